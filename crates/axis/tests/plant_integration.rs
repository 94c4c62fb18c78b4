//! The plant against a fourth-order Runge-Kutta integration of the bare equations, with its own event logic, on random axes.
#![allow(clippy::unwrap_used, clippy::panic, reason = "tests")]

use lostmotion_axis::config::{AxisConfig, ContactLaw};
use lostmotion_axis::plant::{Plant, PlantInput, PlantParams, PlantState};
use proptest::prelude::*;

/// Steps of the integration per period: at most a few hundredths of a rad of the fastest oscillation each.
const SUBSTEPS: usize = 40;

#[derive(Clone, Copy, Debug)]
struct Other {
    /// i, theta_M, theta_L, w_M, w_L
    x: [f64; 5],
    /// Sliding direction of motor and load; 0 is stuck.
    slide: [f64; 2],
    side: f64,
}

struct Bench {
    p: PlantParams,
    voltage: f64,
    extra: f64,
}

impl Bench {
    fn contact(&self, o: &Other, x: &[f64; 5]) -> f64 {
        let p = &self.p;
        if p.half_gap_rad == 0.0 {
            return p.stiffness_nm_per_rad * (x[1] - x[2]) + p.damping_nm_s_per_rad * (x[3] - x[4]);
        }
        if o.side == 0.0 {
            return 0.0;
        }
        let spring = p.stiffness_nm_per_rad * (x[1] - x[2] - o.side * p.half_gap_rad);
        let damper = p.damping_nm_s_per_rad * (x[3] - x[4]);
        match p.contact {
            ContactLaw::Linear => spring + damper,
            ContactLaw::Clamped => o.side * (o.side * (spring + damper)).max(0.0),
            ContactLaw::Bounded => spring + damper.clamp(-spring.abs(), spring.abs()),
        }
    }

    /// Which piece of a piecewise linear contact law holds.
    fn piece(&self, o: &Other, x: &[f64; 5]) -> (bool, bool) {
        let p = &self.p;
        let spring = o.side * p.stiffness_nm_per_rad * (x[1] - x[2] - o.side * p.half_gap_rad);
        let damper = o.side * p.damping_nm_s_per_rad * (x[3] - x[4]);
        let engaged = o.side != 0.0;
        (engaged && p.contact != ContactLaw::Linear && damper < -spring, engaged && p.contact == ContactLaw::Bounded && damper > spring)
    }

    fn need(&self, o: &Other, x: &[f64; 5]) -> [f64; 2] {
        let contact = self.contact(o, x);
        [self.p.torque_constant_nm_per_a * x[0] - contact, contact - self.extra - self.p.load_constant_nm]
    }

    fn derivative(&self, o: &Other, x: &[f64; 5]) -> [f64; 5] {
        let p = &self.p;
        let need = self.need(o, x);
        let motor = need[0] - p.motor_viscous_nm_s_per_rad * x[3] - o.slide[0] * p.motor_coulomb_nm;
        let load = need[1] - p.load_viscous_nm_s_per_rad * x[4] - o.slide[1] * p.load_coulomb_nm;
        [
            (self.voltage - p.resistance_ohm * x[0] - p.back_emf_v_s_per_rad * x[3]) / p.inductance_h,
            x[3],
            x[4],
            if p.motor_coulomb_nm > 0.0 && o.slide[0] == 0.0 { 0.0 } else { motor / p.motor_inertia_kgm2 },
            if p.load_coulomb_nm > 0.0 && o.slide[1] == 0.0 { 0.0 } else { load / p.load_inertia_kgm2 },
        ]
    }

