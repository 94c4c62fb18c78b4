//! Stops of controls that take a gap up by a move of their own: the path comes to rest where an axis
//! reverses, or at the end of every move.

use crate::machine::{Machine, PathStops};
use lostmotion_base::units::deg;
use lostmotion_base::{AXES, math};
use lostmotion_path::{Arc, Curve};
use lostmotion_plan::{Dwell, FeedLimit, Halt, Move, PathControl, PlanItem};
use std::f64::consts::{FRAC_PI_2, TAU};

/// Way of an axis that is none, mm and rad.
const STILL: f64 = 1e-7;
/// Length of a piece that an arc is not cut off for: ends that lie at a quarter but for rounding, mm.
const SHORTEST_MM: f64 = 2e-3;

/// Where on an arc one of the axes of its plane reverses, as arc lengths from its start, rising: the
/// quarters of the circle. Of a spiral they are those of its radius.
pub(crate) fn reversals(curve: &Curve) -> Vec<f64> {
    let Curve::Arc(arc) = curve else {
        return Vec::new();
    };
    let length = curve.length();
    let (from, sweep) = (start_angle(curve, arc), arc.sweep().abs());
    let mut cuts = Vec::new();
    let mut quarter = (from / FRAC_PI_2).floor() + 1.0;
    while quarter * FRAC_PI_2 - from < sweep {
        let at = (quarter * FRAC_PI_2 - from) / sweep * length;
        if at > SHORTEST_MM && length - at > SHORTEST_MM {
            cuts.push(at);
        }
        quarter += 1.0;
        if cuts.len() > (sweep / TAU * 4.0) as usize + 8 {
            break;
        }
    }
    cuts
}

/// Angle of an arc's start, counted in the sense in which it is gone round.
fn start_angle(curve: &Curve, arc: &Arc) -> f64 {
    let [first, second, _] = curve.plane().axes();
    let start = curve.start().linear();
    let from = [
        start[first] - arc.center()[0],
        start[second] - arc.center()[1],
    ];
    arc.sweep().signum() * math::atan2(from[1], from[0])
}

/// Puts a control's stops between the moves of a program.
#[derive(Clone, Debug)]
pub(super) struct Stops {
    at: PathStops,
    /// Sign of the last motion of each axis; 0 before the first one.
    directions: [f64; AXES],
    /// How long each axis takes for its gap, s.
    take_up_s: [f64; AXES],
}

impl Stops {
    /// Those of a machine's control, if it has any.
    pub(super) fn new(machine: &Machine) -> Option<Stops> {
        let at = machine.planner().stops;
        let mut take_up_s = [0.0; AXES];
        for axis in machine.axes() {
            let (config, limits) = (&axis.config, axis.limits_table().limits());
            let load = config.reflected_load().gap_rad;
            let gap = config.compensation.fixed.gap;
            let gap = gap.map_or(load, |gap| gap.motor_rad(&config.transmission));
            let units = gap / config.transmission.motor_rad_per_unit();
            let acceleration = if axis.is_rotary() {
                deg(limits.acceleration)
            } else {
                limits.acceleration
            };
            // A rapid so short that it never reaches its speed: half the way faster, half slower.
            take_up_s[axis.id.index()] = 2.0 * (units / acceleration).sqrt();
        }
        (at != PathStops::Never).then_some(Stops {
            at,
            directions: [0.0; AXES],
            take_up_s,
        })
    }

    /// What a move becomes: its pieces, and the stops before and between them.
    pub(super) fn of_move(&mut self, item: Move) -> Vec<PlanItem> {
        if self.at == PathStops::Blocks {
            return vec![PlanItem::Move(Move {
                control: PathControl::ExactStop,
                ..item
            })];
        }
        let length = item.curve.length();
        let mut ends = reversals(&item.curve);
        ends.push(length);
        let mut items = Vec::with_capacity(2 * ends.len());
        let mut begin = 0.0;
        for end in ends {
            let whole = end - begin >= length;
            let curve = if whole {
                item.curve
            } else {
                item.curve.sub(begin, end)
            };
            if let Some(seconds) = self.turn(&curve) {
                items.push(if seconds > 0.0 {
                    PlanItem::Dwell(Dwell {
                        seconds,
                        block: item.block,
                    })
                } else {
                    PlanItem::Halt(Halt { block: item.block })
                });
            }
            items.push(PlanItem::Move(Move {
                curve,
                feed: match item.feed {
                    FeedLimit::Duration(seconds) if !whole => {
                        FeedLimit::Duration(seconds * (end - begin) / length)
                    }
                    feed => feed,
                },
                ..item
            }));
            begin = end;
        }
        items
    }

    /// How long the machine stands before a piece because axes reverse there.
    fn turn(&mut self, curve: &Curve) -> Option<f64> {
        let (start, end) = (curve.start(), curve.end());
        let mut stands = None;
        for axis in 0..AXES {
            let way = end.0[axis] - start.0[axis];
            if way.abs() <= STILL {
                continue;
            }
            let before = std::mem::replace(&mut self.directions[axis], way.signum());
            if before * way < 0.0 {
                stands = Some(self.take_up_s[axis].max(stands.unwrap_or(0.0)));
            }
        }
        stands
    }
}
