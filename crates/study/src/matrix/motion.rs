//! The part program of a cell.
//!
//! Plain G-code with every number written out, so that a cell can be looked at, and run with any
//! other control. All figures lie in X and Y; only the pocket moves Z, too. Figures
//! are gone round so often that each axis reverses eight times or more.

use super::factor::{Cell, FEED, SHAPE, WAY};
use lostmotion_base::math;
use std::f64::consts::TAU;
use std::fmt::Write;

/// Least time of a motion, s, within the bounds on the number of turns: enough to learn and to be
/// measured. The lissajous figure, whose turns have more reversals, takes half of it. A choice.
const LEAST_MOTION_S: f64 = 12.0;
/// Bounds on the turns of a figure: the least gives eight reversals of each axis, the most keeps
/// the programs of small figures at high feeds short. A choice.
const LEAST_AND_MOST_TURNS: (f64, f64) = (4.0, 16.0);
/// Half width and half height of the lissajous figure, mm, and the number of lines of one turn. A
/// choice.
const LISSAJOUS: (f64, f64, u32) = (15.0, 10.0, 180);
/// Rows of the zigzag: length and distance in mm, and the angle in degrees at which they lie, so
/// that both axes reverse at every row's end. A choice.
const ZIGZAG: (f64, f64, f64) = (30.0, 1.0, 30.0);
/// The pocket's own feed for its straight cuts, mm/min; its other feeds keep their ratio to it.
const POCKET_FEED_MM_MIN: f64 = 2500.0;
/// The sample part `pocket_helical.ngc`.
const POCKET: &str = include_str!("pocket_helical.ngc");

/// The program of a cell.
pub fn program(cell: &Cell) -> String {
    let feed = cell.number(FEED);
    let text = match cell.level_name(SHAPE) {
        "square" => square(feed),
        "rounded" => rounded(feed),
        "lissajous" => lissajous(feed),
        "zigzag" => zigzag(feed),
        "pocket" => with_feeds(POCKET, feed / POCKET_FEED_MM_MIN),
        _ => circle(cell.number(SHAPE), feed),
    };
    // The finished text is mirrored: one rule for all figures, the sample part included.
    if cell.level_name(WAY) == "cw" {
        mirrored(&text)
    } else {
        text
    }
}

/// Whether the program moves Z, which is then an axis like the others.
pub fn moves_z(cell: &Cell) -> bool {
    cell.level_name(SHAPE) == "pocket"
}

/// How often a figure of some length is gone round.
fn turns(length_mm: f64, feed: f64) -> u32 {
    (LEAST_MOTION_S * feed / 60.0 / length_mm)
        .ceil()
        .clamp(LEAST_AND_MOST_TURNS.0, LEAST_AND_MOST_TURNS.1) as u32
}

/// Head of a program: modes, start and feed.
fn opened(mode: &str, x: f64, y: f64, feed: f64) -> String {
    // Millimetres, XY plane, absolute, feed per minute, no compensation of radius or length, no
    // cycle, G54: all modes are said, so that any control starts alike.
    format!("G21 G17 G90 G94 G40 G49 G80 G54\n{mode}\nG0 X{x} Y{y}\nF{feed}\n")
}

/// End of a program.
fn closed(mut text: String) -> String {
    text.push_str("M2\n");
    text
}

/// Full circles from the rightmost point.
fn circle(radius: f64, feed: f64) -> String {
    let mut text = opened("G64 P0.01", radius, 0.0, feed);
    for _ in 0..turns(TAU * radius, feed) {
        let _ = writeln!(text, "G3 X{radius} Y0 I-{radius} J0");
    }
    closed(text)
}

/// Sharp corners, met exactly.
fn square(feed: f64) -> String {
    let mut text = opened("G61", -10.0, -10.0, feed);
    for _ in 0..turns(80.0, feed) {
        text.push_str("G1 X10\nG1 Y10\nG1 X-10\nG1 Y-10\n");
    }
    closed(text)
}

/// Corner arcs of 5 mm.
fn rounded(feed: f64) -> String {
    let mut text = opened("G64 P0.01", -10.0, -15.0, feed);
    for _ in 0..turns(80.0 + 10.0 * TAU / 2.0, feed) {
        text.push_str("G1 X10\nG3 X15 Y-10 I0 J5\nG1 Y10\nG3 X10 Y15 I-5 J0\nG1 X-10\nG3 X-15 Y10 I0 J-5\nG1 Y-10\nG3 X-10 Y-15 I5 J0\n");
    }
    closed(text)
}

