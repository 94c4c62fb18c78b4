//! First crossing of a polynomial to below zero on [0, 1].
//!
//! In Bernstein's form a polynomial lies in the hull of its coefficients, and has no more roots in
//! (0, 1) than they have changes of sign. So no crossing is overlooked, however short the
//! excursion, and most polynomials are settled by one look.

use super::taylor::COEFFICIENTS;

type Poly = [f64; COEFFICIENTS];
const LAST: usize = COEFFICIENTS - 1;
/// Halvings of [0, 1] in the search for the first of several roots; a shorter excursion counts as
/// touching.
const DEPTH: u32 = 40;

/// The smallest tau in [0, 1] from which the polynomial (by powers) is negative; none if it is not.
///
/// The first `zeros` coefficients are known to vanish, whatever rounding has made of them. A
/// polynomial that starts at zero crosses there if it leaves downwards.
pub(super) fn first_crossing(power: &Poly, zeros: usize) -> Option<f64> {
    let mut power = *power;
    let mut lead = 0;
    while lead < COEFFICIENTS && (lead < zeros || power[lead] == 0.0) {
        lead += 1;
    }
    if lead == COEFFICIENTS {
        return None;
    }
    power.rotate_left(lead);
    power[COEFFICIENTS - lead..].fill(0.0);
    if power[0] < 0.0 {
        return Some(0.0);
    }
    search(&bernstein(&power), &power, 0.0, 1.0, DEPTH)
}

fn bernstein(power: &Poly) -> Poly {
    let mut out = *power;
    // out[j] = sum over i <= j of C(j,i)/C(n,i) power[i], by repeated running sums of
    // power[i]/C(n,i)
    let mut binomial = 1.0;
    for (i, entry) in out.iter_mut().enumerate() {
        *entry /= binomial;
        binomial *= (LAST - i) as f64 / (i + 1) as f64;
    }
    for round in 0..LAST {
        for j in (round..LAST).rev() {
            out[j + 1] += out[j];
        }
    }
    out
}

fn search(form: &Poly, power: &Poly, low: f64, high: f64, depth: u32) -> Option<f64> {
    let changes = form
        .windows(2)
        .filter(|pair| (pair[0] < 0.0) != (pair[1] < 0.0))
        .count();
    match changes {
        0 => (form[0] < 0.0).then_some(low),
        1 if form[0] >= 0.0 && form[LAST] < 0.0 => Some(root(power, low, high)),
        _ if depth == 0 => None,
        _ => {
            let (left, right) = halves(form);
            let middle = 0.5 * (low + high);
            search(&left, power, low, middle, depth - 1)
                .or_else(|| search(&right, power, middle, high, depth - 1))
        }
    }
}

/// De Casteljau's subdivision at the middle.
fn halves(form: &Poly) -> (Poly, Poly) {
    let (mut left, mut right) = (*form, *form);
    for (level, entry) in left.iter_mut().enumerate() {
        *entry = right[0];
        for j in 0..LAST - level {
            right[j] = 0.5 * (right[j] + right[j + 1]);
        }
    }
    (left, right)
}

fn value_and_slope(power: &Poly, tau: f64) -> (f64, f64) {
    let (mut value, mut slope) = (0.0, 0.0);
    for c in power.iter().rev() {
        slope = slope * tau + value;
        value = value * tau + c;
    }
    (value, slope)
}

/// The one root between `low` (not negative there) and `high` (negative there): Newton's steps,
/// halved where they leave the bracket.
fn root(power: &Poly, mut low: f64, mut high: f64) -> f64 {
    let mut tau = 0.5 * (low + high);
    for _ in 0..100 {
        let (value, slope) = value_and_slope(power, tau);
        if value < 0.0 {
            high = tau;
        } else {
            low = tau;
        }
        let newton = tau - value / slope;
        let next = if newton > low && newton < high {
            newton
        } else {
            0.5 * (low + high)
        };
        if (next - tau).abs() <= 1e-15 || high - low <= 1e-15 {
            return next;
        }
        tau = next;
    }
    tau
}

#[cfg(test)]
mod tests {
    use super::*;

    fn from_roots(roots: &[f64], scale: f64) -> Poly {
        let mut poly = [0.0; COEFFICIENTS];
        poly[0] = scale;
        for &r in roots {
            for i in (0..COEFFICIENTS).rev() {
                poly[i] = if i > 0 { poly[i - 1] } else { 0.0 } - r * poly[i];
            }
        }
        poly
    }

    #[test]
    fn finds_the_first_of_several() {
        let found = first_crossing(&from_roots(&[0.9, 0.3, 0.300_01], -1.0), 0);
        assert!((found.unwrap() - 0.3).abs() < 1e-9, "{found:?}");
    }

    #[test]
    fn short_excursion_is_seen_and_touching_is_not_one() {
        assert!(first_crossing(&from_roots(&[0.5, 0.5 + 1e-6], 1.0), 0).is_some());
        let mut touching = from_roots(&[0.5, 0.5], 1.0);
        touching[0] += 1e-9;
        assert_eq!(first_crossing(&touching, 0), None);
    }

    #[test]
    fn a_start_at_zero_goes_by_where_it_leaves() {
        assert_eq!(first_crossing(&from_roots(&[0.0], -1.0), 0), Some(0.0));
        assert_eq!(first_crossing(&from_roots(&[0.0], 1.0), 0), None);
        let mut noisy = from_roots(&[0.0, 0.7], -1.0);
        noisy[0] = -1e-18;
        assert!((first_crossing(&noisy, 1).unwrap() - 0.7).abs() < 1e-14);
    }
}
