//! What to set on a control: the parameters that it has, and what they do to a program.
//!
//! ```text
//! 1  every way in which the control can be set, on one plan beside no compensation     the amounts that are best
//!    and, of Siemens, curves over the acceleration for the pulse that leaves least
//! 2  the best of them, told right and told wrong, and with the true gap at either end of its interval;
//!    beside what other controls could do                                               what is left, is it safe
//! ```
//! Which is best, and what is safe, is the law of every comparison (the session's advice). Values are
//! rounded to what the control takes before they are simulated, so the printed setting is the
//! simulated one.

mod parameters;
pub mod results;
mod told;
mod trials;

pub(crate) use told::{WIDEST, uncertainty, with_gap_times};

use crate::control::Control;
use crate::error::SimError;
use crate::machine::{Machine, PathStops};
use crate::method::Choice;
use crate::options::SimulateOptions;
use crate::program::Program;
use crate::results::{ErrorStats, MethodResult, Run};
use crate::session::{unsafe_but_for_gap, unseen_gaps, worse};
use crate::simulation::Simulation;
use lostmotion_methods::MethodId;
use parameters::{Counting, parameters, step, unknown};
use results::{Better, ControlSettings, GapEnd, SETTINGS_SCHEMA_VERSION};
use told::{axes, measure_first, one_setting, told, with_gaps_at};
use trials::{Trial, best_curve, curve_trials, set_already_note, trials, wind_up_note, wound_up};

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
    let counting = Counting::new(control, machine, wanted.detection_unit_um);
    let advice = Advice {
        program,
        machine,
        options: SimulateOptions {
            control: Some(control),
            ..options.clone()
        },
        control,
        wanted,
        // Of controls that stop to compensate the stops belong to what is set.
        told: told(machine, wanted, &counting).with_stops(control.stops()),
        counting,
        answer: ControlSettings {
            schema: SETTINGS_SCHEMA_VERSION,
            program: program.name().to_owned(),
            machine: machine.name().to_owned(),
            control: control.name().to_owned(),
            ..ControlSettings::default()
        },
    };
    advice.given()
}

/// An answer that is being made.
struct Advice<'a> {
    program: &'a Program,
    machine: &'a Machine,
    options: SimulateOptions,
    control: Control,
    wanted: &'a RecommendOptions,
    counting: Counting,
    /// The machine as the control is told of it.
    told: Machine,
    answer: ControlSettings,
}

/// A way that was simulated as it would be set.
struct Tried {
    trial: Trial,
    set: Machine,
    run: Run,
    /// What is left with the true gaps at either end of their intervals.
    ends: Vec<GapEnd>,
    /// Why it is not to be set.
    reason: Option<String>,
}

