//! The motion that an axis is commissioned with: a minute that shows inertia, friction and gap to
//! whoever sees the motor alone.
//!
//! 1. Long strokes there and back at a slow, a medium and a fast feed: viscous and Coulomb friction
//!    in both directions, inertia while they speed up and slow down.
//! 2. Swings, as on circles, from gentle to hard: the flank changes at every reversal, at a known
//!    acceleration and without a rest.
//! 3. Short strokes with rests, from gentle to hard: as programs with pauses and corners.
//! 4. Swings again, with a load that is known by then.
//!
//! ```text
//! stroke   S-curve of constant jerk from rest to rest, 2 (v/a + a/j) long where it reaches the speed
//! swing    x = A (1 - cos phi),  phi' = w (3 u^2 - 2 u^3) up to w and down again    peak acceleration A w^2
//! ```

use lostmotion_base::{AxisLimits, math};
use lostmotion_drive::Setpoint;
use lostmotion_drive::config::AxisUnit;
use std::f64::consts::TAU;

/// Largest total gap that is supposed, rad at the motor: more than `adaptive` looks for.
const SUPPOSED_GAP_RAD: f64 = 0.6;
/// Short strokes and swings over that gap, peak to peak. A choice: several gaps, so that the load
/// is carried most of the way.
const SHORT_GAPS: f64 = 4.0;
/// Longest stroke, in short ones. A choice.
const LONG_SHORTS: f64 = 15.0;
/// Part of the travel that is used at most: the ends stay clear.
const TRAVEL_SHARE: f64 = 0.8;
/// Part of the limits of speed, acceleration and jerk that the motion uses.
const LIMIT_SHARE: f64 = 0.9;

/// A part of the motion, limits as parts of the axis' own.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Phase {
    /// There and back, some times, with a rest at each end.
    Strokes {
        long: bool,
        speed: f64,
        acceleration: f64,
        rest_s: f64,
        count: u32,
    },
    /// Periods of a swing.
    Swings { acceleration: f64, count: u32 },
}

const fn strokes(long: bool, speed: f64, acceleration: f64, rest_s: f64, count: u32) -> Phase {
    Phase::Strokes {
        long,
        speed,
        acceleration,
        rest_s,
        count,
    }
}

const fn swings(acceleration: f64, count: u32) -> Phase {
    Phase::Swings {
        acceleration,
        count,
    }
}

/// The whole motion.
const PHASES: [Phase; 14] = [
    strokes(true, 0.05, 0.3, 0.2, 1),
    strokes(true, 0.2, 0.6, 0.2, 2),
    strokes(true, 0.6, 1.0, 0.2, 3),
    swings(0.01, 2),
    swings(0.04, 4),
    swings(0.15, 8),
    swings(0.5, 10),
    strokes(false, 0.02, 0.1, 0.3, 2),
    strokes(false, 0.1, 0.3, 0.3, 3),
    strokes(false, 0.5, 1.0, 0.3, 4),
    swings(0.02, 3),
    swings(0.08, 6),
    swings(0.3, 10),
    strokes(true, 0.3, 0.8, 0.1, 1),
];

/// A part of the motion as a control takes it: places from the start of the motion, speeds per s.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Segment {
    /// Standing still, s.
    Rest(f64),
    /// To a place, at a speed.
    Stroke { to: f64, speed: f64 },
    /// Periods up from a place and back, at an angular rate, rad/s.
    Swing {
        amplitude: f64,
        rate: f64,
        count: u32,
    },
}

/// Longest time of a stroke one way or of a period of a swing, s. A choice: slow axes would take
/// hours otherwise.
const MOST_S: f64 = 4.0;
/// Parts of the limits of acceleration and jerk that a swing at its rate may take: while the rate
/// rises both are larger. Derived: the acceleration by a quarter, the jerk threefold at most.
const RAMP_SHARES: [f64; 2] = [0.8, 0.3];
/// Rest before the first and after the last move, s.
const REST_S: f64 = 0.5;

/// A part of the motion as a drive takes it, places from the start of the motion.
enum Move {
    /// Standing at a place.
    Rest { place: f64, seconds: f64 },
    /// From a place to another, at this speed where it is reached.
    Stroke {
        from: f64,
        to: f64,
        speed: f64,
        stroke: Stroke,
    },
    /// Up from the start and back, some times.
    Swing(Swing),
}

/// What a motion is made for: limits and travel in the axis' unit, how far the motor turns for one
/// unit (rad), and the command cycle (s).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Travel, speed, acceleration, jerk.
    pub limits: AxisLimits,
    /// Unit of the axis.
    pub unit: AxisUnit,
    /// Motor angle of one unit, rad.
    pub motor_rad_per_unit: f64,
    /// Command cycle, s.
    pub cycle_s: f64,
}

