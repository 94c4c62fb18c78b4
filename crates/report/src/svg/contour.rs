//! The contour error of a path: one panel a method, all magnified alike.

use super::canvas::{Anchor, COLORS, Canvas, FAINT, INK, SOFT, Stroke, fit, text_width};
use super::scale::keep;
use super::scale::{Range, round_down};
use super::trace::Plane;
use super::trace::{ContourTrace, TracePoint};
use crate::number::{fixed, plain};

/// What a picture of contour errors says beside the traces.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContourPicture {
    /// Headline.
    pub title: String,
    /// Line below it.
    pub subtitle: String,
    /// Tolerance drawn as dashed lines to both sides, um; `None` for no lines.
    pub tolerance_um: Option<f64>,
    /// The plane to look at; `None` to choose the one that shows most.
    pub plane: Option<Plane>,
}

/// Width of the picture, px.
const WIDTH_PX: f64 = 960.0;
/// Around everything, px.
const MARGIN_PX: f64 = 24.0;
/// Title and subtitle, px.
const HEADER_PX: f64 = 66.0;
/// Scale of the errors, px.
const FOOTER_PX: f64 = 60.0;
/// Above a panel: the method's name and its figures, px.
const PANEL_HEAD_PX: f64 = 44.0;
/// Left of and below a panel: tick labels and the axis' label, px.
const PANEL_LEFT_PX: f64 = 54.0;
const PANEL_BELOW_PX: f64 = 42.0;
/// Between panels, px.
const BETWEEN_PANELS_PX: f64 = 18.0;
/// The largest error takes at most this part of the contour's larger extent. A choice: more hides
/// the contour.
const LARGEST_ERROR_SHARE: f64 = 0.17;
/// A trace with errors beyond this multiple of the quietest trace's is cut off, so that one method
/// gone wild does not hide the others. A choice.
const WILD_RATIO: f64 = 12.0;
/// Points nearer than this to the line without them are not drawn, px. A choice: below what a
/// screen shows.
const LEAST_DETAIL_PX: f64 = 0.12;

/// Where a panel's frame lies and how mm become pixels.
struct Panel {
    at: [f64; 2],
    size: [f64; 2],
    x: Range,
    y: Range,
    px_per_mm: f64,
    mm_per_um: f64,
    /// Errors beyond are drawn here, um.
    clip_um: f64,
    plane: Plane,
}

impl Panel {
    fn point(&self, mm: [f64; 2]) -> [f64; 2] {
        [
            self.at[0] + 0.5 * self.size[0] + (mm[0] - self.x.middle()) * self.px_per_mm,
            self.at[1] + 0.5 * self.size[1] - (mm[1] - self.y.middle()) * self.px_per_mm,
        ]
    }

    /// The foot point moved along the normal by a magnified error.
    fn displaced(&self, point: &TracePoint, error_um: f64) -> [f64; 2] {
        let mm = error_um.clamp(-self.clip_um, self.clip_um) * self.mm_per_um;
        let [foot, normal] = [point.foot_mm, point.normal].map(|v| self.plane.project(v));
        self.point([foot[0] + normal[0] * mm, foot[1] + normal[1] * mm])
    }
}

