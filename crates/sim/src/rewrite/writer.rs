//! The new program: end points moved, arcs in pieces, take-ups put in.

use super::results::Rewritten;
use super::text::{Line, MARK, refuse};
use super::{Original, ROUNDING_MM, RewriteError, STILL_MM, Text, stretches};
use lostmotion_gcode::Dialect;
use lostmotion_path::Curve;

/// Letters of the axes that are moved, and those of centres.
pub(super) const LETTERS: [u8; 3] = *b"XYZ";
const CENTRES: [u8; 3] = *b"IJK";
/// Decimals of mm and of inch: a tenth of a micrometre and a quarter.
const DECIMALS: [usize; 2] = [4, 5];

/// Writes the new program.
pub(super) fn new_text(
    lines: &[Line],
    steps: &[Original],
    half: [f64; 3],
    dialect: Dialect,
    answer: &mut Rewritten,
) -> Result<Text, RewriteError> {
    let mut writer = NewProgram {
        out: Text::default(),
        end: lines
            .iter()
            .map(|line| line.end.clone())
            .find(|end| !end.is_empty())
            .unwrap_or_else(|| b"\n".to_vec()),
        semicolon: matches!(dialect, Dialect::Marlin | Dialect::Klipper),
        half,
        side: [0.0; 3],
        commanded: None,
        was_rapid: true,
    };
    let (mut next, mut is_headed) = (0, false);
    for (index, line) in lines.iter().enumerate() {
        if !is_headed && !line.is_head() {
            writer.header(&answer.program, &answer.machine);
            is_headed = true;
        }
        let from = next;
        while steps.get(next).is_some_and(|step| step.line == index + 1) {
            next += 1;
        }
        if let Some(code) = line
            .takes_the_place()
            .filter(|_| writer.commanded.is_some())
        {
            return Err(refuse(
                index + 1,
                format!(
                    "{code} takes where the axes stand, which is half a gap aside in a rewritten program: put it before the first move"
                ),
            ));
        }
        match steps.get(from..next).unwrap_or_default() {
            [] => writer.line(&line.text, None),
            [step] if line.is_not_plain().is_none() => {
                writer.step(line, step, from, answer)?;
            }
            // Rapids that are left as they are: to a place of the machine.
            others => {
                writer.line(&line.text, Some(from));
                for step in others {
                    writer.leave(step);
                }
            }
        }
    }
    // As the last line of the original ends.
    if lines.last().is_some_and(|line| line.end.is_empty()) {
        let cut = writer.out.text.len().saturating_sub(writer.end.len());
        writer.out.text.truncate(cut);
    }
    Ok(writer.out)
}

/// Where a piece stands, and what its line has to say.
struct PiecePlace {
    /// Its move of the original.
    index: usize,
    /// Its number on that move, from 0.
    number: usize,
    is_split: bool,
    /// The motion in force before it is another one.
    needs_code: bool,
}

/// The new program as it grows.
struct NewProgram {
    out: Text,
    end: Vec<u8>,
    semicolon: bool,
    half: [f64; 3],
    /// The direction in which each axis went last; 0 before its first.
    side: [f64; 3],
    /// Where the machine was sent last, machine coordinates, mm.
    commanded: Option<[f64; 3]>,
    was_rapid: bool,
}

impl NewProgram {
    fn line(&mut self, text: &[u8], step: Option<usize>) {
        self.out.text.extend_from_slice(text);
        self.out.text.extend_from_slice(&self.end);
        self.out.steps.push(step);
    }

    fn remark(&self, text: &str) -> String {
        let plain = text.replace(['(', ')', ';', '\n', '\r'], " ");
        if self.semicolon {
            format!("; {plain}")
        } else {
            format!("({plain})")
        }
    }

    fn header(&mut self, program: &str, machine: &str) {
        let [x, y, z] = self.half.map(|half| format!("{half:.4}"));
        for text in [
            format!("{program} {MARK} {} for machine {machine}", env!("CARGO_PKG_VERSION")),
            format!("for a control WITHOUT backlash compensation; half gaps in mm: X {x} Y {y} Z {z}"),
            "end points are moved by half the gap towards the way of each axis; lines with the mark backlash are new: they take up a gap".to_owned(),
            "do not run it where the control compensates, nor after a repair of screws or bearings".to_owned(),
        ] {
            let text = self.remark(&text);
            self.line(text.as_bytes(), None);
        }
    }

    /// A rapid that stays as it is: axes that it does not move stay where they were sent.
    fn leave(&mut self, step: &Original) {
        let [start, end] = [step.curve.start(), step.curve.end()].map(|place| place.linear());
        let from = self.commanded.unwrap_or(start);
        let at = std::array::from_fn(|axis| {
            let way: f64 = end[axis] - start[axis];
            if way.abs() <= STILL_MM {
                return from[axis];
            }
            self.side[axis] = way.signum();
            end[axis]
        });
        self.out.ends.push((self.out.steps.len(), at));
        self.commanded = Some(at);
        self.was_rapid = true;
    }

