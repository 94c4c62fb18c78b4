//! When what is known of the gap is used, and how far.
//!
//! 1. Only where friction certainly holds the load. A load without friction floats between the flanks
//!    at the speed that its last contact left it, and the motor does not show where it is: a
//!    traverse that is right for a load on its flank releases it there, or pushes it. With
//!    everything told (`lookup`) such loads leave a larger peak than no compensation in seven of
//!    eight drawn cells; so they are left alone.
//! 2. Only where the inertia is known so well that the change of the flank can be foreseen: a twin whose
//!    inertia is wrong crosses the gap too early or too late, and the load is thrown. Where the axis
//!    is slow the inertia hardly matters, and where it rests not at all. Nor can it be foreseen where a soft shaft
//!    swings by more than the motion needs, so that its torque presses the other flank for a good part of the time: when it
//!    does depends on stiffness and gap by more than anyone knows them.
//! 3. Only as far as the axes that move with it. The errors of two axes of a slanted line or an arc
//!    partly cancel across it, so that one axis set right alone can be worse than neither; both by
//!    the same share never is.
//!
//! An axis that rests while others come and go has an error across theirs, which adds to the contour's whatever they
//! do: once in such a rest its load is put in its place without a wait for them, and what is known too little for
//! motion is used.
//!
//! An axis that hardly moves, as the tool's does behind its plunge, may never show its friction. The slides
//! of a machine are of one kind: where it rests for long beside axes that are ready it is taken to hold its
//! load as they do, unless its own friction is certainly less, and until it moves.
//!
//! ```text
//! held      from  H - 2 s > 0.005 T_rated (3 s with a memory)  until  H + 2 s < 0.005 T_rated;   after 2 s at rest or in a rest aside, the others ready, while  H + 2 s > 0.005 T_rated              H: T_f - max(0, |T_const| - s_c) (|T_const| with a memory);   s, s_c: standard deviations of T_f, T_const
//! foreseen  s_J < 0.1 J, once for good;   or s_J a < 0.12 T_f;   or w^2/(2 a) < 0.1 b;   and of late the shaft swung against the need for less than 1/4 of the time;   or at rest           s_J: standard deviation of J; w, a: largest of late, fading in 4 s
//! used      b min(allowed, least readiness of the others); b allowed once in a rest aside      readiness: 1 with a gap that is used, else 0
//! ```

use crate::memory::{CERTAIN_DEVIATIONS, HOLDING_SHARE};
use lostmotion_base::Clock;
use lostmotion_drive::Heeded;
use lostmotion_drive::signal::Reference;
use lostmotion_drive::twin::LoadModel;
use serde::{Deserialize, Serialize};

/// Standard deviations by which friction has to be above it while learning, or below it to let go. A choice:
/// 1 in 40.
const LEARNING_DEVIATIONS: f64 = 2.0;
/// Standard deviation of the inertia, part of it, with which changes of the flank can be foreseen.
/// Tuned on drawn cells: 17 % threw a load (20261124-10).
const CERTAIN_INERTIA: f64 = 0.1;
/// Part of the friction that the uncertain part of the inertia's torque may be. Tuned on drawn cells:
/// 0.25 let a load be thrown (990019-8), 0.05 left slow axes alone for long.
const UNCERTAIN_TORQUE: f64 = 0.12;
/// Part of the half gap that the way of speeding up may be for the inertia not to matter. A choice.
const SHORT_RAMP: f64 = 0.1;

/// Rest after which an axis is taken to hold its load as others do, a reading that does not count alone
/// is used, and a control waits no longer for the axis to come back, s. A choice: longer than pauses; at once a
/// square whose axes rest in turn is made worse (808-21).
pub const LONG_REST_S: f64 = 2.0;
/// How often an axis has to come back to have moved to and fro. A choice: the tool's axis goes up and down
/// once before it cuts, at one feed.
const LEAST_RETURNS: u32 = 2;
/// Time constant with which the largest speed and acceleration fade, s. A choice: a rapid is forgotten in a
/// slow cut, and a corner not before the next one.
const FADING_S: f64 = 4.0;

/// Part of the time of late in which a swinging shaft may decide the flank, and until which it may again once it did for
/// longer. On a flank that was foreseen wrongly a load is a whole gap off, without a correction half of one: four times
/// the square, so that with a quarter of the time nothing is gained. Half of that is a choice.
const SWINGING: [f64; 2] = [0.25, 0.125];

