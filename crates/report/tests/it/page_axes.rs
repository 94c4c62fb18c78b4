//! What a page says of each axis: rests, estimates of the gap, and the direction of the tool.

use crate::page::{All, bytes, data, html, run, unpacked, without_scripts};
use lostmotion_report::page::page;
use lostmotion_sim::{Machine, MotorPoint, Program, Simulation};

/// X stands at 10 and 20 mm after motion in both directions, Y and Z nowhere.
const RESTS: &str = "G21 G90 G61.1 F1500\nG1 X10\nG4 P0.4\nX20\nG4 P0.4\nX30\nG4 P0.4\nX20\n\
    G4 P0.4\nX10\nG4 P0.4\nX0\nM2\n";

fn of_x(motors: &[MotorPoint]) -> Vec<&MotorPoint> {
    let all = motors.iter();
    all.filter(|point| point.axis.letter() == 'X').collect()
}

/// The reversal value by the rows of the trace: rests by hand, from the times of the dwells.
#[test]
fn the_reversal_value_is_that_of_the_rests() {
    let (one, all, program) = run(RESTS, &["none"]);
    let x = of_x(&all.motors[0]);
    // Means over the second half of each rest of 0.4 s, with the place.
    let mut rests: Vec<(f64, f64)> = Vec::new();
    let mut from = 0;
    for at in 1..=x.len() {
        if at < x.len() && (x[at].reference - x[from].reference).abs() < 1e-9 {
            continue;
        }
        let span = &x[from..at];
        if span.len() as f64 * 250e-6 > 0.35 && from > 0 && at < x.len() {
            let half = &span[span.len() / 2..];
            let sum: f64 = half.iter().map(|point| point.load - point.reference).sum();
            rests.push((span[0].reference, sum / half.len() as f64));
        }
        from = at;
    }
    let places: Vec<f64> = rests.iter().map(|(place, _)| place.round()).collect();
    assert_eq!(places.len(), 5, "{rests:?}");
    let up_down = [rests[0].1 - rests[4].1, rests[1].1 - rests[3].1];
    let largest = up_down.iter().fold(0.0_f64, |most, b| most.max(b.abs()));
    // The gap of 40 um and what friction winds up.
    assert!((0.03..0.06).contains(&largest), "{up_down:?}");
    let page = without_scripts(&html(&one, &program, &all.page.finish(&one)));
    let (_, table) = page.split_once("<h2>Axes</h2>").unwrap();
    let cells: Vec<&str> = table
        .lines()
        .filter(|line| line.contains("<th scope=\"row\">"))
        .take(3)
        .map(|line| line.split("<td class=\"n\">").nth(6).unwrap())
        .collect();
    let (value, rest) = cells[0].split_once(' ').unwrap();
    let value: f64 = value.parse().unwrap();
    assert!((value - 1e3 * largest).abs() < 0.05, "{value} {largest}");
    assert!(rest.ends_with("(2 targets)"), "{rest}");
    assert_eq!(cells[1..], ["-", "-"]);
}

/// What the method knows at the end of a chunk holds for the parts that begin after it.
#[test]
fn the_estimate_of_the_gap_is_what_was_known() {
    let strokes = "G1 X25 F3000\nG4 P0.2\nX0\nG4 P0.2\n".repeat(25);
    let text = format!("G21 G90 G61.1\n{strokes}M2\n");
    let (both, all, program) = run(&text, &["none", "adaptive"]);
    let learning = all.learning.clone();
    let data = data(&html(&both, &program, &all.page.finish(&both)));
    let names: Vec<&str> = data["signals"]
        .as_array()
        .unwrap()
        .iter()
        .map(|name| name.as_str().unwrap())
        .collect();
    let at = names
        .iter()
        .position(|name| *name == "gap estimate")
        .unwrap();
    let motor = |method: usize| &data["methods"][method]["motors"][0];
    assert!(motor(0)["signals"].get(at).is_none());
    let (shown, half) = unpacked(&motor(1)["signals"][at]["high"]);
    let part_s = motor(1)["ticks"].as_f64().unwrap() * data["tick"].as_f64().unwrap();
    let machine = Machine::preset("vmc3-worn").unwrap();
    let per_rad = 1.0
        / machine
            .drive("x")
            .unwrap()
            .transmission
            .motor_rad_per_unit();
    let mut known = 0;
    for (part, shown) in shown.iter().enumerate() {
        let before = learning[1]
            .iter()
            .rfind(|(time, _)| *time <= part as f64 * part_s);
        let gap = before
            .and_then(|(_, learned)| *learned)
            .filter(|learned| learned.gap_readings > 0)
            .map_or(f64::NAN, |learned| 2.0 * learned.half_gap_rad * per_rad);
        assert!(
            (shown.is_nan() && gap.is_nan()) || (shown - gap).abs() <= 1.1 * half + 1e-9,
            "{part}: {shown} {gap}"
        );
        known += usize::from(gap > 0.0);
    }
    assert!(known > 0, "nothing was learned");
}

/// On a machine that turns the tool its direction is there, and nowhere else.
#[test]
fn the_tool_leans_where_its_machine_turns_it() {
    let (upright, all, program) = run(RESTS, &["none"]);
    let shown = data(&html(&upright, &program, &all.page.finish(&upright)));
    assert!(shown["path"]["tool"].is_null());
    let machine = Machine::preset("fork5").unwrap();
    let text = "G21 G90 F3000\nG0 X10 Y10 Z50\nG43.4 H0\nG1 X20 B30\nG1 X30 B30 C90\nM2\n";
    let program = Program::from_str("lean.ngc", text);
    let mut all = All::new(1);
    let turned = Simulation::new(&program, &machine)
        .observer(&mut all)
        .run()
        .unwrap();
    let points = all.points[0].clone();
    let shown = data(&page(&turned, &machine, &program, &all.page.finish(&turned)).unwrap());
    let tools = bytes(shown["path"]["tool"].as_str().unwrap());
    let last: Vec<f64> = tools[tools.len() - 3..]
        .iter()
        .map(|byte| f64::from(*byte as i8) / 127.0)
        .collect();
    let end = points.iter().rfind(|point| point.moving).unwrap();
    assert!(end.tool[2] < 0.9, "{:?}", end.tool);
    for (shown, tool) in last.iter().zip(end.tool) {
        assert!((shown - tool).abs() < 0.01, "{last:?} {:?}", end.tool);
    }
}

/// LinuxCNC's settings are in the units of its INI file: 40 um are 0.001575 inch.
#[test]
fn gaps_to_set_are_in_the_units_of_the_control() {
    use lostmotion_gcode::Units;
    use lostmotion_sim::control::Control;

    let (run, all, program) = run("G21 G90 F600\nG1 X2\nX0\nM2\n", &["fixed"]);
    let record = all.page.finish(&run);
    let preset = Machine::preset("vmc3-worn").unwrap();
    for (control, units, says) in [
        (Control::LinuxCnc, Units::Inch, "X 0.001575 inch, "),
        (Control::LinuxCnc, Units::Mm, "X 0.04 mm, "),
        (Control::Fanuc, Units::Inch, "X 0.04 mm, "),
    ] {
        let machine = preset.edit(|m| {
            m.simulate.control = Some(control);
            m.control_units = units;
        });
        let text = page(&run, &machine.unwrap(), &program, &record).unwrap();
        assert!(without_scripts(&text).contains(says), "{says}");
    }
}
