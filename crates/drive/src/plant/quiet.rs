//! A cheap look whether a step can have met an event at all.
//!
//! Nearly every step meets none. The look may only err towards "perhaps"; [`super::Plant::step`]
//! then searches in earnest. What friction does is looked at twice: by how much the ends of the step
//! differ, and where that does not suffice, as it does not near rest and near breaking away, by the cubic
//! through both ends with the slopes there.

use super::dynamics::{Held, LOAD, MOTOR, PENETRATION, Vector};
use super::guard::Guards;
use super::mode::{Mass, Mode};
use super::params::PlantParams;
use lostmotion_base::Number;

/// Largest rate of a plant times its period with which the cubic is looked at. A choice: a vibration of
/// that rate is off the cubic by 1/384 of its amplitude, a sixth of what [`SLOPE_PART`] leaves it.
const LARGEST_CUBIC_RATE: f64 = 1.0;
/// Part of the slopes of a cubic that has to be left to a bound. A choice: a vibration needs it from 1.9 times
/// the largest rate on.
const SLOPE_PART: f64 = 1.0 / 16.0;

/// How far a quantity can dip within a step between two ends that are alike.
#[derive(Clone, Copy, Debug)]
pub(super) struct Margins {
    speed: f64,
    /// How far a speed and a torque can be off the cubic through both ends; infinite where it is not
    /// looked at.
    off_cubic: [f64; 2],
    torque: f64,
    third: f64,
}

impl Margins {
    /// From the largest acceleration that the drive's current can cause: a dip is at most h^2/8 of
    /// the second derivative.
    pub(super) fn new(params: &PlantParams) -> Margins {
        // the lighter mass is the one that accelerates most
        let inertia = params.motor_inertia_kgm2.min(params.load_inertia_kgm2);
        let acceleration = 2.0 * params.torque_constant_nm_per_a * params.current_limit_a / inertia;
        let dip = params.period_s * params.period_s / 8.0 * acceleration;
        let rate = params.rate();
        // second derivatives: of a speed the jerk, at most `rate` times the acceleration; of the
        // shaft's torque k times the acceleration and d times the jerk
        let damping = params.damping_nm_s_per_rad * rate;
        // a cubic is off by at most h^4/384 of the fourth derivative: twice `rate` more
        let per_step = rate * params.period_s;
        let off = if per_step <= LARGEST_CUBIC_RATE {
            per_step * per_step / 48.0
        } else {
            f64::INFINITY
        };
        let torque = dip * (params.stiffness_nm_per_rad + damping);
        Margins {
            off_cubic: [dip * rate * off, torque * off],
            speed: dip * rate,
            torque,
            third: params.period_s / 3.0,
        }
    }

    /// Dip of a speed, rad/s.
    pub(super) fn speed(&self) -> f64 {
        self.speed
    }

    /// Dip of a torque, N m.
    pub(super) fn torque(&self) -> f64 {
        self.torque
    }

    /// A third of the step, s.
    pub(super) fn third(&self) -> f64 {
        self.third
    }

    /// Whether frictions stay what they are, by the cubics of speeds and torques.
    #[cold]
    #[inline(never)]
    pub(super) fn near(
        &self,
        params: &PlantParams,
        mode: Mode,
        held: &Held,
        before: &Vector,
        after: &Vector,
    ) -> bool {
        let frictions = [
            params.sliding_torque(Mass::Motor, mode.motor),
            params.sliding_torque(Mass::Load, mode.load) + held.load_torque,
        ];
        let held = (held.voltage, frictions, held.load_torque);
        [Mass::Motor, Mass::Load].into_iter().all(|mass| {
            self.watch(params, mode, mass)
                .keeps(|x| *x, [before, after], held)
        })
    }

