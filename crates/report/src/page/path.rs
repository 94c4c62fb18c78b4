//! The path of the tool for a page: stretches of the command, each with the largest error of every
//! method on it, in bounded memory for programs of any length.

use lostmotion_sim::{ContourPoint, Limiter};

/// A jump of the commanded tip within one servo tick that no machine makes, mm: the zero of the
/// program has changed. A choice: 20 m/s at 4 kHz.
const JUMP_MM: f64 = 5.0;
/// Height of a unit vector along a tool that stands upright, by the roundings of kinematics and of the
/// page: half a degree.
const UPRIGHT: f32 = 0.99996;
/// Group size from which on stretches are joined across anything: nothing else is left to join.
const LAST_RESORT_TICKS: u64 = 1 << 24;
/// Most stretches that are looked back on when a straight line is drawn through them. A choice that
/// bounds the work.
const LONGEST_LOOK_BACK: usize = 12;

/// A stretch of the path: from its place to that of the next one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Stretch {
    /// Running number of its first tick among those at which anything moves.
    pub(super) tick: u64,
    /// Time of that tick, s.
    pub(super) time_s: f64,
    /// Commanded tip then, from the program's zero, mm.
    pub(super) from_mm: [f32; 3],
    /// Direction in which the error counts positive.
    pub(super) normal: [f32; 3],
    /// Unit vector along the commanded tool, from its tip to the spindle.
    pub(super) tool: [f32; 3],
    /// Length of the command's way, mm.
    pub(super) length_mm: f32,
    /// File of the block, 0 for the program itself.
    pub(super) file: u32,
    /// Line of the block.
    pub(super) line: u32,
    /// Whether it is part of a G0 move.
    pub(super) rapid: bool,
    /// What keeps the motion from going faster for most of it.
    pub(super) limiter: Limiting,
    /// Whether no line leads to it from the stretch before.
    pub(super) broken: bool,
}

/// A limiter, and by how many ticks it leads the others: if one has more than half of all it is the
/// one (the majority vote of Boyer and Moore), else it is one of those that come often.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Limiting {
    pub(super) limiter: Option<Limiter>,
    lead: u32,
}

impl Limiting {
    /// Takes another for some ticks.
    fn add(&mut self, other: Limiting) {
        if self.limiter == other.limiter {
            self.lead = self.lead.saturating_add(other.lead);
        } else if self.lead >= other.lead {
            self.lead -= other.lead;
        } else {
            *self = Limiting {
                lead: other.lead - self.lead,
                ..other
            };
        }
    }
}

/// Where a method is in the list of stretches.
#[derive(Clone, Copy, Debug, Default)]
struct Cursor {
    seen: u64,
    stretch: usize,
}

/// The path that all methods share, and the error of each.
#[derive(Clone, Debug)]
pub(super) struct PathRecorder {
    capacity: usize,
    /// Most ticks of a stretch.
    group: u64,
    /// Ticks at which anything moves, of the method that came farthest.
    seen: u64,
    last_mm: [f64; 3],
    /// Time of a tick, s; 0 until two are known.
    tick_s: f64,
    last_s: f64,
    stretches: Vec<Stretch>,
    /// For each method the signed error of largest magnitude on every stretch, um.
    peaks: Vec<Vec<f32>>,
    cursors: Vec<Cursor>,
}

impl PathRecorder {
    /// For this many methods, holding at most `2 * capacity` stretches.
    pub(super) fn new(methods: usize, capacity: usize) -> PathRecorder {
        PathRecorder {
            capacity: capacity.max(16),
            group: 1,
            seen: 0,
            last_mm: [0.0; 3],
            tick_s: 0.0,
            last_s: f64::NEG_INFINITY,
            stretches: Vec::new(),
            peaks: vec![Vec::new(); methods],
            cursors: vec![Cursor::default(); methods],
        }
    }

    /// Takes a servo tick of a method.
    pub(super) fn push(&mut self, method: usize, point: &ContourPoint) {
        let Some(Cursor { seen, .. }) = self.cursors.get(method).copied() else {
            return;
        };
        if !point.moving || !point.commanded_mm.iter().all(|c| c.is_finite()) {
            return;
        }
        // The command is the same for all methods: whoever is farthest draws the path.
        if seen == self.seen {
            self.extend(point);
        }
        let Some(cursor) = self.cursors.get_mut(method) else {
            return;
        };
        while self
            .stretches
            .get(cursor.stretch + 1)
            .is_some_and(|next| next.tick <= cursor.seen)
        {
            cursor.stretch += 1;
        }
        cursor.seen += 1;
        let peak = self
            .peaks
            .get_mut(method)
            .and_then(|peaks| peaks.get_mut(cursor.stretch));
        let error = point.error_um as f32;
        if let Some(peak) = peak
            && error.abs() > peak.abs()
        {
            *peak = error;
        }
    }

