//! From one pace to another in the shortest time that the joints' limits allow.
//!
//! The plan p goes by its own time sigma at the pace w = d sigma / dt. With u and r, the first and
//! second derivative of w by real time, a joint has the velocity p' w, the acceleration p'' w2 + p'
//! u and the jerk p''' w3 + 3 p'' w u + p' r. A ramp takes the most of r that all joints leave,
//! then the most of u, and turns round just in time to arrive with u = 0. Whether it keeps every
//! limit is checked afterwards, all along.
//!
//! Behind the ramps stands the choice among them: which change of pace to make, and when.

use super::course::{Course, CoursePlace, PaceState};
use lostmotion_base::root::Bracket;

/// Real time from one choice of r to the next, s. A choice: a quarter of the usual command cycle;
/// shorter follows the limits closer and costs time.
const STEP_S: f64 = 2.5e-4;
/// The pace may change by 1 in no less than about twice this time, s: where joints rest, nothing
/// else would bound it.
const SWIFTEST_PACE_S: f64 = 4e-3;
/// Part of the limits of acceleration and jerk that is used, since they are evaluated in the middle
/// of each step. A choice: nearer to 1 limits are passed within a step, farther ramps take longer.
const PLANNED_PART: f64 = 0.998;
/// Halvings of the step in which a ramp turns round: to 1e-9 of it.
const TURN_HALVINGS: usize = 30;
/// Part of a limit up to which it counts as kept: 1 and rounding.
const LIMIT_ROUNDING: f64 = 1.0 + 1e-9;
/// Longest ramp, in steps: one second.
const MAX_PIECES: usize = 4000;
/// Difference from a pace up to which it is reached, and speed backward that is rounding.
const PACE_TOLERANCE: f64 = 1e-9;
/// Paces outside which a ramp is given up: backward, or faster than any override asks for.
const PACE_RANGE: [f64; 2] = [-0.5, 4.0];

/// A state, and what happens from there for how long.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct RampPiece {
    pub(super) from: PaceState,
    pub(super) lasts_s: f64,
    pub(super) r: f64,
}

/// A change of pace.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Ramp {
    pub(super) pieces: Vec<RampPiece>,
    pub(super) end: PaceState,
}

impl Ramp {
    pub(super) fn lasts_s(&self) -> f64 {
        self.pieces.iter().map(|piece| piece.lasts_s).sum()
    }

    /// This ramp and another one from where it ends.
    fn then(mut self, next: Ramp) -> Ramp {
        self.pieces.extend(next.pieces);
        Ramp {
            pieces: self.pieces,
            end: next.end,
        }
    }

    /// The state at a time since its start, and how long it has been over.
    pub(super) fn at(&self, mut t: f64, step_s: f64) -> (PaceState, Option<f64>) {
        for piece in &self.pieces {
            if t < piece.lasts_s {
                return (piece.from.after(t, piece.r, step_s), None);
            }
            t -= piece.lasts_s;
        }
        (self.end, Some(t))
    }
}

/// How hard a ramp uses the limits.
#[derive(Clone, Copy, Debug)]
pub(super) struct Effort<'a> {
    pub(super) course: &'a Course,
    /// Part of the most that the pace may change by.
    pub(super) part: f64,
    /// What of r a joint that moves may count on, 1/s2.
    pub(super) reach: f64,
}

/// The least and largest x with |c + slope x| within a limit for every c between two.
fn room(c: [f64; 2], slope: f64, limit: f64) -> [f64; 2] {
    let [a, b] = [(-limit - c[0]) / slope, (limit - c[1]) / slope];
    if slope > 0.0 {
        [a, b]
    } else {
        [(limit - c[1]) / slope, (-limit - c[0]) / slope]
    }
}

