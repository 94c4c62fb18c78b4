//! The channels of one axis, on one clock, in one unit.

use crate::clocks::Track;
use crate::collect::{Part, collect};
use crate::error::LogError;
use crate::motion::{held, jumps, say_spikes, spikes, unwrap, wrap};
use crate::reader::LogReader;
use crate::roles::{Assigned, ColumnSpec, Role, assign};
use crate::source::{Format, Header, ReadOptions};
use crate::unit::{Quantity, Unit};
use std::io::BufRead;

/// Fewest rows of a log: velocity and acceleration are taken by differences.
pub(crate) const FEWEST_ROWS: usize = 3;
/// Time between rows, s, from which on times without a unit are not taken for seconds. A choice: a drive is
/// not identified from ten values a second, and milliseconds as seconds are far above.
const SLOWEST_GUESSED_S: f64 = 0.1;
/// Most rows that are taken where the caller does not say otherwise. A choice: a log of any size is
/// read and fitted in 64 MiB.
pub(crate) const DEFAULT_ROWS: usize = 200_000;

/// What to take of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisOptions {
    /// How the log is read.
    pub read: ReadOptions,
    /// Which channel is what, beside what names tell.
    pub columns: Vec<ColumnSpec>,
    /// Roles without which the log is refused. The motor is always one.
    pub needed: Vec<Role>,
    /// Roles that are left out even where the log has them.
    pub without: Vec<Role>,
    /// First time taken, s of the log.
    pub from_s: f64,
    /// Last time taken, s of the log.
    pub to_s: f64,
    /// Most rows taken, from the first time on.
    pub max_rows: usize,
}

impl Default for AxisOptions {
    fn default() -> Self {
        AxisOptions {
            read: ReadOptions::default(),
            columns: Vec::new(),
            needed: Vec::new(),
            without: Vec::new(),
            from_s: f64::NEG_INFINITY,
            to_s: f64::INFINITY,
            max_rows: DEFAULT_ROWS,
        }
    }
}

/// What drives the axis in a log.
#[derive(Clone, Debug, PartialEq)]
pub enum DriveSignal {
    /// Torque-forming current, A.
    Current(Vec<f64>),
    /// Torque of the motor, N m.
    Torque(Vec<f64>),
    /// Force of the motor at the load, N.
    Force(Vec<f64>),
}

impl DriveSignal {
    /// The values.
    pub fn values(&self) -> &[f64] {
        match self {
            DriveSignal::Current(values)
            | DriveSignal::Torque(values)
            | DriveSignal::Force(values) => values,
        }
    }
}

/// A log of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisLog {
    /// Format of the log.
    pub format: Format,
    /// Time of each row, s, rising.
    pub time_s: Vec<f64>,
    /// Line of the log that each row stands in.
    pub line: Vec<u64>,
    /// Unit of the positions: mm, deg or rad.
    pub unit: Unit,
    /// Motor positions in `unit`, at the load.
    pub motor: Vec<f64>,
    /// Load positions in `unit`; empty where there are none.
    pub load: Vec<f64>,
    /// Commanded positions in `unit`; empty where there are none.
    pub command: Vec<f64>,
    /// What drives the axis, if the log has it.
    pub drive: Option<DriveSignal>,
    /// What was found, taken for granted, mended or left out, for the user.
    pub said: Vec<String>,
}

