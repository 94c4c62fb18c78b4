//! Programs of other dialects rewritten: their text stays, their lines are found again by the front end.

use lostmotion_gcode::Dialect;
use lostmotion_gcode::syntax::line_checksum;
use lostmotion_sim::motion::ProgrammedMove;
use lostmotion_sim::rewrite::results::Rewritten;
use lostmotion_sim::rewrite::{RewriteError, RewriteOptions, rewrite};
use lostmotion_sim::{Machine, Program, SimulateOptions, Simulation};

fn machine() -> Machine {
    Machine::preset("vmc3-worn").unwrap()
}

/// Half the gaps alone: end points are then known.
fn rewritten(program: &Program, dialect: Dialect) -> Result<Rewritten, RewriteError> {
    let options = SimulateOptions {
        dialect: Some(dialect),
        ..SimulateOptions::default()
    };
    let wanted = RewriteOptions {
        most_normal_um: 0.0,
        ..RewriteOptions::default()
    };
    rewrite(program, &machine(), &options, &wanted)
}

fn refused(text: &str, dialect: Dialect) -> String {
    let program = Program::from_str("part.nc", text);
    rewritten(&program, dialect).unwrap_err().to_string()
}

fn ends(program: &Program, dialect: Dialect) -> Vec<[f64; 3]> {
    let machine = machine();
    let all = Simulation::new(program, &machine).dialect(dialect).curves();
    let moves: Vec<ProgrammedMove> = all.unwrap().map(Result::unwrap).collect();
    let ways = moves.iter().filter(|item| item.motion.curve.length() > 0.0);
    ways.map(|item| item.motion.curve.end().linear()).collect()
}

/// The new program, whose ends are those of the old one, in its order, half a gap of 40 um aside.
fn follows(bytes: &[u8], dialect: Dialect) -> Vec<u8> {
    let program = Program::from_bytes("part.nc", bytes);
    let new = rewritten(&program, dialect).unwrap_or_else(|error| panic!("{dialect}: {error}"));
    assert_eq!(new.refused, None, "{}", new.text);
    let again = Program::from_bytes("part.nc", new.bytes.as_slice());
    let found = ends(&again, dialect);
    let mut at = 0;
    for end in ends(&program, dialect) {
        let near = |new: &[f64; 3]| (0..3).all(|axis| (new[axis] - end[axis]).abs() < 0.0203);
        let place = found[at..].iter().position(near);
        at += place.unwrap_or_else(|| panic!("{end:?} is not in {}", new.text));
    }
    new.bytes
}

#[test]
fn programs_of_fanuc_keep_their_head_and_macros() {
    let text = "%\n(of a part)\n:0001(SLOT)\nN10G21G17G90G64\n#100=5*2\nG5.1 Q1\nN20G0X0Y0Z5.\nG1Z-1.F300\n\
                /2 N30 M8\nN40G1X+30.Y0F900(cut)\nN50X30Y.2E2\nG1X-.5 ; odd (not closed\nY0\nG0Z20.\nM30\n%\nG91 ( garbage\n";
    let new = String::from_utf8(follows(text.as_bytes(), Dialect::Fanuc)).unwrap();
    assert!(
        new.starts_with("%\n(of a part)\n:0001(SLOT)\n(part.nc rewritten by lostmotion"),
        "{new}"
    );
    for kept in [
        "\n#100=5*2\nG5.1 Q1\nN20G0X-0.48Y-0.48Z5.48\n",
        "\n/2 N30 M8\n",
        "\nN40G1X30.02Y0.02F900(cut)\n",
        // An exponent is part of its number.
        "\nN50X30.02Y20.02\n",
        "\nG1X-0.52",
        " ; odd (not closed\n",
        "\nM30\n%\nG91 ( garbage\n",
    ] {
        assert!(new.contains(kept), "{kept}: {new}");
    }
}

