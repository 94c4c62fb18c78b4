//! What the control watches while a method runs: following error, travel and overload of every
//! motor, once a command cycle. Past a limit the machine stops.

use super::frame::Frame;
use super::outputs::Outputs;
use crate::machine::{Machine, MachineAxis, MonitorLimits, OverloadLimit};
use crate::method::Choice;
use crate::results::{LimitsUsed, StopLimit};
use lostmotion_base::{BlockRef, Tick, math};
use lostmotion_drive::Monitored;
use lostmotion_methods::AxisConfig;

/// A stop, in the units of its axis.
#[derive(Clone, Debug)]
pub(crate) struct Stop {
    /// Place of the motor among the drives: the axes, then the second motor of a gantry.
    pub(crate) drive: usize,
    /// The limit that was passed.
    pub(crate) limit: StopLimit,
    /// What it was, and what is allowed.
    pub(crate) value: f64,
    pub(crate) allowed: f64,
    /// When, counted as the frames are.
    pub(crate) tick: Tick,
    pub(crate) block: BlockRef,
    /// Commanded tip from the program's zero, mm, once it is known.
    pub(crate) at_mm: [f64; 3],
    /// All motors of the machine then.
    pub(crate) drives: Vec<Monitored>,
}

/// Watches the motors of one variant of the machine.
#[derive(Debug)]
pub(crate) struct Monitor {
    motors: Vec<MotorMonitor>,
    servo_ticks: usize,
}

impl Monitor {
    /// Of a machine at rest with a compensator, its motors cold.
    pub(crate) fn new(machine: &Machine, choice: &Choice) -> Monitor {
        let period_s = machine.cycles().command().period_s();
        let servo_ticks = machine.cycles().servo_ticks();
        let firsts = machine.axes().iter().map(|axis| (axis, &axis.config));
        let second = machine
            .gantry()
            .and_then(|gantry| Some((machine.axis(gantry.axis)?, &gantry.second)));
        let motor = |(axis, config): (&MachineAxis, &AxisConfig)| MotorMonitor {
            knows_correction: choice.told_gap(config),
            ..MotorMonitor::new(axis.monitor_limits_of(config), period_s, servo_ticks as u64)
        };
        Monitor {
            motors: firsts.chain(second).map(motor).collect(),
            servo_ticks,
        }
    }

    /// Looks at the frames of a chunk, at the last servo tick of each command cycle, as the control
    /// sees the motors. The first limit that one of them has passed, in the order of the axes; the
    /// tool's place is told by the judge.
    pub(crate) fn chunk(
        &mut self,
        frames: &[Frame],
        outputs: &Outputs,
        variant: usize,
    ) -> Option<Stop> {
        let servo_ticks = self.servo_ticks;
        let is_last = |frame: &&Frame| frame.servo_sample % servo_ticks == servo_ticks - 1;
        for frame in frames.iter().filter(is_last) {
            let stop = self.cycle(frame, outputs, variant);
            if stop.is_some() {
                return stop;
            }
        }
        None
    }

    /// The largest parts of its limits that a motor has used, by its place among the drives.
    pub(crate) fn used(&self, drive: usize) -> Option<LimitsUsed> {
        self.motors.get(drive).map(|motor| motor.used)
    }

    fn cycle(&mut self, frame: &Frame, outputs: &Outputs, variant: usize) -> Option<Stop> {
        let cycle = frame.servo_sample / self.servo_ticks;
        let seen = |drive: usize| outputs.of(variant, drive).monitored.get(cycle).copied();
        let mut passed = None;
        // Every motor takes the cycle, also behind one that is past a limit: heat is a sum.
        for (drive, motor) in self.motors.iter_mut().enumerate() {
            let Some(found) = seen(drive).and_then(|seen| motor.step(&seen)) else {
                continue;
            };
            passed = passed.or(Some((drive, found)));
        }
        let (
            drive,
            Passed {
                limit,
                value,
                allowed,
            },
        ) = passed?;
        Some(Stop {
            drive,
            limit,
            value,
            allowed,
            tick: frame.tick,
            block: frame.sample.block,
            at_mm: frame.pose.tip,
            drives: (0..self.motors.len()).filter_map(seen).collect(),
        })
    }
}

/// Keeps the larger one.
fn raise(most: &mut f64, value: f64) {
    if value > *most {
        *most = value;
    }
}

