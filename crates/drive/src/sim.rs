//! An axis with a compensator: the parts of a servo tick in their order.

use crate::compensator::{Compensator, Heeded, MethodInfo};
use crate::config::AxisConfig;
use crate::error::AxisError;
use crate::learned::{Learned, Learning};
use crate::plant::{Drifting, Known, Plant, PlantParams, PlantStart, PlantState};
use crate::reference::{Spline, SplineState};
use crate::runner::{AxisOutput, AxisRunner, CurrentLoop, Seen, TwinStep};
use crate::servo::{Servo, ServoState};
use crate::signal::{
    AxisSample, BlockMotion, Correction, MotorSample, Reference, Setpoint, Signals,
};
use crate::start::AxisStart;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// The largest force on the load that a setpoint may bring, N or N m.
const LARGEST_LOAD_FORCE: f64 = 1e7;

/// All that an axis carries from tick to tick.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AxisState<S> {
    /// The reference.
    pub spline: SplineState,
    /// The drive.
    pub servo: ServoState,
    /// The plant.
    pub plant: PlantState,
    /// The compensator.
    pub compensator: S,
}

/// An axis with a compensator: the description shared, the state its own.
#[derive(Debug)]
pub struct AxisSim<C: Compensator> {
    model: Arc<Model<C>>,
    state: AxisState<C::State>,
    drifting: Option<Drifting>,
    setpoint: Taken,
    /// What a step of the plant in its mode asks for, with the count of events at which it was that mode.
    known: Option<(u64, Known)>,
}

/// What follows from the setpoint taken last.
#[derive(Clone, Debug, Default)]
struct Taken {
    /// References at its servo ticks, and at the next setpoint's first.
    references: Vec<Reference>,
    /// Torque of its force on the load, N m at the motor.
    load_torque: f64,
    /// Its block.
    block: Option<BlockMotion>,
    /// What the compensator saw at the tick that a batch has begun, if it has.
    signals: Signals,
    begun: bool,
}

/// The reference at a servo tick, and the next one.
#[inline(always)]
fn at(references: &[Reference], index: u32) -> [&Reference; 2] {
    let from = index as usize;
    match references.get(from..from + 2) {
        Some([now, next]) => [now, next],
        // there is one more than ticks
        _ => [&Reference::ZERO; 2],
    }
}

impl<C: Compensator> Clone for AxisSim<C> {
    fn clone(&self) -> Self {
        let mut copy = AxisSim {
            model: Arc::clone(&self.model),
            state: self.state.clone(),
            drifting: self.drifting.clone(),
            setpoint: self.setpoint.clone(),
            known: None,
        };
        copy.make_room();
        copy
    }
}

impl<C: Compensator> AxisSim<C> {
    /// Standing still with the motor at a position in the axis' unit. The description has to be
    /// checked before.
    pub fn new<S>(config: &AxisConfig<S>, compensator: C, start_position: f64) -> AxisSim<C> {
        AxisSim::begin(config, compensator, &AxisStart::at(start_position))
    }

    /// Beginning as told. The description has to be checked before, and the start against it.
    pub fn begin<S>(config: &AxisConfig<S>, compensator: C, start: &AxisStart) -> AxisSim<C> {
        let factor = config.transmission.motor_rad_per_unit();
        let start_rad = start.position * factor;
        let mut params = PlantParams::new(config);
        let (spline, mut servo) = (Spline::new(config), Servo::new(config));
        if start.drive_off {
            // an open winding: the back-EMF drives no current, and the drive sets no voltage
            params.back_emf_v_s_per_rad = 0.0;
            servo = servo.switched_off();
        }
        // the plant first: the drive starts with the current that holds it
        let rest = PlantState::at_rest(&params, start_rad, config.start_in_gap.0);
        let plant = if *start == AxisStart::at(start.position) {
            rest
        } else {
            rest.set_going(
                &params,
                &PlantStart {
                    motor_velocity: start.motor_velocity * factor,
                    load_velocity: start.load_velocity * factor,
                    wind_up: start.wind_up.map(|wind_up| wind_up * factor),
                    drive_off: start.drive_off,
                },
            )
        };
        let state = AxisState {
            spline: spline.initial(start.position),
            servo: servo.initial(&plant, start_rad),
            plant,
            compensator: compensator.initial(start_rad),
        };
        // a method that does not declare a scale is not shown one
        let has_scale = compensator.info().knows.load_scale;
        let plant = Plant::new(&params);
        let drifting = Drifting::new(&config.drift, &config.cycles, &plant);
        let (units_per_motor_rad, load_per_motor_rad) =
            (1.0 / factor, config.transmission.load_per_motor_rad());
        let servo_ticks = config.cycles.servo_ticks() as u32;
        let model = Model {
            spline,
            servo_ticks,
            servo,
            plant,
            compensator,
            units_per_motor_rad,
            load_per_motor_rad,
            has_scale,
        };
        let mut axis = AxisSim {
            model: Arc::new(model),
            state,
            drifting,
            setpoint: Taken {
                references: vec![Reference::default(); servo_ticks as usize + 1],
                ..Taken::default()
            },
            known: None,
        };
        axis.make_room();
        axis
    }

