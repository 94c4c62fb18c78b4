//! What a method that learns knew, and when: the time line of a run.

use super::moment::{self, AxisMoment, AxisTruth, Missing, Moment, axis_moment};
use lostmotion_drive::{Learning, ReadingVerdict};
use lostmotion_methods::AxisConfig;
use lostmotion_report::number::fixed;
use lostmotion_sim::ForeseenContour;
use std::collections::BTreeMap;

/// Part of a value by which a used gap has to change to be told again. A choice.
const TOLD_CHANGE: f64 = 0.02;

/// Something that changed in what a method knows of an axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Told {
    /// Time since the start of the program, s; of the end of the chunk in which it happened.
    pub time_s: f64,
    /// Name of the drive.
    pub drive: String,
    /// What, in words.
    pub what: String,
}

/// What was told of an axis so far.
#[derive(Clone, Debug, Default)]
struct AxisKnowledge {
    is_load_told: bool,
    told_um: f64,
    missing: Option<Missing>,
    reading: u32,
    verdicts: BTreeMap<&'static str, u32>,
    counted: u32,
}

/// The time line of a method in a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Knowledge {
    truths: Vec<AxisTruth>,
    axes: Vec<AxisKnowledge>,
    corrects: bool,
    pub(super) told: Vec<Told>,
    pub(super) moments: Vec<Moment>,
}

impl Knowledge {
    /// Of the drives of a machine that cut: those with a gap.
    pub(super) fn new<'a>(drives: impl Iterator<Item = (String, &'a AxisConfig)>) -> Knowledge {
        let truths: Vec<AxisTruth> = drives
            .map(|(name, config)| AxisTruth::of(name, config))
            .collect();
        Knowledge {
            axes: vec![AxisKnowledge::default(); truths.len()],
            truths,
            ..Knowledge::default()
        }
    }

    /// Takes what all drives know at a time, s.
    pub(super) fn push(&mut self, time_s: f64, drives: &[Option<Learning>]) {
        let mut moments = Vec::new();
        let axes = self.axes.iter_mut().zip(&self.truths);
        for ((axis, truth), learning) in axes.zip(drives) {
            let Some(learning) = learning else { continue };
            let moment = axis_moment(truth, learning);
            let told = axis.push(truth, learning, &moment);
            self.told.extend(told.into_iter().map(|what| Told {
                time_s,
                drive: truth.name.clone(),
                what,
            }));
            moments.push(moment);
        }
        // A method that learns does so in all drives.
        if moments.len() == self.truths.len() && !moments.is_empty() {
            self.moments.push(Moment {
                time_s,
                axes: moments,
                foreseen: None,
                backlash_um: [0.0; 2],
                ticks: 0,
            });
        }
    }

    /// Takes what the control foresees, behind [`Knowledge::push`].
    pub(super) fn foresee(&mut self, time_s: f64, contour: Option<&ForeseenContour>) {
        let Some((contour, moment)) = contour.zip(self.moments.last_mut()) else {
            return;
        };
        moment.foreseen = Some(*contour);
        if contour.corrects != std::mem::replace(&mut self.corrects, contour.corrects) {
            let [[without, with], [highest, high]] =
                [contour.rms_um, contour.max_um].map(|pair| pair.map(|um| fixed(um, 2)));
            let does = if contour.corrects {
                "lets the drives correct"
            } else {
                "takes the correction back"
            };
            self.told.push(Told {
                time_s,
                drive: "control".to_owned(),
                what: if contour.measured_s > 0.0 {
                    format!(
                        "{does}: foresees {with} um RMS for {without}, {high} um max for {highest}"
                    )
                } else if self.moments.len() > 1 {
                    format!("{does}, as rehearsed")
                } else {
                    format!("{does} from the start")
                },
            });
        }
    }

    /// Takes what backlash causes from one moment to the next: servo ticks, the sum of the squares and
    /// the largest magnitude, um.
    pub(super) fn left(&mut self, intervals: impl Iterator<Item = (u64, f64, f64)>) {
        for (moment, (ticks, squares, max)) in self.moments.iter_mut().zip(intervals) {
            moment.ticks = ticks;
            moment.backlash_um = [(squares / (ticks as f64).max(1.0)).sqrt(), max];
        }
    }

    /// What is true of its axes.
    pub(super) fn truths(&self) -> &[AxisTruth] {
        &self.truths
    }

    /// Why the method leaves what it leaves; empty for one that does not learn.
    pub(super) fn cause(&self) -> String {
        moment::cause(&self.moments, &self.truths, |axis| {
            self.axes.get(axis)?.refused()
        })
    }
}

impl AxisKnowledge {
    /// Takes what is known now; gives what has changed.
    fn push(&mut self, truth: &AxisTruth, now: &Learning, moment: &AxisMoment) -> Vec<String> {
        let mut told = Vec::new();
        if now.learned.is_some() && !std::mem::replace(&mut self.is_load_told, true) {
            told.push(format!(
                "load known: inertia {} +- {} of the true one, friction {} +- {} of the rated torque, {} true",
                fixed(moment.inertia[0], 2),
                fixed(moment.inertia[1], 2),
                fixed(moment.friction[0], 4),
                fixed(moment.friction[1], 4),
                fixed(truth.friction, 4),
            ));
        }
        if let Some(reading) = now.reading.filter(|reading| reading.number != self.reading) {
            // Of several within a chunk the last one is told.
            self.reading = reading.number;
            *self.verdicts.entry(reading.verdict.text()).or_default() += 1;
            self.counted += u32::from(reading.verdict == ReadingVerdict::Counts);
            let [gap, deviation] = [reading.half_gap_rad, reading.deviation_rad]
                .map(|half| fixed(2.0 * half * truth.um_per_rad, 2));
            told.push(format!(
                "reading {}: {gap} um +- {deviation}: {}",
                reading.number,
                reading.verdict.text()
            ));
        }
        // What it misses is told with what it believes: friction and inertia decide about it.
        let before = self.missing.replace(moment.missing);
        let is_told = truth.gap_um > 0.0 && moment.missing != Missing::Load;
        if is_told && before != Some(moment.missing) {
            told.push(format!(
                "{}: gap {} of {} um, inertia {} +- {}, friction {} +- {} of {}",
                moment.missing.text(),
                fixed(moment.gap_um[0], 2),
                fixed(truth.gap_um, 2),
                fixed(moment.inertia[0], 2),
                fixed(moment.inertia[1], 2),
                fixed(moment.friction[0], 4),
                fixed(moment.friction[1], 4),
                fixed(truth.friction, 4),
            ));
        }
        let used_um = moment.gap_um[2];
        if (used_um - self.told_um).abs() > TOLD_CHANGE * used_um.max(self.told_um) {
            self.told_um = used_um;
            told.push(if used_um > 0.0 {
                format!(
                    "uses {} um of {}",
                    fixed(used_um, 2),
                    fixed(truth.gap_um, 2)
                )
            } else {
                "uses no gap".to_owned()
            });
        }
        told
    }

    /// What became of its readings, where few count.
    fn refused(&self) -> Option<String> {
        if self.reading == 0 {
            return Some("no reading".to_owned());
        }
        let all = self.reading;
        if self.counted > 0 {
            return Some(format!("{} of {all} readings count", self.counted));
        }
        let (why, count) = self.verdicts.iter().max_by_key(|(_, count)| **count)?;
        Some(format!("{count} of {all} readings refused, {why}"))
    }
}
