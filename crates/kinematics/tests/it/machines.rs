//! Every family: forward undoes inverse, jets agree with differences, Jacobians too.

use crate::common::{Poses, difference, machines};
use lostmotion_base::Random;
use lostmotion_base::{AxisId, Coords, Jet, math};
use lostmotion_kinematics::{Family, KindSpec, KindVisitor, KinematicsSpec, build};

#[test]
fn forward_undoes_inverse() {
    for described in machines() {
        let machine = described.build();
        let mut random = Random::new(1);
        let poses = if described.name.contains("numeric") {
            2_000
        } else {
            10_000
        };
        for _ in 0..poses {
            let (words, tool) = described.pose(machine.as_ref(), &mut random);
            let joints = machine.inverse(&words, &tool).unwrap();
            let back = machine.forward(&joints, &tool);
            let (mm, rad) = difference(&described, &words, &back);
            assert!(
                mm < 1e-9 && rad < 1e-9,
                "{}: {mm} mm, {rad} rad at {words:?}",
                described.name
            );
            let tip = machine.tool_pose(&joints, &tool);
            assert!((0..3).all(|i| (tip.tip[i] - back.0[i]).abs() < 1e-9));
            assert!((tip.axis.iter().map(|c| c * c).sum::<f64>() - 1.0).abs() < 1e-13);
        }
    }
}

#[test]
fn rotary_axes_at_zero_leave_the_tool_offset() {
    for described in machines()
        .into_iter()
        .filter(|m| m.poses == Poses::Any && !m.name.contains("inclined") && m.name != "corexy")
    {
        let machine = described.build();
        let mut random = Random::new(2);
        for _ in 0..200 {
            let (mut words, tool) = described.pose(machine.as_ref(), &mut random);
            for axis in [AxisId::A, AxisId::B, AxisId::C, AxisId::W] {
                words[axis] = 0.0;
            }
            let difference = machine.inverse(&words, &tool).unwrap()
                - words
                - Coords::xyz(tool[0], tool[1], tool[2]);
            assert!(
                difference.0.iter().all(|d| d.abs() < 1e-12),
                "{}",
                described.name
            );
        }
    }
}

#[test]
fn jets_agree_with_differences() {
    for described in machines() {
        let machine = described.build();
        let mut random = Random::new(3);
        let mut done = 0;
        while done < 60 {
            let (words, tool) = described.pose(machine.as_ref(), &mut random);
            // A cubic through the pose; rates of the order of 1 rad and 100 mm a unit.
            let rate = |random: &mut Random| {
                Coords(std::array::from_fn(|i| {
                    random.signed() * if (3..6).contains(&i) { 0.5 } else { 60.0 }
                }))
            };
            let p = [
                words,
                rate(&mut random),
                rate(&mut random),
                rate(&mut random),
            ];
            let at = |t: f64| {
                Coords(std::array::from_fn(|i| {
                    p[0].0[i] + t * (p[1].0[i] + t * (p[2].0[i] + t * p[3].0[i]))
                }))
            };
            let jets: [Jet; 9] = std::array::from_fn(|i| {
                Jet::new(p[0].0[i], p[1].0[i], 2.0 * p[2].0[i], 6.0 * p[3].0[i])
            });
            let h = 2e-3;
            let around: Result<Vec<Coords>, _> = (-4..=4)
                .map(|k| machine.inverse(&at(f64::from(k) * h), &tool))
                .collect();
            let (Ok(joints), Ok(f)) = (machine.inverse_jet(&jets, &tool), around) else {
                continue;
            };
            done += 1;
            for (i, Jet([v, j1, j2, j3])) in joints.into_iter().enumerate() {
                let f: Vec<f64> = f.iter().map(|c| c.0[i]).collect();
                // Central differences of eighth, eighth and sixth order.
                let d1 = [(5, 0.8), (6, -0.2), (7, 4.0 / 105.0), (8, -1.0 / 280.0)]
                    .iter()
                    .map(|(k, w)| w * (f[*k] - f[8 - k]))
                    .sum::<f64>()
                    / h;
                let d2 = ([(5, 1.6), (6, -0.2), (7, 8.0 / 315.0), (8, -1.0 / 560.0)]
                    .iter()
                    .map(|(k, w)| w * (f[*k] + f[8 - k]))
                    .sum::<f64>()
                    - 205.0 / 72.0 * f[4])
                    / (h * h);
                let d3 = [
                    (5, -61.0 / 30.0),
                    (6, 169.0 / 120.0),
                    (7, -0.3),
                    (8, 7.0 / 240.0),
                ]
                .iter()
                .map(|(k, w)| w * (f[*k] - f[8 - k]))
                .sum::<f64>()
                    / (h * h * h);
                let size = 1.0 + j1.abs() + j2.abs() + j3.abs();
                assert!(
                    (v - f[4]).abs() < 1e-9 * (1.0 + v.abs()),
                    "{} {v} {}",
                    described.name,
                    f[4]
                );
                assert!(
                    (j1 - d1).abs() < 1e-7 * size,
                    "{} joint {i} first: {j1} {d1}",
                    described.name
                );
                assert!(
                    (j2 - d2).abs() < 3e-6 * size + 1e-5,
                    "{} joint {i} second: {j2} {d2}",
                    described.name
                );
                assert!(
                    (j3 - d3).abs() < 1e-3 * size + 1e-3,
                    "{} joint {i} third: {j3} {d3}",
                    described.name
                );
            }
        }
    }
}

