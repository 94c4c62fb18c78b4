//! Random profiles of turning cycles, and the places that the cycles' moves go through.

use lostmotion_base::{Random, math};
use lostmotion_gcode::{CanonicalOp, InterpreterConfig, Program};
use std::fmt::Write;

/// A place: along the travel, and the level.
pub(crate) type Point = [f64; 2];

/// Distance between samples, and between the heights of the stock.
pub(crate) const STEP: f64 = 0.04;

/// How a profile lies in Z and X.
#[derive(Clone, Copy)]
pub(crate) struct Lie {
    pub(crate) facing: bool,
    pub(crate) backwards: bool,
    pub(crate) inside: bool,
}

impl Lie {
    /// Z and X of a place.
    pub(crate) fn zx(self, [along, level]: Point) -> Point {
        let along = if self.backwards { -along } else { along };
        let level = if self.inside { 20.0 - level } else { level };
        if self.facing {
            [level, along]
        } else {
            [along, level]
        }
    }

    pub(crate) fn back(self, [z, x]: Point) -> Point {
        let [along, level] = if self.facing { [x, z] } else { [z, x] };
        [
            if self.backwards { -along } else { along },
            if self.inside { 20.0 - level } else { level },
        ]
    }

    pub(crate) fn mirrors(self) -> bool {
        self.facing != (self.backwards != self.inside)
    }

    pub(crate) fn words(self, place: Point) -> String {
        let [z, x] = self.zx(place);
        format!("X{x:.4} Z{z:.4}")
    }
}

/// A profile as a subroutine and as a polyline.
pub(crate) struct Profile {
    pub(crate) text: String,
    pub(crate) line: Vec<Point>,
    pub(crate) top: f64,
}

fn arc_points(from: Point, to: Point, center: Point, ccw: bool) -> Vec<Point> {
    let radius = math::hypot(from[0] - center[0], from[1] - center[1]);
    let [a, b] = [from, to].map(|place| math::atan2(place[1] - center[1], place[0] - center[0]));
    let full = std::f64::consts::TAU;
    let sweep = if ccw {
        (b - a).rem_euclid(full)
    } else {
        -(a - b).rem_euclid(full)
    };
    let count = (2.0 * sweep.abs() * radius / STEP).ceil().max(2.0) as usize;
    let at = |index: usize| a + sweep * index as f64 / count as f64;
    let place = |index| {
        let (sin, cos) = math::sin_cos(at(index));
        [center[0] + radius * cos, center[1] + radius * sin]
    };
    (1..=count).map(place).collect()
}

