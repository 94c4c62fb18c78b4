//! A recorded motion held against its program: where in the program it is, how far it leaves the
//! programmed path, and whether it keeps the limits of the machine.
//!
//! The record may begin and end anywhere in the program, at any clock, with overrides, feed holds and
//! pauses (`locate`). A limit counts as exceeded where the record proves it, whatever its rounding
//! and noise (`rates`).

mod blocks;
mod locate;
mod path;
mod rates;
pub mod results;

use crate::error::SimError;
use crate::motion::{self, Checked, Curves};
use crate::program::BlockTexts;
use crate::results::ProgramInfo;
use crate::setup::Setup;
use blocks::{Blocks, Holes};
use locate::{Coordinates, Located, Unfound, follow, goes_on, locate};
use lostmotion_base::units::deg;
use lostmotion_base::{AxisId, Coords};
use path::{Foot, ProgrammedPath};
use rates::{Channel, Fineness, Order, time_bound_s};
use results::{
    Derivative, LimitUse, RECORD_SCHEMA, RecordCheck, RecordCoordinates, RecordKind, RecordPlace,
    RecordedAxisCheck,
};

/// Time between rows beyond which limits are not told, and beyond which nothing is, s. Choices: a stroke's
/// acceleration lasts some 0.1 s, and blocks last some 0.5.
const SLOW_S: f64 = 0.1;
const SLOWEST_S: f64 = 0.5;
/// By how much a limit may be exceeded without being said to be, in parts of it. A choice: limits of
/// controls are rounded numbers.
const LIMIT_SLACK: f64 = 0.005;
/// The same of measured positions. A choice: limits are those of commands, and servos overshoot.
const SERVO_SLACK: f64 = 0.1;
/// Part of a limit that an error of a derivative may be for the record to tell it.
const TOLD_SHARE: f64 = 0.5;
/// Other places that are listed.
const MOST_OTHERS: usize = 10;
/// Derivatives with the place of their limit.
const DERIVATIVES: [Derivative; 3] = [
    Derivative::Velocity,
    Derivative::Acceleration,
    Derivative::Jerk,
];

/// Positions of one axis, mm or rad.
#[derive(Clone, Debug, PartialEq)]
pub struct RecordedAxis {
    /// The axis.
    pub axis: AxisId,
    /// A position a row.
    pub values: Vec<f64>,
}

/// A motion that was recorded.
#[derive(Clone, Debug, PartialEq)]
pub struct Recorded {
    /// Time of each row by any clock, s, rising.
    pub time_s: Vec<f64>,
    /// The axes: joints of the machine, or what [`Recorded::of_tool`] says.
    pub axes: Vec<RecordedAxis>,
    /// What was recorded.
    pub kind: RecordKind,
    /// Whether the positions are those of the tool and of the program's axes. On machines whose
    /// joints go with the program's axes it makes no difference.
    pub of_tool: bool,
}

/// How a record is checked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordOptions {
    /// How many of the worst blocks are listed.
    pub keep_blocks: usize,
    /// Most moves of a program: they are held in memory.
    pub max_moves: usize,
    /// Whether the record may be in coordinates that are neither the machine's nor the program's.
    pub shifted: bool,
}

impl Default for RecordOptions {
    fn default() -> RecordOptions {
        RecordOptions {
            keep_blocks: 10,
            max_moves: 1_000_000,
            shifted: true,
        }
    }
}

/// Rows that two parts of a record share: a stencil of the longest has rows on either side.
pub const SHARED_ROWS: usize = 2 * rates::LONGEST_ROWS;

/// Checks a record against a program on a machine.
pub(crate) fn check(
    setup: &Setup<'_>,
    recorded: &Recorded,
    options: &RecordOptions,
) -> Result<RecordCheck, SimError> {
    let (checked, path) = program(setup, options)?;
    let mut record = Record::new(setup, &path, options);
    record.part(recorded, 0)?;
    record.finish(checked)
}

/// The same of a record in parts, each with how many rows of the one before it begins with.
pub(crate) fn check_parts<E: From<SimError>>(
    setup: &Setup<'_>,
    next: &mut dyn FnMut() -> Result<Option<(Recorded, usize)>, E>,
    options: &RecordOptions,
) -> Result<RecordCheck, E> {
    let (checked, path) = program(setup, options)?;
    let mut record = Record::new(setup, &path, options);
    while let Some((recorded, shared)) = next()? {
        record.part(&recorded, shared)?;
    }
    Ok(record.finish(checked)?)
}

