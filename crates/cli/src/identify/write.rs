//! Files of `axis identify`: the overlay, and the description with the source of every value.

use super::findings::{Finding, STRIBECK_TABLE};
use super::scales::{Scales, with_interval};
use crate::output::{self, Failure};
use lostmotion::drive::config::{FrictionLaw, Load, Stribeck};
use lostmotion::identify::body::{BodyLog, Replayed};
use lostmotion::methods::AxisConfig;
use lostmotion::report::WriteError;
use lostmotion::sim::machine::axis_to_toml;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;

/// Keys of a gap.
const GAP_KEYS: [&str; 3] = ["gap_um", "gap_mdeg", "gap_rad"];

pub(super) fn write_overlay(
    path: &Path,
    log: &BodyLog,
    again: &Replayed,
    scales: &Scales,
) -> Result<(), Failure> {
    let mut file = output::create(path)?;
    let unwritten = |error| Failure::from(WriteError::io("write", path, error));
    let unit = scales.unit.symbol();
    let mut text = format!("t_s,motor_{unit},simulated_{unit},difference_{unit}\n");
    for (sample, (measured, simulated)) in log.motor.iter().zip(&again.position).enumerate() {
        let (measured, simulated) = (measured / scales.base, simulated / scales.base);
        text += &format!(
            "{:.6},{measured:.9},{simulated:.9},{:.9}\n",
            sample as f64 * log.period_s,
            simulated - measured
        );
        if text.len() > 1 << 16 {
            file.write_all(text.as_bytes()).map_err(unwritten)?;
            text.clear();
        }
    }
    file.write_all(text.as_bytes()).map_err(unwritten)?;
    file.commit()?;
    Ok(())
}

/// Writes the description with what was found, each value with its source.
pub(super) fn write_axis(
    path: &Path,
    described: &AxisConfig,
    findings: &[Finding],
    log: &str,
    base: &str,
) -> Result<(), Failure> {
    let mut axis = described.clone();
    let mut sources: BTreeMap<(&str, &str), String> = BTreeMap::new();
    for finding in findings {
        let refused = finding.refused(log);
        let source = if let Some(why) = refused {
            format!("{base}; {why}")
        } else if set(&mut axis, finding) {
            let [_, low, high] = with_interval(finding.measured);
            if GAP_KEYS.contains(&finding.key) {
                axis.compensation.gap_uncertainty = rounded_up(finding.measured.uncertainty());
                sources.insert(
                    ("compensation", "gap_uncertainty"),
                    "the longer half of the gap's interval".to_owned(),
                );
            }
            format!("measured: {log}, 95 %: {low} to {high}")
        } else {
            format!("{base}; {log} does not tell it")
        };
        sources.insert((finding.table, finding.key), source);
    }
    axis.check()
        .map_err(|error| Failure::message(format!("{log}: the axis found is none: {error}")))?;
    let plain = axis_to_toml(&axis).map_err(|error| Failure::message(error.to_string()))?;
    let taken = findings.iter().any(|found| found.refused(log).is_none());
    let mut text = if taken {
        format!(
            "# From {log} by `lostmotion axis identify`; what it does not tell is from {base}.\n"
        )
    } else {
        format!(
            "# Nothing measured in {log} was taken over by `lostmotion axis identify`: all of it is from {base}.\n"
        )
    };
    let mut table = String::new();
    for line in plain.lines() {
        text += line;
        if let Some(name) = line.strip_prefix('[') {
            table = name.trim_matches(['[', ']']).to_owned();
        } else if let Some((key, value)) = line.split_once(" = ")
            && !value.ends_with(['[', '{', ','])
        {
            let source = sources
                .get(&(table.as_str(), key))
                .map_or(base, String::as_str);
            text += &format!(" # {source}");
        }
        text.push('\n');
    }
    let mut file = output::create(path)?;
    file.write_all(text.as_bytes())
        .map_err(|error| WriteError::io("write", path, error))?;
    file.commit()?;
    Ok(())
}

/// To a thousandth.
fn rounded_up(part: f64) -> f64 {
    (part * 1e3).ceil() / 1e3
}

/// Sets a value of the description; false where it has none of the kind.
fn set(axis: &mut AxisConfig, finding: &Finding) -> bool {
    let value = finding.measured.value;
    if finding.table == STRIBECK_TABLE {
        return set_stribeck(axis, finding.key, value);
    }
    if let FrictionLaw::Lugre(law) = &mut axis.friction.load
        && finding.table == "friction.load.lugre"
    {
        let place = if finding.key == "static_factor" {
            &mut law.static_factor
        } else {
            &mut law.speed_units_s
        };
        *place = value;
        return true;
    }
    let place = match (finding.key, &mut axis.load) {
        ("position_gain_per_s", _) => &mut axis.drive.position_gain_per_s,
        ("velocity_feedforward", _) => &mut axis.drive.velocity_feedforward,
        ("velocity_time_s", _) => &mut axis.drive.velocity_time_s,
        ("velocity_gain_a_s_per_rad", _) => &mut axis.drive.velocity_gain_a_s_per_rad,
        ("mass_kg", Load::Slide(load)) => &mut load.mass_kg,
        ("viscous_n_s_per_m", Load::Slide(load)) => &mut load.viscous_n_s_per_m,
        ("coulomb_n", Load::Slide(load)) => &mut load.coulomb_n,
        ("constant_n", Load::Slide(load)) => &mut load.constant_n,
        ("gap_um", Load::Slide(load)) => &mut load.gap_um,
        ("stiffness_n_per_um", Load::Slide(load)) => &mut load.stiffness_n_per_um,
        ("inertia_kgm2", Load::Table(load)) => &mut load.inertia_kgm2,
        ("viscous_nm_s_per_rad", Load::Table(load)) => &mut load.viscous_nm_s_per_rad,
        ("coulomb_nm", Load::Table(load)) => &mut load.coulomb_nm,
        ("constant_nm", Load::Table(load)) => &mut load.constant_nm,
        ("gap_mdeg", Load::Table(load)) => &mut load.gap_mdeg,
        ("inertia_kgm2", Load::Reflected(load)) => &mut load.inertia_kgm2,
        ("viscous_nm_s_per_rad", Load::Reflected(load)) => &mut load.viscous_nm_s_per_rad,
        ("coulomb_nm", Load::Reflected(load)) => &mut load.coulomb_nm,
        ("constant_nm", Load::Reflected(load)) => &mut load.constant_nm,
        ("gap_rad", Load::Reflected(load)) => &mut load.gap_rad,
        _ => return false,
    };
    *place = value;
    true
}

/// Sets a value of friction that falls with speed; a plain friction becomes one.
fn set_stribeck(axis: &mut AxisConfig, key: &str, value: f64) -> bool {
    let mut law = match axis.friction.load {
        FrictionLaw::Stribeck(law) => law,
        _ => Stribeck {
            static_factor: 1.0,
            speed_units_s: f64::NAN,
        },
    };
    match key {
        "static_factor" => law.static_factor = value,
        _ => law.speed_units_s = value,
    }
    axis.friction.load = FrictionLaw::Stribeck(law);
    true
}
