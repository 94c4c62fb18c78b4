//! One cell: its program through the chain, all methods side by side, and the servo ticks that are
//! traced.

use super::cycle::{Watch, Windows, step_um};
use super::factor::{Cell, ENCODER, GAP};
use super::limit::Physics;
use super::machine::AXES;
use super::motion;
use super::result::{CellResult, FIGURE_DECIMALS, Tally};
use lostmotion_base::units::UM_PER_MM;
use lostmotion_base::{AxisId, Clock, Tick};
use lostmotion_contour::{ContourError, ContourSample, FootState};
use lostmotion_drive::AxisSample;
use lostmotion_drive::config::Change;
use lostmotion_methods::{AxisConfig, MethodId};
use lostmotion_plan::Sample;
use lostmotion_report::number::round_to;
use lostmotion_sim::{Frame as SimFrame, SETTLE_S, SinkError, TickSink, Ticks};

/// Servo ticks in a command cycle: the study's machine has the usual cycles.
const SERVO_TICKS: usize = (Clock::CNC.period_ns() / Clock::SERVO.period_ns()) as usize;
/// Reversals of each axis before measuring: what a method needs to learn belongs to no figure. A
/// choice.
const FIRST_REVERSALS: u32 = 4;
/// Time after the last of them, command cycles (0.1 s): the transient of the last reversal is over.
const REST_TICKS: Tick = 100;

/// What is measured of a cell's machine in all its variants.
pub(super) struct Bench<'a, 't> {
    cell: Cell,
    names: Vec<String>,
    /// Of the machine without a gap, then of the methods.
    feet: Vec<FootState>,
    /// Servo ticks of each method for which its drive was at a limit.
    saturated: Vec<u64>,
    with_z: bool,
    tallies: Vec<Tally>,
    frames: Vec<Frame>,
    physics: Physics,
    gap_drift: Option<Change>,
    motor_rad_per_mm: f64,
    watches: [Watch; 2],
    events: [Windows; 2],
    reversals: [u32; 2],
    /// Watch over Z and its reversals, where Z is an axis like the others.
    z: (Watch, u32),
    measured_from: Option<Tick>,
    ticks: Tick,
    reached_mm_s: f64,
    limit_max_rad: f64,
    limit_squares: f64,
    floating_ticks: u64,
    trace: Option<&'a mut Trace<'t>>,
}

impl<'a, 't> Bench<'a, 't> {
    pub(super) fn new(
        cell: &Cell,
        config: &AxisConfig,
        methods: &[String],
        trace: Option<&'a mut Trace<'t>>,
    ) -> Bench<'a, 't> {
        // `none` is always run, and first: the ratios refer to it.
        let mut names = vec![MethodId::NONE.name().to_owned()];
        names.extend(
            methods
                .iter()
                .filter(|name| *name != MethodId::NONE.name())
                .cloned(),
        );
        let motor_rad_per_mm = config.transmission.motor_rad_per_unit();
        let count_um = count_um(cell, motor_rad_per_mm);
        Bench {
            cell: *cell,
            tallies: vec![Tally::new(step_um(count_um, cell.number(GAP))); names.len()],
            feet: vec![FootState::default(); names.len() + 1],
            saturated: vec![0; names.len()],
            with_z: motion::moves_z(cell),
            names,
            frames: Vec::new(),
            physics: Physics::of(config),
            gap_drift: config.drift.gap,
            motor_rad_per_mm,
            watches: Default::default(),
            events: Default::default(),
            reversals: [0; 2],
            z: (Watch::default(), 0),
            measured_from: None,
            ticks: 0,
            reached_mm_s: 0.0,
            limit_max_rad: 0.0,
            limit_squares: 0.0,
            floating_ticks: 0,
            trace,
        }
    }

    /// The methods, `none` first.
    pub(super) fn names(&self) -> Vec<String> {
        self.names.clone()
    }

    /// Where the loads of a variant are, mm. A Z that the program does not move is taken as ideal.
    fn load(&self, ticks: &Ticks<'_>, variant: usize, frame: &SimFrame) -> [f64; 3] {
        self.with_ideal_z(ticks.load(variant, frame).linear(), frame)
    }

