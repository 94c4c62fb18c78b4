//! Sobol's sequence, with the direction numbers of Joe and Kuo.

/// Most coordinates that a point can have. A choice; the published table goes on to 21,201.
pub const MOST_DIMENSIONS: usize = 40;

/// Binary digits of a coordinate.
const DIGITS: usize = 52;

/// Primitive polynomials and first direction numbers of the coordinates from the second on: S. Joe,
/// F. Y. Kuo, *Constructing Sobol sequences with better two-dimensional projections*, SIAM J. Sci.
/// Comput. 30 (2008), table `new-joe-kuo-6`. The inner coefficients of the polynomial as the digits
/// of a number, and one direction number for each of its degrees.
const DIRECTIONS: [(u32, &[u64]); MOST_DIMENSIONS - 1] = [
    (0, &[1]),
    (1, &[1, 3]),
    (1, &[1, 3, 1]),
    (2, &[1, 1, 1]),
    (1, &[1, 1, 3, 3]),
    (4, &[1, 3, 5, 13]),
    (2, &[1, 1, 5, 5, 17]),
    (4, &[1, 1, 5, 5, 5]),
    (7, &[1, 1, 7, 11, 19]),
    (11, &[1, 1, 5, 1, 1]),
    (13, &[1, 1, 1, 3, 11]),
    (14, &[1, 3, 5, 5, 31]),
    (1, &[1, 3, 3, 9, 7, 49]),
    (13, &[1, 1, 1, 15, 21, 21]),
    (16, &[1, 3, 1, 13, 27, 49]),
    (19, &[1, 1, 1, 15, 7, 5]),
    (22, &[1, 3, 1, 15, 13, 25]),
    (25, &[1, 1, 5, 5, 19, 61]),
    (1, &[1, 3, 7, 11, 23, 15, 103]),
    (4, &[1, 3, 7, 13, 13, 15, 69]),
    (7, &[1, 1, 3, 13, 7, 35, 63]),
    (8, &[1, 3, 5, 9, 1, 25, 53]),
    (14, &[1, 3, 1, 13, 9, 35, 107]),
    (19, &[1, 3, 1, 5, 27, 61, 31]),
    (21, &[1, 1, 5, 11, 19, 41, 61]),
    (28, &[1, 3, 5, 3, 3, 13, 69]),
    (31, &[1, 1, 7, 13, 1, 19, 1]),
    (32, &[1, 3, 7, 5, 13, 19, 59]),
    (37, &[1, 1, 3, 9, 25, 29, 41]),
    (41, &[1, 3, 5, 13, 23, 1, 55]),
    (42, &[1, 3, 7, 3, 13, 59, 17]),
    (50, &[1, 3, 1, 3, 5, 53, 69]),
    (55, &[1, 1, 5, 5, 23, 33, 13]),
    (56, &[1, 1, 7, 7, 1, 61, 123]),
    (59, &[1, 1, 7, 9, 13, 61, 49]),
    (62, &[1, 3, 3, 5, 3, 55, 33]),
    (14, &[1, 3, 1, 15, 31, 13, 49, 245]),
    (21, &[1, 3, 5, 15, 31, 59, 63, 97]),
    (22, &[1, 3, 1, 11, 11, 11, 77, 249]),
];

/// The points of Sobol's sequence in Gray code order, from the origin on; coordinates in [0, 1).
///
/// ```
/// use lostmotion_sweep::design::Sobol;
///
/// let points: Vec<Vec<f64>> = Sobol::new(2).take(4).collect();
/// assert_eq!(points, [[0.0, 0.0], [0.5, 0.5], [0.75, 0.25], [0.25, 0.75]]);
/// ```
#[derive(Clone, Debug)]
pub struct Sobol {
    /// For each coordinate the direction number of each digit, as parts of 2^[`DIGITS`].
    directions: Vec<[u64; DIGITS]>,
    now: Vec<u64>,
    /// Number of the next point.
    next: u64,
}

impl Sobol {
    /// Points of this many coordinates; beyond [`MOST_DIMENSIONS`] the rest have none.
    pub fn new(dimensions: usize) -> Sobol {
        let first = std::iter::once((0, &[][..]));
        let directions = first.chain(DIRECTIONS.iter().map(|(inner, start)| (*inner, *start)));
        let directions: Vec<_> = directions
            .take(dimensions)
            .map(|(i, s)| numbers(i, s))
            .collect();
        Sobol {
            now: vec![0; directions.len()],
            directions,
            next: 0,
        }
    }
}

