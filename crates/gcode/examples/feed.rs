//! A console: reads lines from stdin and tells at once what each of them does. `G1 X10 F200`, for
//! example.

use lostmotion_gcode::{Feeder, InterpreterConfig};
use std::io::{self, BufRead, Write};

fn main() -> io::Result<()> {
    let mut feeder = Feeder::new(InterpreterConfig::default());
    let mut out = io::stdout().lock();
    for line in io::stdin().lock().split(b'\n') {
        let fed = feeder.feed(&line?);
        for sourced in &fed.ops {
            writeln!(out, "  {}", sourced.op)?;
        }
        for diagnostic in &fed.diagnostics {
            writeln!(out, "  {diagnostic}")?;
        }
        if fed.waits {
            writeln!(out, "  ...")?;
        }
        if fed.ended {
            break;
        }
    }
    Ok(())
}
