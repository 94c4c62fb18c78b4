//! The record of one crossing of the gap: the motor's measured position and the current that drove
//! it.
//!
//! Nothing else is kept: with the motor's motion known, the load behind it follows from its own
//! equations, and what servo, references and compensator did meanwhile is all in that motion. The
//! ticks around leaving and reaching a flank are kept singly. In between, where the motor is alone,
//! samples are merged in pairs when they become many; so a crossing of any length fits into the
//! same memory and takes the same time to read. Where the motor stands samples become longer the longer
//! it does, so that a rest leaves room for what came before it: a load that came to rest between its
//! flanks may have touched one. A motor that creeps on stands in samples in which it moves little: the more it creeps,
//! the more that is.

use super::lanes::WARM_UP;
use lostmotion_base::Clock;
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;
use std::mem::take;

/// Servo ticks kept singly from before a crossing: 50 ms, for the warm-up and some more.
const TICKS_BEFORE: usize = 200;
/// Servo ticks kept singly from the end of a crossing: 100 ms. A choice: the contact has to lie in
/// it; more cost memory and time of the reading.
const TICKS_AT_END: usize = 400;
/// Servo ticks by which the observed torque lags: 1/190 s, the time constant of its low pass.
const OBSERVER_LAG_TICKS: usize = 21;
/// Bound of the samples in between. A choice: bounds memory and work; at their longest they span 16
/// s.
const SAMPLES_BETWEEN: usize = 128;
/// Samples of a window that is complete, at most.
const MOST_SAMPLES: usize = TICKS_BEFORE + SAMPLES_BETWEEN + TICKS_AT_END;
/// Motion of the motor in a sample up to which it stands, rad: 0.06 um on a screw of 20 mm. A choice:
/// a servo that brings an axis to its place creeps for long, and this is a hundredth of a small gap.
const STANDING_RAD: f64 = 2e-5;
/// The same where a motor that creeps has filled the window, at most, rad: 1 um on a screw of 20 mm. A choice: some
/// per cent of the gaps over which one creeps so far.
const MOST_STANDING_RAD: f64 = 16.0 * STANDING_RAD;
/// Samples that have to become free for such a motion to be let pass. A choice: a quarter; fewer have it asked again
/// and again.
const LEAST_FREED: usize = SAMPLES_BETWEEN / 4;
/// Part of the time for which the motor has stood that a sample may last. A choice: a load that still
/// moves is followed to some per cent of that time.
const STANDING_SHARE: u32 = 8;
/// Servo ticks in a sample up to which a contact shows in it: 1 ms. A choice: as long as what is read of
/// a contact.
const SHOWING_TICKS: u32 = 4;
/// Bound of the servo ticks in a sample: 128 ms, which makes a window of 16 s. A longer crossing is
/// not read.
const LONGEST_SAMPLE_TICKS: u32 = 512;

/// The motor over a sample: position at its end (rad), mean current (A), length in servo ticks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Sample {
    pub(super) position: f64,
    pub(super) current: f64,
    /// Current at the start less that at the end, A.
    pub(super) fall: f64,
    pub(super) ticks: u32,
}

/// One servo tick: what a sample has of it, and the observed torque behind the motor (N m).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Tick {
    pub(super) position: f64,
    pub(super) current: f64,
    pub(super) fall: f64,
    pub(super) seen: f64,
    /// Whether the load stands, by the gapless twin.
    pub(super) stands: bool,
}

impl Tick {
    fn sample(&self) -> Sample {
        Sample {
            position: self.position,
            current: self.current,
            fall: self.fall,
            ticks: 1,
        }
    }
}

/// The last ticks, from which a window begins.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Recent {
    ticks: Vec<Tick>,
    /// Where the oldest is once there are [`TICKS_BEFORE`]: the next one takes its place.
    #[serde(default)]
    oldest: usize,
}

impl Recent {
    /// Room for all that is kept.
    pub(super) fn make_room(&mut self) {
        self.ticks
            .reserve_exact(TICKS_BEFORE.saturating_sub(self.ticks.len()));
    }

