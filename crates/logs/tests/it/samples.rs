//! Logs of real controls, where they lie beside the repository. Figures are facts counted by other
//! means: rows, first and last values.

use crate::{Whole, whole};
use lostmotion_logs::ReadOptions;
use std::path::{Path, PathBuf};

/// Folder of the samples; says so where it is absent.
fn folder() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    if folder.is_dir() {
        return Some(folder);
    }
    println!("{} is not there: skipped", folder.display());
    None
}

fn sample(path: &Path) -> Whole {
    let options = ReadOptions {
        period_s: path
            .components()
            .any(|part| part.as_os_str() == "halsampler")
            .then_some(1e-3),
        ..ReadOptions::default()
    };
    let bytes = std::fs::read(path).unwrap();
    whole(&bytes, &options).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Format, rows of each clock, first row and last row of the first clock.
type Fact<'a> = (&'a str, &'a str, &'a [usize], &'a [f64], &'a [f64]);

const FACTS: &[Fact<'_>] = &[
    (
        "halscope/real_daiman444_halscope.log",
        "HALscope, LinuxCNC up to 2.8",
        &[1999],
        &[0.0, 7.92000000061527, 0.0, 0.0],
        &[0.0, 7.92000000061527, 0.0, 0.0],
    ),
    (
        "halscope/real_daiman444_test.log",
        "HALscope, LinuxCNC up to 2.8",
        &[4000],
        &[1.0, -16.71899999938447, 1.0, 0.0],
        &[1.0, -0.71899999938462, 1.0, 0.0],
    ),
    (
        "halscope/by_us_v28_old_ns_C_locale.log",
        "HALscope, LinuxCNC up to 2.8",
        &[2000],
        &[0.0002, 4e-6, 0.0, 0.2],
        &[1.68500000000007, 1.92999962219789, 1.94, -5.0],
    ),
    (
        "halscope/by_us_old_nSec_comma_locale.log",
        "HALscope, LinuxCNC up to 2.8",
        &[499],
        &[0.0002, 4e-6, 0.0, 0.2],
        &[2.43499999999997, 2.19001320881493, 2.18, 5.0],
    ),
    (
        "halscope/by_us_v29_csv.csv",
        "HALscope, LinuxCNC 2.9",
        &[6000],
        &[0.0002, 4e-6, 0.0, 0.2, 0.0],
        &[5.0, 4.99999999999998, 4.99, 0.0, 1.0],
    ),
    (
        "halscope/by_us_v210_csv_position_scale.csv",
        "HALscope, LinuxCNC 2.10",
        &[4000],
        &[0.0002, 4e-6, 0.0, 0.2, 0.0],
        &[5.0, 4.99973179707639, 4.99, 0.0, 1.0],
    ),
    (
        "halsampler/by_us_fffs_tagged.txt",
        "halsampler",
        &[3000],
        &[0.0002, 4e-6, 0.0, 1.0],
        &[1.69, 1.445268, 1.435, 1.0],
    ),
    (
        "halsampler/by_us_fffs_untagged.txt",
        "halsampler",
        &[3000],
        &[0.0002, 4e-6, 0.0, 1.0],
        &[1.69, 1.445268, 1.435, 1.0],
    ),
    (
        "halsampler/by_us_old_tagged_gap_overrun_line.txt",
        "halsampler",
        &[1469],
        &[0.0002, 4e-6, 0.0, 1.0],
        &[4.185, 4.420791, 4.431, 1.0],
    ),
    (
        "halsampler/by_us_tagged_second_run_starts_with_overrun.txt",
        "halsampler",
        &[500],
        &[0.0002, 4e-6, 0.0, 1.0],
        &[2.44, 2.195013, 2.185, 1.0],
    ),
    (
        "halsampler/by_us_untagged_lost_rows_no_mark.txt",
        "halsampler",
        &[1469],
        &[0.0002, 4e-6, 0.0, 1.0],
        &[4.185, 4.420791, 4.431, 1.0],
    ),
    (
        "halsampler/real_linuxcnc_test_and-or-not-mux0.txt",
        "halsampler",
        &[16],
        &[0.0, 0.0, 1.0, 1.0, 3.0],
        &[0.0, 1.0, 0.0, 2.0, 4.0],
    ),
    (
        "halsampler/real_linuxcnc_test_biquad.txt",
        "halsampler",
        &[10],
        &[0.0, 0.123, 0.123],
        &[0.0, 0.0, 0.0],
    ),
    (
        "halsampler/real_linuxcnc_test_counter-encoder0.txt",
        "halsampler",
        &[3500],
        &[1.0, 1.0, 1.0],
        &[1281.0, 321.0, 321.0],
    ),
    (
        "halsampler/real_linuxcnc_test_limit3_f_tagged.txt",
        "halsampler",
        &[800],
        &[0.001],
        &[160.0],
    ),
    (
        "halsampler/real_linuxcnc_test_stepgen0_bb_untagged.txt",
        "halsampler",
        &[3500],
        &[0.0, 0.0],
        &[0.0, 0.0],
    ),
    (
        "heidenhain_tncscope/FeedStep150_N0_H55.sco",
        "Heidenhain TNCscope",
        &[6848],
        &[0.29296875, 0.0, 400.0, 400.0, 3.815],
        &[0.0, 0.0, 400.0, 400.0, 0.031],
    ),
    (
        "heidenhain_tncscope/FeedStep150_N300_H55.sco",
        "Heidenhain TNCscope",
        &[7136],
        &[],
        &[0.0, 0.0, 400.0, 400.0, 0.144],
    ),
    (
        "sinumerik/X_BK300_1.xml",
        "Sinumerik trace",
        &[7199],
        &[
            -300.0,
            -1100.174537,
            -299.999996,
            0.0,
            -1.430511,
            0.292969,
            -0.000004,
            1.800537,
            -0.737915,
            -1.999893,
        ],
        &[
            -300.0,
            -1100.173764,
            -299.999996,
            0.0,
            -7.581711,
            0.292969,
            -0.000004,
            1.794434,
            0.599854,
            1.982944,
        ],
    ),
    (
        "twincat_scope/tc3_scope_3_4_3145_3-default.csv",
        "TwinCAT Scope",
        &[1000],
        &[0.0],
        &[1.0],
    ),
    (
        "twincat_scope/by_us_fulltimestamp_tab_decimalcomma.csv",
        "TwinCAT Scope",
        &[1000, 1000],
        &[0.000004],
        &[4.694996],
    ),
    (
        "twincat_scope/by_us_nameonly_comma.csv",
        "TwinCAT Scope",
        &[500, 250],
        &[0.000004, 0.0002],
        &[4.69, 4.935],
    ),
    (
        "klipper/by_us_adxl345_raw.csv",
        "Klipper accelerometer",
        &[3000],
        &[-282.32494, 123.52989, 9806.65],
        &[],
    ),
    (
        "duet/by_us_M956_accelerometer.csv",
        "RepRapFirmware accelerometer",
        &[1000],
        &[0.0, 0.02, 1.0],
        &[-0.286, 0.02, 1.0],
    ),
    (
        "emps/data_emps.csv",
        "table",
        &[24841],
        &[0.000107822, 0.00000745, 2.538628089],
        &[],
    ),
    (
        "ubc_mill_trial3/trial3_air_cut_3ms.csv",
        "table",
        &[3900],
        &[-19.9999, 0.0, 1.1719, -0.388, 1737.843, -0.034],
        &[],
    ),
    (
        "ubc_mill_trial3/trial3_air_cut_0.1ms_first8000rows_of_motion.csv",
        "table",
        &[8000],
        &[253.949, 2880.2734, 2879.9805, 1.612, 1739.357, -0.083],
        &[],
    ),
];

