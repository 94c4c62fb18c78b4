//! Logs as a workshop records them: a ball screw with a gap under cascade control, random strokes,
//! 1 kHz, rounded encoder and scale, a noisy current, and the flaws of a real recorder (lost rows,
//! jitter, lateness) and of a real friction. Shares no code with the simulated axis.

use std::f64::consts::TAU;

use lostmotion_base::{Random, math};
use lostmotion_identify::{BacklashLog, FitError, FitSettings};

/// Friction of the load other than Coulomb and viscous.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Friction {
    /// Nothing else.
    Plain,
    /// Breakaway above sliding by this share, falling with speed.
    Stribeck(f64),
    /// Bristles: presliding over this many rad at the motor.
    Bristle(f64),
    /// Waves over the travel by this share.
    Wavy(f64),
    /// Larger in the positive than in the negative direction by this share.
    Uneven(f64),
}

/// A ball screw axis and its recorder; SI units at the motor shaft unless the name says else.
#[derive(Clone, Copy, Debug)]
pub struct BallScrew {
    pub lead_mm: f64,
    pub gap_um: f64,
    pub stiffness_n_per_um: f64,
    pub torque_constant: f64,
    pub rated_torque: f64,
    pub current_limit: f64,
    /// Rotor and screw.
    pub motor_inertia: f64,
    pub load_inertia: f64,
    pub motor_viscous: f64,
    pub motor_coulomb: f64,
    pub load_viscous: f64,
    pub load_coulomb: f64,
    pub friction: Friction,
    /// Damping ratio of the shaft against both masses.
    pub damping_ratio: f64,
    pub encoder_counts: f64,
    pub scale_um: f64,
    /// Standard deviation of the current's noise over the rated current.
    pub noise: f64,
    /// Share of rows that are missing.
    pub missing: f64,
    /// Standard deviation of the sampling time, s.
    pub jitter_s: f64,
    /// Whether the log holds the jittered times or the nominal ones.
    pub jitter_recorded: bool,
    /// By how much the logged current lags behind the positions, negative: leads, s.
    pub current_late_s: f64,
    /// Time constant of a first-order filter before the current's recorder, s; zero for none.
    pub current_filter_s: f64,
    pub seconds: f64,
    /// Slowest and fastest peak of a stroke, mm/s.
    pub speeds_mm_s: [f64; 2],
    pub seed: u64,
}

/// Rows of a log.
#[derive(Clone, Debug, Default)]
pub struct Rows {
    pub time_s: Vec<f64>,
    pub motor_mm: Vec<f64>,
    pub load_mm: Vec<f64>,
    pub current_a: Vec<f64>,
}

const STEP_S: f64 = 10e-6;
const STEPS_PER_SERVO: usize = 25;
const STEPS_PER_ROW: f64 = 100.0;

impl BallScrew {
    /// An axis of any lead, gap, stiffness, inertia and friction; clean log, friction as modelled.
    pub fn random(seed: u64) -> BallScrew {
        let mut random = Random::new(seed.wrapping_mul(0x9e37_79b9).wrapping_add(77));
        let leads = [5.0, 8.0, 10.0, 12.0, 16.0, 20.0];
        let lead_mm = leads[random.below(leads.len())];
        // A servo motor of 11 N m or of 3.2 N m, with a screw.
        let large = random.unit() < 0.5;
        let (torque_constant, rated_torque, rotor, current_limit) = if large {
            (1.08, 11.0, 0.00189, 28.0)
        } else {
            (0.55, 3.2, 0.00026, 17.0)
        };
        let friction = [0.0, 0.02, 0.06, 0.12, 0.15][random.below(5)];
        let mut axis = BallScrew {
            lead_mm,
            gap_um: random.log_between(2.0, 100.0),
            stiffness_n_per_um: random.log_between(50.0, 300.0),
            torque_constant,
            rated_torque,
            current_limit,
            motor_inertia: 1.35 * rotor,
            load_inertia: rotor * random.log_between(0.3, 3.0),
            motor_viscous: if large { 0.0022 } else { 0.00064 },
            motor_coulomb: 0.012 * rated_torque,
            load_viscous: random.between(0.0, 0.002),
            load_coulomb: friction * rated_torque,
            friction: Friction::Plain,
            damping_ratio: random.between(0.04, 0.1),
            encoder_counts: math::pow(2.0, random.between(17.0, 24.99).floor()),
            scale_um: 0.1,
            noise: 0.0,
            missing: 0.0,
            jitter_s: 0.0,
            jitter_recorded: true,
            current_late_s: 0.0,
            current_filter_s: 0.0,
            seconds: [10.0, 20.0, 20.0, 60.0][random.below(4)],
            speeds_mm_s: [20.0, 500.0],
            seed,
        };
        axis.load_viscous *= rated_torque;
        axis
    }

