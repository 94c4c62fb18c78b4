//! Crossing the gap at the right time: which flank has to carry the load, and the motor's way from
//! one flank to the other.
//!
//! ```text
//! T      torque that the shaft of the gapless twin carries, N m
//! need   J_L alpha + b_L w + T_f sign(w) + T_const at the reference, lagged by (1 - f_v)/Kv as the axis is without feed-forward
//! ahead  T extrapolated by half the traverse's time and two ticks
//! side   sign(ahead) where |ahead| > 1e-5 of the rated torque and need has the same sign, else as it was
//! ```
//! Both have to agree: `T` has the right time, and shakes for some milliseconds after each sticking
//! of the motor; `need` does not shake. Whether an acceleration that runs towards zero goes through
//! or ends there, nobody knows before; `passage` expects what it did the last time. At rest there
//! is no need. The velocity loop's integral then goes on pulling at a load that sticks, until it
//! slips or the position is reached: there `T` decides alone, once it is a quarter of the friction.
//! A weight that turns with the load (a joint) is a constant torque that depends on where the load
//! is: that of the twin now, and that of where it will be.
//!
//! Setting out half a traverse before the torque vanishes halves its effect twice over: what is
//! left on a load without friction is `j T_g^3/12`, on one with friction nothing as long as it
//! sticks longer than the traverse takes.
//!
//! Outputs while crossing: offset and its speed to the loops; `J_M` times its acceleration, motor
//! viscous friction, and the change of the motor's Coulomb friction as torque, ahead by half the
//! current loop's lag. A half gap that changes is taken up by the next crossing; one that is sure
//! (`taking_up`) on the flank while the load slides, within a quarter of the torque that presses
//! it, so that it neither lets go nor is thrown.

use crate::AxisConfig;
use crate::passage::Passage;
use crate::traverse::{Offset, Traverse, ticks_for};
use lostmotion_drive::plant::Waves;
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::twin::{LoadModel, Shown, Twin, TwinState, Twinned};
use lostmotion_drive::{Correction, Signals};
use serde::{Deserialize, Serialize};

/// A traverse takes no less and no more, ms. A current loop cannot follow what is quicker.
const TRAVERSE_MS: [f64; 2] = [3.0, 100.0];
/// Ticks by which a traverse sets out earlier: detection and the loops take about two.
const EARLIER_TICKS: f64 = 2.0;
/// Part of the rated torque below which the shaft carries nothing.
const NOTHING: f64 = 1e-5;
/// A reference slower than this is at rest, rad/s.
const STANDING_RAD_S: f64 = 1e-6;

/// Taking up a half gap on the flank: least and most time, ms; part of the torque on the flank that
/// it may take; a way that is none, rad; and the speed from which on the load slides, rad/s.
const TAKING_UP_MS: [f64; 2] = [20.0, 500.0];
const PRESSING: f64 = 0.25;
const NO_WAY_RAD: f64 = 1e-7;
const SLIDES_RAD_S: f64 = 0.05;

/// Ticks over which the torque that holds an axis at rest is averaged: 3 and 9 ms; from both it is
/// extrapolated.
const HOLDING_TICKS: [f64; 2] = [12.0, 36.0];
/// Ticks of rest, and since the last traverse, after which that is known: 4 ms.
const HELD_TICKS: u32 = 16;
/// Part of the Coulomb friction with which the shaft of an axis at rest pulls at a load that
/// sticks, for the flank to change.
const STUCK: f64 = 0.25;

/// Twin and traverse of an axis.
#[derive(Clone, Debug)]
pub(super) struct Crossing {
    pub(super) twin: Twin,
    acceleration: f64,
    nothing: f64,
    torque_lead_ticks: f64,
    lag_per_tick: f64,
    wind_up: f64,
    period: f64,
    traverse_ticks: [u32; 2],
    taking_up_ticks: [u32; 2],
    takes_up: bool,
    /// Torque of the weight over the load's angle, where it is told.
    weight: Waves,
}

