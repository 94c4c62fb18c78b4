//! Which windows show the shaft in firm contact, and on which flank.

use crate::{deadzone::Deadzone, error::NotExcited, settings::FitSettings, window::WindowSample};
use lostmotion_base::math::quantile;

/// Median of the absolute value of a standard normal variable.
pub(crate) const MEDIAN_OF_NORMAL: f64 = 0.6745;
/// Share of the log's largest torque from which on the side counts as known, unless the torque's
/// noise is larger. A choice: smaller takes samples in the gap for contact, larger gives up slow
/// strokes.
pub(crate) const MIN_TORQUE_SHARE: f64 = 0.02;
/// Standard deviations of noise that a torque or a slip has to exceed to count. Derived: normal
/// noise exceeds six of them once in 5e8 samples.
pub(crate) const NOISE_FACTOR: f64 = 6.0;

/// Share of the usual torque from which on the side counts as known where the torque is taken from
/// the position difference. A choice: the edges of the gap are known to a few parts in a hundred of
/// the wind-up there.
const ZONE_MARGIN: f64 = 0.2;

/// One window in firm contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactSample {
    /// Episode that it belongs to, counted from 0 over the log.
    pub episode: usize,
    /// Its window, counted from 0 over the log.
    pub index: usize,
    /// 1 or -1.
    pub side: f64,
    /// What was measured in it.
    pub window: WindowSample,
    /// The torque as its instruments tell it, free of the current's noise, N m.
    pub told_torque_nm: f64,
    /// The rate of the position difference as its instruments tell it, rad/s.
    pub told_rate_rad_s: f64,
}

/// The part of a log in firm contact.
#[derive(Clone, Debug, PartialEq)]
pub struct Contact {
    /// Windows in order of time.
    pub samples: Vec<ContactSample>,
    /// Torque threshold in force, N m.
    pub threshold_nm: f64,
    /// Uninterrupted stretches of one side.
    pub episodes: usize,
    /// How often an episode is followed by one of the other side.
    pub traversals: usize,
    /// Side of every window of the log: 1 or -1 in contact, settled or not, 0 elsewhere.
    pub sides: Vec<i8>,
}

impl Contact {
    /// Windows with the positive and with the negative flank in contact.
    pub fn per_side(&self) -> (usize, usize) {
        let positive = self
            .samples
            .iter()
            .filter(|sample| sample.side > 0.0)
            .count();
        (positive, self.samples.len() - positive)
    }
}

/// Selects the windows in firm contact; `spacing_s` is the time between windows.
///
/// A window counts if its torque exceeds the threshold, the position difference does not slip
/// across it, contact on this side has already lasted for the settling time, and the next window is
/// still in contact (its triangle reaches into it). Windows with lost rows, or in which the
/// direction of the motor's own friction is uncertain, are left out with their neighbours.
///
/// # Errors
/// [`NotExcited`] if there is too little torque, only one side, or too few changes of side.
pub fn select(
    windows: &[WindowSample],
    settings: &FitSettings,
    spacing_s: f64,
) -> Result<Contact, NotExcited> {
    let SideTorque {
        torques_nm,
        largest_nm,
        threshold_nm,
    } = SideTorque::of(windows, settings);
    if largest_nm <= threshold_nm {
        return Err(NotExcited::TorqueBelowThreshold {
            largest_nm,
            threshold_nm,
        });
    }
    let sides = sides(
        windows,
        &torques_nm,
        threshold_nm,
        slip_limit(windows, settings),
    );
    // the saturating cast turns an absurd settling time into one that leaves nothing over
    let settle = ((settings.settle_s / spacing_s).ceil() as usize).max(1);
    let contact = episodes(windows, sides, settle, threshold_nm);
    let (positive, negative) = contact.per_side();
    if positive == 0 || negative == 0 {
        return Err(NotExcited::OneSide { positive, negative });
    }
    if contact.traversals < settings.min_traversals {
        return Err(NotExcited::TooFewTraversals {
            seen: contact.traversals,
            needed: settings.min_traversals,
        });
    }
    Ok(contact)
}

/// The torque by which the side of a window is judged.
struct SideTorque {
    torques_nm: Vec<f64>,
    /// Their largest size, N m.
    largest_nm: f64,
    /// From here on the side counts as known, N m.
    threshold_nm: f64,
}

