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

use super::squares::{Squares, SquaresFit, jackknife};
use super::{BodyLog, Figure, Motion, Rates};
use crate::body::motion::noise_of;
use serde::Serialize;

/// Deviations of the load's noise that its place has to move by to count as moving. A choice.
const MOVES_FROM: f64 = 6.0;
/// Part of the motor's speed by which the load's is off while the motor crosses a gap. A choice.
const CROSSING_SHARE: f64 = 0.5;
/// Lengths that are tried, over the range of travel.
const LENGTHS: usize = 33;
/// Shortest and longest length tried, in parts of the load's range of travel.
const LENGTH_RANGE: [f64; 2] = [0.003, 1.0];
/// Times the length by which 95 % of the loss is there.
const SATURATED: f64 = 3.0;

const OFFSET: usize = 0;
const STEP: usize = 1;
const ALONG: usize = 2;
const START: usize = 3;
const COEFFICIENTS: usize = 4;

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
/// # Errors
/// What is missing: no load's position, no reversal, a load that does not move beyond its noise.
pub fn fit_lost_motion(log: &BodyLog) -> Result<LostMotion, String> {
    if log.load.is_empty() {
        return Err(
            "the log has no load's position (a linear scale): lost motion is not told by it"
                .to_owned(),
        );
    }
    let noise = noise_of(&log.load);
    let (place, reversals) = followed(&log.load, MOVES_FROM * noise);
    if reversals == 0 {
        return Err("the load never turns round: move it to and fro".to_owned());
    }
    let least = place.iter().copied().fold(f64::INFINITY, f64::min);
    let most = place.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let range = most - least;
    let lowest = (LENGTH_RANGE[0] * range).max(noise);
    let growth =
        lostmotion_base::math::log(LENGTH_RANGE[1] * range / lowest) / (LENGTHS - 1) as f64;
    let lengths: Vec<f64> = (0..LENGTHS)
        .map(|index| lowest * lostmotion_base::math::exp(growth * index as f64))
        .collect();
    let crossing = crossing(log);
    let fits: Vec<Option<SquaresFit<COEFFICIENTS>>> = lengths
        .iter()
        .map(|&length| fit(log, &place, &crossing, length, true))
        .collect();
    let rms = |index: usize| {
        fits[index]
            .as_ref()
            .map_or(f64::INFINITY, |found| found.rms)
    };
    let best = (0..LENGTHS)
        .min_by(|&a, &b| rms(a).total_cmp(&rms(b)))
        .unwrap_or_default();
    let Some(found) = &fits[best] else {
        return Err(
            "the load's travel does not tell a step from a slow loss: make longer strokes"
                .to_owned(),
        );
    };
    let step_alone = fit(log, &place, &crossing, lengths[best], false);
    // The residual of windows that err alike: as many of them as blocks.
    let blocks = super::squares::BLOCKS as f64;
    let near = found.rms * (1.0 + 4.0 / blocks).sqrt();
    let alike: Vec<usize> = (0..LENGTHS).filter(|&index| rms(index) <= near).collect();
    let length = |index: Option<&usize>| {
        index
            .and_then(|&index| lengths.get(index))
            .map(|length| SATURATED * length)
    };
    let total = |x: &[f64; COEFFICIENTS]| x[STEP] + x[ALONG];
    // What another length that explains the log as well makes of a figure belongs to its interval.
    let figure = |of: &dyn Fn(&[f64; COEFFICIENTS]) -> f64| {
        let mut figure = jackknife(of(&found.x), found.without.iter().map(of));
        for other in alike.iter().filter_map(|&index| fits[index].as_ref()) {
            let [low, high] = jackknife(of(&other.x), other.without.iter().map(of)).interval;
            figure.interval = [figure.interval[0].min(low), figure.interval[1].max(high)];
        }
        figure
    };
    let whole = figure(&total);
    let [low, high] = whole.interval;
    if high < 0.0 {
        return Err(
            "behind a reversal the load is ahead of the motor: a sign is reversed, the columns of motor and load are exchanged, or one of them is no position"
                .to_owned(),
        );
    }
    if high - low > range {
        return Err(
            "motor and load do not go together: are both in the same unit? Else make more strokes"
                .to_owned(),
        );
    }
    let along = figure(&|x| x[ALONG]);
    let alone = step_alone.as_ref().is_some_and(|alone| alone.rms <= near);
    Ok(LostMotion {
        total: whole,
        step: figure(&|x| x[STEP]),
        along,
        saturates_after: SATURATED * lengths[best],
        saturates_between: [
            length(alike.first()).unwrap_or(0.0),
            length(alike.last()).unwrap_or(f64::INFINITY),
        ],
        reversals,
        rms: found.rms,
        is_step: alone || along.interval[0] <= 0.0,
    })
}

/// Samples at which the motor moves and the load does not follow: it crosses a gap.
fn crossing(log: &BodyLog) -> Vec<bool> {
    let motion = Motion::of(log);
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

/// The place without its noise: it follows only what leaves a band around it. Counts how often it
/// turns round.
fn followed(column: &[f64], band: f64) -> (Vec<f64>, usize) {
    let mut place = column.first().copied().unwrap_or(0.0);
    let (mut direction, mut reversals) = (0.0, 0);
    let followed = column
        .iter()
        .map(|&value| {
            let ahead = value - place;
            if ahead.abs() > band {
                if direction * ahead < 0.0 {
                    reversals += 1;
                }
                direction = ahead.signum();
                place = value - direction * band;
            }
            place
        })
        .collect();
    (followed, reversals)
}

fn fit(
    log: &BodyLog,
    place: &[f64],
    crossing: &[bool],
    length: f64,
    along: bool,
) -> Option<SquaresFit<COEFFICIENTS>> {
    let mut squares = Squares::new(log.len());
    let (mut state, mut side, mut travel) = (0.0, 0.0, 0.0);
    for at in 1..log.len() {
        let moved = place[at] - place[at - 1];
        if moved != 0.0 {
            side = moved.signum();
            state = side - (side - state) * lostmotion_base::math::exp(-moved.abs() / length);
            travel += moved.abs();
        }
        if side == 0.0 || crossing[at] || log.touches_lost(at..=at) {
            continue;
        }
        // Where the log begins nobody knows; that fades along the travel.
        let start = lostmotion_base::math::exp(-travel / length);
        let row = [1.0, 0.5 * side, 0.5 * state, start];
        squares.add(at, row, log.motor[at] - log.load[at]);
    }
    let mut used = [true; COEFFICIENTS];
    used[ALONG] = along;
    used[START] = along;
    debug_assert!(used[OFFSET]);
    squares.solve(&used)
}
