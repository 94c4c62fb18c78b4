//! `lostmotion machine import`.

use super::DONE;
use crate::failure::Failure;
use crate::{input, output};
use lostmotion::report::atomic::AtomicFile;
use lostmotion::report::text::{Align, Table};
use lostmotion::sim::import::{ImportFormat, Row, import};
use std::io::Write;
use std::path::Path;

/// Turns a description into a machine file and tells what became of every key.
pub(crate) fn run(
    file: &Path,
    from: Option<&str>,
    preset: &str,
    out: Option<&Path>,
) -> Result<u8, Failure> {
    let text = input::text(file, "machine description")?;
    let name = file.display().to_string();
    let known = ImportFormat::NAMES.map(|(name, _)| name).join(", ");
    let format = match from {
        Some(from) => ImportFormat::NAMES
            .iter()
            .find(|(name, _)| *name == from)
            .map(|(_, format)| *format),
        None => ImportFormat::recognise(&name, &text),
    };
    let format = format.ok_or_else(|| {
        let what = from.map_or_else(
            || format!("{name}: the format is not recognised"),
            |from| format!("there is no format \"{from}\""),
        );
        Failure::with_hint(what, format!("say it with --from: {known}"))
    })?;
    let imported = import(&name, &text, format, preset)
        .map_err(|error| Failure::Rendered(error.to_string()))?;
    let report = report(&imported.rows);
    match out {
        Some(path) => {
            let mut file = AtomicFile::create(path)?;
            file.write_all(imported.toml.as_bytes()).map_err(|error| {
                Failure::message(format!("cannot write {}: {error}", path.display()))
            })?;
            file.commit()?;
            output::print(&report)?;
        }
        None => {
            output::print(&imported.toml)?;
            output::remark(&report);
        }
    }
    Ok(DONE)
}

fn report(rows: &[Row]) -> String {
    let mut table = Table::new(&[
        ("key", Align::Left),
        ("value", Align::Left),
        ("", Align::Left),
        ("", Align::Left),
    ]);
    for row in rows {
        table.row([
            row.key.as_str().into(),
            row.value.as_str().into(),
            row.fate.name().into(),
            row.note.as_str().into(),
        ]);
    }
    table.render()
}
