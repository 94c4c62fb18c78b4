//! `lostmotion gcode`: what is done with the text of a part program.

use super::check::{Lint, lint};
use super::to_json;
use crate::findings::{Findings, Voice};
use crate::input;
use crate::options::part::{Setup, interpret};
use crate::options::{Format, show, whole};
use crate::output::{self, DONE, FOUND, Failure, is_standard};
use clap::{Args, Subcommand, ValueEnum, ValueHint};
use lostmotion::gcode::InterpreterConfig;
use lostmotion::gcode_tools::explain::explain as explained;
use lostmotion::gcode_tools::format::{
    Case, FormatOptions, FormatSummary, LineNumbers, format as formatted, refers_to_line_numbers,
};
use lostmotion::gcode_tools::writer::{WriterError, Written, write_program};
use lostmotion::report::atomic::AtomicFile;
use lostmotion::sim::Program;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

/// `gcode`.
#[derive(Debug, Subcommand)]
pub(crate) enum GcodeCommand {
    /// Say what a line does, with the modes and the position before and after
    Explain(Explain),
    /// Put a part program into one style without changing what it does
    Format(FormatPart),
    /// Write a program with everything computed: no parameters, loops, calls, cycles, offsets;
    /// lines and arcs with coordinates
    Write(WritePart),
    /// Print the canonical operations of a part program, one per line
    Canon(Canon),
    /// Look for what is allowed and may still break a tool, a part or a machine. Exit code 0
    /// nothing, 1 warnings, 2 errors
    Lint(Lint),
}

/// Runs the command asked for.
pub(crate) fn run(command: &GcodeCommand, quiet: bool) -> Result<u8, Failure> {
    match command {
        GcodeCommand::Explain(args) => explain(args, quiet),
        GcodeCommand::Format(args) => format(args, quiet),
        GcodeCommand::Write(args) => write(args, quiet),
        GcodeCommand::Canon(args) => canon(args, quiet),
        GcodeCommand::Lint(args) => lint(args, quiet),
    }
}

/// `canon`.
#[derive(Debug, Args)]
pub(crate) struct Canon {
    /// Part program; `-` is stdin
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) part: PathBuf,
    /// Start like LinuxCNC's stand-alone interpreter `rs274`, whose machine units, those of the
    /// tool table too, are inches
    #[arg(long, conflicts_with_all = ["machine", "set", "offset"])]
    pub(crate) like_rs274: bool,
    #[command(flatten)]
    pub(crate) setup: Setup,
}

/// `format`.
#[derive(Debug, Args)]
pub(crate) struct FormatPart {
    /// Part program; `-` is stdin
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) part: PathBuf,
    /// Change nothing and say what would be changed; exit code 1 if there is something
    #[arg(long, conflicts_with = "write")]
    pub(crate) check: bool,
    /// Write the file in place instead of stdout
    #[arg(long)]
    pub(crate) write: bool,
    /// Case of letters outside comments
    #[arg(long, value_enum, default_value_t)]
    pub(crate) case: LetterCase,
    /// Spaces for each level of O-words
    #[arg(long, value_name = "N", default_value_t = 2, allow_negative_numbers = true, value_parser = whole::<usize>)]
    pub(crate) indent: usize,
    /// Line numbers: keep, remove, or the step of new numbers
    #[arg(long, value_name = "keep|remove|STEP", default_value = "keep")]
    pub(crate) line_numbers: String,
}

/// Case of letters.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub(crate) enum LetterCase {
    /// G1 X10; O-words stay as they are
    #[default]
    Upper,
    /// g1 x10
    Lower,
    /// Unchanged
    Keep,
}

/// `explain`.
#[derive(Debug, Args)]
pub(crate) struct Explain {
    /// Part program and line, for example part.ngc:12
    #[arg(value_name = "PART:LINE", value_hint = ValueHint::FilePath)]
    pub(crate) place: String,
    /// Form of the answer
    #[arg(long, value_enum, default_value_t)]
    pub(crate) format: Format,
    #[command(flatten)]
    pub(crate) setup: Setup,
}

/// `write`.
#[derive(Debug, Args)]
pub(crate) struct WritePart {
    /// Part program; `-` is stdin
    #[arg(value_hint = ValueHint::FilePath)]
    pub(crate) part: PathBuf,
    /// Work coordinate system, 1 for G54 to 9 for G59.3, that the coordinates of the new program
    /// are in
    #[arg(long, value_name = "N", default_value_t = 1, allow_negative_numbers = true, value_parser = whole::<u8>)]
    pub(crate) system: u8,
    /// File to write; stdout, if left out or `-`
    #[arg(long, short, value_name = "FILE", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    #[command(flatten)]
    pub(crate) setup: Setup,
}

