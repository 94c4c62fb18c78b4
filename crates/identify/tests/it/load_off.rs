//! A load's scale that is longer than the motor's, and one that is read later: neither is a gap.

use crate::rig::ballscrew::{BallScrew, Rows};
use lostmotion_base::{Random, math};
use lostmotion_identify::body::{BodyLog, LoadOff, Motion, fit_lost_motion};
use lostmotion_identify::{BacklashFit, BacklashLog, FitSettings, Presumed, fit_backlash};

/// Counts what holds the truth of ten axes: gap, stiffness, and how the load was said to be off.
fn holds(seed: u64, change: impl Fn(&mut Rows), truth: [f64; 2]) -> [usize; 3] {
    let mut held = [0; 3];
    for seed in seed..seed + 10 {
        let axis = BallScrew::random(seed);
        let mut rows = axis.record();
        change(&mut rows);
        // One that refuses to tell holds nothing.
        let found = fit_backlash(&axis.log(&rows).unwrap(), &axis.settings());
        let Ok(fit): Result<BacklashFit, _> = found else {
            continue;
        };
        let [low, high] = fit.half_gap_interval_rad;
        held[0] += usize::from(low <= axis.half_gap() && axis.half_gap() <= high);
        let [low, high] = fit.stiffness_interval_nm_per_rad;
        held[1] += usize::from(
            low.is_none_or(|low| low <= axis.stiffness())
                && high.is_none_or(|high| axis.stiffness() <= high),
        );
        let Some(off) = fit.load_off else { continue };
        let within = |[low, high]: [f64; 2], truth: f64| {
            (truth == 0.0 && low == high) || (low <= truth && truth <= high)
        };
        held[2] += usize::from(
            within(off.scale_interval, truth[0]) && within(off.late_interval_s, truth[1]),
        );
    }
    held
}

#[test]
fn a_scale_that_is_longer_than_the_screw_is_no_gap() {
    let longer = |rows: &mut Rows| rows.load_mm.iter_mut().for_each(|mm| *mm *= 1.0 + 80e-6);
    let held = holds(94_100, longer, [80e-6, 0.0]);
    assert!(held.iter().all(|held| *held >= 9), "{held:?}");
}

#[test]
fn a_load_that_is_read_late_is_no_gap() {
    let later = |rows: &mut Rows| {
        // one row late
        rows.load_mm.rotate_right(1);
        rows.load_mm[0] = rows.load_mm[1];
    };
    let [gap, stiffness, off] = holds(94_200, later, [0.0, 1e-3]);
    // The softest shafts come out too stiff by a few parts in a thousand.
    assert!(
        gap >= 8 && stiffness >= 7 && off >= 9,
        "{gap} {stiffness} {off}"
    );
}

#[test]
fn nothing_is_taken_off_a_load_that_goes_with_its_motor() {
    for seed in 94_300..94_310 {
        let axis = BallScrew::random(seed);
        let fit = fit_backlash(&axis.log(&axis.record()).unwrap(), &axis.settings()).unwrap();
        assert_eq!(fit.load_off, None, "{seed}");
    }
}

/// The load read so many rows late, by a parabola through three rows.
fn late_by(rows: &mut Rows, part: f64) {
    let read = |three: &[f64]| {
        let [before, at, after] = [three[0], three[1], three[2]];
        at - 0.5 * part * (after - before) + 0.5 * part * part * (after - 2.0 * at + before)
    };
    let inner: Vec<f64> = rows.load_mm.windows(3).map(read).collect();
    let last = rows.load_mm.len() - 1;
    rows.load_mm[1..last].copy_from_slice(&inner);
}

#[test]
fn a_load_that_is_read_a_part_of_a_row_late_is_no_gap() {
    for part in [0.25, -0.1] {
        let [gap, stiffness, off] = holds(94_400, |rows| late_by(rows, part), [0.0, part * 1e-3]);
        assert!(
            gap >= 9 && stiffness >= 8 && off >= 8,
            "{part}: {gap} {stiffness} {off}"
        );
    }
}

