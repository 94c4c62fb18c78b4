//! Whether what a machine file says makes sense: values in their range, parts that go together.

use super::document::Document;
use super::limits::unit;
use super::problem::Problem;
use super::section::join;
use super::settings::{BOW_LIMIT_UM, Position};
use super::{General, MachineAxis, WorkOffsets, reach};
use lostmotion_base::units::{deg, number};
use lostmotion_base::{AxisId, AxisSet, Coords};
use lostmotion_drive::AxisConfigError;
use lostmotion_drive::config::CompensatorSettings;
use lostmotion_drive::config::Transmission;
use lostmotion_kinematics::Kinematics;
use lostmotion_methods::AxisConfig;

/// Most joints of a control (LinuxCNC's EMCMOT_MAX_JOINTS).
const MOST_JOINTS: usize = 16;

/// Checks every axis for itself.
pub(super) fn axes(
    document: &Document<'_>,
    general: Option<&General>,
    axes: &[MachineAxis],
    problems: &mut Vec<Problem>,
) {
    for axis in axes {
        let key = format!("axis.{}", axis.id.letter().to_ascii_lowercase());
        limits(document, &key, axis, problems);
        config(document, &key, &axis.config, problems);
        kind_of_motion(document, &key, axis, turns(general, axis.id), problems);
    }
}

fn out_of_range(value: f64, low: f64, high: f64) -> String {
    format!(
        "is {}; it has to be from {} to {}",
        number(value),
        number(low),
        number(high)
    )
}

fn limits(document: &Document<'_>, key: &str, axis: &MachineAxis, problems: &mut Vec<Problem>) {
    let bounded = axis.table.bounded();
    for (name, value, low, high) in bounded {
        // Written so that NaN is out of range, too.
        if !(value >= low && value <= high) {
            problems.push(document.problem(
                &format!("{key}.limits.{name}"),
                out_of_range(value, low, high),
                "",
            ));
        }
    }
    let [(_, min, ..), (max_key, max, ..), ..] = bounded;
    if min >= max {
        let message = format!(
            "is {}, but the travel begins at {} {}",
            number(max),
            number(min),
            unit(axis.is_rotary())
        );
        problems.push(document.problem(
            &format!("{key}.limits.{max_key}"),
            message,
            "the upper end of the travel has to lie above the lower one",
        ));
    }
}

/// The parts of an axis are checked one by one first, so that each can tell its own problem, then
/// together.
pub(super) fn config(
    document: &Document<'_>,
    key: &str,
    config: &AxisConfig,
    problems: &mut Vec<Problem>,
) {
    let parts = [
        ("cycles", config.cycles.check()),
        ("transmission", config.transmission.check()),
        ("motor", config.motor.check()),
        ("load", config.load.check(&config.transmission)),
        ("drive", config.drive.check(&config.cycles)),
        (
            "compensation",
            config.compensation.check(&config.transmission),
        ),
    ];
    let before = problems.len();
    for (part, result) in parts {
        if let Err(error) = result {
            problems.push(axis_problem(document, key, &error.within(part)));
        }
    }
    // Only parts that are sound by themselves can be held against each other.
    if problems.len() == before
        && let Err(error) = config.check()
    {
        problems.push(axis_problem(document, key, &error));
    }
}

/// Two motors on one axis move in the same unit.
pub(super) fn transmissions(
    document: &Document<'_>,
    first: &AxisConfig,
    second: &AxisConfig,
    problems: &mut Vec<Problem>,
) {
    if first.unit() != second.unit() {
        let message = format!(
            "moves in {}, but the first end in {}",
            second.unit().symbol(),
            first.unit().symbol()
        );
        problems.push(document.problem(
            "gantry.second.transmission",
            message,
            "both ends of a gantry move in one unit",
        ));
    }
}

/// Whether an axis has to turn: a chain says itself which of its joints do.
fn turns(general: Option<&General>, axis: AxisId) -> bool {
    general.map_or(axis.is_rotary(), |general| {
        general.kinematics.is_rotary(axis)
    })
}

fn kind_of_motion(
    document: &Document<'_>,
    key: &str,
    axis: &MachineAxis,
    meant: bool,
    problems: &mut Vec<Problem>,
) {
    // The unit of the limits tells how the file means the axis to move.
    if axis.is_rotary() != meant {
        let message = format!(
            "are in {}, but axis {} moves in {}",
            unit(axis.is_rotary()),
            axis.id,
            unit(meant)
        );
        problems.push(document.problem(
            &format!("{key}.limits"),
            message,
            "give travel and limits in that unit",
        ));
    }
    // The transmission tells how its drive does.
    let rotary = matches!(axis.config.transmission, Transmission::Rotary(_));
    if rotary != meant {
        let (is, wants) = if rotary {
            ("rotary", "linear")
        } else {
            ("linear", "rotary")
        };
        let message = format!("is {is}, but axis {} moves in {}", axis.id, unit(meant));
        problems.push(document.problem(
            &format!("{key}.transmission"),
            message,
            format!("describe it as {key}.transmission.{wants}"),
        ));
    }
}

