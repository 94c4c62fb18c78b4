//! The path coloured by its error, a drawing a level of Z. Where the lines of a surface are too near
//! to each other to be told apart, squares are drawn, each with the largest error in it.

use super::data::escape;
use super::path::{Path, Stretch};
use super::picture::{BOUNDS, Drawing, Frame, color, ruler, signed};
use crate::number::{fixed, plain};
use crate::svg::{Plane, keep, round_down};
use lostmotion_base::math;
use std::collections::{BTreeMap, BTreeSet};

/// Around the path, px.
const MARGIN: f64 = 22.0;
/// Most points of all drawings: a picture of some 300 kB.
const MOST_POINTS: usize = 16_000;
/// Shortest line that is drawn first, px; longer ones follow until there are few enough points.
const LEAST_PX: f64 = 0.4;
/// Points nearer than this to the line without them are not drawn, px. A choice: below what a screen
/// shows.
const LEAST_DETAIL_PX: f64 = 0.12;
/// Side of a square in shortest lines.
const SQUARE: f64 = 10.0;
/// Part of the squares with something in them that has neighbours on all sides where lines fill an
/// area. A choice: an outline has none, a raster nearly all.
const FILLED_SHARE: f64 = 0.5;
/// Steps by which levels are told apart, mm.
const LEVEL_MM: f64 = 1e-3;
/// Steps within which what is not quite level belongs to a level: under G64 a path swings beside its
/// lines. A choice: most tolerances are less, and levels are farther apart.
const NEAR_LEVEL: u64 = 50;
/// Part of the cutting that has to be level for drawings by level. A choice.
const LEVEL_SHARE: f64 = 0.6;

/// A level: which stretches, and what is said of them.
struct Level {
    caption: String,
    /// Its Z in steps of [`LEVEL_MM`]; `None` for everything in one.
    height: Option<i64>,
    stretches: Vec<usize>,
    /// Rapids that lead to what is cut on it.
    rapids: Vec<usize>,
}

/// A place that is marked in the pictures.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Mark {
    pub(super) at_mm: [f64; 3],
    pub(super) name: String,
}

/// What is drawn of a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shown<'a> {
    pub(super) method: usize,
    pub(super) tolerance_um: f64,
    pub(super) marks: &'a [Mark],
    /// Most levels, longest first.
    pub(super) levels: usize,
}

/// Drawings of the path of a method; none where nothing is cut.
pub(super) fn path(path: &Path, shown: Shown<'_>, frame: Frame) -> Vec<Drawing> {
    let last = path.stretches.len().saturating_sub(1);
    let leads_on = |index: usize| path.stretches.get(index + 1).is_some_and(|s| !s.broken);
    let all: Vec<usize> = (0..last).filter(|index| leads_on(*index)).collect();
    let (rapids, cutting): (Vec<usize>, Vec<usize>) = all
        .into_iter()
        .partition(|index| path.stretches.get(*index).is_some_and(|s| s.rapid));
    if cutting.is_empty() {
        return Vec::new();
    }
    let plane = plane(path, &cutting);
    let mut levels = levels(path, &cutting, plane, shown.levels);
    add_rapids(&mut levels, &rapids);
    let peaks = path.peaks.get(shown.method).map_or(&[][..], Vec::as_slice);
    // Coarser and coarser until all drawings together have few enough points.
    let mut least_px = LEAST_PX;
    loop {
        let drawn: Vec<Drawing> = levels
            .iter()
            .map(|level| {
                let marks = shown.marks.iter().filter(|mark| level.has(mark, &levels));
                let sheet = LevelSheet::new(path, level, plane, frame, least_px);
                sheet.draw(peaks, shown.tolerance_um, marks)
            })
            .collect();
        let points: usize = drawn.iter().map(|drawing| drawing.points).sum();
        if points <= MOST_POINTS || least_px > 100.0 {
            return drawn;
        }
        least_px *= 1.6;
    }
}

impl Level {
    /// Whether a place is on it, or nearer to it than to any other.
    fn has(&self, mark: &Mark, levels: &[Level]) -> bool {
        let at = (mark.at_mm[2] / LEVEL_MM).round() as i64;
        let off = |level: &Level| level.height.map_or(0, |height| height.abs_diff(at));
        let nearest = levels.iter().map(off).min().unwrap_or(0);
        off(self) == nearest
    }
}

