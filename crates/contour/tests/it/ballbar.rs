//! Sheets of a ballbar made of known errors: the values come back, their intervals cover, and what
//! cannot be told is said to be.

use lostmotion_base::random::Random;
use lostmotion_base::{AxisId, Plane, math};
use lostmotion_contour::ballbar::{BallbarSheet, BallbarTrace, Explained, sheet};
use lostmotion_contour::{Circle, RadialPoint};

const RADIUS_MM: f64 = 100.0;

/// Errors of two axes, mm and parts.
#[derive(Clone, Copy, Default)]
struct Errors {
    lost: [f64; 2],
    square: f64,
    scale: f64,
    /// How far X is behind Y.
    lag: f64,
    center: [f64; 2],
    spike: f64,
    noise: f64,
}

fn circle() -> Circle {
    Circle {
        plane: Plane::Xy,
        center_mm: [0.0; 2],
        radius_mm: RADIUS_MM,
    }
}

/// The trace of a machine with these errors: its tip is put together axis by axis.
fn trace(
    errors: &Errors,
    ccw: bool,
    from_deg: f64,
    to_deg: f64,
    random: &mut Random,
) -> BallbarTrace {
    let sense = if ccw { 1.0 } else { -1.0 };
    let count = ((to_deg - from_deg) / 0.1).round() as i32;
    let points = (0..count).map(|index| {
        let deg = if ccw {
            from_deg + 0.1 * f64::from(index)
        } else {
            to_deg - 0.1 * f64::from(index)
        };
        let angle = (deg + 0.05 * sense).to_radians();
        let (sin, cos) = math::sin_cos(angle);
        let velocity = [-sin * sense, cos * sense];
        let (mut x, mut y) = (RADIUS_MM * cos, RADIUS_MM * sin);
        // Behind the reversal of either axis it sticks for 8 degrees.
        let past = (sense * deg).rem_euclid(90.0);
        let stuck = if past < 8.0 {
            errors.spike * (1.0 - past / 8.0)
        } else {
            0.0
        };
        (x, y) = (
            x + errors.scale * x + errors.square * y
                - errors.lag * velocity[0]
                - 0.5 * errors.lost[0] * velocity[0].signum()
                + errors.center[0],
            y - 0.5 * errors.lost[1] * velocity[1].signum() + errors.center[1],
        );
        RadialPoint {
            angle_rad: angle,
            deviation_mm: math::hypot(x, y) - RADIUS_MM + stuck + errors.noise * random.normal(),
        }
    });
    BallbarTrace::new(points.collect())
}

fn both(errors: &Errors, random: &mut Random) -> BallbarSheet {
    let traces = [true, false].map(|ccw| trace(errors, ccw, -20.0, 380.0, random));
    sheet(&circle(), &traces).unwrap()
}

const KNOWN: Errors = Errors {
    lost: [0.008, 0.005],
    square: 20e-6,
    scale: -30e-6,
    lag: 0.006,
    center: [0.012, -0.007],
    spike: 0.0,
    noise: 0.0,
};

fn value(found: Option<Explained>) -> f64 {
    found.unwrap().value
}

#[test]
fn known_errors_come_back() {
    for spike in [0.0, 0.004] {
        let found = both(&Errors { spike, ..KNOWN }, &mut Random::new(1));
        // Second order in the centre's shift: 12^2 um^2 / 2 / 100 mm.
        let near = |found: f64, expected: f64, within: f64| {
            assert!((found - expected).abs() < within, "{found} {expected}");
        };
        near(value(found.lost_motion_um[0]), 8.0, 0.03);
        near(value(found.lost_motion_um[1]), 5.0, 0.03);
        near(value(found.squareness_um_m), 20.0, 0.2);
        near(value(found.scale_um_m), -30.0, 0.2);
        near(value(found.mismatch_um), 6.0, 0.03);
        near(value(found.center_um[0]), 12.0, 0.03);
        near(value(found.center_um[1]), -7.0, 0.03);
        assert!(found.untold.is_empty(), "{:?}", found.untold);
        assert_eq!(found.reversals.len(), 8);
        for mark in &found.reversals {
            let expected = if mark.axis == AxisId::X { 8.0 } else { 5.0 };
            near(mark.step_um, expected, 0.6);
            near(mark.spike_um, 1e3 * spike, 0.5);
        }
    }
}

