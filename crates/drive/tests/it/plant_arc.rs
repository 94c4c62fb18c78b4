//! A whole engaged arc, and a whole coasting one, at once: by the matrix exponential of the
//! equations written out here, in one go of thousands of periods.

use lostmotion_base::math;
use lostmotion_drive::config::ContactLaw;
use lostmotion_drive::plant::{Contact, Plant, PlantInput, PlantParams, PlantState, Side};
use lostmotion_methods::AxisConfig;

/// i, theta_b less half the gap, theta_L, w_M, w_L, and 1.
const N: usize = 6;
type Matrix = [[f64; N]; N];

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..N).map(|k| a[i][k] * b[k][j]).sum()))
}

/// `solve(q, p) = q^-1 p` by elimination with pivots.
fn solve(mut q: Matrix, mut p: Matrix) -> Matrix {
    for column in 0..N {
        let pivot = (column..N)
            .max_by(|&a, &b| q[a][column].abs().total_cmp(&q[b][column].abs()))
            .unwrap();
        q.swap(column, pivot);
        p.swap(column, pivot);
        for row in 0..N {
            let factor = q[row][column] / q[column][column];
            if row != column && factor != 0.0 {
                for k in 0..N {
                    q[row][k] -= factor * q[column][k];
                    p[row][k] -= factor * p[column][k];
                }
            }
        }
    }
    std::array::from_fn(|row| p[row].map(|entry| entry / q[row][row]))
}

/// Padé's approximation of degree 6 with scaling and squaring (Golub, Van Loan, *Matrix
/// Computations*, algorithm 11.3.1).
fn exponential(a: &Matrix, time: f64) -> Matrix {
    let norm = a
        .iter()
        .map(|row| row.iter().map(|entry| entry.abs()).sum::<f64>())
        .fold(0.0, f64::max)
        * time;
    let halvings = (0..60)
        .find(|&n| norm <= 0.5 * math::exp2(f64::from(n)))
        .unwrap_or(60);
    let step = time / math::exp2(f64::from(halvings));
    let scaled = a.map(|row| row.map(|entry| entry * step));
    let mut power: Matrix =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j))));
    let (mut numerator, mut denominator, mut c) = (power, power, 1.0);
    for k in 1..=6 {
        c *= f64::from(6 - k + 1) / f64::from(k * (12 - k + 1));
        power = product(&power, &scaled);
        let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
        for i in 0..N {
            for j in 0..N {
                numerator[i][j] += c * power[i][j];
                denominator[i][j] += sign * c * power[i][j];
            }
        }
    }
    let mut result = solve(denominator, numerator);
    for _ in 0..halvings {
        result = product(&result, &result);
    }
    result
}

/// The system matrix with or without contact, the held voltage and torques in the last column.
fn system(p: &PlantParams, engaged: bool, voltage: f64, load: f64) -> Matrix {
    let (k, d) = if engaged {
        (p.stiffness_nm_per_rad, p.damping_nm_s_per_rad)
    } else {
        (0.0, 0.0)
    };
    let (m, l) = (1.0 / p.motor_inertia_kgm2, 1.0 / p.load_inertia_kgm2);
    let (inductance, viscous) = (
        p.inductance_h,
        [p.motor_viscous_nm_s_per_rad, p.load_viscous_nm_s_per_rad],
    );
    [
        [
            -p.resistance_ohm / inductance,
            0.0,
            0.0,
            -p.back_emf_v_s_per_rad / inductance,
            0.0,
            voltage / inductance,
        ],
        [0.0, 0.0, 0.0, 1.0, -1.0, 0.0],
        [0.0, 0.0, 0.0, 0.0, 1.0, 0.0],
        [
            m * p.torque_constant_nm_per_a,
            -m * k,
            0.0,
            -m * (viscous[0] + d),
            m * d,
            0.0,
        ],
        [0.0, l * k, 0.0, l * d, -l * (viscous[1] + d), -l * load],
        [0.0; N],
    ]
}

fn check(engaged: bool, periods: usize) {
    for law in [ContactLaw::Linear, ContactLaw::Clamped, ContactLaw::Bounded] {
        let base = PlantParams::new(&AxisConfig::paper());
        let params = PlantParams {
            contact: law,
            pole_pairs: 0.0,
            load_viscous_nm_s_per_rad: 0.03,
            ..base
        };
        let half_gap_rad = if engaged { params.half_gap_rad } else { 1e3 };
        let params = PlantParams {
            half_gap_rad,
            ..params
        };
        let plant = Plant::new(&params);
        let mut state = PlantState::at_rest(&params, 0.0, 0.0);
        // wound up by the load, so that it never comes off the flank and damping stays below the
        // spring
        let (voltage, load) = if engaged { (0.3, 2.0) } else { (0.4, 0.0) };
        if engaged {
            state.mode.contact = Contact::Spring(Side::Positive);
            (state.gap_angle, state.current_q) = (
                half_gap_rad + load / params.stiffness_nm_per_rad,
                load / params.torque_constant_nm_per_a,
            );
        }
        let middle = if engaged { half_gap_rad } else { 0.0 };
        let start = [
            state.current_q,
            state.gap_angle - middle,
            state.load_position,
            0.0,
            0.0,
            1.0,
        ];
        let input = PlantInput {
            voltage_d: 0.0,
            voltage_q: voltage,
            load_torque: load,
        };
        for _ in 0..periods {
            plant.step(&mut state, &input);
        }
        assert_eq!(state.events, 0, "one arc without an event");
        let whole = exponential(
            &system(&params, engaged, voltage, load),
            periods as f64 * params.period_s,
        );
        let end: [f64; N] =
            std::array::from_fn(|row| (0..N).map(|k| whole[row][k] * start[k]).sum());
        let reached = [
            state.current_q,
            state.gap_angle - middle,
            state.load_position,
            state.motor_velocity,
            state.load_velocity,
        ];
        for (a, b) in reached.iter().zip(end) {
            assert!(
                (a - b).abs() < 1e-10 * (1.0 + b.abs()),
                "{law:?}: {reached:?} against {end:?}"
            );
        }
    }
}

#[test]
fn an_engaged_arc_is_one_matrix_exponential() {
    check(true, 4000);
}

#[test]
fn a_motor_alone_in_its_gap_is_one_matrix_exponential() {
    check(false, 4000);
}
