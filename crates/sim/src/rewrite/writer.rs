//! The new program: end points moved, arcs in pieces, take-ups put in.

use super::heights::Heights;
use super::results::Rewritten;
use super::text::{LETTERS, Line, MARK, TextLines};
use super::{Moves, Original, ROUNDING_MM, STILL_MM, Stretch, Text};
use lostmotion_gcode::Dialect;
use lostmotion_path::{Arc, Curve};

/// Letters of centres.
const CENTRES: [u8; 3] = *b"IJK";
/// Decimals of mm and of inch: a tenth of a micrometre and a quarter.
const DECIMALS: [usize; 2] = [4, 5];
/// By how much a centre may move for both ends of its arc to be equally far from it, mm. A choice: along
/// the chord it moves no point of less than half a turn by more than half of what the radii differ by;
/// beyond this the chord is too short to go by.
const MOST_EVENED_MM: f64 = 0.1;

/// How far beyond its first place an axis is brought before it goes there, mm, and in half gaps at least.
/// Choices: more than gap and wind-up, and little beside the distance that rapids keep.
const APPROACH_MM: f64 = 0.5;
const APPROACH_HALVES: f64 = 8.0;

/// The direction in which X and Y move first in a cut: they are brought to their first place in the same
/// one. Z always comes from above.
fn first_directions(moves: &Moves<'_>) -> [f64; 3] {
    let of_axis = |axis: usize| {
        let all = moves.steps.iter().zip(moves.pieces);
        let cuts = all.filter(|(step, _)| !step.rapid);
        let mut directions = cuts
            .flat_map(|(_, own)| own)
            .map(|piece| piece.direction[axis]);
        directions.find(|way| *way != 0.0).unwrap_or(1.0)
    };
    [of_axis(0), of_axis(1), -1.0]
}

/// What the header counts.
const COUNTED: &str = "first cuts are from a side that is not known";

/// Writes the new program.
pub(super) fn new_text(
    lines: &TextLines,
    moves: &Moves<'_>,
    dialect: Dialect,
    answer: &mut Rewritten,
) -> Text {
    let steps = moves.steps;
    let mut writer = NewProgram {
        out: Text {
            text: lines.mark.to_vec(),
            ..Text::default()
        },
        end: lines
            .all
            .iter()
            .map(|line| line.end.clone())
            .find(|end| !end.is_empty())
            .unwrap_or_else(|| b"\n".to_vec()),
        semicolon: dialect.is_printer(),
        half: moves.half,
        travel: moves.travel,
        ahead: first_directions(moves),
        heights: Heights::of(moves),
        is_known: moves.half.map(|half| half == 0.0),
        is_placed: [false; 3],
        is_plain: [true; 3],
        count_at: 0,
        side: [0.0; 3],
        commanded: None,
        commanded_side: [0.0; 3],
        was_rapid: true,
    };
    let mut next = 0;
    // The first piece of the next move, counted over the whole program.
    let mut piece = 0;
    for (index, line) in lines.all.iter().enumerate() {
        if index == lines.head {
            writer.header(answer);
        }
        let from = next;
        while steps.get(next).is_some_and(|step| step.line == index + 1) {
            next += 1;
        }
        // Where a change leaves the axes is the control's affair.
        if line.changes_the_tool() {
            writer.is_known = moves.half.map(|half| half == 0.0);
            writer.is_placed = [false; 3];
        }
        let first = piece;
        piece += moves.pieces[from..next].iter().map(Vec::len).sum::<usize>();
        match steps.get(from..next).unwrap_or_default() {
            [] => {
                writer.line(&line.text, None);
                // From half a gap aside to a home where the original stands already.
                let before = from.checked_sub(1).and_then(|index| steps.get(index));
                let place = before
                    .map(|step| step.curve.end())
                    .or_else(|| steps.get(from).map(|step| step.curve.start()));
                if let Some(place) = place.filter(|_| line.goes_home()) {
                    writer.leave(line, [place.linear(); 2]);
                }
            }
            [step] if line.is_not_plain().is_none() => {
                let pieces: Vec<MovedPiece> = moves.pieces[from]
                    .iter()
                    .enumerate()
                    .map(|(number, stretch)| MovedPiece {
                        stretch: *stretch,
                        shifts: moves.shifts.of(first + number),
                        center: moves.shifts.center(first + number),
                    })
                    .collect();
                writer.step(line, step, from, &pieces, answer);
            }
            // Rapids that are left as they are: to a place of the machine.
            others => {
                writer.line(&line.text, Some(from));
                for step in others {
                    let ends = [step.curve.start(), step.curve.end()];
                    writer.leave(line, ends.map(|place| place.linear()));
                }
            }
        }
    }
    writer.tell_count(answer.sides_unknown);
    // As the last line of the original ends.
    if lines.all.last().is_some_and(|line| line.end.is_empty()) {
        let cut = writer.out.text.len().saturating_sub(writer.end.len());
        writer.out.text.truncate(cut);
    }
    writer.out
}

