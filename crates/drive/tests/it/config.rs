//! Descriptions: refused where they make no sense, kept through text, reflected as physics says.

use lostmotion_drive::config::{Gap, Load, Rotary, StartInGap, Table, Transmission};
use lostmotion_methods::AxisConfig;
use lostmotion_rig::mill;
use std::f64::consts::TAU;

fn refused(change: impl FnOnce(&mut AxisConfig)) -> String {
    let mut config = mill(100.0, 0.0);
    change(&mut config);
    config.check().unwrap_err().to_string()
}

fn slide(config: &mut AxisConfig) -> &mut lostmotion_drive::config::Slide {
    match &mut config.load {
        Load::Slide(slide) => slide,
        _ => panic!("the mill has a slide"),
    }
}

#[test]
fn presets_are_good() {
    AxisConfig::paper().check().unwrap();
    mill(100.0, 5.0).check().unwrap();
    AxisConfig::paper().without_gap().check().unwrap();
}

#[test]
fn what_makes_no_sense_is_refused_with_key_and_value() {
    let message = refused(|c| c.motor.inertia_kgm2 = 0.0);
    assert_eq!(
        message,
        "motor.inertia_kgm2 is 0; it has to be a finite number above 0"
    );
    assert!(
        refused(|c| c.motor.resistance_ohm = f64::NAN).starts_with("motor.resistance_ohm is NaN")
    );
    assert!(refused(|c| c.motor.poles = 5).contains("an even number"));
    assert!(
        refused(|c| slide(c).gap_um = -1.0)
            .starts_with("load.slide.gap_um is -1; it has to be from 0")
    );
    assert!(refused(|c| slide(c).mass_kg = f64::INFINITY).starts_with("load.slide.mass_kg is inf"));
    assert!(refused(|c| slide(c).stiffness_n_per_um = 1e12).contains("shaft resonance"));
    assert!(refused(|c| c.motor.inductance_h = 1e-9).contains("resistance over inductance"));
    assert!(refused(|c| c.drive.current_period_us = Some(60.0)).contains("a whole fraction"));
    assert!(
        refused(|c| c.drive.velocity_feedforward = 1.5)
            .starts_with("drive.velocity_feedforward is 1.5")
    );
    assert!(refused(|c| c.start_in_gap = StartInGap(f64::NAN)).starts_with("start_in_gap is NaN"));
    assert!(
        refused(|c| c.compensation.published.lambda = Some(1.0))
            .starts_with("compensation.published.lambda is 1")
    );
    assert!(
        refused(|c| c.compensation.fixed.gap = Some(Gap::Mdeg(1.0))).contains("the axis is in mm")
    );
    assert!(
        refused(|c| c.transmission = Transmission::Rotary(Rotary {
            gear: 1.0,
            unit: Default::default()
        }))
        .contains("a slide needs a linear")
    );
}

#[test]
fn text_keeps_every_value_and_refuses_unknown_keys() {
    for config in [mill(100.0, 3.0), AxisConfig::paper()] {
        let text = toml::to_string(&config).unwrap();
        assert_eq!(
            toml::from_str::<AxisConfig>(&text).unwrap(),
            config,
            "{text}"
        );
        let wrong = text.replace("poles =", "pole_pairs =");
        let error = toml::from_str::<AxisConfig>(&wrong)
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("pole_pairs") && error.contains("line"),
            "{error}"
        );
    }
}

#[test]
fn a_slide_is_reflected_through_its_screw() {
    let load = mill(300.0, 60.0).reflected_load();
    let r = 0.010 / TAU;
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} against {b}");
    close(load.inertia_kgm2, 350.0 * r * r);
    close(load.motor_side_inertia_kgm2, 0.0012);
    close(load.coulomb_nm, 300.0 * r);
    close(load.viscous_nm_s_per_rad, 60.0 * r * r);
    close(load.stiffness_nm_per_rad, 120e6 * r * r);
    close(load.damping_nm_s_per_rad, 30e3 * r * r);
    close(load.gap_rad, 10e-6 / r);
    close(mill(0.0, 0.0).gap_in_unit(), 0.010);
    close(mill(0.0, 0.0).with_gap(0.040).gap_in_unit(), 0.040);
}

#[test]
fn a_table_is_reflected_through_its_gear() {
    let table = Table {
        inertia_kgm2: 2.0,
        gear_inertia_kgm2: 0.0,
        viscous_nm_s_per_rad: 0.0,
        coulomb_nm: 18.0,
        constant_nm: 9.0,
        stiffness_nm_per_rad: 8.1e5,
        damping_nm_s_per_rad: 810.0,
        gap_mdeg: 5.0,
        scale_mdeg: 1.0,
    };
    let config = AxisConfig {
        transmission: Transmission::Rotary(Rotary {
            gear: 90.0,
            unit: lostmotion_drive::config::AxisUnit::Deg,
        }),
        load: Load::Table(table),
        ..AxisConfig::paper()
    };
    config.check().unwrap();
    let load = config.reflected_load();
    let close = |a: f64, b: f64| assert!((a / b - 1.0).abs() < 1e-12, "{a} against {b}");
    close(load.inertia_kgm2, 2.0 / 8100.0);
    close(load.coulomb_nm, 0.2);
    close(load.stiffness_nm_per_rad, 100.0);
    close(load.gap_rad, 0.005 * TAU / 360.0 * 90.0);
    close(config.gap_in_unit(), 0.005);
    close(config.with_gap(0.01).gap_in_unit(), 0.01);
}
