//! The plan ahead of the axes: chunk by chunk, as far as there is room, by whatever thread is idle.
//!
//! Planning comes in bursts: a long curve is found at once, and the next seconds of motion cost nothing. So
//! the axes go on with chunks that are ready while the next ones are planned. Without threads a chunk is
//! planned where it is needed. The chunks are the same either way.

use crate::error::SimError;
use crate::limiter::{Along, Limiter};
use crate::motion::{Feed, Modes};
use crate::results::PlanInfo;
use lostmotion_base::threads;
use lostmotion_contour::ProgrammedSegment;
use lostmotion_plan::Sample;
use std::any::Any;
use std::collections::VecDeque;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Most chunks that wait for the axes. A choice: the longest bursts take as long as the axes take for ten chunks,
/// and a chunk's samples take 0.4 MB.
const MOST_READY: usize = 16;

/// A chunk of the plan.
pub(crate) struct Planned {
    pub(crate) samples: Vec<Sample>,
    /// By sample, what limits the motion up to it; empty where nobody asks.
    pub(crate) limiters: Vec<Option<Limiter>>,
    /// What was read on the way.
    pub(crate) segments: Vec<ProgrammedSegment>,
    pub(crate) modes: Modes,
    pub(crate) bytes_done: u64,
    /// The last sample of the plan up to its end.
    pub(crate) last: Option<Sample>,
    pub(crate) error: Option<SimError>,
}

impl Planned {
    /// Whether nothing comes behind it.
    fn is_last(&self) -> bool {
        self.samples.is_empty() || self.error.is_some()
    }
}

/// What plans.
struct PlanSource {
    feed: Feed,
    /// Who says what limits the plan, if somebody asks.
    along: Option<Along>,
    /// Samples of a chunk.
    most: usize,
}

impl PlanSource {
    /// The next chunk, in the room of one that is done with.
    fn plan(&mut self, mut planned: Planned) -> Planned {
        let PlanSource { feed, along, most } = self;
        planned.segments.clear();
        let result = feed.chunk(*most, &mut planned.samples, &mut planned.segments);
        planned.error = result.err();
        planned.modes.clone_from(feed.modes());
        planned.limiters.clear();
        if let Some(along) = along {
            let intervals = along.chunk(&planned.samples, feed.notes(), feed.modes());
            let limiters = intervals.map(|interval| Some(interval?.limiter));
            planned.limiters.extend(limiters);
        }
        planned.bytes_done = feed.bytes_done();
        planned.last = feed.last();
        planned
    }
}

/// Whether some thread plans ahead.
#[derive(Clone, Copy, Debug, PartialEq)]
enum AheadWork {
    None,
    /// Wanted, but no thread has been idle yet.
    Asked,
    Begun,
}

/// What is ready, and what is known of who plans.
struct Ready {
    chunks: VecDeque<Planned>,
    /// Room of chunks that are done with.
    spare: Vec<Planned>,
    work: AheadWork,
    /// Whether there is nothing more to plan: the plan is over, or nobody needs it any more.
    over: bool,
    /// Why planning ahead came to an untimely end.
    panic: Option<Box<dyn Any + Send>>,
}

impl Ready {
    fn wants_more(&self) -> bool {
        !self.over && self.panic.is_none() && self.chunks.len() < MOST_READY
    }
}

/// Both. Whoever plans holds the source until the chunk is ready, so that chunks are in their order.
struct Shared {
    source: Mutex<PlanSource>,
    ready: Mutex<Ready>,
    /// Something has become ready, or nobody plans any more.
    news: Condvar,
}

/// The plan ahead of the axes.
pub(crate) struct Ahead {
    shared: Arc<Shared>,
    modes: Modes,
    threads: usize,
}

