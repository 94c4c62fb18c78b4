//! Numbers of the plant, all at the motor's shaft.

use super::mode::{Friction, Mass, Side};
use crate::config::{AxisConfig, ContactLaw, FrictionLaw, Harmonic, MAX_HARMONICS};
use lostmotion_base::math;
use std::f64::consts::TAU;

/// What the plant is made of. SI units, angles in rad at the motor's shaft.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlantParams {
    /// Phase resistance, ohm.
    pub resistance_ohm: f64,
    /// Phase inductance, H.
    pub inductance_h: f64,
    /// Back-EMF in q, V s/rad (mechanical).
    pub back_emf_v_s_per_rad: f64,
    /// Torque per i_q, N m/A.
    pub torque_constant_nm_per_a: f64,
    /// Pole pairs.
    pub pole_pairs: f64,
    /// Inertia of the rotor and what turns with it, kg m2.
    pub motor_inertia_kgm2: f64,
    /// Viscous friction at the motor, N m s/rad.
    pub motor_viscous_nm_s_per_rad: f64,
    /// Coulomb friction at the motor, N m.
    pub motor_coulomb_nm: f64,
    /// Inertia of the load, kg m2.
    pub load_inertia_kgm2: f64,
    /// Viscous friction at the load, N m s/rad.
    pub load_viscous_nm_s_per_rad: f64,
    /// Coulomb friction at the load, N m.
    pub load_coulomb_nm: f64,
    /// Constant torque against the positive direction at the load, N m.
    pub load_constant_nm: f64,
    /// Stiffness of the shaft, N m/rad.
    pub stiffness_nm_per_rad: f64,
    /// Damping of the shaft, N m s/rad.
    pub damping_nm_s_per_rad: f64,
    /// Half gap b, rad.
    pub half_gap_rad: f64,
    /// Where the middle of the gap is, in parts of the half gap.
    pub gap_middle: f64,
    /// Law of the contact torque.
    pub contact: ContactLaw,
    /// Law of the motor's Coulomb friction.
    pub motor_friction: FrictionShape,
    /// Law of the load's Coulomb friction.
    pub load_friction: FrictionShape,
    /// What is not linear.
    pub curved: Curved,
    /// Largest current the drive allows, A; only scales the margins of the event search.
    pub current_limit_a: f64,
    /// Length of a step: the current loop's period, s.
    pub period_s: f64,
}

impl PlantParams {
    /// The plant of an axis.
    pub fn new<C>(config: &AxisConfig<C>) -> PlantParams {
        // data sheets are line to line and in the axis' unit; from here on per phase and at the
        // motor's shaft
        let (motor, load) = (&config.motor, config.reflected_load());
        PlantParams {
            resistance_ohm: motor.phase_resistance_ohm(),
            inductance_h: motor.phase_inductance_h(),
            back_emf_v_s_per_rad: motor.back_emf_v_s_per_rad(),
            torque_constant_nm_per_a: motor.torque_constant_nm_per_a,
            pole_pairs: motor.pole_pairs(),
            motor_inertia_kgm2: config.motor_side_inertia_kgm2(),
            motor_viscous_nm_s_per_rad: motor.viscous_nm_s_per_rad,
            motor_coulomb_nm: motor.coulomb_nm,
            load_inertia_kgm2: load.inertia_kgm2,
            load_viscous_nm_s_per_rad: load.viscous_nm_s_per_rad,
            load_coulomb_nm: load.coulomb_nm,
            load_constant_nm: load.constant_nm,
            stiffness_nm_per_rad: load.stiffness_nm_per_rad,
            damping_nm_s_per_rad: load.damping_nm_s_per_rad,
            half_gap_rad: load.half_gap_rad(),
            gap_middle: config.flanks.middle,
            contact: config.contact,
            motor_friction: FrictionShape::new(&config.friction.motor),
            load_friction: FrictionShape::new(&config.friction.load_at_motor(&config.transmission)),
            curved: Curved::new(config),
            current_limit_a: config.drive.current_limit_a,
            period_s: config.current_period_us() * 1e-6,
        }
    }

    /// Gap angle at which a flank of a sign begins; the middle of the gap for 0. Rad.
    #[inline]
    pub(super) fn flank(&self, sign: f64) -> f64 {
        (self.gap_middle + sign) * self.half_gap_rad
    }

