//! A machine as far as a format describes it; `fill` adds the rest.

use crate::control::Control;
use lostmotion_base::AxisId;
use lostmotion_gcode::Units;
use lostmotion_kinematics::{CartesianSpec, CoreXySpec, KinematicsSpec};
use std::f64::consts::SQRT_2;

/// What became of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// Taken over.
    Used,
    /// Means nothing here.
    Ignored,
    /// Not in the file: from the preset.
    Filled,
    /// Neither in the file nor of a machine: what is usual, to be measured or looked up.
    Guessed,
}

impl Fate {
    /// For people.
    pub const fn name(self) -> &'static str {
        match self {
            Fate::Used => "used",
            Fate::Ignored => "ignored",
            Fate::Filled => "filled in",
            Fate::Guessed => "guess",
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

/// What is told of an axis that a stepper moves, open loop.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct StepperDraft {
    /// Travel for a turn of the motor, mm or deg.
    pub(super) per_turn: Option<Told>,
    /// Microsteps for a mm or deg.
    pub(super) steps_per_unit: Option<Told>,
    /// Full steps of a turn.
    pub(super) full_steps: Option<Told>,
    /// Microsteps of a full step.
    pub(super) microsteps: Option<Told>,
    /// Amplitude of the current of a phase, A.
    pub(super) peak_current_a: Option<Told>,
}

/// The method that the control already runs on an axis, with its settings as machine files have
/// them.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Carried {
    pub(super) method: &'static str,
    pub(super) settings: Vec<(&'static str, f64)>,
    pub(super) from: String,
}

/// A motor of an axis behind its first.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FurtherMotor {
    /// Where it is told: `JOINT_2`.
    pub(super) from: String,
    /// Its gap, mm or deg.
    pub(super) gap: Option<Told>,
}

/// An axis whose two motors have gaps of their own.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DraftGantry {
    pub(super) axis: AxisId,
    /// The axis that moves the tool along the beam.
    pub(super) along: AxisId,
    pub(super) second_gap: Told,
}

/// A quantity of an axis, mm or deg and s.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Min,
    Max,
    Velocity,
    Acceleration,
    Jerk,
    Gap,
    PerTurn,
    StepsPerUnit,
    FullSteps,
    Microsteps,
    PeakCurrent,
}

impl Quantity {
    /// For people.
    fn name(self) -> &'static str {
        match self {
            Quantity::Min => "lower end of the travel",
            Quantity::Max => "upper end of the travel",
            Quantity::Velocity => "velocity",
            Quantity::Acceleration => "acceleration",
            Quantity::Jerk => "jerk",
            Quantity::Gap => "gap",
            Quantity::PerTurn => "travel of a turn of the motor",
            Quantity::StepsPerUnit => "steps of the motor",
            Quantity::FullSteps => "full steps of a turn",
            Quantity::Microsteps => "microsteps of a step",
            Quantity::PeakCurrent => "current of the motor",
        }
    }
}

