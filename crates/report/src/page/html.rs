//! The page as text: the first screen is plain HTML, the rest is drawn by the scripts.

use super::advice::{remedy, settings};
use super::axes::{axes, reversals};
use super::ballbar;
use super::data::{data, embedded, escape, line, line_link, plane_letters, source};
use super::enlarged;
use super::levels::{self, Mark, Shown};
use super::picture::{Frame, signed};
use super::record::Gathered;
use crate::number::{duration, error, fixed, percent, plain};
use crate::text::{needs, stop_place, stop_reason, tested, what_it_takes};
use lostmotion_sim::results::{BlockResult, ErrorStats, Harm, MethodResult, Run};
use lostmotion_sim::{Machine, Program};
use std::fmt::Write;
use std::io;

const STYLE: &str = include_str!("assets/page.css");
/// In the order in which they need each other.
const SCRIPTS: [&str; 6] = [
    include_str!("assets/base.js"),
    include_str!("assets/parts.js"),
    include_str!("assets/view.js"),
    include_str!("assets/source.js"),
    include_str!("assets/plots.js"),
    include_str!("assets/main.js"),
];

/// Most rows of a table, and most remarks. A choice: the JSON form has all.
const MOST_ROWS: usize = 10;
const MOST_WARNINGS: usize = 10;
/// Worst places that are drawn enlarged.
pub(super) const DRAWN_PLACES: usize = 3;
/// Most levels of Z that are drawn. A choice.
const MOST_LEVELS: usize = 6;
/// Room of a drawing of the path, and of a worst place.
const PANEL_FRAME: Frame = Frame {
    width: 640.0,
    font: 14.0,
};
const PLACE_FRAME: Frame = Frame {
    width: 300.0,
    font: 13.0,
};

/// Writes the page of a run.
///
/// `record` is what was gathered of the run ([`PageRecorder::finish`]); the program is read once more
/// for its lines.
///
/// [`PageRecorder::finish`]: super::PageRecorder::finish
///
/// # Errors
/// The program cannot be read any more.
pub fn page(
    run: &Run,
    machine: &Machine,
    program: &Program,
    record: &Gathered,
) -> io::Result<String> {
    let lines = source(program, run)?;
    // Where none is recommended the first is shown.
    let main = run.deciding_index().unwrap_or(0);
    let mut out = String::new();
    let title = format!(
        "{} on {}: contour error",
        file_name(&run.program.name),
        run.machine
    );
    head(&mut out, &title);
    first_screen(&mut out, run, machine, record, main);
    out.push_str(VIEW);
    let shown = Shown {
        method: main,
        tolerance_um: run.tolerance_um,
        marks: &marks(run, main),
        levels: MOST_LEVELS,
    };
    let still = levels::path(&record.path, shown, PANEL_FRAME);
    if !still.is_empty() {
        out.push_str("<details id=\"still\" open><summary>Still pictures of the path</summary>");
        out.push_str(LEGEND);
        out.push_str("<div class=\"panels\">");
        for drawing in still {
            let _ = writeln!(
                out,
                "<figure class=\"panel\">{}<figcaption>{}</figcaption></figure>",
                drawing.inline(),
                escape(&drawing.label)
            );
        }
        out.push_str("</div></details>\n");
    }
    out.push_str(PLOTS);
    if let Some(result) = run.results.get(main) {
        axes(&mut out, result, record, main);
        circles(&mut out, record, main);
        reversals(&mut out, result);
    }
    remarks(&mut out, run);
    let json = embedded(&data(run, machine, record, main, &lines));
    let scripts = format!(
        "<script type=\"application/json\" id=\"data\">{json}</script>\n<script>\n\"use strict\";\n{}</script>\n",
        SCRIPTS.concat()
    );
    foot(&mut out, &scripts);
    Ok(out)
}

/// The worst blocks that are drawn: of a line that is cut again and again the worst time alone.
pub(super) fn drawn_blocks(result: &MethodResult) -> impl Iterator<Item = &BlockResult> {
    let mut seen = Vec::new();
    let fresh = move |block: &&BlockResult| {
        let at = (block.block.span.file, block.block.span.line);
        let is_fresh = !seen.contains(&at);
        seen.push(at);
        is_fresh
    };
    let cutting = result.worst_blocks.iter().filter(|block| !block.rapid);
    cutting.filter(fresh).take(DRAWN_PLACES)
}

