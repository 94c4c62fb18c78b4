//! All codes, one row each in the order of their numbers:
//!
//! ```text
//! ten times the number, group, axis words, "other words" => "meaning", "example", "sample";
//! ```
//!
//! `may` use axis words, `needs` at least one, or `none`. F, S and T need not be named: any line may
//! have them. `only NAME` makes a code of other controls, which needs that leniency.

use super::row::{AxisUse, CodeRow, Group, row};
use crate::dialect::Leniency;

macro_rules! axis_use {
    (none) => {
        AxisUse::None
    };
    (may) => {
        AxisUse::May
    };
    (needs) => {
        AxisUse::Needs
    };
}

/// Makes the rows of G and M codes.
macro_rules! codes {
    (
        g { $($g:literal $g_group:ident $g_axes:ident $g_words:literal $(only $g_only:ident)?
            => $g_meaning:literal, $g_example:literal, $g_sample:literal;)* }
        m { $($m:literal $m_group:ident $m_axes:ident $m_words:literal $(only $m_only:ident)?
            => $m_meaning:literal, $m_example:literal, $m_sample:literal;)* }
    ) => {
        /// All G codes in the order of their numbers.
        pub(crate) const G_ROWS: &[CodeRow] = &[$(
            row('G', $g, Group::$g_group, (axis_use!($g_axes), $g_words), [$g_meaning, $g_example, $g_sample])
                $(.only_with(Leniency::$g_only))?,
        )*];

        /// All M codes in the order of their numbers.
        pub(crate) const M_ROWS: &[CodeRow] = &[$(
            row('M', $m, Group::$m_group, (axis_use!($m_axes), $m_words), [$m_meaning, $m_example, $m_sample])
                $(.only_with(Leniency::$m_only))?,
        )*];
    };
}

