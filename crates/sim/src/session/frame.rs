//! One servo tick as every variant sees it: the command.

use crate::limiter::Limiter;
use crate::motion::Modes;
use lostmotion_base::{Coords, Tick};
use lostmotion_contour::ContourInput;
use lostmotion_kinematics::ToolPose;
use lostmotion_plan::Sample;
use std::collections::VecDeque;

/// The command at one servo tick, after the delay of the reference.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct Frame {
    /// Servo sample in the chunk.
    pub(crate) servo_sample: usize,
    /// Servo tick of the commanded motion (the delay taken out).
    pub tick: Tick,
    /// Sample of the plan at or before it.
    pub sample: Sample,
    /// What limits the motion up to that sample; `None` where nobody asks.
    pub(crate) limiter: Option<Limiter>,
    /// Whether it is the first servo tick of that sample.
    pub is_command_tick: bool,
    /// Whether any joint is commanded to move.
    pub moving: bool,
    /// Commanded tool.
    pub pose: ToolPose,
}

/// What the tracker is asked: a tool that should be at the frame's command.
pub(crate) fn contour_input(frame: &Frame, actual: &ToolPose) -> ContourInput {
    ContourInput {
        tick: frame.tick,
        segment: frame.sample.segment,
        s: frame.sample.s,
        actual_tip_mm: actual.tip,
        commanded_tip_mm: frame.pose.tip,
        actual_axis: actual.axis,
        commanded_axis: frame.pose.axis,
    }
}

/// Speed below which a joint stands still, mm/s or rad/s: rounding of the planner.
pub(super) const STANDSTILL_PER_S: f64 = 1e-9;

/// Pairs servo samples with the commands that they answer to, across chunks.
#[derive(Clone, Debug, Default)]
pub(crate) struct Aligner {
    delay_ticks: u64,
    servo_per_cnc: u64,
    /// The last `delay_ticks` samples of the chunks before.
    past: VecDeque<(Sample, Option<Limiter>)>,
    /// CNC samples in all chunks before.
    done: u64,
}

impl Aligner {
    pub(crate) fn new(delay_ticks: u32, servo_per_cnc: usize) -> Aligner {
        Aligner {
            delay_ticks: u64::from(delay_ticks),
            servo_per_cnc: servo_per_cnc as u64,
            past: VecDeque::new(),
            done: 0,
        }
    }

    /// The frames of a chunk. Servo samples before the first command are left out. Limiters come with the samples, or not at all.
    pub(crate) fn frames(
        &mut self,
        (samples, limiters): (&[Sample], &[Option<Limiter>]),
        modes: &Modes,
        reference: impl Fn(usize) -> Coords,
        frames: &mut Vec<Frame>,
    ) {
        frames.clear();
        let held = self.past.len() as u64;
        let at = |index: usize| (samples[index], limiters.get(index).copied().flatten());
        for servo_sample in 0..samples.len() as u64 * self.servo_per_cnc {
            // The servo sample shows the axis under the command of `delay_ticks` command cycles
            // before, which may lie in the chunk before.
            let (cnc, part) = (
                self.done + servo_sample / self.servo_per_cnc,
                servo_sample % self.servo_per_cnc,
            );
            let Some(commanded) = cnc.checked_sub(self.delay_ticks) else {
                continue;
            };
            // Index counted from the oldest sample held back: below `held` it lies in an earlier
            // chunk.
            let from_oldest = commanded + held - self.done;
            let (sample, limiter) = match from_oldest.checked_sub(held) {
                Some(index) => at(index as usize),
                None => self.past[from_oldest as usize],
            };
            let joints = reference(servo_sample as usize);
            frames.push(Frame {
                servo_sample: servo_sample as usize,
                tick: commanded * self.servo_per_cnc + part,
                sample,
                limiter,
                is_command_tick: part == 0,
                moving: sample.velocity.0.iter().any(|v| v.abs() > STANDSTILL_PER_S),
                pose: modes.at(sample.segment).tool_pose(&joints, &sample.tool_mm),
            });
        }
        // The last samples of this chunk are answered by ticks of the next one.
        self.done += samples.len() as u64;
        let delay = self.delay_ticks as usize;
        let from = samples.len().saturating_sub(delay);
        self.past.extend((from..samples.len()).map(at));
        // A chunk shorter than the delay leaves samples of the one before in use.
        while self.past.len() > delay {
            self.past.pop_front();
        }
    }
}
