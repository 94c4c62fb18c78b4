//! Inverse of any chain by Newton's method.
//!
//! With e(q) the way still to go, (tip, turn) in six numbers, and J the geometric Jacobian, each
//! step is the damped least-squares step q += J' (J J' + lambda I)^-1 e (Y. Nakamura, H. Hanafusa,
//! 1986; K. Levenberg, 1944), bounded in length, so that the solution nearest to where it starts is
//! found. Of more than six joints those named U, V and W stand where their own words say (an arm on
//! a rail). It starts at home; where that does not lead to the pose, the pose is approached from
//! home in parts.
//!
//! Derivatives along a path come from the same step on jets: with J frozen at the solution, each
//! step makes one more order exact, since what an order lacks depends on lower orders only. That is
//! implicit differentiation of e(q(s), s) = 0.

use super::{Pose, in_order, layout, letters, turns_to, words};
use crate::chain::Chain;
use crate::{Kinematics, KinematicsError, Layout, Reach, ToolPose};
use lostmotion_base::vec::{Vec3, across, add, cross, dot, norm, scale, sub};
use lostmotion_base::{AXES, AxisId, AxisSet, Coords, Jet, Real};
use nalgebra::{SMatrix, SVector};

/// Length by which turns enter the residual, mm per rad: about the size of a tool.
const RESIDUAL_ARM_MM: f64 = 100.0;
/// Ratio of the smallest to the largest pivot of J J' below which the pose is singular.
const SINGULAR_RATIO: f64 = 1e-10;
/// Residual at which the pose counts as solved, mm: 50 times the rounding of coordinates of 1 m.
const SOLVED_MM: f64 = 1e-11;
/// Residual that is accepted where rounding allows no better, mm.
const ACCEPTED_MM: f64 = 1e-9;
/// Most steps of a search; a few suffice from a neighbouring pose.
const MAX_NEWTON_STEPS: usize = 60;
/// Damping at the start of a search, and its bounds, as parts of the trace of J J': Marquardt's
/// rule multiplies it by 10 after a step that made the residual larger and by 0.1 after one that
/// made it smaller. A choice: more starts as steepest descent and takes more steps, less overshoots
/// from a far start.
const FIRST_DAMPING: f64 = 1e-6;
/// Smallest damping: a Newton step to within rounding.
const MIN_DAMPING: f64 = 1e-15;
/// Largest damping: a short step down the gradient.
const MAX_DAMPING: f64 = 1.0;
/// Longest step of a joint: rad, or hundreds of mm.
const MAX_JOINT_STEP: f64 = 0.5;
/// Parts in which a pose is approached that cannot be reached in one go.
const APPROACH_PARTS: u32 = 24;

type Jacobian = SMatrix<f64, 6, AXES>;
type Residual<R> = [R; 6];

/// A chain solved numerically.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Numeric {
    kind: &'static str,
    chain: Chain,
    home: Coords,
    reach: Reach,
    /// The joints that are looked for.
    free: AxisSet,
    /// How many of the six numbers they can change at home.
    rank: usize,
}

impl Numeric {
    /// A chain that starts its searches at home.
    ///
    /// # Errors
    /// A chain without joints, or one whose home is singular.
    pub(crate) fn new(
        kind: &'static str,
        chain: Chain,
        home: Coords,
        reach: &Reach,
    ) -> Result<Numeric, String> {
        // Of more than six joints those named U, V and W stand where their words say.
        let extra = |axis: AxisId| {
            chain.joints.len() > 6 && matches!(axis, AxisId::U | AxisId::V | AxisId::W)
        };
        let free: AxisSet = chain
            .joints
            .iter()
            .map(|joint| joint.axis)
            .filter(|axis| !extra(*axis))
            .collect();
        if free.len() > 6 {
            return Err("of more than six joints those that are extra have to be named u, v or w, and stand where these words say".into());
        }
        let mut numeric = Numeric {
            kind,
            chain,
            home,
            reach: reach.clone(),
            free,
            rank: 0,
        };
        // Rank at home: as many independent motions as a regular pose has.
        let pivots = numeric.pivots(&home, &[0.0; 3]);
        let largest = pivots.first().copied().unwrap_or(0.0);
        numeric.rank = pivots
            .iter()
            .filter(|pivot| **pivot > SINGULAR_RATIO * largest)
            .count();
        let wanted = numeric.rows().min(free.len());
        if free.is_empty() || numeric.rank < wanted {
            return Err(format!(
                "at `home` its joints {} move the tool in {} ways instead of {wanted}: choose a home that is not singular",
                letters(&numeric.chain),
                numeric.rank
            ));
        }
        Ok(numeric)
    }

