//! One axis alone, a command cycle or a servo tick after the other, for real-time threads, too.

use crate::border::{call, list, out, room, text};
use crate::compensator::{LmCompensator, Own};
use crate::failure::{Brief, Failure, LmStatus, Reason};
use crate::handle::{change, free, insert, look, opaque};
use crate::machine::{LmMachine, drive_of, wrong_size};
use lostmotion::drive::{AxisError, AxisOutput, AxisRunner, Setpoint};
use lostmotion::methods::{AxisConfig, MethodId, UnknownMethod, alone, build_runner, run_with};
use lostmotion::report::csv::AxisScales;
use lostmotion::sim::machine::{axis_from_toml, axis_preset};
use std::ffi::c_char;
use std::mem::MaybeUninit;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

/// An axis with a compensator: drive, motor, shaft with a gap, load.
#[derive(Debug)]
pub struct LmAxis(());

opaque!(LmAxis(5, "axis") is Alone);

/// `LmSetpoint.velocity` is given.
pub const LM_SETPOINT_VELOCITY: u32 = 1;
/// `LmSetpoint.acceleration` is given.
pub const LM_SETPOINT_ACCELERATION: u32 = 2;
/// `LmSetpoint.load_force` is given.
pub const LM_SETPOINT_LOAD_FORCE: u32 = 4;

/// A command of the control, one each command cycle, in the unit of the axis (mm, deg or rad).
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmSetpoint {
    /// Position.
    pub position: f64,
    /// Velocity per s, where `given` has `LM_SETPOINT_VELOCITY`.
    pub velocity: f64,
    /// Acceleration per s2, where `given` has `LM_SETPOINT_ACCELERATION`.
    pub acceleration: f64,
    /// Force on the load against the positive direction, N, or N m at a load that turns, where
    /// `given` has `LM_SETPOINT_LOAD_FORCE`.
    pub load_force: f64,
    /// Which of these are given: a sum of `LM_SETPOINT_...`.
    pub given: u32,
}

/// An axis at a servo tick: positions in its unit at the load, current, torque and estimates at the
/// motor. The columns of the command's axis traces.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmAxisSample {
    /// Time since the start, s.
    pub time_s: f64,
    /// Reference of the servo.
    pub reference: f64,
    /// Its velocity per s.
    pub reference_velocity: f64,
    /// Its acceleration per s2.
    pub reference_acceleration: f64,
    /// Motor, at the load's side of the transmission.
    pub motor: f64,
    /// Its velocity per s.
    pub motor_velocity: f64,
    /// Load.
    pub load: f64,
    /// Its velocity per s.
    pub load_velocity: f64,
    /// Torque-forming current, A.
    pub current_a: f64,
    /// Torque of the motor, N m.
    pub torque_nm: f64,
    /// What the shaft does to the load, N, or N m at a load that turns.
    pub shaft_force: f64,
    /// The compensator's estimate of motor minus load; NaN without one.
    pub gap_estimate: f64,
    /// Its estimate of the inertia that the motor carries, kg m2; NaN without one.
    pub inertia_estimate_kgm2: f64,
    /// Its estimate of the shaft's stiffness, N m/rad; NaN without one.
    pub stiffness_estimate_nm_per_rad: f64,
    /// Its estimate of the shaft's damping, N m s/rad; NaN without one.
    pub damping_estimate_nm_s_per_rad: f64,
    /// Flank of the gap in contact: -1, 0 or 1.
    pub engagement: i32,
    /// The compensator's estimate of it.
    pub engagement_estimate: i32,
}

/// What is fixed of an axis.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmAxisInfo {
    /// Unit of positions: "mm", "deg" or "rad".
    pub unit: *const c_char,
    /// Servo ticks in a command cycle: samples that each setpoint makes.
    pub servo_ticks: usize,
    /// Command cycles by which the reference lags behind the setpoints.
    pub delay_ticks: u32,
    /// Time between two servo ticks, s.
    pub servo_period_s: f64,
    /// Time between two setpoints, s.
    pub command_period_s: f64,
    /// Total gap, in the unit of the axis.
    pub gap: f64,
}

/// An axis: what is fixed, and what changes from tick to tick.
pub struct Alone {
    config: AxisConfig,
    scales: AxisScales,
    /// The lock is never taken: whoever steps has the axis to himself.
    stepping: Mutex<Stepping>,
    /// Whether a compensator of the caller's has failed.
    failed: Arc<AtomicBool>,
}

struct Stepping {
    runner: Box<dyn AxisRunner>,
    out: AxisOutput,
    tick: u64,
    /// Servo ticks of the present setpoint that have been stepped.
    stepped: usize,
}

impl Clone for Stepping {
    fn clone(&self) -> Stepping {
        Stepping {
            runner: self.runner.boxed_clone(),
            out: roomy(&self.out),
            tick: self.tick,
            stepped: self.stepped,
        }
    }
}

