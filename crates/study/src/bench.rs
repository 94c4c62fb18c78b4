//! A virtual test bench: two motors back to back, a coupler of known stiffness and an adjustable
//! gap between their shafts.
//!
//! The first motor runs the axis' loops, the second is the load: its rotor is the inertia, its
//! friction the load's, and its drive puts a torque on the coupler. So everything that an estimator
//! has to find is known beforehand. [`run`] makes two recordings: one in which the second motor
//! pulls and pushes, and the coupler winds up under loads of every size, and one in which it is
//! towed, as a slide is; and the gap that `adaptive` learned towing it.

use crate::error::StudyError;
use lostmotion_base::math;
use lostmotion_drive::config::Load;
use lostmotion_drive::{AxisOutput, AxisSample, Engagement, Setpoint};
use lostmotion_methods::{AxisConfig, MethodId, build_runner};
use std::f64::consts::TAU;

/// Length of a recording, s: some fifteen periods of the slow sine. A choice.
const RECORDING_S: u32 = 20;
/// Coulomb friction of the second motor, N m. A choice.
const FRICTION_NM: f64 = 0.4;
/// Torque of the second motor, N m: five times its friction, so that it decides the flank. A
/// choice.
const TORQUE_NM: f64 = 2.0;
/// Frequencies of that torque, Hz, in no simple ratio to each other or the motion. A choice.
const TORQUE_HZ: [f64; 2] = [0.7, 1.9];
/// Amplitudes, rad, and rates, rad/s, of the motion's two sines, in no simple ratio. A choice.
const MOTION: [(f64, f64); 2] = [(3.0, 5.0), (1.1, 13.0)];
/// Counts per turn of the encoders of both motors: 20 bits, as common absolute encoders have.
const ENCODER_COUNTS: u32 = 1 << 20;

/// What lies between the shafts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupler {
    /// Total gap, rad.
    pub gap_rad: f64,
    /// Stiffness, N m/rad.
    pub stiffness_nm_per_rad: f64,
}

impl Coupler {
    /// Damping, N m s/rad, between two rotors: a twentieth of the critical one.
    pub fn damping_nm_s_per_rad(&self, rotor_kgm2: f64) -> f64 {
        0.05 * 2.0 * (self.stiffness_nm_per_rad * 0.5 * rotor_kgm2).sqrt()
    }
}

/// Usual couplers: three gaps, two of them with a soft and a stiff spring.
pub const COUPLERS: [Coupler; 5] = [
    Coupler {
        gap_rad: 0.1,
        stiffness_nm_per_rad: 2000.0,
    },
    Coupler {
        gap_rad: 0.02,
        stiffness_nm_per_rad: 500.0,
    },
    Coupler {
        gap_rad: 0.02,
        stiffness_nm_per_rad: 2000.0,
    },
    Coupler {
        gap_rad: 0.005,
        stiffness_nm_per_rad: 500.0,
    },
    Coupler {
        gap_rad: 0.005,
        stiffness_nm_per_rad: 5000.0,
    },
];

/// What was recorded on the bench.
#[derive(Clone, Debug)]
pub struct Recording {
    /// The first motor's axis.
    pub axis: AxisConfig,
    /// With the second motor pulling and pushing: a sample every 250 us, as encoders of 2^20 counts
    /// read them.
    pub loaded: Vec<AxisSample>,
    /// The same with the second motor towed.
    pub towed: Vec<AxisSample>,
    /// Total gap that `adaptive` learned towing it, rad; `None` if it claims none.
    pub adaptive_gap_rad: Option<f64>,
    /// Stiffness, N m/rad, and damping, N m s/rad, estimated online in that run; `None` where
    /// the motion did not excite the coupler.
    pub online: Option<[f64; 2]>,
}

/// The first motor and what it turns: two motors of the paper's kind.
pub fn axis(coupler: &Coupler) -> AxisConfig {
    let mut config = AxisConfig::paper();
    let rotor = config.motor.inertia_kgm2;
    config.drive.velocity_feedforward = 1.0;
    config.drive.acceleration_feedforward = 1.0;
    config.drive.encoder_counts_per_rev = Some(ENCODER_COUNTS);
    config.compensation.estimate_shaft = true;
    // The velocity gain scales with the inertia, so that the loop is as fast as on the paper's
    // axis.
    config.drive.velocity_gain_a_s_per_rad *=
        2.0 * rotor / (rotor + config.reflected_load().inertia_kgm2);
    // The second motor is the load: its rotor, its friction, and the coupler for the shaft.
    let damping = coupler.damping_nm_s_per_rad(rotor);
    if let Load::Reflected(load) = &mut config.load {
        (
            load.inertia_kgm2,
            load.coulomb_nm,
            load.viscous_nm_s_per_rad,
        ) = (rotor, FRICTION_NM, config.motor.viscous_nm_s_per_rad);
        (
            load.gap_rad,
            load.stiffness_nm_per_rad,
            load.damping_nm_s_per_rad,
        ) = (coupler.gap_rad, coupler.stiffness_nm_per_rad, damping);
    }
    config
}

