//! What to set on a control: the parameters that it has, and what they do to a program.
//!
//! ```text
//! 1  every way in which the control can be set, on one plan beside no compensation     the amounts that are best
//!    and, of Siemens, curves over the acceleration for the pulse that leaves least
//! 2  the best of them, told right and told wrong, beside what other controls could do   what is left, is it safe
//! 3  the same with the true gap at either end of its interval                           how sure that is
//! ```
//! Which is best, and what is safe, is the law of every comparison (the session's advice). Values are
//! rounded to what the control takes before they are simulated, so the printed setting is the
//! simulated one.

mod parameters;
pub mod results;

use crate::control::Control;
use crate::error::SimError;
use crate::machine::{Machine, PathStops};
use crate::method::Choice;
use crate::options::SimulateOptions;
use crate::program::Program;
use crate::results::{ErrorStats, MethodResult, Run};
use crate::session::unseen_gaps;
use crate::simulation::Simulation;
use lostmotion_base::units::deg;
use lostmotion_drive::config::{AxisUnit, Load};
use lostmotion_methods::{AxisConfig, MethodId};
use parameters::{Counting, ToldAxis, gap_of, parameters, step, unknown};
use results::{Better, ControlSettings, GapEnd, SETTINGS_SCHEMA_VERSION};
use std::sync::Arc;

/// What is asked for besides the control.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RecommendOptions {
    /// How far off the gap of the machine description may be, as a part of it, below 1; as each axis
    /// says (`compensation.gap_uncertainty`) if `None`.
    pub gap_uncertainty: Option<f64>,
    /// Detection unit of a Fanuc control, um.
    pub detection_unit_um: f64,
}

impl Default for RecommendOptions {
    fn default() -> RecommendOptions {
        RecommendOptions {
            gap_uncertainty: None,
            detection_unit_um: 1.0,
        }
    }
}

/// Methods that no control here has, and that show what there is to gain.
const BEYOND: [&str; 2] = ["adaptive", "lookup"];

/// A way in which a control can be set.
#[derive(Clone)]
struct Trial {
    method: MethodId,
    said: String,
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
            change: Arc::new(change),
        })
    }

    fn name(&self) -> String {
        format!("{} {}", self.method, self.said).trim().to_owned()
    }

    /// The machine with it.
    fn on(&self, told: &Machine) -> Machine {
        told.map_axes(|config| {
            let mut config = config.clone();
            (self.change)(&mut config);
            config
        })
    }

    /// Whether there are numbers to set for it, or a reason why it cannot be set.
    fn has_numbers(&self, told: &Machine, control: Control, counting: &Counting) -> bool {
        let set = axes(&self.on(told));
        parameters(control, self.method.name(), &set, counting)
            .map_or(true, |found| !found.settings.is_empty())
    }

    fn choice(&self) -> Choice {
        let change = Arc::clone(&self.change);
        Choice::set(self.name(), self.method, move |config| change(config))
    }
}

