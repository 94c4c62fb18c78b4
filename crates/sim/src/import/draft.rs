//! A machine as far as a format describes it; `fill` adds the rest.

use lostmotion_base::AxisId;
use lostmotion_kinematics::{CartesianSpec, KinematicsSpec};

/// What became of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Taken over.
    Used,
    /// Means nothing here.
    Ignored,
    /// Not in the file: from the preset.
    Filled,
}

impl Fate {
    /// For people.
    pub const fn name(self) -> &'static str {
        match self {
            Fate::Used => "used",
            Fate::Ignored => "ignored",
            Fate::Filled => "filled in",
        }
    }
}

/// One line of the report.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Row {
    /// Key in the file that was read, or in the machine file for what was filled in.
    pub key: String,
    /// Its value.
    pub value: String,
    /// What became of it.
    pub fate: Fate,
    /// What it is in the machine file, or where it came from.
    pub note: String,
}

/// A value, with where it stands.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Told {
    pub(super) value: f64,
    pub(super) from: String,
    /// Its line.
    pub(super) line: usize,
}

/// An axis as far as it was told: mm or deg, and s.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DraftAxis {
    pub(super) id: AxisId,
    pub(super) rotary: bool,
    pub(super) min: Option<Told>,
    pub(super) max: Option<Told>,
    pub(super) velocity: Option<Told>,
    pub(super) acceleration: Option<Told>,
    pub(super) jerk: Option<Told>,
    pub(super) gap: Option<Told>,
    /// Largest following error at full speed and at rest.
    pub(super) following_error: Option<Told>,
    pub(super) standstill_error: Option<Told>,
}

impl DraftAxis {
    pub(super) fn new(id: AxisId, rotary: bool) -> DraftAxis {
        DraftAxis {
            id,
            rotary,
            min: None,
            max: None,
            velocity: None,
            acceleration: None,
            jerk: None,
            gap: None,
            following_error: None,
            standstill_error: None,
        }
    }
}

/// A machine as far as it was told.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Draft {
    pub(super) name: String,
    pub(super) source: &'static str,
    /// Dialect of its programs, if that is told.
    pub(super) dialect: Option<&'static str>,
    pub(super) kinematics: KinematicsSpec,
    pub(super) axes: Vec<DraftAxis>,
    pub(super) rows: Vec<Row>,
}

impl Draft {
    /// A machine of which nothing is told yet: no axes, and joints that carry the axes of their own
    /// names. `source` is the format in words.
    pub(super) fn new(source: &'static str) -> Draft {
        Draft {
            name: "imported".to_owned(),
            source,
            dialect: None,
            kinematics: CartesianSpec {}.into(),
            axes: Vec::new(),
            rows: Vec::new(),
        }
    }

    pub(super) fn row(
        &mut self,
        key: impl Into<String>,
        value: impl Into<String>,
        fate: Fate,
        note: impl Into<String>,
    ) {
        self.rows.push(Row {
            key: key.into(),
            value: value.into(),
            fate,
            note: note.into(),
        });
    }

    /// The axis of a letter, made if it is not there yet.
    pub(super) fn axis(&mut self, id: AxisId, rotary: bool) -> &mut DraftAxis {
        let index = self
            .axes
            .iter()
            .position(|axis| axis.id == id)
            .unwrap_or_else(|| {
                self.axes.push(DraftAxis::new(id, rotary));
                self.axes.len() - 1
            });
        &mut self.axes[index]
    }
}

/// Numbers as a machine file has them: always with a point.
pub(super) fn float(value: f64) -> String {
    // Rounded, because a change of units leaves a tail of digits.
    format!("{:?}", (value * 1e9).round() / 1e9)
}

/// Components of directions (1) and points (mm) below this are the rounding of turns.
const ROUNDING: f64 = 1e-12;

/// A vector without the rounding of the turns that led to it.
pub(super) fn clean(v: [f64; 3]) -> [f64; 3] {
    v.map(|c| if c.abs() < ROUNDING { 0.0 } else { c })
}
