//! Position lost after a reversal: at once, as a gap loses it, or along the travel, as pre-sliding
//! friction and give do.
//!
//! While the load moves one way, motor less load tends to one side; after a reversal it goes to the
//! other one. A gap goes over before the load moves at all. What saturates along the load's travel
//! follows Dahl's law, whose solution in one direction is an exponential:
//!
//! ```text
//! motor - load = offset + step s / 2 + travel_lost z / 2,    dz / dx = (s - z) / length
//! ```

use super::followed::Followed;
use super::load_off::{ALONE_SHARE, MATTERS_SHARE, MOST_GIVE_S2, VARIES_SHARE};
use super::squares::{Squares, SquaresFit, jackknife};
use super::{BodyLog, Figure, LoadOff, Motion, Rates, RigidBody};
use crate::body::motion::noise_of;
use crate::rounding::{Rounded, Row};
use serde::Serialize;

/// Deviations of the load's noise that its place has to move by to count as moving. A choice.
const MOVES_FROM: f64 = 6.0;
/// Part of the motor's speed by which the load's is off while the motor crosses a gap. A choice.
const CROSSING_SHARE: f64 = 0.5;
/// Half windows for which the motor has to have pressed until the load no longer bounces. A choice.
const SETTLES_WINDOWS: usize = 4;
/// Part of the deceleration that friction holds from which on the load may be loose: part of the
/// friction belongs to the motor, and the wind-up shrinks. A choice.
const HELD_PART: f64 = 0.5;
/// Part of the usual acceleration that the motor may slow down with where nobody knows the friction. A choice:
/// above what noise makes of a steady speed.
const UNKNOWN_SHARE: f64 = 0.05;
/// Deceleration that any friction holds, m/s^2 or rad/s^2. A choice: two thousandths of the weight.
const ANY_HOLDS: f64 = 0.02;
/// Part of the usual acceleration with which the motor has to speed up to have caught a loose load. A
/// choice: above what noise makes of a steady speed.
const CATCHES_SHARE: f64 = 0.1;
/// Lengths that are tried at a time.
const LENGTHS: usize = 33;
/// Shortest length tried, in parts of the load's range of travel, where its noise is smaller still.
const SHORTEST: f64 = 1e-6;
/// Times the length by which 95 % of the loss is there.
const SATURATED: f64 = 3.0;
/// What is left of the log's beginning where it counts no more.
const FADED: f64 = 1e-3;
/// Blocks over which it has to fade to be told. A choice: two without the one that is left out.
const FADES_OVER: usize = 3;
/// How often the lengths are narrowed down. A choice: each time by a factor of three at least.
const LOOKS: usize = 8;
/// Travel behind a reversal that tells a length, in times of the travel to 95 %. A choice: the loss is
/// complete in the second half, and its size is told there.
const TELLS: f64 = 3.0;

const OFFSET: usize = 0;
const STEP: usize = 1;
const ALONG: usize = 2;
const START: usize = 3;
/// Where the load was put right, what is left of that.
const PLACE: usize = 4;
/// A load that is read later than its motor is behind by that much of its speed.
const SPEED: usize = 5;
/// Beside it what winds the shaft up while the axis speeds up, which is when it is slow.
const ACCELERATION: usize = 6;
const COEFFICIENTS: usize = 7;

/// What is lost after a reversal, at the load.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LostMotion {
    /// All that is lost after long travel.
    pub total: Figure,
    /// What is lost at once, as by a gap.
    pub step: Figure,
    /// What is lost along the travel.
    pub along: Figure,
    /// Travel after which 95 % of it is lost.
    pub saturates_after: f64,
    /// Lengths that explain the log nearly as well, as travel to 95 %.
    pub saturates_between: [f64; 2],
    /// Reversals of the load.
    pub reversals: usize,
    /// Residual, root mean square.
    pub rms: f64,
    /// Whether a step alone explains the log as well.
    pub is_step: bool,
}

