//! Feed hold, override and stop in a program that is simulated.
use lostmotion_plan::{Action, Sample};
use lostmotion_sim::{Intervention, Machine, Program, SimulateOptions, Simulation};

const PART: &str =
    "G21 G90 G17 G64 P0.01\nG1 X20 F3000\nY20\nG4 P0.3\nG2 X40 Y20 I10 J0\nG1 X60\nM2\n";

fn options(actions: &[(f64, Action)]) -> SimulateOptions {
    let interventions = actions
        .iter()
        .map(|(at_s, action)| Intervention {
            at_s: *at_s,
            action: *action,
        })
        .collect();
    SimulateOptions {
        interventions,
        ..SimulateOptions::default()
    }
}

fn planned(actions: &[(f64, Action)]) -> Vec<Sample> {
    let (source, machine) = (
        Program::from_bytes("part.ngc", PART.as_bytes()),
        Machine::preset("bench3").expect("bench3"),
    );
    let mut samples = Vec::new();
    Simulation::new(&source, &machine)
        .options(options(actions))
        .plan(&mut |chunk, _| {
            samples.extend_from_slice(chunk);
            Ok(())
        })
        .expect("a plan");
    samples
}

/// Cycles at rest in a place.
fn resting(samples: &[Sample], line: u32) -> usize {
    samples
        .windows(2)
        .filter(|pair| pair[1].block.span.line == line && pair[0].position == pair[1].position)
        .count()
}

#[test]
fn a_hold_lasts_from_its_stop_to_the_resume_and_changes_nothing_else() {
    let alone = planned(&[]);
    let held = planned(&[(0.2, Action::Hold), (1.2, Action::Resume)]);
    assert_eq!(held[..=200], alone[..=200]);
    assert_eq!(
        held.last().expect("samples").position,
        alone.last().expect("samples").position
    );
    // 50 mm/s, 1000 mm/s2, 30,000 mm/s3: a stop takes v/a + a/j = 83.3 ms.
    let at_rest = held
        .windows(2)
        .filter(|pair| {
            pair[0].position == pair[1].position && pair[0].tick > 200 && pair[0].tick < 1200
        })
        .count();
    assert!((916 - 3..=917).contains(&at_rest), "{at_rest}");
    // Speeding up and slowing down on a straight line lose the distance of one stop each: together
    // v/a + a/j.
    let lost = held.len() - alone.len();
    assert!((999..=1003).contains(&lost), "{lost}");
}

#[test]
fn a_dwell_keeps_its_length_whatever_the_override_and_waits_while_held() {
    let (alone, slow) = (planned(&[]), planned(&[(0.0, Action::Override(0.4))]));
    let dwell = resting(&alone, 3);
    assert!((298..=302).contains(&dwell), "{dwell}");
    assert!(
        resting(&slow, 3).abs_diff(dwell) <= 2,
        "{}",
        resting(&slow, 3)
    );
    let begin = alone
        .iter()
        .position(|s| s.block.span.line == 3 && s.velocity.linear_norm() == 0.0)
        .expect("the dwell") as f64
        * 1e-3;
    let held = planned(&[(begin + 0.1, Action::Hold), (begin + 1.1, Action::Resume)]);
    assert!(
        resting(&held, 3).abs_diff(dwell + 1000) <= 12,
        "{}",
        resting(&held, 3)
    );
}

#[test]
fn a_stop_ends_at_rest_and_a_hold_for_good_too() {
    for action in [Action::Stop, Action::Hold] {
        let samples = planned(&[(1.0, action)]);
        let last = samples.last().expect("samples");
        assert_eq!(
            (last.velocity.linear_norm(), last.acceleration.linear_norm()),
            (0.0, 0.0)
        );
        assert!((1000..1400).contains(&samples.len()), "{}", samples.len());
    }
}

