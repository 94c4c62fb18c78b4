//! The result as one picture that needs no script: for documents, mails and small screens.

use super::data::escape;
use super::enlarged;
use super::html::{DRAWN_PLACES, drawn_blocks, file_name, marks};
use super::levels::{self, Shown};
use super::picture::{BOUNDS, Drawing, Frame, HUES, signed};
use super::record::Gathered;
use crate::number::{duration, error, fixed, plain};
use crate::svg::{fit, text_width};
use crate::text::{stop_place, stop_reason};
use lostmotion_sim::results::{MethodResult, Run};
use std::fmt::Write;

/// Width of the picture, px.
const WIDTH: f64 = 720.0;
/// Size of its texts, px: 10 on a telephone of 390 px.
const FONT: f64 = 19.0;
/// Around everything, and between drawings, px.
const MARGIN: f64 = 18.0;
/// Height of a line of text, px.
const LINE: f64 = 1.35 * FONT;
/// Most drawings of levels below each other of one method, and of two. A choice: what can be looked
/// at.
const MOST_LEVELS: [usize; 2] = [6, 3];
/// Colours and widths, for a light ground: a picture is looked at in many places.
const STYLE: &str = "text{fill:#52606d;font-size:19px}.title{fill:#17202a;font-size:26px;font-weight:bold}.name{fill:#17202a;font-weight:bold}.good{fill:#0a6b3d;font-weight:bold}.bad{fill:#b3001b;font-weight:bold}.path path,.place path,.rapid,.ruler,.squares path,.dots path,circle{fill:none}.dots path{stroke-width:9;stroke-linecap:round}.path path,.place path{stroke-linejoin:round;stroke-linecap:round}.path path{stroke-width:2.2}.path .e1,.path .e7{stroke-width:3}.path .e0,.path .e8{stroke-width:4}.place path{stroke-width:3}.place .programmed{stroke:#52606d;stroke-width:1}.place .tool{stroke:#17202a;stroke-width:1.6}.place .limit{stroke:#7b8794;stroke-width:1;stroke-dasharray:5 4}.place .e0,.place .e8{stroke-width:4}.rapid{stroke:#9aa5b1;stroke-width:1;stroke-dasharray:2 4}.ruler{stroke:#52606d}circle.mark{stroke:#17202a;stroke-width:1.4}text.mark{fill:#17202a;stroke:#fff;stroke-width:4px;paint-order:stroke}.frame{fill:none;stroke:#ccd3da}";

/// Draws a run: verdict, the path coloured by its contour error on a scale tied to the tolerance (a
/// drawing a level of Z, without compensation beside the method that decides where both were run),
/// and the three worst places enlarged.
///
/// SVG 1.1 on a white ground, without scripts; the same run gives the same bytes. The size is
/// bounded whatever the program's length.
pub fn still(run: &Run, record: &Gathered) -> String {
    // Where none is recommended the first is shown.
    let main = run.deciding_index().unwrap_or(0);
    let mut sheet = StillSheet::default();
    let title = format!("{} on {}", file_name(&run.program.name), run.machine);
    sheet.y += 0.3 * LINE;
    sheet.text("title", &title, 26.0);
    if let Some(result) = run.results.get(main) {
        verdict(&mut sheet, run, result);
    }
    let before = run.results.iter().position(MethodResult::is_baseline);
    let mut shown: Vec<usize> = before.filter(|none| *none != main).into_iter().collect();
    shown.push(main);
    let two = shown.len() == 2;
    let wide = WIDTH - 2.0 * MARGIN;
    let half = 0.5 * (wide - MARGIN);
    let most_levels = MOST_LEVELS[usize::from(two)];
    let columns: Vec<Vec<Drawing>> = shown
        .iter()
        .map(|method| {
            let marks = marks(run, main);
            let shown = Shown {
                method: *method,
                tolerance_um: run.tolerance_um,
                // They are the worst places of the method that decides.
                marks: if *method == main { &marks } else { &[] },
                levels: most_levels,
            };
            let draw = |width| levels::path(&record.path, shown, Frame { width, font: FONT });
            // One drawing takes the whole width.
            let drawn = draw(half);
            if two || drawn.len() > 1 {
                drawn
            } else {
                draw(wide)
            }
        })
        .collect();
    if columns.iter().all(Vec::is_empty) {
        sheet.text("", "no cutting move", FONT);
        return sheet.finish(&title);
    }
    legend(&mut sheet, run.tolerance_um);
    if two {
        heads(&mut sheet, run, &shown, half);
        let rows = columns.iter().map(Vec::len).max().unwrap_or(0);
        for row in 0..rows {
            let cells: Vec<&Drawing> = columns.iter().filter_map(|c| c.get(row)).collect();
            sheet.row(&cells, true);
        }
    } else if let Some(all) = columns.first() {
        let all: Vec<&Drawing> = all.iter().collect();
        let across = if all.len() > 1 { 2 } else { 1 };
        all.chunks(across).for_each(|cells| sheet.row(cells, true));
    }
    worst(&mut sheet, run, record, main);
    sheet.finish(&title)
}

