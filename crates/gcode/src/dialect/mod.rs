//! Dialects: the G-code of other controls, as named leniencies that can be switched one by one.
//!
//! The base is RS274/NGC as LinuxCNC 2.9 reads it. A [`Leniency`] accepts one thing more, and says
//! so with a warning of its own code the first time. A [`Dialect`] is a set of leniencies, and how
//! a few words are meant that controls disagree about.

mod leniency;

pub use leniency::{LENIENCIES, Leniencies, Leniency};

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
