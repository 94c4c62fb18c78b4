//! What a drive can do besides its cascade: friction feed-forward, filters, delays, anti-windup
//! schemes.

use lostmotion_drive::config::{
    AntiWindup, FrictionFeedforward, Load, LowPass, Notch, TorqueFilter, TorqueFilters,
};
use lostmotion_methods::AxisConfig;
use lostmotion_rig::{Move, circle, errors, max_abs, mill, rms, run};

fn filters(list: &[TorqueFilter]) -> TorqueFilters {
    TorqueFilters::try_from(list.to_vec()).unwrap()
}

#[test]
fn told_friction_takes_the_glitch_out_of_a_reversal() {
    let mut config = mill(600.0, 2000.0).without_gap();
    let load = config.reflected_load();
    let sine = |config: &AxisConfig| {
        max_abs(errors(&run(config, "none", &|t| circle(10.0, 5.0, t), 5.0)).split_off(8000))
    };
    let without = sine(&config);
    config.drive.friction_feedforward = Some(FrictionFeedforward {
        coulomb_nm: load.coulomb_nm,
        viscous_nm_s_per_rad: load.viscous_nm_s_per_rad + config.motor.viscous_nm_s_per_rad,
        smoothing_rad_s: 0.05,
    });
    let with = sine(&config);
    assert!(with < 0.6 * without, "{with} with, {without} without");
}

#[test]
fn told_viscous_friction_carries_a_cruise() {
    // at constant velocity with everything fed forward the integral has nothing left to hold
    let mut config = mill(0.0, 20_000.0).without_gap();
    let load = config.reflected_load();
    config.drive.friction_feedforward = Some(FrictionFeedforward {
        coulomb_nm: 0.0,
        viscous_nm_s_per_rad: load.viscous_nm_s_per_rad + config.motor.viscous_nm_s_per_rad,
        smoothing_rad_s: 0.1,
    });
    let fast = Move {
        distance: 100.0,
        velocity: 200.0,
        acceleration: 1500.0,
        jerk: 30_000.0,
    };
    // of the motor: the load hangs behind it by the shaft's wind-up in any case
    let motor = |config: &AxisConfig| -> Vec<f64> {
        run(config, "none", &|t| fast.at(t), 0.8)
            .trace
            .unwrap()
            .iter()
            .map(|sample| sample.motor_position)
            .collect()
    };
    let (told, untold) = (
        motor(&config),
        motor(&AxisConfig {
            drive: mill(0.0, 0.0).drive,
            ..config.clone()
        }),
    );
    let mut frictionless = mill(0.0, 0.0).without_gap();
    frictionless.motor.viscous_nm_s_per_rad = 0.0;
    let free = motor(&frictionless);
    let lag = |motor: &[f64]| rms(motor.iter().zip(&free).map(|(a, b)| a - b));
    assert!(
        lag(&told) < 0.2 * lag(&untold),
        "{} against {}",
        lag(&told),
        lag(&untold)
    );
}

#[test]
fn a_low_pass_far_above_the_loop_changes_little_and_a_notch_of_no_depth_nothing() {
    let still = mill(0.0, 0.0).without_gap();
    let motion = |t: f64| circle(10.0, 5.0, t);
    let plain = run(&still, "none", &motion, 2.0).load;
    let off = |list: &[TorqueFilter]| {
        let mut config = still.clone();
        config.drive.torque_filter = filters(list);
        let load = run(&config, "none", &motion, 2.0).load;
        max_abs(load.iter().zip(&plain).map(|(a, b)| a - b))
    };
    assert!(
        off(&[TorqueFilter::Notch(Notch {
            frequency_hz: 150.0,
            width_hz: 50.0,
            depth_db: 0.0
        })]) < 1e-12
    );
    let low = off(&[TorqueFilter::LowPass(LowPass {
        frequency_hz: 1500.0,
        damping: 0.7,
    })]);
    assert!(low > 0.0 && low < 2e-3, "{low} mm");
}

#[test]
fn a_notch_quietens_a_resonance_that_the_loop_excites() {
    // hardly damped shaft, velocity loop turned up until the resonance rings; a notch on it allows
    // that gain
    let mut config = mill(0.0, 0.0).without_gap();
    if let Load::Slide(slide) = &mut config.load {
        (slide.stiffness_n_per_um, slide.damping_n_s_per_mm) = (2000.0, 4.0);
    }
    config.drive.velocity_gain_a_s_per_rad *= 2.0;
    config.drive.command_delay_periods = 3;
    let load = config.reflected_load();
    let joint = 1.0 / config.motor_side_inertia_kgm2() + 1.0 / load.inertia_kgm2;
    let resonance_hz = (load.stiffness_nm_per_rad * joint).sqrt() / std::f64::consts::TAU;
    let tail = |config: &AxisConfig| {
        max_abs(
            errors(&run(
                config,
                "none",
                &|t| (if t > 0.01 { 0.01 } else { 0.0 }, 0.0, 0.0),
                1.0,
            ))
            .split_off(3000),
        )
    };
    let plain = tail(&config);
    config.drive.torque_filter = filters(&[TorqueFilter::Notch(Notch {
        frequency_hz: resonance_hz,
        width_hz: 0.8 * resonance_hz,
        depth_db: 30.0,
    })]);
    let notched = tail(&config);
    assert!(
        plain > 1e-3 && notched < 1e-4,
        "{plain} without, {notched} with, at {resonance_hz} Hz"
    );
}

