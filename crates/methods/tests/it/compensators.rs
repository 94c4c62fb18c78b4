//! What each compensator does, and what it does wrong.

use lostmotion_drive::config::Gap;
use lostmotion_methods::AxisConfig;
use lostmotion_methods::{MethodId, build_runner};
use lostmotion_rig::{
    Move, PAPER_MOVE, circle, circle_error, errors, max_abs, mill, rms, run, there_and_back,
};

const REST: f64 = 0.4;

/// Settled offset of the load there and back, and RMS of what the gap causes, on the paper's move.
fn paper_move(method: &str) -> [f64; 3] {
    let config = AxisConfig::paper();
    let motion = |t: f64| there_and_back(PAPER_MOVE, REST, t);
    let seconds = 2.0 * (PAPER_MOVE.duration() + REST);
    let (out, rigid) = (
        run(&config, method, &motion, seconds),
        run(&config.without_gap(), "none", &motion, seconds),
    );
    let error = errors(&out);
    let settled = |end: usize| error[end - 80..end].iter().sum::<f64>() / 80.0;
    [
        settled(error.len() / 2),
        settled(error.len()),
        rms(out.load.iter().zip(&rigid.load).map(|(a, b)| a - b)),
    ]
}

/// Part of the load's error that the gap causes on a sine, rms and max over all but the first two
/// turns, over those of `none`.
fn harm_on_a_sine(config: &AxisConfig, method: &str, radius: f64, w: f64) -> [f64; 2] {
    let seconds = 8.0 * std::f64::consts::TAU / w;
    let motion = |t: f64| circle(radius, w, t);
    let rigid = run(&config.without_gap(), "none", &motion, seconds);
    let figures = |method: &str| {
        let out = run(config, method, &motion, seconds);
        let lost: Vec<f64> = out
            .load
            .iter()
            .zip(&rigid.load)
            .skip(out.load.len() / 4)
            .map(|(a, b)| a - b)
            .collect();
        [rms(lost.iter().copied()), max_abs(lost)]
    };
    let (with, without) = (figures(method), figures("none"));
    [with[0] / without[0], with[1] / without[1]]
}

#[test]
fn uncompensated_the_load_is_off_by_half_the_gap() {
    // the frictionless load ends on the flank that braked it, released and all but at rest
    let [there, back, _] = paper_move("none");
    assert!(
        (there / -0.1 - 1.0).abs() < 1e-3 && (back / 0.1 - 1.0).abs() < 1e-3,
        "{there} {back}"
    );
}

#[test]
fn a_slow_reversal_against_friction_loses_gap_and_wind_up() {
    let config = mill(300.0, 0.0);
    let stroke = Move {
        distance: 1.0,
        velocity: 1.0,
        acceleration: 20.0,
        jerk: 1000.0,
    };
    let out = run(&config, "none", &|t| there_and_back(stroke, 0.2, t), 2.5);
    // while moving at constant speed the shaft carries the friction
    let lost = |index: usize| errors(&out)[index];
    let (forth, back) = (lost(2000), lost(out.load.len() / 2 + 2600));
    let expected = 0.010 + 2.0 * 300.0 / 120.0 * 1e-3;
    assert!(
        ((forth - back) / expected - 1.0).abs() < 1e-3,
        "{} against {expected}",
        forth - back
    );
}

#[test]
fn published_removes_the_settled_offset_of_the_papers_move() {
    let none = paper_move("none");
    let published = paper_move("published");
    for side in 0..2 {
        let ratio = (published[side] / none[side]).abs();
        assert!(ratio < 0.10, "{ratio}");
    }
    let ratio = published[2] / none[2];
    assert!(ratio > 0.2 && ratio < 0.35, "{ratio}");
}

#[test]
fn published_harms_on_arcs_as_known() {
    for w in [2.0, 6.0, 15.0] {
        let [rms, max] = harm_on_a_sine(&AxisConfig::paper(), "published", 5.0, w);
        assert!(rms > 1.2 && max > 1.5, "w {w}: {rms} {max}");
    }
}

#[test]
fn published_makes_circles_about_twice_as_bad() {
    for (radius, feed) in [(10.0, 3000.0), (25.0, 3000.0), (50.0, 3000.0)] {
        let config = mill(0.0, 0.0);
        let (none, published) = (
            circle_error(&config, "none", radius, feed),
            circle_error(&config, "published", radius, feed),
        );
        assert!(
            published[0] > none[0],
            "R {radius}: rms {} against {} um",
            published[0],
            none[0]
        );
        let ratio = published[1] / none[1];
        assert!(ratio > 1.5 && ratio < 2.5, "R {radius}: {ratio}");
    }
}

