//! Which points of the space of the varied values a sweep visits.

mod sobol;

pub use sobol::{MOST_DIMENSIONS, Sobol};

use lostmotion_base::{Random, math};
use serde::{Deserialize, Serialize};
use std::fmt;

/// How points are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Design {
    /// Every level with every other.
    #[default]
    Grid,
    /// Drawn at random from a seed, each point by itself.
    Random,
    /// The first points of Sobol's sequence: spread evenly, most so where their number is a power of
    /// two.
    Sobol,
}

/// A value of a key.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Level {
    /// Yes or no.
    Flag(bool),
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
}

/// Largest whole number that is written without a point: all of them are exact.
const LARGEST_WHOLE: f64 = 1e15;

impl fmt::Display for Level {
    /// As TOML has it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Level::Flag(flag) => write!(f, "{flag}"),
            // A whole number without a point, so that it suits keys that count.
            Level::Number(number) if number.fract() == 0.0 && number.abs() < LARGEST_WHOLE => {
                write!(f, "{number:.0}")
            }
            Level::Number(number) => write!(f, "{number:?}"),
            Level::Text(text) => f.write_str(text),
        }
    }
}

/// How a range is divided.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Scale {
    /// In equal steps.
    #[default]
    Linear,
    /// By equal factors; both ends have to be above 0.
    Log,
}

/// What a coordinate may be.
#[derive(Clone, Debug, PartialEq)]
pub enum Span {
    /// One of these.
    Levels(Vec<Level>),
    /// A number of a range.
    Range {
        /// One end.
        from: f64,
        /// The other.
        to: f64,
        /// How it is divided.
        scale: Scale,
        /// Levels of a grid, both ends among them.
        steps: usize,
    },
}

impl Span {
    /// Number of levels in a grid.
    pub fn count(&self) -> usize {
        match self {
            Span::Levels(levels) => levels.len(),
            Span::Range { steps, .. } => *steps,
        }
    }

    /// The level at a place from 0 (the first) to 1.
    fn level(&self, place: f64) -> Option<Level> {
        match self {
            Span::Levels(levels) => {
                // Equal parts of the way for each level; 1 itself belongs to the last.
                let index = (place * levels.len() as f64) as usize;
                levels
                    .get(index.min(levels.len().saturating_sub(1)))
                    .cloned()
            }
            Span::Range {
                from, to, scale, ..
            } => Some(Level::Number(match scale {
                // The ends themselves are met to the bit.
                _ if place >= 1.0 => *to,
                _ if place <= 0.0 => *from,
                Scale::Linear => from + (to - from) * place,
                Scale::Log => from * math::pow(to / from, place),
            })),
        }
    }

    /// The levels of a grid, in their order.
    fn levels(&self) -> Vec<Level> {
        match self {
            Span::Levels(levels) => levels.clone(),
            Span::Range { steps, .. } => {
                let last = steps.saturating_sub(1).max(1) as f64;
                (0..*steps)
                    .filter_map(|step| self.level(step as f64 / last))
                    .collect()
            }
        }
    }

    /// Those of its levels on which a machine is tried before the sweep: all of a list, both ends of
    /// a range.
    pub(crate) fn tried(&self) -> Vec<Level> {
        match self {
            Span::Levels(levels) => levels.clone(),
            Span::Range { .. } => [0.0, 1.0].iter().filter_map(|at| self.level(*at)).collect(),
        }
    }
}

impl Design {
    /// Number of points; `None` where it is beyond any.
    pub fn count(self, spans: &[Span], points: usize) -> Option<usize> {
        match self {
            Design::Grid => spans
                .iter()
                .try_fold(1_usize, |count, span| count.checked_mul(span.count())),
            Design::Random | Design::Sobol => Some(points),
        }
    }

