//! The positions of several axes, on one clock, in mm and rad.

use crate::axis::{DEFAULT_ROWS, FEWEST_ROWS};
use crate::clocks::Track;
use crate::collect::{Collector, Part};
use crate::error::LogError;
use crate::motion::{Jump, Spike, held, jumps, say_spikes, spikes, unwrap, wrap};
use crate::reader::LogReader;
use crate::roles::{Assigned, ColumnSpec, Role, assign_told};
use crate::source::{Format, Header, ReadOptions};
use crate::unit::{Quantity, Unit, stem};
use lostmotion_base::AxisId;
use lostmotion_base::text::shortened;
use std::f64::consts::TAU;
use std::io::BufRead;

/// Longest list of names in a message, characters.
const LONGEST_SHOWN: usize = 240;
/// Fewest changes of a column from which its clock is told.
const FEWEST_CHANGES: usize = 20;

/// What to take of a log of several axes.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionOptions {
    /// How the log is read.
    pub read: ReadOptions,
    /// Which channel is which axis, beside what names tell: roles are [`Role::Axis`] and
    /// [`Role::Time`].
    pub columns: Vec<ColumnSpec>,
    /// The axes of the machine, in the order in which its control numbers joints.
    pub axes: Vec<AxisId>,
    /// The axes without which the log is refused.
    pub needed: Vec<AxisId>,
    /// Unit of lengths where the log does not tell it; angles are then in deg.
    pub unit: Option<Unit>,
    /// First time taken, s of the log.
    pub from_s: f64,
    /// Last time taken, s of the log.
    pub to_s: f64,
    /// Most rows taken, from the first time on.
    pub max_rows: usize,
}

impl Default for PositionOptions {
    fn default() -> Self {
        PositionOptions {
            read: ReadOptions::default(),
            columns: Vec::new(),
            axes: vec![AxisId::X, AxisId::Y, AxisId::Z],
            needed: Vec::new(),
            unit: None,
            from_s: f64::NEG_INFINITY,
            to_s: f64::INFINITY,
            max_rows: DEFAULT_ROWS,
        }
    }
}

/// Where recorded positions come from, as far as their names tell.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PositionKind {
    /// Commands of the control.
    Commanded,
    /// What an encoder or a scale has read.
    Measured,
}

/// The positions of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisPositions {
    /// The axis.
    pub axis: AxisId,
    /// Whether it turns: its channel is an angle.
    pub is_angle: bool,
    /// Positions, mm or rad.
    pub values: Vec<f64>,
}

/// A log of several axes.
#[derive(Clone, Debug, PartialEq)]
pub struct PositionLog {
    /// Format of the log.
    pub format: Format,
    /// Time of each row, s, rising.
    pub time_s: Vec<f64>,
    /// Line of the log that each row stands in.
    pub line: Vec<u64>,
    /// The axes that were found, in the order of the machine's.
    pub axes: Vec<AxisPositions>,
    /// What they are; `None` where names do not tell it.
    pub kind: Option<PositionKind>,
    /// What was found, taken for granted or mended, for the user.
    pub said: Vec<String>,
}

/// Reads the positions of the axes of a machine out of a log. `name` is the file's name for
/// messages.
///
/// Channels of different clocks are brought to the slowest one, values that a slower clock holds are
/// taken once, angles that wrap at a turn are added up. Up to three rows in which an axis is off and
/// comes back are left out and said. A place that jumps and stays is left as it is and said: in a
/// log of commands it is a fault of the control.
///
/// ```
/// use lostmotion_base::AxisId;
/// use lostmotion_logs::{PositionOptions, read_positions};
///
/// let text = "t_s,x_mm,y_mm\n0,0,5\n0.001,0.25,5\n0.002,0.5,5\n";
/// let log = read_positions(text.as_bytes(), "log.csv", &PositionOptions::default())?;
/// assert_eq!((log.axes[0].axis, log.axes[0].values[2]), (AxisId::X, 0.5));
/// # Ok::<(), lostmotion_logs::LogError>(())
/// ```
///
/// # Errors
/// As [`LogReader`]; an axis that is needed and not found or found twice, a unit that is not told or
/// is none of a position, rows out of order, a log too short.
pub fn read_positions(
    input: impl BufRead,
    name: &str,
    options: &PositionOptions,
) -> Result<PositionLog, LogError> {
    let mut parts = PositionParts::new(input, name, options, options.max_rows, 0)?;
    match parts.next_part()? {
        Some((log, _)) => Ok(log),
        None => Err(LogError::file(name, "0 rows of data can be used", "")),
    }
}

