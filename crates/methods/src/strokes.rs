//! Strokes that were run, with what was learned for each: a bounded memory for
//! `iterative-learning`.
//!
//! A stroke goes from one reversal of the reference to the next. It is recognised by its beginning
//! (position, acceleration and direction), and counts as the same as long as its reference stays on
//! the stored one. The least recently used stroke is dropped when the memory is full.
//!
//! ```text
//! u(n) <- Q (u(n) + gamma e(n + lead))       n: cell of 1 ms; u: correction, e: error of the load, rad
//! ```

use serde::{Deserialize, Serialize};

/// Cells of the shortest stroke that is stored: 20 ms. A choice: shorter ones would fill the memory
/// with what is hardly corrected.
const SHORTEST_STROKE_CELLS: usize = 20;
/// Memory that a stroke takes besides its cells, in cells.
const OVERHEAD_CELLS: usize = 8;
/// Cells of a page: no more than the overhead, so that what is counted has room.
const PAGE_CELLS: usize = OVERHEAD_CELLS;
/// Largest distance between two references that count as the same, rad at the motor: 1.6 um on a
/// screw of 20 mm. A choice: above the rounding of setpoints, below a gap worth correcting.
const SAME_WITHIN_RAD: f64 = 5e-4;
/// What is added to it, as a part of the way since the reversal. A choice: 0.01 mm in 100 mm.
const SAME_WITHIN_SHARE: f64 = 1e-4;
/// Largest difference of the accelerations at the reversals of two strokes that begin alike, as a
/// part of the larger. A choice: narrower stores one stroke twice, wider applies a correction to
/// another stroke.
const SAME_ACCELERATION_SHARE: f64 = 0.02;
/// RMS error over that of the first run from which on a correction is dropped. A choice: lower
/// would drop good corrections for the scatter from run to run.
const HARMFUL_RATIO: f64 = 1.1;

/// How a stroke begins: position (rad), acceleration (rad/s2) and direction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Beginning {
    pub(super) position: f64,
    pub(super) acceleration: f64,
    pub(super) direction: i8,
}

impl Beginning {
    fn is_like(&self, other: &Beginning) -> bool {
        let larger = self.acceleration.abs().max(other.acceleration.abs());
        self.direction == other.direction
            && (self.position - other.position).abs() <= SAME_WITHIN_RAD
            && (self.acceleration - other.acceleration).abs() <= SAME_ACCELERATION_SHARE * larger
    }
}

/// A stroke under way or done: per cell of 1 ms the way of the reference, what was added, and the
/// load's error, rad.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Run {
    pub(super) beginning: Beginning,
    pub(super) ways: Vec<f64>,
    pub(super) applied: Vec<f64>,
    pub(super) errors: Vec<f64>,
}

/// A stored stroke.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Stroke {
    beginning: Beginning,
    /// Where its pages begin in the list of them, and its cells.
    first_page: usize,
    cells: usize,
    /// RMS of the error when it was first seen, rad.
    first: f64,
    /// gamma of this stroke; halved each time that its correction did harm.
    rate: f64,
    /// Clock of its last use.
    used: u64,
}

/// A part of a stored stroke: ways of the reference and corrections, rad.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Page {
    ways: [f64; PAGE_CELLS],
    corrections: [f64; PAGE_CELLS],
}

/// All stored strokes, and a clock that counts their uses.
///
/// Their cells are on pages, which are given out and taken back whole, so that no stroke has to be moved
/// for another. What a stroke leaves free of its last page is within its overhead.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Strokes {
    strokes: Vec<Stroke>,
    clock: u64,
    pages: Vec<Page>,
    /// The pages of all strokes, those of each in a row.
    taken: Vec<usize>,
    free: Vec<usize>,
}

/// The learning law: gamma, lead and half width of the filter in cells, the memory in cells, and the
/// bound of a correction, rad.
#[derive(Clone, Copy, Debug)]
pub(super) struct Law {
    pub(super) rate: f64,
    pub(super) lead_cells: f64,
    pub(super) filter_cells: usize,
    pub(super) most_cells: usize,
    pub(super) largest: f64,
}

