//! Settings of controls, and programs rewritten for controls without any: against the machine's own
//! figures, closed forms, and the front end.

use lostmotion_gcode::Dialect;
use lostmotion_sim::control::Control;
use lostmotion_sim::recommend::results::ControlSettings;
use lostmotion_sim::recommend::{RecommendOptions, recommend};
use lostmotion_sim::results::ErrorStats;
use lostmotion_sim::rewrite::results::Rewritten;
use lostmotion_sim::rewrite::{RewriteOptions, rewrite};
use lostmotion_sim::{ContourPoint, Machine, Observer, Program, SimulateOptions, Simulation};

const ARC: &str = "G21 G90 G17 G64 P0.002\nG0 X10 Y-3\nG1 Y0 F900\nG3 X10 Y0 I-10 J0\nG1 Y3\nM2\n";

fn program(text: &str) -> Program {
    Program::from_str("part.ngc", text)
}

fn machine() -> Machine {
    Machine::preset("vmc3-worn").unwrap()
}

fn settings(control: Control, wanted: &RecommendOptions) -> ControlSettings {
    recommend(
        &program(ARC),
        &machine(),
        &SimulateOptions::default(),
        control,
        wanted,
    )
    .unwrap()
}

#[test]
fn what_is_printed_is_what_was_simulated() {
    let answer = settings(Control::LinuxCnc, &RecommendOptions::default());
    // The same by the keys of the machine file alone.
    let machine = machine();
    let axes = machine.axes().iter().zip(&answer.settings);
    let set = axes.fold(machine.clone(), |set, (axis, setting)| {
        let told: f64 = setting.value.parse().unwrap();
        let mut config = axis.config.clone();
        let limits = axis.limits_table().limits();
        let linuxcnc = &mut config.compensation.fixed_linuxcnc;
        linuxcnc.gap = Some(lostmotion_drive::config::Gap::Um(1e3 * told));
        linuxcnc.velocity_units_s = Some(limits.velocity);
        linuxcnc.acceleration_units_s2 = Some(limits.acceleration);
        set.with_axis_config(axis.id, &config)
    });
    let part = program(ARC);
    let run = Simulation::new(&part, &set)
        .methods(["none", "fixed-linuxcnc"])
        .run()
        .unwrap();
    assert_eq!(answer.before, run.results[0].cutting);
    // The printed value is the told one to the last bits.
    let (told, again) = (answer.after, run.results[1].cutting);
    assert!((told.rms - again.rms).abs() < 1e-8 && (told.max - again.max).abs() < 1e-8);
    assert_eq!(answer.method.as_deref(), Some("fixed-linuxcnc"));
    // LinuxCNC issue 395: the take-up needs half of the joint's limits on top.
    let limits = machine.axes()[0].limits_table().limits();
    let needed = format!("STEPGEN_MAXACCEL of {:.1} to", 1.5 * limits.acceleration);
    assert!(
        answer.preconditions[0].contains(&needed),
        "{:?}",
        answer.preconditions
    );
}

/// A machine whose control corrects half of what it is told today is set to correct all of it.
#[test]
fn amounts_of_a_marlin_are_those_of_all_of_the_gap() {
    let whole = settings(Control::Marlin, &RecommendOptions::default());
    let halved = machine().map_axes(|config| {
        let mut config = config.clone();
        config.compensation.fixed_by_travel.correction = 0.5;
        config
    });
    let (part, options) = (program(ARC), SimulateOptions::default());
    let wanted = RecommendOptions::default();
    let again = recommend(&part, &halved, &options, Control::Marlin, &wanted).unwrap();
    assert!(
        again.paste[1].starts_with("M425 F1.0 "),
        "{:?}",
        again.paste
    );
    assert_eq!((again.paste, again.after), (whole.paste, whole.after));
}

#[test]
fn an_uncertain_gap_is_told_its_least_and_shown_at_both_ends() {
    let wanted = RecommendOptions {
        gap_uncertainty: Some(0.25),
        ..RecommendOptions::default()
    };
    let answer = settings(Control::Fanuc, &wanted);
    // 40 um less a quarter, and 15.7 of wind-up, in detection units of 1 um
    assert_eq!(answer.settings[0].value, "46");
    let factors: Vec<f64> = answer.uncertain.iter().map(|end| end.factor).collect();
    assert_eq!(factors, [0.75, 1.25]);
    // Told 30 um of 30 little is left, of 50 the rest.
    assert!(answer.uncertain[0].after.rms < answer.uncertain[1].after.rms);
    assert!(answer.uncertain[0].before.rms < answer.uncertain[1].before.rms);
    let coarse = RecommendOptions {
        detection_unit_um: 10.0,
        ..wanted
    };
    assert_eq!(settings(Control::Fanuc, &coarse).settings[0].value, "5");
    // 35.2 um and the wind-up are 50.9, rounded once: 40 and the wind-up would be 6 units.
    let once = RecommendOptions {
        gap_uncertainty: Some(0.12),
        ..coarse
    };
    assert_eq!(settings(Control::Fanuc, &once).settings[0].value, "5");
    for bad in [f64::NAN, -0.1, 1.0] {
        let wanted = RecommendOptions {
            gap_uncertainty: Some(bad),
            ..wanted
        };
        let options = SimulateOptions::default();
        let error = recommend(&program(ARC), &machine(), &options, Control::Fanuc, &wanted);
        assert!(error.is_err(), "{bad}");
    }
}

