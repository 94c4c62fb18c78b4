//! A step of a plant that is not linear: series as long as they settle, split at the same events as
//! the linear one.

use super::dynamics::{COEFFICIENTS, Held, PENETRATION, Vector};
use super::expansion::Expansion;
use super::guard::{Event, Vanishing};
use super::mode::{Contact, Friction, Mass, Side};
use super::series::Series;
use super::state::PlantState;
use super::{LARGEST_RATE_SPAN, MAX_EVENTS, Plant};
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
        // the guard as a polynomial of tau
        let mut guard = series.map(|c| sign * c);
        guard[0] += offset;
        let zeros = match self.vanishing {
            Some((vanishing, zeros)) if vanishing == event => zeros,
            _ => 0,
        };
        // its constant outweighs all the rest: it stays positive
        if guard[0] > guard[1..].iter().map(|c| c.abs()).sum() {
            return;
        }
        // of events at the same instant the one listed first happens
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
        // a first length of the Taylor pieces from the fastest rate at this speed
        let mut span = LARGEST_RATE_SPAN
            / self
                .params
                .rate_at(state.motor_velocity, state.load_velocity);
        let (mut events, mut vanishing) = (0, None);
        while left > 0.0 {
            let part = span.min(left);
            let expansion = Expansion::new(&self.params, state, held, part);
            // halve the piece until the last coefficients are below rounding
            if !expansion.is_settled() && part > SMALLEST_PART * self.params.period_s {
                span = 0.5 * part;
                continue;
            }
            let first = if events < MAX_EVENTS {
                self.first_curved_event(state, &expansion, vanishing)
            } else {
                None
            };
            // no event: take the whole piece, and try a longer one next
            let Some((tau, event)) = first else {
                expansion.store(state, 1.0);
                vanishing = None;
                left -= part;
                span = 2.0 * part;
                continue;
            };
            // up to the event, across it, and on in the mode that follows
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
        // contact before friction, as in `Guards`
        self.contact_guards(state, expansion, &mut search);
        for (index, mass) in [Mass::Motor, Mass::Load].into_iter().enumerate() {
            let (speed, slow) = (
                &expansion.speed[index],
                self.params.friction(mass).speed_rad_s,
            );
            match state.mode.friction(mass) {
                Friction::None => {}
                Friction::Bristles(side) => {
                    // the law has |w| in it: its series holds as long as the speed keeps its sign
                    search.guard(Event::Turn(mass), side.sign(), speed, 0.0);
                }
                Friction::Sliding(side) if self.params.friction(mass).creeps() => {
                    // below v_s friction rises with falling speed: another mode
                    search.guard(Event::Slow(mass), side.sign(), speed, -slow);
                }
                Friction::Sliding(side) => search.guard(Event::Stop(mass), side.sign(), speed, 0.0),
                Friction::Creeping(side) => {
                    search.guard(Event::Stop(mass), side.sign(), speed, 0.0);
                    search.guard(Event::Fast(mass), -side.sign(), speed, slow);
                }
                Friction::Stuck => {
                    // breaks away where the torque exceeds the static friction, in either direction
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
        // the guards of the linear plant (`guard`), as series
        let sum =
            |a: &Series, b: &Series, factor: f64| std::array::from_fn(|n| a[n] + factor * b[n]);
        let s = state.mode.contact.sign();
        match state.mode.contact {
            Contact::Rigid => {}
            Contact::Gap => {
                // the gap's width is a series where the flanks are worn
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
                // the spring is doubled as long as the damper would give more than it
                search.guard(Event::Desaturate, -s, &sum(&spring, &damper, -1.0), 0.0);
            }
            Contact::Lifted(_) => {
                // without torque the flank is left, or pushed again once spring and damper together
                // would push
                search.guard(Event::Open, s, &expansion.depth, 0.0);
                let (spring, damper) = expansion.spring_and_damper();
                search.guard(Event::Reload, -s, &sum(&spring, &damper, 1.0), 0.0);
            }
        }
    }

    /// Puts the state on the event's boundary and into the mode that follows.
    fn curved_switch(&self, state: &mut PlantState, event: Event, need: [f64; 2]) -> Vanishing {
        let before = state.mode.contact;
        // `switch` thinks in states counted from the flank
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
        // closing and opening put the gap angle onto the flank, which wear may have moved
        let flank = match event {
            Event::Close(side) => side.sign(),
            Event::Open => before.sign(),
            _ => return vanishing,
        };
        state.gap_angle = self.params.flank_at(flank, state.load_position);
        vanishing
    }
}

// First crossing of a polynomial to below zero on [0, 1].
//
// In Bernstein's form a polynomial lies in the hull of its coefficients, and has no more roots in
// (0, 1) than they have changes of sign. So no crossing is overlooked, however short the
// excursion, and most polynomials are settled by one look.

type Poly = [f64; COEFFICIENTS];
const LAST: usize = COEFFICIENTS - 1;
/// Halvings of [0, 1] in the search for the first of several roots; a shorter excursion counts as
/// touching.
const ROOT_HALVINGS: u32 = 40;

/// The smallest tau in [0, 1] from which the polynomial (by powers) is negative; none if it is not.
///
/// The first `zeros` coefficients are known to vanish, whatever rounding has made of them. A
/// polynomial that starts at zero crosses there if it leaves downwards.
pub(super) fn first_crossing(power: &Poly, zeros: usize) -> Option<f64> {
    // a zero at the start of known order is divided out: what is left decides which way it leaves
    let mut power = *power;
    let mut lead = 0;
    while lead < COEFFICIENTS && (lead < zeros || power[lead] == 0.0) {
        lead += 1;
    }
    if lead == COEFFICIENTS {
        return None;
    }
    power.rotate_left(lead);
    power[COEFFICIENTS - lead..].fill(0.0);
    // negative from the start, as after a jump of the voltage or the load torque: the event is now
    if power[0] < 0.0 {
        return Some(0.0);
    }
    search(&bernstein(&power), &power, 0.0, 1.0, ROOT_HALVINGS)
}

fn bernstein(power: &Poly) -> Poly {
    let mut out = *power;
    // out[j] = sum over i <= j of C(j,i)/C(n,i) power[i], by repeated running sums of
    // power[i]/C(n,i)
    let mut binomial = 1.0;
    for (i, entry) in out.iter_mut().enumerate() {
        *entry /= binomial;
        binomial *= (LAST - i) as f64 / (i + 1) as f64;
    }
    for round in 0..LAST {
        for j in (round..LAST).rev() {
            out[j + 1] += out[j];
        }
    }
    out
}

fn search(form: &Poly, power: &Poly, low: f64, high: f64, depth: u32) -> Option<f64> {
    // Descartes: no more roots in between than changes of sign
    let changes = form
        .windows(2)
        .filter(|pair| (pair[0] < 0.0) != (pair[1] < 0.0))
        .count();
    match changes {
        0 => (form[0] < 0.0).then_some(low),
        // exactly one root, downwards
        1 if form[0] >= 0.0 && form[LAST] < 0.0 => Some(root(power, low, high)),
        _ if depth == 0 => None,
        _ => {
            // several are possible: halve, the earlier half first
            let (left, right) = halves(form);
            let middle = 0.5 * (low + high);
            search(&left, power, low, middle, depth - 1)
                .or_else(|| search(&right, power, middle, high, depth - 1))
        }
    }
}

/// De Casteljau's subdivision at the middle.
fn halves(form: &Poly) -> (Poly, Poly) {
    let (mut left, mut right) = (*form, *form);
    for (level, entry) in left.iter_mut().enumerate() {
        *entry = right[0];
        for j in 0..LAST - level {
            right[j] = 0.5 * (right[j] + right[j + 1]);
        }
    }
    (left, right)
}

fn value_and_slope(power: &Poly, tau: f64) -> (f64, f64) {
    let (mut value, mut slope) = (0.0, 0.0);
    for c in power.iter().rev() {
        slope = slope * tau + value;
        value = value * tau + c;
    }
    (value, slope)
}

/// The one root between `low` (not negative there) and `high` (negative there): Newton's steps,
/// halved where they leave the bracket.
fn root(power: &Poly, mut low: f64, mut high: f64) -> f64 {
    let mut tau = 0.5 * (low + high);
    // 50 halvings reach 1e-15; near a double root Newton's steps halve the distance, too
    for _ in 0..100 {
        let (value, slope) = value_and_slope(power, tau);
        // keep the bracket
        if value < 0.0 {
            high = tau;
        } else {
            low = tau;
        }
        // Newton where it stays in the bracket, else bisection
        let newton = tau - value / slope;
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        if (next - tau).abs() <= 1e-15 || high - low <= 1e-15 {
            return next;
        }
        tau = next;
    }
    tau
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from_roots(roots: &[f64], scale: f64) -> Poly {
        let mut poly = [0.0; COEFFICIENTS];
        poly[0] = scale;
        for &r in roots {
            for i in (0..COEFFICIENTS).rev() {
                poly[i] = if i > 0 { poly[i - 1] } else { 0.0 } - r * poly[i];
            }
        }
        poly
    }

    #[test]
    fn finds_the_first_of_several() {
        let found = first_crossing(&from_roots(&[0.9, 0.3, 0.300_01], -1.0), 0);
        assert!((found.unwrap() - 0.3).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn short_excursion_is_seen_and_touching_is_not_one() {
        assert!(first_crossing(&from_roots(&[0.5, 0.5 + 1e-6], 1.0), 0).is_some());
        let mut touching = from_roots(&[0.5, 0.5], 1.0);
        touching[0] += 1e-9;
        assert_eq!(first_crossing(&touching, 0), None);
    }

    #[test]
    fn a_start_at_zero_goes_by_where_it_leaves() {
        assert_eq!(first_crossing(&from_roots(&[0.0], -1.0), 0), Some(0.0));
        assert_eq!(first_crossing(&from_roots(&[0.0], 1.0), 0), None);
        let mut noisy = from_roots(&[0.0, 0.7], -1.0);
        noisy[0] = -1e-18;
        assert!((first_crossing(&noisy, 1).unwrap() - 0.7).abs() < 1e-14);
    }
}
