//! Curves over time or anything else.

use super::canvas::{Anchor, COLORS, Canvas, FAINT, INK, SOFT, Stroke, fit, text_width};
use super::scale::Range;
use super::scale::keep;
use crate::number::fixed;

/// One curve.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Series {
    /// Its name in the legend.
    pub name: String,
    /// Its points, x rising. A value that is not finite interrupts the curve.
    pub points: Vec<[f64; 2]>,
}

/// What stands around the curves.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SeriesPicture {
    /// Headline.
    pub title: String,
    /// Label of the horizontal axis with its unit.
    pub x_label: String,
    /// Label of the vertical axis with its unit.
    pub y_label: String,
}

/// Width and height of the picture, px.
const SIZE_PX: [f64; 2] = [760.0, 400.0];
/// Margins around the plot, px: tick labels to the left, title and legend above.
const LEFT_PX: f64 = 74.0;
const TOP_PX: f64 = 72.0;
const RIGHT_PX: f64 = 20.0;
const BOTTOM_PX: f64 = 52.0;
/// Between rows of the legend, px.
const LEGEND_ROW_PX: f64 = 18.0;
/// Points nearer than this to the line without them are not drawn, px. As in the contour picture.
const LEAST_DETAIL_PX: f64 = 0.12;

/// Draws curves in one frame with a legend above it.
pub fn series(picture: &SeriesPicture, curves: &[Series]) -> String {
    let places = legend(curves);
    // What the legend needs beyond its first row makes the picture higher, not the plot smaller.
    let more = places.last().map_or(0.0, |place| place[1]);
    let (size, top) = ([SIZE_PX[0], SIZE_PX[1] + more], TOP_PX + more);
    let mut canvas = Canvas::new(size[0], size[1]);
    canvas.bold(
        [LEFT_PX, 28.0],
        &fit(&picture.title, 16.0, size[0] - LEFT_PX - RIGHT_PX),
        16.0,
        INK,
        Anchor::Start,
    );
    let Some(plot) = Plot::of(curves, size, top) else {
        canvas.text([LEFT_PX, top], "no data", 13.0, SOFT, Anchor::Start);
        return canvas.finish(&picture.title);
    };
    // The grid first: curves lie over it.
    plot.grid(&mut canvas);
    plot.frame(&mut canvas, picture);
    for (index, (curve, place)) in curves.iter().zip(places).enumerate() {
        let color = COLORS[index % COLORS.len()];
        plot.curve(&mut canvas, curve, color);
        sign(&mut canvas, &curve.name, place, color);
    }
    canvas.finish(&picture.title)
}

/// Where the curves lie in a picture, and the ranges that are shown there.
struct Plot {
    x: Range,
    y: Range,
    /// Of the picture, px.
    size: [f64; 2],
    /// Of the plot itself, px.
    top: f64,
    width: f64,
    height: f64,
}

impl Plot {
    /// The plot that shows all of the curves; `None` where there is nothing to show.
    fn of(curves: &[Series], size: [f64; 2], top: f64) -> Option<Plot> {
        // Values that are not finite interrupt a curve and have no part in the ranges.
        let finite = || {
            curves
                .iter()
                .flat_map(|c| &c.points)
                .filter(|p| p[0].is_finite() && p[1].is_finite())
        };
        let x = Range::of(finite().map(|p| p[0]))?;
        let y = Range::of(finite().map(|p| p[1]))?;
        Some(Plot {
            // A single point has no range to divide by.
            x: if x.span() > 0.0 { x } else { x.padded(0.0) },
            y: y.padded(0.05),
            size,
            top,
            width: size[0] - LEFT_PX - RIGHT_PX,
            height: size[1] - top - BOTTOM_PX,
        })
    }

    /// The pixel of a point.
    fn place(&self, p: [f64; 2]) -> [f64; 2] {
        [
            LEFT_PX + (p[0] - self.x.min) / self.x.span() * self.width,
            self.top + (self.y.max - p[1]) / self.y.span() * self.height,
        ]
    }

