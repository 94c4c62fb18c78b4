//! The drive: loops, limits, encoder.

use super::check::{AxisConfigError, between, not_negative, positive};
use super::cycles::{Cycles, is_whole};
use super::filter::TorqueFilters;
use super::load::Reflected;
use super::motor::Motor;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Settings of the cascade: position P and velocity PI every servo cycle (250 us unless [`Cycles`]
/// say otherwise), current PI every [`Drive::current_period_us`].
///
/// Delays: position, velocity and current command are computed from the encoder at a servo tick and
/// take effect `command_delay_periods` current periods after it; a voltage takes effect
/// `voltage_delay_periods` current periods after the current it was computed from. The velocity is
/// the encoder's difference over the last servo period, half a period old on average; the velocity
/// feed-forward is the difference of the reference over the same period, so the two match.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Drive {
    /// Proportional gain of the current loop, V/A.
    pub current_gain_v_per_a: f64,
    /// Integral time of the current loop, s.
    pub current_time_s: f64,
    /// Proportional gain of the velocity loop, A s/rad.
    pub velocity_gain_a_s_per_rad: f64,
    /// Integral time of the velocity loop, s.
    pub velocity_time_s: f64,
    /// Gain of the position loop (Kv), 1/s.
    pub position_gain_per_s: f64,
    /// Part of the reference velocity that is fed forward, 0 to 1.
    #[serde(default)]
    pub velocity_feedforward: f64,
    /// Part of the reference acceleration that is fed forward, 0 to 1.
    #[serde(default)]
    pub acceleration_feedforward: f64,
    /// Inertia that the drive was told for its acceleration feed-forward, kg m2 at the motor; motor
    /// and load if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub told_inertia_kgm2: Option<f64>,
    /// Largest current, A (amplitude of i_q).
    pub current_limit_a: f64,
    /// Voltage of the DC bus, V. The voltage vector is limited to bus / sqrt(3).
    pub bus_voltage_v: f64,
    /// Counts of the motor's encoder for one turn, after interpolation; an ideal encoder if left
    /// out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub encoder_counts_per_rev: Option<u32>,
    /// Period of the current loop, us: a whole fraction of the servo's cycle, 1 to 250. If left
    /// out, the longest up to 50 us.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub current_period_us: Option<f64>,
    /// Current periods between a current measurement and the voltage computed from it, 0 or 1.
    #[serde(default)]
    pub voltage_delay_periods: u32,
    /// Current periods between the encoder's reading and the current command computed from it, up
    /// to two servo periods.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub command_delay_periods: u32,
    /// Friction fed forward; nothing if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction_feedforward: Option<FrictionFeedforward>,
    /// Filters on the current command, in series; no filter if left out.
    #[serde(default, skip_serializing_if = "TorqueFilters::is_empty")]
    pub torque_filter: TorqueFilters,
    /// What the velocity loop's integral does at a limit.
    #[serde(default, skip_serializing_if = "AntiWindup::is_default")]
    pub anti_windup: AntiWindup,
    /// Margins that the loops have to keep when the machine is checked.
    #[serde(default, skip_serializing_if = "LeastMargins::is_default")]
    pub least_margins: LeastMargins,
}

#[allow(
    clippy::trivially_copy_pass_by_ref,
    reason = "serde hands over a reference"
)]
fn is_zero(number: &u32) -> bool {
    *number == 0
}