    fn with_ideal_z(&self, [x, y, z]: [f64; 3], frame: &SimFrame) -> [f64; 3] {
        let ideal = frame.sample.position[AxisId::Z];
        [x, y, if self.with_z { z } else { ideal }]
    }

    /// Pairs each servo sample with the command it answers to and measures the machine without a
    /// gap.
    fn frame(&mut self, ticks: &Ticks<'_>) -> Result<(), ContourError> {
        self.frames.clear();
        for found in ticks.frames() {
            // Servo ticks of one command cycle share its command.
            let (tick, part) = (
                found.tick / SERVO_TICKS as Tick,
                found.tick % SERVO_TICKS as Tick,
            );
            if found.is_command_tick {
                self.watch(tick, &found.sample);
            }
            let since = self.measured_from.and_then(|from| tick.checked_sub(from));
            let mut frame = Frame {
                tick: found.tick,
                command: found.sample,
                commanded_tip_mm: self.with_ideal_z(found.pose.tip, found),
                without_gap: ContourSample::default(),
                z_counts: self.z.1 >= FIRST_REVERSALS,
                since: since.map(|ticks| ticks as usize * SERVO_TICKS + part as usize),
            };
            // Variant 0 has no gap: its contour error is the part that servo and planning cause.
            let load = self.load(ticks, 0, found);
            if let Some(foot) = self.feet.first_mut() {
                frame.without_gap = ticks.measure(foot, found, [frame.commanded_tip_mm, load])?;
            }
            if frame.measured() {
                self.reached_mm_s = self.reached_mm_s.max(frame.command.path_speed);
            }
            self.frames.push(frame);
        }
        Ok(())
    }

    /// Counts reversals and changes of flank, and what they cost at least.
    fn watch(&mut self, tick: Tick, command: &Sample) {
        let since = self.measured_from.and_then(|from| tick.checked_sub(from));
        for axis in 0..AXES.len() {
            let (Some(id), Some(watch)) = (AXES.get(axis), self.watches.get_mut(axis)) else {
                continue;
            };
            let factor = self.motor_rad_per_mm;
            let event = watch.step(
                &self.physics,
                command.velocity[*id] * factor,
                command.acceleration[*id] * factor,
            );
            // Reversals open the measuring, changes of flank cost at least what physics takes.
            if let (true, Some(count)) = (event.reversal, self.reversals.get_mut(axis)) {
                *count += 1;
            }
            let (Some(since), Some(events)) = (since, self.events.get_mut(axis)) else {
                continue;
            };
            if event.reversal || event.flank_rad.is_some() {
                events.count(since as usize * SERVO_TICKS);
            }
            if let Some(least) = event.flank_rad {
                self.limit_max_rad = self.limit_max_rad.max(least);
                self.limit_squares += least * least;
            }
        }
        let factor = self.motor_rad_per_mm;
        let floats = |id: &AxisId| {
            self.physics.floats(
                command.velocity[*id] * factor,
                command.acceleration[*id] * factor,
            )
        };
        self.floating_ticks += u64::from(since.is_some() && AXES.iter().any(floats));
        let z = self.z.0.step(
            &self.physics,
            command.velocity[AxisId::Z] * factor,
            command.acceleration[AxisId::Z] * factor,
        );
        self.z.1 += u32::from(z.reversal);
        // Every axis has reversed often enough: measuring begins behind the transient.
        if self.measured_from.is_none()
            && self.reversals.iter().all(|count| *count >= FIRST_REVERSALS)
        {
            self.measured_from = Some(tick + REST_TICKS);
        }
    }

