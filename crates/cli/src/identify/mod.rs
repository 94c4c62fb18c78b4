//! `axis identify`: what a log tells of an axis, a description with the source of every value, and
//! the check of a description against a log.

mod findings;
mod scales;
mod write;

use crate::fits::rad_per_unit;
use crate::logs::{LogInput, axis_unit};
use crate::options::Lateness;
use crate::options::machine::{axis, axis_files};
use crate::output::{self, DONE, FOUND, Failure};
use clap::{Args, ValueHint};
use findings::{Finding, gap_findings};
use lostmotion::base::units::MM_PER_INCH;
use lostmotion::drive::config::AxisUnit;
use lostmotion::identify::body::{
    BodyLog, LostMotion, Motion, Replayed, RigidBody, ServoGains, fit_body, fit_lost_motion,
    fit_servo, replay, times_go_with,
};
use lostmotion::identify::{
    BacklashFit, BacklashLog, Cause, FitError, FitSettings, MotorLog, fit_backlash,
};
use lostmotion::logs::{AxisLog, DriveSignal};
use lostmotion::methods::AxisConfig;
use scales::{Scales, figures, gap_figure, gap_text, with_interval};
use std::path::PathBuf;
use write::{write_axis, write_overlay};

/// `axis identify`.
#[derive(Debug, Args)]
pub(crate) struct Identify {
    #[command(flatten)]
    pub(crate) log: LogInput,
    /// The axis that was logged: its motor and transmission make forces of currents; what the log
    /// does not tell is taken from it
    #[arg(long, value_name = "FILE.toml|PRESET")]
    pub(crate) axis: Option<String>,
    /// Description of the axis to write, with the source of every value beside it
    #[arg(long, short, value_name = "FILE.toml", requires = "axis", value_hint = ValueHint::FilePath)]
    pub(crate) out: Option<PathBuf>,
    /// CSV to write with the measured and the simulated position and their difference
    #[arg(long, value_name = "FILE.csv", value_hint = ValueHint::FilePath)]
    pub(crate) overlay: Option<PathBuf>,
    /// Compare the description with the log: exit code 1 where a value is certainly another one, or
    /// nothing can be compared
    #[arg(long, requires = "axis")]
    pub(crate) check: bool,
    #[command(flatten)]
    pub(crate) lateness: Lateness,
}

/// Part of the Coulomb friction from which on a constant force may keep the load on one flank. A choice: how much of
/// that friction is the motor's own is known to some such part.
const PULLS_SHARE: f64 = 0.2;

/// How far the travel of the motor may be off that of its command in another unit, in parts. A choice: a loop follows
/// to some per cent.
const UNIT_WITHIN: f64 = 0.02;

/// What is said of a log.
#[derive(Default)]
struct Told {
    text: String,
    /// What is not told, and why.
    untold: Vec<String>,
    /// What the description can be held against.
    findings: Vec<Finding>,
    /// What of the description cannot be, in lines.
    contradictions: Vec<String>,
}

impl Told {
    fn lost_motion(&mut self, found: &Result<LostMotion, String>, scales: &Scales) {
        match found {
            Ok(lost) => self.text += &scales.lost(lost),
            Err(reason) => self.untold.push(format!("lost motion: {reason}")),
        }
    }

    /// The gap, of a log whose lost motion is that of a gap or not.
    fn gap(
        &mut self,
        found: &Result<BacklashFit, GapError>,
        lost: &Result<LostMotion, String>,
        body: Option<&RigidBody>,
        described: Option<&AxisConfig>,
        scales: &Scales,
    ) {
        if let Some(why) = body.and_then(|body| uncrossed(found.as_ref().ok()?, body, scales)) {
            self.untold.push(format!("the gap: {why}"));
            return;
        }
        let lost = lost.as_ref().ok();
        let is_step = lost.is_none_or(|lost| lost.is_step);
        let pair = found.as_ref().ok().zip(lost);
        if let Some(why) = pair.and_then(|(fit, lost)| beyond(fit, lost, scales)) {
            self.untold.push(format!("the gap: {why}"));
            return;
        }
        match found {
            Ok(fit) if is_step => {
                self.text += &gap_text(fit, scales);
                let findings = described.map(|axis| gap_findings(fit, axis));
                self.findings.extend(findings.into_iter().flatten());
            }
            Ok(_) => self
                .untold
                .push("the gap: position is lost along the travel, not at once".to_owned()),
            Err(reason) => self.untold.push(format!("gap and stiffness: {reason}")),
        }
    }

