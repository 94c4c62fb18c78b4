//! What an operation does, in words.

use super::modes::axes;
use lostmotion_base::math;
use lostmotion_gcode::ops::{ArcFeed, CanonicalOp, Position, Units};

const LETTERS: [char; 9] = ['X', 'Y', 'Z', 'A', 'B', 'C', 'U', 'V', 'W'];

/// Describes an operation; motion goes from `at`.
pub(super) fn describe(op: &CanonicalOp, at: &Position, units: Units) -> String {
    use CanonicalOp as O;
    let unit = units.name();
    match op {
        O::StraightTraverse(end) => straight("rapid", at, end, unit),
        O::StraightFeed(end) => straight("feed", at, end, unit),
        O::ArcFeed(feed) => arc(feed, at, unit),
        O::NurbsFeed(curve) => format!(
            "feed along a curve with {} control points to {}",
            curve.points.len(),
            targets(at, &curve.end)
        ),
        O::StraightProbe(probe) => format!("probe towards {}", targets(at, &probe.end)),
        O::Dwell(seconds) => format!("wait for {seconds} s"),
        O::SetFeedRate { rate, .. } => format!("feed rate {rate}"),
        O::SetG5xOffset { offset, .. } => format!("work offset {}", axes(offset)),
        O::SetG92Offset(offset) => format!("G92 offset {}", axes(offset)),
        O::UseToolLengthOffset(offset) => format!("tool offset {}", axes(offset)),
        O::SelectTool(tool) => format!("make tool {tool} ready"),
        O::ChangeTool(tool) => format!("put tool {tool} into the spindle"),
        O::SetSpindleSpeed { speed, .. } => format!("spindle speed {speed}"),
        O::StartSpindle { clockwise, .. } => format!(
            "start the spindle, {}",
            if *clockwise {
                "clockwise"
            } else {
                "counter-clockwise"
            }
        ),
        O::StopSpindle { .. } => "stop the spindle".to_owned(),
        O::ProgramStop => "stop until told to go on".to_owned(),
        O::ProgramEnd => "end the program".to_owned(),
        other => other.to_string(),
    }
}

/// Moves a place to the end of an operation.
pub(super) fn advance(op: &CanonicalOp, at: &mut Position) {
    match op {
        CanonicalOp::StraightTraverse(end) | CanonicalOp::StraightFeed(end) => *at = *end,
        CanonicalOp::ArcFeed(feed) => *at = feed.position(),
        CanonicalOp::NurbsFeed(curve) => *at = curve.end,
        CanonicalOp::StraightProbe(probe) => *at = probe.stop,
        _ => {}
    }
}

/// Axes that move with their ends.
fn targets(from: &Position, to: &Position) -> String {
    let moved = LETTERS
        .iter()
        .zip(from)
        .zip(to)
        .filter(|((_, from), to)| from != to);
    let texts: Vec<String> = moved
        .map(|((letter, from), to)| format!("{letter}{to} (from {from})"))
        .collect();
    if texts.is_empty() {
        "where it is".to_owned()
    } else {
        texts.join(" ")
    }
}

fn length(from: &Position, to: &Position) -> f64 {
    from.iter()
        .zip(to)
        .take(3)
        .map(|(from, to)| (to - from) * (to - from))
        .sum::<f64>()
        .sqrt()
}

fn straight(how: &str, from: &Position, to: &Position, unit: &str) -> String {
    let length = length(from, to);
    let length = if length > 0.0 {
        format!(", {length:.4} {unit}")
    } else {
        String::new()
    };
    format!("{how} to {}{length}", targets(from, to))
}

fn arc(arc: &ArcFeed, from: &Position, unit: &str) -> String {
    let [first, second, _] = arc.plane.axes();
    let letter = |axis: usize| LETTERS.get(axis).copied().unwrap_or('?');
    let radius = math::hypot(from[first] - arc.center[0], from[second] - arc.center[1]);
    let way = if arc.turns < 0 {
        "clockwise"
    } else {
        "counter-clockwise"
    };
    let turns = if arc.turns.abs() > 1 {
        format!(", {} turns begun", arc.turns.abs())
    } else {
        String::new()
    };
    let center = format!(
        "{}{} {}{}",
        letter(first),
        arc.center[0],
        letter(second),
        arc.center[1]
    );
    format!(
        "{way} arc about {center} of radius {radius:.4} {unit}{turns} to {}",
        targets(from, &arc.position())
    )
}
