//! A group of axes: lane by lane the servo tick, then all lanes the periods of the current loop.

use super::kernel::{Periods, Stop};
use super::lanes::{Lanes, WIDTH};
use crate::error::AxisError;
use crate::runner::{AxisOutput, AxisRunner};
use crate::signal::Setpoint;
use pulp::Arch;

/// Up to [`WIDTH`] axes with the same number of servo ticks in a command cycle and of current periods in a servo tick.
pub(super) struct Group {
    axes: Vec<Box<dyn AxisRunner>>,
    servo_ticks: u32,
    periods: u32,
    lanes: Lanes,
    arch: Arch,
    /// Lanes that the kernel steps.
    active: [bool; WIDTH],
}

impl Group {
    pub(super) fn new(axis: Box<dyn AxisRunner>, periods: u32) -> Group {
        let servo_ticks = axis.servo_ticks() as u32;
        Group { axes: vec![axis], servo_ticks, periods, lanes: Lanes::new(), arch: Arch::new(), active: [false; WIDTH] }
    }

    /// Whether it has room for one more axis in a group of at most `size`.
    pub(super) fn takes(&self, axis: &dyn AxisRunner, periods: u32, size: usize) -> bool {
        self.axes.len() < size.min(WIDTH) && self.periods == periods && self.servo_ticks as usize == axis.servo_ticks()
    }

    pub(super) fn add(&mut self, axis: Box<dyn AxisRunner>) {
        self.axes.push(axis);
    }

    pub(super) fn len(&self) -> usize {
        self.axes.len()
    }

    pub(super) fn axes(&self) -> impl Iterator<Item = &dyn AxisRunner> {
        self.axes.iter().map(|axis| &**axis)
    }

    /// Setpoints and outputs lane by lane, possibly of different lengths.
    pub(super) fn push(&mut self, setpoints: &[&[Setpoint]], outputs: &mut [AxisOutput]) -> Vec<Result<(), AxisError>> {
        let mut results: Vec<Result<(), AxisError>> = outputs.iter().map(|_| Ok(())).collect();
        let longest = setpoints.iter().map(|list| list.len()).max().unwrap_or(0);
        for (lane, output) in outputs.iter().enumerate() {
            self.lanes.states.peak.0[lane] = output.peak_current_a;
        }
        // whoever has a runner may have changed its state since the last push
        let mut described = [false; WIDTH];
        for tick in 0..longest {
            let mut running = [false; WIDTH];
            for (lane, (axis, list)) in self.axes.iter_mut().zip(setpoints).enumerate() {
                let (Some(setpoint), Some(result @ Ok(()))) = (list.get(tick), results.get_mut(lane)) else { continue };
                *result = axis.begin_setpoint(setpoint);
                running[lane] = result.is_ok();
            }
            self.describe(&running, &mut described);
            for index in 0..self.servo_ticks {
                self.servo_tick(index, &running, outputs);
            }
        }
        for (lane, output) in outputs.iter_mut().enumerate() {
            output.peak_current_a = self.lanes.states.peak.0[lane];
        }
        results
    }

    /// Takes up the numbers of the axes where they may have changed.
    fn describe(&mut self, running: &[bool; WIDTH], described: &mut [bool; WIDTH]) {
        for (lane, axis) in self.axes.iter_mut().enumerate() {
            let fast = axis.current_loop();
            if !described[lane] || fast.drifting {
                self.active[lane] = self.lanes.describe(lane, &fast);
                described[lane] = true;
            }
            self.active[lane] &= running[lane];
        }
    }

    fn servo_tick(&mut self, index: u32, running: &[bool; WIDTH], outputs: &mut [AxisOutput]) {
        let Group { axes, periods, lanes, arch, active, .. } = self;
        for (lane, (axis, output)) in axes.iter_mut().zip(outputs.iter_mut()).enumerate() {
            if !running[lane] {
                continue;
            }
            axis.begin_tick(index, output);
            let mut fast = axis.current_loop();
            if active[lane] {
                lanes.hold(lane, &fast);
                lanes.gather(lane, &fast);
            } else {
                let peak = &mut lanes.states.peak.0[lane];
                (0..*periods).for_each(|_| fast.period(peak));
            }
        }
        let mut from = 0;
        while let Some(stop) = arch.dispatch(Periods { lanes, from, to: *periods, active: *active }) {
            by_themselves(axes, lanes, &stop);
            from = stop.period + 1;
        }
        for (lane, (axis, output)) in axes.iter_mut().zip(outputs.iter_mut()).enumerate() {
            if running[lane] {
                let mut fast = axis.current_loop();
                if active[lane] {
                    lanes.scatter(lane, &mut fast);
                }
                fast.finish(output);
            }
        }
    }
}

/// The period of the lanes that the kernel has left as they were.
fn by_themselves(axes: &mut [Box<dyn AxisRunner>], lanes: &mut Lanes, stop: &Stop) {
    for (lane, axis) in axes.iter_mut().enumerate().filter(|(lane, _)| stop.lanes[*lane]) {
        let mut fast = axis.current_loop();
        lanes.scatter(lane, &mut fast);
        fast.period(&mut lanes.states.peak.0[lane]);
        lanes.gather(lane, &fast);
        if !lanes.knows(lane, &fast) {
            lanes.describe(lane, &fast);
        }
    }
}
