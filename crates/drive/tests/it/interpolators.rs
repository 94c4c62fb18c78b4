//! Every interpolator on the two motions that it is documented with: position error against the
//! motion itself, and jerk against its jerk.
//!
//! `UPDATE_DOCS=1 cargo test -p lostmotion-drive --test it interpolators` writes the table of
//! docs/book/src/model/interpolation.md.

use lostmotion_base::math;
use lostmotion_drive::config::{Cycles, Interpolator, Linear, Transmission};
use lostmotion_drive::reference::Spline;
use lostmotion_drive::{Reference, Setpoint};
use lostmotion_methods::AxisConfig;
use lostmotion_rig::{Motion, Move};
use std::fmt::Write as _;
use std::path::Path;

/// 100 mm/s, 1 m/s2, 30 m/s3; the switches of its jerk fall on setpoints and between them.
const LINE: Move = Move {
    distance: 30.0,
    velocity: 100.0,
    acceleration: 1000.0,
    jerk: 30_000.0,
};
/// Places in a command cycle at which the line sets out; the first is at a setpoint.
const PHASES: u32 = 16;
/// Circle at the acceleration of the line, mm.
const RADIUS: f64 = 5.0;

fn spline(interpolator: Interpolator, cycles: Cycles) -> Spline {
    // a lead of 2 pi makes a motor rad a millimetre
    let transmission = Transmission::Linear(Linear {
        lead_mm: std::f64::consts::TAU,
        gear: 1.0,
    });
    Spline::new(&AxisConfig {
        transmission,
        interpolator,
        cycles,
        ..AxisConfig::paper()
    })
}

fn circle(t: f64) -> (f64, f64, f64) {
    let w = (LINE.acceleration / RADIUS).sqrt();
    let (s, c) = math::sin_cos(w * t);
    (RADIUS * s, RADIUS * w * c, -RADIUS * w * w * s)
}

/// Largest error of the position at the servo ticks, nm, and largest third difference of the
/// positions over them.
fn measure(spline: &Spline, cycles: Cycles, motion: Motion, seconds: f64) -> [f64; 2] {
    let (command, servo, count) = (
        cycles.command(),
        cycles.servo(),
        cycles.servo_ticks() as u32,
    );
    let delay = command.seconds(u64::from(spline.delay_ticks()));
    let mut state = spline.initial(motion(0.0).0);
    let (mut worst, mut jerk, mut last) = (0.0_f64, 0.0_f64, Vec::<f64>::new());
    for n in 0..(seconds / command.period_s()) as u64 {
        let (position, velocity, acceleration) = motion(command.seconds(n));
        spline
            .push(
                &mut state,
                &Setpoint::moving(position, velocity, acceleration),
            )
            .unwrap();
        for j in 0..count {
            let time = command.seconds(n) + servo.seconds(u64::from(j)) - delay;
            if n < 8 {
                continue;
            }
            let position = spline.at(&state, j, count).position;
            worst = worst.max((position - motion(time).0).abs());
            last.push(position);
            if let [.., a, b, c, d] = last[..] {
                jerk =
                    jerk.max((d - 3.0 * c + 3.0 * b - a).abs() / math::pow(servo.period_s(), 3.0));
            }
        }
    }
    [worst * 1e6, jerk]
}

/// Position error, nm, and jerk over the motion's own: the worst of the line, at so many phases,
/// and the circle.
fn figures(interpolator: Interpolator, cycles: Cycles, phases: u32) -> [f64; 2] {
    let spline = spline(interpolator, cycles);
    let period = cycles.command().period_s();
    let own_jerk = LINE.acceleration * (LINE.acceleration / RADIUS).sqrt();
    let [mut error, jerk] = measure(&spline, cycles, &circle, 0.5);
    let mut jerk = jerk / own_jerk;
    for phase in 0..phases {
        let start = 0.02 + period * f64::from(phase) / f64::from(PHASES);
        let [e, j] = measure(
            &spline,
            cycles,
            &|t| LINE.at(t - start),
            LINE.duration() + 0.06,
        );
        (error, jerk) = (error.max(e), jerk.max(j / LINE.jerk));
    }
    [error, jerk]
}

