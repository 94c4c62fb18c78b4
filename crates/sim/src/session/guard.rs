//! Whether correcting makes the contour better: of a machine whose compensators foresee where their
//! loads would be without a correction and with it.
//!
//! A drive knows its axis alone, and the contour is made by all of them: what the gap of one hides
//! of its overshoot may be the best that there is. The control has the path and is told what each
//! drive foresees; so it measures both contours, and lets the drives correct as long as theirs is
//! not the worse one.
//!
//! ```text
//! better   rms without^2 - rms with^2 >= 0.5 rms (without - with)^2 over 0.3 s in which an axis came back    and peak with <= 1.01 peak without + 0.25 um
//! no worse rms with <= rms without over 2 s in which each axis came back twice   and the same
//! worse    rms with > 1.01 rms without, or peak with > 1.02 peak without + 0.5 um
//! ```
//! Where what a correction changes has nothing to do with the other errors, the squares differ by the
//! square of the change: half of it is clear, also where the axes lag by far more than the gap.
//!
//! An axis that has rested for 2 s need not come back: the tool's plunges before the others are known. While it rests and
//! others come and go its error is across theirs: it is not waited for if it is not known, and its load is put in
//! its place as soon as it is, whatever the others know.
//!
//! Without a memory nothing is corrected before it is certainly better or no worse. Then a rehearsal with
//! what the drives know by that time says how far, and is asked again each time that they know clearly
//! more. With a memory it is corrected from the start as far as a rehearsal says. Either way it is until it
//! is worse than what is foreseen and what was rehearsed without a correction. Axes learn their gaps one after the other, and foresee the last
//! seconds then: commands are held until all are known. Only what the drives know enters: their learned loads and gaps,
//! their references and motors.

use super::contours::{Contours, Pair, Returns};
use super::frame::STANDSTILL_PER_S;
use super::outputs::AxisInfo;
use super::skips::{PathPlace, Skips};
use crate::machine::{Machine, Memory};
use crate::motion::Modes;
use crate::observer::ForeseenContour;
use lostmotion_base::Clock;
use lostmotion_base::units::UM_PER_MM;
use lostmotion_contour::ContourTracker;
use lostmotion_plan::Sample;
use std::collections::VecDeque;

/// Part of the squares of what is changed by which the squares of the error have to be less for it to
/// be clearly better, and the time over which it has to be, s. A choice: half is far beyond what foreseeing errs
/// by; corners, where the peak is, are seen by the rehearsal that follows.
const CLEARLY: (f64, f64) = (0.5, 0.3);
/// Time over which the contour has to be no worse, s, and how often each axis has to come back. A
/// choice: as often as on a closed figure.
const NO_WORSE: (f64, u32) = (2.0, 2);
/// Time before which nothing counts as worse, s; with a memory, as long as for `NO_WORSE`. A choice: at
/// the start of a motion nobody knows where a load lies in its gap.
const LEAST_S: f64 = 1.0;
/// RMS with a correction over that without from which on it is worse. A choice: half of what counts
/// as worse in the study.
const WORSE_RMS: f64 = 1.01;
/// How often each axis comes back, and the least time, s, until what was foreseen is forgotten while nothing
/// was corrected yet; twice as often each time. A choice: loads are learned within a few reversals, and
/// what was foreseen before was wrong.
const PATIENCE: (u32, f64) = (3, 1.0);
/// Peak with a correction over that without up to which correcting begins, and what may be on top, mm. A
/// choice: half of what counts as worse.
const BETTER_PEAK: (f64, f64) = (1.01, 2.5e-4);
/// Peak with a correction over that without from which on it is worse, and what may be on top, mm: what
/// counts as worse in the study.
const WORSE_PEAK: (f64, f64) = (1.02, 5e-4);

/// What a rehearsal says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Rehearsed {
    /// The part of the correction with which the contour is no worse, 0 for none.
    pub(super) share: f64,
    /// Where nothing is corrected all the same.
    pub(super) skips: Skips,
    /// Mean square (mm2) and peak (mm) of the contour error without a correction.
    pub(super) without: [f64; 2],
}