/// Inside or outside, by how much, where and why.
fn verdict(sheet: &mut StillSheet, run: &Run, result: &MethodResult) {
    let tolerance = plain(run.tolerance_um);
    let (class, word) = match (&result.stop, result.within_tolerance) {
        (Some(stop), _) => ("bad", format!("the machine stops {}", stop_place(stop))),
        (None, true) => (
            "good",
            format!("within the tolerance of {tolerance} \u{b5}m"),
        ),
        (None, false) => (
            "bad",
            format!("OUTSIDE the tolerance of {tolerance} \u{b5}m"),
        ),
    };
    sheet.text(class, &format!("method {}: {word}", result.method), FONT);
    if let Some(stop) = &result.stop {
        sheet.text("", &stop_reason(stop), FONT);
    }
    let block = result.worst_blocks.iter().find(|block| !block.rapid);
    if let Some(block) = block.filter(|_| result.cutting.samples > 0) {
        let text = format!(
            "largest contour error {} \u{b5}m in line {}: {}",
            error(result.cutting.max),
            block.block.span.line,
            block.cause
        );
        sheet.text("", &text, FONT);
    }
    let time = duration(run.plan.duration_s);
    let text = format!(
        "{time} of machine time, {} mm cut",
        fixed(run.plan.cutting_mm, 0)
    );
    sheet.text("", &text, FONT);
}

/// The colours with the errors at which they change.
fn legend(sheet: &mut StillSheet, tolerance_um: f64) {
    sheet.y += 0.4 * LINE;
    sheet.text(
        "",
        "contour error, \u{b5}m; positive: left of the direction of travel",
        FONT,
    );
    let side = (WIDTH - 2.0 * MARGIN) / HUES.len() as f64;
    let top = sheet.y;
    for (number, hue) in HUES.iter().enumerate() {
        let [x, y, width] = [MARGIN + number as f64 * side, top, side].map(|c| fixed(c, 1));
        let _ = writeln!(
            sheet.body,
            "<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"14\" fill=\"{hue}\"/>"
        );
    }
    for (number, bound) in BOUNDS.iter().enumerate() {
        let at = [MARGIN + (number as f64 + 1.0) * side, top + 14.0 + FONT];
        let um = crate::number::round_to(bound * tolerance_um, 6);
        let text = format!(
            "{}{}",
            if um > 0.0 { "+" } else { "" },
            plain(um).replace('-', "\u{2212}")
        );
        sheet.element("", &text, at, "middle");
    }
    sheet.y += 14.0 + 1.6 * LINE;
}

/// The methods above their columns.
fn heads(sheet: &mut StillSheet, run: &Run, shown: &[usize], half: f64) {
    sheet.y += 0.8 * FONT;
    for (column, method) in shown.iter().enumerate() {
        let Some(result) = run.results.get(*method) else {
            continue;
        };
        let text = format!(
            "{}: max {} \u{b5}m",
            result.method,
            error(result.cutting.max)
        );
        let at = [MARGIN + column as f64 * (half + MARGIN), sheet.y];
        sheet.element("name", &fit(&text, FONT, half), at, "start");
    }
    sheet.y += 0.4 * LINE;
}