/// Where every way of setting a control does harm, nothing is set, and why is said.
#[test]
fn what_does_harm_is_not_recommended() {
    let turning = "G21 G90 G17 G64 P0.01\nG54 G0 X0 Y0 Z5 A0\nG1 Z-1 F300\nX10 A30 F500\nX0 A0\nY10 A-20\nG0 Z5\nM2\n";
    let exact = RecommendOptions {
        gap_uncertainty: Some(0.0),
        ..RecommendOptions::default()
    };
    let (machine, options) = (Machine::preset("vmc4").unwrap(), SimulateOptions::default());
    for control in [Control::Fanuc, Control::Heidenhain] {
        let of = recommend(&program(turning), &machine, &options, control, &exact);
        let answer = of.unwrap();
        // The slide of Z flies across its gap where it brakes: with a shift of half a gap it lies farther off.
        let refused = answer.refused.as_deref().unwrap_or_default();
        assert!(refused.contains("worse than none"), "{refused}");
        // 30 arc seconds of the table, of which the contour knows nothing.
        let table = "half its 8.3 mdeg are 3.6 um at 50 mm";
        let unseen = |note: &String| note.starts_with("A: no contour") && note.contains(table);
        assert!(answer.notes.iter().any(unseen), "{:?}", answer.notes);
        assert_eq!(answer.method.is_none(), answer.settings.is_empty());
        assert_eq!(answer.method.is_none(), answer.refused.is_some());
    }
}

/// On a machine next to without a gap nothing is to be set, and the block that decides is named.
#[test]
fn what_is_left_off_names_the_worst_block() {
    let whole = machine();
    // Without friction there is no wind-up to be set either.
    let tight = whole.map_axes(|config| {
        let mut load = config.clone().with_gap(1e-5).reflected_load();
        load.coulomb_nm = 0.0;
        lostmotion_methods::AxisConfig {
            load: lostmotion_drive::config::Load::Reflected(load),
            ..config.clone()
        }
    });
    let part = program("G21 G90 G17\nG0 X0 Y0 Z5\nG1 Z-1 F300\nG1 X20 F600\nX0\nY10\nM2\n");
    let (options, wanted) = (SimulateOptions::default(), RecommendOptions::default());
    let answer = recommend(&part, &tight, &options, Control::LinuxCnc, &wanted).unwrap();
    let refused = answer.refused.unwrap();
    assert!(
        refused.starts_with("leave the compensation off: "),
        "{refused}"
    );
    assert!(refused.contains("worst block is line "), "{refused}");
}

/// Without a gap all that is lost is wind-up, which a control can be told as well.
#[test]
fn without_a_gap_the_wind_up_is_set() {
    let tight = machine().map_axes(|config| config.clone().without_gap());
    let (options, wanted) = (SimulateOptions::default(), RecommendOptions::default());
    let answer = recommend(&program(ARC), &tight, &options, Control::LinuxCnc, &wanted).unwrap();
    assert_eq!(answer.refused, None);
    // 2 F/k of the worn machine's friction and stiffness: with its gap of 40 um it is told 55.7.
    assert_eq!(answer.settings[0].value, "0.0157");
    assert!(answer.after.rms < 0.5 * answer.before.rms);
}

/// How well the gap is known decides where it is said: then nothing is asked of other gaps, and what is
/// set does no harm at either end.
#[test]
fn what_is_set_does_no_harm_wherever_in_its_interval_the_gap_is() {
    for (control, share) in [
        (Control::Fanuc, 0.2),
        (Control::Marlin, 0.9),
        (Control::RepRapFirmware, 0.6),
    ] {
        let wanted = RecommendOptions {
            gap_uncertainty: Some(share),
            ..RecommendOptions::default()
        };
        let answer = settings(control, &wanted);
        assert_eq!(answer.gap_uncertainty, Some(share));
        assert_eq!(answer.uncertain.len(), 2);
        let worse = answer.uncertain.iter().any(|end| {
            end.after.rms > end.before.rms + 0.1 || end.after.max > end.before.max + 0.1
        });
        assert_eq!(answer.refused.is_some(), answer.settings.is_empty());
        assert!(!worse || answer.refused.is_some(), "{answer:?}");
        assert!(answer.trust.is_none() || answer.refused.is_some());
    }
}

