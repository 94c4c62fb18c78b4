//! Records of the tool's tip on machines whose joints do not go with it.

use lostmotion_base::{AxisId, Coords, math};
use lostmotion_sim::recorded::results::{Derivative, RecordCheck, RecordCoordinates, RecordKind};
use lostmotion_sim::recorded::{RecordOptions, Recorded, RecordedAxis};
use lostmotion_sim::{Machine, Program, SimError, Simulation};

/// The tip goes along X while A turns the table.
const TURN: &str =
    "G21 G90 G94 G54 G17 G61\nG1 X-30 Y0 Z40 A-20 C0 F3000\nG1 X30 Y0 Z40 A20 C0 F900\nM2\n";
/// How long the second move takes in the record, s.
const LASTS_S: f64 = 2.0;
/// Z of the program, its zero in machine coordinates, and the axis of A of `trunnion5`: 50 mm over its
/// rotation point at -420, mm.
const Z_MM: f64 = 40.0;
const ORIGIN_Z_MM: f64 = -370.0;
const LEVER_MM: f64 = Z_MM + ORIGIN_Z_MM - (50.0 - 420.0);

/// Share of the move at a time: from rest to rest, without a jump of the acceleration.
fn share(t: f64) -> f64 {
    let u = t / LASTS_S;
    u * u * u * (10.0 - 15.0 * u + 6.0 * u * u)
}

/// A at a time, rad.
fn angle(t: f64) -> f64 {
    (-20.0 + 40.0 * share(t)).to_radians()
}

/// The tip every millisecond, Z against the program's zero, with a decimal of mm and deg; 0 for none.
fn tip(z_mm: f64, decimal: f64) -> Recorded {
    let time_s: Vec<f64> = (0..=2000).map(|row| 1e-3 * f64::from(row)).collect();
    let rounded = |value: f64| {
        if decimal > 0.0 {
            (value / decimal).round() * decimal
        } else {
            value
        }
    };
    let axis = |axis: AxisId, of: &dyn Fn(f64) -> f64| RecordedAxis {
        axis,
        values: time_s.iter().map(|t| of(*t)).collect(),
    };
    Recorded {
        axes: vec![
            axis(AxisId::X, &|t| rounded(-30.0 + 60.0 * share(t))),
            axis(AxisId::Y, &|_| 0.0),
            axis(AxisId::Z, &|_| z_mm),
            axis(AxisId::A, &|t| rounded(angle(t).to_degrees()).to_radians()),
            axis(AxisId::C, &|_| 0.0),
        ],
        time_s,
        kind: RecordKind::Commanded,
        of_tool: true,
    }
}

fn checked(text: &str, machine: &str, recorded: &Recorded) -> Result<RecordCheck, SimError> {
    let machine = Machine::preset(machine).unwrap();
    Simulation::new(&Program::from_str("part.ngc", text), &machine)
        .check_record(recorded, &RecordOptions::default())
}

/// What the record proves of a limit of an axis, and how far it may be off.
fn found(check: &RecordCheck, axis: AxisId, derivative: Derivative) -> (f64, f64) {
    let axis = check.axes.iter().find(|other| other.axis == axis).unwrap();
    let mut limits = axis.limits.iter();
    let limit = limits.find(|limit| limit.derivative == derivative).unwrap();
    (limit.found, limit.plus_minus)
}

/// Where the table lies level it turns fastest, 40 deg * 1.875 / 2 s, and takes a tip over its axis
/// along Y with the lever of the tip: whatever the coordinates that the tip is told in.
#[test]
fn the_joints_of_a_tip_are_those_of_the_machine_in_any_coordinates() {
    let fastest = LEVER_MM * (40.0 * 1.875 / LASTS_S).to_radians();
    for (z_mm, coordinates) in [
        (Z_MM, RecordCoordinates::Program),
        (Z_MM + ORIGIN_Z_MM, RecordCoordinates::Machine),
    ] {
        let check = checked(TURN, "trunnion5", &tip(z_mm, 0.0)).unwrap();
        assert_eq!(check.place.coordinates, coordinates);
        let (velocity, _) = found(&check, AxisId::Y, Derivative::Velocity);
        assert!(
            (velocity / fastest - 1.0).abs() < 1e-4,
            "{coordinates:?}: {velocity} {fastest}"
        );
        assert!(check.is_within(), "{:#?}", check.blocks);
    }
}