    fn runge_kutta(&self, o: &Other, h: f64) -> [f64; 5] {
        let at = |k: &[f64; 5], f: f64| std::array::from_fn(|i| o.x[i] + f * k[i]);
        let k1 = self.derivative(o, &o.x);
        let k2 = self.derivative(o, &at(&k1, 0.5 * h));
        let k3 = self.derivative(o, &at(&k2, 0.5 * h));
        let k4 = self.derivative(o, &at(&k3, h));
        std::array::from_fn(|i| o.x[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]))
    }

    /// Whether the discrete state still holds at `x`: which part does not, 1 contact, 2 motor, 3 load, 4 piece of the law; 0 if all is well.
    fn broken(&self, o: &Other, x: &[f64; 5]) -> u8 {
        let (p, angle) = (&self.p, x[1] - x[2]);
        if p.half_gap_rad > 0.0 && (if o.side == 0.0 { angle.abs() > p.half_gap_rad } else { o.side * angle < p.half_gap_rad }) {
            return 1;
        }
        if self.piece(o, x) != self.piece(o, &o.x) {
            return 4;
        }
        let need = self.need(o, x);
        for (mass, limit) in [p.motor_coulomb_nm, p.load_coulomb_nm].into_iter().enumerate() {
            let gone = if o.slide[mass] == 0.0 { need[mass].abs() > limit } else { o.slide[mass] * x[3 + mass] < 0.0 };
            if limit > 0.0 && gone {
                return 2 + mass as u8;
            }
        }
        0
    }

    fn advance(&self, o: &mut Other, mut h: f64) {
        for _ in 0..60 {
            let end = self.runge_kutta(o, h);
            if self.broken(o, &end) == 0 {
                o.x = end;
                return;
            }
            let (mut low, mut high) = (0.0, h);
            for _ in 0..80 {
                let middle = 0.5 * (low + high);
                if self.broken(o, &self.runge_kutta(o, middle)) == 0 { low = middle } else { high = middle }
            }
            let end = self.runge_kutta(o, high);
            let broken = self.broken(o, &end);
            o.x = end;
            match broken {
                1 => o.side = if o.side == 0.0 { (o.x[1] - o.x[2]).signum() } else { 0.0 },
                0 | 4 => {}
                which => {
                    let mass = usize::from(which - 2);
                    let limit = [self.p.motor_coulomb_nm, self.p.load_coulomb_nm][mass];
                    o.x[3 + mass] = 0.0;
                    let need = self.need(o, &o.x)[mass];
                    o.slide[mass] = if need.abs() > limit { need.signum() } else { 0.0 };
                }
            }
            h -= high;
            if h <= 0.0 {
                return;
            }
        }
    }
}

fn axis() -> impl Strategy<Value = (PlantParams, Vec<(f64, f64)>)> {
    let law = prop_oneof![Just(ContactLaw::Linear), Just(ContactLaw::Clamped), Just(ContactLaw::Bounded)];
    let friction = || prop_oneof![Just(0.0), 0.02..0.6_f64];
    let gap = prop_oneof![Just(0.0), 1e-3..0.1_f64];
    let input = prop::collection::vec((-12.0..12.0_f64, -0.5..0.5_f64), 4..10);
    (law, friction(), friction(), gap, 0.0..0.02_f64, 500.0..20000.0_f64, 0.05..1.5_f64, 0.5..8.0_f64, input).prop_map(
        |(contact, motor, load, half_gap_rad, viscous, stiffness, damping, ratio, input)| {
            let base = PlantParams::new(&AxisConfig::paper());
            let params = PlantParams {
                contact,
                motor_coulomb_nm: motor,
                load_coulomb_nm: load,
                load_viscous_nm_s_per_rad: viscous,
                half_gap_rad,
                stiffness_nm_per_rad: stiffness,
                damping_nm_s_per_rad: damping,
                load_inertia_kgm2: ratio * base.motor_inertia_kgm2,
                ..base
            };
            (params, input)
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, failure_persistence: None, rng_seed: proptest::test_runner::RngSeed::Fixed(7), ..ProptestConfig::default() })]

    #[test]
    fn exact_steps_agree_with_an_independent_integration((params, input) in axis()) {
        let plant = Plant::new(&params);
        let mut state = PlantState::at_rest(&params, 0.0, 0.0);
        let mut other = Other { x: [0.0; 5], slide: [0.0; 2], side: 0.0 };
        let scale = if params.half_gap_rad > 0.0 { 2.0 * params.half_gap_rad } else { 1e-3 };
        for (voltage, extra) in input {
            for _ in 0..150 {
                plant.step(&mut state, &PlantInput { voltage_d: 0.0, voltage_q: voltage, load_torque: extra });
                // without the cross-coupling of d and q, which the integration does not have
                state.current_d = 0.0;
                let bench = Bench { p: params, voltage, extra };
                for _ in 0..SUBSTEPS {
                    bench.advance(&mut other, params.period_s / SUBSTEPS as f64);
                }
                let error = (state.load_position - other.x[2]).abs().max((state.motor_position() - other.x[1]).abs());
                prop_assert!(error < 1e-8 * scale, "{} of the gap after {} events, {state:?}", error / scale, state.events);
            }
        }
    }

    #[test]
    fn mirrored_input_gives_mirrored_output_to_the_bit((params, input) in axis(), start in -1.0..1.0_f64) {
        let plant = Plant::new(&params);
        let (mut one, mut two) = (PlantState::at_rest(&params, 3.0, start), PlantState::at_rest(&params, -3.0, -start));
        for (voltage, extra) in input {
            for _ in 0..100 {
                plant.step(&mut one, &PlantInput { voltage_d: 0.1, voltage_q: voltage, load_torque: extra });
                plant.step(&mut two, &PlantInput { voltage_d: 0.1, voltage_q: -voltage, load_torque: -extra });
                prop_assert_eq!(one.load_position, -two.load_position);
                prop_assert_eq!(one.gap_angle, -two.gap_angle);
                prop_assert_eq!(one.current_q, -two.current_q);
                prop_assert_eq!(one.current_d, two.current_d);
                prop_assert_eq!(one.events, two.events);
            }
        }
    }
}
