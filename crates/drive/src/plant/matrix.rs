//! Exponential of a small matrix.

/// A square matrix, row by row.
pub(super) type Matrix<const N: usize> = [[f64; N]; N];

const TERMS: u32 = 24;

fn product<const N: usize>(a: &Matrix<N>, b: &Matrix<N>) -> Matrix<N> {
    let mut out = [[0.0; N]; N];
    for (row, a_row) in out.iter_mut().zip(a) {
        for (k, &factor) in a_row.iter().enumerate() {
            if factor == 0.0 {
                continue;
            }
            for (entry, &b_entry) in row.iter_mut().zip(&b[k]) {
                *entry += factor * b_entry;
            }
        }
    }
    out
}

/// `exp(a * time)` by Taylor's series with scaling and squaring.
///
/// `rate` bounds the norm of `a` in units in which its entries are balanced. The series converges
/// as in those units whatever units the entries are in, so a shaft in rad and a current in A need
/// no more squarings than their physics asks for.
pub(super) fn exponential<const N: usize>(a: &Matrix<N>, time: f64, rate: f64) -> Matrix<N> {
    let mut squarings = 0;
    let mut step = time;
    while rate * step > 1.0 && squarings < 40 {
        step *= 0.5;
        squarings += 1;
    }
    let mut term = [[0.0; N]; N];
    for (i, row) in term.iter_mut().enumerate() {
        row[i] = 1.0;
    }
    let mut sum = term;
    for n in 1..=TERMS {
        term = product(&term, a);
        let factor = step / f64::from(n);
        for (term_row, sum_row) in term.iter_mut().zip(&mut sum) {
            for (t, s) in term_row.iter_mut().zip(sum_row) {
                *t *= factor;
                *s += *t;
            }
        }
    }
    for _ in 0..squarings {
        sum = product(&sum, &sum);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::math;

    #[test]
    fn rotation_and_decay_have_their_closed_forms() {
        let (omega, decay, time) = (700.0, 30.0, 0.01);
        let a = [[-decay, omega], [-omega, -decay]];
        let e = exponential(&a, time, 800.0);
        let (scale, angle) = (math::exp(-decay * time), omega * time);
        assert!((e[0][0] - scale * math::cos(angle)).abs() < 1e-14);
        assert!((e[0][1] - scale * math::sin(angle)).abs() < 1e-14);
        assert!((e[1][0] + scale * math::sin(angle)).abs() < 1e-14);
    }

    #[test]
    fn a_shift_stays_exact() {
        // coasting: position' = speed; squaring must not disturb the unit entries
        let e = exponential(&[[0.0, 1.0], [0.0, 0.0]], 5e-5, 1e6);
        assert_eq!(e, [[1.0, 5e-5], [0.0, 1.0]]);
    }
}