fn table() -> String {
    let mut table = String::from(
        "| name | delay | needs | position error, nm | jerk over the motion's | the same, any phase |\n|---|---|---|---|---|---|\n",
    );
    for interpolator in Interpolator::ALL {
        let [error, jerk] = figures(interpolator, Cycles::default(), 1);
        let [any_error, any_jerk] = figures(interpolator, Cycles::default(), PHASES);
        let needs = match (
            interpolator.needs_velocity(),
            interpolator.needs_acceleration(),
        ) {
            (true, true) => "velocity, acceleration",
            (true, false) => "velocity",
            (false, true) => "acceleration",
            (false, false) => "positions alone",
        };
        let digits = if error < 1.0 { 3 } else { 1 };
        let name = if interpolator == Interpolator::default() {
            format!("`{interpolator}` (default)")
        } else {
            format!("`{interpolator}`")
        };
        writeln!(
            table,
            "| {name} | {} ms | {needs} | {error:.digits$} | {jerk:.2} | {any_error:.digits$}, {any_jerk:.2} |",
            interpolator.delay_cycles()
        )
        .unwrap();
    }
    table
}

#[test]
fn the_documented_table_is_what_is_measured() {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/book/src/model/interpolation.md");
    let page = std::fs::read_to_string(&path).unwrap();
    let from = page.find("| name |").unwrap();
    let to = from + page[from..].find("\n\n").unwrap() + 1;
    let measured = table();
    if std::env::var_os("UPDATE_DOCS").is_some() {
        std::fs::write(&path, format!("{}{measured}{}", &page[..from], &page[to..])).unwrap();
    } else {
        assert_eq!(&page[from..to], measured, "run with UPDATE_DOCS=1");
    }
}

#[test]
fn the_default_is_good_to_a_tenth_of_a_nanometre_and_a_twentieth_of_the_jerk() {
    let [error, jerk] = figures(Interpolator::default(), Cycles::default(), 1);
    assert!(error <= 0.1 && jerk <= 1.05, "{error} nm, {jerk}");
    let [error, jerk] = figures(Interpolator::default(), Cycles::default(), PHASES);
    assert!(error <= 0.1 && jerk <= 1.1, "any phase: {error} nm, {jerk}");
}

/// At constant acceleration a chord is off by a T^2/8, the B-spline by a T^2/6, and speeds that are
/// half a cycle old by `a T^2/2 (u - 3 u^2 + 2 u^3)`.
#[test]
fn those_with_a_closed_form_meet_it() {
    let motion = |t: f64| (0.5 * 1000.0 * t * t, 1000.0 * t, 1000.0);
    for (interpolator, expected) in [
        (Interpolator::Linear, 125.0),
        (Interpolator::CubicDifferences, 500.0 * 0.25 * 0.75 * 0.5),
        (Interpolator::CatmullRom, 0.0),
        (Interpolator::CubicHermite, 0.0),
        (Interpolator::QuinticHermite, 0.0),
        (Interpolator::BSpline, 1000.0 / 6.0),
        (Interpolator::CompensatedBSpline, 0.0),
        (Interpolator::QuinticDifferences, 0.0),
    ] {
        let [error, _] = measure(
            &spline(interpolator, Cycles::default()),
            Cycles::default(),
            &motion,
            0.1,
        );
        assert!(
            (error - expected).abs() < 1e-5,
            "{interpolator}: {error} nm"
        );
    }
}

