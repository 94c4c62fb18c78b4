//! The fitted gap in use, and an axis that no fit was given for.

mod support;

use lostmotion_axis::config::Gap;
use support::{circle, mill_x, ratio_on_a_sine, run};

#[test]
fn it_is_lookup_with_what_the_fit_told() {
    let mut config = mill_x(0.1, 10.0, None);
    let motion = |t: f64| circle(10.0, 5.0, t);
    assert_eq!(run(&config, "fitted-lookup", &motion, 2.0).load, run(&config, "none", &motion, 2.0).load);
    config = config.with_told_gap(Gap::Um(9.9));
    assert_eq!(run(&config, "fitted-lookup", &motion, 2.0).load, run(&config, "lookup", &motion, 2.0).load);
    let [rms, _] = ratio_on_a_sine(&config, "fitted-lookup", 10.0, 5.0, 4.0);
    // a hundredth of the gap is missing
    assert!(rms > 0.01 && rms < 0.03, "{rms}");
}
