//! Which channel is what: told by the caller, or by the names that controls give.

use crate::error::LogError;
use crate::source::{Format, Header, ReadOptions};
use crate::unit::{Quantity, Unit, stem};
use lostmotion_base::AxisId;
use lostmotion_base::text::shortened;
use std::fmt;
use std::str::FromStr;

/// Longest list of names in a message, characters.
const LONGEST_SHOWN: usize = 240;

/// Names of a column of times, without their unit.
const TIME_NAMES: &[&str] = &[
    "t",
    "time",
    "zeit",
    "timestamp",
    "elapsed",
    "elapsed time",
    "zeitstempel",
];

/// What a channel is of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[non_exhaustive]
pub enum Role {
    /// Time of the rows.
    Time,
    /// Commanded position.
    Command,
    /// Position of the motor, at the load.
    Motor,
    /// Position of the load.
    Load,
    /// Torque-forming current.
    Current,
    /// Torque of the motor.
    Torque,
    /// Force of the motor at the load.
    Force,
    /// Angle of a ballbar ([`read_ballbar`](crate::read_ballbar)).
    Angle,
    /// Its radius.
    Radius,
    /// Its deviation from a radius.
    Deviation,
    /// Position of one of several axes ([`read_positions`](crate::read_positions)).
    Axis(AxisId),
}

const ROLES: &[(Role, &str)] = &[
    (Role::Time, "time"),
    (Role::Command, "command"),
    (Role::Motor, "motor"),
    (Role::Load, "load"),
    (Role::Current, "current"),
    (Role::Torque, "torque"),
    (Role::Force, "force"),
    (Role::Angle, "angle"),
    (Role::Radius, "radius"),
    (Role::Deviation, "deviation"),
];

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Role::Axis(axis) = self {
            return write!(f, "{}", axis.letter().to_ascii_lowercase());
        }
        let name = ROLES.iter().find(|(role, _)| role == self);
        f.write_str(name.map_or("", |(_, name)| name))
    }
}

impl FromStr for Role {
    type Err = String;

    fn from_str(text: &str) -> Result<Role, String> {
        let mut letters = text.chars();
        if let (Some(letter), None) = (letters.next(), letters.next())
            && let Some(axis) = AxisId::from_letter(letter)
        {
            return Ok(Role::Axis(axis));
        }
        ROLES
            .iter()
            .find(|(_, name)| *name == text)
            .map(|(role, _)| *role)
            .ok_or_else(|| {
                let known: Vec<&str> = ROLES.iter().map(|(_, name)| *name).collect();
                format!(
                    "`{text}` is no role of a column; there are {}, and the letters of axes",
                    known.join(", ")
                )
            })
    }
}

/// Which channel plays a role, and how its values are to be taken:
/// `motor=NAME,unit=um,sign=-,scale=2`.
///
/// ```
/// use lostmotion_logs::{ColumnSpec, Role};
///
/// let spec: ColumnSpec = "motor=s ist/Y,unit=um,sign=-".parse()?;
/// assert_eq!((spec.role, spec.name.as_str(), spec.factor), (Role::Motor, "s ist/Y", -1.0));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnSpec {
    /// The role.
    pub role: Role,
    /// The channel's name in the log, or the number of its column from 1, columns of times counted, too;
    /// of a log without columns that of the channel.
    pub name: String,
    /// Its unit; as the log tells it where this is `None`.
    pub unit: Option<Unit>,
    /// What its values are multiplied with: sign and scale.
    pub factor: f64,
}

impl FromStr for ColumnSpec {
    type Err = String;

    fn from_str(text: &str) -> Result<ColumnSpec, String> {
        let Some((role, rest)) = text.split_once('=') else {
            return Err(format!(
                "`{text}` is not ROLE=NAME, for example motor=s_ist,unit=um,sign=-"
            ));
        };
        let role = role.trim().parse()?;
        // Names may hold commas: options are taken from the end.
        let (mut name, mut unit, mut factor) = (rest, None, 1.0);
        while let Some((before, option)) = name.rsplit_once(',') {
            let Some((key, value)) = option.split_once('=') else {
                break;
            };
            match (key.trim(), value.trim()) {
                ("unit", value) => unit = Some(value.parse()?),
                ("sign", "-") => factor = -factor,
                ("sign", "+") => {}
                ("sign", other) => return Err(format!("sign `{other}` is neither + nor -")),
                ("scale", value) => {
                    let scale: f64 = value
                        .parse()
                        .map_err(|_| format!("scale `{value}` is not a number"))?;
                    if !(scale.is_finite() && scale != 0.0) {
                        return Err(format!(
                            "scale `{value}` is not a finite number other than zero"
                        ));
                    }
                    factor *= scale;
                }
                _ => break,
            }
            name = before;
        }
        if name.trim().is_empty() {
            return Err(format!("`{text}` names no column"));
        }
        Ok(ColumnSpec {
            role,
            name: name.trim().to_owned(),
            unit,
            factor,
        })
    }
}

