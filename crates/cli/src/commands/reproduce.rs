//! `lostmotion reproduce`.

use super::DONE;
use crate::args::study::Reproduce;
use crate::failure::Failure;
use crate::output;
use lostmotion::report::WriteError;
use lostmotion::report::atomic::OutputFolder;
use lostmotion_study::StudyError;
use lostmotion_study::paper::{Trial, figures, outlook, scan, shaft_trials, text, trials};
use std::io::Write;

/// Runs the paper's experiments again.
pub(crate) fn run(what: &Reproduce) -> Result<u8, Failure> {
    let Reproduce::Paper(args) = what;
    let failed = |error: StudyError| Failure::message(error.to_string());
    // a folder that cannot be is told before the work is done
    let folder = args.out.as_ref().map(OutputFolder::create).transpose()?;
    let trials = trials(&Trial::CHOSEN, &scan::FORMS).map_err(failed)?;
    let scanned = scan::scan().map_err(failed)?;
    let shafts = shaft_trials().map_err(failed)?;
    let markdown = text::markdown(&trials, &scanned, &shafts);
    if let Some(mut folder) = folder {
        let mut files = vec![
            ("paper.md".to_owned(), markdown.clone()),
            ("scan.csv".to_owned(), text::csv(&scanned)),
        ];
        files.extend(figures::figures(&trials));
        files.extend(figures::scan_figures(&scanned));
        files.extend(outlook::figures(&shafts));
        for (name, content) in files {
            let mut file = folder.file(&name)?;
            file.write_all(content.as_bytes())
                .map_err(|error| WriteError::io("write into", folder.path(), error))?;
            folder.add(file);
        }
        folder.commit()?;
    }
    output::print(&markdown)?;
    Ok(DONE)
}
