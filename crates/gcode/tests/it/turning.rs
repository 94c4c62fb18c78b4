//! The turning cycles held against brute force: random profiles, every move sampled, the stock as a
//! row of heights.
use crate::profiles::{Lie, Point, STEP, away, moves, profile};
use lostmotion_base::Random;
use std::fmt::Write;

/// Chords of sampled arcs, the rounding of programs, and corners that are left as points.
const SLACK: f64 = 0.012;

/// The stock over the profile: what remains at each place along it.
struct Stock {
    from: f64,
    heights: Vec<f64>,
}

impl Stock {
    fn new(line: &[Point], top: f64) -> Stock {
        let count = (line[line.len() - 1][0] / STEP) as usize;
        Stock {
            from: line[0][0],
            heights: vec![top; count],
        }
    }

    fn index(&self, along: f64) -> Option<usize> {
        let index = ((along - self.from) / STEP).round();
        (index >= 0.0 && (index as usize) < self.heights.len()).then_some(index as usize)
    }

    /// Lowest of the heights beside a place: a wall may lie on either side of it.
    fn lowest(heights: &[f64], index: usize) -> f64 {
        heights
            .iter()
            .skip(index.saturating_sub(1))
            .take(3)
            .copied()
            .fold(f64::INFINITY, f64::min)
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
        (across.abs() <= distance.max(0.5 * STEP))
            .then(|| place[1] + (distance * distance - across * across).max(0.0).sqrt())
    };
    line.iter()
        .filter_map(over)
        .fold(f64::NEG_INFINITY, f64::max)
}

/// Checks roughing of a profile; false if it was refused for want of room.
fn check_roughing(seed: u64, codes: &[&str], pockets: bool) -> bool {
    let mut random = Random::new(seed);
    let lie = Lie {
        facing: seed.is_multiple_of(2),
        backwards: random.below(2) == 0,
        inside: random.below(2) == 0,
    };
    let profile = profile(&mut random, lie, pockets);
    let distance = [0.0, 0.1, 0.3][random.below(3)];
    let depth = 0.3 + 0.1 * random.below(10) as f64;
    let top = profile.top + distance + 0.5;
    let start = lie.words([-1.0 - distance, top]);
    let first = if lie.facing { 72 } else { 71 };
    let mut text = format!("G21 G18 G8 F100\n{}G0 {start}\n", profile.text);
    for code in codes {
        let _ = writeln!(
            text,
            "G{first}{code} Q1 {start} D{distance} I{depth:.2} R0.4"
        );
    }
    text.push_str("M2\n");
    let moves = match moves(&text, lie) {
        Ok(moves) => moves,
        Err(told) => {
            assert!(
                told.contains("profile-distance") || told.contains("ProfileDistance"),
                "{told}\n{text}"
            );
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
            let near = profile
                .line
                .iter()
                .filter(|other| (other[0] - place[0]).abs() <= 1.5 * STEP);
            let ground = near
                .map(|other| other[1])
                .reduce(f64::min)
                .unwrap_or(f64::NEG_INFINITY);
            assert!(
                place[1] >= ground - SLACK,
                "{place:?} is inside the profile\n{text}"
            );
            // Beside the start of the profile there may be stock that no cut has reached.
            if let Some(index) = stock
                .index(place[0])
                .filter(|_| !feed && place[0] > distance + 2.0 * STEP)
            {
                let beside = Stock::lowest(&stock.heights, index);
                assert!(
                    place[1] >= beside - SLACK,
                    "rapid into the stock at {place:?}\n{text}"
                );
            }
        }
        if *feed {
            let cut = stock.cut(places);
            assert!(
                cut <= depth + SLACK + STEP,
                "a cut of {cut}, deeper than {depth}\n{text}"
            );
        }
    }
    let end = profile.line[profile.line.len() - 1][0];
    for (index, height) in stock.heights.iter().enumerate() {
        let along = index as f64 * STEP;
        // The shoulder of a step may lie on either side of a sample.
        let wanted = [-1.5, 0.0, 1.5]
            .map(|side| least(&profile.line, along + side * STEP, distance))
            .into_iter()
            .fold(f64::MIN, f64::max);
        if along > distance + 2.0 * STEP && along < end - distance - 2.0 * STEP {
            assert!(
                *height <= wanted + SLACK + STEP,
                "{height} remains at {along}, above {wanted}\n{text}"
            );
        }
    }
    true
}

#[test]
fn roughing_takes_all_above_the_profile_and_nothing_of_it() {
    let done = (1..=60)
        .filter(|&seed| check_roughing(seed, &[""], true))
        .count();
    assert!(
        done > 54,
        "only {done} of 60 profiles had room for the distance"
    );
}

#[test]
fn roughing_without_pockets_and_then_only_pockets_takes_all() {
    let done = (101..=140)
        .filter(|&seed| check_roughing(seed, &[".1", ".2"], true))
        .count();
    assert!(
        done > 35,
        "only {done} of 40 profiles had room for the distance"
    );
}

#[test]
fn profiles_without_pockets_need_one_cycle() {
    let done = (201..=230)
        .filter(|&seed| check_roughing(seed, &[".1"], false))
        .count();
    assert!(
        done > 26,
        "only {done} of 30 profiles had room for the distance"
    );
}

#[test]
fn finishing_passes_follow_at_their_distances() {
    for seed in 301..=340 {
        let mut random = Random::new(seed);
        let lie = Lie {
            facing: false,
            backwards: random.below(2) == 0,
            inside: random.below(2) == 0,
        };
        let profile = profile(&mut random, lie, true);
        let (first, last, passes) = (0.2, 0.05, 1 + random.below(3));
        let start = lie.words([-1.0, profile.top + 1.0]);
        let text = format!(
            "G21 G18 G8 F100\n{}G0 {start}\nG70 Q1 D{first} E{last} P{passes}\nM2\n",
            profile.text
        );
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
                assert!(
                    (clear - distance).abs() < SLACK,
                    "{place:?} is {clear} from the profile, not {distance}\n{text}"
                );
            }
        }
        assert_eq!(pass, 0, "{text}");
    }
}
