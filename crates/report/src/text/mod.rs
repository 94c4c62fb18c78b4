//! Results in a terminal: a verdict, then tables.
//!
//! Plain ASCII without colour unless [`TextOptions::color`] is set, so that redirected output is
//! the same everywhere; only the line of [`along`] is not.

mod along;
mod ballbar;
mod blocks;
mod comparison;
mod parts;
mod recommend;
mod recorded;
mod rewritten;
mod runs;
mod simulation;
mod table;
mod time;

pub use along::{Along, along};
pub use ballbar::ballbar;
pub use comparison::comparison;
pub(crate) use comparison::{tested, what_it_takes};
pub use parts::straightness;
pub(crate) use parts::{stop_place, stop_reason};
pub use recommend::control_settings;
pub use recorded::record_check;
pub use rewritten::rewritten;
pub use runs::runs;
pub use simulation::simulation;
pub use table::{Align, Cell, Table};
pub use time::time;

use lostmotion_drive::Knowledge;
use lostmotion_methods::MethodId;
use lostmotion_sim::Run;

/// What to show of a result.
#[derive(Clone, Copy, Debug)]
pub struct TextOptions {
    /// Colour the verdicts with ANSI escapes.
    pub color: bool,
    /// How many of the worst blocks to list.
    pub blocks: usize,
    /// How many of the worst reversals to list.
    pub reversals: usize,
    /// Show how the methods do whose drives are told their axes wrong, where that was run.
    pub sensitivity: bool,
    /// Longest line of a table; tables leave out columns to keep it. `None` for any length.
    pub width: Option<usize>,
}

impl Default for TextOptions {
    fn default() -> TextOptions {
        TextOptions {
            color: false,
            blocks: 10,
            reversals: 10,
            sensitivity: false,
            width: None,
        }
    }
}

/// The answer of a run as the command prints it: several methods side by side, or the one.
pub fn answer(run: &Run, compared: bool, options: &TextOptions) -> String {
    match (!compared).then(|| run.clone().into_single()).flatten() {
        Some(single) => simulation(&single, options),
        None => comparison(run, options),
    }
}

/// What a method may know beyond the signals of every drive, in words; `-` for nothing.
pub fn knowledge(knows: Knowledge) -> String {
    let parts = [
        (knows.load_scale, "load scale"),
        (knows.gap, "gap"),
        (knows.load, "load"),
    ];
    let known: Vec<&str> = parts
        .into_iter()
        .filter(|(is, _)| *is)
        .map(|(_, name)| name)
        .collect();
    if known.is_empty() {
        "-".to_owned()
    } else {
        known.join(", ")
    }
}

/// The same for a method by its name; `?` for one that is not registered.
pub(crate) fn needs(method: &str) -> String {
    // A run in code may have compensators that are registered nowhere.
    method.parse().map_or_else(
        |_| "?".to_owned(),
        |method: MethodId| knowledge(method.info().knows),
    )
}

/// Ink of a verdict.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ink {
    Good,
    Bad,
}

impl TextOptions {
    /// A table in lines that are not too long.
    fn table(&self, table: &Table) -> String {
        table.render_within(self.width.unwrap_or(usize::MAX))
    }

    fn paint(&self, ink: Ink, text: &str) -> String {
        match (self.color, ink) {
            (false, _) => text.to_owned(),
            (true, Ink::Good) => format!("\x1b[1;32m{text}\x1b[0m"),
            (true, Ink::Bad) => format!("\x1b[1;31m{text}\x1b[0m"),
        }
    }
}
