//! The blocks that a record goes through, and the stretches of the path that it does not show.

use super::path::{Foot, ProgrammedPath};
use super::results::{LimitUse, RecordCheck, RecordKind, RecordedBlock};
use super::{Recorded, short};
use crate::setup::Setup;

/// Distance that is none, mm: roundings of programs.
const SLACK_MM: f64 = 1e-4;
/// Periods between two rows from which rows are missing, where the axes moved by so much meanwhile, mm.
/// Choices: clocks jitter by a period, and a log of changes has no rows while nothing moves.
const MISSING_PERIODS: f64 = 3.0;
const MISSING_MM: f64 = 0.1;

/// The blocks that the record goes through.
pub(super) struct Blocks<'a> {
    pub(super) path: &'a ProgrammedPath,
    kind: RecordKind,
    tolerance_mm: f64,
    pub(super) error_mm: f64,
    rows: u64,
    square: f64,
    /// Each with the first and last of its pieces.
    found: Vec<(usize, usize, RecordedBlock)>,
}

impl<'a> Blocks<'a> {
    pub(super) fn new(
        setup: &Setup<'_>,
        recorded: &Recorded,
        path: &'a ProgrammedPath,
        error_mm: f64,
    ) -> Blocks<'a> {
        let told = setup.options.tolerance_um;
        let tolerance_um = told.unwrap_or(setup.machine.simulate().tolerance_um);
        Blocks {
            path,
            kind: recorded.kind,
            tolerance_mm: 1e-3 * tolerance_um,
            error_mm,
            rows: 0,
            square: 0.0,
            found: Vec::new(),
        }
    }

    /// How far the record may be off at a foot, mm.
    fn allowed_mm(&self, foot: &Foot, rapid: bool) -> Option<f64> {
        let blending = self.path.tolerance_mm(foot)?;
        match self.kind {
            RecordKind::Commanded => Some(blending),
            RecordKind::Measured => (!rapid).then_some(blending + self.tolerance_mm),
        }
    }

    /// Takes the foot of the next row.
    pub(super) fn add(&mut self, time_s: f64, foot: &Foot) {
        self.rows += 1;
        self.square += foot.distance_mm * foot.distance_mm;
        let Some(piece) = self.path.pieces.get(foot.piece) else {
            return;
        };
        let allowed = self.allowed_mm(foot, piece.rapid);
        let at = self.position(foot.piece);
        let off_um = 1e3 * foot.distance_mm;
        let is_outside = allowed.is_some_and(|mm| foot.distance_mm > mm + self.error_mm + SLACK_MM);
        let index = match at {
            Ok(index) => index,
            Err(index) => {
                // A spline or a rounded contour is one block of many pieces.
                let goes_on = index
                    .checked_sub(1)
                    .and_then(|before| self.found.get_mut(before))
                    .filter(|(_, last, block)| {
                        block.block == piece.block && foot.piece - *last <= 1
                    });
                if let Some((_, last, _)) = goes_on {
                    *last = foot.piece;
                    index - 1
                } else {
                    let block = RecordedBlock {
                        block: piece.block,
                        rapid: piece.rapid,
                        from_s: time_s,
                        deviation_s: time_s,
                        allowed_um: allowed.map(|mm| 1e3 * mm),
                        ..RecordedBlock::default()
                    };
                    self.found.insert(index, (foot.piece, foot.piece, block));
                    index
                }
            }
        };
        let Some((_, _, block)) = self.found.get_mut(index) else {
            return;
        };
        block.to_s = time_s;
        block.is_outside |= is_outside;
        // The place that is worst against what is allowed there.
        let share = |off: f64, allowed: Option<f64>| off / allowed.unwrap_or(1e3).max(1e-3);
        let allowed_um = allowed.map(|mm| 1e3 * mm);
        if share(off_um, allowed_um) > share(block.deviation_um, block.allowed_um)
            || block.deviation_um == 0.0
        {
            (block.deviation_um, block.deviation_s, block.allowed_um) =
                (off_um, time_s, allowed_um);
        }
    }

    /// Takes the use of a limit on a piece.
    pub(super) fn limit(&mut self, piece: usize, used: LimitUse) {
        let Ok(index) = self.position(piece) else {
            return;
        };
        let Some((_, _, block)) = self.found.get_mut(index) else {
            return;
        };
        if block
            .limit
            .as_ref()
            .is_none_or(|other| used.certain() > other.certain())
        {
            block.limit = Some(used);
        }
    }

    fn position(&self, piece: usize) -> Result<usize, usize> {
        self.found.binary_search_by(|(first, last, _)| {
            if *last < piece {
                std::cmp::Ordering::Less
            } else if *first > piece {
                std::cmp::Ordering::Greater
            } else {
                std::cmp::Ordering::Equal
            }
        })
    }

    pub(super) fn finish(self, answer: &mut RecordCheck, keep: usize) {
        answer.deviation_rms_um = 1e3 * (self.square / self.rows.max(1) as f64).sqrt();
        answer.deviation_plus_minus_um = 1e3 * self.error_mm;
        let mut blocks: Vec<RecordedBlock> =
            self.found.into_iter().map(|(_, _, block)| block).collect();
        answer.block_count = blocks.len() as u64;
        answer.at_fault = blocks.iter().filter(|block| block.is_at_fault()).count() as u64;
        answer.deviation_max_um = blocks
            .iter()
            .map(|block| block.deviation_um)
            .fold(0.0, f64::max);
        blocks.sort_by(|a, b| {
            let by_fault = b.is_at_fault().cmp(&a.is_at_fault());
            by_fault.then(b.times().total_cmp(&a.times()))
        });
        blocks.truncate(keep);
        answer.blocks = blocks;
    }
}

/// Stretches of the path without rows.
#[derive(Default)]
pub(super) struct Holes {
    count: usize,
    /// The longest, s and mm.
    longest: Option<Hole>,
}

/// From the last row before it to the first behind.
struct Hole {
    from_s: f64,
    to_s: f64,
    from: Foot,
    to: Foot,
}

impl Holes {
    /// Looks for one between two rows.
    pub(super) fn between(
        &mut self,
        (from_s, from): (f64, Foot),
        (to_s, to): (f64, Foot),
        period_s: f64,
    ) {
        let is_long = to_s - from_s > MISSING_PERIODS * period_s;
        if !is_long || to.place_mm - from.place_mm < MISSING_MM {
            return;
        }
        self.count += 1;
        let longest = self
            .longest
            .as_ref()
            .map_or(0.0, |hole| hole.to_s - hole.from_s);
        if to_s - from_s > longest {
            self.longest = Some(Hole {
                from_s,
                to_s,
                from,
                to,
            });
        }
    }

    /// What is not told for the sake of them.
    pub(super) fn untold(&self, path: &ProgrammedPath) -> Option<String> {
        let Hole {
            from_s,
            to_s,
            from,
            to,
        } = self.longest.as_ref()?;
        let line = |foot: &Foot| {
            path.pieces
                .get(foot.piece)
                .map_or(0, |piece| piece.block.span.line)
        };
        let (first, last) = (line(from), line(to));
        let lines = if first == last {
            format!("of line {first}")
        } else {
            format!("from line {first} to line {last}")
        };
        let others = match self.count {
            1 => String::new(),
            count => format!(", as in {} more places", count - 1),
        };
        Some(format!(
            "what the axes did between {from_s:.3} and {to_s:.3} s, {} mm of the path {lines}: rows are missing there{others}",
            short(to.place_mm - from.place_mm),
        ))
    }
}
