//! The first pass: the whole program is read and held against the machine before anything is
//! simulated, so that all its errors are reported together.

use super::curves::plan_item;
use super::reader::Reader;
use super::steer::Modes;
use super::steer::Read;
use super::travel::Excesses;
use crate::error::SimError;
use crate::machine::Machine;
use crate::options::SimulateOptions;
use crate::program::Program;
use crate::results::{PlanInfo, ProgramInfo};
use crate::setup::Setup;
use lostmotion_base::AxisSet;
use lostmotion_gcode::{Diagnostic, Diagnostics, Problem, Severity, SourceFiles};
use lostmotion_plan::{FeedLimit, Move, PlanItem, PlannerConfig, Quality, TravelCheck};
use std::sync::Arc;

/// The largest cutting force, N. A choice: far more than any machine stands, far below an overflow.
const LARGEST_FORCE_N: f64 = 1e6;

/// What the first pass learns.
#[derive(Clone, Debug, Default)]
pub(crate) struct Checked {
    pub(crate) program: ProgramInfo,
    /// Lengths only.
    pub(crate) plan: PlanInfo,
    /// Files of subroutines that were read.
    pub(crate) files: SourceFiles,
}

/// The planner's settings for a machine.
pub(crate) fn planner_config(machine: &Machine, quality: Quality) -> PlannerConfig {
    let mut limits = [None; lostmotion_base::AXES];
    for axis in machine.axes() {
        limits[axis.id.index()] = Some(axis.limits);
    }
    let settings = machine.planner();
    PlannerConfig {
        clock: machine.cycles().command(),
        quality,
        default_tolerance_mm: settings.default_tolerance_mm,
        exact_path_tolerance_mm: settings.exact_path_tolerance_mm,
        exact_path_angle_deg: settings.exact_path_angle_deg,
        ..PlannerConfig::new(limits)
    }
}

struct Pass<'a> {
    setup: &'a Setup<'a>,
    /// Without tool-centre-point control, and with it.
    travel: [TravelCheck; 2],
    words: AxisSet,
    excesses: Excesses,
    problems: Vec<Diagnostic>,
    moves: u64,
    plan: PlanInfo,
}

/// Reads the program to its end.
///
/// # Errors
/// Everything that is wrong with the program, or all moves beyond the machine's travel.
pub(crate) fn check(setup: &Setup<'_>) -> Result<Checked, SimError> {
    let (machine, options) = (setup.machine, setup.options);
    // Options before the program: a wrong number must not cost the reading of a large file.
    check_options(options)?;
    let mut reader = Reader::new(setup)?;
    let modes = Modes::new(&setup.kinematics);
    let config = planner_config(machine, options.quality);
    // Moves are held against the travel with the kinematics of their coordinates.
    let travel =
        [false, true].map(|tip| TravelCheck::new(&config, Arc::clone(modes.kinematics(tip))));
    let words = modes
        .kinematics(true)
        // A machine whose joints have other letters than its words says which words it takes.
        .layout()
        .map_or_else(|| machine.axis_set(), |layout| layout.words);
    let plan = PlanInfo::default();
    let mut pass = Pass {
        setup,
        travel,
        words,
        excesses: Excesses::default(),
        problems: Vec::new(),
        moves: 0,
        plan,
    };
    while let Some(item) = reader.next() {
        match item {
            Ok(read) => pass
                .item(&read, reader.system())
                .map_err(|error| error.with_provenance(reader.diagnostics()))?,
            Err((problem, place)) => pass.problems.push(Diagnostic { problem, place }),
        }
        // More problems would not be shown; a hostile program must not fill the memory.
        if pass.problems.len() >= options.limits.diagnostics {
            break;
        }
    }
    // One warning for all moves in step with the spindle: its speed is assumed, not simulated.
    if let Some(place) = reader.synchronised() {
        pass.problems.push(Diagnostic {
            problem: Problem::SpindleAssumed,
            place,
        });
    }
    pass.finish(reader.diagnostics(), options)
}

