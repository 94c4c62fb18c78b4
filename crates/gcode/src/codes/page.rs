//! `docs/codes.md`, made from the table.

use super::{AxisUse, CodeRow, rows};
use std::fmt::Write;

const HEAD: &str = "# Codes\n\nEvery G and M code that lostmotion reads: its modal group (one line may have one code of a group), the words it takes besides F, S and T, what it \
does, a line that uses it. This page is made from the table in `crates/gcode/src/codes`; a test keeps it in step. Each code has a sample program in \
[gcode_samples/codes](../gcode_samples/codes), whose canonical operations are recorded as a snapshot.\n\n\
Axis words are X Y Z A B C U V W, and in motions the polar @ and ^. In brackets: may be there.\n";

/// The page of all codes, in Markdown.
pub fn page() -> String {
    let mut page = String::from(HEAD);
    for (letter, title) in [('G', "G codes"), ('M', "M codes")] {
        // Writing to a String cannot fail.
        let _ = write!(
            page,
            "\n## {title}\n\n| code | group | words | meaning | example | sample |\n|---|---|---|---|---|---|\n"
        );
        for row in rows().filter(|row| row.code.letter == letter) {
            let sample = format!("[{0}](../gcode_samples/codes/{0})", row.sample);
            let _ = writeln!(
                page,
                "| {} | {} | {} | {} | `{}` | {sample} |",
                row.code,
                row.group.name(),
                words(row),
                row.meaning,
                row.example
            );
        }
    }
    page
}

fn words(row: &CodeRow) -> String {
    let axes = match row.axes {
        AxisUse::None => None,
        AxisUse::May => Some("(axes)".to_owned()),
        AxisUse::Needs => Some("axes".to_owned()),
    };
    let letters = row.words.chars().map(String::from);
    axes.into_iter()
        .chain(letters)
        .collect::<Vec<_>>()
        .join(" ")
}
