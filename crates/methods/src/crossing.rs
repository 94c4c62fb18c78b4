//! Crossing the gap at the right time: predicts the flank that has to carry the load, and moves the
//! motor from one flank to the other.
//!
//! ```text
//! T      torque in the shaft of the gapless twin, N m
//! need   J_L alpha + b_L w + T_f sign(w) + T_const at the reference, lagged by (1 - f_v)/Kv as the axis is without feed-forward
//! ahead  T extrapolated by half the traverse's time and two ticks
//! side   sign(ahead) where |ahead| > 1e-5 of the rated torque and need has the same sign, else unchanged;
//!        straight back behind a crossing, for two traverses, only where both are above T_f/2
//! ```
//! Both have to agree: `T` has the right timing, but oscillates for some milliseconds after each
//! sticking of the motor; `need` does not oscillate. `passage` predicts whether an acceleration
//! that runs towards zero passes through it. At rest there is no need. The integral of the velocity
//! loop then keeps pulling at a load that sticks, until it slips or the position is reached: there
//! `T` decides alone, from a quarter of the friction on. A weight that turns with the load (a
//! joint) is a constant torque that depends on the load's position: at that of the twin now, and at
//! the predicted one.
//!
//! Starting half a traverse before the torque vanishes centres the traverse on the change of flank.
//! The error that is left is `j T_g^3/12` on a load without friction (j: jerk, rad/s3); with
//! friction it is nothing as long as the load sticks longer than the traverse takes.
//!
//! Outputs while crossing: offset and its velocity to the loops; as torque `J_M` times its
//! acceleration, the motor's viscous friction, the change of the motor's Coulomb friction, and what
//! the shaft carries less than the twin's, whose torque the loops give a motor that has left its
//! load. The lag of the current loop is undone, see `traverse`. At rest, where the motor of a load
//! that sticks has run ahead of the twin's, only the way is fed forward that is left. A half gap that
//! changes is applied at the next crossing; with `taking_up` it is applied on the flank while the
//! load slides, within a quarter of the torque that presses it, so that contact is kept; or at rest. A
//! load that is pushed at rest stops with all of its friction in the shaft, where that of the gapless
//! twin may carry less; it is pushed so much farther:
//! ```text
//! offset   b + (T_f + T_const - T)/k       on the upper flank; mirrored on the lower one, and only where T presses the flank
//! ```
//! One that is not met is fetched back from the other flank, see `rest`.
//!
//! The law is this project's; the flank by torque sign is after Gan, Wang, Huang, Machines 2023,
//! 11(2), 193. Where it fails is said in `lookup`.

mod flank;
mod rest;

use crate::AxisConfig;
use crate::passage::Passage;
use crate::traverse::{CurrentLag, Offset, Traverse, ticks_for};
use lostmotion_drive::plant::Waves;
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::twin::{LoadModel, Shown, Twin, TwinState, Twinned};
use lostmotion_drive::{Correction, Signals};
use rest::Rested;
use serde::{Deserialize, Serialize};

/// Shortest and longest traverse, ms: a current loop cannot follow a shorter one. The shortest is
/// tuned (2, 4 and 5 ms were tried and dropped); the longest a choice, at which hardly any torque
/// is needed.
const TRAVERSE_LIMITS_MS: [f64; 2] = [3.0, 100.0];
/// Part of the rated torque below which the shaft counts as unloaded: above rounding, far below any
/// friction. A choice.
const UNLOADED_TORQUE_SHARE: f64 = 1e-5;

/// Shortest and longest time in which a changed half gap is applied on the flank, ms. A choice:
/// shorter pushes the load, longer lasts into the next reversal.
const TAKE_UP_LIMITS_MS: [f64; 2] = [20.0, 500.0];
/// Part of the torque that presses the flank which applying a changed half gap may take from it: a
/// quarter keeps contact. A choice, see decision 65 of the book.
const TAKE_UP_TORQUE_SHARE: f64 = 0.25;
/// How many times faster it has to be possible by now to be applied anew. A choice: what it loses by beginning from
/// rest is a part of that.
const HASTENING: f64 = 2.0;
/// Change of the half gap that is not worth applying, rad: below the step of an encoder with 2^23
/// counts (7e-7).
const NEGLIGIBLE_CHANGE_RAD: f64 = 1e-7;
/// Rest after which a load is pushed to its place, ms. A choice: what begins in a short stop is still under way
/// when the axis goes on (275903-6: one thrown load more), and the next crossing is near.
const REST_MS: f64 = 300.0;
/// Shortest time in which it is pushed, ms. A choice: a load swings on its shaft at 10 to 150 Hz, and
/// one that is pushed within a period slides on (604417-8: by a third of the way).
const REST_TAKE_UP_MS: f64 = 100.0;
/// Speed of the load from which on it certainly slides, rad/s at the motor. A choice: 160 um/s on a
/// screw of 20 mm, as in the filters.
const SLIDING_RAD_S: f64 = 0.05;

