//! A recorded motion held against its program: where in the program it is, how far it leaves the
//! programmed path, and whether it keeps the limits of the machine.
//!
//! The record may begin and end anywhere in the program, at any clock, with overrides, feed holds and
//! pauses (`locate`). A limit counts as exceeded where the record proves it, whatever its rounding
//! and noise (`rates`).

mod blocks;
mod channels;
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
use channels::{Channels, needed};
use locate::{Coordinates, Located, Unfound, follow, goes_on, locate};
use lostmotion_base::{AxisId, BlockRef};
use path::{Foot, ProgrammedPath};
use results::{
    RECORD_SCHEMA, RecordCheck, RecordCoordinates, RecordKind, RecordPlace, RecordedAxisCheck,
};

/// Time between rows beyond which limits are not told, and beyond which nothing is, s. Choices: a stroke's
/// acceleration lasts some 0.1 s, and blocks last some 0.5.
const SLOW_S: f64 = 0.1;
const SLOWEST_S: f64 = 0.5;
/// Distance that a fitted shift may leave, RMS, in multiples of what programs, servos and roundings
/// explain. A choice.
const DOUBTFUL: f64 = 2.0;
/// Other places that are listed.
const MOST_OTHERS: usize = 10;

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
    let (checked, paths) = program(setup, options)?;
    let mut record = Record::new(setup, &paths, options);
    record.part(recorded, 0)?;
    record.finish(checked)
}

/// The same of a record in parts, each with how many rows of the one before it begins with.
pub(crate) fn check_parts<E: From<SimError>>(
    setup: &Setup<'_>,
    next: &mut dyn FnMut() -> Result<Option<(Recorded, usize)>, E>,
    options: &RecordOptions,
) -> Result<RecordCheck, E> {
    let (checked, paths) = program(setup, options)?;
    let mut record = Record::new(setup, &paths, options);
    while let Some((recorded, shared)) = next()? {
        record.part(&recorded, shared)?;
    }
    Ok(record.finish(checked)?)
}

/// The program, checked, and its paths: one, or one for each tool and kind of coordinates.
fn program(
    setup: &Setup<'_>,
    options: &RecordOptions,
) -> Result<(Checked, Vec<ProgrammedPath>), SimError> {
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
    let paths = path::read(
        Curves::new(setup)?,
        setup.kinematics.joint_map(),
        setup.machine.planner().exact_path_tolerance_mm,
        options.max_moves,
    )?;
    if paths.is_empty() {
        return Err(SimError::refused(
            "the program does not move the tool",
            "is it the right file?",
        ));
    }
    Ok((checked, paths))
}

/// A record that is held against its program part by part. The first part that moves is looked for in
/// the program; the others go on where the one before ends.
struct Record<'a> {
    setup: &'a Setup<'a>,
    paths: &'a [ProgrammedPath],
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
    /// The path, and which one of the program's.
    path: &'a ProgrammedPath,
    section: usize,
    kind: RecordKind,
    period_s: f64,
    located: Located,
    from_s: f64,
    to_s: f64,
    first: Foot,
    /// First blocks of other places that fit as well.
    others: Vec<BlockRef>,
    /// How far a point may be off without the shift, mm.
    error_mm: f64,
    /// The last feet, as many as parts share.
    tail: Vec<Foot>,
    blocks: Blocks<'a>,
    holes: Holes,
    axes: Vec<RecordedAxisCheck>,
    untold: Vec<String>,
}

/// Where a part of a record was found: its path, which one of the program's, and its columns.
struct FoundPart<'a, 'r> {
    path: &'a ProgrammedPath,
    section: usize,
    channels: Channels<'r>,
    /// First blocks of other places that fit as well.
    others: Vec<BlockRef>,
}

impl OnPath<'_> {
    /// Takes the feet of the rows of a part, behind those that it shares with the one before.
    fn feet(&mut self, time_s: &[f64], feet: &[Foot], shared: usize) {
        let mut before = self.tail.last().map(|foot| (self.to_s, *foot));
        for (time_s, foot) in time_s.iter().zip(feet).skip(shared) {
            let now = (*time_s, *foot);
            if let Some(before) = before.replace(now) {
                self.holes.between(before, now, self.period_s);
            }
            self.blocks.add(now.0, foot);
        }
        self.to_s = time_s.last().copied().unwrap_or(self.to_s);
    }

    /// Where the next part is, whose first rows are the last ones of the part before.
    fn goes_on(&self, channels: &Channels<'_>, shared: usize) -> Located {
        let first = shared.saturating_sub(self.tail.len());
        let known = self.tail.len().saturating_sub(shared);
        let place_mm = self.tail.get(known).map_or(0.0, |foot| foot.place_mm);
        let points = channels.points.get(first..).unwrap_or_default();
        let error_mm = channels.error_mm;
        let last = first + goes_on(self.path, points, place_mm, &self.located, error_mm);
        Located {
            rows: (first, last),
            place_mm,
            ..self.located.clone()
        }
    }
}

