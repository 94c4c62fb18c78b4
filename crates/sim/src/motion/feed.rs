//! The second pass: program in, samples of the plan out, with the programmed segments that they lie
//! on.

use super::bow::Bows;
use super::change::LimitChange;
use super::check::planner_config;
use super::curves::plan_item;
use super::paced::{PLAN_CHUNK_SAMPLES, Paced};
use super::reader::Reader;
use super::steer::Modes;
use super::steer::Read;
use super::stops::Stops;
use crate::error::SimError;
use crate::options::BowLimit;
use crate::results::{PlanInfo, PlanShortfalls};
use crate::setup::Setup;
use lostmotion_base::{BlockRef, Coords, Tick, threads};
use lostmotion_contour::ProgrammedSegment;
use lostmotion_gcode::MotionItem;
use lostmotion_kinematics::TipControl;
use lostmotion_plan::{
    FeedLimit, ItemsIn, Move, Pacer, PlanItem, Planner, PlannerConfig, Sample, Shortfalls,
};
use std::collections::VecDeque;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What was read, for the account of where time goes.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "nearly all are moves")]
pub(crate) enum Note {
    /// A move with its running number.
    Move { index: u64, item: Move },
    /// A dwell, after `after` moves.
    Dwell {
        after: u64,
        seconds: f64,
        block: BlockRef,
    },
    /// Another tool.
    ToolChange,
}

/// Pieces of path that are taken from the program at least and at most while those before are planned: as many as
/// that takes time for. A choice: less would be at work in turns, more takes as much memory as the planner's window.
const AHEAD_PIECES: [usize; 2] = [64, 4096];
/// Blocks that are read meanwhile at most. A choice: a curve is found over up to 4096 lines at once.
const AHEAD_BLOCKS: usize = 5000;
/// Moves behind the last sample of a chunk that are read at most for what follows on the path: moves of rotary
/// axes alone have no length. A choice.
const MOST_FOLLOWING: u64 = 4096;

/// A program on its way through the planner.
pub(crate) struct Feed {
    reading: ReadAhead,
    planner: Planner,
    config: PlannerConfig,
    paced: Option<Paced>,
    /// Of the commands that the drives get, which is coarser than the planner's under a pacer.
    command_period_s: f64,
    start_joints: Coords,
    /// Joints at the last sample of the plan.
    planned: Coords,
    /// Samples and segments before the planner at work.
    before: (Tick, u64),
    /// What the planners before it fell short of.
    shortfalls: Shortfalls,
    given: Tick,
    /// Why the planner cannot go on, to be told once all samples before it have been given.
    failed: Option<SimError>,
    /// Path behind the last sample of a chunk that has been read with it, mm.
    following_mm: f64,
    /// Threads for reading and planning at the same time.
    threads: usize,
    last: Option<Sample>,
}

/// What reads the program for the planner.
struct ReadAhead {
    name: String,
    reader: Reader,
    bows: Option<Bows>,
    modes: Modes,
    stops: Option<Stops>,
    /// The first move in other coordinates, which begins when the planner has come to rest.
    held: Option<Read>,
    segments: u64,
    /// Where each move ends that no sample has left behind, mm of path, and its running number.
    ends: VecDeque<(u64, f64)>,
    change: LimitChange,
    notes: Option<Vec<Note>>,
    over: bool,
    /// What is wrong with the program, to be told once all before it has been planned.
    failed: Option<SimError>,
}

impl Feed {
    pub(crate) fn new(setup: &Setup<'_>) -> Result<Feed, SimError> {
        Feed::changed(setup, LimitChange::NONE)
    }

    /// Reads while it plans, with more than one thread.
    pub(crate) fn on_threads(self, threads: usize) -> Feed {
        Feed {
            threads,
            planner: self.planner.on_threads(threads),
            ..self
        }
    }

    /// With notes of what is read.
    pub(crate) fn timed(setup: &Setup<'_>) -> Result<Feed, SimError> {
        let mut feed = Feed::new(setup)?;
        feed.reading.notes = Some(Vec::new());
        Ok(feed)
    }

