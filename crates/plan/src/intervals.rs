//! Bounds of the joints' derivatives along a piece of path.

use crate::demand::{Demand, Interval, JointDemand};
use crate::machine::Machine;
use crate::piece::Piece;
use lostmotion_base::{AXES, Coords, Jet};
use lostmotion_kinematics::{JointMap, Kinematics, KinematicsError};
use lostmotion_path::{Curve, Quintic};

/// Most that the tangent of an arc turns within one part, rad. A choice: over it an axis' share of
/// the tangent changes by 0.1 at most; smaller bounds tighter and costs time.
const ARC_PART_RAD: f64 = 0.1;
/// Parts of a blend or of a piece of a run. A choice: more bound tighter and cost time.
const QUINTIC_PARTS: usize = 6;
/// Most parts of one arc, so that no number of turns needs unbounded memory. A choice: 65 turns in
/// parts of `ARC_PART_RAD`; beyond, parts get longer.
const MAX_ARC_PARTS: f64 = 4096.0;
/// Halvings, at most, while the derivatives of the joints vary over a stretch. A choice: a stretch
/// is cut into 1024 at most.
const MAX_HALVINGS: u32 = 10;
/// Further halvings where a joint turns round between the places that were evaluated (near a
/// singular pose). A choice: into another 1024 at most.
const PEAK_HALVINGS: u32 = 10;
/// A stretch is halved while the value in its middle differs from the mean of its ends by more than
/// this part of the largest value. A choice: the bound is at most 2 % above the values; smaller
/// costs halvings.
const CHORD_DEPARTURE: f64 = 0.02;
/// Neighbouring intervals that are together shorter than this part of the way in one averaging
/// window become one. Record 35 of the decisions gives what it costs.
const GATHERED_WINDOW: f64 = 0.4;
/// Largest speed of the path parameter, 1/s, where neither feed nor joints bound it; far above any
/// machine.
const SPEED_CEILING: f64 = 1e9;
/// Rounding of a joint's travel over a stretch, mm or rad.
const TRAVEL_ROUNDING: f64 = 1e-9;

/// Turns pieces into intervals, gathering tiny ones.
#[derive(Clone, Debug)]
pub(crate) struct Intervals {
    end: f64,
    /// Part of the way in one averaging window below which neighbours become one.
    gathered: f64,
    /// The interval that may still be gathered with what follows, and the longest window of the joints
    /// that move in it, s.
    open: Option<(Interval, f64)>,
}

impl Intervals {
    /// Starts a path at 0; neighbours that are short become one.
    pub(crate) fn gathered() -> Intervals {
        Intervals {
            end: 0.0,
            gathered: GATHERED_WINDOW,
            open: None,
        }
    }

    /// Starts a path at 0; each part is an interval.
    pub(crate) fn apart() -> Intervals {
        Intervals {
            gathered: 0.0,
            ..Intervals::gathered()
        }
    }

    /// Length of the path so far.
    pub(crate) fn end(&self) -> f64 {
        self.end
    }

    /// Adds a piece; intervals that are complete go to `out`.
    pub(crate) fn push(
        &mut self,
        piece: &Piece,
        machine: &Machine,
        kinematics: &dyn Kinematics,
        out: &mut Vec<Interval>,
    ) -> Result<(), KinematicsError> {
        for (length, demand) in demands(piece, machine, kinematics)? {
            // Where neither a joint nor the feed bounds the speed, the cap has to be finite all the
            // same: it is squared.
            let cap = machine.speed_cap(&demand).min(SPEED_CEILING);
            self.add(length, (demand, machine.window_s(&demand)), cap, out);
        }
        Ok(())
    }

