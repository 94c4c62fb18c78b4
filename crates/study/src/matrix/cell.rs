//! One cell: its program through the chain, all methods side by side.

use super::cycle::{Windows, step_um};
use super::events::Watch;
use super::factor::{Cell, ENCODER, GAP};
use super::frame::{Frame, Traced, caused_mm, contour_input};
use super::lane::{Lane, SETTLE_TICKS};
use super::limit::Physics;
use super::machine::AXES;
use super::motion;
use super::result::CellResult;
use super::tally::Tally;
use crate::error::StudyError;
use lostmotion_base::units::UM_PER_MM;
use lostmotion_base::{AxisId, Clock, Coords, Tick};
use lostmotion_contour::{ContourConfig, ContourSample, ContourTracker, ProgrammedSegment};
use lostmotion_drive::Setpoint;
use lostmotion_drive::config::Change;
use lostmotion_methods::AxisConfig;
use lostmotion_plan::Sample;
use lostmotion_report::number::round_to;

/// Servo ticks in a command cycle: the study's machine has the usual cycles.
const SERVO_TICKS: usize = (Clock::CNC.period_ns() / Clock::SERVO.period_ns()) as usize;
/// Reversals of each axis before measuring.
const FIRST_REVERSALS: u32 = 4;
/// Time after the last of them, CNC ticks.
const AFTER: Tick = 100;
const DECIMALS: usize = 6;

/// The lanes of a cell and what is measured of them.
pub(super) struct Bench<'a> {
    cell: Cell,
    names: Vec<String>,
    /// The machine without a gap, then the methods.
    lanes: Vec<Lane>,
    tallies: Vec<Tally>,
    tracker: ContourTracker,
    frames: Vec<Frame>,
    setpoints: Vec<Setpoint>,
    physics: Physics,
    gap_drift: Option<Change>,
    motor_rad_per_mm: f64,
    watches: [Watch; 2],
    events: [Windows; 2],
    reversals: [u32; 2],
    /// Those of a Z that is an axis like the others.
    z: (Watch, u32),
    measured_from: Option<Tick>,
    previous: Option<Sample>,
    ticks: Tick,
    reached_mm_s: f64,
    limit_max_rad: f64,
    limit_squares: f64,
    floating_ticks: u64,
    trace: Option<&'a mut dyn FnMut(&Traced)>,
}

