//! The cycles in which a control commands and a drive controls.

use super::AxisConfig;
use super::check::{AxisConfigError, between};
use super::drift::Change;
use super::friction::FrictionLaw;
use lostmotion_base::Clock;
use serde::{Deserialize, Serialize};

/// Longest current period that follows from the servo's cycle, us.
const USUAL_CURRENT_PERIOD_US: f64 = 50.0;

/// How often a control sends a setpoint, and how often position and velocity loop run. One divides
/// the other.
///
/// In a file: `[cycles]` with `command_ms` (0.25 to 8) and `servo_us` (31.25 to 1000), both whole
/// numbers of nanoseconds.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Cycles {
    /// Time from setpoint to setpoint, ms: the planner's and the bus' cycle.
    pub command_ms: f64,
    /// Time from servo tick to servo tick, us.
    pub servo_us: f64,
}

impl Default for Cycles {
    fn default() -> Cycles {
        Cycles {
            command_ms: 1.0,
            servo_us: 250.0,
        }
    }
}

fn nanos(value: f64, per_unit: f64) -> u64 {
    (value * per_unit).round() as u64
}

fn clock(period_ns: u64, otherwise: Clock) -> Clock {
    Clock::from_nanos(period_ns).unwrap_or(otherwise)
}

impl Cycles {
    /// The clock of the setpoints.
    pub fn command(&self) -> Clock {
        clock(nanos(self.command_ms, 1e6), Clock::CNC)
    }

    /// The clock of the servo.
    pub fn servo(&self) -> Clock {
        clock(nanos(self.servo_us, 1e3), Clock::SERVO)
    }

    /// Servo ticks for each setpoint.
    pub fn servo_ticks(&self) -> usize {
        self.command().ratio(self.servo()).unwrap_or(1) as usize
    }

    /// Whether they are 1 ms and 250 us.
    pub fn is_usual(&self) -> bool {
        *self == Cycles::default()
    }

    /// A time in servo ticks, to the nearest, at least one.
    pub fn ticks(&self, ms: f64) -> u32 {
        ((ms * 1e-3 / self.servo().period_s()).round() as u32).max(1)
    }

    /// The longest whole part of the servo's cycle that is a whole number of nanoseconds and no
    /// longer than 50 us, in us.
    pub fn usual_current_period_us(&self) -> f64 {
        let servo_ns = self.servo().period_ns();
        // fewest parts that are short enough, then the first number that divides the nanoseconds
        let least = (self.servo_us / USUAL_CURRENT_PERIOD_US).ceil() as u64;
        let parts = (least.max(1)..=servo_ns)
            .find(|parts| servo_ns.is_multiple_of(*parts))
            .unwrap_or(1);
        (servo_ns / parts) as f64 * 1e-3
    }

    /// Checks both and that one divides the other.
    ///
    /// # Errors
    /// The first value out of range.
    pub fn check(&self) -> Result<(), AxisConfigError> {
        between("command_ms", self.command_ms, 0.25, 8.0)?;
        between("servo_us", self.servo_us, 31.25, 1000.0)?;
        // clocks count whole nanoseconds, so that ticks stay in step however long a run is
        whole("command_ms", self.command_ms, 1e6)?;
        whole("servo_us", self.servo_us, 1e3)?;
        // a setpoint spans a whole number of servo ticks
        if self.command().ratio(self.servo()).is_none() {
            let allowed = format!(
                "a whole fraction of the command's {} us: 1/1, 1/2, 1/3, ...",
                self.command_ms * 1e3
            );
            return Err(AxisConfigError::Range {
                key: "servo_us".to_owned(),
                value: self.servo_us,
                allowed,
            });
        }
        Ok(())
    }
}

/// Whether a time is a whole number of nanoseconds.
pub(super) fn is_whole(value: f64, per_unit: f64) -> bool {
    let nanos = value * per_unit;
    (nanos - nanos.round()).abs() <= 1e-9 * nanos
}

fn whole(key: &str, value: f64, per_unit: f64) -> Result<(), AxisConfigError> {
    if is_whole(value, per_unit) {
        return Ok(());
    }
    Err(AxisConfigError::Range {
        key: key.to_owned(),
        value,
        allowed: "a whole number of nanoseconds".to_owned(),
    })
}

// How fast the parts of an axis move, against what a step of the current loop can resolve.

