//! Machines of every family, and random poses of each.
#![allow(
    clippy::disallowed_methods,
    clippy::unwrap_used,
    clippy::panic,
    dead_code,
    unreachable_pub
)]

use lostmotion_base::units::rad;
use lostmotion_base::{AxisId, Coords, Random};
use lostmotion_kinematics::{Kinematics, KinematicsSpec, build};

/// Machines with two rotary axes.
pub const FIVE: [&str; 9] = [
    "table-table AC",
    "table-table BC",
    "head-head CA",
    "head-head AB",
    "head-table BC",
    "nutating head",
    "nutating table",
    "nutating head-table",
    "trunnion-ac",
];

/// A tool: up to 5 mm aside, up to 200 mm long.
pub fn tool(random: &mut Random) -> [f64; 3] {
    [
        5.0 * random.signed(),
        5.0 * random.signed(),
        random.between(0.0, 200.0),
    ]
}

/// How poses of a machine are made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Poses {
    /// Any words.
    Any,
    /// Within a circle of X and Y.
    Within(f64),
    /// X and Y between two circles, any C.
    Ring(f64, f64),
    /// Those of joints so far about home, degrees, in the order of the chain.
    Around(&'static [f64], f64),
}

pub struct Machine {
    pub name: &'static str,
    pub spec: KinematicsSpec,
    pub poses: Poses,
}

fn rotary(axis: &str, side: &str, direction: [f64; 3], point: [f64; 3], sign: i32) -> String {
    format!(
        "[[joint]]\naxis = \"{axis}\"\ntype = \"rotary\"\nside = \"{side}\"\ndirection = {direction:?}\npoint_mm = {point:?}\nsign = {sign}\n"
    )
}

fn linear(axis: &str, side: &str, direction: [f64; 3]) -> String {
    format!(
        "[[joint]]\naxis = \"{axis}\"\ntype = \"linear\"\nside = \"{side}\"\ndirection = {direction:?}\n"
    )
}

const X: [f64; 3] = [1.0, 0.0, 0.0];
const Y: [f64; 3] = [0.0, 1.0, 0.0];
const Z: [f64; 3] = [0.0, 0.0, 1.0];
const YZ45: [f64; 3] = [
    0.0,
    std::f64::consts::FRAC_1_SQRT_2,
    std::f64::consts::FRAC_1_SQRT_2,
];

fn xyz(side: &str) -> String {
    [("x", X), ("y", Y), ("z", Z)]
        .map(|(axis, direction)| linear(axis, side, direction))
        .concat()
}

fn chain(name: &'static str, head: &str, joints: &[String], poses: Poses) -> Machine {
    let text = format!("kind = \"chain\"\n{head}{}", joints.concat());
    Machine {
        name,
        spec: toml::from_str(&text).unwrap_or_else(|error| panic!("{name}: {error}\n{text}")),
        poses,
    }
}

fn plain(name: &'static str, text: &str, poses: Poses) -> Machine {
    Machine {
        name,
        spec: toml::from_str(text).unwrap(),
        poses,
    }
}