/// Draws each trace in a panel of its own: the programmed contour in grey, the tool's path with its
/// error magnified along the normal in colour. Without any point the picture says so.
pub fn contour(picture: &ContourPicture, traces: &[ContourTrace]) -> String {
    let plane = picture.plane.unwrap_or_else(|| Plane::of(traces));
    // Extent of the contour itself; the magnified errors get their room further down.
    let seen = |axis: usize| {
        Range::of(
            traces
                .iter()
                .flat_map(ContourTrace::points)
                .map(|p| plane.project(p.foot_mm)[axis]),
        )
    };
    let (Some(x), Some(y)) = (seen(0), seen(1)) else {
        return empty(picture);
    };
    // Two columns for two or four traces: rows without a hole.
    let columns = match traces.len() {
        1 => 1,
        2 | 4 => 2,
        _ => 3,
    };
    // A part without extent (one hole) still gets a frame.
    let extent = x.span().max(y.span()).max(1e-3);
    let shown_um = shown_um(picture, traces);
    let mm_per_um = LARGEST_ERROR_SHARE * extent / shown_um;
    // A round number of times, which the scale bar can name; errors are never made smaller.
    let magnification = round_down(mm_per_um * 1e3).max(1.0);
    // Room for the magnified errors around the contour.
    let pad = LARGEST_ERROR_SHARE * extent * 1.15;
    let (x, y) = (
        Range {
            min: x.min - pad,
            max: x.max + pad,
        },
        Range {
            min: y.min - pad,
            max: y.max + pad,
        },
    );

    let cell =
        (WIDTH_PX - 2.0 * MARGIN_PX - BETWEEN_PANELS_PX * (columns as f64 - 1.0)) / columns as f64;
    // A lone panel does not take the whole width, or it would be higher than a screen.
    let width = (cell - PANEL_LEFT_PX).min(560.0);
    // One scale for both directions, so that circles stay round; a tall part sets it by its height.
    let px_per_mm = (width / x.span()).min(1.1 * width / y.span());
    // A flat part, such as a single line, still gets a frame with room for its labels.
    let height = (y.span() * px_per_mm).max(0.25 * width);
    // Panels of equal size in rows, with one magnification: traces can be compared by eye.
    let rows = traces.len().div_ceil(columns);
    let step = PANEL_HEAD_PX + height + PANEL_BELOW_PX + BETWEEN_PANELS_PX;
    let total = HEADER_PX + rows as f64 * step + FOOTER_PX;
    let mut canvas = Canvas::new(WIDTH_PX, total);
    heading(&mut canvas, picture);
    for (index, trace) in traces.iter().enumerate() {
        let (column, row) = (index % columns, index / columns);
        // Behind the tick labels, in the middle of the room of its column.
        let left = MARGIN_PX
            + column as f64 * (cell + BETWEEN_PANELS_PX)
            + 0.5 * (cell - PANEL_LEFT_PX - width)
            + PANEL_LEFT_PX;
        let at = [left, HEADER_PX + row as f64 * step + PANEL_HEAD_PX];
        let panel = Panel {
            at,
            size: [width, height],
            x,
            y,
            px_per_mm,
            mm_per_um: magnification * 1e-3,
            // A little beyond the scale, within the padding of the frame.
            clip_um: 1.1 * shown_um,
            plane,
        };
        draw_panel(
            &mut canvas,
            &panel,
            trace,
            COLORS[index % COLORS.len()],
            picture.tolerance_um,
        );
    }
    footer(
        &mut canvas,
        total - FOOTER_PX + 14.0,
        magnification,
        px_per_mm * magnification * 1e-3,
        shown_um,
        picture.tolerance_um,
    );
    canvas.finish(&picture.title)
}

/// Largest error of a trace, um.
fn largest_um(trace: &ContourTrace) -> f64 {
    trace.points().map(|p| p.error_um.abs()).fold(0.0, f64::max)
}

/// The error that the scale is made for, um: the largest one, unless it is out of all proportion to
/// the quietest trace.
fn shown_um(picture: &ContourPicture, traces: &[ContourTrace]) -> f64 {
    let each = || traces.iter().map(largest_um).filter(|um| *um > 0.0);
    let quietest = each().fold(f64::INFINITY, f64::min);
    // Traces far beyond the quietest are clipped at the scale that the others set.
    let largest = each()
        .filter(|um| *um <= WILD_RATIO * quietest)
        .fold(0.0, f64::max);
    // The tolerance lines are to be seen, but not at the price of errors pressed flat; without any
    // error the scale still has to divide.
    largest
        .max(picture.tolerance_um.unwrap_or(0.0).min(2.0 * largest))
        .max(1e-6)
}

fn heading(canvas: &mut Canvas, picture: &ContourPicture) {
    let room = WIDTH_PX - 2.0 * MARGIN_PX;
    canvas.bold(
        [MARGIN_PX, 30.0],
        &fit(&picture.title, 18.0, room),
        18.0,
        INK,
        Anchor::Start,
    );
    canvas.text(
        [MARGIN_PX, 51.0],
        &fit(&picture.subtitle, 13.0, room),
        13.0,
        SOFT,
        Anchor::Start,
    );
}

fn empty(picture: &ContourPicture) -> String {
    let mut canvas = Canvas::new(WIDTH_PX, HEADER_PX + FOOTER_PX);
    heading(&mut canvas, picture);
    canvas.text(
        [MARGIN_PX, HEADER_PX + 20.0],
        "no cutting move",
        13.0,
        SOFT,
        Anchor::Start,
    );
    canvas.finish(&picture.title)
}

fn draw_panel(
    canvas: &mut Canvas,
    panel: &Panel,
    trace: &ContourTrace,
    color: &'static str,
    tolerance_um: Option<f64>,
) {
    let [left, top] = panel.at;
    // A clipped trace looks like one that just fits: so it is said.
    let cut = if largest_um(trace) > panel.clip_um {
        " (off the scale)"
    } else {
        ""
    };
    let name = fit(&format!("{}{cut}", trace.name), 15.0, panel.size[0]);
    canvas.bold([left, top - 25.0], &name, 15.0, color, Anchor::Start);
    canvas.text(
        [left, top - 8.0],
        &fit(&trace.caption, 12.0, panel.size[0]),
        12.0,
        SOFT,
        Anchor::Start,
    );
    draw_axes(canvas, panel);
    for run in &trace.runs {
        let foot: Vec<[f64; 2]> = run.iter().map(|p| panel.displaced(p, 0.0)).collect();
        let tool: Vec<[f64; 2]> = run.iter().map(|p| panel.displaced(p, p.error_um)).collect();
        // The area between contour and tool: along the one and back along the other.
        let mut outline = reduced(&foot);
        outline.extend(reduced(&tool).into_iter().rev());
        canvas.area(&outline, color, 0.16);
        if let Some(tolerance) = tolerance_um {
            for side in [-tolerance, tolerance] {
                let band: Vec<[f64; 2]> = run.iter().map(|p| panel.displaced(p, side)).collect();
                canvas.polyline(
                    &reduced(&band),
                    Stroke {
                        dashed: true,
                        ..Stroke::new(FAINT, 0.8)
                    },
                );
            }
        }
        // Contour and tool are drawn last, over area and band.
        canvas.polyline(&reduced(&foot), Stroke::new("#7b8794", 1.0));
        canvas.polyline(&reduced(&tool), Stroke::new(color, 1.5));
    }
}

