//! Why there is no result, for bindings to other languages: a kind, a stable code, a message, a hint,
//! and what was found in program or machine with its place.

use crate::findings::{Finding, Origin};
use lostmotion_base::Span;
use lostmotion_contour::ContourError;
use lostmotion_gcode::{InterpreterConfig, Severity, SubroutineLoader};
use lostmotion_gcode_tools::lint::{Levels, LintFindings, lint};
use lostmotion_plan::PlanError;
use lostmotion_sim::machine::{MachineError, Problem};
use lostmotion_sim::program::Operations;
use lostmotion_sim::request::RequestError;
use lostmotion_sim::{Program, SimError};
use serde_json::{Map, Value};
use std::io;
use std::sync::Arc;

/// What is to be changed for a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum RefusalKind {
    /// The part program.
    Program,
    /// The description of the machine.
    Machine,
    /// The method, or its axis.
    Method,
    /// A value that the caller gave.
    Option,
    /// Data: columns, logs.
    Data,
    /// Nothing: the caller has ended it.
    Cancelled,
    /// Something else.
    Other,
}

/// Why there is no result.
///
/// ```
/// use lostmotion_report::refusal::{Refusal, RefusalKind};
/// use lostmotion_sim::{Machine, Program, Simulation};
///
/// let program = Program::from_str("part", "G21 G90\nG1 Z-\nM2\n");
/// let machine = Machine::preset("vmc3")?;
/// let error = Simulation::new(&program, &machine).run().unwrap_err();
/// let refusal = Refusal::of_run(&error, &program);
/// assert_eq!(refusal.kind, RefusalKind::Program);
/// assert_eq!((refusal.findings[0].span.line, refusal.findings[0].excerpt.as_str()), (2, "G1 Z-"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Refusal {
    /// What is to be changed.
    pub kind: RefusalKind,
    /// Stable name of the reason.
    pub code: String,
    /// What is wrong, with place and values.
    pub message: String,
    /// What to do; may be empty.
    pub hint: String,
    /// What was found, each with its place.
    pub findings: Vec<Finding>,
}

impl Refusal {
    /// One without a place.
    pub fn new(kind: RefusalKind, code: &str, message: impl Into<String>, hint: &str) -> Refusal {
        Refusal {
            kind,
            code: code.to_owned(),
            message: message.into(),
            hint: hint.to_owned(),
            findings: Vec::new(),
        }
    }

    /// Of a value that a caller gave.
    pub fn option(message: impl Into<String>, hint: &str) -> Refusal {
        Refusal::new(RefusalKind::Option, "option", message, hint)
    }

    /// Of data: arrays, logs.
    pub fn data(message: impl Into<String>, hint: &str) -> Refusal {
        Refusal::new(RefusalKind::Data, "data", message, hint)
    }

    /// Of a program that cannot be read.
    pub fn unread(program: &Program, error: &io::Error) -> Refusal {
        let message = format!("cannot read {}: {error}", program.name());
        Refusal::new(RefusalKind::Program, "read", message, "")
    }

    /// Of findings in a program, the first of which gives code and hint.
    pub fn of_findings(message: String, findings: Vec<Finding>, program: &Program) -> Refusal {
        let findings: Vec<Finding> = findings
            .into_iter()
            .map(|finding| placed(finding, program))
            .collect();
        let first = findings.first();
        Refusal {
            kind: RefusalKind::Program,
            code: first.map(|first| first.code.clone()).unwrap_or_default(),
            hint: first
                .and_then(|first| first.hint.clone())
                .unwrap_or_default(),
            message,
            findings,
        }
    }

    /// Of a run, plan or check of a program.
    pub fn of_run(error: &SimError, program: &Program) -> Refusal {
        let findings = Finding::from_error(error, program.name());
        if !findings.is_empty() {
            let message = told(&findings, error);
            return Refusal::of_findings(message, findings, program);
        }
        let of = |kind, code: &str| Refusal::new(kind, code, error.to_string(), "");
        let hinted = |refusal: Refusal, hint: &str| Refusal {
            hint: hint.to_owned(),
            ..refusal
        };
        match error {
            SimError::Read { .. } => of(RefusalKind::Program, "read"),
            SimError::Empty { .. } => of(RefusalKind::Program, "empty"),
            SimError::TooLong { .. } => hinted(
                of(RefusalKind::Option, "too-long"),
                "raise max_duration_s if that is meant",
            ),
            SimError::Option { .. } => of(RefusalKind::Option, "option"),
            SimError::Threads { .. } => of(RefusalKind::Option, "threads"),
            SimError::Plan(PlanError::Setting { .. }) => of(RefusalKind::Option, "option"),
            SimError::Plan(_) => of(RefusalKind::Program, "plan"),
            SimError::Method(_) => of(RefusalKind::Method, "unknown-method"),
            SimError::Axis { .. } => of(RefusalKind::Method, "axis"),
            SimError::Machine(error) => Refusal::from(error.clone()),
            SimError::Kinematics(_) => of(RefusalKind::Machine, "kinematics"),
            SimError::Refused { what, hint } => {
                Refusal::new(RefusalKind::Option, "refused", what.clone(), hint)
            }
            SimError::Contour(ContourError::NotFinite { .. }) => hinted(
                of(RefusalKind::Other, "not-finite"),
                "a simulated axis has run away: the machine's tuning tells whether its loops are stable; a force may be too much for its motor",
            ),
            SimError::Cancelled => of(RefusalKind::Cancelled, "cancelled"),
            _ => of(RefusalKind::Other, "run"),
        }
    }
}