    /// Measures a method, counted from 0, at every servo tick of the chunk.
    fn measure(&mut self, method: usize, ticks: &Ticks<'_>) -> Result<(), ContourError> {
        // Variant 0 is the machine without a gap.
        let variant = method + 1;
        // Only the last method goes to the trace.
        let traced = variant == self.names.len();
        let sample = |axis: usize, frame: &SimFrame| {
            let id = AXES.get(axis).copied().unwrap_or_default();
            ticks.trace(variant, id, frame).copied()
        };
        let sample =
            |axis, frame: &SimFrame| -> AxisSample { sample(axis, frame).unwrap_or_default() };
        for (frame, found) in self.frames.iter().zip(ticks.frames()) {
            let without = self.load(ticks, 0, found);
            let mut load = self.load(ticks, variant, found);
            // Until Z has reversed often enough it counts as ideal, like a Z that is no axis here.
            if !frame.z_counts {
                load[2] = without[2];
            }
            let (Some(foot), Some(tally)) =
                (self.feet.get_mut(variant), self.tallies.get_mut(method))
            else {
                return Ok(());
            };
            let error = ticks.measure(foot, found, [frame.commanded_tip_mm, load])?;
            let measured = frame.measured();
            if measured {
                // What backlash adds: with the gap minus without.
                tally.contour(caused_mm(
                    [error.error_mm, frame.without_gap.error_mm],
                    [load, without],
                ));
            }
            if let Some(since) = frame.since {
                // The true half gap of the moment: it drifts from the start of the settling on.
                let time_s = Clock::SERVO.seconds(frame.tick) + SETTLE_S;
                let half_gap = 0.5
                    * self.physics.gap_rad
                    * self.gap_drift.map_or(1.0, |change| change.at(time_s));
                for axis in 0..AXES.len() {
                    let deviation = load
                        .get(axis)
                        .zip(without.get(axis))
                        .map_or(f64::NAN, |(with, without)| with - without);
                    tally.axis(axis, since, deviation, &sample(axis, found), half_gap);
                }
            }
            if let (true, Some(trace)) = (traced, &mut self.trace) {
                let error_um =
                    [error.error_mm, frame.without_gap.error_mm].map(|mm| mm * UM_PER_MM);
                trace(&Traced {
                    tick: frame.tick,
                    error_um,
                    measured,
                    axes: [0, 1].map(|axis| sample(axis, found)),
                });
            }
        }
        Ok(())
    }

    pub(super) fn finish(self) -> CellResult {
        // From radians of the motor to um at the slide.
        let um_per_rad = UM_PER_MM / self.motor_rad_per_mm;
        let ticks = self.ticks * SERVO_TICKS as Tick;
        let from = self.measured_from.unwrap_or(self.ticks);
        // At least one cycle, so that a program without four reversals divides by no zero.
        let measured_s = Clock::CNC
            .seconds(self.ticks.saturating_sub(from))
            .max(Clock::CNC.period_s());
        // Every unavoidable error at its largest for a whole traverse, over the measured time.
        let limit_rms = (self.limit_squares * self.physics.traverse_s / measured_s).sqrt();
        let figures = |(tally, (name, saturated)): (&Tally, (&String, &u64))| {
            let share = *saturated as f64 / (ticks.max(1) as f64);
            Some(tally.figures(name, self.tallies.first()?, &self.events, share))
        };
        let methods = self.names.iter().zip(&self.saturated);
        CellResult {
            cell: self.cell,
            duration_s: round_to(Clock::CNC.seconds(self.ticks), 3),
            measured_from_s: round_to(Clock::CNC.seconds(from), 3),
            samples: self.tallies.first().map_or(0, Tally::samples),
            reached_mm_min: round_to(self.reached_mm_s * 60.0, 3),
            reversals: self.reversals,
            traverse_ms: round_to(self.physics.traverse_s * 1e3, FIGURE_DECIMALS),
            limit_max_um: round_to(self.limit_max_rad * um_per_rad, FIGURE_DECIMALS),
            limit_rms_um: round_to(limit_rms * um_per_rad, FIGURE_DECIMALS),
            floating: round_to(
                Clock::CNC.seconds(self.floating_ticks) / measured_s,
                FIGURE_DECIMALS,
            ),
            encoder_um: round_to(count_um(&self.cell, self.motor_rad_per_mm), FIGURE_DECIMALS),
            methods: self
                .tallies
                .iter()
                .zip(methods)
                .filter_map(figures)
                .collect(),
        }
    }
}

