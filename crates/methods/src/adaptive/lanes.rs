//! A motor as its current should have moved it, with the load behind it (`load_laws`): eight hypotheses side by side.
//!
//! Over each sample, with the motor going from one measured position to the next at a constant
//! speed (SI units at the motor):
//! ```text
//! w  += H (K_t i - T - b_v w - F_M sign)/J_M       theta += H w       T: mean torque of the shaft
//! e   = theta measured - theta;  theta += alpha e, w += beta e/H
//! ```
//! The load takes four steps in a sample (`h = H/4`). `e` is the innovation: what the hypothesis did not
//! predict. alpha and beta are those of the steady-state Kalman filter for the encoder's rounding against an
//! unmodelled torque; the true parameters minimise the sum of `e^2` over its variance (prediction error method,
//! Ljung, *System Identification*, 1999).

use super::load_laws::{Driven, LoadLaws};
use super::start::{Gains, StartFilter, StartRates};
use super::window::{Sample, Window};
use lostmotion_base::{Clock, Number, Wide};
use pulp::Simd;
use serde::{Deserialize, Serialize};
use std::ops::{Deref, DerefMut};

/// Hypotheses side by side.
pub(super) const LANES: usize = 8;
/// Integration steps of the load in a sample. A choice: 62.5 us, of which a shaft that rings at 500 Hz has 32 a
/// period; more cost time in proportion.
pub(super) const STEPS_PER_SAMPLE: usize = 4;

/// One number for each hypothesis, where a vector of them is read and written in one piece.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[repr(align(64))]
pub(super) struct Lanes(pub(super) [f64; LANES]);

impl Lanes {
    /// Every number through a function.
    #[inline(always)]
    pub(super) fn map(&self, function: impl Fn(f64) -> f64) -> Lanes {
        let mut lanes = *self;
        for lane in &mut lanes.0 {
            *lane = function(*lane);
        }
        lanes
    }
}

impl Deref for Lanes {
    type Target = [f64; LANES];

    fn deref(&self) -> &[f64; LANES] {
        &self.0
    }
}

impl DerefMut for Lanes {
    fn deref_mut(&mut self) -> &mut [f64; LANES] {
        &mut self.0
    }
}

/// What the shaft, the load and the motor's friction may be. Motor side, SI.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Hypotheses {
    pub(super) half_gap: Lanes,
    pub(super) coulomb: Lanes,
    pub(super) constant: Lanes,
    pub(super) inertia: Lanes,
    pub(super) viscous: Lanes,
    pub(super) stiffness: Lanes,
    pub(super) damping: Lanes,
    pub(super) motor_coulomb: Lanes,
}

/// Where the hypotheses are in a window.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Progress {
    next: usize,
    pub(super) lead: Lanes,
    pub(super) load_speed: Lanes,
    off: Lanes,
    pub(super) speed: Lanes,
    filter: SteadyFilter,
    start: StartFilter,
}

/// Samples at the start of a window in which the load's unknown start is found: 35 ms of the 50 ms that are kept
/// from before a crossing. A choice: the 15 ms that are left are read before the crossing.
pub(super) const WARM_UP: usize = 140;

/// Step of a load's equation.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Step {
    /// s.
    pub(super) time_s: f64,
    /// Part of it after which the torque is taken: a half for the midpoint rule, all for implicit Euler.
    pub(super) part: f64,
}

impl Step {
    /// In a sample of so many servo ticks.
    fn of(filter: &SteadyFilter) -> Step {
        Step {
            time_s: filter.span / STEPS_PER_SAMPLE as f64,
            part: if filter.ticks > 1 { 1.0 } else { 0.5 },
        }
    }
}

/// Samples over which the motor's speed at the start is averaged: 4 ms. A choice: longer means average more of
/// the encoder's steps, shorter ones lag less behind an acceleration.
const SPEED_SAMPLES: usize = 16;

/// Innovations of one sample, and their variance, rad and rad2.
pub(super) struct Innovation {
    pub(super) e: Lanes,
    pub(super) variance: f64,
}