    /// Adds a part with the longest window of the joints that move in it: one that stands has no say.
    fn add(
        &mut self,
        length: f64,
        (demand, window_s): (Demand, f64),
        cap: f64,
        out: &mut Vec<Interval>,
    ) {
        let (start, end) = (self.end, self.end + length);
        self.end = end;
        // Parts that the motion passes within a fraction of the averaging window act on it
        // together: the maximum over them costs little time and saves intervals.
        match &mut self.open {
            Some((open, longest_s))
                if end - open.start
                    <= self.gathered * longest_s.max(window_s) * open.cap.min(cap) =>
            {
                open.demand.join(&demand);
                open.cap = open.cap.min(cap);
                open.end = end;
                *longest_s = longest_s.max(window_s);
            }
            open => {
                let next = Interval {
                    start,
                    end,
                    demand,
                    cap,
                };
                out.extend(open.replace((next, window_s)).map(|(done, _)| done));
            }
        }
    }

    /// Ends the path; the next one starts at 0.
    pub(crate) fn finish(&mut self, out: &mut Vec<Interval>) {
        out.extend(self.open.take().map(|(done, _)| done));
        self.end = 0.0;
    }
}

/// Lengths and demands of consecutive parts of a piece.
pub(crate) fn demands(
    piece: &Piece,
    machine: &Machine,
    kinematics: &dyn Kinematics,
) -> Result<Vec<(f64, Demand)>, KinematicsError> {
    let length = piece.curve.length();
    let mut parts = parts(&piece.curve);
    // Bounds of the whole quintic tell how many parts are worth having.
    if let (Curve::Quintic(quintic), JointMap::Shifted) = (&piece.curve, kinematics.joint_map()) {
        let mut whole = signed(quintic, 0.0, length);
        whole.feed = feed(piece, 0.0, length, slopes(&whole)).min(chord_speed(
            piece,
            machine,
            kinematics,
            [0.0, length],
        )?);
        // Parts shorter than this would be gathered again.
        let gathered = GATHERED_WINDOW * machine.window_s(&whole) * machine.speed_cap(&whole);
        if length <= gathered {
            return Ok(vec![(length, whole)]);
        }
        parts = parts.min((length / gathered).ceil() as usize);
    }
    let mut out = Vec::with_capacity(parts);
    for part in 0..parts {
        let (s0, s1) = (
            length * (part as f64 / parts as f64),
            length * ((part + 1) as f64 / parts as f64),
        );
        if kinematics.joint_map() == JointMap::Shifted {
            // Joints are program coordinates up to a constant, so that bounds of the curve hold for
            // them.
            let mut demand = match &piece.curve {
                Curve::Quintic(quintic) => signed(quintic, s0, s1),
                curve => magnitudes(curve, s0, s1),
            };
            demand.feed = feed(piece, s0, s1, slopes(&demand)).min(chord_speed(
                piece,
                machine,
                kinematics,
                [s0, s1],
            )?);
            out.push((s1 - s0, demand));
        } else {
            curved_demands(
                piece,
                machine,
                kinematics,
                (s0, s1),
                MAX_HALVINGS + PEAK_HALVINGS,
                &mut out,
            )?;
        }
    }
    Ok(out)
}

/// The largest slope of every joint.
fn slopes(demand: &Demand) -> Coords {
    Coords(demand.joints.map(|joint| joint.first))
}

/// Bounds of the magnitudes.
fn magnitudes(curve: &Curve, s0: f64, s1: f64) -> Demand {
    let (d1, d2, d3) = curve.max_derivatives(s0, s1);
    let joint = |k: usize| JointDemand::new(d1.0[k], d2.0[k], d3.0[k]);
    Demand {
        joints: std::array::from_fn(joint),
        ..Demand::NONE
    }
}