/// Fits how position is lost after the load's reversals.
///
/// `body` tells the friction that keeps the load on its flank while the motor slows down; without it only
/// rows count in which the motor speeds up or keeps its speed.
///
/// # Errors
/// What is missing: no load's position, no reversal, a load that does not move beyond its noise; a loss that
/// hides in what lateness of the load makes; a load ahead of its motor.
pub fn fit_lost_motion(log: &BodyLog, body: Option<&RigidBody>) -> Result<LostMotion, String> {
    if log.load.is_empty() {
        return Err(
            "the log has no load's position (a linear scale): lost motion is not told by it"
                .to_owned(),
        );
    }
    let noise = noise_of(&log.load);
    let holds = body.and_then(RigidBody::held_deceleration);
    let rows = Rows::of(log, MOVES_FROM * noise, holds);
    if rows.followed.reversals == 0 {
        return Err("the load never turns round: move it to and fro".to_owned());
    }
    let unseen_s = match log.load_off().filter(|off| off.late_s != 0.0) {
        // What is left of lateness that was taken off.
        Some(off) => 0.5 * (off.late_interval_s[1] - off.late_interval_s[0]),
        None => log.lateness_s,
    };
    let presumed = match loss(&rows, noise, Late::Presumed(unseen_s)) {
        Err(why @ (Untold::Reversed | Untold::Other(_))) => return Err(why.into_words()),
        presumed => presumed,
    };
    let width = |found: &Loss| found.lost.total.interval[1] - found.lost.total.interval[0];
    let is_certain = |found: &Loss| found.lost.total.interval[0] > 0.0;
    let told = match (loss(&rows, noise, Late::Told), &presumed) {
        // A reversed sign that lateness would hide; a loss that no lateness hides stands.
        (Err(Untold::Reversed), presumed) if !presumed.as_ref().is_ok_and(is_certain) => {
            return Err(Untold::Reversed.into_words());
        }
        (Ok(told), Ok(presumed)) if width(&told) >= width(presumed) => None,
        (told, _) => told.ok(),
    };
    match told {
        // As rows are told apart by the load's place, what matters is taken off before.
        Some(Loss {
            lost,
            late: Some(off),
        }) if log.load_off().is_none_or(|off| off.late_s == 0.0) => {
            fit_lost_motion(&log.clone().with_late_taken_off(off), body).or(Ok(lost))
        }
        Some(told) => Ok(told.lost),
        None => presumed.map(|found| found.lost).map_err(Untold::into_words),
    }
}

/// What is lost, and the lateness of the load that was found beside it, is certain and matters.
struct Loss {
    lost: LostMotion,
    late: Option<LoadOff>,
}

