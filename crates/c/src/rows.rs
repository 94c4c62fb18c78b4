//! Rows and figures as C reads them, and the functions that take them.

use crate::border::Texts;
use lostmotion::base::{AxisId, AxisSet, Clock, Coords, units};
use lostmotion::plan::Sample;
use lostmotion::sim::results::{BlockResult, ErrorStats, PlanInfo};
use std::ffi::{c_char, c_void};

/// Distribution of an error's magnitude, um.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmErrorStats {
    /// Number of samples.
    pub samples: u64,
    /// Largest magnitude.
    pub max: f64,
    /// Root mean square.
    pub rms: f64,
    /// Median.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
    /// 99th percentile.
    pub p99: f64,
    /// 99.9th percentile.
    pub p999: f64,
}

/// How far a run is.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmProgress {
    /// Bytes of the program read so far.
    pub done_bytes: u64,
    /// Bytes of the program.
    pub total_bytes: u64,
    /// Machine time so far, s.
    pub simulated_s: f64,
    /// Part of the program that has been read, 0 to 1.
    pub share: f64,
}

/// A servo tick of the contour as the machine cut it; places in mm from the program's zero.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmContourSample {
    /// Time, s.
    pub time_s: f64,
    /// Contour error, um: positive to the left of the direction of travel.
    pub error_um: f64,
    /// What backlash adds to it, um.
    pub backlash_um: f64,
    /// Foot point on the programmed path.
    pub foot_mm: [f64; 3],
    /// Unit vector to the left of travel in the plane in force.
    pub normal: [f64; 3],
    /// Commanded tip.
    pub commanded_mm: [f64; 3],
    /// Actual tip.
    pub actual_mm: [f64; 3],
    /// Unit vector along the tool, from its tip to the spindle.
    pub tool: [f64; 3],
    /// Line of the block, from 1.
    pub line: u32,
    /// Whether any joint is commanded to move; the others are not judged.
    pub moving: bool,
    /// Whether the tool is on a G0 move.
    pub rapid: bool,
}

/// A motor at a servo tick, in the unit of its axis.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmMotorSample {
    /// Time, s.
    pub time_s: f64,
    /// Reference of the servo.
    pub reference: f64,
    /// Motor, at the load's side of the transmission.
    pub motor: f64,
    /// Load.
    pub load: f64,
    /// Torque-forming current, A.
    pub current_a: f64,
    /// Torque, N m.
    pub torque_nm: f64,
    /// Flank of the gap in contact: -1, 0 or 1.
    pub engagement: i32,
    /// Letter of the axis.
    pub axis: c_char,
    /// Whether it is the second motor of a gantry.
    pub second: bool,
}

/// A block of the program, and how far the tool left its contour.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmBlock {
    /// Its text, trimmed, at most 80 characters.
    pub text: *const c_char,
    /// What makes most of the error, for people.
    pub cause: *const c_char,
    /// Running number of the move.
    pub segment: u64,
    /// Time of the worst sample, s.
    pub time_s: f64,
    /// Largest error, um, signed: positive to the left of the direction of travel.
    pub max_um: f64,
    /// Root mean square, um.
    pub rms_um: f64,
    /// Part of the command itself (blending) in the largest error, um.
    pub command_um: f64,
    /// Part that a machine without a gap would add, um.
    pub servo_um: f64,
    /// Part of the gap, um.
    pub backlash_um: f64,
    /// Commanded tip at the worst sample, mm, from the program's zero.
    pub at_mm: [f64; 3],
    /// File: 0 for the program, from 1 those of its subroutines.
    pub file: u32,
    /// Line, from 1.
    pub line: u32,
    /// Column in bytes, from 1.
    pub column: u32,
    /// Whether it is a G0 move.
    pub rapid: bool,
}

/// A reversal of an axis.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmReversal {
    /// When the commanded velocity changes its sign, s.
    pub time_s: f64,
    /// Largest contour error until the end of its window, um, signed.
    pub peak_um: f64,
    /// Share of backlash in it, um, signed.
    pub backlash_um: f64,
    /// Line of the block in force, from 1.
    pub line: u32,
    /// New direction: 1 or -1.
    pub direction: i32,
    /// Letter of the axis.
    pub axis: c_char,
    /// Whether it is on a rapid.
    pub rapid: bool,
}

