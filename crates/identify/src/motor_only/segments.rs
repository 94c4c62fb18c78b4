//! Crossings of the gap during which the load's motion is known but for a few constants.
//!
//! Two kinds. The load **rests**, held by its friction while the torque passes from one flank to
//! the other:
//! ```text
//! x_L = X,   and from where it breaks away   x_L = X + p G,   G = double integral of T - T_0 - b_L w - T_f s
//! ```
//! or it **slides** through in one direction:
//! ```text
//! x_L = X + V t + Q t^2/2 + p G - p b_L D + p e L,   G = double integral of T,   L = single integral of K_t i,
//!                                                 D = double integral of w
//! ```
//! with p = 1/J_L, and X, V, Q of this crossing alone; Q includes friction and constant torque. The
//! contact torque T is data: the double integral of a triangular average over its own width is an
//! exact second difference, so that the encoder's noise in `J_M alpha` comes out of the sum as it
//! went in. The current between two samples is not their mean; to first order it is the current of
//! a moment e later, hence the term with L.

use super::sides::{Sides, Stretch};
use crate::result::FittedLoad;
use crate::window::WindowSample;

/// Part of the friction up to which a load certainly rests. A choice: the remainder is left to the
/// friction's error and the torque's noise.
const RESTING_SHARE: f64 = 0.85;
/// Windows of each side that a crossing takes at most. A choice: more average more noise, and let
/// more error of the inertia into the load's motion.
const MAX_WINDOWS_PER_SIDE: usize = 24;
/// Windows after the break-away of a resting load that a crossing takes at most. A choice: soon
/// after it the load's friction decides, which is known less well than its rest.
const WINDOWS_AFTER_BREAKAWAY: usize = 10;
/// Windows between the motor's reversal and the load's certain rest. A choice: fewer take the
/// shaft's swing for rest, more give up short crossings.
const WINDOWS_AFTER_REVERSAL: usize = 5;
/// Fewest windows on each side of a crossing. Derived: one more than the side's offset needs, so
/// that a residual tells of the noise.
const MIN_WINDOWS_PER_SIDE: usize = 2;
/// Least speed of a load that slides through, over that at the start. A choice: a slower load may
/// have stopped within the error of the friction.
const MIN_SPEED_SHARE: f64 = 0.1;
/// Longest crossing of a load that slides, in windows: errors of the torque add up in its motion.
/// A choice: a torque off by 1 % moves a load that coasts with the square of the time.
const LONGEST_SLIDING: usize = 300;
/// Longest crossing of a load that rests, in windows. A choice: bounds the work; the load does not
/// move meanwhile.
const LONGEST_RESTING: usize = 1000;

/// One window in firm contact, as an equation: motor = offset(X, V, Q) + side b + torque c -
/// sliding_rate r - slip tau + resting_rate c e + travel p + impulse p e + friction p dT_f - drag p
/// b_L.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Equation {
    pub(super) motor: f64,
    pub(super) side: f64,
    /// Torque of the contact, N m; where the load slides without its constant part, and free of the
    /// encoder's noise.
    pub(super) torque: f64,
    /// Rate of the motor's torque, N m/s, where the load slides; zero where it rests. In contact
    /// that of the contact follows it, and it is free of the encoder's noise.
    pub(super) sliding_rate: f64,
    /// Speed of the motor against the load, rad/s, where the load rests or breaks away; zero where
    /// it slides.
    pub(super) slip: f64,
    /// Rate of the motor's torque, N m/s, where the load rests or breaks away; zero where it
    /// slides.
    pub(super) resting_rate: f64,
    pub(super) travel: f64,
    /// Single integral of the motor's torque, beyond that at the break-away if there is one, N m s.
    pub(super) impulse: f64,
    /// Double integral of the speed, rad s, where the load slides; zero where it rests.
    pub(super) drag: f64,
    /// The load's travel against each N m of friction beyond the known, for p = 1, kg m2 rad.
    pub(super) friction: f64,
    /// Windows since the crossing's first.
    pub(super) time: f64,
    /// Windows since the load's motion has to be added up; zero where it rests.
    pub(super) under_way: f64,
}

