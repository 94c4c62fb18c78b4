//! How two moves are joined: a stop, a blend, a vertex of a run, or nothing.

use crate::piece::Programmed;
use crate::piece::size;
use crate::{PathControl, PlannerConfig};
use lostmotion_base::math;
use lostmotion_base::units::{deg, rad};
use lostmotion_base::{AXES, AxisId, Coords};
use lostmotion_path::Curve;

/// Sharpest corner that is blended, degrees; sharper ones are reversals, which no blend passes
/// faster than a stop.
const REVERSAL_DEG: f64 = 175.0;
/// Most that a run turns at a vertex, degrees. A choice: larger takes corners for curves, smaller
/// stops or blends at coarse chords.
const VERTEX_DEG: f64 = 30.0;
/// Most that a run may leave its shorter chord at a vertex, in units of its length times how far apart the
/// directions are. A curve that passes each vertex in the direction of its longer chord leaves the
/// shorter one, of length h, by 0.148 h times that for either end.
const VERTEX_DEVIATION: f64 = 0.3;
/// The same for the end of a long line beside a short one, which takes all of the angle.
const LONG_DEVIATION: f64 = 0.25;
/// Longest part of a long line that belongs to a run, in lengths of the short line beside it: with
/// more the curve bends unevenly. Record 38 of the decisions.
const LONG_CHORDS: f64 = 6.0;
/// Difference of two derivatives up to which it is rounding.
const SAME_DERIVATIVE: f64 = 1e-10;

/// A meeting of two moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Junction {
    /// Comes to rest.
    Stop,
    /// Nothing to do: position and two derivatives agree.
    Through,
    /// A vertex of a polyline that stands for a curve.
    Vertex,
    /// To be blended within a tolerance, mm, if that is faster than a stop.
    Blend { tolerance: f64 },
}

/// Tolerance at the end of a move, mm, and whether sharp corners may be cut.
fn allowed(config: &PlannerConfig, control: PathControl) -> Option<(f64, bool)> {
    match control {
        PathControl::ExactStop => None,
        PathControl::ExactPath => Some((config.exact_path_tolerance_mm, false)),
        PathControl::Continuous { tolerance_mm, .. } => {
            let tolerance = tolerance_mm.unwrap_or(config.default_tolerance_mm);
            Some((
                tolerance.max(config.exact_path_tolerance_mm),
                tolerance > config.exact_path_tolerance_mm,
            ))
        }
    }
}

/// Tolerance for a run of short lines, mm; `None` if they are not to be merged.
pub(crate) fn merge_tolerance(config: &PlannerConfig, control: PathControl) -> Option<f64> {
    let PathControl::Continuous {
        tolerance_mm,
        merge_tolerance_mm,
    } = control
    else {
        return None;
    };
    let (tolerance, wide) = allowed(config, control)?;
    // A bare G64 asks for the best speed: its default tolerance holds for runs, too.
    let merge = match (tolerance_mm, merge_tolerance_mm) {
        (Some(_), Some(merge)) => merge.min(tolerance),
        _ => tolerance,
    };
    (wide && merge > 0.0).then_some(merge)
}

/// A derivative with its angles in degrees, so that it measures as the feed rule does.
fn scaled(d: &Coords) -> Coords {
    let mut scaled = *d;
    for axis in AxisId::ALL.into_iter().filter(|axis| axis.is_rotary()) {
        scaled[axis] = deg(d[axis]);
    }
    scaled
}

/// Angle between two directions, rad.
fn angle(a: &Coords, b: &Coords) -> f64 {
    let stands = |d: &Coords| d.0[3..].iter().all(|d| *d == 0.0);
    if stands(a) && stands(b) {
        angle_of::<3>(a, b)
    } else {
        angle_of::<AXES>(&scaled(a), &scaled(b))
    }
}

