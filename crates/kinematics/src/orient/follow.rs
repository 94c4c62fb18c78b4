//! From one direction to another along the great circle between them.

use super::branch::Wanted;
use super::{Angles, OrientError, Orientation, angle_between};
use lostmotion_base::math;
use lostmotion_base::units::deg;
use lostmotion_base::vec::{add, cross, dot, scale, unit};

/// Largest turn of the tool between two directions at which solutions are chosen, rad. Tuned on
/// random paths of every family; larger may step over a pole between two choices, smaller costs
/// time.
const CHOICE_STEP_RAD: f64 = 0.05;
/// Places within a step at which the tool's direction is compared with the great circle.
const CHECKS_PER_STEP: u32 = 16;
/// How often a step is halved, at most.
const MAX_STEP_HALVINGS: u32 = 14;

/// One of the steps of a turn: rotary joints go linearly from one to the next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrientedStep {
    /// Which of the turns asked for, and how much of that is done, 0 to 1.
    pub turn: usize,
    /// Part of the turn that is done, up to 1.
    pub part: f64,
    /// Rotary joints at its end, rad.
    pub angles: Angles,
}

impl Orientation {
    /// Turns from where the joints are to each direction in order, along great circles, in steps in
    /// which the joints go linearly and the tool leaves the great circle by no more than the
    /// orientation tolerance.
    ///
    /// Which solution is taken is decided over the whole list, so that a pole is crossed by tilting
    /// to the other side instead of turning round where that is shorter. Within half the tolerance
    /// of a pole the first joint may stay. A turn that passes a pole farther off makes it turn
    /// fast, which is the planner's business; no step ever jumps.
    ///
    /// # Errors
    /// Directions out of reach or of the travel, and turns on which the joints would have to change
    /// over.
    pub fn follow(
        &self,
        from: Angles,
        directions: &[[f64; 3]],
    ) -> Result<Vec<OrientedStep>, OrientError> {
        let mut wanted = Vec::new();
        let mut places = Vec::new();
        let mut here = self.direction(from);
        for (turn, direction) in directions.iter().enumerate() {
            let Some(there) = unit(*direction) else {
                return Err(OrientError::Unreachable {
                    direction: *direction,
                });
            };
            // Cut every great circle into directions close enough for solutions to be compared.
            let steps = (angle_between(here, there) / CHOICE_STEP_RAD)
                .ceil()
                .max(1.0);
            for step in 1..=(steps as u32) {
                let part = f64::from(step) / steps;
                wanted.push(self.wanted(between(here, there, part)));
                places.push((turn, part));
            }
            here = there;
        }
        // Choose the solutions over the whole list, then halve where linear joints leave the circle.
        let angles = self.through(from, Some(self.direction(from)), &wanted)?;
        let mut steps = Vec::new();
        let mut before = (self.direction(from), from, 0.0);
        for (((turn, part), wanted), angles) in places.into_iter().zip(&wanted).zip(angles) {
            // A place of the same turn goes on from the last; a new turn begins at 0.
            let start = if before.2 < part { before.2 } else { 0.0 };
            self.refine(
                before.0,
                before.1,
                wanted.direction,
                angles,
                (turn, start, part),
                MAX_STEP_HALVINGS,
                &mut steps,
            )?;
            before = (wanted.direction, angles, part);
        }
        Ok(steps)
    }

