//! G28 and G30 by way of a point that was not meant.

use super::Check;
use super::moves::{Leg, has_g};
use super::rules::{Lint, LintFindings, LintRule, rule};
use lostmotion_gcode::program::Event;

/// The lints of this file.
pub(super) const LINTS: Lint = Lint {
    rules: &[&HOME_ABSOLUTE],
    check: || Box::new(Home),
};

static HOME_ABSOLUTE: LintRule = rule(
    "home-absolute",
    "G28 or G30 in G90 goes through the point that is named first.",
    "`G28 Z0` in G90 rapids to Z0 of the work before it goes home. Write `G91 G28 Z0`, or `G53 G0 Z0`.",
);

pub(super) struct Home;

impl Check for Home {
    fn block(&mut self, event: &Event<'_>, legs: &[Leg<'_>], found: &mut LintFindings) {
        let code = if has_g(event, 280) { "G28" } else { "G30" };
        if !event.after.absolute || !(has_g(event, 280) || has_g(event, 300)) {
            return;
        }
        // The first leg of G28 and G30 leads to the named point, the second one home.
        let Some(by_way) = legs.first() else { return };
        let (z, to_z, unit) = (by_way.start[2], by_way.end[2], event.after.units.name());
        let sideways = by_way
            .start
            .iter()
            .zip(&by_way.end)
            .enumerate()
            .any(|(axis, (from, to))| axis != 2 && from != to);
        let values = [("from_z", z), ("to_z", to_z)];
        // Down towards the work, or sideways while below its surface.
        if to_z < z {
            let message = format!(
                "{code} in G90 first rapids down from Z{z} to Z{to_z} {unit} of the work, then home"
            );
            found.add(
                &HOME_ABSOLUTE,
                event.place,
                message,
                &values,
                &format!("G91 {code} Z0 goes straight home"),
            );
        } else if sideways && z < 0.0 {
            let message = format!(
                "{code} in G90 first rapids to the point it names, at Z{z} {unit} below Z0"
            );
            found.add(
                &HOME_ABSOLUTE,
                event.place,
                message,
                &values,
                "retract Z first",
            );
        }
    }
}
