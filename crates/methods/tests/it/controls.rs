//! Backlash parameters of real controls, against closed forms and the makers' tables.
#![allow(
    clippy::disallowed_methods,
    reason = "expected values from other functions than those under test"
)]

use lostmotion_drive::config::Gap;
use lostmotion_drive::reference::Spline;
use lostmotion_drive::signal::BlockMotion;
use lostmotion_drive::{Correction, Reference, Signals};
use lostmotion_methods::AxisConfig;
use lostmotion_methods::actual_value::ActualValue;
use lostmotion_methods::decaying_pulse::DecayingPulse;
use lostmotion_methods::fixed_by_travel::FixedByTravel;
use lostmotion_methods::fixed_fanuc::FixedFanuc;
use lostmotion_methods::fixed_isg::FixedIsg;
use lostmotion_methods::fixed_mach3::FixedMach3;
use lostmotion_methods::fixed_mitsubishi::FixedMitsubishi;
use lostmotion_methods::friction_torque::FrictionTorque;
use lostmotion_methods::registry::Registered;
use lostmotion_methods::reversal_pulse::ReversalPulse;
use lostmotion_rig::{circle, mill_x, ratio_on_a_sine, run, setpoints};

const TICK: f64 = 250e-6;

/// A stretch of motion: speed in mm/s, acceleration in mm/s2, block, ticks.
type Stretch = (f64, f64, Option<BlockMotion>, u32);

/// What a method answers over stretches of motion.
fn corrections<C: Registered>(config: &AxisConfig, stretches: &[Stretch]) -> Vec<Correction> {
    let method = C::from_axis(config);
    let mut state = method.initial(0.0);
    let mut out = Vec::new();
    for &(speed, acceleration, block, ticks) in stretches {
        let per_mm = config.transmission.motor_rad_per_unit();
        let reference = Reference {
            velocity: speed * per_mm,
            acceleration: acceleration * per_mm,
            ..Reference::default()
        };
        let signals = Signals {
            reference,
            next_reference: reference,
            block,
            ..Signals::default()
        };
        out.extend((0..ticks).map(|_| method.step(&mut state, &signals)));
    }
    out
}

/// A reversal at +-10 mm/s: what the method answers behind it, positions in um.
fn behind_a_reversal<C: Registered>(config: &AxisConfig) -> Vec<f64> {
    let per_um = config.transmission.motor_rad_per_unit() * 1e-3;
    corrections::<C>(config, &[(10.0, 0.0, None, 4000), (-10.0, 0.0, None, 4000)])
        .iter()
        .skip(4000)
        .map(|correction| correction.position / per_um)
        .collect()
}

#[test]
fn isg_goes_along_sin2_in_its_cycles() {
    let mut config = mill_x(0.1, 10.0, None);
    config.compensation.fixed_isg.cycles = 20;
    let x = behind_a_reversal::<FixedIsg>(&config);
    // 20 cycles of 1 ms are 80 ticks
    for (tick, x) in x.iter().enumerate().take(200) {
        let u = (tick as f64 + 1.0).min(80.0) / 80.0;
        let expected = 5.0 - 10.0 * (std::f64::consts::FRAC_PI_2 * u).sin().powi(2);
        assert!((x - expected).abs() < 1e-9, "{tick}: {x} {expected}");
    }
    config.compensation.fixed_isg.cycles = 1;
    let x = behind_a_reversal::<FixedIsg>(&config);
    assert!((x[0] + 5.0).abs() < 1e-9, "one cycle is abrupt: {}", x[0]);
}

#[test]
fn mach3_takes_up_at_one_speed_at_once() {
    let mut config = mill_x(0.1, 10.0, None);
    config.compensation.fixed_mach3.speed_units_s = 2.0;
    let x = behind_a_reversal::<FixedMach3>(&config);
    // 10 um at 2 mm/s: 5 ms, half a micrometre a tick from the first one on
    for (tick, x) in x.iter().enumerate().take(40) {
        let expected = (5.0 - 0.5 * (tick as f64 + 1.0)).max(-5.0);
        assert!((x - expected).abs() < 1e-9, "{tick}: {x} {expected}");
    }
}

