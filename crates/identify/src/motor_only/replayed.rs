//! The fit by replaying the load: what is searched, what is refused, what is told.

use crate::{
    contact::{MEDIAN_OF_NORMAL, MIN_TORQUE_SHARE, NOISE_FACTOR, noise},
    error::{NotExcited, SolverStatus},
    estimate::RESOLUTION_SHARE,
    huber::{HUBER_TUNING, Regression},
    log::MotorLog,
    result::{BacklashFit, FittedLoad, SolverReport, ToldCompliance},
    settings::FitSettings,
    spread::{self, Spread},
    window::{self, WindowSample},
};
use lostmotion_base::math::{self, quantile};

use super::interval::{BLOCK_S, Profile};
use super::replay::{self, Replay, load_of, spline_loss, spline_slopes};
use super::search::{Answer, Found, Search};

/// Longest step of the integration, s. A choice: a tenth of a period of 1 kHz logs; fast shafts get
/// shorter ones.
const LONGEST_STEP_S: f64 = 100e-6;
/// Share of the shaft's vibration that may be lost between the samples. A choice: reached at 0.31
/// of the sampling rate; beyond it the loss grows with the fourth power of the frequency.
const MAX_SPLINE_LOSS: f64 = 0.05;
/// Half-width of the long windows, s, and of the short ones. A choice: the long ones are longer
/// than impacts come early or late with a gap that is off by a step of the grid.
const HALF_WINDOWS_S: [f64; 2] = [10e-3, 2e-3];
/// Share of the largest speed below which the direction of sliding is not sure. A choice.
const SLOW_SHARE: f64 = 0.02;
/// Fewest windows in which the axis moves. A choice: half a second of long windows.
const MIN_MOVING: usize = 50;
/// Least residual at which the loss turns linear, in parts of the largest torque. A choice: impacts
/// between two samples leave residuals in clean logs that are no outliers.
const MIN_DELTA_SHARE: f64 = 2e-3;
/// Windows over which residuals are averaged, to see what is left beside noise: 20 ms.
const MISFIT_WINDOWS: usize = 10;
/// Torque left over beside the noise, in parts of the usual contact torque, beyond which the load
/// is not as modelled. Tuned on logs with a known gap: all residuals and those averaged over
/// [`MISFIT_WINDOWS`]. Friction as modelled left up to 2.7 % and 0.7 %, another friction
/// at least 2.3 % and 1.3 %.
const MAX_MISFIT_SHARE: f64 = 0.035;
const MAX_SLOW_MISFIT_SHARE: f64 = 0.01;
/// Standard errors by which the noise of these averages may exceed its mean. A choice: one of 40.
const CHANCE_ERRORS: f64 = 2.0;
/// How well the noise of the current is known. A choice: 4 %, some three standard errors.
const NOISE_DOUBT: f64 = 1.04;
/// Error of the model as a share of the wind-up. Tuned as that of the fit over crossings.
const MODEL_ERROR_SHARE: f64 = 3e-3;
/// Error of the motor's motion between two samples, which is interpolated, as a share of the gap.
/// Tuned on logs without noise at 1 kHz: the gap came out up to 0.4 %, in the median 0.2 %, too
/// large.
const BETWEEN_SAMPLES_SHARE: f64 = 3e-3;
/// Error of the model as a share of the compliance itself.
const COMPLIANCE_ERROR_SHARE: f64 = 2e-2;
/// Ratio of the difference of two costs to its standard error below which a rival minimum is not
/// rejected. A choice: one rival of a hundred is taken for worse by chance.
const SURE_RATIO: f64 = 2.3;

/// The fit; `None` if the log has too little of motion for a replay.
pub(super) fn replayed(
    log: &MotorLog,
    settings: &FitSettings,
) -> Option<Result<BacklashFit, NotExcited>> {
    let averaged = AveragedLog::new(log, settings)?;
    let search = averaged.search();
    let answer = search.run()?;
    let searched = Searched::new(&averaged, &search, &answer)?;
    // The profile may end in a better minimum than the search did.
    let profile = search.profile(answer.found.clone(), &answer.used, &searched.numbers);
    match searched.judged(profile) {
        Ok((profile, loss)) => searched.fit(&profile, loss).map(Ok),
        Err(reason) => Some(Err(reason)),
    }
}

