//! The solution of the equations that are not linear, as power series of time.
//!
//! With w the width of the gap at the load's place, s the flank's sign and m the middle of the gap
//! in half gaps, the flank is at `theta_b = (m + s) b w(x_L)`, and
//! ```text
//! p           = theta_b - (m + s) b w(x_L)
//! dp/dt       = w_M - w_L (1 + (m + s) b w'(x_L))
//! J_M dw_M/dt = K_t (1 + r(theta_M)) i - T_c - T_cog(theta_M) - b_v w_M - F_M
//! J_L dw_L/dt = T_c (1 + (m + s) b w'(x_L)) - T_ext - T_g(x_L) - b_L w_L - F_L
//! L di/dt     = u - R i - K_e (1 + r(theta_M)) w_M
//! ```
//! An inclined flank takes its part of the force along the load, so that the spring's energy is
//! that of its compression, wherever it is.

use super::dynamics::{COEFFICIENTS, Held};
use super::mode::{Coupling, Friction, Mass, Mode};
use super::params::{Bristles, PlantParams};
use super::series::{Gauss, NOTHING, Series, Sine, Width, product, value};
use super::state::PlantState;
use crate::config::MAX_HARMONICS;

/// Order before which no series counts as settled: what acts on the motor shows in the load four
/// orders later.
const FEWEST_ORDERS: usize = 6;
/// How small the last two coefficients have to be beside the largest.
const SETTLED_SHARE: f64 = 2e-16;

/// States and torques over a span of time as series of tau = t/span.
pub(super) struct Expansion<'a> {
    params: &'a PlantParams,
    mode: Mode,
    held: Held,
    span: f64,
    current: Series,
    pub(super) angle: Series,
    pub(super) speed: [Series; 2],
    place: Series,
    bristles: [Series; 2],
    motor_angle: Series,
    cogging: [Sine; MAX_HARMONICS],
    ripple: [Sine; MAX_HARMONICS],
    gravity: [Sine; MAX_HARMONICS],
    brushes: [Option<Brush>; 2],
    width: Option<Width>,
    lever: Series,
    constant: Series,
    /// Past the flank; in the gap past its middle.
    pub(super) depth: Series,
    /// Speed of that.
    pub(super) closing: Series,
    /// Torque on each mass that its friction has to hold if it stands.
    pub(super) need: [Series; 2],
    contact: Series,
    settled: bool,
}

