//! What a command says: its answer on stdout, remarks and progress on stderr, and why it ends
//! without an answer.

use indicatif::{ProgressBar, ProgressStyle};
use lostmotion::base::text::legible;
use lostmotion::logs::LogError;
use lostmotion::report::atomic::{AtomicFile, OutputFolder};
use lostmotion::report::{ReadError, WriteError};
use std::io::{self, ErrorKind, IsTerminal, Write};
use std::path::Path;
use std::process::ExitCode;
use std::time::{Duration, Instant};

/// Exit code: done, and within tolerance where there is one.
pub(crate) const DONE: u8 = 0;
/// Exit code: the part comes out outside its tolerance, the machine stops, or there are warnings.
pub(crate) const FOUND: u8 = 1;
/// Exit code: something is wrong with what was given.
pub(crate) const BAD_INPUT: u8 = 2;

/// A command that could not do its work; ends with exit code 2.
#[derive(Debug)]
pub(crate) enum Failure {
    /// A message, with what to do about it.
    Message {
        /// What is wrong, with place and values.
        text: String,
        /// What to do; may be empty.
        hint: String,
    },
    /// Messages that carry their own prefixes.
    Rendered(String),
}

impl Failure {
    /// A message without a hint.
    pub(crate) fn message(text: impl Into<String>) -> Failure {
        Failure::with_hint(text, "")
    }

    /// A message with a hint.
    pub(crate) fn with_hint(text: impl Into<String>, hint: impl Into<String>) -> Failure {
        Failure::Message {
            text: text.into(),
            hint: hint.into(),
        }
    }

    /// The whole message.
    pub(crate) fn text(&self) -> String {
        match self {
            Failure::Message { text, hint } => {
                let hint = if hint.is_empty() {
                    String::new()
                } else {
                    format!("\nhint: {}", legible(hint))
                };
                format!("error: {}{hint}", legible(text))
            }
            Failure::Rendered(text) => text.trim_end().to_owned(),
        }
    }

    /// Prints the failure on stderr and returns the exit code. A closed stderr is ignored.
    pub(crate) fn report(&self) -> ExitCode {
        let _ = writeln!(io::stderr().lock(), "{}", self.text());
        ExitCode::from(BAD_INPUT)
    }
}

impl From<WriteError> for Failure {
    fn from(error: WriteError) -> Failure {
        Failure::message(error.to_string())
    }
}

impl From<LogError> for Failure {
    fn from(error: LogError) -> Failure {
        Failure::message(error.to_string())
    }
}

impl From<ReadError> for Failure {
    fn from(error: ReadError) -> Failure {
        Failure::message(error.to_string())
    }
}

/// Buffer of stdout, bytes: large enough that millions of short lines go out in few calls. A
/// choice.
const BUFFER_BYTES: usize = 1 << 16;

/// stdout, buffered.
pub(crate) fn stdout() -> io::BufWriter<io::StdoutLock<'static>> {
    io::BufWriter::with_capacity(BUFFER_BYTES, io::stdout().lock())
}

/// Whether somebody looks at stdout.
pub(crate) fn stdout_is_terminal() -> bool {
    io::stdout().is_terminal()
}

/// Whether stdout is a terminal that wants colour (`NO_COLOR` unset, `TERM` not `dumb`).
pub(crate) fn stdout_has_color() -> bool {
    stdout_is_terminal() && wants_color()
}

/// The same for stderr.
pub(crate) fn stderr_has_color() -> bool {
    io::stderr().is_terminal() && wants_color()
}

