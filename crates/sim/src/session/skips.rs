//! Stretches of a program that a correction leaves out, since the contour would be worse there.
//!
//! What the gap hides of a drive's overshoot mostly matters in a few corners of a part. Left out are
//! the stretches before and after each place where the error with a correction is beyond what is allowed,
//! from before the last reversal on, which is where the load changed its flank. They are found on the
//! rehearsed machine, and rehearsed again with them ([`super::rehearsal`]), since a correction that ends and begins
//! again moves the tool, too.
//!
//! Places are those of the path, so that what an operator does to the feed moves none of them.

use std::cmp::Ordering;

/// A place on the path: number of the segment and place on it.
pub(super) type PathPlace = (u64, f64);

/// Behind every place.
const END: PathPlace = (u64::MAX, f64::INFINITY);

/// Time before a place that is too far off from which on nothing is corrected, and after it, s; twice as
/// long each time that it did not suffice. A choice: a correction is taken back within some tens of milliseconds, and
/// drives are told twenty times a second.
const AROUND_S: [f64; 2] = [0.25, 0.15];
/// Time before such a place within which a reversal may be the cause, s. A choice: a drive overshoots for less.
const CAUSE_S: f64 = 0.5;
/// Stretches this near to each other are one, s. A choice: a shorter correction is of no use.
const NEAR_S: f64 = 0.3;
/// Time over which squares are compared, s. A choice: a reversal with what follows.
const WINDOW_S: f64 = 0.5;
/// Part of the time beyond which leaving out is of no use: so much of a gap remains anyway.
const MOST_SHARE: f64 = 0.8;

/// A command of a rehearsal.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RehearsedCommand {
    pub(super) place: PathPlace,
    /// Squares of the error without a correction and with it, mm2; 0 where nothing is measured.
    pub(super) squares: [f64; 2],
    /// Whether an axis comes back.
    pub(super) returns: bool,
}

/// Stretches in the order of the path, which do not touch.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Skips {
    /// Numbers of the first command and the one behind the last.
    commands: Vec<[usize; 2]>,
    places: Vec<[PathPlace; 2]>,
    /// How often they were widened.
    rounds: i32,
}

impl Skips {
    /// Whether a place is left out.
    pub(super) fn contain(&self, place: PathPlace) -> bool {
        let behind = |stretch: &[PathPlace; 2]| order(&stretch[1], &place) == Ordering::Greater;
        let next = self.places.partition_point(|stretch| !behind(stretch));
        self.places
            .get(next)
            .is_some_and(|[from, _]| order(from, &place) != Ordering::Greater)
    }

    /// Leaves out more: around commands whose error with the correction is beyond `most_mm`, and, where the sum of
    /// its squares is beyond that without it, where it grows most. `None` where hardly anything is left to correct. `is_whole`: whether
    /// the program ends with the last command; what comes after it is left out otherwise.
    pub(super) fn widened(
        &self,
        steps: &[RehearsedCommand],
        most_mm: f64,
        period_s: f64,
        is_whole: bool,
    ) -> Option<Skips> {
        let commands = |time_s: f64| (time_s / period_s).round() as usize;
        let wider = f64::from(1 << self.rounds.min(6));
        let [before, after] = AROUND_S.map(|time_s| commands(wider * time_s));
        let mut stretches = self.commands.clone();
        let mut returned = None;
        for (number, step) in steps.iter().enumerate() {
            if step.returns {
                returned = Some(number);
            }
            if step.squares[1] > most_mm * most_mm {
                let cause = returned.filter(|returned| number - returned < commands(CAUSE_S));
                let from = cause.unwrap_or(number).saturating_sub(before);
                stretches.push([from, number + after]);
            }
        }
        stretches.extend(growing(steps, commands(WINDOW_S).max(1)));
        let commands = joined(stretches, commands(NEAR_S));
        let left_out: usize = commands
            .iter()
            .map(|[from, to]| (*to).min(steps.len()) - from)
            .sum();
        if left_out as f64 > MOST_SHARE * steps.len() as f64 {
            return None;
        }
        let at = |number: usize| steps.get(number).map_or(END, |step| step.place);
        let mut places: Vec<[PathPlace; 2]> = commands
            .iter()
            .map(|[from, to]| [at(*from), at(*to)])
            .collect();
        if !is_whole && let Some(last) = steps.last() {
            places.push([last.place, END]);
        }
        Some(Skips {
            commands,
            places,
            rounds: self.rounds + 1,
        })
    }
}

