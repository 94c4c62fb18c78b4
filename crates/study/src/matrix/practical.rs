//! The practical limit: what may be expected of a drive in a cell at best.
//!
//! Three causes limit a method that learns, and add up:
//!
//! - torque: the gap is crossed on a quintic, whose largest torque `5.77 J_M g/T^2` is the drive's
//!   limit. That takes 1.2 times as long as the shortest traverse with full torque one way and the
//!   other (`limit`), and errors go with the second or third power of the time: 1.73 times the
//!   least possible at most.
//! - the gap has to be known: to a hundredth, which four reversals can show; a hundredth of the
//!   error stays.
//! - encoder: a motion below a count is not seen. RMS a count over the square root of 12, at most a
//!   count.
//!
//! The squares of the RMS errors add up, and the largest errors do.

use super::result::CellResult;
use lostmotion_methods::MethodId;

/// Traverse on a quintic over the shortest one, to the third power: (sqrt(5.77)/2)^3.
const QUINTIC_TRAVERSE_CUBED: f64 = 1.733;
/// Part of the gap that is not known: what a careful measurement leaves. A choice.
const UNKNOWN_GAP_SHARE: f64 = 0.01;
/// Goal where the limit allows it: RMS and largest error over those of `none`. A choice.
pub const WANTED: [f64; 2] = [0.02, 0.10];

impl CellResult {
    /// The practical limit: RMS and largest error, over those of `none`; `None` if `none` leaves
    /// next to nothing.
    pub fn practical(&self) -> Option<[f64; 2]> {
        let none = self.of(MethodId::NONE.name())?;
        // No limit where `none` leaves next to nothing: there is no ratio to hold it against.
        self.ratios(MethodId::NONE.name())?;
        let rms = [
            QUINTIC_TRAVERSE_CUBED * self.limit_rms_um,
            UNKNOWN_GAP_SHARE * none.rms_um,
            self.encoder_um / 12.0_f64.sqrt(),
        ];
        let max = QUINTIC_TRAVERSE_CUBED * self.limit_max_um
            + UNKNOWN_GAP_SHARE * none.max_um
            + self.encoder_um;
        // Independent causes: variances add up, largest errors add up at worst.
        let squares: f64 = rms.iter().map(|part| part * part).sum();
        Some([squares.sqrt() / none.rms_um, max / none.max_um])
    }

    /// Whether a method leaves no more than is wanted in RMS (0) and in its largest error (1), or
    /// than the limit allows where that is more.
    pub fn within(&self, method: &str) -> Option<[bool; 2]> {
        let (ratios, limit) = (self.ratios(method)?, self.practical()?);
        Some([0, 1].map(|which: usize| ratios[which] <= WANTED[which].max(limit[which])))
    }
}

#[cfg(test)]
mod tests {
    use super::super::result::MethodFigures;
    use super::*;

    #[test]
    fn each_of_the_three_shows_where_it_is_the_largest() {
        let figures = |method: &str, rms_um, max_um| MethodFigures {
            method: method.to_owned(),
            rms_um,
            max_um,
            ..MethodFigures::default()
        };
        let mut cell: CellResult = serde_json::from_str(
            r#"{"cell":"circle5-f300-cw-g20-t30-v0-j8-ideal-steady","duration_s":1,"measured_from_s":0,"samples":1,"reached_mm_min":300,"reversals":[4,4],
                "traverse_ms":1,"limit_max_um":0,"limit_rms_um":0,"methods":[]}"#,
        )
        .unwrap();
        cell.methods = vec![
            figures("none", 5.0, 10.0),
            figures("good", 0.09, 0.9),
            figures("fair", 0.2, 2.0),
        ];
        assert_eq!(cell.practical(), Some([0.01, 0.01]));
        assert_eq!(
            (
                cell.within("good"),
                cell.within("fair"),
                cell.within("nobody")
            ),
            (Some([true; 2]), Some([false; 2]), None)
        );
        // a count of 1 um: 0.29 um RMS
        cell.encoder_um = 1.0;
        let [rms, max] = cell.practical().unwrap();
        assert!(
            (rms - (1.0_f64 / 12.0 / 25.0 + 1e-4).sqrt()).abs() < 1e-12
                && (max - 0.11).abs() < 1e-12,
            "{rms} {max}"
        );
        assert_eq!(cell.within("fair"), Some([true, false]));
        cell.limit_max_um = 1.0;
        assert!(cell.within("fair") == Some([true, true]));
    }
}