/// Sheets with a sample each degree, at whole degrees, where parts of the turn begin.
#[test]
fn few_samples_at_round_angles_tell_the_same() {
    for step in [5, 10, 20] {
        let traces = [true, false].map(|ccw| {
            let whole = trace(&KNOWN, ccw, -0.05, 360.0, &mut Random::new(1));
            let points = whole.points.into_iter().step_by(step);
            BallbarTrace::new(points.collect())
        });
        let found = sheet(&circle(), &traces).unwrap();
        assert!(found.untold.is_empty(), "{:?}", found.untold);
        assert_eq!(found.reversals.len(), 8);
        for (told, expected) in [
            (found.lost_motion_um[0], 8.0),
            (found.lost_motion_um[1], 5.0),
            (found.squareness_um_m, 20.0),
            (found.scale_um_m, -30.0),
            (found.mismatch_um, 6.0),
        ] {
            assert!((value(told) - expected).abs() < 0.1, "{told:?} {expected}");
        }
    }
}

/// The gap of an axis is no servo mismatch: the second harmonic of its steps is another one.
#[test]
fn lost_motion_does_not_pass_for_mismatch() {
    let only = Errors {
        lost: [0.020, 0.0],
        ..Errors::default()
    };
    let found = both(&only, &mut Random::new(1));
    assert!(value(found.mismatch_um).abs() < 0.01 && value(found.lost_motion_um[1]).abs() < 0.01);
    assert!((value(found.lost_motion_um[0]) - 20.0).abs() < 0.01);
}

/// G, F and H by hand: a circle of 10 um larger radius one way and its centre off.
#[test]
fn values_of_the_standard_by_hand() {
    let made = |ccw: bool, larger: f64| {
        let points = (0..3600).map(|tenth| {
            let deg = 0.1 * f64::from(if ccw { tenth } else { 3600 - tenth });
            RadialPoint {
                angle_rad: deg.to_radians(),
                deviation_mm: larger + 0.003 * math::cos(deg.to_radians()),
            }
        });
        BallbarTrace::new(points.collect())
    };
    let found = sheet(&circle(), &[made(true, 0.010), made(false, 0.004)]).unwrap();
    assert!(found.senses[0].counterclockwise && !found.senses[1].counterclockwise);
    for (sense, mean) in found.senses.iter().zip([10.0, 4.0]) {
        // The centre is taken out of G, not of F.
        assert!(sense.g_um < 1e-6 && (sense.mean_um - mean).abs() < 1e-6);
        assert!(
            (sense.f_um[0] - (mean - 3.0)).abs() < 1e-3
                && (sense.f_um[1] - (mean + 3.0)).abs() < 1e-3
        );
    }
    assert!((found.h_um.unwrap() - 6.0).abs() < 0.03);
    assert!(
        (found.g_both_um.unwrap() - 6.0).abs() < 1e-6 && (found.d_um.unwrap() - 7.0).abs() < 1e-6
    );
}