    /// On a machine, or of a program, with something changed.
    pub(crate) fn changed(setup: &Setup<'_>, change: LimitChange) -> Result<Feed, SimError> {
        let (machine, options) = (setup.machine, setup.options);
        let mut modes = Modes::new(&setup.kinematics);
        let start = machine.start();
        let mut config = change.of_machine(planner_config(machine, options.quality));
        // An operator's actions retime the finished plan: they act on samples, not on the planner.
        let paced = Paced::new(&config, &options.interventions)?;
        if paced.is_some() {
            // The planner samples finely enough that the pacer loses nothing between two of its
            // samples.
            config.clock = Pacer::plan_clock(&config);
        }
        let bows = Bows::new(
            modes.kinematics(true),
            machine.cycles().command().period_s(),
            BowLimit::new(machine, options),
        );
        // Without rotary orientation words are always the tip; else only where the machine or G43.4
        // says so.
        let tip = setup.tip_control == TipControl::Always
            || modes.kinematics(true).orientation().is_none();
        modes.begin(0, tip);
        let kinematics = Arc::clone(modes.kinematics(tip));
        // Before the first tool change no offset is in force.
        let start_joints = kinematics.inverse(&start, &[0.0; 3])?;
        let planner = Bows::bound(
            bows.as_ref(),
            Planner::new(config.clone(), kinematics, start)?,
        );
        Ok(Feed {
            reading: ReadAhead {
                name: setup.program.name().to_owned(),
                reader: Reader::new(setup)?,
                bows,
                modes,
                stops: Stops::new(machine),
                held: None,
                segments: 0,
                ends: VecDeque::new(),
                change,
                notes: None,
                over: false,
                failed: None,
            },
            start_joints,
            planned: start_joints,
            planner,
            config,
            paced,
            command_period_s: machine.cycles().command().period_s(),
            before: (0, 0),
            shortfalls: Shortfalls::default(),
            given: 0,
            failed: None,
            following_mm: options.contour.max_window_mm,
            threads: 1,
            last: None,
        })
    }

    /// The next samples, at most `most`, none at the end; and the segments that were read on the
    /// way: at least those on the path that follows within what contour errors are sought on, so that no error
    /// depends on how far was read.
    pub(crate) fn chunk(
        &mut self,
        most: usize,
        samples: &mut Vec<Sample>,
        segments: &mut Vec<ProgrammedSegment>,
    ) -> Result<(), SimError> {
        samples.clear();
        // Taken out for the call, since the pacer draws on the plan of `self`.
        let result = if let Some(mut paced) = self.paced.take() {
            let result = paced.take(most, samples, |plan| {
                self.plan(PLAN_CHUNK_SAMPLES, plan, segments)
            });
            self.paced = Some(paced);
            result
        } else {
            self.plan(most, samples, segments)
        };
        if let Some(bows) = &mut self.reading.bows {
            bows.samples(samples);
        }
        self.last = samples.last().copied().or(self.last);
        result?;
        self.read_following(segments);
        Ok(())
    }

    /// Reads what follows on the path.
    fn read_following(&mut self, segments: &mut Vec<ProgrammedSegment>) {
        let Some(last) = self.last else { return };
        let Feed {
            reading, planner, ..
        } = self;
        let (mut items, _) = planner.halves();
        reading.leave(last.segment);
        while reading.follows_mm() < self.following_mm && reading.is_open() {
            if reading.segments - last.segment > MOST_FOLLOWING {
                break;
            }
            reading.read_on(&mut items, segments);
        }
    }

    /// The next samples of the plan, up to `most` in all.
    fn plan(
        &mut self,
        most: usize,
        samples: &mut Vec<Sample>,
        segments: &mut Vec<ProgrammedSegment>,
    ) -> Result<(), SimError> {
        while samples.len() < most {
            let from = samples.len();
            let taken = self.planner.take(most - from, samples);
            // Each planner counts from 0; the program has one count over all of them.
            for sample in samples.iter_mut().skip(from) {
                sample.tick += self.before.0;
                sample.segment += self.before.1;
            }
            self.given += taken as Tick;
            self.planned = samples.last().map_or(self.planned, |last| last.position);
            // The planner knows no more: it gets the next items, or comes to rest, and goes on in
            // other coordinates if a move in those is waiting.
            if taken == 0 && !self.go_on(segments)? {
                break;
            }
        }
        Ok(())
    }

