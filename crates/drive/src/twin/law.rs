//! The equations of a twin's motor, shaft and load over one period of the current loop: see the head
//! of [`crate::twin`].

use super::LoadModel;
use crate::config::AxisConfig;
use crate::number::numbers;
use crate::plant::PlantState;
use lostmotion_base::Number;

numbers! {
    /// What the motor's equations compute with, over a period h of the current loop.
    MotorNumbers {
        /// Part of the current that a period leaves, 1/(1 + R h/L).
        current_keep,
        /// Current that a voltage adds in a period, A/V.
        current_gain,
        /// Current that the motor's speed takes in a period, A s/rad.
        current_brake,
        /// N m/A.
        torque_constant,
        /// N m s/rad.
        viscous,
        /// Torque that the motor's speed takes, by the current that it takes and by viscous friction, N m s/rad.
        brake,
        /// N m.
        coulomb,
        /// h/J_M.
        motor_step,
        /// What Coulomb friction takes of the speed in a period, rad/s.
        motor_most,
        /// J_M/h: the torque for a change of speed.
        friction_scale,
    }
}

numbers! {
    /// What the load's equations compute with, as long as the load stays the same.
    Rates {
        /// N m.
        load_constant,
        /// N m s/rad.
        load_viscous,
        /// N m.
        load_coulomb,
        /// h/J_L.
        load_step,
        /// What Coulomb friction takes of the speed in a period, rad/s.
        load_most,
        /// N m/rad.
        stiffness,
        /// h k + d: the torque of the shaft for a speed of its ends against each other, N m s/rad.
        by_rate,
        /// g/J_M: its torque for one on the motor.
        by_motor,
        /// g/J_L: its torque for one on the load.
        by_load,
        /// Part of it that is left where its ends give way to it: both,
        both_give,
        /// the motor alone,
        motor_gives,
        /// the load alone.
        load_gives,
    }
}

numbers! {
    /// Where motor, shaft and load of a twin are.
    TwinMasses {
        /// i_q, A.
        current,
        /// Angle of the motor ahead of the load, rad.
        lead,
        /// Speed of the motor, rad/s.
        motor,
        /// Speed of the load, rad/s.
        load,
        /// Position of the load, rad.
        place,
    }
}

impl PlantState {
    /// Where a twin is that keeps its state as a plant's.
    #[inline]
    pub(crate) fn masses(&self) -> TwinMasses<f64> {
        TwinMasses {
            current: self.current_q,
            lead: self.gap_angle,
            motor: self.motor_velocity,
            load: self.load_velocity,
            place: self.load_position,
        }
    }

    /// Puts it there.
    #[inline]
    pub(crate) fn take(&mut self, masses: &TwinMasses<f64>) {
        self.current_q = masses.current;
        self.gap_angle = masses.lead;
        self.motor_velocity = masses.motor;
        self.load_velocity = masses.load;
        self.load_position = masses.place;
    }
}

/// Torques in a period, N m.
#[derive(Clone, Copy, Debug)]
pub(crate) struct TwinTorques<N> {
    /// Of the shaft on the load.
    pub(crate) shaft: N,
    /// Of the motor's Coulomb friction on the motor.
    pub(crate) motor_friction: N,
}

/// What each end of the shaft gives way to its torque: by [`Rates`], less where friction holds it.
#[derive(Clone, Copy)]
pub(super) struct Gives<N> {
    by_motor: N,
    by_load: N,
    /// Part of the torque that is left.
    left: N,
}

impl<N: Number> Rates<N> {
    /// While neither is held.
    #[inline(always)]
    pub(super) fn free(&self) -> Gives<N> {
        Gives {
            by_motor: self.by_motor,
            by_load: self.by_load,
            left: self.both_give,
        }
    }
}

/// A period without Coulomb friction.
#[derive(Clone, Copy)]
pub(super) struct Frictionless<N> {
    /// i_q at its end, A.
    pub(super) current: N,
    /// Torque of the shaft on the load, N m.
    pub(super) shaft: N,
    /// Speeds of motor and load at its end, rad/s.
    pub(super) motor: N,
    pub(super) load: N,
}

impl<N: Number> TwinMasses<N> {
    /// After a period at whose end current and speeds are these.
    #[inline(always)]
    pub(super) fn moved(&self, h: N, current: N, motor: N, load: N) -> TwinMasses<N> {
        // semi-implicit: positions go on with the new speeds
        TwinMasses {
            current,
            lead: self.lead + h * (motor - load),
            motor,
            load,
            place: self.place + h * load,
        }
    }
}

