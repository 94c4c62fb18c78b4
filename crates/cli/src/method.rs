//! `lostmotion method`: the compensation methods.

use crate::machine::keys;
use crate::options::{Listing, methods};
use crate::output::{DONE, Failure, print, stdout_columns};
use clap::{Args, Subcommand};
use lostmotion::methods::MethodId;
use lostmotion::report::text::{Align, Table, knowledge};
use lostmotion::sim::machine::{KeyInfo, keys as all_keys};

/// `method`.
#[derive(Debug, Subcommand)]
pub(crate) enum MethodCommand {
    /// List the compensation methods with what each may know
    List,
    /// Print what a method does: its law, signals, settings with defaults and units, where it
    /// fails, and its source
    Show(ShowMethod),
}

/// `method show`.
#[derive(Debug, Args)]
pub(crate) struct ShowMethod {
    /// A name from `method list`; all methods, if left out
    #[arg(value_parser = methods())]
    name: Option<String>,
    /// Form of the description
    #[arg(long, value_enum, default_value_t)]
    format: Listing,
}

/// Runs the command asked for.
pub(crate) fn run(command: &MethodCommand) -> Result<u8, Failure> {
    match command {
        MethodCommand::List => print(&list())?,
        MethodCommand::Show(args) => {
            let named = |name: &str| args.name.as_deref().is_none_or(|asked| asked == name);
            let all = MethodId::all();
            let texts: Vec<String> = all
                .filter(|method| named(method.name()))
                .map(|method| show(method, args.format))
                .collect();
            print(&texts.join("\n"))?;
        }
    }
    Ok(DONE)
}

fn list() -> String {
    let mut table = Table::new(&[
        ("method", Align::Left),
        ("needs", Align::Left),
        ("", Align::Left),
    ])
    .folded();
    for method in MethodId::all() {
        table.row([
            method.name().into(),
            knowledge(method.info().knows).into(),
            method.info().summary.into(),
        ]);
    }
    table.render_within(stdout_columns())
}

/// What the head of each method's file says, behind a line `=== NAME`; a test holds it to the
/// files.
const HEADS: &str = include_str!("methods.txt");

/// Law, signals, tunables, where it fails and source of a method, as its file says them.
fn law(name: &str) -> &'static str {
    let named = |text: &&str| text.lines().next() == Some(name);
    HEADS
        .split("=== ")
        .find(named)
        .and_then(|text| text.split_once('\n'))
        .map_or("", |(_, head)| head.trim_end())
}

/// Keys of a method's settings.
fn settings(method: MethodId) -> Vec<KeyInfo> {
    let Some(table) = method.settings_key() else {
        return Vec::new();
    };
    // Settings stand in a table of the method's own, the same for every axis.
    let prefix = format!("axis.x.compensation.{table}.");
    let mut keys = all_keys();
    keys.retain(|info| info.key.starts_with(&prefix));
    keys
}

/// Everything about a method.
fn show(method: MethodId, form: Listing) -> String {
    let (name, info) = (method.name(), method.info());
    let keys = settings(method);
    let keys: Vec<&KeyInfo> = keys.iter().collect();
    // `-` stands for nothing in a table, but not in a sentence.
    let needs = match knowledge(info.knows) {
        nothing if nothing == "-" => "nothing beyond the motor's encoder and current".to_owned(),
        known => known,
    };
    match form {
        Listing::Text => {
            let mut out = format!(
                "{name}: {}\nneeds: {needs}\nsource: {}\n\n{}\n",
                info.summary,
                info.source,
                law(name)
            );
            if keys.is_empty() {
                out.push_str("\nNo settings.\n");
            } else {
                out.push_str("\nsettings\n");
                out.push_str(&keys::text(&keys));
            }
            out
        }
        Listing::Markdown => {
            let mut out = format!(
                "## {name}\n\n{}. Needs: {needs}. Source: {}.\n\n{}\n",
                info.summary,
                info.source,
                law(name)
            );
            if keys.is_empty() {
                out.push_str("\nNo settings.\n");
            } else {
                out.push('\n');
                out.push_str(&keys::markdown(&keys));
            }
            out
        }
    }
}