/// A piece of a move, with the displacements of its start and end besides half a gap, mm.
struct MovedPiece {
    stretch: Stretch,
    shifts: [[f64; 3]; 2],
    /// That of an arc's centre, in the axes of its plane.
    center: [f64; 2],
}

/// Where a piece stands, and what its line has to say.
struct PiecePlace<'a> {
    line: &'a Line,
    step: &'a Original,
    /// Its move of the original.
    index: usize,
    /// Its number on that move, from 0.
    number: usize,
    is_split: bool,
    /// Its ends are displaced along the normal, and by how much the centre is.
    is_bent: bool,
    center: [f64; 2],
    /// The motion in force before it is another one.
    needs_code: bool,
}

/// The new program as it grows.
struct NewProgram {
    out: Text,
    end: Vec<u8>,
    semicolon: bool,
    half: [f64; 3],
    /// Ends of the travel, machine coordinates, mm.
    travel: [[f64; 2]; 3],
    /// The direction in which each axis is brought to its first place.
    ahead: [f64; 3],
    heights: Heights,
    /// Whether an axis' flank is known: not before it has gone somewhere from a place that is, since
    /// nobody knows where the machine stands when the program begins, and behind a change of the tool.
    is_known: [bool; 3],
    /// Whether the program has sent an axis somewhere since then.
    is_placed: [bool; 3],
    /// Whether an axis stands where the original has it, without half a gap: at a place of the machine, or
    /// where its flank is not known. It stays there until it moves.
    is_plain: [bool; 3],
    /// Where the header has how many flanks are not known, in bytes.
    count_at: usize,
    /// The direction in which each axis went last; 0 before its first.
    side: [f64; 3],
    /// Where the machine was sent last, machine coordinates, mm.
    commanded: Option<[f64; 3]>,
    /// The direction in which each axis went last on its way there.
    commanded_side: [f64; 3],
    was_rapid: bool,
}

impl NewProgram {
    fn line(&mut self, text: &[u8], step: Option<usize>) {
        self.out.text.extend_from_slice(text);
        self.out.text.extend_from_slice(&self.end);
        self.out.steps.push(step);
    }

    /// The machine was sent there.
    fn sent(&mut self, at: [f64; 3]) {
        self.commanded = Some(at);
        // Without half a gap an axis is on neither side.
        self.commanded_side = std::array::from_fn(|axis| {
            if self.is_plain[axis] {
                0.0
            } else {
                self.side[axis]
            }
        });
    }

    fn remark(&self, text: &str) -> String {
        let plain = text.replace(['(', ')', ';', '\n', '\r'], " ");
        if self.semicolon {
            format!("; {plain}")
        } else {
            format!("({plain})")
        }
    }

    fn header(&mut self, answer: &Rewritten) {
        let (program, machine) = (&answer.program, &answer.machine);
        let [x, y, z] = self.half.map(|half| format!("{half:.4}"));
        let normal = (answer.normal_um > 0.0).then(|| {
            format!(
                "end points are also moved by up to {:.4} mm along the normal against what friction and servo leave; a mark correction is of an axis that is moved for this alone",
                answer.normal_um * 1e-3
            )
        });
        let texts = [
            format!("{program} {MARK} {} for machine {machine}", env!("CARGO_PKG_VERSION")),
            format!("for a control WITHOUT backlash compensation; half gaps in mm: X {x} Y {y} Z {z}"),
            "end points are moved by half the gap towards the way of each axis; lines with the mark backlash are new: they take up a gap, or are the further pieces of an arc".to_owned(),
            format!("each axis is brought to its first place from a known side, by rapids that begin {:.4} mm beyond it: Z from above, X and Y where the tool is above all cuts, {COUNTED}", self.approach_mm()),
            "do not run it where the control compensates, nor after a repair of screws or bearings".to_owned(),
        ];
        for text in texts.into_iter().chain(normal) {
            let text = self.remark(&text);
            if let Some(at) = text.find(COUNTED) {
                self.count_at = self.out.text.len() + at;
            }
            self.line(text.as_bytes(), None);
        }
    }

