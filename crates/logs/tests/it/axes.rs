//! One axis out of a log: roles, units, clocks, held values, wrapped counters, lost time.

use lostmotion_logs::{AxisLog, AxisOptions, DriveSignal, Role, read_axis};

fn options(columns: &[&str]) -> AxisOptions {
    AxisOptions {
        columns: columns.iter().map(|spec| spec.parse().unwrap()).collect(),
        ..AxisOptions::default()
    }
}

fn says(log: &AxisLog, part: &str) -> bool {
    log.said.iter().any(|said| said.contains(part))
}

#[test]
fn roles_units_and_signs() {
    let text = "Zeit [ms];Geber [um];Massstab [mm];Iq [mA];Status\n0;1000;-1;500;run\n1;2000;-2;-500;run\n2;3000;-3;0;run\n";
    let options = options(&["motor=Geber [um]", "load=Massstab [mm],sign=-", "current=5"]);
    // the fifth column is the status: numbers count all columns, that of the time, too
    assert!(read_axis(text.as_bytes(), "log", &options).is_err());
    let options = self::options(&[
        "motor=Geber [um]",
        "load=Massstab [mm],sign=-",
        "current=4,scale=2",
    ]);
    let log = read_axis(text.as_bytes(), "log", &options).unwrap();
    assert_eq!(
        (log.unit.symbol, log.time_s.as_slice()),
        ("mm", &[0.0, 1e-3, 2e-3][..])
    );
    assert_eq!(
        (log.motor, log.load),
        (vec![1.0, 2.0, 3.0], vec![1.0, 2.0, 3.0])
    );
    assert_eq!(log.drive, Some(DriveSignal::Current(vec![1.0, -1.0, 0.0])));
    assert_eq!(log.line, [2, 3, 4]);
}

/// A user counts the columns of the file from the left.
#[test]
fn numbers_count_every_column_of_the_file() {
    let text = "pos_mm,t_s,load_mm\n1,0,4\n2,0.001,5\n3,0.002,6\n";
    let of = |columns: &[&str]| read_axis(text.as_bytes(), "log", &options(columns));
    let log = of(&["motor=1", "load=3"]).unwrap();
    assert_eq!(log.motor, [1.0, 2.0, 3.0]);
    assert_eq!(log.load, [4.0, 5.0, 6.0]);
    for (columns, what) in [
        (["motor=1", "load=4"], "there is no column 4: the log has 3"),
        (["motor=0", "load=3"], "there is no column 0: the log has 3"),
        (
            ["motor=2", "load=3"],
            "column 2 is the time, or holds no numbers; columns of values are 1, 3",
        ),
    ] {
        let error = of(&columns).unwrap_err().to_string();
        assert!(
            error.contains(what) && error.contains("every column"),
            "{error}"
        );
    }
}