impl Progress {
    /// At the start of a window: the load on its flank, both moving as the motor does over the
    /// first samples.
    pub(super) fn start(window: &Window, hypotheses: &Hypotheses) -> Progress {
        let mean = |to: usize| window.mean_speed(0, to);
        // means over half and all of the first samples, extrapolated linearly to the start
        let speed = 2.0 * mean(SPEED_SAMPLES / 2) - mean(SPEED_SAMPLES);
        let side = f64::from(window.side);
        // pressed on its flank so far that the spring carries the observed torque
        let lead = Lanes(std::array::from_fn(|lane| {
            side * hypotheses.half_gap[lane] + window.torque / hypotheses.stiffness[lane]
        }));
        // a load at rest stands; one on the way must not stick in the transient of the start
        let load_speed = Lanes([if window.stands { 0.0 } else { speed }; LANES]);
        Progress {
            next: 1,
            lead,
            load_speed,
            off: Lanes::default(),
            speed: Lanes([speed; LANES]),
            filter: SteadyFilter::default(),
            start: StartFilter::default(),
        }
    }

    /// How many samples have been taken.
    pub(super) fn taken(&self) -> usize {
        self.next
    }

    /// Takes one more sample of the window for the first `asked` hypotheses: `None` at its end, else the
    /// innovations, or `Some(None)` during the warm-up.
    #[inline(always)]
    pub(super) fn step<S: Simd>(
        &mut self,
        simd: S,
        (known, p): (&Known, &Hypotheses),
        stays: &mut Stays,
        window: &Window,
        asked: usize,
    ) -> Option<Option<Innovation>> {
        let [from, to] = [
            window.samples.get(self.next - 1)?,
            window.samples.get(self.next)?,
        ];
        // merged samples are longer: the steady-state gains depend on the length
        if to.ticks != self.filter.ticks {
            self.filter = known.filter(to.ticks);
        }
        if stays.ticks != self.filter.ticks {
            *stays = Stays::of(p, &self.filter);
        }
        let warm = self.next < WARM_UP;
        let gains = warm.then(|| self.find_start(known, p, stays, window));
        self.next += 1;
        // the motor's measured motion drives the load, the load's torque the motor
        let speed = (to.position - from.position) / self.filter.span;
        let parts = asked.div_ceil(S::F64_LANES);
        let torque = self.load(simd, stays, speed, parts);
        let innovation = self.motor(simd, (known, p), &torque, [from, to], parts);
        self.correct(simd, &innovation.e, gains, parts);
        Some((!warm).then_some(innovation))
    }

    /// Gains of the next sample of the warm-up.
    #[inline(always)]
    fn find_start(
        &mut self,
        known: &Known,
        p: &Hypotheses,
        stays: &mut Stays,
        window: &Window,
    ) -> Gains {
        if self.next == 1 {
            let span = self.filter.span;
            self.start = StartFilter::new(known, p, window.torque, window.stands, span);
        }
        let is_pressed = self.lead[0].abs() > p.half_gap[0];
        let stands = self.load_speed[0].abs() <= 0.0;
        let of = [is_pressed, stands];
        if stays.start.of != Some(of) {
            stays.start = StartRates::new(known, p, of, stays.step);
        }
        self.start.step(known, &stays.start)
    }

    /// Moves the load over a sample; returns the mean torque of the shaft, N m.
    #[inline(always)]
    fn load<S: Simd>(&mut self, simd: S, stays: &Stays, motor_speed: f64, parts: usize) -> Lanes {
        let mut mean = Lanes::default();
        for part in 0..parts {
            let get = |lanes: &Lanes| Wide::get(simd, &lanes.0, part);
            let laws = stays.load.map(get);
            let driven = Driven::new(&laws, motor_speed);
            let mut load = [get(&self.lead), get(&self.load_speed)];
            let mut sum = get(&mean);
            for _ in 0..STEPS_PER_SAMPLE {
                // a load at rest has to be asked whether it sticks; mostly none of them rests
                let torque;
                (load, torque) = if Wide::none(load[1].equals(load[1].zero())) {
                    laws.step(load, &driven, load[1])
                } else {
                    laws.step_of_resting(load, &driven)
                };
                sum = sum + torque;
            }
            (sum * sum.constant(1.0 / STEPS_PER_SAMPLE as f64)).put(&mut mean.0, part);
            load[0].put(&mut self.lead.0, part);
            load[1].put(&mut self.load_speed.0, part);
        }
        mean
    }