#[test]
fn the_printed_gain_diverges() {
    let mut config = AxisConfig::paper();
    config.compensation.published.p0 = 1e6;
    config.compensation.published.lambda = Some(0.6);
    let motion = |t: f64| there_and_back(PAPER_MOVE, REST, t);
    let out = run(&config, "published-literal", &motion, 1.7);
    assert!(max_abs(errors(&out)) > 10.0);
    assert!(out.load.iter().all(|p| p.is_finite()));
}

#[test]
fn an_estimator_that_has_run_away_leaves_the_axis_finite() {
    let mut config = AxisConfig::paper();
    config.compensation.published.p0 = 1e12;
    let motion = |t: f64| there_and_back(PAPER_MOVE, REST, t % 1.8);
    let out = run(&config, "published-literal", &motion, 20.0);
    assert!(out.load.iter().all(|p| p.is_finite()));
}

#[test]
fn fixed_mends_a_friction_driven_load_and_harms_a_coasting_one() {
    let [rms, _] = harm_on_a_sine(&mill(400.0, 0.0), "fixed", 10.0, 2.0);
    assert!(rms < 0.75, "{rms}");
    let [rms, _] = harm_on_a_sine(&mill(0.0, 0.0), "fixed", 10.0, 5.0);
    assert!(rms > 1.0, "{rms}");
}

#[test]
fn a_wrongly_told_gap_leaves_its_difference() {
    let stroke = Move {
        distance: 5.0,
        velocity: 20.0,
        acceleration: 200.0,
        jerk: 5000.0,
    };
    let settled = |told: Option<Gap>| {
        let mut config = mill(300.0, 0.0);
        config.compensation.fixed.gap = told;
        let out = run(&config, "fixed", &|t| there_and_back(stroke, 0.5, t), 2.0);
        errors(&out)[1200]
    };
    // reference minus load while moving: half of what was told too little
    let difference = settled(Some(Gap::Um(8.0))) - settled(None);
    assert!((difference - 0.001).abs() < 1e-5, "{difference}");
}

#[test]
fn load_feedback_leaves_no_settled_offset() {
    let [there, back, lost] = paper_move("load-feedback");
    assert!(there.abs() < 1e-3 && back.abs() < 1e-3, "{there} {back}");
    assert!(lost < 0.35 * paper_move("none")[2]);
}

#[test]
fn every_method_is_found_by_its_name_and_says_what_it_is() {
    for method in MethodId::all() {
        assert_eq!(method.name().parse::<MethodId>().unwrap(), method);
        assert!(!method.info().summary.is_empty() && !method.info().source.is_empty());
        let runner = build_runner(&AxisConfig::paper(), method, 1.0).unwrap();
        assert_eq!(runner.info(), method.info());
    }
    let error = "magic".parse::<MethodId>().unwrap_err();
    assert!(
        error
            .to_string()
            .contains("known here: none, fixed, published"),
        "{error}"
    );
    assert!(build_runner(&AxisConfig::paper(), MethodId::NONE, f64::INFINITY).is_err());
}

#[test]
fn a_method_is_written_and_read_by_its_name() {
    for method in MethodId::all() {
        let text = serde_json::to_string(&method).unwrap();
        assert_eq!(text, format!("\"{method}\""));
        assert_eq!(serde_json::from_str::<MethodId>(&text).unwrap(), method);
    }
    let error = serde_json::from_str::<MethodId>("\"fixd\"").unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("unknown variant `fixd`, expected one of `none`, `fixed`"),
        "{error}"
    );
    assert!(
        "fixd"
            .parse::<MethodId>()
            .unwrap_err()
            .to_string()
            .ends_with("did you mean `fixed`?")
    );
}

#[test]
fn flags_say_what_a_method_needs() {
    let of = |flag: fn(MethodId) -> bool| -> Vec<&str> {
        MethodId::all()
            .filter(|method| flag(*method))
            .map(MethodId::name)
            .collect()
    };
    assert_eq!(of(MethodId::is_baseline), ["none"]);
    assert_eq!(MethodId::NONE.name(), "none");
    assert_eq!(MethodId::ADAPTIVE.name(), "adaptive");
    assert_eq!(of(MethodId::needs_fit), ["fitted-lookup"]);
    assert_eq!(of(MethodId::closes_on_load), ["load-feedback"]);
    assert_eq!(
        of(MethodId::needs_load_scale),
        ["load-feedback", "adaptive-inverse", "iterative-learning"]
    );
    assert_eq!(
        of(|method| method.settings_key().is_none()),
        ["none", "load-feedback"]
    );
    assert_eq!(
        "published-literal"
            .parse::<MethodId>()
            .unwrap()
            .settings_key(),
        Some("published")
    );
}
