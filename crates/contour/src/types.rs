//! Input, output and errors of the tracker.

use lostmotion_base::{BlockRef, Tick};
use lostmotion_path::{Curve, Plane};
use serde::{Deserialize, Serialize};

/// One programmed move, as it was programmed: no blending.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ProgrammedSegment {
    /// Running number; grows from one to the next.
    pub index: u64,
    /// Programmed curve of the tool tip in the part's frame, mm and rad.
    pub curve: Curve,
    /// Plane in force: in it, an error has a side.
    pub plane: Plane,
    /// Whether it is a G0 move.
    pub rapid: bool,
    /// Where the program's zero lies in the curve's frame, mm: what people read places from.
    pub origin_mm: [f64; 3],
    /// Block that commanded it.
    pub block: BlockRef,
}

/// How far around the command the foot point is searched, and from where on a joint is a corner.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct ContourConfig {
    /// Least path to either side of the command and of the last foot point, mm.
    pub min_window_mm: f64,
    /// The same as a multiple of the distance between actual and commanded tip. 1 suffices where
    /// every sample is measured, as the search then follows the foot point; callers that measure
    /// now and then need more, about 4.
    pub window_factor: f64,
    /// Most path to either side of the command, mm; the same length of past path is held.
    pub max_window_mm: f64,
    /// Most segments of the past that are held, should `max_window_mm` be made of very short ones.
    pub max_segments: usize,
    /// Accuracy of the distance where it has no closed form, mm.
    pub tolerance_mm: f64,
    /// Change of direction at a joint from which it is a corner, rad.
    pub corner_angle_rad: f64,
    /// Change of curvature at a joint from which it counts as a corner, 1/mm.
    pub corner_curvature_per_mm: f64,
    /// Path to either side of a corner that counts as near it, mm.
    pub corner_window_mm: f64,
}

impl Default for ContourConfig {
    fn default() -> ContourConfig {
        ContourConfig {
            min_window_mm: 1.0,
            window_factor: 1.0,
            max_window_mm: 50.0,
            max_segments: 8192,
            tolerance_mm: 1e-7,
            corner_angle_rad: 0.1,
            corner_curvature_per_mm: 0.01,
            corner_window_mm: 2.0,
        }
    }
}

/// Where one machine's tool is at one tick.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContourInput {
    /// Tick of the caller's clock.
    pub tick: Tick,
    /// Running number of the programmed segment on which the command lies.
    pub segment: u64,
    /// Parameter of the command on that segment's programmed curve.
    pub s: f64,
    /// Actual tool tip, part frame, mm.
    pub actual_tip_mm: [f64; 3],
    /// Commanded tool tip, part frame, mm.
    pub commanded_tip_mm: [f64; 3],
    /// Actual direction of the tool, part frame; need not be of unit length.
    pub actual_axis: [f64; 3],
    /// Commanded direction of the tool, part frame; need not be of unit length.
    pub commanded_axis: [f64; 3],
}

/// The contour error at one tick.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ContourSample {
    /// Tick of the input.
    pub tick: Tick,
    /// The distance with the sign of its side: positive to the left of the direction of travel, mm.
    pub error_mm: f64,
    /// Distance from the actual tip to the foot point, mm.
    pub distance_mm: f64,
    /// Actual tip, part frame, mm.
    pub tip_mm: [f64; 3],
    /// From the foot point to the actual tip, mm: a vector of the length `distance_mm`.
    pub off_mm: [f64; 3],
    /// Unit vector of travel at the foot point. At a corner the one between the directions before
    /// and after it that `off_mm` is at right angles to. Zero where the tip does not move.
    pub travel: [f64; 3],
    /// Segment of the foot point.
    pub segment: u64,
    /// Parameter of the foot point on it.
    pub s: f64,
    /// Whether that segment is a G0 move.
    pub rapid: bool,
    /// Block of that segment.
    pub block: BlockRef,
    /// Whether a corner or a step of curvature is near the foot point.
    pub near_corner: bool,
    /// Angle between actual and commanded direction of the tool, rad.
    pub orientation_error_rad: f64,
}

/// An input that is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ContourError {
    /// Segments pushed out of order.
    #[error("segment {pushed} was pushed after segment {last}; running numbers have to grow")]
    Order {
        /// The one pushed.
        pushed: u64,
        /// The one before.
        last: u64,
    },
    /// A sample whose commanded segment is not held: not pushed yet, or released.
    #[error(
        "the command at tick {tick} is on segment {segment}, which is not held ({held}); push segments before their samples"
    )]
    UnknownSegment {
        /// When.
        tick: Tick,
        /// The segment that the sample names.
        segment: u64,
        /// What is held.
        held: String,
    },
    /// A sample with a coordinate that is not a finite number.
    #[error("{what} at tick {tick} is not finite: {values:?}")]
    NotFinite {
        /// When.
        tick: Tick,
        /// Which vector.
        what: &'static str,
        /// Its values.
        values: [f64; 3],
    },
    /// A circle without a radius, or too few samples on one.
    #[error("a circular test needs {what}")]
    Circle {
        /// What is missing, with values.
        what: String,
    },
}