/// 200 machines drawn at random, with noise and spikes: the intervals cover about as often as they
/// say, and are no wider than they have to be.
#[test]
fn intervals_cover() {
    let mut random = Random::new(20);
    let (mut covered, mut all) = (0, 0);
    let (mut halves, mut errors_of_all) = ([0.0; 7], [0.0; 7]);
    for _ in 0..200 {
        let um = 1e-3;
        let errors = Errors {
            lost: [
                random.between(0.0, 20.0) * um,
                random.between(0.0, 20.0) * um,
            ],
            square: random.between(-50e-6, 50e-6),
            scale: random.between(-50e-6, 50e-6),
            lag: random.between(-10.0, 10.0) * um,
            center: [
                random.between(-5.0, 5.0) * um,
                random.between(-5.0, 5.0) * um,
            ],
            spike: random.between(0.0, 5.0) * um,
            noise: random.between(0.2, 1.0) * um,
        };
        let found = both(&errors, &mut random);
        let expected = [
            (found.lost_motion_um[0], 1e3 * errors.lost[0]),
            (found.lost_motion_um[1], 1e3 * errors.lost[1]),
            (found.squareness_um_m, 1e6 * errors.square),
            (found.scale_um_m, 1e6 * errors.scale),
            (found.mismatch_um, 1e3 * errors.lag),
            (found.center_um[0], 1e3 * errors.center[0]),
            (found.center_um[1], 1e3 * errors.center[1]),
        ];
        for (place, (told, truth)) in expected.into_iter().enumerate() {
            let found = told.unwrap();
            let [low, high] = found.interval;
            covered += u32::from((low..=high).contains(&truth));
            all += 1;
            halves[place] += 0.25 * (high - low) * (high - low);
            errors_of_all[place] += (found.value - truth) * (found.value - truth);
        }
    }
    let share = f64::from(covered) / f64::from(all);
    assert!((0.92..=0.99).contains(&share), "{share}");
    // Two standard deviations of what the errors really are, and little more.
    for (half, error) in halves.iter().zip(errors_of_all) {
        let ratio = (half / error).sqrt();
        assert!((1.8..2.8).contains(&ratio), "{ratio}");
    }
}

#[test]
fn what_one_sense_or_a_part_of_the_circle_cannot_tell_is_said() {
    let mut random = Random::new(2);
    let one = sheet(&circle(), &[trace(&KNOWN, true, 0.0, 360.0, &mut random)]).unwrap();
    assert_eq!(
        (one.squareness_um_m, one.mismatch_um, one.h_um),
        (None, None, None)
    );
    // Together they are (a R + d) / R.
    assert!(
        one.untold[0].contains("one sense of rotation") && one.untold[0].contains("80.0 um/m"),
        "{}",
        one.untold[0]
    );
    assert!((value(one.lost_motion_um[0]) - 8.0).abs() < 0.05);
    // From 20 to 70 degrees no axis reverses.
    let arcs = [true, false].map(|ccw| trace(&KNOWN, ccw, 20.0, 70.0, &mut random));
    let part = sheet(&circle(), &arcs).unwrap();
    assert!(
        part.untold
            .iter()
            .any(|why| why.starts_with("G, F and H of the whole circle: 50 deg")),
        "{:?}",
        part.untold
    );
    // Half a circle has the reversal of Y in its middle, and nothing of X behind its own.
    let half = [true, false].map(|ccw| trace(&KNOWN, ccw, 0.0, 180.0, &mut random));
    let half = sheet(&circle(), &half).unwrap();
    assert!(
        (value(half.lost_motion_um[1]) - 5.0).abs() < 0.2,
        "{half:?}"
    );
}

#[test]
fn nonsense_is_refused() {
    assert!(sheet(&circle(), &[]).is_err());
    let few = BallbarTrace::new(
        (0..5)
            .map(|n| RadialPoint {
                angle_rad: f64::from(n),
                deviation_mm: 0.0,
            })
            .collect(),
    );
    assert!(sheet(&circle(), &[few]).is_err());
    let short = BallbarTrace::new(
        (0..100)
            .map(|n| RadialPoint {
                angle_rad: 1e-3 * f64::from(n),
                deviation_mm: 0.0,
            })
            .collect(),
    );
    assert!(
        sheet(&circle(), &[short])
            .unwrap_err()
            .to_string()
            .contains("all around")
    );
    let none = Circle {
        radius_mm: 0.0,
        ..circle()
    };
    let trace = trace(&KNOWN, true, 0.0, 360.0, &mut Random::new(1));
    assert!(sheet(&none, &[trace]).is_err());
}