#[test]
fn lines_of_printers_keep_their_checksums_and_texts() {
    let line = |text: &str| format!("{text}*{}", line_checksum(text.as_bytes()));
    let lines = [
        line("N1 G21"),
        line("N2 G90"),
        "M117 go to X5 G91".to_owned(),
        "M117 G91 X5".to_owned(),
        line("N3 G0 X0 Y0 F3000") + " ; go (there) X3",
        line("N4 G1 X30 Y0 E.5 F1200"),
        "N5 x30 y20 e1".to_owned(),
        "G1 E-.8 F2100".to_owned(),
        "G1X0Y20E1.5".to_owned(),
        "G1 Y0 E2".to_owned(),
        "M84 ; end".to_owned(),
    ];
    for dialect in [Dialect::Marlin, Dialect::Klipper] {
        let new = follows((lines.join("\n") + "\n").as_bytes(), dialect);
        let new = String::from_utf8(new).unwrap();
        for kept in [
            "\nM117 go to X5 G91\nM117 G91 X5\n",
            " ; go (there) X3\n",
            "\nG1 E-.8 F2100\n",
            "\nM84 ; end\n",
            // A printer's line has its code first.
            "\nN5 G1 x30.02 y20.02 e1\n",
            "\nG1X-0.02Y20.02E1.5\n",
        ] {
            assert!(new.contains(kept), "{kept}: {new}");
        }
        // Y has not moved yet, and the program says no Z: its side is not known.
        let changed = line("N4 G1 X30.02 Y0. E.5 F1200");
        assert!(new.contains(&changed), "{changed}: {new}");
    }
}

/// A byte order mark stays first, comments stay what bytes they are, lines end as they did.
#[test]
fn bytes_that_are_no_words_stay() {
    let text = b"\xef\xbb\xbf(caf\xe9)\rg21 g90 g17\rg0 x0 y0 z5\rg1z-1f300\rg1x1.5e+1y0\rx15y2e+1\rx0\ry0\rm2\r";
    let new = follows(text, Dialect::LinuxCnc);
    assert!(new.starts_with(b"\xef\xbb\xbf(part.nc rewritten"));
    assert!(new.windows(8).any(|piece| piece == b"\r(caf\xe9)\r"));
    assert!(!new.contains(&b'\n'));
}

#[test]
fn what_a_dialect_has_besides_is_refused_by_its_place() {
    let head = "G21G90G17\nG0X0Y0Z1.\nG1Z-1.F300\n";
    for (rest, dialect, place, what) in [
        (
            "#1=30\nG1X#1\n",
            Dialect::Fanuc,
            "line 5, column 3: ",
            "X is an expression",
        ),
        (
            "G1X30.,R2.\nY20.\n",
            Dialect::Fanuc,
            "line 4, column 7: ",
            "a corner with ,R or ,C",
        ),
        (
            "G0Z1.\nG13 I2. K8. Q2. Z-1. F200\n",
            Dialect::Haas,
            "line 5, column 1: ",
            "G13 is not rewritten",
        ),
        (
            "X9\nG54 G4 P1 G1 X3\n",
            Dialect::LinuxCnc,
            "line 5, column 5: ",
            "line of its own",
        ),
        (
            "X9 Y1\n G91 X5\n",
            Dialect::LinuxCnc,
            "line 5, column 6: ",
            "lostmotion gcode write",
        ),
        // What stays when plain lines are made is not sent there.
        (
            "M3 S500\nG33 Z-2 K1\n",
            Dialect::LinuxCnc,
            "line 5, column 1: ",
            "it goes with the spindle",
        ),
        (
            "G38.2 Z-5\n",
            Dialect::LinuxCnc,
            "line 4, column 1: ",
            "where the probe touches",
        ),
        (
            "G93 G1 X9 F60\n",
            Dialect::LinuxCnc,
            "line 4, column 1: ",
            "write feeds a minute (G94)",
        ),
        (
            "G5 X9 Y9 I3 J0 P0 Q-3\n",
            Dialect::LinuxCnc,
            "line 4, column 1: ",
            "write splines as short lines",
        ),
        (
            "G2 X20 Y0 I10 J0 M1\n",
            Dialect::LinuxCnc,
            "line 4, column 18: ",
            "put the M code on a line of its own",
        ),
        (
            "G2 X20 Y0 I10 J0 E2\n",
            Dialect::Marlin,
            "line 4, column 18: ",
            "have the slicer write lines",
        ),
    ] {
        let error = refused(&format!("{head}{rest}M30\n"), dialect);
        assert!(error.starts_with(place) && error.contains(what), "{error}");
    }
    let error = refused(&format!("{head}G7 X9\nX0\nM2\n"), Dialect::LinuxCnc);
    assert!(
        error.contains("what is under diameters (G7) is not rewritten"),
        "{error}"
    );
    // What cannot be read is told by the front end, which knows whether the program comes there.
    let bad = Program::from_str("part.nc", format!("{head}G1 X1..2\nM30\n"));
    let error = rewritten(&bad, Dialect::LinuxCnc).unwrap_err();
    assert!(matches!(error, RewriteError::Sim(_)), "{error}");
}

