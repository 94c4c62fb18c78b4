//! The axis as one body: published records, and logs of an integrator of its own.

#![allow(
    clippy::disallowed_methods,
    reason = "std's functions are independent of those under test"
)]

use crate::rig::ballscrew::BallScrew;
use lostmotion_base::random::Random;
use lostmotion_identify::body::{
    BodyLog, Figure, Motion, fit_body, fit_lost_motion, fit_servo, replay,
};
use lostmotion_logs::{AxisOptions, read_axis};
use std::path::{Path, PathBuf};

/// A record beside the repository; says so where it is absent.
fn record(name: &str) -> Option<PathBuf> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/data")
        .join(name);
    if path.is_file() {
        return Some(path);
    }
    println!("{} is not there: skipped", path.display());
    None
}

fn read(path: &Path, columns: &[&str]) -> BodyLog {
    let options = AxisOptions {
        columns: columns.iter().map(|spec| spec.parse().unwrap()).collect(),
        ..AxisOptions::default()
    };
    let bytes = std::fs::read(path).unwrap();
    let log = read_axis(bytes.as_slice(), "record", &options).unwrap();
    // mm to m
    let metres = |column: Vec<f64>| column.into_iter().map(|value| 1e-3 * value).collect();
    let drive = log
        .drive
        .map(|drive| drive.values().to_vec())
        .unwrap_or_default();
    BodyLog::from_rows(
        &log.time_s,
        metres(log.motor),
        metres(log.load),
        metres(log.command),
        drive,
    )
    .unwrap()
}

/// EMPS (Janot, Gautier, Brunot 2019): the published values with three of their standard errors.
#[test]
fn emps_has_the_published_parameters() {
    let Some(path) = record("emps/data_emps.csv") else {
        return;
    };
    let log = read(
        &path,
        &[
            "motor=position_m",
            "command=reference_m",
            "force=voltage_V,unit=N,scale=35.15065188248547",
        ],
    );
    let motion = Motion::of(&log);
    let body = fit_body(&log, &motion).unwrap();
    for (found, published, error, what) in [
        (body.inertia, 95.1089, 0.1085, "mass"),
        (body.viscous, 203.5034, 1.1460, "viscous friction"),
        (body.coulomb, 20.3935, 0.1012, "Coulomb friction"),
        (body.constant, -3.1648, 0.0444, "offset"),
    ] {
        println!("{what}: {found:?}");
        assert!(
            (found.value - published).abs() < 3.0 * error,
            "{what}: {found:?}"
        );
        assert!(found.is_told(), "{what}");
    }
    // viscous friction differs by the direction: published 166.7 and 240.4
    let [forth, back] = body.sided.unwrap().viscous;
    println!("{forth:?} {back:?}");
    assert!((forth.value - 166.7).abs() < 6.0 && (back.value - 240.4).abs() < 6.0);
    // the published controller: kp 160.18 1/s, kv 243.45 V/(m/s), speed from a difference over 2 ms
    let servo = fit_servo(&log, &motion).unwrap();
    let law = servo.law.unwrap();
    println!("{law:?}");
    assert!((law.position_gain_per_s.value - 160.18).abs() < 0.5);
    assert!((law.velocity_gain.value / 35.150_651_882_485_47 - 243.45).abs() < 2.5);
    assert!((law.delay_s - 1e-3).abs() < 1e-4);
    assert_eq!(law.integral_time_s, None);
    // between the gain's 1/160.18 s and the 852.2 um at the top speed of 0.1247 m/s, friction included
    assert!(
        (6.243e-3..6.834e-3).contains(&servo.lag_s.value),
        "{:?}",
        servo.lag_s
    );
    let again = replay(&log, &body, &servo).unwrap();
    println!(
        "closed loop: rms {:.3} um, largest {:.1} um",
        1e6 * again.rms,
        1e6 * again.largest
    );
    assert!(again.rms < 3e-6, "{}", again.rms);
}

