//! What sources use of `std`, in a build without the features that ask a system for something.

use super::{Module, Package, attributes};
use std::collections::BTreeSet;
use syn::visit::{self, Visit};

/// Features that such a build has.
const ON: [&str; 2] = ["report", "wasm"];

/// Methods of paths that look at files.
const OF_FILES: [&str; 9] = [
    "canonicalize",
    "exists",
    "is_dir",
    "is_file",
    "metadata",
    "read_dir",
    "read_link",
    "symlink_metadata",
    "try_exists",
];

/// Names below `std` that the modules of a package use, each with its file; a method that looks at files
/// is `path::METHOD`.
pub(crate) fn std_names(package: &Package) -> BTreeSet<(String, String)> {
    let mut found = BTreeSet::new();
    for module in &package.modules {
        if left_out(package, module) {
            continue;
        }
        let mut names = Names::default();
        module
            .items
            .iter()
            // children are modules of their own
            .filter(|item| !matches!(item, syn::Item::Mod(_)))
            .for_each(|item| names.visit_item(item));
        let file = super::shown(&module.file);
        found.extend(names.0.into_iter().map(|name| (name, file.clone())));
    }
    found
}

/// Whether a module, or one above it, is declared for a feature that is off.
fn left_out(package: &Package, module: &Module) -> bool {
    (0..module.path.len()).any(|depth| {
        let (parent, name) = (&module.path[..depth], &module.path[depth]);
        let parents = package.modules.iter().filter(|other| other.path == parent);
        parents
            .flat_map(|parent| &parent.items)
            .any(|item| match item {
                syn::Item::Mod(child) => child.ident == name && is_off(&child.attrs),
                _ => false,
            })
    })
}

/// `#[cfg(feature = "..")]` of a feature that is off, or `#[cfg(test)]`.
fn is_off(attributes: &[syn::Attribute]) -> bool {
    super::only_for_tests(attributes)
        || attributes.iter().any(|attribute| {
            let syn::Meta::List(list) = &attribute.meta else {
                return false;
            };
            let words = list.tokens.to_string();
            let feature = words.strip_prefix("feature = \"");
            let feature = feature.and_then(|rest| rest.strip_suffix('"'));
            list.path.is_ident("cfg") && feature.is_some_and(|feature| !ON.contains(&feature))
        })
}

#[derive(Default)]
struct Names(BTreeSet<String>);

impl Names {
    fn take(&mut self, first: &str, second: Option<&str>) {
        if let Some(second) = second.filter(|_| first == "std") {
            self.0.insert(second.to_owned());
        }
    }
}

impl<'ast> Visit<'ast> for Names {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !is_off(attributes(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_stmt(&mut self, stmt: &'ast syn::Stmt) {
        let off = match stmt {
            syn::Stmt::Local(local) => is_off(&local.attrs),
            syn::Stmt::Expr(syn::Expr::Block(block), _) => is_off(&block.attrs),
            syn::Stmt::Expr(syn::Expr::If(branch), _) => is_off(&branch.attrs),
            syn::Stmt::Expr(syn::Expr::Return(answer), _) => is_off(&answer.attrs),
            _ => false,
        };
        if !off {
            visit::visit_stmt(self, stmt);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let mut names = path
            .segments
            .iter()
            .map(|segment| segment.ident.to_string());
        if let Some(first) = names.next() {
            self.take(&first, names.next().as_deref());
        }
        visit::visit_path(self, path);
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        fn firsts(tree: &syn::UseTree, out: &mut Vec<String>) {
            match tree {
                syn::UseTree::Path(path) => out.push(path.ident.to_string()),
                syn::UseTree::Name(name) => out.push(name.ident.to_string()),
                syn::UseTree::Rename(name) => out.push(name.ident.to_string()),
                syn::UseTree::Group(group) => group.items.iter().for_each(|t| firsts(t, out)),
                syn::UseTree::Glob(_) => out.push("*".to_owned()),
            }
        }
        if let syn::UseTree::Path(path) = &item.tree {
            let mut names = Vec::new();
            firsts(&path.tree, &mut names);
            for name in names {
                self.take(&path.ident.to_string(), Some(&name));
            }
        }
    }

    fn visit_macro(&mut self, mac: &'ast syn::Macro) {
        // what stands in a macro is no path yet
        let words = mac.tokens.to_string();
        let words: Vec<&str> = words.split_whitespace().collect();
        for part in words.windows(3) {
            if part[1] == "::" {
                let letters = |c: char| !c.is_alphanumeric() && c != '_';
                let second = part[2].split(letters).next();
                self.take(part[0].trim_start_matches(letters), second);
            }
        }
        visit::visit_macro(self, mac);
    }

    fn visit_expr_method_call(&mut self, call: &'ast syn::ExprMethodCall) {
        let name = call.method.to_string();
        if OF_FILES.contains(&name.as_str()) {
            self.0.insert(format!("path::{name}"));
        }
        visit::visit_expr_method_call(self, call);
    }
}
