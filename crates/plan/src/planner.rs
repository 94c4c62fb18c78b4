//! The planner: items in, samples out.

use crate::admit::{Position, admit, dwell};
use crate::chord::Chord;
use crate::condition::Conditioner;
use crate::corner::{Leg, overlap_s};
use crate::judge::TimeJudge;
use crate::machine::Machine;
use crate::motion::Stretch;
use crate::optimal::{self, Retimer, nominal_clock};
use crate::piece::{PathStep, Programmed, Soft, Stop};
use crate::sampler::Sampler;
use crate::window::{Settled, Window};
use crate::{Move, PlanError, PlanItem, PlannerConfig, Quality, Sample, Shortfalls};
use lostmotion_base::Coords;
use lostmotion_kinematics::{JointMap, Kinematics};
use lostmotion_path::Curve;
use std::sync::Arc;

/// Moves shorter than this, mm or degrees, are dropped; their displacement is added to the next
/// move. A nanometre: no control resolves it, but a path that bends within it would be slow.
const DROPPED_LENGTH: f64 = 1e-6;
/// Displacement of dropped moves that is made up for where the motion comes to rest, if it is
/// larger than this, mm or degrees: less is rounding.
const CLOSED_GAP: f64 = 1e-9;

/// Plans a program as it comes and outputs samples as they become final.
///
/// Push items, take samples in between, and finish: memory stays within the window of the
/// configuration as long as the samples are taken. The samples do not depend on how pushing and
/// taking interleave.
#[derive(Clone, Debug)]
pub struct Planner {
    config: PlannerConfig,
    kinematics: Arc<dyn Kinematics>,
    machine: Machine,
    /// The limits that two motions which add up at a corner have to keep.
    corner_machine: Machine,
    conditioner: Conditioner,
    window: Window,
    sampler: Sampler,
    here: Position,
    /// Displacement of the dropped moves, which the next move has to make up for.
    gap: Coords,
    /// The last dropped move.
    gap_of: Option<Box<Programmed>>,
    segments: u64,
    window_stops: u64,
    /// Tolerance of the corner at which the last stretch came to rest, if it may be rounded.
    corner: Option<f64>,
    /// How soft the next stretch should begin, for that corner.
    soft: Option<Soft>,
    finished: bool,
    /// What makes the motion nearly optimal, if it should be.
    retimer: Option<Box<Retimer>>,
}

impl Planner {
    /// A planner at rest at `start`: program coordinates without a tool offset, mm and rad.
    ///
    /// # Errors
    /// A setting or limit that makes no sense, a start that the machine cannot take.
    pub fn new(
        config: PlannerConfig,
        kinematics: Arc<dyn Kinematics>,
        start: Coords,
    ) -> Result<Planner, PlanError> {
        config.check()?;
        let joints = kinematics
            .inverse(&start, &[0.0; 3])
            .map_err(|source| PlanError::Start(Box::new(source)))?;
        let machine = Machine::new(&config.limits);
        let retimer = (config.quality == Quality::Optimal).then(|| Box::new(Retimer::new(&config)));
        let clock = if retimer.is_some() {
            nominal_clock(config.clock)
        } else {
            config.clock
        };
        Ok(Planner {
            corner_machine: if retimer.is_some() {
                Machine::new(&optimal::loosened(&config.limits))
            } else {
                machine.clone()
            },
            conditioner: Conditioner::new(config.clone()),
            window: Window::new(&config),
            sampler: Sampler::new(clock, start, joints),
            here: Position {
                program: start,
                tool_mm: [0.0; 3],
            },
            gap: Coords::ZERO,
            gap_of: None,
            config,
            kinematics,
            machine,
            segments: 0,
            window_stops: 0,
            corner: None,
            soft: None,
            finished: false,
            retimer,
        })
    }

    /// The same for drives that join commands by straight lines of the joints: the tool stays
    /// within the chord's limit of its way.
    #[must_use]
    pub fn with_chord(mut self, chord: Chord) -> Planner {
        let pace = if self.retimer.is_some() {
            optimal::end_pace()
        } else {
            1.0
        };
        self.corner_machine.chord = Some(chord.at_pace(pace));
        self.machine.chord = Some(chord.clone());
        self.sampler.chord = Some(chord);
        self
    }

