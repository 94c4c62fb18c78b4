//! The cells of the full factorial that are run: a balanced sample.
//!
//! Every level of a factor occurs equally often (to one), and the pairs of levels of any two
//! factors as evenly as exchanges can make them: starting from shuffled columns, two cells swap
//! their levels of one factor whenever that does not raise the sum of squares of the pair counts.
//! Same number and seed, same cells.

use super::factor::{COUNT, Cell, FACTORS};
use crate::error::StudyError;
use lostmotion_base::Random;
use std::collections::BTreeSet;

/// Number of cells of the largest sample. A choice.
pub const MOST_CELLS: usize = 20_000;

/// Exchanges tried, for each cell. Tuned: more hardly make the pairs more even.
const EXCHANGES_PER_CELL: usize = 600;

/// Cells of the full factorial.
pub fn full_size() -> usize {
    FACTORS.iter().map(|factor| factor.levels.len()).product()
}

/// All cells there are, in the order of their levels.
pub fn all_cells() -> Vec<Cell> {
    (0..full_size())
        .map(|mut index| {
            // Mixed radix: the last factor varies fastest.
            let mut cell = Cell::default();
            for (level, factor) in cell.0.iter_mut().zip(&FACTORS).rev() {
                *level = (index % factor.levels.len()) as u8;
                index /= factor.levels.len();
            }
            cell
        })
        .collect()
}

/// A sample of a number of different cells.
///
/// # Errors
/// No cell, or more than [`MOST_CELLS`].
pub fn sample(cells: usize, seed: u64) -> Result<Vec<Cell>, StudyError> {
    let all = full_size();
    if cells == 0 || cells > MOST_CELLS.min(all) {
        return Err(StudyError::Cells {
            asked: cells,
            most: MOST_CELLS.min(all),
            all,
        });
    }
    let mut random = Random::new(seed);
    let mut list = shuffled_columns(cells, &mut random);
    let mut pairs = Pairs::of(&list);
    // Exchange algorithm: two cells swap their levels of one factor where that evens out the pairs.
    for _ in 0..EXCHANGES_PER_CELL * cells {
        let (a, b, factor) = (
            random.below(cells),
            random.below(cells),
            random.below(COUNT),
        );
        pairs.exchange_if_better(&mut list, a, b, factor);
    }
    // Exchanges know pairs only; whole cells may have become equal.
    part_twins(&mut list, &mut random);
    list.sort_unstable();
    Ok(list)
}

/// Columns in which each level occurs equally often, each shuffled by itself.
fn shuffled_columns(cells: usize, random: &mut Random) -> Vec<Cell> {
    let mut list = vec![Cell::default(); cells];
    for (factor, description) in FACTORS.iter().enumerate() {
        let levels = description.levels.len();
        // Levels that do not divide the number: those that occur once more are drawn at random.
        let mut order: Vec<u8> = (0..levels as u8).collect();
        random.shuffle(&mut order);
        let mut column: Vec<u8> = order.iter().copied().cycle().take(cells).collect();
        random.shuffle(&mut column);
        for (cell, level) in list.iter_mut().zip(column) {
            if let Some(place) = cell.0.get_mut(factor) {
                *place = level;
            }
        }
    }
    list
}

/// How often each pair of levels of two factors occurs.
struct Pairs {
    first: [usize; COUNT],
    width: usize,
    counts: Vec<i64>,
}

impl Pairs {
    fn of(list: &[Cell]) -> Pairs {
        // The levels of all factors one behind another are the rows of the matrix of counts, and
        // its columns.
        let mut first = [0; COUNT];
        let mut width = 0;
        for (place, factor) in first.iter_mut().zip(&FACTORS) {
            *place = width;
            width += factor.levels.len();
        }
        let mut pairs = Pairs {
            first,
            width,
            counts: vec![0; width * width],
        };
        // Each pair in both orders, so that an exchange may look it up either way.
        for cell in list {
            for f in 0..COUNT {
                for g in (0..COUNT).filter(|g| *g != f) {
                    let at = pairs.at(f, cell.level(f), g, cell.level(g));
                    pairs.add(at, 1);
                }
            }
        }
        pairs
    }

    fn at(&self, f: usize, level_f: usize, g: usize, level_g: usize) -> usize {
        let row =
            |factor: usize, level: usize| self.first.get(factor).map_or(0, |first| first + level);
        row(f, level_f) * self.width + row(g, level_g)
    }

    fn count(&self, at: usize) -> i64 {
        self.counts.get(at).copied().unwrap_or(0)
    }

    fn add(&mut self, at: usize, by: i64) {
        if let Some(count) = self.counts.get_mut(at) {
            *count += by;
        }
    }

