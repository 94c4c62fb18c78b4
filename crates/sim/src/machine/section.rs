//! Reading one part of a file into a type, with all that is wrong with it rather than the first
//! thing.
//!
//! serde stops at its first error. So the part is read again and again, each time with the error
//! found last mended in a copy: an unknown key taken out, a stand-in put where a value is missing
//! or of the wrong type. What was read from a mended copy is thrown away.

use super::document::{Document, path_of_span};
use super::problem::{MISSING, Problem, UNKNOWN_KEY};
use lostmotion_base::names::did_you_mean;
use lostmotion_base::text::{legible, shortened};
use serde::de::DeserializeOwned;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Error, ValueDeserializer};

/// The most errors looked for in one part. A choice: a reader mends fewer at a time, and each costs a
/// further reading.
const MOST_ERRORS: usize = 100;

/// Values put where one is missing or of the wrong type, tried in this order.
const STAND_IN_TEXTS: [&str; 5] = ["1.0", "1", "\"\"", "true", "{}"];

/// Marks a stand-in, so that an error in it is not reported: no text is that long.
const STAND_IN_SPAN: Range<usize> = usize::MAX - 1..usize::MAX;

/// Reads the part that stands under `key` (empty for the whole file). `also` are keys known there
/// that the type does not know.
pub(super) fn read<T: DeserializeOwned>(
    document: &Document<'_>,
    key: &str,
    part: &Spanned<DeValue<'_>>,
    also: &[&str],
    problems: &mut Vec<Problem>,
) -> Option<T> {
    let mut copy = part.clone();
    let before = problems.len();
    let mut stand_in = 0;
    for _ in 0..MOST_ERRORS {
        let error = match T::deserialize(ValueDeserializer::from(copy.clone())) {
            Ok(value) => return (problems.len() == before).then_some(value),
            Err(error) => error,
        };
        let span = error.span().unwrap_or_else(|| part.span());
        // The error lies in a stand-in: try the next kind of value in its place, and report
        // nothing.
        if span == STAND_IN_SPAN {
            stand_in += 1;
        } else {
            let problem = describe(document, key, part, &span, error.message(), also);
            // The same error again: mending did not help, and would not the next time.
            if problems.iter().skip(before).any(|old| *old == problem) {
                return None;
            }
            problems.push(problem);
            stand_in = 0;
        }
        if !mend(&mut copy, &error, &span, stand_in) {
            return None;
        }
    }
    None
}

/// The words in backquotes of one of serde's messages.
fn quoted(message: &str) -> Vec<&str> {
    message.split('`').skip(1).step_by(2).collect()
}

fn describe(
    document: &Document<'_>,
    key: &str,
    part: &Spanned<DeValue<'_>>,
    span: &Range<usize>,
    message: &str,
    also: &[&str],
) -> Problem {
    let below = path_of_span(part, span).unwrap_or_default();
    let path = join(key, &below);
    let words = quoted(message);
    if let (true, Some((unknown, known))) = (message.starts_with("unknown"), words.split_first()) {
        let mut known = known.to_vec();
        known.extend_from_slice(also);
        // Mixing up distance and angle is no misspelling: the nearest name would mislead.
        if let Some(hint) = gap_hint(unknown, &known) {
            return document.problem_at(span.start, path, UNKNOWN_KEY.to_owned(), hint);
        }
        let what = if message.starts_with("unknown variant") {
            format!("`{unknown}` is not known")
        } else {
            UNKNOWN_KEY.to_owned()
        };
        return document.problem_at(span.start, path, what, did_you_mean(unknown, &known));
    }
    if let (true, Some(missing)) = (message.starts_with("missing field"), words.first()) {
        let path = join(&path, missing);
        return document.problem_at(
            span.start,
            path,
            MISSING.to_owned(),
            format!("add `{missing}` here"),
        );
    }
    if message == OVERFLOWED {
        return document.problem_at(
            span.start,
            path,
            "the whole number is larger than a file can hold".to_owned(),
            "write it with a decimal point or an exponent, if it is meant".to_owned(),
        );
    }
    let said = message
        .strip_prefix("invalid type: ")
        .or_else(|| message.strip_prefix("invalid value: "))
        .unwrap_or(message);
    // serde speaks of Rust types; the file's author knows tables, lists and numbers.
    // Where something else was expected the rest is a value, of any length; else it is a sentence.
    let (found, expected) = match said.split_once(", expected ") {
        Some(("map", expected)) => ("a table".to_owned(), expected),
        Some((value, expected)) => (shortened(&legible(value), SHOWN_CHARACTERS), expected),
        None => (said.to_owned(), ""),
    };
    let expected = match expected {
        "f64" => "a number",
        "u32" => "a whole number, 0 or above",
        "a sequence" => "a list",
        expected if expected.starts_with("struct ") || expected.starts_with("enum ") => "a table",
        expected => expected,
    };
    let said = if expected.is_empty() {
        found
    } else {
        format!("found {found}, expected {expected}")
    };
    document.problem_at(span.start, path, said, String::new())
}

