//! An INI file as LinuxCNC reads it: sections, `KEY = VALUE`, lines that a backslash continues, and
//! files that `#INCLUDE` puts in its line's place. See
//! <https://linuxcnc.org/docs/stable/html/config/ini-config.html>.

use super::draft::{Draft, Fate};
use super::{ImportOptions, problem};
use crate::machine::Problem;

/// Deepest nesting of included files. A choice: LinuxCNC's own samples nest three deep, and a file
/// that includes itself ends here.
const DEEPEST: usize = 16;

/// A line `KEY = VALUE`.
pub(super) struct Entry {
    /// Its line in the file that is imported: of the include, where it stands in another file.
    pub(super) line: usize,
    pub(super) section: String,
    pub(super) key: String,
    pub(super) value: String,
    /// The pin on which HAL sets it, where that is not the INI file's own value.
    pub(super) pin: Option<String>,
}

impl Entry {
    /// The text of the file that it names; a missing one is reported.
    pub(super) fn text(&self, draft: &mut Draft, options: &ImportOptions<'_>) -> Option<String> {
        let file = self.value.split_whitespace().next()?;
        let why = match options.files.text(file) {
            Ok(text) if text.len() <= options.max_bytes => return Some(text),
            Ok(text) => format!("not read: {} bytes", text.len()),
            Err(why) => format!("not read ({why})"),
        };
        draft.row(self.name(), file, Fate::Ignored, why);
        None
    }

    /// The value before a comment. LinuxCNC keeps comments behind values, and reads a number in front of one
    /// (`sscanf("%lf")`).
    pub(super) fn plain(&self) -> &str {
        self.value
            .split(['#', ';'])
            .next()
            .unwrap_or_default()
            .trim()
    }

    /// `[SECTION] KEY`.
    pub(super) fn name(&self) -> String {
        match &self.pin {
            Some(pin) => format!("[HAL] setp {pin}"),
            None => format!("[{}] {}", self.section, self.key),
        }
    }
}

/// What became of an included file.
pub(super) struct Included {
    pub(super) file: String,
    /// Why it was not read; `None` if it was.
    pub(super) missing: Option<String>,
}

/// A file and all that it includes.
#[derive(Default)]
pub(super) struct Ini {
    pub(super) entries: Vec<Entry>,
    pub(super) included: Vec<Included>,
    /// Lines that are neither a section nor `KEY = VALUE`: LinuxCNC passes over them.
    pub(super) passed: Vec<(usize, String)>,
    section: String,
    bytes: usize,
}

/// The place of a line: in the imported file, and in which other file it stands, if it does.
#[derive(Clone, Copy)]
struct LinePlace<'a> {
    line: usize,
    within: Option<(&'a str, usize)>,
}

impl LinePlace<'_> {
    fn problem(self, text: &str, message: &str, hint: &str) -> Problem {
        let message = match self.within {
            Some((file, line)) => format!("{message} (line {line} of {file})"),
            None => message.to_owned(),
        };
        problem(self.line, text, message, hint)
    }
}

/// Reads a file and those that it includes.
pub(super) fn read(text: &str, options: &ImportOptions<'_>) -> Result<Ini, Vec<Problem>> {
    let (mut ini, mut problems) = (Ini::default(), Vec::new());
    ini.file(text, None, options, 0, &mut problems);
    if problems.is_empty() {
        Ok(ini)
    } else {
        Err(problems)
    }
}

impl Ini {
    /// The first value of a key in one of these sections.
    pub(super) fn first(&self, sections: &[&str], key: &str) -> Option<&Entry> {
        let mut entries = self.entries.iter();
        entries.find(|entry| sections.contains(&entry.section.as_str()) && entry.key == key)
    }

    /// Puts another value in the place of a joint's or an axis' own; gives those that no longer count.
    pub(super) fn replace(&mut self, entry: Entry) -> Vec<Entry> {
        let same = |own: &mut Entry| own.section == entry.section && own.key == entry.key;
        let before = self.entries.extract_if(.., same).collect();
        self.entries.push(entry);
        before
    }

