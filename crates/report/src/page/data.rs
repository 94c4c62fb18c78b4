//! The numbers of a page as JSON with packed arrays, and its texts so that no program can break out
//! of them.

use super::circles::FullCircle;
use super::path::Path;
use super::places::Place;
use super::record::{Gathered, Motor, SIGNALS, Watched};
use super::series::{Envelope, Limits};
use crate::number::{fixed, round_to};
use lostmotion_base::BlockRef;
use lostmotion_sim::results::{BlockResult, MethodResult, ReversalResult, Run};
use lostmotion_sim::{Limiter, Machine, Program};
use serde_json::{Value, json};
use std::io::{self, BufRead};

/// Longest line of the program that is shown, characters. A choice.
const LONGEST_LINE: usize = 160;
/// Most text of the program in a page, bytes: with the path and the series it stays below 5 MB.
const MOST_SOURCE_BYTES: usize = 800_000;
/// Lines that are shown around a worst block of a program that is too long to be shown whole.
const LINES_AROUND: u32 = 200;
/// Steps of a packed number on one side of 0: those of 16 bits, without the lowest, which stands for
/// no value.
const STEPS: f64 = 32_767.0;

/// Signal behind [`SIGNALS`], of methods that learn.
const GAP_ESTIMATE: &str = "gap estimate";

/// Longest text that is shown, characters: names and messages can be of any length. A choice.
const LONGEST_TEXT: usize = 1_000;

/// Text without what changes how others are shown: control characters, and those that turn the
/// direction of writing.
pub(super) fn clean(text: &str) -> String {
    let shown = text.chars().take(LONGEST_TEXT).map(|c| match c {
        '\t' | '\n' => ' ',
        '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}' => '\u{fffd}',
        c if c.is_control() => '\u{fffd}',
        c => c,
    });
    shown.collect()
}

/// Text for HTML: markup loses its meaning, control characters their effect.
pub(super) fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in clean(text).chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            c => out.push(c),
        }
    }
    out
}

/// The line of a block, with the number of its file if that is not the program.
pub(super) fn line(block: &BlockRef) -> String {
    match block.span.file {
        0 => block.span.line.to_string(),
        file => format!("{file}:{}", block.span.line),
    }
}

/// The line of a block for HTML, which the scripts make clickable.
pub(super) fn line_link(block: &BlockRef, time_s: f64) -> String {
    format!(
        "<a href=\"#view\" data-t=\"{}\">{}</a>",
        fixed(time_s, 5),
        line(block)
    )
}

/// JSON for a `script` element: no `<` can end it, in whatever text it stands.
pub(super) fn embedded(value: &Value) -> String {
    let mut out = String::new();
    for c in value.to_string().chars() {
        match c {
            '<' => out.push_str("\\u003c"),
            '>' => out.push_str("\\u003e"),
            '&' => out.push_str("\\u0026"),
            '\u{2028}' => out.push_str("\\u2028"),
            '\u{2029}' => out.push_str("\\u2029"),
            c => out.push(c),
        }
    }
    out
}

/// Bytes as text of 64 characters (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const CHARACTERS: [u8; 64] =
        *b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let at = |index: usize| u32::from(three.get(index).copied().unwrap_or(0));
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for place in 0..4 {
            out.push(if place > three.len() {
                '='
            } else {
                char::from(CHARACTERS[(bits >> (18 - 6 * place) & 63) as usize])
            });
        }
    }
    out
}

/// Values as 16 bits each, with the value of a step.
fn packed(values: impl Iterator<Item = f32> + Clone) -> Value {
    let largest = values
        .clone()
        .filter(|value| value.is_finite())
        .fold(0.0_f64, |most, value| most.max(f64::from(value.abs())));
    let step = if largest > 0.0 { largest / STEPS } else { 1.0 };
    let mut bytes = Vec::new();
    for value in values {
        let steps = if value.is_finite() {
            (f64::from(value) / step).round().clamp(-STEPS, STEPS) as i16
        } else {
            i16::MIN
        };
        bytes.extend_from_slice(&steps.to_le_bytes());
    }
    json!({ "step": step, "b": base64(&bytes) })
}

/// Smallest and largest values of a signal, one after the other.
fn ends(series: &Envelope, signal: usize) -> Value {
    let of = |end: usize| packed(series.signal(signal).map(move |part| part[end]));
    json!({ "low": of(0), "high": of(1) })
}

