//! Feed hold, override and stop: within all limits at any moment, on the path, and to the same end.

use crate::common::paced::{Plan, circle, pocket, sine, square};
use crate::common::{LIMITS, Program, optimal, three_axes};
use lostmotion_base::BlockRef;
use lostmotion_plan::{Action, Dwell, Pacer, PathControl, PlanItem, Sample};
use proptest::prelude::*;

/// What comes of a hold: cycles to the stop.
fn stop_ms(samples: &[Sample], hold: usize) -> usize {
    samples[hold..]
        .windows(2)
        .position(|pair| pair[0].position == pair[1].position)
        .unwrap()
}

fn holds(plan: &Plan, step: usize, longest_ms: usize) {
    let untouched = plan.check(&[], 0.01);
    for hold in (0..untouched.len() - 1).step_by(step) {
        let samples = plan.check(
            &[
                (hold as u64, Action::Hold),
                (hold as u64 + 800, Action::Resume),
            ],
            0.01,
        );
        assert!(samples[..=hold] == untouched[..=hold]);
        assert!(
            samples.len() < untouched.len() + 800 + longest_ms,
            "hold at {hold}: {} of {}",
            samples.len(),
            untouched.len()
        );
        if hold + longest_ms < untouched.len() {
            let stop = stop_ms(&samples, hold);
            assert!(stop < longest_ms, "hold at {hold}: stops after {stop} ms");
        }
    }
}

#[test]
fn a_hold_at_any_time_keeps_limits_and_path_and_resumes_to_the_same_end() {
    for program in [square(), circle(), sine(), pocket()] {
        holds(&Plan::program(&program), 170, 600);
    }
}

#[test]
fn so_it_does_on_a_plan_that_is_nearly_optimal() {
    for program in [square(), sine()] {
        let items = program.moves.iter().map(|m| PlanItem::Move(*m)).collect();
        holds(&Plan::of(&optimal(), items), 230, 600);
    }
}

/// The sweep whose figures record 40 of docs/book/src/decisions/plan.md gives.
#[test]
fn holds_everywhere() {
    for program in [square(), circle(), sine(), pocket()] {
        let plan = Plan::program(&program);
        let untouched = plan.paced(&[]);
        let mut stops: Vec<usize> = Vec::new();
        for hold in (0..untouched.len() - 500).step_by(100) {
            let samples = plan.check(
                &[
                    (hold as u64, Action::Hold),
                    (hold as u64 + 900, Action::Resume),
                ],
                0.01,
            );
            stops.push(stop_ms(&samples, hold));
        }
        stops.sort_unstable();
        println!(
            "stops after {} ms in the median, {} at most, {} holds",
            stops[stops.len() / 2],
            stops.last().unwrap(),
            stops.len()
        );
    }
}

/// On a straight line at a steady speed the way to the stop is the S-curve's, v (v/a + a/j) / 2,
/// and so is the time.
#[test]
fn on_a_line_it_stops_as_soon_as_can_be() {
    let mut program = Program::new(PathControl::ExactPath, 60.0);
    program.line(60.0, 20.0, 0.0);
    let plan = Plan::program(&program);
    let samples = plan.check(&[(400, Action::Hold), (900, Action::Resume)], 1e-9);
    // X moves by 3/sqrt(10) of the path, and its limits hold it: 1000 and 30,000 are 1054 and
    // 31,623 along the path.
    let (v, part) = (60.0, 0.9_f64.sqrt());
    let (a, j) = (LIMITS.acceleration / part, LIMITS.jerk / part);
    let time_s = v / a + a / j;
    let way = (samples[600].position - samples[400].position).linear_norm();
    assert!((way / (0.5 * v * time_s) - 1.0).abs() < 4e-3, "{way}");
    let stop = stop_ms(&samples, 400);
    assert!((stop as f64 - time_s * 1e3).abs() <= 2.0, "{stop} {time_s}");
}

/// Half the pace on a feed-limited line is half the speed.
#[test]
fn an_override_scales_the_speed() {
    let mut program = Program::new(PathControl::ExactPath, 60.0);
    program.line(60.0, 0.0, 0.0);
    let samples = Plan::program(&program).check(
        &[(300, Action::Override(0.5)), (700, Action::Override(1.0))],
        1e-9,
    );
    assert!(
        (samples[600].velocity.0[0] - 30.0).abs() < 1e-6
            && (samples[600].path_speed - 30.0).abs() < 1e-6
    );
    assert!((samples[900].velocity.0[0] - 60.0).abs() < 1e-6);
}

/// A dwell lasts as long as it should at any override.
#[test]
fn dwells_are_not_stretched() {
    let mut program = Program::new(PathControl::ExactPath, 60.0);
    program.line(20.0, 0.0, 0.0);
    program.line(20.0, 20.0, 0.0);
    let dwell = PlanItem::Dwell(Dwell {
        seconds: 0.4,
        block: BlockRef::default(),
    });
    let plan = Plan::of(
        &three_axes(),
        vec![
            PlanItem::Move(program.moves[0]),
            dwell,
            PlanItem::Move(program.moves[1]),
        ],
    );
    let resting = |samples: &[Sample]| {
        samples
            .windows(2)
            .filter(|pair| pair[0].position == pair[1].position)
            .count()
    };
    let (alone, slow) = (
        plan.check(&[], 1e-9),
        plan.check(&[(0, Action::Override(0.3))], 1e-9),
    );
    assert!(
        resting(&alone).abs_diff(resting(&slow)) <= 2,
        "{} {}",
        resting(&alone),
        resting(&slow)
    );
}

#[test]
fn overrides_out_of_range_are_refused() {
    let mut pacer = Pacer::new(&three_axes()).unwrap();
    for part in [-0.5, 1e-9, 9e-4, 2.01, f64::NAN, f64::INFINITY] {
        assert!(pacer.act(Action::Override(part)).is_err(), "{part}");
        assert!(pacer.act(Action::Rapid(part)).is_err(), "{part}");
    }
    assert!(pacer.act(Action::Rapid(1.01)).is_err());
    for part in [0.0, 1e-3] {
        assert!(
            pacer.act(Action::Override(part)).is_ok() && pacer.act(Action::Rapid(part)).is_ok()
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn any_actions_keep_limits_and_path(which in 0_usize..4, waits in prop::collection::vec((1_u64..400, 0_u32..5, 0.05_f64..1.0), 1..6)) {
        let plan = Plan::program(&[square(), circle(), sine(), pocket()][which]);
        let (mut now, mut actions) = (0, Vec::new());
        for (wait, kind, part) in waits {
            now += wait;
            actions.push((now, match kind { 0 | 1 => Action::Hold, 2 => Action::Resume, _ => Action::Override(part) }));
        }
        actions.push((now + 300, Action::Resume));
        plan.check(&actions, 0.01);
    }
}
