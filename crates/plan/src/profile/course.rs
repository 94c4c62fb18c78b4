//! Derivatives of the joints along the pieces of a section, and what the limits of velocity,
//! acceleration and jerk make of them: bounds of the speed over each interval of a part.

use super::Section;
use super::barrier::{BarrierProblem, Row};
use super::spline::Grid;
use crate::demand::JointDerivs;
use lostmotion_base::AXES;
use lostmotion_kinematics::JointMap;

/// Part of a limit up to which it counts as kept: 1 and rounding.
pub(super) const KEPT_SHARE: f64 = 1.0 + 1e-6;

/// Derivatives of the joints by the path at a place, and the largest speed of the path parameter
/// that the feed and the chords allow, 1/s.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointPlace {
    pub(crate) d: [[f64; AXES]; 3],
    pub(crate) feed: f64,
}

impl JointPlace {
    /// The derivatives of one joint.
    pub(super) fn joint(&self, joint: usize) -> JointDerivs {
        let [d1, d2, d3] = [0, 1, 2].map(|order| self.d[order][joint]);
        JointDerivs { d1, d2, d3 }
    }
}

/// Derivatives over a short stretch.
#[derive(Clone, Copy, Debug)]
pub(crate) struct JointSpan {
    /// At either end.
    pub(crate) ends: [JointPlace; 2],
    /// What bounds the third downward and upward near either end: where pieces meet in between it
    /// steps, and its extremes count at both ends.
    pub(crate) third: [[[f64; AXES]; 2]; 2],
    pub(crate) feed: f64,
}

/// Bounds of the joints' second to fifth derivatives by the path.
pub(super) type Bends = [[f64; AXES]; 4];

/// Goes along a section; fast where the places asked for rise.
#[derive(Debug)]
pub(crate) struct JointCourse<'a> {
    section: &'a Section<'a>,
    index: usize,
}

impl<'a> JointCourse<'a> {
    pub(crate) fn new(section: &'a Section<'a>) -> JointCourse<'a> {
        JointCourse { section, index: 0 }
    }

    /// Finds the piece under a place; whether it is another one than before.
    pub(super) fn find(&mut self, s: f64) -> bool {
        let (pieces, before) = (self.section.pieces, self.index);
        while self.index > 0 && pieces.get(self.index).is_some_and(|(start, _)| *start > s) {
            self.index -= 1;
        }
        while pieces
            .get(self.index + 1)
            .is_some_and(|(start, _)| *start <= s)
        {
            self.index += 1;
        }
        self.index != before
    }

    /// Where the piece after the one in hand begins.
    pub(super) fn next(&self) -> Option<f64> {
        self.section
            .pieces
            .get(self.index + 1)
            .map(|(start, _)| *start)
    }

    /// Goes on to the next piece.
    pub(super) fn step(&mut self) {
        self.index += 1;
    }

    /// At a place on the piece in hand.
    pub(super) fn on_piece(&self, s: f64) -> Option<JointPlace> {
        let (start, piece) = self.section.pieces.get(self.index)?;
        let at = piece.curve.eval(s - start);
        let feed = piece.feed / piece.fed_speed(&at.d1, 1.0).max(f64::MIN_POSITIVE);
        let chord = self.section.machine.chord.as_ref();
        if self.section.kinematics.joint_map() == JointMap::Shifted && chord.is_none() {
            return Some(JointPlace {
                d: [at.d1.0, at.d2.0, at.d3.0],
                feed,
            });
        }
        let jets = self
            .section
            .kinematics
            .inverse_jet(&at.jets(), &piece.tool_mm)
            .ok()?;
        let feed = chord.map_or(feed, |chord| {
            feed.min(chord.speed_here(&jets, &piece.tool_mm))
        });
        Some(JointPlace {
            d: [1, 2, 3].map(|order| jets.map(|jet| jet.0[order])),
            feed,
        })
    }

    /// Bounds of the second to fifth derivatives of affine joints between two places on the piece
    /// in hand, given those at the ends.
    pub(super) fn bends(&self, from: f64, to: f64, ends: [&JointPlace; 2]) -> Bends {
        let Some((start, piece)) = self.section.pieces.get(self.index) else {
            return Bends::default();
        };
        let (fourth, fifth) = piece.curve.higher_derivatives(from - start, to - start);
        let half = 0.5 * (to - from);
        let [left, right] = ends.map(|place| &place.d);
        let most = |order: usize, joint: usize| {
            f64::abs(left[order][joint]).max(right[order][joint].abs())
        };
        // Between the ends a derivative passes the larger of them by at most half the stretch times
        // the next derivative.
        let third: [f64; AXES] =
            std::array::from_fn(|joint| most(2, joint) + half * fourth.0[joint]);
        let second = std::array::from_fn(|joint| most(1, joint) + half * third[joint]);
        [second, third, fourth.0, fifth.0]
    }

    /// Over a stretch: third derivatives at its ends, on both sides of where pieces meet in it, and
    /// halfway in between.
    pub(crate) fn over(&mut self, from: f64, to: f64) -> Option<JointSpan> {
        self.find(from);
        let first = self.on_piece(from)?;
        let mut feed = first.feed;
        let (mut low, mut high) = (first.d[2], first.d[2]);
        let mut take = |place: &JointPlace| {
            for (joint, d3) in place.d[2].into_iter().enumerate() {
                low[joint] = low[joint].min(d3);
                high[joint] = high[joint].max(d3);
            }
            feed = feed.min(place.feed);
        };
        let (mut here, before) = (from, self.index);
        // Third derivatives step where pieces meet, so that both sides of each meeting count.
        while let Some((next, _)) = self
            .section
            .pieces
            .get(self.index + 1)
            .filter(|(next, _)| *next < to)
        {
            take(&self.on_piece(0.5 * (here + next))?);
            take(&self.on_piece(*next)?);
            self.index += 1;
            take(&self.on_piece(*next)?);
            here = *next;
        }
        let middle = self.on_piece(0.5 * (here + to))?;
        take(&middle);
        let last = self.on_piece(to)?;
        take(&last);
        let third = if self.index == before {
            // On one piece it goes from one end to the other; what bulges between them counts at
            // both.
            [&first, &last].map(|end| {
                [-1.0, 1.0].map(|side| {
                    std::array::from_fn(|joint| {
                        let mean = 0.5 * (first.d[2][joint] + last.d[2][joint]);
                        let bulge = (side * (middle.d[2][joint] - mean)).max(0.0);
                        end.d[2][joint] + side * bulge
                    })
                })
            })
        } else {
            [[low, high]; 2]
        };
        Some(JointSpan {
            ends: [first, last],
            third,
            feed,
        })
    }
}