/// Runs the bench with a coupler.
///
/// # Errors
/// A coupler that makes no sense.
pub fn run(coupler: &Coupler) -> Result<Recording, StudyError> {
    let axis = axis(coupler);
    let count = TAU / f64::from(ENCODER_COUNTS);
    // The recordings hold what encoders read, not the true angles.
    let read = |angle: f64| (angle / count).round() * count;
    // One axis three times: with the second motor driven, towed, and towed while `adaptive` learns.
    let (mut loaded, mut towed, adaptive) = (
        record(&axis, MethodId::NONE, TORQUE_NM)?,
        record(&axis, MethodId::NONE, 0.0)?,
        record(&axis, MethodId::ADAPTIVE, 0.0)?,
    );
    for sample in loaded.iter_mut().chain(&mut towed) {
        (sample.motor_position, sample.load_position) =
            (read(sample.motor_position), read(sample.load_position));
    }
    Ok(Recording {
        adaptive_gap_rad: learned(&adaptive),
        online: estimated(&adaptive),
        axis,
        loaded,
        towed,
    })
}

/// Trace of the axis with a method, with the second motor's torque.
fn record(
    axis: &AxisConfig,
    method: MethodId,
    torque_nm: f64,
) -> Result<Vec<AxisSample>, StudyError> {
    let mut out = AxisOutput::new(true);
    let points: Vec<Setpoint> = (0..1000 * RECORDING_S)
        .map(|n| setpoint(1e-3 * f64::from(n), torque_nm))
        .collect();
    build_runner(axis, method, 0.0)?.push(&points, &mut out)?;
    Ok(out.trace.unwrap_or_default())
}

/// Two sines whose periods do not match, and the torque of the second motor against them.
fn setpoint(t: f64, torque_nm: f64) -> Setpoint {
    let sum =
        |value: &dyn Fn(f64, f64) -> f64| MOTION.into_iter().map(|(a, w)| value(a, w)).sum::<f64>();
    let [slow, fast] = TORQUE_HZ.map(|hz| math::sin(TAU * hz * t));
    // 1 - cos starts at rest; velocity and acceleration are its exact derivatives.
    let (position, velocity) = (
        sum(&|a, w| a * (1.0 - math::cos(w * t))),
        sum(&|a, w| a * w * math::sin(w * t)),
    );
    let moving = Setpoint::moving(
        position,
        velocity,
        sum(&|a, w| a * w * w * math::cos(w * t)),
    );
    Setpoint {
        load_force: Some(0.5 * torque_nm * (slow + fast)),
        ..moving
    }
}

/// Stiffness and damping as estimated at the end.
fn estimated(samples: &[AxisSample]) -> Option<[f64; 2]> {
    let last = samples.last()?;
    last.stiffness_estimate
        .is_finite()
        .then_some([last.stiffness_estimate, last.damping_estimate])
}

/// Mean of the estimate over the last quarter, on either flank.
fn learned(samples: &[AxisSample]) -> Option<f64> {
    let last = samples.get(samples.len() / 4 * 3..)?;
    // Only in contact is the estimated gap angle the half gap.
    let touching = last
        .iter()
        .filter(|s| s.engagement_estimate != Engagement::Gap && s.gap_angle_estimate.is_finite());
    let (count, sum) = touching.fold((0_u32, 0.0), |(count, sum), s| {
        (count + 1, sum + s.gap_angle_estimate.abs())
    });
    (count > 0 && sum > 0.0).then(|| 2.0 * sum / f64::from(count))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn adaptive_finds_the_gap_that_was_set() {
        for coupler in [COUPLERS[0], COUPLERS[2]] {
            let found = run(&coupler).unwrap().adaptive_gap_rad.unwrap();
            assert!(
                (found / coupler.gap_rad - 1.0).abs() < 0.03,
                "{found} {coupler:?}"
            );
        }
    }

    #[test]
    fn stiffness_and_damping_are_estimated_while_it_runs() {
        for coupler in COUPLERS {
            let recording = run(&coupler).unwrap();
            let [stiffness, damping] = recording.online.unwrap();
            let told = coupler.damping_nm_s_per_rad(recording.axis.motor.inertia_kgm2);
            // the widest gap has the hardest blows, after which the motor bounces for longest
            let most = if coupler == COUPLERS[0] { 0.05 } else { 0.03 };
            assert!(
                (stiffness / coupler.stiffness_nm_per_rad - 1.0).abs() < most,
                "{stiffness} {coupler:?}"
            );
            assert!(
                (damping / told - 1.0).abs() < 0.2,
                "{damping} {told} {coupler:?}"
            );
        }
    }

    #[test]
    fn the_coupler_winds_up_by_torque_over_stiffness() {
        // wherever the second motor moves steadily, what it takes is its friction and torque
        let coupler = COUPLERS[1];
        let recording = run(&coupler).unwrap();
        let most = recording
            .loaded
            .iter()
            .map(|s| (s.motor_position - s.load_position).abs())
            .fold(0.0, f64::max);
        let torque = most_torque(&recording.loaded) / coupler.stiffness_nm_per_rad;
        assert!(
            most > 0.5 * coupler.gap_rad + 0.5 * torque
                && most < 0.5 * coupler.gap_rad + 2.0 * torque,
            "{most} {torque}"
        );
    }

    fn most_torque(samples: &[AxisSample]) -> f64 {
        samples.iter().map(|s| s.torque.abs()).fold(0.0, f64::max)
    }
}
