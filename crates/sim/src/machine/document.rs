//! A TOML text with the place of every key.

use super::problem::Problem;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Longest machine file, bytes. The embedded ones have some 20 kB; a larger text is something else,
/// and listing its errors would take long.
const MAX_BYTES: usize = 256 * 1024;
/// The most syntax errors listed. A choice: later ones mostly follow from earlier ones.
const MAX_SYNTAX_ERRORS: usize = 20;

/// A parsed text.
pub(super) struct Document<'a> {
    text: &'a str,
    /// The whole file as a table.
    pub(super) root: DeTable<'a>,
    /// Where values stand that do not come from the file, and what names them in messages.
    given: Vec<(Range<usize>, String)>,
}

impl<'a> Document<'a> {
    /// Parses a text, and puts values in place of its own.
    ///
    /// # Errors
    /// All syntax errors; a text that is too long; a change that is no key with a value.
    pub(super) fn parse(changed: &'a ChangedText) -> Result<Document<'a>, Vec<Problem>> {
        let mut document = Document::parse_file(changed.file())?;
        // From here on bytes are counted in the text with the changes behind it: each value has one
        // place.
        document.text = &changed.text;
        let mut problems = Vec::new();
        // What is said of a gantry's second end alone comes last: until then it is like the first.
        let of_second =
            |change: &&PlacedChange| changed.text[change.key.clone()].starts_with(SECOND_END);
        let (last, first): (Vec<_>, Vec<_>) = changed.changes.iter().partition(of_second);
        for change in first.into_iter().chain(last) {
            if of_second(&change) {
                own_second_end(&mut document.root, change);
            }
            document
                .given
                .push((change.key.start..change.value.end, change.name.clone()));
            if let Err((message, hint)) = put(&mut document.root, &changed.text, change) {
                let key = changed.text[change.key.clone()].to_owned();
                problems.push(document.problem_at(change.key.start, key, message, hint));
            }
        }
        if problems.is_empty() {
            Ok(document)
        } else {
            Err(problems)
        }
    }

    fn parse_file(text: &'a str) -> Result<Document<'a>, Vec<Problem>> {
        if text.len() > MAX_BYTES {
            let message = format!(
                "has {} bytes; a machine file has at most {MAX_BYTES}",
                text.len()
            );
            let hint = "is it a machine file? `lostmotion machine show vmc3` prints one".to_owned();
            return Err(vec![Problem {
                line: 1,
                column: 1,
                key: String::new(),
                message,
                hint,
                option: None,
            }]);
        }
        // The parser goes on behind an error, so that all of them are told at once.
        let (root, errors) = DeTable::parse_recoverable(text);
        let document = Document {
            text,
            root: root.into_inner(),
            given: Vec::new(),
        };
        if errors.is_empty() {
            return Ok(document);
        }
        let problem = |error: &toml::de::Error| {
            let start = error.span().map_or(0, |span| span.start);
            document.problem_at(
                start,
                String::new(),
                error.message().replace('\n', "; "),
                String::new(),
            )
        };
        Err(errors.iter().take(MAX_SYNTAX_ERRORS).map(problem).collect())
    }

    /// A problem at a byte of the text.
    pub(super) fn problem_at(
        &self,
        byte: usize,
        key: String,
        message: String,
        hint: String,
    ) -> Problem {
        let (line, column) = self.place(byte);
        // A byte of a change belongs to the option that brought it, not to a line of the file.
        let given = self.given.iter().find(|(place, _)| place.contains(&byte));
        Problem {
            line,
            column,
            key,
            message,
            hint,
            option: given.map(|(_, name)| name.clone()),
        }
    }

    /// A problem with the value of a dotted key; where the key is not in the text, its nearest
    /// table is pointed at.
    pub(super) fn problem(
        &self,
        key: &str,
        message: impl Into<String>,
        hint: impl Into<String>,
    ) -> Problem {
        self.problem_at(
            self.byte_of(key),
            key.to_owned(),
            message.into(),
            hint.into(),
        )
    }

    /// Line and column in bytes, both from 1, of a byte.
    fn place(&self, byte: usize) -> (u32, u32) {
        let before = self
            .text
            .as_bytes()
            .get(..byte)
            .unwrap_or(self.text.as_bytes());
        let line = before.iter().filter(|b| **b == b'\n').count() + 1;
        let column = before.iter().rev().take_while(|b| **b != b'\n').count() + 1;
        (
            u32::try_from(line).unwrap_or(u32::MAX),
            u32::try_from(column).unwrap_or(u32::MAX),
        )
    }

    /// Where a dotted key stands, or the longest part of it that is there.
    fn byte_of(&self, key: &str) -> usize {
        let mut table = Some(&self.root);
        let mut byte = 0;
        for part in key.split('.') {
            let name = part.split('[').next().unwrap_or(part);
            // What is not in the text is pointed at by the nearest table that is.
            let Some((found, value)) = table.and_then(|table| table.get_key_value(name)) else {
                break;
            };
            byte = found.span().start;
            let element = match value.get_ref() {
                DeValue::Array(array) => index_of(part)
                    .and_then(|index| array.get(index))
                    .inspect(|element| byte = element.span().start),
                _ => Some(value),
            };
            table = element.and_then(|element| element.get_ref().as_table());
        }
        byte
    }
}

/// A value in place of a machine file's own, as the command's `--set KEY=VALUE` gives it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// Dotted key: `axis.x.drive.position_gain_per_s`, `tool[0].length_mm`. Tables that are
    /// missing are made.
    pub key: String,
    /// The value in TOML; text may stand without quotes.
    pub value: String,
    /// What messages call it in place of the file, line and column:
    /// `--set axis.x.drive.position_gain_per_s=30`.
    pub name: String,
}

/// The text of a file with changes written behind it, so that every value has a place in one text.
pub(super) struct ChangedText {
    text: String,
    file_bytes: usize,
    changes: Vec<PlacedChange>,
}

/// Where a change's key and value stand in the text.
struct PlacedChange {
    key: Range<usize>,
    value: Range<usize>,
    name: String,
}

impl ChangedText {
    /// Puts changes behind a text.
    pub(super) fn new(file: &str, changes: &[Change]) -> ChangedText {
        let mut text = file.to_owned();
        let place = |change: &Change| {
            // Behind the file, so that the places of its own values stay as they are.
            text.push('\n');
            let key = text.len()..text.len() + change.key.len();
            text.push_str(&change.key);
            text.push('=');
            let value = text.len()..text.len() + change.value.len();
            text.push_str(&change.value);
            PlacedChange {
                key,
                value,
                name: change.name.clone(),
            }
        };
        let changes = changes.iter().map(place).collect();
        ChangedText {
            text,
            file_bytes: file.len(),
            changes,
        }
    }

