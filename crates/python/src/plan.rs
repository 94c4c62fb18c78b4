//! `plan`: the motion alone.

use crate::apart::apart;
use crate::error::Refusal;
use crate::machine::Machine;
use crate::options;
use crate::program::Program;
use crate::table::Table;
use lostmotion::Simulation;
use lostmotion::report::columns::ColumnTable;
use lostmotion::report::csv::PlanWriter;
use lostmotion::sim::request::RunRequest;
use lostmotion::sim::results::PlanInfo;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use pythonize::pythonize;

/// A planned motion.
#[pyclass(frozen, module = "lostmotion")]
pub(crate) struct Plan {
    info: PlanInfo,
    /// A row a command cycle: time, position, velocity and acceleration of each axis, source line.
    #[pyo3(get)]
    samples: Table,
}

#[pymethods]
impl Plan {
    /// Length of the motion, s.
    #[getter]
    fn duration_s(&self) -> f64 {
        self.info.duration_s
    }

    /// Length of cutting moves, mm.
    #[getter]
    fn cutting_mm(&self) -> f64 {
        self.info.cutting_mm
    }

    /// Length of rapids, mm.
    #[getter]
    fn rapid_mm(&self) -> f64 {
        self.info.rapid_mm
    }

    /// All that is known of the plan.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(pythonize(py, &self.info)?)
    }

    fn __repr__(&self) -> String {
        format!(
            "Plan({:?} s, {} samples)",
            self.info.duration_s,
            self.samples.rows()
        )
    }
}

/// Plans a program.
#[pyfunction]
pub(crate) fn plan(
    py: Python<'_>,
    program: &Program,
    machine: &Machine,
    reading: &Bound<'_, PyDict>,
    running: &Bound<'_, PyDict>,
    on_progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Plan> {
    let reading = options::reading(program.path.as_ref(), reading)?;
    let running: RunRequest = options::settings(running)?;
    let (program, machine) = (program.program.clone(), machine.clone());
    apart(py, on_progress, move |watch| {
        let options = reading.options(&machine.0, running.options()?)?;
        let (axes, rotary) = (machine.0.axis_set(), machine.0.rotary_joints());
        let command = machine.0.cycles().command();
        let mut writer =
            PlanWriter::<ColumnTable>::start_with_rates(Vec::new(), axes, rotary, command)?;
        let info = Simulation::new(&program, &machine.0)
            .options(options)
            .on_progress(|progress| watch.progress(progress))
            .plan(&mut |samples, _path| writer.push(samples).map_err(Into::into))
            .map_err(|error| Refusal::of_run(&error, &program))?;
        Ok(Plan {
            info,
            samples: Table::of(writer.finish()?),
        })
    })
}
