//! How a machine's drives are tuned: margins of every loop, limit cycles; and what is not good
//! enough.

use super::document::{Change, ChangedText, Document};
use super::problem::MachineError;
use super::{Machine, MachineAxis};
use lostmotion_analysis::{
    AxisAnalysis, Cycle, Feedback, LimitCycle, analyse, limit_cycle, simulated_cycle,
};
use lostmotion_base::AxisId;

/// Tuning of one axis.
#[derive(Clone, Debug, PartialEq)]
pub struct AxisTuning {
    /// The axis.
    pub axis: AxisId,
    /// Margins of its loops, and its delays.
    pub loops: AxisAnalysis,
    /// The limit cycle that the describing function predicts, position loop on the motor or, with
    /// the method `load-feedback`, on the load.
    pub predicted: LimitCycle,
    /// The limit cycle that the simulated axis is in after a push, in the axis' unit.
    pub simulated: Option<Cycle>,
}

impl AxisTuning {
    /// The tuning of an axis.
    pub fn of(axis: &MachineAxis) -> AxisTuning {
        let config = &axis.config;
        // A loop that is closed on the load has the gap inside.
        let feedback = if config.compensation.method.closes_on_load() {
            Feedback::Load
        } else {
            Feedback::Motor
        };
        AxisTuning {
            axis: axis.id,
            loops: analyse(config),
            predicted: limit_cycle(config, feedback),
            simulated: simulated_cycle(config, feedback),
        }
    }
}

impl Machine {
    /// The tuning of every axis.
    pub fn tuning(&self) -> Vec<AxisTuning> {
        self.axes().iter().map(AxisTuning::of).collect()
    }

    /// Reads a machine file as [`Machine::from_toml`] does, and looks at its tuning.
    ///
    /// # Errors
    /// Everything that is wrong with the file; if nothing is, every axis with an unstable loop or
    /// one whose margins are below the file's `least_margins`, with the loop and its margin.
    pub fn check_toml(name: &str, text: &str) -> Result<(Machine, Vec<AxisTuning>), MachineError> {
        Machine::check_changed_toml(name, text, &[])
    }

    /// The same with values in place of the file's own, as [`Machine::from_changed_toml`].
    ///
    /// # Errors
    /// As [`Machine::check_toml`].
    pub fn check_changed_toml(
        name: &str,
        text: &str,
        changes: &[Change],
    ) -> Result<(Machine, Vec<AxisTuning>), MachineError> {
        let machine = Machine::from_changed_toml(name, text, changes)?;
        let changed = ChangedText::new(text, changes);
        let document =
            Document::parse(&changed).map_err(|problems| MachineError::new(name, problems))?;
        // Only a sound file has loops to analyse; faults point at the gain that has to be cut.
        let tuning = machine.tuning();
        let mut problems = Vec::new();
        for (axis, tuning) in machine.axes().iter().zip(&tuning) {
            if let Some(fault) = tuning.loops.fault(&axis.config) {
                let key = format!(
                    "axis.{}.drive.{}",
                    axis.id.letter().to_ascii_lowercase(),
                    fault.at().kind.gain_key()
                );
                problems.push(document.problem(&key, fault.to_string(), fault.hint()));
            }
        }
        if problems.is_empty() {
            Ok((machine, tuning))
        } else {
            Err(MachineError::new(name, problems))
        }
    }
}
