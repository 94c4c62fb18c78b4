//! The columns of a record: as points of the tool for the program, and as joints for their limits,
//! each with how far rounding and noise of the log may have it off.

use super::blocks::Blocks;
use super::locate::{Coordinates, Located};
use super::path::{Foot, ProgrammedPath};
use super::rates::{Channel, Fineness, Order, time_bound_s};
use super::results::{Derivative, LimitUse, RecordKind, RecordedAxisCheck};
use super::{Recorded, short};
use crate::error::SimError;
use crate::setup::Setup;
use lostmotion_base::units::deg;
use lostmotion_base::vec::norm;
use lostmotion_base::{AXES, AxisId, Coords};
use lostmotion_kinematics::JointMap;
use std::ops::Range;

/// By how much a limit may be exceeded without being said to be, in parts of it. A choice: limits of
/// controls are rounded numbers.
const LIMIT_SLACK: f64 = 0.005;
/// The same of measured positions. A choice: limits are those of commands, and servos overshoot.
const SERVO_SLACK: f64 = 0.1;
/// Part of a limit that an error of a derivative may be for the record to tell it.
const TOLD_SHARE: f64 = 0.5;
/// Derivatives with the place of their limit.
const DERIVATIVES: [Derivative; 3] = [
    Derivative::Velocity,
    Derivative::Acceleration,
    Derivative::Jerk,
];
/// Least change of a coordinate that tells what the joints make of it, mm or rad: far above the
/// digits of a number, far below what bends the kinematics.
const LEAST_CHANGE: f64 = 1e-7;
/// Most rows of a part on which errors are carried through the kinematics. A choice: between them
/// the machine hardly moves.
const MOST_ROWS: usize = 20_000;

/// The record as the program sees it, and as the joints do.
pub(super) struct Channels<'a> {
    recorded: &'a Recorded,
    /// The tool in the coordinates that the path is in.
    pub(super) points: Vec<[f64; 3]>,
    /// Of each column of the log.
    fineness: Vec<(AxisId, Fineness)>,
    /// How far a point may be off, mm.
    pub(super) error_mm: f64,
}

/// Positions of a joint on the rows that are on the path, mm or rad.
pub(super) struct JointColumn {
    axis: AxisId,
    values: Vec<f64>,
    fineness: Fineness,
}

