//! Margins of a loop, from its response.

use super::response::{Complex, StateSpace};
use lostmotion_base::math;
use serde::Serialize;

/// Decades below half the sampling rate in which crossings are looked for. A choice: down to mHz at
/// 4 kHz, far below any loop.
const SEARCH_DECADES: u32 = 6;
/// Frequencies per decade of the search. A choice: 0.9 % apart.
const STEPS_PER_DECADE: u32 = 250;

/// Margins and bandwidth of a loop.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Margins {
    /// Factor by which the loop's gain may grow before it oscillates, dB; `None` if no growth does
    /// that. Below 0: the loop is unstable already.
    pub gain_margin_db: Option<f64>,
    /// Frequency at which it would oscillate then, Hz.
    pub gain_margin_hz: Option<f64>,
    /// Phase that may be lost at the crossover, deg; the smallest of all crossovers; `None` if the
    /// gain never crosses 1.
    pub phase_margin_deg: Option<f64>,
    /// Lowest frequency at which the loop's gain crosses 1, Hz.
    pub crossover_hz: Option<f64>,
    /// Smallest distance of the response from -1: the inverse of the largest sensitivity.
    pub modulus_margin: f64,
    /// Frequency at which the closed loop's gain falls to -3 dB for the first time, Hz; `None` if
    /// it does not.
    pub bandwidth_hz: Option<f64>,
    /// Largest magnitude of a pole of the closed loop; below 1 it is stable.
    pub spectral_radius: f64,
}

impl Margins {
    /// The margins of a loop that is given broken at its error.
    pub(super) fn of(open: &StateSpace) -> Margins {
        // The response on a grid; two crossings within one step would cancel and be missed.
        let grid: Vec<(f64, Complex)> = frequencies(open.nyquist_hz())
            .map(|f| (f, open.at(f)))
            .collect();
        let mut margins = Margins {
            gain_margin_db: None,
            gain_margin_hz: None,
            phase_margin_deg: None,
            crossover_hz: None,
            modulus_margin: grid
                .iter()
                .map(|(_, l)| from_minus_one(*l))
                .fold(1.0, f64::min),
            bandwidth_hz: None,
            spectral_radius: open.closed_radius(),
        };
        for pair in grid.windows(2) {
            let [(low, from), (high, to)] = pair else {
                continue;
            };
            // Each crossing between two neighbours is refined; the bandwidth is the first fall
            // below -3 dB.
            margins.gain_crossing(open, *low, *high, *from, *to);
            margins.phase_crossing(open, *low, *high, *from, *to);
            if margins.bandwidth_hz.is_none()
                && closed(*from) >= HALF_POWER
                && closed(*to) < HALF_POWER
            {
                margins.bandwidth_hz = Some(root(*low, *high, |f| closed(open.at(f)) - HALF_POWER));
            }
        }
        // At half the sampling rate the response is real.
        margins.at_negative_axis(open.nyquist_hz(), open.at(open.nyquist_hz()).re);
        margins
    }

    /// Whether the closed loop is stable.
    pub fn stable(&self) -> bool {
        self.spectral_radius < 1.0
    }

    fn gain_crossing(
        &mut self,
        open: &StateSpace,
        low: f64,
        high: f64,
        from: Complex,
        to: Complex,
    ) {
        if (from.abs() < 1.0) == (to.abs() < 1.0) {
            return;
        }
        // Phase above -180 degrees where the gain is 1; the smallest of all crossings counts.
        let f = root(low, high, |f| open.at(f).abs() - 1.0);
        let margin = open.at(f).scaled(-1.0).phase().to_degrees();
        self.crossover_hz = self.crossover_hz.or(Some(f));
        if self
            .phase_margin_deg
            .is_none_or(|least| margin.abs() < least.abs())
        {
            self.phase_margin_deg = Some(margin);
        }
    }

    /// The response crosses the negative real axis. Where its gain there is above 1 the loop may
    /// need that gain (conditionally stable), so it counts as a margin only if the loop is
    /// unstable.
    fn phase_crossing(
        &mut self,
        open: &StateSpace,
        low: f64,
        high: f64,
        from: Complex,
        to: Complex,
    ) {
        if (from.im < 0.0) == (to.im < 0.0) || from.re.max(to.re) >= 0.0 {
            return;
        }
        let f = root(low, high, |f| open.at(f).im);
        self.at_negative_axis(f, open.at(f).re);
    }

