//! How fast the parts of an axis move, against what a step of the current loop can resolve.

use super::check::between;
use super::drift::Change;
use super::friction::FrictionLaw;
use super::{AxisConfig, AxisConfigError};

impl<C> AxisConfig<C> {
    /// Refuses parts so stiff, light or quick that a step of the current loop could not resolve
    /// them, at the start or by drift.
    pub(super) fn check_rates(&self) -> Result<(), AxisConfigError> {
        let inertia = self.motor_side_inertia_kgm2();
        let (mut motor, mut load) = (self.motor, self.reflected_load());
        load.inertia_kgm2 *= reached(self.drift.load_inertia).min(1.0);
        load.viscous_nm_s_per_rad *= reached(self.drift.load_viscous).max(1.0);
        load.stiffness_nm_per_rad *= reached(self.drift.stiffness).max(1.0);
        motor.viscous_nm_s_per_rad *= reached(self.drift.motor_viscous).max(1.0);
        let joint = 1.0 / inertia + 1.0 / load.inertia_kgm2;
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
            FrictionLaw::Stribeck(law) => rate(
                "fall of friction over inertia in 1/s",
                deceleration * (law.static_factor - 1.0) / law.speed_units_s,
                1e5,
            ),
            FrictionLaw::Lugre(law) => {
                let fastest =
                    self.drive.bus_voltage_v / 3.0_f64.sqrt() / self.motor.back_emf_v_s_per_rad();
                rate(
                    "motor's no-load speed over presliding in 1/s",
                    fastest / law.presliding_units,
                    1e6,
                )?;
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
