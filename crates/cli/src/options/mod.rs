//! Options that commands share, and what they mean.

pub(crate) mod machine;
pub(crate) mod part;
pub(crate) mod start;

use crate::output::{self, Failure};
use clap::builder::{PossibleValue, TypedValueParser};
use clap::error::ErrorKind;
use clap::{Arg, Args, Command, ValueEnum};
use lostmotion::base::names::did_you_mean;
use lostmotion::identify::LATENESS_S;
use lostmotion::methods::MethodId;
use lostmotion::plan::Action;
use lostmotion::sim::Intervention;
use lostmotion::sim::options::MAX_THREADS;
use std::ffi::OsStr;
use std::str::FromStr;

/// Form of the answer on stdout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Format {
    /// Tables for people
    #[default]
    Text,
    /// Versioned JSON for programs
    Json,
}

/// Form of the answer of a run on stdout.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum RunFormat {
    /// Tables for people
    #[default]
    Text,
    /// Versioned JSON for programs
    Json,
    /// Blocks outside the tolerance, and what is found in the program, as SARIF 2.1.0 for editors
    /// and code hosts
    Sarif,
}

/// The answer in the form asked for.
pub(crate) fn show(format: Format, json: &str, text: &str) -> Result<(), Failure> {
    output::print(match format {
        Format::Text => text,
        Format::Json => json,
    })
}

/// Form of a list of what there is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Listing {
    /// For a terminal
    #[default]
    Text,
    /// For a book
    Markdown,
}

/// How much effort the planner puts into the cycle time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum Quality {
    /// As fast as programs are read
    #[default]
    Fast,
    /// Nearly the shortest time that the limits allow
    Optimal,
}

impl Quality {
    /// The planner's own value.
    pub(crate) fn of_planner(self) -> lostmotion::plan::Quality {
        match self {
            Quality::Fast => lostmotion::plan::Quality::Fast,
            Quality::Optimal => lostmotion::plan::Quality::Optimal,
        }
    }
}

/// A value that has to be one of a list of names: they are listed in help and completions, and an
/// unknown one is answered with the nearest.
#[derive(Clone, Debug)]
pub(crate) struct Names {
    /// What is named, singular.
    what: &'static str,
    /// Names with a line about each.
    known: Vec<(&'static str, &'static str)>,
}

impl Names {
    /// Names of a kind of thing.
    pub(crate) fn new(
        what: &'static str,
        known: impl IntoIterator<Item = (&'static str, &'static str)>,
    ) -> Names {
        Names {
            what,
            known: known.into_iter().collect(),
        }
    }

    /// Why a name is refused.
    pub(crate) fn refusal(&self, name: &str) -> Failure {
        let known: Vec<&str> = self.known.iter().map(|(name, _)| *name).collect();
        let all = format!("known {}s: {}", self.what, known.join(", "));
        // All names besides the nearest one: the guess may be wrong.
        let nearest = did_you_mean(name, &known);
        let hint = if nearest.starts_with("did") {
            format!("{nearest} {all}")
        } else {
            all
        };
        Failure::with_hint(format!("there is no {} \"{name}\"", self.what), hint)
    }
}

impl TypedValueParser for Names {
    type Value = String;

    fn parse_ref(
        &self,
        _command: &Command,
        argument: Option<&Arg>,
        value: &OsStr,
    ) -> Result<String, clap::Error> {
        let name = value.to_string_lossy();
        let name = name.trim();
        if self.known.iter().any(|(known, _)| *known == name) {
            return Ok(name.to_owned());
        }
        let Failure::Message { text, hint } = self.refusal(name) else {
            return Ok(name.to_owned());
        };
        let option = argument
            .map(|argument| format!("{argument}: "))
            .unwrap_or_default();
        // clap puts `error:` before the text and ends with exit code 2, as for other bad input.
        let message = format!("{option}{text}\nhint: {hint}\n");
        Err(clap::Error::raw(ErrorKind::InvalidValue, message))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let value = |(name, about): &(&'static str, &'static str)| {
            let value = PossibleValue::new(*name);
            if about.is_empty() {
                value
            } else {
                value.help(*about)
            }
        };
        Some(Box::new(self.known.iter().map(value)))
    }
}

/// Names of compensation methods.
pub(crate) fn methods() -> Names {
    let named = MethodId::all().map(|method| (method.name(), method.info().summary));
    Names::new("method", named)
}

