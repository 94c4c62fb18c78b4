//! `lostmotion machine keys`: every key of machine files.

use crate::options::Listing;
use crate::output::{Failure, indented, print};
use clap::Args;
use lostmotion::base::names::did_you_mean;
use lostmotion::sim::machine::{KeyInfo, keys as all_keys};

/// `machine keys`.
#[derive(Debug, Args)]
pub(crate) struct Keys {
    /// Only keys that begin so, for example axis.x.drive; `axis.x` stands for any axis
    prefix: Option<String>,
    /// Form of the list
    #[arg(long, value_enum, default_value_t)]
    format: Listing,
}

/// Prints the keys that begin with a prefix.
pub(super) fn keys(args: &Keys) -> Result<(), Failure> {
    let prefix = args.prefix.as_deref().unwrap_or_default();
    let all = all_keys();
    let found: Vec<&KeyInfo> = all
        .iter()
        .filter(|info| begins(&info.key, prefix))
        .collect();
    if found.is_empty() {
        let mut known: Vec<&str> = all.iter().map(|info| info.key.as_str()).collect();
        // Tables are prefixes, too, and are suggested like keys.
        known.extend(
            all.iter()
                .filter_map(|info| Some(info.key.rsplit_once('.')?.0)),
        );
        let nearest = did_you_mean(prefix, &known);
        let hint = if nearest.starts_with("did") {
            nearest
        } else {
            "`lostmotion machine keys` lists all keys".to_owned()
        };
        return Err(Failure::with_hint(
            format!("no key of machine files begins with \"{prefix}\""),
            hint,
        ));
    }
    print(&match args.format {
        Listing::Text => text(&found),
        Listing::Markdown => markdown(&found),
    })
}

/// What the doc comments of fields say, a line each: `Type.field` and the text; a test holds it to
/// the sources.
const DOCS: &str = include_str!("keys.txt");

/// What the doc comment of a key's field says.
fn about(info: &KeyInfo) -> &'static str {
    let found = DOCS
        .lines()
        .filter_map(|line| line.split_once(": "))
        .find(|(name, _)| *name == info.field);
    found.map_or("", |(_, text)| text)
}

/// Whether a key is a prefix or stands below it; any axis letter stands for x.
fn begins(key: &str, prefix: &str) -> bool {
    let mut parts = key.split('.');
    let mut asked = prefix.split('.').filter(|part| !part.is_empty()).peekable();
    let mut index = 0;
    while let Some(part) = asked.next() {
        let Some(own) = parts.next() else {
            return false;
        };
        // Any letter may stand for the x of the list: the tables of all axes are alike.
        let axis = index == 1 && key.starts_with("axis.") && part.len() == 1;
        // Only the last part may be cut short: `axis.x.dr` begins `axis.x.drive`, `ax.x` begins
        // nothing.
        let last = asked.peek().is_none();
        if !(own == part || axis || last && own.starts_with(part)) {
            return false;
        }
        index += 1;
    }
    true
}

/// What stands in a table about a key: type with unit, default, allowed values.
fn facts(info: &KeyInfo) -> [String; 3] {
    let unit = info.unit();
    let kind = if unit.is_empty() {
        info.kind.clone()
    } else {
        format!("{}, {unit}", info.kind)
    };
    [
        kind,
        info.default().unwrap_or_default(),
        info.allowed().unwrap_or_default(),
    ]
}

/// A key and its facts in a line, what it is below it.
pub(crate) fn text(found: &[&KeyInfo]) -> String {
    let mut out = String::new();
    for info in found {
        let [kind, default, allowed] = facts(info);
        out.push_str(&format!("{}  ({kind}", info.key));
        for (what, value) in [("default ", default), ("", allowed)] {
            if !value.is_empty() {
                out.push_str(&format!("; {what}{value}"));
            }
        }
        out.push_str(")\n");
        out.push_str(&indented(about(info)));
    }
    out
}

/// A Markdown table for each table of the file.
pub(crate) fn markdown(found: &[&KeyInfo]) -> String {
    let mut out = String::new();
    let mut table = None;
    for info in found {
        let (within, name) = info.key.rsplit_once('.').unwrap_or(("", &info.key));
        // Keys come in the order of their tables: a new heading where the table changes.
        if table != Some(within) {
            let title = if within.is_empty() {
                "At the top of the file".to_owned()
            } else {
                format!("`[{within}]`")
            };
            let lead = if table.is_some() { "\n" } else { "" };
            out.push_str(&format!(
                "{lead}### {title}\n\n| key | value | default | allowed | |\n|--|--|--|--|--|\n"
            ));
            table = Some(within);
        }
        let [kind, default, allowed] = facts(info);
        // A bare bar would end the cell.
        let about = about(info).replace('|', "\\|");
        out.push_str(&format!(
            "| `{name}` | {kind} | {default} | {allowed} | {about} |\n"
        ));
    }
    out
}
