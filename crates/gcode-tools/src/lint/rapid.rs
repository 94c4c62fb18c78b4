//! Rapids below the surface of the work, and G28 and G30 by way of a point that was not meant.

use super::Check;
use super::moves::{Leg, has_g, in_cycle, in_machine, is_feed, is_lathe};
use super::rules::{Lint, LintFindings, LintRule, rule};
use lostmotion_gcode::ops::CanonicalOp;
use lostmotion_gcode::program::Event;

/// Rapids below the surface.
pub(super) const RAPID: Lint = Lint {
    rules: &[&RAPID_PLUNGE, &RAPID_BELOW_SURFACE],
    check: || Box::new(Rapid::default()),
};

static RAPID_PLUNGE: LintRule = rule(
    "rapid-plunge",
    "A rapid goes down below Z0.",
    "At Z0 there usually is material. Go down at feed (G1) from a clearance above it. Not reported for a hole that a feed at the same place has cut to that depth, for cycles, or for G18.",
);

static RAPID_BELOW_SURFACE: LintRule = rule(
    "rapid-below-surface",
    "A rapid moves sideways below Z0.",
    "Retract first, or use G1. Not reported after a Z in machine coordinates (G53, G28, G30) or a new offset, until Z is programmed again: how far above the work that is, only the machine knows.",
);

/// Largest difference of coordinates that counts as rounding, program units.
const SAME_COORDINATE: f64 = 1e-6;

/// How deep feeds have cut at the present place in X and Y, and whether Z is known over the work.
#[derive(Debug, Default)]
pub(super) struct Rapid {
    cut_z: Option<f64>,
    /// Z was moved in machine coordinates, or an offset has changed: how far above the work that is,
    /// only the machine knows.
    unknown_z: bool,
}

fn moves_sideways(leg: &Leg<'_>) -> bool {
    (leg.end[0] - leg.start[0]).abs() > SAME_COORDINATE
        || (leg.end[1] - leg.start[1]).abs() > SAME_COORDINATE
}

impl Rapid {
    /// Whether a block leaves Z at a height above the work that the program knows.
    fn follow_z(&mut self, event: &Event<'_>, moves: bool) {
        let words = &event.block().words;
        let names = |letters: &[u8]| words.iter().any(|word| letters.contains(&word.letter));
        let all_home = (has_g(event, 280) || has_g(event, 300)) && !names(b"XYZABCUVW");
        if in_machine(event) {
            self.unknown_z |= names(b"Z") || all_home;
        } else if names(b"Z") && (moves || has_g(event, 920)) {
            self.unknown_z = false;
        } else {
            self.unknown_z |= event.before.offsets != event.after.offsets;
        }
    }

    fn traverse(&self, leg: &Leg<'_>, event: &Event<'_>, found: &mut LintFindings) {
        let ([.., from, _, _, _, _, _, _], [.., to, _, _, _, _, _, _]) = (leg.start, leg.end);
        let unit = event.after.units.name();
        // Back into a hole that a feed has just cut: pecking does this.
        let into_own_hole =
            !moves_sideways(leg) && self.cut_z.is_some_and(|cut| to >= cut - SAME_COORDINATE);
        // Downwards below Z0 is a plunge; level or upwards below Z0 it can only hit sideways.
        if to < -SAME_COORDINATE && to < from - SAME_COORDINATE && !into_own_hole {
            let message = format!("a rapid goes down from Z{from} to Z{to} {unit}, below Z0");
            found.add(
                &RAPID_PLUNGE,
                event.place,
                message,
                &[("from_z", from), ("to_z", to)],
                "go down with G1 from above the work",
            );
        } else if to < -SAME_COORDINATE
            && from < -SAME_COORDINATE
            && moves_sideways(leg)
            && !self.unknown_z
        {
            let message = format!("a rapid moves sideways at Z{to} {unit}, below Z0");
            found.add(
                &RAPID_BELOW_SURFACE,
                event.place,
                message,
                &[("z", to)],
                "retract first, or use G1",
            );
        }
    }
}

impl Check for Rapid {
    fn block(&mut self, event: &Event<'_>, legs: &[Leg<'_>], found: &mut LintFindings) {
        let judged = !(in_machine(event) || in_cycle(event) || is_lathe(event.after));
        self.follow_z(event, !legs.is_empty());
        for leg in legs {
            if judged && matches!(leg.op, CanonicalOp::StraightTraverse(_)) {
                self.traverse(leg, event, found);
            }
            // A hole is known only at the place where it was cut.
            if moves_sideways(leg) {
                self.cut_z = None;
            }
            if is_feed(leg.op) {
                self.cut_z = Some(self.cut_z.map_or(leg.end[2], |cut| cut.min(leg.end[2])));
            }
        }
    }
}

/// Ways home through a point that was not meant.
pub(super) const HOME: Lint = Lint {
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
