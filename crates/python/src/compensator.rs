//! Compensators written in Python: slow (a call per servo tick and axis, under Python's lock), and
//! good for trying an idea.

use crate::apart::Watch;
use lostmotion::drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use lostmotion::methods::AxisConfig;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFloat};
use pythonize::pythonize;
use serde::de::Error as _;
use serde::ser::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};
use std::sync::Arc;

/// Makes an axis' compensator: a callable of the user's that takes the facts of an axis.
pub(crate) struct Maker {
    pub(crate) name: String,
    pub(crate) make: Arc<Py<PyAny>>,
    pub(crate) needs_load_scale: bool,
    /// Where an exception of the user's code goes.
    pub(crate) watch: Watch,
}

impl Maker {
    /// The compensator of an axis.
    pub(crate) fn of(&self, config: &AxisConfig) -> Scripted {
        Scripted {
            make: Arc::clone(&self.make),
            config: Box::new(config.clone()),
            info: MethodInfo::kept(
                &self.name,
                "a compensator written in Python",
                Knowledge {
                    load_scale: self.needs_load_scale,
                    gap: true,
                    load: true,
                },
            ),
            watch: self.watch.clone(),
        }
    }
}

/// A compensator of the user's for one axis.
pub(crate) struct Scripted {
    make: Arc<Py<PyAny>>,
    config: Box<AxisConfig>,
    info: &'static MethodInfo,
    watch: Watch,
}

/// The user's object, which carries its state itself; `None` once it has failed.
pub(crate) struct Scripting(Option<Py<PyAny>>);

impl Clone for Scripting {
    /// A copy goes on by itself, as the state of any compensator does.
    fn clone(&self) -> Scripting {
        let copy = |object: &Py<PyAny>| {
            Python::try_attach(|py| {
                let copied = py.import("copy")?.call_method1("deepcopy", (object,))?;
                PyResult::Ok(copied.unbind())
            })
        };
        Scripting(self.0.as_ref().and_then(copy).and_then(Result::ok))
    }
}

impl Serialize for Scripting {
    fn serialize<S: Serializer>(&self, _serializer: S) -> Result<S::Ok, S::Error> {
        Err(S::Error::custom("a compensator in Python is not stored"))
    }
}

impl<'de> Deserialize<'de> for Scripting {
    fn deserialize<D: Deserializer<'de>>(_deserializer: D) -> Result<Scripting, D::Error> {
        Err(D::Error::custom("a compensator in Python is not stored"))
    }
}

/// What a compensator may know of its axis; all angles are rad at the motor's shaft.
fn facts<'py>(py: Python<'py>, config: &AxisConfig) -> PyResult<Bound<'py, PyAny>> {
    let load = config.reflected_load();
    let given = PyDict::new(py);
    given.set_item("unit", config.unit().symbol())?;
    given.set_item(
        "motor_rad_per_unit",
        config.transmission.motor_rad_per_unit(),
    )?;
    given.set_item("servo_period_s", config.cycles.servo().period_s())?;
    given.set_item("gap_rad", load.gap_rad)?;
    given.set_item("motor_inertia_kgm2", config.motor_side_inertia_kgm2())?;
    given.set_item("motor_coulomb_nm", config.motor.coulomb_nm)?;
    given.set_item("load_inertia_kgm2", load.inertia_kgm2)?;
    given.set_item("load_coulomb_nm", load.coulomb_nm)?;
    given.set_item("load_viscous_nm_s_per_rad", load.viscous_nm_s_per_rad)?;
    given.set_item("load_constant_nm", load.constant_nm)?;
    given.set_item("stiffness_nm_per_rad", load.stiffness_nm_per_rad)?;
    given.set_item("damping_nm_s_per_rad", load.damping_nm_s_per_rad)?;
    given.set_item("description", pythonize(py, config)?)?;
    let class = py.import("lostmotion.compensators")?.getattr("AxisFacts")?;
    class.call((), Some(&given))
}