/// Why lost motion is not told.
enum Untold {
    /// It hides in what lateness of the load makes, up to so many s.
    InLateness(f64),
    /// Certainly below zero.
    Reversed,
    /// In words.
    Other(&'static str),
}

impl Untold {
    fn into_words(self) -> String {
        match self {
            Untold::InLateness(unseen_s) => format!(
                "a load that is read up to {:.2} ms later or earlier than the motor looks the same at these speeds: move with strokes of several speeds, or slower; where one drive reads both at the same time, say so (lateness 0)",
                unseen_s * 1e3
            ),
            Untold::Reversed => "behind a reversal the load is ahead of the motor: a sign is reversed, the columns of motor and load are exchanged, or one of them is no position".to_owned(),
            Untold::Other(why) => why.to_owned(),
        }
    }
}

/// What a load that is read later or earlier than its motor does to what is lost.
#[derive(Clone, Copy, PartialEq)]
enum Late {
    /// The log tells it: a column of the speed, beside what winds up with acceleration.
    Told,
    /// Nothing tells it: intervals hold what so many seconds either way make of them.
    Presumed(f64),
}

/// The loss with a load that is so late.
fn loss(rows: &Rows<'_>, noise: f64, late: Late) -> Result<Loss, Untold> {
    let (look, within) = Look::narrowed(rows, noise, late);
    let Some(found) = look.best() else {
        return Err(Untold::Other(
            "the load's travel does not tell a step from a slow loss: make longer strokes",
        ));
    };
    let own = RowsOf {
        along: true,
        within,
        late,
        target: Target::Difference,
    };
    // Right behind reversals acceleration is the same as a step: what no shaft gives was taken from that.
    let [low, high] = look.figure(found, |x| x[ACCELERATION]).interval;
    if late == Late::Told && (low > MOST_GIVE_S2 || high < -MOST_GIVE_S2) {
        return Err(Untold::Other("acceleration hides what is lost"));
    }
    let most_late_s = match late {
        Late::Presumed(most_s) => most_s,
        Late::Told => 0.0,
    };
    let of_lateness = made_of(rows, look.length(), own, (Target::Speed, most_late_s));
    let unseen_scale = (Target::Place, rows.log.unseen_scale);
    let of_scale = made_of(rows, look.length(), own, unseen_scale);
    let plain = look.figure(found, |x| x[STEP] + x[ALONG]);
    // Where a load stands within its noise hangs on where it comes from.
    let rounding = rows.unspread(look.length(), within);
    let unseen = noise
        + rounding
        + (of_lateness[STEP] + of_lateness[ALONG]).abs()
        + (of_scale[STEP] + of_scale[ALONG]).abs();
    check_loss(&plain, unseen, rows.followed.range(), late)?;
    let whole = plain.widened(unseen);
    let [low, high] = whole.interval;
    // No axis gains position: below zero is what scatter and lengths make of next to none.
    let whole = Figure {
        value: whole.value.max(0.0),
        interval: [low.max(0.0), high],
        ..whole
    };
    let part = |which: usize| {
        let figure = look.figure(found, |x| x[which]);
        figure.widened(noise + rounding + of_lateness[which].abs() + of_scale[which].abs())
    };
    let along = part(ALONG);
    let step_alone = RowsOf {
        along: false,
        ..own
    };
    let step_alone = rows.fit(look.length(), step_alone);
    let alone = step_alone.is_some_and(|alone| alone.rms <= look.near);
    let late_s = look.figure(found, |x| x[SPEED]);
    let lost = LostMotion {
        total: whole,
        step: part(STEP),
        along,
        saturates_after: SATURATED * look.length(),
        saturates_between: look.saturates_between(),
        reversals: rows.followed.reversals,
        rms: found.rms,
        is_step: alone || along.interval[0] <= 0.0,
    };
    Ok(Loss {
        lost,
        late: late_load(late_s, rows.top_speed, whole.value),
    })
}

/// What so much of the speed or the place, unseen in the difference of motor and load, makes of the coefficients at
/// most: they are linear in it.
fn made_of(
    rows: &Rows<'_>,
    length: f64,
    own: RowsOf,
    (target, most): (Target, f64),
) -> [f64; COEFFICIENTS] {
    if most == 0.0 {
        return [0.0; COEFFICIENTS];
    }
    let fit = rows.fit(length, RowsOf { target, ..own });
    fit.map_or([0.0; COEFFICIENTS], |fit| fit.x.map(|x| most * x))
}

/// Refuses a loss that is none: one below zero, above the load's range of travel, or within what is unseen.
fn check_loss(loss: &Figure, unseen: f64, range: f64, late: Late) -> Result<(), Untold> {
    let [low, high] = loss.interval;
    if high + unseen < 0.0 {
        return Err(Untold::Reversed);
    }
    if high - low > range {
        return Err(Untold::Other(
            "motor and load do not go together: are both in the same unit? Else make more strokes",
        ));
    }
    if let Late::Presumed(unseen_s) = late
        && low > 0.0
        && unseen >= low
    {
        return Err(Untold::InLateness(unseen_s));
    }
    Ok(())
}

/// The lateness of the load, s, where it is certain and matters beside what is lost.
fn late_load(late_s: Figure, top_speed: f64, lost: f64) -> Option<LoadOff> {
    let matters = late_s.value.abs() * top_speed > MATTERS_SHARE * lost;
    (late_s.is_told() && matters).then(|| LoadOff {
        late_s: late_s.value,
        late_interval_s: late_s.interval,
        ..LoadOff::default()
    })
}

/// Samples at which the motor moves and the load does not follow: it crosses a gap.
fn crossing(log: &BodyLog, motion: &Motion) -> Vec<bool> {
    let (motor, load) = (
        Rates::new(&log.motor, motion.half, log.period_s),
        Rates::new(&log.load, motion.half, log.period_s),
    );
    (0..log.len())
        .map(|at| {
            let (first, last) = (at.checked_sub(motion.half), at + motion.half);
            if first.is_none() || last >= log.len() {
                return false;
            }
            let speed = motor.velocity(at);
            let behind = (speed - load.velocity(at)).abs();
            speed.abs() > motion.rest_speed && behind > CROSSING_SHARE * speed.abs()
        })
        .collect()
}

/// Samples at which the load may be off the flank that drives it: from where the motor slows down faster
/// than friction stops the load, over the rest behind it, until the motor has caught it again.
fn loose(log: &BodyLog, motion: &Motion, holds: Option<f64>, crossing: &[bool]) -> Vec<bool> {
    let rates = Rates::new(&log.motor, motion.half, log.period_s);
    let unknown = (UNKNOWN_SHARE * motion.usual_acceleration).max(ANY_HOLDS);
    let held = holds.map_or(unknown, |holds| HELD_PART * holds);
    let catches = CATCHES_SHARE * motion.usual_acceleration;
    let settles = SETTLES_WINDOWS * motion.half;
    let mut loose = vec![false; log.len()];
    // Samples for which the motor has pressed again; none while the load is where it should be.
    let mut pressed: Option<usize> = None;
    for at in motion.half..log.len().saturating_sub(motion.half) {
        let (speed, acceleration) = (rates.velocity(at), rates.acceleration(at));
        let along = acceleration * speed.signum();
        if speed.abs() > motion.rest_speed {
            if along < -held {
                pressed = Some(0);
            } else if let Some(count) = &mut pressed {
                // It catches the load by speeding up, and keeps it.
                let keeps = !crossing[at] && (*count > 0 || along >= catches);
                *count = if keeps { *count + 1 } else { 0 };
                if *count > settles {
                    pressed = None;
                }
            }
        } else if let Some(count) = &mut pressed {
            *count = 0;
        }
        loose[at] = pressed.is_some();
    }
    loose
}

/// What a log tells of the load's reversals.
struct Rows<'a> {
    log: &'a BodyLog,
    /// Velocities and accelerations of the motor.
    rates: Rates<'a>,
    /// Top speed of the motor.
    top_speed: f64,
    /// Acceleration below which a speed is steady: where it rises shaft and load have not come to rest on
    /// their flank.
    steady_below: f64,
    half: usize,
    followed: Followed,
    crossing: Vec<bool>,
    loose: Vec<bool>,
}

