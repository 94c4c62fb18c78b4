//! `lostmotion check` and `gcode lint`: what can be said about a part program without moving.

use super::failure;
use crate::findings::{Findings, Form, Voice};
use crate::input;
use crate::options::Names;
use crate::options::part::{Setup, interpret};
use crate::output::{self, BAD_INPUT, DONE, FOUND, Failure};
use clap::{Args, ValueHint};
use lostmotion::gcode::{InterpreterConfig, Severity};
use lostmotion::gcode_tools::lint::{Level, Levels, lint as linted, rules};
use lostmotion::report::findings::{Finding, Origin};
use lostmotion::report::text::{Align, Table};
use lostmotion::sim::{Machine, Program, SimError, SimulateOptions, Simulation};
use std::path::PathBuf;

/// Which lints are reported, and how.
#[derive(Clone, Debug, Args)]
#[command(next_help_heading = "Lints")]
pub(crate) struct LintLevels {
    /// Switch a lint off; may be repeated. `all` stands for every lint, and a code beats `all`
    #[arg(long, value_name = "CODE", value_parser = lints(), hide_possible_values = true)]
    pub(crate) allow: Vec<String>,
    /// Report a lint as a warning
    #[arg(long, value_name = "CODE", value_parser = lints(), hide_possible_values = true)]
    pub(crate) warn: Vec<String>,
    /// Report a lint as an error
    #[arg(long, value_name = "CODE", value_parser = lints(), hide_possible_values = true)]
    pub(crate) deny: Vec<String>,
}

/// `lint`.
#[derive(Debug, Args)]
#[command(after_long_help = every_lint())]
pub(crate) struct Lint {
    /// Part program; `-` is stdin
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) part: PathBuf,
    /// Form of the answer on stdout; that of --diagnostics, if left out
    #[arg(long, value_enum)]
    pub(crate) format: Option<Form>,
    #[command(flatten)]
    pub(crate) setup: Setup,
    #[command(flatten)]
    pub(crate) lints: LintLevels,
}

/// `check`.
#[derive(Debug, Args)]
#[command(after_help = CHECKED, after_long_help = checked())]
pub(crate) struct Check {
    /// Part program; `-` is stdin
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) part: PathBuf,
    /// Form of the answer on stdout; that of --diagnostics, if left out
    #[arg(long, value_enum)]
    pub(crate) format: Option<Form>,
    #[command(flatten)]
    pub(crate) setup: Setup,
    #[command(flatten)]
    pub(crate) lints: LintLevels,
}

/// What `check` holds a program against besides the lints.
const CHECKED: &str = "Checked besides the lints: that every block can be read and carried out \
in its dialect (`machine keys dialect`, --dialect), that every axis moved is on the machine, that \
all moves stay within its travel, and that tools and offsets are in its tables. --help lists the \
lints.";

/// The same, with every lint.
fn checked() -> String {
    let (besides, _) = CHECKED.rsplit_once(" --help").unwrap_or((CHECKED, ""));
    format!("{besides}\n\n{}", every_lint())
}

/// Columns of the list of lints: those of a terminal that does not say how many it has, without the
/// blanks before each line.
const LINT_COLUMNS: usize = 78;

/// Every lint with what it finds, as help prints it.
fn every_lint() -> String {
    let mut table = Table::new(&[("CODE", Align::Left), ("", Align::Left)]).folded();
    for rule in rules::all() {
        let is_off = if rule.level == Level::Allow {
            " (off)"
        } else {
            ""
        };
        let summary = rule.summary.trim_end_matches('.');
        table.row([rule.code.into(), format!("{summary}{is_off}").into()]);
    }
    let lines = table.render_within(LINT_COLUMNS);
    let lines: String = lines.lines().map(|line| format!("  {line}\n")).collect();
    format!("What the lints find:\n{lines}")
}

/// Codes of lints, and `all`.
fn lints() -> Names {
    let named = rules::all().map(|rule| (rule.code, ""));
    Names::new("lint", named.chain([("all", "every lint")]))
}

/// Code of the lint for moves beyond the travel.
const TRAVEL: &str = "outside-travel";

/// `gcode lint`: on a machine only if one is named.
pub(crate) fn lint(args: &Lint, quiet: bool) -> Result<u8, Failure> {
    let voice = args.setup.reading.voice(quiet);
    let levels = levels(&args.lints, Levels::default());
    let machine = args.setup.machine()?;
    let source = input::program(&args.part)?;
    let mut findings = find(
        &source,
        &args.part,
        &args.setup,
        machine.as_ref(),
        &levels,
        voice,
    )?;
    tell(&mut findings, args.format.unwrap_or(voice.diagnostics))
}

