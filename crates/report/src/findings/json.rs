//! Findings as one JSON document.

use super::{Counts, Finding};
use serde::Serialize;
use std::io::{self, Write};

/// Version of the document; it rises only when a field changes its meaning or goes away.
const SCHEMA: u32 = 1;

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    #[serde(flatten)]
    counts: Counts,
    findings: &'a [Finding],
}

/// Writes findings and their counts. Values that are not finite come out as `null`.
///
/// # Errors
/// Those of the writer.
pub fn write(out: &mut dyn Write, findings: &[Finding], counts: Counts) -> io::Result<()> {
    serde_json::to_writer_pretty(
        &mut *out,
        &Document {
            schema: SCHEMA,
            counts,
            findings,
        },
    )?;
    out.write_all(b"\n")
}