/// The worst places, as they are marked in the pictures.
pub(super) fn marks(run: &Run, main: usize) -> Vec<Mark> {
    let blocks = run.results.get(main).into_iter().flat_map(drawn_blocks);
    blocks
        .map(|block| Mark {
            at_mm: block.at_mm,
            name: format!("line {}", line(&block.block)),
        })
        .collect()
}

/// The colours of an error, for the still pictures and the view alike.
const LEGEND: &str = "<p class=\"legend\"><span>right of travel</span><i class=\"b0\"></i><i class=\"b1\"></i><i class=\"b2\"></i><i class=\"b3\"></i><i class=\"b4\"></i><i class=\"b5\"></i><i class=\"b6\"></i><i class=\"b7\"></i><i class=\"b8\"></i><span>left of travel</span> <small>steps at 10, 30, 60 and 100 % of the tolerance; the outermost colours are outside it</small></p>\n";

/// What the scripts fill; hidden without them.
const VIEW: &str = include_str!("assets/view.html");
const PLOTS: &str = include_str!("assets/plots.html");

/// Everything before the body's content.
pub(super) fn head(out: &mut String, title: &str) {
    let _ = writeln!(
        out,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{}</title>\n<style>\n{STYLE}</style>\n</head>\n<body>",
        escape(title)
    );
}

/// The end of every page, behind its scripts.
pub(super) fn foot(out: &mut String, scripts: &str) {
    let _ = writeln!(
        out,
        "<footer>Written by lostmotion {}. This file needs no network.</footer>\n</main>\n{scripts}</body>\n</html>",
        env!("CARGO_PKG_VERSION")
    );
}

/// A page that says why there is no result; it needs no scripts.
pub fn message_page(title: &str, text: &str) -> String {
    let mut out = String::new();
    head(&mut out, title);
    let _ = writeln!(
        out,
        "<main><header><h1>{}</h1></header><pre class=\"scroll\">",
        escape(title)
    );
    for line in text.lines() {
        let _ = writeln!(out, "{}", escape(line));
    }
    out.push_str("</pre></main>\n</body>\n</html>");
    out
}

/// The last part of a path.
pub(super) fn file_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

fn first_screen(out: &mut String, run: &Run, machine: &Machine, record: &Gathered, main: usize) {
    let Some(result) = run.results.get(main) else {
        out.push_str("<main><h1>No method was run</h1>\n");
        return;
    };
    verdict(out, run, result);
    if run.results.len() > 1 {
        methods(out, run, main);
    } else {
        errors(out, run, result);
    }
    if let Some(values) = settings(result, machine) {
        let _ = writeln!(
            out,
            "<p class=\"advice\"><b>To set on the control</b> for {}: {}</p>",
            escape(&result.method),
            escape(&values)
        );
    }
    worst(out, run, record, main);
}

/// Inside or outside, by how much, where and why.
fn verdict(out: &mut String, run: &Run, result: &MethodResult) {
    let (class, word) = match (&result.stop, result.within_tolerance) {
        (Some(_), _) => ("bad", "The machine stops"),
        (None, true) => ("good", "within tolerance"),
        (None, false) => ("bad", "OUTSIDE tolerance"),
    };
    let _ = writeln!(
        out,
        "<main>\n<header>\n<h1>{}</h1>\n<p class=\"who\">on {}, method {}{}</p>\n<p class=\"verdict {class}\">{word}</p>",
        escape(file_name(&run.program.name)),
        escape(&run.machine),
        escape(&result.method),
        if run.results.len() > 1 {
            " (the one that decides)"
        } else {
            ""
        },
    );
    if let Some(stop) = &result.stop {
        let _ = writeln!(
            out,
            "<p class=\"finding\">{}: {}. All figures are of what was before.</p>",
            escape(&stop_place(stop)),
            escape(&stop_reason(stop))
        );
    }
    let worst = result.worst_blocks.iter().find(|block| !block.rapid);
    if result.cutting.samples == 0 {
        out.push_str("<p class=\"finding\">The program has no cutting move.</p>\n");
    } else {
        let place = worst.map_or(String::new(), |block| {
            format!(
                " in line {}: {}",
                line_link(&block.block, block.time_s),
                escape(&block.cause.to_string())
            )
        });
        let _ = writeln!(
            out,
            "<p class=\"finding\">Largest contour error <b>{} \u{b5}m</b>{place}</p>",
            error(result.cutting.max)
        );
        meter(out, result.cutting.max, run.tolerance_um);
        if let Some(block) = worst {
            let _ = writeln!(
                out,
                "<p class=\"note\">What helps there: {}.</p>",
                remedy(block.cause)
            );
        }
    }
    let facts = [
        (duration(run.plan.duration_s), "cycle time"),
        (format!("{} mm", fixed(run.plan.cutting_mm, 0)), "cutting"),
        (format!("{} mm", fixed(run.plan.rapid_mm, 0)), "rapid"),
        (run.program.moves.to_string(), "moves"),
        (run.program.lines.to_string(), "lines"),
    ];
    out.push_str("<dl class=\"facts\">");
    for (value, name) in facts {
        let _ = write!(out, "<div><dt>{name}</dt><dd>{value}</dd></div>");
    }
    out.push_str("</dl>\n</header>\n");
}

