//! Where the control stops the machine: following error, travel and overload, each where a closed
//! form says; and never on a sound machine.

use lostmotion_base::AxisId;
use lostmotion_drive::config::{Load, Monitoring};
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use lostmotion_sim::machine::{LimitsTable, LinearLimits, presets};
use lostmotion_sim::results::{MethodResult, Run, StopLimit, StopResult};
use lostmotion_sim::{Machine, Program, Simulation};
use std::f64::consts::TAU;
use std::path::Path;

fn run(machine: &Machine, text: &str) -> Run {
    let program = Program::from_str("stop.ngc", text);
    Simulation::new(&program, machine).run().unwrap()
}

fn stop(run: &Run) -> Option<&StopResult> {
    run.first().unwrap().stop.as_ref()
}

/// The mill with X without feed-forward at a position gain, slow in getting to speed, and nothing
/// but its following error watched.
fn slow_x(gain: f64, acceleration: f64, watched: Monitoring) -> Machine {
    Machine::preset("vmc3")
        .unwrap()
        .edit(|m| {
            let x = m.axis("x");
            x.drive.position_gain_per_s = gain;
            x.drive.velocity_feedforward = 0.0;
            x.drive.acceleration_feedforward = 0.0;
            x.drive.encoder_counts_per_rev = None;
            x.limits = LimitsTable::Linear(LinearLimits {
                min_mm: -762.0,
                max_mm: 0.0,
                velocity_mm_s: 500.0,
                acceleration_mm_s2: acceleration,
                jerk_mm_s3: 1e5,
            });
            x.monitoring = watched;
        })
        .unwrap()
}

/// Commanded speed of X at a time, mm/s.
fn commanded_speed(machine: &Machine, text: &str, time_s: f64) -> f64 {
    let program = Program::from_str("stop.ngc", text);
    let mut speeds = Vec::new();
    Simulation::new(&program, machine)
        .plan(&mut |samples, _| {
            speeds.extend(samples.iter().map(|sample| sample.velocity[AxisId::X]));
            Ok(())
        })
        .unwrap();
    let at = time_s * 1e3;
    let (low, part) = (at.floor() as usize, at.fract());
    speeds[low] + part * (speeds[low + 1] - speeds[low])
}

/// A position loop that is followed at once has the error `v/Kv - a/Kv^2` at the end of a long ramp
/// of speed: it passes a limit `L` at `v = Kv L + a/Kv`.
#[test]
fn the_following_error_stops_the_machine_at_the_speed_of_the_closed_form() {
    let text = "G21 G90\nG1 X200 F6000\nM2\n";
    for (gain, acceleration, limit) in [(50.0, 100.0, 1.0), (40.0, 150.0, 1.7), (62.8, 80.0, 0.9)] {
        let machine = slow_x(
            gain,
            acceleration,
            Monitoring {
                following_error_units: Some(limit),
                ..Monitoring::OFF
            },
        );
        let run = run(&machine, text);
        let stop = stop(&run).expect("it does not stop");
        assert_eq!(
            (stop.axis, stop.limit),
            (AxisId::X, StopLimit::FollowingError)
        );
        assert_eq!((stop.block.span.line, stop.unit.as_str()), (2, "um"));
        assert!((stop.allowed - 1e3 * limit).abs() < 1e-9, "{stop:?}");
        // The limit is passed by what the error grows in a command cycle at most.
        let growth_um = acceleration / gain * 1e-3 * 1e3;
        assert!(
            stop.value > stop.allowed && stop.value < stop.allowed + growth_um,
            "{stop:?}"
        );
        let speed = commanded_speed(&machine, text, stop.time_s);
        let expected = gain * limit + acceleration / gain;
        // Within a command cycle and a half of the ramp, and 1e-4 of the speed.
        assert!(
            (speed - expected).abs() < 1.5e-3 * acceleration + 1e-4 * expected,
            "{speed} mm/s for {expected}"
        );
        assert!(!run.is_within_tolerance());
    }
}

/// `v/Kv` at a constant speed on either side of the limit, which grows with the speed as LinuxCNC's
/// does: `max(MIN_FERROR, FERROR v/v_max)`.
#[test]
fn a_speed_whose_error_is_within_the_limit_does_not_stop_the_machine() {
    let watched = |full: f64, standstill: Option<f64>| Monitoring {
        following_error_units: Some(full),
        standstill_error_units: standstill,
        ..Monitoring::OFF
    };
    // At 50/s an error of 1 mm at 50 mm/s: 10 mm at 500 mm/s. While the axis brakes the error is
    // larger by a/Kv^2, 8 um, which the limit at rest has to cover.
    for (feed, watched, stops) in [
        (2940, watched(1.0, None), false),
        (3060, watched(1.0, None), true),
        (3060, watched(10.5, Some(0.3)), false),
        (3060, watched(9.7, Some(0.3)), true),
        (3060, watched(9.7, Some(1.1)), false),
        (3060, watched(0.0, Some(0.1)), false),
    ] {
        let machine = slow_x(50.0, 20.0, watched);
        let run = run(&machine, &format!("G21 G90\nG1 X300 F{feed}\nM2\n"));
        assert_eq!(stop(&run).is_some(), stops, "F{feed} {watched:?}");
    }
}