impl<'a> Channels<'a> {
    pub(super) fn new(
        setup: &Setup<'_>,
        recorded: &'a Recorded,
        path: &ProgrammedPath,
    ) -> Result<Channels<'a>, SimError> {
        let rows = recorded.time_s.len();
        let kinematics = &setup.kinematics;
        let tool = path.tool_mm;
        let is_forward = path.is_tip && !recorded.of_tool;
        let points = (0..rows)
            .map(|row| {
                let coords = coords(recorded, row);
                if is_forward {
                    kinematics.forward(&coords, &tool).linear()
                } else {
                    coords.linear()
                }
            })
            .collect();
        let fineness: Vec<(AxisId, Fineness)> = recorded
            .axes
            .iter()
            .map(|axis| (axis.axis, Fineness::of(&axis.values)))
            .collect();
        // A point is off by what its three coordinates are off.
        let mut own = [Fineness::default(); AXES];
        for (axis, fineness) in &fineness {
            own[axis.index()] = *fineness;
        }
        let of_point = if is_forward {
            let forward = |joints: &Coords| Ok(kinematics.forward(joints, &tool));
            carried(recorded, &fineness, 0..rows, &forward)?
        } else {
            own
        };
        let [x, y, z] = [0, 1, 2].map(|axis: usize| of_point[axis].bound(3 * rows));
        Ok(Channels {
            recorded,
            points,
            fineness,
            error_mm: norm([x, y, z]),
        })
    }

    /// The joints on the rows that are on the path: the columns, or what the kinematics make of
    /// positions of the tool.
    ///
    /// # Errors
    /// A position that the machine cannot take.
    pub(super) fn joints(
        &self,
        setup: &Setup<'_>,
        path: &ProgrammedPath,
        located: &Located,
        rows: Range<usize>,
    ) -> Result<Vec<JointColumn>, SimError> {
        let recorded = self.recorded;
        if !(recorded.of_tool && path.is_tip) {
            let columns = recorded.axes.iter().zip(&self.fineness);
            let joint =
                |(axis, (_, fineness)): (&super::RecordedAxis, &(AxisId, Fineness))| JointColumn {
                    axis: axis.axis,
                    values: axis.values.get(rows.clone()).unwrap_or_default().to_vec(),
                    fineness: *fineness,
                };
            return Ok(columns.map(joint).collect());
        }
        // The kinematics take coordinates of the machine: a part on a table turns about an axis that
        // stands still there.
        let mut origin = match located.coordinates {
            Coordinates::Program => path.origin,
            Coordinates::Machine | Coordinates::Found => Coords::ZERO,
        };
        for (value, shift) in origin.0.iter_mut().zip(located.shift_mm) {
            *value = -shift;
        }
        let inverse = |tool: &Coords| {
            let joints = setup.kinematics.inverse(&(*tool + origin), &path.tool_mm)?;
            Ok(joints)
        };
        let fineness = carried(recorded, &self.fineness, rows.clone(), &inverse)?;
        let mut joints: Vec<JointColumn> = setup
            .machine
            .axes()
            .iter()
            .map(|axis| JointColumn {
                axis: axis.id,
                values: Vec::with_capacity(rows.len()),
                fineness: fineness[axis.id.index()],
            })
            .collect();
        for row in rows {
            let found = inverse(&coords(recorded, row))?;
            for joint in &mut joints {
                joint.values.push(found.0[joint.axis.index()]);
            }
        }
        Ok(joints)
    }

    /// Holds each axis against its limits.
    pub(super) fn axes(
        &self,
        setup: &Setup<'_>,
        joints: &[JointColumn],
        rows: Range<usize>,
        blocks: &mut Blocks<'_>,
        feet: &[Foot],
        untold: &mut Vec<String>,
    ) -> Vec<RecordedAxisCheck> {
        let time_s = self.recorded.time_s.get(rows).unwrap_or_default();
        let time_bound_s = time_bound_s(time_s);
        let mut found = Vec::new();
        for joint in joints {
            let (id, fineness) = (joint.axis, joint.fineness);
            let Some(axis) = setup.machine.axis(id) else {
                continue;
            };
            let channel = Channel {
                time_s,
                values: &joint.values,
                fineness,
                time_bound_s,
            };
            let unit = if axis.is_rotary() { deg(1.0) } else { 1.0 };
            let mut limits = Vec::new();
            let is_measured = self.recorded.kind == RecordKind::Measured;
            let slack = if is_measured {
                SERVO_SLACK
            } else {
                LIMIT_SLACK
            };
            // What friction and a gap do to the jerk of a load is no fault of the control.
            let held = if is_measured { 2 } else { DERIVATIVES.len() };
            for (order, derivative) in DERIVATIVES.into_iter().take(held).enumerate() {
                let limit = match derivative {
                    Derivative::Velocity => axis.limits.velocity,
                    Derivative::Acceleration => axis.limits.acceleration,
                    Derivative::Jerk => axis.limits.jerk,
                };
                // Between two commands the jerk is the interpolation's.
                let least_s = match derivative {
                    Derivative::Jerk => {
                        (order + 1) as f64 * setup.machine.cycles().command().period_s()
                    }
                    Derivative::Velocity | Derivative::Acceleration => 0.0,
                };
                let order = Order(order + 1);
                let mut worst: Option<LimitUse> = None;
                for rate in channel.rates(order, least_s) {
                    let Some(foot) = feet.get(rate.row) else {
                        continue;
                    };
                    let is_exceeded = rate.certain() > limit * (1.0 + slack);
                    let used = LimitUse {
                        axis: id,
                        derivative,
                        limit: limit * unit,
                        found: rate.value.abs() * unit,
                        plus_minus: rate.error * unit,
                        times: rate.value.abs() / limit,
                        over_s: rate.over_s,
                        time_s: time_s[rate.row],
                        block: blocks.path.block(foot.piece),
                        is_exceeded,
                    };
                    let more = |than: &LimitUse| rate.certain() / limit > than.certain();
                    if worst.as_ref().is_none_or(more) {
                        worst = Some(used.clone());
                    }
                    blocks.limit(foot.piece, used);
                }
                let letter = if axis.is_rotary() { "deg" } else { "mm" };
                let reason = hidden(&channel, order, limit).map(|(over_s, error)| {
                    format!(
                        "whether axis {id} keeps its {derivative} of {}: rounding and noise of the log make +-{} {letter} and s of it even over {:.0} ms",
                        short(limit * unit),
                        short(error * unit),
                        1e3 * over_s,
                    )
                });
                untold.extend(reason);
                limits.extend(worst);
            }
            found.push(RecordedAxisCheck {
                axis: id,
                unit: if axis.is_rotary() { "deg" } else { "mm" }.to_owned(),
                step: fineness.step * unit,
                noise: fineness.noise * unit,
                limits,
            });
        }
        found
    }
}

