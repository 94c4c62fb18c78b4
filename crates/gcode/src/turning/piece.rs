//! Lines and arcs of a profile in the plane of travel and level.

use lostmotion_base::math;
use std::f64::consts::{PI, TAU};

/// A place: along the direction of travel, and the level above it.
pub(crate) type Point = [f64; 2];

/// The circle of an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Circle {
    pub(crate) center: Point,
    /// Counter-clockwise, travel to the right and level up.
    pub(crate) ccw: bool,
}

/// A line, or an arc with its circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    pub(crate) start: Point,
    pub(crate) end: Point,
    pub(crate) circle: Option<Circle>,
}

/// A stretch of a piece that only rises or only falls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Stretch {
    pub(crate) from: Point,
    pub(crate) to: Point,
    /// It does not fall. Where an arc begins at its highest place this is true of a first stretch
    /// of no length.
    pub(crate) rises: bool,
}

pub(crate) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1]]
}

pub(crate) fn along(from: Point, way: Point, length: f64) -> Point {
    [from[0] + length * way[0], from[1] + length * way[1]]
}

pub(crate) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1]
}

pub(crate) fn cross(a: Point, b: Point) -> f64 {
    a[0] * b[1] - a[1] * b[0]
}

pub(crate) fn distance(a: Point, b: Point) -> f64 {
    math::hypot(b[0] - a[0], b[1] - a[1])
}

/// Direction from one place to another; zero if they are the same.
pub(crate) fn direction(from: Point, to: Point) -> Point {
    let length = distance(from, to);
    if length > 0.0 {
        [(to[0] - from[0]) / length, (to[1] - from[1]) / length]
    } else {
        [0.0; 2]
    }
}

/// A quarter turn counter-clockwise.
pub(crate) const fn left_of(way: Point) -> Point {
    [-way[1], way[0]]
}

impl Piece {
    pub(crate) const fn line(start: Point, end: Point) -> Piece {
        Piece {
            start,
            end,
            circle: None,
        }
    }

    pub(crate) const fn arc(start: Point, end: Point, center: Point, ccw: bool) -> Piece {
        Piece {
            start,
            end,
            circle: Some(Circle { center, ccw }),
        }
    }

    /// The piece upside down.
    pub(crate) fn mirrored(&self) -> Piece {
        let flip = |place: Point| [place[0], -place[1]];
        let circle = self.circle.map(|circle| Circle {
            center: flip(circle.center),
            ccw: !circle.ccw,
        });
        Piece {
            start: flip(self.start),
            end: flip(self.end),
            circle,
        }
    }

    /// Radius at the start; none for a line.
    pub(crate) fn radius(&self) -> Option<f64> {
        self.circle
            .map(|circle| distance(circle.center, self.start))
    }

    /// Direction of travel at a place of the piece.
    pub(crate) fn heading(&self, at: Point) -> Point {
        match self.circle {
            None => direction(self.start, self.end),
            Some(Circle { center, ccw }) => {
                let left = left_of(direction(center, at));
                if ccw { left } else { [-left[0], -left[1]] }
            }
        }
    }

    /// Angle from the arc's start to a place, in its direction: 0 up to a full turn.
    pub(crate) fn turned(&self, at: Point) -> f64 {
        let Some(Circle { center, ccw }) = self.circle else {
            return 0.0;
        };
        let (a, b) = (minus(self.start, center), minus(at, center));
        let angle = math::atan2(cross(a, b), dot(a, b));
        let angle = if ccw { angle } else { -angle };
        if angle < 0.0 { angle + TAU } else { angle }
    }

    /// Angle of the whole arc, above 0 and up to a full turn.
    pub(crate) fn sweep(&self) -> f64 {
        let sweep = self.turned(self.end);
        if self.circle.is_some() && sweep == 0.0 {
            TAU
        } else {
            sweep
        }
    }

    /// The place after an angle of the arc, on the circle of its start.
    fn at_angle(&self, turned: f64) -> Point {
        let Some(Circle { center, ccw }) = self.circle else {
            return self.start;
        };
        let (sin, cos) = math::sin_cos(if ccw { turned } else { -turned });
        let out = minus(self.start, center);
        [
            center[0] + out[0] * cos - out[1] * sin,
            center[1] + out[0] * sin + out[1] * cos,
        ]
    }

    /// The place at a share of the piece from 0 to 1.
    pub(crate) fn at(&self, share: f64) -> Point {
        match self.circle {
            None => along(self.start, minus(self.end, self.start), share),
            Some(_) => self.at_angle(share * self.sweep()),
        }
    }