/// The settings of a control for a program on a machine.
///
/// ```
/// use lostmotion_sim::control::Control;
/// use lostmotion_sim::recommend::{RecommendOptions, recommend};
/// use lostmotion_sim::{Machine, Program, SimulateOptions};
///
/// let program = Program::from_str("arc.ngc", "G21 G90 G17\nG0 X9 Y0\nG3 I-9 F900\nM2\n");
/// let machine = Machine::preset("vmc3-worn")?;
/// let wanted = RecommendOptions::default();
/// let options = SimulateOptions::default();
/// let answer = recommend(&program, &machine, &options, Control::LinuxCnc, &wanted)?;
/// // A gap of 40 um and the wind-up of the drive.
/// assert!(answer.paste[1].starts_with("BACKLASH = 0.05"));
/// assert!(answer.after.rms < 0.5 * answer.before.rms);
/// // No primary source: no number.
/// let haas = recommend(&program, &machine, &options, Control::Haas, &wanted)?;
/// assert!(haas.refused.is_some() && haas.settings.is_empty());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// As [`Simulation::run`]; an uncertainty or a detection unit out of range.
pub fn recommend(
    program: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    control: Control,
    wanted: &RecommendOptions,
) -> Result<ControlSettings, SimError> {
    check(wanted)?;
    let mut answer = ControlSettings {
        schema: SETTINGS_SCHEMA_VERSION,
        program: program.name().to_owned(),
        machine: machine.name().to_owned(),
        control: control.name().to_owned(),
        ..ControlSettings::default()
    };
    let options = SimulateOptions {
        control: Some(control),
        ..options.clone()
    };
    // Of controls that stop to compensate the stops belong to what is set.
    let counting = Counting {
        detection_unit_um: wanted.detection_unit_um,
        units: machine.control_units(),
        joints: machine.joint_axes(),
    };
    let told = told(machine, control, &counting, wanted).with_stops(control.stops());
    if let Some(method) = machine
        .axes()
        .iter()
        .map(|axis| axis.config.compensation.method)
        .find(|m| !m.is_baseline())
    {
        answer.notes.push(format!(
            "the machine description has {method} set already; \"before\" is without any compensation"
        ));
    }
    // Step 1: amounts that are not measured are sought.
    let trials = trials(control);
    if trials.is_empty() {
        answer.refused = Some(unknown(control));
        let run = simulate(program, machine, &without_tests(&options), vec![baseline()])?;
        answer.runs += 1;
        fill_baseline(&mut answer, machine, &run);
        return Ok(answer);
    }
    let choices = std::iter::once(baseline()).chain(trials.iter().map(Trial::choice));
    let first = simulate(program, &told, &without_tests(&options), choices.collect())?;
    answer.runs += 1 + trials.len() as u64;
    if control.stops() == PathStops::Never {
        fill_baseline(&mut answer, machine, &first);
    } else {
        let run = simulate(program, machine, &without_tests(&options), vec![baseline()])?;
        answer.runs += 1;
        fill_baseline(&mut answer, machine, &run);
        let [with_s, without_s] = [first.plan.duration_s, run.plan.duration_s];
        answer.notes.extend(stops_cost(control, with_s, without_s));
    }
    let curves = match curve_trials(control, &first, &trials) {
        curves if curves.is_empty() => None,
        curves => Some(curves),
    };
    let mut best = trials
        .iter()
        .find(|trial| Some(trial.name()) == first.recommended)
        .cloned();
    // Step 1b: a pulse that is the same at all accelerations against curves over them.
    if let Some(curves) = curves {
        let all: Vec<Trial> = best.iter().cloned().chain(curves).collect();
        let choices = std::iter::once(baseline()).chain(all.iter().map(Trial::choice));
        let run = simulate(program, &told, &without_tests(&options), choices.collect())?;
        answer.runs += 1 + all.len() as u64;
        answer.notes.push(best_curve(&run, &first));
        let found = |trial: &&Trial| Some(trial.name()) == run.recommended;
        best = all.iter().find(found).cloned().or(best);
    }
    // Step 1c: what has no numbers here is no advice; the best of those that have.
    if let Some(unset) = best.take_if(|best| !best.has_numbers(&told, control, &counting)) {
        let other = trials
            .iter()
            .filter(|trial| trial.has_numbers(&told, control, &counting));
        let rest: Vec<Trial> = other.cloned().collect();
        let choices = std::iter::once(baseline()).chain(rest.iter().map(Trial::choice));
        let run = simulate(program, &told, &without_tests(&options), choices.collect())?;
        answer.runs += 1 + rest.len() as u64;
        if let Some(left) = first.result(&unset.name()) {
            let (rms, max) = (left.cutting.rms, left.cutting.max);
            answer.notes.push(format!(
                "best for the program is {}, RMS {rms:.2} um, at most {max:.2} um: no primary source tells here how it is set",
                unset.name()
            ));
        }
        let found = |trial: &Trial| Some(trial.name()) == run.recommended;
        best = rest.into_iter().find(found);
        if best.is_none() {
            answer.refused = Some(format!(
                "the one way that helps is {}, and no primary source tells here how it is set: no number is printed",
                unset.name()
            ));
            let set = unset.on(&told);
            if let Ok(found) = parameters(control, unset.method.name(), &axes(&set), &counting) {
                answer.notes.extend(found.notes);
            }
            return Ok(answer);
        }
    }
    let Some(best) = best else {
        answer.refused = Some(refusal(&first));
        return Ok(answer);
    };
    // Step 1d: a dial gauge measures gap and wind-up together, and the description tells both.
    let mut candidates = vec![best];
    let steps = [false, true].map(|is_rotary| step(control, &counting, is_rotary));
    if let Some(wound) = wound_up(&candidates[0], &told, steps) {
        let both = [&candidates[0], &wound];
        let choices = std::iter::once(baseline()).chain(both.map(Trial::choice));
        let run = simulate(program, &told, &without_tests(&options), choices.collect())?;
        answer.runs += 3;
        if Some(wound.name()) == run.recommended {
            candidates.insert(0, wound);
        }
    }
    // Step 2: as set, and told wrong. Where that speaks against the wind-up, the gap alone is left.
    let mut tried = None;
    for candidate in candidates {
        let set = candidate.on(&told);
        let methods = [MethodId::NONE, candidate.method].map(Choice::Registered);
        let run = simulate(program, &set, &options, methods.into())?;
        let result = run.result(candidate.method.name());
        answer.runs += 2 + result.map_or(0, |result| result.misled.len() as u64);
        let is_safe = result.is_some_and(|result| result.not_recommended.is_none());
        tried = Some((candidate, set, run));
        if is_safe {
            break;
        }
    }
    let Some((best, set, second)) = tried else {
        return Ok(answer);
    };
    answer.chosen.clone_from(&best.said);
    let Some(result) = second.result(best.method.name()) else {
        return Ok(answer);
    };
    answer.after = result.cutting;
    answer.wrong.clone_from(&result.misled);
    answer.trust.clone_from(&second.trust);
    answer.notes.extend(result.notes.iter().cloned());
    answer.notes.extend(wind_up_note(&told, &set));
    answer.better = beyond(program, machine, &options, &mut answer)?;
    if let Some(reason) = &result.not_recommended {
        answer.refused = Some(format!("{}: {reason}", best.name()));
        return Ok(answer);
    }
    // What is printed is what was simulated.
    match parameters(control, best.method.name(), &axes(&set), &counting) {
        Ok(found) => {
            answer.method = Some(best.method.name().to_owned());
            answer.within_tolerance = result.within_tolerance;
            answer.settings = found.settings;
            answer.paste = found.paste;
            answer.preconditions = found.preconditions;
            answer.notes.extend(found.notes);
            answer.source = found.source.to_owned();
        }
        Err(reason) => {
            answer.refused = Some(reason);
            return Ok(answer);
        }
    }
    // Step 3: the ends of the interval.
    let of_axes = machine.axes().iter();
    let share = of_axes
        .map(|axis| uncertainty(&axis.config, wanted.gap_uncertainty))
        .fold(0.0, f64::max);
    answer.gap_uncertainty = wanted.gap_uncertainty.or((share > 0.0).then_some(share));
    if share > 0.0 {
        for sign in [-1.0, 1.0] {
            let end = with_gaps_at(&set, machine, wanted, sign);
            let choices = [MethodId::NONE, best.method].map(Choice::Registered);
            let run = simulate(program, &end, &without_tests(&options), choices.into())?;
            answer.runs += 2;
            let stats = |name: &str| {
                run.result(name)
                    .map_or(ErrorStats::default(), |r| r.cutting)
            };
            answer.uncertain.push(GapEnd {
                factor: 1.0 + sign * share,
                before: stats(MethodId::NONE.name()),
                after: stats(best.method.name()),
                stops: run
                    .result(best.method.name())
                    .is_some_and(|r| r.stop.is_some()),
            });
        }
    }
    Ok(answer)
}