/// Where rounding and noise hide whether a limit is kept at every width of the stencils: the width
/// that hides it least, s, and the error that is left there.
fn hidden(channel: &Channel<'_>, order: Order, limit: f64) -> Option<(f64, f64)> {
    channel
        .errors(order)
        .into_iter()
        .min_by(|a, b| a.1.total_cmp(&b.1))
        .filter(|(_, error)| *error > TOLD_SHARE * limit)
}

/// A row of a record, mm and rad; 0 of axes that it does not have.
fn coords(recorded: &Recorded, row: usize) -> Coords {
    let mut coords = Coords::ZERO;
    for axis in &recorded.axes {
        coords.0[axis.axis.index()] = axis.values.get(row).copied().unwrap_or_default();
    }
    coords
}

/// What steps and noise of the columns make of each coordinate that a map gives of them: steps add
/// up at worst, noise by its squares. How much a coordinate changes with a column is told by a
/// small change of it; the row where that is most counts.
fn carried(
    recorded: &Recorded,
    columns: &[(AxisId, Fineness)],
    rows: Range<usize>,
    map: &dyn Fn(&Coords) -> Result<Coords, SimError>,
) -> Result<[Fineness; AXES], SimError> {
    let mut most = [Fineness::default(); AXES];
    let stride = rows.len().div_ceil(MOST_ROWS).max(1);
    for row in rows.step_by(stride) {
        let at = coords(recorded, row);
        let here = map(&at)?;
        let (mut steps, mut squares) = ([0.0; AXES], [0.0; AXES]);
        for (axis, fineness) in columns {
            if fineness.step == 0.0 && fineness.noise == 0.0 {
                continue;
            }
            let change = (0.5 * fineness.step).max(fineness.noise).max(LEAST_CHANGE);
            let moved = |by: f64| {
                let mut there = at;
                there.0[axis.index()] += by;
                map(&there)
            };
            // At the end of a joint's reach one of the two ways is left.
            let there = moved(change).or_else(|_| moved(-change))?;
            for joint in 0..AXES {
                let slope = (there.0[joint] - here.0[joint]).abs() / change;
                steps[joint] += slope * fineness.step;
                squares[joint] += slope * slope * fineness.noise * fineness.noise;
            }
        }
        for ((most, step), square) in most.iter_mut().zip(steps).zip(squares) {
            most.step = most.step.max(step);
            most.noise = most.noise.max(square.sqrt());
        }
    }
    Ok(most)
}

/// The columns without which a record says nothing of the joints: X, Y and Z where the joints go
/// with the program's axes, else all that the kinematics take.
pub(super) fn needed(setup: &Setup<'_>, of_tool: bool) -> Vec<AxisId> {
    let is_linear = |axis: &AxisId| axis.index() < 3;
    let joints = setup.machine.axes().iter().map(|axis| axis.id);
    if setup.kinematics.joint_map() == JointMap::Shifted {
        // Tools have X, Y and Z whatever the joints are called.
        return if of_tool {
            vec![AxisId::X, AxisId::Y, AxisId::Z]
        } else {
            joints.filter(is_linear).collect()
        };
    }
    match setup.kinematics.layout().filter(|_| of_tool) {
        Some(layout) => layout.words.iter().collect(),
        None => joints.collect(),
    }
}
