//! A batch gives what single runs give, to the last bit.

use lostmotion_drive::config::{
    Change, ContactLaw, FrictionLaw, Harmonic, Load, LowPass, Lugre, Shape, Stribeck, TorqueFilter,
    TorqueFilters,
};
use lostmotion_drive::{AxisBatch, AxisError, AxisOutput, AxisStart, Setpoint};
use lostmotion_methods::AxisConfig;
use lostmotion_methods::{METHODS, MethodId, build_runner, build_runner_from};
use lostmotion_rig::{Move, circle, mill, mill_x, setpoints, there_and_back};
use proptest::prelude::*;

/// An output with everything that can be kept, or with nothing but load and reference.
fn output(traced: bool) -> AxisOutput {
    let mut out = AxisOutput::new(traced);
    out.motor = traced.then(Vec::new);
    out
}

fn single(config: &AxisConfig, method: &str, points: &[Setpoint], traced: bool) -> AxisOutput {
    let mut out = output(traced);
    build_runner(config, method.parse().unwrap(), points[0].position)
        .unwrap()
        .push(points, &mut out)
        .unwrap();
    out
}

/// The same axes in a batch, in chunks; `traced` says which of them keep a trace.
fn batched(
    axes: &[(AxisConfig, &str)],
    points: &[Vec<Setpoint>],
    chunk: usize,
    traced: impl Fn(usize) -> bool,
) -> Vec<AxisOutput> {
    let runners = axes
        .iter()
        .zip(points)
        .map(|((config, method), points)| {
            build_runner(config, method.parse().unwrap(), points[0].position).unwrap()
        })
        .collect();
    let mut batch = AxisBatch::new(runners, 2);
    let mut outputs: Vec<AxisOutput> = (0..axes.len()).map(|lane| output(traced(lane))).collect();
    let longest = points.iter().map(Vec::len).max().unwrap();
    for start in (0..longest).step_by(chunk) {
        let parts: Vec<&[Setpoint]> = points
            .iter()
            .map(|list| &list[start.min(list.len())..(start + chunk).min(list.len())])
            .collect();
        assert!(batch.push(&parts, &mut outputs).iter().all(Result::is_ok));
    }
    outputs
}

/// Lanes with a trace, lanes without one, and both among each other.
fn assert_same(axes: &[(AxisConfig, &str)], points: &[Vec<Setpoint>], chunk: usize) {
    same(axes, points, chunk, |_| true);
    same(axes, points, chunk, |_| false);
    same(axes, points, chunk, |lane| lane % 3 == 1);
}

fn same(
    axes: &[(AxisConfig, &str)],
    points: &[Vec<Setpoint>],
    chunk: usize,
    traced: impl Fn(usize) -> bool,
) {
    let outputs = batched(axes, points, chunk, &traced);
    for (lane, (((config, method), points), batched)) in
        axes.iter().zip(points).zip(outputs).enumerate()
    {
        let alone = single(config, method, points, traced(lane));
        assert!(
            alone
                .load
                .iter()
                .zip(&batched.load)
                .all(|(a, b)| a.to_bits() == b.to_bits()),
            "{method}"
        );
        assert_eq!(alone.reference, batched.reference);
        assert_eq!(
            (alone.saturated_samples, alone.peak_current_a.to_bits()),
            (batched.saturated_samples, batched.peak_current_a.to_bits())
        );
        assert_eq!(alone.monitored.len(), points.len());
        assert_eq!(alone.monitored, batched.monitored, "{method}");
        let bits = |out: &AxisOutput| -> Vec<[u64; 16]> {
            let all = out.trace.iter().flatten();
            all.map(|s| {
                [
                    s.reference.position,
                    s.reference.velocity,
                    s.reference.acceleration,
                    s.motor_position,
                    s.motor_velocity,
                    s.load_position,
                    s.load_velocity,
                    s.current,
                    s.torque,
                    s.shaft_torque,
                    s.engagement.sign().into(),
                    s.gap_angle_estimate,
                    s.inertia_estimate,
                    s.engagement_estimate.sign().into(),
                    s.stiffness_estimate,
                    s.damping_estimate,
                ]
                .map(f64::to_bits)
            })
            .collect()
        };
        assert_eq!(bits(&alone), bits(&batched), "{method}");
        // The motor alone is what the whole trace says of it.
        let of_motor = |out: &AxisOutput| -> Vec<[u64; 4]> {
            let all = out.motor.iter().flatten();
            all.map(|s| [s.position, s.current, s.torque, s.engagement.sign().into()])
                .map(|values| values.map(f64::to_bits))
                .collect()
        };
        let of_trace: Vec<[u64; 4]> = bits(&alone)
            .iter()
            .map(|all| [all[3], all[7], all[8], all[10]])
            .collect();
        assert_eq!(of_motor(&alone), of_trace, "{method}");
        assert_eq!(of_motor(&batched), of_trace, "{method}");
    }
}

#[test]
fn every_method_on_a_circle() {
    let points = setpoints(&|t| circle(10.0, 5.0, t), 0.7);
    let axes: Vec<(AxisConfig, &str)> = METHODS
        .iter()
        .map(|method| (mill(200.0, 300.0), method.info.name))
        .collect();
    assert_same(&axes, &vec![points; axes.len()], 100);
}

