//! Serial machines from a list of joints: machine tools ([`MachineTool`]) where
//! the rotary words are rotary joints, arms where words are a pose (in closed form or by Newton's
//! method).

use crate::chain::{Chain, GaugeSpec, JointSpec};
use crate::kind::finite;
use crate::machine_tool::MachineTool;
use crate::{KindSpec, Kinematics, Reach, TipControl, pose};
use lostmotion_base::AxisId;
use lostmotion_base::units::rad;
use serde::{Deserialize, Serialize};

/// How far the tool's direction may leave the programmed one where a machine file does not say,
/// degrees. A choice: larger lets the tool lean away on the way, smaller makes more steps and
/// refuses more passages of a pole.
const DEFAULT_ORIENTATION_TOLERANCE_DEG: f64 = 0.1;
/// Largest orientation tolerance that is accepted, degrees: more is taken for a slip of the unit.
const MAX_ORIENTATION_TOLERANCE_DEG: f64 = 10.0;

/// What the rotary words of a chain are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Words {
    /// Positions of the rotary joints of that name: machine tools.
    Axes,
    /// Roll, pitch and yaw of the tool's frame: arms.
    Pose,
}

/// Describes a serial machine, joint by joint.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ChainSpec {
    /// When X Y Z are the tool's tip: `always` or `programmed`; `always` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tip_control: Option<TipControl>,
    /// How far the tool's direction may leave the programmed one while it turns, deg; 0.1 if not
    /// given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orientation_tolerance_deg: Option<f64>,
    /// What the rotary words are: `axes` or `pose`; `axes` if not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub words: Option<Words>,
    /// Joints at home in the order of the chain, mm and deg: chooses among the solutions where
    /// words are a pose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub home: Option<Vec<f64>>,
    /// The spindle of a chain with all joints at zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gauge: Option<GaugeSpec>,
    /// Joints of a chain in the order from the workpiece to the tool.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joint: Vec<JointSpec>,
}

impl KindSpec for ChainSpec {
    const SUMMARY: &'static str =
        "joints in any order from workpiece to tool: tables, heads, nutating ones, arms";

    fn build(&self, reach: &Reach) -> Result<Box<dyn Kinematics>, String> {
        finite("home", self.home.as_deref().unwrap_or_default())?;
        let chain = Chain::new(&self.joint, &self.gauge.unwrap_or_default())?;
        match self.words {
            Some(Words::Pose) => {
                // The joints of an arm are found from the whole pose: nothing of a machine tool's
                // rotary words applies.
                if self.tip_control.is_some() || self.orientation_tolerance_deg.is_some() {
                    return Err(
                        "words that are a pose have no use for `tip_control` and `orientation_tolerance_deg`"
                            .into(),
                    );
                }
                pose::build(
                    ChainSpec::KIND,
                    chain,
                    self.home.as_deref().unwrap_or_default(),
                    reach,
                )
            }
            Some(Words::Axes) | None => {
                if self.home.is_some() {
                    return Err("it has no use for `home` unless `words` is `pose`".into());
                }
                let tolerance = orientation_tolerance(self.orientation_tolerance_deg)?;
                Ok(Box::new(MachineTool::new(
                    ChainSpec::KIND,
                    chain,
                    reach,
                    tolerance,
                )?))
            }
        }
    }

    fn tip_control(&self) -> TipControl {
        self.tip_control.unwrap_or_default()
    }

    /// A chain says itself which of its joints are rotary.
    fn is_rotary(&self, joint: AxisId) -> bool {
        let own = self.joint.iter().find(|own| own.axis_id() == Some(joint));
        own.map_or(joint.is_rotary(), JointSpec::is_rotary)
    }
}

/// How far the tool's direction may leave the programmed one, rad.
pub(crate) fn orientation_tolerance(given_deg: Option<f64>) -> Result<f64, String> {
    let tolerance_deg = given_deg.unwrap_or(DEFAULT_ORIENTATION_TOLERANCE_DEG);
    if tolerance_deg > 0.0 && tolerance_deg <= MAX_ORIENTATION_TOLERANCE_DEG {
        return Ok(rad(tolerance_deg));
    }
    Err(format!(
        "`orientation_tolerance_deg` is {tolerance_deg}; it has to be above 0 and at most {MAX_ORIENTATION_TOLERANCE_DEG}"
    ))
}