    /// An upper bound of how fast any mode of the plant moves, 1/s: the norm of its system matrix
    /// in balanced units.
    pub(super) fn rate(&self) -> f64 {
        let joint = 1.0 / self.motor_inertia_kgm2 + 1.0 / self.load_inertia_kgm2;
        let electric = self.resistance_ohm / self.inductance_h;
        // of two states that drive each other balancing leaves the geometric mean of both entries
        let electromechanic = (self.torque_constant_nm_per_a * self.back_emf_v_s_per_rad
            / (self.inductance_h * self.motor_inertia_kgm2))
            .sqrt();
        // twice the stiffness: bounded damping doubles the spring
        let spring = (2.0 * self.stiffness_nm_per_rad * joint).sqrt();
        let friction = (self.motor_viscous_nm_s_per_rad + self.fall(Mass::Motor))
            / self.motor_inertia_kgm2
            + (self.load_viscous_nm_s_per_rad + self.fall(Mass::Load)) / self.load_inertia_kgm2;
        electric + electromechanic + spring + self.damping_nm_s_per_rad * joint + friction
    }
}

// What of a plant is not linear within a mode: its numbers, at the motor's shaft.

/// One harmonic over an angle: `amplitude sin(per_rad theta + phase)`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wave {
    /// Amplitude, in the unit of what it is a part of.
    pub amplitude: f64,
    /// Periods for one rad, times 2 pi.
    pub per_rad: f64,
    /// Phase, rad.
    pub phase_rad: f64,
}

/// A few harmonics over one angle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Waves {
    list: [Wave; MAX_HARMONICS],
    len: usize,
}

/// Wear: the gap is `1 + excess exp(-((x - at)/width)^2)` times as wide at load position x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bell {
    /// By how much the gap is wider at the worst place, in parts of the gap elsewhere.
    pub excess: f64,
    /// The worst place, rad.
    pub at_rad: f64,
    /// Width, rad.
    pub width_rad: f64,
}

/// Everything that is not linear, besides friction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Curved {
    /// Cogging, N m over the motor's angle.
    pub cogging: Waves,
    /// Relative torque ripple over the motor's angle.
    pub ripple: Waves,
    /// Gravity against the positive direction, N m over the load's angle.
    pub gravity: Waves,
    /// Wear of the flanks.
    pub wear: Option<Bell>,
}

impl Waves {
    /// Of a list; more than there is room for is left out.
    pub fn new(waves: impl IntoIterator<Item = Wave>) -> Waves {
        let mut all = Waves::default();
        for wave in waves {
            if let Some(slot) = all.list.get_mut(all.len) {
                *slot = wave;
                all.len += 1;
            }
        }
        all
    }

    /// Torque of an axis' weight against the positive direction over the load's angle, N m and rad
    /// at the motor; none without [`crate::config::Gravity`].
    pub fn gravity<C>(config: &AxisConfig<C>) -> Waves {
        let ratio = config.transmission.load_per_motor_rad();
        Waves::new(config.gravity.map(|gravity| Wave {
            amplitude: gravity.torque_nm * ratio,
            per_rad: ratio,
            phase_rad: -gravity.hangs_at_deg * (TAU / 360.0),
        }))
    }

    fn over_turn(harmonics: &[Harmonic]) -> Waves {
        Waves::new(harmonics.iter().map(|harmonic| Wave {
            amplitude: harmonic.amplitude,
            per_rad: f64::from(harmonic.per_turn),
            phase_rad: harmonic.phase_deg * (TAU / 360.0),
        }))
    }

    /// The harmonics.
    pub fn as_slice(&self) -> &[Wave] {
        self.list.get(..self.len).unwrap_or(&[])
    }

    /// Their sum at an angle, rad.
    #[inline]
    pub fn at(&self, angle: f64) -> f64 {
        if self.len == 0 {
            return 0.0;
        }
        self.sum_at(angle)
    }

    fn sum_at(&self, angle: f64) -> f64 {
        self.as_slice()
            .iter()
            .map(|wave| wave.amplitude * math::sin(wave.per_rad * angle + wave.phase_rad))
            .sum()
    }

    /// The fastest of them, periods times 2 pi for one rad.
    fn per_rad(&self) -> f64 {
        self.as_slice()
            .iter()
            .fold(0.0, |highest, wave| wave.per_rad.max(highest))
    }
}

impl Bell {
    /// How many times wider the gap is at a load position.
    pub fn at(&self, place: f64) -> f64 {
        let u = (place - self.at_rad) / self.width_rad;
        1.0 + self.excess * math::exp(-(u * u))
    }