/// The program, checked, and its path.
fn program(
    setup: &Setup<'_>,
    options: &RecordOptions,
) -> Result<(Checked, ProgrammedPath), SimError> {
    // The work offset of the log may be another than the machine file's: then travel says nothing.
    let checked = match motion::check(setup) {
        Err(SimError::Travel { name, .. }) => Checked {
            program: ProgramInfo {
                name,
                ..ProgramInfo::default()
            },
            ..Checked::default()
        },
        other => other?,
    };
    let path = ProgrammedPath::read(
        Curves::new(setup)?,
        setup.kinematics.joint_map(),
        setup.machine.planner().exact_path_tolerance_mm,
        options.max_moves,
    )?;
    if path.pieces.is_empty() {
        return Err(SimError::refused(
            "the program does not move the tool",
            "is it the right file?",
        ));
    }
    Ok((checked, path))
}

/// A record that is held against its program part by part. The first part that moves is looked for in
/// the program; the others go on where the one before ends.
struct Record<'a> {
    setup: &'a Setup<'a>,
    path: &'a ProgrammedPath,
    options: &'a RecordOptions,
    /// Rows up to now, before the path and behind it.
    rows: u64,
    rows_before: u64,
    rows_behind: u64,
    /// Why the record was not found yet.
    unfound: Option<SimError>,
    on_path: Option<OnPath<'a>>,
    /// Whether the path was left for good.
    is_behind: bool,
}

/// A record that was found.
struct OnPath<'a> {
    kind: RecordKind,
    period_s: f64,
    located: Located,
    from_s: f64,
    to_s: f64,
    first: Foot,
    /// The last feet, as many as parts share.
    tail: Vec<Foot>,
    blocks: Blocks<'a>,
    holes: Holes,
    axes: Vec<RecordedAxisCheck>,
    untold: Vec<String>,
}

