//! `lostmotion completions`, `lostmotion man` and `lostmotion schema`: the command line for shells
//! and for `man`, its documents for other programs.

use crate::options::Names;
use crate::output::{self, DONE, Failure};
use clap::{Args, Command, ValueHint};
use clap_complete::Shell;
use clap_mangen::Man;
use lostmotion::report::WriteError;
use lostmotion::report::schema::{Document, UnknownDocument, schema as schema_of};
use std::io::{self, Write};
use std::path::PathBuf;

/// `completions`.
#[derive(Debug, Args)]
pub(crate) struct Completions {
    /// Shell that the completions are for
    #[arg(value_enum)]
    shell: Shell,
}

/// `man`.
#[derive(Debug, Args)]
pub(crate) struct ManPages {
    /// Command whose page is printed, for example machine check; the program's, if left out
    #[arg(conflicts_with = "out")]
    command: Vec<String>,
    /// Write the pages of all commands into this folder; made if it does not exist
    #[arg(long, short, value_name = "DIR", value_hint = ValueHint::DirPath)]
    out: Option<PathBuf>,
}

/// `schema`.
#[derive(Debug, Args)]
pub(crate) struct Schema {
    /// Document that the schema is of; a list of them, if left out
    #[arg(value_name = "NAME", value_parser = documents())]
    document: Option<String>,
}

/// Names of documents with a schema.
fn documents() -> Names {
    let named = Document::ALL.map(|document| (document.name(), document.written_by()));
    Names::new("document", named)
}

/// Prints the schema of a document, or which documents have one.
pub(crate) fn schema(args: &Schema) -> Result<u8, Failure> {
    let Some(name) = &args.document else {
        let row =
            |document: Document| format!("{:<12} {}\n", document.name(), document.written_by());
        output::print(&Document::ALL.map(row).concat())?;
        return Ok(DONE);
    };
    let document: Document = name
        .parse()
        .map_err(|error: UnknownDocument| Failure::message(error.to_string()))?;
    let text = serde_json::to_string_pretty(&schema_of(document))
        .map_err(|error| Failure::message(format!("cannot write the schema: {error}")))?;
    output::print(&format!("{text}\n"))?;
    Ok(DONE)
}

/// Prints a completion file.
pub(crate) fn completions(args: &Completions, mut program: Command) -> Result<u8, Failure> {
    let name = program.get_name().to_owned();
    let mut text = Vec::new();
    clap_complete::generate(args.shell, &mut program, name, &mut text);
    output::print(&text)?;
    Ok(DONE)
}

/// Prints the page of a command, or writes the pages of all.
pub(crate) fn man(args: &ManPages, mut program: Command) -> Result<u8, Failure> {
    // Without it subcommands do not know their full names.
    program.build();
    let unwritten = |error: io::Error| Failure::message(format!("cannot make a page: {error}"));
    if let Some(path) = &args.out {
        let mut folder = output::create_folder(path)?;
        for (name, page) in pages(&program).map_err(unwritten)? {
            let mut file = folder.file(&format!("{name}.1"))?;
            file.write_all(&page)
                .map_err(|error| WriteError::io("write into", path, error))?;
            folder.add(file);
        }
        folder.commit()?;
        return Ok(DONE);
    }
    // Down the tree of commands; former names are hidden in the list but have a page, too.
    let mut command = &program;
    for name in &args.command {
        let inner = command.get_subcommands().find(|sub| sub.get_name() == name);
        command = inner.ok_or_else(|| {
            let visible = command.get_subcommands().filter(is_visible);
            let known: Vec<&str> = visible.map(Command::get_name).collect();
            Failure::with_hint(
                format!("{} has no command \"{name}\"", command.get_name()),
                format!("its commands: {}", known.join(", ")),
            )
        })?;
    }
    let page = page(command).map_err(unwritten)?;
    output::print(&page)?;
    Ok(DONE)
}

/// The page of a command.
fn page(command: &Command) -> io::Result<Vec<u8>> {
    let name = command.get_display_name().unwrap_or(command.get_name());
    let mut text = Vec::new();
    Man::new(command.clone())
        .title(name.to_ascii_uppercase())
        .source(concat!("lostmotion ", env!("CARGO_PKG_VERSION")))
        .render(&mut text)?;
    Ok(text)
}

/// Name and page of a command and all below it that are not hidden.
fn pages(command: &Command) -> io::Result<Vec<(String, Vec<u8>)>> {
    let name = command.get_display_name().unwrap_or(command.get_name());
    let mut all = vec![(name.to_owned(), page(command)?)];
    for inner in command.get_subcommands().filter(is_visible) {
        all.extend(pages(inner)?);
    }
    Ok(all)
}

/// Whether a command has a page: not the former names, nor clap's own `help`.
fn is_visible(command: &&Command) -> bool {
    !command.is_hide_set() && command.get_name() != "help"
}
