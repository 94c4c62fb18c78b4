//! Integration by the solvers of the crate `differential-equations`.
//!
//! The solver stops at the first step after which a guard is negative; where in that step it became
//! so is found by halving, on the solver's own solution from the step's start (the crate's root
//! finder on interpolated states can end beside the root).

use super::{Cause, Machine, Phase, State};
use differential_equations::control::ControlFlag;
use differential_equations::interpolate::Interpolation;
use differential_equations::prelude::*;
use differential_equations::solout::Solout;
use differential_equations::solution::Solution;

/// Which solver, with which tolerance.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Method {
    /// Radau IIA of order 5: implicit, for stiff equations.
    Radau(f64),
    /// Dormand and Prince's explicit method of order 8.
    Explicit(f64),
}

/// How far a guard has to be negative: a mode may begin on the boundary, to rounding.
const PAST: f64 = -1e-13;

/// Longest step of the implicit method, s. Left to its own control at 1e-12 it lets 3e-6 of a gap
/// through.
const RADAU_STEP: f64 = 1e-5;

struct Running<'a> {
    machine: &'a Machine,
    phase: &'a Phase,
}

impl ODE<f64, State> for Running<'_> {
    fn diff(&self, _: f64, y: &State, out: &mut State) {
        *out = self.machine.derivative(self.phase, y);
    }
}

/// Keeps the last step, and stops after one that ends past a guard.
struct Watch<'a>(&'a Running<'a>);

impl Solout<f64, State> for Watch<'_> {
    fn solout<I>(
        &mut self,
        now: f64,
        before: f64,
        y: &State,
        y_before: &State,
        _: &mut I,
        kept: &mut Solution<f64, State>,
    ) -> ControlFlag<f64, State>
    where
        I: Interpolation<f64, State> + ?Sized,
    {
        (kept.t, kept.y) = (vec![before, now], vec![*y_before, *y]);
        if now > before && self.0.past(y) {
            ControlFlag::Terminate
        } else {
            ControlFlag::Continue
        }
    }
}

impl Running<'_> {
    fn past(&self, y: &State) -> bool {
        self.machine.lowest(self.phase, y).0 < PAST
    }

    /// Start and end of the last step, to the end of the span or to the first step past a guard.
    fn last_step(&self, method: Method, start: State, span: f64) -> [(f64, State); 2] {
        let problem = IVP::ode(self, 0.0, span, start).solout(Watch(self));
        let solution = match method {
            Method::Radau(tolerance) => problem
                .method(
                    ImplicitRungeKutta::radau5()
                        .h_max(RADAU_STEP)
                        .rtol(tolerance)
                        .atol(1e-3 * tolerance),
                )
                .solve(),
            Method::Explicit(tolerance) => problem
                .method(
                    ExplicitRungeKutta::dop853()
                        .rtol(tolerance)
                        .atol(1e-3 * tolerance),
                )
                .solve(),
        };
        match solution {
            Ok(solution) => [
                (solution.t[0], solution.y[0]),
                (solution.t[1], solution.y[1]),
            ],
            Err(error) => panic!("the solver gave up: {error:?} at {:?}", self.phase),
        }
    }

    /// The first instant past a guard within a step, from its start.
    fn locate(&self, method: Method, start: State, step: f64, mut end: State) -> (f64, State) {
        let (mut low, mut high) = (0.0, step);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if middle < 1e-14 || high - low < 1e-15 {
                break;
            }
            let [_, (_, y)] = self.last_step(method, start, middle);
            if self.past(&y) {
                (high, end) = (middle, y);
            } else {
                low = middle;
            }
        }
        (high, end)
    }
}

impl Machine {
    /// Advances by `span` seconds.
    pub(crate) fn advance(&self, phase: &mut Phase, span: f64, method: Method) {
        let mut left = span;
        for _ in 0..200 {
            let running = Running {
                machine: self,
                phase,
            };
            let [(before, y_before), (now, y)] = running.last_step(method, phase.y, left);
            if !running.past(&y) {
                phase.y = y;
                return;
            }
            let (time, y) = running.locate(method, y_before, now - before, y);
            let (_, Some(cause)) = self.lowest(phase, &y) else {
                panic!("an event of no guard")
            };
            let cause: Cause = cause;
            phase.y = y;
            self.switch(phase, cause);
            left -= before + time;
            if left < 1e-15 {
                return;
            }
        }
        panic!("no end of events: {phase:?}");
    }
}
