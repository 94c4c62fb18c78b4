//! Cycles between the modules of a crate.
//!
//! A module uses another one where a path in it leads there: `use`, a path in code or in a macro's
//! arguments, through `crate::`, `super::`, `self::` or the name of a child. A name that a module
//! re-exports counts as a use of the module that it comes from.
//!
//! At every level of nesting the children of one module are compared: `a` depends on `b` where
//! anything in or below `a` uses anything in or below `b`. What a parent and its own children use
//! of each other does not count, since a parent and its children are one thing to outsiders.

use super::{Module, Package};
use std::collections::{BTreeMap, BTreeSet, HashMap};
use syn::visit::Visit;

/// Children of one module that depend on each other in a ring.
pub(crate) struct Cycle {
    /// The common parent; empty for the crate's root.
    pub(crate) parent: Vec<String>,
    pub(crate) members: Vec<String>,
    /// Each edge between two members, with the modules where it stands.
    pub(crate) edges: Edges,
}

/// Edges between siblings, from and to, each with the modules where it stands.
type Edges = BTreeMap<(String, String), BTreeSet<String>>;

/// Every cycle of a package.
pub(crate) fn cycles(package: &Package) -> Vec<Cycle> {
    let tree = Tree::new(package);
    // edges between siblings, by parent
    let mut levels: BTreeMap<Vec<String>, Edges> = BTreeMap::new();
    for module in &package.modules {
        for target in tree.uses(module) {
            let common = module
                .path
                .iter()
                .zip(&target)
                .take_while(|(a, b)| a == b)
                .count();
            let (Some(from), Some(to)) = (module.path.get(common), target.get(common)) else {
                continue;
            };
            levels
                .entry(target[..common].to_vec())
                .or_default()
                .entry((from.clone(), to.clone()))
                .or_default()
                .insert(module.path.join("::"));
        }
    }
    let mut found = Vec::new();
    for (parent, edges) in levels {
        for members in rings(&edges) {
            let inside = |name: &String| members.contains(name);
            let edges = edges
                .iter()
                .filter(|((from, to), _)| inside(from) && inside(to))
                .map(|(edge, places)| (edge.clone(), places.clone()))
                .collect();
            found.push(Cycle {
                parent: parent.clone(),
                members,
                edges,
            });
        }
    }
    found
}

/// Sets of more than one name of which each reaches every other.
fn rings(edges: &BTreeMap<(String, String), BTreeSet<String>>) -> Vec<Vec<String>> {
    let mut next: BTreeMap<&String, Vec<&String>> = BTreeMap::new();
    for (from, to) in edges.keys() {
        next.entry(from).or_default().push(to);
    }
    let reach = |start: &String| {
        let mut reached = BTreeSet::new();
        let mut todo: Vec<&String> = next.get(start).cloned().unwrap_or_default();
        while let Some(name) = todo.pop() {
            if reached.insert(name.clone()) {
                todo.extend(next.get(name).cloned().unwrap_or_default());
            }
        }
        reached
    };
    let reached: BTreeMap<&String, BTreeSet<String>> =
        next.keys().map(|name| (*name, reach(name))).collect();
    let mut rings: BTreeSet<Vec<String>> = BTreeSet::new();
    for (name, forward) in &reached {
        let ring: Vec<String> = forward
            .iter()
            .filter(|other| reached.get(other).is_some_and(|back| back.contains(*name)))
            .cloned()
            .collect();
        if ring.len() > 1 {
            rings.insert(ring);
        }
    }
    rings.into_iter().collect()
}

/// Names of a crate: what each module declares, and what it re-exports from where.
struct Tree {
    modules: BTreeSet<Vec<String>>,
    declared: HashMap<Vec<String>, BTreeSet<String>>,
    /// (module, name) to the full path that a `use` in that module gives the name.
    imported: HashMap<(Vec<String>, String), Vec<String>>,
    globs: HashMap<Vec<String>, Vec<Vec<String>>>,
}

impl Tree {
    fn new(package: &Package) -> Self {
        let mut tree = Tree {
            modules: package.modules.iter().map(|m| m.path.clone()).collect(),
            declared: HashMap::new(),
            imported: HashMap::new(),
            globs: HashMap::new(),
        };
        for module in &package.modules {
            let names = module.items.iter().filter_map(declared_name).collect();
            tree.declared.insert(module.path.clone(), names);
        }
        for module in &package.modules {
            for item in &module.items {
                if let syn::Item::Use(item) = item {
                    for (path, name) in flatten(&item.tree) {
                        let Some(full) = tree.absolute(&module.path, &path) else {
                            continue;
                        };
                        if name == "*" {
                            tree.globs
                                .entry(module.path.clone())
                                .or_default()
                                .push(full);
                        } else {
                            tree.imported.insert((module.path.clone(), name), full);
                        }
                    }
                }
            }
        }
        tree
    }

    /// Modules that a module's paths lead to.
    fn uses(&self, module: &Module) -> BTreeSet<Vec<String>> {
        let mut collected = Paths::default();
        for item in &module.items {
            // a child stands for itself in the list of modules
            if !matches!(item, syn::Item::Mod(_)) {
                collected.visit_item(item);
            }
        }
        let mut targets = BTreeSet::new();
        for path in collected.0 {
            if let Some(full) = self.absolute(&module.path, &path) {
                targets.insert(self.home(full));
            }
        }
        targets.remove(&module.path);
        targets
    }

