//! The ways in which a control can be set, each a change of the machine's axes.

use super::parameters::{Counting, gap_of, parameters, sets_rotary};
use super::told::{axes, is_rotary, told_alike, told_gap, wind_up};
use crate::control::Control;
use crate::machine::Machine;
use crate::method::Choice;
use crate::results::Run;
use lostmotion_methods::{AxisConfig, MethodId};
use std::sync::Arc;

/// The method that stands for a friction compensation by a pulse.
const PULSE: &str = "decaying-pulse";

/// A way in which a control can be set.
#[derive(Clone)]
pub(super) struct Trial {
    pub(super) method: MethodId,
    pub(super) said: String,
    /// What the control takes of a told gap, mm and deg: it is rounded to that.
    steps: [f64; 2],
    /// Whether the wind-up of the drive is in what is told.
    is_wound: bool,
    /// Whether the control has settings for axes that turn; else they are left alone.
    sets_rotary: bool,
    /// Whether both motors of an axis have settings of their own.
    has_own_motors: bool,
    change: Arc<dyn Fn(&mut AxisConfig) + Send + Sync>,
}

impl Trial {
    fn new(
        method: &str,
        said: impl Into<String>,
        change: impl Fn(&mut AxisConfig) + Send + Sync + 'static,
    ) -> Option<Trial> {
        Some(Trial {
            method: method.parse().ok()?,
            said: said.into(),
            steps: [0.0; 2],
            is_wound: false,
            sets_rotary: true,
            has_own_motors: true,
            change: Arc::new(change),
        })
    }

    pub(super) fn name(&self) -> String {
        format!("{} {}", self.method, self.said).trim().to_owned()
    }

    /// The machine with it.
    pub(super) fn on(&self, told: &Machine) -> Machine {
        let set = told.map_axes(|config| {
            let mut config = config.clone();
            self.change(&mut config);
            config
        });
        if self.has_own_motors {
            set
        } else {
            told_alike(set)
        }
    }

    /// Sets an axis, its gap rounded to what the control takes.
    fn change(&self, config: &mut AxisConfig) {
        (self.change)(config);
        let is_rotary = is_rotary(config);
        if is_rotary && !self.sets_rotary {
            config.compensation.tell_gap(gap_of(0.0, true));
            config.compensation.decaying_pulse.height_units_s = Some(0.0);
            return;
        }
        let step = self.steps[usize::from(is_rotary)];
        if let Some(told) = told_gap(config).filter(|_| step > 0.0) {
            config
                .compensation
                .tell_gap(gap_of((told / step).round() * step, is_rotary));
        }
    }

    /// Whether there are numbers to set for it, or a reason why it cannot be set.
    pub(super) fn has_numbers(
        &self,
        told: &Machine,
        control: Control,
        counting: &Counting,
    ) -> bool {
        let set = axes(&self.on(told), counting);
        parameters(control, self.method.name(), &set, counting)
            .map_or(true, |found| !found.settings.is_empty())
    }

    /// Whether a control can be told of the wind-up, which is at least half of its step. What it takes up
    /// already has been measured with it.
    fn takes_wind_up(&self, config: &AxisConfig) -> bool {
        let is_rotary = is_rotary(config);
        (!is_rotary || self.sets_rotary)
            && !is_set_already(config)
            && wind_up(config, is_rotary) >= 0.5 * self.steps[usize::from(is_rotary)]
    }

    pub(super) fn choice(&self) -> Choice {
        let own = self.clone();
        Choice::set(self.name(), self.method, move |config| own.change(config))
    }
}

