//! Every command and code block of README.md and of the book is run.
//!
//! | block | what is done |
//! |---|---|
//! | `console` | each `$ lostmotion ...` is run; its output is compared line by line, `...` stands for any lines, `[exit N]` at the end for an exit code other than 0 |
//! | `sh` | each line is run and has to end with exit code 0 |
//! | `gcode` | has to be read without errors |
//! | `toml` | with `file=NAME` read by the commands after it; else merged into an embedded machine (`base=NAME`, else `vmc3`), which has to be sound; with `defaults` it has to stay the same machine |
//! | `rust` | a doctest of the facade, which has to include the page |
//! | `diff` | held by the test that `held-by` names |
//! | `python` | run by the tests of the Python package, which read its page |
//! | `c`, `cpp` | built and run by `.ci/c`, which reads its page |
//! | `js` | held by the test that `held-by` names |
//! | `text` | no code: formulas, layouts |
//!
//! `file=NAME` writes a block to a file for the commands after it on the same page. `not-run="reason"`
//! leaves a block out; such blocks are counted. Commands run in a folder that has `gcode_samples`.
//!
//! `UPDATE_DOCS=1` writes the outputs of `console` blocks that have no `...`, and the pages made from
//! the program. `cargo test -p lostmotion-cli --test documents -- --nocapture` prints the counts.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

use lostmotion::Machine;
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The page whose Python blocks are run.
const PYTHON: &str = "docs/book/src/guide/python.md";

/// The page whose blocks in C and C++ are built and run.
const C: &str = "docs/book/src/guide/c.md";

/// A fenced block of a document.
struct Block {
    /// Line of its opening fence, from 1.
    line: usize,
    kind: String,
    attributes: BTreeMap<String, String>,
    text: String,
}

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn update() -> bool {
    std::env::var_os("UPDATE_DOCS").is_some()
}

/// README.md and every page of the book, with their paths from the root of the repository.
fn documents() -> Vec<String> {
    let mut documents = vec!["README.md".to_string()];
    let mut folders = vec!["docs/book/src".to_string()];
    while let Some(folder) = folders.pop() {
        for entry in fs::read_dir(repository().join(&folder)).unwrap() {
            let entry = entry.unwrap();
            let path = format!("{folder}/{}", entry.file_name().to_string_lossy());
            if entry.path().is_dir() {
                folders.push(path);
            } else if Path::new(&path).extension().is_some_and(|end| end == "md") {
                documents.push(path);
            }
        }
    }
    documents.sort();
    documents
}

fn blocks(text: &str) -> Vec<Block> {
    let mut blocks = Vec::new();
    let mut open: Option<Block> = None;
    for (index, line) in text.lines().enumerate() {
        match (&mut open, line.strip_prefix("```")) {
            (Some(_), Some(_)) => blocks.extend(open.take()),
            (Some(block), None) => {
                block.text += line;
                block.text.push('\n');
            }
            (None, Some(info)) => {
                let mut words = info_words(info).into_iter();
                open = Some(Block {
                    line: index + 1,
                    kind: words.next().unwrap_or_default(),
                    attributes: words
                        .map(|word| match word.split_once('=') {
                            Some((key, value)) => (key.to_string(), value.to_string()),
                            None => (word, String::new()),
                        })
                        .collect(),
                    text: String::new(),
                });
            }
            (None, None) => {}
        }
    }
    blocks
}

