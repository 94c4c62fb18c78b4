//! Errors of a fit, and reasons why a log does not determine the gap.

use serde::{Deserialize, Serialize};

/// Why a log does not determine the gap.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum NotExcited {
    /// No sample carries enough contact torque for its side to be known.
    #[error(
        "the contact torque stays below {threshold_nm:.4} N m (its largest values are {largest_nm:.4} N m): accelerate the axis harder, or lower the threshold"
    )]
    TorqueBelowThreshold {
        /// The 99.9th percentile of the absolute contact torque, N m.
        largest_nm: f64,
        /// The threshold in force, N m.
        threshold_nm: f64,
    },
    /// Rows are missing in nearly every window.
    #[error(
        "rows are missing so often, {percent:.0} % of them, that hardly a stretch of the log is whole: log every row"
    )]
    RowsLost {
        /// How many of the rows are missing.
        percent: f64,
    },
    /// Only one flank was ever in firm contact.
    #[error(
        "only one side of the gap was in firm contact ({positive} samples positive, {negative} negative): log a motion with reversals"
    )]
    OneSide {
        /// Samples with the positive flank in contact.
        positive: usize,
        /// Samples with the negative flank in contact.
        negative: usize,
    },
    /// The contact changed sides too rarely.
    #[error(
        "the contact changed sides {seen} times; at least {needed} changes are needed: log more reversals"
    )]
    TooFewTraversals {
        /// Changes of side in the log.
        seen: usize,
        /// Changes asked for.
        needed: usize,
    },
    /// Seen from the motor alone, too few crossings show a load that certainly rests or certainly
    /// slides on.
    #[error(
        "of {seen} changes of side, {usable} show a load that certainly rests or slides on; at least {needed} are needed: log more reversals, some gentle, some brisk"
    )]
    CrossingsUnclear {
        /// Crossings that can be used.
        usable: usize,
        /// Changes of side in the log.
        seen: usize,
        /// Crossings asked for.
        needed: usize,
    },
    /// The contact torque has one and the same size everywhere, so that gap and wind-up look alike.
    #[error(
        "the contact torque keeps nearly one size (it varies by {variation:.4} of its mean), so that gap and wind-up cannot be told apart: vary the acceleration, or give the stiffness"
    )]
    TorqueNotVaried {
        /// Standard deviation of the torque once side and offset are taken out, over its RMS.
        variation: f64,
    },
    /// The contact torque changes by less than the noise of the current lets tell.
    #[error(
        "the change of the contact torque drowns in the noise of the current, so that gap and wind-up cannot be told apart (together they are {together_rad:.3e} rad at the motor): vary the acceleration, log longer or with less noise of the current, or give the stiffness"
    )]
    TorqueHidden {
        /// Gap and wind-up together: the position difference between the two sides, rad at the motor.
        together_rad: f64,
    },
    /// Without the motor's data, wind-up and gap look alike in this log.
    #[error(
        "the gap cannot be told, because the motor's own inertia and friction are unknown, so that gap and wind-up look alike: give the axis (--axis); together the two are {span:.6} of the log's unit"
    )]
    MotorUnknown {
        /// Span of the position difference, in the log's unit.
        span: f64,
    },
    /// Seen from the motor alone, the load's motion drowns in the noise of the current.
    #[error(
        "the gap cannot be told from the motor alone, because the noise of its torque, {noise_nm:.4} N m, is above {most_nm:.4} N m, the most for torques of this size: log the load's position, too, or accelerate harder"
    )]
    NoiseHidesLoad {
        /// Standard deviation of the noise, N m.
        noise_nm: f64,
        /// The most that is allowed, N m.
        most_nm: f64,
    },
    /// Seen from the motor alone, the interval is so wide that it cannot be relied upon.
    #[error(
        "the gap cannot be told from the motor alone, because it leaves the half gap between {low_rad:.3e} and {high_rad:.3e} rad at the motor: log the load's position, too, or faster (4 kHz) with less noise of the current"
    )]
    MotorToldTooLittle {
        /// Lower end of the 95 % interval, rad at the motor.
        low_rad: f64,
        /// Upper end, rad at the motor.
        high_rad: f64,
    },
    /// Seen from the motor alone, the load's motion cannot be followed by the model's.
    #[error(
        "the gap cannot be told from the motor alone, because the load cannot be followed: its friction is not Coulomb and viscous, or so small that it bounces in its gap, or the current is filtered ({left_nm:.4} N m of torque are left over, the noise of the current is {noise_nm:.4} N m): log the load's position, too"
    )]
    LoadNotAsModelled {
        /// RMS of the torque that the model leaves, N m.
        left_nm: f64,
        /// The noise of the current in it, N m.
        noise_nm: f64,
    },
    /// Seen from the motor alone, the shaft's vibration is too fast for the log.
    #[error(
        "the gap cannot be told from the motor alone, because load and motor vibrate against each other at {frequency_hz:.0} Hz, too fast for rows {period_ms:.2} ms apart: log the load's position, too, or faster"
    )]
    ShaftTooFast {
        /// Natural frequency that was fitted, Hz.
        frequency_hz: f64,
        /// Time between rows, ms.
        period_ms: f64,
    },
    /// Seen from the motor alone, different gaps explain the log alike.
    #[error(
        "the gap cannot be told from the motor alone, because different gaps explain the log alike (half gaps of {first_rad:.3e} and {second_rad:.3e} rad at the motor): log the load's position, too, or longer with varied accelerations"
    )]
    SeveralGaps {
        /// Half gap that explains it best, rad at the motor.
        first_rad: f64,
        /// Another one, rad at the motor.
        second_rad: f64,
    },
    /// The rows were not sampled when the log says.
    #[error(
        "the gap cannot be told, because the rows were sampled some {jitter_ms:.3} ms beside the times that the log gives, which hides the motor's acceleration: log the time at which each row was sampled"
    )]
    TimesWrong {
        /// Standard deviation of the sampling time about the logged one, ms.
        jitter_ms: f64,
    },
    /// The interval is so wide that the value is no use.
    #[error(
        "the gap cannot be told, because noise and wind-up leave the half gap between {low_rad:.3e} and {high_rad:.3e} rad at the motor: log longer, with more reversals and varied accelerations, or with less noise of the current"
    )]
    IntervalTooWide {
        /// Lower end of the 95 % interval, rad at the motor.
        low_rad: f64,
        /// Upper end, rad at the motor.
        high_rad: f64,
    },
    /// The interval is so wide for a load that may be read later or earlier than its motor.
    #[error(
        "the gap cannot be told, because a load read up to {lateness_ms:.2} ms later or earlier than its motor leaves the half gap between {low_rad:.3e} and {high_rad:.3e} rad at the motor: log strokes of several speeds, which tell the two apart; where one drive reads both at the same time, say so (lateness 0)"
    )]
    LatenessUnknown {
        /// How much later or earlier it may be read, ms.
        lateness_ms: f64,
        /// Lower end of the 95 % interval, rad at the motor.
        low_rad: f64,
        /// Upper end, rad at the motor.
        high_rad: f64,
    },
    /// The interval of the half gap reaches zero.
    #[error(
        "the half gap of {half_gap_rad:.3e} rad cannot be told from zero (95 % interval up to {upper_rad:.3e} rad)"
    )]
    GapBelowNoise {
        /// Fitted half gap, rad at the motor.
        half_gap_rad: f64,
        /// Upper end of its 95 % interval, rad at the motor.
        upper_rad: f64,
    },
}

