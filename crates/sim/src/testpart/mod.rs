//! Programs to run on a machine in order to measure it: circles for a ballbar or a grid plate,
//! reversals, friction, and the motion that teaches an axis.
//!
//! The moves fit the travel and the limits of the machine as it is described; they are in G54, and
//! leave alone the axes that they do not measure.

mod answer;
mod ballbar;
mod dialect;

pub use answer::{BALLBAR_SCHEMA, BallbarAnswer};
pub use ballbar::{BallbarTest, simulate_ballbar};

use crate::commission;
use crate::error::SimError;
use crate::machine::{Machine, MachineAxis};
use crate::program::Program;
use crate::simulation::Simulation;
use dialect::{Writer, plain, word};
use lostmotion_base::AxisId;
use lostmotion_base::units::deg;
use lostmotion_gcode::Dialect;
use std::fmt;

/// Part of the travel that is used: the ends stay clear.
const TRAVEL_SHARE: f64 = 0.8;
/// Part of a limit of velocity, acceleration or jerk that a circle takes. A choice: the servo, not
/// the control's look-ahead, is to be measured.
const LIMIT_SHARE: f64 = 0.5;
/// Radii of a ballbar, mm.
const BARS_MM: [f64; 4] = [300.0, 150.0, 100.0, 50.0];
/// Usual feed of a circle, mm/min.
const FEED_MM_MIN: f64 = 1000.0;
/// Rest before and behind what is measured, s.
const REST_S: f64 = 2.0;
/// Longest reversal or friction stroke, mm or deg. A choice: a scale or a laser reaches it, and a
/// slow stroke ends.
const STROKE: f64 = 100.0;
/// Places at which a reversal is measured, and how often.
const PLACES: u32 = 5;
const CYCLES: u32 = 2;
/// Speeds of strokes for friction, as parts of the axis' largest. A choice: Stribeck's decay lies
/// below a hundredth, viscous friction shows above a tenth.
const SPEEDS: [f64; 8] = [0.001, 0.003, 0.01, 0.03, 0.1, 0.2, 0.4, 0.6];
/// Longest time of a stroke, s.
const MOST_S: f64 = 20.0;

/// What a program is to measure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TestKind {
    /// Circles of several sizes and feeds in both senses: a grid plate, or a part to be measured.
    Circle,
    /// Places that are come to from both sides, with rests: reversal value B of ISO 230-2.
    Reversal,
    /// One circle in both senses, with half a turn before and behind: a ballbar.
    Ballbar,
    /// The motion that teaches an axis its load and its gap ([`crate::commission`]).
    Commission,
    /// Strokes at steady speeds both ways: friction over speed.
    Friction,
}

impl TestKind {
    /// All of them.
    pub const ALL: [TestKind; 5] = [
        TestKind::Circle,
        TestKind::Reversal,
        TestKind::Ballbar,
        TestKind::Commission,
        TestKind::Friction,
    ];

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            TestKind::Circle => "circle",
            TestKind::Reversal => "reversal",
            TestKind::Ballbar => "ballbar",
            TestKind::Commission => "commission",
            TestKind::Friction => "friction",
        }
    }
}

impl fmt::Display for TestKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// How a program is to be.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TestOptions {
    /// Dialect; the machine's if `None`.
    pub dialect: Option<Dialect>,
    /// Radius of the circle, mm; the largest of 300, 150, 100 and 50 that the machine can run if
    /// `None`.
    pub radius_mm: Option<f64>,
    /// Feed of the circle, mm/min; 1000, or less where the limits ask for it, if `None`.
    pub feed_mm_min: Option<f64>,
}