impl Pass<'_> {
    fn item(&mut self, read: &Read, system: u16) -> Result<(), SimError> {
        let Some(PlanItem::Move(item)) = plan_item(&read.item)? else {
            return Ok(());
        };
        self.moves += 1;
        // Lengths of the program as it stands, before blending shortens corners.
        match item.feed {
            FeedLimit::Rapid => self.plan.rapid_mm += tip_length(&item),
            _ => self.plan.cutting_mm += tip_length(&item),
        }
        // An axis that stays at its place may be named: posts write A0 on three-axis machines, too.
        for axis in lostmotion_base::AxisId::ALL {
            if !self.words.contains(axis) && item.curve.end()[axis] != item.curve.start()[axis] {
                return Err(SimError::NoAxis {
                    block: item.block,
                    axis,
                    machine: self.setup.machine.name().to_owned(),
                    provenance: Box::default(),
                });
            }
        }
        // The whole curve is held against the travel, not its ends alone: an arc bulges beyond
        // them.
        let travel = &mut self.travel[usize::from(read.tip)];
        travel.push(&item)?;
        let found = travel.take_violations();
        self.excesses.add(self.setup.machine, system, &found);
        Ok(())
    }

    fn finish(self, found: &Diagnostics, options: &SimulateOptions) -> Result<Checked, SimError> {
        let name = self.setup.program.name().to_owned();
        let mut diagnostics = found.clone();
        for problem in self.problems {
            diagnostics.push(problem);
        }
        // Errors of the text go first: places beyond the travel may follow from them.
        if diagnostics.errors() > 0 {
            return Err(SimError::Program {
                name,
                diagnostics: Box::new(diagnostics),
            });
        }
        if !self.excesses.is_empty() {
            let error = self.excesses.error(self.setup);
            return Err(error.with_provenance(&diagnostics));
        }
        let setup = self.setup;
        let unreadable = |source| setup.unreadable(source);
        let bytes = setup.program.len().map_err(unreadable)?;
        // Loops make blocks and lines differ: lines are counted in the file.
        let lines = count_lines(setup.program).map_err(unreadable)?;
        if self.moves == 0 {
            return Err(SimError::Empty { name, bytes, lines });
        }
        let warning = |d: &&Diagnostic| d.severity() == Severity::Warning;
        let warnings = diagnostics
            .kept()
            .iter()
            .filter(warning)
            .take(options.limits.diagnostics)
            .map(ToString::to_string)
            .collect();
        let files = diagnostics.files().clone();
        let names = files.iter().map(|file| file.name.clone()).collect();
        Ok(Checked {
            program: ProgramInfo {
                name,
                bytes,
                lines,
                moves: self.moves,
                warnings,
                files: names,
            },
            plan: self.plan,
            files,
        })
    }
}

/// Path of the tip, mm.
fn tip_length(item: &Move) -> f64 {
    if item.curve.moves_tip() {
        item.curve.length()
    } else {
        0.0
    }
}

fn count_lines(source: &Program) -> std::io::Result<u64> {
    let mut reader = source.open()?;
    let (mut lines, mut unfinished) = (0, false);
    loop {
        let buffer = reader.fill_buf()?;
        if buffer.is_empty() {
            return Ok(lines + u64::from(unfinished));
        }
        // A last line without a line feed counts, too.
        lines += buffer.iter().filter(|byte| **byte == b'\n').count() as u64;
        unfinished = buffer.last() != Some(&b'\n');
        let length = buffer.len();
        reader.consume(length);
    }
}

/// Bounds of the tolerance of splines, mm: below, a spline takes more curves than memory holds.
/// The same as of the planner's own tolerance.
const SPLINE_TOLERANCES_MM: (f64, f64) = (1e-6, 100.0);

fn check_options(options: &SimulateOptions) -> Result<(), SimError> {
    const FROM_TO_UM: &str = "a positive finite number, from 0.001 to 1e6";
    // Bounds of the machine file's own keys. Asked for the good range, which NaN is outside of.
    let within = |what, value: f64, (low, high), condition| {
        if value >= low && value <= high {
            Ok(())
        } else {
            Err(SimError::Option {
                what,
                value,
                condition,
            })
        }
    };
    // An infinite bound would let a program run or a chunk grow without end.
    let positive = |what, value: f64| {
        if value.is_finite() && value > 0.0 {
            Ok(())
        } else {
            Err(SimError::Option {
                what,
                value,
                condition: "a positive finite number",
            })
        }
    };
    if let Some(tolerance_um) = options.tolerance_um {
        within("tolerance_um", tolerance_um, (1e-3, 1e6), FROM_TO_UM)?;
    }
    if let Some(force_n) = options.cutting_force_n {
        let bounds = (0.0, LARGEST_FORCE_N);
        within("cutting_force_n", force_n, bounds, "a number from 0 to 1e6")?;
    }
    if let Some(limit_um) = options.bow_limit_um {
        within("bow_limit_um", limit_um, (1e-3, 1e6), FROM_TO_UM)?;
    }
    if let Some(share) = options.misled_share {
        within(
            "misled_share",
            share,
            (0.0, 0.95),
            "a number from 0 to 0.95",
        )?;
    }
    positive("reversal_window_s", options.reversal_window_s)?;
    positive("max_duration_s", options.max_duration_s)?;
    within(
        "spline_tolerance_mm",
        options.spline_tolerance_mm,
        SPLINE_TOLERANCES_MM,
        "a positive finite number, from 1e-6 to 100",
    )?;
    positive("chunk_samples", options.chunk_samples as f64)
}
