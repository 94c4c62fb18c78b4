//! Standard errors that hold although neighbouring samples err alike.
//!
//! Samples of one contact share their encoder error, ringing and stick, so they are far from
//! independent, and the textbook error over all samples would be much too small. Here the log is
//! cut into blocks, whole contact episodes where there are enough of them, and each block is left
//! out in turn: the delete-a-block jackknife (Quenouille, Tukey; for regression the CR3 form of
//! cluster-robust errors, Bell and McCaffrey 2002), with one Newton step per left-out block.
//! Whatever samples have in common within a block is in the scatter between blocks. Student's t
//! then allows for the number of blocks, counted by their weight on the coefficient (Carter,
//! Schnepel and Steigerwald 2017).

use crate::huber::{NormalEquations, Piece, Regression, solve_small};

/// Least number of blocks; episodes are cut where the log has fewer. A choice: with nine degrees of
/// freedom Student's t is 15 % above the normal quantile.
const MIN_BLOCKS: usize = 10;

/// Uncertainty of one coefficient.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Standard error with the samples' dependence allowed for.
    pub standard_error: f64,
    /// Half the width of the 95 % interval.
    pub half_width: f64,
    /// Independent samples that would give this standard error.
    pub effective_samples: f64,
    /// Blocks of the log.
    pub blocks: usize,
}

/// Blocks as index ranges over the samples, from each sample's episode (non-decreasing).
pub fn blocks(episodes: &[usize]) -> Vec<std::ops::Range<usize>> {
    // Lengths of the runs of samples that belong to one episode.
    let runs: Vec<_> = episodes
        .chunk_by(|a, b| a == b)
        .map(<[usize]>::len)
        .collect();
    // With few episodes each is cut into parts, as many as bring the blocks to the wanted number.
    let parts = if runs.is_empty() {
        1
    } else {
        MIN_BLOCKS.div_ceil(runs.len())
    };
    let mut blocks = Vec::new();
    let mut first = 0;
    for length in runs {
        let parts = parts.min(length);
        blocks.extend(
            (0..parts)
                .map(|part| first + length * part / parts..first + length * (part + 1) / parts),
        );
        first += length;
    }
    blocks
}

/// Spread of the coefficient `which` of a Huber regression at its minimiser `x`; `None` where the
/// samples left after some block is taken out no longer determine the coefficients.
pub fn spread<const P: usize>(
    data: &Regression<P>,
    x: &[f64; P],
    delta: f64,
    blocks: &[std::ops::Range<usize>],
    which: usize,
) -> Option<Spread> {
    // Curvature and gradient of the loss that a range of samples brings, at the minimiser.
    let part = |range: std::ops::Range<usize>| {
        let mut normal = NormalEquations::<P>::default();
        for k in range {
            let residual = data.residual(k, x) / delta;
            normal.add(&data.rows[k], residual, Piece::of(residual));
        }
        normal
    };
    let whole = part(0..data.rows.len());
    let unit: [f64; P] = std::array::from_fn(|j| f64::from(u8::from(j == which)));
    // Column of the inverse curvature: how a pull on each coefficient moves this one.
    let influence = solve_small(&whole.matrix, &unit)?;
    let count = blocks.len() as f64;
    let (mut square, mut shifts, mut weight, mut weight_square) = (0.0, 0.0, 0.0, 0.0);
    for block in blocks {
        let block = part(block.clone());
        let mut rest = whole.without(&block);
        // at the minimiser the whole gradient is zero, save where a bound holds it; the shift is
        // the block's own pull
        rest.gradient = block.gradient.map(|pull| -pull);
        let shift = rest.newton(&[true; P])?[which];
        square += shift * shift;
        shifts += shift;
        // What the block brings of the information on the coefficient.
        let own = quadratic_form(&block.matrix, &influence);
        weight += own;
        weight_square += own * own;
    }
    // Jackknife: scatter of the shifts about their mean, times (B - 1)/B.
    let variance = (count - 1.0) / count * (square - shifts * shifts / count).max(0.0);
    let standard_error = delta * variance.sqrt();
    // Blocks counted by their weight, (sum w)^2 / sum w^2, less one.
    let freedom = weight * weight / weight_square - 1.0;
    // Variance as if all samples were independent; the ratio to the jackknife's tells how many are.
    let psi_square: f64 = (0..data.rows.len())
        .map(|k| (data.residual(k, x) / delta).clamp(-1.0, 1.0))
        .map(|psi| psi * psi)
        .sum();
    let naive = delta * delta * influence[which] * psi_square / data.rows.len() as f64;
    let effective_samples = if standard_error > 0.0 {
        data.rows.len() as f64 * naive / (standard_error * standard_error)
    } else {
        data.rows.len() as f64
    };
    Some(Spread {
        standard_error,
        half_width: student_975(freedom) * standard_error,
        effective_samples,
        blocks: blocks.len(),
    })
}

