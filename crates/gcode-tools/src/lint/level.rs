//! What is done about a lint.

use super::rules::LintRule;
use serde::Serialize;
use std::collections::BTreeMap;

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
        let set = self
            .changed
            .get(rule.code)
            .or_else(|| self.changed.get("all"));
        set.copied().unwrap_or(rule.level)
    }
}
