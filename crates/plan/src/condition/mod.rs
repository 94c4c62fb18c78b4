//! From programmed moves to the path that is travelled: pieces that join with continuous second
//! derivative, between stops.
//!
//! Lines and arcs that meet at small angles are a section: one smooth curve inside the tube of the program
//! takes its place ([`tube`]), from the middle of its first line to the middle of its last, unless
//! taking it vertex by vertex ([`moves`]) is faster.

mod begun;
mod blend;
mod fair;
mod joint;
mod moves;
mod run;
mod tube;

pub(crate) use blend::Judge;
pub(crate) use tube::LinearJoint;

use crate::PlannerConfig;
use crate::piece::{PathStep, Piece, Programmed, Stop};
use begun::Begun;
use joint::Junction;
use lostmotion_path::Curve;
use moves::Joiner;
use std::sync::Arc;
use tube::{Found, Tie, Way};

/// Lines of a section with which it is worked off. A choice: bounds memory.
const SECTION_LINES: usize = 4096;
/// Pieces of a curve with which it is worked off. A choice: bounds memory; longer parts have less
/// that is found twice.
const SECTION_PIECES: usize = 256;
/// Pieces at its end that are found again with what follows. A choice: the smoothest curve inside a
/// tube forgets what follows within a few turns from side to side, of about eight pieces each.
const HELD_PIECES: usize = 40;
/// Pieces before the last one that may be kept among which the part that is kept ends. A choice: half
/// a turn from side to side at least.
const CUT_PIECES: usize = 16;
/// Lines at which a section is looked at for the first time: how many more are needed then follows
/// from their shape.
const FIRST_LOOK: usize = 96;
/// Least number of lines from one look to the next. A choice: each looks at all lines.
const NEXT_LOOK: usize = 16;

/// A curve has to take less than this part of the time of the section vertex by vertex. A choice: the
/// estimate errs by about the rest, and a curve that gains nothing leaves more of the program.
const FASTER_PART: f64 = 0.99;
/// The same where the section has arcs, which are what is wanted and not chords of something: a curve
/// that leaves them for little makes the contour worse. A choice.
const FASTER_PART_OF_ARCS: f64 = 0.98;
/// The same where it has sharp corners: a curve swings beside its lines all along, and rounding in
/// time does not. A choice.
const FASTER_PART_OF_CORNERS: f64 = 0.96;
/// Ways from rest to the feed, for each sharp corner of a section, from which on gentle bends and sharp corners
/// are taken one after the other without a look at both. A stop costs the time in which the feed goes two such
/// ways, of which a curve saves half, and 1 - `FASTER_PART_OF_CORNERS` of all is what it has to save.
const LONG_RUN_UPS: f64 = 25.0;
/// Tolerances that both lines at such a corner are long at least. A choice: between shorter lines the corner
/// by itself is a stop that cannot be rounded, and a curve saves all of it.
const ROUND_TOLERANCES: f64 = 10.0;
/// Ways from rest to the feed over which a line may bend all along. A choice: on longer lines the
/// motion is at its feed anyway, and a curve that begins there gets slower with a larger tolerance.
const RUN_UPS: f64 = 3.0;

/// How the section that is open is taken.
#[derive(Clone, Debug)]
enum Taken {
    /// That is not decided yet.
    Open,
    /// Vertex by vertex.
    Moves,
    /// As a curve, of which the beginning has been output.
    Curve(Box<Begun>),
}

/// Whether a section may have gentle bends beside sharp corners.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mixture {
    Allowed,
    /// Either by itself: no curve was found over both.
    Parted,
}

/// Turns moves into steps, holding back what the next move may change.
#[derive(Clone, Debug)]
pub(crate) struct Conditioner {
    config: PlannerConfig,
    joiner: Joiner,
    /// Lines that meet at small angles; the joiner has the first one, and all of them where they are
    /// taken vertex by vertex.
    section: Vec<Programmed>,
    /// Where the curve begins on the first one.
    from: f64,
    taken: Taken,
    /// Whether the motion rests where the first line begins, for good.
    rested: bool,
    /// Weight of the section's moves: a line is one, an arc as many lines.
    held: usize,
    /// The weight at which the section is looked at.
    due: usize,
    /// How the section's beginning is taken vertex by vertex, where that is known.
    known: Option<Moves>,
    /// How often a curve could not be found any further.
    curve_stops: u64,
    /// How many threads find curves.
    threads: usize,
}

