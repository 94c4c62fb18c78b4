//! Where in the program a record is, without its clock.
//!
//! A record is a stretch of the path, gone along at any pace: times play no part, only places. From
//! a guess of where one point lies, the others follow, each the nearest point of the path not far
//! behind the last. Guesses come from the machine's own coordinates and the program's; where neither
//! fits, from every place of the path in turn, with the shift of coordinates that it would take.

use super::path::{Foot, ProgrammedPath};
use super::short;
use crate::error::SimError;
use lostmotion_base::linalg::{cholesky, cholesky_solve};
use lostmotion_base::math::quantile;
use lostmotion_base::vec::{dot, norm, sub};

/// How far a record may leave the path before its place is lost, mm. A choice: more than any control
/// rounds corners at usual feeds.
const LOST_MM: f64 = 3.0;
/// The same as a part of the size of the record: small ones would fit anywhere.
const LOST_PART: f64 = 0.05;
/// Way that may be lost in a row, in multiples of that distance.
const LOST_WAY: f64 = 4.0;
/// Least distance between the points that are followed, mm.
const STEP_MM: f64 = 0.02;
/// How far a record may go back, besides its error, mm.
const BACK_MM: f64 = 1e-3;
/// Fewest and most points that are followed. Choices: a few make no shape; more take no better place.
const FEWEST_POINTS: usize = 8;
const MOST_POINTS: usize = 40_000;
/// Points of the first look at a place, and distance between two places, mm.
const COARSE_POINTS: usize = 400;
const COARSE_MM: f64 = 0.5;
/// Most places of the first look, and of those that are looked at again.
const MOST_PLACES: f64 = 20_000.0;
const MOST_AGAIN: usize = 200;
/// Share of a record that has to be found in coordinates that are known; where they are not, and at
/// all.
const KNOWN_SHARE: f64 = 0.98;
const LEAST_SHARE: f64 = 0.5;
/// Shift below which coordinates are those that were guessed, mm. A choice: above gaps and errors of
/// guides, below what work offsets differ by.
const NEAR_MM: f64 = 0.05;
/// How far off the path a record may be on the whole, RMS of its better part, mm.
const FIT_MM: f64 = 0.3;
/// The same as a part of the size of the record.
const FIT_PART: f64 = 0.01;
/// Way along the path for one along the record: less where it goes round corners that the path does
/// not have, more where it cuts them.
const WAYS: std::ops::RangeInclusive<f64> = 0.6..=1.7;
/// Steps of the fit of a shift.
const FIT_STEPS: usize = 16;
/// How much narrower each of them takes the points that count.
const NARROWER: f64 = 0.4;
/// Smallest part of the points that has to tell a direction of the shift.
const TOLD_SHARE: f64 = 1e-3;
/// Stretches of a record of which each pulls at a fitted shift once. A choice: some blocks each.
const STRETCHES: usize = 8;
/// Student's t for 95 %, with as many degrees of freedom as the shift leaves of them.
const STUDENT: f64 = 2.571;
/// A fit this many times as wide as the best one, and the channel's own error, is as good.
const AS_GOOD: f64 = 1.5;

/// Whose coordinates the record is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coordinates {
    Machine,
    Program,
    Found,
}

/// A record in its program.
#[derive(Clone, Debug)]
pub(super) struct Located {
    pub(super) coordinates: Coordinates,
    /// Record minus machine coordinates, mm, and how far it may be off (95 %).
    pub(super) shift_mm: [f64; 3],
    pub(super) shift_error_mm: f64,
    /// First and last row that are on the path.
    pub(super) rows: (usize, usize),
    /// Place of the first row, mm along the path.
    pub(super) place_mm: f64,
    /// Other places that fit as well.
    pub(super) others: Vec<f64>,
    /// How far it may leave the path before its place is lost, mm.
    pub(super) lost_mm: f64,
}

/// A point of the record, some way from the last one.
#[derive(Clone, Copy, Debug)]
struct Point {
    row: usize,
    at: [f64; 3],
}