    /// Reads on, or plans what was read; the answer is false at the end.
    fn go_on(&mut self, segments: &mut Vec<ProgrammedSegment>) -> Result<bool, SimError> {
        if let Some(error) = self.failed.take() {
            return Err(error);
        }
        let Feed {
            reading, planner, ..
        } = self;
        if reading.is_open() || planner.is_behind() {
            // While the one half takes further items the other plans what it took before.
            let (mut items, path) = planner.halves();
            let is_planning = AtomicBool::new(false);
            let plan = || {
                is_planning.store(true, Ordering::Relaxed);
                let planned = path.plan();
                is_planning.store(false, Ordering::Relaxed);
                planned
            };
            let read = || reading.read_ahead(&mut items, segments, &is_planning);
            let ((), planned) = threads::join(self.threads, read, plan);
            // What was planned before it is given first.
            self.failed = planned.err().map(SimError::from);
        } else if let Some(read) = reading.held.take() {
            // The planner has come to rest, so the waiting move may begin in its own coordinates.
            self.change_over(&read)?;
            let (mut items, _) = self.planner.halves();
            self.reading.push(&read, &mut items, segments)?;
        } else if let Some(error) = reading.failed.take() {
            return Err(error);
        } else {
            return Ok(false);
        }
        Ok(true)
    }

    /// Notes since the last call.
    pub(crate) fn notes(&mut self) -> Vec<Note> {
        self.reading
            .notes
            .as_mut()
            .map(std::mem::take)
            .unwrap_or_default()
    }

    /// How often the spindle has been told to start, stop or turn round.
    pub(crate) fn spindle_events(&self) -> u64 {
        self.reading.reader.spindle_events()
    }

    /// Goes on from rest in other coordinates.
    fn change_over(&mut self, read: &Read) -> Result<(), SimError> {
        let kinematics = self.reading.modes.kinematics(read.tip);
        // The joints stand where the last plan ended; only the words for the place change.
        let start = kinematics.forward(&self.planned, &[0.0; 3]);
        self.shortfalls += self.planner.shortfalls();
        self.planner = Bows::bound(
            self.reading.bows.as_ref(),
            Planner::new(self.config.clone(), Arc::clone(kinematics), start)?
                .on_threads(self.threads),
        );
        // Offsets of samples and segments for the new planner's counts.
        self.before = (self.given, self.reading.segments);
        Ok(())
    }

    /// Tells how straight the tool goes, what the plan falls short of, and which interventions came
    /// after the end of the motion.
    pub(crate) fn tell(&self, plan: &mut PlanInfo) {
        if let Some(bows) = &self.reading.bows {
            bows.tell(plan);
        }
        let paced = self.paced.as_ref();
        plan.late = paced.and_then(|paced| paced.left(self.command_period_s));
        let mut shortfalls = self.shortfalls;
        shortfalls += self.planner.shortfalls();
        if let Some(paced) = paced {
            shortfalls += paced.shortfalls();
        }
        plan.shortfalls = PlanShortfalls::of(shortfalls);
    }

    /// The last sample given out.
    pub(crate) fn last(&self) -> Option<Sample> {
        self.last
    }

    /// Which kinematics each segment goes through, as far as it has been read.
    pub(crate) fn modes(&self) -> &Modes {
        &self.reading.modes
    }

    /// Joints before the program.
    pub(crate) fn start_joints(&self) -> Coords {
        self.start_joints
    }

    /// How far into the program it has read, bytes.
    pub(crate) fn bytes_done(&self) -> u64 {
        self.reading.reader.bytes_done()
    }
}

impl ReadAhead {
    /// Whether there is more to read before the planner has to come to rest.
    fn is_open(&self) -> bool {
        !self.over && self.held.is_none() && self.failed.is_none()
    }

    /// Forgets the ends of moves before this one.
    fn leave(&mut self, segment: u64) {
        while self.ends.front().is_some_and(|(index, _)| *index < segment) {
            self.ends.pop_front();
        }
    }

    /// Path that has been read behind the first move that is not forgotten, mm.
    fn follows_mm(&self) -> f64 {
        let (first, last) = (self.ends.front(), self.ends.back());
        first
            .zip(last)
            .map_or(0.0, |(first, last)| last.1 - first.1)
    }

