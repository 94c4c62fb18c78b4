//! What a log tells beside what an axis' description says.

use super::scales::{Scales, figures, gap_figure, with_interval};
use lostmotion::drive::config::{FrictionLaw, Load};
use lostmotion::identify::BacklashFit;
use lostmotion::identify::body::{Figure, RigidBody, ServoGains};
use lostmotion::methods::AxisConfig;

/// How far a described value may be off the measured one, in parts of it, before `--check` says
/// so: data sheets are given to this. The interval of the log has to leave it out, too.
const LEAST_DIFFERENCE: f64 = 0.05;

/// By how much the part of the speed that is fed forward may be off. A choice: in logs of drives with
/// known settings it was within half of it.
const FORWARD_WITHIN: f64 = 0.05;
/// Integral time of a velocity loop without an integral part, s, and that from which on it shows in no
/// stroke.
const NO_INTEGRAL_S: f64 = 1000.0;
const LONG_INTEGRAL_S: f64 = 1.0;

/// Table of friction that falls in a straight line.
pub(super) const STRIBECK_TABLE: &str = "friction.load.stribeck";
/// Speed at which a straight line has fallen to nothing, over that of a Gaussian with the same
/// breakaway and the same area below it: the root of pi.
const STRAIGHT: f64 = 1.772_453_850_905_516;

/// A value of the description that the log tells.
pub(super) struct Finding {
    /// Table and key in the file of an axis.
    pub(super) table: &'static str,
    pub(super) key: &'static str,
    pub(super) unit: &'static str,
    pub(super) described: f64,
    pub(super) measured: Figure,
}

impl Finding {
    /// Whether a description can have the measured value, or why it is not taken over: friction below that
    /// of the motor is nobody's.
    pub(super) fn refused(&self, log: &str) -> Option<String> {
        let may_be_none = self.key == "velocity_feedforward";
        if may_be_none && self.measured.value >= 0.0 {
            return None;
        }
        if !self.measured.is_told() {
            return Some(format!("{log} does not tell it"));
        }
        self.is_less_than_the_motors()
            .then(|| format!("its motor alone has more than {log} shows of the whole axis"))
    }

    /// Whether less than nothing is left beside the described motor: of a mass or a friction.
    fn is_less_than_the_motors(&self) -> bool {
        let signed = self.key.starts_with("constant") || self.key == "velocity_feedforward";
        !signed && self.measured.is_told() && self.measured.value <= 0.0
    }

    /// Whether the description is certainly another one, in words.
    pub(super) fn verdict(&self) -> (String, bool) {
        if self.is_less_than_the_motors() {
            let text = format!(
                "{}.{}: described {} {}; the motor alone is described with more than this log shows of the whole axis: DIFFERS\n",
                self.table,
                self.key,
                figures(self.described),
                self.unit
            );
            return (text, true);
        }
        let [low, high] = self.measured.interval;
        let outside = !(low..=high).contains(&self.described);
        let off = (self.described - self.measured.value).abs()
            > LEAST_DIFFERENCE * self.measured.value.abs();
        // What the log does not tell is no difference.
        let may_be_none = self.key.starts_with("constant") || self.key == "velocity_feedforward";
        let is_told = self.measured.is_told() || may_be_none;
        let differs = outside && off && is_told;
        let words = if differs {
            "DIFFERS"
        } else if outside && !is_told {
            "not told"
        } else if outside {
            "agrees within 5 %"
        } else {
            "agrees"
        };
        let [measured, low, high] = with_interval(self.measured);
        let text = format!(
            "{}.{}: described {} {u}, measured {measured} (95 %: {low} to {high}): {words}\n",
            self.table,
            self.key,
            figures(self.described),
            u = self.unit,
        );
        (text, differs)
    }
}