impl Drive {
    /// Checks every value.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self, cycles: &Cycles) -> Result<(), AxisConfigError> {
        positive("current_gain_v_per_a", self.current_gain_v_per_a)?;
        positive("current_time_s", self.current_time_s)?;
        positive("velocity_gain_a_s_per_rad", self.velocity_gain_a_s_per_rad)?;
        positive("velocity_time_s", self.velocity_time_s)?;
        not_negative("position_gain_per_s", self.position_gain_per_s)?;
        between("velocity_feedforward", self.velocity_feedforward, 0.0, 1.0)?;
        between(
            "acceleration_feedforward",
            self.acceleration_feedforward,
            0.0,
            1.0,
        )?;
        if let Some(told) = self.told_inertia_kgm2 {
            positive("told_inertia_kgm2", told)?;
        }
        positive("current_limit_a", self.current_limit_a)?;
        positive("bus_voltage_v", self.bus_voltage_v)?;
        if let Some(counts) = self.encoder_counts_per_rev {
            between(
                "encoder_counts_per_rev",
                f64::from(counts),
                16.0,
                f64::from(u32::MAX),
            )?;
        }
        between(
            "voltage_delay_periods",
            f64::from(self.voltage_delay_periods),
            0.0,
            1.0,
        )?;
        self.check_current_period(cycles)?;
        // the drive keeps the present command and two earlier ones
        let longest = 2 * self.current_periods(cycles);
        between(
            "command_delay_periods",
            f64::from(self.command_delay_periods),
            0.0,
            f64::from(longest),
        )?;
        self.friction_feedforward
            .map_or(Ok(()), |friction| friction.check())?;
        self.torque_filter.check(cycles.servo().period_s())?;
        self.least_margins.check()
    }

    fn check_current_period(&self, cycles: &Cycles) -> Result<(), AxisConfigError> {
        let period = self.current_period_us(cycles);
        between("current_period_us", period, 1.0, 250.0)?;
        // steps are whole nanoseconds, and a whole number of them fills the servo period
        let parts = cycles.servo_us / period;
        if is_whole(period, 1e3) && is_whole(parts, 1.0) {
            return Ok(());
        }
        let allowed = format!(
            "a whole fraction of the servo's {} us, such as {}",
            cycles.servo_us,
            cycles.usual_current_period_us()
        );
        Err(AxisConfigError::Range {
            key: "current_period_us".to_owned(),
            value: period,
            allowed,
        })
    }

    /// Period of the current loop, us.
    pub fn current_period_us(&self, cycles: &Cycles) -> f64 {
        self.current_period_us
            .unwrap_or_else(|| cycles.usual_current_period_us())
    }

    /// Current periods in a servo period.
    pub fn current_periods(&self, cycles: &Cycles) -> u32 {
        (cycles.servo_us / self.current_period_us(cycles)).round() as u32
    }
}

// What a drive's loops do besides their gains: friction feed-forward, anti-windup, and the margins
// asked of them.

/// Torque fed forward against friction: `coulomb w/sqrt(w^2 + smoothing^2) + viscous w`, w the
/// reference's mean velocity over the coming servo period, rad/s at the motor.
///
/// The smoothing keeps the torque from jumping at a reversal: at `w = smoothing` it is 71 % of the
/// Coulomb friction.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionFeedforward {
    /// Coulomb friction that the drive was told, N m at the motor.
    pub coulomb_nm: f64,
    /// Viscous friction that the drive was told, N m s/rad at the motor.
    #[serde(default)]
    pub viscous_nm_s_per_rad: f64,
    /// Velocity over which the sign is smoothed, rad/s at the motor.
    #[serde(default = "smoothing_rad_s")]
    pub smoothing_rad_s: f64,
}

fn smoothing_rad_s() -> f64 {
    0.1
}

impl FrictionFeedforward {
    pub(super) fn check(&self) -> Result<(), AxisConfigError> {
        not_negative("friction_feedforward.coulomb_nm", self.coulomb_nm)?;
        not_negative(
            "friction_feedforward.viscous_nm_s_per_rad",
            self.viscous_nm_s_per_rad,
        )?;
        positive("friction_feedforward.smoothing_rad_s", self.smoothing_rad_s)
    }
}

/// What the velocity loop's integral does while the current command is cut at its limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AntiWindup {
    /// Back-calculation: a command cut by `delta` moves the integral by `delta` times period over
    /// integral time, so the tracking time is the integral time. While the voltage is at its limit
    /// the integral ignores an error that demands still more torque. Source: Astrom and
    /// Haegglund, *Advanced PID Control* (2006), section 3.5.
    #[default]
    BackCalculation,
    /// Conditional integration: while current or voltage is at its limit the integral ignores
    /// an error that demands still more torque.
    Conditional,
    /// None: the integral goes on. For showing what the others are there for.
    None,
}

/// Margins below which the crate `lostmotion-analysis` calls a loop badly tuned.
///
/// The defaults are low: they refuse what is about to oscillate, not what a commissioning engineer
/// would do better.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeastMargins {
    /// Phase margin, deg.
    #[serde(default = "phase_deg")]
    pub phase_deg: f64,
    /// Gain margin, dB.
    #[serde(default = "gain_db")]
    pub gain_db: f64,
}

fn phase_deg() -> f64 {
    15.0
}

fn gain_db() -> f64 {
    3.0
}

impl Default for LeastMargins {
    fn default() -> LeastMargins {
        LeastMargins {
            phase_deg: phase_deg(),
            gain_db: gain_db(),
        }
    }
}

