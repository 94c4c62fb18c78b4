//! `lostmotion watch`: a run that is made again whenever one of its files changes, with its page on a
//! port of this computer.

use super::serve::Server;
use super::simulate::{self, Simulate};
use crate::options::whole;
use crate::output::{Failure, is_standard, remark};
use clap::Args;
use lostmotion::report::page::message_page;
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::path::{Path, PathBuf};
use std::time::{Duration, SystemTime};

/// How often files are looked at. A choice: sooner than anyone turns from the editor to the page.
const LOOK_EVERY: Duration = Duration::from_millis(250);
/// Most files of a folder that are looked at.
const MOST_FILES: usize = 1000;

/// `watch`.
#[derive(Debug, Args)]
pub(crate) struct Watch {
    #[command(flatten)]
    simulate: Simulate,
    /// Port of 127.0.0.1 that the page is on; a free one, if left out
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole::<u16>)]
    port: u16,
}

/// Size and time of every file that a run reads.
type Seen = BTreeMap<PathBuf, Option<(u64, Option<SystemTime>)>>;

/// Runs, serves the page, and runs again, until it is ended.
pub(crate) fn run(args: &mut Watch, quiet: bool) -> Result<Infallible, Failure> {
    let part = args.simulate.run.on.part.clone();
    if is_standard(&part) {
        let hint = "give the name of a file, which can change";
        return Err(Failure::with_hint("stdin cannot be watched", hint));
    }
    // A part that is not there now is a misspelt name, not one that will come.
    crate::input::open(&part, "part program")?;
    let server = Server::start(args.port)?;
    remark(&format!(
        "watching {}; the page is at {} (Ctrl-C ends)",
        part.display(),
        server.address()
    ));
    loop {
        // Looked at before the run: what changes meanwhile makes the next one.
        let seen = look(args);
        match simulate::page_of(&mut args.simulate, quiet) {
            Ok(page) => server.show(&page),
            Err(failure) => {
                let _ = failure.report();
                let title = format!("{}: no result", part.display());
                server.show(&message_page(&title, &failure.text()));
            }
        }
        await_change(args, &seen);
    }
}

/// Waits until a file differs from what was seen, and then until nothing changes any more: editors
/// write in several steps.
fn await_change(args: &Watch, seen: &Seen) {
    let mut now = look(args);
    while now == *seen {
        std::thread::sleep(LOOK_EVERY);
        now = look(args);
    }
    loop {
        std::thread::sleep(LOOK_EVERY);
        let next = look(args);
        if next == now {
            return;
        }
        now = next;
    }
}

/// The files of a run: part, machine, tools, what was learned, fits, and files of subroutines.
fn look(args: &Watch) -> Seen {
    let run = &args.simulate.run;
    let mut files: Vec<PathBuf> = vec![run.on.part.clone()];
    files.extend(run.on.setup.on.inputs().map(|(path, _)| path.to_owned()));
    files.extend(run.learning.learned.clone());
    let fits = run.fitted.iter().filter_map(|fit| fit.split_once('='));
    files.extend(fits.map(|(_, file)| PathBuf::from(file)));
    let own = run.on.part.parent().map(Path::to_path_buf);
    let extension = run.on.part.extension();
    // Beside the part only programs like it: results may be written there.
    files.extend(
        own.iter()
            .flat_map(|folder| within(folder))
            .filter(|file| file.extension() == extension),
    );
    let folders = &run.on.setup.reading.subroutines;
    files.extend(folders.iter().flat_map(|folder| within(folder)));
    let state = |path: &Path| {
        let found = std::fs::metadata(path).ok()?;
        Some((found.len(), found.modified().ok()))
    };
    files
        .into_iter()
        .map(|path| {
            let state = state(&path);
            (path, state)
        })
        .collect()
}

/// The files of a folder, at most [`MOST_FILES`].
fn within(folder: &Path) -> Vec<PathBuf> {
    // The folder of `part.ngc` is written as nothing.
    let folder = if folder.as_os_str().is_empty() {
        Path::new(".")
    } else {
        folder
    };
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    let paths = entries
        .map(|entry| entry.path())
        .filter(|path| path.is_file());
    paths.take(MOST_FILES).collect()
}