/// Order along the path.
fn order(a: &PathPlace, b: &PathPlace) -> Ordering {
    a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
}

/// Windows in which the squares grow most, as many as it takes for their sum not to grow.
fn growing(steps: &[RehearsedCommand], window: usize) -> Vec<[usize; 2]> {
    let sums = steps.chunks(window).enumerate().map(|(number, steps)| {
        let growth: f64 = steps
            .iter()
            .map(|step| step.squares[1] - step.squares[0])
            .sum();
        (growth, number)
    });
    let mut sums: Vec<(f64, usize)> = sums.collect();
    let mut total: f64 = sums.iter().map(|(growth, _)| growth).sum();
    sums.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut found = Vec::new();
    for (growth, number) in sums {
        if total <= 0.0 || growth <= 0.0 {
            break;
        }
        total -= growth;
        found.push([number * window, (number + 1) * window]);
    }
    found
}

/// The stretches in order, those that are near to each other as one.
fn joined(mut stretches: Vec<[usize; 2]>, near: usize) -> Vec<[usize; 2]> {
    stretches.sort_unstable();
    let mut joined: Vec<[usize; 2]> = Vec::new();
    for [from, to] in stretches {
        match joined.last_mut() {
            Some(last) if from <= last[1] + near => last[1] = last[1].max(to),
            _ => joined.push([from, to]),
        }
    }
    joined
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A command every 10 ms, ten to a segment, all with these squares.
    fn steps(count: usize, squares: [f64; 2]) -> Vec<RehearsedCommand> {
        let step = |number: usize| RehearsedCommand {
            place: ((number / 10) as u64, (number % 10) as f64),
            squares,
            returns: false,
        };
        (0..count).map(step).collect()
    }

    const PERIOD_S: f64 = 0.01;

    #[test]
    fn what_is_too_far_off_is_left_out_from_before_its_reversal_on() {
        let mut steps = steps(1000, [1.0, 0.5]);
        (steps[480].returns, steps[500].squares[1]) = (true, 9.0);
        // a reversal that is long past is no cause
        (steps[600].returns, steps[700].squares[1]) = (true, 9.0);
        let skips = Skips::default()
            .widened(&steps, 2.0, PERIOD_S, true)
            .unwrap();
        assert_eq!(skips.commands, [[455, 515], [675, 715]]);
        let places = [(45, 4.0), (45, 5.0), (51, 4.9), (51, 5.0), (68, 0.0)];
        assert_eq!(
            places.map(|place| skips.contain(place)),
            [false, true, true, false, true]
        );
        // twice as far around the second time
        let wider = skips.widened(&steps, 2.0, PERIOD_S, true).unwrap();
        assert_eq!(wider.commands, [[430, 530], [650, 730]]);
    }

    #[test]
    fn what_was_not_rehearsed_is_left_out() {
        let mut steps = steps(1000, [1.0, 0.5]);
        steps[500].squares[1] = 9.0;
        let widened = |is_whole| {
            Skips::default()
                .widened(&steps, 2.0, PERIOD_S, is_whole)
                .unwrap()
        };
        let behind = (100, 0.0);
        assert!(widened(false).contain(behind) && !widened(true).contain(behind));
    }

    #[test]
    fn squares_that_grow_are_left_out_where_they_grow_most() {
        // 0.5 s at a time: the sum grows by 5, and less of the second of them is enough
        let mut steps = steps(500, [1.0, 0.99]);
        for step in &mut steps[100..150] {
            step.squares[1] = 1.06;
        }
        for step in &mut steps[300..350] {
            step.squares[1] = 1.3;
        }
        let skips = Skips::default()
            .widened(&steps, 2.0, PERIOD_S, true)
            .unwrap();
        assert_eq!(skips.commands, [[300, 350]]);
    }

    #[test]
    fn where_hardly_anything_is_left_to_correct_nothing_is() {
        let mut steps = steps(1000, [1.0, 0.5]);
        for step in steps.iter_mut().step_by(30) {
            step.squares[1] = 9.0;
        }
        assert_eq!(Skips::default().widened(&steps, 2.0, PERIOD_S, true), None);
    }
}