    /// From a start to a pose.
    fn search(&self, target: &Pose<f64>, tool: &[f64; 3], start: Coords) -> Option<Coords> {
        let mut joints = start;
        let mut damping = FIRST_DAMPING;
        let mut residual = self.residual(target, &joints.0, &self.frame(&joints), tool);
        let mut size = length(&residual);
        for _ in 0..MAX_NEWTON_STEPS {
            if size < SOLVED_MM {
                break;
            }
            // Damped least-squares step (Levenberg and Marquardt).
            let inverse = Self::inverse_of(&self.jacobian(&joints, tool), damping)?;
            let step = inverse * SVector::<f64, 6>::from(residual);
            // Steps that are too long for the linearisation are shortened.
            let longest = self.chain.joints.iter().map(|joint| {
                let step = step[joint.axis.index()].abs();
                if joint.rotary {
                    step
                } else {
                    step / RESIDUAL_ARM_MM
                }
            });
            let factor = (MAX_JOINT_STEP / longest.fold(f64::MIN_POSITIVE, f64::max)).min(1.0);
            let next = Coords(std::array::from_fn(|i| joints.0[i] + factor * step[i]));
            let next_residual = self.residual(target, &next.0, &self.frame(&next), tool);
            let next_size = length(&next_residual);
            // A step that makes it worse is discarded and damped more.
            if next_size < size || factor < 1.0 {
                (joints, residual, size) = (next, next_residual, next_size);
                damping = (damping * 0.1).max(MIN_DAMPING);
            } else if size < ACCEPTED_MM {
                // Rounding allows no better.
                break;
            } else {
                damping = (damping * 10.0).min(MAX_DAMPING);
            }
            if !joints.is_finite() {
                return None;
            }
        }
        (size < ACCEPTED_MM && !self.is_turned_away(target, &joints, tool)).then_some(joints)
    }

    /// Home, with the joints that have words of their own where these say.
    fn home_for(&self, program: &Coords) -> Coords {
        let mut home = self.home;
        for joint in self
            .chain
            .joints
            .iter()
            .filter(|joint| !self.free.contains(joint.axis))
        {
            home[joint.axis] = program[joint.axis];
        }
        home
    }

    /// From home to a pose, if need be in parts.
    fn solve(&self, program: &Coords, tool: &[f64; 3]) -> Result<Coords, KinematicsError> {
        let target = Pose::of_words(&program.0);
        let found = self
            .search(&target, tool, self.home_for(program))
            .or_else(|| self.approach(program, tool));
        let Some(mut joints) = found else {
            return Err(KinematicsError::Unreachable {
                pose: *program,
                why: "no joint positions near home give it".into(),
            });
        };
        for joint in self
            .chain
            .joints
            .iter()
            .filter(|joint| joint.rotary && self.free.contains(joint.axis))
        {
            // Of the turns that are the same, those nearest to home.
            joints[joint.axis] += turns_to(joints[joint.axis], self.home[joint.axis]);
        }
        // Rank of the Jacobian: fewer independent motions than at home is a singular pose.
        let pivots = self.pivots(&joints, tool);
        if pivots
            .iter()
            .filter(|pivot| **pivot > SINGULAR_RATIO * pivots.first().copied().unwrap_or(0.0))
            .count()
            < self.rank
        {
            return Err(KinematicsError::singular(
                program,
                "the joints cannot move the tool in every direction there",
            ));
        }
        for joint in &self.chain.joints {
            // The solution near home is the only one that is looked for: beyond the travel there is
            // no pose.
            if let Some((min, max)) = self.reach.0[joint.axis.index()]
                .filter(|(min, max)| !(*min..=*max).contains(&joints[joint.axis]))
            {
                let why = format!(
                    "joint {} would stand at {:.4}, outside {min:.4} to {max:.4} (mm or rad)",
                    joint.axis, joints[joint.axis]
                );
                return Err(KinematicsError::Unreachable {
                    pose: *program,
                    why,
                });
            }
        }
        Ok(joints)
    }