/// The same where only the first N axes move.
fn angle_of<const N: usize>(a: &Coords, b: &Coords) -> f64 {
    let (a, b) = (&a.0[..N], &b.0[..N]);
    let size = |d: &[f64]| d.iter().map(|d| d * d).sum::<f64>().sqrt();
    let (na, nb) = (size(a), size(b));
    let (mut sum, mut difference) = (0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        let (x, y) = (a / na, b / nb);
        sum += (x + y) * (x + y);
        difference += (x - y) * (x - y);
    }
    // From both |a + b| and |a - b|, which is accurate for small angles and for reversals alike.
    2.0 * math::atan2(difference.sqrt(), sum.sqrt())
}

/// How far a curve in one direction leaves a line in another per unit of length: the angle between them, and
/// at least what any group of axes does. Where rotary axes turn fast the angle is small whatever X Y Z do.
fn apart(a: &Coords, b: &Coords) -> f64 {
    angle(a, b).max(size(&(*b - *a)))
}

/// How much of a long line may bend next to the vertex where two lines meet, mm: a curve through it
/// stays within the tolerance of chords of that length.
pub(super) fn reach(before: &Programmed, next: &Programmed, tolerance: f64) -> f64 {
    let apart = apart(
        &before.curve.eval(before.length).d1,
        &next.curve.eval(0.0).d1,
    );
    (tolerance / (LONG_DEVIATION * apart.max(f64::MIN_POSITIVE)))
        .min(LONG_CHORDS * before.length.min(next.length))
}

/// Most that the lines of a section turn where they meet, degrees.
const BEND_DEG: f64 = 125.1;
/// Most that they turn in a section that has gentle bends, degrees. A choice: with sharp corners among
/// gentle bends all of it is a curve or none.
const GENTLE_DEG: f64 = 60.1;
/// How far from a corner a curve leaves its lines, in units of the tolerance over the angle.
/// Measured.
const BEND_REACH: f64 = 120.0;

/// The same in units of the root of the tolerance times the radius of an arc. Measured.
const ARC_REACH: f64 = 40.0;
/// How many lines an arc counts as in a section. A choice: about as many pieces of a curve lie on it.
const ARC_WEIGHT: usize = 24;

/// How much a move adds to a section.
pub(super) fn weight(line: &Programmed) -> usize {
    match line.curve {
        Curve::Arc(_) => ARC_WEIGHT,
        _ => 1,
    }
}

/// Whether two moves are lines or arcs that one curve may take the place of.
pub(super) fn bends(config: &PlannerConfig, before: &Programmed, next: &Programmed) -> bool {
    let kept = |line: &Programmed| {
        matches!(line.curve, Curve::Line(_) | Curve::Arc(_))
            && merge_tolerance(config, line.control).is_some()
            && is_linear(line)
    };
    kept(before)
        && kept(next)
        && before.tool_mm == next.tool_mm
        && turns_within(config, before, next, BEND_DEG)
}

/// Whether lines turn no more than an angle where they meet, or for no longer than the tolerance.
fn turns_within(
    config: &PlannerConfig,
    before: &Programmed,
    next: &Programmed,
    most_deg: f64,
) -> bool {
    let turn = turn(before, next);
    let short = before.length.min(next.length);
    turn <= rad(most_deg) || turn * short <= tolerance(config, before, next)
}

/// Whether moves of which one curve may take the place meet at a gentle bend, not a sharp corner.
pub(super) fn is_gentle(config: &PlannerConfig, before: &Programmed, next: &Programmed) -> bool {
    turns_within(config, before, next, GENTLE_DEG)
}

/// The lesser tolerance of two moves.
fn tolerance(config: &PlannerConfig, before: &Programmed, next: &Programmed) -> f64 {
    [before, next]
        .iter()
        .filter_map(|line| merge_tolerance(config, line.control))
        .fold(f64::INFINITY, f64::min)
}

/// Whether a line moves X Y Z and nothing else.
fn is_linear(line: &Programmed) -> bool {
    let d = line.curve.eval(0.0).d1;
    line.curve.moves_tip() && d.0[3..].iter().all(|d| *d == 0.0)
}

fn turn(before: &Programmed, next: &Programmed) -> f64 {
    angle(
        &before.curve.eval(before.length).d1,
        &next.curve.eval(0.0).d1,
    )
}

