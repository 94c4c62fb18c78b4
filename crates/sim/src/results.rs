//! What a run answers, as data. Text, JSON, CSV and pictures are made from these by the report
//! crate.
//!
//! Errors are in micrometres (linear) and millidegrees (orientation), times in s; every field says
//! so. The JSON form of these types is the versioned output of the command line: fields are only
//! ever added within one schema number, and one that is missing in a file is read as its default.

use crate::machine::Memory;
use lostmotion_base::{AxisId, BlockRef};
pub use lostmotion_contour::Cause;
use lostmotion_methods::{MethodId, Misled, Told};
use lostmotion_plan::Shortfalls;
use serde::{Deserialize, Serialize};

/// Version of the JSON form of [`Run`] and [`SingleRun`].
pub const SCHEMA_VERSION: u32 = 1;

/// Distribution of an error's magnitude over the samples of one kind of motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct ErrorStats {
    /// Number of samples.
    pub samples: u64,
    /// Largest magnitude.
    pub max: f64,
    /// Root mean square.
    pub rms: f64,
    /// Median magnitude.
    pub p50: f64,
    /// 95th percentile.
    pub p95: f64,
    /// 99th percentile.
    pub p99: f64,
    /// 99.9th percentile.
    pub p999: f64,
}

/// One block of the program and how far the tool left its contour.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct BlockResult {
    /// Where the block stands.
    pub block: BlockRef,
    /// The block's text, trimmed, at most 80 characters.
    pub text: String,
    /// Running number of the move.
    pub segment: u64,
    /// Whether it is a G0 move.
    pub rapid: bool,
    /// Time of the worst sample, s.
    pub time_s: f64,
    /// Largest error, signed, um; positive to the left of the direction of travel.
    pub max_um: f64,
    /// Root mean square, um.
    pub rms_um: f64,
    /// Parts of the error at the worst sample, um: command (blending), servo, backlash.
    pub parts_um: ErrorParts,
    /// What makes most of it.
    pub cause: Cause,
    /// Tool tip commanded at the worst sample, mm, from the program's zero.
    pub at_mm: [f64; 3],
}

/// Decomposition of one signed contour error, um. The sum is the error itself.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct ErrorParts {
    /// The command's own distance from the programmed path.
    pub command: f64,
    /// What the machine without a gap adds.
    pub servo: f64,
    /// What the gap adds.
    pub backlash: f64,
}

/// One reversal of one axis.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct ReversalResult {
    /// The axis.
    pub axis: AxisId,
    /// When its commanded velocity changes sign, s.
    pub time_s: f64,
    /// The block in force then.
    pub block: BlockRef,
    /// New direction: 1 or -1.
    pub direction: i8,
    /// Largest contour error between this reversal and the end of its window, um, signed.
    pub peak_um: f64,
    /// Share of backlash in it, um, signed.
    pub backlash_um: f64,
    /// Whether the reversal is on a rapid.
    pub rapid: bool,
}

/// One axis over the whole run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct AxisResult {
    /// The axis.
    pub axis: AxisId,
    /// Unit of the position figures below: `um` or `mdeg`.
    pub unit: String,
    /// Total gap of the machine's axis.
    pub gap: f64,
    /// Following error: reference minus load position (delay of the spline taken out).
    pub following: ErrorStats,
    /// The same without the gap.
    pub following_without_gap: ErrorStats,
    /// Number of reversals.
    pub reversals: u64,
    /// Largest current, in parts of the drive's limit.
    pub peak_current_ratio: f64,
    /// Samples at which the drive was at a limit.
    pub saturated_samples: u64,
    /// Peak commanded velocity per s (mm or deg).
    pub peak_velocity: f64,
    /// Travelled range, mm or deg.
    pub range: [f64; 2],
}

/// How near the motors of an axis came to the limits that stop the machine, as parts of them: 1 is
/// the limit. 0 where nothing is watched; on a gantry the larger of both motors.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct LimitsUsed {
    /// The axis.
    pub axis: AxisId,
    /// Of the following error that is allowed at the speed of the moment.
    pub following_error: f64,
    /// Of the way from the middle of the travel to where the motor is stopped.
    pub travel: f64,
    /// Of the overload (I2t).
    pub overload: f64,
    /// Of the time that the drive may be at its limit without a break.
    pub at_limit: f64,
}

