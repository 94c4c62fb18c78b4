//! Cells on all cores.

use crate::cell::{CellResult, Outcome, run_cell};
use crate::error::SweepError;
use crate::inputs::Inputs;
use crate::manifest::Cell;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::sync_channel;
use std::sync::{Mutex, PoisonError};

/// Results that may wait to be written, for each thread: a slow disk slows the threads down before
/// it fills the memory.
const WAITING: usize = 16;

/// How far a run is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SweepProgress {
    /// Cells finished.
    pub done: usize,
    /// Cells in all.
    pub all: usize,
    /// Cells that could not be run.
    pub failed: usize,
    /// Machine time simulated, s.
    pub simulated_s: f64,
}

impl SweepProgress {
    fn count(&mut self, result: &CellResult) {
        self.done += 1;
        match &result.outcome {
            Outcome::Figures(figures) => {
                self.simulated_s += figures.duration_s.unwrap_or_default();
            }
            Outcome::Error(_) => self.failed += 1,
        }
    }
}

/// Runs `count` cells on a number of threads (0: one per core) until all are done or `stop` is set; cells in
/// flight are finished then. `sink` takes each result as it is finished, in no particular order, on
/// the caller's thread.
///
/// # Errors
/// A program or manifest that cannot be read any more; whatever the sink answers. No further cell
/// begins then.
pub fn run_cells(
    inputs: &Inputs,
    (cells, count): (impl Iterator<Item = Result<Cell, SweepError>> + Send, usize),
    threads: usize,
    stop: &AtomicBool,
    sink: &mut dyn FnMut(&CellResult, SweepProgress) -> Result<(), SweepError>,
) -> Result<SweepProgress, SweepError> {
    let cores = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let threads = if threads == 0 { cores() } else { threads }.min(count.max(1));
    let (cells, ended) = (Mutex::new(cells), AtomicBool::new(false));
    let mut progress = SweepProgress {
        all: count,
        ..SweepProgress::default()
    };
    let mut sunk = Ok(());
    std::thread::scope(|scope| {
        let (sender, receiver) = sync_channel(threads * WAITING);
        for _ in 0..threads {
            let (sender, cells, ended) = (sender.clone(), &cells, &ended);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) && !ended.load(Ordering::Relaxed) {
                    // Whoever is free takes the next cell.
                    let next = cells.lock().unwrap_or_else(PoisonError::into_inner).next();
                    let Some(cell) = next else { break };
                    // The receiver outlives all senders.
                    let _ = sender.send(cell.and_then(|cell| run_cell(inputs, &cell)));
                }
            });
        }
        drop(sender);
        for result in receiver {
            // After the first fault what else was in flight is let go: it runs again.
            if sunk.is_err() {
                continue;
            }
            sunk = result.and_then(|result| {
                progress.count(&result);
                sink(&result, progress)
            });
            ended.store(sunk.is_err(), Ordering::Relaxed);
        }
    });
    sunk.map(|()| progress)
}