#[test]
fn reprap_spreads_over_its_multiple_and_marlin_over_its_path() {
    let mut config = mill_x(0.1, 10.0, None);
    // 10 gaps are 100 um: 10 ms at 10 mm/s
    let x = behind_a_reversal::<FixedByTravel>(&config);
    for (tick, x) in x.iter().enumerate().take(100) {
        let expected = (5.0 - 10.0 * (tick as f64 + 1.0) / 40.0).max(-5.0);
        assert!((x - expected).abs() < 1e-9, "{tick}: {x} {expected}");
    }
    // Marlin: e^-1 is left behind each S of the path, of all axes
    let settings = &mut config.compensation.fixed_by_travel;
    (settings.multiple, settings.smoothing_mm) = (1.0, 3.0);
    let per_um = config.transmission.motor_rad_per_unit() * 1e-3;
    let block = Some(BlockMotion {
        rapid: false,
        path_speed_mm_s: 30.0,
    });
    let answer = corrections::<FixedByTravel>(
        &config,
        &[(10.0, 0.0, block, 4000), (-10.0, 0.0, block, 4000)],
    );
    for ticks in [100, 400, 800] {
        let left = answer[4000 + ticks - 1].position / per_um + 5.0;
        let path = 30.0 * TICK * ticks as f64;
        let expected = 10.0 * (-path / 3.0).exp();
        assert!(
            (left / expected - 1.0).abs() < 2e-3 * path,
            "{left} {expected}"
        );
    }
    // half of the gap alone, and no more than the axis' own way: a creeping axis doubles its speed
    let settings = &mut config.compensation.fixed_by_travel;
    (settings.correction, settings.smoothing_mm) = (0.5, 0.0);
    let slow =
        corrections::<FixedByTravel>(&config, &[(1.0, 0.0, block, 4000), (-1.0, 0.0, block, 400)]);
    let speeds = slow.iter().map(|c| c.velocity / per_um * 1e-3);
    assert!(speeds.fold(0.0_f64, |most, v| most.max(v.abs())) < 1.0 + 1e-9);
    assert!((slow[3999].position / per_um - 2.5).abs() < 1e-9);
    assert!((slow[4399].position / per_um + 2.5).abs() < 1e-9);
}

#[test]
fn mitsubishi_takes_the_amount_of_the_acceleration() {
    let mut config = mill_x(0.1, 10.0, None);
    let settings = &mut config.compensation.fixed_mitsubishi;
    settings.acceleration_units_s2 = [100.0, 200.0, 400.0, 800.0];
    settings.part = [1.0, 1.2, 1.2, 0.8];
    let per_um = config.transmission.motor_rad_per_unit() * 1e-3;
    for (acceleration, part) in [
        (0.0, 1.0),
        (100.0, 1.0),
        (150.0, 1.1),
        (300.0, 1.2),
        (600.0, 1.0),
        (800.0, 0.8),
        (5000.0, 0.8),
    ] {
        let answer = corrections::<FixedMitsubishi>(
            &config,
            &[(10.0, 0.0, None, 100), (-10.0, -acceleration, None, 100)],
        );
        let reached = -answer[199].position / per_um;
        assert!(
            (reached - 5.0 * part).abs() < 1e-9,
            "{acceleration}: {reached}"
        );
    }
    config.compensation.fixed_mitsubishi.acceleration_units_s2[3] = 300.0;
    let error = config.check().unwrap_err().to_string();
    assert!(error.contains("acceleration_units_s2"), "{error}");
}

#[test]
fn fanuc_knows_a_rapid_from_its_block() {
    let (a, b) = (10.0, 6.0);
    let mut config = mill_x(0.1, 10.0, None);
    let settings = &mut config.compensation.fixed_fanuc;
    (settings.cutting, settings.rapid) = (Some(Gap::Um(a)), Some(Gap::Um(b)));
    let per_um = config.transmission.motor_rad_per_unit() * 1e-3;
    let kind = |rapid| {
        Some(BlockMotion {
            rapid,
            path_speed_mm_s: 20.0,
        })
    };
    // the table of the manual; the speed is that of a slow cut throughout
    let half = (a - b) / 2.0;
    for (before, after, reverses, expected) in [
        (false, false, false, 0.0),
        (true, true, false, 0.0),
        (false, true, false, -half),
        (true, false, false, half),
        (false, false, true, -a),
        (true, true, true, -b),
        (false, true, true, -(a + b) / 2.0),
        (true, false, true, -(a + b) / 2.0),
    ] {
        let speed = if reverses { -20.0 } else { 20.0 };
        let x = corrections::<FixedFanuc>(
            &config,
            &[
                (20.0, 0.0, kind(before), 200),
                // between blocks the axis stands for a moment
                (0.0, 0.0, kind(after), 10),
                (speed, 0.0, kind(after), 200),
            ],
        );
        let moved = (x[409].position - x[199].position) / per_um;
        assert!(
            (moved - expected).abs() < 1e-9,
            "{before} {after}: {moved} um"
        );
    }
}

