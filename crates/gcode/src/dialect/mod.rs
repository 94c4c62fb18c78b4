//! Dialects: the G-code of other controls, as named leniencies that can be switched one by one.
//!
//! The base is RS274/NGC as LinuxCNC 2.9 reads it. A [`Leniency`] accepts one thing more, and says
//! so with a warning of its own code the first time. A [`Dialect`] is a set of leniencies, and how
//! a few words are meant that controls disagree about.

use crate::severity::Severity;
use Dialect::{Fanuc, Haas, Klipper, LinuxCnc, Marlin, Siemens};
use serde::{Deserialize, Serialize};

/// Whose G-code a program is in.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
#[serde(rename_all = "lowercase")]
pub enum Dialect {
    /// RS274/NGC.
    #[default]
    LinuxCnc,
    /// Fanuc with Macro B; P of G4 and of cycles is in milliseconds.
    Fanuc,
    /// Fanuc with the pockets and hole patterns of Haas; P without a decimal point is in
    /// milliseconds.
    Haas,
    /// Printers with Marlin; P of G4 is in milliseconds, S in seconds.
    Marlin,
    /// Printers with Klipper.
    Klipper,
    /// Sinumerik: recognised, and refused.
    Siemens,
}

impl Dialect {
    /// All of them.
    pub const ALL: [Dialect; 6] = [
        Dialect::LinuxCnc,
        Dialect::Fanuc,
        Dialect::Haas,
        Dialect::Marlin,
        Dialect::Klipper,
        Dialect::Siemens,
    ];

    /// Its name on command lines and in machine files.
    pub const fn name(self) -> &'static str {
        match self {
            Dialect::LinuxCnc => "linuxcnc",
            Dialect::Fanuc => "fanuc",
            Dialect::Haas => "haas",
            Dialect::Marlin => "marlin",
            Dialect::Klipper => "klipper",
            Dialect::Siemens => "siemens",
        }
    }

    /// The dialect of a name.
    pub fn from_name(name: &str) -> Option<Dialect> {
        Dialect::ALL
            .into_iter()
            .find(|dialect| dialect.name() == name)
    }

    /// What it accepts beyond RS274/NGC.
    pub fn leniencies(self) -> Leniencies {
        LENIENCIES
            .iter()
            .copied()
            .filter(|leniency| leniency.dialects().contains(&self))
            .collect()
    }

    /// Whether it is for printers.
    pub const fn is_printer(self) -> bool {
        matches!(self, Dialect::Marlin | Dialect::Klipper)
    }

    /// Whether it is of the family of Fanuc.
    pub const fn is_fanuc(self) -> bool {
        matches!(self, Dialect::Fanuc | Dialect::Haas)
    }
}

impl std::fmt::Display for Dialect {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name())
    }
}

const EVERY: &[Dialect] = &[LinuxCnc, Fanuc, Haas, Marlin, Klipper, Siemens];
const CONTROLS: &[Dialect] = &[LinuxCnc, Fanuc, Haas];
const FANUC: &[Dialect] = &[Fanuc, Haas];
const PRINTERS: &[Dialect] = &[Marlin, Klipper];

/// One thing that is accepted with a warning although RS274/NGC does not have it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum Leniency {
    /// A program that ends without M2, M30 or its closing %.
    MissingEnd,
    /// A byte order mark at the start.
    ByteOrderMark,
    /// `X1.2E-12`.
    Exponents,
    /// `G0 G28 Z0`: the motion code beside a code that takes the axis words.
    ExtraMotion,
    /// `G17 G2 ... K0`: an offset of zero along the plane's normal.
    OffPlaneZero,
    /// P in G73 and G83.
    PeckDwell,
    /// Lines that end with CR alone.
    BareReturns,
    /// `g1 x10` where controls want capitals.
    LowerCase,
    /// G43.4, G43.5, G53.1, G68, G68.2, G69.
    FiveAxis,
    /// `#1=#2+3`: arithmetic without brackets.
    BareArithmetic,
    /// WHILE DO END, IF GOTO, IF THEN, GOTO.
    MacroFlow,
    /// G65, G66, G67: macros called with arguments by letter.
    MacroCalls,
    /// `#0`, and parameters that have not been set: words with them are left out.
    Vacant,
    /// `M98 P30100`: rounds and program in one number; M99 P.
    PackedCalls,
    /// `,R2` and `,C2`: corners rounded and chamfered.
    CornerWords,
    /// G10 L10 to L13 with R, as Fanuc's tool memories.
    ToolMemory,
    /// M97: subroutines at a line number of the same program.
    LocalCalls,
    /// G12, G13: circular pockets.
    CircularPockets,
    /// G70, G71, G72: bolt circle, arc and line.
    HolePatterns,
    /// E words of an extruder.
    ExtruderWords,
    /// Codes of printers that do not move the axes, such as M104 and G29.
    PrinterCodes,
    /// `M117 Hello` and extended commands with names.
    StringCommands,
    /// `N5 G1 X1*87`.
    Checksums,
    /// `G28 X Y`: letters without numbers.
    BareLetters,
    /// `G1X10Y5`: words without blanks between them.
    NoBlanks,
    /// Lines that end with CR LF.
    CrLf,
    /// U, V and W: axes beside X, Y and Z.
    SecondaryAxes,
    /// Lines longer than LinuxCNC reads.
    LongLines,
    /// Codes of controls that change no path: high-speed modes (G5.1 Q1, G8 P1, G187), look-ahead
    /// (G103), the ends of modes that never began (G15, G50, G50.1).
    IgnoredCodes,
    /// G70 under G41 and G42 goes to the end of its profile first.
    FinishDetour,
    /// `#<n>=[#<n>+1]` counts from 0.
    ReadBeforeSet,
}