/// What is certain of joints is never more than what is, however the log is rounded.
#[test]
fn roundings_of_a_tip_are_carried_over_to_the_joints() {
    let y = |t: f64| LEVER_MM * math::sin(angle(t));
    // Third difference over 3 ms, at its largest.
    let h = 1e-3;
    let jerk = (0..1997)
        .map(|row| h * f64::from(row))
        .map(|t| (y(t + 3.0 * h) - 3.0 * y(t + 2.0 * h) + 3.0 * y(t + h) - y(t)) / (h * h * h))
        .fold(0.0, |most: f64, jerk| most.max(jerk.abs()));
    for decimal in [0.0, 1e-5, 1e-4, 1e-3] {
        let check = checked(TURN, "trunnion5", &tip(Z_MM, decimal)).unwrap();
        let (of_y, plus_minus) = found(&check, AxisId::Y, Derivative::Jerk);
        assert!(
            of_y - plus_minus <= 1.01 * jerk,
            "{decimal}: {of_y} +-{plus_minus}, {jerk}"
        );
        assert!(check.is_within(), "{decimal}: {:#?}", check.blocks);
        // Of A's rounding the lever makes one of Y.
        let step = check.axes[1].step;
        let of_a = LEVER_MM * decimal.to_radians();
        if decimal >= 1e-4 {
            assert!((step / of_a - 1.0).abs() < 0.01, "{decimal}: {step} {of_a}");
        }
    }
}

/// Without the angle of the table nobody knows where its joints are.
#[test]
fn a_tip_without_the_axes_that_turn_is_refused() {
    let mut bare = tip(Z_MM, 0.0);
    bare.axes.truncate(4);
    let refused = checked(TURN, "trunnion5", &bare).unwrap_err().to_string();
    assert!(
        refused.contains("no axis C, and the joints of the machine `trunnion5` depend on it"),
        "{refused}"
    );
}

/// X, Y and Z in mm, A or B and C in deg, where the moves of a program end.
type Stop = [f64; 5];

/// A tip that goes from stop to stop, each move in a second, a row every millisecond.
fn along(stops: &[Stop], tilt: AxisId) -> Recorded {
    let mut rows: Vec<Stop> = Vec::new();
    for pair in stops.windows(2) {
        for row in 0..1000 {
            let part = share(LASTS_S * 1e-3 * f64::from(row));
            let at: Vec<f64> = (0..5)
                .map(|axis| pair[0][axis] + part * (pair[1][axis] - pair[0][axis]))
                .collect();
            rows.push([at[0], at[1], at[2], at[3], at[4]]);
        }
    }
    rows.extend(stops.last());
    let axes = [AxisId::X, AxisId::Y, AxisId::Z, tilt, AxisId::C];
    let unit = [1.0, 1.0, 1.0, 1_f64.to_radians(), 1_f64.to_radians()];
    Recorded {
        time_s: (0..rows.len()).map(|row| 1e-3 * row as f64).collect(),
        axes: (0..5)
            .map(|place| RecordedAxis {
                axis: axes[place],
                values: rows.iter().map(|row| row[place] * unit[place]).collect(),
            })
            .collect(),
        kind: RecordKind::Commanded,
        of_tool: true,
    }
}

/// The program of stops: the first one is come to by a rapid before tip control.
fn program(before: &str, stops: &[Stop], tilt: char, behind: &str) -> String {
    let words = |[x, y, z, a, c]: &Stop| format!("X{x} Y{y} Z{z} {tilt}{a} C{c}\n");
    let moves: String = stops
        .iter()
        .skip(1)
        .map(|stop| format!("G1 {}", words(stop)))
        .collect();
    let first = stops.first().map(words).unwrap_or_default();
    format!("G21 G90 G94 G54 G17 G61 F1200\nG0 {first}{before}{moves}{behind}M2\n")
}