/// A tool.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ToolDraft {
    pub(super) number: u32,
    pub(super) length_mm: f64,
    pub(super) diameter_mm: f64,
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
    /// Of an axis that a stepper moves.
    pub(super) stepper: Option<StepperDraft>,
    /// What the control does about the gap.
    pub(super) carried: Option<Carried>,
    /// The motors behind the first, whose gap is `gap`.
    pub(super) further: Vec<FurtherMotor>,
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
            stepper: None,
            carried: None,
            further: Vec::new(),
        }
    }

    /// The control runs a method on this axis.
    pub(super) fn carry(&mut self, method: &'static str, settings: Vec<(&'static str, f64)>) {
        let carried = self.gaps().find(|gap| gap.value > 0.0).map(|gap| Carried {
            method,
            settings,
            from: gap.from.clone(),
        });
        self.carried = carried;
    }

    /// What the report says of that.
    pub(super) fn carried_row(&self) -> Option<Row> {
        let carried = self.carried.as_ref()?;
        Some(Row {
            key: format!(
                "axis.{}.compensation.method",
                self.id.letter().to_ascii_lowercase()
            ),
            value: carried.method.to_owned(),
            fate: Fate::Used,
            note: format!("the control runs it already: {}", carried.from),
        })
    }

    /// What a key of the axis in the machine file was made of: `limits.velocity_mm_s`.
    fn told(&self, key: &str) -> Option<&Told> {
        let stepper = self.stepper.as_ref();
        let is_of = |part: &str| key.contains(part);
        let told = if is_of("limits.velocity_") {
            &self.velocity
        } else if is_of("limits.acceleration_") {
            &self.acceleration
        } else if is_of("limits.jerk_") {
            &self.jerk
        } else if is_of("limits.min_") {
            &self.min
        } else if is_of("limits.max_") {
            &self.max
        } else if is_of("gap_") {
            &self.gap
        } else if is_of("following_error") && self.following_error.is_some() {
            &self.following_error
        } else if is_of("standstill_error") && self.standstill_error.is_some() {
            &self.standstill_error
        } else if is_of("current_") {
            &stepper?.peak_current_a
        } else {
            // Travel of a turn, counts of a turn, steps as an error: of the steps.
            let stepper = stepper?;
            return stepper
                .per_turn
                .as_ref()
                .or(stepper.steps_per_unit.as_ref());
        };
        told.as_ref()
    }

    /// The place of a quantity. Those of a stepper make the axis one.
    fn slot(&mut self, quantity: Quantity) -> &mut Option<Told> {
        match quantity {
            Quantity::Min => &mut self.min,
            Quantity::Max => &mut self.max,
            Quantity::Velocity => &mut self.velocity,
            Quantity::Acceleration => &mut self.acceleration,
            Quantity::Jerk => &mut self.jerk,
            Quantity::Gap => &mut self.gap,
            _ => {
                let stepper = self.stepper.get_or_insert_default();
                match quantity {
                    Quantity::PerTurn => &mut stepper.per_turn,
                    Quantity::StepsPerUnit => &mut stepper.steps_per_unit,
                    Quantity::FullSteps => &mut stepper.full_steps,
                    Quantity::Microsteps => &mut stepper.microsteps,
                    _ => &mut stepper.peak_current_a,
                }
            }
        }
    }
}

/// Which machines have motors like this one's: where only steps are told, the rest is a guess by
/// kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum MachineSize {
    /// Routers and small mills.
    #[default]
    Router,
    /// Printers.
    Printer,
}