/// Writes the program of a test. Programs for Siemens are written, but not read: what one does tells
/// the same test written for LinuxCNC, which has the same moves.
///
/// ```
/// use lostmotion_sim::testpart::{TestKind, TestOptions, program};
/// use lostmotion_sim::{Machine, Program, Simulation};
///
/// let machine = Machine::preset("vmc3")?;
/// let text = program(&machine, TestKind::Reversal, &TestOptions::default())?;
/// let run = Simulation::new(&Program::from_str("reversal.ngc", &text), &machine).run()?;
/// assert!(run.results[0].stop.is_none());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// [`SimError::Refused`]: a dialect that a test is not written for, a circle that the travel or the limits do not
/// allow, kinematics whose joints a program does not move one by one. As [`Simulation::check`] where
/// the machine runs none of the usual circles.
pub fn program(
    machine: &Machine,
    kind: TestKind,
    options: &TestOptions,
) -> Result<String, SimError> {
    let dialect = options.dialect.unwrap_or(machine.dialect());
    let of_circle = options.radius_mm.is_some() || options.feed_mm_min.is_some();
    if of_circle && !matches!(kind, TestKind::Circle | TestKind::Ballbar) {
        return Err(SimError::refused(
            format!("radius and feed are those of a circle, and `{kind}` has none"),
            "leave them out",
        ));
    }
    match kind {
        TestKind::Ballbar => Ok(BallbarTest::new(machine, options)?.program(dialect, machine)),
        TestKind::Circle => circles(machine, dialect, options),
        TestKind::Reversal => strokes(machine, dialect, kind, reversal),
        TestKind::Friction => strokes(machine, dialect, kind, friction),
        TestKind::Commission => {
            if dialect != Dialect::LinuxCnc {
                return Err(SimError::refused(
                    format!(
                        "`commission` is written for LinuxCNC alone, not for {}",
                        dialect.name()
                    ),
                    "its swings are chains of short feed moves in G53, which other controls refuse",
                ));
            }
            let drives = machine.drives();
            commission::program(machine, &drives).map_err(|why| {
                SimError::refused(
                    why,
                    "take the setpoints of each joint: `axis commission --out`",
                )
            })
        }
    }
}

/// An axis in the program's coordinates, mm or deg.
#[derive(Clone, Copy, Debug)]
struct Way {
    axis: AxisId,
    middle: f64,
    /// Half of what may be used.
    half: f64,
    velocity: f64,
    acceleration: f64,
    jerk: f64,
}

impl Way {
    fn of(machine: &Machine, axis: &MachineAxis) -> Way {
        let unit = if axis.is_rotary() { deg(1.0) } else { 1.0 };
        let zero = machine.work_offsets()[0].0[axis.id.index()];
        let limits = &axis.limits;
        Way {
            axis: axis.id,
            middle: unit * (0.5 * (limits.min + limits.max) - zero),
            half: unit * 0.5 * TRAVEL_SHARE * (limits.max - limits.min),
            velocity: unit * limits.velocity,
            acceleration: unit * limits.acceleration,
            jerk: unit * limits.jerk,
        }
    }
}

/// The axes of a machine that a program moves one by one.
fn ways(machine: &Machine, kind: TestKind) -> Result<Vec<Way>, SimError> {
    let kinematics = machine.kinematics().kind();
    if kinematics != "cartesian" {
        return Err(SimError::refused(
            format!(
                "machine `{}` has kinematics \"{kinematics}\", whose joints a program does not move one by one: no `{kind}` for it",
                machine.name()
            ),
            "take --for ballbar, or setpoints of each joint: `axis commission --out`",
        ));
    }
    Ok(machine
        .axes()
        .iter()
        .map(|axis| Way::of(machine, axis))
        .collect())
}

/// The two axes of the plane XY, and the largest radius and feed that they allow.
fn plane(machine: &Machine) -> Result<[Way; 2], SimError> {
    // Where joints are not the program's axes the travel tells nothing: around the program's zero.
    let is_cartesian = machine.kinematics().kind() == "cartesian";
    let free = |axis: AxisId| Way {
        axis,
        middle: 0.0,
        half: BARS_MM[0],
        velocity: f64::INFINITY,
        acceleration: f64::INFINITY,
        jerk: f64::INFINITY,
    };
    let of = |axis: AxisId| match machine.axis(axis) {
        Some(found) if is_cartesian => Ok(Way::of(machine, found)),
        _ if !is_cartesian => Ok(free(axis)),
        _ => Err(SimError::refused(
            format!("machine `{}` has no axis {axis}", machine.name()),
            "a circle needs X and Y",
        )),
    };
    Ok([of(AxisId::X)?, of(AxisId::Y)?])
}

