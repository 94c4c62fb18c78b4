//! A ballbar's sheet: the radial deviation over the angle of a circle in one or both senses, with the
//! values of ISO 230-4, what each reversal leaves, and which errors of the axes explain it.

mod explain;
mod reversal;

use crate::circular::{Circle, RadialPoint};
use crate::types::ContourError;
use explain::{LOST, MISMATCH, SCALE, SQUARE, Told, UNKNOWNS, explain, levelled};
use lostmotion_base::AxisId;
use reversal::reversal;
use serde::{Deserialize, Serialize};
use std::f64::consts::{PI, TAU};

/// Most parts of a turn that deviations are averaged over: half a degree.
pub const PARTS: usize = 720;
/// Samples that a part of a turn has to have on the mean.
const PER_PART: usize = 2;
/// From how wide a gap between two samples on that part of the circle was not measured, deg.
const GAP_DEG: f64 = 3.0;
/// How much of the circle has to be measured for G and F to be those of a whole one, deg.
const WHOLE_DEG: f64 = 355.0;

/// A circle in one sense of rotation.
#[derive(Clone, Debug, PartialEq)]
pub struct BallbarTrace {
    /// From the plane's first axis to its second.
    pub counterclockwise: bool,
    /// Deviations in the order of time; angles may go on beyond a turn.
    pub points: Vec<RadialPoint>,
}

impl BallbarTrace {
    /// A trace whose sense is that of its angles. Of more than a turn the middle one is taken: the
    /// ends are where the machine starts and stops.
    pub fn new(mut points: Vec<RadialPoint>) -> BallbarTrace {
        // Angles of one turn after the other: steps of more than half a turn are wraps.
        let mut added = 0.0;
        for index in 1..points.len() {
            let step = points[index].angle_rad + added - points[index - 1].angle_rad;
            added -= TAU * (step / TAU).round();
            points[index].angle_rad += added;
        }
        let ends = (points.first(), points.last());
        let (from, to) = match ends {
            (Some(from), Some(to)) => (from.angle_rad, to.angle_rad),
            _ => (0.0, 0.0),
        };
        let middle = 0.5 * (from + to);
        if (to - from).abs() > TAU {
            points.retain(|point| (point.angle_rad - middle).abs() <= PI);
        }
        BallbarTrace {
            counterclockwise: to >= from,
            points,
        }
    }

    /// Angles, rad, and deviations, um.
    fn points_um(&self) -> Vec<(f64, f64)> {
        let points = self.points.iter();
        points
            .map(|point| (point.angle_rad, 1e3 * point.deviation_mm))
            .collect()
    }

    /// Mean deviation of each of `parts` parts of the turn, um; NaN where there is none.
    pub fn parts_um(&self, parts: usize) -> Vec<f64> {
        let mut sums = vec![(0.0, 0u32); parts];
        for point in &self.points {
            let part = (point.angle_rad / TAU).rem_euclid(1.0) * parts as f64;
            if let Some((sum, count)) = sums.get_mut(part as usize % parts.max(1)) {
                *sum += 1e3 * point.deviation_mm;
                *count += 1;
            }
        }
        sums.into_iter()
            .map(|(sum, count)| {
                if count > 0 {
                    sum / f64::from(count)
                } else {
                    f64::NAN
                }
            })
            .collect()
    }

    /// How much of the circle has samples, deg.
    fn covered_deg(&self) -> f64 {
        let mut angles: Vec<f64> = self
            .points
            .iter()
            .map(|point| (point.angle_rad / TAU).rem_euclid(1.0) * 360.0)
            .collect();
        angles.sort_unstable_by(f64::total_cmp);
        let around = angles.first().map(|first| first + 360.0);
        angles.extend(around);
        let gaps = angles.windows(2).map(|pair| pair[1] - pair[0]);
        360.0 - gaps.filter(|gap| *gap > GAP_DEG).sum::<f64>()
    }
}

/// Parts of a turn for which all traces have samples enough: half a degree, or more where samples are
/// few.
pub fn parts_for(traces: &[BallbarTrace]) -> usize {
    let fewest = traces.iter().map(|trace| trace.points.len()).min();
    (fewest.unwrap_or_default() / PER_PART).clamp(1, PARTS)
}

