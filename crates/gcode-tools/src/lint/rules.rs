//! What a lint is: its rule, its level, its findings. The rules stand with their checks.

use super::{Check, LINTS};
use lostmotion_base::span::BlockRef;
use serde::Serialize;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

/// One lint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LintRule {
    /// Stable name, kebab case.
    pub code: &'static str,
    /// Its level unless [`Levels`] change it.
    pub level: Level,
    /// What has been found.
    pub summary: &'static str,
    /// Why it matters, and what to do.
    pub advice: &'static str,
}

pub(super) const fn rule(
    code: &'static str,
    summary: &'static str,
    advice: &'static str,
) -> LintRule {
    LintRule {
        code,
        level: Level::Warn,
        summary,
        advice,
    }
}

/// Reported by callers that know a machine.
static OUTSIDE_TRAVEL: LintRule = rule(
    "outside-travel",
    "A move leaves the travel of the machine that was named.",
    "Check the work offset, or take another machine. Only with `--machine`.",
);

/// The lints of one file.
pub(super) struct Lint {
    pub(super) rules: &'static [&'static LintRule],
    /// Makes the check that looks for them.
    pub(super) check: fn() -> Box<dyn Check>,
}

/// All lints.
pub fn all() -> impl Iterator<Item = &'static LintRule> {
    LINTS
        .iter()
        .flat_map(|lint| lint.rules)
        .copied()
        .chain([&OUTSIDE_TRAVEL])
}

/// The lint of a code.
pub fn find(code: &str) -> Option<&'static LintRule> {
    all().find(|rule| rule.code == code)
}

/// The lints' part of `docs/book/src/reference/diagnostics.md`, in Markdown.
pub fn page() -> String {
    let mut page = String::from(
        "\n## Lints\n\n`lostmotion check PART` reports these besides. `--allow CODE` switches one off, `--deny CODE` makes it an error, `--warn CODE` switches one on that \
         is off.\n\n| code | | what has been found | why it matters, what to do |\n|---|---|---|---|\n",
    );
    for rule in all() {
        // Writing to a String cannot fail.
        let _ = writeln!(
            page,
            "| `{}` | {} | {} | {} |",
            rule.code,
            rule.level.name(),
            rule.summary.replace('|', "\\|"),
            rule.advice.replace('|', "\\|")
        );
    }
    page
}

/// What is done about a lint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    /// Nothing.
    Allow,
    /// It is reported.
    Warn,
    /// It is reported as an error.
    Deny,
}

impl Level {
    /// Its name.
    pub const fn name(self) -> &'static str {
        match self {
            Level::Allow => "allow",
            Level::Warn => "warn",
            Level::Deny => "deny",
        }
    }
}

/// Levels that differ from those of the table.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Levels {
    changed: BTreeMap<String, Level>,
}

impl Levels {
    /// Sets the level of a code; a later setting replaces an earlier one. `all` stands for every
    /// lint.
    pub fn set(&mut self, code: &str, level: Level) {
        if code == "all" {
            self.changed.clear();
        }
        self.changed.insert(code.to_owned(), level);
    }

    /// The level of a lint.
    pub fn of(&self, rule: &LintRule) -> Level {
        // A level for the code itself comes before that for `all`.
        let set = self
            .changed
            .get(rule.code)
            .or_else(|| self.changed.get("all"));
        set.copied().unwrap_or(rule.level)
    }
}

/// Most findings of one lint that are kept.
const KEPT_PER_RULE: u64 = 20;

/// One finding.
#[derive(Clone, Debug, PartialEq)]
pub struct LintFinding {
    /// Its lint.
    pub rule: &'static LintRule,
    /// Warn or deny.
    pub level: Level,
    /// What has been found here, with its values.
    pub message: String,
    /// The values in the message by name.
    pub values: Vec<(&'static str, f64)>,
    /// What to do.
    pub hint: String,
    /// Where.
    pub place: BlockRef,
}

/// All findings of a program.
#[derive(Clone, Debug, Default)]
pub struct LintFindings {
    levels: Levels,
    kept: Vec<LintFinding>,
    seen: BTreeSet<(&'static str, u32, u64)>,
    counts: BTreeMap<&'static str, u64>,
    warned: u64,
    denied: u64,
}

impl LintFindings {
    /// Findings that are judged by these levels.
    pub fn new(levels: Levels) -> LintFindings {
        LintFindings {
            levels,
            ..LintFindings::default()
        }
    }

    /// Adds a finding, unless its lint is off or the same has been said of this place.
    pub fn add(
        &mut self,
        rule: &'static LintRule,
        place: BlockRef,
        message: String,
        values: &[(&'static str, f64)],
        hint: &str,
    ) {
        let level = self.levels.of(rule);
        let count = self.counts.entry(rule.code).or_default();
        if level == Level::Allow
            // Places are remembered only as long as findings are kept, so that a loop cannot fill
            // memory.
            || (*count <= KEPT_PER_RULE
                && !self
                    .seen
                    .insert((rule.code, place.span.file, place.span.start)))
        {
            return;
        }
        *count += 1;
        match level {
            Level::Deny => self.denied += 1,
            _ => self.warned += 1,
        }
        if *count <= KEPT_PER_RULE {
            self.kept.push(LintFinding {
                rule,
                level,
                message,
                values: values.to_vec(),
                hint: hint.to_owned(),
                place,
            });
        }
    }

    /// The findings that were kept, in the order of the program.
    pub fn kept(&self) -> &[LintFinding] {
        &self.kept
    }

    pub(super) fn sort(&mut self) {
        self.kept
            .sort_by_key(|finding| (finding.place.span.file, finding.place.span.start));
    }

    /// How many were counted, of lints that warn.
    pub fn warned(&self) -> u64 {
        self.warned
    }

    /// How many were counted, of lints that are denied.
    pub fn denied(&self) -> u64 {
        self.denied
    }
}
