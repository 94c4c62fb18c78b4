//! How right the fits are on logs that nothing was tuned on, kept in
//! docs/book/src/trust/fits.md: `UPDATE_DOCS=1 cargo test --release -p lostmotion-identify --test it
//! held_out -- --ignored` writes the table; it takes minutes. What must hold of each kind is tested
//! on fewer logs in `logged`.

use crate::rig::score::{KINDS, Score};
use std::fmt::Write as _;
use std::path::Path;

/// First seeds of the logs that were looked at while the fits were made, and of those that judge.
const SEEDS: [u64; 2] = [210_000, 830_000];
const LOGS: u64 = 40;

#[test]
#[ignore = "takes minutes"]
fn the_table_of_the_book() {
    let mut table = String::from(
        "| logs | seeds | interval holds the gap | error, median | worst | width of the interval, median | farthest outside, in widths | refused |\n|---|---|---|---|---|---|---|---|\n",
    );
    for kind in KINDS {
        for (what, first) in ["looked at", "judging"].into_iter().zip(SEEDS) {
            let score = Score::of(kind, first..first + LOGS, |_, _, _| ());
            writeln!(table, "| {} | {what} | {} |", kind.name, score.row()).unwrap();
        }
    }
    println!("{table}");
    if std::env::var_os("UPDATE_DOCS").is_some() {
        let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/book/src/trust/fits.md");
        let text = std::fs::read_to_string(&page).unwrap();
        let start = text.find("| logs |").unwrap();
        let end = start + text[start..].find("\n\n").unwrap() + 1;
        std::fs::write(&page, [&text[..start], &table, &text[end..]].concat()).unwrap();
    }
}
