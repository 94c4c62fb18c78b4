//! G2 and G3: arcs and helices, and their centres from what a block says.

use super::Exec;
use crate::codes::Code;
use crate::dialect::Leniency;
use crate::exec::words::whole_within;
use crate::ops::{ArcFeed, CanonicalOp, Plane, Position, Units};
use crate::problem::Problem;
use lostmotion_base::math;
use lostmotion_base::vec::{Vec2, distance2};
use std::f64::consts::{SQRT_2, TAU};

/// Letters of the centre by axis index.
pub(super) const CENTER_LETTERS: [u8; 3] = *b"IJK";
/// Most turns one block may make.
const MOST_TURNS: f64 = 1e6;

/// G2 and G3.
pub(crate) fn arc(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.motion = Some(code);
    let end = exec.target()?;
    let start = exec.state.current;
    // Where the block was meant to lead, even if it is wrong: what follows is then judged from
    // there.
    exec.state.current = end;
    exec.check_feed(code)?;
    let clockwise = code.tenths == 20;
    let turns = exec.turns(code)?;
    let plane = exec.state.plane;
    let [first, second, normal] = plane.axes();
    let (from, to) = ([start[first], start[second]], [end[first], end[second]]);
    // A start that is not known, because a block before it was refused, decides nothing.
    if exec.in_doubt([first, second]) {
        return Ok(());
    }
    // The centre from I, J, K or R; then limits, feed and the compensated or plain operation.
    let center = exec.center(&start, &end, clockwise)?;
    let turns = if clockwise { -turns } else { turns };
    check_radius(from, center, exec.state.units, exec.config.limits.radius_mm)?;
    // In inverse time the rate is the length of the arc over the time that F gives.
    exec.inverse_time(|| length(from, to, center, turns, end[normal] - start[normal]));
    let feed = arc_feed(plane, &end, center, turns);
    // Leaving the compensation shifts the tool by its radius, which only a straight move can
    // absorb.
    if exec.state.arc_not_allowed {
        return Err(Problem::Compensation {
            message: "the first move after cutter compensation has to be straight",
        });
    }
    if exec
        .state
        .compensation
        .as_ref()
        .is_some_and(|compensation| compensation.acts())
    {
        return exec.compensated_arc(&start, feed);
    }
    exec.emit(CanonicalOp::ArcFeed(feed));
    Ok(())
}

/// The operation of an arc to an end.
pub(crate) fn arc_feed(plane: Plane, end: &Position, center: Vec2, turns: i32) -> ArcFeed {
    let [first, second, normal] = plane.axes();
    let [_, _, _, others @ ..] = *end;
    ArcFeed {
        plane,
        end: [end[first], end[second]],
        center,
        turns,
        axis_end: end[normal],
        others,
    }
}

/// Refuses arcs beyond the limit of the radius.
pub(crate) fn check_radius(
    from: Vec2,
    center: Vec2,
    units: Units,
    limit: f64,
) -> Result<(), Problem> {
    let radius_mm = math::hypot(from[0] - center[0], from[1] - center[1]) * units.mm();
    if radius_mm <= limit {
        Ok(())
    } else {
        Err(Problem::RadiusTooLarge { radius_mm, limit })
    }
}

