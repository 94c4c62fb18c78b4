//! `lostmotion simulate`: a part program on a machine, with one method or several.

use super::record::{Answer, PageSlot, Record, Trace};
use super::{accepted, failure, found, shown, to_json};
use crate::commission::LearnedFiles;
use crate::findings::{Form, Voice};
use crate::input;
use crate::options::machine::{Drives, with_fits};
use crate::options::part::OnMachine;
use crate::options::{Interventions, Names, Quality, RunFormat, methods, number, threads, whole};
use crate::output::{
    DONE, FOUND, Failure, print, refuse_input, refuse_inputs, remark, stdout_is_terminal,
};
use clap::{Args, ValueHint};
use lostmotion::drive::config::AxisConfigError;
use lostmotion::methods::MethodId;
use lostmotion::report::findings::BlockRecorder;
use lostmotion::report::text;
use lostmotion::report::text::{Along, TextOptions};
use lostmotion::sim::control::{Control, UnknownControl};
use lostmotion::sim::{Machine, Program, SimulateOptions, Simulation, results};
use std::path::{Path, PathBuf};
use std::sync::{Arc, PoisonError};

/// What `simulate` and `compare` share.
#[derive(Debug, Args)]
pub(crate) struct Run {
    /// How much effort to put into the cycle time
    #[arg(long, value_enum, default_value_t)]
    pub(crate) quality: Quality,
    /// Tolerance of the contour error in micrometres; the machine's, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub(crate) tolerance_um: Option<f64>,
    /// Cutting force in newton, against the direction of travel on every feed move; the machine's
    /// (mostly 0), if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub(crate) cutting_force_n: Option<f64>,
    /// How far the tool may leave its path between two setpoints, in micrometres; the motion slows
    /// down to keep it. If left out the machine's, or 5, which is kept if a drive interpolates
    /// linearly and only warned about otherwise
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = number)]
    pub(crate) bow_limit_um: Option<f64>,
    /// Show how methods do whose drives are told gap, friction or stiffness too small or too large,
    /// by this many per cent. A comparison tests its recommendation with 30; 0 is no test
    #[arg(
        long,
        value_name = "PERCENT",
        num_args = 0..=1,
        default_missing_value = "30",
        allow_negative_numbers = true,
        value_parser = number
    )]
    pub(crate) sensitivity: Option<f64>,
    /// Recommend among what this control can do; the machine's (`simulate.control`), or any method
    /// on the motor, if left out
    #[arg(long, value_name = "NAME", value_parser = controls())]
    pub(crate) control: Option<String>,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: RunFormat,
    /// Folder for result, tables, picture and page; made if it does not exist
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    pub(crate) out: Option<PathBuf>,
    /// Also write the result as a page for a browser, one file that needs no network
    #[arg(long, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) html: Option<PathBuf>,
    /// Where the page is wanted as text, too.
    #[arg(skip)]
    pub(crate) served: Option<PageSlot>,
    #[command(flatten)]
    pub(crate) trace: Trace,
    /// Tell the methods that may know it the gap of an axis, from a result of `axis fit`
    /// (`fitted-lookup` needs one, and also uses the load of `axis fit --motor-only`); y2 is the
    /// second motor of a gantry's Y; may be repeated
    #[arg(long, value_name = "AXIS=FILE.json")]
    pub(crate) fitted: Vec<String>,
    #[command(flatten)]
    pub(crate) learning: LearnedFiles,
    /// Threads to use at most; all cores, if left out. The answer does not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) threads: Option<usize>,
    #[command(flatten)]
    pub(crate) on: OnMachine,
    #[command(flatten)]
    pub(crate) drives: Drives,
    #[command(flatten)]
    pub(crate) interventions: Interventions,
}

impl Run {
    /// What is listed, with what was asked for besides.
    fn listed(&self, options: TextOptions) -> TextOptions {
        TextOptions {
            sensitivity: self.sensitivity.is_some_and(|percent| percent > 0.0),
            ..options
        }
    }

    /// Who looks on while these methods run. The folder is made now: a wrong one must not cost the
    /// run.
    fn record(
        &self,
        methods: &[String],
        machine: &Machine,
        quiet: bool,
    ) -> Result<Record, Failure> {
        let out = self.out.as_deref();
        let record = Record::new(out, self.html.as_deref(), &self.trace, methods, quiet)?;
        let record = match &self.served {
            Some(slot) => record.with_page_in(slot),
            None => record,
        };
        // Its line is made of blocks that no file and no pipe expects.
        let record = if self.format == RunFormat::Text && stdout_is_terminal() {
            record.with_along()
        } else {
            record
        };
        if self.format != RunFormat::Sarif {
            return Ok(record);
        }
        let tolerance_um = self.tolerance_um.unwrap_or(machine.simulate().tolerance_um);
        Ok(record.with_blocks_outside(tolerance_um))
    }

