//! A run that is told to end leaves nothing behind.

use crate::bench::{Bench, names};
use std::path::Path;
use std::process::{Child, Command};
use std::time::Duration;

/// Hours of motion.
const ENDLESS: &str = "G21 G90 G17 G64 P0.005\nG0 X10 Y0\nO1 repeat [200000]\nG3 X10 Y0 I-10 J0 F1000\nG2 X10 Y0 I-10 J0 F1000\nO1 endrepeat\nM2\n";

/// Waits until a file is being written, or the run is over.
fn await_part(folder: &Path, run: &mut Child) {
    let writing = || folder.is_dir() && names(folder).iter().any(|name| name.ends_with(".part"));
    while run.try_wait().unwrap().is_none() && !writing() {
        std::thread::sleep(Duration::from_millis(5));
    }
    assert!(writing(), "the run was over before it wrote anything");
}

#[test]
fn unfinished_files_and_their_folders_go_with_the_run() {
    for (signal, arguments, within) in [
        (
            "-INT",
            ["plan", "endless.ngc", "--out", "plan.csv", "--quiet"].as_slice(),
            ".",
        ),
        (
            "-TERM",
            [
                "simulate",
                "endless.ngc",
                "--out",
                "a/b",
                "--trace",
                "--quiet",
            ]
            .as_slice(),
            "a/b",
        ),
    ] {
        let bench = Bench::new();
        bench.file("endless.ngc", ENDLESS);
        let mut run = bench.command(arguments).spawn().unwrap();
        await_part(&bench.path(within), &mut run);
        assert!(
            Command::new("kill")
                .args([signal, &run.id().to_string()])
                .status()
                .unwrap()
                .success()
        );
        assert_eq!(run.wait().unwrap().code(), Some(130), "{arguments:?}");
        assert_eq!(bench.names(), ["endless.ngc"], "{arguments:?}");
    }
}
