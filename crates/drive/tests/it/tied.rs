//! Two axes tied by a spring, against closed forms.

use lostmotion_drive::config::Load;
use lostmotion_drive::{AxisOutput, Setpoint, Tie, TiedAxes};
use lostmotion_methods::{AxisConfig, MethodId, build_runner};
use lostmotion_rig::mill_x;
use std::f64::consts::TAU;

const STIFFNESS: f64 = 238.0;

/// An end without friction, and with a gap.
fn end(gap_um: f64, coulomb_n: f64) -> AxisConfig {
    let mut config = mill_x(0.0, gap_um, None);
    config.motor.coulomb_nm = 0.0;
    if let Load::Slide(slide) = &mut config.load {
        (slide.coulomb_n, slide.stiffness_n_per_um) = (coulomb_n, STIFFNESS);
    }
    config
}

fn tied(ends: [&AxisConfig; 2], stiffness_n_per_um: f64) -> TiedAxes {
    let runners = ends.map(|config| build_runner(config, MethodId::NONE, 0.0).unwrap());
    TiedAxes::new(
        runners,
        ends,
        Tie {
            stiffness_n_per_um,
            damping_n_s_per_mm: 0.0,
        },
    )
    .unwrap()
}

/// Load positions of both ends, um, after setpoints of each.
fn run(pair: &mut TiedAxes, setpoints: [&[Setpoint]; 2]) -> [Vec<f64>; 2] {
    let (mut a, mut b) = (AxisOutput::new(false), AxisOutput::new(false));
    pair.push(setpoints, [&mut a, &mut b]).unwrap();
    [a.load, b.load].map(|load| load.into_iter().map(|mm| mm * 1e3).collect())
}

fn hold(force_n: f64) -> Setpoint {
    Setpoint {
        load_force: Some(force_n),
        ..Setpoint::moving(0.0, 0.0, 0.0)
    }
}

/// A force on one of two ends that are held: springs to the ground on either side of the tie. The
/// other end gets what goes through two springs in series.
#[test]
fn held_ends_are_three_springs() {
    let config = end(0.0, 0.0);
    for tie in [0.0, 30.0, 500.0] {
        let force = 400.0;
        let [a, b] = run(
            &mut tied([&config; 2], tie),
            [&[hold(force); 3000], &[hold(0.0); 3000]],
        );
        let (a, b) = (-a.last().unwrap(), -b.last().unwrap());
        let determinant = STIFFNESS * (STIFFNESS + 2.0 * tie);
        let (first, second) = (
            force * (STIFFNESS + tie) / determinant,
            force * tie / determinant,
        );
        assert!(
            (a - first).abs() < 1e-5 && (b - second).abs() < 1e-5,
            "{tie}: {a} {first}, {b} {second}"
        );
    }
}

/// Like ends that do the same never feel the tie: each is an axis by itself, and both together are
/// one of twice the mass, motor and stiffness.
#[test]
fn like_ends_are_one_axis() {
    let config = end(20.0, 120.0);
    let motion = |n: u32| {
        let (w, t) = (TAU * 1.5, f64::from(n) * 1e-3);
        let (sin, cos) = lostmotion_base::math::sin_cos(w * t);
        Setpoint::moving(3.0 * (1.0 - cos), 3.0 * w * sin, 3.0 * w * w * cos)
    };
    let setpoints: Vec<Setpoint> = (0..1500).map(motion).collect();
    let mut alone = AxisOutput::new(false);
    build_runner(&config, MethodId::NONE, 0.0)
        .unwrap()
        .push(&setpoints, &mut alone)
        .unwrap();
    let (mut a, mut b) = (AxisOutput::new(false), AxisOutput::new(false));
    tied([&config; 2], 80.0)
        .push([&setpoints, &setpoints], [&mut a, &mut b])
        .unwrap();
    assert!(a == alone && b == alone);
}

/// The end whose gap is open is dragged by the beam alone: the skew is its friction by the beam's
/// stiffness.
#[test]
fn an_end_in_its_gap_is_dragged_by_the_beam() {
    for (tie, friction) in [(20.0, 200.0), (60.0, 90.0)] {
        let (tight, loose) = (end(0.0, friction), end(400.0, friction));
        // The gap of 0.4 mm is gone through at 1 mm/s: half of it takes 200 ms, the second end
        // stands in its middle.
        let setpoints: Vec<Setpoint> = (0..190_u32)
            .map(|n| Setpoint::moving(1e-3 * f64::from(n), 1.0, 0.0))
            .collect();
        let [a, b] = run(&mut tied([&tight, &loose], tie), [&setpoints, &setpoints]);
        let late = a.len() - 160..a.len() - 40;
        let skew = a[late.clone()]
            .iter()
            .zip(&b[late.clone()])
            .map(|(a, b)| a - b)
            .sum::<f64>()
            / late.len() as f64;
        // The slides' viscous friction, 500 N s/m at 1 mm/s, counts along.
        let expected = (friction + 0.5) / tie;
        assert!(
            (skew / expected - 1.0).abs() < 0.02,
            "{tie} {friction}: {skew} {expected}"
        );
    }
}

/// Ends that the shafts hardly hold swing against each other as two masses on the tie between them:
/// at sqrt(2 k / m).
#[test]
fn free_ends_swing_against_each_other() {
    let mut config = end(10_000.0, 0.0);
    if let Load::Slide(slide) = &mut config.load {
        slide.viscous_n_s_per_m = 0.0;
    }
    let tie = 20.0;
    let mut pair = tied([&config; 2], tie);
    // A push apart, and then let go: both stay within their gaps.
    let push = |force: f64| [hold(force); 2];
    run(&mut pair, [&push(-2000.0), &push(2000.0)]);
    let [a, b] = run(&mut pair, [&[hold(0.0); 2000], &[hold(0.0); 2000]]);
    let skew: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
    let crossings: Vec<f64> = skew
        .windows(2)
        .enumerate()
        .filter(|(_, pair)| pair[0] < 0.0 && pair[1] >= 0.0)
        .map(|(n, pair)| n as f64 - pair[0] / (pair[1] - pair[0]))
        .collect();
    let cycles = (crossings.len() - 1) as f64;
    let period_s = (crossings.last().unwrap() - crossings[0]) * 250e-6 / cycles;
    let expected = TAU / (2.0 * tie * 1e6 / 300.0_f64).sqrt();
    assert!(
        (period_s / expected - 1.0).abs() < 1e-3,
        "{period_s} {expected}"
    );
    // No energy comes or goes: the last swings are as wide as the first.
    let widest = |part: &[f64]| part.iter().fold(0.0_f64, |most, skew| most.max(skew.abs()));
    let [first, last] = [widest(&skew[..400]), widest(&skew[skew.len() - 400..])];
    assert!((last / first - 1.0).abs() < 5e-3, "{first} {last}");
}

#[test]
fn a_tie_that_the_current_loop_cannot_follow_is_refused() {
    let config = end(0.0, 0.0);
    for (stiffness_n_per_um, damping_n_s_per_mm) in
        [(-1.0, 0.0), (f64::NAN, 0.0), (1e5, 0.0), (10.0, -1.0)]
    {
        assert!(
            Tie {
                stiffness_n_per_um,
                damping_n_s_per_mm
            }
            .check([&config; 2])
            .is_err()
        );
    }
}
