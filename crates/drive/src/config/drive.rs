//! The drive: loops, limits, encoder.

use super::check::{AxisConfigError, between, not_negative, positive};
use super::cycles::{Cycles, is_whole};
use super::filter::TorqueFilters;
use super::loops::{AntiWindup, FrictionFeedforward, LeastMargins};
use serde::{Deserialize, Serialize};

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
    /// Friction fed forward; none if left out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub friction_feedforward: Option<FrictionFeedforward>,
    /// Filters on the current command, in series; none if left out.
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
