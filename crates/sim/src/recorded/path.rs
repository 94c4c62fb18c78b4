//! The programmed path in one piece: places along it, and the nearest point between two of them.

use crate::error::SimError;
use crate::motion::ProgrammedMove;
use lostmotion_base::vec::{norm, sub};
use lostmotion_base::{BlockRef, Coords};
use lostmotion_kinematics::JointMap;
use lostmotion_path::Curve;
use lostmotion_plan::PathControl;

/// Distances less apart than this are the same: the earlier place counts, mm.
const SAME_MM: f64 = 1e-9;
/// Accuracy of distances that have no closed form, mm.
const ACCURACY_MM: f64 = 1e-7;

/// A move on which the tool's tip goes somewhere.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    curve: Curve,
    /// From the curve to what is recorded, mm: the tool's offset.
    shift_mm: [f64; 3],
    start_mm: f64,
    length_mm: f64,
    pub(super) block: BlockRef,
    pub(super) rapid: bool,
    /// How far the command may be off the path, mm; `None` for G64 without P.
    pub(super) tolerance_mm: Option<f64>,
}

/// Moves of a program, one behind the other.
#[derive(Clone, Debug, Default)]
pub(super) struct ProgrammedPath {
    pub(super) pieces: Vec<Piece>,
    pub(super) length_mm: f64,
    /// Zero of the program in machine coordinates, that of its first move, mm.
    pub(super) origin_mm: [f64; 3],
    /// The same of all axes, mm and rad.
    pub(super) origin: Coords,
    /// Whether curves are those of the tool's tip, on machines whose joints are another thing.
    pub(super) is_tip: bool,
    /// Tool in force, on such machines.
    pub(super) tool_mm: [f64; 3],
}

/// The nearest point of a stretch of the path.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Foot {
    pub(super) piece: usize,
    /// Along the piece, and along the path, mm.
    pub(super) s: f64,
    pub(super) place_mm: f64,
    pub(super) distance_mm: f64,
}

/// Reads the moves of a program. On machines whose joints do not go with the tool each stretch with
/// one tool and one kind of coordinates is a path of its own: the same joints are another place of
/// the tool in the next one.
pub(super) fn read(
    moves: impl Iterator<Item = Result<ProgrammedMove, SimError>>,
    map: JointMap,
    exact_mm: f64,
    most: usize,
) -> Result<Vec<ProgrammedPath>, SimError> {
    let mut paths: Vec<ProgrammedPath> = Vec::new();
    let mut count = 0;
    for item in moves {
        let item = item?;
        let motion = &item.motion;
        if !motion.curve.moves_tip() {
            continue;
        }
        if count == most {
            return Err(SimError::refused(
                format!("the program has more than {most} moves"),
                "allow more of them: they are held in memory, half a kilobyte each",
            ));
        }
        count += 1;
        let is_tip = map != JointMap::Shifted && item.is_tip;
        let goes_on = paths.last().is_some_and(|path| {
            path.is_tip == is_tip && (!is_tip || path.tool_mm == motion.tool_mm)
        });
        if !goes_on {
            paths.push(ProgrammedPath {
                origin_mm: item.origin_mm,
                origin: item.origin,
                is_tip,
                tool_mm: motion.tool_mm,
                ..ProgrammedPath::default()
            });
        }
        if let Some(path) = paths.last_mut() {
            path.add(&item, exact_mm);
        }
    }
    Ok(paths)
}

impl ProgrammedPath {
    /// Takes the next move.
    fn add(&mut self, item: &ProgrammedMove, exact_mm: f64) {
        let rapid = item.is_rapid();
        let motion = &item.motion;
        let length_mm = motion.curve.length();
        self.pieces.push(Piece {
            curve: motion.curve,
            shift_mm: if self.is_tip {
                [0.0; 3]
            } else {
                motion.tool_mm
            },
            start_mm: self.length_mm,
            length_mm,
            block: motion.block,
            rapid,
            tolerance_mm: match motion.control {
                PathControl::ExactStop | PathControl::ExactPath => Some(exact_mm),
                PathControl::Continuous { tolerance_mm, .. } => tolerance_mm,
            },
        });
        self.length_mm += length_mm;
    }

    /// The block of a piece.
    pub(super) fn block(&self, piece: usize) -> BlockRef {
        self.pieces
            .get(piece)
            .map(|piece| piece.block)
            .unwrap_or_default()
    }

    /// The piece that a place lies on.
    pub(super) fn at(&self, place_mm: f64) -> usize {
        let after = self
            .pieces
            .partition_point(|piece| piece.start_mm <= place_mm);
        after.saturating_sub(1)
    }

