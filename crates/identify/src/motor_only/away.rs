//! A load that breaks away: its motion from the contact torque, sample by sample.

use super::segments::Cutter;

/// The motion of a load from where it breaks away, sample by sample, for p = 1.
pub(super) struct BrokenAway {
    /// Sample at which it starts.
    first: usize,
    /// Travel, travel per N m of friction, impulse of the motor beyond that at the start, and
    /// speed.
    motion: Vec<[f64; 4]>,
    inertia: f64,
}

impl BrokenAway {
    /// `start`: first window whose torque exceeds the certain rest; `end`: last window that is
    /// asked for.
    pub(super) fn new(cutter: &Cutter, start: usize, end: usize, side: f64) -> BrokenAway {
        let load = cutter.load;
        let at = |sample: usize| &cutter.samples[(sample - 1).min(cutter.samples.len() - 1)];
        let beyond = |sample: usize| {
            side * (at(sample).torque_nm
                - load.constant_nm
                - load.viscous_nm_s_per_rad * at(sample).rate_rad_s)
                - load.coulomb_nm
        };
        let (earliest, last) = (start * cutter.half, (end + 2) * cutter.half);
        let first = (earliest..last)
            .find(|&sample| beyond(sample) > 0.0 && beyond(sample + 1) > 0.0)
            .unwrap_or(last);
        let motor = |sample: usize| {
            at(sample).torque_nm + cutter.motor_inertia_kgm2 * at(sample).acceleration_rad_s2
        };
        let (period, square) = (cutter.period_s, cutter.period_s * cutter.period_s);
        let (mut before, mut now, mut impulse, mut speed) = ([0.0; 2], [0.0; 2], 0.0, 0.0);
        let mut motion = Vec::new();
        for sample in first..last {
            let steps = [side * beyond(sample), -side];
            let late = period * (motor(sample) - motor(first));
            motion.push([
                now[0],
                now[1],
                impulse + 0.5 * late,
                speed + 0.5 * period * steps[0],
            ]);
            let next = std::array::from_fn(|i| 2.0 * now[i] - before[i] + square * steps[i]);
            (before, now) = (now, next);
            impulse += late;
            speed += period * steps[0];
        }
        BrokenAway {
            first,
            motion,
            inertia: load.inertia_kgm2,
        }
    }

    /// Averages over a window's triangle.
    pub(super) fn chosen(&self, window: usize, half: usize) -> Chosen {
        let centre = (window + 1) * half;
        let mut sums = [0.0; 4];
        for sample in centre - half..=centre + half {
            let weight = (half - sample.abs_diff(centre)) as f64 / (half * half) as f64;
            let motion = sample
                .checked_sub(self.first)
                .and_then(|n| self.motion.get(n));
            if let Some(motion) = motion {
                sums.iter_mut()
                    .zip(motion)
                    .for_each(|(sum, value)| *sum += weight * value);
            }
        }
        let [travel, friction, impulse, speed] = sums;
        let under_way = (centre as f64 - self.first as f64).max(0.0) / half as f64;
        Chosen {
            travel,
            friction,
            impulse,
            under_way,
            load_speed: speed / self.inertia,
            ..Chosen::at_rest(window)
        }
    }
}

/// A window of a crossing with what the load's travel in it consists of.
pub(super) struct Chosen {
    pub(super) window: usize,
    pub(super) travel: f64,
    pub(super) impulse: f64,
    pub(super) friction: f64,
    pub(super) drag: f64,
    pub(super) load_speed: f64,
    pub(super) under_way: f64,
}

impl Chosen {
    pub(super) fn at_rest(window: usize) -> Chosen {
        Chosen {
            window,
            travel: 0.0,
            impulse: 0.0,
            friction: 0.0,
            drag: 0.0,
            load_speed: 0.0,
            under_way: 0.0,
        }
    }
}
