//! Learning the load from the torque that the motor gives beyond its own need.
//!
//! Over 8 ms at a time, every 4 ms, in which the axis moves steadily (15 ms after any reversal,
//! change of flank or crossing), means weighted with a triangle, so that the mean acceleration is
//! an exact second difference of positions and a shaft's ringing cancels:
//! ```text
//! T = K_t i - J_M alpha - b_v w - F_M sign(w)              measured at the motor, N m
//! T = J_L alpha + b_L w + T_f sign(w) + T_const            model of the load
//! ```
//! An acceleration that does not exceed the encoder's noise by four standard deviations counts as
//! zero: as a regressor it would be noise, which biases the inertia towards zero and makes it too
//! certain. What the shaft winds up meanwhile is taken off (`stretch`).
//!
//! Over a reversal, from one steady stretch to the next, the balance of momentum holds whatever
//! happens between (`bridge`). The four unknowns are estimated in `load_filter`.

use super::bridge::{BLOCK_TICKS, Block, Bridge, Crossed};
use super::load_filter::{LEAST_INERTIA, LoadFilter, LoadVector, N, VISCOUS_SPEED};
use super::stretch::{Mean, Row, Shaft, Stretch};
use super::trust::Deviations;
use super::watch::Motor;
use lostmotion_base::Clock;
use lostmotion_drive::Signals;
use lostmotion_drive::twin::{LoadModel, Twin, TwinState};
use serde::{Deserialize, Serialize};

/// Servo ticks that have to pass after a reversal or a change of flank: 15 ms, three periods of a
/// shaft's ringing.
const SETTLE_TICKS: u32 = 60;
/// Blocks after which the load counts as known. A choice: 32 ms; fewer let a single bad block in,
/// more leave the axis uncompensated longer.
const BLOCKS_TO_KNOW: u32 = 8;
/// Part of the load's friction below which the torque behind the motor shows a load without
/// contact. A choice: half way between a sliding load, whose shaft carries all of its friction, and
/// a loose one, whose shaft carries none.
const LOOSE_SHARE: f64 = 0.5;
/// Change of the inertia, part of it, from which on the load that is used is made anew, and that of a torque, part of the
/// rated one. A choice: far below what is known of either; smaller ones make the tables of the twin anew for nothing.
const LEAST_CHANGE: f64 = 1e-3;
const LEAST_TORQUE_CHANGE: f64 = 5e-5;
/// Torque behind the motor below which nothing is in contact, part of the rated torque: far below
/// any friction, above the noise of a block.
const UNLOADED_SHARE: f64 = 1e-3;
/// Speed below which a load does not count as moving, rad/s at the motor. A choice: 64 um/s on a
/// screw of 20 mm; slower, the direction of friction is uncertain.
const MOVING_RAD_S: f64 = 0.02;
/// Largest inertia of a load, over that of the motor. A choice.
pub(super) const LARGEST_INERTIA: f64 = 100.0;

/// Readings whose inertia is held on to. A choice: fewer hold on to chance, more come late.
/// Decision 88 of the book.
const ANCHORS: usize = 4;
/// Ratio of the largest of them to the least up to which they agree. A choice: good readings are
/// within a tenth of the inertia, those that hold a wrong one drift by more.
const ANCHORS_RATIO: f64 = 1.5;
/// Ratio by which the inertia may leave their range. A choice: narrower would not follow a workpiece
/// that is put on, wider lets friction take the error.
const ANCHORED_RATIO: f64 = 1.1;
/// The same of fewer readings. A choice: as far apart as readings may be that agree; loads that bounce
/// took the inertia to ten times within a second (20261124-10, 990019-8).
const FEW_ANCHORED_RATIO: f64 = 1.5;
/// Standard deviations of its own within which a crossing with a correction in use has to find the inertia
/// that is known, so that what it tells of the load is taken over. Measured with 1, 2 and 3 (decision 161): with
/// 1 less is taken over for nothing, 3 is no different.
const CONFIRMING_DEVIATIONS: f64 = 2.0;

