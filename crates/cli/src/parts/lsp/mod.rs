//! `lostmotion lsp`: a language server, by which editors show what the other commands find, say what
//! a line does, format, and after a run show the contour error behind each line.

mod place;

use super::check::{LintLevels, find, levels_on_machine};
use crate::findings::{Findings, Form, Voice};
use crate::options::part::{Setup, interpret};
use crate::options::{methods, threads, whole};
use crate::output::{DONE, Failure};
use clap::Args;
use lostmotion::gcode::{InterpreterConfig, Severity};
use lostmotion::gcode_tools::explain::explain;
use lostmotion::gcode_tools::format::{FormatOptions, format};
use lostmotion::report::findings::{BlockRecorder, Finding};
use lostmotion::report::number::{error, plain};
use lostmotion::sim::results::{BlockResult, Run};
use lostmotion::sim::{Machine, Observer, Program, Progress, SimulateOptions, Simulation};
use lsp_server::{Connection, ErrorCode, Message, Notification, Request, RequestId, Response};
use place::{OpenText, path_of};
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashMap};
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// `lsp`.
#[derive(Clone, Debug, Args)]
pub(crate) struct Lsp {
    /// Compensation method of a run; if left out, the one that the machine file names for each axis
    #[arg(long, value_name = "NAME", value_parser = methods())]
    method: Option<String>,
    /// Threads that a run uses at most; all cores, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>)]
    threads: Option<usize>,
    #[command(flatten)]
    setup: Setup,
    #[command(flatten)]
    lints: LintLevels,
}

/// The command that a lens runs.
const RUN: &str = "lostmotion.run";
/// Nothing goes to stderr but failures: editors show it as a fault.
const VOICE: Voice = Voice {
    quiet: true,
    diagnostics: Form::Json,
};

/// A text that is open in the editor.
#[derive(Default)]
struct Document {
    version: i64,
    text: OpenText,
    /// What a run of this very text found.
    ran: Option<Ran>,
    /// Whether one is under way.
    running: bool,
}

/// What a run found.
struct Ran {
    /// By line: the error of largest magnitude, um, and what causes most of it.
    errors: BTreeMap<u32, (f64, String)>,
    /// Blocks outside the tolerance.
    findings: Vec<Finding>,
    /// The verdict.
    title: String,
}

type Documents = Arc<Mutex<HashMap<String, Document>>>;

/// What the editor's requests and a run's thread share.
#[derive(Clone)]
struct LanguageServer {
    args: Arc<Lsp>,
    machine: Machine,
    documents: Documents,
    connection: Arc<Connection>,
    /// Whether the editor asks for hints and lenses again when told.
    refreshes: bool,
}

/// Answers an editor on stdin and stdout until it says that it ends.
pub(crate) fn run(args: &Lsp) -> Result<u8, Failure> {
    // A wrong machine or option is told now, not with every text.
    let machine = args.setup.on.load()?;
    args.setup
        .config(Some(&machine), InterpreterConfig::default())?;
    threads(args.threads)?;
    let (connection, io) = Connection::stdio();
    let failed = |error: lsp_server::ProtocolError| {
        if error.channel_is_disconnected() {
            return Failure::with_hint(
                "the input ended before a client had said hello (initialize)",
                "editors start `lostmotion lsp` and talk to it; it is no command to type",
            );
        }
        Failure::message(format!("lsp: {error}"))
    };
    let capabilities = json!({
        "positionEncoding": "utf-16",
        "textDocumentSync": { "openClose": true, "change": 1 },
        "hoverProvider": true,
        "documentFormattingProvider": true,
        "inlayHintProvider": true,
        "codeLensProvider": {},
        "executeCommandProvider": { "commands": [RUN] },
    });
    let (id, params) = connection.initialize_start().map_err(failed)?;
    let answer = json!({
        "capabilities": capabilities,
        "serverInfo": { "name": "lostmotion", "version": env!("CARGO_PKG_VERSION") },
    });
    connection.initialize_finish(id, answer).map_err(failed)?;
    let wants = |path: &str| params.pointer(path) == Some(&Value::Bool(true));
    let connection = Arc::new(connection);
    let server = LanguageServer {
        args: Arc::new(args.clone()),
        machine,
        documents: Documents::default(),
        connection: Arc::clone(&connection),
        refreshes: wants("/capabilities/workspace/inlayHint/refreshSupport"),
    };
    for message in &connection.receiver {
        match message {
            Message::Request(request) => {
                if connection.handle_shutdown(&request).map_err(failed)? {
                    break;
                }
                server.answer(request);
            }
            Message::Notification(notification) => server.heed(&notification),
            // To the refreshes: there is nothing to do about it.
            Message::Response(_) => {}
        }
    }
    // A run ends when its text has gone, and the threads of the connection when nobody is left to
    // send.
    server.documents().clear();
    drop((server, connection));
    io.join()
        .map_err(|error| Failure::message(format!("lsp: {error}")))?;
    Ok(DONE)
}

