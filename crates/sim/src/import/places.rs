//! Where an imported machine stands, and where its parts are: homes and work offsets.

use super::draft::{Draft, DraftAxis, Fate, MachineSize, Row, filled, float};
use super::problem;
use crate::machine::Problem;
use lostmotion_base::units::{deg, rad};
use lostmotion_base::{AxisId, Coords};
use lostmotion_kinematics::chain::JointSpec;
use lostmotion_kinematics::{KinematicsSpec, build};
use std::fmt::Write;

/// How far a SCARA's elbow is bent at its homes, degrees: any angle clear of straight and folded.
const ELBOW_DEG: f64 = 60.0;
/// How far the joints of an arm stand from the middle of their travel at home, degrees or mm, by
/// the order of its axes: unequal angles, at which no common arm is straight. A choice: primes,
/// those of the first six axes all different.
const ARM_HOME_OFFSETS: [f64; 9] = [7.0, -23.0, 41.0, 13.0, 37.0, 17.0, 5.0, 5.0, 5.0];
/// Part of its travel that a joint at home keeps from the ends. A choice: room for motion about
/// home.
const HOME_MARGIN: f64 = 0.05;

/// Where a joint of an arm stands at home, mm or deg.
pub(super) fn home_of(joint: &JointSpec, axes: &[DraftAxis], travel: &[(f64, f64)]) -> f64 {
    let index = axes
        .iter()
        .position(|axis| joint.axis_id() == Some(axis.id));
    let (min, max) = index
        .and_then(|index| travel.get(index))
        .copied()
        .unwrap_or((-90.0, 90.0));
    let middle = if min < 0.0 && max > 0.0 {
        0.0
    } else {
        0.5 * (min + max)
    };
    // A bent arm: straight ones are singular.
    let bent = middle
        + ARM_HOME_OFFSETS
            .get(index.unwrap_or(0))
            .copied()
            .unwrap_or(5.0);
    // A travel with one end lent may be reversed: min and max do not panic as clamp would, and
    // the check of the machine refuses it.
    (bent
        .min(max - HOME_MARGIN * (max - min))
        .max(min + HOME_MARGIN * (max - min))
        * 100.0)
        .round()
        / 100.0
}

/// Part of the travel that zero has to be inside its ends for parts to be around it. A choice: controls
/// that count from a switch have zero at an end, where no part is.
const CLEAR_OF_ENDS: f64 = 0.1;

/// Where parts are likely to be on an axis of a mill or router: at zero, or in the middle of a travel
/// that begins or ends there.
fn part_zero(min: f64, max: f64) -> f64 {
    let clear = CLEAR_OF_ENDS * (max - min);
    if (min + clear..=max - clear).contains(&0.0) {
        0.0
    } else {
        0.5 * (min + max)
    }
}

/// Work offset and homes within the travel: zero where it can be, else the middle.
pub(super) fn positions(
    draft: &Draft,
    travel: &[(f64, f64)],
    out: &mut String,
    rows: &mut Vec<Row>,
) -> Result<(), Vec<Problem>> {
    let kinematics = build(&draft.kinematics)
        .map_err(|error| vec![problem(1, "kinematics", error.to_string(), "")])?;
    // Machine files give places in words, not in joints.
    let words = kinematics.forward(&joints_at_home(draft, travel), &[0.0; 3]);
    let parts = part_place(draft, travel, &words);
    // Told places that the travel has go before those.
    let usual = ["work_offset.g54", "home.g28", "home.g30"];
    let told = draft.offsets.iter().map(|(table, ..)| *table);
    let mut seen = Vec::new();
    for key in usual.into_iter().chain(told) {
        if seen.contains(&key) {
            continue;
        }
        seen.push(key);
        let own = match key {
            "work_offset.g54" => Some(&parts),
            _ if usual.contains(&key) => Some(&words),
            _ => None,
        };
        table(draft, travel, (key, own), out, rows);
    }
    Ok(())
}