/// Whether two references are on the same way, rad.
fn near(way: f64, stored: f64) -> bool {
    (way - stored).abs() <= SAME_WITHIN_RAD + SAME_WITHIN_SHARE * stored.abs()
}

/// Linear interpolation between the cells of a list of `count`; the last value beyond the end.
fn between(cells: impl Fn(usize) -> f64, count: usize, at: f64) -> f64 {
    let Some(last) = count.checked_sub(1) else {
        return 0.0;
    };
    let n = at.max(0.0) as usize;
    if n >= last {
        return cells(last);
    }
    let here = cells(n);
    here + (cells(n + 1) - here) * (at.max(0.0) - n as f64)
}

impl Run {
    /// Room for a stroke that fills the memory; the cell behind it shows that there is more.
    pub(super) fn make_room(&mut self, law: &Law) {
        for cells in [&mut self.ways, &mut self.applied, &mut self.errors] {
            cells.reserve_exact((law.most_cells + 1).saturating_sub(cells.len()));
        }
    }
}

impl Strokes {
    /// Room for as many strokes and pages as the memory holds.
    pub(super) fn make_room(&mut self, law: &Law) {
        let strokes = law.most_cells / (SHORTEST_STROKE_CELLS + OVERHEAD_CELLS);
        self.strokes
            .reserve_exact(strokes.saturating_sub(self.strokes.len()));
        let pages = law.most_cells / PAGE_CELLS;
        self.pages
            .reserve_exact(pages.saturating_sub(self.pages.len()));
        for list in [&mut self.taken, &mut self.free] {
            list.reserve_exact(pages.saturating_sub(list.len()));
        }
    }

    /// The stored stroke with this beginning and these ways so far; of several the one used last.
    pub(super) fn find(&mut self, beginning: &Beginning, ways: &[f64]) -> Option<usize> {
        let same = |stroke: &Stroke| {
            stroke.beginning.is_like(beginning)
                && stroke.cells >= ways.len()
                && ways
                    .chunks(PAGE_CELLS)
                    .zip(self.of(stroke))
                    .all(|(ways, page)| {
                        let stored = &self.pages[*page].ways;
                        ways.iter().zip(stored).all(|(way, at)| near(*way, *at))
                    })
        };
        // the most recent one: in a series of parts the order of the strokes repeats, too
        let found = (0..self.strokes.len())
            .filter(|&n| same(&self.strokes[n]))
            .max_by_key(|&n| self.strokes[n].used)?;
        self.clock += 1;
        self.strokes[found].used = self.clock;
        Some(found)
    }

    /// The pages of a stroke.
    fn of(&self, stroke: &Stroke) -> &[usize] {
        let end = stroke.first_page + stroke.cells.div_ceil(PAGE_CELLS);
        &self.taken[stroke.first_page..end]
    }

    /// The page with a cell of a stroke, and where it is on it.
    fn page(&self, stroke: &Stroke, cell: usize) -> (&Page, usize) {
        let page = self.taken[stroke.first_page + cell / PAGE_CELLS];
        (&self.pages[page], cell % PAGE_CELLS)
    }

    /// Correction of a stroke at a time in cells since its beginning, rad.
    pub(super) fn correction(&self, stroke: usize, cells: f64) -> f64 {
        let correction = |stroke: &Stroke| {
            let at = |cell: usize| {
                let (page, place) = self.page(stroke, cell);
                page.corrections[place]
            };
            between(at, stroke.cells, cells)
        };
        self.strokes.get(stroke).map_or(0.0, correction)
    }

    /// Whether the way at a cell is still that of the stored stroke.
    pub(super) fn goes_on(&self, stroke: usize, cell: usize, way: f64) -> bool {
        self.strokes
            .get(stroke)
            .filter(|stroke| cell < stroke.cells)
            .is_some_and(|stroke| {
                let (page, place) = self.page(stroke, cell);
                near(way, page.ways[place])
            })
    }

