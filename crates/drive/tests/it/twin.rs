//! The twin beside the exact plant.

use lostmotion_base::math;
use lostmotion_drive::config::Load;
use lostmotion_drive::twin::{LoadModel, Twin};
use lostmotion_drive::{AxisOutput, Setpoint};
use lostmotion_methods::{AxisConfig, MethodId, build_runner};

/// The twin's load beside that of the exact plant without a gap: largest difference, and
/// largest lag of the load behind its reference, rad.
fn beside_the_plant(coulomb: f64, feedforward: f64) -> [f64; 2] {
    let mut config = AxisConfig::paper().without_gap();
    config.drive.velocity_feedforward = feedforward;
    config.drive.acceleration_feedforward = feedforward;
    config.motor.coulomb_nm = 0.1;
    if let Load::Reflected(load) = &mut config.load {
        load.coulomb_nm = coulomb;
    }
    let at = |t: f64| {
        let (s, c) = math::sin_cos(6.0 * t);
        Setpoint::moving(2.0 - 2.0 * c, 12.0 * s, 72.0 * c)
    };
    let mut runner = build_runner(&config, MethodId::NONE, 0.0).unwrap();
    let mut out = AxisOutput::new(true);
    let points: Vec<Setpoint> = (0..2000).map(|n| at(f64::from(n) * 1e-3)).collect();
    runner.push(&points, &mut out).unwrap();
    let trace = out.trace.unwrap();
    let (twin, load) = (Twin::new(&config), LoadModel::told(&config));
    let mut state = twin.initial(0.0, &load);
    let (mut off, mut lag) = (0.0_f64, 0.0_f64);
    for pair in trace.windows(2) {
        off = off.max((state.plant.load_position - pair[0].load_position).abs());
        lag = lag.max((pair[0].reference.position - pair[0].load_position).abs());
        twin.step(&mut state, &pair[0].reference, &pair[1].reference, &load);
    }
    [off, lag]
}

#[test]
fn it_moves_as_the_exact_plant_without_a_gap() {
    for (coulomb, feedforward) in [(0.0, 0.0), (0.0, 1.0), (1.1, 0.0), (1.1, 1.0)] {
        let [off, lag] = beside_the_plant(coulomb, feedforward);
        assert!(
            off < 2e-4 && off < 0.06 * lag,
            "{coulomb} {feedforward}: {off} of {lag} rad"
        );
    }
}

/// A drive sums its current for the mean of a servo period. Holding a load that hangs, it carries the
/// same current for as long as it stands, and no sum of all of them.
#[test]
fn its_sum_of_currents_is_of_one_servo_period() {
    let config = AxisConfig::paper().without_gap();
    let mut load = LoadModel::told(&config);
    load.constant = 2.0 * load.coulomb + 0.5;
    let twin = Twin::new(&config);
    let mut state = twin.initial(0.0, &load);
    let stands = lostmotion_drive::Reference::default();
    for ticks in [1, 2000] {
        for _ in 0..ticks {
            twin.step(&mut state, &stands, &stands, &load);
        }
        let kept = serde_json::to_value(state).unwrap();
        let sum = kept["servo"]["current"]["sum"].as_f64().unwrap();
        let held = load.constant / config.motor.torque_constant_nm_per_a;
        let periods = config.servo_period_s() * 1e6 / config.current_period_us();
        assert!(
            (sum - periods * held).abs() < 1e-6 * sum,
            "{sum} A after {ticks}, {periods} of {held}"
        );
    }
}
