//! Samples of one stretch that moves alone.

use super::{Sampler, Until};
use crate::Sample;
use lostmotion_base::Coords;
use lostmotion_kinematics::Kinematics;

impl Sampler {
    /// Adds samples up to `most`, as long as nothing but the first stretch moves and
    /// joints are program coordinates up to a constant: the usual case, without anything that it
    /// does not need. Whether there was one.
    pub(super) fn run(
        &mut self,
        most: usize,
        settled: Until,
        kinematics: &dyn Kinematics,
        out: &mut Vec<Sample>,
    ) -> bool {
        let (before, from_s) = (
            out.len(),
            self.stretches
                .get(1)
                .map_or(f64::INFINITY, |second| second.start_s),
        );
        let Some(stretch) = self
            .stretches
            .front_mut()
            .filter(|_| kinematics.is_affine())
        else {
            return false;
        };
        let rest_s = if stretch.complete {
            stretch.rest_s()
        } else {
            f64::INFINITY
        };
        while out.len() < most {
            let t = self.clock.seconds(self.tick);
            if !settled.holds(t) || t <= stretch.start_s || t >= rest_s || t > from_s {
                break;
            }
            let motion = stretch.advance(t - stretch.start_s);
            let Some((piece, local)) = stretch.here(motion.s) else {
                break;
            };
            if self
                .offset
                .is_none_or(|(tool_mm, _)| tool_mm != piece.tool_mm)
            {
                self.offset = kinematics
                    .inverse(&Coords::ZERO, &piece.tool_mm)
                    .ok()
                    .map(|offset| (piece.tool_mm, offset));
            }
            let Some((_, offset)) = self.offset else {
                break;
            };
            let (mark, s) = piece.programmed(local);
            let [place, velocity, acceleration] = piece.curve.travel(local, motion.v, motion.a);
            out.push(Sample {
                tick: self.tick,
                position: place + offset,
                velocity,
                acceleration,
                segment: mark.segment,
                s,
                path_speed: motion.v,
                feed_part: velocity.linear_norm().max(motion.v) / piece.feed,
                chord_part: 0.0,
                heeds: piece.heeds,
                tool_mm: piece.tool_mm,
                block: mark.block,
            });
            self.tick += 1;
        }
        out.len() > before
    }
}