    /// The same axis with noise of the current up to 5 % and now and then a recorder's flaw.
    pub fn noisy(seed: u64) -> BallScrew {
        let mut random = Random::new(seed.wrapping_mul(0x51ed_270b).wrapping_add(3));
        let mut axis = BallScrew::random(seed);
        axis.noise = [0.005, 0.02, 0.02, 0.05][random.below(4)];
        match random.below(6) {
            0 => axis.missing = 0.01,
            1 => axis.jitter_s = 100e-6,
            2 => axis.current_late_s = random.between(-0.2e-3, 1e-3),
            _ => {}
        }
        axis
    }

    /// The same axis with a friction that no model of the fit has, and flaws of the recorder.
    pub fn odd(seed: u64) -> BallScrew {
        let mut random = Random::new(seed.wrapping_mul(0x2545_f491).wrapping_add(9));
        let mut axis = BallScrew::noisy(seed);
        axis.friction = match random.below(4) {
            0 => Friction::Stribeck(random.between(0.2, 0.8)),
            1 => Friction::Bristle(random.log_between(1e-4, 1e-2)),
            2 => Friction::Wavy(random.between(0.1, 0.4)),
            _ => Friction::Uneven(random.between(0.1, 0.4)),
        };
        axis.load_coulomb = axis.load_coulomb.max(0.04 * axis.rated_torque);
        axis
    }

    /// Radian at the motor for a millimetre of the slide.
    pub fn rad_per_mm(&self) -> f64 {
        TAU / self.lead_mm
    }

    /// Stiffness at the motor shaft, N m/rad.
    pub fn stiffness(&self) -> f64 {
        self.stiffness_n_per_um * 1e6 * 1e-6 / (self.rad_per_mm() * self.rad_per_mm())
    }

    /// Half gap at the motor shaft, rad.
    pub fn half_gap(&self) -> f64 {
        0.5e-3 * self.gap_um * self.rad_per_mm()
    }

    /// What the axis' description tells the fit.
    pub fn settings(&self) -> FitSettings {
        FitSettings {
            motor_viscous_nm_s_per_rad: self.motor_viscous,
            motor_coulomb_nm: self.motor_coulomb,
            known_inertia_kgm2: Some(self.motor_inertia + self.load_inertia),
            rated_torque_nm: Some(self.rated_torque),
            motor_rad_per_unit: Some(self.rad_per_mm()),
            ..FitSettings::new(self.torque_constant, Some(self.motor_inertia))
        }
    }

    /// The log that the fit reads.
    pub fn log(&self, rows: &Rows) -> Result<BacklashLog, FitError> {
        let scaled = |values: &[f64]| values.iter().map(|v| v * self.rad_per_mm()).collect();
        BacklashLog::from_rows(
            &rows.time_s,
            scaled(&rows.motor_mm),
            scaled(&rows.load_mm),
            rows.current_a.clone(),
        )
    }

