//! What an INI file sets on a trunnion's pins: `[HAL] HALCMD = setp xyzac-trt-kins.x-rot-point 12.5`, names and meaning as LinuxCNC's chapter
//! on five-axis kinematics has them.

use super::draft::{Draft, Fate};
use super::{number, problem};
use crate::machine::Problem;

/// Takes one HALCMD for the machine's kinematics `module`; false if it is about something else. `mm` is the machine's unit.
pub(super) fn take(draft: &mut Draft, module: &str, line: usize, command: &str, mm: f64) -> Result<bool, Problem> {
    let mut words = command.split_whitespace();
    let (Some("setp"), Some(pin), Some(value), None) = (words.next(), words.next(), words.next(), words.next()) else { return Ok(false) };
    let Some(name) = pin.strip_prefix(module).and_then(|rest| rest.strip_prefix('.')) else { return Ok(false) };
    let spec = &mut draft.kinematics;
    let tilts_about_x = spec.kind == "trunnion-ac";
    let length = || Ok::<f64, Problem>(number(line, pin, value)? * mm);
    let key = match name {
        "x-rot-point" | "y-rot-point" | "z-rot-point" => {
            let index = match name.as_bytes().first() {
                Some(b'x') => 0,
                Some(b'y') => 1,
                _ => 2,
            };
            spec.rotation_point_mm.get_or_insert([0.0; 3])[index] = length()?;
            "kinematics.rotation_point_mm"
        }
        "x-offset" if !tilts_about_x => {
            spec.offset_x_mm = Some(length()?);
            "kinematics.offset_x_mm"
        }
        "y-offset" if tilts_about_x => {
            spec.offset_y_mm = Some(length()?);
            "kinematics.offset_y_mm"
        }
        "z-offset" => {
            spec.offset_z_mm = Some(length()?);
            "kinematics.offset_z_mm"
        }
        "conventional-directions" => {
            spec.conventional_directions = Some(match value.to_ascii_lowercase().as_str() {
                "1" | "true" => true,
                "0" | "false" => false,
                _ => return Err(problem(line, pin, format!("`{value}` is neither 0 nor 1"), "")),
            });
            "kinematics.conventional_directions"
        }
        _ => return Ok(false),
    };
    draft.row(format!("[HAL] setp {pin}"), value, Fate::Used, key);
    Ok(true)
}
