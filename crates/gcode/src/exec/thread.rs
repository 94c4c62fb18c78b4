//! G76: a thread cut on a lathe in several passes.

use super::Exec;
use crate::codes::{Code, whole};
use crate::exec::words::whole_within;
use crate::ops::{CanonicalOp, Plane};
use crate::problem::Problem;
use lostmotion_base::math;
use lostmotion_base::units::rad;

/// Operations that one pass makes at most.
const OPS_PER_PASS: f64 = 12.0;

/// A thread along Z; lengths in program units.
#[derive(Clone, Copy, Debug)]
struct Thread {
    /// Distance per revolution.
    pitch: f64,
    /// X of the drive line, where the tool is at the beginning.
    drive: f64,
    /// Direction of the cut in X: 1 for an inside thread, -1 for an outside one.
    outwards: f64,
    /// X of the thread's crest.
    crest: f64,
    /// Z of start and end.
    ends: [f64; 2],
    /// Full depth.
    depth: f64,
    /// Z per depth, from the angle of the compound slide.
    slide: f64,
    /// Length of the entry and of the exit taper; 0 is none.
    tapers: [f64; 2],
}

/// G76. P pitch, I from the drive line to the crest, J first depth, K full depth, R degression, Q
/// angle of the slide, H spring passes, E length of the tapers, L which ends have them.
pub(crate) fn thread(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.motion = Some(code);
    if exec.state.plane != Plane::Zx {
        return Err(Problem::Cycle {
            message: "G76 needs the ZX plane (G18)",
        });
    }
    if exec.state.spindle.clockwise.is_none() {
        return Err(Problem::SpindleStopped { code });
    }
    let mut end = exec.target()?;
    let [drive, _, start, ..] = exec.state.current;
    let pitch = exec.positive(code, b'P', "P, the pitch")?;
    // Depths and the crest are along X: halved where X is a diameter.
    let first = exec.radial(exec.positive(code, b'J', "J, the depth of the first pass")?);
    let depth = exec.radial(exec.positive(code, b'K', "K, the depth of the thread")?);
    let crest = exec.radial(exec.need(b'I', code, "I, from the drive line to the crest")?);
    if crest == 0.0 {
        return Err(Problem::WordOutOfRange {
            code,
            letter: 'I',
            value: crest,
            allowed: "other than zero",
        });
    }
    // The degression starts at the first depth and must grow to the full one.
    if depth <= first {
        return Err(Problem::Cycle {
            message: "the depth of the thread (K) has to be more than that of its first pass (J)",
        });
    }
    let angle = exec.word(b'Q').unwrap_or(0.0);
    // The infeed along the slide grows with tan Q, which has to stay bounded.
    if angle.abs() > 80.0 {
        return Err(Problem::WordOutOfRange {
            code,
            letter: 'Q',
            value: angle,
            allowed: "an angle from -80 to 80",
        });
    }
    let thread = Thread {
        pitch,
        drive,
        outwards: crest.signum(),
        crest: drive + crest,
        ends: [start, end[2]],
        depth,
        slide: math::tan(rad(angle)),
        tapers: exec.tapers(code)?,
    };
    exec.passes(code, &thread, first)?;
    end[0] = drive;
    exec.move_to(end, false);
    Ok(())
}