/// A value with its 95 % interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Explained {
    /// The value.
    pub value: f64,
    /// The ends of its interval.
    pub interval: [f64; 2],
}

impl From<Told> for Explained {
    fn from((value, interval): Told) -> Explained {
        Explained { value, interval }
    }
}

/// What one reversal of an axis leaves on the circle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ReversalMark {
    /// The axis that reverses.
    pub axis: AxisId,
    /// Where, deg: 0, 90, 180 or 270.
    pub angle_deg: f64,
    /// In which sense.
    pub counterclockwise: bool,
    /// Step of the level along the axis, um, positive outwards: lost motion there.
    pub step_um: f64,
    /// How far the path leaves the band between the levels of before and behind, um.
    pub spike_um: f64,
}

/// Values of ISO 230-4 of one sense.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SenseValues {
    /// From the plane's first axis to its second.
    pub counterclockwise: bool,
    /// Circular deviation G, um.
    pub g_um: f64,
    /// Smallest and largest radial deviation F about the nominal centre, um.
    pub f_um: [f64; 2],
    /// Mean radial deviation about the least-squares centre, um.
    pub mean_um: f64,
    /// Samples.
    pub samples: u64,
}

/// A ballbar's sheet.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct BallbarSheet {
    /// The two axes of the plane.
    pub axes: Vec<AxisId>,
    /// Nominal radius, mm.
    pub radius_mm: f64,
    /// Values of each sense.
    pub senses: Vec<SenseValues>,
    /// Circular hysteresis H: largest difference of the two senses, um; means over half a degree, or over two samples where they are farther apart.
    pub h_um: Option<f64>,
    /// Bi-directional circular deviation G(b), um.
    pub g_both_um: Option<f64>,
    /// Mean bi-directional radial deviation D, um.
    pub d_um: Option<f64>,
    /// Centre against the nominal one, um.
    pub center_um: Vec<Option<Explained>>,
    /// What each axis loses at a reversal, um.
    pub lost_motion_um: Vec<Option<Explained>>,
    /// How much longer the first axis moves than the second, um/m.
    pub scale_um_m: Option<Explained>,
    /// Turn of the second axis towards the first, um/m.
    pub squareness_um_m: Option<Explained>,
    /// How far the first axis is behind the second at this feed, um.
    pub mismatch_um: Option<Explained>,
    /// Reversals, in the order of senses and angles.
    pub reversals: Vec<ReversalMark>,
    /// What is left unexplained, um RMS, spikes aside.
    pub left_um: f64,
    /// What cannot be told, and why.
    pub untold: Vec<String>,
}