/// The fastest feed on a circle that takes half of the limits of both axes, mm/min.
fn fastest(plane: &[Way; 2], radius_mm: f64) -> f64 {
    let least = |of: fn(&Way) -> f64| of(&plane[0]).min(of(&plane[1])) * LIMIT_SHARE;
    let velocity = least(|way| way.velocity);
    let acceleration = (least(|way| way.acceleration) * radius_mm).sqrt();
    let jerk = lostmotion_base::math::cbrt(least(|way| way.jerk) * radius_mm * radius_mm);
    60.0 * velocity.min(acceleration).min(jerk)
}

/// The feed asked for, or a usual one.
fn feed(plane: &[Way; 2], radius_mm: f64, asked: Option<f64>) -> Result<f64, SimError> {
    let most = fastest(plane, radius_mm);
    match asked {
        Some(feed) if !(feed.is_finite() && feed > 0.0) => Err(SimError::refused(
            format!("a feed of {feed} mm/min"),
            "give a positive one",
        )),
        Some(feed) if feed > most => Err(SimError::refused(
            format!(
                "{feed} mm/min on a radius of {radius_mm} mm takes more than half of the limits of the axes"
            ),
            format!("up to {:.0} mm/min can be measured", most.floor()),
        )),
        Some(feed) => Ok(feed),
        None => Ok(FEED_MM_MIN.min((most / 10.0).floor() * 10.0).max(1.0)),
    }
}

/// The radius asked for, or the largest usual one that fits: whose program, which `text` writes for
/// LinuxCNC, the machine can run.
fn radius(
    machine: &Machine,
    plane: &[Way; 2],
    asked: Option<f64>,
    text: impl Fn(f64) -> Result<String, SimError>,
) -> Result<f64, SimError> {
    let most = plane[0].half.min(plane[1].half);
    let largest = (10.0 * most).floor() / 10.0;
    match asked {
        Some(radius) if !(radius.is_finite() && radius > 0.0) => Err(SimError::refused(
            format!("a radius of {radius} mm"),
            "give a positive one",
        )),
        Some(radius) if radius > most => Err(SimError::refused(
            format!(
                "a circle of {radius} mm radius does not fit the travel with a tenth of it clear at each end"
            ),
            format!("the largest has {largest:.1} mm"),
        )),
        Some(radius) => Ok(radius),
        None => {
            let mut bars: Vec<f64> = BARS_MM.into_iter().filter(|bar| *bar <= most).collect();
            if bars.is_empty() {
                bars.push(largest);
            }
            // Where joints are not the program's axes only the machine itself tells what fits.
            let mut refused = None;
            for bar in bars {
                let program = Program::from_str("the test", &text(bar)?);
                let checked = Simulation::new(&program, machine)
                    .dialect(Dialect::LinuxCnc)
                    .check();
                match checked {
                    Ok(_) => return Ok(bar),
                    Err(error) => refused = Some(error),
                }
            }
            refused.map_or(Ok(largest), Err)
        }
    }
}

/// Circles of three sizes and two feeds, each in both senses.
fn circles(machine: &Machine, dialect: Dialect, options: &TestOptions) -> Result<String, SimError> {
    let plane = plane(machine)?;
    let text = |dialect: Dialect, largest: f64| {
        circles_up_to(largest, machine, &plane, dialect, options.feed_mm_min)
    };
    let largest = radius(machine, &plane, options.radius_mm, |radius_mm| {
        text(Dialect::LinuxCnc, radius_mm)
    })?;
    text(dialect, largest)
}

