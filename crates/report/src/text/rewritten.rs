//! A program that was rewritten, as text.

use super::TextOptions;
use super::parts::count;
use super::table::{Align, Cell, Table};
use crate::number::{duration_in_place, error, percent, plain};
use lostmotion_sim::rewrite::results::{Leaves, Rewritten};

/// The whole answer: what was written, what is left, what it costs. `name` is that of the new file.
/// Ends in a newline.
pub fn rewritten(name: &str, answer: &Rewritten, options: &TextOptions) -> String {
    let mut out = format!(
        "{} on {}, tolerance {} um\n",
        answer.program,
        answer.machine,
        plain(answer.tolerance_um)
    );
    out.push_str(&match &answer.refused {
        Some(reason) => format!("nothing is written: {reason}\n"),
        None => format!(
            "{name} is written, {}: RMS {} um in place of {}, at most {} um in place of {}\n",
            if answer.is_within_tolerance() {
                "within tolerance"
            } else {
                "OUTSIDE tolerance"
            },
            error(answer.after.rms_um),
            error(answer.before.rms_um),
            error(answer.after.max_um),
            error(answer.before.max_um)
        ),
    });
    let [x, y, z] = answer.shift_mm.map(|shift| error(shift * 1e3));
    out.push_str(&format!(
        "end points are moved by up to {x} um in X, {y} in Y, {z} in Z; {} taken up in the air, {} within cuts, {} cut at reversals\n",
        count(answer.in_the_air, "gap"),
        answer.within_cuts,
        count(answer.arcs_split, "arc")
    ));
    if answer.sides_unknown > 0 {
        out.push_str(&format!(
            "{} from a side that is not known: before, the tool was nowhere known to be above all cuts\n",
            count(answer.sides_unknown, "first cut")
        ));
    }
    if answer.normal_um > 0.0 {
        out.push_str(&format!(
            "and by up to {} um along the normal, against what friction and servo leave\n",
            error(answer.normal_um)
        ));
    }
    out.push_str(&format!(
        "duration {}\n",
        duration_in_place(answer.time_after_s, answer.time_before_s)
    ));
    out.push_str("\ntool off the contour of the original while it cuts, um\n");
    let mut table = Table::new(&[
        ("", Align::Left),
        ("max", Align::Right),
        ("RMS", Align::Right),
    ]);
    let mut row = |what: String, leaves: &Leaves| {
        table.row([
            what.into(),
            Cell::Error(leaves.max_um),
            Cell::Error(leaves.rms_um),
        ]);
    };
    row("original".to_owned(), &answer.before);
    row("rewritten".to_owned(), &answer.after);
    for end in &answer.uncertain {
        let [x, y, z] = end.factors.map(percent);
        let gap = if x == y && y == z {
            x
        } else {
            format!("X {x} Y {y} Z {z}")
        };
        row(format!("true gaps {gap}, original"), &end.before);
        row(format!("true gaps {gap}, rewritten"), &end.after);
    }
    out.push_str(&options.table(&table));
    if !answer.is_uncertainty_told {
        let is_of_all = answer.uncertain.iter().all(|end| {
            let [x, y, z] = end.factors;
            x == y && y == z
        });
        let of_axes = if is_of_all {
            String::new()
        } else {
            format!(" of {}", answer.untold.join(", "))
        };
        out.push_str(&format!(
            "how well the gaps{of_axes} are known is not told (`compensation.gap_uncertainty`, or --gap-uncertainty PERCENT): 30 % are taken\n"
        ));
    }
    out
}