/// With the command's cycle halved the error falls by the interpolator's order at least, on a
/// circle.
#[test]
fn errors_fall_with_the_cycle_by_the_order() {
    for (interpolator, order) in [
        (Interpolator::Linear, 2.0),
        (Interpolator::CubicDifferences, 2.0),
        (Interpolator::CatmullRom, 3.0),
        (Interpolator::CubicHermite, 4.0),
        (Interpolator::QuinticHermite, 6.0),
        (Interpolator::BSpline, 2.0),
        (Interpolator::CompensatedBSpline, 4.0),
        (Interpolator::QuinticDifferences, 5.0),
    ] {
        let error = |command_ms: f64| {
            let cycles = Cycles {
                command_ms,
                servo_us: 125.0 * command_ms,
            };
            measure(&spline(interpolator, cycles), cycles, &circle, 0.5)[0]
        };
        let (coarse, fine) = (error(8.0), error(4.0));
        let found = math::log2(coarse / fine);
        assert!(
            (found - order).abs() < 0.35,
            "{interpolator}: {coarse} nm, {fine} nm, order {found}"
        );
    }
}

/// Pieces meet at the setpoints: in position all, in velocity all but straight ones, in
/// acceleration all but cubics of two points.
#[test]
fn pieces_meet_as_smoothly_as_they_should() {
    for interpolator in Interpolator::ALL {
        let spline = spline(interpolator, Cycles::default());
        let mut state = spline.initial(0.0);
        let mut steps = [0.0_f64; 3];
        let mut end: Option<Reference> = None;
        for n in 0..200_u32 {
            let (position, velocity, acceleration) = circle(f64::from(n) * 1e-3);
            spline
                .push(
                    &mut state,
                    &Setpoint::moving(position, velocity, acceleration),
                )
                .unwrap();
            // a billionth into the piece, for what it has at its start
            let start = spline.at(&state, 1, 1_000_000_000);
            if let Some(end) = end.filter(|_| n > 8) {
                let differences = [
                    start.position - end.position,
                    start.velocity - end.velocity,
                    start.acceleration - end.acceleration,
                ];
                for (step, difference) in steps.iter_mut().zip(differences) {
                    *step = step.max(difference.abs());
                }
            }
            assert_eq!(
                end.unwrap_or(spline.at(&state, 0, 4)),
                spline.at(&state, 0, 4)
            );
            end = Some(spline.at(&state, 4, 4));
        }
        let smooth_velocity = interpolator != Interpolator::Linear;
        // that of `cubic-hermite` is too small to be seen here
        let cubic = matches!(
            interpolator,
            Interpolator::CubicDifferences | Interpolator::CatmullRom
        );
        let smooth_acceleration = !cubic;
        assert!(steps[0] < 1e-6, "{interpolator}: {steps:?}");
        assert_eq!(
            steps[1] < 1e-4,
            smooth_velocity,
            "{interpolator}: {steps:?}"
        );
        assert_eq!(
            steps[2] < 1e-2,
            smooth_acceleration,
            "{interpolator}: {steps:?}"
        );
    }
}

#[test]
fn what_is_needed_has_to_come_along_and_names_find_their_interpolator() {
    for interpolator in Interpolator::ALL {
        assert_eq!(
            Interpolator::from_name(interpolator.name()),
            Some(interpolator)
        );
        let text = toml::to_string(&AxisConfig {
            interpolator,
            ..AxisConfig::paper()
        })
        .unwrap();
        assert!(
            text.contains(&format!("interpolator = \"{interpolator}\"")),
            "{text}"
        );
        let alone = Setpoint {
            position: 1.0,
            ..Setpoint::default()
        };
        let spline = spline(interpolator, Cycles::default());
        let taken = spline.push(&mut spline.initial(0.0), &alone).is_ok();
        assert_eq!(
            taken,
            !interpolator.needs_velocity() && !interpolator.needs_acceleration(),
            "{interpolator}"
        );
    }
    assert_eq!(Interpolator::from_name("spline"), None);
    // names of earlier files
    let old = |name: &str| {
        let text = toml::to_string(&AxisConfig::paper()).unwrap();
        toml::from_str::<AxisConfig>(&text.replace(
            "interpolator = \"quintic-hermite\"",
            &format!("reference = \"{name}\""),
        ))
        .unwrap()
    };
    assert_eq!(old("sent-along").interpolator, Interpolator::QuinticHermite);
    assert_eq!(
        old("differences").interpolator,
        Interpolator::QuinticDifferences
    );
}
