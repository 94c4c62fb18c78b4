//! G4.

use super::Exec;
use crate::code::Code;
use crate::ops::CanonicalOp;
use crate::problem::Problem;

/// G4 P.
pub(crate) fn dwell(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let seconds = exec.need(b'P', code, "P, the seconds to wait")?;
    exec.pause(seconds)
}

impl Exec<'_> {
    /// A dwell of a checked length.
    pub(crate) fn pause(&mut self, seconds: f64) -> Result<(), Problem> {
        let limit = self.config.limits.dwell_s;
        if seconds < 0.0 {
            self.warnings.push(Problem::NegativeDwell { seconds });
        }
        if seconds > limit {
            return Err(Problem::DwellTooLong { seconds, limit });
        }
        self.emit(CanonicalOp::Dwell(seconds));
        Ok(())
    }
}
