//! Trunnion machines against poses computed by LinuxCNC, where the table of them is at hand.

use lostmotion_base::{AxisId, Coords, units::rad};
use lostmotion_kinematics::{KinematicsSpec, build};
use std::path::Path;

/// Columns: kins, con, xr, yr, zr, xo, yo, zo, tool, pivot, px, py, pz, a, b, c, w, jx, jy, jz.
#[test]
fn poses_of_linuxcnc() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/plan/kinematics/five_axis_oracle.csv");
    let Ok(text) = std::fs::read_to_string(&path) else {
        println!("skipped: no table of poses beside the repository");
        return;
    };
    let (mut rows, mut worst) = ([0_u32; 2], 0.0_f64);
    for line in text.lines().skip(1) {
        let Some(tilt_a) = ["xyzbc-trt", "xyzac-trt"].iter().position(|name| line.starts_with(name)).map(|i| i == 1) else { continue };
        let n: Vec<f64> = line.split(',').skip(1).map(|field| field.parse().unwrap()).collect();
        let spec = KinematicsSpec {
            kind: if tilt_a { "trunnion-ac" } else { "trunnion-bc" }.into(),
            rotation_point_mm: Some([n[1], n[2], n[3]]),
            offset_x_mm: (!tilt_a).then_some(n[4]),
            offset_y_mm: tilt_a.then_some(n[5]),
            offset_z_mm: Some(n[6]),
            conventional_directions: Some(n[0] > 0.5),
        };
        let machine = build(&spec).unwrap();
        // LinuxCNC's position has the tool's length added already.
        let tool = [0.0, 0.0, n[7]];
        let mut program = Coords::xyz(n[9], n[10], n[11] - n[7]);
        (program[AxisId::A], program[AxisId::B], program[AxisId::C]) = (rad(n[12]), rad(n[13]), rad(n[14]));
        let meant = Coords::xyz(n[16], n[17], n[18]);
        let joints = machine.inverse(&program, &tool).unwrap();
        let mut back = joints;
        back.0[..3].copy_from_slice(&meant.0[..3]);
        let there = (joints - meant).linear_norm();
        let again = (machine.forward(&back, &tool) - program).linear_norm();
        worst = worst.max(there).max(again);
        assert!(there < 1e-8 && again < 1e-8, "{line}: {there} {again}");
        rows[usize::from(tilt_a)] += 1;
    }
    println!("{} rows of xyzac-trt and {} of xyzbc-trt, worst {worst:e} mm", rows[1], rows[0]);
    assert!(rows[0] > 0 && rows[1] > 0);
}