/// The circles of which the largest has this radius.
fn circles_up_to(
    largest: f64,
    machine: &Machine,
    plane: &[Way; 2],
    dialect: Dialect,
    asked: Option<f64>,
) -> Result<String, SimError> {
    let [x, y] = plane.map(|way| way.middle);
    let mut writer = Writer::new(
        dialect,
        &format!(
            "circles of {}: no tool in the part, Z by hand; origin G54",
            machine.name()
        ),
    );
    for part in [1.0, 0.5, 0.2] {
        let radius = part * largest;
        // Of smaller circles the limits may ask for less than was asked of the largest.
        let most = fastest(plane, radius);
        let usual = feed(plane, largest, asked)?.min(most);
        for feed in [usual, (0.2 * usual).max(1.0)] {
            for (code, name) in [("G3", "counter-clockwise"), ("G2", "clockwise")] {
                writer.remark(&format!(
                    "radius {} mm, {feed:.0} mm/min, {name}",
                    plain(radius)
                ));
                writer.line(&format!("G0 X{} Y{}", word(x + radius), word(y)));
                writer.dwell(REST_S);
                let (to, away) = (word(x + radius), word(-radius));
                writer.line(&format!(
                    "{code} X{to} Y{} I{away} J0. F{}",
                    word(y),
                    word(feed)
                ));
                writer.dwell(REST_S);
            }
        }
    }
    Ok(writer.finish())
}

/// A program of strokes, axis by axis.
fn strokes(
    machine: &Machine,
    dialect: Dialect,
    kind: TestKind,
    of: fn(&mut Writer, &Way),
) -> Result<String, SimError> {
    let ways = ways(machine, kind)?;
    let about = format!(
        "{kind} of {}: without tool and part, clear of the table; origin G54",
        machine.name()
    );
    let mut writer = Writer::new(dialect, &about);
    // To the middle one by one, Z first: where the others stand is not known.
    let mut order: Vec<&Way> = ways.iter().collect();
    order.sort_by_key(|way| way.axis != AxisId::Z);
    for way in order {
        writer.line(&format!("G0 {}{}", way.axis, word(way.middle)));
    }
    for way in &ways {
        writer.remark(&format!("axis {}", way.axis));
        of(&mut writer, way);
        writer.line(&format!("G0 {}{}", way.axis, word(way.middle)));
    }
    Ok(writer.finish())
}

/// Up and down through the same places, with a rest at each and a turn beyond both ends.
fn reversal(writer: &mut Writer, way: &Way) {
    let half = (0.5 * STROKE).min(way.half);
    // Beyond the ends by a tenth: each place is come to from one side alone.
    let reach = half / 1.1;
    let feed = word(60.0 * (0.1 * way.velocity).min(2.0 * half));
    let letter = way.axis;
    let place =
        |index: u32| way.middle + reach * (2.0 * f64::from(index) / f64::from(PLACES - 1) - 1.0);
    for _ in 0..CYCLES {
        writer.line(&format!("G1 {letter}{} F{feed}", word(way.middle - half)));
        for index in 0..PLACES {
            writer.line(&format!("G1 {letter}{} F{feed}", word(place(index))));
            writer.dwell(REST_S);
        }
        writer.line(&format!("G1 {letter}{} F{feed}", word(way.middle + half)));
        for index in (0..PLACES).rev() {
            writer.line(&format!("G1 {letter}{} F{feed}", word(place(index))));
            writer.dwell(REST_S);
        }
    }
}

/// There and back at each speed.
fn friction(writer: &mut Writer, way: &Way) {
    let letter = way.axis;
    for part in SPEEDS {
        let speed = part * way.velocity;
        // Long enough to run at that speed, short enough to end.
        let half = (0.5 * speed * MOST_S).min(0.5 * STROKE).min(way.half);
        writer.line(&format!("G0 {letter}{}", word(way.middle - half)));
        writer.dwell(0.5);
        for end in [half, -half] {
            writer.line(&format!(
                "G1 {letter}{} F{}",
                word(way.middle + end),
                word(60.0 * speed)
            ));
            writer.dwell(0.5);
        }
    }
}