impl<'a> Record<'a> {
    fn new(
        setup: &'a Setup<'a>,
        paths: &'a [ProgrammedPath],
        options: &'a RecordOptions,
    ) -> Record<'a> {
        Record {
            setup,
            paths,
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
        let again = shared;
        // Where the part is: found, or behind the last feet.
        let (place, located, shared) = match &self.on_path {
            None => match self.find(recorded) {
                Ok((place, located)) => (place, located, 0),
                Err(error @ Unfound::Rests(_)) => {
                    self.rows_before += fresh;
                    self.unfound = Some(error.into());
                    return Ok(());
                }
                Err(error) => return Err(error.into()),
            },
            Some(found) => {
                let place = FoundPart {
                    path: found.path,
                    section: found.section,
                    channels: Channels::new(self.setup, recorded, found.path)?,
                    others: Vec::new(),
                };
                let first = shared.saturating_sub(found.tail.len());
                let located = found.goes_on(&place.channels, shared);
                (place, located, shared - first)
            }
        };
        let (path, channels) = (place.path, place.channels);
        let error_mm = channels.error_mm;
        let (first, last) = located.rows;
        self.is_behind = last + 1 < rows;
        self.one_section(place.section, first)?;
        self.rows_behind += (rows - 1 - last.min(rows - 1)) as u64;
        let on_path = channels.points.get(first..=last).unwrap_or_default();
        let at = |point: &[f64; 3]| lostmotion_base::vec::sub(*point, located.shift_mm);
        let feet = follow(path, on_path.iter().map(at), located.place_mm, error_mm);
        let (own_mm, error_mm) = (error_mm, error_mm + located.shift_error_mm);
        let time = |row: usize| recorded.time_s.get(row).copied().unwrap_or_default();
        let found = match &mut self.on_path {
            Some(found) => found,
            None => {
                self.rows_before = (self.rows_before + first as u64).saturating_sub(again as u64);
                let steps = recorded.time_s.windows(2).map(|pair| pair[1] - pair[0]);
                self.on_path.insert(OnPath {
                    path,
                    section: place.section,
                    others: place.others,
                    error_mm: own_mm,
                    kind: recorded.kind,
                    period_s: lostmotion_base::math::quantile(steps.collect(), 0.5),
                    from_s: time(first),
                    to_s: 0.0,
                    first: feet.first().copied().unwrap_or_default(),
                    tail: Vec::new(),
                    blocks: Blocks::new(self.setup, recorded, path, error_mm),
                    holes: Holes::default(),
                    axes: Vec::new(),
                    untold: Vec::new(),
                    located,
                })
            }
        };
        found.blocks.error_mm = found.blocks.error_mm.max(error_mm);
        let times = recorded.time_s.get(first..=last).unwrap_or_default();
        found.feet(times, &feet, shared);
        let mut untold = Vec::new();
        let range = first..last + 1;
        let joints = channels.joints(self.setup, path, &found.located, range.clone())?;
        let axes = channels.axes(
            self.setup,
            &joints,
            range,
            &mut found.blocks,
            &feet,
            &mut untold,
        );
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

    /// Looks for a part in each path of the program, at first in coordinates that are known. The
    /// path that has most of its rows counts, of equal ones the first.
    fn find<'r>(&self, recorded: &'r Recorded) -> Result<(FoundPart<'a, 'r>, Located), Unfound> {
        let passes: &[bool] = match (self.paths, self.options.shifted) {
            ([_], shifted) => &[shifted],
            (_, true) => &[false, true],
            (_, false) => &[false],
        };
        let mut unfound = None;
        for &shifted in passes {
            let mut found: Vec<(FoundPart<'a, 'r>, Located)> = Vec::new();
            let mut longest_mm = 0.0;
            for (section, path) in self.paths.iter().enumerate() {
                let channels = Channels::new(self.setup, recorded, path)?;
                match locate(path, &channels.points, channels.error_mm, shifted) {
                    Ok(located) => {
                        let others = located.others.iter();
                        let place = FoundPart {
                            path,
                            section,
                            channels,
                            others: others.map(|mm| path.block(path.at(*mm))).collect(),
                        };
                        found.push((place, located));
                    }
                    // What hinders it on the longest path says most.
                    Err(error) if path.length_mm >= longest_mm => {
                        longest_mm = path.length_mm;
                        unfound = Some(error);
                    }
                    Err(_) => {}
                }
            }
            let rows =
                |(_, located): &(FoundPart<'_, '_>, Located)| located.rows.1 - located.rows.0;
            let most = found.iter().map(rows).max().unwrap_or_default();
            found.retain(|one| rows(one) * 100 >= most * 98);
            let mut found = found.into_iter();
            if let Some((mut place, located)) = found.next() {
                for (other, at) in found {
                    place
                        .others
                        .push(other.path.block(other.path.at(at.place_mm)));
                    place.others.extend(other.others);
                }
                return Ok((place, located));
            }
        }
        let nowhere = || Unfound::Elsewhere(SimError::refused("the log follows no path", ""));
        Err(unfound.unwrap_or_else(nowhere))
    }

