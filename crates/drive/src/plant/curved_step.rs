//! A step of a plant that is not linear: series as long as they settle, split at the same events as
//! the linear one.

use super::crossing::first_crossing;
use super::dynamics::{Held, PENETRATION, Vector};
use super::expansion::Expansion;
use super::guard::{Event, Vanishing};
use super::mode::{Contact, Friction, Mass, Side};
use super::series::Series;
use super::state::PlantState;
use super::{MAX_EVENTS, PIECE, Plant};
use crate::config::ContactLaw;

/// Parts of a period below which a span is not cut, settled or not, so that no input whatever can
/// hang a run.
const SMALLEST_PART: f64 = 1.0 / 4096.0;

/// The earliest event found so far.
struct Search {
    vanishing: Vanishing,
    first: Option<(f64, Event)>,
}

impl Search {
    /// A guard: not negative as long as the mode lasts.
    fn guard(&mut self, event: Event, sign: f64, series: &Series, offset: f64) {
        let mut guard = series.map(|c| sign * c);
        guard[0] += offset;
        let zeros = match self.vanishing {
            Some((vanishing, zeros)) if vanishing == event => zeros,
            _ => 0,
        };
        if guard[0] > guard[1..].iter().map(|c| c.abs()).sum() {
            return;
        }
        if let Some(tau) = first_crossing(&guard, zeros)
            && self.first.is_none_or(|(earliest, _)| tau < earliest)
        {
            self.first = Some((tau, event));
        }
    }
}

impl Plant {
    /// One period.
    #[cold]
    #[inline(never)]
    pub(super) fn curved_step(&self, state: &mut PlantState, held: &Held) {
        let mut left = self.params.period_s;
        let mut span = PIECE
            / self
                .params
                .rate_at(state.motor_velocity, state.load_velocity);
        let (mut events, mut vanishing) = (0, None);
        while left > 0.0 {
            let part = span.min(left);
            let expansion = Expansion::new(&self.params, state, held, part);
            if !expansion.is_settled() && part > SMALLEST_PART * self.params.period_s {
                span = 0.5 * part;
                continue;
            }
            let first = if events < MAX_EVENTS {
                self.first_curved_event(state, &expansion, vanishing)
            } else {
                None
            };
            let Some((tau, event)) = first else {
                expansion.store(state, 1.0);
                vanishing = None;
                left -= part;
                span = 2.0 * part;
                continue;
            };
            expansion.store(state, tau);
            vanishing = self.curved_switch(state, event, expansion.need_at(tau));
            state.events += u64::from(!matches!(event, Event::Turn(_)));
            events += 1;
            left -= tau * part;
        }
    }

    fn first_curved_event(
        &self,
        state: &PlantState,
        expansion: &Expansion<'_>,
        vanishing: Vanishing,
    ) -> Option<(f64, Event)> {
        let mut search = Search {
            vanishing,
            first: None,
        };
        self.contact_guards(state, expansion, &mut search);
        for (index, mass) in [Mass::Motor, Mass::Load].into_iter().enumerate() {
            let (speed, slow) = (
                &expansion.speed[index],
                self.params.friction(mass).speed_rad_s,
            );
            match state.mode.friction(mass) {
                Friction::None => {}
                Friction::Bristles(side) => {
                    search.guard(Event::Turn(mass), side.sign(), speed, 0.0)
                }
                Friction::Sliding(side) if self.params.friction(mass).creeps() => {
                    search.guard(Event::Slow(mass), side.sign(), speed, -slow);
                }
                Friction::Sliding(side) => search.guard(Event::Stop(mass), side.sign(), speed, 0.0),
                Friction::Creeping(side) => {
                    search.guard(Event::Stop(mass), side.sign(), speed, 0.0);
                    search.guard(Event::Fast(mass), -side.sign(), speed, slow);
                }
                Friction::Stuck => {
                    let limit = self.params.breakaway(mass);
                    search.guard(
                        Event::Break(mass, Side::Positive),
                        -1.0,
                        &expansion.need[index],
                        limit,
                    );
                    search.guard(
                        Event::Break(mass, Side::Negative),
                        1.0,
                        &expansion.need[index],
                        limit,
                    );
                }
            }
        }
        search.first
    }

    fn contact_guards(&self, state: &PlantState, expansion: &Expansion<'_>, search: &mut Search) {
        let law = self.params.contact;
        let sum =
            |a: &Series, b: &Series, factor: f64| std::array::from_fn(|n| a[n] + factor * b[n]);
        let s = state.mode.contact.sign();
        match state.mode.contact {
            Contact::Rigid => {}
            Contact::Gap => {
                let half = expansion.half_gap();
                search.guard(
                    Event::Close(Side::Positive),
                    1.0,
                    &sum(&half, &expansion.depth, -1.0),
                    0.0,
                );
                search.guard(
                    Event::Close(Side::Negative),
                    1.0,
                    &sum(&half, &expansion.depth, 1.0),
                    0.0,
                );
            }
            Contact::Spring(_) => {
                search.guard(Event::Open, s, &expansion.depth, 0.0);
                let (spring, damper) = expansion.spring_and_damper();
                if law != ContactLaw::Linear {
                    search.guard(Event::Release, s, &sum(&spring, &damper, 1.0), 0.0);
                }
                if law == ContactLaw::Bounded {
                    search.guard(Event::Saturate, s, &sum(&spring, &damper, -1.0), 0.0);
                }
            }
            Contact::Doubled(_) => {
                let (spring, damper) = expansion.spring_and_damper();
                search.guard(Event::Desaturate, -s, &sum(&spring, &damper, -1.0), 0.0);
            }
            Contact::Lifted(_) => {
                search.guard(Event::Open, s, &expansion.depth, 0.0);
                let (spring, damper) = expansion.spring_and_damper();
                search.guard(Event::Reload, -s, &sum(&spring, &damper, 1.0), 0.0);
            }
        }
    }

    /// Puts the state on the event's boundary and into the mode that follows.
    fn curved_switch(&self, state: &mut PlantState, event: Event, need: [f64; 2]) -> Vanishing {
        let before = state.mode.contact;
        let depth = state.gap_angle - self.params.flank_at(before.sign(), state.load_position);
        let mut x: Vector = [
            state.current_q,
            depth,
            state.motor_velocity,
            state.load_velocity,
        ];
        x[PENETRATION] = depth;
        let (mode, vanishing) =
            self.params
                .switch(event, state.mode, &mut x, |mass, _| match mass {
                    Mass::Motor => need[0],
                    Mass::Load => need[1],
                });
        state.mode = mode;
        [_, _, state.motor_velocity, state.load_velocity] = x;
        let flank = match event {
            Event::Close(side) => side.sign(),
            Event::Open => before.sign(),
            _ => return vanishing,
        };
        state.gap_angle = self.params.flank_at(flank, state.load_position);
        vanishing
    }
}