/// A record along a stretch of the path.
#[derive(Clone, Debug, Default)]
struct Track {
    /// First and last point that are on the path.
    from: usize,
    to: usize,
    feet: Vec<Foot>,
}

impl Track {
    fn share(&self, points: &[Point]) -> f64 {
        (self.to + 1 - self.from) as f64 / points.len().max(1) as f64
    }

    /// RMS of the distances, mm.
    fn rms_mm(&self) -> f64 {
        let distances: Vec<f64> = self.feet.iter().map(|foot| foot.distance_mm).collect();
        rms(&distances)
    }

    /// The same of the better three quarters: places where the record leaves the path do not count.
    fn fit_mm(&self) -> f64 {
        let mut distances: Vec<f64> = self.feet.iter().map(|foot| foot.distance_mm).collect();
        distances.sort_unstable_by(f64::total_cmp);
        distances.truncate((3 * distances.len()).div_ceil(4));
        rms(&distances)
    }
}

fn rms(values: &[f64]) -> f64 {
    let square: f64 = values.iter().map(|value| value * value).sum();
    (square / values.len().max(1) as f64).sqrt()
}

/// What is looked for and how well it is known.
struct Search<'a> {
    path: &'a ProgrammedPath,
    /// How far a point of the record may be off itself, mm.
    error_mm: f64,
    lost_mm: f64,
    /// How far off the path it may be on the whole, mm.
    fit_mm: f64,
}

/// Why a record was not found.
#[derive(Debug)]
pub(super) enum Unfound {
    /// It hardly moves, this far.
    Rests(SimError),
    /// It moves, and not along the program.
    Elsewhere(SimError),
}

impl From<SimError> for Unfound {
    fn from(error: SimError) -> Unfound {
        Unfound::Elsewhere(error)
    }
}

impl From<Unfound> for SimError {
    fn from(unfound: Unfound) -> SimError {
        match unfound {
            Unfound::Rests(error) | Unfound::Elsewhere(error) => error,
        }
    }
}

/// Finds a record. `shifted` says whether coordinates other than the machine's and the program's are
/// looked for.
pub(super) fn locate(
    path: &ProgrammedPath,
    record: &[[f64; 3]],
    error_mm: f64,
    shifted: bool,
) -> Result<Located, Unfound> {
    let points = points(record, STEP_MM.max(20.0 * error_mm));
    let search = Search::of(path, &points, error_mm);
    if points.len() < FEWEST_POINTS {
        return Err(Unfound::Rests(few_points(&points, record, error_mm)));
    }
    let known = [
        (Coordinates::Machine, [0.0; 3]),
        (Coordinates::Program, path.origin_mm.map(|mm| -mm)),
    ];
    for (coordinates, shift) in known {
        if let Some(found) = search.known(&points, coordinates, shift) {
            return Ok(search.whole(found, &points, record));
        }
    }
    if !shifted {
        return Err(SimError::refused(
            "the log does not follow the program in the coordinates of the machine or of the program",
            "leave out --no-shift to look for others; check units, signs and order of the columns",
        )
        .into());
    }
    let found = search.shifted(&points)?;
    Ok(search.whole(found, &points, record))
}

/// Noise, in parts of the way from one row to the next, from which on rows are too far apart. A choice.
const NOISE_SHARE: f64 = 0.1;

/// Why a record has too few points: it rests, or goes so far from row to row that it looks like noise.
fn few_points(points: &[Point], record: &[[f64; 3]], error_mm: f64) -> SimError {
    let ways = record.windows(2).map(|pair| norm(sub(pair[1], pair[0])));
    let way_mm = quantile(ways.collect(), 0.5);
    // What bends between rows that are far apart passes for noise.
    if way_mm > STEP_MM && error_mm > NOISE_SHARE * way_mm {
        return SimError::refused(
            format!(
                "the rows of the log are too far apart to tell where in the program they are: {} mm from one to the next",
                short(way_mm)
            ),
            "log at 100 Hz or more; at that rate positions that jump so far are noise",
        );
    }
    let what = format!(
        "the log hardly moves: {} points are {} mm apart or more",
        points.len(),
        short(STEP_MM.max(20.0 * error_mm))
    );
    SimError::refused(what, "log the program while it moves")
}