    /// Says in the header how many flanks are not known.
    fn tell_count(&mut self, count: u64) {
        if self.count_at > 0 {
            let at = self.count_at;
            self.out.text.splice(at..at, format!("{count} ").bytes());
        }
    }

    /// A rapid that stays as it is: axes that its line does not name stay where they were sent.
    fn leave(&mut self, line: &Line, [start, end]: [[f64; 3]; 2]) {
        let from = self.commanded.unwrap_or(start);
        let mut at = from;
        for axis in (0..3).filter(|axis| line.sends(*axis)) {
            at[axis] = end[axis];
            let way: f64 = at[axis] - from[axis];
            if way.abs() > STILL_MM {
                self.side[axis] = way.signum();
            }
            self.is_known[axis] |= self.is_placed[axis] && way.abs() >= self.approach_mm();
            (self.is_placed[axis], self.is_plain[axis]) = (true, true);
        }
        self.out.ends.push((self.out.steps.len(), at));
        self.sent(at);
        self.was_rapid = true;
    }

    /// A move with its end point moved, in as many pieces as it has reversals.
    fn step(
        &mut self,
        line: &Line,
        step: &Original,
        index: usize,
        pieces: &[MovedPiece],
        answer: &mut Rewritten,
    ) {
        answer.arcs_split += u64::from(pieces.len() > 1);
        for (number, piece) in pieces.iter().enumerate() {
            let MovedPiece {
                stretch,
                shifts: [first, last],
                center,
            } = piece;
            for (side, direction) in self.side.iter_mut().zip(stretch.direction) {
                if direction != 0.0 {
                    *side = direction;
                }
            }
            let behind = if step.rapid {
                self.behind(line, step, stretch)
            } else {
                self.cut_from(line, stretch, answer);
                [0.0; 3]
            };
            let offset = self.offset();
            let from = self.commanded.unwrap_or(stretch.start);
            let mut start = [0.0; 3];
            let mut end = [0.0; 3];
            for axis in 0..3 {
                // An axis that does not move is not moved: at its home, half a gap before the end of its
                // travel, there is no room for it.
                let rests = stretch.direction[axis] == 0.0 && behind[axis] == 0.0;
                let is_named = line.value(LETTERS[axis]).is_some();
                if rests && (self.is_plain[axis] || step.rapid && !is_named) {
                    (start[axis], end[axis]) = (from[axis], from[axis]);
                    continue;
                }
                // Where its flank is not known, half a gap would be as good to the other side.
                let is_left = step.rapid && !self.is_known[axis];
                self.is_plain[axis] = is_left;
                let offset = if is_left { 0.0 } else { offset[axis] };
                start[axis] = stretch.start[axis] + offset + first[axis];
                end[axis] = stretch.end[axis] + offset + last[axis];
            }
            let mut needs_code = number > 0;
            if !step.rapid && self.take_up(line, step, index, start, answer) {
                needs_code = true;
            }
            let place = PiecePlace {
                line,
                step,
                index,
                number,
                is_split: pieces.len() > 1,
                is_bent: [first, last].iter().any(|shift| **shift != [0.0; 3]),
                center: *center,
                needs_code,
            };
            if behind == [0.0; 3] {
                self.piece(&place, [start, end]);
                continue;
            }
            // Behind its place, wherever it came from; then there.
            let first = std::array::from_fn(|axis| end[axis] + behind[axis]);
            self.piece(&place, [start, first]);
            for (side, behind) in self.commanded_side.iter_mut().zip(behind) {
                if behind != 0.0 {
                    *side = behind.signum();
                }
            }
            self.was_rapid = true;
            self.take_up(line, step, index, end, answer);
        }
        if step.rapid {
            self.settle(line, step, index, answer);
        }
        self.was_rapid = step.rapid;
    }

    /// A cut makes the flanks of the axes that it moves known.
    fn cut_from(&mut self, line: &Line, stretch: &Stretch, answer: &mut Rewritten) {
        for (axis, letter) in LETTERS.into_iter().enumerate() {
            let moves = stretch.direction[axis] != 0.0;
            answer.sides_unknown += u64::from(moves && !self.is_known[axis]);
            self.is_known[axis] |= moves;
            self.is_placed[axis] |= moves || line.value(letter).is_some();
        }
    }

