//! Options of an axis as its description has them: a robot's joint, a worn screw, a scale; what is
//! refused.

use lostmotion_base::math;
use lostmotion_drive::config::{
    Flanks, FrictionLaw, Frictions, Gravity, Harmonic, Lugre, Ripple, Scale, ScaleError, Stribeck,
    Wear,
};
use lostmotion_drive::plant::LoadScale;
use lostmotion_drive::{AxisOutput, Setpoint};
use lostmotion_methods::{AxisConfig, MethodId, build_runner};
use lostmotion_rig::{Motion, circle, mill, run};
use std::f64::consts::TAU;

fn refused(change: impl FnOnce(&mut AxisConfig)) -> String {
    let mut config = mill(100.0, 0.0);
    change(&mut config);
    config.check().unwrap_err().to_string()
}

/// The paper's axis as the joint of a robot: its load turns an arm through a gear of 5.
fn joint() -> AxisConfig {
    let text = toml::to_string(&AxisConfig::paper())
        .unwrap()
        .replace("gear = 1.0", "gear = 5.0");
    let text = format!("{text}\n[gravity]\ntorque_nm = 20.0\nhangs_at_deg = -90.0\n");
    let config: AxisConfig = toml::from_str(&text).unwrap();
    config.check().unwrap();
    config
}

#[test]
fn a_joint_carries_its_arm_with_the_torque_of_its_angle() {
    for angle in [-2.0, -0.3, 0.0, 0.7, 2.5] {
        let mut runner = build_runner(&joint(), MethodId::NONE, angle).unwrap();
        let mut out = AxisOutput::new(true);
        runner
            .push(&[Setpoint::moving(angle, 0.0, 0.0); 1000], &mut out)
            .unwrap();
        let load = *out.load.last().unwrap();
        let expected = 20.0 * math::cos(load) / 5.0;
        let torque = out.trace.unwrap().last().unwrap().torque;
        assert!(
            (torque - expected).abs() < 1e-6,
            "{torque} against {expected} at {angle}"
        );
    }
}

#[test]
fn a_moving_arm_needs_gravity_and_inertia() {
    let config = joint().without_gap();
    let motion: Motion = &|t: f64| circle(0.8, 3.0, t);
    let trace = run(&config, "none", motion, 4.0).trace.unwrap();
    let inertia = config.motor_side_inertia_kgm2() + config.reflected_load().inertia_kgm2;
    let error = trace[8000..].windows(3).map(|w| {
        let acceleration = (w[2].motor_velocity - w[0].motor_velocity) / 5e-4;
        let expected = inertia * acceleration
            + 0.01 * w[1].motor_velocity
            + 4.0 * math::cos(w[1].load_position / 5.0);
        w[1].torque - expected
    });
    assert!(lostmotion_rig::max_abs(error) < 5e-3);
}

#[test]
fn motion_is_lost_where_the_screw_is_worn_and_on_the_side_of_the_middle() {
    let mut config = mill(800.0, 0.0);
    config.flanks = Flanks {
        middle: -1.0,
        wear: Some(Wear {
            factor: 3.0,
            at_units: 0.0,
            width_units: 20.0,
        }),
    };
    let lost = |place: f64| {
        let slow = |t: f64| {
            let (p, v, a) = circle(0.5, 3.0, t);
            (place + p, v, a)
        };
        let (out, rigid) = (
            run(&config, "none", &slow, 4.5),
            run(&config.without_gap(), "none", &slow, 4.5),
        );
        let apart = |from: f64, to: f64| {
            let samples = (from * 4000.0) as usize..(to * 4000.0) as usize;
            let mut apart: Vec<f64> = out.load[samples.clone()]
                .iter()
                .zip(&rigid.load[samples])
                .map(|(a, b)| a - b)
                .collect();
            apart.sort_by(f64::total_cmp);
            apart[apart.len() / 2]
        };
        // forwards from 2.1 to 3.1 s, back from 3.2 to 4.2 s
        (apart(2.3, 3.0), apart(3.4, 4.1))
    };
    for (place, gap) in [(0.0, 0.030), (200.0, 0.010)] {
        let (forwards, back) = lost(place);
        assert!(
            forwards.abs() < 0.02 * gap,
            "pushed forwards it is where it should be: {forwards}"
        );
        assert!(
            (back / gap - 1.0).abs() < 0.02,
            "pulled back it lags the whole gap: {back} of {gap}"
        );
    }
}

#[test]
fn a_scale_counts_from_its_index_and_errs_as_told() {
    let mut config = mill(0.0, 0.0);
    let unit = TAU / 10.0;
    if let lostmotion_drive::config::Load::Slide(slide) = &mut config.load {
        slide.scale_um = 5.0;
    }
    let read = |config: &AxisConfig, at: f64| LoadScale::new(config).read(at * unit) / unit;
    let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} against {b}");
    close(read(&config, 0.0123), 0.010);
    config.scale.index_units = 7.003;
    close(read(&config, 0.0123), 0.013);
    close(read(&config, 7.003), 7.003);
    if let lostmotion_drive::config::Load::Slide(slide) = &mut config.load {
        slide.scale_um = 0.0;
    }
    let errors = vec![ScaleError {
        amplitude_units: 0.002,
        period_units: 20.0,
        phase_deg: 90.0,
    }];
    config.scale = Scale {
        index_units: 100.0,
        slope_ppm: 20.0,
        errors,
    };
    config.check().unwrap();
    close(
        read(&config, 110.0),
        110.0 + 20e-6 * 10.0 + 0.002 * math::cos(TAU * 110.0 / 20.0),
    );
}

