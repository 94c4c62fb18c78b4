//! Cells through the session that users run, and their figures.

use super::cell::{DrawnCell, Traits, draw};
use super::knowledge::{Knowledge, Told};
use super::limit;
use super::moment::{AxisTruth, Moment};
use crate::error::StudyError;
use lostmotion_base::AxisId;
use lostmotion_drive::Learning;
use lostmotion_methods::{AxisConfig, MethodId};
use lostmotion_sim::machine::Memory;
use lostmotion_sim::{
    ContourPoint, ForeseenContour, Observer, Program, Run, SimulateOptions, Simulation, commission,
};
use rayon::prelude::*;
use std::sync::Arc;

/// Errors over a part of a program, um on cutting moves.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Part {
    /// RMS of what backlash causes.
    pub backlash_rms: f64,
    /// Its largest magnitude.
    pub backlash_max: f64,
    /// RMS of the contour error.
    pub contour_rms: f64,
    /// Its largest magnitude.
    pub contour_max: f64,
}

/// How a method does in a cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnFigures {
    /// Registered name.
    pub method: String,
    /// Whether its axes were commissioned before: a method that learns starts from what it learned
    /// then.
    pub warm: bool,
    /// Over the whole program.
    pub whole: Part,
    /// Over the second half of its time.
    pub second_half: Part,
    /// Over the whole program, told its axes wrong: the largest of each figure.
    pub misled: Part,
    /// Why it leaves what it leaves, of a method that learns; empty where there is no cause to
    /// name.
    pub cause: String,
    /// What it knew and when, of a method that learns.
    pub told: Vec<Told>,
    /// The same every 50 ms, with what is true.
    pub moments: Vec<Moment>,
    /// What is true of the drives.
    pub truths: Vec<AxisTruth>,
}

impl DrawnFigures {
    /// The method's name for tables: with `, warm` where it was commissioned.
    pub fn name(&self) -> String {
        let warm = if self.warm { ", warm" } else { "" };
        format!("{}{warm}", self.method)
    }
}

/// A cell and how all methods do in it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DrawnResult {
    /// The cell's name.
    pub name: String,
    /// What matters about it.
    pub traits: Traits,
    /// Length of the motion, s.
    pub duration_s: f64,
    /// The practical limit of what backlash leaves, um: RMS and largest.
    pub practical_um: [f64; 2],
    /// What `lookup` leaves that knows each axis from its first change of flank on, um: backlash RMS and largest.
    /// The least that can be left by a method that has to learn its gaps from the motors.
    pub cold_um: [f64; 2],
    /// `none` first; a method that learns cold, and then warm.
    pub methods: Vec<DrawnFigures>,
    /// What `compare` recommends.
    pub recommended: Option<String>,
}

impl DrawnResult {
    /// What the machine does without compensation.
    pub fn none(&self) -> Option<&DrawnFigures> {
        self.methods.first()
    }
}

/// Sums of an interval of a method's motion: as long as it takes from one look at what is known to the
/// next.
#[derive(Clone, Copy, Debug, Default)]
struct Interval {
    count: u64,
    backlash_squares: f64,
    contour_squares: f64,
    backlash_max: f64,
    contour_max: f64,
}

/// Looks on: adds up intervals, so that halves can be told apart when the end is known, and notes what
/// is known when.
struct Watcher {
    interval_s: f64,
    intervals: Vec<Vec<Interval>>,
    knowledge: Vec<Knowledge>,
}

impl Watcher {
    fn new(cell: &DrawnCell, methods: usize) -> Watcher {
        let names = cell.machine.drives();
        let drives = || {
            let configs = names.iter().filter_map(|name| cell.machine.drive(name));
            Knowledge::new(names.iter().cloned().zip(configs))
        };
        Watcher {
            interval_s: CHUNK_SAMPLES as f64 * cell.machine.cycles().command().period_s(),
            intervals: vec![Vec::new(); methods],
            knowledge: std::iter::repeat_with(drives).take(methods).collect(),
        }
    }
}