/// The ways in which a control can be set: each method that it has, with the amounts that are sought.
pub(super) fn trials(control: Control, steps: [f64; 2], has_own_motors: bool) -> Vec<Trial> {
    let mut all = Vec::new();
    for method in control.methods() {
        let method = *method;
        match method {
            "actual-value" if control == Control::Heidenhain => {
                for ms in [0.0, 10.0, 20.0, 40.0] {
                    all.push(Trial::new(method, format!("over {ms} ms"), move |config| {
                        config.compensation.actual_value.spread_ms = ms;
                    }));
                }
            }
            PULSE => {
                for ms in [8.0, 15.0, 30.0] {
                    for part in [0.5, 1.0, 2.0] {
                        let said = format!("of {part} gaps over {ms} ms");
                        all.push(Trial::new(method, said, move |config| {
                            let gap = config.reflected_load().gap_rad;
                            let per_unit = config.transmission.motor_rad_per_unit();
                            let pulse = &mut config.compensation.decaying_pulse;
                            // In steps of 1 um/s, far below what a control takes.
                            let height = part * gap / per_unit / (ms * 1e-3);
                            pulse.height_units_s = Some((height * 1e3).round() * 1e-3);
                            pulse.time_ms = ms;
                        }));
                    }
                }
            }
            "friction-torque" => {
                for part in [0.5, 1.0, 1.5] {
                    let said = format!("of {part} times the standard");
                    all.push(Trial::new(method, said, move |config| {
                        // Whole per cent of the rated torque.
                        let friction = 2.0 * config.reflected_load().coulomb_nm;
                        let percent = 0.01 * config.motor.rated_torque_nm;
                        let amount = (part * friction / percent).round() * percent;
                        config.compensation.friction_torque.amount_nm = Some(amount);
                    }));
                }
            }
            "fixed-isg" => {
                for cycles in [1, 5, 10, 19] {
                    all.push(Trial::new(
                        method,
                        format!("over {cycles} cycles"),
                        move |config| {
                            config.compensation.fixed_isg.cycles = cycles;
                        },
                    ));
                }
            }
            "fixed-mach3" => {
                for percent in [0.5, 1.0, 2.0, 5.0] {
                    let said = format!("at {percent} % of the largest speed");
                    all.push(Trial::new(method, said, move |config| {
                        config.compensation.fixed_mach3.speed_units_s *= 0.01 * percent;
                    }));
                }
            }
            "fixed-by-travel" => {
                let ways: &[(f64, f64)] = match control {
                    Control::Marlin => &[(1.0, 0.0), (1.0, 1.0), (1.0, 3.0)],
                    Control::RepRapFirmware => {
                        &[(1.0, 0.0), (2.0, 0.0), (5.0, 0.0), (10.0, 0.0), (20.0, 0.0)]
                    }
                    _ => &[(1.0, 0.0)],
                };
                for &(multiple, smoothing_mm) in ways {
                    let said = match control {
                        Control::Marlin => format!("smoothed over {smoothing_mm} mm"),
                        Control::RepRapFirmware if multiple > 1.0 => {
                            format!("over {multiple} gaps")
                        }
                        Control::RepRapFirmware => "over 1 gap".to_owned(),
                        _ => String::new(),
                    };
                    all.push(Trial::new(method, said, move |config| {
                        let spread = &mut config.compensation.fixed_by_travel;
                        (spread.multiple, spread.smoothing_mm) = (multiple, smoothing_mm);
                        // Whatever part the control corrects today: the amounts are those of all of it.
                        spread.correction = 1.0;
                    }));
                }
            }
            _ => all.push(Trial::new(method, "", |_| ())),
        }
    }
    let all = all.into_iter().flatten();
    all.map(|trial| Trial {
        steps,
        sets_rotary: sets_rotary(control, trial.method.name()),
        has_own_motors,
        ..trial
    })
    .collect()
}

/// Whether the control of an axis takes its gap up already: what is set there has been measured on the
/// machine, as by a dial gauge, which shows gap and wind-up together.
fn is_set_already(config: &AxisConfig) -> bool {
    let method = config.compensation.method;
    !method.is_baseline() && method.told_gap()
}

/// Says of which axes the amount that the control has is taken for gap and wind-up together.
pub(super) fn set_already_note(
    tried: &Trial,
    set: &Machine,
    counting: &Counting,
) -> Option<String> {
    let axes = axes(set, counting);
    let alone = axes.iter().filter(|axis| is_set_already(&axis.config));
    let names: Vec<&str> = alone.map(|axis| axis.name.as_str()).collect();
    (tried.method.told_gap() && !names.is_empty()).then(|| {
        format!(
            "the control takes up the gap of {} already: that amount is taken for gap and wind-up together, as a gauge shows them, and no wind-up is added",
            names.join(", ")
        )
    })
}