    fn at_negative_axis(&mut self, f: f64, real: f64) {
        // Gain up to 1 in dB; on the positive axis there is nothing to oscillate.
        let margin = -20.0 * math::log10(real.abs());
        if real >= 0.0 || (margin < 0.0 && self.stable()) {
            return;
        }
        if self.gain_margin_db.is_none_or(|least| margin < least) {
            self.gain_margin_db = Some(margin);
            self.gain_margin_hz = Some(f);
        }
    }
}

/// Gain of -3 dB: half of the power.
const HALF_POWER: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// From low to half the sampling rate, evenly in the logarithm, the very end left out.
pub(super) fn frequencies(nyquist_hz: f64) -> impl Iterator<Item = f64> {
    let count = SEARCH_DECADES * STEPS_PER_DECADE;
    (0..=count).map(move |n| {
        nyquist_hz
            * 0.999_999
            * math::pow(
                10.0,
                (f64::from(n) - f64::from(count)) / f64::from(STEPS_PER_DECADE),
            )
    })
}

/// Distance from -1.
pub(super) fn from_minus_one(open: Complex) -> f64 {
    open.plus(Complex { re: 1.0, im: 0.0 }).abs()
}

/// Gain of the closed loop.
fn closed(open: Complex) -> f64 {
    open.abs() / from_minus_one(open)
}

/// Where a function changes its sign.
fn root(mut low: f64, mut high: f64, function: impl Fn(f64) -> f64) -> f64 {
    // Bisection: 50 halvings leave rounding alone.
    let negative = function(low) < 0.0;
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if (function(middle) < 0.0) == negative {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{PI, TAU};

    /// `w_c T/(z - 1)` behind `delays` whole periods.
    fn integrator(crossover: f64, period: f64, delays: usize) -> StateSpace {
        StateSpace::of(1 + delays, period, |x, u| {
            let last = if delays == 0 { x[0] } else { x[delays] };
            for i in (1..=delays).rev() {
                x[i] = x[i - 1];
            }
            x[0] += crossover * period * u;
            last
        })
    }

    #[test]
    fn an_integrator_with_delay_has_its_textbook_margins() {
        let period = 250e-6;
        for delays in 0..5 {
            for wanted in [50.0, 300.0] {
                let margins = Margins::of(&integrator(wanted, period, delays));
                // |L| = (w T/2)/sin(w' T/2) w../: crossover where 2 sin(w' T/2) = w T; delay is d +
                // 1/2 periods
                let crossover = 2.0 / period * math::asin(0.5 * wanted * period);
                assert!((margins.crossover_hz.unwrap() * TAU / crossover - 1.0).abs() < 1e-9);
                let delay = (delays as f64 + 0.5) * period;
                let phase = 90.0 - (crossover * delay).to_degrees();
                assert!(
                    (margins.phase_margin_deg.unwrap() - phase).abs() < 1e-6,
                    "{delays} {wanted}"
                );
                // -180 deg where w delay = 90 deg
                let oscillates = 0.5 * PI / delay;
                let gain = 2.0 * math::sin(0.5 * oscillates * period) / (wanted * period);
                assert!((margins.gain_margin_db.unwrap() - 20.0 * math::log10(gain)).abs() < 1e-6);
                assert!((margins.gain_margin_hz.unwrap() * TAU / oscillates - 1.0).abs() < 1e-9);
                assert!(margins.stable());
            }
        }
    }

    #[test]
    fn the_spectral_radius_passes_one_at_the_gain_margin() {
        let loop_at = |gain: f64| integrator(300.0 * gain, 250e-6, 3);
        let limit = math::pow(
            10.0,
            Margins::of(&loop_at(1.0)).gain_margin_db.unwrap() / 20.0,
        );
        assert!(
            loop_at(limit * 0.9999).closed_radius() < 1.0
                && loop_at(limit * 1.0001).closed_radius() > 1.0
        );
        let unstable = Margins::of(&loop_at(1.1 * limit));
        assert!(
            !unstable.stable()
                && unstable.gain_margin_db.unwrap() < 0.0
                && unstable.phase_margin_deg.unwrap() < 0.0
        );
    }

    #[test]
    fn a_first_order_lag_has_its_own_frequency_as_bandwidth() {
        // closed loop w/(s + w), slow against the sampling
        let margins = Margins::of(&integrator(20.0, 250e-6, 0));
        assert!(
            (margins.bandwidth_hz.unwrap() * TAU / 20.0 - 1.0).abs() < 5e-3,
            "{:?}",
            margins.bandwidth_hz
        );
    }
}