/// The error beside the tolerance as a bar.
pub(super) fn meter(out: &mut String, max_um: f64, tolerance_um: f64) {
    let whole = max_um.max(tolerance_um).max(1e-9) * 1.05;
    let part = |um: f64| fixed(400.0 * um / whole, 1);
    let class = if max_um <= tolerance_um {
        "good"
    } else {
        "bad"
    };
    let _ = writeln!(
        out,
        "<svg class=\"meter\" viewBox=\"0 0 400 34\" role=\"img\" aria-label=\"{e} of {t} um\"><rect class=\"ground\" y=\"6\" width=\"400\" height=\"12\" rx=\"2\"/><rect class=\"{class}\" y=\"6\" width=\"{w}\" height=\"12\" rx=\"2\"/><path class=\"mark\" d=\"M{x} 1V22\"/><text x=\"{x}\" y=\"33\" text-anchor=\"end\">tolerance {t} \u{b5}m</text></svg>",
        e = error(max_um),
        t = plain(tolerance_um),
        w = part(max_um),
        x = part(tolerance_um),
    );
}

/// Methods side by side, the recommendation, and why.
fn methods(out: &mut String, run: &Run, main: usize) {
    let none = run.results.iter().find(|result| result.is_baseline());
    out.push_str("<section id=\"methods\"><h2>Methods side by side</h2>\n");
    let how = tested(&run.results);
    let _ = match &run.recommended {
        Some(name) => writeln!(
            out,
            "<p class=\"advice\"><b>Recommended: {}</b>: the smallest error that stays small{}</p>",
            escape(name),
            escape(&how)
        ),
        None => writeln!(
            out,
            "<p class=\"advice\"><b>No method is recommended</b>; the reasons are in the table.</p>"
        ),
    };
    if let Some(trust) = &run.trust {
        let _ = writeln!(out, "<p>{}.</p>", escape(&what_it_takes(trust)));
    }
    out.push_str("<div class=\"scroll\"><table><thead><tr><th>method<th class=\"n\">max \u{b5}m<th class=\"n\">RMS<th class=\"n\">p99<th class=\"n\">by backlash<th class=\"n\">of none<th>verdict<th>needs<th>remark</tr></thead><tbody>\n");
    for (index, result) in run.results.iter().enumerate() {
        let class = if index == main { " class=\"main\"" } else { "" };
        let ratio = none
            .filter(|n| n.backlash.rms > 0.0 && n.stop.is_none())
            .map_or("-".to_owned(), |n| {
                percent(result.backlash.rms / n.backlash.rms)
            });
        let _ = write!(
            out,
            "<tr{class}><th scope=\"row\">{}",
            escape(&result.method)
        );
        if let Some(stop) = &result.stop {
            let _ = writeln!(
                out,
                "<td colspan=\"5\">-<td class=\"bad\">stops {}<td>{}<td>{}</tr>",
                escape(&stop_place(stop)),
                needs(&result.method),
                escape(&stop_reason(stop))
            );
            continue;
        }
        let (class, word) = if result.within_tolerance {
            ("good", "within")
        } else {
            ("bad", "outside")
        };
        let _ = writeln!(
            out,
            "<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{ratio}<td class=\"{class}\">{word}<td>{}<td>{}</tr>",
            error(result.cutting.max),
            error(result.cutting.rms),
            error(result.cutting.p99),
            error(result.backlash.max),
            needs(&result.method),
            escape(&remark(result, none)),
        );
    }
    let free = &run.without_gap;
    let _ = writeln!(
        out,
        "<tr class=\"soft\"><th scope=\"row\">(no gap)<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">-<td class=\"n\">-<td>{}<td>-<td>the same machine without a gap</tr>\n</tbody></table></div>\n</section>",
        error(free.max),
        error(free.rms),
        error(free.p99),
        if free.max <= run.tolerance_um {
            "within"
        } else {
            "outside"
        },
    );
}

