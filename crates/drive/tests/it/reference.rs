//! The reference spline against motions with closed forms.

use lostmotion_base::math;
use lostmotion_drive::config::{Interpolator, Linear, Transmission};
use lostmotion_drive::reference::Spline;
use lostmotion_drive::{AxisError, Reference, Setpoint};
use lostmotion_methods::AxisConfig;
use lostmotion_rig::{Motion, Move};

const NM: f64 = 1e-6;

fn millimetres(interpolator: Interpolator) -> Spline {
    // a lead of 2 pi makes a motor rad a millimetre
    let transmission = Transmission::Linear(Linear {
        lead_mm: std::f64::consts::TAU,
        gear: 1.0,
    });
    Spline::new(&AxisConfig {
        transmission,
        interpolator,
        ..AxisConfig::paper()
    })
}

/// Largest error of position, velocity and acceleration at the servo ticks, and largest step of the
/// acceleration between pieces.
fn worst(spline: &Spline, motion: Motion, seconds: f64) -> [f64; 4] {
    let delay = f64::from(spline.delay_ticks()) * 1e-3;
    let mut state = spline.initial(motion(0.0).0);
    let mut worst = [0.0_f64; 4];
    let mut end: Option<Reference> = None;
    for n in 0..(seconds * 1e3) as usize {
        let (position, velocity, acceleration) = motion(n as f64 * 1e-3);
        let sent = Setpoint::moving(position, velocity, acceleration);
        assert_eq!(spline.push(&mut state, &sent), Ok(()));
        let start = spline.at(&state, 0, 4);
        if let Some(end) = end {
            assert_eq!(end, start, "pieces have to meet");
        }
        end = Some(spline.at(&state, 4, 4));
        // the ends of a piece as its inside sees them
        let inside = spline.at(&state, 1_000_000 - 1, 1_000_000);
        if n > 6 {
            worst[3] =
                worst[3].max((inside.acceleration - spline.at(&state, 4, 4).acceleration).abs());
        }
        for j in 0..4 {
            let r = spline.at(&state, j, 4);
            let t = n as f64 * 1e-3 + f64::from(j) * 0.25e-3 - delay;
            if t > 6e-3 {
                let (p, v, a) = motion(t);
                worst[0] = worst[0].max((r.position - p).abs());
                worst[1] = worst[1].max((r.velocity - v).abs());
                worst[2] = worst[2].max((r.acceleration - a).abs());
            }
        }
    }
    worst
}

fn circle(t: f64) -> (f64, f64, f64) {
    // R 10 mm at 12 m/min, away from the origin
    let w = 20.0;
    let (s, c) = math::sin_cos(w * t);
    (300.0 + 10.0 * s, 10.0 * w * c, -10.0 * w * w * s)
}

/// 60 m/min, 6 m/s2, 150 m/s3; its switches fall between setpoints.
const RAPID: Move = Move {
    distance: 500.0,
    velocity: 1000.0,
    acceleration: 6000.0,
    jerk: 150_000.7,
};

#[test]
fn with_derivatives_sent_along_the_error_is_below_a_tenth_of_a_nanometre() {
    let spline = millimetres(Interpolator::QuinticHermite);
    let [p, v, a, step] = worst(&spline, &circle, 1.0);
    assert!(p < 1e-4 * NM && v < 1e-6 && a < 1e-3, "{p} {v} {a}");
    assert!(step < 1.0, "{step}");
    let [p, ..] = worst(&spline, &|t| RAPID.at(t - 0.010_3), 1.0);
    assert!(
        p < 1.0 * NM,
        "at a jerk of 150 m/s3 that switches within a piece: {p}"
    );
}

#[test]
fn positions_alone_are_good_to_a_few_nanometres() {
    let spline = millimetres(Interpolator::QuinticDifferences);
    assert_eq!(spline.delay_ticks(), 3);
    let [p, v, a, step] = worst(&spline, &circle, 1.0);
    assert!(p < 1e-2 * NM && v < 1e-3 && a < 1.0, "{p} {v} {a}");
    assert!(step < 1.0, "{step}");
    let [p, ..] = worst(&spline, &|t| RAPID.at(t - 0.010_3), 1.0);
    assert!(p < 10.0 * NM, "{p}");
}

#[test]
fn constant_velocity_stays_constant() {
    for source in [
        Interpolator::QuinticHermite,
        Interpolator::QuinticDifferences,
    ] {
        let [p, v, a, _] = worst(
            &millimetres(source),
            &|t| (700.0 + 83.0 * t, 83.0, 0.0),
            0.5,
        );
        assert!(p < 1e-12 * 1e3 && v < 1e-8 && a < 1e-4, "{p} {v} {a}");
    }
}

#[test]
fn incomplete_and_infinite_setpoints_are_refused_with_their_number() {
    let spline = millimetres(Interpolator::QuinticHermite);
    let mut state = spline.initial(0.0);
    let good = Setpoint::moving(0.0, 0.0, 0.0);
    spline.push(&mut state, &good).unwrap();
    let error = spline
        .push(
            &mut state,
            &Setpoint {
                velocity: None,
                ..good
            },
        )
        .unwrap_err();
    assert_eq!(
        error,
        AxisError::SetpointIncomplete {
            tick: 1,
            what: "velocity"
        }
    );
    let error = spline
        .push(
            &mut state,
            &Setpoint {
                position: f64::NAN,
                ..good
            },
        )
        .unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("setpoint 1: its position is NaN"),
        "{error}"
    );
}

/// A motion of constant jerk that stops, or starts, anywhere within a command cycle: the reference never
/// turns round.
#[test]
fn a_reference_that_stops_does_not_turn_round() {
    for interpolator in [Interpolator::QuinticHermite, Interpolator::CubicHermite] {
        let spline = millimetres(interpolator);
        for (stop, jerk) in (1..50).flat_map(|n| {
            let at = 0.02 + f64::from(n) * 1e-3 / 50.0;
            [(at, 50_000.0), (at, -1e6)]
        }) {
            // braking to rest at `stop`, and from there on again
            let away = |t: f64, start: f64| {
                let s = (t - start).max(0.0);
                (s * s * s / 6.0, 0.5 * s * s, s)
            };
            let motion = |t: f64| {
                let (before, after) = (away(stop, t), away(t, stop + 0.02));
                [after.0 - before.0, after.1 + before.1, after.2 - before.2].map(|x| jerk * x)
            };
            let mut state = spline.initial(motion(0.0)[0]);
            let mut last = motion(0.0)[0];
            for n in 0..60 {
                let [position, velocity, acceleration] = motion(f64::from(n) * 1e-3);
                let sent = Setpoint::moving(position, velocity, acceleration);
                assert_eq!(spline.push(&mut state, &sent), Ok(()));
                for j in 0..16 {
                    let r = spline.at(&state, j, 16);
                    if n > 1 {
                        let way = (r.position - last) * jerk.signum();
                        assert!(way > -NM, "{interpolator:?} {stop} {n} {j}: {way}");
                        assert!(r.velocity * jerk.signum() > -1e-12, "{r:?}");
                    }
                    last = r.position;
                }
            }
        }
    }
}