fn machine_tools() -> Vec<Machine> {
    let p = [40.0, -25.0, 60.0];
    let q = [-12.0, 33.0, 90.0];
    vec![
        chain("3 axes", "", &[xyz("head")], Poses::Any),
        chain(
            "3 axes, inclined",
            "",
            &[
                linear("x", "table", X),
                linear("y", "head", [0.1, 0.9, 0.45]),
                linear("z", "head", Z),
            ],
            Poses::Any,
        ),
        chain(
            "rotary table A",
            "",
            &[rotary("a", "table", X, p, 1), xyz("head")],
            Poses::Any,
        ),
        chain(
            "rotary head B",
            "",
            &[xyz("head"), rotary("b", "head", Y, p, 1)],
            Poses::Any,
        ),
        chain(
            "table-table AC",
            "",
            &[
                rotary("c", "table", Z, p, 1),
                rotary("a", "table", X, q, -1),
                xyz("head"),
            ],
            Poses::Any,
        ),
        chain(
            "table-table BC",
            "",
            &[
                rotary("c", "table", Z, p, -1),
                rotary("b", "table", Y, q, 1),
                xyz("head"),
            ],
            Poses::Any,
        ),
        chain(
            "head-head CA",
            "",
            &[
                xyz("head"),
                rotary("c", "head", Z, p, 1),
                rotary("a", "head", X, q, 1),
            ],
            Poses::Any,
        ),
        chain(
            "head-head AB",
            "",
            &[
                xyz("head"),
                rotary("a", "head", X, p, 1),
                rotary("b", "head", Y, q, 1),
                linear("w", "head", [0.0, 0.0, -1.0]),
            ],
            Poses::Any,
        ),
        chain(
            "head-table BC",
            "",
            &[
                rotary("c", "table", Z, p, 1),
                xyz("head"),
                rotary("b", "head", Y, q, 1),
            ],
            Poses::Any,
        ),
        chain(
            "nutating head",
            "",
            &[
                xyz("head"),
                rotary("c", "head", Z, p, 1),
                rotary("b", "head", YZ45, q, 1),
            ],
            Poses::Any,
        ),
        chain(
            "nutating table",
            "",
            &[
                rotary("c", "table", Z, p, 1),
                rotary("b", "table", YZ45, q, 1),
                xyz("head"),
            ],
            Poses::Any,
        ),
        chain(
            "nutating head-table",
            "",
            &[
                rotary("c", "table", Z, p, 1),
                xyz("head"),
                rotary("b", "head", YZ45, q, -1),
            ],
            Poses::Any,
        ),
        chain(
            "X on the table's A",
            "",
            &[
                linear("x", "table", X),
                rotary("a", "table", X, p, 1),
                linear("y", "head", Y),
                linear("z", "head", Z),
                rotary("b", "head", Y, q, 1),
            ],
            Poses::Any,
        ),
        plain(
            "trunnion-ac",
            "kind = \"trunnion-ac\"\nrotation_point_mm = [200.0, 150.0, -40.0]\noffset_y_mm = 3.0\noffset_z_mm = 20.0",
            Poses::Any,
        ),
        plain(
            "trunnion-bc",
            "kind = \"trunnion-bc\"\nrotation_point_mm = [1.0, -150.0, -40.0]\noffset_x_mm = 3.0\nconventional_directions = false",
            Poses::Any,
        ),
    ]
}

pub const ARM_HOME: &[f64] = &[0.0, -20.0, 30.0, 10.0, 40.0, 20.0];

fn arm_joints(wrist: f64) -> Vec<String> {
    // A vertical arm with shoulder and elbow offsets; a wrist offset of 0 makes its last three axes
    // meet.
    vec![
        rotary("x", "head", Z, [0.0; 3], 1),
        rotary("y", "head", Y, [150.0, 0.0, 450.0], 1),
        rotary("z", "head", Y, [150.0, 0.0, 1050.0], 1),
        rotary("a", "head", X, [150.0, 0.0, 1180.0], 1),
        rotary("b", "head", Y, [790.0, 0.0, 1180.0 + wrist], 1),
        rotary("c", "head", X, [790.0, wrist, 1180.0], 1),
    ]
}

pub fn others() -> Vec<Machine> {
    let gauge = "[gauge]\npoint_mm = [890.0, 0.0, 1180.0]\naxis = [-1.0, 0.0, 0.0]\nx_axis = [0.0, 0.0, 1.0]\n";
    let head = |home: &[f64]| format!("words = \"pose\"\nhome = {home:?}\n{gauge}");
    let five: Vec<String> = arm_joints(60.0).into_iter().take(5).collect();
    let mut seven = arm_joints(60.0);
    seven.insert(0, linear("u", "table", Y));
    vec![
        plain("cartesian", "kind = \"cartesian\"", Poses::Any),
        plain("corexy", "kind = \"corexy\"", Poses::Any),
        plain(
            "delta",
            "kind = \"delta\"\ntower_radius_mm = 150.0\nrod_mm = 320.0",
            Poses::Within(140.0),
        ),
        plain(
            "scara",
            "kind = \"scara\"\nupper_arm_mm = 300.0\nforearm_mm = 250.0",
            Poses::Ring(100.0, 540.0),
        ),
        chain(
            "arm, spherical wrist",
            &head(ARM_HOME),
            &arm_joints(0.0),
            Poses::Around(ARM_HOME, 35.0),
        ),
        chain(
            "arm, offset wrist (numeric)",
            &head(ARM_HOME),
            &arm_joints(60.0),
            Poses::Around(ARM_HOME, 25.0),
        ),
        chain(
            "arm on a rail, 7 joints (numeric)",
            &head(&[0.0, 0.0, -20.0, 30.0, 10.0, 40.0, 20.0]),
            &seven,
            Poses::Around(&[0.0, 0.0, -20.0, 30.0, 10.0, 40.0, 20.0], 20.0),
        ),
        chain(
            "arm of 5 joints (numeric)",
            &head(&ARM_HOME[..5]),
            &five,
            Poses::Around(&[0.0, -20.0, 30.0, 10.0, 40.0], 20.0),
        ),
    ]
}