impl Rows<'_> {
    fn of(log: &BodyLog, band: f64, holds: Option<f64>) -> Rows<'_> {
        let motion = Motion::of(log);
        let crossing = crossing(log, &motion);
        Rows {
            log,
            rates: Rates::new(&log.motor, motion.half, log.period_s),
            top_speed: motion.top_speed,
            steady_below: UNKNOWN_SHARE * motion.usual_acceleration,
            half: motion.half,
            followed: Followed::of(&log.load, band),
            loose: loose(log, &motion, holds, &crossing),
            crossing,
        }
    }

    /// Whether the log's beginning is told by enough rows: one that fades within a block of those that
    /// are left out in turn is left out as a whole.
    fn tells_its_beginning(&self, length: f64) -> bool {
        let (place, mut travel) = (&self.followed.place, 0.0);
        let fading = place.windows(2).take_while(|pair| {
            travel += (pair[1] - pair[0]).abs();
            lostmotion_base::math::exp(-travel / length) > FADED
        });
        fading.count() > FADES_OVER * place.len() / super::squares::BLOCKS
    }

    /// Whether a row tells where the load is; `begins` right behind a reversal, while it lags as across a gap.
    fn counts(&self, at: usize, begins: bool) -> bool {
        !(self.followed.unsure[at]
            || self.loose[at]
            || (self.crossing[at] && !begins)
            || self.log.touches_lost(at..=at))
    }

    /// A loss of one length, by rows of some kind.
    fn fit(&self, length: f64, of: RowsOf) -> Option<SquaresFit<COEFFICIENTS>> {
        let mut squares = Squares::new(self.log.len());
        // Count, sum and square of the steady speeds of each side.
        let mut speeds = [[0.0; 3]; 2];
        self.each(length, of.within, |at, row| {
            let (speed, side) = (row[SPEED], row[STEP]);
            if row[ACCELERATION].abs() < self.steady_below {
                let own = &mut speeds[usize::from(side > 0.0)];
                (own[0], own[1], own[2]) = (own[0] + 1.0, own[1] + speed, own[2] + speed * speed);
            }
            let target = match of.target {
                Target::Difference => self.log.motor[at] - self.log.load[at],
                Target::Speed => speed,
                Target::Place => row[PLACE],
            };
            squares.add(at, row, target);
        });
        if of.late == Late::Told && !vary(&speeds) {
            return None;
        }
        let mut used = [true; COEFFICIENTS];
        used[ALONG] = of.along;
        used[START] = of.along && self.tells_its_beginning(length);
        used[PLACE] = self.log.load_off().is_some_and(|off| off.scale != 0.0);
        (used[SPEED], used[ACCELERATION]) = (of.late == Late::Told, of.late == Late::Told);
        debug_assert!(used[OFFSET]);
        // In a motion of one frequency place and acceleration are the same.
        if used[PLACE] && used[ACCELERATION] {
            used[ACCELERATION] = squares.left_of(ACCELERATION, &used) > ALONE_SHARE;
        }
        squares.solve(&used)
    }

    /// What is lost may be off by so much for rounding that does not average out.
    fn unspread(&self, length: f64, within: f64) -> f64 {
        let mut rows: Vec<Row> = Vec::new();
        self.each(length, within, |at, row| {
            let side = row[STEP].signum();
            let stretch = rows
                .last()
                .map_or(0, |last| last.stretch + usize::from(last.side * side < 0.0));
            rows.push(Row {
                at,
                stretch,
                side,
                weight: 1.0,
            });
        });
        let all = rows.len() as f64;
        let forward = rows.iter().filter(|row| row.side > 0.0).count() as f64;
        // What is lost is the mean of one side less that of the other.
        for row in &mut rows {
            row.weight = if row.side > 0.0 {
                1.0 / forward
            } else {
                1.0 / (all - forward)
            };
        }
        let rounded = Rounded {
            motor: &self.log.motor,
            load: &self.log.load,
            steps: self.log.steps,
            half: self.half,
            scale: self.log.load_off().map_or(0.0, |off| off.scale),
        };
        rounded.unspread(&rows)
    }

    /// Calls for each row that counts with its sample and its columns.
    fn each(&self, length: f64, within: f64, mut call: impl FnMut(usize, [f64; COEFFICIENTS])) {
        let Followed { place, turned, .. } = &self.followed;
        let (mut state, mut side, mut travel, mut since) = (0.0, 0.0, 0.0, 0.0);
        let mut begins = false;
        let told = self.tells_its_beginning(length);
        for at in 1..self.log.len() {
            let mut moved = place[at] - place[at - 1];
            if turned[at] {
                moved += moved.signum() * 2.0 * self.followed.band;
                since = 0.0;
                begins = true;
            }
            // Behind a reversal a loss along the travel holds the load back as a gap does before it.
            begins &= self.crossing[at];
            if moved != 0.0 {
                side = moved.signum();
                state = side - (side - state) * lostmotion_base::math::exp(-moved.abs() / length);
                travel += moved.abs();
                since += moved.abs();
            }
            if side == 0.0 || since > within || !self.counts(at, begins) {
                continue;
            }
            // Where the log begins nobody knows; that fades along the travel.
            let start = lostmotion_base::math::exp(-travel / length);
            if start > FADED && !told {
                continue;
            }
            if at < self.half || at + self.half >= self.log.len() {
                continue;
            }
            let (speed, acceleration) = (self.rates.velocity(at), self.rates.acceleration(at));
            let moved = self.log.motor[at] - self.log.motor[0];
            let row = [
                1.0,
                0.5 * side,
                0.5 * state,
                start,
                moved,
                speed,
                acceleration,
            ];
            call(at, row);
        }
    }
}

