//! Contour-error metrics of the sample parts with every method, locked.
//!
//! A snapshot says what a part's error is to 0.1 um, which is below what any of its causes can be
//! known to. It locks what other tests check by closed forms and invariants; review a change of one
//! like a change of the model. A method that runs away is said to do so, and where it stops the
//! machine: how far it gets is chance.

use crate::common::{machine, part, run};
use lostmotion::Run;
use std::fmt::Write;

/// Part, machine. Short parts: together they take a minute.
const PARTS: &[(&str, &str)] = &[
    ("circle_r10.ngc", "vmc3"),
    ("circle_r50.ngc", "vmc3-worn"),
    ("square_sharp.ngc", "vmc3"),
    ("square_rounded.ngc", "vmc3"),
    ("lissajous.ngc", "vmc3"),
    ("bearing_bore.ngc", "vmc3"),
    ("contour_rarcs.ngc", "vmc3-worn"),
    ("engraving.ngc", "vmc3"),
    ("parameters.ngc", "vmc3"),
    ("incremental_comb.ngc", "vmc3-worn"),
    ("planes_ball.ngc", "vmc3"),
    ("trunnion_cone.ngc", "trunnion5"),
];

/// Error from which a method has lost the part, um.
const RUNS_AWAY_UM: f64 = 500.0;

const METHODS: &[&str] = &["none", "fixed", "published", "load-feedback"];

fn table(comparison: &Run) -> String {
    let mut text = String::new();
    let plan = &comparison.plan;
    let _ = writeln!(
        text,
        "{:.3} s, {} moves, cutting {:.1} mm, command off the path by {:.1} um at most",
        plan.duration_s, comparison.program.moves, plan.cutting_mm, plan.command.max
    );
    let _ = writeln!(
        text,
        "{:<14} {:>8} {:>8} {:>8} {:>8}  worst",
        "um", "max", "p99", "rms", "backlash"
    );
    let row = &comparison.without_gap;
    let _ = writeln!(
        text,
        "{:<14} {:>8.1} {:>8.1} {:>8.1} {:>8}",
        "without gap", row.max, row.p99, row.rms, "-"
    );
    for result in &comparison.results {
        let row = &result.cutting;
        if let Some(stop) = &result.stop {
            let line = stop.block.span.line;
            let (limit, motor) = (stop.limit, stop.motor());
            let _ = writeln!(
                text,
                "{:<14} stops in line {line}: {limit} of {motor}",
                result.method
            );
            continue;
        }
        if row.max > RUNS_AWAY_UM {
            let _ = writeln!(text, "{:<14} runs away", result.method);
            continue;
        }
        let worst = result.worst_blocks.first().map_or(String::new(), |block| {
            format!("line {} {:?}", block.block.span.line, block.cause)
        });
        let _ = writeln!(
            text,
            "{:<14} {:>8.1} {:>8.1} {:>8.1} {:>8.1}  {worst}",
            result.method, row.max, row.p99, row.rms, result.backlash.rms
        );
    }
    text
}

fn check(index: usize) {
    let (name, on) = PARTS[index];
    let comparison =
        run(&part(name), &machine(on), METHODS).unwrap_or_else(|error| panic!("{name}: {error}"));
    // No sound machine stops, whatever sound method it has.
    for result in comparison
        .results
        .iter()
        .filter(|r| r.method != "published")
    {
        assert_eq!(result.stop, None, "{name} on {on}: {}", result.method);
    }
    insta::with_settings!({ prepend_module_to_snapshot => false, omit_expression => true }, {
        insta::assert_snapshot!(format!("{}__{on}", name.trim_end_matches(".ngc")), table(&comparison));
    });
}

macro_rules! parts {
    ($($test:ident $index:literal)*) => { $(#[test] fn $test() { check($index); })* };
}

// One test a part, so that they run side by side.
parts! { part_00 0 part_01 1 part_02 2 part_03 3 part_04 4 part_05 5 part_06 6 part_07 7 part_08 8 part_09 9 part_10 10 part_11 11 }

#[test]
fn every_listed_part_is_tested() {
    assert_eq!(PARTS.len(), 12);
}