/// A real trace with motor and linear scale: 30 steps of 1 um down, then up. Motor less scale goes
/// from one side to the other over some 20 um of travel.
#[test]
fn lost_motion_of_a_real_axis_is_no_step() {
    let Some(path) = record("sinumerik/X_BK300_1.xml") else {
        return;
    };
    let log = read(&path, &[]);
    let lost = fit_lost_motion(&log, None).unwrap();
    println!("{lost:?}");
    assert!((1..=4).contains(&lost.reversals));
    assert!(!lost.is_step);
    assert!(
        (1.2e-6..2.2e-6).contains(&lost.total.value),
        "{:?}",
        lost.total
    );
    assert!(
        (10e-6..40e-6).contains(&lost.saturates_after),
        "{}",
        lost.saturates_after
    );
    assert!(!lost.step.is_told() || lost.step.value < 0.5 * lost.total.value);
}

/// An axis of one body: mass, friction of either direction, cascade control, encoder.
struct Axis {
    mass: f64,
    viscous: f64,
    coulomb: f64,
    above: f64,
    stribeck: f64,
    constant: f64,
    position_gain: f64,
    velocity_gain: f64,
    integral_time: f64,
    forward: f64,
    count: f64,
    noise: f64,
}

impl Axis {
    fn drawn(random: &mut Random) -> Axis {
        let mass = random.log_between(20.0, 2000.0);
        let coulomb = mass * random.log_between(0.05, 0.5);
        Axis {
            mass,
            viscous: mass * random.log_between(0.5, 5.0),
            coulomb,
            above: 0.0,
            stribeck: 2e-3,
            constant: coulomb * (random.between(-0.5, 0.5)),
            position_gain: random.between(15.0, 35.0),
            velocity_gain: mass * random.between(200.0, 350.0),
            integral_time: random.between(0.03, 0.08),
            forward: random.between(0.0, 1.0),
            count: random.log_between(1e-8, 2e-7),
            noise: coulomb * 0.05,
        }
    }

    /// 20 s of strokes of different length and speed at 1 kHz, each with trapezoids of acceleration.
    fn log(&self, random: &mut Random) -> BodyLog {
        let period = 1e-3;
        let mut command: Vec<f64> = Vec::new();
        let mut place = 0.0;
        while command.len() < 20_000 {
            let way: f64 = random.between(-0.15, 0.15) - 0.3 * place;
            let acceleration = random.log_between(0.5, 4.0);
            // no stroke lasts longer than some 3 s
            let speed: f64 = random.log_between(0.005, 0.3).max(0.3 * way.abs());
            let ramp = (speed / acceleration).min((way.abs() / acceleration).sqrt());
            let top = acceleration * ramp;
            let flat = (way.abs() - top * ramp).max(0.0) / top;
            let whole = 2.0 * ramp + flat;
            let samples = (whole / period).ceil() as usize;
            for sample in 0..samples {
                let t = sample as f64 * period;
                let done = if t < ramp {
                    0.5 * acceleration * t * t
                } else if t < ramp + flat {
                    top * (t - 0.5 * ramp)
                } else {
                    let left = (whole - t).max(0.0);
                    top * (ramp + flat) - 0.5 * acceleration * left * left
                };
                command.push(place + way.signum() * done);
            }
            place += way.signum() * top * (ramp + flat);
            command.extend(std::iter::repeat_n(
                place,
                20 + (random.between(0.0, 100.0)) as usize,
            ));
        }
        command.truncate(20_000);
        let (mut x, mut v, mut integral, mut before) = (0.0_f64, 0.0_f64, 0.0, 0.0);
        let (mut motor, mut drive) = (Vec::new(), Vec::new());
        let steps = 50;
        let step = period / f64::from(steps);
        for sample in 0..command.len() {
            let measured = (x / self.count).round() * self.count;
            motor.push(measured);
            let speed = (measured - before) / period;
            before = measured;
            let reference = (command[sample] - command[sample.saturating_sub(1)]) / period;
            let asked = self.position_gain * (command[sample] - measured)
                + self.forward * reference
                - speed;
            integral += asked * period / self.integral_time;
            let force = self.velocity_gain * (asked + integral);
            drive.push(force + self.noise * random.normal());
            for _ in 0..steps {
                let net = force - self.constant;
                let side = if v == 0.0 { net.signum() } else { v.signum() };
                let friction = self.coulomb + self.above * (-(v / self.stribeck).powi(2)).exp();
                if v == 0.0 && net.abs() <= friction {
                    continue;
                }
                let mut next = v + step / self.mass * (net - self.viscous * v - side * friction);
                if next * side < 0.0 {
                    next = 0.0;
                }
                x += 0.5 * step * (v + next);
                v = next;
            }
        }
        let time: Vec<f64> = (0..command.len())
            .map(|sample| sample as f64 * period)
            .collect();
        BodyLog::from_rows(&time, motor, Vec::new(), command, drive).unwrap()
    }
}