    /// Goes on along the command by one tick.
    fn extend(&mut self, point: &ContourPoint) {
        let at = point.commanded_mm;
        let way = [0, 1, 2].map(|axis| at[axis] - self.last_mm[axis]);
        let way = (way[0] * way[0] + way[1] * way[1] + way[2] * way[2]).sqrt();
        let broken = self.stretches.is_empty() || way > JUMP_MM;
        if !broken {
            let step = point.time_s - self.last_s;
            if step > 0.0 && (self.tick_s <= 0.0 || step < self.tick_s) {
                self.tick_s = step;
            }
        }
        let (file, line) = (point.block.span.file, point.block.span.line);
        let goes_on = |last: &Stretch| {
            !broken
                && last.rapid == point.rapid
                && (last.file, last.line) == (file, line)
                && self.seen - last.tick < self.group
        };
        let limiting = Limiting {
            limiter: point.limiter,
            lead: 1,
        };
        match self.stretches.last_mut() {
            // The way to this tick belongs to the stretch before, whether it ends here or not.
            Some(last) if !broken => last.length_mm += way as f32,
            _ => {}
        }
        let goes_on = self.stretches.last().is_some_and(goes_on);
        if let Some(last) = self.stretches.last_mut().filter(|_| goes_on) {
            last.limiter.add(limiting);
        } else {
            if self.stretches.len() >= 2 * self.capacity {
                self.shrink(self.capacity);
            }
            self.stretches.push(Stretch {
                tick: self.seen,
                time_s: point.time_s,
                from_mm: at.map(|c| c as f32),
                normal: point.normal.map(|c| c as f32),
                tool: point.tool.map(|c| c as f32),
                length_mm: 0.0,
                file,
                line,
                rapid: point.rapid,
                limiter: limiting,
                broken,
            });
            for peaks in &mut self.peaks {
                peaks.push(0.0);
            }
        }
        self.last_mm = at;
        self.last_s = point.time_s;
        self.seen += 1;
    }

    /// Joins neighbours until at most `limit` stretches are left. The largest error of each stays.
    fn shrink(&mut self, limit: usize) {
        while self.stretches.len() > limit.max(2) && self.group < u64::MAX / 4 {
            self.group *= 2;
            let group = self.group;
            // Blocks stay apart as long as they are long enough to be seen.
            self.join(|first, next, _, end| {
                let ticks = end - first.tick;
                let same = (first.file, first.line) == (next.file, next.line);
                group > LAST_RESORT_TICKS
                    || (!next.broken
                        && first.rapid == next.rapid
                        && ticks <= group
                        && (same || ticks <= group / 4))
            });
        }
    }

    /// Joins a stretch with those after it as long as `may` says so of the first one, the next one,
    /// its index, and the tick at which it ends.
    fn join(&mut self, mut may: impl FnMut(&Stretch, &Stretch, usize, u64) -> bool) {
        let mut into = Vec::with_capacity(self.stretches.len());
        let mut kept: Vec<Stretch> = Vec::with_capacity(self.stretches.len());
        for (index, stretch) in self.stretches.iter().enumerate() {
            let end = self
                .stretches
                .get(index + 1)
                .map_or(self.seen, |next| next.tick);
            match kept.last_mut() {
                Some(last) if may(last, stretch, index, end) => {
                    last.length_mm += stretch.length_mm;
                    last.limiter.add(stretch.limiter);
                }
                _ => kept.push(*stretch),
            }
            into.push(kept.len() - 1);
        }
        for peaks in &mut self.peaks {
            let mut joined = vec![0.0_f32; kept.len()];
            for (peak, into) in peaks.iter().zip(&into) {
                if let Some(joined) = joined.get_mut(*into)
                    && peak.abs() > joined.abs()
                {
                    *joined = *peak;
                }
            }
            *peaks = joined;
        }
        for cursor in &mut self.cursors {
            cursor.stretch = into.get(cursor.stretch).copied().unwrap_or(0);
        }
        self.stretches = kept;
    }

    /// Whether the tool leans anywhere so far.
    pub(super) fn leans(&self) -> bool {
        leans(&self.stretches)
    }