/// Reads the channels of one axis out of a log. `name` is the file's name for messages.
///
/// Positions may be in any length or angle; they come out in the motor's unit, or in mm and deg
/// where that is no unit of an axis. Channels of different clocks are brought to the slowest one.
/// Values that a slower clock holds are taken once. Counters that wrap are added up. Where time was
/// lost the longest part is taken.
///
/// # Errors
/// As [`LogReader`]; a role that is needed and not found or found twice, a unit that is not told,
/// rows out of order, a log too short.
pub fn read_axis(
    input: impl BufRead,
    name: &str,
    options: &AxisOptions,
) -> Result<AxisLog, LogError> {
    let mut reader = LogReader::new(input, name, &read_options(name, options)?)?;
    let header = reader.header().clone();
    let (mut assigned, more) = assign(name, &header, &options.columns)?;
    assigned.retain(|other| !options.without.contains(&other.role));
    check_needed(name, &header, &assigned, options)?;
    keep_one_drive(&mut assigned, options);
    let (factors, unit) = factors(name, &header, &assigned)?;
    reader.select(
        &assigned
            .iter()
            .map(|other| other.channel)
            .collect::<Vec<_>>(),
    );
    let mut said = vec![format!("format: {}", header.format)];
    said.extend(header.said.iter().cloned());
    said.extend(more);
    let part = Part {
        from_s: options.from_s,
        to_s: options.to_s,
        max_rows: options.max_rows,
    };
    let mut track = collect(&mut reader, &assigned, &factors, &part, &mut said)?;
    said.extend(reader.remarks());
    let turn = (unit.quantity == Quantity::Angle).then(|| std::f64::consts::TAU / unit.factor);
    mend(&mut track, &assigned, &factors, turn, &mut said);
    check_rows(name, &header, &track)?;
    let mut log = AxisLog {
        format: header.format,
        time_s: track.time_s,
        line: track.line,
        unit,
        motor: Vec::new(),
        load: Vec::new(),
        command: Vec::new(),
        drive: None,
        said,
    };
    for (other, column) in assigned.iter().zip(track.columns) {
        match other.role {
            Role::Motor => log.motor = column,
            Role::Load => log.load = column,
            Role::Command => log.command = column,
            Role::Current => log.drive = Some(DriveSignal::Current(column)),
            Role::Torque => log.drive = Some(DriveSignal::Torque(column)),
            Role::Force => log.drive = Some(DriveSignal::Force(column)),
            _ => {}
        }
    }
    if let Some(what) = lost_sign(&log) {
        if options.needed.contains(&Role::Current) {
            let hint = "log the current with its sign, not its magnitude";
            return Err(LogError::file(name, what, hint));
        }
        log.said.push(format!("{what}; it is left out"));
        log.drive = None;
    }
    Ok(log)
}

/// How the log is read, with the column of times that is told among the roles.
///
/// # Errors
/// A role that is none of one axis.
fn read_options(name: &str, options: &AxisOptions) -> Result<ReadOptions, LogError> {
    let other = |spec: &&ColumnSpec| {
        use Role::{Angle, Axis, Deviation, Radius};
        matches!(spec.role, Axis(_) | Angle | Radius | Deviation)
    };
    if let Some(spec) = options.columns.iter().find(other) {
        let what = format!(
            "column {}={}: this log is of one axis",
            spec.role, spec.name
        );
        let hint = "its roles are time, command, motor, load, current, torque and force";
        return Err(LogError::file(name, what, hint));
    }
    let mut read = options.read.clone();
    if let Some(time) = options.columns.iter().find(|spec| spec.role == Role::Time) {
        read.time_column = Some(time.name.clone());
        read.time_unit = time.unit;
    }
    Ok(read)
}

/// Keeps one signal that drives the axis: the told one, else the current where there is one.
fn keep_one_drive(assigned: &mut Vec<Assigned>, options: &AxisOptions) {
    let driving: Vec<Role> = assigned
        .iter()
        .map(|other| other.role)
        .filter(|role| is_drive(*role))
        .collect();
    let kept = [Role::Current, Role::Torque, Role::Force]
        .into_iter()
        .find(|role| {
            let told = options.columns.iter().find(|spec| is_drive(spec.role));
            told.map_or(driving.contains(role), |told| told.role == *role)
        });
    assigned.retain(|other| !is_drive(other.role) || Some(other.role) == kept);
}

/// Refuses a log with too few rows, or with rows so far apart that the guess of the times' unit is wrong.
fn check_rows(name: &str, header: &Header, track: &Track) -> Result<(), LogError> {
    if track.len() < FEWEST_ROWS {
        let what = format!("{} rows of data can be used", track.len());
        return Err(LogError::file(
            name,
            what,
            format!("at least {FEWEST_ROWS} are needed"),
        ));
    }
    let apart_s = track.time_s.last().unwrap_or(&0.0) - track.time_s.first().unwrap_or(&0.0);
    let apart_s = apart_s / (track.len() - 1) as f64;
    let guessed = header.guessed_time.as_ref();
    if let Some(guessed) = guessed.filter(|_| apart_s > SLOWEST_GUESSED_S) {
        let what = format!("{guessed}, and its rows would be {apart_s:.3} s apart");
        let hint = "give it: --column time=NAME,unit=ms, or unit=s if that is right";
        return Err(LogError::file(name, what, hint));
    }
    Ok(())
}