    /// Moves the motor over a sample; returns how far the measured position is from there.
    #[inline(always)]
    fn motor<S: Simd>(
        &mut self,
        simd: S,
        (known, p): (&Known, &Hypotheses),
        torque: &Lanes,
        [from, to]: [&Sample; 2],
        parts: usize,
    ) -> Innovation {
        let filter = self.filter;
        let (span, inverse) = (filter.span, 1.0 / known.inertia);
        let drive = known.torque_constant * to.current;
        // the current is a parabola through its ends and mean: one that falls acts early and moves
        // the motor farther, by H^2 K_t fall/(12 J_M)
        let way = to.position
            - from.position
            - span * span * inverse * known.torque_constant * to.fall / 12.0;
        let mut e = Lanes::default();
        for part in 0..parts {
            let get = |lanes: &Lanes| Wide::get(simd, &lanes.0, part);
            let all = |value: f64| Wide::all(simd, value);
            let speed = get(&self.speed);
            // prediction: change of speed by motor torque, shaft and viscous friction, then Coulomb
            // friction
            let gain =
                all(span * inverse) * ((all(drive) - get(torque)) - all(known.viscous) * speed);
            let next = slide(speed, gain, all(span * inverse) * get(&p.motor_coulomb));
            // off: predicted less measured position; differences keep the digits of a long way
            let off = (get(&self.off) + all(0.5 * span) * (speed + next)) - all(way);
            (-off).put(&mut e.0, part);
            off.put(&mut self.off.0, part);
            next.put(&mut self.speed.0, part);
        }
        // what the parabola does not describe counts as noise, as large as its own correction
        let untold = span * span * inverse * known.torque_constant * to.fall / 12.0;
        Innovation {
            e,
            variance: filter.variance + untold * untold,
        }
    }

    /// Takes in an innovation: with the gains of the steady-state filter, and while the start is being found with
    /// those that know how uncertain it is. A load that stands stays where it is.
    #[inline(always)]
    fn correct<S: Simd>(&mut self, simd: S, e: &Lanes, gains: Option<Gains>, parts: usize) {
        let SteadyFilter {
            alpha, beta, span, ..
        } = self.filter;
        let [lead, load_speed, off, speed] = gains.unwrap_or([0.0, 0.0, alpha, beta / span]);
        for part in 0..parts {
            let get = |lanes: &Lanes| Wide::get(simd, &lanes.0, part);
            let e = get(e);
            let by = |gain: f64| Wide::all(simd, gain) * e;
            (get(&self.off) + by(off)).put(&mut self.off.0, part);
            (get(&self.speed) + by(speed)).put(&mut self.speed.0, part);
            // once it is found the load need not wait for the motor
            if gains.is_some() {
                let before = get(&self.load_speed);
                let moves = e.zero().less(before.abs());
                let gained = Wide::choose(moves, by(load_speed), e.zero());
                (get(&self.lead) + by(lead)).put(&mut self.lead.0, part);
                (before + gained).put(&mut self.load_speed.0, part);
            }
        }
    }
}

/// What stays from sample to sample, as long as hypotheses and samples are the same and as long.
#[derive(Default)]
pub(super) struct Stays {
    /// Servo ticks in a sample, 0 before the first.
    ticks: u32,
    step: Step,
    load: LoadLaws<Lanes>,
    start: StartRates,
}

impl Stays {
    #[inline(always)]
    fn of(p: &Hypotheses, filter: &SteadyFilter) -> Stays {
        let step = Step::of(filter);
        Stays {
            ticks: filter.ticks,
            step,
            load: LoadLaws::new(p, step),
            start: StartRates::default(),
        }
    }
}