/// Bounds of the derivatives over part of a quintic by their control points there.
fn signed(quintic: &Quintic, s0: f64, s1: f64) -> Demand {
    let mut demand = Demand::NONE;
    for joint in 0..quintic.moving() {
        // A Bezier polynomial lies within the hull of its control points, and its derivatives
        // within those of their differences.
        let (first, second, third) = quintic.derivative_points(joint, s0, s1);
        let most = first.into_iter();
        let first = most.fold(0.0, |most: f64, b| most.max(b.abs()));
        // Each side apart: bending one way must not be charged with the jerk of bending the other
        // way.
        let [second, third] = [second.as_slice(), &third].map(|points| {
            let up = points.iter().fold(0.0, |most: f64, b| most.max(*b));
            let down = points.iter().fold(0.0, |most: f64, b| most.max(-b));
            [up, down]
        });
        demand.joints[joint] = JointDemand {
            first,
            second,
            third,
        };
    }
    demand
}

fn parts(curve: &Curve) -> usize {
    match curve {
        Curve::Line(_) => 1,
        Curve::Arc(arc) => (arc.sweep().abs() / ARC_PART_RAD)
            .ceil()
            .clamp(1.0, MAX_ARC_PARTS) as usize,
        Curve::Quintic(_) => QUINTIC_PARTS,
    }
}

/// Largest speed of the parameter that keeps the feed: lower where X Y Z move faster than the
/// parameter, and higher where they alone move and are slower.
fn feed(piece: &Piece, s0: f64, s1: f64, d1: Coords) -> f64 {
    let Curve::Quintic(quintic) = &piece.curve else {
        return piece.feed;
    };
    let by_tip = piece.goes_by_tip(&d1);
    // The tip is no faster than the parameter.
    if d1.linear_norm() <= 1.0 && !by_tip {
        return piece.feed;
    }
    // The hodograph lies within the hull of its control points: the longest one bounds the speed of
    // the tip.
    let [x, y, z] = [0, 1, 2].map(|axis| quintic.derivative_points(axis, s0, s1).0);
    let squares = x
        .iter()
        .zip(&y)
        .zip(&z)
        .map(|((x, y), z)| x * x + y * y + z * z);
    let least = if by_tip { f64::MIN_POSITIVE } else { 1.0 };
    piece.feed / squares.fold(least, f64::max).sqrt()
}

/// Largest speed of the parameter with which the tool stays near its way between two commands. On
/// a line the joints go straight anyway.
fn chord_speed(
    piece: &Piece,
    machine: &Machine,
    kinematics: &dyn Kinematics,
    ends: [f64; 2],
) -> Result<f64, KinematicsError> {
    match (&machine.chord, &piece.curve) {
        (None, _) | (_, Curve::Line(_)) => Ok(f64::INFINITY),
        (Some(chord), _) => chord.speed_over(piece, kinematics, ends),
    }
}

/// Whether the travel of some joint differs from Simpson's rule over its speeds at the ends and in
/// the middle of a stretch: then its speed has a peak between those places.
fn hides_a_peak([first, second, third]: &[[Jet; AXES]; 3], length: f64) -> bool {
    first.iter().zip(second).zip(third).any(|((a, m), b)| {
        let fastest = a.0[1].abs().max(m.0[1].abs()).max(b.0[1].abs());
        // Travel by Simpson's rule.
        let told = (a.0[1] + 4.0 * m.0[1] + b.0[1]) * length / 6.0;
        (b.0[0] - a.0[0] - told).abs() > CHORD_DEPARTURE * fastest * length + TRAVEL_ROUNDING
    })
}