    /// The path with at most `limit` stretches: straight ones on which no error changes by more
    /// than `flat_um` become one, then neighbours are joined as far as it takes.
    pub(super) fn finish(mut self, flat_um: f32, limit: usize) -> Path {
        let places: Vec<[f32; 3]> = self.stretches.iter().map(|s| s.from_mm).collect();
        let extent = extent_mm(&places);
        // A fifth of a pixel of a screen of 4,000.
        let near = extent * 5e-5;
        let peaks = self.peaks.clone();
        let mut first = 0;
        let of =
            |peaks: &Vec<f32>, at: usize| peaks.get(at).map_or([f32::NAN; 2], |peak| [*peak; 2]);
        // Smallest and largest error of each method from the first stretch on.
        let mut ranges: Vec<[f32; 2]> = peaks.iter().map(|peaks| of(peaks, 0)).collect();
        self.join(|last, next, at, _| {
            let mut flat = true;
            for ([low, high], peaks) in ranges.iter_mut().zip(&peaks) {
                let [peak, _] = of(peaks, at);
                (*low, *high) = (low.min(peak), high.max(peak));
                flat &= *high - *low <= flat_um;
            }
            let end = places.get(at + 1).or(places.get(at));
            let straight = || {
                let (Some(from), Some(to)) = (places.get(first), end) else {
                    return false;
                };
                places
                    .get(first + 1..=at)
                    .unwrap_or_default()
                    .iter()
                    .all(|place| off_line(place, from, to) <= near)
            };
            let joins = at - first < LONGEST_LOOK_BACK
                && !next.broken
                && last.rapid == next.rapid
                && (last.file, last.line) == (next.file, next.line)
                && flat
                && straight();
            if !joins {
                first = at;
                for (range, peaks) in ranges.iter_mut().zip(&peaks) {
                    *range = of(peaks, at);
                }
            }
            joins
        });
        self.shrink(limit);
        // What a method never came to, because the machine stops, has no error.
        for (peaks, cursor) in self.peaks.iter_mut().zip(&self.cursors) {
            for (peak, stretch) in peaks.iter_mut().zip(&self.stretches) {
                if stretch.tick >= cursor.seen {
                    *peak = f32::NAN;
                }
            }
        }
        // The end of the last stretch.
        if let Some(last) = self.stretches.last().copied() {
            self.stretches.push(Stretch {
                tick: self.seen,
                time_s: self.last_s,
                from_mm: self.last_mm.map(|c| c as f32),
                length_mm: 0.0,
                broken: false,
                ..last
            });
            for peaks in &mut self.peaks {
                peaks.push(0.0);
            }
        }
        Path {
            tick_s: self.tick_s,
            leans: leans(&self.stretches),
            stretches: self.stretches,
            peaks: self.peaks,
        }
    }
}

/// Whether the tool leans anywhere: on machines of three axes it stays upright.
fn leans(stretches: &[Stretch]) -> bool {
    stretches.iter().any(|stretch| stretch.tool[2] < UPRIGHT)
}

/// A path that is complete.
#[derive(Clone, Debug, Default)]
pub(super) struct Path {
    /// Time between two ticks, s.
    tick_s: f64,
    /// Its stretches, and behind them its end.
    pub(super) stretches: Vec<Stretch>,
    /// For each method the signed error of largest magnitude on every stretch, um.
    pub(super) peaks: Vec<Vec<f32>>,
    /// Whether the tool leans anywhere.
    pub(super) leans: bool,
}

impl Path {
    /// Mean speed on a stretch, mm/s.
    pub(super) fn speed_mm_s(&self, index: usize) -> f32 {
        let of = |index: usize| self.stretches.get(index);
        let (Some(this), Some(next)) = (of(index), of(index + 1)) else {
            return 0.0;
        };
        let seconds = (next.tick - this.tick) as f64 * self.tick_s;
        if seconds > 0.0 {
            this.length_mm / seconds as f32
        } else {
            0.0
        }
    }
}

/// Largest extent of places along an axis, mm.
fn extent_mm(places: &[[f32; 3]]) -> f32 {
    (0..3)
        .map(|axis| {
            let along = || places.iter().map(|place| place[axis]);
            along().fold(f32::NEG_INFINITY, f32::max) - along().fold(f32::INFINITY, f32::min)
        })
        .fold(0.0, f32::max)
}

/// Distance of a place from the line between two others.
fn off_line(place: &[f32; 3], from: &[f32; 3], to: &[f32; 3]) -> f32 {
    let way = [0, 1, 2].map(|axis| to[axis] - from[axis]);
    let off = [0, 1, 2].map(|axis| place[axis] - from[axis]);
    let dot = |a: [f32; 3], b: [f32; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let square = dot(way, way);
    let along = if square > 0.0 {
        (dot(off, way) / square).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let rest = [0, 1, 2].map(|axis| off[axis] - along * way[axis]);
    dot(rest, rest).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_limits_more_than_half_of_a_stretch_limits_it() {
        let one = |limiter| Limiting { limiter, lead: 1 };
        for count in 1..60_u64 {
            let of = |tick: u64| match tick * 37 % 11 {
                0..6 => Some(Limiter::Feed),
                6..9 => Some(Limiter::Tolerance),
                _ => None,
            };
            // Joined in an order that has nothing to do with the ticks.
            let mut parts: Vec<Limiting> = (0..count).map(|tick| one(of(tick))).collect();
            while parts.len() > 1 {
                let last = parts.swap_remove(parts.len() / 2);
                parts[0].add(last);
            }
            let feeds = (0..count).filter(|tick| of(*tick) == Some(Limiter::Feed));
            if 2 * feeds.count() as u64 > count {
                assert_eq!(parts[0].limiter, Some(Limiter::Feed), "{count}");
            }
        }
    }

    #[test]
    fn a_place_beyond_the_end_is_as_far_as_from_the_end() {
        let [a, b] = [[0.0; 3], [10.0, 0.0, 0.0]];
        assert!((off_line(&[5.0, 3.0, 4.0], &a, &b) - 5.0).abs() < 1e-6);
        assert!((off_line(&[13.0, 0.0, 4.0], &a, &b) - 5.0).abs() < 1e-6);
        assert!((off_line(&[3.0, 4.0, 0.0], &a, &a) - 5.0).abs() < 1e-6);
    }
}