    /// A path from the crate's root, if it leads into this crate.
    fn absolute(&self, module: &[String], path: &[String]) -> Option<Vec<String>> {
        let first = path.first()?;
        let mut full = match first.as_str() {
            "crate" | "$crate" => Vec::new(),
            "self" => module.to_vec(),
            "super" => module[..module.len().checked_sub(1)?].to_vec(),
            name => {
                let mut child = module.to_vec();
                child.push(name.to_string());
                if !self.modules.contains(&child) {
                    return None;
                }
                child
            }
        };
        for name in &path[1..] {
            if name == "super" {
                full.pop()?;
            } else if name != "self" {
                full.push(name.clone());
            }
        }
        Some(full)
    }

    /// The module that a full path ends in, through re-exports.
    fn home(&self, mut full: Vec<String>) -> Vec<String> {
        // re-exports of re-exports are few; the bound only ends a ring of them
        for _ in 0..8 {
            let depth = (0..=full.len())
                .rev()
                .find(|&depth| self.modules.contains(&full[..depth]))
                .unwrap_or(0);
            let module = full[..depth].to_vec();
            let Some(name) = full.get(depth).cloned() else {
                return module;
            };
            if self.declares(&module, &name) {
                return module;
            }
            let mut onward = match self.imported.get(&(module.clone(), name.clone())) {
                Some(target) => target.clone(),
                None => {
                    let globs = self.globs.get(&module);
                    let from = globs
                        .and_then(|globs| globs.iter().find(|glob| self.declares(glob, &name)));
                    match from {
                        Some(glob) => [glob.as_slice(), std::slice::from_ref(&name)].concat(),
                        None => return module,
                    }
                }
            };
            onward.extend_from_slice(&full[depth + 1..]);
            full = onward;
        }
        full
    }

    fn declares(&self, module: &[String], name: &str) -> bool {
        self.declared
            .get(module)
            .is_some_and(|names| names.contains(name))
    }
}

/// The name of an item, but for modules, `use` and `impl`.
fn declared_name(item: &syn::Item) -> Option<String> {
    let name = match item {
        syn::Item::Const(item) => &item.ident,
        syn::Item::Enum(item) => &item.ident,
        syn::Item::Fn(item) => &item.sig.ident,
        syn::Item::Macro(item) => item.ident.as_ref()?,
        syn::Item::Static(item) => &item.ident,
        syn::Item::Struct(item) => &item.ident,
        syn::Item::Trait(item) => &item.ident,
        syn::Item::Type(item) => &item.ident,
        syn::Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(name.to_string())
}

/// Every path of a `use` with the name that it gets; `*` for a glob.
fn flatten(tree: &syn::UseTree) -> Vec<(Vec<String>, String)> {
    fn walk(tree: &syn::UseTree, before: &[String], out: &mut Vec<(Vec<String>, String)>) {
        let with = |name: &syn::Ident| {
            let mut path = before.to_vec();
            path.push(name.to_string());
            path
        };
        match tree {
            syn::UseTree::Path(path) => walk(&path.tree, &with(&path.ident), out),
            syn::UseTree::Name(name) if name.ident == "self" => {
                out.push((before.to_vec(), before.last().cloned().unwrap_or_default()));
            }
            syn::UseTree::Name(name) => out.push((with(&name.ident), name.ident.to_string())),
            syn::UseTree::Rename(rename) => {
                out.push((with(&rename.ident), rename.rename.to_string()));
            }
            syn::UseTree::Glob(_) => out.push((before.to_vec(), "*".to_string())),
            syn::UseTree::Group(group) => {
                for tree in &group.items {
                    walk(tree, before, out);
                }
            }
        }
    }
    let mut out = Vec::new();
    walk(tree, &[], &mut out);
    out
}

/// Collects paths of more than one name, in code, types and the arguments of macros.
#[derive(Default)]
struct Paths(Vec<Vec<String>>);

impl<'ast> Visit<'ast> for Paths {
    fn visit_item(&mut self, item: &'ast syn::Item) {
        if !super::only_for_tests(super::attributes(item)) {
            syn::visit::visit_item(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast syn::ItemUse) {
        self.0
            .extend(flatten(&item.tree).into_iter().map(|(path, _)| path));
    }

    fn visit_visibility(&mut self, _: &'ast syn::Visibility) {}

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let names: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        if names.len() > 1 {
            self.0.push(names);
        }
        syn::visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, call: &'ast syn::Macro) {
        self.visit_path(&call.path);
        self.tokens(call.tokens.clone());
    }
}

impl Paths {
    /// Chains of `name::name` among the tokens of a macro.
    fn tokens(&mut self, tokens: proc_macro2::TokenStream) {
        use proc_macro2::TokenTree;
        let mut chain: Vec<String> = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Punct(mark) if mark.as_char() == ':' && !chain.is_empty() => colons += 1,
                TokenTree::Ident(name) => {
                    if colons != 2 {
                        self.end_chain(&mut chain);
                    }
                    chain.push(name.to_string());
                    colons = 0;
                }
                TokenTree::Group(group) => {
                    self.end_chain(&mut chain);
                    colons = 0;
                    self.tokens(group.stream());
                }
                _ => {
                    self.end_chain(&mut chain);
                    colons = 0;
                }
            }
        }
        self.end_chain(&mut chain);
    }

    fn end_chain(&mut self, chain: &mut Vec<String>) {
        let chain = std::mem::take(chain);
        if chain.len() > 1 {
            self.0.push(chain);
        }
    }
}