pub(super) fn axis_problem(
    document: &Document<'_>,
    table: &str,
    error: &AxisConfigError,
) -> Problem {
    match error {
        AxisConfigError::Range {
            key,
            value,
            allowed,
        } => document.problem(
            &join(table, key),
            format!("is {}; it has to be {allowed}", number(*value)),
            "",
        ),
        AxisConfigError::Mismatch { key, reason, hint } => document.problem(
            &join(table, key),
            format!("does not fit: {reason}"),
            hint.clone(),
        ),
        // The error may get kinds that have no key to point at.
        other => document.problem(table, other.to_string(), ""),
    }
}

/// Checks what is not an axis, and that it goes with the axes.
pub(super) fn general(
    document: &Document<'_>,
    general: &General,
    axes: &[MachineAxis],
    problems: &mut Vec<Problem>,
) {
    // Written so that NaN is out of range, too.
    let mut range = |key: &str, value: f64, low: f64, high: f64| {
        if !(value >= low && value <= high) {
            problems.push(document.problem(key, out_of_range(value, low, high), ""));
        }
    };
    range(
        "planner.default_tolerance_mm",
        general.planner.default_tolerance_mm,
        1e-6,
        100.0,
    );
    range(
        "planner.exact_path_tolerance_mm",
        general.planner.exact_path_tolerance_mm,
        1e-6,
        1.0,
    );
    range(
        "planner.exact_path_angle_deg",
        general.planner.exact_path_angle_deg,
        0.0,
        10.0,
    );
    range(
        "simulate.tolerance_um",
        general.simulate.tolerance_um,
        1e-3,
        1e6,
    );
    range(
        "simulate.bow_limit_um",
        general.simulate.bow_limit_um.unwrap_or(BOW_LIMIT_UM),
        1e-3,
        1e6,
    );
    range(
        "simulate.cutting_force_n",
        general.simulate.cutting_force_n,
        0.0,
        1e6,
    );
    for (index, tool) in general.tool.iter().enumerate() {
        range(
            &format!("tool[{index}].length_mm"),
            tool.length_mm,
            0.0,
            1e4,
        );
        range(
            &format!("tool[{index}].diameter_mm"),
            tool.diameter_mm,
            0.0,
            1e4,
        );
    }
    if let Err(error) = general.cycles.check() {
        problems.push(axis_problem(document, "", &error.within("cycles")));
    }
    if general.name.trim().is_empty() {
        problems.push(document.problem("name", "is empty", "give the machine a name"));
    }
    tools(document, general, problems);
    // what follows would only repeat an axis that could not be read
    if problems
        .iter()
        .any(|problem| problem.key.starts_with("axis"))
    {
        return;
    }
    let set: AxisSet = axes.iter().map(|axis| axis.id).collect();
    joint_axes(document, general, set, problems);
    kinematics(document, general, axes, set, problems);
}

/// Each joint of the control moves an axis or none, and each axis has a joint.
fn joint_axes(
    document: &Document<'_>,
    general: &General,
    set: AxisSet,
    problems: &mut Vec<Problem>,
) {
    let Some(letters) = &general.joint_axes else {
        return;
    };
    let axes: Vec<Option<AxisId>> = letters.chars().map(AxisId::from_letter).collect();
    let wrong = letters
        .chars()
        .zip(&axes)
        .find(|(c, axis)| *c != '-' && axis.is_none_or(|axis| !set.contains(axis)));
    let lost = set.iter().find(|axis| !axes.contains(&Some(*axis)));
    let message = match (wrong, lost) {
        _ if axes.len() > MOST_JOINTS => {
            format!("has {} joints, more than {MOST_JOINTS}", axes.len())
        }
        (Some((c, _)), _) => format!("is `{letters}`, and the machine has no axis `{c}`"),
        (None, Some(axis)) => format!("is `{letters}`, without a joint of axis {axis}"),
        (None, None) => return,
    };
    let has: String = set.iter().map(AxisId::letter).collect();
    let hint = format!(
        "the letters of {has} in the order of the joints' numbers, a letter twice for two motors of an axis, - for a joint of no axis"
    );
    problems.push(document.problem("joint_axes", message, hint));
}

fn tools(document: &Document<'_>, general: &General, problems: &mut Vec<Problem>) {
    for (index, tool) in general.tool.iter().enumerate() {
        if general
            .tool
            .iter()
            .take(index)
            .any(|other| other.number == tool.number)
        {
            let message = format!("tool {} is listed twice", tool.number);
            problems.push(document.problem(
                &format!("tool[{index}].number"),
                message,
                "remove one of the two",
            ));
        }
    }
}