impl Effort<'_> {
    /// The least and largest r that all joints allow.
    fn jerk_room(place: &CoursePlace, w: f64, u: f64) -> [f64; 2] {
        let most = 1.0 / (SWIFTEST_PACE_S * SWIFTEST_PACE_S);
        let mut all = [-most, most];
        for joint in place.joints().iter().filter(|joint| joint.v != 0.0) {
            // The jerk without r, for the range of p'''; p' r comes on top.
            let c = joint.j.map(|j| (j * w * w + 3.0 * joint.a * u) * w);
            let [low, high] = room(c, joint.v, PLANNED_PART * joint.limits[2]);
            all = [all[0].max(low), all[1].min(high)];
        }
        // Where no r suits all joints, the middle; the ramp is judged as a whole later.
        if all[0] <= all[1] {
            all
        } else {
            [0.5 * (all[0] + all[1]); 2]
        }
    }

    /// The least and largest u. Where a joint hardly moves, r does not reach its jerk, and 3 p'' w
    /// u alone has to keep within it.
    fn rate_room(&self, place: &CoursePlace, w: f64) -> [f64; 2] {
        let most = 1.0 / SWIFTEST_PACE_S;
        let mut all = [-most, most];
        let mut meet = |[low, high]: [f64; 2]| all = [all[0].max(low), all[1].min(high)];
        for joint in place.joints() {
            // Acceleration p'' w^2 + p' u.
            if joint.v != 0.0 {
                meet(room(
                    [joint.a * w * w; 2],
                    joint.v,
                    PLANNED_PART * joint.limits[1],
                ));
            }
            let slope = 3.0 * joint.a * w;
            // Jerk 3 p'' w u, of which r can take back what p' reaches.
            if slope != 0.0 {
                let reach = joint.v.abs() * self.reach;
                meet(room(
                    joint.j.map(|j| j * w * w * w),
                    slope,
                    PLANNED_PART * joint.limits[2] + reach,
                ));
            }
        }
        all
    }

    /// The r that changes the pace to one side as fast as it may, where the next choice comes after
    /// a time.
    fn hardest(&self, state: &PaceState, up: bool, t: f64) -> f64 {
        let step_s = self.course.step_s;
        // The jerk is evaluated in the middle of the step, the room for u at its end.
        let middle = state.after(0.5 * t, 0.0, step_s);
        let [low, high] = Self::jerk_room(&self.course.at(middle.sigma), middle.w, middle.u);
        let end = state.after(t, 0.0, step_s);
        let [least, most] = self.rate_room(&self.course.at(end.sigma), end.w);
        let soft = |r: f64, forced: bool| if forced { r } else { self.part * r };
        if up {
            soft(high, high < 0.0)
                .min((self.part * most - state.u) / t)
                .max(low)
        } else {
            soft(low, low > 0.0)
                .max((self.part * least - state.u) / t)
                .min(high)
        }
    }

    /// From a state to a steady pace, as fast as may be; `None` where the plan is not known far
    /// enough.
    fn level(&self, from: PaceState, pieces: &mut Vec<RampPiece>) -> Option<PaceState> {
        let (mut state, step_s) = (from, self.course.step_s);
        let last = self.course.end()?;
        let up = from.u < 0.0;
        while state.u != 0.0 {
            let r = self.hardest(&state, up, STEP_S);
            // The step in which u gets to zero ends there.
            let crosses = if up {
                state.u + r * STEP_S >= 0.0
            } else {
                state.u + r * STEP_S <= 0.0
            };
            let t = if crosses { -state.u / r } else { STEP_S };
            pieces.push(RampPiece {
                from: state,
                lasts_s: t,
                r,
            });
            state = state.after(t, r, step_s);
            if crosses {
                state.u = 0.0;
            }
            // It does not arrive: too many steps, out of range, or beyond the known plan.
            if pieces.len() > MAX_PIECES
                || state.w < PACE_RANGE[0]
                || state.w > PACE_RANGE[1]
                || (state.sigma > last && !self.course.complete)
            {
                return None;
            }
        }
        Some(state)
    }

    /// The pace that it would arrive at by turning round at once; out of the way where it does not
    /// arrive.
    fn arrives(&self, from: PaceState, up: bool) -> f64 {
        let lost = if up { f64::INFINITY } else { f64::NEG_INFINITY };
        self.level(from, &mut Vec::new())
            .map_or(lost, |state| state.w)
    }

    /// The fastest way from a state to a pace; `None` where it cannot be had, or passes a limit.
    pub(super) fn ramp(&self, from: PaceState, target: f64) -> Option<Ramp> {
        let up = self.level(from, &mut Vec::new())?.w < target;
        let beyond = |state: PaceState| {
            let w = self.arrives(state, up);
            if up { w > target } else { w < target }
        };
        // As hard as may be to one side, then back to a steady pace: the later it turns round, the
        // farther it gets.
        let mut pieces = self.trunk(from, target, up);
        // The first piece after which turning round arrives beyond the target.
        let end = |piece: &RampPiece, t: f64| piece.from.after(t, piece.r, self.course.step_s);
        let turn = pieces.partition_point(|piece| !beyond(end(piece, piece.lasts_s)));
        let last = *pieces.get(turn)?;
        let lasts_s = Bracket::new(0.0, last.lasts_s)
            .bisect(TURN_HALVINGS, |t| !beyond(end(&last, t)))
            .low;
        pieces.truncate(turn);
        pieces.push(RampPiece { lasts_s, ..last });
        let arrived = self.level(end(&last, lasts_s), &mut pieces)?;
        // Only now all limits are checked, all along.
        let near = (arrived.w - target).abs() <= PACE_TOLERANCE;
        let keeps = near && pieces.iter().all(|piece| self.keeps(piece));
        keeps.then_some(Ramp {
            pieces,
            end: PaceState {
                w: target,
                u: 0.0,
                ..arrived
            },
        })
    }

    /// As hard as may be to one side, until that passes a limit or the target.
    fn trunk(&self, from: PaceState, target: f64, up: bool) -> Vec<RampPiece> {
        let mut pieces = Vec::new();
        let mut state = from;
        while pieces.len() < MAX_PIECES
            && (self.course.complete || self.course.end().is_some_and(|last| state.sigma < last))
        {
            let piece = RampPiece {
                from: state,
                lasts_s: STEP_S,
                r: self.hardest(&state, up, STEP_S),
            };
            pieces.push(piece);
            state = state.after(STEP_S, piece.r, self.course.step_s);
            let through = if up {
                state.w > target && state.u > 0.0
            } else {
                state.w < target && state.u < 0.0
            };
            if through || !self.keeps(&piece) {
                break;
            }
        }
        pieces
    }

    /// Whether a piece keeps every limit, and does not go backward.
    fn keeps(&self, piece: &RampPiece) -> bool {
        [0.0, 0.5, 1.0].into_iter().all(|part| {
            let PaceState { sigma, w, u } =
                piece
                    .from
                    .after(part * piece.lasts_s, piece.r, self.course.step_s);
            let place = self.course.at(sigma);
            w >= -PACE_TOLERANCE
                && place.joints().iter().all(|joint| {
                    let [v, a, j] = joint.limits.map(|limit| limit * LIMIT_ROUNDING);
                    let jerk = joint
                        .j
                        .map(|jerk| (jerk * w * w + 3.0 * joint.a * u) * w + joint.v * piece.r);
                    (joint.v * w).abs() <= v
                        && (joint.a * w * w + joint.v * u).abs() <= a
                        && jerk[0].abs().max(jerk[1].abs()) <= j
                })
        })
    }
}