    /// How far from the end of a rapid axes have to be first whose flank is not known, mm; and takes
    /// their sides. An axis that comes from a place where the program has sent it, far enough, needs
    /// nothing; one that may not go beyond its place is left without a known flank.
    fn behind(&mut self, line: &Line, step: &Original, stretch: &Stretch) -> [f64; 3] {
        let approach = self.approach_mm();
        let is_clear = self.is_clear(line, step, stretch);
        let mut behind = [0.0; 3];
        for axis in 0..3 {
            let moves = stretch.direction[axis] != 0.0;
            if !(moves || line.value(LETTERS[axis]).is_some()) {
                continue;
            }
            let way = (stretch.end[axis] - stretch.start[axis]).abs();
            let was_placed = std::mem::replace(&mut self.is_placed[axis], true);
            if self.is_known[axis] {
                continue;
            }
            if was_placed && way >= approach {
                self.is_known[axis] = true;
            } else if let Some(side) = self.free_side(axis, stretch.end[axis], is_clear) {
                (self.is_known[axis], self.side[axis]) = (true, side);
                behind[axis] = -side * approach;
            }
        }
        behind
    }

    /// Whether X and Y may go beyond their places on a rapid: its Z is known, and above all cuts at both
    /// ends.
    fn is_clear(&self, line: &Line, step: &Original, stretch: &Stretch) -> bool {
        let is_placed = self.is_placed[2];
        let [start, end] = [stretch.start[2], stretch.end[2]].map(|z| z - step.tool_z_mm);
        // Where the program begins the place before its first one is not known: the end counts.
        let lowest = if is_placed { start.min(end) } else { end };
        (is_placed || line.value(b'Z').is_some()) && self.heights.are_below(lowest)
    }

    /// The direction in which an axis is brought to a place, if there is one with room: Z goes down, since
    /// below there may be material.
    fn free_side(&self, axis: usize, place: f64, is_clear: bool) -> Option<f64> {
        let (approach, half) = (self.approach_mm(), self.half[axis]);
        let [min, max] = self.travel[axis];
        let is_within = |side: &f64| {
            let first = place - side * approach;
            first - half >= min && first + half <= max
        };
        let ahead = self.ahead[axis];
        if axis == 2 {
            return Some(-1.0).filter(is_within);
        }
        // At an end of the travel from the other side.
        [ahead, -ahead]
            .into_iter()
            .find(is_within)
            .filter(|_| is_clear)
    }

    /// Brings X and Y to their places from a known side once the tool is above all cuts, where they could
    /// not on the way there: by two rapids of their own.
    fn settle(&mut self, line: &Line, step: &Original, index: usize, answer: &mut Rewritten) {
        let at = step.curve.end().linear();
        if !(self.is_placed[2] && self.heights.are_below(at[2] - step.tool_z_mm)) {
            return;
        }
        let Some(from) = self.commanded else { return };
        let (mut beyond, mut place) = (from, from);
        let mut sides = self.side;
        for axis in 0..2 {
            if self.is_known[axis] || !self.is_placed[axis] {
                continue;
            }
            let Some(side) = self.free_side(axis, at[axis], true) else {
                continue;
            };
            place[axis] = at[axis] + side * self.half[axis];
            beyond[axis] = place[axis] - side * self.approach_mm();
            sides[axis] = side;
            // The way to its place is a reversal, and so is the one before it.
            (self.side[axis], self.commanded_side[axis]) = (-side, side);
            (self.is_known[axis], self.is_plain[axis]) = (true, false);
        }
        if beyond == from {
            return;
        }
        self.was_rapid = true;
        self.take_up(line, step, index, beyond, answer);
        (self.side, self.was_rapid) = (sides, true);
        self.take_up(line, step, index, place, answer);
        // Two rapids take up one gap.
        answer.in_the_air = answer.in_the_air.saturating_sub(1);
    }

    fn approach_mm(&self) -> f64 {
        let widest = self.half.into_iter().fold(0.0, f64::max);
        APPROACH_MM.max(APPROACH_HALVES * widest)
    }

