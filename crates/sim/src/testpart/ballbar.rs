//! A circle in both senses as a ballbar measures it, and what a simulated machine makes of it.

use super::dialect::{Writer, plain, word};
use super::{REST_S, TestOptions, feed, plane, radius};
use crate::error::SimError;
use crate::machine::Machine;
use crate::observer::{ContourPoint, Observer};
use crate::program::Program;
use crate::simulation::Simulation;
use lostmotion_base::Plane;
use lostmotion_contour::ballbar::BallbarTrace;
use lostmotion_contour::{Circle, RadialPoint};
use lostmotion_gcode::Dialect;

/// A ballbar's circle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BallbarTest {
    /// The circle, from the program's zero.
    pub circle: Circle,
    /// Feed, mm/min.
    pub feed_mm_min: f64,
}

impl BallbarTest {
    /// The circle of a machine in XY.
    ///
    /// # Errors
    /// A radius or a feed that travel or limits do not allow; as [`Simulation::check`] where the
    /// machine runs none of the usual circles.
    pub fn new(machine: &Machine, options: &TestOptions) -> Result<BallbarTest, SimError> {
        let plane = plane(machine)?;
        let of = |radius_mm: f64| -> Result<BallbarTest, SimError> {
            Ok(BallbarTest {
                circle: Circle {
                    plane: Plane::Xy,
                    center_mm: plane.map(|way| way.middle),
                    radius_mm,
                },
                feed_mm_min: feed(&plane, radius_mm, options.feed_mm_min)?,
            })
        };
        of(radius(machine, &plane, options.radius_mm, |radius_mm| {
            Ok(of(radius_mm)?.program(Dialect::LinuxCnc, machine))
        })?)
    }

    /// The program for a control.
    pub(super) fn program(&self, dialect: Dialect, machine: &Machine) -> String {
        self.written(dialect, machine).0
    }

    /// The program, and the lines of its circles, counter-clockwise first.
    fn written(&self, dialect: Dialect, machine: &Machine) -> (String, [u32; 2]) {
        let radius = self.circle.radius_mm;
        let [x, y] = self.circle.center_mm;
        let about = format!(
            "ballbar of {}: radius {} mm, {} mm/min; bar on, Z by hand; origin G54",
            machine.name(),
            plain(radius),
            plain(self.feed_mm_min)
        );
        let mut writer = Writer::new(dialect, &about);
        let (left, right) = (word(x - radius), word(x + radius));
        let (y, feed) = (word(y), word(self.feed_mm_min));
        writer.line(&format!("G0 X{left} Y{y}"));
        writer.remark("put the bar on, start its recording");
        writer.line("M0");
        let mut lines = [0; 2];
        for (line, (code, name)) in lines
            .iter_mut()
            .zip([("G3", "counter-clockwise"), ("G2", "clockwise")])
        {
            writer.remark(name);
            writer.dwell(REST_S);
            // Half a turn to get to speed, the turn that is measured, half a turn to come to rest.
            writer.line(&format!(
                "{code} X{right} Y{y} I{} J0. F{feed}",
                word(radius)
            ));
            *line = writer.line(&format!(
                "{code} X{right} Y{y} I{} J0. F{feed}",
                word(-radius)
            ));
            writer.line(&format!(
                "{code} X{left} Y{y} I{} J0. F{feed}",
                word(-radius)
            ));
        }
        writer.dwell(REST_S);
        (writer.finish(), lines)
    }
}

/// Gathers the radial deviation on two lines of the program.
struct Bar {
    circle: Circle,
    lines: [u32; 2],
    points: [Vec<RadialPoint>; 2],
}

impl Observer for Bar {
    fn contour(&mut self, method: usize, points: &[ContourPoint]) {
        if method > 0 {
            return;
        }
        for point in points {
            let line = point.block.span.line;
            let Some(index) = self.lines.iter().position(|other| *other == line) else {
                continue;
            };
            self.points[index].extend(self.circle.profile([&point.actual_mm]));
        }
    }

    fn wants_contour(&self) -> bool {
        true
    }
}

/// What a ballbar would measure on a machine as it is described, with the methods that it names.
///
/// # Errors
/// As [`Simulation::run`], and [`SimError::Refused`] where the machine stops.
pub fn simulate_ballbar(
    machine: &Machine,
    test: &BallbarTest,
) -> Result<Vec<BallbarTrace>, SimError> {
    let (text, lines) = test.written(Dialect::LinuxCnc, machine);
    let program = Program::from_str("ballbar", &text);
    let mut bar = Bar {
        circle: test.circle,
        lines,
        points: Default::default(),
    };
    let run = Simulation::new(&program, machine)
        .dialect(Dialect::LinuxCnc)
        .observer(&mut bar)
        .run()?;
    if let Some(stop) = run.results.first().and_then(|result| result.stop.as_ref()) {
        return Err(SimError::refused(
            format!(
                "the machine `{}` stops on the ballbar's circle after {:.2} s",
                machine.name(),
                stop.time_s
            ),
            "take a lower feed, or correct the description",
        ));
    }
    Ok(bar.points.into_iter().map(BallbarTrace::new).collect())
}