    /// Learns from a run of a stored stroke, or stores a new one. The run's corrections and errors are
    /// used up.
    pub(super) fn learn(&mut self, run: &mut Run, known: Option<usize>, law: &Law) {
        let cells = run.ways.len();
        let rms = (run.errors.iter().map(|error| error * error).sum::<f64>() / cells.max(1) as f64)
            .sqrt();
        if cells < SHORTEST_STROKE_CELLS
            || cells + OVERHEAD_CELLS > law.most_cells
            || !rms.is_finite()
        {
            return;
        }
        self.clock += 1;
        // the correction did harm: back to none, and more carefully; else learn from this run
        let known = known.filter(|&n| self.strokes.get(n).is_some_and(|s| s.cells >= cells));
        match known {
            Some(n) if rms > HARMFUL_RATIO * self.strokes[n].first => {
                self.strokes[n].rate *= 0.5;
                let stroke = self.strokes[n];
                for at in stroke.first_page..stroke.first_page + self.of(&stroke).len() {
                    self.pages[self.taken[at]].corrections = [0.0; PAGE_CELLS];
                }
            }
            Some(n) => {
                law.next(run, self.strokes[n].rate);
                self.shorten(n, cells);
                self.write(n, run);
            }
            // new: what the run shows without a correction is the first step of learning
            None => {
                self.forget_for(cells + OVERHEAD_CELLS, law.most_cells);
                law.next(run, law.rate);
                let first_page = self.taken.len();
                for _ in 0..cells.div_ceil(PAGE_CELLS) {
                    let page = self.free.pop().unwrap_or_else(|| {
                        self.pages.push(Page::default());
                        self.pages.len() - 1
                    });
                    self.taken.push(page);
                }
                self.strokes.push(Stroke {
                    beginning: run.beginning,
                    first_page,
                    cells,
                    first: rms,
                    rate: law.rate,
                    used: self.clock,
                });
                self.write(self.strokes.len() - 1, run);
            }
        }
    }

    /// Writes the ways of a run, and the corrections that were made of it, on the pages of a stroke.
    fn write(&mut self, stroke: usize, run: &Run) {
        let first_page = self.strokes[stroke].first_page;
        let corrections = run.errors.chunks(PAGE_CELLS);
        for (n, (ways, corrections)) in run.ways.chunks(PAGE_CELLS).zip(corrections).enumerate() {
            let page = &mut self.pages[self.taken[first_page + n]];
            page.ways[..ways.len()].copy_from_slice(ways);
            page.corrections[..corrections.len()].copy_from_slice(corrections);
        }
    }

    /// Takes back the pages of a stroke behind so many cells, of which it has as many at least.
    fn shorten(&mut self, stroke: usize, cells: usize) {
        let Stroke {
            first_page,
            cells: before,
            ..
        } = self.strokes[stroke];
        let left = first_page + cells.div_ceil(PAGE_CELLS);
        let end = first_page + before.div_ceil(PAGE_CELLS);
        self.strokes[stroke].cells = cells;
        self.free.extend(self.taken.drain(left..end));
        for other in &mut self.strokes {
            if other.first_page >= end {
                other.first_page -= end - left;
            }
        }
    }

    /// Drops the least recently used strokes until there is room.
    fn forget_for(&mut self, wanted: usize, most: usize) {
        let mut taken: usize = self
            .strokes
            .iter()
            .map(|stroke| stroke.cells + OVERHEAD_CELLS)
            .sum();
        while taken + wanted > most {
            let Some(oldest) = (0..self.strokes.len()).min_by_key(|&n| self.strokes[n].used) else {
                return;
            };
            taken -= self.strokes[oldest].cells + OVERHEAD_CELLS;
            self.shorten(oldest, 0);
            self.strokes.swap_remove(oldest);
        }
    }
}