/// Drawn axes: how often intervals hold the truth, and how large the errors are.
#[test]
fn intervals_of_drawn_axes_hold_the_truth() {
    let mut held = [0; 4];
    let mut worst = [0.0_f64; 4];
    let logs = 30;
    for seed in 0..logs {
        let mut random = Random::new(18_340_000 + seed);
        let axis = Axis::drawn(&mut random);
        let log = axis.log(&mut random);
        let motion = Motion::of(&log);
        let body = fit_body(&log, &motion).unwrap();
        let pairs = [
            (body.inertia, axis.mass),
            (body.viscous, axis.viscous),
            (body.coulomb, axis.coulomb),
            (body.constant, axis.constant),
        ];
        for (index, (found, truth)) in pairs.into_iter().enumerate() {
            held[index] += i32::from(found.interval[0] <= truth && truth <= found.interval[1]);
            worst[index] = worst[index]
                .max((found.value - truth).abs() / if index == 3 { axis.coulomb } else { truth });
        }
        assert!(body.stribeck.is_none(), "seed {seed}: {:?}", body.stribeck);
    }
    println!("held {held:?} of {logs}, worst {worst:?}");
    assert!(held.iter().all(|&held| held >= 26), "{held:?}");
    assert!(
        worst[0] < 0.02 && worst[1] < 0.1 && worst[2] < 0.05,
        "{worst:?}"
    );
}

#[test]
fn friction_that_falls_with_speed_is_told_from_slow_strokes() {
    let mut random = Random::new(18_250_001);
    let axis = Axis {
        above: 60.0,
        stribeck: 12e-3,
        mass: 300.0,
        coulomb: 100.0,
        viscous: 400.0,
        noise: 2.0,
        ..Axis::drawn(&mut random)
    };
    let log = axis.log(&mut random);
    let body = fit_body(&log, &Motion::of(&log)).unwrap();
    let stribeck = body.stribeck.unwrap();
    println!("{body:?}");
    assert!((stribeck.above.value - 60.0).abs() < 12.0, "{stribeck:?}");
    assert!((8e-3..18e-3).contains(&stribeck.speed.value));
    assert!((body.coulomb.value - 100.0).abs() < 5.0);
}

/// Drawn axes whose friction falls with speed: intervals hold the truth in at least 95 of 100.
#[test]
fn intervals_of_friction_that_falls_hold_the_truth() {
    const NAMES: [&str; 6] = [
        "above", "speed", "coulomb", "viscous", "inertia", "constant",
    ];
    let mut held = [0; 6];
    let mut worst = [0.0_f64; 6];
    let mut told = 0;
    let logs = 240;
    for seed in 0..logs {
        let mut random = Random::new(18_540_000 + seed);
        let drawn = Axis::drawn(&mut random);
        let axis = Axis {
            above: drawn.coulomb * random.between(0.3, 1.0),
            stribeck: random.log_between(6e-3, 2e-2),
            ..drawn
        };
        let log = axis.log(&mut random);
        let body = fit_body(&log, &Motion::of(&log)).unwrap();
        let Some(stribeck) = body.stribeck else {
            println!("seed {seed}: {:?}", body.untold);
            continue;
        };
        told += 1;
        let pairs = [
            (stribeck.above, axis.above),
            (stribeck.speed, axis.stribeck),
            (body.coulomb, axis.coulomb),
            (body.viscous, axis.viscous),
            (body.inertia, axis.mass),
            (body.constant, axis.constant),
        ];
        for (index, (found, truth)) in pairs.into_iter().enumerate() {
            let within = found.interval[0] <= truth && truth <= found.interval[1];
            held[index] += i32::from(within);
            let size = if index == 5 { axis.coulomb } else { truth };
            worst[index] = worst[index].max((found.value - truth).abs() / size);
        }
    }
    println!("{NAMES:?} held {held:?} of {told} told of {logs}, worst {worst:?}");
    assert!(told >= 228, "{told}");
    assert!(held.iter().all(|held| 20 * held >= 19 * told), "{held:?}");
    assert!(worst[0] < 0.2 && worst[1] < 0.2, "{worst:?}");
}

