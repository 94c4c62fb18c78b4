//! Every limit and tolerance is kept on programs that nobody would write.

use crate::common::{LIMITS, Program, assert_limits, continuous, deviation, optimal};
use lostmotion_base::math;
use lostmotion_plan::{FeedLimit, PathControl};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

#[derive(Clone, Debug)]
enum Step {
    Line(f64, f64, f64),
    Arc(f64, f64, f64),
    /// Straight on from a line or arc in the direction of a fixed tangent, then an arc tangent to
    /// it.
    Fillet(f64, f64),
}

fn size() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), -0.01..0.01, -1.0..1.0, -30.0..30.0, -1e-7..1e-7]
}

fn step() -> impl Strategy<Value = Step> {
    prop_oneof![
        4 => (size(), size(), size()).prop_map(|(x, y, z)| Step::Line(x, y, z)),
        2 => (0.02..20.0, -3.1..3.1, prop_oneof![0.05..6.2, -6.2..-0.05]).prop_map(|(r, at, sweep)| Step::Arc(r, at, sweep)),
        2 => (0.2..10.0, prop_oneof![0.2..3.0, -3.0..-0.2]).prop_map(|(r, sweep)| Step::Fillet(r, sweep)),
        1 => (-1e-4..1e-4, 1.0..20.0).prop_map(|(y, x): (f64, f64)| Step::Line(-x, y, 0.0)),
    ]
}

fn control() -> impl Strategy<Value = PathControl> {
    prop_oneof![
        4 => prop_oneof![0.001..0.02, 0.02..0.5].prop_map(continuous),
        1 => Just(PathControl::ExactPath),
        1 => Just(PathControl::ExactStop),
    ]
}

fn program(steps: &[Step], control: PathControl, feed: f64) -> Program {
    let mut program = Program::new(control, feed);
    for (number, step) in steps.iter().enumerate() {
        program.feed = if number % 5 == 4 {
            FeedLimit::Rapid
        } else {
            FeedLimit::PerSecond(feed)
        };
        let [x, y, z] = program.here.linear();
        match *step {
            Step::Line(dx, dy, dz) => program.line(x + dx, y + dy, z + dz),
            Step::Arc(r, at, sweep) => program.arc(r * math::cos(at), r * math::sin(at), sweep),
            Step::Fillet(r, sweep) => {
                program.line(x + 2.0 * r, y, z);
                program.arc(0.0, r * sweep.signum(), sweep);
            }
        }
    }
    program
}

fn tolerance(control: PathControl) -> f64 {
    match control {
        PathControl::Continuous { tolerance_mm, .. } => tolerance_mm.unwrap_or(0.01).max(1e-4),
        _ => 1e-4,
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn limits_and_tolerance_hold(steps in prop::collection::vec(step(), 1..14), control in control(), feed in 1.0..150.0) {
        let program = program(&steps, control, feed);
        let samples = program.run();
        assert_limits(&samples, &[Some(LIMITS); 3]);
        let worst = deviation(&samples, &program.moves);
        prop_assert!(worst <= tolerance(control) + 1e-8, "deviation {worst} of {}", tolerance(control));
        prop_assert!(samples.windows(2).all(|pair| pair[0].segment <= pair[1].segment));
        let (first, last) = (samples[0], samples[samples.len() - 1]);
        prop_assert_eq!(first.velocity.0, [0.0; 9]);
        prop_assert_eq!(last.velocity.0, [0.0; 9]);
        prop_assert!((last.position - program.here).linear_norm() < 1e-8);
    }

    #[test]
    fn noisy_polylines_keep_limits(seed in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 20..200), spacing in 0.01..0.6f64, noise in 0.0..0.01f64) {
        let mut program = Program::new(continuous(0.01), 100.0);
        for (i, (u, v)) in seed.iter().enumerate() {
            let x = spacing * (i + 1) as f64;
            program.line(x, 2.0 * math::sin(x * 0.6) + u * noise, 0.3 * x + v * noise);
        }
        let samples = program.run();
        assert_limits(&samples, &[Some(LIMITS); 3]);
        let worst = deviation(&samples, &program.moves);
        prop_assert!(worst <= 0.01 + 1e-8, "deviation {worst}");
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, rng_seed: RngSeed::Fixed(5), ..ProptestConfig::default() })]

    #[test]
    fn limits_and_tolerance_hold_at_nearly_the_least_time(
        steps in prop::collection::vec(step(), 1..14),
        control in control(),
        feed in 1.0..150.0,
    ) {
        let program = program(&steps, control, feed);
        let samples = program.run_with(optimal());
        let fast = program.run();
        assert_limits(&samples, &[Some(LIMITS); 3]);
        let worst = deviation(&samples, &program.moves);
        prop_assert!(worst <= tolerance(control) + 1e-8, "deviation {worst} of {}", tolerance(control));
        prop_assert!(samples.windows(2).all(|pair| pair[0].segment <= pair[1].segment));
        prop_assert!((samples[samples.len() - 1].position - program.here).linear_norm() < 1e-8);
        let (time, fast) = (samples.len() as f64, fast.len() as f64);
        prop_assert!(time <= 1.002 * fast + 3.0, "{time} ms, fast {fast} ms");
    }
}
