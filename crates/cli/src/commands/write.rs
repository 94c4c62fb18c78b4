//! `lostmotion write`.

use super::{DONE, interpreter};
use crate::args::front::WritePart;
use crate::diagnostics::Findings;
use crate::failure::Failure;
use crate::voice::Voice;
use crate::{input, output};
use lostmotion::gcode_tools::writer::{WriterError, Written, write_program};
use lostmotion::report::atomic::AtomicFile;
use std::io::ErrorKind;

/// Writes the resolved program to a file, which appears complete or not at all, or to stdout.
pub(crate) fn run(args: &WritePart, voice: Voice) -> Result<u8, Failure> {
    let source = input::program(&args.part)?;
    let (config, _) = interpreter::config(&args.setup)?;
    let loader = args.setup.reading.loader(&args.part)?;
    // Nothing is written of a program that is refused.
    let mut program =
        interpreter::open(&source, config.clone())?.with_loader(std::sync::Arc::clone(&loader));
    for _ in program.by_ref() {}
    let findings = Findings::of(&source, program.diagnostics());
    if findings.counts.errors > 0 {
        return Err(findings.failure(voice));
    }
    let mut program = interpreter::open(&source, config.clone())?.with_loader(loader);
    let result = match &args.out {
        Some(path) => {
            let mut file = AtomicFile::create(path)?;
            let result = write_program(&mut program, &config, args.system, &mut file);
            if result.is_ok() {
                file.commit()?;
            }
            result
        }
        None => write_program(&mut program, &config, args.system, &mut output::stdout()),
    };
    match result {
        Ok(Written { blocks, .. }) => {
            findings.remark(voice)?;
            if let Some(path) = args.out.as_ref().filter(|_| !voice.quiet) {
                output::print(&format!("{}: {blocks} blocks\n", path.display()))?;
            }
            Ok(DONE)
        }
        Err(WriterError::Io(error)) if error.kind() == ErrorKind::BrokenPipe => Ok(DONE),
        Err(error) => Err(Failure::message(format!("{}: {error}", source.name()))),
    }
}