/// A figure with a wide interval is given and said to be vague, not said to be untold.
#[test]
fn a_vague_figure_is_not_called_untold() {
    // Strokes of nearly one speed, with noise as large as what viscous friction makes of its change.
    let mut random = Random::new(18_450_017);
    let speeds: [f64; 3] = [0.05, 0.08, 0.11];
    let (mut place, mut places, mut drive) = (0.0_f64, Vec::new(), Vec::new());
    for stroke in 0..24 {
        let speed = speeds[stroke / 2 % 3] * if stroke % 2 == 0 { 1.0 } else { -1.0 };
        for _ in 0..400 {
            place += 1e-3 * speed;
            places.push(place);
            drive.push(100.0 * speed.signum() + 40.0 * speed + 40.0 * random.normal());
        }
    }
    let time: Vec<f64> = (0..places.len())
        .map(|sample| sample as f64 * 1e-3)
        .collect();
    let log = BodyLog::from_rows(&time, places, vec![], vec![], drive).unwrap();
    let body = fit_body(&log, &Motion::of(&log)).unwrap();
    let said: Vec<&String> = body
        .untold
        .iter()
        .filter(|it| it.starts_with("the "))
        .collect();
    assert!(!said.is_empty());
    for words in said {
        assert!(
            words.contains(" from zero: ") || words.contains(" more closely than "),
            "{words}"
        );
    }
}

/// Friction that does not fall with speed: slow motion says how little it could, fast motion alone
/// says that it cannot be told and which motion would.
#[test]
fn friction_that_does_not_fall_is_bounded_or_said_not_to_be_told() {
    let mut random = Random::new(18_450_001);
    let drawn = Axis::drawn(&mut random);
    let log = drawn.log(&mut random);
    let body = fit_body(&log, &Motion::of(&log)).unwrap();
    let bound = body.stribeck_bound.unwrap();
    println!("{bound:?} of {}", drawn.coulomb);
    assert!(bound.above < 0.5 * drawn.coulomb && bound.from_speed < 0.01);
    // One speed to and fro, turning round at once.
    let place = |sample: usize| {
        let way = sample % 2000;
        2e-5 * if way < 1000 { way } else { 2000 - way } as f64
    };
    let motor: Vec<f64> = (0..20_000).map(place).collect();
    let drive = (1..20_001)
        .map(|sample| 100.0 * (place(sample) - place(sample - 1)).signum() + random.normal());
    let time: Vec<f64> = (0..20_000).map(|sample| f64::from(sample) * 1e-3).collect();
    let log = BodyLog::from_rows(&time, motor, vec![], vec![], drive.collect()).unwrap();
    let body = fit_body(&log, &Motion::of(&log)).unwrap();
    let untold = body.untold.join("; ");
    assert!(body.stribeck.is_none() && body.stribeck_bound.is_none());
    assert!(
        untold.contains("cannot be told, because only") && untold.contains("a hundredth"),
        "{untold}"
    );
}

