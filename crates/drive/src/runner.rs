//! One axis from setpoints to where its load really is.

use crate::compensator::{Heeded, MethodInfo};
use crate::error::AxisError;
use crate::learned::{Learned, Learning};
use crate::plant::{Known, Plant, PlantInput, PlantState};
use crate::servo::{Servo, ServoState};
use crate::signal::{AxisSample, Correction, MotorSample, Reference, Setpoint};
use crate::twin::Twinned;

pub use crate::plant::DRIFT_MS;

/// What an axis did: appended to by every [`AxisRunner::push`], emptied by the caller.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxisOutput {
    /// Load position at each servo tick, in the axis' unit.
    pub load: Vec<f64>,
    /// Position reference at each servo tick, in the axis' unit.
    pub reference: Vec<f64>,
    /// Number of servo periods in which the current or the voltage was at its limit.
    pub saturated_samples: u64,
    /// Largest magnitude of i_q, A.
    pub peak_current_a: f64,
    /// Everything at each servo tick, if a list is given here.
    pub trace: Option<Vec<AxisSample>>,
    /// The motor alone at each servo tick, if a list is given here.
    pub motor: Option<Vec<MotorSample>>,
    /// What a control watches, at the last servo tick of each command cycle.
    pub monitored: Vec<Monitored>,
    /// Sum of i_d^2 + i_q^2 over the servo ticks of the present command cycle, A2.
    pub(crate) current_squares: f64,
    /// Position and feedback of the last correction, rad.
    pub(crate) correction: f64,
}

/// An axis at the last servo tick of a command cycle, as its control sees it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Monitored {
    /// Position reference, in the axis' unit.
    pub reference: f64,
    /// Motor position from its encoder, at the load's side of the transmission, in the axis' unit.
    pub motor: f64,
    /// What the compensator adds to the position that the loop follows: its position and feedback,
    /// in the axis' unit.
    pub correction: f64,
    /// `i_d^2 + i_q^2`, mean of the servo ticks of the command cycle, A2: at the ticks, not of the
    /// mean current between them, which would hide a current loop that swings.
    pub current_squared: f64,
    /// [`AxisOutput::saturated_samples`] up to the end of the cycle.
    pub saturated_samples: u64,
    /// [`AxisOutput::peak_current_a`] up to the end of the cycle.
    pub peak_current_a: f64,
}

impl AxisOutput {
    /// Empty, without or with a trace.
    pub fn new(with_trace: bool) -> AxisOutput {
        AxisOutput {
            trace: with_trace.then(Vec::new),
            ..AxisOutput::default()
        }
    }

    /// Empty, with the signals of the motor.
    pub fn with_motor() -> AxisOutput {
        AxisOutput {
            motor: Some(Vec::new()),
            ..AxisOutput::default()
        }
    }

    /// Forgets the samples and keeps the memory; count and peak go on from those of another output.
    pub fn go_on_from(&mut self, before: &AxisOutput) {
        self.clear();
        self.saturated_samples = before.saturated_samples;
        self.peak_current_a = before.peak_current_a;
        self.current_squares = before.current_squares;
        self.correction = before.correction;
    }

    /// Forgets the samples and keeps the memory; count and peak go on.
    pub fn clear(&mut self) {
        self.load.clear();
        self.reference.clear();
        self.monitored.clear();
        if let Some(trace) = &mut self.trace {
            trace.clear();
        }
        if let Some(motor) = &mut self.motor {
            motor.clear();
        }
    }
}

/// An axis with whatever compensator, driven by chunks of setpoints.
pub trait AxisRunner: Send {
    /// Takes one setpoint per command cycle and appends [`AxisRunner::servo_ticks`] samples for
    /// each.
    ///
    /// Sample k (counted from the start) shows the axis at servo tick k, before that tick's command
    /// has had any effect; the reference in it belongs to the setpoint time
    /// `k * servo cycle - delay`, setpoint n standing at n command cycles. Sample 0 is the start
    /// itself.
    ///
    /// # Errors
    /// A setpoint that is not finite or incomplete, or a force on the load beyond 1e7. Those before
    /// it have been taken.
    fn push(&mut self, setpoints: &[Setpoint], out: &mut AxisOutput) -> Result<(), AxisError>;

    /// Command cycles by which the reference lags behind the setpoints.
    fn delay_ticks(&self) -> u32;

    /// Servo ticks in a command cycle.
    fn servo_ticks(&self) -> usize;

    /// The compensator.
    fn info(&self) -> &'static MethodInfo;

    /// What the compensator has learned of the axis; `None` where it learns nothing, and while it
    /// knows nothing.
    fn learned(&self) -> Option<Learned>;

    /// What the compensator knows now, for traces; `None` where it learns nothing.
    fn learning(&self) -> Option<Learning>;

    /// The plant's present state, at the motor's shaft.
    fn plant(&self) -> &PlantState;

    /// A copy that goes on from here on its own.
    fn boxed_clone(&self) -> Box<dyn AxisRunner>;

    /// First part of what [`AxisRunner::push`] does with a setpoint: takes it. For a batch, which
    /// steps several axes side by side.
    ///
    /// # Errors
    /// As for `push`; the axis is then as before.
    fn begin_setpoint(&mut self, setpoint: &Setpoint) -> Result<(), AxisError>;

    /// Then, for each of its [`AxisRunner::servo_ticks`]: measures, compensates, sets the current
    /// command, appends a sample.
    fn begin_tick(&mut self, index: u32, out: &mut AxisOutput);