fn is_drive(role: Role) -> bool {
    matches!(role, Role::Current | Role::Torque | Role::Force)
}

fn is_position(role: Role) -> bool {
    matches!(role, Role::Command | Role::Motor | Role::Load)
}

fn check_needed(
    name: &str,
    header: &Header,
    assigned: &[Assigned],
    options: &AxisOptions,
) -> Result<(), LogError> {
    for &role in std::iter::once(&Role::Motor).chain(&options.needed) {
        let found = assigned
            .iter()
            .any(|other| other.role == role || (role == Role::Current && is_drive(other.role)));
        if !found {
            let names: Vec<&str> = header
                .channels
                .iter()
                .map(|channel| channel.name.as_str())
                .collect();
            let names = lostmotion_base::text::shortened(&names.join(", "), 240);
            let is_accelerometer = matches!(
                header.format,
                Format::KlipperAccelerometer | Format::DuetAccelerometer
            );
            if is_accelerometer {
                let what = format!("an accelerometer's log has no {role}");
                let hint = "it is listed by `axis log` alone: a fit needs the positions and the current of a drive";
                return Err(LogError::file(name, what, hint));
            }
            let unit = if is_position(role) { "mm" } else { "a" };
            let what = format!(
                "there is no column `{role}_{unit}` and none that is known to be the {role}; the columns are: {names}"
            );
            let hint = format!(
                "name it: --column {role}=NAME,unit={}",
                unit.replace('a', "A")
            );
            return Err(LogError::file(name, what, hint));
        }
    }
    Ok(())
}

/// What each channel is multiplied with, and the unit of the positions.
fn factors(
    name: &str,
    header: &Header,
    assigned: &[Assigned],
) -> Result<(Vec<f64>, Unit), LogError> {
    let called = |other: &Assigned| {
        header
            .channels
            .get(other.channel)
            .map_or("", |channel| channel.name.as_str())
    };
    let positions = [Quantity::Length, Quantity::Angle];
    let mut unit: Option<Unit> = None;
    // The motor's unit first: the others follow it.
    let motor = assigned.iter().find(|other| other.role == Role::Motor);
    if let Some(motor) = motor {
        let found = motor.factor_to(name, called(motor), &positions, "a length or an angle")?;
        let usual = match (found.symbol, found.quantity) {
            ("mm" | "deg" | "rad", _) => found,
            (_, Quantity::Length) => Unit::MM,
            _ => Unit {
                quantity: Quantity::Angle,
                factor: std::f64::consts::TAU / 360.0,
                symbol: "deg",
            },
        };
        unit = Some(usual);
    }
    let unit = unit.unwrap_or(Unit::MM);
    let mut factors = Vec::new();
    for other in assigned {
        let (quantities, what): (&[Quantity], &str) = match other.role {
            Role::Current => (&[Quantity::Current], "a current"),
            Role::Torque => (&[Quantity::Torque], "a torque"),
            Role::Force => (&[Quantity::Force], "a force"),
            _ => (&positions, "a length or an angle"),
        };
        let found = other.factor_to(name, called(other), quantities, what)?;
        if is_position(other.role) && found.quantity != unit.quantity {
            let what = format!(
                "`{}` is in {found}, but the motor's position is in {unit}",
                called(other)
            );
            let hint = format!(
                "give both as lengths or both as angles; an angle of the motor with how far the axis moves for it: --column {}={},unit=mm,scale=MM_A_DEGREE",
                Role::Motor,
                motor.map_or("NAME", called)
            );
            return Err(LogError::file(name, what, hint));
        }
        let base = if is_position(other.role) {
            unit.factor
        } else {
            1.0
        };
        // The same unit is not divided by itself: values stay as they were written.
        let scale = if found.factor == base {
            1.0
        } else {
            found.factor / base
        };
        factors.push(other.factor * scale);
    }
    Ok((factors, unit))
}

