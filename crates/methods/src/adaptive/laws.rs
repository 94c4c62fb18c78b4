//! Shaft and friction of the hypotheses, in a form that vectors can take.

/// Torque of the shaft at a lead, nothing within the gap.
#[inline(always)]
pub(super) fn shaft(lead: f64, half_gap: f64, stiffness: f64, damping_torque: f64) -> f64 {
    let pressed = lead - lead.max(-half_gap).min(half_gap);
    if pressed.abs() > 0.0 {
        stiffness * pressed + damping_torque
    } else {
        0.0
    }
}

/// Speed after a gain of speed with friction that takes at most `most`; what turns around does so
/// within the sample, and friction with it.
#[inline(always)]
pub(super) fn slide(speed: f64, gain: f64, most: f64) -> f64 {
    let driven = gain - gain.max(-most).min(most);
    let after = speed + gain - if speed > 0.0 { most } else { -most };
    let turns = speed * after <= 0.0;
    // part of the sample that is left once it stands
    let left = if speed.abs() > 0.0 {
        after / (after - speed)
    } else {
        1.0
    };
    if turns { left * driven } else { after }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mass_that_turns_around_goes_on_with_friction_against_its_new_way() {
        // at rest after 0.1/0.61 of the sample, then 0.59 for the rest of it
        assert!((slide(-0.1, 0.6, 0.01) - 0.59 * (1.0 - 0.1 / 0.61)).abs() < 1e-15);
        assert_eq!((slide(0.1, -0.005, 0.2), slide(0.0, 0.1, 0.2)), (0.0, 0.0));
        assert!(
            (slide(0.5, 0.1, 0.2) - 0.4).abs() < 1e-15
                && (slide(0.0, 0.3, 0.2) - 0.1).abs() < 1e-15
        );
    }
}
