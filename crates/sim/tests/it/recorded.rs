//! Records of programs, made by sampling plans by another clock, with overrides, holds, roundings and
//! noise, and with faults of known size at known blocks.

use lostmotion_base::AxisId;
use lostmotion_base::random::Random;
use lostmotion_drive::config::Cycles;
use lostmotion_plan::{Action, Sample};
use lostmotion_sim::recorded::results::{Derivative, RecordCheck, RecordCoordinates, RecordKind};
use lostmotion_sim::recorded::{RecordOptions, Recorded, RecordedAxis, SHARED_ROWS};
use lostmotion_sim::{Intervention, Machine, Program, SimError, SimulateOptions, Simulation};

/// Corners, arcs and a dwell; no stretch is like another.
const PART: &str = "G21 G90 G17 G64 P0.05\nG0 X0 Y0 Z5\nG1 Z-2 F1200\nG1 X40 F6000\nG1 Y30\nG2 X60 Y50 I20 J0\nG1 X90 Y62\nG4 P0.3\nG3 X70 Y30 I-10.4494 J-15.7191\nG1 X20 Y12\nG1 X5 Y40\nG0 Z20\nM2\n";

/// How a plan becomes a record.
#[derive(Clone, Debug)]
struct Make {
    actions: Vec<(f64, Action)>,
    /// Quarters of a millisecond from row to row, and the first one that is recorded.
    every: usize,
    first: usize,
    /// Rows that are left out at the end.
    cut: usize,
    clock_s: f64,
    shift_mm: [f64; 3],
    step_mm: f64,
    noise_mm: f64,
}

impl Default for Make {
    fn default() -> Make {
        Make {
            actions: Vec::new(),
            every: 4,
            first: 0,
            cut: 0,
            clock_s: 0.0,
            shift_mm: [0.0; 3],
            step_mm: 0.0,
            noise_mm: 0.0,
        }
    }
}

fn machine() -> Machine {
    Machine::preset("bench3").unwrap()
}

fn planned(text: &str, actions: &[(f64, Action)]) -> Vec<Sample> {
    let fine = machine().with_cycles(Cycles {
        command_ms: 0.25,
        servo_us: 250.0,
    });
    let program = Program::from_str("part.ngc", text);
    let interventions = actions
        .iter()
        .map(|&(at_s, action)| Intervention { at_s, action })
        .collect();
    let mut samples = Vec::new();
    Simulation::new(&program, &fine)
        .options(SimulateOptions {
            interventions,
            ..SimulateOptions::default()
        })
        .plan(&mut |chunk, _| {
            samples.extend_from_slice(chunk);
            Ok(())
        })
        .unwrap();
    samples
}

impl Make {
    /// The rows that are recorded.
    fn rows(&self, text: &str) -> Vec<Sample> {
        let all = planned(text, &self.actions);
        let mut rows: Vec<Sample> = all
            .into_iter()
            .skip(self.first)
            .step_by(self.every)
            .collect();
        rows.truncate(rows.len() - self.cut);
        rows
    }

    fn record(&self, text: &str) -> Recorded {
        self.of(&self.rows(text))
    }

    fn of(&self, rows: &[Sample]) -> Recorded {
        let mut random = Random::new(7);
        let axes = [AxisId::X, AxisId::Y, AxisId::Z].map(|axis| RecordedAxis {
            axis,
            values: rows
                .iter()
                .map(|row| row.position.0[axis.index()] + self.shift_mm[axis.index()])
                .map(|mm| mm + self.noise_mm * random.normal())
                .map(|mm| {
                    if self.step_mm > 0.0 {
                        (mm / self.step_mm).round() * self.step_mm
                    } else {
                        mm
                    }
                })
                .collect(),
        });
        Recorded {
            time_s: (0..rows.len())
                .map(|row| self.clock_s + 2.5e-4 * (self.every * row) as f64)
                .collect(),
            axes: axes.into(),
            kind: RecordKind::Commanded,
            of_tool: false,
        }
    }
}

fn checked(text: &str, recorded: &Recorded) -> Result<RecordCheck, SimError> {
    Simulation::new(&Program::from_str("part.ngc", text), &machine())
        .check_record(recorded, &RecordOptions::default())
}