    fn body(
        &mut self,
        found: &Result<RigidBody, String>,
        described: Option<&AxisConfig>,
        scales: &Scales,
    ) {
        match found {
            Ok(body) => {
                self.text += &scales.body(body);
                self.untold.extend(body.untold.iter().cloned());
                let findings = described.map(|axis| scales.body_findings(body, axis));
                self.findings.extend(findings.into_iter().flatten());
            }
            Err(reason) => self.untold.push(format!("inertia and friction: {reason}")),
        }
    }

    fn servo(
        &mut self,
        found: &Result<ServoGains, String>,
        described: Option<&AxisConfig>,
        by_current: bool,
        scales: &Scales,
    ) {
        match found {
            Ok(servo) => {
                self.text += &scales.servo(servo);
                self.untold.extend(servo.untold.iter().cloned());
                let findings = described.map(|axis| scales.servo_findings(servo, axis, by_current));
                self.findings.extend(findings.into_iter().flatten());
            }
            Err(reason) => self.untold.push(format!("servo: {reason}")),
        }
    }

    fn replayed(&mut self, again: &Replayed, scales: &Scales) {
        let um = 1.0 / scales.small;
        self.text += &format!(
            "simulated on the log's command: {} {u} RMS off the record, at most {} {u}\n",
            figures(again.rms * um),
            figures(again.largest * um),
            u = scales.small_unit,
        );
    }

    /// Holds the described gap against all that is lost, of which it is a part, where the gap itself is not told.
    fn described_gap(&mut self, lost: &LostMotion, axis: &AxisConfig, scales: &Scales) {
        let told = |finding: &Finding| finding.key.starts_with("gap");
        if self.findings.iter().any(told) {
            return;
        }
        let um = 1.0 / scales.small;
        let gap = axis.gap_in_unit() * scales.base * um;
        let most = lost.total.times(um).interval[1];
        if gap > most {
            self.contradictions.push(format!(
                "gap: described {} {u}, of which a lost motion of at most {} {u} (95 %) leaves no room, unless a weight keeps the load on one flank: DIFFERS\n",
                figures(gap),
                figures(most),
                u = scales.small_unit
            ));
        }
    }

    /// The verdict on each value that can be checked; whether the description is another one.
    fn check(&mut self) -> bool {
        let mut differs = !self.contradictions.is_empty();
        self.text += &self.contradictions.concat();
        for finding in &self.findings {
            let (words, other) = finding.verdict();
            differs |= other;
            self.text += &words;
        }
        if self.findings.is_empty() && !differs {
            self.text += "nothing of the description can be checked with this log\n";
            differs = true;
        }
        differs
    }
}

/// Whether a constant force may keep the load on one flank.
fn pulls(body: &RigidBody) -> bool {
    let of_friction = PULLS_SHARE * body.coulomb.value.abs();
    body.constant.is_told() && body.constant.value.abs() > of_friction
}

/// Why there may be a gap that the log does not tell from zero: what pulls at the load one way, as a weight does,
/// keeps it on one flank.
fn uncrossed(fit: &BacklashFit, body: &RigidBody, scales: &Scales) -> Option<String> {
    (pulls(body) && !fit.excited).then(|| {
        format!(
            "none is seen, but a constant force of {} {} may keep the load on one flank, so that this motion never crosses it: log strokes that speed up and slow down faster than that force does the load",
            figures(body.constant.value),
            scales.drive_unit
        )
    })
}

