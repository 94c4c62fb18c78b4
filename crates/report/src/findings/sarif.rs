//! Findings in SARIF 2.1.0, the format of static analysis results that code hosts and editors read
//! (OASIS standard).

use super::{Call, Finding, run};
use lostmotion_base::span::Span;
use lostmotion_gcode::{Severity, catalog};
use lostmotion_gcode_tools::lint::{Level, rules};
use serde_json::{Map, Value, json};
use std::collections::BTreeMap;
use std::io::{self, Write};

/// Address of the schema that the document follows.
const SARIF_SCHEMA: &str =
    "https://docs.oasis-open.org/sarif/sarif/v2.1.0/errata01/os/schemas/sarif-schema-2.1.0.json";

/// Writes a log with one run. Only the rules that have results are listed.
///
/// # Errors
/// Those of the writer.
pub fn write(out: &mut dyn Write, findings: &[Finding]) -> io::Result<()> {
    // Rules in the order of their codes, so that results can name them by index.
    let codes: BTreeMap<&str, ()> = findings
        .iter()
        .map(|finding| (finding.code.as_str(), ()))
        .collect();
    let codes: Vec<&str> = codes.into_keys().collect();
    let rules: Vec<Value> = codes.iter().map(|code| rule(code)).collect();
    let results: Vec<Value> = findings
        .iter()
        .map(|finding| result(finding, &codes))
        .collect();
    let driver = json!({ "name": "lostmotion", "semanticVersion": env!("CARGO_PKG_VERSION"), "rules": rules });
    // Columns are those of bytes; programs are ASCII, where they are those of UTF-16 too.
    let run =
        json!({ "tool": { "driver": driver }, "columnKind": "utf16CodeUnits", "results": results });
    let log = json!({ "$schema": SARIF_SCHEMA, "version": "2.1.0", "runs": [run] });
    serde_json::to_writer_pretty(&mut *out, &log)?;
    out.write_all(b"\n")
}

const fn level(severity: Severity) -> &'static str {
    match severity {
        Severity::Note => "note",
        Severity::Warning => "warning",
        Severity::Error => "error",
    }
}

/// What is known about a code.
fn rule(code: &str) -> Value {
    // A code is the interpreter's, a lint's or a run's; those of the session, such as a missing
    // axis, are in no catalogue, and SARIF asks for no more than the id.
    let of_run = run::CODES.iter().find(|(known, ..)| *known == code);
    let (severity, summary, advice) = match (catalog::find(code), rules::find(code), of_run) {
        (Some(row), ..) => (row.severity, row.summary, row.advice),
        (None, Some(rule), _) if rule.level == Level::Deny => {
            (Severity::Error, rule.summary, rule.advice)
        }
        (None, Some(rule), _) => (Severity::Warning, rule.summary, rule.advice),
        (None, None, Some(&(_, summary, advice))) => (Severity::Error, summary, advice),
        (None, None, None) => return json!({ "id": code }),
    };
    json!({
        "id": code,
        "shortDescription": { "text": summary },
        "help": { "text": advice },
        "defaultConfiguration": { "level": level(severity) },
    })
}

fn result(finding: &Finding, codes: &[&str]) -> Value {
    // SARIF has no place for a hint of one result: it follows the message.
    let text = match &finding.hint {
        Some(hint) => format!("{} ({hint})", finding.message),
        None => finding.message.clone(),
    };
    let mut result = json!({
        "ruleId": finding.code,
        "level": level(finding.severity),
        "message": { "text": text },
        "locations": [location(&finding.file, &finding.span, &finding.excerpt)],
        "properties": { "values": finding.values },
    });
    // The codes are sorted: a result names its rule by place, so that viewers need no search.
    if let (Some(object), Ok(index)) = (
        result.as_object_mut(),
        codes.binary_search(&finding.code.as_str()),
    ) {
        object.insert("ruleIndex".to_owned(), index.into());
        if !finding.calls.is_empty() {
            object.insert("stacks".to_owned(), json!([stack(&finding.calls)]));
        }
    }
    result
}

fn stack(calls: &[Call]) -> Value {
    let frame = |call: &Call| {
        let mut location = location(&call.file, &call.span, "");
        if let Some(object) = location.as_object_mut() {
            object.insert(
                "message".to_owned(),
                json!({ "text": format!("calls {}", call.sub) }),
            );
        }
        json!({ "location": location })
    };
    json!({ "message": { "text": "calls, innermost first" }, "frames": calls.iter().map(frame).collect::<Vec<_>>() })
}

fn location(file: &str, span: &Span, excerpt: &str) -> Value {
    let mut place = Map::new();
    place.insert("artifactLocation".to_owned(), json!({ "uri": uri(file) }));
    // Line 0 stands for the file as a whole: no region.
    if span.line > 0 {
        let mut region = json!({
            "startLine": span.line,
            "startColumn": span.column,
            "endColumn": u64::from(span.column) + u64::from(span.len),
            "byteOffset": span.start,
            "byteLength": span.len,
        });
        if let (Some(object), false) = (region.as_object_mut(), excerpt.is_empty()) {
            object.insert("snippet".to_owned(), json!({ "text": excerpt }));
        }
        place.insert("region".to_owned(), region);
    }
    json!({ "physicalLocation": place })
}

/// A path as a URI reference (RFC 3986): bytes outside its unreserved characters are escaped.
fn uri(path: &str) -> String {
    let path = path.replace('\\', "/");
    let mut uri = String::new();
    // Relative paths stay relative, so that viewers find them in their checkout.
    if path.starts_with('/') {
        uri.push_str("file://");
    }
    for byte in path.bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' | b'/' => {
                uri.push(char::from(byte));
            }
            _ => uri.push_str(&format!("%{byte:02X}")),
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::uri;

    #[test]
    fn paths_become_uris() {
        assert_eq!(uri("parts/a b.ngc"), "parts/a%20b.ngc");
        assert_eq!(uri("/x/ü.nc"), "file:///x/%C3%BC.nc");
        assert_eq!(uri("c:\\a"), "c%3A/a");
    }
}