/// Neither hides the other, whichever way each is off.
#[test]
fn a_scale_and_lateness_together_are_no_gap() {
    let pairs = [(0.35, 20e-6), (0.35, -20e-6), (-0.2, 10e-6), (0.1, 40e-6)];
    let mut all = [0; 3];
    for (number, (part, scale)) in pairs.into_iter().enumerate() {
        let both = |rows: &mut Rows| {
            late_by(rows, part);
            rows.load_mm.iter_mut().for_each(|mm| *mm *= 1.0 + scale);
        };
        let held = holds(94_500 + 10 * number as u64, both, [scale, part * 1e-3]);
        println!("{part} {scale}: {held:?}");
        (0..3).for_each(|at| all[at] += held[at]);
    }
    let [gap, stiffness, off] = all;
    assert!(gap >= 33 && stiffness >= 28 && off >= 28, "{all:?}");
}

/// Strokes at 10 rad/s by a shaft whose stiffness is known, with a load that is read so much late: lateness is
/// the same as a gap.
fn one_speed(half_gap: f64, late_s: f64) -> (BacklashLog, FitSettings) {
    let (speed, torque, stiffness, stroke_s) = (10.0, 1.0, 500.0, 0.2);
    let (mut motor, mut load, mut current) = (Vec::new(), Vec::new(), Vec::new());
    for row in 0..8000 {
        let within = (f64::from(row) * 250e-6 / stroke_s).rem_euclid(2.0);
        let (place, side) = if within < 1.0 {
            (within, 1.0)
        } else {
            (2.0 - within, -1.0)
        };
        let wound = half_gap + torque / stiffness;
        motor.push(speed * stroke_s * place);
        load.push(speed * stroke_s * place - side * (wound + late_s * speed));
        current.push(side * torque);
    }
    let settings = FitSettings {
        motor_inertia_kgm2: Some(0.0),
        stiffness_nm_per_rad: Some(stiffness),
        fit_damping: false,
        ..FitSettings::default()
    };
    let log = BacklashLog::new(250e-6, motor, load, current).unwrap();
    (log, settings)
}

#[test]
fn at_one_speed_the_interval_of_the_gap_holds_what_lateness_may_be() {
    let half_gap = 20e-3;
    for late_s in [0.0, 250e-6, -250e-6] {
        let (log, settings) = one_speed(half_gap, late_s);
        let fit = fit_backlash(&log, &settings).unwrap();
        let [low, high] = fit.half_gap_interval_rad;
        assert!(low <= half_gap && half_gap <= high, "{late_s}: {fit:?}");
        // 0.4 ms at this speed
        let lateness = fit.half_gap_lateness_rad;
        assert!((lateness / 4e-3 - 1.0).abs() < 1e-2, "{fit:?}");
    }
}

#[test]
fn a_gap_that_lateness_may_be_is_refused_with_what_would_tell_it() {
    let (log, settings) = one_speed(5e-3, 0.0);
    let error = fit_backlash(&log, &settings).unwrap_err().to_string();
    assert!(
        error.contains("later or earlier") && error.contains("several speeds"),
        "{error}"
    );
}

#[test]
fn lateness_that_a_fit_found_is_no_lost_motion() {
    let late = LoadOff {
        late_s: 300e-6,
        ..LoadOff::default()
    };
    let times: Vec<f64> = (0..4000).map(|row| f64::from(row) * 1e-3).collect();
    let place = |t: f64| 0.05 * math::sin(3.0 * t);
    let motor: Vec<f64> = times.iter().map(|t| place(*t)).collect();
    let load = times.iter().map(|t| place(t - late.late_s)).collect();
    let log = BodyLog::from_rows(&times, motor, load, Vec::new(), Vec::new()).unwrap();
    let right = log.clone().with_late_taken_off(late);
    let off = |log: &BodyLog| {
        let pairs = log.motor.iter().zip(&log.load).skip(2).take(3990);
        pairs.fold(0.0, |most: f64, (motor, load)| {
            most.max((motor - load).abs())
        })
    };
    assert!(off(&log) > 4e-5 && off(&right) < 1e-9, "{:e}", off(&right));
    assert_eq!(right.load_off(), Some(&late));
    // Once is enough.
    assert_eq!(right.clone().with_late_taken_off(late), right);
}

