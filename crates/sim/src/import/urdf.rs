//! URDF: a tree of links and joints; the chain from its root to its one end becomes a serial chain.
//!
//! Each joint's `origin` places it in its parent's frame with everything at zero, `axis` is its
//! direction there; lengths in m, angles in rad. A tree with two ends is a machine with table and
//! spindle where the name of one end begins with `work`, `table` or `part`: joints on the way there
//! move the workpiece and count against their direction. Where the tree ends in more links (flanges,
//! sensors, the fingers of a gripper), the one that holds the tool has to be named. See
//! <https://wiki.ros.org/urdf/XML>.

use super::draft::{Draft, Fate, Told, clean};
use super::{Format, ImportOptions, problem, xml};
use crate::machine::Problem;
use lostmotion_base::units::deg;
use lostmotion_base::{AxisId, math};
use lostmotion_kinematics::chain::{GaugeSpec, JointSpec, Side};
use lostmotion_kinematics::{ChainSpec, Words};
use roxmltree::Node;

/// The format's row.
pub(super) const FORMAT: Format = Format {
    name: "urdf",
    extensions: &["urdf"],
    looks_like: |text| text.contains("<robot"),
    is_lines: false,
    read,
};

/// Most nodes of a description. A choice: because an arm has some hundred, and one with the shapes
/// of all its links and a gripper some thousand.
const MOST_NODES: u32 = 100_000;

/// URDF is in metres.
const MM_PER_M: f64 = 1e3;

type Vector = [f64; 3];
type Matrix = [Vector; 3];

/// A joint of the tree.
struct Joint<'a> {
    line: usize,
    name: &'a str,
    kind: &'a str,
    parent: &'a str,
    child: &'a str,
    place: Vector,
    turn: Matrix,
    axis: Vector,
    limit: Option<Node<'a, 'a>>,
}

impl Joint<'_> {
    fn is_fixed(&self) -> bool {
        self.kind == "fixed"
    }
}

fn turned(rows: &Matrix, v: Vector) -> Vector {
    std::array::from_fn(|i| (0..3).map(|k| rows[i][k] * v[k]).sum())
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| std::array::from_fn(|column| (0..3).map(|k| row[k] * b[k][column]).sum()))
}

fn roll_pitch_yaw([r, p, y]: Vector) -> Matrix {
    let ((sr, cr), (sp, cp), (sy, cy)) = (math::sin_cos(r), math::sin_cos(p), math::sin_cos(y));
    [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ]
}

fn line(node: &Node<'_, '_>) -> usize {
    node.document().text_pos_at(node.range().start).row as usize
}

fn vector(node: Option<Node<'_, '_>>, attribute: &str, default: Vector) -> Result<Vector, Problem> {
    let Some((node, text)) = node.and_then(|node| Some((node, node.attribute(attribute)?))) else {
        return Ok(default);
    };
    let wrong = || {
        problem(
            line(&node),
            attribute,
            format!("`{text}` is not three numbers"),
            "write \"0 0 1\"",
        )
    };
    // A word that is no number must not drop out: "0 x 0 1" would pass as three numbers.
    let number = |word: &str| word.parse().ok().filter(|value: &f64| value.is_finite());
    let numbers: Option<Vec<f64>> = text.split_whitespace().map(number).collect();
    <Vector>::try_from(numbers.ok_or_else(wrong)?).map_err(|_| wrong())
}

/// Reads the file.
fn read(text: &str, options: &ImportOptions<'_>, _: &str) -> Result<Draft, Vec<Problem>> {
    let document = xml(text, MOST_NODES)?;
    let robot = document.root_element();
    if robot.tag_name().name() != "robot" {
        return Err(vec![problem(
            line(&robot),
            "",
            "the outermost element is not <robot>",
            "expand xacro files first",
        )]);
    }
    let mut problems = Vec::new();
    let mut joints = Vec::new();
    for node in robot.children().filter(|node| node.has_tag_name("joint")) {
        match joint(node) {
            Ok(found) => joints.push(found),
            Err(found) => problems.push(found),
        }
    }
    // The tree cannot be followed with a joint missing.
    if !problems.is_empty() {
        return Err(problems);
    }
    let mut draft = Draft::new("URDF");
    if let Some(name) = robot.attribute("name") {
        draft.name = name.to_owned();
    }
    // Links hold shapes and masses, which are not used; everything else is reported as ignored.
    for node in robot.children().filter(|node| {
        node.is_element() && !node.has_tag_name("joint") && !node.has_tag_name("link")
    }) {
        draft.row(
            format!("<{}>", node.tag_name().name()),
            node.attribute("name").unwrap_or(""),
            Fate::Ignored,
            "",
        );
    }
    build(&mut draft, &joints, options.tip).map_err(|problem| vec![problem])?;
    Ok(draft)
}

