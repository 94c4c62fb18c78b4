//! A tenth of a second of one axis in its closed loop, its plant stepped by the library and by a
//! general-purpose solver with location of events.
//!
//! Spline, drive and inputs are the same; the solver's tolerances and the load's deviation from the
//! library's are printed with both times and the ratio. Elements are CNC periods.

#![allow(
    clippy::expect_used,
    clippy::unwrap_used,
    clippy::panic,
    reason = "a bench says what went wrong by panicking"
)]

#[path = "../tests/it/hybrid/mod.rs"]
mod hybrid;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use hybrid::{Machine, Method, Phase};
use lostmotion_base::math;
use lostmotion_drive::Correction;
use lostmotion_drive::Setpoint;
use lostmotion_drive::config::{FrictionLaw, Frictions, Load, Lugre, Stribeck};
use lostmotion_drive::plant::{Plant, PlantInput, PlantParams, PlantState};
use lostmotion_drive::reference::Spline;
use lostmotion_drive::servo::Servo;
use lostmotion_methods::AxisConfig;
use std::time::Instant;

const TICKS: u32 = 100;
const SAMPLES: u32 = 4;

/// What takes a period of the current loop.
trait Stepper {
    fn step(&mut self, state: &mut PlantState, input: &PlantInput);
}

impl Stepper for &Plant {
    fn step(&mut self, state: &mut PlantState, input: &PlantInput) {
        Plant::step(self, state, input);
    }
}

/// The plant's equations under a general-purpose solver.
struct Solver {
    machine: Machine,
    phase: Phase,
    method: Method,
}

impl Stepper for Solver {
    fn step(&mut self, state: &mut PlantState, input: &PlantInput) {
        let p = &self.machine.p;
        // i_d as the library has it: an exponential of its own, coupled with values at the period's
        // start
        let cross = p.pole_pairs * state.motor_velocity * p.inductance_h;
        let decay = math::exp(-p.resistance_ohm / p.inductance_h * p.period_s);
        self.machine.voltage = input.voltage_q - cross * state.current_d;
        state.current_d = decay * state.current_d
            + (1.0 - decay) / p.resistance_ohm * (input.voltage_d + cross * state.current_q);
        self.machine.extra = input.load_torque;
        self.machine
            .advance(&mut self.phase, p.period_s, self.method);
        let [current, motor, load, motor_velocity, load_velocity, ..] = self.phase.y;
        (state.current_q, state.gap_angle, state.load_position) = (current, motor - load, load);
        (state.motor_velocity, state.load_velocity) = (motor_velocity, load_velocity);
    }
}

/// The axis' load at each servo tick, rad at the motor's shaft.
fn run(config: &AxisConfig, start: PlantState, stepper: &mut dyn Stepper) -> Vec<f64> {
    let (spline, servo) = (Spline::new(config), Servo::new(config));
    let mut state = start;
    let (mut reference, mut drive) = (spline.initial(0.0), servo.initial(&state, 0.0));
    let mut loads = Vec::new();
    for tick in 0..TICKS {
        let rate = 40.0;
        let (sin, cos) = math::sin_cos(rate * f64::from(tick) * 1e-3);
        spline
            .push(
                &mut reference,
                &Setpoint::moving(1.0 - cos, rate * sin, rate * rate * cos),
            )
            .expect("finite");
        for index in 0..SAMPLES {
            let (now, next) = (
                spline.at(&reference, index, SAMPLES),
                spline.at(&reference, index + 1, SAMPLES),
            );
            let measured = servo.measure(&mut drive, &state);
            loads.push(state.load_position);
            servo.command(&mut drive, &now, &next, &measured, &Correction::NONE);
            for _ in 0..servo.current_steps() {
                let input = servo.voltage(&mut drive, &state);
                stepper.step(&mut state, &input);
            }
        }
    }
    loads
}

/// The paper's axis with friction at both masses and a gap of 0.01 rad.
fn axis(friction: Frictions) -> AxisConfig {
    let mut config = AxisConfig {
        friction,
        ..AxisConfig::paper()
    };
    config.motor.coulomb_nm = 0.1;
    if let Load::Reflected(load) = &mut config.load {
        (load.coulomb_nm, load.gap_rad) = (0.5, 0.01);
    }
    config.check().expect("a good axis");
    config
}

fn best_of(rounds: u32, mut work: impl FnMut()) -> f64 {
    let once = |work: &mut dyn FnMut()| {
        let start = Instant::now();
        work();
        start.elapsed().as_secs_f64()
    };
    (0..rounds)
        .map(|_| once(&mut work))
        .fold(f64::INFINITY, f64::min)
}

fn solver(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("solver");
    group
        .throughput(Throughput::Elements(u64::from(TICKS)))
        .sample_size(10);
    let stribeck = FrictionLaw::Stribeck(Stribeck {
        static_factor: 1.4,
        speed_units_s: 1.0,
    });
    let lugre = FrictionLaw::Lugre(Lugre {
        static_factor: 1.4,
        speed_units_s: 1.0,
        presliding_units: 2e-3,
        damping_s: 1e-3,
    });
    let laws = [
        ("coulomb", FrictionLaw::Coulomb),
        ("stribeck", stribeck),
        ("lugre", lugre),
    ];
    for (name, law) in laws {
        let config = axis(Frictions {
            motor: FrictionLaw::Coulomb,
            load: law,
        });
        let params = PlantParams::new(&config);
        let (plant, start) = (Plant::new(&params), PlantState::at_rest(&params, 0.0, 0.0));
        let with = |method: Method| {
            let machine = Machine {
                p: params,
                voltage: 0.0,
                extra: 0.0,
            };
            run(
                &config,
                start,
                &mut Solver {
                    machine,
                    phase: Phase::of(&params, &start),
                    method,
                },
            )
        };
        let ours = run(&config, start, &mut &plant);
        let own = best_of(20, || drop(run(&config, start, &mut &plant)));
        for (kind, method) in [
            ("explicit", Method::Explicit(1e-7)),
            ("implicit", Method::Radau(1e-8)),
        ] {
            let theirs = with(method);
            let apart = ours
                .iter()
                .zip(&theirs)
                .fold(0.0, |most: f64, (a, b)| most.max((a - b).abs()))
                / 0.01;
            let other = best_of(3, || drop(with(method)));
            println!(
                "{name}, {kind} solver: {apart:.1e} of the gap apart; {:.0} times slower than the library",
                other / own
            );
        }
        group.bench_function(format!("{name} library"), |bencher| {
            bencher.iter(|| run(&config, start, &mut &plant));
        });
        group.bench_function(format!("{name} explicit"), |bencher| {
            bencher.iter(|| with(Method::Explicit(1e-7)));
        });
    }
    group.finish();
}

criterion_group!(benches, solver);
criterion_main!(benches);
