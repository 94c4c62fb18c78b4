//! For the tests of drive, methods and analysis: motions with closed forms, axes of a mill, and a
//! short way to run an axis along a motion.
#![allow(
    clippy::expect_used,
    clippy::missing_panics_doc,
    reason = "for tests alone"
)]

use lostmotion_base::math;
use lostmotion_drive::{AxisOutput, AxisRunner, Setpoint};
use lostmotion_methods::{AxisConfig, build_runner};

/// Position, velocity, acceleration at a time in s.
pub type Motion<'a> = &'a dyn Fn(f64) -> (f64, f64, f64);

/// A rest-to-rest move of constant jerk pieces that reaches its velocity and acceleration limits.
#[derive(Clone, Copy, Debug)]
pub struct Move {
    /// Signed way, in the axis' unit.
    pub distance: f64,
    /// Limit of the velocity, per s.
    pub velocity: f64,
    /// Limit of the acceleration, per s2.
    pub acceleration: f64,
    /// Limit of the jerk, per s3.
    pub jerk: f64,
}

impl Move {
    /// Durations of the seven pieces and their jerks.
    fn pieces(&self) -> [(f64, f64); 7] {
        // Durations of constant jerk, constant acceleration and cruise.
        let tj = self.acceleration / self.jerk;
        let ta = self.velocity / self.acceleration - tj;
        let cruise = self.distance.abs() / self.velocity - (ta + 2.0 * tj);
        assert!(
            ta >= 0.0 && cruise >= 0.0,
            "the move does not reach its limits"
        );
        let j = self.jerk * self.distance.signum();
        [
            (tj, j),
            (ta, 0.0),
            (tj, -j),
            (cruise, 0.0),
            (tj, -j),
            (ta, 0.0),
            (tj, j),
        ]
    }

    /// From rest to rest, s.
    pub fn duration(&self) -> f64 {
        self.pieces().iter().map(|piece| piece.0).sum()
    }

    /// Position, velocity, acceleration at a time in s.
    pub fn at(&self, mut t: f64) -> (f64, f64, f64) {
        let (mut p, mut v, mut a) = (0.0, 0.0, 0.0);
        if t <= 0.0 {
            return (0.0, 0.0, 0.0);
        }
        if t >= self.duration() {
            return (self.distance, 0.0, 0.0);
        }
        // Each piece is integrated to its end, the last one up to t.
        for (i, (span, j)) in self.pieces().into_iter().enumerate() {
            let dt = t.min(span);
            // exact zero on the cruise, as a planner gives it
            let a0 = if i == 3 { 0.0 } else { a };
            p += v * dt + a0 * dt * dt / 2.0 + j * dt * dt * dt / 6.0;
            v += a0 * dt + j * dt * dt / 2.0;
            a = a0 + j * dt;
            t -= dt;
            if t <= 0.0 {
                break;
            }
        }
        (p, v, a)
    }
}

/// There, a rest, back, a rest.
pub fn there_and_back(forward: Move, rest: f64, t: f64) -> (f64, f64, f64) {
    let half = forward.duration() + rest;
    if t < half {
        forward.at(t)
    } else {
        // The way back is the forward move mirrored, from its end on.
        let back = Move {
            distance: -forward.distance,
            ..forward
        };
        let (p, v, a) = back.at(t - half);
        (forward.distance + p, v, a)
    }
}

/// The paper's kind of move: 0 -> 20 rad at 40 rad/s, 400 rad/s2, 8000 rad/s3.
pub const PAPER_MOVE: Move = Move {
    distance: 20.0,
    velocity: 40.0,
    acceleration: 400.0,
    jerk: 8000.0,
};

/// `radius (1 - cos(w t))`: starts without velocity, but with acceleration.
pub fn circle(radius: f64, w: f64, t: f64) -> (f64, f64, f64) {
    let (s, c) = math::sin_cos(w * t);
    (radius * (1.0 - c), radius * w * s, radius * w * w * c)
}

