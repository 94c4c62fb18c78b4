//! One cell: a program on a machine with values of its own, and the figures that come of it.

use crate::error::SweepError;
use crate::inputs::Inputs;
use crate::key::Key;
use crate::manifest::Cell;
use lostmotion_report::refusal::Refusal;
use lostmotion_sim::results::{ErrorStats, MethodResult, Run};
use lostmotion_sim::{Machine, SimulateOptions, Simulation};
use serde::{Deserialize, Serialize};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// What came of a cell: a line of a file of results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct CellResult {
    /// The cell.
    pub key: Key,
    /// Its figures, or why there are none.
    #[serde(flatten)]
    pub outcome: Outcome,
}

/// Figures, or why there are none.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Outcome {
    /// It ran.
    Figures(Figures),
    /// It could not be run.
    Error(Failed),
}

/// The figures of a cell. A number that is not known is `None`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Figures {
    /// Duration of the program, s.
    pub duration_s: Option<f64>,
    /// Length of cutting moves, mm.
    pub cutting_mm: Option<f64>,
    /// Tolerance of the verdict, um.
    pub tolerance_um: Option<f64>,
    /// Contour error of the same machine without a gap, um: largest, and RMS.
    pub without_gap_um: [Option<f64>; 2],
    /// The method that is recommended, where they were tried with gap and friction told wrong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recommended: Option<String>,
    /// How each method did.
    pub methods: Vec<MethodFigures>,
}

/// How a method did in a cell; errors of cutting moves in um.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MethodFigures {
    /// Its name.
    pub method: String,
    /// Largest contour error.
    pub max_um: Option<f64>,
    /// Its RMS.
    pub rms_um: Option<f64>,
    /// Its 99th percentile.
    pub p99_um: Option<f64>,
    /// What backlash adds, at most.
    pub backlash_max_um: Option<f64>,
    /// RMS of what backlash adds.
    pub backlash_rms_um: Option<f64>,
    /// Largest contour error of rapids.
    pub rapid_max_um: Option<f64>,
    /// Line of the worst block, from 1; 0 if there is none.
    pub worst_line: u32,
    /// Whether the part is within its tolerance and the machine is not stopped.
    pub within: bool,
    /// What stops the machine, if it is stopped; figures are of what was before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop: Option<String>,
}

/// Why a cell could not be run.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Failed {
    /// Stable name of the reason.
    pub code: String,
    /// What is wrong, with place and values.
    pub message: String,
}

/// JSON has no NaN and no infinity.
fn known(number: f64) -> Option<f64> {
    number.is_finite().then_some(number)
}

impl MethodFigures {
    fn of(result: &MethodResult) -> MethodFigures {
        let ErrorStats { max, rms, p99, .. } = result.cutting;
        MethodFigures {
            method: result.method.clone(),
            max_um: known(max),
            rms_um: known(rms),
            p99_um: known(p99),
            backlash_max_um: known(result.backlash.max),
            backlash_rms_um: known(result.backlash.rms),
            rapid_max_um: known(result.rapid.max),
            worst_line: result.blocks().next().map_or(0, |block| block.line),
            within: result.within_tolerance,
            stop: result.stop.as_ref().map(|stop| {
                let line = stop.block.span.line;
                format!("{} of {} in line {line}", stop.limit, stop.motor())
            }),
        }
    }
}

impl Figures {
    fn of(run: &Run, is_recommended: bool) -> Figures {
        Figures {
            duration_s: known(run.plan.duration_s),
            cutting_mm: known(run.plan.cutting_mm),
            tolerance_um: known(run.tolerance_um),
            without_gap_um: [run.without_gap.max, run.without_gap.rms].map(known),
            recommended: run.recommended.clone().filter(|_| is_recommended),
            methods: run.results.iter().map(MethodFigures::of).collect(),
        }
    }
}

/// What programs and machines are called in the messages of a cell: their own names are no part of
/// its key.
const PROGRAM: &str = "program";
const MACHINE: &str = "machine";

/// Runs a cell. What is wrong with it is its result: it would go wrong again.
///
/// # Errors
/// A program that cannot be read any more, which says nothing of the cell.
pub fn run_cell(inputs: &Inputs, cell: &Cell) -> Result<CellResult, SweepError> {
    // A fault in the program itself must not end a sweep of days either.
    let figures = catch_unwind(AssertUnwindSafe(|| figures(inputs, cell)));
    let failed = |code: &str, message: &str| {
        Outcome::Error(Failed {
            code: code.to_owned(),
            message: message.trim_end().to_owned(),
        })
    };
    let outcome = match figures {
        Ok(Ok(figures)) => Outcome::Figures(figures),
        Ok(Err(refusal)) if refusal.code == "read" => {
            return Err(SweepError::value(refusal.message, refusal.hint));
        }
        Ok(Err(refusal)) => {
            let name = inputs.header.program(cell);
            match refusal.message.strip_prefix(name) {
                Some(rest) => failed(&refusal.code, &format!("{PROGRAM}{rest}")),
                None => failed(&refusal.code, &refusal.message),
            }
        }
        Err(_panic) => failed(
            "internal",
            "the run ended by a fault of the program; please report it",
        ),
    };
    Ok(CellResult {
        key: cell.key,
        outcome,
    })
}

fn figures(inputs: &Inputs, cell: &Cell) -> Result<Figures, Refusal> {
    let missing = || Refusal::data("its program or machine is not at hand", "");
    let program = inputs.programs.get(cell.program).and_then(Option::as_ref);
    let program = program.ok_or_else(missing)?;
    let text = inputs.machines.get(cell.machine).ok_or_else(missing)?;
    let changes = inputs.header.changes(&cell.values);
    let machine = Machine::from_changed_toml(MACHINE, &text.toml, &changes)?;
    let options: SimulateOptions = inputs.reading().options(&machine, inputs.options.clone())?;
    // Without the runs that a recommendation rests on there is none.
    let is_recommended = options.misled_share.is_some_and(|share| share > 0.0);
    let run = Simulation::new(program, &machine)
        .options(options)
        .methods(&inputs.header.methods)
        .run()
        .map_err(|error| Refusal::of_run(&error, program))?;
    Ok(Figures::of(&run, is_recommended))
}