    /// Swaps the levels of a factor between two cells if that makes the pairs more even, or leaves
    /// them as they are.
    fn exchange_if_better(&mut self, list: &mut [Cell], a: usize, b: usize, f: usize) {
        let (Some(&one), Some(&other)) = (list.get(a), list.get(b)) else {
            return;
        };
        let (level_a, level_b) = (one.level(f), other.level(f));
        if level_a == level_b {
            return;
        }
        // The sum of squares changes by 2 (gained counts - lost counts) + 4 for each other factor
        // on which the cells differ.
        let mut change = 0;
        for g in (0..COUNT).filter(|g| *g != f && one.level(*g) != other.level(*g)) {
            // Pairs that the swap takes away and those that it makes.
            let lost = self.count(self.at(f, level_a, g, one.level(g)))
                + self.count(self.at(f, level_b, g, other.level(g)));
            let gained = self.count(self.at(f, level_b, g, one.level(g)))
                + self.count(self.at(f, level_a, g, other.level(g)));
            change += 2 * (gained - lost) + 4;
        }
        // An exchange that changes nothing is made, too: the way to better ones leads over
        // plateaus.
        if change > 0 {
            return;
        }
        for g in (0..COUNT).filter(|g| *g != f) {
            for (cell, from, to) in [(&one, level_a, level_b), (&other, level_b, level_a)] {
                for (level, by) in [(from, -1), (to, 1)] {
                    let (at, mirrored) = (
                        self.at(f, level, g, cell.level(g)),
                        self.at(g, cell.level(g), f, level),
                    );
                    self.add(at, by);
                    self.add(mirrored, by);
                }
            }
        }
        for (index, level) in [(a, level_b), (b, level_a)] {
            if let Some(place) = list.get_mut(index).and_then(|cell| cell.0.get_mut(f)) {
                *place = level as u8;
            }
        }
    }
}

/// Swaps levels until no two cells are the same; the levels' numbers stay.
fn part_twins(list: &mut [Cell], random: &mut Random) {
    // A swap may make a new pair of twins: repeated until there is none, with a bound.
    for _ in 0..100 {
        // Every second and further occurrence swaps one level with a random cell.
        let mut seen = BTreeSet::new();
        let twins: Vec<usize> = (0..list.len())
            .filter(|i| list.get(*i).is_some_and(|cell| !seen.insert(*cell)))
            .collect();
        if twins.is_empty() {
            return;
        }
        for a in twins {
            let (b, f) = (random.below(list.len()), random.below(COUNT));
            let levels = (
                list.get(a).map_or(0, |cell| cell.level(f)),
                list.get(b).map_or(0, |cell| cell.level(f)),
            );
            for (index, level) in [(a, levels.1), (b, levels.0)] {
                if let Some(place) = list.get_mut(index).and_then(|cell| cell.0.get_mut(f)) {
                    *place = level as u8;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pair_counts(list: &[Cell], f: usize, g: usize) -> Vec<usize> {
        let (levels_f, levels_g) = (FACTORS[f].levels.len(), FACTORS[g].levels.len());
        let mut counts = vec![0; levels_f * levels_g];
        for cell in list {
            counts[cell.level(f) * levels_g + cell.level(g)] += 1;
        }
        counts
    }

    #[test]
    fn every_level_occurs_equally_often_and_every_pair_occurs() {
        for (cells, seed) in [(120, 1), (120, 2), (240, 1)] {
            let list = sample(cells, seed).unwrap();
            for (f, factor) in FACTORS.iter().enumerate() {
                for level in 0..factor.levels.len() {
                    let count = list.iter().filter(|cell| cell.level(f) == level).count();
                    let even = cells / factor.levels.len();
                    assert!(
                        count == even || count == even + 1,
                        "{} {level}: {count}",
                        factor.name
                    );
                }
                for g in (0..COUNT).filter(|g| *g != f) {
                    assert!(
                        pair_counts(&list, f, g).iter().all(|count| *count > 0),
                        "{cells} {seed} {f} {g}"
                    );
                }
            }
        }
    }

    #[test]
    fn exchanges_make_pairs_more_even_than_chance() {
        let spread = |list: &[Cell]| {
            let mut sum = 0.0;
            for f in 0..COUNT {
                for g in 0..f {
                    let counts = pair_counts(list, f, g);
                    let mean = list.len() as f64 / counts.len() as f64;
                    sum += counts
                        .iter()
                        .map(|c| (*c as f64 - mean) * (*c as f64 - mean))
                        .sum::<f64>();
                }
            }
            sum
        };
        let chance = spread(&shuffled_columns(120, &mut Random::new(5)));
        let sampled = spread(&sample(120, 5).unwrap());
        assert!(sampled < 0.2 * chance, "{sampled} {chance}");
    }

    #[test]
    fn cells_are_different_and_the_same_for_the_same_seed() {
        let list = sample(2000, 9).unwrap();
        let set: BTreeSet<Cell> = list.iter().copied().collect();
        assert_eq!(set.len(), 2000);
        assert_eq!(list, sample(2000, 9).unwrap());
        assert_ne!(list, sample(2000, 10).unwrap());
    }

    #[test]
    fn the_full_factorial_has_every_cell_once() {
        let all = all_cells();
        assert_eq!(all.len(), full_size());
        assert_eq!(all.iter().collect::<BTreeSet<_>>().len(), all.len());
    }

    #[test]
    fn no_cells_and_too_many_are_refused() {
        assert!(sample(0, 1).is_err() && sample(MOST_CELLS + 1, 1).is_err());
    }
}
