//! Sheets of a ballbar: columns, units, senses, and what is refused.

use lostmotion_logs::{BallbarLog, BallbarOptions, read_ballbar};

fn read(text: &str, columns: &[&str]) -> Result<BallbarLog, String> {
    let options = BallbarOptions {
        columns: columns.iter().map(|spec| spec.parse().unwrap()).collect(),
        ..BallbarOptions::default()
    };
    read_ballbar(text.as_bytes(), "sheet", &options).map_err(|error| error.to_string())
}

/// Rows of angles in tenths of a degree with a radius of 100 mm.
fn rows(header: &str, tenths: impl Iterator<Item = i32>) -> String {
    let rows: Vec<String> = tenths
        .map(|tenth| {
            format!(
                "{:.1},{:.4}\n",
                f64::from(tenth) / 10.0,
                100.0 + f64::from(tenth % 10) * 1e-3
            )
        })
        .collect();
    format!("{header}\n{}", rows.concat())
}

#[test]
fn one_sense_and_both_in_one_file() {
    let one = read(&rows("angle_deg,radius_mm", -180..3780), &[]).unwrap();
    assert!(!one.is_deviation && one.senses.len() == 1 && one.senses[0].len() == 3960);
    // There and back, with a rest where it turns round.
    let there_and_back = (0..3600)
        .chain(std::iter::repeat_n(3600, 50))
        .chain((0..3600).rev());
    let both = read(&rows("angle_deg,radius_mm", there_and_back), &[]).unwrap();
    assert_eq!(both.senses.len(), 2);
    let turn = |index: usize| both.senses[index].last().unwrap().0 - both.senses[index][0].0;
    assert!(turn(0) > 6.2 && turn(1) < -6.2);
    // Angles that begin anew at a turn go on.
    let wrapped = read(
        &rows("angle_deg,radius_mm", (0..7200).map(|tenth| tenth % 3600)),
        &[],
    )
    .unwrap();
    let last = wrapped.senses[0].last().unwrap().0;
    assert!((last - 719.9_f64.to_radians()).abs() < 1e-9);
}

#[test]
fn columns_by_name_number_unit_and_sign() {
    let text = rows("phi,dr", 0..3600);
    assert!(
        read(&text, &[])
            .unwrap_err()
            .contains("the unit of `phi`, the angle, is not told")
    );
    let told = read(&text, &["angle=phi,unit=deg", "deviation=2,unit=um,sign=-"]).unwrap();
    assert!(told.is_deviation && (told.senses[0][1].1 + 0.100_001).abs() < 1e-9);
    // A sheet with both: the radius is taken.
    let both = "angle_deg,radius_nominal_mm,radius_measured_mm,deviation_mm\n".to_owned()
        + &(0..360)
            .map(|deg| format!("{deg},100,100.004,0.004\n"))
            .collect::<String>();
    let found = read(&both, &[]).unwrap();
    assert!(!found.is_deviation && (found.senses[0][0].1 - 100.004).abs() < 1e-12);
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let refused = |text: &str, columns: &[&str], part: &str| {
        let error = read(text, columns).unwrap_err();
        assert!(error.contains(part), "{error}");
    };
    let good = rows("angle_deg,radius_mm", 0..3600);
    refused(
        &rows("angle_deg,b_mm", 0..3600),
        &[],
        "no column is known to be the radius or the deviation; the columns are: angle_deg, b_mm",
    );
    refused(
        &rows("a,radius_mm", 0..3600),
        &[],
        "no column is known to be the angle",
    );
    refused(&good, &["motor=1"], "this is a ballbar's sheet");
    refused(
        &good,
        &["angle=2", "radius=1"],
        "`radius_mm`, the angle, is in mm",
    );
    refused(&rows("angle_deg,radius_mm", 0..30), &[], "30 rows of data");
    refused(
        &rows("angle_deg,radius_mm", (0..100).map(|n| n % 3)),
        &[],
        "the angles hardly turn",
    );
    refused(
        &rows("angle_rad,radius_mm", (0..60).map(|n| 10 * n)),
        &[],
        "line 3: the angle goes on by",
    );
    refused(
        &rows("angle_rad,radius_mm", 0..3600),
        &[],
        "the angles go on for 57 turns",
    );
    refused(
        &good.replace("10.0,", "10.0,-"),
        &[],
        "line 102: the radius -100 mm is not positive",
    );
    refused(&good.replace("10.0,", "10.0,nan"), &[], "line 102");
    refused("", &[], "the file is empty");
}