/// Number of threads asked for, 0 for all cores; refuses `--threads 0`.
pub(crate) fn threads(asked: Option<usize>) -> Result<usize, Failure> {
    match asked {
        Some(asked) if !(1..=MAX_THREADS).contains(&asked) => Err(Failure::with_hint(
            format!("--threads is {asked}; it has to be 1 to {MAX_THREADS}"),
            "leave it out to use all cores",
        )),
        asked => Ok(asked.unwrap_or(0)),
    }
}

/// A number of an option. clap puts the option and the text before the refusal.
pub(crate) fn number(text: &str) -> Result<f64, &'static str> {
    text.trim().parse().map_err(|_| "it is not a number")
}

/// A whole number of an option, not below 0.
pub(crate) fn whole<T: FromStr>(text: &str) -> Result<T, &'static str> {
    // 2.5 and -1 are numbers, if not whole ones from 0 on: another message than for `abc`.
    let is_number = text.trim().parse::<f64>().is_ok();
    text.trim().parse().map_err(|_| match is_number {
        true => "it is not a whole number from 0 upwards that fits",
        false => "it is not a number",
    })
}

/// How late the load of a log may be.
#[derive(Debug, Args)]
pub(crate) struct Lateness {
    /// How much later or earlier than the motor's the position of the load may be read where the log does
    /// not tell it, ms: intervals hold it; 0 where one drive reads both at the same time
    #[arg(
        long = "lateness",
        value_name = "MS",
        allow_negative_numbers = true,
        value_parser = milliseconds,
        default_value_t = 1e3 * LATENESS_S
    )]
    ms: f64,
}

impl Lateness {
    /// The same in s.
    pub(crate) fn seconds(&self) -> f64 {
        1e-3 * self.ms
    }
}

/// A time from 0 on.
fn milliseconds(text: &str) -> Result<f64, &'static str> {
    let ms = number(text)?;
    let told =
        "it is no time from 0 on: 0 says that one drive reads motor and load at the same time";
    (ms.is_finite() && ms >= 0.0).then_some(ms).ok_or(told)
}

/// What an operator does while a program runs.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Operator")]
pub(crate) struct Interventions {
    /// What the operator does at a time since the start: hold, resume, stop, override:PERCENT (of
    /// the feed: 0, or 0.1 to 200) or rapid:PERCENT (of rapid moves: 0, or 0.1 to 100); for example
    /// 3.2s=hold; may be repeated
    #[arg(long, value_name = "TIME=ACTION", allow_hyphen_values = true)]
    pub(crate) at: Vec<String>,
}
impl Interventions {
    /// In the order of their times.
    ///
    /// # Errors
    /// An action that is not understood.
    pub(crate) fn read(&self) -> Result<Vec<Intervention>, Failure> {
        let mut all = self
            .at
            .iter()
            .map(|word| intervention(word))
            .collect::<Result<Vec<_>, _>>()?;
        // The pacer takes actions in the order of their times, users give them in any.
        all.sort_by(|a, b| a.at_s.total_cmp(&b.at_s));
        Ok(all)
    }
}

fn intervention(word: &str) -> Result<Intervention, Failure> {
    let wrong = || {
        let hint =
            "for example: --at 3.2s=hold --at 4500ms=resume --at 7s=override:50 --at 9s=stop";
        Failure::with_hint(
            format!(
                "--at {word} is not a time in s or ms and hold, resume, stop, override:PERCENT (0, or 0.1 to 200) or rapid:PERCENT (0, or 0.1 to 100)"
            ),
            hint,
        )
    };
    let (time, action) = word.split_once('=').ok_or_else(wrong)?;
    // `ms` before `s`, which it ends in.
    let (number, unit_s) = match time.strip_suffix("ms") {
        Some(number) => (number, 1e-3),
        None => (time.strip_suffix('s').unwrap_or(time), 1.0),
    };
    let at_s = number.trim().parse::<f64>().map_err(|_| wrong())? * unit_s;
    let action = match action.trim() {
        "hold" => Action::Hold,
        "resume" => Action::Resume,
        "stop" => Action::Stop,
        other => {
            let (what, percent) = other.split_once(':').ok_or_else(wrong)?;
            // Per cent of the feed or of the rapid, which the planner takes as a factor.
            let part = 0.01 * percent.trim().parse::<f64>().map_err(|_| wrong())?;
            match what {
                "override" => Action::Override(part),
                "rapid" => Action::Rapid(part),
                _ => return Err(wrong()),
            }
        }
    };
    // Ranges are the planner's own: it checks its actions.
    let good = at_s.is_finite() && at_s >= 0.0 && action.check().is_ok();
    if good {
        Ok(Intervention { at_s, action })
    } else {
        Err(wrong())
    }
}
