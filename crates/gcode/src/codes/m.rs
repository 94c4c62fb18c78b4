//! M codes.

use super::row::{AxisUse, CodeRow, Group, Texts, row};

const fn m(number: u16, group: Group, words: &'static str, texts: Texts) -> CodeRow {
    row('M', number * 10, group, (AxisUse::None, words), texts)
}

/// All M codes in the order of their numbers.
pub(crate) const ROWS: &[CodeRow] = &[
    m(
        0,
        Group::Stop,
        "",
        ["stop until told to go on", "M0", "m00.ngc"],
    ),
    m(
        1,
        Group::Stop,
        "",
        ["stop if the operator wants it", "M1", "m01.ngc"],
    ),
    m(2, Group::Stop, "", ["end of the program", "M2", "m02.ngc"]),
    m(
        3,
        Group::Spindle,
        "$",
        ["spindle on, clockwise", "M3 S1200", "m03.ngc"],
    ),
    m(
        4,
        Group::Spindle,
        "$",
        ["spindle on, counter-clockwise", "M4 S1200", "m04.ngc"],
    ),
    m(5, Group::Spindle, "$", ["spindle off", "M5", "m05.ngc"]),
    m(
        6,
        Group::ToolChange,
        "",
        ["change to the selected tool", "T2 M6", "m06.ngc"],
    ),
    m(7, Group::Coolant, "", ["mist on", "M7", "m07.ngc"]),
    m(8, Group::Coolant, "", ["flood on", "M8", "m08.ngc"]),
    m(9, Group::Coolant, "", ["coolant off", "M9", "m09.ngc"]),
    m(
        19,
        Group::Spindle,
        "RPQ$",
        ["turn the spindle to an angle", "M19 R90 Q2", "m19.ngc"],
    ),
    m(
        30,
        Group::Stop,
        "",
        ["end of the program", "M30", "m30.ngc"],
    ),
    m(
        48,
        Group::Override,
        "",
        ["allow overrides of feed and speed", "M48", "m48.ngc"],
    ),
    m(
        49,
        Group::Override,
        "",
        ["forbid overrides of feed and speed", "M49", "m49.ngc"],
    ),
    m(
        50,
        Group::Override,
        "P",
        ["feed override on, off with P0", "M50 P0", "m50.ngc"],
    ),
    m(
        51,
        Group::Override,
        "P$",
        ["speed override on, off with P0", "M51 P0", "m51.ngc"],
    ),
    m(
        52,
        Group::Override,
        "P",
        ["adaptive feed on, off with P0", "M52 P0", "m52.ngc"],
    ),
    m(
        53,
        Group::Override,
        "P",
        ["feed hold on, off with P0", "M53 P0", "m53.ngc"],
    ),
    m(
        60,
        Group::Stop,
        "",
        ["exchange pallets and stop", "M60", "m60.ngc"],
    ),
    m(
        61,
        Group::ToolChange,
        "Q",
        ["the tool in the spindle is Q", "M61 Q3", "m61.ngc"],
    ),
    m(
        62,
        Group::Output,
        "P",
        ["digital output on, with the next move", "M62 P1", "m62.ngc"],
    ),
    m(
        63,
        Group::Output,
        "P",
        [
            "digital output off, with the next move",
            "M63 P1",
            "m63.ngc",
        ],
    ),
    m(
        64,
        Group::Output,
        "P",
        ["digital output on", "M64 P1", "m64.ngc"],
    ),
    m(
        65,
        Group::Output,
        "P",
        ["digital output off", "M65 P1", "m65.ngc"],
    ),
    m(
        66,
        Group::Output,
        "PELQ",
        ["read an input into #5399", "M66 P1 L3 Q2", "m66.ngc"],
    ),
    m(
        67,
        Group::Output,
        "EQ",
        [
            "analogue output, with the next move",
            "M67 E1 Q2.5",
            "m67.ngc",
        ],
    ),
    m(
        68,
        Group::Output,
        "EQ",
        ["analogue output", "M68 E1 Q2.5", "m68.ngc"],
    ),
    m(
        70,
        Group::ModalState,
        "",
        ["save the modes", "M70", "m70.ngc"],
    ),
    m(
        71,
        Group::ModalState,
        "",
        ["forget the saved modes", "M71", "m71.ngc"],
    ),
    m(
        72,
        Group::ModalState,
        "",
        ["bring the saved modes back", "M72", "m72.ngc"],
    ),
    m(
        73,
        Group::ModalState,
        "",
        [
            "save the modes until the subroutine returns",
            "M73",
            "m73.ngc",
        ],
    ),
    m(
        98,
        Group::Stop,
        "PL",
        ["call subroutine P, L times", "M98 P100 L2", "m98.ngc"],
    ),
    m(
        99,
        Group::Stop,
        "P",
        ["return from a subroutine", "M99", "m99.ngc"],
    ),
];
