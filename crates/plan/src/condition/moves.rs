//! Vertex by vertex: blends between moves of any shape, runs through the vertices of short lines,
//! stops where nothing else is faster.
//!
//! No two of these share a stretch of the path, so the whole tolerance is there for each of them:
//! half of every move belongs to what happens at its either end.

use super::blend::{self, Judge};
use super::joint::{self, Junction};
use super::run::{self, RunChord, RunKnot};
use crate::PlannerConfig;
use crate::piece::{PathStep, Programmed, Stop};
use lostmotion_base::Coords;
use std::sync::Arc;

/// Number of chords with which a run is worked off. A choice: bounds memory; longer parts are
/// faired more evenly.
const RUN_CHORDS: usize = 96;
/// Chords at its end that are held back then. A spline forgets by a factor of 3.7 per vertex, so
/// that what follows cannot move what has been output.
const HELD_CHORDS: usize = 32;
/// Vertices of the held chords that are settled already: a spline forgets what follows.
const CARRIED_VERTICES: usize = 8;
/// Length scale of fairing in mean chords. Record 38 of the decisions.
const FAIRED_CHORDS: f64 = 3.3;

/// A line this many times as long as the shorter one beside it may end a run. Record 38 of the
/// decisions.
const FAR_RATIO: f64 = 12.0;
/// Largest part of such a line that a run may bend for the line to end it. Record 38 of the
/// decisions.
const BENT_PART: f64 = 0.3;

/// Turns moves into steps, holding back what the next move may change.
#[derive(Clone, Debug)]
pub(super) struct Joiner {
    config: PlannerConfig,
    /// Moves that meet in vertices; one move alone if there are none.
    chain: Vec<Programmed>,
    /// How much of the first move of the chain is spent.
    spent: f64,
    /// Where a run already partly worked off goes on: the knot at the start of the chain.
    knot: Option<RunKnot>,
    /// Vertices after it that are settled, too.
    carried: Vec<Coords>,
}

impl Joiner {
    pub(super) fn new(config: PlannerConfig) -> Joiner {
        Joiner {
            config,
            chain: Vec::new(),
            spent: 0.0,
            knot: None,
            carried: Vec::new(),
        }
    }

    /// Takes a move of positive length.
    pub(super) fn push(&mut self, next: &Programmed, judge: &dyn Judge, out: &mut Vec<PathStep>) {
        let Some(last) = self.chain.last() else {
            self.chain.push(*next);
            return;
        };
        let joint = joint::joint(&self.config, last, next);
        if joint == Junction::Vertex {
            // A long line ends the run before it and begins another one.
            if self.is_straight(last, next) {
                self.close_chain(judge, out);
            }
            self.chain.push(*next);
            // Memory is bounded: the older part of a long run is worked off.
            if self.chain.len() >= RUN_CHORDS {
                self.work_off(out);
            }
            return;
        }
        self.close_chain(judge, out);
        let spent = match joint {
            Junction::Stop => {
                self.end(out);
                out.push(PathStep::Stop(Stop::default()));
                0.0
            }
            Junction::Through | Junction::Vertex => {
                self.end(out);
                0.0
            }
            Junction::Blend { tolerance } => self.blend(next, tolerance, judge, out),
        };
        self.chain.clear();
        self.chain.push(*next);
        self.spent = spent;
    }

    /// Comes to rest after what was pushed so far.
    pub(super) fn stop(&mut self, stop: Stop, judge: &dyn Judge, out: &mut Vec<PathStep>) {
        self.close_chain(judge, out);
        self.end(out);
        self.chain.clear();
        out.push(PathStep::Stop(stop));
    }

    /// How much of the only move of the chain is spent.
    pub(super) fn spent(&self) -> f64 {
        self.spent
    }

    /// Outputs what the chain may still need to go on from its last move.
    pub(super) fn close(&mut self, judge: &dyn Judge, out: &mut Vec<PathStep>) {
        self.close_chain(judge, out);
    }

