//! Interacting multiple models: three Kalman filters, one per flank and one for the gap, mixed by a
//! Markov chain.
//!
//! Each filter is linear (`filter`). Every servo tick:
//! ```text
//! mixing:      c_j = sum_i p_ij mu_i;   mu_ij = p_ij mu_i/c_j;   x_j, P_j = moments of the mixture of all (x_i, P_i) with weights mu_ij
//! filtering:   prediction with the model of j (left: -1, gap: 0, right: 1), update with the encoder, likelihood L_j of the innovation
//! geometry:    G_j = probability, after x_j and P_j, that the flank of j is pressed; for the gap, that none is
//! chain:       mu_j = c_j L_j G_j/sum;   p: stays with 1 - p, from flank to gap p, from the gap to either flank p/2
//! output:      x, P = moments of the mixture with weights mu_j
//! ```
//! G is this project's addition: a linear spring also pulls, and without G "pulled by the left
//! flank" and "pushed by the right one" look alike.
//!
//! The half gap is used as in `kalman`, with changes of the most probable flank. Signals:
//! references, motor position (rad), current (A). It is told the load's inertia and friction and
//! the shaft, **not the gap**. Settings: those of `kalman`, and p (0 to 0.5 a tick).
//!
//! Fails: as `kalman`; and with a large p every oscillation of the torque becomes a change of
//! flank.
//!
//! Source: Blom and Bar-Shalom, IEEE Trans. Automatic Control 33 (1988).

use crate::AxisConfig;
use crate::crossing::{Crossing, CrossingState, TORQUE_SHARE};
use crate::filter::{Belief, Filter, GAP_ANGLE, HALF_GAP, N, Noises, Trust, check_noises};
use crate::registry::{Registered, Settings};
use lostmotion_base::math;
use lostmotion_drive::config::check::{AxisConfigError, between};
use lostmotion_drive::config::{Gap, Transmission};
use lostmotion_drive::signal::Engagement;
use lostmotion_drive::{Compensator, Correction, Knowledge, MethodInfo, Signals};
use serde::{Deserialize, Serialize};

/// Settings of `multiple-models`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MultipleModelsSettings {
    /// Standard deviation of the torques that the models do not explain, as part of the rated
    /// torque.
    pub torque_noise_share: f64,
    /// Standard deviation of the unknown gap at the start, as a total gap; a two-hundredth of a
    /// turn of the motor if left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap_spread: Option<Gap>,
    /// Drift of the half gap, as a part of its spread at the start per square root of s.
    pub wandering_share: f64,
    /// Part of the drive's largest torque that a traverse of the gap may take, 0 to 1.
    pub torque_share: f64,
    /// Probability that contact is made or broken within a tick of 250 us, above 0 to 0.5.
    pub change_per_tick: f64,
}

impl Default for MultipleModelsSettings {
    fn default() -> MultipleModelsSettings {
        MultipleModelsSettings {
            torque_noise_share: 0.015,
            gap_spread: None,
            wandering_share: 1e-3,
            torque_share: TORQUE_SHARE,
            change_per_tick: 3e-4,
        }
    }
}

impl Settings for MultipleModelsSettings {
    fn check(&self, transmission: &Transmission) -> Result<(), AxisConfigError> {
        between("change_per_tick", self.change_per_tick, 1e-9, 0.5)?;
        check_noises(
            self.torque_noise_share,
            self.gap_spread,
            self.wandering_share,
            transmission,
        )?;
        between("torque_share", self.torque_share, 0.01, 1.0)
    }
}

/// Flanks of the models: left, none (the gap), right.
const SIDES: [i8; 3] = [-1, 0, 1];
/// Least probability of a model: one that reached zero could never come back. A choice.
const LEAST_PROBABILITY: f64 = 1e-9;
/// Standard deviation that the geometry of a flank has at least, rad: it keeps the probability of
/// contact smooth when the filters are certain. A choice: 3 nm on a screw of 20 mm, about a step of
/// an encoder with 2^23 counts.
const GEOMETRY_NOISE_RAD: f64 = 1e-6;

/// The method `multiple-models`.
#[derive(Clone, Debug)]
pub struct MultipleModels {
    filter: Filter,
    crossing: Crossing,
    /// `chain[i][j]`: from i to j in a tick.
    chain: [[f64; 3]; 3],
}

/// Mean and covariance of each model, their probabilities, the traverse, and the trust in the half
/// gap.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MultipleModelsState {
    beliefs: [Belief; 3],
    probability: [f64; 3],
    crossing: CrossingState,
    current: f64,
    trust: Trust,
}

impl Registered for MultipleModels {
    const INFO: &'static MethodInfo = &MethodInfo {
        name: "multiple-models",
        summary: "interacting multiple models {left, gap, right} from the motor's side with the half gap as a state; planned traverse",
        knows: Knowledge {
            load_scale: false,
            gap: false,
            load: true,
        },
        source: "Blom and Bar-Shalom, IEEE Trans. Automatic Control 33 (1988)",
    };

    fn from_axis(config: &AxisConfig) -> MultipleModels {
        let settings = &config.compensation.multiple_models;
        let p = settings.change_per_tick;
        MultipleModels {
            filter: Filter::new(
                config,
                &Noises::new(
                    settings.torque_noise_share,
                    settings.gap_spread,
                    settings.wandering_share,
                    config,
                ),
            ),
            crossing: Crossing::new(config, settings.torque_share, 0.0),
            chain: [
                // contact is made and broken through the gap: no step from flank to flank
                [1.0 - p, p, 0.0],
                [0.5 * p, 1.0 - p, 0.5 * p],
                [0.0, p, 1.0 - p],
            ],
        }
    }
}