/// Why a gap cannot be right that is certainly larger than all that is lost, of which it is a part.
fn beyond(fit: &BacklashFit, lost: &LostMotion, scales: &Scales) -> Option<String> {
    let um = 1.0 / scales.small;
    let gap = gap_figure(fit, scales.per_rad).times(um);
    let lost = lost.total.times(um);
    (gap.interval[0] > lost.interval[1]).then(|| {
        let [value, low, high] = with_interval(gap);
        format!(
            "{value} {u} (95 %: {low} to {high}) would be more than the lost motion, of which it is a part, so that one of the two is wrong: the load may be read in another way than is taken off; log strokes of several speeds and lengths",
            u = scales.small_unit
        )
    })
}

/// Runs the command.
pub(crate) fn run(args: &Identify, quiet: bool) -> Result<u8, Failure> {
    let described = args
        .axis
        .as_deref()
        .map(|name| axis(name, &[]))
        .transpose()?;
    let described = described.as_ref();
    let name = args.log.name();
    refuse_outputs(args)?;
    args.log.exists()?;
    let log = args.log.read(&[], &[], quiet)?;
    let unit = axis_unit(&log);
    if let Some(described) = described {
        rad_per_unit(described, unit, &name)?;
    }
    refuse_other_unit(&log, &name)?;
    let scales = Scales::of(&log, unit, described);
    let lateness_s = args.lateness.seconds();
    let (body_log, motion) = body_log(&log, &scales, &name)?;
    let body_log = body_log
        .read_within(lateness_s)
        .map_err(|error| Failure::message(format!("{name}: {error}")))?;
    let body = fit_body(&body_log, &motion);
    refuse_reversed(&body, &scales, &name)?;
    let (gap, doubt) = believed_gap(&log, described, (unit, lateness_s), &name)?;
    let doubt = doubt.or_else(|| scaled_alike(&gap, &body, described, &scales));
    // A long log is not held twice.
    let by_current = matches!(log.drive, Some(DriveSignal::Current(_)));
    drop(log);
    // Lateness that the gap's fit tells would pass for lost motion, too.
    let off = gap.as_ref().ok().and_then(|fit| fit.load_off);
    let body_log = off.into_iter().fold(body_log, BodyLog::with_late_taken_off);
    let mut told = Told {
        text: scales.motion(&motion, &body_log),
        ..Told::default()
    };
    // Lost motion first: it says whether a gap is the right word.
    let lost = fit_lost_motion(&body_log, body.as_ref().ok());
    told.lost_motion(&lost, &scales);
    told.gap(&gap, &lost, body.as_ref().ok(), described, &scales);
    if let (Some(axis), Ok(lost)) = (described, &lost)
        && !body.as_ref().is_ok_and(pulls)
    {
        told.described_gap(lost, axis, &scales);
    }
    told.body(&body, described, &scales);
    let servo = fit_servo(&body_log, &motion);
    told.servo(&servo, described, by_current, &scales);
    let replayed = match (&body, &servo) {
        (Ok(body), Ok(servo)) => replay(&body_log, body, servo),
        _ => None,
    };
    if let Some(again) = &replayed {
        told.replayed(again, &scales);
    }
    for reason in &told.untold {
        told.text += &format!("not told: {reason}\n");
    }
    let differs = args.check && told.check();
    if replayed.is_none() && args.overlay.is_some() {
        output::print(&told.text)?;
        return Err(Failure::with_hint(
            format!("{name}: nothing can be simulated for --overlay"),
            "it needs a command, a current and a servo law that the log obeys",
        ));
    }
    if let (Some(path), Some(again)) = (&args.overlay, &replayed) {
        write_overlay(path, &body_log, again, &scales)?;
    }
    if let (Some(path), Some(described)) = (&args.out, described) {
        let base = args.axis.as_deref().unwrap_or_default();
        if let Some(cause) = &doubt {
            told.text += &format!("not written: what was measured, since {cause}\n");
            told.findings.clear();
        } else if told
            .findings
            .iter()
            .all(|found| found.refused(&name).is_some())
        {
            told.text += "not written: what was measured, since none of it can be taken over\n";
        }
        write_axis(path, described, &told.findings, &name, base)?;
    }
    output::print(&told.text)?;
    Ok(if differs { FOUND } else { DONE })
}

