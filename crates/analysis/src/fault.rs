//! What is wrong with a tuning, and how to mend it.

use super::loops::{AxisAnalysis, LoopAnalysis};
use lostmotion_methods::AxisConfig;
use std::fmt;

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
                format!("{} has to be less than {factor:.3} times what it is; delays and filters cost phase, too", at.kind.gain_key())
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
