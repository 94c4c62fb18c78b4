//! A ballbar's sheet as text, beside that of a simulated machine where there is one.

use super::TextOptions;
use super::table::{Align, Table};
use crate::number::{error, fixed, plain};
use lostmotion_contour::ballbar::{BallbarSheet, Explained};
use lostmotion_sim::testpart::BallbarAnswer;

const LEFT: Align = Align::Left;
const RIGHT: Align = Align::Right;

/// The whole answer. Ends in a newline.
pub fn ballbar(answer: &BallbarAnswer, options: &TextOptions) -> String {
    let measured = &answer.measured;
    let names: Vec<String> = measured.axes.iter().map(ToString::to_string).collect();
    let mut out = format!(
        "{}: circle of {} mm in {}\n",
        answer.sheets.join(", "),
        plain(measured.radius_mm),
        names.concat(),
    );
    if let (Some(machine), Some(feed)) = (&answer.machine, answer.feed_mm_min) {
        out.push_str(&format!(
            "beside it {machine} as simulated at {} mm/min\n",
            plain(feed)
        ));
    }
    out.push_str("\nISO 230-4, um\n");
    out.push_str(&values(answer, options));
    out.push_str("\nwhat explains it (95 %)\n");
    out.push_str(&explained(answer, &names, options));
    out.push_str(&format!(
        "left unexplained: {} um RMS, spikes aside\n",
        error(measured.left_um)
    ));
    if let Some(apart) = answer.apart_rms_um {
        out.push_str(&format!(
            "measured and simulated path: {} um RMS apart, centre and mean radius aside\n",
            error(apart)
        ));
    }
    for reason in &measured.untold {
        out.push_str(&format!("not told: {reason}\n"));
    }
    out.push_str("\nreversals, um\n");
    out.push_str(&reversals(answer, options));
    out
}

fn sense(counterclockwise: bool) -> &'static str {
    if counterclockwise { "ccw" } else { "cw" }
}

fn values(answer: &BallbarAnswer, options: &TextOptions) -> String {
    let mut table = Table::new(&[
        ("", LEFT),
        ("G", RIGHT),
        ("F min", RIGHT),
        ("F max", RIGHT),
        ("mean", RIGHT),
        ("H", RIGHT),
    ]);
    let sheets = [
        ("", Some(&answer.measured)),
        ("simulated ", answer.simulated.as_ref()),
    ];
    for (name, sheet) in sheets {
        let Some(sheet) = sheet else {
            continue;
        };
        for values in &sheet.senses {
            table.row([
                format!("{name}{}", sense(values.counterclockwise)).into(),
                error(values.g_um).into(),
                error(values.f_um[0]).into(),
                error(values.f_um[1]).into(),
                error(values.mean_um).into(),
                "".into(),
            ]);
        }
        if let (Some(g), Some(d), Some(h)) = (sheet.g_both_um, sheet.d_um, sheet.h_um) {
            table.row([
                format!("{name}both senses").into(),
                error(g).into(),
                "".into(),
                "".into(),
                error(d).into(),
                error(h).into(),
            ]);
        }
    }
    options.table(&table)
}

/// Names, units and values of what explains a sheet.
fn rows(sheet: &BallbarSheet, names: &[String]) -> Vec<(String, &'static str, Option<Explained>)> {
    let mut rows = Vec::new();
    for (name, value) in names.iter().zip(&sheet.lost_motion_um) {
        rows.push((format!("lost motion of {name}"), "um", *value));
    }
    let [first, second] = [0, 1].map(|at| names.get(at).map_or("", String::as_str));
    rows.push((
        format!("servo mismatch, {first} behind {second}"),
        "um",
        sheet.mismatch_um,
    ));
    rows.push((
        format!("squareness, {second} towards {first}"),
        "um/m",
        sheet.squareness_um_m,
    ));
    rows.push((
        format!("scale, {first} longer than {second}"),
        "um/m",
        sheet.scale_um_m,
    ));
    for (name, value) in names.iter().zip(&sheet.center_um) {
        rows.push((format!("centre, {name}"), "um", *value));
    }
    rows
}

fn explained(answer: &BallbarAnswer, names: &[String], options: &TextOptions) -> String {
    let both = answer.simulated.is_some();
    let mut columns = vec![
        ("", LEFT),
        ("value", RIGHT),
        ("from", RIGHT),
        ("to", RIGHT),
        ("unit", LEFT),
    ];
    if both {
        columns.push(("simulated", RIGHT));
    }
    let mut table = Table::new(&columns);
    let simulated = answer.simulated.as_ref().map(|sheet| rows(sheet, names));
    for (place, (name, unit, value)) in rows(&answer.measured, names).into_iter().enumerate() {
        let mut cells = match value {
            Some(Explained {
                value,
                interval: [low, high],
            }) => vec![
                name.into(),
                fixed(value, 2).into(),
                fixed(low, 2).into(),
                fixed(high, 2).into(),
                unit.into(),
            ],
            None => vec![
                name.into(),
                "not told".into(),
                "".into(),
                "".into(),
                unit.into(),
            ],
        };
        if let Some(simulated) = &simulated {
            let other = simulated.get(place).and_then(|(_, _, value)| *value);
            cells.push(
                other
                    .map_or("-".to_owned(), |told| fixed(told.value, 2))
                    .into(),
            );
        }
        table.row(cells);
    }
    options.table(&table)
}

fn reversals(answer: &BallbarAnswer, options: &TextOptions) -> String {
    let mut columns = vec![
        ("axis", LEFT),
        ("deg", RIGHT),
        ("sense", LEFT),
        ("step", RIGHT),
        ("spike", RIGHT),
    ];
    if answer.simulated.is_some() {
        columns.extend([("step simulated", RIGHT), ("spike simulated", RIGHT)]);
    }
    let mut table = Table::new(&columns);
    for mark in &answer.measured.reversals {
        let mut cells = vec![
            mark.axis.to_string().into(),
            fixed(mark.angle_deg, 0).into(),
            sense(mark.counterclockwise).into(),
            error(mark.step_um).into(),
            error(mark.spike_um).into(),
        ];
        if let Some(simulated) = &answer.simulated {
            let other = simulated.reversals.iter().find(|other| {
                other.angle_deg == mark.angle_deg && other.counterclockwise == mark.counterclockwise
            });
            for um in [
                other.map(|other| other.step_um),
                other.map(|other| other.spike_um),
            ] {
                cells.push(um.map_or("-".to_owned(), error).into());
            }
        }
        table.row(cells);
    }
    options.table(&table)
}
