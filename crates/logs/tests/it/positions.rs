//! Positions of several axes: names, units, kinds, clocks, turns, and what is refused.

use lostmotion_base::AxisId;
use lostmotion_logs::{PositionKind, PositionLog, PositionOptions, PositionParts, read_positions};

fn options(columns: &[&str]) -> PositionOptions {
    PositionOptions {
        columns: columns.iter().map(|spec| spec.parse().unwrap()).collect(),
        needed: vec![AxisId::X, AxisId::Y],
        axes: vec![AxisId::X, AxisId::Y, AxisId::Z, AxisId::C],
        ..PositionOptions::default()
    }
}

fn read(text: &str, options: &PositionOptions) -> Result<PositionLog, String> {
    read_positions(text.as_bytes(), "log", options).map_err(|error| error.to_string())
}

/// A table of these columns with three rows that count up.
fn table(columns: &[&str]) -> String {
    let mut text = format!("t_s,{}\n", columns.join(","));
    for row in 0..3 {
        let cells: Vec<String> = (0..columns.len())
            .map(|column| format!("{}", 10 * (column + 1) + row))
            .collect();
        text += &format!("0.{row},{}\n", cells.join(","));
    }
    text
}

#[test]
fn names_tell_axes_and_what_was_recorded() {
    let commanded = Some(PositionKind::Commanded);
    let measured = Some(PositionKind::Measured);
    for (columns, kind) in [
        (vec!["x_mm", "y_mm"], None),
        (
            vec![
                "x_reference_mm",
                "x_motor_mm",
                "y_reference_mm",
                "y_motor_mm",
            ],
            commanded,
        ),
        (vec!["tool_x_mm", "tool_y_mm"], measured),
        (
            vec![
                "pos_x [mm]",
                "cmd_pos_x [mm]",
                "pos_y [mm]",
                "cmd_pos_y [mm]",
            ],
            commanded,
        ),
        // One axis has no command: all are taken as measured.
        (vec!["x_act_mm", "x_cmd_mm", "y_act_mm"], measured),
    ] {
        let log = read(&table(&columns), &options(&[])).unwrap();
        assert_eq!(log.kind, kind, "{columns:?}");
        let ids: Vec<AxisId> = log.axes.iter().map(|axis| axis.axis).collect();
        assert_eq!(ids, [AxisId::X, AxisId::Y]);
        let expected = columns
            .iter()
            .position(|name| {
                name.contains('x')
                    && (kind != commanded || name.contains("cmd") || name.contains("reference"))
            })
            .unwrap();
        assert_eq!(
            log.axes[0].values[0],
            10.0 * (expected + 1) as f64,
            "{columns:?}"
        );
    }
}

#[test]
fn pins_of_linuxcnc_are_known_and_their_unit_is_asked_for() {
    let text = "# Sampling period is 1000000 ns\njoint.0.pos-cmd;joint.0.motor-pos-cmd;joint.1.pos-cmd;joint.3.pos-cmd\n1;1.5;2;90\n2;2.5;3;180\n3;3.5;4;270\n";
    let error = read(text, &options(&[])).unwrap_err();
    assert!(
        error.contains("the unit of `joint.0.pos-cmd`") && error.contains("--unit mm"),
        "{error}"
    );
    let told = PositionOptions {
        unit: Some("inch".parse().unwrap()),
        ..options(&[])
    };
    let log = read(text, &told).unwrap();
    assert_eq!(log.kind, Some(PositionKind::Commanded));
    assert_eq!(log.axes[0].values, [25.4, 50.8, 3.0 * 25.4]);
    // The fourth joint of this machine is C, in degrees.
    assert_eq!(log.axes[2].axis, AxisId::C);
    assert!(log.axes[2].is_angle && (log.axes[2].values[1] - std::f64::consts::PI).abs() < 1e-12);
}

#[test]
fn columns_that_are_told_go_before_names() {
    let log = read(
        &table(&["x_mm", "a1", "a2"]),
        &options(&["x=a2,unit=um,sign=-", "y=3,unit=mm"]),
    )
    .unwrap();
    assert_eq!(log.axes[0].values, [-0.030, -0.031, -0.032]);
    assert_eq!(log.axes[1].values, [20.0, 21.0, 22.0]);
}