/// Place of the half gap b, rad, among the coefficients that all crossings have in common. Below, p
/// is 1 over the load's inertia.
pub(super) const HALF_GAP: usize = 0;
/// The compliance c, rad/(N m).
pub(super) const COMPLIANCE: usize = 1;
/// r on the rate of the torque of sliding contact: damping less lateness, rad s/(N m).
pub(super) const SLIDING_RATE: usize = 2;
/// p, 1/(kg m2).
pub(super) const INVERSE_INERTIA: usize = 3;
/// p times the load's friction beyond the known, rad/s2.
pub(super) const FRICTION: usize = 4;
/// p times the lateness e of the current, s/(kg m2).
pub(super) const CURRENT_LATENESS: usize = 5;
/// The damping time tau, s.
pub(super) const DAMPING_TIME: usize = 6;
/// c times the lateness of the current, where the load rests, rad s/(N m).
pub(super) const RESTING_RATE: usize = 7;
/// p times the load's viscous friction, 1/s.
pub(super) const DRAG: usize = 8;
/// Number of these coefficients.
pub(super) const COMMON: usize = 9;

/// One crossing.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Segment {
    /// Whether the load slides through: then it has a speed and an acceleration of its own.
    pub(super) slides: bool,
    pub(super) equations: Vec<Equation>,
}

/// Inputs from which crossings are cut.
pub(super) struct Cutter<'a> {
    pub(super) windows: &'a [WindowSample],
    pub(super) sides: &'a Sides,
    pub(super) load: &'a FittedLoad,
    /// Time between windows, s.
    pub(super) spacing_s: f64,
    /// The same log, one window a sample.
    pub(super) samples: &'a [WindowSample],
    /// Samples between windows, and time between samples, s.
    pub(super) half: usize,
    pub(super) period_s: f64,
    /// Windows until a landing has settled.
    pub(super) settle: usize,
    /// Inertia of the motor, kg m2.
    pub(super) motor_inertia_kgm2: f64,
}

