//! What a method that learns knew, and when: the time line of a run, and the cause of what it leaves.

use lostmotion_base::units::UM_PER_MM;
use lostmotion_drive::{Learning, ReadingVerdict};
use lostmotion_methods::AxisConfig;
use lostmotion_report::number::{fixed, percent};
use std::collections::BTreeMap;

/// Part of a value by which a used gap has to change to be told again. A choice.
const TOLD_CHANGE: f64 = 0.02;
/// Part of the time after which a gap that is used at last was learned late. A choice.
const LATE_SHARE: f64 = 0.2;
/// Part of the true gap by which a used one is wrong. A choice: it leaves as much of the error.
const WRONG_SHARE: f64 = 0.05;
/// Part of the time without a use of a known gap from which on that is the cause. A choice.
const UNUSED_SHARE: f64 = 0.2;
/// Largest error that backlash causes, over the larger gap, from which on a load was thrown. A
/// choice: a gap alone causes no more than itself.
const THROWN: f64 = 1.2;

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

/// What a method knew of an axis over a run.
#[derive(Clone, Debug, Default)]
struct AxisKnowledge {
    name: String,
    /// True total gap, um, and um of a radian of the motor.
    gap_um: f64,
    um_per_rad: f64,
    load_known_s: Option<f64>,
    first_used_s: Option<f64>,
    used_um: f64,
    told_um: f64,
    floats: bool,
    share: f64,
    reading: u32,
    verdicts: BTreeMap<&'static str, u32>,
    counted: u32,
    /// Time in which the gap was known and not used, s, and that of it in which the load floats.
    unused_s: f64,
    floating_s: f64,
    faded_s: f64,
    last_s: f64,
}

/// The time line of a method in a run.
#[derive(Clone, Debug, Default)]
pub(super) struct Knowledge {
    axes: Vec<AxisKnowledge>,
    pub(super) told: Vec<Told>,
}

impl Knowledge {
    /// Of the drives of a machine that cut: those with a gap.
    pub(super) fn new<'a>(drives: impl Iterator<Item = (String, &'a AxisConfig)>) -> Knowledge {
        let axis = |(name, config): (String, &AxisConfig)| AxisKnowledge {
            name,
            gap_um: UM_PER_MM * config.gap_in_unit(),
            um_per_rad: UM_PER_MM / config.transmission.motor_rad_per_unit(),
            share: 1.0,
            ..AxisKnowledge::default()
        };
        Knowledge {
            axes: drives.map(axis).collect(),
            told: Vec::new(),
        }
    }

    /// Takes what all drives know at a time, s.
    pub(super) fn push(&mut self, time_s: f64, drives: &[Option<Learning>]) {
        for (axis, learning) in self.axes.iter_mut().zip(drives) {
            if let Some(learning) = learning {
                let told = axis.push(time_s, learning);
                self.told.extend(told.into_iter().map(|what| Told {
                    time_s,
                    drive: axis.name.clone(),
                    what,
                }));
            }
        }
    }

    /// Why the method leaves what it leaves: of the axes with a gap, the first cause of each;
    /// `largest_um` is the largest error that backlash causes, `duration_s` the length of the
    /// motion.
    pub(super) fn cause(&self, largest_um: f64, duration_s: f64) -> String {
        let most_um = self.axes.iter().map(|axis| axis.gap_um).fold(0.0, f64::max);
        let mut causes = Vec::new();
        if largest_um > THROWN * most_um {
            causes.push(format!("threw the load, {} um", fixed(largest_um, 0)));
        }
        let of_axes = self.axes.iter().filter(|axis| axis.gap_um > 0.0);
        causes.extend(
            of_axes.filter_map(|axis| Some(format!("{} {}", axis.name, axis.cause(duration_s)?))),
        );
        causes.join("; ")
    }
}