/// A cut at the end of travel, where half a gap has no room: by the line of the original.
#[test]
fn what_the_new_program_is_refused_for_is_told_by_the_line_of_the_original() {
    let text =
        "g17 g21 g90 g0 x0 y0 f100\ng1 x1.5e-3 y-2.5E+1\ng2 x10 y-25 i5 j0 k0\ng1 z300\nx1\n";
    let error = refused(text, Dialect::LinuxCnc);
    assert!(
        error.starts_with("line 4: with half a gap added it cannot be run: axis Z to 0.020 mm")
            && error.contains("move the origin of G54"),
        "{error}"
    );
}

/// Corners that the tolerance rounds to next to nothing: no rewriting helps.
#[test]
fn a_program_that_is_not_helped_names_its_worst_lines() {
    let mut text = "G21 G90 G17 G64 P0.05\nG0 X0 Y0 Z1\nG1 Z-1 F300\n".to_owned();
    for step in 1..60 {
        let y = if step % 2 == 0 { 0.0 } else { 0.01 };
        text.push_str(&format!("G1 X{:.2} Y{y} F900\n", 0.2 * f64::from(step)));
    }
    text.push_str("G0 Z5\nM2\n");
    let new = rewritten(&Program::from_str("part.nc", &text), Dialect::LinuxCnc).unwrap();
    let reason = new.refused.unwrap_or_default();
    for part in [
        "it does not help enough",
        "the worst before is on line ",
        ", after on line ",
        " um, before at most ",
    ] {
        assert!(reason.contains(part), "{reason}");
    }
    // Which of the runs it is refused for is the reason's to say.
    let runs = new.uncertain.iter().map(|end| end.after.max_um);
    let mut most = runs
        .chain([new.after.max_um])
        .map(|um| format!("({um:.2} um, before"));
    assert!(most.any(|most| reason.contains(&most)), "{reason}");
}

/// Where nothing is cut there is nothing to help.
#[test]
fn a_program_without_a_cut_is_not_written() {
    let part = Program::from_str("part.nc", "G21 G90\nG0 X5 Y5 Z5\nG0 X0\nM2\n");
    let new = rewritten(&part, Dialect::LinuxCnc).unwrap();
    let reason = new.refused.unwrap_or_default();
    assert!(reason.contains("nothing is cut"), "{reason}");
}

/// Lines of a new program that move.
fn moves(text: &str) -> Vec<String> {
    let program = Program::from_str("part.nc", text);
    let new = rewritten(&program, Dialect::LinuxCnc).unwrap();
    let moves = new.text.lines().filter(|line| line.starts_with('G'));
    moves.map(str::to_owned).collect()
}

/// Below its place there may be a table, and beside it a wall.
#[test]
fn rapids_go_beyond_their_places_only_where_nothing_can_be() {
    // The first feed moves of Z go up, those of X away from a wall.
    let new = moves(
        "G21 G90 G17\nG0 Z20\nG0 Y-10\nG0 Z-5\nG0 X-5.2\nG1 Y50 F400\nG1 X-20\nG1 Z2\nG0 Z20\nM2\n",
    );
    let wanted = [
        "G0 Z20.48",
        "G0 Z19.98 (backlash of Z)",
        "G0 Y-10.48",
        "G0 Y-9.98 (backlash of Y)",
        "G0 Z-5.02",
        "G0 X-5.2",
        "G1 Y50.02 F400",
    ];
    assert_eq!(new[1..=7], wanted, "{new:?}");
    // X and Y where Z is not known yet: once it is.
    let new = moves("G21 G90 G17\nG0 X-30 Y0\nG0 Z5\nG1 Z-1 F200\nG1 X30 F400\nG1 Y9\nG0 Z5\nM2\n");
    let wanted = [
        "G0 X-30. Y0.",
        "G0 Z5.48",
        "G0 Z4.98 (backlash of Z)",
        "G0 X-30.48 Y-0.48 (backlash of X Y)",
        "G0 X-29.98 Y0.02 (backlash of X Y)",
        "G1 Z-1.02 F200",
    ];
    assert_eq!(new[1..=6], wanted, "{new:?}");
}

