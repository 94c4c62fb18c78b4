//! What an operator does while a program runs.

use crate::failure::Failure;
use clap::Args;
use lostmotion::plan::Action;
use lostmotion::sim::Intervention;

/// Feed hold and the like.
#[derive(Debug, Default, Args)]
pub(crate) struct Interventions {
    /// What the operator does at a time since the start: hold, resume, stop, override:PERCENT (of
    /// the feed, 0 to 200) or rapid:PERCENT (of rapid moves, 0 to 100); such as 3.2s=hold; may be
    /// repeated
    #[arg(long, value_name = "TIME=ACTION")]
    pub(crate) at: Vec<String>,
}

impl Interventions {
    /// In the order of their times.
    ///
    /// # Errors
    /// A word that says nothing.
    pub(crate) fn read(&self) -> Result<Vec<Intervention>, Failure> {
        let mut all = self
            .at
            .iter()
            .map(|word| intervention(word))
            .collect::<Result<Vec<_>, _>>()?;
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
                "--at {word} is not a time in s or ms and hold, resume, stop, override:PERCENT (0 to 200) or rapid:PERCENT (0 to 100)"
            ),
            hint,
        )
    };
    let (time, action) = word.split_once('=').ok_or_else(wrong)?;
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
            let part = 0.01 * percent.trim().parse::<f64>().map_err(|_| wrong())?;
            match what {
                "override" => Action::Override(part),
                "rapid" => Action::Rapid(part),
                _ => return Err(wrong()),
            }
        }
    };
    let good = at_s.is_finite() && at_s >= 0.0 && action.check().is_ok();
    if good {
        Ok(Intervention { at_s, action })
    } else {
        Err(wrong())
    }
}
