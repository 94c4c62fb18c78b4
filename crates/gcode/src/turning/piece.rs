//! Pieces of a profile in the frame of a turning cycle (along the direction of travel, and the level
//! above it), and where their lines and circles cross.

use lostmotion_base::math;
use lostmotion_base::vec::{Vec2, along, cross2, direction2, distance2, dot, left_of, sub};
use std::f64::consts::{PI, TAU};

/// The circle of an arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct PieceCircle {
    pub(crate) center: Vec2,
    /// Counter-clockwise, travel to the right and level up.
    pub(crate) ccw: bool,
}

/// A line, or an arc with its circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Piece {
    pub(crate) start: Vec2,
    pub(crate) end: Vec2,
    pub(crate) circle: Option<PieceCircle>,
}

/// A stretch of a piece that only rises or only falls.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct MonotonePart {
    pub(crate) from: Vec2,
    pub(crate) to: Vec2,
    /// It does not fall. Where an arc begins at its highest place this is true of a first stretch
    /// of no length.
    pub(crate) rises: bool,
}

/// Direction from one place to another; zero if they are the same.
pub(crate) fn direction(from: Vec2, to: Vec2) -> Vec2 {
    direction2(from, to).unwrap_or_default()
}

impl Piece {
    pub(crate) const fn line(start: Vec2, end: Vec2) -> Piece {
        Piece {
            start,
            end,
            circle: None,
        }
    }

    pub(crate) const fn arc(start: Vec2, end: Vec2, center: Vec2, ccw: bool) -> Piece {
        Piece {
            start,
            end,
            circle: Some(PieceCircle { center, ccw }),
        }
    }

    /// The piece upside down.
    pub(crate) fn mirrored(&self) -> Piece {
        let flip = |place: Vec2| [place[0], -place[1]];
        let circle = self.circle.map(|circle| PieceCircle {
            center: flip(circle.center),
            ccw: !circle.ccw,
        });
        Piece {
            start: flip(self.start),
            end: flip(self.end),
            circle,
        }
    }

    /// Radius at the start; `None` for a line.
    pub(crate) fn radius(&self) -> Option<f64> {
        self.circle
            .map(|circle| distance2(circle.center, self.start))
    }

    /// Direction of travel at a place of the piece.
    pub(crate) fn heading(&self, at: Vec2) -> Vec2 {
        match self.circle {
            None => direction(self.start, self.end),
            Some(PieceCircle { center, ccw }) => {
                let left = left_of(direction(center, at));
                if ccw { left } else { [-left[0], -left[1]] }
            }
        }
    }

