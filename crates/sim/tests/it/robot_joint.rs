//! The same axis as a robot's joint: the arm's weight, not the reversal, says when the flank
//! changes.
use lostmotion_analysis::analyse;
use lostmotion_drive::config::Load;
use lostmotion_drive::{AxisOutput, AxisSample, Engagement, Setpoint};
use lostmotion_methods::AxisConfig;
use lostmotion_methods::{MethodId, build_runner};
use lostmotion_sim::machine::axis_preset;

/// Ends of the sweep, deg, and its speed, deg/s.
const END: f64 = 30.0;
const SPEED: f64 = 4.0;
/// Time to speed up and slow down, s.
const RISE: f64 = 0.5;

fn joint() -> AxisConfig {
    axis_preset("robot-joint").unwrap()
}

/// From -30 deg through the hanging position to 30 deg, or back.
fn sweep(direction: f64) -> Vec<AxisSample> {
    let cruise = 2.0 * END / SPEED - RISE;
    let at = |t: f64| -> Setpoint {
        let (start, speed, rate) = (
            -direction * END,
            direction * SPEED,
            direction * SPEED / RISE,
        );
        match t {
            t if t < RISE => Setpoint::moving(start + 0.5 * rate * t * t, rate * t, rate),
            t if t < RISE + cruise => {
                Setpoint::moving(start + speed * (t - 0.5 * RISE), speed, 0.0)
            }
            t => {
                let left = (2.0 * RISE + cruise - t).max(0.0);
                Setpoint::moving(
                    -start - 0.5 * rate * left * left,
                    rate * left,
                    if left > 0.0 { -rate } else { 0.0 },
                )
            }
        }
    };
    let mut runner = build_runner(&joint(), MethodId::NONE, -direction * END).unwrap();
    let mut out = AxisOutput::new(true);
    let points: Vec<Setpoint> = (0..((cruise + 2.0 * RISE) * 1e3) as u32)
        .map(|n| at(f64::from(n) * 1e-3))
        .collect();
    runner.push(&points, &mut out).unwrap();
    out.trace.unwrap()
}

/// Angles of the joint, deg, at which the first flank is left and the other one is met.
fn change(samples: &[AxisSample], to: Engagement) -> [f64; 2] {
    let ratio = joint().transmission.load_per_motor_rad();
    let first = |engagement| {
        samples
            .iter()
            .find(|sample| sample.engagement == engagement)
            .unwrap()
            .load_position
    };
    [first(Engagement::Gap), first(to)].map(|angle: f64| (angle * ratio).to_degrees())
}

#[test]
fn the_flank_changes_where_weight_and_friction_balance() {
    let config = joint();
    let Load::Table(arm) = config.load else {
        unreachable!("the preset is a table")
    };
    // torque_nm sin(q) + friction = 0 on the way up; mirrored on the way back
    let friction = arm.coulomb_nm + arm.viscous_nm_s_per_rad * SPEED.to_radians();
    let expected =
        -lostmotion_base::math::asin(friction / config.gravity.unwrap().torque_nm).to_degrees();
    let [left, met] = change(&sweep(1.0), Engagement::Positive);
    assert!(
        (left - expected).abs() < 0.1,
        "{left} deg against {expected} deg"
    );
    // the arm falls through the gap, slowly at first: in docs/book/src/trust/robot_joint.md, half a degree
    assert!(
        (0.2..0.8).contains(&(met - left)),
        "{met} deg after {left} deg"
    );
    let [back, _] = change(&sweep(-1.0), Engagement::Negative);
    assert!(
        (back + expected).abs() < 0.1,
        "{back} deg against {} deg",
        -expected
    );
}

#[test]
fn it_hangs_on_the_flank_that_carries_it_with_its_wind_up() {
    let config = joint();
    let Load::Table(arm) = config.load else {
        unreachable!("the preset is a table")
    };
    let first = sweep(-1.0)[0];
    // friction holds a part of the weight; at rest the drive carries all of it
    let weight = config.gravity.unwrap().torque_nm * lostmotion_base::math::sin(END.to_radians());
    let expected_mdeg = 0.5 * arm.gap_mdeg + (weight / arm.stiffness_nm_per_rad).to_degrees() * 1e3;
    let found_mdeg = (first.motor_position - first.load_position).to_degrees()
        * config.transmission.load_per_motor_rad()
        * 1e3;
    assert_eq!(first.engagement, Engagement::Positive);
    assert!(
        (found_mdeg / expected_mdeg - 1.0).abs() < 0.02,
        "{found_mdeg} mdeg against {expected_mdeg} mdeg"
    );
}

#[test]
fn its_loops_are_stable_on_the_flank_and_in_the_gap() {
    let config = joint();
    assert_eq!(analyse(&config).fault(&config), None);
}

/// What the gap adds to the arm's position on three swings of 30 deg to either side, mdeg RMS and
/// largest, after the first: with the gap minus without it.
fn added(method: &str, rate: f64) -> [f64; 2] {
    let period = std::f64::consts::TAU / rate;
    let at = |t: f64| {
        let (sin, cos) = lostmotion_base::math::sin_cos(rate * t);
        Setpoint::moving(-END * cos, END * rate * sin, END * rate * rate * cos)
    };
    let points: Vec<Setpoint> = (0..(3.0 * period * 1e3) as u32)
        .map(|n| at(f64::from(n) * 1e-3))
        .collect();
    let [with, without] =
        [(joint(), method), (joint().without_gap(), "none")].map(|(config, method)| {
            let mut out = AxisOutput::new(false);
            build_runner(&config, method.parse().unwrap(), -END)
                .unwrap()
                .push(&points, &mut out)
                .unwrap();
            out.load
        });
    let off: Vec<f64> = with
        .iter()
        .zip(without)
        .map(|(a, b)| 1e3 * (a - b))
        .skip((period * 4e3) as usize)
        .collect();
    [
        (off.iter().map(|x| x * x).sum::<f64>() / off.len() as f64).sqrt(),
        off.iter().fold(0.0, |most, x| x.abs().max(most)),
    ]
}

#[test]
fn lookup_told_of_the_weight_crosses_where_the_flank_changes() {
    let (none, lookup) = (added("none", 2.0), added("lookup", 2.0));
    // uncompensated the arm is off by half a gap
    assert!((none[0] / 8.35 - 1.0).abs() < 0.02, "{none:?}");
    assert!(
        lookup[0] < 0.02 * none[0] && lookup[1] < 0.1 * none[1],
        "{lookup:?} of {none:?}"
    );
}
