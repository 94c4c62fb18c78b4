//! What canned cycles do at a hole.

use super::Exec;
use crate::codes::Code;
use crate::dialect::Dialect;
use crate::ops::{CanonicalOp, OrientWay, Plane, Position, Units};
use crate::problem::Problem;

/// How far above the last depth a peck's rapid move stops (LinuxCNC: 0.010 in, 0.254 mm).
const PECK_CLEARANCE_MM: f64 = 0.254;

/// A hole: levels along the plane's normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hole {
    pub(crate) code: Code,
    pub(crate) plane: Plane,
    /// Index of the axis that is drilled along.
    pub(crate) normal: usize,
    /// Where feed begins.
    pub(crate) r: f64,
    pub(crate) bottom: f64,
    /// Where the cycle ends.
    pub(crate) clear: f64,
    /// Dwell, s.
    pub(crate) p: Option<f64>,
    /// Dwell of the last cycle that had one, s.
    pub(crate) last_p: f64,
    /// I, J and K.
    pub(crate) ijk: [Option<f64>; 3],
    /// Depth of a peck.
    pub(crate) q: Option<f64>,
    /// Spindle that taps.
    pub(crate) spindle: u8,
}

impl Exec<'_> {
    /// Drills from above a hole, which is at its R level.
    pub(crate) fn drill(&mut self, hole: &Hole) -> Result<(), Problem> {
        // How each cycle goes down, what it does at the bottom, and how it comes out.
        match hole.code.tenths {
            730 | 830 => self.peck(hole),
            740 | 840 => self.tap(hole),
            // Counterbore: dwell at the bottom, rapid out.
            820 => {
                self.level(hole, hole.bottom, true);
                self.hole_dwell(hole)?;
                self.level(hole, hole.clear, false);
                Ok(())
            }
            // Ream: feed out to R, then rapid.
            850 => {
                self.level(hole, hole.bottom, true);
                self.level(hole, hole.r, true);
                self.level(hole, hole.clear, false);
                Ok(())
            }
            // Bore: dwell, feed out.
            890 => {
                self.level(hole, hole.bottom, true);
                self.hole_dwell(hole)?;
                self.level(hole, hole.clear, true);
                Ok(())
            }
            860 | 880 => self.bore(hole),
            870 => self.back_bore(hole),
            _ => {
                self.level(hole, hole.bottom, true);
                self.level(hole, hole.clear, false);
                Ok(())
            }
        }
    }

    /// Moves along the hole's axis.
    pub(crate) fn level(&mut self, hole: &Hole, level: f64, feed: bool) {
        let mut end = self.state.current;
        end[hole.normal] = level;
        self.move_to(end, feed);
    }

    fn hole_dwell(&mut self, hole: &Hole) -> Result<(), Problem> {
        let seconds = hole.p.ok_or(Problem::WordMissing {
            code: hole.code,
            what: "P, the seconds to wait",
        })?;
        self.pause(seconds)
    }

    /// G83 clears the hole after each peck, G73 only breaks the chip.
    fn peck(&mut self, hole: &Hole) -> Result<(), Problem> {
        // A peck of zero depth would never reach the bottom.
        let delta = hole.q.ok_or(Problem::WordMissing {
            code: hole.code,
            what: "Q, the depth of a peck",
        })?;
        if delta <= 0.0 {
            return Err(Problem::WordOutOfRange {
                code: hole.code,
                letter: 'Q',
                value: delta,
                allowed: "greater than zero",
            });
        }
        let clearance = Units::Mm.convert(PECK_CLEARANCE_MM, self.state.units);
        // Each peck starts a little above the depth of the last one.
        let mut depth = hole.r - delta;
        while depth > hole.bottom {
            self.level(hole, depth, true);
            if hole.code.tenths == 830 {
                self.level(hole, hole.r, false);
            }
            self.level(hole, depth + clearance, false);
            depth -= delta;
        }
        self.level(hole, hole.bottom, true);
        self.level(hole, hole.clear, false);
        Ok(())
    }

    fn turn(&mut self, spindle: u8, clockwise: bool) {
        self.emit(CanonicalOp::StopSpindle { spindle });
        self.spindle_state(spindle).clockwise = Some(clockwise);
        self.emit(CanonicalOp::StartSpindle { spindle, clockwise });
    }

    /// G84 taps right-handed, G74 left-handed.
    ///
    /// Rigid tapping turns the spindle itself: after M29 at Fanuc, always at Haas ("it is not
    /// necessary to start the spindle with M03"). It stands still after the hole if it did before.
    fn tap(&mut self, hole: &Hole) -> Result<(), Problem> {
        let clockwise = hole.code.tenths == 840;
        let turns = self.spindle_state(hole.spindle).clockwise;
        let is_rigid = self.state.rigid_tapping || self.config.dialect == Dialect::Haas;
        if is_rigid {
            if turns != Some(clockwise) {
                self.turn(hole.spindle, clockwise);
            }
        } else if turns != Some(clockwise) {
            // The wrong sense of rotation would break the tap.
            let message = match (clockwise, self.config.dialect == Dialect::Fanuc) {
                (true, false) => "G84 needs the spindle to turn clockwise",
                (false, false) => "G74 needs the spindle to turn counter-clockwise",
                (true, true) => {
                    "G84 needs the spindle to turn clockwise (M3), or M29 for rigid tapping"
                }
                (false, true) => {
                    "G74 needs the spindle to turn counter-clockwise (M4), or M29 for rigid tapping"
                }
            };
            return Err(Problem::Cycle { message });
        }
        let (feed, speed) = (self.state.feed_override, self.state.speed_override);
        // Feed and speed belong together while the tap is in the hole: overrides are off.
        self.emit(CanonicalOp::FeedOverride(false));
        self.emit(CanonicalOp::SpeedOverride(false));
        self.tap_level(hole, hole.bottom);
        // Reversed at the bottom the tap unscrews itself at the same pitch.
        self.turn(hole.spindle, !clockwise);
        self.pause(hole.last_p)?;
        self.tap_level(hole, hole.clear);
        if is_rigid && turns.is_none() {
            let spindle = hole.spindle;
            self.emit(CanonicalOp::StopSpindle { spindle });
            self.spindle_state(spindle).clockwise = None;
        } else {
            self.turn(hole.spindle, clockwise);
        }
        self.emit(CanonicalOp::FeedOverride(feed));
        self.emit(CanonicalOp::SpeedOverride(speed));
        Ok(())
    }

    /// A tapping move along the hole's axis.
    fn tap_level(&mut self, hole: &Hole, level: f64) {
        let mut end = self.state.current;
        end[hole.normal] = level;
        let asked = end;
        if self.config.rs274_tapping && hole.plane != Plane::Xy {
            // As recorded: the stand-alone interpreter takes the plane's axes one too far.
            let [first, second, normal] = hole.plane.axes();
            (end[0], end[1], end[2]) = if hole.plane == Plane::Zx {
                (asked[normal], asked[first], asked[second])
            } else {
                (asked[second], asked[normal], asked[first])
            };
        }
        self.move_to(end, true);
        self.state.current = asked;
    }

    /// G87 lowers the tool beside the hole's centre line with the spindle held, bores upwards to
    /// the middle level, and comes out the same way.
    fn back_bore(&mut self, hole: &Hole) -> Result<(), Problem> {
        let Some(clockwise) = self.state.spindle.clockwise else {
            return Err(Problem::Cycle {
                message: "the cycle needs the spindle to turn",
            });
        };
        let [first, second, normal] = hole.plane.axes();
        let offset = |axis: usize| {
            hole.ijk[axis].ok_or(Problem::WordMissing {
                code: hole.code,
                what: "I, J and K",
            })
        };
        let (along_first, along_second, middle) =
            (offset(first)?, offset(second)?, offset(normal)?);
        // K is the upper end of the counterbore; under G91 it counts from the bottom.
        let middle = if self.state.absolute {
            middle
        } else {
            middle + hole.bottom
        };
        let center = self.state.current;
        // I and J shift the tool off the centre line, so that its edge clears the bore.
        let mut beside = center;
        beside[first] += along_first;
        beside[second] += along_second;
        let at = |place: &Position, level: f64| {
            let mut end = *place;
            end[normal] = level;
            end
        };
        let way = if clockwise {
            OrientWay::Clockwise
        } else {
            OrientWay::CounterClockwise
        };
        let orient = CanonicalOp::OrientSpindle {
            spindle: 0,
            degrees: 0.0,
            way,
            boring: true,
        };
        let start = CanonicalOp::StartSpindle {
            spindle: 0,
            clockwise,
        };
        // Lower the held tool beside the bore, move to its centre line and start the spindle there.
        self.move_to(beside, false);
        self.emit(CanonicalOp::StopSpindle { spindle: 0 });
        self.emit(orient.clone());
        self.move_to(at(&beside, hole.bottom), false);
        self.move_to(at(&center, hole.bottom), false);
        self.emit(start.clone());
        // Bore upwards, and back down to where the tool can leave.
        self.move_to(at(&center, middle), true);
        self.move_to(at(&center, hole.bottom), true);
        // Hold the tool again and lift it out beside the bore.
        self.emit(CanonicalOp::StopSpindle { spindle: 0 });
        self.emit(orient);
        self.move_to(at(&beside, hole.bottom), false);
        self.move_to(at(&beside, hole.clear), false);
        self.move_to(at(&center, hole.clear), false);
        self.emit(start);
        Ok(())
    }

    /// G86 retracts with the spindle stopped, G88 lets the operator do it.
    fn bore(&mut self, hole: &Hole) -> Result<(), Problem> {
        let Some(clockwise) = self.state.spindle.clockwise else {
            return Err(Problem::Cycle {
                message: "the cycle needs the spindle to turn",
            });
        };
        self.level(hole, hole.bottom, true);
        self.hole_dwell(hole)?;
        self.emit(CanonicalOp::StopSpindle { spindle: 0 });
        if hole.code.tenths == 880 {
            self.emit(CanonicalOp::ProgramStop);
            // The operator retracts by hand to the clearance level.
            self.state.current[hole.normal] = hole.clear;
        } else {
            self.level(hole, hole.clear, false);
        }
        self.emit(CanonicalOp::StartSpindle {
            spindle: 0,
            clockwise,
        });
        Ok(())
    }
}
