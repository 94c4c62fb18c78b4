//! Every format with its quirks, on texts written for it.

use crate::{read, whole, with_period};
use lostmotion_logs::{ReadOptions, Row};

fn row(line: u64, time_s: f64, group: usize, values: &[f64]) -> Row {
    Row {
        line,
        time_s,
        group,
        part: 0,
        values: values.to_vec(),
    }
}

#[test]
fn halscope_up_to_2_8_alternates_names_and_values() {
    let text = "Sampling period is 500000 nSec \n\nx.fb +1,25000000000000 x.fb -0,50000000000000 \n\
                x.fb +1,50000000000000 x.fb -0,25000000000000 \nx.fb +0,00000000000000 x.fb +0,00000000000000 \n";
    let log = read(text);
    assert_eq!(log.format, "HALscope, LinuxCNC up to 2.8");
    assert_eq!(log.names, ["x.fb", "x.fb#2"]);
    // the last row is one too many
    assert_eq!(
        log.rows,
        [
            row(3, 0.0, 0, &[1.25, -0.5]),
            row(4, 5e-4, 0, &[1.5, -0.25])
        ]
    );
    assert!(log.says("decimal commas") && log.says("`x.fb` is there more than once"));
    let points = read(&text.replace(',', ".").replace("nSec", "ns"));
    assert_eq!(points.rows, log.rows);
    assert!(points.says("decimal points"));
}

#[test]
fn halscope_2_9_and_2_10_have_names_in_line_2() {
    let log = read("# Sampling period is 1000000 ns\na;[CSV] b\n1.0;2.0\n3.0;4.0\n\n");
    assert_eq!(
        (log.format.as_str(), log.names.len()),
        ("HALscope, LinuxCNC 2.9", 2)
    );
    assert_eq!(log.names[1], "b");
    assert_eq!(
        log.rows,
        [row(3, 0.0, 0, &[1.0, 2.0]), row(4, 1e-3, 0, &[3.0, 4.0])]
    );
    // the display settings are printed in the locale of the screen
    let log = read(
        "# Sampling period is 1000000 ns\na;b\n# Position: 0,5;0,5\n# Scale: 0;-1\n1.0;2.0\n3.0;4\n",
    );
    assert_eq!(log.format, "HALscope, LinuxCNC 2.10");
    assert_eq!(log.rows.len(), 2);
    let cut = read("# Sampling period is 1000000 ns\na;b\n1.0;2.0\n3.0");
    assert_eq!(cut.rows.len(), 1);
    assert!(cut.says("line 4 is cut"));
}

#[test]
fn halsampler_counts_samples_or_rows() {
    let tagged = with_period("7 0.5 1 \n8 0.6 0 \n9 0.7 1 \n");
    assert_eq!(tagged.names, ["pin1", "pin2"]);
    assert!(tagged.says("taken for the number of the sample"));
    // a column that stands still somewhere counts nothing
    let untagged = with_period("7 0.5 1 \n8 0.6 0 \n8 0.7 1 \n");
    assert_eq!(untagged.names, ["pin1", "pin2", "pin3"]);
    assert!(untagged.says("no column counts"));
    let options = ReadOptions {
        period_s: Some(1e-3),
        tagged: Some(true),
        ..ReadOptions::default()
    };
    let tagged = whole(
        b"overrun\n7 0.5 1 \n8 0.6 0 \noverrun\n12 0.7 1 \n",
        &options,
    )
    .unwrap();
    let times: Vec<f64> = tagged.rows.iter().map(|row| row.time_s).collect();
    assert_eq!(times, [7e-3, 8e-3, 12e-3]);
    assert!(tagged.says("3 samples are missing") && tagged.says("`overrun` stands 2 times"));
    let found = with_period("overrun\n4294967294 0.5 \n4294967295 0.6 \n0 0.7 \n1 0.8 \n");
    assert!(found.rows.len() == 4);
    let wrapped = whole(b"4294967294 0.5 \n4294967295 0.6 \n0 0.7 \n", &options).unwrap();
    assert_eq!(wrapped.rows[2].time_s, 4_294_967_296.0 * 1e-3);
    // numbers that begin anew are another recording
    let anew = whole(b"100 0.5 \n101 0.6 \n5 0.7 \n", &options).unwrap();
    assert_eq!(anew.rows[2].part, 1);
    let untagged = with_period("0.5 1 \n0.6 1 \noverrun\n0.9 1 \n1.0");
    assert_eq!(untagged.rows[2].part, 1);
    assert!(untagged.says("line 5 is cut"));
    let error = whole(b"0.5 1 \n0.6 1 \n", &ReadOptions::default())
        .err()
        .unwrap();
    assert!(error.contains("--period-ms"), "{error}");
}

