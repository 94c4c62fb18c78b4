//! `lostmotion lsp` as an editor talks to it: messages over pipes, in the frames of the protocol.

use crate::bench::Bench;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, ChildStdin, ChildStdout, Stdio};

/// An editor with its server.
struct Editor {
    server: Child,
    to: Option<ChildStdin>,
    from: BufReader<ChildStdout>,
    asked: u64,
    /// Notifications and requests that came while an answer was waited for.
    heard: Vec<Value>,
}

impl Drop for Editor {
    fn drop(&mut self) {
        let _ = self.server.kill();
        let _ = self.server.wait();
    }
}

impl Editor {
    fn new(bench: &Bench, arguments: &[&str]) -> Editor {
        let mut command = bench.command(&[&["lsp"], arguments].concat());
        command.stdin(Stdio::piped()).stdout(Stdio::piped());
        let mut server = command.spawn().unwrap();
        let mut editor = Editor {
            to: server.stdin.take(),
            from: BufReader::new(server.stdout.take().unwrap()),
            server,
            asked: 0,
            heard: Vec::new(),
        };
        let answer = editor.ask(
            "initialize",
            json!({ "processId": null, "rootUri": null, "capabilities": {
                "workspace": { "inlayHint": { "refreshSupport": true }, "codeLens": { "refreshSupport": true } }
            } }),
        );
        assert_eq!(answer["serverInfo"]["name"], "lostmotion");
        assert_eq!(answer["capabilities"]["hoverProvider"], true);
        editor.tell("initialized", json!({}));
        editor
    }

    fn send(&mut self, message: &Value) {
        let text = message.to_string();
        let to = self.to.as_mut().unwrap();
        write!(to, "Content-Length: {}\r\n\r\n{text}", text.len()).unwrap();
        to.flush().unwrap();
    }

    fn tell(&mut self, method: &str, params: Value) {
        let mut message = json!({ "jsonrpc": "2.0", "method": method });
        message["params"] = params;
        self.send(&message);
    }

    /// The next message of the server.
    fn next(&mut self) -> Value {
        let mut length = 0;
        loop {
            let mut line = String::new();
            assert!(
                self.from.read_line(&mut line).unwrap() > 0,
                "the server has gone"
            );
            match line.trim_end().split_once(": ") {
                Some(("Content-Length", count)) => length = count.parse().unwrap(),
                Some(_) => {}
                None => break,
            }
        }
        let mut text = vec![0; length];
        self.from.read_exact(&mut text).unwrap();
        serde_json::from_slice(&text).unwrap()
    }

    /// The whole answer to a request.
    fn answer(&mut self, method: &str, params: Value) -> Value {
        self.asked += 1;
        let id = self.asked;
        let mut message = json!({ "jsonrpc": "2.0", "id": id, "method": method });
        message["params"] = params;
        self.send(&message);
        loop {
            let message = self.next();
            if message["id"] == id && message.get("method").is_none() {
                return message;
            }
            self.heard.push(message);
        }
    }

    /// What a request that is granted is answered with.
    fn ask(&mut self, method: &str, params: Value) -> Value {
        let answer = self.answer(method, params);
        assert!(answer.get("error").is_none(), "{method}: {answer}");
        answer["result"].clone()
    }

    /// The parameters of the next message of this method; what came before it is dropped.
    fn hear(&mut self, method: &str) -> Value {
        let mut heard = std::mem::take(&mut self.heard).into_iter();
        while let Some(message) = heard.next() {
            if message["method"] == method {
                self.heard = heard.collect();
                return message["params"].clone();
            }
        }
        loop {
            let message = self.next();
            if message["method"] == method {
                return message["params"].clone();
            }
        }
    }

    fn open(&mut self, uri: &str, text: &str) -> Value {
        let document = json!({ "uri": uri, "languageId": "gcode", "version": 1, "text": text });
        self.tell("textDocument/didOpen", json!({ "textDocument": document }));
        self.hear("textDocument/publishDiagnostics")
    }

    fn change(&mut self, uri: &str, version: i64, text: &str) -> Value {
        self.tell(
            "textDocument/didChange",
            json!({ "textDocument": { "uri": uri, "version": version }, "contentChanges": [{ "text": text }] }),
        );
        self.hear("textDocument/publishDiagnostics")
    }

    /// The exit code after a shutdown in order.
    fn end(mut self) -> i32 {
        assert_eq!(self.ask("shutdown", Value::Null), Value::Null);
        self.tell("exit", Value::Null);
        self.server.wait().unwrap().code().unwrap()
    }
}

const URI: &str = "file:///nowhere/my%20part.ngc";
const PART: &str = "G21 G90 G17 G61 G54 G94 F1200 (ä)\nG0 X20 Y0\nG3 I-20\nG1 X0 Y0\nM2\n";