/// A log of several axes, read part by part: as [`read_positions`], of a log that is larger than
/// memory.
///
/// How long values are held is told by the first part. A log of several clocks has one part, and
/// where time was lost behind the first one, the log ends; both are said.
pub struct PositionParts<'a> {
    name: String,
    reader: LogReader<'a>,
    format: Format,
    assigned: Vec<Assigned>,
    factors: Vec<f64>,
    angles: Vec<bool>,
    kind: Option<PositionKind>,
    collector: Collector,
    part: Part,
    /// Rows that may still be taken.
    left: usize,
    part_rows: usize,
    shared_rows: usize,
    said: Vec<String>,
    /// Rows that a value is held for, and the first of them; none before the first part.
    held: Option<(usize, usize)>,
    /// Rows of the log up to now.
    rows: usize,
    /// The last rows, as they stand in the log, and where turns are added up to in the first of them.
    tail: Track,
    added_up: Vec<f64>,
    ended: bool,
}

impl<'a> PositionParts<'a> {
    /// Reads the header; parts have so many new rows, and begin with so many of the part before.
    ///
    /// # Errors
    /// As [`read_positions`].
    pub fn new(
        input: impl BufRead + 'a,
        name: &str,
        options: &PositionOptions,
        part_rows: usize,
        shared_rows: usize,
    ) -> Result<PositionParts<'a>, LogError> {
        let mut read = options.read.clone();
        for spec in &options.columns {
            match spec.role {
                Role::Axis(_) => {}
                Role::Time => {
                    read.time_column = Some(spec.name.clone());
                    read.time_unit = spec.unit;
                }
                other => {
                    let what = format!("column {other}={}: this log is of several axes", spec.name);
                    let hint = "its roles are time and the letters of axes: x=NAME,unit=mm";
                    return Err(LogError::file(name, what, hint));
                }
            }
        }
        let mut reader = LogReader::new(input, name, &read)?;
        let header = reader.header().clone();
        let mut assigned = assign_told(name, &header, &options.columns)?;
        let mut said = vec![format!("format: {}", header.format)];
        said.extend(header.said.iter().cloned());
        let kind = assign_named(name, &header, options, &mut assigned, &mut said)?;
        assigned.sort_by_key(|other| other.role);
        check_needed(name, &header, &assigned, &options.needed)?;
        said.extend(second_motors(&header, &assigned));
        let (factors, angles) = factors(name, &header, &assigned, options.unit, &mut said)?;
        let channels: Vec<usize> = assigned.iter().map(|other| other.channel).collect();
        reader.select(&channels);
        Ok(PositionParts {
            name: name.to_owned(),
            format: header.format,
            collector: Collector::new(&reader, &assigned),
            reader,
            tail: Track::new(assigned.len()),
            added_up: vec![0.0; assigned.len()],
            assigned,
            factors,
            angles,
            kind,
            part: Part {
                from_s: options.from_s,
                to_s: options.to_s,
                max_rows: 0,
            },
            left: options.max_rows,
            part_rows,
            shared_rows,
            said,
            held: None,
            rows: 0,
            ended: false,
        })
    }

    /// The next part, and how many of its rows are the last ones of the part before; `None` behind
    /// the last one.
    ///
    /// # Errors
    /// As [`read_positions`].
    pub fn next_part(&mut self) -> Result<Option<(PositionLog, usize)>, LogError> {
        if self.ended {
            return Ok(None);
        }
        let mut said = std::mem::take(&mut self.said);
        let is_first = self.held.is_none();
        self.part.max_rows = self.part_rows.min(self.left);
        let mut track =
            self.collector
                .part(&mut self.reader, &self.factors, &self.part, &mut said)?;
        self.left -= track.len().min(self.left);
        let goes_on = self.collector.has_more && self.collector.has_one_clock() && self.left > 0;
        self.ended = !goes_on;
        if self.collector.has_more && !goes_on {
            said.push(format!(
                "the first {} rows are taken; more with --rows, others with --from and --to",
                self.rows + track.len()
            ));
        }
        said.extend(self.reader.remarks());
        let before = self.rows;
        self.rows += track.len();
        let (step, first) = *self.held.get_or_insert_with(|| held_rows(&track));
        if step > 1 {
            if is_first {
                said.push(format!(
                    "values are held for {step} rows: one of them is taken"
                ));
            }
            // The first of them that is not before this part.
            let behind = before.saturating_sub(first) % step;
            let phase = if before <= first {
                first - before
            } else {
                (step - behind) % step
            };
            track.thin(phase, step);
        }
        if is_first && track.len() < FEWEST_ROWS {
            let what = format!("{} rows of data can be used", track.len());
            let hint = format!("at least {FEWEST_ROWS} are needed");
            return Err(LogError::file(&self.name, what, hint));
        }
        let mut shared = self.tail.len();
        let mut whole = std::mem::take(&mut self.tail);
        whole.counted = track.counted;
        whole.append(track);
        let off = self.rows_off(&whole, &mut said);
        whole.leave_out(&off);
        shared -= off.partition_point(|row| *row < shared);
        let rest = whole.len().saturating_sub(self.shared_rows);
        self.tail = whole.clone();
        self.tail.keep(rest..whole.len());
        self.mend(&mut whole, shared, &mut said);
        self.added_up = whole
            .columns
            .iter()
            .map(|column| column.get(rest).copied().unwrap_or_default())
            .collect();
        let axes = self.assigned.iter().zip(&self.angles).zip(whole.columns);
        let log = PositionLog {
            format: self.format,
            time_s: whole.time_s,
            line: whole.line,
            axes: axes
                .filter_map(|((other, is_angle), values)| match other.role {
                    Role::Axis(axis) => Some(AxisPositions {
                        axis,
                        is_angle: *is_angle,
                        values,
                    }),
                    _ => None,
                })
                .collect(),
            kind: self.kind,
            said,
        };
        Ok(Some((log, shared)))
    }

    /// Rows where an axis is off and comes back, in order, and says so. They are left out, as out of
    /// logs of one axis.
    fn rows_off(&self, track: &Track, said: &mut Vec<String>) -> Vec<usize> {
        let mut off: Vec<usize> = Vec::new();
        for ((other, &is_angle), column) in
            self.assigned.iter().zip(&self.angles).zip(&track.columns)
        {
            let found = spikes(column);
            // At its ends an angle that wraps may toggle.
            let is_wrap = || {
                let jumps = jumps(&track.time_s, column);
                is_angle && wrap(column, &jumps, &[TAU], 1.0).is_some()
            };
            if found.is_empty() || is_wrap() {
                continue;
            }
            let unit = if is_angle { 1_f64.to_degrees() } else { 1.0 };
            let shown: Vec<Spike> = found
                .into_iter()
                .map(|spike| Spike {
                    size: spike.size * unit,
                    ..spike
                })
                .collect();
            let what = format!("axis {}", other.role);
            off.extend(say_spikes(&shown, track, &what, said));
        }
        off.sort_unstable();
        off.dedup();
        off
    }

    /// Adds up turns, and says where a place jumps behind the shared rows.
    fn mend(&self, track: &mut Track, shared: usize, said: &mut Vec<String>) {
        let axes = self.assigned.iter().zip(&self.angles).zip(&self.added_up);
        for (((other, &is_angle), &added_up), column) in axes.zip(&mut track.columns) {
            let found = jumps(&track.time_s, column);
            let new: Vec<&Jump> = found.iter().filter(|jump| jump.row >= shared).collect();
            if let Some(period) = is_angle
                .then(|| wrap(column, &found, &[TAU], 1.0))
                .flatten()
            {
                if !new.is_empty() {
                    said.push(format!(
                        "axis {} wraps {} times; it is added up",
                        other.role,
                        new.len()
                    ));
                }
                unwrap(&track.time_s, column, period);
            } else if let Some(jump) = new.first() {
                let shown = if is_angle {
                    jump.size.to_degrees()
                } else {
                    jump.size
                };
                said.push(format!(
                    "{} {}: axis {} jumps by {shown:.4} {}{}: rows are missing, or it was commanded so",
                    track.counted,
                    track.line.get(jump.row).copied().unwrap_or_default(),
                    other.role,
                    if is_angle { "deg" } else { "mm" },
                    if new.len() > 1 {
                        format!(", and {} times more", new.len() - 1)
                    } else {
                        String::new()
                    },
                ));
            }
            // On from the turns of the parts before.
            let turns = column
                .first()
                .filter(|_| is_angle && shared > 0)
                .map_or(0.0, |first| ((added_up - first) / TAU).round() * TAU);
            if turns != 0.0 {
                column.iter_mut().for_each(|value| *value += turns);
            }
        }
    }
}

