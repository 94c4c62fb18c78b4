//! Compensators of the caller's own.

use crate::border::{item, text};
use crate::failure::Failure;
use crate::machine::wrong_size;
use lostmotion::drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use lostmotion::methods::AxisConfig;
use serde::de::Error as _;
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::ffi::{c_char, c_void};
use std::ptr::NonNull;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// What a compensator may know of its axis; all angles are rad at the motor's shaft.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmAxisFacts {
    /// Unit of positions: "mm", "deg" or "rad".
    pub unit: *const c_char,
    /// Angle of the motor for a unit of the axis, rad.
    pub motor_rad_per_unit: f64,
    /// Time between two calls of `step`, s.
    pub servo_period_s: f64,
    /// Total gap, rad.
    pub gap_rad: f64,
    /// Inertia at the motor, its own and what turns with it, kg m2.
    pub motor_inertia_kgm2: f64,
    /// Coulomb friction of the motor, N m.
    pub motor_coulomb_nm: f64,
    /// Inertia of the load, kg m2.
    pub load_inertia_kgm2: f64,
    /// Coulomb friction of the load, N m.
    pub load_coulomb_nm: f64,
    /// Viscous friction of the load, N m s/rad.
    pub load_viscous_nm_s_per_rad: f64,
    /// Constant torque on the load, N m.
    pub load_constant_nm: f64,
    /// Stiffness of the shaft, N m/rad.
    pub stiffness_nm_per_rad: f64,
    /// Damping of the shaft, N m s/rad.
    pub damping_nm_s_per_rad: f64,
}

/// What a compensator sees at a servo tick: rad, rad/s, rad/s2 at the motor, A.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmTick {
    /// Reference.
    pub position: f64,
    /// Its velocity.
    pub velocity: f64,
    /// Its acceleration.
    pub acceleration: f64,
    /// Reference one servo tick ahead.
    pub next_position: f64,
    /// Its velocity.
    pub next_velocity: f64,
    /// Its acceleration.
    pub next_acceleration: f64,
    /// Motor from its encoder.
    pub motor_position: f64,
    /// Motor's velocity as the drive computes it.
    pub motor_velocity: f64,
    /// Torque-forming current at the tick.
    pub current: f64,
    /// Its mean over the last servo period.
    pub mean_current: f64,
    /// Load from its scale; NaN unless the compensator has `load_scale`.
    pub load_position: f64,
    /// Whether the drive was at a limit in the last period.
    pub saturated: bool,
}

/// What a compensator answers; zeros where it has nothing to say.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmCorrection {
    /// Added to the position reference, rad.
    pub position: f64,
    /// Added to the velocity feed-forward, rad/s.
    pub velocity: f64,
    /// Added to the torque feed-forward, N m.
    pub torque: f64,
    /// Subtracted from the measured motor position, rad.
    pub feedback: f64,
}

/// A compensator: four functions that work on a state of the caller's.
///
/// One state is made for each axis and method, and copied where the library tries a motion ahead.
/// Different states may be stepped on different threads at the same time; one state is used by one
/// thread at a time. The functions must return: no `longjmp`, no C++ exception.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmCompensator {
    /// `sizeof(LmCompensator)`.
    pub size: usize,
    /// Name in the results.
    pub name: *const c_char,
    /// Handed to `create`; it has to outlive the simulation or axis.
    pub user: *mut c_void,
    /// Makes the state of an axis that stands at `motor_position` rad; null where it cannot.
    pub create: Option<
        unsafe extern "C" fn(
            user: *mut c_void,
            facts: *const LmAxisFacts,
            motor_position: f64,
        ) -> *mut c_void,
    >,
    /// Copies a state; null where it cannot.
    pub copy: Option<unsafe extern "C" fn(state: *const c_void) -> *mut c_void>,
    /// Frees a state.
    pub destroy: Option<unsafe extern "C" fn(state: *mut c_void)>,
    /// A servo tick: sets the parts of the correction that are not zero.
    pub step: Option<
        unsafe extern "C" fn(
            state: *mut c_void,
            tick: *const LmTick,
            correction: *mut LmCorrection,
        ),
    >,
    /// Whether it is shown the load's scale.
    pub load_scale: bool,
}