impl AxisKnowledge {
    /// Takes what is known now; gives what has changed.
    fn push(&mut self, time_s: f64, now: &Learning) -> Vec<String> {
        let mut told = Vec::new();
        let span = time_s - std::mem::replace(&mut self.last_s, time_s);
        if let Some(learned) = now.learned.filter(|_| self.load_known_s.is_none()) {
            self.load_known_s = Some(time_s);
            told.push(format!(
                "load known: inertia {:.3e} kg m2, friction {:.3e} N m",
                learned.load_inertia_kgm2, learned.coulomb_nm
            ));
        }
        if let Some(reading) = now.reading.filter(|reading| reading.number != self.reading) {
            // Of several within a chunk the last one is told.
            self.reading = reading.number;
            *self.verdicts.entry(reading.verdict.text()).or_default() += 1;
            self.counted += u32::from(reading.verdict == ReadingVerdict::Counts);
            let [gap, deviation] = [reading.half_gap_rad, reading.deviation_rad]
                .map(|half| fixed(2.0 * half * self.um_per_rad, 2));
            told.push(format!(
                "reading {}: {gap} um +- {deviation}: {}",
                reading.number,
                reading.verdict.text()
            ));
        }
        let is_known = now
            .learned
            .is_some_and(|learned| learned.half_gap_rad > 0.0);
        let floats = now.learned.is_some_and(|learned| learned.floats);
        let used_um = 2.0 * now.used_half_gap_rad * now.share * self.um_per_rad;
        if is_known && used_um == 0.0 {
            self.unused_s += span;
            self.floating_s += if floats { span } else { 0.0 };
            self.faded_s += if now.share < 1.0 { span } else { 0.0 };
        }
        if is_known && floats != self.floats {
            self.floats = floats;
            told.push(if floats { "floats" } else { "is on its flanks" }.to_owned());
        }
        if (now.share - self.share).abs() > TOLD_CHANGE {
            told.push(format!(
                "{} to {}",
                if now.share < self.share {
                    "fades"
                } else {
                    "comes back"
                },
                percent(now.share)
            ));
            self.share = now.share;
        }
        if used_um > 0.0 {
            self.first_used_s = self.first_used_s.or(Some(time_s));
            self.used_um = used_um;
        }
        if (used_um - self.told_um).abs() > TOLD_CHANGE * used_um.max(self.told_um) {
            self.told_um = used_um;
            told.push(if used_um > 0.0 {
                format!("uses {} um of {}", fixed(used_um, 2), fixed(self.gap_um, 2))
            } else {
                "uses no gap".to_owned()
            });
        }
        told
    }

    fn cause(&self, duration_s: f64) -> Option<String> {
        let Some(first_s) = self.first_used_s else {
            let refused = self.verdicts.iter().max_by_key(|(_, count)| **count);
            return Some(match (self.load_known_s, refused) {
                (None, _) => "never learned: the load is not known".to_owned(),
                _ if self.floating_s > 0.5 * self.unused_s && self.unused_s > 0.0 => {
                    format!(
                        "known and not used: floats for {} s",
                        fixed(self.floating_s, 0)
                    )
                }
                (_, None) => "never learned: no reading".to_owned(),
                _ if self.counted > 0 => {
                    format!(
                        "never learned: {} of {} readings count, too few agree",
                        self.counted, self.reading
                    )
                }
                (_, Some((why, count))) => {
                    format!(
                        "never learned: {count} of {} readings refused, {why}",
                        self.reading
                    )
                }
            });
        };
        let off = self.used_um / self.gap_um - 1.0;
        if off.abs() > WRONG_SHARE {
            return Some(format!(
                "learned wrong by {}{}",
                if off > 0.0 { "+" } else { "" },
                percent(off)
            ));
        }
        if first_s > LATE_SHARE * duration_s {
            return Some(format!("learned late, after {} s", fixed(first_s, 0)));
        }
        if self.faded_s > UNUSED_SHARE * duration_s {
            return Some(format!("faded out for {} s", fixed(self.faded_s, 0)));
        }
        if self.unused_s > UNUSED_SHARE * duration_s {
            return Some(format!(
                "known and not used for {} s{}",
                fixed(self.unused_s, 0),
                if self.floating_s > 0.5 * self.unused_s {
                    ": floats"
                } else {
                    ""
                }
            ));
        }
        None
    }
}
