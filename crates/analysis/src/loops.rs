//! The loops of an axis, one by one, in both regimes.

use super::margins::Margins;
use super::model::{Coupling, Feedback, Model};
use super::response::StateSpace;
use lostmotion_methods::AxisConfig;
use serde::Serialize;
use std::fmt;

/// A loop of the cascade.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LoopKind {
    /// Current PI, rotor held.
    Current,
    /// Velocity PI, current loop closed, position loop open.
    Velocity,
    /// Position P, velocity loop closed.
    Position,
}

impl LoopKind {
    /// Key of its gain in the table `drive`.
    pub fn gain_key(self) -> &'static str {
        match self {
            LoopKind::Current => "current_gain_v_per_a",
            LoopKind::Velocity => "velocity_gain_a_s_per_rad",
            LoopKind::Position => "position_gain_per_s",
        }
    }
}

impl fmt::Display for LoopKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            LoopKind::Current => "current loop",
            LoopKind::Velocity => "velocity loop",
            LoopKind::Position => "position loop",
        })
    }
}

/// The masses that the motor moves in an analysis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Regime {
    /// A flank in contact: motor and load with the shaft between them.
    Engaged,
    /// The motor alone, between the flanks.
    Gap,
}

impl fmt::Display for Regime {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Regime::Engaged => "on a flank",
            Regime::Gap => "in the gap",
        })
    }
}

/// One loop in one regime.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LoopAnalysis {
    /// Which loop.
    pub kind: LoopKind,
    /// What the motor moves.
    pub regime: Regime,
    /// Its margins.
    pub margins: Margins,
    /// Factor on its gain up to which it is stable, where it is not; `None` if it is stable, or
    /// unstable at any gain.
    pub stable_factor: Option<f64>,
}

/// Dead times of the drive, us.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct LoopDelays {
    /// From a current's measurement to the middle of the period in which the voltage computed from
    /// it acts.
    pub current_us: f64,
    /// From the middle of the encoder's difference to the middle of the period in which the command
    /// computed from it holds, without the current loop and the filters.
    pub velocity_us: f64,
    /// From the encoder's reading to the middle of that period.
    pub position_us: f64,
}

impl LoopDelays {
    /// The dead times of an axis.
    pub fn of(config: &AxisConfig) -> LoopDelays {
        let (drive, current_us, half) = (
            &config.drive,
            config.current_period_us(),
            0.5 * config.cycles.servo_us,
        );
        let position_us = f64::from(drive.command_delay_periods) * current_us + half;
        LoopDelays {
            current_us: (f64::from(drive.voltage_delay_periods) + 0.5) * current_us,
            velocity_us: position_us + half,
            position_us,
        }
    }
}

/// Results of the linear analysis of an axis.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct AxisAnalysis {
    /// From the innermost loop outwards; current, velocity and position loop on a flank, then the
    /// latter two in the gap if there is one.
    pub loops: Vec<LoopAnalysis>,
    /// Dead times.
    pub delays: LoopDelays,
}

impl AxisAnalysis {
    /// A loop's margins, if it was analysed.
    pub fn margins(&self, kind: LoopKind, regime: Regime) -> Option<&Margins> {
        self.loops
            .iter()
            .find(|at| at.kind == kind && at.regime == regime)
            .map(|at| &at.margins)
    }
}

/// Analyses every loop of an axis that has been checked. The position loop is taken as closed on
/// the motor's encoder, or on the load's scale on a flank if the axis' method is `load-feedback`.
///
/// ```
/// use lostmotion_analysis::{LoopKind, Regime, analyse};
/// use lostmotion_methods::AxisConfig;
///
/// let axis = AxisConfig::paper();
/// let analysis = analyse(&axis);
/// assert_eq!(analysis.fault(&axis), None);
/// // The motor alone is lighter: the velocity loop is faster in the gap than on a flank.
/// let crossover = |regime| analysis.margins(LoopKind::Velocity, regime)?.crossover_hz;
/// assert!(crossover(Regime::Gap) > crossover(Regime::Engaged));
/// ```
pub fn analyse(config: &AxisConfig) -> AxisAnalysis {
    let feedback = if config.compensation.method.closes_on_load() {
        Feedback::Load
    } else {
        Feedback::Motor
    };
    // The current loop is looked at alone; its rotor is held, so that the regime does not matter.
    let engaged = Model::new(config, Coupling::ENGAGED);
    let mut loops = vec![look(LoopKind::Current, Regime::Engaged, |gain| {
        Model::current_loop(config, gain)
    })];
    let mut regime = |model: &Model, regime: Regime, feedback: Feedback| {
        loops.push(look(LoopKind::Velocity, regime, |gain| {
            model.velocity_loop(gain)
        }));
        // Without a position gain there is no position loop.
        if config.drive.position_gain_per_s > 0.0 {
            loops.push(look(LoopKind::Position, regime, |gain| {
                model.position_loop(feedback, gain)
            }));
        }
    };
    regime(&engaged, Regime::Engaged, feedback);
    // In the gap the load does not follow the motor: its scale closes no loop there.
    if config.reflected_load().gap_rad > 0.0 {
        regime(
            &Model::new(config, Coupling::GAP),
            Regime::Gap,
            Feedback::Motor,
        );
    }
    AxisAnalysis {
        loops,
        delays: LoopDelays::of(config),
    }
}