/// How far from where two moves meet a curve leaves them.
pub(super) fn bent(config: &PlannerConfig, before: &Programmed, next: &Programmed) -> f64 {
    let tolerance = tolerance(config, before, next);
    let turn = turn(before, next).max(f64::MIN_POSITIVE);
    let [end, start] = [before.curve.eval(before.length).d2, next.curve.eval(0.0).d2];
    let bend = end.linear_norm().max(start.linear_norm());
    (BEND_REACH * tolerance / turn)
        .min(ARC_REACH * (tolerance / bend.max(f64::MIN_POSITIVE)).sqrt())
}

/// The way from rest to a feed, mm, if all joints moved as the slowest of X Y Z.
pub(super) fn run_up(config: &PlannerConfig, feed: f64) -> f64 {
    let limits = config.limits[..3].iter().flatten();
    let (acceleration, jerk) = limits.fold((f64::INFINITY, f64::INFINITY), |(a, j), limits| {
        (a.min(limits.acceleration), j.min(limits.jerk))
    });
    0.5 * feed * (feed / acceleration + acceleration / jerk)
}

/// Whether a line is so long that its middle stays as it is.
pub(super) fn stays_straight(
    config: &PlannerConfig,
    before: &Programmed,
    line: &Programmed,
    next: &Programmed,
) -> bool {
    bent(config, before, line) + bent(config, line, next) < line.length
}

/// Decides how `next` follows `before`.
pub(crate) fn joint(config: &PlannerConfig, before: &Programmed, next: &Programmed) -> Junction {
    let (Some(first), Some(second)) = (
        allowed(config, before.control),
        allowed(config, next.control),
    ) else {
        // Only the end of an exact stop move is a stop; what follows one has none at its start
        // besides.
        return match allowed(config, before.control) {
            None => Junction::Stop,
            Some((tolerance, _)) => corner(config, before, next, tolerance, false),
        };
    };
    corner(
        config,
        before,
        next,
        first.0.min(second.0),
        first.1 && second.1,
    )
}

fn corner(
    config: &PlannerConfig,
    before: &Programmed,
    next: &Programmed,
    tolerance: f64,
    cut: bool,
) -> Junction {
    if before.tool_mm != next.tool_mm {
        return Junction::Stop;
    }
    let (end, start) = (before.curve.eval(before.length), next.curve.eval(0.0));
    let turn = angle(&end.d1, &start.d1);
    // A vertex that happens to lie on the line of its neighbours is one all the same.
    if is_vertex(config, before, next, turn, apart(&end.d1, &start.d1)) {
        return Junction::Vertex;
    }
    if goes_on(before, next) {
        return Junction::Through;
    }
    // G61 rounds only what is within its angle, and a reversal is always a stop.
    if turn > rad(REVERSAL_DEG) || (!cut && turn > rad(config.exact_path_angle_deg)) {
        return Junction::Stop;
    }
    Junction::Blend { tolerance }
}

/// Whether position and two derivatives agree already.
pub(super) fn goes_on(before: &Programmed, next: &Programmed) -> bool {
    let (end, start) = (before.curve.eval(before.length), next.curve.eval(0.0));
    [start.p - end.p, start.d1 - end.d1, start.d2 - end.d2]
        .iter()
        .all(|difference| size(difference) <= SAME_DERIVATIVE)
}

fn is_vertex(
    config: &PlannerConfig,
    before: &Programmed,
    next: &Programmed,
    turn: f64,
    apart: f64,
) -> bool {
    let (Some(first), Some(second)) = (
        merge_tolerance(config, before.control),
        merge_tolerance(config, next.control),
    ) else {
        return false;
    };
    let lines = matches!(
        (&before.curve, &next.curve),
        (Curve::Line(_), Curve::Line(_))
    );
    let tips = before.curve.moves_tip() && next.curve.moves_tip();
    // Short lines that turn little: a curve through the vertices stays within the tolerance.
    lines
        && tips
        && turn <= rad(VERTEX_DEG)
        && VERTEX_DEVIATION * apart * before.length.min(next.length) <= first.min(second)
}