/// Speed after a gain of speed against Coulomb friction that takes at most `most` of it. A mass that
/// reverses does so within the sample, and friction changes its sign there.
#[inline(always)]
pub(super) fn slide<N: Number>(speed: N, gain: N, most: N) -> N {
    let after = slid_on(speed, gain, most);
    let turns = (speed * after).at_most(speed.zero());
    // few of them turn around
    if N::none(turns) {
        return after;
    }
    N::choose(turns, turned(speed, after, gain, most), after)
}

/// The same of a single mass: what it would do if it turned around is computed only if it does.
#[inline]
pub(super) fn slide_alone(speed: f64, gain: f64, most: f64) -> f64 {
    let after = slid_on(speed, gain, most);
    if speed * after > 0.0 {
        return after;
    }
    turned(speed, after, gain, most)
}

/// Speed afterwards, as long as it keeps its sign.
#[inline(always)]
fn slid_on<N: Number>(speed: N, gain: N, most: N) -> N {
    (speed + gain) - N::choose(speed.zero().less(speed), most, -most)
}

/// Speed afterwards of a mass that stood or came to rest.
#[inline(always)]
fn turned<N: Number>(speed: N, after: N, gain: N, most: N) -> N {
    // what friction leaves of the gain at rest: nothing below its limit
    let driven = gain - gain.clamp(-most, most);
    // part of the sample that is left after the zero of the speed
    let moved = speed.zero().less(speed.abs());
    let left = N::choose(moved, after / (after - speed), speed.constant(1.0));
    left * driven
}

/// What the drive knows of its motor, and the noises of its model. SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Known {
    pub(super) torque_constant: f64,
    pub(super) inertia: f64,
    pub(super) viscous: f64,
    /// Standard deviation of a measured position, rad.
    pub(super) noise: f64,
    /// Standard deviation of the torque that nothing models, over a servo tick, N m.
    pub(super) unmodelled: f64,
}

/// Gains and innovation variance of the steady-state filter for samples of one length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct SteadyFilter {
    pub(super) ticks: u32,
    pub(super) span: f64,
    pub(super) alpha: f64,
    pub(super) beta: f64,
    pub(super) variance: f64,
}