    /// Adds a tick; the oldest one is dropped.
    #[inline(always)]
    pub(super) fn push(&mut self, tick: Tick) {
        if self.ticks.len() < TICKS_BEFORE {
            self.ticks.push(tick);
            return;
        }
        if let Some(oldest) = self.ticks.get_mut(self.oldest) {
            *oldest = tick;
        }
        self.oldest += 1;
        if self.oldest >= TICKS_BEFORE {
            self.oldest = 0;
        }
    }

    /// The oldest first.
    fn iter(&self) -> impl Iterator<Item = &Tick> {
        let (newer, older) = self.ticks.split_at(self.oldest.min(self.ticks.len()));
        older.iter().chain(newer)
    }
}

/// Samples around a crossing from one flank. It is used again for one crossing after the other, so that its
/// memory stays.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Window {
    /// Flank that carried the load at the start, -1 or 1.
    pub(super) side: i8,
    /// Torque that the shaft carried at the start, N m.
    pub(super) torque: f64,
    /// Whether the load stood at the start.
    pub(super) stands: bool,
    /// Whether the motor pulled the load off that flank at times during the warm-up, in which a reading
    /// takes it to lie there: it tells the gap then, but not the load.
    pub(super) unsettled: bool,
    /// Whether the flank that should carry the load changed again before it did.
    pub(super) wavered: bool,
    /// Whether a correction was in use when it was complete.
    pub(super) corrected: bool,
    /// Before the crossing and the way between; with `close` all of it.
    pub(super) samples: Vec<Sample>,
    /// The last ticks, singly.
    end: VecDeque<Sample>,
    /// Servo ticks of a merged sample.
    stride: u32,
    /// Servo ticks for which the motor has stood.
    standing: u32,
    /// Motion of the motor in a sample up to which it stands, rad.
    still: f64,
}

impl Window {
    /// Room for all that is ever kept.
    pub(super) fn make_room(&mut self) {
        self.samples
            .reserve_exact(MOST_SAMPLES.saturating_sub(self.samples.len()));
        // a tick joins the end before the oldest leaves it
        self.end
            .reserve_exact((TICKS_AT_END + 1).saturating_sub(self.end.len()));
    }

    /// Begins anew with the last ticks. Returns false where there are too few.
    pub(super) fn begin(&mut self, recent: &Recent, side: i8) -> bool {
        // the torque observed now is that of the start, a time constant ago
        let later = || recent.iter().skip(OBSERVER_LAG_TICKS);
        let (Some(first), Some(late)) = (recent.iter().next(), later().next()) else {
            return false;
        };
        self.clear();
        (self.side, self.torque, self.stands) = (side, late.seen, first.stands);
        self.unsettled = recent
            .iter()
            .zip(later())
            .take(WARM_UP)
            .any(|(tick, late)| !tick.stands && late.seen * f64::from(side) < 0.0);
        (self.stride, self.still) = (1, STANDING_RAD);
        self.samples.extend(recent.iter().map(Tick::sample));
        true
    }

    /// Forgets everything.
    pub(super) fn clear(&mut self) {
        let (mut samples, mut end) = (take(&mut self.samples), take(&mut self.end));
        samples.clear();
        end.clear();
        *self = Window {
            samples,
            end,
            ..Window::default()
        };
    }

    /// Adds a tick. Returns whether there was room for it.
    pub(super) fn push(&mut self, sample: Sample) -> bool {
        self.end.push_back(sample);
        // a tick that has left the end belongs to the way between
        if self.end.len() > TICKS_AT_END
            && let Some(old) = self.end.pop_front()
        {
            self.between(old);
        }
        self.stride <= LONGEST_SAMPLE_TICKS
    }

    /// Ends the window.
    pub(super) fn close(&mut self) {
        self.samples.extend(self.end.drain(..));
    }

    /// Whether a contact may be hidden in the way between, since its samples are long.
    pub(super) fn hides(&self) -> bool {
        self.stride > SHOWING_TICKS
    }

    /// Mean speed of the motor between two single ticks, rad/s; 0 where there are none.
    pub(super) fn mean_speed(&self, from: usize, to: usize) -> f64 {
        match (self.samples.get(from), self.samples.get(to)) {
            (Some(a), Some(b)) if to > from => {
                (b.position - a.position) / ((to - from) as f64 * Clock::SERVO.period_s())
            }
            _ => 0.0,
        }
    }