fn line(check: &RecordCheck) -> (u32, u32) {
    (check.place.first.span.line, check.place.last.span.line)
}

/// What has to hold of a record without a fault.
fn is_good(make: &Make) {
    let rows = make.rows(PART);
    let check = checked(PART, &make.of(&rows)).unwrap();
    assert!(check.is_within(), "{make:?}: {:#?}", check.blocks.first());
    assert_eq!(
        check.place.rows_before + check.place.rows_behind,
        0,
        "{make:?}"
    );
    // Rows on a corner may count for the move before or behind it.
    let all = planned(PART, &make.actions);
    let near = |row: &Sample, line: u32| {
        all.iter()
            .filter(|other| (other.position - row.position).linear_norm() < 0.2)
            .any(|other| other.block.span.line == line)
    };
    let (first, last) = line(&check);
    assert!(near(&rows[0], first), "{make:?}: {first}");
    assert!(near(&rows[rows.len() - 1], last), "{make:?}: {last}");
    // Roundings of corners are found as they are: never more than P, and about it.
    let allowed = 1e3 * 0.05 + check.deviation_plus_minus_um;
    assert!(
        check.deviation_max_um <= allowed,
        "{make:?}: {}",
        check.deviation_max_um
    );
    if rows.len() * make.every > 20_000 {
        assert!(
            check.deviation_max_um > 45.0,
            "{make:?}: {}",
            check.deviation_max_um
        );
    }
    let expected = if make.shift_mm == [0.0; 3] {
        RecordCoordinates::Machine
    } else {
        RecordCoordinates::Shifted
    };
    assert_eq!(check.place.coordinates, expected, "{make:?}");
    for (found, given) in check.place.shift_mm.iter().zip(make.shift_mm) {
        let off = (found - given).abs();
        assert!(
            off <= check.place.shift_error_mm + 1e-9,
            "{make:?}: {found} {given} {}",
            check.place.shift_error_mm
        );
    }
    assert_eq!(check.place.other_places, 0, "{make:?}");
}

#[test]
fn a_plan_is_found_in_its_program_and_keeps_its_limits() {
    let usual = Make::default();
    for make in [
        usual.clone(),
        Make {
            clock_s: 4711.25,
            every: 10,
            first: 3,
            ..usual.clone()
        },
        Make {
            every: 16,
            first: 5000,
            ..usual.clone()
        },
        Make {
            first: 6123,
            cut: 1000,
            ..usual.clone()
        },
        Make {
            step_mm: 1e-3,
            ..usual.clone()
        },
        Make {
            step_mm: 1.0 / 4096.0,
            first: 777,
            ..usual.clone()
        },
        Make {
            noise_mm: 5e-4,
            ..usual.clone()
        },
        Make {
            noise_mm: 2e-3,
            step_mm: 1e-4,
            every: 8,
            ..usual.clone()
        },
        Make {
            shift_mm: [123.4, -56.7, 8.9],
            ..usual.clone()
        },
        Make {
            shift_mm: [-0.4, 0.3, 0.2],
            step_mm: 1e-4,
            first: 4000,
            ..usual.clone()
        },
        Make {
            shift_mm: [20.0, 0.0, 0.0],
            noise_mm: 1e-3,
            ..usual.clone()
        },
    ] {
        is_good(&make);
    }
}

#[test]
fn overrides_holds_and_pauses_play_no_part() {
    let usual = Make::default();
    for actions in [
        vec![(0.3, Action::Override(0.4)), (2.0, Action::Override(0.9))],
        vec![(0.9, Action::Hold), (2.9, Action::Resume)],
        vec![
            (0.5, Action::Override(0.0)),
            (1.5, Action::Override(1.0)),
            (1.9, Action::Hold),
            (2.2, Action::Resume),
        ],
    ] {
        for shift_mm in [[0.0; 3], [-7.0, 11.0, 13.0]] {
            is_good(&Make {
                actions: actions.clone(),
                shift_mm,
                step_mm: 1e-4,
                ..usual.clone()
            });
        }
    }
}