/// A section taken vertex by vertex.
#[derive(Clone, Debug)]
struct Moves {
    /// Its lines.
    lines: usize,
    /// The joiner after them.
    joiner: Joiner,
    steps: Vec<PathStep>,
    /// The same up to where gentle bends and sharp corners part first; none where they do not.
    first: Option<Box<Moves>>,
    /// Whether a curve was looked for and none was found.
    is_unfound: bool,
}

impl Conditioner {
    pub(crate) fn new(config: PlannerConfig) -> Conditioner {
        Conditioner {
            joiner: Joiner::new(config.clone()),
            config,
            section: Vec::new(),
            from: 0.0,
            taken: Taken::Open,
            rested: true,
            held: 0,
            due: FIRST_LOOK,
            known: None,
            curve_stops: 0,
            threads: 1,
        }
    }

    /// How many threads find curves.
    pub(crate) fn set_threads(&mut self, threads: usize) {
        self.threads = threads;
    }

    /// How often the motion came to rest because a curve could not be found any further.
    pub(crate) fn curve_stops(&self) -> u64 {
        self.curve_stops
    }

    /// Takes a move of positive length.
    pub(crate) fn push(&mut self, next: &Programmed, judge: &dyn Judge, out: &mut Vec<PathStep>) {
        self.take(next, Mixture::Allowed, judge, out);
    }

    fn take(
        &mut self,
        next: &Programmed,
        mixture: Mixture,
        judge: &dyn Judge,
        out: &mut Vec<PathStep>,
    ) {
        let Some(last) = self.section.last().copied() else {
            self.joiner.push(next, judge, out);
            self.begin(*next);
            return;
        };
        if !joint::bends(&self.config, &last, next) {
            let stops = matches!(joint::joint(&self.config, &last, next), Junction::Stop);
            self.close(stops, judge, out);
            self.joiner.push(next, judge, out);
            self.rested = stops;
            self.begin(*next);
            return;
        }
        // A line so long that its middle stays straight ends a section and begins another.
        if let [.., before, _] = self.section.as_slice()
            && (joint::stays_straight(&self.config, before, &last, next)
                || self.parts(before, &last, next, mixture))
        {
            self.close(false, judge, out);
            if self.section.is_empty() {
                self.take(next, mixture, judge, out);
                return;
            }
            self.rested = false;
            self.begin(last);
        }
        match self.taken {
            Taken::Moves => {
                self.joiner.push(next, judge, out);
                self.section.clear();
                self.section.extend([last, *next]);
            }
            Taken::Open | Taken::Curve(_) => {
                // A run of moves that do not belong to the section may end with its first one.
                if self.section.len() == 1 {
                    self.joiner.close(judge, out);
                }
                self.section.push(*next);
                self.held += joint::weight(next);
                if self.held >= self.due {
                    self.work_off(judge, out);
                }
            }
        }
    }

    /// Comes to rest after what was pushed so far.
    pub(crate) fn stop(&mut self, stop: Stop, judge: &dyn Judge, out: &mut Vec<PathStep>) {
        self.close(stop.tolerance.is_none(), judge, out);
        self.section.clear();
        self.joiner.stop(stop, judge, out);
        self.rested = true;
    }

    /// Whether a line lies between gentle bends and sharp corners and ends a section of either: where it
    /// is longer than what bends at the corner, or where that is wanted.
    fn parts(
        &self,
        before: &Programmed,
        line: &Programmed,
        next: &Programmed,
        mixture: Mixture,
    ) -> bool {
        let corner = match (self.is_gentle(before, line), self.is_gentle(line, next)) {
            (true, false) => [line, next],
            (false, true) => [before, line],
            _ => return false,
        };
        let bent = joint::bent(&self.config, corner[0], corner[1]);
        mixture == Mixture::Parted || matches!(self.taken, Taken::Moves) || bent < 0.5 * line.length
    }

