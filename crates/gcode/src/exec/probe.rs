//! G38.2 to G38.5.

use super::Exec;
use crate::code::Code;
use crate::ops::{CanonicalOp, StraightProbe, Units};
use crate::problem::Problem;
use crate::state::FeedMode;

/// How far before its end a probing move is taken to stop, as in LinuxCNC's stand-alone
/// interpreter: 0.254 mm.
const STOP_MM: f64 = 0.254;
/// Shortest probing move (LinuxCNC: 0.00000001 units).
const SHORTEST: f64 = 1e-8;
/// Parameters: where the probe touched, in program coordinates.
const TOUCHED: u16 = 5061;
/// Parameter: whether it touched.
const SUCCESS: u16 = 5070;

/// Probes up to the programmed end. There is no probe: #5061 to #5069 become the end, #5070 says
/// that nothing was touched, and the tool is taken to be a little before the end.
pub(crate) fn probe(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.motion = Some(code);
    let end = exec.target()?;
    let start = exec.state.current;
    exec.state.current = end;
    exec.check_feed(code)?;
    if exec.state.feed_mode == FeedMode::PerRevolution {
        return Err(Problem::ProbeFeed { code });
    }
    let must = code.tenths.is_multiple_of(2);
    let ways: [f64; 9] = std::array::from_fn(|axis| end[axis] - start[axis]);
    if must && ways.iter().all(|way| way.abs() < SHORTEST) {
        return Err(Problem::ProbeTooShort { code });
    }
    let length = ways.iter().take(3).map(|way| way * way).sum::<f64>().sqrt();
    let mut stop = end;
    if length > 0.0 {
        let share = Units::Mm.convert(STOP_MM, exec.state.units) / length;
        for axis in 0..3 {
            stop[axis] -= ways[axis] * share;
        }
    }
    let probe = StraightProbe {
        end,
        stop,
        away: code.tenths >= 384,
        must,
    };
    exec.parameters.put_position(TOUCHED, &end);
    exec.parameters.put(SUCCESS, 0.0);
    exec.emit(CanonicalOp::StraightProbe(Box::new(probe)));
    exec.state.current = stop;
    Ok(())
}
