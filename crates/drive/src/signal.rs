//! What goes into an axis and what comes out.

use serde::{Deserialize, Serialize};

/// Command of an axis at one CNC tick (1 ms), in the axis' own unit (mm, deg or rad at the load).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setpoint {
    /// Commanded position.
    pub position: f64,
    /// Commanded velocity per s, where the control sends it along.
    pub velocity: Option<f64>,
    /// Commanded acceleration per s2, where the control sends it along.
    pub acceleration: Option<f64>,
    /// Force on the load against the positive direction besides what the axis' description has
    /// (cutting), N, or N m at a rotary load. It acts over the period that the push of this
    /// setpoint simulates; none for a load that is left alone.
    pub load_force: Option<f64>,
    /// The block of the program that moves the axis, where the control sends it along. It comes with
    /// the command: ahead of the reference by the delay of the spline.
    pub block: Option<BlockMotion>,
}

/// What a control knows of the block that it carries out and a position does not show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BlockMotion {
    /// Whether it is rapid traverse (G0).
    pub rapid: bool,
    /// Speed along the path of all axes, mm/s.
    pub path_speed_mm_s: f64,
}

impl Setpoint {
    /// A position with its velocity and acceleration, and no force on the load.
    pub const fn moving(position: f64, velocity: f64, acceleration: f64) -> Setpoint {
        Setpoint {
            position,
            velocity: Some(velocity),
            acceleration: Some(acceleration),
            load_force: None,
            block: None,
        }
    }
}

/// Reference of the servo loops at one servo tick (250 us): motor side, rad, rad/s, rad/s2.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// Position, rad.
    pub position: f64,
    /// Velocity, rad/s.
    pub velocity: f64,
    /// Acceleration, rad/s2.
    pub acceleration: f64,
}

impl Reference {
    /// At rest at zero.
    pub(crate) const ZERO: Reference = Reference {
        position: 0.0,
        velocity: 0.0,
        acceleration: 0.0,
    };
}

/// Which flank of the gap is in contact.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
pub enum Engagement {
    /// The motor pushes the load in the negative direction (theta_b <= -b).
    Negative,
    /// No contact.
    #[default]
    Gap,
    /// The motor pushes the load in the positive direction (theta_b >= b).
    Positive,
}

impl Engagement {
    /// The flank that a direction of motion against friction puts in contact.
    pub const fn of_sign(sign: i8) -> Engagement {
        match sign {
            1 => Engagement::Positive,
            -1 => Engagement::Negative,
            _ => Engagement::Gap,
        }
    }

    /// -1, 0 or 1.
    pub const fn sign(self) -> i8 {
        match self {
            Engagement::Negative => -1,
            Engagement::Gap => 0,
            Engagement::Positive => 1,
        }
    }
}

/// Full state of an axis at one servo tick, for traces. Motor side: rad, rad/s, A, N m.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AxisSample {
    /// Reference that the servo was given at this tick.
    pub reference: Reference,
    /// True motor position, rad.
    pub motor_position: f64,
    /// True motor velocity, rad/s.
    pub motor_velocity: f64,
    /// True load position, rad at the motor shaft.
    pub load_position: f64,
    /// True load velocity, rad/s.
    pub load_velocity: f64,
    /// Torque-forming current i_q, A.
    pub current: f64,
    /// Motor torque, N m.
    pub torque: f64,
    /// Torque of the shaft on the load, N m.
    pub shaft_torque: f64,
    /// Which flank is in contact.
    pub engagement: Engagement,
    /// The compensator's estimate of theta_M - theta_L, rad; NaN if it makes none.
    pub gap_angle_estimate: f64,
    /// The compensator's estimate of the inertia that the motor carries, kg m2; NaN if it makes
    /// none.
    pub inertia_estimate: f64,
    /// The compensator's estimate of the engagement.
    pub engagement_estimate: Engagement,
    /// Estimate of the shaft's stiffness, N m/rad at the motor; NaN if there is none or nothing has
    /// excited the shaft.
    pub stiffness_estimate: f64,
    /// Estimate of the shaft's damping, N m s/rad at the motor; NaN as that of the stiffness.
    pub damping_estimate: f64,
}