    fn is_gentle(&self, before: &Programmed, next: &Programmed) -> bool {
        joint::is_gentle(&self.config, before, next)
    }

    /// Whether the section has both gentle bends and sharp corners.
    fn is_mixed(&self) -> bool {
        let mut pairs = self.section.windows(2);
        let Some(first) = pairs.next() else {
            return false;
        };
        let first = self.is_gentle(&first[0], &first[1]);
        pairs.any(|pair| self.is_gentle(&pair[0], &pair[1]) != first)
    }

    /// Takes gentle bends and sharp corners of the section one after the other, given how the first of
    /// them is taken vertex by vertex where that is known.
    fn part(
        &mut self,
        taken: Taken,
        known: Option<Moves>,
        judge: &dyn Judge,
        out: &mut Vec<PathStep>,
    ) {
        let (from, lines) = (self.from, std::mem::take(&mut self.section));
        let mut lines = lines.into_iter();
        if let Some(first) = lines.next() {
            self.begin(first);
        }
        (self.from, self.taken, self.known) = (from, taken, known);
        for line in lines {
            self.take(&line, Mixture::Parted, judge, out);
        }
    }

    /// Begins a section with a line that the joiner has.
    fn begin(&mut self, line: Programmed) {
        self.section.clear();
        self.section.push(line);
        self.held = joint::weight(&line);
        self.taken = Taken::Open;
        self.due = FIRST_LOOK;
        self.from = 0.0;
        self.known = None;
    }

    /// Ends the section at its last line, of which at least the second half is left unless the
    /// motion rests at its end.
    fn close(&mut self, rests: bool, judge: &dyn Judge, out: &mut Vec<PathStep>) {
        let Some(last) = self.section.last().copied() else {
            return;
        };
        match std::mem::replace(&mut self.taken, Taken::Moves) {
            Taken::Moves => self.joiner.close(judge, out),
            _ if self.section.len() < 2 => {}
            Taken::Open => {
                let (from, start) = self.start();
                let (to, end) = self.end(rests);
                match self.decide([from, to], [start, end], judge) {
                    Err(moves) if self.rests_behind_first(&moves, judge, out) => {
                        self.close(rests, judge, out);
                    }
                    Ok(found) => {
                        self.joiner.lead_in_to(from, out);
                        emit(found.pieces, out);
                        self.joiner.go_on(last, to);
                    }
                    Err(Moves {
                        first: Some(first), ..
                    }) => {
                        self.part(Taken::Open, Some(*first), judge, out);
                        self.close(rests, judge, out);
                    }
                    Err(Moves { joiner, steps, .. }) => {
                        self.joiner = joiner;
                        out.extend(steps);
                        self.joiner.close(judge, out);
                    }
                }
            }
            begun @ Taken::Curve(_) => {
                self.taken = begun;
                let (to, end) = self.end(rests);
                if let Some(found) = self.find_on(to, end, judge, out) {
                    emit(found.pieces, out);
                    self.joiner.go_on(last, to);
                    self.taken = Taken::Moves;
                } else {
                    self.give_up(judge, out);
                    self.close(rests, judge, out);
                }
            }
        }
    }

