//! How the flanks push on each other.

use serde::{Deserialize, Serialize};

/// Law of the contact torque at penetration p of a flank with closing speed v (stiffness k, damping
/// d).
///
/// Published models differ, and bounce differently. With a gap of zero both flanks touch at once
/// and the shaft is the plain spring and damper, whichever law is chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ContactLaw {
    /// `k p + d v` as long as p > 0: pulls while the flanks separate fast.
    #[default]
    Linear,
    /// `max(0, k p + d v)`: never pulls.
    Clamped,
    /// `k p + clamp(d v, -k p, k p)`: never pulls, and no jump of torque when the flanks meet (the
    /// bounded damping of the Modelica Standard Library's elasto-backlash).
    Bounded,
}

/// Where in its gap the axis stands at the start, as the motor's lead over the load: -1 on the
/// negative flank, 0 in the middle, 1 on the positive flank.
///
/// The motor stands at the start position; the load is off it by this part of half the gap.
/// Positions therefore count from the middle of the gap. If the constant load torque is more than
/// the friction can hold, the axis starts on the flank that carries it, wound up, with the servo
/// already holding it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub struct StartInGap(pub f64);
