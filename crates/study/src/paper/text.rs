//! The paper's claims, our results, and the conditions under which both agree, as Markdown and CSV.

use super::CLAIM;
use super::outlook::{self, ShaftTrial};
use super::trial::{
    DISTANCE_RAD, FORMS, LAMBDA, Outcome, P0, Scan, ScanPoint, Trials, VELOCITY_RAD_S,
};
use lostmotion_methods::MethodId;
use lostmotion_report::number::{fixed, percent};
use std::fmt::Write;

/// Writing to a `String` cannot fail.
macro_rules! put {
    ($out:expr, $($arg:tt)*) => { let _ = writeln!($out, $($arg)*); };
}

/// The result as Markdown.
pub fn markdown(trials: &Trials, scan: &Scan, shafts: &[ShaftTrial]) -> String {
    let mut out = String::new();
    let (trial, motion) = (&trials.trial, &trials.trial.motion);
    put!(out, "# The paper's experiments, again\n");
    put!(
        out,
        "Gan, Wang, Huang, *Adaptive Backlash Compensation for CNC Machining Applications*, Machines 2023, 11(2), 193, Figures 3 and 7 to 11."
    );
    put!(out, "Made by `lostmotion study paper`; do not edit.\n");
    // What the paper gives, then what it leaves open and was chosen here.
    put!(
        out,
        "Given by the paper (Tables 2 and 3): motor, inertias, shaft, total gap 0.2 rad, all gains and periods."
    );
    put!(
        out,
        "Not given, and chosen here: the move ({} rad and back at {} rad/s, {} rad/s2, {} rad/s3),",
        motion.distance_rad,
        motion.velocity_rad_s,
        motion.acceleration_rad_s2,
        motion.jerk_rad_s3
    );
    put!(
        out,
        "P0 = {}, lambda = {}, current limit and bus voltage (so wide that they are not met), encoder (ideal), friction of the load (none).\n",
        trial.p0,
        trial.lambda
    );
    put!(
        out,
        "| method | settled offset (reference minus load) there, mrad | back, mrad | error of the estimate there | back | RMS of what the gap adds, of none | largest, of none |"
    );
    put!(out, "|---|--:|--:|--:|--:|--:|--:|");
    for (name, outcome, _) in &trials.runs {
        row(&mut out, *name, outcome, trials.half_gap_rad);
    }
    put!(
        out,
        "\nThe paper: the estimate stays \"within +-0.1 rad with an error less than 15 %\", \"hence\" the position error with compensation is, too. Ours: see the table. It holds"
    );
    put!(
        out,
        "for the load at rest and for the estimate, not on the way: with the paper's P position loop and no feed-forward the peak after a change of flank stays.\n"
    );
    put!(
        out,
        "## For which P0 and lambda does \"less than {}\" hold?\n",
        percent(CLAIM)
    );
    put!(
        out,
        "Larger settled offset in per cent of half the gap; bold where offset and estimate are below {}. `-`: ran away.\n",
        percent(CLAIM)
    );
    // The settings that the paper leaves open, on the chosen move; further down the moves.
    for form in FORMS {
        grid(
            &mut out,
            form,
            ("lambda", &LAMBDA, |p| p.trial.lambda),
            ("P0", &P0, |p| p.trial.p0),
            &scan.tuning,
        );
    }
    put!(
        out,
        "## And for which move (P0 = {}, lambda = {})?\n\nAcceleration 10 times and jerk 200 times the speed, per s and s2.\n",
        trial.p0,
        trial.lambda
    );
    for form in FORMS {
        let distance = (
            "distance, rad",
            &DISTANCE_RAD[..],
            (|p| p.trial.motion.distance_rad) as fn(&ScanPoint) -> f64,
        );
        let velocity = (
            "speed, rad/s",
            &VELOCITY_RAD_S[..],
            (|p| p.trial.motion.velocity_rad_s) as fn(&ScanPoint) -> f64,
        );
        grid(&mut out, form, distance, velocity, &scan.motion);
    }
    out.push_str(&outlook::markdown(shafts));
    conclusion(&mut out, scan);
    out
}

