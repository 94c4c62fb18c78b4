//! A machine as plain data: what a machine file says, to be written, read, sent, and changed in
//! code.

use super::gantry::GantryFile;
use super::{General, LimitsTable, Machine, MachineError};
use lostmotion_base::units::{UM_PER_MM, deg, rad};
use lostmotion_drive::config::{AxisUnit, Cycles};
use lostmotion_kinematics::KinematicsSpec;
use lostmotion_methods::AxisConfig;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::ops::{Deref, DerefMut};

/// Everything that a machine file says, unchecked; [`MachineFile::check`] makes a machine of it.
///
/// A machine and its file are the same to the last bit, in TOML, JSON or any other form of serde's.
///
/// ```
/// use lostmotion_sim::Machine;
/// use lostmotion_sim::machine::MachineFile;
///
/// let machine = Machine::preset("vmc4")?;
/// let text = serde_json::to_string(&machine.file())?;
/// let read: MachineFile = serde_json::from_str(&text)?;
/// assert_eq!(read.check()?, machine);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MachineFile {
    /// All but the axes.
    #[serde(flatten)]
    pub general: General,
    /// The axis that two motors drive, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gantry: Option<GantryFile>,
    /// The axes by their letter in lower case.
    pub axis: BTreeMap<String, AxisFile>,
}

/// Tables `[axis.x.limits]`, `[axis.x.motor]` and so on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisFile {
    /// Travel and limits.
    pub limits: LimitsTable,
    /// Transmission, motor, load, drive, compensation.
    #[serde(flatten)]
    pub config: AxisConfig,
}

impl MachineFile {
    /// A machine with a name and kinematics, without any axis yet: the beginning of one that is
    /// made in code.
    ///
    /// ```
    /// use lostmotion_base::AxisId;
    /// use lostmotion_kinematics::CartesianSpec;
    /// use lostmotion_sim::Machine;
    /// use lostmotion_sim::machine::{AxisFile, LimitsTable, LinearLimits, MachineFile};
    ///
    /// let limits = LimitsTable::Linear(LinearLimits {
    ///     min_mm: -100.0,
    ///     max_mm: 100.0,
    ///     velocity_mm_s: 200.0,
    ///     acceleration_mm_s2: 2000.0,
    ///     jerk_mm_s3: 40_000.0,
    /// });
    /// let mut file = MachineFile::new("plotter", CartesianSpec {});
    /// // The X axis of a preset is a good start; every field of it may be changed.
    /// let mill = Machine::preset("vmc3")?;
    /// let x = &mill.axis(AxisId::X).ok_or("no X")?.config;
    /// for letter in ["x", "y"] {
    ///     let config = x.clone();
    ///     file.axis.insert(letter.to_owned(), AxisFile { limits, config });
    /// }
    /// let machine = file.check()?;
    /// assert_eq!(machine.drives(), ["x", "y"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(name: impl Into<String>, kinematics: impl Into<KinematicsSpec>) -> MachineFile {
        MachineFile {
            general: General::new(name.into(), kinematics.into()),
            gantry: None,
            axis: BTreeMap::new(),
        }
    }

    /// The machine that it describes.
    ///
    /// # Errors
    /// Everything that is wrong, as [`Machine::from_toml`], with keys in place of lines.
    pub fn check(&self) -> Result<Machine, MachineError> {
        // One way in for files and code, so that both are checked alike.
        let name = &self.general.name;
        let text = self
            .to_toml()
            .map_err(|error| MachineError::of(name, "", error.to_string(), ""))?;
        Machine::from_toml(name, &text).map_err(MachineError::without_places)
    }

    /// As a machine file.
    ///
    /// # Errors
    /// A number that TOML cannot hold.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        toml::to_string_pretty(self)
    }
}

impl TryFrom<MachineFile> for Machine {
    type Error = MachineError;

    fn try_from(file: MachineFile) -> Result<Machine, MachineError> {
        file.check()
    }
}

impl From<Machine> for MachineFile {
    fn from(machine: Machine) -> MachineFile {
        machine.file()
    }
}