/// A log averaged over long and over short windows, with what is known before the search.
struct AveragedLog<'a> {
    log: &'a MotorLog,
    inertia_kgm2: f64,
    /// Half a window, samples: of the long ones, and of the short ones.
    halves: [usize; 2],
    windows: [Vec<WindowSample>; 2],
    /// Slopes of the motor's spline at the samples.
    slopes: Vec<f64>,
    /// The load as it slides.
    load: FittedLoad,
    /// Largest torque, N m.
    largest_nm: f64,
    /// Noise of the motor's torque, N m: in a sample, and in a short window.
    current_noise_nm: f64,
    noise_nm: f64,
}

impl<'a> AveragedLog<'a> {
    /// `None` where the load hardly moves.
    fn new(log: &'a MotorLog, settings: &FitSettings) -> Option<AveragedLog<'a>> {
        let (period_s, inertia) = (log.period_s(), settings.motor_inertia_kgm2?);
        let rows = log.as_backlash_log();
        let halves = HALF_WINDOWS_S.map(|width| (width / period_s).round().max(1.0) as usize);
        let windows = halves.map(|half| window::averages(rows, settings, inertia, half));
        let (load, largest_nm) = sliding(&windows[0])?;
        let current_noise_nm =
            settings.torque_constant_nm_per_a * noise(rows.current().iter().copied());
        Some(AveragedLog {
            log,
            inertia_kgm2: inertia,
            halves,
            windows,
            slopes: spline_slopes(rows.motor()),
            load,
            largest_nm,
            current_noise_nm,
            noise_nm: current_noise_nm * triangle_norm(halves[1]),
        })
    }

    /// The search over replays with long and with short windows.
    fn search(&self) -> Search<'_> {
        let replay = |n: usize| {
            Replay::new(
                (self.log.as_backlash_log().motor(), &self.slopes),
                self.log.period_s(),
                (&self.windows[n], self.halves[n]),
                self.inertia_kgm2,
                self.largest_nm,
                LONGEST_STEP_S,
            )
        };
        Search {
            long: replay(0),
            short: replay(1),
            load: self.load,
            motor_inertia_kgm2: self.inertia_kgm2,
            delta: (HUBER_TUNING * self.noise_nm).max(MIN_DELTA_SHARE * self.largest_nm),
        }
    }
}

/// What a search found, and how its windows go together.
struct Searched<'a> {
    averaged: &'a AveragedLog<'a>,
    search: &'a Search<'a>,
    answer: &'a Answer,
    /// The block of each window that counts.
    numbers: Vec<usize>,
    /// Root mean square of the torque over these windows, N m.
    torque_nm: f64,
}

