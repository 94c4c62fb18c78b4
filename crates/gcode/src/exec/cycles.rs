//! Canned cycles: where the holes are and what the words mean. What is done at a hole is in
//! [`super::holes`].

use super::Exec;
use super::holes::Hole;
use crate::codes::{Code, users};
use crate::dialect::{Dialect, Leniency};
use crate::exec::words::whole_within;
use crate::ops::{CanonicalOp, PathControl, Position};
use crate::problem::Problem;
use crate::state::{CycleWords, FeedMode};

/// What is missing without the word of the axis that is drilled along.
const BOTTOM: [&str; 3] = [
    "X, the bottom of the hole",
    "Y, the bottom of the hole",
    "Z, the bottom of the hole",
];

/// Whether a motion mode is one of the canned cycles of this file.
pub(crate) const fn is_canned(mode: Code) -> bool {
    matches!(mode.tenths, 730 | 740 | 810..=890)
}

/// G73, G74 and G81 to G89.
pub(crate) fn cycle(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    if exec.state.motion != Some(code) {
        // Words stick only within the same cycle, the level where cycles began until another
        // motion.
        let in_cycle = exec.state.motion.is_some_and(is_canned);
        exec.state.cycle = CycleWords {
            level: exec.state.cycle.level.filter(|_| in_cycle),
            last_p: exec.state.cycle.last_p,
            ..CycleWords::default()
        };
        if !in_cycle {
            exec.state.before_cycle = exec.state.motion;
        }
        exec.state.motion = Some(code);
    }
    exec.check_feed(code)?;
    // Other controls turn the part between holes.
    if exec.config.dialect == Dialect::LinuxCnc && (3..6).any(|axis| exec.axis_word(axis).is_some())
    {
        return Err(Problem::Cycle {
            message: "a rotary axis in a canned cycle: turn it on a line of its own",
        });
    }
    if exec.state.feed_mode == FeedMode::InverseTime {
        return Err(Problem::Cycle {
            message: "a canned cycle in inverse time feed (G93)",
        });
    }
    // P is no word of the peck cycles, but many CAM systems write it.
    if matches!(code.tenths, 730 | 830) && exec.words.has(b'P') {
        exec.forgive_dwell()?;
    }
    let repeats = exec.repeats(code)?;
    exec.holes(code, repeats)
}

/// G98 and G99.
pub(crate) fn retract(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.retract_to_start = code.tenths == 980;
    Ok(())
}

