//! `lostmotion compare`.

use super::{DONE, accepted, check_fit, failure, has_fit, prepare, show, text_options, to_json};
use crate::args::Form;
use crate::args::run::Compare;
use crate::failure::Failure;
use crate::output::{remark, stdout_has_color};
use crate::record::{Answer, Record};
use crate::voice::Voice;
use lostmotion::methods::MethodId;
use lostmotion::report::text;
use lostmotion::sim::{Machine, Simulation};

/// Runs a program with several methods. Exit code 0 whatever the verdicts are.
pub(crate) fn run(args: &Compare, voice: Voice) -> Result<u8, Failure> {
    let (program, machine, options) = prepare(&args.run)?;
    let methods = methods(
        &args.methods,
        &machine,
        voice.quiet || voice.diagnostics != Form::Text,
    )?;
    let mut record = Record::new(&args.run, &methods, voice.quiet)?;
    let result = Simulation::new(&program, &machine)
        .methods(&methods)
        .options(options.clone())
        .observer(&mut record)
        .run();
    let comparison = result.map_err(|error| failure(&program, &error, voice))?;
    accepted(&program, &machine, &options, voice)?;
    let json = to_json(&comparison)?;
    let plain = text::comparison(&comparison, &text_options(false));
    record.finish(&Answer {
        program: &comparison.program.name,
        machine: &comparison.machine,
        duration_s: comparison.plan.duration_s,
        tolerance_um: comparison.tolerance_um,
        results: &comparison.results,
        json_name: "comparison.json",
        json: &json,
        text_name: "comparison.txt",
        text: &plain,
    })?;
    show(
        args.run.format,
        &json,
        &text::comparison(&comparison, &text_options(stdout_has_color())),
    )?;
    Ok(DONE)
}

/// The methods asked for, each once; if none is named, all of them, without the one for fits where
/// there is no fit.
fn methods(asked: &[String], machine: &Machine, quiet: bool) -> Result<Vec<String>, Failure> {
    let mut methods: Vec<String> = Vec::new();
    for name in asked
        .iter()
        .map(|name| name.trim())
        .filter(|name| !name.is_empty())
    {
        if methods.iter().any(|known| known == name) {
            return Err(Failure::message(format!(
                "--methods names \"{name}\" twice"
            )));
        }
        methods.push(name.to_owned());
    }
    if methods.is_empty() {
        let fitted = has_fit(machine);
        methods = MethodId::all()
            .filter(|method| fitted || !method.needs_fit())
            .map(|method| method.to_string())
            .collect();
        if !fitted && !quiet {
            let named: Vec<&str> = MethodId::all()
                .filter(|method| method.needs_fit())
                .map(MethodId::name)
                .collect();
            remark(&format!(
                "note: {} is left out: no axis was told a fitted gap (--fitted AXIS=FILE.json)",
                named.join(", ")
            ));
        }
    }
    methods
        .iter()
        .try_for_each(|name| check_fit(name, machine))?;
    Ok(methods)
}