fn joint<'a>(node: Node<'a, 'a>) -> Result<Joint<'a>, Problem> {
    let child = |name: &str| node.children().find(|child| child.has_tag_name(name));
    let link = |name: &str| {
        let told = child(name).and_then(|found| found.attribute("link"));
        told.ok_or_else(|| {
            problem(
                line(&node),
                name,
                format!("the joint has no <{name} link=\"...\">"),
                "",
            )
        })
    };
    Ok(Joint {
        line: line(&node),
        name: node.attribute("name").unwrap_or("joint"),
        kind: node.attribute("type").ok_or_else(|| {
            problem(
                line(&node),
                "type",
                "the joint has no type",
                "revolute, continuous, prismatic or fixed",
            )
        })?,
        parent: link("parent")?,
        child: link("child")?,
        place: vector(child("origin"), "xyz", [0.0; 3])?.map(|metre| metre * MM_PER_M),
        turn: roll_pitch_yaw(vector(child("origin"), "rpy", [0.0; 3])?),
        // X where there is no <axis>, by the format's definition.
        axis: vector(child("axis"), "xyz", [1.0, 0.0, 0.0])?,
        limit: child("limit"),
    })
}

/// Joints from the root to a link, in order.
fn path<'a, 'b>(joints: &'b [Joint<'a>], end: &str) -> Vec<&'b Joint<'a>> {
    let mut way: Vec<&Joint<'a>> = Vec::new();
    let mut at = end.to_owned();
    while let Some(joint) = joints
        .iter()
        .find(|joint| joint.child == at)
        // Joints in a ring would go round for ever.
        .filter(|_| way.len() <= joints.len())
    {
        way.push(joint);
        at = joint.parent.to_owned();
    }
    way.reverse();
    way
}

/// The links at which the workpiece (if it moves) and the tool are.
fn ends<'a>(
    joints: &[Joint<'a>],
    tip: Option<&'a str>,
) -> Result<(Option<&'a str>, &'a str), Problem> {
    let is_end = |name: &str| joints.iter().all(|joint| joint.parent != name);
    let ends: Vec<&str> = joints
        .iter()
        .map(|joint| joint.child)
        .filter(|child| is_end(child))
        .collect();
    let is_table = |name: &str| {
        ["work", "table", "part"]
            .iter()
            .any(|word| name.starts_with(word))
    };
    let tables: Vec<&str> = ends.iter().copied().filter(|end| is_table(end)).collect();
    let tool = if let Some(tip) = tip {
        // Any link: flanges have fingers and sensors behind them.
        let known = joints
            .iter()
            .flat_map(|joint| [joint.parent, joint.child])
            .any(|link| link == tip);
        if !known {
            let message = format!("there is no link `{tip}`");
            let hint = format!("the tree ends in {}", ends.join(", "));
            return Err(problem(1, "--tip", message, &hint));
        }
        if path(joints, tip).iter().all(|joint| joint.is_fixed()) {
            let message = format!("nothing moves the link `{tip}`");
            let hint = format!("the tree ends in {}", ends.join(", "));
            return Err(problem(1, "--tip", message, &hint));
        }
        Some(tip)
    } else {
        // A link that nothing moves (the frame of a foot) holds no tool.
        let mut moved = ends.iter().copied().filter(|end| {
            !is_table(end) && path(joints, end).iter().any(|joint| !joint.is_fixed())
        });
        moved.next().filter(|_| moved.next().is_none())
    };
    match (tables.as_slice(), tool) {
        ([], Some(tool)) => Ok((None, tool)),
        ([table], Some(tool)) => Ok((Some(*table), tool)),
        _ => {
            let hint = "name the one that holds the tool with --tip LINK; a table's link is named work..., table... or part...";
            let message = format!("the tree ends in {} links: {}", ends.len(), ends.join(", "));
            Err(problem(1, "", message, hint))
        }
    }
}

