//! Sheets of a ballbar: a radius or a deviation over the angle.

use crate::error::LogError;
use crate::reader::LogReader;
use crate::roles::{Assigned, ColumnSpec, Role, assign_told};
use crate::source::{Header, ReadOptions, Row};
use crate::unit::{Quantity, Unit, stem};
use lostmotion_base::text::shortened;
use std::f64::consts::{PI, TAU};
use std::io::BufRead;

/// Longest list of names in a message, characters.
const LONGEST_SHOWN: usize = 240;
/// Fewest rows of a sheet.
const FEWEST_ROWS: usize = 36;
/// Least turn of a sheet, rad. A choice: less tells no centre.
const LEAST_TURN: f64 = 0.5;
/// How far angles have to go back for it to be the other sense, rad. A choice: more than any noise.
const BACK: f64 = 0.2;
/// Farthest from one angle to the next, rad. A choice: wider gaps leave out what is looked for.
const WIDEST_STEP: f64 = 0.2;

/// Most turn of one sense, rad. A choice: a test has one to three turns, and degrees taken for radians
/// make 57 times as many.
const MOST_TURN: f64 = 20.0 * TAU;

/// What to take of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct BallbarOptions {
    /// Which channel is what, beside what names tell: roles are [`Role::Angle`], and
    /// [`Role::Radius`] or [`Role::Deviation`].
    pub columns: Vec<ColumnSpec>,
    /// Most rows taken.
    pub max_rows: usize,
}

impl Default for BallbarOptions {
    fn default() -> Self {
        BallbarOptions {
            columns: Vec::new(),
            max_rows: 1_000_000,
        }
    }
}

/// The rows of a sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct BallbarLog {
    /// Angles and values of each sense of rotation, in the order of the file: rad, going on beyond a
    /// turn, and mm.
    pub senses: Vec<Vec<(f64, f64)>>,
    /// Whether the values are deviations from a radius that the sheet does not tell; else radii.
    pub is_deviation: bool,
    /// What was found and taken for granted, for the user.
    pub said: Vec<String>,
}

/// Reads a sheet. `name` is the file's name for messages. Where angles turn round, the other sense
/// begins.
///
/// ```
/// use lostmotion_logs::{BallbarOptions, read_ballbar};
///
/// let mut text = "Winkel [Grad];Abweichung [um]\n".to_owned();
/// for degrees in 0..360 {
///     text += &format!("{degrees},0;{},5\n", degrees % 7);
/// }
/// let sheet = read_ballbar(text.as_bytes(), "sheet.csv", &BallbarOptions::default())?;
/// assert!(sheet.is_deviation && sheet.senses.len() == 1);
/// assert!((sheet.senses[0][3].1 - 0.0035).abs() < 1e-12);
/// # Ok::<(), lostmotion_logs::LogError>(())
/// ```
///
/// # Errors
/// As [`LogReader`]; a column that is not found or found twice, a unit that is none of it, angles
/// that hardly turn or leave wide gaps, fewer than 36 rows.
pub fn read_ballbar(
    input: impl BufRead,
    name: &str,
    options: &BallbarOptions,
) -> Result<BallbarLog, LogError> {
    let roles = [Role::Angle, Role::Radius, Role::Deviation];
    if let Some(spec) = options
        .columns
        .iter()
        .find(|spec| !roles.contains(&spec.role))
    {
        let what = format!(
            "column {}={}: this is a ballbar's sheet",
            spec.role, spec.name
        );
        let hint = "its roles are angle, radius and deviation";
        return Err(LogError::file(name, what, hint));
    }
    // A sheet has no times: rows follow one another.
    let read = ReadOptions {
        period_s: Some(1.0),
        ..ReadOptions::default()
    };
    let mut reader = LogReader::new(input, name, &read)?;
    let header = reader.header().clone();
    let mut said = vec![format!("format: {}", header.format)];
    // How far apart in time rows are plays no part.
    let timed = |said: &&String| !said.starts_with("rows are taken to be");
    said.extend(header.said.iter().filter(timed).cloned());
    let [angle, value] = columns(name, &header, options, &mut said)?;
    let is_deviation = value.role == Role::Deviation;
    let factors = [
        factor(name, &header, &angle, Quantity::Angle)?,
        factor(name, &header, &value, Quantity::Length)?,
    ];
    reader.select(&[angle.channel, value.channel]);
    let place = |wanted: usize| {
        let group = header
            .channels
            .get(wanted)
            .map_or(0, |channel| channel.group);
        let within = header.group(group).position(|other| other == wanted);
        (group, within.unwrap_or_default())
    };
    let (places, mut rows) = ([place(angle.channel), place(value.channel)], Vec::new());
    if places[0].0 != places[1].0 {
        let what = "angle and value are recorded by different clocks";
        return Err(LogError::file(name, what, "export them as one table"));
    }
    let mut row = Row::default();
    while reader.next_row(&mut row)? {
        if row.group != places[0].0 {
            continue;
        }
        if rows.len() == options.max_rows {
            said.push(format!("the first {} rows are taken", options.max_rows));
            break;
        }
        let [angle, value] = [0, 1].map(|index| {
            let at = row.values.get(places[index].1).copied();
            at.unwrap_or(f64::NAN) * factors[index]
        });
        if !(angle.is_finite() && value.is_finite()) {
            let what = format!("the angle {angle} rad with the value {value} mm is none");
            return Err(LogError::line(name, row.line, what, "leave the row out"));
        }
        if !is_deviation && value <= 0.0 {
            let what = format!("the radius {value} mm is not positive");
            let hint = "for deviations from the radius: --column deviation=NAME,unit=um";
            return Err(LogError::line(name, row.line, what, hint));
        }
        rows.push((row.line, angle, value));
    }
    said.extend(reader.remarks());
    Ok(BallbarLog {
        senses: senses(name, &rows)?,
        is_deviation,
        said,
    })
}