    /// The pose in parts along the words from those at home, each solved from where the one before
    /// led.
    fn approach(&self, program: &Coords, tool: &[f64; 3]) -> Option<Coords> {
        let home = self.home_for(program);
        let from = words(&self.chain, &home, tool);
        (1..=APPROACH_PARTS).try_fold(home, |joints, part| {
            let on_the_way = from.lerp(*program, f64::from(part) / f64::from(APPROACH_PARTS));
            self.search(&Pose::of_words(&on_the_way.0), tool, joints)
        })
    }
}

impl Kinematics for Numeric {
    fn name(&self) -> &'static str {
        self.kind
    }

    fn inverse(&self, program: &Coords, tool: &[f64; 3]) -> Result<Coords, KinematicsError> {
        self.solve(program, tool)
    }

    fn inverse_jet(
        &self,
        program: &[Jet; 9],
        tool: &[f64; 3],
    ) -> Result<[Jet; 9], KinematicsError> {
        let place = Coords(program.map(|jet| jet.0[0]));
        let solution = self.solve(&place, tool)?;
        let target = Pose::of_words(program);
        // Newton's matrix at the solution, frozen for all orders of the jets.
        let frame = self.frame(&solution);
        let inverse = Self::inverse_of(&self.jacobian(&solution, tool), MIN_DAMPING);
        let inverse = inverse
            .ok_or_else(|| KinematicsError::singular(&place, "its Jacobian cannot be inverted"))?;
        // The zeroth order is the solution; the higher ones start at zero.
        let mut joints = in_order(
            &self.chain,
            &self
                .chain
                .joints
                .iter()
                .map(|j| Jet::constant(solution[j.axis]))
                .collect::<Vec<_>>(),
        );
        for joint in self
            .chain
            .joints
            .iter()
            .filter(|joint| !self.free.contains(joint.axis))
        {
            // Joints with words of their own follow these in every order.
            joints[joint.axis.index()] = program[joint.axis.index()];
        }
        // One step an order, and two more to take rounding out.
        for _ in 0..5 {
            let residual = self.residual(&target, &joints, &frame, tool);
            for index in self.free.iter().map(AxisId::index) {
                let step = (0..6).fold(Jet::constant(0.0), |sum, row| {
                    sum + residual[row] * Jet::constant(inverse[(index, row)])
                });
                joints[index] = joints[index] + step;
            }
        }
        Ok(joints)
    }

    fn forward(&self, joints: &Coords, tool: &[f64; 3]) -> Coords {
        words(&self.chain, joints, tool)
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

    fn layout(&self) -> Option<Layout> {
        Some(layout(&self.chain))
    }
}

impl Numeric {
    /// With five joints the turn about the tool's own axis is left out.
    fn rows(&self) -> usize {
        if self.free.len() == 5 { 5 } else { 6 }
    }

    /// Pivots of J J' in falling order: squares of how fast the tool can be moved, for the weakest
    /// directions left last.
    fn pivots(&self, joints: &Coords, tool: &[f64; 3]) -> Vec<f64> {
        let jacobian = self.jacobian(joints, tool);
        // Elimination with full pivoting on the diagonal: J J' is symmetric.
        let mut square = jacobian * jacobian.transpose();
        let mut pivots = Vec::new();
        for step in 0..6 {
            let (mut at, mut largest) = (step, 0.0);
            for row in step..6 {
                if square[(row, row)] > largest {
                    (at, largest) = (row, square[(row, row)]);
                }
            }
            if largest <= 0.0 {
                break;
            }
            pivots.push(largest);
            square.swap_rows(step, at);
            square.swap_columns(step, at);
            for row in step + 1..6 {
                // Schur complement: what is left once the directions so far are held.
                let factor = square[(row, step)] / largest;
                for column in step + 1..6 {
                    square[(row, column)] -= factor * square[(step, column)];
                }
            }
        }
        pivots
    }