/// The filter, and the block or reversal under way.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct LearningState {
    filter: LoadFilter,
    /// Inertia of the load that the last readings found which agree on the gap, over that of the
    /// motor; 0 for none.
    anchors: [f64; ANCHORS],
    blocks: u32,
    /// Whether the load has been learned.
    pub(super) known: bool,
    /// Servo ticks of undisturbed motion, up to [`SETTLE_TICKS`].
    calm: u32,
    twin_speed: f64,
    block: Block,
    before: Option<Block>,
    bridge: Option<Bridge>,
    /// Whether the last pair of blocks showed a load in contact.
    together: bool,
    /// The last means of the present stretch.
    stretch: Stretch,
    /// What a bridge said that ends where the load has yet to show that it is in contact.
    pending: Option<Crossed>,
    /// Whether anything was learned since the last [`LearningState::news`].
    news: bool,
}

/// What the motor shows of the load at a tick: the torque behind the motor (N m), and whether the load may
/// be between its flanks.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) torque: f64,
    pub(super) disturbed: bool,
}

impl LearningState {
    pub(super) fn new() -> LearningState {
        LearningState {
            filter: LoadFilter::new(),
            anchors: [0.0; ANCHORS],
            blocks: 0,
            known: false,
            calm: 0,
            twin_speed: 0.0,
            block: Block::default(),
            before: None,
            bridge: None,
            together: false,
            stretch: Stretch::default(),
            pending: None,
            news: true,
        }
    }

    /// The load is known already, with its covariance in the order of
    /// [`LearningState::covariance`].
    pub(super) fn known(
        load: &LoadModel,
        covariance: &[LoadVector; N],
        inertia: f64,
        rated: f64,
    ) -> LearningState {
        let mean = [load.inertia, load.viscous, load.coulomb, load.constant];
        LearningState {
            filter: LoadFilter::known(&mean, covariance, &units(inertia, rated)),
            anchors: [load.inertia / inertia; ANCHORS],
            blocks: BLOCKS_TO_KNOW,
            known: true,
            ..LearningState::new()
        }
    }

    /// Covariance of inertia, viscous friction, Coulomb friction and constant torque, SI.
    pub(super) fn covariance(&self, inertia: f64, rated: f64) -> [LoadVector; N] {
        self.filter.covariance(&units(inertia, rated))
    }

    /// Takes over what a crossing told of the load, SI.
    pub(super) fn learn(
        &mut self,
        (mean, covariance): &([f64; 4], [[f64; 4]; 4]),
        inertia: f64,
        rated: f64,
    ) {
        self.filter.learn(mean, covariance, &units(inertia, rated));
        self.news = true;
    }

    /// Whether what a crossing told of the load, SI, has the inertia that is known, as closely as it tells it.
    pub(super) fn confirms_inertia(
        &self,
        (mean, covariance): &([f64; 4], [[f64; 4]; 4]),
        inertia: f64,
    ) -> bool {
        let off = mean[0] - self.filter.mean[0] * inertia;
        off * off < CONFIRMING_DEVIATIONS * CONFIRMING_DEVIATIONS * covariance[0][0]
    }

    /// Takes the inertia (over that of the motor) that a reading found which agrees with others; one that
    /// no load has is not held on to.
    pub(super) fn anchor(&mut self, inertia: f64) {
        if !(LEAST_INERTIA..=LARGEST_INERTIA).contains(&inertia) {
            return;
        }
        self.anchors.rotate_right(1);
        self.anchors[0] = inertia;
        self.news = true;
    }

    /// The least and the most inertia that the readings allow, over that of the motor: near what the
    /// last ones found, where they agree, and not far from the first ones.
    fn anchored(&self) -> [f64; 2] {
        let found = || {
            self.anchors
                .iter()
                .copied()
                .filter(|inertia| *inertia > 0.0)
        };
        let ratio = match found().count() {
            0 => return [LEAST_INERTIA, LARGEST_INERTIA],
            ANCHORS if self.is_anchored() => ANCHORED_RATIO,
            ANCHORS => return [LEAST_INERTIA, LARGEST_INERTIA],
            _ => FEW_ANCHORED_RATIO,
        };
        let (least, most) = (found().reduce(f64::min), found().reduce(f64::max));
        [
            least.unwrap_or(LEAST_INERTIA) / ratio,
            most.unwrap_or(LARGEST_INERTIA) * ratio,
        ]
    }