/// What limits the motion over time: for each limiter that there is its part of the whole and of each
/// part of the time, largest first. Its number is its index.
fn limits(limits: &Limits) -> Value {
    let mut found: Vec<(Limiter, f64)> = Limiter::ALL
        .into_iter()
        .map(|limiter| (limiter, limits.share(limiter)))
        .filter(|(_, share)| *share > 0.0)
        .collect();
    found.sort_by(|(_, a), (_, b)| b.total_cmp(a));
    let every = found.into_iter().map(|(limiter, share)| {
        let bytes: Vec<u8> = limits
            .shares(limiter)
            .map(|share| (share * 255.0).round() as u8)
            .collect();
        json!({
            "limiter": limiter.index(),
            "name": limiter.to_string(),
            "share": round_to(share, 5),
            "parts": base64(&bytes),
        })
    });
    json!({
        "n": limits.len(),
        "ticks": limits.group(),
        "every": every.collect::<Vec<_>>(),
    })
}

/// Number of a stretch without a limiter.
const NO_LIMITER: u8 = u8::MAX;

fn path(path: &Path) -> Value {
    let stretches = &path.stretches;
    let mut low = [f32::INFINITY; 3];
    let mut high = [f32::NEG_INFINITY; 3];
    for stretch in stretches {
        for axis in 0..3 {
            low[axis] = low[axis].min(stretch.from_mm[axis]);
            high[axis] = high[axis].max(stretch.from_mm[axis]);
        }
    }
    let step = [0, 1, 2].map(|axis| ((high[axis] - low[axis]) / 65_535.0).max(1e-9));
    let (mut places, mut normals, mut times, mut kinds) = (vec![], vec![], vec![], vec![]);
    let (mut tools, mut limiters) = (Vec::new(), Vec::new());
    // Below any servo cycle, and coarser only where 12 hours would not fit.
    let end = stretches.last().map_or(0.0, |stretch| stretch.time_s);
    let time_step = (end / f64::from(u32::MAX)).max(1e-5);
    // Lines come in runs: file, line, and the stretch from which on.
    let mut runs: Vec<[u64; 3]> = Vec::new();
    for (index, stretch) in stretches.iter().enumerate() {
        for axis in 0..3 {
            let steps = (stretch.from_mm[axis] - low[axis]) / step[axis];
            places.extend_from_slice(&(steps.round() as u16).to_le_bytes());
            normals.push((stretch.normal[axis] * 127.0).round() as i8 as u8);
            if path.leans {
                tools.push((stretch.tool[axis] * 127.0).round() as i8 as u8);
            }
        }
        times.extend_from_slice(&((stretch.time_s / time_step).round() as u32).to_le_bytes());
        let limiter = stretch.limiter.limiter;
        limiters.push(limiter.map_or(NO_LIMITER, |limiter| limiter.index() as u8));
        kinds.push(u8::from(stretch.rapid) | u8::from(stretch.broken) << 1);
        let at = [u64::from(stretch.file), u64::from(stretch.line)];
        if runs.last().is_none_or(|run| run[..2] != at) {
            runs.push([at[0], at[1], index as u64]);
        }
    }
    // As differences: mostly 0, 1 and a small number.
    let mut last = [0_u64; 3];
    let runs: Vec<i64> = runs
        .into_iter()
        .flat_map(|run| {
            let change = [0, 1, 2].map(|of| run[of] as i64 - last[of] as i64);
            last = run;
            change
        })
        .collect();
    json!({
        "n": stretches.len(),
        "low": if stretches.is_empty() { [0.0; 3] } else { low },
        "step": step,
        "at": base64(&places),
        "normal": base64(&normals),
        // Of machines that turn the tool.
        "tool": path.leans.then(|| base64(&tools)),
        "t": base64(&times),
        "time_step": time_step,
        "kind": base64(&kinds),
        "limiter": base64(&limiters),
        "speed": packed((0..stretches.len()).map(|index| path.speed_mm_s(index))),
        "lines": runs,
        "error": path.peaks.iter().map(|peaks| packed(peaks.iter().copied())).collect::<Vec<_>>(),
    })
}

fn block(block: &BlockResult) -> Value {
    let um = |value: f64| round_to(value, 3);
    json!({
        "file": block.block.span.file,
        "line": block.block.span.line,
        "text": clean(&block.text),
        "t": round_to(block.time_s, 5),
        "um": um(block.max_um),
        "rms": um(block.rms_um),
        "parts": [um(block.parts_um.command), um(block.parts_um.servo), um(block.parts_um.backlash)],
        "cause": block.cause.to_string(),
        "at": block.at_mm.map(|c| round_to(c, 4)),
        "rapid": block.rapid,
    })
}

