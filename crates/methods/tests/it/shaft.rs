//! The shaft's estimator: against a closed form, against the truth of random axes, and that it says
//! nothing where nothing tells.

use lostmotion_base::math;
use lostmotion_drive::Signals;
use lostmotion_drive::config::Load;
use lostmotion_methods::{AxisConfig, ShaftEstimate, ShaftEstimator, ShaftState};
use lostmotion_rig::{PAPER_MOVE, circle, mill_x, run, there_and_back};

/// Encoders: ideal, 2^23 and 2^20 counts.
const COUNTS: [Option<u32>; 3] = [None, Some(1 << 23), Some(1 << 20)];

/// A number in 0 .. 1 from a counter (Weyl's sequence).
fn weyl(n: u32, which: usize) -> f64 {
    const STEPS: [f64; 5] = [
        0.754_877_666_246_693,
        0.569_840_290_998_053,
        0.438_579,
        0.819_172_513_396_164,
        0.671_043_606_703_789,
    ];
    (0.5 + f64::from(n) * STEPS[which]).fract()
}

/// A random axis with its stiffness and damping: 200 to 20000 N m/rad, 0.03 to 0.3 of critical
/// damping, inertia ratio 0.5 to 8, gap 2 to 200 mrad, load friction none to 2 N m.
fn axis(n: u32) -> (AxisConfig, f64, f64) {
    let mut config = AxisConfig::paper();
    config.compensation.estimate_shaft = true;
    let motor = config.motor.inertia_kgm2;
    let stiffness = 200.0 * math::exp(math::log(100.0) * weyl(n, 0));
    let inertia = motor * 0.5 * math::exp(math::log(16.0) * weyl(n, 1));
    let ratio = 0.03 + 0.27 * weyl(n, 2);
    let damping = 2.0 * ratio * (stiffness / (1.0 / motor + 1.0 / inertia)).sqrt();
    config.drive.velocity_gain_a_s_per_rad *= (motor + inertia) / (motor + 0.0065);
    if let Load::Reflected(load) = &mut config.load {
        (
            load.inertia_kgm2,
            load.stiffness_nm_per_rad,
            load.damping_nm_s_per_rad,
        ) = (inertia, stiffness, damping);
        load.coulomb_nm = if n.is_multiple_of(3) {
            0.0
        } else {
            2.0 * weyl(n, 3)
        };
        load.gap_rad = 0.002 * math::exp(math::log(100.0) * weyl(n, 4));
    }
    config.drive.encoder_counts_per_rev = COUNTS[n as usize / 3 % 3];
    (config, stiffness, damping)
}

/// Median and largest of how far estimates are off, and how many there are.
fn spread(mut off: Vec<f64>) -> (f64, f64, usize) {
    off.sort_by(f64::total_cmp);
    (off[off.len() / 2], off[off.len() - 1], off.len())
}

#[test]
fn random_axes_are_known_to_a_per_cent_or_not_at_all() {
    for method in ["none", "adaptive"] {
        let (mut stiffness, mut damping) = (Vec::new(), Vec::new());
        for n in 0..24 {
            let (config, k, d) = axis(n);
            let out = run(
                &config,
                method,
                &|t| there_and_back(PAPER_MOVE, 0.4, t % 2.0),
                4.0,
            );
            let last = *out.trace.unwrap().last().unwrap();
            if last.stiffness_estimate.is_finite() {
                stiffness.push((last.stiffness_estimate / k - 1.0).abs());
            }
            if last.damping_estimate.is_finite() {
                damping.push((last.damping_estimate / d - 1.0).abs());
            }
        }
        let (median, most, told) = spread(stiffness);
        assert!(
            told >= 18 && median < 0.005 && most < 0.1,
            "{method}: {told} of 24, {median} {most}"
        );
        let (median, most, told) = spread(damping);
        assert!(
            told >= 16 && median < 0.02 && most < 0.5,
            "{method}, damping: {told} of 24, {median} {most}"
        );
    }
}