/// A sample of the plan, one a command cycle: mm and deg of the joints X Y Z A B C U V W; zeros where
/// the machine has none. A joint that turns is in deg whatever its letter.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmPlanSample {
    /// Time, s.
    pub time_s: f64,
    /// Position.
    pub position: [f64; 9],
    /// Velocity per s.
    pub velocity: [f64; 9],
    /// Acceleration per s2.
    pub acceleration: [f64; 9],
    /// Line of the block, from 1.
    pub line: u32,
}

/// What is known of a plan.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct LmPlan {
    /// Length of the motion, s.
    pub duration_s: f64,
    /// Length of cutting moves, mm.
    pub cutting_mm: f64,
    /// Length of rapids, mm.
    pub rapid_mm: f64,
    /// Distance of the command itself from the programmed path on cutting moves, um: zeros where only
    /// the plan was asked for.
    pub command: LmErrorStats,
}

/// Is told how far a run is, about once a second of motion; false ends it.
pub type LmOnProgress =
    Option<unsafe extern "C" fn(user: *mut c_void, progress: *const LmProgress) -> bool>;
/// Takes samples of a method (its number in the order of the methods); false ends the run. They are
/// valid until it returns.
pub type LmOnContour = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        method: usize,
        samples: *const LmContourSample,
        count: usize,
    ) -> bool,
>;
/// Takes the motors of a method, for each tick those of all axes; as `LmOnContour`.
pub type LmOnMotors = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        method: usize,
        samples: *const LmMotorSample,
        count: usize,
    ) -> bool,
>;
/// Takes finished blocks of a method, in their order; as `LmOnContour`.
pub type LmOnBlocks = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        method: usize,
        blocks: *const LmBlock,
        count: usize,
    ) -> bool,
>;
/// Takes finished reversals of a method, in their order; as `LmOnContour`.
pub type LmOnReversals = Option<
    unsafe extern "C" fn(
        user: *mut c_void,
        method: usize,
        reversals: *const LmReversal,
        count: usize,
    ) -> bool,
>;
/// Takes samples of the plan; false ends it. They are valid until it returns.
pub type LmOnPlan = Option<
    unsafe extern "C" fn(user: *mut c_void, samples: *const LmPlanSample, count: usize) -> bool,
>;

/// A distribution as C reads it.
pub(crate) fn stats(stats: &ErrorStats) -> LmErrorStats {
    LmErrorStats {
        samples: stats.samples,
        max: stats.max,
        rms: stats.rms,
        p50: stats.p50,
        p95: stats.p95,
        p99: stats.p99,
        p999: stats.p999,
    }
}

/// A block as C reads it, with texts that live as long as `texts`.
pub(crate) fn block(row: &BlockResult, texts: &mut Texts) -> LmBlock {
    LmBlock {
        text: texts.of(&row.text),
        cause: texts.of(&row.cause.to_string()),
        segment: row.segment,
        time_s: row.time_s,
        max_um: row.max_um,
        rms_um: row.rms_um,
        command_um: row.parts_um.command,
        servo_um: row.parts_um.servo,
        backlash_um: row.parts_um.backlash,
        at_mm: row.at_mm,
        file: row.block.span.file,
        line: row.block.span.line,
        column: row.block.span.column,
        rapid: row.rapid,
    }
}

/// Letter of an axis.
pub(crate) fn letter(axis: AxisId) -> c_char {
    axis.letter() as u8 as c_char
}

/// A sample in mm and deg, as the command's table has it.
pub(crate) fn plan_sample(sample: &Sample, rotary: AxisSet, clock: Clock) -> LmPlanSample {
    let shown = |of: &Coords| {
        AxisId::ALL.map(|axis| {
            if rotary.contains(axis) {
                units::deg(of[axis])
            } else {
                of[axis]
            }
        })
    };
    LmPlanSample {
        time_s: sample.tick.saturating_mul(clock.period_ns()) as f64 / 1e9,
        position: shown(&sample.position),
        velocity: shown(&sample.velocity),
        acceleration: shown(&sample.acceleration),
        line: sample.block.span.line,
    }
}

/// What is known of a plan.
pub(crate) fn plan_told(plan: &PlanInfo) -> LmPlan {
    LmPlan {
        duration_s: plan.duration_s,
        cutting_mm: plan.cutting_mm,
        rapid_mm: plan.rapid_mm,
        command: stats(&plan.command),
    }
}