impl LanguageServer {
    fn documents(&self) -> MutexGuard<'_, HashMap<String, Document>> {
        self.documents
            .lock()
            .unwrap_or_else(PoisonError::into_inner)
    }

    /// Sends, unless the editor has gone: then the loop ends by itself.
    fn send(&self, message: impl Into<Message>) {
        let _ = self.connection.sender.send(message.into());
    }

    fn answer(&self, request: Request) {
        let Request { id, method, params } = request;
        let uri = params.pointer("/textDocument/uri").and_then(Value::as_str);
        let line = params.pointer("/position/line").and_then(Value::as_u64);
        let result = match (method.as_str(), uri) {
            ("textDocument/hover", Some(uri)) => self.hover(uri, line.unwrap_or(0)),
            ("textDocument/formatting", Some(uri)) => self.formatting(uri),
            ("textDocument/inlayHint", Some(uri)) => Ok(self.hints(uri, &params)),
            ("textDocument/codeLens", Some(uri)) => Ok(self.lenses(uri)),
            ("workspace/executeCommand", _) => self.execute(&params),
            _ => {
                let code = ErrorCode::MethodNotFound as i32;
                return self.send(Response::new_err(id, code, format!("no method {method}")));
            }
        };
        self.send(match result {
            Ok(value) => Response::new_ok(id, value),
            Err(failure) => Response::new_err(id, ErrorCode::RequestFailed as i32, failure.text()),
        });
    }

    fn heed(&self, notification: &Notification) {
        let params = &notification.params;
        let Some(uri) = params.pointer("/textDocument/uri").and_then(Value::as_str) else {
            return;
        };
        let text = match notification.method.as_str() {
            "textDocument/didOpen" => params.pointer("/textDocument/text"),
            // The whole text: no other kind of change was offered.
            "textDocument/didChange" => {
                let changes = params.pointer("/contentChanges").and_then(Value::as_array);
                changes
                    .and_then(|all| all.last())
                    .and_then(|last| last.get("text"))
            }
            "textDocument/didClose" => {
                self.documents().remove(uri);
                return self.publish(uri, None, &[]);
            }
            _ => return,
        };
        let Some(text) = text.and_then(Value::as_str) else {
            return;
        };
        let version = params
            .pointer("/textDocument/version")
            .and_then(Value::as_i64);
        let document = Document {
            version: version.unwrap_or(0),
            text: OpenText::new(text.to_owned()),
            ..Document::default()
        };
        // What a run has found is of another text now.
        self.documents().insert(uri.to_owned(), document);
        self.diagnose(uri);
    }

    /// The text of a document as a program.
    fn program(&self, uri: &str) -> Option<(Program, PathBuf, i64)> {
        let documents = self.documents();
        let document = documents.get(uri)?;
        let path = path_of(uri).unwrap_or_else(|| PathBuf::from("untitled.ngc"));
        let bytes = document.text.text.clone().into_bytes();
        let program = Program::from_bytes(path.display().to_string(), bytes);
        Some((program, path, document.version))
    }

    /// Publishes what is found in a text, and what a run of it found.
    fn diagnose(&self, uri: &str) {
        let Some((program, path, version)) = self.program(uri) else {
            return;
        };
        let levels = levels_on_machine(&self.args.lints);
        // Nothing is not a faulty program, but one that is still to be written.
        let found = if program.len().is_ok_and(|bytes| bytes == 0) {
            Ok(Findings::none(&program))
        } else {
            find(
                &program,
                &path,
                &self.args.setup,
                Some(&self.machine),
                &levels,
                VOICE,
            )
        };
        let documents = self.documents();
        let Some(document) = documents.get(uri) else {
            return;
        };
        let ran = document.ran.iter().flat_map(|ran| &ran.findings);
        let all: Vec<Value> = match &found {
            Ok(findings) => {
                let list = findings.list.iter().chain(ran);
                list.map(|finding| diagnostic(finding, &document.text))
                    .collect()
            }
            Err(failure) => vec![json!({
                "range": document.text.range(0, 0, 0),
                "severity": 1,
                "source": "lostmotion",
                "message": failure.text(),
            })],
        };
        drop(documents);
        self.publish(uri, Some(version), &all);
    }

    fn publish(&self, uri: &str, version: Option<i64>, diagnostics: &[Value]) {
        let mut params = json!({ "uri": uri, "diagnostics": diagnostics });
        if let Some(version) = version {
            params["version"] = version.into();
        }
        self.send(Notification::new(
            "textDocument/publishDiagnostics".to_owned(),
            params,
        ));
    }

    /// What a line does.
    fn hover(&self, uri: &str, line: u64) -> Result<Value, Failure> {
        let Some((program, path, _)) = self.program(uri) else {
            return Ok(Value::Null);
        };
        let setup = &self.args.setup;
        let config = setup.config(Some(&self.machine), InterpreterConfig::default())?;
        let mut operations = interpret(&program, config, Some(setup.reading.loader(&path)?))?;
        let number = u32::try_from(line + 1).unwrap_or(u32::MAX);
        let Some(explanation) = explain(&mut operations, number) else {
            return Ok(Value::Null);
        };
        let documents = self.documents();
        let ran = documents
            .get(uri)
            .and_then(|document| document.ran.as_ref());
        let found = ran.and_then(|ran| ran.errors.get(&number));
        let of_run = found.map_or(String::new(), |(um, cause)| {
            format!("\nlargest contour error {} um: {cause}\n", signed(*um))
        });
        // As it stands: no text of a program is taken for markup.
        Ok(
            json!({ "contents": { "kind": "plaintext", "value": format!("{explanation}{of_run}") } }),
        )
    }

    /// The text in the style of `gcode format`.
    fn formatting(&self, uri: &str) -> Result<Value, Failure> {
        let documents = self.documents();
        let Some(document) = documents.get(uri) else {
            return Ok(Value::Null);
        };
        let mut out = Vec::new();
        let text = &document.text;
        let summary = format(text.text.as_bytes(), &FormatOptions::default(), &mut out)
            .map_err(|error| Failure::message(format!("cannot format: {error}")))?;
        let new = String::from_utf8(out)
            .map_err(|_| Failure::message("the formatted text is not UTF-8"))?;
        Ok(if summary.changed == 0 {
            json!([])
        } else {
            json!([{ "range": text.whole(), "newText": new }])
        })
    }

    /// The contour error behind each line that was cut.
    fn hints(&self, uri: &str, params: &Value) -> Value {
        let documents = self.documents();
        let Some(Document {
            text,
            ran: Some(ran),
            ..
        }) = documents.get(uri)
        else {
            return json!([]);
        };
        let line = |end: &str| {
            let found = params.pointer(end).and_then(Value::as_u64);
            found.map(|line| u32::try_from(line + 1).unwrap_or(u32::MAX))
        };
        let from = line("/range/start/line").unwrap_or(1);
        let to = line("/range/end/line").unwrap_or(u32::MAX).max(from);
        let hint = |(line, (um, cause)): (&u32, &(f64, String))| {
            json!({
                "position": text.end_of(*line),
                "label": format!("{} \u{b5}m", signed(*um)),
                "tooltip": format!("largest contour error of this line, from {cause}; positive: left of the direction of travel"),
                "paddingLeft": true,
            })
        };
        ran.errors.range(from..=to).map(hint).collect()
    }

    /// One lens above the program: it runs it, and says what came out.
    fn lenses(&self, uri: &str) -> Value {
        let documents = self.documents();
        let Some(document) = documents.get(uri) else {
            return json!([]);
        };
        let title = match (&document.ran, document.running) {
            (_, true) => "running ...".to_owned(),
            (Some(ran), _) => format!("{}; run again", ran.title),
            (None, _) => format!("run on {}", self.machine.name()),
        };
        json!([{
            "range": document.text.range(1, 1, 0),
            "command": { "title": title, "command": RUN, "arguments": [uri] },
        }])
    }

    /// Starts a run; its end is told by hints, lenses and findings.
    fn execute(&self, params: &Value) -> Result<Value, Failure> {
        let command = params.get("command").and_then(Value::as_str);
        let uri = params.pointer("/arguments/0").and_then(Value::as_str);
        let (Some(RUN), Some(uri)) = (command, uri) else {
            let hint = format!("it has {RUN} with the address of a text");
            return Err(Failure::with_hint("lsp: there is no such command", hint));
        };
        let Some((program, path, version)) = self.program(uri) else {
            return Err(Failure::message(format!("{uri} is not open")));
        };
        if let Some(document) = self.documents().get_mut(uri) {
            // The text that runs is the one that would run again.
            if std::mem::replace(&mut document.running, true) {
                return Ok(Value::Null);
            }
        }
        let (server, uri) = (self.clone(), uri.to_owned());
        std::thread::spawn(move || {
            let ran = server.simulate(&uri, &program, &path, version);
            server.finish(&uri, version, ran);
        });
        self.refresh();
        Ok(Value::Null)
    }

    fn simulate(
        &self,
        uri: &str,
        program: &Program,
        path: &std::path::Path,
        version: i64,
    ) -> Result<Ran, Failure> {
        let options = SimulateOptions {
            threads: threads(self.args.threads)?,
            ..SimulateOptions::default()
        };
        let options = self.args.setup.options(path, &self.machine, options)?;
        let tolerance_um = self.machine.simulate().tolerance_um;
        let mut watch = RunWatch {
            documents: Arc::clone(&self.documents),
            uri: uri.to_owned(),
            version,
            errors: BTreeMap::new(),
            blocks: BlockRecorder::new(1, tolerance_um),
        };
        let simulation = Simulation::new(program, &self.machine);
        let simulation = match &self.args.method {
            Some(name) => simulation.method(name),
            None => simulation,
        };
        let run = simulation.options(options).observer(&mut watch).run();
        let run = run.map_err(|error| {
            super::failure(
                program,
                &error,
                Voice {
                    diagnostics: Form::Text,
                    ..VOICE
                },
            )
        })?;
        let mut findings = Findings::none(program);
        if let Some(result) = run.results.first() {
            findings.add_run(&watch.blocks, 0, result);
        }
        Ok(Ran {
            errors: watch.errors,
            findings: findings.list,
            title: title(&run),
        })
    }

    /// Keeps what a run found if its text is still the same, and has the editor show it.
    fn finish(&self, uri: &str, version: i64, ran: Result<Ran, Failure>) {
        let mut documents = self.documents();
        let Some(document) = documents.get_mut(uri).filter(|d| d.version == version) else {
            return;
        };
        document.running = false;
        let said = match ran {
            Ok(ran) => {
                let said = (3, ran.title.clone());
                document.ran = Some(ran);
                said
            }
            Err(failure) => (1, failure.text()),
        };
        drop(documents);
        let params = json!({ "type": said.0, "message": said.1 });
        self.send(Notification::new("window/showMessage".to_owned(), params));
        self.diagnose(uri);
        self.refresh();
    }

    /// Has the editor ask for hints and lenses again.
    fn refresh(&self) {
        if self.refreshes {
            for what in ["inlayHint", "codeLens"] {
                let id = RequestId::from(format!("refresh {what}"));
                self.send(Request::new(
                    id,
                    format!("workspace/{what}/refresh"),
                    Value::Null,
                ));
            }
        }
    }
}

