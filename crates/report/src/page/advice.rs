//! What a user can do about a result: which values to enter in the control, and what helps against
//! a cause.

use crate::number::plain;
use lostmotion_gcode::Units;
use lostmotion_methods::MethodId;
use lostmotion_sim::Machine;
use lostmotion_sim::control::Control;
use lostmotion_sim::results::{AxisResult, Cause, MethodResult};

/// Where a control keeps the gap of an axis, by its manual.
const fn parameter(control: Control) -> Option<&'static str> {
    match control {
        Control::Fanuc => Some("parameter 1851 (in detection units)"),
        Control::Siemens => Some("MD32450 MA_BACKLASH (mm)"),
        Control::Heidenhain => Some("MP710, or backlash in CfgAxisComp (mm)"),
        Control::Mitsubishi => Some("the backlash compensation of the axis"),
        Control::Fagor => Some("BACKLASH (mm)"),
        Control::Beckhoff => Some("P-AXIS-00103"),
        Control::LinuxCnc => Some("BACKLASH in [JOINT_n] (machine units)"),
        Control::Mach3 => Some("the backlash distance of the axis"),
        Control::GrblHal => Some("$160 and following (mm)"),
        Control::Marlin | Control::RepRapFirmware => Some("M425 (mm)"),
        Control::Smoothieware => Some("alpha_backlash_mm and following"),
        _ => None,
    }
}

/// What to set for a method that is told the gap: axis by axis, and where. `None` if it needs none
/// or no axis has a gap.
pub(super) fn settings(result: &MethodResult, machine: &Machine) -> Option<String> {
    let method: MethodId = result.method.parse().ok()?;
    if !method.info().knows.gap {
        return None;
    }
    let control = machine.simulate().control;
    // LinuxCNC's settings are in the units of the machine; the others are known in mm.
    let (linear, size) = match machine.control_units() {
        Units::Inch if control == Some(Control::LinuxCnc) => ("inch", Units::Inch.mm()),
        _ => ("mm", Units::Mm.mm()),
    };
    let gap = |axis: &AxisResult| {
        let (unit, size) = match axis.unit.as_str() {
            "mdeg" => ("deg", 1.0),
            _ => (linear, size),
        };
        let told = plain(axis.gap * 1e-3 / size);
        format!("{} {told} {unit}", axis.axis.letter())
    };
    let gaps: Vec<String> = result
        .axes
        .iter()
        .filter(|axis| axis.gap > 0.0)
        .map(gap)
        .collect();
    if gaps.is_empty() {
        return None;
    }
    let place = control
        .and_then(parameter)
        .unwrap_or("the backlash compensation of the control");
    Some(format!("{} in {place}", gaps.join(", ")))
}

/// What helps against most of an error.
pub(super) const fn remedy(cause: Cause) -> &'static str {
    match cause {
        Cause::Reversal(_) => {
            "backlash compensation of this axis, or a smaller gap; a lower feed where the axis reverses"
        }
        Cause::Gap => "a smaller gap or preload: the load drifts between the flanks",
        Cause::Corner => "a lower feed or acceleration into this corner",
        Cause::ServoLag => "a lower feed here, or more feed-forward and position gain",
        Cause::Blend => "a smaller blending tolerance (G64 P), or exact path (G61)",
    }
}
