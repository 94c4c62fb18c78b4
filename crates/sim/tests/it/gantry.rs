//! Two motors on one axis: the tool between them as a lever says, and how far they are apart.

use lostmotion_base::AxisId;
use lostmotion_drive::config::Load;
use lostmotion_sim::machine::{Change, Machine, presets};
use lostmotion_sim::{
    ContourPoint, Observer, Program, SimulateOptions, Simulation, results::SingleRun,
};

/// Where the beam's screws are along X of the preset, machine coordinates, mm.
const ENDS: [f64; 2] = [-860.0, 98.0];
/// Part zero in X, mm.
const ZERO: f64 = -381.0;

/// Keeps the points of some lines.
struct Points {
    lines: Vec<u32>,
    kept: Vec<ContourPoint>,
}

impl Observer for Points {
    fn wants_contour(&self) -> bool {
        true
    }

    fn contour(&mut self, _method: usize, points: &[ContourPoint]) {
        self.kept.extend(
            points
                .iter()
                .filter(|point| self.lines.contains(&point.block.span.line)),
        );
    }
}

fn text() -> &'static str {
    presets()
        .iter()
        .find(|preset| preset.name == "gantry3")
        .expect("gantry3")
        .toml
}

fn machine(gaps_um: [f64; 2]) -> Machine {
    let (before, y) = text().split_at(text().find("[axis.y.").expect("Y"));
    let before = before.replacen(
        "second_gap_um = 25.0",
        &format!("second_gap_um = {:?}", gaps_um[1]),
        1,
    );
    let machine = format!(
        "{before}{}",
        y.replacen("gap_um = 10.0", &format!("gap_um = {:?}", gaps_um[0]), 1)
    );
    let machine = Machine::from_toml("g.toml", &machine).unwrap_or_else(|error| panic!("{error}"));
    assert!(
        (machine.gantry().expect("a gantry").second.gap_in_unit() * 1e3 - gaps_um[1]).abs() < 1e-9
    );
    assert!(
        (machine.axis(AxisId::Y).expect("Y").config.gap_in_unit() * 1e3 - gaps_um[0]).abs() < 1e-9
    );
    machine
}

fn run(
    machine: &Machine,
    program: &str,
    lines: &[u32],
    method: &str,
) -> (SingleRun, Vec<ContourPoint>) {
    let mut points = Points {
        lines: lines.to_vec(),
        kept: Vec::new(),
    };
    let source = Program::from_bytes("part.ngc", program.as_bytes());
    let result = Simulation::new(&source, machine)
        .method(method)
        .observer(&mut points)
        .run()
        .map(|run| run.into_single().unwrap())
        .expect("a result");
    (result, points.kept)
}

/// Lines along X: the first after Y came from below, the second after it came from above, so slowly
/// that friction stops the beam on its flanks.
const COMB: &str = "G21 G90 G17 G61\nG1 X-150 Y-20 F6000\nY-10.5\nY-10 F60\nG4 P0.2\nX150 F3000\nY20\nY10.5\nY10 F60\nG4 P0.2\nX-150 F3000\nM2\n";

/// Friction holds the beam's ends on their flanks, half a gap behind: at x the tool is off by half
/// of what the lever makes of both gaps.
#[test]
fn the_tool_is_off_by_what_the_lever_makes_of_both_gaps() {
    for gaps in [[10.0, 30.0], [40.0, 0.0], [20.0, 20.0]] {
        let (_, points) = run(&machine(gaps), COMB, &[6, 11], "none");
        let mut seen = 0;
        for point in points.iter().filter(|point| point.foot_mm[0].abs() < 140.0) {
            let share = (point.foot_mm[0] + ZERO - ENDS[0]) / (ENDS[1] - ENDS[0]);
            let expected = 0.5 * (gaps[0] + share * (gaps[1] - gaps[0]));
            // the side follows the travel: the beam lags to -Y on line 6 (right of +X), to +Y on
            // line 11 (right of -X)
            assert!(
                (point.backlash_um + expected).abs() < 0.3,
                "{gaps:?} at {:?}: {} against {expected}",
                point.foot_mm,
                point.backlash_um
            );
            seen += 1;
        }
        assert!(seen > 1000, "{seen}");
    }
}

/// In the middle of the beam two gaps are like one of their mean.
#[test]
fn in_the_middle_the_effective_gap_is_the_mean() {
    let (_, points) = run(&machine([10.0, 30.0]), COMB, &[6], "none");
    let middle = points
        .iter()
        .min_by(|a, b| a.foot_mm[0].abs().total_cmp(&b.foot_mm[0].abs()))
        .expect("points");
    assert!(
        (middle.backlash_um.abs() - 0.5 * (10.0 + 30.0) / 2.0).abs() < 0.2,
        "{}",
        middle.backlash_um
    );
}