/// The same with the wind-up of the drive added to every told gap: what friction twists the drive by from
/// one direction to the other, `2 F/k`. `None` for a method that is not told a length, and where
/// the wind-up is below what the control takes.
pub(super) fn wound_up(best: &Trial, told: &Machine) -> Option<Trial> {
    if best.is_wound || !best.method.told_gap() || best.method.name() == PULSE {
        return None;
    }
    let is_taken = {
        let best = best.clone();
        move |config: &AxisConfig| best.takes_wind_up(config)
    };
    if !told.axes().iter().any(|axis| is_taken(&axis.config)) {
        return None;
    }
    let before = Arc::clone(&best.change);
    let said = [best.said.as_str(), "gap and wind-up"];
    let said = said.map(str::trim).into_iter().filter(|it| !it.is_empty());
    Some(Trial {
        said: said.collect::<Vec<_>>().join(", "),
        is_wound: true,
        change: Arc::new(move |config| {
            before(config);
            let is_rotary = is_rotary(config);
            if let Some(gap) = told_gap(config).filter(|_| is_taken(config)) {
                let both = gap + wind_up(config, is_rotary);
                config.compensation.tell_gap(gap_of(both, is_rotary));
            }
        }),
        ..best.clone()
    })
}

/// How much of the told amounts is wind-up, if any of it is.
pub(super) fn wind_up_note(tried: &Trial, set: &Machine, counting: &Counting) -> Option<String> {
    let axes = axes(set, counting);
    let of_axis = axes
        .iter()
        .filter(|axis| tried.is_wound && tried.takes_wind_up(&axis.config));
    let parts: Vec<String> = of_axis
        .map(|axis| {
            let unit = if axis.is_rotary { "mdeg" } else { "um" };
            // Amounts are rounded to what the control takes.
            let wind_up = 1e3 * wind_up(&axis.config, axis.is_rotary);
            format!("{} {wind_up:.1} {unit}", axis.name)
        })
        .collect();
    (!parts.is_empty()).then(|| {
        format!(
            "in the amounts is the wind-up of the drive, twice the friction over the stiffness: {}",
            parts.join(", ")
        )
    })
}

/// Parts of the axes' largest acceleration between which a pulse's height may change: where it has
/// risen, where it begins to fall, where it has fallen.
const CURVES: [[f64; 3]; 3] = [[0.001, 0.02, 0.2], [0.005, 0.05, 0.5], [0.02, 0.2, 0.8]];
/// Heights beyond the last acceleration, as parts of the largest.
const LEAST_HEIGHTS: [f64; 2] = [0.5, 0.0];

/// Siemens' friction compensation with an adaptation characteristic: curves over the acceleration for
/// the constant pulse that leaves least.
pub(super) fn curve_trials(control: Control, run: &Run, trials: &[Trial]) -> Vec<Trial> {
    let pulses = trials.iter().filter_map(|trial| {
        let rms = run.result(&trial.name())?.cutting.rms;
        (control == Control::Siemens && trial.method.name() == PULSE).then_some((trial, rms))
    });
    let Some((pulse, _)) = pulses.min_by(|a, b| a.1.total_cmp(&b.1)) else {
        return Vec::new();
    };
    let mut all = Vec::new();
    for parts in CURVES {
        for least in LEAST_HEIGHTS {
            let percent = parts.map(|part| 100.0 * part);
            let said = format!(
                "{}, over accelerations of {percent:?} % of the largest, {least} of it beyond",
                pulse.said
            );
            let constant = Arc::clone(&pulse.change);
            all.push(Trial::new(PULSE, said, move |config| {
                constant(config);
                let largest = config.compensation.fixed_linuxcnc.acceleration_units_s2;
                let pulse = &mut config.compensation.decaying_pulse;
                // In steps of 1 mm/s2 and 1 um/s, far below what a control takes.
                let round = |value: f64, step: f64| (value / step).round() * step;
                pulse.acceleration_units_s2 =
                    largest.map(|most| parts.map(|part| round(part * most, 1.0).max(1.0)));
                pulse.least_height_units_s = pulse
                    .height_units_s
                    .map(|height| round(least * height, 1e-3));
            }));
        }
    }
    let all = all.into_iter().flatten();
    let Trial {
        steps,
        sets_rotary,
        has_own_motors,
        ..
    } = *pulse;
    all.map(|trial| Trial {
        steps,
        sets_rotary,
        has_own_motors,
        ..trial
    })
    .collect()
}

/// What the best curve leaves beside the best constant pulse.
pub(super) fn best_curve(run: &Run, first: &Run) -> String {
    let least = |run: &Run, is_curve: bool| {
        let of_kind = run.results.iter().filter(|result| {
            result.method.starts_with(PULSE) && result.method.contains("accelerations") == is_curve
        });
        let rms = of_kind.map(|result| result.cutting.rms);
        rms.fold(f64::INFINITY, f64::min)
    };
    format!(
        "friction compensation (MD32490): with the best curve over the acceleration RMS {:.2} um, with the best constant pulse {:.2} um",
        least(run, true),
        least(first, false)
    )
}
