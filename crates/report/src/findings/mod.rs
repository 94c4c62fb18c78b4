//! What was found in a part program and by a run of it, for other programs: JSON and SARIF 2.1.0.

mod refusal;
mod run;
mod sarif;

pub use run::{BlockRecorder, MOST_BLOCKS};
pub use sarif::write as write_sarif;

use lostmotion_base::span::Span;
use lostmotion_base::text::legible;
use lostmotion_gcode::{CallSite, Diagnostic, Provenance, Severity};
use lostmotion_gcode_tools::lint::{Level, LintFinding};
use serde::Serialize;
use serde_json::{Map, Value};
use std::io::{self, Write};

/// One finding, free of the interpreter that made it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Finding {
    /// Stable name of the kind of finding.
    pub code: String,
    /// Whether it refuses the program.
    pub severity: Severity,
    /// What has been found here.
    pub message: String,
    /// Name of the file.
    pub file: String,
    /// Where in the file. Line 0: the file as a whole.
    pub span: Span,
    /// The values in the message by name.
    pub values: Map<String, Value>,
    /// The line, or the part of a long one around the place, without what cannot be printed.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub excerpt: String,
    /// What to do.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hint: Option<String>,
    /// The calls that led here, innermost first.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub calls: Vec<Call>,
}

/// A call of a subroutine.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Call {
    /// The subroutine.
    pub sub: String,
    /// File of the block that calls it.
    pub file: String,
    /// That block.
    pub span: Span,
}

/// Names of files and the calls that led to a block, from the reading that made the findings.
#[derive(Clone, Copy, Debug)]
pub struct Origin<'a> {
    /// Name of the program itself.
    pub program: &'a str,
    /// What the places of the findings point into.
    pub provenance: &'a Provenance,
}

impl Origin<'_> {
    /// Name of the file of an index.
    pub fn file(&self, index: u32) -> String {
        self.provenance
            .file(index)
            .map_or(self.program, |file| file.name.as_str())
            .to_owned()
    }

    /// The calls that led to a place, innermost first.
    pub fn calls(&self, call_stack: u32) -> Vec<Call> {
        let call = |site: &CallSite| Call {
            sub: site.name.clone(),
            file: self.file(site.call.file),
            span: site.call,
        };
        self.provenance
            .call_stacks()
            .trace(call_stack)
            .map(call)
            .collect()
    }
}

impl Finding {
    /// A finding of the front end.
    pub fn from_diagnostic(diagnostic: &Diagnostic, origin: &Origin<'_>) -> Finding {
        // A problem serialises as {variant: {values}}: only the values are wanted.
        let values = match serde_json::to_value(&diagnostic.problem) {
            Ok(Value::Object(variant)) => variant.into_iter().next().map(|(_, values)| values),
            _ => None,
        };
        // The excerpt is fetched by the caller, who can read the source.
        Finding {
            code: diagnostic.code().to_owned(),
            severity: diagnostic.severity(),
            message: diagnostic.message(),
            file: origin.file(diagnostic.place.span.file),
            span: diagnostic.place.span,
            values: if let Some(Value::Object(values)) = values {
                values
            } else {
                Map::new()
            },
            excerpt: String::new(),
            hint: diagnostic.hint(),
            calls: origin.calls(diagnostic.place.call_stack),
        }
    }

    /// A finding of a lint. One that is denied is an error.
    pub fn from_lint(finding: &LintFinding, origin: &Origin<'_>) -> Finding {
        Finding {
            code: finding.rule.code.to_owned(),
            // Lints have levels, findings severities: what is denied refuses the program.
            severity: if finding.level == Level::Deny {
                Severity::Error
            } else {
                Severity::Warning
            },
            message: legible(&finding.message),
            file: origin.file(finding.place.span.file),
            span: finding.place.span,
            values: finding
                .values
                .iter()
                .map(|(name, value)| ((*name).to_owned(), Value::from(*value)))
                .collect(),
            excerpt: String::new(),
            hint: Some(finding.hint.clone()).filter(|hint| !hint.is_empty()),
            calls: origin.calls(finding.place.call_stack),
        }
    }
}

/// How many findings there were; more than are listed, if some were not kept.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Counts {
    /// Errors.
    pub errors: u64,
    /// Warnings.
    pub warnings: u64,
    /// Notes.
    pub notes: u64,
}

/// Version of the document; it rises only when a field changes its meaning or goes away.
const JSON_SCHEMA: u32 = 1;

/// What is found in a part program.
#[derive(Serialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub(crate) struct Findings<'a> {
    /// Version of the document.
    schema: u32,
    #[serde(flatten)]
    counts: Counts,
    /// What was found, in the order of the program; errors, warnings and notes beyond a number that
    /// is kept are only counted.
    findings: &'a [Finding],
}

/// Writes findings and their counts. Values that are not finite come out as `null`.
///
/// # Errors
/// Those of the writer.
pub fn write_json(out: &mut dyn Write, findings: &[Finding], counts: Counts) -> io::Result<()> {
    serde_json::to_writer_pretty(
        &mut *out,
        &Findings {
            schema: JSON_SCHEMA,
            counts,
            findings,
        },
    )?;
    out.write_all(b"\n")
}
