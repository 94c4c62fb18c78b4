//! Six-axis arm with a spherical wrist: closed form.
//!
//! The last three axes meet in the wrist's centre w, whose place c follows from the pose alone.
//! Where the second and third axes are parallel and across the first (nearly every arm), the rest
//! is three steps (D. L. Pieper, 1968):
//!
//! 1. shoulder: the part of c along u2 in the first link is that of w; a cos x + b sin x = d, two
//!    solutions;
//! 2. elbow: |E2 E3 w - p2| = |c - p2| in the plane across u2; two solutions, then the second joint
//!    is one angle;
//! 3. wrist: R4 R5 R6 = (R1 R2 R3)^-1 R, as for two rotary axes of a machine tool
//!    ([`crate::rotation::two`]); two solutions.
//!
//! Of the eight the one is taken that holds at home; it stays the same everywhere, so joints are
//! continuous in the pose.

use super::{Pose, in_order, layout, turns_to, words};
use crate::chain::{Chain, wrist_center};
use crate::rotation::{about, cosine, two};
use crate::{Kinematics, KinematicsError, Layout, ToolPose};
use lostmotion_base::vec::{Vec3, across, add, constant, dot, scale, sub};
use lostmotion_base::{AXES, Coords, Jet, Real};

/// Largest cosine between axes that have to be at right angles, and largest distance from 1 of the
/// cosine of those that have to be parallel: rounding of the description's numbers.
const AXIS_ERROR: f64 = 1e-9;
/// Largest distance of a joint from home at which a solution of the pose at home is home itself,
/// rad. Derived: above what axes that are off by `AXIS_ERROR` make of the closed form, far below
/// the distance of two solutions.
const SAME_AS_HOME_RAD: f64 = 1e-6;

/// An arm on one of its eight branches.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Arm {
    kind: &'static str,
    chain: Chain,
    /// Wrist centre with all joints at zero.
    center: [f64; 3],
    home: Coords,
    branch: Branch,
}

/// Shoulder, elbow, wrist: first or second solution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Branch(usize, usize, usize);

impl Arm {
    /// If the chain is of that kind, and home is not singular.
    pub(crate) fn new(kind: &'static str, chain: &Chain, home: &Coords) -> Option<Arm> {
        let [first, second, third, ..] = chain.joints.as_slice() else {
            return None;
        };
        // Pieper's condition: six rotary joints, the last three through one point; here the first two at
        // right angles and the second parallel to the third.
        let six = chain.joints.len() == 6 && chain.joints.iter().all(|joint| joint.rotary);
        let (u1, u2, u3) = (first.direction(), second.direction(), third.direction());
        let square = dot(u1, u2).abs() < AXIS_ERROR && (dot(u2, u3).abs() - 1.0).abs() < AXIS_ERROR;
        let center = wrist_center(chain)?;
        if !(six && square) {
            return None;
        }
        let mut arm = Arm {
            kind,
            chain: chain.clone(),
            center,
            home: *home,
            branch: Branch(0, 0, 0),
        };
        let pose = Pose::of_joints(chain, &home.0, &[0.0; 3]);
        let mut nearest: Option<(f64, Branch)> = None;
        // Of the eight solutions of the pose at home, the one that stands at home gives the branch.
        for index in 0..8 {
            let branch = Branch(index & 1, index >> 1 & 1, index >> 2);
            let Ok(joints) = arm.solve(&pose, &[0.0; 3], branch) else {
                continue;
            };
            let away = (Coords(joints) - *home)
                .0
                .iter()
                .fold(0.0_f64, |most, d| most.max(d.abs()));
            if nearest.is_none_or(|(least, _)| away < least) {
                nearest = Some((away, branch));
            }
        }
        let (away, branch) = nearest?;
        arm.branch = branch;
        (away < SAME_AS_HOME_RAD).then_some(arm)
    }