/// Whether the steady speeds of each side, by their count, sum and square, scatter enough to tell lateness.
fn vary(speeds: &[[f64; 3]; 2]) -> bool {
    let scatter = |[count, sum, square]: [f64; 3]| {
        let mean = sum / count.max(1.0);
        square - mean * sum
    };
    let all: f64 = speeds.iter().map(|side| side[2]).sum();
    let within: f64 = speeds.iter().map(|side| scatter(*side)).sum();
    within > VARIES_SHARE * VARIES_SHARE * all
}

/// What a loss is fitted to.
#[derive(Clone, Copy)]
enum Target {
    /// Difference of motor and load.
    Difference,
    /// Speed of the motor, as lateness would add of it.
    Speed,
    /// Place of the motor, as a scale would add of it.
    Place,
}

/// Which rows are fitted, and what beside the loss.
#[derive(Clone, Copy)]
struct RowsOf {
    /// Whether a part of the loss is along the travel.
    along: bool,
    /// Travel behind reversals within which rows count.
    within: f64,
    late: Late,
    /// What stands in the place of the difference of motor and load.
    target: Target,
}

/// Lengths that were tried, and which of them explain the log.
struct Look {
    /// By which each is longer than the one before.
    growth: f64,
    lengths: Vec<f64>,
    fits: Vec<Option<SquaresFit<COEFFICIENTS>>>,
    best: usize,
    /// Residual, root mean square, of what explains the log as well as the best.
    near: f64,
    /// Lengths that do.
    alike: Vec<usize>,
}

