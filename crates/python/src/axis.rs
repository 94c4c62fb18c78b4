//! One axis alone, a command cycle after the other.

use crate::apart::Watch;
use crate::compensator::Maker;
use crate::error::Refusal;
use crate::machine::Machine;
use crate::table::{Table, eights};
use lostmotion::drive::{AxisError, AxisOutput, AxisRunner, Setpoint};
use lostmotion::methods::{AxisConfig, MethodId, UnknownMethod, alone, build_runner, run_with};
use lostmotion::report::columns::ColumnTable;
use lostmotion::report::csv::AxisTraceWriter;
use lostmotion::sim::machine::{axis_from_toml, axis_preset};
use pyo3::prelude::*;
use pythonize::pythonize;
use std::sync::{Arc, Mutex, MutexGuard, TryLockError};

/// Setpoints that go to the axis at once, after which Ctrl-C is heard. A choice: a second of motion.
const CHUNK: usize = 1000;

/// An axis with a compensator.
#[pyclass(frozen, module = "lostmotion._native")]
pub(crate) struct Axis {
    config: AxisConfig,
    method: String,
    servo_ticks: usize,
    delay_ticks: u32,
    stepping: Mutex<Stepping>,
    /// Where exceptions of a compensator in Python go.
    watch: Watch,
}

/// What changes from step to step.
struct Stepping {
    runner: Box<dyn AxisRunner>,
    out: AxisOutput,
    tick: u64,
}

fn unfit(error: &AxisError) -> Refusal {
    Refusal::new("MethodError", "axis", error.to_string(), "")
}

/// The description of an axis: of a preset, of a machine's drive, or of a text.
pub(crate) fn described(axis: &Bound<'_, PyAny>, drive: Option<&str>) -> PyResult<AxisConfig> {
    if let Ok(machine) = axis.cast::<Machine>() {
        let machine = &machine.get().0;
        let known = machine.drives().join(", ");
        let hint = format!("its drives: {known}");
        let drive = drive.ok_or_else(|| Refusal::option("which axis of the machine?", &hint))?;
        let found = machine.drive(drive).cloned();
        return Ok(found.ok_or_else(|| {
            Refusal::option(format!("the machine has no axis \"{drive}\""), &hint)
        })?);
    }
    let text: String = axis.extract()?;
    if text.contains('\n') {
        return Ok(axis_from_toml("axis.toml", &text).map_err(Refusal::from)?);
    }
    Ok(axis_preset(&text).ok_or_else(|| {
        let hint = "for example \"paper\" or \"vmc3:x\"; or a Machine with the letter of its axis";
        Refusal::option(format!("there is no axis \"{text}\""), hint)
    })?)
}

/// A column of setpoints; nothing where it was not given.
fn column(bytes: Option<&[u8]>) -> Option<Vec<f64>> {
    bytes.map(|bytes| eights(bytes, f64::from_ne_bytes))
}

type TraceTable = AxisTraceWriter<ColumnTable>;

impl Stepping {
    /// Takes setpoints and adds what the axis did at the servo ticks of each to a table.
    fn take(&mut self, setpoints: &[Setpoint], table: &mut TraceTable) -> Result<(), Refusal> {
        let pushed = self.runner.push(setpoints, &mut self.out);
        // Of setpoints before a refused one the ticks have passed.
        for sample in self.out.trace.iter().flatten() {
            table.push(self.tick, sample)?;
            self.tick += 1;
        }
        self.out.clear();
        pushed.map_err(|error| unfit(&error))
    }
}

impl Axis {
    /// What changes from step to step. Nobody waits for it with Python's lock in hand, which a
    /// compensator in Python needs to go on.
    fn stepping(&self) -> Result<MutexGuard<'_, Stepping>, Refusal> {
        match self.stepping.try_lock() {
            Ok(stepping) => Ok(stepping),
            Err(TryLockError::Poisoned(poisoned)) => Ok(poisoned.into_inner()),
            Err(TryLockError::WouldBlock) => Err(Refusal::option(
                "the axis is being stepped",
                "step an axis from one thread at a time; copy() makes another one",
            )),
        }
    }
}