    /// Runs the axis and records it.
    pub fn record(&self) -> Rows {
        let mut random = Random::new(self.seed ^ 0xabcd_ef01);
        let stiffness = self.stiffness();
        let (jm, jl) = (self.motor_inertia, self.load_inertia);
        let both = jm * jl / (jm + jl);
        let damping = 2.0 * self.damping_ratio * (stiffness * both).sqrt();
        let half_gap = self.half_gap();
        let bandwidth = 376.0;
        let velocity_gain = bandwidth * (jm + jl) / self.torque_constant;
        let count = TAU / self.encoder_counts;
        let scale = self.scale_um * 1e-3 * self.rad_per_mm();
        let noise = self.noise * self.rated_torque / self.torque_constant;

        let mut strokes = Strokes::new(self);
        let (mut motor, mut load) = (Mass::default(), Mass::default());
        let (mut bristle, mut current, mut wanted, mut integral) = (0.0, 0.0_f64, 0.0_f64, 0.0_f64);
        let mut filtered = 0.0_f64;
        let steps = (self.seconds / STEP_S) as usize;
        // The pending row: where and when each of its columns is sampled, in steps.
        let mut rows = Rows::default();
        let (mut row, mut pending_current) = (0_usize, 0_usize);
        let jitters: Vec<f64> = (0..(steps as f64 / STEPS_PER_ROW) as usize + 2)
            .map(|_| (self.jitter_s / STEP_S * random.normal()).clamp(-45.0, 45.0))
            .collect();
        // Rows start 2 ms in, so that a lagging current finds its place.
        let lead_in = 200.0;
        let when = |row: usize| {
            (lead_in + row as f64 * STEPS_PER_ROW + jitters.get(row).copied().unwrap_or(0.0))
                .round() as usize
        };
        let late = self.current_late_s / STEP_S;
        for step in 0..steps {
            if step % STEPS_PER_SERVO == 0 {
                let t = step as f64 * STEP_S;
                let (position, velocity, acceleration) = strokes.at(t, &mut random);
                let seen = (motor.angle / count).floor() * count;
                let error = 40.0 * (position - seen) + velocity - motor.speed;
                integral = (integral + error * 250e-6 * bandwidth / 4.0).clamp(-60.0, 60.0);
                wanted = (velocity_gain * (error + integral)
                    + (jm + jl) * acceleration / self.torque_constant)
                    .clamp(-self.current_limit, self.current_limit);
            }
            if row < jitters.len() && step == when(row) {
                let round = |value: f64, step: f64| (value / step).round() * step;
                rows.time_s.push(if self.jitter_recorded {
                    (step as f64 - lead_in) * STEP_S
                } else {
                    row as f64 * STEPS_PER_ROW * STEP_S
                });
                rows.motor_mm
                    .push(round(round(motor.angle, count) / self.rad_per_mm(), 1e-6));
                rows.load_mm
                    .push(round(round(load.angle, scale) / self.rad_per_mm(), 1e-6));
                row += 1;
            }
            let due = (when(pending_current) as f64 - late).round() as usize;
            if pending_current < jitters.len() && step == due {
                rows.current_a
                    .push(((filtered + noise * random.normal()) * 1e4).round() * 1e-4);
                pending_current += 1;
            }
            // The current loop: some 2 kHz.
            current += (wanted - current) * STEP_S / 80e-6;
            filtered = if self.current_filter_s > 0.0 {
                filtered + (current - filtered) * STEP_S / self.current_filter_s
            } else {
                current
            };
            let angle = motor.angle - load.angle;
            let depth = angle.abs() - half_gap;
            let contact = if depth > 0.0 {
                stiffness * depth * angle.signum() + damping * (motor.speed - load.speed)
            } else {
                0.0
            };
            motor.turn(
                self.torque_constant * current - self.motor_viscous * motor.speed - contact,
                self.motor_coulomb,
                jm,
            );
            let drive = contact - self.load_viscous * load.speed;
            let coulomb = self.load_coulomb;
            match self.friction {
                Friction::Plain => load.turn(drive, coulomb, jl),
                Friction::Stribeck(share) => {
                    let speed = load.speed.abs() / (0.01e3 * self.rad_per_mm());
                    load.turn(drive, coulomb * (1.0 + share / (1.0 + speed * speed)), jl);
                }
                Friction::Wavy(share) => {
                    let wave = math::sin(load.angle / (7.0 * self.rad_per_mm()));
                    load.turn(drive, coulomb * (1.0 + share * wave), jl);
                }
                Friction::Uneven(share) => {
                    let way = if load.speed == 0.0 {
                        drive.signum()
                    } else {
                        load.speed.signum()
                    };
                    load.turn(drive, coulomb * (1.0 + 0.5 * share * way), jl);
                }
                Friction::Bristle(length) => {
                    // Dahl: the bristle follows the motion until it slips.
                    let moved = load.speed * STEP_S;
                    bristle =
                        (bristle + moved - moved.abs() * bristle / length).clamp(-length, length);
                    load.turn(drive - coulomb * bristle / length, 0.0, jl);
                }
            }
        }
        // Rows whose current came after the end go, and those that were lost.
        let whole = rows.time_s.len().min(rows.current_a.len());
        let mut kept = Rows::default();
        for k in 0..whole {
            if k > 0 && random.unit() < self.missing {
                continue;
            }
            kept.time_s.push(rows.time_s[k]);
            kept.motor_mm.push(rows.motor_mm[k]);
            kept.load_mm.push(rows.load_mm[k]);
            kept.current_a.push(rows.current_a[k]);
        }
        kept
    }
}