    /// Halves a step until the tool stays near the great circle.
    #[allow(clippy::too_many_arguments)]
    fn refine(
        &self,
        here: [f64; 3],
        from: Angles,
        there: [f64; 3],
        to: Angles,
        (turn, start, part): (usize, f64, f64),
        halvings: u32,
        out: &mut Vec<OrientedStep>,
    ) -> Result<(), OrientError> {
        let leaves = self.leaves(here, from, there, to);
        if leaves <= self.tolerance_rad {
            out.push(OrientedStep {
                turn,
                part,
                angles: to,
            });
            return Ok(());
        }
        let jump = || OrientError::Jump {
            direction: there,
            leaves_deg: deg(leaves),
            tolerance_deg: deg(self.tolerance_rad),
        };
        // No shorter step helps: the joints would have to change over here.
        if halvings == 0 || angle_between(here, there) == 0.0 {
            return Err(jump());
        }
        // Halve on the great circle, so that the tool is exact in the middle, too.
        let middle = between(here, there, 0.5);
        let wanted = self.wanted(middle);
        let angles = self
            .nearest([(here, from), (there, to)], &wanted)
            .ok_or_else(jump)?;
        let half = 0.5 * (start + part);
        self.refine(
            here,
            from,
            middle,
            angles,
            (turn, start, half),
            halvings - 1,
            out,
        )?;
        self.refine(
            middle,
            angles,
            there,
            to,
            (turn, half, part),
            halvings - 1,
            out,
        )
    }

    /// The position between two places, directions with their angles, that turns least from the one
    /// and to the other: of the solution that both stand on, since what lies nearer may be the
    /// other one, which leads away from there.
    fn nearest(
        &self,
        [(here, from), (there, to)]: [([f64; 3], Angles); 2],
        wanted: &Wanted,
    ) -> Option<Angles> {
        let away = |a: &Angles| {
            (0..2)
                .map(|i| (a[i] - from[i]).abs() + (a[i] - to[i]).abs())
                .sum::<f64>()
        };
        // Both ends on the same solution: the middle has to be on it, too.
        let branch = match (self.branch_at(from, here), self.branch_at(to, there)) {
            (Some(a), Some(b)) if a != b => None,
            (a, b) => a.or(b),
        };
        let solutions = self.solutions(wanted.direction);
        let allowed = solutions
            .iter()
            .enumerate()
            .filter(|(index, _)| branch.is_none_or(|branch| branch == *index));
        let candidates = allowed.flat_map(|(_, solution)| {
            [from, to]
                .into_iter()
                .flat_map(|near| self.positions(near, wanted, solution))
        });
        candidates.min_by(|a, b| away(a).total_cmp(&away(b)))
    }

    /// How far the tool leaves the great circle between two directions while the joints go
    /// linearly, rad.
    pub(crate) fn leaves(&self, here: [f64; 3], from: Angles, there: [f64; 3], to: Angles) -> f64 {
        let places = (0..=CHECKS_PER_STEP).map(|check| {
            let part = f64::from(check) / f64::from(CHECKS_PER_STEP);
            from_arc(
                here,
                there,
                self.direction([0, 1].map(|i| from[i] + part * (to[i] - from[i]))),
            )
        });
        places.fold(0.0, f64::max)
    }
}

/// A direction part of the way along the great circle from one to another.
pub(crate) fn between(a: [f64; 3], b: [f64; 3], part: f64) -> [f64; 3] {
    let angle = angle_between(a, b);
    let side = unit(add(b, scale(a, -dot(a, b))));
    // Of opposite directions any great circle will do.
    let side = side.unwrap_or_else(|| {
        if angle < 1.0 {
            [0.0; 3]
        } else {
            lostmotion_base::vec::across(a)
        }
    });
    let (sin, cos) = math::sin_cos(part * angle);
    let v = add(scale(a, cos), scale(side, sin));
    if part >= 1.0 { b } else { unit(v).unwrap_or(a) }
}

/// Angle between a direction and the arc of the great circle between two others, rad.
fn from_arc(a: [f64; 3], b: [f64; 3], d: [f64; 3]) -> f64 {
    let ends = angle_between(a, d).min(angle_between(b, d));
    let Some(normal) = unit(cross(a, b)) else {
        return ends;
    };
    // Inside the arc's span the distance is that from its plane.
    let inside = dot(cross(normal, a), d) >= 0.0 && dot(cross(b, normal), d) >= 0.0;
    if inside {
        math::asin(dot(normal, d).clamp(-1.0, 1.0)).abs().min(ends)
    } else {
        ends
    }
}
