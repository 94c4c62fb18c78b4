//! What a control is told of a machine, and the machine with other gaps than it is told.

use super::RecommendOptions;
use super::parameters::{Counting, ToldAxis, gap_of};
use crate::machine::{Machine, MachineAxis};
use lostmotion_base::units::deg;
use lostmotion_drive::config::{AxisUnit, Load};
use lostmotion_methods::AxisConfig;

/// How far off a gap may be, as a part of it, that counts as known. A choice: beyond, less than a fifth of it
/// is taken up.
pub(crate) const WIDEST: f64 = 0.8;

/// How far off the gap of an axis may be, as a part of it: as told, or as the axis says.
pub(crate) fn uncertainty(config: &AxisConfig, told: Option<f64>) -> f64 {
    told.unwrap_or(config.compensation.gap_uncertainty)
}

/// The machine as set, with its true gaps at an end of their intervals.
pub(super) fn with_gaps_at(
    set: &Machine,
    machine: &Machine,
    wanted: &RecommendOptions,
    sign: f64,
) -> Machine {
    let factor = |config: &AxisConfig| 1.0 + sign * uncertainty(config, wanted.gap_uncertainty);
    let mut end = set.clone();
    for (axis, of_set) in machine.axes().iter().zip(set.axes()) {
        let config = with_gap_times(&of_set.config, factor(&axis.config));
        end = end.with_axis_config(axis.id, &config);
    }
    if let (Some(gantry), Some(of_set)) = (machine.gantry(), set.gantry()) {
        let config = with_gap_times(&of_set.second, factor(&gantry.second));
        end = end.with_second_config(&config);
    }
    end
}

/// What has to be done first where gaps are as good as unknown.
pub(super) fn measure_first(machine: &Machine, wanted: &RecommendOptions) -> Option<String> {
    let unknown = machine.axes().iter().filter_map(|axis| {
        let share = uncertainty(&axis.config, wanted.gap_uncertainty);
        (share > WIDEST).then(|| format!("{} {:.0} %", axis.id, 100.0 * share))
    });
    let unknown: Vec<String> = unknown.collect();
    (!unknown.is_empty()).then(|| {
        format!(
            "the gaps are as good as unknown (they may be off by {}): measure them before anything is set, as with `axis testpart --for reversal`",
            unknown.join(", ")
        )
    })
}

/// The axis with a gap of another size.
pub(crate) fn with_gap_times(config: &AxisConfig, factor: f64) -> AxisConfig {
    let mut load = config.reflected_load();
    load.gap_rad *= factor;
    AxisConfig {
        load: Load::Reflected(load),
        ..config.clone()
    }
}

/// An angle of the motor, in mm or deg of the axis.
pub(super) fn units(config: &AxisConfig, is_rotary: bool, motor_rad: f64) -> f64 {
    let units = motor_rad / config.transmission.motor_rad_per_unit();
    if is_rotary && config.transmission.unit() == AxisUnit::Rad {
        deg(units)
    } else {
        units
    }
}

/// What friction winds the drive up by from one direction to the other, mm or deg.
pub(super) fn wind_up(config: &AxisConfig, is_rotary: bool) -> f64 {
    let load = config.reflected_load();
    units(
        config,
        is_rotary,
        2.0 * load.coulomb_nm / load.stiffness_nm_per_rad,
    )
}

/// The gap that a drive is told, mm or deg.
pub(super) fn told_gap(config: &AxisConfig) -> Option<f64> {
    let told = config
        .compensation
        .fixed
        .gap?
        .motor_rad(&config.transmission);
    Some(units(config, is_rotary(config), told))
}

pub(super) fn is_rotary(config: &AxisConfig) -> bool {
    config.transmission.unit() != AxisUnit::Mm
}

/// The machine with both motors of an axis told the lesser of what they are told.
pub(super) fn told_alike(machine: Machine) -> Machine {
    let motors = machine.gantry().and_then(|gantry| {
        let first = machine.axis(gantry.axis)?.config.clone();
        Some((gantry.axis, first, gantry.second.clone()))
    });
    let Some((id, mut first, mut second)) = motors else {
        return machine;
    };
    let gaps = [&first, &second].map(|config| told_gap(config).unwrap_or(0.0));
    let least = gap_of(gaps[0].min(gaps[1]), is_rotary(&first));
    first.compensation.tell_gap(least);
    second.compensation.tell_gap(least);
    machine
        .with_axis_config(id, &first)
        .with_second_config(&second)
}

