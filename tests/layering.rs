//! The crates may depend on each other only downwards, as ARCHITECTURE.md draws it, and so may the
//! modules of each crate.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test says what went wrong by panicking"
)]

mod sources;

use cargo_metadata::{DependencyKind, MetadataCommand};
use std::collections::{BTreeMap, BTreeSet};

/// Every allowed direct edge: crate, then what it may depend on.
const ALLOWED: &[(&str, &[&str])] = &[
    ("lostmotion-base", &[]),
    ("lostmotion-gcode", &["base"]),
    ("lostmotion-gcode-tools", &["base", "gcode"]),
    ("lostmotion-path", &["base"]),
    ("lostmotion-drive", &["base"]),
    ("lostmotion-methods", &["base", "drive"]),
    ("lostmotion-analysis", &["base", "drive", "methods"]),
    ("lostmotion-rig", &["base", "drive", "methods"]),
    ("lostmotion-kinematics", &["base", "path"]),
    ("lostmotion-plan", &["base", "path", "kinematics"]),
    ("lostmotion-contour", &["base", "path"]),
    ("lostmotion-identify", &["base", "drive"]),
    ("lostmotion-logs", &["base"]),
    (
        "lostmotion-sim",
        &[
            "base",
            "gcode",
            "path",
            "kinematics",
            "plan",
            "drive",
            "methods",
            "analysis",
            "contour",
        ],
    ),
    (
        "lostmotion-report",
        &[
            "base",
            "drive",
            "methods",
            "contour",
            "plan",
            "gcode",
            "gcode-tools",
            "sim",
        ],
    ),
    (
        "lostmotion-study",
        &[
            "base", "plan", "drive", "methods", "contour", "sim", "report",
        ],
    ),
    ("lostmotion-sweep", &["base", "methods", "sim", "report"]),
    (
        "lostmotion",
        &[
            "base",
            "gcode",
            "gcode-tools",
            "path",
            "kinematics",
            "plan",
            "drive",
            "methods",
            "analysis",
            "contour",
            "identify",
            "logs",
            "sim",
            "report",
        ],
    ),
    ("lostmotion-cli", &["", "study", "sweep"]),
    ("lostmotion-python", &["", "sweep"]),
    ("lostmotion-c", &[""]),
];

/// Crates from outside that a room must never see, whatever the way.
const FORBIDDEN: &[(&str, &[&str])] = &[
    ("lostmotion-gcode", &["nalgebra", "faer", "clarabel"]),
    ("lostmotion-gcode-tools", &["nalgebra", "faer", "clarabel"]),
    (
        "lostmotion-analysis",
        &["nalgebra", "faer", "clarabel", "nom"],
    ),
    ("lostmotion-path", &["faer", "clarabel", "nom"]),
    ("lostmotion-plan", &["faer", "clarabel", "nom"]),
    ("lostmotion-contour", &["faer", "clarabel", "nom"]),
    (
        "lostmotion-sim",
        &["faer", "clarabel", "clap", "indicatif", "csv"],
    ),
];

fn short(name: &str) -> &str {
    name.strip_prefix("lostmotion")
        .map_or(name, |rest| rest.trim_start_matches('-'))
}

#[test]
fn edges_between_crates_go_one_way() {
    let metadata = MetadataCommand::new()
        .no_deps()
        .exec()
        .expect("cargo metadata");
    let allowed: BTreeMap<&str, BTreeSet<&str>> = ALLOWED
        .iter()
        .map(|(name, edges)| (*name, edges.iter().copied().collect()))
        .collect();
    let mut seen = BTreeSet::new();
    for package in &metadata.packages {
        let name = package.name.as_str();
        seen.insert(name.to_string());
        let edges = allowed
            .get(name)
            .unwrap_or_else(|| panic!("{name} is not in the layering table"));
        for dependency in package
            .dependencies
            .iter()
            .filter(|d| d.kind == DependencyKind::Normal)
        {
            if dependency.name.starts_with("lostmotion") {
                assert!(
                    edges.contains(short(&dependency.name)),
                    "{name} must not depend on {}",
                    dependency.name
                );
            }
        }
    }
    let table: BTreeSet<String> = ALLOWED
        .iter()
        .map(|(name, _)| (*name).to_string())
        .collect();
    assert_eq!(
        seen, table,
        "the layering table lists exactly the workspace"
    );
}

