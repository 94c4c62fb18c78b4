//! The plant: motor, shaft with a gap, load, friction. Steps are exact.
//!
//! In each [`Mode`] (contact x motor friction x load friction) the plant is linear and
//! time-invariant, and the voltage is held over a period of the current loop; so a step is one
//! product with a precomputed matrix exponential. Where a mode ends within the step, the instant is
//! found on the exact solution (a Taylor polynomial whose remainder is below rounding), the states
//! are put on the boundary, and the rest of the step is taken in the next mode. Source: `theta_M/I`
//! of Gan, Wang, Huang (2023), equations (2) and (3), with friction on both masses added.
//!
//! State: the load's position and the gap angle `theta_b = theta_M - theta_L` of its own, so that a
//! contact a thousand turns out is as sharp as at the origin; i_q; both speeds. i_d has an exact
//! step of its own. The voltages that couple d and q (`w_e L i`) and would make the equations
//! bilinear are held over a period at their value at its start.

mod curved_step;
mod drifting;
mod dynamics;
mod expansion;
mod guard;
mod lane;
mod mode;
mod params;
mod quiet;
mod series;
mod state;

pub use drifting::DRIFT_MS;
pub(crate) use drifting::Drifting;
pub(crate) use dynamics::{Electric, exact_step, shaft_torque};
pub(crate) use lane::{Known, Lane};
pub use mode::{Contact, Friction, Mode, Side};
pub use params::{Bell, Bristles, Curved, FrictionShape, LoadScale, PlantParams, Wave, Waves};
pub(crate) use quiet::{Watch, keeps_pushing, keeps_sliding, keeps_standing, stays_within};
pub use state::{PlantStart, PlantState};

use dynamics::{Held, StepTable, Taylor, Vector};
use guard::{Event, Guards, Vanishing};
use lostmotion_base::math;
use mode::{MATRICES, Mass};
use quiet::Margins;

/// Events in one step after which the rest of the step is taken without looking for more. Contact
/// and friction cannot follow each other that fast; the bound is there so that no input whatever
/// can hang a run.
const MAX_EVENTS: u32 = 32;
/// Taylor pieces are so short that `rate * span` stays below this.
const LARGEST_RATE_SPAN: f64 = 0.5;

/// What acts on the plant over one period, held.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlantInput {
    /// Voltage in d, V.
    pub voltage_d: f64,
    /// Voltage in q, V.
    pub voltage_q: f64,
    /// Torque against the load's positive direction on top of the constant one, N m (cutting
    /// force).
    pub load_torque: f64,
}

/// The plant of one axis: immutable, shared.
#[derive(Clone, Debug)]
pub struct Plant {
    params: PlantParams,
    tables: [StepTable; MATRICES],
    margins: Margins,
    curved: bool,
    pieces: u32,
    electric: Electric<f64>,
}

impl Plant {
    /// Precomputes the steps.
    pub fn new(params: &PlantParams) -> Plant {
        // the search for events uses Taylor series, which need the period in pieces this short
        let mut pieces = 1;
        while params.rate() * params.period_s / f64::from(pieces) > LARGEST_RATE_SPAN
            && pieces < 10_000
        {
            pieces += 1;
        }
        // L di_d/dt = u_d - R i_d with u_d held: over a period h an exponential of R h/L
        let electric = params.resistance_ohm / params.inductance_h * params.period_s;
        Plant {
            params: *params,
            tables: StepTable::all(params),
            margins: Margins::new(params),
            curved: params.is_curved(),
            pieces,
            electric: Electric {
                pole_pairs: params.pole_pairs,
                inductance: params.inductance_h,
                decay_d: math::exp(-electric),
                gain_d: -math::expm1(-electric) / params.resistance_ohm,
            },
        }
    }

    /// Its numbers.
    pub fn params(&self) -> &PlantParams {
        &self.params
    }

    /// Torque of the shaft against the motor, N m.
    pub fn contact_torque(&self, state: &PlantState) -> f64 {
        self.params.contact_torques(state)[0]
    }

    /// Torque of the shaft on the load, N m; on worn flanks their incline is in it.
    #[inline]
    pub fn torque_on_load(&self, state: &PlantState) -> f64 {
        self.params.contact_torques(state)[1]
    }

    /// One period of the current loop.
    pub fn step(&self, state: &mut PlantState, input: &PlantInput) {
        self.step_knowing(&self.known(state.mode), state, input);
    }

