//! Tables: written, read back, and refused with the place of what is wrong.

use lostmotion_base::{AxisId, AxisSet, BlockRef, Clock, Coords, Span};
use lostmotion_drive::config::{AxisUnit, Interpolator};
use lostmotion_drive::{AxisSample, Engagement, Reference, Setpoint};
use lostmotion_logs::{AxisOptions, DriveSignal, read_axis};
use lostmotion_plan::{Heeds, Sample};
use lostmotion_report::ReadError;
use lostmotion_report::csv::{AxisTraceWriter, PlanWriter, SetpointReader, SetpointSource};
use proptest::prelude::*;

fn sample(tick: u64, x: f64, c: f64) -> Sample {
    let mut position = Coords::xyz(x, 0.0, 0.0);
    position[AxisId::C] = c;
    Sample {
        tick,
        position,
        velocity: Coords::ZERO,
        acceleration: Coords::ZERO,
        segment: 0,
        s: 0.0,
        path_speed: 0.0,
        feed_part: 0.0,
        chord_part: 0.0,
        heeds: Heeds::Feed,
        tool_mm: [0.0; 3],
        block: BlockRef {
            span: Span {
                line: 7,
                ..Span::default()
            },
            call_stack: 0,
        },
    }
}

fn plan(samples: &[Sample]) -> String {
    let axes: AxisSet = [AxisId::X, AxisId::C].into_iter().collect();
    let mut writer = PlanWriter::new(
        Vec::new(),
        axes,
        [AxisId::A, AxisId::B, AxisId::C].into_iter().collect(),
        Clock::CNC,
    )
    .unwrap();
    writer.push(samples).unwrap();
    String::from_utf8(writer.finish().unwrap()).unwrap()
}

#[test]
fn a_plan_has_a_row_a_millisecond() {
    let text = plan(&[sample(0, 0.0, 0.0), sample(1, -1.25, std::f64::consts::PI)]);
    assert_eq!(
        text,
        "t_s,x_mm,c_deg,line\n\
         0.000,0.000000000000,0.000000000000,7\n\
         0.001,-1.250000000000,180.000000000000,7\n"
    );
}

#[test]
fn an_axis_trace_is_in_the_axis_own_unit_and_leaves_missing_estimates_empty() {
    let trace = AxisSample {
        reference: Reference {
            position: 2.0,
            velocity: 1.0,
            acceleration: -1.0,
        },
        motor_position: 1.0,
        load_position: 0.5,
        current: 3.0,
        torque: 0.25,
        // 1.5 mm for a radian: 0.375 N m are 250 N
        shaft_torque: 0.375,
        engagement: Engagement::Negative,
        gap_angle_estimate: f64::NAN,
        inertia_estimate: 0.001_89,
        stiffness_estimate: 2000.0,
        damping_estimate: f64::NAN,
        ..AxisSample::default()
    };
    let mut writer = AxisTraceWriter::new(Vec::new(), AxisUnit::Mm, 1.5, Clock::SERVO).unwrap();
    writer.push(3, &trace).unwrap();
    let text = String::from_utf8(writer.finish().unwrap()).unwrap();
    let mut lines = text.lines();
    assert_eq!(
        lines.next(),
        Some(
            "t_s,reference_mm,reference_velocity_mm_s,reference_acceleration_mm_s2,motor_mm,motor_velocity_mm_s,load_mm,\
             load_velocity_mm_s,current_a,torque_nm,engagement,gap_estimate_mm,inertia_estimate_kgm2,engagement_estimate,\
             stiffness_estimate_nm_per_rad,damping_estimate_nm_s_per_rad,shaft_force_n"
        )
    );
    assert_eq!(
        lines.next(),
        Some(
            "0.000750,3.000000000000,1.500000000,-1.500000000,1.500000000000,0.000000000,0.750000000000,0.000000000,\
             3.000000000,0.250000000,-1,,0.001890000000,0,2000.000000000,,250.000000000"
        )
    );
}

