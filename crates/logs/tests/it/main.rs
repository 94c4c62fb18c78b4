//! Tests of the readers: fixtures for every quirk, bad input, and the collected samples.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    clippy::disallowed_methods,
    reason = "a test says what went wrong by panicking, and std's functions are independent of those under test"
)]

mod axes;
mod bad;
mod ballbar;
#[allow(unreachable_pub, reason = "the fuzzers' crate publishes them")]
mod checks;
mod formats;
#[cfg(feature = "mcap")]
mod mcap;
#[cfg(feature = "parquet")]
mod parquet;
mod positions;
mod replay;
mod samples;
mod tables;

use lostmotion_logs::{LogReader, ReadOptions, Row};

/// A log read whole: what was said, and its rows.
struct Whole {
    format: String,
    names: Vec<String>,
    said: Vec<String>,
    rows: Vec<Row>,
    scale_s: f64,
}

fn whole(bytes: &[u8], options: &ReadOptions) -> Result<Whole, String> {
    let mut reader = LogReader::new(bytes, "log", options).map_err(|error| error.to_string())?;
    let header = reader.header().clone();
    let mut rows = Vec::new();
    let mut row = Row::default();
    while reader
        .next_row(&mut row)
        .map_err(|error| error.to_string())?
    {
        rows.push(row.clone());
    }
    let mut said = header.said;
    said.extend(reader.remarks());
    Ok(Whole {
        format: header.format.to_string(),
        names: header
            .channels
            .into_iter()
            .map(|channel| channel.name)
            .collect(),
        said,
        rows,
        scale_s: reader.time_scale_s(),
    })
}

fn read(text: &str) -> Whole {
    whole(text.as_bytes(), &ReadOptions::default()).unwrap()
}

fn with_period(text: &str) -> Whole {
    let options = ReadOptions {
        period_s: Some(1e-3),
        ..ReadOptions::default()
    };
    whole(text.as_bytes(), &options).unwrap()
}

impl Whole {
    fn says(&self, part: &str) -> bool {
        self.said.iter().any(|said| said.contains(part))
    }
}
