//! `lostmotion study`.

mod bench;
mod cell;
mod endurance;
mod journal;
mod matrix;

use crate::args::study::Study;
use crate::failure::Failure;
use crate::voice::Voice;
use lostmotion::methods::{METHODS, find_method};
use lostmotion_study::StudyError;

/// Runs the study asked for.
pub(crate) fn run(study: &Study, voice: Voice) -> Result<u8, Failure> {
    match study {
        Study::Matrix(args) => matrix::run(args, voice.quiet),
        Study::Cell(args) => cell::run(args),
        Study::Bench(args) => bench::run(args),
        Study::Endurance(args) => endurance::run(args),
    }
}

fn failure(error: &StudyError) -> Failure {
    Failure::message(error.to_string())
}

/// Needs a gap fitted beforehand, which nobody has in a study.
const FITTED: &str = "fitted-lookup";

/// The methods asked for, each known and once, without `none`; all but `fitted-lookup` if none is
/// named.
fn methods(asked: &[String]) -> Result<Vec<String>, Failure> {
    let mut methods: Vec<String> = Vec::new();
    let mut named = false;
    for name in asked
        .iter()
        .map(|name| name.trim())
        .filter(|name| !name.is_empty())
    {
        find_method(name).map_err(|error| Failure::message(error.to_string()))?;
        if methods.iter().any(|known| known == name) {
            return Err(Failure::message(format!(
                "--methods names \"{name}\" twice"
            )));
        }
        named = true;
        if name != "none" {
            methods.push(name.to_owned());
        }
    }
    if !named {
        methods = METHODS
            .iter()
            .map(|method| method.info.name.to_owned())
            .filter(|name| !["none", FITTED].contains(&name.as_str()))
            .collect();
    }
    Ok(methods)
}