/// A place of the machine whose coordinate an axis has already is half a gap away all the same, and an axis
/// at home that does not move has no room for it.
#[test]
fn ways_home_are_those_of_the_new_program() {
    for home in ["G30", "G53 G0 X-381 Z0", "G28", "G28 Z20\nG30"] {
        let text = format!(
            "G21 G90 G17\nG0 Z10\nG0 X0 Y0\nG1 Z-1 F200\nG1 X20 F400\nG1 X0\nG0 Z20\n{home}\nG0 X10 Y10\nG0 Z1\nG1 X30 F400\nG1 X10\nG0 Z10\nM2\n"
        );
        assert!(moves(&text).contains(&home.lines().last().unwrap().to_owned()));
    }
    let new = moves(
        "G21 G90 G17\nG91 G28 Z0\nG90\nG28 X0 Y0\nG1 Z-10 F1000\nG0 X0 Y0\nG1 Z-11 F200\nG1 X30 F400\nG1 Y9\nG1 X0\nG1 Y0\nG0 Z5\nM2\n",
    );
    assert!(new.contains(&"G1 Z-10.02 F1000".to_owned()), "{new:?}");
}

#[test]
fn what_the_control_may_do_otherwise_is_refused_and_all_of_it_told() {
    let error = refused(
        "G21 G17 G90 G94\n/G0 X0 Y0 Z5\nG1 X5 F100\nIF [#500 EQ 1] GOTO 100\nG1 X0\nN100 G1 X#1\nG1 X#1\nM30\n",
        Dialect::Fanuc,
    );
    let told: Vec<&str> = error.lines().collect();
    assert_eq!(told.len(), 3, "{error}");
    assert!(
        told[0].starts_with("line 2, column 1: a block that may be skipped"),
        "{error}"
    );
    assert!(
        told[1].starts_with("line 4, ") && told[1].contains("the control decides"),
        "{error}"
    );
    assert!(
        told[2].contains("X is an expression") && told[2].ends_with("(so on lines 7)"),
        "{error}"
    );
    let error = refused(
        "G21 G17 G90\no1 if [#5399 EQ 0]\nG0 X1\no1 endif\nM2\n",
        Dialect::LinuxCnc,
    );
    assert!(
        error.starts_with("line 2, ") && error.contains("the control decides"),
        "{error}"
    );
}

/// What is told of one axis makes no other one exact, and 0 is an answer.
#[test]
fn gaps_of_which_nothing_is_told_may_be_off_as_usual() {
    let text =
        "G21 G90 G17 G64 P0.01\nG0 X0 Y0 Z5\nG1 Z-1 F300\nX40 F900\nY30\nX0\nY0\nG0 Z5\nM2\n";
    let machine = machine().edit(|m| {
        m.axis("x").compensation.gap_uncertainty = 0.1;
    });
    let of = |gap_uncertainty| {
        let wanted = RewriteOptions {
            most_normal_um: 0.0,
            gap_uncertainty,
            ..RewriteOptions::default()
        };
        let program = Program::from_str("part.nc", text);
        let options = SimulateOptions::default();
        rewrite(&program, machine.as_ref().unwrap(), &options, &wanted).unwrap()
    };
    let new = of(None);
    assert_eq!(
        new.uncertain[0]
            .factors
            .map(|factor| (100.0 * factor).round()),
        [90.0, 70.0, 70.0]
    );
    assert_eq!(
        (new.is_uncertainty_told, new.untold),
        (false, vec!["Y".to_owned(), "Z".to_owned()])
    );
    let new = of(Some(0.0));
    assert!(new.is_uncertainty_told && new.uncertain.is_empty());
}

#[test]
fn pieces_of_arcs_are_marked() {
    let new =
        moves("G21 G17 G90\nG0 Z5\nG0 X10 Y0\nG1 Z0 F300\nG2 X10 Y0 I-10 J0 F400\nG0 Z5\nM2\n");
    let arcs: Vec<&String> = new.iter().filter(|line| line.starts_with("G2 ")).collect();
    assert!(
        arcs.len() > 3
            && arcs[1..]
                .iter()
                .all(|line| line.ends_with("(backlash: piece)")),
        "{new:?}"
    );
}
