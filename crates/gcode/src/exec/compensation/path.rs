//! Moves under cutter compensation.

use super::geometry::{CornerKind, crossing, in_plane, joint};
use crate::exec::Exec;
use crate::ops::{ArcFeed, CanonicalOp, Plane, Position, SourcedOp};
use crate::problem::Problem;
use crate::state::{Compensation, Edge, HeldOp, Shape};
use lostmotion_base::vec::{Vec2, along, direction2, distance2, dot, left_of, sub};

const NO_ROOM: Problem = Problem::Compensation {
    message: "the tool does not fit between these two moves: it would gouge",
};

/// Puts the end in the plane into a move.
pub(crate) fn set_end(op: &mut CanonicalOp, plane: Plane, end: Vec2) {
    let [first, second, _] = plane.axes();
    match op {
        CanonicalOp::StraightTraverse(position) | CanonicalOp::StraightFeed(position) => {
            (position[first], position[second]) = (end[0], end[1]);
        }
        CanonicalOp::ArcFeed(arc) => arc.end = end,
        _ => {}
    }
}

impl Exec<'_> {
    /// A straight move from the programmed place to `end`.
    #[cold]
    pub(crate) fn compensated_line(
        &mut self,
        start: &Position,
        end: Position,
        feed: bool,
    ) -> Result<(), Problem> {
        let op = if feed {
            CanonicalOp::StraightFeed(end)
        } else {
            CanonicalOp::StraightTraverse(end)
        };
        let plane = self.state.plane;
        let (from, to) = (in_plane(plane, start), in_plane(plane, &end));
        let Some(mut compensation) = self.state.compensation.take() else {
            return Ok(());
        };
        // A move along the normal only has no direction in the plane: it follows the held move.
        let result = match direction2(from, to) {
            None if compensation.last.is_some() => {
                compensation.across(self, op);
                Ok(())
            }
            _ if compensation.last.is_none() && distance2(from, to) <= compensation.left.abs() => {
                let message = "the first move under cutter compensation has to be longer than the tool's radius";
                Err(Problem::Compensation { message })
            }
            None => Ok(()),
            Some(u) => {
                // The offset line is the programmed one, shifted square to it by the tool's
                // radius.
                let side = along([0.0; 2], left_of(u), compensation.left);
                let edge = Edge {
                    shape: Shape::Line(u),
                    start: along(from, side, 1.0),
                    end: along(to, side, 1.0),
                    entry: false,
                    astray: false,
                    leaves: u,
                };
                // The first move leads from the path to the offset, so that only its end is
                // shifted.
                let entry = Edge {
                    start: from,
                    entry: true,
                    ..edge
                };
                let edge = if compensation.last.is_none() {
                    entry
                } else {
                    edge
                };
                compensation.advance(self, start, u, edge, op)
            }
        };
        self.state.compensation = Some(compensation);
        result
    }

    /// An arc from the programmed place.
    #[cold]
    pub(crate) fn compensated_arc(
        &mut self,
        start: &Position,
        mut arc: ArcFeed,
    ) -> Result<(), Problem> {
        let plane = self.state.plane;
        let (from, to) = (in_plane(plane, start), arc.end);
        let Some(mut compensation) = self.state.compensation.take() else {
            return Ok(());
        };
        // The direction of the programmed arc at its start decides the kind of corner.
        let enters = tangent(sub(from, arc.center), arc.turns > 0);
        let result = compensation.arc_edge(from, to, &arc).and_then(|edge| {
            if let Shape::Arc { center, .. } = edge.shape {
                arc.center = center;
            }
            // A lathe tool is offset about its nose centre, while the program controls another
            // point of it.
            let shift = compensation.nose(plane);
            arc.center = along(arc.center, shift, 1.0);
            let mut op = CanonicalOp::ArcFeed(arc);
            if edge.entry && shift != [0.0; 2] {
                // The start is not shifted as the end is: no arc with this tangent leads there.
                op = CanonicalOp::StraightFeed(arc.position());
            }
            compensation.advance(self, start, enters, edge, op)
        });
        self.state.compensation = Some(compensation);
        result
    }
}

/// Direction of travel where a circle has the given radius vector.
fn tangent(radius: Vec2, counter_clockwise: bool) -> Vec2 {
    let u = direction2([0.0; 2], radius).unwrap_or([1.0, 0.0]);
    let left = left_of(u);
    if counter_clockwise {
        left
    } else {
        [-left[0], -left[1]]
    }
}

