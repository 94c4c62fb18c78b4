//! Polynomials of one axis by their Bernstein coefficients; rows of six hold them from the front.

/// The coefficients over the stretch from `u0` to `u1` of the first N of a row.
pub(super) fn row<const N: usize>(row: &[f64; 6], u0: f64, u1: f64) -> [f64; N] {
    let mut points = [0.0; N];
    points.copy_from_slice(&row[..N]);
    // The beginning up to u1 first; u0 is then at u0 / u1 of it.
    let head = if u1 < 1.0 {
        split(points, u1).0
    } else {
        points
    };
    if u0 > 0.0 && u1 > 0.0 {
        split(head, u0 / u1).1
    } else {
        head
    }
}

/// De Casteljau's subdivision: coefficients before and after u.
fn split<const N: usize>(points: [f64; N], u: f64) -> ([f64; N], [f64; N]) {
    let (mut work, mut head, mut tail) = (points, points, points);
    for level in 0..N {
        // The outermost points of each level are control points of the two parts.
        head[level] = work[0];
        tail[N - 1 - level] = work[N - 1 - level];
        for i in 0..N - 1 - level {
            work[i] += (work[i + 1] - work[i]) * u;
        }
    }
    (head, tail)
}

/// Bernstein polynomials of degree N - 1 at u.
pub(super) fn bernstein<const N: usize>(u: f64) -> [f64; N] {
    let mut basis = [0.0; N];
    basis[0] = 1.0;
    for degree in 1..N {
        raise(&mut basis[..=degree], u);
    }
    basis
}

/// Those of the next degree from those of one: M is N + 1.
pub(super) fn raised<const N: usize, const M: usize>(basis: &[f64; N], u: f64) -> [f64; M] {
    let mut next = [0.0; M];
    next[..N].copy_from_slice(basis);
    raise(&mut next, u);
    next
}

fn raise(basis: &mut [f64], u: f64) {
    // Downwards: each entry needs its lower neighbour of the degree before.
    for i in (1..basis.len()).rev() {
        basis[i] = basis[i] * (1.0 - u) + basis[i - 1] * u;
    }
    basis[0] *= 1.0 - u;
}

/// Sum of rows with their weights, axis by axis.
pub(super) fn mixed<const N: usize, const M: usize>(
    rows: &[[f64; N]; M],
    weights: &[f64; M],
) -> [f64; N] {
    let mut sum = [0.0; N];
    for (row, weight) in rows.iter().zip(weights) {
        for (sum, value) in sum.iter_mut().zip(row) {
            *sum += value * weight;
        }
    }
    sum
}

/// Differences of neighbouring rows: L is M - 1.
pub(super) fn differences<const N: usize, const M: usize, const L: usize>(
    rows: &[[f64; N]; M],
) -> [[f64; N]; L] {
    std::array::from_fn(|i| std::array::from_fn(|axis| rows[i + 1][axis] - rows[i][axis]))
}

/// Largest magnitude.
pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| most.max(value.abs()))
}
