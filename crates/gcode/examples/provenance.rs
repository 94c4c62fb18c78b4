//! Every motion of a program with the block that it comes from and the calls that led there.
//!
//! `cargo run -p lostmotion-gcode --example provenance PART` reads the part block by block, in
//! memory that does not grow with its length; without PART it runs the program below.

use lostmotion_gcode::{InterpreterConfig, MotionFold, MotionItem, Program};
use std::collections::VecDeque;
use std::error::Error;
use std::fs::File;
use std::io::{self, BufRead, BufReader, Write};

const OWN: &str = "G21 G90 F600\no<side> sub\n  G1 X#1 Y#2\no<side> endsub\no<square> sub\n  o<side> call [10] [0]\n  o<side> call [10] [10]\n\
                   o<square> endsub\nG0 X0 Y0\no<square> call\nM2\n";

fn main() -> Result<(), Box<dyn Error>> {
    let source: Box<dyn BufRead> = match std::env::args().nth(1) {
        Some(path) => Box::new(BufReader::new(File::open(path)?)),
        None => Box::new(OWN.as_bytes()),
    };
    let config = InterpreterConfig::default();
    let mut fold = MotionFold::new(config.start);
    let mut program = Program::new(source, config);
    let mut out = io::stdout().lock();
    let (mut ops, mut items) = (Vec::new(), VecDeque::new());
    while program.run_block(&mut ops) {
        for sourced in ops.drain(..) {
            fold.push_all(&sourced, &mut items)?;
        }
        for item in items.drain(..) {
            let MotionItem::Move(motion) = item else {
                continue;
            };
            let span = motion.block.span;
            write!(
                out,
                "{}:{} to {:?}",
                span.line,
                span.column,
                &motion.end.0[..3]
            )?;
            for call in program
                .interpreter()
                .call_stacks()
                .trace(motion.block.call_stack)
            {
                write!(
                    out,
                    ", in {} called from line {}",
                    call.name, call.call.line
                )?;
            }
            writeln!(out)?;
        }
    }
    for found in program.diagnostics().kept() {
        eprintln!("{found}");
    }
    Ok(())
}
