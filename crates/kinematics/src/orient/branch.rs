//! Which of the solutions: the way through all directions that turns least.

use super::{Angles, OrientError, Orientation};
use std::f64::consts::TAU;

/// Positions beyond the travel by less are rounding, rad.
const TRAVEL_TOLERANCE_RAD: f64 = 1e-9;
/// Solutions nearer to each other than this are one, rad.
const SAME_STATE_RAD: f64 = 1e-9;
/// Most states kept per direction, those that turn least. A choice: more cost time, fewer may give
/// up a way that pays later.
const MAX_STATES: usize = 24;

/// Where the joints may be at one direction, and how they got there.
#[derive(Clone, Copy, Debug)]
struct State {
    angles: Angles,
    /// Turned so far, rad, both joints together.
    turned: f64,
    /// State of the direction before.
    from: usize,
    /// Which of the solutions; `None` where the first joint is free.
    branch: Option<usize>,
}

/// What each direction of a list asks of the joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Wanted {
    pub(crate) direction: [f64; 3],
    /// Whether the first joint may stay where it is: the direction is the pole within the
    /// tolerance.
    pub(crate) free: bool,
}

impl Orientation {
    /// Positions of the rotary joints for a list of directions, from where they are: of all
    /// solutions those that turn least in sum, the shortest way for joints that may go a turn more
    /// or less, within the travel.
    ///
    /// Exact over the whole list: a search by stages (Bellman), whose states are the solutions with
    /// all their turns.
    ///
    /// # Errors
    /// The first direction that cannot be had.
    pub fn choose(
        &self,
        from: Angles,
        directions: &[[f64; 3]],
    ) -> Result<Vec<Angles>, OrientError> {
        let wanted: Vec<Wanted> = directions
            .iter()
            .map(|direction| self.wanted(*direction))
            .collect();
        self.through(from, None, &wanted)
    }

    /// A direction, free where it is the pole within the tolerance.
    pub(crate) fn wanted(&self, direction: [f64; 3]) -> Wanted {
        let free = self
            .pole_distance(direction)
            .is_some_and(|away| away <= 0.5 * self.tolerance_rad);
        Wanted { direction, free }
    }

    /// The same; with `start`, the direction at the beginning, the list is a path: solutions may
    /// only be changed between where the tool stays near the great circle meanwhile.
    pub(crate) fn through(
        &self,
        from: Angles,
        start: Option<[f64; 3]>,
        wanted: &[Wanted],
    ) -> Result<Vec<Angles>, OrientError> {
        let branch = start.and_then(|start| self.branch_at(from, start));
        let mut stages = vec![vec![State {
            angles: from,
            turned: 0.0,
            from: 0,
            branch,
        }]];
        let mut here = start;
        // Forward: the least turning to each state of each stage.
        for next in wanted {
            let before = stages.last().map(Vec::as_slice).unwrap_or_default();
            let states = self.stage(before, here, next)?;
            stages.push(states);
            here = here.map(|_| next.direction);
        }
        // Backward: from the best last state along the states that led there.
        let least = |states: &[State]| {
            (0..states.len()).min_by(|a, b| states[*a].turned.total_cmp(&states[*b].turned))
        };
        let mut at = stages.last().and_then(|states| least(states)).unwrap_or(0);
        let mut angles = Vec::with_capacity(wanted.len());
        for states in stages.iter().skip(1).rev() {
            let Some(state) = states.get(at) else { break };
            angles.push(state.angles);
            at = state.from;
        }
        angles.reverse();
        Ok(angles)
    }

    /// Which solution the joints stand on; none at a pole.
    pub(crate) fn branch_at(&self, angles: Angles, direction: [f64; 3]) -> Option<usize> {
        if self.wanted(direction).free {
            return None;
        }
        // Distance in angle, whole turns aside.
        let off = |(first, second): &(Option<f64>, f64)| {
            let turn = |a: f64, b: f64| (a - b - TAU * ((a - b) / TAU).round()).abs();
            turn(first.unwrap_or(angles[0]), angles[0])
                + if self.joints.len() > 1 {
                    turn(*second, angles[1])
                } else {
                    0.0
                }
        };
        let solutions = self.solutions(direction);
        (0..solutions.len()).min_by(|a, b| off(&solutions[*a]).total_cmp(&off(&solutions[*b])))
    }