    /// Whether the last readings agree on the inertia of the load.
    pub(super) fn is_anchored(&self) -> bool {
        let [least, most] = self.anchor_range();
        least > 0.0 && most <= ANCHORS_RATIO * least
    }

    fn anchor_range(&self) -> [f64; 2] {
        let fold = |first, of: fn(f64, f64) -> f64| self.anchors.iter().copied().fold(first, of);
        [fold(f64::INFINITY, f64::min), fold(0.0, f64::max)]
    }

    /// Whether anything was learned since this was asked last.
    pub(super) fn news(&mut self) -> bool {
        std::mem::take(&mut self.news)
    }

    /// Standard deviation over value of the inertia.
    pub(super) fn inertia_doubt(&self) -> f64 {
        self.filter.inertia_doubt()
    }

    /// The least and the most that Coulomb friction may exceed what certainly pulls the load all the time, N m:
    /// less than nothing where it does not hold the load.
    pub(super) fn holding_bounds(
        &self,
        load: &LoadModel,
        rated: f64,
        allowed: Deviations,
    ) -> [f64; 2] {
        let [usual, deviation] = self.filter.usual_friction().map(|torque| torque * rated);
        // while an axis has moved one way only, friction and a constant torque are not told apart
        let pull =
            (load.constant.abs() - allowed.pulls * self.filter.constant_doubt() * rated).max(0.0);
        // what the bounds of the inertia make of the friction is in doubt, and all of it where no load could be
        // what was found
        let found = usual.max(0.0);
        let least = if self.filter.is_possible() {
            load.coulomb.min(found) - pull - allowed.holds * deviation
        } else {
            f64::NEG_INFINITY
        };
        [
            least,
            load.coulomb.max(found) - pull + allowed.lets_go * deviation,
        ]
    }

    /// One tick; changes the load at the end of a block.
    #[inline(always)]
    pub(super) fn step(
        &mut self,
        twin: &Twin,
        now: &TwinState,
        signals: &Signals,
        seen: Seen,
        motor: &Motor,
        load: &mut LoadModel,
    ) {
        let speed = now.plant.load_velocity;
        // steady: in contact, moving, and in one direction
        // towards the end of a move the axis creeps after a reference at rest: there the load may
        // stick, and friction balances any torque
        let wanted = signals.reference.velocity;
        let disturbed = seen.disturbed
            || speed.abs() < MOVING_RAD_S
            || wanted.abs() < MOVING_RAD_S
            || speed * wanted < 0.0
            || speed * self.twin_speed < 0.0;
        self.twin_speed = speed;
        let was_steady = self.calm >= SETTLE_TICKS;
        self.calm = if disturbed {
            0
        } else {
            (self.calm + 1).min(SETTLE_TICKS)
        };
        let position = signals.motor_position;
        if self.calm < SETTLE_TICKS {
            if was_steady {
                self.disturb(position, motor, load);
            } else {
                // nothing has begun since
                self.block.position = position;
            }
            // a rest hides how long which torque held the load: no balance over it
            if wanted == 0.0 && signals.next_reference.velocity == 0.0 {
                self.bridge = None;
            }
            // at rest friction balances any torque, so its direction is unknown
            let loose = speed.abs() < MOVING_RAD_S
                || seen.torque.abs() < LOOSE_SHARE * self.filter.mean[2] * motor.rated_torque;
            if let Some(bridge) = &mut self.bridge
                && !bridge.push(signals, speed, loose)
            {
                self.bridge = None;
            }
            return;
        }
        self.block.push(signals);
        if self.block.ticks >= BLOCK_TICKS {
            let last = std::mem::replace(&mut self.block, Block::start(position));
            // the first whole block of a stretch closes the bridge
            if let Some(bridge) = self.bridge.take() {
                self.pending = Some(bridge.end(&last, position, motor, twin.motor_coulomb()));
            }
            // two blocks in a row: rising weights of the first and falling ones of the second make
            // the triangle
            if let Some(before) = self.before.replace(last) {
                self.take(twin, [&before, &last], position, motor, load);
            }
        }
    }