#[test]
fn what_nobody_measures_is_refused_by_its_row() {
    let text = "t_s,motor_mm,load_mm\n0,1,4\n0.001,1e300,5\n0.002,3,6\n";
    let error = read_axis(text.as_bytes(), "log", &AxisOptions::default()).unwrap_err();
    let error = error.to_string();
    for part in [
        "line 3",
        "motor_mm",
        "1e300",
        "larger than anything measured",
    ] {
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn roles_that_names_tell() {
    let text = "# Sampling period is 1000000 ns\njoint.0.motor-pos-cmd;joint.0.motor-pos-fb;x-scale-pos\n1;2;3\n1;2;3\n1;2;3\n";
    let error = read_axis(text.as_bytes(), "log", &AxisOptions::default())
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("--column motor=joint.0.motor-pos-fb,unit=UNIT"),
        "{error}"
    );
    let told = options(&[
        "motor=joint.0.motor-pos-fb,unit=mm",
        "load=x-scale-pos,unit=mm",
        "command=joint.0.motor-pos-cmd,unit=inch",
    ]);
    let log = read_axis(text.as_bytes(), "log", &told).unwrap();
    assert_eq!(log.command, [25.4; 3]);
}

/// Two clocks, 0.2 and 1 ms: both come out at the slower one.
#[test]
fn clocks_are_brought_together() {
    let mut text = "Name;x\nFile;y\nStarttime of export;1\nEndtime of export;2\n\nName;ActPos;Name;Torque\nUnit;mm;Unit;Nm\n\n".to_owned();
    for row in 0..1000 {
        let t = 0.2 * f64::from(row);
        let slow = if row < 200 {
            format!("{};{}", row, 2 * row)
        } else {
            " ; ".to_owned()
        };
        text += &format!("{t:.1};{};{slow}\n", 3.0 * t);
    }
    let log = read_axis(text.as_bytes(), "log", &AxisOptions::default()).unwrap();
    assert_eq!(log.time_s.len(), 200);
    for (row, motor) in log.motor.iter().enumerate() {
        assert!((motor - 3.0 * row as f64).abs() < 1e-9);
    }
    assert!(says(&log, "columns have 2 clocks"));
}

#[test]
fn held_values_are_taken_once() {
    let mut text = "t_s,motor_mm\n".to_owned();
    for row in 0..3000 {
        let x = (f64::from(row / 30) * 0.05).sin();
        text += &format!("{},{x}\n", f64::from(row) * 1e-4);
    }
    let log = read_axis(text.as_bytes(), "log", &AxisOptions::default()).unwrap();
    assert_eq!(log.time_s.len(), 100);
    assert!(says(&log, "values are held for 30 rows"));
}

#[test]
fn wrapped_angles_are_added_up_and_jumps_are_cut_out() {
    let mut text = "t_s,motor_deg\n".to_owned();
    let mut cut = text.clone();
    for row in 0..2000 {
        let angle = 0.5 * f64::from(row) + 1e-3 * f64::from(row % 3);
        text += &format!("{},{}\n", f64::from(row) * 1e-3, angle.rem_euclid(360.0));
        let lost = if row < 500 { 0.0 } else { 17.0 };
        cut += &format!("{},{}\n", f64::from(row) * 1e-3, angle + lost);
    }
    let log = read_axis(text.as_bytes(), "log", &AxisOptions::default()).unwrap();
    assert!((log.motor.last().unwrap() - 999.5).abs() < 2e-3);
    assert!(says(&log, "wraps 2 times at 360"));
    let log = read_axis(cut.as_bytes(), "log", &AxisOptions::default()).unwrap();
    assert_eq!(log.time_s.len(), 1500);
    assert!(
        says(&log, "line 502: the motor's position jumps by 17"),
        "{:?}",
        log.said
    );
}

#[test]
fn rows_and_times_are_bounded() {
    let text: String = std::iter::once("t_s,motor_mm,load_mm\n".to_owned())
        .chain((0..100).map(|row| format!("{row},{row},x\n")))
        .collect();
    let options = AxisOptions {
        from_s: 10.0,
        to_s: 50.0,
        max_rows: 20,
        without: vec![Role::Load],
        ..AxisOptions::default()
    };
    let log = read_axis(text.as_bytes(), "log", &options).unwrap();
    assert_eq!((log.time_s[0], log.time_s.len()), (10.0, 20));
    assert!(says(&log, "the first 20 rows are taken"));
}

#[test]
fn a_log_may_have_uneven_rows() {
    let text = "t_s,motor_mm,load_mm,current_a\n0,0,0,0\n0.001,0,0,0\n0.003,0,0,0\n";
    let log = read_axis(text.as_bytes(), "log", &AxisOptions::default()).unwrap();
    assert_eq!(log.time_s, [0.0, 0.001, 0.003]);
}

/// A log without end, a row a millisecond.
struct Endless {
    row: u64,
    waiting: Vec<u8>,
    given: u64,
}

impl std::io::Read for Endless {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        while self.waiting.len() < buffer.len() {
            let row = self.row;
            let place = row % 1000;
            let text = format!("{:.3},{place},{place}\n", row as f64 * 1e-3);
            self.waiting.extend(text.as_bytes());
            self.row += 1;
        }
        let rest = self.waiting.split_off(buffer.len());
        buffer.copy_from_slice(&self.waiting);
        self.waiting = rest;
        self.given += buffer.len() as u64;
        assert!(self.given < 64 << 20, "it is read on and on");
        Ok(buffer.len())
    }
}

