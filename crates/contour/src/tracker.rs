//! The foot point on the path near the command.

use crate::side::{Tangents, frame, side};
use crate::{ContourConfig, ContourError, ContourInput, ContourSample, ProgrammedSegment};
use lostmotion_base::math;
use lostmotion_base::vec::{angle, norm, sub};
use lostmotion_path::Curve;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// Distances that differ by less are equal, mm: of two feet the one nearer to the command along the
/// path is then taken. A choice: a picometre, above the rounding of coordinates of some metres.
const SAME_DISTANCE_MM: f64 = 1e-9;

/// A foot counts as lying on a joint within this of a segment's end, in mm and in parts of its
/// length. A choice: above the rounding of s.
const JOINT_SLACK: f64 = 1e-9;

/// A programmed segment with its place along the path.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Held {
    segment: ProgrammedSegment,
    /// Path of the tip from the start of the program to the start of this segment, mm.
    start_mm: f64,
    /// Path of the tip on it, mm: 0 where only rotary axes move.
    length_mm: f64,
    /// Whether its start is a corner.
    corner: bool,
}

impl Held {
    fn end_mm(&self) -> f64 {
        self.start_mm + self.length_mm
    }

    /// Whether a curve that runs at unit speed is too short to come as near to the point as that.
    fn beyond(&self, point: [f64; 3], distance: f64) -> bool {
        // At unit speed no point of a curve is farther from its start than its length.
        let unit_speed = !matches!(self.segment.curve, Curve::Quintic(_));
        unit_speed
            && norm(sub(self.segment.curve.start().linear(), point)) - self.length_mm > distance
    }

    fn place(&self, s: f64) -> f64 {
        if self.length_mm > 0.0 {
            self.start_mm + s
        } else {
            self.start_mm
        }
    }
}

/// Where one machine's last foot point was; one for each machine that is measured against the same
/// tracker.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FootState {
    place_mm: Option<f64>,
}

/// The stretch of programmed path around the command.
///
/// The foot point of an actual position is the nearest point of the path between the last foot
/// point and the command, and a window beyond either:
/// `max(min_window_mm, window_factor |actual - commanded|)`. So neither a crossing of the path with
/// itself can attract it, nor does a machine that lags behind around a sharp corner lose it.
///
/// An error's side is told in the plane of the segment on which the foot lies. Where the foot is a
/// joint of two segments, as on the outside of a corner, travel is taken along the corner's
/// bisector, which puts the whole outside on one side. Where there is no side (overshoot beyond the
/// end of the program, an error along the normal) the error is positive.
///
/// ```
/// use lostmotion_base::{BlockRef, Coords, Plane};
/// use lostmotion_contour::{
///     ContourConfig, ContourInput, ContourTracker, FootState, ProgrammedSegment,
/// };
/// use lostmotion_path::Curve;
///
/// let mut tracker = ContourTracker::new(ContourConfig::default());
/// tracker.push(ProgrammedSegment {
///     index: 0,
///     curve: Curve::line(Coords::ZERO, Coords::xyz(50.0, 0.0, 0.0)),
///     plane: Plane::Xy,
///     rapid: false,
///     origin_mm: [0.0; 3],
///     block: BlockRef::default(),
/// })?;
/// // The command is at X20; the tool lags by 0.1 mm and is 4 um to the right of the line.
/// let sample = tracker.measure(
///     &mut FootState::default(),
///     &ContourInput {
///         tick: 0,
///         segment: 0,
///         s: 20.0,
///         actual_tip_mm: [19.9, -0.004, 0.0],
///         commanded_tip_mm: [20.0, 0.0, 0.0],
///         actual_axis: [0.0, 0.0, 1.0],
///         commanded_axis: [0.0, 0.0, 1.0],
///     },
/// )?;
/// assert!((sample.error_mm + 0.004).abs() < 1e-12 && (sample.s - 19.9).abs() < 1e-12);
/// # Ok::<(), lostmotion_contour::ContourError>(())
/// ```
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ContourTracker {
    config: ContourConfig,
    held: VecDeque<Held>,
}