#[test]
fn a_hold_shows_in_the_contour_error_and_chunks_make_no_difference() {
    let (source, machine) = (
        Program::from_bytes("part.ngc", PART.as_bytes()),
        Machine::preset("vmc3").expect("vmc3"),
    );
    let run = |options: &SimulateOptions| {
        Simulation::new(&source, &machine)
            .method("none")
            .options(options.clone())
            .run()
            .map(|run| run.into_single().unwrap())
            .expect("a simulation")
    };
    let held = options(&[
        (0.9, Action::Hold),
        (1.5, Action::Resume),
        (2.0, Action::Override(0.5)),
    ]);
    let whole = run(&held);
    assert_eq!(
        run(&SimulateOptions {
            chunk_samples: 37,
            ..held
        }),
        whole
    );
    assert!(whole.plan.duration_s > run(&options(&[])).plan.duration_s + 0.5);
    // The command stays where it was: within the tolerance of its corners.
    assert!(
        whole.plan.command.max <= 10.0 + 1e-3,
        "{}",
        whole.plan.command.max
    );
}

/// Steady speeds on the blocks of a program that locks some of its feeds.
#[test]
fn who_heeds_an_override() {
    let part = "G21 G90 G17 G61\nS600 M3\nG0 X20\nG1 X40 F1200\nM49\nG1 X60\nM48\nG1 X80\nM50 P0\nG1 X100\nM50 P1\nG33 X120 K2\nG95 G1 X140 F1.5\nM2\n";
    let (source, machine) = (
        Program::from_bytes("part.ngc", part.as_bytes()),
        Machine::preset("bench3").expect("bench3"),
    );
    let mut samples: Vec<Sample> = Vec::new();
    Simulation::new(&source, &machine)
        .options(options(&[
            (0.0, Action::Override(1.5)),
            (0.0, Action::Rapid(0.5)),
        ]))
        .plan(&mut |chunk, _| {
            samples.extend_from_slice(chunk);
            Ok(())
        })
        .expect("a plan");
    let rapid = machine.axes()[0].limits.velocity;
    // 20 mm/s are programmed, also by the lead of 2 mm at 600/min; 15 mm/s as feed per revolution.
    for (line, speed) in [
        (3, 0.5 * rapid),
        (4, 30.0),
        (6, 20.0),
        (8, 30.0),
        (10, 20.0),
        (12, 20.0),
        (13, 22.5),
    ] {
        let fastest = samples
            .iter()
            .filter(|sample| sample.block.span.line == line)
            .map(|sample| sample.path_speed)
            .fold(0.0, f64::max);
        assert!(
            (fastest / speed - 1.0).abs() < 0.01,
            "line {line}: {fastest} of {speed}"
        );
    }
}

#[test]
fn nonsense_is_refused() {
    let (source, machine) = (
        Program::from_bytes("part.ngc", PART.as_bytes()),
        Machine::preset("bench3").expect("bench3"),
    );
    for actions in [
        vec![(-1.0, Action::Hold)],
        vec![(2.0, Action::Hold), (1.0, Action::Resume)],
        vec![(0.0, Action::Override(f64::NAN))],
    ] {
        assert!(
            Simulation::new(&source, &machine)
                .options(options(&actions))
                .plan(&mut |_, _| Ok(()))
                .is_err()
        );
    }
}

#[test]
fn what_comes_after_the_end_is_told() {
    let (program, machine) = (
        Program::from_bytes("part.ngc", PART.as_bytes()),
        Machine::preset("bench3").expect("bench3"),
    );
    let planned = |actions: &[(f64, Action)]| {
        Simulation::new(&program, &machine)
            .options(options(actions))
            .plan(&mut |_, _| Ok(()))
            .expect("a plan")
    };
    let ends = planned(&[(0.2, Action::Hold), (0.4, Action::Resume)]);
    assert_eq!(ends.late, None);
    let late = planned(&[
        (0.2, Action::Override(1.0)),
        (80.0, Action::Hold),
        (81.0, Action::Resume),
    ]);
    let told = late.late_warning().expect("a warning");
    assert!(
        told.starts_with(
            "2 interventions, the first at 80 s, come after the end of the motion at "
        ),
        "{told}"
    );
    // A stop for good leaves the rest undone.
    let stopped = planned(&[(0.2, Action::Stop), (0.9, Action::Resume)]);
    let told = stopped.late_warning().expect("a warning");
    assert!(
        told.starts_with("the intervention at 0.9 s comes"),
        "{told}"
    );
    let run = Simulation::new(&program, &machine)
        .options(options(&[(80.0, Action::Hold)]))
        .run()
        .expect("a run");
    assert!(
        run.program
            .warnings
            .iter()
            .any(|told| told.contains("80 s"))
    );
}
