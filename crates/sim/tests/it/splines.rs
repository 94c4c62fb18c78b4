//! Splines are planned as curves: no stop and no blend between their parts, even on an exact path.
use lostmotion_sim::{Machine, Program, Simulation};

/// Place, velocity and acceleration of X and Y of every sample.
fn planned(text: &str) -> Vec<[[f64; 2]; 3]> {
    let machine = Machine::preset("bench3").unwrap();
    let mut out = Vec::new();
    let source = Program::from_bytes("spline.ngc", text.as_bytes().to_vec());
    Simulation::new(&source, &machine)
        .plan(&mut |samples, _| {
            out.extend(
                samples
                    .iter()
                    .map(|s| [s.position, s.velocity, s.acceleration].map(|c| [c.0[0], c.0[1]])),
            );
            Ok(())
        })
        .unwrap();
    out
}

/// A cubic as G5 has it, and its place by the parameter, from Bernstein's form.
const PART: &str = "G21 G17 G90 G61\nF1200\nG5 X60 Y20 I20 J0 P-10 Q-30\nM2\n";

fn cubic(t: f64) -> [f64; 2] {
    let (s, x, y) = (1.0 - t, [0.0, 20.0, 50.0, 60.0], [0.0, 0.0, -10.0, 20.0]);
    let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
    [x, y].map(|axis| axis.iter().zip(weights).map(|(p, w)| p * w).sum::<f64>())
}

#[test]
fn a_spline_is_travelled_at_the_feed_without_a_stop_on_its_curve() {
    let samples = planned(PART);
    let curve: Vec<[f64; 2]> = (0..=40_000)
        .map(|k| cubic(f64::from(k) / 40_000.0))
        .collect();
    let distance = |a: [f64; 2], b: [f64; 2]| {
        ((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1])).sqrt()
    };
    let length: f64 = curve
        .windows(2)
        .map(|pair| distance(pair[0], pair[1]))
        .sum();
    for sample in samples.iter().step_by(50) {
        let nearest = curve
            .iter()
            .map(|point| distance(*point, sample[0]))
            .fold(f64::INFINITY, f64::min);
        // A micrometre of the spline's tolerance, and what the points of the curve leave out.
        assert!(
            nearest < 1.0e-3 + 2e-3 * 0.5 * 1e-3 + length / 80_000.0,
            "{nearest}"
        );
    }
    // 20 mm/s all the way but for one start and one stop: v/a + a/j more than its length takes.
    let time = (samples.len() - 1) as f64 * 1e-3;
    assert!(
        (time - length / 20.0).abs() < 0.06,
        "{time} s for {length} mm"
    );
    let moving = &samples[80..samples.len() - 80];
    for [_, v, _] in moving {
        let speed = distance(*v, [0.0; 2]);
        assert!((speed - 20.0).abs() < 0.21, "{speed}");
    }
}

#[test]
fn parts_of_a_spline_meet_without_a_step_of_acceleration() {
    let samples = planned(PART);
    let limit = 30_000.0 * 1e-3 * 1.001;
    for pair in samples.windows(2) {
        for (before, after) in pair[0][2].iter().zip(pair[1][2]) {
            let step = (after - before).abs();
            assert!(step <= limit, "{step} mm/s2 in a cycle");
        }
    }
}
