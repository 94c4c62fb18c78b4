//! Replays the corpus of the fuzz target, and inputs drawn at random from pieces of logs.

use crate::checks;
use proptest::prelude::*;
use std::path::Path;

/// What a target checks of its input.
type Check = fn(&[u8]);

/// Every target with what its corpus lies in.
const TARGETS: &[(&str, Check)] = &[
    ("halscope", checks::halscope),
    ("halsampler", checks::halsampler),
    ("twincat", checks::twincat),
    ("sinumerik", checks::sinumerik),
    ("tncscope", checks::tncscope),
    ("camonitor", checks::camonitor),
    ("accelerometer", checks::accelerometer),
    ("table", checks::table),
    ("positions", checks::positions),
    ("ballbar", checks::ballbar),
    #[cfg(feature = "mcap")]
    ("mcap", checks::binary),
    #[cfg(feature = "parquet")]
    ("parquet", checks::binary),
];

/// The inputs that a target starts from.
fn corpus(name: &str) -> Vec<Vec<u8>> {
    let corpus = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../fuzz/corpus");
    let mut files: Vec<_> = std::fs::read_dir(corpus.join(format!("log_{name}")))
        .unwrap()
        .map(|file| file.unwrap().path())
        .collect();
    files.sort();
    assert!(files.len() > 1, "the corpus of {name} is missing");
    files
        .iter()
        .map(|file| std::fs::read(file).unwrap())
        .collect()
}

#[test]
fn the_corpus_holds() {
    for (name, check) in TARGETS {
        corpus(name).iter().for_each(|input| check(input));
    }
}

/// Logs that are no text, with bytes changed: a text's pieces would never pass their checks.
#[test]
#[cfg(all(feature = "mcap", feature = "parquet"))]
fn damaged_binary_logs_are_read_or_refused() {
    let mut random = lostmotion_base::random::Random::new(18_500_001);
    for input in [corpus("mcap"), corpus("parquet")].concat() {
        for _ in 0..400 {
            let mut damaged = input.clone();
            for _ in 0..1 + random.below(4) {
                let at = random.below(damaged.len());
                damaged[at] = random.below(256) as u8;
            }
            checks::binary(&damaged);
        }
        for length in (0..input.len()).step_by(7) {
            checks::binary(&input[..length]);
        }
    }
}

/// Pieces that logs are made of.
const PIECES: &[&str] = &[
    "Sampling period is 1000000 ns \n",
    "# Sampling period is 1000000 ns\n",
    "a;b\n",
    "# Position: 0,5;1\n",
    "a +1.0 b -2,5 \n",
    "1.0;2.0\n",
    "0 0.5 1 \n",
    "1 0.6 1 \n",
    "overrun\n",
    "Name\tx\n",
    "File\ty\n",
    "Starttime of export\t1\n",
    "Name\ta\tName\tb\n",
    "Unit\tmm\tUnit\tA\n",
    "0\t1.5\t0\t2\n",
    "1\t2.5\n",
    " \t \t1\t3\n",
    "EOF\n",
    "<traceSession>\n",
    "<signal key=\"s1\" unitsType=\"posn\"/>",
    "<frameHeader dropOuts=\"0\"/>",
    "<dataSignal key=\"s1\" id=\"f1\" name=\"ActPos1stEnc\" interval=\"0.002\"/>",
    "<rec time=\"0.0\" f1=\"1.5\"/>\n",
    "<rec time=\"1e3\" f1=\"2.5\"/>\n",
    "%TNCscopeNT data file\n",
    "%[CURVE1]\n",
    "%NAME=s ist/X\n",
    "%DIMENSION=mm\n",
    "%[DATA]\n",
    " 0.0e+000; 1.0e+000; \n",
    " 3.0e+003; 2.0e+000; \n",
    "#time,accel_x\n",
    "0.1,5\n",
    "0.2,6\n",
    "Sample,X\n",
    "0,1\n",
    "1,1\n",
    "Rate 1000, overflows 0\n",
    "P 2026-01-01 00:00:00.0 1\n",
    "P 2026-01-01 00:00:01.0 2\n",
    "t_s,motor_mm,load_mm,current_a\n",
    "t_s,x_mm,cmd_pos_y [um],c_deg\n",
    "angle_deg,radius_mm\n",
    "370,1e9\n",
    "0,1,2,3\n",
    "0.001,1,2,-3\n",
    "0.002,1,2,3\n",
    ",",
    ";",
    "nan",
    "\n",
    "\r\n",
    "\u{feff}",
    "\"",
];

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn pieces_of_logs_are_read_or_refused(first: u8, pieces in prop::collection::vec(0..PIECES.len(), 0..24)) {
        let mut bytes = vec![first];
        pieces.iter().for_each(|&piece| bytes.extend(PIECES[piece].as_bytes()));
        checks::log(&bytes);
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        checks::log(&bytes);
        TARGETS.iter().for_each(|(_, check)| check(&bytes));
    }

    #[test]
    fn pieces_behind_each_beginning(first: u8, pieces in prop::collection::vec(0..PIECES.len(), 0..16)) {
        let mut bytes = vec![first];
        pieces.iter().for_each(|&piece| bytes.extend(PIECES[piece].as_bytes()));
        TARGETS.iter().for_each(|(_, check)| check(&bytes));
    }
}
