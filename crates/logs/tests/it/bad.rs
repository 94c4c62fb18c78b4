//! Bad input: each is refused with its place and what to do.

use crate::whole;
use lostmotion_logs::{AxisOptions, ReadOptions, read_axis};
use std::io::Read;

fn error(text: &[u8]) -> String {
    let options = AxisOptions {
        needed: vec![lostmotion_logs::Role::Load, lostmotion_logs::Role::Current],
        ..AxisOptions::default()
    };
    read_axis(text, "log", &options)
        .expect_err("has to be refused")
        .to_string()
}

#[test]
fn each_fault_has_its_place() {
    let good = "t_s,motor_mm,load_mm,current_a\n0.000,0,0,0\n0.001,0,0,0\n0.002,0,0,0\n";
    let change = |from: &str, to: &str| good.replacen(from, to, 1).into_bytes();
    let cases: &[(Vec<u8>, &[&str])] = &[
        (Vec::new(), &["log: the file is empty"]),
        (b" \n\n".to_vec(), &["blank lines"]),
        (b"\x00\x01\x02".to_vec(), &["byte 0x00 at offset 0"]),
        (b"\xff\xfet\x00".to_vec(), &["UTF-16", "save it as UTF-8"]),
        (b"\x1f\x8b\x08".to_vec(), &["gzip", "decompress it"]),
        (
            b"\x28\xb5\x2f\xfd\x04\x00".to_vec(),
            &["Zstandard", "decompress it"],
        ),
        (
            b"ARROW1\x00\x00".to_vec(),
            &["Feather", "as CSV or Parquet"],
        ),
        (
            b"THREAD servo-thread\nMAXCHAN 4\n".to_vec(),
            &["set-up of HALscope"],
        ),
        (
            b"hello world\nthis is prose\n".to_vec(),
            &["no table of numbers"],
        ),
        (
            change("0.002,0", "0.002,nan"),
            &["line 4, column `motor_mm`: `nan` is not a finite number"],
        ),
        (
            change("0.001,0", "0.001,"),
            &["line 3, column `motor_mm`: `` is empty"],
        ),
        (
            change("0.001,0", "0.001,1x"),
            &["line 3, column `motor_mm`: `1x` is not a number"],
        ),
        (
            change("0.002,0,0,0", "0.002,0"),
            &["line 4: 2 cells where the header has 4"],
        ),
        (
            change("0.002", "0.001"),
            &["line 4: the time 0.001 s is not after 0.001 s"],
        ),
        (
            change("load_mm", "load_deg"),
            &["`load_deg` is in deg, but the motor's position is in mm"],
        ),
        (
            change("load_mm", "last"),
            &[
                "none that is known to be the load",
                "--column load=NAME,unit=mm",
            ],
        ),
        (
            change("load_mm", "motor_mm"),
            &["two columns `motor_mm`", "--column motor=NAME"],
        ),
        (
            change("load_mm", "load"),
            &[
                "the unit of `load`, the load, is not told",
                "--column load=load,unit=UNIT",
            ],
        ),
        (
            change("current_a", "current_mm"),
            &["`current_mm`, the current, is in mm", "a current"],
        ),
        (
            change("t_s", "t_mm"),
            &["the unit of the time `t_mm` is mm"],
        ),
        (change("t_s", "x"), &["no column of times", "--period-ms"]),
        (
            good.as_bytes()[..43].to_vec(),
            &["1 rows of data", "at least 3"],
        ),
        (
            b"t_s,motor_mm,load_mm,current_a\n".to_vec(),
            &["no table of numbers"],
        ),
        (
            b"Sampling period is 0 ns \n\na +1.0 \n".to_vec(),
            &["line 1: `0 ns` is not a sampling period"],
        ),
        (
            b"# Sampling period is 1000 ns\na;b\n1.0;2.0\n1.0;2.0;3.0\n".to_vec(),
            &["none that is known to be the motor"],
        ),
        (
            b"Name\tx\nFile\ty\nStarttime of export\t1\nEndtime\t2\n\nName\ta\n".to_vec(),
            &["no rows of data behind the header"],
        ),
        (
            b"%TNCscopeNT data file\n%[GLOBAL]\n".to_vec(),
            &["no `%[DATA]`"],
        ),
        (
            b"<traceSession>\n<traceData/></traceSession>".to_vec(),
            &["no records"],
        ),
        (
            b"<traceSession>\n<rec time=\"0\" ".to_vec(),
            &["line 2", "the file may be cut"],
        ),
        (
            b"Sample,X,Y,Z\n0,1,1,1\n".to_vec(),
            &["an accelerometer's log has no motor", "`axis log`"],
        ),
        (
            b"Failed to start accelerometer\n".to_vec(),
            &["the firmware says"],
        ),
    ];
    for (text, parts) in cases {
        let said = error(text);
        for part in *parts {
            assert!(
                said.contains(part),
                "{}\n-> {said}",
                String::from_utf8_lossy(text)
            );
        }
    }
}

