//! Prints the canonical operations of a part program: `canon [--tool-table FILE] PART`.

use lostmotion_gcode::{
    InterpreterConfig, LoadedFile, Program, SubroutineLoader, ToolTable, canon,
};
use std::error::Error;
use std::fs::File;
use std::io::{BufReader, BufWriter, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::sync::Arc;

/// Subroutines from the folder of the part.
#[derive(Debug)]
struct Folder(PathBuf);

impl SubroutineLoader for Folder {
    fn load(&self, name: &str) -> Result<Option<LoadedFile>, String> {
        if name.contains(['/', '\\', '.']) {
            return Ok(None);
        }
        let path = self.0.join(format!("{name}.ngc"));
        if !path.is_file() {
            return Ok(None);
        }
        let text = std::fs::read(&path).map_err(|error| error.to_string())?;
        Ok(Some(LoadedFile {
            name: path.display().to_string(),
            text,
        }))
    }
}

fn run() -> Result<bool, Box<dyn Error>> {
    let mut config = InterpreterConfig::like_rs274();
    let mut part = None;
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        if argument == "--tool-table" {
            let table =
                std::fs::read_to_string(arguments.next().ok_or("a tool table has to be named")?)?;
            config.tool_table = Some(ToolTable::parse(&table)?);
        } else {
            part = Some(argument);
        }
    }
    let part = part.ok_or("usage: canon [--tool-table FILE] PART")?;
    let source = BufReader::new(File::open(&part)?);
    let folder = Folder(
        Path::new(&part)
            .parent()
            .unwrap_or(Path::new("."))
            .to_owned(),
    );
    let mut out = BufWriter::new(std::io::stdout().lock());
    let diagnostics = canon::write_program(
        Program::new(source, config).with_loader(Arc::new(folder)),
        &mut out,
    )?;
    out.flush()?;
    for diagnostic in diagnostics.kept() {
        eprintln!("{diagnostic}");
    }
    Ok(diagnostics.errors() == 0)
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(2),
        Err(error) => {
            eprintln!("{error}");
            ExitCode::from(2)
        }
    }
}