/// The functions, all there.
#[derive(Clone, Copy, Debug)]
struct Functions {
    user: *mut c_void,
    create: unsafe extern "C" fn(*mut c_void, *const LmAxisFacts, f64) -> *mut c_void,
    copy: unsafe extern "C" fn(*const c_void) -> *mut c_void,
    destroy: unsafe extern "C" fn(*mut c_void),
    step: unsafe extern "C" fn(*mut c_void, *const LmTick, *mut LmCorrection),
}

// SAFETY: `user` is only handed to `create`; the interface says that it may come from any thread.
unsafe impl Send for Functions {}
// SAFETY: as above.
unsafe impl Sync for Functions {}

/// A compensator of the caller's, and whether one of its axes has failed.
#[derive(Clone, Debug)]
pub(crate) struct Own {
    pub(crate) name: String,
    functions: Functions,
    info: &'static MethodInfo,
    pub(crate) failed: Arc<AtomicBool>,
}

impl Own {
    /// From what C hands in.
    ///
    /// # Errors
    /// A null, a size of another version, a function that is not there.
    ///
    /// # Safety
    /// `given` is null or points to a compensator whose functions do as the interface says.
    pub(crate) unsafe fn of(given: *const LmCompensator) -> Result<Own, Failure> {
        // SAFETY: the caller's promise; its size is checked before anything else is used.
        let given = unsafe { item(given, "compensator") }?;
        if given.size != size_of::<LmCompensator>() {
            let needed = size_of::<LmCompensator>();
            return Err(wrong_size("compensator.size", given.size, needed));
        }
        // SAFETY: the caller's promise.
        let name = unsafe { text(given.name, "compensator.name") }?;
        let (Some(create), Some(copy), Some(destroy), Some(step)) =
            (given.create, given.copy, given.destroy, given.step)
        else {
            let hint = "create, copy, destroy and step are all needed";
            return Err(Failure::option(
                "a function of the compensator is null",
                hint,
            ));
        };
        let knows = Knowledge {
            load_scale: given.load_scale,
            gap: true,
            load: true,
        };
        Ok(Own {
            name: name.to_owned(),
            functions: Functions {
                user: given.user,
                create,
                copy,
                destroy,
                step,
            },
            info: MethodInfo::kept(name, "a compensator of the caller's, in C", knows),
            failed: Arc::default(),
        })
    }

    /// The compensator of an axis.
    pub(crate) fn for_axis(&self, config: &AxisConfig) -> OwnOfAxis {
        let load = config.reflected_load();
        let unit = match config.unit().symbol() {
            "mm" => c"mm",
            "deg" => c"deg",
            _ => c"rad",
        };
        OwnOfAxis {
            own: self.clone(),
            facts: Facts(LmAxisFacts {
                unit: unit.as_ptr(),
                motor_rad_per_unit: config.transmission.motor_rad_per_unit(),
                servo_period_s: config.cycles.servo().period_s(),
                gap_rad: load.gap_rad,
                motor_inertia_kgm2: config.motor_side_inertia_kgm2(),
                motor_coulomb_nm: config.motor.coulomb_nm,
                load_inertia_kgm2: load.inertia_kgm2,
                load_coulomb_nm: load.coulomb_nm,
                load_viscous_nm_s_per_rad: load.viscous_nm_s_per_rad,
                load_constant_nm: load.constant_nm,
                stiffness_nm_per_rad: load.stiffness_nm_per_rad,
                damping_nm_s_per_rad: load.damping_nm_s_per_rad,
            }),
        }
    }
}

struct Facts(LmAxisFacts);

