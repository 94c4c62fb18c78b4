//! Axes that come with the library.

use super::AxisConfig;
use super::cycles::Cycles;
use super::drift::Drift;
use super::drive::{AntiWindup, Drive, LeastMargins};
use super::filter::TorqueFilters;
use super::flanks::{ContactLaw, Flanks, StartInGap};
use super::friction::Frictions;
use super::load::{Load, Reflected};
use super::monitoring::Monitoring;
use super::motor::{Motor, Ripple};
use super::reference::Interpolator;
use super::scale::Scale;
use super::transmission::{AxisUnit, Rotary, Transmission};

impl<C: Default> AxisConfig<C> {
    /// The axis of Gan, Wang, Huang, *Adaptive Backlash Compensation for CNC Machining
    /// Applications*, Machines 2023, 11(2), 193, Tables 2 and 3: a rotary axis in rad at the
    /// motor's shaft, its 5:1 gear already reflected.
    ///
    /// The paper gives no current limit, bus voltage, rated torque or encoder: limits are set so
    /// wide (60 A, 560 V) that its motion does not meet them, the rated torque is taken as 11 N m,
    /// the encoder is ideal. The viscous friction sits on the motor, as in the paper's equation
    /// (2). The velocity gain of 1.74 is in A s/rad: with K_t = 1.08 and the total inertia that is
    /// a natural frequency of 161 rad/s with damping 0.70. The printed voltage constant (296
    /// V/krpm) contradicts K_t and is not used.
    pub fn paper() -> AxisConfig<C> {
        AxisConfig {
            transmission: Transmission::Rotary(Rotary {
                gear: 1.0,
                unit: AxisUnit::Rad,
            }),
            motor: Motor {
                resistance_ohm: 0.42,
                inductance_h: 4.5e-3,
                poles: 10,
                inertia_kgm2: 0.00189,
                torque_constant_nm_per_a: 1.08,
                // not in the paper
                rated_torque_nm: 11.0,
                viscous_nm_s_per_rad: 0.01,
                coulomb_nm: 0.0,
            },
            load: Load::Reflected(Reflected {
                inertia_kgm2: 0.0065,
                motor_side_inertia_kgm2: 0.0,
                viscous_nm_s_per_rad: 0.0,
                coulomb_nm: 0.0,
                constant_nm: 0.0,
                stiffness_nm_per_rad: 2000.0,
                damping_nm_s_per_rad: 0.8,
                gap_rad: 0.2,
                scale_rad: 0.0,
            }),
            drive: Drive {
                current_gain_v_per_a: 15.0,
                current_time_s: 1.85e-3,
                velocity_gain_a_s_per_rad: 1.74,
                velocity_time_s: 8.6e-3,
                position_gain_per_s: 25.0,
                velocity_feedforward: 0.0,
                acceleration_feedforward: 0.0,
                told_inertia_kgm2: None,
                // neither limit is in the paper: so wide that its motion does not meet them
                current_limit_a: 60.0,
                bus_voltage_v: 560.0,
                encoder_counts_per_rev: None,
                current_period_us: None,
                voltage_delay_periods: 0,
                command_delay_periods: 0,
                friction_feedforward: None,
                torque_filter: TorqueFilters::default(),
                anti_windup: AntiWindup::default(),
                least_margins: LeastMargins::default(),
            },
            contact: ContactLaw::Linear,
            start_in_gap: StartInGap(0.0),
            cycles: Cycles::default(),
            interpolator: Interpolator::default(),
            compensation: C::default(),
            friction: Frictions::default(),
            flanks: Flanks::default(),
            ripple: Ripple::default(),
            gravity: None,
            scale: Scale::default(),
            drift: Drift::NONE,
            monitoring: Monitoring::default(),
        }
    }
}
