//! How a machine's drives are tuned: margins of every loop, limit cycles; and what is not good
//! enough.

use super::document::{Change, ChangedText, Document};
use super::problem::MachineError;
use super::{Machine, MachineAxis};
use lostmotion_analysis::{
    AxisAnalysis, Cycle, Feedback, LimitCycle, analyse, limit_cycle, simulated_cycle,
};
use lostmotion_base::AxisId;
use lostmotion_methods::AxisConfig;

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
        // Only a sound file has loops to analyse; faults point at the gain that has to be cut.
        let tuning = machine.tuning();
        let loops: Vec<&AxisAnalysis> = tuning.iter().map(|tuning| &tuning.loops).collect();
        refuse_faults(name, &ChangedText::new(text, changes), &machine, &loops)?;
        Ok((machine, tuning))
    }

    /// Reads a machine file and refuses unstable loops and small margins; without a look at cycles,
    /// which takes longer than all else.
    pub(crate) fn from_stable_toml(name: &str, text: &str) -> Result<Machine, MachineError> {
        let machine = Machine::from_toml(name, text)?;
        // Axes are often alike.
        let mut known: Vec<(&AxisConfig, AxisAnalysis)> = Vec::new();
        for axis in machine.axes() {
            if !known.iter().any(|(config, _)| **config == axis.config) {
                known.push((&axis.config, analyse(&axis.config)));
            }
        }
        let of = |axis: &MachineAxis| {
            let found = known.iter().find(|(config, _)| **config == axis.config);
            found.map(|(_, loops)| loops)
        };
        let loops: Vec<&AxisAnalysis> = machine.axes().iter().filter_map(of).collect();
        refuse_faults(name, &ChangedText::new(text, &[]), &machine, &loops)?;
        Ok(machine)
    }
}

/// Refuses a machine with an unstable loop, or one whose margins are below the file's.
fn refuse_faults(
    name: &str,
    text: &ChangedText,
    machine: &Machine,
    loops: &[&AxisAnalysis],
) -> Result<(), MachineError> {
    let document = Document::parse(text).map_err(|problems| MachineError::new(name, problems))?;
    let mut problems = Vec::new();
    for (axis, loops) in machine.axes().iter().zip(loops) {
        if let Some(fault) = loops.fault(&axis.config) {
            let key = format!(
                "axis.{}.drive.{}",
                axis.id.letter().to_ascii_lowercase(),
                fault.at().kind.gain_key()
            );
            problems.push(document.problem(&key, fault.to_string(), fault.hint()));
        }
    }
    if problems.is_empty() {
        Ok(())
    } else {
        Err(MachineError::new(name, problems))
    }
}