/// What the coefficient `which` changes by for a unit of each sample's target; `None` where the samples do not
/// determine it.
pub fn pulls<const P: usize>(
    data: &Regression<P>,
    x: &[f64; P],
    delta: f64,
    which: usize,
) -> Option<Vec<f64>> {
    let piece = |k: usize| {
        let residual = data.residual(k, x) / delta;
        (residual, Piece::of(residual))
    };
    let mut normal = NormalEquations::<P>::default();
    for (k, row) in data.rows.iter().enumerate() {
        let (residual, piece) = piece(k);
        normal.add(row, residual, piece);
    }
    let unit: [f64; P] = std::array::from_fn(|j| f64::from(u8::from(j == which)));
    let influence = solve_small(&normal.matrix, &unit)?;
    // Beyond delta a sample pulls by its sign alone.
    let pull = |(k, row): (usize, &[f64; P])| match piece(k).1 {
        Piece::Square => (0..P).map(|j| row[j] * influence[j]).sum(),
        _ => 0.0,
    };
    Some(data.rows.iter().enumerate().map(pull).collect())
}

fn quadratic_form<const P: usize>(matrix: &[[f64; P]; P], v: &[f64; P]) -> f64 {
    (0..P)
        .map(|i| (0..P).map(|j| v[i] * matrix[i][j] * v[j]).sum::<f64>())
        .sum()
}

/// The 97.5 % quantile of Student's t for at least 2 degrees of freedom (fewer count as 2), by the
/// expansion about the normal quantile in powers of 1/freedom (Abramowitz and Stegun 26.7.5);
/// within 1 % at 2 and 0.1 % from 3 on.
pub(crate) fn student_975(freedom: f64) -> f64 {
    // The normal quantile, then the polynomials g1 to g4 of the expansion.
    let z: f64 = 1.959_963_984_540_054;
    let z2 = z * z;
    let n = if freedom >= 2.0 { freedom } else { 2.0 };
    let g1 = z * (z2 + 1.0) / 4.0;
    let g2 = z * ((5.0 * z2 + 16.0) * z2 + 3.0) / 96.0;
    let g3 = z * (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / 384.0;
    let g4 = z * ((((79.0 * z2 + 776.0) * z2 + 1482.0) * z2 - 1920.0) * z2 - 945.0) / 92160.0;
    z + (g1 + (g2 + (g3 + g4 / n) / n) / n) / n
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn student_matches_the_printed_table() {
        for (freedom, t) in [
            (2.0, 4.303),
            (3.0, 3.182),
            (4.0, 2.776),
            (5.0, 2.571),
            (10.0, 2.228),
            (30.0, 2.042),
            (120.0, 1.980),
        ] {
            assert!((student_975(freedom) - t).abs() < 0.01 * t, "{freedom}");
        }
        assert!((student_975(f64::NAN) - student_975(2.0)).abs() < 1e-12);
    }

    #[test]
    fn blocks_are_episodes_if_there_are_enough_and_parts_of_them_otherwise() {
        let many: Vec<usize> = (0..30).map(|k| k / 2).collect();
        assert_eq!(blocks(&many).len(), 15);
        assert!(blocks(&many).iter().all(|block| block.len() == 2));
        let few: Vec<usize> = (0..30).map(|k| k / 10).collect();
        let cut = blocks(&few);
        assert_eq!(
            (cut.len(), cut[0].clone(), cut[11].clone()),
            (12, 0..2, 27..30)
        );
        assert_eq!(blocks(&[0, 0, 1]), [0..1, 1..2, 2..3]);
        assert!(blocks(&[]).is_empty());
    }

    #[test]
    fn the_error_of_a_mean_is_that_of_its_block_means() {
        // five blocks of four equal samples: the mean's error is that of five numbers, sqrt(s^2/5),
        // not of twenty
        let means: [f64; 5] = [1.0, 2.0, 4.0, 4.0, 9.0];
        let targets: Vec<f64> = means.iter().flat_map(|&mean| [mean; 4]).collect();
        let data = Regression {
            rows: vec![[1.0]; 20],
            targets,
            nonnegative: [false],
        };
        let blocks: Vec<_> = (0..5).map(|n| 4 * n..4 * n + 4).collect();
        let spread = spread(&data, &[4.0], 100.0, &blocks, 0).unwrap();
        let variance = means.iter().map(|m| (m - 4.0) * (m - 4.0)).sum::<f64>() / 4.0;
        assert!((spread.standard_error - (variance / 5.0).sqrt()).abs() < 1e-12);
        assert!((spread.effective_samples - 4.0).abs() < 1e-9);
        assert!((spread.half_width / spread.standard_error - 2.776).abs() < 0.005);
    }
}