    /// How far the motor moves in a tick on average over the last ones, rad.
    pub(super) fn pace(&self) -> f64 {
        let last = &self.samples[self.samples.len().saturating_sub(TICKS_AT_END)..];
        let way = last
            .windows(2)
            .map(|pair| (pair[1].position - pair[0].position).abs())
            .sum::<f64>();
        way / last
            .iter()
            .map(|sample| f64::from(sample.ticks))
            .sum::<f64>()
            .max(1.0)
    }

    /// Its length, s, and the motor's largest speed over a sample, rad/s.
    pub(super) fn extent(&self) -> (f64, f64) {
        let period = Clock::SERVO.period_s();
        let speed = |pair: &[Sample]| {
            (pair[1].position - pair[0].position).abs() / (f64::from(pair[1].ticks) * period)
        };
        let time = self
            .samples
            .iter()
            .map(|sample| f64::from(sample.ticks))
            .sum::<f64>()
            * period;
        (time, self.samples.windows(2).map(speed).fold(0.0, f64::max))
    }

    /// Adds a sample of the way between, merged to the present stride.
    fn between(&mut self, sample: Sample) {
        // the ticks before the crossing stay single
        let between = self.samples.len() > TICKS_BEFORE;
        let stands = |from: Option<&Sample>, most: f64| {
            from.is_some_and(|from| (sample.position - from.position).abs() <= most)
        };
        self.standing = if stands(self.samples.last(), STANDING_RAD) {
            self.standing.saturating_add(1)
        } else {
            0
        };
        let ticks = if stands(self.samples.iter().nth_back(1), self.still) {
            self.stride.max(self.standing / STANDING_SHARE)
        } else {
            self.stride
        };
        match self.samples.last_mut() {
            Some(last) if between && last.ticks < ticks => *last = merged(last, &sample),
            _ => self.samples.push(sample),
        }
        if self.samples.len() >= TICKS_BEFORE + SAMPLES_BETWEEN
            && self
                .samples
                .last()
                .is_some_and(|last| last.ticks >= self.stride)
            && !self.let_creep()
        {
            // full: merge pairs, and from now on twice as many ticks
            let mut kept = TICKS_BEFORE;
            for at in (TICKS_BEFORE..self.samples.len()).step_by(2) {
                let first = self.samples[at];
                let second = self.samples.get(at + 1);
                self.samples[kept] = second.map_or(first, |second| merged(&first, second));
                kept += 1;
            }
            self.samples.truncate(kept);
            self.stride *= 2;
        }
    }

    /// Merges samples in which the motor creeps, of a window that is full. Returns whether that made room.
    fn let_creep(&mut self) -> bool {
        let full = self.samples.len();
        while self.still < MOST_STANDING_RAD {
            self.still *= 2.0;
            let (mut kept, mut standing) = (TICKS_BEFORE, 0);
            for at in TICKS_BEFORE..self.samples.len() {
                let sample = self.samples[at];
                let slow = STANDING_RAD * f64::from(sample.ticks);
                let moved = sample.position - self.samples[at - 1].position;
                standing = if moved.abs() <= slow {
                    standing + sample.ticks
                } else {
                    0
                };
                let most = self.stride.max(standing / STANDING_SHARE);
                let [from, last] = [self.samples[kept - 2], self.samples[kept - 1]];
                let joins = kept > TICKS_BEFORE
                    && last.ticks + sample.ticks <= most
                    && (sample.position - from.position).abs() <= self.still;
                if joins {
                    self.samples[kept - 1] = merged(&last, &sample);
                } else {
                    self.samples[kept] = sample;
                    kept += 1;
                }
            }
            self.samples.truncate(kept);
            if full - kept >= LEAST_FREED {
                return true;
            }
        }
        false
    }
}