/// The plane that shows most of what is cut: by how far cuts lie from their middle, weighed by their
/// length, so that a plunge from above does not make a flat part a tall one.
fn plane(path: &Path, cutting: &[usize]) -> Plane {
    let (mut whole, mut sum, mut squares) = (0.0, [0.0; 3], [0.0; 3]);
    let first = cutting.first().and_then(|index| path.stretches.get(*index));
    let origin = first.map_or([0.0; 3], |stretch| stretch.from_mm.map(f64::from));
    for index in cutting {
        let (Some(from), Some(to)) = (path.stretches.get(*index), path.stretches.get(index + 1))
        else {
            continue;
        };
        let length = f64::from(from.length_mm);
        whole += length;
        for axis in 0..3 {
            let ends = [from, to].map(|end| f64::from(end.from_mm[axis]) - origin[axis]);
            sum[axis] += length * 0.5 * (ends[0] + ends[1]);
            // The integral of the square along a straight line.
            let [a, b] = ends;
            squares[axis] += length * (a * a + a * b + b * b) / 3.0;
        }
    }
    let whole = f64::max(whole, 1e-12);
    Plane::of_extents([0, 1, 2].map(|axis| {
        let mean = sum[axis] / whole;
        (squares[axis] / whole - mean * mean).max(0.0).sqrt()
    }))
}

/// One for all, or one a level of Z where most of the cutting is level and seen from above.
fn levels(path: &Path, cutting: &[usize], plane: Plane, most: usize) -> Vec<Level> {
    let all = || Level {
        caption: "All cutting moves".to_owned(),
        height: None,
        stretches: cutting.to_vec(),
        rapids: Vec::new(),
    };
    if plane != Plane::Xy {
        return vec![all()];
    }
    let z_of = |stretch: &Stretch| (f64::from(stretch.from_mm[2]) / LEVEL_MM).round() as i64;
    let ends = |index: usize| {
        let (from, to) = (path.stretches.get(index)?, path.stretches.get(index + 1)?);
        Some((z_of(from), z_of(to), f64::from(from.length_mm)))
    };
    let (mut lengths, mut whole): (BTreeMap<i64, f64>, f64) = (BTreeMap::new(), 0.0);
    for (from, to, length) in cutting.iter().filter_map(|index| ends(*index)) {
        whole += length;
        if from == to {
            *lengths.entry(from).or_default() += length;
        }
    }
    let mut longest: Vec<(i64, f64)> = lengths.into_iter().collect();
    longest.sort_by(|a, b| b.1.total_cmp(&a.1).then(b.0.cmp(&a.0)));
    longest.truncate(most);
    // A level with next to nothing on it is a plunge or an approach.
    longest.retain(|(_, length)| *length > 0.02 * whole);
    let covered: f64 = longest.iter().map(|(_, length)| length).sum();
    if covered < LEVEL_SHARE * whole || longest.len() < 2 {
        return vec![all()];
    }
    // From the top down, as they are cut.
    longest.sort_by_key(|level| std::cmp::Reverse(level.0));
    let mut levels: Vec<Level> = longest
        .iter()
        .map(|(z, _)| Level {
            caption: format!("Z {} mm", plain(*z as f64 * LEVEL_MM)),
            height: Some(*z),
            stretches: Vec::new(),
            rapids: Vec::new(),
        })
        .collect();
    // What is not level belongs to the level that it leads to, and behind the last of them to that
    // one: nothing is left out. A level without a drawing of its own goes to the nearest.
    let mut leads_to = longest.len() - 1;
    for index in cutting.iter().rev() {
        let Some((from, to, _)) = ends(*index) else {
            continue;
        };
        let off = |at: usize| longest[at].0.abs_diff(from).max(longest[at].0.abs_diff(to));
        if let Some(nearest) = (0..longest.len()).min_by_key(|at| off(*at))
            && (from == to || off(nearest) <= NEAR_LEVEL)
        {
            leads_to = nearest;
        }
        if let Some(level) = levels.get_mut(leads_to) {
            level.stretches.push(*index);
        }
    }
    for level in &mut levels {
        level.stretches.reverse();
    }
    levels
}

/// Gives each rapid to the level of the cut that it leads to.
fn add_rapids(levels: &mut [Level], rapids: &[usize]) {
    for rapid in rapids {
        let next = |level: &Level| {
            let at = level.stretches.partition_point(|index| index < rapid);
            level.stretches.get(at).copied()
        };
        let nearest = (0..levels.len()).min_by_key(|at| next(&levels[*at]).unwrap_or(usize::MAX));
        // After the last cut there is nothing to lead to.
        if let Some(level) = nearest.and_then(|at| levels.get_mut(at))
            && next(level).is_some()
        {
            level.rapids.push(*rapid);
        }
    }
}

