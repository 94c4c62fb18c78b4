//! Results as JSON.
//!
//! The Rust structs are the schema: [`lostmotion_sim::results`] says what each field means, and
//! `docs/book/src/reference/json.md` tells it to people who do not read Rust. The number `schema`
//! rises only when a field changes its meaning or goes away. Numbers are cut to what is meaningful,
//! by one table of keys: errors in um and mdeg to 1e-4, all others to 1e-6 of their unit. NaN and
//! infinity have no JSON
//! form and come out as `null`.

use crate::number::round_to;
use lostmotion_sim::Run;
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

/// Writes the answer of a run as the command does: several methods side by side, or the one.
///
/// # Errors
/// Those of the writer.
pub fn write_answer(out: &mut dyn Write, run: &Run, compared: bool) -> io::Result<()> {
    match (!compared).then(|| run.clone().into_single()).flatten() {
        Some(single) => write(out, &single),
        None => write(out, run),
    }
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
        // A list or table takes its own key's decimals, else those of what it lies in.
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

/// What is kept of the numbers under a key.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Keep {
    /// [`ERROR_DECIMALS`], and the same in what lies in it.
    Error,
    /// [`OTHER_DECIMALS`], and the same in what lies in it.
    Other,
    /// As in what it lies in.
    Inherit,
}

/// Every key of the results that holds numbers with a fraction, and what is kept of them. A test
/// finds those that are missing; a key that is not here keeps [`OTHER_DECIMALS`] or what it lies
/// in.
const KEYS: &[(&str, Keep)] = &[
    // statistics: the key that they stand under says what of
    ("max", Keep::Inherit),
    ("rms", Keep::Inherit),
    ("interval", Keep::Inherit),
    ("p50", Keep::Inherit),
    ("p95", Keep::Inherit),
    ("p99", Keep::Inherit),
    ("p999", Keep::Inherit),
    // errors: um and mdeg
    ("after", Keep::Error),
    ("allowed", Keep::Error),
    ("allowed_um", Keep::Error),
    ("apart_rms_um", Keep::Error),
    ("backlash", Keep::Error),
    ("backlash_um", Keep::Error),
    ("before", Keep::Error),
    ("bow_limit_um", Keep::Error),
    ("center_um", Keep::Error),
    ("command", Keep::Error),
    ("cutting", Keep::Error),
    ("d_um", Keep::Error),
    ("deviation_max_um", Keep::Error),
    ("deviation_plus_minus_um", Keep::Error),
    ("deviation_rms_um", Keep::Error),
    ("deviation_um", Keep::Error),
    ("f_um", Keep::Error),
    ("following", Keep::Error),
    ("following_without_gap", Keep::Error),
    ("gap", Keep::Error),
    ("g_both_um", Keep::Error),
    ("g_um", Keep::Error),
    ("h_um", Keep::Error),
    ("left_um", Keep::Error),
    ("lost_motion_um", Keep::Error),
    ("max_um", Keep::Error),
    ("mean_um", Keep::Error),
    ("mismatch_um", Keep::Error),
    ("orientation_mdeg", Keep::Error),
    ("parts_um", Keep::Error),
    ("peak_um", Keep::Error),
    ("rapid", Keep::Error),
    ("rms_um", Keep::Error),
    ("scale_um_m", Keep::Error),
    ("servo", Keep::Error),
    ("skew_um", Keep::Error),
    ("spike_um", Keep::Error),
    ("squareness_um_m", Keep::Error),
    ("step_um", Keep::Error),
    ("tolerance_um", Keep::Error),
    ("value", Keep::Error),
    ("without_gap", Keep::Error),
    // times in s, places and lengths in mm or deg, ratios, forces in N
    ("angle_deg", Keep::Other),
    ("at_limit", Keep::Other),
    ("at_limit_s", Keep::Other),
    ("at_mm", Keep::Other),
    ("cutting_force_n", Keep::Other),
    ("cutting_mm", Keep::Other),
    ("cutting_s", Keep::Other),
    ("deviation_s", Keep::Other),
    ("duration_s", Keep::Other),
    ("dwell_s", Keep::Other),
    ("feed_mm_min", Keep::Other),
    ("following_error", Keep::Other),
    ("found", Keep::Other),
    ("from_s", Keep::Other),
    ("limit", Keep::Other),
    ("noise", Keep::Other),
    ("over_s", Keep::Other),
    ("overload", Keep::Other),
    ("peak_current_ratio", Keep::Other),
    ("peak_velocity", Keep::Other),
    ("period_s", Keep::Other),
    ("plan_s", Keep::Other),
    ("plus_minus", Keep::Other),
    ("radius_mm", Keep::Other),
    ("range", Keep::Other),
    ("rapid_mm", Keep::Other),
    ("rapid_s", Keep::Other),
    ("saved_s", Keep::Other),
    ("saved_share", Keep::Other),
    ("share", Keep::Other),
    ("shift_error_mm", Keep::Other),
    ("shift_mm", Keep::Other),
    ("spindle_event_s", Keep::Other),
    ("start_s", Keep::Other),
    ("step", Keep::Other),
    ("time_s", Keep::Other),
    ("times", Keep::Other),
    ("to_s", Keep::Other),
    ("tool_change_s", Keep::Other),
    ("total_s", Keep::Other),
    ("travel", Keep::Other),
];

/// The decimals that a key stands for; `None` where it inherits those of what it lies in.
fn decimals_of(key: &[u8]) -> Option<usize> {
    let known = KEYS.iter().find(|(name, _)| name.as_bytes() == key);
    match known.map(|(_, keep)| keep) {
        Some(Keep::Error) => Some(ERROR_DECIMALS),
        Some(Keep::Other) => Some(OTHER_DECIMALS),
        Some(Keep::Inherit) | None => None,
    }
}

/// Whether the rounding of a key's numbers has been decided, rather than left to the default.
pub fn is_known_key(key: &str) -> bool {
    KEYS.iter().any(|(name, _)| *name == key)
}

fn nine_digits(value: f64) -> f64 {
    // One digit before the point and eight behind it.
    format!("{value:.8e}").parse().unwrap_or(value)
}

impl Formatter for Rounding {
    fn write_f64<W: ?Sized + Write>(&mut self, writer: &mut W, value: f64) -> io::Result<()> {
        // Rounded here, after serde: the structs keep every bit.
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
        // serde_json hands keys over as strings, too: only those between the marks of a key are
        // kept.
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
