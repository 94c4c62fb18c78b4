//! What every method is held against: the contour errors of the command itself and of the machine without
//! a gap, by servo tick.

use super::frame::{Frame, contour_input};
use crate::error::SimError;
use lostmotion_base::vec::sub;
use lostmotion_contour::{ContourSample, ContourTracker, FootState, Place, Statistics};

/// The command: the reference as the tool, so what is left is G64's blending and the interpolation.
#[derive(Debug, Default)]
pub(crate) struct CommandContour {
    foot: FootState,
    samples: Vec<ContourSample>,
    /// Commanded tips from the program's zero, mm.
    tips_mm: Vec<[f64; 3]>,
    /// Of cutting moves, from the start of the program.
    pub(crate) cutting: Statistics,
}

/// What a method is held against at one tick.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reference<'a> {
    /// Contour error of the command.
    pub(crate) command: &'a ContourSample,
    /// Contour error of the machine without a gap: command plus servo.
    pub(crate) without_gap: &'a ContourSample,
    /// Commanded tip from the program's zero, mm.
    pub(crate) tip_mm: [f64; 3],
}

impl CommandContour {
    /// Measures some frames.
    pub(crate) fn measure(
        &mut self,
        frames: &[Frame],
        tracker: &ContourTracker,
    ) -> Result<(), SimError> {
        self.samples.clear();
        self.tips_mm.clear();
        for frame in frames {
            let sample = tracker.measure(&mut self.foot, &contour_input(frame, &frame.pose))?;
            // Results name places as the program does: from its work offset, not from machine zero.
            let origin = tracker
                .segment(frame.sample.segment)
                .map_or([0.0; 3], |segment| segment.origin_mm);
            self.tips_mm.push(sub(frame.pose.tip, origin));
            // Rapids and standstill would dilute the RMS and percentiles of what is cut.
            if frame.moving && !sample.rapid {
                let place = Place {
                    tick: frame.tick,
                    segment: sample.segment,
                    s: sample.s,
                };
                self.cutting.push(sample.error_mm, place);
            }
            self.samples.push(sample);
        }
        Ok(())
    }

    /// By frame, with what the machine without a gap does there.
    pub(crate) fn beside<'a>(
        &'a self,
        without_gap: &'a [ContourSample],
    ) -> impl Iterator<Item = Reference<'a>> {
        let samples = self.samples.iter().zip(without_gap);
        samples
            .zip(&self.tips_mm)
            .map(|((command, without_gap), tip_mm)| Reference {
                command,
                without_gap,
                tip_mm: *tip_mm,
            })
    }
}