/// 3 to 2, of lines; X reverses six times a turn and Y four times.
fn lissajous(feed: f64) -> String {
    let (a, b, lines) = LISSAJOUS;
    let mut text = opened("G64 P0.01", 0.0, b, feed);
    // A turn is 205 mm long, taken as 200, and has four reversals or more of each axis: half the
    // turns of the other figures do, and half their time.
    for line in 1..=lines * turns(200.0, feed) / 2 {
        // Whole turns close exactly: the same numbers in each.
        let angle = TAU * f64::from(line % lines) / f64::from(lines);
        let (x, y) = (a * math::sin(3.0 * angle), b * math::cos(2.0 * angle));
        let _ = writeln!(text, "G1 X{x:.4} Y{y:.4}");
    }
    closed(text)
}

/// Rows there and back, turned so that both axes move in each.
fn zigzag(feed: f64) -> String {
    let (length, step, degrees) = ZIGZAG;
    let (s, c) = math::sin_cos(degrees.to_radians());
    let at = |u: f64, v: f64| format!("X{:.4} Y{:.4}", u * c - v * s, u * s + v * c);
    let mut text = opened("G64 P0.01", 0.0, 0.0, feed);
    // Each row is a reversal of both axes: twelve are more than are needed.
    for row in 0..turns(length + step, feed).max(12) {
        // Rows alternate their direction: each begins beside the end of the last one.
        let v = step * f64::from(row);
        let (near, far) = if row % 2 == 0 {
            (0.0, length)
        } else {
            (length, 0.0)
        };
        let _ = writeln!(text, "G1 {}\nG1 {}", at(near, v), at(far, v));
    }
    closed(text)
}

/// A program with the numbers that `change` replaces, by letter and number. Comments stay.
fn with_words(text: &str, change: impl Fn(char, &str) -> Option<String>) -> String {
    let mut out = String::with_capacity(text.len() + text.len() / 8);
    let mut rest = text;
    let mut in_comment = false;
    while let Some(letter) = rest.chars().next() {
        // A comment in brackets may hold letters and numbers: copied as it is.
        in_comment = (in_comment || letter == '(') && letter != ')';
        rest = &rest[letter.len_utf8()..];
        out.push(letter);
        if in_comment || !letter.is_ascii_uppercase() {
            continue;
        }
        let end = rest
            .find(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'))
            .unwrap_or(rest.len());
        let number = &rest[..end];
        out.push_str(&change(letter, number).unwrap_or_else(|| number.to_owned()));
        rest = &rest[end..];
    }
    out
}

/// A program with its feeds times a factor.
fn with_feeds(text: &str, factor: f64) -> String {
    with_words(text, |letter, number| {
        match (letter, number.parse::<f64>()) {
            ('F', Ok(feed)) => Some(format!("{:.3}", feed * factor)),
            _ => None,
        }
    })
}

/// The figure seen from behind: gone round the other way.
fn mirrored(text: &str) -> String {
    with_words(text, |letter, number| match (letter, number) {
        // Mirrored at the X axis: arcs change their sense, Y and J their sign.
        ('G', "2") => Some("3".to_owned()),
        ('G', "3") => Some("2".to_owned()),
        ('Y' | 'J', _) => Some(
            number
                .strip_prefix('-')
                .map_or_else(|| format!("-{number}"), str::to_owned),
        ),
        _ => None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirrors_and_feeds_leave_comments_and_other_words_alone() {
        let text = "(G3 Y1 F5)\nG3 X4 Y-2.5 Z-6 I-4 J0 P4 F900\nG17 G40\n";
        assert_eq!(
            mirrored(text),
            "(G3 Y1 F5)\nG2 X4 Y2.5 Z-6 I-4 J-0 P4 F900\nG17 G40\n"
        );
        assert_eq!(
            with_feeds(text, 0.5),
            "(G3 Y1 F5)\nG3 X4 Y-2.5 Z-6 I-4 J0 P4 F450.000\nG17 G40\n"
        );
    }
}