/// Why a method is not recommended, or in what it does harm.
fn remark(result: &MethodResult, none: Option<&MethodResult>) -> String {
    if let Some(reason) = &result.not_recommended {
        return reason.clone();
    }
    match none.and_then(|n| result.harm(n)) {
        Some(Harm::Rms(ratio)) => format!("worse than none, {} times", fixed(ratio, 2)),
        Some(Harm::Peak(ratio)) => format!("higher peak than none, {} times", fixed(ratio, 2)),
        None => String::new(),
    }
}

/// The distribution of the error of one method, and its parts.
fn errors(out: &mut String, run: &Run, result: &MethodResult) {
    out.push_str("<section id=\"errors\"><h2>Contour error, \u{b5}m</h2>\n<div class=\"scroll\"><table><thead><tr><th><th class=\"n\">max<th class=\"n\">RMS<th class=\"n\">p50<th class=\"n\">p95<th class=\"n\">p99<th class=\"n\">p99.9</tr></thead><tbody>\n");
    let rows: [(&str, &ErrorStats); 5] = [
        ("cutting moves", &result.cutting),
        ("caused by backlash", &result.backlash),
        ("same machine without gap", &run.without_gap),
        ("command itself (blending)", &run.plan.command),
        ("rapids", &result.rapid),
    ];
    for (name, stats) in rows {
        let _ = write!(out, "<tr><th scope=\"row\">{name}");
        for value in [
            stats.max, stats.rms, stats.p50, stats.p95, stats.p99, stats.p999,
        ] {
            let text = if stats.samples == 0 {
                "-".to_owned()
            } else {
                error(value)
            };
            let _ = write!(out, "<td class=\"n\">{text}");
        }
        out.push_str("</tr>\n");
    }
    out.push_str("</tbody></table></div>\n</section>\n");
}

/// Worst blocks: three enlarged, ten as a table.
fn worst(out: &mut String, run: &Run, record: &Gathered, main: usize) {
    let Some(result) = run.results.get(main) else {
        return;
    };
    if result.worst_blocks.is_empty() {
        return;
    }
    out.push_str("<section id=\"worst\"><h2>Worst places</h2>\n<div class=\"places\">");
    let places = record.methods.get(main).map_or(&[][..], |m| &m.places);
    for block in drawn_blocks(result) {
        let drawn = places
            .iter()
            .find(|place| place.block == block.block)
            .and_then(|place| enlarged::place(place, run.tolerance_um, PLACE_FRAME));
        let Some(drawing) = drawn else {
            continue;
        };
        let _ = write!(
            out,
            "<figure class=\"place\"><figcaption><b>line {}</b> {} \u{b5}m, {}</figcaption>{}<p class=\"note\">{}</p></figure>",
            line_link(&block.block, block.time_s),
            signed(block.max_um),
            escape(&block.cause.to_string()),
            drawing.inline(),
            drawing.label
        );
    }
    out.push_str("</div>\n<div class=\"scroll\"><table><thead><tr><th class=\"n\">line<th class=\"n\">error \u{b5}m<th class=\"n wide\">command<th class=\"n wide\">servo<th class=\"n wide\">backlash<th>cause<th class=\"n wide\">time s<th>block</tr></thead><tbody>\n");
    for block in result.worst_blocks.iter().take(MOST_ROWS) {
        worst_row(out, block, run.tolerance_um);
    }
    out.push_str("</tbody></table></div>\n<p class=\"note\">Positive: left of the direction of travel. <i>command</i> is rounding by G64, <i>servo</i> what the machine without a gap does, <i>backlash</i> the rest; the three add up to the error.</p>\n</section>\n");
}

fn worst_row(out: &mut String, block: &BlockResult, tolerance_um: f64) {
    let class = if block.max_um.abs() > tolerance_um {
        " bad"
    } else {
        ""
    };
    let parts = [
        block.parts_um.command,
        block.parts_um.servo,
        block.parts_um.backlash,
    ];
    let _ = write!(
        out,
        "<tr><td class=\"n\">{}<td class=\"n{class}\">{}",
        line_link(&block.block, block.time_s),
        signed(block.max_um)
    );
    for part in parts {
        let _ = write!(out, "<td class=\"n wide\">{}", signed(part));
    }
    let _ = writeln!(
        out,
        "<td>{}{}<td class=\"n wide\">{}<td class=\"code\">{}</tr>",
        escape(&block.cause.to_string()),
        if block.rapid { ", rapid" } else { "" },
        fixed(block.time_s, 3),
        escape(&block.text)
    );
}

