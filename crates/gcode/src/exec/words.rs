//! The words of a block as numbers, at most one per letter, its codes, and what they have to do with
//! each other before anything is carried out.

use crate::codes::row::bit;
use crate::codes::{AxisUse, Code, CodeRow, Group, find, users, whole};
use crate::dialect::{Leniencies, Leniency};
use crate::problem::Problem;
use crate::state::{State, TipControl};
use crate::syntax::Text;
use std::ops::RangeBounds;

/// Letters of the axes in index order.
pub(crate) const AXIS_LETTERS: [u8; 9] = *b"XYZABCUVW";
/// Bits of the axes.
pub(crate) const AXIS_BITS: u32 = bit(b'X')
    | bit(b'Y')
    | bit(b'Z')
    | bit(b'A')
    | bit(b'B')
    | bit(b'C')
    | bit(b'U')
    | bit(b'V')
    | bit(b'W');
/// Bits of U, V and W.
pub(crate) const SECONDARY_BITS: u32 = bit(b'U') | bit(b'V') | bit(b'W');
/// Most codes of one line. Derived: one of each modal group, G and M apart.
const MOST_CODES: usize = 24;

const G80: Code = Code::g(800);

/// A code of the block.
#[derive(Clone, Copy, Debug)]
pub(crate) struct UsedCode {
    pub(crate) row: &'static CodeRow,
    pub(crate) text: Text,
}

/// Words by letter, codes by phase.
#[derive(Clone, Debug, Default)]
pub(crate) struct Words {
    pub(crate) mask: u32,
    values: [f64; 31],
    texts: [Text; 31],
    codes: Vec<UsedCode>,
    /// Row of the motion that the block makes.
    pub(crate) motion: Option<&'static CodeRow>,
    /// What is accepted beyond RS274/NGC.
    pub(crate) accepted: Leniencies,
    /// A leniency that a code of the block takes.
    pub(crate) taken: Option<Leniency>,
    /// Bits of letters that may stand there without a code.
    pub(crate) free: u32,
}

fn slot(letter: u8) -> usize {
    bit(letter).trailing_zeros() as usize
}

impl Words {
    /// No words yet, with what is accepted beyond RS274/NGC.
    pub(crate) fn accepting(accepted: Leniencies) -> Words {
        Words {
            accepted,
            ..Words::default()
        }
    }

    pub(crate) fn clear(&mut self) {
        self.mask = 0;
        self.codes.clear();
        self.motion = None;
        self.taken = None;
        self.free = 0;
    }

    /// Whether a letter is there.
    pub(crate) const fn has(&self, letter: u8) -> bool {
        self.mask & bit(letter) != 0
    }

    /// The value of a letter.
    pub(crate) fn get(&self, letter: u8) -> Option<f64> {
        if self.has(letter) {
            self.values.get(slot(letter)).copied()
        } else {
            None
        }
    }

    /// Where a letter stands.
    pub(crate) fn text(&self, letter: u8) -> Text {
        self.texts.get(slot(letter)).copied().unwrap_or_default()
    }

    /// Whether the E word goes on with the number of another word, and would be its exponent with a
    /// sign.
    fn is_exponent(&self) -> bool {
        let start = self.text(b'E').start;
        let ends = |letter: u8| {
            let text = self.text(letter);
            self.has(letter) && text.len > 0 && text.start + text.len == start
        };
        self.accepted.has(Leniency::Exponents) && (b'A'..=b'Z').any(ends)
    }

    /// Codes in the order of execution.
    pub(crate) fn codes(&self) -> &[UsedCode] {
        &self.codes
    }

    /// Whether a G code is there.
    pub(crate) fn has_g(&self, tenths: u16) -> bool {
        self.codes
            .iter()
            .any(|used| used.row.code == Code::g(tenths))
    }

    /// Sets the value of a letter.
    pub(crate) fn put(&mut self, letter: u8, value: f64) {
        self.mask |= bit(letter);
        if let Some(kept) = self.values.get_mut(slot(letter)) {
            *kept = value;
        }
    }

    /// Sets the value of a letter that stands at a place.
    pub(crate) fn put_at(&mut self, letter: u8, value: f64, text: Text) {
        self.put(letter, value);
        if let Some(place) = self.texts.get_mut(slot(letter)) {
            *place = text;
        }
    }

    /// Whether a code is on the line and no other code takes a letter.
    pub(crate) fn only_user_of(&self, code: Code, letter: u8) -> bool {
        let mut there = false;
        for used in &self.codes {
            there |= used.row.code == code;
            if used.row.code != code && used.row.takes & bit(letter) != 0 {
                return false;
            }
        }
        there
    }