impl Cutter<'_> {
    /// All crossings that can be used, and how many changes of side there were.
    pub(super) fn cut(&self) -> (Vec<Segment>, usize) {
        let stretches = self.sides.stretches();
        let changes = |stretches: &[Stretch]| -> Vec<[Stretch; 2]> {
            stretches
                .windows(2)
                .filter(|pair| pair[0].0 != pair[1].0)
                .map(|pair| [pair[0], pair[1]])
                .collect()
        };
        // a landing may bounce: between two long stretches the short ones are part of the crossing
        let long: Vec<Stretch> = stretches
            .iter()
            .copied()
            .filter(|stretch| stretch.2 - stretch.1 > self.settle)
            .collect();
        let (all, landed) = (changes(&stretches), changes(&long));
        // Changes of side that show neither kind with certainty are dropped.
        let resting = all.iter().filter_map(|[from, to]| self.resting(*from, *to));
        let sliding = landed
            .iter()
            .filter_map(|[from, to]| self.sliding(*from, *to));
        (resting.chain(sliding).collect(), all.len())
    }

    fn rate(&self, n: usize) -> f64 {
        self.windows[n].rate_rad_s
    }

    /// Torque on the load beyond the constant one, N m.
    fn drive(&self, n: usize) -> f64 {
        self.windows[n].torque_nm - self.load.constant_nm
    }

    fn rests(&self, n: usize) -> bool {
        self.drive(n).abs() < RESTING_SHARE * self.load.coulomb_nm
    }

    fn resting(&self, from: Stretch, to: Stretch) -> Option<Segment> {
        // Signs of the flank that is left and of the one that is met.
        let (old, new) = (f64::from(from.0), f64::from(to.0));
        let unloads = |n: usize| self.rests(n) && self.rate(n) * old < 0.0;
        let last = from.2;
        // How long before contact is lost the motor already backs off while friction holds the
        // load.
        let backed = (from.1..=last)
            .rev()
            .take(LONGEST_RESTING)
            .take_while(|&n| unloads(n))
            .count();
        // the load came to rest where the motor turned round; without that turn it may slide
        // backwards, braked
        let turn = (last + 1)
            .checked_sub(backed + 1)
            .filter(|&n| n >= from.1 && self.rate(n) * old >= 0.0)?;
        // At rest for certain, and not more windows than a crossing takes.
        let first =
            (turn + 1 + WINDOWS_AFTER_REVERSAL).max(last.saturating_sub(MAX_WINDOWS_PER_SIDE));
        // In the gap, too, the torque must stay below the friction: else the load moves unseen.
        if (last..to.1).any(|n| !self.rests(n)) || to.1 - last > LONGEST_RESTING {
            return None;
        }
        let firm = |n: &usize| self.sides.firm(*n);
        let mut chosen: Vec<CrossingWindow> = (first..=last)
            .filter(firm)
            .map(CrossingWindow::at_rest)
            .collect();
        let before = chosen.len();
        // On the new flank the load rests until the torque exceeds its friction, then breaks away.
        let held = (to.1..=to.2)
            .take_while(|&n| self.rests(n))
            .count()
            .min(MAX_WINDOWS_PER_SIDE);
        let end = (to.1 + held + WINDOWS_AFTER_BREAKAWAY).min(to.2);
        let away = BreakawayMotion::new(self, to.1 + held, end, new);
        chosen.extend(
            (to.1..end)
                .filter(firm)
                .map(|n| away.averaged(n, self.half)),
        );
        let after = chosen.len() - before;
        (before >= MIN_WINDOWS_PER_SIDE && after >= MIN_WINDOWS_PER_SIDE)
            .then(|| self.segment(&chosen, false))
    }

    fn sliding(&self, from: Stretch, to: Stretch) -> Option<Segment> {
        // Speed at the loss of contact, whose sign is the way of the crossing.
        let way = self.rate(from.2);
        let goes_on =
            |n: &usize| self.rate(*n) * way > 0.0 && self.rate(*n) / way > MIN_SPEED_SHARE;
        // Back from there as long as the motor goes the same way, fast enough.
        let first = (from.1.max(from.2.saturating_sub(MAX_WINDOWS_PER_SIDE))..=from.2)
            .rev()
            .take_while(goes_on)
            .last()?;
        // Contact on the new flank counts once its ringing has settled.
        let landed = to.1 + self.settle;
        let end = to.2.min(landed + MAX_WINDOWS_PER_SIDE);
        if end <= landed || landed - from.2 > LONGEST_SLIDING {
            return None;
        }
        // Double integrals of torque and speed by second differences, a single one of the motor's
        // torque, and the load's speed by Euler's method, which decides only whether it still
        // slides.
        let square = self.spacing_s * self.spacing_s;
        let (mut before, mut now, mut impulse, mut speed) =
            ([0.0; 2], [0.0; 2], 0.0, self.rate(first));
        let (mut chosen, mut counts) = (Vec::new(), [0, 0]);
        for n in first..=end {
            let window = &self.windows[n];
            // Nearly at rest: the load may stick, and its friction is no longer constant.
            if speed / way < MIN_SPEED_SHARE {
                break;
            }
            // the motor's own friction is constant as long as it goes one way: its part is a
            // parabola's
            let drive = self.spacing_s * self.motor_torque(n);
            let steps = [window.torque_nm, window.rate_rad_s];
            if self.sides.firm(n) && (n <= from.2 || n >= landed) {
                // The mean of a parabola under the triangle is its middle value and H^2/12 of its
                // bend.
                let [travel, drag] = std::array::from_fn(|i| now[i] + square * steps[i] / 12.0);
                let under_way = (n - first) as f64;
                chosen.push(CrossingWindow {
                    travel,
                    drag,
                    under_way,
                    impulse: impulse + 0.5 * drive,
                    ..CrossingWindow::at_rest(n)
                });
                counts[usize::from(n >= landed)] += 1;
            }
            (before, now) = (
                now,
                std::array::from_fn(|i| 2.0 * now[i] - before[i] + square * steps[i]),
            );
            impulse += drive;
            let viscous = self.load.viscous_nm_s_per_rad * speed;
            speed += self.spacing_s
                * (self.drive(n) - viscous - self.load.coulomb_nm * way.signum())
                / self.load.inertia_kgm2;
        }
        // a straight line, a parabola and a step need more windows than a step
        (counts
            .iter()
            .all(|count| *count >= 2 * MIN_WINDOWS_PER_SIDE))
        .then(|| self.segment(&chosen, true))
    }

    /// What the motor gives beyond its own friction, N m.
    fn motor_torque(&self, n: usize) -> f64 {
        self.windows[n].torque_nm + self.motor_inertia_kgm2 * self.windows[n].acceleration_rad_s2
    }

    fn segment(&self, chosen: &[CrossingWindow], slides: bool) -> Segment {
        let start = chosen.first().map_or(0, |first| first.window);
        let origin = self.windows[start].difference_rad;
        // while both masses slide together the contact carries the load's part of the motor's
        // torque, and a constant of the crossing's own
        let clean = self.load.inertia_kgm2 / (self.load.inertia_kgm2 + self.motor_inertia_kgm2);
        let equation = |chosen: &CrossingWindow| {
            let n = chosen.window;
            // Central difference of the motor's torque.
            let rate =
                (self.motor_torque(n + 1) - self.motor_torque(n - 1)) / (2.0 * self.spacing_s);
            Equation {
                motor: self.windows[n].difference_rad - origin,
                side: f64::from(self.sides.of(n)),
                torque: if slides {
                    clean * self.motor_torque(n)
                } else {
                    self.windows[n].torque_nm
                },
                sliding_rate: if slides { rate } else { 0.0 },
                resting_rate: if slides { 0.0 } else { rate },
                slip: if slides {
                    0.0
                } else {
                    self.rate(n) - chosen.load_speed
                },
                travel: chosen.travel,
                impulse: chosen.impulse,
                friction: chosen.friction,
                drag: chosen.drag,
                time: (n - start) as f64,
                under_way: chosen.under_way,
            }
        };
        Segment {
            slides,
            equations: chosen.iter().map(equation).collect(),
        }
    }
}