#[test]
fn skew_is_half_the_difference_of_the_gaps_and_names_its_block() {
    let (result, _) = run(&machine([10.0, 30.0]), COMB, &[], "none");
    let gantry = result.result.gantry.expect("a gantry");
    assert_eq!(gantry.axis, AxisId::Y);
    assert!((gantry.skew_um.p50 - 10.0).abs() < 0.5, "{gantry:?}");
    assert!(
        gantry.skew_um.max >= 9.5 && (gantry.peak_um.abs() - gantry.skew_um.max).abs() < 1e-9,
        "{gantry:?}"
    );
    assert!((2..=11).contains(&gantry.block.span.line), "{gantry:?}");
    // like ends do not skew
    let (result, _) = run(&machine([20.0, 20.0]), COMB, &[], "none");
    assert!(result.result.gantry.expect("a gantry").skew_um.max < 1e-9);
}

/// Each end has its own compensator: told their gaps, both take them up.
#[test]
fn each_end_has_a_compensator_of_its_own() {
    let machine = machine([10.0, 30.0]);
    let rms = |method| run(&machine, COMB, &[], method).0.result.backlash.rms;
    let [none, fixed] = [rms("none"), rms("fixed")];
    assert!(fixed < 0.2 * none, "{fixed} um against {none} um");
    let skew = run(&machine, COMB, &[], "fixed")
        .0
        .result
        .gantry
        .expect("a gantry")
        .skew_um;
    assert!(skew.p50 < 1.0, "{skew:?}");
}

/// Newtons of the slide's Coulomb friction, and N/um of its screw, in the preset.
fn slide() -> (f64, f64) {
    let machine = Machine::preset("gantry3").expect("gantry3");
    let Load::Slide(slide) = machine.axis(AxisId::Y).expect("Y").config.load else {
        panic!("a slide")
    };
    (slide.coulomb_n, slide.stiffness_n_per_um)
}

fn with_beam(machine: &Machine, stiffness_n_per_um: f64) -> Machine {
    let table = format!(
        "[gantry.beam]\nstiffness_n_per_um = {stiffness_n_per_um:?}\ndamping_n_s_per_mm = 20.0\n"
    );
    Machine::from_toml(
        "g.toml",
        &format!("{}{table}", machine.to_toml().expect("a file")),
    )
    .unwrap_or_else(|error| panic!("{error}"))
}

/// A stiff beam drags the end whose gap is open: what is left of the skew is that end's friction by
/// the stiffness of the beam.
#[test]
fn a_stiff_beam_keeps_its_ends_together() {
    let (friction, _) = slide();
    let yielding = machine([10.0, 60.0]);
    let beside = run(&yielding, SLOW, &[], "none")
        .0
        .result
        .gantry
        .expect("a gantry")
        .skew_um
        .p50;
    assert!((beside - 25.0).abs() < 0.5, "{beside}");
    for times in [4.0, 12.0] {
        // So stiff that friction leaves this part of the skew.
        let stiff = with_beam(&yielding, times * friction / 25.0);
        let skew = run(&stiff, SLOW, &[], "none")
            .0
            .result
            .gantry
            .expect("a gantry")
            .skew_um
            .p50;
        assert!((skew * times / 25.0 - 1.0).abs() < 0.05, "{times}: {skew}");
    }
}

/// Slowly there and back, so that friction is nearly Coulomb's alone.
const SLOW: &str = "G21 G90 G17 G61\nG1 X0 Y-10 F600\nY10 F120\nY-10\nM2\n";

/// A force on the tool goes to the ends as a lever says, and each shaft gives way to its part.
#[test]
fn a_cutting_force_is_shared_by_the_lever() {
    let ((_, stiffness), force) = (slide(), 2000.0);
    let machine = machine([0.0, 0.0]);
    for x in [-150.0, 120.0] {
        let share = (x + ZERO - ENDS[0]) / (ENDS[1] - ENDS[0]);
        let program = format!("G21 G90 G17 G61\nG1 X{x} F6000\nY20 F300\nM2\n");
        let source = Program::from_bytes("part.ngc", program.as_bytes());
        let options = SimulateOptions {
            cutting_force_n: Some(force),
            ..SimulateOptions::default()
        };
        let mut points = Points {
            lines: Vec::new(),
            kept: Vec::new(),
        };
        let result = Simulation::new(&source, &machine)
            .method("none")
            .options(options.clone())
            .observer(&mut points)
            .run()
            .map(|run| run.into_single().unwrap())
            .expect("a result")
            .result;
        // Most of the time goes by on the move along Y.
        let expected = force * (1.0 - 2.0 * share) / stiffness;
        let gantry = result.gantry.expect("a gantry");
        assert!(
            (gantry.skew_um.p50 / expected.abs() - 1.0).abs() < 0.01,
            "{x}: {gantry:?} {expected}"
        );
        // The end nearer to the tool lags.
        assert!(
            gantry.peak_um * expected < 0.0,
            "{x}: {gantry:?} {expected}"
        );
    }
}