/// Refuses files to write that are read, or are one and the same.
fn refuse_outputs(args: &Identify) -> Result<(), Failure> {
    for out in [&args.out, &args.overlay].into_iter().flatten() {
        output::refuse_input(out, &args.log.log, "log")?;
        output::refuse_inputs(out, axis_files(args.axis.as_deref()))?;
    }
    if let (Some(out), Some(overlay)) = (&args.out, &args.overlay)
        && out == overlay
    {
        let shown = out.display();
        return Err(Failure::message(format!(
            "--out and --overlay are both {shown}"
        )));
    }
    Ok(())
}

/// Refuses a motor whose travel is that of its command in another unit.
fn refuse_other_unit(log: &AxisLog, name: &str) -> Result<(), Failure> {
    let range = |column: &[f64]| {
        let ends = column
            .iter()
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| {
                [low.min(*value), high.max(*value)]
            });
        ends[1] - ends[0]
    };
    let ratio = range(&log.motor) / range(&log.command);
    let is_unit = |factor: f64| (ratio / factor - 1.0).abs() < UNIT_WITHIN;
    let factors = [1e3, 1e6, MM_PER_INCH, 1e3 * MM_PER_INCH];
    if factors
        .iter()
        .any(|factor| is_unit(*factor) || is_unit(factor.recip()))
    {
        return Err(Failure::with_hint(
            format!(
                "{name}: the motor moves {ratio:.6} times as far as its command: they are in different units"
            ),
            "say the unit of each: --column motor=NAME,unit=um --column command=NAME,unit=mm",
        ));
    }
    Ok(())
}

/// The log in the units of the fits, its load put right, and how it moves.
fn body_log(log: &AxisLog, scales: &Scales, name: &str) -> Result<(BodyLog, Motion), Failure> {
    let body_log = scales
        .body_log(log)
        .map_err(|error| Failure::message(format!("{name}: {error}")))?;
    let motion = Motion::of(&body_log);
    times_go_with(&body_log, &motion).map_err(|error| {
        Failure::with_hint(
            format!("{name}: {error}"),
            "say the unit of the times with --column time=NAME,unit=ms (s, ms, us or ns), or the time between rows with --period-ms",
        )
    })?;
    let body_log = body_log.put_right(&motion);
    Ok((body_log, motion))
}

/// Refuses a log in which a sign is reversed.
fn refuse_reversed(
    body: &Result<RigidBody, String>,
    scales: &Scales,
    name: &str,
) -> Result<(), Failure> {
    let Some(body) = body.as_ref().ok().filter(|body| body.is_reversed()) else {
        return Ok(());
    };
    let [inertia, _, _] = with_interval(body.inertia);
    Err(Failure::with_hint(
        format!(
            "{name}: the axis speeds up against what drives it, as if its inertia were {inertia}: the sign of the {drive}, or of the position, is reversed",
            drive = scales.drive_name,
        ),
        format!("turn it round: --column {}=NAME,sign=-", scales.drive_name),
    ))
}

/// The gap, or why there is none, and a unit that may be wrong: that is said, and nothing that hangs on it is
/// taken over. A log in which everything else would be wrong, too, is refused.
fn believed_gap(
    log: &AxisLog,
    described: Option<&AxisConfig>,
    (unit, lateness_s): (AxisUnit, f64),
    name: &str,
) -> Result<(Result<BacklashFit, GapError>, Option<String>), Failure> {
    let found = gap(log, described, (unit, lateness_s), name);
    let doubt = match &found {
        Err(GapError::Fit(error)) if error.is_of_the_log() => {
            return Err(Failure::with_hint(
                format!("{name}: {error}"),
                "say what the columns are with --column ROLE=NAME,unit=UNIT,sign=-,scale=FACTOR; without --axis the log is not held against it",
            ));
        }
        Err(GapError::Fit(FitError::Implausible { cause, .. })) if cause.names_a_unit() => {
            Some(cause.to_string())
        }
        _ => None,
    };
    Ok((found, doubt))
}