/// The motion of a load from where it breaks away, sample by sample, for p = 1.
struct BreakawayMotion {
    /// Sample at which it starts.
    first: usize,
    /// Travel, travel per N m of friction, impulse of the motor beyond that at the start, and
    /// speed.
    motion: Vec<[f64; 4]>,
    inertia: f64,
}

impl BreakawayMotion {
    /// `start`: first window whose torque exceeds the certain rest; `end`: last window that is
    /// asked for.
    fn new(cutter: &Cutter, start: usize, end: usize, side: f64) -> BreakawayMotion {
        let load = cutter.load;
        // Averages of half-width 1 begin at the log's second sample.
        let at = |sample: usize| &cutter.samples[(sample - 1).min(cutter.samples.len() - 1)];
        // Torque beyond what friction holds, counted towards the new flank's side.
        let beyond = |sample: usize| {
            side * (at(sample).torque_nm
                - load.constant_nm
                - load.viscous_nm_s_per_rad * at(sample).rate_rad_s)
                - load.coulomb_nm
        };
        let (earliest, last) = (start * cutter.half, (end + 2) * cutter.half);
        // Two samples in a row: noise of the current alone does not break the load away.
        let first = (earliest..last)
            .find(|&sample| beyond(sample) > 0.0 && beyond(sample + 1) > 0.0)
            .unwrap_or(last);
        let motor = |sample: usize| {
            at(sample).torque_nm + cutter.motor_inertia_kgm2 * at(sample).acceleration_rad_s2
        };
        let (period, square) = (cutter.period_s, cutter.period_s * cutter.period_s);
        let (mut before, mut now, mut impulse, mut speed) = ([0.0; 2], [0.0; 2], 0.0, 0.0);
        let mut motion = Vec::new();
        for sample in first..last {
            // Integrals sample by sample: the place by second differences, the speed by Euler's
            // method.
            let steps = [side * beyond(sample), -side];
            let late = period * (motor(sample) - motor(first));
            motion.push([
                now[0],
                now[1],
                impulse + 0.5 * late,
                speed + 0.5 * period * steps[0],
            ]);
            let next = std::array::from_fn(|i| 2.0 * now[i] - before[i] + square * steps[i]);
            (before, now) = (now, next);
            impulse += late;
            speed += period * steps[0];
        }
        BreakawayMotion {
            first,
            motion,
            inertia: load.inertia_kgm2,
        }
    }

    /// Averages over a window's triangle.
    fn averaged(&self, window: usize, half: usize) -> CrossingWindow {
        // Weights of the window's triangle; before the break-away the load rests and adds nothing.
        let centre = (window + 1) * half;
        let mut sums = [0.0; 4];
        for sample in centre - half..=centre + half {
            let weight = (half - sample.abs_diff(centre)) as f64 / (half * half) as f64;
            let motion = sample
                .checked_sub(self.first)
                .and_then(|n| self.motion.get(n));
            if let Some(motion) = motion {
                sums.iter_mut()
                    .zip(motion)
                    .for_each(|(sum, value)| *sum += weight * value);
            }
        }
        let [travel, friction, impulse, speed] = sums;
        let under_way = (centre as f64 - self.first as f64).max(0.0) / half as f64;
        CrossingWindow {
            travel,
            friction,
            impulse,
            under_way,
            load_speed: speed / self.inertia,
            ..CrossingWindow::at_rest(window)
        }
    }
}

/// A window of a crossing with the parts of the load's travel in it, as in [`Equation`].
struct CrossingWindow {
    window: usize,
    travel: f64,
    impulse: f64,
    friction: f64,
    drag: f64,
    load_speed: f64,
    under_way: f64,
}

impl CrossingWindow {
    fn at_rest(window: usize) -> CrossingWindow {
        CrossingWindow {
            window,
            travel: 0.0,
            impulse: 0.0,
            friction: 0.0,
            drag: 0.0,
            load_speed: 0.0,
            under_way: 0.0,
        }
    }
}
