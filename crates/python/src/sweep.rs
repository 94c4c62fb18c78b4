//! Sweeps: a driver with manifest and results, and workers that run batches of cells.

use crate::apart::apart;
use crate::error::Refusal;
use crate::table::Table;
use lostmotion::report::columns::ColumnTable;
use lostmotion_sweep::SweepError;
use lostmotion_sweep::batch::{Driver, work, work_each};
use lostmotion_sweep::collect::Finished;
use lostmotion_sweep::file::SweepFile;
use lostmotion_sweep::manifest::Manifest;
use lostmotion_sweep::missing::Shard;
use lostmotion_sweep::plan::{Folders, plan};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

impl From<SweepError> for Refusal {
    fn from(error: SweepError) -> Refusal {
        match error {
            SweepError::Machine(error) => error.into(),
            SweepError::Request(error) => error.into(),
            error @ (SweepError::Write(_) | SweepError::Read { .. }) => {
                Refusal::new("Error", "file", error.to_string(), &error.hint())
            }
            error => Refusal::data(error.to_string(), &error.hint()),
        }
    }
}

fn refused(error: SweepError) -> PyErr {
    Refusal::from(error).into()
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Plans a sweep from the text of its file; writes the manifest and gives the number of cells.
#[pyfunction]
pub(crate) fn sweep_plan(
    py: Python<'_>,
    text: String,
    path: PathBuf,
    out: PathBuf,
    most_cells: Option<usize>,
) -> PyResult<usize> {
    apart(py, None, move |_| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let file = SweepFile::from_toml(&name, &text)?;
        let folders = Folders {
            file: folder(&path),
            manifest: folder(&out),
        };
        let plan = plan(&file, folders, most_cells)?;
        plan.write(&out)?;
        Ok(plan.header.cells)
    })
}

/// How many missing cells are named. A choice.
const NAMED: usize = 3;

/// The table of a sweep, the number of cells that are missing, and the keys of the first of them.
#[pyfunction]
pub(crate) fn sweep_collect(
    py: Python<'_>,
    manifest: PathBuf,
    results: Vec<PathBuf>,
) -> PyResult<(Table, usize, Vec<String>)> {
    apart(py, None, move |_| {
        let manifest = Manifest::read(&manifest)?;
        let mut finished = Finished::read(&manifest, &results)?;
        let columns = finished.write_table::<ColumnTable>(Vec::new())?;
        let (missing, first) = finished.missing(NAMED)?;
        let first = first.iter().map(|(_, cell)| cell.key.to_string());
        Ok((Table::of(columns), missing, first.collect()))
    })
}

/// Runs a batch of cells: what every worker needs, the texts of programs by their numbers, and lines
/// of cells; gives lines of results. Ctrl-C ends it after the cells in flight.
#[pyfunction]
pub(crate) fn sweep_work(
    py: Python<'_>,
    shared: Vec<u8>,
    programs: Vec<(usize, Vec<u8>)>,
    cells: Vec<String>,
    threads: usize,
) -> PyResult<Vec<String>> {
    let stop = Arc::new(AtomicBool::new(false));
    let stopping = Stopping(Arc::clone(&stop));
    let answer = apart(py, None, move |_| {
        Ok(work(&shared, programs, &cells, threads, &stop)?)
    });
    drop(stopping);
    answer
}

/// Ends the work when its caller leaves.
struct Stopping(Arc<AtomicBool>);

impl Drop for Stopping {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

/// The side that has manifest and results, until it is closed.
#[pyclass(frozen, module = "lostmotion")]
pub(crate) struct SweepDriver(Mutex<Option<Driver>>);

impl SweepDriver {
    fn slot(&self) -> MutexGuard<'_, Option<Driver>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Does something with the driver while it is open.
    fn with<T>(
        &self,
        act: impl FnOnce(&mut Driver) -> Result<T, SweepError>,
    ) -> Result<T, Refusal> {
        match self.slot().as_mut() {
            Some(driver) => Ok(act(driver)?),
            None => Err(Refusal::data("the sweep was left".to_owned(), "")),
        }
    }
}

#[pymethods]
impl SweepDriver {
    #[new]
    fn new(
        py: Python<'_>,
        manifest: PathBuf,
        shard: &str,
        results: PathBuf,
    ) -> PyResult<SweepDriver> {
        let shard: Shard = shard
            .parse()
            .map_err(|why: String| Refusal::option(why, "").raised(py))?;
        apart(py, None, move |_| {
            Ok(Driver::open(&manifest, shard, &results)?)
        })
        .map(|driver| SweepDriver(Mutex::new(Some(driver))))
    }

    /// Number of cells that are to be run.
    fn __len__(&self) -> usize {
        self.slot().as_ref().map_or(0, Driver::len)
    }

    /// What every worker needs.
    fn shared<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyBytes>> {
        let shared = self.with(|driver| driver.shared())?;
        Ok(PyBytes::new(py, &shared))
    }

    /// Lines of the next cells, `count` at most, and the numbers of their programs.
    fn take(&self, count: usize) -> PyResult<(Vec<String>, Vec<usize>)> {
        Ok(self.with(|driver| driver.take(count))?)
    }

    /// The text of a program.
    fn program<'py>(&self, py: Python<'py>, index: usize) -> PyResult<Bound<'py, PyBytes>> {
        let text = self.with(|driver| driver.program(index))?;
        Ok(PyBytes::new(py, &text))
    }

    /// Keeps lines of results; gives the number without figures, and the machine time, s.
    #[expect(clippy::needless_pass_by_value, reason = "Python hands texts over")]
    fn append(&self, lines: Vec<String>) -> PyResult<(usize, f64)> {
        Ok(self.with(|driver| driver.append(&lines))?)
    }

    /// Runs a batch of cells in this process and keeps each result as it is finished; gives what
    /// `append` does. After Ctrl-C nothing is kept any more.
    fn work(
        slf: Py<Self>,
        py: Python<'_>,
        shared: Vec<u8>,
        programs: Vec<(usize, Vec<u8>)>,
        cells: Vec<String>,
        threads: usize,
    ) -> PyResult<(usize, f64)> {
        let stop = Arc::new(AtomicBool::new(false));
        let stopping = Stopping(Arc::clone(&stop));
        let answer = apart(py, None, move |_| {
            let (mut failed, mut simulated_s) = (0, 0.0);
            let mut closed = Ok(());
            let worked = work_each(&shared, programs, &cells, threads, &stop, &mut |_, line| {
                // Without a driver the caller has left: what is still in flight is let go.
                match slf.get().with(|driver| driver.append(&[line])) {
                    Ok((without, seconds)) => {
                        failed += without;
                        simulated_s += seconds;
                    }
                    Err(refusal) => {
                        stop.store(true, Ordering::Relaxed);
                        closed = Err(refusal);
                    }
                }
                Ok(())
            });
            closed?;
            worked?;
            Ok((failed, simulated_s))
        });
        drop(stopping);
        answer
    }

    /// Makes sure that everything is on the disk, and gives the files back.
    fn close(&self) -> PyResult<()> {
        let driver = self.slot().take();
        driver
            .map_or(Ok(()), |driver| driver.sync())
            .map_err(refused)
    }
}