impl Look {
    fn of(rows: &Rows<'_>, [shortest, longest]: [f64; 2], within: f64, late: Late) -> Look {
        let rate = lostmotion_base::math::log(longest / shortest) / (LENGTHS - 1) as f64;
        let lengths: Vec<f64> = (0..LENGTHS)
            .map(|index| shortest * lostmotion_base::math::exp(rate * index as f64))
            .collect();
        let fits: Vec<_> = lengths
            .iter()
            .map(|&length| {
                let own = RowsOf {
                    along: true,
                    within,
                    late,
                    target: Target::Difference,
                };
                rows.fit(length, own)
            })
            .collect();
        let rms = |index: usize| {
            fits.get(index)
                .and_then(Option::as_ref)
                .map_or(f64::INFINITY, |found| found.rms)
        };
        let best = (0..LENGTHS)
            .min_by(|&a, &b| rms(a).total_cmp(&rms(b)))
            .unwrap_or_default();
        // The residual of windows that err alike: as many of them as blocks.
        let blocks = super::squares::BLOCKS as f64;
        let near = rms(best) * (1.0 + 4.0 / blocks).sqrt();
        let alike = (0..LENGTHS)
            .filter(|&index| fits[index].is_some() && rms(index) <= near)
            .collect();
        Look {
            growth: lostmotion_base::math::exp(rate),
            lengths,
            best,
            near,
            alike,
            fits,
        }
    }

    /// The lengths that explain the log, as finely as it tells them, and the travel behind reversals within
    /// which rows count.
    fn narrowed(rows: &Rows<'_>, noise: f64, late: Late) -> (Look, f64) {
        let range = rows.followed.range();
        let lowest = (SHORTEST * range).max(noise);
        // A loss that is complete soon is told by the few rows behind each reversal, which the many others
        // would outweigh: what is longer than the log allows goes, and with it the rows that only that needs.
        let (mut longest, mut within) = (range, f64::INFINITY);
        let mut look = Look::of(rows, [lowest, longest], within, late);
        for _ in 0..LOOKS {
            let Some(last) = look.alike.last().map(|&index| look.lengths[index]) else {
                break;
            };
            let narrower = TELLS * SATURATED * last;
            if narrower > (range / 3.0).min(within / 3.0) {
                break;
            }
            let next = Look::of(rows, [lowest, longest.min(3.0 * last)], narrower, late);
            if next.best().is_none() {
                break;
            }
            (longest, within, look) = (3.0 * last, narrower, next);
        }
        // As finely as the lengths that explain the log are told.
        if let [Some(first), Some(last)] = [look.alike.first(), look.alike.last()] {
            let [shortest, longest] = [
                look.lengths[*first] / look.growth,
                look.lengths[*last] * look.growth,
            ];
            let lengths = [shortest.max(lowest), longest.min(range)];
            look = Look::of(rows, lengths, within, late);
        }
        (look, within)
    }

    fn best(&self) -> Option<&SquaresFit<COEFFICIENTS>> {
        self.fits.get(self.best).and_then(Option::as_ref)
    }

    /// The length that explains the log best.
    fn length(&self) -> f64 {
        self.lengths[self.best]
    }

    /// A figure of the best fit. What another length that explains the log as well makes of it belongs to its
    /// interval.
    fn figure(
        &self,
        found: &SquaresFit<COEFFICIENTS>,
        of: impl Fn(&[f64; COEFFICIENTS]) -> f64,
    ) -> Figure {
        let of_fit =
            |fit: &SquaresFit<COEFFICIENTS>| jackknife(of(&fit.x), fit.without.iter().map(&of));
        let alike = self.alike.iter();
        alike
            .filter_map(|&index| self.fits[index].as_ref())
            .fold(of_fit(found), |figure, other| figure.joined(of_fit(other)))
    }

    /// The lengths that explain the log nearly as well, as travel to 95 %: between two that are tried another
    /// one may lie.
    fn saturates_between(&self) -> [f64; 2] {
        let length = |index: Option<&usize>, beyond: f64| {
            index
                .and_then(|&index| self.lengths.get(index))
                .map(|length| SATURATED * length * beyond)
        };
        [
            length(self.alike.first(), self.growth.recip()).unwrap_or(0.0),
            length(self.alike.last(), self.growth).unwrap_or(f64::INFINITY),
        ]
    }
}