fn reversal(reversal: &ReversalResult) -> Value {
    json!({
        "axis": reversal.axis.letter().to_string(),
        "t": round_to(reversal.time_s, 5),
        "line": reversal.block.span.line,
        "file": reversal.block.span.file,
        "to": reversal.direction,
        "um": round_to(reversal.peak_um, 3),
    })
}

fn circle(circle: &FullCircle) -> Value {
    let um = |value: f64| round_to(value, 3);
    let of = |end: usize| packed(circle.radial_um.iter().map(move |part| part[end]));
    json!({
        "line": circle.line,
        "t": round_to(circle.time_s, 5),
        "axes": plane_letters(circle),
        "center": circle.center_mm.map(|c| round_to(c, 4)),
        "r": round_to(circle.radius_mm, 4),
        "ccw": circle.counterclockwise,
        "low": of(0),
        "high": of(1),
        "g": um(circle.g_um),
        "f": circle.f_um.map(um),
        "h": circle.h_um.map(um),
    })
}

/// The letters of a circle's plane.
pub(super) fn plane_letters(circle: &FullCircle) -> [&'static str; 2] {
    let [one, two, _] = circle.plane.axes();
    [one, two].map(|axis| ["X", "Y", "Z"][axis])
}

fn place(place: &Place) -> Value {
    let near = || place.near.iter();
    json!({
        "line": place.block.span.line,
        "t": round_to(place.time_s, 5),
        "from": near().next().map(|near| round_to(near.time_s, 5)),
        "error": packed(near().map(|near| near.error_um)),
    })
}

/// Estimates of the gap in the parts of a series: what was known when each of them began, in the unit
/// of the axis. `None` for a method that learns nothing.
fn gap_estimate(motor: &Motor, rad_per_unit: f64, tick_s: f64) -> Option<Value> {
    let series = &motor.series;
    motor.gaps.first()?;
    let part_s = series.ticks() as f64 * tick_s;
    let mut known = motor.gaps.iter().peekable();
    let mut gap = f64::NAN;
    let values: Vec<f32> = (0..series.len())
        .map(|part| {
            while let Some((_, next)) = known.next_if(|(time, _)| *time <= part as f64 * part_s) {
                gap = *next / rad_per_unit;
            }
            gap as f32
        })
        .collect();
    let packed = packed(values.into_iter());
    Some(json!({ "low": packed, "high": packed }))
}

fn motor(motor: &Motor, machine: &Machine, tick_s: f64) -> Value {
    let series = &motor.series;
    let name = format!(
        "{}{}",
        motor.axis.letter(),
        if motor.second { "2" } else { "" }
    );
    let mut signals: Vec<Value> = (0..SIGNALS.len())
        .map(|signal| ends(series, signal))
        .collect();
    let rad_per_unit = machine
        .drive(&name.to_ascii_lowercase())
        .map_or(1.0, |drive| drive.transmission.motor_rad_per_unit());
    signals.extend(gap_estimate(motor, rad_per_unit, tick_s));
    json!({
        "name": name,
        "unit": motor.unit.symbol(),
        "n": series.len(),
        "ticks": series.ticks(),
        "signals": signals,
    })
}

fn method(result: &MethodResult, watched: &Watched, machine: &Machine, tick_s: f64) -> Value {
    let histogram = &watched.histogram;
    let cutting = &result.cutting;
    let motors: Vec<Value> = watched
        .motors
        .iter()
        .map(|of| motor(of, machine, tick_s))
        .collect();
    let percentiles = [cutting.p50, cutting.p95, cutting.p99, cutting.p999];
    json!({
        "name": clean(&result.method),
        "max": round_to(result.cutting.max, 3),
        "within": result.within_tolerance,
        "percentiles": percentiles.map(|um| round_to(um, 3)),
        "rms": round_to(result.cutting.rms, 3),
        "worst": result.worst_blocks.iter().map(block).collect::<Vec<_>>(),
        "reversals": result.reversals.iter().map(reversal).collect::<Vec<_>>(),
        "places": watched.places.iter().map(place).collect::<Vec<_>>(),
        "circles": watched.circles.iter().map(circle).collect::<Vec<_>>(),
        "error": {
            "n": watched.error.len(),
            "ticks": watched.error.ticks(),
            "ends": ends(&watched.error, 0),
        },
        "histogram": { "width": histogram.width_um, "counts": histogram.counts },
        "motors": motors,
    })
}

