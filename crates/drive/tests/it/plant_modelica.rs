//! The contact beside the backlash components of the Modelica Standard Library
//! (`Modelica.Mechanics.Rotational.Components`), whose documented equations are written out here:
//! with `phi` the angle between the flanges, `b` the total backlash, c and d the spring and the
//! damper,
//! ```text
//! tau_c = c (phi - b/2), tau_d = d der(phi)              for phi > b/2, with the opposite sign of b/2 for phi < -b/2
//! ElastoBacklash2  tau = 0 if tau_c + tau_d <= 0, else tau_c + tau_d
//! ElastoBacklash   tau = 0 if tau_c + tau_d <= 0, else tau_c + min(tau_c, tau_d)
//! ```
//! The first is our clamped contact, the second our bounded one.

use differential_equations::prelude::*;
use lostmotion_drive::config::ContactLaw;
use lostmotion_drive::plant::{Plant, PlantInput, PlantParams, PlantState};
use lostmotion_methods::AxisConfig;

/// Two inertias and a backlash component; states phi_1, phi_2, w_1, w_2.
struct Train {
    inertia: [f64; 2],
    c: f64,
    d: f64,
    b: f64,
    law: ContactLaw,
    torque: [f64; 2],
}

impl Train {
    fn component(&self, phi: f64, speed: f64) -> f64 {
        let half = 0.5 * self.b;
        let sign = if phi > half { 1.0 } else { -1.0 };
        if phi.abs() <= half {
            return 0.0;
        }
        let (tau_c, tau_d) = (sign * self.c * (phi - sign * half), sign * self.d * speed);
        let pushing = if self.law == ContactLaw::Bounded {
            tau_c + f64::min(tau_c, tau_d)
        } else {
            tau_c + tau_d
        };
        if tau_c + tau_d <= 0.0 {
            0.0
        } else {
            sign * pushing
        }
    }
}

impl ODE<f64, [f64; 4]> for Train {
    fn diff(&self, _: f64, y: &[f64; 4], out: &mut [f64; 4]) {
        let tau = self.component(y[0] - y[1], y[2] - y[3]);
        *out = [
            y[2],
            y[3],
            (self.torque[0] - tau) / self.inertia[0],
            (self.torque[1] + tau) / self.inertia[1],
        ];
    }
}

/// Our plant with a motor that has no torque of its own, and the train, both with the same torque
/// on the second inertia. Gives the largest difference of the angle between them over the gap, and
/// how often they met.
fn compare(params: &PlantParams, speed: f64, torque: f64, seconds: f64) -> (f64, u64) {
    let plant = Plant::new(params);
    let mut state = PlantState::at_rest(params, 0.0, 0.0);
    state.motor_velocity = speed;
    let train = Train {
        inertia: [params.motor_inertia_kgm2, params.load_inertia_kgm2],
        c: params.stiffness_nm_per_rad,
        d: params.damping_nm_s_per_rad,
        b: 2.0 * params.half_gap_rad,
        law: params.contact,
        torque: [0.0, torque],
    };
    let mut y = [0.0, 0.0, speed, 0.0];
    let input = PlantInput {
        load_torque: -torque,
        ..PlantInput::default()
    };
    let (mut worst, mut meetings, mut apart): (f64, u64, bool) = (0.0, 0, true);
    for _ in 0..(seconds / params.period_s) as usize {
        plant.step(&mut state, &input);
        // steps so short that one that spans a kink of the torque errs by less than the comparison
        let method = ExplicitRungeKutta::dop853()
            .rtol(1e-11)
            .atol(1e-12)
            .h_max(5e-6);
        let solution = IVP::ode(&train, 0.0, params.period_s, y)
            .method(method)
            .solve()
            .unwrap();
        y = *solution.y.last().unwrap();
        worst = worst.max((state.gap_angle - (y[0] - y[1])).abs() / params.half_gap_rad);
        let free = state.gap_angle.abs() < params.half_gap_rad;
        meetings += u64::from(apart && !free);
        apart = free;
    }
    (worst, meetings)
}

fn free(law: ContactLaw) -> PlantParams {
    let base = PlantParams::new(&AxisConfig::paper());
    PlantParams {
        back_emf_v_s_per_rad: 0.0,
        motor_viscous_nm_s_per_rad: 0.0,
        contact: law,
        ..base
    }
}

#[test]
fn bounces_are_those_of_both_components() {
    for law in [ContactLaw::Clamped, ContactLaw::Bounded] {
        let (worst, meetings) = compare(&free(law), 20.0, 0.0, 0.2);
        assert!(worst < 1e-6, "{law:?}: {worst} of half the gap");
        assert!(meetings >= 3, "{law:?}: {meetings}");
        let (worst, meetings) = compare(&free(law), 5.0, -0.5, 0.2);
        assert!(worst < 1e-6, "{law:?}: {worst} of half the gap");
        assert!(meetings >= 2, "{law:?}: {meetings}");
    }
}

#[test]
fn without_backlash_both_components_are_a_spring_and_a_damper() {
    for law in [ContactLaw::Clamped, ContactLaw::Bounded] {
        let params = PlantParams {
            half_gap_rad: 0.0,
            ..free(law)
        };
        let plant = Plant::new(&params);
        let mut state = PlantState::at_rest(&params, 0.0, 0.0);
        state.motor_velocity = 3.0;
        let (c, d) = (params.stiffness_nm_per_rad, params.damping_nm_s_per_rad);
        let mass = params.motor_inertia_kgm2 * params.load_inertia_kgm2
            / (params.motor_inertia_kgm2 + params.load_inertia_kgm2);
        let decay = 0.5 * d / mass;
        let omega = (c / mass - decay * decay).sqrt();
        for k in 1..4000 {
            plant.step(&mut state, &PlantInput::default());
            let t = f64::from(k) * params.period_s;
            let expected = 3.0 / omega
                * lostmotion_base::math::exp(-decay * t)
                * lostmotion_base::math::sin(omega * t);
            assert!(
                (state.gap_angle - expected).abs() < 1e-13,
                "{k}: {} against {expected}",
                state.gap_angle
            );
        }
    }
}
