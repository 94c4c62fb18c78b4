//! A measured ballbar's sheet beside that of a simulated machine, as data; its JSON form is versioned
//! like that of [`crate::results`].

use lostmotion_contour::ballbar::{BallbarSheet, BallbarTrace, parts_for};
use serde::{Deserialize, Serialize};

/// Version of the JSON form of [`BallbarAnswer`].
pub const BALLBAR_SCHEMA: u32 = 1;

/// Answer of one `ballbar`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
#[non_exhaustive]
pub struct BallbarAnswer {
    /// Version of this form, [`BALLBAR_SCHEMA`].
    pub schema: u32,
    /// Names of the sheets.
    pub sheets: Vec<String>,
    /// What was measured.
    pub measured: BallbarSheet,
    /// Name of the machine that was simulated.
    pub machine: Option<String>,
    /// Feed of its circle, mm/min.
    pub feed_mm_min: Option<f64>,
    /// What it makes of the circle.
    pub simulated: Option<BallbarSheet>,
    /// How far the two paths are apart, um RMS, centre and mean radius of each aside.
    pub apart_rms_um: Option<f64>,
}

impl BallbarAnswer {
    /// A sheet that was measured.
    pub fn new(sheets: Vec<String>, measured: BallbarSheet) -> BallbarAnswer {
        BallbarAnswer {
            schema: BALLBAR_SCHEMA,
            sheets,
            measured,
            ..BallbarAnswer::default()
        }
    }

    /// With that of a machine beside it.
    #[must_use]
    pub fn beside(
        mut self,
        (machine, feed_mm_min): (&str, f64),
        simulated: BallbarSheet,
        (measured_traces, simulated_traces): (&[BallbarTrace], &[BallbarTrace]),
    ) -> BallbarAnswer {
        let count = parts_for(measured_traces).min(parts_for(simulated_traces));
        // A bar is set to zero by hand: where the centre and how long the bar is, is the sheet's.
        let placed = |sheet: &BallbarSheet, trace: &BallbarTrace| -> Vec<f64> {
            let shift = [0, 1].map(|axis| {
                let told = sheet.center_um.get(axis).copied().flatten();
                told.map_or(0.0, |told| told.value)
            });
            let parts = trace.parts_um(count);
            let placed: Vec<f64> = parts
                .iter()
                .enumerate()
                .map(|(part, um)| {
                    let angle = (part as f64 + 0.5) / count as f64 * std::f64::consts::TAU;
                    let (sin, cos) = lostmotion_base::math::sin_cos(angle);
                    um - shift[0] * cos - shift[1] * sin
                })
                .collect();
            let finite: Vec<f64> = placed.iter().copied().filter(|um| um.is_finite()).collect();
            let mean = finite.iter().sum::<f64>() / finite.len().max(1) as f64;
            placed.into_iter().map(|um| um - mean).collect()
        };
        let (mut square, mut compared) = (0.0, 0.0);
        for one in measured_traces {
            let other = simulated_traces
                .iter()
                .find(|other| other.counterclockwise == one.counterclockwise);
            let Some(other) = other else {
                continue;
            };
            let pairs = placed(&self.measured, one)
                .into_iter()
                .zip(placed(&simulated, other));
            for off in pairs.map(|(a, b)| a - b).filter(|off| off.is_finite()) {
                square += off * off;
                compared += 1.0;
            }
        }
        self.apart_rms_um = (compared > 0.0).then(|| f64::sqrt(square / compared));
        self.machine = Some(machine.to_owned());
        self.feed_mm_min = Some(feed_mm_min);
        self.simulated = Some(simulated);
        self
    }
}