impl Exec<'_> {
    /// P of an arc.
    fn turns(&self, code: Code) -> Result<i32, Problem> {
        let Some(value) = self.word(b'P') else {
            return Ok(1);
        };
        whole_within(
            (code, b'P'),
            value,
            1.0..=MOST_TURNS,
            "a whole number of turns from 1",
        )
        .map(|number| number as i32)
    }

    /// The centre of an arc between two places from the words of the block.
    pub(crate) fn center(
        &mut self,
        start: &Position,
        end: &Position,
        clockwise: bool,
    ) -> Result<Vec2, Problem> {
        let plane = self.state.plane;
        let [first, second, normal] = plane.axes();
        let (from, to) = ([start[first], start[second]], [end[first], end[second]]);
        let words = self.words;
        let offset = |axis: usize| words.get(CENTER_LETTERS[axis]);
        let units = self.state.units;
        // By radius: the centre is computed, so that I, J and K would contradict it.
        if let Some(radius) = self.word(b'R') {
            if let Some(letter) = CENTER_LETTERS
                .into_iter()
                .find(|&letter| self.words.has(letter))
            {
                return Err(Problem::ArcTwoFormats {
                    letter: char::from(letter),
                });
            }
            return center_from_radius(from, to, radius, clockwise, units)
                .map_err(|fault| self.arc_problem(fault, start, end));
        }
        // An offset along the plane's normal has no meaning; CAM systems write it as zero. Outside the
        // plane that programs begin in, it and only one of the others are the pair of another plane.
        if let Some(value) = offset(normal) {
            let is_beside =
                plane == Plane::Xy || offset(first).is_some() == offset(second).is_some();
            if value == 0.0 && is_beside && self.config.leniencies.has(Leniency::OffPlaneZero) {
                self.warnings.push(Problem::Lenient {
                    leniency: Leniency::OffPlaneZero,
                });
            } else {
                return Err(Problem::ArcOffPlane {
                    letter: char::from(CENTER_LETTERS[normal]),
                    plane: plane.name(),
                    try_this: self.other_plane(start, end),
                });
            }
        }
        // Absolute centres (G90.1) need both words, relative ones count as zero where they are
        // missing.
        let center = match (offset(first), offset(second)) {
            (None, None) => {
                let offsets = match plane {
                    Plane::Xy => "I and J",
                    Plane::Zx => "I and K",
                    Plane::Yz => "J and K",
                };
                return Err(Problem::ArcWithoutCenter { offsets });
            }
            (Some(first), Some(second)) if self.state.arc_absolute => [first, second],
            (None, _) if self.state.arc_absolute => {
                return Err(Problem::ArcCenterWord {
                    letter: char::from(CENTER_LETTERS[first]),
                });
            }
            (_, None) if self.state.arc_absolute => {
                return Err(Problem::ArcCenterWord {
                    letter: char::from(CENTER_LETTERS[second]),
                });
            }
            (first, second) => [
                from[0] + first.unwrap_or(0.0),
                from[1] + second.unwrap_or(0.0),
            ],
        };
        check_center(from, to, center, units)
            .map_err(|fault| self.arc_problem(fault, start, end))?;
        Ok(center)
    }

    /// Whether the start of an arc is not known where it matters: relative words shift with it, the
    /// absolute ones of an end or a centre do not.
    fn in_doubt(&self, plane: [usize; 2]) -> bool {
        let named = |axis: &usize| self.axis_word(*axis).is_some();
        plane
            .iter()
            .filter(|axis| self.state.doubtful & 1 << **axis != 0)
            .any(|axis| self.state.arc_absolute || (self.state.absolute && named(axis)))
    }
}

/// Why two ends and a centre or a radius are no arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum ArcFault {
    /// A radius below the smallest.
    TooSmall {
        radius: f64,
        least: f64,
        center: Vec2,
    },
    /// The ends' radii differ.
    Radii { radii: [f64; 2], center: Vec2 },
    /// A radius that cannot span the chord.
    RadiusShort {
        radius: f64,
        distance: f64,
        least: f64,
    },
    /// An arc by radius without a chord.
    SamePoint,
}

/// Smallest radius, and by how much R may be short of half the distance (LinuxCNC: 0.00005 in).
const RADIUS_TOLERANCE_INCH: f64 = 0.000_05;
/// By how much the radii of an arc's ends may always differ (LinuxCNC: the diagonal of a square of
/// 0.001 in or 0.01 mm, doubled).
const CENTER_TOLERANCE_INCH: f64 = 2.0 * SQRT_2 * 0.001;
const CENTER_TOLERANCE_MM: f64 = 2.0 * SQRT_2 * 0.01;
/// Largest difference of the radii relative to the radius. Published: LinuxCNC.
const CENTER_TOLERANCE_RELATIVE: f64 = 0.001;
/// Largest difference of the radii in absolute tolerances, whatever the radius.
const MOST_CENTER_TOLERANCES: f64 = 100.0;

const fn radius_tolerance(units: Units) -> f64 {
    match units {
        Units::Inch => RADIUS_TOLERANCE_INCH,
        Units::Mm => RADIUS_TOLERANCE_INCH * 25.4,
    }
}

