//! The part program of a drawn cell: one of the figures that are milled every day, at a feed and in
//! a size that are drawn, too.

use lostmotion_base::{Random, math};
use std::f64::consts::TAU;
use std::fmt::Write;

/// Feeds, mm/min.
const FEEDS: (f64, f64) = (200.0, 8000.0);
/// Time of the motion that a program is filled up to, s, and the fewest rounds whatever the time. A
/// choice: long enough to learn on, short enough for a part.
const MOTION_S: (f64, f64) = (15.0, 60.0);
const LEAST_ROUNDS: f64 = 2.0;
const MOST_ROUNDS: f64 = 60.0;

/// A program and its name.
pub(super) struct Drawn {
    pub(super) name: String,
    pub(super) text: String,
}

/// A figure, by the length of a round in mm, and what writes one.
struct Outline {
    name: String,
    round_mm: f64,
    start: [f64; 2],
    round: String,
}

pub(super) fn draw(random: &mut Random) -> Drawn {
    let feed = random.log_between(FEEDS.0, FEEDS.1).round();
    let figure = match random.below(7) {
        0 => square(random),
        1 => circle(random),
        2 => pause(random),
        3 => mixture(random, feed),
        4 => zigzag(random),
        5 => slot(random),
        _ => waves(random),
    };
    // G61 and G64 with a tolerance are both common.
    let mode = ["G64 P0.005", "G64 P0.02", "G61"][random.below(3)];
    let [x, y] = figure.start;
    let mut text = format!(
        "G21 G17 G90 G94 G40 G49 G80 G54\n{mode}\nG0 X{x:.3} Y{y:.3} Z5\nG1 Z0 F800\nF{feed}\n"
    );
    let time_s = random.between(MOTION_S.0, MOTION_S.1);
    let rounds = (time_s * feed / 60.0 / figure.round_mm)
        .ceil()
        .clamp(LEAST_ROUNDS, MOST_ROUNDS) as u32;
    for _ in 0..rounds {
        text.push_str(&figure.round);
    }
    text.push_str("G1 Z5\nM2\n");
    Drawn {
        name: format!("{}-f{feed}", figure.name),
        text,
    }
}

/// Along the axes, sharp corners.
fn square(random: &mut Random) -> Outline {
    let side = random.log_between(8.0, 60.0).round();
    Outline {
        name: format!("square{side}"),
        round_mm: 4.0 * side,
        start: [0.0, 0.0],
        round: format!("G1 X{side}\nY{side}\nX0\nY0\n"),
    }
}

/// Full circles, one way or the other.
fn circle(random: &mut Random) -> Outline {
    let radius = random.log_between(3.0, 60.0).round();
    let sense = 2 + random.below(2);
    Outline {
        name: format!("circle{radius}"),
        round_mm: TAU * radius,
        start: [radius, 0.0],
        round: format!("G{sense} X{radius} Y0 I-{radius} J0\n"),
    }
}

/// There and back on a line at an angle, with a rest at each end.
fn pause(random: &mut Random) -> Outline {
    let length = random.log_between(10.0, 60.0).round();
    let angle = random.between(0.0, 0.25 * TAU);
    let rest = random.between(0.05, 0.8);
    let (s, c) = math::sin_cos(angle);
    let (x, y) = (length * c, length * s);
    Outline {
        name: format!("pause{length}"),
        // A rest counts as a length, so that slow and fast feeds get rounds enough.
        round_mm: 2.0 * length + 10.0,
        start: [0.0, 0.0],
        round: format!("G1 X{x:.3} Y{y:.3}\nG4 P{rest:.2}\nG1 X0 Y0\nG4 P{rest:.2}\n"),
    }
}

/// Circles and lines, slow and fast.
fn mixture(random: &mut Random, feed: f64) -> Outline {
    let radius = random.log_between(4.0, 30.0).round();
    let (far, step) = (radius + 20.0, 10.0);
    let slow = (feed * random.between(0.1, 0.5)).round();
    Outline {
        name: format!("mix{radius}"),
        round_mm: 2.0 * TAU * radius + 2.0 * (20.0 + step) * feed / slow,
        start: [radius, 0.0],
        round: format!(
            "G3 X{radius} Y0 I-{radius} J0 F{slow}\nG1 X{far} F{feed}\nY{step}\nX{radius} Y0 F{slow}\nG2 X{radius} Y0 I-{radius} J0 F{feed}\n"
        ),
    }
}

/// Rows there and back at an angle, beside each other.
fn zigzag(random: &mut Random) -> Outline {
    let length = random.log_between(10.0, 50.0).round();
    let step = random.between(0.3, 2.0);
    let (s, c) = math::sin_cos(random.between(0.0, 0.25 * TAU));
    let at = |u: f64, v: f64| format!("X{:.3} Y{:.3}", u * c - v * s, u * s + v * c);
    let mut round = String::new();
    for row in 0..4_u32 {
        let v = step * f64::from(row);
        let (near, far) = if row % 2 == 0 {
            (0.0, length)
        } else {
            (length, 0.0)
        };
        let _ = writeln!(round, "G1 {}\nG1 {}", at(near, v), at(far, v));
    }
    let _ = writeln!(round, "G1 {}", at(0.0, 0.0));
    Outline {
        name: format!("zigzag{length}"),
        round_mm: 4.0 * length + 6.0 * step,
        start: [0.0, 0.0],
        round,
    }
}

/// A slot with round ends, turned.
fn slot(random: &mut Random) -> Outline {
    let length = random.log_between(10.0, 60.0).round();
    let radius = random.log_between(2.0, 12.0);
    let (s, c) = math::sin_cos(random.between(0.0, 0.5 * TAU));
    let at = |u: f64, v: f64| [u * c - v * s, u * s + v * c];
    let [a, b, d, e] = [
        at(0.0, -radius),
        at(length, -radius),
        at(length, radius),
        at(0.0, radius),
    ];
    let [i, j] = at(0.0, radius);
    Outline {
        name: format!("slot{length}"),
        round_mm: 2.0 * length + TAU * radius,
        start: a,
        round: format!(
            "G1 X{:.4} Y{:.4}\nG3 X{:.4} Y{:.4} I{i:.4} J{j:.4}\nG1 X{:.4} Y{:.4}\nG3 X{:.4} Y{:.4} I{:.4} J{:.4}\n",
            b[0], b[1], d[0], d[1], e[0], e[1], a[0], a[1], -i, -j
        ),
    }
}

/// Lissajous figures in short lines.
fn waves(random: &mut Random) -> Outline {
    let (a, b) = (random.between(8.0, 30.0), random.between(8.0, 30.0));
    let (m, n) = [(1.0, 2.0), (3.0, 2.0), (2.0, 3.0)][random.below(3)];
    let lines = 180_u32;
    let point = |line: u32| {
        let angle = TAU * f64::from(line % lines) / f64::from(lines);
        [a * math::sin(m * angle), b * math::cos(n * angle)]
    };
    let (mut round, mut round_mm, mut last) = (String::new(), 0.0, point(0));
    for line in 1..=lines {
        let [x, y] = point(line);
        let _ = writeln!(round, "G1 X{x:.4} Y{y:.4}");
        round_mm += math::hypot(x - last[0], y - last[1]);
        last = [x, y];
    }
    Outline {
        name: format!("waves{m}{n}"),
        round_mm,
        start: point(0),
        round,
    }
}
