//! What of a program lies beyond the machine's travel, told once for the one cause that it mostly
//! has: a work offset.

use super::curves::Curves;
use super::steer::Modes;
use crate::error::{SimError, TravelExcess, shown};
use crate::machine::{Machine, WorkOffsets};
use crate::setup::Setup;
use lostmotion_base::units::deg;
use lostmotion_kinematics::JointMap;
use lostmotion_path::Bounds;
use lostmotion_plan::TravelViolation;
use std::collections::BTreeSet;

/// Violations of the travel, added up by joint and end.
#[derive(Clone, Debug, Default)]
pub(super) struct Excesses {
    found: Vec<TravelExcess>,
    moves: u64,
    /// Work coordinate systems in which moves go beyond the travel, from 1 for G54.
    systems: BTreeSet<u16>,
}

impl Excesses {
    /// Takes the violations of one move.
    pub(super) fn add(&mut self, machine: &Machine, system: u16, violations: &[TravelViolation]) {
        if violations.is_empty() {
            return;
        }
        self.moves += 1;
        self.systems.insert(system);
        for violation in violations {
            // One entry a joint and end of its travel: limits are compared to the bit, both come
            // from the same machine.
            let same = |known: &&mut TravelExcess| {
                known.joint == violation.joint && known.limit.to_bits() == violation.limit.to_bits()
            };
            let new = TravelExcess {
                joint: violation.joint,
                is_rotary: machine.rotary_joints().contains(violation.joint),
                limit: violation.limit,
                value: violation.value,
                block: violation.block,
                moves: 1,
            };
            match self.found.iter_mut().find(same) {
                Some(known) => {
                    let moves = known.moves + 1;
                    // The farthest place stands for all, with the count of moves beyond this end.
                    if new.by() > known.by() {
                        *known = new;
                    }
                    known.moves = moves;
                }
                None => self.found.push(new),
            }
        }
    }

    /// Whether everything is within the travel.
    pub(super) fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// The error that they are, largest first, with what to do about them.
    pub(super) fn error(mut self, setup: &Setup<'_>) -> SimError {
        // Linear joints first: mm and rad cannot be ordered by size.
        self.found.sort_by(|a, b| {
            (a.is_rotary, b.by())
                .partial_cmp(&(b.is_rotary, a.by()))
                .unwrap_or(std::cmp::Ordering::Equal)
        });
        let hint = self
            .shift(setup)
            .unwrap_or_else(|| "shift the part, or take a machine with more travel".to_owned());
        SimError::Travel {
            name: setup.program.name().to_owned(),
            machine: setup.machine.name().to_owned(),
            moves: self.moves,
            excesses: self.found,
            hint,
            provenance: Box::default(),
        }
    }

    /// The shift of the work offset that brings the part into the travel; `None` where joints are
    /// not the program's coordinates, or several offsets are in play.
    fn shift(&self, setup: &Setup<'_>) -> Option<String> {
        let name = match (self.systems.first(), self.systems.len()) {
            (Some(system), 1) => WorkOffsets::KEYS.get(usize::from(*system).checked_sub(1)?)?,
            _ => return None,
        };
        // A shift helps only where the whole part moves with it: the range of all moves is needed.
        let reached = reached(setup)?;
        let (mut shifts, mut keys) = (Vec::new(), Vec::new());
        for axis in setup.machine.axes() {
            let excess: Vec<&TravelExcess> = self
                .found
                .iter()
                .filter(|excess| excess.joint == axis.id)
                .collect();
            let Some(first) = excess.first() else {
                continue;
            };
            let (low, high) = (reached.min[axis.id], reached.max[axis.id]);
            let (needs, has) = (high - low, axis.limits.max - axis.limits.min);
            // No offset makes a part fit that is longer than the travel.
            if needs > has {
                let [needs, has] = [needs, has].map(|length| shown(length, axis.is_rotary()));
                return Some(format!(
                    "the part needs {needs} of {}, the machine has {has}: take a machine with more travel",
                    axis.id
                ));
            }
            // The least shift: the farthest place comes to lie on the limit.
            let by = first.limit - first.value;
            shifts.push(format!(
                "{} by {} or more",
                axis.id,
                signed(by, axis.is_rotary())
            ));
            let system = usize::from(*self.systems.first()?) - 1;
            // The value to write into the machine file: the origin in force, shifted.
            let origin = setup.machine.work_offsets().get(system)?[axis.id] + by;
            let value = if axis.is_rotary() {
                deg(origin)
            } else {
                origin
            };
            keys.push(format!("{} = {value:.3}", axis.id.column()));
        }
        Some(format!(
            "move the origin of {}: {}; in the machine file [work_offset.{name}] {}",
            name.to_ascii_uppercase().replace('_', "."),
            shifts.join(", "),
            keys.join(", ")
        ))
    }
}

/// A way along a joint with its sign and unit.
fn signed(value: f64, is_rotary: bool) -> String {
    if is_rotary {
        format!("{:+.3} deg", deg(value))
    } else {
        format!("{value:+.3} mm")
    }
}

/// From where to where each joint goes over the whole program; `None` where joints are not the
/// program's coordinates up to a constant. The program is read once more: nothing of it is kept,
/// and a program that fits does not pay for it.
fn reached(setup: &Setup<'_>) -> Option<Bounds> {
    let modes = Modes::new(&setup.kinematics);
    let mut reached: Option<Bounds> = None;
    for item in Curves::new(setup).ok()? {
        let item = item.ok()?;
        let kinematics = modes.kinematics(item.is_tip);
        // With rotary kinematics a shift of the part changes every joint: no single number mends
        // it.
        if kinematics.joint_map() == JointMap::Curved {
            return None;
        }
        let start = item.motion.curve.start();
        // Joints are the program's coordinates plus a constant, so bounds of the curve need no
        // sampling.
        let offset = kinematics.inverse(&start, &item.motion.tool_mm).ok()? - start;
        let bounds = item.motion.curve.bounds();
        let (min, max) = (bounds.min + offset, bounds.max + offset);
        let all = reached.get_or_insert(Bounds { min, max });
        all.include(min);
        all.include(max);
    }
    reached
}