/// Motion before the program begins and behind its end belongs to no block.
#[test]
fn motion_that_is_not_of_the_program_is_left_out() {
    let make = Make {
        step_mm: 1e-4,
        ..Make::default()
    };
    let mut rows = make.rows(PART);
    let first = rows[0];
    let (mut before, mut behind) = (Vec::new(), Vec::new());
    for step in 0..800 {
        // A jog towards the start, and one away from the end.
        let mut row = first;
        row.position.0[1] -= 0.03 * f64::from(800 - step);
        row.position.0[0] -= 0.02 * f64::from(800 - step);
        before.push(row);
        let mut row = rows[rows.len() - 1];
        row.position.0[0] += 0.03 * f64::from(step);
        behind.push(row);
    }
    let count = rows.len() as i64;
    before.append(&mut rows);
    before.append(&mut behind);
    let check = checked(PART, &make.of(&before)).unwrap();
    // What the machine does within 3 mm of the path may still be of it.
    let on_path = (check.place.rows - check.place.rows_before - check.place.rows_behind) as i64;
    assert!((0..320).contains(&(on_path - count)), "{:?}", check.place);
    assert_eq!(line(&check).1, 12);
}

/// An acceleration 8.1 times over on the straight move of line 4: forth, back twice, forth, so that
/// speed and place are those of before.
#[test]
fn an_acceleration_8_times_over_is_found_at_its_block_with_its_size() {
    let limit = 1000.0;
    for (step_mm, noise_mm, every, within) in [
        (0.0, 0.0, 4, 1e-3),
        (1e-4, 0.0, 4, 0.05),
        (1e-3, 0.0, 4, 0.12),
        (0.0, 2e-4, 4, 0.1),
        (1e-4, 0.0, 8, 0.05),
    ] {
        let make = Make {
            step_mm,
            noise_mm,
            every,
            ..Make::default()
        };
        let mut rows = make.rows(PART);
        // In the middle of the move, at its steady speed.
        let middle = rows
            .iter()
            .position(|row| {
                row.block.span.line == 4 && row.position.0[0] - rows[0].position.0[0] > 20.0
            })
            .unwrap();
        assert!(rows[middle].acceleration.linear_norm() < 1e-6);
        let (accel, quarter_s) = (8.1 * limit, 0.012);
        let bump = |t: f64| {
            let square = |t: f64| t.max(0.0).powi(2);
            0.5 * accel
                * (square(t) - 2.0 * square(t - quarter_s) + 2.0 * square(t - 3.0 * quarter_s)
                    - square(t - 4.0 * quarter_s))
        };
        for (index, row) in rows.iter_mut().enumerate().skip(middle) {
            row.position.0[0] += bump((index - middle) as f64 * 2.5e-4 * every as f64);
        }
        let check = checked(PART, &make.of(&rows)).unwrap();
        assert!(!check.is_within());
        let worst = &check.blocks[0];
        assert_eq!((worst.block.span.line, check.place.first.span.line), (4, 2));
        let found = check.axes[0]
            .limits
            .iter()
            .find(|limit| limit.derivative == Derivative::Acceleration)
            .unwrap();
        assert_eq!((found.block.span.line, found.axis), (4, AxisId::X));
        assert!(found.is_exceeded);
        assert!(
            (found.times - 8.1).abs() <= found.plus_minus / found.limit + 1e-6,
            "{found:?}"
        );
        assert!(found.plus_minus / found.limit <= 8.1 * within, "{found:?}");
        // Y and Z have no part in it.
        for axis in &check.axes[1..] {
            assert!(
                axis.limits.iter().all(|limit| !limit.is_exceeded),
                "{axis:#?}"
            );
        }
        // The tool stays on the path.
        assert!(check.deviation_max_um <= 50.0 + check.deviation_plus_minus_um);
    }
}

