//! Machine tools as chains: X Y Z are the tool tip in the workpiece's frame, the rotary words are
//! the rotary joints, and three linear joints named X, Y and Z carry the tip wherever the rotary
//! ones turn it.
//!
//! With the rotary joints given the tip is affine in the three linear ones,
//!
//! tip = b(theta) + sum m_k(theta) l_k,
//!
//! so that the inverse is a 3 x 3 system, exact on jets too. Where no rotary joint lies between the
//! three linear ones (nearly every machine: table-table, head-head, head-table, nutating, one
//! rotary axis or none) its matrix is constant: the tip goes backward through the joints before
//! them, the tool forward through those behind, and the difference is what they move.

use crate::chain::{Chain, ChainJoint};
use crate::orient::Orientation;
use crate::rotation::apply;
use crate::{Kinematics, KinematicsError, Reach, ToolPose};
use lostmotion_base::vec::{Vec3, constant, cross, dot, scale, sub};
use lostmotion_base::{AXES, AxisId, Coords, Jet, Real};

/// Smallest volume of the box spanned by the unit directions of X, Y and Z; 1 where they are at right
/// angles. Directions nearer to a plane are refused as a mistake in the description.
const MIN_VOLUME: f64 = 1e-3;

/// A serial machine tool.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineTool {
    kind: &'static str,
    chain: Chain,
    /// Places of X, Y, Z among the joints.
    carriers: [usize; 3],
    together: Option<Together>,
    orientation: Option<Orientation>,
}

/// Carriers without a rotary joint between them.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Together {
    first: usize,
    last: usize,
    /// From a way of the tip to ways of the carriers; `None` if they are the coordinate axes.
    inverse: Option<[[f64; 3]; 3]>,
}

