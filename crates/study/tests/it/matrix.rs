//! The matrix against what is known beforehand.
use lostmotion_study::StudyError;
use lostmotion_study::matrix::journal::{Header, line, read};
use lostmotion_study::matrix::machine;
use lostmotion_study::matrix::{
    Cell, CellResult, MethodFigures, Traced, run_cell, run_cells, table,
};

fn names(methods: &[&str]) -> Vec<String> {
    methods.iter().map(|name| (*name).to_owned()).collect()
}

fn cell(id: &str) -> Cell {
    Cell::parse(id).unwrap()
}

const SHORT: [&str; 4] = [
    "circle5-f3000-ccw-g10-t10-v0-j2-e20-steady",
    "circle5-f10000-cw-g60-t2-v20-j1-ideal-steady",
    "circle10-f10000-ccw-g20-t30-v0-j0.5-e23-steady",
    "zigzag-f10000-cw-g5-t10-v20-j4-e17-steady",
];

fn run_short(threads: usize) -> Vec<CellResult> {
    let cells = SHORT.map(cell);
    run_cells(
        &cells,
        &names(&["fixed", "adaptive"]),
        threads,
        &mut |_, _| Ok(()),
    )
    .unwrap()
}

#[test]
fn a_slow_load_with_friction_lies_half_the_gap_behind() {
    // friction of 30 % winds the shaft up by 3.3/2400 rad = 4.4 um on either machine; what backlash
    // adds is half the gap, all the time
    let result = run_cell(
        &cell("circle25-f300-ccw-g20-t30-v0-j1-ideal-steady"),
        &[],
        None,
    )
    .unwrap();
    for rms in result.methods[0].axis_rms_um {
        assert!((rms / 10.0 - 1.0).abs() < 0.02, "{rms}");
    }
    // both along the radius of a circle: half the gap times (|cos phi| - |sin phi|), whose RMS over
    // a turn is half the gap times sqrt(1 - 2/pi) at this feed the time in the gap adds two parts
    // in a hundred
    let expected = 10.0 * (1.0 - std::f64::consts::FRAC_2_PI).sqrt();
    assert!(
        (result.methods[0].rms_um / expected - 1.0).abs() < 0.03,
        "{} {expected}",
        result.methods[0].rms_um
    );
}

/// A cell in which `none` and `fixed` leave so much, um.
fn made(id: &str, none_um: f64, fixed_um: f64) -> CellResult {
    let figures = |method: &str, um| MethodFigures {
        method: method.to_owned(),
        rms_um: um,
        max_um: um,
        ..MethodFigures::default()
    };
    CellResult {
        cell: cell(id),
        duration_s: 1.0,
        measured_from_s: 0.5,
        samples: 2000,
        reached_mm_min: 3000.0,
        reversals: [8, 8],
        traverse_ms: 1.0,
        limit_max_um: 0.0,
        limit_rms_um: 0.0,
        floating: 0.0,
        encoder_um: 0.0,
        methods: vec![figures("none", none_um), figures("fixed", fixed_um)],
    }
}

#[test]
fn harm_is_a_part_of_all_cells() {
    // `none` leaves next to nothing in all cells but one, and has no ratio there; one of twenty is
    // worse, which is less than a tenth
    let id = "circle25-f3000-ccw-g10-t10-v0-j2-e20-steady";
    let mut cells = vec![made(id, 0.01, 0.01); 18];
    cells.push(made(id, 0.01, 0.5));
    cells.push(made(id, 1.0, 0.1));
    let text = table::markdown(&cells, "made");
    let row = text
        .lines()
        .skip_while(|line| !line.contains("| does harm |"))
        .find(|line| line.starts_with("| `fixed`"));
    assert_eq!(row, Some("| `fixed` | - | - |"), "{text}");
    // two more are
    cells.extend(vec![made(id, 0.01, 0.5); 2]);
    let text = table::markdown(&cells, "made");
    assert!(text.contains("| `fixed` | - | circle25, g10, "), "{text}");
}

#[test]
fn both_ways_round_are_alike() {
    let [one, other] = ["ccw", "cw"].map(|way| {
        run_cell(
            &cell(&format!("circle10-f3000-{way}-g20-t10-v20-j2-ideal-steady")),
            &names(&["fixed"]),
            None,
        )
        .unwrap()
    });
    for (one, other) in one.methods.iter().zip(&other.methods) {
        assert!(
            (one.rms_um / other.rms_um - 1.0).abs() < 1e-3,
            "{one:?} {other:?}"
        );
    }
}

