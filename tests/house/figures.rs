//! Figures of the text, printed for whoever wants to compare.
//!
//! - files, lines: `.rs` files and their lines under `src`, and under tests, examples and benches.
//! - comments: lines of `//` comments within function bodies of `src` (no doc comments), in parts of
//!   its code lines (neither blank nor comment). Tests within `src` count as code.
//! - examples: fenced blocks in doc comments of `src` that `cargo test` runs or compiles.
//! - repeated: type names that a crate declares more than once.
//! - cycles: sets of sibling modules that use each other in a ring; in brackets their members.

use crate::names::repeated_types;
use crate::sources::cycles::cycles;
use crate::sources::{Package, code_folders, function_bodies, packages, rust_files};
use std::fs;

#[derive(Default)]
struct Figures {
    source_files: usize,
    source_lines: usize,
    other_files: usize,
    other_lines: usize,
    code_lines: usize,
    comment_lines: usize,
    examples: usize,
    repeated: usize,
    cycles: usize,
    in_cycles: usize,
}

fn figures_of(package: &Package) -> Figures {
    let mut figures = Figures::default();
    for folder in code_folders(package) {
        let source = folder.ends_with("src");
        for file in rust_files(&folder) {
            let text = fs::read_to_string(&file).expect("a source file");
            let lines = text.lines().count();
            if !source {
                figures.other_files += 1;
                figures.other_lines += lines;
                continue;
            }
            figures.source_files += 1;
            figures.source_lines += lines;
            let bodies = function_bodies(&text);
            for (number, line) in text.lines().map(str::trim_start).enumerate() {
                let within =
                    |(first, last): &(usize, usize)| (first..=last).contains(&&(number + 1));
                if line.starts_with("//") {
                    let plain = !line.starts_with("///") && !line.starts_with("//!");
                    figures.comment_lines += usize::from(plain && bodies.iter().any(within));
                } else {
                    figures.code_lines += usize::from(!line.is_empty());
                }
            }
            figures.examples += doc_examples(&text);
        }
    }
    figures.repeated = repeated_types(package).len();
    for cycle in cycles(package) {
        figures.cycles += 1;
        figures.in_cycles += cycle.members.len();
    }
    figures
}

/// Fenced blocks of doc comments that are Rust and not ignored.
fn doc_examples(text: &str) -> usize {
    let mut open = false;
    let mut examples = 0;
    for line in text.lines().map(str::trim_start) {
        let doc = line
            .strip_prefix("///")
            .or_else(|| line.strip_prefix("//!"));
        let Some(kind) = doc.and_then(|doc| doc.trim().strip_prefix("```")) else {
            continue;
        };
        if !open && ["", "rust", "no_run", "should_panic", "compile_fail"].contains(&kind) {
            examples += 1;
        }
        open = !open;
    }
    examples
}

fn row(name: &str, figures: &Figures) {
    let share = 100.0 * figures.comment_lines as f64 / (figures.code_lines as f64).max(1.0);
    println!(
        "{name:<12} {:>5} {:>7} {:>6} {:>7} {:>7} {share:>7.2} % {:>8} {:>8} {:>5} ({})",
        figures.source_files,
        figures.source_lines,
        figures.other_files,
        figures.other_lines,
        figures.comment_lines,
        figures.examples,
        figures.repeated,
        figures.cycles,
        figures.in_cycles,
    );
}

#[test]
fn figures() {
    println!(
        "crate          src   lines  other   lines comments     share examples repeated cycles"
    );
    let mut all = Figures::default();
    for package in packages() {
        let figures = figures_of(&package);
        row(&package.name, &figures);
        all.source_files += figures.source_files;
        all.source_lines += figures.source_lines;
        all.other_files += figures.other_files;
        all.other_lines += figures.other_lines;
        all.code_lines += figures.code_lines;
        all.comment_lines += figures.comment_lines;
        all.examples += figures.examples;
        all.repeated += figures.repeated;
        all.cycles += figures.cycles;
        all.in_cycles += figures.in_cycles;
    }
    row("all", &all);
    assert!(all.source_files > 0 && all.code_lines > 0);
}