const SCOPE: &str = "Name\tdemo\nFile\tC:\\demo.csv\nStarttime of export\t132959733843760000\tMontag, 2. Mai 2022\t15:56:24.376\nEndtime of export\t132959733853750000\tx\ty\n\n\n\
Name\tAct Pos\tSetPos\tName\tTorque\nData-Type\tREAL64\tREAL64\tData-Type\tUINT64\nSampleTime[ms]\t1\t1\tSampleTime[ms]\t2,5\nUnit\tmm\tmm\tUnit\tNm\nUnit ScaleFactor\t1\t-10\tUnit ScaleFactor\t1\n\n\
0\t0.5\t0.25\t-3\t9\n1\t0.6\t0.35\t2\t8\n2\t0.7\t0.45\n3\t0.8\t0.55\t \t \nEOF\nnot data\n";

#[test]
fn twincat_scope_has_groups_with_their_own_times() {
    for separator in ["\t", ";", ":"] {
        let text = SCOPE.replace('\t', separator);
        let log = read(&text);
        assert_eq!(log.format, "TwinCAT Scope");
        assert_eq!(log.names, ["Act Pos", "SetPos", "Torque"]);
        assert_eq!(log.rows.len(), 6, "{separator:?}");
        assert_eq!(log.rows[0], row(13, 0.0, 0, &[0.5, 0.25]));
        assert_eq!(log.rows[1], row(13, -3e-3, 1, &[9.0]));
        assert_eq!(log.rows[5], row(16, 3e-3, 0, &[0.8, 0.55]));
        assert!(log.says("`SetPos` is shown with Unit ScaleFactor -10"));
        assert!(log.says("`Torque` has 64 bits"));
    }
    // decimal commas in the data, too; windows line ends; a byte order mark
    let text = SCOPE.replace("0.", "0,").replace('\n', "\r\n");
    assert_eq!(read(&format!("\u{feff}{text}")).rows[5].values, [0.8, 0.55]);
    // blanks: the names are longer than the data, the symbols are not
    let blanks = SCOPE
        .replace(
            "Unit\t",
            "SymbolName\ta.Pos\ta.Set\tSymbolName\ta.Trq\nUnit\t",
        )
        .replacen("\t \t \n", "\n", 1)
        .replace('\t', " ");
    let log = read(&blanks);
    assert_eq!(log.names, ["a.Pos", "a.Set", "a.Trq"]);
    assert_eq!(log.rows.len(), 6);
    // with commas the header's decimal commas break its rows; the names do not
    let log = read(&SCOPE.replace('\t', ","));
    assert_eq!((log.rows.len(), log.names[2].as_str()), (6, "Torque"));
}

#[test]
fn twincat_times_may_count_since_1601() {
    let text = "Name;x;\nFile;y\nStarttime of export;1\nEndtime of export;2\n\nName;a\n\n\
                133238090039920001;1,5\n133238090039930002;2,5\n133238090039940003;";
    let log = read(text);
    assert_eq!(log.rows.len(), 2);
    assert_eq!(log.rows[1].time_s, 10_001.0 * 1e-7);
    assert!(log.says("line 10 is cut"));
}

const TRACE: &str = r#"<?xml version="1.0" encoding="utf-8" ?>
<traceSession version="01.00.03.02">
<traceCaptureSetup_V20><signalSettings>
 <signal key="s1" unitsType="posn" name="/Nck/!SD/nckServoDataActPos1stEnc64 [u1, 1]"/>
 <signal key="s2" unitsType="torque" name="/Nck/!SD/nckServoDataCmdTorque64 [u1, 1]"/>
</signalSettings></traceCaptureSetup_V20>
<traceCaptureSetup><signalSettings>
 <signal key="s1" unitsType="posn" name="/Nck/!SD/nckServoDataActPos1stEnc64 [u1, 1]"/>
 <signal key="s2" unitsType="torque" name="/Nck/!SD/nckServoDataCmdTorque64 [u1, 1]"/>
</signalSettings></traceCaptureSetup>
<traceData dataFrames="1"><dataFrame>
 <frameHeader dropOuts="0" startTime="2026-01-01T00:00:00.000Z"/>
 <dataSignal key="s2" id="f2" unitsType="611DTime1" name="/Nck/!SD/nckServoDataCmdTorque64 [u1, 1]" interval="0.004" datapointCount="3"/>
 <dataSignal key="s1" id="f1" unitsType="posn" name="/Nck/!SD/nckServoDataActPos1stEnc64 [u1, 1]" interval="0.002" datapointCount="5"/>
 <dataSignal key="s3" id="f3" unitsType="posn" name="empty" interval="0.002" datapointCount="0"/>
 <rec time="0.000000" f1="1.5" f2="-2.0"/>
 <rec time="0.002000" f1="1.6"/>
 <rec time="0.008000" f1="1.7"/>