    /// What the compensator does at such a tick with what the drive has seen, up to where its own
    /// model of the axis is stepped, and that step; nothing if it has none. For a batch that measures and
    /// sets the command itself.
    fn begin_compensation<'a>(
        &'a mut self,
        index: u32,
        seen: &Seen,
        step: &mut Option<TwinStep<'a>>,
    );

    /// And what it answers to the tick that was begun, once its model is stepped.
    fn finish_compensation(&mut self) -> Correction;

    /// [`crate::Compensator::HEEDS_OTHERS`] of its compensator.
    fn heeds_others(&self) -> bool;

    /// [`crate::Compensator::readiness`] of its compensator.
    fn readiness(&self) -> Option<f64>;

    /// [`crate::Compensator::heed`] of its compensator.
    fn heed(&mut self, heeded: Heeded);

    /// [`crate::Compensator::foreseen`] of its compensator.
    fn foreseen(&self) -> &[Option<[f64; 2]>];

    /// Then its [`CurrentLoop::periods`] periods of the current loop.
    fn current_loop(&mut self) -> CurrentLoop<'_>;
}

/// A compensator's model of its axis with the references of the tick that it is to be stepped by.
#[derive(Debug)]
pub struct TwinStep<'a> {
    pub(crate) twin: Twinned<'a>,
    pub(crate) reference: &'a Reference,
    pub(crate) next: &'a Reference,
}

impl TwinStep<'_> {
    /// Steps it by itself.
    pub fn run(self) {
        self.twin.step(self.reference, self.next);
    }
}

/// What the drive has seen at a servo tick: rad, rad/s, A.
#[derive(Clone, Copy, Debug)]
pub struct Seen {
    /// Motor position from its encoder.
    pub motor_position: f64,
    /// Motor speed as the drive computes it.
    pub motor_velocity: f64,
    /// i_q.
    pub current: f64,
    /// Its mean over the last servo period.
    pub mean_current: f64,
    /// Whether a limit was met in it.
    pub saturated: bool,
    /// Where the load is, for a scale to read.
    pub load_position: f64,
}

impl AxisSample {
    /// A plant and its state, with what a compensator answers.
    #[inline(always)]
    pub(crate) fn of(
        reference: Reference,
        plant: &Plant,
        state: &PlantState,
        correction: &Correction,
    ) -> AxisSample {
        AxisSample {
            reference,
            motor_position: state.motor_position(),
            motor_velocity: state.motor_velocity,
            load_position: state.load_position,
            load_velocity: state.load_velocity,
            current: state.current_q,
            torque: plant.params().torque_constant_nm_per_a * state.current_q,
            shaft_torque: plant.torque_on_load(state),
            engagement: state.engagement(),
            gap_angle_estimate: correction.gap_angle_estimate,
            inertia_estimate: correction.inertia_estimate,
            engagement_estimate: correction.engagement_estimate,
            stiffness_estimate: correction.stiffness_estimate,
            damping_estimate: correction.damping_estimate,
        }
    }
}

impl MotorSample {
    /// A plant's motor.
    pub(crate) fn of(plant: &Plant, state: &PlantState) -> MotorSample {
        MotorSample {
            position: state.motor_position(),
            current: state.current_q,
            torque: plant.params().torque_constant_nm_per_a * state.current_q,
            engagement: state.engagement(),
        }
    }
}

/// What runs at the rate of the current loop: the drive's fast half and the plant.
#[derive(Debug)]
pub struct CurrentLoop<'a> {
    pub(crate) servo: &'a Servo,
    pub(crate) plant: &'a Plant,
    pub(crate) servo_state: &'a mut ServoState,
    pub(crate) plant_state: &'a mut PlantState,
    pub(crate) load_torque: f64,
    /// Whether the plant's parameters change from setpoint to setpoint.
    pub(crate) drifting: bool,
    /// Whether the compensator never does anything.
    pub(crate) passive: bool,
    /// What a step of the plant in its mode asks for, with the count of events at which it was that mode.
    pub(crate) known: &'a mut Option<(u64, Known)>,
    /// References at the servo ticks of the setpoint taken last, and at the next one's first.
    pub(crate) references: &'a [Reference],
    pub(crate) units_per_motor_rad: f64,
}

impl CurrentLoop<'_> {
    /// Periods in a servo tick.
    pub fn periods(&self) -> u32 {
        self.servo.current_steps()
    }

    /// One period; raises the peak of the current, A, to what it reaches.
    #[inline(always)]
    pub fn period(&mut self, peak_current_a: &mut f64) {
        let voltages = self.servo.voltage(self.servo_state, self.plant_state);
        // every change of the mode is an event
        let events = self.plant_state.events;
        let known = match self.known {
            Some((since, known)) if *since == events => known,
            _ => {
                let known = self.plant.known(self.plant_state.mode);
                &self.known.insert((events, known)).1
            }
        };
        self.plant.step_knowing(
            known,
            self.plant_state,
            &PlantInput {
                load_torque: self.load_torque,
                ..voltages
            },
        );
        *peak_current_a = peak_current_a.max(self.plant_state.current_q.abs());
    }

    /// The end of a servo tick: counts it if the drive was at a limit.
    #[inline]
    pub fn finish(&self, out: &mut AxisOutput) {
        out.saturated_samples += u64::from(self.servo_state.saturated);
    }

    /// The end of a command cycle of so many servo ticks: appends what a control watches.
    #[inline]
    pub(crate) fn monitor(&self, ticks: u32, peak_current_a: f64, out: &mut AxisOutput) {
        let seen = &self.servo_state.velocity;
        out.monitored.push(Monitored {
            reference: seen.reference * self.units_per_motor_rad,
            motor: seen.position * self.units_per_motor_rad,
            correction: out.correction * self.units_per_motor_rad,
            current_squared: out.current_squares / f64::from(ticks),
            saturated_samples: out.saturated_samples,
            peak_current_a,
        });
        out.current_squares = 0.0;
    }
}
