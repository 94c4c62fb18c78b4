//! The modes of a state by name, with the codes that set them.

use lostmotion_gcode::ops::{PathControl, Plane, Position, Units};
use lostmotion_gcode::state::{FeedMode, State};
use serde::Serialize;

/// One mode.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Mode {
    /// What it is.
    pub name: &'static str,
    /// What it is set to.
    pub value: String,
}

const SYSTEMS: [&str; 9] = [
    "G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3",
];

/// Axis letters with values that are not zero.
pub(super) fn axes(position: &Position) -> String {
    // Axes at zero are left out: most offsets name two or three.
    let one = |(letter, value): (char, &f64)| format!("{letter}{value}");
    let some: Vec<String> = "XYZABCUVW"
        .chars()
        .zip(position)
        .filter(|(_, value)| **value != 0.0)
        .map(one)
        .collect();
    if some.is_empty() {
        "none".to_owned()
    } else {
        some.join(" ")
    }
}

fn switch(on: bool) -> &'static str {
    if on { "on" } else { "off" }
}

fn path(control: PathControl, merge: f64) -> String {
    match control {
        PathControl::ExactPath => "exact path (G61)".to_owned(),
        PathControl::ExactStop => "exact stop (G61.1)".to_owned(),
        PathControl::Continuous { tolerance: 0.0 } => "continuous (G64)".to_owned(),
        PathControl::Continuous { tolerance } => {
            format!("continuous within {tolerance} (G64 P), merging within {merge}")
        }
    }
}

fn feed(state: &State) -> String {
    let unit = state.units.name();
    match state.feed_mode {
        FeedMode::InverseTime => "inverse time, one F a move (G93)".to_owned(),
        FeedMode::PerMinute => format!("{} {unit}/min (G94)", state.feed),
        FeedMode::PerRevolution => format!("{} {unit}/rev (G95)", state.feed),
    }
}

fn spindle(state: &State) -> String {
    let spindle = &state.spindle;
    let turns = match spindle.clockwise {
        None => "stopped (M5)",
        Some(true) => "clockwise (M3)",
        Some(false) => "counter-clockwise (M4)",
    };
    // Under G96 the S is a cutting speed, otherwise revolutions per minute.
    let unit = if spindle.surface_limit.is_some() {
        "surface speed (G96)"
    } else {
        "rev/min"
    };
    format!("{turns}, S{} {unit}", spindle.speed)
}

/// All modes of a state.
pub(super) fn modes(state: &State, compensated: bool) -> Vec<Mode> {
    let mode = |name, value: String| Mode { name, value };
    let plane = match state.plane {
        Plane::Xy => "XY (G17)",
        Plane::Zx => "ZX (G18)",
        Plane::Yz => "YZ (G19)",
    };
    let offsets = &state.offsets;
    // Systems count from 1 for G54.
    let system = SYSTEMS
        .get(usize::from(state.system).wrapping_sub(1))
        .copied()
        .unwrap_or("?");
    let compensation = if compensated {
        "on (G41, G42)"
    } else {
        "off (G40)"
    };
    vec![
        mode(
            "motion",
            state
                .motion
                .map_or("none (G80)".to_owned(), |code| code.to_string()),
        ),
        mode(
            "units",
            if state.units == Units::Mm {
                "mm (G21)"
            } else {
                "inch (G20)"
            }
            .to_owned(),
        ),
        mode(
            "distances",
            if state.absolute {
                "absolute (G90)"
            } else {
                "incremental (G91)"
            }
            .to_owned(),
        ),
        mode(
            "arc centres",
            if state.arc_absolute {
                "absolute (G90.1)"
            } else {
                "relative (G91.1)"
            }
            .to_owned(),
        ),
        mode("plane", plane.to_owned()),
        mode("feed", feed(state)),
        mode("spindle", spindle(state)),
        mode(
            "tool",
            format!(
                "T{} in the spindle, {}",
                state.loaded_tool,
                state
                    .selected_tool
                    .map_or("none selected".to_owned(), |tool| format!(
                        "T{tool} selected"
                    ))
            ),
        ),
        mode("tool offset", axes(&offsets.tool)),
        mode("work offset", format!("{system}: {}", axes(&offsets.g5x))),
        mode("rotation", format!("{} degrees", offsets.rotation_deg)),
        mode("G92 offset", axes(&offsets.g92)),
        mode("cutter compensation", compensation.to_owned()),
        mode("path", path(state.path_control, state.merge_tolerance)),
        mode(
            "coolant",
            format!("flood {}, mist {}", switch(state.flood), switch(state.mist)),
        ),
        mode(
            "cycles return to",
            if state.retract_to_start {
                "where they began (G98)"
            } else {
                "R (G99)"
            }
            .to_owned(),
        ),
        mode(
            "X",
            if state.diameter {
                "a diameter (G7)"
            } else {
                "a radius (G8)"
            }
            .to_owned(),
        ),
    ]
}