fn look(kind: LoopKind, regime: Regime, open: impl Fn(f64) -> StateSpace) -> LoopAnalysis {
    let margins = Margins::of(&open(1.0));
    // Only an unstable loop needs the factor that would make it stable.
    let stable_factor = if margins.stable() {
        None
    } else {
        stable_factor(&open)
    };
    LoopAnalysis {
        kind,
        regime,
        margins,
        stable_factor,
    }
}

/// The largest factor below 1 up to which a loop is stable: down in steps of 10 % until it is, then
/// halved to the border.
fn stable_factor(open: &impl Fn(f64) -> StateSpace) -> Option<f64> {
    let stable = |gain: f64| open(gain).closed_radius() < 1.0;
    // Down in steps of 10 % until it is stable: the border then lies within the last step.
    let mut low = 1.0;
    let mut high = 1.0;
    while !stable(low) {
        high = low;
        low *= 0.9;
        if low < 1e-4 {
            return None;
        }
    }
    // Bisection to the border of stability.
    for _ in 0..30 {
        let middle = 0.5 * (low + high);
        if stable(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(low)
}

// Faults of a tuning, with hints.

/// Why a tuning is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fault {
    /// The closed loop has a pole on or outside the unit circle.
    Unstable(LoopAnalysis),
    /// The phase margin is below the least one (deg).
    Phase(LoopAnalysis, f64),
    /// The gain margin is below the least one (dB).
    Gain(LoopAnalysis, f64),
}

impl Fault {
    /// The loop at fault.
    pub fn at(&self) -> &LoopAnalysis {
        match self {
            Fault::Unstable(at) | Fault::Phase(at, _) | Fault::Gain(at, _) => at,
        }
    }

    /// How to mend it.
    pub fn hint(&self) -> String {
        let at = self.at();
        match (self, at.stable_factor) {
            (Fault::Unstable(_), Some(factor)) => {
                format!("{} has to be less than {factor:.3} times its present value; delays and filters cost phase, too", at.kind.gain_key())
            }
            (Fault::Unstable(_), None) => {
                "no gain of this loop makes it stable: look at the integral time, the delays and the filters".to_owned()
            }
            _ => format!("lower {}, or allow less in drive.least_margins", at.kind.gain_key()),
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let LoopAnalysis {
            kind,
            regime,
            margins,
            ..
        } = self.at();
        match self {
            Fault::Unstable(_) => {
                write!(
                    f,
                    "the {kind} is unstable {regime}: largest pole {:.4}",
                    margins.spectral_radius
                )?;
                let gain = margins
                    .gain_margin_db
                    .map(|db| format!(", gain margin {db:.1} dB"));
                let phase = margins
                    .phase_margin_deg
                    .map(|deg| format!(", phase margin {deg:.1} deg"));
                write!(
                    f,
                    "{}{}",
                    gain.unwrap_or_default(),
                    phase.unwrap_or_default()
                )
            }
            Fault::Phase(_, least) => {
                write!(
                    f,
                    "the {kind} has a phase margin of {:.1} deg {regime}; at least {least} deg are asked for",
                    margins.phase_margin_deg.unwrap_or(0.0)
                )
            }
            Fault::Gain(_, least) => {
                write!(
                    f,
                    "the {kind} has a gain margin of {:.1} dB {regime}; at least {least} dB are asked for",
                    margins.gain_margin_db.unwrap_or(0.0)
                )
            }
        }
    }
}

impl AxisAnalysis {
    /// The first thing wrong with the tuning, innermost loop first: instability, then margins below
    /// those that the axis asks for.
    pub fn fault(&self, config: &AxisConfig) -> Option<Fault> {
        let least = config.drive.least_margins;
        // Instability first: margins of an unstable loop have no meaning.
        let unstable = self
            .loops
            .iter()
            .find(|at| !at.margins.stable())
            .map(|at| Fault::Unstable(*at));
        let short = |at: &LoopAnalysis| {
            if at
                .margins
                .phase_margin_deg
                .is_some_and(|deg| deg < least.phase_deg)
            {
                return Some(Fault::Phase(*at, least.phase_deg));
            }
            at.margins
                .gain_margin_db
                .is_some_and(|db| db < least.gain_db)
                .then_some(Fault::Gain(*at, least.gain_db))
        };
        unstable.or_else(|| self.loops.iter().find_map(short))
    }
}