    /// Outputs the only move of the chain up to a place.
    pub(super) fn lead_in_to(&mut self, from: f64, out: &mut Vec<PathStep>) {
        debug_assert!(self.chain.len() <= 1, "moves before it would be lost");
        if let Some(first) = self.chain.last()
            && from > self.spent
        {
            out.push(PathStep::Piece(Arc::new(first.part(self.spent, from))));
        }
        self.spent = from;
    }

    /// Goes on from a place on a move, up to which all has been output.
    pub(super) fn go_on(&mut self, line: Programmed, from: f64) {
        self.chain.clear();
        self.chain.push(line);
        self.spent = from;
        self.knot = None;
        self.carried.clear();
    }

    /// Goes on from rest with the next move.
    pub(super) fn forget(&mut self) {
        self.chain.clear();
        self.spent = 0.0;
        self.knot = None;
        self.carried.clear();
    }

    /// Outputs the rest of the last move.
    fn end(&mut self, out: &mut Vec<PathStep>) {
        if let Some(last) = self.chain.last()
            && last.length > self.spent
        {
            out.push(PathStep::Piece(Arc::new(
                last.part(self.spent, last.length),
            )));
        }
        self.spent = 0.0;
    }

    /// Outputs the rest of the last move up to a blend, and the blend; or a stop in its place.
    /// Returns how much of the next move is spent.
    fn blend(
        &mut self,
        next: &Programmed,
        tolerance: f64,
        judge: &dyn Judge,
        out: &mut Vec<PathStep>,
    ) -> f64 {
        let Some(before) = self.chain.last() else {
            return 0.0;
        };
        // Half of the next move belongs to its other end; of this one all that its start has left.
        let longest = (before.length - self.spent).min(0.5 * next.length);
        match blend::best_blend(before, next, tolerance, longest, judge) {
            Some((half, piece)) => {
                if before.length - half > self.spent {
                    out.push(PathStep::Piece(Arc::new(
                        before.part(self.spent, before.length - half),
                    )));
                }
                out.push(PathStep::Piece(Arc::new(piece)));
                half
            }
            None => {
                // A stop wins, which may still be rounded in time where the tolerance allows it.
                let allowed =
                    (tolerance > self.config.exact_path_tolerance_mm).then_some(tolerance);
                let soft = allowed.and_then(|tolerance| judge.soft(before, next, tolerance));
                self.end(out);
                out.push(PathStep::Stop(Stop {
                    tolerance: allowed,
                    soft,
                    ..Stop::default()
                }));
                0.0
            }
        }
    }

    /// Outputs all of the chain but its last move, of which at least the second half is left.
    fn close_chain(&mut self, judge: &dyn Judge, out: &mut Vec<PathStep>) {
        let one_vertex = self.knot.is_none() && self.chain.len() == 2;
        if (one_vertex || self.ends_in_a_stub())
            && let (tolerance, Some(last)) = (self.tolerance(), self.chain.pop())
        {
            // One vertex makes no curve, and none is needed on a straight line: a blend of its two
            // halves would go at the lower of both feeds.
            self.close_chain(judge, out);
            let straight = self
                .chain
                .last()
                .is_some_and(|before| joint::goes_on(before, &last));
            let spent = if straight {
                self.end(out);
                0.0
            } else {
                self.blend(&last, tolerance, judge, out)
            };
            self.chain = vec![last];
            self.spent = spent;
        } else if self.knot.is_some() || self.chain.len() > 2 {
            // The curve through all vertices, into the middle of the last line.
            let (first, chords) = self.chords();
            let knots = run::knots(
                first,
                &chords,
                &self.carried,
                self.tolerance(),
                fairing_length(&chords),
            );
            if self.knot.is_none() {
                self.lead_in(&chords, out);
            }
            emit(&knots, &chords, out);
            self.spent = chords.last().map_or(0.0, |chord| chord.to);
            let last = self.chain.pop();
            self.chain.clear();
            self.chain.extend(last);
            self.knot = None;
            self.carried.clear();
        }
    }

    /// Whether a run would have to end in the direction of a line that is far too short for the
    /// curve to get there.
    fn ends_in_a_stub(&self) -> bool {
        matches!(self.chain.as_slice(), [_, .., before, last] if FAR_RATIO * last.length < before.length)
    }

