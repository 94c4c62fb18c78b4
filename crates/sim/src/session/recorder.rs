//! What one variant of the machine does to the contour, added up.

use super::frame::{Frame, contour_input};
use super::monitor::Stop;
use super::outputs::Outputs;
use super::references::Reference;
use super::rows;
use super::stepper::Chunk;
use crate::error::SimError;
use crate::observer::ContourPoint;
use crate::options::SimulateOptions;
use lostmotion_base::vec::sub;
use lostmotion_base::{BlockRef, Clock};
use lostmotion_contour::{
    BlockLedger, BlockRow, CauseRule, ContourSample, ContourTracker, ErrorRecord, FootState, Place,
    ReversalConfig, ReversalLedger, ReversalRow, ReversalState, Shares, Statistics,
};
use lostmotion_drive::config::Cycles;

/// One variant's records. Constant in size, whatever the length of the program.
#[derive(Debug)]
pub(crate) struct Recorder {
    variant: usize,
    servo: Clock,
    foot: FootState,
    /// What was measured in the last frames.
    samples: Vec<ContourSample>,
    rule: CauseRule,
    reversal_config: ReversalConfig,
    reversals: ReversalState,
    pub(crate) cutting: Statistics,
    pub(crate) rapid: Statistics,
    pub(crate) backlash: Statistics,
    pub(crate) orientation: Statistics,
    pub(crate) following: Vec<Statistics>,
    /// How far the ends of a gantry are apart, in its unit.
    pub(crate) skew: Statistics,
    /// Magnitude and block of the largest.
    pub(crate) skew_peak: (f64, BlockRef),
    pub(crate) blocks: BlockLedger,
    pub(crate) turns: ReversalLedger,
    /// Rows finished in the last chunk.
    pub(crate) finished_blocks: Vec<BlockRow>,
    pub(crate) finished_turns: Vec<ReversalRow>,
    /// Where the machine has stopped: nothing is recorded from there on.
    pub(crate) stop: Option<Stop>,
    /// Every sample of the last chunk, if asked for.
    pub(crate) points: Option<Vec<ContourPoint>>,
}

impl Recorder {
    pub(crate) fn new(
        variant: usize,
        axes: usize,
        cycles: Cycles,
        options: &SimulateOptions,
        with_points: bool,
    ) -> Recorder {
        // The window is given in seconds and counted in servo ticks: causes must not depend on
        // rounding of times.
        let window = (options.reversal_window_s / cycles.servo().period_s()).round() as u64;
        Recorder {
            variant,
            foot: FootState::default(),
            samples: Vec::new(),
            rule: CauseRule {
                reversal_window_ticks: window,
            },
            reversal_config: ReversalConfig::default(),
            reversals: ReversalState::default(),
            cutting: Statistics::default(),
            rapid: Statistics::default(),
            backlash: Statistics::default(),
            orientation: Statistics::default(),
            following: vec![Statistics::default(); axes],
            skew: Statistics::default(),
            skew_peak: (0.0, BlockRef::default()),
            blocks: BlockLedger::new(options.keep_blocks),
            turns: ReversalLedger::new(window, options.keep_reversals),
            finished_blocks: Vec::new(),
            finished_turns: Vec::new(),
            stop: None,
            points: with_points.then(Vec::new),
            servo: cycles.servo(),
        }
    }

    /// Forgets what it has of the chunk before.
    pub(crate) fn begin(&mut self) {
        self.finished_blocks.clear();
        self.finished_turns.clear();
        if let Some(points) = &mut self.points {
            points.clear();
        }
    }

    /// Measures some frames of a chunk, up to where the machine stops.
    pub(crate) fn measure(
        &mut self,
        frames: &[Frame],
        chunk: &Chunk,
        tracker: &ContourTracker,
    ) -> Result<(), SimError> {
        self.samples.clear();
        // What a machine does that its control has stopped is no contour error.
        if self.stop.is_some() {
            return Ok(());
        }
        let (outputs, modes, stop) = (&chunk.outputs, &chunk.modes, self.stop_in(chunk));
        for frame in frames {
            if stop.is_some_and(|stop| stop.tick == frame.tick) {
                break;
            }
            let joints = outputs.load(self.variant, frame.servo_sample);
            // Forward kinematics of the loads: where the tool is, in the part's frame.
            let actual = modes
                .at(frame.sample.segment)
                .tool_pose(&joints, &frame.sample.tool_mm);
            let sample = tracker.measure(&mut self.foot, &contour_input(frame, &actual))?;
            self.samples.push(sample);
        }
        Ok(())
    }

