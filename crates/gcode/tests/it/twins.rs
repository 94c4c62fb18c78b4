//! One part programmed in two ways gives the same canonical operations, to the bit.
//!
//! Coordinates are whole multiples of a unit that is exact in an f64: 5 in = 127 mm (25.4 times up
//! to 635 in rounds to the exact product), or 1/16 mm. So nothing is rounded on either way and
//! equality needs no tolerance.
use lostmotion_gcode::{CanonicalOp, InterpreterConfig, Position, Program, Units};
use proptest::prelude::*;
use std::fmt::Write;

/// How a part is written down.
#[derive(Clone, Copy)]
struct Way {
    head: &'static str,
    /// Length of one unit in the program's units.
    unit: f64,
    incremental: bool,
}

const INCH: Way = Way {
    head: "G20",
    unit: 5.0,
    incremental: false,
};
const MM: Way = Way {
    head: "G21",
    unit: 127.0,
    incremental: false,
};
const FINE: Way = Way {
    head: "G21",
    unit: 0.0625,
    incremental: false,
};

/// One step of a part; numbers are units, places are absolute.
#[derive(Clone, Debug)]
enum Step {
    Straight {
        feed: bool,
        to: [i32; 3],
        turn_deg: i32,
    },
    /// A quarter of a circle about a centre that lies so far from the start.
    Quarter {
        clockwise: bool,
        center: [i32; 2],
    },
    Hole {
        cycle: usize,
        at: [i32; 2],
        below: i32,
        depth: i32,
    },
    Feed(i32),
    Shift([i32; 3]),
    System(bool),
    Dwell(i32),
}

fn step() -> impl Strategy<Value = Step> {
    let place = || prop::array::uniform3(-30i32..30);
    let near = || prop::array::uniform2(-3i32..4);
    prop_oneof![
        4 => (any::<bool>(), place(), -720i32..720).prop_map(|(feed, to, turn_deg)| Step::Straight { feed, to, turn_deg }),
        3 => (any::<bool>(), near()).prop_map(|(clockwise, center)| Step::Quarter { clockwise, center }),
        2 => (0usize..4, prop::array::uniform2(-30i32..30), 0i32..5, 1i32..5)
            .prop_map(|(cycle, at, below, depth)| Step::Hole { cycle, at, below, depth }),
        1 => (1i32..100).prop_map(Step::Feed),
        1 => place().prop_map(Step::Shift),
        1 => any::<bool>().prop_map(Step::System),
        1 => (0i32..9).prop_map(Step::Dwell),
    ]
}

/// The part as a program. Keeps the place in program coordinates, in units.
struct Writer {
    way: Way,
    text: String,
    at: [i32; 3],
    turn_deg: i32,
    shift: [i32; 3],
    system: [i32; 3],
}

/// Origin of the second work coordinate system.
const SECOND: [i32; 3] = [2, -3, 4];

fn write(way: Way, steps: &[Step]) -> String {
    let mut writer = Writer {
        way,
        text: String::new(),
        at: [0; 3],
        turn_deg: 0,
        shift: [0; 3],
        system: [0; 3],
    };
    let [x, y, z] = SECOND.map(|value| writer.length(value));
    let distance = if way.incremental { "G91" } else { "G90" };
    writer.text = format!(
        "{} G17 G98 {distance}\nG10 L2 P2 X{x} Y{y} Z{z}\nF{}\n",
        way.head,
        writer.length(7)
    );
    for step in steps {
        writer.step(step);
    }
    writer.text + "M2\n"
}

impl Writer {
    fn length(&self, units: i32) -> f64 {
        f64::from(units) * self.way.unit
    }

    /// X, Y or Z words that lead from one place to another.
    fn words(&mut self, letters: &str, from: &[i32], to: &[i32]) {
        for ((letter, from), to) in letters.chars().zip(from).zip(to) {
            let value = self.length(if self.way.incremental { to - from } else { *to });
            let _ = write!(self.text, " {letter}{value}");
        }
    }

    /// The origin goes somewhere else, the machine stays.
    fn origin(&mut self, change: impl FnOnce(&mut Writer)) {
        let machine: [i32; 3] =
            std::array::from_fn(|i| self.at[i] + self.shift[i] + self.system[i]);
        change(self);
        self.at = std::array::from_fn(|i| machine[i] - self.shift[i] - self.system[i]);
    }