    fn jacobian(&self, joints: &Coords, tool: &[f64; 3]) -> Jacobian {
        // Turns are taken in the tool's frame and times an arm, so that all rows are lengths.
        let mut matrix = Jacobian::zeros();
        let frame = self.frame(joints);
        for (joint, (linear, angular)) in self
            .chain
            .joints
            .iter()
            .zip(self.chain.jacobian(joints, tool))
        {
            let column = joint.axis.index();
            if !self.free.contains(joint.axis) {
                continue;
            }
            for row in 0..3 {
                matrix[(row, column)] = linear[row];
                matrix[(3 + row, column)] = RESIDUAL_ARM_MM * dot(frame[row], angular);
            }
            // The sixth row, the turn about the tool itself, is empty with five joints.
            if self.rows() == 5 {
                matrix[(5, column)] = 0.0;
            }
        }
        matrix
    }

    /// Directions in which turns are told: two across the tool and the tool's own.
    fn frame(&self, joints: &Coords) -> [[f64; 3]; 3] {
        let axis = self.chain.axis(joints);
        let side = across(axis);
        [side, cross(axis, side), axis]
    }

    /// The way still to go: of the tip in mm, of the tool's frame as a rotation vector (to first
    /// order) times an arm.
    fn residual<R: Real>(
        &self,
        target: &Pose<R>,
        joints: &[R; AXES],
        frame: &[[f64; 3]; 3],
        tool: &[f64; 3],
    ) -> Residual<R> {
        let here = Pose::of_joints(&self.chain, joints, tool);
        let way = sub(target.tip, here.tip);
        let half = R::constant(0.5 * RESIDUAL_ARM_MM);
        let turn: Vec3<R> = if self.rows() == 5 {
            // The tool's axis alone: how far it turns about itself does not count.
            scale(
                cross(here.columns[2], target.columns[2]),
                R::constant(RESIDUAL_ARM_MM),
            )
        } else {
            // Half the sum of the crosses of corresponding columns is the rotation vector to first order.
            let crosses = here
                .columns
                .iter()
                .zip(&target.columns)
                .map(|(here, there)| cross(*here, *there));
            scale(crosses.fold([R::constant(0.0); 3], add), half)
        };
        let told = |row: usize| dot(frame[row].map(R::constant), turn);
        let last = if self.rows() == 5 {
            R::constant(0.0)
        } else {
            told(2)
        };
        [way[0], way[1], way[2], told(0), told(1), last]
    }

    /// Whether the tool's frame is more than a right angle from the target's: the first-order turn
    /// vanishes at half a turn, too.
    fn is_turned_away(&self, target: &Pose<f64>, joints: &Coords, tool: &[f64; 3]) -> bool {
        let here = Pose::of_joints(&self.chain, &joints.0, tool);
        let count = if self.rows() == 5 { 2..3 } else { 0..3 };
        count
            .into_iter()
            .any(|i| dot(here.columns[i], target.columns[i]) < 0.0)
    }

    /// (J J' + lambda I)^-1, then J'.
    fn inverse_of(jacobian: &Jacobian, damping: f64) -> Option<SMatrix<f64, AXES, 6>> {
        let mut square = jacobian * jacobian.transpose();
        let lambda = damping * square.trace() + f64::MIN_POSITIVE;
        // Marquardt's damping relative to the size of J J': steps stay finite at singular poses.
        for i in 0..6 {
            square[(i, i)] += lambda;
        }
        square
            .cholesky()
            .map(|factor| jacobian.transpose() * factor.inverse())
    }
}

fn length(residual: &Residual<f64>) -> f64 {
    let [x, y, z, a, b, c] = *residual;
    let (linear, angular) = (norm([x, y, z]), norm([a, b, c]));
    (linear * linear + angular * angular).sqrt()
}
