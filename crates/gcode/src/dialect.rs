//! Dialects: the G-code of other controls, as named leniencies that can be switched one by one.
//!
//! The base is RS274/NGC as LinuxCNC 2.9 reads it. A [`Leniency`] accepts one thing more, and says
//! so with a warning of its own code the first time. A [`Dialect`] is a set of leniencies, and how
//! a few words are meant that controls disagree about.

use crate::finding::{Severity, severity};
use Dialect::{Fanuc, Haas, Klipper, LinuxCnc, Marlin, Siemens};
use serde::{Deserialize, Serialize};

/// Whose G-code a program is in.
///
/// ```
/// use lostmotion_gcode::{Dialect, InterpreterConfig, Leniency, Program};
///
/// let text = b"G21 G1 X#1 F200\n#1=3+4\nM30\n";
/// let errors = |config| Program::new(&text[..], config).finish().errors();
/// assert_eq!(errors(InterpreterConfig::default()), 1);
/// let fanuc = InterpreterConfig::default().with_dialect(Dialect::Fanuc);
/// assert!(fanuc.leniencies.has(Leniency::BareArithmetic));
/// assert_eq!(errors(fanuc), 0);
/// ```
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
    /// Sinumerik: blocks of plain G-code are read, those of its own are recognised and refused.
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

    /// The words that select a work coordinate system: 1 for G54 to 9 for G59.3, 10 on for
    /// those beyond (G54.1 P, at Haas G154 P).
    ///
    /// ```
    /// use lostmotion_gcode::Dialect;
    ///
    /// assert_eq!(Dialect::LinuxCnc.system_name(9), "G59.3");
    /// assert_eq!(Dialect::Fanuc.system_name(10), "G54.1 P1");
    /// assert_eq!(Dialect::Haas.system_name(108), "G154 P99");
    /// ```
    pub fn system_name(self, system: u16) -> String {
        match (system, self) {
            (0..=6, _) => format!("G{}", 53 + system.max(1)),
            (7..=9, _) => format!("G59.{}", system - 6),
            (_, Dialect::Haas) => format!("G154 P{}", system - 9),
            _ => format!("G54.1 P{}", system - 9),
        }
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

/// Makes the enum of leniencies and what is known about each.
macro_rules! leniencies {
    ($(
        $(#[$doc:meta])*
        $leniency:ident => $severity:ident $name:literal, $dialects:expr, $meaning:literal
        $(, remedy $remedy:literal)?;
    )*) => {
        /// One thing that is accepted with a warning although RS274/NGC does not have it.
        #[derive(
            Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
        )]
        #[serde(rename_all = "kebab-case")]
        #[non_exhaustive]
        pub enum Leniency {
            $($(#[$doc])* $leniency,)*
        }

        /// All leniencies, in the order of their bits.
        pub const LENIENCIES: [Leniency; [$($name),*].len()] = [$(Leniency::$leniency),*];

        impl Leniency {
            /// Its name, which is also the code of its warning.
            pub const fn name(self) -> &'static str {
                match self {
                    $(Leniency::$leniency => $name,)*
                }
            }

            /// What is accepted.
            pub const fn meaning(self) -> &'static str {
                match self {
                    $(Leniency::$leniency => $meaning,)*
                }
            }

            /// The dialects that have it on.
            pub const fn dialects(self) -> &'static [Dialect] {
                match self {
                    $(Leniency::$leniency => $dialects,)*
                }
            }

            /// How the use of it is told: habits of writing that controls agree about are notes.
            pub const fn severity(self) -> Severity {
                match self {
                    $(Leniency::$leniency => severity!($severity),)*
                }
            }

            /// What makes a habit go away; `None` for those that need no change.
            pub(crate) const fn remedy(self) -> Option<&'static str> {
                match self {
                    $($(Leniency::$leniency => Some($remedy),)?)*
                    _ => None,
                }
            }

            /// The leniency of a name.
            pub fn from_name(name: &str) -> Option<Leniency> {
                LENIENCIES
                    .into_iter()
                    .find(|leniency| leniency.name() == name)
            }
        }
    };
}

