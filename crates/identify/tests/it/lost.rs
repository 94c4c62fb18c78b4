//! Lost motion of known size: at once, along the load's travel, and both.

use lostmotion_base::math;
use lostmotion_base::random::Random;
use lostmotion_identify::body::{BodyLog, LostMotion, Motion, fit_body, fit_lost_motion};

/// A load behind a gap and something that gives by Dahl's law along its own travel.
struct Loss {
    /// Total gap, m.
    step: f64,
    /// What is lost along the travel, m.
    along: f64,
    /// Travel to 95 % of it, m.
    saturates_after: f64,
}

impl Loss {
    /// The state behind a travel to one side.
    fn after(&self, state: f64, travel: f64, side: f64) -> f64 {
        let end = 0.5 * side * self.along;
        end + (state - end) * math::exp(-3.0 * travel / self.saturates_after)
    }

    /// 20 s of a motion of so many metres at 1 kHz, the load read in steps of 0.1 um.
    fn log(&self, amplitude: f64, random: &mut Random) -> BodyLog {
        let time: Vec<f64> = (0..20_000).map(|sample| f64::from(sample) * 1e-3).collect();
        let (mut load, mut state) = (-0.5 * self.step, 0.0);
        let (mut motors, mut loads) = (Vec::new(), Vec::new());
        for t in &time {
            let motor = amplitude * (math::sin(0.94 * t) + 0.4 * math::sin(2.57 * t));
            for side in [1.0, -1.0] {
                // How far the motor is beyond what it loses when the load goes on by a travel.
                let beyond = |travel: f64| {
                    side * (motor - load - self.after(state, travel, side))
                        - travel
                        - 0.5 * self.step
                };
                if beyond(0.0) <= 0.0 {
                    continue;
                }
                let (mut low, mut high) = (0.0, 1.0);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if beyond(middle) > 0.0 {
                        low = middle;
                    } else {
                        high = middle;
                    }
                }
                state = self.after(state, low, side);
                load += side * low;
            }
            motors.push(motor + 2e-8 * random.normal());
            loads.push((load / 1e-7).round() * 1e-7);
        }
        BodyLog::from_rows(&time, motors, loads, Vec::new(), Vec::new()).unwrap()
    }
}

fn found(loss: &Loss, amplitude: f64, seed: u64) -> LostMotion {
    let log = loss.log(amplitude, &mut Random::new(seed));
    let lost = fit_lost_motion(&log, None).unwrap();
    println!("{lost:?}");
    let pairs = [
        (lost.total.interval, loss.step + loss.along),
        (lost.step.interval, loss.step),
        (lost.along.interval, loss.along),
    ];
    for ([low, high], truth) in pairs {
        assert!(low <= truth && truth <= high, "{low} to {high}: {truth}");
    }
    lost
}

/// However short the travel is against the strokes, down to a thousandth.
#[test]
fn a_loss_along_the_travel_has_its_length() {
    let um = 1e-6;
    for (number, [amplitude, saturates_after, along, step]) in [
        [3e-3, 20.0 * um, 6.0 * um, 0.0],
        [3e-3, 200.0 * um, 6.0 * um, 0.0],
        [0.1e-3, 20.0 * um, 6.0 * um, 0.0],
        [20e-3, 100.0 * um, 10.0 * um, 0.0],
        [3e-3, 20e-3, 8.0 * um, 0.0],
        [3e-3, 30.0 * um, 4.0 * um, 4.0 * um],
        [3e-3, 300.0 * um, 4.0 * um, 10.0 * um],
    ]
    .into_iter()
    .enumerate()
    {
        let loss = Loss {
            step,
            along,
            saturates_after,
        };
        let lost = found(&loss, amplitude, 18_340_910 + number as u64);
        let [low, high] = lost.saturates_between;
        assert!(!lost.is_step && low <= saturates_after && saturates_after <= high);
        assert!(high < 1.7 * low, "{low} to {high}");
    }
}

#[test]
fn a_gap_alone_is_a_step() {
    for (number, step) in [2e-6, 8e-6, 40e-6].into_iter().enumerate() {
        let loss = Loss {
            step,
            along: 0.0,
            saturates_after: 1.0,
        };
        assert!(found(&loss, 3e-3, 18_340_920 + number as u64).is_step);
    }
}

