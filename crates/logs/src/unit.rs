//! Units of channels: how controls and people write them, and what they are worth.

use std::f64::consts::TAU;
use std::fmt;
use std::str::FromStr;

/// What a channel measures.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quantity {
    /// A place along a line; mm.
    Length,
    /// An angle; rad.
    Angle,
    /// A time; s.
    Time,
    /// A speed along a line; mm/s.
    Speed,
    /// A speed of rotation; rad/s.
    Rotation,
    /// An acceleration; mm/s^2.
    Acceleration,
    /// An electric current; A.
    Current,
    /// A torque; N m.
    Torque,
    /// A force; N.
    Force,
    /// A voltage; V.
    Voltage,
    /// Parts of a rated value; %.
    Percent,
}

/// A unit that a channel can have.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// What it measures.
    pub quantity: Quantity,
    /// Units of the quantity in one of this unit.
    pub factor: f64,
    /// How it is written.
    pub symbol: &'static str,
}

const fn unit(quantity: Quantity, factor: f64, symbol: &'static str) -> Unit {
    Unit {
        quantity,
        factor,
        symbol,
    }
}

/// Every unit, with the ways it is written beside its symbol, in lower case.
const UNITS: &[(Unit, &[&str])] = &[
    (
        unit(Quantity::Length, 1.0, "mm"),
        &["millimeter", "millimetre"],
    ),
    (
        unit(Quantity::Length, 1e-3, "um"),
        &["µm", "μm", "micron", "microns"],
    ),
    (Unit::NM_LENGTH, &[]),
    (unit(Quantity::Length, 1e3, "m"), &["meter", "metre"]),
    (
        unit(Quantity::Length, 25.4, "inch"),
        &["in", "\"", "inches"],
    ),
    (
        unit(Quantity::Angle, TAU / 360.0, "deg"),
        &["°", "grad", "degree", "degrees"],
    ),
    (unit(Quantity::Angle, 1.0, "rad"), &[]),
    (
        unit(Quantity::Angle, TAU / 360.0 / 3600.0, "arcsec"),
        &["arc second", "arc seconds"],
    ),
    (unit(Quantity::Angle, TAU / 360_000.0, "mdeg"), &[]),
    (
        unit(Quantity::Angle, TAU, "rev"),
        &["revolution", "revolutions", "turn", "turns"],
    ),
    (
        unit(Quantity::Time, 1.0, "s"),
        &["sec", "second", "seconds"],
    ),
    (
        unit(Quantity::Time, 1e-3, "ms"),
        &["msec", "millisecond", "milliseconds"],
    ),
    (
        unit(Quantity::Time, 1e-6, "us"),
        &["µs", "μs", "usec", "microseconds"],
    ),
    (unit(Quantity::Time, 1e-9, "ns"), &["nsec", "nanoseconds"]),
    (unit(Quantity::Speed, 1.0, "mm/s"), &["mm_s"]),
    (unit(Quantity::Speed, 1.0 / 60.0, "mm/min"), &["mm_min"]),
    (unit(Quantity::Speed, 1e3, "m/s"), &["m_s"]),
    (unit(Quantity::Speed, 1e3 / 60.0, "m/min"), &["m_min"]),
    (unit(Quantity::Rotation, 1.0, "rad/s"), &["rad_s"]),
    (
        unit(Quantity::Rotation, TAU / 360.0, "deg/s"),
        &["deg_s", "°/s"],
    ),
    (
        unit(Quantity::Rotation, TAU / 60.0, "rev/min"),
        &["rpm", "1/min", "min-1", "u/min"],
    ),
    (
        unit(Quantity::Acceleration, 1.0, "mm/s^2"),
        &["mm_s2", "mm/s2", "mm/s²"],
    ),
    (
        unit(Quantity::Acceleration, 1e3, "m/s^2"),
        &["m_s2", "m/s2", "m/s²"],
    ),
    (unit(Quantity::Acceleration, 9806.65, "g"), &[]),
    (
        unit(Quantity::Current, 1.0, "A"),
        &["ampere", "amp", "amps", "aeff", "arms"],
    ),
    (unit(Quantity::Current, 1e-3, "mA"), &[]),
    (Unit::NM_TORQUE, &["n m", "n_m", "n·m", "n*m"]),
    (unit(Quantity::Force, 1.0, "N"), &["newton"]),
    (unit(Quantity::Force, 1e3, "kN"), &[]),
    (unit(Quantity::Voltage, 1.0, "V"), &["volt", "volts"]),
    (unit(Quantity::Voltage, 1e-3, "mV"), &[]),
    (unit(Quantity::Percent, 1.0, "%"), &["percent", "pct"]),
];