/// Who rehearses a variant, by its number, whose drives know this; `None` where nothing is to be said.
/// While they learn, with the time of the motion so far, s.
pub(crate) type Rehearse<'a> = dyn Fn(usize, &Memory, Option<f64>) -> Option<Rehearsed> + Sync + 'a;

/// Who rehearses the variants of a machine.
#[derive(Clone, Copy)]
pub(crate) struct Rehearsals<'a> {
    pub(crate) machine: &'a Machine,
    pub(crate) rehearse: &'a Rehearse<'a>,
}

/// What the drives of a variant foresee, measured on the path.
#[derive(Debug)]
pub(super) struct Guard {
    contours: Contours,
    returns: Returns,
    /// What could not be measured yet, since an axis was not known; the oldest first.
    held: VecDeque<Held>,
    /// How often each axis comes back until what was measured is forgotten while nothing is corrected.
    patience: u32,
    /// Whether it ever corrected.
    corrected: bool,
    corrects: bool,
    /// Whether it did from the start.
    from_start: bool,
    /// Whether an axis is not known that the others have to wait for.
    held_back: bool,
    /// The part of their corrections that drives use while they correct.
    part: f64,
    /// Whether that is all that it says: of a machine that is rehearsed.
    fixed: bool,
    /// What a rehearsal said of the machine without a correction: mean square (mm2) and peak (mm).
    rehearsed: Option<[f64; 2]>,
    /// Where nothing is corrected, the place of the newest command, and whether it lies there.
    skips: Skips,
    place: PathPlace,
    skipping: bool,
    /// What the drives knew when a rehearsal was asked last while they learned.
    asked: Option<Memory>,
    /// How often one may be asked yet.
    asks_left: u32,
}

/// A command of the plan and what was foreseen for it.
#[derive(Clone, Debug)]
struct Held {
    sample: Sample,
    /// What is not known is not a number.
    pair: Pair,
    /// By axis, a bit where it came back.
    returned: u32,
}

impl Held {
    fn is_known(&self) -> bool {
        self.pair[0].0.iter().all(|place| !place.is_nan())
    }

    /// A load that is not known stays where it is while its axis stands.
    fn standing(mut self) -> Held {
        let Sample {
            position, velocity, ..
        } = &self.sample;
        for joints in &mut self.pair {
            for ((joint, place), speed) in joints.0.iter_mut().zip(position.0).zip(velocity.0) {
                if joint.is_nan() && speed.abs() <= STANDSTILL_PER_S {
                    *joint = place;
                }
            }
        }
        self
    }
}

/// Rehearsals of a variant while its drives learn, at most. A choice: the gaps of two axes settle within
/// some readings, and each takes as long as a part of the program.
const MOST_ASKED: u32 = 8;
/// Part of the largest gap of the axes by which one has to change to be rehearsed again. A choice: a gap told
/// 3 % too large hides a peak that is 4 % higher (20261124-15).
const NEWS: f64 = 0.015;

/// Whether drives know clearly more than before: a load, a gap that changed, or that friction holds a load.
fn differs(before: &Memory, now: &Memory) -> bool {
    let half_gaps = now.axis.values().map(|axis| axis.learned.half_gap_rad);
    let news = NEWS * half_gaps.fold(0.0, f64::max);
    now.axis.iter().any(|(name, axis)| {
        before.axis.get(name).is_none_or(|before| {
            before.learned.floats != axis.learned.floats
                || (before.learned.half_gap_rad - axis.learned.half_gap_rad).abs() > news
        })
    })
}

/// Commands that are kept until all axes are known. A choice: as many as a drive recalls.
const MOST_HELD: usize = 4000;

impl Guard {
    /// Of so many axes; whether it corrects from the start.
    pub(super) fn new(axes: usize, corrects: bool) -> Guard {
        Guard {
            contours: Contours::default(),
            returns: Returns::new(axes),
            held: VecDeque::new(),
            patience: PATIENCE.0,
            corrected: corrects,
            corrects,
            from_start: corrects,
            held_back: false,
            part: 1.0,
            fixed: false,
            rehearsed: None,
            skips: Skips::default(),
            place: PathPlace::default(),
            skipping: false,
            asked: None,
            asks_left: MOST_ASKED,
        }
    }