#[test]
fn gains_of_a_cascade_are_found() {
    let mut random = Random::new(18_260_002);
    let mut held = [0; 2];
    for _ in 0..12 {
        let axis = Axis::drawn(&mut random);
        let log = axis.log(&mut random);
        let servo = fit_servo(&log, &Motion::of(&log)).unwrap();
        let law = servo.law.unwrap();
        println!(
            "kp {} {:?}, kv {} {:?}, T {} {:?}, ff {} {}, delay {}",
            axis.position_gain,
            law.position_gain_per_s,
            axis.velocity_gain,
            law.velocity_gain,
            axis.integral_time,
            law.integral_time_s,
            axis.forward,
            law.feedforward,
            law.delay_s
        );
        let within =
            |found: Figure, truth: f64| found.interval[0] <= truth && truth <= found.interval[1];
        held[0] += i32::from(within(law.position_gain_per_s, axis.position_gain));
        held[1] += i32::from(within(law.velocity_gain, axis.velocity_gain));
        assert!((law.position_gain_per_s.value / axis.position_gain - 1.0).abs() < 0.15);
        assert!((law.velocity_gain.value / axis.velocity_gain - 1.0).abs() < 0.1);
        assert!((law.integral_time_s.unwrap().value / axis.integral_time - 1.0).abs() < 0.2);
        assert!((law.feedforward - axis.forward).abs() < 0.1);
    }
    println!("{held:?} of 12");
    assert!(held.iter().all(|&held| held >= 11), "{held:?}");
}

/// Loops as stiff as those of machine tools: with the whole speed fed forward the log tells two pairs,
/// and where the two are nearly one an interval that is wide.
#[test]
fn gains_of_stiff_loops_are_held() {
    let mut random = Random::new(18_340_901);
    for number in 0..16 {
        let drawn = Axis::drawn(&mut random);
        let axis = Axis {
            position_gain: random.between(30.0, 70.0),
            velocity_gain: drawn.mass * random.between(250.0, 350.0),
            integral_time: random.between(0.008, 0.02),
            forward: [1.0, 1.0, 0.3, 0.6][number % 4],
            ..drawn
        };
        let log = axis.log(&mut random);
        let law = fit_servo(&log, &Motion::of(&log)).unwrap().law.unwrap();
        let [low, high] = law.position_gain_per_s.interval;
        println!(
            "kp {} T {} ff {}: {:?} {:?} {:?}",
            axis.position_gain,
            axis.integral_time,
            axis.forward,
            law.position_gain_per_s,
            law.integral_time_s,
            law.alike
        );
        let held = low <= axis.position_gain && axis.position_gain <= high;
        let other = law.alike.is_some_and(|[gain, time]| {
            (gain / axis.position_gain - 1.0).abs() < 0.1
                && (time / axis.integral_time - 1.0).abs() < 0.1
        });
        assert!(held || other, "{number}");
        assert!(high < 2.5 * low, "{number}: {low} to {high}");
    }
}

/// A loop without an integral part, with none, some or all of the speed fed forward.
#[test]
fn gains_of_loops_without_an_integral_part_are_found() {
    let mut random = Random::new(18_611_207);
    let mut held = 0;
    for number in 0..12 {
        let drawn = Axis::drawn(&mut random);
        let axis = Axis {
            integral_time: f64::INFINITY,
            forward: [0.0, 1.0, 0.5, 0.8][number % 4],
            // friction leaves such a loop behind its command at every rest
            coulomb: 0.3 * drawn.coulomb,
            ..drawn
        };
        let log = axis.log(&mut random);
        let law = fit_servo(&log, &Motion::of(&log)).unwrap().law.unwrap();
        println!(
            "kp {} {:?}, kv {} {:?}, T {:?}, ff {} {}",
            axis.position_gain,
            law.position_gain_per_s,
            axis.velocity_gain,
            law.velocity_gain,
            law.integral_time_s,
            axis.forward,
            law.feedforward,
        );
        let [low, high] = law.position_gain_per_s.interval;
        held += i32::from(low <= axis.position_gain && axis.position_gain <= high);
        assert!((law.position_gain_per_s.value / axis.position_gain - 1.0).abs() < 0.1);
        assert!((law.velocity_gain.value / axis.velocity_gain - 1.0).abs() < 0.1);
        assert!((law.feedforward - axis.forward).abs() < 0.1);
        assert!(law.integral_time_s.is_none_or(|time| time.value > 1.0));
    }
    println!("{held} of 12");
    assert!(held >= 11, "{held}");
}