#[test]
fn every_motion_reverses_more_than_four_times_and_is_as_fast_as_its_name() {
    for shape in lostmotion_study::matrix::FACTORS[0].levels {
        let result = run_cell(
            &cell(&format!("{shape}-f10000-cw-g5-t10-v0-j1-ideal-steady")),
            &[],
            None,
        )
        .unwrap();
        assert!(
            result.reversals.iter().all(|count| *count >= 8),
            "{shape} {:?}",
            result.reversals
        );
        assert!(result.samples > 4000, "{shape} {}", result.samples);
        if shape.starts_with("circle") {
            // the time law comes near a limit of speed, not onto it
            assert!(
                (result.reached_mm_min / 1e4 - 1.0).abs() < 1e-3,
                "{shape} {}",
                result.reached_mm_min
            );
        }
    }
}

#[test]
fn every_machine_is_sound() {
    for friction in ["t0", "t30"] {
        for ratio in ["j0.5", "j1", "j2", "j4", "j8"] {
            let id = format!("circle10-f10000-ccw-g2-{friction}-v20-{ratio}-e20-steady");
            let axis = machine::axis(&cell(&id)).unwrap();
            let wanted: f64 = ratio[1..].parse().unwrap();
            assert!(
                (axis.reflected_load().inertia_kgm2 / axis.motor.inertia_kgm2 - wanted).abs()
                    < 1e-12
            );
            assert!((axis.gap_in_unit() - 0.002).abs() < 1e-12);
            // the planner's largest acceleration with all friction stays within the drive's torque
            let inertia = axis.motor.inertia_kgm2 + axis.reflected_load().inertia_kgm2;
            let torque = inertia * 7000.0 * axis.transmission.motor_rad_per_unit()
                + axis.reflected_load().coulomb_nm;
            assert!(
                torque < axis.motor.torque_constant_nm_per_a * axis.drive.current_limit_a,
                "{ratio} {torque}"
            );
        }
    }
}

#[test]
fn results_do_not_depend_on_threads() {
    assert_eq!(run_short(1), run_short(3));
}

#[test]
fn a_journal_gives_back_what_was_put_in() {
    let results = run_short(0);
    let header = Header::new(Some(4), 1, &names(&["fixed", "adaptive"]));
    let mut text = line(&header).unwrap();
    for result in &results {
        text.push_str(&line(result).unwrap());
    }
    let found = read(&text, &header).unwrap();
    assert_eq!(found.whole_bytes, text.len());
    assert!(
        results
            .iter()
            .all(|result| found.results.get(&result.cell) == Some(result))
    );
    // stopped in the middle of a line: that cell counts for nothing
    let cut = read(&text[..text.len() - 20], &header).unwrap();
    assert_eq!(cut.results.len(), 3);
    assert_eq!(&text[..cut.whole_bytes].matches('\n').count(), &4);
    assert!(table::markdown(&results, "four").contains("| `adaptive` |"));
    assert_eq!(table::csv(&results).lines().count(), 1 + 4 * 3);
}

#[test]
fn journals_of_other_studies_and_broken_ones_are_refused() {
    let header = Header::new(Some(4), 1, &names(&["fixed"]));
    let mut text = line(&Header::new(Some(4), 2, &names(&["fixed"]))).unwrap();
    let refused = read(&text, &header).unwrap_err();
    assert!(
        matches!(
            refused,
            StudyError::OtherStudy {
                what: "the seed",
                ..
            }
        ),
        "{refused}"
    );
    text = line(&header).unwrap() + "{\"cell\":\"circle5\"}\n";
    assert!(matches!(
        read(&text, &header),
        Err(StudyError::Journal { line: 2, .. })
    ));
    assert!(matches!(
        read("nonsense\n", &header),
        Err(StudyError::Journal { line: 1, .. })
    ));
}

#[test]
fn a_trace_shows_what_the_figures_sum_up() {
    let (mut squares, mut count) = (0.0, 0_u64);
    let mut watch = |row: &Traced| {
        if row.measured {
            let [with, without] = row.error_um;
            squares += (with - without) * (with - without);
            count += 1;
        }
    };
    let result = run_cell(&cell(SHORT[0]), &names(&["fixed"]), Some(&mut watch)).unwrap();
    assert_eq!(count, result.samples);
    let rms = (squares / count as f64).sqrt();
    assert!((rms / result.methods[1].rms_um - 1.0).abs() < 1e-5, "{rms}");
}

#[test]
fn an_unknown_method_is_refused_with_the_cell_named() {
    let error = run_cell(&cell(SHORT[0]), &names(&["magic"]), None)
        .unwrap_err()
        .to_string();
    assert!(
        error.contains("cell circle5-f3000") && error.contains("magic"),
        "{error}"
    );
}

/// The package holds a copy, so that it builds on its own.
#[test]
fn the_pocket_of_the_matrix_is_the_sample_part() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR"));
    let read = |path: &str| std::fs::read_to_string(root.join(path)).unwrap();
    assert_eq!(
        read("src/matrix/pocket_helical.ngc"),
        read("../../gcode_samples/parts/pocket_helical.ngc")
    );
}