/// Skew of an axis that two motors drive: how far its first end is ahead of the second while
/// anything moves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct GantryResult {
    /// The axis.
    pub axis: AxisId,
    /// Distribution of the skew's magnitude, um.
    pub skew_um: ErrorStats,
    /// The largest, um, signed: positive where the first end is ahead.
    pub peak_um: f64,
    /// When, s.
    pub time_s: f64,
    /// In which block.
    pub block: BlockRef,
}

/// What a control watches while a machine moves.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "kebab-case")]
#[non_exhaustive]
pub enum StopLimit {
    /// Commanded minus measured position of the motor.
    #[default]
    FollowingError,
    /// Position of the motor beyond the travel.
    Travel,
    /// Warmth of the motor by the square of its current.
    Overload,
    /// Time at the drive's current or voltage limit without a break.
    AtLimit,
}

impl std::fmt::Display for StopLimit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            StopLimit::FollowingError => "following error",
            StopLimit::Travel => "motor position",
            StopLimit::Overload => "overload",
            StopLimit::AtLimit => "time at the drive's limit",
        })
    }
}

/// Where and why the control stops the machine, in a command cycle.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct StopResult {
    /// The axis.
    pub axis: AxisId,
    /// Whether it is the second motor of a gantry.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub second: bool,
    /// The limit that it has passed.
    pub limit: StopLimit,
    /// When, s.
    pub time_s: f64,
    /// The block in force then.
    pub block: BlockRef,
    /// Tool tip commanded then, mm, from the program's zero.
    pub at_mm: [f64; 3],
    /// Unit of the two values below: `um` or `mdeg` of a following error, `mm` or `deg` of a
    /// position, `%` of an overload, `s` at the drive's limit.
    pub unit: String,
    /// What it was, signed.
    pub value: f64,
    /// The limit: of a following error its magnitude, of the travel its end with the overtravel, of
    /// an overload 100, else the longest time.
    pub allowed: f64,
    /// How long the drive had been at its current or voltage limit by then, s.
    pub at_limit_s: f64,
    /// Why, as far as it can be told: an unstable loop, a drive at its limit, a compensator that
    /// drives the axis off. May be empty.
    pub reason: String,
}

impl StopResult {
    /// The axis, and which of its motors on a gantry: `X`, `Y2`.
    pub fn motor(&self) -> String {
        format!("{}{}", self.axis, if self.second { "2" } else { "" })
    }
}

/// How one method did.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct MethodResult {
    /// Registered name of the compensator.
    pub method: String,
    /// Contour error of cutting moves (G1, G2, G3), um.
    pub cutting: ErrorStats,
    /// Contour error of rapids, um.
    pub rapid: ErrorStats,
    /// What backlash adds to the error on cutting moves, um: the length of the difference between
    /// the errors with and without a gap, as vectors across the path.
    pub backlash: ErrorStats,
    /// Tool-axis orientation error on cutting moves, mdeg, on machines with rotary axes.
    pub orientation_mdeg: Option<ErrorStats>,
    /// Cutting blocks with the largest error, worst first; G0 blocks only if the program cuts
    /// nothing.
    pub worst_blocks: Vec<BlockResult>,
    /// Reversals with the largest error, worst first; the number kept is bounded.
    pub reversals: Vec<ReversalResult>,
    /// Number of all reversals.
    pub reversal_count: u64,
    /// Per axis.
    pub axes: Vec<AxisResult>,
    /// Skew of the gantry, on machines that have one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gantry: Option<GantryResult>,
    /// Where the control stops the machine; all figures are of what was before. `None` if it runs
    /// to the end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stop: Option<StopResult>,
    /// How near each axis came to being stopped.
    pub limits_used: Vec<LimitsUsed>,
    /// Largest error of cutting moves within the tolerance, and the machine not stopped?
    pub within_tolerance: bool,
    /// How it does where the drive is told its axis wrong; of methods that are compared and told
    /// something.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub misled: Vec<MisledResult>,
    /// What it has learned of the axes by the end, of a method that learns. Not part of the JSON
    /// form: it is a file of its own.
    #[serde(skip)]
    pub learned: Memory,
    /// Why it is not recommended, if there is a reason.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_recommended: Option<String>,
    /// Remarks for people: saturation, a limit cycle, a method that does harm.
    pub notes: Vec<String>,
}

