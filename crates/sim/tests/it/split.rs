//! What is caused by backlash, held by what the gaps can do; and every tick in the trace.

use lostmotion_base::vec::{norm, sub};
use lostmotion_sim::{ContourPoint, Machine, Observer, Program, Simulation};

/// What the trace of one method shows.
#[derive(Default)]
struct Seen {
    points: u64,
    last: Option<ContourPoint>,
    /// The largest part that is laid to backlash, um, and when.
    largest: (f64, f64),
    /// Its largest change in a servo tick, um.
    jump: f64,
    /// Largest difference between the error and the distance from the tool to its foot point, um.
    apart_um: f64,
}

impl Observer for Seen {
    fn contour(&mut self, _method: usize, points: &[ContourPoint]) {
        for point in points {
            let size = point.backlash_um.abs();
            if size > self.largest.0 {
                self.largest = (size, point.time_s);
            }
            match self.last {
                Some(last) => {
                    assert!(
                        (point.time_s - last.time_s - 250e-6).abs() < 1e-9,
                        "a hole from {} to {}",
                        last.time_s,
                        point.time_s
                    );
                    self.jump = self.jump.max((size - last.backlash_um.abs()).abs());
                }
                None => assert_eq!(point.time_s.to_bits(), 0, "the first tick"),
            }
            let distance_um = 1e3 * norm(sub(point.actual_mm, point.foot_mm));
            self.apart_um = self
                .apart_um
                .max((distance_um - point.error_um.abs()).abs());
            self.points += 1;
            self.last = Some(*point);
        }
    }

    fn wants_contour(&self) -> bool {
        true
    }
}

/// The contour of a part without compensation, and its duration in s.
fn seen(name: &str) -> (Seen, f64) {
    let path = format!(
        "{}/../../gcode_samples/parts/{name}",
        env!("CARGO_MANIFEST_DIR")
    );
    let machine = Machine::preset("vmc3").expect("vmc3");
    let mut seen = Seen::default();
    let run = Simulation::new(&Program::from_path(path), &machine)
        .observer(&mut seen)
        .run()
        .expect("a run");
    (seen, run.plan.duration_s)
}

/// Without compensation a load is on one flank of its gap or between the two: its axis is off by
/// at most the whole gap from that of the machine without one. Three axes with gaps of 10 um move
/// the tool by at most sqrt(3) times that, two by sqrt(2) times. Subtracting signed distances gave
/// 39.4 um for the first of these parts and 23.5 um for the second.
#[test]
fn no_part_is_laid_to_backlash_beyond_what_the_gaps_can_do() {
    for (name, axes) in [
        ("pocket_helical.ngc", 3.0),
        ("bearing_bore.ngc", 3.0),
        ("square_sharp.ngc", 2.0),
    ] {
        let (seen, _) = seen(name);
        let ((um, at_s), bound_um) = (seen.largest, 10.0 * f64::sqrt(axes));
        assert!(
            um > 3.0 && um <= bound_um,
            "{name}: {um} um at {at_s} s of {bound_um}"
        );
        // The two machines go together; in a tick of 250 us they part by what a load flies in its
        // gap, at 10 mm/s at most. Signed distances jumped by 34 um.
        assert!(seen.jump < 2.5, "{name}: a jump of {} um", seen.jump);
    }
}

/// A program that measures its tool before it moves: at the first tick the tip stands where the
/// first move begins, a tool's length below the spindle, and is off nothing.
#[test]
fn a_tool_measured_at_rest_is_there_from_the_first_tick() {
    let text = "G21 G90 G94 G17 G54\nG43.1 Z55.5\nG0 X20 Y10 Z5\nG1 X40 F600\nM2\n";
    let machine = Machine::preset("vmc3").expect("vmc3");
    let mut seen = Standing::default();
    Simulation::new(&Program::from_str("tool.ngc", text), &machine)
        .observer(&mut seen)
        .run()
        .expect("a run");
    assert!(seen.0.len() > 4, "{}", seen.0.len());
    for point in &seen.0 {
        assert!((point.actual_mm[2] + 55.5).abs() < 1e-3, "{point:?}");
        assert!((point.commanded_mm[2] + 55.5).abs() < 1e-3, "{point:?}");
        assert!(point.error_um.abs() < 1.0, "{point:?}");
    }
}

/// The points of the first two milliseconds.
#[derive(Default)]
struct Standing(Vec<ContourPoint>);

impl Observer for Standing {
    fn contour(&mut self, _method: usize, points: &[ContourPoint]) {
        let early = points.iter().filter(|point| point.time_s < 2e-3);
        self.0.extend(early);
    }

    fn wants_contour(&self) -> bool {
        true
    }
}

/// Rows are counted against servo ticks, and the tool's place against its error: parts that dwell,
/// plunge and have corners in space, and one that changes its zero between moves: there the foot may
/// lie on a block of another zero than the command (it was a fixture's distance away, 60 mm).
#[test]
fn every_tick_is_in_the_trace_with_the_place_of_the_tool() {
    for name in ["circle_r50.ngc", "bolt_circle.ngc", "work_offsets.ngc"] {
        let (seen, duration_s) = seen(name);
        let ticks = (duration_s * 4000.0).round() as u64;
        assert!(
            seen.points.abs_diff(ticks) <= 4,
            "{name}: {} of {ticks}",
            seen.points
        );
        assert!(seen.apart_um < 1e-6, "{name}: {} um", seen.apart_um);
    }
}