#[test]
fn what_a_log_does_not_tell_is_said() {
    let time: Vec<f64> = (0..5000).map(|sample| f64::from(sample) * 1e-3).collect();
    // one way at one speed
    let way: Vec<f64> = time.iter().map(|t| 0.01 * t).collect();
    let none = Vec::new;
    let log = BodyLog::from_rows(&time, way.clone(), none(), none(), vec![1.0; 5000]).unwrap();
    let motion = Motion::of(&log);
    assert_eq!((motion.reversals, motion.strokes.len()), (0, 1));
    assert!(fit_body(&log, &motion).unwrap_err().contains("to and fro"));
    assert!(fit_servo(&log, &motion).unwrap_err().contains("no command"));
    assert!(
        fit_lost_motion(&log, None)
            .unwrap_err()
            .contains("linear scale")
    );
    // a second between rows, and a column that has nothing to do with the motion
    let slow: Vec<f64> = time.iter().map(|t| 1e3 * t).collect();
    let to_and_fro: Vec<f64> = time
        .iter()
        .map(|t| 0.02 * (2.6 * t).sin() + 0.003 * (8.2 * t).sin())
        .collect();
    let noise: Vec<f64> = {
        let mut random = Random::new(5_550_001);
        time.iter().map(|_| random.normal()).collect()
    };
    for (time, says) in [
        (&slow, "1 s apart"),
        (&time, "nothing to do with the motion"),
    ] {
        let log =
            BodyLog::from_rows(time, to_and_fro.clone(), none(), none(), noise.clone()).unwrap();
        let error = fit_body(&log, &Motion::of(&log)).unwrap_err();
        assert!(error.contains(says), "{error}");
    }
    // a force with the other sign
    let against: Vec<f64> = time
        .iter()
        .map(|t| {
            let speed = 0.052 * (2.6 * t).cos() + 0.0246 * (8.2 * t).cos();
            let acceleration = -0.1352 * (2.6 * t).sin() - 0.20172 * (8.2 * t).sin();
            -10.0 * acceleration - 3.0 * speed.signum()
        })
        .collect();
    let log = BodyLog::from_rows(&time, to_and_fro, none(), none(), against).unwrap();
    assert!(fit_body(&log, &Motion::of(&log)).unwrap().is_reversed());
    let silent = BodyLog::from_rows(&time, way, none(), none(), none()).unwrap();
    assert!(
        fit_body(&silent, &motion)
            .unwrap_err()
            .contains("no current")
    );
}

/// At one speed Coulomb and viscous friction are one figure; friction never drives.
#[test]
fn friction_at_one_speed_is_not_told_apart() {
    // strokes of 0.9 s at 5 mm/s with ramps of 10 ms, to and fro with rests
    let (speed, ramp, stroke) = (5e-3, 0.01, 0.9);
    let profile = |t: f64| {
        let (number, within) = ((t / 1.0).floor(), t % 1.0);
        let sign = if number % 2.0 == 0.0 { 1.0 } else { -1.0 };
        let up = (within / ramp).min((stroke - within) / ramp);
        let v = speed * up.clamp(0.0, 1.0);
        let a = if within < ramp {
            speed / ramp
        } else if (stroke - ramp..stroke).contains(&within) {
            -speed / ramp
        } else {
            0.0
        };
        (sign * v, sign * a)
    };
    let mut random = Random::new(18_290_001);
    let dt = 1e-3;
    let (mut at, mut time, mut way, mut drive) = (0.0, vec![], vec![], vec![]);
    for sample in 0..20_000 {
        let t = f64::from(sample) * dt;
        let (v, a) = profile(t);
        at += v * dt;
        time.push(t);
        way.push(at + 1e-7 * random.normal());
        let friction = if v == 0.0 {
            0.0
        } else {
            300.0 * v.signum() + 500.0 * v
        };
        drive.push(400.0 * a + friction + random.normal());
    }
    let log = BodyLog::from_rows(&time, way.clone(), vec![], vec![], drive.clone()).unwrap();
    let body = fit_body(&log, &Motion::of(&log)).unwrap();
    let holds =
        |figure: Figure, truth: f64| (figure.interval[0]..=figure.interval[1]).contains(&truth);
    assert!(
        holds(body.viscous, 500.0) && holds(body.coulomb, 300.0),
        "{body:?}"
    );
    assert!(
        !body.viscous.is_told() && !body.coulomb.is_told(),
        "{body:?}"
    );
    let said = body
        .untold
        .iter()
        .filter(|text| text.contains("apart, because"))
        .count();
    assert_eq!(said, 1, "{:?}", body.untold);
    // The same with a friction that drives.
    let drives: Vec<f64> = time
        .iter()
        .map(|t| {
            let (v, a) = profile(*t);
            let friction = if v == 0.0 { 0.0 } else { v.signum() };
            400.0 * a - 300.0 * friction
        })
        .collect();
    let log = BodyLog::from_rows(&time, way, vec![], vec![], drives).unwrap();
    let said = fit_body(&log, &Motion::of(&log)).unwrap_err();
    assert!(said.contains("friction would drive the axis"), "{said}");
}

