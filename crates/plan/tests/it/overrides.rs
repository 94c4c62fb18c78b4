//! Overrides above 100 %, of rapid moves, and moves that heed none: within all limits, on the path,
//! and to the same end.

use crate::common::paced::{Plan, circle, pocket, sine, square};
use crate::common::{LIMITS, Program, optimal};
use lostmotion_base::{AxisLimits, Coords};
use lostmotion_plan::{Action, FeedLimit, PathControl, PlanItem, Sample};
use proptest::prelude::*;

fn at_feed(mut program: Program, mm_s: f64) -> Program {
    program
        .moves
        .iter_mut()
        .for_each(|item| item.feed = FeedLimit::PerSecond(mm_s));
    program
}

/// Rapid to and fro, with feed moves and one that heeds no override in between.
fn drilling() -> Program {
    let mut program = Program::new(PathControl::ExactPath, 20.0);
    let (feed, fixed) = (program.feed, FeedLimit::Fixed(20.0));
    for (x, feed) in [(1.0, feed), (2.0, fixed)] {
        program.feed = FeedLimit::Rapid;
        program.line(30.0 * x, 0.0, 0.0);
        program.feed = feed;
        program.line(30.0 * x, 0.0, -10.0);
        program.feed = FeedLimit::Rapid;
        program.line(30.0 * x, 0.0, 0.0);
    }
    program
}

/// Largest path speed on a move.
fn fastest(samples: &[Sample], segment: u64) -> f64 {
    samples
        .iter()
        .filter(|sample| sample.segment == segment)
        .map(|sample| sample.path_speed)
        .fold(0.0, f64::max)
}

fn mm_s(velocity: f64, part: f64) -> std::ops::RangeInclusive<f64> {
    velocity * (1.0 - part)..=velocity * 1.0001
}

/// What a feed above the programmed one takes is what the program would with that feed: from the
/// start within 2.5 %, since the curve is chosen for the programmed feed; later on what has gone by is
/// lost.
#[test]
fn above_100_the_feed_is_what_the_program_would_have_with_it() {
    for make in [square, circle, sine, pocket] {
        let plan = Plan::program(&at_feed(make(), 40.0));
        let alone = plan.check(&[], 0.01);
        for part in [1.2, 2.0] {
            let replanned = Plan::program(&at_feed(make(), part * 40.0))
                .check(&[], 0.01)
                .len();
            for at in [0, 150, 333] {
                let samples = plan.check(&[(at, Action::Override(part))], 0.01);
                assert!(samples[..=at as usize] == alone[..=at as usize]);
                let most = replanned
                    + replanned / 40
                    + at as usize * (alone.len() - replanned) / alone.len()
                    + 60;
                assert!(
                    samples.len() <= most,
                    "{part} at {at}: {} of {most}",
                    samples.len()
                );
                assert!(
                    samples
                        .iter()
                        .all(|sample| sample.feed_part <= part * 1.0005),
                    "{part} at {at}"
                );
            }
        }
    }
}

#[test]
fn so_it_is_on_a_plan_that_is_nearly_optimal() {
    let items = at_feed(square(), 25.0)
        .moves
        .into_iter()
        .map(PlanItem::Move)
        .collect();
    let plan = Plan::of(&optimal(), items);
    let (alone, faster) = (
        plan.check(&[], 0.01).len(),
        plan.check(&[(200, Action::Override(2.0))], 0.01).len(),
    );
    assert!(faster < alone * 6 / 10, "{faster} of {alone}");
}