/// How a method does where the drive is told one quantity of its axes wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct MisledResult {
    /// What is told wrong, on every axis.
    #[serde(flatten)]
    pub misled: Misled,
    /// Contour error of cutting moves, um.
    pub cutting: ErrorStats,
    /// What backlash adds to it, um.
    pub backlash: ErrorStats,
    /// Whether the control stops the machine; the errors are then of what was before.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub stops: bool,
}

/// The program that was run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct ProgramInfo {
    /// File name as given.
    pub name: String,
    /// Size.
    pub bytes: u64,
    /// Lines.
    pub lines: u64,
    /// Moves.
    pub moves: u64,
    /// Warnings of the front end, rendered.
    pub warnings: Vec<String>,
    /// Files of subroutines that were read: blocks name them by their place in this list, from 1.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub files: Vec<String>,
}

/// The plan, common to all methods.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct PlanInfo {
    /// Duration of the program, s.
    pub duration_s: f64,
    /// Length of cutting moves, mm.
    pub cutting_mm: f64,
    /// Length of rapids, mm.
    pub rapid_mm: f64,
    /// Deviation of the command itself from the programmed path on cutting moves, um.
    pub command: ErrorStats,
    /// Size of the cutting force on feed moves, N.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub cutting_force_n: f64,
    /// On machines whose joints do not go straight with the tool, and where there is a limit to
    /// keep: how far it leaves its planned way between two commands if the drives join them by
    /// straight lines of the joints, in the part's frame.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bow: Option<Straightness>,
    /// How far it may be at most, um, where the motion is planned to keep a limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bow_limit_um: Option<f64>,
    /// How far a straight feed move with linear and rotary words, without tool-centre-point
    /// control, is from the straight line between its ends in the part's frame; `None` where there
    /// is no such move.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unstraight: Option<Straightness>,
    /// Interventions whose time came after the end of the motion; they did nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub late: Option<LateInterventions>,
    /// How often the plan is not what it could be, if it ever is not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shortfalls: Option<PlanShortfalls>,
}

/// How often a plan is not what it could be: it keeps every limit, but takes longer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct PlanShortfalls {
    /// Stops because the look-ahead window was too short for the path's detail.
    pub window_stops: u64,
    /// Stops where a smooth curve in place of many lines could not be found any further.
    pub curve_stops: u64,
    /// Windows of a retimed motion (quality `optimal`, overrides above 100 %) in which nothing
    /// faster was found than the pace that they end with.
    pub kept_windows: u64,
}

impl PlanShortfalls {
    /// Those of a plan; `None` where there is none.
    pub(crate) fn of(plan: Shortfalls) -> Option<PlanShortfalls> {
        let found = PlanShortfalls {
            window_stops: plan.window_stops,
            curve_stops: plan.curve_stops,
            kept_windows: plan.kept_windows,
        };
        (found != PlanShortfalls::default()).then_some(found)
    }
}

fn is_zero(value: &f64) -> bool {
    value.to_bits() == 0
}

/// Interventions that came too late to do anything.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct LateInterventions {
    /// How many.
    pub count: u64,
    /// Time of the first of them since the start of the program, s.
    pub first_s: f64,
    /// When the motion was over, s.
    pub end_s: f64,
}