/// A foot point in space.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FootPlace {
    /// The foot point from the program's zero, mm.
    pub foot_mm: [f64; 3],
    /// Unit vector to the left of the direction of travel, in the plane in force; zero where travel
    /// is along its normal.
    pub left: [f64; 3],
}

/// The best foot so far.
struct Found {
    at: usize,
    s: f64,
    distance: f64,
    /// Path between it and the command, then segments between.
    away: (f64, u64),
}

impl ContourTracker {
    /// A tracker that holds no path yet.
    pub fn new(config: ContourConfig) -> ContourTracker {
        ContourTracker {
            config,
            held: VecDeque::new(),
        }
    }

    /// Adds the next programmed segment. Push at least a window ahead of the command, as far as
    /// the program goes.
    ///
    /// # Errors
    /// A running number that does not grow.
    pub fn push(&mut self, segment: ProgrammedSegment) -> Result<(), ContourError> {
        let last = self.held.back();
        if let Some(last) = last.filter(|last| last.segment.index >= segment.index) {
            return Err(ContourError::Order {
                pushed: segment.index,
                last: last.segment.index,
            });
        }
        let start_mm = last.map_or(0.0, Held::end_mm);
        // A move of rotary axes alone has one place on the path of the tip.
        let length_mm = if segment.curve.moves_tip() {
            segment.curve.length()
        } else {
            0.0
        };
        let corner = length_mm > 0.0 && self.breaks(&segment);
        self.held.push_back(Held {
            segment,
            start_mm,
            length_mm,
            corner,
        });
        Ok(())
    }

    /// Whether direction or curvature change where the segment is joined on.
    fn breaks(&self, segment: &ProgrammedSegment) -> bool {
        let Some(last) = self.held.iter().rev().find(|held| held.length_mm > 0.0) else {
            return false;
        };
        // Tangent and curvature vector on both sides of the joint.
        let (tangent, bend) = frame(&last.segment.curve, last.segment.curve.length());
        let (next_tangent, next_bend) = frame(&segment.curve, 0.0);
        angle(tangent, next_tangent) >= self.config.corner_angle_rad
            || norm(sub(next_bend, bend)) >= self.config.corner_curvature_per_mm
    }

    /// Drops the segments that the command, now at `s` of `segment`, has left far behind. Returns
    /// the oldest segment still held; no later sample has its foot on one before it.
    pub fn release(&mut self, segment: u64, s: f64) -> Option<u64> {
        let at = self.position(segment)?;
        // No window reaches further back than this.
        let horizon = self.held.get(at)?.place(s) - self.config.max_window_mm;
        // Whole segments behind the horizon are dropped, and the oldest where there are too many.
        let mut behind = at;
        while behind > 0
            && self
                .held
                .front()
                .is_some_and(|held| held.end_mm() < horizon || behind > self.config.max_segments)
        {
            self.held.pop_front();
            behind -= 1;
        }
        self.held.front().map(|held| held.segment.index)
    }

    /// How many segments are held.
    pub fn held(&self) -> usize {
        self.held.len()
    }

    /// The running number of the last segment pushed.
    pub fn newest(&self) -> Option<u64> {
        self.held.back().map(|held| held.segment.index)
    }

    fn position(&self, segment: u64) -> Option<usize> {
        let of = |held: &Held| held.segment.index;
        // Running numbers grow and mostly by one, but need not.
        let guess = usize::try_from(segment.checked_sub(self.held.front().map(of)?)?).ok()?;
        if self.held.get(guess).map(of) == Some(segment) {
            return Some(guess);
        }
        self.held.binary_search_by_key(&segment, of).ok()
    }

