//! Machine files: what is read, what is refused, and with which words.

use lostmotion_base::AxisId;
use lostmotion_base::units::rad;
use lostmotion_sim::machine::{
    Change, Machine, MachineError, axis_from_toml, axis_preset, presets,
};
use proptest::prelude::*;

fn vmc3() -> &'static str {
    presets()[0].toml
}

/// Reads vmc3 with one text replaced by another, which has to fail.
fn broken(from: &str, to: &str) -> MachineError {
    assert!(vmc3().contains(from), "{from} is not in the preset");
    Machine::from_toml("m.toml", &vmc3().replacen(from, to, 1)).expect_err(to)
}

/// One problem, at the line on which `at` first stands.
#[track_caller]
fn check(from: &str, to: &str, at: &str, key: &str, says: &str) {
    let error = broken(from, to);
    let text = vmc3().replacen(from, to, 1);
    let line = text.lines().position(|line| line.contains(at)).expect(at) + 1;
    assert_eq!(error.problems.len(), 1, "{error}");
    let problem = &error.problems[0];
    assert_eq!(
        (problem.line as usize, problem.key.as_str()),
        (line, key),
        "{error}"
    );
    let column = text
        .lines()
        .nth(line - 1)
        .and_then(|text| text.find(at))
        .expect(at)
        + 1;
    assert_eq!(problem.column as usize, column, "{error}");
    assert!(error.to_string().contains(says), "{error}");
}

#[test]
fn every_preset_reads_and_writes_back_equal() {
    for info in presets() {
        let machine =
            Machine::from_toml(info.name, info.toml).unwrap_or_else(|error| panic!("{error}"));
        assert_eq!(machine.name(), info.name);
        assert_eq!(Machine::preset(info.name).as_ref(), Ok(&machine));
        let again = machine.to_toml().expect("writes");
        let read =
            Machine::from_toml("again", &again).unwrap_or_else(|error| panic!("{error}\n{again}"));
        assert_eq!(read, machine);
        assert_eq!(machine.axes().len(), machine.axis_set().len());
    }
    assert!(Machine::preset("vmc").is_err());
}

#[test]
fn limits_are_in_mm_and_rad() {
    let machine = Machine::preset("trunnion5").expect("trunnion5");
    let a = machine.axis(AxisId::A).expect("A");
    assert_eq!(a.limits.max.to_bits(), rad(120.0).to_bits());
    assert_eq!(a.limits.velocity.to_bits(), rad(90.0).to_bits());
    assert!((a.axis_units_per_joint_unit() * a.limits.max - 120.0).abs() < 1e-12);
    let x = machine.axis(AxisId::X).expect("X");
    assert_eq!(
        (x.limits.min, x.limits.jerk, x.axis_units_per_joint_unit()),
        (-381.0, 50_000.0, 1.0)
    );
    assert!(machine.axis(AxisId::B).is_none());
}

#[test]
fn without_gap_leaves_all_else() {
    let machine = Machine::preset("trunnion5").expect("trunnion5");
    let rigid = machine.without_gap();
    for (with, without) in machine.axes().iter().zip(rigid.axes()) {
        assert!(with.config.gap_in_unit() > 0.0);
        assert_eq!(without.config.gap_in_unit().to_bits(), 0);
        assert_eq!(
            without.config.with_gap(with.config.gap_in_unit()).drive,
            with.config.drive
        );
        assert_eq!(with.limits, without.limits);
    }
}

#[test]
fn unknown_keys_are_refused_with_a_hint() {
    check(
        "mass_kg = 300.0",
        "mass_lb = 350.0\nmass_kg = 300.0",
        "mass_lb",
        "axis.x.load.slide.mass_lb",
        "did you mean `mass_kg`?",
    );
    check(
        "jerk_mm_s3",
        "color = 1\njerk_mm_s3",
        "color",
        "axis.x.limits.color",
        "known here: min_mm, max_mm",
    );
    check(
        "[planner]",
        "[planer]\n[planner]",
        "planer",
        "planer",
        "did you mean `planner`?",
    );
    check(
        "[axis.x.limits]",
        "[axis.x.gears]\n[axis.x.limits]",
        "gears",
        "axis.x.gears",
        "limits",
    );
    check(
        "[axis.x.limits]",
        "[axis.q.limits]\n[axis.x.limits]",
        "q.limits",
        "axis.q",
        "no axis has this name",
    );
    check("g30]", "g3O]", "g3O", "home.g3O", "did you mean `g30`?");
}