/// Where the joints stand: at zero where their travel has it, else in its middle; an arm at its home,
/// which is clear of singular poses.
fn joints_at_home(draft: &Draft, travel: &[(f64, f64)]) -> Coords {
    let mut joints = Coords::ZERO;
    for (axis, (min, max)) in draft.axes.iter().zip(travel) {
        let at = if *min <= 0.0 && *max >= 0.0 {
            0.0
        } else {
            0.5 * (min + max)
        };
        joints[axis.id] = if axis.rotary { rad(at) } else { at };
        if matches!(draft.kinematics, KinematicsSpec::Scara(_)) && axis.id == AxisId::B {
            // A straight arm is singular.
            joints[axis.id] = rad(ELBOW_DEG.min(*max).max(*min));
        }
    }
    if let KinematicsSpec::Chain(chain) = &draft.kinematics
        && let Some(home) = &chain.home
    {
        for (joint, at) in chain.joint.iter().zip(home) {
            let Some(id) = joint.axis_id() else {
                continue;
            };
            joints[id] = if joint.is_rotary() { rad(*at) } else { *at };
        }
    }
    joints
}

/// Where parts are: of a mill around zero or in the middle of the travel. Of a lathe zero of X is the
/// middle of its spindle, and of a printer the corner of its bed.
fn part_place(draft: &Draft, travel: &[(f64, f64)], words: &Coords) -> Coords {
    let linear = [AxisId::X, AxisId::Y, AxisId::Z];
    let has = |id: &AxisId| draft.axes.iter().any(|axis| axis.id == *id && !axis.rotary);
    let is_mill = matches!(draft.kinematics, KinematicsSpec::Cartesian(_))
        && draft.size == MachineSize::Router
        && linear.iter().all(has);
    let mut parts = *words;
    if is_mill {
        for (axis, (min, max)) in draft.axes.iter().zip(travel) {
            if linear.contains(&axis.id) {
                parts[axis.id] = part_zero(*min, *max);
            }
        }
    }
    parts
}

/// Writes the table of a place, as told where the travel has that, else its usual one if it has any.
fn table(
    draft: &Draft,
    travel: &[(f64, f64)],
    (key, usual): (&'static str, Option<&Coords>),
    out: &mut String,
    rows: &mut Vec<Row>,
) {
    let mut lines = Vec::new();
    for axis in AxisId::ALL {
        let own = usual.map_or(0.0, |place| place[axis]);
        let own = if axis.is_rotary() { deg(own) } else { own };
        let mut offsets = draft.offsets.iter();
        let told = offsets.rfind(|(table, id, _)| *table == key && *id == axis);
        let at = draft.axes.iter().position(|own| own.id == axis);
        let has = |value: f64| {
            at.and_then(|at| travel.get(at))
                .is_some_and(|(min, max)| (*min..=*max).contains(&value))
        };
        let (value, from) = match told {
            Some((_, _, told)) if has(told.value) => (told.value, format!(" # {}", told.from)),
            Some((_, _, told)) => {
                rows.push(Row {
                    key: told.from.clone(),
                    value: float(told.value),
                    fate: Fate::Ignored,
                    note: format!("{key}: outside the travel of {axis}"),
                });
                (own, String::new())
            }
            None => (own, String::new()),
        };
        // What a position leaves out is 0.
        if value.abs() > 1e-9 {
            lines.push(format!("{} = {}{from}", axis.column(), float(value)));
        }
    }
    let told = draft.offsets.iter().any(|(table, ..)| *table == key);
    let why = if told {
        "as told; the rest within the travel"
    } else {
        "within the travel: set it to where parts are"
    };
    let _ = write!(out, "# {why}\n[{key}]\n{}\n\n", lines.join("\n"));
    if !told {
        rows.push(filled(key, lines.join(", "), "within the travel"));
    }
}