/// Lines of one colour.
#[derive(Clone, Default)]
struct Strokes {
    chains: Vec<Vec<[f64; 2]>>,
}

impl Strokes {
    fn line(&mut self, from: [f64; 2], to: [f64; 2], joined: bool) {
        match self.chains.last_mut() {
            Some(chain) if joined => chain.push(to),
            _ => self.chains.push(vec![from, to]),
        }
    }

    /// Without points that are not seen.
    fn reduced(mut self) -> Strokes {
        for chain in &mut self.chains {
            *chain = keep(chain, LEAST_DETAIL_PX)
                .into_iter()
                .map(|at| chain[at])
                .collect();
        }
        self
    }

    fn points(&self) -> usize {
        self.chains.iter().map(Vec::len).sum()
    }

    /// As the data of a path.
    fn data(&self) -> String {
        let mut data = String::new();
        for chain in &self.chains {
            for (nth, point) in chain.iter().enumerate() {
                let [x, y] = point.map(|c| fixed(c, 1));
                data.push_str(&format!("{}{x} {y}", if nth == 0 { 'M' } else { 'L' }));
            }
        }
        data
    }
}

/// A level on paper: how mm become px, and how fine it is drawn.
struct LevelSheet<'a> {
    path: &'a Path,
    level: &'a Level,
    plane: Plane,
    frame: Frame,
    least_px: f64,
    /// Left and upper edge of what is cut, mm.
    corner_mm: [f64; 2],
    /// Larger extent, mm.
    wide_mm: f64,
    left_px: f64,
    px_per_mm: f64,
    height_px: f64,
}