    fn solve<R: Real>(
        &self,
        pose: &Pose<R>,
        tool: &[f64; 3],
        branch: Branch,
    ) -> Result<[R; AXES], &'static str> {
        // The wrist's centre depends on the first three joints only, the orientation on the rest.
        let c = self.wrist_place(pose, tool);
        let [x1, x2, x3] = self.shoulder(c, branch)?;
        let [x4, x5, x6] = self.wrist(pose, [x1, x2, x3], branch)?;
        let mut positions = [R::constant(0.0); 6];
        for ((position, joint), moved) in positions
            .iter_mut()
            .zip(&self.chain.joints)
            .zip([x1, x2, x3, x4, x5, x6])
        {
            // Of the turns that are the same, the one within half a turn of home.
            let angle = joint.position(moved);
            *position = angle + R::constant(turns_to(angle.value(), self.home[joint.axis]));
        }
        Ok(in_order(&self.chain, &positions))
    }

    /// What the pose turns a direction to that is given as it points with all joints at zero.
    fn turned<R: Real>(&self, pose: &Pose<R>, at_zero: [f64; 3]) -> Vec3<R> {
        let parts = self
            .chain
            .columns
            .map(|column| R::constant(dot(column, at_zero)));
        let [x, y, z] = pose.columns;
        add(
            add(scale(x, parts[0]), scale(y, parts[1])),
            scale(z, parts[2]),
        )
    }

    fn wrist_place<R: Real>(&self, pose: &Pose<R>, tool: &[f64; 3]) -> Vec3<R> {
        add(
            pose.tip,
            self.turned(pose, sub(self.center, self.chain.tip_at_zero(tool))),
        )
    }

    /// The first three angles, that bring the wrist's centre to its place.
    fn shoulder<R: Real>(&self, c: Vec3<R>, branch: Branch) -> Result<[R; 3], &'static str> {
        let [j1, j2, j3, ..] = self.chain.joints.as_slice() else {
            return Err("there is no shoulder");
        };
        let u2 = j2.direction();
        let out = sub(c, constant(j1.point));
        // a cos x1 + b sin x1 = d, both sides being the centre's distance along u2.
        let (a, b) = (
            dot(constant(u2), out),
            -dot(
                constant(u2),
                lostmotion_base::vec::cross(constant(j1.direction()), out),
            ),
        );
        let d = R::constant(dot(u2, sub(self.center, j2.point)) - dot(u2, sub(j1.point, j2.point)));
        let h = (a * a + b * b).sqrt();
        // First joint: the centre's distance along u2 does not change with the second and third joint.
        let firsts = cosine(a, b, d, h - d, h + d).ok_or("it lies too near to the first axis")?;
        let x1 = pick(firsts, branch.0);
        let inner = add(j1.turning.by(out, -x1), constant(j1.point));
        // In the plane across u2: g = R(x2) (upper + R(x3) fore).
        let flat = |v: Vec3<R>| sub(v, scale(constant(u2), dot(constant(u2), v)));
        let g = flat(sub(inner, constant(j2.point)));
        let upper = flat(constant(sub(j3.point, j2.point)));
        let fore = flat(constant(sub(self.center, j3.point)));
        let side = lostmotion_base::vec::cross(constant(j3.direction()), fore);
        let (a, b) = (dot(upper, fore), dot(upper, side));
        let d = (dot(g, g) - dot(upper, upper) - dot(fore, fore)) * R::constant(0.5);
        let h = R::constant((a.value() * a.value() + b.value() * b.value()).sqrt());
        // Third joint: the distance from the second axis to the centre (law of cosines).
        let thirds = cosine(a, b, d, h - d, h + d).ok_or("it lies beyond the reach of the arm")?;
        let x3 = pick(thirds, branch.1);
        let reached = add(upper, j3.turning.by(fore, x3));
        // Second joint: turns the reached point onto the wanted one.
        let x2 = about(u2, reached, g).ok_or("the wrist lies on the second axis")?;
        Ok([x1, x2, x3])
    }

    /// The last three angles, that turn the tool.
    fn wrist<R: Real>(
        &self,
        pose: &Pose<R>,
        moved: [R; 3],
        branch: Branch,
    ) -> Result<[R; 3], &'static str> {
        let [j1, j2, j3, j4, j5, j6] = self.chain.joints.as_slice() else {
            return Err("there is no wrist");
        };
        let unturn = |v: Vec3<R>| {
            j3.turning.by(
                j2.turning.by(j1.turning.by(v, -moved[0]), -moved[1]),
                -moved[2],
            )
        };
        // Orientation left over once the first three joints are undone.
        let along = unturn(self.turned(pose, j6.direction()));
        let solutions = two(&j4.turning, &j5.turning, j6.direction(), along)
            .ok_or("the wrist cannot turn there")?;
        let [(first, second), (third, fourth)] = solutions;
        let (x4, x5) = if branch.2 == 0 {
            (first, second)
        } else {
            (third, fourth)
        };
        let x4 = x4.ok_or(
            "the wrist is straight, where its first and last axis turn the same (singular)",
        )?;
        // Sixth joint: from where a direction across its axis has to point.
        let marker = across(j6.direction());
        let seen = unturn(self.turned(pose, marker));
        let x6 = about(
            j6.direction(),
            constant(marker),
            j5.turning.by(j4.turning.by(seen, -x4), -x5),
        );
        Ok([x4, x5, x6.ok_or("the wrist cannot turn there")?])
    }

    fn error(&self, pose: &Coords, why: &'static str) -> KinematicsError {
        KinematicsError::Unreachable {
            pose: *pose,
            why: why.to_owned(),
        }
    }
}

fn pick<R: Real>(pair: [R; 2], index: usize) -> R {
    let [first, second] = pair;
    if index == 0 { first } else { second }
}

impl Kinematics for Arm {
    fn name(&self) -> &'static str {
        self.kind
    }

    fn inverse(&self, program: &Coords, tool: &[f64; 3]) -> Result<Coords, KinematicsError> {
        self.solve(&Pose::of_words(&program.0), tool, self.branch)
            .map(Coords)
            .map_err(|why| self.error(program, why))
    }

    fn inverse_jet(
        &self,
        program: &[Jet; 9],
        tool: &[f64; 3],
    ) -> Result<[Jet; 9], KinematicsError> {
        let joints = self.solve(&Pose::of_words(program), tool, self.branch);
        joints.map_err(|why| self.error(&Coords(program.map(|jet| jet.0[0])), why))
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