#[test]
fn units_and_signs_are_those_of_the_control() {
    let of = |control| settings(control, &RecommendOptions::default());
    assert_eq!(
        of(Control::Siemens).paste[0],
        "N32450 $MA_BACKLASH[0,AX1]=0.0557"
    );
    let isg = of(Control::Beckhoff);
    assert_eq!(isg.settings[0].value, "557");
    // Which of 1 and 2 it is depends on how homing ends.
    assert_eq!(isg.settings[1].value, "1");
    assert!(
        isg.preconditions
            .iter()
            .any(|text| text.contains("homing ends"))
    );
    assert_eq!(
        of(Control::Smoothieware).paste[0],
        "alpha_backlash_mm    0.04    # X"
    );
    // Spread over twice the gap it comes late on an arc: as little as the control takes is best.
    let soon = of(Control::RepRapFirmware);
    assert_eq!(soon.refused, None);
    assert!(soon.chosen.starts_with("over 1 gap"), "{}", soon.chosen);
    assert!(soon.paste[1].ends_with(" S1"), "{:?}", soon.paste);
    assert!(soon.after.rms < soon.before.rms);
    // In inches the words would be 25 times as large.
    let marlin = of(Control::Marlin).paste;
    assert!(
        marlin[0] == "G21" && marlin[1].starts_with("M425 F1.0 S"),
        "{marlin:?}"
    );
    assert_eq!(of(Control::GrblHal).paste[1], "$161=0.058");
    for control in [Control::Haas, Control::Klipper, Control::Own] {
        let answer = of(control);
        assert!(answer.refused.is_some() && answer.settings.is_empty() && answer.paste.is_empty());
        assert!(!answer.is_within_tolerance() && answer.before.samples > 0);
    }
}

/// 55.7 um are 0.00219 inch.
#[test]
fn controls_in_inches_are_told_inches() {
    let inches = machine().edit(|m| m.control_units = lostmotion_gcode::Units::Inch);
    let inches = inches.unwrap();
    let (part, options) = (program(ARC), SimulateOptions::default());
    for (control, line, needs) in [
        (
            Control::Mach3,
            "distance 0.00219 inch, speed",
            "native units",
        ),
        (
            Control::Fagor,
            "BACKLASH 0.00219    (X, inch)",
            "are in inch",
        ),
        (
            Control::Siemens,
            "N32450 $MA_BACKLASH[0,AX1]=0.00219",
            "MD10240 SCALING_SYSTEM_IS_METRIC is 0",
        ),
        // Counted in a unit of its own whatever the machine's.
        (Control::Beckhoff, "P-AXIS-00103 557", "homing ends"),
    ] {
        let wanted = RecommendOptions::default();
        let answer = recommend(&part, &inches, &options, control, &wanted).unwrap();
        assert!(
            answer.paste[0].contains(line),
            "{control}: {:?} {:?}",
            answer.paste,
            answer.refused
        );
        let all = answer.preconditions.join("\n");
        assert!(all.contains(needs), "{control}: {all}");
    }
}