</dataFrame></traceData></traceSession>
"#;

#[test]
fn sinumerik_records_list_what_changed() {
    let log = read(TRACE);
    assert_eq!(log.format, "Sinumerik trace");
    assert_eq!(log.names.len(), 2);
    let of = |group| -> Vec<(f64, f64)> {
        let rows = log.rows.iter().filter(|row| row.group == group);
        rows.map(|row| ((row.time_s * 1e6).round() / 1e6, row.values[0]))
            .collect()
    };
    assert_eq!(
        of(0),
        [
            (0.0, 1.5),
            (0.002, 1.6),
            (0.004, 1.6),
            (0.006, 1.6),
            (0.008, 1.7)
        ]
    );
    assert_eq!(of(1), [(0.0, -2.0), (0.004, -2.0), (0.008, -2.0)]);
    assert!(log.says("signal f2 has the unit `611DTime1`, but `torque` in the setup"));
    assert!(log.says("signal f3 has no points"));
    assert!(log.says("2 times have no record"));
    // where records were lost nothing is filled in
    let lost = read(&TRACE.replace("dropOuts=\"0\"", "dropOuts=\"4\""));
    assert_eq!(lost.rows.iter().filter(|row| row.group == 0).count(), 3);
    // two frames of the same signals are two recordings
    let frame = TRACE
        .split("<dataFrame>")
        .nth(1)
        .unwrap()
        .split("</dataFrame>")
        .next()
        .unwrap();
    let two = TRACE.replace(
        "</traceData>",
        &format!("<dataFrame>{frame}</dataFrame></traceData>"),
    );
    assert_eq!(
        read(&two)
            .rows
            .iter()
            .filter(|row| row.part == 1 && row.group == 0)
            .count(),
        5
    );
}

#[test]
fn tncscope_has_curves_in_columns() {
    let text = "%TNCscopeNT data file\r\n% \r\n%[GLOBAL]\r\n%VERSION=2.0\r\n%CONTROL=iTNC530\r\n% \r\n%[CURVE1]\r\n%NAME=s soll/X\r\n%DIMENSION=mm\r\n%COUNT=3\r\n%COLUMN=2\r\n% \r\n\
                %[CURVE2]\r\n%NAME=DSP/X\r\n%DIMENSION=id(217)\r\n%COUNT=3\r\n%COLUMN=1\r\n% \r\n%[DATA]\r\n 0.0e+000;  1.0e+000; -2.5e-001; \r\n 3.0e+003;  2.0e+000; -3.5e-001; \r\n";
    let log = read(text);
    assert_eq!(log.format, "Heidenhain TNCscope");
    assert_eq!(log.names, ["DSP/X", "s soll/X"]);
    assert_eq!(
        log.rows,
        [
            row(20, 0.0, 0, &[1.0, -0.25]),
            row(21, 3e-3, 0, &[2.0, -0.35])
        ]
    );
    assert!(log.says("`id(217)`") && log.says("the header promises 3 rows; there are 2"));
}

#[test]
fn camonitor_has_a_stamp_a_line() {
    let text = "AX:POS                         2026-03-20 23:59:59.750000 1.25\nAX:CUR                         2026-03-20 23:59:59.800000 -3 HIGH MINOR\n\
                AX:GONE                        *** Not connected (PV not found)\nAX:POS                         2026-03-21 00:00:00.250000 1.5\nAX:CUR                         2026-03-21 00:00:01.0";
    let log = read(text);
    assert_eq!(log.format, "EPICS camonitor");
    assert_eq!(log.names, ["AX:POS", "AX:CUR"]);
    assert_eq!(log.rows.len(), 3);
    assert_eq!(
        (log.rows[2].group, log.rows[2].time_s, log.rows[2].values[0]),
        (0, 0.5, 1.5)
    );
    assert!(log.says("1 lines tell of a lost connection") && log.says("line 5 is cut"));
}

#[test]
fn accelerometers_of_printers() {
    let log =
        read("#time,accel_x,accel_y,accel_z\n12.5,1.0,2.0,9806.65\n12.500312,1.5,2.0,9806.65\n");
    assert_eq!(
        (log.format.as_str(), log.rows.len()),
        ("Klipper accelerometer", 2)
    );
    let log = read("Sample,X,Y,Z\n0,0.1,0.2,1.0\n1,0.1,0.2,1.0\nRate 1250, overflows 2\n");
    assert_eq!((log.rows[1].time_s, log.scale_s), (1.0, 8e-4));
    assert!(log.says("2 overflows"));
}