/// The same with the wind-up of the drive added to every told gap: what friction twists the drive by from
/// one direction to the other, `2 F/k`. `None` for a method that is not told a length, and where
/// the wind-up is below what the control takes.
fn wound_up(best: &Trial, told: &Machine, steps: [f64; 2]) -> Option<Trial> {
    if !best.method.told_gap() || best.method.name() == PULSE {
        return None;
    }
    // The told amount with it, in steps of the control, mm or deg.
    let amount = move |config: &AxisConfig| {
        let load = config.reflected_load();
        let is_rotary = config.transmission.unit() != AxisUnit::Mm;
        let step = steps[usize::from(is_rotary)];
        let wind_up = 2.0 * load.coulomb_nm / load.stiffness_nm_per_rad;
        let wind_up = (units(config, is_rotary, wind_up) / step).round() * step;
        let told = config
            .compensation
            .fixed
            .gap?
            .motor_rad(&config.transmission);
        let value = units(config, is_rotary, told) + wind_up;
        (wind_up > 0.0).then(|| gap_of((value / step).round() * step, is_rotary))
    };
    told.axes()
        .iter()
        .any(|axis| amount(&axis.config).is_some())
        .then_some(())?;
    let before = Arc::clone(&best.change);
    let said = [best.said.as_str(), "gap and wind-up"];
    let said = said.map(str::trim).into_iter().filter(|it| !it.is_empty());
    Some(Trial {
        method: best.method,
        said: said.collect::<Vec<_>>().join(", "),
        change: Arc::new(move |config| {
            before(config);
            if let Some(gap) = amount(config) {
                config.compensation.tell_gap(gap);
            }
        }),
    })
}

