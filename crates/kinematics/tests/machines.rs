//! Every registered kind: forward undoes inverse, jets agree with differences, descriptions are checked.

#![allow(clippy::unwrap_used)]

use lostmotion_base::{AxisId, Coords, Jet, math};
use lostmotion_kinematics::{Kinematics, KinematicsError, KinematicsSpec, build, entries};
use proptest::prelude::*;

fn spec(kind: &str, point: [f64; 3], offset: [f64; 2], conventional: bool) -> KinematicsSpec {
    let mut spec = KinematicsSpec { kind: kind.into(), ..KinematicsSpec::default() };
    if kind.starts_with("trunnion") {
        spec.rotation_point_mm = Some(point);
        spec.offset_z_mm = Some(offset[1]);
        spec.conventional_directions = Some(conventional);
        *(if kind == "trunnion-ac" { &mut spec.offset_y_mm } else { &mut spec.offset_x_mm }) = Some(offset[0]);
    }
    spec
}

fn machine() -> impl Strategy<Value = (Box<dyn Kinematics>, [f64; 3])> {
    let tool = (-5.0..5.0_f64, -5.0..5.0_f64, 0.0..200.0_f64).prop_map(|(x, y, z)| [x, y, z]);
    let kinds: Vec<_> = entries().iter().map(|entry| entry.kind).collect();
    (prop::sample::select(kinds), prop::array::uniform3(-200.0..200.0_f64), prop::array::uniform2(-50.0..50.0_f64), any::<bool>(), tool)
        .prop_map(|(kind, point, offset, conventional, tool)| (build(&spec(kind, point, offset, conventional)).unwrap(), tool))
}

fn coords(linear: f64, angle: f64) -> impl Strategy<Value = Coords> {
    (prop::array::uniform3(-linear..linear), prop::array::uniform3(-angle..angle), prop::array::uniform3(-linear..linear))
        .prop_map(|([x, y, z], [a, b, c], [u, v, w])| Coords([x, y, z, a, b, c, u, v, w]))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(10_000))]

    #[test]
    fn forward_undoes_inverse((machine, tool) in machine(), pose in coords(500.0, 7.0)) {
        let joints = machine.inverse(&pose, &tool).unwrap();
        let difference = machine.forward(&joints, &tool) - pose;
        prop_assert!(difference.0.iter().all(|d| d.abs() < 1e-9), "{machine:?} {difference:?}");
        let tip = machine.tool_pose(&joints, &tool);
        prop_assert!((0..3).all(|i| (tip.tip[i] - pose.0[i]).abs() < 1e-9));
        let size = tip.axis.iter().map(|c| c * c).sum::<f64>();
        prop_assert!((size - 1.0).abs() < 1e-14);
    }

    #[test]
    fn rotary_axes_at_zero_leave_the_tool_offset((machine, tool) in machine(), pose in coords(500.0, 0.0001)) {
        let mut pose = pose;
        for axis in [AxisId::A, AxisId::B, AxisId::C] {
            pose[axis] = 0.0;
        }
        let difference = machine.inverse(&pose, &tool).unwrap() - pose - Coords::xyz(tool[0], tool[1], tool[2]);
        prop_assert!(difference.0.iter().all(|d| d.abs() < 1e-12));
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn jets_agree_with_differences((machine, tool) in machine(), p in prop::array::uniform4(coords(1.0, 1.0)), scale in 1.0..100.0_f64) {
        // A cubic through program space; rotary rates of 1 rad per unit of the parameter.
        let size = |axis: usize| if (3..6).contains(&axis) { 1.0 } else { scale };
        let at = |t: f64| Coords(std::array::from_fn(|i| size(i) * (p[0].0[i] + t * (p[1].0[i] + t * (p[2].0[i] + t * p[3].0[i])))));
        let program: [Jet; 9] = std::array::from_fn(|i| {
            Jet::new(size(i) * p[0].0[i], size(i) * p[1].0[i], 2.0 * size(i) * p[2].0[i], 6.0 * size(i) * p[3].0[i])
        });
        let joints = machine.inverse_jet(&program, &tool).unwrap();
        let f = |t: f64| machine.inverse(&at(t), &tool).unwrap();
        let h = 4e-3;
        let (m3, m2, m1, f0, f1, f2, f3) = (f(-3.0 * h), f(-2.0 * h), f(-h), f(0.0), f(h), f(2.0 * h), f(3.0 * h));
        for (i, joint) in joints.into_iter().enumerate() {
            let [m3, m2, m1, f0, f1, f2, f3] = [m3, m2, m1, f0, f1, f2, f3].map(|c| c.0[i]);
            let d1 = (m2 - 8.0 * m1 + 8.0 * f1 - f2) / (12.0 * h);
            let d2 = (-m2 + 16.0 * m1 - 30.0 * f0 + 16.0 * f1 - f2) / (12.0 * h * h);
            let d3 = (m3 - 8.0 * m2 + 13.0 * m1 - 13.0 * f1 + 8.0 * f2 - f3) / (8.0 * h * h * h);
            let Jet([v, j1, j2, j3]) = joint;
            prop_assert!((v - f0).abs() < 1e-12 * (1.0 + f0.abs()));
            let size = 1.0 + scale + 400.0;
            prop_assert!((j1 - d1).abs() < 1e-6 * size, "{j1} {d1}");
            prop_assert!((j2 - d2).abs() < 1e-6 * size, "{j2} {d2}");
            prop_assert!((j3 - d3).abs() < 1e-4 * size, "{j3} {d3}");
        }
    }
}