/// Everything that the scripts of a page draw.
pub(super) fn data(
    run: &Run,
    machine: &Machine,
    record: &Gathered,
    main: usize,
    source: &Source,
) -> Value {
    let signals: Vec<&str> = SIGNALS.into_iter().chain([GAP_ESTIMATE]).collect();
    let methods: Vec<Value> = run
        .results
        .iter()
        .zip(&record.methods)
        .map(|(result, watched)| method(result, watched, machine, record.tick_s))
        .collect();
    json!({
        "format": 1,
        "program": clean(&run.program.name),
        "tolerance": run.tolerance_um,
        "duration": round_to(run.plan.duration_s, 4),
        "tick": record.tick_s,
        "main": main,
        "signals": signals,
        "methods": methods,
        "path": path(&record.path),
        "limits": limits(&record.limits),
        "files": run.program.files.iter().map(|name| clean(name)).collect::<Vec<_>>(),
        "lines": run.program.lines,
        "source": source.lines.iter().map(|lines| json!([lines.from, lines.text])).collect::<Vec<_>>(),
        "operations": source.operations,
    })
}

/// Lines of the program next to each other.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Lines {
    /// Number of the first.
    pub(super) from: u32,
    /// The lines, joined by line feeds.
    pub(super) text: String,
}

/// What a page has of the text of a program.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) struct Source {
    /// The whole text, or of a program that is too long its beginning and what lies around the worst
    /// blocks.
    pub(super) lines: Vec<Lines>,
    /// Lines at which operations begin, with their names: see [`heading`].
    pub(super) operations: Vec<(u32, String)>,
}

/// Most operations that are told apart. A choice: more are no help to a reader.
const MOST_OPERATIONS: usize = 200;
/// Longest name of an operation, characters.
const LONGEST_NAME: usize = 60;

/// The name of an operation that begins with a line: a comment that stands alone, as CAM systems
/// write them, or a change of tools.
fn heading(line: &str) -> Option<String> {
    let text = line.trim().trim_end_matches('%').trim();
    let comment = match text.strip_prefix(';') {
        Some(comment) => Some(comment),
        None => text
            .strip_prefix('(')
            .and_then(|rest| rest.strip_suffix(')')),
    };
    if let Some(comment) = comment.map(str::trim) {
        // One comment alone: `(a) G1 X1 (b)` is no heading.
        let alone = !comment.contains('(') && !comment.is_empty();
        return alone.then(|| comment.chars().take(LONGEST_NAME).collect());
    }
    let code = text
        .split(['(', ';'])
        .next()
        .unwrap_or_default()
        .to_ascii_uppercase();
    let word = |letter: char| {
        code.split(letter).skip(1).map(|rest| {
            let digits: String = rest
                .trim_start()
                .chars()
                .take_while(char::is_ascii_digit)
                .collect();
            digits.trim_start_matches('0').to_owned()
        })
    };
    let changes = word('M').any(|number| number == "6");
    let tool = word('T').find(|number| !number.is_empty())?;
    changes.then(|| format!("T{tool}"))
}

/// What a page has of the text of a program.
///
/// # Errors
/// The program cannot be read any more.
pub(super) fn source(program: &Program, run: &Run) -> io::Result<Source> {
    let mut reader = program.open()?;
    let whole = run.program.bytes <= MOST_SOURCE_BYTES as u64;
    // Half of the room for the beginning, the rest for the surroundings of worst blocks.
    let beginning = if whole {
        usize::MAX
    } else {
        MOST_SOURCE_BYTES / 2
    };
    let worst = |line: u32| {
        let blocks = run.results.iter().flat_map(|result| &result.worst_blocks);
        let mut blocks = blocks.filter(|block| block.block.span.file == 0);
        blocks.any(|block| block.block.span.line.abs_diff(line) <= LINES_AROUND)
    };
    let (mut chunks, mut used): (Vec<Lines>, usize) = (Vec::new(), 0);
    let mut operations: Vec<(u32, String)> = Vec::new();
    let (mut number, mut next) = (0, 1);
    while let Some(line) = short_line(&mut reader)? {
        number += 1;
        if let Some(name) = heading(&line) {
            let room = operations.len() < MOST_OPERATIONS;
            match operations.last_mut() {
                // Comments below each other are one heading, and name the tool that they are about.
                Some((last, all)) if *last + 1 == number => {
                    *last = number;
                    *all = format!("{all} / {name}")
                        .chars()
                        .take(LONGEST_NAME)
                        .collect();
                }
                _ if room => operations.push((number, name)),
                _ => {}
            }
        }
        let wanted = used + line.len() < beginning || worst(number);
        // A line takes a few more bytes in JSON.
        if !wanted || used + line.len() + 8 > MOST_SOURCE_BYTES {
            continue;
        }
        used += line.len() + 8;
        match chunks.last_mut() {
            Some(chunk) if next == number => {
                chunk.text.push('\n');
                chunk.text.push_str(&line);
            }
            _ => chunks.push(Lines {
                from: number,
                text: line,
            }),
        }
        next = number + 1;
    }
    Ok(Source {
        lines: chunks,
        operations,
    })
}