impl Crossing {
    /// `torque_share`: part of the drive's largest torque that a traverse may take; `wind_up`: part
    /// of the shaft's wind-up added to the reference.
    pub(super) fn new(config: &AxisConfig, torque_share: f64, wind_up: f64) -> Crossing {
        let (motor, drive, period) = (&config.motor, &config.drive, config.servo_period_s());
        let missing = 1.0 - drive.velocity_feedforward;
        let current_lag = motor.phase_inductance_h() / drive.current_gain_v_per_a
            + f64::from(drive.voltage_delay_periods) * config.current_period_us() * 1e-6;
        Crossing {
            twin: Twin::new(config),
            acceleration: torque_share * motor.torque_constant_nm_per_a * drive.current_limit_a
                / config.motor_side_inertia_kgm2(),
            nothing: NOTHING * motor.rated_torque_nm,
            torque_lead_ticks: (0.5 * current_lag / period).min(1.0),
            lag_per_tick: if missing > 0.0 {
                (period * drive.position_gain_per_s / missing).min(1.0)
            } else {
                1.0
            },
            wind_up,
            period,
            traverse_ticks: TRAVERSE_MS.map(|ms| config.cycles.ticks(ms)),
            taking_up_ticks: TAKING_UP_MS.map(|ms| config.cycles.ticks(ms)),
            takes_up: false,
            weight: Waves::default(),
        }
    }

    /// The same for a half gap that is sure and seldom changes: it is taken up on the flank, not by
    /// the next crossing.
    #[must_use]
    pub(super) fn taking_up(self) -> Crossing {
        Crossing {
            takes_up: true,
            ..self
        }
    }

    /// For who is told the load's weight, too.
    pub(super) fn with_weight(self, config: &AxisConfig) -> Crossing {
        Crossing {
            weight: Waves::gravity(config),
            ..self
        }
    }

    /// The load with its weight at a place, rad at the motor.
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

    /// One servo tick with a load and half a gap as they are known now.
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

