//! Small symmetric systems by Cholesky.

/// Pivots are no smaller, so that what is not determined stays finite.
const LEAST_PIVOT: f64 = 1e-14;

/// Factor of a symmetric matrix given by its lower half.
pub(super) fn factor<const M: usize>(a: &[[f64; M]; M]) -> [[f64; M]; M] {
    let mut l = [[0.0; M]; M];
    for i in 0..M {
        for j in 0..i {
            let sum: f64 = (0..j).map(|k| l[i][k] * l[j][k]).sum();
            l[i][j] = (a[i][j] - sum) / l[j][j];
        }
        let sum: f64 = (0..i).map(|k| l[i][k] * l[i][k]).sum();
        l[i][i] = (a[i][i] - sum).max(LEAST_PIVOT).sqrt();
    }
    l
}

/// Solves with a factor.
pub(super) fn solve<const M: usize>(l: &[[f64; M]; M], right: &[f64; M]) -> [f64; M] {
    let mut x = [0.0; M];
    for i in 0..M {
        let sum: f64 = (0..i).map(|k| l[i][k] * x[k]).sum();
        x[i] = (right[i] - sum) / l[i][i];
    }
    for i in (0..M).rev() {
        let sum: f64 = (i + 1..M).map(|k| l[k][i] * x[k]).sum();
        x[i] = (x[i] - sum) / l[i][i];
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_solves_what_was_multiplied() {
        let a = [
            [4.0, 1.0, 0.0, 0.5],
            [1.0, 3.0, 0.2, 0.0],
            [0.0, 0.2, 2.0, 0.1],
            [0.5, 0.0, 0.1, 1.0],
        ];
        let wanted = [1.0, -2.0, 0.5, 3.0];
        let right = a.map(|row| row.iter().zip(wanted).map(|(a, x)| a * x).sum::<f64>());
        for (x, wanted) in solve(&factor(&a), &right).into_iter().zip(wanted) {
            assert!((x - wanted).abs() < 1e-12, "{x} {wanted}");
        }
    }
}