impl<'a> Expansion<'a> {
    pub(super) fn new(
        params: &'a PlantParams,
        state: &PlantState,
        held: &Held,
        span: f64,
    ) -> Expansion<'a> {
        let sines = |waves: &super::params::Waves| {
            let mut list = [Sine::new(super::params::Wave::default()); MAX_HARMONICS];
            for (slot, wave) in list.iter_mut().zip(waves.as_slice()) {
                *slot = Sine::new(*wave);
            }
            list
        };
        // bristles carry a mass only in a mode that moves on them
        let brush = |mass: Mass| match (state.mode.friction(mass), params.friction(mass).bristles) {
            (Friction::Bristles(side), Some(bristles)) => {
                Some(Brush::new(params, mass, side.sign(), bristles))
            }
            _ => None,
        };
        let mut all = Expansion {
            params,
            mode: state.mode,
            held: *held,
            span,
            current: start(state.current_q),
            angle: start(state.gap_angle),
            speed: [start(state.motor_velocity), start(state.load_velocity)],
            place: start(state.load_position),
            bristles: state.bristles.map(start),
            motor_angle: NOTHING,
            cogging: sines(&params.curved.cogging),
            ripple: sines(&params.curved.ripple),
            gravity: sines(&params.curved.gravity),
            brushes: [brush(Mass::Motor), brush(Mass::Load)],
            width: params.curved.wear.map(Width::new),
            lever: NOTHING,
            constant: NOTHING,
            depth: NOTHING,
            closing: NOTHING,
            need: [NOTHING; 2],
            contact: NOTHING,
            settled: false,
        };
        // order by order: torques from the states, the next order of the states from the torques
        for n in 0..COEFFICIENTS {
            all.contact_at(n);
            all.torques_at(n);
            if n + 1 < COEFFICIENTS {
                all.integrate(n);
            }
            // a settled series ends early; one that never settles tells the caller to take a
            // shorter span
            if n >= FEWEST_ORDERS && all.has_come_down(n) {
                all.settled = true;
                break;
            }
        }
        all
    }

    /// Flank, penetration and contact torque.
    fn contact_at(&mut self, n: usize) {
        let params = self.params;
        let flank = self.params.gap_middle + self.mode.contact.sign();
        let unit = if n == 0 { 1.0 } else { 0.0 };
        // width of the gap at the load, and its change along the load
        let (times, slope) = match &mut self.width {
            None => (unit, 0.0),
            Some(width) => {
                width.extend(&self.place, n);
                (width.times[n], width.slope[n])
            }
        };
        // penetration past the flank, and the lever of an inclined flank
        self.depth[n] = self.angle[n] - flank * (params.half_gap_rad * times);
        self.lever[n] = unit + flank * params.half_gap_rad * slope;
        // speed of the penetration: the flank moves with the load on the incline
        let load = if self.width.is_some() {
            product(&self.speed[1], &self.lever, n)
        } else {
            self.speed[1][n]
        };
        self.closing[n] = self.speed[0][n] - load;
        // spring and damper of the mode
        let (k, d) = params.shaft(self.mode.contact.coupling());
        self.contact[n] = k * self.depth[n] + d * self.closing[n];
    }

    /// Torques on both masses, friction's state variables.
    fn torques_at(&mut self, n: usize) {
        let params = self.params;
        self.motor_angle[n] = self.place[n] + self.angle[n];
        let sum = |sines: &mut [Sine], count: usize, angle: &Series| -> f64 {
            sines
                .iter_mut()
                .take(count)
                .map(|sine| sine.extend(angle, n))
                .sum()
        };
        let curved = &params.curved;
        // waves over motor and load angle
        let cogging = sum(
            &mut self.cogging,
            curved.cogging.as_slice().len(),
            &self.motor_angle,
        );
        let gravity = sum(
            &mut self.gravity,
            curved.gravity.as_slice().len(),
            &self.place,
        );
        let ripples = curved.ripple.as_slice().len();
        let unit = if n == 0 { 1.0 } else { 0.0 };
        self.constant[n] = unit + sum(&mut self.ripple, ripples, &self.motor_angle);
        // torque of the current, with the torque constant that ripples
        let drive = if ripples > 0 {
            product(&self.constant, &self.current, n)
        } else {
            self.current[n]
        };
        // what the flank gives to the load along its own direction
        let on_load = if self.width.is_some() {
            product(&self.contact, &self.lever, n)
        } else {
            self.contact[n]
        };
        // what friction has to balance on either mass
        self.need[0][n] = params.torque_constant_nm_per_a * drive - self.contact[n] - cogging;
        self.need[1][n] = on_load - gravity - unit * self.held.load_torque;
        // deflection of the bristles and their torque, from the speeds of the same order
        for (mass, brush) in self.brushes.iter_mut().enumerate() {
            if let Some(brush) = brush {
                brush.extend(&self.speed[mass], &self.bristles[mass], n);
            }
        }
    }

    /// Coefficients n + 1 of the states.
    fn integrate(&mut self, n: usize) {
        let params = self.params;
        let unit = if n == 0 { 1.0 } else { 0.0 };
        // integrating tau^n divides by n + 1; the span converts tau to seconds
        let over = self.span / (n + 1) as f64;
        // the winding: voltage less resistance and back-EMF, which ripples as the torque constant
        // does
        let emf = if params.curved.ripple.as_slice().is_empty() {
            self.speed[0][n]
        } else {
            product(&self.constant, &self.speed[0], n)
        };
        let voltage = unit * self.held.voltage
            - params.resistance_ohm * self.current[n]
            - params.back_emf_v_s_per_rad * emf;
        self.current[n + 1] = over * voltage / params.inductance_h;
        self.angle[n + 1] = over * (self.speed[0][n] - self.speed[1][n]);
        self.place[n + 1] = over * self.speed[1][n];
        // both masses: need less viscous and dry friction
        let inertia = [params.motor_inertia_kgm2, params.load_inertia_kgm2];
        for (index, mass) in [Mass::Motor, Mass::Load].into_iter().enumerate() {
            let state = self.mode.friction(mass);
            let friction = match &self.brushes[index] {
                Some(brush) => {
                    self.bristles[index][n + 1] = over * brush.rate[n];
                    brush.torque[n]
                }
                None => unit * params.sliding_torque(mass, state),
            };
            let torque =
                self.need[index][n] - params.viscous(mass, state) * self.speed[index][n] - friction;
            self.speed[index][n + 1] = if state.stuck() {
                0.0
            } else {
                over * torque / inertia[index]
            };
        }
    }

    /// Whether coefficients n and n + 1 of all states are down to rounding (n and n - 1 at the
    /// end).
    fn has_come_down(&self, n: usize) -> bool {
        // two in a row, because every second coefficient of an even or odd function is zero
        let last = (n + 1).min(COEFFICIENTS - 1);
        let states = [
            &self.current,
            &self.angle,
            &self.speed[0],
            &self.speed[1],
            &self.place,
            &self.bristles[0],
            &self.bristles[1],
        ];
        states.iter().all(|series| {
            let largest = series[..=last]
                .iter()
                .fold(0.0, |most: f64, c| most.max(c.abs()));
            series[last].abs().max(series[last - 1].abs()) <= SETTLED_SHARE * largest
        })
    }

    /// Whether the series have come down to rounding; else the span is too long.
    pub(super) fn is_settled(&self) -> bool {
        self.settled
    }

    /// Torques that friction has to hold at tau.
    pub(super) fn need_at(&self, tau: f64) -> [f64; 2] {
        [value(&self.need[0], tau), value(&self.need[1], tau)]
    }

    /// Half the gap at the load's place.
    pub(super) fn half_gap(&self) -> Series {
        let b = self.params.half_gap_rad;
        match &self.width {
            None => start(b),
            Some(width) => width.times.map(|times| b * times),
        }
    }

    /// Stiffness times depth and damping times closing speed: the two parts of the contact torque,
    /// whether or not it acts.
    pub(super) fn spring_and_damper(&self) -> (Series, Series) {
        let (k, d) = self.params.shaft(Coupling::Spring);
        (self.depth.map(|c| k * c), self.closing.map(|c| d * c))
    }

    /// Puts the state at tau.
    pub(super) fn store(&self, state: &mut PlantState, tau: f64) {
        state.current_q = value(&self.current, tau);
        state.gap_angle = value(&self.angle, tau);
        state.motor_velocity = value(&self.speed[0], tau);
        state.load_velocity = value(&self.speed[1], tau);
        state.load_position = value(&self.place, tau);
        state.bristles = [value(&self.bristles[0], tau), value(&self.bristles[1], tau)];
    }
}