impl LeastMargins {
    pub(super) fn check(&self) -> Result<(), AxisConfigError> {
        not_negative("least_margins.phase_deg", self.phase_deg)?;
        not_negative("least_margins.gain_db", self.gain_db)
    }

    /// Whether these are the defaults.
    pub fn is_default(&self) -> bool {
        *self == LeastMargins::default()
    }
}

impl AntiWindup {
    /// Whether this is the default.
    pub fn is_default(&self) -> bool {
        *self == AntiWindup::default()
    }
}

// A stated rule for a drive's gains, so that every machine of a catalogue is tuned the same way.

/// What the gains of a drive follow from.
///
/// Rule:
/// - current PI by pole-zero cancellation: integral time `L/R`, gain `2 pi f_c L`, so the closed
///   loop is a first-order lag of bandwidth `f_c`;
/// - velocity PI for the rigid axis, inertia `J` of rotor, screw and load: natural frequency
///   `w_n = 2 pi f_v` and damping `D`, so the gain is `(2 D w_n J - b)/K_t` and the integral time
///   `(2 D w_n J - b)/(w_n^2 J)`;
/// - position gain `Kv = position_ratio * w_n`.
///
/// `f_v` has to stay well below the first resonance and below what the loop's delays allow.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tuning {
    /// Bandwidth f_c of the current loop, Hz.
    pub current_bandwidth_hz: f64,
    /// Natural frequency f_v of the velocity loop, Hz.
    pub velocity_frequency_hz: f64,
    /// Damping D of the velocity loop.
    pub velocity_damping: f64,
    /// Position gain over the velocity loop's natural frequency (rad/s).
    pub position_ratio: f64,
    /// Part of the velocity that is fed forward, 0 to 1.
    pub velocity_feedforward: f64,
    /// Part of the acceleration that is fed forward, 0 to 1.
    pub acceleration_feedforward: f64,
}

impl Default for Tuning {
    /// A stiffly tuned machine tool axis: 800 Hz, 40 Hz, D 1, ratio 1/4 (Kv 63 1/s), full
    /// feed-forward.
    fn default() -> Tuning {
        Tuning {
            current_bandwidth_hz: 800.0,
            velocity_frequency_hz: 40.0,
            velocity_damping: 1.0,
            position_ratio: 0.25,
            velocity_feedforward: 1.0,
            acceleration_feedforward: 1.0,
        }
    }
}

impl Drive {
    /// A drive whose gains follow from the motor and the load by the rule of [`Tuning`].
    ///
    /// The limits are the caller's: `current_limit_a` as i_q amplitude, `bus_voltage_v` as DC. The
    /// encoder is ideal, the current loop has its usual period (50 us) and one period of delay; all
    /// fields can be set afterwards.
    pub fn tuned(
        motor: &Motor,
        load: &Reflected,
        tuning: &Tuning,
        current_limit_a: f64,
        bus_voltage_v: f64,
    ) -> Drive {
        // data sheets give line to line; the loops act on phases
        let inductance = motor.phase_inductance_h();
        let inertia = motor.inertia_kgm2 + load.motor_side_inertia_kgm2 + load.inertia_kgm2;
        let viscous = motor.viscous_nm_s_per_rad + load.viscous_nm_s_per_rad;
        let natural = TAU * tuning.velocity_frequency_hz;
        // characteristic polynomial of the rigid axis with PI: J s^2 + (b + K_t K_v) s + K_t
        // K_v/T_v, compared with s^2 + 2 D w_n s + w_n^2
        let damping_torque = 2.0 * tuning.velocity_damping * natural * inertia - viscous;
        Drive {
            current_gain_v_per_a: TAU * tuning.current_bandwidth_hz * inductance,
            // pole-zero cancellation: the zero of the PI on the pole R/L of the winding
            current_time_s: inductance / motor.phase_resistance_ohm(),
            velocity_gain_a_s_per_rad: damping_torque / motor.torque_constant_nm_per_a,
            velocity_time_s: damping_torque / (natural * natural * inertia),
            position_gain_per_s: tuning.position_ratio * natural,
            velocity_feedforward: tuning.velocity_feedforward,
            acceleration_feedforward: tuning.acceleration_feedforward,
            told_inertia_kgm2: None,
            current_limit_a,
            bus_voltage_v,
            encoder_counts_per_rev: None,
            current_period_us: None,
            voltage_delay_periods: 1,
            command_delay_periods: 0,
            friction_feedforward: None,
            torque_filter: TorqueFilters::default(),
            anti_windup: AntiWindup::default(),
            least_margins: LeastMargins::default(),
        }
    }
}