    fn file(&self) -> &str {
        &self.text[..self.file_bytes]
    }
}

/// Most tables in a key, twice as many as the longest has. A choice.
const MOST_KEY_PARTS: usize = 16;

/// Tables of a gantry's second end.
const SECOND_END: &str = "gantry.second.";

/// Gives a gantry's second end tables of its own, if it has none: those of the first end, with the
/// gap that is told of the second. What is missing or of another kind is told where the file is read.
fn own_second_end(root: &mut DeTable<'_>, change: &PlacedChange) {
    let Some(like_first) = root
        .get("gantry")
        .and_then(|gantry| gantry.get_ref().as_table()?.get("axis"))
        .and_then(|axis| {
            root.get("axis")?
                .get_ref()
                .as_table()?
                .get(axis.get_ref().as_str()?)
        })
        .and_then(|axis| axis.get_ref().as_table())
        .cloned()
    else {
        return;
    };
    let Some(gantry) = table_in(root, "gantry") else {
        return;
    };
    if gantry.contains_key("second") {
        return;
    }
    let mut second = like_first;
    second.remove("limits");
    if let Some(gap) = gantry.get("second_gap_um").cloned() {
        let Some(slide) = table_in(&mut second, "load").and_then(|load| table_in(load, "slide"))
        else {
            return;
        };
        slide.remove("gap_um");
        slide.insert(Spanned::new(gap.span(), "gap_um".into()), gap);
        gantry.remove("second_gap_um");
    }
    let second = Spanned::new(change.key.clone(), DeValue::Table(second));
    gantry.insert(Spanned::new(change.key.clone(), "second".into()), second);
}

/// A table in a table.
fn table_in<'t, 'a>(table: &'t mut DeTable<'a>, name: &str) -> Option<&'t mut DeTable<'a>> {
    match table.get_mut(name)?.get_mut() {
        DeValue::Table(inner) => Some(inner),
        _ => None,
    }
}

/// Puts a change into a table; why it cannot be, with a hint.
fn put<'a>(
    root: &mut DeTable<'a>,
    text: &'a str,
    change: &PlacedChange,
) -> Result<(), (String, String)> {
    let key = &text[change.key.clone()];
    let hint = "a key is like axis.x.drive.position_gain_per_s or tool[0].length_mm";
    // A key of thousands of tables would be read with as many calls within each other.
    if key.split('.').count() > MOST_KEY_PARTS {
        return Err(("is not a key".to_owned(), hint.to_owned()));
    }
    let value = value_of(&text[change.value.clone()], change.value.start)?;
    let mut table = root;
    let mut parts = key.split('.').peekable();
    while let Some(part) = parts.next() {
        let name = part.split('[').next().unwrap_or(part);
        if name.is_empty() || name.len() != name.trim().len() {
            return Err(("is not a key".to_owned(), hint.to_owned()));
        }
        let last = parts.peek().is_none();
        let at = || Spanned::new(change.key.clone(), name.into());
        if last && name == part {
            // a map keeps the key that it has, and with it its place in the file
            table.remove(name);
            table.insert(at(), value);
            return Ok(());
        }
        // Tables that are missing on the way are made.
        let nothing = DeValue::Table(DeTable::new());
        let entry = table
            .entry(at())
            .or_insert_with(|| Spanned::new(change.key.clone(), nothing));
        let inner = if name == part {
            Some(entry)
        } else {
            element(entry, part)
        };
        let Some(inner) = inner else {
            return Err((format!("there is no `{part}`"), String::new()));
        };
        if last {
            *inner = value;
            return Ok(());
        }
        let DeValue::Table(next) = inner.get_mut() else {
            return Err((format!("`{part}` is not a table"), String::new()));
        };
        table = next;
    }
    Ok(())
}