/// What a control's name for a signal tells of its role.
fn role_of(format: Format, name: &str) -> Option<Role> {
    let lower = name.to_lowercase();
    let has = |part: &str| lower.contains(part);
    let named = match format {
        Format::SinumerikTrace if has("cmdpos") => Some(Role::Command),
        Format::SinumerikTrace if has("actpos1stenc") => Some(Role::Motor),
        Format::SinumerikTrace if has("actpos2ndenc") => Some(Role::Load),
        Format::SinumerikTrace if has("actcurr") => Some(Role::Current),
        Format::SinumerikTrace if has("cmdtorque") => Some(Role::Torque),
        Format::Tncscope if lower.starts_with("s soll") || lower.starts_with("s noml") => {
            Some(Role::Command)
        }
        Format::Tncscope if lower.starts_with("s ist") || lower.starts_with("s actual") => {
            Some(Role::Motor)
        }
        Format::Tncscope if lower.starts_with("i ist") || lower.starts_with("i actual") => {
            Some(Role::Current)
        }
        Format::SinumerikTrace | Format::Tncscope => return None,
        _ if lower.ends_with("motor-pos-cmd") => Some(Role::Command),
        _ if lower.ends_with("motor-pos-fb") => Some(Role::Motor),
        _ => None,
    };
    let stem = stem(name);
    let last = stem.rsplit(['.', '/', ':']).next().unwrap_or_default();
    named.or(match last {
        "command" | "cmd" | "reference" | "setpoint" | "setpos" | "cmd_pos" => Some(Role::Command),
        "motor" | "actpos" | "motor_position" => Some(Role::Motor),
        "load" | "scale" | "load_position" => Some(Role::Load),
        "current" | "iq" | "actcurrent" => Some(Role::Current),
        "torque" | "acttorque" => Some(Role::Torque),
        "force" => Some(Role::Force),
        _ => None,
    })
}

/// What is wrong with a choice, and what to do.
type Refusal = (String, &'static str);

/// The column of times: the one that the caller names, or the one whose name tells it; none where
/// rows have a period instead.
pub(crate) fn time_among(
    names: &[String],
    options: &ReadOptions,
) -> Result<Option<usize>, Refusal> {
    if let Some(wanted) = &options.time_column {
        let found = names.iter().position(|name| name == wanted);
        let found = found.or_else(|| numbered(wanted, names.len()));
        return found.map(Some).ok_or_else(|| {
            let listed = shortened(&names.join(", "), LONGEST_SHOWN);
            let what = format!("there is no column `{wanted}`; the columns are: {listed}");
            (what, "")
        });
    }
    if options.period_s.is_some() {
        return Ok(None);
    }
    let is_time = |name: &&String| TIME_NAMES.contains(&stem(name).as_str());
    let mut found = names.iter().filter(is_time);
    let (one, two) = (found.next(), found.next());
    if let (Some(one), Some(two)) = (one, two) {
        let what = if one == two {
            format!("there are two columns `{one}`")
        } else {
            format!("both `{one}` and `{two}` could be the time")
        };
        return Err((what, "name one with --column time=NAME"));
    }
    Ok(names.iter().position(|name| is_time(&name)))
}

/// The time between two rows of a log without a column of times.
pub(crate) fn period_s(names: &[String], options: &ReadOptions) -> Result<f64, Refusal> {
    options.period_s.ok_or_else(|| {
        let listed = shortened(&names.join(", "), LONGEST_SHOWN);
        let what = format!("there is no column of times such as `t_s`; the columns are: {listed}");
        (
            what,
            "name it with --column time=NAME,unit=ms, or give the time between rows with --period-ms",
        )
    })
}

/// The unit of a column of times, as the caller, the log (`told`) or the name tells it; where nobody does,
/// what is taken for granted, too.
pub(crate) fn time_unit(
    name: &str,
    told: Option<Unit>,
    options: &ReadOptions,
) -> Result<(Unit, Option<String>), Refusal> {
    let told = options.time_unit.or(told);
    let Some(unit) = told.or_else(|| Unit::in_name(name)) else {
        let guess = format!("`{name}` is taken for seconds: its unit is not told");
        return Ok((Unit::S, Some(guess)));
    };
    if unit.quantity != Quantity::Time {
        let what = format!("the unit of the time `{name}` is {unit}");
        return Err((what, "a time is in s, ms, us or ns"));
    }
    Ok((unit, None))
}

/// A column called by its number, from 1.
fn numbered(name: &str, columns: usize) -> Option<usize> {
    let number: usize = name.parse().ok()?;
    (1..=columns).contains(&number).then(|| number - 1)
}

/// A channel in its role.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Assigned {
    pub(crate) role: Role,
    pub(crate) channel: usize,
    pub(crate) unit: Option<Unit>,
    pub(crate) factor: f64,
}