/// Joints that turn and second motors for which a control has no setting are not compensated in what it
/// promises.
#[test]
fn what_cannot_be_set_is_not_simulated_as_set() {
    let wanted = RecommendOptions::default();
    let part = program(
        "G21 G90 G17 G64 P0.005\nG0 X10 Y0 Z5\nG1 Z0 F600\nG3 X10 Y0 I-10 J0 F900\nG1 Z-2\nG1 Z0\nG0 Z5\nM2\n",
    );
    let answered = |machine: &Machine, control| {
        recommend(
            &part,
            machine,
            &SimulateOptions::default(),
            control,
            &wanted,
        )
        .unwrap()
    };
    let gantry = Machine::preset("gantry3").unwrap();
    // One setting for both motors: that of the smaller gap. Letters and numbers are those of the axes.
    let marlin = answered(&gantry, Control::Marlin);
    let words: Vec<&str> = marlin.paste[1].split(' ').skip(3).collect();
    assert!(words.len() == 3 && words[2].starts_with('Z'), "{words:?}");
    let y: f64 = words[1].strip_prefix('Y').unwrap().parse().unwrap();
    assert!((0.01..0.014).contains(&y), "{words:?}");
    assert!(
        marlin
            .notes
            .iter()
            .any(|note| note.contains("10.0 and 25.0 um"))
    );
    let grblhal = answered(&gantry, Control::GrblHal);
    let names: Vec<&str> = grblhal
        .settings
        .iter()
        .map(|own| own.name.as_str())
        .collect();
    assert_eq!(names, ["$160", "$161", "$162"]);
    let fanuc = answered(&gantry, Control::Fanuc);
    assert!(
        fanuc
            .preconditions
            .iter()
            .any(|text| text.contains("A1 X, A2 Y, A3 Y2, A4 Z"))
    );
    // Each motor of LinuxCNC is a joint of its own, but where the machine's joints are told otherwise.
    let joints = |machine: &Machine| answered(machine, Control::LinuxCnc).settings.len();
    let alone = gantry
        .edit(|m| m.joint_axes = Some("XYZ".to_owned()))
        .unwrap();
    assert_eq!((joints(&gantry), joints(&alone)), (4, 3));
    // As run with what is printed alone, by the keys of the machine file.
    let told = |setting: &str| 1e3 * setting.parse::<f64>().unwrap();
    let both = answered(&alone, Control::LinuxCnc);
    let mut set = alone.clone();
    for (axis, setting) in alone.axes().iter().zip(&both.settings) {
        let of = |config: &lostmotion_methods::AxisConfig| {
            let mut config = config.clone();
            let limits = axis.limits_table().limits();
            let own = &mut config.compensation.fixed_linuxcnc;
            own.gap = Some(lostmotion_drive::config::Gap::Um(told(&setting.value)));
            own.velocity_units_s = Some(limits.velocity);
            own.acceleration_units_s2 = Some(limits.acceleration);
            config
        };
        set = set.with_axis_config(axis.id, &of(&axis.config));
        if let Some(gantry) = alone.gantry().filter(|gantry| gantry.axis == axis.id) {
            set = set.with_second_config(&of(&gantry.second));
        }
    }
    let run = Simulation::new(&part, &set)
        .method("fixed-linuxcnc")
        .run()
        .unwrap();
    assert!(
        (run.results[0].cutting.rms - both.after.rms).abs() < 1e-8,
        "{:?}",
        both.after
    );
    // An arm's joints turn, and a firmware has no amounts for them: nothing helps along Z alone.
    let scara = answered(&Machine::preset("scara").unwrap(), Control::Marlin);
    assert!(
        scara.after.rms == 0.0 || scara.after.rms > 0.9 * scara.before.rms,
        "{:?} {:?}",
        scara.before,
        scara.after
    );
}

/// GRBL-Advanced issue 30, grblHAL issue 751: a control that takes the gap up by a move of its own
/// stops the circle at each quadrant; Mach3 stops at the end of each move.
#[test]
fn controls_that_stop_to_compensate_take_longer() {
    for (control, place) in [
        (Control::GrblHal, "where an axis reverses"),
        (Control::Mach3, "at the end of every move"),
    ] {
        let answer = settings(control, &RecommendOptions::default());
        let note = answer.notes.iter().find(|note| note.contains(place));
        let note = note.unwrap_or_else(|| panic!("{:?}", answer.notes));
        let numbers: Vec<f64> = note
            .split(|c: char| !c.is_ascii_digit() && c != '.')
            .filter_map(|text| text.parse().ok())
            .collect();
        let [with, without] = numbers[..] else {
            panic!("{note}")
        };
        assert!(with > without, "{note}");
    }
}

/// The judge on the original program finds what the run itself says of it, but for places where another move is
/// nearer than the present one.
fn judged_as_run(part: &Program, machine: &Machine, new: &Rewritten) -> ErrorStats {
    let run = Simulation::new(part, machine).method("none").run().unwrap();
    let own = run.results[0].cutting;
    assert!(
        (new.before.rms_um / own.rms - 1.0).abs() < 0.05,
        "{own:?} {:?}",
        new.before
    );
    own
}

/// GRBL-Advanced issue 30: an inserted move at each quadrant stops the circle there. On a circle of
/// three feeds four take-ups a turn, and time that they cost.
#[test]
fn a_rewritten_circle_stops_at_each_quadrant_and_keeps_the_contour() {
    let (part, machine) = (program(ARC), machine());
    let options = SimulateOptions::default();
    let new = rewrite(&part, &machine, &options, &RewriteOptions::default()).unwrap();
    assert_eq!(new.refused, None);
    assert!(new.shift_mm.iter().all(|half| (half - 0.02).abs() < 1e-12));
    assert_eq!(new.arcs_split, 1);
    // X turns at its start and after half a turn, Y after a quarter and three.
    assert!(new.within_cuts >= 4, "{new:?}");
    assert!(new.time_after_s > new.time_before_s);
    // Half the gap of 40 um on each side of the circle: without friction's wind-up 20 um at most.
    assert!(
        new.after.rms_um < 0.5 * new.before.rms_um,
        "{:?} {:?}",
        new.before,
        new.after
    );
    let own = judged_as_run(&part, &machine, &new);
    assert!(
        (new.before.max_um / own.max - 1.0).abs() < 0.02,
        "{own:?} {:?}",
        new.before
    );
}