    /// The first segment at or before this one from which on all keep a condition, which has to hold
    /// from somewhere on. Asked of a few neighbours: segments far away are not in the cache.
    fn back_while(&self, at: usize, keeps: impl Fn(&Held) -> bool) -> usize {
        let mut before = self.held.range(..at).rev();
        at - before.position(|held| !keeps(held)).unwrap_or(at)
    }

    /// The contour error of one machine at one tick.
    ///
    /// # Errors
    /// A command on a segment that is not held; coordinates that are not finite.
    pub fn measure(
        &self,
        foot: &mut FootState,
        input: &ContourInput,
    ) -> Result<ContourSample, ContourError> {
        check(input)?;
        let at = self.position(input.segment);
        let Some((at, held)) = at.and_then(|at| Some((at, self.held.get(at)?))) else {
            return Err(self.unknown(input));
        };
        // Nothing fails from here on: the last foot changes only together with a sample.
        let command = held.place(input.s);
        let found = self.search(foot, input, at, command);
        let held = self.held.get(found.at).unwrap_or(held);
        let place = held.place(found.s);
        foot.place_mm = Some(place);
        let off = sub(
            input.actual_tip_mm,
            held.segment.curve.point(found.s).linear(),
        );
        // The distance gets the sign of the side on which the tool lies.
        let tangents = self.tangents(found.at, found.s);
        let sign = side(off, tangents.mean(), held.segment.plane);
        Ok(ContourSample {
            tick: input.tick,
            error_mm: sign * found.distance,
            distance_mm: found.distance,
            tip_mm: input.actual_tip_mm,
            off_mm: off,
            travel: tangents.across(off),
            segment: held.segment.index,
            s: found.s,
            rapid: held.segment.rapid,
            block: held.segment.block,
            near_corner: self.near_corner(found.at, place),
            orientation_error_rad: angle(input.actual_axis, input.commanded_axis),
        })
    }

    fn unknown(&self, input: &ContourInput) -> ContourError {
        let held = match (self.held.front(), self.held.back()) {
            (Some(first), Some(last)) => {
                format!("held are {} to {}", first.segment.index, last.segment.index)
            }
            _ => "none is held".to_owned(),
        };
        ContourError::UnknownSegment {
            tick: input.tick,
            segment: input.segment,
            held,
        }
    }

    /// The nearest point of the window.
    fn search(&self, foot: &FootState, input: &ContourInput, at: usize, command: f64) -> Found {
        let config = &self.config;
        // The window: from the last foot to the command, and a margin beyond either that grows with
        // the lag.
        let apart = norm(sub(input.actual_tip_mm, input.commanded_tip_mm));
        let margin = (config.window_factor * apart)
            .max(config.min_window_mm)
            .min(config.max_window_mm);
        let last = foot.place_mm.unwrap_or(command);
        let low = (last.min(command) - margin).max(command - config.max_window_mm);
        let high = (last.max(command) + margin).min(command + config.max_window_mm);

        let mut best = Found {
            at,
            s: input.s,
            distance: f64::INFINITY,
            away: (f64::INFINITY, u64::MAX),
        };
        // The last foot's segment first: with its distance known, most others need no look.
        let likely = self.back_while(at, |held| held.end_mm() >= last.max(low));
        let first = self.back_while(likely, |held| held.end_mm() >= low);
        for index in std::iter::once(likely).chain(first..self.held.len()) {
            let Some(held) = self.held.get(index) else {
                break;
            };
            // Segments are in order of their places: none further on is in the window.
            if held.start_mm > high && index > at {
                break;
            }
            if held.beyond(input.actual_tip_mm, best.distance + SAME_DISTANCE_MM) {
                continue;
            }
            // The part of the window on this segment; nearest holds it within the curve.
            let range = if held.length_mm > 0.0 {
                (low - held.start_mm, high - held.start_mm)
            } else if index == at {
                (input.s, input.s)
            } else {
                (0.0, 0.0)
            };
            let near = held
                .segment
                .curve
                .nearest(input.actual_tip_mm, range, config.tolerance_mm);
            let away = (
                (held.place(near.s) - command).abs(),
                held.segment.index.abs_diff(input.segment),
            );
            // Of equal distances the foot nearer to the command along the path, then by segments.
            let nearer = near.distance < best.distance - SAME_DISTANCE_MM;
            if nearer || (near.distance <= best.distance + SAME_DISTANCE_MM && away < best.away) {
                best = Found {
                    at: index,
                    s: near.s,
                    distance: near.distance,
                    away,
                };
            }
        }
        best
    }

