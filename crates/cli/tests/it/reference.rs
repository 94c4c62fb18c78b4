//! What the program says about keys and methods is complete, and is what the doc comments say.

use crate::bench::Bench;
use lostmotion::methods::MethodId;
use lostmotion::sim::machine::{keys, presets};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The crates whose types machine files are read into.
const CRATES: [&str; 4] = ["drive", "methods", "kinematics", "sim"];

/// Gaps that a file gives in one of several units, and a type has in one.
const GAPS: [(&str, &str); 3] = [
    (".gap_mdeg", "Total gap at the table, mdeg."),
    (".gap_arcsec", "Total gap at the table, seconds of arc."),
    (".gap_deg", "Total gap at the table, deg."),
];

fn crates() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// All Rust sources below a folder, in order.
fn sources(folder: &Path, found: &mut Vec<PathBuf>) {
    let mut entries: Vec<PathBuf> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            found.push(path);
        }
    }
}

/// Doc comments of fields and variants by `Type.field`.
fn field_docs() -> BTreeMap<String, String> {
    let mut docs = BTreeMap::new();
    for name in CRATES {
        let mut files = Vec::new();
        sources(&crates().join(name).join("src"), &mut files);
        for file in files {
            let text = std::fs::read_to_string(file).unwrap();
            let (mut of, mut doc, mut other) = (None, String::new(), None);
            for line in text.lines() {
                let trimmed = line.trim();
                // items of macros are indented
                let item = ["pub(super) ", "pub(crate) ", "pub "]
                    .iter()
                    .find_map(|shown| trimmed.strip_prefix(shown))
                    .unwrap_or(trimmed);
                let opened = item
                    .strip_prefix("struct ")
                    .or_else(|| item.strip_prefix("enum "))
                    .filter(|rest| rest.ends_with('{'));
                if opened.is_some() || !line.starts_with(' ') {
                    of = opened.map(|rest| rest.split([' ', '<']).next().unwrap().to_owned());
                    doc.clear();
                } else if let Some(said) = trimmed.strip_prefix("/// ") {
                    if !doc.is_empty() {
                        doc.push(' ');
                    }
                    doc.push_str(said);
                } else if trimmed.starts_with("#[serde") {
                    let named = ["rename = \"", "alias = \""]
                        .iter()
                        .find_map(|key| trimmed.split_once(key));
                    let named = named.and_then(|(_, rest)| rest.split('"').next());
                    other = named.map(str::to_owned).or(other);
                } else if !trimmed.starts_with('#') && !trimmed.is_empty() {
                    let field = trimmed.trim_start_matches("pub ");
                    let end = field.find(|c: char| !c.is_alphanumeric() && c != '_');
                    let field = &field[..end.unwrap_or(field.len())];
                    if let (Some(of), false) = (&of, doc.is_empty()) {
                        for name in [Some(field.to_owned()), other].into_iter().flatten() {
                            docs.entry(format!("{of}.{name}")).or_insert(doc.clone());
                        }
                    }
                    (doc, other) = (String::new(), None);
                }
            }
        }
    }
    docs
}

/// Holds a file to a text, or writes it if `UPDATE_REFERENCE` is set.
fn hold(path: &Path, text: &str) {
    if std::env::var_os("UPDATE_REFERENCE").is_some() {
        std::fs::write(path, text).unwrap();
    }
    let stands = std::fs::read_to_string(path).unwrap();
    assert!(
        stands == text,
        "{} is not what the doc comments say: run the tests with UPDATE_REFERENCE=1 once",
        path.display()
    );
}

/// The variant `Um` is written `um`, `MotorRad` `motor_rad`.
fn plain(name: &str) -> String {
    name.to_lowercase().replace(['_', '-'], "")
}

