//! The contour error along a program as a line of blocks, for a terminal.

use super::{Ink, TextOptions};
use crate::number::{duration, error, plain};
use lostmotion_sim::ContourPoint;

/// Parts of the time that are held, twice as many just before they are joined. A choice: more than
/// a terminal has columns.
const MOST_PARTS: usize = 512;
/// Columns if no width is given.
const COLUMNS: usize = 80;
/// Eighths of a line's height.
const BLOCKS: [char; 8] = [
    '\u{2581}', '\u{2582}', '\u{2583}', '\u{2584}', '\u{2585}', '\u{2586}', '\u{2587}', '\u{2588}',
];

/// Gathers the contour error of one method along a program, in memory that does not grow with it.
///
/// ```
/// use lostmotion_report::text::{Along, TextOptions, along};
///
/// let options = TextOptions { width: Some(40), ..TextOptions::default() };
/// let nothing = along(&[("none", &Along::default())], 20.0, 1.5, &options);
/// assert!(nothing.is_empty());
/// ```
#[derive(Clone, Debug)]
pub struct Along {
    /// Ticks of a part.
    group: u64,
    seen: u64,
    /// Largest error of cutting moves in each part, um; NaN where nothing is cut.
    parts: Vec<f32>,
}

impl Default for Along {
    fn default() -> Along {
        Along {
            group: 1,
            seen: 0,
            parts: Vec::new(),
        }
    }
}

impl Along {
    /// Takes the next servo ticks.
    pub fn push(&mut self, points: &[ContourPoint]) {
        for point in points {
            let cuts = point.moving && !point.rapid;
            self.tick(if cuts {
                point.error_um.abs() as f32
            } else {
                f32::NAN
            });
        }
    }

    fn tick(&mut self, um: f32) {
        if self.seen.is_multiple_of(self.group) {
            if self.parts.len() >= 2 * MOST_PARTS {
                self.parts = self.parts.chunks(2).map(largest).collect();
                self.group *= 2;
            }
            // Where parts were joined just now, the last one is whole: their number was even.
            self.parts.push(um);
        } else if let Some(last) = self.parts.last_mut() {
            *last = last.max(um);
        }
        self.seen += 1;
    }

    /// The largest error in each of so many equal parts of the time.
    fn columns(&self, count: usize) -> Vec<f32> {
        let parts = self.parts.len();
        (0..count)
            .map(|column| {
                let from = column * parts / count;
                let to = ((column + 1) * parts).div_ceil(count).min(parts);
                self.parts.get(from..to.max(from)).map_or(f32::NAN, largest)
            })
            .collect()
    }
}

/// `f32::max` leaves out what is not a number.
fn largest(values: &[f32]) -> f32 {
    values.iter().copied().fold(f32::NAN, f32::max)
}

/// A line of blocks a method: how large the contour error is along the program, which takes
/// `duration_s`. Full height is the tolerance, or the largest error of them all if that is larger;
/// blank is where nothing is cut. Empty where no method cuts anything. Not ASCII: for terminals.
pub fn along(
    methods: &[(&str, &Along)],
    tolerance_um: f64,
    duration_s: f64,
    options: &TextOptions,
) -> String {
    let all = methods.iter().flat_map(|(_, along)| &along.parts);
    let worst = f64::from(all.copied().fold(f32::NAN, f32::max));
    if !worst.is_finite() {
        return String::new();
    }
    let name_width = match methods {
        [_] => 0,
        _ => methods
            .iter()
            .map(|(name, _)| name.chars().count() + 2)
            .max()
            .unwrap_or(0),
    };
    let width = options.width.unwrap_or(COLUMNS).min(MOST_PARTS);
    let columns = width.saturating_sub(name_width).max(8);
    let top = worst.max(tolerance_um);
    let what = if top > tolerance_um {
        format!(
            "full height {} um, tolerance {} um",
            error(top),
            plain(tolerance_um)
        )
    } else {
        format!("full height {} um, the tolerance", plain(tolerance_um))
    };
    let mut out = format!(
        "\nerror along the program, {}; {what}\n",
        duration(duration_s)
    );
    for (name, along) in methods {
        if name_width > 0 {
            out.push_str(&format!("{name:<name_width$}"));
        }
        // Neighbours of one colour are painted together: escapes are longer than blocks.
        let mut run = String::new();
        let mut outside = false;
        let mut line = String::new();
        for um in along.columns(columns).into_iter().map(f64::from) {
            let is_out = um > tolerance_um;
            if is_out != outside && !run.is_empty() {
                line.push_str(&painted(&std::mem::take(&mut run), outside, options));
            }
            outside = is_out;
            run.push(block(um, top));
        }
        line.push_str(&painted(&run, outside, options));
        out.push_str(line.trim_end());
        out.push('\n');
    }
    out
}