    /// Puts a code of the same group in the place of another.
    pub(crate) fn replace(&mut self, old: Code, new: Code) {
        let Some(row) = find(new) else { return };
        for used in self.codes.iter_mut().filter(|used| used.row.code == old) {
            used.row = row;
        }
    }

    /// Takes a letter out.
    pub(crate) fn drop_word(&mut self, letter: u8) {
        self.mask &= !bit(letter);
    }

    /// Takes the motion code out.
    pub(crate) fn drop_motion(&mut self) {
        self.codes.retain(|used| used.row.group != Group::Motion);
    }

    /// Adds a word.
    pub(crate) fn add(&mut self, letter: u8, value: f64, text: Text) -> Result<(), Problem> {
        if letter == b'G' || letter == b'M' {
            return self.add_code(letter, value, text);
        }
        // One value a letter: two X words on a line contradict each other.
        if self.has(letter) {
            return Err(Problem::RepeatedWord {
                letter: char::from(letter),
            });
        }
        self.mask |= bit(letter);
        let slot = slot(letter);
        if let (Some(kept), Some(place)) = (self.values.get_mut(slot), self.texts.get_mut(slot)) {
            *kept = value;
            *place = text;
        }
        Ok(())
    }

    fn add_code(&mut self, letter: u8, value: f64, text: Text) -> Result<(), Problem> {
        let letter = char::from(letter);
        let code = Code::of(letter, value).ok_or(Problem::NotACode { letter, value })?;
        let row = find(code).ok_or(Problem::UnsupportedCode { code })?;
        // A code of other controls needs its leniency; that it was taken is told once the block
        // runs.
        if let Some(leniency) = row.leniency {
            if !self.accepted.has(leniency) {
                return Err(Problem::UnsupportedCode { code });
            }
            self.taken = Some(leniency);
        }
        // G80 beside a motion code is harmless and common.
        if row.group == Group::Motion && self.replaces_motion(row) {
            return Ok(());
        }
        // Codes of one modal group exclude each other.
        if let Some(other) = self
            .codes
            .iter()
            .find(|used| used.row.group == row.group && used.row.code.letter == letter)
        {
            return Err(Problem::ModalConflict {
                first: other.row.code,
                second: code,
                group: row.group.name(),
            });
        }
        if self.codes.len() >= MOST_CODES {
            return Err(Problem::TooManyWords { limit: MOST_CODES });
        }
        // Kept in the order of execution, whatever the order on the line.
        let at = self
            .codes
            .iter()
            .position(|used| used.row.phase > row.phase)
            .unwrap_or(self.codes.len());
        self.codes.insert(at, UsedCode { row, text });
        Ok(())
    }

    /// G80 may stand beside another motion code and then means nothing: true if the new code is
    /// that G80. If the G80 came first, it is taken out.
    fn replaces_motion(&mut self, new: &CodeRow) -> bool {
        let Some(at) = self
            .codes
            .iter()
            .position(|used| used.row.group == Group::Motion)
        else {
            return false;
        };
        if new.code == G80 {
            return true;
        }
        if self.codes.get(at).is_some_and(|used| used.row.code == G80) {
            self.codes.remove(at);
        }
        false
    }
}

/// The whole number within bounds that a word of a code stands for.
pub(crate) fn whole_within(
    (code, letter): (Code, u8),
    value: f64,
    bounds: impl RangeBounds<f64>,
    allowed: &'static str,
) -> Result<f64, Problem> {
    let number = whole(value).filter(|number| bounds.contains(number));
    number.ok_or(Problem::WordOutOfRange {
        code,
        letter: char::from(letter),
        value,
        allowed,
    })
}

/// Words that need no code.
const FREE_LETTERS: u32 = bit(b'F') | bit(b'S') | bit(b'T');
const ARC_CENTER_BITS: u32 = bit(b'I') | bit(b'J') | bit(b'K');
const CORNER_BITS: u32 = bit(b'r') | bit(b'c');
const POLAR_BITS: u32 = bit(b'@') | bit(b'^');

/// A problem with the place of the word that has it.
pub(crate) type Placed = (Problem, Option<Text>);

