//! Linear systems in discrete time, and their frequency response.

use lostmotion_base::math;
use lostmotion_base::matrix::SquareMatrix;

/// A complex number.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Complex {
    pub(super) re: f64,
    pub(super) im: f64,
}

impl Complex {
    /// `e^(j angle)`.
    pub(super) fn turn(angle: f64) -> Complex {
        let (im, re) = math::sin_cos(angle);
        Complex { re, im }
    }

    pub(super) fn abs(self) -> f64 {
        math::hypot(self.re, self.im)
    }

    /// In rad, from -pi to pi.
    pub(super) fn phase(self) -> f64 {
        math::atan2(self.im, self.re)
    }

    pub(super) fn plus(self, other: Complex) -> Complex {
        Complex {
            re: self.re + other.re,
            im: self.im + other.im,
        }
    }

    pub(super) fn times(self, other: Complex) -> Complex {
        Complex {
            re: self.re * other.re - self.im * other.im,
            im: self.re * other.im + self.im * other.re,
        }
    }

    pub(super) fn scaled(self, factor: f64) -> Complex {
        Complex {
            re: self.re * factor,
            im: self.im * factor,
        }
    }

    pub(super) fn over(self, other: Complex) -> Complex {
        let size = other.re * other.re + other.im * other.im;
        self.times(Complex {
            re: other.re / size,
            im: -other.im / size,
        })
    }
}

/// `x(k+1) = A x + b u`, `y = c x + d u`.
#[derive(Clone, Debug)]
pub(super) struct StateSpace {
    pub(super) a: SquareMatrix,
    b: Vec<f64>,
    c: Vec<f64>,
    d: f64,
    /// Its period, s.
    pub(super) period_s: f64,
}

impl StateSpace {
    /// The matrices of a step that is written as code: `step(state, input)` changes the state and
    /// returns the output, and is linear.
    pub(super) fn of(
        size: usize,
        period_s: f64,
        step: impl Fn(&mut [f64], f64) -> f64,
    ) -> StateSpace {
        let mut out = StateSpace {
            a: SquareMatrix::zero(size),
            b: vec![0.0; size],
            c: vec![0.0; size],
            d: 0.0,
            period_s,
        };
        let mut state = vec![0.0; size];
        // A linear step of a unit vector is a column of A, its output an entry of c.
        for column in 0..size {
            state.fill(0.0);
            state[column] = 1.0;
            out.c[column] = step(&mut state, 0.0);
            for (row, value) in state.iter().enumerate() {
                out.a.set(row, column, *value);
            }
        }
        state.fill(0.0);
        // A unit input at rest gives d and b.
        out.d = step(&mut state, 1.0);
        out.b = state;
        out
    }

    /// Largest magnitude of a pole when the output is fed back to the input, `u = -y`. The output
    /// must not follow the input at once.
    pub(super) fn closed_radius(&self) -> f64 {
        let mut closed = self.a.clone();
        // Closed loop: A - b c, as d is zero.
        for (row, into) in self.b.iter().enumerate() {
            for (column, out) in self.c.iter().enumerate() {
                closed.set(row, column, closed.get(row, column) - into * out);
            }
        }
        closed.spectral_radius()
    }

    /// Half of the sampling rate, Hz.
    pub(super) fn nyquist_hz(&self) -> f64 {
        0.5 / self.period_s
    }

    /// `c (z I - A)^-1 b + d` at `z = e^(j w T)`.
    pub(super) fn at(&self, frequency_hz: f64) -> Complex {
        let z = Complex::turn(std::f64::consts::TAU * frequency_hz * self.period_s);
        let size = self.a.size();
        // Rows of z I - A with b on the right.
        let mut rows: Vec<Vec<Complex>> = (0..size)
            .map(|i| {
                self.a
                    .row(i)
                    .iter()
                    .map(|entry| Complex {
                        re: -entry,
                        im: 0.0,
                    })
                    .collect()
            })
            .collect();
        for (i, row) in rows.iter_mut().enumerate() {
            row[i] = row[i].plus(z);
            row.push(Complex {
                re: self.b[i],
                im: 0.0,
            });
        }
        let x = solve(rows);
        let zero = Complex {
            re: self.d,
            im: 0.0,
        };
        x.iter()
            .zip(&self.c)
            .fold(zero, |sum, (entry, factor)| sum.plus(entry.scaled(*factor)))
    }
}

/// Solution of equations given as rows with the right-hand side last: Gauss' elimination with the
/// largest pivot of each column.
fn solve(mut rows: Vec<Vec<Complex>>) -> Vec<Complex> {
    let size = rows.len();
    for column in 0..size {
        let pivot = (column..size).fold(column, |best, row| {
            if rows[row][column].abs() > rows[best][column].abs() {
                row
            } else {
                best
            }
        });
        rows.swap(column, pivot);
        let (upper, lower) = rows.split_at_mut(column + 1);
        let pivot_row = &upper[column];
        for row in lower {
            // Elimination below the pivot.
            let factor = row[column].over(pivot_row[column]).scaled(-1.0);
            for (entry, above) in row.iter_mut().zip(pivot_row).skip(column) {
                *entry = entry.plus(above.times(factor));
            }
        }
    }
    // Back substitution.
    let mut x = vec![Complex::default(); size];
    for i in (0..size).rev() {
        let known = (i + 1..size).fold(rows[i][size], |sum, j| {
            sum.plus(rows[i][j].times(x[j]).scaled(-1.0))
        });
        x[i] = known.over(rows[i][i]);
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_integrator_with_delays_has_its_closed_form() {
        // y(k) = sum of u up to k-3, times T
        let period = 1e-3;
        let system = StateSpace::of(3, period, |x, u| {
            let y = x[2];
            x[2] += period * x[1];
            x[1] = x[0];
            x[0] = u;
            y
        });
        for f in [1.0, 30.0, 400.0] {
            let half = std::f64::consts::PI * f * period;
            let got = system.at(f);
            assert!(
                (got.abs() * 2.0 * math::sin(half) / period - 1.0).abs() < 1e-12,
                "{f}"
            );
            // T z^-3/(1 - 1/z) = T z^-2.5/(2 j sin(wT/2))
            let phase = -std::f64::consts::FRAC_PI_2 - 5.0 * half;
            assert!(
                (Complex::turn(phase).over(got).phase()).abs() < 1e-12,
                "{f}"
            );
        }
    }
}
