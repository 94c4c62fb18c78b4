//! Symmetric matrices with two bands on either side: the diagonal and the two entries after it in
//! each row.

/// Adds the share of one interval: gradient and upper triangle of the second derivatives by three
/// values that are sums over three coefficients.
pub(super) fn gather(
    basis: &[[f64; 3]; 3],
    g: &[f64; 3],
    h: &[[f64; 3]; 3],
    right: &mut [f64],
    bands: &mut [[f64; 3]],
) {
    let full = |i: usize, k: usize| if i <= k { h[i][k] } else { h[k][i] };
    let mut product = [[0.0; 3]; 3];
    for (i, row) in product.iter_mut().enumerate() {
        for (q, value) in row.iter_mut().enumerate() {
            *value = full(i, 0) * basis[0][q] + full(i, 1) * basis[1][q] + full(i, 2) * basis[2][q];
        }
    }
    for p in 0..3 {
        right[p] += g[0] * basis[0][p] + g[1] * basis[1][p] + g[2] * basis[2][p];
        for q in p..3 {
            bands[p][q - p] += basis[0][p] * product[0][q]
                + basis[1][p] * product[1][q]
                + basis[2][p] * product[2][q];
        }
    }
}

/// Solves for all unknowns but the first and the last two, which become 0.
pub(super) fn solve_inner(bands: &mut [[f64; 3]], x: &mut [f64]) {
    let n = bands.len();
    for fixed in [0, 1, n - 2, n - 1] {
        x[fixed] = 0.0;
        bands[fixed] = [1.0, 0.0, 0.0];
    }
    bands[n - 4][2] = 0.0;
    bands[n - 3][1] = 0.0;
    bands[n - 3][2] = 0.0;
    solve(bands, x);
}

/// Solves a positive definite system by LDL'.
fn solve(bands: &mut [[f64; 3]], x: &mut [f64]) {
    let n = bands.len();
    for i in 0..n {
        let [d, e, f] = bands[i];
        let (l1, l2) = (e / d, f / d);
        if i + 1 < n {
            bands[i + 1][0] -= l1 * e;
            bands[i + 1][1] -= l1 * f;
            x[i + 1] -= l1 * x[i];
        }
        if i + 2 < n {
            bands[i + 2][0] -= l2 * f;
            x[i + 2] -= l2 * x[i];
        }
        bands[i] = [d, l1, l2];
    }
    for i in (0..n).rev() {
        let [d, l1, l2] = bands[i];
        let mut value = x[i] / d;
        if i + 1 < n {
            value -= l1 * x[i + 1];
        }
        if i + 2 < n {
            value -= l2 * x[i + 2];
        }
        x[i] = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_solution_solves() {
        let entry = |i: usize, k: usize| match i.abs_diff(k) {
            0 => 5.0 + i as f64,
            1 => -1.0 - 0.1 * i.min(k) as f64,
            2 => 0.7,
            _ => 0.0,
        };
        let mut bands: Vec<[f64; 3]> = (0..7)
            .map(|i| [entry(i, i), entry(i, i + 1), entry(i, i + 2)])
            .collect();
        let right: Vec<f64> = (0..7).map(|i| 1.0 - 0.3 * i as f64).collect();
        let mut x = right.clone();
        solve(&mut bands, &mut x);
        for (i, right) in right.iter().enumerate() {
            let product: f64 = (0..7).map(|k| entry(i, k) * x[k]).sum();
            assert!((product - right).abs() < 1e-12);
        }
    }
}