    /// Prints the answer in the form asked for.
    fn print(
        &self,
        answer: &Answer<'_>,
        options: &SimulateOptions,
        text: &str,
        outside: Option<BlockRecorder>,
        along: &[Along],
    ) -> Result<(), Failure> {
        let (RunFormat::Sarif, Some(outside)) = (self.format, outside) else {
            if self.format != RunFormat::Text {
                return print(answer.json);
            }
            let run = answer.run;
            let names = run.results.iter().map(|result| result.method.as_str());
            let methods: Vec<(&str, &Along)> = names.zip(along).collect();
            let line = text::along(&methods, run.tolerance_um, run.plan.duration_s, &shown());
            return print(&format!("{text}{line}"));
        };
        let mut findings = found(answer.program, answer.machine, options)?;
        // Of the method that decides; where none is recommended, of the first.
        let index = answer.run.deciding_index().unwrap_or(0);
        if let Some(result) = answer.run.results.get(index) {
            findings.add_run(&outside, index, result);
        }
        print(&findings.render(Form::Sarif)?)
    }
}

/// The exit code of a run: 0 where the method that decides keeps the tolerance.
fn exit_code(run: &results::Run) -> u8 {
    if run.is_within_tolerance() {
        DONE
    } else {
        FOUND
    }
}

/// `simulate`.
#[derive(Debug, Args)]
pub(crate) struct Simulate {
    /// Compensation method of all axes; if left out, the one that the machine file names for each
    /// axis (`compensation.method`), and `none` for an axis without one
    #[arg(
        long,
        value_name = "NAME",
        value_parser = methods(),
        conflicts_with = "methods"
    )]
    pub(crate) method: Option<String>,
    /// Several compensation methods on one plan, side by side, separated by commas; `all` is every
    /// method
    #[arg(
        long,
        value_name = "NAMES",
        value_delimiter = ',',
        value_parser = methods_or_all(),
        hide_possible_values = true
    )]
    pub(crate) methods: Vec<String>,
    #[command(flatten)]
    pub(crate) run: Run,
}

/// Names of controls.
fn controls() -> Names {
    Names::new("control", Control::ALL.map(|control| (control.name(), "")))
}

fn control(name: &str) -> Result<Control, Failure> {
    name.parse()
        .map_err(|error: UnknownControl| Failure::message(error.to_string()))
}

/// Names of methods, and `all`.
fn methods_or_all() -> Names {
    let all = ("all", "every method");
    let named = MethodId::all().map(|method| (method.name(), method.info().summary));
    Names::new("method", named.chain([all]))
}

/// `compare`.
#[derive(Debug, Args)]
pub(crate) struct Compare {
    /// Compensation methods, separated by commas; all, if left out
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = methods())]
    pub(crate) methods: Vec<String>,
    #[command(flatten)]
    pub(crate) run: Run,
}

/// What a run is given: the program, the machine, and how.
fn prepare(run: &Run, quiet: bool) -> Result<(Program, Machine, SimulateOptions), Failure> {
    let program = input::program(&run.on.part)?;
    // First how the drives are commanded: a fit is checked with the axis that it goes to.
    let machine = run.drives.of(&run.on.machine()?)?;
    let machine = with_fits(machine, &run.fitted)?;
    // Asked for the good range, which NaN is outside of.
    if let Some(percent) = run.sensitivity
        && !(0.0..=95.0).contains(&percent)
    {
        return Err(Failure::message(format!(
            "--sensitivity is {percent}; it has to be from 0 to 95"
        )));
    }
    if let Some(html) = &run.html {
        refuse_input(html, &run.on.part, "part program")?;
        refuse_inputs(html, run.on.setup.on.inputs())?;
        refuse_inputs(html, run.learning.inputs())?;
        let fits = run.fitted.iter().filter_map(|fit| fit.split_once('='));
        refuse_inputs(html, fits.map(|(_, file)| (Path::new(file), "fit result")))?;
    }
    let learned = run.learning.of_machine(&machine, quiet)?;
    let options = SimulateOptions {
        learned: learned.map(Arc::new),
        tolerance_um: run.tolerance_um,
        cutting_force_n: run.cutting_force_n,
        bow_limit_um: run.bow_limit_um,
        threads: threads(run.threads)?,
        control: run.control.as_deref().map(control).transpose()?,
        misled_share: run.sensitivity.map(|percent| percent / 100.0),
        quality: run.quality.of_planner(),
        interventions: run.interventions.read()?,
        ..SimulateOptions::default()
    };
    let options = run.on.options(&machine, options)?;
    Ok((program, machine, options))
}