impl<'a> Record<'a> {
    fn new(
        setup: &'a Setup<'a>,
        path: &'a ProgrammedPath,
        options: &'a RecordOptions,
    ) -> Record<'a> {
        Record {
            setup,
            path,
            options,
            rows: 0,
            rows_before: 0,
            rows_behind: 0,
            unfound: None,
            on_path: None,
            is_behind: false,
        }
    }

    /// Takes the next part, whose first rows are the last ones of the part before.
    fn part(&mut self, recorded: &Recorded, shared: usize) -> Result<(), SimError> {
        check_rows(
            self.setup,
            recorded,
            self.rows.saturating_sub(shared as u64),
        )?;
        let rows = recorded.time_s.len();
        let fresh = rows.saturating_sub(shared) as u64;
        self.rows += fresh;
        if self.is_behind {
            self.rows_behind += fresh;
            return Ok(());
        }
        let channels = Channels::new(self.setup, recorded, self.path)?;
        let error_mm = channels.error_mm;
        let again = shared;
        // Where the part is: found, or behind the last feet.
        let (located, shared) = match &self.on_path {
            None => match locate(self.path, &channels.points, error_mm, self.options.shifted) {
                Ok(located) => (located, 0),
                Err(error @ Unfound::Rests(_)) => {
                    self.rows_before += fresh;
                    self.unfound = Some(error.into());
                    return Ok(());
                }
                Err(error) => return Err(error.into()),
            },
            Some(found) => {
                let first = shared.saturating_sub(found.tail.len());
                let known = found.tail.len().saturating_sub(shared);
                let place_mm = found.tail.get(known).map_or(0.0, |foot| foot.place_mm);
                let points = channels.points.get(first..).unwrap_or_default();
                let last = first + goes_on(self.path, points, place_mm, &found.located, error_mm);
                let located = Located {
                    rows: (first, last),
                    place_mm,
                    ..found.located.clone()
                };
                (located, shared - first)
            }
        };
        let (first, last) = located.rows;
        self.is_behind = last + 1 < rows;
        self.rows_behind += (rows - 1 - last.min(rows - 1)) as u64;
        let on_path = channels.points.get(first..=last).unwrap_or_default();
        let at = |point: &[f64; 3]| lostmotion_base::vec::sub(*point, located.shift_mm);
        let feet = follow(
            self.path,
            on_path.iter().map(at),
            located.place_mm,
            error_mm,
        );
        let error_mm = error_mm + located.shift_error_mm;
        let time = |row: usize| recorded.time_s.get(row).copied().unwrap_or_default();
        let found = match &mut self.on_path {
            Some(found) => found,
            None => {
                self.rows_before = (self.rows_before + first as u64).saturating_sub(again as u64);
                let steps = recorded.time_s.windows(2).map(|pair| pair[1] - pair[0]);
                self.on_path.insert(OnPath {
                    kind: recorded.kind,
                    period_s: lostmotion_base::math::quantile(steps.collect(), 0.5),
                    from_s: time(first),
                    to_s: 0.0,
                    first: feet.first().copied().unwrap_or_default(),
                    tail: Vec::new(),
                    blocks: Blocks::new(self.setup, recorded, self.path, error_mm),
                    holes: Holes::default(),
                    axes: Vec::new(),
                    untold: Vec::new(),
                    located,
                })
            }
        };
        found.blocks.error_mm = found.blocks.error_mm.max(error_mm);
        let mut before = found.tail.last().map(|foot| (found.to_s, *foot));
        found.to_s = time(last);
        for (row, foot) in feet.iter().enumerate().skip(shared) {
            let now = (time(first + row), *foot);
            if let Some(before) = before.replace(now) {
                found.holes.between(before, now, found.period_s);
            }
            found.blocks.add(now.0, foot);
        }
        let mut untold = Vec::new();
        let range = first..last + 1;
        let axes = channels.axes(self.setup, range, &mut found.blocks, &feet, &mut untold);
        merge(&mut found.axes, axes);
        for reason in untold {
            // The same of the same axis, with other figures.
            let what = |text: &str| text.split(':').next().unwrap_or_default().to_owned();
            if !found.untold.iter().any(|told| what(told) == what(&reason)) {
                found.untold.push(reason);
            }
        }
        found.tail.extend(feet.iter().skip(shared));
        let spare = found.tail.len().saturating_sub(SHARED_ROWS);
        found.tail.drain(..spare);
        Ok(())
    }

    fn finish(self, checked: Checked) -> Result<RecordCheck, SimError> {
        let Some(found) = self.on_path else {
            return Err(self.unfound.unwrap_or_else(|| {
                SimError::refused("the log has no rows", "log the program while it moves")
            }));
        };
        if found.period_s > SLOWEST_S {
            return Err(SimError::refused(
                format!(
                    "the rows of the log are {} s apart: in between an axis does anything",
                    short(found.period_s)
                ),
                "times in milliseconds? Then --column time=NAME,unit=ms; else log at 100 Hz or more",
            ));
        }
        let path = self.path;
        let mut untold = Vec::new();
        if found.period_s > SLOW_S {
            untold.push(format!(
                "whether the axes keep their limits: the rows are {} ms apart, and an axis may begin and end its acceleration in between",
                short(1e3 * found.period_s)
            ));
        }
        if found.kind == RecordKind::Measured {
            untold.push("whether the axes keep their jerk: that limit is one of commands, and these positions are measured".to_owned());
        }
        untold.extend(found.holes.untold(path));
        untold.extend(found.untold);
        let located = &found.located;
        if located.coordinates == Coordinates::Found && path.pieces.iter().any(|piece| piece.rapid)
        {
            untold.push(
                "whether the work offset of the log is the one that was meant: it was fitted"
                    .to_owned(),
            );
        }
        let block = |piece: usize| {
            path.pieces
                .get(piece)
                .map(|piece| piece.block)
                .unwrap_or_default()
        };
        let mut answer = RecordCheck {
            schema: RECORD_SCHEMA,
            program: checked.program,
            machine: self.setup.machine.name().to_owned(),
            kind: found.kind,
            period_s: found.period_s,
            place: RecordPlace {
                first: block(found.first.piece),
                last: block(found.tail.last().map_or(0, |foot| foot.piece)),
                from_s: found.from_s,
                to_s: found.to_s,
                rows: self.rows,
                rows_before: self.rows_before,
                rows_behind: self.rows_behind,
                coordinates: match located.coordinates {
                    Coordinates::Machine => RecordCoordinates::Machine,
                    Coordinates::Program => RecordCoordinates::Program,
                    Coordinates::Found => RecordCoordinates::Shifted,
                },
                shift_mm: located.shift_mm,
                shift_error_mm: located.shift_error_mm,
                others: located
                    .others
                    .iter()
                    .take(MOST_OTHERS)
                    .map(|place| block(path.at(*place)))
                    .collect(),
                other_places: located.others.len() as u64,
            },
            axes: found.axes,
            untold,
            ..RecordCheck::default()
        };
        found.blocks.finish(&mut answer, self.options.keep_blocks);
        let mut texts = BlockTexts::new(self.setup.program, checked.files);
        for block in &mut answer.blocks {
            block.text = texts.at(block.block.span);
        }
        Ok(answer)
    }
}

