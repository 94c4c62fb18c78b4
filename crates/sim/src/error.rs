//! What ends a run without a result.

use crate::machine::MachineError;
use lostmotion_base::units::{deg, number};
use lostmotion_base::{AxisId, BlockRef};
use lostmotion_contour::ContourError;
use lostmotion_drive::AxisError;
use lostmotion_gcode::{Diagnostics, Provenance};
use lostmotion_kinematics::KinematicsError;
use lostmotion_methods::UnknownMethod;
use lostmotion_path::PathError;
use lostmotion_plan::PlanError;
use std::fmt;

/// Why a sink refuses what it is given.
pub type SinkError = Box<dyn std::error::Error + Send + Sync>;

/// The moves that take a joint beyond one end of its travel.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct TravelExcess {
    /// The joint.
    pub joint: AxisId,
    /// Whether it turns.
    pub is_rotary: bool,
    /// The end of its travel, mm or rad, machine coordinates.
    pub limit: f64,
    /// The farthest position, mm or rad.
    pub value: f64,
    /// The block that goes there.
    pub block: BlockRef,
    /// Number of moves that go beyond this end.
    pub moves: u64,
}

impl TravelExcess {
    /// By how much the farthest position is beyond the limit, mm or rad.
    pub fn by(&self) -> f64 {
        (self.value - self.limit).abs()
    }
}

impl fmt::Display for TravelExcess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let TravelExcess { joint, .. } = self;
        let [value, limit] = [self.value, self.limit].map(|v| shown(v, self.is_rotary));
        write!(f, "axis {joint} to {value}, beyond its limit of {limit}")
    }
}

/// A position of a joint with its unit.
pub(crate) fn shown(value: f64, is_rotary: bool) -> String {
    if is_rotary {
        format!("{:.3} deg", deg(value))
    } else {
        format!("{value:.3} mm")
    }
}

/// Why there is no result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SimError {
    /// The program cannot be read.
    #[error("{name}: {source}")]
    Read {
        /// Name of the program.
        name: String,
        /// What the system says.
        source: std::io::Error,
    },
    /// The program has errors.
    #[error("{name}: {count} error{s} in the program", count = diagnostics.errors(), s = if diagnostics.errors() == 1 { "" } else { "s" })]
    Program {
        /// Name of the program.
        name: String,
        /// All that was found.
        diagnostics: Box<Diagnostics>,
    },
    /// The program has nothing to simulate.
    #[error(
        "{name}: the program moves nothing ({bytes} byte{b}, {lines} line{l} read); is it the right file?",
        b = if *bytes == 1 { "" } else { "s" },
        l = if *lines == 1 { "" } else { "s" },
    )]
    Empty {
        /// Name of the program.
        name: String,
        /// Bytes read.
        bytes: u64,
        /// Lines read.
        lines: u64,
    },
    /// The part lies outside the machine's travel.
    #[error(
        "{name}: the part does not fit the machine `{machine}`: {moves} move{s} beyond its travel, {all}; hint: {hint}",
        s = if *moves == 1 { " goes" } else { "s go" },
        all = excesses.iter().map(ToString::to_string).collect::<Vec<_>>().join(", "),
    )]
    Travel {
        /// Name of the program.
        name: String,
        /// Name of the machine.
        machine: String,
        /// Number of moves beyond it.
        moves: u64,
        /// How far each joint is beyond each end, the farthest first.
        excesses: Vec<TravelExcess>,
        /// What to do about it: which work offset to move by how much.
        hint: String,
        /// The files that their blocks stand in, and the calls that led there.
        provenance: Box<Provenance>,
    },
    /// The program moves an axis that the machine does not have.
    #[error("{}: the program moves axis {axis}, which the machine `{machine}` does not have; take a machine with that axis", block.span)]
    NoAxis {
        /// Block that moves it.
        block: BlockRef,
        /// The axis.
        axis: AxisId,
        /// Name of the machine.
        machine: String,
        /// The file that the block stands in, and the calls that led there.
        provenance: Box<Provenance>,
    },
    /// The program runs longer than allowed.
    #[error(
        "the program runs longer than {limit_s} s; raise the limit on the duration if that is meant"
    )]
    TooLong {
        /// The limit, s.
        limit_s: f64,
    },
    /// There is no method of that name.
    #[error(transparent)]
    Method(#[from] UnknownMethod),
    /// A method needs what the machine does not have.
    #[error("axis {axis}: {source}")]
    Axis {
        /// The axis.
        axis: AxisId,
        /// What the axis says.
        source: AxisError,
    },
    /// A setting that makes no sense.
    #[error("{what} is {}; it has to be {condition}", number(*value))]
    Option {
        /// Which setting: the name of its field.
        what: &'static str,
        /// Its value.
        value: f64,
        /// What it has to be.
        condition: &'static str,
    },
    /// The machine description does not hold.
    #[error(transparent)]
    Machine(#[from] MachineError),
    /// An arc that cannot be.
    #[error("{}: {source}", block.span)]
    Path {
        /// Its block.
        block: BlockRef,
        /// What is wrong.
        source: PathError,
        /// The file that the block stands in, and the calls that led there.
        provenance: Box<Provenance>,
    },
    /// The planner refuses.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The kinematics refuses.
    #[error(transparent)]
    Kinematics(#[from] KinematicsError),
    /// The contour stage was fed wrongly, or a simulated position is not a number any more.
    #[error("contour stage: {0}")]
    Contour(#[from] ContourError),
    /// What is asked for cannot be done: a recorded motion that is none of the program, a test that
    /// does not fit the machine.
    #[error("{what}{}", if hint.is_empty() { String::new() } else { format!("\nhint: {hint}") })]
    Refused {
        /// What is wrong.
        what: String,
        /// What to do; may be empty.
        hint: String,
    },
    /// The pool of threads cannot be made.
    #[error("cannot start {threads} threads: {why}")]
    Threads {
        /// How many.
        threads: usize,
        /// What the system says.
        why: String,
    },
    /// A sink has refused what it was given; carries its reason.
    #[error("{0}")]
    Sink(SinkError),
    /// The caller has ended the run.
    #[error("the run was cancelled")]
    Cancelled,
}

impl SimError {
    pub(crate) fn refused(what: impl Into<String>, hint: impl Into<String>) -> SimError {
        SimError::Refused {
            what: what.into(),
            hint: hint.into(),
        }
    }

    /// With the files and calls that the block of the error stands in.
    pub(crate) fn with_provenance(mut self, found: &Diagnostics) -> SimError {
        if let SimError::NoAxis { provenance, .. }
        | SimError::Path { provenance, .. }
        | SimError::Travel { provenance, .. } = &mut self
        {
            **provenance = found.provenance().clone();
        }
        self
    }
}
