//! `simulate`: a program on a machine, and what came of it.

use crate::apart::{Watch, apart};
use crate::compensator::Maker;
use crate::error::Refusal;
use crate::machine::Machine;
use crate::options;
use crate::program::Program;
use crate::table::Table;
use lostmotion::drive::Learning;
use lostmotion::methods::MethodId;
use lostmotion::report::columns::ColumnTable;
use lostmotion::report::csv::{
    BlockWriter, ContourWriter, MotorWriter, ReversalWriter, TraceRange,
};
use lostmotion::report::page::{PageRecorder, page};
use lostmotion::report::schema::{self as documents, Document};
use lostmotion::report::text::{self, TextOptions};
use lostmotion::report::{json, schema as report_schema};
use lostmotion::sim::MotorPoint;
use lostmotion::sim::machine::Memory;
use lostmotion::sim::request::RunRequest;
use lostmotion::sim::results::{self, BlockResult, ReversalResult};
use lostmotion::{ContourPoint, Observer, SimulateOptions, Simulation};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyTuple};
use pythonize::{depythonize, pythonize};
use std::io;
use std::ops::ControlFlow;
use std::sync::Arc;

/// Every registered method with a line about it.
#[pyfunction]
pub(crate) fn methods() -> Vec<(&'static str, &'static str)> {
    MethodId::all()
        .map(|method| (method.name(), method.info().summary))
        .collect()
}

/// JSON Schema of a document.
#[pyfunction]
pub(crate) fn schema<'py>(py: Python<'py>, document: &str) -> PyResult<Bound<'py, PyAny>> {
    let document: Document = document
        .parse()
        .map_err(|error: documents::UnknownDocument| Refusal::option(error.to_string(), ""))?;
    Ok(pythonize(py, &report_schema::schema(document))?)
}

/// What is kept of a run besides its figures.
#[derive(Clone, Copy)]
struct Wanted {
    samples: bool,
    motors: bool,
    page: bool,
}

/// Keeps rows as they are finished.
struct Keeper {
    methods: Vec<String>,
    watch: Watch,
    blocks: BlockWriter<ColumnTable>,
    reversals: ReversalWriter<ColumnTable>,
    samples: Option<ContourWriter<ColumnTable>>,
    motors: Option<MotorWriter<ColumnTable>>,
    page: Option<PageRecorder>,
}

impl Keeper {
    fn new(methods: Vec<String>, wanted: Wanted, watch: Watch) -> io::Result<Keeper> {
        let all = TraceRange::default();
        let samples = wanted
            .samples
            .then(|| ContourWriter::start(Vec::new(), all));
        Ok(Keeper {
            watch,
            blocks: BlockWriter::start(Vec::new())?,
            reversals: ReversalWriter::start(Vec::new())?,
            samples: samples.transpose()?,
            motors: wanted.motors.then(|| MotorWriter::start(Vec::new(), all)),
            page: wanted.page.then(|| PageRecorder::new(methods.len())),
            methods,
        })
    }

    /// Name of a method, and its table's answer, which cannot fail in memory.
    fn name(&self, method: usize) -> String {
        self.methods.get(method).cloned().unwrap_or_default()
    }
}

impl Observer for Keeper {
    fn progress(&mut self, progress: lostmotion::Progress) -> ControlFlow<()> {
        self.watch.progress(progress)
    }

    fn blocks(&mut self, method: usize, rows: &[BlockResult]) {
        let name = self.name(method);
        // Writing into memory does not fail.
        let _ = self.blocks.push(&name, rows);
    }

    fn reversals(&mut self, method: usize, rows: &[ReversalResult]) {
        let name = self.name(method);
        let _ = self.reversals.push(&name, rows);
    }

    fn contour(&mut self, method: usize, points: &[ContourPoint]) {
        let name = self.name(method);
        if let Some(samples) = &mut self.samples {
            let _ = samples.push(&name, points);
        }
        if let Some(page) = &mut self.page {
            page.contour(method, points);
        }
    }

    fn wants_contour(&self) -> bool {
        self.samples.is_some() || self.page.as_ref().is_some_and(Observer::wants_contour)
    }

    fn wants_limiters(&self) -> bool {
        self.page.as_ref().is_some_and(Observer::wants_limiters)
    }

    fn motors(&mut self, method: usize, points: &[MotorPoint]) {
        let name = self.name(method);
        if let Some(motors) = &mut self.motors {
            let _ = motors.push(&name, points);
        }
        if let Some(page) = &mut self.page {
            page.motors(method, points);
        }
    }

    fn wants_motors(&self) -> bool {
        self.motors.is_some() || self.page.as_ref().is_some_and(Observer::wants_motors)
    }

    fn learning(&mut self, method: usize, time_s: f64, drives: &[Option<Learning>]) {
        if let Some(page) = &mut self.page {
            page.learning(method, time_s, drives);
        }
    }

    fn wants_learning(&self) -> bool {
        self.page.as_ref().is_some_and(Observer::wants_learning)
    }
}

/// What came of a run.
#[pyclass(frozen, module = "lostmotion._native")]
pub(crate) struct Run {
    run: results::Run,
    /// Whether methods were compared: then its document is the comparison's.
    compared: bool,
    #[pyo3(get)]
    blocks: Table,
    #[pyo3(get)]
    reversals: Table,
    #[pyo3(get)]
    samples: Option<Table>,
    #[pyo3(get)]
    motors: Option<Table>,
    #[pyo3(get)]
    page: Option<String>,
    #[pyo3(get)]
    learned: Option<String>,
}

/// What is run: methods by name, and compensators of the caller's.
struct Choices {
    named: Vec<String>,
    own: Vec<(String, Arc<Py<PyAny>>, bool)>,
    compared: bool,
}

