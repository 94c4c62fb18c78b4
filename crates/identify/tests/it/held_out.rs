//! How right the fits are on logs that nothing was tuned on, kept in
//! docs/book/src/trust/fits.md: `UPDATE_DOCS=1 cargo test --release -p lostmotion-identify --test it
//! held_out` measures and writes the table; it takes a quarter of an hour. With a part of a kind's
//! name in place of the 1 it takes less: the rows of other kinds stay. Without that variable the
//! rows are checked for what they are about. What must hold of each kind is tested on fewer logs in `logged`.

use crate::rig::score::{Given, KINDS, Kind, Score};
use std::fmt::Write as _;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// First seed of the logs. None from here on were looked at while the fits were made.
const FIRST_SEED: u64 = 2_610_000;
/// Logs in a row.
const LOGS: u64 = 20;
/// Seeds for the fits from the motor alone, which were made later and take seconds.
const MOTOR_SEEDS: Range<u64> = 9_730_000..9_730_012;

/// The seeds of a kind.
fn seeds(kind: Kind) -> Range<u64> {
    match kind.given {
        Given::MotorOnly => MOTOR_SEEDS,
        Given::Everything | Given::NoAxis => FIRST_SEED..FIRST_SEED + LOGS,
    }
}

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
    if let Ok(part) = std::env::var("UPDATE_DOCS") {
        for kind in KINDS {
            if part == "1" || kind.name.contains(&part) {
                measure(kind);
            }
        }
    }
    let (_, text, place) = page();
    let rows: Vec<Vec<&str>> = text[place]
        .lines()
        .skip(2)
        .map(|row| row.trim_matches('|').split('|').map(str::trim).collect())
        .collect();
    assert!(rows.len() >= 10, "{rows:?}");
    for row in rows {
        let [name, holds, median, _, _, _, refused] = row[..] else {
            panic!("{row:?}");
        };
        let kind = KINDS.into_iter().find(|kind| kind.name == name).unwrap();
        let logs = seeds(kind).count() as u64;
        let (held, fitted) = holds.split_once(" of ").unwrap();
        let [held, fitted, refused] = [held, fitted, refused].map(|n| n.parse::<u64>().unwrap());
        assert!(held <= fitted && fitted + refused == logs, "{row:?}");
        // Where nothing was answered there is no error either.
        assert_eq!(median == "-", fitted == 0, "{row:?}");
    }
}

/// Measures a kind and writes its row.
fn measure(kind: Kind) {
    let row = Score::of(kind, seeds(kind), |_, _, _| ()).row();
    // The page is read only now: another kind may have been written in the meantime.
    let (path, text, place) = page();
    let mut table = String::new();
    let (head, body) = text[place.clone()].split_at(
        text[place.clone()]
            .match_indices('\n')
            .nth(1)
            .map_or(0, |(end, _)| end + 1),
    );
    table.push_str(head);
    for other in KINDS {
        if other.name == kind.name {
            writeln!(table, "| {} | {row} |", kind.name).unwrap();
            continue;
        }
        let begins = format!("| {} |", other.name);
        if let Some(kept) = body.lines().find(|line| line.starts_with(&begins)) {
            writeln!(table, "{kept}").unwrap();
        }
    }
    std::fs::write(
        &path,
        [&text[..place.start], &table, &text[place.end..]].concat(),
    )
    .unwrap();
}