/// Whether any axis was told the gap of a fit.
fn has_fit(machine: &Machine) -> bool {
    machine
        .axes()
        .iter()
        .any(|axis| axis.config.compensation.fitted_lookup.gap.is_some())
}

/// Refuses the method for fits where no axis has one: it would leave everything as it is.
fn check_fit(method: &str, machine: &Machine) -> Result<(), Failure> {
    let needs_fit = method.parse::<MethodId>().is_ok_and(MethodId::needs_fit);
    if !needs_fit || has_fit(machine) {
        return Ok(());
    }
    let hint = "give a result of `lostmotion axis fit` as --fitted AXIS=FILE.json, or set compensation.fitted_lookup.gap in the machine file";
    Err(Failure::with_hint(
        format!("{method} needs a fitted gap, and no axis has one"),
        hint,
    ))
}

/// Runs a program with one method, or with several.
pub(crate) fn run(args: &Simulate, quiet: bool) -> Result<u8, Failure> {
    let voice = args.run.on.setup.reading.voice(quiet);
    if !args.methods.is_empty() {
        let all = args.methods.iter().any(|name| name == "all");
        // For `several` an empty list means every method.
        let named = if all { &[] } else { args.methods.as_slice() };
        return several(&args.run, named, voice);
    }
    one(&args.run, args.method.as_deref(), voice)
}

/// Runs a program as [`run`] does and answers the page of the result.
pub(crate) fn page_of(args: &mut Simulate, quiet: bool) -> Result<String, Failure> {
    let slot = PageSlot::default();
    args.run.served = Some(PageSlot::clone(&slot));
    run(args, quiet)?;
    let page = slot.lock().unwrap_or_else(PoisonError::into_inner);
    Ok(page.clone())
}

/// `compare`: several methods; all, if none is named.
pub(crate) fn compare(args: &Compare, quiet: bool) -> Result<u8, Failure> {
    several(
        &args.run,
        &args.methods,
        args.run.on.setup.reading.voice(quiet),
    )
}

/// The method asked for, or those that the axes have of their own.
fn methods_of(asked: Option<&str>, machine: &Machine) -> Vec<MethodId> {
    match asked {
        Some(name) => name.parse().into_iter().collect(),
        None => machine
            .axes()
            .iter()
            .map(|axis| axis.config.compensation.method)
            .collect(),
    }
}

/// One method, or each axis' own. Exit code 0 within tolerance, 1 outside or where the machine
/// stops.
fn one(run: &Run, method: Option<&str>, voice: Voice) -> Result<u8, Failure> {
    let (program, machine, options) = prepare(run, voice.quiet)?;
    let simulation = Simulation::new(&program, &machine);
    // Without a method each axis has the one of the machine file, and all of them make the label.
    let (simulation, label) = match method {
        Some(name) => {
            check_fit(name, &machine)?;
            (simulation.method(name), name.to_owned())
        }
        None => (simulation, machine.method_names()),
    };
    let methods = std::slice::from_ref(&label);
    run.learning.check(&methods_of(method, &machine))?;
    let mut record = run.record(methods, &machine, voice.quiet)?;
    let answer = simulation
        .options(options.clone())
        .observer(&mut record)
        .run()
        .map_err(|error| failure(&program, &error, voice))?;
    let simulation = answer
        .clone()
        .into_single()
        .ok_or_else(|| Failure::message("no method was run"))?;
    accepted(&program, &machine, &options, voice)?;
    let (learned, stops) = (&simulation.result.learned, simulation.result.stop.is_some());
    run.learning
        .save(options.learned.as_deref(), learned, stops)?;
    let json = to_json(&simulation)?;
    // Files get text without colour in full width; stdout gets what its terminal can show.
    let outside = record.take_blocks_outside();
    let along = record.take_along();
    let answer = Answer {
        program: &program,
        machine: &machine,
        run: &answer,
        json_name: "simulation.json",
        json: &json,
        text_name: "simulation.txt",
        text: &text::simulation(&simulation, &run.listed(TextOptions::default())),
    };
    record.finish(&answer)?;
    let text = text::simulation(&simulation, &run.listed(shown()));
    run.print(&answer, &options, &text, outside, &along)?;
    Ok(exit_code(answer.run))
}