#[test]
fn jacobians_agree_with_differences() {
    for described in machines() {
        let machine = described.build();
        let Some(chain) = machine.chain() else {
            continue;
        };
        let mut random = Random::new(4);
        for _ in 0..100 {
            let joints = Coords(std::array::from_fn(|i| {
                random.signed() * if (3..6).contains(&i) { 3.0 } else { 2.0 }
            }));
            let tool = crate::common::tool(&mut random);
            for (joint, (linear, angular)) in
                chain.joints().iter().zip(chain.jacobian(&joints, &tool))
            {
                let h = 1e-4;
                let moved = |by: f64| {
                    let mut moved = joints;
                    moved[joint.axis] += by;
                    (chain.tip(&moved.0, &tool), chain.axis(&moved))
                };
                let ((p, u), (q, v)) = (moved(-h), moved(h));
                let (far, near) = ((moved(-2.0 * h), moved(2.0 * h)), chain.axis(&joints));
                let spin = [
                    angular[1] * near[2] - angular[2] * near[1],
                    angular[2] * near[0] - angular[0] * near[2],
                    angular[0] * near[1] - angular[1] * near[0],
                ];
                for i in 0..3 {
                    let tip = (8.0 * (q[i] - p[i]) - (far.1.0[i] - far.0.0[i])) / (12.0 * h);
                    let axis = (8.0 * (v[i] - u[i]) - (far.1.1[i] - far.0.1[i])) / (12.0 * h);
                    assert!(
                        (tip - linear[i]).abs() < 1e-7,
                        "{} {}: {tip} {linear:?}",
                        described.name,
                        joint.axis
                    );
                    assert!(
                        (axis - spin[i]).abs() < 1e-9,
                        "{} {}",
                        described.name,
                        joint.axis
                    );
                }
            }
        }
    }
}

#[test]
fn families_are_recognised() {
    let family = |name: &str| {
        machines()
            .into_iter()
            .find(|m| m.name == name)
            .unwrap()
            .build()
            .chain()
            .unwrap()
            .family()
    };
    for (name, expected) in [
        ("3 axes", Family::Linear),
        ("rotary table A", Family::RotaryTable),
        ("rotary head B", Family::RotaryHead),
        ("table-table BC", Family::TableTable),
        ("trunnion-ac", Family::TableTable),
        ("head-head CA", Family::HeadHead),
        ("head-table BC", Family::HeadTable),
        ("nutating head", Family::Nutating),
        ("arm, spherical wrist", Family::SphericalWristArm),
        ("arm, offset wrist (numeric)", Family::General),
    ] {
        assert_eq!(family(name), expected, "{name}");
    }
}

#[test]
fn a_table_tilted_by_a_quarter_turn() {
    // A table whose both axes meet in the origin, A = 90 degrees in conventional sense: the tool
    // approaches along -Y of the part, as a head turned by +90 degrees about X would.
    let machine =
        build(&toml::from_str("kind = \"trunnion-ac\"\nrotation_point_mm = [0, 0, 0]").unwrap())
            .unwrap();
    let mut program = Coords::xyz(1.0, 2.0, 3.0);
    program[AxisId::A] = std::f64::consts::FRAC_PI_2;
    let joints = machine.inverse(&program, &[0.0, 0.0, 100.0]).unwrap();
    assert!(
        (joints
            - Coords([
                1.0,
                3.0,
                -2.0 + 100.0,
                program[AxisId::A],
                0.0,
                0.0,
                0.0,
                0.0,
                0.0
            ]))
        .0
        .iter()
        .all(|d| d.abs() < 1e-13)
    );
    let pose = machine.tool_pose(&joints, &[0.0, 0.0, 100.0]);
    assert!((pose.axis[1] + 1.0).abs() < 1e-15);
}

