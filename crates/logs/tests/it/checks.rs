//! What has to hold for every input: shared by the fuzz targets and by the test that replays their
//! corpus.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a check fails by panicking"
)]

use lostmotion_logs::{
    AxisOptions, BallbarOptions, ColumnSpec, LogReader, PositionOptions, ReadOptions, Row,
    read_axis, read_ballbar, read_positions,
};

/// Bytes of a log that may be held: a file that says that it has more is refused.
const MOST_BYTES: usize = 1 << 20;
/// Rows that are read of one input: each costs memory only while it is held.
const MOST_ROWS: usize = 20_000;

/// Any bytes are read or refused: rows have the channels of their group and finite values, lines
/// never fall, and a message names the file.
pub fn log(bytes: &[u8]) {
    let mut options = ReadOptions {
        max_bytes: MOST_BYTES,
        ..ReadOptions::default()
    };
    // The first byte says what a user may have told.
    let (first, rest) = bytes.split_first().unwrap_or((&0, &[]));
    if first & 1 == 1 {
        options.period_s = Some(1e-3);
    }
    options.tagged = match first & 6 {
        2 => Some(true),
        4 => Some(false),
        _ => None,
    };
    match LogReader::new(rest, "fuzzed", &options) {
        Err(error) => assert!(error.to_string().contains("fuzzed"), "{error}"),
        Ok(mut reader) => rows(&mut reader),
    }
    let columns: Vec<ColumnSpec> = [
        "motor=1,unit=mm",
        "load=2,unit=um,sign=-",
        "current=3,unit=A",
    ]
    .iter()
    .take(usize::from(first >> 5) % 4)
    .filter_map(|spec| spec.parse().ok())
    .collect();
    let options = AxisOptions {
        read: options,
        columns,
        max_rows: MOST_ROWS,
        ..AxisOptions::default()
    };
    if let Ok(log) = read_axis(rest, "fuzzed", &options) {
        assert!(log.time_s.len() >= 3);
        assert!(log.time_s.windows(2).all(|pair| pair[1] > pair[0]));
        assert_eq!(log.motor.len(), log.time_s.len());
        assert!(log.load.is_empty() || log.load.len() == log.time_s.len());
        assert!(log.motor.iter().all(|value| value.is_finite()));
    }
}

fn rows(reader: &mut LogReader<'_>) {
    let header = reader.header().clone();
    assert!(!header.channels.is_empty() && header.groups > 0);
    let widths: Vec<usize> = (0..header.groups)
        .map(|group| header.group(group).count())
        .collect();
    let mut row = Row::default();
    let mut line = 0;
    for _ in 0..MOST_ROWS {
        match reader.next_row(&mut row) {
            Ok(true) => {
                assert_eq!(widths.get(row.group), Some(&row.values.len()));
                assert!(row.line >= line, "lines fall");
                line = row.line;
                assert!(row.time_s.is_finite());
                assert!(row.values.iter().all(|value| value.is_finite()));
            }
            Ok(false) => {
                // The end is the end.
                assert!(matches!(reader.next_row(&mut row), Ok(false)));
                return;
            }
            Err(error) => {
                assert!(error.to_string().contains("fuzzed"), "{error}");
                return;
            }
        }
    }
}

/// As [`log`], with a beginning that only one format has.
fn begun(start: &str, data: &[u8]) {
    let (first, rest) = data.split_first().unwrap_or((&0, &[]));
    let bytes: Vec<u8> = [&[*first], start.as_bytes(), rest].concat();
    log(&bytes);
}

/// HALscope: the first byte also chooses the generation.
pub fn halscope(data: &[u8]) {
    let start = match data.first().unwrap_or(&0) & 8 {
        0 => "# Sampling period is 1000000 ns\n",
        _ => "Sampling period is 1000000 ns \n\n",
    };
    begun(start, data);
}

/// halsampler.
pub fn halsampler(data: &[u8]) {
    begun("0 0.5 1 \n1 0.6 0 \n", data);
}

/// TwinCAT Scope.
pub fn twincat(data: &[u8]) {
    begun(
        "Name\tx\nFile\ty\nStarttime of export\t1\nEndtime of export\t2\n\nName\t",
        data,
    );
}