/// How long values are held, and from which row on; an axis that moves freely shows the clock of the
/// log, one that hardly moves shows none.
fn held_rows(track: &Track) -> (usize, usize) {
    let changes = |values: &[f64]| values.windows(2).filter(|pair| pair[0] != pair[1]).count();
    track
        .columns
        .iter()
        .filter(|values| changes(values) > FEWEST_CHANGES)
        .map(|values| held(values))
        .min_by_key(|(step, _)| *step)
        .unwrap_or((1, 0))
}

/// Says of columns as `y2_mm` or `cmd_y2` that they are left out: an axis has one position.
fn second_motors(header: &Header, assigned: &[Assigned]) -> Option<String> {
    let is_motor = |word: &str| {
        let (letter, number) = word.split_at_checked(1).unwrap_or_default();
        let axis = letter.chars().next().and_then(AxisId::from_letter);
        let is_numbered = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
        is_numbered
            && assigned
                .iter()
                .any(|other| axis.map(Role::Axis) == Some(other.role))
    };
    let names: Vec<String> = header
        .channels
        .iter()
        .enumerate()
        .filter(|(place, _)| !assigned.iter().any(|other| other.channel == *place))
        .filter(|(_, channel)| {
            let name = stem(&channel.name).to_lowercase();
            name.split(['_', ' ', '-', '.']).any(is_motor)
        })
        .map(|(_, channel)| format!("`{}`", channel.name))
        .collect();
    (!names.is_empty()).then(|| {
        format!(
            "left out, as an axis has one position here: {}",
            shortened(&names.join(", "), LONGEST_SHOWN)
        )
    })
}