/// Of a log without end so many rows are held as are asked for, wherever they stand.
#[test]
fn rows_before_and_behind_those_that_are_taken_are_not_held() {
    let taken = |from_s: f64, max_rows: Option<usize>| {
        let defaults = AxisOptions::default();
        let options = AxisOptions {
            from_s,
            max_rows: max_rows.unwrap_or(defaults.max_rows),
            ..defaults
        };
        let endless = Endless {
            row: 0,
            waiting: b"t_s,motor_mm,load_mm\n".to_vec(),
            given: 0,
        };
        read_axis(std::io::BufReader::new(endless), "log", &options).unwrap()
    };
    let log = taken(1000.0, Some(500));
    assert_eq!((log.time_s.len(), log.time_s[0]), (500, 1000.0));
    assert!(log.time_s.capacity() < 2000 && log.motor.capacity() < 2000);
    let log = taken(f64::NEG_INFINITY, None);
    assert!(
        log.said
            .iter()
            .any(|said| said.contains("the first 200000 rows are taken"))
    );
    assert!(log.time_s.capacity() < 1 << 19);
}

#[test]
fn a_torque_in_lower_case_newton_metres_is_none_in_nanometres() {
    for name in ["torque_nm", "torque [nm]", "Torque (Nm)"] {
        let text = format!("t_s,motor_mm,{name}\n0,0,1.5\n0.001,0.1,2\n0.002,0.2,2.5\n");
        let log = read_axis(text.as_bytes(), "log", &AxisOptions::default()).unwrap();
        assert_eq!(log.drive.unwrap().values(), [1.5, 2.0, 2.5], "{name}");
    }
    let text = "t_s,motor_nm,torque_nm\n0,0,1\n0.001,1000,1\n0.002,2000,1\n";
    let log = read_axis(text.as_bytes(), "log", &AxisOptions::default()).unwrap();
    assert!((log.motor[1] - 1e-3).abs() < 1e-15);
}

#[test]
fn times_that_would_be_far_apart_need_a_unit() {
    let text = "time,motor_mm\n0,0\n1,0.1\n2,0.2\n3,0.3\n";
    let error = read_axis(text.as_bytes(), "log", &AxisOptions::default()).unwrap_err();
    let error = error.to_string();
    assert!(
        error.contains("its unit is not told, and its rows would be 1.000 s apart"),
        "{error}"
    );
    for (unit, worth) in [("ms", 1e-3), ("s", 1.0)] {
        let options = AxisOptions {
            columns: vec![format!("time=time,unit={unit}").parse().unwrap()],
            ..AxisOptions::default()
        };
        let log = read_axis(text.as_bytes(), "log", &options).unwrap();
        assert_eq!(log.time_s[3], 3.0 * worth);
    }
}

/// camonitor writes changes alone: a rest is no missing row.
#[test]
fn a_rest_in_a_record_of_changes_is_held() {
    let mut text = String::new();
    for tick in 0..60_i32 {
        // 2 s of motion, 2 s of rest, 2 s back; the last change of the rest is that of its beginning.
        let place = f64::from(tick.min(20) - (tick - 40).max(0));
        let stamp = format!("2026-03-20 10:00:{:02}.{}00000", tick / 10, tick % 10);
        for name in ["AX:MOTOR", "AX:LOAD"] {
            if !(21..=40).contains(&tick) {
                text += &format!("{name} {stamp} {place}\n");
            }
        }
    }
    let options = options(&["motor=AX:MOTOR,unit=mm", "load=AX:LOAD,unit=mm"]);
    let log = read_axis(text.as_bytes(), "log", &options).unwrap();
    assert_eq!((log.motor.len(), &log.motor), (60, &log.load));
    assert_eq!(&log.motor[18..24], [18.0, 19.0, 20.0, 20.0, 20.0, 20.0]);
    assert_eq!(&log.motor[38..43], [20.0, 20.0, 20.0, 19.0, 18.0]);
    assert!(says(&log, "40 values were held"), "{:?}", log.said);
}

