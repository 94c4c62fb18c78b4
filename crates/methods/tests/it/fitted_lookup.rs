//! The fitted gap in use, and an axis that no fit was given for.

use lostmotion_drive::config::Gap;
use lostmotion_methods::fitted_lookup::ToldLoad;
use lostmotion_rig::{circle, mill_x, ratio_on_a_sine, run};

#[test]
fn it_is_lookup_with_what_the_fit_told() {
    let mut config = mill_x(0.1, 10.0, None);
    let motion = |t: f64| circle(10.0, 5.0, t);
    assert_eq!(
        run(&config, "fitted-lookup", &motion, 2.0).load,
        run(&config, "none", &motion, 2.0).load
    );
    config.compensation.tell_gap(Gap::Um(9.9));
    assert_eq!(
        run(&config, "fitted-lookup", &motion, 2.0).load,
        run(&config, "lookup", &motion, 2.0).load
    );
    let [rms, _] = ratio_on_a_sine(&config, "fitted-lookup", 10.0, 5.0, 4.0);
    // a hundredth of the gap is missing
    assert!(rms > 0.01 && rms < 0.03, "{rms}");
}

#[test]
fn it_takes_the_load_that_the_fit_found() {
    let mut config = mill_x(0.1, 10.0, None);
    config.compensation.tell_gap(Gap::Um(10.0));
    let load = config.reflected_load();
    let with = |factor: f64| {
        let mut told = config.clone();
        told.compensation.fitted_lookup.load = Some(ToldLoad {
            inertia_kgm2: load.inertia_kgm2 * factor,
            viscous_nm_s_per_rad: load.viscous_nm_s_per_rad,
            coulomb_nm: load.coulomb_nm,
            constant_nm: load.constant_nm,
        });
        told
    };
    let motion = |t: f64| circle(10.0, 5.0, t);
    assert_eq!(
        run(&with(1.0), "fitted-lookup", &motion, 2.0).load,
        run(&config, "fitted-lookup", &motion, 2.0).load
    );
    let rms = |factor: f64| ratio_on_a_sine(&with(factor), "fitted-lookup", 10.0, 5.0, 4.0)[0];
    // a wrong inertia is a crossing at the wrong time
    assert!(rms(3.0) > 1.2 * rms(1.0), "{} {}", rms(3.0), rms(1.0));
    assert!(with(-1.0).check().is_err());
}
