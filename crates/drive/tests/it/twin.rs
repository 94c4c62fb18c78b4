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

/// A drive sums its current for the mean of a servo period; a twin, which nobody asks for that, keeps no sum,
/// whether it holds a load that hangs or moves.
#[test]
fn it_keeps_no_sum_of_its_currents() {
    let config = AxisConfig::paper().without_gap();
    let mut load = LoadModel::told(&config);
    load.constant = 2.0 * load.coulomb + 0.5;
    let twin = Twin::new(&config);
    let mut state = twin.initial(0.0, &load);
    for tick in 0..2000_u32 {
        let at = |tick: u32| {
            let t = 250e-6 * f64::from(tick.saturating_sub(1000));
            lostmotion_drive::Reference {
                position: 10.0 * t * t,
                velocity: 20.0 * t,
                ..lostmotion_drive::Reference::default()
            }
        };
        twin.step(&mut state, &at(tick), &at(tick + 1), &load);
        let kept = serde_json::to_value(state).unwrap();
        assert_eq!(kept["servo"]["current"]["sum"].as_f64(), Some(0.0));
    }
}