/// Checks an arc given by its centre: the ends' radii have to agree within tolerance.
pub(crate) fn check_center(
    start: Vec2,
    end: Vec2,
    center: Vec2,
    units: Units,
) -> Result<(), ArcFault> {
    // Rounded words make the two radii differ: LinuxCNC's tolerances decide what is still an arc.
    let (start_radius, end_radius) = (distance2(center, start), distance2(center, end));
    let least = radius_tolerance(units);
    for radius in [start_radius, end_radius] {
        if radius < least {
            return Err(ArcFault::TooSmall {
                radius,
                least,
                center,
            });
        }
    }
    let tolerance = match units {
        Units::Inch => CENTER_TOLERANCE_INCH,
        Units::Mm => CENTER_TOLERANCE_MM,
    };
    // Within the absolute tolerance any arc is accepted, beyond it only relative to a large radius.
    let difference = (start_radius - end_radius).abs();
    let relative = difference / start_radius.max(end_radius);
    if difference > MOST_CENTER_TOLERANCES * tolerance
        || (difference > tolerance && relative > CENTER_TOLERANCE_RELATIVE)
    {
        return Err(ArcFault::Radii {
            radii: [start_radius, end_radius],
            center,
        });
    }
    Ok(())
}

/// The centre of an arc given by its radius; a negative radius takes the way round that is longer
/// than a half circle.
///
/// The centre lies on the perpendicular bisector of start and end, on the right of the way from
/// start to end for the shorter clockwise arc and on the left for the shorter counter-clockwise
/// one.
pub(crate) fn center_from_radius(
    start: Vec2,
    end: Vec2,
    radius: f64,
    clockwise: bool,
    units: Units,
) -> Result<Vec2, ArcFault> {
    let chord = distance2(start, end);
    if chord == 0.0 {
        return Err(ArcFault::SamePoint);
    }
    // The circle has to span the chord: R may be short of half of it by rounding only.
    let half = 0.5 * chord;
    let least = radius_tolerance(units);
    if half - radius.abs() > least {
        return Err(ArcFault::RadiusShort {
            radius,
            distance: chord,
            least: half,
        });
    }
    // Height of the centre above the chord, to the side that the sign of R selects.
    let height = (radius * radius - half * half).max(0.0).sqrt();
    let side = if clockwise == (radius > 0.0) {
        height
    } else {
        -height
    };
    // From the middle of the chord, square to it.
    let along = [(end[0] - start[0]) / chord, (end[1] - start[1]) / chord];
    Ok([
        0.5 * (start[0] + end[0]) + side * along[1],
        0.5 * (start[1] + end[1]) - side * along[0],
    ])
}

/// Length of an arc, helix or spiral as inverse time feed takes it: the radius at the start, the
/// sweep, the rise.
pub(crate) fn length(start: Vec2, end: Vec2, center: Vec2, turns: i32, rise: f64) -> f64 {
    let angle = |point: Vec2| math::atan2(point[1] - center[1], point[0] - center[0]);
    let (from, to) = (angle(start), angle(end));
    // The first turn is begun at the start and may be a full one; each further turn adds a full
    // circle.
    let counter_clockwise = if turns > 0 { to - from } else { from - to };
    let first = if counter_clockwise <= 0.0 {
        counter_clockwise + TAU
    } else {
        counter_clockwise
    };
    let sweep = first + TAU * f64::from(turns.unsigned_abs().saturating_sub(1));
    math::hypot(distance2(center, start) * sweep, rise)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn a_centre_from_a_radius_is_that_far_from_both_ends(
            end in [-100.0..100.0_f64, -100.0..100.0_f64], extra in 0.0..50.0_f64, long in any::<bool>(), clockwise in any::<bool>()
        ) {
            let start = [3.0, -4.0];
            let chord = distance2(start, end);
            prop_assume!(chord > 1e-3);
            let radius = (0.5 * chord + extra) * if long { -1.0 } else { 1.0 };
            let center = center_from_radius(start, end, radius, clockwise, Units::Mm).unwrap();
            prop_assert!((distance2(center, start) - radius.abs()).abs() < 1e-9 * radius.abs());
            prop_assert!((distance2(center, end) - radius.abs()).abs() < 1e-9 * radius.abs());
            let sweep = length(start, end, center, if clockwise { -1 } else { 1 }, 0.0) / radius.abs();
            prop_assert_eq!(sweep > std::f64::consts::PI + 1e-6, long && extra > 1e-6 * chord);
        }
    }
}