/// Refuses a log without an axis that is needed, or without any.
fn check_needed(
    name: &str,
    header: &Header,
    assigned: &[Assigned],
    needed: &[AxisId],
) -> Result<(), LogError> {
    let has = |axis: &AxisId| assigned.iter().any(|other| other.role == Role::Axis(*axis));
    let missing = needed.iter().find(|axis| !has(axis));
    let (what, letter) = match missing {
        Some(axis) => (format!("axis {axis}"), axis.letter().to_ascii_lowercase()),
        None if assigned.is_empty() => ("an axis".to_owned(), 'x'),
        None => return Ok(()),
    };
    let names: Vec<&str> = header
        .channels
        .iter()
        .map(|channel| channel.name.as_str())
        .collect();
    let what = format!(
        "no column is known to be the position of {what}; the columns are: {}",
        shortened(&names.join(", "), LONGEST_SHOWN)
    );
    let hint = format!("name it: --column {letter}=NAME,unit=mm");
    Err(LogError::file(name, what, hint))
}

/// What a name tells of a position: its axis, what it is, and how good a candidate it is.
fn axis_of(name: &str, axes: &[AxisId]) -> Option<(AxisId, Option<PositionKind>, u8)> {
    const COMMANDED: Option<PositionKind> = Some(PositionKind::Commanded);
    const MEASURED: Option<PositionKind> = Some(PositionKind::Measured);
    let lower = name.trim().to_lowercase();
    let lettered = |text: &str| {
        let mut letters = text.chars();
        match (letters.next(), letters.next()) {
            (Some(letter), None) => AxisId::from_letter(letter),
            _ => None,
        }
    };
    // LinuxCNC's pins: joint.0.motor-pos-cmd, axis.x.pos-cmd; joints by their numbers.
    if let Some((_, pin)) = lower
        .split_once("joint.")
        .or_else(|| lower.split_once("axis."))
    {
        let (which, signal) = pin.split_once('.')?;
        let numbered = which.parse::<usize>().ok().and_then(|at| axes.get(at));
        let axis = numbered.copied().or_else(|| lettered(which))?;
        // With the position that the planner commands before that with corrections added.
        return match signal {
            "pos-cmd" => Some((axis, COMMANDED, 0)),
            "joint-pos-cmd" | "teleop-pos-cmd" => Some((axis, COMMANDED, 1)),
            "motor-pos-cmd" => Some((axis, COMMANDED, 2)),
            "pos-fb" => Some((axis, MEASURED, 0)),
            "joint-pos-fb" => Some((axis, MEASURED, 1)),
            "motor-pos-fb" => Some((axis, MEASURED, 2)),
            _ => None,
        };
    }
    // Heidenhain's: s soll X, s ist/X.
    for (start, kind) in [
        ("s soll", COMMANDED),
        ("s noml", COMMANDED),
        ("s ist", MEASURED),
        ("s actual", MEASURED),
    ] {
        if let Some(rest) = lower.strip_prefix(start) {
            let letter = rest.trim_matches(|c: char| !c.is_alphanumeric());
            return Some((lettered(letter)?, kind, 0));
        }
    }
    let stem = stem(name);
    if let Some(axis) = lettered(&stem) {
        return Some((axis, None, 0));
    }
    // x_command, cmd_pos_x: a letter among words that are known.
    let (mut axis, mut kind, mut rank) = (None, None, 0);
    for word in stem.split(['_', ' ', '-']) {
        let found = match word {
            "pos" | "position" | "axis" => continue,
            "command" | "commanded" | "cmd" | "reference" | "setpoint" | "set" | "soll" => {
                COMMANDED
            }
            "measured" | "actual" | "act" | "fb" | "tool" | "ist" => MEASURED,
            "motor" | "load" => {
                rank = 1;
                MEASURED
            }
            letter => {
                // One letter, and nothing that is not known.
                if axis.is_some() {
                    return None;
                }
                axis = Some(lettered(letter)?);
                continue;
            }
        };
        if kind.is_some() {
            return None;
        }
        kind = found;
    }
    Some((axis?, kind, rank))
}

