//! What ends a study without a result.

use lostmotion_contour::ContourError;
use lostmotion_drive::AxisError;
use lostmotion_sim::SimError;
use lostmotion_sim::machine::MachineError;

/// Why a study has no result.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StudyError {
    /// A number of cells that cannot be sampled.
    #[error(
        "{asked} cells were asked for; it has to be 1 to {most}, or all {all} of the full factorial"
    )]
    Cells {
        /// The number asked for.
        asked: usize,
        /// The largest sample.
        most: usize,
        /// Cells of the full factorial.
        all: usize,
    },
    /// A name that is no cell's.
    #[error("there is no cell `{id}`: {reason}")]
    CellName {
        /// The name.
        id: String,
        /// What is wrong with it.
        reason: String,
    },
    /// The study's own machine is not accepted.
    #[error("the machine of the study: {0}")]
    Machine(#[from] MachineError),
    /// A cell cannot be run.
    #[error("cell {id}: {source}")]
    Cell {
        /// Which.
        id: String,
        /// Why.
        source: Box<StudyError>,
    },
    /// The chain stopped.
    #[error(transparent)]
    Sim(#[from] SimError),
    /// An axis stopped.
    #[error(transparent)]
    Axis(#[from] AxisError),
    /// A contour error cannot be measured.
    #[error(transparent)]
    Contour(#[from] ContourError),
    /// No threads.
    #[error("cannot start {threads} threads: {why}")]
    Threads {
        /// How many were asked for.
        threads: usize,
        /// What the system says.
        why: String,
    },
    /// A journal of another study.
    #[error(
        "the results there are of another study: {what} is {there}, now {here}; take another folder, or start afresh"
    )]
    OtherStudy {
        /// What differs.
        what: &'static str,
        /// Its value in the journal.
        there: String,
        /// Its value now.
        here: String,
    },
    /// A journal that cannot be read.
    #[error("line {line} of the results is broken ({reason}); take it out, or start afresh")]
    Journal {
        /// Line, from 1.
        line: usize,
        /// What is wrong.
        reason: String,
    },
    /// The sink has refused a result.
    #[error("{0}")]
    Sink(String),
}
