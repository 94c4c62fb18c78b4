//! Two axes whose loads a spring ties: the ends of a stiff beam on two screws.
//!
//! ```text
//! F = k (y1 - y2 - r) + d (v1 - v2)        r: what y1 - y2 was when the beam was squared up
//! ```
//! The force is held over a period of the current loop and taken in its middle, y + v h/2, so that
//! each end's plant goes its exact step and the beam's swing is that of Stoermer's method (drift,
//! kick, drift: for free ends it neither gains nor loses energy). Both ends are stepped period by
//! period.

use crate::config::{AxisConfig, AxisConfigError};
use crate::error::AxisError;
use crate::plant::PlantState;
use crate::runner::{AxisOutput, AxisRunner, CurrentLoop};
use crate::signal::Setpoint;
use serde::{Deserialize, Serialize};

/// Largest part of a swing of the beam, rad, in a period of the current loop; at 2 the method
/// diverges, at 0.5 its frequency is 1 % off.
const MOST_PER_PERIOD: f64 = 0.5;

/// The spring and its damper.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Tie {
    /// Stiffness of the beam against one end running ahead, force per skew of the ends, N/um.
    pub stiffness_n_per_um: f64,
    /// Damping, N s/mm.
    #[serde(default)]
    pub damping_n_s_per_mm: f64,
}

impl Tie {
    /// Checks it against the ends that it ties.
    ///
    /// # Errors
    /// A value that is negative or not finite, a tie so stiff that its swing is faster than the
    /// current loop can follow, ends that turn.
    pub fn check<C>(&self, ends: [&AxisConfig<C>; 2]) -> Result<(), AxisConfigError> {
        let range = |key: &str, value: f64, allowed: String| {
            Err(AxisConfigError::Range {
                key: key.to_owned(),
                value,
                allowed,
            })
        };
        if !(self.damping_n_s_per_mm >= 0.0 && self.damping_n_s_per_mm <= 1e6) {
            return range(
                "damping_n_s_per_mm",
                self.damping_n_s_per_mm,
                "from 0 to 1e6".to_owned(),
            );
        }
        // the ends swing against each other at sqrt(k (1/m1 + 1/m2))
        let mobility = |end: &AxisConfig<C>| {
            let reach_m = end.transmission.load_per_motor_rad();
            reach_m * reach_m / end.reflected_load().inertia_kgm2
        };
        let rate = MOST_PER_PERIOD / (ends[0].current_period_us() * 1e-6);
        let stiffest = rate * rate / (mobility(ends[0]) + mobility(ends[1])) * 1e-6;
        if !(self.stiffness_n_per_um >= 0.0 && self.stiffness_n_per_um <= stiffest) {
            return range(
                "stiffness_n_per_um",
                self.stiffness_n_per_um,
                format!("from 0 to {stiffest:.0} at this current loop and these masses"),
            );
        }
        Ok(())
    }
}

/// Two axes with the same cycles, and a tie between their loads.
pub struct TiedAxes {
    axes: [Box<dyn AxisRunner>; 2],
    /// Stiffness, N/m, and damping, N s/m.
    tie: [f64; 2],
    /// m of each load for a rad of its motor.
    reach_m: [f64; 2],
    period_s: f64,
    /// y1 - y2 without a force, m.
    rest_m: f64,
}

impl TiedAxes {
    /// Ties two axes as they stand: the beam is without a force there.
    ///
    /// # Errors
    /// A tie that does not fit the ends ([`Tie::check`]).
    pub fn new<C>(
        axes: [Box<dyn AxisRunner>; 2],
        configs: [&AxisConfig<C>; 2],
        tie: Tie,
    ) -> Result<TiedAxes, AxisConfigError> {
        tie.check(configs)?;
        let reach_m = configs.map(|config| config.transmission.load_per_motor_rad());
        let place = |end: usize| axes[end].plant().load_position * reach_m[end];
        Ok(TiedAxes {
            rest_m: place(0) - place(1),
            tie: [tie.stiffness_n_per_um * 1e6, tie.damping_n_s_per_mm * 1e3],
            period_s: configs[0].current_period_us() * 1e-6,
            axes,
            reach_m,
        })
    }

    /// The axes.
    pub fn axes(&self) -> impl Iterator<Item = &dyn AxisRunner> {
        self.axes.iter().map(|axis| &**axis)
    }

    /// Gives both axes their setpoints, as [`AxisRunner::push`] does with one.
    ///
    /// # Errors
    /// As there, with the number of the end (0 or 1) whose setpoint it was. Setpoints before it
    /// have been taken.
    pub fn push(
        &mut self,
        setpoints: [&[Setpoint]; 2],
        out: [&mut AxisOutput; 2],
    ) -> Result<(), (usize, AxisError)> {
        let [out0, out1] = out;
        let ticks = self.axes[0].servo_ticks() as u32;
        for (first, second) in setpoints[0].iter().zip(setpoints[1]) {
            // both ends take the setpoint before either moves: the tie couples them period by
            // period
            for (end, setpoint) in [first, second].into_iter().enumerate() {
                self.axes[end]
                    .begin_setpoint(setpoint)
                    .map_err(|error| (end, error))?;
            }
            for index in 0..ticks {
                self.axes[0].begin_tick(index, out0);
                self.axes[1].begin_tick(index, out1);
                self.periods(out0, out1);
            }
            for (axis, out) in self.axes.iter_mut().zip([&mut *out0, &mut *out1]) {
                let peak_current_a = out.peak_current_a;
                axis.current_loop().monitor(ticks, peak_current_a, out);
            }
        }
        Ok(())
    }

    fn periods(&mut self, out0: &mut AxisOutput, out1: &mut AxisOutput) {
        let (tie, reach, rest, half_s) = (self.tie, self.reach_m, self.rest_m, 0.5 * self.period_s);
        let [first, second] = &mut self.axes;
        let (mut first, mut second): (CurrentLoop<'_>, CurrentLoop<'_>) =
            (first.current_loop(), second.current_loop());
        // the tie adds to the forces that came with the setpoints
        let told = [first.load_torque, second.load_torque];
        for _ in 0..first.periods() {
            // skew of the ends in metres, in the middle of the period
            let ahead = |of: &dyn Fn(&PlantState) -> f64| {
                of(first.plant_state) * reach[0] - of(second.plant_state) * reach[1]
            };
            let faster = ahead(&|plant| plant.load_velocity);
            let force = tie[0] * (ahead(&|plant| plant.load_position) - rest + faster * half_s)
                + tie[1] * faster;
            // A load's torque counts against its positive direction.
            first.load_torque = told[0] + force * reach[0];
            second.load_torque = told[1] - force * reach[1];
            first.period(&mut out0.peak_current_a);
            second.period(&mut out1.peak_current_a);
        }
        first.finish(out0);
        second.finish(out1);
    }
}
