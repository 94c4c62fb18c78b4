//! Where the tool's centre goes in a program.

use lostmotion_gcode::{Diagnostics, InterpreterConfig, Motion, MotionFold, MotionItem, Program};
use std::f64::consts::TAU;

pub(crate) type Point = [f64; 2];

/// The moves of a program, and what was found.
pub(crate) fn run(text: &str) -> (Vec<Motion>, Diagnostics) {
    let mut fold = MotionFold::new(InterpreterConfig::default().start);
    let mut program = Program::new(text.as_bytes(), InterpreterConfig::default());
    let mut moves = Vec::new();
    for op in program.by_ref() {
        if let Some(MotionItem::Move(motion)) = fold.push(&op).unwrap() {
            moves.push(motion);
        }
    }
    (moves, program.diagnostics().clone())
}

/// Points along a move in the XY plane, one more than so many steps.
pub(crate) fn sampled(motion: &Motion, steps: u32) -> impl Iterator<Item = Point> + '_ {
    let (start, end) = (motion.start.0, motion.end.0);
    (0..=steps).map(move |step| {
        let share = f64::from(step) / f64::from(steps);
        let Some(circle) = motion.circle else {
            return [
                start[0] + share * (end[0] - start[0]),
                start[1] + share * (end[1] - start[1]),
            ];
        };
        let [cx, cy] = circle.center_mm;
        let from = (start[1] - cy).atan2(start[0] - cx);
        let sweep = ((end[1] - cy).atan2(end[0] - cx) - from).rem_euclid(TAU);
        let angle = from + share * if circle.turns > 0 { sweep } else { sweep - TAU };
        let radius = (start[0] - cx).hypot(start[1] - cy);
        [cx + radius * angle.cos(), cy + radius * angle.sin()]
    })
}
