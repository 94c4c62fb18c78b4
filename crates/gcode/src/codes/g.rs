//! G codes.

use super::row::{AxisUse, CodeRow, Group, Texts, row};
use crate::dialect::Leniency;

const NONE: AxisUse = AxisUse::None;
const MAY: AxisUse = AxisUse::May;
const NEEDS: AxisUse = AxisUse::Needs;

const fn g(tenths: u16, group: Group, uses: (AxisUse, &'static str), texts: Texts) -> CodeRow {
    row('G', tenths, group, uses, texts)
}

/// All G codes in the order of their numbers.
pub(crate) const ROWS: &[CodeRow] = &[
    g(
        0,
        Group::Motion,
        (MAY, ""),
        ["traverse in a straight line", "G0 X10 Y5", "g00.ngc"],
    ),
    g(
        10,
        Group::Motion,
        (MAY, ""),
        ["feed in a straight line", "G1 X10 F200", "g01.ngc"],
    ),
    g(
        20,
        Group::Motion,
        (MAY, "IJKRP"),
        ["arc or helix, clockwise", "G2 X10 Y0 I5 J0", "g02.ngc"],
    ),
    g(
        30,
        Group::Motion,
        (MAY, "IJKRP"),
        ["arc or helix, counter-clockwise", "G3 X10 Y0 R5", "g03.ngc"],
    ),
    g(
        40,
        Group::NonModal,
        (NONE, "P"),
        ["dwell for P seconds", "G4 P0.5", "g04.ngc"],
    ),
    g(
        50,
        Group::Motion,
        (MAY, "IJPQ"),
        ["cubic spline", "G5 X2 Y2 I0 J3 P0 Q-3", "g05.ngc"],
    ),
    g(
        51,
        Group::Motion,
        (MAY, "IJ"),
        ["quadratic spline", "G5.1 X4 I2 J4", "g05_1.ngc"],
    ),
    g(
        52,
        Group::Motion,
        (MAY, "PL"),
        ["control points of a NURBS", "G5.2 X1 Y1 P1 L3", "g05_2.ngc"],
    ),
    g(
        53,
        Group::Motion,
        (NONE, ""),
        ["end of the NURBS, which is then run", "G5.3", "g05_3.ngc"],
    ),
    g(
        70,
        Group::Diameter,
        (NONE, ""),
        ["X is a diameter", "G7", "g07.ngc"],
    ),
    g(
        80,
        Group::Diameter,
        (NONE, ""),
        ["X is a radius", "G8", "g08.ngc"],
    ),
    g(
        100,
        Group::NonModal,
        (MAY, "LPRIJQ"),
        [
            "coordinate systems (L2, L20) and tools (L1, L10, L11)",
            "G10 L2 P1 X10",
            "g10.ngc",
        ],
    ),
    g(
        120,
        Group::NonModal,
        (MAY, "IKQD"),
        [
            "circular pocket, clockwise (Haas)",
            "G12 I5 Z-2 F200",
            "g12.ngc",
        ],
    )
    .only_with(Leniency::CircularPockets),
    g(
        130,
        Group::NonModal,
        (MAY, "IKQD"),
        [
            "circular pocket, counter-clockwise (Haas)",
            "G13 I2 K8 Q2 Z-2 F200",
            "g13.ngc",
        ],
    )
    .only_with(Leniency::CircularPockets),
    g(
        170,
        Group::Plane,
        (NONE, ""),
        ["arcs in the XY plane", "G17", "g17.ngc"],
    ),
    g(
        180,
        Group::Plane,
        (NONE, ""),
        ["arcs in the ZX plane", "G18", "g18.ngc"],
    ),
    g(
        190,
        Group::Plane,
        (NONE, ""),
        ["arcs in the YZ plane", "G19", "g19.ngc"],
    ),
    g(200, Group::Units, (NONE, ""), ["inches", "G20", "g20.ngc"]),
    g(
        210,
        Group::Units,
        (NONE, ""),
        ["millimetres", "G21", "g21.ngc"],
    ),
    g(
        280,
        Group::NonModal,
        (MAY, ""),
        ["home by way of a point", "G28 Z10", "g28.ngc"],
    ),
    g(
        281,
        Group::NonModal,
        (NONE, ""),
        ["make this place the home of G28", "G28.1", "g28_1.ngc"],
    ),
    g(
        300,
        Group::NonModal,
        (MAY, ""),
        ["second home by way of a point", "G30 Z10", "g30.ngc"],
    ),
    g(
        301,
        Group::NonModal,
        (NONE, ""),
        ["make this place the home of G30", "G30.1", "g30_1.ngc"],
    ),
    g(
        330,
        Group::Motion,
        (NEEDS, "K$"),
        ["move in step with the spindle", "G33 Z-9 K1.5", "g33.ngc"],
    ),
    g(
        331,
        Group::Motion,
        (NEEDS, "KI$"),
        [
            "rigid tapping, there and back",
            "G33.1 Z-9 K1.5",
            "g33_1.ngc",
        ],
    ),
    g(
        382,
        Group::Motion,
        (NEEDS, ""),
        [
            "probe until contact, which has to come",
            "G38.2 Z-9",
            "g38_2.ngc",
        ],
    ),
    g(
        383,
        Group::Motion,
        (NEEDS, ""),
        ["probe until contact", "G38.3 Z-9", "g38_3.ngc"],
    ),
    g(
        384,
        Group::Motion,
        (NEEDS, ""),
        [
            "probe until contact is lost, which it has to be",
            "G38.4 Z9",
            "g38_4.ngc",
        ],
    ),
    g(
        385,
        Group::Motion,
        (NEEDS, ""),
        ["probe until contact is lost", "G38.5 Z9", "g38_5.ngc"],
    ),
    g(
        400,
        Group::CutterCompensation,
        (NONE, ""),
        ["cutter compensation off", "G40", "g40.ngc"],
    ),
    g(
        410,
        Group::CutterCompensation,
        (NONE, "D"),
        [
            "cutter compensation, tool left of the path",
            "G41 D3",
            "g41.ngc",
        ],
    ),
    g(
        411,
        Group::CutterCompensation,
        (NONE, "DL"),
        ["the same by the diameter", "G41.1 D6", "g41_1.ngc"],
    ),
    g(
        420,
        Group::CutterCompensation,
        (NONE, "D"),
        [
            "cutter compensation, tool right of the path",
            "G42 D3",
            "g42.ngc",
        ],
    ),
    g(
        421,
        Group::CutterCompensation,
        (NONE, "DL"),
        ["the same by the diameter", "G42.1 D6", "g42_1.ngc"],
    ),
    g(
        430,
        Group::ToolLength,
        (NONE, "H"),
        ["tool offset from the table", "G43 H3", "g43.ngc"],
    ),
    g(
        431,
        Group::ToolLength,
        (MAY, ""),
        ["tool offset from the line", "G43.1 Z12.5", "g43_1.ngc"],
    ),
    g(
        432,
        Group::ToolLength,
        (MAY, "H"),
        ["one more tool offset on top", "G43.2 H4", "g43_2.ngc"],
    ),
    g(
        434,
        Group::ToolLength,
        (NONE, "H"),
        [
            "X Y Z are the tool's tip, whatever the rotary axes do",
            "G43.4 H3",
            "g43_4.ngc",
        ],
    )
    .only_with(Leniency::FiveAxis),
    g(
        435,
        Group::ToolLength,
        (NONE, "H"),
        [
            "the same, I J K being the tool's direction",
            "G43.5 H3",
            "g43_5.ngc",
        ],
    )
    .only_with(Leniency::FiveAxis),
    g(
        490,
        Group::ToolLength,
        (NONE, ""),
        ["no tool offset", "G49", "g49.ngc"],
    ),
    g(
        520,
        Group::NonModal,
        (NEEDS, ""),
        ["shift of all coordinate systems", "G52 X5", "g52.ngc"],
    ),
    g(
        530,
        Group::NonModal,
        (NONE, ""),
        ["this move in machine coordinates", "G53 G0 Z0", "g53.ngc"],
    ),
    g(
        531,
        Group::NonModal,
        (NONE, ""),
        [
            "the tool stands upright on the tilted plane",
            "G53.1",
            "g53_1.ngc",
        ],
    )
    .only_with(Leniency::FiveAxis),
    g(
        540,
        Group::CoordinateSystem,
        (NONE, ""),
        ["coordinate system 1", "G54", "g54.ngc"],
    ),
    g(
        550,
        Group::CoordinateSystem,
        (NONE, ""),
        ["coordinate system 2", "G55", "g55.ngc"],
    ),
    g(
        560,
        Group::CoordinateSystem,
        (NONE, ""),
        ["coordinate system 3", "G56", "g56.ngc"],
    ),
    g(
        570,
        Group::CoordinateSystem,
        (NONE, ""),
        ["coordinate system 4", "G57", "g57.ngc"],
    ),
    g(
        580,
        Group::CoordinateSystem,
        (NONE, ""),
        ["coordinate system 5", "G58", "g58.ngc"],
    ),
    g(
        590,
        Group::CoordinateSystem,
        (NONE, ""),
        ["coordinate system 6", "G59", "g59.ngc"],
    ),
    g(
        591,
        Group::CoordinateSystem,
        (NONE, ""),
        ["coordinate system 7", "G59.1", "g59_1.ngc"],
    ),
    g(
        592,
        Group::CoordinateSystem,
        (NONE, ""),
        ["coordinate system 8", "G59.2", "g59_2.ngc"],
    ),
    g(
        593,
        Group::CoordinateSystem,
        (NONE, ""),
        ["coordinate system 9", "G59.3", "g59_3.ngc"],
    ),
    g(
        610,
        Group::PathControl,
        (NONE, ""),
        ["exact path", "G61", "g61.ngc"],
    ),
    g(
        611,
        Group::PathControl,
        (NONE, ""),
        ["exact stop", "G61.1", "g61_1.ngc"],
    ),
    g(
        640,
        Group::PathControl,
        (NONE, "PQ"),
        ["rounded corners within P", "G64 P0.05 Q0.01", "g64.ngc"],
    ),
    g(
        680,
        Group::NonModal,
        (MAY, "R"),
        [
            "coordinates turned by R about X Y",
            "G68 X5 Y5 R30",
            "g68.ngc",
        ],
    )
    .only_with(Leniency::FiveAxis),
    g(
        682,
        Group::NonModal,
        (MAY, "IJK"),
        ["tilted plane", "G68.2 X0 Y0 Z10 I0 J30 K0", "g68_2.ngc"],
    )
    .only_with(Leniency::FiveAxis),
    g(
        690,
        Group::NonModal,
        (NONE, ""),
        ["coordinates not turned any more", "G69", "g69.ngc"],
    )
    .only_with(Leniency::FiveAxis),
    g(
        700,
        Group::Motion,
        (MAY, "QDEP"),
        [
            "finish along a profile, subroutine Q",
            "G70 Q100 X20 Z2 D0.5 P2",
            "g70.ngc",
        ],
    ),
    g(
        710,
        Group::Motion,
        (MAY, "QDIR"),
        [
            "rough a profile along Z",
            "G71 Q100 X20 Z2 D0.5 I1 R0.5",
            "g71.ngc",
        ],
    ),
    g(
        711,
        Group::Motion,
        (MAY, "QDIR"),
        [
            "the same without pockets",
            "G71.1 Q100 X20 Z2 D0.5 I1 R0.5",
            "g71_1.ngc",
        ],
    ),
    g(
        712,
        Group::Motion,
        (MAY, "QDIR"),
        [
            "the same, only later pockets",
            "G71.2 Q100 X20 Z2 D0.3 I1 R0.5",
            "g71_2.ngc",
        ],
    ),
    g(
        720,
        Group::Motion,
        (MAY, "QDIR"),
        [
            "rough a profile along X",
            "G72 Q100 X20 Z2 D0.5 I1 R0.5",
            "g72.ngc",
        ],
    ),
    g(
        721,
        Group::Motion,
        (MAY, "QDIR"),
        [
            "the same without pockets",
            "G72.1 Q100 X20 Z2 D0.5 I1 R0.5",
            "g72_1.ngc",
        ],
    ),
    g(
        722,
        Group::Motion,
        (MAY, "QDIR"),
        [
            "the same, only later pockets",
            "G72.2 Q100 X20 Z2 D0.3 I1 R0.5",
            "g72_2.ngc",
        ],
    ),
    g(
        730,
        Group::Motion,
        (NEEDS, "RQLP"),
        ["drill with chip breaking", "G73 X1 Z-9 R1 Q2", "g73.ngc"],
    ),
    g(
        740,
        Group::Motion,
        (NEEDS, "RLP$"),
        ["tap, left-handed", "G74 X1 Z-9 R1", "g74.ngc"],
    ),
    g(
        760,
        Group::Motion,
        (NEEDS, "PIJKRQHEL"),
        [
            "thread in several passes",
            "G76 Z-20 P1.5 I-1 J0.2 K0.9 R2 Q29.5 H1 E1 L2",
            "g76.ngc",
        ],
    ),
    g(
        800,
        Group::Motion,
        (NONE, ""),
        ["end of the motion mode", "G80", "g80.ngc"],
    ),
    g(
        810,
        Group::Motion,
        (NEEDS, "RLPQ"),
        ["drill", "G81 X1 Z-9 R1", "g81.ngc"],
    ),
    g(
        820,
        Group::Motion,
        (NEEDS, "RLPQ"),
        ["drill with dwell", "G82 X1 Z-9 R1 P0.5", "g82.ngc"],
    ),
    g(
        830,
        Group::Motion,
        (NEEDS, "RLPQ"),
        ["drill in pecks", "G83 X1 Z-9 R1 Q2", "g83.ngc"],
    ),
    g(
        840,
        Group::Motion,
        (NEEDS, "RLPQ$"),
        ["tap, right-handed", "G84 X1 Z-9 R1", "g84.ngc"],
    ),
    g(
        850,
        Group::Motion,
        (NEEDS, "RLPQ"),
        ["bore, feed out", "G85 X1 Z-9 R1", "g85.ngc"],
    ),
    g(
        860,
        Group::Motion,
        (NEEDS, "RLPQ"),
        ["bore, stop, rapid out", "G86 X1 Z-9 R1 P0.5", "g86.ngc"],
    ),
    g(
        870,
        Group::Motion,
        (NEEDS, "RLPQIJK"),
        ["bore from behind", "G87 X1 Z-9 R1 I1 J0 K-7", "g87.ngc"],
    ),
    g(
        880,
        Group::Motion,
        (NEEDS, "RLPQ"),
        ["bore, stop, manual out", "G88 X1 Z-9 R1 P0.5", "g88.ngc"],
    ),
    g(
        890,
        Group::Motion,
        (NEEDS, "RLPQ"),
        ["bore, dwell, feed out", "G89 X1 Z-9 R1 P0.5", "g89.ngc"],
    ),
    g(
        900,
        Group::Distance,
        (NONE, ""),
        ["absolute coordinates", "G90", "g90.ngc"],
    ),
    g(
        901,
        Group::ArcDistance,
        (NONE, ""),
        ["absolute arc centres", "G90.1", "g90_1.ngc"],
    ),
    g(
        910,
        Group::Distance,
        (NONE, ""),
        ["incremental coordinates", "G91", "g91.ngc"],
    ),
    g(
        911,
        Group::ArcDistance,
        (NONE, ""),
        ["arc centres relative to the start", "G91.1", "g91_1.ngc"],
    ),
    g(
        920,
        Group::NonModal,
        (NEEDS, ""),
        [
            "this place has the given coordinates",
            "G92 X0 Y0",
            "g92.ngc",
        ],
    ),
    g(
        921,
        Group::AxisOffset,
        (NONE, ""),
        ["forget the G92 offset", "G92.1", "g92_1.ngc"],
    ),
    g(
        922,
        Group::AxisOffset,
        (NONE, ""),
        ["suspend the G92 offset", "G92.2", "g92_2.ngc"],
    ),
    g(
        923,
        Group::AxisOffset,
        (NONE, ""),
        ["restore the G92 offset", "G92.3", "g92_3.ngc"],
    ),
    g(
        930,
        Group::FeedMode,
        (NONE, ""),
        ["F in moves per minute", "G93", "g93.ngc"],
    ),
    g(
        940,
        Group::FeedMode,
        (NONE, ""),
        ["F in units per minute", "G94", "g94.ngc"],
    ),
    g(
        950,
        Group::FeedMode,
        (NONE, ""),
        ["F in units per revolution", "G95", "g95.ngc"],
    ),
    g(
        960,
        Group::SpindleMode,
        (NONE, "D$"),
        ["constant surface speed", "G96 S100 D2500", "g96.ngc"],
    ),
    g(
        970,
        Group::SpindleMode,
        (NONE, "$"),
        ["S in rev/min", "G97 S500", "g97.ngc"],
    ),
    g(
        980,
        Group::Retract,
        (NONE, ""),
        ["cycles end where they began", "G98", "g98.ngc"],
    ),
    g(
        990,
        Group::Retract,
        (NONE, ""),
        ["cycles end at R", "G99", "g99.ngc"],
    ),
];