impl<'a> Searched<'a> {
    /// `None` where no window counts.
    fn new(
        averaged: &'a AveragedLog<'a>,
        search: &'a Search<'a>,
        answer: &'a Answer,
    ) -> Option<Searched<'a>> {
        let spacing_s = averaged.halves[1] as f64 * averaged.log.period_s();
        let per_block = (BLOCK_S / spacing_s).ceil() as usize;
        let first = answer.used.first()? / per_block;
        let numbers: Vec<usize> = answer.used.iter().map(|n| n / per_block - first).collect();
        let mut searched = Searched {
            averaged,
            search,
            answer,
            numbers,
            torque_nm: 0.0,
        };
        let squares = searched.torques().map(|torque| torque * torque);
        searched.torque_nm = (squares.sum::<f64>() / answer.used.len() as f64).sqrt();
        Some(searched)
    }

    /// Torques of the windows that count, N m.
    fn torques(&self) -> impl Iterator<Item = f64> {
        let windows = &self.averaged.windows[1];
        self.answer.used.iter().map(|&n| windows[n].torque_nm)
    }

    /// A profile that is the log's only answer, and the share of the shaft's vibration that is lost between its
    /// samples.
    ///
    /// # Errors
    /// Why the log is refused: a shaft that is too fast, a load that is not as modelled, several gaps.
    fn judged(&self, profile: Option<Profile>) -> Result<(Profile, f64), NotExcited> {
        let deepest = profile.as_ref();
        let deepest = deepest.map_or(&self.answer.found, |best| &best.found);
        let loss = self.vibration_lost(deepest)?;
        self.check_left_over(deepest)?;
        Ok((self.check_rivals(profile)?, loss))
    }

    /// The share of the shaft's vibration that is lost: between its samples the motor's motion is not known.
    fn vibration_lost(&self, deepest: &Found) -> Result<f64, NotExcited> {
        let period_s = self.averaged.log.period_s();
        let stiffness = 1.0 / deepest.x[replay::COMPLIANCE];
        let inverse = 1.0 / self.averaged.inertia_kgm2 + 1.0 / deepest.x[replay::INERTIA];
        let frequency_hz = (stiffness * inverse).sqrt() / std::f64::consts::TAU;
        let loss = spline_loss(frequency_hz * period_s);
        if loss > MAX_SPLINE_LOSS {
            return Err(NotExcited::ShaftTooFast {
                frequency_hz,
                period_ms: 1e3 * period_s,
            });
        }
        Ok(loss)
    }

    /// Refuses a load that is not as modelled: what is left over has to be noise, all in all and on an average
    /// over some windows.
    fn check_left_over(&self, deepest: &Found) -> Result<(), NotExcited> {
        let (noise_nm, torque_nm) = (self.averaged.noise_nm, self.torque_nm);
        let left_nm = root_mean_square(&deepest.residuals);
        let most_nm = math::hypot(NOISE_DOUBT * noise_nm, MAX_MISFIT_SHARE * torque_nm);
        let slow_nm = slow_misfit(
            deepest,
            &self.answer.used,
            self.averaged.current_noise_nm / (self.averaged.halves[1] as f64).sqrt(),
        );
        if left_nm > most_nm || slow_nm > MAX_SLOW_MISFIT_SHARE * torque_nm {
            return Err(NotExcited::LoadNotAsModelled { left_nm, noise_nm });
        }
        Ok(())
    }

    /// Refuses a log with several answers: a rival that the log does not reject is one, too.
    fn check_rivals(&self, profile: Option<Profile>) -> Result<Profile, NotExcited> {
        let several = |found: &Found, rival: &Found| NotExcited::SeveralGaps {
            first_rad: found.x[replay::HALF_GAP],
            second_rad: rival.x[replay::HALF_GAP],
        };
        let Answer { found, rivals, .. } = self.answer;
        let Some(profile) = profile else {
            return Err(several(found, rivals.first().unwrap_or(found)));
        };
        let [low, high] = profile.interval_rad;
        for rival in rivals {
            let beside = rival.x[replay::HALF_GAP] < low || high < rival.x[replay::HALF_GAP];
            if beside && self.search.ratio(&profile.found, rival, &self.numbers) < SURE_RATIO {
                return Err(several(&profile.found, rival));
            }
        }
        Ok(profile)
    }

    /// Spreads of half gap, compliance, damping time and lateness; `None` where the windows left after some
    /// block is taken out do not tell them.
    fn spreads(&self, found: &Found) -> Option<[Spread; 4]> {
        let about = self.search.short.about(&found.x, &self.answer.used).problem;
        let blocks = spread::blocks(&self.numbers);
        let spread = |which| spread::spread(&about, &found.x, self.search.delta, &blocks, which);
        Some([
            spread(replay::HALF_GAP)?,
            spread(replay::COMPLIANCE)?,
            spread(replay::DAMPING_TIME)?,
            spread(replay::LATENESS)?,
        ])
    }

    /// What the gap is told by less beside the scatter, rad: resolution, errors of the model, and `loss`, the
    /// share of the vibration that is lost.
    fn allowance_rad(&self, found: &Found, loss: f64) -> f64 {
        RESOLUTION_SHARE * self.averaged.log.resolution_rad()
            + (MODEL_ERROR_SHARE + loss) * found.x[replay::COMPLIANCE] * self.torque_nm
            + BETWEEN_SAMPLES_SHARE * found.x[replay::HALF_GAP]
    }

    /// The fit at the minimum of a profile; `None` where its windows do not tell the spreads.
    fn fit(&self, profile: &Profile, loss: f64) -> Option<BacklashFit> {
        let (averaged, found) = (self.averaged, &profile.found);
        let [gap_spread, compliance_spread, damping_spread, late_spread] = self.spreads(found)?;
        let (half_gap, compliance) = (found.x[replay::HALF_GAP], found.x[replay::COMPLIANCE]);
        let allowance = self.allowance_rad(found, loss);
        let [low, high] = profile.interval_rad;
        let interval = [(low - allowance).max(0.0), high + allowance];
        let reason = (interval[0] <= 0.0).then_some(NotExcited::GapBelowNoise {
            half_gap_rad: half_gap,
            upper_rad: interval[1],
        });
        let told = ToldCompliance::new(
            compliance,
            compliance_spread.half_width + COMPLIANCE_ERROR_SHARE * compliance,
        );
        let about_zero = |value: f64, half_width: f64| {
            [value - half_width, value + half_width].map(|end| end.max(0.0))
        };
        let (damping, late) = (found.x[replay::DAMPING_TIME], found.x[replay::LATENESS]);
        // Beyond it the flank is certain.
        let threshold_nm =
            (MIN_TORQUE_SHARE * averaged.largest_nm).max(NOISE_FACTOR * averaged.noise_nm);
        let positive = self.torques().filter(|torque| *torque > 0.0).count();
        let sizes: Vec<f64> = found.residuals.iter().map(|r| r.abs()).collect();
        Some(BacklashFit {
            half_gap_rad: half_gap,
            half_gap_interval_rad: interval,
            half_gap_error_rad: profile.standard_error_rad,
            half_gap_allowance_rad: allowance,
            half_gap_lateness_rad: 0.0,
            compliance_rad_per_nm: compliance,
            compliance_error_rad_per_nm: compliance_spread.standard_error,
            compliance_interval_rad_per_nm: told.compliance_interval_rad_per_nm,
            stiffness_nm_per_rad: told.stiffness_nm_per_rad,
            stiffness_interval_nm_per_rad: told.stiffness_interval_nm_per_rad,
            offset_rad: 0.0,
            damping_time_s: damping,
            damping_time_interval_s: about_zero(damping, damping_spread.half_width),
            current_late_s: late.max(0.0),
            current_late_interval_s: about_zero(late, late_spread.half_width),
            motor_inertia_kgm2: averaged.inertia_kgm2,
            residual_rms_rad: compliance * root_mean_square(&found.residuals),
            residual_scale_rad: compliance * quantile(sizes.clone(), 0.5) / MEDIAN_OF_NORMAL,
            huber_delta_rad: compliance * self.search.delta,
            outliers: sizes
                .iter()
                .filter(|size| **size > self.search.delta)
                .count(),
            torque_threshold_nm: threshold_nm,
            samples_logged: averaged.log.len(),
            window_samples: averaged.halves[1],
            samples_used: sizes.len(),
            samples_positive: positive,
            samples_negative: sizes.len() - positive,
            traversals: changes(self.torques(), threshold_nm),
            blocks: profile.blocks,
            // The scatter counts the samples, and the profile how much they tell.
            effective_samples: gap_spread.effective_samples
                * (gap_spread.standard_error * gap_spread.standard_error)
                / (profile.standard_error_rad * profile.standard_error_rad),
            excited: reason.is_none(),
            reason,
            load: Some(load_of(&found.x)),
            load_off: None,
            otherwise: Vec::new(),
            solver: solver_report(found),
        })
    }
}