fn painted(run: &str, outside: bool, options: &TextOptions) -> String {
    if outside {
        options.paint(Ink::Bad, run)
    } else {
        run.to_owned()
    }
}

fn block(um: f64, top: f64) -> char {
    if um.is_nan() {
        return ' ';
    }
    // Rounded up: an error just above an eighth of the height is seen to be.
    let eighths = (8.0 * um / top.max(1e-9)).ceil().clamp(1.0, 8.0) as usize;
    BLOCKS[eighths - 1]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(errors: impl Iterator<Item = f32>) -> Along {
        let mut along = Along::default();
        errors.for_each(|um| along.tick(um));
        along
    }

    /// One spike in a million ticks stands in the column of its time, and is the only one.
    #[test]
    fn no_peak_is_lost_and_memory_is_bounded() {
        let (ticks, peak) = (1_000_003, 612_345);
        let along = of((0..ticks).map(|tick| if tick == peak { 9.0 } else { 1.0 }));
        assert!(along.parts.len() <= 2 * MOST_PARTS);
        for columns in [8, 33, 80, 200] {
            let found = along.columns(columns);
            let at = peak * columns / ticks;
            for (column, um) in found.iter().enumerate() {
                // A part of the time may lie over the border of two columns.
                let near = column.abs_diff(at) <= 1;
                assert!(*um < 9.0 || near, "{columns} {column}");
            }
            assert!(found.contains(&9.0));
        }
    }

    #[test]
    fn a_line_is_tied_to_the_tolerance_and_fits() {
        let ramp = of((0..800_u16).map(|tick| match tick {
            700.. => f32::NAN,
            _ => f32::from(tick) / 700.0 * 8.0,
        }));
        let options = TextOptions {
            width: Some(8),
            ..TextOptions::default()
        };
        let text = along(&[("none", &ramp)], 8.0, 0.2, &options);
        let line = text.lines().nth(2).unwrap();
        assert_eq!(
            line,
            "\u{2582}\u{2583}\u{2584}\u{2585}\u{2586}\u{2587}\u{2588}"
        );
        // Twice the tolerance: what is above it is painted, what is below it has half the height.
        let color = TextOptions {
            color: true,
            ..options
        };
        let text = along(&[("none", &ramp)], 4.0, 0.2, &color);
        assert!(
            text.contains("full height 7.99 um, tolerance 4 um"),
            "{text}"
        );
        let (below, above) = text.split_once("\x1b[1;31m").unwrap();
        assert!(below.ends_with("\u{2582}\u{2583}\u{2584}"), "{text}");
        assert!(
            above.starts_with("\u{2585}\u{2586}\u{2587}\u{2588}\x1b[0m"),
            "{text}"
        );
        let wide = TextOptions {
            width: Some(40),
            ..options
        };
        let text = along(
            &[("none", &ramp), ("load-feedback", &ramp)],
            8.0,
            0.2,
            &wide,
        );
        let lengths: Vec<usize> = text
            .lines()
            .skip(2)
            .map(|line| line.chars().count())
            .collect();
        assert_eq!(lengths.len(), 2);
        assert!(
            lengths.iter().all(|length| (30..=40).contains(length)),
            "{text}"
        );
    }
}