#[test]
fn rows_are_refused_with_line_and_channel() {
    let options = ReadOptions {
        period_s: Some(1e-3),
        ..ReadOptions::default()
    };
    for (text, part) in [
        (
            "# Sampling period is 1000 ns\na;b\n1.0;2.0\n1.0;2.0;3.0\n",
            "line 4: 3 values where there are 2 channels",
        ),
        (
            "# Sampling period is 1000 ns\na;b\n1.0;2.0\n1.0;nan\n",
            "line 4, column `b`: `nan` is not a finite number",
        ),
        (
            "Sampling period is 1000 ns \n\na +1.0 b +2.0 \na +1.0 c +2.0 \na +1.0 b +2.0 \n",
            "line 4: channel `c` stands where `b` was",
        ),
        (
            "0.5 1 \n0.5 1 1 \n",
            "line 2: 3 values where the first row has 2",
        ),
        ("0.5 1 \n0.5 inf \n0.5 1 \n", "no table of numbers"),
        (
            "Sample,X\n0,1\n2,1\nRate 5, overflows 0\n",
            "line 3: sample 2 stands where 1",
        ),
        (
            "Sample,X\n0,1\n1,1\n",
            "the last line with the rate is missing",
        ),
        (
            "a 2026-01-01 00:00:00.0 1\na 2026-01-01 00:00:01.0 on\n",
            "column `a`: `on` is not a number",
        ),
    ] {
        match whole(text.as_bytes(), &options) {
            Ok(_) => panic!("{text:?} was read"),
            Err(said) => assert!(
                said.contains(part) || part == "no table of numbers",
                "{text:?}\n-> {said}"
            ),
        }
    }
}

/// A current whose sign was lost.
#[test]
fn a_magnitude_is_no_current() {
    let mut text = "t_s,motor_mm,load_mm,current_a\n".to_owned();
    for row in 0..400 {
        let x = (f64::from(row) * 0.05).sin();
        text += &format!("{},{x},{x},{}\n", f64::from(row) * 1e-3, x.abs() + 0.1);
    }
    assert!(error(text.as_bytes()).contains("its sign is lost"));
}

/// Zeros without end, as of a sparse file, and one line without end.
#[test]
fn endless_input_is_refused_early() {
    struct Endless(u8, u64);
    impl Read for Endless {
        fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
            buffer.fill(self.0);
            self.1 += buffer.len() as u64;
            assert!(self.1 < 1 << 24, "more than 16 MiB were read");
            Ok(buffer.len())
        }
    }
    for byte in [0, b'1', b' '] {
        let input = std::io::BufReader::new(Endless(byte, 0));
        assert!(read_axis(input, "log", &AxisOptions::default()).is_err());
    }
    let trace = b"<traceSession>".chain(std::io::BufReader::new(Endless(b'a', 0)));
    assert!(
        read_axis(
            std::io::BufReader::new(trace),
            "log",
            &AxisOptions::default()
        )
        .is_err()
    );
}
