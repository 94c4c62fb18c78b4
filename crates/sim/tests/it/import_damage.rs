//! Descriptions that were cut or garbled: refused with their line, or what is not taken is listed.
//! The texts are those of the fuzz targets' corpus.

use crate::import_replay::corpus;
use lostmotion_sim::import::{Fate, ImportFormat, ImportOptions, Imported, import};
use std::collections::BTreeSet;

fn read(name: &str, text: &str) -> Result<Imported, String> {
    let mut formats = ImportFormat::NAMES.into_iter();
    let (_, format) = formats.find(|(own, _)| *own == name).unwrap();
    import("file", text, format, &ImportOptions::default()).map_err(|error| error.to_string())
}

/// What is said of values that were not taken.
fn said(found: &Imported) -> BTreeSet<(String, String, String)> {
    let rows = found.rows.iter().filter(|row| row.fate != Fate::Used);
    rows.map(|row| (row.key.clone(), row.value.clone(), row.note.clone()))
        .collect()
}

/// The machine without its name, which may be anything, and what is said of where values come from.
fn values(found: &Imported) -> String {
    let lines = found
        .toml
        .lines()
        .filter(|line| !line.starts_with("name ="));
    let lines = lines.map(|line| {
        let (value, _) = line.split_once('#').unwrap_or((line, ""));
        value.trim_end()
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// Whether a damaged text is refused, says that something is missing, or is none the worse for it.
fn is_said(name: &str, whole: &Imported, text: &str) -> bool {
    match read(name, text) {
        // A place, and a reason.
        Err(error) => error.starts_with("file:") && error.lines().all(|line| line.len() > 10),
        Ok(found) => {
            values(&found) == values(whole)
                || said(&found).difference(&said(whole)).next().is_some()
        }
    }
}

/// Every so many damages of a kind are tried, so that the tests stay short; with
/// LOSTMOTION_ALL_DAMAGE set, all.
fn step(usual: usize) -> usize {
    if std::env::var_os("LOSTMOTION_ALL_DAMAGE").is_some() {
        1
    } else {
        usual
    }
}

/// Fails with the damages of all formats that nothing was said of.
fn check(kind: &str, usual: usize, damage: impl Fn(&str) -> Vec<(String, String)>) {
    let (mut silent, mut tried) = (Vec::new(), 0);
    for (name, _) in ImportFormat::NAMES {
        for text in corpus(name) {
            let whole = read(name, &text).unwrap();
            for (what, damaged) in damage(&text).into_iter().step_by(step(usual)) {
                tried += 1;
                if !is_said(name, &whole, &damaged) {
                    silent.push(format!("{name}: {what}"));
                }
            }
        }
    }
    assert!(
        silent.is_empty(),
        "{} of {tried} with {kind} say nothing:\n{}",
        silent.len(),
        silent.join("\n")
    );
}

#[test]
fn a_file_that_was_cut_anywhere_says_so() {
    check("a cut", 61, |text| {
        // A FluidNC file that ends with a line of its last linear axis is whole: nobody can tell that A was there.
        let is_whole = |before: &str| {
            before.ends_with('\n')
                && text.contains("\naxes:")
                && before.contains("max_travel_mm: 100")
        };
        let cuts =
            (1..text.len()).filter(|cut| text.is_char_boundary(*cut) && !is_whole(&text[..*cut]));
        let tail = |cut: usize| text[..cut].lines().last().unwrap_or_default().to_owned();
        cuts.map(|cut| (format!("behind `{}`", tail(cut)), text[..cut].to_owned()))
            .collect()
    });
}

#[test]
fn a_line_that_was_cut_says_so() {
    check("a line cut", 61, |text| {
        let lines: Vec<&str> = text.lines().collect();
        let mut all = Vec::new();
        for (index, line) in lines.iter().enumerate() {
            for (end, _) in line.char_indices() {
                let (before, behind) = line.split_at(end);
                // A line that is not there at all is none.
                if before.trim().is_empty() {
                    continue;
                }
                // Within a number nobody can tell.
                if before.ends_with(|c: char| c.is_ascii_digit() || c == '.')
                    && behind.starts_with(|c: char| c.is_ascii_digit() || c == '.')
                {
                    continue;
                }
                let mut left = lines.clone();
                left[index] = before;
                all.push((format!("`{before}` of `{line}`"), left.join("\n") + "\n"));
            }
        }
        all
    });
}

#[test]
fn a_value_that_is_no_number_says_so() {
    check("a value garbled", 41, |text| {
        let is_part = |c: char| c.is_ascii_digit() || c == '.';
        let begins = text
            .char_indices()
            .filter(|(at, c)| c.is_ascii_digit() && !text[..*at].ends_with(is_part));
        let mut all = Vec::new();
        for (begin, _) in begins {
            let rest = &text[begin..];
            let end = begin + rest.find(|c| !is_part(c)).unwrap_or(rest.len());
            let line = text[..begin].lines().count().max(1);
            for garbage in ["nan", "inf", "1e999", "abc", "--5", "0x10", "", "\u{0}"] {
                let what = format!("`{garbage}` in place of {}, line {line}", &text[begin..end]);
                all.push((what, [&text[..begin], garbage, &text[end..]].concat()));
            }
        }
        all
    });
}

/// The machine file that is made of them is not at hand: its ranges are told of the lines that were read.
#[test]
fn values_out_of_range_are_told_at_the_lines_that_they_were_read_in() {
    let ini = "[KINS]\nKINEMATICS = trivkins coordinates=X\nJOINTS = 1\n[TRAJ]\nCOORDINATES = X\nLINEAR_UNITS = mm\n[JOINT_0]\nTYPE = LINEAR\nMAX_VELOCITY = 1e30\nMAX_ACCELERATION = 500\nBACKLASH = 5000\nMIN_LIMIT = 0\nMAX_LIMIT = 300\n";
    let grbl = "$22=1\n$100=1e99\n$101=250\n$102=250\n$110=3000\n$111=3000\n$112=800\n$120=200\n$121=200\n$122=100\n$130=300\n$131=300\n$132=80\n";
    for (format, text, lines) in [
        (
            "linuxcnc",
            ini,
            [
                "file:9:1: axis.x.limits.velocity_mm_s: ",
                "file:11:1: axis.x.",
            ]
            .as_slice(),
        ),
        ("grbl", grbl, &["file:2:1: axis.x.transmission.linear."]),
    ] {
        let said = read(format, text).unwrap_err();
        println!("{said}");
        for line in lines {
            assert!(said.contains(line), "{line} is not in {said}");
        }
    }
}