/// Says that two motors with gaps of their own have one setting.
pub(super) fn one_setting(set: &Machine, counting: &Counting) -> Option<String> {
    let gantry = set.gantry().filter(|_| !counting.has_own_motors)?;
    let first = &set.axis(gantry.axis)?.config;
    let gaps = [first, &gantry.second]
        .map(|config| 1e3 * units(config, is_rotary(config), config.reflected_load().gap_rad));
    Some(format!(
        "{}: the control has one setting for both motors, whose gaps are {:.1} and {:.1} um: it is that of the smaller one",
        gantry.axis, gaps[0], gaps[1]
    ))
}

/// The machine as its control is told of it: the least gap that it may have, which a trial rounds to what
/// the control takes, and the limits of the joints.
pub(super) fn told(machine: &Machine, wanted: &RecommendOptions, counting: &Counting) -> Machine {
    let mut told = machine.map_axes(|config| {
        let mut config = config.clone();
        let is_rotary = is_rotary(&config);
        let least = units(&config, is_rotary, config.reflected_load().gap_rad)
            * (1.0 - uncertainty(&config, wanted.gap_uncertainty));
        config.compensation.tell_gap(gap_of(least, is_rotary));
        // The least has been taken.
        config.compensation.gap_uncertainty = 0.0;
        config
    });
    for axis in machine.axes() {
        if let Some(config) = told.axis(axis.id).map(|own| with_limits(&own.config, axis)) {
            told = told.with_axis_config(axis.id, &config);
        }
        // The second motor of an axis has the limits of the first.
        let gantry = told.gantry().filter(|gantry| gantry.axis == axis.id);
        if let Some(config) = gantry.map(|gantry| with_limits(&gantry.second, axis)) {
            told = told.with_second_config(&config);
        }
    }
    if counting.has_own_motors {
        told
    } else {
        told_alike(told)
    }
}

/// A drive whose compensation is told the limits of its axis.
fn with_limits(config: &AxisConfig, axis: &MachineAxis) -> AxisConfig {
    let mut config = config.clone();
    let (velocity, acceleration) = limits(axis);
    let linuxcnc = &mut config.compensation.fixed_linuxcnc;
    linuxcnc.velocity_units_s = Some(velocity);
    linuxcnc.acceleration_units_s2 = Some(acceleration);
    // 100 %, of which a trial takes a part.
    config.compensation.fixed_mach3.speed_units_s = velocity;
    config
}

/// Largest speed and acceleration of an axis, mm or deg per s and s2.
fn limits(axis: &MachineAxis) -> (f64, f64) {
    let limits = axis.limits_table().limits();
    if axis.is_rotary() {
        (deg(limits.velocity), deg(limits.acceleration))
    } else {
        (limits.velocity, limits.acceleration)
    }
}

/// The axes of a machine that has been told, in their order, with second motors that have settings.
pub(super) fn axes(set: &Machine, counting: &Counting) -> Vec<ToldAxis> {
    let mut all = Vec::new();
    for axis in set.axes() {
        let (velocity, acceleration) = limits(axis);
        let second = set
            .gantry()
            .filter(|gantry| counting.has_own_motors && gantry.axis == axis.id)
            .map(|gantry| (format!("{}2", axis.id), gantry.second.clone()));
        let first = (axis.id.to_string(), axis.config.clone());
        for (name, config) in std::iter::once(first).chain(second) {
            let is_rotary = axis.is_rotary();
            all.push(ToldAxis {
                id: axis.id,
                name,
                is_rotary,
                gap: told_gap(&config).unwrap_or(0.0),
                velocity,
                acceleration,
                config,
            });
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::control::Control;

    #[test]
    fn the_second_motor_of_an_axis_is_told_its_limits() {
        let machine = Machine::preset("gantry3").unwrap();
        let counting = Counting::new(Control::LinuxCnc, &machine, 1.0);
        let told = told(&machine, &RecommendOptions::default(), &counting);
        let gantry = told.gantry().unwrap();
        let limits = |config: &AxisConfig| {
            let linuxcnc = &config.compensation.fixed_linuxcnc;
            let mach3 = &config.compensation.fixed_mach3;
            let speeds = (linuxcnc.velocity_units_s, mach3.speed_units_s);
            (speeds, linuxcnc.acceleration_units_s2)
        };
        let first = &told.axis(gantry.axis).unwrap().config;
        assert!(limits(first).1.is_some());
        assert_eq!(limits(&gantry.second), limits(first));
    }
}