#[test]
fn turns_are_added_up_and_held_values_taken_once() {
    let mut text = "t_s,x_mm,y_mm,c_deg\n".to_owned();
    for row in 0..2000 {
        let held = row / 4 * 4;
        let x = 5.0 * (0.01 * f64::from(held)).sin();
        text += &format!(
            "{:.3},{x:.6},{:.6},{:.4}\n",
            f64::from(row) * 1e-3,
            x * 0.7,
            (f64::from(held) * 0.9).rem_euclid(360.0)
        );
    }
    let log = read(&text, &options(&[])).unwrap();
    assert_eq!(log.time_s.len(), 500);
    let last = log.axes[2].values.last().unwrap().to_degrees();
    assert!((last - 0.9 * 1996.0).abs() < 1e-3, "{last}");
    assert!(log.said.iter().any(|said| said.contains("held for 4 rows")));
}

#[test]
fn jumps_stay_and_are_said() {
    let mut text = "t_s,x_mm,y_mm\n".to_owned();
    for row in 0..400 {
        let jump = if row > 200 { 3.0 } else { 0.0 };
        let x = 0.05 * f64::from(row) + 1e-4 * f64::from(row % 3);
        text += &format!("{:.3},{:.5},0\n", f64::from(row) * 1e-3, x + jump);
    }
    let log = read(&text, &options(&[])).unwrap();
    assert_eq!(log.time_s.len(), 400);
    assert!(
        log.said
            .iter()
            .any(|said| said.starts_with("line 203: axis x jumps by 2.9997 mm")),
        "{:?}",
        log.said
    );
}

