//! `lostmotion report`: the answers of several runs side by side.

use super::shown;
use crate::input;
use crate::output::{DONE, Failure, create, print, refuse_inputs};
use clap::{Args, ValueHint};
use lostmotion::report::WriteError;
use lostmotion::report::page::runs_page;
use lostmotion::report::runs::{NamedRun, RunError, short_names};
use lostmotion::report::text;
use std::io::Write;
use std::path::PathBuf;

/// `report`.
#[derive(Debug, Args)]
pub(crate) struct Report {
    /// Answers of `simulate --format json`, or simulation.json and comparison.json of its folders
    #[arg(required = true, value_name = "RESULT.json", value_hint = ValueHint::FilePath)]
    results: Vec<PathBuf>,
    /// Also write them as a page for a browser, one file that needs no network
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    html: Option<PathBuf>,
}

/// Reads the answers and shows them side by side.
pub(crate) fn run(args: &Report) -> Result<u8, Failure> {
    if let Some(html) = &args.html {
        let inputs = args.results.iter().map(|path| (path.as_path(), "result"));
        refuse_inputs(html, inputs)?;
    }
    let paths: Vec<String> = args
        .results
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    let names = short_names(&paths.iter().map(String::as_str).collect::<Vec<_>>());
    let mut runs = Vec::with_capacity(paths.len());
    for ((path, given), name) in args.results.iter().zip(&paths).zip(names) {
        let text = input::text(path, "result")?;
        let read = NamedRun::read(given, &text).map_err(|error| refusal(&error))?;
        runs.push(NamedRun { name, ..read });
    }
    if let Some(path) = &args.html {
        let mut file = create(path)?;
        let page = runs_page(&runs);
        file.write_all(page.as_bytes())
            .map_err(|error| WriteError::io("write", path, error))?;
        file.commit()?;
    }
    print(&text::runs(&runs, &shown()))?;
    Ok(DONE)
}

fn refusal(error: &RunError) -> Failure {
    let hint = "give what `lostmotion simulate PART --format json` prints, or simulation.json or comparison.json of its --out folder";
    Failure::with_hint(error.to_string(), hint)
}
