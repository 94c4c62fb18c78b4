//! What canned cycles do at a hole.

use super::Exec;
use crate::ops::{CanonicalOp, Units};
use crate::problem::{Code, Problem};

/// How far above the last depth a peck's rapid move stops (LinuxCNC: 0.010 in, 0.254 mm).
const PECK_CLEARANCE_MM: f64 = 0.254;

/// A hole: levels along the plane's normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hole {
    pub(crate) code: Code,
    /// Index of the axis that is drilled along.
    pub(crate) normal: usize,
    /// Where feed begins.
    pub(crate) r: f64,
    pub(crate) bottom: f64,
    /// Where the cycle ends.
    pub(crate) clear: f64,
    /// Dwell, s.
    pub(crate) p: Option<f64>,
    /// Depth of a peck.
    pub(crate) q: Option<f64>,
}

impl Exec<'_> {
    /// Drills from above a hole, which is at its R level.
    pub(crate) fn drill(&mut self, hole: &Hole) -> Result<(), Problem> {
        match hole.code.tenths {
            730 | 830 => self.peck(hole),
            740 | 840 => self.tap(hole),
            820 => {
                self.level(hole, hole.bottom, true);
                self.hole_dwell(hole)?;
                self.level(hole, hole.clear, false);
                Ok(())
            }
            850 | 890 => {
                self.level(hole, hole.bottom, true);
                if hole.code.tenths == 890 {
                    self.hole_dwell(hole)?;
                }
                self.level(hole, hole.r, true);
                self.level(hole, hole.clear, false);
                Ok(())
            }
            860 | 880 => self.bore(hole),
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
        let seconds = hole.p.ok_or(Problem::WordMissing { code: hole.code, what: "P, the seconds to wait" })?;
        self.pause(seconds)
    }

    /// G83 clears the hole after each peck, G73 only breaks the chip.
    fn peck(&mut self, hole: &Hole) -> Result<(), Problem> {
        let delta = hole.q.ok_or(Problem::WordMissing { code: hole.code, what: "Q, the depth of a peck" })?;
        if delta <= 0.0 {
            return Err(Problem::WordOutOfRange { code: hole.code, letter: 'Q', value: delta, allowed: "greater than zero" });
        }
        let clearance = Units::Mm.convert(PECK_CLEARANCE_MM, self.state.units);
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

    fn turn(&mut self, clockwise: bool) {
        self.emit(CanonicalOp::StopSpindle { spindle: 0 });
        self.state.spindle.clockwise = Some(clockwise);
        self.emit(CanonicalOp::StartSpindle { spindle: 0, clockwise });
    }

    /// G84 taps right-handed, G74 left-handed.
    fn tap(&mut self, hole: &Hole) -> Result<(), Problem> {
        let clockwise = hole.code.tenths == 840;
        if self.state.spindle.clockwise != Some(clockwise) {
            let message =
                if clockwise { "G84 needs the spindle to turn clockwise" } else { "G74 needs the spindle to turn counter-clockwise" };
            return Err(Problem::Cycle { message });
        }
        let (feed, speed) = (self.state.feed_override, self.state.speed_override);
        self.emit(CanonicalOp::FeedOverride(false));
        self.emit(CanonicalOp::SpeedOverride(false));
        self.level(hole, hole.bottom, true);
        self.turn(!clockwise);
        self.pause(hole.p.unwrap_or(0.0))?;
        self.level(hole, hole.clear, true);
        self.turn(clockwise);
        self.emit(CanonicalOp::FeedOverride(feed));
        self.emit(CanonicalOp::SpeedOverride(speed));
        Ok(())
    }

    /// G86 retracts with the spindle stopped, G88 lets the operator do it.
    fn bore(&mut self, hole: &Hole) -> Result<(), Problem> {
        let Some(clockwise) = self.state.spindle.clockwise else {
            return Err(Problem::Cycle { message: "the cycle needs the spindle to turn" });
        };
        self.level(hole, hole.bottom, true);
        self.hole_dwell(hole)?;
        self.emit(CanonicalOp::StopSpindle { spindle: 0 });
        if hole.code.tenths == 880 {
            self.emit(CanonicalOp::ProgramStop);
        } else {
            self.level(hole, hole.clear, false);
        }
        self.emit(CanonicalOp::StartSpindle { spindle: 0, clockwise });
        Ok(())
    }
}
