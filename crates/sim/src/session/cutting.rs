//! The cutting force: of constant size, against the tool's way through the part, on feed moves
//! alone.
//!
//! With p(q) the tip in the part's frame over the joints q and t the unit vector along `dp/dt`, the
//! force on the tool is `-F t`, and by virtual work each joint's load takes `F t . dp/dq` against
//! its positive direction: the direction's cosines on linear axes in N, moments about the rotary
//! ones in N m.

use crate::motion::Modes;
use lostmotion_base::units::UM_PER_MM;
use lostmotion_base::{AxisId, AxisSet, Coords};
use lostmotion_contour::ContourTracker;
use lostmotion_kinematics::Kinematics;
use lostmotion_plan::Sample;

/// Half the distance over which the tip is differentiated by a joint: mm for linear ones, rad for
/// rotary ones. Derived: far above rounding of places up to 1 m, far below any curvature.
const DIFFERENCE_STEPS: [f64; 2] = [1e-3, 1e-6];
/// Speed of the tip below which it has no direction, mm/s. Derived: far above the rounding of speeds
/// of 1 m/s, far below any feed.
const STANDSTILL_MM_S: f64 = 1e-9;

/// A cutting force on some machine.
#[derive(Debug)]
pub(crate) struct Cutting {
    force_n: f64,
    rotary: AxisSet,
    axes: Vec<AxisId>,
}

impl Cutting {
    /// None for a force of 0.
    pub(crate) fn new(force_n: f64, rotary: AxisSet, axes: Vec<AxisId>) -> Option<Cutting> {
        (force_n > 0.0).then_some(Cutting {
            force_n,
            rotary,
            axes,
        })
    }

    /// The forces of a chunk of samples: on each joint's load against its positive direction, N or
    /// N m; 0 on rapids and at rest.
    pub(crate) fn forces(
        &self,
        samples: &[Sample],
        tracker: &ContourTracker,
        modes: &Modes,
    ) -> Vec<Coords> {
        // No force on rapids, nor where the segment is not known any more.
        let cuts = |sample: &Sample| {
            tracker
                .segment(sample.segment)
                .is_some_and(|segment| !segment.rapid)
        };
        samples
            .iter()
            .map(|sample| {
                if cuts(sample) {
                    self.force(sample, modes.at(sample.segment))
                } else {
                    Coords::ZERO
                }
            })
            .collect()
    }

    fn force(&self, sample: &Sample, kinematics: &dyn Kinematics) -> Coords {
        // Columns of the tip's Jacobian dp/dq, one a joint.
        let ways: Vec<(AxisId, [f64; 3])> = self
            .axes
            .iter()
            .map(|axis| (*axis, self.way(sample, *axis, kinematics)))
            .collect();
        let along = |n: usize| {
            ways.iter()
                .map(|(axis, way)| way[n] * sample.velocity[*axis])
                .sum::<f64>()
        };
        // Speed of the tip in the part's frame: the sum of what each joint contributes.
        let velocity = [along(0), along(1), along(2)];
        let speed = dot(&velocity, &velocity).sqrt();
        let mut forces = Coords::ZERO;
        if speed > STANDSTILL_MM_S {
            // Virtual work: F t . dp/dq is what the force takes from each joint.
            for (axis, way) in ways {
                let per_joint = self.force_n * dot(&velocity, &way) / speed;
                // mm of the tip for each rad of a rotary joint
                forces[axis] = if self.rotary.contains(axis) {
                    per_joint / UM_PER_MM
                } else {
                    per_joint
                };
            }
        }
        forces
    }

