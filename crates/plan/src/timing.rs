//! The second half of the work: the path in, samples out.

use crate::chord::Chord;
use crate::corner::{Leg, overlap_s};
use crate::machine::Machine;
use crate::motion::Stretch;
use crate::optimal::{self, Retimer, nominal_clock};
use crate::piece::{PathStep, Soft};
use crate::sampler::Sampler;
use crate::window::{Settled, Window};
use crate::{PlanError, PlannerConfig, Quality, Sample};
use lostmotion_base::Coords;
use lostmotion_kinematics::{JointMap, Kinematics};
use std::sync::Arc;

/// Plans the motion along the path, and samples it.
#[derive(Clone, Debug)]
pub(crate) struct Timing {
    kinematics: Arc<dyn Kinematics>,
    machine: Machine,
    /// The limits that two motions which add up at a corner have to keep.
    corner_machine: Machine,
    window: Window,
    sampler: Sampler,
    window_stops: u64,
    /// Tolerance of the corner at which the last stretch came to rest, if it may be rounded.
    corner: Option<f64>,
    /// How soft the next stretch should begin, for that corner.
    soft: Option<Soft>,
    /// What makes the motion nearly optimal, if it should be.
    retimer: Option<Box<Retimer>>,
}

impl Timing {
    /// At rest at `start`.
    pub(crate) fn new(
        config: &PlannerConfig,
        kinematics: Arc<dyn Kinematics>,
        start: Coords,
        joints: Coords,
        machine: Machine,
    ) -> Timing {
        let retimer = (config.quality == Quality::Optimal).then(|| Box::new(Retimer::new(config)));
        let clock = if retimer.is_some() {
            nominal_clock(config.clock)
        } else {
            config.clock
        };
        Timing {
            corner_machine: if retimer.is_some() {
                Machine::new(&optimal::loosened(&config.limits))
            } else {
                machine.clone()
            },
            window: Window::new(config),
            sampler: Sampler::new(clock, start, joints),
            kinematics,
            machine,
            window_stops: 0,
            corner: None,
            soft: None,
            retimer,
        }
    }

    /// The tool stays within the chord's limit of its way.
    pub(crate) fn keep(&mut self, chord: Chord) {
        let pace = if self.retimer.is_some() {
            optimal::end_pace()
        } else {
            1.0
        };
        self.corner_machine.chord = Some(chord.at_pace(pace));
        self.machine.chord = Some(chord.clone());
        self.sampler.chord = Some(chord);
    }

    /// Whether no path comes any more.
    pub(crate) fn is_finished(&self) -> bool {
        self.sampler.finished
    }

    /// No path comes any more.
    pub(crate) fn finish(&mut self) {
        self.sampler.finished = true;
    }

    /// Takes up to `max_samples` samples that are final; returns how many.
    pub(crate) fn take(&mut self, max_samples: usize, out: &mut Vec<Sample>) -> usize {
        let Some(retimer) = &mut self.retimer else {
            return self
                .sampler
                .take(max_samples, self.kinematics.as_ref(), out);
        };
        let (before, mut nominal) = (out.len(), Vec::with_capacity(1));
        while out.len() - before < max_samples {
            if let Some(sample) = retimer.next() {
                out.push(sample);
            } else if self.sampler.take(1, self.kinematics.as_ref(), &mut nominal) > 0 {
                nominal.drain(..).for_each(|sample| retimer.push(sample));
            } else if !(self.sampler.finished && retimer.finish()) {
                break;
            }
        }
        out.len() - before
    }

    /// How often it had to come to rest for want of look-ahead, and windows that were kept as they were planned.
    pub(crate) fn stops_and_kept(&self) -> [u64; 2] {
        let kept = self.retimer.as_ref().map_or(0, |retimer| retimer.kept());
        [self.window_stops, kept]
    }

    /// How many pieces of path are held, waiting to be planned or sampled.
    pub(crate) fn held_pieces(&self) -> usize {
        let planned = self.sampler.stretches.iter().map(Stretch::len);
        self.window.len() + planned.sum::<usize>()
    }

    /// How many samples are held to be retimed, or wait to be taken after that.
    pub(crate) fn held_samples(&self) -> usize {
        self.retimer.as_ref().map_or(0, |retimer| retimer.held())
    }

    /// Plans along the next steps of the path.
    pub(crate) fn follow(
        &mut self,
        steps: impl Iterator<Item = PathStep>,
    ) -> Result<(), PlanError> {
        for step in steps {
            match step {
                PathStep::Piece(piece) => {
                    self.window
                        .push(piece, &self.machine, self.kinematics.as_ref())?;
                    // The memory is bounded: a full window outputs its final part, by a stop if
                    // need be.
                    while self.window.is_due() {
                        let Some((settled, forced)) =
                            self.window.settle(&self.machine, self.kinematics.as_ref())
                        else {
                            break;
                        };
                        self.commit(settled);
                        self.window_stops += u64::from(forced);
                    }
                }
                PathStep::Stop(stop) => {
                    // The soft start was settled with the corner before, the soft end with this
                    // one.
                    let ends = [self.soft.take(), stop.soft];
                    if let Some(settled) =
                        self.window
                            .finish(&self.machine, self.kinematics.as_ref(), ends)
                    {
                        // The next stretch begins softly only if this one ends so.
                        self.soft = stop.soft.filter(|_| settled.soft);
                        self.commit(settled);
                    }
                    self.sampler.end_s += stop.dwell_s;
                    self.corner = stop.tolerance;
                }
            }
        }
        Ok(())
    }

    /// Adds a final part of a profile to the open stretch, or begins one with it.
    fn commit(&mut self, settled: Settled) {
        let from = settled.knots.first().map_or(0.0, |knot| knot.s);
        // A part after a stop begins a new stretch.
        let open = self
            .sampler
            .stretches
            .back()
            .is_some_and(|stretch| !stretch.complete);
        let open = if open {
            self.sampler.stretches.pop_back()
        } else {
            None
        };
        let is_new = open.is_none();
        let mut stretch = open.unwrap_or_else(|| Stretch::new(from));
        stretch.extend(settled.pieces.into_iter(), &settled.knots);
        stretch.complete = settled.complete;
        if is_new {
            // Only now both motions at the corner are known, and with them how long they may
            // overlap.
            let overlap_s = self.overlap_s(&stretch);
            stretch.start_s = self.sampler.end_s - overlap_s;
            stretch.corner = stretch
                .first()
                .filter(|_| overlap_s > 0.0)
                .map(|piece| piece.curve.start());
        }
        self.sampler.end_s = stretch.rest_s();
        self.sampler.add(stretch);
    }

    /// How long before the end of the stretch before a stretch may set out, s.
    fn overlap_s(&mut self, stretch: &Stretch) -> f64 {
        // Program coordinates add up to joints only where the one is the other up to a constant.
        let Some(tolerance) = self
            .corner
            .take()
            .filter(|_| self.kinematics.joint_map() == JointMap::Shifted)
        else {
            return 0.0;
        };
        let before = self.sampler.stretches.back().and_then(Leg::end_of);
        match (before, Leg::start_of(stretch)) {
            (Some(before), Some(after)) => {
                overlap_s(&self.corner_machine, &before, &after, tolerance)
            }
            _ => 0.0,
        }
    }
}
