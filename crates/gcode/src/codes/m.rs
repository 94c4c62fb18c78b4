//! M codes.

use super::row::{AxisUse, CodeRow, Group, Texts, row};
use crate::exec::{Exec, auxiliary, context, outputs, spindle, stop, tool};
use crate::problem::{Code, Problem};

const fn m(
    number: u16,
    group: Group,
    words: &'static str,
    texts: Texts,
    action: fn(&mut Exec<'_>, Code) -> Result<(), Problem>,
) -> CodeRow {
    row('M', number * 10, group, (AxisUse::None, words), texts, action)
}

/// All M codes in the order of their numbers.
pub(crate) const ROWS: &[CodeRow] = &[
    m(0, Group::Stop, "", ["stop until told to go on", "M0", "m00.ngc"], stop::stop),
    m(1, Group::Stop, "", ["stop if the operator wants it", "M1", "m01.ngc"], stop::optional_stop),
    m(2, Group::Stop, "", ["end of the program", "M2", "m02.ngc"], stop::end),
    m(3, Group::Spindle, "$", ["spindle on, clockwise", "M3 S1200", "m03.ngc"], auxiliary::spindle_on),
    m(4, Group::Spindle, "$", ["spindle on, counter-clockwise", "M4 S1200", "m04.ngc"], auxiliary::spindle_on),
    m(5, Group::Spindle, "$", ["spindle off", "M5", "m05.ngc"], auxiliary::spindle_off),
    m(6, Group::ToolChange, "", ["change to the selected tool", "T2 M6", "m06.ngc"], tool::change),
    m(7, Group::Coolant, "", ["mist on", "M7", "m07.ngc"], auxiliary::coolant),
    m(8, Group::Coolant, "", ["flood on", "M8", "m08.ngc"], auxiliary::coolant),
    m(9, Group::Coolant, "", ["coolant off", "M9", "m09.ngc"], auxiliary::coolant),
    m(19, Group::Spindle, "RPQ$", ["turn the spindle to an angle", "M19 R90 Q2", "m19.ngc"], spindle::orient),
    m(30, Group::Stop, "", ["end of the program", "M30", "m30.ngc"], stop::end),
    m(48, Group::Override, "", ["allow overrides of feed and speed", "M48", "m48.ngc"], auxiliary::overrides),
    m(49, Group::Override, "", ["forbid overrides of feed and speed", "M49", "m49.ngc"], auxiliary::overrides),
    m(50, Group::Override, "P", ["feed override on, off with P0", "M50 P0", "m50.ngc"], auxiliary::feed_override),
    m(51, Group::Override, "P$", ["speed override on, off with P0", "M51 P0", "m51.ngc"], auxiliary::speed_override),
    m(52, Group::Override, "P", ["adaptive feed on, off with P0", "M52 P0", "m52.ngc"], auxiliary::adaptive_feed),
    m(53, Group::Override, "P", ["feed hold on, off with P0", "M53 P0", "m53.ngc"], auxiliary::feed_hold),
    m(60, Group::Stop, "", ["exchange pallets and stop", "M60", "m60.ngc"], stop::pallet),
    m(61, Group::ToolChange, "Q", ["the tool in the spindle is Q", "M61 Q3", "m61.ngc"], tool::set_number),
    m(62, Group::Output, "P", ["digital output on, with the next move", "M62 P1", "m62.ngc"], outputs::digital),
    m(63, Group::Output, "P", ["digital output off, with the next move", "M63 P1", "m63.ngc"], outputs::digital),
    m(64, Group::Output, "P", ["digital output on", "M64 P1", "m64.ngc"], outputs::digital),
    m(65, Group::Output, "P", ["digital output off", "M65 P1", "m65.ngc"], outputs::digital),
    m(66, Group::Output, "PELQ", ["read an input into #5399", "M66 P1 L3 Q2", "m66.ngc"], outputs::input),
    m(67, Group::Output, "EQ", ["analogue output, with the next move", "M67 E1 Q2.5", "m67.ngc"], outputs::analog),
    m(68, Group::Output, "EQ", ["analogue output", "M68 E1 Q2.5", "m68.ngc"], outputs::analog),
    m(70, Group::ModalState, "", ["save the modes", "M70", "m70.ngc"], context::save),
    m(71, Group::ModalState, "", ["forget the saved modes", "M71", "m71.ngc"], context::forget),
    m(72, Group::ModalState, "", ["bring the saved modes back", "M72", "m72.ngc"], context::bring_back),
    m(73, Group::ModalState, "", ["save the modes until the subroutine returns", "M73", "m73.ngc"], context::save),
    m(98, Group::Stop, "PL", ["call subroutine P, L times", "M98 P100 L2", "m98.ngc"], stop::call),
    m(99, Group::Stop, "P", ["return from a subroutine", "M99", "m99.ngc"], stop::back),
];