#[test]
fn a_delayed_command_comes_that_much_later() {
    // five current periods are one servo period: the whole loop acts as one that is one tick late
    let mut config = AxisConfig::paper().without_gap();
    config.drive.position_gain_per_s = 0.0;
    config.drive.velocity_feedforward = 1.0;
    let push = |t: f64| (if t > 0.01 { 0.01 } else { 0.0 }, 0.0, 0.0);
    let first = |delay: u32| {
        let mut late = config.clone();
        late.drive.command_delay_periods = delay;
        let trace = run(&late, "none", &push, 0.05).trace.unwrap();
        let at = trace
            .iter()
            .position(|sample| sample.torque != 0.0)
            .unwrap();
        (at, trace[at].torque)
    };
    let [(at, torque), (one, same), (two, again)] = [first(0), first(5), first(10)];
    assert_eq!((one, two), (at + 1, at + 2));
    assert_eq!(
        (torque.to_bits(), torque.to_bits()),
        (same.to_bits(), again.to_bits())
    );
    // within a period: the later, the less of it has acted at the next tick
    let part: Vec<f64> = (0..5).map(|delay| first(delay).1.abs()).collect();
    assert!(part.windows(2).all(|pair| pair[1] < pair[0]), "{part:?}");
}

#[test]
fn anti_windup_keeps_a_saturated_axis_from_overshooting() {
    let fast = Move {
        distance: 20.0,
        velocity: 40.0,
        acceleration: 800.0,
        jerk: 40_000.0,
    };
    let overshoot = |scheme: AntiWindup| {
        let mut config = AxisConfig::paper().without_gap();
        config.drive.current_limit_a = 2.0;
        config.drive.anti_windup = scheme;
        let out = run(&config, "none", &|t| fast.at(t), 6.0);
        assert!(
            scheme == AntiWindup::None || max_abs(errors(&out).split_off(23_000)) < 1e-6,
            "{scheme:?}"
        );
        out.load.iter().fold(0.0_f64, |most, p| most.max(p - 20.0))
    };
    let [back, conditional, none] = [
        AntiWindup::BackCalculation,
        AntiWindup::Conditional,
        AntiWindup::None,
    ]
    .map(overshoot);
    assert!(
        back < 0.5 * none && conditional < 0.8 * none,
        "{back} {conditional} {none}"
    );
}

#[test]
fn the_file_format_of_the_options() {
    let mut config = mill(0.0, 0.0);
    let plain = toml::to_string(&config.drive).unwrap();
    for key in [
        "command_delay",
        "friction_feedforward",
        "torque_filter",
        "anti_windup",
        "least_margins",
    ] {
        assert!(
            !plain.contains(key),
            "{key} is left out where it is the default: {plain}"
        );
    }
    let text = format!(
        "{plain}\ncommand_delay_periods = 3\nanti_windup = \"conditional\"\nleast_margins = {{ phase_deg = 30.0 }}\n\
         friction_feedforward = {{ coulomb_nm = 0.4 }}\n\
         torque_filter = [{{ notch = {{ frequency_hz = 180.0, width_hz = 60.0, depth_db = 30.0 }} }}, {{ low-pass = {{ frequency_hz = 800.0 }} }}]\n"
    );
    config.drive = toml::from_str(&text).unwrap();
    assert_eq!(config.drive.torque_filter.iter().count(), 2);
    assert_eq!(config.check(), Ok(()));
    assert_eq!(
        toml::from_str::<lostmotion_drive::config::Drive>(&toml::to_string(&config.drive).unwrap())
            .unwrap(),
        config.drive
    );
    let refused = |change: fn(&mut lostmotion_drive::config::Drive), key: &str| {
        let mut bad = config.clone();
        change(&mut bad.drive);
        assert!(
            bad.check().unwrap_err().to_string().contains(key),
            "{:?}",
            bad.check()
        );
    };
    refused(
        |drive| drive.command_delay_periods = 11,
        "drive.command_delay_periods",
    );
    refused(
        |drive| drive.least_margins.phase_deg = f64::NAN,
        "drive.least_margins.phase_deg",
    );
    refused(
        |drive| {
            drive.torque_filter = filters(&[TorqueFilter::LowPass(LowPass {
                frequency_hz: 2000.0,
                damping: 0.7,
            })]);
        },
        "torque_filter[0]",
    );
    let five = "torque_filter = [{ low-pass = { frequency_hz = 1.0 } }, { low-pass = { frequency_hz = 1.0 } }, \
                { low-pass = { frequency_hz = 1.0 } }, { low-pass = { frequency_hz = 1.0 } }, { low-pass = { frequency_hz = 1.0 } }]";
    assert!(
        toml::from_str::<lostmotion_drive::config::Drive>(&format!("{plain}\n{five}"))
            .unwrap_err()
            .to_string()
            .contains("at most 4")
    );
}