    /// The point of a place.
    pub(super) fn point(&self, place_mm: f64) -> [f64; 3] {
        let at = self.pieces.get(self.at(place_mm));
        at.map_or([0.0; 3], |piece| piece.point(place_mm - piece.start_mm))
    }

    /// The nearest point to `point` from one place to another; of equally near ones the first.
    pub(super) fn nearest(&self, point: [f64; 3], from_mm: f64, to_mm: f64) -> Foot {
        let first = self.at(from_mm.max(0.0));
        let mut best = Foot {
            piece: first,
            s: 0.0,
            place_mm: from_mm,
            distance_mm: f64::INFINITY,
        };
        for (index, piece) in self.pieces.iter().enumerate().skip(first) {
            if piece.start_mm > to_mm && index > first {
                break;
            }
            if piece.is_beyond(point, best.distance_mm) {
                continue;
            }
            let foot = piece.nearest(point, from_mm - piece.start_mm, to_mm - piece.start_mm);
            if foot.1 < best.distance_mm - SAME_MM {
                best = Foot {
                    piece: index,
                    s: foot.0,
                    place_mm: piece.start_mm + foot.0,
                    distance_mm: foot.1,
                };
            }
        }
        best
    }

    /// Places where the path passes within a distance of a point: the nearest of each passage.
    pub(super) fn passages(&self, point: [f64; 3], within_mm: f64) -> Vec<f64> {
        let mut found: Vec<Foot> = Vec::new();
        let mut is_inside = false;
        for (index, piece) in self.pieces.iter().enumerate() {
            let foot = (!piece.is_beyond(point, within_mm))
                .then(|| piece.nearest(point, 0.0, piece.length_mm))
                .filter(|foot| foot.1 <= within_mm);
            let Some((s, distance_mm)) = foot else {
                is_inside = false;
                continue;
            };
            let foot = Foot {
                piece: index,
                s,
                place_mm: piece.start_mm + s,
                distance_mm,
            };
            match found.last_mut().filter(|_| is_inside) {
                // Moves next to each other are one passage, unless it has turned back meanwhile.
                Some(last) if foot.place_mm - last.place_mm <= 2.0 * within_mm => {
                    if foot.distance_mm < last.distance_mm - SAME_MM {
                        *last = foot;
                    }
                }
                _ => found.push(foot),
            }
            is_inside = true;
        }
        found.into_iter().map(|foot| foot.place_mm).collect()
    }

    /// From the foot to the point, and the direction of the path there.
    pub(super) fn off(&self, foot: &Foot, point: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        self.pieces
            .get(foot.piece)
            .map_or_else(Default::default, |piece| {
                (sub(point, piece.point(foot.s)), piece.curve.tangent(foot.s))
            })
    }

    /// How far the command may be off the path near a foot: on a corner the wider tolerance of the
    /// moves that meet there.
    pub(super) fn tolerance_mm(&self, foot: &Foot) -> Option<f64> {
        let mut found = self.pieces.get(foot.piece)?.tolerance_mm?;
        let reach = 2.0 * foot.distance_mm + found;
        let near = [
            (foot.piece > 0 && foot.s <= reach).then(|| foot.piece - 1),
            self.pieces
                .get(foot.piece)
                .filter(|piece| piece.length_mm - foot.s <= reach)
                .map(|_| foot.piece + 1),
        ];
        for piece in near.into_iter().flatten() {
            if let Some(piece) = self.pieces.get(piece) {
                found = found.max(piece.tolerance_mm?);
            }
        }
        Some(found)
    }
}

impl Piece {
    fn point(&self, s: f64) -> [f64; 3] {
        let [x, y, z] = self.curve.point(s).linear();
        let [a, b, c] = self.shift_mm;
        [x + a, y + b, z + c]
    }

    /// Whether the whole piece is farther away than this.
    fn is_beyond(&self, point: [f64; 3], distance_mm: f64) -> bool {
        // At unit speed no point of a curve is farther from its start than its length.
        let unit_speed = !matches!(self.curve, Curve::Quintic(_));
        unit_speed && norm(sub(self.point(0.0), point)) - self.length_mm > distance_mm
    }

    fn nearest(&self, point: [f64; 3], from: f64, to: f64) -> (f64, f64) {
        let foot = self
            .curve
            .nearest(sub(point, self.shift_mm), (from, to), ACCURACY_MM);
        (foot.s, foot.distance)
    }
}