/// The last row of a further part of a record that is on the path, from the place of its first one
/// on.
pub(super) fn goes_on(
    path: &ProgrammedPath,
    record: &[[f64; 3]],
    place_mm: f64,
    located: &Located,
    error_mm: f64,
) -> usize {
    let points = points(record, STEP_MM.max(20.0 * error_mm));
    let search = Search {
        // A part may be small; how far the whole may leave the path is known.
        lost_mm: located.lost_mm,
        ..Search::of(path, &points, error_mm)
    };
    let feet = search.run(points.iter(), place_mm, located.shift_mm, true);
    let lost = points
        .get(feet.len())
        .map_or(record.len(), |point| point.row);
    lost.max(1) - 1
}

/// Points of a record that are at least a step from one another.
fn points(record: &[[f64; 3]], least_mm: f64) -> Vec<Point> {
    let mut step = least_mm;
    loop {
        let mut points: Vec<Point> = Vec::new();
        for (row, &at) in record.iter().enumerate() {
            let is_far = points
                .last()
                .is_none_or(|last| norm(sub(at, last.at)) >= step);
            if is_far {
                points.push(Point { row, at });
            }
        }
        if points.len() <= MOST_POINTS {
            return points;
        }
        step *= 1.5 * points.len() as f64 / MOST_POINTS as f64;
    }
}

/// Diagonal of the box around points, mm.
fn size(points: &[Point]) -> f64 {
    let side = |axis: usize| {
        let values = points.iter().map(|point| point.at[axis]);
        let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
            (low.min(value), high.max(value))
        });
        (high - low).max(0.0)
    };
    norm([side(0), side(1), side(2)])
}

impl<'a> Search<'a> {
    fn of(path: &'a ProgrammedPath, points: &[Point], error_mm: f64) -> Search<'a> {
        let size_mm = size(points);
        let widest = path.pieces.iter().filter_map(|piece| piece.tolerance_mm);
        let lost_mm = LOST_MM.min(LOST_PART * size_mm);
        Search {
            path,
            error_mm,
            lost_mm: widest.fold(lost_mm, |lost, tolerance| lost.max(4.0 * tolerance)),
            fit_mm: FIT_MM.min(FIT_PART * size_mm).max(error_mm),
        }
    }

    /// Where a point is on the path, `way_mm` behind the last; `reach_mm` is the farthest place up to
    /// now, from which the record does not come back: where the path turns round, the way back is
    /// another place.
    fn next(
        &self,
        last: &Foot,
        reach_mm: &mut f64,
        way_mm: f64,
        at: [f64; 3],
        forward: bool,
    ) -> Foot {
        let slack = STEP_MM + 2.0 * self.error_mm + 2.0 * last.distance_mm.min(self.lost_mm);
        let ahead = 3.0 * way_mm + slack;
        let back = BACK_MM + self.error_mm;
        if forward {
            let foot = self.path.nearest(at, *reach_mm - back, *reach_mm + ahead);
            *reach_mm = reach_mm.max(foot.place_mm);
            foot
        } else {
            let foot = self.path.nearest(at, *reach_mm - ahead, *reach_mm + back);
            *reach_mm = reach_mm.min(foot.place_mm);
            foot
        }
    }

    /// Follows points forward or backward from a place of the first; ends where the path is lost.
    fn run<'p>(
        &self,
        mut points: impl Iterator<Item = &'p Point>,
        place_mm: f64,
        shift: [f64; 3],
        forward: bool,
    ) -> Vec<Foot> {
        let Some(first) = points.next() else {
            return Vec::new();
        };
        let at = sub(first.at, shift);
        let mut last = self
            .path
            .nearest(at, place_mm - 2.0 * STEP_MM, place_mm + 2.0 * STEP_MM);
        let (mut feet, mut before, mut lost_way) = (vec![last], at, 0.0);
        let mut reach_mm = last.place_mm;
        let mut good = 1;
        for point in points {
            let at = sub(point.at, shift);
            let way = norm(sub(at, before));
            last = self.next(&last, &mut reach_mm, way, at, forward);
            before = at;
            feet.push(last);
            if last.distance_mm <= self.lost_mm {
                (lost_way, good) = (0.0, feet.len());
            } else {
                lost_way += way;
            }
            if lost_way > LOST_WAY * self.lost_mm || last.distance_mm > 4.0 * self.lost_mm {
                break;
            }
        }
        feet.truncate(good);
        feet
    }