/// How much of the told amounts is wind-up, if any of it is.
fn wind_up_note(told: &Machine, set: &Machine) -> Option<String> {
    let parts: Vec<String> = axes(told)
        .iter()
        .zip(axes(set))
        .map(|(gap, both)| (1e3 * (both.gap - gap.gap), both))
        .filter(|(more, _)| *more > 0.0)
        .map(|(more, axis)| {
            let unit = if axis.is_rotary { "mdeg" } else { "um" };
            format!("{} {more:.1} {unit}", axis.name)
        })
        .collect();
    (!parts.is_empty()).then(|| {
        format!(
            "in the amounts is the wind-up of the drive, twice the friction over the stiffness: {}",
            parts.join(", ")
        )
    })
}

/// What methods would leave that no control here has; of one that does not work on this machine a note
/// says why.
fn beyond(
    program: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    answer: &mut ControlSettings,
) -> Result<Vec<Better>, SimError> {
    let mut methods = Vec::new();
    for method in BEYOND
        .iter()
        .filter_map(|name| name.parse::<MethodId>().ok())
    {
        let refused = machine
            .axes()
            .iter()
            .find_map(|axis| Some((axis.id, method.suits(&axis.config).err()?)));
        match refused {
            None => methods.push(Choice::Registered(method)),
            Some((axis, error)) => answer
                .notes
                .push(format!("{method} is not compared: {axis}: {error}")),
        }
    }
    if methods.is_empty() {
        return Ok(Vec::new());
    }
    answer.runs += methods.len() as u64;
    let run = simulate(program, machine, &without_tests(options), methods)?;
    let better = run.results.iter().map(|result| Better {
        method: result.method.clone(),
        cutting: result.cutting,
        stops: result.stop.is_some(),
    });
    Ok(better.collect())
}

/// Parts of the axes' largest acceleration between which a pulse's height may change: where it has
/// risen, where it begins to fall, where it has fallen.
const CURVES: [[f64; 3]; 3] = [[0.001, 0.02, 0.2], [0.005, 0.05, 0.5], [0.02, 0.2, 0.8]];
/// Heights beyond the last acceleration, as parts of the largest.
const LEAST_HEIGHTS: [f64; 2] = [0.5, 0.0];

/// Siemens' friction compensation with an adaptation characteristic: curves over the acceleration for
/// the constant pulse that leaves least.
fn curve_trials(control: Control, run: &Run, trials: &[Trial]) -> Vec<Trial> {
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
    all.into_iter().flatten().collect()
}

/// The method that stands for a friction compensation by a pulse.
const PULSE: &str = "decaying-pulse";

