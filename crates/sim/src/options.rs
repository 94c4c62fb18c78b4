//! Settings of a run.

use crate::control::Control;
use crate::machine::{BOW_LIMIT_UM, Machine, Memory};
use lostmotion_contour::ContourConfig;
use lostmotion_drive::config::Interpolator;
use lostmotion_gcode::motion::SPLINE_TOLERANCE_MM;
use lostmotion_gcode::{
    Code, Dialect, InterpreterConfig, Leniencies, Limits, MCodeUse, SubroutineLoader, ToolTable,
};
use lostmotion_plan::{Action, Quality};
use std::collections::BTreeMap;
use std::sync::Arc;

/// What an operator does at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Intervention {
    /// Time since the start of the program, s; taken to the nearest command cycle.
    pub at_s: f64,
    /// What is done.
    pub action: Action,
}

/// Settings of a run: what to judge by, what to keep, and the bounds of every resource.
#[derive(Clone, Debug)]
pub struct SimulateOptions {
    /// Tolerance of the verdict, um; the machine's own if `None`.
    pub tolerance_um: Option<f64>,
    /// Size of the cutting force on feed moves, N; the machine's own if `None`.
    pub cutting_force_n: Option<f64>,
    /// Largest distance of the tool from its way between two commands that are joined by straight
    /// lines of the joints, um, that is not warned of; the machine's own if `None`.
    pub bow_limit_um: Option<f64>,
    /// Threads: 1 stays on the caller's thread; more make a pool for the run, 0 one with a thread
    /// per core. The result does not depend on it.
    pub threads: usize,
    /// How many of the worst blocks a result lists.
    pub keep_blocks: usize,
    /// How many of the worst reversals a result lists.
    pub keep_reversals: usize,
    /// How long after a reversal an error counts as caused by it, s.
    pub reversal_window_s: f64,
    /// Longest motion simulated, s; beyond it the run ends with an error.
    pub max_duration_s: f64,
    /// Samples (a command cycle each) that go through the stages at a time. The result does not
    /// depend on it.
    pub chunk_samples: usize,
    /// How the foot point on the contour is searched.
    pub contour: ContourConfig,
    /// Whether blocks that begin with `/` are skipped.
    pub block_delete: bool,
    /// Which of `/1` to `/9` are skipped, `/` being `/1`; as `block_delete` says if `None`.
    pub block_skips: Option<Vec<u8>>,
    /// What M codes of the machine's builder do.
    pub m_codes: BTreeMap<Code, MCodeUse>,
    /// Values that only the machine knows: numbers or names of parameters and system variables.
    pub told: Vec<(String, f64)>,
    /// Tools, in place of the machine's own.
    pub tool_table: Option<ToolTable>,
    /// How far the polynomials may lie from the splines (G5, G5.1, G5.2) that they stand for,
    /// mm.
    pub spline_tolerance_mm: f64,
    /// By how much gap, friction and stiffness are told wrong in the runs that a recommendation
    /// rests on, as part of the true value: below 1, 0 for no such runs. `None` for 0.3 where
    /// methods are compared, and no such runs of one method alone.
    pub misled_share: Option<f64>,
    /// The control among whose functions a method is recommended; the machine's own if `None`.
    pub control: Option<Control>,
    /// What methods that learn start from; `None` where they know nothing.
    pub learned: Option<Arc<Memory>>,
    /// How much work the planner puts into a shorter time.
    pub quality: Quality,
    /// What an operator does while the program runs: feed hold, resume, override, stop; in the
    /// order of their times.
    pub interventions: Vec<Intervention>,
    /// Bounds of the G-code front end.
    pub limits: Limits,
    /// Dialect of the program; the machine's own if `None`.
    pub dialect: Option<Dialect>,
    /// What is accepted with a warning; what the dialect accepts if `None`.
    pub leniencies: Option<Leniencies>,
    /// Where subroutines come from that the program does not define; from nowhere if `None`.
    pub loader: Option<Arc<dyn SubroutineLoader>>,
}

/// Most threads that a run may be given: far above the cores of any machine, and low enough that
/// the system makes them at once. 65,535 threads, the pool's own bound, take minutes to start.
pub const MAX_THREADS: usize = 1024;

impl Default for SimulateOptions {
    fn default() -> SimulateOptions {
        let interpreter = InterpreterConfig::default();
        SimulateOptions {
            tolerance_um: None,
            cutting_force_n: None,
            bow_limit_um: None,
            threads: 1,
            keep_blocks: 10,
            keep_reversals: 20,
            reversal_window_s: 0.1,
            max_duration_s: 7.0 * 86_400.0,
            chunk_samples: 1000,
            contour: ContourConfig::default(),
            block_delete: interpreter.block_delete,
            block_skips: interpreter.block_skips,
            m_codes: interpreter.m_codes,
            told: interpreter.told,
            tool_table: None,
            spline_tolerance_mm: SPLINE_TOLERANCE_MM,
            misled_share: None,
            control: None,
            learned: None,
            quality: Quality::default(),
            interventions: Vec::new(),
            limits: interpreter.limits,
            dialect: None,
            leniencies: None,
            loader: None,
        }
    }
}

/// How far the tool may be off its way between two commands that drives join by straight lines of
/// the joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BowLimit {
    /// Distance, um.
    pub um: f64,
    /// Whether the motion is planned to keep it; else there is a warning where it does not.
    pub is_kept: bool,
}

impl BowLimit {
    /// Kept where the options or the machine name one, and where a drive joins commands by straight
    /// lines.
    pub fn new(machine: &Machine, options: &SimulateOptions) -> BowLimit {
        let told = options.bow_limit_um.or(machine.simulate().bow_limit_um);
        // These drives really do go straight from command to command.
        let is_linear = machine
            .axes()
            .iter()
            .any(|axis| axis.config.interpolator == Interpolator::Linear);
        BowLimit {
            um: told.unwrap_or(BOW_LIMIT_UM),
            is_kept: told.is_some() || is_linear,
        }
    }
}
