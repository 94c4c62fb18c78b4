//! A group of axes: the servo tick of those with plain drives and the periods of the current loop
//! in vectors, everything else lane by lane.

use super::kernel::{Periods, Stop};
use super::lanes::{Lanes, WIDTH};
use super::tick::{Command, Measure};
use super::twins::{TwinTick, Twins};
use crate::error::AxisError;
use crate::runner::{AxisOutput, AxisRunner, Seen};
use crate::signal::{Correction, Setpoint};
use pulp::Arch;

/// Up to [`WIDTH`] axes with the same number of servo ticks in a command cycle and of current
/// periods in a servo tick.
pub(super) struct Group {
    axes: Vec<Box<dyn AxisRunner>>,
    servo_ticks: u32,
    periods: u32,
    lanes: Box<Lanes>,
    twins: Box<Twins>,
    arch: Arch,
    marks: Marks,
    /// What the compensators of traced lanes answered last; those that are never asked make no
    /// estimates.
    corrections: [Correction; WIDTH],
}

/// What is done with each lane.
#[derive(Clone, Copy, Default)]
struct Marks {
    /// It has a setpoint.
    running: [bool; WIDTH],
    /// Its current loop and plant are stepped in vectors.
    active: [bool; WIDTH],
    /// So is its servo tick, and it is up to date in the lanes alone.
    resident: [bool; WIDTH],
    /// Resident, and its compensator has to be asked.
    asked: [bool; WIDTH],
    /// Whether any of those that run is not resident, and whether somebody looks at every tick of one that is.
    any_alone: bool,
    any_watched: bool,
}

impl Group {
    /// Of no axis yet.
    pub(super) fn new(servo_ticks: u32, periods: u32) -> Group {
        Group {
            axes: Vec::new(),
            servo_ticks,
            periods,
            lanes: Box::new(Lanes::new(servo_ticks as usize)),
            twins: Box::default(),
            arch: Arch::new(),
            marks: Marks::default(),
            corrections: [Correction::NONE; WIDTH],
        }
    }

    /// Adds an axis with as many ticks and periods, of at most [`WIDTH`].
    pub(super) fn add(&mut self, axis: Box<dyn AxisRunner>) {
        self.axes.push(axis);
    }

    pub(super) fn axes(&self) -> impl Iterator<Item = &dyn AxisRunner> {
        self.axes.iter().map(|axis| &**axis)
    }

    pub(super) fn axes_mut(&mut self) -> impl Iterator<Item = &mut dyn AxisRunner> {
        self.axes
            .iter_mut()
            .map(|axis| &mut **axis as &mut dyn AxisRunner)
    }

    /// Setpoints and outputs lane by lane, possibly of different lengths.
    pub(super) fn push(
        &mut self,
        setpoints: &[&[Setpoint]],
        outputs: &mut [&mut AxisOutput],
    ) -> Vec<Result<(), AxisError>> {
        let mut results: Vec<Result<(), AxisError>> = outputs.iter().map(|_| Ok(())).collect();
        // lanes may bring lists of different lengths; one that has come to its end rests
        let longest = setpoints.iter().map(|list| list.len()).max().unwrap_or(0);
        let ticks = longest * self.servo_ticks as usize;
        for (lane, output) in outputs.iter_mut().enumerate() {
            // the peaks go on from what the outputs already hold
            self.lanes.states.peak.0[lane] = output.peak_current_a;
            output.load.reserve(ticks);
            output.reference.reserve(ticks);
            output.monitored.reserve(longest);
        }
        // between pushes the axes themselves hold their states (see the end), so numbers and states
        // are gathered anew in each
        let mut described = [false; WIDTH];
        for tick in 0..longest {
            for (lane, (axis, list)) in self.axes.iter_mut().zip(setpoints).enumerate() {
                self.marks.running[lane] = false;
                let (Some(setpoint), Some(result @ Ok(()))) =
                    (list.get(tick), results.get_mut(lane))
                else {
                    continue;
                };
                // a refused setpoint takes its lane out for the rest of the push; the others go on
                match axis.begin_setpoint(setpoint) {
                    Ok(()) => self.marks.running[lane] = true,
                    refused => *result = refused,
                }
            }
            self.take_up(&mut described, outputs);
            for index in 0..self.servo_ticks {
                self.servo_tick(index, outputs);
            }
            self.show(outputs);
        }
        // every lane is released, so that its axis is up to date for those who read it
        self.marks.running = [false; WIDTH];
        self.take_up(&mut described, outputs);
        for (lane, output) in outputs.iter_mut().enumerate() {
            output.peak_current_a = self.lanes.states.peak.0[lane];
        }
        results
    }