/// Judges one or two traces of a circle.
///
/// ```
/// use lostmotion_base::{Plane, math};
/// use lostmotion_contour::ballbar::{BallbarTrace, sheet};
/// use lostmotion_contour::{Circle, RadialPoint};
///
/// // Ten micrometres of lost motion of X, one sense.
/// let points = (0..3600).map(|tenth| {
///     let angle_rad = f64::from(tenth).to_radians() / 10.0;
///     let (sin, cos) = math::sin_cos(angle_rad);
///     RadialPoint { angle_rad, deviation_mm: 0.005 * sin.signum() * cos }
/// });
/// let circle = Circle { plane: Plane::Xy, center_mm: [0.0; 2], radius_mm: 150.0 };
/// let found = sheet(&circle, &[BallbarTrace::new(points.collect())])?;
/// let lost = found.lost_motion_um[0].ok_or("not told")?;
/// assert!((lost.value - 10.0).abs() < 0.01 && found.lost_motion_um[1].is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// No trace, a radius that is not positive, fewer than eight samples, or samples on too small a part
/// of the circle to tell its centre.
pub fn sheet(circle: &Circle, traces: &[BallbarTrace]) -> Result<BallbarSheet, ContourError> {
    let [first, second, _] = circle.plane.axes();
    let axes: Vec<AxisId> = [first, second]
        .into_iter()
        .filter_map(AxisId::from_index)
        .collect();
    let mut found = BallbarSheet {
        axes,
        radius_mm: circle.radius_mm,
        ..BallbarSheet::default()
    };
    if traces.is_empty() {
        return Err(ContourError::Circle {
            what: "at least one trace, not none".to_owned(),
        });
    }
    for trace in traces {
        let deviation = circle.deviation_of(&trace.points)?;
        found.senses.push(SenseValues {
            counterclockwise: trace.counterclockwise,
            g_um: 1e3 * deviation.circular_mm,
            f_um: [1e3 * deviation.radial_min_mm, 1e3 * deviation.radial_max_mm],
            mean_um: 1e3 * deviation.mean_mm,
            samples: trace.points.len() as u64,
        });
    }
    let pair = pair(traces);
    if let Some((one, other)) = pair {
        let parts = parts_for(traces);
        let [a, b] = [one, other].map(|index| traces[index].parts_um(parts));
        found.h_um = Some(hysteresis(&a, &b));
        let both: Vec<RadialPoint> = [one, other]
            .into_iter()
            .flat_map(|index| traces[index].points.iter().copied())
            .collect();
        let both = circle.deviation_of(&both)?;
        (found.g_both_um, found.d_um) = (Some(1e3 * both.circular_mm), Some(1e3 * both.mean_mm));
    }
    let values = explained(&mut found, traces, pair.is_some());
    for trace in traces {
        let counterclockwise = trace.counterclockwise;
        let points = trace.points_um();
        let level = levelled(
            (&points, counterclockwise),
            &values,
            1e-3 * circle.radius_mm,
        );
        for (quarter, axis) in (0..4).zip(found.axes.clone().into_iter().cycle()) {
            let angle_deg = 90.0 * f64::from(quarter);
            if let Some((step_um, spike_um)) = reversal(&level, angle_deg, counterclockwise) {
                found.reversals.push(ReversalMark {
                    axis,
                    angle_deg,
                    counterclockwise,
                    step_um,
                    spike_um,
                });
            }
        }
    }
    Ok(found)
}

/// Places of a trace of each sense.
fn pair(traces: &[BallbarTrace]) -> Option<(usize, usize)> {
    let of = |wanted: bool| {
        traces
            .iter()
            .position(|trace| trace.counterclockwise == wanted)
    };
    of(true).zip(of(false))
}

/// Circular hysteresis H: the largest difference of two deviations at one angle, in their unit.
fn hysteresis(one: &[f64], other: &[f64]) -> f64 {
    one.iter()
        .zip(other)
        .map(|(a, b)| (a - b).abs())
        .filter(|off| off.is_finite())
        .fold(0.0, f64::max)
}

/// Adds what explains the deviations, and what is not told; returns the former.
fn explained(
    found: &mut BallbarSheet,
    traces: &[BallbarTrace],
    both: bool,
) -> [Option<Told>; UNKNOWNS] {
    let points: Vec<(Vec<(f64, f64)>, bool)> = traces
        .iter()
        .map(|trace| (trace.points_um(), trace.counterclockwise))
        .collect();
    let senses: Vec<(&[(f64, f64)], bool)> = points
        .iter()
        .map(|(points, ccw)| (points.as_slice(), *ccw))
        .collect();
    // Radius in metres times micrometres: scale and squareness come out in um/m.
    let radius_m = 1e-3 * found.radius_mm;
    let (values, left_um) = explain(&senses, radius_m);
    let told = |place: usize| values[place].map(Explained::from);
    found.left_um = left_um;
    found.center_um = [1, 2].into_iter().map(told).collect();
    found.lost_motion_um = LOST.into_iter().map(told).collect();
    found.scale_um_m = told(SCALE);
    if both {
        found.squareness_um_m = told(SQUARE);
        found.mismatch_um = told(MISMATCH);
    } else {
        let together = told(SQUARE).map_or(String::new(), |both| {
            format!(
                "; the two together are {:.1} um/m (95 %: {:.1} to {:.1}) at this feed",
                both.value, both.interval[0], both.interval[1]
            )
        });
        found.untold.push(format!(
            "squareness and servo mismatch: one sense of rotation does not tell them apart{together}; measure the circle in the other sense, too"
        ));
    }
    let covered_deg = traces
        .iter()
        .map(BallbarTrace::covered_deg)
        .fold(360.0, f64::min);
    if covered_deg < WHOLE_DEG {
        found.untold.push(format!(
            "G, F and H of the whole circle: {covered_deg:.0} deg of it were measured"
        ));
        found
            .untold
            .push(mean_of_a_part(&values, both, covered_deg));
    }
    let names: Vec<String> = found.axes.iter().map(ToString::to_string).collect();
    for (axis, value) in names.iter().zip(&found.lost_motion_um) {
        if value.is_none() {
            found.untold.push(format!(
                "lost motion of {axis}: the axis does not move both ways on what was measured of the circle"
            ));
        }
    }
    if found.scale_um_m.is_none() || (both && found.squareness_um_m.is_none()) {
        found.untold.push(
            "scale or squareness: too small a part of the circle was measured to tell them from its centre"
                .to_owned(),
        );
    }
    values
}

