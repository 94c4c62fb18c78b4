//! What a method that learns believed, what it did and what is true, a row every 50 ms; and from
//! the rows why it leaves what it leaves.

use lostmotion_base::units::UM_PER_MM;
use lostmotion_drive::Learning;
use lostmotion_methods::AxisConfig;
use lostmotion_report::number::{fixed, percent};
use lostmotion_sim::ForeseenContour;

/// Part of the squares of what backlash leaves from which on a cause is named. A choice: it is a
/// quarter of the RMS.
const NAMED_SHARE: f64 = 0.06;
/// Part of the true value by which a belief has to be off to be named while the method corrects. A
/// choice.
const OFF_SHARE: f64 = 0.02;
/// Largest error that backlash causes, over the larger gap, from which on a load was thrown. A
/// choice: a gap alone causes no more than itself.
const THROWN: f64 = 1.2;

/// What is true of an axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct AxisTruth {
    /// Name of the drive.
    pub name: String,
    /// Total gap, um.
    pub gap_um: f64,
    /// Inertia of the load at the motor, kg m2.
    pub inertia_kgm2: f64,
    /// Coulomb friction of the load, part of the rated torque.
    pub friction: f64,
    /// Rated torque of the motor, N m.
    pub rated_nm: f64,
    /// Micrometres of a radian of the motor.
    pub um_per_rad: f64,
}

impl AxisTruth {
    pub(super) fn of(name: String, config: &AxisConfig) -> AxisTruth {
        let (load, rated_nm) = (config.reflected_load(), config.motor.rated_torque_nm);
        AxisTruth {
            name,
            gap_um: UM_PER_MM * config.gap_in_unit(),
            inertia_kgm2: load.inertia_kgm2,
            friction: load.coulomb_nm / rated_nm,
            rated_nm,
            um_per_rad: UM_PER_MM / config.transmission.motor_rad_per_unit(),
        }
    }
}

/// What an axis still misses to correct; the first of these that it does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Missing {
    /// The load is not known.
    Load,
    /// The gap is not known, or not well enough.
    Gap,
    /// Friction does not certainly hold the load.
    Friction,
    /// The inertia is not known where it matters.
    Inertia,
    /// The control does not let it correct: the contour is not seen to get better, or another axis is
    /// not ready.
    Leave,
    /// It corrects.
    Nothing,
}

impl Missing {
    /// In words.
    pub const fn text(self) -> &'static str {
        match self {
            Missing::Load => "load not known",
            Missing::Gap => "gap not known",
            Missing::Friction => "friction not certain to hold the load",
            Missing::Inertia => "inertia not certain",
            Missing::Leave => "contour not seen to get better",
            Missing::Nothing => "while correcting",
        }
    }
}

/// An axis at a moment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisMoment {
    /// Total gap that it believes in, its standard deviation, and the gap that it corrects with, um;
    /// 0 while unknown.
    pub gap_um: [f64; 3],
    /// Inertia of the load that it believes in and its standard deviation, over the true one; not a
    /// number while unknown.
    pub inertia: [f64; 2],
    /// Coulomb friction of the load that it believes in and its standard deviation, parts of the rated
    /// torque.
    pub friction: [f64; 2],
    /// What it misses.
    pub missing: Missing,
}

/// A row of the trace: 50 ms up to a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Moment {
    /// Time at its end, s.
    pub time_s: f64,
    /// By drive.
    pub axes: Vec<AxisMoment>,
    /// What the control foresees.
    pub foreseen: Option<ForeseenContour>,
    /// RMS and largest of what backlash causes on cutting moves meanwhile, um; 0 where there are none.
    pub backlash_um: [f64; 2],
    /// Servo ticks of cutting moves.
    pub ticks: u64,
}

/// What is believed of an axis.
pub(super) fn axis_moment(truth: &AxisTruth, now: &Learning) -> AxisMoment {
    let um = |half: f64| 2.0 * half * truth.um_per_rad;
    let learned = now.learned.unwrap_or_default();
    let inertia = [
        learned.load_inertia_kgm2,
        learned.load_inertia_deviation_kgm2,
    ];
    let friction = [learned.coulomb_nm, learned.coulomb_deviation_nm];
    let [inertia, friction] = if now.learned.is_some() {
        [
            inertia.map(|value| value / truth.inertia_kgm2),
            friction.map(|value| value / truth.rated_nm),
        ]
    } else {
        [[f64::NAN; 2]; 2]
    };
    let missing = if now.learned.is_none() {
        Missing::Load
    } else if learned.half_gap_rad <= 0.0 {
        Missing::Gap
    } else if learned.floats {
        Missing::Friction
    } else if !now.foresees {
        Missing::Inertia
    } else if now.allowed <= 0.0 {
        Missing::Leave
    } else if now.used_half_gap_rad <= 0.0 {
        Missing::Gap
    } else {
        Missing::Nothing
    };
    AxisMoment {
        gap_um: [
            um(learned.half_gap_rad),
            um(learned.half_gap_deviation_rad),
            um(now.used_half_gap_rad),
        ],
        inertia,
        friction,
        missing,
    }
}

