//! The gap from one crossing: what the drive did is run again on the twin with gaps of many sizes; the one whose motor moves as the real one did is it.
//!
//! No threshold and no derivative of a measured position comes in: the whole servo, friction at standstill and the shaft's wind-up are in the
//! twin, and contact is known as finely as the motor's motion shows it, to a fraction of a sample.

use super::Correction;
use super::twin::{LoadModel, Twin, TwinState};
use crate::signal::Reference;
use serde::{Deserialize, Serialize};

/// Longest record, ticks: 400 ms.
const LONGEST: usize = 1600;
/// Shortest record from which a gap is read: 10 ms.
const SHORTEST: usize = 40;
/// Smallest half gap of the coarse search, rad, its ratio and its steps: up to 0.35 rad.
const COARSE_FROM: f64 = 1e-4;
const COARSE_RATIO: f64 = 1.3;
const COARSE_STEPS: u32 = 32;
/// Part of the interval that a golden section keeps, and how often: to a thousandth of the gap.
const GOLDEN: f64 = 0.618_033_988_749_894_8;
const SECTIONS: u32 = 12;

/// A tick of a record: reference, correction (position, velocity, torque), measured motor position.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Tick {
    reference: Reference,
    correction: [f64; 3],
    motor: f64,
}

/// A crossing: the gapless twin where it began, the flank left, the offset then, and what followed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Record {
    start: TwinState,
    side: i8,
    offset: f64,
    ticks: Vec<Tick>,
}

/// What a record says: half gap, and the mean squares (rad2) of what stays unexplained with it, without a gap, and a tenth beside it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Reading {
    pub(super) half_gap: f64,
    pub(super) misfit: f64,
    pub(super) without: f64,
    pub(super) beside: f64,
}

impl Record {
    pub(super) fn new(start: TwinState, side: i8, offset: f64) -> Record {
        Record { start, side, offset, ticks: Vec::with_capacity(LONGEST) }
    }

    /// Whether it is as long as it gets.
    pub(super) fn full(&self) -> bool {
        self.ticks.len() >= LONGEST
    }

    /// Whether a gap can be read from it.
    pub(super) fn readable(&self) -> bool {
        self.side != 0 && self.ticks.len() >= SHORTEST
    }

    pub(super) fn push(&mut self, reference: Reference, correction: &Correction, motor: f64) {
        self.ticks.push(Tick { reference, correction: [correction.position, correction.velocity, correction.torque], motor });
    }

    /// Mean square of the motor's position against that of the twin with a gap, rad2.
    fn misfit(&self, twin: &Twin, load: &LoadModel, half_gap: f64) -> f64 {
        let mut state = twin.on_flank(&self.start, f64::from(self.side), half_gap, self.offset);
        let mut sum = 0.0;
        for pair in self.ticks.windows(2) {
            let off = pair[0].motor - state.plant.motor_position();
            sum += off * off;
            let [position, velocity, torque] = pair[0].correction;
            let correction = Correction { position, velocity, torque, ..Correction::NONE };
            twin.step_with_gap(&mut state, &pair[0].reference, &pair[1].reference, &correction, load, half_gap);
        }
        sum / (self.ticks.len() as f64).max(1.0)
    }

    /// The half gap that fits best: near a guess, or anywhere.
    pub(super) fn read(&self, twin: &Twin, load: &LoadModel, guess: Option<f64>) -> Reading {
        let cost = |half_gap: f64| self.misfit(twin, load, half_gap);
        let without = cost(0.0);
        let middle = guess.unwrap_or_else(|| coarse(&cost, without));
        let half_gap = golden(&cost, middle / COARSE_RATIO, middle * COARSE_RATIO);
        Reading { half_gap, misfit: cost(half_gap), without, beside: cost(0.9 * half_gap).min(cost(1.1 * half_gap)) }
    }
}

fn coarse(cost: &impl Fn(f64) -> f64, without: f64) -> f64 {
    let (mut least, mut best, mut half_gap) = (without, 0.0, COARSE_FROM);
    for _ in 0..COARSE_STEPS {
        let misfit = cost(half_gap);
        if misfit < least {
            (least, best) = (misfit, half_gap);
        }
        half_gap *= COARSE_RATIO;
    }
    best
}

/// Minimum of a function with one minimum between two bounds.
fn golden(cost: &impl Fn(f64) -> f64, from: f64, to: f64) -> f64 {
    let (mut from, mut to) = (from, to);
    let (mut a, mut b) = (to - GOLDEN * (to - from), from + GOLDEN * (to - from));
    let (mut at_a, mut at_b) = (cost(a), cost(b));
    for _ in 0..SECTIONS {
        if at_a < at_b {
            (to, b, at_b) = (b, a, at_a);
            a = to - GOLDEN * (to - from);
            at_a = cost(a);
        } else {
            (from, a, at_a) = (a, b, at_b);
            b = from + GOLDEN * (to - from);
            at_b = cost(b);
        }
    }
    0.5 * (from + to)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_searches_find_a_minimum() {
        let cost = |x: f64| (x - 0.0123) * (x - 0.0123);
        let middle = coarse(&cost, cost(0.0));
        assert!((middle / 0.0123).max(0.0123 / middle) < COARSE_RATIO);
        let found = golden(&cost, middle / COARSE_RATIO, middle * COARSE_RATIO);
        assert!((found / 0.0123 - 1.0).abs() < 1e-3, "{found}");
    }

    #[test]
    fn nothing_to_find_is_no_gap() {
        assert_eq!(coarse(&|x| x, 0.0), 0.0);
    }
}