    /// Room for all that a tick keeps: a step of a real-time thread allocates nothing.
    fn make_room(&mut self) {
        self.model
            .compensator
            .make_room(&mut self.state.compensator);
    }

    /// The present state, to be kept.
    pub fn state(&self) -> &AxisState<C::State> {
        &self.state
    }

    /// Goes on from a state kept earlier.
    pub fn restore(&mut self, state: AxisState<C::State>) {
        self.state = state;
        self.known = None;
        self.make_room();
    }

    #[inline]
    fn tick(&mut self, index: u32, out: &mut AxisOutput) {
        let (model, state) = (&*self.model, &mut self.state);
        let references = at(&self.setpoint.references, index);
        let [reference, next_reference] = references;
        // the encoder first: everything in the tick sees the same instant
        let measured = model.servo.measure(&mut state.servo, &state.plant);
        let seen = Seen {
            motor_position: measured.position,
            motor_velocity: measured.velocity,
            current: state.plant.current_q,
            mean_current: model.servo.mean_current(&mut state.servo, &state.plant),
            saturated: state.servo.saturated,
            load_position: state.plant.load_position,
        };
        let [direct, quadrature] = [state.plant.current_d, state.plant.current_q];
        out.current_squares += direct * direct + quadrature * quadrature;
        let mut signals = Signals::default();
        model.show(&mut signals, references, self.setpoint.block, &seen);
        let correction = model.correct(&mut state.compensator, &signals);
        out.correction = correction.position + correction.feedback;
        // the sample shows the axis before this tick's command has any effect
        out.load
            .push(state.plant.load_position * model.units_per_motor_rad);
        out.reference
            .push(reference.position * model.units_per_motor_rad);
        let plant = || self.drifting.as_ref().map_or(&model.plant, Drifting::plant);
        if let Some(trace) = &mut out.trace {
            trace.push(AxisSample::of(
                *reference,
                plant(),
                &state.plant,
                &correction,
            ));
        }
        if let Some(motor) = &mut out.motor {
            motor.push(MotorSample::of(plant(), &state.plant));
        }
        // last: it acts in the periods that follow
        model.servo.command(
            &mut state.servo,
            reference,
            next_reference,
            &measured,
            &correction,
        );
    }

    #[inline]
    fn fast_half(&mut self) -> CurrentLoop<'_> {
        CurrentLoop {
            servo: &self.model.servo,
            // a drifting axis steps the plant of the present setpoint
            plant: self
                .drifting
                .as_ref()
                .map_or(&self.model.plant, Drifting::plant),
            servo_state: &mut self.state.servo,
            plant_state: &mut self.state.plant,
            load_torque: self.setpoint.load_torque,
            drifting: self.drifting.is_some(),
            passive: C::PASSIVE,
            known: &mut self.known,
            references: &self.setpoint.references,
            units_per_motor_rad: self.model.units_per_motor_rad,
        }
    }
}

fn load_force(tick: u64, setpoint: &Setpoint) -> Result<f64, AxisError> {
    let value = setpoint.load_force.unwrap_or(0.0);
    if value.abs() <= LARGEST_LOAD_FORCE {
        Ok(value)
    } else {
        Err(AxisError::LoadForce {
            tick,
            value,
            highest: LARGEST_LOAD_FORCE,
        })
    }
}

impl<C: Compensator> AxisRunner for AxisSim<C> {
    fn push(&mut self, setpoints: &[Setpoint], out: &mut AxisOutput) -> Result<(), AxisError> {
        for setpoint in setpoints {
            // the same parts, one axis alone, that a batch calls for several side by side
            self.begin_setpoint(setpoint)?;
            for index in 0..self.model.servo_ticks {
                self.tick(index, out);
                let mut fast = self.fast_half();
                for _ in 0..fast.periods() {
                    fast.period(&mut out.peak_current_a);
                }
                fast.finish(out);
            }
            let (ticks, peak_current_a) = (self.model.servo_ticks, out.peak_current_a);
            self.fast_half().monitor(ticks, peak_current_a, out);
        }
        Ok(())
    }

