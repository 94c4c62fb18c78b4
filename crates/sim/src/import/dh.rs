//! A serial arm by its Denavit-Hartenberg parameters as `genserkins` has them (J. J. Craig,
//! Introduction to Robotics): from joint to joint a turn ALPHA about X, a step A along X, the
//! joint's own turn about Z, a step D along Z.

use super::draft::{Draft, clean};
use super::hal::Pins;
use super::problem;
use crate::machine::Problem;
use lostmotion_base::{AxisId, math};
use lostmotion_kinematics::chain::{GaugeSpec, JointSpec, Side};
use lostmotion_kinematics::{ChainSpec, Words};

const JOINTS: usize = 6;
/// Writes a chain of six joints; every length and angle has to be told.
pub(super) fn serial(draft: &mut Draft, pins: &mut Pins<'_>, mm: f64) -> Result<(), Problem> {
    // Columns X, Y, Z of the frame, and where it is.
    let (mut x, mut y, mut z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let mut place = [0.0; 3];
    let mut joints = Vec::with_capacity(JOINTS);
    for (number, axis) in AxisId::ALL.into_iter().take(JOINTS).enumerate() {
        // Nothing is filled in: an arm with a lent link would be another arm.
        let mut pin = |draft: &mut Draft, name: &str, scale: f64| {
            let name = format!("{name}-{number}");
            let told = pins.told(draft, &name, scale, "kinematics.joint")?;
            let hint = "an arm has A-0 ... A-5, ALPHA-0 ..., D-0 ... (mm or inch, rad): write [HAL] HALCMD = setp genserkins.A-0 0.0 and so on";
            told.ok_or_else(|| {
                problem(
                    pins.line(),
                    &format!("genserkins.{name}"),
                    "is not set in the INI file",
                    hint,
                )
            })
        };
        let (step, alpha, rise) = (
            pin(draft, "A", mm)?,
            pin(draft, "ALPHA", 1.0)?,
            pin(draft, "D", mm)?,
        );
        // Turn about X by alpha and step along X: the new Z is the joint's axis.
        let (sin, cos) = math::sin_cos(alpha);
        let turned = |a: f64, b: f64| -> [f64; 3] { std::array::from_fn(|i| a * y[i] + b * z[i]) };
        (y, z) = (turned(cos, sin), turned(-sin, cos));
        place = along(place, x, step);
        joints.push(JointSpec::rotary(axis, Side::Head, clean(z), clean(place)));
        place = along(place, z, rise);
    }
    x = clean(x);
    // The tool points along the last frame's Z: from the tip to the spindle is against it.
    let gauge = GaugeSpec {
        point_mm: clean(place),
        axis: clean(z.map(|c| -c)),
        x_axis: x,
    };
    draft.kinematics = ChainSpec {
        words: Some(Words::Pose),
        gauge: Some(gauge),
        joint: joints,
        ..ChainSpec::default()
    }
    .into();
    Ok(())
}

fn along(place: [f64; 3], direction: [f64; 3], by: f64) -> [f64; 3] {
    std::array::from_fn(|i| place[i] + by * direction[i])
}
