//! Limit cycles in a simulation: does a load that should stand still swing, how far and how fast?

use super::model::Feedback;
use lostmotion_drive::AxisSim;
use lostmotion_drive::config::Interpolator;
use lostmotion_drive::runner::{AxisOutput, AxisRunner};
use lostmotion_drive::signal::Setpoint;
use lostmotion_methods::AxisConfig;
use lostmotion_methods::load_feedback::LoadFeedback;
use lostmotion_methods::none::Uncompensated;
use serde::Serialize;

/// A swing around a standing reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cycle {
    /// Half of peak to peak, in the unit of the positions given.
    pub amplitude: f64,
    /// Swings a second, Hz.
    pub frequency_hz: f64,
}

/// Turning points that are remembered. Derived: nine enclose four whole swings.
const REMEMBERED_TURNS: usize = 9;
/// Least size of a swing over the one before: below, it is ringing that dies away. A choice: nearer
/// to 1 the scatter of a true cycle would pass for decay, lower a slow decay for a cycle.
const MIN_SWING_RATIO: f64 = 0.9;
/// Most time of the last two swings over that of the first two: above, a load bounces ever slower.
/// A choice: nearer to 1 a cycle whose period scatters is missed, higher a bounce that slows little
/// is taken for one.
const MAX_SLOWING: f64 = 1.05;

/// Watches a load while its reference stands still.
///
/// Constant memory. A turning point counts where the load has come back from it by more than
/// `least_swing`. A limit cycle is told from what dies away by the last four swings: none may be
/// smaller than nine tenths of the one before (ringing), and the last two may not take longer than
/// the first two by more than a twentieth (a load that bounces between its flanks, ever slower).
///
/// ```
/// use lostmotion_analysis::CycleDetector;
/// use lostmotion_base::math;
///
/// // A load that swings by 0.1 about a standing reference, five times a second.
/// let mut detector = CycleDetector::new(1e-3, 0.01);
/// for n in 0..2000 {
///     detector.push(0.0, 0.1 * math::sin(std::f64::consts::TAU * 5e-3 * f64::from(n)));
/// }
/// let cycle = detector.cycle().ok_or("no limit cycle")?;
/// assert!((cycle.frequency_hz - 5.0).abs() < 0.1 && (cycle.amplitude - 0.1).abs() < 1e-3);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct CycleDetector {
    least_swing: f64,
    period_s: f64,
    reference: Option<f64>,
    sample: u64,
    /// The furthest place since the last turning point, with its sample.
    extreme: (f64, u64),
    rising: Option<bool>,
    turns: [(f64, u64); REMEMBERED_TURNS],
    count: usize,
}

impl CycleDetector {
    /// For samples at a period, and swings (peak to peak) above a least one, in the unit of the
    /// positions.
    pub fn new(period_s: f64, least_swing: f64) -> CycleDetector {
        let nowhere = (0.0, 0);
        CycleDetector {
            least_swing,
            period_s,
            reference: None,
            sample: 0,
            extreme: nowhere,
            rising: None,
            turns: [nowhere; REMEMBERED_TURNS],
            count: 0,
        }
    }

    /// The next sample.
    pub fn push(&mut self, reference: f64, load: f64) {
        self.sample += 1;
        // The reference moves: nothing of what was seen belongs to a swing around rest.
        if self.reference != Some(reference) {
            self.reference = Some(reference);
            (self.rising, self.count, self.extreme) = (None, 0, (load, self.sample));
            return;
        }
        let (furthest, _) = self.extreme;
        match self.rising {
            // Not known yet which way it swings: the first motion that is large enough tells.
            None if (load - furthest).abs() > self.least_swing => {
                self.rising = Some(load > furthest);
                self.extreme = (load, self.sample);
            }
            None => {}
            Some(rising) if (load > furthest) == rising => self.extreme = (load, self.sample),
            // Back from the extreme by a swing (hysteresis): the extreme was a turning point.
            Some(rising) if (load - furthest).abs() > self.least_swing => {
                self.turns.rotate_left(1);
                self.turns[REMEMBERED_TURNS - 1] = self.extreme;
                self.count += 1;
                self.rising = Some(!rising);
                self.extreme = (load, self.sample);
            }
            Some(_) => {}
        }
    }