/// Standard deviations that are allowed for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Deviations {
    /// By which friction has to be above what holds a load, and below it to let go.
    pub(super) holds: f64,
    pub(super) lets_go: f64,
    /// By which a constant torque may be less than it seems.
    pub(super) pulls: f64,
}

/// Whether the gap of an axis is used, by itself and beside the others.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Trust {
    /// Whether friction certainly holds the load.
    held: bool,
    /// Whether the gap is too small to matter.
    pub(super) nil: bool,
    /// Whether it is taken to hold its load as the axes do that move beside it.
    held_as_others: bool,
    /// Whether the reference moves, and servo ticks since it last did.
    moves: bool,
    rested: u32,
    /// Sign of the last speed of the reference, 0 before it moves, and how often it came back.
    way: i8,
    returns: u32,
    /// The flank, 0 before the first, and whether it has changed since the start.
    side: i8,
    changed: bool,
    /// Largest speed (rad/s) and acceleration (rad/s2) of the reference of late.
    most: [f64; 2],
    /// Whether the inertia is known well, and whether changes of the flank can be foreseen.
    certain: bool,
    foreseen: bool,
    /// Part of the time of motion of late in which the swinging shaft decided the flank, and whether that is too much.
    swinging: f64,
    swings: bool,
    /// What the control allows.
    allowed: f64,
    /// Whether the control waits, and lets correct only who rests aside.
    waits: bool,
    /// Whether it rests while others come and go, and whether it has corrected in this rest as all of them may.
    aside: bool,
    placed: bool,
    /// Least readiness of the other axes; `None` where none of them matters.
    others: Option<f64>,
    /// Whether it began with a memory.
    remembers: bool,
}

impl Trust {
    /// Nothing is known yet.
    pub(super) const NONE: Trust = Trust {
        held: false,
        nil: false,
        held_as_others: false,
        moves: false,
        rested: 0,
        way: 0,
        returns: 0,
        side: 0,
        changed: false,
        most: [0.0; 2],
        certain: false,
        foreseen: false,
        swinging: 0.0,
        swings: false,
        allowed: 1.0,
        waits: false,
        aside: false,
        placed: false,
        others: None,
        remembers: false,
    };

    /// From what is known already: whether friction holds the load, and whether the gap is too small
    /// to matter.
    pub(super) fn remembering(held: bool, nil: bool) -> Trust {
        Trust {
            held,
            nil,
            certain: true,
            foreseen: true,
            remembers: true,
            ..Trust::NONE
        }
    }

    /// How sure it has to be that friction holds a load, more where a memory says so, since it is used without
    /// a proof, and what pulls the load has been told apart from friction.
    pub(super) fn deviations(&self) -> Deviations {
        let [holds, pulls] = if self.remembers {
            [CERTAIN_DEVIATIONS, 0.0]
        } else {
            [LEARNING_DEVIATIONS, 1.0]
        };
        Deviations {
            holds,
            lets_go: LEARNING_DEVIATIONS,
            pulls,
        }
    }

    /// Whether friction certainly holds the load.
    pub(super) fn is_held(&self) -> bool {
        self.held
    }

    /// Whether it has moved to and fro: what pulls one way is told from friction then.
    pub(super) fn moved_both_ways(&self) -> bool {
        self.returns >= LEAST_RETURNS
    }

    /// Whether it has rested for long, or rests while others come and go.
    pub(super) fn rests_long(&self) -> bool {
        self.aside || f64::from(self.rested) * Clock::SERVO.period_s() > LONG_REST_S
    }

    /// Whether its load is put in its place whatever the others know: once in a rest aside.
    fn is_alone(&self) -> bool {
        self.aside && !self.placed
    }

    /// Takes whether a gap is used at rest.
    pub(super) fn places(&mut self, used: bool) {
        self.placed = !self.moves && (self.placed || used && !self.aside);
    }

    /// Whether changes of the flank can be foreseen.
    pub(super) fn foresees(&self) -> bool {
        self.foreseen && !self.swings || !self.moves
    }