/// A load with little friction is thrown against the far flank by every stop. With the friction that the
/// force tells the rows in which it may be anywhere are left out.
#[test]
fn a_load_that_is_thrown_between_its_flanks_is_told_apart() {
    let (gap, mass, friction) = (30e-6, 100.0, 40.0);
    let step = 1e-4;
    let mut random = Random::new(20_261_127);
    // Strokes of 0.8 s of several speeds with accelerations of up to 1 m/s2, rests of 0.2 s.
    let speed = |t: f64| {
        let phase = t.rem_euclid(1.0);
        let profile = (phase / 0.1).min((0.8 - phase) / 0.1).clamp(0.0, 1.0);
        let forward = (t as u32 % 4 < 2) == (t as u32 % 3 < 2);
        let top = [0.1, 0.05, 0.02, 0.08, 0.035][t as usize % 5];
        (if forward { top } else { -top }) * profile
    };
    let (mut motor, mut load, mut velocity) = (0.0, 0.0, 0.0);
    let (mut time, mut motors, mut loads, mut forces) = (vec![], vec![], vec![], vec![]);
    for tick in 0..200_000 {
        let t = f64::from(tick) * step;
        let (before, now) = (speed(t), speed(t + step));
        // Stiff flanks with a little damping, friction that holds and slides.
        let off: f64 = motor - load;
        let wound = off - off.clamp(-0.5 * gap, 0.5 * gap);
        let contact = if wound == 0.0 {
            0.0
        } else {
            2e8 * wound + 2e4 * (before - velocity)
        };
        let free: f64 = velocity + contact / mass * step;
        let slows = friction / mass * step;
        let last = velocity;
        velocity = if free.abs() <= slows {
            0.0
        } else {
            free - slows * free.signum()
        };
        load += 0.5 * (last + velocity) * step;
        motor += 0.5 * (before + now) * step;
        if tick % 10 == 0 {
            time.push(t);
            motors.push(motor + 1e-8 * random.normal());
            loads.push((load / 1e-7).round() * 1e-7);
            forces.push(contact + 20.0 * (now - before) / step + 2.0 * random.normal());
        }
    }
    let log = BodyLog::from_rows(&time, motors, loads, Vec::new(), forces).unwrap();
    let body = fit_body(&log, &Motion::of(&log)).unwrap();
    let lost = fit_lost_motion(&log, Some(&body)).unwrap();
    let plain = fit_lost_motion(&log, None).unwrap();
    println!("{:?} without friction {:?}", lost.total, plain.total);
    let [low, high] = lost.total.interval;
    let truth = gap + 2.0 * friction / 2e8;
    // Within a count of the scale.
    assert!(low - 1e-7 <= truth && truth <= high + 1e-7 && high - low < 0.2 * truth);
    // Without the force what counts is that the motor speeds up or keeps its speed.
    let [low, high] = plain.total.interval;
    assert!(low - 1e-7 <= truth && truth <= high + 1e-7 && high - low < 0.2 * truth);
}

/// A load that follows its motor at once but for noise: nothing is lost, and no axis gains.
#[test]
fn nothing_lost_is_none_and_no_gain() {
    for seed in 31_700..31_706 {
        let mut random = Random::new(seed);
        let time: Vec<f64> = (0..10_000).map(|sample| f64::from(sample) * 1e-3).collect();
        // Of several speeds: at one a load that is read late would look the same.
        let wide = |t: f64| 0.01 * (2.0 + math::sin(0.7 * t));
        let motor = time.iter().map(|t| wide(*t) * math::sin(6.0 * t));
        let motor: Vec<f64> = motor.collect();
        let load = motor.iter().map(|place| place + 1e-6 * random.normal());
        let load = load.collect();
        let log = BodyLog::from_rows(&time, motor, load, Vec::new(), Vec::new()).unwrap();
        let Ok(lost) = fit_lost_motion(&log, None) else {
            continue;
        };
        let [low, high] = lost.total.interval;
        assert!(
            lost.total.value >= 0.0 && low == 0.0 && high < 8e-6,
            "{seed}: {lost:?}"
        );
    }
}

/// Strokes of some speeds, in turn, of a load behind a gap, read so late; no current.
fn strokes(speeds: &[f64], gap: f64, late_s: f64, seed: u64) -> BodyLog {
    let mut random = Random::new(seed);
    let time: Vec<f64> = (0..30_000).map(|sample| f64::from(sample) * 1e-3).collect();
    // Out and back in 2 s, with accelerations of 1 m/s2.
    let speed = |t: f64| {
        let top = speeds[(t / 2.0) as usize % speeds.len()];
        let phase = t.rem_euclid(1.0);
        let profile = (phase.min(0.9 - phase).max(0.0)).min(top);
        if t.rem_euclid(2.0) < 1.0 {
            profile
        } else {
            -profile
        }
    };
    let steps = 20;
    let (mut motor, mut load) = (0.0, 0.0_f64);
    let (mut motors, mut loads) = (Vec::new(), Vec::new());
    for t in &time {
        for step in 0..steps {
            let fine = 1e-3 / f64::from(steps);
            motor += speed(t + f64::from(step) * fine) * fine;
            load = load.clamp(motor - 0.5 * gap, motor + 0.5 * gap);
        }
        motors.push(motor + 1e-8 * random.normal());
        // So much later is what was so much farther back; what stands is where it was.
        let now = speed(*t);
        let follows = (motor - load - 0.5 * gap * now.signum()).abs() < 1e-9;
        let read = load - if follows { now * late_s } else { 0.0 };
        loads.push((read / 1e-7).round() * 1e-7);
    }
    BodyLog::from_rows(&time, motors, loads, Vec::new(), Vec::new()).unwrap()
}