impl Compensation {
    /// The offset of an arc; the first one leads from the path to its offset and is tangent to that
    /// at its end.
    fn arc_edge(&self, from: Vec2, to: Vec2, arc: &ArcFeed) -> Result<Edge, Problem> {
        let counter_clockwise = arc.turns > 0;
        // The tool to the left of a counter-clockwise arc is inside it.
        let outwards = if counter_clockwise {
            -self.left
        } else {
            self.left
        };
        let radius = distance2(arc.center, to) + outwards;
        if radius <= 0.0 || distance2(arc.center, from) + outwards <= 0.0 {
            return Err(Problem::Compensation {
                message: "the tool's radius is not less than that of the arc it is inside of",
            });
        }
        // The offset arc has the same centre; its end lies on the same ray.
        let out = direction2(arc.center, to).unwrap_or([1.0, 0.0]);
        let end = along(arc.center, out, radius);
        let leaves = tangent(out, counter_clockwise);
        if self.last.is_some() {
            // After the first move both ends are shifted along their radius.
            let begins = direction2(arc.center, from).unwrap_or([1.0, 0.0]);
            let start = along(arc.center, begins, distance2(arc.center, from) + outwards);
            return Ok(Edge {
                shape: Shape::Arc {
                    center: arc.center,
                    radius,
                    counter_clockwise,
                },
                start,
                end,
                entry: false,
                astray: false,
                leaves,
            });
        }
        // The entry arc is tangent to the offset at its end: its centre lies on the radius of the end
        // and is as far from the start as from the end.
        let chord = sub(from, end);
        let reach = dot(chord, chord);
        let inwards = -dot(chord, out);
        if inwards.abs() <= 1e-9 * reach.sqrt() {
            return Err(Problem::Compensation {
                message: "the first arc under cutter compensation is too short",
            });
        }
        // Equal distance from start and end: r = |chord|^2 / (2 inwards).
        let radius = reach / (2.0 * inwards);
        let center = along(end, out, -radius);
        Ok(Edge {
            shape: Shape::Arc {
                center,
                radius: radius.abs(),
                counter_clockwise,
            },
            start: from,
            end,
            entry: true,
            astray: false,
            leaves,
        })
    }

    /// Goes from the held move to the next one, which is then held.
    fn advance(
        &mut self,
        exec: &mut Exec<'_>,
        at: &Position,
        enters: Vec2,
        mut edge: Edge,
        mut op: CanonicalOp,
    ) -> Result<(), Problem> {
        let plane = exec.state.plane;
        let corner = in_plane(plane, at);
        let shift = self.nose(plane);
        let mut result = Ok(());
        if let Some(last) = self.last {
            // Now that the next direction is known, the end of the held move is final.
            let (joint, end) = self.meet(&last, corner, enters, &mut edge);
            let (end, refused) =
                end.map_or_else(|problem| (None, Err(problem)), |end| (end, Ok(())));
            result = refused;
            let released = self.release(plane, end, exec.out);
            result = result.and(released);
            if joint == CornerKind::Outside {
                // An outside corner: the tool rolls about it, at rapid in a straight line.
                let end = along(edge.start, shift, 1.0);
                if matches!(op, CanonicalOp::StraightTraverse(_)) {
                    let mut across = CanonicalOp::StraightTraverse(*at);
                    set_end(&mut across, plane, end);
                    exec.out.push(SourcedOp {
                        op: across,
                        block: exec.block,
                        named: 0,
                    });
                } else {
                    self.roll(exec, at, end, along(corner, shift, 1.0));
                }
            }
        }
        // The new move waits in its turn; its end may still change.
        set_end(&mut op, plane, along(edge.end, shift, 1.0));
        self.held.push(HeldOp {
            sourced: SourcedOp {
                named: exec.named(&op),
                op,
                block: exec.block,
            },
            follows: false,
        });
        self.last = Some(edge);
        self.fixed = false;
        result
    }

    /// How the held move goes on to the next one, which is made to start there, and where the held
    /// one has to end for that.
    fn meet(
        &mut self,
        last: &Edge,
        corner: Vec2,
        enters: Vec2,
        edge: &mut Edge,
    ) -> (CornerKind, Result<Option<Vec2>, Problem>) {
        // After a profile (G70) the tool counts as standing at the profile's end.
        if let Some(place) = self.strayed.take() {
            let last = last.astray(place, corner, self.left);
            let joint = joint(&last, enters, edge.shape, self.left);
            let end = last.end_astray(place, corner, joint, enters, self.left);
            edge.astray = joint != CornerKind::Outside;
            if edge.astray {
                edge.start = end.as_ref().ok().copied().flatten().unwrap_or(place);
            }
            return (joint, end);
        }
        // Inside corners end the held move early, where the offsets cross; outside ones leave it
        // whole.
        let joint = joint(last, enters, edge.shape, self.left);
        let end = match joint {
            CornerKind::Inside if !self.fixed => {
                crossing(last.shape, last.end, edge.shape, edge.start, self.left)
                    .ok_or(NO_ROOM)
                    .map(Some)
            }
            CornerKind::Outside => Ok(Some(last.end)),
            _ => Ok(None),
        };
        match (joint, &end) {
            (CornerKind::Outside, _) | (_, Err(_)) => {}
            (_, &Ok(end)) => edge.start = end.unwrap_or(last.end),
        }
        (joint, end)
    }

    /// The arc about an outside corner, at the height and the angles that the tool has.
    fn roll(&self, exec: &mut Exec<'_>, at: &Position, end: Vec2, center: Vec2) {
        let plane = exec.state.plane;
        let [_, _, normal] = plane.axes();
        let [_, _, _, others @ ..] = *at;
        // A tool on the left rolls clockwise about the corner.
        let turns = if self.left > 0.0 { -1 } else { 1 };
        let arc = ArcFeed {
            plane,
            end,
            center,
            turns,
            axis_end: at[normal],
            others,
        };
        exec.out.push(SourcedOp {
            op: CanonicalOp::ArcFeed(arc),
            block: exec.block,
            named: 0,
        });
    }

    /// A move across the plane: it ends where the held move ends.
    fn across(&mut self, exec: &mut Exec<'_>, mut op: CanonicalOp) {
        let Some(last) = self.last else { return };
        set_end(
            &mut op,
            exec.state.plane,
            along(
                self.strayed.unwrap_or(last.end),
                self.nose(exec.state.plane),
                1.0,
            ),
        );
        self.held.push(HeldOp {
            sourced: SourcedOp {
                named: exec.named(&op),
                op,
                block: exec.block,
            },
            follows: true,
        });
    }
}