/// What a part of a circle tells of the mean of all of it: radius, centre and the errors of the axes trade
/// places there, so that the mean of the part is none of the whole.
fn mean_of_a_part(values: &[Option<Told>; UNKNOWNS], both: bool, covered_deg: f64) -> String {
    let part = "the mean about the centre is that of the part that was measured";
    // What is not told of the others is in the mean.
    let others = (1..UNKNOWNS).filter(|place| both || *place != MISMATCH);
    let is_told = others.clone().all(|place| values[place].is_some());
    match values[0].filter(|_| is_told) {
        Some((mean, [low, high])) => format!(
            "the mean radial deviation of the whole circle: {part}, {covered_deg:.0} deg; by the errors of the axes that of the whole is {mean:.1} um (95 %: {low:.1} to {high:.1})"
        ),
        None => format!(
            "the mean radial deviation of the whole circle cannot be told, because the record covers only {covered_deg:.0} deg: {part}"
        ),
    }
}

/// Words of a sheet for a circle whose deviations are known by parts of the turn, um: what a page shows
/// of a circle of a program.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CircleWords {
    /// Largest spike of each axis, um.
    pub spike_um: [f64; 2],
    /// Largest step of each axis, um.
    pub step_um: [f64; 2],
    /// Squareness (um/m), servo mismatch (um) and scale (um/m), where both senses are there.
    pub both: Option<[f64; 3]>,
}

/// The words of a circle, and of the same one in the other sense.
pub fn words(
    radial_um: &[f64],
    counterclockwise: bool,
    other_um: Option<&[f64]>,
    radius_mm: f64,
) -> CircleWords {
    let mut words = CircleWords::default();
    let points = |parts: &[f64]| -> Vec<(f64, f64)> {
        let angle = |part: usize| (part as f64 + 0.5) / parts.len() as f64 * TAU;
        let all = parts.iter().enumerate();
        all.filter(|(_, um)| um.is_finite())
            .map(|(part, um)| (angle(part), *um))
            .collect()
    };
    let (own, other) = (points(radial_um), other_um.map(points));
    let mut senses = vec![(own.as_slice(), counterclockwise)];
    senses.extend(other.as_deref().map(|other| (other, !counterclockwise)));
    let (values, _) = explain(&senses, 1e-3 * radius_mm);
    let level = levelled((&own, counterclockwise), &values, 1e-3 * radius_mm);
    for axis in 0..2 {
        // The first axis reverses where the second is at its middle, and the other way round.
        for side in [0.0, 180.0] {
            let at = 90.0 * axis as f64 + side;
            let (step, spike) = reversal(&level, at, counterclockwise).unwrap_or_default();
            if step.abs() > words.step_um[axis].abs() {
                words.step_um[axis] = step;
            }
            words.spike_um[axis] = words.spike_um[axis].max(spike);
        }
    }
    let value = |place: usize| values[place].map(|(value, _)| value);
    words.both = other
        .as_ref()
        .and_then(|_| Some([value(SQUARE)?, value(MISMATCH)?, value(SCALE)?]));
    words
}