#[test]
fn a_trace_is_a_log() {
    let mut writer = AxisTraceWriter::new(Vec::new(), AxisUnit::Deg, 2.0, Clock::SERVO).unwrap();
    for tick in 0..5 {
        let position = tick as f64 * 0.125;
        writer
            .push(
                tick,
                &AxisSample {
                    motor_position: position,
                    load_position: -position,
                    current: 0.5,
                    ..AxisSample::default()
                },
            )
            .unwrap();
    }
    let trace = writer.finish().unwrap();
    let log = read_axis(trace.as_slice(), "log", &AxisOptions::default()).unwrap();
    assert_eq!(log.unit.symbol, "deg");
    assert_eq!(log.time_s, [0.0, 250e-6, 500e-6, 750e-6, 1e-3]);
    assert_eq!(log.motor, [0.0, 0.25, 0.5, 0.75, 1.0]);
    assert_eq!(log.load, [0.0, -0.25, -0.5, -0.75, -1.0]);
    assert_eq!(log.drive, Some(DriveSignal::Current(vec![0.5; 5])));
}

fn setpoints(text: &str) -> Result<Vec<f64>, ReadError> {
    SetpointReader::new(
        text.as_bytes(),
        "in.csv",
        SetpointSource::Position,
        Clock::CNC,
    )?
    .map(|setpoint| Ok(setpoint?.position))
    .collect()
}

#[test]
fn setpoints_with_extra_columns_marks_and_line_ends_are_read() {
    for text in [
        "\u{feff}note,t_s, position\nx,0.000, 1.5\n,0.001,-2e-3\n",
        "t_s,position\r\n5.000,1.5\r\n5.001,-0.002\r\n",
    ] {
        assert_eq!(setpoints(text).unwrap(), [1.5, -0.002]);
    }
    let reader = SetpointReader::new(
        "t_s,position_rad\n0,1\n".as_bytes(),
        "in",
        SetpointSource::Position,
        Clock::CNC,
    )
    .unwrap();
    assert_eq!(reader.unit(), Some(AxisUnit::Rad));
    let reader = SetpointReader::new(
        "t_s,x_mm\n0,1\n".as_bytes(),
        "in",
        SetpointSource::Column("x_mm"),
        Clock::CNC,
    )
    .unwrap();
    assert_eq!(reader.unit(), Some(AxisUnit::Mm));
}

#[test]
fn setpoints_may_bring_velocity_and_acceleration() {
    let text = "t_s,acceleration,position,velocity\n0,3,1,2\n0.00025,6,4,5\n";
    let clock = Clock::from_nanos(250_000).unwrap();
    let reader =
        SetpointReader::new(text.as_bytes(), "in", SetpointSource::Position, clock).unwrap();
    assert!(reader.serves(Interpolator::QuinticHermite));
    let read: Vec<Setpoint> = reader.map(Result::unwrap).collect();
    assert_eq!(
        read,
        [
            Setpoint::moving(1.0, 2.0, 3.0),
            Setpoint::moving(4.0, 5.0, 6.0)
        ]
    );
    let positions = SetpointReader::new(
        "t_s,position\n".as_bytes(),
        "in",
        SetpointSource::Position,
        clock,
    )
    .unwrap();
    assert!(
        positions.serves(Interpolator::CatmullRom)
            && !positions.serves(Interpolator::CompensatedBSpline)
    );
}

/// Every refusal, as people see it.
#[test]
fn refusals_name_the_place_the_value_and_what_to_do() {
    let cases = [
        ("empty", ""),
        ("header only", "t_s,position\n"),
        ("no time", "time,position\n0,1\n"),
        ("no position", "t_s,pos\n0,1\n"),
        ("two positions", "t_s,position_mm,position_deg\n0,1,2\n"),
        ("not a number", "t_s,position\n0,1\n0.001,abc\n"),
        ("nan", "t_s,position\n0,NaN\n"),
        ("infinite", "t_s,position\n0,-inf\n"),
        ("empty cell", "t_s,position\n0,\n"),
        ("backwards", "t_s,position\n0,1\n0.001,2\n0.000,3\n"),
        ("twice", "t_s,position\n0,1\n0,2\n"),
        ("2 ms", "t_s,position\n0,1\n0.002,2\n"),
        (
            "missing row, CRLF",
            "t_s,position\r\n0,1\r\n0.001,2\r\n0.003,2\r\n",
        ),
        ("ragged", "t_s,position\n0,1\n0.001\n"),
        ("binary", "\u{7f}ELF\u{2}\u{1}\u{1}\0\0,\0\n"),
    ];
    let mut out = String::new();
    for (what, text) in cases {
        let error = setpoints(text).expect_err(what);
        out.push_str(&format!("== {what}\n{error}\n"));
    }
    let latin1 = SetpointReader::new(
        &b"t_s,pos\xe9\n"[..],
        "in.csv",
        SetpointSource::Position,
        Clock::CNC,
    )
    .err()
    .unwrap();
    out.push_str(&format!("== not UTF-8\n{latin1}\n"));
    insta::assert_snapshot!(out);
}