/// The circular test in figures; the scripts draw the polar plots.
fn circles(out: &mut String, record: &Gathered, main: usize) {
    let circles = record.methods.get(main).map_or(&[][..], |m| &m.circles);
    if circles.is_empty() {
        return;
    }
    out.push_str("<section id=\"circles\"><h2>Full circles, as a ballbar shows them</h2>\n<div id=\"polar\"></div>\n<div class=\"scroll\"><table><thead><tr><th class=\"n\">line<th>plane<th class=\"n\">radius mm<th>sense<th class=\"n\">G \u{b5}m<th class=\"n\">F min<th class=\"n\">F max<th class=\"n\">H</tr></thead><tbody>\n");
    for circle in circles {
        let _ = writeln!(
            out,
            "<tr><td class=\"n\"><a href=\"#view\" data-t=\"{}\">{}</a><td>{}<td class=\"n\">{}<td>{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}</tr>",
            fixed(circle.time_s, 5),
            circle.line,
            plane_letters(circle).concat(),
            plain(crate::number::round_to(circle.radius_mm, 3)),
            if circle.counterclockwise { "ccw" } else { "cw" },
            error(circle.g_um),
            signed(circle.f_um[0]),
            signed(circle.f_um[1]),
            circle.h_um.map_or("-".to_owned(), error),
        );
    }
    out.push_str("</tbody></table></div>\n");
    out.push_str("<div class=\"scroll\"><table><thead><tr><th class=\"n\">line<th class=\"n\">reversal spikes \u{b5}m<th class=\"n\">lost motion \u{b5}m<th class=\"n\">squareness \u{b5}m/m<th class=\"n\">servo mismatch \u{b5}m<th class=\"n\">scale mismatch \u{b5}m/m</tr></thead><tbody>\n");
    for circle in circles {
        let sheet = ballbar::sheet(circle, circles);
        let letters = plane_letters(circle);
        let pair = |um: [f64; 2], shown: &dyn Fn(f64) -> String| {
            format!(
                "{} {}, {} {}",
                letters[0],
                shown(um[0]),
                letters[1],
                shown(um[1])
            )
        };
        let both = |at: usize| {
            sheet
                .both
                .as_ref()
                .map_or("-".to_owned(), |both| signed(both[at]))
        };
        let _ = writeln!(
            out,
            "<tr><td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}</tr>",
            circle.line,
            pair(sheet.spike_um, &|um| error(um)),
            pair(sheet.step_um, &|um| signed(um)),
            both(0),
            both(1),
            both(2),
        );
    }
    out.push_str("</tbody></table></div>\n<p class=\"note\">As a ballbar's sheet names it: a <i>reversal spike</i> is how far the path leaves the band between before and behind the reversal of an axis (stick-slip, gap: compensate it), <i>lost motion</i> the step of the level there, positive outwards (gap and wind-up: enter it as backlash). With the same circle in the other sense: <i>squareness</i> and <i>scale mismatch</i> stay, <i>servo mismatch</i> turns over: by so much is the first axis behind the second at this feed (match gains and feed-forward).</p>\n<p class=\"note\">After ISO 230-4: circular deviation G is the width of the ring about the least-squares centre that holds the path; radial deviation F is against the programmed circle, positive outwards; circular hysteresis H is the largest difference between the same circle cut in both senses (- where it is cut in one).</p>\n</section>\n");
}

fn remarks(out: &mut String, run: &Run) {
    let notes = run.results.iter().flat_map(|result| {
        let name = (run.results.len() > 1).then(|| format!("{}: ", result.method));
        let with_name = move |note: &String| format!("{}{note}", name.as_deref().unwrap_or(""));
        result.notes.iter().map(with_name)
    });
    let all: Vec<String> = run.program.warnings.iter().cloned().chain(notes).collect();
    if all.is_empty() {
        return;
    }
    out.push_str("<section id=\"remarks\"><h2>Remarks</h2>\n<ul>\n");
    for remark in all.iter().take(MOST_WARNINGS) {
        let _ = writeln!(out, "<li>{}</li>", escape(remark));
    }
    if all.len() > MOST_WARNINGS {
        let _ = writeln!(out, "<li>and {} more</li>", all.len() - MOST_WARNINGS);
    }
    out.push_str("</ul>\n</section>\n");
}