#[test]
fn rows_and_values_are_those_of_the_files() {
    let Some(folder) = folder() else { return };
    for (file, format, rows, first, last) in FACTS {
        let log = sample(&folder.join(file));
        assert_eq!(log.format, *format, "{file}");
        for (group, &rows) in rows.iter().enumerate() {
            let found = log.rows.iter().filter(|row| row.group == group).count();
            assert_eq!(found, rows, "{file}, clock {group}");
        }
        let mut of_first = log.rows.iter().filter(|row| row.group == 0);
        let of_first = (of_first.next().unwrap(), of_first.next_back().unwrap());
        if !first.is_empty() {
            assert_eq!(of_first.0.values, *first, "{file}: first row");
        }
        if !last.is_empty() {
            assert_eq!(of_first.1.values, *last, "{file}: last row");
        }
    }
}

/// The same recording, exported with every separator, mark and order: channels count up together.
#[test]
fn every_export_of_one_scope_is_the_same() {
    let Some(folder) = folder() else { return };
    let mut seen = 0;
    for entry in std::fs::read_dir(folder.join("twincat_scope")).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        if !name.starts_with("tc3_scope") {
            continue;
        }
        let log = sample(&path);
        // `var_REAL64` counts milliseconds; called by its symbol where names hold the separator
        let channel = log
            .names
            .iter()
            .position(|name| name == "var_REAL64" || name == "MAIN.var_LREAL")
            .unwrap();
        let mut group = 0;
        let mut within = channel;
        loop {
            let width = log
                .rows
                .iter()
                .find(|row| row.group == group)
                .unwrap()
                .values
                .len();
            if within < width {
                break;
            }
            within -= width;
            group += 1;
        }
        let values: Vec<(f64, f64)> = log
            .rows
            .iter()
            .filter(|row| row.group == group)
            .map(|row| (row.time_s, row.values[within]))
            .collect();
        assert_eq!(values.len(), 1000, "{name}");
        for (index, (time_s, value)) in values.iter().enumerate() {
            assert!(
                (time_s - index as f64 * 1e-3).abs() < 1e-12,
                "{name}: {time_s}"
            );
            assert_eq!(*value, index as f64, "{name}");
        }
        seen += 1;
    }
    assert_eq!(seen, 11);
}

/// No file of the samples makes a reader panic, whatever it is.
#[test]
fn every_file_is_read_or_refused() {
    let Some(folder) = folder() else { return };
    let mut todo = vec![folder];
    let mut refused = 0;
    while let Some(next) = todo.pop() {
        for entry in std::fs::read_dir(next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                todo.push(path);
                continue;
            }
            let bytes = std::fs::read(&path).unwrap();
            match whole(&bytes, &ReadOptions::default()) {
                Ok(log) => assert!(!log.names.is_empty()),
                Err(error) => {
                    refused += 1;
                    assert!(error.contains("log"), "{}: {error}", path.display());
                }
            }
        }
    }
    println!("{refused} refused");
}
