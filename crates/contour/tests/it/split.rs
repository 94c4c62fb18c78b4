//! What a gap adds to the contour error is bounded by how far it moves the tool, and continuous.

use lostmotion_base::random::Random;
use lostmotion_base::vec::{add, norm, scale, sub};
use lostmotion_base::{BlockRef, Coords, Plane};
use lostmotion_contour::{
    ContourConfig, ContourInput, ContourSample, ContourTracker, FootState, ProgrammedSegment,
    Shares,
};
use lostmotion_path::Curve;

/// A path of lines through the points.
fn path(points: &[[f64; 3]]) -> ContourTracker {
    let mut tracker = ContourTracker::new(ContourConfig::default());
    for (index, pair) in points.windows(2).enumerate() {
        let [from, to] = [pair[0], pair[1]].map(|[x, y, z]| Coords::xyz(x, y, z));
        tracker
            .push(ProgrammedSegment {
                index: index as u64,
                curve: Curve::line(from, to),
                plane: Plane::Xy,
                rapid: false,
                origin_mm: [0.0; 3],
                block: BlockRef::default(),
            })
            .unwrap();
    }
    tracker
}

/// The nearest foot on the whole path of a tool that should be at the first corner.
fn measured(tracker: &ContourTracker, tip: [f64; 3], corner: [f64; 3]) -> ContourSample {
    let input = ContourInput {
        tick: 0,
        segment: 1,
        s: 0.0,
        actual_tip_mm: tip,
        commanded_tip_mm: corner,
        actual_axis: [0.0, 0.0, 1.0],
        commanded_axis: [0.0, 0.0, 1.0],
    };
    tracker.measure(&mut FootState::default(), &input).unwrap()
}

fn within(random: &mut Random, radius: f64) -> [f64; 3] {
    std::array::from_fn(|_| random.between(-radius, radius))
}

/// The tool crosses the surroundings of a corner on a straight line, another stands still: what is
/// between their errors changes by no more than the way that the tool goes, wherever the foot point
/// jumps from one leg to the other, and is never more than they are apart.
#[test]
fn around_a_corner_in_space_the_gap_does_no_more_than_it_moves_the_tool() {
    let mut random = Random::new(20_261_123);
    let mut jumps = 0;
    for case in 0..400 {
        // Two legs of 1 mm; every third corner lies in the plane, every third goes up or down.
        let mut leg = || {
            let mut to = within(&mut random, 1.0);
            if case % 3 == 0 {
                to[2] = 0.0;
            }
            scale(to, 1.0 / norm(to))
        };
        let (incoming, mut outgoing) = (leg(), leg());
        if case % 3 == 1 {
            outgoing = [0.0, 0.0, -1.0];
        }
        // Nearly straight back, a vertex has no neighbourhood in which feet are neighbours.
        if norm(add(incoming, outgoing)) < 0.2 {
            continue;
        }
        let corner = [3.0, -2.0, 1.0];
        let tracker = path(&[sub(corner, incoming), corner, add(corner, outgoing)]);
        let command = measured(&tracker, corner, corner);
        let standing = add(corner, within(&mut random, 0.02));
        let (from, to) = (
            add(corner, within(&mut random, 0.02)),
            add(corner, within(&mut random, 0.02)),
        );
        let without_gap = measured(&tracker, standing, corner);
        let steps = 2000;
        let step_mm = norm(sub(to, from)) / f64::from(steps);
        let mut last: Option<(f64, u64)> = None;
        for step in 0..=steps {
            let tip = add(
                from,
                scale(sub(to, from), f64::from(step) / f64::from(steps)),
            );
            let actual = measured(&tracker, tip, corner);
            let shares = Shares::of(&command, &without_gap, &actual);
            let size = shares.backlash_size_mm;
            assert!(size <= norm(sub(tip, standing)) + 1e-12);
            assert!(shares.backlash_mm.abs() <= size + 1e-12);
            assert!((shares.total_mm() - actual.error_mm).abs() < 1e-12);
            if let Some((before, segment)) = last {
                assert!(
                    (size - before).abs() <= step_mm * (1.0 + 1e-6) + 1e-10,
                    "case {case}, step {step}: {before} to {size} in {step_mm}"
                );
                jumps += u64::from(segment != actual.segment);
            }
            last = Some((size, actual.segment));
        }
    }
    assert!(jumps > 100, "{jumps} jumps from leg to leg");
}

/// On a line the length is the part of the tool's displacement across it, in closed form; on a
/// circle the difference of the distances from its centre.
#[test]
fn on_a_line_it_is_the_displacement_across_it() {
    let tracker = path(&[[-1.0, 0.0, 0.0], [0.0; 3], [4.0, 0.0, 0.0]]);
    let at = |tip| measured(&tracker, tip, [0.0; 3]);
    let shares = Shares::of(
        &at([0.0; 3]),
        &at([0.01, 0.003, 0.0]),
        &at([0.02, -0.001, 0.003]),
    );
    // Across: -4 um in Y, 3 um in Z.
    assert!((shares.backlash_size_mm - 0.005).abs() < 1e-12);
    // Out of the plane: Z alone, as large as before.
    let above = Shares::of(&at([0.0; 3]), &at([0.0; 3]), &at([0.02, 0.0, 0.003]));
    assert!((above.backlash_size_mm - 0.003).abs() < 1e-12);
}