/// How the descent to a minimum went.
fn solver_report(found: &Found) -> SolverReport {
    SolverReport {
        name: "Levenberg-Marquardt".to_owned(),
        status: if found.settled {
            SolverStatus::Solved
        } else {
            SolverStatus::IterationLimit
        },
        iterations: found.rounds,
        solves: 1,
        explicit_samples: found.residuals.len(),
        optimality: 0.0,
    }
}

/// The load as the long windows show it in which the axis moves, and the largest of their torques;
/// `None` where it hardly moves.
fn sliding(windows: &[WindowSample]) -> Option<(FittedLoad, f64)> {
    let fastest = windows
        .iter()
        .map(|w| w.velocity_rad_s.abs())
        .fold(0.0, f64::max);
    let moving = || {
        windows
            .iter()
            .filter(|w| w.one_way && w.whole && w.velocity_rad_s.abs() > SLOW_SHARE * fastest)
    };
    if moving().count() < MIN_MOVING {
        return None;
    }
    // Flanks do not matter here: while the axis moves, so does the load, save in the gap.
    let [inertia_kgm2, viscous_nm_s_per_rad, coulomb_nm, constant_nm] = Regression::<4> {
        rows: moving()
            .map(|w| {
                [
                    w.acceleration_rad_s2,
                    w.velocity_rad_s,
                    w.velocity_rad_s.signum(),
                    1.0,
                ]
            })
            .collect(),
        targets: moving().map(|w| w.torque_nm).collect(),
        nonnegative: [true, true, true, false],
    }
    .least_squares();
    let load = FittedLoad {
        inertia_kgm2,
        viscous_nm_s_per_rad,
        coulomb_nm,
        constant_nm,
    };
    let largest_nm = quantile(windows.iter().map(|w| w.torque_nm.abs()).collect(), 0.999);
    (inertia_kgm2 > 0.0 && largest_nm > 0.0).then_some((load, largest_nm))
}

