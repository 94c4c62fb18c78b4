//! The predefined named parameters that show the state (LinuxCNC, "Predefined Named Parameters").

use crate::ops::{Plane, Units};
use crate::state::{FeedMode, State};

/// Numbers that `#<_coord_system>` shows for G54 to G59.3.
const SYSTEM_CODES: [f64; 9] = [
    540.0, 550.0, 560.0, 570.0, 580.0, 590.0, 591.0, 592.0, 593.0,
];

fn truth(condition: bool) -> f64 {
    if condition { 1.0 } else { 0.0 }
}

/// The value of a predefined parameter; none if there is none of that name.
pub(crate) fn system_name(name: &[u8], state: &State) -> Option<f64> {
    let name = std::str::from_utf8(name).ok()?;
    Some(match name {
        "_vmajor" => 2.9,
        "_vminor" => 0.0,
        "_line" => f64::from(state.line),
        "_motion_mode" => state.motion.map_or(800.0, |code| f64::from(code.tenths)),
        "_plane" => match state.plane {
            Plane::Xy => 170.0,
            Plane::Zx => 180.0,
            Plane::Yz => 190.0,
        },
        "_ccomp" => state
            .compensation
            .as_ref()
            .map_or(400.0, |compensation| compensation.code()),
        "_metric" => truth(state.units == Units::Mm),
        "_imperial" => truth(state.units == Units::Inch),
        "_absolute" => truth(state.absolute),
        "_incremental" => truth(!state.absolute),
        "_inverse_time" => truth(state.feed_mode == FeedMode::InverseTime),
        "_units_per_minute" => truth(state.feed_mode == FeedMode::PerMinute),
        "_units_per_rev" => truth(state.feed_mode == FeedMode::PerRevolution),
        "_coord_system" => SYSTEM_CODES
            .get(usize::from(state.system) - 1)
            .copied()
            .unwrap_or_default(),
        "_tool_offset" => truth(state.offsets.tool.iter().any(|offset| *offset != 0.0)),
        "_retract_r_plane" => truth(!state.retract_to_start),
        "_retract_old_z" => truth(state.retract_to_start),
        "_spindle_rpm_mode" => truth(state.spindle.surface_limit.is_none()),
        "_spindle_css_mode" => truth(state.spindle.surface_limit.is_some()),
        "_ijk_absolute_mode" => truth(state.arc_absolute),
        "_lathe_diameter_mode" => truth(state.diameter),
        "_lathe_radius_mode" => truth(!state.diameter),
        "_spindle_on" => truth(state.spindle.clockwise.is_some()),
        "_spindle_cw" => truth(state.spindle.clockwise == Some(true)),
        "_mist" => truth(state.mist),
        "_flood" => truth(state.flood),
        "_speed_override" => truth(state.speed_override),
        "_feed_override" => truth(state.feed_override),
        "_adaptive_feed" => truth(state.adaptive_feed),
        "_feed_hold" => truth(state.feed_hold),
        "_feed" => state.feed,
        "_rpm" => state.spindle.speed,
        "_current_tool" => f64::from(state.loaded_tool),
        "_current_pocket" => f64::from(state.loaded_tool),
        "_selected_tool" | "_selected_pocket" => f64::from(state.selected_tool.unwrap_or(-1)),
        "_task" | "_remap_level" => 0.0,
        _ => return coordinate(name, state),
    })
}

/// `_x` to `_w`: where the tool is; `_abs_x` to `_abs_w`: in machine coordinates.
fn coordinate(name: &str, state: &State) -> Option<f64> {
    let (position, letter) = match name.strip_prefix("_abs_") {
        Some(letter) => (state.machine(), letter),
        None => (state.current, name.strip_prefix('_')?),
    };
    let index = "xyzabcuvw".find(letter)?;
    if letter.len() == 1 {
        position.get(index).copied()
    } else {
        None
    }
}