/// What the reader of TOML says of a whole number beyond 64 bits.
const OVERFLOWED: &str = "integer number overflowed";

/// Most characters of a value that a message shows. A choice: a line of text has room for the rest.
const SHOWN_CHARACTERS: usize = 60;

/// What to say of a gap in an angle where it is a distance, or the other way round.
fn gap_hint(unknown: &str, known: &[&str]) -> Option<String> {
    const ANGLES: [&str; 3] = ["gap_arcsec", "gap_mdeg", "gap_deg"];
    if ANGLES.contains(&unknown) && known.contains(&"gap_um") {
        return Some("the gap of a linear axis is a distance: `gap_um`".to_owned());
    }
    (unknown == "gap_um" && known.contains(&"gap_mdeg")).then(|| {
        format!(
            "the gap of a rotary axis is an angle: one of {}",
            ANGLES.map(|key| format!("`{key}`")).join(", ")
        )
    })
}

/// A dotted key from the key of a table and one below it.
pub(super) fn join(table: &str, key: &str) -> String {
    match (table, key) {
        ("", key) => key.to_owned(),
        (table, "") => table.to_owned(),
        (table, key) if key.starts_with('[') => format!("{table}{key}"),
        (table, key) => format!("{table}.{key}"),
    }
}

/// Mends the copy so that the next error can be found. False if that cannot be done.
fn mend(
    copy: &mut Spanned<DeValue<'_>>,
    error: &Error,
    span: &Range<usize>,
    stand_in: usize,
) -> bool {
    let Some(replacement) = STAND_IN_TEXTS
        .get(stand_in)
        .and_then(|text| DeValue::parse(text).ok())
    else {
        return false;
    };
    let replacement = Spanned::new(STAND_IN_SPAN, replacement.into_inner());
    let message = error.message();
    // A key too many is taken out; all other errors get a stand-in.
    if *span != STAND_IN_SPAN && message.starts_with("unknown field") {
        return remove_key(copy, span);
    }
    match (
        message.starts_with("missing field"),
        quoted(message).first(),
    ) {
        (true, Some(missing)) => insert(copy, span, missing, &replacement),
        _ => replace(copy, span, &replacement),
    }
}

fn children<'t, 'i>(value: &'t mut Spanned<DeValue<'i>>) -> Vec<&'t mut Spanned<DeValue<'i>>> {
    match value.get_mut() {
        DeValue::Table(table) => table.iter_mut().map(|(_, inner)| inner).collect(),
        DeValue::Array(array) => array.iter_mut().collect(),
        _ => Vec::new(),
    }
}

fn remove_key(value: &mut Spanned<DeValue<'_>>, span: &Range<usize>) -> bool {
    if let DeValue::Table(table) = value.get_mut() {
        let found = table
            .keys()
            .find(|key| key.span() == *span)
            .map(|key| key.get_ref().to_string());
        if let Some(name) = found {
            return table.remove(name.as_str()).is_some();
        }
    }
    children(value)
        .into_iter()
        .any(|inner| remove_key(inner, span))
}

fn replace<'i>(
    value: &mut Spanned<DeValue<'i>>,
    span: &Range<usize>,
    by: &Spanned<DeValue<'i>>,
) -> bool {
    for inner in children(value) {
        // The innermost value of that span: a table and its only value may share one.
        let inside = replace(inner, span, by);
        if inside {
            return true;
        }
        if inner.span() == *span {
            *inner = by.clone();
            return true;
        }
    }
    false
}

fn insert<'i>(
    value: &mut Spanned<DeValue<'i>>,
    span: &Range<usize>,
    key: &str,
    new: &Spanned<DeValue<'i>>,
) -> bool {
    let here = value.span() == *span;
    if let (true, DeValue::Table(table)) = (here, value.get_mut()) {
        put(table, key, new.clone());
        return true;
    }
    children(value)
        .into_iter()
        .any(|inner| insert(inner, span, key, new))
}

fn put<'i>(table: &mut DeTable<'i>, key: &str, value: Spanned<DeValue<'i>>) {
    table.insert(Spanned::new(STAND_IN_SPAN, key.to_owned().into()), value);
}