/// Deviation of a window's mean over that of a sample.
fn triangle_norm(half: usize) -> f64 {
    let area = (half * half) as f64;
    (0..=2 * half)
        .map(|k| (half - half.abs_diff(k)) as f64 / area)
        .map(|weight| weight * weight)
        .sum::<f64>()
        .sqrt()
}

fn root_mean_square(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len().max(1) as f64).sqrt()
}

/// RMS of the residuals averaged over some windows, without what noise certainly or by chance leaves
/// of them; `noise_nm`: that of a window's share of the log.
fn slow_misfit(found: &Found, used: &[usize], noise_nm: f64) -> f64 {
    let (mut square, mut noise_square, mut stretches) = (0.0, 0.0, 0.0);
    let mut rest = found.residuals.as_slice();
    for stretch in used.chunk_by(|a, b| a / MISFIT_WINDOWS == b / MISFIT_WINDOWS) {
        let (these, others) = rest.split_at(stretch.len());
        rest = others;
        if stretch.len() < MISFIT_WINDOWS {
            continue;
        }
        let count = these.len() as f64;
        let mean = these.iter().sum::<f64>() / count;
        square += mean * mean;
        noise_square += noise_nm * noise_nm / count;
        stretches += 1.0;
    }
    let stretches = f64::max(stretches, 1.0);
    // The mean of that many squares of normal values scatters by sqrt(2/n) of itself.
    let by_chance = 1.0 + CHANCE_ERRORS * (2.0 / stretches).sqrt();
    ((square - by_chance * noise_square) / stretches)
        .max(0.0)
        .sqrt()
}

/// How often the torque goes from beyond the threshold on one side to beyond it on the other.
fn changes(torques: impl Iterator<Item = f64>, threshold_nm: f64) -> usize {
    let sides: Vec<f64> = torques
        .filter(|torque| torque.abs() > threshold_nm)
        .map(f64::signum)
        .collect();
    sides
        .windows(2)
        .filter(|pair| pair[0] * pair[1] < 0.0)
        .count()
}