/// Mean and covariance of a mixture of normal distributions.
fn mixture(beliefs: &[Belief; 3], weights: &[f64; 3]) -> Belief {
    let mut whole = Belief {
        mean: [0.0; N],
        covariance: [[0.0; N]; N],
    };
    for (belief, weight) in beliefs.iter().zip(weights) {
        for (sum, x) in whole.mean.iter_mut().zip(belief.mean) {
            *sum += weight * x;
        }
    }
    for (belief, weight) in beliefs.iter().zip(weights) {
        // covariance of the members, and the spread of their means about the common one
        let off: [f64; N] = std::array::from_fn(|i| belief.mean[i] - whole.mean[i]);
        for (i, row) in whole.covariance.iter_mut().enumerate() {
            for (j, sum) in row.iter_mut().enumerate() {
                *sum += weight * (belief.covariance[i][j] + off[i] * off[j]);
            }
        }
    }
    whole
}

/// The normal distribution's probability below z, by the logistic curve 1/(1 + exp(-1.702 z)), which
/// differs by less than 0.01 (Haley, 1952).
fn probability_below(z: f64) -> f64 {
    1.0 / (1.0 + math::exp((-1.702 * z).clamp(-700.0, 700.0)))
}

/// Probability that a model's geometry holds.
fn geometry(belief: &Belief, side: i8) -> f64 {
    let pressed = |side: i8| {
        // how far the flank is pressed is normally distributed about the filter's mean
        let spread =
            (belief.pressed_variance(side) + GEOMETRY_NOISE_RAD * GEOMETRY_NOISE_RAD).sqrt();
        probability_below(belief.pressed(side) / spread)
    };
    if side == 0 {
        (1.0 - pressed(1)) * (1.0 - pressed(-1))
    } else {
        pressed(side)
    }
}

impl MultipleModels {
    /// One cycle of the interacting filters: `reading` in rad, mean `current` in A.
    fn filter_all(&self, state: &mut MultipleModelsState, reading: f64, current: f64) {
        let before = (state.beliefs, state.probability);
        let mut logs = [0.0; 3];
        let mut prior = [0.0; 3];
        for (j, side) in SIDES.into_iter().enumerate() {
            // mixing: each model starts from all of them, weighted by the chain's transitions
            let arriving: [f64; 3] = std::array::from_fn(|i| self.chain[i][j] * before.1[i]);
            prior[j] = arriving.iter().sum::<f64>();
            let weights = arriving.map(|weight| weight / prior[j]);
            let mut belief = mixture(&before.0, &weights);
            // filtering with the model of this flank; the geometry weighs like a second measurement
            self.filter.predict(&mut belief, side, current);
            logs[j] = self.filter.update(&mut belief, reading)
                + math::log(geometry(&belief, side).max(1e-30));
            state.beliefs[j] = belief;
        }
        // posterior of the chain; shifted by the largest logarithm so that no exponential
        // underflows for all
        let largest = logs.into_iter().fold(f64::NEG_INFINITY, f64::max);
        let weights: [f64; 3] = std::array::from_fn(|j| {
            (prior[j] * math::exp((logs[j] - largest).max(-700.0))).max(LEAST_PROBABILITY)
        });
        let sum: f64 = weights.iter().sum();
        state.probability = weights.map(|weight| weight / sum);
    }
}

impl Compensator for MultipleModels {
    type State = MultipleModelsState;

    fn info(&self) -> &'static MethodInfo {
        Self::INFO
    }

    fn initial(&self, motor_position: f64) -> MultipleModelsState {
        MultipleModelsState {
            beliefs: [self.filter.initial(motor_position); 3],
            probability: [0.25, 0.5, 0.25],
            crossing: self.crossing.initial(motor_position, self.filter.load()),
            current: 0.0,
            trust: Trust::default(),
        }
    }

    fn step(&self, state: &mut MultipleModelsState, signals: &Signals) -> Correction {
        let current = Filter::mean_current(state.current, signals);
        state.current = signals.current;
        self.filter_all(state, signals.motor_position, current);
        // diverged, as on input that is not finite: start anew
        if !state.beliefs.iter().all(Belief::is_finite)
            || !state.probability.iter().all(|p| p.is_finite())
        {
            state.beliefs = [self.filter.initial(signals.motor_position); 3];
            state.probability = [0.25, 0.5, 0.25];
        }
        // one estimate out of the three, weighted by their probabilities
        let whole = mixture(&state.beliefs, &state.probability);
        // a flank counts only with more than half of the probability, otherwise the gap does
        let likeliest = SIDES
            .into_iter()
            .zip(state.probability)
            .fold(
                (0, 0.5),
                |best, next| if next.1 > best.1 { next } else { best },
            )
            .0;
        let half_gap = state
            .trust
            .step(likeliest, whole.mean[HALF_GAP], whole.half_gap_spread());
        let crossing =
            self.crossing
                .step(&mut state.crossing, signals, self.filter.load(), half_gap);
        Correction {
            gap_angle_estimate: whole.mean[GAP_ANGLE],
            engagement_estimate: Engagement::of_sign(likeliest),
            ..crossing
        }
    }
}