impl<N: Number> MotorNumbers<N> {
    /// One period h of the current loop with a held voltage: see the head of [`crate::twin`].
    #[inline(always)]
    pub(crate) fn advance(
        &self,
        rates: &Rates<N>,
        x: &TwinMasses<N>,
        h: N,
        voltage: N,
    ) -> (TwinMasses<N>, TwinTorques<N>) {
        let (zero, one) = (h.zero(), h.constant(1.0));
        // friction that holds a mass at rest takes whatever torque the shaft puts on it
        let holds = |coulomb: N, speed: N| zero.less(coulomb) & speed.abs().at_most(zero);
        let (motor_holds, load_holds) = (
            holds(self.coulomb, x.motor),
            holds(rates.load_coulomb, x.load),
        );
        let gives = Gives {
            by_motor: N::choose(motor_holds, zero, rates.by_motor),
            by_load: N::choose(load_holds, zero, rates.by_load),
            left: N::choose(
                motor_holds,
                N::choose(load_holds, one, rates.load_gives),
                N::choose(load_holds, rates.motor_gives, rates.both_give),
            ),
        };
        let free = self.frictionless(rates, x, voltage, &gives);
        let (motor, friction) = slide(x.motor, free.motor, self.motor_most);
        let (load, _) = slide(x.load, free.load, rates.load_most);
        let torques = TwinTorques {
            shaft: free.shaft,
            motor_friction: friction * self.friction_scale,
        };
        (x.moved(h, free.current, motor, load), torques)
    }

    /// What it comes to before Coulomb friction takes its part.
    #[inline(always)]
    pub(super) fn frictionless(
        &self,
        rates: &Rates<N>,
        x: &TwinMasses<N>,
        voltage: N,
        gives: &Gives<N>,
    ) -> Frictionless<N> {
        // the winding, implicit in the current, and the motor's torque with it
        let pushed = self.current_keep * x.current + self.current_gain * voltage;
        let current = pushed - self.current_brake * x.motor;
        let drive = self.torque_constant * pushed - self.brake * x.motor;
        let drag = -rates.load_constant - rates.load_viscous * x.load;
        // the shaft's torque, implicit in the ends' accelerations
        let wound =
            rates.stiffness * x.lead + rates.by_rate * (x.motor - x.load) - gives.by_load * drag;
        let shaft = (wound + gives.by_motor * drive) * gives.left;
        Frictionless {
            current,
            shaft,
            motor: (x.motor + self.motor_step * drive) - self.motor_step * shaft,
            load: (x.load + rates.load_step * drag) + rates.load_step * shaft,
        }
    }
}

/// What Coulomb friction that takes at most `most` leaves of the speed that a mass would have without it;
/// and what the friction added.
#[inline(always)]
fn slide<N: Number>(speed: N, free: N, most: N) -> (N, N) {
    let zero = speed.zero();
    let taken = free.clamp(-most, most);
    let left = free - taken;
    // friction acts against the sliding before, so it can stop a mass within the step and not turn
    // it round
    let stops = (speed * left).less(zero);
    (N::choose(stops, zero, left), -N::choose(stops, free, taken))
}

impl MotorNumbers<f64> {
    pub(super) fn new<C>(config: &AxisConfig<C>, inertia: f64, h: f64) -> MotorNumbers<f64> {
        let motor = &config.motor;
        // implicit Euler in the winding: i' = (i + h/L (u - K_e w)) / (1 + R h/L)
        let share = h / motor.phase_inductance_h();
        let keep = 1.0 / (1.0 + share * motor.phase_resistance_ohm());
        let (gain, viscous) = (share * keep, motor.viscous_nm_s_per_rad);
        let current_brake = gain * motor.back_emf_v_s_per_rad();
        MotorNumbers {
            current_keep: keep,
            current_gain: gain,
            current_brake,
            torque_constant: motor.torque_constant_nm_per_a,
            viscous,
            brake: motor.torque_constant_nm_per_a * current_brake + viscous,
            coulomb: motor.coulomb_nm,
            motor_step: h / inertia,
            motor_most: h / inertia * motor.coulomb_nm,
            friction_scale: inertia / h,
        }
    }
}

impl Rates<f64> {
    #[inline]
    pub(super) fn new(load: &LoadModel, motor_step: f64, h: f64) -> Rates<f64> {
        let load_step = h / load.inertia;
        let by_rate = h * load.stiffness + load.damping;
        let (by_motor, by_load) = (by_rate * motor_step, by_rate * load_step);
        Rates {
            load_constant: load.constant,
            load_viscous: load.viscous,
            load_coulomb: load.coulomb,
            load_step,
            load_most: load_step * load.coulomb,
            stiffness: load.stiffness,
            by_rate,
            by_motor,
            by_load,
            both_give: 1.0 / (1.0 + by_motor + by_load),
            motor_gives: 1.0 / (1.0 + by_motor),
            load_gives: 1.0 / (1.0 + by_load),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_stops_a_mass_and_then_holds_it() {
        assert_eq!(slide(1.0, 1.0, 0.25), (0.75, -0.25));
        assert_eq!(slide(0.1, 0.1, 0.25).0, 0.0);
        assert_eq!(slide(0.0, 0.2, 0.25), (0.0, -0.2));
        assert_eq!(slide(0.0, -0.3, 0.25).0, -0.3 + 0.25);
    }
}