/// The channels of the angle and of the value.
fn columns(
    name: &str,
    header: &Header,
    options: &BallbarOptions,
    said: &mut Vec<String>,
) -> Result<[Assigned; 2], LogError> {
    let mut assigned = assign_told(name, header, &options.columns)?;
    let is_value = |role: Role| matches!(role, Role::Radius | Role::Deviation);
    let known = |name: &str| match stem(name).as_str() {
        "angle" | "winkel" | "theta" | "phi" | "position" => Some(Role::Angle),
        "radius" | "r" | "radius_measured" | "measured_radius" | "radius measured" => {
            Some(Role::Radius)
        }
        "deviation" | "abweichung" | "error" | "radial_deviation" | "radial deviation" | "dr" => {
            Some(Role::Deviation)
        }
        _ => None,
    };
    // A radius says more than a deviation: where a sheet has both it is taken.
    for wanted in [Role::Angle, Role::Radius, Role::Deviation] {
        let has = assigned
            .iter()
            .any(|other| other.role == wanted || (is_value(wanted) && is_value(other.role)));
        if has {
            continue;
        }
        let mut found = header
            .channels
            .iter()
            .enumerate()
            .filter(|(place, channel)| {
                known(&channel.name) == Some(wanted)
                    && !assigned.iter().any(|other| other.channel == *place)
            });
        if let (Some((channel, one)), next) = (found.next(), found.next()) {
            if let Some((_, other)) = next {
                let what = format!(
                    "both `{}` and `{}` could be the {wanted}",
                    one.name, other.name
                );
                let hint = format!("name one with --column {wanted}=NAME");
                return Err(LogError::file(name, what, hint));
            }
            said.push(format!("`{}` is taken for the {wanted}", one.name));
            assigned.push(Assigned {
                role: wanted,
                channel,
                unit: one.unit,
                factor: 1.0,
            });
        }
    }
    let of = |wanted: &dyn Fn(Role) -> bool| assigned.iter().find(|other| wanted(other.role));
    let angle = of(&|role| role == Role::Angle).cloned();
    let value = of(&is_value).cloned();
    match (angle, value) {
        (Some(angle), Some(value)) => Ok([angle, value]),
        (angle, _) => {
            let names: Vec<&str> = header
                .channels
                .iter()
                .map(|channel| channel.name.as_str())
                .collect();
            let (what, hint) = if angle.is_none() {
                ("angle", "name it: --column angle=NAME,unit=deg")
            } else {
                (
                    "radius or the deviation",
                    "name it: --column radius=NAME,unit=mm or --column deviation=NAME,unit=um",
                )
            };
            let what = format!(
                "no column is known to be the {what}; the columns are: {}",
                shortened(&names.join(", "), LONGEST_SHOWN)
            );
            Err(LogError::file(name, what, hint))
        }
    }
}