    /// Follows all points, both ways from one of them.
    fn track(&self, points: &[Point], anchor: usize, place_mm: f64, shift: [f64; 3]) -> Track {
        let (before, after) = points.split_at(anchor);
        let ahead = self.run(after.iter(), place_mm, shift, true);
        // Backward the anchor comes first once more.
        let back = after.iter().take(1).chain(before.iter().rev());
        let mut feet = self.run(back, place_mm, shift, false);
        feet.reverse();
        feet.pop();
        let from = anchor - feet.len();
        feet.extend(ahead);
        Track {
            from,
            to: from + feet.len().max(1) - 1,
            feet,
        }
    }

    /// The best place in coordinates that are known, if there is a good one.
    fn known(&self, points: &[Point], coordinates: Coordinates, shift: [f64; 3]) -> Option<Found> {
        let mut tracks: Vec<Track> = Vec::new();
        for quarter in [0, 2, 1, 3] {
            let anchor = quarter * (points.len() - 1) / 4;
            let at = sub(points.get(anchor)?.at, shift);
            for place in self.path.passages(at, self.lost_mm) {
                let track = self.track(points, anchor, place, shift);
                if track.share(points) >= KNOWN_SHARE && self.is_good(points, &track) {
                    tracks.push(track);
                }
            }
            if !tracks.is_empty() {
                break;
            }
        }
        let best = self.best(&mut tracks)?;
        // A record that is in other coordinates near these fits better with a shift.
        let fitted = self.fit(points, &best, shift);
        let moved = norm(sub(fitted.shift_mm, shift));
        let is_near = moved <= NEAR_MM + 3.0 * self.error_mm || !fitted.is_told;
        is_near.then(|| Found {
            coordinates,
            shift_mm: shift,
            shift_error_mm: 0.0,
            others: others(&tracks, &best),
            track: best,
        })
    }

    /// Whether a record goes along the path, and as far as the path does.
    fn is_good(&self, points: &[Point], track: &Track) -> bool {
        let on_path = points.get(track.from..=track.to).unwrap_or_default();
        let way = |pair: &[Point]| match pair {
            [a, b] => norm(sub(b.at, a.at)),
            _ => 0.0,
        };
        let along: f64 = on_path.windows(2).map(way).sum();
        let place = |foot: Option<&Foot>| foot.map_or(0.0, |foot| foot.place_mm);
        let ways = (place(track.feet.last()) - place(track.feet.first())) / along;
        track.fit_mm() <= self.fit_mm && WAYS.contains(&ways)
    }

    /// Whether a track is as near the path as the best one, where the two are not at one place.
    fn is_as_good(&self, track: &Track, best: &Track) -> bool {
        let both = track.from.max(best.from)..=track.to.min(best.to);
        let (mut own, mut other) = (Vec::new(), Vec::new());
        for point in both {
            let feet = (
                track.feet.get(point - track.from),
                best.feet.get(point - best.from),
            );
            if let (Some(a), Some(b)) = feet
                && (a.place_mm - b.place_mm).abs() > STEP_MM
            {
                own.push(a.distance_mm);
                other.push(b.distance_mm);
            }
        }
        rms(&own) <= AS_GOOD * rms(&other) + self.error_mm + BACK_MM
    }