/// A corner cut by a straight move 2.4 times as far as P allows.
#[test]
fn a_corner_cut_2_4_times_the_tolerance_is_found_with_its_size() {
    // Half of the cut off the legs is the distance of the middle of the cut from either.
    let cut = 2.0 * 2.4 * 0.05;
    let faulty = PART.replace(
        "G1 X40 F6000\nG1 Y30\n",
        &format!(
            "G1 X{:.4} F6000\nG61\nG1 X40 Y{cut:.4}\nG64 P0.05\nG1 Y30\n",
            40.0 - cut
        ),
    );
    for (step_mm, shift_mm) in [
        (0.0, [0.0; 3]),
        (1e-4, [0.0; 3]),
        (1e-3, [0.0; 3]),
        (1e-4, [31.0, -4.0, 2.0]),
    ] {
        let make = Make {
            step_mm,
            shift_mm,
            ..Make::default()
        };
        let check = checked(PART, &make.record(&faulty)).unwrap();
        let worst = &check.blocks[0];
        assert!(
            worst.is_outside && [4, 5].contains(&worst.block.span.line),
            "{worst:?}"
        );
        assert_eq!(worst.allowed_um, Some(50.0));
        let off = worst.deviation_um - 120.0;
        // A row every millisecond may miss the middle of the cut: by half of its way, 45 degrees.
        let missed = 5.0;
        assert!(
            (-missed - check.deviation_plus_minus_um..=check.deviation_plus_minus_um)
                .contains(&off),
            "{off}"
        );
        assert!(check.at_fault <= 2, "{}", check.at_fault);
    }
}

#[test]
fn what_is_repeated_is_said_to_be() {
    // Three times the same outline: which round it was cannot be told.
    let outline = "G1 X40\nG1 Y20\nG1 X0\nG1 Y0\n";
    let text = format!("G21 G90 G64 P0.02\nG0 X0 Y0 Z2\nF3000\n{outline}{outline}{outline}M2\n");
    let rows = Make::default().rows(&text);
    let round: Vec<Sample> = rows
        .into_iter()
        .filter(|row| (8..12).contains(&row.block.span.line))
        .collect();
    let check = checked(&text, &Make::default().of(&round)).unwrap();
    assert_eq!(check.place.other_places, 2);
    assert!(check.is_within());
}

#[test]
fn logs_of_other_programs_are_refused() {
    let other = "G21 G90 G64 P0.02\nG0 X5 Y80\nG1 X-30 Y20 F4000\nG1 X3 Y-40\nG3 X30 Y-13 R27\nG1 Y50\nM2\n";
    let record = Make::default().record(other);
    let error = checked(PART, &record).unwrap_err().to_string();
    assert!(
        error.contains("does not follow the program anywhere"),
        "{error}"
    );
    // Swapped columns are another motion, and so are wrong units.
    let mut swapped = Make::default().record(PART);
    swapped.axes[0].axis = AxisId::Y;
    swapped.axes[1].axis = AxisId::X;
    assert!(checked(PART, &swapped).is_err());
    let mut inches = Make::default().record(PART);
    inches
        .axes
        .iter_mut()
        .flat_map(|axis| &mut axis.values)
        .for_each(|mm| *mm /= 25.4);
    assert!(checked(PART, &inches).is_err());
}

/// Milliseconds taken for seconds: nothing would be said to be over a limit.
#[test]
fn rows_that_are_far_apart_do_not_tell_limits() {
    let mut slow = Make::default().record(PART);
    for time in &mut slow.time_s {
        *time *= 1e3;
    }
    let refused = checked(PART, &slow).unwrap_err().to_string();
    assert!(refused.contains("rows of the log are 1"), "{refused}");
    for time in &mut slow.time_s {
        *time *= 0.2;
    }
    let told = checked(PART, &slow).unwrap();
    assert!(
        told.untold
            .iter()
            .any(|reason| reason.contains("whether the axes keep their limits"))
    );
}

/// Rows that are missing while it moves are said with their place; while it rests they are not missed.
#[test]
fn rows_that_are_missing_are_said_with_their_place() {
    let plain = Make::default().record(PART);
    let rows = plain.time_s.len();
    let without = |from: usize, to: usize| {
        let (mut before, behind) = (rows_of(&plain, 0..from), rows_of(&plain, to..rows));
        before.time_s.extend(behind.time_s);
        for (axis, more) in before.axes.iter_mut().zip(behind.axes) {
            axis.values.extend(more.values);
        }
        before
    };
    let said = |record: &Recorded| {
        let untold = checked(PART, record).unwrap().untold;
        untold
            .into_iter()
            .find(|reason| reason.contains("rows are missing"))
    };
    assert_eq!(said(&plain), None);
    let middle = rows / 4;
    let (from, to) = (plain.time_s[middle], plain.time_s[middle + 101]);
    let reason = said(&without(middle + 1, middle + 101)).unwrap();
    assert!(
        reason.starts_with(&format!(
            "what the axes did between {from:.3} and {to:.3} s"
        )),
        "{reason}"
    );
    // a pause of a second, of which nobody has rows
    let mut paused = plain.clone();
    for time in paused.time_s.iter_mut().skip(middle) {
        *time += 1.0;
    }
    for axis in &mut paused.axes {
        axis.values[middle] = axis.values[middle - 1];
    }
    assert_eq!(said(&paused), None);
}