    /// Directions of travel at a foot point.
    fn tangents(&self, at: usize, s: f64) -> Tangents {
        let Some(held) = self.held.get(at) else {
            return Tangents::default();
        };
        let length = held.length_mm;
        let still = length <= 0.0;
        // At a joint of two segments, those of both; moves of rotary axes alone lie between.
        let slack = JOINT_SLACK * (1.0 + length);
        let (at_start, at_end) = (still || s <= slack, still || s >= length - slack);
        let before = || {
            self.held
                .iter()
                .take(at)
                .rev()
                .find(|held| held.length_mm > 0.0)
        };
        let after = || {
            self.held
                .iter()
                .skip(at + 1)
                .find(|held| held.length_mm > 0.0)
        };
        Tangents {
            own: held.segment.curve.tangent(s),
            before: at_start
                .then(before)
                .flatten()
                .map(|held| held.segment.curve.tangent(held.length_mm)),
            after: at_end
                .then(after)
                .flatten()
                .map(|held| held.segment.curve.tangent(0.0)),
        }
    }

    /// A segment that is held.
    pub fn segment(&self, index: u64) -> Option<&ProgrammedSegment> {
        Some(&self.held.get(self.position(index)?)?.segment)
    }

    /// Where a sample's foot point lies and which way is left there; `None` if its segment is held
    /// no longer.
    pub fn place(&self, sample: &ContourSample) -> Option<FootPlace> {
        let at = self.position(sample.segment)?;
        let segment = &self.held.get(at)?.segment;
        // Left is a quarter turn counter-clockwise from the shadow of travel on the plane.
        let [first, second, _] = segment.plane.axes();
        let travel = self.tangents(at, sample.s).mean();
        let shadow = math::hypot(travel[first], travel[second]);
        let mut left = [0.0; 3];
        if shadow > 0.0 {
            (left[first], left[second]) = (-travel[second] / shadow, travel[first] / shadow);
        }
        Some(FootPlace {
            foot_mm: sub(segment.curve.point(sample.s).linear(), segment.origin_mm),
            left,
        })
    }

    /// Whether a corner is in the window around a place on a segment.
    fn near_corner(&self, at: usize, place: f64) -> bool {
        let window = self.config.corner_window_mm;
        // Corners are starts of segments, which are in order.
        self.held
            .range(..=at)
            .rev()
            .take_while(|held| held.start_mm >= place - window)
            .any(|held| held.corner)
            || self
                .held
                .range(at + 1..)
                .skip_while(|held| held.start_mm < place - window)
                .take_while(|held| held.start_mm <= place + window)
                .any(|held| held.corner)
    }
}

fn check(input: &ContourInput) -> Result<(), ContourError> {
    let vectors = [
        ("the actual tip", input.actual_tip_mm),
        ("the commanded tip", input.commanded_tip_mm),
        ("the actual tool direction", input.actual_axis),
        ("the commanded tool direction", input.commanded_axis),
    ];
    match vectors
        .into_iter()
        .find(|(_, values)| values.iter().any(|c| !c.is_finite()))
    {
        Some((what, values)) => Err(ContourError::NotFinite {
            tick: input.tick,
            what,
            values,
        }),
        None => Ok(()),
    }
}