/// Radial error of two like axes on a circle of `radius` mm at `feed` mm/min, entered smoothly from
/// rest: rms and max over all but the first turn, um.
pub fn circle_error(config: &AxisConfig, method: &str, radius: f64, feed: f64) -> [f64; 2] {
    let w = feed / 60.0 / radius;
    let angle = |t: f64| {
        // Angle with a smooth start: the angular velocity rises over 0.2 s as 3 u^2 - 2 u^3.
        let (rise, t) = (0.2, t - 0.1);
        let u = (t / rise).clamp(0.0, 1.0);
        let way = rise * (u * u * u - 0.5 * u * u * u * u) + (t - rise).max(0.0);
        (
            w * way,
            w * (3.0 * u * u - 2.0 * u * u * u),
            w * 6.0 * (u - u * u) / rise,
        )
    };
    // Each axis by the chain rule through the angle.
    let x = |t: f64| {
        let ((q, v, a), r) = (angle(t), radius);
        let (s, c) = math::sin_cos(q);
        (r * (1.0 - c), r * s * v, r * (c * v * v + s * a))
    };
    let y = |t: f64| {
        let ((q, v, a), r) = (angle(t), radius);
        let (s, c) = math::sin_cos(q);
        (r * s, r * c * v, r * (c * a - s * v * v))
    };
    let seconds = 3.0 * std::f64::consts::TAU / w;
    // Two like axes, run one by one; the first turn is left out.
    let (xs, ys) = (
        run(config, method, &x, seconds).load,
        run(config, method, &y, seconds).load,
    );
    // Radial error: distance from the circle's centre, which lies at X = radius, less the radius.
    let error =
        |(x, y): (&f64, &f64)| (((radius - x) * (radius - x) + y * y).sqrt() - radius) * 1e3;
    let errors: Vec<f64> = xs.iter().zip(&ys).skip(xs.len() / 3).map(error).collect();
    [rms(errors.iter().copied()), max_abs(errors)]
}

/// The setpoints of a motion at 1 ms.
pub fn setpoints(motion: Motion, seconds: f64) -> Vec<Setpoint> {
    let count = (seconds * 1000.0).round() as usize;
    (0..count)
        .map(|n| {
            // Times are counted, not accumulated.
            let (position, velocity, acceleration) = motion(n as f64 * 1e-3);
            Setpoint::moving(position, velocity, acceleration)
        })
        .collect()
}

/// An axis with the method of a name, standing still.
pub fn runner(config: &AxisConfig, method: &str, start: f64) -> Box<dyn AxisRunner> {
    let method = method.parse().expect("a method");
    build_runner(config, method, start).expect("a good axis")
}

/// Runs an axis from rest at the motion's start, with a trace.
pub fn run(config: &AxisConfig, method: &str, motion: Motion, seconds: f64) -> AxisOutput {
    let mut runner = runner(config, method, motion(0.0).0);
    let mut out = AxisOutput::new(true);
    runner
        .push(&setpoints(motion, seconds), &mut out)
        .expect("good setpoints");
    out
}

/// Root mean square.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for value in values {
        sum += value * value;
        count += 1.0;
    }
    (sum / f64::max(count, 1.0)).sqrt()
}

/// Largest magnitude.
pub fn max_abs(values: impl IntoIterator<Item = f64>) -> f64 {
    values
        .into_iter()
        .fold(0.0, |max: f64, value| max.max(value.abs()))
}

/// Reference minus load, in the axis' unit.
pub fn errors(out: &AxisOutput) -> Vec<f64> {
    out.reference
        .iter()
        .zip(&out.load)
        .map(|(r, l)| r - l)
        .collect()
}

