//! JSON Schema (draft 2020-12) of the documents that this crate writes, made from their structs.
//!
//! ```
//! use lostmotion_report::schema::{Document, schema};
//!
//! let document: Document = "simulation".parse()?;
//! let text = serde_json::to_string(&schema(document))?;
//! assert!(text.contains("\"tolerance_um\""));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::findings;
use lostmotion_base::names::did_you_mean;
use lostmotion_sim::measure::Measurements;
use lostmotion_sim::recommend::results::ControlSettings;
use lostmotion_sim::recorded::results::RecordCheck;
use lostmotion_sim::results::{Run, SingleRun};
use lostmotion_sim::rewrite::results::Rewritten;
use lostmotion_sim::testpart::BallbarAnswer;
use lostmotion_sim::time::results::CycleTime;
use schemars::generate::SchemaSettings;
use schemars::transform::{Transform, transform_subschemas};
use schemars::{JsonSchema, Schema};
use serde_json::Value;

/// A document with a schema.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Document {
    /// Answer of `simulate --format json` with one method.
    Simulation,
    /// Answer of `simulate --methods .. --format json`.
    Comparison,
    /// Answer of `time --format json`.
    Time,
    /// Answer of `check-log --format json`.
    CheckLog,
    /// Answer of `recommend --format json`.
    Recommend,
    /// Answer of `compensate --format json`.
    Compensate,
    /// Answer of `ballbar --format json`.
    Ballbar,
    /// Answer of `machine check --measure --json`.
    Measure,
    /// What is found in a part program: `--diagnostics json`.
    Findings,
}

impl Document {
    /// All of them.
    pub const ALL: [Document; 9] = [
        Document::Simulation,
        Document::Comparison,
        Document::Time,
        Document::CheckLog,
        Document::Recommend,
        Document::Compensate,
        Document::Ballbar,
        Document::Measure,
        Document::Findings,
    ];

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Document::Simulation => "simulation",
            Document::Comparison => "comparison",
            Document::Time => "time",
            Document::CheckLog => "check-log",
            Document::Recommend => "recommend",
            Document::Compensate => "compensate",
            Document::Ballbar => "ballbar",
            Document::Measure => "measure",
            Document::Findings => "findings",
        }
    }

    /// Which command writes it.
    pub const fn written_by(self) -> &'static str {
        match self {
            Document::Simulation => "simulate --format json, one method",
            Document::Comparison => "simulate --methods NAMES --format json",
            Document::Time => "time --format json",
            Document::CheckLog => "check-log --format json",
            Document::Recommend => "recommend --format json",
            Document::Compensate => "compensate --format json",
            Document::Ballbar => "ballbar --format json",
            Document::Measure => "machine check --measure --json",
            Document::Findings => "--diagnostics json, check and lint --format json",
        }
    }
}

/// A name that no document has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no document \"{name}\" with a schema; {nearest}")]
pub struct UnknownDocument {
    name: String,
    nearest: String,
}

impl std::str::FromStr for Document {
    type Err = UnknownDocument;

    fn from_str(name: &str) -> Result<Document, UnknownDocument> {
        let mut all = Document::ALL.into_iter();
        all.find(|document| document.name() == name).ok_or_else(|| {
            let names = Document::ALL.map(Document::name);
            UnknownDocument {
                name: name.to_owned(),
                nearest: did_you_mean(name, &names),
            }
        })
    }
}

/// The schema of a document: every key that is always there is required, each has its
/// description. Keys that are not in it may be added without a new number `schema` in the document.
pub fn schema(document: Document) -> Schema {
    match document {
        Document::Simulation => of::<SingleRun>(document),
        Document::Comparison => of::<Run>(document),
        Document::Time => of::<CycleTime>(document),
        Document::CheckLog => of::<RecordCheck>(document),
        Document::Recommend => of::<ControlSettings>(document),
        Document::Compensate => of::<Rewritten>(document),
        Document::Ballbar => of::<BallbarAnswer>(document),
        Document::Measure => of::<Measurements>(document),
        Document::Findings => of::<findings::Findings<'static>>(document),
    }
}

fn of<T: JsonSchema>(document: Document) -> Schema {
    let settings = SchemaSettings::draft2020_12()
        .for_serialize()
        .with_transform(Plain);
    let mut schema = settings.into_generator().into_root_schema_for::<T>();
    let title = format!("lostmotion {}", document.name());
    schema.insert("title".to_owned(), Value::from(title));
    schema
}

/// Makes a schema made from Rust one for people who do not read Rust: links of doc comments become
/// their text, and formats and defaults, which tell nothing to a reader of JSON, go.
#[derive(Clone, Debug)]
struct Plain;

impl Transform for Plain {
    fn transform(&mut self, schema: &mut Schema) {
        if let Some(Value::String(text)) = schema.get_mut("description") {
            *text = unlinked(text);
        }
        // Numbers that are not finite are written as null.
        let is_float = schema.get("format") == Some(&Value::from("double"));
        if is_float && schema.get("type") == Some(&Value::from("number")) {
            schema.insert("type".to_owned(), Value::from(vec!["number", "null"]));
        }
        for key in ["format", "default"] {
            schema.remove(key);
        }
        transform_subschemas(self, schema);
    }
}

/// A doc comment's first paragraph without links: "[`Run`]" and "[the run](crate::Run)" become
/// "`Run`" and "the run".
fn unlinked(text: &str) -> String {
    let paragraph = text.split("\n\n").next().unwrap_or_default();
    let mut plain = String::new();
    let mut rest = paragraph;
    // A link is a bracket, its text, a bracket, and perhaps a target in parentheses.
    while let Some((before, after)) = rest.split_once("[`") {
        let Some((name, after)) = after.split_once("`]") else {
            break;
        };
        plain.push_str(&format!("{before}`{name}`"));
        rest = match after.strip_prefix('(').and_then(|to| to.split_once(')')) {
            Some((_, after)) => after,
            None => after,
        };
    }
    plain.push_str(rest);
    plain.replace('\n', " ")
}
