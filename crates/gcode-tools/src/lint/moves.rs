//! The moves of a block with their ends, in program coordinates.

use lostmotion_gcode::codes::{CodeRow, Group};
use lostmotion_gcode::ops::{CanonicalOp, Plane, Position};
use lostmotion_gcode::program::Event;
use lostmotion_gcode::state::State;

/// Where a move begins and ends.
pub(super) struct Leg<'a> {
    pub(super) op: &'a CanonicalOp,
    pub(super) start: Position,
    pub(super) end: Position,
}

/// The moves of a block in order. Empty under cutter compensation, where they belong to the block
/// before.
pub(super) fn legs<'a>(event: &'a Event<'_>) -> Vec<Leg<'a>> {
    if event.compensated || event.compensates {
        return Vec::new();
    }
    let mut at = event.before.current;
    let mut legs = Vec::new();
    for sourced in event.ops {
        // Operations without an end do not move the tool.
        let end = match &sourced.op {
            CanonicalOp::StraightTraverse(end) | CanonicalOp::StraightFeed(end) => *end,
            CanonicalOp::ArcFeed(arc) => arc.position(),
            CanonicalOp::NurbsFeed(curve) => curve.end,
            CanonicalOp::StraightProbe(probe) => probe.stop,
            _ => continue,
        };
        legs.push(Leg {
            op: &sourced.op,
            start: at,
            end,
        });
        at = end;
    }
    legs
}

/// Whether a block has a G code.
pub(super) fn has_g(event: &Event<'_>, tenths: u16) -> bool {
    event.interpreter.codes().any(|(row, _)| is_g(row, tenths))
}

pub(super) fn is_g(row: &CodeRow, tenths: u16) -> bool {
    row.code.letter == 'G' && row.code.tenths == tenths
}

/// Whether a block moves in machine coordinates: G53, G28, G30.
pub(super) fn in_machine(event: &Event<'_>) -> bool {
    [280, 300, 530]
        .into_iter()
        .any(|tenths| has_g(event, tenths))
}

/// Whether a block runs a canned cycle.
pub(super) fn in_cycle(event: &Event<'_>) -> bool {
    event
        .after
        .motion
        .is_some_and(|code| (730..=899).contains(&code.tenths) && code.tenths != 800)
}

/// Whether a state looks like that of a lathe, where Z below zero says nothing about material.
pub(super) fn is_lathe(state: &State) -> bool {
    state.plane == Plane::Zx || state.diameter
}

/// Whether a block sets a mode.
pub(super) fn sets(event: &Event<'_>, group: Group) -> bool {
    event.interpreter.codes().any(|(row, _)| row.group == group)
}

/// Whether an operation moves at the feed rate.
pub(super) fn is_feed(op: &CanonicalOp) -> bool {
    matches!(
        op,
        CanonicalOp::StraightFeed(_) | CanonicalOp::ArcFeed(_) | CanonicalOp::NurbsFeed(_)
    )
}
