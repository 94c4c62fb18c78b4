//! The turning cycles held against brute force: random profiles, every move sampled, the stock as a row of heights.
#![allow(clippy::unwrap_used, clippy::panic)]

use lostmotion_base::math;
use lostmotion_gcode::{CanonicalOp, InterpreterConfig, Program};
use std::fmt::Write;

/// A place: along the travel, and the level.
type Point = [f64; 2];

/// Distance between samples, and between the heights of the stock.
const STEP: f64 = 0.04;
/// Chords of sampled arcs, the rounding of programs, and corners that are left as points.
const SLACK: f64 = 0.012;

struct Random(u64);

impl Random {
    /// A whole number below a bound.
    fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % bound
    }
}

/// How a profile lies in Z and X.
#[derive(Clone, Copy)]
struct Lie {
    facing: bool,
    backwards: bool,
    inside: bool,
}

impl Lie {
    /// Z and X of a place.
    fn zx(self, [along, level]: Point) -> Point {
        let along = if self.backwards { -along } else { along };
        let level = if self.inside { 20.0 - level } else { level };
        if self.facing { [level, along] } else { [along, level] }
    }

    fn back(self, [z, x]: Point) -> Point {
        let [along, level] = if self.facing { [x, z] } else { [z, x] };
        [if self.backwards { -along } else { along }, if self.inside { 20.0 - level } else { level }]
    }

    fn mirrors(self) -> bool {
        self.facing != (self.backwards != self.inside)
    }

    fn words(self, place: Point) -> String {
        let [z, x] = self.zx(place);
        format!("X{x:.4} Z{z:.4}")
    }
}

/// A profile as a subroutine and as a polyline.
struct Profile {
    text: String,
    line: Vec<Point>,
    top: f64,
}

fn arc_points(from: Point, to: Point, center: Point, ccw: bool) -> Vec<Point> {
    let radius = math::hypot(from[0] - center[0], from[1] - center[1]);
    let [a, b] = [from, to].map(|place| math::atan2(place[1] - center[1], place[0] - center[0]));
    let full = std::f64::consts::TAU;
    let sweep = if ccw { (b - a).rem_euclid(full) } else { -(a - b).rem_euclid(full) };
    let count = (2.0 * sweep.abs() * radius / STEP).ceil().max(2.0) as usize;
    let at = |index: usize| a + sweep * index as f64 / count as f64;
    let place = |index| {
        let (sin, cos) = math::sin_cos(at(index));
        [center[0] + radius * cos, center[1] + radius * sin]
    };
    (1..=count).map(place).collect()
}