impl SideTorque {
    /// The contact torque itself, or where the noise of the current would hide too much of it, the
    /// torque that goes with the position difference.
    fn of(windows: &[WindowSample], settings: &FitSettings) -> Self {
        // A high quantile, not the maximum: a spike of the current must not set the threshold.
        let largest =
            |torques: &[f64]| quantile(torques.iter().map(|torque| torque.abs()).collect(), 0.999);
        let torques_nm: Vec<f64> = windows.iter().map(|window| window.torque_nm).collect();
        let largest_nm = largest(&torques_nm);
        // Below it the side is unknown: the torque is small, or noise could turn its sign.
        let (share_nm, noise_nm) = (
            MIN_TORQUE_SHARE * largest_nm,
            NOISE_FACTOR * noise(torques_nm.iter().copied()),
        );
        let plain = SideTorque {
            threshold_nm: settings
                .torque_threshold_nm
                .unwrap_or(share_nm.max(noise_nm)),
            torques_nm,
            largest_nm,
        };
        // Selecting by a noisy torque would also select its noise: what lies above the threshold
        // lies there partly by chance. The position difference has no part in that noise.
        let Some(zone) = Deadzone::fit(windows) else {
            return plain;
        };
        let torques_nm: Vec<f64> = windows
            .iter()
            .map(|window| zone.torque(window.difference_rad))
            .collect();
        let largest_nm = largest(&torques_nm);
        let pressing = torques_nm
            .iter()
            .map(|torque| torque.abs())
            .filter(|torque| *torque > 0.0);
        let usual_nm = quantile(pressing.collect(), 0.5);
        SideTorque {
            threshold_nm: settings
                .torque_threshold_nm
                .unwrap_or((MIN_TORQUE_SHARE * largest_nm).max(ZONE_MARGIN * usual_nm)),
            torques_nm,
            largest_nm,
        }
    }
}

fn slip_limit(windows: &[WindowSample], settings: &FitSettings) -> f64 {
    let differences = || windows.iter().map(|window| window.difference_rad);
    // Span of gap and wind-up together, without the outer hundredths of the log.
    let span = quantile(differences().collect(), 0.99) - quantile(differences().collect(), 0.01);
    (settings.slip_share * span).max(NOISE_FACTOR * noise(differences()))
}

/// Side of each window: 1 or -1 in contact, 0 elsewhere.
fn sides(
    windows: &[WindowSample],
    torques_nm: &[f64],
    threshold_nm: f64,
    slip_limit_rad: f64,
) -> Vec<i8> {
    let side = |n: usize| {
        let window = &windows[n];
        let before = &windows[n.saturating_sub(1)];
        let after = windows.get(n + 1).unwrap_or(window);
        // Across the window before and the one after: the shaft crosses the gap, or rings.
        let slips = (after.difference_rad - before.difference_rad).abs() > slip_limit_rad;
        if slips || torques_nm[n].abs() <= threshold_nm {
            0
        } else {
            torques_nm[n].signum() as i8
        }
    };
    (0..windows.len()).map(side).collect()
}

fn episodes(windows: &[WindowSample], sides: Vec<i8>, settle: usize, threshold_nm: f64) -> Contact {
    // A window is sure if it and both neighbours, into which its triangle reaches, are.
    let sure = |n: usize| {
        let last = windows.len() - 1;
        windows[n.saturating_sub(1)..=(n + 1).min(last)]
            .iter()
            .all(|window| window.one_way && window.whole)
    };
    let mut contact = Contact {
        samples: Vec::new(),
        threshold_nm,
        episodes: 0,
        traversals: 0,
        sides: Vec::new(),
    };
    let mut first = 0;
    // One run of windows of the same side at a time.
    while first < sides.len() {
        let side = sides[first];
        let length = sides[first..]
            .iter()
            .take_while(|other| **other == side)
            .count();
        // one window at the end goes, since its triangle already reaches into what follows
        if side != 0 && length > settle + 1 {
            let side = f64::from(side);
            // A traversal is a change of side between episodes that count; short bounces are none.
            contact.traversals += usize::from(
                contact
                    .samples
                    .last()
                    .is_some_and(|last| last.side * side < 0.0),
            );
            let settled = first + settle..first + length - 1;
            contact
                .samples
                .extend(settled.filter(|&n| sure(n)).map(|index| ContactSample {
                    episode: contact.episodes,
                    index,
                    side,
                    window: windows[index],
                    told_torque_nm: windows[index].torque_nm,
                    told_rate_rad_s: windows[index].rate_rad_s,
                }));
            contact.episodes += 1;
        }
        first += length;
    }
    contact.sides = sides;
    contact
}

