//! MCAP logs, written by the format's own writer, and packed chunks put together by hand.

use crate::{Whole, whole};
use lostmotion_logs::ReadOptions;
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use std::collections::BTreeMap;
use std::io::Write;

/// A topic: its name, the encoding of its messages, its schema's encoding and text.
type Topic<'a> = (&'a str, &'a str, &'a str, &'a str);

/// A message: the place of its topic, its time and its bytes.
type Sent = (usize, u64, Vec<u8>);

/// A file with messages.
fn file(topics: &[Topic<'_>], messages: &[Sent], chunk: Option<u64>) -> Vec<u8> {
    let mut writer = mcap::WriteOptions::new()
        .use_chunks(chunk.is_some())
        .chunk_size(chunk)
        .disable_seeking(true)
        .create(NoSeek::new(Vec::new()))
        .unwrap();
    let mut ids = Vec::new();
    for (topic, encoding, by, text) in topics {
        let schema = writer.add_schema(topic, by, text.as_bytes()).unwrap();
        ids.push(
            writer
                .add_channel(schema, topic, encoding, &BTreeMap::new())
                .unwrap(),
        );
    }
    for (sequence, (topic, time, data)) in messages.iter().enumerate() {
        let header = MessageHeader {
            channel_id: ids[*topic],
            sequence: sequence as u32,
            log_time: *time,
            publish_time: *time,
        };
        writer.write_to_known_channel(&header, data).unwrap();
    }
    writer.finish().unwrap();
    writer.into_inner().into_inner()
}

const START_NS: u64 = 1_700_000_000_000_000_000;

fn axis() -> (Vec<Topic<'static>>, Vec<Sent>) {
    let topics = vec![
        ("axis", "json", "jsonschema", "{}"),
        (
            "/drive",
            "cdr",
            "ros2msg",
            "float64[] current_a\nuint8 state",
        ),
        ("/other", "protobuf", "protobuf", "x"),
    ];
    let mut messages = Vec::new();
    for n in 0..500_u64 {
        let time = START_NS + 1_000_000 * n;
        let text = format!(
            "{{\"motor_mm\":{},\"name\":\"x\",\"on\":{},\"more\":{{\"load_mm\":[{}]}}}}",
            0.125 * n as f64,
            n % 2 == 0,
            0.25 * n as f64
        );
        messages.push((0, time, text.into_bytes()));
        if n % 2 == 0 {
            let mut data = vec![0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0];
            data.extend((-0.5 * n as f64).to_le_bytes());
            data.push(3);
            messages.push((1, time + 250, data));
            messages.push((2, time, vec![1, 2]));
        }
    }
    (topics, messages)
}

fn check(log: &Whole, rows: usize) {
    assert_eq!(log.format, "MCAP");
    let mut names: Vec<&str> = log.names.iter().map(String::as_str).collect();
    names.sort_unstable();
    let expected = [
        "/drive.current_a[0]",
        "/drive.state",
        "axis.more.load_mm[0]",
        "axis.motor_mm",
        "axis.on",
    ];
    assert_eq!(names, expected);
    let axis: Vec<_> = log.rows.iter().filter(|row| row.group == 0).collect();
    let drive: Vec<_> = log.rows.iter().filter(|row| row.group == 1).collect();
    assert_eq!(log.rows.len(), rows);
    let motor = log
        .names
        .iter()
        .position(|name| name == "axis.motor_mm")
        .unwrap();
    for (n, row) in axis.iter().enumerate() {
        assert_eq!(row.values[motor], 0.125 * n as f64);
        assert_eq!(row.time_s, 1e-9 * (1_000_000 * n) as f64);
    }
    for (n, row) in drive.iter().enumerate() {
        assert_eq!(row.values, [-(n as f64), 3.0]);
        assert_eq!(row.time_s, 1e-9 * (2_000_000 * n + 250) as f64);
    }
}

/// The same file with its one chunk packed.
fn packed(name: &str, pack: impl Fn(&[u8]) -> Vec<u8>) -> Vec<u8> {
    let (topics, messages) = axis();
    let bytes = file(&topics, &messages, None);
    // Everything between the header and the end of the data becomes a chunk.
    let header = 9 + u64::from_le_bytes(bytes[9..17].try_into().unwrap()) as usize;
    let mut at = 8 + header;
    let from = at;
    while bytes[at] != 0x0F {
        at += 9 + u64::from_le_bytes(bytes[at + 1..at + 9].try_into().unwrap()) as usize;
    }
    let records = &bytes[from..at];
    let inside = pack(records);
    let mut chunk = Vec::new();
    chunk.extend(0_u64.to_le_bytes());
    chunk.extend(0_u64.to_le_bytes());
    chunk.extend((records.len() as u64).to_le_bytes());
    chunk.extend(0_u32.to_le_bytes());
    chunk.extend((name.len() as u32).to_le_bytes());
    chunk.extend(name.as_bytes());
    chunk.extend((inside.len() as u64).to_le_bytes());
    chunk.extend(inside);
    let mut out = bytes[..from].to_vec();
    out.push(6);
    out.extend((chunk.len() as u64).to_le_bytes());
    out.extend(chunk);
    out.extend(&bytes[at..]);
    out
}

#[test]
fn topics_are_clocks_and_numbers_are_channels() {
    let (topics, messages) = axis();
    for chunk in [None, Some(1 << 10), Some(1 << 20)] {
        let log = whole(&file(&topics, &messages, chunk), &ReadOptions::default()).unwrap();
        check(&log, 750);
        assert_eq!(log.names.len(), 5);
        assert!(log.says("topic `/other` is left out: its messages are in `protobuf`"));
    }
}

#[test]
fn packed_chunks_are_read() {
    let lz4 = packed("lz4", |records| {
        let mut encoder = lz4_flex::frame::FrameEncoder::new(Vec::new());
        encoder.write_all(records).unwrap();
        encoder.finish().unwrap()
    });
    let zstd = packed("zstd", |records| {
        let level = ruzstd::encoding::CompressionLevel::Fastest;
        ruzstd::encoding::compress_to_vec(records, level)
    });
    for bytes in [&lz4, &zstd, &packed("", <[u8]>::to_vec)] {
        check(&whole(bytes, &ReadOptions::default()).unwrap(), 750);
    }
    let other = packed("xz", <[u8]>::to_vec);
    let said = whole(&other, &ReadOptions::default()).err().unwrap();
    assert!(
        said.contains("compressed with `xz`\nhint: lz4 and zstd are read"),
        "{said}"
    );
    let few = ReadOptions {
        max_bytes: 2000,
        ..ReadOptions::default()
    };
    let said = whole(&lz4, &few).err().unwrap();
    assert!(
        said.contains("2000 are allowed\nhint: allow more with --max-memory-mb"),
        "{said}"
    );
    // a size that is not that of what was packed
    let mut wrong = lz4.clone();
    let at = wrong.windows(3).position(|three| three == b"lz4").unwrap() - 16;
    wrong[at] ^= 1;
    assert!(whole(&wrong, &ReadOptions::default()).is_err());
}

/// A recording that was killed: what is whole is read, and it is said.
#[test]
fn a_cut_file_gives_what_is_whole() {
    let (topics, messages) = axis();
    let bytes = file(&topics, &messages, None);
    let log = whole(&bytes[..bytes.len() / 2], &ReadOptions::default()).unwrap();
    assert!(log.says("the file ends within a record") && log.rows.len() > 100);
    check(&log, log.rows.len());
    for length in 0..200 {
        let said = whole(&bytes[..length], &ReadOptions::default())
            .err()
            .unwrap();
        assert!(said.contains("log"), "{said}");
    }
}

#[test]
fn faults_are_told_with_their_message() {
    let topic = [("axis", "json", "jsonschema", "{}")];
    let said = |texts: &[&str]| {
        let messages: Vec<_> = texts
            .iter()
            .enumerate()
            .map(|(n, text)| (0, n as u64, text.as_bytes().to_vec()))
            .collect();
        whole(&file(&topic, &messages, None), &ReadOptions::default())
    };
    let error = said(&["{\"a\":1}", "{\"a\":null}"]).err().unwrap();
    assert!(error.contains("log, message 2, column `axis.a`"), "{error}");
    let error = said(&["{\"a\":1}", "{\"a\":"]).err().unwrap();
    assert!(
        error.contains("log, message 2: topic `axis`: the message is no JSON"),
        "{error}"
    );
    let error = said(&["{\"a\":\"text\"}"]).err().unwrap();
    assert!(error.contains("0 channels of numbers"), "{error}");
    let error = whole(
        &file(
            &[("x", "protobuf", "protobuf", "x")],
            &[(0, 0, vec![1])],
            None,
        ),
        &ReadOptions::default(),
    );
    let error = error.err().unwrap();
    assert!(
        error.contains("`x` is left out: its messages are in `protobuf`"),
        "{error}"
    );
    let short = [("x", "cdr", "ros2msg", "float64 data")];
    let error = whole(
        &file(&short, &[(0, 0, vec![0, 1, 0, 0, 1])], None),
        &ReadOptions::default(),
    );
    let error = error.err().unwrap();
    assert!(
        error.contains("message 1: topic `x`: the message is shorter"),
        "{error}"
    );
}
