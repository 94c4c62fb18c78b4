//! How bad a problem is, and what to try.

use super::Problem;
use crate::severity::Severity;

impl Problem {
    /// Warnings leave the program accepted.
    pub fn severity(&self) -> Severity {
        match self {
            Problem::Habit { leniency, .. } => leniency.severity(),
            Problem::NoProgramEnd
            | Problem::NoClosingPercent
            | Problem::ByteOrderMark
            | Problem::UnsetParameter { .. }
            | Problem::NoToolTable { .. }
            | Problem::FeedBeforeUnits { .. }
            | Problem::NegativeDwell { .. }
            | Problem::EndlessMain
            | Problem::Lenient { .. }
            | Problem::SpindleAssumed
            | Problem::FinishDetour { .. }
            | Problem::UnclosedSub { .. } => Severity::Warning,
            _ => Severity::Error,
        }
    }

    /// What to try.
    pub fn hint(&self) -> Option<String> {
        if let Some(limit) = self.limit() {
            return Some(format!(
                "the limit `{limit}` can be raised: --limit {limit}=VALUE on the command line"
            ));
        }
        let text = match self {
            Problem::ArcRadii {
                center_absolute: false,
                ..
            } => "did you mean G90.1, absolute arc centres?",
            Problem::ArcRadii { .. } => "did you mean G91.1, centres relative to the start?",
            Problem::ArcRadiusShort { .. } => {
                "check R, and whether the start is where it is meant to be"
            }
            Problem::ArcSamePoint => "write a full circle with I, J or K",
            Problem::NoFeed { .. } => "set F first",
            Problem::FeedBeforeUnits { .. } => "put F on the next line",
            Problem::NoInverseTimeFeed { .. } => {
                "G93 needs F on every G1, G2 and G3; G94 goes back to units per minute"
            }
            Problem::NoRevolutions { .. } => "start the spindle with M3 or M4 and S, or use G94",
            Problem::AxisWithoutCode => "start the line with G0 or G1",
            Problem::Nul => "the file may be damaged or not a text file",
            Problem::SpindleStopped { .. } => "start the spindle with M3 or M4",
            Problem::TurningPlane { .. } => "put G18 before it",
            Problem::ProfileEmpty { .. } => {
                "the first move leads to the profile, the others are the profile"
            }
            Problem::ProfileTurnsBack { .. } => {
                "write it so that it never goes back, or cut it in two cycles"
            }
            Problem::ProfileCode { .. } => "a profile consists of G0, G1, G2 and G3",
            Problem::ProfileCorner { two: false, .. } => {
                "make it positive and smaller than the moves before and after it"
            }
            Problem::ProfileIncrement { .. } => {
                "X and Z are incremental already; U and W are for G90"
            }
            Problem::ProfileDistance { .. } => "reduce D, or widen the grooves of the profile",
            Problem::FinishDetour { .. } => {
                "write the finishing pass without G41 and G42 (G40, with D or E), or refuse finish-detour if the control goes straight to the profile"
            }
            Problem::G53Incremental => "put G90 before it",
            Problem::Siemens { .. } => {
                "write it as RS274/NGC (G-code), or post-process the part for another control"
            }
            Problem::Checksum { .. } => "the line has been changed since the checksum was made",
            Problem::NoProgramEnd => "end the program with M2",
            Problem::NoClosingPercent => "a program that starts with % also ends with %",
            Problem::TwoAxisUsers { .. } => "put them on two lines",
            Problem::NoSuchSub { .. } => {
                "define it in the program, or put its file into the part's folder or one that subroutines are taken from (--subroutines)"
            }
            Problem::Heidenhain => "post-process the part for a control that reads G-code",
            Problem::NoSuchTool { .. } => "check the tool table",
            Problem::UnusedWord {
                letter: 'E', users, ..
            } if !users.is_empty() => {
                return Some(format!(
                    "it belongs to {users}; an exponent needs its sign (1E+3), or --dialect fanuc"
                ));
            }
            Problem::UnusedWord { users, .. } if !users.is_empty() => {
                return Some(format!("it belongs to {users}"));
            }
            Problem::ControlCycle { hint, .. } => hint,
            Problem::Habit { leniency, .. } => return leniency.remedy().map(str::to_owned),
            _ => return None,
        };
        Some(text.to_owned())
    }

    /// The limit of [`crate::Limits`] that has been exceeded.
    pub fn limit(&self) -> Option<&'static str> {
        use Problem as P;
        Some(match self {
            P::LineTooLong { .. } => "line_bytes",
            P::SourceTooLong { .. } => "source_bytes",
            P::TooManyWords { .. } => "words",
            P::TooDeep { .. } => "expression_depth",
            P::TooManyBlocks { .. } => "executed_blocks",
            P::TooManyLoopedBlocks { .. } => "looped_blocks",
            P::TooManyOperations { .. } => "looped_operations",
            P::IdleLoop { .. } => "idle_blocks",
            P::CallsTooDeep { .. } => "call_depth",
            P::TooManyOpen { .. } => "open_structures",
            P::TooMuchHeld { .. } => "held_bytes",
            P::CoordinateTooLarge { .. } => "coordinate",
            P::RadiusTooLarge { .. } => "radius_mm",
            P::FeedTooLarge { .. } => "feed",
            P::DwellTooLong { .. } => "dwell_s",
            P::CycleTooLong { .. } => "cycle_moves",
            P::CurveTooLong { .. } => "curve_points",
            P::TooManyParameters { .. } => "named_parameters",
            _ => return None,
        })
    }
}