/// Robust standard deviation of the part of a signal that changes from value to value: median
/// absolute second difference, scaled as for white noise. Signals that vary slowly leave it small.
pub(crate) fn noise(signal: impl Iterator<Item = f64>) -> f64 {
    let signal: Vec<f64> = signal.collect();
    // White noise of deviation sigma has second differences of deviation sqrt(6) sigma.
    let bends = signal
        .windows(3)
        .map(|w| (w[0] - 2.0 * w[1] + w[2]).abs())
        .collect();
    quantile(bends, 0.5) / (MEDIAN_OF_NORMAL * 6.0_f64.sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn windows(torques: &[f64]) -> Vec<WindowSample> {
        torques
            .iter()
            .map(|&torque_nm| WindowSample {
                position_rad: 0.0,
                difference_rad: torque_nm.signum(),
                rate_rad_s: 0.0,
                acceleration_rad_s2: 0.0,
                velocity_rad_s: 0.0,
                torque_nm,
                one_way: true,
                whole: true,
            })
            .collect()
    }

    fn settings() -> FitSettings {
        FitSettings {
            torque_threshold_nm: Some(0.5),
            settle_s: 2.0,
            slip_share: 10.0,
            ..FitSettings::new(1.0, None)
        }
    }

    #[test]
    fn episodes_lose_their_settling_time_and_their_last_window() {
        let torques = [
            1.0, 1.0, 1.1, 1.2, 1.0, 0.0, -1.0, -1.0, -1.3, -1.0, 0.1, 1.0, 1.0, -1.0, 1.0, 1.0,
            1.4, 1.0,
        ];
        let contact = select(&windows(&torques), &settings(), 1.0).unwrap();
        let kept: Vec<_> = contact
            .samples
            .iter()
            .map(|sample| (sample.episode, sample.window.torque_nm))
            .collect();
        assert_eq!(kept, [(0, 1.1), (0, 1.2), (1, -1.3), (2, 1.4)]);
        assert_eq!(
            (contact.episodes, contact.traversals, contact.per_side()),
            (3, 2, (3, 1))
        );
    }

    #[test]
    fn what_is_missing_is_named() {
        assert_eq!(
            select(&windows(&[0.1; 20]), &settings(), 1.0),
            Err(NotExcited::TorqueBelowThreshold {
                largest_nm: 0.1,
                threshold_nm: 0.5
            })
        );
        assert_eq!(
            select(&windows(&[1.0; 20]), &settings(), 1.0),
            Err(NotExcited::OneSide {
                positive: 17,
                negative: 0
            })
        );
        let once = [[1.0; 10], [-1.0; 10]].concat();
        assert_eq!(
            select(&windows(&once), &settings(), 1.0),
            Err(NotExcited::TooFewTraversals { seen: 1, needed: 2 })
        );
    }

    #[test]
    fn a_slipping_difference_is_no_contact() {
        let mut windows = windows(&[1.0; 30]);
        for (n, window) in windows.iter_mut().enumerate() {
            window.difference_rad = if n < 15 { 0.0 } else { 1.0 };
        }
        let torques: Vec<f64> = windows.iter().map(|window| window.torque_nm).collect();
        let sides = sides(&windows, &torques, 0.5, 0.1);
        assert_eq!(
            sides
                .iter()
                .enumerate()
                .filter(|(_, side)| **side == 0)
                .map(|(n, _)| n)
                .collect::<Vec<_>>(),
            [14, 15]
        );
    }

    #[test]
    fn noise_is_seen_through_a_slow_signal() {
        // a sine of amplitude 100 under alternating +-1: second differences of 4
        let signal = (0..1000).map(|k| {
            100.0 * lostmotion_base::math::sin(f64::from(k) * 1e-3)
                + if k % 2 == 0 { 1.0 } else { -1.0 }
        });
        assert!((noise(signal) - 4.0 / (MEDIAN_OF_NORMAL * 6.0_f64.sqrt())).abs() < 1e-3);
    }
}
