//! The whole chain against closed forms and invariants.

use crate::common::{machine, part, program, run};
use lostmotion::base::AxisId;
use lostmotion::drive::config::Load;
use lostmotion::methods::AxisConfig;
use lostmotion::sim::{Machine, SimulateOptions, Simulation};

/// A machine whose axes are as rigid and frictionless as the model goes: what is left is the servo
/// alone.
fn ideal(velocity_feedforward: f64, acceleration_feedforward: f64) -> Machine {
    machine("bench3")
        .without_gap()
        .map_axes(|config: &AxisConfig| {
            let mut axis = config.clone();
            axis.motor.coulomb_nm = 0.0;
            axis.motor.viscous_nm_s_per_rad = 0.0;
            if let Load::Slide(slide) = &mut axis.load {
                slide.viscous_n_s_per_m = 0.0;
                slide.coulomb_n = 0.0;
            }
            axis.drive.velocity_feedforward = velocity_feedforward;
            axis.drive.acceleration_feedforward = acceleration_feedforward;
            axis.drive.encoder_counts_per_rev = None;
            axis
        })
}

/// Three turns, so that starting and stopping are a small part; the middle of the distribution is
/// the steady circle.
fn circle(radius: f64, feed: f64) -> String {
    format!("G21 G90 G17 G64 P0.001\nG0 X{radius} Y0\nG4 P0.5\nG3 I-{radius} J0 P3 F{feed}\nM2\n")
}

#[test]
fn a_p_loop_without_feed_forward_shrinks_circles_as_the_closed_form_says() {
    let machine = ideal(0.0, 0.0);
    let gain = machine
        .axis(AxisId::X)
        .map(|axis| axis.config.drive.position_gain_per_s)
        .unwrap();
    for (radius, feed) in [(25.0, 1500.0), (10.0, 1000.0)] {
        let comparison = run(&program(&circle(radius, feed)), &machine, &["none"]).unwrap();
        // dR = -F^2 / (2 R Kv^2) to first order: the amplitude of a first-order lag at the circle's
        // frequency.
        let speed = feed / 60.0;
        let expected_um = 1e3 * speed * speed / (2.0 * radius * gain * gain);
        let measured_um = comparison.results[0].cutting.p50;
        let ratio = measured_um / expected_um;
        assert!(
            (ratio - 1.0).abs() < 0.05,
            "R{radius} F{feed}: {measured_um} um against {expected_um} um"
        );
    }
}

#[test]
fn full_feed_forward_without_a_gap_tracks_an_arc_to_under_a_micrometre() {
    let comparison = run(&program(&circle(25.0, 3000.0)), &ideal(1.0, 1.0), &["none"]).unwrap();
    let cutting = comparison.results[0].cutting;
    assert!(cutting.max < 1.0, "{cutting:?}");
}

#[test]
fn without_a_gap_there_is_no_backlash_whatever_the_method() {
    let machine = machine("vmc3").without_gap();
    let comparison = run(&program(&circle(10.0, 2000.0)), &machine, &["none"]).unwrap();
    assert_eq!(
        comparison.results[0].backlash.max.to_bits(),
        0.0_f64.to_bits()
    );
    assert_eq!(comparison.results[0].cutting, comparison.without_gap);
}

#[test]
fn the_parts_of_every_error_sum_to_it() {
    let comparison = run(&program(&circle(25.0, 3000.0)), &machine("vmc3"), &["none"]).unwrap();
    for block in &comparison.results[0].worst_blocks {
        let sum = block.parts_um.command + block.parts_um.servo + block.parts_um.backlash;
        assert!((sum - block.max_um).abs() < 1e-6, "{block:?}");
    }
}

#[test]
fn a_wider_gap_is_worse() {
    let rms = |gap_um: f64| {
        let machine = machine("vmc3").map_axes(|config| config.with_gap(gap_um * 1e-3));
        run(&program(&circle(25.0, 2000.0)), &machine, &["none"])
            .unwrap()
            .results[0]
            .backlash
            .rms
    };
    let [narrow, middle, wide] = [5.0, 20.0, 80.0].map(rms);
    assert!(narrow < middle && middle < wide, "{narrow} {middle} {wide}");
}

#[test]
fn a_curve_of_short_lines_is_not_driven_stop_and_go() {
    // 360 chords of one to two millimetres, three to ten degrees between them, at 40 mm/s.
    let comparison = run(&part("lissajous.ngc"), &machine("vmc3"), &["none"]).unwrap();
    let at_the_feed_s = comparison.plan.cutting_mm / 40.0;
    assert!(
        comparison.plan.duration_s < 1.15 * at_the_feed_s,
        "{} s against {at_the_feed_s} s",
        comparison.plan.duration_s
    );
}

/// The motor holds its place, so the load gives by what the shaft winds up: force over stiffness.
#[test]
fn a_cutting_force_pushes_the_load_back_by_force_over_stiffness() {
    let machine = machine("vmc3");
    let lag = |way: &str, cutting_force_n: f64| {
        let source = program(&format!(
            "G21 G90 G94 G64 P0.001\nG0 X0 Y0 Z10\nG1 {way} F600\nM2\n"
        ));
        let options = SimulateOptions {
            cutting_force_n: Some(cutting_force_n),
            ..SimulateOptions::default()
        };
        let result = Simulation::new(&source, &machine)
            .method("none")
            .options(options.clone())
            .run()
            .map(|run| run.into_single().unwrap())
            .unwrap();
        result.result.axes[0].following.p50
    };
    let stiffness = |index: usize| match &machine.axes()[index].config.load {
        Load::Slide(slide) => slide.stiffness_n_per_um,
        other => panic!("{other:?}"),
    };
    for (way, share) in [
        ("X60", 1.0),
        ("X60 Y60", std::f64::consts::FRAC_1_SQRT_2),
        ("Y60", 0.0),
    ] {
        let added = lag(way, 500.0) - lag(way, 0.0);
        let expected = share * 500.0 / stiffness(0);
        assert!(
            (added - expected).abs() < 0.03,
            "{way}: {added} um against {expected} um"
        );
    }
}

#[test]
fn no_force_is_no_force_and_a_senseless_one_is_refused() {
    let source = program("G21 G90 G94\nG0 X0 Y0 Z10\nG1 X20 F600\nM2\n");
    let with = |machine: &Machine, cutting_force_n| {
        let options = SimulateOptions {
            cutting_force_n,
            ..SimulateOptions::default()
        };
        Simulation::new(&source, machine)
            .method("none")
            .options(options.clone())
            .run()
            .map(|run| run.into_single().unwrap())
    };
    let machine = machine("vmc3");
    assert_eq!(
        with(&machine, Some(0.0)).unwrap(),
        with(&machine, None).unwrap()
    );
    for force in [-1.0, f64::NAN, 1e7] {
        assert!(
            with(&machine, Some(force))
                .unwrap_err()
                .to_string()
                .contains("cutting_force_n is"),
            "{force}"
        );
    }
    let text = format!("{}\n", machine.to_toml().unwrap()).replace(
        "tolerance_um = 20.0",
        "tolerance_um = 20.0\ncutting_force_n = 300.0",
    );
    let pushed = Machine::from_toml("pushed.toml", &text).unwrap();
    assert_eq!(
        with(&pushed, None).unwrap(),
        with(&machine, Some(300.0)).unwrap()
    );
}