#[test]
fn a_pulse_has_the_height_of_the_characteristic_and_the_area_of_the_gap() {
    let mut config = mill_x(0.1, 10.0, None);
    let per_mm = config.transmission.motor_rad_per_unit();
    let all = corrections::<DecayingPulse>(&config, &[(10.0, 0.0, None, 4000)]);
    let area: f64 = all.iter().map(|c| c.velocity * TICK / per_mm * 1e3).sum();
    // held over ticks of 250 us with a time constant of 15 ms: T/dt (1 - exp(-dt/T)) below 1
    assert!((area / 10.0 - 1.0).abs() < 0.01, "{area} um");
    // B1 to B4 of the manual
    let settings = &mut config.compensation.decaying_pulse;
    settings.height_units_s = Some(3.0);
    settings.least_height_units_s = Some(1.0);
    settings.acceleration_units_s2 = Some([10.0, 100.0, 300.0]);
    for (acceleration, height) in [
        (0.0, 0.0),
        (5.0, 1.5),
        (10.0, 3.0),
        (100.0, 3.0),
        (200.0, 2.0),
        (300.0, 1.0),
        (3000.0, 1.0),
    ] {
        let answer = corrections::<DecayingPulse>(&config, &[(-1.0, -acceleration, None, 61)]);
        let found = -answer[0].velocity / per_mm;
        assert!((found - height).abs() < 1e-9, "{acceleration}: {found}");
        // a time constant later: 60 ticks of 250 us
        let later = -answer[60].velocity / per_mm;
        assert!((later - height * (-1.0_f64).exp()).abs() < 1e-9, "{later}");
    }
}

/// What a method answers on a circle of a radius in mm at a speed in mm/s, at each servo tick with
/// the reference that the interpolator makes of the control's setpoints.
fn on_a_circle<C: Registered>(
    config: &AxisConfig,
    radius: f64,
    speed: f64,
    turns: f64,
) -> Vec<(Reference, Correction)> {
    let (spline, method) = (Spline::new(config), C::from_axis(config));
    let mut state = method.initial(0.0);
    let mut piece = spline.initial(0.0);
    let w = speed / radius;
    let mut out = Vec::new();
    for setpoint in setpoints(&|t| circle(radius, w, t), turns * std::f64::consts::TAU / w) {
        spline.push(&mut piece, &setpoint).unwrap();
        for tick in 0..4 {
            let reference = spline.at(&piece, tick, 4);
            let signals = Signals {
                reference,
                next_reference: spline.at(&piece, tick + 1, 4),
                ..Signals::default()
            };
            out.push((reference, method.step(&mut state, &signals)));
        }
    }
    out
}

/// Tick of the reversal half a turn after the start, of three quarters of one.
fn far_reversal(answers: &[(Reference, Correction)]) -> usize {
    let quarter = answers.len() / 3;
    let is_back = |(reference, _): &(Reference, Correction)| reference.velocity < 0.0;
    quarter + answers[quarter..].iter().position(is_back).unwrap()
}