/// An output with room for a servo tick, whose counts go on.
fn roomy(before: &AxisOutput) -> AxisOutput {
    let mut out = AxisOutput::new(true);
    out.go_on_from(before);
    out.load.reserve(1);
    out.reference.reserve(1);
    if let Some(trace) = &mut out.trace {
        trace.reserve(1);
    }
    out
}

fn unfit(error: &AxisError) -> Failure {
    Failure::method("axis", error.to_string())
}

impl Alone {
    fn new(
        mut config: AxisConfig,
        make: impl FnOnce(&AxisConfig) -> Result<Box<dyn AxisRunner>, Failure>,
        failed: Arc<AtomicBool>,
    ) -> Result<Alone, Failure> {
        // the estimator of the shaft gathers stretches of the motion in lists
        config.compensation.estimate_shaft = false;
        let runner = make(&config)?;
        if failed.load(Ordering::Relaxed) {
            return Err(Failure::brief("compensator", Reason::Compensator));
        }
        let units_per_rad = 1.0 / config.transmission.motor_rad_per_unit();
        Ok(Alone {
            scales: AxisScales::new(config.unit(), units_per_rad),
            stepping: Mutex::new(Stepping {
                out: roomy(&AxisOutput::default()),
                tick: 0,
                stepped: runner.servo_ticks(),
                runner,
            }),
            config,
            failed,
        })
    }

    /// Takes the next setpoint.
    fn setpoint(&mut self, given: &LmSetpoint) -> Result<(), Failure> {
        let told = |bit: u32, value: f64| (given.given & bit != 0).then_some(value);
        let known = LM_SETPOINT_VELOCITY | LM_SETPOINT_ACCELERATION | LM_SETPOINT_LOAD_FORCE;
        if given.given & !known != 0 {
            let given = given.given as usize;
            return Err(wrong_size("setpoint.given", given, known as usize));
        }
        let setpoint = Setpoint {
            position: given.position,
            velocity: told(LM_SETPOINT_VELOCITY, given.velocity),
            acceleration: told(LM_SETPOINT_ACCELERATION, given.acceleration),
            load_force: told(LM_SETPOINT_LOAD_FORCE, given.load_force),
            block: None,
        };
        let stepping = self
            .stepping
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner);
        let left = stepping.runner.servo_ticks() - stepping.stepped;
        if left > 0 {
            return Err(Failure::brief("axis", Reason::TicksLeft(left)));
        }
        if self.failed.load(Ordering::Relaxed) {
            return Err(Failure::brief("compensator", Reason::Compensator));
        }
        stepping
            .runner
            .begin_setpoint(&setpoint)
            .map_err(|error| Failure::Brief(Brief::axis(&error)))?;
        stepping.stepped = 0;
        Ok(())
    }

    /// Steps a servo tick.
    fn tick(&mut self) -> Result<LmAxisSample, Failure> {
        let stepping = self
            .stepping
            .get_mut()
            .unwrap_or_else(PoisonError::into_inner);
        let Stepping {
            runner,
            out,
            tick,
            stepped,
        } = stepping;
        if *stepped >= runner.servo_ticks() {
            return Err(Failure::brief("axis", Reason::NoSetpoint));
        }
        // As the runner's own `push`, a tick at a time.
        runner.begin_tick(*stepped as u32, out);
        let mut fast = runner.current_loop();
        for _ in 0..fast.periods() {
            fast.period(&mut out.peak_current_a);
        }
        fast.finish(out);
        let sample = out.trace.iter().flatten().next_back().copied();
        out.clear();
        let row = self.scales.row(&sample.unwrap_or_default());
        let clock = self.config.cycles.servo();
        let sample = LmAxisSample {
            time_s: tick.saturating_mul(clock.period_ns()) as f64 / 1e9,
            reference: row.reference,
            reference_velocity: row.reference_velocity,
            reference_acceleration: row.reference_acceleration,
            motor: row.motor,
            motor_velocity: row.motor_velocity,
            load: row.load,
            load_velocity: row.load_velocity,
            current_a: row.current_a,
            torque_nm: row.torque_nm,
            shaft_force: row.shaft_force,
            gap_estimate: row.gap_estimate,
            inertia_estimate_kgm2: row.inertia_estimate_kgm2,
            stiffness_estimate_nm_per_rad: row.stiffness_estimate_nm_per_rad,
            damping_estimate_nm_s_per_rad: row.damping_estimate_nm_s_per_rad,
            engagement: row.engagement.into(),
            engagement_estimate: row.engagement_estimate.into(),
        };
        *tick += 1;
        *stepped += 1;
        if self.failed.load(Ordering::Relaxed) {
            return Err(Failure::brief("compensator", Reason::Compensator));
        }
        Ok(sample)
    }

    /// Takes a setpoint and fills the samples of its ticks.
    fn step(
        &mut self,
        setpoint: &LmSetpoint,
        samples: &mut [MaybeUninit<LmAxisSample>],
    ) -> Result<(), Failure> {
        self.setpoint(setpoint)?;
        for sample in samples {
            sample.write(self.tick()?);
        }
        Ok(())
    }

    fn servo_ticks(&mut self) -> usize {
        let stepping = self.stepping.get_mut();
        let stepping = stepping.unwrap_or_else(PoisonError::into_inner);
        stepping.runner.servo_ticks()
    }
}

