//! The paper's axis on a move there and back and on sines, a mill's axes on circles: every method,
//! a scan of the published method's two parameters, and the speed of the simulation.
//!
//! `cargo run --release -p lostmotion-methods --example paper`

use lostmotion_drive::AxisOutput;
use lostmotion_methods::{AxisConfig, MethodId, build_runner};
use lostmotion_rig::{
    PAPER_MOVE, circle, circle_error, errors, max_abs, mill, rms, run, setpoints, there_and_back,
};
use std::time::Instant;

const REST_S: f64 = 0.4;

/// Settled load offset there and back, RMS of reference minus load, RMS of the part that the gap
/// causes; rad.
fn move_figures(config: &AxisConfig, method: &str) -> [f64; 4] {
    let seconds = 2.0 * (PAPER_MOVE.duration() + REST_S);
    let motion = |t: f64| there_and_back(PAPER_MOVE, REST_S, t);
    let out = run(config, method, &motion, seconds);
    let rigid = run(&config.without_gap(), "none", &motion, seconds);
    let error = errors(&out);
    let half = error.len() / 2;
    let settled = |end: usize| error[end - 80..end].iter().sum::<f64>() / 80.0;
    let lost = out.load.iter().zip(&rigid.load).map(|(a, b)| a - b);
    [
        settled(half),
        settled(error.len()),
        rms(error.iter().copied()),
        rms(lost),
    ]
}

/// RMS and maximum of reference minus load on a sine, compared with the axis without gap, after two
/// turns.
fn sine_figures(config: &AxisConfig, method: &str, radius: f64, w: f64) -> [f64; 2] {
    let turn = std::f64::consts::TAU / w;
    let motion = |t: f64| circle(radius, w, t);
    let (with, without) = (
        run(config, method, &motion, 8.0 * turn),
        run(&config.without_gap(), "none", &motion, 8.0 * turn),
    );
    let skip = with.load.len() / 4;
    let lost: Vec<f64> = with
        .load
        .iter()
        .zip(&without.load)
        .skip(skip)
        .map(|(a, b)| a - b)
        .collect();
    [rms(lost.iter().copied()), max_abs(lost)]
}

/// Best of many seconds of simulated time, so that other work on the computer counts little.
fn speed(config: &AxisConfig, method: &str) -> Result<f64, Box<dyn std::error::Error>> {
    let points = setpoints(&|t| circle(5.0, 6.0, t), 60.0);
    let mut runner = build_runner(config, method.parse()?, 0.0)?;
    let mut out = AxisOutput::default();
    let mut best = f64::MAX;
    for second in points.chunks(1000) {
        let start = Instant::now();
        for chunk in second.chunks(64) {
            out.clear();
            runner.push(chunk, &mut out)?;
        }
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok(1.0 / best)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let paper = AxisConfig::paper();
    println!(
        "move 0 -> 20 -> 0 rad (40 rad/s, 400 rad/s2, 8000 rad/s3), gap 0.2 rad, no feed-forward"
    );
    println!(
        "{:<20}{:>14}{:>14}{:>12}{:>12}",
        "method", "offset there", "offset back", "rms", "rms of gap"
    );
    for method in MethodId::all() {
        let [there, back, r, m] = move_figures(&paper, method.name());
        println!(
            "{:<20}{there:>14.6}{back:>14.6}{r:>12.6}{m:>12.6}",
            method.name()
        );
    }
    println!("\npart of the load's error that the gap causes on a sine of 5 rad (rms, max; rad)");
    for w in [2.0, 6.0, 15.0] {
        for method in MethodId::all() {
            let [r, m] = sine_figures(&paper, method.name(), 5.0, w);
            println!("w {w:>4} rad/s  {:<20}{r:>12.6}{m:>12.6}", method.name());
        }
    }
    println!("\nradial error of a circle with a 10 um gap, ideal encoders (rms / max, um)");
    for (name, config) in [
        ("no friction", mill(0.0, 0.0)),
        ("300 N, 500 N s/m", mill(300.0, 500.0)),
    ] {
        for (radius, feed) in [
            (5.0, 1000.0),
            (10.0, 3000.0),
            (25.0, 3000.0),
            (50.0, 3000.0),
        ] {
            print!("{name:<18} R {radius:>3} F {feed}");
            let [r, m] = circle_error(&config.without_gap(), "none", radius, feed);
            print!("  without gap {r:.2} / {m:.2}");
            for method in ["none", "fixed", "published", "load-feedback"] {
                let [r, m] = circle_error(&config, method, radius, feed);
                print!("  {method} {r:.2} / {m:.2}");
            }
            println!();
        }
    }
    println!(
        "\npublished: offset there / back / rms of the gap's part over those of none, by p0 and lambda"
    );
    let base = move_figures(&paper, "none");
    for method in ["published", "published-literal"] {
        for p0 in [
            1e-3, 1e-2, 1.0, 1e1, 3e1, 1e2, 3e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8,
        ] {
            print!("{method:<18} p0 {p0:>8.0e}");
            for lambda in [0.2, 0.4, 0.5, 0.6, 0.7, 0.75, 0.77] {
                let mut config = paper.clone();
                config.compensation.published.p0 = p0;
                config.compensation.published.lambda = Some(lambda);
                let f = move_figures(&config, method);
                print!(
                    " | {:>6.2} {:>6.2} {:>5.2}",
                    f[0] / base[0],
                    f[1] / base[1],
                    f[3] / base[3]
                );
            }
            println!();
        }
    }
    println!("\nspeed, times real time: this axis, a slide with friction");
    for method in MethodId::all() {
        let with_friction = mill(300.0, 100.0);
        println!(
            "{:<20}{:>10.0}{:>10.0}",
            method.name(),
            speed(&paper, method.name())?,
            speed(&with_friction, method.name())?
        );
    }
    Ok(())
}
