//! Pieces of a Huber loss, its curvature and gradient, and the small dense algebra on them.

use faer::{
    Mat, Side,
    linalg::solvers::{Llt, Solve},
};

use super::Regression;

/// What is assumed of a sample's residual, in units of delta.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Piece {
    /// Nothing: the sample has its own variables.
    Explicit,
    /// It ends in the square part.
    Square,
    /// It ends above delta.
    Above,
    /// It ends below -delta.
    Below,
}

impl Piece {
    pub(super) fn assume(residual: f64, band: f64) -> Self {
        if (residual.abs() - 1.0).abs() <= band {
            Piece::Explicit
        } else {
            Self::of(residual)
        }
    }

    /// The piece that a residual lies in.
    pub(crate) fn of(residual: f64) -> Self {
        if residual.abs() <= 1.0 {
            Piece::Square
        } else if residual > 0.0 {
            Piece::Above
        } else {
            Piece::Below
        }
    }

    pub(super) fn holds(self, residual: f64) -> bool {
        match self {
            Piece::Explicit => true,
            Piece::Square => residual.abs() <= 1.0,
            Piece::Above => residual >= 1.0,
            Piece::Below => residual <= -1.0,
        }
    }
}

/// Second-order picture of the loss at a point, in the regression's own units with delta 1.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalEquations<const P: usize> {
    /// `sum a a'` over the samples in the square part.
    pub matrix: [[f64; P]; P],
    /// `sum a psi(r)`: the negative gradient.
    pub gradient: [f64; P],
}

impl<const P: usize> Default for NormalEquations<P> {
    fn default() -> Self {
        Self {
            matrix: [[0.0; P]; P],
            gradient: [0.0; P],
        }
    }
}

impl<const P: usize> NormalEquations<P> {
    /// Of the whole loss at `z`.
    pub fn at(data: &Regression<P>, z: &[f64; P]) -> Self {
        let mut normal = Self::default();
        for (k, row) in data.rows.iter().enumerate() {
            let residual = data.residual(k, z);
            normal.add(row, residual, Piece::of(residual));
        }
        normal
    }

    /// At zero, with every sample in the square part.
    pub(super) fn square(data: &Regression<P>) -> Self {
        let mut normal = Self::default();
        data.rows
            .iter()
            .zip(&data.targets)
            .for_each(|(row, &target)| normal.add(row, target, Piece::Square));
        normal
    }

    /// Of the samples that are summed up, around a centre.
    pub(super) fn of_pieces(data: &Regression<P>, pieces: &[Piece], centre: &[f64; P]) -> Self {
        let mut normal = Self::default();
        for (k, &piece) in pieces
            .iter()
            .enumerate()
            .filter(|(_, piece)| **piece != Piece::Explicit)
        {
            normal.add(&data.rows[k], data.residual(k, centre), piece);
        }
        normal
    }

    /// Adds one sample that lies in `piece`.
    pub(crate) fn add(&mut self, row: &[f64; P], residual: f64, piece: Piece) {
        // Only the square part has curvature; a linear part has slope 1 or -1 whatever the
        // residual.
        let psi = match piece {
            Piece::Explicit => return,
            Piece::Square => {
                for (i, line) in self.matrix.iter_mut().enumerate() {
                    line.iter_mut()
                        .zip(row)
                        .for_each(|(entry, a)| *entry += row[i] * a);
                }
                residual
            }
            Piece::Above => 1.0,
            Piece::Below => -1.0,
        };
        self.gradient
            .iter_mut()
            .zip(row)
            .for_each(|(entry, a)| *entry += a * psi);
    }

    /// Takes another sum away, as when a block of the samples is left out.
    pub fn without(&self, other: &Self) -> Self {
        Self {
            matrix: std::array::from_fn(|i| {
                std::array::from_fn(|j| self.matrix[i][j] - other.matrix[i][j])
            }),
            gradient: std::array::from_fn(|j| self.gradient[j] - other.gradient[j]),
        }
    }

    /// Newton step over the free coefficients, zero in the others; `None` where the curvature is
    /// singular.
    pub fn newton(&self, free: &[bool; P]) -> Option<[f64; P]> {
        // A coefficient that is held gets the row of the unit matrix and a zero on the right.
        let matrix = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                if free[i] && free[j] {
                    self.matrix[i][j]
                } else {
                    f64::from(u8::from(i == j))
                }
            })
        });
        let right = std::array::from_fn(|j| if free[j] { self.gradient[j] } else { 0.0 });
        solve_small(&matrix, &right)
    }
}

/// Smallest diagonal entry of a Cholesky factor, of a matrix with unit diagonal. A choice: its
/// square, 1e-14, is what rounding leaves of a singular direction.
const MIN_PIVOT: f64 = 1e-7;

/// Solves `M x = r` for a symmetric positive definite matrix by Cholesky; `None` if it is not, to
/// working accuracy.
pub fn solve_small<const P: usize>(matrix: &[[f64; P]; P], right: &[f64; P]) -> Option<[f64; P]> {
    // equilibrated to a unit diagonal, so that the pivots tell how far from singular it is
    let scale: [f64; P] = std::array::from_fn(|j| matrix[j][j].sqrt());
    if !scale.iter().all(|s| s.is_finite() && *s > 0.0) {
        return None;
    }
    let factor = Llt::new(
        Mat::from_fn(P, P, |i, j| matrix[i][j] / (scale[i] * scale[j])).as_ref(),
        Side::Lower,
    )
    .ok()?;
    if (0..P).any(|j| factor.L()[(j, j)] < MIN_PIVOT) {
        return None;
    }
    let solution = factor.solve(Mat::from_fn(P, 1, |i, _| right[i] / scale[i]));
    Some(std::array::from_fn(|j| solution[(j, 0)] / scale[j]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_system_is_solved_and_a_singular_one_refused() {
        let x = solve_small(&[[4.0, 2.0], [2.0, 3.0]], &[10.0, 8.0]).unwrap();
        assert!((x[0] - 1.75).abs() < 1e-14 && (x[1] - 1.5).abs() < 1e-14);
        assert_eq!(solve_small(&[[1.0, 1.0], [1.0, 1.0]], &[1.0, 1.0]), None);
        assert_eq!(solve_small(&[[0.0, 0.0], [0.0, 1.0]], &[1.0, 1.0]), None);
        assert_eq!(
            solve_small(&[[f64::NAN, 0.0], [0.0, 1.0]], &[1.0, 1.0]),
            None
        );
    }
}