    /// Lines at round values, with the values beside them.
    fn grid(&self, canvas: &mut Canvas) {
        let grid = Stroke::new("#eef1f4", 1.0);
        let bottom = self.top + self.height;
        let (ticks, decimals) = self.x.ticks(8);
        for tick in ticks {
            let [px, _] = self.place([tick, self.y.min]);
            canvas.line([px, self.top], [px, bottom], grid);
            canvas.text(
                [px, bottom + 16.0],
                &fixed(tick, decimals),
                11.0,
                SOFT,
                Anchor::Middle,
            );
        }
        let (ticks, decimals) = self.y.ticks(6);
        for tick in ticks {
            let [_, py] = self.place([self.x.min, tick]);
            canvas.line([LEFT_PX, py], [LEFT_PX + self.width, py], grid);
            canvas.text(
                [LEFT_PX - 6.0, py + 4.0],
                &fixed(tick, decimals),
                11.0,
                SOFT,
                Anchor::End,
            );
        }
    }

    /// The frame and the labels of its axes.
    fn frame(&self, canvas: &mut Canvas, picture: &SeriesPicture) {
        canvas.frame(
            [LEFT_PX, self.top],
            [self.width, self.height],
            Stroke::new(FAINT, 1.0),
        );
        canvas.text(
            [LEFT_PX + 0.5 * self.width, self.size[1] - 14.0],
            &picture.x_label,
            12.0,
            SOFT,
            Anchor::Middle,
        );
        let middle = self.top + 0.5 * self.height;
        canvas.upright([18.0, middle], &picture.y_label, 12.0, SOFT);
    }

    /// A curve, in as many pieces as values that are not finite leave of it.
    fn curve(&self, canvas: &mut Canvas, curve: &Series, color: &'static str) {
        for piece in curve
            .points
            .split(|p| !(p[0].is_finite() && p[1].is_finite()))
        {
            // Reduced in pixels: what counts is what can be seen.
            let pixels: Vec<[f64; 2]> = piece.iter().map(|p| self.place(*p)).collect();
            let line: Vec<[f64; 2]> = keep(&pixels, LEAST_DETAIL_PX)
                .into_iter()
                .map(|i| pixels[i])
                .collect();
            canvas.polyline(&line, Stroke::new(color, 1.5));
        }
    }
}

/// A curve's sign in the legend, and its name.
fn sign(canvas: &mut Canvas, name: &str, [x, row]: [f64; 2], color: &'static str) {
    canvas.line(
        [x, row + 50.0],
        [x + 22.0, row + 50.0],
        Stroke::new(color, 2.0),
    );
    canvas.text([x + 28.0, row + 54.0], name, 12.0, INK, Anchor::Start);
}

/// Where each curve's sign in the legend begins, and by how much its row is below the first.
fn legend(curves: &[Series]) -> Vec<[f64; 2]> {
    let (mut x, mut row) = (LEFT_PX, 0.0);
    let place = |curve: &Series| {
        let width = 28.0 + text_width(&curve.name, 12.0);
        // A name that does not fit begins a row, unless it is the first of one.
        if x > LEFT_PX && x + width > SIZE_PX[0] - RIGHT_PX {
            (x, row) = (LEFT_PX, row + LEGEND_ROW_PX);
        }
        let at = [x, row];
        x += width + 22.0;
        at
    };
    curves.iter().map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six long names need a second row, two short ones do not, and every name ends within the
    /// picture.
    #[test]
    fn a_legend_takes_the_rows_that_it_needs() {
        let curves = |names: &[&str]| {
            names
                .iter()
                .map(|name| Series {
                    name: (*name).to_owned(),
                    points: Vec::new(),
                })
                .collect::<Vec<_>>()
        };
        let many = curves(&[
            "bench, adaptive, ideal",
            "bench, adaptive, 2^20",
            "mill, adaptive, ideal",
            "mill, adaptive, 2^20",
            "truth",
        ]);
        let places = legend(&many);
        assert_eq!(
            (places[0], places.last().map(|place| place[1])),
            ([LEFT_PX, 0.0], Some(LEGEND_ROW_PX))
        );
        assert!(places.iter().zip(&many).all(|(place, curve)| place[0]
            + 28.0
            + text_width(&curve.name, 12.0)
            <= SIZE_PX[0] - RIGHT_PX));
        assert!(
            legend(&curves(&["a", "b"]))
                .iter()
                .all(|place| place[1] == 0.0)
        );
    }
}