impl Exec<'_> {
    fn positive(&self, code: Code, letter: u8, what: &'static str) -> Result<f64, Problem> {
        let value = self.need(letter, code, what)?;
        let allowed = "greater than zero";
        if value > 0.0 {
            Ok(value)
        } else {
            Err(Problem::WordOutOfRange {
                code,
                letter: char::from(letter),
                value,
                allowed,
            })
        }
    }

    /// A length in X, which is a diameter in G7.
    fn radial(&self, length: f64) -> f64 {
        if self.state.diameter {
            0.5 * length
        } else {
            length
        }
    }

    fn tapers(&self, code: Code) -> Result<[f64; 2], Problem> {
        let length = self.word(b'E').unwrap_or(0.0);
        if length < 0.0 {
            return Err(Problem::WordOutOfRange {
                code,
                letter: 'E',
                value: length,
                allowed: "zero or more",
            });
        }
        let value = self.word(b'L').unwrap_or(0.0);
        match whole(value) {
            Some(0.0) => Ok([0.0, 0.0]),
            Some(1.0) => Ok([length, 0.0]),
            Some(2.0) => Ok([0.0, length]),
            Some(3.0) => Ok([length; 2]),
            _ => Err(Problem::WordOutOfRange {
                code,
                letter: 'L',
                value,
                allowed: "0 to 3",
            }),
        }
    }

    /// All passes: each is deeper by the law of degression, the last ones are at full depth.
    fn passes(&mut self, code: Code, thread: &Thread, first: f64) -> Result<(), Problem> {
        // R = 1 gives equal steps in depth.
        let degression = self.word(b'R').unwrap_or(1.0).max(1.0);
        let value = self.word(b'H').unwrap_or(0.0);
        let springs = whole_within((code, b'H'), value, 0.0.., "a whole number from 0")?;
        let limit = self.config.limits.cycle_moves;
        // Number of passes: depth / first to the power of R.
        if (math::pow(thread.depth / first, degression) + springs + 2.0) * OPS_PER_PASS
            > f64::from(limit)
        {
            return Err(Problem::CycleTooLong { limit });
        }
        // Pass n goes to first * n^(1 / R): with R = 2 every pass removes the same area.
        let mut depth = first;
        let mut pass = 1.0;
        while depth < thread.depth {
            self.pass(thread, depth);
            pass += 1.0;
            depth = first * math::pow(pass, 1.0 / degression);
        }
        // The last pass at full depth, then spring passes.
        for _ in 0..=(springs as u64) {
            self.pass(thread, thread.depth);
        }
        Ok(())
    }

    fn pass(&mut self, thread: &Thread, depth: f64) {
        // X of clearance, cut, and the end of a taper.
        let clear = thread.drive - thread.outwards * (thread.depth - depth);
        let cut = thread.crest + thread.outwards * depth;
        let out = cut - thread.outwards * thread.depth;
        // The compound slide shifts start and end along Z, so that one flank of the tool cuts.
        let [start, end] = [
            thread.ends[0] - depth * thread.slide,
            thread.ends[1] + (thread.depth - depth) * thread.slide,
        ];
        let way = (end - start).signum();
        let [entry, exit] = thread.tapers;
        // Infeed, entry taper, the thread, exit taper, back at clearance.
        self.lathe(clear, start, false);
        if entry == 0.0 {
            self.lathe(cut, start, false);
        }
        // The feed is tied to the spindle: an override would spoil the pitch.
        self.emit(CanonicalOp::FeedOverride(false));
        if entry > 0.0 {
            self.emit(CanonicalOp::StartSpeedFeedSync(tapered(thread, entry)));
            self.lathe(out, start, true);
            self.lathe(cut, start + way * entry, true);
        }
        self.emit(CanonicalOp::StartSpeedFeedSync(thread.pitch));
        self.lathe(cut, end - way * exit, true);
        if exit > 0.0 {
            self.emit(CanonicalOp::StartSpeedFeedSync(tapered(thread, exit)));
            self.lathe(out, end, true);
        }
        self.emit(CanonicalOp::StopSpeedFeedSync);
        self.lathe(clear, end, false);
        self.emit(CanonicalOp::FeedOverride(self.state.feed_override));
    }

    fn lathe(&mut self, x: f64, z: f64, feed: bool) {
        let mut end = self.state.current;
        (end[0], end[2]) = (x, z);
        self.move_to(end, feed);
    }
}

/// Distance per revolution along a taper, so that Z keeps the pitch.
fn tapered(thread: &Thread, length: f64) -> f64 {
    thread.pitch * math::hypot(length, thread.depth) / length
}