impl Advice<'_> {
    /// The answer, as far as there is one.
    fn given(mut self) -> Result<ControlSettings, SimError> {
        self.note_what_is_set();
        // Step 1: amounts that are not measured are sought.
        let steps = [false, true].map(|is_rotary| step(self.control, &self.counting, is_rotary));
        let trials = trials(self.control, steps, self.counting.has_own_motors);
        if trials.is_empty() {
            self.answer.refused = Some(unknown(self.control));
            let run = self.baseline()?;
            fill_baseline(&mut self.answer, self.machine, &run);
            return Ok(self.answer);
        }
        self.note_coarse_steps(steps);
        let first = self.simulated(&trials)?;
        self.fill_before(&first)?;
        let best = match self.best(&trials, &first)? {
            Some(best) => Some(best),
            None => self.best_wound(&trials)?,
        };
        // What has no numbers here is no advice.
        let best = match best {
            Some(best) if !self.has_numbers(&best) => {
                match self.best_with_numbers(&best, &trials, &first)? {
                    None => return Ok(self.answer),
                    other => other,
                }
            }
            best => best,
        };
        let Some(best) = best else {
            self.answer.refused = Some(refusal(&first));
            return Ok(self.answer);
        };
        // Step 2: as set, and told wrong.
        let candidates = self.candidates(best)?;
        let Some(tried) = self.tried(candidates)? else {
            return Ok(self.answer);
        };
        self.fill_after(&tried)?;
        Ok(self.answer)
    }

    /// Says that the machine has a method already.
    fn note_what_is_set(&mut self) {
        let axes = self.machine.axes().iter();
        let mut methods = axes.map(|axis| axis.config.compensation.method);
        if let Some(method) = methods.find(|method| !method.is_baseline()) {
            self.answer.notes.push(format!(
                "the machine description has {method} set already; \"before\" is without any compensation"
            ));
        }
    }

    /// Says of which axes the gap is less than the control can be told.
    fn note_coarse_steps(&mut self, steps: [f64; 2]) {
        let all = axes(&self.told, &self.counting);
        let small = all.iter().filter_map(|axis| {
            let step = steps[usize::from(axis.is_rotary)];
            let unit = if axis.is_rotary { "deg" } else { "mm" };
            let is_lost = axis.gap > 0.0 && axis.gap < 0.5 * step;
            is_lost.then(|| format!("{} {:.4} of {step} {unit}", axis.name, axis.gap))
        });
        let small: Vec<String> = small.collect();
        if !small.is_empty() {
            self.answer.notes.push(format!(
                "the control takes no gap below half of its step: {}",
                small.join(", ")
            ));
        }
    }

    /// A run of the machine as it is, without compensation.
    fn baseline(&mut self) -> Result<Run, SimError> {
        self.answer.runs += 1;
        let options = without_tests(&self.options);
        simulate(self.program, self.machine, &options, vec![baseline()])
    }

    /// A run of ways to set the control, beside no compensation.
    fn simulated(&mut self, trials: &[Trial]) -> Result<Run, SimError> {
        self.answer.runs += 1 + trials.len() as u64;
        let choices = std::iter::once(baseline()).chain(trials.iter().map(Trial::choice));
        let options = without_tests(&self.options);
        simulate(self.program, &self.told, &options, choices.collect())
    }

    /// What is without compensation: of controls that stop to compensate in a run without the stops.
    fn fill_before(&mut self, first: &Run) -> Result<(), SimError> {
        if self.control.stops() == PathStops::Never {
            fill_baseline(&mut self.answer, self.machine, first);
            return Ok(());
        }
        let run = self.baseline()?;
        fill_baseline(&mut self.answer, self.machine, &run);
        let [with_s, without_s] = [first.plan.duration_s, run.plan.duration_s];
        let cost = stops_cost(self.control, with_s, without_s);
        self.answer.notes.extend(cost);
        Ok(())
    }

    /// The best way, a pulse that is the same at all accelerations held against curves over them.
    fn best(&mut self, trials: &[Trial], first: &Run) -> Result<Option<Trial>, SimError> {
        let best = recommended(trials, first);
        let curves = curve_trials(self.control, first, trials);
        if curves.is_empty() {
            return Ok(best);
        }
        let all: Vec<Trial> = best.iter().cloned().chain(curves).collect();
        let run = self.simulated(&all)?;
        self.answer.notes.push(best_curve(&run, first));
        Ok(recommended(&all, &run).or(best))
    }

    /// The best way with the wind-up in its gaps, where without it none helps: without a gap all that is
    /// lost is wind-up.
    fn best_wound(&mut self, trials: &[Trial]) -> Result<Option<Trial>, SimError> {
        let wound = trials
            .iter()
            .filter_map(|trial| wound_up(trial, &self.told));
        let wound: Vec<Trial> = wound.collect();
        if wound.is_empty() {
            return Ok(None);
        }
        let run = self.simulated(&wound)?;
        Ok(recommended(&wound, &run))
    }

    fn has_numbers(&self, trial: &Trial) -> bool {
        trial.has_numbers(&self.told, self.control, &self.counting)
    }

    /// The best of the ways that have numbers, where the best of all has none; `None` with the answer
    /// refused where none of them helps.
    fn best_with_numbers(
        &mut self,
        unset: &Trial,
        trials: &[Trial],
        first: &Run,
    ) -> Result<Option<Trial>, SimError> {
        let rest = trials.iter().filter(|trial| self.has_numbers(trial));
        let rest: Vec<Trial> = rest
            .flat_map(|trial| [Some(trial.clone()), wound_up(trial, &self.told)])
            .flatten()
            .collect();
        let run = self.simulated(&rest)?;
        if let Some(left) = first.result(&unset.name()) {
            let (rms, max) = (left.cutting.rms, left.cutting.max);
            self.answer.notes.push(format!(
                "best for the program is {}, RMS {rms:.2} um, at most {max:.2} um: no primary source tells here how it is set",
                unset.name()
            ));
        }
        let best = recommended(&rest, &run);
        if best.is_none() {
            self.answer.refused = Some(format!(
                "the one way that helps is {}, and no primary source tells here how it is set: no number is printed",
                unset.name()
            ));
            let set = axes(&unset.on(&self.told), &self.counting);
            if let Ok(found) = parameters(self.control, unset.method.name(), &set, &self.counting) {
                self.answer.notes.extend(found.notes);
            }
        }
        Ok(best)
    }

    /// The best way, behind the same with the wind-up in its gaps where that is better: a dial gauge
    /// measures gap and wind-up together, and the description tells both.
    fn candidates(&mut self, best: Trial) -> Result<Vec<Trial>, SimError> {
        let Some(wound) = wound_up(&best, &self.told) else {
            return Ok(vec![best]);
        };
        let both = [best.clone(), wound.clone()];
        let run = self.simulated(&both)?;
        if Some(wound.name()) == run.recommended {
            return Ok(vec![wound, best]);
        }
        Ok(vec![best])
    }

    /// The first way that is safe when it is told wrong, and wherever in its interval the gap is; else the
    /// last. Where that speaks against the wind-up, the gap alone is left.
    fn tried(&mut self, candidates: Vec<Trial>) -> Result<Option<Tried>, SimError> {
        let mut tried = None;
        for trial in candidates {
            let set = trial.on(&self.told);
            let methods = [MethodId::NONE, trial.method].map(Choice::Registered);
            let run = simulate(self.program, &set, &self.options, methods.into())?;
            let ends = self.ends(&set, trial.method)?;
            let Some((result, none)) = run.result(trial.method.name()).zip(run.first()) else {
                continue;
            };
            self.answer.runs += 2 + result.misled.len() as u64;
            // How well the gap is known counts where that is said.
            let told_wrong = match self.wanted.gap_uncertainty {
                Some(_) => unsafe_but_for_gap(result, &none.cutting),
                None => result.not_recommended.clone(),
            };
            let reason = told_wrong.or_else(|| unsafe_at(&ends));
            let is_safe = reason.is_none();
            tried = Some(Tried {
                trial,
                set,
                run,
                ends,
                reason,
            });
            if is_safe {
                break;
            }
        }
        Ok(tried)
    }

    /// What is left with it, and the settings, if any, which are those that were simulated.
    fn fill_after(&mut self, tried: &Tried) -> Result<(), SimError> {
        let Tried {
            trial,
            set,
            run,
            ends,
            reason,
        } = tried;
        self.answer.chosen.clone_from(&trial.said);
        let Some(result) = run.result(trial.method.name()) else {
            return Ok(());
        };
        self.answer.uncertain.clone_from(ends);
        self.answer.after = result.cutting;
        self.answer.wrong.clone_from(&result.misled);
        if reason.is_some() {
            self.answer.trust.clone_from(&run.trust);
        }
        self.answer.notes.extend(result.notes.iter().cloned());
        self.answer
            .notes
            .extend(wind_up_note(trial, set, &self.counting));
        let already = set_already_note(trial, set, &self.counting);
        self.answer.notes.extend(already);
        self.answer.notes.extend(one_setting(set, &self.counting));
        self.answer.better = beyond(self.program, self.machine, &self.options, &mut self.answer)?;
        if let Some(reason) = reason {
            self.answer.refused = Some(format!("{}: {reason}", trial.name()));
            return Ok(());
        }
        let method = trial.method.name();
        let set = axes(set, &self.counting);
        match parameters(self.control, method, &set, &self.counting) {
            Ok(found) => {
                self.answer.method = Some(method.to_owned());
                self.answer.within_tolerance = result.within_tolerance;
                self.answer.settings = found.settings;
                self.answer.paste = found.paste;
                let first = measure_first(self.machine, self.wanted);
                self.answer.preconditions = first.into_iter().collect();
                self.answer.preconditions.extend(found.preconditions);
                self.answer.notes.extend(found.notes);
                self.answer.source = found.source.to_owned();
            }
            Err(reason) => self.answer.refused = Some(reason),
        }
        Ok(())
    }

    /// What is left with the true gaps at either end of their intervals, if those are wider than nothing.
    fn ends(&mut self, set: &Machine, method: MethodId) -> Result<Vec<GapEnd>, SimError> {
        let of_axes = self.machine.axes().iter();
        let share = of_axes
            .map(|axis| uncertainty(&axis.config, self.wanted.gap_uncertainty))
            .fold(0.0, f64::max);
        self.answer.gap_uncertainty = self
            .wanted
            .gap_uncertainty
            .or((share > 0.0).then_some(share));
        if share <= 0.0 {
            return Ok(Vec::new());
        }
        let mut ends = Vec::new();
        for sign in [-1.0, 1.0] {
            let end = with_gaps_at(set, self.machine, self.wanted, sign);
            let choices = [MethodId::NONE, method].map(Choice::Registered);
            let options = without_tests(&self.options);
            let run = simulate(self.program, &end, &options, choices.into())?;
            self.answer.runs += 2;
            let stats = |name: &str| {
                run.result(name)
                    .map_or(ErrorStats::default(), |r| r.cutting)
            };
            ends.push(GapEnd {
                factor: 1.0 + sign * share,
                before: stats(MethodId::NONE.name()),
                after: stats(method.name()),
                stops: run.result(method.name()).is_some_and(|r| r.stop.is_some()),
            });
        }
        Ok(ends)
    }
}

/// The way that a run recommends.
fn recommended(trials: &[Trial], run: &Run) -> Option<Trial> {
    let mut all = trials.iter();
    all.find(|trial| Some(trial.name()) == run.recommended)
        .cloned()
}

/// Why a way is out where the true gap is at an end of its interval.
fn unsafe_at(ends: &[GapEnd]) -> Option<String> {
    ends.iter().find_map(|end| {
        let when = format!(
            " where the true gap is {:.0} % of the description's",
            100.0 * end.factor
        );
        if end.stops {
            return Some(format!("the machine stops{when}"));
        }
        worse(&end.after, &end.before, &when)
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