/// Why a fit failed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FitError {
    /// A log without samples.
    #[error("the log holds no samples")]
    Empty,
    /// Columns of different lengths.
    #[error(
        "the columns differ in length: {motor} motor positions, {load} load positions, {current} currents"
    )]
    LengthMismatch {
        /// Motor positions.
        motor: usize,
        /// Load positions.
        load: usize,
        /// Currents.
        current: usize,
    },
    /// NaN or infinity in a column.
    #[error("{column}[{index}] is {value}; a log holds finite numbers only")]
    NotFinite {
        /// Which column.
        column: &'static str,
        /// Index from 0.
        index: usize,
        /// The value.
        value: f64,
    },
    /// Times that do not rise.
    #[error("time[{index}] is {time_s} s, after {before_s} s; rows have to be in order of time")]
    TimeOrder {
        /// Index from 0.
        index: usize,
        /// The time before it, s.
        before_s: f64,
        /// The time, s.
        time_s: f64,
    },
    /// More rows missing than present.
    #[error(
        "the log has {rows} rows where its period leaves room for {places:.0}: more rows are missing than present"
    )]
    RowsMissing {
        /// Rows in the log.
        rows: usize,
        /// Rows that an even log over the same time would have.
        places: f64,
    },
    /// Units, signs or columns that cannot be right.
    #[error("the log does not go with the axis: {what}; likely cause: {cause}")]
    Implausible {
        /// What was found.
        what: String,
        /// What it looks like.
        cause: Cause,
    },
    /// A log too short for one averaging window.
    #[error(
        "the log has {samples} samples; the averaging window alone spans {needed}: log longer, or shorten half_window_s"
    )]
    TooShort {
        /// Samples in the log.
        samples: usize,
        /// Samples that one window spans.
        needed: usize,
    },
    /// A setting out of its range.
    #[error("{name} is {value}; it has to be {expected}")]
    Setting {
        /// Name of the setting, with its unit.
        name: &'static str,
        /// Its value.
        value: f64,
        /// What is allowed.
        expected: &'static str,
    },
    /// The log does not determine the gap.
    #[error("the log does not excite the gap: {0}")]
    NotExcited(#[from] NotExcited),
    /// The solver refused the problem.
    #[error("the solver refused the problem: {reason}")]
    SolverRefused {
        /// The solver's own words.
        reason: String,
    },
    /// The solver ended without a solution.
    #[error(
        "the solver stopped with status {status} after {iterations} iterations: loosen the tolerance or raise the iteration limit"
    )]
    Solver {
        /// How it ended.
        status: SolverStatus,
        /// Iterations made.
        iterations: u32,
    },
}

