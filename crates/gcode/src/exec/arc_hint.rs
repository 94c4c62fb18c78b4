//! What an arc that is none says: where it leads, and a change that would make it right, tried before
//! it is named.

use super::Exec;
use super::arc::{ArcFault, CENTER_LETTERS, center_from_radius, check_center};
use crate::exec::words::AXIS_LETTERS;
use crate::ops::{Plane, Position};
use crate::problem::{ArcPlace, Problem, place};
use lostmotion_base::vec::{Vec2, distance2};

impl Exec<'_> {
    /// The message of an arc that is none, with what would make it right.
    #[cold]
    pub(super) fn arc_problem(&self, fault: ArcFault, start: &Position, end: &Position) -> Problem {
        let [first, second, _] = self.state.plane.axes();
        let letter = |axis: usize| char::from(AXIS_LETTERS[axis]);
        let center = match fault {
            ArcFault::TooSmall { center, .. } | ArcFault::Radii { center, .. } => Some(center),
            ArcFault::RadiusShort { .. } | ArcFault::SamePoint => None,
        };
        let place = Box::new(ArcPlace {
            axes: [letter(first), letter(second)],
            start: [start[first], start[second]],
            end: [end[first], end[second]],
            center,
        });
        let unit = self.state.units.name();
        match fault {
            ArcFault::SamePoint => Problem::ArcSamePoint,
            ArcFault::TooSmall { radius, least, .. } => Problem::ArcTooSmall {
                radius,
                least,
                unit,
                place,
            },
            ArcFault::Radii { radii, center } => {
                let [start_radius, end_radius] = radii;
                Problem::ArcRadii {
                    start_radius,
                    end_radius,
                    difference: (start_radius - end_radius).abs(),
                    unit,
                    try_this: self.right_center(start, end, center),
                    place,
                }
            }
            ArcFault::RadiusShort {
                radius,
                distance,
                least,
            } => {
                let is_right = |to: Vec2| {
                    center_from_radius(place.start, to, radius, true, self.state.units).is_ok()
                };
                Problem::ArcRadiusShort {
                    radius,
                    distance,
                    least,
                    unit,
                    try_this: self.other_distance(start, is_right),
                    place,
                }
            }
        }
    }

    /// A change of an arc whose radii differ that makes it right; each one is tried.
    #[cold]
    fn right_center(&self, start: &Position, end: &Position, center: Vec2) -> Option<String> {
        let units = self.state.units;
        let [first, second, _] = self.state.plane.axes();
        let (from, to) = ([start[first], start[second]], [end[first], end[second]]);
        let fits = |to: Vec2, center: Vec2| check_center(from, to, center, units).is_ok();
        let words = [first, second].map(|axis| self.word(CENTER_LETTERS[axis]));
        // The centre counted from the other place.
        if self.state.arc_absolute {
            let relative = [0, 1].map(|i| from[i] + words[i].unwrap_or(0.0));
            if fits(to, relative) {
                return Some("did you mean G91.1, centres relative to the start?".to_owned());
            }
        } else if let [Some(one), Some(two)] = words
            && fits(to, [one, two])
        {
            return Some("did you mean G90.1, absolute arc centres?".to_owned());
        }
        // A sign that is wrong.
        for index in [0, 1] {
            let Some(value) = words[index].filter(|value| *value != 0.0) else {
                continue;
            };
            let mut other = center;
            other[index] -= 2.0 * value;
            if fits(to, other) {
                let letter = char::from(CENTER_LETTERS[[first, second][index]]);
                return Some(format!("did you mean {letter}{}?", place(-value)));
            }
        }
        // An end counted from the other place: a relative centre stays.
        let hint = self.other_distance(start, |to| fits(to, center));
        hint.or_else(|| {
            // A centre that was rounded or mistyped: the nearest one with equal radii, as it would be
            // written.
            let near = nearest_center(from, to, center)?;
            let base = if self.state.arc_absolute {
                [0.0; 2]
            } else {
                from
            };
            let written = [0, 1].map(|i| place(near[i] - base[i]));
            let read = [0, 1].map(|i| written[i].parse::<f64>().map(|value| base[i] + value));
            let [Ok(one), Ok(two)] = read else {
                return None;
            };
            let shift = distance2(center, [one, two]);
            let is_near = shift <= MOST_CENTER_SHIFT * distance2(center, from);
            let [one_letter, two_letter] =
                [first, second].map(|axis| char::from(CENTER_LETTERS[axis]));
            (is_near && fits(to, [one, two])).then(|| {
                let [one, two] = &written;
                format!(
                    "the nearest centre with equal radii is {one_letter}{one} {two_letter}{two}"
                )
            })
        })
    }

    /// Whether an end is right if its words are read in the other distance mode.
    #[cold]
    fn other_distance(&self, start: &Position, is_right: impl Fn(Vec2) -> bool) -> Option<String> {
        let [first, second, _] = self.state.plane.axes();
        let to = [first, second].map(|axis| match self.axis_word(axis) {
            Some(value) if self.state.absolute => start[axis] + value,
            Some(value) => value,
            None => start[axis],
        });
        is_right(to).then(|| {
            if self.state.absolute {
                "did you mean G91, incremental coordinates?".to_owned()
            } else {
                "did you mean G90, absolute coordinates?".to_owned()
            }
        })
    }

    /// The plane in which the offsets of the block make an arc, if there is one.
    #[cold]
    pub(super) fn other_plane(&self, start: &Position, end: &Position) -> Option<String> {
        let planes = [(Plane::Xy, "G17"), (Plane::Zx, "G18"), (Plane::Yz, "G19")];
        // A plane that has both words first; a word that is missing counts as zero.
        let tries = [true, false].map(|both| planes.map(|(plane, code)| (plane, code, both)));
        tries.into_iter().flatten().find_map(|(plane, code, both)| {
            let [first, second, normal] = plane.axes();
            let (from, to) = ([start[first], start[second]], [end[first], end[second]]);
            let words = [first, second].map(|axis| self.word(CENTER_LETTERS[axis]));
            let stray = self.word(CENTER_LETTERS[normal]);
            if plane == self.state.plane
                || stray.is_some_and(|value| value != 0.0)
                || both != words.iter().all(Option::is_some)
            {
                return None;
            }
            let center = match (words, self.state.arc_absolute) {
                ([Some(one), Some(two)], true) => [one, two],
                ([None, None], _) | (_, true) => return None,
                ([one, two], false) => [from[0] + one.unwrap_or(0.0), from[1] + two.unwrap_or(0.0)],
            };
            check_center(from, to, center, self.state.units).ok()?;
            Some(format!("did you mean {code}, the {} plane?", plane.name()))
        })
    }
}

/// Largest shift of a centre that is proposed, relative to the radius. A choice: a tenth is a slip
/// of a digit, more is another arc.
const MOST_CENTER_SHIFT: f64 = 0.1;

/// The centre nearest to another one that is as far from the start as from the end: its foot on the
/// perpendicular bisector of the chord.
fn nearest_center(start: Vec2, end: Vec2, center: Vec2) -> Option<Vec2> {
    let chord = [end[0] - start[0], end[1] - start[1]];
    let square = chord[0] * chord[0] + chord[1] * chord[1];
    let middle = [0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1])];
    let along = ((center[0] - middle[0]) * chord[0] + (center[1] - middle[1]) * chord[1]) / square;
    along
        .is_finite()
        .then(|| [center[0] - along * chord[0], center[1] - along * chord[1]])
}