impl MachineTool {
    /// From a chain with linear joints X, Y and Z. `kind` is the name that it gives itself,
    /// `tolerance_rad` how far the tool's direction may leave the programmed one.
    ///
    /// # Errors
    /// A chain without these joints, or one whose three linear joints lie in a plane.
    pub fn new(
        kind: &'static str,
        chain: Chain,
        reach: &Reach,
        tolerance_rad: f64,
    ) -> Result<MachineTool, String> {
        // The slides that bring the tip to its place, by their place in the chain.
        let mut carriers = [0; 3];
        for (slot, axis) in carriers.iter_mut().zip([AxisId::X, AxisId::Y, AxisId::Z]) {
            let found = chain
                .joints
                .iter()
                .position(|joint| joint.axis == axis && !joint.rotary);
            *slot = found.ok_or_else(|| {
                format!(
                    "linear joint `{axis}` is missing; machines without linear joints X, Y and Z need `words = \"pose\"`",
                    axis = axis.letter().to_ascii_lowercase()
                )
            })?;
        }
        let directions = carriers.map(|index| chain.joints[index].direction());
        // Triple product: 0 where the three slides cannot reach every point.
        let volume = dot(directions[0], cross(directions[1], directions[2]));
        if volume.abs() < MIN_VOLUME {
            return Err("the directions of the linear joints x, y and z lie in a plane".into());
        }
        let (first, last) = (
            *carriers.iter().min().unwrap_or(&0),
            *carriers.iter().max().unwrap_or(&0),
        );
        // Without a rotary joint between them the slides' matrix is the same for all poses.
        let apart = chain.joints[first..=last].iter().any(|joint| joint.rotary);
        let plain = directions == [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        // Rows of the inverse of the matrix with the directions as columns, times its determinant.
        let rows = [
            cross(directions[1], directions[2]),
            cross(directions[2], directions[0]),
            cross(directions[0], directions[1]),
        ];
        let inverse = (!plain).then(|| rows.map(|row| scale(row, 1.0 / volume)));
        let together = (!apart).then_some(Together {
            first,
            last,
            inverse,
        });
        let orientation = Orientation::new(&chain, reach, tolerance_rad);
        Ok(MachineTool {
            kind,
            chain,
            carriers,
            together,
            orientation,
        })
    }

    /// Part to joints, for numbers and for jets alike.
    fn joints<R: Real>(&self, program: &[R; AXES], tool: &[f64; 3]) -> [R; AXES] {
        // Where the tip has to go, and where the chain has it with all joints at zero.
        let target = [program[0], program[1], program[2]];
        let tip = constant(self.chain.tip_at_zero(tool));
        let ways = match &self.together {
            Some(together) => self.ways_together(together, program, target, tip),
            None => self.ways_apart(program, target, tip),
        };
        let mut joints = *program;
        // The rotary words are the rotary joints; only the slides are solved for.
        for (way, index) in ways.into_iter().zip(self.carriers) {
            let joint = &self.chain.joints[index];
            joints[joint.axis.index()] = joint.position(way);
        }
        joints
    }

    fn ways_together<R: Real>(
        &self,
        together: &Together,
        program: &[R; AXES],
        target: Vec3<R>,
        tip: Vec3<R>,
    ) -> Vec3<R> {
        let at = |joint: &ChainJoint| program[joint.axis.index()];
        let joints = &self.chain.joints;
        // Backward: the target as it is seen from behind the rotary joints on the workpiece's side.
        let target = joints[..together.first]
            .iter()
            .fold(target, |point, joint| joint.leave(point, at(joint)));
        // Forward: where the joints behind the slides carry the tip while the slides are at zero.
        let carried = joints
            .iter()
            .enumerate()
            .skip(together.first)
            .rev()
            .filter(|(index, _)| !self.carriers.contains(index));
        let tip = carried.fold(tip, |point, (_, joint)| joint.carry(point, at(joint)));
        // The difference is what the slides have to move.
        let way = sub(target, tip);
        together
            .inverse
            .map_or(way, |rows| apply(&rows.map(constant), way))
    }

    fn ways_apart<R: Real>(&self, program: &[R; AXES], target: Vec3<R>, tip: Vec3<R>) -> Vec3<R> {
        // From the tool to the workpiece: the tip with the slides at zero, and how each slide moves
        // it, both turned by the rotary joints nearer to the workpiece.
        let mut tip = tip;
        let mut columns = [constant([0.0; 3]); 3];
        for (index, joint) in self.chain.joints.iter().enumerate().rev() {
            if let Some(carrier) = self.carriers.iter().position(|carrier| *carrier == index) {
                columns[carrier] = constant(joint.direction());
                continue;
            }
            let position = program[joint.axis.index()];
            tip = joint.carry(tip, position);
            columns = columns.map(|column| joint.carry_direction(column, position));
        }
        let way = sub(target, tip);
        // Cramer's rule for x l_x + y l_y + z l_z = way.
        let [x, y, z] = columns;
        let volume = dot(x, cross(y, z));
        [
            dot(way, cross(y, z)) / volume,
            dot(way, cross(z, x)) / volume,
            dot(way, cross(x, y)) / volume,
        ]
    }
}

impl Kinematics for MachineTool {
    fn name(&self) -> &'static str {
        self.kind
    }

    fn inverse(&self, program: &Coords, tool: &[f64; 3]) -> Result<Coords, KinematicsError> {
        let joints = Coords(self.joints(&program.0, tool));
        if joints.is_finite() {
            Ok(joints)
        } else {
            Err(KinematicsError::singular(
                program,
                "the linear joints are in a plane there",
            ))
        }
    }

    fn inverse_jet(
        &self,
        program: &[Jet; 9],
        tool: &[f64; 3],
    ) -> Result<[Jet; 9], KinematicsError> {
        Ok(self.joints(program, tool))
    }

    fn forward(&self, joints: &Coords, tool: &[f64; 3]) -> Coords {
        let mut program = *joints;
        program.0[..3].copy_from_slice(&self.chain.tip(&joints.0, tool));
        program
    }

    fn tool_pose(&self, joints: &Coords, tool: &[f64; 3]) -> ToolPose {
        ToolPose {
            tip: self.chain.tip(&joints.0, tool),
            axis: self.chain.axis(joints),
        }
    }

    fn chain(&self) -> Option<&Chain> {
        Some(&self.chain)
    }

    fn orientation(&self) -> Option<&Orientation> {
        self.orientation.as_ref()
    }
}
