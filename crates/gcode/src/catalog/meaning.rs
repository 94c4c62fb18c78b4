//! Rows about what a program means: feeds, arcs, tools, curves, cycles.

use super::{CatalogRow, error, warning};

pub(super) const ROWS: &[CatalogRow] = &[
    error(
        "no-feed",
        "A feed move without a feed rate.",
        "Set F first. Changing between G93, G94 and G95 forgets the feed.",
    ),
    warning(
        "feed-before-units",
        "F stands on the line that changes the units, and is taken in the old ones.",
        "Put F on the next line.",
    ),
    error(
        "no-inverse-time-feed",
        "A move in inverse time (G93) without F on its line.",
        "G93 needs F on every G1, G2 and G3.",
    ),
    error(
        "no-revolutions",
        "Feed per revolution while the spindle does not turn.",
        "Start the spindle, or use G94.",
    ),
    error(
        "arc-radii",
        "The centre of an arc is not as far from its end as from its start.",
        "Check whether I, J and K are relative to the start (G91.1) or absolute (G90.1).",
    ),
    error(
        "arc-too-small",
        "The radius of an arc is too small.",
        "Replace it by a straight move.",
    ),
    error(
        "arc-radius-short",
        "R is too small for the distance between the ends.",
        "Check R, and whether the start is where it is meant to be.",
    ),
    error(
        "arc-same-point",
        "An arc by radius ends where it begins.",
        "Write a full circle with I, J or K.",
    ),
    error(
        "arc-without-center",
        "An arc has neither R nor a centre.",
        "Add R, or the two letters of the plane.",
    ),
    error(
        "arc-two-formats",
        "An arc has both R and a centre.",
        "Remove one of them.",
    ),
    error(
        "arc-off-plane",
        "The centre of an arc has a letter outside its plane.",
        "Select the plane (G17, G18, G19), or remove the letter.",
    ),
    error(
        "arc-center-word",
        "An absolute centre lacks one of its letters.",
        "In G90.1 both letters of the plane are needed.",
    ),
    error(
        "g53-without-motion",
        "G53 without G0 or G1.",
        "Put G0 or G1 on its line.",
    ),
    error(
        "g53-incremental",
        "G53 in incremental distances.",
        "Put G90 before it.",
    ),
    error(
        "no-such-tool",
        "The tool is not in the tool table.",
        "Check the number, or add the tool.",
    ),
    warning(
        "no-tool-table",
        "A tool's length is asked for, and there is no tool table.",
        "Name the tool table; without it every length is 0.",
    ),
    error(
        "no-tool-selected",
        "M6 before any T.",
        "Select a tool with T.",
    ),
    error(
        "tool-table",
        "The tool table cannot be read.",
        "See the message for line and word.",
    ),
    error(
        "coordinate-too-large",
        "A coordinate is beyond the limit.",
        "Check the value; the limit `coordinate` can be raised.",
    ),
    warning(
        "negative-dwell",
        "A dwell of less than zero seconds.",
        "Write a positive P.",
    ),
    error(
        "dwell-too-long",
        "A dwell is longer than the limit.",
        "P is in seconds; the limit `dwell_s` can be raised.",
    ),
    error(
        "spindle-stopped",
        "A move in step with the spindle while it does not turn.",
        "Start it with M3 or M4.",
    ),
    error(
        "probe-feed",
        "A probing move in feed per revolution.",
        "Put G94 and F before it.",
    ),
    error(
        "probe-too-short",
        "A probing move begins where it ends.",
        "Program a way to go.",
    ),
    error(
        "curve",
        "A spline or NURBS is not as it has to be.",
        "See the message.",
    ),
    error(
        "curve-too-long",
        "A NURBS has more control points than the limit.",
        "Split it, or raise the limit `curve_points`.",
    ),
    error(
        "polar",
        "Polar coordinates are not as they have to be.",
        "See the message.",
    ),
    error(
        "nothing-saved",
        "M72 without M70 or M73 before it, or after M71.",
        "Save the modes first, at the same level of calls.",
    ),
    error(
        "no-motion-for",
        "What the program asks for can be read, but not yet moved.",
        "Replace it by lines and arcs.",
    ),
    error(
        "compensation",
        "Cutter compensation cannot be carried out.",
        "See the message; often the tool's radius is larger than the corner allows.",
    ),
    warning(
        "endless-main",
        "M99 in the main program would start it again.",
        "End the program with M2 or M30.",
    ),
    error(
        "cycle",
        "A canned cycle is not as it has to be.",
        "See the message.",
    ),
    error(
        "turning-plane",
        "A turning cycle outside the ZX plane.",
        "Put G18 before it.",
    ),
    error(
        "profile-empty",
        "The profile of a turning cycle has no moves.",
        "The first move leads to the profile, the others are the profile.",
    ),
    error(
        "profile-turns-back",
        "The profile of a turning cycle goes back along its direction of travel.",
        "It must not turn back in Z for G71, in X for G72, and in one of them for G70.",
    ),
    error(
        "profile-code",
        "A code that moves in another way stands in a profile.",
        "A profile consists of G0, G1, G2 and G3.",
    ),
    error(
        "profile-corner",
        "A or C in a profile cannot be made.",
        "It has to be positive and smaller than the moves it stands between.",
    ),
    error(
        "profile-increment",
        "U or W in a profile while coordinates are incremental.",
        "X and Z are incremental already.",
    ),
    error(
        "profile-distance",
        "A profile has no room for the distance that is to remain.",
        "Reduce D, or widen the grooves of the profile.",
    ),
    error(
        "no-axis",
        "The program moves an axis that the machine does not have.",
        "Take a machine with that axis: see `lostmotion machine list`.",
    ),
    error("path", "A move has no geometry.", "See the message."),
    error(
        "cycle-too-long",
        "A cycle makes more moves than the limit.",
        "Check Q and L, or raise the limit `cycle_moves`.",
    ),
    error(
        "radius-too-large",
        "An arc has a radius beyond the limit.",
        "Check I, J, K or R; the limit can be raised.",
    ),
    error(
        "feed-too-large",
        "A feed rate is beyond the limit.",
        "Check F and the units; the limit can be raised.",
    ),
    error(
        "too-many-operations",
        "Loops and subroutines make more operations at a stretch than the limit.",
        "Check what ends the loop; the limit can be raised.",
    ),
    error(
        "no-such-line",
        "A jump or a local call leads to a line number that is not there.",
        "Give the line its N number.",
    ),
    error(
        "wrong-checksum",
        "The checksum of a line does not fit it.",
        "The line has been changed or damaged; make the checksum anew or remove it.",
    ),
    error(
        "siemens",
        "A block is of Siemens (Sinumerik), whose programs are not read.",
        "Post-process the part for another control.",
    ),
    error(
        "heidenhain",
        "The program is in Heidenhain's conversational language.",
        "Post-process the part for a control that reads G-code.",
    ),
    error(
        "corner",
        "A corner (`,R` or `,C`) cannot be made.",
        "It needs two straight moves in the plane, both long enough.",
    ),
    error(
        "five-axis-use",
        "A five-axis code cannot be used here.",
        "See the message for what has to come before it.",
    ),
    warning(
        "spindle-assumed",
        "A move follows the spindle, which is taken to turn at its programmed speed.",
        "Nothing: real spindles slow down where they reverse, which the plan does not know.",
    ),
];
