//! What is worth measuring first, against runs made by hand.
use lostmotion_sim::measure::{MeasureOptions, guesses, measurements};
use lostmotion_sim::{Machine, Program, SimulateOptions, Simulation};

const PART: &str = "G21 G90 G17 G64 P0.005\nG0 X9 Y0\nG3 I-9 F900\nM2\n";

#[test]
fn the_gap_comes_first_and_its_change_is_that_of_a_run_by_hand() {
    let part = Program::from_str("arc.ngc", PART);
    let toml = lostmotion_sim::presets()
        .iter()
        .find(|preset| preset.name == "vmc3-worn")
        .unwrap()
        .toml;
    let machine = Machine::from_toml("m.toml", toml).unwrap();
    let options = SimulateOptions::default();
    let wanted = MeasureOptions::default();
    let found = measurements(&machine, Some(&part), &guesses(toml), &options, &wanted).unwrap();
    assert_eq!(found.measure.len(), 5);
    // The part moves X and Y alone; each value is run up and down.
    assert_eq!((found.tried, found.runs), (18, 1 + 2 * 18));
    let first = &found.measure[0];
    assert_eq!(first.quantity, "gap");
    let error = |um: f64| {
        let letter = first.axis.to_ascii_lowercase();
        let head = format!("[axis.{letter}.load.slide]");
        let (before, rest) = toml.split_once(&head).unwrap();
        let rest = rest.replacen("gap_um = 40.0", &format!("gap_um = {um:?}"), 1);
        let machine = Machine::from_toml("m.toml", &format!("{before}{head}{rest}")).unwrap();
        Simulation::new(&part, &machine).run().unwrap().results[0]
            .cutting
            .max
    };
    let by_hand = [52.0, 28.0].map(|um| (error(um) - error(40.0)).abs());
    let most = by_hand[0].max(by_hand[1]);
    assert!(
        (first.change_um.unwrap() - most).abs() < 1e-6 * most,
        "{first:?} {by_hand:?}"
    );
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
    let again = measurements(&machine, Some(&part), &guesses(toml), &threads, &wanted).unwrap();
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