    /// Whether the last line of the chain is so long that a run ends at its start and another
    /// begins at its end.
    fn is_straight(&self, last: &Programmed, next: &Programmed) -> bool {
        let Some(before) = self
            .chain
            .len()
            .checked_sub(2)
            .and_then(|k| self.chain.get(k))
        else {
            return false;
        };
        let short = before.length.min(next.length);
        let (longer, far) = (
            last.length > before.length + next.length,
            last.length > FAR_RATIO * short,
        );
        // A vertex reaches over more than the shorter of its lines, so that most lines need no
        // closer look.
        if !longer && !far {
            return false;
        }
        let tolerance = self.tolerance();
        let far = far && short > tolerance;
        let (first, second) = (
            joint::reach(before, last, tolerance),
            joint::reach(last, next, tolerance),
        );
        longer && first + second < last.length || far && first.min(second) < BENT_PART * last.length
    }

    /// Tolerance of the run that the chain is, mm.
    fn tolerance(&self) -> f64 {
        let tolerances = self
            .chain
            .iter()
            .filter_map(|line| joint::merge_tolerance(&self.config, line.control));
        tolerances.fold(f64::INFINITY, f64::min).min(1e3)
    }

    /// First knot and chords of the run: from the second half of the first move, where a run
    /// begins, into the first half of the last.
    fn chords(&self) -> (RunKnot, Vec<RunChord<'_>>) {
        let mut chords: Vec<RunChord<'_>> = self
            .chain
            .iter()
            .map(|line| RunChord {
                line,
                from: 0.0,
                to: line.length,
            })
            .collect();
        let tolerance = self.tolerance();
        let bent = |pair: Option<&[Programmed]>, line: &Programmed| match pair {
            Some([before, next]) => joint::reach(before, next, tolerance).min(0.5 * line.length),
            _ => 0.5 * line.length,
        };
        if let Some(last) = chords.last_mut() {
            last.to = bent(self.chain.windows(2).last(), last.line);
        }
        match (self.knot, chords.first_mut()) {
            (Some(knot), _) => (knot, chords),
            (None, Some(first)) => {
                first.from = first.line.length - bent(self.chain.windows(2).next(), first.line);
                (first.knot(first.from), chords)
            }
            (None, None) => (RunKnot::default(), chords),
        }
    }

    /// Outputs the older part of a long run.
    fn work_off(&mut self, out: &mut Vec<PathStep>) {
        let (first, chords) = self.chords();
        let knots = run::knots(
            first,
            &chords,
            &self.carried,
            self.tolerance(),
            fairing_length(&chords),
        );
        // The held chords at the end are solved for again with what follows.
        let done = chords.len() - HELD_CHORDS;
        if self.knot.is_none() {
            self.lead_in(&chords, out);
        }
        emit(&knots[..=done], &chords[..done], out);
        self.knot = knots.get(done).copied();
        self.carried = knots
            .iter()
            .skip(done + 1)
            .take(CARRIED_VERTICES)
            .map(|knot| knot.p)
            .collect();
        self.chain.drain(..done);
        self.spent = 0.0;
    }

    /// Outputs the rest of the first move before the run begins within it.
    fn lead_in(&self, chords: &[RunChord<'_>], out: &mut Vec<PathStep>) {
        if let Some(first) = chords.first()
            && first.from > self.spent
        {
            out.push(PathStep::Piece(Arc::new(
                first.line.part(self.spent, first.from),
            )));
        }
    }
}

/// Length scale of fairing, mm: longer features of a run stay as they are. It depends on the
/// program alone, so that a faster machine does not get a rougher path.
fn fairing_length(chords: &[RunChord<'_>]) -> f64 {
    FAIRED_CHORDS * chords.iter().map(RunChord::length).sum::<f64>() / chords.len().max(1) as f64
}

/// Outputs the pieces between knots.
fn emit(knots: &[RunKnot], chords: &[RunChord<'_>], out: &mut Vec<PathStep>) {
    for (chord, ends) in chords.iter().zip(knots.windows(2)) {
        out.push(PathStep::Piece(Arc::new(run::piece(
            &ends[0], &ends[1], chord,
        ))));
    }
}