impl Ahead {
    /// From the start of the program, `most` samples a chunk.
    pub(crate) fn new(feed: Feed, along: Option<Along>, most: usize, threads: usize) -> Ahead {
        let modes = feed.modes().clone();
        let ready = Ready {
            chunks: VecDeque::new(),
            spare: Vec::new(),
            work: AheadWork::None,
            over: false,
            panic: None,
        };
        let shared = Shared {
            source: Mutex::new(PlanSource { feed, along, most }),
            ready: Mutex::new(ready),
            news: Condvar::new(),
        };
        Ahead {
            shared: Arc::new(shared),
            modes,
            threads,
        }
    }

    /// The next chunk: one that is ready, or one that is planned now. The last ones are empty.
    pub(crate) fn next(&mut self) -> Planned {
        let planned = self.shared.next(&self.modes);
        self.ask();
        planned
    }

    /// Hands back the room of a chunk.
    pub(crate) fn done_with(&mut self, planned: Planned) {
        lock(&self.shared.ready).spare.push(planned);
    }

    /// Has an idle thread plan ahead, unless one does.
    fn ask(&self) {
        if self.threads <= 1 {
            return;
        }
        let mut ready = lock(&self.shared.ready);
        if ready.work == AheadWork::None && ready.wants_more() {
            ready.work = AheadWork::Asked;
            let (shared, modes) = (Arc::clone(&self.shared), self.modes.clone());
            threads::spawn(move || shared.work(&modes));
        }
    }

    /// Tells how straight the tool goes, what the plan falls short of, and which interventions came after the
    /// end of the motion.
    pub(crate) fn tell(&self, plan: &mut PlanInfo) {
        lock(&self.shared.source).feed.tell(plan);
    }
}

impl Drop for Ahead {
    /// Nobody needs what would still be planned.
    fn drop(&mut self) {
        lock(&self.shared.ready).over = true;
    }
}

impl Shared {
    fn next(&self, modes: &Modes) -> Planned {
        let mut ready = lock(&self.ready);
        loop {
            if let Some(panic) = ready.panic.take() {
                drop(ready);
                resume_unwind(panic);
            }
            if let Some(planned) = ready.chunks.pop_front() {
                return planned;
            }
            if ready.work != AheadWork::Begun {
                break;
            }
            // Whoever plans may share the work out.
            let is_there = |of: &Ready| !of.chunks.is_empty() || of.work != AheadWork::Begun;
            ready = threads::help_or_wait(&self.ready, ready, &self.news, is_there);
        }
        drop(ready);
        // Nobody has begun: whoever begins now waits for the source.
        let mut source = lock(&self.source);
        let mut ready = lock(&self.ready);
        if let Some(planned) = ready.chunks.pop_front() {
            return planned;
        }
        let room = ready.room(modes);
        drop(ready);
        let planned = source.plan(room);
        lock(&self.ready).over = planned.is_last();
        planned
    }

    /// Plans chunks as long as there is room for them.
    fn work(&self, modes: &Modes) {
        let planning = AssertUnwindSafe(|| {
            lock(&self.ready).work = AheadWork::Begun;
            loop {
                let mut source = lock(&self.source);
                let mut ready = lock(&self.ready);
                if !ready.wants_more() {
                    break;
                }
                let room = ready.room(modes);
                drop(ready);
                let planned = source.plan(room);
                let mut ready = lock(&self.ready);
                ready.over |= planned.is_last();
                ready.chunks.push_back(planned);
                self.news.notify_all();
            }
        });
        let result = catch_unwind(planning);
        let mut ready = lock(&self.ready);
        ready.work = AheadWork::None;
        ready.panic = result.err();
        self.news.notify_all();
    }
}

impl Ready {
    fn room(&mut self, modes: &Modes) -> Planned {
        self.spare.pop().unwrap_or_else(|| Planned {
            samples: Vec::new(),
            limiters: Vec::new(),
            segments: Vec::new(),
            modes: modes.clone(),
            bytes_done: 0,
            last: None,
            error: None,
        })
    }
}

/// What a thread has left half done is told by its panic, which is passed on.
fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}