    /// Whether a rehearsal may be asked while the drives learn: where it would correct but for that.
    pub(super) fn may_ask(&self) -> bool {
        let refused = self.asked.is_some() && self.part <= 0.0;
        self.asks_left > 0 && (self.corrects || refused)
    }

    /// Whether drives that know this by now know clearly more than when a rehearsal was asked last.
    pub(super) fn asks(&self, memory: &Memory) -> bool {
        let asked = self.asked.as_ref();
        asked.is_none_or(|asked| differs(asked, memory))
    }

    /// What a rehearsal says of drives that know this by now: how far it corrects from then on.
    pub(super) fn told(&mut self, memory: Memory, said: Option<Rehearsed>) {
        self.asks_left = self.asks_left.saturating_sub(1);
        self.asked = Some(memory);
        let Some(said) = said else { return };
        // what was foreseen of another correction is forgotten
        if said.skips != self.skips {
            self.contours.clear();
            self.returns.counted.fill(0);
        }
        self.corrects = said.share > 0.0;
        self.part = said.share;
        self.rehearsed = Some(said.without);
        self.skips = said.skips;
        // also where the newest command lies already
        self.reach(self.place);
    }

    /// Of a machine that is rehearsed with a part of its correction, but for some stretches.
    pub(super) fn fixed(axes: usize, part: f64, skips: Skips) -> Guard {
        Guard {
            part,
            fixed: true,
            skips,
            asks_left: 0,
            ..Guard::new(axes, true)
        }
    }

    /// Of a machine whose program was rehearsed: it corrects from the start, and as far as that says.
    pub(super) fn rehearsed(axes: usize, said: Rehearsed) -> Guard {
        Guard {
            part: said.share,
            rehearsed: Some(said.without),
            skips: said.skips,
            asks_left: 0,
            ..Guard::new(axes, said.share > 0.0)
        }
    }

    /// The newest command lies at this place of the path.
    pub(super) fn reach(&mut self, place: PathPlace) {
        self.place = place;
        self.skipping = self.skips.contain(place);
    }

    /// What is foreseen, for those who look on.
    pub(super) fn foreseen(&self, clock: Clock) -> ForeseenContour {
        let Contours {
            squares,
            peaks,
            time_s,
            ..
        } = self.contours;
        let count = (time_s / clock.period_s()).max(1.0);
        ForeseenContour {
            corrects: self.corrects,
            waits: self.held_back,
            measured_s: time_s,
            rms_um: squares.map(|sum| UM_PER_MM * (sum / count).max(0.0).sqrt()),
            max_um: peaks.map(|peak| UM_PER_MM * peak),
        }
    }

    /// The part of their corrections that the drives may use once it waits no longer.
    pub(super) fn part(&self) -> f64 {
        let taken_back = self.corrected && !self.corrects;
        if self.skipping || taken_back {
            0.0
        } else {
            self.part
        }
    }

    /// Whether it waits: for an axis that is not known, or to see that the contour gets better.
    pub(super) fn waits(&self) -> bool {
        self.held_back || !self.corrects
    }

    /// Whether an axis rests while others come and go.
    pub(super) fn is_aside(&self, axis: usize) -> bool {
        self.returns.is_aside(axis)
    }

    /// The part of their corrections that the drives may use.
    pub(super) fn share(&self) -> f64 {
        if self.waits() { 0.0 } else { self.part() }
    }

    /// Takes what is foreseen for a command of the plan, whose cycle takes `clock`.
    pub(super) fn take(
        &mut self,
        sample: &Sample,
        pair: &Pair,
        (axes, clock): (&[AxisInfo], Clock),
        (tracker, modes): (&ContourTracker, &Modes),
    ) {
        // what comes back counts from the start: it is of the path, not of what is foreseen
        let returned = self.returns.take(sample, axes, clock);
        // until an axis comes back, and while others do time and again, its load stays on its flank;
        // else one that is not known holds the others back: one set right alone can be worse than neither
        let mut pair = *pair;
        self.held_back = false;
        for (axis, (stays, info)) in self.returns.stays.iter().zip(axes).enumerate() {
            let unknown = pair[0][info.id].is_nan();
            // nothing begins just before one that is not known sets out
            self.held_back |= unknown && !self.corrects && self.returns.is_to_cut(axis);
            if *stays || unknown && self.returns.is_aside(axis) {
                pair.iter_mut()
                    .for_each(|joints| joints[info.id] = sample.position[info.id]);
            }
            self.held_back |= pair[0][info.id].is_nan();
        }
        // of a rehearsal nothing is decided by what is foreseen
        if self.fixed {
            return;
        }
        let command = Held {
            sample: *sample,
            pair,
            returned,
        };
        if self.held_back {
            if self.held.len() >= MOST_HELD {
                self.held.pop_front();
            }
            self.held.push_back(command);
            return;
        }
        // the path is measured in its order
        self.measure_held(clock, (tracker, modes));
        self.measure(&command, clock, (tracker, modes));
    }