/// Axes with a gap and a shaft: while the motor crosses the gap the load's part of it all is missing, and
/// with the load in the log that is told apart. Without it the intervals are wider and hold, too.
#[test]
fn inertia_and_friction_of_axes_with_a_gap_hold_the_truth() {
    let mut held = [[0; 3]; 2];
    let mut errors = Vec::new();
    let seeds = 7_120_000..7_120_016;
    for seed in seeds.clone() {
        let axis = BallScrew {
            seconds: 20.0,
            noise: 0.002,
            ..BallScrew::random(seed)
        };
        let rows = axis.record();
        let r = axis.rad_per_mm() * 1e3;
        let metres = |column: &[f64]| column.iter().map(|value| 1e-3 * value).collect::<Vec<_>>();
        let force: Vec<f64> = rows
            .current_a
            .iter()
            .map(|current| current * axis.torque_constant * r)
            .collect();
        let truth = [
            (axis.motor_inertia + axis.load_inertia) * r * r,
            (axis.motor_viscous + axis.load_viscous) * r * r,
            (axis.motor_coulomb + axis.load_coulomb) * r,
        ];
        for (which, load) in [metres(&rows.load_mm), Vec::new()].into_iter().enumerate() {
            let motor = metres(&rows.motor_mm);
            let log = BodyLog::from_rows(&rows.time_s, motor, load, vec![], force.clone());
            let log = log.unwrap();
            let body = fit_body(&log, &Motion::of(&log)).unwrap();
            if which == 0 {
                assert!(body.is_one_body(), "{seed}: {body:?}");
                errors.push((body.inertia.value / truth[0] - 1.0).abs());
            }
            let found = [body.inertia, body.viscous, body.coulomb];
            for (at, (found, truth)) in found.into_iter().zip(truth).enumerate() {
                let [low, high] = found.interval;
                held[which][at] += i32::from(low <= truth && truth <= high || !body.is_one_body());
            }
        }
    }
    errors.sort_by(f64::total_cmp);
    println!("held {held:?} of {}, errors {errors:?}", seeds.count());
    assert!(held.iter().flatten().all(|held| *held >= 14), "{held:?}");
    assert!(errors[8] < 1e-3 && errors[15] < 0.02, "{errors:?}");
}