/// Takes held values once, leaves out rows that are off, adds up wrapped counters, and cuts where a position
/// jumps.
fn mend(
    track: &mut Track,
    assigned: &[Assigned],
    factors: &[f64],
    turn: Option<f64>,
    said: &mut Vec<String>,
) {
    let positions: Vec<usize> = (0..assigned.len())
        .filter(|&place| is_position(assigned[place].role))
        .collect();
    // The slowest clock of the measured positions; a command may be slower than what is measured.
    let measured = positions
        .iter()
        .filter(|&&place| assigned[place].role != Role::Command);
    let slowest = measured
        .map(|&place| held(&track.columns[place]))
        .max_by_key(|(step, _)| *step);
    if let Some((step, first)) = slowest.filter(|(step, _)| *step > 1) {
        said.push(format!(
            "values are held for {step} rows: one of them is taken"
        ));
        track.thin(first, step);
    }
    let count = |place: usize| factors.get(place).copied().unwrap_or(1.0).abs();
    // A turn of the axis, or of what a scale makes an axis' position of: in its own unit, or else degrees or radians.
    let turns = |place: usize| -> Vec<f64> {
        let scale = assigned.get(place).map_or(1.0, |other| other.factor.abs());
        let scaled = match turn {
            _ if scale == 1.0 => vec![],
            Some(turn) => vec![turn * scale],
            None => vec![360.0 * count(place), std::f64::consts::TAU * count(place)],
        };
        turn.into_iter().chain(scaled).collect()
    };
    let mut off: Vec<usize> = Vec::new();
    for &place in &positions {
        let column = &track.columns[place];
        let found = spikes(column);
        // At its ends a counter may toggle.
        let is_wrap = || {
            wrap(
                column,
                &jumps(&track.time_s, column),
                &turns(place),
                count(place),
            )
            .is_some()
        };
        if found.is_empty() || is_wrap() {
            continue;
        }
        off.extend(say_spikes(
            &found,
            track,
            &format!("the {}", assigned[place].role),
            said,
        ));
    }
    off.sort_unstable();
    off.dedup();
    track.leave_out(&off);
    let mut cuts: Vec<usize> = Vec::new();
    for &place in &positions {
        let found = jumps(&track.time_s, &track.columns[place]);
        let role = assigned[place].role;
        if let Some(period) = wrap(&track.columns[place], &found, &turns(place), count(place)) {
            let wraps = unwrap(&track.time_s, &mut track.columns[place], period);
            said.push(format!(
                "the {role}'s position wraps {wraps} times at {period}; it is added up"
            ));
            continue;
        }
        for jump in &found {
            said.push(format!(
                "{} {}: the {role}'s position jumps by {:.4}: rows are missing, or it was set",
                track.counted,
                track.line.get(jump.row).copied().unwrap_or_default(),
                jump.size
            ));
        }
        cuts.extend(found.iter().map(|jump| jump.row));
    }
    if cuts.is_empty() {
        return;
    }
    // The longest stretch without a jump.
    cuts.extend([0, track.len()]);
    cuts.sort_unstable();
    cuts.dedup();
    let longest = cuts.windows(2).max_by_key(|pair| pair[1] - pair[0]);
    if let Some(&[from, to]) = longest.map(|pair| <&[usize; 2]>::try_from(pair).unwrap_or(&[0, 0]))
    {
        said.push(format!(
            "the longest stretch without a jump is taken, {} rows",
            to - from
        ));
        track.keep(from..to);
    }
}

/// What is wrong with a drive signal without its sign; `None` of one that has it.
fn lost_sign(log: &AxisLog) -> Option<String> {
    let values = log.drive.as_ref().map(DriveSignal::values)?;
    let (mut forth, mut back) = (0usize, 0usize);
    for pair in log.motor.windows(2) {
        forth += usize::from(pair[1] > pair[0]);
        back += usize::from(pair[1] < pair[0]);
    }
    let both = forth.min(back) * 10 > log.motor.len();
    let one_sign =
        values.iter().all(|&value| value >= 0.0) && values.iter().any(|&value| value > 0.0);
    let what = "the current is never negative though the axis moves both ways: its sign is lost";
    (both && one_sign).then(|| what.to_owned())
}