/// Several methods side by side; all, if none is named. The exit code is that of the recommended
/// one, and 1 where none can be recommended.
fn several(run: &Run, named: &[String], voice: Voice) -> Result<u8, Failure> {
    let (program, machine, options) = prepare(run, voice.quiet)?;
    // A document on stderr must not have a sentence before it.
    let quiet = voice.quiet || voice.diagnostics != Form::Text;
    let methods = compared(named, &machine, quiet)?;
    let named: Vec<MethodId> = methods
        .iter()
        .filter_map(|name| name.parse().ok())
        .collect();
    run.learning.check(&named)?;
    let mut record = run.record(&methods, &machine, voice.quiet)?;
    let comparison = Simulation::new(&program, &machine)
        .methods(&methods)
        .options(options.clone())
        .observer(&mut record)
        .run()
        .map_err(|error| failure(&program, &error, voice))?;
    accepted(&program, &machine, &options, voice)?;
    // One method learns: the others have learned nothing.
    let mut results = comparison.results.iter();
    if let Some(result) = results.rfind(|result| !result.learned.is_empty()) {
        let stops = result.stop.is_some();
        run.learning
            .save(options.learned.as_deref(), &result.learned, stops)?;
    }
    let json = to_json(&comparison)?;
    let outside = record.take_blocks_outside();
    let along = record.take_along();
    let answer = Answer {
        program: &program,
        machine: &machine,
        run: &comparison,
        json_name: "comparison.json",
        json: &json,
        text_name: "comparison.txt",
        text: &text::comparison(&comparison, &run.listed(TextOptions::default())),
    };
    record.finish(&answer)?;
    let text = text::comparison(&comparison, &run.listed(shown()));
    run.print(&answer, &options, &text, outside, &along)?;
    Ok(exit_code(answer.run))
}

/// The first axis that a method does not work on, and why.
fn unsuited_axis(method: MethodId, machine: &Machine) -> Option<(String, AxisConfigError)> {
    machine.drives().into_iter().find_map(|drive| {
        let error = method.suits(machine.drive(&drive)?).err()?;
        Some((drive, error))
    })
}

/// The methods asked for, each once; if none is named, all of them, without the one for fits where
/// there is no fit, and without those that an axis does not suit.
fn compared(asked: &[String], machine: &Machine, quiet: bool) -> Result<Vec<String>, Failure> {
    let mut methods: Vec<String> = Vec::new();
    for name in asked.iter().filter(|name| !name.is_empty()) {
        // Twice the same column would hide that another method was meant.
        if methods.contains(name) {
            return Err(Failure::message(format!(
                "--methods names \"{name}\" twice"
            )));
        }
        methods.push(name.clone());
    }
    if methods.is_empty() {
        // `fitted-lookup` without a fit would do nothing: it is left out of `all`, and refused by
        // name.
        let fitted = has_fit(machine);
        let mut unsuited = Vec::new();
        for method in MethodId::all().filter(|method| fitted || !method.needs_fit()) {
            match unsuited_axis(method, machine) {
                None => methods.push(method.to_string()),
                Some((axis, why)) => {
                    unsuited.push(format!("{method} does not suit axis {axis}: {why}"));
                }
            }
        }
        if !quiet {
            for why in unsuited {
                remark(&format!("note: left out: {why}"));
            }
        }
        if !fitted && !quiet {
            let named: Vec<&str> = MethodId::all()
                .filter(|method| method.needs_fit())
                .map(MethodId::name)
                .collect();
            remark(&format!(
                "note: {} is left out: no axis has a fitted gap (--fitted AXIS=FILE.json)",
                named.join(", ")
            ));
        }
    }
    if !quiet {
        say_least_gaps(machine);
    }
    methods
        .iter()
        .try_for_each(|name| check_fit(name, machine))?;
    Ok(methods)
}

/// Says of which gaps methods are told the least that they may be.
fn say_least_gaps(machine: &Machine) {
    let uncertain = machine.axes().iter().filter_map(|axis| {
        let share = axis.config.compensation.gap_uncertainty;
        (share > 0.0).then(|| format!("{} {:.0} %", axis.id, 100.0 * share))
    });
    let uncertain: Vec<String> = uncertain.collect();
    if !uncertain.is_empty() {
        remark(&format!(
            "note: methods are told the least that a gap may be; it may be off by (compensation.gap_uncertainty): {}",
            uncertain.join(", ")
        ));
    }
}
