//! The machines that come with the library hold together physically.

use lostmotion_analysis::LimitCycle;
use lostmotion_base::{AxisId, Coords};
use lostmotion_drive::config::{Drive, Tuning};
use lostmotion_sim::machine::{
    DEFAULT_MACHINE, Machine, axis_from_toml, axis_preset, axis_preset_toml, axis_presets, presets,
};

fn machines() -> impl Iterator<Item = Machine> {
    presets()
        .iter()
        .filter_map(|info| Machine::preset(info.name).ok())
}

#[test]
fn motors_manage_their_limits_and_loops_stay_below_the_mechanics() {
    for machine in machines() {
        for figures in machine.review() {
            let who = format!("{} {figures:?}", machine.name());
            assert!(figures.remarks().is_empty(), "{:?}", figures.remarks());
            assert!((0.05..0.8).contains(&figures.peak_torque_ratio), "{who}");
            assert!((0.02..0.3).contains(&figures.friction_ratio), "{who}");
            assert!(
                figures.friction_ratio + figures.constant_ratio < 0.5,
                "{who}"
            );
            assert!(figures.voltage_ratio < 0.9, "{who}");
            assert!((500.0..3000.0).contains(&figures.motor_rpm), "{who}");
            assert!(
                figures.velocity_loop_hz * 1.5 < figures.resonance_hz,
                "{who}"
            );
            assert!((50.0..250.0).contains(&figures.resonance_hz), "{who}");
            assert!((0.03..0.08).contains(&figures.resonance_damping), "{who}");
            assert!((30.0..65.0).contains(&figures.position_gain_per_s), "{who}");
        }
    }
}

#[test]
fn gains_follow_from_the_stated_rule() {
    for machine in machines() {
        for axis in machine.axes() {
            let drive = axis.config.drive;
            // of the rule's numbers only the velocity loop's frequency differs between axes; Kv =
            // w_n / 4
            let frequency_hz = drive.position_gain_per_s * 4.0 / std::f64::consts::TAU;
            let tuning = Tuning {
                velocity_frequency_hz: frequency_hz,
                ..Tuning::default()
            };
            let rule = Drive::tuned(
                &axis.config.motor,
                &axis.config.reflected_load(),
                &tuning,
                drive.current_limit_a,
                drive.bus_voltage_v,
            );
            for (file, rule) in [
                (drive.current_gain_v_per_a, rule.current_gain_v_per_a),
                (drive.current_time_s, rule.current_time_s),
                (
                    drive.velocity_gain_a_s_per_rad,
                    rule.velocity_gain_a_s_per_rad,
                ),
                (drive.velocity_time_s, rule.velocity_time_s),
                (drive.velocity_feedforward, rule.velocity_feedforward),
                (
                    drive.acceleration_feedforward,
                    rule.acceleration_feedforward,
                ),
            ] {
                assert!(
                    (file / rule - 1.0).abs() < 0.01,
                    "{} {}: {file} in the file, {rule} by the rule",
                    machine.name(),
                    axis.id
                );
            }
        }
    }
}

#[test]
fn gaps_are_what_the_names_say() {
    let gap_um = |name: &str, axis| {
        Machine::preset(name).ok().and_then(|machine| {
            machine
                .axis(axis)
                .map(|axis| axis.config.gap_in_unit() * 1e3)
        })
    };
    for axis in [AxisId::X, AxisId::Y, AxisId::Z] {
        for (name, gap) in [("vmc3", 10.0), ("vmc3-worn", 40.0), ("bench3", 10.0)] {
            assert!(
                (gap_um(name, axis).unwrap_or(0.0) - gap).abs() < 1e-9,
                "{name} {axis}"
            );
        }
    }
    // 20 arc seconds are 9.7 um at 100 mm
    let c = gap_um("trunnion5", AxisId::C).unwrap_or(0.0);
    assert!(
        (c * 1e-3_f64.to_radians() * 100.0 * 1e3 - 9.7).abs() < 0.05,
        "{c} mdeg"
    );
}

#[test]
fn samples_fit_round_part_zero() {
    for name in ["vmc3", "vmc3-worn", "vmc4"] {
        let machine = Machine::preset(name).expect(name);
        let zero = machine.work_offsets()[0];
        for (axis, low, high) in [
            (AxisId::X, -100.0, 100.0),
            (AxisId::Y, -100.0, 100.0),
            (AxisId::Z, -30.0, 200.0),
        ] {
            let limits = machine.axis(axis).expect("axis").limits;
            assert!(
                limits.contains(zero[axis] + low, 0.0) && limits.contains(zero[axis] + high, 0.0),
                "{name} {axis}"
            );
        }
        assert_eq!(machine.start(), zero);
    }
}

#[test]
fn bench3_has_the_limits_it_promises_and_no_offset() {
    let bench = Machine::preset("bench3").expect("bench3");
    assert_eq!(bench.work_offsets(), [Coords::ZERO; 9]);
    assert_eq!(bench.start(), Coords::ZERO);
    for axis in bench.axes() {
        let limits = axis.limits;
        assert_eq!(
            (limits.velocity, limits.acceleration, limits.jerk),
            (100.0, 1000.0, 30_000.0)
        );
        assert_eq!((limits.min, limits.max), (-1000.0, 1000.0));
    }
}

#[test]
fn axes_come_by_name() {
    let names = axis_presets();
    // Two axes alone, and those of the machines; the gantry's second motor has a name of its own.
    assert_eq!(
        names.len(),
        2 + 3 + 3 + 4 + 5 + 3 + 3 * 5 + 3 + 3 + 4 + 6 + 3 + 1
    );
    assert!(names.iter().any(|name| name == "gantry3:y2"), "{names:?}");
    for name in &names {
        assert!(
            axis_preset(name).is_some_and(|axis| axis.check().is_ok()),
            "{name}"
        );
    }
    assert!(
        axis_preset("VMC3:x").is_none()
            && axis_preset("vmc3:b").is_none()
            && axis_preset("vmc3:xx").is_none()
            && axis_preset("").is_none()
    );
    assert!(Machine::preset(DEFAULT_MACHINE).is_ok());
}

#[test]
fn every_loop_has_the_margins_of_a_good_tuning_and_no_axis_swings() {
    for machine in machines() {
        for tuning in machine.tuning() {
            for at in &tuning.loops.loops {
                let who = format!(
                    "{} {} {} {}: {:?}",
                    machine.name(),
                    tuning.axis,
                    at.kind,
                    at.regime,
                    at.margins
                );
                assert!(
                    at.margins.stable()
                        && at.margins.phase_margin_deg.is_some_and(|deg| deg > 45.0),
                    "{who}"
                );
                assert!(
                    at.margins.gain_margin_db.is_some_and(|db| db > 8.0),
                    "{who}"
                );
            }
            assert_eq!(
                (tuning.predicted, tuning.simulated),
                (LimitCycle::None, None),
                "{} {}",
                machine.name(),
                tuning.axis
            );
        }
    }
}

#[test]
fn axes_that_are_shown_read_back_as_they_were() {
    for name in axis_presets() {
        let file = axis_preset_toml(&name).expect(&name);
        assert_eq!(
            axis_from_toml(&name, &file).expect(&name),
            axis_preset(&name).expect(&name),
            "{name}"
        );
    }
    assert!(axis_preset_toml("vmc3:q").is_none());
}
