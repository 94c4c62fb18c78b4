//! Stage 8: a run as people and programs read it.
//!
//! Text for a terminal, JSON with a version number that reads back exactly, rows for a table as
//! they are finished.

use lostmotion::report::{json, text};
use lostmotion::results::{BlockResult, SingleRun};
use lostmotion::{Machine, Observer, Program, Simulation};

/// Counts the blocks as they are finished; a real one would write them to a file.
#[derive(Default)]
struct Rows {
    count: usize,
    worst: Option<BlockResult>,
}

impl Observer for Rows {
    fn blocks(&mut self, _method: usize, rows: &[BlockResult]) {
        self.count += rows.len();
        for row in rows {
            let before = self.worst.as_ref().map_or(0.0, |worst| worst.max_um.abs());
            if !row.rapid && row.max_um.abs() > before {
                self.worst = Some(row.clone());
            }
        }
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let program = Program::from_str(
        "square.ngc",
        "G21 G90 G94 G64 P0.01\nG0 X0 Y0 Z5\nG1 X20 F2000\nG1 Y20\nG1 X0\nG1 Y0\nM2\n",
    );
    let machine = Machine::preset("vmc3")?;
    let mut rows = Rows::default();
    let run = Simulation::new(&program, &machine)
        .method("none")
        .observer(&mut rows)
        .run()?;
    let run = run.into_single().ok_or("one method")?;

    let table = text::simulation(&run, &text::TextOptions::default());
    println!("{}", table.lines().take(2).collect::<Vec<_>>().join("\n"));
    if let Some(worst) = rows.worst {
        println!("{} blocks, the worst is `{}`", rows.count, worst.text);
    }

    let mut out = Vec::new();
    json::write(&mut out, &run)?;
    let back: SingleRun = serde_json::from_slice(&out)?;
    println!(
        "schema {}, {} worst blocks",
        back.schema,
        back.result.worst_blocks.len()
    );
    Ok(())
}

// Prints:
// square.ngc on vmc3, method none
// within tolerance: largest contour error 10.16 um in line 6 (reversal of Y), tolerance 20 um
// 5 blocks, the worst is `G1 Y0`
// schema 1, 4 worst blocks
