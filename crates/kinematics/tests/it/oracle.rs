//! Five-axis machines against poses computed by LinuxCNC, where the table of them is at hand.

use lostmotion_base::{AxisId, Coords, units::rad};
use lostmotion_kinematics::{Kinematics, KinematicsSpec, TrunnionAcSpec, TrunnionBcSpec, build};
use std::path::Path;

fn trunnion_ac(n: &[f64]) -> KinematicsSpec {
    TrunnionAcSpec {
        rotation_point_mm: [n[1], n[2], n[3]],
        offset_y_mm: Some(n[5]),
        offset_z_mm: Some(n[6]),
        conventional_directions: Some(n[0] > 0.5),
        ..TrunnionAcSpec::default()
    }
    .into()
}

fn trunnion_bc(n: &[f64]) -> KinematicsSpec {
    TrunnionBcSpec {
        rotation_point_mm: [n[1], n[2], n[3]],
        offset_x_mm: Some(n[4]),
        offset_z_mm: Some(n[6]),
        conventional_directions: Some(n[0] > 0.5),
        ..TrunnionBcSpec::default()
    }
    .into()
}

/// The machine of a row, as a chain where it is a head.
fn machine(kins: &str, n: &[f64]) -> Box<dyn Kinematics> {
    let linear = "[[joint]]\naxis = \"x\"\ntype = \"linear\"\ndirection = [1, 0, 0]\n[[joint]]\naxis = \"y\"\ntype = \"linear\"\ndirection = [0, 1, 0]\n[[joint]]\naxis = \"z\"\ntype = \"linear\"\ndirection = [0, 0, 1]\n";
    let rotary = |axis: &str, side: &str, direction: &str, z: f64, sign: i32| {
        format!(
            "[[joint]]\naxis = \"{axis}\"\ntype = \"rotary\"\nside = \"{side}\"\ndirection = {direction}\npoint_mm = [0.0, 0.0, {z:?}]\nsign = {sign}\n"
        )
    };
    let quill = "[[joint]]\naxis = \"w\"\ntype = \"linear\"\ndirection = [0, 0, -1]\n";
    let pivot = n[8];
    let text = match kins {
        "xyzac-trt" => return build(&trunnion_ac(n)).unwrap(),
        "xyzbc-trt" => return build(&trunnion_bc(n)).unwrap(),
        // The tilt tips the tool towards -X for a positive B.
        "maxkins" => {
            let sign = if n[0] > 0.5 { 1 } else { -1 };
            let (table, head) = (
                rotary("c", "table", "[0, 0, 1]", 0.0, 1),
                rotary("b", "head", "[0, 1, 0]", pivot, sign),
            );
            format!("kind = \"chain\"\n{table}{linear}{head}{quill}")
        }
        _ => {
            let (pan, tilt) = (
                rotary("c", "head", "[0, 0, 1]", 0.0, 1),
                rotary("b", "head", "[0, 1, 0]", pivot, -1),
            );
            format!("kind = \"chain\"\n{linear}{pan}{tilt}{quill}")
        }
    };
    build(&toml::from_str(&text).unwrap()).unwrap()
}

/// Columns: kins, con, xr, yr, zr, xo, yo, zo, tool, pivot, px, py, pz, a, b, c, w, jx, jy, jz.
#[test]
fn poses_of_linuxcnc() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../../shared/plan/kinematics/five_axis_oracle.csv");
    let Ok(text) = std::fs::read_to_string(&path) else {
        println!("skipped: no table of poses beside the repository");
        return;
    };
    let (mut rows, mut worst) = (0, 0.0_f64);
    for line in text.lines().skip(1) {
        let kins = line.split(',').next().unwrap();
        let n: Vec<f64> = line
            .split(',')
            .skip(1)
            .map(|field| field.parse().unwrap())
            .collect();
        let machine = machine(kins, &n);
        // Its trunnions add the tool's length to the position already; its heads have it in the
        // pivot.
        let length = if kins.ends_with("-trt") { n[7] } else { 0.0 };
        let tool = [0.0, 0.0, length];
        let mut program = Coords::xyz(n[9], n[10], n[11] - length);
        (
            program[AxisId::A],
            program[AxisId::B],
            program[AxisId::C],
            program[AxisId::W],
        ) = (rad(n[12]), rad(n[13]), rad(n[14]), n[15]);
        let meant = Coords::xyz(n[16], n[17], n[18]);
        let joints = machine.inverse(&program, &tool).unwrap();
        let mut back = joints;
        back.0[..3].copy_from_slice(&meant.0[..3]);
        let there = (joints - meant).linear_norm();
        let again = (machine.forward(&back, &tool) - program).linear_norm();
        worst = worst.max(there).max(again);
        assert!(there < 1e-8 && again < 1e-8, "{line}: {there} {again}");
        rows += 1;
    }
    println!("{rows} rows, worst {worst:e} mm");
    assert_eq!(rows, 2000);
}
