//! A study of many cells as a page: a chart of what each method leaves in each cell, and the tables.

use super::data::escape;
use super::html::{foot, head};
use crate::number::percent;
use lostmotion_base::math;
use pulldown_cmark::{Event, HeadingLevel, Options, Parser, Tag, TagEnd, html};
use std::fmt::Write;

/// What a method leaves in the cells of a study.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MethodCells {
    /// Name of the method.
    pub method: String,
    /// The cells.
    pub cells: Vec<CellRatio>,
}

/// What a method leaves in a cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct CellRatio {
    /// Name of the cell.
    pub cell: String,
    /// What is left over what `none` leaves: 0.02 is 2 %.
    pub ratio: f64,
    /// Whether it is worse than `none`.
    pub worse: bool,
}

/// Height of the row of a method, and of the axis below; width of names and of the whole. Units of
/// the picture.
const ROW: f64 = 26.0;
const FOOT: f64 = 22.0;
const NAMES: f64 = 150.0;
const WIDTH: f64 = 760.0;
/// Where the chart ends to the left: what is smaller is drawn there. A choice.
const LEAST: f64 = 1e-3;

/// Writes the page of a study: its title, a chart of the methods, and its tables, which are Markdown.
/// It needs no scripts and no network.
///
/// ```
/// use lostmotion_report::page::{CellRatio, MethodCells, study_page};
///
/// let left = |cell: &str, ratio| CellRatio { cell: cell.to_owned(), ratio, worse: ratio > 1.0 };
/// let lookup = MethodCells {
///     method: "lookup".to_owned(),
///     cells: vec![left("square", 0.02), left("circle", 1.3)],
/// };
/// let page = study_page("Two cells", &[lookup], "| method | worst |\n|---|--:|\n| lookup | 130 % |\n");
/// assert!(page.starts_with("<!DOCTYPE html>") && page.contains("<td>lookup</td>"));
/// ```
pub fn study_page(title: &str, methods: &[MethodCells], markdown: &str) -> String {
    let mut out = String::new();
    head(&mut out, title);
    let _ = writeln!(
        out,
        "<main>\n<header>\n<h1>{}</h1>\n</header>",
        escape(title)
    );
    chart(&mut out, methods);
    tables(&mut out, markdown);
    foot(&mut out, "");
    out
}

/// Cells in the order of what is left in them; those of which nothing is known are left out.
fn sorted(method: &MethodCells) -> Vec<&CellRatio> {
    let known = method.cells.iter().filter(|cell| cell.ratio.is_finite());
    let mut cells: Vec<&CellRatio> = known.collect();
    cells.sort_by(|a, b| a.ratio.total_cmp(&b.ratio));
    cells
}

/// A row of dots for each method on a logarithmic scale, with the median as a bar.
fn chart(out: &mut String, methods: &[MethodCells]) {
    let cells = || methods.iter().flat_map(sorted);
    if cells().next().is_none() {
        return;
    }
    let most = cells().fold(1.0_f64, |most, cell| most.max(cell.ratio));
    let decades = math::log10(most / LEAST).ceil().max(3.0);
    let place = |ratio: f64| {
        let part = math::log10(ratio.max(LEAST) / LEAST) / decades;
        NAMES + 10.0 + part * (WIDTH - NAMES - 40.0)
    };
    let height = ROW * methods.len() as f64;
    let _ = writeln!(
        out,
        "<section id=\"chart\"><h2>What each method leaves</h2>\n<figure class=\"cells scroll\"><svg viewBox=\"0 0 {WIDTH} {}\" role=\"img\" aria-label=\"What each method leaves of the backlash of each cell\">",
        height + FOOT
    );
    for decade in 0..=decades as i32 {
        let ratio = LEAST * math::pow(10.0, f64::from(decade));
        let x = place(ratio);
        let _ = writeln!(
            out,
            "<line class=\"grid\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"0\" y2=\"{height}\"/><text x=\"{x:.1}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
            height + 15.0,
            percent(ratio)
        );
    }
    let x = place(1.0);
    let _ = writeln!(
        out,
        "<line class=\"none\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"0\" y2=\"{height}\"/>"
    );
    for (row, method) in methods.iter().enumerate() {
        let middle = (row as f64 + 0.5) * ROW;
        let cells = sorted(method);
        let _ = writeln!(
            out,
            "<text x=\"0\" y=\"{}\">{}</text>",
            middle + 4.0,
            escape(&method.method)
        );
        for cell in &cells {
            let class = if cell.worse { "worse" } else { "better" };
            let _ = writeln!(
                out,
                "<circle class=\"{class}\" cx=\"{:.1}\" cy=\"{middle}\" r=\"4\"><title>{}: {}</title></circle>",
                place(cell.ratio),
                escape(&cell.cell),
                percent(cell.ratio)
            );
        }
        // The cell that half of the others are not above.
        if let Some(median) = cells.get(cells.len().saturating_sub(1) / 2) {
            let x = place(median.ratio);
            let _ = writeln!(
                out,
                "<line class=\"median\" x1=\"{x:.1}\" x2=\"{x:.1}\" y1=\"{}\" y2=\"{}\"/>",
                middle - 10.0,
                middle + 10.0
            );
        }
    }
    let _ = writeln!(
        out,
        "</svg></figure>\n<p class=\"note\">A dot is a cell: the RMS of what backlash adds, of what it adds without compensation, on a logarithmic scale. 100 % is <i>none</i>; upright bars are medians; red dots are cells that the study counts as worse than none. What is below {} is drawn there.</p>\n</section>",
        percent(LEAST)
    );
}

