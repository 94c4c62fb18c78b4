//! How far a way that is no straight line is off the one that is meant.

use crate::machine::{BOW_LIMIT_UM, Machine};
use crate::options::SimulateOptions;
use crate::results::PlanInfo;
use lostmotion_base::BlockRef;
use lostmotion_drive::config::Interpolator;
use serde::{Deserialize, Serialize};

/// The largest distance of a way that is no straight line from another, and where.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Straightness {
    /// Distance, um.
    pub max_um: f64,
    /// The block.
    pub block: BlockRef,
}

/// How far the tool may be off its way between two commands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BowLimit {
    /// Distance, um.
    pub um: f64,
    /// Whether the motion is planned to keep it; else there is a warning where it does not.
    pub is_kept: bool,
}

impl BowLimit {
    /// Kept where somebody has said it, and where a drive joins commands by straight lines.
    pub fn new(machine: &Machine, options: &SimulateOptions) -> BowLimit {
        let told = options.bow_limit_um.or(machine.simulate().bow_limit_um);
        let is_linear = machine
            .axes()
            .iter()
            .any(|axis| axis.config.interpolator == Interpolator::Linear);
        BowLimit {
            um: told.unwrap_or(BOW_LIMIT_UM),
            is_kept: told.is_some() || is_linear,
        }
    }
}

impl PlanInfo {
    /// A warning where the tool leaves its way between two commands by more than a limit, um.
    pub fn bow_warning(&self, limit_um: f64) -> Option<String> {
        let Straightness { max_um, block } = self.bow.filter(|bow| bow.max_um > limit_um)?;
        let line = block.span.line;
        Some(format!(
            "line {line}: between two commands the tool bows by {max_um:.3} um from its way if the joints go straight (limit {limit_um} um); a shorter command cycle, a \
             lower speed or a smoother interpolator help"
        ))
    }
}