    /// The best track, and those that fit as well; the first of several.
    fn best(&self, tracks: &mut Vec<Track>) -> Option<Track> {
        let longest = tracks.iter().map(|track| track.feet.len()).max()?;
        // A point more or less at an end says nothing.
        tracks.retain(|track| track.feet.len() * 100 >= longest * 98);
        let by_rms = |a: &&Track, b: &&Track| a.rms_mm().total_cmp(&b.rms_mm());
        let least = tracks.iter().min_by(by_rms)?.clone();
        tracks.retain(|track| self.is_as_good(track, &least));
        let place = |track: &Track| track.feet.first().map_or(0.0, |foot| foot.place_mm);
        tracks.sort_by(|a, b| place(a).total_cmp(&place(b)));
        tracks.first().cloned()
    }

    /// The best place in coordinates that are not known.
    fn shifted(&self, points: &[Point]) -> Result<Found, SimError> {
        let stride = points.len().div_ceil(COARSE_POINTS);
        let coarse: Vec<Point> = points.iter().step_by(stride).copied().collect();
        let grid_mm = COARSE_MM.max(self.path.length_mm / MOST_PLACES);
        let places = (self.path.length_mm / grid_mm).floor() as usize;
        let mut found: Vec<(Track, [f64; 3])> = Vec::new();
        for quarter in [0, 2] {
            let anchor = quarter * (coarse.len() - 1) / 4;
            let Some(at) = coarse.get(anchor).map(|point| point.at) else {
                continue;
            };
            let looks = (0..=places).map(|index| index as f64 * grid_mm);
            let mut first: Vec<(f64, f64, Track, [f64; 3])> = Vec::new();
            for place in looks {
                let shift = sub(at, self.path.point(place));
                let track = self.track(&coarse, anchor, place, shift);
                let share = track.share(&coarse);
                if share >= LEAST_SHARE {
                    first.push((share, track.fit_mm(), track, shift));
                }
            }
            // Those that go far first, then those that fit.
            let by = |share: f64| (share * 10.0).round();
            first.sort_by(|a, b| by(b.0).total_cmp(&by(a.0)).then(a.1.total_cmp(&b.1)));
            first.truncate(MOST_AGAIN);
            for (_, _, track, shift) in first {
                let fitted = self.fit(&coarse, &track, shift);
                found.push((fitted.track, fitted.shift_mm));
            }
            if found
                .iter()
                .any(|(track, _)| track.share(&coarse) >= KNOWN_SHARE)
            {
                break;
            }
        }
        found.sort_by(|(a, _), (b, _)| {
            let by = |track: &Track| (track.share(&coarse) * 20.0).round();
            by(b)
                .total_cmp(&by(a))
                .then(a.fit_mm().total_cmp(&b.fit_mm()))
        });
        // With all points: the best few, each once.
        let mut fitted: Vec<Fitted> = Vec::new();
        for (track, shift) in found.iter().take(MOST_AGAIN / 10) {
            let Some(foot) = track.feet.first() else {
                continue;
            };
            let anchor = track.from * stride;
            let whole = self.track(points, anchor, foot.place_mm, *shift);
            let one = self.fit(points, &whole, *shift);
            let place = |fit: &Fitted| fit.track.feet.first().map_or(0.0, |foot| foot.place_mm);
            if fitted
                .iter()
                .all(|other| (place(other) - place(&one)).abs() > NEAR_MM)
            {
                fitted.push(one);
            }
        }
        let mut tracks: Vec<Track> = fitted.iter().map(|fit| fit.track.clone()).collect();
        let best = self.best(&mut tracks);
        let good =
            best.filter(|best| best.share(points) >= LEAST_SHARE && self.is_good(points, best));
        let Some(best) = good else {
            return Err(SimError::refused(
                "the log does not follow the program anywhere",
                "check that it is the log of this program; check units, signs and order of the columns, and the dialect of the program",
            ));
        };
        let place = |track: &Track| track.feet.first().map(|foot| foot.place_mm);
        let one = fitted
            .into_iter()
            .find(|fit| place(&fit.track) == place(&best))
            .filter(|fit| fit.is_told);
        let Some(one) = one else {
            return Err(SimError::refused(
                "the log moves in too few directions to tell where in the program it is: its coordinates are neither those of the machine nor those of the program",
                "log more of the program, or give the machine the work offset of the log: --offset g54=X,Y,Z",
            ));
        };
        Ok(Found {
            coordinates: Coordinates::Found,
            shift_mm: one.shift_mm,
            shift_error_mm: one.error_mm,
            others: others(&tracks, &best),
            track: best,
        })
    }

