//! `lostmotion study bench`.

use super::failure;
use crate::args::study::Bench as Args;
use crate::commands::DONE;
use crate::failure::Failure;
use crate::output;
use lostmotion::base::Clock;
use lostmotion::identify::{
    BacklashFit, BacklashLog, FitError, FitSettings, MotorLog, fit_backlash, fit_motor_only,
};
use lostmotion_study::bench::{COUPLERS, Coupler, Recording, run as record};

/// Prints what was set, and what was found by each that looked.
pub(crate) fn run(args: &Args) -> Result<u8, Failure> {
    let couplers = match (args.gap_rad, args.stiffness_nm_per_rad) {
        (Some(gap_rad), Some(stiffness_nm_per_rad)) => vec![Coupler {
            gap_rad,
            stiffness_nm_per_rad,
        }],
        _ => COUPLERS.to_vec(),
    };
    let mut out =
        "| gap, rad | stiffness, N m/rad | `fit`: gap | stiffness | `fit --motor-only`: gap | stiffness | `adaptive`: gap | stiffness | damping |\n"
            .to_owned();
    out.push_str("|--:|--:|--:|--:|--:|--:|--:|--:|--:|\n");
    for coupler in couplers {
        let recording = record(&coupler).map_err(|error| failure(&error))?;
        let found = [with_load(&recording), motor_only(&recording)].map(|fit| shown(&coupler, fit));
        let learned = recording
            .adaptive_gap_rad
            .map_or("-".to_owned(), |gap| off(gap, coupler.gap_rad));
        let (gap, stiffness) = (coupler.gap_rad, coupler.stiffness_nm_per_rad);
        let online = online(
            &coupler,
            recording.axis.motor.inertia_kgm2,
            recording.online,
        );
        out.push_str(&format!(
            "| {gap} | {stiffness} | {} | {learned} | {online} |\n",
            found.join(" | ")
        ));
    }
    output::print(&out)?;
    Ok(DONE)
}

fn with_load(recording: &Recording) -> Result<BacklashFit, FitError> {
    let log = BacklashLog::from_samples(Clock::SERVO.period_s(), &recording.loaded)?;
    fit_backlash(&log, &FitSettings::for_axis(&recording.axis))
}

fn motor_only(recording: &Recording) -> Result<BacklashFit, FitError> {
    let motor = recording
        .towed
        .iter()
        .map(|sample| sample.motor_position)
        .collect();
    let current = recording
        .towed
        .iter()
        .map(|sample| sample.current)
        .collect();
    let log = MotorLog::new(Clock::SERVO.period_s(), motor, current)?;
    fit_motor_only(&log, &FitSettings::for_axis(&recording.axis).motor_only())
}

/// Gap and stiffness off what was set; why there is none.
fn shown(coupler: &Coupler, fit: Result<BacklashFit, FitError>) -> String {
    match fit {
        Ok(fit) => {
            let stiffness = 1.0 / fit.compliance_rad_per_nm;
            format!(
                "{} | {}",
                off(2.0 * fit.half_gap_rad, coupler.gap_rad),
                off(stiffness, coupler.stiffness_nm_per_rad)
            )
        }
        Err(error) => format!("{error} | -"),
    }
}

/// Stiffness and damping off what was set.
fn online(coupler: &Coupler, rotor_kgm2: f64, found: Option<[f64; 2]>) -> String {
    found.map_or("not excited | -".to_owned(), |[stiffness, damping]| {
        let known = if damping.is_finite() {
            off(damping, coupler.damping_nm_s_per_rad(rotor_kgm2))
        } else {
            "not known".to_owned()
        };
        format!("{} | {known}", off(stiffness, coupler.stiffness_nm_per_rad))
    })
}

fn off(found: f64, set: f64) -> String {
    format!("{:+.2} %", 100.0 * (found / set - 1.0))
}
