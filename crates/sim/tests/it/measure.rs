//! What is worth measuring first, against runs made by hand.
use lostmotion_sim::measure::{MeasureOptions, guesses, measurements};
use lostmotion_sim::{Machine, Program, SimulateOptions, Simulation};

const PART: &str = "G21 G90 G17 G64 P0.005\nG0 X9 Y0\nG3 I-9 F900\nM2\n";

#[test]
fn five_come_first_and_a_change_is_that_of_a_run_by_hand() {
    let part = Program::from_str("arc.ngc", PART);
    let toml = lostmotion_sim::presets()
        .iter()
        .find(|preset| preset.name == "vmc3-worn")
        .unwrap()
        .toml;
    let machine = Machine::from_toml("m.toml", toml).unwrap();
    let options = SimulateOptions::default();
    let wanted = MeasureOptions::default();
    // Nothing in a file that comes with the program is called a guess but this.
    let mut guessed = guesses(toml);
    assert!(guessed.is_empty());
    guessed.insert("axis.y.load.slide.gap_um".to_owned());
    let found = measurements(&machine, Some(&part), &guessed, &options, &wanted).unwrap();
    assert_eq!(found.measure.len(), 5);
    // Each value of an axis that moves is run up and down; Z stands still.
    assert_eq!((found.tried, found.runs), (12, 1 + 2 * 12));
    assert!(found.measure.iter().all(|it| it.axis != 'Z'));
    let error = |axis: char, keys: [&str; 2], factor: f64| {
        let head = format!("[axis.{}.load.slide]", axis.to_ascii_lowercase());
        let mut inside = false;
        let lines = toml.lines().map(|line| {
            if line.starts_with('[') {
                inside = line == head;
            }
            match line.split_once(" = ") {
                Some((key, value)) if inside && keys.contains(&key) => {
                    format!("{key} = {:?}", value.parse::<f64>().unwrap() * factor)
                }
                _ => line.to_owned(),
            }
        });
        let text = lines.collect::<Vec<_>>().join("\n");
        let machine = Machine::from_toml("m.toml", &text).unwrap();
        Simulation::new(&part, &machine).run().unwrap().results[0]
            .cutting
            .max
    };
    for (quantity, axis, keys, factors) in [
        ("gap", 'Y', ["gap_um", ""], [2.0, 0.5]),
        (
            "friction",
            'Y',
            ["coulomb_n", "viscous_n_s_per_m"],
            [1.3, 0.7],
        ),
    ] {
        let mut all = found.measure.iter();
        let it = all
            .find(|it| it.quantity == quantity && it.axis == axis)
            .unwrap();
        assert_eq!((it.guess, [it.up, it.down]), (quantity == "gap", factors));
        let as_described = error(axis, keys, 1.0);
        let by_hand = factors.map(|factor| (error(axis, keys, factor) - as_described).abs());
        let most = by_hand[0].max(by_hand[1]);
        assert!(
            (it.change_um.unwrap() - most).abs() < 1e-6 * most,
            "{it:?} {by_hand:?}"
        );
    }
    assert!(
        found
            .measure
            .windows(2)
            .all(|two| two[0].change_um >= two[1].change_um)
    );
    assert!(found.measure.iter().map(|it| it.share).sum::<f64>() <= 1.0 + 1e-12);
    // The same bits again, on more threads.
    let threads = SimulateOptions {
        threads: 2,
        ..SimulateOptions::default()
    };
    let again = measurements(&machine, Some(&part), &guessed, &threads, &wanted).unwrap();
    assert_eq!(found, again);
}

#[test]
fn guesses_count_with_a_factor_and_bounds_are_kept() {
    let text = "[axis.x.limits]\njerk_mm_s3 = 1.0 # guess: none\n# ---- X ----\n# drive: preset vmc3:x\n[axis.x.load.slide]\nmass_kg = 3.0\ngap_um = 4.0 # [JOINT_0] BACKLASH\n# ---- Y ----\n[axis.y.load.slide]\nmass_kg = 1.0\n";
    let found: Vec<String> = guesses(text).into_iter().collect();
    assert_eq!(
        found,
        ["axis.x.limits.jerk_mm_s3", "axis.x.load.slide.mass_kg"]
    );
    let part = Program::from_str("arc.ngc", PART);
    let machine = Machine::preset("vmc3").unwrap();
    let options = SimulateOptions::default();
    let guessed = [String::from("axis.x.load.slide.gap_um")].into();
    let wanted = MeasureOptions::default();
    let found = measurements(&machine, Some(&part), &guessed, &options, &wanted).unwrap();
    let x = found
        .measure
        .iter()
        .find(|it| it.axis == 'X' && it.quantity == "gap")
        .unwrap();
    assert!(x.guess && (x.up, x.down) == (2.0, 0.5));
    let short = MeasureOptions {
        max_motion_s: 5.0,
        ..wanted
    };
    let error = measurements(&machine, Some(&part), &guessed, &options, &short).unwrap_err();
    assert!(
        error.to_string().contains("are more than 5 s of motion"),
        "{error}"
    );
}
