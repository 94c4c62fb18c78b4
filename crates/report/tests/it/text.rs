//! What people read, and what programs read.

use crate::common::{comparison, method, simulation, stop};
use lostmotion_methods::{Misled, Told};
use lostmotion_report::csv::{BlockWriter, ReversalWriter};
use lostmotion_report::json;
use lostmotion_report::text::{
    TextOptions, comparison as render_comparison, simulation as render_simulation,
};
use lostmotion_sim::results::{Harm, MisledResult, Trust};

fn options() -> TextOptions {
    TextOptions::default()
}

#[test]
fn a_simulation_in_a_terminal() {
    insta::assert_snapshot!(render_simulation(&simulation(), &options()));
}

#[test]
fn a_comparison_in_a_terminal() {
    insta::assert_snapshot!(render_comparison(&comparison(), &options()));
}

#[test]
fn sensitivity_and_reasons_in_a_terminal() {
    let mut run = comparison();
    let right = run.results[1].cutting;
    for (factor, share) in [(0.7, 1.1), (1.3, 2.5)] {
        let mut misled = MisledResult::default();
        misled.misled = Misled {
            what: Told::Gap,
            factor,
        };
        misled.cutting = right;
        misled.cutting.max *= share;
        misled.cutting.rms *= share;
        run.results[1].misled.push(misled);
    }
    run.results[1].not_recommended = Some("worse than none if told a gap".to_owned());
    let text = render_comparison(
        &run,
        &TextOptions {
            sensitivity: true,
            ..options()
        },
    );
    for part in [
        "gap x 0.70",
        "gap x 1.30",
        "(tested with gap, friction and stiffness told 30 % too small and too large)",
        "fixed: not recommended: worse than none if told a gap\n",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    // What it would take, with one quantity and with two, and where nothing helps.
    let mut trust = Trust::default();
    trust.method = "lookup".to_owned();
    trust.told = vec![Told::Gap];
    trust.within = Some(0.15);
    trust.least = 0.075;
    run.trust = Some(trust.clone());
    let text = render_comparison(&run, &options());
    let line = "\nlookup would be recommended if the gap were known within 15 %\n";
    assert!(text.contains(line), "{text}");
    trust.told.push(Told::Stiffness);
    trust.within = None;
    run.trust = Some(trust);
    let text = render_comparison(&run, &options());
    let line = "\nlookup is best where all is told right, but would not be safe even if the gap and stiffness both were known within 7.5 %\n";
    assert!(text.contains(line), "{text}");
    run.trust = None;
    // The table is there on request alone.
    assert!(!render_comparison(&run, &options()).contains("gap x 0.70"));
    run.results
        .iter_mut()
        .for_each(|result| result.misled.clear());
    assert!(!render_comparison(&run, &options()).contains("30 %"));
}

#[test]
fn a_program_that_does_not_cut_is_said_to() {
    let mut run = simulation();
    run.result = method("none", 0.0, 0.0);
    run.result.cutting = Default::default();
    run.result.worst_blocks.clear();
    run.result.reversals.clear();
    run.result.axes.clear();
    insta::assert_snapshot!(render_simulation(&run, &options()));
}

#[test]
fn a_machine_that_stops_is_said_to_before_anything_else() {
    let mut run = simulation();
    run.result.stop = Some(stop());
    run.result.within_tolerance = false;
    let text = render_simulation(&run, &options());
    let lines: Vec<&str> = text.lines().take(3).collect();
    assert_eq!(
        lines,
        [
            "circle.ngc on mill-worn, method fixed",
            "the machine stops in line 14 at 3.218 s: the following error of X is 1530.2 um, allowed are 1024.0; the compensator asks for -1529 um; the drive was at its current or voltage limit for 0.250 s",
            "up to there: largest contour error 12.35 um in line 5 (reversal of X), tolerance 10 um",
        ]
    );
}

#[test]
fn a_method_that_stops_the_machine_has_no_figures_and_does_no_harm() {
    let mut run = comparison();
    run.results[2].stop = Some(stop());
    run.results[2].notes.clear();
    let text = render_comparison(&run, &options());
    let row = text
        .lines()
        .find(|line| line.starts_with("published "))
        .unwrap();
    assert_eq!(
        row.split_whitespace().collect::<Vec<_>>().join(" "),
        "published - - - - - - stops in line 14 at 3.218 s -"
    );
    assert!(text.contains("\npublished: the machine stops in line 14 at 3.218 s: the following error of X is 1530.2 um"));
    assert_eq!(run.results[2].harm(&run.results[0]), None);
    for result in &mut run.results {
        result.stop = Some(stop());
    }
    run.recommended = None;
    let text = render_comparison(&run, &options());
    assert!(
        text.contains("recommended: no method; the machine stops with each of those compared\n")
    );
}

#[test]
fn colour_is_only_where_it_was_asked_for_and_changes_no_word() {
    let plain = render_simulation(&simulation(), &options());
    let coloured = render_simulation(
        &simulation(),
        &TextOptions {
            color: true,
            ..options()
        },
    );
    assert!(!plain.contains('\x1b'));
    assert!(coloured.contains("\x1b[1;31mOUTSIDE tolerance\x1b[0m"));
    assert_eq!(
        coloured.replace("\x1b[1;31m", "").replace("\x1b[0m", ""),
        plain
    );
}

#[test]
fn harm_is_a_larger_rms_or_else_a_larger_peak() {
    let none = method("none", 10.0, 10.0);
    assert_eq!(
        method("twice", 20.0, 20.0).harm(&none),
        Some(Harm::Rms(2.0))
    );
    assert_eq!(method("same", 10.0, 10.1).harm(&none), None);
    assert_eq!(none.harm(&none), None);
    let mut peak = method("peak", 10.0, 15.0);
    peak.backlash.rms = 1.0;
    assert_eq!(peak.harm(&none), Some(Harm::Peak(1.5)));
}

#[test]
fn json_has_a_version_and_reads_back_as_what_it_was() {
    let mut out = Vec::new();
    json::write(&mut out, &simulation()).unwrap();
    let text = String::from_utf8(out).unwrap();
    assert!(text.starts_with("{\n  \"schema\": 1,\n"));
    let read: lostmotion_sim::results::SingleRun = serde_json::from_str(&text).unwrap();
    assert_eq!(read.result.worst_blocks.len(), 2);
    let mut again = Vec::new();
    json::write(&mut again, &read).unwrap();
    assert_eq!(String::from_utf8(again).unwrap(), text);
}

#[test]
fn json_of_a_simulation() {
    let mut run = simulation();
    run.result.worst_blocks.truncate(1);
    run.result.reversals.truncate(1);
    run.result.axes.truncate(1);
    let mut out = Vec::new();
    json::write(&mut out, &run).unwrap();
    insta::assert_snapshot!(String::from_utf8(out).unwrap());
}

#[test]
fn blocks_and_reversals_as_tables() {
    let run = simulation();
    let mut blocks = BlockWriter::new(Vec::new()).unwrap();
    blocks.push("fixed", &run.result.worst_blocks).unwrap();
    let mut reversals = ReversalWriter::new(Vec::new()).unwrap();
    reversals.push("fixed", &run.result.reversals).unwrap();
    let text = [blocks.finish().unwrap(), reversals.finish().unwrap()]
        .map(|bytes| String::from_utf8(bytes).unwrap())
        .concat();
    insta::assert_snapshot!(text);
}