fn start(first: f64) -> Series {
    let mut series = NOTHING;
    series[0] = first;
    series
}

// LuGre's friction as a series; see [`crate::config::Lugre`] for its equations.

/// Friction of a mass that moves on bristles in one direction.
#[derive(Clone, Copy, Debug)]
pub(super) struct Brush {
    sign: f64,
    coulomb: f64,
    static_excess: f64,
    speed: f64,
    stiffness: f64,
    damping: f64,
    u: Series,
    gauss: Gauss,
    level: Series,
    ratio: Series,
    /// Speed of the deflection, rad/s.
    pub(super) rate: Series,
    /// Friction torque against the positive direction, N m.
    pub(super) torque: Series,
}

impl Brush {
    pub(super) fn new(params: &PlantParams, mass: Mass, sign: f64, bristles: Bristles) -> Brush {
        let (shape, coulomb) = (params.friction(mass), params.coulomb(mass));
        // sigma_0: at the presliding deflection the bristles carry the Coulomb friction
        let stiffness = coulomb / bristles.presliding_rad;
        Brush {
            sign,
            coulomb,
            static_excess: shape.static_factor - 1.0,
            speed: shape.speed_rad_s,
            stiffness,
            damping: stiffness * bristles.damping_s,
            u: NOTHING,
            gauss: Gauss::NEW,
            level: NOTHING,
            ratio: NOTHING,
            rate: NOTHING,
            torque: NOTHING,
        }
    }

    pub(super) fn extend(&mut self, speed: &Series, deflection: &Series, n: usize) {
        // Stribeck level g(w) = F_c + (F_s - F_c) exp(-(w/v_s)^2)
        self.u[n] = speed[n] / self.speed;
        self.gauss.extend(&self.u, n);
        self.level[n] = self.coulomb * self.static_excess * self.gauss.value[n];
        if n == 0 {
            self.level[0] += self.coulomb;
        }
        // deflection over level, by long division; its own coefficient n is still zero in the
        // product
        self.ratio[n] = (deflection[n] - product(&self.level, &self.ratio, n)) / self.level[0];
        // dz/dt = w - |w| z / g(w) in units of torque, then the torque sigma_0 z + sigma_1 dz/dt
        self.rate[n] = speed[n] - self.sign * self.stiffness * product(speed, &self.ratio, n);
        self.torque[n] = self.stiffness * deflection[n] + self.damping * self.rate[n];
    }
}
