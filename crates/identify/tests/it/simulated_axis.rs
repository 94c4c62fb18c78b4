//! The fit on logs of the axis that the library simulates: current loop at 50 us, exact steps, true
//! stick.

use lostmotion_base::math;
use lostmotion_drive::{
    AxisOutput, AxisSample, Setpoint,
    config::{AxisUnit, ContactLaw, Load},
};
use lostmotion_identify::body::{BodyRows, Identified};
use lostmotion_identify::{BacklashFit, BacklashLog, FitSettings, LATENESS_S, fit_backlash};
use lostmotion_methods::{AxisConfig, MethodId, build_runner};

/// Two sines whose periods do not match, so that every reversal is another.
fn setpoints(seconds: f64) -> Vec<Setpoint> {
    let at = |t: f64| {
        let parts = [(3.0, 9.0), (1.1, 23.0)];
        let position = parts.iter().map(|(a, w)| a * math::sin(w * t)).sum();
        let velocity = parts.iter().map(|(a, w)| a * w * math::cos(w * t)).sum();
        let acceleration = parts
            .iter()
            .map(|(a, w)| -a * w * w * math::sin(w * t))
            .sum();
        Setpoint::moving(position, velocity, acceleration)
    };
    (0..(seconds * 1e3) as u32)
        .map(|n| at(f64::from(n) * 1e-3))
        .collect()
}

fn axis(gap: f64, load_friction: f64, motor_friction: f64) -> AxisConfig {
    let mut config = AxisConfig::paper().with_gap(gap);
    config.motor.coulomb_nm = motor_friction;
    config.drive.velocity_feedforward = 1.0;
    if let Load::Reflected(load) = &mut config.load {
        load.coulomb_nm = load_friction;
    }
    config
}

fn fit(config: &AxisConfig, counts: f64) -> BacklashFit {
    let mut out = AxisOutput::new(true);
    build_runner(config, MethodId::NONE, 0.0)
        .unwrap()
        .push(&setpoints(4.0), &mut out)
        .unwrap();
    let mut trace = out.trace.unwrap();
    let step = std::f64::consts::TAU / counts;
    for sample in &mut trace {
        sample.motor_position = (sample.motor_position / step).floor() * step;
        sample.load_position = (sample.load_position / step).floor() * step;
    }
    let log = BacklashLog::from_samples(250e-6, &trace).unwrap();
    fit_backlash(&log, &FitSettings::for_axis(config)).unwrap()
}

#[test]
fn the_simulated_gap_is_found_within_a_tenth_of_a_percent() {
    for gap in [0.2, 12.57e-3, 1.257e-3] {
        for friction in [0.0, 0.22, 1.1, 3.3] {
            let fit = fit(&axis(gap, friction, 0.0), 1_048_576.0);
            let error = 2.0 * fit.half_gap_rad / gap - 1.0;
            assert!(
                error.abs() < 1e-3,
                "gap {gap}, friction {friction}: {error:+.2e}"
            );
            let [low, high] = fit.half_gap_interval_rad;
            assert!(
                low <= 0.5 * gap && 0.5 * gap <= high,
                "gap {gap}, friction {friction}: {low} {high}"
            );
            assert!(
                (fit.compliance_rad_per_nm * 2000.0 - 1.0).abs() < 3e-3,
                "{}",
                fit.compliance_rad_per_nm
            );
        }
    }
}

#[test]
fn the_contact_law_and_the_motor_s_own_friction_do_not_matter() {
    for law in [ContactLaw::Linear, ContactLaw::Clamped, ContactLaw::Bounded] {
        let config = AxisConfig {
            contact: law,
            ..axis(12.57e-3, 1.1, 0.3)
        };
        let fit = fit(&config, 1_048_576.0);
        let error = 2.0 * fit.half_gap_rad / 12.57e-3 - 1.0;
        assert!(error.abs() < 1e-3, "{law:?}: {error:+.2e}");
    }
}

/// One sine, which begins at full speed and so with the log's largest acceleration by far: lost motion is
/// the gap and twice what the load's friction winds up.
#[test]
fn one_sine_without_noise_tells_lost_motion() {
    let (amplitude, friction) = (10.0, 1.1);
    for gap in [12.57e-3, 50e-3] {
        for pace in [1.0, 3.0] {
            let config = axis(gap, friction, 0.0);
            let sine: Vec<_> = (0..(25_000.0 / pace) as u32)
                .map(|n| pace * 1e-3 * f64::from(n))
                .map(|at| {
                    let [place, speed] = [math::sin(at), pace * math::cos(at)];
                    let acceleration = -pace * pace * place;
                    let [place, speed, acceleration] =
                        [place, speed, acceleration].map(|value| amplitude * value);
                    Setpoint::moving(place, speed, acceleration)
                })
                .collect();
            let mut out = AxisOutput::new(true);
            let mut runner = build_runner(&config, MethodId::NONE, 0.0).unwrap();
            runner.push(&sine, &mut out).unwrap();
            let trace = out.trace.unwrap();
            let column = |of: fn(&AxisSample) -> f64| trace.iter().map(of).collect::<Vec<_>>();
            let time: Vec<f64> = (0..trace.len()).map(|row| 250e-6 * row as f64).collect();
            let current = column(|sample| sample.current);
            let rows = BodyRows {
                unit: AxisUnit::Rad,
                time_s: &time,
                motor: &column(|sample| sample.motor_position),
                load: &column(|sample| sample.load_position),
                command: &[],
                drive: &current,
                // What lateness makes of the difference at full speed hides the smaller gaps.
                lateness_s: if gap > 2.0 * LATENESS_S * amplitude * pace {
                    LATENESS_S
                } else {
                    0.0
                },
            };
            for drive in [&current[..], &[]] {
                let found = Identified::of(&BodyRows { drive, ..rows }).unwrap();
                let lost = found.lost_motion.unwrap_or_else(|| {
                    panic!("gap {gap}, pace {pace}: {:?}", found.untold);
                });
                let [low, high] = lost.total.interval;
                let truth = gap + 2.0 * friction / 2000.0;
                assert!(
                    0.98 * low <= truth && truth <= 1.02 * high && high - low < 1.2 * truth,
                    "gap {gap}, pace {pace}: {:?} for {truth}",
                    lost.total
                );
            }
        }
    }
}
