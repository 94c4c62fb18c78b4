//! Reads the sources of every package of the workspace, for the tests that hold the layout.
//!
//! A package's module tree is followed from `src/lib.rs` or `src/main.rs` through its `mod`
//! declarations. Items under `#[cfg(test)]` are left out.

#![allow(
    dead_code,
    reason = "two test binaries share this reader; each uses its part"
)]

pub(crate) mod cycles;
pub(crate) mod system;

use std::fs;
use std::path::{Path, PathBuf};
use syn::spanned::Spanned;

/// One package of the workspace.
pub(crate) struct Package {
    /// Name without the prefix `lostmotion-`; the facade is `lostmotion`.
    pub(crate) name: String,
    /// Folder with its `Cargo.toml`.
    pub(crate) root: PathBuf,
    /// Modules of the library, or of the program where there is no library; the root comes first.
    pub(crate) modules: Vec<Module>,
}

/// One module: a file, or a `mod` with a body.
pub(crate) struct Module {
    /// Names from the crate's root; empty for the root itself.
    pub(crate) path: Vec<String>,
    pub(crate) file: PathBuf,
    /// Items without those under `#[cfg(test)]`.
    pub(crate) items: Vec<syn::Item>,
}

/// Root of the repository.
pub(crate) fn repository() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// Every package under `crates/`, by name, then the facade.
pub(crate) fn packages() -> Vec<Package> {
    let mut roots: Vec<PathBuf> = fs::read_dir(repository().join("crates"))
        .expect("the folder crates")
        .map(|entry| entry.expect("an entry of crates").path())
        .filter(|path| path.join("Cargo.toml").is_file())
        .collect();
    roots.sort();
    roots.push(repository());
    roots.into_iter().map(package).collect()
}

fn package(root: PathBuf) -> Package {
    let name = if root == repository() {
        "lostmotion".to_string()
    } else {
        let folder = root.file_name().expect("a folder with a name");
        folder.to_string_lossy().into_owned()
    };
    let start = ["src/lib.rs", "src/main.rs"]
        .map(|file| root.join(file))
        .into_iter()
        .find(|file| file.is_file())
        .unwrap_or_else(|| panic!("{name} has neither src/lib.rs nor src/main.rs"));
    let mut modules = Vec::new();
    let folder = start.parent().expect("a file in a folder").to_path_buf();
    read_module(&start, &folder, &[], &mut modules);
    Package {
        name,
        root,
        modules,
    }
}

/// Reads a file as a module; `folder` is where the files of its children lie.
fn read_module(file: &Path, folder: &Path, path: &[String], out: &mut Vec<Module>) {
    let text = fs::read_to_string(file).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    let parsed = syn::parse_file(&text).unwrap_or_else(|e| panic!("{}: {e}", file.display()));
    take_items(file, folder, path, parsed.items, out);
}

fn take_items(
    file: &Path,
    folder: &Path,
    path: &[String],
    mut items: Vec<syn::Item>,
    out: &mut Vec<Module>,
) {
    items.retain(|item| !only_for_tests(attributes(item)));
    let children: Vec<syn::ItemMod> = items
        .iter()
        .filter_map(|item| match item {
            syn::Item::Mod(module) => Some(module.clone()),
            _ => None,
        })
        .collect();
    let declared = declared_by_macros(&items);
    out.push(Module {
        path: path.to_vec(),
        file: file.to_path_buf(),
        items,
    });
    for name in declared {
        let found = folder.join(format!("{name}.rs"));
        if found.is_file() {
            let child_path = [path, std::slice::from_ref(&name)].concat();
            read_module(&found, &folder.join(&name), &child_path, out);
        }
    }
    for child in children {
        let name = child.ident.to_string();
        let mut child_path = path.to_vec();
        child_path.push(name.clone());
        if let Some((_, body)) = child.content {
            take_items(file, &folder.join(&name), &child_path, body, out);
            continue;
        }
        let named = child.attrs.iter().find_map(path_attribute);
        let candidates = match named {
            Some(named) => vec![file.parent().expect("a folder").join(named)],
            None => vec![
                folder.join(format!("{name}.rs")),
                folder.join(&name).join("mod.rs"),
            ],
        };
        let found = candidates
            .iter()
            .find(|candidate| candidate.is_file())
            .unwrap_or_else(|| panic!("{}: no file for mod {name}", file.display()));
        read_module(found, &folder.join(&name), &child_path, out);
    }
}

