//! Tables of any kind: what is found of their layout.

use crate::{read, whole, with_period};
use lostmotion_logs::ReadOptions;

#[test]
fn separators_decimal_marks_and_units_are_found_and_said() {
    let rows = [
        ["0.0", "1.5", "-2"],
        ["0.5", "2.5", "-3"],
        ["1.0", "3.5", "-4"],
    ];
    for (separator, name) in [
        ("\t", "tabs"),
        (";", "semicolons"),
        (",", "commas"),
        ("  ", "blanks"),
    ] {
        for comma in [false, true] {
            if comma && separator == "," {
                continue;
            }
            let mut text = ["time_ms", "motor_mm", "current_a"].join(separator);
            for row in rows {
                let row = row.join(separator);
                text += &format!("\n{}", if comma { row.replace('.', ",") } else { row });
            }
            let log = read(&text);
            let mark = if comma { "commas" } else { "points" };
            let said = format!("a table with {name} between cells and decimal {mark}");
            assert!(log.says(&said), "{separator:?} {comma}: {:?}", log.said);
            assert_eq!(log.names, ["motor_mm", "current_a"]);
            let last = log.rows.last().unwrap();
            assert_eq!(
                (last.line, last.time_s, last.values.as_slice()),
                (4, 1e-3, &[3.5, -4.0][..])
            );
        }
    }
}

#[test]
fn headers_may_be_comments_come_late_have_units_below_or_lack() {
    let log = read("# made by hand\n#t_s,a,b\n0,1,2\n# a remark\n1,3,4\n\n2,5,6\n");
    assert_eq!(
        (log.names.as_slice(), log.rows.len()),
        (&["a".to_owned(), "b".to_owned()][..], 3)
    );
    let log = read("Machine: X\nDate: today\n\nTime,Pos,\"I, motor\"\ns,mm,A\n0,1,2\n1,3,4\n");
    assert_eq!(log.names, ["Pos", "I, motor"]);
    assert!(log.says("names in line 4, units in line 5"));
    let log = with_period("1,2\n3,4\n5,6\n");
    assert_eq!(log.names, ["column1", "column2"]);
    assert!(log.says("there is no header") && log.says("1 ms apart"));
    // a separator at the end of each row
    let log = read("t_s;a;\n0;1;\n1;2;\n");
    assert_eq!(log.names, ["a"]);
}

#[test]
fn times_may_be_stamps_or_times_of_day() {
    let log = read("time,a\n2026-01-31 23:59:59.5,1\n2026-02-01 00:00:00.25,2\n");
    assert_eq!(log.rows[1].time_s, 0.75);
    let log = read("time;a\n23:59:59.5;1\n00:00:00.25;2\n");
    assert_eq!(log.rows[1].time_s - log.rows[0].time_s, 0.75);
}

#[test]
fn texts_in_columns_that_nobody_asks_for_do_no_harm() {
    let options = ReadOptions {
        time_column: Some("3".to_owned()),
        ..ReadOptions::default()
    };
    let error = whole(b"state,a,ticks\nrun,1,0\nrun,x,1\n", &options)
        .err()
        .unwrap();
    assert!(error.contains("line 2, column `state`"), "{error}");
}