    /// Outputs the beginning of a long section, or decides how it is taken.
    fn work_off(&mut self, judge: &dyn Judge, out: &mut Vec<PathStep>) {
        let Some(last) = self.section.last().copied() else {
            return;
        };
        let (from, start) = match &self.taken {
            Taken::Curve(begun) => (self.from, Tie::State(begun.state)),
            _ => self.start(),
        };
        let is_open = matches!(self.taken, Taken::Open);
        // More lines are needed for a curve of the usual length.
        let pieces = self
            .way(from, last.length)
            .map_or(0, |way| tube::pieces(&way, [start, Tie::Place]));
        if pieces > 0 && pieces < SECTION_PIECES && self.held < SECTION_LINES {
            let more = self.held * SECTION_PIECES / pieces;
            self.due = (more + more / 8)
                .max(self.held + NEXT_LOOK)
                .min(SECTION_LINES);
            return;
        }
        let found = if is_open {
            match self.decide([from, last.length], [start, Tie::Place], judge) {
                Ok(found) => found,
                Err(moves) if self.rests_behind_first(&moves, judge, out) => {
                    return self.work_off(judge, out);
                }
                Err(Moves {
                    first: Some(first), ..
                }) => return self.part(Taken::Open, Some(*first), judge, out),
                Err(Moves { joiner, steps, .. }) => {
                    self.taken = Taken::Moves;
                    self.joiner = joiner;
                    out.extend(steps);
                    self.section.drain(..self.section.len() - 1);
                    // An arc ends what is taken move by move: what follows may be faster as a curve.
                    if matches!(last.curve, Curve::Arc(_)) {
                        self.joiner.close(judge, out);
                        self.rested = false;
                        self.begin(last);
                    }
                    return;
                }
            }
        } else {
            match self.find_on(last.length, Tie::Place, judge, out) {
                Some(found) => found,
                None => return self.give_up(judge, out),
            }
        };
        let held = HELD_PIECES.min(found.pieces.len() / 2);
        let most = (found.pieces.len() - held).min(self.before_last(&found));
        if most == 0 {
            self.due = self.held + NEXT_LOOK;
            return;
        }
        if is_open {
            self.joiner.lead_in_to(from, out);
        }
        self.cut(found, most.saturating_sub(CUT_PIECES).max(1)..=most, out);
        self.due = (2 * self.held).max(NEXT_LOOK);
    }

    /// Where the curve begins, and how.
    fn start(&self) -> (f64, Tie) {
        let (Some(first), Some(next)) = (self.section.first(), self.section.get(1)) else {
            return (0.0, Tie::Place);
        };
        let spent = self.joiner.spent();
        let bent = joint::bent(&self.config, first, next);
        if self.rested && spent == 0.0 && bent > first.length && self.is_run_up(first) {
            return (0.0, Tie::Place);
        }
        let bent = bent.min(0.5 * first.length);
        let from = (first.length - bent).max(spent);
        (from, Tie::State(first.state(from)))
    }

    /// Where the curve ends, and how.
    fn end(&self, rests: bool) -> (f64, Tie) {
        let [.., before, last] = self.section.as_slice() else {
            return (0.0, Tie::Place);
        };
        let bent = joint::bent(&self.config, before, last);
        if rests && bent > last.length && self.is_run_up(last) {
            return (last.length, Tie::Place);
        }
        let bent = bent.min(0.5 * last.length);
        (bent, Tie::State(last.state(bent)))
    }

    /// Whether a move from or to rest is over soon after the motion is at its feed: then all of it may
    /// bend, since the curve begins and ends in any direction. An arc may anyway: it bends itself.
    fn is_run_up(&self, line: &Programmed) -> bool {
        matches!(line.curve, Curve::Arc(_))
            || line.length < RUN_UPS * joint::run_up(&self.config, line.feed)
    }

    fn find(
        &self,
        [from, to]: [f64; 2],
        [start, end]: [Tie; 2],
        judge: &dyn Judge,
    ) -> Option<Found> {
        let way = self.way(from, to)?;
        let first = self.section.first()?;
        let joints = judge.joints_at(&first.curve.start(), &first.tool_mm);
        let found = tube::curve(&way, [start, end], &joints, self.threads);
        if found.is_some() || !way.is_rough() {
            return found;
        }
        tube::curve(&way.finely_thinned(), [start, end], &joints, self.threads)
    }

