//! Results made by hand, with figures that were chosen, not computed.

use lostmotion_base::{AxisId, BlockRef, Span};
use lostmotion_sim::results::{
    AxisResult, BlockResult, Cause, ErrorParts, ErrorStats, LimitsUsed, MethodResult, PlanInfo,
    ProgramInfo, ReversalResult, Run, SCHEMA_VERSION, SingleRun, StopLimit, StopResult,
};

/// Statistics in proportion to a maximum.
pub(crate) fn stats(max: f64) -> ErrorStats {
    made!(ErrorStats {
        samples: 12_000,
        max,
        rms: max * 0.4,
        p50: max * 0.2,
        p95: max * 0.7,
        p99: max * 0.9,
        p999: max * 0.98,
    })
}

fn at_line(line: u32) -> BlockRef {
    BlockRef {
        span: Span {
            file: 0,
            line,
            column: 1,
            start: u64::from(line) * 20,
            len: 18,
        },
        call_stack: 0,
    }
}

fn block(line: u32, max_um: f64, cause: Cause, text: &str) -> BlockResult {
    made!(BlockResult {
        block: at_line(line),
        text: text.to_owned(),
        segment: u64::from(line),
        rapid: false,
        time_s: 0.75 * f64::from(line),
        max_um,
        rms_um: max_um.abs() * 0.4,
        parts_um: made!(ErrorParts {
            command: 0.0,
            servo: max_um * 0.25,
            backlash: max_um * 0.75,
        }),
        cause,
        at_mm: [25.0, -0.0004, -1.5],
    })
}

fn used(axis: AxisId) -> LimitsUsed {
    made!(LimitsUsed {
        axis,
        following_error: 0.0421,
        travel: 0.5,
        overload: 0.25,
        at_limit: 0.0,
    })
}

fn axis(axis: AxisId, gap: f64) -> AxisResult {
    made!(AxisResult {
        axis,
        unit: if axis.is_rotary() { "mdeg" } else { "um" }.to_owned(),
        gap,
        following: stats(gap * 1.2),
        following_without_gap: stats(gap * 0.2),
        reversals: 4,
        peak_current_ratio: 0.273,
        saturated_samples: if axis == AxisId::Y { 12 } else { 0 },
        peak_velocity: 50.0,
        range: [-25.0, 25.0],
    })
}

/// A method whose cutting error and share of backlash are these.
pub(crate) fn method(name: &str, cutting: f64, backlash: f64) -> MethodResult {
    let reversal = |axis, direction, time_s, peak_um: f64| {
        made!(ReversalResult {
            axis,
            time_s,
            block: at_line(5),
            direction,
            peak_um,
            backlash_um: peak_um * 0.9,
            rapid: false,
        })
    };
    made!(MethodResult {
        method: name.to_owned(),
        cutting: stats(cutting),
        rapid: stats(cutting * 3.0),
        backlash: stats(backlash),
        orientation_mdeg: None,
        worst_blocks: vec![
            block(
                5,
                -cutting,
                Cause::Reversal(AxisId::X),
                "G2 X0 Y0 I25 J0 (the \"circle\", once)",
            ),
            block(4, 1.2, Cause::ServoLag, "G1 X0 F3000"),
        ],
        reversals: vec![
            reversal(AxisId::X, -1, 3.25, -cutting),
            reversal(AxisId::Y, 1, 1.5, 4.0),
        ],
        reversal_count: 8,
        limits_used: vec![used(AxisId::X)],
        axes: vec![axis(AxisId::X, 10.0), axis(AxisId::Y, 40.0)],
        gantry: None,
        within_tolerance: cutting <= 10.0,
        notes: Vec::new(),
    })
}

/// X is off its command, because its compensator drives it.
pub(crate) fn stop() -> StopResult {
    made!(StopResult {
        axis: AxisId::X,
        limit: StopLimit::FollowingError,
        time_s: 3.218_25,
        block: at_line(14),
        at_mm: [25.0, 1.5, -1.5],
        unit: "um".to_owned(),
        value: -1530.25,
        allowed: 1024.0,
        at_limit_s: 0.25,
        reason: "the compensator asks for -1529 um; the drive was at its current or voltage limit for 0.250 s"
            .to_owned(),
    })
}

fn program() -> ProgramInfo {
    made!(ProgramInfo {
        name: "circle.ngc".to_owned(),
        bytes: 123,
        lines: 9,
        moves: 4,
        warnings: vec!["line 9: no M2 at the end".to_owned()],
        files: Vec::new(),
    })
}

fn plan() -> PlanInfo {
    made!(PlanInfo {
        duration_s: 12.345_678_9,
        cutting_mm: 207.079_632,
        rapid_mm: 50.0,
        command: ErrorStats::default(),
        cutting_force_n: 0.0,
        bow: None,
        bow_limit_um: None,
        unstraight: None,
    })
}

/// A run on a worn mill.
pub(crate) fn simulation() -> SingleRun {
    let mut result = method("fixed", 12.345_678, 9.87);
    result.orientation_mdeg = Some(stats(1.5));
    result.axes.push(axis(AxisId::C, 3.0));
    result
        .notes
        .push("Y: the drive was at its current limit in 12 samples".to_owned());
    made!(SingleRun {
        schema: SCHEMA_VERSION,
        program: program(),
        machine: "mill-worn".to_owned(),
        tolerance_um: 10.0,
        plan: plan(),
        without_gap: stats(1.1),
        result,
    })
}

/// Five methods, of which one does harm and one has higher peaks.
pub(crate) fn comparison() -> Run {
    let mut spiky = method("spiky", 60.0, 36.0);
    spiky.backlash.rms = 3.0;
    let mut published = method("published", 4.2e7, 4.1e7);
    published.notes.push(
        "does harm here: backlash RMS 16400000.00 um against 14.00 um without compensation"
            .to_owned(),
    );
    made!(Run {
        schema: SCHEMA_VERSION,
        program: program(),
        machine: "mill-worn".to_owned(),
        tolerance_um: 10.0,
        plan: plan(),
        without_gap: stats(1.1),
        results: vec![
            method("none", 36.0, 35.0),
            method("fixed", 8.0, 7.5),
            published,
            spiky,
            method("load-feedback", 2.0, 1.0),
        ],
        recommended: Some("fixed".to_owned()),
    })
}
