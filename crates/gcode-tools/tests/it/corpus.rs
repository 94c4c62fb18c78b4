//! Replays the fuzzers' corpus, and all sample programs, through the functions that the fuzzers
//! call.
use crate::checks;
use std::fs;
use std::path::{Path, PathBuf};

fn files(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(folder);
    let mut files: Vec<_> = fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.is_file())
        .collect();
    files.sort();
    files
}

/// Runs a check on its corpus and on all samples.
fn replay(target: &str, check: fn(&[u8])) {
    let corpus = files(&format!("fuzz/corpus/{target}"));
    assert!(corpus.len() > 20, "the corpus of {target} is missing");
    for path in corpus
        .iter()
        .chain(&files("gcode_samples/codes"))
        .chain(&files("gcode_samples/hostile"))
    {
        check(&fs::read(path).unwrap());
    }
}

#[test]
fn parser() {
    replay("parser", checks::parser);
}

#[test]
fn round_trip() {
    replay("round_trip", checks::round_trip);
}

#[test]
fn interpreter() {
    replay("interpreter", checks::interpreter);
}

#[test]
fn writer() {
    replay("interpreter", checks::writer);
}

#[test]
fn dialects() {
    let corpus = files("fuzz/corpus/dialects");
    assert!(corpus.len() > 20, "the corpus of dialects is missing");
    corpus
        .iter()
        .for_each(|path| checks::dialects(&fs::read(path).unwrap()));
    for path in files("gcode_samples/dialects")
        .iter()
        .chain(&files("gcode_samples/hostile"))
    {
        let text = fs::read(path).unwrap();
        for dialect in 0..6 {
            checks::dialects(&[&[dialect], text.as_slice()].concat());
        }
    }
}