impl<C> AxisConfig<C> {
    /// Refuses parts so stiff, light or quick that a step of the current loop could not resolve
    /// them, at the start or by drift.
    pub(super) fn check_rates(&self) -> Result<(), AxisConfigError> {
        let inertia = self.motor_side_inertia_kgm2();
        let (mut motor, mut load) = (self.motor, self.reflected_load());
        // the worst that a drift reaches: lighter, stiffer, more viscous
        load.inertia_kgm2 *= reached(self.drift.load_inertia).min(1.0);
        load.viscous_nm_s_per_rad *= reached(self.drift.load_viscous).max(1.0);
        load.stiffness_nm_per_rad *= reached(self.drift.stiffness).max(1.0);
        motor.viscous_nm_s_per_rad *= reached(self.drift.motor_viscous).max(1.0);
        // two masses on a spring: omega^2 = k (1/J_M + 1/J_L)
        let joint = 1.0 / inertia + 1.0 / load.inertia_kgm2;
        // electrical and mechanical side of the motor as an oscillator: omega^2 = K_t K_e/(L J)
        let emf = motor.torque_constant_nm_per_a * motor.back_emf_v_s_per_rad()
            / (motor.phase_inductance_h() * inertia);
        let rates = [
            (
                "load: shaft resonance in rad/s (stiffness with both inertias)",
                (load.stiffness_nm_per_rad * joint).sqrt(),
                1e5,
            ),
            (
                "load: shaft damping in 1/s (damping with both inertias)",
                load.damping_nm_s_per_rad * joint,
                1e6,
            ),
            (
                "load: viscous friction over inertia in 1/s",
                load.viscous_nm_s_per_rad / load.inertia_kgm2,
                1e5,
            ),
            (
                "motor: viscous friction over inertia in 1/s",
                motor.viscous_nm_s_per_rad / inertia,
                1e5,
            ),
            (
                "motor: resistance over inductance in 1/s",
                motor.resistance_ohm / motor.inductance_h,
                1e5,
            ),
            (
                "motor: square root of K_t K_e/(L J) in rad/s",
                emf.sqrt(),
                1e5,
            ),
        ];
        rates
            .into_iter()
            .try_for_each(|(key, rate, highest)| between(key, rate, 0.0, highest))?;
        // deceleration by Coulomb friction, which scales the rates of the other friction laws
        let motor_coulomb = motor.coulomb_nm * reached(self.drift.motor_coulomb).max(1.0);
        let load_coulomb = load.coulomb_nm * reached(self.drift.load_coulomb).max(1.0);
        self.check_friction_rates(
            "friction.motor",
            self.friction.motor,
            motor_coulomb / inertia,
        )?;
        self.check_friction_rates(
            "friction.load",
            self.friction.load_at_motor(&self.transmission),
            load_coulomb / load.inertia_kgm2,
        )
    }

    /// The same for friction, `deceleration` being what Coulomb friction alone causes, rad/s2.
    fn check_friction_rates(
        &self,
        key: &str,
        law: FrictionLaw,
        deceleration: f64,
    ) -> Result<(), AxisConfigError> {
        let rate = |what: &str, value: f64, highest: f64| {
            between(&format!("{key}: {what}"), value, 0.0, highest)
        };
        match law {
            FrictionLaw::Coulomb => Ok(()),
            // falling friction is a negative damping: a disturbance grows at this rate
            FrictionLaw::Stribeck(law) => rate(
                "fall of friction over inertia in 1/s",
                deceleration * (law.static_factor - 1.0) / law.speed_units_s,
                1e5,
            ),
            FrictionLaw::Lugre(law) => {
                // no-load speed: phase voltage of the inverter over the back-EMF constant
                let fastest =
                    self.drive.bus_voltage_v / 3.0_f64.sqrt() / self.motor.back_emf_v_s_per_rad();
                // a bristle is bent over anew each time the presliding way is travelled
                rate(
                    "motor's no-load speed over presliding in 1/s",
                    fastest / law.presliding_units,
                    1e6,
                )?;
                // the mass on its bristles: omega^2 = sigma_0/J with sigma_0 = F_c/presliding
                rate(
                    "bristle resonance in rad/s",
                    (deceleration / law.presliding_units).sqrt(),
                    1e5,
                )?;
                rate(
                    "bristle damping over inertia in 1/s",
                    deceleration / law.presliding_units * law.damping_s,
                    1e5,
                )
            }
        }
    }
}

fn reached(change: Option<Change>) -> f64 {
    change.map_or(1.0, |change| change.factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_of_usual_cycles_is_good_where_one_divides_the_other() {
        for command_ms in [0.25, 0.5, 1.0, 2.0, 4.0, 8.0] {
            for servo_us in [31.25, 62.5, 125.0, 250.0, 500.0, 1000.0] {
                let cycles = Cycles {
                    command_ms,
                    servo_us,
                };
                assert_eq!(
                    cycles.check().is_ok(),
                    servo_us <= 1e3 * command_ms,
                    "{cycles:?}"
                );
                let parts = servo_us / cycles.usual_current_period_us();
                assert!(
                    (parts - parts.round()).abs() < 1e-12
                        && cycles.usual_current_period_us() <= 50.0,
                    "{cycles:?}"
                );
            }
        }
        assert_eq!(
            Cycles {
                command_ms: 8.0,
                servo_us: 31.25
            }
            .servo_ticks(),
            256
        );
        assert!((Cycles::default().usual_current_period_us() - 50.0).abs() < 1e-12);
        assert!(
            (Cycles {
                servo_us: 125.0,
                ..Cycles::default()
            }
            .usual_current_period_us()
                - 31.25)
                .abs()
                < 1e-12
        );
    }

    #[test]
    fn what_does_not_divide_or_is_no_whole_nanosecond_is_refused() {
        let refused = |command_ms, servo_us| {
            Cycles {
                command_ms,
                servo_us,
            }
            .check()
            .unwrap_err()
            .to_string()
        };
        assert_eq!(
            refused(1.0, 400.0),
            "servo_us is 400; it has to be a whole fraction of the command's 1000 us: 1/1, 1/2, 1/3, ..."
        );
        assert!(refused(1.0, 333.333_333_3).contains("whole number of nanoseconds"));
        assert!(refused(9.0, 250.0).contains("from 0.25 to 8"));
        assert!(refused(f64::NAN, 250.0).starts_with("command_ms is NaN"));
        assert!(refused(1.0, 30.0).contains("from 31.25 to 1000"));
        assert!(refused(0.25, 500.0).contains("a whole fraction"));
    }
}
