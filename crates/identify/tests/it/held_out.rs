//! How right the fits are on logs that nothing was tuned on, kept in
//! docs/book/src/trust/fits.md: `UPDATE_DOCS=1 cargo test --release -p lostmotion-identify --test it
//! held_out` measures and writes the table; it takes minutes. Without that variable the rows are
//! checked for what they are about. What must hold of each kind is tested on fewer logs in `logged`.

use crate::rig::score::{KINDS, Score};
use std::fmt::Write as _;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// First seeds of the logs that were looked at while the fits were made, and of those that judge.
const SEEDS: [u64; 2] = [210_000, 830_000];
const LOTS: [&str; 2] = ["looked at", "judging"];
const LOGS: u64 = 40;

/// The page of the book, and where its table is in it.
fn page() -> (PathBuf, String, Range<usize>) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/book/src/trust/fits.md");
    let text = std::fs::read_to_string(&path).unwrap();
    let start = text.find("| logs |").unwrap();
    let end = text[start..]
        .find("\n\n")
        .map_or(text.len(), |end| start + end + 1);
    (path, text, start..end)
}

#[test]
fn the_table_of_the_book() {
    let (path, text, place) = page();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(
            &path,
            [&text[..place.start], &measured(), &text[place.end..]].concat(),
        )
        .unwrap();
    }
    let (_, text, place) = page();
    let rows: Vec<Vec<&str>> = text[place]
        .lines()
        .skip(2)
        .map(|row| row.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    assert!(rows.len() >= 10, "{rows:?}");
    for row in rows {
        let [logs, seeds, holds, median, _, _, _, refused] = row[..] else {
            panic!("{row:?}");
        };
        assert!(KINDS.iter().any(|kind| kind.name == logs), "{row:?}");
        assert!(LOTS.contains(&seeds), "{row:?}");
        let (held, fitted) = holds.split_once(" of ").unwrap();
        let [held, fitted, refused] = [held, fitted, refused].map(|n| n.parse::<u64>().unwrap());
        assert!(
            held <= fitted && fitted + refused <= LOGS && fitted + refused > 0,
            "{row:?}"
        );
        // Where nothing was answered there is no error either.
        assert_eq!(median == "-", fitted == 0, "{row:?}");
    }
}

/// The table, from the logs.
fn measured() -> String {
    let mut table = String::from(
        "| logs | seeds | interval holds the gap | error, median | worst | width of the interval, median | farthest outside, in widths | refused |\n|---|---|---|---|---|---|---|---|\n",
    );
    for kind in KINDS {
        for (what, first) in LOTS.into_iter().zip(SEEDS) {
            let score = Score::of(kind, first..first + LOGS, |_, _, _| ());
            writeln!(table, "| {} | {what} | {} |", kind.name, score.row()).unwrap();
        }
    }
    table
}
