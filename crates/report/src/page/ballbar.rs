//! The words of a ballbar's sheet for a circle: reversal spikes and lost motion of each axis, and with
//! the same circle in the other sense squareness, servo mismatch and scale mismatch.
//!
//! All are read from the radial deviation over the angle, as a ballbar measures it.

use super::circles::{FullCircle, partner};
use lostmotion_base::math;
use std::f64::consts::TAU;

/// Degrees next to a reversal in which its spike is looked for. A choice: a spike has passed by then
/// on circles that are not much smaller than they are fast.
const SPIKE_DEG: f64 = 15.0;
/// Degrees before and behind a reversal over which the offsets are taken. A choice: beyond the spike,
/// and before the next octant.
const LEVEL_DEG: [f64; 2] = [15.0, 30.0];

/// What a sheet says of a circle. The axes are those of its plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct BallbarSheet {
    /// How far the path leaves the band between what it would be with the offsets of before and of
    /// behind a reversal of each axis, um.
    pub(super) spike_um: [f64; 2],
    /// Step of the offset along each axis at its reversal, um, positive outwards: its lost motion.
    pub(super) step_um: [f64; 2],
    /// What takes the same circle in both senses.
    pub(super) both: Option<BothSenses>,
}

/// What two senses tell apart.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct BothSenses {
    /// Turn of the second axis towards the first, um/m: an oval at 45 degrees that stays.
    pub(super) squareness_um_m: f64,
    /// How far the first axis is behind the second at this speed, um: an oval at 45 degrees that
    /// turns over with the sense.
    pub(super) mismatch_um: f64,
    /// How much longer the first axis moves than the second, um/m: an oval along the axes.
    pub(super) scale_um_m: f64,
}

/// The sheet of a circle among all of a method.
pub(super) fn sheet(circle: &FullCircle, all: &[FullCircle]) -> BallbarSheet {
    let own = middles(circle);
    let mut sheet = BallbarSheet::default();
    for axis in 0..2 {
        // The first axis reverses where the second is at its middle, and the other way round.
        for side in [0.0, 180.0] {
            let at = 90.0 * axis as f64 + side;
            let (step, spike) = reversal(&own, at, circle.counterclockwise);
            if step.abs() > sheet.step_um[axis].abs() {
                sheet.step_um[axis] = step;
            }
            sheet.spike_um[axis] = sheet.spike_um[axis].max(spike);
        }
    }
    sheet.both = partner(circle, all).map(|other| {
        let (mut ccw, mut cw) = (second(&own), second(&middles(other)));
        if !circle.counterclockwise {
            std::mem::swap(&mut ccw, &mut cw);
        }
        // Radial deviation of a turn a: a R sin cos; of a lag d: d sin cos, with the sign of the
        // sense; of a scale s: s R cos^2.
        let per_m = 1e3 / circle.radius_mm;
        BothSenses {
            squareness_um_m: (ccw[1] + cw[1]) * per_m,
            mismatch_um: ccw[1] - cw[1],
            scale_um_m: (ccw[0] + cw[0]) * per_m,
        }
    });
    sheet
}

/// Radial deviation in the middle of what each part of the turn has, um.
fn middles(circle: &FullCircle) -> Vec<f64> {
    let middle = |[low, high]: &[f32; 2]| 0.5 * (f64::from(*low) + f64::from(*high));
    circle.radial_um.iter().map(middle).collect()
}

/// Amplitudes of the second harmonic, of cosine and sine.
fn second(radial_um: &[f64]) -> [f64; 2] {
    let mut sums = [0.0; 2];
    let mut count = 0_u32;
    for (part, um) in radial_um
        .iter()
        .enumerate()
        .filter(|(_, um)| um.is_finite())
    {
        let angle = (part as f64 + 0.5) / radial_um.len() as f64 * TAU;
        let (sin, cos) = math::sin_cos(2.0 * angle);
        sums = [sums[0] + um * cos, sums[1] + um * sin];
        count += 1;
    }
    sums.map(|sum| 2.0 * sum / f64::from(count.max(1)))
}

/// Step and spike at a reversal, by its angle in degrees.
fn reversal(radial_um: &[f64], at_deg: f64, counterclockwise: bool) -> (f64, f64) {
    let parts = radial_um.len();
    let per = parts as f64 / 360.0;
    let sense = if counterclockwise { 1.0 } else { -1.0 };
    // From one angle to another, as they are travelled from the reversal on: cosine and sine of the
    // angle, and the deviation.
    let stretch = |from_deg: f64, to_deg: f64| {
        let (from, to) = ((from_deg * per) as i64, (to_deg * per) as i64);
        (from..to).filter_map(move |step| {
            let along = step as f64 + 0.5;
            let part = (at_deg * per + sense * along).rem_euclid(parts as f64) as usize;
            let um = radial_um.get(part).copied().filter(|um| um.is_finite())?;
            let (sin, cos) = math::sin_cos(along / parts as f64 * TAU);
            Some([cos, sin, um])
        })
    };
    let [near, far] = LEVEL_DEG;
    let levels = (offset(stretch(-far, -near)), offset(stretch(near, far)));
    // Where the circle has a gap there, nothing is known.
    let (Some(before), Some(behind)) = levels else {
        return (0.0, 0.0);
    };
    let outside = |[cos, sin, um]: [f64; 3]| {
        let [one, other] = [before, behind].map(|[a, b]| a * cos + b * sin);
        (um - one.max(other)).max(one.min(other) - um).max(0.0)
    };
    let spike = stretch(0.0, SPIKE_DEG).map(outside).fold(0.0, f64::max);
    (behind[0] - before[0], spike)
}