/// The channel of a column's number.
fn channel_at(header: &Header, number: usize) -> Result<usize, Refusal> {
    let all = header.channels.len();
    let Some(columns) = &header.columns else {
        let found = number.checked_sub(1).filter(|channel| *channel < all);
        return found.ok_or_else(|| {
            let what = format!("there is no channel {number}: the log has {all}, from 1");
            (
                what,
                "channels are counted here, since the log has no columns",
            )
        });
    };
    let of_channels = columns.of_channels.iter();
    if let Some(channel) = of_channels.clone().position(|column| *column == number) {
        return Ok(channel);
    }
    let count = columns.count;
    if !(1..=count).contains(&number) {
        let what = format!("there is no column {number}: the log has {count}, from 1");
        return Err((
            what,
            "every column of the file counts, that of the time, too",
        ));
    }
    let are: Vec<String> = of_channels.map(ToString::to_string).collect();
    let what = format!(
        "column {number} is the time, or holds no numbers; columns of values are {}",
        shortened(&are.join(", "), LONGEST_SHOWN)
    );
    Err((
        what,
        "every column of the file counts, that of the time, too",
    ))
}

/// The roles that are told.
pub(crate) fn assign_told(
    file: &str,
    header: &Header,
    told: &[ColumnSpec],
) -> Result<Vec<Assigned>, LogError> {
    let mut assigned: Vec<Assigned> = Vec::new();
    let names: Vec<&str> = header
        .channels
        .iter()
        .map(|channel| channel.name.as_str())
        .collect();
    let listed = || shortened(&names.join(", "), LONGEST_SHOWN);
    for spec in told.iter().filter(|spec| spec.role != Role::Time) {
        let places: Vec<usize> = (0..names.len())
            .filter(|&place| names.get(place) == Some(&spec.name.as_str()))
            .collect();
        let number = spec.name.parse::<usize>().ok();
        let channel = match (places.as_slice(), number) {
            ([one], _) => *one,
            ([], Some(number)) => {
                let found = channel_at(header, number);
                found.map_err(|(what, hint)| LogError::file(file, what, hint))?
            }
            ([], None) => {
                let what = format!(
                    "there is no column `{}`; the columns are: {}",
                    spec.name,
                    listed()
                );
                return Err(LogError::file(file, what, ""));
            }
            _ => {
                let what = format!("{} columns are called `{}`", places.len(), spec.name);
                return Err(LogError::file(file, what, "call it by its number"));
            }
        };
        if let Some(other) = assigned
            .iter()
            .find(|other| other.role == spec.role || other.channel == channel)
        {
            let what = format!(
                "column `{}` is told twice, as {} and {}",
                spec.name, other.role, spec.role
            );
            return Err(LogError::file(file, what, "one column for each role"));
        }
        assigned.push(Assigned {
            role: spec.role,
            channel,
            unit: spec.unit.or_else(|| {
                header
                    .channels
                    .get(channel)
                    .and_then(|channel| channel.unit)
            }),
            factor: spec.factor,
        });
    }
    Ok(assigned)
}

