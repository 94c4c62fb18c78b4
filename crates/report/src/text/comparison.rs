//! The answer of `compare`: one line a method.

use super::parts::{program, stop_place, stop_reason, warnings};
use super::table::{Align, Cell, Table};
use super::{Ink, TextOptions, needs};
use crate::number::{error, fixed, percent, plain};
use lostmotion_methods::{MethodId, Misled};
use lostmotion_sim::results::{Harm, MethodResult, Run, Trust};

/// Most warnings shown, a choice; the JSON form has all of them.
const MOST_WARNINGS: usize = 3;

/// The whole answer: one line a method, the recommendation, harm, notes. Ends in a newline.
pub fn comparison(comparison: &Run, options: &TextOptions) -> String {
    // Ratios and harm refer to `none`; a comparison need not have it.
    let none = comparison.results.iter().find(|r| r.is_baseline());
    let mut out = format!(
        "{} on {}, tolerance {} um: {} on one plan\n",
        comparison.program.name,
        comparison.machine,
        plain(comparison.tolerance_um),
        super::parts::count(comparison.results.len() as u64, "method"),
    );
    out.push_str(&program(&comparison.program, &comparison.plan));
    out.push_str(&warnings(&comparison.program, MOST_WARNINGS));
    out.push_str("\ncontour error of cutting moves, um\n");
    out.push_str(&table(comparison, none, options));
    if options.sensitivity {
        out.push_str(&misled(
            &comparison.results,
            comparison.tolerance_um,
            options,
        ));
    }
    out.push('\n');
    out.push_str(&recommendation(comparison, options));
    if let Some(trust) = &comparison.trust {
        out.push_str(&format!("{}\n", what_it_takes(trust)));
    }
    for result in &comparison.results {
        out.push_str(&stop_line(result, options));
        out.push_str(&reason_line(result, none, options));
    }
    for result in &comparison.results {
        for note in &result.notes {
            out.push_str(&format!("{}: {note}\n", result.method));
        }
    }
    out
}

fn table(comparison: &Run, none: Option<&MethodResult>, options: &TextOptions) -> String {
    let right = Align::Right;
    let mut table = Table::new(&[
        ("method", Align::Left),
        ("max", right),
        ("RMS", right),
        ("p99", right),
        ("backlash max", right),
        ("backlash RMS", right),
        ("of none", right),
        ("verdict", Align::Left),
        ("needs", Align::Left),
    ])
    // First to go on a narrow terminal: p99, needs, maximum and RMS, ratio to `none`.
    .optional(&[3, 8, 4, 2, 6]);
    for result in &comparison.results {
        if let Some(stop) = &result.stop {
            // Figures of a part of the program would be held against those of the whole.
            let verdict = format!("stops {}", stop_place(stop));
            let dashes = std::iter::repeat_n(Cell::from("-"), 6);
            table.row(
                std::iter::once(result.method.as_str().into())
                    .chain(dashes)
                    .chain([verdict.into(), needs(&result.method).into()]),
            );
            continue;
        }
        // Of what no compensation leaves; without backlash there is nothing to compare with.
        let ratio = none
            .filter(|n| n.backlash.rms > 0.0 && n.stop.is_none())
            .map_or("-".to_owned(), |n| {
                percent(result.backlash.rms / n.backlash.rms)
            });
        let inside = if result.within_tolerance {
            "within"
        } else {
            "outside"
        };
        let worse = match none.and_then(|n| result.harm(n)) {
            Some(Harm::Rms(_)) => ", worse than none",
            Some(Harm::Peak(_)) => ", higher peak",
            None => "",
        };
        table.row([
            result.method.as_str().into(),
            Cell::Error(result.cutting.max),
            Cell::Error(result.cutting.rms),
            Cell::Error(result.cutting.p99),
            Cell::Error(result.backlash.max),
            Cell::Error(result.backlash.rms),
            ratio.into(),
            format!("{inside}{worse}").into(),
            needs(&result.method).into(),
        ]);
    }
    // Beside them the machine without a gap: command and servo alone.
    let free = &comparison.without_gap;
    table.row([
        "(no gap)".into(),
        Cell::Error(free.max),
        Cell::Error(free.rms),
        Cell::Error(free.p99),
        "-".into(),
        "-".into(),
        "-".into(),
        if free.max <= comparison.tolerance_um {
            "within"
        } else {
            "outside"
        }
        .into(),
        "-".into(),
    ]);
    options.table(&table)
}