    /// How far the control and the other axes let it correct.
    pub(super) fn allowed(&self) -> f64 {
        let others = if self.is_alone() {
            1.0
        } else if self.waits {
            0.0
        } else {
            self.others.unwrap_or(1.0)
        };
        self.allowed.min(others)
    }

    /// The part of a known gap that is used.
    #[inline(always)]
    pub(super) fn share(&self) -> f64 {
        self.own(1.0).min(self.allowed())
    }

    /// Whether [`Trust::step`] decides nothing new with this reference and flank: the axis moves on the same way, on
    /// the same flank. What friction may exceed has to be as it was, too.
    #[inline(always)]
    pub(super) fn goes_on(&self, reference: &Reference, side: i8) -> bool {
        let onward = if self.way > 0 {
            reference.velocity > 0.0
        } else {
            reference.velocity < 0.0
        };
        self.moves && onward && side == self.side
    }

    /// Takes the reference and the flank of a tick, and the least and the most that Coulomb friction
    /// may exceed a constant torque, parts of the rated torque.
    #[inline(always)]
    pub(super) fn step(&mut self, reference: &Reference, side: i8, [least, most]: [f64; 2]) {
        self.held = if self.held {
            most > HOLDING_SHARE
        } else {
            least > HOLDING_SHARE
        };
        self.moves = reference.velocity != 0.0;
        self.aside &= !self.moves;
        self.rested = if self.moves {
            0
        } else {
            self.rested.saturating_add(1)
        };
        if self.moves {
            let way = if reference.velocity > 0.0 { 1 } else { -1 };
            self.returns = self.returns.saturating_add(u32::from(way == -self.way));
            self.way = way;
        }
        // where all of them rest for a moment, what was taken stands
        let as_others = self
            .others
            .map_or(self.held_as_others, |ready| ready == 1.0);
        self.held_as_others = self.rests_long() && as_others && most > HOLDING_SHARE;
        // the first flank is no change
        self.changed |= self.side != 0 && side != self.side;
        self.side = side;
    }

    /// Takes the load, the standard deviation of its inertia as a part of it (0 where readings agree on
    /// it), and the half gap (rad).
    #[inline(always)]
    pub(super) fn weigh(
        &mut self,
        reference: &Reference,
        load: &LoadModel,
        inertia_doubt: f64,
        half_gap: f64,
    ) {
        let [speed, acceleration] = &mut self.most;
        let fades = 1.0 - Clock::SERVO.period_s() / FADING_S;
        *speed = (*speed * fades).max(reference.velocity.abs());
        *acceleration = (*acceleration * fades).max(reference.acceleration.abs());
        // for good: while a load bounces its inertia is in doubt time and again
        self.certain |= inertia_doubt < CERTAIN_INERTIA;
        let uncertain = inertia_doubt * load.inertia * *acceleration;
        self.foreseen = self.certain
            || uncertain < UNCERTAIN_TORQUE * load.coulomb
            || 0.5 * *speed * *speed < SHORT_RAMP * half_gap * *acceleration;
    }

    /// Takes whether the swinging shaft decides the flank, against what the motion needs; `None` where that is not
    /// known.
    #[inline(always)]
    pub(super) fn swing(&mut self, swings: Option<bool>) {
        let Some(swings) = swings else { return };
        let now = if swings { 1.0 } else { 0.0 };
        self.swinging += Clock::SERVO.period_s() / FADING_S * (now - self.swinging);
        let [most, again] = SWINGING;
        self.swings = self.swinging > if self.swings { again } else { most };
    }

    /// How far this axis is ready, where it matters to others: it moves, its load changes flanks, and
    /// there is a gap. `half_gap`: the one to use, 0 while it is unknown.
    pub(super) fn readiness(&self, half_gap: f64) -> Option<f64> {
        (self.moves && self.changed && !self.nil).then_some(self.own(half_gap))
    }

    fn own(&self, half_gap: f64) -> f64 {
        if (self.held || self.held_as_others) && self.foresees() && half_gap > 0.0 {
            1.0
        } else {
            0.0
        }
    }

    /// The half gap that is used once the other axes are ready, in its unit: 0 where there is none to
    /// speak of, `None` while it is not known, or friction does not certainly hold the load, or
    /// its changes of flank cannot be foreseen.
    #[inline(always)]
    pub(super) fn known(&self, half_gap: f64) -> Option<f64> {
        if self.nil {
            return Some(0.0);
        }
        (self.own(half_gap) > 0.0).then_some(half_gap)
    }