    /// The same with what a step in the state's mode asks for: the mode stays what it is over many.
    #[inline(always)]
    pub(crate) fn step_knowing(&self, known: &Known, state: &mut PlantState, input: &PlantInput) {
        // the electric side that is bilinear: coupling held at the start of the period, i_d by its
        // own step
        let (voltage, next_d) = self.electric.step(
            state.motor_velocity,
            [state.current_d, state.current_q],
            [input.voltage_d, input.voltage_q],
        );
        let held = Held {
            voltage,
            load_torque: self.params.load_constant_nm + input.load_torque,
        };
        state.current_d = next_d;
        if self.curved {
            self.curved_step(state, &held);
            return;
        }
        // the step as if nothing happened in it, and a look whether that can have been so
        let before = state.vector(known.offset);
        let (after, travel) = self.tables[known.matrix].step(known.friction, &before, &held);
        // the cubics cost more than they save where the ends of the step tell
        let quiet = known.keeps_contact(&before, &after)
            && (known.keeps_frictions(&before, &after, held.load_torque)
                || self
                    .margins
                    .near(&self.params, known.mode, &held, &before, &after));
        if quiet {
            state.store(known.offset, &after, travel);
        } else {
            self.careful_step(state, &held, &after, travel);
        }
    }

    /// Gap angle at which the penetration of a mode is zero.
    fn offset(&self, mode: Mode) -> f64 {
        self.params.flank(mode.contact.sign())
    }

    /// A step in which something may happen. `after` and `travel` are right if nothing does.
    #[cold]
    #[inline(never)]
    fn careful_step(&self, state: &mut PlantState, held: &Held, after: &Vector, travel: f64) {
        // piece by piece, and within a piece from event to event
        let piece = self.params.period_s / f64::from(self.pieces);
        let start = *state;
        let mut events = 0;
        let mut vanishing = None;
        for _ in 0..self.pieces {
            let mut left = piece;
            while let Some((span, event)) =
                self.advance(state, held, left, vanishing, events < MAX_EVENTS)
            {
                let (mut x, before) = (state.vector(self.offset(state.mode)), state.mode);
                let (mode, next) =
                    self.params
                        .switch(event, state.mode, &mut x, |mass, x| match mass {
                            Mass::Motor => self.params.motor_need(before, x),
                            Mass::Load => self.params.load_need(before, x, held),
                        });
                state.mode = mode;
                state.store(self.offset(state.mode), &x, 0.0);
                state.events += 1;
                events += 1;
                vanishing = next;
                left -= span;
            }
            // the next piece starts within the mode, off its boundaries
            vanishing = None;
        }
        // nothing happened after all: the matrix product has the bits of the quick step
        if events == 0 {
            *state = start;
            state.store(self.offset(state.mode), after, travel);
        }
    }

    /// Advances to the first event within `left` seconds, or to their end. Returns the time taken
    /// and the event.
    fn advance(
        &self,
        state: &mut PlantState,
        held: &Held,
        left: f64,
        vanishing: Vanishing,
        look: bool,
    ) -> Option<(f64, Event)> {
        let x = state.vector(self.offset(state.mode));
        // the exact solution over the rest of the piece, and every guard a polynomial on it
        let taylor = Taylor::new(&self.params, state.mode, &x, held, left);
        let first = if look {
            self.first_event(state.mode, held, &taylor, vanishing)
        } else {
            None
        };
        let tau = first.map_or(1.0, |(tau, _)| tau);
        let (next, travel) = taylor.at(tau, left);
        state.store(self.offset(state.mode), &next, travel);
        first.map(|(tau, event)| (tau * left, event))
    }

    fn first_event(
        &self,
        mode: Mode,
        held: &Held,
        taylor: &Taylor,
        vanishing: Vanishing,
    ) -> Option<(f64, Event)> {
        let mut first: Option<(f64, Event)> = None;
        for guard in Guards::of(&self.params, mode, held).iter() {
            // the guard of the event just passed starts at zero; rounding must not make it fire
            // again
            let zeros = match vanishing {
                Some((event, zeros)) if event == guard.event => zeros,
                _ => 0,
            };
            let polynomial = taylor.functional(guard.offset, &guard.row);
            if let Some(tau) = curved_step::first_crossing(&polynomial, zeros)
                && first.is_none_or(|(earliest, _)| tau < earliest)
            {
                first = Some((tau, guard.event));
            }
        }
        first
    }
}