/// The direction numbers of a coordinate. Without a polynomial every one of them is 1: van der
/// Corput's sequence.
fn numbers(inner: u32, start: &[u64]) -> [u64; DIGITS] {
    let degree = start.len();
    let mut m = [1_u64; DIGITS];
    for digit in 0..DIGITS {
        if let Some(given) = start.get(digit) {
            m[digit] = *given;
        } else if degree > 0 {
            // m_k = 2 a_1 m_(k-1) ^ 4 a_2 m_(k-2) ^ .. ^ 2^s m_(k-s) ^ m_(k-s)
            let back = m[digit - degree];
            m[digit] = (1..degree)
                .filter(|step| inner >> (degree - 1 - step) & 1 == 1)
                .fold(back ^ (back << degree), |sum, step| {
                    sum ^ (m[digit - step] << step)
                });
        }
    }
    std::array::from_fn(|digit| m[digit] << (DIGITS - 1 - digit))
}

impl Iterator for Sobol {
    type Item = Vec<f64>;

    fn next(&mut self) -> Option<Vec<f64>> {
        let scale = (1_u64 << DIGITS) as f64;
        let point = self.now.iter().map(|place| *place as f64 / scale).collect();
        // From point to point one digit of the Gray code changes: that of the lowest 0 of the number.
        let digit = (self.next.trailing_ones() as usize).min(DIGITS - 1);
        for (place, directions) in self.now.iter_mut().zip(&self.directions) {
            *place ^= directions[digit];
        }
        self.next += 1;
        Some(point)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first ten points of three coordinates as Joe and Kuo print them beside their table.
    #[test]
    fn the_first_points_are_the_published_ones() {
        let published = [
            [0.0, 0.0, 0.0],
            [0.5, 0.5, 0.5],
            [0.75, 0.25, 0.25],
            [0.25, 0.75, 0.75],
            [0.375, 0.375, 0.625],
            [0.875, 0.875, 0.125],
            [0.625, 0.125, 0.875],
            [0.125, 0.625, 0.375],
            [0.1875, 0.3125, 0.9375],
            [0.6875, 0.8125, 0.4375],
        ];
        let points: Vec<_> = Sobol::new(3).take(10).collect();
        assert_eq!(points, published);
    }

    /// Of 2^m points each of the 2^m equal parts of every axis has one; a point set of any other
    /// kind does not have this.
    #[test]
    fn every_axis_is_divided_evenly() {
        let points: Vec<_> = Sobol::new(MOST_DIMENSIONS).take(1024).collect();
        for axis in 0..MOST_DIMENSIONS {
            let mut seen = [false; 1024];
            for point in &points {
                let part = (point[axis] * 1024.0) as usize;
                assert!(!std::mem::replace(&mut seen[part], true), "axis {axis}");
            }
        }
        // And of the first two axes every way of cutting the square into 2^10 equal rectangles.
        for wide in 0..=10 {
            let (columns, rows) = (1 << wide, 1 << (10 - wide));
            let mut seen = vec![false; columns * rows];
            for point in &points {
                let column = (point[0] * columns as f64) as usize;
                let place = column * rows + (point[1] * rows as f64) as usize;
                assert!(
                    !std::mem::replace(&mut seen[place], true),
                    "2^{wide} columns"
                );
            }
        }
    }

    /// Point 777 of all coordinates, as SciPy 1.17 has it (`qmc.Sobol(40, scramble=False)`), in
    /// parts of 1024.
    #[test]
    fn later_coordinates_are_those_of_another_implementation() {
        let theirs = [
            709, 959, 167, 281, 651, 365, 195, 781, 357, 331, 763, 713, 393, 485, 583, 527, 413,
            885, 379, 771, 243, 279, 969, 493, 353, 149, 61, 799, 65, 113, 555, 921, 115, 3, 825,
            969, 473, 359, 351, 367,
        ];
        let point = Sobol::new(MOST_DIMENSIONS).nth(777).unwrap();
        assert_eq!(point, theirs.map(|part| f64::from(part) / 1024.0));
    }
}