/// Sinumerik's trace.
pub fn sinumerik(data: &[u8]) {
    begun(
        "<traceSession version=\"1\"><dataSignal id=\"f1\" key=\"s1\" unitsType=\"posn\" name=\"ActPos1stEnc\" interval=\"0.002\"/>",
        data,
    );
}

/// Heidenhain's TNCscope.
pub fn tncscope(data: &[u8]) {
    begun(
        "%TNCscopeNT data file\n%[CURVE1]\n%NAME=s ist/X\n%DIMENSION=mm\n",
        data,
    );
}

/// EPICS' camonitor.
pub fn camonitor(data: &[u8]) {
    begun(
        "P 2026-01-01 00:00:00.0 1\nP 2026-01-01 00:00:01.0 2\n",
        data,
    );
}

/// Accelerometers: the first byte chooses between Klipper and RepRapFirmware.
pub fn accelerometer(data: &[u8]) {
    let start = match data.first().unwrap_or(&0) & 8 {
        0 => "#time,accel_x,accel_y\n",
        _ => "Sample,X,Y\n",
    };
    begun(start, data);
}

/// Positions of several axes: the first byte says what a user may have told.
pub fn positions(data: &[u8]) {
    let (first, rest) = data.split_first().unwrap_or((&0, &[]));
    let text = [
        &b"t_s,x_mm,cmd_pos_y [um],joint.2.pos-cmd,c_deg\n"[..],
        rest,
    ]
    .concat();
    let bytes = if first & 1 == 1 { rest } else { &text };
    let columns = ["x=1,unit=mm", "y=2,unit=inch,sign=-", "time=3"];
    let options = PositionOptions {
        read: ReadOptions {
            period_s: (first & 2 == 2).then_some(1e-3),
            ..ReadOptions::default()
        },
        columns: columns
            .iter()
            .take(usize::from(first >> 5) % 4)
            .filter_map(|spec| spec.parse().ok())
            .collect(),
        axes: lostmotion_base::AxisId::ALL.to_vec(),
        unit: (first & 4 == 4).then(|| "mm".parse().unwrap()),
        max_rows: MOST_ROWS,
        ..PositionOptions::default()
    };
    match read_positions(bytes, "fuzzed", &options) {
        Err(error) => assert!(error.to_string().contains("fuzzed"), "{error}"),
        Ok(log) => {
            assert!(log.time_s.len() >= 3 && log.line.len() == log.time_s.len());
            assert!(log.time_s.windows(2).all(|pair| pair[1] > pair[0]));
            for axis in &log.axes {
                assert_eq!(axis.values.len(), log.time_s.len());
                assert!(axis.values.iter().all(|value| value.is_finite()));
            }
        }
    }
}

/// A ballbar's sheet: the first byte says what a user may have told.
pub fn ballbar(data: &[u8]) {
    let (first, rest) = data.split_first().unwrap_or((&0, &[]));
    let turn: String = (0..40)
        .map(|n| format!("{},{}\n", 9 * n, 100 + n % 3))
        .collect();
    let text = [b"angle_deg,radius_mm\n", turn.as_bytes(), rest].concat();
    let bytes = if first & 1 == 1 { rest } else { &text };
    let columns = ["angle=1,unit=rad", "deviation=2,unit=um"];
    let options = BallbarOptions {
        columns: columns
            .iter()
            .take(usize::from(first >> 6))
            .filter_map(|spec| spec.parse().ok())
            .collect(),
        max_rows: MOST_ROWS,
    };
    match read_ballbar(bytes, "fuzzed", &options) {
        Err(error) => assert!(error.to_string().contains("fuzzed"), "{error}"),
        Ok(sheet) => {
            assert!(!sheet.senses.is_empty());
            for point in sheet.senses.iter().flatten() {
                assert!(point.0.is_finite() && point.1.is_finite());
            }
        }
    }
}

/// Logs that are no text: MCAP and Parquet.
#[allow(dead_code, reason = "a build may read neither")]
pub fn binary(data: &[u8]) {
    log(data);
}

/// Any other table.
pub fn table(data: &[u8]) {
    begun("t_s,motor_mm,load_mm,current_a\n", data);
}
