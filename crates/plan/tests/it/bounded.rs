//! Plans end, in time and memory in proportion to their length, in every quality and at every pace.
//!
//! The suite plans some programs of each kind; `PROGRAMS=10000` plans as many of each. A plan that
//! grows without end fails the test before it fills the memory.

use crate::common::generate::{Case, Dice, plain, varied};
use crate::common::paced::Plan;
use crate::common::{cartesian, run};
use lostmotion_base::Coords;
use lostmotion_path::Curve;
use lostmotion_plan::{Action, FeedLimit, Move, PlanItem, Planner, PlannerConfig, Quality, Sample};
use std::env;

/// Samples in what a program may take at least, times the cycle: ten stops of the slowest machine.
const SHORTEST_MS: usize = 20_000;

fn count(few: u64) -> u64 {
    env::var("PROGRAMS").map_or(few, |many| many.parse().unwrap())
}

fn of_quality(case: Case, quality: Quality) -> Case {
    Case {
        config: PlannerConfig {
            quality,
            ..case.config
        },
        ..case
    }
}

fn items(case: &Case) -> Vec<PlanItem> {
    case.program
        .moves
        .iter()
        .map(|m| PlanItem::Move(*m))
        .collect()
}

fn plan(case: &Case) -> Vec<Sample> {
    run(
        case.config.clone(),
        cartesian(),
        Coords::ZERO,
        items(case).into_iter(),
    )
}

/// Part by which a plan of quality `optimal` may take longer than that of `fast`: where no better
/// motion is found within a window, the nominal pace stands in for it, or half of it (record 118).
const SLOWER: f64 = 0.25;

#[test]
fn plans_of_both_qualities_end() {
    let mut slower = 0;
    for seed in 90_000..90_000 + count(60) {
        for make in [plain, varied] {
            let fast = plan(&of_quality(make(seed), Quality::Fast));
            let optimal = plan(&of_quality(make(seed), Quality::Optimal));
            let part = (optimal.len() as f64 - 2.0) / fast.len() as f64 - 1.0;
            if part > 0.01 {
                println!("{seed}: {part}");
                slower += 1;
            }
            assert!(part <= SLOWER, "{seed}: {part}");
        }
    }
    assert!(slower <= count(60) / 50, "{slower}");
}

fn actions(dice: &mut Dice) -> Vec<(u64, Action)> {
    let mut at = 0;
    let mut actions = Vec::new();
    for _ in 0..dice.between(1.0, 6.0) as usize {
        at += dice.spread(1.0, 800.0) as u64;
        actions.push((
            at,
            match dice.roll() {
                part if part < 0.1 => Action::Hold,
                part if part < 0.25 => Action::Resume,
                part if part < 0.4 => Action::Rapid(dice.one_of(&[0.0, 0.05, 0.5, 1.0])),
                part if part < 0.6 => Action::Override(dice.one_of(&[0.0, 1e-3, 1.0, 2.0])),
                _ => Action::Override(dice.between(1e-3, 2.0)),
            },
        ));
    }
    at += 300;
    actions.extend([
        (at, Action::Resume),
        (at, Action::Rapid(1.0)),
        (at, Action::Override(dice.between(0.8, 2.0))),
    ]);
    actions
}

/// With what an operator may do, too: after the last of it no program takes much longer than all of
/// it took as planned.
#[test]
fn plans_end_whatever_an_operator_does() {
    let mut dice = Dice::seeded(77);
    for seed in 95_000..95_000 + count(60) {
        let quality = dice.one_of(&[Quality::Fast, Quality::Fast, Quality::Optimal]);
        let case = of_quality(
            if seed % 2 == 0 {
                plain(seed)
            } else {
                varied(seed)
            },
            quality,
        );
        let alone = plan(&case).len();
        let actions = actions(&mut dice);
        let last = actions.last().unwrap().0 as usize;
        let plan = Plan::of(&case.config, items(&case));
        let most = last + 2 * alone + SHORTEST_MS;
        let samples = plan.paced_within(&actions, most);
        assert!(
            samples.len() < most,
            "{seed}: {} {actions:?}",
            samples.len()
        );
        assert_eq!(
            samples.last().unwrap().position,
            plan.samples.last().unwrap().position,
            "{seed}: {actions:?}"
        );
    }
}

/// A program several times, with a line back to its start in between.
fn again(case: &Case, times: usize) -> Vec<Move> {
    let once = &case.program.moves;
    let back = Move {
        curve: Curve::line(once.last().unwrap().curve.end(), once[0].curve.start()),
        feed: FeedLimit::Rapid,
        ..once[0]
    };
    (0..times)
        .flat_map(|_| once.iter().copied().chain([back]))
        .collect()
}

/// The most pieces and samples that a planner held, where what is final is taken at once.
fn held_by_planner(config: &PlannerConfig, moves: &[Move]) -> [usize; 2] {
    let mut planner = Planner::new(config.clone(), cartesian(), Coords::ZERO).unwrap();
    let (mut held, mut samples) = ([0; 2], Vec::new());
    for item in moves {
        planner.push(PlanItem::Move(*item)).unwrap();
        samples.clear();
        while planner.take(1, &mut samples) > 0 {
            held[1] = held[1].max(planner.held_samples());
        }
        held[0] = held[0].max(planner.held_pieces());
    }
    held
}

/// What is held is that of the window: it does not grow with the program, in any quality and at any
/// pace.
#[test]
fn what_is_held_does_not_grow_with_the_program() {
    for seed in 97_000..97_000 + count(4) {
        for quality in [Quality::Fast, Quality::Optimal] {
            let make = if seed % 2 == 0 { plain } else { varied };
            let case = of_quality(make(seed), quality);
            // As often as the windows need to be full at least once.
            let times = 1 + 6000 / plan(&case).len();
            let [few, many] = [times, 4 * times].map(|times| again(&case, times));
            let [few_held, many_held] =
                [&few, &many].map(|moves| held_by_planner(&case.config, moves));
            // A window that is never at rest fills up; a section is not cut.
            let full = case.config.window_pieces + 512;
            assert!(many_held[0] <= full, "{seed} {quality:?}: {many_held:?}");
            assert!(
                few_held[1] == 0 || many_held[1] <= few_held[1] + few_held[1] / 4 + 64,
                "{seed} {quality:?}: {many_held:?} after {few_held:?}"
            );
            assert_eq!(many_held[1] > 0, quality == Quality::Optimal, "{seed}");
            let [few, many] = [few, many].map(|moves| {
                let items = moves.into_iter().map(PlanItem::Move).collect();
                let plan = Plan::of(&case.config, items);
                let most = 4 * plan.samples.len() + SHORTEST_MS;
                let over = [(0, Action::Override(1.5))];
                let (samples, held) = plan.paced_held(&over, most);
                assert!(samples.len() < most, "{seed}");
                held
            });
            assert!(
                many <= few + few / 4 + 64,
                "{seed} {quality:?}: paced {many} after {few}"
            );
        }
    }
}