/// Answer of a run: one plan, one method or several side by side.
///
/// Its JSON form is that of `compare`; [`Run::into_single`] gives that of `simulate`.
///
/// ```
/// use lostmotion_sim::{Machine, Program, Run, Simulation};
///
/// let program = Program::from_str("arc.ngc", "G21 G90 G17\nG0 X9 Y0\nG3 I-9 F900\nM2\n");
/// let run = Simulation::new(&program, &Machine::preset("vmc3-worn")?)
///     .methods(["none", "fixed"])
///     .run()?;
/// let [none, fixed] = ["none", "fixed"].map(|name| run.result(name).map(|r| r.backlash.rms));
/// assert!(fixed < none);
/// // As JSON it reads back to the last bit.
/// let text = serde_json::to_string(&run)?;
/// assert_eq!(serde_json::from_str::<Run>(&text)?, run);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct Run {
    /// Version of this form, [`SCHEMA_VERSION`].
    pub schema: u32,
    /// The program.
    pub program: ProgramInfo,
    /// Machine name.
    pub machine: String,
    /// Tolerance of the verdict, um.
    pub tolerance_um: f64,
    /// The plan.
    pub plan: PlanInfo,
    /// The same machine without any gap and without compensation: the best that compensation can
    /// reach, um on cutting moves.
    pub without_gap: ErrorStats,
    /// One row a method, in the order asked for.
    pub results: Vec<MethodResult>,
    /// The method to use: never one that stops the machine, or leaves a larger contour error than no compensation, as it
    /// stands or with gap, friction or stiffness told wrong ([`MethodResult::misled`]); of the
    /// others one that keeps the tolerance, with the smallest RMS in the worst of these runs.
    /// `None` if there is one method, or none that can be recommended.
    pub recommended: Option<String>,
    /// What it would take to recommend another one: that which is best where everything is told
    /// right, if it is not the one that is safe where something is told wrong.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub trust: Option<Trust>,
}

/// How well the axes have to be known for a method to be recommended.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct Trust {
    /// The method.
    pub method: String,
    /// The quantities that have to be known better.
    pub told: Vec<Told>,
    /// Largest part of the values tried by which they may be off; `None` if the method is not
    /// safe even with the smallest one.
    pub within: Option<f64>,
    /// The smallest part tried.
    pub least: f64,
}

/// A block of a run, for a listing.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct WorstBlock<'a> {
    /// Its line, from 1.
    pub line: u32,
    /// Everything else about it.
    pub result: &'a BlockResult,
}

impl std::ops::Deref for WorstBlock<'_> {
    type Target = BlockResult;

    fn deref(&self) -> &BlockResult {
        self.result
    }
}

impl Run {
    /// How the first method did; a run has one at least.
    pub fn first(&self) -> Option<&MethodResult> {
        self.results.first()
    }

    /// How a method did, by its name.
    pub fn result(&self, method: &str) -> Option<&MethodResult> {
        self.results.iter().find(|result| result.method == method)
    }

    /// The blocks of the first method with the largest errors, worst first.
    pub fn blocks(&self) -> impl Iterator<Item = WorstBlock<'_>> {
        self.first().into_iter().flat_map(MethodResult::blocks)
    }

    /// The method whose verdict is that of the run: of several the recommended one, `None` where
    /// none can be recommended.
    pub fn deciding(&self) -> Option<&MethodResult> {
        self.results.get(self.deciding_index()?)
    }

    /// Where [`Run::deciding`] is among the results.
    pub fn deciding_index(&self) -> Option<usize> {
        match &self.recommended {
            Some(name) => self
                .results
                .iter()
                .position(|result| result.method == *name),
            None => (self.results.len() == 1).then_some(0),
        }
    }

    /// Whether the method that decides ([`Run::deciding`]) keeps the tolerance on all cutting
    /// moves, and the machine is not stopped; false where no method can be recommended.
    pub fn is_within_tolerance(&self) -> bool {
        self.deciding()
            .is_some_and(|result| result.within_tolerance)
    }

    /// The same for the first method alone; `None` for a run without any.
    pub fn into_single(self) -> Option<SingleRun> {
        let result = self.results.into_iter().next()?;
        Some(SingleRun {
            schema: self.schema,
            program: self.program,
            machine: self.machine,
            tolerance_um: self.tolerance_um,
            plan: self.plan,
            without_gap: self.without_gap,
            result,
        })
    }
}

/// Answer of a run with one method, as `simulate` writes it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct SingleRun {
    /// Version of this form, [`SCHEMA_VERSION`].
    pub schema: u32,
    /// The program.
    pub program: ProgramInfo,
    /// Machine name.
    pub machine: String,
    /// Tolerance of the verdict, um.
    pub tolerance_um: f64,
    /// The plan.
    pub plan: PlanInfo,
    /// The same machine without any gap and without compensation: the best that compensation can
    /// reach, um on cutting moves.
    pub without_gap: ErrorStats,
    /// The method.
    pub result: MethodResult,
}