/// Gathers the worst error of every line, and ends a run whose text has changed.
struct RunWatch {
    documents: Documents,
    uri: String,
    version: i64,
    errors: BTreeMap<u32, (f64, String)>,
    blocks: BlockRecorder,
}

impl Observer for RunWatch {
    fn progress(&mut self, _: Progress) -> ControlFlow<()> {
        let documents = self
            .documents
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        match documents.get(&self.uri) {
            Some(document) if document.version == self.version => ControlFlow::Continue(()),
            _ => ControlFlow::Break(()),
        }
    }

    fn blocks(&mut self, method: usize, rows: &[BlockResult]) {
        self.blocks.push(method, rows);
        for row in rows
            .iter()
            .filter(|row| !row.rapid && row.block.span.file == 0)
        {
            let kept = self.errors.entry(row.block.span.line).or_default();
            if kept.1.is_empty() || row.max_um.abs() > kept.0.abs() {
                *kept = (row.max_um, row.cause.to_string());
            }
        }
    }
}

fn signed(um: f64) -> String {
    format!("{}{}", if um > 0.0 { "+" } else { "" }, error(um))
}

/// The verdict in a line.
fn title(run: &Run) -> String {
    let Some(result) = run.results.first() else {
        return "nothing was run".to_owned();
    };
    let verdict = match (&result.stop, result.within_tolerance) {
        (Some(_), _) => "the machine stops",
        (None, true) => "within tolerance",
        (None, false) => "OUTSIDE tolerance",
    };
    format!(
        "{verdict}: {} \u{b5}m of {} \u{b5}m on {}, method {}",
        error(result.cutting.max),
        plain(run.tolerance_um),
        run.machine,
        result.method
    )
}

/// A finding as the protocol has it. One in a file of subroutines stands at the first line.
fn diagnostic(finding: &Finding, text: &OpenText) -> Value {
    let span = finding.span;
    let (range, place) = if span.file == 0 {
        (text.range(span.line, span.column, span.len), String::new())
    } else {
        let place = format!("{}, line {}: ", finding.file, span.line);
        (text.range(0, 0, 0), place)
    };
    let hint = finding
        .hint
        .as_ref()
        .map_or(String::new(), |hint| format!("\nhint: {hint}"));
    json!({
        "range": range,
        "severity": match finding.severity {
            Severity::Error => 1,
            Severity::Warning => 2,
            Severity::Note => 3,
        },
        "code": finding.code,
        "source": "lostmotion",
        "message": format!("{place}{}{hint}", finding.message),
    })
}