impl<'a> Bench<'a> {
    pub(super) fn new(
        cell: &Cell,
        config: &AxisConfig,
        methods: &[String],
        start: &Coords,
        trace: Option<&'a mut dyn FnMut(&Traced)>,
    ) -> Result<Bench<'a>, StudyError> {
        let mut names = vec!["none".to_owned()];
        names.extend(methods.iter().filter(|name| *name != "none").cloned());
        let with_z = motion::moves_z(cell);
        let mut lanes = vec![Lane::new(&config.without_gap(), "none", start, with_z)?];
        for name in &names {
            lanes.push(Lane::new(config, name, start, with_z)?);
        }
        let motor_rad_per_mm = config.transmission.motor_rad_per_unit();
        let count_um = count_um(cell, motor_rad_per_mm);
        Ok(Bench {
            cell: *cell,
            tallies: vec![Tally::new(step_um(count_um, cell.number(GAP))); names.len()],
            names,
            lanes,
            tracker: ContourTracker::new(ContourConfig::default()),
            frames: Vec::new(),
            setpoints: Vec::new(),
            physics: Physics::of(config),
            gap_drift: config.drift.gap,
            motor_rad_per_mm,
            watches: Default::default(),
            events: Default::default(),
            reversals: [0; 2],
            z: (Watch::default(), 0),
            measured_from: None,
            previous: None,
            ticks: 0,
            reached_mm_s: 0.0,
            limit_max_rad: 0.0,
            limit_squares: 0.0,
            floating_ticks: 0,
            trace,
        })
    }

    pub(super) fn chunk(
        &mut self,
        samples: &[Sample],
        segments: &[ProgrammedSegment],
    ) -> Result<(), StudyError> {
        for segment in segments {
            self.tracker.push(*segment)?;
        }
        for lane in &mut self.lanes {
            lane.run(samples, &mut self.setpoints)?;
        }
        self.frame(samples)?;
        for variant in 0..self.tallies.len() {
            self.measure(variant)?;
        }
        if let Some(last) = samples.last() {
            self.tracker.release(last.segment, last.s);
        }
        self.ticks += samples.len() as Tick;
        Ok(())
    }

    /// Pairs each servo sample with the command it answers to, one CNC tick before, and measures
    /// the machine without a gap.
    fn frame(&mut self, samples: &[Sample]) -> Result<(), StudyError> {
        self.frames.clear();
        for (n, sample) in samples.iter().enumerate() {
            let command = self.previous.replace(*sample);
            let Some(command) = command else { continue };
            let tick = self.ticks + n as Tick - 1;
            self.watch(tick, &command);
            for part in 0..SERVO_TICKS {
                let servo_sample = n * SERVO_TICKS + part;
                let Some(lane) = self.lanes.first_mut() else {
                    continue;
                };
                let since = self.measured_from.and_then(|from| tick.checked_sub(from));
                let mut frame = Frame {
                    servo_sample,
                    tick: tick * SERVO_TICKS as Tick + part as Tick,
                    command,
                    commanded_tip_mm: lane.reference(servo_sample, command.position[AxisId::Z]),
                    without_gap: ContourSample::default(),
                    z_counts: self.z.1 >= FIRST_REVERSALS,
                    since: since.map(|ticks| ticks as usize * SERVO_TICKS + part),
                };
                let load = lane.load(servo_sample, frame.ideal_z_mm());
                frame.without_gap = self
                    .tracker
                    .measure(&mut lane.foot, &contour_input(&frame, load))?;
                if frame.measured() {
                    self.reached_mm_s = self.reached_mm_s.max(command.path_speed);
                }
                self.frames.push(frame);
            }
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
        if self.measured_from.is_none()
            && self.reversals.iter().all(|count| *count >= FIRST_REVERSALS)
        {
            self.measured_from = Some(tick + AFTER);
        }
    }

    fn measure(&mut self, variant: usize) -> Result<(), StudyError> {
        let Some((rigid, lanes)) = self.lanes.split_first_mut() else {
            return Ok(());
        };
        let (Some(lane), Some(tally)) = (lanes.get_mut(variant), self.tallies.get_mut(variant))
        else {
            return Ok(());
        };
        let traced = variant + 1 == self.names.len();
        for frame in &self.frames {
            let without = rigid.load(frame.servo_sample, frame.ideal_z_mm());
            let mut load = lane.load(frame.servo_sample, frame.ideal_z_mm());
            if !frame.z_counts {
                load[2] = without[2];
            }
            let error = self
                .tracker
                .measure(&mut lane.foot, &contour_input(frame, load))?;
            let measured = frame.measured();
            if measured {
                tally.contour(caused_mm(
                    [error.error_mm, frame.without_gap.error_mm],
                    [load, without],
                ));
            }
            if let Some(since) = frame.since {
                let time_s =
                    Clock::SERVO.seconds(frame.tick) + Clock::CNC.seconds(SETTLE_TICKS as Tick);
                let half_gap = 0.5
                    * self.physics.gap_rad
                    * self.gap_drift.map_or(1.0, |change| change.at(time_s));
                for axis in 0..AXES.len() {
                    let deviation = load
                        .get(axis)
                        .zip(without.get(axis))
                        .map_or(f64::NAN, |(with, without)| with - without);
                    tally.axis(
                        axis,
                        since,
                        deviation,
                        &lane.sample(axis, frame.servo_sample),
                        half_gap,
                    );
                }
            }
            if let (true, Some(trace)) = (traced, &mut self.trace) {
                let error_um =
                    [error.error_mm, frame.without_gap.error_mm].map(|mm| mm * UM_PER_MM);
                trace(&Traced {
                    tick: frame.tick,
                    error_um,
                    measured,
                    axes: [0, 1].map(|axis| lane.sample(axis, frame.servo_sample)),
                });
            }
        }
        Ok(())
    }

    pub(super) fn finish(self) -> CellResult {
        let um_per_rad = UM_PER_MM / self.motor_rad_per_mm;
        let ticks = self.ticks * SERVO_TICKS as Tick;
        let from = self.measured_from.unwrap_or(self.ticks);
        let measured_s = Clock::CNC
            .seconds(self.ticks.saturating_sub(from))
            .max(Clock::CNC.period_s());
        let limit_rms = (self.limit_squares * self.physics.traverse_s / measured_s).sqrt();
        let figures = |(tally, (name, lane)): (&Tally, (&String, &Lane))| {
            Some(tally.figures(
                name,
                self.tallies.first()?,
                &self.events,
                lane.saturated(ticks),
            ))
        };
        let lanes = self.names.iter().zip(self.lanes.iter().skip(1));
        CellResult {
            cell: self.cell,
            duration_s: round_to(Clock::CNC.seconds(self.ticks), 3),
            measured_from_s: round_to(Clock::CNC.seconds(from), 3),
            samples: self.tallies.first().map_or(0, Tally::samples),
            reached_mm_min: round_to(self.reached_mm_s * 60.0, 3),
            reversals: self.reversals,
            traverse_ms: round_to(self.physics.traverse_s * 1e3, DECIMALS),
            limit_max_um: round_to(self.limit_max_rad * um_per_rad, DECIMALS),
            limit_rms_um: round_to(limit_rms * um_per_rad, DECIMALS),
            floating: round_to(
                Clock::CNC.seconds(self.floating_ticks) / measured_s,
                DECIMALS,
            ),
            encoder_um: round_to(count_um(&self.cell, self.motor_rad_per_mm), DECIMALS),
            methods: self.tallies.iter().zip(lanes).filter_map(figures).collect(),
        }
    }
}

/// A count of the encoder at the slide, um.
fn count_um(cell: &Cell, motor_rad_per_mm: f64) -> f64 {
    match cell.number(ENCODER) as i32 {
        0 => 0.0,
        bits => UM_PER_MM * std::f64::consts::TAU / motor_rad_per_mm / f64::from(1_u32 << bits),
    }
}