    /// Moves the axes whose gap has to be crossed before a piece; whether there is one.
    fn take_up(
        &mut self,
        line: &Line,
        step: &Original,
        index: usize,
        start: [f64; 3],
        answer: &mut Rewritten,
    ) -> bool {
        let from = self
            .commanded
            .unwrap_or_else(|| step.curve.start().linear());
        let moved: Vec<usize> = (0..3)
            .filter(|axis| (start[*axis] - from[*axis]).abs() > ROUNDING_MM)
            .collect();
        if moved.is_empty() {
            return false;
        }
        let rapid = self.was_rapid;
        let mut text = if rapid {
            "G0".to_owned()
        } else {
            "G1".to_owned()
        };
        // An axis that has not reversed is only moved for its neighbours along the normal to meet.
        let (mut reversed, mut corrected) = (Vec::new(), Vec::new());
        let mut at = from;
        for axis in moved {
            at[axis] = start[axis];
            let letter = char::from(LETTERS[axis]);
            text.push_str(&format!(
                " {letter}{}",
                number(start[axis] - step.shift[axis], line.mm)
            ));
            let names = if self.side[axis] == self.commanded_side[axis] {
                &mut corrected
            } else {
                &mut reversed
            };
            names.push(letter.to_string());
        }
        if let Some(feed) = line.feed.as_ref().filter(|_| !rapid) {
            text.push_str(&format!(" {feed}"));
        }
        let marks: Vec<String> = [("backlash", reversed), ("correction", corrected)]
            .into_iter()
            .filter(|(_, names)| !names.is_empty())
            .map(|(mark, names)| format!("{mark} of {}", names.join(" ")))
            .collect();
        let remark = self.remark(&marks.join(", "));
        text.push_str(&format!(" {remark}"));
        self.line(text.as_bytes(), Some(index));
        self.out.ends.push((self.out.steps.len(), at));
        if rapid {
            answer.in_the_air += 1;
        } else {
            answer.within_cuts += 1;
        }
        self.sent(at);
        // What follows is a cut; a rapid that took up is no cut.
        self.was_rapid = false;
        true
    }

    /// By how much half a gap displaces the machine.
    fn offset(&self) -> [f64; 3] {
        std::array::from_fn(|axis| self.side[axis] * self.half[axis])
    }

    /// Writes a piece between two places of the machine.
    fn piece(&mut self, place: &PiecePlace<'_>, [start, end]: [[f64; 3]; 2]) {
        let from = self
            .commanded
            .unwrap_or_else(|| place.step.curve.start().linear());
        let mut words: Vec<(u8, String)> = Vec::new();
        if place.needs_code && (place.number > 0 || !place.line.has_motion()) {
            words.push((b'G', place.motion_code().to_owned()));
        }
        // An axis without a word stays where it was sent.
        let mut at = from;
        for axis in place.axes_with_words(from, [start, end]) {
            at[axis] = end[axis];
            let programmed = end[axis] - place.step.shift[axis];
            words.push((LETTERS[axis], number(programmed, place.line.mm)));
        }
        if let Curve::Arc(arc) = &place.step.curve {
            let spokes = place.spokes(arc, self.offset(), [start, end]);
            words.extend(place.centre_words(spokes));
            // Each piece is less than a turn.
            if place.line.value(b'P').is_some() {
                words.push((b'P', String::new()));
            }
        }
        let mut text = place.text(&words);
        if place.number > 0 {
            let mark = self.remark("backlash: piece");
            text.extend_from_slice(format!(" {mark}").as_bytes());
        }
        self.line(&text, Some(place.index));
        self.out.ends.push((self.out.steps.len(), at));
        self.sent(at);
    }
}