/// All leniencies, in the order of their bits.
pub const LENIENCIES: [Leniency; 31] = [
    Leniency::MissingEnd,
    Leniency::ByteOrderMark,
    Leniency::Exponents,
    Leniency::ExtraMotion,
    Leniency::OffPlaneZero,
    Leniency::PeckDwell,
    Leniency::BareReturns,
    Leniency::LowerCase,
    Leniency::FiveAxis,
    Leniency::BareArithmetic,
    Leniency::MacroFlow,
    Leniency::MacroCalls,
    Leniency::Vacant,
    Leniency::PackedCalls,
    Leniency::CornerWords,
    Leniency::ToolMemory,
    Leniency::LocalCalls,
    Leniency::CircularPockets,
    Leniency::HolePatterns,
    Leniency::ExtruderWords,
    Leniency::PrinterCodes,
    Leniency::StringCommands,
    Leniency::Checksums,
    Leniency::BareLetters,
    Leniency::NoBlanks,
    Leniency::CrLf,
    Leniency::SecondaryAxes,
    Leniency::LongLines,
    Leniency::IgnoredCodes,
    Leniency::FinishDetour,
    Leniency::ReadBeforeSet,
];

impl Leniency {
    /// Its name, which is also the code of its warning.
    pub const fn name(self) -> &'static str {
        self.row().0
    }

    /// What is accepted.
    pub const fn meaning(self) -> &'static str {
        self.row().1
    }

    /// The dialects that have it on.
    pub const fn dialects(self) -> &'static [Dialect] {
        self.row().2
    }

    /// How the use of it is told: habits of writing that controls agree about are notes.
    pub const fn severity(self) -> Severity {
        match self {
            Leniency::LowerCase | Leniency::NoBlanks | Leniency::CrLf | Leniency::SecondaryAxes => {
                Severity::Note
            }
            _ => Severity::Warning,
        }
    }

    /// What makes a habit go away; none for those that are not to be mended.
    pub(crate) const fn remedy(self) -> Option<&'static str> {
        match self {
            Leniency::LowerCase | Leniency::NoBlanks => Some("`lostmotion format` puts it right"),
            Leniency::LongLines => Some("LinuxCNC refuses it: split it, or shorten its comment"),
            _ => None,
        }
    }

    /// The leniency of a name.
    pub fn from_name(name: &str) -> Option<Leniency> {
        LENIENCIES
            .into_iter()
            .find(|leniency| leniency.name() == name)
    }

    const fn row(self) -> (&'static str, &'static str, &'static [Dialect]) {
        match self {
            Leniency::MissingEnd => (
                "no-program-end",
                "the program ends without M2, M30 or its closing %",
                EVERY,
            ),
            Leniency::ByteOrderMark => (
                "byte-order-mark",
                "a byte order mark at the start is skipped",
                EVERY,
            ),
            Leniency::Exponents => ("exponent", "a number with an exponent", CONTROLS),
            Leniency::ExtraMotion => (
                "extra-motion",
                "a motion code beside a code that takes its axis words only sets the mode",
                CONTROLS,
            ),
            Leniency::OffPlaneZero => (
                "off-plane-zero",
                "an arc offset of zero along the plane's normal is ignored",
                EVERY,
            ),
            Leniency::PeckDwell => (
                "peck-dwell",
                "P in G73 and G83, which do not dwell",
                CONTROLS,
            ),
            Leniency::BareReturns => ("bare-return", "lines that end with CR alone", EVERY),
            Leniency::LowerCase => ("lower-case", "letters of words in lower case", EVERY),
            Leniency::FiveAxis => ("five-axis", "five-axis codes of other controls", FANUC),
            Leniency::BareArithmetic => (
                "bare-arithmetic",
                "arithmetic without brackets after =",
                FANUC,
            ),
            Leniency::MacroFlow => (
                "macro-flow",
                "WHILE DO END, IF GOTO, IF THEN and GOTO of Macro B",
                FANUC,
            ),
            Leniency::MacroCalls => (
                "macro-call",
                "G65, G66 and G67 call macros with arguments by letter",
                FANUC,
            ),
            Leniency::Vacant => (
                "vacant",
                "#0 and parameters without a value are vacant: words with them are left out",
                FANUC,
            ),
            Leniency::PackedCalls => (
                "packed-call",
                "rounds and program in the P of one M98, or a line in that of M99",
                FANUC,
            ),
            Leniency::CornerWords => (
                "corner-word",
                "a corner rounded by ,R or chamfered by ,C",
                FANUC,
            ),
            Leniency::ToolMemory => (
                "tool-memory",
                "G10 L10 to L13 with R set length and radius of a tool",
                FANUC,
            ),
            Leniency::LocalCalls => (
                "local-call",
                "M97 calls the lines from an N number on",
                &[Haas],
            ),
            Leniency::CircularPockets => (
                "circular-pocket",
                "G12 and G13 cut circular pockets",
                &[Haas],
            ),
            Leniency::HolePatterns => (
                "hole-pattern",
                "G70, G71 and G72 are patterns of holes",
                &[Haas],
            ),
            Leniency::ExtruderWords => (
                "extruder-word",
                "E words of an extruder are ignored",
                PRINTERS,
            ),
            Leniency::PrinterCodes => (
                "printer-code",
                "codes of printers that do not move the axes are skipped",
                PRINTERS,
            ),
            Leniency::StringCommands => {
                ("string-command", "commands with text are skipped", PRINTERS)
            }
            Leniency::Checksums => ("checksum", "checksums are verified and left out", PRINTERS),
            Leniency::BareLetters => (
                "bare-letter",
                "an axis letter without a number counts as 0",
                PRINTERS,
            ),
            Leniency::NoBlanks => ("no-blanks", "words without blanks between them", EVERY),
            Leniency::CrLf => ("crlf", "lines that end with CR LF", EVERY),
            Leniency::SecondaryAxes => (
                "uvw-axes",
                "axes U, V and W, which most machines do not have",
                EVERY,
            ),
            Leniency::LongLines => ("long-line", "a line of more than 255 bytes", EVERY),
            Leniency::FinishDetour => (
                "finish-detour",
                "G70 under cutter compensation goes to the end of its profile first; refused, it does not",
                &[LinuxCnc],
            ),
            Leniency::ReadBeforeSet => (
                "read-before-set",
                "a name that reads itself in its first setting counts from 0",
                &[LinuxCnc],
            ),
            Leniency::IgnoredCodes => (
                "ignored-code",
                "a code of the control that changes no path is skipped",
                FANUC,
            ),
        }
    }
}