/// `check`: on the machine named or the default one; moves beyond its travel are errors.
pub(crate) fn check(args: &Check, quiet: bool) -> Result<u8, Failure> {
    let voice = args.setup.reading.voice(quiet);
    let levels = levels_on_machine(&args.lints);
    let machine = args.setup.on.load()?;
    let source = input::program(&args.part)?;
    let mut findings = find(
        &source,
        &args.part,
        &args.setup,
        Some(&machine),
        &levels,
        voice,
    )?;
    let form = args.format.unwrap_or(voice.diagnostics);
    let code = tell(&mut findings, form)?;
    // Silence would leave open whether anything was checked; an empty document says so by itself.
    if code == DONE && form == Form::Text && !quiet {
        let said = format!("{} on {}: nothing found\n", source.name(), machine.name());
        output::print(&said)?;
    }
    Ok(code)
}

/// The levels asked for on a machine that was chosen: a part beyond its travel is an error there,
/// unless --allow or --warn says otherwise.
pub(super) fn levels_on_machine(args: &LintLevels) -> Levels {
    let mut usual = Levels::default();
    usual.set(TRAVEL, Level::Deny);
    levels(args, usual)
}

/// What the interpreter and the lints find and, on a machine, what leaves its travel.
pub(super) fn find<'a>(
    source: &'a Program,
    part: &std::path::Path,
    setup: &Setup,
    machine: Option<&Machine>,
    levels: &Levels,
    voice: Voice,
) -> Result<Findings<'a>, Failure> {
    // With a machine its tools, offsets and start count; without one the interpreter's own.
    let config = setup.config(machine, InterpreterConfig::default())?;
    let mut program = interpret(source, config, Some(setup.reading.loader(part)?))?;
    let travel = rules::find(TRAVEL).map_or(Level::Warn, |rule| levels.of(rule));
    let found = linted(&mut program, levels.clone());
    let mut findings = Findings::of(source, program.diagnostics());
    let origin = Origin {
        program: source.name(),
        provenance: program.diagnostics().provenance(),
    };
    let of_lint = |finding| Finding::from_lint(finding, &origin);
    findings.list.extend(found.kept().iter().map(of_lint));
    // Counts go on where findings beyond the bound are dropped.
    findings.counts.errors += found.denied();
    findings.counts.warnings += found.warned();
    // Moves of a program with errors are guesses: their travel says nothing.
    let readable = program.diagnostics().errors() == 0;
    if let Some(machine) = machine.filter(|_| readable && travel != Level::Allow) {
        let options = setup.options(part, machine, SimulateOptions::default())?;
        on_machine(source, machine, &options, travel, &mut findings, voice)?;
    }
    Ok(findings)
}

/// Holds the program against a machine's axes and travel.
fn on_machine(
    source: &Program,
    machine: &Machine,
    options: &SimulateOptions,
    level: Level,
    findings: &mut Findings<'_>,
    voice: Voice,
) -> Result<(), Failure> {
    let simulation = Simulation::new(source, machine).options(options.clone());
    match simulation.check() {
        // A program without a move leaves no travel.
        Ok(_) | Err(SimError::Empty { .. }) => Ok(()),
        Err(error @ SimError::Travel { .. }) => {
            let severity = if level == Level::Deny {
                Severity::Error
            } else {
                Severity::Warning
            };
            findings.add_error(&error, severity);
            Ok(())
        }
        // What the lints have found is told, too.
        Err(error) if findings.add_error(&error, Severity::Error) => Ok(()),
        Err(error) => Err(failure(source, &error, voice)),
    }
}

/// Prints findings in the order of the text; the exit code says the worst.
fn tell(findings: &mut Findings<'_>, form: Form) -> Result<u8, Failure> {
    // Interpreter, lints and travel add theirs one after the other.
    findings
        .list
        .sort_by_key(|finding| (finding.span.file, finding.span.start));
    output::print(&findings.render(form)?)?;
    Ok(match findings.counts {
        counts if counts.errors > 0 => BAD_INPUT,
        counts if counts.warnings > 0 => FOUND,
        _ => DONE,
    })
}

/// The levels asked for; a code beats `all`.
fn levels(args: &LintLevels, mut levels: Levels) -> Levels {
    let given = [
        (&args.allow, Level::Allow),
        (&args.warn, Level::Warn),
        (&args.deny, Level::Deny),
    ];
    // `all` first, whatever the order on the command line, so that single codes stand.
    let (all, named): (Vec<_>, Vec<_>) = given
        .iter()
        .flat_map(|(codes, level)| codes.iter().map(|code| (code.as_str(), *level)))
        .partition(|(code, _)| *code == "all");
    for (code, level) in all.into_iter().chain(named) {
        levels.set(code, level);
    }
    levels
}
