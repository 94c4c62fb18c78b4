//! The answer of `simulate`.

use super::parts::{program, stats_row, stats_table, stop_place, stop_reason, warnings};
use super::{Ink, TextOptions, blocks, comparison};
use crate::number::{error, plain};
use lostmotion_sim::results::SingleRun;

/// Most warnings shown, a choice; the JSON form has all of them.
const MOST_WARNINGS: usize = 10;

/// The whole answer: verdict, errors, worst blocks, axes, reversals, notes. Ends in a newline.
pub fn simulation(simulation: &SingleRun, options: &TextOptions) -> String {
    let mut out = verdict(simulation, options);
    out.push_str(&program(&simulation.program, &simulation.plan));
    out.push_str(&warnings(&simulation.program, MOST_WARNINGS));
    out.push('\n');
    out.push_str(&errors(simulation, options));
    let result = &simulation.result;
    // The run has sorted them, worst first.
    let worst = &result.worst_blocks[..result.worst_blocks.len().min(options.blocks)];
    if !worst.is_empty() {
        out.push_str("\nworst blocks, um (positive: left of the direction of travel)\n");
        out.push_str(&blocks::worst_blocks(worst, options));
    }
    if !result.axes.is_empty() {
        out.push_str("\naxes\n");
        out.push_str(&blocks::axes(&result.axes, options));
    }
    if let Some(gantry) = &result.gantry {
        out.push_str(&blocks::gantry(gantry));
    }
    let reversals = &result.reversals[..result.reversals.len().min(options.reversals)];
    if !reversals.is_empty() {
        out.push_str(&format!(
            "\nreversals, um (worst {} of {})\n",
            reversals.len(),
            result.reversal_count
        ));
        out.push_str(&blocks::reversals(reversals, options));
    }
    if options.sensitivity {
        out.push_str(&comparison::misled(
            std::slice::from_ref(result),
            simulation.tolerance_um,
            options,
        ));
    }
    if !result.notes.is_empty() {
        out.push_str("\nnotes\n");
        for note in &result.notes {
            out.push_str(&format!("- {note}\n"));
        }
    }
    out
}

/// The first lines: inside or outside, by how much, where and why; before that where and why the
/// machine stops, if it does.
fn verdict(simulation: &SingleRun, options: &TextOptions) -> String {
    let result = &simulation.result;
    let (ink, word) = if result.within_tolerance {
        (Ink::Good, "within tolerance")
    } else {
        (Ink::Bad, "OUTSIDE tolerance")
    };
    let who = format!(
        "{} on {}, method {}",
        simulation.program.name, simulation.machine, result.method
    );
    // Without a cutting move there is no contour to judge.
    let what = if result.cutting.samples == 0 {
        "no cutting move".to_owned()
    } else {
        // The verdict is about cutting moves: rapids have no tolerance.
        let place = result
            .worst_blocks
            .iter()
            .find(|block| !block.rapid)
            .map(|b| {
                format!(
                    " in line {} ({})",
                    super::parts::line(&b.block),
                    super::parts::cause(b.cause)
                )
            })
            .unwrap_or_default();
        format!(
            "largest contour error {} um{place}, tolerance {} um",
            error(result.cutting.max),
            plain(simulation.tolerance_um)
        )
    };
    let Some(stop) = &result.stop else {
        return format!("{who}\n{}: {what}\n\n", options.paint(ink, word));
    };
    let stops = options.paint(Ink::Bad, "the machine stops");
    format!(
        "{who}\n{stops} {}: {}\nup to there: {what}\n\n",
        stop_place(stop),
        stop_reason(stop)
    )
}

/// The table of contour errors.
fn errors(simulation: &SingleRun, options: &TextOptions) -> String {
    let result = &simulation.result;
    let mut table = stats_table("contour error, um");
    // The whole error first, then what the gap adds, what is left without it, and the part of the
    // command itself.
    stats_row(&mut table, "cutting moves", &result.cutting);
    stats_row(&mut table, "  caused by backlash", &result.backlash);
    stats_row(
        &mut table,
        "  same machine without gap",
        &simulation.without_gap,
    );
    stats_row(
        &mut table,
        "  command itself (blending)",
        &simulation.plan.command,
    );
    stats_row(&mut table, "rapids", &result.rapid);
    let mut out = options.table(&table);
    if let Some(orientation) = &result.orientation_mdeg {
        let mut table = stats_table("tool axis, mdeg");
        stats_row(&mut table, "cutting moves", orientation);
        out.push_str(&options.table(&table));
    }
    out
}