/// Demands under kinematics that bend the path: from exact derivatives at the ends and the middle
/// of a stretch, halved until the middle lies near the chord of the ends.
fn curved_demands(
    piece: &Piece,
    machine: &Machine,
    kinematics: &dyn Kinematics,
    (s0, s1): (f64, f64),
    halvings: u32,
    out: &mut Vec<(f64, Demand)>,
) -> Result<(), KinematicsError> {
    let middle = 0.5 * (s0 + s1);
    let mut jets = [[Jet::default(); AXES]; 3];
    for (jet, s) in jets.iter_mut().zip([s0, middle, s1]) {
        *jet = kinematics.inverse_jet(&piece.curve.jet(s), &piece.tool_mm)?;
    }
    let mut demand = Demand::NONE;
    let mut smooth = true;
    let [first, second, third] = jets;
    // A peak of the speed between the three places shows in the travel alone.
    let hidden = hides_a_peak(&jets, s1 - s0);
    for (joint, ((first, second), third)) in first.iter().zip(&second).zip(&third).enumerate() {
        let most = [1, 2, 3].map(|order| {
            let (a, m, b) = (first.0[order], second.0[order], third.0[order]);
            let largest = a.abs().max(m.abs()).max(b.abs());
            // No bound of the next derivative is known: the middle's distance from the chord stands
            // for what the function may rise above all three values.
            let sagitta = (m - 0.5 * (a + b)).abs();
            smooth &= sagitta <= CHORD_DEPARTURE * largest + f64::EPSILON;
            largest + sagitta
        });
        demand.joints[joint] = JointDemand::new(most[0], most[1], most[2]);
    }
    // The first halvings make the derivatives smooth; all of them are spent on a hidden peak.
    if (smooth || halvings <= PEAK_HALVINGS) && (!hidden || halvings == 0) {
        let (d1, _, _) = piece.curve.max_derivatives(s0, s1);
        let chord = machine.chord.as_ref().map_or(f64::INFINITY, |chord| {
            chord.speed([&first, &second, &third], &piece.tool_mm)
        });
        demand.feed = feed(piece, s0, s1, d1).min(chord);
        out.push((s1 - s0, demand));
        return Ok(());
    }
    curved_demands(piece, machine, kinematics, (s0, middle), halvings - 1, out)?;
    curved_demands(piece, machine, kinematics, (middle, s1), halvings - 1, out)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Dense samples of the derivatives lie within the bounds, and come near those that should be
    /// exact.
    #[test]
    fn signed_bounds_hold_everywhere() {
        let height = [0.0, 0.3, -0.2, 0.9, 0.1, 0.5];
        let mut points = [Coords::ZERO; 6];
        for (k, point) in points.iter_mut().enumerate() {
            *point = Coords::xyz(0.4 * k as f64, height[k], -height[5 - k]);
        }
        let quintic = Quintic::from_control_points(points, 2.0).ok();
        let Some(quintic) = quintic else {
            return assert!(quintic.is_some());
        };
        for (s0, s1) in [(0.0, 2.0), (0.3, 0.7), (1.2, 1.25), (1.9, 2.0)] {
            let demand = signed(&quintic, s0, s1);
            let (mut second, mut third) = (0.0_f64, 0.0_f64);
            for i in 0..=1000 {
                let at = quintic.eval(s0 + (s1 - s0) * (f64::from(i) / 1000.0));
                let within = |bounds: [&[f64; AXES]; 2], d: Coords| {
                    bounds[0]
                        .iter()
                        .zip(bounds[1])
                        .zip(d.0)
                        .all(|((up, down), d)| -down - 1e-9 <= d && d <= up + 1e-9)
                };
                let of = |joint: fn(&JointDemand) -> f64| demand.joints.each_ref().map(joint);
                assert!(within([&of(|joint| joint.first); 2], at.d1));
                assert!(
                    within(
                        [&of(|joint| joint.second[0]), &of(|joint| joint.second[1])],
                        at.d2
                    ),
                    "second from {s0} to {s1}"
                );
                assert!(
                    within(
                        [&of(|joint| joint.third[0]), &of(|joint| joint.third[1])],
                        at.d3
                    ),
                    "third from {s0} to {s1}"
                );
                (second, third) = (second.max(at.d2.0[1].abs()), third.max(at.d3.0[1].abs()));
            }
            if s1 - s0 < 0.1 {
                let most = demand.joints[1].most();
                assert!(most.d2 < 1.05 * second && most.d3 < 1.05 * third);
            }
        }
    }
}