impl Machine {
    /// What a machine file says of it. Comments of the file it came from are gone.
    pub fn file(&self) -> MachineFile {
        let axis = |part: &super::MachineAxis| {
            let letter = part.id.letter().to_ascii_lowercase().to_string();
            // The machine's own table has the cycles.
            let config = AxisConfig {
                cycles: Cycles::default(),
                ..part.config.clone()
            };
            let limits = part.table;
            (letter, AxisFile { limits, config })
        };
        MachineFile {
            general: self.general.clone(),
            gantry: self.gantry.as_ref().map(super::Gantry::file),
            axis: self.axes.iter().map(axis).collect(),
        }
    }

    /// The machine as a file that [`Machine::from_toml`] reads back to an equal machine. Comments
    /// of the file it came from are gone.
    ///
    /// # Errors
    /// None for a machine made by this crate; the type is that of the writer underneath.
    pub fn to_toml(&self) -> Result<String, toml::ser::Error> {
        self.file().to_toml()
    }

    /// The machine with something changed, checked again.
    ///
    /// ```
    /// use lostmotion_sim::Machine;
    ///
    /// let machine = Machine::preset("vmc3")?.edit(|m| {
    ///     m.g54 = [-300.0, -200.0, -250.0];
    ///     m.axis("x").gap_um = 25.0;
    ///     m.axis("x").drive.position_gain_per_s = 40.0;
    ///     m.simulate.tolerance_um = 15.0;
    /// })?;
    /// assert_eq!(machine.work_offsets()[0].linear(), [-300.0, -200.0, -250.0]);
    ///
    /// let error = machine.edit(|m| m.axis("y").drive.position_gain_per_s = -1.0).unwrap_err();
    /// assert_eq!(error.problems[0].key, "axis.y.drive.position_gain_per_s");
    /// # Ok::<(), lostmotion_sim::machine::MachineError>(())
    /// ```
    ///
    /// # Errors
    /// Everything that is wrong with the changed machine, with its keys; axes that it does not
    /// have.
    pub fn edit(&self, change: impl FnOnce(&mut MachineEdit)) -> Result<Machine, MachineError> {
        let mut edit = MachineEdit::new(self.file());
        change(&mut edit);
        edit.finish()?.check()
    }
}

/// A machine that is being changed: everything of [`General`] as a field, the axes through
/// [`MachineEdit::axis`], and the origin of G54 by its coordinates.
#[derive(Clone, Debug)]
pub struct MachineEdit {
    /// X, Y and Z of the origin of G54 in machine coordinates, mm; the other work offsets, and
    /// other axes, are in `work_offset`.
    pub g54: [f64; 3],
    /// The axis that two motors drive, if there is one.
    pub gantry: Option<GantryFile>,
    general: General,
    axes: BTreeMap<String, AxisEdit>,
    told_g54: [f64; 3],
    /// Axes that were asked for and that there are not, with what was to be changed.
    missing: BTreeMap<String, AxisEdit>,
}

impl Deref for MachineEdit {
    type Target = General;

    fn deref(&self) -> &General {
        &self.general
    }
}

impl DerefMut for MachineEdit {
    fn deref_mut(&mut self) -> &mut General {
        &mut self.general
    }
}

impl MachineEdit {
    fn new(file: MachineFile) -> MachineEdit {
        let g54 = file.general.work_offset.g54;
        let g54 = [g54.x_mm, g54.y_mm, g54.z_mm];
        let axes = file.axis.into_iter();
        MachineEdit {
            g54,
            told_g54: g54,
            gantry: file.gantry,
            general: file.general,
            axes: axes
                .map(|(name, axis)| (name, AxisEdit::new(axis)))
                .collect(),
            missing: BTreeMap::new(),
        }
    }

    /// The axis of a letter. One that the machine does not have is an error of [`Machine::edit`].
    pub fn axis(&mut self, letter: &str) -> &mut AxisEdit {
        let name = letter.to_ascii_lowercase();
        if self.axes.contains_key(&name) {
            return self.axes.entry(name).or_insert_with(AxisEdit::nowhere);
        }
        // Kept apart, so that the mistake is told when the edit is finished.
        self.missing.entry(name).or_insert_with(AxisEdit::nowhere)
    }

    /// Adds an axis, or replaces the one of that letter.
    pub fn add_axis(&mut self, letter: &str, axis: AxisFile) {
        self.axes
            .insert(letter.to_ascii_lowercase(), AxisEdit::new(axis));
    }

    /// Takes an axis away.
    pub fn remove_axis(&mut self, letter: &str) {
        self.axes.remove(&letter.to_ascii_lowercase());
    }