impl Law {
    /// `Q (u + gamma e(n + lead))`, bounded, in place of the errors of the run.
    fn next(&self, run: &mut Run, rate: f64) {
        let Run {
            applied, errors, ..
        } = run;
        let count = errors.len();
        for (n, applied) in applied.iter_mut().enumerate() {
            *applied += rate * between(|cell| errors[cell], count, n as f64 + self.lead_cells);
        }
        // three running means are nearly a Gaussian; centred, so that they do not shift the phase
        self.mean(applied, errors);
        self.mean(errors, applied);
        self.mean(applied, errors);
        errors
            .iter_mut()
            .for_each(|cell| *cell = cell.clamp(-self.largest, self.largest));
    }

    /// Centred running mean; towards the ends the window narrows, so that a straight line is kept.
    fn mean(&self, cells: &[f64], means: &mut [f64]) {
        let last = cells.len().saturating_sub(1);
        for (n, mean) in means.iter_mut().enumerate() {
            let reach = self.filter_cells.min(n).min(last - n);
            *mean = cells[n - reach..=n + reach].iter().sum::<f64>() / (2 * reach + 1) as f64;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LAW: Law = Law {
        rate: 0.5,
        lead_cells: 2.0,
        filter_cells: 0,
        most_cells: 200,
        largest: 1.0,
    };

    fn run(position: f64, cells: usize, error: impl Fn(usize) -> f64) -> Run {
        Run {
            beginning: Beginning {
                position,
                acceleration: 10.0,
                direction: 1,
            },
            ways: (0..cells).map(|n| 1e-3 * (n * n) as f64).collect(),
            applied: vec![0.0; cells],
            errors: (0..cells).map(error).collect(),
        }
    }

    #[test]
    fn it_learns_the_error_ahead_of_its_time() {
        let mut strokes = Strokes::default();
        strokes.learn(&mut run(1.0, 50, |n| n as f64 * 1e-3), None, &LAW);
        let found = strokes.find(&run(1.0, 0, |_| 0.0).beginning, &[]).unwrap();
        assert!((strokes.correction(found, 10.5) - 0.5 * 12.5e-3).abs() < 1e-15);
        assert!(
            strokes.goes_on(found, 20, 0.4)
                && !strokes.goes_on(found, 20, 0.41)
                && !strokes.goes_on(found, 50, 2.5)
        );
        assert_eq!(
            strokes.find(
                &Beginning {
                    position: 1.01,
                    acceleration: 10.0,
                    direction: 1
                },
                &[]
            ),
            None
        );
        assert_eq!(
            strokes.find(
                &Beginning {
                    position: 1.0,
                    acceleration: 10.0,
                    direction: -1
                },
                &[]
            ),
            None
        );
    }

    #[test]
    fn the_oldest_goes_when_the_memory_is_full_and_what_is_too_long_is_not_taken() {
        let mut strokes = Strokes::default();
        for position in 0..4 {
            strokes.learn(&mut run(f64::from(position), 50, |_| 1e-3), None, &LAW);
        }
        let known: Vec<bool> = (0..4)
            .map(|p| {
                strokes
                    .find(&run(f64::from(p), 0, |_| 0.0).beginning, &[])
                    .is_some()
            })
            .collect();
        assert_eq!(known, [false, true, true, true]);
        strokes.learn(&mut run(9.0, 300, |_| 1e-3), None, &LAW);
        assert_eq!(strokes.find(&run(9.0, 0, |_| 0.0).beginning, &[]), None);
    }

    #[test]
    fn a_correction_that_does_harm_is_dropped() {
        let mut strokes = Strokes::default();
        strokes.learn(&mut run(1.0, 50, |_| 1e-3), None, &LAW);
        strokes.learn(&mut run(1.0, 50, |_| 2e-3), Some(0), &LAW);
        assert!(strokes.correction(0, 10.0).abs() < 1e-300);
    }

    #[test]
    fn the_filter_has_no_lag_and_keeps_a_straight_line() {
        let law = Law {
            filter_cells: 3,
            ..LAW
        };
        let line: Vec<f64> = (0..40).map(f64::from).collect();
        let mut means = vec![0.0; line.len()];
        law.mean(&line, &mut means);
        assert!(means.iter().zip(&line).all(|(a, b)| (a - b).abs() < 1e-12));
    }
}