#[test]
fn values_out_of_range_are_named_with_what_is_allowed() {
    check(
        "jerk_mm_s3 = 50000.0",
        "jerk_mm_s3 = 0.0",
        "jerk_mm_s3",
        "axis.x.limits.jerk_mm_s3",
        "is 0; it has to be from 0.1 to 1e9",
    );
    check(
        "velocity_mm_s = 500.0",
        "velocity_mm_s = -5",
        "velocity_mm_s",
        "axis.x.limits.velocity_mm_s",
        "is -5",
    );
    check(
        "acceleration_mm_s2 = 4000.0",
        "acceleration_mm_s2 = nan",
        "acceleration_mm_s2",
        "axis.x.limits.acceleration_mm_s2",
        "is nan",
    );
    check(
        "mass_kg = 300.0",
        "mass_kg = inf",
        "mass_kg",
        "axis.x.load.slide.mass_kg",
        "is inf",
    );
    check(
        "max_mm = 0.0",
        "max_mm = -800.0",
        "max_mm",
        "axis.x.limits.max_mm",
        "the travel begins at -762 mm",
    );
    check(
        "gap_um = 10.0",
        "gap_um = -10.0",
        "gap_um",
        "axis.x.load.slide.gap_um",
        "is -10",
    );
    check(
        "poles = 10",
        "poles = 9",
        "poles = 9",
        "axis.x.motor.poles",
        "an even number",
    );
    check(
        "tolerance_um = 20.0",
        "tolerance_um = 0",
        "tolerance_um",
        "simulate.tolerance_um",
        "is 0",
    );
    check(
        "voltage_delay_periods = 1",
        "current_period_us = 60",
        "current_period_us",
        "axis.x.drive.current_period_us",
        "whole fraction",
    );
}

/// 300 digits would fill the screen: of a text, or of a number as serde writes it.
#[test]
fn long_values_are_shortened_in_messages() {
    let nines = "9".repeat(300);
    for (value, found) in [
        (format!("\"{nines}\""), "(300 digits)"),
        ("1e300".to_owned(), "(301 digits)"),
        (nines, "larger than a file can hold"),
    ] {
        let error = broken("poles = 10", &format!("poles = {value}")).to_string();
        assert!(error.contains("axis.x.motor.poles"), "{error}");
        // Place, key and what is expected take the rest of the line.
        let longest = error.lines().map(str::len).max().unwrap();
        assert!(longest < 200, "{error}");
        // What is cut is cut once, and its length is its own.
        assert!(error.contains(found) && !error.contains("...."), "{error}");
    }
}

#[test]
fn wrong_types_and_missing_values_are_named() {
    check(
        "lead_mm = 16.0",
        "lead_mm = \"16\"",
        "\"16\"",
        "axis.x.transmission.linear.lead_mm",
        "found string \"16\", expected a number",
    );
    check(
        "poles = 10",
        "poles = -10",
        "-10",
        "axis.x.motor.poles",
        "expected a whole number",
    );
    check(
        "poles = 10\n",
        "",
        "[axis.x.motor]",
        "axis.x.motor.poles",
        "missing",
    );
    let error = broken("kind = \"cartesian\"", "kind = \"cartesain\"");
    assert!(
        error.to_string().contains("did you mean `cartesian`?"),
        "{error}"
    );
    let method = "[axis.x.compensation]\nmethod = \"publishd\"\n\n[axis.x.drive]";
    check(
        "[axis.x.drive]",
        method,
        "\"publishd\"",
        "axis.x.compensation.method",
        "did you mean `published`?",
    );
}