#[test]
fn every_key_says_what_its_doc_comment_says() {
    let docs = field_docs();
    let by_plain: BTreeMap<String, &String> = docs.iter().map(|(k, v)| (plain(k), v)).collect();
    let mut text = String::new();
    let mut missing = Vec::new();
    let mut told = Vec::new();
    for info in keys() {
        if told.contains(&info.field) {
            continue;
        }
        // a type `TableFile` is the form of a `Table` in files
        let same = info.field.replace("File.", ".");
        let found = by_plain
            .get(&plain(&info.field))
            .or_else(|| by_plain.get(&plain(&same)));
        let gap = || {
            GAPS.iter()
                .find(|(end, _)| info.field.ends_with(end))
                .map(|(_, doc)| *doc)
        };
        match found.map(|doc| doc.as_str()).or_else(gap) {
            Some(doc) => text.push_str(&format!("{}: {doc}\n", info.field)),
            None => missing.push(info.field.clone()),
        }
        told.push(info.field);
    }
    assert!(missing.is_empty(), "no doc comment: {missing:?}");
    hold(&crates().join("cli/src/machine/keys.txt"), &text);
}

/// Whatever stands in a machine that comes with the program is listed.
#[test]
fn every_key_of_every_preset_is_listed() {
    let listed: Vec<String> = keys().into_iter().map(|info| info.key).collect();
    let known = |key: &str| {
        let mut parts: Vec<&str> = key.split('.').collect();
        let turns = parts.last().is_some_and(|name| name.contains("_deg"));
        if parts[0] == "axis" {
            parts[1] = if parts[2] == "limits" && turns {
                "a"
            } else {
                "x"
            };
        }
        let key = parts.join(".");
        listed
            .iter()
            .any(|listed| *listed == key || listed.starts_with(&format!("{key}[]")))
    };
    fn leaves(key: &str, value: &toml::Value, found: &mut Vec<String>) {
        match value {
            toml::Value::Table(table) => {
                for (name, inner) in table {
                    let dot = if key.is_empty() { "" } else { "." };
                    leaves(&format!("{key}{dot}{name}"), inner, found);
                }
            }
            toml::Value::Array(array) if array.iter().all(toml::Value::is_table) => {
                for inner in array {
                    leaves(&format!("{key}[]"), inner, found);
                }
            }
            _ => found.push(key.to_owned()),
        }
    }
    for preset in presets() {
        let mut found = Vec::new();
        leaves(
            "",
            &toml::Value::Table(toml::from_str(preset.toml).unwrap()),
            &mut found,
        );
        for key in found {
            assert!(known(&key), "{}: {key} is not listed", preset.name);
        }
    }
}

#[test]
fn every_method_says_what_its_file_says() {
    let mut files = Vec::new();
    sources(&crates().join("methods/src"), &mut files);
    let mut heads = BTreeMap::new();
    for file in files {
        let text = std::fs::read_to_string(file).unwrap();
        let head: Vec<&str> = text
            .lines()
            .map_while(|line| line.strip_prefix("//!"))
            .collect();
        let head: Vec<&str> = head
            .iter()
            .map(|line| line.strip_prefix(' ').unwrap_or(line))
            .collect();
        for method in MethodId::all() {
            if text.contains(&format!("name: \"{}\",", method.name())) {
                heads.insert(method.name(), head.join("\n"));
            }
        }
    }
    let mut text = String::new();
    for method in MethodId::all() {
        let name = method.name();
        let head = heads
            .get(name)
            .unwrap_or_else(|| panic!("{name} has no file"));
        text.push_str(&format!("=== {name}\n{}\n", head.trim()));
    }
    hold(&crates().join("cli/src/methods.txt"), &text);
    let bench = Bench::new();
    for method in MethodId::all() {
        let shown = bench.expect(0, &["method", "show", method.name()]);
        assert!(
            shown.starts_with(&format!("{}: {}\n", method.name(), method.info().summary)),
            "{shown}"
        );
        assert!(
            shown.contains("\nneeds: ") && shown.to_lowercase().contains("settings\n")
                || shown.contains("No settings."),
            "{shown}"
        );
    }
}

#[test]
fn keys_have_types_units_defaults_ranges_and_meanings() {
    let bench = Bench::new();
    let text = bench.expect(0, &["machine", "keys", "axis.x.drive.position_gain"]);
    assert!(
        text.starts_with("axis.x.drive.position_gain_per_s  (number, 1/s; ")
            && text.contains("finite number, 0 or above)\n    "),
        "{text}"
    );
    let text = bench.expect(0, &["machine", "keys", "axis.z.compensation.lookup"]);
    assert!(
        text.contains("axis.x.compensation.lookup.torque_share  (number; default 0.8; "),
        "{text}"
    );
    let text = bench.expect(0, &["machine", "keys", "planner", "--format", "markdown"]);
    assert!(
        text.starts_with("### `[planner]`\n\n| key |")
            && text.contains("| `default_tolerance_mm` | number, mm | "),
        "{text}"
    );
    let all = bench.expect(0, &["machine", "keys"]);
    assert_eq!(
        all.lines().filter(|line| !line.starts_with(' ')).count(),
        keys().len()
    );
    bench.refuses(
        &["machine", "keys", "axis.x.drove"],
        &["no key", "did you mean `axis.x.drive"],
    );
}