    fn step(&mut self, step: &Step) {
        let at = self.at;
        match *step {
            Step::Straight { feed, to, turn_deg } => {
                self.text += if feed { "G1" } else { "G0" };
                self.words("XYZ", &at, &to);
                let turn = if self.way.incremental {
                    turn_deg - self.turn_deg
                } else {
                    turn_deg
                };
                let _ = write!(self.text, " A{turn}");
                (self.at, self.turn_deg) = (to, turn_deg);
            }
            Step::Quarter {
                clockwise,
                center: [i, j],
            } if i != 0 || j != 0 => {
                let [x, y] = if clockwise { [-j, i] } else { [j, -i] };
                let to = [at[0] + i + x, at[1] + j + y];
                self.text += if clockwise { "G2" } else { "G3" };
                self.words("XY", &at[..2], &to);
                let _ = write!(self.text, " I{} J{}", self.length(i), self.length(j));
                self.at = [to[0], to[1], at[2]];
            }
            Step::Quarter { .. } => {}
            Step::Hole {
                cycle,
                at: to,
                below,
                depth,
            } => {
                let clear = at[2] - below;
                self.text += ["G81", "G82 P1", "G85", "G89 P2"][cycle];
                self.words("XY", &at[..2], &to);
                self.words("R", &at[2..], &[clear]);
                self.words("Z", &[clear], &[clear - depth]);
                self.text += "\nG80";
                self.at = [to[0], to[1], at[2]];
            }
            Step::Feed(units) => {
                let _ = write!(self.text, "F{}", self.length(units));
            }
            Step::Shift(shift) => {
                let [x, y, z] = shift.map(|value| self.length(value));
                let _ = write!(self.text, "G52 X{x} Y{y} Z{z}");
                self.origin(|writer| writer.shift = shift);
            }
            Step::System(second) => {
                self.text += if second { "G55" } else { "G54" };
                self.origin(|writer| writer.system = if second { SECOND } else { [0; 3] });
            }
            Step::Dwell(seconds) => {
                let _ = write!(self.text, "G4 P{seconds}");
            }
        }
        self.text.push('\n');
    }
}

fn ops(text: &str) -> Vec<CanonicalOp> {
    let mut program = Program::new(text.as_bytes(), InterpreterConfig::default());
    let ops = program.by_ref().map(|sourced| sourced.op).collect();
    assert_eq!(
        program.diagnostics().errors(),
        0,
        "{text}\n{:?}",
        program.diagnostics().kept()
    );
    ops
}

/// An operation in inches as one in millimetres.
fn in_mm(op: CanonicalOp) -> CanonicalOp {
    use CanonicalOp as O;
    let mm = |length| Units::Inch.convert(length, Units::Mm);
    let place = |position: Position| {
        std::array::from_fn(|axis| {
            if (3..6).contains(&axis) {
                position[axis]
            } else {
                mm(position[axis])
            }
        })
    };
    match op {
        O::UseLengthUnits(_) => O::UseLengthUnits(Units::Mm),
        O::SetG5xOffset { system, offset } => O::SetG5xOffset {
            system,
            offset: place(offset),
        },
        O::SetG92Offset(offset) => O::SetG92Offset(place(offset)),
        O::SetFeedRate { rate, inverse_time } => O::SetFeedRate {
            rate: mm(rate),
            inverse_time,
        },
        O::StraightTraverse(end) => O::StraightTraverse(place(end)),
        O::StraightFeed(end) => O::StraightFeed(place(end)),
        O::ArcFeed(mut arc) => {
            (arc.end, arc.center, arc.axis_end) =
                (arc.end.map(mm), arc.center.map(mm), mm(arc.axis_end));
            O::ArcFeed(arc)
        }
        other => other,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn inches_and_millimetres(steps in prop::collection::vec(step(), 1..15), incremental in any::<bool>()) {
        let inch: Vec<_> = ops(&write(Way { incremental, ..INCH }, &steps)).into_iter().map(in_mm).collect();
        prop_assert_eq!(inch, ops(&write(Way { incremental, ..MM }, &steps)));
    }

    #[test]
    fn absolute_and_incremental(steps in prop::collection::vec(step(), 1..15)) {
        prop_assert_eq!(ops(&write(Way { incremental: true, ..FINE }, &steps)), ops(&write(FINE, &steps)));
    }
}

#[test]
fn twins_differ_where_they_should() {
    let steps = [
        Step::Straight {
            feed: true,
            to: [1, 2, 3],
            turn_deg: 0,
        },
        Step::Straight {
            feed: true,
            to: [2, 2, 3],
            turn_deg: 0,
        },
    ];
    assert_ne!(ops(&write(INCH, &steps)), ops(&write(MM, &steps)));
    assert_ne!(
        write(FINE, &steps),
        write(
            Way {
                incremental: true,
                ..FINE
            },
            &steps
        )
    );
}