/// Siemens, function manual K3 (03/2013, 6FC5397-1BP40-3BA1), p. 294: over the acceleration v^2/r at
/// the change of the quadrant the pulse's height rises in proportion (B1), stays (B2), falls in a
/// straight line (B3), stays (B4).
#[test]
fn siemens_pulse_follows_its_characteristic_from_circle_to_circle() {
    let mut config = mill_x(0.1, 10.0, None);
    let per_mm = config.transmission.motor_rad_per_unit();
    let [most, least] = [2.5, 0.8];
    let [a1, a2, a3] = [20.0, 120.0, 600.0];
    let settings = &mut config.compensation.decaying_pulse;
    settings.height_units_s = Some(most);
    settings.least_height_units_s = Some(least);
    settings.acceleration_units_s2 = Some([a1, a2, a3]);
    let mut ranges = [0; 4];
    for radius in [5.0, 20.0, 80.0] {
        for speed in [10.0, 25.0, 60.0, 120.0] {
            let a = speed * speed / radius;
            let (range, expected) = match a {
                a if a < a1 => (0, most * a / a1),
                a if a <= a2 => (1, most),
                a if a < a3 => (2, most + (least - most) / (a3 - a2) * (a - a2)),
                _ => (3, least),
            };
            ranges[range] += 1;
            let answers = on_a_circle::<DecayingPulse>(&config, radius, speed, 0.75);
            let at = far_reversal(&answers);
            let found = -answers[at].1.velocity / per_mm;
            // the tick is up to 250 us behind the reversal, where cos is below 1
            assert!(
                (found / expected - 1.0).abs() < 1e-4,
                "r {radius}, v {speed}: {found} mm/s, not {expected}"
            );
        }
    }
    assert!(ranges.iter().all(|&circles| circles > 0), "{ranges:?}");
}

/// A pulse that ends by travel lasts as long as the reference needs for its way, at any acceleration;
/// Fanuc's second stage (B-65270EN/05 p. 188) goes from a distance to twice that distance.
#[test]
fn pulses_by_travel_end_where_they_are_told_at_any_acceleration() {
    let mut config = mill_x(0.1, 10.0, None);
    let per_mm = config.transmission.motor_rad_per_unit();
    let pulse = &mut config.compensation.reversal_pulse;
    (pulse.speed_rad_s, pulse.travel_units) = (Some(3.0), Some(0.005));
    (pulse.second_torque_nm, pulse.second_travel_units) = (Some(0.7), Some([0.02, 0.04]));
    for (radius, speed) in [(10.0, 20.0), (10.0, 60.0), (100.0, 60.0)] {
        let answers = on_a_circle::<ReversalPulse>(&config, radius, speed, 0.75);
        let at = far_reversal(&answers);
        let top = 2.0 * radius;
        for (reference, correction) in &answers[at..] {
            // the way behind the far end of the circle, mm; up to a tick of it lies before the
            // reversal is seen
            let way = top - reference.position / per_mm;
            let seen = top - answers[at].0.position / per_mm;
            let part = 1.0 - (way - seen) / 0.005;
            let expected = -3.0 * part.max(0.0);
            assert!(
                (correction.velocity - expected).abs() < 1e-6,
                "{way} mm: {} rad/s, not {expected}",
                correction.velocity
            );
            let second = way - seen >= 0.02 && way - seen < 0.04;
            assert_eq!(correction.torque, if second { -0.7 } else { 0.0 }, "{way}");
        }
        // x = a t^2/2: so long the first pulse lasts
        let lasts = answers[at..]
            .iter()
            .take_while(|(_, correction)| correction.velocity != 0.0)
            .count() as f64
            * TICK;
        let expected = (2.0 * 0.005 * radius / (speed * speed)).sqrt();
        assert!(
            (lasts - expected).abs() < 2.5 * TICK,
            "r {radius}, v {speed}: {lasts} s, not {expected}"
        );
    }
    // an axis that stops within the way is not pushed on
    let stretches = [(-1.0, 0.0, None, 2), (0.0, 0.0, None, 10)];
    let answers = corrections::<ReversalPulse>(&config, &stretches);
    assert!(answers[1].velocity < 0.0 && answers[2].velocity == 0.0);
    // the height of a pulse by travel is told, and a second pulse has its way
    let refused = |change: &dyn Fn(&mut AxisConfig)| {
        let mut config = config.clone();
        change(&mut config);
        config.check().unwrap_err().to_string()
    };
    let told = refused(&|config| config.compensation.reversal_pulse.speed_rad_s = None);
    assert!(
        told.contains("travel_units") && told.contains("speed_rad_s"),
        "{told}"
    );
    let told = refused(&|config| config.compensation.reversal_pulse.second_travel_units = None);
    assert!(told.contains("second_travel_units"), "{told}");
    let told = refused(&|config| {
        config.compensation.reversal_pulse.second_travel_units = Some([0.02, 0.01]);
    });
    assert!(told.contains("second_travel_units"), "{told}");
}