/// Time constants of the two means of the torque that holds an axis at rest, servo ticks: 3 and 9
/// ms. A first-order mean lags a ramp by its time constant, so two of them give value and slope. A
/// choice: longer ones lag more than they can make up for, shorter ones let the noise of encoder
/// and loops through.
const HOLDING_MEAN_TICKS: [f64; 2] = [12.0, 36.0];
/// Servo ticks of rest, and since the last traverse, after which the holding torque is known once the load
/// rests: 4 ms. A choice: earlier the traverse's own torque is taken for the load's, and the motor goes to
/// and fro.
const HELD_AFTER_TICKS: u32 = 16;
/// Part of the drive's largest torque that a traverse may take, if nothing else is set. Tuned on 97 cells
/// of four seeds: a traverse of half the torque takes a quarter longer, and what a load loses meanwhile
/// grows with the square to the cube of that; the rest is for the axis' own motion.
pub(super) const TORQUE_SHARE: f64 = 0.8;

/// Half a gap, rad: what is used of it in motion, and at rest. A traverse that is too long throws the
/// load while it moves; at rest it takes it along by no more than it is too long.
#[derive(Clone, Copy, Debug)]
pub(super) struct HalfGap {
    pub(super) moving: f64,
    pub(super) resting: f64,
}

impl From<f64> for HalfGap {
    fn from(half_gap: f64) -> HalfGap {
        HalfGap {
            moving: half_gap,
            resting: half_gap,
        }
    }
}

/// The constant part: twin, limits and gains of an axis.
#[derive(Clone, Debug)]
pub(super) struct Crossing {
    pub(super) twin: Twin,
    /// Peak acceleration of a traverse, rad/s2.
    acceleration: f64,
    /// Torque below which the shaft counts as unloaded, N m.
    unloaded: f64,
    current: CurrentLag,
    /// Gain of the first-order lag of an axis without full velocity feed-forward, 1 for none.
    lag_per_tick: f64,
    /// Part of the shaft's wind-up that is added to the reference.
    wind_up: f64,
    /// Servo period, s.
    period: f64,
    traverse_ticks: [u32; 2],
    take_up_ticks: [u32; 2],
    rest_ticks: u32,
    rest_take_up_ticks: u32,
    /// Whether a changed half gap is applied on the flank, not at the next crossing.
    takes_up: bool,
    /// Torque of the weight over the load's angle, where it is told.
    weight: Waves,
}

impl Crossing {
    /// `torque_share`: part of the drive's largest torque that a traverse may take; `wind_up`: part
    /// of the shaft's wind-up added to the reference.
    pub(super) fn new(config: &AxisConfig, torque_share: f64, wind_up: f64) -> Crossing {
        let (motor, drive, period) = (&config.motor, &config.drive, config.servo_period_s());
        // without full velocity feed-forward the axis follows its reference like a first-order lag
        // of (1 - f_v)/Kv
        let missing = 1.0 - drive.velocity_feedforward;
        let loop_period = config.current_period_us() * 1e-6 / period;
        let current = CurrentLag {
            lag: motor.phase_inductance_h() / drive.current_gain_v_per_a / period,
            delay: f64::from(drive.voltage_delay_periods) * loop_period,
            half_step: 0.5 * loop_period,
        };
        Crossing {
            twin: Twin::new(config),
            acceleration: torque_share * motor.torque_constant_nm_per_a * drive.current_limit_a
                / config.motor_side_inertia_kgm2(),
            unloaded: UNLOADED_TORQUE_SHARE * motor.rated_torque_nm,
            current,
            lag_per_tick: if missing > 0.0 {
                (period * drive.position_gain_per_s / missing).min(1.0)
            } else {
                1.0
            },
            wind_up,
            period,
            traverse_ticks: TRAVERSE_LIMITS_MS.map(|ms| config.cycles.ticks(ms)),
            take_up_ticks: TAKE_UP_LIMITS_MS.map(|ms| config.cycles.ticks(ms)),
            rest_ticks: config.cycles.ticks(REST_MS),
            rest_take_up_ticks: config.cycles.ticks(REST_TAKE_UP_MS),
            takes_up: false,
            weight: Waves::default(),
        }
    }