    /// A disturbance ends the stretch: the last whole block opens a bridge, the begun one is part of it.
    fn disturb(&mut self, position: f64, motor: &Motor, load: &mut LoadModel) {
        let rest = std::mem::replace(&mut self.block, Block::start(position));
        // a bridge starts at the last whole block; later disturbances extend it
        let before = self.before.take();
        let together = std::mem::replace(&mut self.together, false);
        self.pending = None;
        if let Some(row) = self.stretch.end() {
            self.learn_row(&row, motor, load);
        }
        if let Some(before) = before.filter(|_| together) {
            self.bridge = Some(Bridge::start(before, &rest));
        } else if let Some(bridge) = &mut self.bridge {
            bridge.skip(&rest);
        }
    }

    /// Takes two blocks in a row, and the motor's position at their end.
    fn take(
        &mut self,
        twin: &Twin,
        [first, second]: [&Block; 2],
        position: f64,
        motor: &Motor,
        load: &mut LoadModel,
    ) {
        let count = f64::from(BLOCK_TICKS);
        let span = count * Clock::SERVO.period_s();
        // the same triangle over velocity and acceleration: differences of the blocks' mean
        // positions, and an exact second difference
        let speed = (second.position - first.position + (second.way - first.way) / count) / span;
        let acceleration =
            ((position - second.position) - (second.position - first.position)) / (span * span);
        // torque behind the motor: what it gives less what it needs itself
        let own = motor.inertia * acceleration
            + motor.viscous * speed
            + twin.motor_coulomb() * speed.signum();
        let torque = motor.torque_constant * (first.rising + second.falling) / count - own;
        // torque behind a motor whose load is loose says nothing of the load, and a bridge that
        // ends there does not either
        self.together = torque.abs() > UNLOADED_SHARE * motor.rated_torque;
        let crossed = self.pending.take();
        if !self.together {
            self.stretch.lose();
            return;
        }
        if let Some(crossed) = crossed {
            self.filter.cross(&crossed, motor);
            self.news = true;
        }
        let mean = Mean {
            torque,
            speed,
            acceleration,
        };
        if let Some(row) = self.stretch.take(mean, motor, shaft(load)) {
            self.learn_row(&row, motor, load);
        }
    }

    /// Learns a row; once enough have been seen the load is believed, within physical bounds.
    fn learn_row(&mut self, row: &Row, motor: &Motor, load: &mut LoadModel) {
        self.filter
            .update(&row.regressors, row.torque, row.noise, self.known);
        self.news = true;
        self.blocks = self.blocks.saturating_add(1);
        if self.blocks >= BLOCKS_TO_KNOW {
            let unit = units(motor.inertia, motor.rated_torque);
            let mean = self.filter.possible(self.anchored());
            let found = LoadModel {
                inertia: mean[0].clamp(LEAST_INERTIA, LARGEST_INERTIA) * unit[0],
                viscous: mean[1].max(0.0) * unit[1],
                coulomb: mean[2].max(0.0) * unit[2],
                constant: mean[3] * unit[3],
                ..*load
            };
            if !self.known || differs(&found, load, &unit) {
                *load = found;
            }
            self.known = true;
        }
    }
}

/// Whether a load differs so much from the one that is used that it takes its place.
fn differs(found: &LoadModel, used: &LoadModel, unit: &LoadVector) -> bool {
    let off = |of: fn(&LoadModel) -> f64| (of(found) - of(used)).abs();
    off(|load| load.inertia) > LEAST_CHANGE * used.inertia
        || off(|load| load.viscous) > LEAST_TORQUE_CHANGE * unit[1]
        || off(|load| load.coulomb) > LEAST_TORQUE_CHANGE * unit[2]
        || off(|load| load.constant) > LEAST_TORQUE_CHANGE * unit[3]
}

