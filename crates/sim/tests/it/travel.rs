//! A part that does not fit the machine: one message for the one cause, with the way out.

use lostmotion_sim::{Machine, Program, SimError, Simulation};

fn refusal(machine: &Machine, text: &str) -> (u64, String, String) {
    let program = Program::from_str("part.ngc", text);
    match Simulation::new(&program, machine).check() {
        Err(SimError::Travel {
            moves,
            excesses,
            hint,
            ..
        }) => {
            let all: Vec<String> = excesses.iter().map(ToString::to_string).collect();
            (moves, all.join("; "), hint)
        }
        other => panic!("{other:?}"),
    }
}

/// Fifty rows of a raster in the first quadrant.
fn raster() -> String {
    let rows: String = (0..50)
        .map(|row| {
            format!(
                "G1 Y{row} F3000\nG1 X{}\n",
                if row % 2 == 0 { 80 } else { 0 }
            )
        })
        .collect();
    format!("G21 G90 G17 G94 G54\nG0 X0 Y0 Z0\nG0 Z5\n{rows}M2\n")
}

#[test]
fn an_empty_work_offset_is_one_message_that_says_how_far_to_move_it() {
    let machine = Machine::preset("vmc3").unwrap();
    let empty = machine
        .edit(|m| m.work_offset.g54 = Default::default())
        .unwrap();
    let (moves, all, hint) = refusal(&empty, &raster());
    // All moves but the first G0, the first feed move along Y and the last back to X0 leave it.
    assert!(moves > 90, "{moves}");
    assert_eq!(
        all,
        "axis X to 80.000 mm, beyond its limit of 0.000 mm; \
         axis Y to 49.000 mm, beyond its limit of 0.000 mm; \
         axis Z to 5.000 mm, beyond its limit of 0.000 mm"
    );
    assert_eq!(
        hint,
        "move the origin of G54: X by -80.000 mm or more, Y by -49.000 mm or more, \
         Z by -5.000 mm or more; in the machine file [work_offset.g54] x_mm = -80.000, \
         y_mm = -49.000, z_mm = -5.000"
    );
    // What the hint says is enough.
    let moved = empty.edit(|m| m.g54 = [-80.0, -49.0, -5.0]).unwrap();
    let program = Program::from_str("part.ngc", raster());
    assert!(Simulation::new(&program, &moved).check().is_ok());
}

#[test]
fn a_part_that_is_too_large_is_said_to_be() {
    let machine = Machine::preset("vmc3").unwrap();
    let (_, _, hint) = refusal(&machine, "G21 G90\nG0 X-400\nG0 X400\nM2\n");
    assert!(
        hint.starts_with("the part needs 800.000 mm of X, the machine has 762.000 mm"),
        "{hint}"
    );
}