// One entry for each. The order is that of the bits in `Leniencies`: new ones come last.
leniencies! {
    /// A program that ends without M2, M30 or its closing %.
    MissingEnd => warning "no-program-end", EVERY,
        "the program ends without M2, M30 or its closing %";
    /// A byte order mark at the start.
    ByteOrderMark => warning "byte-order-mark", EVERY,
        "a byte order mark at the start is skipped";
    /// `X1.2E-12`.
    Exponents => warning "exponent", CONTROLS,
        "a number with an exponent";
    /// `G0 G28 Z0`: the motion code beside a code that takes the axis words.
    ExtraMotion => warning "extra-motion", CONTROLS,
        "a motion code beside a code that takes its axis words only sets the mode";
    /// `G17 G2 ... K0`: an offset of zero along the plane's normal.
    OffPlaneZero => warning "off-plane-zero", EVERY,
        "an arc offset of zero along the plane's normal is ignored";
    /// P in G73 and G83.
    PeckDwell => warning "peck-dwell", CONTROLS,
        "P in G73 and G83, which do not dwell";
    /// Lines that end with CR alone.
    BareReturns => warning "bare-return", EVERY,
        "lines that end with CR alone";
    /// `g1 x10` where controls want capitals.
    LowerCase => note "lower-case", EVERY,
        "letters of words in lower case",
        remedy "`lostmotion gcode format` puts it right";
    /// G43.4, G43.5, G53.1, G68, G68.2, G69.
    FiveAxis => warning "five-axis", FANUC,
        "five-axis codes of other controls";
    /// `#1=#2+3`: arithmetic without brackets.
    BareArithmetic => warning "bare-arithmetic", FANUC,
        "arithmetic without brackets after =";
    /// WHILE DO END, IF GOTO, IF THEN, GOTO.
    MacroFlow => warning "macro-flow", FANUC,
        "WHILE DO END, IF GOTO, IF THEN and GOTO of Macro B";
    /// G65, G66, G67: macros called with arguments by letter.
    MacroCalls => warning "macro-call", FANUC,
        "G65, G66 and G67 call macros with arguments by letter";
    /// `#0`, and parameters that have not been set: words with them are left out.
    Vacant => warning "vacant", FANUC,
        "#0 and parameters without a value are vacant: words with them are left out";
    /// `M98 P30100`: rounds and program in one number; M99 P.
    PackedCalls => warning "packed-call", FANUC,
        "rounds and program in the P of one M98, or a line in that of M99";
    /// `,R2` and `,C2`: corners rounded and chamfered.
    CornerWords => warning "corner-word", FANUC,
        "a corner rounded by ,R or chamfered by ,C";
    /// G10 L10 to L13 with R, as Fanuc's tool memories.
    ToolMemory => warning "tool-memory", FANUC,
        "G10 L10 to L13 with R set length and radius of a tool";
    /// M97: subroutines at a line number of the same program.
    LocalCalls => warning "local-call", &[Haas],
        "M97 calls the lines from an N number on";
    /// G12, G13: circular pockets.
    CircularPockets => warning "circular-pocket", &[Haas],
        "G12 and G13 cut circular pockets";
    /// G70, G71, G72: bolt circle, arc and line.
    HolePatterns => warning "hole-pattern", &[Haas],
        "G70, G71 and G72 are patterns of holes";
    /// E words of an extruder.
    ExtruderWords => warning "extruder-word", PRINTERS,
        "E words of an extruder are ignored";
    /// Codes of printers that do not move the axes, such as M104 and G29.
    PrinterCodes => warning "printer-code", PRINTERS,
        "codes of printers that do not move the axes are skipped";
    /// `M117 Hello` and extended commands with names.
    StringCommands => warning "string-command", PRINTERS,
        "commands with text are skipped";
    /// `N5 G1 X1*87`.
    Checksums => warning "checksum", PRINTERS,
        "checksums are verified and left out";
    /// `G28 X Y`: letters without numbers.
    BareLetters => warning "bare-letter", PRINTERS,
        "an axis letter without a number counts as 0";
    /// `G1X10Y5`: words without blanks between them.
    NoBlanks => note "no-blanks", EVERY,
        "words without blanks between them",
        remedy "`lostmotion gcode format` puts it right";
    /// Lines that end with CR LF.
    CrLf => note "crlf", EVERY,
        "lines that end with CR LF";
    /// U, V and W: axes beside X, Y and Z.
    SecondaryAxes => note "uvw-axes", EVERY,
        "axes U, V and W, which most machines do not have";
    /// Lines longer than LinuxCNC reads.
    LongLines => warning "long-line", EVERY,
        "a line of more than 255 bytes",
        remedy "LinuxCNC refuses it: split it, or shorten its comment";
    /// Codes of controls that change no path: high-speed modes (G5.1 Q1, G8 P1, G187), look-ahead
    /// (G103), the ends of modes that never began (G15, G50, G50.1).
    IgnoredCodes => warning "ignored-code", FANUC,
        "a code of the control that changes no path is skipped";
    /// G70 under G41 and G42 goes to the end of its profile first.
    FinishDetour => warning "finish-detour", &[LinuxCnc],
        "G70 under cutter compensation goes to the end of its profile first; refused, it does not";
    /// `#<n>=[#<n>+1]` counts from 0.
    ReadBeforeSet => warning "read-before-set", &[LinuxCnc],
        "a name that reads itself in its first setting counts from 0";
    /// `G54.1 P1`, `G154 P1`, `G110`.
    ExtraSystems => warning "extra-system", FANUC,
        "G54.1 P, G154 P and G110 to G129 are work coordinate systems beyond G59";
    /// K (Fanuc) and L of canned cycles, 0 included.
    CycleRepeats => note "cycle-repeats", FANUC,
        "K or L repeats a canned cycle; K0 and L0 store its words and make no hole";
    /// `/2 G0 X1`.
    NumberedSkip => note "numbered-skip", FANUC,
        "a number after the / of block delete";
    /// `:0001` for `O0001`.
    ColonNumbers => note "colon-number", FANUC,
        "a program number after a colon instead of O";
    /// G44: a tool length that is subtracted.
    NegativeLength => note "negative-length", FANUC,
        "G44 subtracts the tool's length";
    /// SAVE_GCODE_STATE, RESTORE_GCODE_STATE, SET_GCODE_OFFSET.
    GcodeStates => note "gcode-state", &[Klipper],
        "SAVE_GCODE_STATE, RESTORE_GCODE_STATE and SET_GCODE_OFFSET are carried out";
    /// Blocks for a Sinumerik that have nothing of its own.
    PlainSiemens => note "plain-siemens", &[Siemens],
        "blocks for Siemens (Sinumerik) that have nothing of its own are read as plain G-code";
}

/// A set of leniencies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Leniencies(u64);

impl Leniencies {
    /// Whether something is accepted.
    pub const fn has(self, leniency: Leniency) -> bool {
        self.0 & (1 << leniency as u64) != 0
    }

    /// The same with one more.
    #[must_use]
    pub const fn with(self, leniency: Leniency) -> Leniencies {
        Leniencies(self.0 | 1 << leniency as u64)
    }

    /// The same with one less.
    #[must_use]
    pub const fn without(self, leniency: Leniency) -> Leniencies {
        Leniencies(self.0 & !(1 << leniency as u64))
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