/// Command cycles that a change may wait for a place where it can be made, if that makes it sooner
/// done.
const WAIT_CYCLES: [u32; 22] = [
    0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 64, 80, 96,
];
/// Parts of the most that the pace may change by that are tried, each with the part of the least
/// reach that joints which hardly move may count on.
const EFFORTS: [[f64; 2]; 8] = [
    [1.0, 0.5],
    [1.0, 0.0],
    [0.85, 0.0],
    [0.7, 0.0],
    [0.55, 0.0],
    [0.4, 0.0],
    [0.25, 0.0],
    [0.12, 0.0],
];
/// Parts of the pace aimed at that are tried where the plan leaves no room for all of it; the rest
/// follows with a later change.
const GOAL_PARTS: [f64; 9] = [1.0, 0.99, 0.97, 0.93, 0.85, 0.7, 0.5, 0.3, 0.1];
/// Parts of a fall that are left by a ramp before the one that does the rest. A choice: one of them
/// nearly always finds room at once.
const FIRST_PARTS: [f64; 4] = [0.97, 0.9, 0.8, 0.6];
/// Difference from a pace up to which it is reached.
pub(super) const PACE_SLACK: f64 = 1e-6;

/// A change of pace that begins after `wait` command cycles.
#[derive(Clone, Debug)]
pub(super) struct Aim {
    pub(super) wait: u32,
    pub(super) ramp: Ramp,
}