#[pymethods]
impl Axis {
    #[new]
    #[pyo3(signature = (axis, drive = None, *, method = None, compensator = None, start = 0.0, differences = true))]
    fn new(
        py: Python<'_>,
        axis: &Bound<'_, PyAny>,
        drive: Option<&str>,
        method: Option<&str>,
        compensator: Option<Py<PyAny>>,
        start: f64,
        differences: bool,
    ) -> PyResult<Axis> {
        let mut config = alone(described(axis, drive)?, differences);
        config.compensation.estimate_shaft = true;
        let watch = Watch::alone();
        let (runner, name) = match (method, compensator) {
            (Some(_), Some(_)) => {
                let hint = "give one of them";
                return Err(Refusal::option("both method and compensator are given", hint).into());
            }
            (None, Some(make)) => {
                let scale = make.bind(py).getattr_opt("load_scale")?;
                let maker = Maker {
                    name: "own".to_owned(),
                    needs_load_scale: scale.is_some_and(|told| told.is_truthy().unwrap_or(false)),
                    make: Arc::new(make),
                    watch: watch.clone(),
                };
                let made = run_with(&config, maker.of(&config), start);
                (made, "own".to_owned())
            }
            (method, None) => {
                let name = method.unwrap_or(MethodId::NONE.name());
                let method: MethodId = name.parse().map_err(|error: UnknownMethod| {
                    Refusal::new("MethodError", "unknown-method", error.to_string(), "")
                })?;
                (build_runner(&config, method, start), name.to_owned())
            }
        };
        if let Some(error) = watch.raised() {
            return Err(error);
        }
        let runner = runner.map_err(|error| unfit(&error))?;
        Ok(Axis {
            servo_ticks: runner.servo_ticks(),
            delay_ticks: runner.delay_ticks(),
            stepping: Mutex::new(Stepping {
                runner,
                out: AxisOutput::new(true),
                tick: 0,
            }),
            method: name,
            config,
            watch,
        })
    }

    /// Takes setpoints, and answers what the axis did at the servo ticks of each.
    fn _push(
        &self,
        py: Python<'_>,
        position: &[u8],
        velocity: Option<&[u8]>,
        acceleration: Option<&[u8]>,
        load_force: Option<&[u8]>,
    ) -> PyResult<Table> {
        let position = eights(position, f64::from_ne_bytes);
        let [velocity, acceleration, force] = [velocity, acceleration, load_force].map(column);
        let at = |column: &Option<Vec<f64>>, index: usize| {
            column
                .as_ref()
                .and_then(|column| column.get(index))
                .copied()
        };
        let setpoints: Vec<Setpoint> = position
            .iter()
            .enumerate()
            .map(|(index, position)| Setpoint {
                position: *position,
                velocity: at(&velocity, index),
                acceleration: at(&acceleration, index),
                load_force: at(&force, index),
                ..Setpoint::default()
            })
            .collect();
        if self.watch.is_cancelled() {
            let hint = "make a new axis";
            let text = "the compensator of this axis has failed";
            return Err(Refusal::new("MethodError", "failed", text, hint).into());
        }
        let units_per_rad = 1.0 / self.config.transmission.motor_rad_per_unit();
        let (unit, clock) = (self.config.unit(), self.config.cycles.servo());
        let mut table = TraceTable::start(Vec::new(), unit, units_per_rad, clock)?;
        for chunk in setpoints.chunks(CHUNK) {
            let taken = py.detach(|| self.stepping()?.take(chunk, &mut table));
            if let Some(error) = self.watch.raised() {
                return Err(error);
            }
            taken?;
            py.check_signals()?;
        }
        Ok(Table::of(table.finish()?))
    }

    /// Unit of positions: mm, deg or rad.
    #[getter]
    fn unit(&self) -> &'static str {
        self.config.unit().symbol()
    }

    #[getter]
    fn method(&self) -> &str {
        &self.method
    }

    /// Servo ticks in a command cycle.
    #[getter]
    fn servo_ticks(&self) -> usize {
        self.servo_ticks
    }

    /// Command cycles by which the reference lags behind the setpoints.
    #[getter]
    fn delay_ticks(&self) -> u32 {
        self.delay_ticks
    }

    /// Time between two servo ticks, s.
    #[getter]
    fn servo_period_s(&self) -> f64 {
        self.config.cycles.servo().period_s()
    }

    /// Time between two setpoints, s.
    #[getter]
    fn command_period_s(&self) -> f64 {
        self.config.cycles.command().period_s()
    }

    /// Everything that is known of the axis.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(pythonize(py, &self.config)?)
    }

    /// A copy that goes on from here on its own.
    fn copy(&self) -> PyResult<Axis> {
        let stepping = self.stepping()?;
        Ok(Axis {
            config: self.config.clone(),
            method: self.method.clone(),
            servo_ticks: self.servo_ticks,
            delay_ticks: self.delay_ticks,
            watch: self.watch.clone(),
            stepping: Mutex::new(Stepping {
                runner: stepping.runner.boxed_clone(),
                out: stepping.out.clone(),
                tick: stepping.tick,
            }),
        })
    }

    fn __repr__(&self) -> String {
        format!("Axis({}, method={:?})", self.unit(), self.method)
    }
}