    /// The same for a half gap that is known well and seldom changes: a change is applied on the
    /// flank, not at the next crossing.
    #[must_use]
    pub(super) fn taking_up(self) -> Crossing {
        Crossing {
            takes_up: true,
            ..self
        }
    }

    /// Adds the known gravity torque of the load.
    pub(super) fn with_weight(self, config: &AxisConfig) -> Crossing {
        Crossing {
            weight: Waves::gravity(config),
            ..self
        }
    }

    /// The load with its gravity torque at a position, rad at the motor.
    fn weighed(&self, load: &LoadModel, place: f64) -> LoadModel {
        LoadModel {
            constant: load.constant + self.weight.at(place),
            ..*load
        }
    }

    pub(super) fn initial(&self, motor_position: f64, load: &LoadModel) -> CrossingState {
        let twin = self
            .twin
            .initial(motor_position, &self.weighed(load, motor_position));
        CrossingState::new(twin)
    }

    /// One servo tick with the load and the half gap (rad) as they are known now.
    pub(super) fn step(
        &self,
        state: &mut CrossingState,
        signals: &Signals,
        load: &LoadModel,
        half_gap: f64,
    ) -> Correction {
        self.begin(state, load)
            .step(&signals.reference, &signals.next_reference);
        self.finish(state, signals, load, half_gap)
    }