fn recommendation(comparison: &Run, options: &TextOptions) -> String {
    let how = tested(&comparison.results);
    // The run recommends among the methods that need no scale on the load; `none` may be the best.
    match &comparison.recommended {
        Some(name) if name == MethodId::NONE.name() => {
            let text = "none: no method compared is safe to improve on doing nothing";
            format!("{} {text}{how}\n", options.paint(Ink::Good, "recommended:"))
        }
        Some(name) => format!("{} {name}{how}\n", options.paint(Ink::Good, "recommended:")),
        None if comparison.results.iter().all(|r| r.stop.is_some()) => {
            "recommended: no method; the machine stops with each of those compared\n".to_owned()
        }
        None => "recommended: no method; the reasons follow\n".to_owned(),
    }
}

/// What it would take to recommend another method: `lookup would be recommended if the gap were known within 15 %`.
pub(crate) fn what_it_takes(trust: &Trust) -> String {
    let names: Vec<&str> = trust.told.iter().map(|told| told.name()).collect();
    let known = format!(
        "{} {} known within",
        names.join(" and "),
        if names.len() == 1 {
            "were"
        } else {
            "both were"
        }
    );
    let method = &trust.method;
    match trust.within {
        Some(share) => format!(
            "{method} would be recommended if the {known} {}",
            percent(share)
        ),
        None => format!(
            "{method} is best where all is told right, but would not be safe even if the {known} {}",
            percent(trust.least)
        ),
    }
}

/// What the recommendation was tested with.
pub(crate) fn tested(results: &[MethodResult]) -> String {
    let factors = results.iter().flat_map(|result| &result.misled);
    let share = factors
        .map(|run| run.misled.factor - 1.0)
        .fold(0.0, f64::max);
    if share > 0.0 {
        format!(
            " (tested with gap, friction and stiffness told {} too small and too large)",
            percent(share)
        )
    } else {
        String::new()
    }
}

/// Says where and why the machine stops with a method, if it does.
fn stop_line(result: &MethodResult, options: &TextOptions) -> String {
    let Some(stop) = &result.stop else {
        return String::new();
    };
    let name = options.paint(Ink::Bad, &result.method);
    format!(
        "{name}: the machine stops {}: {}\n",
        stop_place(stop),
        stop_reason(stop)
    )
}

/// Says plainly why a method is not recommended, and else what its verdict only hints at; a larger
/// RMS is among the run's own notes.
fn reason_line(
    result: &MethodResult,
    none: Option<&MethodResult>,
    options: &TextOptions,
) -> String {
    let name = options.paint(Ink::Bad, &result.method);
    // The table says what a method needs.
    let needs_scale = result
        .method
        .parse()
        .is_ok_and(|method: MethodId| method.needs_load_scale());
    match &result.not_recommended {
        Some(reason) if !needs_scale && result.stop.is_none() => {
            return format!("{name}: not recommended: {reason}\n");
        }
        _ => {}
    }
    let Some((none, Harm::Peak(ratio))) = none.and_then(|n| result.harm(n).map(|h| (n, h))) else {
        return String::new();
    };
    let [with, without] = [result, none].map(|r| error(r.backlash.max));
    format!(
        "{name}: higher peak than none: backlash max {with} um against {without} um, {ratio:.2} times\n"
    )
}

/// What is told, by which factor: two decimals, or as many as tell it from the truth.
fn told(misled: Misled) -> String {
    let short = fixed(misled.factor, 2);
    let exact = plain(misled.factor);
    let factor = if exact.len() > short.len() {
        exact
    } else {
        short
    };
    format!("{} x {factor}", misled.what.name())
}

/// How the methods do whose drives are told their axes wrong.
pub(super) fn misled(results: &[MethodResult], tolerance_um: f64, options: &TextOptions) -> String {
    let right = Align::Right;
    let mut table = Table::new(&[
        ("method, and told", Align::Left),
        ("max", right),
        ("RMS", right),
        ("backlash max", right),
        ("backlash RMS", right),
        ("verdict", Align::Left),
    ]);
    let verdict = |max: f64| {
        if max <= tolerance_um {
            "within"
        } else {
            "outside"
        }
    };
    let tried = results.iter().filter(|result| !result.misled.is_empty());
    for result in tried.clone() {
        table.row([
            result.method.as_str().into(),
            Cell::Error(result.cutting.max),
            Cell::Error(result.cutting.rms),
            Cell::Error(result.backlash.max),
            Cell::Error(result.backlash.rms),
            verdict(result.cutting.max).into(),
        ]);
        for run in &result.misled {
            table.row([
                format!("  {}", told(run.misled)).into(),
                Cell::Error(run.cutting.max),
                Cell::Error(run.cutting.rms),
                Cell::Error(run.backlash.max),
                Cell::Error(run.backlash.rms),
                if run.stops {
                    "stops"
                } else {
                    verdict(run.cutting.max)
                }
                .into(),
            ]);
        }
    }
    if tried.count() == 0 {
        return "\nno method compared is told gap, friction or stiffness\n".to_owned();
    }
    format!(
        "\ncontour error of cutting moves where the drives are told their axes wrong, um\n{}",
        options.table(&table)
    )
}