fn profile(random: &mut Random, lie: Lie, pockets: bool) -> Profile {
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
            _ => ([at[0] + 0.3 + 0.1 * random.below(20) as f64, at[1] + if last { up + (top - at[1]) } else { up }], None),
        };
        match center {
            None => {
                let _ = writeln!(text, "G1 {}", lie.words(to));
                let count = (math::hypot(to[0] - at[0], to[1] - at[1]) / STEP).ceil() as usize;
                line.extend((1..=count).map(|i| [0, 1].map(|axis| at[axis] + (to[axis] - at[axis]) * i as f64 / count as f64)));
            }
            Some(center) => {
                let ccw = (at[0] - center[0]) * (to[1] - center[1]) - (at[1] - center[1]) * (to[0] - center[0]) > 0.0;
                let (from, middle) = (lie.zx(at), lie.zx(center));
                let code = if ccw != lie.mirrors() { 3 } else { 2 };
                let _ = writeln!(text, "G{code} {} I{:.4} K{:.4}", lie.words(to), middle[1] - from[1], middle[0] - from[0]);
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
    line.extend((1..=count).map(|i| [0, 1].map(|axis| at[axis] + (to[axis] - at[axis]) * i as f64 / count as f64)));
    top = top.max(to[1]);
    Profile { text, line, top }
}

/// What a program does after its first rapid: rapid or feed, and the places it goes through.
fn moves(text: &str, lie: Lie) -> Result<Vec<(bool, Vec<Point>)>, String> {
    let mut program = Program::new(text.as_bytes(), InterpreterConfig::default());
    let mut at: Option<Point> = None;
    let mut found = Vec::new();
    for sourced in program.by_ref() {
        let (feed, end, arc) = match sourced.op {
            CanonicalOp::StraightTraverse(end) => (false, [end[2], end[0]], None),
            CanonicalOp::StraightFeed(end) => (true, [end[2], end[0]], None),
            CanonicalOp::ArcFeed(arc) => (true, arc.end, Some((lie.back(arc.center), (arc.turns > 0) != lie.mirrors()))),
            _ => continue,
        };
        let end = lie.back(end);
        if let Some(from) = at {
            let places = match arc {
                Some((center, ccw)) => arc_points(from, end, center, ccw),
                None => {
                    let count = (2.0 * math::hypot(end[0] - from[0], end[1] - from[1]) / STEP).ceil().max(1.0) as usize;
                    (0..=count).map(|i| [0, 1].map(|axis| from[axis] + (end[axis] - from[axis]) * i as f64 / count as f64)).collect()
                }
            };
            found.push((feed, places));
        }
        at = Some(end);
    }
    let diagnostics = program.diagnostics();
    if diagnostics.errors() > 0 { Err(format!("{:?}", diagnostics.kept())) } else { Ok(found) }
}

/// How far a place is from a polyline.
fn away(line: &[Point], place: Point) -> f64 {
    let to_part = |pair: &[Point]| {
        let (a, b) = (pair[0], pair[1]);
        let way = [b[0] - a[0], b[1] - a[1]];
        let length = way[0] * way[0] + way[1] * way[1];
        let share = if length > 0.0 { ((place[0] - a[0]) * way[0] + (place[1] - a[1]) * way[1]) / length } else { 0.0 };
        let share = share.clamp(0.0, 1.0);
        math::hypot(place[0] - a[0] - share * way[0], place[1] - a[1] - share * way[1])
    };
    line.windows(2).map(to_part).fold(f64::INFINITY, f64::min)
}

/// The stock over the profile: what remains at each place along it.
struct Stock {
    from: f64,
    heights: Vec<f64>,
}

impl Stock {
    fn new(line: &[Point], top: f64) -> Stock {
        let count = (line[line.len() - 1][0] / STEP) as usize;
        Stock { from: line[0][0], heights: vec![top; count] }
    }

    fn index(&self, along: f64) -> Option<usize> {
        let index = ((along - self.from) / STEP).round();
        (index >= 0.0 && (index as usize) < self.heights.len()).then_some(index as usize)
    }

    /// Lowest of the heights beside a place: a wall may lie on either side of it.
    fn lowest(heights: &[f64], index: usize) -> f64 {
        heights.iter().skip(index.saturating_sub(1)).take(3).copied().fold(f64::INFINITY, f64::min)
    }

    /// Cuts through places; the deepest cut.
    fn cut(&mut self, places: &[Point]) -> f64 {
        let before = self.heights.clone();
        let mut deepest: f64 = 0.0;
        for place in places {
            if let Some(index) = self.index(place[0]) {
                deepest = deepest.max(Stock::lowest(&before, index) - place[1]);
                self.heights[index] = self.heights[index].min(place[1]);
            }
        }
        deepest
    }
}

/// Lowest level at a place along the travel that keeps a distance from the profile.
fn least(line: &[Point], along: f64, distance: f64) -> f64 {
    let over = |place: &Point| {
        let across = along - place[0];
        (across.abs() <= distance.max(0.5 * STEP)).then(|| place[1] + (distance * distance - across * across).max(0.0).sqrt())
    };
    line.iter().filter_map(over).fold(f64::NEG_INFINITY, f64::max)
}

/// Checks roughing of a profile; false if it was refused for want of room.
fn check_roughing(seed: u64, codes: &[&str], pockets: bool) -> bool {
    let mut random = Random(seed);
    let lie = Lie { facing: seed.is_multiple_of(2), backwards: random.below(2) == 0, inside: random.below(2) == 0 };
    let profile = profile(&mut random, lie, pockets);
    let distance = [0.0, 0.1, 0.3][random.below(3) as usize];
    let depth = 0.3 + 0.1 * random.below(10) as f64;
    let top = profile.top + distance + 0.5;
    let start = lie.words([-1.0 - distance, top]);
    let first = if lie.facing { 72 } else { 71 };
    let mut text = format!("G21 G18 G8 F100\n{}G0 {start}\n", profile.text);
    for code in codes {
        let _ = writeln!(text, "G{first}{code} Q1 {start} D{distance} I{depth:.2} R0.4");
    }
    text.push_str("M2\n");
    let moves = match moves(&text, lie) {
        Ok(moves) => moves,
        Err(told) => {
            assert!(told.contains("profile-distance") || told.contains("ProfileDistance"), "{told}\n{text}");
            return false;
        }
    };
    let mut stock = Stock::new(&profile.line, top);
    for (feed, places) in &moves {
        for place in places {
            let clear = away(&profile.line, *place);
            assert!(
                clear >= distance - SLACK,
                "{place:?} is {clear} from the profile, not {distance}: {feed} {:?} {:?}\n{text}",
                places.first(),
                places.last()
            );
            let near = profile.line.iter().filter(|other| (other[0] - place[0]).abs() <= 1.5 * STEP);
            let ground = near.map(|other| other[1]).reduce(f64::min).unwrap_or(f64::NEG_INFINITY);
            assert!(place[1] >= ground - SLACK, "{place:?} is inside the profile\n{text}");
            // Beside the start of the profile there may be stock that no cut has reached.
            if let Some(index) = stock.index(place[0]).filter(|_| !feed && place[0] > distance + 2.0 * STEP) {
                let beside = Stock::lowest(&stock.heights, index);
                assert!(place[1] >= beside - SLACK, "rapid into the stock at {place:?}\n{text}");
            }
        }
        if *feed {
            let cut = stock.cut(places);
            assert!(cut <= depth + SLACK + STEP, "a cut of {cut}, deeper than {depth}\n{text}");
        }
    }
    let end = profile.line[profile.line.len() - 1][0];
    for (index, height) in stock.heights.iter().enumerate() {
        let along = index as f64 * STEP;
        // The shoulder of a step may lie on either side of a sample.
        let wanted = [-1.5, 0.0, 1.5].map(|side| least(&profile.line, along + side * STEP, distance)).into_iter().fold(f64::MIN, f64::max);
        if along > distance + 2.0 * STEP && along < end - distance - 2.0 * STEP {
            assert!(*height <= wanted + SLACK + STEP, "{height} remains at {along}, above {wanted}\n{text}");
        }
    }
    true
}

#[test]
fn roughing_takes_all_above_the_profile_and_nothing_of_it() {
    let done = (1..=60).filter(|&seed| check_roughing(seed, &[""], true)).count();
    assert!(done > 54, "only {done} of 60 profiles had room for the distance");
}

#[test]
fn roughing_without_pockets_and_then_only_pockets_takes_all() {
    let done = (101..=140).filter(|&seed| check_roughing(seed, &[".1", ".2"], true)).count();
    assert!(done > 35, "only {done} of 40 profiles had room for the distance");
}

#[test]
fn profiles_without_pockets_need_one_cycle() {
    let done = (201..=230).filter(|&seed| check_roughing(seed, &[".1"], false)).count();
    assert!(done > 26, "only {done} of 30 profiles had room for the distance");
}

#[test]
fn finishing_passes_follow_at_their_distances() {
    for seed in 301..=340 {
        let mut random = Random(seed);
        let lie = Lie { facing: false, backwards: random.below(2) == 0, inside: random.below(2) == 0 };
        let profile = profile(&mut random, lie, true);
        let (first, last, passes) = (0.2, 0.05, 1 + random.below(3));
        let start = lie.words([-1.0, profile.top + 1.0]);
        let text = format!("G21 G18 G8 F100\n{}G0 {start}\nG70 Q1 D{first} E{last} P{passes}\nM2\n", profile.text);
        let moves = moves(&text, lie).unwrap_or_else(|told| panic!("{told}\n{text}"));
        let mut pass = passes;
        let mut feeding = false;
        for (feed, places) in moves {
            if feed && !feeding {
                pass -= 1;
            }
            feeding = feed;
            // (pass - 1) * (D - E) / P + E, as documented.
            let distance = pass as f64 * (first - last) / passes as f64 + last;
            for place in places.iter().filter(|_| feed) {
                let clear = away(&profile.line, *place);
                assert!((clear - distance).abs() < SLACK, "{place:?} is {clear} from the profile, not {distance}\n{text}");
            }
        }
        assert_eq!(pass, 0, "{text}");
    }
}