/// By how much inertia and friction may be off the description differently, as a ratio, for both to be off by
/// the current's scale. A choice: of another axis the two have nothing to do with each other.
const ALIKE: f64 = 1.15;

/// The current's scale as what is likely wrong, where inertia and friction are off the description alike.
fn scaled_alike(
    gap: &Result<BacklashFit, GapError>,
    body: &Result<RigidBody, String>,
    described: Option<&AxisConfig>,
    scales: &Scales,
) -> Option<String> {
    let is_off = matches!(
        gap,
        Err(GapError::Fit(FitError::Implausible {
            cause: Cause::OtherAxis,
            ..
        }))
    );
    let (axis, body) = (described.filter(|_| is_off)?, body.as_ref().ok()?);
    if !(scales.has_force() && body.is_one_body() && body.coulomb.is_told()) {
        return None;
    }
    let (load, r) = (axis.reflected_load(), scales.per_rad);
    let inertia = (axis.motor_side_inertia_kgm2() + load.inertia_kgm2) / (r * r);
    let coulomb = (axis.motor.coulomb_nm + load.coulomb_nm) / r;
    let apart = (body.inertia.value / inertia) / (body.coulomb.value / coulomb);
    (1.0 / ALIKE..ALIKE)
        .contains(&apart)
        .then(|| Cause::CurrentScale.to_string())
}

/// Why there is no gap.
enum GapError {
    /// What the log or the call lacks.
    Missing(String),
    /// What the fit says.
    Fit(FitError),
}

impl std::fmt::Display for GapError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            GapError::Missing(what) => f.write_str(what),
            GapError::Fit(error) => error.fmt(f),
        }
    }
}

/// The gap as `axis fit` finds it; where the log has none, whether it goes with the axis.
fn gap(
    log: &AxisLog,
    described: Option<&AxisConfig>,
    (unit, lateness_s): (AxisUnit, f64),
    name: &str,
) -> Result<BacklashFit, GapError> {
    let missing = |what: &str| Err(GapError::Missing(what.to_owned()));
    let (Some(axis), Some(drive)) = (described, &log.drive) else {
        return missing("needs the load's position, a current, torque or force, and --axis");
    };
    let scale =
        rad_per_unit(axis, unit, name).map_err(|failure| GapError::Missing(failure.text()))?;
    let scaled = |values: &[f64], factor: f64| -> Vec<f64> {
        values.iter().map(|value| value * factor).collect()
    };
    let settings = FitSettings {
        lateness_s,
        ..FitSettings::for_axis(axis)
    };
    let per_ampere = axis.motor.torque_constant_nm_per_a;
    let (amperes, is_current) = match drive {
        DriveSignal::Current(_) => (1.0, true),
        DriveSignal::Torque(_) => (1.0 / per_ampere, false),
        DriveSignal::Force(_) => (axis.transmission.load_per_motor_rad() / per_ampere, false),
    };
    if !log.load.is_empty() {
        return BacklashLog::from_rows(
            &log.time_s,
            scaled(&log.motor, scale),
            scaled(&log.load, scale),
            scaled(drive.values(), amperes),
        )
        .and_then(|log| fit_backlash(&log, &settings))
        .map_err(|error| match error {
            // A torque or force is in its unit, and the inertia may be another one.
            FitError::Implausible { what, .. } if !is_current && !error.is_of_the_log() => {
                GapError::Missing(format!("the log does not go with the axis: {what}"))
            }
            error => GapError::Fit(error),
        });
    }
    let motor = MotorLog::from_rows(
        &log.time_s,
        scaled(&log.motor, scale),
        scaled(drive.values(), amperes),
    )
    .map_err(GapError::Fit)?;
    match motor.goes_with(&settings) {
        Err(error) if is_current || error.is_of_the_log() => Err(GapError::Fit(error)),
        _ => missing(
            "needs the load's position (a linear scale); `axis fit --motor-only` may tell them from a fast log",
        ),
    }
}