    /// What the friction of a mass is judged by: its guards, which differ in their sign and offset.
    pub(super) fn watch(&self, params: &PlantParams, mode: Mode, mass: Mass) -> Watch<f64> {
        let loaded = |load_torque: f64| {
            let held = Held {
                load_torque,
                ..Held::default()
            };
            Guards::of_mass(params, mode, mass, &held)
        };
        let [free, loaded] = [0.0, 1.0].map(loaded);
        let (mut guards, mut loaded) = (free.iter(), loaded.iter());
        let Some((low, pulled)) = guards.next().zip(loaded.next()) else {
            return Watch::FREE;
        };
        let off = self.off_cubic[usize::from(mode.friction(mass).stuck())];
        // the slope is the value of the derivative, which is linear in the states and what is held
        let of = |x: &Vector| (0..4).map(|row| low.row[row] * x[row]).sum::<f64>() * self.third;
        let mut step = [0.0; 7];
        for (state, step) in step.iter_mut().enumerate().take(4) {
            let mut unit = [0.0; 4];
            unit[state] = 1.0;
            *step = of(&params.linear(mode, &unit));
        }
        for (input, (state, by)) in params.inputs(mode).into_iter().enumerate() {
            step[4 + input] = low.row[state] * by * self.third;
        }
        Watch {
            value: low.row,
            held: pulled.offset - low.offset,
            step,
            range: [
                off - low.offset,
                guards
                    .next()
                    .map_or(f64::INFINITY, |high| high.offset - off),
            ],
        }
    }
}

/// What the friction of a mass is judged by: its speed in the direction of sliding, or while it stands the
/// torque on it; and the range in which its friction stays what it is, with what the cubic may be off.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Watch<N> {
    /// By state.
    pub(crate) value: [N; 4],
    /// By the torque that is held against the load.
    pub(crate) held: N,
    /// A third of the period times the slope, by state, voltage, and the torques that oppose motor and load.
    pub(crate) step: [N; 7],
    pub(crate) range: [N; 2],
}

impl Watch<f64> {
    /// Of a mass without friction.
    const FREE: Watch<f64> = Watch {
        value: [0.0; 4],
        held: 0.0,
        step: [0.0; 7],
        range: [f64::NEG_INFINITY, f64::INFINITY],
    };
}

impl<M> Watch<M> {
    /// Whether it stays in its range over a step between two ends, by the four coefficients in
    /// Bernstein's form of the cubic, and with a part of its slopes to spare. Held are the voltage, the torques
    /// that oppose motor and load, and what of the latter is not friction. `get` reads a number.
    #[inline(always)]
    pub(crate) fn keeps<N: Number>(
        &self,
        get: impl Fn(&M) -> N,
        [from, to]: [&[N; 4]; 2],
        (voltage, [motor, load], load_torque): (N, [N; 2], N),
    ) -> N::Mask {
        let held = get(&self.held) * load_torque;
        let same =
            get(&self.step[4]) * voltage + get(&self.step[5]) * motor + get(&self.step[6]) * load;
        let (mut first, mut last) = (held, held);
        let (mut rise, mut fall) = (same, same);
        for state in 0..4 {
            let (value, step) = (get(&self.value[state]), get(&self.step[state]));
            first = first + value * from[state];
            last = last + value * to[state];
            rise = rise + step * from[state];
            fall = fall + step * to[state];
        }
        let spare = (rise.abs() + fall.abs()) * held.constant(SLOPE_PART);
        let low = get(&self.range[0]) + spare;
        let high = get(&self.range[1]) - spare;
        let (second, third) = (first + rise, last - fall);
        (low.less(first) & first.less(high))
            & (low.less(last) & last.less(high))
            & (low.less(second) & second.less(high))
            & (low.less(third) & third.less(high))
    }
}

impl<N> Watch<N> {
    /// Puts every number into its place in another one.
    pub(crate) fn put<M>(&mut self, values: &Watch<M>, place: impl Fn(&mut N, &M)) {
        let of = |values: &[M], places: &mut [N]| {
            let pairs = places.iter_mut().zip(values);
            pairs.for_each(|(here, value)| place(here, value));
        };
        of(&values.value, &mut self.value);
        of(&values.step, &mut self.step);
        of(&values.range, &mut self.range);
        place(&mut self.held, &values.held);
    }
}