/// A machine as far as it was told.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Draft {
    pub(super) name: String,
    pub(super) source: &'static str,
    /// Dialect of its programs, if that is told.
    pub(super) dialect: Option<&'static str>,
    /// Units of the control and of programs at their start, and where those are told.
    pub(super) control_units: (Units, String),
    pub(super) program_units: Option<(Units, String)>,
    /// Axes of the control's joints by their number.
    pub(super) joint_axes: Vec<Option<AxisId>>,
    pub(super) kinematics: KinematicsSpec,
    /// Among whose functions a method is recommended.
    pub(super) control: Option<Control>,
    pub(super) size: MachineSize,
    /// Time from setpoint to setpoint, ms.
    pub(super) command_ms: Option<Told>,
    /// Tolerance of the path under G64, mm.
    pub(super) path_tolerance_mm: Option<Told>,
    /// Table of a position (`work_offset.g54`, `home.g28`), axis, and the place in mm or deg.
    pub(super) offsets: Vec<(&'static str, AxisId, Told)>,
    pub(super) tools: Vec<ToolDraft>,
    pub(super) axes: Vec<DraftAxis>,
    /// The axis that two motors drive, each with its own gap.
    pub(super) gantry: Option<DraftGantry>,
    /// Axes that have to be there, and why: one that is not was lost with a part of the file.
    pub(super) expected: Vec<(AxisId, &'static str)>,
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
            control_units: (Units::Mm, String::new()),
            program_units: None,
            joint_axes: Vec::new(),
            kinematics: CartesianSpec {}.into(),
            control: None,
            size: MachineSize::default(),
            command_ms: None,
            path_tolerance_mm: None,
            offsets: Vec::new(),
            tools: Vec::new(),
            axes: Vec::new(),
            gantry: None,
            expected: Vec::new(),
            rows: Vec::new(),
        }
    }

    /// What a key of the machine file was made of, where the file that was read told it: `axis.x.limits.jerk_mm_s3`.
    pub(super) fn told(&self, key: &str) -> Option<&Told> {
        let (letter, own) = key.strip_prefix("axis.")?.split_once('.')?;
        let axis = self
            .axes
            .iter()
            .find(|axis| letter.eq_ignore_ascii_case(&axis.id.letter().to_string()))?;
        axis.told(own)
    }

    /// The axes of the control's joints as a machine file has them; `None` where they are not told,
    /// or not of all axes.
    pub(super) fn joint_letters(&self) -> Option<String> {
        let is_there = |axis: &AxisId| self.axes.iter().any(|own| own.id == *axis);
        let letters = self.joint_axes.iter();
        let letters: String = letters
            .map(|axis| axis.filter(is_there).map_or('-', AxisId::letter))
            .collect();
        let mut axes = self.axes.iter();
        axes.all(|axis| letters.contains(axis.id.letter()))
            .then(|| letters.trim_end_matches('-').to_owned())
            .filter(|letters| !letters.is_empty())
    }

    /// A gap of zero tells that the control compensates nothing, and nothing of the machine.
    pub(super) fn forget_zero_gaps(&mut self) {
        for axis in &mut self.axes {
            let further = axis.further.iter_mut().map(|motor| &mut motor.gap);
            for gap in std::iter::once(&mut axis.gap).chain(further) {
                let Some(gap) = gap.take_if(|gap| gap.value == 0.0) else {
                    continue;
                };
                let rows = self.rows.iter_mut();
                for row in rows.filter(|row| row.key == gap.from && row.fate == Fate::Used) {
                    row.fate = Fate::Ignored;
                    row.note = format!(
                        "{}: the control compensates nothing, the gap itself is not told",
                        axis.id
                    );
                }
            }
        }
    }

    /// Axes of which the file should tell and does not are reported.
    pub(super) fn report_missing(&mut self) {
        for (axis, why) in std::mem::take(&mut self.expected) {
            if !self.axes.iter().any(|own| own.id == axis) {
                let note = format!("{why}, and nothing is told of it: is the file whole?");
                self.row(format!("axis {axis}"), "none", Fate::Guessed, note);
            }
        }
    }

    /// Reports a last line that does not end: the value there may be a part of itself.
    pub(super) fn report_open_end(&mut self, text: &str) {
        let Some(last) = text.lines().last().filter(|_| !text.ends_with('\n')) else {
            return;
        };
        let note = "the last line does not end: was the file cut there?";
        let key = format!("line {}", text.lines().count());
        self.row(key, last.trim(), Fate::Guessed, note);
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

impl Draft {
    /// Takes a quantity of an axis over and reports it: `value` as it stands in the file.
    pub(super) fn tell(&mut self, id: AxisId, quantity: Quantity, told: Told, value: &str) {
        let note = format!("{} of {id}", quantity.name());
        let line = told.line;
        let from = told.from.clone();
        let before = self.axis(id, id.is_rotary()).slot(quantity).replace(told);
        // Told before: that one does not count, which is said.
        if let Some(before) = before
            && let Some(row) = self
                .rows
                .iter_mut()
                .rfind(|row| row.key == before.from && row.note == note)
        {
            row.fate = Fate::Ignored;
            row.note = format!(
                "line {}: given again in line {line}, which counts",
                before.line
            );
        }
        self.row(from, value, Fate::Used, note);
    }

    /// Takes a quantity over that nobody tells and the control or a guess has; the caller reports it.
    pub(super) fn default(&mut self, id: AxisId, quantity: Quantity, told: Told) {
        *self.axis(id, id.is_rotary()).slot(quantity) = Some(told);
    }

    /// Reports gaps that no machine that cuts has: mostly they are a unit that was mistaken.
    pub(super) fn report_wide_gaps(&mut self) {
        let mut rows = Vec::new();
        for axis in &self.axes {
            let unit = if axis.rotary { "deg" } else { "mm" };
            let wide = |gap: &&Told| gap.value > WIDEST_GAP;
            rows.extend(axis.gaps().filter(wide).map(|gap| Row {
                key: gap.from.clone(),
                value: format!("{} {unit}", float(gap.value)),
                fate: Fate::Guessed,
                note: format!(
                    "axis {}: a gap of {} {unit} is unlikely: was it written in um or mdeg, as steps, or in inches in a file in mm?",
                    axis.id,
                    float(gap.value)
                ),
            }));
        }
        self.rows.extend(rows);
    }

    /// The control runs a method on every axis whose gap it was told: the gap is what the machine
    /// has, the method what the control does about it.
    pub(super) fn carry(
        &mut self,
        method: &'static str,
        settings: impl Fn(&DraftAxis) -> Vec<(&'static str, f64)>,
    ) {
        for axis in &mut self.axes {
            let settings = settings(axis);
            axis.carry(method, settings);
            self.rows.extend(axis.carried_row());
        }
    }

    /// Limits told for X and Y of a CoreXY machine become those of its belts, x + y and x - y. A
    /// belt moves at most sqrt 2 times as fast as the tool.
    pub(super) fn belts(&mut self) {
        self.kinematics = CoreXySpec {}.into();
        let x = self.axis(AxisId::X, false).clone();
        let y = self.axis(AxisId::Y, false).clone();
        let both = |a: &Option<Told>, b: &Option<Told>, of: fn(f64, f64) -> f64| {
            let (a, b) = (a.as_ref()?, b.as_ref()?);
            Some(Told {
                value: of(a.value, b.value),
                from: format!("{}, {}: of the belt", a.from, b.from),
                line: a.line,
            })
        };
        let least = |a: f64, b: f64| SQRT_2 * a.min(b);
        let ends = [
            (
                both(&x.min, &y.min, |x, y| x + y),
                both(&x.max, &y.max, |x, y| x + y),
            ),
            (
                both(&x.min, &y.max, |x, y| x - y),
                both(&x.max, &y.min, |x, y| x - y),
            ),
        ];
        for (id, (min, max)) in [AxisId::X, AxisId::Y].into_iter().zip(ends) {
            let axis = self.axis(id, false);
            (axis.min, axis.max) = (min, max);
            axis.velocity = both(&x.velocity, &y.velocity, least);
            axis.acceleration = both(&x.acceleration, &y.acceleration, least);
        }
        self.row(
            "axis.x, axis.y",
            "belts",
            Fate::Used,
            "limits of the tool as limits of the belts x + y and x - y: within them the tool may leave its own travel",
        );
    }
}

impl DraftAxis {
    /// The further motor of a name, made if it is not there yet.
    pub(super) fn further_motor(&mut self, from: &str) -> &mut FurtherMotor {
        let index = self
            .further
            .iter()
            .position(|motor| motor.from == from)
            .unwrap_or_else(|| {
                self.further.push(FurtherMotor {
                    from: from.to_owned(),
                    gap: None,
                });
                self.further.len() - 1
            });
        &mut self.further[index]
    }

    /// The gaps that are told, of the first motor and then of the further ones.
    pub(super) fn gaps(&self) -> impl Iterator<Item = &Told> {
        let further = self.further.iter().filter_map(|motor| motor.gap.as_ref());
        self.gap.iter().chain(further)
    }
}

impl Draft {
    /// Further motors of the axes that are there.
    pub(super) fn add_motors(&mut self, motors: &[(AxisId, String)]) {
        for (id, from) in motors {
            if let Some(axis) = self.axes.iter_mut().find(|axis| axis.id == *id) {
                axis.further_motor(from);
            }
        }
    }
}

/// What becomes of a motor behind the first of its axis.
pub(super) const LIKE_FIRST: &str = "a further motor of the axis, taken to be like the first";

/// The same of a value that the first motor may have otherwise: `first` is where that is told, and its value.
pub(super) fn unlike_first(first: Option<(&str, &str)>, value: &str) -> String {
    let same = |first: &str| match (first.parse::<f64>(), value.parse::<f64>()) {
        (Ok(a), Ok(b)) => a == b,
        _ => first == value,
    };
    match first {
        Some((_, first)) if same(first) => LIKE_FIRST.to_owned(),
        Some((name, first)) => {
            format!(
                "a further motor of the axis, which differs from the first ({name} = {first}): both are taken as that"
            )
        }
        None => {
            "a further motor of the axis; of the first it is not told, and both are taken as that"
                .to_owned()
        }
    }
}

/// Widest gap that is taken without a word, mm or deg. A choice: worn routers and printers have some tenths.
const WIDEST_GAP: f64 = 0.5;

/// What becomes of a negative gap.
pub(super) const LEADING: &str =
    "negative: of an encoder that the load leads, which is not modelled; the gap is not told";

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

/// A line of the report for what a preset lends.
pub(super) fn filled(
    key: impl Into<String>,
    value: impl Into<String>,
    note: impl Into<String>,
) -> Row {
    Row {
        key: key.into(),
        value: value.into(),
        fate: Fate::Filled,
        note: note.into(),
    }
}
