//! A rotary table behind a worm: at a radius its gap is an error of radius times gap.
//!
//! The gaps are those of worn worms, so that the way the table coasts when it stops is small beside
//! them.

use lostmotion_base::AxisId;
use lostmotion_base::units::rad;
use lostmotion_sim::machine::{Machine, presets};
use lostmotion_sim::{ContourPoint, Observer, Program, Simulation};

#[derive(Default)]
struct Points(Vec<ContourPoint>);

impl Observer for Points {
    fn wants_contour(&self) -> bool {
        true
    }

    fn contour(&mut self, _method: usize, points: &[ContourPoint]) {
        self.0.extend(points);
    }
}

/// C comes to 0 from below, then from above; each time a line outwards along X. Tool-centre-point
/// is in force on this machine.
const SPOKES: &str = "G21 G90 G17 G61\nG0 Z40\nG1 X10 Y0 C-5 F3000\nC-0.2\nC0 F10\nG4 P0.2\nX90 F1000\nX10\nC5 F3000\nC0.2\nC0 F10\nG4 P0.2\nX90 F1000\nM2\n";

#[test]
fn the_error_is_radius_times_gap() {
    for gap_mdeg in [50.0, 150.0] {
        let machine = Machine::preset("trunnion5").expect("trunnion5");
        // the gap of C alone
        let machine = machine.without_gap();
        let config = machine
            .axis(AxisId::C)
            .expect("C")
            .config
            .with_gap(gap_mdeg * 1e-3);
        let machine = machine.with_axis_config(AxisId::C, &config);
        let source = Program::from_bytes("spokes.ngc", SPOKES.as_bytes());
        let mut points = Points::default();
        Simulation::new(&source, &machine)
            .method("none")
            .observer(&mut points)
            .run()
            .map(|run| run.into_single().unwrap())
            .expect("a result");
        let at = |line: u32, radius: f64| {
            let of_line = points
                .0
                .iter()
                .filter(|point| point.block.span.line == line);
            let nearest = of_line.min_by(|a, b| {
                (a.foot_mm[0] - radius)
                    .abs()
                    .total_cmp(&(b.foot_mm[0] - radius).abs())
            });
            nearest.expect("points").backlash_um
        };
        for radius in [30.0, 60.0, 85.0] {
            let (below, above) = (at(7, radius), at(13, radius));
            let expected = radius * rad(gap_mdeg * 1e-3) * 1e3;
            assert!(
                ((below - above).abs() - expected).abs() < 0.02 * expected + 0.05,
                "{gap_mdeg} mdeg at {radius} mm: {below} and {above} um against {expected} um"
            );
        }
    }
}

/// Worms are sold with their backlash in seconds of arc or degrees.
#[test]
fn a_gap_in_any_unit_of_angle_is_the_same_gap() {
    let text = presets()
        .iter()
        .find(|preset| preset.name == "trunnion5")
        .expect("trunnion5")
        .toml;
    let (rest, table) = text.split_at(text.find("[axis.c.load.table]").expect("a table"));
    let own = table
        .lines()
        .find(|line| line.starts_with("gap_mdeg"))
        .expect("a gap");
    let read =
        |gap: &str| Machine::from_toml("w.toml", &format!("{rest}{}", table.replacen(own, gap, 1)));
    for gap in ["gap_mdeg = 7.5", "gap_arcsec = 27.0", "gap_deg = 0.0075"] {
        let machine = read(gap).expect(gap);
        let degrees = machine.axis(AxisId::C).expect("C").config.gap_in_unit();
        assert!((degrees - 0.0075).abs() < 1e-12, "{gap}: {degrees}");
    }
    let told = |gap: &str| read(gap).expect_err(gap).to_string();
    assert!(told("gap_arcsec = 27.0\ngap_mdeg = 7.5").contains("keep one of"));
    assert!(
        told("").contains(
            "the gap of the table is missing; add one of `gap_mdeg`, `gap_arcsec` and `gap_deg`"
        ),
        "{}",
        told("")
    );
    assert!(
        told("gap_um = 7.5").contains("one of `gap_arcsec`, `gap_mdeg`, `gap_deg`"),
        "{}",
        told("gap_um = 7.5")
    );
    let linear = text.replacen("gap_um = ", "gap_arcsec = ", 1);
    let error = Machine::from_toml("w.toml", &linear)
        .expect_err("an angle on a linear axis")
        .to_string();
    assert!(
        error.contains("the gap of a linear axis is a distance: `gap_um`"),
        "{error}"
    );
}
