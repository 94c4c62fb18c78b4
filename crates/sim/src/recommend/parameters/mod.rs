//! The parameters of controls: names, units, signs, and what they ask for.
//!
//! Numbers are printed only for parameters whose unit and meaning a primary source of the maker
//! tells; what is known from elsewhere is named without one.

mod machine_tools;
mod open_controls;

use super::results::ControlSetting;
use crate::control::Control;
use crate::machine::Machine;
use lostmotion_base::AxisId;
use lostmotion_drive::config::Gap;
use lostmotion_gcode::Units;
use lostmotion_methods::AxisConfig;
use machine_tools::{fagor, fanuc, heidenhain, isg, mitsubishi, siemens};
use open_controls::{grblhal, linuxcnc, mach3, marlin, reprap, smoothie};

/// An axis with what the control is told of it.
#[derive(Clone, Debug)]
pub(super) struct ToldAxis {
    pub(super) id: AxisId,
    /// `X`, `Y2`.
    pub(super) name: String,
    /// Whether it turns.
    pub(super) is_rotary: bool,
    /// Total gap that is told, mm or deg.
    pub(super) gap: f64,
    /// Largest speed and acceleration, mm or deg per s and s2.
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    /// With the settings that were simulated.
    pub(super) config: AxisConfig,
}

/// What is set, and what has to be true for it.
#[derive(Clone, Debug, Default)]
pub(super) struct Parameters {
    pub(super) settings: Vec<ControlSetting>,
    pub(super) paste: Vec<String>,
    pub(super) preconditions: Vec<String>,
    pub(super) notes: Vec<String>,
    pub(super) source: &'static str,
}

/// How a control counts.
#[derive(Clone, Debug)]
pub(super) struct Counting {
    /// Detection unit of a Fanuc control, um.
    pub(super) detection_unit_um: f64,
    /// Unit of length of its settings.
    pub(super) units: Units,
    /// The axes of LinuxCNC's joints by their number.
    pub(super) joints: Vec<Option<AxisId>>,
    /// Whether each motor of an axis with two has settings of its own.
    pub(super) has_own_motors: bool,
}

impl Counting {
    pub(super) fn new(control: Control, machine: &Machine, detection_unit_um: f64) -> Counting {
        let joints = machine.joint_axes();
        // Of others the unit is always the same, or told with the value.
        let has_machine_units = matches!(
            control,
            Control::LinuxCnc | Control::Mach3 | Control::Siemens | Control::Fagor
        );
        let has_own_motors = match (control, machine.gantry()) {
            (Control::LinuxCnc, Some(gantry)) => {
                let of_axis = joints.iter().filter(|axis| **axis == Some(gantry.axis));
                of_axis.count() > 1
            }
            (
                Control::Mach3
                | Control::GrblHal
                | Control::Marlin
                | Control::RepRapFirmware
                | Control::Smoothieware,
                _,
            ) => false,
            _ => true,
        };
        Counting {
            detection_unit_um,
            units: if has_machine_units {
                machine.control_units()
            } else {
                Units::Mm
            },
            joints,
            has_own_motors,
        }
    }

    /// Unit of an axis in the control's settings: its name, the mm or deg in it, and the digits behind
    /// the point that a gap has.
    fn of(&self, is_rotary: bool) -> (&'static str, f64, usize) {
        match self.units {
            _ if is_rotary => ("deg", 1.0, 4),
            Units::Mm => ("mm", 1.0, 4),
            Units::Inch => ("inch", Units::Inch.mm(), 5),
        }
    }
}

/// Step of the value that a control takes for a gap, mm or deg.
pub(super) fn step(control: Control, counting: &Counting, is_rotary: bool) -> f64 {
    match control {
        Control::Fanuc => counting.detection_unit_um * 1e-3,
        _ if !is_rotary && counting.units == Units::Inch => 1e-5 * Units::Inch.mm(),
        Control::Marlin | Control::RepRapFirmware | Control::Smoothieware | Control::GrblHal => {
            1e-3
        }
        _ => 1e-4,
    }
}

/// Whether a control has a setting for axes that turn, whose unit is known here.
pub(super) fn sets_rotary(control: Control, method: &str) -> bool {
    match control {
        Control::LinuxCnc | Control::Fanuc | Control::Siemens => true,
        Control::Mitsubishi => method == "friction-torque",
        _ => false,
    }
}

/// Largest value that it takes, in steps of its own.
fn most_steps(control: Control) -> f64 {
    match control {
        Control::Fanuc => 9999.0,
        Control::Heidenhain => 10_000.0,
        _ => f64::INFINITY,
    }
}