/// Adds the axes that names tell; returns what all positions are.
fn assign_named(
    file: &str,
    header: &Header,
    options: &PositionOptions,
    assigned: &mut Vec<Assigned>,
    said: &mut Vec<String>,
) -> Result<Option<PositionKind>, LogError> {
    let told: Vec<Option<PositionKind>> = assigned
        .iter()
        .filter_map(|other| header.channels.get(other.channel))
        .map(|channel| axis_of(&channel.name, &options.axes).and_then(|(_, kind, _)| kind))
        .collect();
    let named: Vec<_> = header
        .channels
        .iter()
        .enumerate()
        .filter_map(|(place, channel)| {
            let (axis, kind, rank) = axis_of(&channel.name, &options.axes)?;
            options
                .axes
                .contains(&axis)
                .then_some((place, axis, kind, rank))
        })
        .filter(|(place, axis, ..)| {
            !assigned
                .iter()
                .any(|other| other.channel == *place || other.role == Role::Axis(*axis))
        })
        .collect();
    // All of one kind: what was told decides, else commands, where every axis has one.
    let every = |kind: Option<PositionKind>| {
        !named.is_empty()
            && named.iter().all(|(_, axis, ..)| {
                named
                    .iter()
                    .any(|(_, other, of, _)| other == axis && *of == kind)
            })
    };
    let kinds = [
        Some(PositionKind::Commanded),
        Some(PositionKind::Measured),
        None,
    ];
    let kind = match told.first() {
        Some(first) => told
            .iter()
            .all(|kind| kind == first)
            .then_some(*first)
            .flatten(),
        None => kinds.into_iter().find(|kind| every(*kind)).flatten(),
    };
    for &axis in &options.axes {
        let mut candidates: Vec<_> = named
            .iter()
            .filter(|(_, of, of_kind, _)| *of == axis && (*of_kind == kind || kind.is_none()))
            .collect();
        candidates.sort_by_key(|(.., rank)| *rank);
        let (Some(best), next) = (candidates.first(), candidates.get(1)) else {
            continue;
        };
        let called = |place: usize| {
            header
                .channels
                .get(place)
                .map_or("", |channel| channel.name.as_str())
        };
        if let Some(next) = next.filter(|next| next.3 == best.3) {
            let (one, two) = (called(best.0), called(next.0));
            let what = format!("both `{one}` and `{two}` could be the position of axis {axis}");
            let letter = axis.letter().to_ascii_lowercase();
            let hint = format!("name one with --column {letter}=NAME");
            return Err(LogError::file(file, what, hint));
        }
        if !stem(called(best.0)).eq_ignore_ascii_case(&axis.to_string()) {
            said.push(format!("`{}` is taken for axis {axis}", called(best.0)));
        }
        assigned.push(Assigned {
            role: Role::Axis(axis),
            channel: best.0,
            unit: header.channels.get(best.0).and_then(|channel| channel.unit),
            factor: 1.0,
        });
    }
    Ok(kind)
}

