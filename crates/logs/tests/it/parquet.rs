//! Parquet logs, written by the format's own writer.

use crate::whole;
use lostmotion_logs::{AxisOptions, ReadOptions, read_axis};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, FloatType, Int32Type, Int64Type};
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::parser::parse_message_type;
use std::sync::Arc;

/// One column of a row group.
enum Cells {
    Doubles(Vec<f64>),
    /// Values, and for every row whether it has one.
    Maybe(Vec<f64>, Vec<i16>),
    Floats(Vec<f32>),
    Ints(Vec<i32>),
    Longs(Vec<i64>),
    Texts(Vec<&'static str>),
}

/// A file with these row groups.
fn file(schema: &str, groups: &[Vec<Cells>], compression: parquet::basic::Compression) -> Vec<u8> {
    let schema = Arc::new(parse_message_type(schema).unwrap());
    let properties = WriterProperties::builder()
        .set_compression(compression)
        .build();
    let mut bytes = Vec::new();
    let mut writer = SerializedFileWriter::new(&mut bytes, schema, Arc::new(properties)).unwrap();
    for cells in groups {
        let mut group = writer.next_row_group().unwrap();
        for column in cells {
            let mut out = group.next_column().unwrap().unwrap();
            match column {
                Cells::Doubles(values) => out.typed::<DoubleType>().write_batch(values, None, None),
                Cells::Maybe(values, there) => {
                    out.typed::<DoubleType>()
                        .write_batch(values, Some(there), None)
                }
                Cells::Floats(values) => out.typed::<FloatType>().write_batch(values, None, None),
                Cells::Ints(values) => out.typed::<Int32Type>().write_batch(values, None, None),
                Cells::Longs(values) => out.typed::<Int64Type>().write_batch(values, None, None),
                Cells::Texts(values) => {
                    let values: Vec<ByteArray> = values.iter().map(|text| (*text).into()).collect();
                    out.typed::<ByteArrayType>()
                        .write_batch(&values, None, None)
                }
            }
            .unwrap();
            out.close().unwrap();
        }
        group.close().unwrap();
    }
    writer.close().unwrap();
    bytes
}

const PLAIN: parquet::basic::Compression = parquet::basic::Compression::UNCOMPRESSED;

fn options() -> ReadOptions {
    ReadOptions::default()
}

#[test]
fn every_type_of_number_is_read_in_every_row_group() {
    let schema = "message log {
        required int64 when (TIMESTAMP(NANOS,true));
        required double motor_mm;
        optional double load_um;
        required float current_a;
        required int32 count (INTEGER(32,false));
        required int32 tenths (DECIMAL(5,1));
        required binary name (STRING);
        repeated int32 list;
    }";
    // Past the time from which on seconds in a double lose microseconds.
    let start = 1_700_000_000_000_000_000_i64;
    let group = |from: i64, rows: i64| {
        let row = |of: fn(i64) -> f64| (from..from + rows).map(of).collect::<Vec<f64>>();
        vec![
            Cells::Longs((from..from + rows).map(|n| start + 250_000 * n).collect()),
            Cells::Doubles(row(|n| 0.1 * n as f64)),
            Cells::Maybe(
                row(|n| 100.0 * n as f64).into_iter().skip(1).collect(),
                (0..rows).map(|n| i16::from(n > 0)).collect(),
            ),
            Cells::Floats((from..from + rows).map(|n| n as f32 + 0.5).collect()),
            Cells::Ints((0..rows).map(|n| -1 - n as i32).collect()),
            Cells::Ints((from..from + rows).map(|n| n as i32).collect()),
            Cells::Texts(vec!["a"; rows as usize]),
            // No list has an element: levels of zero would be needed for one.
            Cells::Ints(Vec::new()),
        ]
    };
    // The list's column is empty in a file without rows alone; so it is left out here.
    let schema = schema.replace("        repeated int32 list;\n", "");
    let groups: Vec<Vec<Cells>> = [(0, 1500), (1500, 3)]
        .into_iter()
        .map(|(from, rows)| group(from, rows).into_iter().take(7).collect())
        .collect();
    for compression in [
        PLAIN,
        parquet::basic::Compression::SNAPPY,
        parquet::basic::Compression::LZ4_RAW,
    ] {
        let bytes = file(&schema, &groups, compression);
        let columns = [
            "motor=motor_mm".parse().unwrap(),
            "current=current_a".parse().unwrap(),
        ];
        let log = read_axis(
            bytes.as_slice(),
            "log",
            &AxisOptions {
                columns: columns.to_vec(),
                without: vec![lostmotion_logs::Role::Load],
                ..AxisOptions::default()
            },
        )
        .unwrap();
        assert_eq!(log.time_s.len(), 1503);
        assert!(log.said.iter().any(|said| said.contains("left out: name")));
        for (n, time) in log.time_s.iter().enumerate() {
            assert_eq!(*time, (250_000 * n) as f64 * 1e-9);
            assert_eq!(log.motor[n], 0.1 * n as f64);
            assert_eq!(log.drive.as_ref().unwrap().values()[n], n as f64 + 0.5);
        }
        assert_eq!(log.line[1502], 1503);
        // A null is refused with its row where the column is read.
        let error = whole(&bytes, &options()).err().unwrap();
        assert!(
            error.contains("log, row 1, column `load_um`: `null` is no number"),
            "{error}"
        );
    }
}

