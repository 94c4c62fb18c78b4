//! Every cell with its limits beside what the methods that need no scale leave.

use super::result::CellResult;
use super::table::capped;
use lostmotion_report::number::fixed;
use std::fmt::Write;

/// Methods shown, where they have been run: told everything, and told nothing.
const SHOWN: [&str; 2] = ["lookup", "adaptive"];

/// Appends the table.
pub(super) fn markdown(out: &mut String, results: &[CellResult]) {
    let ran = |name: &&&str| results.first().is_some_and(|cell| cell.of(name).is_some());
    let shown: Vec<&str> = SHOWN.iter().filter(ran).copied().collect();
    out.push_str(
        "\n## Each cell with its limits\n\nTraverse: the shortest one with all of the drive's torque. Least: what that leaves. Count: of the encoder. Practical: the practical limit (RMS / largest, of `none`). \
         **Bold**: within.\n\n| cell | `none`: RMS, um | max, um | traverse, ms | least: RMS, um | max, um | count, um | practical |",
    );
    shown.iter().for_each(|name| {
        let _ = write!(out, " `{name}` |");
    });
    out.push_str("\n|---|--:|--:|--:|--:|--:|--:|--:|");
    out.push_str(&"--:|".repeat(shown.len()));
    out.push('\n');
    for cell in results {
        row(out, cell, &shown);
    }
}

fn row(out: &mut String, cell: &CellResult, shown: &[&str]) {
    let [rms, max] = cell
        .of("none")
        .map_or([f64::NAN; 2], |none| [none.rms_um, none.max_um]);
    let _ = write!(
        out,
        "| `{}` | {} | {} | {} |",
        cell.cell,
        fixed(rms, 2),
        fixed(max, 2),
        fixed(cell.traverse_ms, 2)
    );
    let _ = write!(
        out,
        " {} | {} | {} |",
        fixed(cell.limit_rms_um, 4),
        fixed(cell.limit_max_um, 3),
        fixed(cell.encoder_um, 4)
    );
    let pair = |[rms, max]: [f64; 2]| format!("{} / {}", capped(rms), capped(max));
    let _ = write!(out, " {} |", cell.practical().map_or("-".to_owned(), pair));
    for name in shown {
        let Some(ratios) = cell.ratios(name) else {
            out.push_str(" - |");
            continue;
        };
        let mark = |inside: bool| if inside { "**" } else { "" };
        let [rms, max] = cell.within(name).unwrap_or_default().map(mark);
        let _ = write!(
            out,
            " {rms}{}{rms} / {max}{}{max} |",
            capped(ratios[0]),
            capped(ratios[1])
        );
    }
    out.push('\n');
}
