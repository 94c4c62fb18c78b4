//! From planned stretches to samples at the clock's ticks.

use crate::chord::Chord;
use crate::motion::Stretch;
use crate::piece::size;
use crate::{Heeds, Sample};
use lostmotion_base::{AXES, Clock, Coords, Jet, Tick};
use lostmotion_kinematics::{JointMap, Kinematics};
use std::collections::VecDeque;

/// A bound of times.
#[derive(Clone, Copy, Debug)]
enum Until {
    Included(f64),
    Excluded(f64),
}

impl Until {
    fn holds(self, t: f64) -> bool {
        match self {
            Until::Included(end) => t <= end,
            Until::Excluded(end) => t < end,
        }
    }
}

/// Outputs samples up to where the motion is settled.
#[derive(Clone, Debug)]
pub(crate) struct Sampler {
    clock: Clock,
    tick: Tick,
    pub(crate) stretches: VecDeque<Stretch>,
    /// Where the motion rests after the stretches that are done, program side.
    rest: Sample,
    rest_program: Coords,
    /// End of the last motion or dwell, s; samples go on to the first tick at or after it.
    pub(crate) end_s: f64,
    pub(crate) finished: bool,
    /// Constant between program coordinates and joints under a tool offset, for kinematics that
    /// have one.
    offset: Option<([f64; 3], Coords)>,
    /// Limit of the distance between the tool and its way between two samples, for drives that go
    /// straight from command to command.
    pub(crate) chord: Option<Chord>,
}

impl Sampler {
    /// Starts at rest.
    pub(crate) fn new(clock: Clock, program: Coords, joints: Coords) -> Sampler {
        let rest = Sample {
            tick: 0,
            position: joints,
            velocity: Coords::ZERO,
            acceleration: Coords::ZERO,
            segment: 0,
            s: 0.0,
            path_speed: 0.0,
            feed_part: 0.0,
            chord_part: 0.0,
            heeds: Heeds::default(),
            tool_mm: [0.0; 3],
            block: lostmotion_base::BlockRef::default(),
        };
        Sampler {
            clock,
            tick: 0,
            stretches: VecDeque::new(),
            rest,
            rest_program: program,
            end_s: 0.0,
            finished: false,
            offset: None,
            chord: None,
        }
    }

    /// Adds up to `most` samples whose time is settled; gives how many.
    pub(crate) fn take(
        &mut self,
        most: usize,
        kinematics: &dyn Kinematics,
        out: &mut Vec<Sample>,
    ) -> usize {
        let before = out.len();
        while out.len() - before < most {
            let t = self.clock.seconds(self.tick);
            let settled = self.settled();
            if !settled.holds(t) {
                break;
            }
            // What has ended leaves only the place where the motion rests.
            while self
                .stretches
                .front()
                .is_some_and(|stretch| stretch.complete && t >= stretch.rest_s())
            {
                self.leave();
            }
            // Nearly all samples come from one stretch under affine kinematics, without the general
            // case's jets.
            if !self.run(before.saturating_add(most), settled, kinematics, out) {
                let sample = Sample {
                    tick: self.tick,
                    ..self.at(t, kinematics)
                };
                out.push(sample);
                self.tick += 1;
            }
            self.rest.position = out
                .last()
                .map_or(self.rest.position, |sample| sample.position);
        }
        if let Some(chord) = &self.chord {
            for sample in &mut out[before..] {
                sample.chord_part = chord.part(
                    [&sample.position, &sample.velocity, &sample.acceleration],
                    &sample.tool_mm,
                );
            }
        }
        out.len() - before
    }

    /// Up to when the motion is final.
    fn settled(&self) -> Until {
        match self.stretches.back() {
            Some(last) if !(self.finished && last.complete) => Until::Included(last.known_s()),
            _ if self.finished => {
                // The last sample is the first tick at or after the end.
                Until::Excluded(self.end_s + self.clock.period_s() * (1.0 - 1e-6))
            }
            _ => Until::Excluded(f64::NEG_INFINITY),
        }
    }

    /// Adds a stretch; the motion has rested where it begins.
    pub(crate) fn add(&mut self, stretch: Stretch) {
        if self.tick == 0
            && self.stretches.is_empty()
            && let Some((piece, local)) = stretch.peek(stretch.from)
        {
            let (mark, s) = piece.programmed(local);
            // The tool was measured before the first move: the tip stands where that begins.
            if piece.tool_mm != self.rest.tool_mm {
                self.rest_program = piece.curve.point(local);
            }
            self.rest = Sample {
                segment: mark.segment,
                s,
                block: mark.block,
                tool_mm: piece.tool_mm,
                heeds: piece.heeds,
                ..self.rest
            };
        }
        self.stretches.push_back(stretch);
    }

    /// Comes to rest at the end of the first stretch.
    fn leave(&mut self) {
        let Some(stretch) = self.stretches.pop_front() else {
            return;
        };
        if let Some((piece, local)) = stretch.peek(stretch.profile.to()) {
            let (mark, s) = piece.programmed(local);
            self.rest_program = piece.curve.point(local);
            let heeds = piece.heeds;
            self.rest = Sample {
                segment: mark.segment,
                s,
                block: mark.block,
                tool_mm: piece.tool_mm,
                heeds,
                ..self.rest
            };
        }
    }