/// A part of the circle: its mean about its own centre is none of the whole; where the errors of the axes
/// are told their mean is, within its interval, and else nothing is.
#[test]
fn the_mean_of_a_part_is_told_with_its_interval_or_not_at_all() {
    let mut random = Random::new(4_711);
    let errors = Errors {
        scale: 2e-4,
        noise: 2e-4,
        ..KNOWN
    };
    let of = |from_deg: f64, to_deg: f64, random: &mut Random| {
        let traces = [true, false].map(|ccw| trace(&errors, ccw, from_deg, to_deg, random));
        sheet(&circle(), &traces).unwrap()
    };
    let whole = of(-20.0, 380.0, &mut random);
    let about_mean = |found: &BallbarSheet| -> Vec<String> {
        let all = found.untold.iter();
        all.filter(|told| told.contains("mean radial deviation of the whole"))
            .cloned()
            .collect()
    };
    assert!(about_mean(&whole).is_empty());
    // scale of one axis alone: half of it on the mean, 10 um
    let truth = 0.5 * errors.scale * 1e3 * RADIUS_MM;
    assert!(
        (whole.d_um.unwrap() - truth).abs() < 0.3,
        "{:?}",
        whole.d_um
    );
    for to_deg in [220.0, 300.0] {
        let part = of(0.0, to_deg, &mut random);
        let told = about_mean(&part);
        let numbers: Vec<f64> = told[0]
            .rsplit_once("whole is ")
            .unwrap_or_else(|| panic!("{told:?}"))
            .1
            .split(|letter: char| !(letter.is_ascii_digit() || matches!(letter, '.' | '-')))
            .filter_map(|number| number.parse().ok())
            .collect();
        let [_, _, low, high] = numbers[..] else {
            panic!("{told:?}");
        };
        assert!((low..=high).contains(&truth), "{told:?}");
    }
    let part = of(0.0, 70.0, &mut random);
    assert!(about_mean(&part)[0].contains("cannot be told, because the record covers only 70 deg"));
}

/// On a short arc scale or squareness is left out; the centre and the others then hold a part of it, and
/// their intervals say so.
#[test]
fn intervals_cover_on_a_part_of_the_circle() {
    let mut random = Random::new(61_003);
    let (mut held, mut told) = ([0; 4], [0; 4]);
    for _ in 0..60 {
        let errors = Errors {
            lost: [random.between(0.0, 0.01), random.between(0.0, 0.01)],
            square: random.between(-40e-6, 40e-6),
            scale: random.between(-40e-6, 40e-6),
            center: [random.between(-0.02, 0.02), random.between(-0.02, 0.02)],
            noise: 2e-4,
            ..Errors::default()
        };
        let from_deg = random.between(0.0, 360.0);
        let arcs =
            [true, false].map(|ccw| trace(&errors, ccw, from_deg, from_deg + 90.0, &mut random));
        let found = sheet(&circle(), &arcs).unwrap();
        let pairs = [
            (found.center_um[0], 1e3 * errors.center[0]),
            (found.center_um[1], 1e3 * errors.center[1]),
            (found.scale_um_m, 1e6 * errors.scale),
            (found.squareness_um_m, 1e6 * errors.square),
        ];
        for (place, (found, truth)) in pairs.into_iter().enumerate() {
            let Some(found) = found else { continue };
            told[place] += 1;
            let [low, high] = found.interval;
            held[place] += usize::from(low <= truth && truth <= high);
        }
    }
    for (held, told) in held.into_iter().zip(told) {
        assert!(told >= 10 && 10 * held >= 9 * told, "{held} of {told}");
    }
}
