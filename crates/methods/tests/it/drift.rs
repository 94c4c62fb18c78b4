//! Parameters that change while the axis runs, and forces on the load: against what statics and
//! Newton say.

use lostmotion_drive::config::{Change, Drift, Shape};
use lostmotion_drive::{AxisOutput, AxisRunner, AxisSample, AxisSim, Setpoint};
use lostmotion_methods::registry::Registered;
use lostmotion_methods::{AxisConfig, MethodId, build_runner};
use lostmotion_rig::{Motion, circle, mill, run};

fn ramp(factor: f64, over_s: f64) -> Option<Change> {
    Some(Change {
        factor,
        over_s,
        shape: Shape::Ramp,
    })
}

fn drifting(mut config: AxisConfig, drift: Drift) -> AxisConfig {
    config.drift = drift;
    config.check().unwrap();
    config
}

/// Mean motor torque over a stretch of time, s.
fn mean_torque(trace: &[AxisSample], from: f64, to: f64) -> f64 {
    let part = &trace[(from * 4000.0) as usize..(to * 4000.0) as usize];
    part.iter().map(|sample| sample.torque).sum::<f64>() / part.len() as f64
}

fn steady(speed: f64) -> impl Fn(f64) -> (f64, f64, f64) {
    // speeds up over 0.1 s
    move |t: f64| {
        if t < 0.1 {
            (5.0 * speed * t * t, 10.0 * speed * t, 10.0 * speed)
        } else {
            (speed * (t - 0.05), speed, 0.0)
        }
    }
}

#[test]
fn a_change_is_what_its_shape_says() {
    let change = Change {
        factor: 3.0,
        over_s: 8.0,
        shape: Shape::Ramp,
    };
    assert_eq!(
        [0.0, 2.0, 8.0, 100.0].map(|t| change.at(t)),
        [1.0, 1.5, 3.0, 3.0]
    );
    let cycle = Change {
        shape: Shape::Cycle,
        ..change
    };
    for (t, factor) in [
        (0.0, 1.0),
        (2.0, 2.0),
        (4.0, 3.0),
        (6.0, 2.0),
        (8.0, 1.0),
        (12.0, 3.0),
    ] {
        assert!((cycle.at(t) - factor).abs() < 1e-12, "{t}: {}", cycle.at(t));
    }
}

#[test]
fn a_gap_that_grows_loses_as_much_motion_as_it_has_grown() {
    // slow reversals under friction: the load follows the flank, so the lost motion is the gap of
    // that time
    let config = drifting(
        mill(800.0, 0.0),
        Drift {
            gap: ramp(3.0, 4.0),
            ..Drift::default()
        },
    );
    let motion = |t: f64| circle(2.0, 6.0, t);
    let rigid = run(&config.without_gap(), "none", &motion, 6.0);
    let out = run(&config, "none", &motion, 6.0);
    let lost = |from: f64, to: f64| {
        let samples = (from * 4000.0) as usize..(to * 4000.0) as usize;
        let mut apart: Vec<f64> = out.load[samples.clone()]
            .iter()
            .zip(&rigid.load[samples])
            .map(|(a, b)| (a - b).abs())
            .collect();
        apart.sort_by(f64::total_cmp);
        apart[apart.len() / 2]
    };
    // half the gap, 5 um at the start and 15 um at the end; the median leaves the traverses of the
    // gap out
    assert!(
        (lost(4.9, 6.0) / 0.015 - 1.0).abs() < 0.01,
        "{}",
        lost(4.9, 6.0)
    );
    assert!(
        (lost(0.8, 1.2) / 0.0075 - 1.0).abs() < 0.05,
        "{}",
        lost(0.8, 1.2)
    );
}

#[test]
fn friction_and_inertia_ask_for_the_torque_of_their_time() {
    let speed = 100.0;
    let drift = Drift {
        load_coulomb: ramp(2.0, 1.0),
        load_viscous: ramp(3.0, 1.0),
        ..Drift::default()
    };
    let config = drifting(mill(800.0, 900.0), drift);
    let trace = run(&config, "none", &steady(speed), 3.0).trace.unwrap();
    let (load, motor_speed) = (
        config.reflected_load(),
        speed * config.transmission.motor_rad_per_unit(),
    );
    let expected = 2.0 * load.coulomb_nm + (3.0 * load.viscous_nm_s_per_rad + 0.002) * motor_speed;
    let torque = mean_torque(&trace, 2.0, 3.0);
    assert!(
        (torque / expected - 1.0).abs() < 1e-3,
        "{torque} against {expected}"
    );

    let config = drifting(
        mill(0.0, 0.0),
        Drift {
            load_inertia: ramp(0.25, 0.5),
            ..Drift::default()
        },
    );
    let accelerating: Motion = &|t: f64| {
        if t < 1.0 {
            (0.0, 0.0, 0.0)
        } else {
            (100.0 * (t - 1.0) * (t - 1.0), 200.0 * (t - 1.0), 200.0)
        }
    };
    let trace = run(&config, "none", accelerating, 2.0).trace.unwrap();
    let acceleration = 200.0 * config.transmission.motor_rad_per_unit();
    let inertia = config.motor_side_inertia_kgm2() + 0.25 * config.reflected_load().inertia_kgm2;
    let viscous = 0.002 * trace[7000].motor_velocity;
    let torque = mean_torque(&trace, 1.745, 1.755) - viscous;
    assert!(
        (torque / (inertia * acceleration) - 1.0).abs() < 5e-3,
        "{torque} against {}",
        inertia * acceleration
    );
}