    fn begin_setpoint(&mut self, setpoint: &Setpoint) -> Result<(), AxisError> {
        // refuse before anything has changed
        let tick = self.state.spline.ticks();
        let load_torque = load_force(tick, setpoint)? * self.model.load_per_motor_rad;
        self.model.spline.push(&mut self.state.spline, setpoint)?;
        let (spline, state) = (&self.model.spline, &self.state.spline);
        self.setpoint.load_torque = load_torque;
        self.setpoint.block = setpoint.block;
        // one more than the ticks: feed-forward looks a tick ahead
        let count = self.model.servo_ticks as usize + 1;
        let references = &mut self.setpoint.references;
        references.resize(count, Reference::default());
        spline.fill(state, references);
        // after the spline, which may refuse the setpoint
        if let Some(drifting) = &mut self.drifting {
            drifting.advance(tick, &mut self.state.plant);
            // another plant
            self.known = None;
        }
        Ok(())
    }

    fn begin_tick(&mut self, index: u32, out: &mut AxisOutput) {
        self.tick(index, out);
    }

    fn heeds_others(&self) -> bool {
        C::HEEDS_OTHERS
    }

    fn readiness(&self) -> Option<f64> {
        self.model.compensator.readiness(&self.state.compensator)
    }

    fn heed(&mut self, heeded: Heeded) {
        self.model
            .compensator
            .heed(&mut self.state.compensator, heeded);
    }

    fn foreseen(&self) -> &[Option<[f64; 2]>] {
        self.model.compensator.foreseen(&self.state.compensator)
    }

    fn begin_compensation<'a>(
        &'a mut self,
        index: u32,
        seen: &Seen,
        step: &mut Option<TwinStep<'a>>,
    ) {
        let (model, block) = (&*self.model, self.setpoint.block);
        let references = at(&self.setpoint.references, index);
        let signals = &mut self.setpoint.signals;
        model.show(signals, references, block, seen);
        self.setpoint.begun = true;
        *step = model
            .compensator
            .begin(&mut self.state.compensator, signals)
            .map(|twin| TwinStep {
                twin,
                reference: &signals.reference,
                next: &signals.next_reference,
            });
    }

    fn finish_compensation(&mut self) -> Correction {
        if !self.setpoint.begun {
            return Correction::NONE;
        }
        let signals = &self.setpoint.signals;
        usable(
            self.model
                .compensator
                .finish(&mut self.state.compensator, signals),
        )
    }

    fn current_loop(&mut self) -> CurrentLoop<'_> {
        self.fast_half()
    }

    fn delay_ticks(&self) -> u32 {
        self.model.spline.delay_ticks()
    }

    fn servo_ticks(&self) -> usize {
        self.model.servo_ticks as usize
    }

    fn info(&self) -> &'static MethodInfo {
        self.model.compensator.info()
    }

    fn learned(&self) -> Option<Learned> {
        self.model.compensator.learned(&self.state.compensator)
    }

    fn learning(&self) -> Option<Learning> {
        self.model.compensator.learning(&self.state.compensator)
    }

    fn plant(&self) -> &PlantState {
        &self.state.plant
    }

    fn boxed_clone(&self) -> Box<dyn AxisRunner> {
        Box::new(self.clone())
    }
}

/// Description of an axis with its compensator.
#[derive(Debug)]
struct Model<C> {
    spline: Spline,
    servo_ticks: u32,
    servo: Servo,
    plant: Plant,
    compensator: C,
    units_per_motor_rad: f64,
    load_per_motor_rad: f64,
    has_scale: bool,
}

impl<C: Compensator> Model<C> {
    /// Shows a compensator what it sees. Written field by field to where it is read: a copy of all of it
    /// in wider pieces than it was written in waits until that is in memory.
    #[inline(always)]
    fn show(
        &self,
        signals: &mut Signals,
        [reference, next_reference]: [&Reference; 2],
        block: Option<BlockMotion>,
        seen: &Seen,
    ) {
        signals.block = block;
        signals.reference = *reference;
        signals.next_reference = *next_reference;
        signals.motor_position = seen.motor_position;
        signals.motor_velocity = seen.motor_velocity;
        signals.current = seen.current;
        signals.mean_current = seen.mean_current;
        signals.saturated = seen.saturated;
        signals.load_position = if self.has_scale {
            Some(self.servo.read_scale(seen.load_position))
        } else {
            None
        };
    }

    /// What the compensator answers; without its output if a drive could not act on that.
    #[inline]
    fn correct(&self, state: &mut C::State, signals: &Signals) -> Correction {
        usable(self.compensator.step(state, signals))
    }
}

#[inline]
fn usable(wanted: Correction) -> Correction {
    if wanted.is_usable() {
        wanted
    } else {
        wanted.without_output()
    }
}