/// `tool[2]` in the list `tool`.
fn element<'t, 'a>(
    list: &'t mut Spanned<DeValue<'a>>,
    part: &str,
) -> Option<&'t mut Spanned<DeValue<'a>>> {
    match list.get_mut() {
        DeValue::Array(array) => array.get_mut(index_of(part)?),
        _ => None,
    }
}

/// The value of a text that begins at a byte; what is not TOML but begins with a letter is text
/// without quotes.
fn value_of(text: &str, at: usize) -> Result<Spanned<DeValue<'_>>, (String, String)> {
    match DeValue::parse(text) {
        Ok(value) => Ok(moved(value, at)),
        Err(_) if text.trim_start().starts_with(|c: char| c.is_alphabetic()) => {
            let string = DeValue::String(text.trim().into());
            Ok(Spanned::new(at..at + text.len(), string))
        }
        Err(error) => {
            let message = format!("`{text}` is not a value: {}", error.message());
            let hint = "for example: 30, 1e-3, true, [0.0, 10.0], \"text\", { um = 10.0 }";
            Err((message.replace('\n', "; "), hint.to_owned()))
        }
    }
}

/// A value whose places lie further on.
fn moved(value: Spanned<DeValue<'_>>, by: usize) -> Spanned<DeValue<'_>> {
    let further = |span: Range<usize>| span.start + by..span.end + by;
    let span = further(value.span());
    let inner = match value.into_inner() {
        DeValue::Array(array) => {
            DeValue::Array(array.into_iter().map(|inner| moved(inner, by)).collect())
        }
        DeValue::Table(table) => DeValue::Table(
            table
                .into_iter()
                .map(|(key, inner)| {
                    let place = further(key.span());
                    (Spanned::new(place, key.into_inner()), moved(inner, by))
                })
                .collect(),
        ),
        other => other,
    };
    Spanned::new(span, inner)
}

/// The index in `tool[2]`.
fn index_of(part: &str) -> Option<usize> {
    part.split_once('[')?.1.strip_suffix(']')?.parse().ok()
}

/// Dotted path below `value` of the key or value that has a span.
pub(super) fn path_of_span(value: &Spanned<DeValue<'_>>, span: &Range<usize>) -> Option<String> {
    match value.get_ref() {
        DeValue::Table(table) => table.iter().find_map(|(key, inner)| {
            let name = key.get_ref();
            // An unknown key is reported by the key's place, a wrong value by the value's.
            if key.span() == *span || inner.span() == *span {
                return Some(name.to_string());
            }
            path_of_span(inner, span).map(|rest| {
                format!(
                    "{name}{}{rest}",
                    if rest.starts_with('[') { "" } else { "." }
                )
            })
        }),
        DeValue::Array(array) => array.iter().enumerate().find_map(|(index, inner)| {
            if inner.span() == *span {
                return Some(format!("[{index}]"));
            }
            path_of_span(inner, span).map(|rest| format!("[{index}].{rest}"))
        }),
        _ => None,
    }
}

/// Dotted keys of all numbers that are not finite, with what stands there.
pub(super) fn not_finite(table: &DeTable<'_>) -> Vec<(String, String)> {
    let mut found = Vec::new();
    for (key, value) in table.iter() {
        walk(key.get_ref().to_string(), value.get_ref(), &mut found);
    }
    found
}

fn walk(path: String, value: &DeValue<'_>, found: &mut Vec<(String, String)>) {
    match value {
        DeValue::Table(table) => table.iter().for_each(|(key, inner)| {
            walk(format!("{path}.{}", key.get_ref()), inner.get_ref(), found);
        }),
        DeValue::Array(array) => array
            .iter()
            .enumerate()
            .for_each(|(i, inner)| walk(format!("{path}[{i}]"), inner.get_ref(), found)),
        // TOML has inf and nan; no measure of a machine may be one.
        DeValue::Float(float) if !float.as_str().parse::<f64>().is_ok_and(f64::is_finite) => {
            found.push((path, float.as_str().to_owned()));
        }
        _ => {}
    }
}
