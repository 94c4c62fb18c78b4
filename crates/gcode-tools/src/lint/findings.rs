//! What the lints have found: a bounded number is kept, all are counted.

use super::level::{Level, Levels};
use super::rules::LintRule;
use lostmotion_base::span::BlockRef;
use std::collections::{BTreeMap, BTreeSet};

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