fn with_method(
    config: AxisConfig,
    method: &str,
    start: f64,
    differences: bool,
) -> Result<Alone, Failure> {
    let method: MethodId = method
        .parse()
        .map_err(|error: UnknownMethod| Failure::method("unknown-method", error.to_string()))?;
    let make =
        |config: &AxisConfig| build_runner(config, method, start).map_err(|error| unfit(&error));
    Alone::new(alone(config, differences), make, Arc::default())
}

/// An axis of a machine with a registered method ("none", "fixed", "adaptive", ..), standing still at
/// `start` in its unit. With `differences` positions alone are enough: velocity and acceleration are
/// made from them; without it the drive interpolates by its own law, which may need both.
///
/// All memory that stepping may ever need is taken here: a few kB; 320 kB for "adaptive"; 45 bytes for each
/// ms of its `memory_s` for "iterative-learning", 2.7 MB for the usual 60 s. When that is full the strokes
/// that were not used for the longest time are forgotten.
///
/// Threads: any. Real time: no; what comes after it is.
///
/// # Safety
/// `drive` and `method` are null or end with a zero; `axis` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_axis_new(
    machine: *const LmMachine,
    drive: *const c_char,
    method: *const c_char,
    start: f64,
    differences: bool,
    axis: *mut *mut LmAxis,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(axis, "axis") }?;
        // SAFETY: the caller's promise.
        let drive = unsafe { text(drive, "drive") }?;
        // SAFETY: the caller's promise.
        let method = unsafe { text(method, "method") }?;
        let config = look(machine, |machine| drive_of(machine, drive))?;
        room.write(insert(with_method(config, method, start, differences)?)?);
        Ok(())
    })
}

/// As `lm_axis_new`, of a description alone: the name of one that comes with the library ("paper",
/// "vmc3:x"), or the text of an axis file.
///
/// Threads: any. Real time: no; what comes after it is.
///
/// # Safety
/// `description` and `method` are null or end with a zero; `axis` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_axis_from_description(
    description: *const c_char,
    method: *const c_char,
    start: f64,
    differences: bool,
    axis: *mut *mut LmAxis,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(axis, "axis") }?;
        // SAFETY: the caller's promise.
        let described = unsafe { text(description, "description") }?;
        // SAFETY: the caller's promise.
        let method = unsafe { text(method, "method") }?;
        let config = if described.contains('\n') {
            axis_from_toml("axis.toml", described)?
        } else {
            axis_preset(described).ok_or_else(|| {
                let hint = "for example \"paper\" or \"vmc3:x\"";
                Failure::option(format!("there is no axis \"{described}\""), hint)
            })?
        };
        room.write(insert(with_method(config, method, start, differences)?)?);
        Ok(())
    })
}

/// As `lm_axis_new`, with a compensator of the caller's own. It is stepped by whoever steps the axis,
/// and is as fit for real time as its `step` is.
///
/// Threads: any. Real time: no; what comes after it is.
///
/// # Safety
/// `drive` is null or ends with a zero; `compensator` is null or as `LmCompensator` says; `axis` is
/// null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_axis_with_compensator(
    machine: *const LmMachine,
    drive: *const c_char,
    compensator: *const LmCompensator,
    start: f64,
    differences: bool,
    axis: *mut *mut LmAxis,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(axis, "axis") }?;
        // SAFETY: the caller's promise.
        let drive = unsafe { text(drive, "drive") }?;
        // SAFETY: the caller's promise.
        let own = unsafe { Own::of(compensator) }?;
        let config = look(machine, |machine| drive_of(machine, drive))?;
        let make = |config: &AxisConfig| {
            let made = run_with(config, own.for_axis(config), start);
            made.map_err(|error| unfit(&error))
        };
        let failed = Arc::clone(&own.failed);
        room.write(insert(Alone::new(
            alone(config, differences),
            make,
            failed,
        )?)?);
        Ok(())
    })
}

