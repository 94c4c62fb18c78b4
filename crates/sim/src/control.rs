//! What controls can do about backlash: which of the registered methods a machine can be set to.
//!
//! The rows follow the makers' manuals; what no primary source says is left out, and a control
//! about which nothing is known has no row of methods at all.

use lostmotion_base::names::did_you_mean;
use lostmotion_methods::MethodId;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::str::FromStr;

/// Where the path comes to rest besides where the program asks for it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum PathStops {
    /// Nowhere.
    #[default]
    Never,
    /// Where an axis reverses, for as long as the axis takes for its gap: controls that put a move
    /// of their own between blocks (grbl and its descendants).
    Reversals,
    /// At the end of every move: controls that leave constant velocity to compensate (Mach3).
    Blocks,
}

impl PathStops {
    /// Its name in machine files.
    pub const fn name(self) -> &'static str {
        match self {
            PathStops::Never => "never",
            PathStops::Reversals => "reversals",
            PathStops::Blocks => "blocks",
        }
    }

    /// Where that is, in words.
    pub(crate) const fn place(self) -> &'static str {
        match self {
            PathStops::Never => "nowhere",
            PathStops::Reversals => "where an axis reverses",
            PathStops::Blocks => "at the end of every move",
        }
    }
}

/// A family of controls.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
#[non_exhaustive]
pub enum Control {
    /// Fanuc: parameters 1851 and 1852; backlash acceleration in the servo (2003#5, 2048, 2071).
    Fanuc,
    /// Siemens 840D, 828D, 808D: MD32450, friction compensation MD32490 and what follows.
    Siemens,
    /// Heidenhain: MP710, MP750 and MP752, or CfgAxisComp; reversal spikes MP715, MP716.
    Heidenhain,
    /// Mitsubishi: backlash compensation, and lost motion compensation in the servo (SV016, SV041).
    Mitsubishi,
    /// Fagor: BACKLASH, and the exponential pulse BAKANOUT.
    Fagor,
    /// Beckhoff and other controls on the ISG kernel: P-AXIS-00103.
    Beckhoff,
    /// LinuxCNC: BACKLASH of a joint.
    LinuxCnc,
    /// Mach3: backlash distance and speed.
    Mach3,
    /// grblHAL where it is compiled in: $160 and what follows.
    GrblHal,
    /// Marlin: M425.
    Marlin,
    /// RepRapFirmware: M425.
    RepRapFirmware,
    /// Smoothieware: alpha_backlash_mm and M425.
    Smoothieware,
    /// Klipper: nothing as released.
    Klipper,
    /// Haas: no primary source says what its setting does.
    Haas,
    /// A drive that the user programs: every method on the motor.
    Own,
}

impl Control {
    /// All of them.
    pub const ALL: [Control; 15] = [
        Control::Fanuc,
        Control::Siemens,
        Control::Heidenhain,
        Control::Mitsubishi,
        Control::Fagor,
        Control::Beckhoff,
        Control::LinuxCnc,
        Control::Mach3,
        Control::GrblHal,
        Control::Marlin,
        Control::RepRapFirmware,
        Control::Smoothieware,
        Control::Klipper,
        Control::Haas,
        Control::Own,
    ];

    /// Its name on command lines and in machine files.
    pub const fn name(self) -> &'static str {
        match self {
            Control::Fanuc => "fanuc",
            Control::Siemens => "siemens",
            Control::Heidenhain => "heidenhain",
            Control::Mitsubishi => "mitsubishi",
            Control::Fagor => "fagor",
            Control::Beckhoff => "beckhoff",
            Control::LinuxCnc => "linuxcnc",
            Control::Mach3 => "mach3",
            Control::GrblHal => "grblhal",
            Control::Marlin => "marlin",
            Control::RepRapFirmware => "reprapfirmware",
            Control::Smoothieware => "smoothieware",
            Control::Klipper => "klipper",
            Control::Haas => "haas",
            Control::Own => "own",
        }
    }

    /// Other names of controls on command lines: what their users say.
    pub const ALIASES: [(&'static str, Control); 6] = [
        ("sinumerik", Control::Siemens),
        ("twincat", Control::Beckhoff),
        ("isg", Control::Beckhoff),
        ("rrf", Control::RepRapFirmware),
        ("smoothie", Control::Smoothieware),
        ("tnc", Control::Heidenhain),
    ];

    /// The names of the methods that it has, besides `none`.
    pub(crate) const fn methods(self) -> &'static [&'static str] {
        match self {
            Control::Fanuc => &["fixed-fanuc", "reversal-pulse"],
            Control::Siemens => &["actual-value", "decaying-pulse"],
            Control::Heidenhain => &["actual-value", "reversal-pulse"],
            Control::Mitsubishi => &["fixed-mitsubishi", "friction-torque"],
            Control::Fagor => &["fixed", "decaying-pulse"],
            Control::Beckhoff => &["fixed-isg"],
            Control::LinuxCnc => &["fixed-linuxcnc"],
            Control::Mach3 => &["fixed-mach3"],
            Control::GrblHal => &["fixed"],
            Control::Marlin | Control::RepRapFirmware | Control::Smoothieware => {
                &["fixed-by-travel"]
            }
            Control::Klipper | Control::Haas | Control::Own => &[],
        }
    }

    /// Where it stops the path to compensate.
    pub(crate) const fn stops(self) -> PathStops {
        match self {
            Control::GrblHal => PathStops::Reversals,
            Control::Mach3 => PathStops::Blocks,
            _ => PathStops::Never,
        }
    }

    /// Why it cannot do what a method does, if it cannot.
    pub fn refusal(self, method: MethodId) -> Option<String> {
        if method.is_baseline() || self == Control::Own || self.methods().contains(&method.name()) {
            return None;
        }
        Some(match self {
            Control::Haas => {
                "what a Haas control offers is not known here: ask its manual".to_owned()
            }
            control => format!("a {control} control has no such function"),
        })
    }
}

impl fmt::Display for Control {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// A name that no control has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("there is no control `{name}`; {hint}")]
pub struct UnknownControl {
    /// The name asked for.
    pub name: String,
    /// The nearest name, or all of them.
    pub hint: String,
}

impl FromStr for Control {
    type Err = UnknownControl;

    fn from_str(name: &str) -> Result<Control, UnknownControl> {
        let found = Control::ALL
            .into_iter()
            .find(|control| control.name() == name);
        let mut aliases = Control::ALIASES.iter();
        let alias = aliases.find(|(alias, _)| *alias == name);
        found
            .or(alias.map(|(_, control)| *control))
            .ok_or_else(|| UnknownControl {
                name: name.to_owned(),
                hint: did_you_mean(name, &Control::ALL.map(Control::name)),
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_of_a_control_is_registered() {
        for control in Control::ALL {
            for name in control.methods() {
                let method: Result<MethodId, _> = name.parse();
                assert!(
                    method.is_ok_and(|method| control.refusal(method).is_none()),
                    "{name}"
                );
            }
            assert_eq!(control.name().parse(), Ok(control));
            assert_eq!(control.refusal(MethodId::NONE), None);
        }
        let adaptive = Control::Fanuc.refusal(MethodId::ADAPTIVE);
        assert_eq!(
            adaptive.as_deref(),
            Some("a fanuc control has no such function")
        );
        assert_eq!(Control::Own.refusal(MethodId::ADAPTIVE), None);
    }
}
