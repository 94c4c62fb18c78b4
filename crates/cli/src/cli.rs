//! The command line: which commands there are, under which headings, and what they are called
//! besides.

use crate::axis::{self, AxisCommand};
use crate::ballbar::{self, Ballbar};
use crate::check_log::{self, CheckLog};
use crate::machine::{self, MachineCommand};
use crate::method::{self, MethodCommand};
use crate::output::Failure;
use crate::parts::check::{Check, Lint, check, lint};
use crate::parts::compensate::{self, Compensate};
use crate::parts::gcode::{self, Canon, Explain, FormatPart, GcodeCommand, WritePart};
use crate::parts::lsp::{self, Lsp};
use crate::parts::plan::{self, Plan};
use crate::parts::recommend::{self, Recommend};
use crate::parts::report::{self, Report};
use crate::parts::simulate::{self, Compare, Simulate};
use crate::parts::time::{self, Time};
use crate::parts::watch::{self, Watch};
use crate::shell::{Completions, ManPages, Schema, completions, man, schema};
use crate::study::{self, Paper, StudyCommand};
use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use std::ffi::OsString;

/// How far a real machine leaves the programmed contour, and what each way of compensating backlash
/// does about it.
#[derive(Debug, Parser)]
#[command(
    name = "lostmotion",
    version,
    max_term_width = 100,
    arg_required_else_help = true,
    subcommand_required = true,
    after_help = AFTER,
    help_template = "{about-with-newline}\n{usage-heading} {usage}\n\n{before-help}\
                     Options:\n{options}{after-help}"
)]
pub(crate) struct Cli {
    /// Print no progress and no warnings
    #[arg(long, short, global = true)]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

/// Headings of `--help`, each with its commands. clap has no headings for commands, so the list is
/// made here; a test holds it to the commands that are not hidden.
const HEADINGS: [(&str, &[&str]); 5] = [
    (
        "Parts",
        &[
            "simulate",
            "recommend",
            "compensate",
            "watch",
            "report",
            "time",
            "check",
            "plan",
            "gcode",
            "lsp",
        ],
    ),
    ("Machines and methods", &["machine", "method"]),
    (
        "Drives and measured data",
        &["axis", "check-log", "ballbar"],
    ),
    ("Research", &["study"]),
    ("This program", &["schema", "completions", "man"]),
];

/// The commands under their headings, each with the first sentence of what it does.
fn commands_by_heading(program: &clap::Command) -> String {
    let mut text = String::new();
    for (heading, names) in HEADINGS {
        text.push_str(&format!("{heading}:\n"));
        for name in names {
            let about = program
                .get_subcommands()
                .find(|command| command.get_name() == *name)
                .and_then(|command| command.get_about())
                .map(ToString::to_string)
                .unwrap_or_default();
            // The first clause alone: the list has a line for each command.
            let about = about.split([';', ':']).next().unwrap_or_default();
            text.push_str(&format!("  {name:<12} {}\n", about.trim_end_matches('.')));
        }
        text.push('\n');
    }
    text.trim_end().to_owned()
}

/// The program as clap knows it, with the commands under their headings.
fn program() -> clap::Command {
    let program = Cli::command();
    let commands = commands_by_heading(&program);
    program.before_help(commands)
}

/// What the program's exit codes mean.
const AFTER: &str = "Exit codes: 0 done, and within tolerance where there is one; 1 outside \
tolerance or limits, a machine that stops, warnings of check and lint, or not formatted; 2 bad input; 130 ended by Ctrl-C. \
Of several methods the recommended one decides; 1 where none can be recommended.";

/// What to do.
#[derive(Debug, Subcommand)]
enum Command {
    /// Run a part program on a machine: contour error against a tolerance, with the blocks that
    /// cause it; several compensation methods side by side with --methods
    Simulate(Simulate),
    /// Say what to set on a control for a part program on a machine: its own parameters, what they
    /// leave, and what if the gap was measured wrong
    Recommend(Recommend),
    /// Rewrite a part program for a control without backlash compensation; the tool then keeps the
    /// contour, as is simulated before anything is written
    Compensate(Compensate),
    /// Run a part program again whenever its files change, with its page for a browser
    Watch(Watch),
    /// Set the answers of several runs side by side: machines, settings or versions of a program
    Report(Report),
    /// Show where the time of a part program goes: by block, by kind, by what limits it, and what
    /// better limits would save
    Time(Time),
    /// Say everything about a part program that can be said without moving: errors, lints, travel,
    /// tools. Exit code 0 nothing, 1 warnings, 2 errors
    Check(Check),
    /// Write the planned motion of every axis as CSV, a row per command cycle
    Plan(Plan),
    /// Explain, format, rewrite and list the text of a part program
    #[command(subcommand)]
    Gcode(GcodeCommand),
    /// Serve an editor: findings, what a line does, format, and contour errors after a run
    Lsp(Lsp),
    /// List, show, check, make and import machines
    #[command(subcommand)]
    Machine(MachineCommand),
    /// List and describe the compensation methods
    #[command(subcommand)]
    Method(MethodCommand),
    /// Run one axis alone, or fit its gap to a log
    #[command(subcommand)]
    Axis(AxisCommand),
    /// Hold the log of a program against the programmed path and the limits of the machine; where
    /// in the program it was recorded is found
    CheckLog(CheckLog),
    /// Say what a ballbar's sheet tells of the axes: G, F and H of ISO 230-4, lost motion, spikes,
    /// servo mismatch, squareness and scale with intervals; beside a simulated machine
    Ballbar(Ballbar),
    /// Run the studies behind the methods
    #[command(subcommand)]
    Study(StudyCommand),
    /// Print the JSON Schema of a document that this program writes
    Schema(Schema),
    /// Print completions for a shell
    Completions(Completions),
    /// Print or write man pages
    Man(ManPages),

