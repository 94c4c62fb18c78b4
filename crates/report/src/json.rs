//! Results as JSON.
//!
//! The Rust structs are the schema: [`lostmotion_sim::results`] says what each field means, and
//! `docs/book/src/reference/json.md` tells it to people who do not read Rust. The number `schema` rises
//! only when a field changes its meaning or goes away. Numbers are cut to what is meaningful:
//! values in um and mdeg to 1e-4, all others to 1e-6 of their unit. NaN and infinity have no JSON
//! form and come out as `null`.

use crate::number::round_to;
use serde::Serialize;
use serde_json::ser::{Formatter, PrettyFormatter};
use std::io::{self, Write};

/// Decimals of errors, um and mdeg: 0.1 nm.
const ERROR_DECIMALS: usize = 4;
/// Decimals of everything else: 1 us, 1 nm, 1e-6 deg.
const OTHER_DECIMALS: usize = 6;

/// Writes a value as indented JSON with a final newline.
///
/// # Errors
/// Those of the writer.
pub fn write(out: &mut dyn Write, value: &impl Serialize) -> io::Result<()> {
    write_with(out, value, Rounding::default())
}

/// The same with every number cut to nine significant digits: for figures of any size, such as a
/// fit's.
///
/// # Errors
/// Those of the writer.
pub fn write_significant(out: &mut dyn Write, value: &impl Serialize) -> io::Result<()> {
    write_with(
        out,
        value,
        Rounding {
            significant: true,
            ..Rounding::default()
        },
    )
}

fn write_with(out: &mut dyn Write, value: &impl Serialize, rounding: Rounding) -> io::Result<()> {
    let mut serializer = serde_json::Serializer::with_formatter(&mut *out, rounding);
    value.serialize(&mut serializer)?;
    out.write_all(b"\n")
}

/// Writes each number with the decimals that its key calls for.
///
/// serde_json tells a formatter about keys and numbers separately, so the key last seen is kept,
/// one a level.
#[derive(Default)]
struct Rounding {
    pretty: PrettyFormatter<'static>,
    significant: bool,
    in_key: bool,
    key: Vec<u8>,
    levels: Vec<Option<usize>>,
    pending: Option<usize>,
}

impl Rounding {
    fn open(&mut self) {
        let level = self.pending.or(self.levels.last().copied().flatten());
        self.levels.push(level);
        self.pending = None;
    }

    fn close(&mut self) {
        self.levels.pop();
        self.pending = None;
    }

    fn decimals(&self) -> usize {
        self.pending
            .or(self.levels.last().copied().flatten())
            .unwrap_or(OTHER_DECIMALS)
    }
}

/// The decimals that a key stands for, none where it inherits those of what it lies in.
fn decimals_of(key: &[u8]) -> Option<usize> {
    const ERRORS: [&[u8]; 9] = [
        b"cutting",
        b"rapid",
        b"backlash",
        b"without_gap",
        b"command",
        b"following",
        b"following_without_gap",
        b"gap",
        b"servo",
    ];
    if ERRORS.contains(&key) || key.ends_with(b"_um") || key.ends_with(b"_mdeg") {
        return Some(ERROR_DECIMALS);
    }
    let is_unit = [
        &b"_s"[..],
        b"_mm",
        b"_ratio",
        b"_velocity",
        b"_deg",
        b"_rad",
    ]
    .iter()
    .any(|unit| key.ends_with(unit));
    (is_unit || key == b"range").then_some(OTHER_DECIMALS)
}

fn nine_digits(value: f64) -> f64 {
    format!("{value:.8e}").parse().unwrap_or(value)
}

impl Formatter for Rounding {
    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        let cut = if self.significant {
            nine_digits(value)
        } else {
            round_to(value, self.decimals())
        };
        self.pretty.write_f64(writer, cut)
    }

    fn write_string_fragment<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        fragment: &str,
    ) -> io::Result<()> {
        if self.in_key {
            self.key.extend_from_slice(fragment.as_bytes());
        }
        self.pretty.write_string_fragment(writer, fragment)
    }

    fn begin_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open();
        self.pretty.begin_array(writer)
    }

    fn end_array<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close();
        self.pretty.end_array(writer)
    }

    fn begin_array_value<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        self.pretty.begin_array_value(writer, first)
    }

    fn end_array_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.pretty.end_array_value(writer)
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.open();
        self.pretty.begin_object(writer)
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.close();
        self.pretty.end_object(writer)
    }

    fn begin_object_key<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        self.in_key = true;
        self.key.clear();
        self.pretty.begin_object_key(writer, first)
    }

    fn end_object_key<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.in_key = false;
        self.pending = decimals_of(&self.key);
        self.pretty.end_object_key(writer)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.pretty.begin_object_value(writer)
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.pretty.end_object_value(writer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Serialize)]
    struct Inner {
        max: f64,
        time_s: f64,
    }

    #[derive(Serialize)]
    struct Outer {
        cutting: Inner,
        at_mm: [f64; 2],
        parts_um: [f64; 1],
        none: f64,
        count: u64,
    }

    #[test]
    fn small_figures_keep_their_digits_where_asked_for() {
        let mut out = Vec::new();
        write_significant(
            &mut out,
            &[0.000_012_345_678_912_3, -1.0, 123_456.789_012_3],
        )
        .unwrap();
        let text: String = String::from_utf8(out).unwrap().split_whitespace().collect();
        assert_eq!(text, "[0.0000123456789,-1.0,123456.789]");
    }

    #[test]
    fn numbers_are_cut_by_their_unit() {
        let value = Outer {
            cutting: Inner {
                max: 1.234_567_89,
                time_s: 0.123_456_78,
            },
            at_mm: [-0.000_000_01, 2.000_000_4],
            parts_um: [0.000_04],
            none: f64::NAN,
            count: 3,
        };
        let mut out = Vec::new();
        write(&mut out, &value).unwrap();
        let text: String = String::from_utf8(out).unwrap().split_whitespace().collect();
        assert_eq!(
            text,
            r#"{"cutting":{"max":1.2346,"time_s":0.123457},"at_mm":[0.0,2.0],"parts_um":[0.0],"none":null,"count":3}"#
        );
    }
}
