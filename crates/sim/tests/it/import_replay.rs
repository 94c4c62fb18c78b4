//! Replays the corpus of the fuzz targets of imports, and texts drawn at random from its lines.

use crate::import_checks::description;
use lostmotion_sim::import::ImportFormat;
use proptest::prelude::*;
use std::path::Path;

/// The texts of a target.
pub(crate) fn corpus(name: &str) -> Vec<String> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    let folder = folder.join(format!("import_{name}"));
    let files = std::fs::read_dir(&folder).unwrap_or_else(|error| panic!("{name}: {error}"));
    let mut texts: Vec<String> = files
        .map(|file| std::fs::read_to_string(file.unwrap().path()).unwrap())
        .collect();
    texts.sort();
    texts
}

#[test]
fn the_corpus_of_every_format_holds() {
    for (name, _) in ImportFormat::NAMES {
        let texts = corpus(name);
        assert!(!texts.is_empty(), "the corpus of {name} is missing");
        for text in texts {
            description(name, text.as_bytes());
            // Of another format, and cut anywhere.
            for (other, _) in ImportFormat::NAMES {
                description(other, text.as_bytes());
            }
            let cuts = (0..text.len()).step_by(23);
            for cut in cuts.filter(|cut| text.is_char_boundary(*cut)) {
                description(name, &text.as_bytes()[..cut]);
            }
        }
    }
}

/// Values that a line may have in the place of its own.
const VALUES: [&str; 10] = [
    "0",
    "-1",
    "nan",
    "inf",
    "1e308",
    "-1e-308",
    "",
    "9999999999",
    "x",
    "0.5",
];

proptest! {
    #![proptest_config(ProptestConfig { cases: 100, ..ProptestConfig::default() })]
    #[test]
    fn lines_in_any_order_with_any_values_hold(
        format in 0..ImportFormat::NAMES.len(),
        picks in prop::collection::vec((any::<prop::sample::Index>(), 0..40_usize), 1..40),
    ) {
        let name = ImportFormat::NAMES[format].0;
        let whole = corpus(name).concat();
        let lines: Vec<&str> = whole.lines().collect();
        let mut text = String::new();
        for (index, value) in picks {
            let line = index.get(&lines);
            // Most lines stay; of others the last number becomes another value.
            let end = line.trim_end_matches(|c: char| !c.is_ascii_digit()).len();
            let begin = line[..end].trim_end_matches(|c: char| c.is_ascii_digit() || c == '.').len();
            match VALUES.get(value) {
                Some(value) => text.extend([&line[..begin], value, &line[end..], "\n"]),
                None => text.extend([*line, "\n"]),
            }
        }
        description(name, text.as_bytes());
    }
}
