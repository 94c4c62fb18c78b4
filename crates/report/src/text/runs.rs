//! Several runs side by side: one line a run, and their worst blocks.

use super::TextOptions;
use super::parts::{cause, stop_place};
use super::table::{Align, Cell, Table};
use crate::number::{duration, plain};
use crate::runs::{NamedRun, worst, worst_blocks};

/// The whole answer. Ends in a newline.
pub fn runs(runs: &[NamedRun], options: &TextOptions) -> String {
    let mut out = super::parts::count(runs.len() as u64, "run");
    out.push_str(" side by side\n\ncontour error of cutting moves, um\n");
    out.push_str(&table(runs, options));
    let rows = worst_blocks(runs, options.blocks);
    if !rows.is_empty() {
        out.push_str("\nworst blocks, um (- not among the worst of that run)\n");
        let mut columns = vec![("line", Align::Right)];
        columns.extend(runs.iter().map(|named| (named.name.as_str(), Align::Right)));
        columns.push(("block", Align::Left));
        let mut table = Table::new(&columns);
        for row in rows {
            let cell = |um: &Option<f64>| um.map_or(Cell::from("-"), Cell::Error);
            let errors = row.max_um.iter().map(cell);
            let line = std::iter::once(Cell::from(row.line.as_str()));
            table.row(line.chain(errors).chain([row.text.as_str().into()]));
        }
        out.push_str(&options.table(&table));
    }
    out
}

fn table(runs: &[NamedRun], options: &TextOptions) -> String {
    let right = Align::Right;
    let mut table = Table::new(&[
        ("run", Align::Left),
        ("program", Align::Left),
        ("machine", Align::Left),
        ("method", Align::Left),
        ("max", right),
        ("RMS", right),
        ("backlash max", right),
        ("tolerance", right),
        ("time", right),
        ("verdict", Align::Left),
        ("worst", Align::Left),
    ])
    // First to go on a narrow terminal: the worst place, the parts by backlash, program, machine.
    .optional(&[10, 6, 1, 2, 7, 5]);
    for named in runs {
        let (name, run) = (&named.name, &named.run);
        let Some(result) = named.main() else {
            continue;
        };
        let verdict = match &result.stop {
            Some(stop) => format!("stops {}", stop_place(stop)),
            None if result.within_tolerance => "within".to_owned(),
            None => "outside".to_owned(),
        };
        let place = worst(result).map_or(String::new(), |block| {
            let line = super::parts::line(&block.block);
            format!("line {line}, {}", cause(block.cause))
        });
        table.row([
            name.as_str().into(),
            run.program.name.as_str().into(),
            run.machine.as_str().into(),
            result.method.as_str().into(),
            Cell::Error(result.cutting.max),
            Cell::Error(result.cutting.rms),
            Cell::Error(result.backlash.max),
            plain(run.tolerance_um).into(),
            duration(run.plan.duration_s).into(),
            verdict.into(),
            place.into(),
        ]);
    }
    options.table(&table)
}