#[test]
fn places_are_those_of_the_file() {
    let told = |text: &[u8]| {
        SetpointReader::new(text, "in.csv", SetpointSource::Position, Clock::CNC)
            .and_then(Iterator::collect::<Result<Vec<Setpoint>, _>>)
            .unwrap_err()
            .to_string()
    };
    // quotes around cells and within them, a byte order mark, comments and blank lines before
    for (text, byte) in [
        (&b"t_s,pos\xe9\n"[..], 0xe9),
        (b"\"t_s\",\"pos\xe9\"\n", 0xe9),
        (b"\"t\"\"_s\",x,\"pos\xe9\"\n", 0xe9),
        (b"\xef\xbb\xbf\"t_s\",pos\xe9\n", 0xe9),
        (b"# made by \"hand\"\n\n\"t_s\",\"a,b\",pos\xe9\n", 0xe9),
        (b"\"t_s\",\"p\x02\"\n", 0x02),
    ] {
        let offset = text.iter().position(|found| *found == byte).unwrap();
        let said = told(text);
        assert!(
            said.contains(&format!("(byte {byte:#04x} at offset {offset})")),
            "{said}"
        );
    }
    for (text, line) in [
        ("# note\nt_s,pos\n0,1\n", 2),
        ("t_s,position\n0,1\n# note\n\n0.001,x\n", 5),
        ("t_s,position\n0,1\n# note\n0.001,x", 4),
        ("t_s,position,\"a\nb\"\n0,1,\n", 1),
        ("t_s,position,note\n0,1,\"a\nb\"\n0.001,2\n", 4),
        ("t_s,position,note\n0,x,\"a\nb\"\n", 2),
    ] {
        let said = told(text.as_bytes());
        assert!(said.starts_with(&format!("in.csv, line {line}")), "{said}");
    }
}

#[test]
fn columns_of_one_name_and_numbers_of_no_machine_are_refused() {
    let said = setpoints("t_s,position,position\n0,1,2\n").unwrap_err();
    assert_eq!(
        said.to_string(),
        "in.csv, line 1: there are two columns `position`; rename or remove one"
    );
    assert!(setpoints("t_s,position,velocity,velocity\n0,1,2,2\n").is_err());
    // one that is not read may stand there twice
    assert_eq!(setpoints("t_s,position,,\n0,1,,\n").unwrap().len(), 1);
    let said = setpoints("t_s,position\n0,1e300\n").unwrap_err();
    assert!(
        said.to_string().contains("`1e300` is beyond 1e13"),
        "{said}"
    );
}

#[test]
fn a_reader_ends_after_its_first_error() {
    let mut reader = SetpointReader::new(
        "t_s,position\n0,x\n0.001,1\n".as_bytes(),
        "in",
        SetpointSource::Position,
        Clock::CNC,
    )
    .unwrap();
    assert!(reader.next().unwrap().is_err());
    assert!(reader.next().is_none());
}

proptest! {
    /// A plan read back as setpoints gives its positions to 1e-12 mm.
    #[test]
    fn plans_round_trip(positions in prop::collection::vec(-2000.0..2000.0_f64, 1..50), first in 0u64..10_000_000) {
        let samples: Vec<Sample> = positions.iter().zip(first..).map(|(x, tick)| sample(tick, *x, 0.0)).collect();
        let text = plan(&samples);
        let read: Result<Vec<Setpoint>, ReadError> =
            SetpointReader::new(text.as_bytes(), "plan", SetpointSource::Column("x_mm"), Clock::CNC).unwrap().collect();
        for (read, written) in read.unwrap().iter().map(|setpoint| setpoint.position).zip(&positions) {
            prop_assert!((read - written).abs() < 1.5e-12);
        }
    }

    /// No bytes make a reader panic.
    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200), header: bool) {
        let mut input = if header { b"t_s,position\n".to_vec() } else { Vec::new() };
        input.extend(bytes);
        if let Ok(reader) = SetpointReader::new(input.as_slice(), "in", SetpointSource::Position, Clock::CNC) {
            let _ = reader.collect::<Result<Vec<Setpoint>, ReadError>>();
        }
    }
}