codes! {
g {
    0 Motion may "" => "traverse in a straight line", "G0 X10 Y5", "g00.ngc";
    10 Motion may "" => "feed in a straight line", "G1 X10 F200", "g01.ngc";
    20 Motion may "IJKRP" => "arc or helix, clockwise", "G2 X10 Y0 I5 J0", "g02.ngc";
    30 Motion may "IJKRP" => "arc or helix, counter-clockwise", "G3 X10 Y0 R5", "g03.ngc";
    40 NonModal none "P" => "dwell for P seconds", "G4 P0.5", "g04.ngc";
    50 Motion may "IJPQ" => "cubic spline", "G5 X2 Y2 I0 J3 P0 Q-3", "g05.ngc";
    51 Motion may "IJ" => "quadratic spline", "G5.1 X4 I2 J4", "g05_1.ngc";
    52 Motion may "PL" => "control points of a NURBS", "G5.2 X1 Y1 P1 L3", "g05_2.ngc";
    53 Motion none "" => "end of the NURBS, which is then run", "G5.3", "g05_3.ngc";
    70 Diameter none "" => "X is a diameter", "G7", "g07.ngc";
    80 Diameter none "" => "X is a radius", "G8", "g08.ngc";
    100 NonModal may "LPRIJQ" =>
        "coordinate systems (L2, L20) and tools (L1, L10, L11)", "G10 L2 P1 X10", "g10.ngc";
    120 NonModal may "IKQD" only CircularPockets =>
        "circular pocket, clockwise (Haas)", "G12 I5 Z-2 F200", "g12.ngc";
    130 NonModal may "IKQD" only CircularPockets =>
        "circular pocket, counter-clockwise (Haas)", "G13 I2 K8 Q2 Z-2 F200", "g13.ngc";
    170 Plane none "" => "arcs in the XY plane", "G17", "g17.ngc";
    180 Plane none "" => "arcs in the ZX plane", "G18", "g18.ngc";
    190 Plane none "" => "arcs in the YZ plane", "G19", "g19.ngc";
    200 Units none "" => "inches", "G20", "g20.ngc";
    210 Units none "" => "millimetres", "G21", "g21.ngc";
    280 NonModal may "" => "home by way of a point", "G28 Z10", "g28.ngc";
    281 NonModal none "" => "make this place the home of G28", "G28.1", "g28_1.ngc";
    300 NonModal may "" => "second home by way of a point", "G30 Z10", "g30.ngc";
    301 NonModal none "" => "make this place the home of G30", "G30.1", "g30_1.ngc";
    330 Motion needs "K$" => "move in step with the spindle", "G33 Z-9 K1.5", "g33.ngc";
    331 Motion needs "KI$" => "rigid tapping, there and back", "G33.1 Z-9 K1.5", "g33_1.ngc";
    382 Motion needs "" => "probe until contact, which has to come", "G38.2 Z-9", "g38_2.ngc";
    383 Motion needs "" => "probe until contact", "G38.3 Z-9", "g38_3.ngc";
    384 Motion needs "" =>
        "probe until contact is lost, which it has to be", "G38.4 Z9", "g38_4.ngc";
    385 Motion needs "" => "probe until contact is lost", "G38.5 Z9", "g38_5.ngc";
    400 CutterCompensation none "" => "cutter compensation off", "G40", "g40.ngc";
    410 CutterCompensation none "D" =>
        "cutter compensation, tool left of the path", "G41 D3", "g41.ngc";
    411 CutterCompensation none "DL" => "the same by the diameter", "G41.1 D6", "g41_1.ngc";
    420 CutterCompensation none "D" =>
        "cutter compensation, tool right of the path", "G42 D3", "g42.ngc";
    421 CutterCompensation none "DL" => "the same by the diameter", "G42.1 D6", "g42_1.ngc";
    430 ToolLength none "H" => "tool offset from the table", "G43 H3", "g43.ngc";
    431 ToolLength may "" => "tool offset from the line", "G43.1 Z12.5", "g43_1.ngc";
    432 ToolLength may "H" => "one more tool offset on top", "G43.2 H4", "g43_2.ngc";
    434 ToolLength none "H" only FiveAxis =>
        "X Y Z are the tool's tip, whatever the rotary axes do", "G43.4 H3", "g43_4.ngc";
    435 ToolLength none "H" only FiveAxis =>
        "the same, I J K being the tool's direction", "G43.5 H3", "g43_5.ngc";
    440 ToolLength none "H" only NegativeLength =>
        "tool offset from the table, subtracted", "G44 H3", "g44.ngc";
    490 ToolLength none "" => "no tool offset", "G49", "g49.ngc";
    520 NonModal needs "" => "shift of all coordinate systems", "G52 X5", "g52.ngc";
    530 NonModal none "" => "this move in machine coordinates", "G53 G0 Z0", "g53.ngc";
    531 NonModal none "" only FiveAxis =>
        "the tool stands upright on the tilted plane", "G53.1", "g53_1.ngc";
    540 CoordinateSystem none "" => "coordinate system 1", "G54", "g54.ngc";
    541 CoordinateSystem none "P" only ExtraSystems =>
        "coordinate system P beyond G59 (Fanuc)", "G54.1 P2", "g54_1.ngc";
    550 CoordinateSystem none "" => "coordinate system 2", "G55", "g55.ngc";
    560 CoordinateSystem none "" => "coordinate system 3", "G56", "g56.ngc";
    570 CoordinateSystem none "" => "coordinate system 4", "G57", "g57.ngc";
    580 CoordinateSystem none "" => "coordinate system 5", "G58", "g58.ngc";
    590 CoordinateSystem none "" => "coordinate system 6", "G59", "g59.ngc";
    591 CoordinateSystem none "" => "coordinate system 7", "G59.1", "g59_1.ngc";
    592 CoordinateSystem none "" => "coordinate system 8", "G59.2", "g59_2.ngc";
    593 CoordinateSystem none "" => "coordinate system 9", "G59.3", "g59_3.ngc";
    610 PathControl none "" => "exact path", "G61", "g61.ngc";
    611 PathControl none "" => "exact stop", "G61.1", "g61_1.ngc";
    640 PathControl none "PQ" => "rounded corners within P", "G64 P0.05 Q0.01", "g64.ngc";
    680 NonModal may "R" only FiveAxis =>
        "coordinates turned by R about X Y", "G68 X5 Y5 R30", "g68.ngc";
    682 NonModal may "IJK" only FiveAxis =>
        "tilted plane", "G68.2 X0 Y0 Z10 I0 J30 K0", "g68_2.ngc";
    690 NonModal none "" only FiveAxis => "coordinates not turned any more", "G69", "g69.ngc";
    700 Motion may "QDEP" =>
        "finish along a profile, subroutine Q", "G70 Q100 X20 Z2 D0.5 P2", "g70.ngc";
    710 Motion may "QDIR" => "rough a profile along Z", "G71 Q100 X20 Z2 D0.5 I1 R0.5", "g71.ngc";
    711 Motion may "QDIR" =>
        "the same without pockets", "G71.1 Q100 X20 Z2 D0.5 I1 R0.5", "g71_1.ngc";
    712 Motion may "QDIR" =>
        "the same, only later pockets", "G71.2 Q100 X20 Z2 D0.3 I1 R0.5", "g71_2.ngc";
    720 Motion may "QDIR" => "rough a profile along X", "G72 Q100 X20 Z2 D0.5 I1 R0.5", "g72.ngc";
    721 Motion may "QDIR" =>
        "the same without pockets", "G72.1 Q100 X20 Z2 D0.5 I1 R0.5", "g72_1.ngc";
    722 Motion may "QDIR" =>
        "the same, only later pockets", "G72.2 Q100 X20 Z2 D0.3 I1 R0.5", "g72_2.ngc";
    730 Motion needs "RQLP" => "drill with chip breaking", "G73 X1 Z-9 R1 Q2", "g73.ngc";
    740 Motion needs "RLP$" => "tap, left-handed", "G74 X1 Z-9 R1", "g74.ngc";
    760 Motion needs "PIJKRQHEL" =>
        "thread in several passes", "G76 Z-20 P1.5 I-1 J0.2 K0.9 R2 Q29.5 H1 E1 L2", "g76.ngc";
    800 Motion none "" => "end of the motion mode", "G80", "g80.ngc";
    810 Motion needs "RLPQ" => "drill", "G81 X1 Z-9 R1", "g81.ngc";
    820 Motion needs "RLPQ" => "drill with dwell", "G82 X1 Z-9 R1 P0.5", "g82.ngc";
    830 Motion needs "RLPQ" => "drill in pecks", "G83 X1 Z-9 R1 Q2", "g83.ngc";
    840 Motion needs "RLPQ$" => "tap, right-handed", "G84 X1 Z-9 R1", "g84.ngc";
    850 Motion needs "RLPQ" => "bore, feed out", "G85 X1 Z-9 R1", "g85.ngc";
    860 Motion needs "RLPQ" => "bore, stop, rapid out", "G86 X1 Z-9 R1 P0.5", "g86.ngc";
    870 Motion needs "RLPQIJK" => "bore from behind", "G87 X1 Z-9 R1 I1 J0 K-7", "g87.ngc";
    880 Motion needs "RLPQ" => "bore, stop, manual out", "G88 X1 Z-9 R1 P0.5", "g88.ngc";
    890 Motion needs "RLPQ" => "bore, dwell, feed out", "G89 X1 Z-9 R1 P0.5", "g89.ngc";
    900 Distance none "" => "absolute coordinates", "G90", "g90.ngc";
    901 ArcDistance none "" => "absolute arc centres", "G90.1", "g90_1.ngc";
    910 Distance none "" => "incremental coordinates", "G91", "g91.ngc";
    911 ArcDistance none "" => "arc centres relative to the start", "G91.1", "g91_1.ngc";
    920 NonModal needs "" => "this place has the given coordinates", "G92 X0 Y0", "g92.ngc";
    921 AxisOffset none "" => "forget the G92 offset", "G92.1", "g92_1.ngc";
    922 AxisOffset none "" => "suspend the G92 offset", "G92.2", "g92_2.ngc";
    923 AxisOffset none "" => "restore the G92 offset", "G92.3", "g92_3.ngc";
    930 FeedMode none "" => "F in moves per minute", "G93", "g93.ngc";
    940 FeedMode none "" => "F in units per minute", "G94", "g94.ngc";
    950 FeedMode none "" => "F in units per revolution", "G95", "g95.ngc";
    960 SpindleMode none "D$" => "constant surface speed", "G96 S100 D2500", "g96.ngc";
    970 SpindleMode none "$" => "S in rev/min", "G97 S500", "g97.ngc";
    980 Retract none "" => "cycles end where they began", "G98", "g98.ngc";
    990 Retract none "" => "cycles end at R", "G99", "g99.ngc";
    1540 CoordinateSystem none "P" only ExtraSystems =>
        "coordinate system P beyond G59 (Haas)", "G154 P2", "g154.ngc";
}
m {
    0 Stop none "" => "stop until told to go on", "M0", "m00.ngc";
    10 Stop none "" => "stop if the operator wants it", "M1", "m01.ngc";
    20 Stop none "" => "end of the program", "M2", "m02.ngc";
    30 Spindle none "$" => "spindle on, clockwise", "M3 S1200", "m03.ngc";
    40 Spindle none "$" => "spindle on, counter-clockwise", "M4 S1200", "m04.ngc";
    50 Spindle none "$" => "spindle off", "M5", "m05.ngc";
    60 ToolChange none "" => "change to the selected tool", "T2 M6", "m06.ngc";
    70 Coolant none "" => "mist on", "M7", "m07.ngc";
    80 Coolant none "" => "flood on", "M8", "m08.ngc";
    90 Coolant none "" => "coolant off", "M9", "m09.ngc";
    190 Spindle none "RPQ$" => "turn the spindle to an angle", "M19 R90 Q2", "m19.ngc";
    300 Stop none "" => "end of the program", "M30", "m30.ngc";
    480 Override none "" => "allow overrides of feed and speed", "M48", "m48.ngc";
    490 Override none "" => "forbid overrides of feed and speed", "M49", "m49.ngc";
    500 Override none "P" => "feed override on, off with P0", "M50 P0", "m50.ngc";
    510 Override none "P$" => "speed override on, off with P0", "M51 P0", "m51.ngc";
    520 Override none "P" => "adaptive feed on, off with P0", "M52 P0", "m52.ngc";
    530 Override none "P" => "feed hold on, off with P0", "M53 P0", "m53.ngc";
    600 Stop none "" => "exchange pallets and stop", "M60", "m60.ngc";
    610 ToolChange none "Q" => "the tool in the spindle is Q", "M61 Q3", "m61.ngc";
    620 Output none "P" => "digital output on, with the next move", "M62 P1", "m62.ngc";
    630 Output none "P" => "digital output off, with the next move", "M63 P1", "m63.ngc";
    640 Output none "P" => "digital output on", "M64 P1", "m64.ngc";
    650 Output none "P" => "digital output off", "M65 P1", "m65.ngc";
    660 Output none "PELQ" => "read an input into #5399", "M66 P1 L3 Q2", "m66.ngc";
    670 Output none "EQ" => "analogue output, with the next move", "M67 E1 Q2.5", "m67.ngc";
    680 Output none "EQ" => "analogue output", "M68 E1 Q2.5", "m68.ngc";
    700 ModalState none "" => "save the modes", "M70", "m70.ngc";
    710 ModalState none "" => "forget the saved modes", "M71", "m71.ngc";
    720 ModalState none "" => "bring the saved modes back", "M72", "m72.ngc";
    730 ModalState none "" => "save the modes until the subroutine returns", "M73", "m73.ngc";
    980 Stop none "PL" => "call subroutine P, L times", "M98 P100 L2", "m98.ngc";
    990 Stop none "P" => "return from a subroutine", "M99", "m99.ngc";
}
}