/// The new text read by the front end: each end point is the original's, moved by half a gap on each
/// axis, and each arc keeps its radius.
#[test]
fn end_points_are_moved_by_half_the_gaps() {
    let text = "%\nO1000 (a part)\n(head)\nG21 G90 G17 G64 \nG0 X0 Y0 Z5\nN10 G1 Z-1 F300 (plunge)\n\
                N20 X30 M8\nY20 ; up\nG2 X40 Y30 R10\nG3 X50 Y20 I0 J-10 (wrong way round)\nX20 Y0 R-25\nG1 X-10\nG0 Z20\nM30\n%\n";
    let (part, machine) = (program(text), machine());
    let options = SimulateOptions {
        dialect: Some(lostmotion_gcode::Dialect::Fanuc),
        ..SimulateOptions::default()
    };
    let gap_alone = RewriteOptions {
        most_normal_um: 0.0,
        ..RewriteOptions::default()
    };
    let new = rewrite(&part, &machine, &options, &gap_alone).unwrap();
    for kept in [
        "N10 G1 Z-1.02 F300 (plunge)",
        "N20 X30.02 M8",
        " ; up",
        "(head)",
        "M30",
    ] {
        assert!(new.text.contains(kept), "{kept}: {}", new.text);
    }
    assert!(
        new.text
            .starts_with("%\nO1000 (a part)\n(part.ngc rewritten"),
        "{}",
        new.text
    );
    let rewritten = program(&new.text);
    let curves = |program: &Program| -> Vec<lostmotion_sim::motion::ProgrammedMove> {
        let all = Simulation::new(program, &machine)
            .dialect(lostmotion_gcode::Dialect::Fanuc)
            .curves()
            .unwrap();
        all.map(Result::unwrap).collect()
    };
    let old = curves(&part);
    let ends = |moves: &[lostmotion_sim::motion::ProgrammedMove]| -> Vec<[f64; 3]> {
        moves
            .iter()
            .map(|item| item.motion.curve.end().linear())
            .collect()
    };
    let (old_ends, new_ends) = (ends(&old), ends(&curves(&rewritten)));
    // Each end of the original is found again, off by half a gap on each axis or, of an axis that has
    // not moved yet, by none; in the order of the program.
    let mut at = 0;
    for end in old_ends {
        let found = new_ends[at..].iter().position(|new| {
            (0..3).all(|axis| {
                let off = (new[axis] - end[axis]).abs();
                (off - 0.02).abs() < 2e-4 || off < 2e-4
            })
        });
        at += found.unwrap_or_else(|| panic!("{end:?} is not in {}", new.text));
    }
    // Length of all that is cut: the same but for the take-ups, a gap of 0.04 mm each.
    let cut = |moves: &[lostmotion_sim::motion::ProgrammedMove]| -> f64 {
        let cuts = moves.iter().filter(|item| !item.is_rapid());
        cuts.map(|item| item.motion.curve.length()).sum()
    };
    let taken = 0.04 * 1.5 * (new.within_cuts + new.in_the_air + 4) as f64;
    let (old, new_length) = (cut(&old), cut(&curves(&rewritten)));
    assert!((new_length - old).abs() < taken, "{old} {new_length}");
}

/// Besides half the gap end points are moved against the wind-up, within a bound: on straight lines next
/// to nothing is left.
#[test]
fn what_is_left_is_taken_off_along_the_normal() {
    let text = "G21 G90 G17 G64 P0.01\nG0 X0 Y0 Z10\nG1 Z-1 F200\nX30 F800\nY20\nG3 X20 Y30 I-10 J0\nG1 X0\nY0\nG0 Z10\nM2\n";
    let (part, machine) = (program(text), machine());
    let of = |most_normal_um: f64| {
        let wanted = RewriteOptions {
            most_normal_um,
            ..RewriteOptions::default()
        };
        rewrite(&part, &machine, &SimulateOptions::default(), &wanted).unwrap()
    };
    let (alone, bounded, free) = (of(0.0), of(4.0), of(20.0));
    assert_eq!((alone.normal_um, alone.refused), (0.0, None));
    assert!(
        (bounded.normal_um - 4.0).abs() < 1e-9,
        "{}",
        bounded.normal_um
    );
    // Friction over stiffness of the drives is 7 to 10 um.
    assert!((7.0..15.0).contains(&free.normal_um), "{}", free.normal_um);
    let [alone, bounded, free] = [alone.after, bounded.after, free.after];
    println!("{alone:?} {bounded:?} {free:?}");
    assert!(bounded.rms_um < 0.8 * alone.rms_um && free.rms_um < 0.4 * alone.rms_um);
    assert!(free.max_um < alone.max_um + 0.1 * of(20.0).before.max_um);
    assert!(of(20.0).text.contains("along the normal"));
}