#[test]
fn a_record_that_is_none_is_refused_with_its_row() {
    let good = Make::default().record(PART);
    let refused = |change: &dyn Fn(&mut Recorded), part: &str| {
        let mut bad = good.clone();
        change(&mut bad);
        let error = checked(PART, &bad).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    };
    refused(
        &|bad| bad.axes[1].values[41] = f64::NAN,
        "row 42: the position of axis Y is not a number",
    );
    refused(&|bad| bad.time_s[10] = bad.time_s[9], "row 11: the time");
    refused(&|bad| bad.time_s[10] = f64::NAN, "row 11: the time");
    refused(
        &|bad| {
            bad.axes.pop();
        },
        "no axis Z",
    );
    refused(
        &|bad| {
            bad.axes[0].values.pop();
        },
        "positions for",
    );
    refused(
        &|bad| bad.axes.iter_mut().for_each(|axis| axis.values.fill(1.0)),
        "hardly moves",
    );
    refused(
        &|bad| {
            bad.time_s.clear();
            bad.axes.iter_mut().for_each(|axis| axis.values.clear());
        },
        "hardly moves",
    );
    let few = RecordOptions {
        max_moves: 3,
        ..RecordOptions::default()
    };
    let error = Simulation::new(&Program::from_str("part.ngc", PART), &machine())
        .check_record(&good, &few)
        .unwrap_err();
    assert!(error.to_string().contains("more than 3 moves"), "{error}");
}

/// The rows of a range.
fn rows_of(recorded: &Recorded, rows: std::ops::Range<usize>) -> Recorded {
    Recorded {
        time_s: recorded.time_s[rows.clone()].to_vec(),
        axes: recorded
            .axes
            .iter()
            .map(|axis| RecordedAxis {
                axis: axis.axis,
                values: axis.values[rows.clone()].to_vec(),
            })
            .collect(),
        ..recorded.clone()
    }
}