fn ran(
    watch: &Watch,
    program: &lostmotion::Program,
    machine: &Machine,
    options: SimulateOptions,
    choices: Choices,
    wanted: Wanted,
) -> Result<Run, Refusal> {
    let own = choices.own.iter().map(|(name, ..)| name.clone());
    let mut names: Vec<String> = choices.named.iter().cloned().chain(own).collect();
    let mut simulation = Simulation::new(program, &machine.0).methods(&choices.named);
    for (name, make, needs_load_scale) in choices.own {
        let maker = Maker {
            name: name.clone(),
            make,
            needs_load_scale,
            watch: watch.clone(),
        };
        simulation = simulation.compensator(name, move |config| maker.of(config));
    }
    if names.is_empty() {
        names.push(machine.0.method_names());
    }
    let mut keeper = Keeper::new(names, wanted, watch.clone())?;
    let run = simulation
        .options(options)
        .observer(&mut keeper)
        .run()
        .map_err(|error| Refusal::of_run(&error, program))?;
    let page = keeper
        .page
        .map(|recorder| page(&run, &machine.0, program, &recorder.finish(&run)))
        .transpose()
        .map_err(|error| Refusal::unread(program, &error))?;
    let mut memory = run.results.iter().map(|result| &result.learned);
    let learned = memory
        .rfind(|memory| !memory.is_empty())
        .map(Memory::to_toml)
        .transpose()
        .map_err(|error| Refusal::new("Error", "internal", error.to_string(), ""))?;
    let samples = keeper.samples.map(ContourWriter::finish).transpose();
    let motors = keeper.motors.map(MotorWriter::finish).transpose();
    Ok(Run {
        compared: choices.compared,
        blocks: Table::of(keeper.blocks.finish()?),
        reversals: Table::of(keeper.reversals.finish()?),
        samples: samples?.map(Table::of),
        motors: motors?.map(Table::of),
        page,
        learned,
        run,
    })
}

/// Runs a program on a machine. `lostmotion.simulate` is its face.
#[pyfunction]
#[expect(
    clippy::too_many_arguments,
    reason = "keywords of the face, which names each of them"
)]
pub(crate) fn simulate(
    py: Python<'_>,
    program: &Program,
    machine: &Machine,
    method: Option<String>,
    methods: Option<Vec<String>>,
    compensators: Vec<(String, Py<PyAny>)>,
    keep: (bool, bool, bool),
    reading: &Bound<'_, PyDict>,
    running: &Bound<'_, PyDict>,
    on_progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<Run> {
    let reading = options::reading(program.path.as_ref(), reading)?;
    let running: RunRequest = options::settings(running)?;
    let mut own = Vec::new();
    for (name, make) in compensators {
        let needs_load_scale = match make.bind(py).getattr_opt("load_scale")? {
            Some(told) => told.is_truthy()?,
            None => false,
        };
        own.push((name, Arc::new(make), needs_load_scale));
    }
    let compared = methods.is_some() || own.len() + usize::from(method.is_some()) > 1;
    let choices = Choices {
        named: methods.into_iter().flatten().chain(method).collect(),
        own,
        compared,
    };
    let (samples, motors, page) = keep;
    let wanted = Wanted {
        samples,
        motors,
        page,
    };
    let (program, machine) = (program.program.clone(), machine.clone());
    apart(py, on_progress, move |watch| {
        let options = reading.options(&machine.0, running.options()?)?;
        ran(watch, &program, &machine, options, choices, wanted)
    })
}

impl Run {
    /// The document that the command prints.
    fn document(&self) -> Result<String, Refusal> {
        let mut out = Vec::new();
        json::write_answer(&mut out, &self.run, self.compared)?;
        Ok(String::from_utf8_lossy(&out).into_owned())
    }
}

#[pymethods]
impl Run {
    /// Every figure in full.
    fn to_dict<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        Ok(pythonize(py, &self.run)?)
    }

    fn to_json(&self) -> PyResult<String> {
        Ok(self.document()?)
    }

    #[getter]
    fn within_tolerance(&self) -> bool {
        self.run.is_within_tolerance()
    }

    /// The answer as the command prints it.
    #[pyo3(signature = (width = None))]
    fn to_text(&self, width: Option<usize>) -> String {
        let options = TextOptions {
            width,
            ..TextOptions::default()
        };
        text::answer(&self.run, self.compared, &options)
    }

    fn __reduce__<'py>(
        slf: &Bound<'py, Run>,
    ) -> PyResult<(Bound<'py, PyAny>, Bound<'py, PyTuple>)> {
        let (py, run) = (slf.py(), slf.get());
        let restore = slf.get_type().getattr("_restore")?;
        let arguments = (
            run.to_dict(py)?,
            run.compared,
            run.blocks.clone(),
            run.reversals.clone(),
            run.samples.clone(),
            run.motors.clone(),
            run.page.clone(),
            run.learned.clone(),
        );
        Ok((restore, arguments.into_pyobject(py)?))
    }

    #[staticmethod]
    #[expect(clippy::too_many_arguments, reason = "all that a pickled run holds")]
    fn _restore(
        run: &Bound<'_, PyAny>,
        compared: bool,
        blocks: Table,
        reversals: Table,
        samples: Option<Table>,
        motors: Option<Table>,
        page: Option<String>,
        learned: Option<String>,
    ) -> PyResult<Run> {
        Ok(Run {
            run: depythonize(run).map_err(|error| {
                Refusal::data(format!("this is no pickled run: {error}"), "").raised(run.py())
            })?,
            compared,
            blocks,
            reversals,
            samples,
            motors,
            page,
            learned,
        })
    }
}