impl Observer for Watcher {
    fn contour(&mut self, method: usize, points: &[ContourPoint]) {
        let Some(intervals) = self.intervals.get_mut(method) else {
            return;
        };
        for point in points.iter().filter(|point| point.moving && !point.rapid) {
            let interval = (point.time_s.max(0.0) / self.interval_s) as usize;
            if intervals.len() <= interval {
                intervals.resize(interval + 1, Interval::default());
            }
            if let Some(sums) = intervals.get_mut(interval) {
                sums.count += 1;
                sums.backlash_squares += point.backlash_um * point.backlash_um;
                sums.contour_squares += point.error_um * point.error_um;
                sums.backlash_max = sums.backlash_max.max(point.backlash_um.abs());
                sums.contour_max = sums.contour_max.max(point.error_um.abs());
            }
        }
    }

    fn wants_contour(&self) -> bool {
        true
    }

    fn learning(&mut self, method: usize, time_s: f64, drives: &[Option<Learning>]) {
        if let Some(knowledge) = self.knowledge.get_mut(method) {
            knowledge.push(time_s, drives);
        }
    }

    fn foreseen(&mut self, method: usize, time_s: f64, contour: Option<&ForeseenContour>) {
        if let Some(knowledge) = self.knowledge.get_mut(method) {
            knowledge.foresee(time_s, contour);
        }
    }

    fn wants_learning(&self) -> bool {
        true
    }
}

/// The figures of some intervals.
fn part(intervals: &[Interval]) -> Part {
    let sum = |of: fn(&Interval) -> f64| intervals.iter().map(of).sum::<f64>();
    let max = |of: fn(&Interval) -> f64| intervals.iter().map(of).fold(0.0, f64::max);
    let count = (intervals.iter().map(|interval| interval.count).sum::<u64>() as f64).max(1.0);
    Part {
        backlash_rms: (sum(|interval| interval.backlash_squares) / count).sqrt(),
        backlash_max: max(|interval| interval.backlash_max),
        contour_rms: (sum(|interval| interval.contour_squares) / count).sqrt(),
        contour_max: max(|interval| interval.contour_max),
    }
}

/// Command cycles from one look at what is known to the next: 50 ms. A choice: readings come less
/// often.
const CHUNK_SAMPLES: usize = 50;

/// Runs a cell with `none` and these methods; those that learn cold, and then warm: after the axes
/// have been commissioned ([`lostmotion_sim::commission`]).
///
/// # Errors
/// An unknown method; whatever stops the chain.
pub fn run(cell: &DrawnCell, methods: &[String]) -> Result<DrawnResult, StudyError> {
    let inside = |source: StudyError| StudyError::Cell {
        id: cell.name.clone(),
        source: Box::new(source),
    };
    run_inside(cell, methods).map_err(inside)
}

fn run_inside(cell: &DrawnCell, methods: &[String]) -> Result<DrawnResult, StudyError> {
    let none = MethodId::NONE.name();
    let names: Vec<&str> = std::iter::once(none)
        .chain(methods.iter().map(String::as_str))
        .collect();
    let (run, watcher) = simulate(cell, &names, None)?;
    let mut result = DrawnResult {
        name: cell.name.clone(),
        traits: cell.traits,
        duration_s: run.plan.duration_s,
        recommended: run.recommended.clone(),
        ..DrawnResult::default()
    };
    let cold = figures(&run, watcher, false);
    let learns = |method: &str| method == MethodId::ADAPTIVE.name();
    for method in cold {
        let again = learns(&method.method).then(|| method.method.clone());
        result.methods.push(method);
        if let Some(method) = again {
            let (run, watcher) = simulate(cell, &[&method], Some(commissioned(cell)?))?;
            let warm = figures(&run, watcher, true);
            result.methods.extend(warm);
        }
    }
    let whole = result.none().map(|none| none.whole).unwrap_or_default();
    result.practical_um = limit::practical_um_of(cell, [whole.backlash_rms, whole.backlash_max])?;
    result.cold_um = cold_um_of(cell)?;
    Ok(result)
}