/// Rows every 4 ms: averages of such a log and its speeds have to be those of one signal, and the servo sums
/// the error up faster.
#[test]
fn gains_are_found_in_slow_logs() {
    let mut random = Random::new(18_280_003);
    let mut held = [0; 3];
    for _ in 0..12 {
        let axis = Axis::drawn(&mut random);
        let log = axis.log(&mut random);
        let fourth = |column: &[f64]| column.iter().copied().step_by(4).collect::<Vec<_>>();
        let rows = fourth(&log.motor);
        let time: Vec<f64> = (0..rows.len())
            .map(|row| 4.0 * log.period_s * row as f64)
            .collect();
        let (command, drive) = (fourth(&log.command), fourth(&log.drive));
        let slow = BodyLog::from_rows(&time, rows, vec![], command, drive).unwrap();
        let law = fit_servo(&slow, &Motion::of(&slow)).unwrap().law.unwrap();
        println!(
            "{} {} {} {law:?}",
            axis.position_gain, axis.velocity_gain, axis.integral_time
        );
        // With nearly the whole speed fed forward two pairs explain the log alike.
        let near = |found: f64, truth: f64| (found / truth - 1.0).abs() < 0.15;
        let other = law.alike.is_some_and(|[gain, time]| {
            near(gain, axis.position_gain) && near(time, axis.integral_time)
        });
        let figures = [
            law.position_gain_per_s,
            law.velocity_gain,
            law.integral_time_s.unwrap(),
        ];
        let truth = [axis.position_gain, axis.velocity_gain, axis.integral_time];
        for (at, (found, truth)) in figures.into_iter().zip(truth).enumerate() {
            let [low, high] = found.interval;
            let is_held = low <= truth && truth <= high;
            held[at] += i32::from(is_held || other && at != 1);
        }
    }
    println!("{held:?} of 12");
    assert!(held.iter().all(|held| *held >= 11), "{held:?}");
}

/// Strokes that are shorter than the lag: the motor moves less far than its command, and later. The lag is that
/// at a steady speed, of a command whose unit is right.
#[test]
fn a_lag_as_long_as_a_stroke_is_told() {
    let (period, lag) = (2e-3, 0.15);
    let mut motor = Vec::new();
    let mut place: f64 = 0.0;
    let command: Vec<f64> = (0..12_000)
        .map(|row| {
            let t = f64::from(row) * period;
            // Strokes of 10 mm in 0.5, 1 and 0.2 s, to and fro without a rest.
            let stroke = [0.5, 1.0, 0.2][(t / 8.0) as usize % 3];
            let phase = (t / stroke) % 2.0;
            0.01 * if phase < 1.0 { phase } else { 2.0 - phase }
        })
        .collect();
    for command in &command {
        for _ in 0..20 {
            place += period / 20.0 / lag * (command - place);
        }
        motor.push((place * 1e7).round() * 1e-7);
    }
    let time: Vec<f64> = (0..12_000).map(|row| f64::from(row) * period).collect();
    let fit = |motor: Vec<f64>| {
        let log = BodyLog::from_rows(&time, motor, vec![], command.clone(), vec![]).unwrap();
        fit_servo(&log, &Motion::of(&log))
    };
    let found = fit(motor.clone()).unwrap().lag_s;
    println!("{found:?}");
    assert!(
        found.interval[0] <= lag && lag <= found.interval[1],
        "{found:?}"
    );
    assert!((found.value / lag - 1.0).abs() < 0.02, "{found:?}");
    // In another unit it is no command of this axis.
    let wrong = fit(motor.iter().map(|motor| 2.0 * motor).collect()).unwrap_err();
    assert!(wrong.contains("times as far as its command"), "{wrong}");
}

/// A pure gap is a step, of its size.
#[test]
fn a_gap_is_a_step() {
    let time: Vec<f64> = (0..20_000).map(|sample| f64::from(sample) * 1e-3).collect();
    let mut random = Random::new(18_270_001);
    let motor: Vec<f64> = time
        .iter()
        .map(|t| 0.02 * (1.3 * t).sin() + 0.003 * (4.1 * t).sin())
        .collect();
    let mut place: f64 = 0.0;
    let load: Vec<f64> = motor
        .iter()
        .map(|&motor| {
            place = place.clamp(motor - 10e-6, motor + 10e-6);
            place + 1e-8 * random.normal()
        })
        .collect();
    let log = BodyLog::from_rows(&time, motor, load, Vec::new(), Vec::new()).unwrap();
    let lost = fit_lost_motion(&log, None).unwrap();
    println!("{lost:?}");
    assert!(
        (lost.total.value - 20e-6).abs() < 0.6e-6,
        "{:?}",
        lost.total
    );
    assert!(lost.is_step);
}