    /// The twin, which has to be stepped before the tick is finished.
    pub(super) fn begin<'a>(
        &'a self,
        state: &'a mut CrossingState,
        load: &LoadModel,
    ) -> Twinned<'a> {
        state.before = state.twin.shown();
        Twinned {
            twin: &self.twin,
            load: self.weighed(load, state.before.load_position),
            state: &mut state.twin,
        }
    }

    /// The rest of the tick.
    pub(super) fn finish(
        &self,
        state: &mut CrossingState,
        signals: &Signals,
        load: &LoadModel,
        half_gap: f64,
    ) -> Correction {
        let now = state.before;
        self.follow(state, signals);
        if !state.crossing() {
            let ticks = ticks_for(
                2.0 * half_gap,
                self.acceleration,
                self.period,
                self.traverse_ticks,
            );
            let side = self.side_ahead(state, &now, signals, load, 0.5 * f64::from(ticks));
            let to = f64::from(side) * half_gap;
            if side != state.side {
                state.side = side;
                if to != state.traverse.now() {
                    state.traverse.start(to, ticks);
                    state.taking_up = false;
                }
            } else if self.takes_up && !state.traverse.moving() {
                self.take_up(state, &now, load, to);
            }
        }
        let crossing = state.crossing();
        let offset = state.traverse.step(self.torque_lead_ticks, self.period);
        self.correction(state, &now, &offset, load, crossing)
    }

    /// Takes up a half gap that has become known or changed, on the flank, while the load slides
    /// and is pressed: so gently that it stays so.
    fn take_up(&self, state: &mut CrossingState, now: &Shown, load: &LoadModel, to: f64) {
        let way = to - state.traverse.now();
        let pressed = now.torque * f64::from(state.side);
        if way.abs() <= NO_WAY_RAD
            || pressed <= self.nothing
            || now.load_velocity.abs() < SLIDES_RAD_S
        {
            return;
        }
        let ticks = ticks_for(
            way,
            PRESSING * pressed / load.inertia,
            self.period,
            self.taking_up_ticks,
        );
        if ticks < self.taking_up_ticks[1] {
            state.traverse.start(to, ticks);
            state.taking_up = true;
        }
    }

    fn follow(&self, state: &mut CrossingState, signals: &Signals) {
        let (at_rest, torque) = (
            signals.next_reference.velocity == 0.0,
            self.twin.torque_constant() * signals.mean_current,
        );
        state.held_ticks = if at_rest && !state.traverse.moving() {
            state.held_ticks.saturating_add(1)
        } else {
            0
        };
        for (mean, ticks) in state.holding.iter_mut().zip(HOLDING_TICKS) {
            *mean += (torque - *mean) / if state.held_ticks == 0 { 1.0 } else { ticks };
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

    fn side_ahead(
        &self,
        state: &mut CrossingState,
        now: &Shown,
        signals: &Signals,
        load: &LoadModel,
        lead_ticks: f64,
    ) -> i8 {
        let torque = now.torque + (state.twin.torque - now.torque) * (lead_ticks + EARLIER_TICKS);
        let [speed, acceleration] = state.lagged;
        // behind a lag the jerk of the reference says nothing about the axis' own
        let step = if self.lag_per_tick < 1.0 {
            0.0
        } else {
            signals.next_reference.acceleration - signals.reference.acceleration
        };
        let [ahead_speed, ahead_acceleration] =
            state
                .passage
                .ahead(speed, acceleration, step, lead_ticks, self.period);
        let there = self.weighed(
            load,
            now.load_position + ahead_speed * lead_ticks * self.period,
        );
        let need = there.need(ahead_speed, ahead_acceleration, STANDING_RAD_S);
        let stands = speed.abs() <= STANDING_RAD_S && acceleration == 0.0 && step == 0.0;
        if stands && self.takes_up && load.coulomb > self.nothing {
            return if state.held_ticks >= HELD_TICKS {
                self.held(state, lead_ticks)
            } else {
                state.side
            };
        }
        let side = if torque > 0.0 { 1 } else { -1 };
        let sure = if stands {
            torque.abs() > STUCK * load.coulomb && load.coulomb > self.nothing
        } else {
            torque.abs() > self.nothing && need * torque > 0.0
        };
        if sure { side } else { state.side }
    }

    /// The flank that will have to carry a load that sticks, as the motor's own torque shows: it
    /// sets out across the gap once it has overcome its friction.
    fn held(&self, state: &CrossingState, lead_ticks: f64) -> i8 {
        let ([short, long], [few, many]) = (state.holding, HOLDING_TICKS);
        let torque = short + (short - long) / (many - few) * (few + lead_ticks + EARLIER_TICKS);
        if torque * f64::from(state.side) < -self.twin.motor_coulomb() {
            -state.side
        } else {
            state.side
        }
    }

    fn correction(
        &self,
        state: &mut CrossingState,
        now: &Shown,
        offset: &Offset,
        load: &LoadModel,
        crossing: bool,
    ) -> Correction {
        let wound = self.wind_up * now.torque / load.stiffness;
        let wind_speed = (wound - state.wound) / self.period;
        state.wound = wound;
        let carried = if state.taking_up { load.inertia } else { 0.0 };
        let mut torque = (self.twin.motor_inertia() + carried) * offset.acceleration
            + self.twin.motor_viscous() * offset.velocity;
        if crossing {
            let speed = now.motor_velocity + offset.velocity;
            let friction = if speed > 0.0 {
                self.twin.motor_coulomb()
            } else {
                -self.twin.motor_coulomb()
            };
            torque += friction + now.motor_friction;
        }
        Correction {
            position: offset.position + wound,
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

// What a crossing carries from tick to tick.

/// What the crossing carries along.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CrossingState {
    pub(crate) twin: TwinState,
    /// The twin before its last step.
    pub(crate) before: Shown,
    pub(crate) side: i8,
    pub(super) traverse: Traverse,
    /// Whether the traverse takes up a half gap that changed, on the same flank.
    pub(super) taking_up: bool,
    /// Reference velocity and acceleration as the axis follows them.
    pub(super) lagged: [f64; 2],
    pub(super) passage: Passage,
    pub(super) wound: f64,
    /// Torque of the motor, averaged over the times of `HOLDING_TICKS`, N m.
    pub(super) holding: [f64; 2],
    /// Ticks of rest since the last traverse.
    pub(super) held_ticks: u32,
}

impl CrossingState {
    /// Whether it is on its way from flank to flank.
    pub(crate) fn crossing(&self) -> bool {
        self.traverse.moving() && !self.taking_up
    }

    pub(super) fn new(twin: TwinState) -> CrossingState {
        CrossingState {
            before: twin.shown(),
            twin,
            side: 0,
            traverse: Traverse::default(),
            taking_up: false,
            lagged: [0.0; 2],
            passage: Passage::default(),
            wound: 0.0,
            holding: [0.0; 2],
            held_ticks: 0,
        }
    }
}
