//! G5, G5.1, G5.2 and G5.3: curves in the XY plane as rational B-splines.

use super::Exec;
use crate::codes::Code;
use crate::exec::words::whole_within;
use crate::motion::curve_length;
use crate::ops::{CanonicalOp, ControlPoint, NurbsFeed, Plane, Position};
use crate::problem::Problem;
use crate::state::{FeedMode, NurbsDraft};

/// Order of a NURBS block where L does not say.
const DEFAULT_NURBS_ORDER: u32 = 3;
/// Highest order of a NURBS. A choice: work and memory of a point grow with the order, whose
/// default is 3.
const HIGHEST_ORDER: f64 = 32.0;

const fn plain(at: [f64; 2]) -> ControlPoint {
    ControlPoint { at, weight: 1.0 }
}

impl Exec<'_> {
    /// End of a curve: it moves X and Y only, at a feed rate, in the XY plane, without cutter
    /// compensation.
    fn curve_end(&mut self, code: Code) -> Result<Position, Problem> {
        if self.state.plane != Plane::Xy {
            return Err(Problem::Curve {
                code,
                message: "is only for the XY plane (G17)",
            });
        }
        if self.state.compensation.is_some() {
            return Err(Problem::Curve {
                code,
                message: "cannot be used with cutter compensation",
            });
        }
        if (2..9).any(|axis| self.axis_word(axis).is_some()) {
            return Err(Problem::Curve {
                code,
                message: "can only move X and Y",
            });
        }
        self.check_feed(code)?;
        self.target()
    }

    fn spline(&mut self, end: Position, points: Vec<ControlPoint>) {
        let order = points.len() as u32;
        self.state.current = end;
        let curve = NurbsFeed {
            plane: Plane::Xy,
            order,
            points,
            end,
        };
        self.inverse_time(|| curve_length(&curve).unwrap_or_default());
        self.emit(CanonicalOp::NurbsFeed(Box::new(curve)));
    }
}

/// G5: a cubic spline. I and J lead from its start to the first control point, P and Q from its end
/// to the second; without I and J it goes on as the G5 before it ended. The motion mode stays what
/// it was (as recorded).
pub(crate) fn cubic(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let follows = exec.state.spline_exit.take().unwrap_or_default();
    let end = exec.curve_end(code)?;
    let [x, y, ..] = exec.state.current;
    let [p, q] = [
        exec.need(b'P', code, "P and Q")?,
        exec.need(b'Q', code, "P and Q")?,
    ];
    let [i, j] = match (exec.word(b'I'), exec.word(b'J')) {
        (Some(i), Some(j)) => [i, j],
        (None, None) => follows,
        _ => {
            return Err(Problem::WordMissing {
                code,
                what: "both I and J, or neither",
            });
        }
    };
    // Without I and J the next G5 continues in the direction that this one ends in.
    exec.state.spline_exit = Some([-p, -q]);
    // Bezier points: the ends lie on the path, the inner ones give the tangents.
    exec.spline(
        end,
        vec![
            plain([x, y]),
            plain([x + i, y + j]),
            plain([end[0] + p, end[1] + q]),
            plain([end[0], end[1]]),
        ],
    );
    Ok(())
}

/// G5.1: a quadratic spline. I and J lead from its start to the control point. The motion mode
/// stays what it was.
pub(crate) fn quadratic(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    let end = exec.curve_end(code)?;
    let [x, y, ..] = exec.state.current;
    let [i, j] = [
        exec.need(b'I', code, "I and J")?,
        exec.need(b'J', code, "I and J")?,
    ];
    exec.spline(
        end,
        vec![
            plain([x, y]),
            plain([x + i, y + j]),
            plain([end[0], end[1]]),
        ],
    );
    Ok(())
}

/// G5.2: opens a NURBS block, then adds a control point with each block. The first one is where the
/// tool is; its weight is the P of an opening block without X and Y.
pub(crate) fn nurbs(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    if exec.state.feed_mode == FeedMode::InverseTime {
        return Err(Problem::Curve {
            code,
            message: "cannot be used in inverse time (G93): its blocks are one move",
        });
    }
    exec.state.motion = Some(code);
    let end = exec.curve_end(code)?;
    // A block without X and Y opens the curve with weight and order only.
    let given = [0, 1].map(|axis| exec.axis_word(axis).is_some());
    if given[0] != given[1] {
        return Err(Problem::WordMissing {
            code,
            what: "both X and Y of a control point",
        });
    }
    let weight = exec.word(b'P');
    if let Some(value) = weight.filter(|weight| *weight <= 0.0) {
        return Err(Problem::WordOutOfRange {
            code,
            letter: 'P',
            value,
            allowed: "a weight greater than zero",
        });
    }
    // The opening block fixes the order and puts the first control point where the tool is.
    let opens = exec.state.nurbs.is_none();
    if opens {
        let value = exec.word(b'L').unwrap_or(f64::from(DEFAULT_NURBS_ORDER));
        let order = whole_within(
            (code, b'L'),
            value,
            2.0..=HIGHEST_ORDER,
            "an order from 2 to 32",
        )? as u32;
        let [x, y, ..] = exec.state.current;
        let first = ControlPoint {
            at: [x, y],
            weight: weight.filter(|_| !given[0]).unwrap_or(1.0),
        };
        exec.state.nurbs = Some(Box::new(NurbsDraft {
            order,
            points: vec![first],
        }));
    }
    if !given[0] {
        return Ok(());
    }
    // Points are held until G5.3: their number is bounded.
    let limit = exec.config.limits.curve_points;
    let weight = match weight {
        None if !opens => {
            return Err(Problem::WordMissing {
                code,
                what: "P, the weight of the control point",
            });
        }
        weight => weight.unwrap_or(1.0),
    };
    if let Some(draft) = &mut exec.state.nurbs {
        if draft.points.len() >= limit {
            return Err(Problem::CurveTooLong { limit });
        }
        draft.points.push(ControlPoint {
            at: [end[0], end[1]],
            weight,
        });
    }
    exec.state.current = end;
    Ok(())
}

/// A NURBS block that the program ends in.
pub(crate) const fn unclosed() -> Problem {
    Problem::Curve {
        code: Code::g(52),
        message: "without its G5.3: the curve is not run",
    }
}

/// G5.3: closes the NURBS block and makes the move.
pub(crate) fn nurbs_end(exec: &mut Exec<'_>, code: Code) -> Result<(), Problem> {
    exec.state.motion = None;
    let draft = exec.state.nurbs.take().ok_or(Problem::Curve {
        code,
        message: "needs a G5.2 before it",
    })?;
    let NurbsDraft { order, points } = *draft;
    // A B-spline of an order needs at least that many control points.
    if points.len() < order as usize {
        return Err(Problem::CurvePoints {
            points: points.len(),
            order,
        });
    }
    let end = exec.state.current;
    exec.emit(CanonicalOp::NurbsFeed(Box::new(NurbsFeed {
        plane: Plane::Xy,
        order,
        points,
        end,
    })));
    Ok(())
}
