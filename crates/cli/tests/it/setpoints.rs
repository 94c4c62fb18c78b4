//! One axis alone, from the outside: forces on the load over time, what it begins with, its drive
//! off. Held by closed forms and by an integrator of its own.

mod integrator;

use crate::bench::Bench;
use lostmotion::base::math;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// Lead of the screw, m.
const LEAD_M: f64 = 0.01;
/// Inertia of the motor, kg m2.
const INERTIA: f64 = 3e-4;
/// Mass of the load, kg.
const LOAD_KG: f64 = 50.0;
/// Stiffness, N/m, and damping, N s/m, of the shaft.
const STIFFNESS: f64 = 80e6;
const DAMPING: f64 = 4000.0;
/// Torque constant, N m/A.
const TORQUE_CONSTANT: f64 = 0.6;
/// Servo cycle, s.
const TICK_S: f64 = 250e-6;

/// Mass of the motor as the load sees it, kg: its energy at a speed of the screw's nut.
fn motor_kg() -> f64 {
    INERTIA * (TAU / LEAD_M) * (TAU / LEAD_M)
}

/// A slide on a screw.
#[derive(Clone, Copy, Debug)]
struct Slide {
    gap_um: f64,
    law: &'static str,
    /// Coulomb and viscous friction of motor (N m, N m s/rad) and load (N, N s/m).
    motor: [f64; 2],
    load: [f64; 2],
}

/// Without any friction.
const FREE: Slide = Slide {
    gap_um: 0.0,
    law: "linear",
    motor: [0.0; 2],
    load: [0.0; 2],
};

impl Slide {
    fn toml(&self) -> String {
        let Slide {
            gap_um,
            law,
            motor: [motor_coulomb, motor_viscous],
            load: [load_coulomb, load_viscous],
        } = self;
        format!(
            "contact = \"{law}\"\n\
             [transmission.linear]\nlead_mm = {}\n\
             [motor]\nresistance_ohm = 1.6\ninductance_h = 0.008\npoles = 8\n\
             inertia_kgm2 = {INERTIA}\ntorque_constant_nm_per_a = {TORQUE_CONSTANT}\n\
             rated_torque_nm = 4.0\nviscous_nm_s_per_rad = {motor_viscous}\n\
             coulomb_nm = {motor_coulomb}\n\
             [load.slide]\nmass_kg = {LOAD_KG}\nviscous_n_s_per_m = {load_viscous}\n\
             coulomb_n = {load_coulomb}\nstiffness_n_per_um = {}\n\
             damping_n_s_per_mm = {}\ngap_um = {gap_um}\n\
             [drive]\ncurrent_gain_v_per_a = 20.0\ncurrent_time_s = 0.005\n\
             velocity_gain_a_s_per_rad = 0.4\nvelocity_time_s = 0.01\n\
             position_gain_per_s = 40.0\ncurrent_limit_a = 17.0\nbus_voltage_v = 560.0\n",
            1e3 * LEAD_M,
            1e-6 * STIFFNESS,
            1e-3 * DAMPING
        )
    }
}

/// A trace, column by column.
struct Trace(HashMap<String, Vec<f64>>);

impl Trace {
    fn column(&self, name: &str) -> &[f64] {
        self.0
            .get(name)
            .unwrap_or_else(|| panic!("no column {name}"))
    }

    /// Rows of several columns.
    fn rows<const N: usize>(&self, names: [&str; N]) -> Vec<[f64; N]> {
        let columns = names.map(|name| self.column(name));
        (0..columns[0].len())
            .map(|row| columns.map(|column| column[row]))
            .collect()
    }

    /// Motor and load, m and m/s, and the force of the shaft, N.
    fn masses(&self) -> Vec<Masses> {
        self.rows([
            "motor_mm",
            "load_mm",
            "motor_velocity_mm_s",
            "load_velocity_mm_s",
            "shaft_force_n",
        ])
        .into_iter()
        .map(|[xm, xl, vm, vl, force]| Masses {
            x: [1e-3 * xm, 1e-3 * xl],
            v: [1e-3 * vm, 1e-3 * vl],
            force,
        })
        .collect()
    }
}

#[derive(Clone, Copy, Debug)]
struct Masses {
    x: [f64; 2],
    v: [f64; 2],
    force: f64,
}

impl Masses {
    fn lead(&self) -> f64 {
        self.x[0] - self.x[1]
    }