/// Parts of the limits of acceleration and jerk that are planned for; the rest is for what happens
/// between the places where they are imposed. A choice: higher needs repairs, lower is slower.
const GOALS: [f64; 2] = [0.9985, 0.99];
/// Part of the speed limit that is planned for. A choice: higher needs repairs, lower is slower.
const SPEED_PART: f64 = 0.9999;
/// Intervals at either end that may use all of the speed limit, since the state given there may. A
/// choice: the given coefficients reach over two intervals, and one more leaves the limit.
const END_INTERVALS: usize = 3;

/// Limits at the ends of each interval.
pub(super) fn problem<'a>(section: &Section<'_>, grid: &'a Grid) -> Option<BarrierProblem<'a>> {
    let moves = |joint: usize| {
        section
            .intervals
            .iter()
            .any(|interval| interval.demand.joints[joint].first > 0.0)
    };
    let moving: Vec<(usize, [f64; 3])> = section
        .machine
        .joints()
        .filter(|(joint, _)| moves(*joint))
        .collect();
    let mut course = JointCourse::new(section);
    let (mut caps, mut rows) = (
        Vec::with_capacity(grid.len()),
        Vec::with_capacity(6 * moving.len() * grid.len()),
    );
    for interval in 0..grid.len() {
        let span = course.over(grid.nodes[interval], grid.nodes[interval + 1])?;
        let mut cap = span.feed;
        for (joint, [v, a, j]) in &moving {
            let [left, right] =
                [0, 1].map(|end| [0, 1, 2].map(|order| span.ends[end].d[order][*joint]));
            cap = cap.min(v / left[0].abs().max(right[0].abs()).max(f64::MIN_POSITIVE));
            let half = 0.5 * grid.width(interval);
            // b and b' at an end from those in the middle.
            // q'' b + q' b'/2 at the right end, expanded about the middle.
            let acceleration = [
                right[1],
                right[1] * half + 0.5 * right[0],
                0.5 * half * (right[1] * half + right[0]),
            ];
            for side in [1.0, -1.0] {
                // The state at the very end is given.
                let share = if interval + 1 < grid.len() {
                    side / a
                } else {
                    0.0
                };
                rows.push(Row {
                    f: acceleration.map(|f| f * share),
                    end: 0.0,
                });
                for (end, at, third) in
                    [(-1.0, &left, &span.third[0]), (1.0, &right, &span.third[1])]
                {
                    let third = third[usize::from(side > 0.0)][*joint];
                    let x = end * half;
                    // q''' b + 3/2 q'' b' + q' b''/2; the factor sqrt(b) is taken by the solver.
                    let jerk = [
                        third,
                        third * x + 1.5 * at[1],
                        0.5 * third * x * x + 1.5 * at[1] * x + 0.5 * at[0],
                    ];
                    rows.push(Row {
                        f: jerk.map(|f| f * side / j),
                        end,
                    });
                }
            }
        }
        let near = interval.min(grid.len() - 1 - interval) < END_INTERVALS;
        caps.push(
            cap * cap
                * if near {
                    KEPT_SHARE
                } else {
                    SPEED_PART * SPEED_PART
                },
        );
    }
    // At a node both sides' caps hold; the speed at the very end is given.
    for interval in 1..grid.len() {
        caps[interval - 1] = caps[interval - 1].min(caps[interval]);
    }
    if let Some(last) = caps.last_mut() {
        *last = f64::INFINITY;
    }
    Some(BarrierProblem::new(
        grid,
        caps,
        &rows,
        vec![GOALS; grid.len()],
    ))
}