#[test]
fn an_axis_goes_on_from_a_kept_state_as_if_nothing_had_been() {
    let cycle = |factor, over_s| {
        Some(Change {
            factor,
            over_s,
            shape: Shape::Cycle,
        })
    };
    let drift = Drift {
        gap: cycle(2.0, 0.7),
        load_inertia: cycle(1.5, 0.9),
        load_coulomb: cycle(0.5, 0.3),
        ..Drift::default()
    };
    let config = drifting(mill(500.0, 50.0), drift);
    let setpoints = lostmotion_rig::setpoints(&|t: f64| circle(3.0, 20.0, t), 1.5);
    let (head, tail) = setpoints.split_at(777);
    let new = || {
        AxisSim::new(
            &config,
            lostmotion_methods::none::Uncompensated::from_axis(&config),
            0.0,
        )
    };
    let (mut whole, mut early) = (new(), new());
    let (mut all, mut rest) = (AxisOutput::new(false), AxisOutput::new(false));
    whole.push(head, &mut all).unwrap();
    let kept = whole.state().clone();
    all.clear();
    whole.push(tail, &mut all).unwrap();
    early.restore(kept);
    early.push(tail, &mut rest).unwrap();
    assert_eq!(all.load, rest.load);
    assert!(whole.plant().events > 20);
}

#[test]
fn a_cutting_force_costs_its_torque_and_winds_the_shaft_up() {
    let config = mill(0.0, 0.0).without_gap();
    let with = |force: Option<f64>| {
        let mut runner = build_runner(&config, MethodId::NONE, 0.0).unwrap();
        let mut out = AxisOutput::new(true);
        runner
            .push(
                &[Setpoint {
                    load_force: force,
                    ..Setpoint::moving(0.0, 0.0, 0.0)
                }; 1500],
                &mut out,
            )
            .unwrap();
        (
            out.load.last().copied().unwrap(),
            mean_torque(&out.trace.unwrap(), 1.2, 1.5),
        )
    };
    let (place, torque) = with(Some(900.0));
    assert!(
        (torque / (900.0 * 0.01 / std::f64::consts::TAU) - 1.0).abs() < 1e-9,
        "{torque}"
    );
    // 900 N on 120 N/um push it 7.5 um back
    assert!((place / -0.0075 - 1.0).abs() < 1e-6, "{place}");
    assert_eq!(with(None), with(Some(0.0)));
}

#[test]
fn what_makes_no_sense_is_refused() {
    let refused = |drift: Drift| {
        AxisConfig {
            drift,
            ..mill(100.0, 0.0)
        }
        .check()
        .unwrap_err()
        .to_string()
    };
    assert_eq!(
        refused(Drift {
            gap: ramp(0.0, 1.0),
            ..Drift::default()
        }),
        "drift.gap.factor is 0; it has to be from 0.01 to 100"
    );
    assert!(
        refused(Drift {
            stiffness: ramp(2.0, 0.0),
            ..Drift::default()
        })
        .starts_with("drift.stiffness.over_s is 0")
    );
    let mut runner = build_runner(&mill(0.0, 0.0), MethodId::NONE, 0.0).unwrap();
    for value in [f64::NAN, f64::INFINITY, -1.1e7] {
        let setpoint = Setpoint {
            load_force: Some(value),
            ..Setpoint::moving(0.0, 0.0, 0.0)
        };
        let error = runner
            .push(&[setpoint], &mut AxisOutput::default())
            .unwrap_err()
            .to_string();
        assert!(
            error.starts_with("setpoint 0: its load_force is "),
            "{error}"
        );
    }
    let text = toml::to_string(&drifting(
        mill(1.0, 1.0),
        Drift {
            gap: ramp(1.5, 60.0),
            ..Drift::default()
        },
    ))
    .unwrap();
    assert!(
        text.contains("[drift.gap]\nfactor = 1.5\nover_s = 60.0\nshape = \"ramp\""),
        "{text}"
    );
    assert_eq!(
        toml::from_str::<AxisConfig>(&text).unwrap().drift.gap,
        ramp(1.5, 60.0)
    );
}
