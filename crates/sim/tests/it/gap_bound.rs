//! What is laid to backlash on machines that nobody has tuned for it: gaps of any size, flanks off
//! the middle, worn screws, a swivel axis that leans anywhere. Held by what the gaps can do through
//! kinematics of the test's own.

use lostmotion_base::{Random, math};
use lostmotion_methods::AxisConfig;

use lostmotion_sim::{ContourPoint, Machine, MotorPoint, Observer, Program, Simulation};
use std::fmt::Write;

/// Where the axes of both rotary joints meet, mm.
const CENTRE: [f64; 3] = [0.0, 0.0, -420.0];
/// Axes in the order of the machine: X Y Z B C.
const AXES: [&str; 5] = ["x", "y", "z", "b", "c"];

/// An axis' gap.
#[derive(Clone, Copy, Debug)]
struct Gap {
    /// Total, mm or rad.
    gap: f64,
    /// Middle, in half gaps.
    middle: f64,
    /// How many times wider it is where it is worn most.
    wear: f64,
}

impl Gap {
    /// How far a load with the gap can be from one without: the farther flank, and half the gap
    /// again for what motor and shaft do while one of the two crosses it.
    fn reach(&self) -> f64 {
        0.5 * self.gap * (2.0 + self.middle.abs()) * self.wear.max(1.0)
    }
}

/// A machine with a nutating table whose swivel leans in some direction.
#[derive(Clone, Debug)]
struct Mill {
    swivel: [f64; 3],
    gaps: [Gap; 5],
}

impl Mill {
    fn random(random: &mut Random) -> Mill {
        let lean = random.between(0.3, 1.2);
        let aside = random.between(-0.4, 0.4);
        let raw = [math::sin(aside), math::sin(lean), math::cos(lean)];
        let length = dot(raw, raw).sqrt();
        let gaps = std::array::from_fn(|axis| Gap {
            gap: if axis < 3 {
                1e-3 * random.between(3.0, 60.0)
            } else {
                random.between(0.002, 0.02).to_radians()
            },
            middle: [0.0, -1.0, random.between(-1.0, 1.0)][(3.0 * random.unit()) as usize % 3],
            wear: if random.unit() < 0.5 {
                1.0
            } else {
                random.between(1.2, 2.0)
            },
        });
        Mill {
            swivel: raw.map(|c| c / length),
            gaps,
        }
    }

    fn toml(&self) -> String {
        let mut text = String::from("name = \"leaning\"\n[kinematics]\nkind = \"chain\"\n");
        let joint = |axis: &str, kind: &str, direction: [f64; 3]| {
            let place = if kind == "rotary" {
                format!("side = \"table\"\npoint_mm = {CENTRE:?}\n")
            } else {
                String::new()
            };
            format!(
                "[[kinematics.joint]]\naxis = \"{axis}\"\ntype = \"{kind}\"\n\
                 direction = {direction:?}\n{place}"
            )
        };
        text += &joint("c", "rotary", [0.0, 0.0, 1.0]);
        text += &joint("b", "rotary", self.swivel);
        text += &joint("x", "linear", [1.0, 0.0, 0.0]);
        text += &joint("y", "linear", [0.0, 1.0, 0.0]);
        text += &joint("z", "linear", [0.0, 0.0, 1.0]);
        text += "[work_offset.g54]\nz_mm = -370.0\n";
        for (name, gap) in AXES.into_iter().zip(&self.gaps) {
            let linear = matches!(name, "x" | "y" | "z");
            text += &axis(name, linear, gap);
        }
        text
    }

    /// The tool's tip from the part's zero at joint positions in mm and rad: the head carries the
    /// tool in X, Y and Z, the table turns the part about the swivel and the platter.
    fn tip(&self, joints: [f64; 5]) -> [f64; 3] {
        let [x, y, z, b, c] = joints;
        let mut from_centre = [x - CENTRE[0], y - CENTRE[1], z - CENTRE[2]];
        // Positive rotary motion turns the tool positively as seen from the part.
        from_centre = turned(from_centre, self.swivel, b);
        from_centre = turned(from_centre, [0.0, 0.0, 1.0], c);
        // The part's zero lies 50 mm above the face of the platter.
        [from_centre[0], from_centre[1], from_centre[2] - 50.0]
    }