#[test]
fn the_tool_axis_is_the_way_from_tip_to_spindle() {
    // Seen from the part, the tip of a longer tool lies further along the axis by the difference.
    for described in machines()
        .into_iter()
        .filter(|m| m.build().chain().is_some())
    {
        let machine = described.build();
        let joints = Coords([0.5, 0.6, 0.7, 0.4, -0.7, 1.9, 0.0, 0.0, 0.0]);
        let (long, short) = (
            machine.tool_pose(&joints, &[0.0, 0.0, 80.0]),
            machine.tool_pose(&joints, &[0.0, 0.0, 30.0]),
        );
        for i in 0..3 {
            assert!(
                (short.tip[i] - long.tip[i] - 50.0 * short.axis[i]).abs() < 1e-11,
                "{}",
                described.name
            );
        }
    }
}

#[test]
fn a_scara_stretched_along_x() {
    let machine = build(
        &toml::from_str("kind = \"scara\"\nupper_arm_mm = 300.0\nforearm_mm = 400.0").unwrap(),
    )
    .unwrap();
    // 3-4-5: with the tool 500 mm out the elbow is square.
    let joints = machine
        .inverse(&Coords::xyz(500.0, 0.0, 20.0), &[0.0; 3])
        .unwrap();
    assert!((joints[AxisId::B] - std::f64::consts::FRAC_PI_2).abs() < 1e-14);
    assert!((math::tan(-joints[AxisId::A]) - 4.0 / 3.0).abs() < 1e-14);
    assert!(
        machine
            .inverse(&Coords::xyz(701.0, 0.0, 0.0), &[0.0; 3])
            .unwrap_err()
            .to_string()
            .contains("from 100 to 700 mm")
    );
}

#[test]
fn a_delta_in_its_middle() {
    let machine = build(
        &toml::from_str("kind = \"delta\"\ntower_radius_mm = 150.0\nrod_mm = 250.0").unwrap(),
    )
    .unwrap();
    let joints = machine
        .inverse(&Coords::xyz(0.0, 0.0, 7.0), &[0.0; 3])
        .unwrap();
    assert!(
        joints.linear().iter().all(|h| (h - 207.0).abs() < 1e-12),
        "{joints:?}"
    );
    assert!(
        machine
            .inverse(&Coords::xyz(140.0, 0.0, 0.0), &[0.0; 3])
            .is_err()
    );
}

/// What is wrong with a description: with its keys, or with its measures.
fn message(text: &str) -> String {
    match toml::from_str(text) {
        Ok(spec) => build(&spec).unwrap_err().to_string(),
        Err(error) => error.to_string(),
    }
}

/// Unknown kinds are told by name, with those that there are.
struct Never;

impl KindVisitor for Never {
    type Output = ();

    fn visit<S: KindSpec>(self) {
        panic!("{} is no hexapod", S::SUMMARY);
    }
}

