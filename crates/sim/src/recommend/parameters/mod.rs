//! The parameters of controls: names, units, signs, and what they ask for.
//!
//! Numbers are printed only for parameters whose unit and meaning a primary source of the maker
//! tells; what is known from elsewhere is named without one.

mod machine_tools;
mod open_controls;

use super::results::ControlSetting;
use crate::control::Control;
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
    /// Unit of length of LinuxCNC's settings.
    pub(super) units: Units,
    /// The axes of LinuxCNC's joints by their number.
    pub(super) joints: Vec<Option<AxisId>>,
}

impl Counting {
    /// Unit of an axis in LinuxCNC's settings: its name, the mm or deg in it, and the digits behind
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
        Control::LinuxCnc if !is_rotary && counting.units == Units::Inch => 1e-5 * Units::Inch.mm(),
        Control::Marlin | Control::RepRapFirmware | Control::Smoothieware | Control::GrblHal => {
            1e-3
        }
        _ => 1e-4,
    }
}

/// Largest value that it takes, mm or deg.
fn most(control: Control, detection_unit_um: f64) -> f64 {
    match control {
        Control::Fanuc => 9999.0 * detection_unit_um * 1e-3,
        Control::Heidenhain => 1.0,
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
    let limit = most(control, detection_unit_um);
    if let Some(axis) = axes.iter().find(|axis| axis.gap > limit) {
        return Err(format!(
            "the gap of {} is {} {}, and a {control} control takes {limit} at most",
            axis.name,
            axis.gap,
            unit(axis)
        ));
    }
    let mut p = Parameters::default();
    match control {
        Control::LinuxCnc => linuxcnc(&mut p, axes, counting),
        Control::Fanuc => fanuc(&mut p, method, axes, detection_unit_um),
        Control::Siemens => siemens(&mut p, method, axes),
        Control::Heidenhain => heidenhain(&mut p, method, axes),
        Control::Mitsubishi => mitsubishi(&mut p, method, axes),
        Control::Fagor => fagor(&mut p, method, axes),
        Control::Beckhoff => isg(&mut p, axes),
        Control::Mach3 => mach3(&mut p, axes),
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

/// Axes that move along; the others are named as left out.
fn linear<'a>(p: &mut Parameters, axes: &'a [ToldAxis]) -> Vec<&'a ToldAxis> {
    let (turning, straight): (Vec<&ToldAxis>, Vec<&ToldAxis>) =
        axes.iter().partition(|axis| axis.is_rotary);
    for axis in turning {
        p.note(format!(
            "{}: in which unit rotary axes are set has no primary source here; no number is printed, and the simulation has it compensated",
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