    /// The points, each with a level for each span. Of a grid the last span runs fastest.
    ///
    /// ```
    /// use lostmotion_sweep::design::{Design, Level, Scale, Span};
    ///
    /// let gap = Span::Range { from: 0.0, to: 40.0, scale: Scale::Linear, steps: 3 };
    /// let points: Vec<_> = Design::Grid.points(&[gap], 0, 0).collect();
    /// assert_eq!(points, [[0.0], [20.0], [40.0]].map(|point| point.map(Level::Number).to_vec()));
    /// ```
    pub fn points(
        self,
        spans: &[Span],
        points: usize,
        seed: u64,
    ) -> Box<dyn Iterator<Item = Vec<Level>> + '_> {
        let at = move |place: &mut dyn FnMut(usize) -> f64| -> Vec<Level> {
            spans
                .iter()
                .enumerate()
                .filter_map(|(index, span)| span.level(place(index)))
                .collect()
        };
        match self {
            Design::Grid => Box::new(grid(spans)),
            Design::Random => {
                let mut random = Random::new(seed);
                Box::new((0..points).map(move |_| at(&mut |_| random.unit())))
            }
            Design::Sobol => {
                let places = Sobol::new(spans.len()).take(points);
                let level = |point: &[f64], index: usize| point.get(index).copied();
                Box::new(places.map(move |point| {
                    at(&mut |index| level(point.as_slice(), index).unwrap_or_default())
                }))
            }
        }
    }
}

fn grid(spans: &[Span]) -> impl Iterator<Item = Vec<Level>> {
    let levels: Vec<Vec<Level>> = spans.iter().map(Span::levels).collect();
    let count = levels.iter().map(Vec::len).product::<usize>();
    (0..count).map(move |mut number| {
        // The digits of its number, of which the last is that of the last span.
        let mut point = Vec::with_capacity(levels.len());
        for levels in levels.iter().rev() {
            point.extend(levels.get(number % levels.len()).cloned());
            number /= levels.len();
        }
        point.reverse();
        point
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn range(from: f64, to: f64, scale: Scale, steps: usize) -> Span {
        Span::Range {
            from,
            to,
            scale,
            steps,
        }
    }

    fn numbers(points: impl Iterator<Item = Vec<Level>>) -> Vec<Vec<f64>> {
        let number = |level: &Level| match level {
            Level::Number(number) => *number,
            _ => f64::NAN,
        };
        points
            .map(|point| point.iter().map(number).collect())
            .collect()
    }

    #[test]
    fn a_grid_has_every_level_with_every_other() {
        let text = |text: &str| Level::Text(text.to_owned());
        let spans = [
            Span::Levels(vec![text("a"), text("b")]),
            range(1.0, 100.0, Scale::Log, 3),
        ];
        let points: Vec<_> = Design::Grid.points(&spans, 0, 0).collect();
        let shown: Vec<String> = points
            .iter()
            .map(|point| format!("{}{}", point[0], point[1]))
            .collect();
        assert_eq!(shown, ["a1", "a10", "a100", "b1", "b10", "b100"]);
        assert_eq!(Design::Grid.count(&spans, 0), Some(6));
        // No key varied: one point, the machine as it is.
        let points: Vec<_> = Design::Grid.points(&[], 0, 0).collect();
        assert_eq!(points, [Vec::new()]);
        assert_eq!(
            Design::Grid.count(&vec![range(0.0, 1.0, Scale::Linear, 1 << 20); 9], 0),
            None
        );
    }

    #[test]
    fn random_points_are_those_of_their_seed_and_within_the_range() {
        let spans = [
            range(5.0, 10.0, Scale::Linear, 0),
            range(1e-3, 1e3, Scale::Log, 0),
        ];
        let points = numbers(Design::Random.points(&spans, 2000, 7));
        assert_eq!(points, numbers(Design::Random.points(&spans, 2000, 7)));
        assert_ne!(points, numbers(Design::Random.points(&spans, 2000, 8)));
        assert!(
            points
                .iter()
                .all(|p| (5.0..10.0).contains(&p[0]) && (1e-3..1e3).contains(&p[1]))
        );
        // Half of a logarithmic range lies below its geometric middle: 4.5 standard deviations.
        let below = points.iter().filter(|point| point[1] < 1.0).count();
        assert!((900..1100).contains(&below), "{below}");
    }

    #[test]
    fn numbers_are_written_as_toml_reads_them_back() {
        for (number, text) in [
            (20.0, "20"),
            (0.1, "0.1"),
            (1e-7, "1e-7"),
            (-3.0, "-3"),
            (1e16, "1e16"),
        ] {
            assert_eq!(Level::Number(number).to_string(), text);
            let read: toml::Table = format!("x = {text}").parse().unwrap();
            let value = &read["x"];
            let back = value
                .as_float()
                .or(value.as_integer().map(|whole| whole as f64));
            assert_eq!(back, Some(number));
        }
    }
}