pub fn machines() -> Vec<Machine> {
    machine_tools().into_iter().chain(others()).collect()
}

impl Machine {
    pub fn build(&self) -> Box<dyn Kinematics> {
        build(&self.spec).unwrap_or_else(|error| panic!("{}: {error}", self.name))
    }

    /// Random program words and a tool.
    pub fn pose(&self, machine: &dyn Kinematics, random: &mut Random) -> (Coords, [f64; 3]) {
        let tool = tool(random);
        let mut words = Coords::ZERO;
        for axis in AxisId::ALL {
            words[axis] = if axis.is_rotary() {
                7.0 * random.signed()
            } else {
                500.0 * random.signed()
            };
        }
        match self.poses {
            Poses::Any => {}
            Poses::Within(radius) => {
                let (r, turn) = (random.between(0.0, radius - 8.0), random.between(0.0, 6.3));
                words.0[..2].copy_from_slice(&[r * turn.cos(), r * turn.sin()]);
            }
            Poses::Ring(near, far) => {
                let (r, turn) = (
                    random.between(near + 8.0, far - 8.0),
                    random.between(-2.9, 2.9),
                );
                words.0[..2].copy_from_slice(&[r * turn.cos(), r * turn.sin()]);
                (words.0[3], words.0[4]) = (0.0, 0.0);
            }
            Poses::Around(home, about) => {
                let mut joints = Coords::ZERO;
                for (joint, home) in machine.chain().unwrap().joints().iter().zip(home) {
                    joints[joint.axis] = rad(home + about * random.signed());
                    if !joint.rotary {
                        joints[joint.axis] = home + 5.0 * about * random.signed();
                    }
                }
                words = machine.forward(&joints, &tool);
            }
        }
        (words, tool)
    }
}

/// How far two sets of words are from each other: mm of X Y Z U V W, and rad of turns. Roll, pitch
/// and yaw by what they make of a vector, other words as numbers.
pub fn difference(machine: &Machine, there: &Coords, back: &Coords) -> (f64, f64) {
    let linear = [0, 1, 2, 6, 7, 8]
        .map(|i| (there.0[i] - back.0[i]).abs())
        .into_iter()
        .fold(0.0, f64::max);
    if let Poses::Around(home, _) = machine.poses {
        let [p, q] = [there, back].map(|words| turned(words.rotary()));
        let columns = if home.len() == 5 { 2..3 } else { 0..3 };
        let away = columns
            .map(|c| {
                (0..3)
                    .map(|i| (p[c][i] - q[c][i]).powi(2))
                    .sum::<f64>()
                    .sqrt()
            })
            .fold(0.0, f64::max);
        let only: f64 = (0..3)
            .map(|i| (there.0[i] - back.0[i]).powi(2))
            .sum::<f64>();
        return (only.sqrt(), away);
    }
    (
        linear,
        [3, 4, 5]
            .map(|i| (there.0[i] - back.0[i]).abs())
            .into_iter()
            .fold(0.0, f64::max),
    )
}

/// Columns of Rz(c) Ry(b) Rx(a), written out.
fn turned([a, b, c]: [f64; 3]) -> [[f64; 3]; 3] {
    let ((sa, ca), (sb, cb), (sc, cc)) = (a.sin_cos(), b.sin_cos(), c.sin_cos());
    [
        [cc * cb, sc * cb, -sb],
        [cc * sb * sa - sc * ca, sc * sb * sa + cc * ca, cb * sa],
        [cc * sb * ca + sc * sa, sc * sb * ca - cc * sa, cb * ca],
    ]
}