/// What is left of backlash if each axis is known exactly from its first change of flank on, um: RMS and
/// largest.
fn cold_um_of(cell: &DrawnCell) -> Result<[f64; 2], StudyError> {
    let mut cell = cell.clone();
    let axes: Vec<(AxisId, AxisConfig)> = cell
        .machine
        .axes()
        .iter()
        .map(|axis| (axis.id, axis.config.clone()))
        .collect();
    for (id, mut config) in axes {
        config.compensation.lookup.after_crossing = true;
        cell.machine = cell.machine.with_axis_config(id, &config);
    }
    let (run, watcher) = simulate(&cell, &[MethodId::LOOKUP.name()], None)?;
    let left = figures(&run, watcher, false).first().map(|left| left.whole);
    let left = left.unwrap_or_default();
    Ok([left.backlash_rms, left.backlash_max])
}

/// The memory of all axes, after a minute of commissioning each: axes of one contour heed each
/// other, so one that is not known would hold back the others.
///
/// # Errors
/// An axis that cannot be run.
pub fn commissioned(cell: &DrawnCell) -> Result<Memory, StudyError> {
    Ok(commission::memory(&commission::all(&cell.machine)?))
}

/// Runs a cell with methods, from a memory if there is one, and looks on.
fn simulate(
    cell: &DrawnCell,
    methods: &[&str],
    memory: Option<Memory>,
) -> Result<(Run, Watcher), StudyError> {
    let program = Program::from_str(cell.name.clone(), cell.program.clone());
    let mut watcher = Watcher::new(cell, methods.len());
    let options = SimulateOptions {
        chunk_samples: CHUNK_SAMPLES,
        learned: memory.map(Arc::new),
        ..SimulateOptions::default()
    };
    let run = Simulation::new(&program, &cell.machine)
        .methods(methods)
        .options(options)
        .observer(&mut watcher)
        .run()?;
    Ok((run, watcher))
}

fn figures(run: &Run, watcher: Watcher, warm: bool) -> Vec<DrawnFigures> {
    let watched = watcher.intervals.iter().zip(watcher.knowledge);
    let methods = run.results.iter().zip(watched);
    let figures = methods.map(|(result, (intervals, mut knowledge))| {
        let left = intervals.iter();
        knowledge.left(left.map(|left| (left.count, left.backlash_squares, left.backlash_max)));
        let mut misled = Part::default();
        for run in &result.misled {
            misled.backlash_rms = misled.backlash_rms.max(run.backlash.rms);
            misled.backlash_max = misled.backlash_max.max(run.backlash.max);
            misled.contour_rms = misled.contour_rms.max(run.cutting.rms);
            misled.contour_max = misled.contour_max.max(run.cutting.max);
        }
        DrawnFigures {
            method: result.method.clone(),
            warm,
            whole: Part {
                backlash_rms: result.backlash.rms,
                backlash_max: result.backlash.max,
                contour_rms: result.cutting.rms,
                contour_max: result.cutting.max,
            },
            second_half: part(intervals.get(intervals.len() / 2..).unwrap_or_default()),
            misled,
            cause: knowledge.cause(),
            truths: knowledge.truths().to_vec(),
            told: knowledge.told,
            moments: knowledge.moments,
        }
    });
    figures.collect()
}

/// Draws cells from a seed and runs them on a number of threads (0: one per core). The results come
/// in the order of the cells, the same to the bit for any number of threads.
///
/// # Errors
/// As [`run`], of the first cell in order that cannot be run.
pub fn run_all(
    seed: u64,
    count: u32,
    methods: &[String],
    threads: usize,
) -> Result<Vec<DrawnResult>, StudyError> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|why| StudyError::Threads {
        threads,
        why: why.to_string(),
    })?;
    let one = |index: u32| run(&draw(seed, index)?, methods);
    let results: Vec<Result<DrawnResult, StudyError>> =
        pool.install(|| (0..count).into_par_iter().map(one).collect());
    results.into_iter().collect()
}