#[test]
fn heavy_or_io_crates_stay_out_of_the_forward_path() {
    let metadata = MetadataCommand::new().exec().expect("cargo metadata");
    let resolve = metadata.resolve.as_ref().expect("a resolved graph");
    let name_of: BTreeMap<_, _> = metadata
        .packages
        .iter()
        .map(|p| (&p.id, p.name.to_string()))
        .collect();
    for (root, forbidden) in FORBIDDEN {
        let start = metadata
            .packages
            .iter()
            .find(|p| p.name.as_str() == *root)
            .expect("a workspace crate");
        let mut todo = vec![&start.id];
        let mut reached = BTreeSet::new();
        while let Some(id) = todo.pop() {
            if !reached.insert(id) {
                continue;
            }
            let node = resolve
                .nodes
                .iter()
                .find(|node| node.id == *id)
                .expect("every package has a node");
            for dep in &node.deps {
                let normal = dep
                    .dep_kinds
                    .iter()
                    .any(|kind| kind.kind == DependencyKind::Normal);
                if normal {
                    todo.push(&dep.pkg);
                }
            }
        }
        for id in reached {
            let name = &name_of[id];
            assert!(!forbidden.contains(&name.as_str()), "{root} reaches {name}");
        }
    }
}

/// The only crate that may have `unsafe`: a border to C cannot do without.
const WITH_UNSAFE: &str = "c";

#[test]
fn unsafe_stays_in_one_crate() {
    for package in sources::packages() {
        if package.name == WITH_UNSAFE {
            continue;
        }
        let manifest = package.root.join("Cargo.toml");
        let manifest = std::fs::read_to_string(manifest).expect("a manifest");
        // The workspace's lints deny it.
        let name = &package.name;
        assert!(
            manifest.contains("[lints]\nworkspace = true"),
            "{name} has lints of its own"
        );
        for module in &package.modules {
            let source = std::fs::read_to_string(&module.file).expect("a source");
            let file = module.file.display();
            assert!(
                !source.contains("(unsafe_code"),
                "{file} allows `unsafe`, which is for `{WITH_UNSAFE}` alone"
            );
        }
    }
}

#[test]
fn modules_of_a_crate_go_one_way() {
    let mut faults = String::new();
    for package in sources::packages() {
        let cycles = sources::cycles::cycles(&package);
        for cycle in cycles {
            let mut text = format!(
                "{}::{}: {}\n",
                package.name,
                cycle.parent.join("::"),
                cycle.members.join(", ")
            );
            for ((from, to), places) in cycle.edges {
                let places: Vec<String> = places.into_iter().take(4).collect();
                text += &format!("    {from} -> {to} in {}\n", places.join(", "));
            }
            faults += &text;
        }
    }
    assert!(faults.is_empty(), "modules in rings:\n{faults}");
}

/// What only a system has: files, threads, clocks, processes.
const OF_A_SYSTEM: [&str; 7] = ["env", "fs", "net", "os", "process", "thread", "time"];
/// Crates from outside that ask for it.
const WITH_A_SYSTEM: [&str; 3] = ["rayon", "rayon-core", "tempfile"];

/// The library with the features of a build for WebAssembly: the crates and what they use of `std`, which
/// is what the book says.
#[test]
fn the_library_alone_asks_no_system_for_anything() {
    let features = ["--no-default-features", "--features", "wasm"];
    let tree = std::process::Command::new(env!("CARGO"))
        .args([
            "tree",
            "-p",
            "lostmotion-c",
            "-e",
            "normal",
            "--prefix",
            "none",
        ])
        .arg("--locked")
        .args(features)
        .current_dir(sources::repository())
        .output()
        .expect("cargo tree");
    assert!(
        tree.status.success(),
        "{}",
        String::from_utf8_lossy(&tree.stderr)
    );
    let tree = String::from_utf8(tree.stdout).expect("names are UTF-8");
    let crates: BTreeSet<&str> = tree
        .lines()
        .filter_map(|line| line.split(' ').next())
        .collect();
    assert!(crates.contains("lostmotion-sim") && crates.contains("lostmotion-report"));
    for name in WITH_A_SYSTEM {
        assert!(
            !crates.contains(name),
            "{name} is in a build without a system"
        );
    }
    let mut names = BTreeSet::new();
    for package in sources::packages() {
        let whole = match package.name.as_str() {
            "lostmotion" => package.name.clone(),
            name => format!("lostmotion-{name}"),
        };
        if !crates.contains(whole.as_str()) {
            continue;
        }
        for (name, file) in sources::system::std_names(&package) {
            let first = name.split("::").next().unwrap_or_default();
            assert!(
                !OF_A_SYSTEM.contains(&first) && !name.contains("::") && name != "*",
                "{file} uses std::{name}: files belong into `sim::files`, threads into `base::threads`"
            );
            names.insert(format!("`{name}`"));
        }
    }
    let told = format!(
        "Of `std` it uses {}.",
        names.into_iter().collect::<Vec<_>>().join(", ")
    );
    let page = std::fs::read_to_string("docs/book/src/guide/embedding.md").expect("the page");
    assert!(
        page.contains(&told),
        "docs/book/src/guide/embedding.md has to say:\n{told}"
    );
}
