//! Arcs whose shape depends on the rounding of the last digit.

use super::Check;
use super::moves::Leg;
use super::rules::{Lint, LintFindings, LintRule, rule};
use lostmotion_base::math;
use lostmotion_base::units::deg;
use lostmotion_gcode::ops::{ArcFeed, CanonicalOp, Position};
use lostmotion_gcode::program::Event;
use lostmotion_gcode::syntax::{Value, Word};
use std::f64::consts::{PI, TAU};

/// The lints of this file.
pub(super) const LINTS: Lint = Lint {
    rules: &[&ARC_NEARLY_FULL, &ARC_NEARLY_HALF, &ARC_CENTERS_MIXED],
    check: || Box::new(Arcs::default()),
};

static ARC_NEARLY_FULL: LintRule = rule(
    "arc-nearly-full",
    "The ends of an arc are as near to each other as the coordinates were rounded.",
    "By the rounding it is nearly a full circle or nearly nothing, and controls differ. Write a full circle without an end point, or leave the arc out.",
);

static ARC_NEARLY_HALF: LintRule = rule(
    "arc-nearly-half",
    "An arc by radius of nearly 180 degrees: rounding of R moves its centre by far more.",
    "Give the centre with I, J, K.",
);

static ARC_CENTERS_MIXED: LintRule = rule(
    "arc-centers-mixed",
    "The program has arcs with absolute centres (G90.1) and with relative ones (G91.1).",
    "One of the two is likely to be a leftover.",
);

/// Largest distance from a half circle at which an arc by radius is doubtful, degrees.
const NEARLY_HALF_DEG: f64 = 3.0;
/// Largest shift of the centre by rounding that does not matter, mm.
const CENTER_SHIFT_MM: f64 = 0.002;
/// Coordinates that are computed are taken for this many decimals.
const COMPUTED_DECIMALS: i32 = 4;

/// Arcs with absolute and with relative centres seen so far.
#[derive(Debug, Default)]
pub(super) struct Arcs {
    centers: [bool; 2],
}

/// The figures of an arc.
struct Shape {
    radius: f64,
    chord: f64,
    sweep: f64,
}

fn shape(start: &Position, arc: &ArcFeed) -> Shape {
    let [first, second, _] = arc.plane.axes();
    let from = [start[first] - arc.center[0], start[second] - arc.center[1]];
    let to = [arc.end[0] - arc.center[0], arc.end[1] - arc.center[1]];
    // Angle from the start's radius vector to the end's, by cross and dot product.
    let cross = from[0] * to[1] - from[1] * to[0];
    let turn = math::atan2(cross, from[0] * to[0] + from[1] * to[1]);
    let turn = if arc.turns > 0 { turn } else { -turn };
    let chord = math::hypot(to[0] - from[0], to[1] - from[1]);
    // In the arc's own direction the sweep is above zero and at most a full turn.
    let sweep = if turn <= 0.0 { turn + TAU } else { turn };
    Shape {
        radius: math::hypot(from[0], from[1]),
        chord,
        sweep,
    }
}

/// Most decimals that the words of an arc are written with.
fn decimals(event: &Event<'_>) -> i32 {
    let of = |word: &Word| {
        let from = word.text.start as usize;
        let text = event
            .interpreter
            .line()
            .get(from..from + word.text.len as usize)
            .unwrap_or_default();
        match word.value {
            // Digits after the point as written: they tell how the post processor rounds.
            Value::Number(_) => text
                .iter()
                .position(|byte| *byte == b'.')
                .map_or(0, |at| (text.len() - at - 1) as i32),
            Value::Ops(..) => COMPUTED_DECIMALS,
        }
    };
    event
        .block()
        .words
        .iter()
        .filter(|word| b"XYZIJKR".contains(&word.letter))
        .map(of)
        .max()
        .unwrap_or(0)
}