    /// How far the gaps can move the tip from where it is without them, mm: the farthest corner of
    /// the box of what each axis can be off.
    fn reach(&self, joints: [f64; 5], off: [f64; 5]) -> f64 {
        let step = 1e-6;
        let columns: [[f64; 3]; 5] = std::array::from_fn(|axis| {
            let [ahead, behind] = [step, -step].map(|by| {
                let mut moved = joints;
                moved[axis] += by;
                self.tip(moved)
            });
            less(ahead, behind).map(|c| c / (2.0 * step) * off[axis])
        });
        (0..32_u32)
            .map(|corner| {
                let sum = columns
                    .iter()
                    .enumerate()
                    .fold([0.0; 3], |sum, (axis, column)| {
                        let sign = if corner >> axis & 1 == 1 { 1.0 } else { -1.0 };
                        std::array::from_fn(|i| sum[i] + sign * column[i])
                    });
                dot(sum, sum).sqrt()
            })
            .fold(0.0, f64::max)
    }
}

/// The tables of an axis: a screw of 10 mm or a worm of 90:1.
fn axis(name: &str, linear: bool, gap: &Gap) -> String {
    let mut text = String::new();
    let (limits, load) = if linear {
        (
            "min_mm = -450.0\nmax_mm = 450.0\nvelocity_mm_s = 300.0\n\
             acceleration_mm_s2 = 3000.0\njerk_mm_s3 = 40000.0\n",
            format!(
                "[axis.{name}.transmission.linear]\nlead_mm = 10.0\n[axis.{name}.load.slide]\n\
                 mass_kg = 250.0\nviscous_n_s_per_m = 400.0\ncoulomb_n = 120.0\n\
                 stiffness_n_per_um = 180.0\ndamping_n_s_per_mm = 20.0\ngap_um = {}\n",
                1e3 * gap.gap
            ),
        )
    } else {
        (
            "min_deg = -170.0\nmax_deg = 170.0\nvelocity_deg_s = 60.0\n\
             acceleration_deg_s2 = 400.0\njerk_deg_s3 = 5000.0\n",
            format!(
                "[axis.{name}.transmission.rotary]\ngear = 90.0\nunit = \"deg\"\n\
                 [axis.{name}.load.table]\ninertia_kgm2 = 8.0\nviscous_nm_s_per_rad = 25.0\n\
                 coulomb_nm = 40.0\nstiffness_nm_per_rad = 2.5e6\n\
                 damping_nm_s_per_rad = 450.0\ngap_mdeg = {}\n",
                1e3 * gap.gap.to_degrees()
            ),
        )
    };
    let _ = write!(text, "[axis.{name}.limits]\n{limits}{load}");
    let (at, width) = if linear { (5.0, 60.0) } else { (0.0, 20.0) };
    let _ = writeln!(text, "[axis.{name}.flanks]\nmiddle = {}", gap.middle);
    if gap.wear > 1.0 {
        let _ = writeln!(
            text,
            "wear = {{ factor = {}, at_units = {at}, width_units = {width} }}",
            gap.wear
        );
    }
    let _ = write!(
        text,
        "[axis.{name}.motor]\nresistance_ohm = 0.5\ninductance_h = 0.005\npoles = 8\n\
         inertia_kgm2 = 0.003\ntorque_constant_nm_per_a = 1.0\nrated_torque_nm = 10.0\n\
         coulomb_nm = 0.2\n[axis.{name}.drive]\ncurrent_gain_v_per_a = 12.0\n\
         current_time_s = 0.01\nvelocity_gain_a_s_per_rad = 1.2\nvelocity_time_s = 0.012\n\
         position_gain_per_s = 40.0\nvelocity_feedforward = 1.0\nacceleration_feedforward = 1.0\n\
         current_limit_a = 27.0\nbus_voltage_v = 560.0\n"
    );
    text
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn less(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

/// A vector turned about a unit axis: Rodrigues.
fn turned(v: [f64; 3], axis: [f64; 3], angle: f64) -> [f64; 3] {
    let (sine, cosine) = math::sin_cos(angle);
    let across = [
        axis[1] * v[2] - axis[2] * v[1],
        axis[2] * v[0] - axis[0] * v[2],
        axis[0] * v[1] - axis[1] * v[0],
    ];
    let along = dot(axis, v) * (1.0 - cosine);
    std::array::from_fn(|i| v[i] * cosine + across[i] * sine + axis[i] * along)
}

/// Corners, an arc, rotary moves to and fro, and a stop.
fn program(random: &mut Random) -> String {
    let mut text = String::from("G21 G17 G90 G94 G54 G64 P0.01\nG0 X0 Y0 Z60\n");
    for _ in 0..8 {
        let mut word = |from: f64, to: f64| random.between(from, to);
        let _ = writeln!(
            text,
            "G1 X{:.3} Y{:.3} Z{:.3} B{:.3} C{:.3} F{:.0}",
            word(-15.0, 15.0),
            word(-15.0, 15.0),
            word(45.0, 65.0),
            word(-25.0, 25.0),
            word(-40.0, 40.0),
            word(400.0, 2500.0)
        );
    }
    text.push_str("G4 P0.1\nG3 I6 J0 F1500\nG1 Z50\nM2\n");
    text
}

/// The points of the contour and the loads of all axes, tick by tick.
#[derive(Default)]
struct Seen {
    contour: Vec<ContourPoint>,
    loads: Vec<[f64; 5]>,
}

impl Observer for Seen {
    fn contour(&mut self, _method: usize, points: &[ContourPoint]) {
        self.contour.extend_from_slice(points);
    }

    fn wants_contour(&self) -> bool {
        true
    }

    fn motors(&mut self, _method: usize, points: &[MotorPoint]) {
        for tick in points.chunks(5) {
            self.loads.push(std::array::from_fn(|axis| {
                let load = tick[axis].load;
                if axis < 3 { load } else { load.to_radians() }
            }));
        }
    }

    fn wants_motors(&self) -> bool {
        true
    }
}

fn seen(machine: &Machine, text: &str) -> Seen {
    let mut seen = Seen::default();
    let program = Program::from_str("random.ngc", text);
    Simulation::new(&program, machine)
        .observer(&mut seen)
        .run()
        .unwrap_or_else(|error| panic!("{error}\n{text}"));
    seen
}

/// Without compensation, each axis is off what it is without a gap by at most its gap, and half of it
/// more where positions count from a flank; the tool by what that is through the kinematics.
#[test]
fn no_more_is_laid_to_backlash_than_random_gaps_can_do() {
    let mut random = Random::new(20_261_124);
    let (mut closest, mut farthest): (f64, f64) = (0.0, 0.0);
    for case in 0..12 {
        let mill = Mill::random(&mut random);
        let text = program(&mut random);
        let machine = Machine::from_toml("leaning.toml", &mill.toml())
            .unwrap_or_else(|error| panic!("{error}\n{}", mill.toml()));
        let with_gaps = seen(&machine, &text);
        let without = seen(&machine.map_axes(AxisConfig::without_gap), &text);
        assert_eq!(with_gaps.contour.len(), without.contour.len());
        let ticks = with_gaps.contour.len();
        assert!(with_gaps.loads.len() >= ticks && ticks > 4000, "{ticks}");
        let off = mill.gaps.map(|gap| gap.reach());
        let mut largest: f64 = 0.0;
        for tick in 0..ticks {
            let (point, joints) = (&with_gaps.contour[tick], with_gaps.loads[tick]);
            let ideal = without.loads[tick];
            // The test's kinematics are the machine's.
            let apart = less(mill.tip(joints), point.actual_mm);
            assert!(dot(apart, apart).sqrt() < 1e-6, "case {case}: {apart:?}");
            for axis in 0..5 {
                let by = (joints[axis] - ideal[axis]).abs();
                farthest = farthest.max(by / off[axis]);
                assert!(
                    by <= off[axis],
                    "case {case}, {} s: {} is off by {by:e} of {:e}",
                    point.time_s,
                    AXES[axis],
                    off[axis]
                );
            }
            let size = 1e-3 * point.backlash_um.abs();
            let moved = less(mill.tip(joints), mill.tip(ideal));
            assert!(size <= dot(moved, moved).sqrt() + 1e-7, "case {case}");
            let reach = mill.reach(ideal, off);
            assert!(
                size <= reach + 1e-9,
                "case {case}, {} s: {size} mm of {reach}",
                point.time_s
            );
            largest = largest.max(size);
            closest = closest.max(size / reach);
        }
        assert!(largest > 1e-3, "case {case}: {largest} mm: nothing to hold");
    }
    eprintln!("of the bounds: {farthest:.3} of an axis', {closest:.3} of the tool's");
    assert!(closest > 0.5, "a loose bound: {closest}");
}