#[test]
fn a_table_tilted_by_a_quarter_turn() {
    // A table whose both axes meet in the origin, A = 90 degrees in conventional sense: the tool approaches along -Y of the
    // part, as a head turned by +90 degrees about X would.
    let machine = build(&spec("trunnion-ac", [0.0; 3], [0.0; 2], true)).unwrap();
    let mut program = Coords::xyz(1.0, 2.0, 3.0);
    program[AxisId::A] = std::f64::consts::FRAC_PI_2;
    let joints = machine.inverse(&program, &[0.0, 0.0, 100.0]).unwrap();
    assert!((joints - Coords([1.0, 3.0, -2.0 + 100.0, program[AxisId::A], 0.0, 0.0, 0.0, 0.0, 0.0])).0.iter().all(|d| d.abs() < 1e-13));
    let pose = machine.tool_pose(&joints, &[0.0, 0.0, 100.0]);
    assert!((pose.axis[1] + 1.0).abs() < 1e-15);
}

#[test]
fn the_tool_axis_is_the_way_from_tip_to_spindle() {
    // Seen from the part, the tip of a longer tool lies further along the axis by the difference.
    for entry in entries().iter().filter(|entry| entry.kind != "cartesian") {
        let machine = build(&spec(entry.kind, [10.0, -20.0, 5.0], [3.0, 7.0], false)).unwrap();
        let joints = Coords([5.0, 6.0, 7.0, 0.4, -0.7, 1.9, 0.0, 0.0, 0.0]);
        let (long, short) = (machine.tool_pose(&joints, &[0.0, 0.0, 80.0]), machine.tool_pose(&joints, &[0.0, 0.0, 30.0]));
        for i in 0..3 {
            assert!((short.tip[i] - long.tip[i] - 50.0 * short.axis[i]).abs() < 1e-12);
        }
        assert!((short.axis[2] - math::cos(if entry.kind == "trunnion-ac" { 0.4 } else { 0.7 })).abs() < 1e-15);
    }
}

fn message(error: &KinematicsError) -> String {
    error.to_string()
}

#[test]
fn descriptions_are_checked() {
    let read = |text: &str| toml::from_str::<KinematicsSpec>(text);
    let refused = |text: &str| message(&build(&read(text).unwrap()).unwrap_err());
    assert!(build(&read("kind = \"trunnion-ac\"\nrotation_point_mm = [0, 0, -50]\noffset_z_mm = 12.5").unwrap()).is_ok());
    assert_eq!(refused("kind = \"hexapod\""), "kinematics `hexapod`: there is no such kind; known are cartesian, trunnion-ac, trunnion-bc");
    assert_eq!(
        refused("kind = \"cartesian\"\noffset_y_mm = 1.0"),
        "kinematics `cartesian`: it has no use for `offset_y_mm`; it takes no parameters"
    );
    assert!(
        refused("kind = \"trunnion-ac\"\noffset_x_mm = 1.0")
            .contains("it takes rotation_point_mm, offset_y_mm, offset_z_mm, conventional_directions")
    );
    assert!(refused("kind = \"trunnion-ac\"").contains("`rotation_point_mm` is missing"));
    assert!(refused("kind = \"trunnion-bc\"\nrotation_point_mm = [0, 0, nan]").contains("`rotation_point_mm` is NaN"));
    assert!(read("kind = \"cartesian\"\noffset_y = 1.0").unwrap_err().to_string().contains("offset_y"));
    let spec = spec("trunnion-bc", [1.0, 2.0, 3.0], [4.0, 5.0], false);
    assert_eq!(read(&toml::to_string(&spec).unwrap()).unwrap(), spec);
}