    /// The change of that along the load, 1/rad.
    pub(super) fn slope(&self, place: f64) -> f64 {
        let u = (place - self.at_rad) / self.width_rad;
        -2.0 * u / self.width_rad * self.excess * math::exp(-(u * u))
    }
}

impl Curved {
    /// That of an axis.
    pub(super) fn new<C>(config: &AxisConfig<C>) -> Curved {
        // axis units to rad at the motor
        let factor = config.transmission.motor_rad_per_unit();
        let wear = config.flanks.wear.map(|wear| Bell {
            excess: wear.factor - 1.0,
            at_rad: wear.at_units * factor,
            width_rad: wear.width_units * factor,
        });
        Curved {
            cogging: Waves::over_turn(&config.ripple.cogging),
            ripple: Waves::over_turn(&config.ripple.torque),
            gravity: Waves::gravity(config),
            wear,
        }
    }
}

impl PlantParams {
    /// Whether the equations are not linear within a mode.
    pub(super) fn is_curved(&self) -> bool {
        let bristles = [
            (self.motor_coulomb_nm, self.motor_friction),
            (self.load_coulomb_nm, self.load_friction),
        ];
        self.curved != Curved::default()
            || bristles
                .iter()
                .any(|(coulomb, law)| *coulomb > 0.0 && law.bristles.is_some())
    }

    /// An upper bound of how fast anything moves at these speeds, 1/s.
    pub(super) fn rate_at(&self, motor_speed: f64, load_speed: f64) -> f64 {
        // a wave over the motor's angle passes as often as it has periods in the way travelled
        let waves = self
            .curved
            .cogging
            .per_rad()
            .max(self.curved.ripple.per_rad())
            * motor_speed.abs();
        // bristles bend over within the presliding way
        let bend = |bristles: Option<super::params::Bristles>, speed: f64| {
            bristles.map_or(0.0, |b| speed.abs() / b.presliding_rad)
        };
        self.rate()
            + waves
            + bend(self.motor_friction.bristles, motor_speed)
            + bend(self.load_friction.bristles, load_speed)
    }

    /// Gap angle at which a flank of a sign begins with the load at a place; the middle of the gap
    /// for 0. Rad.
    pub(super) fn flank_at(&self, sign: f64, place: f64) -> f64 {
        match &self.curved.wear {
            None => self.flank(sign),
            Some(wear) => (self.gap_middle + sign) * (self.half_gap_rad * wear.at(place)),
        }
    }
}

// Coulomb friction of both masses: how much of it there is in each state.

/// Bristles of LuGre's model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bristles {
    /// Deflection at which they carry the Coulomb friction, rad.
    pub presliding_rad: f64,
    /// Damping over stiffness, s.
    pub damping_s: f64,
}

/// Law of a Coulomb friction, at the motor's shaft. Its size stands apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrictionShape {
    /// Breakaway over Coulomb friction.
    pub static_factor: f64,
    /// Speed from which Coulomb friction alone is left, rad/s; 0 without a fall.
    pub speed_rad_s: f64,
    /// Bristles instead of true stick.
    pub bristles: Option<Bristles>,
}

impl FrictionShape {
    /// The same at every speed.
    pub const PLAIN: FrictionShape = FrictionShape {
        static_factor: 1.0,
        speed_rad_s: 0.0,
        bristles: None,
    };

    /// The law of a description whose speeds and ways are at the motor's shaft.
    pub(super) fn new(law: &FrictionLaw) -> FrictionShape {
        match *law {
            FrictionLaw::Coulomb => FrictionShape::PLAIN,
            FrictionLaw::Stribeck(law) => FrictionShape {
                static_factor: law.static_factor,
                speed_rad_s: law.speed_units_s,
                bristles: None,
            },
            FrictionLaw::Lugre(law) => FrictionShape {
                static_factor: law.static_factor,
                speed_rad_s: law.speed_units_s,
                bristles: Some(Bristles {
                    presliding_rad: law.presliding_units,
                    damping_s: law.damping_s,
                }),
            },
        }
    }

    /// Speed at which a sliding mass begins to creep, rad/s; 0 for one that slides until it stops.
    #[inline]
    pub(super) fn slow_rad_s(&self) -> f64 {
        if self.creeps() { self.speed_rad_s } else { 0.0 }
    }

    /// Whether its friction falls with speed in a straight line.
    #[inline]
    pub(super) fn creeps(&self) -> bool {
        self.static_factor > 1.0 && self.bristles.is_none()
    }
}