impl TickSink for Bench<'_, '_> {
    fn chunk(&mut self, ticks: &Ticks<'_>) -> Result<(), SinkError> {
        // Behind the end of the plan only the delayed reference arrives: nothing is cut any more.
        if ticks.is_over() {
            return Ok(());
        }
        self.frame(ticks)?;
        for method in 0..self.names.len() {
            self.measure(method, ticks)?;
        }
        // These count from the start, so the last chunk leaves the figures of the whole run.
        for (method, saturated) in self.saturated.iter_mut().enumerate() {
            *saturated = ticks.saturated(method + 1);
        }
        self.ticks += ticks.samples().len() as Tick;
        Ok(())
    }
}

/// A count of the encoder at the slide, um.
fn count_um(cell: &Cell, motor_rad_per_mm: f64) -> f64 {
    match cell.number(ENCODER) as i32 {
        0 => 0.0,
        bits => UM_PER_MM * std::f64::consts::TAU / motor_rad_per_mm / f64::from(1_u32 << bits),
    }
}

/// Receives the servo ticks of the traced method.
pub type Trace<'a> = dyn FnMut(&Traced) + Send + 'a;

/// A servo tick of the traced method.
#[derive(Clone, Copy, Debug)]
pub struct Traced {
    /// Servo tick since the start of the program.
    pub tick: Tick,
    /// Signed contour error, um, and that of the machine without a gap.
    pub error_um: [f64; 2],
    /// Whether it counts for the figures.
    pub measured: bool,
    /// X and Y.
    pub axes: [AxisSample; 2],
}

/// The part of a servo tick that all methods of a cell share.
#[derive(Clone, Copy)]
pub(super) struct Frame {
    pub(super) tick: Tick,
    pub(super) command: Sample,
    pub(super) commanded_tip_mm: [f64; 3],
    pub(super) without_gap: ContourSample,
    /// Whether Z has reversed so often that its backlash counts, too.
    pub(super) z_counts: bool,
    /// Servo ticks since measuring began, if it has.
    pub(super) since: Option<usize>,
}

impl Frame {
    /// Whether it counts for the figures: a cutting move, after the first reversals.
    pub(super) fn measured(&self) -> bool {
        self.since.is_some() && self.command.path_speed > 0.0 && !self.without_gap.rapid
    }
}

/// The part of a signed contour error that backlash causes: with the gap minus without (errors and
/// loads with and without, mm). It can be no larger than the loads are apart. Where the difference
/// is larger all the same, the path turns back so sharply that one place lies on its left and on
/// its right: there the signs mean nothing, and the magnitudes are compared.
pub(super) fn caused_mm([with, without]: [f64; 2], [load, ideal]: [[f64; 3]; 2]) -> f64 {
    // Triangle inequality: the distance to the path changes by no more than the loads are apart.
    let apart = load
        .iter()
        .zip(ideal)
        .map(|(a, b)| (a - b) * (a - b))
        .sum::<f64>()
        .sqrt();
    let difference = with - without;
    // Tolerance for rounding, and for the foot point, which is found to a hundredth.
    if difference.abs() <= 1.01 * apart + 1e-6 {
        difference
    } else {
        (with.abs() - without.abs()).clamp(-apart, apart)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn where_the_path_turns_back_only_magnitudes_are_compared() {
        let at = |x: f64| [x, 0.0, 0.0];
        assert!((caused_mm([3e-3, -1e-3], [at(4e-3), at(0.0)]) - 4e-3).abs() < 1e-18);
        // 20 um on either side of a cusp, loads 1 um apart
        assert!((caused_mm([20e-3, -19.5e-3], [at(1e-3), at(0.0)]) - 0.5e-3).abs() < 1e-15);
        assert!((caused_mm([20e-3, -15e-3], [at(1e-3), at(0.0)]) - 1e-3).abs() < 1e-15);
    }
}