#[test]
fn what_makes_no_sense_is_refused_with_key_and_value() {
    let stribeck = |static_factor, speed| {
        FrictionLaw::Stribeck(Stribeck {
            static_factor,
            speed_units_s: speed,
        })
    };
    let lugre = |presliding| {
        FrictionLaw::Lugre(Lugre {
            static_factor: 1.2,
            speed_units_s: 1.0,
            presliding_units: presliding,
            damping_s: 0.0,
        })
    };
    let load = |law| Frictions {
        load: law,
        ..Frictions::default()
    };
    let message = refused(|c| c.friction = load(stribeck(0.5, 1.0)));
    assert_eq!(
        message,
        "friction.load.stribeck.static_factor is 0.5; it has to be from 1 to 10"
    );
    assert!(
        refused(|c| c.friction.motor = stribeck(1.5, 0.0))
            .starts_with("friction.motor.stribeck.speed_units_s is 0;")
    );
    assert!(
        refused(|c| c.friction = load(stribeck(1.5, 1e-9)))
            .starts_with("friction.load: fall of friction over inertia")
    );
    assert!(
        refused(|c| c.friction = load(lugre(0.0)))
            .starts_with("friction.load.lugre.presliding_units is 0;")
    );
    assert!(
        refused(|c| c.friction = load(lugre(1e-9)))
            .starts_with("friction.load: motor's no-load speed over presliding")
    );
    assert!(refused(|c| c.flanks.middle = 1.5).starts_with("flanks.middle is 1.5;"));
    let wear = |factor, width| {
        Some(Wear {
            factor,
            at_units: 0.0,
            width_units: width,
        })
    };
    assert!(refused(|c| c.flanks.wear = wear(0.0, 1.0)).starts_with("flanks.wear.factor is 0;"));
    assert!(
        refused(|c| c.flanks.wear = wear(100.0, 1.0))
            .starts_with("flanks.wear.width_units: slope of the flanks is ")
    );
    let harmonic = Harmonic {
        amplitude: 0.3,
        per_turn: 6,
        phase_deg: 0.0,
    };
    assert!(
        refused(|c| c.ripple.torque = vec![harmonic])
            .starts_with("ripple.torque[0].amplitude is 0.3;")
    );
    assert!(
        refused(|c| c.ripple.cogging = vec![harmonic; 5])
            .starts_with("ripple.cogging: number of harmonics is 5;")
    );
    assert!(
        refused(|c| c.gravity = Some(Gravity {
            torque_nm: 1.0,
            hangs_at_deg: 0.0
        }))
        .contains("needs a rotary transmission")
    );
    assert!(refused(|c| c.scale.slope_ppm = 1e4).starts_with("scale.slope_ppm is 10000;"));
    let steep = ScaleError {
        amplitude_units: 1.0,
        period_units: 2.0,
        phase_deg: 0.0,
    };
    assert!(
        refused(|c| c.scale.errors = vec![steep])
            .starts_with("scale.errors[0].amplitude_units is 1;")
    );
}

#[test]
fn every_option_is_kept_through_text_and_left_out_when_plain() {
    let plain = toml::to_string(&mill(100.0, 3.0)).unwrap();
    for key in [
        "friction", "flanks", "ripple", "gravity", "[scale]", "drift",
    ] {
        assert!(!plain.contains(key), "{key}: {plain}");
    }
    let text = format!(
        "{plain}
[friction.motor.lugre]
static_factor = 1.2
speed_units_s = 0.5
presliding_units = 0.01
damping_s = 0.001
[friction.load.stribeck]
static_factor = 1.5
speed_units_s = 2.0
[flanks]
middle = -1.0
wear = {{ factor = 1.8, at_units = 250.0, width_units = 80.0 }}
[ripple]
cogging = [{{ amplitude = 0.05, per_turn = 60 }}]
torque = [{{ amplitude = 0.01, per_turn = 24, phase_deg = 30.0 }}]
[scale]
index_units = 12.5
errors = [{{ amplitude_units = 0.0005, period_units = 0.02 }}]
"
    );
    let config: AxisConfig = toml::from_str(&text).unwrap();
    config.check().unwrap();
    assert_eq!(
        config.ripple,
        Ripple {
            cogging: vec![Harmonic {
                amplitude: 0.05,
                per_turn: 60,
                phase_deg: 0.0
            }],
            torque: vec![Harmonic {
                amplitude: 0.01,
                per_turn: 24,
                phase_deg: 30.0
            }],
        }
    );
    assert_eq!(
        config.flanks,
        Flanks {
            middle: -1.0,
            wear: Some(Wear {
                factor: 1.8,
                at_units: 250.0,
                width_units: 80.0
            })
        }
    );
    assert_eq!(
        toml::from_str::<AxisConfig>(&toml::to_string(&config).unwrap()).unwrap(),
        config
    );
}