fn build<'a>(draft: &mut Draft, joints: &[Joint<'a>], tip: Option<&'a str>) -> Result<(), Problem> {
    let (table, tool) = ends(joints, tip)?;
    // What is on neither way is told, so that no joint goes without a word.
    let ways: Vec<&str> = table
        .into_iter()
        .chain([tool])
        .flat_map(|end| path(joints, end))
        .map(|joint| joint.name)
        .collect();
    for joint in joints.iter().filter(|joint| !ways.contains(&joint.name)) {
        let note = format!("not on the way to {tool}");
        draft.row(
            format!("joint {}", joint.name),
            joint.kind,
            Fate::Ignored,
            note,
        );
    }
    let mut chain = Vec::new();
    if let Some(table) = table {
        side(draft, &path(joints, table), Side::Table, &mut chain)?;
        chain.reverse();
    }
    let (point, frame) = side(draft, &path(joints, tool), Side::Head, &mut chain)?;
    let column = |i: usize| [frame[0][i], frame[1][i], frame[2][i]];
    // The tool points along the last link's Z: from the tip to the spindle is against it.
    let gauge = GaugeSpec {
        point_mm: point,
        axis: column(2).map(|c| -c),
        x_axis: column(0),
    };
    // Without three slides the words cannot be joints.
    let has_slides = [AxisId::X, AxisId::Y, AxisId::Z].iter().all(|axis| {
        chain
            .iter()
            .any(|joint: &JointSpec| joint.axis_id() == Some(*axis) && !joint.is_rotary())
    });
    draft.kinematics = ChainSpec {
        words: (!has_slides).then_some(Words::Pose),
        gauge: Some(gauge),
        joint: chain,
        ..ChainSpec::default()
    }
    .into();
    Ok(())
}

/// Adds the joints on one side; gives where the last link is and how it is turned with all joints
/// at zero.
fn side(
    draft: &mut Draft,
    way: &[&Joint<'_>],
    side: Side,
    chain: &mut Vec<JointSpec>,
) -> Result<(Vector, Matrix), Problem> {
    let (mut point, mut frame): (Vector, Matrix) = (
        [0.0; 3],
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    );
    for joint in way {
        // The joint's frame at zero: its origin in the parent's frame, then its turn.
        let step = turned(&frame, joint.place);
        point = std::array::from_fn(|i| point[i] + step[i]);
        frame = times(&frame, &joint.turn);
        let rotary = match joint.kind {
            "revolute" | "continuous" => true,
            "prismatic" => false,
            "fixed" => {
                draft.row(
                    format!("joint {}", joint.name),
                    "fixed",
                    Fate::Used,
                    "moves what follows",
                );
                continue;
            }
            other => {
                return Err(problem(
                    joint.line,
                    joint.name,
                    format!("joints of type `{other}` are not known here"),
                    "revolute, continuous, prismatic, fixed",
                ));
            }
        };
        let axis = letter(draft, joint.name, rotary).ok_or_else(|| {
            problem(
                joint.line,
                joint.name,
                "there is no axis left for it",
                "at most nine joints",
            )
        })?;
        // The rounding of the turns would keep a direction from being exactly X, Y or Z.
        let direction = clean(turned(&frame, joint.axis));
        let spec = if rotary {
            JointSpec::rotary(axis, side, direction, clean(point))
        } else {
            JointSpec::linear(axis, direction)
        };
        chain.push(JointSpec {
            side: Some(side),
            sign: (side == Side::Table).then_some(-1.0),
            wrap: (joint.kind == "continuous").then_some(true),
            ..spec
        });
        limits(draft, joint, axis, rotary)?;
    }
    Ok((point, frame))
}

/// The axis named like the joint (`x`, `axis_c`), or the first that is left in the order of arms.
fn letter(draft: &Draft, name: &str, rotary: bool) -> Option<AxisId> {
    let free = |axis: &AxisId| draft.axes.iter().all(|taken| taken.id != *axis);
    let last = name.rsplit(['_', '-', ' ']).next().unwrap_or(name);
    let mut chars = last.chars();
    let named = chars
        .next()
        .and_then(AxisId::from_letter)
        .filter(|axis| chars.next().is_none() && axis.is_rotary() == rotary);
    named
        .filter(free)
        .or_else(|| AxisId::ALL.into_iter().find(free))
}

fn limits(draft: &mut Draft, joint: &Joint<'_>, axis: AxisId, rotary: bool) -> Result<(), Problem> {
    // URDF's m and rad in mm and degrees.
    let scale = if rotary { deg(1.0) } else { MM_PER_M };
    draft.row(
        format!("joint {}", joint.name),
        joint.kind,
        Fate::Used,
        format!("axis {axis}"),
    );
    // A joint without limits has an axis, too, whose limits are lent.
    draft.axis(axis, rotary);
    for attribute in joint.limit.iter().flat_map(roxmltree::Node::attributes) {
        let key = format!("joint {} limit {}", joint.name, attribute.name());
        let target = draft.axis(axis, rotary);
        let slot = match attribute.name() {
            "lower" => &mut target.min,
            "upper" => &mut target.max,
            "velocity" => &mut target.velocity,
            _ => {
                draft.row(
                    key,
                    attribute.value(),
                    Fate::Ignored,
                    "the drive comes from the preset",
                );
                continue;
            }
        };
        *slot = Some(Told {
            value: super::number(joint.line, &key, attribute.value())? * scale,
            from: key.clone(),
            line: joint.line,
        });
        draft.row(key, attribute.value(), Fate::Used, format!("axis {axis}"));
    }
    Ok(())
}