    fn momentum(&self) -> f64 {
        motor_kg() * self.v[0] + LOAD_KG * self.v[1]
    }

    /// Kinetic energy of both and that of the shaft past the flanks of a gap, J.
    fn energy(&self, gap_um: f64) -> f64 {
        let wound = (self.lead().abs() - 0.5e-6 * gap_um).max(0.0);
        0.5 * (motor_kg() * self.v[0] * self.v[0]
            + LOAD_KG * self.v[1] * self.v[1]
            + STIFFNESS * wound * wound)
    }
}

/// Runs the slide on a position that stands at 0, with a force over time (by the row's number), and
/// more arguments.
fn run(slide: &Slide, rows: usize, force: impl Fn(usize) -> f64, more: &[&str]) -> Trace {
    let bench = Bench::new();
    let mut table = String::from("t_s,position_mm,load_force_n\n");
    for row in 0..rows {
        table.push_str(&format!("{:.3},0,{:e}\n", row as f64 * 1e-3, force(row)));
    }
    bench.file("axis.toml", slide.toml()).file("in.csv", table);
    let fixed = [
        "axis",
        "run",
        "--axis",
        "axis.toml",
        "--setpoints",
        "in.csv",
        "-q",
        "-o",
        "out.csv",
    ];
    bench.expect(0, &[&fixed[..], more].concat());
    read(&std::fs::read_to_string(bench.path("out.csv")).unwrap())
}

fn read(text: &str) -> Trace {
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut columns: Vec<Vec<f64>> = names.iter().map(|_| Vec::new()).collect();
    for line in lines {
        for (column, cell) in columns.iter_mut().zip(line.split(',')) {
            column.push(cell.parse().unwrap_or(f64::NAN));
        }
    }
    Trace(names.iter().map(ToString::to_string).zip(columns).collect())
}

/// Natural frequency, rad/s, and damping ratio of the two masses on the shaft.
fn shaft() -> (f64, f64) {
    let reduced = motor_kg() * LOAD_KG / (motor_kg() + LOAD_KG);
    let omega = (STIFFNESS / reduced).sqrt();
    (omega, DAMPING / (2.0 * reduced * omega))
}

/// Let go with 20 um of wind-up: both ends swing against each other with the frequency and the
/// damping of the textbook, their centre of mass stands, and no current flows.
#[test]
fn a_shaft_that_is_let_go_swings_as_two_masses_do() {
    let trace = run(
        &FREE,
        40,
        |_| 0.0,
        &["--drive-off", "--start", "wind_up_um=20"],
    );
    let (omega, zeta) = shaft();
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    for (tick, at) in trace.masses().iter().enumerate() {
        let t = tick as f64 * TICK_S;
        let (fade, angle) = (math::exp(-zeta * omega * t), damped * t);
        let (sine, cosine) = math::sin_cos(angle);
        let lead = 20e-6 * fade * (cosine + zeta * omega / damped * sine);
        let faster = -20e-6 * fade * omega * omega / damped * sine;
        assert!((at.lead() - lead).abs() < 1e-14, "{t}: {}", at.lead());
        assert!((at.v[0] - at.v[1] - faster).abs() < 1e-11, "{t}");
        let force = STIFFNESS * lead + DAMPING * faster;
        assert!((at.force - force).abs() < 1e-6, "{t}: {} N", at.force);
        assert!(at.momentum().abs() < 1e-9, "{t}: {}", at.momentum());
    }
    assert!(trace.masses().len() == 160 && trace.column("current_a").iter().all(|i| *i == 0.0));
}