    /// First part of a tick: hands out the twin, which has to be stepped before [`Crossing::finish`].
    #[inline]
    pub(super) fn begin<'a>(
        &'a self,
        state: &'a mut CrossingState,
        load: &'a LoadModel,
    ) -> Twinned<'a> {
        state.before = state.twin.shown();
        Twinned {
            twin: &self.twin,
            load,
            weight: self.weight.at(state.before.load_position),
            state: &mut state.twin,
        }
    }

    /// Second part of a tick: flank, traverse and correction, once the twin has been stepped.
    #[inline(always)]
    pub(super) fn finish(
        &self,
        state: &mut CrossingState,
        signals: &Signals,
        load: &LoadModel,
        half_gap: impl Into<HalfGap>,
    ) -> Correction {
        let now = state.before;
        let half_gaps = half_gap.into();
        let half_gap = half_gaps.moving;
        self.follow(state, signals);
        state.swings = None;
        state.since = state.since.saturating_add(1);
        if state.crossing() {
            (state.since, state.hovers) = (0, false);
        }
        // no new decision while a crossing is under way: it ends at rest on the far flank
        if !state.crossing() {
            // time of the traverse first: half of it is the lead of the prediction
            let ticks = self.ticks_across(state, half_gap);
            let side = self.side_ahead(
                state,
                &now,
                signals,
                load,
                [half_gap, 0.5 * f64::from(ticks)],
            );
            let to = f64::from(side) * half_gap;
            if side != state.side {
                state.side = side;
                state.rested = None;
                self.cross(state, signals, load, to, ticks);
            } else if self.takes_up && !state.traverse.moving() && !state.has_taken(to) {
                self.take_up(state, &now, load, half_gaps);
            } else if self.takes_up && state.traverse.moving() {
                self.hasten(state, &now, load);
            }
        }
        let crossing = state.crossing();
        let offset = state.traverse.step(&self.current, self.period);
        self.correction(state, &now, &offset, load, crossing)
    }

    /// Servo ticks of a traverse of a gap, given half of it (rad): a gap changes in few ticks.
    #[inline]
    fn ticks_across(&self, state: &mut CrossingState, half_gap: f64) -> u32 {
        if state.across != Some(half_gap) {
            state.across = Some(half_gap);
            state.ticks_across = ticks_for(
                2.0 * half_gap,
                self.acceleration,
                self.period,
                self.traverse_ticks,
            );
        }
        state.ticks_across
    }

    /// Starts to the offset of another flank.
    fn cross(
        &self,
        state: &mut CrossingState,
        signals: &Signals,
        load: &LoadModel,
        to: f64,
        ticks: u32,
    ) {
        let now = state.traverse.now();
        if to == now {
            return;
        }
        // The first time it is applied on a flank: where the load is while it changes is not known. What a rest
        // has applied is taken back, since it would be wrong twice over on the other flank.
        if self.takes_up && !state.engaged {
            if now != 0.0 {
                state.traverse.start(0.0, ticks, &self.current);
                state.taking_up = false;
            }
            return;
        }
        let ticks = if state.at_rest {
            self.gentle_ticks(to - now, load, self.traverse_ticks[1])
        } else {
            ticks
        };
        state.traverse.start(to, ticks, &self.current);
        // With a load that friction holds, the motor has already run towards its reference, which the
        // twin's, pressed against the load, has not reached. It is moved to where that one would be on the
        // new flank, so that the loops pull at the load as they do there.
        let stuck = state.before.load_velocity == 0.0 && signals.next_reference.velocity == 0.0;
        if stuck && !state.at_rest {
            let there = state.twin.plant.motor_position() + state.wound + to;
            state.traverse.leave(there - signals.motor_position);
        }
        state.taking_up = false;
        state.crossed_at_rest = state.at_rest;
    }

    /// Whether a load rests, too: at most it crosses the gap by itself until friction has stopped it.
    #[inline(always)]
    fn has_settled(&self, state: &CrossingState, load: &LoadModel, half_gap: f64) -> bool {
        let Some(ticks) = state.held_ticks.checked_sub(HELD_AFTER_TICKS) else {
            return false;
        };
        // 2 b = T_f/(2 J) t^2
        let time = f64::from(ticks) * self.period;
        time * time * load.coulomb >= 4.0 * half_gap * load.inertia
    }

    /// Applies a half gap that has become known or has changed on the flank, so gently that the load stays
    /// in contact: while it slides and is pressed, or rests.
    #[inline(always)]
    fn take_up(&self, state: &mut CrossingState, now: &Shown, load: &LoadModel, half_gap: HalfGap) {
        let has_settled = self.has_settled(state, load, half_gap.resting);
        if has_settled && state.held_ticks >= self.rest_ticks {
            self.take_up_at_rest(state, now, load, half_gap.resting);
            return;
        }
        let side = f64::from(state.side);
        let taken = side * state.traverse.now();
        // what a rest has taken up stays until the next crossing
        let to = side * taken.min(half_gap.resting).max(half_gap.moving);
        let way = to - state.traverse.now();
        if has_settled && state.rested.is_none() && way.abs() > NEGLIGIBLE_CHANGE_RAD {
            let ticks = self.gentle_ticks(way, load, self.take_up_ticks[1]);
            state.traverse.start(to, ticks, &self.current);
            state.taking_up = true;
            return;
        }
        let pressed = now.torque * f64::from(state.side);
        if pressed <= self.unloaded || now.load_velocity.abs() < SLIDING_RAD_S {
            return;
        }
        // a load that slides is on its flank for certain
        if way.abs() <= NEGLIGIBLE_CHANGE_RAD {
            state.engaged |= to != 0.0;
            return;
        }
        let ticks = self.pressed_ticks(way, pressed, load);
        // pressed too weakly for the longest time: wait for more torque or the next crossing
        if ticks < self.take_up_ticks[1] {
            state.traverse.start(to, ticks, &self.current);
            state.taking_up = true;
            state.engaged = true;
        }
    }

    /// Applies the rest of a half gap faster where the flank is pressed more by now. One that begins as soon as the
    /// flank presses, behind a reversal, would else take up to half a second, and the axis would come back meanwhile.
    #[inline(always)]
    fn hasten(&self, state: &mut CrossingState, now: &Shown, load: &LoadModel) {
        let pressed = now.torque * f64::from(state.side);
        if pressed <= self.unloaded || now.load_velocity.abs() < SLIDING_RAD_S {
            return;
        }
        let (way, left) = state.traverse.left();
        let ticks = self.pressed_ticks(way, pressed, load);
        // it begins anew from rest: worth while where it is much faster
        if HASTENING * f64::from(ticks) < left {
            let to = state.traverse.now() + way;
            state.traverse.start(to, ticks, &self.current);
        }
    }

    /// Servo ticks of a way, rad, on which a load that slides stays on the flank that it is pressed to.
    fn pressed_ticks(&self, way: f64, pressed: f64, load: &LoadModel) -> u32 {
        // the load moves with the motor: its inertia takes part of the pressing torque
        ticks_for(
            way,
            TAKE_UP_TORQUE_SHARE * pressed / load.inertia,
            self.period,
            self.take_up_ticks,
        )
    }

    /// Means of the torque that holds the axis at rest, and the lagged reference.
    #[inline(always)]
    fn follow(&self, state: &mut CrossingState, signals: &Signals) {
        let (at_rest, torque) = (
            signals.next_reference.velocity == 0.0,
            self.twin.torque_constant() * signals.mean_current,
        );
        // a traverse moves the motor by itself; its torque says nothing of the load
        state.held_ticks = if at_rest && !state.traverse.moving() {
            state.held_ticks.saturating_add(1)
        } else {
            0
        };
        if !at_rest {
            state.rested = None;
        }
        // while the axis moves the means just follow, so that they start from the torque at the
        // stop
        for (mean, ticks) in state.holding.iter_mut().zip(HOLDING_MEAN_TICKS) {
            let rise = torque - *mean;
            *mean += if state.held_ticks == 0 {
                rise
            } else {
                rise / ticks
            };
        }
        let reference = &signals.reference;
        for (lagged, now) in state
            .lagged
            .iter_mut()
            .zip([reference.velocity, reference.acceleration])
        {
            *lagged += self.lag_per_tick * (now - *lagged);
        }
    }

    /// Offset, velocity and torque of the traverse, with the wind-up on top.
    #[inline(always)]
    fn correction(
        &self,
        state: &mut CrossingState,
        now: &Shown,
        offset: &Offset,
        load: &LoadModel,
        crossing: bool,
    ) -> Correction {
        // wind-up of the shaft under the twin's torque, and its rate
        let (before, mut wind_speed) = (state.wound, 0.0);
        if self.wind_up != 0.0 {
            state.wound = self.wind_up * now.torque / load.stiffness;
            wind_speed = (state.wound - before) / self.period;
        }
        // across the gap the motor moves alone, on the flank it takes the load along
        let carried = if state.taking_up { load.inertia } else { 0.0 };
        let mut torque = (self.twin.motor_inertia() + carried) * offset.acceleration
            + self.twin.motor_viscous() * offset.velocity;
        // the motor's Coulomb friction with the traverse less that of the twin, which the servo
        // already overcomes; one that does not move yet has none of either sign
        if crossing {
            let speed = now.motor_velocity + offset.velocity;
            let friction = if speed == 0.0 {
                -now.motor_friction
            } else if speed > 0.0 {
                self.twin.motor_coulomb()
            } else {
                -self.twin.motor_coulomb()
            };
            torque += friction + now.motor_friction;
            // in the middle of the time over which the torque is held, as late as the current is
            let ahead = 0.5 + self.current.lag;
            let twins = now.torque + (state.twin.torque - now.torque) * ahead;
            torque += state.traverse.carried(twins, load.stiffness, ahead) - twins;
        }
        Correction {
            position: offset.position + state.wound,
            velocity: offset.velocity + wind_speed,
            torque,
            gap_angle_estimate: offset.position,
            engagement_estimate: match state.side {
                1 => Engagement::Positive,
                -1 => Engagement::Negative,
                _ => Engagement::Gap,
            },
            ..Correction::NONE
        }
    }
}