fn reduced(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    keep(points, LEAST_DETAIL_PX)
        .into_iter()
        .map(|i| points[i])
        .collect()
}

fn draw_axes(canvas: &mut Canvas, panel: &Panel) {
    let ([left, top], [width, height]) = (panel.at, panel.size);
    let (right, bottom) = (left + width, top + height);
    // The frame may be larger than the contour: ticks go over all that is seen.
    let half = |pixels: f64| 0.5 * pixels / panel.px_per_mm;
    let x = Range {
        min: panel.x.middle() - half(width),
        max: panel.x.middle() + half(width),
    };
    let y = Range {
        min: panel.y.middle() - half(height),
        max: panel.y.middle() + half(height),
    };
    let grid = Stroke::new("#eef1f4", 1.0);
    // About 90 px from label to label across, and 60 upwards.
    let (ticks, decimals) = x.ticks((width / 90.0) as usize + 1);
    for tick in ticks {
        let px = panel.point([tick, y.middle()])[0];
        canvas.line([px, top], [px, bottom], grid);
        canvas.text(
            [px, bottom + 15.0],
            &fixed(tick, decimals),
            11.0,
            SOFT,
            Anchor::Middle,
        );
    }
    let (ticks, decimals) = y.ticks((height / 60.0) as usize + 1);
    for tick in ticks {
        let py = panel.point([x.middle(), tick])[1];
        canvas.line([left, py], [right, py], grid);
        canvas.text(
            [left - 6.0, py + 4.0],
            &fixed(tick, decimals),
            11.0,
            SOFT,
            Anchor::End,
        );
    }
    canvas.frame(panel.at, panel.size, Stroke::new(FAINT, 1.0));
    let [horizontal, vertical] = panel.plane.labels();
    canvas.text(
        [left + 0.5 * width, bottom + 32.0],
        horizontal,
        11.0,
        SOFT,
        Anchor::Middle,
    );
    canvas.upright([left - 42.0, top + 0.5 * height], vertical, 11.0, SOFT);
}

/// The scale bar of the error and the legend.
fn footer(
    canvas: &mut Canvas,
    top: f64,
    magnification: f64,
    px_per_um: f64,
    shown_um: f64,
    tolerance_um: Option<f64>,
) {
    // A round error, as long here as it is in the panels.
    let bar_um = round_down(shown_um);
    let length = (bar_um * px_per_um).max(1.0);
    let y = top + 14.0;
    let ends = [MARGIN_PX, MARGIN_PX + length];
    canvas.line([ends[0], y], [ends[1], y], Stroke::new(INK, 2.0));
    for end in ends {
        canvas.line([end, y - 5.0], [end, y + 5.0], Stroke::new(INK, 2.0));
    }
    let label = format!(
        "{} \u{b5}m of error (magnified {} times)",
        plain(bar_um),
        plain(magnification)
    );
    canvas.text([ends[1] + 10.0, y + 4.0], &label, 12.0, INK, Anchor::Start);
    let mut x = ends[1] + 10.0 + text_width(&label, 12.0) + 30.0;
    // There is no font to measure: entries follow each other by the estimated widths of their
    // texts.
    let mut entry = |canvas: &mut Canvas, text: &str, stroke: Stroke| {
        canvas.line([x, y], [x + 24.0, y], stroke);
        canvas.text([x + 30.0, y + 4.0], text, 12.0, SOFT, Anchor::Start);
        x += 30.0 + text_width(text, 12.0) + 20.0;
    };
    entry(canvas, "programmed", Stroke::new("#7b8794", 1.0));
    entry(canvas, "tool", Stroke::new(COLORS[0], 1.5));
    if let Some(tolerance) = tolerance_um {
        let text = format!("tolerance \u{b1}{} \u{b5}m", plain(tolerance));
        entry(
            canvas,
            &text,
            Stroke {
                dashed: true,
                ..Stroke::new("#9aa5b1", 1.0)
            },
        );
    }
}