impl PlantParams {
    #[inline]
    pub(super) fn friction(&self, mass: Mass) -> &FrictionShape {
        match mass {
            Mass::Motor => &self.motor_friction,
            Mass::Load => &self.load_friction,
        }
    }

    #[inline]
    pub(super) fn coulomb(&self, mass: Mass) -> f64 {
        match mass {
            Mass::Motor => self.motor_coulomb_nm,
            Mass::Load => self.load_coulomb_nm,
        }
    }

    /// The most that friction can hold at rest, N m.
    #[inline]
    pub(super) fn breakaway(&self, mass: Mass) -> f64 {
        self.coulomb(mass) * self.friction(mass).static_factor
    }

    /// Slope at which friction falls with speed while a mass creeps, N m s/rad.
    pub(super) fn fall(&self, mass: Mass) -> f64 {
        let shape = self.friction(mass);
        if shape.creeps() {
            self.coulomb(mass) * (shape.static_factor - 1.0) / shape.speed_rad_s
        } else {
            0.0
        }
    }

    /// Viscous friction of a mass in a state, N m s/rad.
    #[inline]
    pub(super) fn viscous(&self, mass: Mass, state: Friction) -> f64 {
        let viscous = match mass {
            Mass::Motor => self.motor_viscous_nm_s_per_rad,
            Mass::Load => self.load_viscous_nm_s_per_rad,
        };
        if state.creeps() {
            viscous - self.fall(mass)
        } else {
            viscous
        }
    }

    /// The part of a sliding mass' friction torque that does not change with speed, N m.
    #[inline]
    pub(super) fn sliding_torque(&self, mass: Mass, state: Friction) -> f64 {
        let torque = self.coulomb(mass) * state.sign();
        if state.creeps() {
            torque * self.friction(mass).static_factor
        } else {
            torque
        }
    }

    /// Moving from rest in a direction.
    pub(super) fn starting(&self, mass: Mass, side: Side) -> Friction {
        if self.friction(mass).creeps() {
            Friction::Creeping(side)
        } else {
            Friction::Sliding(side)
        }
    }

    /// Moving at a speed, or at rest.
    pub(super) fn moving(&self, mass: Mass, speed: f64) -> Friction {
        let (side, shape) = (Side::of(speed), self.friction(mass));
        match self.resting(mass) {
            resting if speed == 0.0 => resting,
            Friction::None => Friction::None,
            Friction::Bristles(_) => Friction::Bristles(side),
            _ if shape.creeps() && speed.abs() < shape.speed_rad_s => Friction::Creeping(side),
            _ => Friction::Sliding(side),
        }
    }

    /// At rest.
    pub(super) fn resting(&self, mass: Mass) -> Friction {
        match (self.coulomb(mass) > 0.0, self.friction(mass).bristles) {
            (false, _) => Friction::None,
            (true, None) => Friction::Stuck,
            (true, Some(_)) => Friction::Bristles(Side::Positive),
        }
    }
}

// The load's scale or encoder.

/// A scale with its step, the place of its index pulse and its errors, at the motor's shaft.
///
/// It reads `index + step round((x + e(x) - index)/step)`, e the error: whole counts from the index
/// pulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadScale {
    step_rad: f64,
    index_rad: f64,
    slope: f64,
    errors: Waves,
}

impl LoadScale {
    /// That of an axis.
    pub fn new<C>(config: &AxisConfig<C>) -> LoadScale {
        let (scale, factor) = (&config.scale, config.transmission.motor_rad_per_unit());
        // axis units to rad at the motor
        let errors = scale.errors.iter().map(|error| Wave {
            amplitude: error.amplitude_units * factor,
            per_rad: TAU / (error.period_units * factor),
            phase_rad: error.phase_deg * (TAU / 360.0),
        });
        LoadScale {
            step_rad: config.reflected_load().scale_rad,
            index_rad: scale.index_units * factor,
            slope: scale.slope_ppm * 1e-6,
            errors: Waves::new(errors),
        }
    }

    /// What it shows with the load at a position, rad.
    #[inline]
    pub fn read(&self, position: f64) -> f64 {
        // slope and counts are zero at the index pulse; the periodic errors have their phase from
        // position 0
        let from_index = position - self.index_rad;
        let seen = from_index + self.slope * from_index + self.errors.at(position);
        if self.step_rad > 0.0 {
            (seen / self.step_rad).round() * self.step_rad + self.index_rad
        } else {
            seen + self.index_rad
        }
    }
}