/// The roles that are told, then those that names tell.
pub(crate) fn assign(
    file: &str,
    header: &Header,
    told: &[ColumnSpec],
) -> Result<(Vec<Assigned>, Vec<String>), LogError> {
    let mut assigned = assign_told(file, header, told)?;
    let foreign = commands_of_another_encoder(header, &assigned);
    let name = |place: usize| {
        header
            .channels
            .get(place)
            .map_or("", |channel| channel.name.as_str())
    };
    let mut said = Vec::new();
    for &(role, _) in ROLES {
        if !lacks(&assigned, role) {
            continue;
        }
        let mut found = header
            .channels
            .iter()
            .enumerate()
            .filter(|(place, channel)| {
                role_of(header.format, &channel.name) == Some(role)
                    && !assigned.iter().any(|other| other.channel == *place)
                    && !foreign.contains(place)
            });
        let (one, two) = (found.next(), found.next());
        match (one, two) {
            (Some((_, one)), Some((_, two)))
                if matches!(role, Role::Motor | Role::Load | Role::Current) =>
            {
                let what = if one.name == two.name {
                    format!("there are two columns `{}`", one.name)
                } else {
                    format!("both `{}` and `{}` could be the {role}", one.name, two.name)
                };
                let hint = format!("name one with --column {role}=NAME");
                return Err(LogError::file(file, what, hint));
            }
            (Some((channel, one)), None) => {
                if stem(&one.name) != role.to_string() {
                    said.push(format!("`{}` is taken for the {role}", one.name));
                }
                assigned.push(Assigned {
                    role,
                    channel,
                    unit: one.unit,
                    factor: 1.0,
                });
            }
            _ => {}
        }
    }
    if let Some(place) = foreign.first().filter(|_| lacks(&assigned, Role::Command)) {
        said.push(format!(
            "`{}` is left out: the position loop is closed over another encoder than the motor's, so that lag and gains are not told",
            name(*place)
        ));
    }
    Ok((assigned, said))
}

fn lacks(assigned: &[Assigned], role: Role) -> bool {
    assigned.iter().all(|other| other.role != role)
}

/// The encoder that a name of a Sinumerik tells: the motor's is the first, that of a scale the second.
fn encoder_of(format: Format, name: &str) -> Option<u8> {
    let lower = name.to_lowercase();
    [("1stenc", 1), ("2ndenc", 2)]
        .into_iter()
        .find(|(part, _)| format == Format::SinumerikTrace && lower.contains(part))
        .map(|(_, encoder)| encoder)
}

/// Commands of another encoder than the motor's position: what is lost between the two would pass for lag.
fn commands_of_another_encoder(header: &Header, told: &[Assigned]) -> Vec<usize> {
    let format = header.format;
    let named = || {
        header
            .channels
            .iter()
            .find(|channel| role_of(format, &channel.name) == Some(Role::Motor))
    };
    let motor = match told.iter().find(|other| other.role == Role::Motor) {
        Some(told) => header.channels.get(told.channel),
        None => named(),
    };
    let Some(encoder) = motor.and_then(|motor| encoder_of(format, &motor.name)) else {
        return Vec::new();
    };
    let is_foreign = |name: &str| {
        role_of(format, name) == Some(Role::Command)
            && encoder_of(format, name).is_some_and(|of| of != encoder)
    };
    (0..header.channels.len())
        .filter(|place| {
            header
                .channels
                .get(*place)
                .is_some_and(|channel| is_foreign(&channel.name))
        })
        .collect()
}

impl Assigned {
    /// What the channel's values are multiplied with to be in a unit of `quantity`'s.
    pub(crate) fn factor_to(
        &self,
        file: &str,
        name: &str,
        quantities: &[Quantity],
        what: &str,
    ) -> Result<Unit, LogError> {
        let role = self.role;
        let Some(unit) = self.unit else {
            let text = format!("the unit of `{name}`, the {role}, is not told");
            let hint = format!("give it: --column {role}={name},unit=UNIT");
            return Err(LogError::file(file, text, hint));
        };
        // headers are often in lower case
        if unit == Unit::NM_LENGTH && quantities.contains(&Quantity::Torque) {
            return Ok(Unit::NM_TORQUE);
        }
        if !quantities.contains(&unit.quantity) {
            let text = format!("`{name}`, the {role}, is in {unit}");
            let hint = format!(
                "it has to be {what}; where it stands for one, say what 1 of it is: \
                 --column {role}={name},unit=UNIT,scale=FACTOR"
            );
            return Err(LogError::file(file, text, hint));
        }
        Ok(unit)
    }
}
