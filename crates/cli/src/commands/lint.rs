//! `lostmotion lint`.

use super::{DONE, add_travel, failure, interpreter};
use crate::args::front::Lint;
use crate::diagnostics::Findings;
use crate::failure::Failure;
use crate::voice::Voice;
use crate::{input, output};
use lostmotion::gcode::Severity;
use lostmotion::gcode_tools::lint::{Level, Levels, lint, rules};
use lostmotion::report::findings::{Finding, Origin};
use lostmotion::sim::{Machine, Program, SimError, SimulateOptions, Simulation};

/// There are warnings, and no errors.
const WARNINGS: u8 = 1;
/// There are errors, or lints that were denied.
const ERRORS: u8 = 2;

/// Reports what the front end and the lints find, on stdout.
pub(crate) fn run(args: &Lint, voice: Voice) -> Result<u8, Failure> {
    let levels = levels(args)?;
    let source = input::program(&args.part)?;
    let (config, machine) = interpreter::config(&args.setup)?;
    let travel = rules::find("outside-travel").map_or(Level::Warn, |rule| levels.of(rule));
    let mut program =
        interpreter::open(&source, config)?.with_loader(args.setup.reading.loader(&args.part)?);
    let found = lint(&mut program, levels);
    let mut findings = Findings::of(&source, program.diagnostics());
    let origin = Origin {
        program: source.name(),
        provenance: program.diagnostics().provenance(),
    };
    findings.list.extend(
        found
            .kept()
            .iter()
            .map(|finding| Finding::from_lint(finding, &origin)),
    );
    findings.counts.errors += found.denied();
    findings.counts.warnings += found.warned();
    if let Some(machine) = machine.filter(|_| findings.counts.errors == 0) {
        let options = args.setup.reading.options(
            &args.part,
            machine.dialect(),
            SimulateOptions::default(),
        )?;
        on_machine((&source, &machine, &options), travel, &mut findings, voice)?;
    }
    findings
        .list
        .sort_by_key(|finding| (finding.span.file, finding.span.start));
    output::print(&findings.render(args.format.unwrap_or(voice.diagnostics))?)?;
    Ok(match findings.counts {
        counts if counts.errors > 0 => ERRORS,
        counts if counts.warnings > 0 => WARNINGS,
        _ => DONE,
    })
}

/// Holds the program against a machine's axes and travel.
fn on_machine(
    (source, machine, options): (&Program, &Machine, &SimulateOptions),
    level: Level,
    findings: &mut Findings<'_>,
    voice: Voice,
) -> Result<(), Failure> {
    if level == Level::Allow {
        return Ok(());
    }
    let simulation = Simulation::new(source, machine).options(options.clone());
    match simulation.check() {
        Ok(_) | Err(SimError::Empty { .. }) => Ok(()),
        Err(SimError::Travel { violations, .. }) => {
            add_travel(
                findings,
                if level == Level::Deny {
                    Severity::Error
                } else {
                    Severity::Warning
                },
                &violations,
            );
            Ok(())
        }
        Err(error) => Err(failure(source, &error, voice)),
    }
}

fn levels(args: &Lint) -> Result<Levels, Failure> {
    let mut levels = Levels::default();
    let given = [
        (&args.allow, Level::Allow),
        (&args.warn, Level::Warn),
        (&args.deny, Level::Deny),
    ];
    let (all, named): (Vec<_>, Vec<_>) = given
        .iter()
        .flat_map(|(codes, level)| codes.iter().map(|code| (code.as_str(), *level)))
        .partition(|(code, _)| *code == "all");
    for (code, level) in all.into_iter().chain(named) {
        if code != "all" && rules::find(code).is_none() {
            let known: Vec<&str> = rules::all().map(|rule| rule.code).collect();
            return Err(Failure::with_hint(
                format!("there is no lint \"{code}\""),
                format!("known lints: {}", known.join(", ")),
            ));
        }
        levels.set(code, level);
    }
    Ok(levels)
}
