//! Travel and limits of an axis as the file holds them: mm for linear axes, degrees for rotary
//! ones.

use lostmotion_base::AxisLimits;
use lostmotion_base::units::rad;
use serde::{Deserialize, Serialize};

/// Table `axis.x.limits` of a linear axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LinearLimits {
    /// Lower end of the travel, mm, machine coordinates.
    pub min_mm: f64,
    /// Upper end of the travel, mm.
    pub max_mm: f64,
    /// Largest speed, mm/s.
    pub velocity_mm_s: f64,
    /// Largest acceleration, mm/s2.
    pub acceleration_mm_s2: f64,
    /// Largest jerk, mm/s3.
    pub jerk_mm_s3: f64,
}

/// Table `axis.a.limits` of a rotary axis.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotaryLimits {
    /// Lower end of the travel, deg, machine coordinates.
    pub min_deg: f64,
    /// Upper end of the travel, deg.
    pub max_deg: f64,
    /// Largest speed, deg/s.
    pub velocity_deg_s: f64,
    /// Largest acceleration, deg/s2.
    pub acceleration_deg_s2: f64,
    /// Largest jerk, deg/s3.
    pub jerk_deg_s3: f64,
}

/// Either of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum LimitsTable {
    /// Of X, Y, Z, U, V, W.
    Linear(LinearLimits),
    /// Of A, B, C.
    Rotary(RotaryLimits),
}

/// A key, its value, and the smallest and largest value that makes sense.
pub(super) type Bounded = (&'static str, f64, f64, f64);

impl LimitsTable {
    /// Of no axis at all: all zero.
    pub(super) const NONE: LimitsTable = LimitsTable::Linear(LinearLimits {
        min_mm: 0.0,
        max_mm: 0.0,
        velocity_mm_s: 0.0,
        acceleration_mm_s2: 0.0,
        jerk_mm_s3: 0.0,
    });

    /// In mm or rad.
    pub fn limits(&self) -> AxisLimits {
        match *self {
            LimitsTable::Linear(l) => AxisLimits {
                min: l.min_mm,
                max: l.max_mm,
                velocity: l.velocity_mm_s,
                acceleration: l.acceleration_mm_s2,
                jerk: l.jerk_mm_s3,
            },
            LimitsTable::Rotary(r) => AxisLimits {
                min: rad(r.min_deg),
                max: rad(r.max_deg),
                velocity: rad(r.velocity_deg_s),
                acceleration: rad(r.acceleration_deg_s2),
                jerk: rad(r.jerk_deg_s3),
            },
        }
    }

    /// Keys with their values and the ranges they have to lie in; wide enough for any machine,
    /// narrow enough for the planner's numbers.
    pub(super) fn bounded(&self) -> [Bounded; 5] {
        match *self {
            LimitsTable::Linear(l) => [
                ("min_mm", l.min_mm, -1e6, 1e6),
                ("max_mm", l.max_mm, -1e6, 1e6),
                ("velocity_mm_s", l.velocity_mm_s, 1e-3, 1e5),
                ("acceleration_mm_s2", l.acceleration_mm_s2, 1e-2, 1e6),
                ("jerk_mm_s3", l.jerk_mm_s3, 1e-1, 1e9),
            ],
            LimitsTable::Rotary(r) => [
                ("min_deg", r.min_deg, -1e7, 1e7),
                ("max_deg", r.max_deg, -1e7, 1e7),
                ("velocity_deg_s", r.velocity_deg_s, 1e-3, 1e5),
                ("acceleration_deg_s2", r.acceleration_deg_s2, 1e-2, 1e6),
                ("jerk_deg_s3", r.jerk_deg_s3, 1e-1, 1e9),
            ],
        }
    }
}

/// Unit of an axis for people: `mm` or `deg`.
pub(super) const fn unit(rotary: bool) -> &'static str {
    if rotary { "deg" } else { "mm" }
}