    /// Refuses a record that moves on before or behind its path where the program goes on with
    /// another tool or in other coordinates. `first` is its first row on the path.
    fn one_section(&self, section: usize, first: usize) -> Result<(), SimError> {
        let is_first = self.on_path.is_none();
        let change = if is_first && first > 0 && section > 0 {
            Some((section, "before"))
        } else if self.is_behind && section + 1 < self.paths.len() {
            Some((section + 1, "behind"))
        } else {
            None
        };
        let Some((section, which)) = change else {
            return Ok(());
        };
        let block = self.paths.get(section).map(|path| path.block(0));
        Err(SimError::refused(
            format!(
                "{}: the program changes its tool or its coordinates here, on a machine whose joints do not go with the tool, and the log moves {which} that, too",
                block.unwrap_or_default().span
            ),
            "check the log of each part of the program by itself: --from and --to take a part of the log",
        ))
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
        let path = found.path;
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
        if let Some(gantry) = self.setup.machine.gantry() {
            untold.push(format!(
                "what the second motor of axis {} does, and how far it is from the first: one position of each axis is checked",
                gantry.axis
            ));
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
        let mut answer = RecordCheck {
            schema: RECORD_SCHEMA,
            program: checked.program,
            machine: self.setup.machine.name().to_owned(),
            kind: found.kind,
            period_s: found.period_s,
            place: RecordPlace {
                first: path.block(found.first.piece),
                last: path.block(found.tail.last().map_or(0, |foot| foot.piece)),
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
                others: found.others.iter().take(MOST_OTHERS).copied().collect(),
                other_places: found.others.len() as u64,
            },
            axes: found.axes,
            untold,
            ..RecordCheck::default()
        };
        found.blocks.finish(&mut answer, self.options.keep_blocks);
        answer
            .untold
            .extend(doubt(self.setup, path, found.error_mm, &answer));
        let mut texts = BlockTexts::new(self.setup.program, checked.files);
        for block in &mut answer.blocks {
            block.text = texts.at(block.block.span);
        }
        Ok(answer)
    }
}

/// Whether a fitted shift leaves more than programs, servos and roundings explain: then it is no
/// shift that the log is off by.
fn doubt(
    setup: &Setup<'_>,
    path: &ProgrammedPath,
    error_mm: f64,
    answer: &RecordCheck,
) -> Option<String> {
    if answer.place.coordinates != RecordCoordinates::Shifted {
        return None;
    }
    let told = setup.options.tolerance_um;
    let verdict_um = told.unwrap_or(setup.machine.simulate().tolerance_um);
    let blending = path.pieces.iter().filter_map(|piece| piece.tolerance_mm);
    let usual_um = 1e3 * (blending.fold(0.0, f64::max) + error_mm) + verdict_um;
    let instead = if path.is_tip {
        "an angle, as the offset of a rotary axis, a tool or a scale may be off instead"
    } else {
        "a scale or a tool may be off instead"
    };
    (answer.deviation_rms_um > DOUBTFUL * usual_um).then(|| {
        format!(
            "whether the log is off by a shift at all: behind the one that was fitted {} um RMS are left; {instead}",
            short(answer.deviation_rms_um)
        )
    })
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
    let missing = needed(setup, recorded.of_tool)
        .into_iter()
        .find(|axis| !has(*axis));
    if let Some(missing) = missing {
        let machine = setup.machine.name();
        let what = if recorded.of_tool && missing.index() >= 3 {
            format!(
                "the record has no axis {missing}, and the joints of the machine `{machine}` depend on it"
            )
        } else {
            format!("the record has no axis {missing}, which the machine `{machine}` has")
        };
        return Err(SimError::refused(what, "log all axes that move the tool"));
    }
    Ok(())
}

/// Three digits of a number of any size.
fn short(value: f64) -> String {
    let digits = 2.0 - lostmotion_base::math::log10(value.abs().max(1e-9)).floor();
    format!("{value:.*}", digits.clamp(0.0, 9.0) as usize)
}
