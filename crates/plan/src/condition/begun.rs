//! A section whose curve is found part by part: where a part ends, from where the next one is found, and what is
//! done where none is.

use super::joint;
use super::tube::{Found, Tie};
use super::{CUT_PIECES, Conditioner, Judge, Moves, ROUND_TOLERANCES, Taken, emit};
use crate::piece::{PathStep, Piece, Stop};
use lostmotion_path::HermiteEnd;
use std::ops::RangeInclusive;

/// How often a curve that is not found from where its beginning ends is looked for from further on. A
/// choice: two more, and what was held is over.
const LATER_CUTS: usize = 2;

/// A curve of which the beginning has been output.
#[derive(Clone, Debug)]
pub(super) struct Begun {
    /// Its state there.
    pub(super) state: HermiteEnd,
    /// What had been found from there on.
    pub(super) rest: Found,
}

impl Conditioner {
    /// How many pieces of a curve end before the last move. That one stays whole: how the curve ends on
    /// it is not known yet.
    pub(super) fn before_last(&self, found: &Found) -> usize {
        let last = self.section.len() - 1;
        found.places.partition_point(|(line, _)| *line < last)
    }

    /// Outputs the beginning of a curve. It ends after one of these numbers of pieces, where it bends
    /// least: what is given there leaves the rest the most freedom.
    pub(super) fn cut(
        &mut self,
        mut found: Found,
        among: RangeInclusive<usize>,
        out: &mut Vec<PathStep>,
    ) {
        let done = among
            .min_by(|a, b| found.bend(*a).total_cmp(&found.bend(*b)))
            .unwrap_or(1);
        let (line, s) = found.places[done - 1];
        self.from = s;
        self.section.drain(..line);
        self.held = self.section.iter().map(joint::weight).sum();
        let state = found.ends[done - 1];
        let rest = found.split_off(done);
        emit(found.pieces, out);
        self.taken = Taken::Curve(Box::new(Begun { state, rest }));
    }

    /// The curve from where its beginning ends; where none is found from there, from further on along
    /// what had been found.
    pub(super) fn find_on(
        &mut self,
        to: f64,
        end: Tie,
        judge: &dyn Judge,
        out: &mut Vec<PathStep>,
    ) -> Option<Found> {
        for later in 0..=LATER_CUTS {
            let Taken::Curve(begun) = &self.taken else {
                return None;
            };
            let start = Tie::State(begun.state);
            if let Some(found) = self.find([self.from, to], [start, end], judge) {
                return Some(found);
            }
            let most = self.before_last(&begun.rest).min(CUT_PIECES);
            if most == 0 || later == LATER_CUTS {
                return None;
            }
            let rest = begun.rest.clone();
            self.cut(rest, most.div_ceil(2)..=most, out);
        }
        None
    }

    /// Rests behind the first line where no curve was found that begins on it and the line is too short to lead
    /// anywhere: from rest a curve begins in any direction. Returns whether it rests.
    pub(super) fn rests_behind_first(
        &mut self,
        moves: &Moves,
        judge: &dyn Judge,
        out: &mut Vec<PathStep>,
    ) -> bool {
        let [first, next, _, ..] = *self.section.as_slice() else {
            return false;
        };
        let tolerance = joint::merge_tolerance(&self.config, first.control);
        let is_short = tolerance.is_some_and(|p| first.length <= ROUND_TOLERANCES * p);
        if !moves.is_unfound || self.rested || !is_short {
            return false;
        }
        self.joiner.stop(Stop::default(), judge, out);
        self.curve_stops += 1;
        self.joiner.push(&next, judge, out);
        self.section.remove(0);
        self.held -= joint::weight(&first);
        (self.from, self.rested) = (0.0, true);
        (self.taken, self.known) = (Taken::Open, None);
        true
    }

    /// Goes on where no curve is found from where the last one ends.
    pub(super) fn give_up(&mut self, judge: &dyn Judge, out: &mut Vec<PathStep>) {
        match std::mem::replace(&mut self.taken, Taken::Moves) {
            Taken::Curve(begun) if self.is_mixed() => {
                self.part(Taken::Curve(begun), None, judge, out);
            }
            // What was found before ends at a vertex: from there on vertex by vertex.
            Taken::Curve(begun) => self.fall_back(begun.rest.pieces, judge, out),
            taken => self.taken = taken,
        }
    }

    /// Outputs what was found before, which ends at a vertex, and goes on vertex by vertex from a
    /// stop there.
    pub(super) fn fall_back(
        &mut self,
        rest: Vec<Piece>,
        judge: &dyn Judge,
        out: &mut Vec<PathStep>,
    ) {
        let done = rest.last().map(|piece| piece.marks[1].segment);
        emit(rest, out);
        out.push(PathStep::Stop(Stop::default()));
        self.curve_stops += 1;
        self.joiner.forget();
        for line in self
            .section
            .iter()
            .filter(|line| done.is_none_or(|done| line.segment > done))
        {
            self.joiner.push(line, judge, out);
        }
        if self.section.iter().all(|line| done >= Some(line.segment)) {
            // All of it is behind: nothing may begin on its last line again.
            self.section.clear();
            self.rested = true;
        } else {
            self.section.drain(..self.section.len() - 1);
        }
        self.taken = Taken::Moves;
    }
}
