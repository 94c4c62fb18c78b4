//! Every limit of every joint is kept at every sample of every sample part, on finite differences
//! as an outsider would take them.

use crate::common::{machine, part};
use lostmotion::base::Coords;
use lostmotion::sim::Simulation;

const PERIOD_S: f64 = 1e-3;
/// Differences of positions with 1e-12 of rounding, three times over 1 ms.
const SLACK: f64 = 1.001;

fn difference(from: &[Coords]) -> Vec<Coords> {
    from.windows(2)
        .map(|pair| (pair[1] - pair[0]) * (1.0 / PERIOD_S))
        .collect()
}

fn check(name: &str, on: &str) {
    let machine = machine(on);
    let mut positions = Vec::new();
    Simulation::new(&part(name), &machine)
        .plan(&mut |samples, _| {
            positions.extend(samples.iter().map(|sample| sample.position));
            Ok(())
        })
        .unwrap_or_else(|error| panic!("{name}: {error}"));
    let rest = |at: Option<&Coords>| vec![*at.expect("samples"); 4];
    let positions = [
        rest(positions.first()),
        positions.clone(),
        rest(positions.last()),
    ]
    .concat();
    let velocity = difference(&positions);
    let acceleration = difference(&velocity);
    let jerk = difference(&acceleration);
    for axis in machine.axes() {
        let peak = |series: &[Coords]| series.iter().map(|c| c[axis.id].abs()).fold(0.0, f64::max);
        let limits = axis.limits;
        for (what, value, limit) in [
            ("velocity", peak(&velocity), limits.velocity),
            ("acceleration", peak(&acceleration), limits.acceleration),
            ("jerk", peak(&jerk), limits.jerk),
        ] {
            assert!(
                value <= limit * SLACK,
                "{name} on {on}: {what} of {} reaches {value} of {limit}",
                axis.id
            );
        }
    }
}

#[test]
fn three_axis_parts_keep_all_limits() {
    for name in [
        "bearing_bore.ngc",
        "circle_diamond_square.ngc",
        "circle_r10.ngc",
        "contour_rarcs.ngc",
        "engraving.ngc",
        "inch_bracket.ngc",
        "incremental_comb.ngc",
        "lissajous.ngc",
        "planes_ball.ngc",
        "pocket_helical.ngc",
        "square_rounded.ngc",
        "square_sharp.ngc",
        "trochoidal_slot.ngc",
        "work_offsets.ngc",
    ] {
        check(name, "vmc3");
    }
}

#[test]
fn five_axis_parts_keep_all_joint_limits() {
    check("trunnion_bevel.ngc", "trunnion5");
    check("trunnion_cone.ngc", "trunnion5");
}
