//! How a window meets what is around it.

use super::banded::Banded;

/// How a window meets what is around it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum End {
    /// In a given state of motion: two coefficients stay as they are.
    #[default]
    Moving,
    /// At rest: beta, which has no influence on the joints there, is constant over so many
    /// intervals.
    Rest(usize),
}

/// Takes what is given or tied out of a system for the change of the coefficients.
pub(super) fn hold([start, end]: [End; 2], matrix: &mut Banded, right: &mut [f64]) {
    let last = right.len() - 1;
    let mut given = |index: usize| {
        matrix.isolate(index);
        right[index] = 0.0;
    };
    if start == End::Moving {
        [0, 1].into_iter().for_each(&mut given);
    }
    if end == End::Moving {
        [last - 1, last].into_iter().for_each(&mut given);
    }
    if let End::Rest(tied) = start {
        for index in 0..tied {
            matrix.tie_up(index);
            right[index + 1] += right[index];
            right[index] = 0.0;
        }
    }
    if let End::Rest(tied) = end {
        for index in (last + 1 - tied..=last).rev() {
            matrix.tie_down(index);
            right[index - 1] += right[index];
            right[index] = 0.0;
        }
    }
}

/// Gives tied coefficients the change of the one that they are tied to.
pub(super) fn follow([start, end]: [End; 2], change: &mut [f64]) {
    if let End::Rest(tied) = start {
        let free = change[tied];
        change[..tied].fill(free);
    }
    if let End::Rest(tied) = end {
        let last = change.len() - 1 - tied;
        let free = change[last];
        change[last + 1..].fill(free);
    }
}