fn wants_color() -> bool {
    // An empty `NO_COLOR` counts as unset (no-color.org).
    std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
        && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// Columns of a terminal that does not say how many it has.
const DEFAULT_COLUMNS: usize = 80;

/// How many columns tables on stdout may take: `COLUMNS`, or what the terminal says, or 80.
pub(crate) fn stdout_columns() -> usize {
    // `COLUMNS` beats the terminal: scripts and tests have no other way to choose the width.
    let told = std::env::var("COLUMNS")
        .ok()
        .and_then(|columns| columns.trim().parse().ok())
        .filter(|columns| *columns > 0);
    told.or_else(|| {
        let (_, columns) = console::Term::stdout().size_checked()?;
        Some(usize::from(columns))
    })
    .unwrap_or(DEFAULT_COLUMNS)
}

/// A text in lines that fit stdout, broken at blanks; ends in a newline.
pub(crate) fn wrapped(text: &str) -> String {
    lines(text, "")
}

/// The same with four blanks before each line.
pub(crate) fn indented(text: &str) -> String {
    lines(text, "    ")
}

fn lines(text: &str, before: &str) -> String {
    let columns = stdout_columns();
    let (mut out, mut used) = (String::new(), 0);
    for word in text.split_whitespace() {
        // Characters, not bytes: an umlaut takes one column.
        let length = word.chars().count();
        // A line takes words as long as they fit; a word longer than the line stands alone.
        if used > 0 && used + 1 + length <= columns {
            out.push(' ');
            used += 1 + length;
        } else {
            out.push_str(if used > 0 { "\n" } else { "" });
            out.push_str(before);
            used = before.len() + length;
        }
        out.push_str(word);
    }
    out.push_str(if used > 0 { "\n" } else { "" });
    out
}

/// Whether writing may go on: false when the reader has gone (`lostmotion ... | head`), which is
/// not a failure.
pub(crate) fn go_on(result: io::Result<()>) -> Result<bool, Failure> {
    match result {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
        Err(error) => Err(Failure::message(format!("cannot write to stdout: {error}"))),
    }
}

/// Prints a whole text.
pub(crate) fn print(text: &(impl AsRef<[u8]> + ?Sized)) -> Result<(), Failure> {
    let mut out = stdout();
    go_on(out.write_all(text.as_ref()).and_then(|()| out.flush())).map(|_| ())
}

/// Prints a remark on stderr; a closed stderr is ignored.
pub(crate) fn remark(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", text.trim_end());
}

/// Whether a path stands for stdin or stdout.
pub(crate) fn is_standard(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Starts a file that appears complete or not at all, which stdout cannot.
pub(crate) fn create(path: &Path) -> Result<AtomicFile, Failure> {
    refuse_standard(path, "a file")?;
    Ok(AtomicFile::create(path)?)
}

/// Refuses to write over what is read: it would be lost.
pub(crate) fn refuse_input(out: &Path, input: &Path, what: &str) -> Result<(), Failure> {
    // On true paths: links and `..` may lead to one file.
    let (Ok(to), Ok(from)) = (out.canonicalize(), input.canonicalize()) else {
        return Ok(());
    };
    if to == from && to.is_file() {
        return Err(Failure::with_hint(
            format!("the output {} is the {what}", out.display()),
            "name another file: what is read would be lost",
        ));
    }
    Ok(())
}

/// Refuses to write over one of the files that a command reads beside its first.
pub(crate) fn refuse_inputs<'a>(
    out: &Path,
    inputs: impl IntoIterator<Item = (&'a Path, &'static str)>,
) -> Result<(), Failure> {
    inputs
        .into_iter()
        .try_for_each(|(input, what)| refuse_input(out, input, what))
}

/// Opens a folder for results, made if it does not exist.
pub(crate) fn create_folder(path: &Path) -> Result<OutputFolder, Failure> {
    refuse_standard(path, "a folder")?;
    Ok(OutputFolder::create(path)?)
}

/// Refuses `-` where stdout cannot be meant.
pub(crate) fn refuse_standard(path: &Path, allowed: &str) -> Result<(), Failure> {
    if is_standard(path) {
        let hint = "this command writes no result to stdout; `./-` is a file or folder named so";
        return Err(Failure::with_hint(
            format!("the output is `-`; it has to be {allowed}"),
            hint,
        ));
    }
    Ok(())
}

/// Writes a text to a file, which appears complete or not at all, or to stdout for `-`.
pub(crate) fn write_text(path: &Path, text: &(impl AsRef<[u8]> + ?Sized)) -> Result<(), Failure> {
    if is_standard(path) {
        return print(text);
    }
    let mut file = AtomicFile::create(path)?;
    file.write_all(text.as_ref())
        .map_err(|error| WriteError::io("write", path, error))?;
    file.commit()?;
    Ok(())
}

/// Work that is done sooner shows no bar: it would only flicker. A choice.
const BAR_DELAY: Duration = Duration::from_millis(300);

/// Steps of the bar: finer than the columns of any terminal. A choice.
const BAR_STEPS: u64 = 1000;

/// A progress bar that appears only on a terminal, and only after a moment.
pub(crate) struct Progress {
    started: Instant,
    bar: Option<ProgressBar>,
    enabled: bool,
}

impl Progress {
    /// A bar that stays away if `quiet`.
    pub(crate) fn new(quiet: bool) -> Progress {
        Progress {
            started: Instant::now(),
            bar: None,
            enabled: !quiet && io::stderr().is_terminal(),
        }
    }

    /// Tells how much is done, and how much machine time has been simulated.
    pub(crate) fn update(&mut self, done: u64, total: u64, simulated_s: f64) {
        // Short runs would only flicker.
        if !self.enabled || self.started.elapsed() < BAR_DELAY {
            return;
        }
        let bar = self.bar.get_or_insert_with(new_bar);
        let part = if total == 0 {
            0.0
        } else {
            done as f64 / total as f64
        };
        let part = part.clamp(0.0, 1.0);
        bar.set_position((part * BAR_STEPS as f64) as u64);
        bar.set_message(progress_text(
            self.started.elapsed().as_secs_f64(),
            part,
            simulated_s,
        ));
    }

    /// Takes the bar away.
    pub(crate) fn finish(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.finish();
    }
}

/// How far a run is after a time, s: machine time, rate, and the time left if it goes on as it did
/// from its start. A whole second is left until it is done.
fn progress_text(elapsed_s: f64, part: f64, simulated_s: f64) -> String {
    let rate = simulated_s / elapsed_s.max(1e-9);
    let left = if part > 0.0 {
        let left_s = (elapsed_s * (1.0 - part) / part).ceil();
        match left_s {
            left_s if left_s < 120.0 => format!("{left_s:.0} s left"),
            left_s => format!("{} left", lostmotion::report::number::duration(left_s)),
        }
    } else {
        "time left not known yet".to_owned()
    };
    format!("{simulated_s:.0} s of motion, {rate:.0} x real time, {left}")
}

fn new_bar() -> ProgressBar {
    let bar = ProgressBar::new(BAR_STEPS);
    if let Ok(style) = ProgressStyle::with_template("{bar:24} {percent:>3} %  {msg}") {
        bar.set_style(style);
    }
    bar
}

#[cfg(test)]
mod tests {
    use super::progress_text;

    #[test]
    fn the_time_left_is_that_of_the_rest_at_the_rate_so_far() {
        // 4 % in 2 s: 48 s for the rest.
        let text = progress_text(2.0, 0.04, 500.0);
        assert_eq!(text, "500 s of motion, 250 x real time, 48 s left");
        assert!(progress_text(2.0, 0.0, 0.0).ends_with("not known yet"));
        assert!(progress_text(10.0, 0.999, 99.0).ends_with(", 1 s left"));
        assert!(progress_text(60.0, 0.1, 1.0).ends_with(", 9 min 0 s left"));
    }
}