#[test]
fn keys_of_another_kinematics_say_whose_they_are() {
    check(
        "kind = \"cartesian\"",
        "kind = \"cartesian\"\nrod_mm = 320.0",
        "rod_mm",
        "kinematics.rod_mm",
        "is a key of kind delta, not of cartesian\n  hint: cartesian has no keys besides `kind`",
    );
    check(
        "kind = \"cartesian\"",
        "kind = \"delta\"\nrod_mm = 320.0\ntower_radius_mm = 150.0\noffset_x_mm = 1.0",
        "offset_x_mm",
        "kinematics.offset_x_mm",
        "is a key of kind trunnion-bc, not of delta\n  hint: delta takes tower_radius_mm, rod_mm",
    );
    check(
        "kind = \"cartesian\"",
        "kind = \"delta\"\nrod_mm = 320.0\ntower_radius = 150.0",
        "tower_radius",
        "kinematics.tower_radius",
        "did you mean `tower_radius_mm`?",
    );
    check(
        "kind = \"cartesian\"",
        "kind = \"scara\"\nupper_arm_mm = 300.0",
        "[kinematics]",
        "kinematics.forearm_mm",
        "add `forearm_mm` here",
    );
}

#[test]
fn parts_that_do_not_go_together_are_refused() {
    check(
        "kind = \"cartesian\"",
        "kind = \"trunnion-ac\"\nrotation_point_mm = [0.0, 0.0, 0.0]",
        "kind",
        "kinematics.kind",
        "needs an axis",
    );
    check(
        "y_mm = -203.0",
        "a_deg = 10.0\ny_mm = -203.0",
        "a_deg",
        "work_offset.g54.a_deg",
        "no axis A",
    );
    let rotary = "[axis.x.transmission.rotary]\ngear = 16.0";
    let error = broken("[axis.x.transmission.linear]\nlead_mm = 16.0", rotary).to_string();
    assert!(
        error.contains("axis.x.load.slide: does not fit: a slide needs a linear transmission"),
        "{error}"
    );
    assert!(
        error.contains("axis.x.transmission: is rotary, but axis X moves in mm"),
        "{error}"
    );
    check(
        "[home.g30]",
        "[home.g30]\nz_mm = 5.0",
        "z_mm = 5",
        "home.g30.z_mm",
        "outside its travel from -508 to 0",
    );
}

#[test]
fn all_problems_come_at_once_in_the_order_of_the_text() {
    let text = vmc3()
        .replacen("name = ", "nam = ", 1)
        .replacen("min_mm", "min_um", 1)
        .replacen("lead_mm = 16.0", "lead_mm = true", 1)
        .replacen("poles = 10", "poles = 10\ncolor = 1\nweight = 2", 1)
        .replacen("[axis.y.limits]", "[axis.y.limit]", 1)
        .replacen("stiffness_n_per_um", "stiffness_n_per_mm", 1);
    let error = Machine::from_toml("m.toml", &text).expect_err("six mistakes");
    let keys: Vec<&str> = error
        .problems
        .iter()
        .map(|problem| problem.key.as_str())
        .collect();
    for key in [
        "nam",
        "axis.x.limits.min_um",
        "axis.x.transmission.linear.lead_mm",
        "axis.x.motor.color",
        "axis.x.motor.weight",
        "axis.x.load.slide.stiffness_n_per_mm",
        "axis.y.limit",
    ] {
        assert!(keys.contains(&key), "{key} is missing in\n{error}");
    }
    assert_eq!(keys.len(), 7, "{error}");
    assert!(
        error
            .problems
            .is_sorted_by_key(|problem| (problem.line, problem.column))
    );
}

#[test]
fn syntax_errors_have_a_place() {
    let error = broken("poles = 10", "poles = = 10");
    let first = &error.problems[0];
    assert_eq!(
        vmc3().lines().nth(first.line as usize - 1),
        Some("poles = 10")
    );
    assert!(
        Machine::from_toml("empty.toml", "")
            .expect_err("empty")
            .to_string()
            .starts_with("empty.toml:1:1: name: missing")
    );
    assert!(Machine::from_toml("b", "\u{0}\u{1}\u{7f}").is_err());
}

