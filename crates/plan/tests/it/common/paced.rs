//! Plans at another pace.

use super::{LIMITS, Program, assert_limits, cartesian, continuous, deviation, run, three_axes};
use lostmotion_base::{Coords, math};
use lostmotion_plan::{Action, Move, Pacer, PlanItem, PlannerConfig, Sample};
use std::f64::consts::TAU;

/// A plan at the clock that a pacer wants.
pub(crate) struct Plan {
    pub(crate) config: PlannerConfig,
    pub(crate) samples: Vec<Sample>,
    pub(crate) moves: Vec<Move>,
}

impl Plan {
    pub(crate) fn of(config: &PlannerConfig, items: Vec<PlanItem>) -> Plan {
        let fine = PlannerConfig {
            clock: Pacer::plan_clock(config),
            ..config.clone()
        };
        let moves = items
            .iter()
            .filter_map(|item| {
                if let PlanItem::Move(item) = item {
                    Some(*item)
                } else {
                    None
                }
            })
            .collect();
        Plan {
            config: config.clone(),
            samples: run(fine, cartesian(), Coords::ZERO, items.into_iter()),
            moves,
        }
    }

    pub(crate) fn program(program: &Program) -> Plan {
        Plan::of(
            &three_axes(),
            program.moves.iter().map(|m| PlanItem::Move(*m)).collect(),
        )
    }

    /// The samples with actions at times in ms.
    pub(crate) fn paced(&self, actions: &[(u64, Action)]) -> Vec<Sample> {
        self.paced_within(actions, usize::MAX)
    }

    /// The same, given up after a number of samples.
    pub(crate) fn paced_within(&self, actions: &[(u64, Action)], most: usize) -> Vec<Sample> {
        self.paced_held(actions, most).0
    }

    /// The same, and the most samples that the pacer held.
    pub(crate) fn paced_held(
        &self,
        actions: &[(u64, Action)],
        most: usize,
    ) -> (Vec<Sample>, usize) {
        let mut held = 0;
        let mut pacer = Pacer::new(&self.config).unwrap();
        let (mut out, mut plan, mut actions): (Vec<Sample>, _, _) =
            (Vec::new(), self.samples.iter(), actions.iter().peekable());
        loop {
            while actions
                .peek()
                .is_some_and(|(at, _)| *at <= out.len() as u64)
            {
                pacer.act(actions.next().unwrap().1).unwrap();
            }
            if pacer.is_held() && actions.peek().is_none() || out.len() >= most {
                return (out, held);
            }
            held = held.max(pacer.held_samples());
            if let Some(sample) = pacer.take() {
                assert_eq!(sample.tick, out.len() as u64);
                out.push(sample);
                continue;
            }
            match plan.next() {
                Some(sample) => pacer.push(*sample),
                None if pacer.finish() => {}
                None => return (out, held),
            }
        }
    }

    /// What holds for any actions that let it go on in the end.
    pub(crate) fn check(&self, actions: &[(u64, Action)], tolerance: f64) -> Vec<Sample> {
        let samples = self.paced(actions);
        assert_limits(&samples, &[Some(LIMITS); 3]);
        let worst = deviation(&samples, &self.moves);
        assert!(
            worst <= tolerance + 2e-8,
            "{actions:?}: {worst} of {tolerance}"
        );
        assert_eq!(
            samples.last().unwrap().position,
            self.samples.last().unwrap().position,
            "{actions:?}"
        );
        samples
    }
}

pub(crate) fn square() -> Program {
    let mut program = Program::new(continuous(0.01), 50.0);
    program.line(20.0, 0.0, 0.0);
    program.line(20.0, 20.0, 0.0);
    program.line(0.0, 20.0, 0.0);
    program.line(0.0, 0.0, 0.0);
    program
}

pub(crate) fn circle() -> Program {
    let mut program = Program::new(continuous(0.01), 100.0);
    program.line(10.0, 0.0, 0.0);
    program.arc(0.0, 8.0, TAU);
    program.line(30.0, 0.0, 0.0);
    program
}

pub(crate) fn sine() -> Program {
    let mut program = Program::new(continuous(0.01), 100.0);
    for i in 1..=300_u32 {
        let x = 0.2 * f64::from(i);
        program.line(x, 0.0, 2.0 * math::sin(x * TAU / 20.0));
    }
    program
}

pub(crate) fn pocket() -> Program {
    let mut program = Program::new(continuous(0.01), 100.0);
    program.line(0.0, 0.0, -1.0);
    for ring in 1..4 {
        let side = 6.0 * f64::from(ring);
        program.line(side, 0.0, -1.0);
        program.arc(0.0, 2.0, 0.25 * TAU);
        program.line(side + 2.0, side, -1.0);
        program.line(0.0, side, -1.0);
        program.line(0.0, 0.0, -1.0);
    }
    program
}