    /// The shift with which a record fits best where it is: least squares of the distances across
    /// the path, of the better part of the points.
    fn fit(&self, points: &[Point], track: &Track, shift: [f64; 3]) -> Fitted {
        let mut fitted = Fitted {
            track: track.clone(),
            shift_mm: shift,
            error_mm: 0.0,
            is_told: true,
        };
        // Wide at first: where most of the record goes one way, the few points that tell the shift
        // along it are off by all of it.
        let mut wide = self.lost_mm;
        for _ in 0..FIT_STEPS {
            let track = &fitted.track;
            let distances = track.feet.iter().map(|foot| foot.distance_mm).collect();
            let usual = 2.0 * quantile(distances, 0.5);
            let widest = usual.max(self.error_mm + 1e-6).max(wide);
            wide *= NARROWER;
            let (mut matrix, mut right) = ([[0.0; 3]; 3], [0.0; 3]);
            let (mut count, mut square) = (0.0, 0.0);
            for (point, foot) in points.iter().skip(track.from).zip(&track.feet) {
                if foot.distance_mm > widest {
                    continue;
                }
                let (off, along) = self.path.off(foot, sub(point.at, fitted.shift_mm));
                let part = dot(off, along);
                count += 1.0;
                square += dot(off, off) - part * part;
                for i in 0..3 {
                    // Across the path alone: along it nothing is told.
                    right[i] += off[i] - part * along[i];
                    for j in 0..3 {
                        let one = if i == j { 1.0 } else { 0.0 };
                        matrix[i][j] += one - along[i] * along[j];
                    }
                }
            }
            let lower = cholesky(&matrix, TOLD_SHARE * count);
            fitted.is_told = (0..3).all(|i| lower[i][i] * lower[i][i] > 1.001 * TOLD_SHARE * count);
            let step = cholesky_solve(&lower, &right);
            let worst = (0..3).map(|i| matrix[i][i]).fold(f64::INFINITY, f64::min);
            fitted.error_mm = 2.0 * (square / count.max(1.0) / worst.max(1.0)).sqrt();
            for (shift, step) in fitted.shift_mm.iter_mut().zip(step) {
                *shift += step;
            }
            let Some(first) = track.feet.first() else {
                break;
            };
            let (from, place) = (track.from, first.place_mm);
            // The place of the first point moves with the shift.
            let near = points.get(from).map_or(place, |point| {
                let at = sub(point.at, fitted.shift_mm);
                let reach = norm(step) + 2.0 * STEP_MM;
                self.path.nearest(at, place - reach, place + reach).place_mm
            });
            fitted.track = self.track(points, from, near, fitted.shift_mm);
            if norm(step) < 1e-7 && wide < self.error_mm.max(1e-4) {
                break;
            }
        }
        let residue_mm = self.pulled(points, &fitted);
        fitted.error_mm = fitted.error_mm.max(residue_mm);
        fitted
    }

