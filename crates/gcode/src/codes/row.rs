//! A code as it stands in a program, and what is known about it.

use crate::dialect::Leniency;
use serde::{Deserialize, Serialize};
use std::fmt;

/// Modal groups: one line may have one code of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[allow(missing_docs, reason = "see Group::name")]
pub enum Group {
    FeedMode,
    SpindleMode,
    Output,
    ToolChange,
    Spindle,
    ModalState,
    Coolant,
    Override,
    Plane,
    Units,
    Diameter,
    CutterCompensation,
    ToolLength,
    CoordinateSystem,
    PathControl,
    Distance,
    ArcDistance,
    Retract,
    NonModal,
    AxisOffset,
    Motion,
    Stop,
}

impl Group {
    /// What the codes of the group set.
    pub const fn name(self) -> &'static str {
        match self {
            Group::FeedMode => "feed mode",
            Group::SpindleMode => "spindle mode",
            Group::Output => "output",
            Group::ToolChange => "tool",
            Group::Spindle => "spindle",
            Group::ModalState => "saved state",
            Group::Coolant => "coolant",
            Group::Override => "overrides",
            Group::Plane => "plane",
            Group::Units => "units",
            Group::Diameter => "diameter mode",
            Group::CutterCompensation => "cutter compensation",
            Group::ToolLength => "tool length offset",
            Group::CoordinateSystem => "coordinate system",
            Group::PathControl => "path control",
            Group::Distance => "distance mode",
            Group::ArcDistance => "arc centre mode",
            Group::Retract => "retract mode",
            Group::NonModal => "action of the line",
            Group::AxisOffset => "axis offset",
            Group::Motion => "motion mode",
            Group::Stop => "program stop",
        }
    }
}

/// What a code does with axis words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisUse {
    /// Leaves them to others.
    None,
    /// May use them.
    May,
    /// Has to have at least one.
    Needs,
}

/// One code.
#[derive(Clone, Copy)]
pub struct CodeRow {
    /// The code.
    pub code: Code,
    /// Its modal group.
    pub group: Group,
    /// Order of execution within a block, lowest first, whatever the order on the line.
    pub(crate) phase: u8,
    /// What it does with axis words.
    pub axes: AxisUse,
    /// Letters it takes besides axis words, F, S and T.
    pub words: &'static str,
    /// The same as bits.
    pub(crate) takes: u32,
    /// Leniency that it needs; `None` for the codes of RS274/NGC.
    pub leniency: Option<Leniency>,
    /// What it does.
    pub meaning: &'static str,
    /// A line that uses it.
    pub example: &'static str,
    /// Name of its sample program.
    pub sample: &'static str,
}

impl std::fmt::Debug for CodeRow {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.code, self.meaning)
    }
}

/// Phases of words that are not codes.
pub(crate) const PHASE_F: u8 = 10;
pub(crate) const PHASE_S: u8 = 20;
pub(crate) const PHASE_T: u8 = 30;
/// Phase of motion.
pub(crate) const PHASE_MOTION: u8 = 230;
/// G4 comes long before the other codes of its group.
const PHASE_DWELL: u8 = 100;

const fn phase(group: Group) -> u8 {
    match group {
        Group::FeedMode => 5,
        Group::SpindleMode => 15,
        Group::Output => 40,
        Group::ToolChange => 50,
        Group::Spindle => 60,
        Group::ModalState => 70,
        Group::Coolant => 80,
        Group::Override => 90,
        Group::Plane => 110,
        Group::Units => 120,
        Group::Diameter => 130,
        Group::CutterCompensation => 140,
        Group::ToolLength => 150,
        Group::CoordinateSystem => 160,
        Group::PathControl => 170,
        Group::Distance => 180,
        Group::ArcDistance => 190,
        Group::Retract => 200,
        Group::NonModal => 220,
        Group::AxisOffset => 225,
        Group::Motion => PHASE_MOTION,
        Group::Stop => 240,
    }
}

/// Bit of a letter; letters without one are never words.
pub(crate) const fn bit(letter: u8) -> u32 {
    match letter {
        b'A'..=b'Z' => 1 << (letter - b'A'),
        b'@' => 1 << 26,
        b'^' => 1 << 27,
        b'$' => 1 << 28,
        // `,R` and `,C` of other dialects.
        b'r' => 1 << 29,
        b'c' => 1 << 30,
        _ => 0,
    }
}

const fn bits(letters: &str) -> u32 {
    let bytes = letters.as_bytes();
    let (mut mask, mut at) = (0, 0);
    // A `for` loop is not allowed in const functions.
    while at < bytes.len() {
        mask |= bit(bytes[at]);
        at += 1;
    }
    mask
}

impl CodeRow {
    /// The same for a code of other dialects.
    pub(crate) const fn only_with(self, leniency: Leniency) -> CodeRow {
        CodeRow {
            leniency: Some(leniency),
            ..self
        }
    }
}

/// Texts of a row: meaning, example, sample.
pub(crate) type Texts = [&'static str; 3];

/// A row; `tenths` is ten times the number.
pub(crate) const fn row(
    letter: char,
    tenths: u16,
    group: Group,
    uses: (AxisUse, &'static str),
    texts: Texts,
) -> CodeRow {
    let [meaning, example, sample] = texts;
    // G4 waits once spindle and coolant have started, before planes and offsets change.
    let phase = if letter == 'G' && tenths == 40 {
        PHASE_DWELL
    } else {
        phase(group)
    };
    CodeRow {
        code: Code { letter, tenths },
        group,
        phase,
        axes: uses.0,
        words: uses.1,
        takes: bits(uses.1),
        leniency: None,
        meaning,
        example,
        sample,
    }
}

/// Largest difference between a value and the integer that it stands for, as in LinuxCNC's
/// interpreter.
const WHOLE_TOLERANCE: f64 = 1e-4;

/// The integer that a value stands for, where codes, tool numbers and counts are expected; `None`
/// if it is more than 0.0001 from one.
pub fn whole(value: f64) -> Option<f64> {
    let nearest = value.round();
    ((value - nearest).abs() <= WHOLE_TOLERANCE).then_some(nearest)
}

/// A G or M code as written: letter and number in tenths, `G59.1` is ('G', 591).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Code {
    /// 'G' or 'M'.
    pub letter: char,
    /// Ten times the number.
    pub tenths: u16,
}

impl Code {
    /// A G code from ten times its number.
    pub const fn g(tenths: u16) -> Code {
        Code {
            letter: 'G',
            tenths,
        }
    }

    /// An M code from ten times its number.
    pub const fn m(tenths: u16) -> Code {
        Code {
            letter: 'M',
            tenths,
        }
    }

    /// The code of a letter and number; `None` for numbers that no code has.
    pub fn of(letter: char, value: f64) -> Option<Code> {
        let tenths = whole(value * 10.0).filter(|tenths| (0.0..=65_535.0).contains(tenths))?;
        Some(Code {
            letter,
            tenths: tenths as u16,
        })
    }
}

impl fmt::Display for Code {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.letter, self.tenths / 10)?;
        if self.tenths.is_multiple_of(10) {
            Ok(())
        } else {
            write!(f, ".{}", self.tenths % 10)
        }
    }
}
