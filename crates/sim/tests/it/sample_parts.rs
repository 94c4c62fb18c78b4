//! The sample parts are what they say: understood without a warning, small, commented, within reach
//! of their machine.

use lostmotion_gcode::{CanonicalOp, InterpreterConfig, Program};
use lostmotion_sim::machine::Machine;
use std::path::PathBuf;

fn samples() -> Vec<PathBuf> {
    let folder = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../gcode_samples/parts");
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder)
        .into_iter()
        .flatten()
        .flatten()
        .map(|entry| entry.path())
        .collect();
    files.sort();
    files
}

fn machine_for(name: &str) -> Option<Machine> {
    Machine::preset(match name {
        name if name.starts_with("trunnion") => "trunnion5",
        name if name.starts_with("rotary") => "vmc4",
        name if name.starts_with("fork") => "fork5",
        name if name.starts_with("swivel") => "swivel5",
        name if name.starts_with("nutating") => "nutating5",
        name if name.starts_with("scara") => "scara",
        name if name.starts_with("arm") => "arm6",
        _ => "vmc3",
    })
    .ok()
}

#[test]
fn every_sample_part_is_understood() {
    let files = samples();
    assert!(files.len() >= 14, "{} samples", files.len());
    for path in files {
        let name = path
            .file_stem()
            .and_then(|stem| stem.to_str())
            .unwrap_or_default()
            .to_owned();
        let text = std::fs::read(&path).unwrap_or_default();
        assert!(text.len() < 30_000 && text.is_ascii(), "{name}");
        let opening = format!("({name}: ");
        let first = text.strip_prefix(b"%\n").unwrap_or(&text);
        assert!(
            first.starts_with(opening.as_bytes()),
            "{name} does not begin with what it shows"
        );
        let Some(machine) = machine_for(&name) else {
            panic!("{name}: no machine")
        };
        let mut config = InterpreterConfig {
            start: machine.start(),
            dialect: machine.dialect(),
            leniencies: machine.dialect().leniencies(),
            ..InterpreterConfig::default()
        };
        for (system, origin) in (1..).zip(machine.work_offsets()) {
            config = config.with_work_offset(system, origin);
        }
        let mut program = Program::new(&text[..], config);
        let cuts = program
            .by_ref()
            .filter(|op| {
                matches!(
                    op.op,
                    CanonicalOp::StraightFeed(_) | CanonicalOp::ArcFeed(_)
                )
            })
            .count();
        // A leniency that the machine's dialect has is told, and H where the machine lists no
        // tools; nothing else.
        let told = program
            .diagnostics()
            .kept()
            .iter()
            .filter(|found| !["five-axis", "no-tool-table"].contains(&found.problem.code()))
            .count();
        assert!(told == 0, "{name}: {:?}", program.diagnostics().kept());
        assert!(cuts >= 10, "{name} cuts {cuts} times");
    }
}