impl Scales {
    pub(super) fn body_findings(&self, body: &RigidBody, axis: &AxisConfig) -> Vec<Finding> {
        if !self.has_force() || !body.is_one_body() {
            return Vec::new();
        }
        let r = self.per_rad;
        // What the motor's side has of it, at the load.
        let less = |figure: Figure, own: f64| Figure {
            value: figure.value - own,
            error: figure.error,
            interval: figure.interval.map(|end| end - own),
        };
        let inertia = less(body.inertia, axis.motor_side_inertia_kgm2() / (r * r));
        let viscous = less(body.viscous, axis.motor.viscous_nm_s_per_rad / (r * r));
        let coulomb = less(body.coulomb, axis.motor.coulomb_nm / r);
        let finding = |table, key, unit, described, measured| Finding {
            table,
            key,
            unit,
            described,
            measured,
        };
        let mut findings = match &axis.load {
            Load::Slide(load) => vec![
                finding("load.slide", "mass_kg", "kg", load.mass_kg, inertia),
                finding(
                    "load.slide",
                    "viscous_n_s_per_m",
                    "N s/m",
                    load.viscous_n_s_per_m,
                    viscous,
                ),
                finding("load.slide", "coulomb_n", "N", load.coulomb_n, coulomb),
                finding(
                    "load.slide",
                    "constant_n",
                    "N",
                    load.constant_n,
                    body.constant,
                ),
            ],
            Load::Table(load) => vec![
                finding(
                    "load.table",
                    "inertia_kgm2",
                    "kg m2",
                    load.inertia_kgm2,
                    inertia,
                ),
                finding(
                    "load.table",
                    "viscous_nm_s_per_rad",
                    "N m s/rad",
                    load.viscous_nm_s_per_rad,
                    viscous,
                ),
                finding("load.table", "coulomb_nm", "N m", load.coulomb_nm, coulomb),
                finding(
                    "load.table",
                    "constant_nm",
                    "N m",
                    load.constant_nm,
                    body.constant,
                ),
            ],
            Load::Reflected(load) => vec![
                finding(
                    "load.reflected",
                    "inertia_kgm2",
                    "kg m2",
                    load.inertia_kgm2,
                    inertia.times(r * r),
                ),
                finding(
                    "load.reflected",
                    "viscous_nm_s_per_rad",
                    "N m s/rad",
                    load.viscous_nm_s_per_rad,
                    viscous.times(r * r),
                ),
                finding(
                    "load.reflected",
                    "coulomb_nm",
                    "N m",
                    load.coulomb_nm,
                    coulomb.times(r),
                ),
                finding(
                    "load.reflected",
                    "constant_nm",
                    "N m",
                    load.constant_nm,
                    body.constant.times(r),
                ),
            ],
        };
        findings.extend(self.decay_findings(body, axis, coulomb));
        findings
    }

    /// Friction that falls with speed, in the law that the description has: the Gaussian that was
    /// fitted, or a straight line of the same breakaway and area.
    fn decay_findings(&self, body: &RigidBody, axis: &AxisConfig, coulomb: Figure) -> Vec<Finding> {
        let Some(stribeck) = body.stribeck.filter(|_| coulomb.value > 0.0) else {
            return Vec::new();
        };
        let (table, described, scale) = match axis.friction.load {
            FrictionLaw::Coulomb => (STRIBECK_TABLE, [1.0, 0.0], STRAIGHT),
            FrictionLaw::Stribeck(law) => (
                STRIBECK_TABLE,
                [law.static_factor, law.speed_units_s],
                STRAIGHT,
            ),
            FrictionLaw::Lugre(law) => (
                "friction.load.lugre",
                [law.static_factor, law.speed_units_s],
                1.0,
            ),
        };
        let above = stribeck.above.times(1.0 / coulomb.value);
        vec![
            Finding {
                table,
                key: "static_factor",
                unit: "",
                described: described[0],
                measured: Figure {
                    value: 1.0 + above.value,
                    error: above.error,
                    interval: above.interval.map(|end| 1.0 + end),
                },
            },
            Finding {
                table,
                key: "speed_units_s",
                unit: "units/s",
                described: described[1],
                measured: stribeck.speed.times(scale / self.base),
            },
        ]
    }