impl Unit {
    /// Millimetres.
    pub const MM: Unit = unit(Quantity::Length, 1.0, "mm");
    /// Seconds.
    pub const S: Unit = unit(Quantity::Time, 1.0, "s");
    /// Nanometres, and newton metres, which differ in a capital letter.
    pub(crate) const NM_LENGTH: Unit = unit(Quantity::Length, 1e-6, "nm");
    pub(crate) const NM_TORQUE: Unit = unit(Quantity::Torque, 1.0, "Nm");

    /// The unit at the end of a column's name: in brackets (`x [mm]`, `x(mm)`), or behind the last
    /// underscores (`motor_um`, `v_mm_s`).
    ///
    /// ```
    /// use lostmotion_logs::Unit;
    ///
    /// assert_eq!(Unit::in_name("motor_um").unwrap().symbol, "um");
    /// assert_eq!(Unit::in_name("Position X [mm/min]").unwrap().symbol, "mm/min");
    /// assert_eq!(Unit::in_name("speed_mm_s").unwrap().symbol, "mm/s");
    /// assert!(Unit::in_name("status").is_none());
    /// ```
    pub fn in_name(name: &str) -> Option<Unit> {
        let name = name.trim();
        for (open, close) in [('[', ']'), ('(', ')')] {
            if let Some(inner) = name.strip_suffix(close)
                && let Some((_, unit)) = inner.rsplit_once(open)
                && let Ok(unit) = unit.parse()
            {
                return Some(unit);
            }
        }
        // The longest ending first: `v_mm_s` is in mm/s, not in s.
        name.match_indices('_')
            .find_map(|(at, _)| name.get(at + 1..)?.parse().ok())
    }
}

/// A name without the unit at its end and in lower case.
pub(crate) fn stem(name: &str) -> String {
    let name = name.trim();
    let bare = match name.rfind(['[', '(']) {
        Some(at) if Unit::in_name(name).is_some() && at > 0 => name.get(..at).unwrap_or(name),
        _ => name
            .match_indices('_')
            .find(|(at, _)| {
                name.get(at + 1..)
                    .is_some_and(|unit| unit.parse::<Unit>().is_ok())
            })
            .and_then(|(at, _)| name.get(..at))
            .unwrap_or(name),
    };
    bare.trim().to_lowercase()
}

impl FromStr for Unit {
    type Err = String;

    fn from_str(text: &str) -> Result<Unit, String> {
        let text = text.trim();
        // Case tells mA from MA nowhere in logs, but mm from MM does not matter either.
        let lower = text.to_lowercase();
        let exact = UNITS.iter().find(|(unit, _)| unit.symbol == text);
        let alike = || {
            UNITS.iter().find(|(unit, others)| {
                unit.symbol.to_lowercase() == lower || others.contains(&lower.as_str())
            })
        };
        exact.or_else(alike).map(|(unit, _)| *unit).ok_or_else(|| {
            let known: Vec<&str> = UNITS.iter().map(|(unit, _)| unit.symbol).collect();
            format!("`{text}` is not a unit; known are {}", known.join(", "))
        })
    }
}

impl fmt::Display for Unit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.symbol)
    }
}