/// What is fixed of an axis.
///
/// Threads: one at a time. Real time: yes.
///
/// # Safety
/// `info` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_axis_info(axis: *mut LmAxis, info: *mut LmAxisInfo) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(info, "info") }?;
        room.write(change(axis, |axis| {
            let stepping = axis.stepping.get_mut();
            let stepping = stepping.unwrap_or_else(PoisonError::into_inner);
            let cycles = &axis.config.cycles;
            Ok(LmAxisInfo {
                unit: match axis.config.unit().symbol() {
                    "mm" => c"mm".as_ptr(),
                    "deg" => c"deg".as_ptr(),
                    _ => c"rad".as_ptr(),
                },
                servo_ticks: stepping.runner.servo_ticks(),
                delay_ticks: stepping.runner.delay_ticks(),
                servo_period_s: cycles.servo().period_s(),
                command_period_s: cycles.command().period_s(),
                gap: axis.config.gap_in_unit(),
            })
        })?);
        Ok(())
    })
}

/// Takes the setpoint of a command cycle and steps its servo ticks: `samples` has room for `count`,
/// which is `LmAxisInfo.servo_ticks`. Sample k shows the axis before that tick's command acts.
///
/// A setpoint that is refused leaves the axis as it was.
///
/// Threads: one at a time. Real time: yes.
///
/// # Safety
/// `setpoint` is null or a setpoint; `samples` is null or has room for `count`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_axis_step(
    axis: *mut LmAxis,
    setpoint: *const LmSetpoint,
    samples: *mut LmAxisSample,
    count: usize,
) -> LmStatus {
    // SAFETY: the caller's promise is the same.
    unsafe { lm_axis_push(axis, setpoint, 1, samples, count) }
}

/// Takes `count` setpoints, one a command cycle, and steps their servo ticks: `samples` has room for
/// `sample_count`, which is `count` times `LmAxisInfo.servo_ticks`.
///
/// Setpoints before a refused one have been taken, and their samples are there.
///
/// Threads: one at a time. Real time: yes.
///
/// # Safety
/// `setpoints` is null or has `count`; `samples` is null or has room for `sample_count`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_axis_push(
    axis: *mut LmAxis,
    setpoints: *const LmSetpoint,
    count: usize,
    samples: *mut LmAxisSample,
    sample_count: usize,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let setpoints = unsafe { list(setpoints, count, "setpoints") }?;
        // SAFETY: the caller's promise.
        let samples = unsafe { room(samples, sample_count, "samples") }?;
        change(axis, |axis| {
            let ticks = axis.servo_ticks();
            let needed = count.saturating_mul(ticks);
            if sample_count != needed {
                return Err(wrong_size("sample count", sample_count, needed));
            }
            let rooms = samples.chunks_mut(ticks);
            setpoints
                .iter()
                .zip(rooms)
                .try_for_each(|(setpoint, samples)| axis.step(setpoint, samples))
        })
    })
}

/// Takes the setpoint of a command cycle, whose servo ticks `lm_axis_tick` steps one by one: for a
/// thread that runs at the servo's rate.
///
/// Threads: one at a time. Real time: yes.
///
/// # Safety
/// `setpoint` is null or a setpoint.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_axis_setpoint(
    axis: *mut LmAxis,
    setpoint: *const LmSetpoint,
) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise; a list of one.
        let setpoints = unsafe { list(setpoint, 1, "setpoint") }?;
        change(axis, |axis| {
            setpoints
                .iter()
                .try_for_each(|setpoint| axis.setpoint(setpoint))
        })
    })
}

/// Steps one servo tick of the setpoint that was taken last.
///
/// Threads: one at a time. Real time: yes.
///
/// # Safety
/// `sample` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_axis_tick(axis: *mut LmAxis, sample: *mut LmAxisSample) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(sample, "sample") }?;
        room.write(change(axis, Alone::tick)?);
        Ok(())
    })
}

/// A copy that goes on from here on its own, and is as fit for real time.
///
/// Threads: one at a time. Real time: no.
///
/// # Safety
/// `copy` is null or has room.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lm_axis_copy(axis: *mut LmAxis, copy: *mut *mut LmAxis) -> LmStatus {
    call(|| {
        // SAFETY: the caller's promise.
        let room = unsafe { out(copy, "copy") }?;
        let copied = change(axis, |axis| {
            let stepping = axis.stepping.get_mut();
            let stepping = stepping.unwrap_or_else(PoisonError::into_inner);
            Ok(Alone {
                config: axis.config.clone(),
                scales: axis.scales,
                stepping: Mutex::new(stepping.clone()),
                failed: Arc::clone(&axis.failed),
            })
        })?;
        room.write(insert(copied)?);
        Ok(())
    })
}

/// Frees an axis; nothing for a null.
///
/// Threads: any, when no other uses it. Real time: no.
#[unsafe(no_mangle)]
pub extern "C" fn lm_axis_free(axis: *mut LmAxis) -> LmStatus {
    call(|| free(axis))
}