/// Whether the penetration stays in a range over a step: the four coefficients in Bernstein's form
/// of the cubic through both ends with the slopes there do, and the cubic lies between them.
#[inline(always)]
pub(crate) fn stays_within<N: Number>(
    [low, high]: [N; 2],
    third: N,
    before: &[N; 4],
    after: &[N; 4],
) -> N::Mask {
    let inside = |x: N| low.at_most(x) & x.at_most(high);
    let slope = |x: &[N; 4]| (x[MOTOR] - x[LOAD]) * third;
    let ends = inside(before[PENETRATION]) & inside(after[PENETRATION]);
    ends & (inside(before[PENETRATION] + slope(before)) & inside(after[PENETRATION] - slope(after)))
}

/// Whether the spring exceeds the damper by far at both ends of a step, so that a contact that may
/// not pull stays as it is. `stiffness` has the flank's sign.
#[inline(always)]
pub(crate) fn keeps_pushing<N: Number>(
    stiffness: N,
    damping: N,
    margin: N,
    before: &[N; 4],
    after: &[N; 4],
) -> N::Mask {
    let spare = |x: &[N; 4]| stiffness * x[PENETRATION] - damping * (x[MOTOR] - x[LOAD]).abs();
    let (a, b) = (spare(before), spare(after));
    let least = (a - b).abs() + margin;
    least.less(a) & least.less(b)
}

/// Whether a mass that slides in the direction of `sign` comes near to rest at neither end of a
/// step, by more than its speed changes.
#[inline(always)]
pub(crate) fn keeps_sliding<N: Number>(sign: N, margin: N, [from, to]: [N; 2]) -> N::Mask {
    let least = (to - from).abs() + margin;
    least.less(sign * from) & least.less(sign * to)
}

/// Whether friction up to `limit` holds a mass through a step against the torque on it at the
/// step's ends, by more than that torque changes. Where it does not change no margin is asked for.
#[inline(always)]
pub(crate) fn keeps_standing<N: Number>(limit: N, margin: N, before: N, after: N) -> N::Mask {
    let (size, then, change) = (before.abs(), after.abs(), (before - after).abs());
    let clear = |size: N| (size + change + margin).less(limit);
    (clear(size) & clear(then)) | (before.equals(after) & size.less(limit))
}

#[cfg(test)]
mod tests {
    use super::super::Plant;
    use super::super::dynamics::{CURRENT, Taylor};
    use super::super::guard::Guard;
    use super::super::mode::{Contact, Friction, Side};
    use super::super::params::{Curved, FrictionShape};
    use super::*;
    use crate::config::ContactLaw;
    use lostmotion_base::random::Random;

    /// A plant of which everything is drawn.
    fn drawn_params(random: &mut Random) -> PlantParams {
        let friction = |random: &mut Random| FrictionShape {
            static_factor: [1.0, random.between(1.05, 2.0)][random.below(2)],
            speed_rad_s: random.log_between(0.01, 1.0),
            bristles: None,
        };
        let (motor_friction, load_friction) = (friction(random), friction(random));
        PlantParams {
            resistance_ohm: random.log_between(0.1, 3.0),
            inductance_h: random.log_between(1e-3, 2e-2),
            back_emf_v_s_per_rad: random.log_between(0.05, 1.5),
            torque_constant_nm_per_a: random.log_between(0.05, 2.0),
            pole_pairs: 4.0,
            motor_inertia_kgm2: random.log_between(1e-4, 2e-2),
            motor_viscous_nm_s_per_rad: random.log_between(1e-5, 1e-2),
            motor_coulomb_nm: random.log_between(0.01, 2.0),
            load_inertia_kgm2: random.log_between(1e-4, 5e-2),
            load_viscous_nm_s_per_rad: random.log_between(1e-5, 1e-2),
            load_coulomb_nm: random.log_between(0.01, 5.0),
            load_constant_nm: 0.0,
            stiffness_nm_per_rad: random.log_between(50.0, 3e4),
            damping_nm_s_per_rad: random.log_between(0.01, 3.0),
            half_gap_rad: 1e-3,
            gap_middle: 0.0,
            contact: ContactLaw::Linear,
            motor_friction,
            load_friction,
            curved: Curved::default(),
            current_limit_a: random.log_between(5.0, 50.0),
            period_s: random.log_between(3e-5, 1.3e-4),
        }
    }

