//! What a run has found, as findings: blocks outside the tolerance, and where the machine stops.

use super::{Finding, Origin};
use crate::number::{error, plain, round_to};
use crate::text::{stop_place, stop_reason};
use lostmotion_base::BlockRef;
use lostmotion_gcode::Severity;
use lostmotion_sim::results::{BlockResult, MethodResult};
use serde_json::{Map, Value};
use std::cmp::Reverse;
use std::collections::BTreeMap;

/// Most blocks kept of a method, a choice: code hosts show at most 5,000 results of a log.
pub const MOST_BLOCKS: usize = 1000;

/// Decimals of values: 0.1 nm, 0.1 ms.
const DECIMALS: usize = 4;

/// Code of a block outside the tolerance.
pub(super) const OUTSIDE: &str = "contour-error";
/// Code of a machine that stops.
pub(super) const STOPS: &str = "machine-stops";

/// Codes that only a run finds, with what they mean and what to do about them.
pub(super) const CODES: [(&str, &str, &str); 2] = [
    (
        OUTSIDE,
        "The tool leaves the programmed contour by more than the tolerance.",
        "See which part of the error is the command's, the servo's or backlash's; compare methods of compensation with `simulate --methods all`, or slow the block down.",
    ),
    (
        STOPS,
        "The control stops the machine.",
        "See which limit was passed, and by which axis; `machine check` tells whether its loops are stable.",
    ),
];

/// Keeps the blocks of a run whose contour error is outside the tolerance, each block of the
/// program once with its worst pass, at most [`MOST_BLOCKS`] of each method.
///
/// ```
/// use lostmotion_report::findings::BlockRecorder;
/// use lostmotion_sim::results::BlockResult;
///
/// let mut recorder = BlockRecorder::new(1, 10.0);
/// let mut block = BlockResult::default();
/// for max_um in [4.0, -12.0, 11.0] {
///     block.max_um = max_um;
///     recorder.push(0, std::slice::from_ref(&block));
/// }
/// // One block of the program in three passes, of which the second is the worst.
/// assert_eq!(recorder.blocks(0).len(), 1);
/// assert_eq!(recorder.blocks(0)[0].max_um, -12.0);
/// ```
#[derive(Clone, Debug)]
pub struct BlockRecorder {
    tolerance_um: f64,
    methods: Vec<MethodBlocks>,
}

/// The blocks of one method.
#[derive(Clone, Debug, Default)]
struct MethodBlocks {
    /// By file, first byte and calls, which name a block of the program.
    blocks: BTreeMap<(u32, u64, u32), BlockResult>,
    /// Whether some had to go.
    dropped: bool,
}

impl BlockRecorder {
    /// For a run with this many methods and this tolerance, um.
    pub fn new(methods: usize, tolerance_um: f64) -> BlockRecorder {
        BlockRecorder {
            tolerance_um,
            methods: vec![MethodBlocks::default(); methods],
        }
    }

    /// Takes finished blocks of a method, as [`Observer::blocks`](lostmotion_sim::Observer::blocks)
    /// brings them.
    pub fn push(&mut self, method: usize, rows: &[BlockResult]) {
        let Some(kept) = self.methods.get_mut(method) else {
            return;
        };
        for row in rows {
            // Rapids have no tolerance.
            if row.rapid || row.max_um.abs() <= self.tolerance_um {
                continue;
            }
            let span = row.block.span;
            let key = (span.file, span.start, row.block.call_stack);
            let worst = kept.blocks.get(&key);
            if worst.is_none_or(|worst| worst.max_um.abs() < row.max_um.abs()) {
                kept.blocks.insert(key, row.clone());
            }
            // Room for as many again, so that sorting is rare.
            if kept.blocks.len() > 2 * MOST_BLOCKS {
                let sorted = worst_first(kept.blocks.values());
                let least = sorted.get(MOST_BLOCKS - 1).map(|block| rank(block));
                let stays = |block: &BlockResult| least.is_none_or(|least| rank(block) <= least);
                let blocks = kept.blocks.iter().filter(|(_, block)| stays(block));
                kept.blocks = blocks.map(|(key, block)| (*key, block.clone())).collect();
                kept.dropped = true;
            }
        }
    }