    /// Smallest and largest coordinate along the travel (0) or of the level (1).
    pub(crate) fn reach(&self, axis: usize) -> [f64; 2] {
        let (mut low, mut high) = (
            self.start[axis].min(self.end[axis]),
            self.start[axis].max(self.end[axis]),
        );
        if let (Some(circle), Some(radius)) = (self.circle, self.radius()) {
            for side in [-radius, radius] {
                let mut extreme = circle.center;
                extreme[axis] += side;
                if self.turned(extreme) < self.sweep() {
                    low = low.min(extreme[axis]);
                    high = high.max(extreme[axis]);
                }
            }
        }
        [low, high]
    }

    /// The stretches that rise or fall. An arc that begins at its highest or lowest place begins
    /// with one of no length.
    pub(crate) fn stretches(&self) -> ([Stretch; 3], usize) {
        let mut found = [Stretch {
            from: self.start,
            to: self.end,
            rises: self.end[1] >= self.start[1],
        }; 3];
        let (Some(circle), Some(radius)) = (self.circle, self.radius()) else {
            return (found, 1);
        };
        let sweep = self.sweep();
        let mut turns: [(f64, Point, bool); 2] = [radius, -radius].map(|side| {
            let place = [circle.center[0], circle.center[1] + side];
            let angle = self.turned(place);
            // Rounding may put the start just behind the extreme.
            (
                if TAU - angle < 1e-9 { 0.0 } else { angle },
                place,
                side > 0.0,
            )
        });
        if turns[1].0 < turns[0].0 {
            turns.swap(0, 1);
        }
        let mut count = 1;
        for (angle, place, highest) in turns {
            if angle < sweep - 1e-9 {
                (found[count - 1].to, found[count - 1].rises) = (place, highest);
                found[count] = Stretch {
                    from: place,
                    to: self.end,
                    rises: !highest,
                };
                count += 1;
            }
        }
        (found, count)
    }

    /// The place at a level on one of its stretches.
    pub(crate) fn at_level(&self, stretch: &Stretch, level: f64) -> Point {
        let (from, to) = (stretch.from, stretch.to);
        let (Some(circle), Some(radius)) = (self.circle, self.radius()) else {
            let rise = to[1] - from[1];
            let share = if rise == 0.0 {
                0.0
            } else {
                ((level - from[1]) / rise).clamp(0.0, 1.0)
            };
            return [from[0] + share * (to[0] - from[0]), level];
        };
        let height = level - circle.center[1];
        let half = (radius * radius - height * height).max(0.0).sqrt();
        let middle = 0.5 * (from[0] + to[0]);
        [
            if middle < circle.center[0] {
                circle.center[0] - half
            } else {
                circle.center[0] + half
            },
            level,
        ]
    }

    /// The piece `by` to the left of its direction; none if an arc has no radius left.
    pub(crate) fn offset(&self, by: f64) -> Option<Piece> {
        let Some(Circle { center, ccw }) = self.circle else {
            let left = left_of(direction(self.start, self.end));
            return Some(Piece::line(
                along(self.start, left, by),
                along(self.end, left, by),
            ));
        };
        let inwards = if ccw { by } else { -by };
        let moved = |place: Point| {
            let radius = distance(center, place) - inwards;
            (radius > 1e-9 * (1.0 + by.abs()))
                .then(|| along(center, direction(center, place), radius))
        };
        Some(Piece::arc(
            moved(self.start)?,
            moved(self.end)?,
            center,
            ccw,
        ))
    }

    /// How far a place is from the piece.
    pub(crate) fn away(&self, place: Point) -> f64 {
        let ends = distance(place, self.start).min(distance(place, self.end));
        match self.circle {
            None => {
                let way = minus(self.end, self.start);
                let length = dot(way, way);
                let share = if length > 0.0 {
                    dot(minus(place, self.start), way) / length
                } else {
                    0.0
                };
                distance(place, along(self.start, way, share.clamp(0.0, 1.0)))
            }
            Some(circle) if self.turned(place) <= self.sweep() => {
                // The ends of an arc may have slightly different radii.
                let share = self.turned(place) / self.sweep();
                let ends_radius = [
                    distance(circle.center, self.start),
                    distance(circle.center, self.end),
                ];
                let radius = ends_radius[0] + share * (ends_radius[1] - ends_radius[0]);
                (distance(circle.center, place) - radius).abs().min(ends)
            }
            Some(_) => ends,
        }
    }

    /// Whether the piece never goes back along the travel by more than a tolerance.
    pub(crate) fn advances(&self, tolerance: f64) -> bool {
        let [low, high] = self.reach(0);
        low >= self.start[0] - tolerance
            && high <= self.end[0] + tolerance
            && (self.circle.is_none() || self.sweep() <= PI + 1e-3 || high - low <= tolerance)
    }
}