#[test]
fn a_torque_changes_by_its_amount_at_each_reversal() {
    let mut config = mill_x(0.1, 10.0, None);
    let both = [(10.0, 0.0, None, 10), (-10.0, 0.0, None, 10)];
    let usual = corrections::<FrictionTorque>(&config, &both);
    let friction = config.reflected_load().coulomb_nm;
    assert!((usual[9].torque - usual[19].torque - 2.0 * friction).abs() < 1e-12);
    let settings = &mut config.compensation.friction_torque;
    (settings.amount_nm, settings.negative_amount_nm) = (Some(0.4), Some(0.6));
    let told = corrections::<FrictionTorque>(&config, &both);
    assert!((told[9].torque - 0.2).abs() < 1e-12 && (told[19].torque + 0.3).abs() < 1e-12);
}

/// Told a gap that the machine does not have, the load shows what the correction does alone.
#[test]
fn what_the_actual_value_is_told_settles_with_the_gain_of_the_position_loop() {
    let mut config = mill_x(0.0, 0.0, None);
    config.compensation.actual_value.gap = Some(Gap::Um(20.0));
    let motion = |t: f64| circle(10.0, 1.0, t);
    let [with, without] =
        ["actual-value", "none"].map(|name| run(&config, name, &motion, 4.0).load);
    let moved: Vec<f64> = with
        .iter()
        .zip(&without)
        .map(|(a, b)| (a - b) * 1e3)
        .collect();
    let settled = moved[moved.len() - 1];
    assert!((settled.abs() - 10.0).abs() < 0.2, "{settled} um");
    // The last reversal of X on the circle: behind it, when the velocity loop has settled, the way
    // that is left falls by e in 1/Kv.
    let turn = moved
        .windows(2)
        .rposition(|pair| (pair[1] - settled).abs() > 15.0)
        .unwrap();
    let gain = config.drive.position_gain_per_s;
    let left = |after_s: f64| (moved[turn + (after_s / TICK) as usize] - settled).abs();
    for (from, to) in [(0.01, 0.02), (0.01, 0.03)] {
        let fell = (left(from) / left(to)).ln() / (to - from);
        assert!((fell / gain - 1.0).abs() < 0.1, "{fell} 1/s against {gain}");
    }
    // spread over 40 ms in a straight line: half way after 20 ms
    config.compensation.actual_value.spread_ms = 40.0;
    let answer =
        corrections::<ActualValue>(&config, &[(10.0, 0.0, None, 400), (-10.0, 0.0, None, 400)]);
    let per_um = config.transmission.motor_rad_per_unit() * 1e-3;
    assert!(answer[479].feedback.abs() / per_um < 1e-9);
    assert!((answer[439].feedback / per_um - 5.0).abs() < 1e-9);
    assert!((answer[799].feedback / per_um + 10.0).abs() < 1e-9);
}

#[test]
fn each_mends_a_load_with_friction_as_far_as_its_law_lets_it() {
    let of =
        |method: &str, gap: f64| ratio_on_a_sine(&mill_x(0.1, gap, None), method, 10.0, 2.5, 4.0);
    for (method, most) in [
        ("fixed-isg", 0.05),
        ("fixed-mach3", 0.05),
        ("fixed-mitsubishi", 0.05),
        ("actual-value", 0.3),
        ("fixed-by-travel", 0.5),
        ("decaying-pulse", 1.0),
        ("friction-torque", 1.02),
    ] {
        let [rms, max] = of(method, 20.0);
        println!("{method}: {rms} {max}");
        assert!(rms < most, "{method}: {rms} {max}");
    }
}

/// Marlin issue 13033: told twice the gap it leaves as much on the other side, told three times
/// twice as much.
#[test]
fn over_compensation_is_as_wrong_as_none() {
    for (factor, left) in [(1.0, 0.0), (2.0, 1.0), (3.0, 2.0)] {
        let mut config = mill_x(0.1, 20.0, None);
        let settings = &mut config.compensation.fixed_by_travel;
        (settings.gap, settings.multiple) = (Some(Gap::Um(20.0 * factor)), 1.0);
        let [rms, _] = ratio_on_a_sine(&config, "fixed-by-travel", 10.0, 2.5, 4.0);
        assert!((rms - left).abs() < 0.15, "{factor}: {rms}");
    }
}
