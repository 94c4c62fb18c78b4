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
    let finite = || {
        curves
            .iter()
            .flat_map(|c| &c.points)
            .filter(|p| p[0].is_finite() && p[1].is_finite())
    };
    // Values that are not finite interrupt a curve and have no part in the ranges.
    let (Some(x), Some(y)) = (
        Range::of(finite().map(|p| p[0])),
        Range::of(finite().map(|p| p[1])),
    ) else {
        canvas.text([LEFT_PX, top], "no data", 13.0, SOFT, Anchor::Start);
        return canvas.finish(&picture.title);
    };
    // A single point has no range to divide by.
    let x = if x.span() > 0.0 { x } else { x.padded(0.0) };
    let y = y.padded(0.05);
    let (width, height) = (size[0] - LEFT_PX - RIGHT_PX, size[1] - top - BOTTOM_PX);
    let place = |p: [f64; 2]| {
        [
            LEFT_PX + (p[0] - x.min) / x.span() * width,
            top + (y.max - p[1]) / y.span() * height,
        ]
    };
    // The grid first: curves lie over it.
    let grid = Stroke::new("#eef1f4", 1.0);
    let (ticks, decimals) = x.ticks(8);
    for tick in ticks {
        let [px, _] = place([tick, y.min]);
        canvas.line([px, top], [px, top + height], grid);
        canvas.text(
            [px, top + height + 16.0],
            &fixed(tick, decimals),
            11.0,
            SOFT,
            Anchor::Middle,
        );
    }
    let (ticks, decimals) = y.ticks(6);
    for tick in ticks {
        let [_, py] = place([x.min, tick]);
        canvas.line([LEFT_PX, py], [LEFT_PX + width, py], grid);
        canvas.text(
            [LEFT_PX - 6.0, py + 4.0],
            &fixed(tick, decimals),
            11.0,
            SOFT,
            Anchor::End,
        );
    }
    canvas.frame([LEFT_PX, top], [width, height], Stroke::new(FAINT, 1.0));
    canvas.text(
        [LEFT_PX + 0.5 * width, size[1] - 14.0],
        &picture.x_label,
        12.0,
        SOFT,
        Anchor::Middle,
    );
    canvas.upright([18.0, top + 0.5 * height], &picture.y_label, 12.0, SOFT);
    for (index, (curve, [legend_x, row])) in curves.iter().zip(places).enumerate() {
        let color = COLORS[index % COLORS.len()];
        for piece in curve
            .points
            .split(|p| !(p[0].is_finite() && p[1].is_finite()))
        {
            // Reduced in pixels: what counts is what can be seen.
            let pixels: Vec<[f64; 2]> = piece.iter().map(|p| place(*p)).collect();
            let line: Vec<[f64; 2]> = keep(&pixels, LEAST_DETAIL_PX)
                .into_iter()
                .map(|i| pixels[i])
                .collect();
            canvas.polyline(&line, Stroke::new(color, 1.5));
        }
        canvas.line(
            [legend_x, row + 50.0],
            [legend_x + 22.0, row + 50.0],
            Stroke::new(color, 2.0),
        );
        canvas.text(
            [legend_x + 28.0, row + 54.0],
            &curve.name,
            12.0,
            INK,
            Anchor::Start,
        );
    }
    canvas.finish(&picture.title)
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
