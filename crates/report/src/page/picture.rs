//! What all still pictures of a result share: the colours of an error, rulers, and drawings that go
//! into the page or into a file of their own. They need no script, and print.

use super::data::escape;
use crate::number::{error, fixed};

/// Errors, as parts of the tolerance, at which the colour changes. Symmetric; beyond 1 is outside.
pub(super) const BOUNDS: [f64; 8] = [-1.0, -0.6, -0.3, -0.1, 0.1, 0.3, 0.6, 1.0];
/// Colours between the bounds on a light ground, from far right of travel to far left of it: told
/// apart with red-green blindness, too. The page's style sheet has the same, and those on a dark one.
pub(super) const HUES: [&str; 9] = [
    "#4b1fb8", "#1c57a5", "#3f8ac9", "#8ab8de", "#a3abb3", "#eeb272", "#d97a10", "#a84a00",
    "#c4001a",
];

/// Number of the colour of an error.
pub(super) fn color(error_um: f64, tolerance_um: f64) -> usize {
    let part = error_um / tolerance_um.max(1e-9);
    BOUNDS.iter().filter(|bound| part >= **bound).count()
}

/// Room that a drawing is made for.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// Width, px of its own scale.
    pub(super) width: f64,
    /// Size of its texts, px.
    pub(super) font: f64,
}

/// A drawing: elements of SVG in the colours of a style sheet, without the element around them.
#[derive(Clone, Debug)]
pub(super) struct Drawing {
    /// Width and height, px of its own scale.
    pub(super) size: [f64; 2],
    pub(super) body: String,
    /// What is seen, for a line below it and for those who cannot see it.
    pub(super) label: String,
    /// Points of its lines.
    pub(super) points: usize,
}

impl Drawing {
    /// As an element of a page.
    pub(super) fn inline(&self) -> String {
        let [width, height] = self.size.map(|side| fixed(side, 0));
        format!(
            "<svg viewBox=\"0 0 {width} {height}\" role=\"img\" aria-label=\"{}\">{}</svg>",
            escape(&self.label),
            self.body
        )
    }

    /// As an element at a place of a picture. What leaves its frame is cut off.
    pub(super) fn placed(&self, at: [f64; 2]) -> String {
        let [x, y, width, height] = [at[0], at[1], self.size[0], self.size[1]].map(|c| fixed(c, 1));
        format!(
            "<svg x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\" viewBox=\"0 0 {width} {height}\">{}</svg>\n",
            self.body
        )
    }
}

/// A length with its name, from a place on to the right.
pub(super) fn ruler([x, y]: [f64; 2], length: f64, name: &str) -> String {
    let [x0, x1, y0, y1, text, middle, base] = [
        x,
        x + length,
        y - 4.0,
        y + 4.0,
        x + length + 8.0,
        y,
        y + 4.5,
    ]
    .map(|c| fixed(c, 1));
    format!(
        "<path class=\"ruler\" d=\"M{x0} {y0}V{y1}M{x0} {middle}H{x1}M{x1} {y0}V{y1}\"/><text x=\"{text}\" y=\"{base}\">{name}</text>"
    )
}

/// An error with its sign.
pub(super) fn signed(um: f64) -> String {
    let text = error(um);
    if um > 0.0 {
        format!("+{text}")
    } else {
        text.replace('-', "\u{2212}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_style_sheet_has_the_same_colours() {
        let sheet = include_str!("assets/page.css");
        for (number, hue) in HUES.iter().enumerate() {
            // On screen and on paper.
            let found = sheet.matches(&format!("--e{number}: {hue};")).count();
            assert_eq!(found, 2, "{number}");
        }
    }

    #[test]
    fn colours_are_symmetric_and_change_at_the_tolerance() {
        assert_eq!(
            (color(0.0, 20.0), color(19.9, 20.0), color(20.0, 20.0)),
            (4, 7, 8)
        );
        for part in 1..200 {
            let um = f64::from(part) * 0.177;
            assert_eq!(color(um, 20.0) + color(-um, 20.0), 8, "{um}");
        }
    }
}