/// Two consecutive samples as one: mean of the current, sum of its falls.
fn merged(first: &Sample, second: &Sample) -> Sample {
    // mean weighted by the lengths
    let [a, b] = [first.ticks, second.ticks].map(f64::from);
    Sample {
        position: second.position,
        current: (a * first.current + b * second.current) / (a + b),
        fall: first.fall + second.fall,
        ticks: first.ticks + second.ticks,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A window whose motor moves for some ticks behind the flank, and then stands or creeps on.
    fn window(moving: usize, resting: usize, creep_rad: f64) -> Window {
        let mut recent = Recent::default();
        let mut position = 0.0;
        let mut tick = |way: f64| {
            position += way;
            Sample {
                position,
                ticks: 1,
                ..Sample::default()
            }
        };
        for _ in 0..TICKS_BEFORE {
            recent.push(Tick {
                position: tick(1e-3).position,
                ..Tick::default()
            });
        }
        let mut window = Window::default();
        assert!(window.begin(&recent, 1));
        let moved = (0..moving).map(|_| 1e-4);
        let stood = (0..resting).map(|_| creep_rad);
        for way in moved.chain(stood).chain((0..TICKS_AT_END).map(|_| -1e-3)) {
            assert!(window.push(tick(way)));
        }
        window.close();
        window
    }

    #[test]
    fn a_rest_leaves_what_came_before_it_as_it_is() {
        // a second and ten seconds of rest, and one in which the servo creeps to its place
        for (resting, creep) in [(4000, 0.0), (40_000, 0.0), (4000, 2e-7)] {
            let window = window(100, resting, creep);
            assert!(!window.hides(), "{resting} {creep}");
            // the hundred ticks before the rest, in samples in which a contact shows
            let before = &window.samples[..TICKS_BEFORE + 100 / SHOWING_TICKS as usize];
            assert!(
                before.iter().all(|sample| sample.ticks <= SHOWING_TICKS),
                "{resting} {creep}"
            );
            assert!(window.samples.len() <= MOST_SAMPLES);
            let ticks: u32 = window.samples.iter().map(|sample| sample.ticks).sum();
            assert_eq!(ticks as usize, TICKS_BEFORE + 100 + resting + TICKS_AT_END);
        }
        // a motor that moves all the time leaves no room
        assert!(window(100, 4000, 1e-4).hides());
    }

    #[test]
    fn a_motor_that_creeps_over_a_gap_leaves_what_came_before_as_it_is() {
        const MOVED: usize = 40;
        // as far as 200 and 800 times the motion in which it stands, as a servo brings a load back from the far flank
        for (resting, creep) in [(4000, 1e-6), (4000, 4e-6)] {
            let window = window(MOVED, resting, creep);
            assert!(!window.hides(), "{creep}");
            let before = &window.samples[..TICKS_BEFORE + MOVED / SHOWING_TICKS as usize];
            assert!(
                before.iter().all(|sample| sample.ticks <= SHOWING_TICKS),
                "{creep}"
            );
            assert!(window.samples.len() <= MOST_SAMPLES);
            let ticks: u32 = window.samples.iter().map(|sample| sample.ticks).sum();
            assert_eq!(
                ticks as usize,
                TICKS_BEFORE + MOVED + resting + TICKS_AT_END
            );
        }
    }

    #[test]
    fn a_flank_that_was_pulled_off_during_the_warm_up_is_not_settled() {
        let begun = |pulled: std::ops::Range<usize>, stands: bool| {
            let mut recent = Recent::default();
            for tick in 0..TICKS_BEFORE {
                recent.push(Tick {
                    seen: if pulled.contains(&tick) { -0.1 } else { 0.1 },
                    stands,
                    ..Tick::default()
                });
            }
            let mut window = Window::default();
            assert!(window.begin(&recent, 1));
            window.unsettled
        };
        assert!(!begun(0..0, false));
        assert!(begun(60..70, false));
        // the observer lags: what it shows first went before, what it shows last is the crossing itself
        assert!(!begun(0..OBSERVER_LAG_TICKS, false));
        assert!(!begun(WARM_UP + OBSERVER_LAG_TICKS..TICKS_BEFORE, false));
        // a load at rest lies where friction holds it, whatever its shaft carries
        assert!(!begun(60..70, true));
    }
}