impl Exec<'_> {
    /// P in a cycle that has no dwell.
    fn forgive_dwell(&mut self) -> Result<(), Problem> {
        if !self.config.leniencies.has(Leniency::PeckDwell) {
            let value = self.word(b'P').unwrap_or_default();
            return Err(Problem::UnusedWord {
                letter: 'P',
                value,
                users: users('P'),
            });
        }
        self.warnings.push(Problem::Lenient {
            leniency: Leniency::PeckDwell,
        });
        Ok(())
    }

    /// L.
    fn repeats(&self, code: Code) -> Result<u32, Problem> {
        let Some(value) = self.word(b'L') else {
            return Ok(1);
        };
        // L0 (K0 of Fanuc) stores the cycle's words without a hole.
        let (least, allowed) = if self.config.leniencies.has(Leniency::CycleRepeats) {
            (0.0, "a whole number from 0")
        } else {
            (1.0, "a whole number from 1")
        };
        whole_within((code, b'L'), value, least..=f64::from(u32::MAX), allowed)
            .map(|number| number as u32)
    }

    /// The cycle's words: from the block, or kept from an earlier one.
    fn cycle_words(&mut self, code: Code, normal: usize) -> Result<CycleWords, Problem> {
        let kept = self.state.cycle;
        let spindle = if self.words.has(b'$') {
            self.spindle_number(code)?
        } else {
            kept.spindle
        };
        // Words stick from hole to hole; the level is that of before the first one.
        let words = CycleWords {
            level: kept.level.or(Some(self.state.current[normal])),
            r: self.word(b'R').or(kept.r),
            bottom: self.axis_word(normal).or(kept.bottom),
            p: self.word(b'P').or(kept.p),
            last_p: self.word(b'P').unwrap_or(kept.last_p),
            q: self.word(b'Q').or(kept.q),
            ijk: std::array::from_fn(|index| self.word(b"IJK"[index]).or(kept.ijk[index])),
            spindle,
        };
        self.state.cycle = words;
        Ok(words)
    }

    fn holes(&mut self, code: Code, repeats: u32) -> Result<(), Problem> {
        let normal = self.state.plane.axes()[2];
        let words = self.cycle_words(code, normal)?;
        if repeats == 0 {
            return Ok(());
        }
        // R and bottom have to be known; then the levels of the hole, and the count of its moves.
        let r = words.r.ok_or(Problem::WordMissing {
            code,
            what: "R, the clearance plane",
        })?;
        let bottom = words.bottom.ok_or(Problem::WordMissing {
            code,
            what: BOTTOM[normal],
        })?;
        let start = self.state.current;
        let began = words.level.unwrap_or(start[normal]);
        let hole = self.resolve_hole(code, &words, began, [r, bottom])?;
        let r = hole.r;
        self.check_moves(&hole, repeats)?;
        // From below R the tool first goes up to it.
        let target = self.target()?;
        if began < r {
            self.level(&hole, r, false);
        }
        // Holes are made in exact path mode, so that no corner is rounded at the bottom.
        let saved = self.state.path_control;
        if saved != PathControl::ExactPath {
            self.emit(CanonicalOp::SetMotionControlMode(PathControl::ExactPath));
        }
        let incremental_polar =
            !self.state.absolute && (self.words.has(b'@') || self.words.has(b'^'));
        for round in 1..=repeats {
            // Under G91 each repetition goes on by the same distance, under G90 it stays at its
            // place.
            let ahead = if self.state.absolute {
                1.0
            } else {
                f64::from(round)
            };
            if incremental_polar {
                // An angle leads on from where the last hole was.
                let place = self.target()?;
                self.hole(&hole, &place)?;
                continue;
            }
            self.hole(
                &hole,
                &std::array::from_fn(|axis| start[axis] + ahead * (target[axis] - start[axis])),
            )?;
        }
        if saved != PathControl::ExactPath {
            self.emit(CanonicalOp::SetMotionControlMode(saved));
            self.emit(CanonicalOp::SetNaiveCamTolerance(
                self.state.merge_tolerance,
            ));
        }
        Ok(())
    }

    /// A hole from R and bottom as programmed: under G91 they count from the level where the cycle
    /// began.
    fn resolve_hole(
        &self,
        code: Code,
        words: &CycleWords,
        began: f64,
        [r, bottom]: [f64; 2],
    ) -> Result<Hole, Problem> {
        // Under G91 R counts from the level at the start, and the bottom from R.
        let (r, bottom) = if self.state.absolute {
            (r, bottom)
        } else {
            (r + began, r + began + bottom)
        };
        if r < bottom {
            return Err(Problem::Cycle {
                message: "R is below the bottom of the hole",
            });
        }
        Ok(Hole {
            code,
            plane: self.state.plane,
            normal: self.state.plane.axes()[2],
            r,
            bottom,
            // G98 returns to the level at the start, G99 to R.
            clear: if self.state.retract_to_start {
                began.max(r)
            } else {
                r
            },
            p: words.p,
            last_p: words.last_p,
            q: words.q,
            ijk: words.ijk,
            spindle: words.spindle,
        })
    }

    /// The cycle in force at a place, with the words that it has kept.
    pub(crate) fn cycle_at(&mut self, code: Code, place: Position) -> Result<(), Problem> {
        let normal = self.state.plane.axes()[2];
        let words = self.state.cycle;
        let (Some(r), Some(bottom)) = (words.r, words.bottom) else {
            return Err(Problem::WordMissing {
                code,
                what: "R and the bottom of the hole from a cycle before the pattern",
            });
        };
        let began = words.level.unwrap_or(self.state.current[normal]);
        let hole = self.resolve_hole(code, &words, began, [r, bottom])?;
        self.check_moves(&hole, 1)?;
        self.hole(&hole, &place)
    }

    /// One hole: across to it at the present level, or up to R on the way if that is higher (as
    /// recorded), down to R, and what the cycle does.
    fn hole(&mut self, hole: &Hole, place: &Position) -> Result<(), Problem> {
        let mut above = *place;
        above[hole.normal] = self.state.current[hole.normal].max(hole.r);
        self.check_target(&above)?;
        self.state.current = above;
        let said = if self.state.absolute {
            self.axes_with_words() & !(1 << hole.normal)
        } else {
            0
        };
        self.emit_named(CanonicalOp::StraightTraverse(above), said);
        if above[hole.normal] != hole.r {
            self.level(hole, hole.r, false);
        }
        self.drill(hole)
    }

    /// Refuses cycles of endless pecks and repetitions.
    fn check_moves(&self, hole: &Hole, repeats: u32) -> Result<(), Problem> {
        let limit = self.config.limits.cycle_moves;
        // Three moves a peck and a few for the hole are an upper bound.
        let pecks = hole
            .q
            .filter(|q| *q > 0.0)
            .map_or(0.0, |q| (hole.r - hole.bottom) / q);
        if f64::from(repeats) * (pecks * 3.0 + 4.0) > f64::from(limit) {
            Err(Problem::CycleTooLong { limit })
        } else {
            Ok(())
        }
    }

    pub(crate) fn move_to(&mut self, end: Position, feed: bool) {
        self.state.current = end;
        self.emit(if feed {
            CanonicalOp::StraightFeed(end)
        } else {
            CanonicalOp::StraightTraverse(end)
        });
    }
}