/// What a fit found of the second motor reaches it, and not the first.
#[test]
fn drives_have_names() {
    let machine = machine([10.0, 30.0]);
    assert_eq!(machine.drives(), ["x", "y", "z", "y2"]);
    let [first, second] = ["y", "y2"].map(|name| machine.drive(name).expect(name).clone());
    assert!(
        (second.gap_in_unit() - 0.03).abs() < 1e-12 && (first.gap_in_unit() - 0.01).abs() < 1e-12
    );
    let changed = machine.with_second_config(&second.with_gap(0.05));
    assert!((changed.drive("y2").expect("y2").gap_in_unit() - 0.05).abs() < 1e-12);
    assert_eq!(changed.drive("y"), machine.drive("y"));
    assert!(
        ["x2", "w", "yy", "2", ""]
            .iter()
            .all(|name| machine.drive(name).is_none())
    );
}

#[test]
fn what_makes_no_beam_is_refused() {
    let refused = |from: &str, to: &str| {
        Machine::from_toml("g.toml", &text().replacen(from, to, 1))
            .expect_err(to)
            .to_string()
    };
    assert!(refused("along = \"x\"", "along = \"y\"").contains("the beam's own axis"));
    assert!(refused("along = \"x\"", "along = \"w\"").contains("no linear axis `w`"));
    assert!(refused("second_at_mm = 98.0", "second_at_mm = -860.0").contains("1 mm apart"));
    assert!(refused("first_at_mm = -860.0\n", "").contains("missing"));
    let beam = "second_gap_um = 25.0\n[gantry.beam]\nstiffness_n_per_um = 1e7\n";
    assert!(refused("second_gap_um = 25.0\n", beam).contains("gantry.beam.stiffness_n_per_um"));
}

/// The second motor's load touches the far flank where the beam brakes, comes back, and rests between its
/// flanks for a second: met there, its gap was read four times as wide as it is, and the beam thrown.
#[test]
fn a_load_that_rests_between_its_flanks_is_not_thrown() {
    let square = "G1 X10\nY10\nX0\nY0\n".repeat(4);
    let text = format!("G21 G90 G61\nG0 Z5\nG0 X0 Y0\nG1 Z-1 F500\nF2000\n{square}G0 Z5\nM2\n");
    let program = Program::from_str("square.ngc", text);
    let machine = Machine::preset("gantry3").unwrap();
    let run = Simulation::new(&program, &machine)
        .methods(["none", "adaptive"])
        .run()
        .unwrap();
    let [none, adaptive] = [0, 1].map(|index: usize| run.results[index].cutting);
    assert!(adaptive.max < none.max && adaptive.rms < 0.5 * none.rms);
}

/// A second end that is described by its gap alone has tables of its own as soon as one of its values
/// is changed: those of the first as they are changed, too, whatever the order.
#[test]
fn a_value_of_the_second_end_alone_can_be_changed() {
    let change = |(key, value): (&str, &str)| Change {
        key: key.to_owned(),
        value: value.to_owned(),
        name: format!("--set {key}={value}"),
    };
    let changed = |changes: &[(&str, &str)]| {
        let changes: Vec<Change> = changes.iter().copied().map(change).collect();
        Machine::from_changed_toml("g.toml", text(), &changes)
    };
    let drag = ("gantry.second.motor.coulomb_nm", "0.3");
    let gap = ("gantry.second.load.slide.gap_um", "40.0");
    let both = ("axis.y.motor.viscous_nm_s_per_rad", "0.004");
    for changes in [[drag, gap, both], [both, gap, drag]] {
        let machine = changed(&changes).expect("a machine");
        let [first, second] = ["y", "y2"].map(|name| machine.drive(name).expect(name));
        assert_eq!(
            [first, second].map(|end| end.motor.viscous_nm_s_per_rad),
            [0.004; 2]
        );
        assert!(first.motor.coulomb_nm < 0.3 && second.motor.coulomb_nm == 0.3);
        assert!((first.gap_in_unit() - 0.01).abs() < 1e-12);
        assert!((second.gap_in_unit() - 0.04).abs() < 1e-12);
    }
    // What is told of its gap otherwise stays.
    let machine = changed(&[drag]).expect("a machine");
    assert!((machine.drive("y2").expect("y2").gap_in_unit() - 0.025).abs() < 1e-12);
    let refused = changed(&[("gantry.second.motor.coulomb", "0.3")]).expect_err("no such key");
    assert!(
        refused
            .to_string()
            .contains("--set gantry.second.motor.coulomb=0.3"),
        "{refused}"
    );
}