    /// A state of a mode near to where its frictions change, and what is held.
    fn drawn(params: &PlantParams, mode: Mode, random: &mut Random) -> (Vector, Held) {
        let wave = |random: &mut Random| random.between(-1.0, 1.0);
        let slow = |mass: Mass, random: &mut Random| {
            let friction = mode.friction(mass);
            let speed_rad_s = random.log_between(1e-4, 1.0);
            let shape = params.friction(mass);
            friction.sign()
                * match friction {
                    Friction::Creeping(_) => shape.speed_rad_s * random.between(0.0, 1.0),
                    _ => shape.slow_rad_s() + speed_rad_s,
                }
        };
        let mut x = [0.0; 4];
        x[CURRENT] = params.current_limit_a * wave(random) * random.log_between(0.01, 1.0);
        x[MOTOR] = slow(Mass::Motor, random);
        x[LOAD] = slow(Mass::Load, random);
        let most = params.coulomb(Mass::Load).max(params.coulomb(Mass::Motor));
        x[PENETRATION] = 1.5 * most * wave(random) / params.stiffness_nm_per_rad;
        let held = Held {
            voltage: 300.0 * wave(random) * random.log_between(1e-3, 1.0),
            load_torque: most * wave(random) * random.log_between(0.01, 1.0),
        };
        (x, held)
    }

    #[test]
    fn where_the_cubics_are_quiet_no_friction_changes() {
        let mut random = Random::new(118_119);
        let (mut quiet, mut searched, mut in_vain) = (0, 0, [0; 2]);
        for _ in 0..400 {
            let params = drawn_params(&mut random);
            let margins = Margins::new(&params);
            if params.rate() * params.period_s > LARGEST_CUBIC_RATE {
                assert_eq!(margins.off_cubic, [f64::INFINITY; 2]);
                continue;
            }
            let plant = Plant::new(&params);
            for _ in 0..200 {
                let friction = |mass: Mass, random: &mut Random| {
                    let side = [Side::Negative, Side::Positive][random.below(2)];
                    match random.below(3) {
                        0 => Friction::Stuck,
                        1 if params.friction(mass).creeps() => Friction::Creeping(side),
                        _ => Friction::Sliding(side),
                    }
                };
                let mode = Mode {
                    contact: [Contact::Gap, Contact::Rigid][random.below(2)],
                    motor: friction(Mass::Motor, &mut random),
                    load: friction(Mass::Load, &mut random),
                };
                let (x, held) = drawn(&params, mode, &mut random);
                let (after, _) = plant.tables[mode.matrix()].step(
                    [
                        params.sliding_torque(Mass::Motor, mode.motor),
                        params.sliding_torque(Mass::Load, mode.load),
                    ],
                    &x,
                    &held,
                );
                let taylor = Taylor::new(&params, mode, &x, &held, params.period_s);
                let masses = [Mass::Motor, Mass::Load];
                let guards = masses.map(|mass| Guards::of_mass(&params, mode, mass, &held));
                // a thousand places of the exact solution
                let least = (0..=1000)
                    .map(|place| {
                        let (x, _) = taylor.at(f64::from(place) / 1000.0, params.period_s);
                        let value = |guard: &Guard| {
                            guard.offset + (0..4).map(|i| guard.row[i] * x[i]).sum::<f64>()
                        };
                        let all = guards.iter().flat_map(Guards::iter);
                        all.map(value).fold(f64::INFINITY, f64::min)
                    })
                    .fold(f64::INFINITY, f64::min);
                let near = margins.near(&params, mode, &held, &x, &after);
                let cheap = plant
                    .known(mode)
                    .keeps_frictions(&x, &after, held.load_torque);
                if near {
                    quiet += 1;
                    assert!(least > 0.0, "{least}: {params:?} {mode:?} {x:?} {held:?}");
                }
                if least > 0.0 {
                    searched += 1;
                    in_vain[0] += u32::from(!cheap);
                    in_vain[1] += u32::from(!cheap && !near);
                }
            }
        }
        // of the steps in which nothing happens the cubics leave few to be searched
        assert!(quiet > 10_000, "{quiet}");
        assert!(
            4 * in_vain[1] < in_vain[0],
            "{in_vain:?} of {searched} searched in vain"
        );
    }
}