/// From a steady speed to another along X takes v/a + a/j, and loses half of that at the higher
/// speed.
#[test]
fn on_a_line_it_gets_faster_as_soon_as_can_be() {
    let mut program = Program::new(PathControl::ExactPath, 30.0);
    program.line(60.0, 0.0, 0.0);
    let plan = Plan::program(&program);
    let samples = plan.check(&[(600, Action::Override(2.0))], 1e-9);
    let AxisLimits {
        acceleration, jerk, ..
    } = LIMITS;
    let takes_ms = 1e3 * (30.0 / acceleration + acceleration / jerk);
    let reached = samples
        .iter()
        .position(|sample| sample.path_speed > 59.9)
        .unwrap() as f64;
    assert!(
        (reached - 600.0 - takes_ms).abs() <= 0.05 * takes_ms,
        "{reached} {takes_ms}"
    );
    assert!(
        mm_s(60.0, 1e-3).contains(&fastest(&samples, 0)),
        "{}",
        fastest(&samples, 0)
    );
}

#[test]
fn rapids_heed_their_own_override_and_fixed_feeds_none() {
    let plan = Plan::program(&drilling());
    for (feed, rapid) in [(0.3, 1.0), (2.0, 1.0), (1.0, 0.25), (0.5, 0.5), (2.0, 0.5)] {
        let samples = plan.check(
            &[(0, Action::Override(feed)), (0, Action::Rapid(rapid))],
            1e-9,
        );
        // Retimed motions leave 2 % of the jerk.
        let part = 0.01;
        for (segment, speed) in [
            (0, 100.0 * rapid),
            (1, 20.0 * feed),
            (3, 100.0 * rapid),
            (4, 20.0),
        ] {
            let fastest = fastest(&samples, segment);
            assert!(
                mm_s(speed, part).contains(&fastest),
                "{feed} {rapid} on {segment}: {fastest}"
            );
        }
    }
}

#[test]
fn nothing_of_the_feed_is_rest_on_feed_moves_only() {
    let plan = Plan::program(&drilling());
    let samples = plan.check(
        &[(0, Action::Override(0.0)), (3000, Action::Override(1.0))],
        1e-9,
    );
    assert!(mm_s(100.0, 0.01).contains(&fastest(&samples, 0)));
    let resting = &samples[1500..3000];
    assert!(
        resting
            .iter()
            .all(|sample| sample.segment == 1 && sample.velocity == Coords::ZERO)
    );
    // It creeps at some hundredths of the feed until it is on the feed move for certain.
    assert!(resting[0].position.linear()[2] > -0.05);
    assert!(plan.paced(&[(0, Action::Override(0.0))]).len() < 1500);
}

/// Where what is held back of a window passes a limit however slow it gets, the window is not
/// slowed until it stands still: it had samples without end.
#[test]
fn a_window_that_no_dip_mends_ends() {
    let plan = Plan::program(&at_feed(pocket(), 35.0));
    let actions = [
        (345, Action::Override(1.307_922_986_504_884_7)),
        (577, Action::Override(1.113_382_917_782_073)),
    ];
    plan.check(&actions, 0.01);
}

#[test]
fn no_override_is_the_plan_to_the_bit() {
    let plan = Plan::program(&drilling());
    assert!(
        plan.paced(&[]) == plan.paced(&[(100, Action::Override(1.0)), (200, Action::Rapid(1.0))])
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 12, failure_persistence: None, ..ProptestConfig::default() })]
    #[test]
    fn any_actions_keep_limits_and_path(which in 0_usize..5, waits in prop::collection::vec((1_u64..400, 0_u32..8, 0.0_f64..2.0), 1..6)) {
        let program = [square, circle, sine, pocket, drilling][which]();
        let plan = Plan::program(&if which < 4 { at_feed(program, 35.0) } else { program });
        let (mut now, mut actions) = (0, Vec::new());
        for (wait, kind, part) in waits {
            now += wait;
            actions.push((now, match kind { 0 => Action::Hold, 1 | 2 => Action::Resume, 3 => Action::Rapid(0.5 * part), _ => Action::Override(part) }));
        }
        actions.push((now + 300, Action::Resume));
        actions.push((now + 300, Action::Override(1.5)));
        actions.push((now + 300, Action::Rapid(1.0)));
        plan.check(&actions, 0.01);
    }
}