/// What may be modules that macros declare, as `methods!` and `kinds!` do: the first word of each
/// row.
fn declared_by_macros(items: &[syn::Item]) -> Vec<String> {
    let mut words = Vec::new();
    for item in items {
        let syn::Item::Macro(item) = item else {
            continue;
        };
        // A macro's definition has a name, its use has none.
        if item.ident.is_some() {
            continue;
        }
        let rows = item.mac.tokens.to_string();
        for row in rows.split(';') {
            let word = row.trim().split(|c: char| !c.is_alphanumeric() && c != '_');
            words.extend(
                word.take(1)
                    .filter(|word| !word.is_empty())
                    .map(str::to_owned),
            );
        }
    }
    words
}

/// The text of `#[path = "..."]`.
fn path_attribute(attribute: &syn::Attribute) -> Option<String> {
    let syn::Meta::NameValue(pair) = &attribute.meta else {
        return None;
    };
    let syn::Expr::Lit(literal) = &pair.value else {
        return None;
    };
    match &literal.lit {
        syn::Lit::Str(text) if pair.path.is_ident("path") => Some(text.value()),
        _ => None,
    }
}

/// `#[cfg(test)]`, also as part of `all(..)`.
pub(crate) fn only_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        let syn::Meta::List(list) = &attribute.meta else {
            return false;
        };
        let words = list.tokens.to_string();
        list.path.is_ident("cfg") && (words == "test" || words.starts_with("all (test"))
    })
}

/// Attributes of an item of any kind.
pub(crate) fn attributes(item: &syn::Item) -> &[syn::Attribute] {
    match item {
        syn::Item::Const(item) => &item.attrs,
        syn::Item::Enum(item) => &item.attrs,
        syn::Item::ExternCrate(item) => &item.attrs,
        syn::Item::Fn(item) => &item.attrs,
        syn::Item::ForeignMod(item) => &item.attrs,
        syn::Item::Impl(item) => &item.attrs,
        syn::Item::Macro(item) => &item.attrs,
        syn::Item::Mod(item) => &item.attrs,
        syn::Item::Static(item) => &item.attrs,
        syn::Item::Struct(item) => &item.attrs,
        syn::Item::Trait(item) => &item.attrs,
        syn::Item::TraitAlias(item) => &item.attrs,
        syn::Item::Type(item) => &item.attrs,
        syn::Item::Union(item) => &item.attrs,
        syn::Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// Names of the types that a package declares in its modules, each with its file.
pub(crate) fn type_names(package: &Package) -> Vec<(String, PathBuf)> {
    let mut names = Vec::new();
    for module in &package.modules {
        for item in &module.items {
            let name = match item {
                syn::Item::Struct(item) => &item.ident,
                syn::Item::Enum(item) => &item.ident,
                syn::Item::Union(item) => &item.ident,
                syn::Item::Trait(item) => &item.ident,
                syn::Item::Type(item) => &item.ident,
                _ => continue,
            };
            names.push((name.to_string(), module.file.clone()));
        }
    }
    names.sort();
    names
}

/// Every `.rs` file under a folder, by name.
pub(crate) fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let mut files = files_under(folder);
    files.retain(|file| file.extension().is_some_and(|end| end == "rs"));
    files
}

/// Every file under a folder, by name, without build output and hidden folders.
pub(crate) fn files_under(folder: &Path) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let mut todo = vec![folder.to_path_buf()];
    while let Some(folder) = todo.pop() {
        let Ok(entries) = fs::read_dir(&folder) else {
            continue;
        };
        for entry in entries {
            let path = entry.expect("an entry of a folder").path();
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let skipped = name == "target" || name == ".git";
            if path.is_dir() && !skipped {
                todo.push(path);
            } else if path.is_file() {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// Folders with Rust code of a package. Those of the facade leave the other packages out.
pub(crate) fn code_folders(package: &Package) -> Vec<PathBuf> {
    ["src", "tests", "examples", "benches"]
        .map(|folder| package.root.join(folder))
        .into_iter()
        .filter(|folder| folder.is_dir())
        .collect()
}

/// First and last line of each function body in a file, nested ones included in the outer one.
pub(crate) fn function_bodies(text: &str) -> Vec<(usize, usize)> {
    struct Bodies(Vec<(usize, usize)>);
    impl<'ast> syn::visit::Visit<'ast> for Bodies {
        fn visit_block(&mut self, block: &'ast syn::Block) {
            let span = block.span();
            self.0.push((span.start().line, span.end().line));
        }
    }
    let Ok(file) = syn::parse_file(text) else {
        return Vec::new();
    };
    let mut bodies = Bodies(Vec::new());
    syn::visit::Visit::visit_file(&mut bodies, &file);
    bodies.0
}

/// A path as it is written from the root of the repository, with `/` on every platform.
pub(crate) fn shown(path: &Path) -> String {
    let root = repository();
    let short = path.strip_prefix(&root).unwrap_or(path);
    short.to_string_lossy().replace('\\', "/")
}