    /// Takes what an axis foresees of the last commands, now that it is known; the last is the newest.
    pub(super) fn recall(&mut self, info: &AxisInfo, places: &[Option<[f64; 2]>]) {
        for (held, places) in self.held.iter_mut().rev().zip(places.iter().rev()) {
            let Some(places) = places else { continue };
            for (joints, place) in held.pair.iter_mut().zip(places) {
                if joints[info.id].is_nan() {
                    joints[info.id] = place * info.units_per_rad / info.units;
                }
            }
        }
    }

    /// Measures the commands that were held, if all axes are known of the newest.
    pub(super) fn catch_up(&mut self, clock: Clock, path: (&ContourTracker, &Modes)) {
        if self.held.back().is_some_and(Held::is_known) {
            self.measure_held(clock, path);
        }
    }

    /// Measures those of the held commands of which all axes are known, or stood.
    fn measure_held(&mut self, clock: Clock, path: (&ContourTracker, &Modes)) {
        for held in std::mem::take(&mut self.held) {
            let held = held.standing();
            if held.is_known() {
                self.measure(&held, clock, path);
            }
        }
    }

    /// The oldest command that is held.
    pub(super) fn oldest(&self) -> Option<&Sample> {
        self.held.front().map(|held| &held.sample)
    }

    /// Measures what is foreseen for a command.
    fn measure(
        &mut self,
        Held {
            sample,
            pair,
            returned,
        }: &Held,
        clock: Clock,
        path: (&ContourTracker, &Modes),
    ) {
        self.returns.count(*returned);
        // what is left out was rehearsed; drives foresee what they would do there
        if !self.skips.contain((sample.segment, sample.s)) {
            self.contours.measure(sample, pair, clock, path);
        }
    }