    /// Takes the next item.
    ///
    /// # Errors
    /// What is wrong with it; the planner is then as before, and can go on with another item or be
    /// finished.
    pub fn push(&mut self, item: PlanItem) -> Result<(), PlanError> {
        if self.finished {
            return Err(PlanError::Finished);
        }
        match item {
            PlanItem::Move(item) => self.push_move(&item),
            PlanItem::Dwell(item) => {
                dwell(item.block, item.seconds)?;
                self.rest(Stop {
                    dwell_s: item.seconds,
                    ..Stop::default()
                })
            }
            PlanItem::Halt(_) => self.rest(Stop::default()),
        }
    }

    /// Ends the program: everything pushed can be taken after it.
    ///
    /// # Errors
    /// A pose on a blend that the machine cannot take.
    pub fn finish(&mut self) -> Result<(), PlanError> {
        if !self.finished {
            self.rest(Stop::default())?;
            self.finished = true;
            self.sampler.finished = true;
        }
        Ok(())
    }

    /// Takes up to `max_samples` samples that are final; returns how many.
    pub fn take(&mut self, max_samples: usize, out: &mut Vec<Sample>) -> usize {
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
            } else if !(self.finished && retimer.finish()) {
                break;
            }
        }
        out.len() - before
    }

    /// How often the plan so far is not what it could be.
    pub fn shortfalls(&self) -> Shortfalls {
        Shortfalls {
            window_stops: self.window_stops,
            curve_stops: self.conditioner.curve_stops(),
            kept_windows: self.retimer.as_ref().map_or(0, |retimer| retimer.kept()),
        }
    }

    /// How many pieces of path are held, waiting to be planned or sampled.
    pub fn held_pieces(&self) -> usize {
        self.window.len()
            + self
                .sampler
                .stretches
                .iter()
                .map(Stretch::len)
                .sum::<usize>()
    }

    /// How many samples are held to be retimed, or wait to be taken after that: none but for quality
    /// `optimal`.
    pub fn held_samples(&self) -> usize {
        self.retimer.as_ref().map_or(0, |retimer| retimer.held())
    }

    fn push_move(&mut self, item: &Move) -> Result<(), PlanError> {
        let feed = admit(&self.config, self.kinematics.as_ref(), &self.here, item)?;
        let segment = self.segments;
        self.segments += 1;
        let Move {
            mut curve,
            control,
            tool_mm,
            block,
            ..
        } = *item;
        // Where the tool offset changes, the same joints have other coordinates.
        let last = if tool_mm == self.here.tool_mm {
            self.here.program
        } else {
            curve.start()
        };
        // The motion is where the dropped moves have left it, so that the curve begins there.
        let drawn = last + self.gap;
        if curve.start() != drawn {
            curve = curve.starting_at(drawn);
        }
        let length = curve.length();
        self.here = Position {
            program: item.curve.end(),
            tool_mm,
        };
        let heeds = item.feed.heeds();
        let programmed = Programmed {
            curve,
            length,
            feed,
            heeds,
            control,
            tool_mm,
            segment,
            block,
        };
        let is_nothing = length <= DROPPED_LENGTH;
        // What this move leaves for the next one to make up for.
        self.gap = if is_nothing { drawn } else { curve.end() } - item.curve.end();
        self.gap_of = (self.gap != Coords::ZERO).then(|| Box::new(programmed));
        if is_nothing {
            return Ok(());
        }
        let mut steps = Vec::new();
        let judge = TimeJudge {
            machine: &self.machine,
            kinematics: self.kinematics.as_ref(),
            softens: self.retimer.is_none(),
        };
        self.conditioner.push(&programmed, &judge, &mut steps);
        self.follow(steps)
    }

    fn rest(&mut self, stop: Stop) -> Result<(), PlanError> {
        let mut steps = Vec::new();
        let judge = TimeJudge {
            machine: &self.machine,
            kinematics: self.kinematics.as_ref(),
            softens: self.retimer.is_none(),
        };
        // Rest is at the programmed point: a short line makes up for the dropped moves.
        if let Some(last) = self.gap_of.take() {
            let end = self.here.program;
            let curve = Curve::line(end + self.gap, end);
            if curve.length() > CLOSED_GAP {
                self.gap = Coords::ZERO;
                self.conditioner.push(
                    &Programmed {
                        curve,
                        length: curve.length(),
                        ..*last
                    },
                    &judge,
                    &mut steps,
                );
            }
        }
        self.conditioner.stop(stop, &judge, &mut steps);
        self.follow(steps)
    }

    fn follow(&mut self, steps: Vec<PathStep>) -> Result<(), PlanError> {
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