impl PiecePlace<'_> {
    /// The number of the G code that makes its motion.
    fn motion_code(&self) -> &'static str {
        let curve = &self.step.curve;
        match curve {
            _ if self.step.rapid => "0",
            Curve::Arc(arc) => {
                let [first, second, _] = curve.plane().axes();
                let (start, tangent) = (curve.start().linear(), curve.tangent(0.0));
                let [x, y] = [
                    start[first] - arc.center()[0],
                    start[second] - arc.center()[1],
                ];
                // The plane's axes are right-handed in their order: as G2 and G3 count.
                if x * tangent[second] - y * tangent[first] > 0.0 {
                    "3"
                } else {
                    "2"
                }
            }
            _ => "1",
        }
    }

    /// The axes whose ends its line says, where the machine was sent to a place before.
    fn axes_with_words(
        &self,
        from: [f64; 3],
        [start, end]: [[f64; 3]; 2],
    ) -> impl Iterator<Item = usize> {
        let plane = self.step.curve.plane().axes();
        (0..3).filter(move |&axis| {
            let is_there = self.number == 0 && self.line.value(LETTERS[axis]).is_some();
            // Without a word of its plane an arc would be a whole circle.
            let is_of_plane = self.is_split && plane[..2].contains(&axis);
            is_there
                || is_of_plane && (end[axis] - start[axis]).abs() > STILL_MM
                || (end[axis] - from[axis]).abs() > ROUNDING_MM
        })
    }

    /// The centre of its arc from where it starts, in the axes of the plane: it goes with the piece.
    fn spokes(&self, arc: &Arc, offset: [f64; 3], [start, end]: [[f64; 3]; 2]) -> [f64; 2] {
        let axes = self.step.curve.plane().axes();
        let mut spokes = [0.0; 2];
        for (index, (axis, center)) in axes.into_iter().zip(arc.center()).enumerate() {
            let offset = offset[axis] + self.center[index];
            spokes[index] = center + offset - start[axis];
        }
        if self.is_bent {
            let [first, second, _] = axes;
            let chord = [end[first] - start[first], end[second] - start[second]];
            spokes = evened(spokes, chord);
        }
        spokes
    }

    /// The words of its centre, or its radius where the line has one; none where the arc keeps its own.
    fn centre_words(&self, spokes: [f64; 2]) -> Vec<(u8, String)> {
        if !(self.is_split || self.is_bent) {
            return Vec::new();
        }
        let Some(radius) = self.line.value(b'R') else {
            let axes = self.step.curve.plane().axes();
            let words = spokes.into_iter().zip(axes);
            return words
                .map(|(spoke, axis)| (CENTRES[axis], number(spoke, self.line.mm)))
                .collect();
        };
        // Without a displacement the radius stays as it was written.
        let size = if self.is_bent {
            lostmotion_base::math::hypot(spokes[0], spokes[1])
        } else {
            radius.abs() * self.line.mm
        };
        let sign = if self.is_split { 1.0 } else { radius.signum() };
        vec![(b'R', number(sign * size, self.line.mm))]
    }

    /// Its line: that of the original with these words, or for a further piece the words alone.
    fn text(&self, words: &[(u8, String)]) -> Vec<u8> {
        if self.number == 0 {
            return self.line.with(words);
        }
        let mut text = String::new();
        for (letter, value) in words.iter().filter(|(_, value)| !value.is_empty()) {
            text.push_str(&format!("{}{value} ", char::from(*letter)));
        }
        text.trim_end().to_owned().into_bytes()
    }
}

/// A centre from an arc's start, mm, moved along the chord until both ends are equally far from it: controls
/// refuse arcs of two radii (grbl from 5 um on). As it is where it would have to go too far.
fn evened(spokes: [f64; 2], chord: [f64; 2]) -> [f64; 2] {
    let squared = chord[0] * chord[0] + chord[1] * chord[1];
    let along = chord[0] * spokes[0] + chord[1] * spokes[1];
    let share = (0.5 * squared - along) / squared;
    if share.abs() * squared.sqrt() <= MOST_EVENED_MM {
        [spokes[0] + share * chord[0], spokes[1] + share * chord[1]]
    } else {
        spokes
    }
}

/// A number of mm in a program's unit, with a point.
fn number(value_mm: f64, mm: f64) -> String {
    let decimals = DECIMALS[usize::from(mm > 1.0)];
    let text = format!("{:.decimals$}", value_mm / mm);
    let cut = text.trim_end_matches('0');
    if cut == "-0." {
        "0.".to_owned()
    } else {
        cut.to_owned()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::math::hypot;

    #[test]
    fn both_ends_of_an_arc_are_equally_far_from_its_centre() {
        // a quarter of a circle of 2 mm whose end was displaced by 22 um
        let (spokes, chord) = ([2.0, 0.0], [2.0, 2.022]);
        let [x, y] = evened(spokes, chord);
        assert!((hypot(x, y) - hypot(x - chord[0], y - chord[1])).abs() < 1e-12);
        assert!(hypot(x - spokes[0], y - spokes[1]) < 0.033);
        // what is left out of a whole turn is too short to tell a direction
        assert_eq!(evened([2.0, 0.0], [1e-4, 1e-3]), [2.0, 0.0]);
        // a whole turn
        assert_eq!(evened([2.0, 0.0], [0.0, 0.0]), [2.0, 0.0]);
    }
}