/// A log of what lies between G43.4 and G49 is checked; one that goes over either is refused with
/// the line behind it.
#[test]
fn a_log_under_tip_control_is_checked_where_the_program_begins_without() {
    let stops = [
        [0.0, 0.0, 50.0, 0.0, 0.0],
        [10.0, 5.0, 45.0, 5.0, 8.0],
        [15.0, -8.0, 42.0, 9.0, 20.0],
    ];
    let text = program("G43.4 H0\n", &stops, 'B', "G49\nG0 Z80\n");
    let record = along(&stops, AxisId::B);
    let check = checked(&text, "fork5", &record).unwrap();
    let lines = (check.place.first.span.line, check.place.last.span.line);
    assert_eq!(lines, (4, 5));
    assert_eq!(check.place.coordinates, RecordCoordinates::Program);
    assert!(check.deviation_max_um < 0.01, "{}", check.deviation_max_um);
    let refused = |stops: &[Stop]| {
        let error = checked(&text, "fork5", &along(stops, AxisId::B)).unwrap_err();
        error.to_string()
    };
    let mut early = stops.to_vec();
    early.insert(0, [0.0, 0.0, 90.0, 0.0, 0.0]);
    let error = refused(&early);
    assert!(
        error.contains("line 4") && error.contains("before that"),
        "{error}"
    );
    let mut late = stops.to_vec();
    late.push([15.0, -8.0, 90.0, 9.0, 20.0]);
    let error = refused(&late);
    assert!(
        error.contains("line 7") && error.contains("behind that"),
        "{error}"
    );
}

/// With a rotary axis 1 deg off no shift is right: the fitted one is no better than what it leaves,
/// and it is said to be doubtful.
#[test]
fn a_shift_that_an_angle_is_taken_for_is_doubtful() {
    let stops = [
        [0.0, 0.0, 10.0, 0.0, 0.0],
        [30.0, 10.0, 10.0, 20.0, 40.0],
        [30.0, -20.0, 5.0, 35.0, 90.0],
        [-20.0, -25.0, 0.0, -10.0, 150.0],
        [-25.0, 15.0, 2.0, 5.0, 220.0],
        [10.0, 25.0, 4.0, 15.0, 300.0],
    ];
    let text = program("", &stops, 'A', "");
    let mut record = along(&stops, AxisId::A);
    let bench = Machine::preset("trunnion5").unwrap();
    let kinematics = bench.build_kinematics().unwrap();
    for row in 0..record.time_s.len() {
        let mut tip = Coords::ZERO;
        for axis in &record.axes {
            tip.0[axis.axis.index()] = axis.values[row];
        }
        tip.0[2] += ORIGIN_Z_MM;
        let joints = kinematics.inverse(&tip, &[0.0; 3]).unwrap();
        for axis in &mut record.axes {
            axis.values[row] = joints.0[axis.axis.index()];
        }
    }
    record.of_tool = false;
    let doubts = |check: &RecordCheck| {
        let mut reasons = check.untold.iter();
        reasons.any(|reason| reason.contains("off by a shift at all"))
    };
    let right = checked(&text, "trunnion5", &record).unwrap();
    assert_eq!(right.place.coordinates, RecordCoordinates::Machine);
    assert!(right.deviation_max_um < 0.1 && !doubts(&right));
    for value in &mut record.axes[3].values {
        *value += 1_f64.to_radians();
    }
    let check = checked(&text, "trunnion5", &record).unwrap();
    assert_eq!(check.place.coordinates, RecordCoordinates::Shifted);
    // There is none.
    for shift in check.place.shift_mm {
        assert!(
            shift.abs() <= check.place.shift_error_mm,
            "{:?}",
            check.place
        );
    }
    assert!(doubts(&check), "{:?}", check.untold);
    assert!(!check.is_within());
}

/// Rows half a second apart are said to be, and not that nothing moves.
#[test]
fn a_log_with_few_rows_that_moves_is_not_said_to_rest() {
    let whole = tip(Z_MM, 0.0);
    let few = |values: &[f64]| values.iter().copied().step_by(500).collect::<Vec<f64>>();
    let record = Recorded {
        time_s: few(&whole.time_s),
        axes: whole
            .axes
            .iter()
            .map(|axis| RecordedAxis {
                axis: axis.axis,
                values: few(&axis.values),
            })
            .collect(),
        ..whole
    };
    let refused = checked(TURN, "trunnion5", &record).unwrap_err().to_string();
    assert!(
        refused.contains("the rows of the log are too far apart"),
        "{refused}"
    );
    assert!(!refused.contains("hardly moves"), "{refused}");
}
