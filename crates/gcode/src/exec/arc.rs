//! G2 and G3.

use super::Exec;
use super::arc_geometry::{Planar, center_from_radius, check_center, length};
use crate::code::Code;
use crate::code::whole;
use crate::dialect::Leniency;
use crate::ops::{ArcFeed, CanonicalOp, Plane, Position, Units};
use crate::problem::Problem;
use lostmotion_base::math;

/// Letters of the centre by axis index.
const OFFSETS: [u8; 3] = *b"IJK";
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
    let center = exec.center(from, to, clockwise)?;
    let turns = if clockwise { -turns } else { turns };
    check_radius(from, center, exec.state.units, exec.config.limits.radius_mm)?;
    exec.inverse_time(|| length(from, to, center, turns, end[normal] - start[normal]));
    let feed = arc_feed(plane, &end, center, turns);
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
pub(crate) fn arc_feed(plane: Plane, end: &Position, center: Planar, turns: i32) -> ArcFeed {
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
    from: Planar,
    center: Planar,
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
        match whole(value).filter(|turns| (1.0..=MOST_TURNS).contains(turns)) {
            Some(turns) => Ok(turns as i32),
            None => Err(Problem::WordOutOfRange {
                code,
                letter: 'P',
                value,
                allowed: "a whole number of turns from 1",
            }),
        }
    }

    pub(crate) fn center(
        &mut self,
        from: Planar,
        to: Planar,
        clockwise: bool,
    ) -> Result<Planar, Problem> {
        let plane = self.state.plane;
        let [first, second, normal] = plane.axes();
        let words = self.words;
        let offset = |axis: usize| words.get(OFFSETS[axis]);
        let units = self.state.units;
        if let Some(radius) = self.word(b'R') {
            if let Some(letter) = OFFSETS.into_iter().find(|&letter| self.words.has(letter)) {
                return Err(Problem::ArcTwoFormats {
                    letter: char::from(letter),
                });
            }
            return center_from_radius(from, to, radius, clockwise, units);
        }
        let off_plane = offset(normal);
        if off_plane == Some(0.0) && self.config.leniencies.has(Leniency::OffPlaneZero) {
            self.warnings.push(Problem::Lenient {
                leniency: Leniency::OffPlaneZero,
            });
        } else if off_plane.is_some() {
            return Err(Problem::ArcOffPlane {
                letter: char::from(OFFSETS[normal]),
                plane: plane.name(),
            });
        }
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
                    letter: char::from(OFFSETS[first]),
                });
            }
            (_, None) if self.state.arc_absolute => {
                return Err(Problem::ArcCenterWord {
                    letter: char::from(OFFSETS[second]),
                });
            }
            (first, second) => [
                from[0] + first.unwrap_or(0.0),
                from[1] + second.unwrap_or(0.0),
            ],
        };
        check_center(from, to, center, units, self.state.arc_absolute)?;
        Ok(center)
    }
}