/// Holds a value to a schema as far as objects, lists and references go: every key of the value is
/// described, and every required one is there.
fn described(value: &serde_json::Value, schema: &serde_json::Value, root: &serde_json::Value) {
    use serde_json::Value;
    if let Some(name) = schema["$ref"].as_str() {
        let target = name.trim_start_matches('#');
        return described(value, root.pointer(target).unwrap(), root);
    }
    let choices = schema["anyOf"].as_array().or(schema["oneOf"].as_array());
    if let Some(choices) = choices {
        // An optional structure: what is not null is the structure.
        let of = choices.iter().find(|choice| choice["$ref"].is_string());
        if let (Some(of), false) = (of, value.is_null()) {
            described(value, of, root);
        }
        return;
    }
    match value {
        Value::Object(entries) => {
            let known = schema["properties"].as_object().unwrap();
            for (key, value) in entries {
                let of = known.get(key);
                described(
                    value,
                    of.unwrap_or_else(|| panic!("{key} of {schema}")),
                    root,
                );
            }
            for key in schema["required"].as_array().into_iter().flatten() {
                assert!(
                    entries.contains_key(key.as_str().unwrap()),
                    "{key} is missing"
                );
            }
        }
        Value::Array(items) if schema["items"].is_object() => {
            items
                .iter()
                .for_each(|item| described(item, &schema["items"], root));
        }
        _ => {}
    }
}

#[test]
fn documents_follow_their_published_schemas() {
    let bench = Bench::new();
    bench.file("circle.ngc", crate::bench::CIRCLE);
    bench.file("bar.csv", crate::measured::sheet());
    bench.expect(0, &["plan", "circle.ngc", "--out", "log.csv"]);
    let parsed = |text: String| serde_json::from_str::<serde_json::Value>(&text).unwrap();
    let book = crates().join("../docs/book/src/reference/schema");
    let documents = [
        (
            "simulation",
            0,
            &[
                "simulate",
                "circle.ngc",
                "--format",
                "json",
                "--tolerance-um",
                "99",
            ][..],
        ),
        (
            "comparison",
            0,
            &[
                "simulate",
                "circle.ngc",
                "--methods",
                "none,fixed",
                "--format",
                "json",
                "--tolerance-um",
                "99",
            ],
        ),
        ("time", 0, &["time", "circle.ngc", "--format", "json"]),
        (
            "measure",
            0,
            &[
                "machine",
                "check",
                "vmc3",
                "--measure",
                "circle.ngc",
                "--json",
            ],
        ),
        (
            "check-log",
            0,
            &["check-log", "log.csv", "circle.ngc", "--format", "json"],
        ),
        (
            "recommend",
            0,
            &[
                "recommend",
                "circle.ngc",
                "--for",
                "linuxcnc",
                "--gap-uncertainty",
                "10",
                "--format",
                "json",
            ],
        ),
        (
            "compensate",
            0,
            &[
                "compensate",
                "circle.ngc",
                "--out",
                "new.ngc",
                "--format",
                "json",
            ],
        ),
        (
            "ballbar",
            0,
            &["ballbar", "bar.csv", "-m", "vmc3", "--format", "json"],
        ),
    ];
    for (name, code, arguments) in documents {
        let text = bench.expect(0, &["schema", name]);
        hold(&book.join(format!("{name}.json")), &text);
        let schema = parsed(text);
        described(&parsed(bench.expect(code, arguments)), &schema, &schema);
    }
    let text = bench.expect(0, &["schema", "findings"]);
    hold(&book.join("findings.json"), &text);
    bench.refuses(
        &["schema", "tim"],
        &["no document \"tim\"", "did you mean `time`"],
    );
}
