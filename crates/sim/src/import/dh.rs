//! A serial arm by its Denavit-Hartenberg parameters as `genserkins` and `pumakins` have them (J. J.
//! Craig, Introduction to Robotics): from joint to joint a turn ALPHA about X, a step A along X, the
//! joint's own turn about Z, a step D along Z.

use super::draft::{Draft, clean};
use super::hal::Pins;
use super::problem;
use crate::machine::Problem;
use lostmotion_base::{AxisId, math};
use lostmotion_kinematics::chain::{GaugeSpec, JointSpec, Side};
use lostmotion_kinematics::{ChainSpec, Words};

/// Joints of an arm.
const JOINTS: usize = 6;

/// From the joint before to this one: the step A along X, the turn ALPHA about it (rad), the step D
/// along the joint's own axis.
#[derive(Clone, Copy, Default)]
struct Link {
    a_mm: f64,
    alpha: f64,
    d_mm: f64,
}

/// Writes a chain of six joints; every length and angle has to be told.
pub(super) fn serial(draft: &mut Draft, pins: &mut Pins<'_>, mm: f64) -> Result<(), Problem> {
    let mut links = [Link::default(); JOINTS];
    for (number, link) in links.iter_mut().enumerate() {
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
        *link = Link {
            a_mm: pin(draft, "A", mm)?,
            alpha: pin(draft, "ALPHA", 1.0)?,
            d_mm: pin(draft, "D", mm)?,
        };
    }
    draft.kinematics = chain(links).into();
    Ok(())
}

/// The arm of Craig's book: five lengths, which LinuxCNC presets to those of a small one, and axes
/// that are upright, level, level, and the three of a wrist.
pub(super) fn puma(draft: &mut Draft, pins: &mut Pins<'_>, mm: f64) -> Result<(), Problem> {
    let mut length = |name: &str, usual: f64| {
        let why = "LinuxCNC's default: set it to your arm's";
        pins.length(draft, name, mm, usual * mm, "kinematics.joint", why)
    };
    let (a2, a3) = (length("A2", 300.0)?, length("A3", 50.0)?);
    let (d3, d4, d6) = (
        length("D3", 70.0)?,
        length("D4", 400.0)?,
        length("D6", 70.0)?,
    );
    let quarter = std::f64::consts::FRAC_PI_2;
    let link = |a_mm, alpha, d_mm| Link { a_mm, alpha, d_mm };
    draft.kinematics = chain([
        link(0.0, 0.0, 0.0),
        link(0.0, -quarter, 0.0),
        link(a2, 0.0, d3),
        link(a3, -quarter, d4),
        link(0.0, quarter, 0.0),
        link(0.0, -quarter, d6),
    ])
    .into();
    Ok(())
}

/// The chain of six rotary joints with all of them at zero.
fn chain(links: [Link; JOINTS]) -> ChainSpec {
    // Columns X, Y, Z of the frame, and where it is.
    let (mut x, mut y, mut z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let mut place = [0.0; 3];
    let mut joints = Vec::with_capacity(JOINTS);
    for (link, axis) in links.into_iter().zip(AxisId::ALL) {
        // Turn about X by alpha and step along X: the new Z is the joint's axis.
        let (sin, cos) = math::sin_cos(link.alpha);
        let turned = |a: f64, b: f64| -> [f64; 3] { std::array::from_fn(|i| a * y[i] + b * z[i]) };
        (y, z) = (turned(cos, sin), turned(-sin, cos));
        place = along(place, x, link.a_mm);
        joints.push(JointSpec::rotary(axis, Side::Head, clean(z), clean(place)));
        place = along(place, z, link.d_mm);
    }
    x = clean(x);
    // The tool points along the last frame's Z: from the tip to the spindle is against it.
    let gauge = GaugeSpec {
        point_mm: clean(place),
        axis: clean(z.map(|c| -c)),
        x_axis: x,
    };
    ChainSpec {
        words: Some(Words::Pose),
        gauge: Some(gauge),
        joint: joints,
        ..ChainSpec::default()
    }
}

fn along(place: [f64; 3], direction: [f64; 3], by: f64) -> [f64; 3] {
    std::array::from_fn(|i| place[i] + by * direction[i])
}