/// The worst places of the method that decides, enlarged.
fn worst(sheet: &mut StillSheet, run: &Run, record: &Gathered, main: usize) {
    let (Some(result), Some(watched)) = (run.results.get(main), record.methods.get(main)) else {
        return;
    };
    let width = (WIDTH - 4.0 * MARGIN) / DRAWN_PLACES as f64;
    let frame = Frame { width, font: FONT };
    let drawn: Vec<_> = drawn_blocks(result)
        .filter_map(|block| {
            let place = watched
                .places
                .iter()
                .find(|place| place.block == block.block)?;
            Some((block, enlarged::place(place, run.tolerance_um, frame)?))
        })
        .collect();
    if drawn.is_empty() {
        return;
    }
    sheet.y += 0.5 * LINE;
    sheet.text("name", "Worst places, enlarged", FONT);
    sheet.text(
        "",
        "black: the tool; grey: the program; dashed: the tolerance",
        FONT,
    );
    let top = sheet.y + 0.6 * LINE;
    for (number, (block, drawing)) in drawn.iter().enumerate() {
        let x = MARGIN + number as f64 * (width + MARGIN);
        let times = drawing.label.split(',').next().unwrap_or_default();
        let lines = [
            (
                "name",
                format!(
                    "line {}: {} \u{b5}m",
                    block.block.span.line,
                    signed(block.max_um)
                ),
            ),
            ("", block.cause.to_string()),
            ("", times.to_owned()),
        ];
        for (nth, (class, text)) in lines.iter().enumerate() {
            let at = [x, top + (nth as f64 + 0.5) * LINE];
            sheet.element(class, &fit(text, FONT, width), at, "start");
        }
    }
    sheet.y = top + 3.0 * LINE;
    let cells: Vec<&Drawing> = drawn.iter().map(|(_, drawing)| drawing).collect();
    sheet.row(&cells, false);
}

/// A picture that grows downwards.
#[derive(Default)]
struct StillSheet {
    body: String,
    /// Where the next element begins, px.
    y: f64,
}

impl StillSheet {
    /// A line of text.
    fn text(&mut self, class: &str, text: &str, size: f64) {
        self.y += 1.35 * size;
        let text = fit(text, size, WIDTH - 2.0 * MARGIN);
        self.element(class, &text, [MARGIN, self.y], "start");
        self.y += 0.25 * size;
    }

    fn element(&mut self, class: &str, text: &str, at: [f64; 2], anchor: &str) {
        let [x, y] = at.map(|c| fixed(c, 1));
        let _ = writeln!(
            self.body,
            "<text class=\"{class}\" x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\">{}</text>",
            escape(text)
        );
    }

    /// Drawings beside each other, with or without what is said of them.
    fn row(&mut self, cells: &[&Drawing], labelled: bool) {
        let highest = cells.iter().map(|cell| cell.size[1]).fold(0.0, f64::max);
        let mut x = MARGIN;
        let mut lines = 0;
        for cell in cells {
            let [width, _] = cell.size;
            let [left, top, w, h] = [x, self.y, width, highest].map(|c| fixed(c, 1));
            let _ = writeln!(
                self.body,
                "<rect class=\"frame\" x=\"{left}\" y=\"{top}\" width=\"{w}\" height=\"{h}\"/>"
            );
            let placed = cell.placed([x, self.y + 0.5 * (highest - cell.size[1])]);
            self.body.push_str(&placed);
            if labelled {
                // A part a line, so that nothing is cut off where two are beside each other.
                let parts: Vec<&str> = if text_width(&cell.label, FONT) <= width {
                    vec![&cell.label]
                } else {
                    cell.label.split("; ").collect()
                };
                for (line, part) in parts.iter().enumerate() {
                    let at = [x, self.y + highest + (line as f64 + 0.9) * LINE];
                    self.element("", &fit(part, FONT, width), at, "start");
                }
                lines = lines.max(parts.len());
            }
            x += width + MARGIN;
        }
        self.y += highest + lines as f64 * LINE + MARGIN;
    }

    fn finish(self, title: &str) -> String {
        let (width, height) = (fixed(WIDTH, 0), fixed(self.y + MARGIN, 0));
        let hues: String = HUES
            .iter()
            .enumerate()
            .map(|(number, hue)| format!(".e{number}{{stroke:{hue}}}"))
            .collect();
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\" font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\">\n\
             <title>{}</title>\n<style>{STYLE}{hues}</style>\n<rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n{}</svg>\n",
            escape(title),
            self.body
        )
    }
}