/// What a load is read late by is no lost motion, where strokes of several speeds tell it.
#[test]
fn lateness_is_taken_off_lost_motion_without_a_current() {
    let gap = 12e-6;
    for (number, late_s) in [-250e-6, -60e-6, 0.0, 60e-6, 150e-6, 350e-6]
        .into_iter()
        .enumerate()
    {
        let log = strokes(
            &[0.05, 0.01, 0.03, 0.002],
            gap,
            late_s,
            33_100 + number as u64,
        );
        let lost = fit_lost_motion(&log, None).unwrap();
        println!("{late_s} {:?}", lost.total);
        let [low, high] = lost.total.interval;
        assert!(
            low <= gap && gap <= high && high - low < 0.1 * gap,
            "{late_s}: {lost:?}"
        );
    }
}

/// Nor is a scale beside it.
#[test]
fn lateness_and_a_scale_together_are_no_lost_motion() {
    let gap = 12e-6;
    let pairs = [
        (350e-6, 20e-6),
        (350e-6, -20e-6),
        (-250e-6, 10e-6),
        (60e-6, 80e-6),
        (150e-6, 3e-6),
    ];
    for (number, (late_s, scale)) in pairs.into_iter().enumerate() {
        let speeds = [0.05, 0.01, 0.03, 0.002];
        let mut log = strokes(&speeds, gap, late_s, 33_500 + number as u64);
        log.load.iter_mut().for_each(|place| *place *= 1.0 + scale);
        let motion = Motion::of(&log);
        let lost = fit_lost_motion(&log.put_right(&motion), None).unwrap();
        println!("{late_s} {scale} {:?}", lost.total);
        let [low, high] = lost.total.interval;
        assert!(
            low <= gap && gap <= high && high - low < 0.15 * gap,
            "{late_s} {scale}: {lost:?}"
        );
    }
}

/// At one speed it looks the same: the interval holds it, or the loss is refused with what would tell it.
#[test]
fn lateness_at_one_speed_is_held_or_refused() {
    for (number, late_s) in [-300e-6, 0.0, 150e-6, 350e-6].into_iter().enumerate() {
        let seed = 33_200 + number as u64;
        // 0.4 ms of 5 mm/s are 2 um on either side.
        let gap = 12e-6;
        let lost = fit_lost_motion(&strokes(&[0.005], gap, late_s, seed), None).unwrap();
        let [low, high] = lost.total.interval;
        println!("{late_s} {:?}", lost.total);
        assert!(
            low <= gap && gap <= high && high - low < 10e-6,
            "{late_s}: {lost:?}"
        );
        // Of 50 mm/s 20 um: more than there is.
        let refused = fit_lost_motion(&strokes(&[0.05], gap, late_s, seed), None);
        match refused {
            Ok(lost) => {
                let [low, high] = lost.total.interval;
                assert!(low <= gap && gap <= high, "{late_s}: {lost:?}");
            }
            Err(why) => assert!(why.contains("several speeds"), "{why}"),
        }
    }
    // Where both are read at the same time it is told again.
    let gap = 12e-6;
    let log = strokes(&[0.05], gap, 0.0, 33_210).read_within(0.0).unwrap();
    let [low, high] = fit_lost_motion(&log, None).unwrap().total.interval;
    assert!(low <= gap && gap <= high && high - low < 0.1 * gap);
}

/// Exchanged columns are found whatever lateness could be.
#[test]
fn a_load_ahead_of_its_motor_is_refused() {
    let log = strokes(&[0.05, 0.01, 0.03, 0.002], 12e-6, 0.0, 33_300);
    let time: Vec<f64> = (0..log.len()).map(|at| 1e-3 * at as f64).collect();
    let swapped = BodyLog::from_rows(&time, log.load, log.motor, Vec::new(), Vec::new()).unwrap();
    let why = fit_lost_motion(&swapped, None).unwrap_err();
    assert!(why.contains("ahead of the motor"), "{why}");
}

/// Rows that are missing are counted, and the rest tells the loss.
#[test]
fn missing_rows_are_counted_and_passed_over() {
    let gap = 12e-6;
    let log = strokes(&[0.05, 0.01, 0.03, 0.002], gap, 0.0, 33_400);
    let kept: Vec<usize> = (0..log.len())
        .filter(|at| !(7_000..7_100).contains(at))
        .collect();
    let of = |column: &[f64]| kept.iter().map(|&at| column[at]).collect::<Vec<f64>>();
    let time: Vec<f64> = kept.iter().map(|&at| 1e-3 * at as f64).collect();
    let cut = BodyLog::from_rows(&time, of(&log.motor), of(&log.load), Vec::new(), Vec::new());
    let cut = cut.unwrap();
    assert_eq!((log.missing_rows(), cut.missing_rows()), (0, 100));
    let [low, high] = fit_lost_motion(&cut, None).unwrap().total.interval;
    assert!(low <= gap && gap <= high, "{low} to {high}");
}
