//! Axes that several motors drive: a table `[gantry]` where the gaps of two are told apart, else one
//! motor, which moves alike as long as their gaps do.

use super::draft::{Draft, DraftAxis, DraftGantry, Fate, Row, Told, float};
use crate::machine::LEAST_BEAM_MM;
use lostmotion_base::AxisId;
use lostmotion_kinematics::KinematicsSpec;
use std::fmt::Write;

/// What to do where the gaps of the motors differ.
const HOW: &str = "where they differ add a table [gantry] (axis, along, first_at_mm, second_at_mm, second_gap_um)";

/// Decides of every axis with several motors what becomes of them, and reports it.
pub(super) fn settle(draft: &mut Draft) {
    for index in 0..draft.axes.len() {
        let axis = &draft.axes[index];
        let id = axis.id;
        let motors = 1 + axis.further.len();
        if motors == 1 {
            continue;
        }
        let told: Vec<Told> = axis.gaps().cloned().collect();
        let differ = told.windows(2).any(|pair| pair[0].value != pair[1].value);
        let beam = beam(draft, axis);
        if let (Ok(along), [_, second], true) = (beam, told.as_slice(), differ && motors == 2) {
            draft.row(
                format!("gantry of {id}"),
                "two motors",
                Fate::Used,
                format!("each with its own gap, the second by {}", second.from),
            );
            draft.gantry = Some(DraftGantry {
                axis: id,
                along,
                second_gap: second.clone(),
            });
            continue;
        }
        as_one(draft, index, &told, beam.err());
    }
}

/// The axis that moves the tool along the beam that an axis' motors carry, or why there is none.
fn beam(draft: &Draft, axis: &DraftAxis) -> Result<AxisId, &'static str> {
    if axis.further.len() > 1 {
        return Err("it has more than two motors");
    }
    if draft.gantry.is_some() {
        return Err("a machine has one such axis here");
    }
    if axis.rotary {
        return Err("it turns");
    }
    let slides = matches!(
        draft.kinematics,
        KinematicsSpec::Cartesian(_)
            | KinematicsSpec::TrunnionAc(_)
            | KinematicsSpec::TrunnionBc(_)
    );
    if !slides {
        return Err("its joints are no slides at right angles");
    }
    // The beam of a gantry, and the bridge or bed that two screws lift, lie along X; what moves along X
    // lies along Y.
    let wanted = match axis.id {
        AxisId::X | AxisId::U => [AxisId::Y, AxisId::Z],
        _ => [AxisId::X, AxisId::Y],
    };
    let is_there = |id: &AxisId| {
        let mut axes = draft.axes.iter();
        *id != axis.id && axes.any(|own| own.id == *id && !own.rotary)
    };
    wanted
        .into_iter()
        .find(is_there)
        .ok_or("no axis moves along its beam")
}

/// Several motors become one, with the widest of the gaps that are told.
fn as_one(draft: &mut Draft, index: usize, told: &[Told], no_beam: Option<&str>) {
    let axis = &mut draft.axes[index];
    let motors = 1 + axis.further.len();
    let from: Vec<&str> = axis.further.iter().map(|own| own.from.as_str()).collect();
    let from = from.join(", ");
    // The first of equal ones.
    let widest = told.iter().reduce(|widest, next| {
        if next.value > widest.value {
            next
        } else {
            widest
        }
    });
    let differ = told
        .iter()
        .any(|own| Some(own.value) != widest.map(|it| it.value));
    let (fate, note) = match (differ, told.len()) {
        (true, _) => (
            Fate::Guessed,
            format!(
                "with the widest gap, since {}",
                no_beam.unwrap_or("not all of their gaps are told")
            ),
        ),
        (false, 0) => (
            Fate::Guessed,
            format!("as if their gaps were the same, of which none is told: {HOW}"),
        ),
        (false, count) if count < motors => (
            Fate::Guessed,
            format!("as if all had the gap that is told of one: measure the others; {HOW}"),
        ),
        _ => (
            Fate::Used,
            "they have one gap, so that they move as one".to_owned(),
        ),
    };
    let id = axis.id;
    axis.gap = widest.cloned();
    let widest = widest.map(|it| (it.from.as_str(), it.value));
    for (by, value) in widest.into_iter() {
        let others = told.iter().filter(|own| own.value != value);
        for other in others {
            let mut rows = draft.rows.iter_mut();
            if let Some(row) = rows.rfind(|row| row.key == other.from && row.fate == Fate::Used) {
                row.fate = Fate::Ignored;
                row.note = format!("axis {id}: {by} counts");
            }
        }
    }
    let key = format!("axis {id}, {from}");
    draft.row(key, format!("{motors} motors as one"), fate, note);
}

/// Writes the table, the ends of the beam where the travel along it ends.
pub(super) fn table(draft: &Draft, travel: &[(f64, f64)], out: &mut String, rows: &mut Vec<Row>) {
    let Some(gantry) = &draft.gantry else { return };
    let at = draft.axes.iter().position(|axis| axis.id == gantry.along);
    let Some(&(min, max)) = at.and_then(|at| travel.get(at)) else {
        return;
    };
    let [axis, along] = [gantry.axis, gantry.along].map(|id| id.letter().to_ascii_lowercase());
    if max - min < LEAST_BEAM_MM {
        rows.push(Row {
            key: "gantry".to_owned(),
            value: String::new(),
            fate: Fate::Ignored,
            note: format!("{} travels too little for the ends of a beam", gantry.along),
        });
        return;
    }
    let _ = write!(
        out,
        "\n# two motors drive {}; guess: their ends of the beam are those of the travel of {}\n[gantry]\naxis = \"{axis}\"\nalong = \"{along}\"\nfirst_at_mm = {}\nsecond_at_mm = {}\nsecond_gap_um = {} # {}\n",
        gantry.axis,
        gantry.along,
        float(min),
        float(max),
        float(gantry.second_gap.value * 1e3),
        gantry.second_gap.from,
    );
    let mut guess = |key: &str, value: String, note: String| {
        rows.push(Row {
            key: key.to_owned(),
            value,
            fate: Fate::Guessed,
            note,
        });
    };
    guess(
        "gantry.first_at_mm, gantry.second_at_mm",
        format!("{}, {}", float(min), float(max)),
        format!(
            "the ends of the travel of {0}, the first motor at the lower: measure where along {0} each is",
            gantry.along
        ),
    );
    guess(
        "gantry.beam",
        "none".to_owned(),
        "a beam that yields to skew: set its stiffness_n_per_um and damping_n_s_per_mm".to_owned(),
    );
}