/// One row of Y is 5 mm off and back, and two of X: they are left out and said, whole and in parts.
#[test]
fn rows_that_are_off_and_come_back_are_left_out() {
    let mut text = "t_s,x_mm,y_mm,y2_mm\n".to_owned();
    for row in 0..1000 {
        let t = f64::from(row) * 1e-3;
        let (x, y) = (40.0 * (3.0 * t).sin(), 25.0 * (2.0 * t).cos());
        let off_x = if [700, 701].contains(&row) { -2.0 } else { 0.0 };
        let off_y = if row == 295 { 5.0 } else { 0.0 };
        text += &format!("{t:.3},{:.6},{:.6},{y:.6}\n", x + off_x, y + off_y);
    }
    let log = read(&text, &options(&[])).unwrap();
    let said = log.said.join("\n");
    for part in [
        "line 702: axis x's position is off by -1.9997",
        "and comes back: 2 rows are left out",
        "line 297: axis y's position is off by 5.0",
        "and comes back: 1 row is left out",
        "left out, as an axis has one position here: `y2_mm`",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    assert_eq!(log.time_s.len(), 997);
    let kept = |time: &f64| {
        ![0.295, 0.7, 0.701]
            .iter()
            .any(|off| (time - off).abs() < 1e-6)
    };
    assert!(log.time_s.iter().all(kept));
    let mut parts = PositionParts::new(text.as_bytes(), "log", &options(&[]), 300, 50).unwrap();
    let mut time_s = Vec::<f64>::new();
    while let Some((part, shared)) = parts.next_part().unwrap() {
        time_s.extend(&part.time_s[shared..]);
    }
    assert_eq!(time_s, log.time_s);
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let refused = |text: &str, columns: &[&str], part: &str| {
        let error = read(text, &options(columns)).unwrap_err();
        assert!(error.contains(part), "{error}");
    };
    refused(
        &table(&["x_mm"]),
        &[],
        "no column is known to be the position of axis Y; the columns are: x_mm",
    );
    refused(
        &table(&["x_mm", "x", "y_mm"]),
        &["x=2,unit=mm", "x=3,unit=mm"],
        "told twice",
    );
    refused(
        &table(&["x_cmd_mm", "x_set_mm", "y_cmd_mm"]),
        &[],
        "both `x_cmd_mm` and `x_set_mm` could be the position of axis X",
    );
    refused(
        &table(&["x_mm", "y_mm"]),
        &["motor=2"],
        "this log is of several axes",
    );
    refused(
        &table(&["x_a", "y_mm"]),
        &["x=x_a,unit=A"],
        "`x_a` is no position",
    );
    refused(
        "t_s,x_mm,y_mm\n0,1,2\n0.001,1,nan\n0.002,1,2\n",
        &[],
        "line 3, column `y_mm`: `nan`",
    );
    refused(
        "t_s,x_mm,y_mm\n0,1,2\n0.001,1,2\n0.001,1,2\n",
        &[],
        "line 4: the time",
    );
    refused("t_s,x_mm,y_mm\n0,1,2\n", &[], "1 rows of data");
    refused("", &[], "the file is empty");
}

/// Part by part a log has the rows that it has as a whole: where values are held, turns wrap and
/// parts begin anywhere.
#[test]
fn parts_are_the_whole() {
    for held in [1, 4] {
        let mut text = "t_s,x_mm,y_mm,c_deg\n".to_owned();
        for row in 0..4000 {
            let t = f64::from((row + 3) / held * held) * 1e-3;
            let angle = (170.0 * t * t) % 360.0;
            text += &format!(
                "{:.3},{:.6},{:.6},{angle:.6}\n",
                f64::from(row) * 1e-3,
                40.0 * (3.0 * t).sin(),
                25.0 * (2.0 * t).cos(),
            );
        }
        let options = options(&[]);
        let whole = read(&text, &options).unwrap();
        assert!(
            whole.said.iter().any(|said| said.contains("wraps")),
            "{:?}",
            whole.said
        );
        assert!(whole.axes[2].values.iter().all(|angle| *angle >= 0.0));
        for (part_rows, shared_rows) in [(700, 100), (997, 1), (1000, 0), (5000, 100)] {
            let mut parts =
                PositionParts::new(text.as_bytes(), "log", &options, part_rows, shared_rows)
                    .unwrap();
            let (mut time_s, mut values) = (Vec::<f64>::new(), vec![Vec::<f64>::new(); 3]);
            let mut before: Option<(f64, f64)> = None;
            while let Some((part, shared)) = parts.next_part().unwrap() {
                // the shared rows are those of the part before
                if let Some(last) = before.filter(|_| shared > 0) {
                    let axis = &part.axes[2];
                    assert_eq!(part.time_s[shared - 1], last.0);
                    assert!((axis.values[shared - 1] - last.1).abs() < 1e-9);
                }
                let rows = part.time_s.len();
                before = Some((part.time_s[rows - 1], part.axes[2].values[rows - 1]));
                time_s.extend(&part.time_s[shared..]);
                for (values, axis) in values.iter_mut().zip(&part.axes) {
                    values.extend(&axis.values[shared..]);
                }
            }
            assert_eq!(time_s, whole.time_s, "{held} {part_rows}");
            for (axis, values) in whole.axes.iter().zip(&values) {
                // without shared rows turns are not carried over
                let turns = axis.axis == AxisId::C && shared_rows == 0;
                let same = axis
                    .values
                    .iter()
                    .zip(values)
                    .all(|(a, b)| (a - b).abs() < 1e-9);
                assert!(same || turns, "{held} {part_rows}: {}", axis.axis);
            }
        }
        // no more rows than are wanted
        let few = PositionOptions {
            max_rows: 1500,
            ..options.clone()
        };
        let mut parts = PositionParts::new(text.as_bytes(), "log", &few, 1000, 0).unwrap();
        let mut rows = Vec::new();
        let mut said = Vec::new();
        while let Some((part, _)) = parts.next_part().unwrap() {
            rows.push(part.time_s.len() * held as usize);
            said.extend(part.said);
        }
        assert_eq!(rows, [1000, 500]);
        assert!(
            said.iter().any(|said| said.contains("the first 1500 rows")),
            "{said:?}"
        );
    }
}

/// Rows that go back in time are refused in any part, with their line.
#[test]
fn a_later_part_is_in_order_too() {
    let mut text = "t_s,x_mm,y_mm\n".to_owned();
    for row in 0..300 {
        let t = if row == 250 { 5 } else { row };
        text += &format!("{:.3},{row},{row}\n", f64::from(t) * 1e-3);
    }
    let mut parts = PositionParts::new(text.as_bytes(), "log", &options(&[]), 200, 10).unwrap();
    assert!(parts.next_part().unwrap().is_some());
    let error = parts.next_part().unwrap_err().to_string();
    assert!(
        error.contains("line 252") && error.contains("is not after"),
        "{error}"
    );
}