/// Thrown apart by hand, without friction: momentum is kept through every impact, and energy never
/// grows, whatever the law of the contact is.
#[test]
fn momentum_is_kept_and_energy_never_grows() {
    for law in ["linear", "clamped", "bounded"] {
        let slide = Slide {
            gap_um: 30.0,
            law,
            ..FREE
        };
        let start = "motor_velocity_mm_s=12.5,load_velocity_mm_s=-20,in_gap=0.4";
        let trace = run(&slide, 200, |_| 0.0, &["--drive-off", "--start", start]);
        let masses = trace.masses();
        let first = masses[0];
        assert!((first.v[0] - 0.0125).abs() < 1e-12 && (first.v[1] + 0.02).abs() < 1e-12);
        // In half gaps: the motor leads the load by 0.4 of 15 um.
        assert!((first.lead() - 6e-6).abs() < 1e-14, "{}", first.lead());
        let mut impacts = 0;
        for pair in masses.windows(2) {
            assert!(
                (pair[1].momentum() - first.momentum()).abs() < 1e-9,
                "{law}"
            );
            let (before, after) = (pair[0].energy(30.0), pair[1].energy(30.0));
            assert!(after <= before * (1.0 + 1e-9), "{law}: {before} to {after}");
            impacts += u32::from(before - after > 1e-6 * first.energy(30.0));
        }
        assert!(impacts > 5, "{law}: {impacts}");
        let drag = Slide {
            motor: [0.05, 1e-4],
            load: [40.0, 100.0],
            ..slide
        };
        let masses = run(&drag, 200, |_| 0.0, &["--drive-off", "--start", start]).masses();
        for pair in masses.windows(2) {
            assert!(pair[1].energy(30.0) <= pair[0].energy(30.0) * (1.0 + 1e-9));
        }
        let last = masses[masses.len() - 1];
        assert!(last.v.iter().all(|v| v.abs() < 1e-12), "{law}: {last:?}");
    }
}

/// A motor that runs into a resting load across half the gap: with a linear contact it is half a
/// swing, after which they part at `exp(-pi zeta/sqrt(1 - zeta^2))` of the speed at which they met.
#[test]
fn an_impact_gives_back_what_half_a_swing_leaves() {
    let slide = Slide {
        gap_um: 40.0,
        ..FREE
    };
    let masses = run(
        &slide,
        30,
        |_| 0.0,
        &["--drive-off", "--start", "motor_velocity_mm_s=8"],
    );
    let engagement = masses.column("engagement");
    let masses = masses.masses();
    let (omega, zeta) = shaft();
    let damped = omega * (1.0 - zeta * zeta).sqrt();
    let restitution = math::exp(-PI * zeta / (1.0 - zeta * zeta).sqrt());
    // 20 um at 8 mm/s, then half a swing.
    let (meet, part) = (0.0025, 0.0025 + PI / damped);
    let total = motor_kg() + LOAD_KG;
    let mean = motor_kg() * 0.008 / total;
    let after = [
        mean - LOAD_KG / total * restitution * 0.008,
        mean + motor_kg() / total * restitution * 0.008,
    ];
    // The next flank is the gap's 40 um away.
    let again = part + 40e-6 / (restitution * 0.008);
    let mut flights = [0, 0];
    for (tick, at) in masses.iter().enumerate() {
        let t = tick as f64 * TICK_S;
        if t < meet - 1e-9 {
            assert!((at.v[0] - 0.008).abs() < 1e-12 && at.v[1] == 0.0 && engagement[tick] == 0.0);
            assert!((at.x[0] - 0.008 * t).abs() < 1e-14);
            flights[0] += 1;
        } else if t > part + 1e-9 && t < again - 1e-9 {
            for (v, expected) in at.v.iter().zip(after) {
                assert!((v - expected).abs() < 1e-11, "{t}: {v} for {expected}");
            }
            assert!(engagement[tick] == 0.0 && at.force == 0.0);
            // Where they are tells when they parted.
            let lead = 20e-6 - restitution * 0.008 * (t - part);
            assert!((at.lead() - lead).abs() < 1e-13, "{t}: {}", at.lead());
            flights[1] += 1;
        } else if t > meet + 1e-9 && t < part - 1e-9 {
            let since = t - meet;
            let depth =
                0.008 / damped * math::exp(-zeta * omega * since) * math::sin(damped * since);
            assert!((at.lead() - 20e-6 - depth).abs() < 1e-13, "{t}");
            assert!(engagement[tick] == 1.0);
        }
    }
    assert!(flights[0] == 10 && flights[1] > 10, "{flights:?}");
}