    /// Where the machine stops in a chunk.
    fn stop_in<'a>(&self, chunk: &'a Chunk) -> Option<&'a Stop> {
        chunk.stops.get(self.variant)?.as_ref()
    }

    /// What was measured last.
    pub(crate) fn measured(&self) -> Vec<ContourSample> {
        self.samples.clone()
    }

    /// Adds up what was measured in some frames of a chunk, each with what it is held against.
    pub(crate) fn record<'a>(
        &mut self,
        frames: impl Iterator<Item = (&'a Frame, Reference<'a>)>,
        chunk: &Chunk,
        tracker: &ContourTracker,
    ) {
        if self.stop.is_some() {
            return;
        }
        let (outputs, modes, stop) = (&chunk.outputs, &chunk.modes, self.stop_in(chunk));
        let samples = std::mem::take(&mut self.samples);
        let mut measured = samples.iter();
        for (frame, reference) in frames {
            if let Some(stop) = stop.filter(|stop| stop.tick == frame.tick) {
                self.stop = Some(Stop {
                    at_mm: reference.tip_mm,
                    ..stop.clone()
                });
                break;
            }
            let Some(&sample) = measured.next() else {
                break;
            };
            // Reversals are those of the commanded velocity, which changes once a command cycle.
            if frame.is_command_tick {
                self.watch_reversals(frame, reference.without_gap.rapid);
            }
            // The error of the command, what the machine without a gap adds to it, and what the gap
            // adds to that.
            let shares = Shares::of(reference.command, reference.without_gap, &sample);
            // Laid to the largest share, and to a reversal if one lies within the window before.
            let cause = self.rule.cause(&shares, &sample, &self.reversals);
            // Places go with the block that the error is counted to: past a change of the zero the
            // foot is still on the path before it, or already on the one behind it.
            let commanded_tip_mm = if sample.segment == frame.sample.segment {
                reference.tip_mm
            } else {
                let of_foot = tracker.segment(sample.segment);
                of_foot.map_or(reference.tip_mm, |of_foot| {
                    sub(frame.pose.tip, of_foot.origin_mm)
                })
            };
            let record = ErrorRecord {
                sample,
                shares,
                cause,
                commanded_tip_mm,
            };
            self.finished_turns.extend(self.turns.record(&record));
            // At once: the tracker holds the foot's segment now, but may have let it go by the end
            // of the chunk. Only where somebody looks on: it is sought anew.
            if let Some(points) = &mut self.points {
                let place = tracker.place(&sample);
                points.extend(
                    place.map(|place| {
                        rows::contour_point(&record, place, (frame, modes), self.servo)
                    }),
                );
            }
            // While all joints are commanded to rest nothing is cut, and dwells would outweigh the
            // motion in the RMS.
            if frame.moving {
                self.count(frame, &record, outputs);
            }
        }
        self.samples = samples;
    }

    fn watch_reversals(&mut self, frame: &Frame, rapid: bool) {
        let sample = &frame.sample;
        for reversal in self
            .reversal_config
            .step(&mut self.reversals, frame.tick, &sample.velocity)
        {
            // An axis that turns again within the window closes its earlier reversal.
            let before = self
                .turns
                .open(reversal, sample.segment, sample.block, rapid);
            self.finished_turns.extend(before);
        }
    }

    fn count(&mut self, frame: &Frame, record: &ErrorRecord, outputs: &Outputs) {
        let place = Place {
            tick: record.sample.tick,
            segment: record.sample.segment,
            s: record.sample.s,
        };
        // Verdict and comparison are about cutting; rapids are kept apart.
        if record.sample.rapid {
            self.rapid.push(record.sample.error_mm, place);
        } else {
            self.cutting.push(record.sample.error_mm, place);
            self.backlash.push(record.shares.backlash_size_mm, place);
            self.orientation
                .push(record.sample.orientation_error_rad, place);
        }
        for (axis, statistics) in self.following.iter_mut().enumerate() {
            // Following error: the reference, after its delay, minus the load at the same tick.
            let reference = outputs.of(self.variant, axis).reference[frame.servo_sample];
            statistics.push(
                reference - outputs.load_of(self.variant, axis, frame.servo_sample),
                place,
            );
        }
        if let Some(skew) = outputs.skew(self.variant, frame.servo_sample) {
            self.skew.push(skew, place);
            // Statistics know where their peak is on the path; the block is kept here.
            if skew.abs() > self.skew_peak.0 {
                self.skew_peak = (skew.abs(), frame.sample.block);
            }
        }
        self.blocks.record(record);
    }

    /// Closes the rows of segments that no later sample can touch.
    pub(crate) fn close_before(&mut self, segment: u64) {
        self.finished_blocks
            .extend(self.blocks.finish_before(segment));
    }

    /// Closes everything.
    pub(crate) fn close(&mut self) {
        self.finished_blocks.clear();
        self.finished_turns.clear();
        self.finished_blocks.extend(self.blocks.finish());
        self.finished_turns.extend(self.turns.finish());
    }
}