    /// The lines of the section with their tolerances.
    fn way(&self, from: f64, to: f64) -> Option<Way<'_>> {
        let tolerances: Option<Vec<f64>> = self
            .section
            .iter()
            .map(|line| joint::merge_tolerance(&self.config, line.control))
            .collect();
        Way::new(&self.section, from, to, &tolerances?)
    }

    /// The section as a curve where that takes clearly less time; else vertex by vertex.
    // On the stack for a moment, once a section.
    #[allow(clippy::result_large_err)]
    fn decide(
        &mut self,
        [from, to]: [f64; 2],
        [start, end]: [Tie; 2],
        judge: &dyn Judge,
    ) -> Result<Found, Moves> {
        let pairs = self.section.windows(2);
        let gentle: Vec<bool> = pairs
            .map(|pair| self.is_gentle(&pair[0], &pair[1]))
            .collect();
        let parted = gentle.windows(2).position(|pair| pair[0] != pair[1]);
        let lines = self.section.len();
        let sharp = gentle.contains(&false);
        if let Some(pair) = parted
            && self.is_past_gain(&gentle)
        {
            let mut first = self.first_moves(pair + 2, judge);
            first.first = Some(Box::new(first.clone()));
            return Err(first);
        }
        let (joiner, steps, first) = match self.known.take() {
            Some(known) if known.lines == lines => (known.joiner, known.steps, None),
            _ => {
                let (mut joiner, mut steps, mut first) = (self.joiner.clone(), Vec::new(), None);
                for (k, line) in self.section.iter().enumerate().skip(1) {
                    joiner.push(line, judge, &mut steps);
                    // Where both part nothing is closed before.
                    if parted.is_some_and(|pair| k == pair + 1) {
                        first = Some((k + 1, joiner.clone(), steps.len()));
                    }
                }
                (joiner, steps, first)
            }
        };
        let mut whole = steps.clone();
        joiner.clone().stop(Stop::default(), judge, &mut whole);
        let arcs = self
            .section
            .iter()
            .any(|of| matches!(of.curve, Curve::Arc(_)));
        let part = match (arcs, sharp) {
            (true, _) => FASTER_PART_OF_ARCS,
            (false, true) => FASTER_PART_OF_CORNERS,
            (false, false) => FASTER_PART,
        };
        let mut is_unfound = false;
        let found = judge.time_to_beat_s(&whole, part).and_then(|most_s| {
            let found = self.find([from, to], [start, end], judge);
            is_unfound = found.is_none();
            found.filter(|found| self.curve_s(found, from, to, judge) < most_s)
        });
        found.ok_or_else(|| Moves {
            lines,
            first: first.map(|(lines, joiner, count)| {
                Box::new(Moves {
                    lines,
                    joiner,
                    steps: steps[..count].to_vec(),
                    first: None,
                    is_unfound: false,
                })
            }),
            joiner,
            steps,
            is_unfound,
        })
    }

    /// Whether the section is so long that what a curve may save at its sharp corners is too little for it,
    /// given at which of its vertices it bends gently.
    fn is_past_gain(&self, gentle: &[bool]) -> bool {
        let length: f64 = self.section.iter().map(|line| line.length).sum();
        let mut corners = self.section.windows(2).zip(gentle);
        let mut saved = 0.0;
        corners.all(|(pair, gentle)| {
            if *gentle {
                return true;
            }
            let feed = pair[0].feed.max(pair[1].feed);
            saved += LONG_RUN_UPS * joint::run_up(&self.config, feed);
            let is_round = joint::merge_tolerance(&self.config, pair[0].control)
                .is_some_and(|p| pair[0].length.min(pair[1].length) > ROUND_TOLERANCES * p);
            is_round && saved < length
        })
    }

    /// The first lines of the section taken vertex by vertex.
    fn first_moves(&self, lines: usize, judge: &dyn Judge) -> Moves {
        let (mut joiner, mut steps) = (self.joiner.clone(), Vec::new());
        for line in &self.section[1..lines] {
            joiner.push(line, judge, &mut steps);
        }
        Moves {
            lines,
            joiner,
            steps,
            first: None,
            is_unfound: false,
        }
    }

    /// About how long the section takes as a curve, s.
    fn curve_s(&self, found: &Found, from: f64, to: f64, judge: &dyn Judge) -> f64 {
        let mut curve = Vec::new();
        self.joiner.clone().lead_in_to(from, &mut curve);
        let pieces = found.straightened();
        curve.extend(pieces.map(|piece| PathStep::Piece(Arc::new(piece))));
        if let Some(last) = self.section.last().filter(|last| to < last.length) {
            curve.push(PathStep::Piece(Arc::new(last.part(to, last.length))));
        }
        if found.has_motion() {
            judge.ideal_s(&curve)
        } else {
            judge.time_s(&curve)
        }
    }
}

fn emit(pieces: Vec<Piece>, out: &mut Vec<PathStep>) {
    out.extend(
        pieces
            .into_iter()
            .map(|piece| PathStep::Piece(Arc::new(piece))),
    );
}