/// Every position of a file with its key.
fn all_positions(general: &General) -> Vec<(String, Position)> {
    let offsets = WorkOffsets::KEYS
        .iter()
        .zip(general.work_offset.all())
        .map(|(key, position)| (format!("work_offset.{key}"), position));
    let homes = [
        ("home.g28".to_owned(), general.home.g28),
        ("home.g30".to_owned(), general.home.g30),
    ];
    offsets
        .chain(homes)
        .chain(general.start.map(|start| ("start".to_owned(), start)))
        .collect()
}

fn positions(
    document: &Document<'_>,
    general: &General,
    set: AxisSet,
    problems: &mut Vec<Problem>,
) {
    for (key, position) in all_positions(general) {
        for axis in position.named().filter(|axis| !set.contains(*axis)) {
            let has: Vec<String> = set.iter().map(|axis| axis.to_string()).collect();
            let message = format!("the machine has no axis {axis}");
            problems.push(document.problem(
                &format!("{key}.{}", axis.column()),
                message,
                format!("its axes are {}", has.join(" ")),
            ));
        }
    }
}

fn kinematics(
    document: &Document<'_>,
    general: &General,
    axes: &[MachineAxis],
    set: AxisSet,
    problems: &mut Vec<Problem>,
) {
    let kinematics = match lostmotion_kinematics::build_within(&general.kinematics, &reach(axes)) {
        Ok(kinematics) => kinematics,
        Err(error) => {
            problems.push(document.problem("kinematics.kind", error.to_string(), ""));
            return;
        }
    };
    let layout = kinematics.layout();
    positions(
        document,
        general,
        layout.map_or(set, |layout| layout.words),
        problems,
    );
    // A kinematics without a layout is probed for the joints that it couples.
    let needed = layout.map_or_else(|| coupled(kinematics.as_ref()), |layout| layout.joints);
    for missing in needed.iter().filter(|axis| !set.contains(*axis)) {
        let message = format!("needs an axis {missing}, which the machine does not have");
        let hint = format!(
            "add [axis.{}] or choose another kind",
            missing.letter().to_ascii_lowercase()
        );
        problems.push(document.problem("kinematics.kind", message, hint));
    }
    let mut stands = vec![
        ("home.g28", general.home.g28),
        ("home.g30", general.home.g30),
    ];
    // Without [start] the machine stands at the origin of G54: that place has to be reachable.
    stands.push(("start", general.start.unwrap_or(general.work_offset.g54)));
    for (key, position) in stands {
        in_travel(
            document,
            key,
            &position.coords(),
            axes,
            kinematics.as_ref(),
            problems,
        );
    }
}

/// The axes that cannot be missing: those that move another joint than their own, and the joints
/// that they move. Found by moving each axis of a pose in which no angle is special.
fn coupled(kinematics: &dyn Kinematics) -> AxisSet {
    let pose = Coords([30.0, 20.0, 10.0, 0.3, 0.4, 0.5, 1.0, 2.0, 3.0]);
    // A pose out of reach tells nothing; what is wrong with it is told elsewhere.
    let Ok(here) = kinematics.inverse(&pose, &[0.0; 3]) else {
        return AxisSet::EMPTY;
    };
    // An axis that moves another joint than its own is coupled with it.
    let mut set = AxisSet::EMPTY;
    for axis in AxisId::ALL {
        let mut moved = pose;
        moved[axis] += 0.1;
        let Ok(there) = kinematics.inverse(&moved, &[0.0; 3]) else {
            continue;
        };
        let others = AxisId::ALL
            .into_iter()
            .filter(|joint| *joint != axis && (there[*joint] - here[*joint]).abs() > 1e-9);
        for joint in others {
            set = set.with(axis).with(joint);
        }
    }
    set
}

fn in_travel(
    document: &Document<'_>,
    key: &str,
    at: &Coords,
    axes: &[MachineAxis],
    kinematics: &dyn Kinematics,
    problems: &mut Vec<Problem>,
) {
    // Without a tool: homes and the start are places of the spindle.
    let joints = match kinematics.inverse(at, &[0.0; 3]) {
        Ok(joints) => joints,
        Err(error) => {
            problems.push(document.problem(key, error.to_string(), ""));
            return;
        }
    };
    // A home on the limit itself must not fail by the rounding of the inverse.
    for axis in axes
        .iter()
        .filter(|axis| !axis.limits.contains(joints[axis.id], 1e-9))
    {
        let shown = |value: f64| number(if axis.is_rotary() { deg(value) } else { value });
        let (position, min, max) = (
            shown(joints[axis.id]),
            shown(axis.limits.min),
            shown(axis.limits.max),
        );
        let message = format!(
            "joint {} would stand at {position} {}, outside its travel from {min} to {max}",
            axis.id,
            unit(axis.is_rotary())
        );
        let hint = if key == "start" {
            "set [start], or the origin of G54, which is where the machine stands if [start] is left out"
        } else {
            ""
        };
        problems.push(document.problem(
            &format!("{key}.{}", AxisId::column(axis.id)),
            message,
            hint,
        ));
    }
}
