//! `lostmotion machine check --measure`: what to measure first.

use crate::findings::{Form, Voice};
use crate::input;
use crate::options::machine::description;
use crate::output::{Failure, stdout_columns, wrapped};
use crate::parts::failure;
use lostmotion::Program;
use lostmotion::report::number::{error, percent};
use lostmotion::report::text::{Align, Table};
use lostmotion::sim::machine::presets;
use lostmotion::sim::measure::{MeasureOptions, Measurements, guesses, measurements};
use lostmotion::sim::{Machine, SimulateOptions};
use std::path::Path;

/// Runs the part, or a circle, with every value up and down.
pub(super) fn first(
    name: &str,
    machine: &Machine,
    part: Option<&Path>,
    max_motion_s: f64,
) -> Result<Measurements, Failure> {
    let (_, text) = description(name)?;
    // A machine that comes with the program is nobody's own: all of it is typical of a class.
    let is_preset = presets().iter().any(|preset| preset.toml == text);
    let guessed = if is_preset {
        guesses(&format!("# preset\n{text}"))
    } else {
        guesses(&text)
    };
    let program = part.map(input::program).transpose()?;
    let wanted = MeasureOptions {
        max_motion_s,
        ..MeasureOptions::default()
    };
    let options = SimulateOptions {
        threads: 0,
        ..SimulateOptions::default()
    };
    let found = measurements(machine, program.as_ref(), &guessed, &options, &wanted);
    found.map_err(|found| {
        let none = Program::from_str("a circle", "");
        let voice = Voice {
            quiet: true,
            diagnostics: Form::Text,
        };
        failure(program.as_ref().unwrap_or(&none), &found, voice)
    })
}

/// The list for people.
pub(super) fn shown(found: &Measurements) -> String {
    let mut text = wrapped(&format!(
        "what to measure first, for {}: largest contour error {} um of a tolerance of {} um as described; {} values in {} runs, {:.0} s of motion",
        found.program,
        error(found.max_um),
        error(found.tolerance_um),
        found.tried,
        found.runs,
        found.motion_s
    ));
    if found.measure.is_empty() {
        text.push_str("none of them changes it\n");
        return text;
    }
    let right = Align::Right;
    let mut table = Table::new(&[
        ("", Align::Left),
        ("", Align::Left),
        ("may be", right),
        ("", Align::Left),
        ("change", right),
        ("share", right),
        ("verdict", Align::Left),
    ]);
    for it in &found.measure {
        let change = it.change_um.map_or_else(
            || "stops".to_owned(),
            |change| format!("{} um", error(change)),
        );
        let verdict = if found.turns_verdict(it) {
            "may turn"
        } else {
            "stays"
        };
        table.row([
            it.axis.to_string().into(),
            it.quantity.as_str().into(),
            format!("{:.2} to {:.2} times", it.down, it.up).into(),
            if it.guess { "guess" } else { "" }.into(),
            change.into(),
            percent(it.share).into(),
            verdict.into(),
        ]);
    }
    text.push_str(&table.render_within(stdout_columns()));
    // How, once for each quantity.
    let mut said: Vec<&str> = Vec::new();
    for it in &found.measure {
        if !said.contains(&it.quantity.as_str()) {
            said.push(&it.quantity);
            text.push_str(&wrapped(&format!("{}: {}", it.quantity, it.how)));
        }
    }
    text
}
