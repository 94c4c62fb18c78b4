//! Text on stdout and stderr.

use crate::failure::Failure;
use std::io::{self, ErrorKind, IsTerminal, Write};

/// Large enough that millions of short lines go out in few calls.
const BUFFER_BYTES: usize = 1 << 16;

/// stdout, buffered.
pub(crate) fn stdout() -> io::BufWriter<io::StdoutLock<'static>> {
    io::BufWriter::with_capacity(BUFFER_BYTES, io::stdout().lock())
}

/// Whether stdout is a terminal that wants colour (`NO_COLOR` unset, `TERM` not `dumb`).
pub(crate) fn stdout_has_color() -> bool {
    io::stdout().is_terminal() && wants_color()
}

/// The same for stderr.
pub(crate) fn stderr_has_color() -> bool {
    io::stderr().is_terminal() && wants_color()
}

fn wants_color() -> bool {
    std::env::var_os("NO_COLOR").is_none_or(|value| value.is_empty())
        && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// Whether writing may go on: false when the reader has gone (`lostmotion ... | head`), which is no
/// failure.
pub(crate) fn go_on(result: io::Result<()>) -> Result<bool, Failure> {
    match result {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(false),
        Err(error) => Err(Failure::message(format!("cannot write to stdout: {error}"))),
    }
}

/// Prints a whole text.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut out = stdout();
    go_on(out.write_all(text.as_bytes()).and_then(|()| out.flush())).map(|_| ())
}

/// Prints a remark on stderr; a closed stderr is nobody's loss.
pub(crate) fn remark(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", text.trim_end());
}