/// Words at blanks; blanks between quotes belong to their word.
fn info_words(text: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quoted = false;
    for c in text.chars() {
        match c {
            '"' => quoted = !quoted,
            ' ' if !quoted => words.push(String::new()),
            c => words.last_mut().unwrap().push(c),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Copies the files of a folder and of those below it.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// What a command writes, first its standard output, and its exit code.
fn run(command: &str, folder: &Path) -> (String, i32) {
    let words = info_words(command);
    assert_eq!(
        words.first().map(String::as_str),
        Some("lostmotion"),
        "only lostmotion is run: {command}"
    );
    let output = Command::new(env!("CARGO_BIN_EXE_lostmotion"))
        .args(&words[1..])
        .current_dir(folder)
        .env("COLUMNS", "100")
        .output()
        .unwrap();
    let mut text = String::from_utf8(output.stdout).unwrap();
    text += &String::from_utf8(output.stderr).unwrap();
    (text, output.status.code().unwrap_or(-1))
}

/// Whether lines are as expected; `...` stands for any number of them.
fn matches(expected: &[&str], actual: &[&str]) -> bool {
    match expected.split_first() {
        None => actual.is_empty(),
        Some((&"...", rest)) => (0..=actual.len()).any(|skip| matches(rest, &actual[skip..])),
        Some((line, rest)) => actual.split_first().is_some_and(|(first, others)| {
            line.trim_end() == first.trim_end() && matches(rest, others)
        }),
    }
}

/// Runs the commands of a `console` block. Gives what the block should be if it is not.
fn console(block: &Block, folder: &Path) -> Result<(), String> {
    let mut sessions: Vec<(&str, Vec<&str>)> = Vec::new();
    for line in block.text.lines() {
        if let Some(command) = line.strip_prefix("$ ") {
            sessions.push((command, Vec::new()));
        } else {
            let session = sessions.last_mut().expect("a block begins with a command");
            session.1.push(line);
        }
    }
    let mut same = true;
    let mut real = String::new();
    for (command, expected) in sessions {
        let (mut text, code) = run(command, folder);
        if code != 0 {
            let _ = writeln!(text, "[exit {code}]");
        }
        let lines: Vec<&str> = text.lines().collect();
        same &= matches(&expected, &lines);
        let _ = writeln!(real, "$ {command}");
        for line in lines {
            let _ = writeln!(real, "{}", line.trim_end());
        }
    }
    if same { Ok(()) } else { Err(real) }
}

fn merge(into: &mut toml::Table, from: toml::Table) {
    for (key, value) in from {
        match (into.get_mut(&key), value) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(more)) => merge(inner, more),
            (_, value) => {
                into.insert(key, value);
            }
        }
    }
}

/// Merges a section into an embedded machine.
fn section(block: &Block) -> Result<(), String> {
    let name = block.attributes.get("base").map_or("vmc3", String::as_str);
    let base = Machine::preset(name).map_err(|e| e.to_string())?;
    let text = base.to_toml().map_err(|e| e.to_string())?;
    let mut table: toml::Table = text.parse().map_err(|e| format!("{e}"))?;
    merge(&mut table, block.text.parse().map_err(|e| format!("{e}"))?);
    let text = toml::to_string(&table).map_err(|e| e.to_string())?;
    let machine = Machine::from_toml(name, &text).map_err(|e| e.to_string())?;
    if block.attributes.contains_key("defaults") && machine != base {
        return Err("the values are not the defaults".to_string());
    }
    Ok(())
}

/// Commands that a text names in backticks, such as `lostmotion machine check`, each up to the first
/// word that is no command.
fn named_commands(text: &str) -> Vec<String> {
    let is_name = |word: &&str| {
        word.chars().all(|c| c.is_ascii_lowercase() || c == '-') && !word.starts_with('-')
    };
    let prose: String = text.split("```").step_by(2).collect();
    prose
        .split('`')
        .skip(1)
        .step_by(2)
        .filter_map(|code| code.strip_prefix("lostmotion "))
        .map(|rest| {
            let mut words: Vec<&str> = rest.split(' ').take_while(is_name).take(2).collect();
            let alone = ["simulate", "time", "check", "plan", "completions", "man"];
            if words.first().is_some_and(|first| alone.contains(first)) {
                words.truncate(1);
            }
            words.join(" ")
        })
        .filter(|command| !command.is_empty())
        .collect()
}

#[test]
fn commands_in_prose_exist() {
    let folder = tempfile::tempdir().unwrap();
    let mut commands = BTreeMap::new();
    for document in documents() {
        let text = fs::read_to_string(repository().join(&document)).unwrap();
        for command in named_commands(&text) {
            commands.insert(command, document.clone());
        }
    }
    for (command, document) in commands {
        let (output, code) = run(&format!("lostmotion {command} --help"), folder.path());
        assert_eq!(code, 0, "{document}: lostmotion {command}: {output}");
    }
}

/// Counts of blocks by what was done with them.
type Counts = BTreeMap<String, usize>;

fn check(document: &str, counts: &mut Counts, faults: &mut String) {
    let path = repository().join(document);
    let mut text = fs::read_to_string(&path).unwrap();
    let folder = tempfile::tempdir().unwrap();
    copy(
        &repository().join("gcode_samples"),
        &folder.path().join("gcode_samples"),
    );
    let facade = fs::read_to_string(repository().join("src/lib.rs")).unwrap();
    for block in blocks(&text) {
        if let Some(name) = block.attributes.get("file") {
            fs::write(folder.path().join(name), &block.text).unwrap();
        }
        let left_out = block.attributes.get("not-run");
        let label = match left_out {
            Some(_) => "not run".to_string(),
            None => block.kind.clone(),
        };
        *counts.entry(label).or_default() += 1;
        if let Some(reason) = left_out {
            println!("{document}:{}: not run: {reason}", block.line);
            continue;
        }
        let outcome = match block.kind.as_str() {
            "console" => match console(&block, folder.path()) {
                Err(real) if update() && !block.text.contains("\n...\n") => {
                    text = text.replace(&block.text, &real);
                    Ok(())
                }
                Err(real) => Err(format!("the output is\n{real}")),
                Ok(()) => Ok(()),
            },
            "sh" => block.text.lines().try_for_each(|command| {
                let (output, code) = run(command, folder.path());
                if code == 0 {
                    Ok(())
                } else {
                    Err(format!("{command}: exit {code}\n{output}"))
                }
            }),
            "gcode" => {
                fs::write(folder.path().join("block.ngc"), &block.text).unwrap();
                let (output, code) = run("lostmotion gcode canon block.ngc", folder.path());
                if code == 0 { Ok(()) } else { Err(output) }
            }
            // What the commands after it read is judged by them.
            "toml" if block.attributes.contains_key("file") => Ok(()),
            "toml" => section(&block),
            "rust" if facade.contains(document) => Ok(()),
            "rust" => Err("src/lib.rs does not include this page as a doctest".to_string()),
            "diff" => match block.attributes.get("held-by") {
                Some(test) if repository().join(test).is_file() => Ok(()),
                _ => Err("held-by has to name the test file that makes this change".to_string()),
            },
            "text" => Ok(()),
            "python" if document == PYTHON => Ok(()),
            "python" => Err("the tests of crates/python do not run this page".to_string()),
            "c" | "cpp" if document == C => Ok(()),
            "c" | "cpp" => Err(".ci/c does not build the blocks of this page".to_string()),
            "js" => match block.attributes.get("held-by") {
                Some(test) if repository().join(test).is_file() => Ok(()),
                _ => Err("held-by has to name the test file that does this".to_string()),
            },
            other => Err(format!("nobody runs blocks of kind {other:?}")),
        };
        if let Err(fault) = outcome {
            let _ = writeln!(faults, "{document}:{}: {fault}", block.line);
        }
    }
    if update() {
        fs::write(path, text).unwrap();
    }
}

#[test]
fn blocks_of_documents_are_true() {
    let mut counts = Counts::new();
    let mut faults = String::new();
    for document in documents() {
        check(&document, &mut counts, &mut faults);
    }
    let texts = counts.remove("text").unwrap_or_default();
    let left_out = counts.remove("not run").unwrap_or_default();
    let tested: usize = counts.values().sum();
    println!("{tested} blocks tested {counts:?}, {left_out} not run, {texts} without code");
    assert!(faults.is_empty(), "{faults}");
}

/// Commands with their own help: names under the headings of `lostmotion --help`, as deep as they go.
fn subcommands(help: &str) -> Vec<String> {
    let mut names = Vec::new();
    let mut listing = false;
    // commands come first: what stands below the options may have headings of its own
    let ends = |line: &&str| line.starts_with("Options:") || line.starts_with("Arguments:");
    for line in help.lines().take_while(|line| !ends(line)) {
        if !line.starts_with(' ') {
            listing = line.ends_with(':');
        } else if listing && line.starts_with("  ") && !line.starts_with("   ") {
            let name = line.split_whitespace().next().unwrap_or_default();
            if !name.starts_with('-') && name != "help" {
                names.push(name.to_string());
            }
        }
    }
    names
}

fn page_of_commands() -> String {
    let folder = tempfile::tempdir().unwrap();
    let mut page =
        "# Commands\n\nMade from `--help` of every command; a test keeps it in step.\n".to_string();
    let mut todo = vec![String::new()];
    while let Some(command) = todo.pop() {
        let call = format!("lostmotion{command}");
        let (help, code) = run(&format!("{call} --help"), folder.path());
        assert_eq!(code, 0, "{call} --help");
        let depth = "#".repeat(2 + command.matches(' ').count().min(3));
        let help: Vec<&str> = help.lines().map(str::trim_end).collect();
        let _ = write!(
            page,
            "\n{depth} {call}\n\n```text\n{}\n```\n",
            help.join("\n")
        );
        let children = subcommands(&help.join("\n"));
        if command.matches(' ').count() < 3 {
            todo.extend(
                children
                    .iter()
                    .rev()
                    .map(|name| format!("{command} {name}")),
            );
        }
    }
    page
}

fn in_step(name: &str, page: &str) {
    let path = repository().join("docs/book/src/reference").join(name);
    if update() {
        fs::write(&path, page).unwrap();
    }
    assert!(
        fs::read_to_string(&path).unwrap_or_default() == page,
        "docs/book/src/reference/{name} is not what the program says: run with UPDATE_DOCS=1"
    );
}

/// The picture in README.md is what the command below it draws.
#[test]
fn the_picture_is_in_step() {
    let folder = tempfile::tempdir().unwrap();
    copy(
        &repository().join("gcode_samples"),
        &folder.path().join("gcode_samples"),
    );
    let command = "lostmotion simulate gcode_samples/parts/contour_rarcs.ngc --methods none,fixed --out drawn";
    let readme = fs::read_to_string(repository().join("README.md")).unwrap();
    assert!(readme.contains(&command.replace("drawn", "DIR")));
    let (output, code) = run(command, folder.path());
    assert_eq!(code, 0, "{output}");
    let drawn = fs::read(folder.path().join("drawn/contour.svg")).unwrap();
    let path = repository().join("docs/contour_rarcs.svg");
    if update() {
        fs::write(&path, &drawn).unwrap();
    }
    assert!(
        fs::read(&path).unwrap_or_default() == drawn,
        "docs/contour_rarcs.svg is not what the program draws: run with UPDATE_DOCS=1"
    );
}

#[test]
fn the_page_of_commands_is_in_step() {
    in_step("commands.md", &page_of_commands());
}

#[test]
fn the_page_of_keys_is_in_step() {
    let folder = tempfile::tempdir().unwrap();
    let (keys, code) = run("lostmotion machine keys --format markdown", folder.path());
    assert_eq!(code, 0, "{keys}");
    let head = "# Machine files\n\nEvery key of a machine file. Made by `lostmotion machine keys --format markdown`; \
                a test keeps it in step.\n\n";
    in_step("machine.md", &format!("{head}{keys}"));
}

#[test]
fn the_page_of_methods_is_in_step() {
    let folder = tempfile::tempdir().unwrap();
    let mut page = "# Methods\n\nEvery method with its settings. Made by `lostmotion method show NAME --format \
                    markdown`; a test keeps it in step. What they do is told in the [part on \
                    methods](../methods/README.md).\n"
        .to_string();
    for method in lostmotion::methods::METHODS {
        let name = method.info.name;
        let (text, code) = run(
            &format!("lostmotion method show {name} --format markdown"),
            folder.path(),
        );
        assert_eq!(code, 0, "{text}");
        // each method has its page
        let own = format!("docs/book/src/methods/{name}.md");
        assert!(repository().join(&own).is_file(), "{own} is missing");
        let _ = write!(page, "\n{}\n", text.trim());
    }
    in_step("methods.md", &page);
}
