//! Cells on all cores, results by index.

use super::cell::{Bench, Trace};
use super::factor::{Cell, FEED, SHAPE};
use super::result::CellResult;
use super::{machine, motion};
use crate::error::StudyError;
use lostmotion_methods::AxisConfig;
use lostmotion_sim::{Program, Simulation};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

/// Runs a cell with `none` and these methods. `trace` sees every servo tick of the last of them.
///
/// # Errors
/// An unknown method; whatever stops the chain.
pub fn run_cell(
    cell: &Cell,
    methods: &[String],
    trace: Option<&mut Trace<'_>>,
) -> Result<CellResult, StudyError> {
    let inside = |source| StudyError::Cell {
        id: cell.to_string(),
        source: Box::new(source),
    };
    run(cell, methods, trace).map_err(inside)
}

fn run(
    cell: &Cell,
    methods: &[String],
    trace: Option<&mut Trace<'_>>,
) -> Result<CellResult, StudyError> {
    let machine = machine::machine(cell)?;
    let program = Program::from_str(cell.to_string(), motion::program(cell));
    // The drift lasts as long as the motion: plan once for its length, then run.
    let length = Simulation::new(&program, &machine).plan(&mut |_, _| Ok(()))?;
    let mut config = AxisConfig {
        drift: machine::drift(cell, length.duration_s),
        ..machine::axis(cell)?
    };
    // The estimator changes no bit of the motion; it only costs time.
    config.compensation.estimate_shaft = trace.is_some();
    let machine = machine::of_cell(&machine, &config);
    let mut bench = Bench::new(cell, &config, methods, trace);
    Simulation::new(&program, &machine)
        .methods(bench.names())
        .ticks(true, &mut bench)?;
    Ok(bench.finish())
}

/// How far a study is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Cells finished.
    pub done: usize,
    /// Cells in all.
    pub all: usize,
    /// Machine time simulated, s.
    pub simulated_s: f64,
}

/// Runs cells, each with `none` and these methods, on a number of threads (0: one per core). `sink`
/// takes each result as it is finished, in no particular order; the results come back in the order
/// of the cells, the same to the bit for any number of threads.
///
/// # Errors
/// The first cell in order that cannot be run; whatever the sink answers. Cells that are finished
/// have gone to the sink.
pub fn run_cells(
    cells: &[Cell],
    methods: &[String],
    threads: usize,
    sink: &mut dyn FnMut(&CellResult, Progress) -> Result<(), StudyError>,
) -> Result<Vec<CellResult>, StudyError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|why| StudyError::Threads {
        threads,
        why: why.to_string(),
    })?;
    let mut order: Vec<usize> = (0..cells.len()).collect();
    // Longest processing time first, so that no core idles at the end.
    order.sort_by(|a, b| f64::total_cmp(&length(cells.get(*b)), &length(cells.get(*a))));
    let stop = AtomicBool::new(false);
    let mut results: Vec<Option<Result<CellResult, StudyError>>> =
        cells.iter().map(|_| None).collect();
    let mut sunk = Ok(());
    let (sender, receiver) = mpsc::channel();
    pool.in_place_scope_fifo(|scope| {
        for index in order {
            let (sender, stop) = (sender.clone(), &stop);
            let Some(cell) = cells.get(index) else {
                continue;
            };
            scope.spawn_fifo(move |_| {
                if !stop.load(Ordering::Relaxed) {
                    // The receiver outlives all senders.
                    let _ = sender.send((index, run_cell(cell, methods, None)));
                }
            });
        }
        drop(sender);
        let mut progress = Progress {
            all: cells.len(),
            ..Progress::default()
        };
        // Results go to the sink on this thread, in the order in which they are finished.
        for (index, result) in receiver {
            progress.done += 1;
            match &result {
                Ok(result) => {
                    progress.simulated_s += result.duration_s;
                    sunk =
                        std::mem::replace(&mut sunk, Ok(())).and_then(|()| sink(result, progress));
                }
                Err(_) => stop.store(true, Ordering::Relaxed),
            }
            if sunk.is_err() {
                stop.store(true, Ordering::Relaxed);
            }
            // By index: the order of the results does not depend on the threads.
            if let Some(place) = results.get_mut(index) {
                *place = Some(result);
            }
        }
    });
    sunk?;
    let mut finished = Vec::with_capacity(cells.len());
    for result in results.into_iter().flatten() {
        finished.push(result?);
    }
    Ok(finished)
}

/// A measure of how long a cell runs: the size of its figure over its feed. Figures without a size
/// in their name, and small circles, count as 20 mm.
fn length(cell: Option<&Cell>) -> f64 {
    cell.map_or(0.0, |cell| {
        cell.number(SHAPE).max(20.0) / cell.number(FEED).max(1.0)
    })
}
