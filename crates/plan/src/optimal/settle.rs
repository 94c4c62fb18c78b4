//! Brings the pace of a window inside the limits where the solver's model of them left it a little
//! beyond.

use super::ends::End;
use super::tighten::Excess;

/// The pace is lowered over so many times sqrt(v/j) on both sides: so wide that its own change
/// costs less jerk than the lower pace saves.
const WIDTH: f64 = 3.5;
/// By how much beta is lowered for each part that a limit is passed by.
const MORE: f64 = 1.1;
/// Nothing is lowered so near to an end of a window whose state is given, in steps; from there on
/// more and more.
const GIVEN: usize = 4;
const TAPER: f64 = 60.0;

/// How wide a dip of the pace is, in steps of nominal time, for the ratios of velocity to jerk of
/// the joints.
pub(super) fn width(limits: impl Iterator<Item = [f64; 3]>, step_s: f64) -> f64 {
    WIDTH * limits.map(|[v, _, j]| (v / j).sqrt()).fold(0.0, f64::max) / step_s
}

/// Lowers the coefficients of beta around what passes a limit; those that are given stay.
pub(super) fn dip(x: &mut [f64], excess: &Excess, width: f64, ends: [End; 2]) {
    let mut less = vec![0.0_f64; x.len()];
    for (interval, scale) in excess {
        let depth = (MORE * (1.0 - scale[0].min(scale[1]))).min(0.5);
        let (center, reach) = (*interval as f64 + 1.0, width.ceil() as usize);
        let around = (interval + 1).saturating_sub(reach)..(interval + 1 + reach).min(x.len());
        for (index, less) in less[around.clone()].iter_mut().enumerate() {
            let away = ((around.start + index) as f64 - center) / width;
            let bump = (1.0 - away * away).max(0.0);
            *less = less.max(depth * bump * bump);
        }
    }
    let last = x.len() - 1;
    let part = |end: End, away: usize| {
        if end == End::Moving {
            (away.saturating_sub(GIVEN) as f64 / TAPER).min(1.0)
        } else {
            1.0
        }
    };
    for (index, (x, less)) in x.iter_mut().zip(less).enumerate() {
        let part = part(ends[0], index).min(part(ends[1], last - index));
        *x *= 1.0 - less * part * part * (3.0 - 2.0 * part);
    }
}
