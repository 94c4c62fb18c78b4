//! `lostmotion study`.

mod bench;
mod cell;
mod endurance;
mod journal;
mod matrix;

use crate::args::study::Study;
use crate::failure::Failure;
use crate::voice::Voice;
use lostmotion::methods::{MethodId, UnknownMethod};
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

/// The methods asked for, each known and once, without the baseline. If none is named: all but those
/// that need a fit, which a study does not have.
fn methods(asked: &[String]) -> Result<Vec<String>, Failure> {
    let mut methods: Vec<String> = Vec::new();
    let mut named = false;
    for name in asked
        .iter()
        .map(|name| name.trim())
        .filter(|name| !name.is_empty())
    {
        let method: MethodId = name
            .parse()
            .map_err(|error: UnknownMethod| Failure::message(error.to_string()))?;
        if methods.iter().any(|known| known == name) {
            return Err(Failure::message(format!(
                "--methods names \"{name}\" twice"
            )));
        }
        named = true;
        if !method.is_baseline() {
            methods.push(name.to_owned());
        }
    }
    if !named {
        methods = MethodId::all()
            .filter(|method| !method.is_baseline() && !method.needs_fit())
            .map(|method| method.to_string())
            .collect();
    }
    Ok(methods)
}
