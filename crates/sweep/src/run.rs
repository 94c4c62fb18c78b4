//! Cells on all cores.

use crate::cell::{CellResult, Outcome, run_cell};
use crate::error::SweepError;
use crate::inputs::Inputs;
use crate::key::Key;
use crate::manifest::{Cell, Manifest};
use std::collections::HashSet;
use std::num::NonZeroUsize;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::sync_channel;

/// Results that may wait to be written, for each thread: a slow disk slows the threads down before
/// it fills the memory.
const WAITING: usize = 16;

/// A part of a sweep: cell `i` of every `n`, so that each has a like share of every program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which, from 1.
    pub index: usize,
    /// Of how many.
    pub count: usize,
}

impl Shard {
    /// The whole sweep.
    pub const WHOLE: Shard = Shard { index: 1, count: 1 };
}

impl std::str::FromStr for Shard {
    type Err = String;

    /// `3/8` is the third of eight.
    ///
    /// ```
    /// use lostmotion_sweep::run::Shard;
    ///
    /// assert_eq!("3/8".parse(), Ok(Shard { index: 3, count: 8 }));
    /// assert!("0/8".parse::<Shard>().is_err() && "9/8".parse::<Shard>().is_err());
    /// ```
    fn from_str(text: &str) -> Result<Shard, String> {
        let number = |text: &str| text.trim().parse::<usize>().ok();
        let pair = text.split_once('/');
        pair.and_then(|(index, count)| number(index).zip(number(count)))
            .filter(|(index, count)| (1..=*count).contains(index))
            .map(|(index, count)| Shard { index, count })
            .ok_or_else(|| {
                format!("`{text}` is not of the form I/N, with I from 1 to N; for example 3/8")
            })
    }
}

/// The cells of a shard that are not done yet, each key once.
pub fn missing<'m>(manifest: &'m Manifest, shard: Shard, done: &HashSet<Key>) -> Vec<&'m Cell> {
    let mut seen = HashSet::new();
    let of_shard = manifest
        .cells
        .iter()
        .skip(shard.index - 1)
        .step_by(shard.count);
    of_shard
        .filter(|cell| !done.contains(&cell.key) && seen.insert(cell.key))
        .collect()
}

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

/// Runs cells on a number of threads (0: one per core) until all are done or `stop` is set; cells in
/// flight are finished then. `sink` takes each result as it is finished, in no particular order, on
/// the caller's thread.
///
/// # Errors
/// A program that cannot be read any more; whatever the sink answers. No further cell begins then.
pub fn run_cells(
    inputs: &Inputs,
    cells: &[&Cell],
    threads: usize,
    stop: &AtomicBool,
    sink: &mut dyn FnMut(&CellResult, SweepProgress) -> Result<(), SweepError>,
) -> Result<SweepProgress, SweepError> {
    let cores = || std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    let threads = if threads == 0 { cores() } else { threads }.min(cells.len().max(1));
    let (next, ended) = (AtomicUsize::new(0), AtomicBool::new(false));
    let mut progress = SweepProgress {
        all: cells.len(),
        ..SweepProgress::default()
    };
    let mut sunk = Ok(());
    std::thread::scope(|scope| {
        let (sender, receiver) = sync_channel(threads * WAITING);
        for _ in 0..threads {
            let (sender, next, ended) = (sender.clone(), &next, &ended);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) && !ended.load(Ordering::Relaxed) {
                    // Whoever is free takes the next cell.
                    let Some(cell) = cells.get(next.fetch_add(1, Ordering::Relaxed)) else {
                        break;
                    };
                    // The receiver outlives all senders.
                    let _ = sender.send(run_cell(inputs, cell));
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