impl Bounds {
    /// Lengths of short and long strokes, in the axis' unit.
    fn lengths(&self) -> [f64; 2] {
        let room = TRAVEL_SHARE * (self.limits.max - self.limits.min);
        let short = SHORT_GAPS * SUPPOSED_GAP_RAD / self.motor_rad_per_unit;
        [short.min(room), (LONG_SHORTS * short).min(room)]
    }

    /// Where the motion begins: strokes go up from here, within the travel.
    pub fn start(&self) -> f64 {
        let [_, long] = self.lengths();
        0.5 * (self.limits.min + self.limits.max) - 0.5 * long
    }

    /// Whether the axis counts in rad.
    pub(super) fn is_in_rad(&self) -> bool {
        self.unit == AxisUnit::Rad
    }

    /// The parts of the motion in their order, places from [`Bounds::start`].
    pub(super) fn segments(&self) -> Vec<Segment> {
        let mut out = Vec::new();
        self.each_move(|part| match part {
            // A cycle between two parts is none of a program's.
            Move::Rest { seconds: 0.0, .. } => {}
            Move::Rest { seconds, .. } => out.push(Segment::Rest(seconds)),
            Move::Stroke { to, speed, .. } => out.push(Segment::Stroke { to, speed }),
            Move::Swing(swing) => out.push(Segment::Swing {
                amplitude: swing.amplitude,
                rate: swing.rate,
                count: swing.count,
            }),
        });
        out
    }

    /// Length of the whole motion, s: a minute, more on an axis that is slow beside the largest gap
    /// that is looked for.
    pub fn duration_s(&self) -> f64 {
        let mut cycles = 0;
        self.each_move(|part| cycles += self.cycles_of(&part));
        cycles as f64 * self.cycle_s
    }

    /// The setpoints of the whole motion, one a command cycle.
    pub fn setpoints(&self) -> Vec<Setpoint> {
        let mut out = Vec::new();
        self.each_move(|part| {
            let at = |cycle: usize| cycle as f64 * self.cycle_s;
            let setpoint = |cycle: usize| match &part {
                Move::Rest { place, .. } => Setpoint::moving(*place, 0.0, 0.0),
                Move::Stroke {
                    from, to, stroke, ..
                } => {
                    let ([p, v, a], sign) = (stroke.at(at(cycle)), (to - from).signum());
                    Setpoint::moving(from + sign * p, sign * v, sign * a)
                }
                Move::Swing(swing) => {
                    let [p, v, a] = swing.at(at(cycle));
                    Setpoint::moving(p, v, a)
                }
            };
            out.extend((0..self.cycles_of(&part)).map(setpoint));
        });
        let start = self.start();
        for setpoint in &mut out {
            setpoint.position += start;
        }
        out
    }

    /// Command cycles of a part of the motion: up to before its end, of a rest one at least.
    fn cycles_of(&self, part: &Move) -> usize {
        match part {
            Move::Rest { seconds, .. } => ((seconds / self.cycle_s).round() as usize).max(1),
            Move::Stroke { stroke, .. } => (stroke.duration() / self.cycle_s).ceil() as usize,
            Move::Swing(swing) => (swing.duration() / self.cycle_s).ceil() as usize,
        }
    }

    /// Calls `each` with the parts of the motion in their order.
    fn each_move(&self, mut each: impl FnMut(Move)) {
        let [short, long] = self.lengths();
        let rest = |place: f64, seconds: f64| Move::Rest { place, seconds };
        each(rest(0.0, REST_S));
        for phase in PHASES {
            match phase {
                Phase::Strokes {
                    long: is_long,
                    speed,
                    acceleration,
                    rest_s,
                    count,
                } => {
                    let length = if is_long { long } else { short };
                    let speed = self.speed(length, speed);
                    let stroke = self.stroke(length, speed, acceleration);
                    for _ in 0..count {
                        for (from, to) in [(0.0, length), (length, 0.0)] {
                            each(Move::Stroke {
                                from,
                                to,
                                speed,
                                stroke,
                            });
                            each(rest(to, rest_s));
                        }
                    }
                }
                Phase::Swings {
                    acceleration,
                    count,
                } => {
                    each(Move::Swing(self.swing(0.5 * short, acceleration, count)));
                    each(rest(0.0, 0.0));
                }
            }
        }
        each(rest(0.0, REST_S));
    }

    /// The speed of a stroke: slow enough for the limits, fast enough for the time.
    fn speed(&self, length: f64, share: f64) -> f64 {
        let fastest = LIMIT_SHARE * self.limits.velocity;
        (share * fastest).max(length / MOST_S).min(fastest)
    }

    fn stroke(&self, length: f64, speed: f64, acceleration: f64) -> Stroke {
        let limits = &self.limits;
        Stroke::new(
            length,
            speed,
            LIMIT_SHARE * acceleration * limits.acceleration,
            LIMIT_SHARE * limits.jerk,
        )
    }