// SAFETY: its only pointer is to a constant text.
unsafe impl Send for Facts {}
// SAFETY: as above.
unsafe impl Sync for Facts {}

/// A compensator of the caller's for one axis.
pub(crate) struct OwnOfAxis {
    own: Own,
    facts: Facts,
}

/// A state of the caller's; none once it has failed.
pub(crate) struct OwnState {
    state: Option<NonNull<c_void>>,
    functions: Option<Functions>,
}

// SAFETY: a state is used by one thread at a time, and the interface says that it may be any.
unsafe impl Send for OwnState {}
// SAFETY: a shared state is only copied, and the interface says that `copy` looks and changes nothing.
unsafe impl Sync for OwnState {}

impl Clone for OwnState {
    fn clone(&self) -> OwnState {
        let copied = self
            .state
            .zip(self.functions)
            .and_then(|(state, functions)| {
                // SAFETY: a state that `create` or `copy` made and that has not been destroyed.
                NonNull::new(unsafe { (functions.copy)(state.as_ptr()) })
            });
        OwnState {
            state: copied,
            functions: self.functions,
        }
    }
}

impl Drop for OwnState {
    fn drop(&mut self) {
        if let Some((state, functions)) = self.state.take().zip(self.functions) {
            // SAFETY: a state that `create` or `copy` made, destroyed once.
            unsafe { (functions.destroy)(state.as_ptr()) };
        }
    }
}

impl Serialize for OwnState {
    fn serialize<S: Serializer>(&self, _serializer: S) -> Result<S::Ok, S::Error> {
        Err(S::Error::custom("a compensator in C is not stored"))
    }
}

impl<'de> Deserialize<'de> for OwnState {
    fn deserialize<D: Deserializer<'de>>(_deserializer: D) -> Result<OwnState, D::Error> {
        Err(D::Error::custom("a compensator in C is not stored"))
    }
}

impl Compensator for OwnOfAxis {
    type State = OwnState;

    fn info(&self) -> &'static MethodInfo {
        self.own.info
    }

    fn initial(&self, motor_position: f64) -> OwnState {
        let functions = self.own.functions;
        // SAFETY: the function of the interface with its own user pointer; the facts live on.
        let made = unsafe { (functions.create)(functions.user, &self.facts.0, motor_position) };
        let state = NonNull::new(made);
        if state.is_none() {
            self.own.failed.store(true, Ordering::Relaxed);
        }
        OwnState {
            state,
            functions: Some(functions),
        }
    }

    fn step(&self, state: &mut OwnState, signals: &Signals) -> Correction {
        let Some(own) = state.state else {
            // A copy could not be made.
            self.own.failed.store(true, Ordering::Relaxed);
            return Correction::NONE;
        };
        let (now, next) = (&signals.reference, &signals.next_reference);
        let tick = LmTick {
            position: now.position,
            velocity: now.velocity,
            acceleration: now.acceleration,
            next_position: next.position,
            next_velocity: next.velocity,
            next_acceleration: next.acceleration,
            motor_position: signals.motor_position,
            motor_velocity: signals.motor_velocity,
            current: signals.current,
            mean_current: signals.mean_current,
            load_position: signals.load_position.unwrap_or(f64::NAN),
            saturated: signals.saturated,
        };
        let mut answer = LmCorrection {
            position: 0.0,
            velocity: 0.0,
            torque: 0.0,
            feedback: 0.0,
        };
        // SAFETY: a state that `create` or `copy` made, which this thread alone uses; tick and answer
        // live through the call.
        unsafe { (self.own.functions.step)(own.as_ptr(), &tick, &mut answer) };
        let correction = Correction {
            position: answer.position,
            velocity: answer.velocity,
            torque: answer.torque,
            feedback: answer.feedback,
            ..Correction::NONE
        };
        if !correction.is_usable() {
            self.own.failed.store(true, Ordering::Relaxed);
        }
        correction
    }
}
