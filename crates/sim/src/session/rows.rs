//! From the contour stage's records to the rows of results: micrometres, seconds, names.

use super::frame::Frame;
use crate::motion::Modes;
use crate::observer::ContourPoint;
use crate::results::{BlockResult, ErrorParts, ErrorStats, ReversalResult};
use lostmotion_base::Clock;
use lostmotion_base::units::UM_PER_MM;
use lostmotion_base::vec::sub;
use lostmotion_contour::{BlockRow, ErrorRecord, FootPlace, ReversalRow, Shares, Statistics};

/// Statistics times a factor (1000 for mm to um).
pub(crate) fn stats(statistics: &Statistics, factor: f64) -> ErrorStats {
    let summary = statistics.summary();
    ErrorStats {
        samples: summary.samples,
        // Signed in the summary, a magnitude in results.
        max: summary.max.abs() * factor,
        rms: summary.rms * factor,
        p50: summary.p50 * factor,
        p95: summary.p95 * factor,
        p99: summary.p99 * factor,
        p999: summary.p999 * factor,
    }
}

fn parts(shares: &Shares) -> ErrorParts {
    ErrorParts {
        command: shares.command_mm * UM_PER_MM,
        servo: shares.servo_mm * UM_PER_MM,
        backlash: shares.backlash_mm * UM_PER_MM,
    }
}

pub(crate) fn block(row: &BlockRow, servo: Clock) -> BlockResult {
    BlockResult {
        block: row.block,
        text: String::new(),
        segment: row.segment,
        rapid: row.rapid,
        time_s: servo.seconds(row.worst.sample.tick),
        max_um: row.max_mm() * UM_PER_MM,
        rms_um: row.rms_mm() * UM_PER_MM,
        parts_um: parts(&row.worst.shares),
        cause: row.worst.cause,
        at_mm: row.worst.commanded_tip_mm,
    }
}

pub(crate) fn reversal(row: &ReversalRow, servo: Clock) -> ReversalResult {
    ReversalResult {
        axis: row.reversal.axis,
        time_s: servo.seconds(row.reversal.tick),
        block: row.block,
        direction: row.reversal.direction,
        peak_um: row.peak_mm * UM_PER_MM,
        backlash_um: row.peak_shares.backlash_mm * UM_PER_MM,
        rapid: row.rapid,
    }
}

/// A row of the trace.
pub(crate) fn contour_point(
    record: &ErrorRecord,
    place: FootPlace,
    (frame, modes): (&Frame, &Modes),
    servo: Clock,
) -> ContourPoint {
    // All places of a row are from one zero, that of its block.
    let origin_mm = sub(frame.pose.tip, record.commanded_tip_mm);
    ContourPoint {
        time_s: servo.seconds(record.sample.tick),
        foot_mm: place.foot_mm,
        normal: place.left,
        error_um: record.sample.error_mm * UM_PER_MM,
        // Its length, on the side to which it moves the error.
        backlash_um: record
            .shares
            .backlash_size_mm
            .copysign(record.shares.backlash_mm)
            * UM_PER_MM,
        commanded_mm: record.commanded_tip_mm,
        actual_mm: sub(record.sample.tip_mm, origin_mm),
        tool: modes.tool_axis(
            frame.sample.segment,
            &frame.sample.position,
            frame.pose.axis,
        ),
        moving: frame.moving,
        rapid: record.sample.rapid,
        limiter: frame.limiter,
        block: record.sample.block,
    }
}
