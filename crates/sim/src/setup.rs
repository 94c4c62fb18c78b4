//! What a run is about.

use crate::error::SimError;
use crate::machine::Machine;
use crate::options::{MAX_THREADS, SimulateOptions};
use crate::program::Program;
use lostmotion_base::threads;
use lostmotion_kinematics::{Kinematics, TipControl};
use std::sync::Arc;

/// A program, a machine, and how the one is to run on the other.
pub(crate) struct Setup<'a> {
    pub(crate) program: &'a Program,
    pub(crate) machine: &'a Machine,
    pub(crate) options: &'a SimulateOptions,
    /// The machine's kinematics, or the caller's own.
    pub(crate) kinematics: Arc<dyn Kinematics>,
    pub(crate) tip_control: TipControl,
}

impl<'a> Setup<'a> {
    /// With kinematics of the caller's own, or the machine's.
    ///
    /// # Errors
    /// Kinematics that cannot be built; `None` for a checked machine.
    pub(crate) fn new(
        program: &'a Program,
        machine: &'a Machine,
        options: &'a SimulateOptions,
        own: Option<&Arc<dyn Kinematics>>,
    ) -> Result<Setup<'a>, SimError> {
        if let Some(memory) = &options.learned {
            memory.check(machine)?;
        }
        Ok(Setup {
            program,
            machine,
            options,
            kinematics: match own {
                Some(own) => Arc::clone(own),
                None => Arc::from(machine.build_kinematics()?),
            },
            tip_control: machine.kinematics().tip_control(),
        })
    }

    /// The program cannot be read.
    pub(crate) fn unreadable(&self, source: std::io::Error) -> SimError {
        SimError::Read {
            name: self.program.name().to_owned(),
            source,
        }
    }

    /// Calls `work` with the number of threads of the run: with 1 on the caller's thread; else inside
    /// a pool of its own with that many (0: one per core), entered once.
    ///
    /// # Errors
    /// A pool that cannot be made; what the work answers.
    pub(crate) fn on_threads<T: Send>(
        &self,
        work: impl FnOnce(usize) -> Result<T, SimError> + Send,
    ) -> Result<T, SimError> {
        let threads = self.options.threads;
        // Without a pool a run may itself be a job of the caller's pool, hundreds at a time.
        if threads == 1 {
            return work(1);
        }
        if threads > MAX_THREADS {
            let why = format!("allowed are 0 (one per core) to {MAX_THREADS}");
            return Err(SimError::Threads { threads, why });
        }
        threads::pool(threads, work).map_err(|why| SimError::Threads { threads, why })?
    }
}