    /// Decides anew; to be asked at the same times of the motion whatever the chunks.
    pub(super) fn decide(&mut self) {
        if self.fixed {
            return;
        }
        let Contours {
            squares: [without, with],
            peaks: [highest, high],
            changed,
            count,
            time_s,
            ..
        } = self.contours;
        let seen = |times: u32, least_s: f64| time_s >= least_s && self.returns.came_back(times);
        let seen_all = seen(NO_WORSE.1, NO_WORSE.0);
        // a mass between two flanks foresees less well than the machine that was rehearsed
        let [rehearsed, rehearsed_peak] = self.rehearsed.unwrap_or_default();
        let least = without.max(rehearsed * count as f64);
        let no_worse = with <= WORSE_RMS * WORSE_RMS * least
            && high <= WORSE_PEAK.0 * highest.max(rehearsed_peak) + WORSE_PEAK.1;
        if self.corrects {
            self.corrected = true;
            let enough = if self.from_start {
                seen_all
            } else {
                time_s >= LEAST_S
            };
            self.corrects = no_worse || !enough;
            return;
        }
        // what was rehearsed and is worse stays as it is
        if self.rehearsed.is_some() && self.part <= 0.0 {
            return;
        }
        // the axis of the tool came back before the others were known
        let shown =
            |times: u32, least_s: f64| time_s >= least_s && self.returns.came_back_or_rests(times);
        // a rehearsal sees the corners of the others that come
        let returned = self.returns.counted.iter().any(|count| *count > 0);
        let clearly = without - with >= CLEARLY.0 * changed && returned && time_s >= CLEARLY.1;
        let peaks = high <= BETTER_PEAK.0 * highest + BETTER_PEAK.1;
        self.corrects =
            peaks && without > 0.0 && (clearly || with <= without && shown(NO_WORSE.1, NO_WORSE.0));
        // what was foreseen while the load was known less well is forgotten
        if !self.corrects && !self.corrected && seen(self.patience, PATIENCE.1) {
            self.patience = self.patience.saturating_mul(2);
            self.contours.clear();
            self.returns.counted.fill(0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::skips::RehearsedCommand;
    use super::*;
    use lostmotion_drive::Learned;
    use lostmotion_methods::AxisMemory;

    /// Both axes came back so often, over a time, with these mean squares and peaks.
    fn seen(corrects: bool, times: u32, time_s: f64, squares: [f64; 2], peaks: [f64; 2]) -> bool {
        let mut guard = Guard {
            contours: Contours {
                squares,
                peaks,
                changed: 1.0,
                time_s,
                ..Contours::default()
            },
            ..Guard::new(3, corrects)
        };
        guard.returns.turns = vec![(1.0, times), (-1.0, times), (0.0, 0)];
        guard.returns.counted = vec![times, times, 0];
        guard.returns.stays = vec![false, false, true];
        guard.decide();
        guard.share() > 0.0
    }

    #[test]
    fn nothing_is_corrected_before_it_is_seen_to_be_no_worse() {
        let (better, alike, peaks) = ([1.0, 0.25], [1.0, 0.99], [1.0, 1.0]);
        assert!(!seen(false, 0, 10.0, better, peaks));
        assert!(!seen(false, 1, 0.2, better, peaks));
        assert!(seen(false, 1, 0.4, better, peaks));
        assert!(!seen(false, 1, 10.0, alike, peaks));
        assert!(!seen(false, 2, 1.0, alike, peaks));
        assert!(seen(false, 2, 3.0, alike, peaks));
        assert!(!seen(false, 2, 3.0, [1.0, 1.01], peaks));
        assert!(!seen(false, 2, 3.0, better, [1.0, 1.05]));
    }

    #[test]
    fn what_corrects_from_the_start_does_until_it_is_seen_to_be_worse() {
        let (worse, peaks) = ([1.0, 1.1], [1.0, 1.0]);
        assert!(seen(true, 1, 10.0, worse, peaks));
        assert!(!seen(true, 2, 10.0, worse, peaks));
        assert!(seen(true, 2, 10.0, [1.0, 1.005], [1.0, 1.0203]));
        assert!(!seen(true, 2, 10.0, [1.0, 0.5], [1.0, 1.03]));
    }

    #[test]
    fn an_axis_beside_others_that_come_back_time_and_again_stays_on_its_flank() {
        let mut guard = Guard::new(2, false);
        let mut came = |axis: usize| {
            guard.returns.turns[axis].1 += 1;
            guard.returns.note(1 << axis);
            guard.returns.stays.clone()
        };
        assert_eq!(came(0), [false, true]);
        assert_eq!(came(1), [false, false]);
        // two of one to one of the other
        for axis in [0, 0, 1, 0, 0] {
            assert_eq!(came(axis), [false, false]);
        }
        // the first alone, until the other comes back
        assert_eq!(came(0), [false, true]);
        assert_eq!(came(1), [false, false]);
    }

    #[test]
    fn what_was_foreseen_first_is_forgotten_after_some_returns() {
        let mut guard = Guard {
            contours: Contours {
                squares: [1.0, 0.5],
                peaks: [1.0, 2.0],
                time_s: 1.5,
                ..Contours::default()
            },
            ..Guard::new(2, false)
        };
        guard.returns.counted = vec![2, 3];
        guard.returns.stays = vec![false, false];
        guard.decide();
        assert!(guard.contours.time_s > 0.0 && guard.patience == 3);
        guard.returns.counted = vec![3, 3];
        guard.decide();
        assert!(guard.contours.time_s == 0.0 && guard.patience == 6 && guard.share() == 0.0);
    }

    #[test]
    fn a_rehearsal_says_how_far_to_correct_and_what_there_is_without() {
        let mut guard = Guard::rehearsed(2, said(0.75));
        assert_eq!(guard.share(), 0.75);
        // worse than what a mass between two flanks foresees, not than what was rehearsed
        guard.contours = Contours {
            squares: [100.0, 150.0],
            peaks: [1.0, 1.1],
            count: 100,
            time_s: 10.0,
            ..Contours::default()
        };
        guard.returns.counted = vec![3, 3];
        guard.returns.stays = vec![false, false];
        guard.decide();
        assert_eq!(guard.share(), 0.75);
        guard.contours.squares[1] = 210.0;
        guard.decide();
        assert_eq!(guard.share(), 0.0);
        // what was worse when rehearsed stays as it is, whatever is foreseen
        let mut guard = Guard::rehearsed(2, said(0.0));
        guard.contours.squares = [100.0, 1.0];
        guard.contours.time_s = 10.0;
        guard.returns.counted = vec![3, 3];
        guard.decide();
        assert_eq!(guard.share(), 0.0);
    }

    /// The drive of an axis knows this half gap, rad.
    fn knows(half_gap_rad: f64) -> Memory {
        let axis = AxisMemory {
            learned: Learned {
                half_gap_rad,
                ..Learned::default()
            },
            ..AxisMemory::default()
        };
        let mut memory = Memory::default();
        memory.axis.insert("x".to_owned(), axis);
        memory
    }

    fn said(share: f64) -> Rehearsed {
        Rehearsed {
            share,
            skips: Skips::default(),
            without: [2.0, 1.2],
        }
    }

    #[test]
    fn a_rehearsal_is_asked_while_drives_learn_each_time_that_they_know_more() {
        let mut guard = Guard::new(2, false);
        assert!(!guard.may_ask());
        guard.corrects = true;
        assert!(guard.may_ask() && guard.asks(&knows(1e-3)));
        // where nothing is to be said it goes by what is foreseen
        guard.told(knows(1e-3), None);
        assert!(
            guard.share() == 1.0 && !guard.asks(&knows(1.01e-3)) && guard.asks(&knows(1.02e-3))
        );
        for _ in 1..MOST_ASKED {
            assert!(guard.may_ask());
            guard.told(knows(1e-3), None);
        }
        assert!(!guard.may_ask());
        // with a memory it was asked before
        let guard = Guard::rehearsed(2, said(1.0));
        assert!(guard.share() == 1.0 && !guard.may_ask());
    }

    #[test]
    fn what_is_rehearsed_while_learning_says_how_far_to_correct() {
        let mut guard = Guard {
            corrects: true,
            ..Guard::new(2, false)
        };
        guard.contours.squares = [1.0, 0.5];
        guard.told(knows(1e-3), Some(said(0.5)));
        assert!(guard.share() == 0.5 && guard.contours.squares == [1.0, 0.5]);
        guard.told(knows(2e-3), Some(said(0.0)));
        assert_eq!(guard.share(), 0.0);
        // whatever is foreseen then, until a rehearsal with more says something else
        guard.contours.squares = [100.0, 1.0];
        guard.contours.time_s = 10.0;
        guard.returns.counted = vec![3, 3];
        guard.decide();
        assert!(guard.share() == 0.0 && guard.may_ask());
        guard.told(knows(3e-3), Some(said(1.0)));
        assert_eq!(guard.share(), 1.0);
    }

    #[test]
    fn a_stretch_that_is_left_out_is_so_where_the_program_is_by_then() {
        let mut steps: Vec<RehearsedCommand> = (0..100)
            .map(|number| RehearsedCommand {
                place: (0, f64::from(number)),
                squares: [1.0, 0.5],
                returns: false,
            })
            .collect();
        steps[50].squares[1] = 9.0;
        let skips = Skips::default().widened(&steps, 2.0, 0.05, true).unwrap();
        let mut guard = Guard {
            corrects: true,
            ..Guard::new(2, false)
        };
        guard.reach((0, 50.0));
        assert_eq!(guard.share(), 1.0);
        guard.told(knows(1e-3), Some(Rehearsed { skips, ..said(1.0) }));
        assert_eq!(guard.share(), 0.0);
        guard.reach((0, 60.0));
        assert_eq!(guard.share(), 1.0);
    }

    #[test]
    fn an_axis_that_came_back_and_is_not_known_holds_the_others_back() {
        let guard = Guard {
            held_back: true,
            ..Guard::new(2, true)
        };
        assert!(guard.share() == 0.0 && Guard::new(2, true).share() == 1.0);
    }
}