/// The told gap of an axis as its settings have it.
pub(super) fn gap_of(value: f64, is_rotary: bool) -> Gap {
    if is_rotary {
        Gap::Mdeg(value * 1e3)
    } else {
        Gap::Um(value * 1e3)
    }
}

impl Parameters {
    fn set(
        &mut self,
        name: impl Into<String>,
        axis: &str,
        value: String,
        unit: &str,
        meaning: &str,
    ) {
        self.settings.push(ControlSetting {
            name: name.into(),
            axis: axis.to_owned(),
            value,
            unit: unit.to_owned(),
            meaning: meaning.to_owned(),
        });
    }

    fn line(&mut self, line: String) {
        self.paste.push(line);
    }

    /// Said once, though both joints of a gantry need it.
    fn needs(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !self.preconditions.contains(&text) {
            self.preconditions.push(text);
        }
    }

    fn note(&mut self, text: impl Into<String>) {
        self.notes.push(text.into());
    }
}

/// The parameters of a control with which a method is simulated.
///
/// # Errors
/// Why they cannot be given, for people.
pub(super) fn parameters(
    control: Control,
    method: &str,
    axes: &[ToldAxis],
    counting: &Counting,
) -> Result<Parameters, String> {
    let detection_unit_um = counting.detection_unit_um;
    let limit = most_steps(control);
    for axis in axes {
        let step = step(control, counting, axis.is_rotary);
        let steps = (axis.gap / step).round();
        if steps > limit {
            return Err(format!(
                "the gap of {} is {steps} units of {} {}, and a {control} control takes {limit} at most",
                axis.name,
                short(step, 7),
                unit(axis),
            ));
        }
    }
    let mut p = Parameters::default();
    match control {
        Control::LinuxCnc => linuxcnc(&mut p, axes, counting),
        Control::Fanuc => fanuc(&mut p, method, axes, detection_unit_um),
        Control::Siemens => siemens(&mut p, method, axes, counting),
        Control::Heidenhain => heidenhain(&mut p, method, axes),
        Control::Mitsubishi => mitsubishi(&mut p, method, axes),
        Control::Fagor => fagor(&mut p, method, axes, counting),
        Control::Beckhoff => isg(&mut p, axes),
        Control::Mach3 => mach3(&mut p, axes, counting),
        Control::GrblHal => grblhal(&mut p, axes),
        Control::Marlin => marlin(&mut p, axes),
        Control::RepRapFirmware => reprap(&mut p, axes),
        Control::Smoothieware => smoothie(&mut p, axes),
        Control::Klipper | Control::Haas | Control::Own => return Err(unknown(control)),
    }
    Ok(p)
}

/// Why nothing can be said of a control's settings.
pub(super) fn unknown(control: Control) -> String {
    match control {
        Control::Haas => {
            "no primary source for the backlash settings of Haas controls is known here: no number is printed. Ask the manual of your control and the maker's service".to_owned()
        }
        Control::Klipper => {
            "Klipper as released has no backlash compensation; rewrite the program instead".to_owned()
        }
        control => format!(
            "the control `{control}` has no settings of its own: `simulate --methods` compares the methods themselves"
        ),
    }
}

fn unit(axis: &ToldAxis) -> &'static str {
    if axis.is_rotary { "deg" } else { "mm" }
}

/// A value without needless zeros, with a point.
fn short(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let cut = text.trim_end_matches('0');
    if !text.contains('.') {
        text
    } else if cut.ends_with('.') {
        format!("{cut}0")
    } else {
        cut.to_owned()
    }
}

/// The axes by the numbers of a control that counts them in the order of the machine description: `A1 X,
/// A2 Y`.
fn numbered(axes: &[&ToldAxis], number: impl Fn(usize) -> String) -> String {
    let named = axes.iter().enumerate();
    let named = named.map(|(place, axis)| format!("{} {}", number(place), axis.name));
    named.collect::<Vec<_>>().join(", ")
}

/// Axes that move along; the others are named as left out.
fn linear<'a>(p: &mut Parameters, axes: &'a [ToldAxis]) -> Vec<&'a ToldAxis> {
    let (turning, straight): (Vec<&ToldAxis>, Vec<&ToldAxis>) =
        axes.iter().partition(|axis| axis.is_rotary);
    for axis in turning {
        p.note(format!(
            "{}: in which unit rotary axes are set has no primary source here; it is left alone, in the simulation, too",
            axis.name
        ));
    }
    straight
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_zeros_behind_the_point_are_cut() {
        let texts = [
            (10.0, 0),
            (20.0, 0),
            (1.0, 0),
            (0.05, 4),
            (100.0, 1),
            (0.0, 3),
        ]
        .map(|(value, decimals)| short(value, decimals));
        assert_eq!(texts, ["10", "20", "1", "0.05", "100.0", "0.0"]);
    }
}