    /// The limit cycle at the end of what was seen, if there is one.
    pub fn cycle(&self) -> Option<Cycle> {
        if self.count < REMEMBERED_TURNS {
            return None;
        }
        // Period: four swings lie between the first and the last turning point.
        let (first, last) = (self.turns[0].1, self.turns[REMEMBERED_TURNS - 1].1);
        let period_s = (last - first) as f64 * self.period_s / (REMEMBERED_TURNS / 2) as f64;
        // A swing that has come to rest makes no turning points.
        let since = (self.sample - last) as f64 * self.period_s;
        // Peak to peak from each turning point to the next.
        let swings: Vec<f64> = self
            .turns
            .windows(2)
            .map(|pair| (pair[1].0 - pair[0].0).abs())
            .collect();
        let keeps = swings
            .windows(2)
            .all(|pair| pair[1] > MIN_SWING_RATIO * pair[0]);
        let middle = self.turns[REMEMBERED_TURNS / 2].1;
        let steady = (last - middle) as f64 <= MAX_SLOWING * (middle - first) as f64;
        let mean = swings.iter().sum::<f64>() / swings.len() as f64;
        (keeps && steady && since < 2.0 * period_s).then(|| Cycle {
            amplitude: 0.5 * mean,
            frequency_hz: 1.0 / period_s,
        })
    }
}

// The limit cycle of the simulated axis, beside the one that is predicted.

/// Length of the run, s. A choice: longer costs time; a cycle has to show enough turns after the
/// push within it.
const RUN_S: f64 = 4.0;
/// Length of the push, s. A choice: a slower push lays the load softly on its flank and may start
/// no cycle, a quicker one asks for more torque.
const PUSH_S: f64 = 0.04;

/// What an axis that has been checked does after a quick move of one and a half gaps: the limit
/// cycle it is in four seconds later, in its own unit, if it is in one. The position loop is closed
/// on the motor or on the load.
pub fn simulated_cycle(config: &AxisConfig, feedback: Feedback) -> Option<Cycle> {
    let config = AxisConfig {
        interpolator: Interpolator::QuinticHermite,
        ..config.clone()
    };
    match feedback {
        Feedback::Motor => watch(&config, AxisSim::new(&config, Uncompensated, 0.0)),
        Feedback::Load => watch(&config, AxisSim::new(&config, LoadFeedback, 0.0)),
    }
}

fn watch(config: &AxisConfig, mut axis: impl AxisRunner) -> Option<Cycle> {
    let gap = config.gap_in_unit();
    // Swings below a fiftieth of the gap are no limit cycle through it.
    let mut detector = CycleDetector::new(config.servo_period_s(), 0.02 * gap);
    let period = config.cycles.command().period_s();
    let mut out = AxisOutput::new(false);
    for tick in 0..(RUN_S / period).round() as u32 {
        out.clear();
        axis.push(&[push(1.5 * gap, tick, period)], &mut out).ok()?;
        for (reference, load) in out.reference.iter().zip(&out.load) {
            detector.push(*reference, *load);
        }
    }
    detector.cycle()
}

/// A quintic from rest to rest.
fn push(distance: f64, tick: u32, period: f64) -> Setpoint {
    let ticks = (PUSH_S / period).round() as u32;
    let duration = f64::from(ticks) * period;
    let u = f64::from(tick.min(ticks)) / f64::from(ticks);
    // Minimum-jerk polynomial: no velocity and no acceleration at either end.
    let v = 1.0 - u;
    Setpoint {
        position: distance * u * u * u * (10.0 - 15.0 * u + 6.0 * u * u),
        velocity: Some(distance * 30.0 * u * u * v * v / duration),
        acceleration: Some(distance * 60.0 * u * v * (1.0 - 2.0 * u) / (duration * duration)),
        ..Setpoint::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::math;

    fn watch(load: impl Fn(f64) -> f64) -> Option<Cycle> {
        let mut detector = CycleDetector::new(250e-6, 1e-3);
        for n in 0..8000 {
            let t = f64::from(n) * 250e-6;
            detector.push(if t < 0.3 { t } else { 0.3 }, load(t));
        }
        detector.cycle()
    }

    #[test]
    fn a_swing_is_seen_and_ringing_is_not() {
        let found = watch(|t| 0.02 * math::sin(std::f64::consts::TAU * 8.0 * t)).unwrap();
        assert!(
            (found.frequency_hz / 8.0 - 1.0).abs() < 1e-2
                && (found.amplitude / 0.02 - 1.0).abs() < 1e-3,
            "{found:?}"
        );
        assert_eq!(
            watch(|t| 0.02 * math::exp(-2.0 * t) * math::sin(50.0 * t)),
            None
        );
        assert_eq!(
            watch(|t| if t < 1.5 {
                0.02 * math::sin(50.0 * t)
            } else {
                0.0
            }),
            None
        );
        // ever slower
        assert_eq!(
            watch(|t| 0.02 * math::sin(40.0 * math::log(1.0 + 2.0 * t))),
            None
        );
        assert_eq!(watch(|t| 2e-4 * math::sin(50.0 * t)), None);
    }
}
