//! Tool changes and tool lengths.

use super::Check;
use super::moves::{Leg, has_g, in_machine, is_lathe};
use super::rules::{Lint, LintFindings, LintRule, rule};
use lostmotion_base::span::BlockRef;
use lostmotion_gcode::ops::CanonicalOp;
use lostmotion_gcode::program::Event;

/// The lints of this file.
pub(super) const LINTS: Lint = Lint {
    rules: &[&TOOL_LENGTH_MISSING, &TOOL_LENGTH_OTHER, &TOOL_CHANGE_LOW],
    check: || Box::new(Tools::default()),
};

static TOOL_LENGTH_MISSING: LintRule = rule(
    "tool-length-missing",
    "After a tool change Z moves without G43.",
    "The length of the tool before, or none, is still in force: put G43 H after M6.",
);

static TOOL_LENGTH_OTHER: LintRule = rule(
    "tool-length-other",
    "G43 takes the length of another tool than the one in the spindle.",
    "Check H against T.",
);

static TOOL_CHANGE_LOW: LintRule = rule(
    "tool-change-low",
    "A tool change below Z0.",
    "Retract before M6; some controls change the tool where it is.",
);

/// The last tool change and whether a length has come after it.
#[derive(Debug, Default)]
pub(super) struct Tools {
    /// Tool and line of a change that no length has followed.
    changed: Option<(i32, u32)>,
    missing: Vec<(BlockRef, i32, u32)>,
    applied: bool,
}

/// Most changes without a length that are remembered.
const MOST_CHANGES: usize = 20;

impl Tools {
    fn change(&mut self, event: &Event<'_>, tool: i32, found: &mut LintFindings) {
        let z = event.before.current[2];
        // T0 empties the spindle: it needs no length.
        self.changed = (tool != 0).then_some((tool, event.place.span.line));
        if z < 0.0 && !is_lathe(event.after) {
            let message = format!(
                "the tool is changed at Z{z} {}, below Z0",
                event.after.units.name()
            );
            found.add(
                &TOOL_CHANGE_LOW,
                event.place,
                message,
                &[("z", z)],
                "retract before M6",
            );
        }
    }

    fn length(&mut self, event: &Event<'_>, found: &mut LintFindings) {
        if has_g(event, 490) {
            return;
        }
        (self.applied, self.changed) = (true, None);
        let h = event
            .block()
            .words
            .iter()
            .find(|word| word.letter == b'H')
            .and_then(|word| event.interpreter.value_of(word));
        // H0 and an empty spindle say nothing about another tool.
        let loaded = f64::from(event.after.loaded_tool);
        if let Some(h) = h.filter(|h| {
            (has_g(event, 430) || has_g(event, 440)) && *h != 0.0 && loaded != 0.0 && *h != loaded
        }) {
            let message =
                format!("H{h} is the length of tool {h}, but tool {loaded} is in the spindle");
            found.add(
                &TOOL_LENGTH_OTHER,
                event.place,
                message,
                &[("h", h), ("tool", loaded)],
                &format!("H{loaded}?"),
            );
        }
    }
}

impl Check for Tools {
    fn block(&mut self, event: &Event<'_>, legs: &[Leg<'_>], found: &mut LintFindings) {
        for sourced in event.ops {
            match sourced.op {
                CanonicalOp::ChangeTool(tool) => self.change(event, tool, found),
                CanonicalOp::UseToolLengthOffset(_) => self.length(event, found),
                _ => {}
            }
        }
        // A move in machine coordinates retracts without a length, rightly.
        let moves_z = || !in_machine(event) && legs.iter().any(|leg| leg.start[2] != leg.end[2]);
        if let Some((tool, line)) = self.changed.filter(|_| moves_z()) {
            self.changed = None;
            if self.missing.len() < MOST_CHANGES {
                self.missing.push((event.place, tool, line));
            }
        }
    }

    fn end(&mut self, _: BlockRef, found: &mut LintFindings) {
        // A program without any G43 is made for tools that are set up by hand: one finding is enough.
        let shown = if self.applied { self.missing.len() } else { 1 };
        for (place, tool, line) in self.missing.iter().take(shown) {
            let message = format!(
                "Z moves, but no tool length has been applied since tool {tool} came in line {line}"
            );
            found.add(
                &TOOL_LENGTH_MISSING,
                *place,
                message,
                &[("tool", f64::from(*tool))],
                &format!("put G43 H{tool} before it"),
            );
        }
    }
}