/// A weight F on a screw of the lead p asks for the current i = F p/(2 pi Kt). From cold, i times
/// the continuous current is borne for `-T ln(1 - 1/i^2)`.
#[test]
fn an_overload_stops_the_machine_when_the_closed_form_says() {
    let (force_n, lead_m) = (3000.0, 0.016);
    let torque_constant = 1.08;
    let current_a = force_n * lead_m / TAU / torque_constant;
    for (ratio, time_s) in [(1.2, 1.0), (1.5, 2.0), (2.0, 5.0)] {
        let machine = Machine::preset("vmc3")
            .unwrap()
            .edit(|m| {
                let z = m.axis("z");
                z.motor.coulomb_nm = 0.0;
                z.drive.encoder_counts_per_rev = None;
                z.monitoring = Monitoring {
                    continuous_current_a: Some(current_a / ratio),
                    overload_time_s: time_s,
                    ..Monitoring::OFF
                };
                if let Load::Slide(slide) = &mut z.config.load {
                    slide.constant_n = force_n;
                    slide.coulomb_n = 0.0;
                }
            })
            .unwrap();
        let run = run(&machine, "G21 G90\nG1 X1 F3000\nG4 P5\nG1 X2\nM2\n");
        let stop = stop(&run).expect("it does not stop");
        assert_eq!((stop.axis, stop.limit), (AxisId::Z, StopLimit::Overload));
        let expected_s = -time_s * f64::ln(1.0 - 1.0 / (ratio * ratio));
        // Heat is seen at the end of a command cycle.
        assert!(
            (stop.time_s - expected_s).abs() < 1.5e-3,
            "{} s for {expected_s} s",
            stop.time_s
        );
    }
}

/// Holds the motor a way ahead of its command.
struct Ahead {
    rad: f64,
}

static AHEAD: MethodInfo = MethodInfo {
    name: "ahead",
    summary: "holds the motor ahead of its command",
    source: "this test",
    knows: Knowledge {
        load_scale: false,
        gap: false,
        load: false,
    },
};

impl Compensator for Ahead {
    type State = ();

    fn info(&self) -> &'static MethodInfo {
        &AHEAD
    }

    fn initial(&self, _start: f64) {}

    fn step(&self, (): &mut (), _signals: &Signals) -> Correction {
        Correction {
            position: self.rad,
            ..Correction::NONE
        }
    }
}

/// The motor is held 0.5 mm ahead; the command goes to the end of the travel, and the motor by that
/// much beyond it.
#[test]
fn the_motor_may_be_beyond_the_travel_by_the_overtravel() {
    for (overtravel, stops) in [(0.49, true), (0.51, false), (0.0, false)] {
        let machine = Machine::preset("vmc3")
            .unwrap()
            .edit(|m| {
                m.axis("x").monitoring = Monitoring {
                    overtravel_units: Some(overtravel),
                    ..Monitoring::OFF
                };
            })
            .unwrap();
        let program = Program::from_str("stop.ngc", "G21 G90\nG1 X380 F20000\nG1 X381 F600\nM2\n");
        let run = Simulation::new(&program, &machine)
            .compensator("ahead", |config| Ahead {
                rad: 0.5 * config.transmission.motor_rad_per_unit(),
            })
            .run()
            .unwrap();
        let stop = stop(&run);
        assert_eq!(stop.is_some(), stops, "{overtravel}: {stop:?}");
        let Some(stop) = stop else {
            continue;
        };
        assert_eq!((stop.axis, stop.limit), (AxisId::X, StopLimit::Travel));
        assert_eq!((stop.block.span.line, stop.unit.as_str()), (3, "mm"));
        assert!((stop.allowed - overtravel).abs() < 1e-12);
        // 10 mm/s: 10 um a command cycle.
        assert!(stop.value > overtravel && stop.value < overtravel + 0.011);
        assert!(
            stop.reason.contains("the compensator asks for 500 um"),
            "{stop:?}"
        );
    }
}

