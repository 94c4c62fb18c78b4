//! A bar on stderr while something takes long.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Work that is done sooner shows no bar.
const PATIENCE: Duration = Duration::from_millis(300);

/// Steps of the bar.
const STEPS: u64 = 1000;

/// A progress bar that appears only on a terminal, and only after a moment.
pub(crate) struct Progress {
    started: Instant,
    bar: Option<ProgressBar>,
    enabled: bool,
}

impl Progress {
    /// A bar that stays away if `quiet`.
    pub(crate) fn new(quiet: bool) -> Progress {
        Progress {
            started: Instant::now(),
            bar: None,
            enabled: !quiet && std::io::stderr().is_terminal(),
        }
    }

    /// Tells how much is done, and how much time the machine has run in the simulation.
    pub(crate) fn update(&mut self, done: u64, total: u64, simulated_s: f64) {
        if !self.enabled || self.started.elapsed() < PATIENCE {
            return;
        }
        let bar = self.bar.get_or_insert_with(new_bar);
        let part = if total == 0 {
            0.0
        } else {
            done as f64 / total as f64
        };
        bar.set_position((part.clamp(0.0, 1.0) * STEPS as f64) as u64);
        bar.set_message(format!("{simulated_s:.0} s of machine time"));
    }

    /// Takes the bar away.
    pub(crate) fn finish(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

impl Drop for Progress {
    fn drop(&mut self) {
        self.finish();
    }
}

fn new_bar() -> ProgressBar {
    let bar = ProgressBar::new(STEPS);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {percent:>3} %  {msg}  {eta} left") {
        bar.set_style(style);
    }
    bar
}