/// Two masses in steady travel under a torque that the load's friction takes; the load is struck at
/// 0.1, 0.7 and 1.3 s, and rings as the closed form says.
fn struck(k: f64, d: f64, inertia_known: bool) -> ShaftEstimate {
    let mut config = AxisConfig::paper();
    config.motor.viscous_nm_s_per_rad = 0.0;
    let (m, l, torque) = (
        config.motor.inertia_kgm2,
        config.reflected_load().inertia_kgm2,
        5.0,
    );
    let (decay, natural) = (
        0.5 * d * (1.0 / m + 1.0 / l),
        (k * (1.0 / m + 1.0 / l)).sqrt(),
    );
    let ringing = (natural * natural - decay * decay).sqrt();
    let blow = 0.4 * torque / k * natural;
    let position = |t: f64| {
        let since = [0.1, 0.7, 1.3].map(|at| (t - at).max(0.0));
        // the centre of mass takes its part of the blow, the twist swings about its rest
        let swing = |t: f64| -blow / ringing * math::exp(-decay * t) * math::sin(ringing * t);
        20.0 * t
            + since
                .iter()
                .map(|t| l / (m + l) * (blow * t + swing(*t)))
                .sum::<f64>()
    };
    let (estimator, mut state) = (ShaftEstimator::new(&config), ShaftState::default());
    let current = torque / config.motor.torque_constant_nm_per_a;
    let mut last = 0.0;
    for n in 0..8000_u32 {
        let motor_position = position(f64::from(n) * 2.5e-4);
        let motor_velocity = (motor_position - last) / 2.5e-4;
        last = motor_position;
        let signals = Signals {
            motor_position,
            motor_velocity,
            current,
            mean_current: current,
            ..Signals::default()
        };
        estimator.step(&mut state, &signals, inertia_known.then_some(l));
    }
    state.estimate()
}

#[test]
fn the_closed_form_of_a_struck_axis_is_found_without_an_error() {
    for (k, d) in [
        (300.0, 0.05),
        (2000.0, 0.3),
        (2000.0, 0.05),
        (15_000.0, 0.9),
    ] {
        let found = struck(k, d, true);
        let off = [
            found.stiffness_nm_per_rad / k - 1.0,
            found.damping_nm_s_per_rad / d - 1.0,
        ];
        assert!(
            off.iter().all(|off| off.abs() < 1e-4),
            "{k} {d}: {off:?} {found:?}"
        );
        // free ringing under a steady torque shows k (1/J_M + 1/J_L) alone
        assert!(struck(k, d, false).stiffness_nm_per_rad.is_nan(), "{k} {d}");
    }
}

#[test]
fn smooth_motion_on_a_flank_tells_nothing() {
    let mut config = mill_x(0.1, 0.0, Some(1 << 20));
    config.compensation.estimate_shaft = true;
    for method in ["none", "adaptive"] {
        let trace = run(&config, method, &|t| circle(50.0, 1.0, t), 6.0)
            .trace
            .unwrap();
        assert!(
            trace
                .iter()
                .all(|s| s.stiffness_estimate.is_nan() && s.damping_estimate.is_nan()),
            "{method}"
        );
    }
}

#[test]
fn watching_the_shaft_changes_no_bit_of_the_motion() {
    let (config, ..) = axis(4);
    let mut unwatched = config.clone();
    unwatched.compensation.estimate_shaft = false;
    for method in ["none", "adaptive", "published"] {
        let motion = |t: f64| there_and_back(PAPER_MOVE, 0.4, t % 2.0);
        let (with, without) = (
            run(&config, method, &motion, 2.0),
            run(&unwatched, method, &motion, 2.0),
        );
        assert_eq!(
            (with.load, with.peak_current_a.to_bits()),
            (without.load, without.peak_current_a.to_bits()),
            "{method}"
        );
        assert!(
            without
                .trace
                .unwrap()
                .iter()
                .all(|s| s.stiffness_estimate.is_nan())
        );
    }
}