/// One of the two masses.
#[derive(Clone, Copy, Default)]
struct Mass {
    angle: f64,
    speed: f64,
}

impl Mass {
    /// A step under a torque, against dry friction that can hold it.
    fn turn(&mut self, torque: f64, coulomb: f64, inertia: f64) {
        let free = self.speed + STEP_S / inertia * torque;
        let held = STEP_S / inertia * coulomb;
        self.speed = if free.abs() <= held {
            0.0
        } else {
            free - held * free.signum()
        };
        self.angle += STEP_S * self.speed;
    }
}

/// Strokes of random length, speed and acceleration within 300 mm, with rests.
struct Strokes {
    start: f64,
    from: f64,
    distance: f64,
    duration: f64,
    rest: f64,
    rad_per_mm: f64,
    speeds_mm_s: [f64; 2],
    most_acceleration: f64,
}

impl Strokes {
    fn new(axis: &BallScrew) -> Strokes {
        let inertia = axis.motor_inertia + axis.load_inertia;
        let most = 0.8 * axis.torque_constant * axis.current_limit - axis.load_coulomb;
        Strokes {
            start: 0.0,
            from: 0.0,
            distance: 0.0,
            duration: 0.0,
            rest: 0.05,
            rad_per_mm: axis.rad_per_mm(),
            speeds_mm_s: axis.speeds_mm_s,
            most_acceleration: (most / inertia).min(5e3 * axis.rad_per_mm()),
        }
    }

    fn at(&mut self, t: f64, random: &mut Random) -> (f64, f64, f64) {
        if t >= self.start + self.duration + self.rest {
            self.start = t;
            self.from += self.distance;
            // Back towards the middle, most strokes short.
            let way = if random.unit() < 0.5 + self.from / (300.0 * self.rad_per_mm) {
                -1.0
            } else {
                1.0
            };
            self.distance = way * random.log_between(1.0, 150.0) * self.rad_per_mm;
            // a minimum-jerk stroke: peaks 1.875 D/T and 5.77 D/T^2
            let [slowest, fastest] = self.speeds_mm_s;
            let speed = random.log_between(slowest, fastest) * self.rad_per_mm;
            let acceleration = random.between(0.1, 1.0) * self.most_acceleration;
            let length = self.distance.abs();
            self.duration = (1.875 * length / speed).max((5.77 * length / acceleration).sqrt());
            self.rest = if random.unit() < 0.5 {
                random.between(0.0, 0.3)
            } else {
                0.0
            };
        }
        let x = ((t - self.start) / self.duration.max(1e-9)).clamp(0.0, 1.0);
        let duration = self.duration.max(1e-9);
        (
            self.from + self.distance * x * x * x * (10.0 - 15.0 * x + 6.0 * x * x),
            self.distance / duration * 30.0 * x * x * (1.0 - x) * (1.0 - x),
            self.distance / (duration * duration) * 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x),
        )
    }
}