/// A set of leniencies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Leniencies(u32);

impl Leniencies {
    /// Whether something is accepted.
    pub const fn has(self, leniency: Leniency) -> bool {
        self.0 & (1 << leniency as u32) != 0
    }

    /// The same with one more.
    #[must_use]
    pub const fn with(self, leniency: Leniency) -> Leniencies {
        Leniencies(self.0 | 1 << leniency as u32)
    }

    /// The same with one less.
    #[must_use]
    pub const fn without(self, leniency: Leniency) -> Leniencies {
        Leniencies(self.0 & !(1 << leniency as u32))
    }
}

impl FromIterator<Leniency> for Leniencies {
    fn from_iter<I: IntoIterator<Item = Leniency>>(leniencies: I) -> Leniencies {
        leniencies
            .into_iter()
            .fold(Leniencies::default(), Leniencies::with)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_leniency_has_its_own_bit_and_name() {
        let names: BTreeSet<&str> = LENIENCIES.iter().map(|leniency| leniency.name()).collect();
        assert_eq!(names.len(), LENIENCIES.len());
        for (bit, leniency) in LENIENCIES.into_iter().enumerate() {
            assert_eq!(leniency as usize, bit);
            assert_eq!(Leniency::from_name(leniency.name()), Some(leniency));
            let only: Leniencies = [leniency].into_iter().collect();
            assert!(only.has(leniency) && only.without(leniency) == Leniencies::default());
        }
        assert!(!Dialect::LinuxCnc.leniencies().has(Leniency::FiveAxis));
        assert!(Dialect::Fanuc.leniencies().has(Leniency::FiveAxis));
    }
}