#[test]
fn descriptions_are_checked() {
    let joint = |axis: &str, rest: &str| format!("[[joint]]\naxis = \"{axis}\"\n{rest}\n");
    let linear = |axis: &str, direction: &str| {
        joint(axis, &format!("type = \"linear\"\ndirection = {direction}"))
    };
    let xyz = [
        linear("x", "[1, 0, 0]"),
        linear("y", "[0, 1, 0]"),
        linear("z", "[0, 0, 1]"),
    ]
    .concat();
    let chain = |rest: &str| message(&format!("kind = \"chain\"\n{rest}"));
    assert!(
        KinematicsSpec::visit_kind("hexapod", Never)
            .unwrap_err()
            .to_string()
            .contains(
                "there is no such kind; known are cartesian, trunnion-ac, trunnion-bc, chain"
            )
    );
    assert!(
        message("kind = \"hexapod\"").contains(
            "unknown variant `hexapod`, expected one of `cartesian`, `trunnion-ac`, `trunnion-bc`, `chain`"
        )
    );
    assert!(
        message("kind = \"cartesian\"\noffset_y_mm = 1.0")
            .contains("unknown field `offset_y_mm`, there are no fields")
    );
    assert!(
        message("kind = \"trunnion-ac\"\noffset_x_mm = 1.0").contains(
            "unknown field `offset_x_mm`, expected one of `rotation_point_mm`, `offset_y_mm`"
        )
    );
    assert!(message("kind = \"trunnion-ac\"").contains("missing field `rotation_point_mm`"));
    assert!(
        message("kind = \"trunnion-bc\"\nrotation_point_mm = [0, 0, nan]")
            .contains("`rotation_point_mm` is NaN")
    );
    assert!(chain("").contains("linear joint `x` is missing"));
    assert!(
        chain(&format!("{xyz}{}", linear("x", "[1, 0, 0]")))
            .contains("axis X moves a joint already")
    );
    assert!(
        chain(
            &[
                linear("x", "[1, 0, 0]"),
                linear("y", "[1, 0, 0]"),
                linear("z", "[0, 0, 1]")
            ]
            .concat()
        )
        .contains("lie in a plane")
    );
    assert!(
        chain(&format!(
            "{xyz}{}",
            joint(
                "c",
                "type = \"rotary\"\nside = \"head\"\ndirection = [0, 0, 1]"
            )
        ))
        .contains("needs `point_mm`")
    );
    assert!(
        chain(&format!(
            "{xyz}{}",
            joint(
                "c",
                "type = \"rotary\"\npoint_mm = [0, 0, 0]\ndirection = [0, 0, 1]"
            )
        ))
        .contains("needs `side`")
    );
    assert!(
        chain(&format!(
            "{xyz}{}",
            joint(
                "c",
                "type = \"rotary\"\nside = \"table\"\npoint_mm = [0, 0, 0]\ndirection = [0, 0, 1]"
            )
        ))
        .contains("from the workpiece to the tool")
    );
    assert!(chain(&linear("x", "[0, 0, 0]")).contains("`direction` has to have a length"));
    assert!(
        chain(&joint(
            "x",
            "type = \"linear\"\ndirection = [1, 0, 0]\nsign = 2.0"
        ))
        .contains("has to be 1 or -1")
    );
    assert!(
        message("kind = \"delta\"\ntower_radius_mm = 200.0\nrod_mm = 150.0")
            .contains("longer than")
    );
    assert!(
        message("kind = \"delta\"\ntower_radius_mm = 100.0\nrod_mm = 150.0\ntower_angles_deg = [0.0, 180.0, 0.1]").contains("in a line")
    );
    assert!(message("kind = \"scara\"").contains("missing field `upper_arm_mm`"));
    assert!(toml::from_str::<KinematicsSpec>("kind = \"cartesian\"\noffset_y = 1.0").is_err());
    for described in machines() {
        assert_eq!(
            toml::from_str::<KinematicsSpec>(&toml::to_string(&described.spec).unwrap()).unwrap(),
            described.spec
        );
    }
}

#[test]
fn an_arm_out_of_reach_or_travel_says_so() {
    for name in ["arm, spherical wrist", "arm, offset wrist (numeric)"] {
        let described = machines().into_iter().find(|m| m.name == name).unwrap();
        let far = described
            .build()
            .inverse(&Coords::xyz(5000.0, 0.0, 0.0), &[0.0; 3])
            .unwrap_err();
        assert!(far.to_string().contains("cannot reach"), "{far}");
    }
    let described = machines()
        .into_iter()
        .find(|m| m.name.contains("numeric"))
        .unwrap();
    let mut reach = lostmotion_kinematics::Reach::default();
    reach.0[0] = Some((-0.1, 0.1));
    let machine = lostmotion_kinematics::build_within(&described.spec, &reach).unwrap();
    let joints = Coords([0.3, -0.3, 0.5, 0.2, 0.7, 0.3, 0.0, 0.0, 0.0]);
    let refused = machine
        .inverse(&machine.forward(&joints, &[0.0; 3]), &[0.0; 3])
        .unwrap_err();
    assert!(
        refused
            .to_string()
            .contains("joint X would stand at 0.3000, outside -0.1000 to 0.1000"),
        "{refused}"
    );
}