/// A limit that was passed.
struct Passed {
    limit: StopLimit,
    value: f64,
    allowed: f64,
}

/// Watches one motor.
#[derive(Debug)]
struct MotorMonitor {
    limits: MonitorLimits,
    period_s: f64,
    /// Part of the way to its new warmth that the motor goes in a command cycle.
    warming: f64,
    /// Warmth: 1 is that of the continuous current.
    heat: f64,
    last_reference: Option<f64>,
    servo_ticks: u64,
    /// Whether the correction is the control's own amount, a told gap, which it takes off.
    knows_correction: bool,
    /// The largest parts of the limits so far.
    used: LimitsUsed,
    /// Servo ticks at a limit up to the last cycle, and the cycles in a row of nothing else.
    saturated_samples: u64,
    limited_cycles: u64,
}

impl MotorMonitor {
    fn new(limits: MonitorLimits, period_s: f64, servo_ticks: u64) -> MotorMonitor {
        // The first-order lag over a cycle with the current held, exactly: 1 - exp(-h/T).
        let warming = limits
            .overload
            .map_or(0.0, |overload| -math::expm1(-period_s / overload.time_s));
        MotorMonitor {
            limits,
            period_s,
            warming,
            heat: 0.0,
            last_reference: None,
            used: LimitsUsed::default(),
            servo_ticks,
            knows_correction: false,
            saturated_samples: 0,
            limited_cycles: 0,
        }
    }