/// State of a crossing from tick to tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CrossingState {
    pub(crate) twin: TwinState,
    /// The twin before its last step.
    pub(crate) before: Shown,
    /// Flank that carries the load, or is to carry it: -1, 1; 0 before the first.
    pub(crate) side: i8,
    pub(super) traverse: Traverse,
    /// The half gap that a traverse was laid out for last, rad, and its servo ticks.
    across: Option<f64>,
    ticks_across: u32,
    /// Servo ticks since the last crossing ended, and whether the other flank was asked for at once.
    since: u32,
    hovers: bool,
    /// Whether the traverse applies a changed half gap on the same flank.
    pub(super) taking_up: bool,
    /// Reference velocity and acceleration as the axis follows them.
    pub(super) lagged: [f64; 2],
    pub(super) passage: Passage,
    /// Wind-up that was added at the last tick, rad.
    pub(super) wound: f64,
    /// Torque of the motor, averaged over the times of `HOLDING_MEAN_TICKS`, N m.
    pub(super) holding: [f64; 2],
    /// Ticks of rest since the last traverse.
    pub(super) held_ticks: u32,
    /// Whether the twin's load is known so well that its torque decides at rest, too.
    pub(super) trusts_twin: bool,
    /// Whether the axis rests with a load that sticks, and whether the gap was crossed in this rest.
    pub(super) at_rest: bool,
    pub(super) crossed_at_rest: bool,
    /// Whether a half gap has been applied on a flank on which the load slid or certainly lay: then it is crossed
    /// on a traverse, also while a part of it is applied.
    pub(super) engaged: bool,
    /// What was applied on this flank since the axis rests.
    pub(super) rested: Option<Rested>,
    /// Whether what the shaft swings with decides which flank carries the load, against what the motion needs;
    /// `None` where that was not asked.
    pub(super) swings: Option<bool>,
}