    /// Where the joints may be on one of a direction's solutions, near where they are.
    pub(crate) fn positions(
        &self,
        near: Angles,
        wanted: &Wanted,
        (first, second): &(Option<f64>, f64),
    ) -> Vec<Angles> {
        // At a pole the first joint stays where it is.
        let firsts = match first {
            Some(first) if !wanted.free => self.nearby(0, *first, near[0]),
            _ => vec![near[0]],
        };
        let seconds = if self.joints.len() > 1 {
            self.nearby(1, *second, near[1])
        } else {
            vec![0.0]
        };
        firsts
            .iter()
            .flat_map(|a| seconds.iter().map(move |b| [*a, *b]))
            .collect()
    }

    fn stage(
        &self,
        before: &[State],
        here: Option<[f64; 3]>,
        wanted: &Wanted,
    ) -> Result<Vec<State>, OrientError> {
        let direction = wanted.direction;
        let solutions = self.solutions(direction);
        // No angles at all give it; a travel that is too short is found out below.
        if solutions.is_empty() {
            return Err(OrientError::Unreachable { direction });
        }
        let mut states: Vec<State> = Vec::new();
        for (index, state) in before.iter().enumerate() {
            for (branch, solution) in solutions.iter().enumerate() {
                let positions = self.positions(state.angles, wanted, solution);
                let branch = (solution.0.is_some() && !wanted.free).then_some(branch);
                // Along a path the solution may only change where the tool stays near the great circle.
                let changes = branch.zip(state.branch).is_some_and(|(a, b)| a != b);
                for angles in positions {
                    if changes
                        && here.is_some_and(|here| {
                            self.leaves(here, state.angles, direction, angles) > self.tolerance_rad
                        })
                    {
                        continue;
                    }
                    // The cost of a way: how far both joints have turned in sum.
                    let turned = state.turned
                        + (angles[0] - state.angles[0]).abs()
                        + (angles[1] - state.angles[1]).abs();
                    keep(
                        &mut states,
                        State {
                            angles,
                            turned,
                            from: index,
                            branch,
                        },
                    );
                }
            }
        }
        if states.is_empty() {
            return Err(OrientError::Travel { direction });
        }
        // Ways that have turned most are given up, so that joints without limits stay affordable.
        states.sort_by(|a, b| a.turned.total_cmp(&b.turned));
        states.truncate(MAX_STATES);
        Ok(states)
    }

    /// The positions that are the same but for whole turns, within the travel: the nearest one, and
    /// the nearest on either side.
    fn nearby(&self, joint: usize, angle: f64, to: f64) -> Vec<f64> {
        let nearest = angle + TAU * ((to - angle) / TAU).round();
        let travel = self.travel.get(joint).copied().flatten();
        let inside = |angle: f64| {
            travel.is_none_or(|(min, max)| {
                angle >= min - TRAVEL_TOLERANCE_RAD && angle <= max + TRAVEL_TOLERANCE_RAD
            })
        };
        // A turn more or less may be what later directions need to stay in the travel.
        [nearest, nearest + TAU, nearest - TAU]
            .into_iter()
            .filter(|angle| inside(*angle))
            .collect()
    }
}

/// Adds a state, or takes it in place of a longer way to the same.
fn keep(states: &mut Vec<State>, new: State) {
    let same = |old: &&mut State| {
        old.branch == new.branch
            && (0..2).all(|i| (old.angles[i] - new.angles[i]).abs() < SAME_STATE_RAD)
    };
    match states.iter_mut().find(same) {
        Some(old) if new.turned < old.turned => *old = new,
        Some(_) => {}
        None => states.push(new),
    }
}
