//! How far a way that is no straight line is off the one that is meant.

use crate::results::PlanInfo;
use lostmotion_base::BlockRef;
use serde::{Deserialize, Serialize};

/// The largest distance of a way that is no straight line from another, and where.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Straightness {
    /// Distance, um.
    pub max_um: f64,
    /// The block.
    pub block: BlockRef,
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
