//! The current loops over a period, for axes and for the models of compensators.

use super::vector::Vector;
use pulp::Simd;

/// What the current loops compute with, d before q.
#[derive(Clone, Copy)]
pub(super) struct Fast<V> {
    pub(super) gain: V,
    pub(super) share: V,
    pub(super) limit_squared: V,
    pub(super) delayed: V,
    pub(super) command: V,
    pub(super) cross: V,
    pub(super) back_emf: V,
    pub(super) current: [V; 2],
    pub(super) integral: [V; 2],
    pub(super) pending: [V; 2],
}

/// What they answer: where the voltage would be cut, the voltages applied, the next integrals, the
/// voltages computed.
#[derive(Clone, Copy)]
pub(super) struct Voltages<V, M> {
    pub(super) limited: M,
    pub(super) voltage: [V; 2],
    pub(super) integral: [V; 2],
    pub(super) free: [V; 2],
}

impl<S: Simd> Vector<S> {
    /// The current loops over a period: what `CurrentState::voltage` computes as long as no voltage
    /// is cut.
    #[inline(always)]
    pub(super) fn current_loop(self, x: &Fast<S::f64s>) -> Voltages<S::f64s, S::m64s> {
        let [current_d, current_q] = x.current;
        let error_d = self.simd.neg_f64s(current_d);
        let error_q = self.sub(x.command, current_q);
        let (push_d, push_q) = (self.mul(x.gain, error_d), self.mul(x.gain, error_q));
        let free_d = self.sub(
            self.add(push_d, x.integral[0]),
            self.mul(x.cross, current_q),
        );
        let free_q = self.add(
            self.add(
                self.add(push_q, x.integral[1]),
                self.mul(x.cross, current_d),
            ),
            x.back_emf,
        );
        let size = self.add(self.mul(free_d, free_d), self.mul(free_q, free_q));
        let delayed = self.less(self.all(0.0), x.delayed);
        let next = |integral, push, free| {
            self.add(
                integral,
                self.mul(x.share, self.add(push, self.sub(free, free))),
            )
        };
        Voltages {
            limited: self.less(x.limit_squared, size),
            voltage: [
                self.choose(delayed, x.pending[0], free_d),
                self.choose(delayed, x.pending[1], free_q),
            ],
            integral: [
                next(x.integral[0], push_d, free_d),
                next(x.integral[1], push_q, free_q),
            ],
            free: [free_d, free_q],
        }
    }
}
