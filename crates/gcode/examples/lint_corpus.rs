//! Lints all programs given and prints a line for every finding: `lint_corpus FILE...`.

use lostmotion_gcode::lint::{Levels, lint};
use lostmotion_gcode::{InterpreterConfig, Program};
use std::fs::File;
use std::io::{self, BufReader};

fn main() -> io::Result<()> {
    for name in std::env::args().skip(1) {
        let mut program = Program::new(BufReader::new(File::open(&name)?), InterpreterConfig::like_rs274());
        let found = lint(&mut program, Levels::default());
        let errors = program.diagnostics().errors();
        for finding in found.kept() {
            println!("{name}:{}: [{}] {errors} {}", finding.place.span.line, finding.rule.code, finding.message);
        }
    }
    Ok(())
}