/// Adds what a further part shows of the axes.
fn merge(axes: &mut Vec<RecordedAxisCheck>, more: Vec<RecordedAxisCheck>) {
    for other in more {
        let Some(axis) = axes.iter_mut().find(|axis| axis.axis == other.axis) else {
            axes.push(other);
            continue;
        };
        axis.step = axis.step.max(other.step);
        axis.noise = axis.noise.max(other.noise);
        for used in other.limits {
            let own = axis.limits.iter_mut();
            match own
                .into_iter()
                .find(|own| own.derivative == used.derivative)
            {
                Some(own) if used.certain() > own.certain() => *own = used,
                Some(_) => {}
                None => axis.limits.push(used),
            }
        }
    }
}

/// Refuses a record that cannot be one of this machine.
/// So many rows stand before.
fn check_rows(setup: &Setup<'_>, recorded: &Recorded, before: u64) -> Result<(), SimError> {
    let rows = recorded.time_s.len();
    let counted = |row: usize| before + row as u64 + 1;
    if let Some(row) = (1..rows).find(|&row| {
        recorded.time_s[row].partial_cmp(&recorded.time_s[row - 1])
            != Some(std::cmp::Ordering::Greater)
    }) {
        return Err(SimError::refused(
            format!(
                "row {}: the time {} s is not after {} s, the time of the row before",
                counted(row),
                recorded.time_s[row],
                recorded.time_s[row - 1]
            ),
            "rows have to be in order of time, none twice",
        ));
    }
    for axis in &recorded.axes {
        if axis.values.len() != rows {
            let what = format!(
                "axis {} has {} positions for {rows} rows",
                axis.axis,
                axis.values.len()
            );
            return Err(SimError::refused(what, "one position a row"));
        }
        if let Some(row) = axis.values.iter().position(|value| !value.is_finite()) {
            let what = format!(
                "row {}: the position of axis {} is not a number",
                counted(row),
                axis.axis
            );
            return Err(SimError::refused(what, "leave the row out"));
        }
    }
    let has = |wanted: AxisId| recorded.axes.iter().any(|axis| axis.axis == wanted);
    // Tools have X, Y and Z whatever the joints are called.
    let needed: Vec<AxisId> = if recorded.of_tool {
        vec![AxisId::X, AxisId::Y, AxisId::Z]
    } else {
        let curved = setup.kinematics.joint_map() != lostmotion_kinematics::JointMap::Shifted;
        let joints = setup.machine.axes().iter();
        joints
            .map(|axis| axis.id)
            .filter(|id| curved || id.index() < 3)
            .collect()
    };
    if let Some(missing) = needed.into_iter().find(|axis| !has(*axis)) {
        return Err(SimError::refused(
            format!(
                "the record has no axis {missing}, which the machine `{}` has",
                setup.machine.name()
            ),
            "log all axes that move the tool",
        ));
    }
    Ok(())
}

/// The record as the program sees it, and as the joints do.
struct Channels<'a> {
    recorded: &'a Recorded,
    /// The tool in the coordinates that the path is in.
    points: Vec<[f64; 3]>,
    joints: Vec<(AxisId, Vec<f64>, Fineness)>,
    /// How far a point may be off, mm.
    error_mm: f64,
}