/// What a channel is multiplied with.
fn factor(
    name: &str,
    header: &Header,
    assigned: &Assigned,
    quantity: Quantity,
) -> Result<f64, LogError> {
    let called = header
        .channels
        .get(assigned.channel)
        .map_or("", |channel| channel.name.as_str());
    let (what, usual) = match quantity {
        Quantity::Angle => ("an angle", "deg"),
        _ => ("a length", "um"),
    };
    let unit: Unit = assigned
        .factor_to(name, called, &[quantity], what)
        .map_err(|error| {
            if assigned.unit.is_some() {
                return error;
            }
            let role = assigned.role;
            let text = format!("the unit of `{called}`, the {role}, is not told");
            let hint = format!("give it: --column {role}={called},unit={usual}");
            LogError::file(name, text, hint)
        })?;
    Ok(assigned.factor * unit.factor)
}

/// Rows of each sense, with angles that go on beyond a turn.
fn senses(name: &str, rows: &[(u64, f64, f64)]) -> Result<Vec<Vec<(f64, f64)>>, LogError> {
    if rows.len() < FEWEST_ROWS {
        let what = format!("{} rows of data", rows.len());
        let hint = format!("a circle needs at least {FEWEST_ROWS}");
        return Err(LogError::file(name, what, hint));
    }
    let mut whole: Vec<(f64, f64)> = Vec::with_capacity(rows.len());
    for &(line, angle, value) in rows {
        let Some(&(before, _)) = whole.last() else {
            whole.push((angle, value));
            continue;
        };
        let mut angle = angle;
        angle -= TAU * ((angle - before) / TAU).round();
        // A second circle may begin anywhere.
        let step = (angle - before).abs();
        if step > WIDEST_STEP && step < PI - 1e-9 && rows.len() > FEWEST_ROWS {
            let is_new = whole.len() >= FEWEST_ROWS;
            if !is_new {
                let what = format!("the angle goes on by {:.1} deg at once", step.to_degrees());
                let hint = "angles have to be no more than some degrees apart, in deg or rad as their column says";
                return Err(LogError::line(name, line, what, hint));
            }
        }
        whole.push((angle, value));
    }
    // The sense turns where angles have gone back from the farthest one.
    let mut found: Vec<Vec<(f64, f64)>> = Vec::new();
    let (mut from, mut farthest, mut sense) = (0, 0, 0.0);
    for (index, &(angle, _)) in whole.iter().enumerate() {
        let away = angle - whole[from].0;
        if sense == 0.0 && away.abs() > BACK {
            sense = away.signum();
            farthest = index;
        }
        if sense * (angle - whole[farthest].0) >= 0.0 {
            farthest = index;
        } else if sense != 0.0 && sense * (whole[farthest].0 - angle) > BACK {
            found.push(whole[from..=farthest].to_vec());
            (from, sense) = (farthest, -sense);
            farthest = index;
        }
    }
    found.push(whole[from..].to_vec());
    // Pieces of motion between two circles are none.
    let turn = |piece: &Vec<(f64, f64)>| match (piece.first(), piece.last()) {
        (Some(first), Some(last)) => (last.0 - first.0).abs(),
        _ => 0.0,
    };
    if let Some(most) = found.iter().map(turn).max_by(f64::total_cmp)
        && most > MOST_TURN
    {
        let what = format!("the angles go on for {:.0} turns", most / TAU);
        let hint = "are they in deg, and not in rad? --column angle=NAME,unit=deg";
        return Err(LogError::file(name, what, hint));
    }
    found.retain(|piece| turn(piece) >= LEAST_TURN && piece.len() >= FEWEST_ROWS);
    if found.is_empty() {
        let what = "the angles hardly turn";
        let hint = "are they in deg, and not in rad? --column angle=NAME,unit=rad";
        return Err(LogError::file(name, what, hint));
    }
    Ok(found)
}