/// A program rewritten for the worn machine, with nothing asked for.
fn rewritten(text: &str) -> Rewritten {
    let (options, wanted) = (SimulateOptions::default(), RewriteOptions::default());
    rewrite(&program(text), &machine(), &options, &wanted).unwrap()
}

/// The same tool path from wherever the machine stood when the program began, and behind a change of the
/// tool: as judged with the described start at most 2 um more.
#[test]
fn a_rewritten_program_may_begin_anywhere() {
    let text = "G21 G90 G17 G64 P0.01\nG0 X0 Y0 Z5\nG1 Z-1 F300\nX40 F900\nY30\nX0\nY0\nG0 Z5\nT2 M6\nG0 X50 Y0\nZ5\nG1 Z-1 F300\nX60 F900\nG0 Z5\nM2\n";
    let wanted = RewriteOptions {
        most_normal_um: 0.0,
        ..RewriteOptions::default()
    };
    let new = rewrite(
        &program(text),
        &machine(),
        &SimulateOptions::default(),
        &wanted,
    )
    .unwrap();
    assert_eq!(new.refused, None);
    // Behind its first place by half a millimetre, X against its first way, and then there.
    let wanted = "G0 X-0.48 Y-0.48 Z5.48\nG0 X0.02 Y0.02 Z4.98 (backlash of X Y Z)\n";
    assert!(new.text.contains(wanted), "{}", new.text);
    assert!(
        new.text
            .contains("(backlash of Z)\nG0 X49.52 Y-0.48 (backlash of X Y)\nG0 X50.02 Y0.02 (backlash of X Y)\n"),
        "{}",
        new.text
    );
    let part = program(&new.text);
    let machine = machine();
    let [x, y, z] = machine.start().linear();
    let left = [-50.0, 0.0, 50.0].map(|aside| {
        let edited = machine.edit(|m| {
            let start = m.start.insert(Default::default());
            [start.x_mm, start.y_mm] = [x + aside, y + aside];
            start.z_mm = z + aside.abs();
        });
        let machine = edited.unwrap();
        let mut seen = OffSegments::default();
        let simulation = Simulation::new(&part, &machine).method("none");
        simulation.observer(&mut seen).run().unwrap();
        seen.0
    });
    let [least, most] = [f64::min, f64::max].map(|of| left.into_iter().reduce(of).unwrap());
    // 36 um with the wrong flank of one axis.
    assert!(most < 20e-3 && most - least < 4e-3, "{left:?}");
}

/// How far the tool is off the cuts of the test, at most, mm.
#[derive(Default)]
struct OffSegments(f64);

impl Observer for OffSegments {
    fn wants_contour(&self) -> bool {
        true
    }

    fn contour(&mut self, _method: usize, points: &[ContourPoint]) {
        const CORNERS: [[f64; 3]; 6] = [
            [0.0, 0.0, 5.0],
            [0.0, 0.0, -1.0],
            [40.0, 0.0, -1.0],
            [40.0, 30.0, -1.0],
            [0.0, 30.0, -1.0],
            [0.0, 0.0, -1.0],
        ];
        const SECOND: [[f64; 3]; 3] = [[50.0, 0.0, 5.0], [50.0, 0.0, -1.0], [60.0, 0.0, -1.0]];
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let less = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
        for point in points.iter().filter(|point| point.moving && !point.rapid) {
            let pairs = CORNERS.windows(2).chain(SECOND.windows(2));
            let off = pairs.map(|pair| {
                let (way, from) = (less(pair[1], pair[0]), less(point.actual_mm, pair[0]));
                let share = (dot(from, way) / dot(way, way)).clamp(0.0, 1.0);
                let rest = less(from, way.map(|part| part * share));
                dot(rest, rest).sqrt()
            });
            self.0 = self.0.max(off.fold(f64::INFINITY, f64::min));
        }
    }
}

/// A way home by a place that half a gap is missing to has a first move that the original does not have.
#[test]
fn a_way_home_from_half_a_gap_aside_is_kept() {
    let text = "G21 G90 G17 G61.1\nG0 X0 Y0 Z10\nG1 X20 F900\nG1 Y20\nG28 Z10\nG90\nG0 Z8\nG1 X0 F900\nG1 Y0\nM2\n";
    let new = rewritten(text);
    assert_eq!(new.refused, None);
    assert!(new.text.contains("\nG28 Z10\n"), "{}", new.text);
}

/// Each piece of several turns is less than one, and says no number of turns.
#[test]
fn arcs_of_several_turns_are_cut_at_their_reversals() {
    let text = "G21 G90 G17 G64 P0.01\nG0 X10 Y0 Z5\nG1 Z0 F300\nG3 X10 Y0 Z-3 I-10 J0 P3 F600\nG0 Z5\nM2\n";
    let new = rewritten(text);
    assert_eq!((new.refused.as_deref(), new.arcs_split), (None, 1));
    // Quarters of three turns, but where a circle begins on a reversal.
    let arcs = new.text.lines().filter(|line| line.starts_with("G3"));
    assert!(arcs.clone().count() >= 11, "{}", new.text);
    assert!(arcs.clone().all(|line| !line.contains('P')), "{}", new.text);
    assert!(
        new.after.rms_um < 0.6 * new.before.rms_um,
        "{:?}",
        new.after
    );
}