/// What a log that does not go with its axis looks like.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Cause {
    /// Times in ms, read as s.
    #[error(
        "the times look like milliseconds that are taken for seconds: `t_s` is in seconds, or say --column time=NAME,unit=ms"
    )]
    Milliseconds,
    /// Times in s, read as ms.
    #[error(
        "the times look like seconds that are taken for milliseconds: `t_ms` is in milliseconds, or say --column time=NAME,unit=s"
    )]
    Seconds,
    /// Rows too far apart for an axis: in other units, or of a slow log.
    #[error(
        "the times look like milliseconds, or the log is too slow; `t_s` is in seconds, and a stroke needs a row every 20 ms"
    )]
    SlowRows,
    /// Current in percent of the rated one.
    #[error("the current looks like percent of the rated current; `current_a` is in A")]
    PercentOfRated,
    /// Current in percent of the largest one.
    #[error("the current looks like percent of the drive's largest current; `current_a` is in A")]
    PercentOfLimit,
    /// Current in mA, in percent, or the motor of another axis.
    #[error(
        "the current looks like milliamperes or percent of the rated current; `current_a` is in A"
    )]
    CurrentUnit,
    /// Torque in the current's column.
    #[error("the current looks like a torque in N m; `current_a` is in A")]
    TorqueForCurrent,
    /// Positions in inches.
    #[error("the positions look like inches; `_mm` is in millimetres")]
    Inches,
    /// Positions in m, or current in mA.
    #[error("the positions look like metres, or the current like milliamperes")]
    Thousand,
    /// Positions in um.
    #[error("the positions look like micrometres, or the current like kiloamperes")]
    Micrometres,
    /// Degrees and radians.
    #[error("degrees and radians look exchanged")]
    Degrees,
    /// Revolutions of the motor, or in place of rad.
    #[error("the positions look like revolutions")]
    Revolutions,
    /// The motor's angle in place of the axis' position.
    #[error("the positions look like the motor's angle in rad; `_mm` and `_deg` are the axis'")]
    MotorAngle,
    /// The current has the other sign.
    #[error("the sign of the current, or of both positions, looks reversed")]
    CurrentSign,
    /// One position has the other sign.
    #[error("the sign of one of the two positions looks reversed")]
    PositionSigns,
    /// Motor and load position in different units.
    #[error("motor and load position look to be in different units, or the lead is another")]
    ColumnUnits,
    /// Motor's and load's columns are exchanged.
    #[error("the columns of motor and load look swapped")]
    SwappedColumns,
    /// A column is no position of this axis.
    #[error("the columns look mixed up: one of the two positions is none")]
    MixedColumns,
    /// Inertia and friction are another one's by one factor.
    #[error(
        "inertia and friction are off alike: the current is in another unit or scaling than A, or the torque constant is another one"
    )]
    CurrentScale,
    /// No unit explains it.
    #[error("torque constant, inertia or lead of another axis, or a unit that is not recognised")]
    OtherAxis,
}

impl FitError {
    /// Whether signs, units or columns of the log are certainly mistaken, so that nothing that is
    /// found in it counts.
    pub const fn is_of_the_log(&self) -> bool {
        matches!(self, FitError::Implausible { cause, .. } if cause.is_of_the_log())
    }
}

impl Cause {
    /// Whether a unit is named, though another axis could look the same.
    pub const fn names_a_unit(&self) -> bool {
        !matches!(self, Cause::OtherAxis)
    }

    /// Whether the columns are mistaken whatever axis they are of: signs, columns exchanged, or a
    /// factor that no wrong description comes near. Smaller factors may be another inertia, and rows
    /// far apart a slow log.
    const fn is_of_the_log(&self) -> bool {
        matches!(
            self,
            Cause::Milliseconds
                | Cause::Seconds
                | Cause::CurrentSign
                | Cause::PositionSigns
                | Cause::ColumnUnits
                | Cause::SwappedColumns
                | Cause::MixedColumns
                | Cause::CurrentUnit
                | Cause::Thousand
                | Cause::Micrometres
                | Cause::Inches
                | Cause::Degrees
        )
    }
}

/// How a solver ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum SolverStatus {
    /// Within the tolerances.
    Solved,
    /// A solution of reduced accuracy.
    AlmostSolved,
    /// No point satisfies the constraints.
    Infeasible,
    /// The objective falls without end.
    Unbounded,
    /// Out of iterations.
    IterationLimit,
    /// Gave up for numerical reasons.
    NumericalFailure,
}

impl std::fmt::Display for SolverStatus {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Solved => "solved",
            Self::AlmostSolved => "almost solved",
            Self::Infeasible => "infeasible",
            Self::Unbounded => "unbounded",
            Self::IterationLimit => "iteration limit",
            Self::NumericalFailure => "numerical failure",
        })
    }
}