/// A record in parts says what the whole one does, with a rest before the program, motion behind it, a
/// stretch that is off, and coordinates that have to be found.
#[test]
fn a_record_in_parts_is_checked_as_a_whole() {
    let usual = Make {
        step_mm: 1e-4,
        ..Make::default()
    };
    let plain = usual.record(PART);
    let rows = plain.time_s.len();
    let with = |change: &dyn Fn(usize, f64) -> f64| {
        let mut changed = plain.clone();
        for (row, value) in changed.axes[0].values.iter_mut().enumerate() {
            *value = (change(row, *value) * 1e4).round() / 1e4;
        }
        changed
    };
    let off = with(&|row, x| {
        let t = (row as f64 - 0.55 * rows as f64) / 200.0;
        x + 0.4 * (-t * t).exp()
    });
    // at rest before the program for longer than a part, away from the path behind it
    let mut around = plain.clone();
    let (before, behind) = (2500, 1500);
    let last = plain.time_s[rows - 1];
    around.time_s = (0..before).map(|row| row as f64 * 1e-3).collect();
    around.time_s.extend(plain.time_s.iter().map(|t| 2.5 + t));
    around
        .time_s
        .extend((1..=behind).map(|row| 2.5 + last + row as f64 * 1e-3));
    for axis in &mut around.axes {
        let (first, last) = (axis.values[0], axis.values[rows - 1]);
        let mut values = vec![first; before];
        values.append(&mut axis.values);
        values.extend((1..=behind).map(|row| last + 0.02 * row as f64));
        axis.values = values;
    }
    let shifted = Make {
        shift_mm: [11.0, -7.0, 3.0],
        ..usual.clone()
    };
    for (what, record, first) in [
        ("plain", plain.clone(), 2000),
        ("off", off, 2000),
        ("shifted", shifted.record(PART), 6000),
    ] {
        let program = Program::from_str("part.ngc", PART);
        let machine = machine();
        let simulation = Simulation::new(&program, &machine);
        let whole = checked(PART, &record).unwrap();
        let total = record.time_s.len();
        let (mut from, mut size) = (0, first);
        let mut next = || -> Result<Option<(Recorded, usize)>, SimError> {
            if from == total {
                return Ok(None);
            }
            let shared = SHARED_ROWS.min(from);
            let to = (from + size).min(total);
            let part = rows_of(&record, from - shared..to);
            (from, size) = (to, 1000);
            Ok(Some((part, shared)))
        };
        let parts = simulation
            .check_record_parts(&mut next, &RecordOptions::default())
            .unwrap();
        assert_eq!(line(&parts), line(&whole), "{what}");
        let place = |check: &RecordCheck| {
            let place = &check.place;
            (place.rows, place.rows_before, place.coordinates)
        };
        assert_eq!(place(&parts), place(&whole), "{what}");
        let behind = parts.place.rows_behind.abs_diff(whole.place.rows_behind);
        assert!(behind <= 20, "{what}: {:?} {:?}", parts.place, whole.place);
        assert_eq!(parts.is_within(), whole.is_within(), "{what}");
        assert_eq!(parts.block_count, whole.block_count, "{what}");
        assert_eq!(parts.at_fault, whole.at_fault, "{what}");
        let near = |a: f64, b: f64| (a - b).abs() <= 0.02 * b.abs() + 0.2;
        assert!(
            near(parts.deviation_max_um, whole.deviation_max_um),
            "{what}"
        );
        assert!(
            near(parts.deviation_rms_um, whole.deviation_rms_um),
            "{what}"
        );
        for (a, b) in parts.axes.iter().zip(&whole.axes) {
            for (a, b) in a.limits.iter().zip(&b.limits) {
                assert!((a.times - b.times).abs() < 0.02, "{what}: {a:?} {b:?}");
            }
        }
    }
    // Rest before the program and motion behind it are left out, whichever parts they fill.
    let total = around.time_s.len();
    let (mut from, mut size) = (0, 2000);
    let mut next = || -> Result<Option<(Recorded, usize)>, SimError> {
        if from == total {
            return Ok(None);
        }
        let shared = SHARED_ROWS.min(from);
        let to = (from + size).min(total);
        let part = rows_of(&around, from - shared..to);
        (from, size) = (to, 1000);
        Ok(Some((part, shared)))
    };
    let program = Program::from_str("part.ngc", PART);
    let bench = machine();
    let parts = Simulation::new(&program, &bench)
        .check_record_parts(&mut next, &RecordOptions::default())
        .unwrap();
    assert_eq!(line(&parts), line(&checked(PART, &plain).unwrap()));
    assert_eq!(parts.place.rows, total as u64);
    assert_eq!(parts.place.coordinates, RecordCoordinates::Machine);
    assert_eq!(parts.place.rows_before, 2000 - SHARED_ROWS as u64);
    // Up to 3 mm beside the path still count for it.
    let least = 1500 - (3.0 / (0.02 * 3.0_f64.sqrt())) as u64;
    let behind = parts.place.rows_behind;
    assert!((least..=1500).contains(&behind), "{:?}", parts.place);
    // A log that never moves is refused for that.
    let rest = rows_of(&plain, 0..1);
    let still = Recorded {
        time_s: (0..3000).map(|row| row as f64 * 1e-3).collect(),
        axes: rest
            .axes
            .iter()
            .map(|axis| RecordedAxis {
                axis: axis.axis,
                values: vec![axis.values[0]; 3000],
            })
            .collect(),
        ..rest.clone()
    };
    let mut parts = vec![(still.clone(), 0)];
    let program = Program::from_str("part.ngc", PART);
    let machine = machine();
    let refused = Simulation::new(&program, &machine)
        .check_record_parts::<SimError>(&mut || Ok(parts.pop()), &RecordOptions::default())
        .unwrap_err();
    assert!(refused.to_string().contains("hardly moves"), "{refused}");
}
