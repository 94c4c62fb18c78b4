//! A two-mass axis with a gap under cascade control, integrated in tiny semi-implicit steps: a
//! source of logs that shares no code with the fit or with the axis crate.

pub mod ballscrew;
pub mod score;

use lostmotion_base::{Random, math};
use lostmotion_identify::{BacklashLog, FitSettings};

/// The axis; defaults are the published servo axis with its motor data, SI units at the motor
/// shaft.
#[derive(Clone, Copy)]
pub struct Rig {
    pub half_gap: f64,
    pub offset: f64,
    pub stiffness: f64,
    pub damping: f64,
    pub motor_inertia: f64,
    pub load_inertia: f64,
    pub motor_viscous: f64,
    pub torque_constant: f64,
    /// Coulomb friction of the load, N m.
    pub friction: f64,
    pub load_viscous: f64,
    /// Whether the contact can pull while separating.
    pub pulls: bool,
    /// Encoder counts per revolution on both sides; 0 for none.
    pub counts: u32,
    pub period: f64,
    /// Noise of the logged current, A.
    pub current_noise: f64,
    /// Longest and shortest move, s.
    pub moves: [f64; 2],
    pub seed: u64,
}

pub const RATED_TORQUE: f64 = 10.0;

impl Default for Rig {
    fn default() -> Self {
        Self {
            half_gap: 6.283e-3,
            offset: 0.0,
            stiffness: 2000.0,
            damping: 0.8,
            motor_inertia: 0.00189,
            load_inertia: 0.0065,
            motor_viscous: 0.01,
            torque_constant: 1.08,
            friction: 0.0,
            load_viscous: 0.0,
            pulls: false,
            counts: 1 << 20,
            period: 250e-6,
            current_noise: 0.0,
            moves: [0.1, 0.5],
            seed: 1,
        }
    }
}

/// Minimum-jerk moves of random length and duration, now and then with a rest.
struct Motion {
    start: f64,
    from: f64,
    distance: f64,
    duration: f64,
    rest: f64,
}

impl Motion {
    fn next(&mut self, random: &mut Random, moves: [f64; 2]) {
        self.start += self.duration + self.rest;
        self.from += self.distance;
        self.duration = random.between(moves[0], moves[1]);
        // at most 5.77 D/T^2 = 600 rad/s^2 and 1.875 D/T = 60 rad/s
        let most = (600.0 * self.duration * self.duration / 5.77).min(60.0 * self.duration / 1.875);
        let back = if self.from.abs() < 1e-9 {
            random.unit() < 0.5
        } else {
            self.from > 0.0
        };
        self.distance = random.between(0.3, 1.0) * if back { -most } else { most };
        self.rest = if random.unit() < 0.3 {
            random.between(0.0, 0.1)
        } else {
            0.0
        };
    }

    /// Position and velocity at a time.
    fn at(&self, t: f64) -> (f64, f64) {
        let x = ((t - self.start) / self.duration).clamp(0.0, 1.0);
        let position = self.from + self.distance * x * x * x * (10.0 - 15.0 * x + 6.0 * x * x);
        (
            position,
            self.distance / self.duration * 30.0 * x * x * (1.0 - 2.0 * x + x * x),
        )
    }
}

impl Rig {
    /// An axis of any gap, friction, inertia and noise; 2^20 counts.
    pub fn random(seed: u64) -> Rig {
        let mut random = Random::new(seed);
        Rig {
            half_gap: 6e-4 * math::pow(100.0, random.unit()),
            friction: RATED_TORQUE * random.between(0.0, 0.3),
            load_inertia: 0.00189 * random.between(0.5, 8.0),
            current_noise: random.between(0.0, 0.02),
            pulls: random.unit() < 0.5,
            seed: seed + 5000,
            ..Rig::default()
        }
    }

    pub fn settings(&self) -> FitSettings {
        let mut settings = FitSettings::new(self.torque_constant, Some(self.motor_inertia));
        settings.motor_viscous_nm_s_per_rad = self.motor_viscous;
        settings
    }

    fn contact_torque(&self, angle: f64, rate: f64) -> f64 {
        let angle = angle - self.offset;
        let side = angle.signum();
        let depth = angle.abs() - self.half_gap;
        if depth <= 0.0 {
            return 0.0;
        }
        let push = self.stiffness * depth + self.damping * rate * side;
        side * if self.pulls { push } else { push.max(0.0) }
    }

    /// Runs the axis for so long and returns its log.
    pub fn run(&self, duration: f64) -> BacklashLog {
        let mut random = Random::new(self.seed);
        let steps = (self.period / 10e-6).round().max(1.0);
        let dt = self.period / steps;
        let mut motion = Motion {
            start: 0.0,
            from: 0.0,
            distance: 0.0,
            duration: 0.0,
            rest: 0.0,
        };
        let (mut theta_m, mut w_m, mut theta_l, mut w_l) = (self.offset, 0.0_f64, 0.0, 0.0_f64);
        let (mut current, mut integral) = (0.0_f64, 0.0);
        let (mut motor, mut load, mut currents) = (vec![], vec![], vec![]);
        for k in 0..(duration / self.period) as usize {
            let t = k as f64 * self.period;
            if t >= motion.start + motion.duration + motion.rest {
                motion.next(&mut random, self.moves);
            }
            motor.push(self.read(theta_m));
            load.push(self.read(theta_l));
            currents.push(current + self.current_noise * random.normal());
            let (position, velocity) = motion.at(t);
            let error = 25.0 * (position - theta_m) + velocity - w_m;
            integral += error * self.period / 8.6e-3;
            integral = integral.clamp(-15.0, 15.0);
            let wanted = (1.74 * (error + integral)).clamp(-30.0, 30.0);
            for _ in 0..steps as usize {
                current += (wanted - current) * dt / 3e-4;
                let torque = self.contact_torque(theta_m - theta_l, w_m - w_l);
                w_m += dt / self.motor_inertia
                    * (self.torque_constant * current - self.motor_viscous * w_m - torque);
                let free = w_l + dt / self.load_inertia * (torque - self.load_viscous * w_l);
                let held = dt / self.load_inertia * self.friction;
                w_l = free.signum() * (free.abs() - held).max(0.0);
                theta_m += dt * w_m;
                theta_l += dt * w_l;
            }
        }
        BacklashLog::new(self.period, motor, load, currents).unwrap()
    }

    fn read(&self, angle: f64) -> f64 {
        if self.counts == 0 {
            return angle;
        }
        let step = 2.0 * std::f64::consts::PI / f64::from(self.counts);
        (angle / step).floor() * step
    }
}