/// Finds the motion of the block and checks that every word is used.
pub(crate) fn check(words: &mut Words, state: &State) -> Result<(), Placed> {
    find_motion(words, state)?;
    // Collect the letters that the codes of the block use; what is left over is an error.
    let mut taken = if state.motion_unknown {
        !0
    } else {
        FREE_LETTERS | words.free
    };
    // `$` says which spindle the S is for.
    if words.has(b'S') {
        // Which spindle the speed is for.
        taken |= bit(b'$');
    }
    for used in words.codes() {
        taken |= used.row.takes;
        if used.row.axes != AxisUse::None {
            taken |= AXIS_BITS;
        }
    }
    if let Some(row) = words.motion {
        taken |= row.takes | AXIS_BITS | POLAR_BITS;
        if row.code.tenths == 10 {
            taken |= CORNER_BITS;
        }
        if row.code.tenths <= 10 && state.tip_control == TipControl::WithVector {
            taken |= ARC_CENTER_BITS;
        }
    }
    // Each letter has to be taken by a code: a forgotten code would otherwise go unnoticed.
    let unused = words.mask & !taken;
    if unused == 0 {
        return Ok(());
    }
    // The first unused letter is reported, with the codes that would take it.
    let letter = (b'@'..=b'^')
        .chain(*b"$rc")
        .find(|&letter| unused & bit(letter) != 0)
        .unwrap_or(b'?');
    let value = words.get(letter).unwrap_or_default();
    let letter_char = char::from(letter);
    Err((
        Problem::UnusedWord {
            letter: letter_char,
            value,
            users: if letter == b'E' && words.is_exponent() {
                format!(
                    "{}; an exponent needs its sign (1E+3), or --dialect fanuc",
                    users(letter_char)
                )
            } else {
                users(letter_char)
            },
        },
        Some(words.text(letter)),
    ))
}

fn find_motion(words: &mut Words, state: &State) -> Result<(), Placed> {
    let has_axes = words.mask & (AXIS_BITS | POLAR_BITS) != 0;
    // Axis words can belong to a motion code or to one other code such as G92, not to both.
    let explicit = words
        .codes()
        .iter()
        .find(|used| used.row.group == Group::Motion)
        .copied();
    let other = words
        .codes()
        .iter()
        .find(|used| used.row.group != Group::Motion && used.row.axes != AxisUse::None)
        .copied();
    if let Some(other) = other {
        if words.mask & POLAR_BITS != 0 {
            return Err((
                Problem::PolarWithoutMotion {
                    code: other.row.code,
                },
                Some(other.text),
            ));
        }
        check_user(other, has_axes)?;
    }
    match (explicit, other) {
        (Some(motion), Some(other)) if motion.row.axes != AxisUse::None => {
            return Err((
                Problem::TwoAxisUsers {
                    code: other.row.code,
                    other: motion.row.code,
                },
                Some(motion.text),
            ));
        }
        // G80 and G5.3 move nothing: axis words beside them are mistakes.
        (Some(motion), None) if has_axes && motion.row.axes == AxisUse::None => {
            return Err((
                Problem::AxesNotAllowed {
                    code: motion.row.code,
                },
                Some(motion.text),
            ));
        }
        (Some(motion), _) => {
            if motion.row.axes == AxisUse::Needs && !has_axes {
                return Err((
                    Problem::AxesMissing {
                        code: motion.row.code,
                    },
                    Some(motion.text),
                ));
            }
            words.motion = Some(motion.row);
        }
        (None, Some(_)) => {}
        (None, None) => words.motion = modal_motion(words, state, has_axes)?,
    }
    Ok(())
}

fn check_user(user: UsedCode, has_axes: bool) -> Result<(), Placed> {
    if user.row.axes == AxisUse::Needs && !has_axes {
        return Err((
            Problem::AxesMissing {
                code: user.row.code,
            },
            Some(user.text),
        ));
    }
    Ok(())
}

/// The motion mode in force, if the block's words call for motion.
fn modal_motion(
    words: &Words,
    state: &State,
    has_axes: bool,
) -> Result<Option<&'static crate::codes::CodeRow>, Placed> {
    let modal = state.motion.and_then(find);
    // I, J and K alone repeat a full circle in the arc modes; other modes need an axis word.
    let is_arc = matches!(
        state.motion,
        Some(Code {
            letter: 'G',
            tenths: 20 | 30
        })
    );
    if has_axes {
        let axis = super::words::AXIS_LETTERS
            .into_iter()
            .chain(*b"@^")
            .find(|&letter| words.has(letter));
        return match modal {
            Some(row) => Ok(Some(row)),
            _ if state.motion_unknown => Ok(None),
            _ => Err((
                Problem::AxisWithoutCode,
                axis.map(|letter| words.text(letter)),
            )),
        };
    }
    Ok(if is_arc && words.mask & ARC_CENTER_BITS != 0 {
        modal
    } else {
        None
    })
}