/// The shaft of a load, with the time between two blocks.
fn shaft(load: &LoadModel) -> Shaft {
    Shaft {
        stiffness: load.stiffness,
        span: f64::from(BLOCK_TICKS) * Clock::SERVO.period_s(),
        inertia: load.inertia,
    }
}

/// SI value of one unit of each unknown.
fn units(inertia: f64, rated: f64) -> LoadVector {
    [inertia, rated / VISCOUS_SPEED, rated, rated]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_that_agree_on_the_inertia_bound_it() {
        let mut state = LearningState::new();
        assert_eq!(state.anchored(), [LEAST_INERTIA, LARGEST_INERTIA]);
        // what no load has is not held on to
        state.anchor(0.01);
        state.anchor(f64::NAN);
        assert_eq!(state.anchored(), [LEAST_INERTIA, LARGEST_INERTIA]);
        state.anchor(2.0);
        assert_eq!(state.anchored(), [2.0 / 1.5, 2.0 * 1.5]);
        for inertia in [9.0, 2.2, 2.1] {
            state.anchor(inertia);
        }
        assert_eq!(state.anchored(), [LEAST_INERTIA, LARGEST_INERTIA]);
        // one of them is far off
        assert!(!state.is_anchored());
        state.anchor(2.0);
        state.anchor(2.05);
        assert!(state.is_anchored());
        let [least, most] = state.anchored();
        assert!((least - 2.0 / 1.1).abs() < 1e-12 && (most - 2.2 * 1.1).abs() < 1e-12);
    }

    #[test]
    fn a_bounded_inertia_takes_the_friction_along() {
        let mut filter = LoadFilter::new();
        // a load of inertia 3 and friction 0.1
        for n in 0..4000 {
            let alpha = f64::from(n % 7) - 3.0;
            filter.update(&[0.1 * alpha, 0.0, 1.0, 0.0], 0.3 * alpha + 0.1, 0.0, true);
        }
        let free = filter.possible([LEAST_INERTIA, LARGEST_INERTIA]);
        let held = filter.possible([4.0, 5.0]);
        assert!((free[0] - 3.0).abs() < 0.05 && (held[0] - 4.0).abs() < 1e-12);
        // conditioned on the inertia, not cut: what is not correlated with it stays
        assert!((held[2] - free[2]).abs() < 0.05, "{free:?} {held:?}");
    }

    #[test]
    fn friction_holds_a_load_that_is_possible_and_that_nothing_pulls_as_strongly() {
        let (inertia, rated) = (1e-3, 10.0);
        let load = |coulomb, constant| LoadModel {
            inertia: 2e-3,
            viscous: 0.0,
            coulomb,
            constant,
            stiffness: 1e3,
            damping: 0.0,
        };
        const ALLOWED: Deviations = Deviations {
            holds: 2.0,
            lets_go: 3.0,
            pulls: 1.0,
        };
        let mut covariance = [[0.0; N]; N];
        (covariance[2][2], covariance[3][3]) = (0.01, 0.0004);
        let bounds = |load: LoadModel| {
            let state = LearningState::known(&load, &covariance, inertia, rated);
            state.holding_bounds(&load, rated, ALLOWED)
        };
        let near = |[least, most]: [f64; 2], expected: [f64; 2]| {
            (least - expected[0]).abs() < 1e-12 && (most - expected[1]).abs() < 1e-12
        };
        assert!(near(bounds(load(0.5, 0.0)), [0.3, 0.8]));
        // of 0.6 N m that pull 0.58 are certain
        assert!(near(bounds(load(0.5, -0.6)), [-0.28, 0.22]));
        let backwards = LoadModel {
            inertia: -2e-3,
            ..load(0.5, 0.0)
        };
        assert!(bounds(backwards)[0] < 0.0);
        // what a bound of the inertia makes of the friction may be wrong
        let state = LearningState::known(&load(0.1, 0.0), &covariance, inertia, rated);
        let [least, most] = state.holding_bounds(&load(0.5, 0.0), rated, ALLOWED);
        assert!(near([least, most], [0.1 - 0.2, 0.5 + 0.3]));
    }
}