/// By how much a tip is off along the axis that reverses and along the other one, which makes the
/// deviations over a stretch, by least squares.
fn offset(stretch: impl Iterator<Item = [f64; 3]>) -> Option<[f64; 2]> {
    let (mut cc, mut cs, mut ss, mut cu, mut su) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for [cos, sin, um] in stretch {
        cc += cos * cos;
        cs += cos * sin;
        ss += sin * sin;
        cu += cos * um;
        su += sin * um;
    }
    let determinant: f64 = cc * ss - cs * cs;
    // Too few parts of the turn have a tick.
    (determinant > 1e-6).then(|| {
        [
            (ss * cu - cs * su) / determinant,
            (cc * su - cs * cu) / determinant,
        ]
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use lostmotion_base::Plane;

    const RADIUS_MM: f64 = 50.0;

    /// A circle whose tip is off by what the functions say of the angle, in both axes, um.
    fn circle(counterclockwise: bool, off: impl Fn(f64) -> [f64; 2]) -> FullCircle {
        let radial = (0..720).map(|part| {
            let angle = (f64::from(part) + 0.5) / 720.0 * TAU;
            let (sin, cos) = math::sin_cos(angle);
            let [x, y] = off(angle);
            [(x * cos + y * sin) as f32; 2]
        });
        FullCircle {
            line: 1,
            time_s: 0.0,
            plane: Plane::Xy,
            center_mm: [0.0; 2],
            radius_mm: RADIUS_MM,
            counterclockwise,
            radial_um: radial.collect(),
            g_um: 0.0,
            f_um: [0.0; 2],
            h_um: None,
        }
    }

    /// A machine whose axes are out of square, of different scale and of different lag.
    #[test]
    fn two_senses_tell_geometry_from_servos() {
        let (square, scale, lag) = (80.0, -30.0, 6.0);
        let of = |sense: f64| {
            circle(sense > 0.0, move |angle| {
                let (sin, cos) = math::sin_cos(angle);
                let (x, y) = (1e-3 * RADIUS_MM * cos, 1e-3 * RADIUS_MM * sin);
                // The first axis is behind by its way, which is -sin of the angle.
                [square * y + scale * x + lag * sense * sin, 0.0]
            })
        };
        let both = [of(1.0), of(-1.0)];
        for circle in &both {
            let found = sheet(circle, &both).both.unwrap();
            assert!((found.squareness_um_m - square).abs() < 0.1, "{found:?}");
            assert!((found.scale_um_m - scale).abs() < 0.1, "{found:?}");
            assert!((found.mismatch_um - lag).abs() < 0.01, "{found:?}");
        }
        assert_eq!(sheet(&both[0], &both[..1]).both, None);
    }

    /// The load of one axis stays behind by its gap: a step at its reversals, and none at the other's.
    #[test]
    fn lost_motion_is_a_step_and_a_spike_is_none() {
        for (counterclockwise, axis) in [(true, 0), (false, 0), (true, 1), (false, 1)] {
            let gap = 10.0;
            let off = move |angle: f64| {
                let sense = if counterclockwise { 1.0 } else { -1.0 };
                // Against the velocity by half the gap.
                let velocity = [
                    -math::sin_cos(angle).0 * sense,
                    math::sin_cos(angle).1 * sense,
                ];
                let mut off = [0.0; 2];
                off[axis] = -0.5 * gap * velocity[axis].signum();
                off
            };
            let found = sheet(&circle(counterclockwise, off), &[]);
            assert!((found.step_um[axis] - gap).abs() < 1e-4, "{found:?}");
            assert!(found.step_um[1 - axis].abs() < 1e-4, "{found:?}");
            assert!(found.spike_um.iter().all(|um| *um < 1e-4), "{found:?}");
            // A spike of 4 um for some degrees behind one reversal.
            let spiked = circle(counterclockwise, move |angle| {
                let mut of = off(angle);
                let at = if axis == 0 { 0.0 } else { 0.25 * TAU };
                let sense = if counterclockwise { 1.0 } else { -1.0 };
                if ((angle - at) * sense).rem_euclid(TAU) < 0.1 {
                    of[axis] += 4.0;
                }
                of
            });
            let found = sheet(&spiked, &[]);
            assert!((found.spike_um[axis] - 4.0).abs() < 0.01, "{found:?}");
            assert!((found.step_um[axis] - gap).abs() < 1e-4, "{found:?}");
        }
    }
}