fn of(uri: &str) -> Value {
    json!({ "textDocument": { "uri": uri }, "options": { "tabSize": 2, "insertSpaces": true },
        "range": { "start": { "line": 0, "character": 0 }, "end": { "line": 99, "character": 0 } } })
}

#[test]
fn an_editor_is_told_what_the_commands_find() {
    let bench = Bench::new();
    let mut editor = Editor::new(&bench, &["-m", "vmc3"]);
    // An arc whose ends do not fit, behind characters of two units and more than two bytes.
    let found = editor.open(URI, "G21 G90 F900\n(\u{e4}\u{1f600}) G2 X30 Y0 I4 J0\nM2\n");
    let [finding] = found["diagnostics"].as_array().unwrap().as_slice() else {
        panic!("{found}");
    };
    assert_eq!((&found["uri"], &found["version"]), (&json!(URI), &json!(1)));
    assert_eq!(
        (&finding["severity"], &finding["range"]["start"]["line"]),
        (&json!(1), &json!(1))
    );
    assert_eq!(finding["source"], "lostmotion");
    // The same code and words as the command's.
    bench.file(
        "part.ngc",
        "G21 G90 F900\n(\u{e4}\u{1f600}) G2 X30 Y0 I4 J0\nM2\n",
    );
    let said = bench.expect(2, &["check", "part.ngc", "--format", "json"]);
    let said: Value = serde_json::from_str(&said).unwrap();
    let same = &said["findings"][0];
    assert_eq!(finding["code"], same["code"]);
    assert!(
        finding["message"]
            .as_str()
            .unwrap()
            .starts_with(same["message"].as_str().unwrap())
    );
    // Columns are units of UTF-16: the bytes before it, less those that characters need more.
    let column = same["span"]["column"].as_u64().unwrap();
    let behind = if column > 8 { 3 } else { 0 };
    assert_eq!(
        finding["range"]["start"]["character"].as_u64().unwrap(),
        column - 1 - behind
    );
    // Once it is mended nothing is left; closed, neither.
    assert_eq!(editor.change(URI, 2, PART)["diagnostics"], json!([]));
    assert_eq!(editor.change(URI, 3, "")["diagnostics"], json!([]));
    let far = editor.change(URI, 4, "G21 G90 F900\nG1 X2000\nM2\n");
    let mut found = far["diagnostics"].as_array().unwrap().iter();
    let far = found
        .find(|finding| finding["code"] == "outside-travel")
        .unwrap();
    assert_eq!(far["severity"], 1);
    editor.tell(
        "textDocument/didClose",
        json!({ "textDocument": { "uri": URI } }),
    );
    assert_eq!(
        editor.hear("textDocument/publishDiagnostics")["diagnostics"],
        json!([])
    );
    assert_eq!(editor.end(), 0);
}

#[test]
fn a_line_is_explained_and_a_text_formatted() {
    let bench = Bench::new();
    let mut editor = Editor::new(&bench, &[]);
    let untidy = PART.replace("G1 X0 Y0", "g1x0y0");
    editor.open(URI, &untidy);
    let hover = editor.ask(
        "textDocument/hover",
        json!({ "textDocument": { "uri": URI }, "position": { "line": 2, "character": 1 } }),
    );
    assert_eq!(hover["contents"]["kind"], "plaintext");
    bench.file("part.ngc", &untidy);
    let said = bench.expect(0, &["gcode", "explain", "part.ngc:3", "-m", "vmc3"]);
    assert_eq!(
        hover["contents"]["value"].as_str().unwrap().trim_end(),
        said.trim_end()
    );
    let past =
        json!({ "textDocument": { "uri": URI }, "position": { "line": 99, "character": 0 } });
    assert_eq!(editor.ask("textDocument/hover", past), Value::Null);
    let edits = editor.ask("textDocument/formatting", of(URI));
    let formatted = bench.expect(0, &["gcode", "format", "part.ngc"]);
    assert_eq!(edits[0]["newText"].as_str().unwrap(), formatted);
    assert_eq!(
        edits[0]["range"],
        json!({ "start": { "line": 0, "character": 0 }, "end": { "line": 5, "character": 0 } })
    );
    editor.change(URI, 2, &formatted);
    assert_eq!(editor.ask("textDocument/formatting", of(URI)), json!([]));
    assert_eq!(editor.end(), 0);
}