/// What the best curve leaves beside the best constant pulse.
fn best_curve(run: &Run, first: &Run) -> String {
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

fn check(wanted: &RecommendOptions) -> Result<(), SimError> {
    let refuse = |what: &'static str, value: f64, condition: &'static str| SimError::Option {
        what,
        value,
        condition,
    };
    if let Some(share) = wanted.gap_uncertainty
        && !(0.0..1.0).contains(&share)
    {
        return Err(refuse(
            "gap_uncertainty",
            share * 100.0,
            "from 0 to below 100 (per cent)",
        ));
    }
    let unit = wanted.detection_unit_um;
    if !(1e-4..=1000.0).contains(&unit) {
        return Err(refuse("detection_unit_um", unit, "from 0.0001 to 1000"));
    }
    Ok(())
}

fn baseline() -> Choice {
    Choice::Registered(MethodId::NONE)
}

/// The same without telling methods anything wrong.
fn without_tests(options: &SimulateOptions) -> SimulateOptions {
    SimulateOptions {
        misled_share: Some(0.0),
        ..options.clone()
    }
}

fn simulate(
    program: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    choices: Vec<Choice>,
) -> Result<Run, SimError> {
    let simulation = Simulation::new(program, machine).options(options.clone());
    choices
        .into_iter()
        .fold(simulation, Simulation::choice)
        .run()
}

fn fill_baseline(answer: &mut ControlSettings, machine: &Machine, run: &Run) {
    answer.tolerance_um = run.tolerance_um;
    answer.without_gap = run.without_gap;
    if let Some(none) = run.first() {
        answer.before = none.cutting;
        answer.within_tolerance = none.within_tolerance;
        answer.notes.extend(unseen_gaps(machine, none));
    }
}

/// Why none of the ways to set a control is better than leaving it alone, and the blocks that tell it.
fn refusal(run: &Run) -> String {
    let refused = run
        .results
        .iter()
        .find_map(|result| Some((result, result.not_recommended.as_deref()?)));
    let Some((result, reason)) = refused else {
        return format!(
            "leave the compensation off: nothing that the control offers makes the error smaller{}",
            run.first()
                .map_or_else(String::new, |none| worst_block(none, "the worst block is"))
        );
    };
    let without = run.first().filter(|none| none.method != result.method);
    format!(
        "leave the compensation off: {}: {reason}{}{}",
        result.method,
        worst_block(result, "its worst block is"),
        without.map_or_else(String::new, |none| worst_block(none, "without it"))
    )
}

/// The block with the largest error of a result, behind some words; nothing where there is none.
fn worst_block(result: &MethodResult, words: &str) -> String {
    let worst = result.blocks().next();
    worst.map_or_else(String::new, |worst| {
        format!(
            "; {words} line {} ({:.2} um, `{}`)",
            worst.line,
            worst.result.max_um.abs(),
            worst.result.text
        )
    })
}

/// How far off the gap of an axis may be, as a part of it: as told, or as the axis says.
pub(crate) fn uncertainty(config: &AxisConfig, told: Option<f64>) -> f64 {
    told.unwrap_or(config.compensation.gap_uncertainty)
}

/// The machine as set, with its true gaps at an end of their intervals.
fn with_gaps_at(set: &Machine, machine: &Machine, wanted: &RecommendOptions, sign: f64) -> Machine {
    let factor = |config: &AxisConfig| 1.0 + sign * uncertainty(config, wanted.gap_uncertainty);
    let mut end = set.clone();
    for (axis, of_set) in machine.axes().iter().zip(set.axes()) {
        let config = with_gap_times(&of_set.config, factor(&axis.config));
        end = end.with_axis_config(axis.id, &config);
    }
    if let (Some(gantry), Some(of_set)) = (machine.gantry(), set.gantry()) {
        let config = with_gap_times(&of_set.second, factor(&gantry.second));
        end = end.with_second_config(&config);
    }
    end
}

/// The axis with a gap of another size.
pub(crate) fn with_gap_times(config: &AxisConfig, factor: f64) -> AxisConfig {
    let mut load = config.reflected_load();
    load.gap_rad *= factor;
    AxisConfig {
        load: Load::Reflected(load),
        ..config.clone()
    }
}

/// An angle of the motor, in mm or deg of the axis.
fn units(config: &AxisConfig, is_rotary: bool, motor_rad: f64) -> f64 {
    let units = motor_rad / config.transmission.motor_rad_per_unit();
    if is_rotary && config.transmission.unit() == AxisUnit::Rad {
        deg(units)
    } else {
        units
    }
}

/// The machine as its control is told of it: the gap rounded to what the control takes, the least
/// that it may be, and the limits of the joints.
fn told(
    machine: &Machine,
    control: Control,
    counting: &Counting,
    wanted: &RecommendOptions,
) -> Machine {
    let mut told = machine.map_axes(|config| {
        let mut config = config.clone();
        let is_rotary = config.transmission.unit() != AxisUnit::Mm;
        let least = units(&config, is_rotary, config.reflected_load().gap_rad)
            * (1.0 - uncertainty(&config, wanted.gap_uncertainty));
        let step = step(control, counting, is_rotary);
        let value = (least / step).round() * step;
        config.compensation.tell_gap(gap_of(value, is_rotary));
        // The least has been taken.
        config.compensation.gap_uncertainty = 0.0;
        config
    });
    for axis in machine.axes() {
        let Some(mut config) = told.axis(axis.id).map(|axis| axis.config.clone()) else {
            continue;
        };
        let (velocity, acceleration) = limits(axis);
        let linuxcnc = &mut config.compensation.fixed_linuxcnc;
        linuxcnc.velocity_units_s = Some(velocity);
        linuxcnc.acceleration_units_s2 = Some(acceleration);
        // 100 %, of which a trial takes a part.
        config.compensation.fixed_mach3.speed_units_s = velocity;
        told = told.with_axis_config(axis.id, &config);
    }
    told
}

/// Largest speed and acceleration of an axis, mm or deg per s and s2.
fn limits(axis: &crate::machine::MachineAxis) -> (f64, f64) {
    let limits = axis.limits_table().limits();
    if axis.is_rotary() {
        (deg(limits.velocity), deg(limits.acceleration))
    } else {
        (limits.velocity, limits.acceleration)
    }
}

/// The axes of a machine that has been told, in their order, with second motors.
fn axes(set: &Machine) -> Vec<ToldAxis> {
    let mut all = Vec::new();
    for axis in set.axes() {
        let (velocity, acceleration) = limits(axis);
        let second = set
            .gantry()
            .filter(|gantry| gantry.axis == axis.id)
            .map(|gantry| (format!("{}2", axis.id), gantry.second.clone()));
        let first = (axis.id.to_string(), axis.config.clone());
        for (name, config) in std::iter::once(first).chain(second) {
            let is_rotary = axis.is_rotary();
            let told = config.compensation.fixed.gap;
            let per_unit = config.transmission.motor_rad_per_unit();
            let units = told.map_or(0.0, |gap| gap.motor_rad(&config.transmission) / per_unit);
            let turns = config.transmission.unit() == AxisUnit::Rad;
            all.push(ToldAxis {
                id: axis.id,
                name,
                is_rotary,
                gap: if turns { deg(units) } else { units },
                velocity,
                acceleration,
                config,
            });
        }
    }
    all
}

/// What stops to take the gap up cost of a program's time, s; nothing where that is next to nothing.
fn stops_cost(control: Control, with_s: f64, without_s: f64) -> Option<String> {
    let more_s = with_s - without_s;
    let cost = if more_s.abs() >= 0.01 {
        format!("{with_s:.2} s in place of {without_s:.2}")
    } else if more_s.abs() >= 1e-5 {
        format!("{:.2} ms of {without_s:.2} s", 1e3 * more_s)
    } else {
        return None;
    };
    let place = control.stops().place();
    Some(format!(
        "the control stops {place} to take the gap up: {cost}"
    ))
}

/// The ways in which a control can be set: each method that it has, with the amounts that are sought.
fn trials(control: Control) -> Vec<Trial> {
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
                    }));
                }
            }
            _ => all.push(Trial::new(method, "", |_| ())),
        }
    }
    all.into_iter().flatten().collect()
}