#[test]
fn whole_numbers_keep_their_sign_and_scale() {
    let schema = "message log { required double t_s; required int32 count (INTEGER(32,false)); required int32 tenths (DECIMAL(5,1)); required int64 big; }";
    let cells = vec![
        Cells::Doubles(vec![0.0, 1.0]),
        Cells::Ints(vec![-1, 7]),
        Cells::Ints(vec![-15, 20]),
        Cells::Longs(vec![-3, 1 << 40]),
    ];
    let log = whole(&file(schema, &[cells], PLAIN), &options()).unwrap();
    let values: Vec<&[f64]> = log.rows.iter().map(|row| row.values.as_slice()).collect();
    assert_eq!(values[0], [4_294_967_295.0, -1.5, -3.0]);
    assert_eq!(values[1], [7.0, 2.0, 1_099_511_627_776.0]);
    assert_eq!((log.format.as_str(), log.names.len()), ("Parquet", 3));
}

#[test]
fn what_cannot_be_read_is_refused() {
    let schema = "message log { required double t_s; required double motor_mm; }";
    let cells = |last: f64| {
        let ramp: Vec<f64> = (0..99).map(|n| f64::from(n) * 1e-3).chain([last]).collect();
        vec![Cells::Doubles(ramp.clone()), Cells::Doubles(ramp)]
    };
    let good = file(schema, &[cells(1.0)], PLAIN);
    assert_eq!(whole(&good, &options()).unwrap().rows.len(), 100);
    let error = |bytes: &[u8], options: &ReadOptions| whole(bytes, options).err().unwrap();
    // cut anywhere there is no directory
    for length in [4, 8, 100, good.len() - 1] {
        let said = error(&good[..length], &options());
        assert!(said.contains("this Parquet file cannot be read"), "{said}");
    }
    let said = error(&file(schema, &[cells(f64::NAN)], PLAIN), &options());
    assert!(
        said.contains("log, row 100, column `motor_mm`: `NaN` is not a finite number")
            || said.contains("column `t_s`"),
        "{said}"
    );
    let few = ReadOptions {
        max_bytes: 1000,
        ..options()
    };
    assert!(
        error(&good, &few).contains("more than 1000 bytes\nhint: allow more with --max-memory-mb")
    );
    let said = error(
        &file(
            "message log { required double a; required double b; }",
            &[cells(1.0)],
            PLAIN,
        ),
        &options(),
    );
    assert!(
        said.contains("no column of times") && said.contains("a, b"),
        "{said}"
    );
    let said = error(
        &file(
            "message log { required binary a (STRING); }",
            &[vec![Cells::Texts(vec!["x"])]],
            PLAIN,
        ),
        &ReadOptions {
            period_s: Some(1e-3),
            ..options()
        },
    );
    assert!(said.contains("0 columns of numbers"), "{said}");
}

/// Written by pyarrow: 60 rows in groups of 40, pages of some 64 bytes, dictionaries, nulls.
#[test]
fn gzip_and_zstd_are_unpacked() {
    for name in [
        "gzip_pages_1",
        "gzip_pages_2",
        "zstd_pages_1",
        "zstd_pages_2",
    ] {
        let path = format!("{}/tests/packed/{name}.parquet", env!("CARGO_MANIFEST_DIR"));
        let bytes = std::fs::read(path).unwrap();
        let columns = ["motor=motor_mm", "current=current_a"];
        let options = AxisOptions {
            columns: columns.iter().map(|text| text.parse().unwrap()).collect(),
            without: vec![lostmotion_logs::Role::Load],
            ..AxisOptions::default()
        };
        let log = read_axis(bytes.as_slice(), "log", &options).unwrap();
        assert_eq!(log.time_s.len(), 60, "{name}");
        for n in 0..60 {
            assert!((log.time_s[n] - 250e-6 * n as f64).abs() < 1e-12, "{name}");
            assert_eq!(log.motor[n], 0.1 * n as f64, "{name}");
            assert_eq!(log.drive.as_ref().unwrap().values()[n], n as f64 + 0.5);
        }
        // damage is told, wherever it is
        for place in 0..bytes.len() {
            let mut bytes = bytes.clone();
            bytes[place] ^= 0x55;
            let _ = read_axis(bytes.as_slice(), "log", &options);
        }
    }
}