/// Markdown as HTML: tables scroll by themselves, headings begin one level lower, the heading of the
/// whole gives way to the title of the page, and nothing is taken for markup that Markdown would let
/// through.
fn tables(out: &mut String, markdown: &str) {
    let lower = |level| match level {
        HeadingLevel::H1 | HeadingLevel::H2 => HeadingLevel::H2,
        _ => HeadingLevel::H3,
    };
    let mut in_title = false;
    let body = Parser::new_ext(markdown, Options::ENABLE_TABLES).filter(|event| {
        let of_title = TagEnd::Heading(HeadingLevel::H1);
        let begins = matches!(event, Event::Start(tag) if tag.to_end() == of_title);
        let inside = in_title || begins;
        in_title = inside && !matches!(event, Event::End(tag) if *tag == of_title);
        !inside
    });
    let events = body.flat_map(|event| match event {
        Event::Html(text) | Event::InlineHtml(text) => vec![Event::Text(text)],
        // a number keeps its unit on its line
        Event::Text(text) => vec![Event::Text(text.replace(" %", "\u{a0}%").into())],
        Event::Start(Tag::Table(columns)) => vec![
            Event::Html("<div class=\"scroll\">".into()),
            Event::Start(Tag::Table(columns)),
        ],
        Event::End(TagEnd::Table) => {
            vec![Event::End(TagEnd::Table), Event::Html("</div>\n".into())]
        }
        Event::Start(Tag::Heading {
            level,
            id,
            classes,
            attrs,
        }) => vec![Event::Start(Tag::Heading {
            level: lower(level),
            id,
            classes,
            attrs,
        })],
        Event::End(TagEnd::Heading(level)) => vec![Event::End(TagEnd::Heading(lower(level)))],
        event => vec![event],
    });
    out.push_str("<section id=\"tables\">\n");
    html::push_html(out, events);
    out.push_str("</section>\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    fn method(ratios: &[f64]) -> MethodCells {
        let cells = ratios.iter().enumerate();
        MethodCells {
            method: "<b>".to_owned(),
            cells: cells
                .map(|(n, ratio)| CellRatio {
                    cell: format!("cell {n}"),
                    ratio: *ratio,
                    worse: *ratio > 1.0,
                })
                .collect(),
        }
    }

    /// Places of dots, by the decades between 0.1 % and 100 %, and the median of five in the middle.
    #[test]
    fn dots_stand_where_their_ratios_are() {
        let page = study_page("t", &[method(&[0.1, 1e-9, 10.0, f64::NAN, 0.01, 1.0])], "");
        let of = |what: &str| -> Vec<f64> {
            let found = page.split(what).skip(1);
            found
                .map(|rest| rest.split('"').next().unwrap().parse().unwrap())
                .collect()
        };
        let dots = of("cx=\"");
        // Below the least, two and one decades below 100 %, there, and one above it.
        let step = dots[3] - dots[2];
        let expected = [0.0, 1.0, 2.0, 3.0, 4.0].map(|n| dots[0] + n * step);
        assert_eq!(dots.len(), 5);
        assert!(dots.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.2));
        assert_eq!(page.matches("class=\"worse\"").count(), 1);
        assert_eq!(of("class=\"median\" x1=\""), [dots[2]]);
        assert!(!page.contains("<b>"));
    }

    #[test]
    fn tables_are_tables_and_markup_stays_text() {
        let text = "# Whole\n\nread\n\n## Part\n\n| a | b |\n|---|--:|\n| <script>x</script> | 1 % |\n\n<script>y</script>\n";
        let page = study_page("Title & all", &[], text);
        assert!(page.contains("<h1>Title &amp; all</h1>") && !page.contains("Whole"));
        assert!(page.contains("<h2>Part</h2>") && page.contains("<table>"));
        assert_eq!(page.matches("<div class=\"scroll\">").count(), 1);
        assert!(!page.contains("<script>") && page.contains("&lt;script&gt;y"));
        assert!(!page.contains("<svg"));
    }
}