fn row(out: &mut String, name: MethodId, outcome: &Outcome, half_gap: f64) {
    let [there, back] = outcome.offset_rad.map(|rad| fixed(1e3 * rad, 1));
    // In parts of half the gap, as the paper's 15 %.
    let estimate = outcome.estimate_error_rad.map(|error| {
        if error.is_finite() {
            percent(error.abs() / half_gap)
        } else {
            "-".to_owned()
        }
    });
    put!(
        out,
        "| `{name}` | {there} | {back} | {} | {} | {} | {} |",
        estimate[0],
        estimate[1],
        percent(outcome.rms_ratio),
        percent(outcome.max_ratio)
    );
}

/// Offset beyond which an estimate has run away, half gaps: how far says nothing. A choice.
const RUNAWAY_HALF_GAPS: f64 = 20.0;

/// One side of a table: its name, its values, and the value of a point.
type Side<'a> = (&'a str, &'a [f64], fn(&ScanPoint) -> f64);

/// Columns by rows.
fn grid(out: &mut String, form: MethodId, columns: Side<'_>, rows: Side<'_>, points: &[ScanPoint]) {
    let ((across, values, column), (down, steps, row)) = (columns, rows);
    // The values come back as they were given: this only avoids comparing floats for equality.
    let same = |a: f64, b: f64| (a - b).abs() < 1e-9 * b.abs();
    put!(out, "`{form}`\n");
    put!(
        out,
        "| {down} \\ {across} | {} |",
        values
            .iter()
            .map(ToString::to_string)
            .collect::<Vec<_>>()
            .join(" | ")
    );
    put!(out, "|--:|{}", "--:|".repeat(values.len()));
    for step in steps {
        // Bold where the claim holds; a runaway offset is not printed.
        let cell = |value: &f64| {
            let point = points
                .iter()
                .find(|p| p.method == form && same(column(p), *value) && same(row(p), *step));
            match point {
                Some(point) if point.offset > RUNAWAY_HALF_GAPS || !point.offset.is_finite() => {
                    "-".to_owned()
                }
                Some(point) if point.holds() => format!("**{}**", percent(point.offset)),
                Some(point) => percent(point.offset),
                None => String::new(),
            }
        };
        put!(
            out,
            "| {step} | {} |",
            values.iter().map(cell).collect::<Vec<_>>().join(" | ")
        );
    }
    put!(out, "");
}

/// How many of the scanned points hold the claim.
fn conclusion(out: &mut String, scan: &Scan) {
    put!(out, "## In short\n");
    for form in FORMS {
        let count = |points: &[ScanPoint]| {
            let of_form: Vec<&ScanPoint> =
                points.iter().filter(|point| point.method == form).collect();
            (
                of_form.iter().filter(|point| point.holds()).count(),
                of_form.len(),
            )
        };
        let ((tuned, tunings), (moved, moves)) = (count(&scan.tuning), count(&scan.motion));
        put!(
            out,
            "- `{form}`: \"less than 15 %\" holds at {tuned} of {tunings} pairs of P0 and lambda, and for {moved} of {moves} moves."
        );
    }
}

/// The scan as CSV, a row a point.
pub fn csv(scan: &Scan) -> String {
    let mut out = "method,p0,lambda,distance_rad,velocity_rad_s,offset_there_rad,offset_back_rad,estimate_error_there_rad,estimate_error_back_rad,rms_ratio,max_ratio,holds\n".to_owned();
    for point in scan.tuning.iter().chain(&scan.motion) {
        let (trial, outcome) = (&point.trial, &point.outcome);
        let ([a, b], [c, d]) = (outcome.offset_rad, outcome.estimate_error_rad);
        let _ = write!(
            out,
            "{},{},{},{},{}",
            point.method,
            trial.p0,
            trial.lambda,
            trial.motion.distance_rad,
            trial.motion.velocity_rad_s
        );
        // With exponents: a settled offset and one that ran away lie many decades apart.
        put!(
            out,
            ",{a:.6e},{b:.6e},{c:.6e},{d:.6e},{:.6e},{:.6e},{}",
            outcome.rms_ratio,
            outcome.max_ratio,
            point.holds()
        );
    }
    out
}