    /// Takes up the axes that begin and those whose numbers may have changed, the setpoints of all,
    /// and gives back those that do not go on.
    fn take_up(&mut self, described: &mut [bool; WIDTH], outputs: &mut [&mut AxisOutput]) {
        let Group {
            axes,
            lanes,
            twins,
            marks,
            ..
        } = self;
        let watched = outputs
            .iter()
            .any(|output| output.trace.is_some() || output.motor.is_some());
        for (lane, (axis, output)) in axes.iter_mut().zip(outputs).enumerate() {
            let mut axis = axis.current_loop();
            // a lane that ends gives its state back to the axis, and its count of ticks at a limit
            // to the output
            if !marks.running[lane] {
                if marks.resident[lane] {
                    lanes.release(lane, &mut axis);
                    output.saturated_samples += lanes.loops.saturated_ticks.0[lane] as u64;
                }
                (marks.active[lane], marks.resident[lane], marks.asked[lane]) =
                    (false, false, false);
                continue;
            }
            // a drifting plant has new numbers at every setpoint, the others once in a push
            if !described[lane] || axis.drifting {
                marks.active[lane] = lanes.describe(lane, &axis);
                let plain = marks.active[lane] && !axis.drifting;
                marks.resident[lane] = plain && lanes.settle(lane, &axis);
                marks.asked[lane] = marks.resident[lane] && !axis.passive;
                described[lane] = true;
                // the compensator's model is described anew with its axis
                twins.forget(lane);
            }
            if marks.resident[lane] {
                lanes.refer(lane, &axis);
            }
        }
        let all = 0..WIDTH;
        marks.any_alone = all
            .clone()
            .any(|lane| marks.running[lane] && !marks.resident[lane]);
        marks.any_watched = watched && all.clone().any(|lane| marks.resident[lane]);
    }

    fn servo_tick(&mut self, index: u32, outputs: &mut [&mut AxisOutput]) {
        let Group {
            axes,
            servo_ticks,
            periods,
            lanes,
            twins,
            arch,
            marks,
            corrections,
            ..
        } = self;
        let (lanes, resident) = (&mut **lanes, marks.resident);
        // resident lanes measure together
        arch.dispatch(Measure {
            lanes,
            index: index as usize,
            resident,
        });
        if marks.asked.iter().any(|asked| *asked) {
            // compensators run lane by lane up to their model of the axis; the models step together
            // all of them before any is used: what was just written number by number would be
            // waited for when it is read in vectors
            let seen: [Seen; WIDTH] = std::array::from_fn(|lane| lanes.seen(lane));
            let mut steps = [const { None }; WIDTH];
            let all = axes.iter_mut().zip(&seen).zip(&mut steps);
            for (((axis, seen), step), asked) in all.zip(marks.asked) {
                if asked {
                    axis.begin_compensation(index, seen, step);
                }
            }
            let references = &lanes.loops.references;
            let at = index as usize;
            let tick = TwinTick {
                // there is one row more than ticks
                references: [&references[at], &references[at + 1]],
                periods: *periods,
                is_last: index + 1 == *servo_ticks,
            };
            twins.step(*arch, &mut steps, &tick);
            // the other way round, since what was touched last is still at hand
            for (lane, axis) in axes.iter_mut().enumerate().rev() {
                if !marks.asked[lane] {
                    continue;
                }
                let correction = axis.finish_compensation();
                lanes.loops.correct(lane, &correction);
                if marks.any_watched {
                    corrections[lane] = correction;
                }
            }
        }
        // a sample shows the axis before this tick's command has any effect
        if marks.any_watched {
            for (lane, (axis, output)) in axes.iter_mut().zip(outputs.iter_mut()).enumerate() {
                if let Some(trace) = output.trace.as_mut().filter(|_| resident[lane]) {
                    let (fast, correction) = (axis.current_loop(), &corrections[lane]);
                    trace.push(lanes.sample(lane, index as usize, &fast, correction));
                }
                if let Some(motor) = output.motor.as_mut().filter(|_| resident[lane]) {
                    motor.push(lanes.motor(lane));
                }
            }
        }
        // position and velocity loops together
        arch.dispatch(Command {
            lanes,
            index: index as usize,
            resident,
        });
        let alone = |lane: usize| marks.any_alone && marks.running[lane] && !resident[lane];
        for (lane, (axis, output)) in axes.iter_mut().zip(outputs.iter_mut()).enumerate() {
            if !alone(lane) {
                continue;
            }
            // other lanes take their tick by themselves and lend their state for the periods
            axis.begin_tick(index, output);
            let mut fast = axis.current_loop();
            if marks.active[lane] {
                lanes.hold(lane, &fast);
                lanes.gather(lane, &fast);
            } else {
                let peak = &mut lanes.states.peak.0[lane];
                (0..*periods).for_each(|_| fast.period(peak));
            }
        }
        // periods run in vectors up to one that some lanes have to take by themselves
        let mut from = 0;
        while let Some(stop) = arch.dispatch(Periods {
            lanes,
            from,
            to: *periods,
            active: marks.active,
        }) {
            by_themselves(axes, lanes, &stop, &resident);
            from = stop.period + 1;
        }
        // resident lanes count their ticks at a limit here, the others in `finish`
        lanes.loops.count();
        for (lane, (axis, output)) in axes.iter_mut().zip(outputs.iter_mut()).enumerate() {
            if alone(lane) {
                let mut fast = axis.current_loop();
                if marks.active[lane] {
                    lanes.scatter(lane, &mut fast);
                }
                fast.finish(output);
            }
        }
    }