/// A finding with the line of the program that it is about.
pub fn placed(finding: Finding, program: &Program) -> Finding {
    if finding.span.file == 0 && finding.span.line > 0 {
        Finding {
            excerpt: program.block_text(finding.span).unwrap_or_default(),
            ..finding
        }
    } else {
        finding
    }
}

/// Everything that the interpreter finds in a program, and with levels the lints, too, in the order
/// of the text.
///
/// # Errors
/// A program that cannot be read.
pub fn findings_of(
    program: &Program,
    config: InterpreterConfig,
    loader: Arc<dyn SubroutineLoader>,
    levels: Option<Levels>,
) -> Result<Vec<Finding>, Refusal> {
    let mut reader = operations_of(program, config, loader)?;
    let linted = match levels {
        Some(levels) => Some(lint(&mut reader, levels)),
        None => {
            reader.by_ref().for_each(drop);
            None
        }
    };
    let diagnostics = reader.diagnostics();
    let origin = Origin {
        program: program.name(),
        provenance: diagnostics.provenance(),
    };
    let of_reader = diagnostics.kept().iter();
    let mut found: Vec<Finding> = of_reader
        .map(|diagnostic| Finding::from_diagnostic(diagnostic, &origin))
        .collect();
    let of_lints = linted.iter().flat_map(LintFindings::kept);
    found.extend(of_lints.map(|finding| Finding::from_lint(finding, &origin)));
    found.sort_by_key(|finding| (finding.span.file, finding.span.start));
    Ok(found)
}

/// A program's canonical operations as they are read.
///
/// # Errors
/// A program that cannot be read.
pub fn operations_of(
    program: &Program,
    config: InterpreterConfig,
    loader: Arc<dyn SubroutineLoader>,
) -> Result<Operations, Refusal> {
    let reader = program
        .operations(config)
        .map_err(|error| Refusal::unread(program, &error))?;
    Ok(reader.with_loader(loader))
}

/// The first finding with its place, and how many there are.
fn told(findings: &[Finding], error: &SimError) -> String {
    let Some(first) = findings.first() else {
        return error.to_string();
    };
    let place = format!("{}:{}:{}", first.file, first.span.line, first.span.column);
    let more = match findings.len() {
        1 => String::new(),
        count => format!(" (and {} more)", count - 1),
    };
    format!("{place}: {}{more}", first.message)
}

impl From<MachineError> for Refusal {
    fn from(error: MachineError) -> Refusal {
        let finding = |problem: &Problem| Finding {
            code: "machine".to_owned(),
            severity: Severity::Error,
            message: problem.message.clone(),
            file: error.file.clone(),
            span: Span {
                line: problem.line,
                column: problem.column,
                ..Span::default()
            },
            values: Map::from_iter([("key".to_owned(), Value::from(problem.key.as_str()))]),
            excerpt: problem.option.clone().unwrap_or_default(),
            hint: Some(problem.hint.clone()),
            calls: Vec::new(),
        };
        let text: Vec<String> = error
            .problems
            .iter()
            .map(|problem| error.text_of(problem))
            .collect();
        let hint = error.problems.first().map(|problem| problem.hint.clone());
        Refusal {
            kind: RefusalKind::Machine,
            code: "machine".to_owned(),
            message: text.join("\n"),
            hint: hint.unwrap_or_default(),
            findings: error.problems.iter().map(finding).collect(),
        }
    }
}

impl From<RequestError> for Refusal {
    fn from(error: RequestError) -> Refusal {
        match error {
            RequestError::Value { message, hint } => Refusal::option(message, &hint),
            RequestError::Machine(error) => Refusal::from(error),
            error => Refusal::option(error.to_string(), ""),
        }
    }
}
