//! Second-order filters on the current command, once per servo tick.
//!
//! A filter's transfer function in s becomes one in z by the bilinear transformation
//! `s = w/tan(w T/2) (z - 1)/(z + 1)`, w the filter's own frequency: there, and at 0, the response
//! is that of the filter in continuous time, to the last digit. Transposed direct form II:
//! ```text
//! y  = b0 u + s1
//! s1 = b1 u - a1 y + s2
//! s2 = b2 u - a2 y
//! ```
//! Delay: what the filter's phase says; the crate `lostmotion-analysis` takes it into account.

use crate::config::{MAX_TORQUE_FILTERS, TorqueFilter, TorqueFilters};
use lostmotion_base::math;
use std::f64::consts::TAU;

/// State of all filters of a drive.
pub type FilterState = [[f64; 2]; MAX_TORQUE_FILTERS];

/// One filter in discrete time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Biquad {
    b: [f64; 3],
    a: [f64; 2],
}

impl Biquad {
    /// `(n2 s^2 + n1 s + n0)/(s^2 + d1 s + d0)` for s in units of the filter's angular frequency.
    fn bilinear(angle: f64, numerator: [f64; 3], denominator: [f64; 3]) -> Biquad {
        let k = 1.0 / math::tan(0.5 * angle);
        // coefficients of z^0, z^-1, z^-2 after s = k (z - 1)/(z + 1), times (z + 1)^2
        let discrete = |[c0, c1, c2]: [f64; 3]| {
            [
                c0 + c1 * k + c2 * k * k,
                2.0 * (c0 - c2 * k * k),
                c0 - c1 * k + c2 * k * k,
            ]
        };
        let ([n0, n1, n2], [d0, d1, d2]) = (discrete(numerator), discrete(denominator));
        Biquad {
            b: [n0 / d0, n1 / d0, n2 / d0],
            a: [d1 / d0, d2 / d0],
        }
    }

    fn new(filter: &TorqueFilter, period_s: f64) -> Biquad {
        match filter {
            TorqueFilter::Notch(notch) => {
                // relative width; the depth is the ratio of the dampings
                let width = notch.width_hz / notch.frequency_hz;
                let rest = width * math::pow(10.0, -notch.depth_db / 20.0);
                Biquad::bilinear(
                    TAU * notch.frequency_hz * period_s,
                    [1.0, rest, 1.0],
                    [1.0, width, 1.0],
                )
            }
            TorqueFilter::LowPass(low) => Biquad::bilinear(
                TAU * low.frequency_hz * period_s,
                [1.0, 0.0, 0.0],
                [1.0, 2.0 * low.damping, 1.0],
            ),
        }
    }

    #[inline]
    fn step(&self, [s1, s2]: &mut [f64; 2], u: f64) -> f64 {
        let ([b0, b1, b2], [a1, a2]) = (self.b, self.a);
        let y = b0 * u + *s1;
        *s1 = b1 * u - a1 * y + *s2;
        *s2 = b2 * u - a2 * y;
        y
    }

    /// The state in which an input that stays gives itself: every filter lets a constant through.
    fn settled(&self, u: f64) -> [f64; 2] {
        let s2 = (self.b[2] - self.a[1]) * u;
        [(self.b[1] - self.a[0]) * u + s2, s2]
    }
}

/// The filters of a drive in series.
#[derive(Clone, Debug, PartialEq)]
pub struct Filters(Vec<Biquad>);

impl Filters {
    /// The filters at a sampling period, s.
    pub fn new(filters: &TorqueFilters, period_s: f64) -> Filters {
        Filters(
            filters
                .iter()
                .map(|filter| Biquad::new(filter, period_s))
                .collect(),
        )
    }

    /// State after a constant input since for ever.
    pub fn settled(&self, input: f64) -> FilterState {
        let mut state = FilterState::default();
        for (slot, filter) in state.iter_mut().zip(&self.0) {
            *slot = filter.settled(input);
        }
        state
    }

    #[inline]
    /// One sample through all of them.
    pub fn step(&self, state: &mut [[f64; 2]], input: f64) -> f64 {
        self.0
            .iter()
            .zip(state)
            .fold(input, |signal, (filter, state)| filter.step(state, signal))
    }

    /// Whether the torque command passes unfiltered.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of filters.
    pub fn len(&self) -> usize {
        self.0.len()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{LowPass, Notch};

    const PERIOD: f64 = 250e-6;

    fn filters(list: &[TorqueFilter]) -> Filters {
        Filters::new(&TorqueFilters::try_from(list.to_vec()).unwrap(), PERIOD)
    }

    /// Gain and phase (rad) on a sine, from the last of many whole periods by Fourier's integrals.
    fn response(filters: &Filters, samples_per_period: u32) -> (f64, f64) {
        let mut state = filters.settled(0.0);
        let (mut re, mut im) = (0.0, 0.0);
        let periods = 400;
        for n in 0..periods * samples_per_period {
            let (s, c) = math::sin_cos(
                TAU * f64::from(n % samples_per_period) / f64::from(samples_per_period),
            );
            let y = filters.step(&mut state, s);
            if n >= (periods - 1) * samples_per_period {
                re += y * s;
                im += y * c;
            }
        }
        let half = 0.5 * f64::from(samples_per_period);
        (math::hypot(re, im) / half, math::atan2(im, re))
    }

    #[test]
    fn a_notch_takes_out_its_middle_and_lets_the_rest_through() {
        // 250 Hz: 16 samples a period
        let notch = |depth_db| {
            filters(&[TorqueFilter::Notch(Notch {
                frequency_hz: 250.0,
                width_hz: 50.0,
                depth_db,
            })])
        };
        let (gain, _) = response(&notch(30.0), 16);
        assert!((gain / math::pow(10.0, -1.5) - 1.0).abs() < 1e-9, "{gain}");
        let (far, _) = response(&notch(30.0), 400);
        assert!((far - 1.0).abs() < 1e-3, "{far}");
        let (flat, phase) = response(&notch(0.0), 16);
        assert!(
            (flat - 1.0).abs() < 1e-12 && phase.abs() < 1e-12,
            "{flat} {phase}"
        );
    }

    #[test]
    fn a_low_pass_has_the_continuous_response_at_its_corner() {
        // at w the filter is 1/(2 D j): half over D, a quarter turn behind
        for damping in [0.3, std::f64::consts::FRAC_1_SQRT_2, 1.2] {
            let low = filters(&[TorqueFilter::LowPass(LowPass {
                frequency_hz: 500.0,
                damping,
            })]);
            let (gain, phase) = response(&low, 8);
            assert!(
                (gain * 2.0 * damping - 1.0).abs() < 1e-9,
                "{damping}: {gain}"
            );
            assert!((phase + 0.25 * TAU).abs() < 1e-9, "{damping}: {phase}");
        }
    }

    #[test]
    fn a_constant_goes_through_from_the_first_tick() {
        let both = filters(&[
            TorqueFilter::Notch(Notch {
                frequency_hz: 180.0,
                width_hz: 60.0,
                depth_db: 40.0,
            }),
            TorqueFilter::LowPass(LowPass {
                frequency_hz: 700.0,
                damping: 0.7,
            }),
        ]);
        let mut state = both.settled(3.7);
        for _ in 0..100 {
            assert!((both.step(&mut state, 3.7) - 3.7).abs() < 1e-13);
        }
    }
}
