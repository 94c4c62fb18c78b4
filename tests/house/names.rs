//! One name for one type in a crate.

use crate::sources::{Package, packages, shown, type_names};
use std::collections::BTreeMap;
use std::path::PathBuf;

/// Crates in which a name still stands for two types. Take a crate out once it is clean.
const STILL_REPEATED: &[&str] = &[];

/// Type names (struct, enum, union, trait, alias) that a package declares more than once in its
/// modules, each with its files. Types inside functions and under `#[cfg(test)]` do not count.
pub(crate) fn repeated_types(package: &Package) -> BTreeMap<String, Vec<PathBuf>> {
    let mut places: BTreeMap<String, Vec<PathBuf>> = BTreeMap::new();
    for (name, file) in type_names(package) {
        places.entry(name).or_default().push(file);
    }
    places.retain(|_, files| files.len() > 1);
    places
}

#[test]
fn no_type_name_twice_in_a_crate() {
    let mut faults = String::new();
    for package in packages() {
        if STILL_REPEATED.contains(&package.name.as_str()) {
            continue;
        }
        for (name, files) in repeated_types(&package) {
            let files: Vec<String> = files.iter().map(|file| shown(file)).collect();
            faults += &format!("{}: {name} in {}\n", package.name, files.join(", "));
        }
    }
    assert!(faults.is_empty(), "type names that stand twice:\n{faults}");
}