/// A move that goes back along the one before it is measured by itself: the drive is wound up the other way.
#[test]
fn ways_that_are_gone_twice_are_told_apart() {
    let text = "G21 G90 G17 G61\nG0 X0 Y0 Z5\nG1 Z-1 F300\nG1 X20 F900\nG2 X30 Y-10 I0 J-10\nG3 X20 Y-20 I-10 J0\nG1 X0\nG0 Z5\nM2\n";
    let new = rewritten(text);
    assert!(
        new.normal_um > 5.0 && new.after.rms_um < 2.5,
        "{} {:?}",
        new.normal_um,
        new.after
    );
}

/// What is moved along the normal alone is not called backlash, and an arc in a plane stays in it.
#[test]
fn marks_say_what_a_line_is_for() {
    let text = "G21 G90 G17 G61\nG0 X10 Y0 Z5\nG1 Z0 F300\nG3 X10 Y0 I-10 J0 F1200\nG1 X20 Y3\nG1 X30 Y3.5\nG2 X40 Y3.5 I5 J0\nG0 Z5\nM2\n";
    let new = rewritten(text);
    assert_eq!(new.refused, None);
    println!("{}", new.text);
    // Z is not wound up by the arcs, which are split in four and one.
    let arcs: Vec<&str> = new
        .text
        .lines()
        .filter(|line| line.starts_with("G3"))
        .collect();
    assert!(
        arcs.len() >= 4 && arcs.iter().all(|line| !line.contains('Z')),
        "{arcs:?}"
    );
    assert!(new.text.contains("(backlash of Y)"), "{}", new.text);
    assert!(
        new.text.contains("(backlash of Y, correction of Z)"),
        "{}",
        new.text
    );
}

#[test]
fn what_is_not_rewritten_is_told_by_its_line() {
    let options = SimulateOptions::default();
    let refused = |text: &str, machine: &Machine| {
        let wanted = RewriteOptions::default();
        rewrite(&program(text), machine, &options, &wanted)
            .unwrap_err()
            .to_string()
    };
    for (text, line, what) in [
        ("G21 G90\nG91\nG1 X1 F100\nM2\n", 3, "G91"),
        ("G21 G90\nG1 X1 F100\nG91 G28 Z5\nG90\nM2\n", 3, "G91"),
        ("G21 G91\nG2 I5 F100\nM2\n", 2, "G91"),
        ("G21 G90\n#1=3\nG1 X#1 F100\nM2\n", 3, "expression"),
        (
            "G21 G90\nG0 X0 Y0 Z5\nG81 X1 Y1 Z-1 R1 F100\nM2\n",
            3,
            "G81",
        ),
        (
            "G21 G90\no1 repeat [2]\nG1 X1 F100\nX2\no1 endrepeat\nM2\n",
            3,
            "more than once",
        ),
        (
            "G21 G90\nG41 D1 G1 X9 F100\nG40\nM2\n",
            2,
            "cutter compensation",
        ),
        (
            "G21 G90 G17\nG0 X5 Y0\nG3 X-5 Y0 I-5 F100 M0\nM2\n",
            3,
            "line of its own",
        ),
        (
            "G21 G90\nG1 X9 F100\nG92 X0\nX5\nM2\n",
            3,
            "G92 takes where",
        ),
        (
            "G21 G90\nG1 X9 F100\nG10 L20 P1 X0\nX5\nM2\n",
            3,
            "G10 L20 takes where",
        ),
        (
            "G21 G90\nG1 X9 F100\nG28.1\nX5\nM2\n",
            3,
            "G28.1 takes where",
        ),
        ("G21 G90\nG1 X9 F100\n /G1 X5\nM2\n", 3, "may be skipped"),
        (
            "G21 G90\no1 sub\n G1 X1 F100\no1 endsub\no1 call\nM2\n",
            3,
            "moves of subroutines",
        ),
    ] {
        let error = refused(text, &machine());
        assert!(
            error.starts_with(&format!("line {line}, column ")) && error.contains(what),
            "{error}"
        );
        // Plain lines of these are another program's.
        let plain = ["G92", "L20", "skipped", "more than once", "subroutines"];
        let is_plain = plain.iter().any(|part| what.contains(part));
        assert!(!is_plain || error.contains("gcode write"), "{error}");
    }
    let error = refused(ARC, &Machine::preset("corexy").unwrap());
    assert!(error.contains("are not X, Y and Z"), "{error}");
    let ideal = machine().without_gap();
    let error = refused(ARC, &ideal);
    assert!(error.contains("no gap"), "{error}");
    let small = RewriteOptions {
        most_um: 5.0,
        ..RewriteOptions::default()
    };
    let error = rewrite(&program(ARC), &machine(), &options, &small)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("half the gap of X is 20.0 um, more than the 5 um"),
        "{error}"
    );
}