#[test]
fn gaps_gains_contact_laws_and_frictions() {
    let stroke = Move {
        distance: 5.0,
        velocity: 60.0,
        acceleration: 1500.0,
        jerk: 40_000.0,
    };
    let points = setpoints(&|t| there_and_back(stroke, 0.1, t), 0.6);
    let mut axes = Vec::new();
    for (index, contact) in [ContactLaw::Linear, ContactLaw::Clamped, ContactLaw::Bounded]
        .into_iter()
        .cycle()
        .take(19)
        .enumerate()
    {
        let mut config = if index % 2 == 0 {
            mill_x(0.02 * index as f64, 4.0 * index as f64, Some(1 << 20))
        } else {
            mill(20.0 * index as f64, 0.0)
        };
        config.contact = contact;
        config.drive.position_gain_per_s += index as f64;
        config.motor.coulomb_nm = 0.05 * (index % 3) as f64;
        config.drive.voltage_delay_periods = u32::from(index % 4 != 0);
        config.drive.command_delay_periods = if index == 7 { 3 } else { 0 };
        config.drive.current_limit_a = if index == 5 {
            12.0
        } else {
            config.drive.current_limit_a
        };
        config.drive.bus_voltage_v = if index == 8 { 60.0 } else { 560.0 };
        axes.push((config, "none"));
    }
    assert_same(&axes, &vec![points; axes.len()], 57);
}

/// The axes that `lookup` and `adaptive` compute alongside, each its own, some with voltages that
/// are cut, some with drives that are not plain.
#[test]
fn models_of_compensators_side_by_side() {
    let stroke = Move {
        distance: 8.0,
        velocity: 80.0,
        acceleration: 2000.0,
        jerk: 60_000.0,
    };
    let points = setpoints(&|t| there_and_back(stroke, 0.1, t % 0.8), 1.6);
    let mut axes = Vec::new();
    for index in 0..23 {
        let mut config = mill_x(
            0.02 * f64::from(index % 6),
            5.0 + 2.0 * f64::from(index),
            (index % 3 != 0).then_some(1 << 20),
        );
        config.motor.coulomb_nm = 0.1 * f64::from(index % 2);
        config.drive.position_gain_per_s += f64::from(index);
        config.drive.voltage_delay_periods = u32::from(index % 4 != 0);
        config.drive.command_delay_periods = if index == 7 { 3 } else { 0 };
        config.drive.current_limit_a = if index == 5 {
            9.0
        } else {
            config.drive.current_limit_a
        };
        config.drive.bus_voltage_v = if index % 8 == 3 { 90.0 } else { 560.0 };
        axes.push((
            config,
            ["lookup", "adaptive", "none", "lookup"][index as usize % 4],
        ));
    }
    assert_same(&axes, &vec![points; axes.len()], 57);
}

/// What the kernel has no vectors for, among axes that it has.
#[test]
fn axes_that_step_by_themselves_among_others() {
    let change = |factor| {
        Some(Change {
            factor,
            over_s: 0.3,
            shape: Shape::Cycle,
        })
    };
    let options: [fn(&mut AxisConfig, Option<Change>); 8] = [
        |_, _| {},
        |axis, _| {
            axis.friction.load = FrictionLaw::Stribeck(Stribeck {
                static_factor: 1.5,
                speed_units_s: 8.0,
            });
        },
        |axis, _| {
            axis.friction.load = FrictionLaw::Lugre(Lugre {
                static_factor: 1.3,
                speed_units_s: 2.0,
                presliding_units: 1e-3,
                damping_s: 0.01,
            });
        },
        |axis, _| {
            axis.ripple.cogging = vec![Harmonic {
                amplitude: 0.1,
                per_turn: 24,
                phase_deg: 10.0,
            }];
        },
        |axis, change| axis.drift.gap = change,
        |axis, change| axis.drift.load_inertia = change,
        |axis, _| axis.drive.command_delay_periods = 4,
        |axis, _| {
            axis.drive.torque_filter =
                TorqueFilters::try_from(vec![TorqueFilter::LowPass(LowPass {
                    frequency_hz: 900.0,
                    damping: 0.7,
                })])
                .unwrap();
        },
    ];
    let points = setpoints(&|t| circle(3.0, 8.0, t), 0.7);
    let axis = |option: &fn(&mut AxisConfig, Option<Change>)| {
        let mut config = mill(200.0, 300.0);
        config.motor.coulomb_nm = 0.1;
        option(&mut config, change(1.5));
        config
    };
    let axes: Vec<(AxisConfig, &str)> = options
        .iter()
        .flat_map(|option| ["none", "lookup"].map(|method| (axis(option), method)))
        .collect();
    assert_same(&axes, &vec![points; axes.len()], 100);
}

