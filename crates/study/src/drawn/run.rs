//! Cells through the session that users run, and their figures.

use super::cell::{DrawnCell, Traits, draw};
use crate::error::StudyError;
use lostmotion_methods::MethodId;
use lostmotion_sim::{ContourPoint, Observer, Program, Run, Simulation};
use rayon::prelude::*;

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
    /// Over the whole program.
    pub whole: Part,
    /// Over the second half of its time.
    pub second_half: Part,
    /// Over the whole program, told its axes wrong: the largest of each figure.
    pub misled: Part,
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
    /// `none` first.
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

/// Sums of one second of a method's motion.
#[derive(Clone, Copy, Debug, Default)]
struct Second {
    count: u64,
    backlash_squares: f64,
    contour_squares: f64,
    backlash_max: f64,
    contour_max: f64,
}

/// Adds up seconds, so that halves can be told apart when the end is known.
struct Seconds(Vec<Vec<Second>>);

impl Observer for Seconds {
    fn contour(&mut self, method: usize, points: &[ContourPoint]) {
        let Some(seconds) = self.0.get_mut(method) else {
            return;
        };
        for point in points.iter().filter(|point| point.moving && !point.rapid) {
            let second = point.time_s.max(0.0) as usize;
            if seconds.len() <= second {
                seconds.resize(second + 1, Second::default());
            }
            if let Some(sums) = seconds.get_mut(second) {
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
}

/// The figures of some seconds.
fn part(seconds: &[Second]) -> Part {
    let sum = |of: fn(&Second) -> f64| seconds.iter().map(of).sum::<f64>();
    let max = |of: fn(&Second) -> f64| seconds.iter().map(of).fold(0.0, f64::max);
    let count = (seconds.iter().map(|second| second.count).sum::<u64>() as f64).max(1.0);
    Part {
        backlash_rms: (sum(|second| second.backlash_squares) / count).sqrt(),
        backlash_max: max(|second| second.backlash_max),
        contour_rms: (sum(|second| second.contour_squares) / count).sqrt(),
        contour_max: max(|second| second.contour_max),
    }
}

/// Runs a cell with `none` and these methods.
///
/// # Errors
/// An unknown method; whatever stops the chain.
pub fn run(cell: &DrawnCell, methods: &[String]) -> Result<DrawnResult, StudyError> {
    let inside = |source: StudyError| StudyError::Cell {
        id: cell.name.clone(),
        source: Box::new(source),
    };
    let names: Vec<&str> = std::iter::once(MethodId::NONE.name())
        .chain(methods.iter().map(String::as_str))
        .collect();
    let program = Program::from_str(cell.name.clone(), cell.program.clone());
    let mut seconds = Seconds(vec![Vec::new(); names.len()]);
    let run = Simulation::new(&program, &cell.machine)
        .methods(names)
        .observer(&mut seconds)
        .run()
        .map_err(|error| inside(error.into()))?;
    Ok(figures(cell, &run, &seconds.0))
}

fn figures(cell: &DrawnCell, run: &Run, seconds: &[Vec<Second>]) -> DrawnResult {
    let methods = run.results.iter().zip(seconds).map(|(result, seconds)| {
        let mut misled = Part::default();
        for run in &result.misled {
            misled.backlash_rms = misled.backlash_rms.max(run.backlash.rms);
            misled.backlash_max = misled.backlash_max.max(run.backlash.max);
            misled.contour_rms = misled.contour_rms.max(run.cutting.rms);
            misled.contour_max = misled.contour_max.max(run.cutting.max);
        }
        DrawnFigures {
            method: result.method.clone(),
            whole: Part {
                backlash_rms: result.backlash.rms,
                backlash_max: result.backlash.max,
                contour_rms: result.cutting.rms,
                contour_max: result.cutting.max,
            },
            second_half: part(seconds.get(seconds.len() / 2..).unwrap_or_default()),
            misled,
        }
    });
    DrawnResult {
        name: cell.name.clone(),
        traits: cell.traits,
        duration_s: run.plan.duration_s,
        methods: methods.collect(),
        recommended: run.recommended.clone(),
    }
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