    /// The entry for which `[SECTION]KEY` or `[SECTION](KEY)` stands, as in HAL files.
    pub(super) fn named(&self, text: &str) -> Option<&Entry> {
        let (section, key) = text.strip_prefix('[')?.split_once(']')?;
        self.first(&[section], key.trim_matches(['(', ')']))
    }

    /// A text in which `[SECTION]KEY` or `[SECTION](KEY)` stands for its value, as in HAL files.
    pub(super) fn value(&self, text: &str) -> String {
        self.named(text)
            .map_or_else(|| text.to_owned(), |entry| entry.value.clone())
    }

    fn file(
        &mut self,
        text: &str,
        included: Option<(&str, usize)>,
        options: &ImportOptions<'_>,
        depth: usize,
        problems: &mut Vec<Problem>,
    ) {
        let mut lines = text.lines().enumerate();
        while let Some((index, first)) = lines.next() {
            // Behind a backslash at its end a line goes on in the next one.
            let mut whole = first.trim().to_owned();
            while let Some(rest) = whole.strip_suffix('\\') {
                let more = lines.next().map_or("", |(_, line)| line.trim());
                whole = format!("{} {more}", rest.trim_end());
            }
            let place = match included {
                Some((file, line)) => LinePlace {
                    line,
                    within: Some((file, index + 1)),
                },
                None => LinePlace {
                    line: index + 1,
                    within: None,
                },
            };
            match include(&whole) {
                Some(file) => self.include(file, place, options, depth, problems),
                None => self.line(&whole, place, problems),
            }
        }
    }

    fn include(
        &mut self,
        file: &str,
        place: LinePlace<'_>,
        options: &ImportOptions<'_>,
        depth: usize,
        problems: &mut Vec<Problem>,
    ) {
        if depth == DEEPEST {
            let message = format!("files include each other more than {DEEPEST} deep");
            let hint = "does a file include itself?";
            problems.push(place.problem(file, &message, hint));
            return;
        }
        let found = options.files.text(file);
        self.included.push(Included {
            file: file.to_owned(),
            missing: found.as_ref().err().cloned(),
        });
        let Ok(text) = found else { return };
        self.bytes = self.bytes.saturating_add(text.len());
        if self.bytes > options.max_bytes {
            let message = format!(
                "included files have more than {} bytes: no description of a machine",
                options.max_bytes
            );
            problems.push(place.problem(file, &message, ""));
            return;
        }
        // Told once: a fault in what it includes itself would be told for every level.
        if problems.is_empty() {
            self.file(
                &text,
                Some((file, place.line)),
                options,
                depth + 1,
                problems,
            );
        }
    }

    fn line(&mut self, line: &str, place: LinePlace<'_>, problems: &mut Vec<Problem>) {
        if line.is_empty() || line.starts_with(['#', ';']) {
            return;
        }
        if let Some(name) = line.strip_prefix('[') {
            match name.split_once(']') {
                Some((name, _)) => name.trim().clone_into(&mut self.section),
                None => {
                    problems.push(place.problem(
                        line,
                        "the section's name is not closed",
                        "write [TRAJ]",
                    ));
                }
            }
        } else if let Some((key, value)) = line.split_once('=') {
            self.entries.push(Entry {
                line: place.line,
                section: self.section.clone(),
                key: key.trim().to_owned(),
                value: value.trim().to_owned(),
                pin: None,
            });
        } else {
            self.passed.push((place.line, line.to_owned()));
        }
    }
}

/// The file that a line includes, if it is such a line.
fn include(line: &str) -> Option<&str> {
    let rest = ["#INCLUDE", ".include"]
        .iter()
        .find_map(|word| line.strip_prefix(word))?;
    Some(rest.trim()).filter(|file| !file.is_empty())
}