impl CrossingState {
    /// Whether the motor is on its way from flank to flank.
    pub(crate) fn crossing(&self) -> bool {
        self.traverse.moving() && !self.taking_up
    }

    /// Whether the axis moves on with this offset, rad, which is all that there is to apply on its flank.
    #[inline(always)]
    fn has_taken(&self, offset: f64) -> bool {
        self.held_ticks == 0 && self.traverse.now() == offset && (self.engaged || offset == 0.0)
    }

    /// What the motor is ahead of its reference, rad, and the part of it that only winds up the shaft of a
    /// load that was pushed at rest.
    pub(super) fn ahead(&self) -> [f64; 2] {
        let offset = self.traverse.now();
        let beyond = self
            .rested
            .map_or(0.0, |rested| (offset.abs() - rested.half_gap).max(0.0));
        [offset, beyond.copysign(offset)]
    }

    pub(super) fn new(twin: TwinState) -> CrossingState {
        CrossingState {
            before: twin.shown(),
            twin,
            side: 0,
            traverse: Traverse::default(),
            across: None,
            ticks_across: 0,
            since: u32::MAX,
            hovers: false,
            taking_up: false,
            lagged: [0.0; 2],
            passage: Passage::default(),
            wound: 0.0,
            holding: [0.0; 2],
            held_ticks: 0,
            trusts_twin: false,
            at_rest: false,
            crossed_at_rest: false,
            engaged: false,
            rested: None,
            swings: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_half_gap_is_applied_faster_once_its_flank_is_pressed_more() {
        let config = AxisConfig::paper();
        let crossing = Crossing::new(&config, TORQUE_SHARE, 0.0).taking_up();
        let load = LoadModel::told(&config);
        let mut state = crossing.initial(0.0, &load);
        state.side = 1;
        let shown = state.before;
        // pressed so that a quarter of it accelerates the load by as much, rad/s2
        let pressed = |acceleration: f64, load_velocity: f64| Shown {
            torque: 4.0 * acceleration * load.inertia,
            load_velocity,
            ..shown
        };
        let most = crossing.take_up_ticks[1];
        state.traverse.start(1e-3, most, &crossing.current);
        state.taking_up = true;
        for _ in 0..100 {
            state.traverse.step(&crossing.current, crossing.period);
        }
        let before = state.traverse;
        for still in [pressed(0.03, 1.0), pressed(10.0, 0.0)] {
            crossing.hasten(&mut state, &still, &load);
            assert_eq!(state.traverse, before);
        }
        crossing.hasten(&mut state, &pressed(10.0, 1.0), &load);
        let ([way, left], [rest, slow]) = (
            <[f64; 2]>::from(state.traverse.left()),
            <[f64; 2]>::from(before.left()),
        );
        assert!(
            (way - rest).abs() < 1e-15 && 2.0 * left < slow,
            "{left} {slow}"
        );
    }
}