    /// A move with its end point moved, in as many pieces as it has reversals.
    fn step(
        &mut self,
        line: &Line,
        step: &Original,
        index: usize,
        answer: &mut Rewritten,
    ) -> Result<(), RewriteError> {
        let pieces = stretches(step)?;
        if pieces.len() > 1 {
            answer.arcs_split += 1;
            if line.has_code_behind_the_move() {
                return Err(refuse(
                    step.line,
                    "the arc has to be cut at its reversals: put the M code or E word on a line of its own",
                ));
            }
        }
        if line.value(b'P').is_some() && matches!(step.curve, Curve::Arc(_)) {
            return Err(refuse(
                step.line,
                "arcs of several turns (P) are not rewritten",
            ));
        }
        for (number, piece) in pieces.iter().enumerate() {
            for (side, direction) in self.side.iter_mut().zip(piece.direction) {
                if direction != 0.0 {
                    *side = direction;
                }
            }
            let offset: [f64; 3] = std::array::from_fn(|axis| self.side[axis] * self.half[axis]);
            let start: [f64; 3] = std::array::from_fn(|axis| piece.start[axis] + offset[axis]);
            let end: [f64; 3] = std::array::from_fn(|axis| piece.end[axis] + offset[axis]);
            let mut needs_code = number > 0;
            if !step.rapid && self.take_up(line, step, index, start, answer) {
                needs_code = true;
            }
            let place = PiecePlace {
                index,
                number,
                is_split: pieces.len() > 1,
                needs_code,
            };
            self.piece(line, step, [start, end], &place);
        }
        self.was_rapid = step.rapid;
        Ok(())
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
        let mut names = Vec::new();
        for axis in moved {
            let letter = char::from(LETTERS[axis]);
            text.push_str(&format!(
                " {letter}{}",
                number(start[axis] - step.shift[axis], line.mm)
            ));
            names.push(letter.to_string());
        }
        if let Some(feed) = line.feed.as_ref().filter(|_| !rapid) {
            text.push_str(&format!(" {feed}"));
        }
        let remark = self.remark(&format!("backlash of {}", names.join(" ")));
        text.push_str(&format!(" {remark}"));
        self.line(text.as_bytes(), Some(index));
        self.out.ends.push((self.out.steps.len(), start));
        if rapid {
            answer.in_the_air += 1;
        } else {
            answer.within_cuts += 1;
        }
        self.commanded = Some(start);
        // What follows is a cut; a rapid that took up is no cut.
        self.was_rapid = false;
        true
    }

    fn piece(
        &mut self,
        line: &Line,
        step: &Original,
        [start, end]: [[f64; 3]; 2],
        place: &PiecePlace,
    ) {
        let PiecePlace {
            index,
            number: piece,
            is_split,
            needs_code,
        } = *place;
        let from = self
            .commanded
            .unwrap_or_else(|| step.curve.start().linear());
        let mut words: Vec<(u8, String)> = Vec::new();
        let code = match &step.curve {
            _ if step.rapid => "0",
            Curve::Arc(arc) => {
                let [first, second, _] = step.curve.plane().axes();
                let (start, tangent) = (step.curve.start().linear(), step.curve.tangent(0.0));
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
        };
        if needs_code && (piece > 0 || !line.has_motion()) {
            words.push((b'G', code.to_owned()));
        }
        for axis in 0..3 {
            let is_there = piece == 0 && line.value(LETTERS[axis]).is_some();
            if is_there
                || is_split && (end[axis] - start[axis]).abs() > STILL_MM
                || (end[axis] - from[axis]).abs() > ROUNDING_MM
            {
                words.push((LETTERS[axis], number(end[axis] - step.shift[axis], line.mm)));
            }
        }
        if let Curve::Arc(arc) = &step.curve {
            if let Some(radius) = line.value(b'R') {
                if is_split {
                    words.push((b'R', number(radius.abs() * line.mm, line.mm)));
                }
            } else if is_split {
                let axes = step.curve.plane().axes();
                // The centre goes with the piece.
                for (axis, center) in axes.into_iter().zip(arc.center()) {
                    let side = self.side[axis] * self.half[axis];
                    words.push((CENTRES[axis], number(center + side - start[axis], line.mm)));
                }
            }
        }
        let text = if piece == 0 {
            line.with(&words)
        } else {
            let mut text = String::new();
            for (letter, value) in &words {
                text.push_str(&format!("{}{value} ", char::from(*letter)));
            }
            text.trim_end().to_owned().into_bytes()
        };
        self.line(&text, Some(index));
        self.out.ends.push((self.out.steps.len(), end));
        self.commanded = Some(end);
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