    /// How the tip moves with a joint: mm for each mm or rad.
    fn way(&self, sample: &Sample, axis: AxisId, kinematics: &dyn Kinematics) -> [f64; 3] {
        // Central differences: any kinematics serves, also one of the caller that has no
        // derivatives of the pose.
        let reach = DIFFERENCE_STEPS[usize::from(self.rotary.contains(axis))];
        let at = |by: f64| {
            let mut joints = sample.position;
            joints[axis] += by;
            kinematics.tool_pose(&joints, &sample.tool_mm).tip
        };
        let (ahead, behind) = (at(reach), at(-reach));
        std::array::from_fn(|n| (ahead[n] - behind[n]) / (2.0 * reach))
    }
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Machine;
    use lostmotion_base::BlockRef;

    fn sample(position: Coords, velocity: Coords) -> Sample {
        let (acceleration, block) = (Coords::ZERO, BlockRef::default());
        let (feed_part, heeds) = (1.0, lostmotion_plan::Heeds::Feed);
        Sample {
            tick: 0,
            position,
            velocity,
            acceleration,
            segment: 0,
            s: 0.0,
            path_speed: 1.0,
            feed_part,
            chord_part: 0.0,
            heeds,
            tool_mm: [0.0, 0.0, 80.0],
            block,
        }
    }

    fn cutting(machine: &str, force_n: f64) -> (Cutting, Box<dyn Kinematics>) {
        let machine = Machine::preset(machine).unwrap();
        let letters = machine.axes().iter().map(|axis| axis.id).collect();
        (
            Cutting::new(force_n, machine.rotary_joints(), letters).unwrap(),
            machine.build_kinematics().unwrap(),
        )
    }

    #[test]
    fn on_linear_axes_it_is_the_force_times_the_directions_cosines() {
        let mut velocity = Coords::ZERO;
        (velocity[AxisId::X], velocity[AxisId::Y]) = (-30.0, 40.0);
        let (cutting, kinematics) = cutting("vmc3", 500.0);
        let force = |velocity| cutting.force(&sample(Coords::ZERO, velocity), kinematics.as_ref());
        let forces = force(velocity);
        for (axis, expected) in [(AxisId::X, -300.0), (AxisId::Y, 400.0), (AxisId::Z, 0.0)] {
            assert!(
                (forces[axis] - expected).abs() < 1e-6,
                "{axis}: {}",
                forces[axis]
            );
        }
        assert_eq!(force(Coords::ZERO), Coords::ZERO);
    }

    /// What the drives give the force is what it takes along the tip's way.
    #[test]
    fn on_a_trunnion_its_power_is_that_at_the_tip() {
        let (cutting, kinematics) = cutting("trunnion5", 700.0);
        let (mut position, mut velocity) = (Coords::ZERO, Coords::ZERO);
        for (axis, at, speed) in [
            (AxisId::X, 30.0, 12.0),
            (AxisId::Y, -20.0, -7.0),
            (AxisId::Z, -60.0, 3.0),
            (AxisId::A, -0.4, 0.2),
            (AxisId::C, 1.1, -0.5),
        ] {
            (position[axis], velocity[axis]) = (at, speed);
        }
        let forces = cutting.force(&sample(position, velocity), kinematics.as_ref());
        let per_mm = |axis: AxisId| if axis.is_rotary() { 1e3 } else { 1.0 };
        let power: f64 = cutting
            .axes
            .iter()
            .map(|axis| forces[*axis] * per_mm(*axis) * velocity[*axis])
            .sum();
        // the tip's speed from where it is a moment before and after
        let tip = |t: f64| {
            let mut joints = position;
            AxisId::ALL
                .iter()
                .for_each(|axis| joints[*axis] += velocity[*axis] * t);
            kinematics.tool_pose(&joints, &[0.0, 0.0, 80.0]).tip
        };
        let (a, b) = (tip(-1e-5), tip(1e-5));
        let way: [f64; 3] = std::array::from_fn(|n| (b[n] - a[n]) / 2e-5);
        let expected = 700.0 * dot(&way, &way).sqrt();
        assert!((power / expected - 1.0).abs() < 1e-7, "{power} {expected}");
        assert!(forces[AxisId::C].abs() > 1.0);
    }
}