/// `canon`: as `gcode canon --like-rs274`.
pub(crate) fn canon_like_rs274(args: &Canon, quiet: bool) -> Result<u8, Failure> {
    print_operations(args, true, args.setup.reading.voice(quiet))
}

fn canon(args: &Canon, quiet: bool) -> Result<u8, Failure> {
    print_operations(args, args.like_rs274, args.setup.reading.voice(quiet))
}

/// Prints canonical operations. If the program has errors, the operations of the blocks without
/// errors are printed, and the failure carries all that was found.
fn print_operations(args: &Canon, like_rs274: bool, voice: Voice) -> Result<u8, Failure> {
    let source = input::program(&args.part)?;
    let alone = if like_rs274 {
        InterpreterConfig::like_rs274()
    } else {
        InterpreterConfig::default()
    };
    let machine = args.setup.machine()?;
    let config = args.setup.config(machine.as_ref(), alone)?;
    let loader = args.setup.reading.loader(&args.part)?;
    let mut program = interpret(&source, config, Some(loader))?;
    // Operations go out as they are made: a program may be longer than memory.
    let mut out = output::stdout();
    for sourced in program.by_ref() {
        if !output::go_on(writeln!(out, "{}", sourced.op))? {
            return Ok(DONE);
        }
    }
    output::go_on(out.flush())?;
    let findings = Findings::of(&source, program.diagnostics());
    if findings.counts.errors > 0 {
        return Err(findings.failure(voice));
    }
    findings.remark(voice)?;
    Ok(DONE)
}

/// Explains a line; what is wrong with the program is a remark.
pub(crate) fn explain(args: &Explain, quiet: bool) -> Result<u8, Failure> {
    let voice = args.setup.reading.voice(quiet);
    let (part, line) = place(&args.place)?;
    let source = input::program(Path::new(part))?;
    let machine = args.setup.machine()?;
    let config = args
        .setup
        .config(machine.as_ref(), InterpreterConfig::default())?;
    let loader = args.setup.reading.loader(Path::new(part))?;
    let mut program = interpret(&source, config, Some(loader))?;
    // The whole program is run: modes and position come from the lines before, and a loop or a call
    // may bring the line again.
    let Some(explanation) = explained(&mut program, line) else {
        return Err(Failure::message(format!("{part} has no line {line}")));
    };
    let json = if args.format == Format::Json {
        to_json(&explanation)?
    } else {
        String::new()
    };
    show(args.format, &json, &explanation.to_string())?;
    Findings::of(&source, program.diagnostics()).remark(voice)?;
    Ok(DONE)
}

fn place(text: &str) -> Result<(&str, u32), Failure> {
    // From the right: paths may hold colons themselves (C:\part.ngc).
    let parts = text
        .rsplit_once(':')
        .and_then(|(part, line)| Some((part, line.parse().ok().filter(|line| *line > 0)?)));
    parts.ok_or_else(|| {
        Failure::with_hint(
            format!("\"{text}\" is not of the form PART:LINE"),
            "for example: part.ngc:12; lines count from 1",
        )
    })
}

/// Writes the resolved program to a file, which appears complete or not at all, or to stdout.
pub(crate) fn write(args: &WritePart, quiet: bool) -> Result<u8, Failure> {
    let voice = args.setup.reading.voice(quiet);
    let source = input::program(&args.part)?;
    let out = args.out.as_ref().filter(|path| !is_standard(path));
    if let Some(path) = out {
        output::refuse_input(path, &args.part, "part program")?;
        output::refuse_inputs(path, args.setup.on.inputs())?;
    }
    let machine = args.setup.machine()?;
    let config = args
        .setup
        .config(machine.as_ref(), InterpreterConfig::default())?;
    let loader = args.setup.reading.loader(&args.part)?;
    // Nothing is written of a program that is refused: the first pass finds the errors, the second
    // one writes.
    let again = std::sync::Arc::clone(&loader);
    let mut program = interpret(&source, config.clone(), Some(again))?;
    for _ in program.by_ref() {}
    let findings = Findings::of(&source, program.diagnostics());
    if findings.counts.errors > 0 {
        return Err(findings.failure(voice));
    }
    let mut program = interpret(&source, config.clone(), Some(loader))?;
    let result = match out {
        Some(path) => {
            let mut file = AtomicFile::create(path)?;
            let result = write_program(&mut program, &config, args.system, &mut file);
            if result.is_ok() {
                file.commit()?;
            }
            result
        }
        None => write_program(&mut program, &config, args.system, &mut output::stdout()),
    };
    match result {
        Ok(Written { blocks, .. }) => {
            findings.remark(voice)?;
            if let Some(path) = out.filter(|_| !quiet) {
                output::print(&format!("{}: {blocks} blocks\n", path.display()))?;
            }
            Ok(DONE)
        }
        // `| head` has read enough.
        Err(WriterError::Io(error)) if error.kind() == ErrorKind::BrokenPipe => Ok(DONE),
        Err(error @ WriterError::Turned { .. }) => Err(Failure::with_hint(
            format!("{}: {error}", source.name()),
            "have the CAM system write the moves without G68 or G68.2, in the coordinates of the machine's axes",
        )),
        Err(error) => Err(Failure::message(format!("{}: {error}", source.name()))),
    }
}