    /// Takes a command cycle. Comparisons are written so that what is not a number is past its
    /// limit.
    fn step(&mut self, seen: &Monitored) -> Option<Passed> {
        let passed = |limit, value, allowed| {
            Some(Passed {
                limit,
                value,
                allowed,
            })
        };
        let last = self.last_reference.replace(seen.reference);
        let way = seen.reference - last.unwrap_or(seen.reference);
        if let Some(OverloadLimit { continuous_a, .. }) = self.limits.overload {
            let ratio = seen.current_squared / (continuous_a * continuous_a);
            self.heat += self.warming * (ratio - self.heat);
        }
        let limited = seen
            .saturated_samples
            .saturating_sub(self.saturated_samples);
        self.saturated_samples = seen.saturated_samples;
        // One servo tick within the limits is a break.
        self.limited_cycles = if limited >= self.servo_ticks {
            self.limited_cycles + 1
        } else {
            0
        };
        let within = |value: f64, low: f64, high: f64| value >= low && value <= high;
        if let Some(limit) = self.limits.following {
            // The mean speed of the cycle.
            let allowed = limit.at(way / self.period_s);
            let own = if self.knows_correction {
                seen.correction
            } else {
                0.0
            };
            let error = seen.reference + own - seen.motor;
            raise(&mut self.used.following_error, error.abs() / allowed);
            if !within(error, -allowed, allowed) {
                return passed(StopLimit::FollowingError, error, allowed);
            }
        }
        if let Some([low, high]) = self.limits.travel {
            let from_middle = (seen.motor - 0.5 * (low + high)).abs();
            raise(&mut self.used.travel, from_middle / (0.5 * (high - low)));
            if !within(seen.motor, low, high) {
                let end = if seen.motor < low { low } else { high };
                return passed(StopLimit::Travel, seen.motor, end);
            }
        }
        if self.limits.overload.is_some() {
            raise(&mut self.used.overload, self.heat);
            if !within(self.heat, 0.0, 1.0) {
                return passed(StopLimit::Overload, self.heat, 1.0);
            }
        }
        if let Some(allowed) = self.limits.at_limit_s {
            let time_s = self.limited_cycles as f64 * self.period_s;
            raise(&mut self.used.at_limit, time_s / allowed);
            if !within(time_s, 0.0, allowed) {
                return passed(StopLimit::AtLimit, time_s, allowed);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::FollowingLimit;

    fn motor(limits: MonitorLimits) -> MotorMonitor {
        MotorMonitor::new(limits, 1e-3, 4)
    }

    const NOTHING: MonitorLimits = MonitorLimits {
        following: None,
        travel: None,
        overload: None,
        at_limit_s: None,
    };

    #[test]
    fn a_constant_current_trips_when_the_first_order_model_says() {
        for (ratio, time_s) in [(1.05, 4.0), (1.5, 20.0), (2.0, 20.0), (2.75, 3.0)] {
            let overload = OverloadLimit {
                continuous_a: 10.2,
                time_s,
            };
            let mut motor = motor(MonitorLimits {
                overload: Some(overload),
                ..NOTHING
            });
            let seen = Monitored {
                current_squared: (ratio * 10.2_f64) * (ratio * 10.2_f64),
                ..Monitored::default()
            };
            let cycles = (1..1_000_000)
                .find(|_| motor.step(&seen).is_some())
                .unwrap();
            // heat = i^2 (1 - exp(-t/T)) reaches 1
            let expected_s = -time_s * math::log(1.0 - 1.0 / (ratio * ratio));
            let found_s = f64::from(cycles) * 1e-3;
            assert!(
                found_s >= expected_s - 1e-9 && found_s < expected_s + 1e-3,
                "{ratio}: {found_s} for {expected_s}"
            );
        }
        let mut motor = motor(MonitorLimits {
            overload: Some(OverloadLimit {
                continuous_a: 10.0,
                time_s: 0.5,
            }),
            ..NOTHING
        });
        let seen = Monitored {
            current_squared: 100.0,
            ..Monitored::default()
        };
        assert!((0..100_000).all(|_| motor.step(&seen).is_none()));
    }

    #[test]
    fn the_limit_of_the_following_error_grows_with_speed() {
        let following = FollowingLimit {
            standstill: 0.5,
            full_speed: 2.0,
            speed: 400.0,
        };
        for (speed, allowed) in [(0.0, 0.5), (-100.0, 0.5), (200.0, 1.0), (-400.0, 2.0)] {
            assert_eq!(following.at(speed), allowed);
            for (part, trips) in [
                (0.999, false),
                (-0.999, false),
                (1.001, true),
                (-1.001, true),
            ] {
                let mut motor = motor(MonitorLimits {
                    following: Some(following),
                    ..NOTHING
                });
                let at = |reference: f64| Monitored {
                    reference,
                    motor: reference - part * allowed,
                    ..Monitored::default()
                };
                let still = Monitored::default();
                assert!(motor.step(&still).is_none());
                assert_eq!(
                    motor.step(&at(speed * 1e-3)).is_some(),
                    trips,
                    "{speed} {part}"
                );
            }
        }
    }

    #[test]
    fn the_amount_of_a_control_is_no_following_error() {
        let following = FollowingLimit {
            standstill: 0.02,
            full_speed: 0.02,
            speed: 5.0,
        };
        // A gap of 200 um taken up, and the motor at its place or off it.
        for (knows_correction, off, trips) in [
            (true, 0.0, false),
            (true, 0.019, false),
            (true, 0.021, true),
            (false, 0.0, true),
        ] {
            let mut motor = MotorMonitor {
                knows_correction,
                ..motor(MonitorLimits {
                    following: Some(following),
                    ..NOTHING
                })
            };
            let seen = Monitored {
                reference: 7.0,
                motor: 7.2 - off,
                correction: 0.2,
                ..Monitored::default()
            };
            assert_eq!(
                motor.step(&seen).is_some(),
                trips,
                "{knows_correction} {off}"
            );
        }
    }

    #[test]
    fn a_drive_at_its_limit_is_stopped_unless_there_is_a_break() {
        for (break_every, stops_at) in [(10_000, Some(251)), (252, Some(251)), (250, None)] {
            let mut motor = motor(MonitorLimits {
                at_limit_s: Some(0.25),
                ..NOTHING
            });
            let mut saturated_samples = 0;
            let found = (1..1000).find(|cycle| {
                // Three of four servo ticks are a break.
                saturated_samples += if cycle % break_every == 0 { 3 } else { 4 };
                let seen = Monitored {
                    saturated_samples,
                    ..Monitored::default()
                };
                motor.step(&seen).is_some()
            });
            assert_eq!(found, stops_at, "{break_every}");
        }
    }

    #[test]
    fn what_is_not_a_number_stops_the_machine() {
        let mut motor = motor(MonitorLimits {
            travel: Some([-1.0, 1.0]),
            ..NOTHING
        });
        let seen = Monitored {
            motor: f64::NAN,
            ..Monitored::default()
        };
        assert!(motor.step(&seen).is_some());
    }
}