pub(crate) fn profile(random: &mut Random, lie: Lie, pockets: bool) -> Profile {
    let mut at = [0.0, 3.0];
    let mut text = format!("o1 sub\nG0 {}\n", lie.words(at));
    let (mut line, mut top) = (vec![at], at[1]);
    let pieces = 3 + random.below(6);
    for index in 0..pieces {
        let size = 0.3 + 0.1 * random.below(20) as f64;
        let last = index + 1 == pieces;
        // What lies before the profile is nobody's concern, so it does not begin with a fall.
        let rises = last || index == 0 || !pockets || random.below(2) == 0 || at[1] - size < 0.5;
        let up = if rises { size } else { -size };
        let (to, center) = match random.below(6) {
            0 if !last => ([at[0] + size, at[1]], None),
            1 if !last => ([at[0], at[1] + up], None),
            2 => ([at[0] + size, at[1] + up], Some([at[0] + size, at[1]])),
            3 => ([at[0] + size, at[1] + up], Some([at[0], at[1] + up])),
            _ => (
                [
                    at[0] + 0.3 + 0.1 * random.below(20) as f64,
                    at[1] + if last { up + (top - at[1]) } else { up },
                ],
                None,
            ),
        };
        match center {
            None => {
                let _ = writeln!(text, "G1 {}", lie.words(to));
                let count = (math::hypot(to[0] - at[0], to[1] - at[1]) / STEP).ceil() as usize;
                line.extend((1..=count).map(|i| {
                    [0, 1].map(|axis| at[axis] + (to[axis] - at[axis]) * i as f64 / count as f64)
                }));
            }
            Some(center) => {
                let ccw = (at[0] - center[0]) * (to[1] - center[1])
                    - (at[1] - center[1]) * (to[0] - center[0])
                    > 0.0;
                let (from, middle) = (lie.zx(at), lie.zx(center));
                let code = if ccw != lie.mirrors() { 3 } else { 2 };
                let _ = writeln!(
                    text,
                    "G{code} {} I{:.4} K{:.4}",
                    lie.words(to),
                    middle[1] - from[1],
                    middle[0] - from[0]
                );
                line.extend(arc_points(at, to, center, ccw));
            }
        }
        at = to;
        top = top.max(at[1]);
    }
    // It ends higher than it begins: otherwise it is an inside one.
    let to = [at[0] + 0.3, top.max(at[1]) + 0.3];
    let _ = writeln!(text, "G1 {}\no1 endsub", lie.words(to));
    let count = (math::hypot(to[0] - at[0], to[1] - at[1]) / STEP).ceil() as usize;
    line.extend(
        (1..=count)
            .map(|i| [0, 1].map(|axis| at[axis] + (to[axis] - at[axis]) * i as f64 / count as f64)),
    );
    top = top.max(to[1]);
    Profile { text, line, top }
}

/// What a program does after its first rapid: rapid or feed, and the places it goes through.
pub(crate) fn moves(text: &str, lie: Lie) -> Result<Vec<(bool, Vec<Point>)>, String> {
    let mut program = Program::new(text.as_bytes(), InterpreterConfig::default());
    let mut at: Option<Point> = None;
    let mut found = Vec::new();
    for sourced in program.by_ref() {
        let (feed, end, arc) = match sourced.op {
            CanonicalOp::StraightTraverse(end) => (false, [end[2], end[0]], None),
            CanonicalOp::StraightFeed(end) => (true, [end[2], end[0]], None),
            CanonicalOp::ArcFeed(arc) => (
                true,
                arc.end,
                Some((lie.back(arc.center), (arc.turns > 0) != lie.mirrors())),
            ),
            _ => continue,
        };
        let end = lie.back(end);
        if let Some(from) = at {
            let places = match arc {
                Some((center, ccw)) => arc_points(from, end, center, ccw),
                None => {
                    let count = (2.0 * math::hypot(end[0] - from[0], end[1] - from[1]) / STEP)
                        .ceil()
                        .max(1.0) as usize;
                    (0..=count)
                        .map(|i| {
                            [0, 1].map(|axis| {
                                from[axis] + (end[axis] - from[axis]) * i as f64 / count as f64
                            })
                        })
                        .collect()
                }
            };
            found.push((feed, places));
        }
        at = Some(end);
    }
    let diagnostics = program.diagnostics();
    if diagnostics.errors() > 0 {
        Err(format!("{:?}", diagnostics.kept()))
    } else {
        Ok(found)
    }
}

/// How far a place is from a polyline.
pub(crate) fn away(line: &[Point], place: Point) -> f64 {
    let to_part = |pair: &[Point]| {
        let (a, b) = (pair[0], pair[1]);
        let way = [b[0] - a[0], b[1] - a[1]];
        let length = way[0] * way[0] + way[1] * way[1];
        let share = if length > 0.0 {
            ((place[0] - a[0]) * way[0] + (place[1] - a[1]) * way[1]) / length
        } else {
            0.0
        };
        let share = share.clamp(0.0, 1.0);
        math::hypot(
            place[0] - a[0] - share * way[0],
            place[1] - a[1] - share * way[1],
        )
    };
    line.windows(2).map(to_part).fold(f64::INFINITY, f64::min)
}