impl<'a> Channels<'a> {
    fn new(
        setup: &Setup<'_>,
        recorded: &'a Recorded,
        path: &ProgrammedPath,
    ) -> Result<Channels<'a>, SimError> {
        let rows = recorded.time_s.len();
        let row = |row: usize| {
            let mut coords = Coords::ZERO;
            for axis in &recorded.axes {
                coords.0[axis.axis.index()] = axis.values[row];
            }
            coords
        };
        let kinematics = &setup.kinematics;
        let shifted = kinematics.joint_map() == lostmotion_kinematics::JointMap::Shifted;
        let points = (0..rows)
            .map(|index| {
                let coords = row(index);
                if path.is_tip && !recorded.of_tool {
                    kinematics.forward(&coords, &path.tool_mm).linear()
                } else {
                    coords.linear()
                }
            })
            .collect();
        let fineness: Vec<(AxisId, Fineness)> = recorded
            .axes
            .iter()
            .map(|axis| (axis.axis, Fineness::of(&axis.values)))
            .collect();
        // A point is off by what its three coordinates are off; on machines whose joints do not go
        // with the tool about as far.
        let square: f64 = fineness
            .iter()
            .filter(|(axis, _)| axis.index() < 3)
            .map(|(_, fineness)| {
                let bound = fineness.bound(3 * rows);
                bound * bound
            })
            .sum();
        let joints = if recorded.of_tool && !shifted {
            let mut columns = vec![Vec::with_capacity(rows); setup.machine.axes().len()];
            for index in 0..rows {
                let joints = kinematics.inverse(&row(index), &path.tool_mm)?;
                for (column, axis) in columns.iter_mut().zip(setup.machine.axes()) {
                    column.push(joints.0[axis.id.index()]);
                }
            }
            let ids = setup.machine.axes().iter().map(|axis| axis.id);
            ids.zip(columns)
                .map(|(id, values)| {
                    let fineness = Fineness::of(&values);
                    (id, values, fineness)
                })
                .collect()
        } else {
            let values = recorded.axes.iter().map(|axis| axis.values.clone());
            fineness
                .iter()
                .zip(values)
                .map(|((id, fineness), values)| (*id, values, *fineness))
                .collect()
        };
        Ok(Channels {
            recorded,
            points,
            joints,
            error_mm: square.sqrt(),
        })
    }

    /// Holds each axis against its limits.
    fn axes(
        &self,
        setup: &Setup<'_>,
        rows: std::ops::Range<usize>,
        blocks: &mut Blocks<'_>,
        feet: &[Foot],
        untold: &mut Vec<String>,
    ) -> Vec<RecordedAxisCheck> {
        let time_s = self.recorded.time_s.get(rows.clone()).unwrap_or_default();
        let time_bound_s = time_bound_s(time_s);
        let mut found = Vec::new();
        for (id, values, fineness) in &self.joints {
            let Some(axis) = setup.machine.axis(*id) else {
                continue;
            };
            let channel = Channel {
                time_s,
                values: values.get(rows.clone()).unwrap_or_default(),
                fineness: *fineness,
                time_bound_s,
            };
            let unit = if axis.is_rotary() { deg(1.0) } else { 1.0 };
            let mut limits = Vec::new();
            let is_measured = self.recorded.kind == RecordKind::Measured;
            let slack = if is_measured {
                SERVO_SLACK
            } else {
                LIMIT_SLACK
            };
            // What friction and a gap do to the jerk of a load is no fault of the control.
            let held = if is_measured { 2 } else { DERIVATIVES.len() };
            for (order, derivative) in DERIVATIVES.into_iter().take(held).enumerate() {
                let limit = match derivative {
                    Derivative::Velocity => axis.limits.velocity,
                    Derivative::Acceleration => axis.limits.acceleration,
                    Derivative::Jerk => axis.limits.jerk,
                };
                // Between two commands the jerk is the interpolation's.
                let least_s = match derivative {
                    Derivative::Jerk => {
                        (order + 1) as f64 * setup.machine.cycles().command().period_s()
                    }
                    Derivative::Velocity | Derivative::Acceleration => 0.0,
                };
                let order = Order(order + 1);
                let mut worst: Option<LimitUse> = None;
                for rate in channel.rates(order, least_s) {
                    let Some(foot) = feet.get(rate.row) else {
                        continue;
                    };
                    let is_exceeded = rate.certain() > limit * (1.0 + slack);
                    let used = LimitUse {
                        axis: *id,
                        derivative,
                        limit: limit * unit,
                        found: rate.value.abs() * unit,
                        plus_minus: rate.error * unit,
                        times: rate.value.abs() / limit,
                        over_s: rate.over_s,
                        time_s: time_s[rate.row],
                        block: blocks
                            .path
                            .pieces
                            .get(foot.piece)
                            .map(|piece| piece.block)
                            .unwrap_or_default(),
                        is_exceeded,
                    };
                    let more = |than: &LimitUse| rate.certain() / limit > than.certain();
                    if worst.as_ref().is_none_or(more) {
                        worst = Some(used.clone());
                    }
                    blocks.limit(foot.piece, used);
                }
                let least = channel
                    .errors(order)
                    .into_iter()
                    .min_by(|a, b| a.1.total_cmp(&b.1));
                if let Some((over_s, error)) =
                    least.filter(|(_, error)| *error > TOLD_SHARE * limit)
                {
                    let letter = if axis.is_rotary() { "deg" } else { "mm" };
                    untold.push(format!(
                        "whether axis {id} keeps its {derivative} of {}: rounding and noise of the log make +-{} {letter} and s of it even over {:.0} ms",
                        short(limit * unit),
                        short(error * unit),
                        1e3 * over_s,
                    ));
                }
                limits.extend(worst);
            }
            found.push(RecordedAxisCheck {
                axis: *id,
                unit: if axis.is_rotary() { "deg" } else { "mm" }.to_owned(),
                step: fineness.step * unit,
                noise: fineness.noise * unit,
                limits,
            });
        }
        found
    }
}

/// Three digits of a number of any size.
fn short(value: f64) -> String {
    let digits = 2.0 - lostmotion_base::math::log10(value.abs().max(1e-9)).floor();
    format!("{value:.*}", digits.clamp(0.0, 9.0) as usize)
}