/// The best change to a pace found: for less pace the one that is done first, for more the one that
/// gets nearest. `after` tells the state after a number of command cycles if nothing changes;
/// `None` if that is not known.
pub(super) fn aim(
    course: &Course,
    target: f64,
    period_s: f64,
    after: &dyn Fn(u32) -> Option<PaceState>,
) -> Option<Aim> {
    let now = after(0)?;
    if now.w < target {
        rise(course, target, &now)
    } else {
        fall(course, target, period_s, after)
    }
}

/// From the hardest to the gentlest.
fn efforts(course: &Course) -> impl Iterator<Item = Effort<'_>> {
    let reach = course.reach();
    EFFORTS.into_iter().map(move |[part, of]| Effort {
        course,
        part,
        reach: of * reach,
    })
}

fn fall(
    course: &Course,
    target: f64,
    period_s: f64,
    after: &dyn Fn(u32) -> Option<PaceState>,
) -> Option<Aim> {
    let mut best: Option<(f64, Aim)> = None;
    for wait in WAIT_CYCLES {
        // Later starts cannot be done before the best one found.
        let waited_s = f64::from(wait) * period_s;
        if best.as_ref().is_some_and(|(least, _)| waited_s >= *least) {
            break;
        }
        let Some(from) = after(wait) else { break };
        let direct = efforts(course).find_map(|effort| effort.ramp(from, target));
        // The jerk falls with the third power of the pace: where the plan leaves no room to brake at
        // once, a little less pace makes it.
        let in_two = FIRST_PARTS.into_iter().filter_map(|part| {
            let goal = target + part * (from.w - target);
            let first = efforts(course).find_map(|effort| effort.ramp(from, goal))?;
            let then = efforts(course).find_map(|effort| effort.ramp(first.end, target))?;
            Some(first.then(then))
        });
        for ramp in direct.into_iter().chain(in_two) {
            let done_s = waited_s + ramp.lasts_s();
            if best.as_ref().is_none_or(|(least, _)| done_s < *least) {
                best = Some((done_s, Aim { wait, ramp }));
            }
        }
    }
    best.map(|(_, aim)| aim)
}

fn rise(course: &Course, target: f64, now: &PaceState) -> Option<Aim> {
    let goals = GOAL_PARTS
        .into_iter()
        .map(|part| part * target)
        .filter(|goal| *goal > now.w + PACE_SLACK);
    // The nearest goal first, each with the hardest effort first.
    let mut tries = goals.flat_map(|goal| efforts(course).map(move |effort| (goal, effort)));
    tries
        .find_map(|(goal, effort)| effort.ramp(*now, goal))
        .map(|ramp| Aim { wait: 0, ramp })
}