/// A drive that `machine check` refuses as unstable.
fn unstable() -> (Machine, String) {
    let toml = presets()
        .iter()
        .find(|preset| preset.name == "vmc3")
        .unwrap()
        .toml
        .replacen(
            "velocity_gain_a_s_per_rad = 2.702",
            "velocity_gain_a_s_per_rad = 20.0",
            1,
        );
    let refused = Machine::check_toml("unstable.toml", &toml).unwrap_err();
    assert_eq!(refused.problems.len(), 1);
    let machine = Machine::from_toml("unstable.toml", &toml).unwrap();
    (machine, refused.problems[0].message.clone())
}

fn sample(name: &str) -> Program {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../gcode_samples/parts");
    let text = std::fs::read_to_string(folder.join(name)).unwrap();
    Program::from_str(name, &text)
}

#[test]
fn an_unstable_drive_stops_the_machine_and_is_said_to_be_unstable() {
    let (machine, fault) = unstable();
    let program = sample("circle_r10.ngc");
    let run = Simulation::new(&program, &machine)
        .methods(["none", "fixed"])
        .run()
        .unwrap();
    for result in &run.results {
        let stop = result.stop.as_ref().expect("it does not stop");
        assert_eq!(stop.axis, AxisId::X);
        assert!(stop.reason.starts_with(&fault), "{stop:?}");
        assert!(!result.within_tolerance);
    }
    assert_eq!(run.recommended, None);
}

/// A current loop that swings at the limits of its voltage warms no motor: the drive is at its limit
/// without a break.
#[test]
fn an_unstable_current_loop_stops_the_machine_within_the_time_at_the_limit() {
    let machine = Machine::preset("vmc3")
        .unwrap()
        .edit(|m| m.axis("x").drive.current_gain_v_per_a = 60.0)
        .unwrap();
    let run = run(&machine, "G21 G90 G17\nG0 X10 Y0\nG3 I-10 J0 F1000\nM2\n");
    let stop = stop(&run).expect("it does not stop");
    assert_eq!((stop.axis, stop.limit), (AxisId::X, StopLimit::AtLimit));
    assert!(
        stop.reason.contains("the current loop is unstable"),
        "{stop:?}"
    );
    assert!(
        (stop.value - 1.001).abs() < 1e-9 && stop.time_s < 2.0,
        "{stop:?}"
    );
}

fn method<'a>(run: &'a Run, name: &str) -> &'a MethodResult {
    run.result(name).unwrap()
}

/// With 2^20 counts the published method's estimate of the gap runs away, and takes the tool along.
#[test]
fn a_method_that_throws_the_tool_stops_the_machine_and_is_not_recommended() {
    let program = sample("pocket_helical.ngc");
    let machine = Machine::preset("vmc3").unwrap();
    let simulate = |machine: &Machine, threads: usize| {
        Simulation::new(&program, machine)
            .methods(["none", "published", "fixed"])
            .threads(threads)
            .run()
            .unwrap()
    };
    let run = simulate(&machine, 1);
    let stopped = method(&run, "published");
    let stop = stopped.stop.as_ref().expect("it does not stop");
    assert_eq!(stop.limit, StopLimit::FollowingError);
    assert!(stop.reason.contains("the compensator asks for"), "{stop:?}");
    assert!(!stop.reason.contains("unstable"), "{stop:?}");
    // What was before stands: the tool has not gone further than the limit lets it.
    let [x, y, z] = [AxisId::X, AxisId::Y, AxisId::Z].map(|axis| {
        let limits = machine.axis(axis).unwrap().monitor_limits();
        limits.following.unwrap().full_speed
    });
    let farthest_um = 1e3 * (x * x + y * y + z * z).sqrt();
    assert!(stopped.cutting.max < farthest_um, "{:?}", stopped.cutting);
    assert_ne!(run.recommended.as_deref(), Some("published"));
    for name in ["none", "fixed"] {
        assert_eq!(method(&run, name).stop, None);
    }
    // Others are as they are without it, and nothing depends on threads.
    assert_eq!(run, simulate(&machine, 3));
    // Unwatched it goes on, and what it does then is what the limits keep from the figures.
    let unwatched = machine.map_axes(|axis| lostmotion_methods::AxisConfig {
        monitoring: Monitoring::OFF,
        ..axis.clone()
    });
    let free = simulate(&unwatched, 1);
    let runs_away = method(&free, "published");
    assert_eq!(runs_away.stop, None);
    assert!(runs_away.cutting.max > 10.0 * stopped.cutting.max);
    // Watching changes no number of a run that does not stop.
    for name in ["none", "fixed"] {
        assert_eq!(method(&run, name).cutting, method(&free, name).cutting);
        assert_eq!(method(&run, name).axes, method(&free, name).axes);
    }
}