/// Where the squares of what backlash leaves arose.
#[derive(Clone, Copy, Debug)]
struct Account {
    axis: Option<usize>,
    missing: Missing,
    squares: f64,
    first_s: f64,
    last_s: f64,
}

impl Moment {
    /// The axis that misses most, of those with a gap, and what.
    fn behind(&self, truths: &[AxisTruth]) -> (Option<usize>, Missing) {
        let axes = self.axes.iter().zip(truths).enumerate();
        let axes = axes.filter(|(_, (_, truth))| truth.gap_um > 0.0);
        let (axis, missing) = axes
            .map(|(index, (axis, _))| (index, axis.missing))
            .min_by_key(|(index, missing)| (*missing, *index))
            .unwrap_or((0, Missing::Nothing));
        // What the control decides and what is left by a correction is of all axes.
        let own = missing < Missing::Leave;
        (own.then_some(axis), missing)
    }

    fn squares(&self) -> f64 {
        self.backlash_um[0] * self.backlash_um[0] * self.ticks as f64
    }
}

/// Why a method leaves what it leaves: where the squares of what backlash causes arose, most first;
/// `refused` says of an axis why its readings were refused.
pub(super) fn cause(
    moments: &[Moment],
    truths: &[AxisTruth],
    refused: impl Fn(usize) -> Option<String>,
) -> String {
    let mut accounts: Vec<Account> = Vec::new();
    let mut total = 0.0;
    let mut before_s = 0.0;
    for moment in moments {
        let (axis, missing) = moment.behind(truths);
        let squares = moment.squares();
        total += squares;
        let known = accounts
            .iter_mut()
            .find(|account| (account.axis, account.missing) == (axis, missing));
        let account = match known {
            Some(account) => account,
            None => {
                accounts.push(Account {
                    axis,
                    missing,
                    squares: 0.0,
                    first_s: before_s,
                    last_s: 0.0,
                });
                let Some(account) = accounts.last_mut() else {
                    continue;
                };
                account
            }
        };
        account.squares += squares;
        account.last_s = moment.time_s;
        before_s = moment.time_s;
    }
    accounts.sort_by(|a, b| b.squares.total_cmp(&a.squares));
    let mut causes = Vec::new();
    let most_um = truths.iter().map(|truth| truth.gap_um).fold(0.0, f64::max);
    let largest = moments.iter().map(|moment| moment.backlash_um[1]);
    let largest_um = largest.fold(0.0, f64::max);
    if largest_um > THROWN * most_um {
        causes.push(format!("threw the load, {} um", fixed(largest_um, 0)));
    }
    for account in accounts {
        let share = account.squares / total;
        // Not a number where nothing is left.
        if share.is_nan() || share < NAMED_SHARE {
            continue;
        }
        let name = account.axis.and_then(|axis| truths.get(axis));
        let of = name.map_or(String::new(), |truth| format!("{} ", truth.name));
        let more = match account.missing {
            Missing::Gap => account.axis.and_then(&refused),
            Missing::Nothing => off(moments, truths),
            _ => None,
        };
        causes.push(format!(
            "{of}{}, {} to {} s ({}){}",
            account.missing.text(),
            fixed(account.first_s, 1),
            fixed(account.last_s, 1),
            percent(share),
            more.map_or(String::new(), |more| format!(": {more}")),
        ));
    }
    causes.join("; ")
}

/// What was believed wrongly while the method corrected, weighed by the squares that were left.
fn off(moments: &[Moment], truths: &[AxisTruth]) -> Option<String> {
    let mut parts = Vec::new();
    for (index, truth) in truths.iter().enumerate().filter(|(_, t)| t.gap_um > 0.0) {
        let (mut weight, mut sums) = (0.0, [0.0; 3]);
        for moment in moments {
            let Some(axis) = moment.axes.get(index) else {
                continue;
            };
            if moment.behind(truths).1 != Missing::Nothing {
                continue;
            }
            let squares = moment.squares();
            weight += squares;
            let ratios = [
                axis.gap_um[2] / truth.gap_um,
                axis.inertia[0],
                axis.friction[0] / truth.friction,
            ];
            for (sum, ratio) in sums.iter_mut().zip(ratios) {
                *sum += squares * (ratio - 1.0);
            }
        }
        for (what, sum) in ["gap", "inertia", "friction"].into_iter().zip(sums) {
            let off = sum / weight;
            if off.is_finite() && off.abs() > OFF_SHARE {
                let sign = if off > 0.0 { "+" } else { "" };
                parts.push(format!("{} {what} {sign}{}", truth.name, percent(off)));
            }
        }
    }
    (!parts.is_empty()).then(|| parts.join(", "))
}