    /// Former name of `simulate --methods`
    #[command(hide = true)]
    Compare(Compare),
    /// Former name of `gcode canon --like-rs274`
    #[command(hide = true)]
    Canon(Canon),
    /// Former name of `gcode lint`
    #[command(hide = true)]
    Lint(Lint),
    /// Former name of `gcode format`
    #[command(hide = true)]
    Format(FormatPart),
    /// Former name of `gcode explain`
    #[command(hide = true)]
    Explain(Explain),
    /// Former name of `gcode write`
    #[command(hide = true)]
    Write(WritePart),
    /// Former name of `axis fit`
    #[command(hide = true)]
    Fit(axis::Fit),
    /// Former name of `study paper`
    #[command(hide = true, subcommand)]
    Reproduce(Reproduce),
}

/// `reproduce`.
#[derive(Debug, Subcommand)]
enum Reproduce {
    /// Former name of `study paper`
    Paper(Paper),
}

impl Cli {
    /// The arguments of this process.
    pub(crate) fn of_process() -> Cli {
        let arguments = with_axis_run(std::env::args_os().collect());
        let matches = program().get_matches_from(arguments);
        Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit())
    }

    /// Runs the command asked for; returns its exit code.
    pub(crate) fn run(&mut self) -> Result<u8, Failure> {
        let quiet = self.quiet;
        match &mut self.command {
            Command::Simulate(args) => simulate::run(args, quiet),
            Command::Compare(args) => simulate::compare(args, quiet),
            Command::Recommend(args) => recommend::run(args, quiet),
            Command::Compensate(args) => compensate::run(args, quiet),
            Command::Watch(args) => match watch::run(args, quiet)? {},
            Command::Report(args) => report::run(args),
            Command::Time(args) => time::run(args, quiet),
            Command::Check(args) => check(args, quiet),
            Command::Plan(args) => plan::run(args, quiet),
            Command::Gcode(command) => gcode::run(command, quiet),
            Command::Canon(args) => gcode::canon_like_rs274(args, quiet),
            Command::Lint(args) => lint(args, quiet),
            Command::Format(args) => gcode::format(args, quiet),
            Command::Explain(args) => gcode::explain(args, quiet),
            Command::Write(args) => gcode::write(args, quiet),
            Command::Lsp(args) => lsp::run(args),
            Command::Machine(command) => machine::run(command, quiet),
            Command::Method(command) => method::run(command),
            Command::Axis(command) => axis::run(command, quiet),
            Command::Ballbar(args) => ballbar::run(args, quiet),
            Command::CheckLog(args) => check_log::run(args, quiet),
            Command::Fit(args) => axis::fit(args, quiet),
            Command::Study(command) => study::run(command, quiet),
            Command::Schema(args) => schema(args),
            Command::Completions(args) => completions(args, program()),
            Command::Man(args) => man(args, Cli::command()),
            Command::Reproduce(Reproduce::Paper(args)) => study::paper(args),
        }
    }
}

/// The arguments with `run` behind an `axis` that is followed by an option: `axis --setpoints` was
/// the former name of `axis run --setpoints`.
fn with_axis_run(mut arguments: Vec<OsString>) -> Vec<OsString> {
    let is_option = |argument: &OsString| argument.to_string_lossy().starts_with('-');
    // Place of the command: the first argument behind the program's name that is no option.
    let command = arguments
        .iter()
        .skip(1)
        .position(|argument| !is_option(argument))
        .map_or(arguments.len(), |index| index + 1);
    // Options like -q may stand before the command's name.
    let is_axis = arguments.get(command).is_some_and(|name| name == "axis");
    // `axis --help` asks about the group, not about `axis run`.
    let asks_help = |argument: &OsString| argument == "-h" || argument == "--help";
    let bare = arguments
        .get(command + 1)
        .is_some_and(|next| is_option(next) && !asks_help(next));
    if is_axis && bare {
        arguments.insert(command + 1, OsString::from("run"));
    }
    arguments
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arguments_are_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn options_after_axis_mean_axis_run() {
        let given = |text: &str| text.split(' ').map(OsString::from).collect::<Vec<_>>();
        for (from, to) in [
            ("l axis --setpoints a.csv", "l axis run --setpoints a.csv"),
            ("l -q axis -q --axis x:y", "l -q axis run -q --axis x:y"),
            ("l axis --help", "l axis --help"),
            ("l axis fit log.csv", "l axis fit log.csv"),
            ("l time axis --top 3", "l time axis --top 3"),
        ] {
            assert_eq!(with_axis_run(given(from)), given(to));
        }
    }
}