/// An axis of a mid-size mill, tuned by the library's rule: 10 mm lead, 350 kg, 10 um gap; friction
/// as given.
pub fn mill(coulomb_n: f64, viscous_n_s_per_m: f64) -> AxisConfig {
    use lostmotion_drive::config::{Drive, Linear, Load, Motor, Slide, Transmission, Tuning};
    let transmission = Transmission::Linear(Linear {
        lead_mm: 10.0,
        gear: 1.0,
    });
    let motor = Motor {
        resistance_ohm: 0.6,
        inductance_h: 6e-3,
        poles: 8,
        inertia_kgm2: 0.0026,
        torque_constant_nm_per_a: 0.9,
        rated_torque_nm: 11.0,
        viscous_nm_s_per_rad: 0.002,
        coulomb_nm: 0.0,
    };
    let load = Load::Slide(Slide {
        mass_kg: 350.0,
        screw_inertia_kgm2: 0.0012,
        viscous_n_s_per_m,
        coulomb_n,
        constant_n: 0.0,
        stiffness_n_per_um: 120.0,
        damping_n_s_per_mm: 30.0,
        gap_um: 10.0,
        scale_um: 0.0,
    });
    let drive = Drive::tuned(
        &motor,
        &load.reflected(&transmission),
        &Tuning::default(),
        60.0,
        560.0,
    );
    AxisConfig {
        transmission,
        motor,
        load,
        drive,
        ..AxisConfig::paper()
    }
}

/// The X axis of a vertical mill (screw 40 x 16 mm, 300 kg, 238 N/um), load friction as part of the
/// rated torque, total gap in um.
pub fn mill_x(friction_share: f64, gap_um: f64, counts: Option<u32>) -> AxisConfig {
    use lostmotion_drive::config::{Drive, Linear, Load, Motor, Slide, Transmission};
    let motor = Motor {
        viscous_nm_s_per_rad: 0.002,
        coulomb_nm: 0.15,
        ..AxisConfig::paper().motor
    };
    let load = Load::Slide(Slide {
        mass_kg: 300.0,
        screw_inertia_kgm2: 0.00198,
        viscous_n_s_per_m: 500.0,
        // Torque at the motor to force at the nut: 2 pi over the lead.
        coulomb_n: friction_share * motor.rated_torque_nm / (0.016 / std::f64::consts::TAU),
        constant_n: 0.0,
        stiffness_n_per_um: 238.0,
        damping_n_s_per_mm: 22.0,
        gap_um,
        scale_um: 0.1,
    });
    let drive = Drive {
        current_gain_v_per_a: 11.31,
        current_time_s: 0.01071,
        velocity_gain_a_s_per_rad: 2.702,
        velocity_time_s: 0.007943,
        position_gain_per_s: 62.8,
        velocity_feedforward: 1.0,
        acceleration_feedforward: 1.0,
        told_inertia_kgm2: None,
        current_limit_a: 28.0,
        bus_voltage_v: 560.0,
        encoder_counts_per_rev: counts,
        current_period_us: None,
        voltage_delay_periods: 1,
        ..AxisConfig::paper().drive
    };
    AxisConfig {
        transmission: Transmission::Linear(Linear {
            lead_mm: 16.0,
            gear: 1.0,
        }),
        motor,
        load,
        drive,
        ..AxisConfig::paper()
    }
}

/// What the gap does to the load on a sine, over the last three eighths of `turns`: rms and
/// max, in the axis' unit times 1e3.
pub fn lost_on_a_sine(
    config: &AxisConfig,
    method: &str,
    radius: f64,
    w: f64,
    turns: f64,
) -> [f64; 2] {
    let seconds = turns * std::f64::consts::TAU / w;
    let motion = |t: f64| circle(radius, w, t);
    // The same axis without a gap: the difference is what the gap does.
    let rigid = run(&config.without_gap(), "none", &motion, seconds);
    let out = run(config, method, &motion, seconds);
    // The transient of the start is left out.
    let lost: Vec<f64> = out
        .load
        .iter()
        .zip(&rigid.load)
        .skip(out.load.len() * 5 / 8)
        .map(|(a, b)| (a - b) * 1e3)
        .collect();
    [rms(lost.iter().copied()), max_abs(lost)]
}

/// Both figures over those of `none`.
pub fn ratio_on_a_sine(
    config: &AxisConfig,
    method: &str,
    radius: f64,
    w: f64,
    turns: f64,
) -> [f64; 2] {
    // The same axis and motion with the method and without any.
    let [with, without] =
        [method, "none"].map(|method| lost_on_a_sine(config, method, radius, w, turns));
    [with[0] / without[0], with[1] / without[1]]
}