impl LevelSheet<'_> {
    fn new<'a>(
        path: &'a Path,
        level: &'a Level,
        plane: Plane,
        frame: Frame,
        least_px: f64,
    ) -> LevelSheet<'a> {
        let at = |index: usize| {
            let place = path.stretches.get(index).map_or([0.0; 3], |s| s.from_mm);
            plane.project(place.map(f64::from))
        };
        let ends = || {
            let stretches = level.stretches.iter();
            stretches.flat_map(|index| [at(*index), at(index + 1)])
        };
        let range = |axis: usize| {
            let low = ends().map(|p| p[axis]).fold(f64::INFINITY, f64::min);
            let high = ends().map(|p| p[axis]).fold(f64::NEG_INFINITY, f64::max);
            [low, high]
        };
        let (x, y) = (range(0), range(1));
        let span = (x[1] - x[0]).max(y[1] - y[0]).max(1e-6);
        let wide_mm = (x[1] - x[0]).max(0.4 * span);
        let px_per_mm = ((frame.width - 2.0 * MARGIN) / wide_mm).min(1.1 * frame.width / span);
        LevelSheet {
            path,
            level,
            plane,
            frame,
            least_px,
            corner_mm: [x[0], y[1]],
            wide_mm,
            left_px: 0.5 * (frame.width - (x[1] - x[0]) * px_per_mm),
            px_per_mm,
            height_px: (y[1] - y[0]) * px_per_mm + 2.0 * MARGIN + 1.6 * frame.font,
        }
    }

    fn px(&self, place_mm: [f64; 3]) -> [f64; 2] {
        let [u, v] = self.plane.project(place_mm);
        [
            self.left_px + (u - self.corner_mm[0]) * self.px_per_mm,
            MARGIN + (self.corner_mm[1] - v) * self.px_per_mm,
        ]
    }

    /// Where a stretch begins.
    fn at(&self, index: usize) -> [f64; 2] {
        let stretch = self.path.stretches.get(index);
        self.px(stretch.map_or([0.0; 3], |s| s.from_mm.map(f64::from)))
    }

    fn draw<'m>(
        &self,
        peaks: &[f32],
        tolerance_um: f64,
        marks: impl Iterator<Item = &'m Mark>,
    ) -> Drawing {
        let peak = |index: usize| peaks.get(index).copied().unwrap_or(f32::NAN);
        // What the machine never came to has no error, and is not drawn.
        let reached: Vec<usize> = self
            .level
            .stretches
            .iter()
            .copied()
            .filter(|index| !peak(*index).is_nan())
            .collect();
        let hue = |index: usize| color(f64::from(peak(index)), tolerance_um);
        let squares = self.squares(&reached, hue);
        let (class, strokes, dots) = match squares {
            Some(squares) => ("squares", squares, Vec::new()),
            None => {
                let (lines, dots) = self.lines(&reached, hue);
                ("path", lines, dots)
            }
        };
        let faint = self.faint();
        let all = || strokes.iter().chain(&dots);
        let points = faint.points() + all().map(Strokes::points).sum::<usize>();
        let lines = elements(&strokes);
        let dots = match elements(&dots) {
            dots if dots.is_empty() => dots,
            dots => format!("<g class=\"dots\">{dots}</g>"),
        };
        let width = if class == "squares" {
            format!(" stroke-width=\"{}\"", fixed(self.side_px() + 0.3, 1))
        } else {
            String::new()
        };
        let marks = self.marks(marks);
        let rapids = if faint.chains.is_empty() {
            String::new()
        } else {
            format!("<path class=\"rapid\" d=\"{}\"/>", faint.data())
        };
        let ruler_mm = round_down(0.3 * self.wide_mm).max(1e-6);
        let ruler = ruler(
            [MARGIN, self.height_px - 0.75 * self.frame.font],
            ruler_mm * self.px_per_mm,
            &format!("{} mm", plain(ruler_mm)),
        );
        let worst = reached
            .iter()
            .map(|index| peak(*index))
            .fold(
                0.0_f32,
                |worst, um| if um.abs() > worst.abs() { um } else { worst },
            );
        let [h, v] = self
            .plane
            .labels()
            .map(|label| label.trim_end_matches(", mm"));
        let squares = if class == "squares" {
            "; squares show their worst"
        } else {
            ""
        };
        Drawing {
            size: [self.frame.width, self.height_px],
            body: format!("{rapids}<g class=\"{class}\"{width}>{lines}</g>{dots}{marks}{ruler}"),
            label: format!(
                "{}: worst {} \u{b5}m; {h} to the right, {v} up{squares}",
                self.level.caption,
                signed(f64::from(worst))
            ),
            points,
        }
    }

    /// Lines in their colours, without detail that is not seen; and dots where the tool goes up and
    /// down alone, as in drilling.
    fn lines(
        &self,
        reached: &[usize],
        hue: impl Fn(usize) -> usize,
    ) -> (Vec<Strokes>, Vec<Strokes>) {
        let middle = BOUNDS.len() / 2;
        let mut strokes = vec![Strokes::default(); BOUNDS.len() + 1];
        let mut dots = strokes.clone();
        // Where the line drawn last ends, and what waits behind it for being long enough: its
        // colour and where it begins.
        let mut pen: Option<(usize, [f64; 2])> = None;
        let mut held: Option<(usize, [f64; 2])> = None;
        for (nth, index) in reached.iter().enumerate() {
            let to = self.at(index + 1);
            // The colour farthest from the middle stays.
            let (hue, start) = match held.take() {
                Some((waiting, since)) => {
                    let hue = hue(*index);
                    let waits = waiting.abs_diff(middle) > hue.abs_diff(middle);
                    (if waits { waiting } else { hue }, since)
                }
                None => (hue(*index), self.at(*index)),
            };
            let goes_on = reached.get(nth + 1) == Some(&(index + 1));
            let length = math::hypot(to[0] - start[0], to[1] - start[1]);
            if length < self.least_px && goes_on {
                held = Some((hue, start));
                continue;
            }
            let joined = pen == Some((hue, start));
            // Nothing else of this cut is seen: it is a hole.
            let is_dot = length < self.least_px && pen.is_none();
            let kind = if is_dot { &mut dots } else { &mut strokes };
            if let Some(stroke) = kind.get_mut(hue) {
                stroke.line(start, to, joined);
            }
            // Nothing is joined across a rapid or another level.
            pen = goes_on.then_some((hue, to));
        }
        (strokes.into_iter().map(Strokes::reduced).collect(), dots)
    }

    /// Side of a square, px.
    fn side_px(&self) -> f64 {
        SQUARE * self.least_px
    }

    /// Squares with the colour of the largest error in each, where lines fill areas.
    fn squares(&self, reached: &[usize], hue: impl Fn(usize) -> usize) -> Option<Vec<Strokes>> {
        let middle = BOUNDS.len() / 2;
        let side = self.side_px();
        // By row and column: runs of one colour then follow each other.
        let mut found: BTreeMap<[i32; 2], usize> = BTreeMap::new();
        for index in reached {
            let (from, to, hue) = (self.at(*index), self.at(index + 1), hue(*index));
            let length = math::hypot(to[0] - from[0], to[1] - from[1]);
            // At half a square no square on the way is missed but at a corner.
            let steps = (2.0 * length / side).ceil().max(1.0);
            for step in 0..=steps as usize {
                let part = step as f64 / steps;
                let at = [1, 0].map(|axis| from[axis] + part * (to[axis] - from[axis]));
                let largest = found
                    .entry(at.map(|c| (c / side).floor() as i32))
                    .or_insert(hue);
                if hue.abs_diff(middle) > largest.abs_diff(middle) {
                    *largest = hue;
                }
            }
        }
        let filled = |[row, column]: [i32; 2]| {
            let around = [
                [row - 1, column],
                [row + 1, column],
                [row, column - 1],
                [row, column + 1],
            ];
            around.iter().all(|at| found.contains_key(at))
        };
        let inside = found.keys().filter(|at| filled(**at)).count();
        if (inside as f64) < FILLED_SHARE * found.len() as f64 {
            return None;
        }
        let mut strokes = vec![Strokes::default(); BOUNDS.len() + 1];
        let mut squares = found.into_iter().peekable();
        while let Some(([row, from], hue)) = squares.next() {
            let mut to = from + 1;
            while squares.next_if_eq(&([row, to], hue)).is_some() {
                to += 1;
            }
            let px = |column: i32| [f64::from(column) * side, (f64::from(row) + 0.5) * side];
            if let Some(stroke) = strokes.get_mut(hue) {
                stroke.line(px(from), px(to), false);
            }
        }
        Some(strokes)
    }

    /// The rapids, each once.
    fn faint(&self) -> Strokes {
        let mut strokes = Strokes::default();
        let mut pen = None;
        let mut drawn = BTreeSet::new();
        for index in &self.level.rapids {
            let (from, to) = (self.at(*index), self.at(index + 1));
            let length = math::hypot(to[0] - from[0], to[1] - from[1]);
            // Up and down they are points here; and many lead along the same line.
            let tenths = [from, to].map(|p| p.map(|c| (c * 10.0) as i64));
            if length < self.least_px || !drawn.insert(tenths) {
                continue;
            }
            strokes.line(from, to, pen == Some(from));
            pen = Some(to);
        }
        strokes
    }

    /// Marks with their names, each beside those before it.
    fn marks<'m>(&self, marks: impl Iterator<Item = &'m Mark>) -> String {
        let font = self.frame.font;
        let mut taken: Vec<[f64; 2]> = Vec::new();
        let mut out = String::new();
        for mark in marks {
            let at = self.px(mark.at_mm);
            // The name is where there is room: away from the nearer edge.
            let (side, anchor) = if at[0] > 0.5 * self.frame.width {
                (-11.0, "end")
            } else {
                (11.0, "start")
            };
            let mut base = at[1] + 0.32 * font;
            let meets = |base: f64, other: &[f64; 2]| {
                (at[0] - other[0]).abs() < 5.0 * font && (base - other[1]).abs() < font
            };
            while taken.iter().any(|other| meets(base, other)) {
                base += 1.1 * font;
            }
            taken.push([at[0], base]);
            let [x, y, text, base] = [at[0], at[1], at[0] + side, base].map(|c| fixed(c, 1));
            out.push_str(&format!(
                "<circle class=\"mark\" cx=\"{x}\" cy=\"{y}\" r=\"8\"/><text class=\"mark\" x=\"{text}\" y=\"{base}\" text-anchor=\"{anchor}\">{}</text>",
                escape(&mark.name)
            ));
        }
        out
    }
}

/// Elements of lines, the largest errors last: they lie on top.
fn elements(strokes: &[Strokes]) -> String {
    let mut order: Vec<usize> = (0..strokes.len()).collect();
    order.sort_by_key(|hue| hue.abs_diff(BOUNDS.len() / 2));
    order
        .into_iter()
        .filter_map(|hue| strokes.get(hue).map(|stroke| (hue, stroke)))
        .filter(|(_, stroke)| !stroke.chains.is_empty())
        .map(|(hue, stroke)| format!("<path class=\"e{hue}\" d=\"{}\"/>", stroke.data()))
        .collect()
}