/// Two turns of a ballbar: radius 150 mm at 1 m/min, with rests before and behind, the load behind a gap of 10 um
/// and read in steps of 0.1 um by a scale that is off by so much.
fn ballbar(scale: f64, random: &mut Random) -> [Vec<f64>; 3] {
    let (radius, rate, gap) = (0.15, 1.0 / 60.0 / 0.15, 10e-6);
    let turning = 2.0 * 2.0 * std::f64::consts::PI / rate;
    let (mut time, mut motors, mut loads) = (Vec::new(), Vec::new(), Vec::new());
    let mut load = radius - 0.5 * gap;
    for sample in 0..115_000 {
        let t = f64::from(sample) * 1e-3;
        let motor = radius * math::cos(rate * (t - 1.0).clamp(0.0, turning));
        load = load.clamp(motor - 0.5 * gap, motor + 0.5 * gap);
        let read = load * (1.0 + scale) + 5e-8 * random.normal();
        time.push(t);
        motors.push(motor);
        loads.push((read / 1e-7).round() * 1e-7);
    }
    [time, motors, loads]
}

/// Place and acceleration are one in a sine: a scale would be told as what is lost along the travel, of 20 um/m as
/// 12 um beside the 10 um of the gap.
#[test]
fn a_scale_is_told_in_the_slow_circle_of_a_ballbar() {
    let mut random = Random::new(1_130_001);
    for scale in [0.0, 20e-6, -20e-6, 60e-6, -60e-6] {
        let [time, motors, loads] = ballbar(scale, &mut random);
        let log = BodyLog::from_rows(&time, motors, loads, vec![], vec![]).unwrap();
        let motion = Motion::of(&log);
        let log = log.put_right(&motion);
        let off = log.load_off().map_or(0.0, |off| off.scale);
        assert!((off - scale).abs() < 4e-6, "{off} for {scale}");
        let lost = fit_lost_motion(&log, None).unwrap().total;
        let [low, high] = lost.interval;
        assert!(
            low <= 10e-6 && (10e-6..15e-6).contains(&high),
            "{scale}: {lost:?}"
        );
    }
}

/// In strokes of one frequency the torque hardly changes on a flank, and what is left of a scale passes for wind-up:
/// the interval holds the gap that goes with the described stiffness, and says so.
#[test]
fn a_stiffness_unlike_the_described_one_widens_the_interval() {
    let mut joined = 0;
    for seed in 1_130_100..1_130_110 {
        let axis = BallScrew::random(seed);
        let log = axis.log(&axis.record()).unwrap();
        let plain = fit_backlash(&log, &axis.settings()).unwrap();
        assert_eq!(plain.otherwise, []);
        let settings = |factor: f64| FitSettings {
            known_stiffness_nm_per_rad: Some(factor * axis.stiffness()),
            ..axis.settings()
        };
        // what catalogues are off by is none of the log's business
        for factor in [0.6, 1.0, 1.6] {
            assert_eq!(fit_backlash(&log, &settings(factor)).unwrap(), plain);
        }
        let fit = fit_backlash(&log, &settings(8.0)).unwrap();
        let [other] = fit.otherwise.as_slice() else {
            continue;
        };
        assert_eq!(other.presumed, Presumed::DescribedStiffness);
        let [low, high] = fit.half_gap_interval_rad;
        assert!(low <= other.half_gap_rad && other.half_gap_rad <= high);
        let [low, high] = plain.half_gap_interval_rad;
        assert!(fit.half_gap_interval_rad[0] <= low && high <= fit.half_gap_interval_rad[1]);
        assert_eq!(fit.half_gap_rad, plain.half_gap_rad);
        joined += 1;
    }
    assert!(joined >= 8, "{joined}");
}