/// What the user's object sees at a tick.
#[pyclass(frozen, get_all, module = "lostmotion")]
pub(crate) struct Tick {
    /// Reference, rad, rad/s, rad/s2.
    position: f64,
    velocity: f64,
    acceleration: f64,
    /// The same one servo tick ahead.
    next_position: f64,
    next_velocity: f64,
    next_acceleration: f64,
    /// Motor, rad and rad/s, as the drive sees it.
    motor_position: f64,
    motor_velocity: f64,
    /// Torque-forming current, A, at the tick and its mean over the last period.
    current: f64,
    mean_current: f64,
    /// Whether the drive was at a limit in the last period.
    saturated: bool,
    /// Load from its scale, rad; `None` unless the compensator declares `load_scale`.
    load_position: Option<f64>,
}

impl Tick {
    fn of(signals: &Signals) -> Tick {
        let (now, next) = (&signals.reference, &signals.next_reference);
        Tick {
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
            saturated: signals.saturated,
            load_position: signals.load_position,
        }
    }
}

fn no_correction(answer: &Bound<'_, PyAny>) -> PyErr {
    let message = format!("a compensator answered {answer}, which is no correction");
    let hint = "answer an angle in rad, a Correction, or None";
    crate::error::Refusal::new("MethodError", "correction", message, hint).raised(answer.py())
}

/// A correction from what the user's `step` answers: nothing, an angle, or one with named parts.
fn correction(answer: &Bound<'_, PyAny>) -> PyResult<Correction> {
    if answer.is_none() {
        return Ok(Correction::NONE);
    }
    if let Ok(position) = answer.extract::<f64>() {
        // Truth values are numbers to Python, and no angles.
        if !answer.is_instance_of::<PyFloat>() && answer.extract::<bool>().is_ok() {
            return Err(no_correction(answer));
        }
        return Ok(Correction {
            position,
            ..Correction::NONE
        });
    }
    let part = |name: &str| match answer.getattr_opt(name)? {
        Some(value) => value.extract::<f64>(),
        None => Err(no_correction(answer)),
    };
    Ok(Correction {
        position: part("position")?,
        velocity: part("velocity")?,
        torque: part("torque")?,
        feedback: part("feedback")?,
        ..Correction::NONE
    })
}

impl Compensator for Scripted {
    type State = Scripting;

    fn info(&self) -> &'static MethodInfo {
        self.info
    }

    fn initial(&self, motor_position: f64) -> Scripting {
        let made = Python::try_attach(|py| {
            let object = self.make.bind(py).call1((facts(py, &self.config)?,))?;
            // Optional: a compensator that does not care need not have it.
            if object.hasattr("start")? {
                object.call_method1("start", (motor_position,))?;
            }
            PyResult::Ok(object.unbind())
        });
        Scripting(match made {
            Some(Ok(object)) => Some(object),
            Some(Err(error)) => {
                self.watch.raise(error);
                None
            }
            // Python is ending.
            None => None,
        })
    }

    fn step(&self, state: &mut Scripting, signals: &Signals) -> Correction {
        // Nobody waits any more: the rest of the chunk is left without Python's lock.
        let Some(object) = state.0.as_ref().filter(|_| !self.watch.is_cancelled()) else {
            return Correction::NONE;
        };
        let answer = Python::try_attach(|py| {
            let answer = object.bind(py).call_method1("step", (Tick::of(signals),))?;
            let correction = correction(&answer)?;
            if correction.is_usable() {
                return Ok(correction);
            }
            let message = format!("a compensator answered {answer}, which no drive can follow");
            let hint = "answer finite angles (rad), speeds (rad/s) and torques (N m)";
            Err(crate::error::Refusal::new("MethodError", "correction", message, hint).raised(py))
        });
        match answer {
            Some(Ok(correction)) => correction,
            Some(Err(error)) => {
                self.watch.raise(error);
                state.0 = None;
                Correction::NONE
            }
            None => Correction::NONE,
        }
    }
}