#[test]
fn an_axis_alone_is_read_with_the_same_care() {
    let axis: String = vmc3()
        .lines()
        .skip_while(|line| !line.contains("[axis.x.transmission"))
        .take_while(|line| !line.contains("---- Y"))
        .fold(String::new(), |text, line| text + line + "\n");
    let axis = axis.replace("[axis.x.", "[");
    let read = axis_from_toml("x.toml", &axis).unwrap_or_else(|error| panic!("{error}"));
    assert_eq!(Some(&read), axis_preset("vmc3:x").as_ref());
    let bad = axis
        .replace("gap_um = 10.0", "gap_um = nan")
        .replace("mass_kg", "mass");
    let error = axis_from_toml("x.toml", &bad).expect_err("bad").to_string();
    assert!(
        error.contains("x.toml:32:1: load.slide.gap_um: is nan")
            && error.contains("did you mean `mass_kg`?"),
        "{error}"
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 64, ..ProptestConfig::default() })]

    /// Whatever is done to a good file, it is read or refused with a place, never worse; and what
    /// is read can be written.
    #[test]
    fn damage_is_read_or_refused(at in 0usize..8000, cut in 0usize..40, put in "[a-z0-9=.\\[\\]\" \n_-]{0,12}") {
        let text = vmc3();
        let floor = |i: usize| (0..=i.min(text.len())).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0);
        let damaged = format!("{}{put}{}", &text[..floor(at)], &text[floor(at + cut)..]);
        match Machine::from_toml("m", &damaged) {
            Ok(machine) => prop_assert!(machine.to_toml().is_ok()),
            Err(error) => {
                prop_assert!(!error.problems.is_empty());
                prop_assert!(error.problems.iter().all(|problem| problem.line > 0 && problem.column > 0));
            }
        }
    }
}

/// Whatever is much longer than a machine file is refused at once, instead of being searched for
/// what is wrong.
#[test]
fn what_is_too_long_is_no_machine_file() {
    let text: String = (0..60_000).map(|k| format!("key_{k} = {k}\n")).collect();
    let told = Machine::from_toml("long.toml", &text)
        .unwrap_err()
        .to_string();
    assert!(
        told.contains("long.toml:1:1: has ")
            && told.contains("at most 262144")
            && told.contains("hint: is it a machine file?"),
        "{told}"
    );
}

/// Changes are read as if they stood in the file, and their problems carry their names.
#[test]
fn changes_are_checked_like_the_file() {
    let text = presets()[0].toml;
    let change = |key: &str, value: &str| Change {
        key: key.to_owned(),
        value: value.to_owned(),
        name: format!("--set {key}={value}"),
    };
    let good = [
        change("axis.x.drive.position_gain_per_s", "30"),
        change("work_offset.g57", "{ x_mm = -1.0, y_mm = -2.0 }"),
        change("home.g28.z_mm", "-5"),
        change("name", "my mill"),
        change("tool", "[{ number = 1, length_mm = 50.0 }]"),
        change("tool[0].length_mm", "60.5"),
    ];
    let machine = Machine::from_changed_toml("vmc3", text, &good).expect("reads");
    assert_eq!(machine.axes()[0].config.drive.position_gain_per_s, 30.0);
    assert_eq!(machine.work_offsets()[3].0[..2], [-1.0, -2.0]);
    assert_eq!(machine.home_g28().0[2], -5.0);
    assert_eq!(machine.name(), "my mill");
    assert_eq!(machine.tools()[0].length_mm, 60.5);
    for (key, value, told) in [
        (
            "axis.x.drive.position_gian_per_s",
            "30",
            "did you mean `position_gain_per_s`?",
        ),
        (
            "axis.x.drive.position_gain_per_s",
            "fast",
            "found string \"fast\", expected a number",
        ),
        (
            "axis.x.drive.position_gain_per_s",
            "-1",
            "is -1; it has to be",
        ),
        (
            "axis.x.drive.position_gain_per_s",
            "1,2",
            "`1,2` is not a value",
        ),
        (
            "axis.x.drive.position_gain_per_s",
            "inf",
            "has to be a finite number",
        ),
        ("axis.x.drive.", "1", "is not a key"),
        ("name.x", "1", "`name` is not a table"),
        ("tool[3].length_mm", "1", "there is no `tool[3]`"),
        ("axix.x.load", "1", "did you mean `axis`?"),
        ("", "1", "is not a key"),
    ] {
        let error = Machine::from_changed_toml("vmc3", text, &[change(key, value)]).expect_err(key);
        let said = error.to_string();
        assert!(
            said.starts_with(&format!("--set {key}={value}: ")) && said.contains(told),
            "{said}"
        );
        assert_eq!(error.problems.len(), 1, "{said}");
    }
}
