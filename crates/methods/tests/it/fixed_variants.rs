//! The fixed correction as particular controls take it up, against closed forms and the controls'
//! own tables.

use lostmotion_drive::config::Gap;
use lostmotion_drive::{Reference, Signals};
use lostmotion_methods::AxisConfig;
use lostmotion_methods::fixed_fanuc::FixedFanuc;
use lostmotion_methods::fixed_linuxcnc::FixedLinuxcnc;
use lostmotion_methods::registry::Registered;
use lostmotion_rig::{mill_x, ratio_on_a_sine};

const TICK: f64 = 250e-6;

/// Corrections at the motor while the reference moves at these speeds (mm/s), each for so many
/// ticks.
fn corrections<C: Registered>(config: &AxisConfig, speeds: &[(f64, u32)]) -> Vec<f64> {
    let method = C::from_axis(config);
    let mut state = method.initial(0.0);
    let mut out = Vec::new();
    for &(speed, ticks) in speeds {
        let velocity = speed * config.transmission.motor_rad_per_unit();
        let reference = Reference {
            velocity,
            ..Reference::default()
        };
        let signals = Signals {
            reference,
            next_reference: reference,
            ..Signals::default()
        };
        out.extend((0..ticks).map(|_| method.step(&mut state, &signals).position));
    }
    out
}

fn linuxcnc(gap_um: f64, velocity: Option<f64>, acceleration: f64) -> AxisConfig {
    let mut config = mill_x(0.1, gap_um, None);
    config.compensation.fixed_linuxcnc.velocity_units_s = velocity;
    config.compensation.fixed_linuxcnc.acceleration_units_s2 = Some(acceleration);
    config
}

#[test]
fn linuxcnc_takes_up_a_triangle_of_speed_at_half_the_joints_acceleration() {
    // 10 um at 200 mm/s2: 2 sqrt(0.01/200) = 14.14 ms, at most sqrt(0.01 * 200) = 1.414 mm/s
    let config = linuxcnc(10.0, None, 400.0);
    let per_mm = config.transmission.motor_rad_per_unit();
    let x: Vec<f64> = corrections::<FixedLinuxcnc>(&config, &[(10.0, 200), (-10.0, 200)])
        .iter()
        .map(|rad| rad / per_mm)
        .collect();
    assert!((x[199] - 0.005).abs() < 1e-12 && (x[399] + 0.005).abs() < 1e-12);
    let arrived = x
        .iter()
        .skip(200)
        .position(|x| (x + 0.005).abs() < 1e-9)
        .map(|ticks| ticks as f64 * TICK);
    assert!(
        arrived.is_some_and(|time| (time - 14.14e-3).abs() < 2.0 * TICK),
        "{arrived:?}"
    );
    let speeds: Vec<f64> = x
        .windows(2)
        .skip(200)
        .map(|pair| (pair[0] - pair[1]) / TICK)
        .collect();
    let fastest = speeds.iter().copied().fold(0.0, f64::max);
    assert!((fastest / 2.0_f64.sqrt() - 1.0).abs() < 0.05, "{fastest}");
    assert!(
        speeds
            .windows(2)
            .all(|pair| pair[1] - pair[0] < 200.0 * TICK * (1.0 + 1e-9))
    );
}

#[test]
fn linuxcnc_keeps_half_the_joints_velocity() {
    // 100 um at 2 mm/s and 200 mm/s2: 10 ms up, 10 ms down, and 80 um at full speed
    let config = linuxcnc(100.0, Some(4.0), 400.0);
    let per_mm = config.transmission.motor_rad_per_unit();
    let x: Vec<f64> = corrections::<FixedLinuxcnc>(&config, &[(10.0, 400), (-10.0, 400)])
        .iter()
        .map(|rad| rad / per_mm)
        .collect();
    let arrived = x
        .iter()
        .skip(400)
        .position(|x| (x + 0.05).abs() < 1e-9)
        .map(|ticks| ticks as f64 * TICK);
    assert!(
        arrived.is_some_and(|time| (time - 0.06).abs() < 3.0 * TICK),
        "{arrived:?}"
    );
    assert!(
        x.windows(2)
            .all(|pair| (pair[1] - pair[0]).abs() <= 2.0 * TICK * (1.0 + 1e-9))
    );
}

#[test]
fn fanuc_moves_by_the_amounts_of_its_table() {
    let (a, b) = (10.0, 6.0);
    let mut config = mill_x(0.1, 10.0, None);
    let settings = &mut config.compensation.fixed_fanuc;
    (
        settings.cutting,
        settings.rapid,
        settings.rapid_above_units_s,
    ) = (Some(Gap::Um(a)), Some(Gap::Um(b)), 100.0);
    let per_um = config.transmission.motor_rad_per_unit() * 1e-3;
    let (cutting, rapid) = (20.0, 300.0);
    // before, after, by how much the correction moves
    let table = [
        (cutting, cutting, 0.0),
        (rapid, rapid, 0.0),
        (cutting, rapid, (b - a) / 2.0),
        (rapid, cutting, 0.0),
        (cutting, -cutting, -a),
        (rapid, -rapid, -b),
        (cutting, -rapid, -(a + b) / 2.0),
        (rapid, -cutting, -(a + b) / 2.0),
    ];
    for (before, after, expected) in table {
        let x = corrections::<FixedFanuc>(&config, &[(before, 200), (after, 200)]);
        let moved = (x[399] - x[199]) / per_um;
        assert!(
            (moved - expected).abs() < 1e-9,
            "{before} to {after}: {moved} um"
        );
    }
    // out of rapid by way of a standstill, as between blocks: the cutting amount again
    let x = corrections::<FixedFanuc>(&config, &[(rapid, 200), (0.0, 10), (cutting, 200)]);
    assert!(((x[409] - x[199]) / per_um - (a - b) / 2.0).abs() < 1e-9);
}

#[test]
fn both_mend_a_load_with_friction_and_harm_one_without() {
    for method in ["fixed-linuxcnc", "fixed-fanuc"] {
        for (radius, feed) in [(5.0, 1500.0), (50.0, 3000.0)] {
            let [rms, _] = ratio_on_a_sine(
                &mill_x(0.1, 20.0, Some(1 << 20)),
                method,
                radius,
                feed / 60.0 / radius,
                4.0,
            );
            assert!(rms < 0.05, "{method} R {radius}: {rms}");
        }
        let [rms, max] = ratio_on_a_sine(&mill_x(0.0, 20.0, None), method, 10.0, 5.0, 4.0);
        assert!(rms > 1.0 && max > 1.5, "{method}: {rms} {max}");
    }
}
