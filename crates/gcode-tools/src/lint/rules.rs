//! The table of lints.

use super::level::Level;
use std::fmt::Write;

/// One lint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LintRule {
    /// Stable name, kebab case.
    pub code: &'static str,
    /// What is done about it unless the user says otherwise.
    pub level: Level,
    /// What has been found.
    pub summary: &'static str,
    /// Why it matters, and what to do.
    pub advice: &'static str,
}

const fn rule(code: &'static str, summary: &'static str, advice: &'static str) -> LintRule {
    LintRule {
        code,
        level: Level::Warn,
        summary,
        advice,
    }
}

/// Makes a static for every rule and the list of all.
macro_rules! rules {
    ($($name:ident: $code:literal, $summary:literal, $advice:literal;)*) => {
        $(pub(crate) static $name: LintRule = rule($code, $summary, $advice);)*
        static ALL: &[&LintRule] = &[$(&$name),*];
    };
}

rules! {
    UNSET_UNITS: "unset-units", "The program moves before it has said G20 or G21.", "It runs in whatever units the control was left in. Put G21 or G20 into the first lines.";
    UNSET_DISTANCE: "unset-distance", "The program moves before it has said G90 or G91.", "After a program that was stopped in G91 it cuts something else. Put G90 into the first lines.";
    UNSET_PLANE: "unset-plane", "An arc or cycle before G17, G18 or G19.", "In another plane the arc is refused, or is another one. Put G17 into the first lines.";
    UNSET_FEED_MODE: "unset-feed-mode", "A feed move before G93, G94 or G95.", "In a control left in G95 every feed is per revolution. Put G94 into the first lines.";
    UNSET_WORK_OFFSET: "unset-work-offset", "The program moves before it has selected a work coordinate system.", "It runs in the one that was used last. Put G54 into the first lines.";
    DWELL_ENDLESS: "dwell-endless", "A dwell of an hour or more.", "P is in seconds. On some controls it is in milliseconds; a post processor for those writes P1000 for a second.";
    DWELL_MILLISECONDS: "dwell-milliseconds", "A dwell of 100 s or more in whole seconds: the number looks like milliseconds.", "P is in seconds: half a second is P0.5.";
    RAPID_PLUNGE: "rapid-plunge", "A rapid goes down below Z0.", "At Z0 there usually is material. Go down at feed (G1) from a clearance above it. Not reported for a hole that a feed at the same place has cut to that depth, for cycles, or for G18.";
    RAPID_BELOW_SURFACE: "rapid-below-surface", "A rapid moves sideways below Z0.", "Retract first, or use G1.";
    ARC_NEARLY_FULL: "arc-nearly-full", "The ends of an arc are as near to each other as the coordinates were rounded.", "By the rounding it is nearly nothing or nearly a full circle, and controls differ. Write a full circle without an end point, or leave the arc out.";
    ARC_NEARLY_HALF: "arc-nearly-half", "An arc by radius of nearly 180 degrees: rounding of R moves its centre by far more.", "Give the centre with I, J, K.";
    ARC_CENTERS_MIXED: "arc-centers-mixed", "The program has arcs with absolute centres (G90.1) and with relative ones (G91.1).", "One of the two is likely to be a leftover.";
    FEED_UNITS: "feed-units", "A feed rate that looks like one in other units.", "Check G20 and G21, G94 and G95, and the post processor.";
    SPINDLE_OFF: "spindle-off", "A feed below Z0 while the spindle stands still, in a program that starts it elsewhere.", "M6, M5 and M2 stop the spindle: start it again with M3 S.";
    SPINDLE_NEVER_STARTED: "spindle-never-started", "The program cuts below Z0 and never starts the spindle.", "Add M3 S; if the spindle is switched by hand, switch this lint off.";
    SPINDLE_NO_SPEED: "spindle-no-speed", "The spindle is started before any S.", "It turns at whatever speed was set last. Put S on the line of M3 or before it.";
    TAP_FEED: "tap-feed", "The feed and the speed of a tapping cycle make a pitch that no usual tap has.", "The tap breaks or strips the thread. F has to be the pitch times S. Compared with ISO 261 and the inch series, within 1 %.";
    UNITS_CHANGED: "units-changed", "G20 or G21 changes the units after the program has moved.", "F, cycle words and parameters keep their numbers and mean something else. Change units only at the start.";
    LINE_NUMBER_TWICE: "line-number-twice", "Two lines have the same N number.", "A jump or an operator who searches for it may end up at the other one. Numbers that begin anew (after N9000 and beyond, or from a subroutine's start) are not reported; of a row of such lines the first is.";
    TOOL_LENGTH_MISSING: "tool-length-missing", "After a tool change Z moves without G43.", "The length of the tool before, or none, is still in force: put G43 H after M6.";
    TOOL_LENGTH_OTHER: "tool-length-other", "G43 takes the length of another tool than the one in the spindle.", "Check H against T.";
    TOOL_CHANGE_LOW: "tool-change-low", "A tool change below Z0.", "Retract before M6; some controls change the tool where it is.";
    HOME_ABSOLUTE: "home-absolute", "G28 or G30 in G90 goes through the point that is named first.", "`G28 Z0` in G90 rapids to Z0 of the work before it goes home. Write `G91 G28 Z0`, or `G53 G0 Z0`.";
    COMPENSATION_LEFT_ON: "compensation-left-on", "The program ends under cutter compensation.", "End it with G40 on a straight move off the work.";
    SPINDLE_LEFT_ON: "spindle-left-on", "The program ends without M2 or M30 while the spindle turns.", "Add M5, or end with M2 or M30.";
    COOLANT_LEFT_ON: "coolant-left-on", "The program ends without M2 or M30 while the coolant is on.", "Add M9, or end with M2 or M30.";
    OFFSET_LEFT_ON: "offset-left-on", "The program ends with an offset of G92 or G52 in force.", "It shifts the next program. Put G92.1 before the end.";
    UNUSED_PARAMETER: "unused-parameter", "A parameter is set and never read.", "It may be misspelt where it is meant to be read. Not reported if parameters are read by computed numbers, or other files are called.";
    UNREACHABLE_SUB: "unreachable-sub", "A subroutine is never called.", "Its name may be misspelt in the call. Not reported if a call computes its name, or the file holds nothing but subroutines.";
    CODE_AFTER_END: "code-after-end", "There are blocks after the end of the program.", "They never run: nothing after M2, M30 or the second `%` does, except subroutines.";
    OUTSIDE_TRAVEL: "outside-travel", "A move leaves the travel of the machine that was named.", "Check the work offset, or take another machine. Only with `--machine`.";
}

/// All lints.
pub fn all() -> impl Iterator<Item = &'static LintRule> {
    ALL.iter().copied()
}

/// The lint of a code.
pub fn find(code: &str) -> Option<&'static LintRule> {
    all().find(|rule| rule.code == code)
}

/// The lints' part of `docs/book/src/reference/diagnostics.md`, in Markdown.
pub fn page() -> String {
    let mut page = String::from(
        "\n## Lints\n\n`lostmotion lint PART` reports these besides. `--allow CODE` switches one off, `--deny CODE` makes it an error, `--warn CODE` switches one on that \
         is off.\n\n| code | | what has been found | why it matters, what to do |\n|---|---|---|---|\n",
    );
    for rule in all() {
        // Writing to a String cannot fail.
        let _ = writeln!(
            page,
            "| `{}` | {} | {} | {} |",
            rule.code,
            rule.level.name(),
            rule.summary.replace('|', "\\|"),
            rule.advice.replace('|', "\\|")
        );
    }
    page
}