/// F/m: a load in its gap goes alone, then both go as one mass. The force counts against the
/// positive direction and is held from its row to the next.
#[test]
fn a_force_accelerates_what_it_acts_on() {
    let slide = Slide {
        gap_um: 40.0,
        ..FREE
    };
    // 10 N push the load in the positive direction from the third row on, for two rows.
    let pulse = |row: usize| if (2..4).contains(&row) { -10.0 } else { 0.0 };
    let masses = run(&slide, 12, pulse, &["--drive-off"]).masses();
    for (tick, at) in masses.iter().enumerate() {
        let t = tick as f64 * TICK_S;
        let (pushed, free) = ((t - 2e-3).clamp(0.0, 2e-3), (t - 4e-3).max(0.0));
        let acceleration = 10.0 / LOAD_KG;
        let way = 0.5 * acceleration * pushed * pushed + acceleration * pushed * free;
        assert!((at.v[1] - acceleration * pushed).abs() < 1e-12, "{t}");
        assert!((at.x[1] - way).abs() < 1e-14, "{t}: {}", at.x[1]);
        assert!(at.v[0] == 0.0 && at.force == 0.0);
    }
    let both = run(&FREE, 100, |_| 25.0, &["--drive-off"]).masses();
    let total = motor_kg() + LOAD_KG;
    for (tick, at) in both.iter().enumerate() {
        let t = tick as f64 * TICK_S;
        let centre = (motor_kg() * at.x[0] + LOAD_KG * at.x[1]) / total;
        assert!((centre + 0.5 * 25.0 / total * t * t).abs() < 1e-12, "{t}");
        assert!((at.momentum() + 25.0 * t).abs() < 1e-9, "{t}");
    }
}

/// A force that steps up against a motor held by its drive: in the end the load gives way by F/k,
/// and half the gap, and the current carries F at the screw.
#[test]
fn a_step_of_force_deflects_by_the_stiffness() {
    for gap_um in [0.0, 24.0] {
        let slide = Slide {
            gap_um,
            load: [0.0, 2000.0],
            ..FREE
        };
        let step = |row: usize| if row < 50 { 0.0 } else { 400.0 };
        let trace = run(&slide, 1500, step, &[]);
        let masses = trace.masses();
        assert!(masses[199].x == [0.0; 2] || masses[199].lead().abs() < 1e-15);
        let last = masses[masses.len() - 1];
        assert!(last.x[0].abs() < 1e-10, "{last:?}");
        let deflection = 400.0 / STIFFNESS + 0.5e-6 * gap_um;
        assert!((last.lead() - deflection).abs() < 1e-10, "{last:?}");
        assert!((last.force - 400.0).abs() < 1e-2, "{last:?}");
        let current = trace.column("current_a")[masses.len() - 1];
        let carried = 400.0 * LEAD_M / TAU / TORQUE_CONSTANT;
        assert!((current - carried).abs() < 1e-4 * carried, "{current}");
    }
}

/// Coulomb friction of 100 N: 99 N move nothing at all, 101 N accelerate by 1 N; a load that is
/// thrown is stopped after v^2/(2 F/m).
#[test]
fn friction_holds_what_is_below_it() {
    let slide = Slide {
        gap_um: 60.0,
        load: [100.0, 0.0],
        ..FREE
    };
    let held = run(&slide, 100, |_| 99.0, &["--drive-off"]).masses();
    assert!(held.iter().all(|at| at.x == held[0].x && at.v == [0.0; 2]));
    let moved = run(&slide, 30, |_| 101.0, &["--drive-off"]).masses();
    for (tick, at) in moved.iter().enumerate() {
        let t = tick as f64 * TICK_S;
        assert!((at.v[1] + t / LOAD_KG).abs() < 1e-12, "{t}: {}", at.v[1]);
    }
    let start = ["--drive-off", "--start", "load_velocity_mm_s=4"];
    let thrown = run(&slide, 30, |_| 0.0, &start).masses();
    let stopping = 0.004 * 0.004 / 2.0 / (100.0 / LOAD_KG);
    let last = thrown[thrown.len() - 1];
    assert!((last.x[1] - stopping).abs() < 1e-14 && last.v[1] == 0.0);
}