/// A trace whose loop is closed over the scale: what is lost between motor and scale is no lag.
#[test]
fn the_command_of_another_encoder_is_left_out() {
    let trace = |names: &[&str]| {
        let mut text =
            "<traceSession version=\"01.00.03.02\">\n<traceData dataFrames=\"1\"><dataFrame>\n"
                .to_owned();
        for (index, name) in names.iter().enumerate() {
            text += &format!(
                "<dataSignal id=\"f{index}\" key=\"s{index}\" name=\"/Nck/!SD/nckServoData{name}64 [u1, 1]\" unitsType=\"posn\" interval=\"0.002\" datapointCount=\"4\"/>\n"
            );
        }
        for row in 0..4 {
            text += &format!("<rec time=\"{}\"", 0.002 * f64::from(row));
            for index in 0..names.len() {
                text += &format!(" f{index}=\"{}\"", 10 * index + row as usize);
            }
            text += "/>\n";
        }
        text + "</dataFrame></traceData></traceSession>\n"
    };
    let of = |text: &str, columns: &[&str]| {
        read_axis(text.as_bytes(), "log.xml", &options(columns)).unwrap()
    };
    let [first, second] = ["CmdPos1stEnc", "CmdPos2ndEnc"];
    let positions = ["ActPos1stEnc", "ActPos2ndEnc"];
    let log = of(&trace(&[&positions[..], &[second]].concat()), &[]);
    assert!(log.command.is_empty() && says(&log, "closed over another encoder"));
    assert!(!says(&log, "taken for the command"), "{:?}", log.said);
    // of two the motor's
    let log = of(&trace(&[&positions[..], &[second, first]].concat()), &[]);
    assert_eq!(log.command, [30.0, 31.0, 32.0, 33.0]);
    // the scale as what is looked at, and what the user says
    let scale = "motor=/Nck/!SD/nckServoDataActPos2ndEnc64 [u1, 1]";
    let text = trace(&[&positions[..], &[second]].concat());
    assert_eq!(of(&text, &[scale]).command, [20.0, 21.0, 22.0, 23.0]);
    let told = "command=/Nck/!SD/nckServoDataCmdPos2ndEnc64 [u1, 1]";
    assert_eq!(of(&text, &[told]).command, [20.0, 21.0, 22.0, 23.0]);
}

#[test]
fn what_a_log_cannot_have_is_not_asked_for() {
    let text = "#time,accel_x,accel_y,accel_z\n0,1,2,3\n0.001,1,2,3\n0.002,1,2,3\n";
    let error = read_axis(text.as_bytes(), "log", &options(&[])).unwrap_err();
    let error = error.to_string();
    assert!(
        error.contains("an accelerometer's log has no motor"),
        "{error}"
    );
    assert!(!error.contains("--column"), "{error}");
    // a motor's angle beside a length: how far the axis goes for it is told as a scale
    let text = "t_s,motor_deg,load_mm\n0,0,0\n0.001,36,1\n0.002,72,2\n";
    let error = read_axis(text.as_bytes(), "log", &options(&[])).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("--column motor=motor_deg,unit=mm,scale="),
        "{error}"
    );
    let scaled = options(&["motor=motor_deg,unit=mm,scale=0.0277777777777777777"]);
    let log = read_axis(text.as_bytes(), "log", &scaled).unwrap();
    assert!((log.motor[2] - 2.0).abs() < 1e-12 && log.load[2] == 2.0);
}

/// The angle of a motor that wraps at its own turn, as a position of the axis.
#[test]
fn a_scaled_angle_wraps_at_its_own_turn() {
    let rows = |name: &str| {
        let mut text = format!("t_s,{name}\n");
        for row in 0..900 {
            let angle = (f64::from(row) * 7.0) % 360.0;
            text += &format!("{},{angle}\n", 0.001 * f64::from(row));
        }
        text
    };
    for (name, unit, scale, unit_out) in [
        ("motor_deg", "deg", 0.013_888_888_888_888_9, "deg"),
        ("motor_deg", "mm", 0.027_777_777_777_777_7, "mm"),
        ("motor_arcsec", "arcsec", 1.0, "deg"),
    ] {
        let spec = format!("motor={name},unit={unit},scale={scale}");
        let log = read_axis(rows(name).as_bytes(), "log", &options(&[&spec])).unwrap();
        assert_eq!(log.unit.symbol, unit_out);
        if unit != "arcsec" {
            let end = 899.0 * 7.0 * scale;
            assert!(
                (log.motor[899] - end).abs() < 1e-9,
                "{unit}: {} {end}",
                log.motor[899]
            );
            assert!(says(&log, "wraps 17 times"), "{:?}", log.said);
        }
    }
}
