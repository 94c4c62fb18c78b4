//! Elements of a picture.

use crate::number::fixed;

/// Dark text and frames.
pub(super) const INK: &str = "#1f2933";
/// Secondary text.
pub(super) const SOFT: &str = "#52606d";
/// Grid and programmed contour.
pub(super) const FAINT: &str = "#cbd2d9";
/// Colours of methods in order; distinguishable also with red-green blindness (after Okabe and
/// Ito).
pub(super) const COLORS: [&str; 7] = [
    "#d55e00", "#0072b2", "#cc3377", "#00855f", "#8a6d00", "#3b93c9", "#5b3fa0",
];

/// Mean width of a character in parts of the font size: an estimate for sans-serif fonts, as there
/// is none to measure.
const GLYPH_WIDTH: f64 = 0.56;

/// Where a text is anchored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a line is drawn.
#[derive(Clone, Copy, Debug)]
pub(super) struct Stroke {
    pub(super) color: &'static str,
    pub(super) width: f64,
}

impl Stroke {
    pub(super) const fn new(color: &'static str, width: f64) -> Stroke {
        Stroke { color, width }
    }

    fn attributes(self) -> String {
        format!(
            "stroke=\"{}\" stroke-width=\"{}\"",
            self.color,
            fixed(self.width, 2)
        )
    }
}

/// A picture being drawn; y points down, as in SVG.
#[derive(Debug)]
pub(super) struct Canvas {
    width: f64,
    height: f64,
    body: String,
}

impl Canvas {
    pub(super) fn new(width: f64, height: f64) -> Canvas {
        Canvas {
            width,
            height,
            body: String::new(),
        }
    }

    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2], stroke: Stroke) {
        let [x1, y1, x2, y2] = [from[0], from[1], to[0], to[1]].map(|c| fixed(c, 2));
        self.body.push_str(&format!(
            "<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" {}/>\n",
            stroke.attributes()
        ));
    }

    pub(super) fn frame(&mut self, at: [f64; 2], size: [f64; 2], stroke: Stroke) {
        let [x, y, w, h] = [at[0], at[1], size[0], size[1]].map(|c| fixed(c, 2));
        self.body.push_str(&format!(
            "<rect x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\" fill=\"none\" {}/>\n",
            stroke.attributes()
        ));
    }

    pub(super) fn polyline(&mut self, points: &[[f64; 2]], stroke: Stroke) {
        // A path of one point draws nothing, and some viewers refuse it.
        if points.len() > 1 {
            let data = path_data(points);
            self.body.push_str(&format!(
                "<path d=\"{data}\" fill=\"none\" stroke-linejoin=\"round\" {}/>\n",
                stroke.attributes()
            ));
        }
    }

    pub(super) fn text(
        &mut self,
        at: [f64; 2],
        text: &str,
        size: f64,
        color: &str,
        anchor: Anchor,
    ) {
        self.styled_text(at, text, size, color, anchor, "");
    }

    pub(super) fn bold(
        &mut self,
        at: [f64; 2],
        text: &str,
        size: f64,
        color: &str,
        anchor: Anchor,
    ) {
        self.styled_text(at, text, size, color, anchor, " font-weight=\"bold\"");
    }

    /// Text that reads upwards.
    pub(super) fn upright(&mut self, at: [f64; 2], text: &str, size: f64, color: &str) {
        let turn = format!(
            " transform=\"rotate(-90 {} {})\"",
            fixed(at[0], 2),
            fixed(at[1], 2)
        );
        self.styled_text(at, text, size, color, Anchor::Middle, &turn);
    }

    fn styled_text(
        &mut self,
        at: [f64; 2],
        text: &str,
        size: f64,
        color: &str,
        anchor: Anchor,
        more: &str,
    ) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let ([x, y], size) = (at.map(|c| fixed(c, 2)), fixed(size, 1));
        let text = escape(text);
        self.body.push_str(&format!(
            "<text x=\"{x}\" y=\"{y}\" font-size=\"{size}\" fill=\"{color}\" text-anchor=\"{anchor}\"{more}>{text}</text>\n"
        ));
    }

    pub(super) fn finish(self, title: &str) -> String {
        let (w, h) = (fixed(self.width, 0), fixed(self.height, 0));
        // With a ground of its own: a dark viewer would swallow the ink.
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
             font-family=\"Helvetica, Arial, 'DejaVu Sans', sans-serif\">\n<title>{}</title>\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n{}</svg>\n",
            escape(title),
            self.body
        )
    }
}

/// Estimated width of a text.
pub(crate) fn text_width(text: &str, size: f64) -> f64 {
    text.chars().count() as f64 * size * GLYPH_WIDTH
}

/// `text` cut to what fits into a width.
pub(crate) fn fit(text: &str, size: f64, width: f64) -> String {
    // At least one character before the three dots.
    let room = (width / (size * GLYPH_WIDTH)).max(4.0) as usize;
    if text.chars().count() <= room {
        text.to_owned()
    } else {
        text.chars().take(room - 3).chain("...".chars()).collect()
    }
}

fn path_data(points: &[[f64; 2]]) -> String {
    let mut data = String::with_capacity(points.len() * 14);
    for (index, point) in points.iter().enumerate() {
        data.push(if index == 0 { 'M' } else { 'L' });
        // A hundredth of a pixel: finer digits only make the file larger.
        data.push_str(&fixed(point[0], 2));
        data.push(' ');
        data.push_str(&fixed(point[1], 2));
    }
    data
}

fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // XML has no control characters, escaped or not.
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}