impl From<SingleRun> for Run {
    fn from(single: SingleRun) -> Run {
        Run {
            schema: single.schema,
            program: single.program,
            machine: single.machine,
            tolerance_um: single.tolerance_um,
            plan: single.plan,
            without_gap: single.without_gap,
            results: vec![single.result],
            recommended: None,
            trust: None,
        }
    }
}

impl MethodResult {
    /// Its blocks with the largest errors, worst first.
    pub fn blocks(&self) -> impl Iterator<Item = WorstBlock<'_>> {
        self.worst_blocks.iter().map(|result| WorstBlock {
            line: result.block.span.line,
            result,
        })
    }

    /// Whether it is the method that does nothing, which others are held against.
    pub fn is_baseline(&self) -> bool {
        self.method == MethodId::NONE.name()
    }

    /// In what it is worse than doing nothing on the same plan, if it is and neither stops the
    /// machine.
    pub fn harm(&self, baseline: &MethodResult) -> Option<Harm> {
        if self.stop.is_some() || baseline.stop.is_some() {
            return None;
        }
        Harm::of(&self.backlash, &baseline.backlash)
    }
}

/// A part of the error that backlash causes which is larger than without compensation by less is
/// not called harm, um: less than a snapshot of the model, or a machine, repeats.
pub(crate) const HARM_UM: f64 = 0.1;

/// In what a method is worse than doing nothing, as ratios of the part that backlash causes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Harm {
    /// Its RMS is larger: this many times.
    Rms(f64),
    /// Its RMS is not, but its peak is: this many times.
    Peak(f64),
}

impl Harm {
    /// Of the backlash error with a method, held against that without one. A difference under 0.1
    /// um is none.
    pub(crate) fn of(with: &ErrorStats, without: &ErrorStats) -> Option<Harm> {
        let worse = |with: f64, without: f64| (with > without + HARM_UM).then(|| with / without);
        // The RMS speaks for the whole program, the peak for one place in it.
        worse(with.rms, without.rms)
            .map(Harm::Rms)
            .or_else(|| worse(with.max, without.max).map(Harm::Peak))
    }
}

/// The largest distance of a way that is no straight line from a straight one, and where.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct Straightness {
    /// Distance, um.
    pub max_um: f64,
    /// The block.
    pub block: BlockRef,
}

impl PlanInfo {
    /// A warning where the tool leaves its way between two commands by more than a limit, um.
    pub fn bow_warning(&self, limit_um: f64) -> Option<String> {
        let Straightness { max_um, block } = self.bow.filter(|bow| bow.max_um > limit_um)?;
        let line = block.span.line;
        Some(format!(
            "line {line}: between two commands the tool bows by {max_um:.3} um from its way if the joints go straight (limit {limit_um} um); a shorter command cycle, a \
             lower speed or a smoother interpolator help"
        ))
    }

    /// A warning where the plan is not what it could be.
    pub fn shortfall_warning(&self) -> Option<String> {
        let PlanShortfalls {
            window_stops,
            curve_stops,
            kept_windows,
        } = self.shortfalls?;
        let times = |count: u64, what: &str| match count {
            0 => None,
            1 => Some(format!("once {what}")),
            more => Some(format!("{more} times {what}")),
        };
        let told = [
            times(window_stops, "it stops for want of look-ahead"),
            times(curve_stops, "it stops where a smooth curve ends"),
            times(
                kept_windows,
                "a stretch keeps a steady pace, since nothing faster was found",
            ),
        ];
        let told: Vec<String> = told.into_iter().flatten().collect();
        Some(format!(
            "the plan keeps every limit but is not as fast as it could be: {}",
            told.join(", ")
        ))
    }

    /// A warning where interventions came after the end of the motion.
    pub fn late_warning(&self) -> Option<String> {
        let LateInterventions {
            count,
            first_s,
            end_s,
        } = self.late?;
        let which = match count {
            1 => format!("the intervention at {first_s} s comes"),
            more => format!("{more} interventions, the first at {first_s} s, come"),
        };
        Some(format!(
            "{which} after the end of the motion at {end_s:.3} s and did nothing"
        ))
    }
}