    fn finish(mut self) -> Result<MachineFile, MachineError> {
        let name = self.general.name.clone();
        // Changes to an axis that there is not would be lost without a word.
        if let Some(missing) = self.missing.keys().next() {
            let known: Vec<&str> = self.axes.keys().map(String::as_str).collect();
            let message = format!("the machine has no axis `{missing}`");
            let hint = format!("its axes are {}", known.join(", "));
            return Err(MachineError::of(
                &name,
                &format!("axis.{missing}"),
                message,
                &hint,
            ));
        }
        // Only if it was changed: `work_offset` may have been set directly.
        if self.g54 != self.told_g54 {
            let origin = &mut self.general.work_offset.g54;
            [origin.x_mm, origin.y_mm, origin.z_mm] = self.g54;
        }
        let mut axis = BTreeMap::new();
        for (letter, edit) in self.axes {
            let edited = edit.finish().map_err(|(key, why)| {
                MachineError::of(&name, &format!("axis.{letter}.{key}"), why, "")
            })?;
            axis.insert(letter, edited);
        }
        Ok(MachineFile {
            general: self.general,
            gantry: self.gantry,
            axis,
        })
    }
}

/// An axis that is being changed: everything of its [`AxisConfig`] as a field, its limits, and its
/// gap in the unit that people use.
#[derive(Clone, Debug)]
pub struct AxisEdit {
    /// Total gap of a linear axis, um; NaN for a rotary one.
    pub gap_um: f64,
    /// Total gap of a rotary axis, mdeg; NaN for a linear one.
    pub gap_mdeg: f64,
    /// Travel and limits.
    pub limits: LimitsTable,
    /// Transmission, motor, load, drive, compensation.
    pub config: AxisConfig,
    told: [f64; 2],
}

impl Deref for AxisEdit {
    type Target = AxisConfig;

    fn deref(&self) -> &AxisConfig {
        &self.config
    }
}

impl DerefMut for AxisEdit {
    fn deref_mut(&mut self) -> &mut AxisConfig {
        &mut self.config
    }
}

/// Thousandths of a degree in a degree.
const MDEG_PER_DEG: f64 = 1e3;

impl AxisEdit {
    fn new(axis: AxisFile) -> AxisEdit {
        let gap = axis.config.gap_in_unit();
        // In the unit that people use for this kind of axis; the other is NaN.
        let told = match axis.config.unit() {
            AxisUnit::Mm => [gap * UM_PER_MM, f64::NAN],
            AxisUnit::Deg => [f64::NAN, gap * MDEG_PER_DEG],
            AxisUnit::Rad => [f64::NAN, deg(gap) * MDEG_PER_DEG],
        };
        AxisEdit {
            gap_um: told[0],
            gap_mdeg: told[1],
            limits: axis.limits,
            config: axis.config,
            told,
        }
    }

    /// Takes the changes to an axis that there is not.
    fn nowhere() -> AxisEdit {
        AxisEdit::new(AxisFile {
            limits: LimitsTable::NONE,
            config: AxisConfig::paper(),
        })
    }

    /// The axis with its gap, or the key of what does not fit and why.
    fn finish(self) -> Result<AxisFile, (&'static str, String)> {
        // By their bits: the gap of the other kind is NaN, which never equals itself.
        let changed = |now: f64, before: f64| now.to_bits() != before.to_bits();
        let (um, mdeg) = (
            changed(self.gap_um, self.told[0]),
            changed(self.gap_mdeg, self.told[1]),
        );
        let gap = match (self.config.unit(), um, mdeg) {
            (_, false, false) => None,
            (AxisUnit::Mm, true, false) => Some(self.gap_um / UM_PER_MM),
            (AxisUnit::Deg, false, true) => Some(self.gap_mdeg / MDEG_PER_DEG),
            (AxisUnit::Rad, false, true) => Some(rad(self.gap_mdeg / MDEG_PER_DEG)),
            (AxisUnit::Mm, ..) => {
                return Err((
                    "gap_mdeg",
                    "is set, but the axis is linear: set gap_um".to_owned(),
                ));
            }
            _ => {
                return Err((
                    "gap_um",
                    "is set, but the axis is rotary: set gap_mdeg".to_owned(),
                ));
            }
        };
        Ok(AxisFile {
            limits: self.limits,
            config: gap.map_or_else(|| self.config.clone(), |gap| self.config.with_gap(gap)),
        })
    }
}