    /// The blocks of a method that are outside the tolerance, in the order of the program, at most
    /// [`MOST_BLOCKS`] of them: the worst.
    pub fn blocks(&self, method: usize) -> Vec<BlockResult> {
        let Some(kept) = self.methods.get(method) else {
            return Vec::new();
        };
        let mut blocks: Vec<BlockResult> = worst_first(kept.blocks.values())
            .into_iter()
            .take(MOST_BLOCKS)
            .cloned()
            .collect();
        blocks.sort_by_key(|block| block.block);
        blocks
    }

    /// Whether a method has more blocks outside the tolerance than [`BlockRecorder::blocks`] tells.
    pub fn has_more(&self, method: usize) -> bool {
        let kept = self.methods.get(method);
        kept.is_some_and(|kept| kept.dropped || kept.blocks.len() > MOST_BLOCKS)
    }

    /// What a method leaves outside the tolerance, and where the machine stops with it: findings
    /// with the codes `contour-error` and `machine-stops`.
    pub fn findings(
        &self,
        method: usize,
        result: &MethodResult,
        origin: &Origin<'_>,
    ) -> Vec<Finding> {
        let stop = result.stop.iter().map(|stop| {
            let message = format!(
                "the machine stops {}: {}",
                stop_place(stop),
                stop_reason(stop)
            );
            let values = [
                ("time_s", stop.time_s),
                ("value", stop.value),
                ("allowed", stop.allowed),
            ];
            finding(STOPS, message, &stop.block, &values, result, origin)
        });
        let blocks = self.blocks(method);
        let outside = blocks.iter().map(|block| {
            let message = format!(
                "the tool is {} um off the contour, tolerance {} um ({}; method {})",
                error(block.max_um.abs()),
                plain(self.tolerance_um),
                block.cause,
                result.method
            );
            let values = [
                ("max_um", block.max_um),
                ("rms_um", block.rms_um),
                ("command_um", block.parts_um.command),
                ("servo_um", block.parts_um.servo),
                ("backlash_um", block.parts_um.backlash),
                ("time_s", block.time_s),
                ("tolerance_um", self.tolerance_um),
            ];
            finding(OUTSIDE, message, &block.block, &values, result, origin)
        });
        let mut findings: Vec<Finding> = stop.chain(outside).collect();
        if self.has_more(method)
            && let Some(last) = findings.last_mut()
        {
            last.hint = Some(format!(
                "more blocks are outside the tolerance; the {MOST_BLOCKS} worst are listed, blocks.csv of --out has all"
            ));
        }
        findings
    }
}

/// Smaller for a worse block; of equals for the one that comes first in the program. Magnitudes
/// order like the bits of their positive numbers.
fn rank(block: &BlockResult) -> (Reverse<u64>, BlockRef) {
    (Reverse(block.max_um.abs().to_bits()), block.block)
}

fn worst_first<'a>(blocks: impl Iterator<Item = &'a BlockResult>) -> Vec<&'a BlockResult> {
    let mut sorted: Vec<&BlockResult> = blocks.collect();
    sorted.sort_by_key(|block| rank(block));
    sorted
}

fn finding(
    code: &str,
    message: String,
    block: &BlockRef,
    values: &[(&str, f64)],
    result: &MethodResult,
    origin: &Origin<'_>,
) -> Finding {
    let numbers = values
        .iter()
        .map(|(name, value)| ((*name).to_owned(), round_to(*value, DECIMALS).into()));
    let method = ("method".to_owned(), Value::from(result.method.clone()));
    Finding {
        code: code.to_owned(),
        severity: Severity::Error,
        message,
        file: origin.file(block.span.file),
        span: block.span,
        values: numbers.chain([method]).collect::<Map<String, Value>>(),
        excerpt: String::new(),
        hint: None,
        calls: origin.calls(block.call_stack),
    }
}
