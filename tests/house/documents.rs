//! Documents name only what is there.

use crate::sources::{files_under, packages, repository, shown};
use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// Every Markdown file of the repository.
fn documents() -> Vec<PathBuf> {
    let mut files = files_under(&repository());
    files.retain(|file| file.extension().is_some_and(|end| end == "md"));
    files
}

/// Text without fenced blocks, whose brackets are no links.
fn prose(text: &str) -> String {
    let mut fenced = false;
    let mut prose = String::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
        } else if !fenced {
            prose += line;
        }
        prose.push('\n');
    }
    prose
}

/// Targets of `[text](target)` that are neither on the net nor within the page.
fn links(text: &str) -> Vec<&str> {
    text.split("](")
        .skip(1)
        .filter_map(|rest| rest.split_once(')').map(|(target, _)| target))
        .map(|target| target.split_once('#').map_or(target, |(file, _)| file))
        .filter(|target| !target.is_empty() && !target.contains("://") && !target.contains(' '))
        .filter(|target| !target.starts_with("mailto:"))
        .collect()
}

/// Words of a text that begin like a path below `start`, up to where a path may end.
fn paths_below<'a>(text: &'a str, start: &str) -> Vec<&'a str> {
    let part_of_path = |c: char| c.is_ascii_alphanumeric() || "_-./".contains(c);
    text.match_indices(start)
        .filter(|(at, _)| !text[..*at].ends_with(part_of_path))
        .map(|(at, _)| {
            let rest = &text[at..];
            let end = rest.find(|c| !part_of_path(c)).unwrap_or(rest.len());
            rest[..end].trim_end_matches(['.', '/'])
        })
        .collect()
}

#[test]
fn links_lead_to_files() {
    let mut faults = String::new();
    for document in documents() {
        let text = prose(&fs::read_to_string(&document).expect("a document"));
        for target in links(&text) {
            if !document.parent().expect("a folder").join(target).exists() {
                faults += &format!("{}: {target}\n", shown(&document));
            }
        }
    }
    assert!(faults.is_empty(), "links to nothing:\n{faults}");
}

/// `crates/...`, `docs/...`, `tests/...` in documents and `docs/...` in Rust comments exist.
#[test]
fn paths_in_documents_exist() {
    let mut faults = String::new();
    let root = repository();
    let mut check = |file: &Path, text: &str, start: &str| {
        for path in paths_below(text, start) {
            // in Rust files paths may also start at their package
            let near = file.ancestors().any(|folder| folder.join(path).exists());
            // a pattern such as `crates/*/tests` ends at its star
            if !near && !root.join(path).exists() {
                faults += &format!("{}: {path}\n", shown(file));
            }
        }
    };
    for document in documents() {
        // the changelog tells of what was
        if document == root.join("CHANGELOG.md") {
            continue;
        }
        let text = fs::read_to_string(&document).expect("a document");
        for start in ["crates/", "docs/", "gcode_samples/", ".ci/", ".github/"] {
            check(&document, &text, start);
        }
    }
    for package in packages() {
        for folder in crate::sources::code_folders(&package) {
            for file in crate::sources::rust_files(&folder) {
                let text = fs::read_to_string(&file).expect("a source file");
                let comments: String = text
                    .lines()
                    .filter(|line| line.trim_start().starts_with("//"))
                    .filter(|line| !line.contains("://"))
                    .map(|line| format!("{line}\n"))
                    .collect();
                check(&file, &comments, "docs/");
                check(&file, &comments, "crates/");
            }
        }
    }
    assert!(faults.is_empty(), "paths that lead to nothing:\n{faults}");
}

#[test]
fn packages_in_documents_exist() {
    let known: BTreeSet<String> = packages().into_iter().map(|package| package.name).collect();
    let mut faults = String::new();
    for document in documents() {
        if document == repository().join("CHANGELOG.md") {
            continue;
        }
        let text = fs::read_to_string(&document).expect("a document");
        for name in paths_below(&text, "lostmotion-") {
            let crate_name = name.trim_start_matches("lostmotion-");
            if !known.contains(crate_name) {
                faults += &format!("{}: {name}\n", shown(&document));
            }
        }
    }
    assert!(faults.is_empty(), "packages that do not exist:\n{faults}");
}

/// What users meet first stays short.
#[test]
fn readme_is_short() {
    let readme = fs::read_to_string(repository().join("README.md")).expect("README.md");
    let most = 8_000;
    assert!(readme.len() <= most, "README.md has {} bytes", readme.len());
}

/// Names such as `plan::Planner::push` in the pages for hackers stand in the sources of that crate.
#[test]
fn names_in_the_tour_exist() {
    let folder = repository().join("docs/book/src/hacking");
    let packages = packages();
    let mut faults = String::new();
    for page in files_under(&folder) {
        let text = prose(&fs::read_to_string(&page).expect("a page"));
        for name in text.split('`').skip(1).step_by(2) {
            let mut parts = name.split("::");
            let first = parts.next().unwrap_or_default().replace('_', "-");
            let Some(package) = packages.iter().find(|package| package.name == first) else {
                continue;
            };
            let sources: String = crate::sources::rust_files(&package.root.join("src"))
                .iter()
                .map(|file| fs::read_to_string(file).expect("a source file"))
                .collect();
            let words = ["fn", "struct", "enum", "trait", "type", "mod", "const"];
            for part in parts {
                let declared = words.iter().any(|word| {
                    let start = format!("{word} {part}");
                    sources.match_indices(&start).any(|(at, _)| {
                        let after = sources[at + start.len()..].chars().next();
                        !after.is_some_and(|c| c.is_alphanumeric() || c == '_')
                    })
                });
                if !declared {
                    faults += &format!("{}: {name}: no {part} in {first}\n", shown(&page));
                }
            }
        }
    }
    assert!(faults.is_empty(), "names of nothing:\n{faults}");
}