    /// Takes what the control allows, and the least readiness of the other axes.
    pub(super) fn heed(&mut self, heeded: Heeded) {
        self.allowed = heeded.allowed.clamp(0.0, 1.0);
        self.waits = heeded.waits;
        self.others = heeded.others.map(|others| others.clamp(0.0, 1.0));
        self.aside = !self.moves && heeded.aside;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MOVING: Reference = Reference {
        position: 0.0,
        velocity: 1.0,
        acceleration: 0.0,
    };

    #[test]
    fn a_gap_is_used_once_friction_holds_the_load_until_it_certainly_does_not() {
        let mut trust = Trust {
            foreseen: true,
            ..Trust::NONE
        };
        for (friction, expected) in [
            ([-0.01, 0.05], 0.0),
            ([0.01, 0.03], 1.0),
            ([-0.02, 0.06], 1.0),
            ([-0.001, 0.004], 0.0),
        ] {
            trust.step(&MOVING, 1, friction);
            assert_eq!(trust.share(), expected, "{friction:?}");
        }
    }

    #[test]
    fn two_axes_are_compensated_by_the_same_share() {
        let foreseen = Trust {
            foreseen: true,
            ..Trust::NONE
        };
        let (mut ready, mut learning) = (foreseen, foreseen);
        for side in [1, -1] {
            ready.step(&MOVING, side, [0.01, 0.03]);
            learning.step(&MOVING, side, [-0.01, 0.05]);
        }
        let told = |trust: &Trust, half_gap| trust.readiness(half_gap).unwrap_or(1.0);
        let (first, second) = (told(&ready, 1.0), told(&learning, 1.0));
        let heeded = |others| Heeded {
            allowed: 1.0,
            waits: false,
            aside: false,
            others: Some(others),
        };
        ready.heed(heeded(second));
        learning.heed(heeded(first));
        assert_eq!((ready.share(), learning.share()), (0.0, 0.0));
        // an axis that stands, or whose load stays on one flank, does not hold the others back
        let rest = Reference::default();
        learning.step(&rest, -1, [-0.01, 0.05]);
        assert_eq!(learning.readiness(1.0), None);
        let mut hanging = Trust::NONE;
        hanging.step(&MOVING, 1, [-0.01, 0.05]);
        hanging.step(&MOVING, 1, [-0.01, 0.05]);
        assert_eq!(hanging.readiness(0.0), None);
    }

    #[test]
    fn after_a_long_rest_a_load_is_held_as_those_that_move_beside_it_until_it_moves() {
        let mut trust = Trust {
            foreseen: true,
            ..Trust::NONE
        };
        let rest = |trust: &mut Trust, seconds: f64, friction| {
            for _ in 0..(seconds / Clock::SERVO.period_s()) as usize {
                trust.step(&Reference::default(), 1, friction);
            }
            trust.share()
        };
        let heeded = |others| Heeded {
            allowed: 1.0,
            waits: false,
            aside: false,
            others,
        };
        let (unknown, slippery) = ([-0.01, 0.05], [-0.01, 0.004]);
        assert_eq!(rest(&mut trust, 3.0, unknown), 0.0);
        // others that are not ready show nothing; a pause of those that were takes nothing back
        for (others, expected) in [
            (Some(0.0), 0.0),
            (Some(1.0), 1.0),
            (None, 1.0),
            (Some(0.5), 0.0),
        ] {
            trust.heed(heeded(others));
            assert_eq!(rest(&mut trust, 0.1, unknown), expected, "{others:?}");
        }
        trust.heed(heeded(Some(1.0)));
        assert_eq!(rest(&mut trust, 0.1, unknown), 1.0);
        assert_eq!(rest(&mut trust, 0.1, slippery), 0.0);
        assert_eq!(rest(&mut trust, 0.1, unknown), 1.0);
        // it is not said to hold its load, and in motion it has to show so
        assert!(!trust.is_held());
        trust.step(&MOVING, 1, unknown);
        assert_eq!(trust.share(), 0.0);
        assert_eq!(rest(&mut trust, 1.9, unknown), 0.0);
        assert_eq!(rest(&mut trust, 0.2, unknown), 1.0);
        // what the control allows bounds it
        trust.heed(Heeded {
            allowed: 0.3,
            waits: false,
            aside: false,
            others: Some(1.0),
        });
        assert_eq!(rest(&mut trust, 0.1, unknown), 0.3);
    }

    #[test]
    fn who_rests_aside_waits_for_nobody_once() {
        let mut trust = Trust {
            held: true,
            foreseen: true,
            ..Trust::NONE
        };
        let heeded = |waits, aside| Heeded {
            allowed: 0.5,
            waits,
            aside,
            others: None,
        };
        let rest = |trust: &mut Trust| {
            trust.step(&Reference::default(), 1, [0.01, 0.03]);
            trust.places(trust.share() > 0.0);
            trust.share()
        };
        trust.heed(heeded(true, false));
        assert_eq!(rest(&mut trust), 0.0);
        assert!(!trust.rests_long());
        trust.heed(heeded(true, true));
        assert_eq!(rest(&mut trust), 0.5);
        assert!(trust.rests_long());
        trust.step(&MOVING, 1, [0.01, 0.03]);
        trust.places(false);
        assert_eq!(trust.share(), 0.0);
        // what corrected in this rest as all of them may waits as they do
        trust.heed(heeded(false, false));
        assert_eq!(rest(&mut trust), 0.5);
        trust.heed(heeded(true, true));
        assert_eq!(rest(&mut trust), 0.0);
    }

    #[test]
    fn a_shaft_that_decides_the_flank_for_a_quarter_of_the_time_is_not_foreseen() {
        let mut trust = Trust {
            foreseen: true,
            moves: true,
            ..Trust::NONE
        };
        // of every 20 ms so many; a tick of which nothing is known changes nothing
        let swing = |trust: &mut Trust, ticks: usize| {
            for tick in 0..(20.0 / Clock::SERVO.period_s()) as usize {
                trust.swing(Some(tick % 80 < ticks));
                trust.swing(None);
            }
            trust.foresees()
        };
        for (ticks, expected) in [(15, true), (30, false), (15, false), (5, true), (15, true)] {
            assert_eq!(swing(&mut trust, ticks), expected, "{ticks}");
        }
        assert!(!swing(&mut trust, 40));
        trust.moves = false;
        assert!(trust.foresees());
    }

    #[test]
    fn an_inertia_in_doubt_is_waited_for_where_it_matters() {
        let load = LoadModel {
            inertia: 0.01,
            viscous: 0.0,
            coulomb: 1.0,
            constant: 0.0,
            stiffness: 1000.0,
            damping: 0.1,
        };
        let at = |velocity, acceleration| Reference {
            position: 0.0,
            velocity,
            acceleration,
        };
        let mut trust = Trust::NONE;
        // 20 % of 0.01 kg m2: 0.1 N m at 50 rad/s2, 0.2 N m at 100
        trust.weigh(&at(5.0, 50.0), &load, 0.2, 1e-3);
        assert!(trust.foreseen);
        trust.weigh(&at(5.0, 100.0), &load, 0.2, 1e-3);
        assert!(!trust.foreseen);
        // what was fast may be again at once; while it rests there is nothing to foresee
        trust.weigh(&at(0.0, 0.0), &load, 0.2, 1e-3);
        assert!(!trust.foreseen && trust.foresees());
        trust.moves = true;
        assert!(!trust.foresees());
        // ten seconds later it is slow: 8 rad/s2 of what was
        for _ in 0..40_000 {
            trust.weigh(&at(0.0, 0.0), &load, 0.2, 1e-3);
        }
        assert!(trust.foreseen);
        trust.weigh(&at(5.0, 100.0), &load, 0.2, 1e-3);
        assert!(!trust.foreseen);
        // a gap that is wide beside the way of speeding up, 0.125 rad
        trust.weigh(&at(0.0, 0.0), &load, 0.2, 1.3);
        assert!(trust.foreseen);
        // once the inertia is known a load that bounces does not put it in doubt
        trust.weigh(&at(0.0, 0.0), &load, 0.05, 1e-3);
        trust.weigh(&at(0.0, 0.0), &load, 0.5, 1e-3);
        assert!(trust.foreseen);
    }
}