/// A table: a torque over time, speeds in deg/s, a wind-up in mdeg.
#[test]
fn an_axis_that_turns_takes_torques_and_degrees() {
    let bench = Bench::new();
    let axis = "[transmission.rotary]\nunit = \"deg\"\ngear = 90.0\n\
        [motor]\nresistance_ohm = 1.6\ninductance_h = 0.008\npoles = 8\ninertia_kgm2 = 3e-4\n\
        torque_constant_nm_per_a = 0.6\nrated_torque_nm = 4.0\n\
        [load.table]\ninertia_kgm2 = 2.5\nstiffness_nm_per_rad = 2e6\n\
        damping_nm_s_per_rad = 500.0\ngap_mdeg = 20.0\n\
        [drive]\ncurrent_gain_v_per_a = 20.0\ncurrent_time_s = 0.005\n\
        velocity_gain_a_s_per_rad = 0.4\nvelocity_time_s = 0.01\nposition_gain_per_s = 40.0\n\
        current_limit_a = 17.0\nbus_voltage_v = 560.0\n";
    bench.file("axis.toml", axis).file(
        "in.csv",
        "t_s,position_deg,load_torque_nm\n0,5,-1\n0.001,5,-1\n0.002,5,-1\n0.003,5,-1\n",
    );
    let fixed = [
        "axis",
        "run",
        "--axis",
        "axis.toml",
        "--setpoints",
        "in.csv",
        "-q",
        "--drive-off",
        "-o",
        "out.csv",
    ];
    let read = || read(&std::fs::read_to_string(bench.path("out.csv")).unwrap());
    bench.expect(
        0,
        &[&fixed[..], &["--start", "load_velocity_deg_s=0.5"]].concat(),
    );
    for (tick, v) in read().column("load_velocity_deg_s").iter().enumerate() {
        let expected = 0.5 + (tick as f64 * TICK_S / 2.5).to_degrees();
        assert!((v - expected).abs() < 1e-9, "{v} for {expected}");
    }
    bench.expect(0, &[&fixed[..], &["--start", "wind_up_mdeg=-3"]].concat());
    let trace = read();
    let lead = trace.column("motor_deg")[0] - trace.column("load_deg")[0];
    // Past the negative flank, 10 mdeg from the middle.
    assert!((lead + 0.013).abs() < 1e-11, "{lead}");
    let torque = trace.column("shaft_torque_nm")[0];
    assert!(
        (torque + 2e6 * 0.003_f64.to_radians()).abs() < 1e-5,
        "{torque}"
    );
}

#[test]
fn starts_and_forces_that_do_not_suit_are_refused() {
    let bench = Bench::new();
    bench
        .file("axis.toml", FREE.toml())
        .file("in.csv", "t_s,position_mm\n0,0\n")
        .file("nm.csv", "t_s,position_mm,load_torque_nm\n0,0,1\n")
        .file(
            "two.csv",
            "t_s,position,load_torque_nm,load_force_n\n0,0,1,1\n",
        )
        .file("far.csv", "t_s,position_mm,load_force_n\n0,0,1e8\n");
    let refuses = |table: &str, more: &[&str], texts: &[&str]| {
        let fixed = [
            "axis",
            "run",
            "--axis",
            "axis.toml",
            "-o",
            "o.csv",
            "--setpoints",
            table,
        ];
        bench.refuses(&[&fixed[..], more].concat(), texts);
    };
    let starts: [(&str, &[&str]); 9] = [
        (
            "wind_up_um",
            &[
                "--start wind_up_um: it is not of the form KEY=VALUE",
                "hint: for example",
            ],
        ),
        (
            "wind_up=3",
            &["an axis in mm has no key `wind_up`", "wind_up_um"],
        ),
        (
            "wind_up_mdeg=3",
            &["an axis in mm has no key `wind_up_mdeg`"],
        ),
        ("in_gap=2", &["--start in_gap=2: it has to be from -1 to 1"]),
        ("in_gap=nan", &["`nan` is not a finite number"]),
        ("in_gap=0,in_gap=1", &["--start in_gap=1: it is told twice"]),
        ("in_gap=0,wind_up_um=1", &["keep one of the two"]),
        (
            "motor_velocity_mm_s=1e9",
            &["the motor velocity at the start is 1000000000; it has to be from -15915.49"],
        ),
        (
            "wind_up_um=1e9",
            &["the wind-up at the start is 1000000; it has to be from -10"],
        ),
    ];
    for (start, texts) in starts {
        refuses("in.csv", &["--start", start], texts);
    }
    refuses(
        "nm.csv",
        &[],
        &[
            "is in mm and has no `load_torque_nm`",
            "hint: call the column load_force_n",
        ],
    );
    refuses(
        "two.csv",
        &[],
        &["load_force_n", "load_torque_nm", "the force on the load"],
    );
    refuses("far.csv", &[], &["its load_force is 100000000"]);
    refuses(
        "in.csv",
        &["--drive-off", "--method", "fixed"],
        &["--drive-off", "--method"],
    );
}