    fn swing(&self, amplitude: f64, acceleration: f64, count: u32) -> Swing {
        let limits = &self.limits;
        let bound = |limit: f64| LIMIT_SHARE * limit / amplitude;
        // the least of what acceleration, speed and jerk allow, with room for the ramps of the rate
        let rate = (acceleration * bound(limits.acceleration)).sqrt();
        let fastest = bound(limits.velocity)
            .min((RAMP_SHARES[0] * bound(limits.acceleration)).sqrt())
            .min(math::cbrt(RAMP_SHARES[1] * bound(limits.jerk)));
        Swing {
            amplitude,
            rate: rate.max(TAU / MOST_S).min(fastest),
            count,
        }
    }
}

/// From rest to rest.
#[derive(Clone, Copy, Debug)]
struct Stroke {
    length: f64,
    jerk: f64,
    /// Times of constant jerk, constant acceleration and constant speed, s.
    times: [f64; 3],
}

impl Stroke {
    fn new(length: f64, speed: f64, acceleration: f64, jerk: f64) -> Stroke {
        // times of constant jerk and acceleration up to a speed
        let ramp = |speed: f64| {
            if speed * jerk < acceleration * acceleration {
                [(speed / jerk).sqrt(), 0.0]
            } else {
                [
                    acceleration / jerk,
                    speed / acceleration - acceleration / jerk,
                ]
            }
        };
        let way = |speed: f64| {
            let [jerked, held] = ramp(speed);
            speed * (2.0 * jerked + held)
        };
        let mut top = speed;
        if way(speed) > length {
            // the way of both ramps grows with the speed: bisection to the last bit that matters
            let (mut low, mut high) = (0.0, speed);
            for _ in 0..60 {
                top = 0.5 * (low + high);
                if way(top) > length {
                    high = top;
                } else {
                    low = top;
                }
            }
            top = low;
        }
        let [jerked, held] = ramp(top);
        let cruise = if top > 0.0 {
            ((length - way(top)) / top).max(0.0)
        } else {
            0.0
        };
        Stroke {
            length,
            jerk,
            times: [jerked, held, cruise],
        }
    }

    fn duration(&self) -> f64 {
        let [jerked, held, cruise] = self.times;
        2.0 * (2.0 * jerked + held) + cruise
    }

    /// Way, speed, acceleration at a time, s.
    fn at(&self, time: f64) -> [f64; 3] {
        let [jerked, held, cruise] = self.times;
        let pieces = [
            (jerked, self.jerk),
            (held, 0.0),
            (jerked, -self.jerk),
            (cruise, 0.0),
            (jerked, -self.jerk),
            (held, 0.0),
            (jerked, self.jerk),
        ];
        if time >= self.duration() {
            return [self.length, 0.0, 0.0];
        }
        let (mut p, mut v, mut a, mut left) = (0.0, 0.0, 0.0, time.max(0.0));
        for (index, (span, jerk)) in pieces.into_iter().enumerate() {
            let t = left.min(span);
            // an exact zero where the speed is constant
            let start = if index == 3 { 0.0 } else { a };
            p += t * (v + t * (0.5 * start + t * jerk / 6.0));
            v += t * (start + 0.5 * t * jerk);
            a = start + t * jerk;
            left -= t;
            if left <= 0.0 {
                break;
            }
        }
        [p, v, a]
    }
}

/// To and fro like an axis on a circle.
#[derive(Clone, Copy, Debug)]
struct Swing {
    amplitude: f64,
    /// Angle a second, rad/s.
    rate: f64,
    /// Whole periods, with those in which it gets going and comes to rest.
    count: u32,
}

impl Swing {
    /// Time of a ramp of the rate, s: it turns by half a period.
    fn ramp(&self) -> f64 {
        TAU / self.rate
    }

    fn duration(&self) -> f64 {
        // both ramps turn half a period each
        2.0 * self.ramp() + f64::from(self.count.saturating_sub(1)) * TAU / self.rate
    }

    /// Way, speed, acceleration at a time, s.
    fn at(&self, time: f64) -> [f64; 3] {
        let (ramp, whole) = (self.ramp(), self.duration());
        if time >= whole {
            return [0.0; 3];
        }
        // angle, its rate and the rate's rate: the end mirrors the start
        let begin = |t: f64| {
            let u = (t / ramp).clamp(0.0, 1.0);
            [
                self.rate * ramp * (u * u * u - 0.5 * u * u * u * u)
                    + self.rate * (t - ramp).max(0.0),
                self.rate * (3.0 - 2.0 * u) * u * u,
                self.rate / ramp * 6.0 * u * (1.0 - u),
            ]
        };
        let [angle, rate, change] = if time < 0.5 * whole {
            begin(time)
        } else {
            let [angle, rate, change] = begin(whole - time);
            [f64::from(self.count) * TAU - angle, rate, -change]
        };
        let (sin, cos) = math::sin_cos(angle);
        [
            self.amplitude * (1.0 - cos),
            self.amplitude * sin * rate,
            self.amplitude * (cos * rate * rate + sin * change),
        ]
    }
}