/// The next line, cut; `None` at the end. A line of any length takes little memory.
fn short_line(reader: &mut dyn BufRead) -> io::Result<Option<String>> {
    let (mut kept, mut length) = (Vec::new(), 0_usize);
    loop {
        let buffer = reader.fill_buf()?;
        if buffer.is_empty() {
            if length == 0 {
                return Ok(None);
            }
            break;
        }
        let end = buffer.iter().position(|byte| *byte == b'\n');
        let part = buffer
            .get(..end.unwrap_or(buffer.len()))
            .unwrap_or_default();
        let room = (4 * LONGEST_LINE).saturating_sub(kept.len());
        kept.extend_from_slice(part.get(..part.len().min(room)).unwrap_or_default());
        length += part.len() + usize::from(end.is_some());
        let used = part.len() + usize::from(end.is_some());
        reader.consume(used);
        if end.is_some() {
            break;
        }
    }
    let text = String::from_utf8_lossy(&kept);
    let text = text.trim_end_matches('\r');
    let mut line: String = text.chars().take(LONGEST_LINE).collect();
    if line.len() < text.len() || length > kept.len() + 2 {
        line.push('\u{2026}');
    }
    Ok(Some(clean(&line)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_of_the_standard() {
        // RFC 4648, section 10.
        for (text, expected) in [
            ("", ""),
            ("f", "Zg=="),
            ("fo", "Zm8="),
            ("foo", "Zm9v"),
            ("foob", "Zm9vYg=="),
            ("fooba", "Zm9vYmE="),
            ("foobar", "Zm9vYmFy"),
        ] {
            assert_eq!(base64(text.as_bytes()), expected);
        }
    }

    #[test]
    fn comments_alone_and_changes_of_tools_head_operations() {
        for (line, name) in [
            ("(POCKET 1, rough)", Some("POCKET 1, rough")),
            ("  ; contour ", Some("contour")),
            ("T3 M6", Some("T3")),
            ("N10 m06 t012 (drill)", Some("T12")),
            ("G1 X1 (in)", None),
            ("(a) G1 X1 (b)", None),
            ("T3", None),
            ("M66 T1", None),
            ("M30", None),
            ("()", None),
        ] {
            assert_eq!(heading(line).as_deref(), name, "{line}");
        }
    }

    #[test]
    fn texts_stay_texts() {
        let text = "<b>&\"'</script>\u{2028}";
        assert_eq!(
            embedded(&json!([text]))
                .matches(['<', '>', '&', '\u{2028}'])
                .count(),
            0
        );
        let read: Value = serde_json::from_str(&embedded(&json!([text]))).unwrap();
        assert_eq!(read, json!([text]));
        assert_eq!(escape(text).matches(['<', '>', '"', '\'']).count(), 0);
    }

    #[test]
    fn long_lines_are_cut_and_counted_as_one() {
        let text = format!("G1\r\n{}\n\nM2", "7".repeat(100_000));
        let mut reader = io::BufReader::with_capacity(16, text.as_bytes());
        let mut lines = Vec::new();
        while let Some(line) = short_line(&mut reader).unwrap() {
            lines.push(line);
        }
        assert_eq!(lines.len(), 4);
        assert_eq!(
            (lines[0].as_str(), lines[2].as_str(), lines[3].as_str()),
            ("G1", "", "M2")
        );
        assert!(
            lines[1].starts_with("777") && lines[1].ends_with('\u{2026}') && lines[1].len() < 200
        );
    }
}