/// What each channel is multiplied with to be in mm or rad, and whether it is an angle.
fn factors(
    name: &str,
    header: &Header,
    assigned: &[Assigned],
    unit: Option<Unit>,
    said: &mut Vec<String>,
) -> Result<(Vec<f64>, Vec<bool>), LogError> {
    let (mut factors, mut angles) = (Vec::new(), Vec::new());
    for other in assigned {
        let called = header
            .channels
            .get(other.channel)
            .map_or("", |channel| channel.name.as_str());
        let turns = matches!(other.role, Role::Axis(AxisId::A | AxisId::B | AxisId::C));
        let (quantity, factor) = match (other.unit, unit) {
            (Some(unit), _) => (unit.quantity, unit.factor),
            (None, None) => {
                let role = other.role;
                let what =
                    format!("the unit of `{called}`, the position of axis {role}, is not told");
                let hint =
                    format!("give it: --unit mm for all, or --column {role}={called},unit=UNIT");
                return Err(LogError::file(name, what, hint));
            }
            (None, Some(_)) if turns => {
                said.push(format!("`{called}` is taken to be in deg"));
                (Quantity::Angle, TAU / 360.0)
            }
            (None, Some(unit)) => (unit.quantity, unit.factor),
        };
        if !matches!(quantity, Quantity::Length | Quantity::Angle) {
            let what = format!("`{called}` is no position: it is neither a length nor an angle");
            let hint = "name the column of the position with --column";
            return Err(LogError::file(name, what, hint));
        }
        factors.push(other.factor * factor);
        angles.push(quantity == Quantity::Angle);
    }
    Ok((factors, angles))
}