/// Formats to stdout or in place, or checks.
pub(crate) fn format(args: &FormatPart, quiet: bool) -> Result<u8, Failure> {
    if args.write && is_standard(&args.part) {
        return Err(Failure::with_hint(
            "--write needs a file to write, and the part program is stdin",
            "leave --write out: the formatted program goes to stdout",
        ));
    }
    let source = input::program(&args.part)?;
    let failed =
        |error: io::Error| Failure::message(format!("cannot format {}: {error}", source.name()));
    let options = options(args, &source)?;
    let reader = source.open().map_err(failed)?;
    let summary = if args.check {
        let summary = formatted(reader, &options, &mut io::sink()).map_err(failed)?;
        output::print(&changes(&source, &summary))?;
        return Ok(if summary.changed > 0 { FOUND } else { DONE });
    } else if args.write {
        // Read from the old file while the new one is written; they are swapped at the end.
        let mut file = AtomicFile::create(&args.part)?;
        let summary = formatted(reader, &options, &mut file).map_err(failed)?;
        if summary.changed > 0 {
            file.commit()?;
        }
        summary
    } else {
        let mut out = output::stdout();
        match formatted(reader, &options, &mut out)
            .and_then(|summary| out.flush().map(|()| summary))
        {
            Ok(summary) => summary,
            Err(error) => {
                // A reader that has gone is no failure; any other error is.
                output::go_on(Err(error))?;
                return Ok(DONE);
            }
        }
    };
    if args.write && !quiet {
        output::print(&format!(
            "{}: {} of {} lines changed\n",
            source.name(),
            summary.changed,
            summary.lines
        ))?;
    }
    Ok(DONE)
}

/// Most blanks for a level of O-words. A choice: ten levels still leave room in a line.
const MAX_INDENT: usize = 16;

fn options(args: &FormatPart, source: &Program) -> Result<FormatOptions, Failure> {
    let case = match args.case {
        LetterCase::Upper => Case::Upper,
        LetterCase::Lower => Case::Lower,
        LetterCase::Keep => Case::Keep,
    };
    let line_numbers = match args.line_numbers.as_str() {
        "keep" => LineNumbers::Keep,
        "remove" => LineNumbers::Remove,
        step => match step.parse() {
            Ok(step @ 1..=10_000) => LineNumbers::Renumber { step },
            _ => {
                return Err(Failure::message(format!(
                    "--line-numbers is {step}; it has to be keep, remove, or a step from 1 to 10000"
                )));
            }
        },
    };
    // GOTO and M99 P jump to N numbers: a new numbering would change what the program does.
    if line_numbers != LineNumbers::Keep {
        let failed =
            |error: io::Error| Failure::message(format!("cannot read {}: {error}", source.name()));
        if let Some(line) =
            refers_to_line_numbers(source.open().map_err(failed)?).map_err(failed)?
        {
            let text = format!(
                "{}, line {line}: the program refers to its line numbers",
                source.name()
            );
            return Err(Failure::with_hint(text, "use --line-numbers keep"));
        }
    }
    if args.indent > MAX_INDENT {
        return Err(Failure::message(format!(
            "--indent is {}; it has to be 0 to {MAX_INDENT}",
            args.indent
        )));
    }
    Ok(FormatOptions {
        case,
        indent: args.indent,
        line_numbers,
        ..FormatOptions::default()
    })
}

/// What would be changed: each line before and after.
fn changes(source: &Program, summary: &FormatSummary) -> String {
    let mut text = String::new();
    for change in &summary.changes {
        let [before, after] = [&change.before, &change.after]
            .map(|bytes| String::from_utf8_lossy(bytes).into_owned());
        text.push_str(&format!(
            "{}:{}\n- {before}\n+ {after}\n",
            source.name(),
            change.line
        ));
    }
    // Only the first changes are kept, all are counted.
    let more = summary.changed - summary.changes.len() as u64;
    if more > 0 {
        text.push_str(&format!("and {more} more\n"));
    }
    if summary.changed > 0 {
        text.push_str(&format!(
            "{}: {} of {} lines would change\n",
            source.name(),
            summary.changed,
            summary.lines
        ));
    }
    text
}