    /// Appends what the lanes showed during a setpoint, and what their controls watch at its end.
    fn show(&mut self, outputs: &mut [&mut AxisOutput]) {
        for (lane, (axis, output)) in self.axes.iter_mut().zip(outputs.iter_mut()).enumerate() {
            if self.marks.running[lane] && !self.marks.resident[lane] {
                let peak_current_a = self.lanes.states.peak.0[lane];
                axis.current_loop()
                    .monitor(self.servo_ticks, peak_current_a, output);
            }
        }
        // the lanes keep a row for each servo tick, an output the ticks of one axis
        for (lane, output) in outputs
            .iter_mut()
            .enumerate()
            .filter(|(lane, _)| self.marks.resident[*lane])
        {
            // the lane's own count is added to the output's at the end of the push
            let before = output.saturated_samples;
            output
                .monitored
                .push(self.lanes.monitored(lane, self.servo_ticks, before));
            output
                .load
                .extend(self.lanes.loops.shown.iter().map(|[load, _]| load.0[lane]));
            output.reference.extend(
                self.lanes
                    .loops
                    .shown
                    .iter()
                    .map(|[_, reference]| reference.0[lane]),
            );
        }
    }
}

/// The period of the lanes that the kernel has left as they were.
fn by_themselves(
    axes: &mut [Box<dyn AxisRunner>],
    lanes: &mut Lanes,
    stop: &Stop,
    resident: &[bool; WIDTH],
) {
    for (lane, axis) in axes
        .iter_mut()
        .enumerate()
        .filter(|(lane, _)| stop.lanes[*lane])
    {
        // the axis is brought up to date, takes the period with its event or cut voltage, and goes
        // back into the lanes
        let mut fast = axis.current_loop();
        if resident[lane] {
            lanes.hand_over(lane, &mut fast);
        } else {
            lanes.scatter(lane, &mut fast);
        }
        fast.period(&mut lanes.states.peak.0[lane]);
        lanes.gather(lane, &fast);
        if resident[lane] {
            // the next servo tick asks whether the voltage was cut, for its anti-windup
            lanes.loops.note_limits(lane, &fast);
        }
        // an event may have changed the mode, whose numbers the lane holds
        if !lanes.knows(lane, &fast) {
            lanes.describe(lane, &fast);
        }
    }
}