    /// Hands the planner the next items, as many as it takes to keep it busy.
    fn read_ahead(
        &mut self,
        planner: &mut ItemsIn<'_>,
        segments: &mut Vec<ProgrammedSegment>,
        is_planning: &AtomicBool,
    ) {
        let [least, most] = AHEAD_PIECES;
        let mut blocks = 0;
        while self.is_open() && blocks < AHEAD_BLOCKS {
            let waiting = planner.waiting();
            if waiting >= most || waiting >= least && !is_planning.load(Ordering::Relaxed) {
                break;
            }
            blocks += 1;
            self.read_on(planner, segments);
        }
    }

    /// Hands the planner one item more, or the end; what is wrong with it is told later.
    fn read_on(&mut self, planner: &mut ItemsIn<'_>, segments: &mut Vec<ProgrammedSegment>) {
        self.failed = self.read(planner, segments).err();
    }

    /// Hands the planner one item more, or the end.
    fn read(
        &mut self,
        planner: &mut ItemsIn<'_>,
        segments: &mut Vec<ProgrammedSegment>,
    ) -> Result<(), SimError> {
        let Some(read) = self.reader.next() else {
            self.over = true;
            planner.finish();
            return Ok(());
        };
        let read =
            read.map_err(|(problem, place)| self.reader.refused(&self.name, problem, place))?;
        // A change between tip and joint coordinates needs a standstill: paths of the two cannot be
        // blended.
        if matches!(read.item, MotionItem::Move(_)) && self.modes.begin(self.segments, read.tip) {
            self.held = Some(read);
            planner.finish();
            return Ok(());
        }
        self.push(&read, planner, segments)
    }

    fn push(
        &mut self,
        read: &Read,
        planner: &mut ItemsIn<'_>,
        segments: &mut Vec<ProgrammedSegment>,
    ) -> Result<(), SimError> {
        let origin = if let MotionItem::Move(motion) = &read.item {
            motion.origin
        } else {
            Coords::ZERO
        };
        // Dwells and tool changes take time without motion: the account of time gets them here.
        self.note_stop(&read.item);
        let item = plan_item(&read.item)
            .map_err(|error| error.with_provenance(self.reader.diagnostics()))?;
        let Some(item) = item.map(|item| self.change.of_item(item)) else {
            return Ok(());
        };
        match (&mut self.stops, item) {
            (Some(stops), PlanItem::Move(item)) => {
                for item in stops.of_move(item) {
                    self.hand(item, (origin, read), planner, segments)?;
                }
                Ok(())
            }
            (_, item) => self.hand(item, (origin, read), planner, segments),
        }
    }

    /// Hands the planner an item of what was read.
    fn hand(
        &mut self,
        item: PlanItem,
        (origin, read): (Coords, &Read),
        planner: &mut ItemsIn<'_>,
        segments: &mut Vec<ProgrammedSegment>,
    ) -> Result<(), SimError> {
        planner.push(item)?;
        // A stop of the control's own, not of the program.
        if let (PlanItem::Dwell(dwell), MotionItem::Move(_), Some(notes)) =
            (item, &read.item, &mut self.notes)
        {
            notes.push(Note::Dwell {
                after: self.segments,
                seconds: dwell.seconds,
                block: dwell.block,
            });
        }
        if let PlanItem::Move(item) = item {
            // Under tip control the planner itself keeps the tip on the line; without it a rotary
            // word bends the way.
            if let Some(bows) = self.bows.as_mut().filter(|_| !read.tip) {
                bows.plain(&item);
            }
            segments.push(ProgrammedSegment {
                index: self.segments,
                curve: item.curve,
                plane: read.plane,
                rapid: item.feed == FeedLimit::Rapid,
                origin_mm: origin.linear(),
                block: item.block,
            });
            if let Some(notes) = &mut self.notes {
                notes.push(Note::Move {
                    index: self.segments,
                    item,
                });
            }
            let before_mm = self.ends.back().map_or(0.0, |(_, end_mm)| *end_mm);
            let length_mm = if item.curve.moves_tip() {
                item.curve.length()
            } else {
                0.0
            };
            self.ends.push_back((self.segments, before_mm + length_mm));
            self.segments += 1;
        }
        Ok(())
    }

    fn note_stop(&mut self, item: &MotionItem) {
        let Some(notes) = &mut self.notes else { return };
        match item {
            MotionItem::Dwell { seconds, block } => notes.push(Note::Dwell {
                after: self.segments,
                seconds: *seconds,
                block: *block,
            }),
            MotionItem::ToolChange { .. } => notes.push(Note::ToolChange),
            _ => {}
        }
    }
}
