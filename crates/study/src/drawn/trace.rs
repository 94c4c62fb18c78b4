//! What methods that learn believed, did and missed over a run, and what is true, as CSV.

use super::moment::{AxisTruth, Moment};
use super::run::DrawnFigures;
use lostmotion_report::number::fixed;
use std::fmt::Write;

/// The rows of runs as CSV: what was believed, done and true of each axis, what the control foresees,
/// and what backlash caused.
pub fn trace(methods: &[DrawnFigures]) -> String {
    let mut out = String::new();
    for method in methods.iter().filter(|method| !method.moments.is_empty()) {
        if out.is_empty() {
            out.push_str(&header(&method.truths));
        }
        let start = if method.warm { "warm" } else { "cold" };
        for moment in &method.moments {
            let _ = write!(out, "{},{start},", method.method);
            row(&mut out, moment, &method.truths);
        }
    }
    out
}

fn header(truths: &[AxisTruth]) -> String {
    let mut out = "method,start,t_s,backlash_rms_um,backlash_max_um,corrects,waits,foreseen_rms_without_um,foreseen_rms_with_um,foreseen_max_without_um,foreseen_max_with_um".to_owned();
    for truth in truths {
        for column in [
            "missing",
            "gap_um",
            "gap_deviation_um",
            "gap_used_um",
            "gap_true_um",
            "inertia_over_true",
            "inertia_deviation_over_true",
            "friction_of_rated",
            "friction_deviation_of_rated",
            "friction_true_of_rated",
        ] {
            let _ = write!(out, ",{}_{column}", truth.name);
        }
    }
    out.push('\n');
    out
}

fn row(out: &mut String, moment: &Moment, truths: &[AxisTruth]) {
    // What is not known is an empty field.
    let field = |value: f64, decimals: usize| {
        if value.is_finite() {
            fixed(value, decimals)
        } else {
            String::new()
        }
    };
    let [rms, max] = moment.backlash_um;
    let _ = write!(
        out,
        "{},{},{}",
        fixed(moment.time_s, 3),
        fixed(rms, 4),
        fixed(max, 4)
    );
    match &moment.foreseen {
        None => out.push_str(",,,,,,"),
        Some(foreseen) => {
            let _ = write!(
                out,
                ",{},{}",
                u8::from(foreseen.corrects),
                u8::from(foreseen.waits)
            );
            for value in foreseen.rms_um.iter().chain(&foreseen.max_um) {
                let _ = write!(out, ",{}", fixed(*value, 4));
            }
        }
    }
    for (axis, truth) in moment.axes.iter().zip(truths) {
        let _ = write!(out, ",{}", axis.missing.text());
        for value in axis.gap_um.iter().chain([&truth.gap_um]) {
            let _ = write!(out, ",{}", field(*value, 4));
        }
        let shares = axis.inertia.iter().chain(&axis.friction);
        for value in shares.chain([&truth.friction]) {
            let _ = write!(out, ",{}", field(*value, 6));
        }
    }
    out.push('\n');
}
