//! What has to hold for every input: shared by the fuzz targets and by the test that replays their
//! corpus.

use lostmotion_logs::{AxisOptions, ColumnSpec, LogReader, ReadOptions, Row, read_axis};

/// Rows that are read of one input: each costs memory only while it is held.
const MOST_ROWS: usize = 20_000;

/// Any bytes are read or refused: rows have the channels of their group and finite values, lines
/// never fall, and a message names the file.
pub fn log(bytes: &[u8]) {
    let mut options = ReadOptions::default();
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