#[test]
fn a_run_shows_the_error_behind_each_line() {
    let bench = Bench::new();
    let mut editor = Editor::new(&bench, &["-m", "vmc3-worn", "--method", "none"]);
    editor.open(URI, PART);
    assert_eq!(editor.ask("textDocument/inlayHint", of(URI)), json!([]));
    let lens = editor.ask("textDocument/codeLens", of(URI));
    let command = lens[0]["command"].clone();
    assert_eq!(command["title"], "run on vmc3-worn");
    editor.ask(
        "workspace/executeCommand",
        json!({ "command": command["command"], "arguments": command["arguments"] }),
    );
    let said = editor.hear("window/showMessage");
    bench.file("part.ngc", PART);
    let run = bench.run(&[
        "simulate",
        "part.ngc",
        "-m",
        "vmc3-worn",
        "--method",
        "none",
        "--format",
        "json",
        "--out",
        "out",
    ]);
    let run: Value = serde_json::from_slice(&run.stdout).unwrap();
    let tolerance = run["tolerance_um"].as_f64().unwrap();
    let is_within = run["result"]["within_tolerance"].as_bool().unwrap();
    let verdict = if is_within {
        "within tolerance: "
    } else {
        "OUTSIDE tolerance: "
    };
    assert!(
        said["message"].as_str().unwrap().starts_with(verdict),
        "{said}"
    );
    // Hints are the worst of each line that was cut, as in the table of blocks.
    let hints = editor.ask("textDocument/inlayHint", of(URI));
    let lines: Vec<u64> = hints
        .as_array()
        .unwrap()
        .iter()
        .map(|hint| hint["position"]["line"].as_u64().unwrap())
        .collect();
    assert_eq!(lines, [2, 3]);
    for (hint, worst) in hints.as_array().unwrap().iter().zip([3, 4]) {
        let block = run["result"]["worst_blocks"]
            .as_array()
            .unwrap()
            .iter()
            .find(|block| block["block"]["span"]["line"] == worst && block["rapid"] == false)
            .unwrap();
        let um = block["max_um"].as_f64().unwrap();
        let label = hint["label"]
            .as_str()
            .unwrap()
            .trim_end_matches(" \u{b5}m")
            .parse::<f64>()
            .unwrap();
        assert!((label - um).abs() < 0.06, "{label} {um}");
        assert_eq!(
            um.is_sign_positive(),
            hint["label"].as_str().unwrap().starts_with('+')
        );
    }
    // Blocks outside the tolerance are findings of the text.
    let found = editor.hear("textDocument/publishDiagnostics");
    let outside = run["result"]["worst_blocks"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|block| {
            block["rapid"] == false && block["max_um"].as_f64().unwrap().abs() > tolerance
        })
        .count();
    assert_eq!(
        found["diagnostics"].as_array().unwrap().len(),
        outside,
        "{found}"
    );
    editor.hear("workspace/inlayHint/refresh");
    let lens = editor.ask("textDocument/codeLens", of(URI));
    assert!(
        lens[0]["command"]["title"]
            .as_str()
            .unwrap()
            .ends_with("; run again")
    );
    // Of another text nothing is known.
    assert_eq!(
        editor.change(URI, 2, &format!("(new)\n{PART}"))["diagnostics"],
        json!([])
    );
    assert_eq!(editor.ask("textDocument/inlayHint", of(URI)), json!([]));
    assert_eq!(editor.end(), 0);
}

/// What is wrong is answered as such, and the server goes on.
#[test]
fn wrong_messages_do_no_harm() {
    let bench = Bench::new();
    bench.refuses(&["lsp", "-m", "nowhere"], &["nowhere"]);
    bench.refuses(&["lsp"], &["the input ended before a client"]);
    let mut editor = Editor::new(&bench, &[]);
    for (method, params) in [
        ("textDocument/rename", of(URI)),
        (
            "workspace/executeCommand",
            json!({ "command": "rm", "arguments": [URI] }),
        ),
        (
            "workspace/executeCommand",
            json!({ "command": "lostmotion.run", "arguments": [URI] }),
        ),
        ("workspace/executeCommand", json!(null)),
    ] {
        let answer = editor.answer(method, params);
        assert!(answer["error"]["message"].is_string(), "{answer}");
    }
    // Of a text that is not open nothing is known.
    assert_eq!(editor.ask("textDocument/hover", of(URI)), Value::Null);
    assert_eq!(editor.ask("textDocument/inlayHint", of(URI)), json!([]));
    editor.tell(
        "textDocument/didChange",
        json!({ "textDocument": { "uri": URI } }),
    );
    editor.tell("textDocument/didOpen", json!("nonsense"));
    // A program of nothing but a long line of markup and control characters.
    let long = format!("({}</script>\u{1}\u{202e}", "<b>".repeat(100_000));
    let found = editor.open(URI, &long);
    assert!(!found["diagnostics"].as_array().unwrap().is_empty());
    assert_eq!(editor.end(), 0);
}

/// An editor that goes without a word leaves no server behind.
#[test]
fn the_server_ends_with_its_editor() {
    let bench = Bench::new();
    let mut editor = Editor::new(&bench, &[]);
    editor.open(URI, PART);
    editor.to = None;
    assert_eq!(editor.server.wait().unwrap().code(), Some(0));
}