    /// How far what is left of the distances may have pulled a shift (95 %), mm. Neighbours are off
    /// alike, by a fault or an angle, so that points do not count one by one: each stretch of the
    /// record pulls once, and the shift is as uncertain as these pulls are large.
    fn pulled(&self, points: &[Point], fitted: &Fitted) -> f64 {
        let track = &fitted.track;
        let stretch = track.feet.len().div_ceil(STRETCHES).max(1);
        let mut matrix = [[0.0; 3]; 3];
        let mut pulls = [[0.0; 3]; STRETCHES];
        let on_path = points.iter().skip(track.from).zip(&track.feet);
        for (index, (point, foot)) in on_path.enumerate() {
            let (off, along) = self.path.off(foot, sub(point.at, fitted.shift_mm));
            let part = dot(off, along);
            let Some(pull) = pulls.get_mut(index / stretch) else {
                break;
            };
            for i in 0..3 {
                pull[i] += off[i] - part * along[i];
                for j in 0..3 {
                    let one = if i == j { 1.0 } else { 0.0 };
                    matrix[i][j] += one - along[i] * along[j];
                }
            }
        }
        let lower = cholesky(&matrix, TOLD_SHARE * track.feet.len() as f64);
        let mut square = [0.0; 3];
        for pull in &pulls {
            let moved = cholesky_solve(&lower, pull);
            for (square, moved) in square.iter_mut().zip(moved) {
                *square += moved * moved;
            }
        }
        // Three of the pulls are taken up by the shift itself.
        let spare = STRETCHES as f64 / (STRETCHES - 3) as f64;
        STUDENT * (spare * square.iter().copied().fold(0.0, f64::max)).sqrt()
    }

    /// With the rows before the first point and behind the last, where they stand still.
    fn whole(&self, found: Found, points: &[Point], record: &[[f64; 3]]) -> Located {
        let track = &found.track;
        let row = |at: usize| points.get(at).map_or(0, |point| point.row);
        let last = points
            .get(track.to + 1)
            .map_or(record.len(), |point| point.row);
        Located {
            coordinates: found.coordinates,
            shift_mm: found.shift_mm,
            shift_error_mm: found.shift_error_mm,
            rows: (row(track.from), last.max(1) - 1),
            place_mm: track.feet.first().map_or(0.0, |foot| foot.place_mm),
            others: found.others,
            lost_mm: self.lost_mm,
        }
    }
}

struct Found {
    coordinates: Coordinates,
    shift_mm: [f64; 3],
    shift_error_mm: f64,
    track: Track,
    others: Vec<f64>,
}

struct Fitted {
    track: Track,
    shift_mm: [f64; 3],
    error_mm: f64,
    /// Whether every direction of the shift is told.
    is_told: bool,
}

/// Places of the first points of the other tracks.
fn others(tracks: &[Track], best: &Track) -> Vec<f64> {
    let place = |track: &Track| track.feet.first().map(|foot| foot.place_mm);
    let own = place(best).unwrap_or_default();
    let all = tracks.iter().filter_map(place);
    all.filter(|other| (other - own).abs() > 2.0 * STEP_MM)
        .collect()
}

/// The feet of rows one after the other, from a place on.
pub(super) fn follow(
    path: &ProgrammedPath,
    rows: impl Iterator<Item = [f64; 3]>,
    place_mm: f64,
    error_mm: f64,
) -> Vec<Foot> {
    let search = Search {
        path,
        error_mm,
        lost_mm: LOST_MM,
        fit_mm: FIT_MM,
    };
    let mut feet: Vec<Foot> = Vec::new();
    let mut before = None;
    let mut reach_mm = place_mm;
    for at in rows {
        let foot = match (feet.last(), before) {
            (Some(last), Some(before)) => {
                search.next(last, &mut reach_mm, norm(sub(at, before)), at, true)
            }
            _ => path.nearest(at, place_mm - 2.0 * STEP_MM, place_mm + 2.0 * STEP_MM),
        };
        before = Some(at);
        feet.push(foot);
    }
    feet
}
