//! The settings of a control, as text.

use super::TextOptions;
use super::comparison::what_it_takes;
use super::parts::count;
use super::table::{Align, Cell, Table};
use crate::number::{error, percent, plain};
use lostmotion_sim::recommend::results::ControlSettings;
use lostmotion_sim::results::ErrorStats;

/// The whole answer: verdict, what to paste, what it asks for, and what is left. Ends in a newline.
pub fn control_settings(answer: &ControlSettings, options: &TextOptions) -> String {
    let mut out = format!(
        "{} on {}, control {}, tolerance {} um\n",
        answer.program,
        answer.machine,
        answer.control,
        plain(answer.tolerance_um)
    );
    out.push_str(&verdict(answer));
    if !answer.paste.is_empty() {
        out.push_str("\nset\n");
        for line in &answer.paste {
            out.push_str(&format!("    {line}\n"));
        }
    }
    if !answer.settings.is_empty() {
        out.push('\n');
        out.push_str(&settings(answer, options));
        out.push_str(&format!("source: {}\n", answer.source));
    }
    if !answer.preconditions.is_empty() {
        out.push_str("\nneeded for it\n");
        for text in &answer.preconditions {
            out.push_str(&format!("  - {text}\n"));
        }
    }
    out.push_str("\ncontour error of cutting moves, um\n");
    out.push_str(&errors(answer, options));
    if answer.method.is_some() && answer.uncertain.is_empty() {
        out.push_str(match answer.gap_uncertainty {
            Some(_) => "the gap is told to be exact: no interval\n",
            None => "how well the gap is known is not told (`compensation.gap_uncertainty`, or --gap-uncertainty PERCENT): no interval\n",
        });
    }
    if let Some(trust) = &answer.trust {
        out.push_str(&format!("{}\n", what_it_takes(trust)));
    }
    for note in &answer.notes {
        out.push_str(&format!("note: {note}\n"));
    }
    out.push_str(&format!(
        "{} of the program\n",
        count(answer.runs, "simulation")
    ));
    out
}

fn verdict(answer: &ControlSettings) -> String {
    if let Some(reason) = &answer.refused {
        return format!("nothing to set: {reason}\n");
    }
    let inside = if answer.within_tolerance {
        "within tolerance"
    } else {
        "OUTSIDE tolerance"
    };
    let amount = match answer.chosen.as_str() {
        "" => String::new(),
        chosen => format!(" ({chosen}, sought by simulation)"),
    };
    format!(
        "{inside} with {}{amount}: RMS {} um in place of {}, at most {} um in place of {}\n",
        answer.method.as_deref().unwrap_or("-"),
        error(answer.after.rms),
        error(answer.before.rms),
        error(answer.after.max),
        error(answer.before.max)
    )
}

fn settings(answer: &ControlSettings, options: &TextOptions) -> String {
    let mut table = Table::new(&[
        ("parameter", Align::Left),
        ("axis", Align::Left),
        ("value", Align::Right),
        ("unit", Align::Left),
        ("what it does", Align::Left),
    ])
    .optional(&[4]);
    for setting in &answer.settings {
        let axis = if setting.axis.is_empty() {
            "all"
        } else {
            &setting.axis
        };
        table.row([
            setting.name.as_str().into(),
            axis.into(),
            setting.value.as_str().into(),
            setting.unit.as_str().into(),
            setting.meaning.as_str().into(),
        ]);
    }
    options.table(&table)
}

/// Before, after, at the ends of the gap's interval, told wrong, and what others would leave.
fn errors(answer: &ControlSettings, options: &TextOptions) -> String {
    let mut table = Table::new(&[
        ("", Align::Left),
        ("max", Align::Right),
        ("RMS", Align::Right),
        ("verdict", Align::Left),
    ]);
    let mut row = |what: String, errors: &ErrorStats, stops: bool| {
        let verdict = match (stops, errors.max <= answer.tolerance_um) {
            (true, _) => "stops",
            (false, true) => "within",
            (false, false) => "outside",
        };
        table.row([
            what.into(),
            Cell::Error(errors.max),
            Cell::Error(errors.rms),
            verdict.into(),
        ]);
    };
    row("without compensation".to_owned(), &answer.before, false);
    if answer.after.samples > 0 {
        row("as set".to_owned(), &answer.after, false);
    }
    for end in &answer.uncertain {
        let gap = percent(end.factor);
        row(format!("true gap {gap}, without"), &end.before, false);
        row(format!("true gap {gap}, as set"), &end.after, end.stops);
    }
    for wrong in &answer.wrong {
        let told = percent((wrong.misled.factor - 1.0).abs());
        let side = if wrong.misled.factor > 1.0 {
            "large"
        } else {
            "small"
        };
        let what = format!("{} told {told} too {side}", wrong.misled.what.name());
        row(what, &wrong.cutting, wrong.stops);
    }
    for better in &answer.better {
        let what = format!("a control with {}", better.method);
        row(what, &better.cutting, better.stops);
    }
    row(
        "a machine without a gap".to_owned(),
        &answer.without_gap,
        false,
    );
    options.table(&table)
}