    /// Adds samples until `out` has `most` of them, as long as only the first stretch moves and
    /// joints are program coordinates up to a constant: the usual case, without the cost of the
    /// general one. Returns whether a sample was added.
    fn run(
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
            .filter(|_| kinematics.joint_map() == JointMap::Shifted)
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
            // Joints are program coordinates plus a constant that depends on the tool offset alone.
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
                path_speed: if piece.goes_by_tip(&velocity) {
                    velocity.linear_norm()
                } else {
                    motion.v
                },
                feed_part: piece.fed_speed(&velocity, motion.v) / piece.feed,
                chord_part: 0.0,
                heeds: piece.heeds,
                tool_mm: piece.tool_mm,
                block: mark.block,
            });
            self.tick += 1;
        }
        out.len() > before
    }

    /// The sample at a time: that of the first stretch, or rest before it; at a rounded corner that
    /// of the sum of two.
    fn at(&mut self, t: f64, kinematics: &dyn Kinematics) -> Sample {
        let mut sample = Sample {
            velocity: Coords::ZERO,
            acceleration: Coords::ZERO,
            path_speed: 0.0,
            feed_part: 0.0,
            ..self.rest
        };
        let mut program = self.rest_program.0.map(|p| Jet::new(p, 0.0, 0.0, 0.0));
        if let Some(first) = self
            .stretches
            .front_mut()
            .and_then(|stretch| follow(stretch, t, &mut sample))
        {
            program = first.program;
            sample.feed_part = first.speed / first.feed;
            let second = self
                .stretches
                .get_mut(1)
                .filter(|stretch| t > stretch.start_s);
            if let Some((stretch, corner)) =
                second.and_then(|stretch| stretch.corner.map(|corner| (stretch, corner)))
            {
                let before = sample;
                if let Some(second) = follow(stretch, t, &mut sample) {
                    // Both motions start from the corner: their sum counts it once.
                    for (joint, (a, b)) in program.iter_mut().zip(second.program).enumerate() {
                        *a = *a + b - Jet::new(corner.0[joint], 0.0, 0.0, 0.0);
                    }
                    // The nearer end of the corner is that of the line on which less is left or
                    // gone.
                    let heeds = before.heeds.max(sample.heeds);
                    if second.gone <= first.left {
                        sample = before;
                    }
                    sample.path_speed = path_speed(&program);
                    sample.feed_part = sample.path_speed / first.feed.min(second.feed);
                    sample.heeds = heeds;
                }
            }
        }
        joints(&mut sample, &program, kinematics);
        sample
    }
}

/// Where a stretch is at a time, program side, with the distance gone and left on it.
struct SamplePlace {
    program: [Jet; AXES],
    gone: f64,
    left: f64,
    /// Speed of the parameter or the tip, whichever is larger, and what the feed allows of both.
    speed: f64,
    feed: f64,
}

/// Speed of the tip, mm/s, or where it stands still that of the other axes as the feed rule
/// measures them.
fn path_speed(program: &[Jet; AXES]) -> f64 {
    let velocity = Coords(program.map(|jet| jet.0[1]));
    let tip = velocity.linear_norm();
    if tip > 0.0 { tip } else { size(&velocity) }
}

/// Moves along a stretch if it has begun, and says in the sample where that is.
fn follow(stretch: &mut Stretch, t: f64, sample: &mut Sample) -> Option<SamplePlace> {
    if t <= stretch.start_s {
        return None;
    }
    let motion = stretch.advance(t - stretch.start_s);
    let (piece, local) = stretch.here(motion.s)?;
    let (mark, s) = piece.programmed(local);
    let (tool_mm, heeds) = (piece.tool_mm, piece.heeds);
    let program = piece
        .curve
        .jet(local)
        .map(|jet| jet.reparametrize(motion.v, motion.a, 0.0));
    let velocity = Coords(program.map(|jet| jet.0[1]));
    let speed = piece.fed_speed(&velocity, motion.v);
    let named = Sample {
        segment: mark.segment,
        s,
        block: mark.block,
        path_speed: if piece.goes_by_tip(&velocity) {
            speed
        } else {
            motion.v
        },
        tool_mm,
        heeds,
        ..*sample
    };
    *sample = named;
    let (gone, left) = (motion.s - stretch.from, stretch.profile.to() - motion.s);
    Some(SamplePlace {
        program,
        speed,
        feed: piece.feed,
        gone,
        left,
    })
}

/// Joint position, velocity and acceleration from the program side's, both by time. Poses were
/// checked when the move was pushed; should one fail all the same, the joints stay where they are.
fn joints(sample: &mut Sample, program: &[Jet; AXES], kinematics: &dyn Kinematics) {
    if kinematics.joint_map() == JointMap::Shifted {
        let point = Coords(program.map(|jet| jet.0[0]));
        if let Ok(position) = kinematics.inverse(&point, &sample.tool_mm) {
            sample.position = position;
            sample.velocity = Coords(program.map(|jet| jet.0[1]));
            sample.acceleration = Coords(program.map(|jet| jet.0[2]));
        }
    } else if let Ok(jets) = kinematics.inverse_jet(program, &sample.tool_mm) {
        sample.position = Coords(jets.map(|jet| jet.0[0]));
        sample.velocity = Coords(jets.map(|jet| jet.0[1]));
        sample.acceleration = Coords(jets.map(|jet| jet.0[2]));
    }
}