/// The motor of an axis at one servo tick: what is watched of a long program, in a quarter of the room
/// of an [`AxisSample`].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct MotorSample {
    /// True position, rad.
    pub position: f64,
    /// Torque-forming current i_q, A.
    pub current: f64,
    /// Torque, N m.
    pub torque: f64,
    /// Which flank is in contact.
    pub engagement: Engagement,
}

/// What a drive knows at a servo tick, motor side.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signals {
    /// Reference at this tick (rad, rad/s, rad/s2).
    pub reference: Reference,
    /// Reference one servo tick ahead; the spline's delay makes it known.
    pub next_reference: Reference,
    /// Motor position from its encoder, rad, quantised.
    pub motor_position: f64,
    /// Motor velocity as the drive computes it, rad/s.
    pub motor_velocity: f64,
    /// Measured torque-forming current, A.
    pub current: f64,
    /// Mean of the torque-forming current over the last servo period, from the samples of the
    /// current loop, A.
    pub mean_current: f64,
    /// Whether the drive was at its current or voltage limit in the last period.
    pub saturated: bool,
    /// The block that is carried out, where the control tells it.
    pub block: Option<BlockMotion>,
    /// Load position from its scale, rad at the motor shaft; only for methods whose
    /// `Knowledge::load_scale` is set and machines that have one.
    pub load_position: Option<f64>,
}

/// A compensator's output at a servo tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Correction {
    /// Added to the position reference, rad.
    pub position: f64,
    /// Added to the velocity feed-forward, rad/s.
    pub velocity: f64,
    /// Added to the torque feed-forward, N m.
    pub torque: f64,
    /// Subtracted from the measured motor position before the position loop sees it, rad
    /// (the published method feeds back theta_M - theta_b_hat).
    pub feedback: f64,
    /// Estimate of theta_M - theta_L, rad; NaN if none.
    pub gap_angle_estimate: f64,
    /// Estimate of the inertia the motor carries, kg m2; NaN if none.
    pub inertia_estimate: f64,
    /// Estimate of the engagement.
    pub engagement_estimate: Engagement,
    /// Estimate of the shaft's stiffness, N m/rad at the motor; NaN if none.
    pub stiffness_estimate: f64,
    /// Estimate of the shaft's damping, N m s/rad at the motor; NaN if none.
    pub damping_estimate: f64,
}

impl Correction {
    /// No correction and no estimate.
    pub const NONE: Correction = Correction {
        position: 0.0,
        velocity: 0.0,
        torque: 0.0,
        feedback: 0.0,
        gap_angle_estimate: f64::NAN,
        inertia_estimate: f64::NAN,
        engagement_estimate: Engagement::Gap,
        stiffness_estimate: f64::NAN,
        damping_estimate: f64::NAN,
    };

    /// The outputs: position, velocity, torque, feedback.
    #[inline]
    pub(crate) fn outputs(&self) -> [f64; 4] {
        [self.position, self.velocity, self.torque, self.feedback]
    }

    /// Whether every output is a number that a drive could act on. A drive ignores an output that
    /// is not, for that tick.
    #[inline]
    pub fn is_usable(&self) -> bool {
        self.outputs()
            .iter()
            .all(|output| output.abs() < LARGEST_USABLE_OUTPUT)
    }

    /// The estimates without any output.
    #[must_use]
    #[inline]
    pub fn without_output(self) -> Correction {
        Correction {
            position: 0.0,
            velocity: 0.0,
            torque: 0.0,
            feedback: 0.0,
            ..self
        }
    }
}

/// An output beyond this (rad, rad/s, N m) has run away.
const LARGEST_USABLE_OUTPUT: f64 = 1e9;
