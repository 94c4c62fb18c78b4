//! How far the tool bows from its way where joints go straight: from one command to the next, and
//! over a whole block.

use crate::options::BowLimit;
use crate::results::{PlanInfo, Straightness};
use lostmotion_base::Coords;
use lostmotion_base::units::UM_PER_MM;
use lostmotion_kinematics::{JointMap, Kinematics, bow_mm};
use lostmotion_path::Curve;
use lostmotion_plan::{Chord, FeedLimit, Move, Planner, Sample};
use std::sync::Arc;

/// A way shorter than this has no direction, mm. Derived: the rounding of places up to 1 m is some
/// 1e-13 mm.
const NO_DIRECTION_MM: f64 = 1e-12;

/// The largest of both, so far.
#[derive(Clone, Debug)]
pub(crate) struct Bows {
    /// The machine's, with tool-centre-point control: joints to the part's frame.
    kinematics: Arc<dyn Kinematics>,
    period_s: f64,
    /// The limit, um, if the motion keeps one.
    kept_um: Option<f64>,
    last: Option<Sample>,
    commands: Straightness,
    block: Option<Straightness>,
}

impl Bows {
    /// `None` where joints that move along a straight line move the tool along one, unless a limit
    /// has to be kept.
    pub(crate) fn new(
        kinematics: &Arc<dyn Kinematics>,
        period_s: f64,
        limit: BowLimit,
    ) -> Option<Bows> {
        let kept_um = limit.is_kept.then_some(limit.um);
        let kinematics = (kinematics.joint_map() == JointMap::Curved || limit.is_kept)
            .then(|| Arc::clone(kinematics))?;
        Some(Bows {
            kinematics,
            period_s,
            kept_um,
            last: None,
            commands: Straightness::default(),
            block: None,
        })
    }

    /// A planner that keeps the limit, if there is one to keep.
    pub(crate) fn bound(bows: Option<&Bows>, planner: Planner) -> Planner {
        match bows.and_then(|bows| bows.kept_um.map(|um| (bows, um))) {
            Some((bows, um)) => planner.with_chord(Chord::new(
                Arc::clone(&bows.kinematics),
                um / UM_PER_MM,
                bows.period_s,
            )),
            None => planner,
        }
    }

    /// Speed between two commands as a part of what the limit allows; 0 without one.
    pub(crate) fn part(&self, a: &Sample, b: &Sample) -> f64 {
        self.kept_um
            .map_or(0.0, |um| (UM_PER_MM * self.between(a, b) / um).sqrt())
    }

    fn tip(&self, joints: &Coords, tool_mm: &[f64; 3]) -> [f64; 3] {
        self.kinematics.tool_pose(joints, tool_mm).tip
    }

    /// Looks at commands.
    pub(crate) fn samples(&mut self, samples: &[Sample]) {
        for sample in samples {
            // Where nothing moves there is no bow, and a change of the tool's length is no motion.
            if let Some(last) = self
                .last
                .replace(*sample)
                .filter(|last| last.position != sample.position && last.tool_mm == sample.tool_mm)
            {
                let bow_um = UM_PER_MM * self.between(&last, sample);
                if bow_um > self.commands.max_um {
                    self.commands = Straightness {
                        max_um: bow_um,
                        block: sample.block,
                    };
                }
            }
        }
    }

    /// How far the tool is off its planned way in the middle between two commands if every joint
    /// goes straight from the one to the other, mm.
    fn between(&self, a: &Sample, b: &Sample) -> f64 {
        if self.rests(a) || self.rests(b) {
            return 0.0;
        }
        // The middle of the chord of the joints, and that of the quintic Hermite polynomial with the
        // velocities and accelerations of both ends.
        let straight = (a.position + b.position) * 0.5;
        let bend = (a.velocity - b.velocity) * (5.0 / 32.0 * self.period_s);
        let planned = straight
            + bend
            + (a.acceleration + b.acceleration) * (self.period_s * self.period_s / 64.0);
        // Both middles through the kinematics: the bow is measured at the tool, not in the joints.
        let [from, to, straight, planned] =
            [a.position, b.position, straight, planned].map(|joints| self.tip(&joints, &b.tool_mm));
        off(&less(&straight, &planned), &less(&to, &from))
    }

    /// Whether the motion is within a cycle of a standstill: what a drive rounds there is a corner,
    /// and no bow.
    fn rests(&self, sample: &Sample) -> bool {
        sample
            .velocity
            .0
            .iter()
            .zip(&sample.acceleration.0)
            .all(|(v, a)| v.abs() <= a.abs() * self.period_s)
    }

    /// Looks at a move without tool-centre-point control: a straight feed move of linear and rotary
    /// words that turns the part, or the tool, on its way.
    pub(crate) fn plain(&mut self, item: &Move) {
        let (Curve::Line(_), false) = (
            &item.curve,
            item.feed == FeedLimit::Rapid || self.kinematics.joint_map() == JointMap::Shifted,
        ) else {
            return;
        };
        // Without tip control words are joints, shifted by the tool's offset.
        let [start, end] =
            [item.curve.start(), item.curve.end()].map(|program| offset(&program, &item.tool_mm));
        let way = end - start;
        let moves = |range: std::ops::Range<usize>| way.0[range].iter().any(|way| *way != 0.0);
        // Bent only where rotary and linear words move together.
        if !(moves(3..6) && (moves(0..3) || moves(6..9))) {
            return;
        }
        let max_um = UM_PER_MM * bow_mm(self.kinematics.as_ref(), &start, &end, &item.tool_mm);
        if self.block.is_none_or(|block| max_um > block.max_um) {
            self.block = Some(Straightness {
                max_um,
                block: item.block,
            });
        }
    }

    /// What was found.
    pub(crate) fn tell(&self, plan: &mut PlanInfo) {
        (plan.bow, plan.bow_limit_um, plan.unstraight) =
            (Some(self.commands), self.kept_um, self.block);
    }
}

/// Linear joints of words without tool-centre-point control.
fn offset(program: &Coords, tool_mm: &[f64; 3]) -> Coords {
    let mut joints = *program;
    joints
        .0
        .iter_mut()
        .zip(tool_mm)
        .for_each(|(joint, offset)| *joint += offset);
    joints
}

fn less(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    std::array::from_fn(|n| a[n] - b[n])
}

/// The part of a vector square to a direction.
fn off(vector: &[f64; 3], direction: &[f64; 3]) -> f64 {
    let dot = |a: &[f64; 3], b: &[f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let square = dot(direction, direction);
    // A way without length has no direction: the whole vector counts.
    let along = if square > NO_DIRECTION_MM * NO_DIRECTION_MM {
        dot(vector, direction) / square
    } else {
        0.0
    };
    let rest = less(vector, &direction.map(|d| d * along));
    dot(&rest, &rest).sqrt()
}