    /// Angle from the arc's start to a place, in its direction: 0 up to a full turn.
    pub(crate) fn turned(&self, at: Vec2) -> f64 {
        let Some(PieceCircle { center, ccw }) = self.circle else {
            return 0.0;
        };
        // Angle between the radius vectors, in the arc's own direction.
        let (a, b) = (sub(self.start, center), sub(at, center));
        let angle = math::atan2(cross2(a, b), dot(a, b));
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
    fn at_angle(&self, turned: f64) -> Vec2 {
        let Some(PieceCircle { center, ccw }) = self.circle else {
            return self.start;
        };
        let (sin, cos) = math::sin_cos(if ccw { turned } else { -turned });
        let out = sub(self.start, center);
        [
            center[0] + out[0] * cos - out[1] * sin,
            center[1] + out[0] * sin + out[1] * cos,
        ]
    }

    /// The place at a share of the piece from 0 to 1.
    pub(crate) fn at(&self, share: f64) -> Vec2 {
        match self.circle {
            None => along(self.start, sub(self.end, self.start), share),
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
            // An arc reaches beyond its ends where it passes an extreme of its circle.
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
    pub(crate) fn stretches(&self) -> ([MonotonePart; 3], usize) {
        let mut found = [MonotonePart {
            from: self.start,
            to: self.end,
            rises: self.end[1] >= self.start[1],
        }; 3];
        let (Some(circle), Some(radius)) = (self.circle, self.radius()) else {
            return (found, 1);
        };
        let sweep = self.sweep();
        // An arc changes between rising and falling at the top and the bottom of its circle.
        let mut turns: [(f64, Vec2, bool); 2] = [radius, -radius].map(|side| {
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
        // Extremes beyond the arc's end do not divide it.
        for (angle, place, highest) in turns {
            if angle < sweep - 1e-9 {
                (found[count - 1].to, found[count - 1].rises) = (place, highest);
                found[count] = MonotonePart {
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
    pub(crate) fn at_level(&self, stretch: &MonotonePart, level: f64) -> Vec2 {
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
        // Half the chord at this height, on the stretch's own side of the centre.
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

    /// The piece `by` to the left of its direction; `None` if an arc has no radius left.
    pub(crate) fn offset(&self, by: f64) -> Option<Piece> {
        let Some(PieceCircle { center, ccw }) = self.circle else {
            let left = left_of(direction(self.start, self.end));
            return Some(Piece::line(
                along(self.start, left, by),
                along(self.end, left, by),
            ));
        };
        // Left of a counter-clockwise arc is inside it.
        let inwards = if ccw { by } else { -by };
        let moved = |place: Vec2| {
            let radius = distance2(center, place) - inwards;
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
    pub(crate) fn away(&self, place: Vec2) -> f64 {
        let ends = distance2(place, self.start).min(distance2(place, self.end));
        match self.circle {
            None => {
                let way = sub(self.end, self.start);
                let length = dot(way, way);
                // Nearest place of the segment: the projection, clamped to its ends.
                let share = if length > 0.0 {
                    dot(sub(place, self.start), way) / length
                } else {
                    0.0
                };
                distance2(place, along(self.start, way, share.clamp(0.0, 1.0)))
            }
            Some(circle) if self.turned(place) <= self.sweep() => {
                // The ends of an arc may have slightly different radii.
                let share = self.turned(place) / self.sweep();
                let ends_radius = [
                    distance2(circle.center, self.start),
                    distance2(circle.center, self.end),
                ];
                let radius = ends_radius[0] + share * (ends_radius[1] - ends_radius[0]);
                (distance2(circle.center, place) - radius).abs().min(ends)
            }
            Some(_) => ends,
        }
    }

    /// Whether the piece never goes back along the travel by more than a tolerance.
    pub(crate) fn advances(&self, tolerance: f64) -> bool {
        let [low, high] = self.reach(0);
        // An arc of more than half a circle goes back even where its ends do not.
        low >= self.start[0] - tolerance
            && high <= self.end[0] + tolerance
            && (self.circle.is_none() || self.sweep() <= PI + 1e-3 || high - low <= tolerance)
    }
}

/// How Z and X lie along the travel and as level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Frame {
    /// Z is the direction of travel (G71); otherwise X is (G72).
    pub(crate) along_z: bool,
    /// Signs of travel and level.
    pub(crate) signs: [f64; 2],
}

impl Frame {
    /// A place given as Z and X.
    pub(crate) fn to(&self, zx: Vec2) -> Vec2 {
        let [first, second] = if self.along_z { zx } else { [zx[1], zx[0]] };
        [self.signs[0] * first, self.signs[1] * second]
    }

    /// A place as Z and X.
    pub(crate) fn from(&self, place: Vec2) -> Vec2 {
        let turned = [self.signs[0] * place[0], self.signs[1] * place[1]];
        if self.along_z {
            turned
        } else {
            [turned[1], turned[0]]
        }
    }

    /// Whether it sees arcs the other way round.
    pub(crate) fn mirrors(&self) -> bool {
        (self.signs[0] * self.signs[1] > 0.0) != self.along_z
    }

    /// A piece given as Z and X.
    pub(crate) fn piece(&self, piece: &Piece) -> Piece {
        let circle = piece.circle.map(|circle| super::piece::PieceCircle {
            center: self.to(circle.center),
            ccw: circle.ccw != self.mirrors(),
        });
        Piece {
            start: self.to(piece.start),
            end: self.to(piece.end),
            circle,
        }
    }

    /// The frame in which a profile goes forwards and up. Recorded: one that comes inwards is an
    /// inside one, wherever the tool is, and one that ends level with its start goes towards the
    /// smaller values.
    pub(crate) fn of(along_z: bool, [first, last]: [Vec2; 2]) -> Frame {
        let axis = usize::from(!along_z);
        let level = 1 - axis;
        let sign = |negative: bool| if negative { -1.0 } else { 1.0 };
        Frame {
            along_z,
            signs: [
                sign(last[axis] <= first[axis]),
                sign(last[level] < first[level]),
            ],
        }
    }
}

/// Where two pieces cross, prolonged without end: both places where circles are concerned. Circles
/// and lines that miss each other by no more than `forgiven` are taken to touch.
pub(crate) fn crossings(a: &Piece, b: &Piece, forgiven: f64) -> Option<[Vec2; 2]> {
    between((a, a.radius()), (b, b.radius()), forgiven)
}

/// The same for pieces of which the second follows the first. Where the ends of an arc have
/// slightly different radii, the one that counts is that of the end which stays where it is (as
/// recorded).
pub(crate) fn joints(a: &Piece, b: &Piece, forgiven: f64) -> Option<[Vec2; 2]> {
    between(
        (a, a.radius()),
        (b, b.circle.map(|circle| distance2(circle.center, b.end))),
        forgiven,
    )
}

fn between(
    (a, a_radius): (&Piece, Option<f64>),
    (b, b_radius): (&Piece, Option<f64>),
    forgiven: f64,
) -> Option<[Vec2; 2]> {
    match (a.circle, b.circle) {
        (None, None) => {
            let (u, v) = (direction(a.start, a.end), direction(b.start, b.end));
            // Parallel lines do not cross.
            let slope = cross2(u, v);
            if slope.abs() < 1e-12 {
                return None;
            }
            Some([along(a.start, u, cross2(sub(b.start, a.start), v) / slope); 2])
        }
        (None, Some(circle)) => line_circle(a, circle, b_radius?, forgiven),
        (Some(circle), None) => line_circle(b, circle, a_radius?, forgiven),
        (Some(c), Some(d)) => circles((c.center, a_radius?), (d.center, b_radius?), forgiven),
    }
}

fn line_circle(line: &Piece, circle: PieceCircle, radius: f64, forgiven: f64) -> Option<[Vec2; 2]> {
    let u = direction(line.start, line.end);
    // Foot point of the centre, then half the chord to either side.
    let foot = along(line.start, u, dot(sub(circle.center, line.start), u));
    let away = distance2(foot, circle.center);
    if away > radius + forgiven {
        return None;
    }
    let half = (radius * radius - away * away).max(0.0).sqrt();
    Some([along(foot, u, -half), along(foot, u, half)])
}

fn circles((c, r): (Vec2, f64), (d, s): (Vec2, f64), forgiven: f64) -> Option<[Vec2; 2]> {
    let gap = distance2(c, d);
    if gap < 1e-12 || gap > r + s + forgiven || gap < (r - s).abs() - forgiven {
        return None;
    }
    let u = direction(c, d);
    // The radical line, square to the line of centres; clamped for circles that just miss.
    let to_foot = ((gap * gap + r * r - s * s) / (2.0 * gap)).clamp(-r, r);
    let half = (r * r - to_foot * to_foot).max(0.0).sqrt();
    let foot = along(c, u, to_foot);
    Some([
        along(foot, left_of(u), half),
        along(foot, left_of(u), -half),
    ])
}