/// 10 to the power of minus `decimals`.
fn last_place(decimals: i32) -> f64 {
    (0..decimals.min(12)).fold(1.0, |place, _| place / 10.0)
}

impl Arcs {
    fn centers(&mut self, event: &Event<'_>, found: &mut LintFindings) {
        let absolute = event.after.arc_absolute;
        // Told at the change from one kind to the other, not at each arc.
        let [relative_seen, absolute_seen] = &mut self.centers;
        let (this, other) = if absolute {
            (absolute_seen, relative_seen)
        } else {
            (relative_seen, absolute_seen)
        };
        if *other && !*this {
            let (now, before) = if absolute {
                ("absolute", "relative")
            } else {
                ("relative", "absolute")
            };
            let message = format!("this arc has an {now} centre, arcs before it had {before} ones")
                .replace("an relative", "a relative");
            found.add(
                &ARC_CENTERS_MIXED,
                event.place,
                message,
                &[],
                "keep one of G90.1 and G91.1 throughout",
            );
        }
        *this = true;
    }
}

fn nearly_full(event: &Event<'_>, shape: &Shape, found: &mut LintFindings) {
    // Ends closer than the rounding of both coordinates may be meant to be one point. An arc that
    // leads forwards from one to the other is as short as it looks.
    let limit = 1.5 * last_place(decimals(event));
    if shape.sweep <= PI
        || shape.chord == 0.0
        || shape.chord > limit
        || shape.chord > 0.1 * shape.radius
    {
        return;
    }
    let (unit, sweep) = (event.after.units.name(), deg(shape.sweep));
    let message = format!(
        "start and end are {:.6} {unit} apart, and the arc goes {sweep:.4} degrees round",
        shape.chord
    );
    let values = [
        ("distance", shape.chord),
        ("sweep_deg", sweep),
        ("radius", shape.radius),
    ];
    let hint = "a control that rounds differently makes a full circle of nothing, or nothing of a full circle";
    found.add(&ARC_NEARLY_FULL, event.place, message, &values, hint);
}

fn nearly_half(event: &Event<'_>, shape: &Shape, found: &mut LintFindings) {
    let off = deg((shape.sweep - PI).abs());
    // Near a half circle the centre's height above the chord is sqrt(2 R dR) for an error dR.
    let uncertain = (shape.radius * last_place(decimals(event))).sqrt();
    // An R of exactly half the distance is a half circle on purpose.
    let exact = (shape.radius - 0.5 * shape.chord).abs() <= 1e-9 * shape.radius;
    if exact || off > NEARLY_HALF_DEG || uncertain * event.after.units.mm() < CENTER_SHIFT_MM {
        return;
    }
    let unit = event.after.units.name();
    let message = format!(
        "an arc by radius of {:.4} degrees: rounding of R and of the ends moves its centre by up to {uncertain:.4} {unit}",
        deg(shape.sweep)
    );
    let values = [
        ("sweep_deg", deg(shape.sweep)),
        ("radius", shape.radius),
        ("center_uncertainty", uncertain),
    ];
    found.add(
        &ARC_NEARLY_HALF,
        event.place,
        message,
        &values,
        "give the centre with I, J, K",
    );
}

impl Check for Arcs {
    fn block(&mut self, event: &Event<'_>, legs: &[Leg<'_>], found: &mut LintFindings) {
        let has = |letters: &[u8]| {
            event
                .block()
                .words
                .iter()
                .any(|word| letters.contains(&word.letter))
        };
        let by_center = has(b"IJK");
        for leg in legs {
            let CanonicalOp::ArcFeed(arc) = leg.op else {
                continue;
            };
            let shape = shape(&leg.start, arc);
            // R leaves the centre to the control, which computes it from rounded figures; I J K
            // state it.
            if has(b"R") {
                nearly_half(event, &shape, found);
            } else if by_center {
                self.centers(event, found);
                if arc.turns.abs() == 1 {
                    nearly_full(event, &shape, found);
                }
            }
        }
    }
}
