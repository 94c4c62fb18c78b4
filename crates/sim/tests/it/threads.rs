//! Threads, chunks and how far was read ahead change no bit, and no error.

use lostmotion_plan::Sample;
use lostmotion_sim::results::BlockResult;
use lostmotion_sim::{
    ContourPoint, Machine, Observer, Program, Progress, SimulateOptions, Simulation,
};
use std::fmt::Write;
use std::ops::ControlFlow;

/// Rows over a wavy surface, arcs, a dwell, exact stops, and slots at right angles.
fn part() -> Program {
    let mut text = String::from("G21 G90 G17 G64 P0.01\nG0 X0 Y0 Z5\nF4000\n");
    for row in 0..6 {
        for i in 0..120 {
            let along = 0.4 * f64::from(if row % 2 == 0 { i } else { 119 - i });
            let z = 2.0 * (0.2 * along).sin() * (0.4 * f64::from(row)).cos();
            writeln!(text, "G1 X{along:.3} Y{:.3} Z{z:.3}", 0.4 * f64::from(row)).unwrap();
        }
    }
    text.push_str("G4 P1.5\nG1 X20 Y20 Z0\nG2 X40 Y20 I10 J0\nG3 X20 Y20 I-10 J0\nG4 P2.2\n");
    text.push_str("G61\nG1 X30\nG1 Y30\nG1 X20\nG64 P0.02\nG1 Y20\nG0 Z10\nM2\n");
    Program::from_bytes("part.ngc", text.into_bytes())
}

/// Everything that is handed out.
#[derive(Default)]
struct All {
    rows: Vec<String>,
    points: Vec<[u64; 3]>,
    most: Option<usize>,
}

impl Observer for All {
    fn progress(&mut self, _progress: Progress) -> ControlFlow<()> {
        match self.most {
            Some(most) if self.points.len() > most => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        }
    }

    fn blocks(&mut self, method: usize, rows: &[BlockResult]) {
        self.rows
            .extend(rows.iter().map(|row| format!("{method} {row:?}")));
    }

    fn contour(&mut self, _method: usize, points: &[ContourPoint]) {
        self.points.extend(
            points
                .iter()
                .map(|point| [point.time_s, point.error_um, point.backlash_um].map(f64::to_bits)),
        );
    }

    fn wants_contour(&self) -> bool {
        true
    }
}

fn options(threads: usize, chunk_samples: usize) -> SimulateOptions {
    SimulateOptions {
        threads,
        chunk_samples,
        ..SimulateOptions::default()
    }
}

#[test]
fn no_bit_depends_on_threads_or_chunks() {
    let (source, machine) = (part(), Machine::preset("vmc3").unwrap());
    let run = |threads: usize, chunk_samples: usize| {
        let mut all = All::default();
        let run = Simulation::new(&source, &machine)
            .methods(["none", "lookup", "adaptive"])
            .options(options(threads, chunk_samples))
            .observer(&mut all)
            .run()
            .unwrap();
        // Rows and points of several methods come in turns, chunk by chunk.
        all.rows.sort_unstable();
        all.points.sort_unstable();
        (format!("{run:?}"), all.rows, all.points)
    };
    let one = run(1, 1000);
    assert!(one.1.len() > 2000 && one.2.len() > 100_000);
    for (threads, chunk_samples) in [(2, 1000), (3, 1000), (4, 137), (1, 61)] {
        assert!(run(threads, chunk_samples) == one, "{threads} threads");
    }
}

/// Samples that are handed out, and the answer.
fn planned(source: &Program, threads: usize) -> (Vec<[u64; 3]>, String) {
    let (mut places, machine) = (Vec::new(), Machine::preset("bench3").unwrap());
    let simulation = Simulation::new(source, &machine).options(options(threads, 50));
    let result = simulation.plan(&mut |samples, _| {
        let place = |sample: &Sample| sample.position.linear().map(f64::to_bits);
        places.extend(samples.iter().map(place));
        Ok(())
    });
    (places, format!("{result:?}"))
}

#[test]
fn a_plan_and_where_it_ends_do_not_depend_on_threads() {
    let endless = "G21 G90 G64 P0.1\nO100 while [1 GT 0]\nG1 X10 F3000\nG1 Y10\nG1 X0\nG1 Y0\nO100 endwhile\nM2\n";
    for source in [
        part(),
        Program::from_str("endless.ngc", endless),
        Program::from_str("empty.ngc", "M2\n"),
    ] {
        let one = planned(&source, 1);
        for threads in [2, 4] {
            assert!(planned(&source, threads) == one, "{threads}");
        }
    }
}

#[test]
fn a_run_that_is_cancelled_ends_on_any_number_of_threads() {
    let (source, machine) = (part(), Machine::preset("vmc3").unwrap());
    for threads in [1, 2, 4] {
        let mut all = All {
            most: Some(5000),
            ..All::default()
        };
        let result = Simulation::new(&source, &machine)
            .threads(threads)
            .observer(&mut all)
            .run();
        assert!(result.is_err());
        assert!(all.points.len() < 20_000, "{}", all.points.len());
    }
}