    pub(super) fn servo_findings(
        &self,
        servo: &ServoGains,
        axis: &AxisConfig,
        by_current: bool,
    ) -> Vec<Finding> {
        let Some(law) = &servo.law else {
            return Vec::new();
        };
        let described = axis.drive.position_gain_per_s;
        let measured = law.position_gain_per_s;
        // Of two laws that explain the log alike, the one nearer to the description: the log does not
        // speak against it.
        let alike = law.alike.map(|[gain, _]| gain);
        let nearer =
            alike.filter(|gain| (gain - described).abs() < (measured.value - described).abs());
        let mut findings = vec![Finding {
            table: "drive",
            key: "position_gain_per_s",
            unit: "1/s",
            described,
            measured: nearer.map_or(measured, |gain| measured.times(gain / measured.value)),
        }];
        let forward = forward(law.feedforward);
        if (0.0..=1.0).contains(&forward) {
            findings.push(Finding {
                table: "drive",
                key: "velocity_feedforward",
                unit: "-",
                described: axis.drive.velocity_feedforward,
                measured: near(forward, FORWARD_WITHIN),
            });
        }
        let described = axis.drive.velocity_time_s;
        let of_nearer = law.alike.filter(|_| nearer.is_some()).map(|[_, time]| time);
        let time = match law.integral_time_s {
            Some(time) => {
                let nearer = of_nearer.unwrap_or(time.value);
                time.times(nearer / time.value)
            }
            // So long a one is none; what is longer than strokes last looks the same.
            None => Figure {
                interval: [LONG_INTEGRAL_S, NO_INTEGRAL_S],
                ..near(NO_INTEGRAL_S, 0.0)
            },
        };
        findings.push(Finding {
            table: "drive",
            key: "velocity_time_s",
            unit: "s",
            described,
            measured: time,
        });
        // A force asked for by a speed at the load, as a current asked for by one of the motor.
        if by_current && self.has_force() {
            findings.push(Finding {
                table: "drive",
                key: "velocity_gain_a_s_per_rad",
                unit: "A s/rad",
                described: axis.drive.velocity_gain_a_s_per_rad,
                measured: law.velocity_gain.times(self.per_rad / self.drive),
            });
        }
        findings
    }
}

/// None and all of the speed, which are what drives are set to, where the log does not tell it from
/// them.
fn forward(part: f64) -> f64 {
    [0.0, 1.0]
        .into_iter()
        .find(|whole| (part - whole).abs() <= FORWARD_WITHIN)
        .unwrap_or(part)
}

/// A figure that is right within so much either way.
fn near(value: f64, within: f64) -> Figure {
    Figure {
        value,
        error: within / 2.0,
        interval: [value - within, value + within],
    }
}

pub(super) fn gap_findings(fit: &BacklashFit, axis: &AxisConfig) -> Vec<Finding> {
    if !fit.excited {
        return Vec::new();
    }
    let per_rad = axis.transmission.load_per_motor_rad();
    let gap = gap_figure(fit, per_rad);
    let mut findings = match &axis.load {
        Load::Slide(load) => vec![Finding {
            table: "load.slide",
            key: "gap_um",
            unit: "um",
            described: load.gap_um,
            measured: gap.times(1e6),
        }],
        Load::Table(load) => vec![Finding {
            table: "load.table",
            key: "gap_mdeg",
            unit: "mdeg",
            described: load.gap_mdeg,
            measured: gap.times(1e3 * 1.0_f64.to_degrees()),
        }],
        Load::Reflected(load) => vec![Finding {
            table: "load.reflected",
            key: "gap_rad",
            unit: "rad",
            described: load.gap_rad,
            measured: gap.times(1.0 / per_rad),
        }],
    };
    // At the load: N/m from N m/rad of the motor.
    let told = (fit.stiffness_nm_per_rad, fit.stiffness_interval_nm_per_rad);
    if let (Some(value), [Some(low), Some(high)], Load::Slide(load)) = (told.0, told.1, &axis.load)
    {
        let at_load = Figure {
            value,
            error: 0.0,
            interval: [low, high],
        };
        findings.push(Finding {
            table: "load.slide",
            key: "stiffness_n_per_um",
            unit: "N/um",
            described: load.stiffness_n_per_um,
            measured: at_load.times(1e-6 / (per_rad * per_rad)),
        });
    }
    findings
}