#[test]
fn axes_of_different_motions_and_lengths() {
    let motions: Vec<Vec<Setpoint>> = (1..12)
        .map(|n| {
            setpoints(
                &|t| circle(0.5 * f64::from(n), 3.0 + f64::from(n), t),
                0.1 + 0.05 * f64::from(n),
            )
        })
        .collect();
    let axes: Vec<(AxisConfig, &str)> = motions
        .iter()
        .map(|_| (AxisConfig::paper(), "load-feedback"))
        .collect();
    assert_same(&axes, &motions, 64);
}

#[test]
fn a_faulty_setpoint_stops_its_axis_alone() {
    let good = setpoints(&|t| circle(10.0, 5.0, t), 0.1);
    let mut bad = good.clone();
    bad[40].position = f64::NAN;
    let runners = (0..3)
        .map(|_| build_runner(&AxisConfig::paper(), MethodId::NONE, 0.0).unwrap())
        .collect();
    let mut outputs = vec![AxisOutput::new(false); 3];
    let results = AxisBatch::new(runners, 1).push(&[&good, &bad, &good], &mut outputs);
    assert!(
        matches!(
            results[..],
            [
                Ok(()),
                Err(AxisError::SetpointNotFinite { tick: 40, .. }),
                Ok(())
            ]
        ),
        "{results:?}"
    );
    assert_eq!(
        outputs.iter().map(|out| out.load.len()).collect::<Vec<_>>(),
        [400, 160, 400]
    );
    assert_eq!(outputs[0], outputs[2]);
    assert_eq!(outputs[1].load[..], outputs[0].load[..160]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn random_axes(seeds in proptest::collection::vec((0.0..0.3_f64, 0.0..200.0_f64, 0.2..3.0_f64, 0..3_u8, 0.0..2.0_f64), 1..12), speed in 1.0..40.0_f64) {
        let points = setpoints(&|t| circle(3.0, speed, t), 0.15);
        let axes: Vec<(AxisConfig, &str)> = seeds
            .iter()
            .map(|(friction, gap, stiffness, law, motor)| {
                let mut config = mill_x(*friction, *gap, None);
                config.contact = [ContactLaw::Linear, ContactLaw::Clamped, ContactLaw::Bounded][usize::from(*law)];
                config.motor.coulomb_nm = *motor;
                if let Load::Slide(slide) = &mut config.load {
                    slide.stiffness_n_per_um *= stiffness;
                }
                (config, "none")
            })
            .collect();
        assert_same(&axes, &vec![points; axes.len()], 1000);
    }
}

/// Axes that begin moving, wound up, or with their drives off: together as alone, to the bit.
#[test]
fn axes_that_begin_otherwise_do_so_in_a_batch_too() {
    let points = vec![Setpoint::moving(0.0, 0.0, 0.0); 120];
    let starts: Vec<AxisStart> = (0..9)
        .map(|n| AxisStart {
            motor_velocity: 3.0 * f64::from(n) - 10.0,
            load_velocity: 8.0 - 2.0 * f64::from(n),
            wind_up: (n % 3 == 1).then_some(1e-3 * f64::from(n - 4)),
            drive_off: n % 2 == 0,
            ..AxisStart::at(0.0)
        })
        .collect();
    let config = mill(200.0, 300.0);
    let axis = |start: &AxisStart| build_runner_from(&config, MethodId::NONE, start).unwrap();
    for traced in [true, false] {
        let mut outputs = vec![AxisOutput::new(traced); starts.len()];
        let mut batch = AxisBatch::new(starts.iter().map(axis).collect(), 2);
        let lists = vec![points.as_slice(); starts.len()];
        assert!(batch.push(&lists, &mut outputs).iter().all(Result::is_ok));
        for (start, batched) in starts.iter().zip(&outputs) {
            let mut alone = AxisOutput::new(traced);
            axis(start).push(&points, &mut alone).unwrap();
            let bits = |out: &AxisOutput| -> Vec<u64> {
                out.load.iter().map(|load| load.to_bits()).collect()
            };
            assert_eq!(bits(&alone), bits(batched), "{start:?}");
            assert_eq!(
                alone.peak_current_a.to_bits(),
                batched.peak_current_a.to_bits()
            );
            assert!(!start.drive_off || batched.peak_current_a == 0.0);
            assert!(batched.load.iter().any(|load| *load != batched.load[0]));
        }
    }
}

#[test]
fn starts_that_no_axis_has_are_refused() {
    let config = mill(200.0, 300.0);
    let refused = |start: AxisStart| {
        let built = build_runner_from(&config, MethodId::NONE, &start);
        built.err().map(|error| error.to_string()).unwrap()
    };
    let at = AxisStart::at(0.0);
    for (start, what) in [
        (AxisStart::at(f64::NAN), "the start position is NaN"),
        (
            AxisStart {
                motor_velocity: f64::INFINITY,
                ..at
            },
            "the motor velocity at the start is inf; it has to be from -",
        ),
        (
            AxisStart {
                load_velocity: -1e12,
                ..at
            },
            "the load velocity at the start is -1000000000000; it has to be from -",
        ),
        (
            AxisStart {
                wind_up: Some(f64::NAN),
                ..at
            },
            "the wind-up at the start is NaN; it has to be from -",
        ),
    ] {
        let said = refused(start);
        assert!(said.starts_with(what), "{said}");
    }
}