/// A program as posts write it: a tool's length, ways home and to places of the machine between cuts.
#[test]
fn tool_lengths_and_ways_home_stay_as_they_are() {
    let cut = "G1 Z-1 F200\nX30 F800\nY20\nX0\nY0\nG0 Z10\n";
    for (head, length, home) in [
        ("", "", "G28 Z0\n"),
        ("G10 L1 P1 Z50\nT1 M6\nG43 H1\n", "", "G91 G28 Z0\nG90\n"),
        ("G43.1 Z50\n", "G43.1 Z70\n", "G53 G0 Z0\n"),
        ("", "", "G28\n"),
        ("", "G43.1 Z20\n", "G30 Z5\n"),
        ("", "", "G53 G0 X-20 Y-20\n"),
    ] {
        let text = format!(
            "G21 G17 G90 G54 G64 P0.01\n{head}G0 X0 Y0 Z10\n{cut}{home}{length}G0 X0 Y0 Z10\n{cut}{home}M2\n"
        );
        let (part, machine) = (program(&text), machine());
        let options = SimulateOptions::default();
        let new = rewrite(&part, &machine, &options, &RewriteOptions::default());
        let new = new.unwrap_or_else(|error| panic!("{error}: {text}"));
        assert_eq!(new.refused, None, "{text}");
        assert!(
            new.after.rms_um < 0.5 * new.before.rms_um,
            "{text}{:?} {:?}",
            new.before,
            new.after
        );
        judged_as_run(&part, &machine, &new);
        assert!(
            new.text.contains(home.lines().next().unwrap()),
            "{}",
            new.text
        );
    }
}

/// Twice rewritten is twice compensated: the mark is found behind the head of any dialect.
#[test]
fn a_rewritten_program_is_not_rewritten() {
    let options = SimulateOptions::default();
    for (dialect, head) in [
        (Dialect::LinuxCnc, ""),
        (Dialect::Fanuc, "%\nO0001\n"),
        (Dialect::Marlin, ""),
    ] {
        let options = SimulateOptions {
            dialect: Some(dialect),
            ..options.clone()
        };
        let of = |text: &str| {
            rewrite(
                &program(text),
                &machine(),
                &options,
                &RewriteOptions::default(),
            )
        };
        let new = of(&format!("{head}{ARC}")).unwrap();
        let error = of(&new.text).unwrap_err().to_string();
        let line = head.lines().count() + 1;
        assert!(
            error.starts_with(&format!(
                "line {line}, column 2: the program has been rewritten already"
            )) && error.contains("rewrite the original program instead"),
            "{error}"
        );
    }
}

/// The text of a program is held beside its moves: neither is without a bound.
#[test]
fn a_program_that_is_too_large_is_not_rewritten() {
    let few = RewriteOptions {
        max_moves: 10,
        ..RewriteOptions::default()
    };
    let text = format!("({})\n{ARC}", "x".repeat(1000));
    let options = SimulateOptions::default();
    let error = rewrite(&program(&text), &machine(), &options, &few).unwrap_err();
    assert!(
        error.to_string().contains("bytes, more than 10 moves take"),
        "{error}"
    );
    rewrite(
        &program(&text),
        &machine(),
        &options,
        &RewriteOptions::default(),
    )
    .unwrap();
}

/// Inch with a plane of its own, and an interval that is too wide.
#[test]
fn inch_other_planes_and_wide_intervals() {
    let (machine, options) = (machine(), SimulateOptions::default());
    let good =
        "G20 G90 G18 G64 P0.0001\nG0 X0.5 Z0\nG1 Z0.1 F30\nG3 X0.7 Z0.3 I0.2 K0\nG1 X1.2\nM2\n";
    let new = rewrite(
        &program(good),
        &machine,
        &options,
        &RewriteOptions::default(),
    )
    .unwrap();
    // 0.02 mm are 0.00079 inch
    assert!(new.text.contains("G1 Z0.10079 F30"), "{}", new.text);
    let wide = RewriteOptions {
        gap_uncertainty: Some(0.9),
        ..RewriteOptions::default()
    };
    let new = rewrite(&program(ARC), &machine, &options, &wide).unwrap();
    // A tenth of the gap is taken up: too little of one that may be 1.9 times as large.
    assert!((new.shift_mm[0] - 0.002).abs() < 1e-12);
    let reason = new.refused.unwrap_or_default();
    assert!(reason.starts_with("it does not help enough"), "{reason}");
}