impl Known {
    /// The steady-state alpha-beta filter for samples of `stride` ticks, from its tracking index
    /// (Kalata, IEEE Trans. Aerospace Electron. Syst. 20, 1984).
    pub(super) fn filter(&self, stride: u32) -> SteadyFilter {
        let span = f64::from(stride) * Clock::SERVO.period_s();
        // tracking index: motion by the unmodelled torque over the noise of the position; torques
        // of single ticks average out over a sample
        let index =
            self.unmodelled / self.inertia * span * span / (f64::from(stride).sqrt() * self.noise);
        let r = 0.25 * (4.0 + index - (8.0 * index + index * index).sqrt());
        let alpha = 1.0 - r * r;
        let beta = 2.0 * (2.0 - alpha) - 4.0 * (1.0 - alpha).sqrt();
        SteadyFilter {
            ticks: stride,
            span,
            alpha,
            beta,
            variance: self.noise * self.noise / (1.0 - alpha),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::prior::uniform;
    use super::*;
    use lostmotion_base::math;
    use pulp::{Arch, Simd, WithSimd};

    const KNOWN: Known = Known {
        torque_constant: 0.9,
        inertia: 1.3e-3,
        viscous: 2e-4,
        noise: 3e-6,
        unmodelled: 0.02,
    };

    /// Bits do not depend on the processor: plain arithmetic gives what its widest vectors give.
    #[test]
    fn vectors_give_the_same_bits_as_plain_arithmetic() {
        let each = |first: f64, ratio: f64| {
            Lanes(std::array::from_fn(|lane| {
                first * (1.0 + ratio * lane as f64)
            }))
        };
        let p = Hypotheses {
            half_gap: each(2e-4, 0.7),
            coulomb: Lanes([0.3; LANES]),
            constant: each(0.05, 0.1),
            inertia: each(2e-3, 0.4),
            viscous: each(1e-3, 0.2),
            stiffness: each(900.0, 0.3),
            damping: each(0.05, 0.5),
            motor_coulomb: each(0.1, 0.05),
        };
        let at = |n: u32| Sample {
            position: 4e-3 * math::sin(0.04 * f64::from(n)),
            current: 2.0 * math::cos(0.05 * f64::from(n)),
            fall: 0.01,
            ticks: 2,
        };
        let mut window = Window::default();
        (window.side, window.torque) = (1, 0.2);
        window.samples = (0..400).map(at).collect();
        // loads at rest and on the way in one vector
        let start = Progress {
            load_speed: each(-0.4, 0.5).map(|speed| if speed < -1.5 { 0.0 } else { speed }),
            ..Progress::start(&window, &p)
        };
        let (mut wide, mut plain) = (start, start);
        let mut stays = [(); 2].map(|()| Stays::default());
        for n in 1..400 {
            let (a, b) = (
                Arch::new().dispatch(One(&mut wide, &p, &mut stays[0], &window)),
                One(&mut plain, &p, &mut stays[1], &window).with_simd(pulp::Scalar::new()),
            );
            assert_eq!(a, b, "{n}");
            assert_eq!(wide, plain, "{n}");
        }
    }

    /// A sample in vectors.
    struct One<'a>(&'a mut Progress, &'a Hypotheses, &'a mut Stays, &'a Window);

    impl WithSimd for One<'_> {
        type Output = Option<Option<[u64; LANES]>>;

        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> Self::Output {
            let One(progress, p, stays, window) = self;
            let innovation = progress.step(simd, (&KNOWN, p), stays, window, LANES)?;
            Some(innovation.map(|innovation| innovation.e.0.map(f64::to_bits)))
        }
    }

    #[test]
    fn a_load_swings_on_its_shaft_as_in_closed_form() {
        for frequency in [20.0, 100.0, 300.0] {
            let (inertia, rate) = (2e-3, std::f64::consts::TAU * frequency);
            let at = [0.0, 0.0, 0.0, inertia, 0.0, inertia * rate * rate, 0.0];
            let p = uniform(&at, 0.0);
            let mut progress = Progress {
                next: 1,
                lead: Lanes([1e-3; LANES]),
                load_speed: Lanes([1e-12; LANES]),
                off: Lanes::default(),
                speed: Lanes::default(),
                filter: KNOWN.filter(1),
                start: StartFilter::default(),
            };
            // the motor stands for 50 ms: a period of the slowest
            let stays = Stays::of(&p, &progress.filter);
            for n in 1..=200 {
                progress.load(pulp::Scalar::new(), &stays, 0.0, LANES);
                let time_s = f64::from(n) * Clock::SERVO.period_s();
                // the midpoint rule is late by a twelfth of the square of its angle a step, and loses nothing
                let angle = rate * stays.step.time_s;
                let late = rate * time_s * angle * angle / 12.0;
                let off = progress.lead[0] - 1e-3 * math::cos(rate * time_s - late);
                assert!(off.abs() < 2e-6, "{frequency} Hz, {time_s} s: {off}");
            }
        }
    }

    #[test]
    fn a_mass_that_turns_around_goes_on_with_friction_against_its_new_way() {
        // at rest after 0.1/0.61 of the sample, then 0.59 for the rest of it
        assert!((slide(-0.1, 0.6, 0.01) - 0.59 * (1.0 - 0.1 / 0.61)).abs() < 1e-15);
        assert_eq!((slide(0.1, -0.005, 0.2), slide(0.0, 0.1, 0.2)), (0.0, 0.0));
        assert!(
            (slide(0.5, 0.1, 0.2) - 0.4).abs() < 1e-15
                && (slide(0.0, 0.3, 0.2) - 0.1).abs() < 1e-15
        );
    }
}
