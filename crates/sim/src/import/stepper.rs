//! The drive of an axis that a stepper moves, open loop.
//!
//! The field of the phases turns with the command, and the rotor follows it as on a spring. With
//! `p` pole pairs (a quarter of the full steps of a turn), the holding torque `T_h` at the current
//! that is set, and the inertia `J` of all that turns:
//!
//! ```text
//! stiffness     dT/dangle = p T_h at the middle       the torque never exceeds T_h: pull-out
//! own frequency w = sqrt(p T_h/J)                     lightly damped: DAMPING
//! lost steps    beyond a quarter of an electrical turn, one full step
//! ```
//! Written with the keys of any drive, that is a position gain of `p T_h/d` over a velocity gain of
//! `d/K`, `d` the damping torque per speed and `K` the torque constant, a current limit of `T_h/K`, no integral part, no feed-forward of the acceleration,
//! and a machine that stops where a stepper would lose a step. The spring is straight up to the
//! pull-out torque where a stepper's is a sine; the winding's inductance and the supply limit the
//! torque at speed. A two-phase motor in the three-phase frame of a drive: all voltages times 2/3.
//!
//! What no configuration of a control tells (motor, mass, friction, stiffness, gap) is a guess of
//! its class, and listed as one.

use super::draft::{DraftAxis, Fate, MachineSize, Row, StepperDraft, Told, float};
use lostmotion_base::math;
use std::f64::consts::{SQRT_2, TAU};
use std::fmt::Write;

/// Cycles in which the rotor is followed, us, and up to which own frequency of the rotor alone, rad/s. A choice:
/// short against a quarter of its period. Motors of 1.8 degrees swing at some 2000 rad/s, those of 0.9 degrees
/// sqrt 2 times as fast.
const SERVO_US: f64 = 125.0;
const SLOW_ROTOR_RAD_S: f64 = 2350.0;
const SHORT_SERVO_US: f64 = 62.5;

/// Damping of the rotor on its spring, of the critical one. A choice: drivers that damp resonance
/// reach some tenths, plain ones a few hundredths, at which mid-band resonance makes motors stall.
const DAMPING: f64 = 0.4;

/// Most that the drive damps the rotor alone, 1/s: what the delays of the model's loops bear. Behind
/// a soft belt the rotor swings without its load.
const MOST_DAMPING_PER_S: f64 = 2000.0;

/// Damping of a spring, over the part of it that delays take away: the gain margin of its loop, here 2.6 dB. A
/// choice: above the 2 dB that are asked for below, and no more than the motors of 1.8 degrees have anyway.
const DELAY_MARGIN: f64 = 1.35;

/// Delay of position and speed as the loop sees them, in servo cycles; that of the current comes to it.
const DELAY_CYCLES: f64 = 0.75;

/// Margins that a stepper has to have, deg and dB: those of a spring with a twentieth of the critical
/// damping.
const LEAST_PHASE_DEG: f64 = 5.0;
const LEAST_GAIN_DB: f64 = 2.0;

/// Highest resonance of the load that is guessed, Hz: what is stiffer is rigid here.
const RIGID_HZ: f64 = 500.0;

/// Bandwidth of the current in a winding, Hz. A choice: choppers of 20 to 40 kHz follow within some 0.1 ms, but
/// for a microstep that is seen as a speed over one period here a faster loop asks for more than the supply has.
const CURRENT_HZ: f64 = 750.0;

/// Integral time that makes the integral part nothing, s.
const NO_INTEGRAL_S: f64 = 1000.0;

/// Part of the pull-out torque that a machine which runs leaves to its acceleration: the guess of
/// the mass goes no further.
const TORQUE_FOR_ACCELERATION: f64 = 0.5;

/// Inertia of the load over that of the rotor up to which makers recommend their steppers: the guess of
/// the mass goes no further.
const LOAD_RATIO: f64 = 10.0;

/// Part of the pull-out torque that the guess of friction goes to.
const TORQUE_FOR_FRICTION: f64 = 0.1;

/// Gap of a machine of which none is told, mm and deg. A choice: owners set 0.03 to 0.35 mm in the
/// controls of routers and small mills.
const GAP_UNITS: f64 = 0.05;

/// Damping of the slide on its screw or belt, of the critical one.
const SLIDE_DAMPING: f64 = 0.05;

/// Travel of a turn from which a belt or a rack is the likely drive, mm.
const BELT_MM: f64 = 20.0;

/// Room above the voltage that the told speed needs.
const SUPPLY_ROOM: f64 = 1.2;

/// Travels of a turn that are sold: screws, then pulleys and racks, mm.
const USUAL_TURNS_MM: [f64; 16] = [
    1.25, 1.5, 2.0, 2.5, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0, 25.0, 32.0, 40.0,
];

/// Microsteps that drivers are set to, the most common first.
const USUAL_MICROSTEPS: [f64; 9] = [16.0, 8.0, 32.0, 10.0, 4.0, 64.0, 2.0, 5.0, 1.0];

/// A size of motors, as catalogues have it.
struct MotorClass {
    name: &'static str,
    /// Holding torque with both phases at the rated current, N m.
    holding_nm: f64,
    /// Rated current of a phase, A.
    rated_a: f64,
    phase_ohm: f64,
    phase_h: f64,
    inertia_kgm2: f64,
    supply_v: f64,
}

/// Frame of 42 mm (NEMA 17), 40 mm long.
const SMALL: MotorClass = MotorClass {
    name: "NEMA 17, 0.40 N m, 1.7 A",
    holding_nm: 0.40,
    rated_a: 1.7,
    phase_ohm: 1.5,
    phase_h: 0.0028,
    inertia_kgm2: 5.4e-6,
    supply_v: 24.0,
};

/// Frame of 57 mm (NEMA 23), 56 mm long.
const LARGE: MotorClass = MotorClass {
    name: "NEMA 23, 1.26 N m, 2.8 A",
    holding_nm: 1.26,
    rated_a: 2.8,
    phase_ohm: 0.9,
    phase_h: 0.0025,
    inertia_kgm2: 30e-6,
    supply_v: 36.0,
};

/// Amplitude of a phase's current from which the motor is of the larger class, A.
const LARGE_FROM_A: f64 = 2.6;

/// The load that a machine of a size has, where nothing is told: kg, N, N/um of a screw, N/um of a belt.
struct Typical {
    mass_kg: f64,
    friction_n: f64,
    screw_n_per_um: f64,
    belt_n_per_um: f64,
}

const PRINTER: Typical = Typical {
    mass_kg: 1.0,
    friction_n: 3.0,
    screw_n_per_um: 5.0,
    belt_n_per_um: 0.1,
};

const ROUTER: Typical = Typical {
    mass_kg: 10.0,
    friction_n: 20.0,
    screw_n_per_um: 20.0,
    belt_n_per_um: 0.5,
};

/// Inertia of a rotary table and its friction, behind a worm.
const TABLE_KGM2: f64 = 0.02;
const TABLE_FRICTION_NM: f64 = 1.0;
const TABLE_NM_PER_RAD: f64 = 2e4;

/// What one turn of the motor is: mm or deg for a turn, full steps, microsteps, and what of it is a
/// guess.
struct Turn {
    units: f64,
    full_steps: f64,
    microsteps: f64,
    told: String,
    guess: Option<String>,
}

fn turn(stepper: &StepperDraft, rotary: bool) -> Turn {
    let full_steps = stepper.full_steps.as_ref().map_or(200.0, |it| it.value);
    let microsteps = stepper.microsteps.as_ref().map(|it| it.value);
    if let Some(told) = &stepper.per_turn {
        return Turn {
            units: told.value,
            full_steps,
            microsteps: microsteps.unwrap_or(16.0),
            told: told.from.clone(),
            guess: microsteps
                .is_none()
                .then(|| "16 microsteps of a full step".to_owned()),
        };
    }
    let Some(steps) = &stepper.steps_per_unit else {
        let units = if rotary { 4.0 } else { 8.0 };
        return Turn {
            units,
            full_steps,
            microsteps: microsteps.unwrap_or(16.0),
            told: "guess".to_owned(),
            guess: Some(format!("{units} for a turn of the motor")),
        };
    };
    let units = |microsteps: f64| full_steps * microsteps / steps.value;
    // Steps alone do not tell the screw from the driver's setting: the first pair of what is sold.
    let usual = || {
        USUAL_MICROSTEPS.into_iter().find(|micro| {
            let turn = units(*micro);
            // No table turns faster than its motor.
            (rotary && turn <= 360.0)
                || (!rotary
                    && USUAL_TURNS_MM
                        .iter()
                        .any(|known| (turn / known - 1.0).abs() < 2e-3))
        })
    };
    let chosen = microsteps.or_else(usual).unwrap_or(16.0);
    Turn {
        units: units(chosen),
        full_steps,
        microsteps: chosen,
        told: format!("{}, {chosen} microsteps", steps.from),
        guess: microsteps
            .is_none()
            .then(|| format!("{chosen} microsteps of a full step")),
    }
}

/// The axis' sections behind its limits, which are velocity and acceleration, mm or deg and s.
pub(super) fn drive(
    axis: &DraftAxis,
    stepper: &StepperDraft,
    size: MachineSize,
    limits: [f64; 2],
    out: &mut String,
    rows: &mut Vec<Row>,
) {
    let motor = SetMotor::new(stepper, size, axis.rotary);
    let load = GuessedLoad::new(&motor, size, axis.rotary, limits);
    let spring = RotorSpring::new(&motor, &load);
    let mut sections = Sections {
        axis,
        letter: axis.id.letter().to_ascii_lowercase(),
        out,
        rows,
    };
    sections.guess_motor(&motor);
    let supply_v = sections.guess_supply(&motor, &load, limits);
    sections.transmission(&motor.turn);
    sections.motor(&motor);
    sections.load(&load);
    sections.gap();
    sections.gains(&motor, &spring, supply_v);
    sections.monitoring(&motor.turn, limits);
}

/// The cycle in which all rotors of a machine are followed, us; the usual one where no axis is a stepper's.
pub(super) fn servo_us(axes: &[DraftAxis], size: MachineSize) -> f64 {
    let cycles = axes.iter().filter_map(|axis| {
        let stepper = axis.stepper.as_ref()?;
        Some(SetMotor::new(stepper, size, axis.rotary).servo_us())
    });
    cycles.fold(SERVO_US, f64::min)
}

/// The motor of an axis: its class, a guess, with the current and the microsteps that are set.
struct SetMotor<'a> {
    turn: Turn,
    class: &'static MotorClass,
    /// Torque constant, N m/A.
    constant: f64,
    /// Of a phase's winding.
    phase_ohm: f64,
    phase_h: f64,
    /// The amplitude of the current where the file tells it.
    told_peak: Option<&'a Told>,
    /// Amplitude of the current, A.
    peak_a: f64,
    /// Holding torque at that current, N m.
    pull_out: f64,
    poles: f64,
}

impl<'a> SetMotor<'a> {
    fn new(stepper: &'a StepperDraft, size: MachineSize, rotary: bool) -> SetMotor<'a> {
        let turn = turn(stepper, rotary);
        let peak = stepper.peak_current_a.as_ref();
        let class = match (peak, size) {
            (Some(peak), _) if peak.value >= LARGE_FROM_A => &LARGE,
            (None, MachineSize::Router) => &LARGE,
            _ => &SMALL,
        };
        // Both phases at the rated current are a vector sqrt 2 times as long.
        let rated_a = SQRT_2 * class.rated_a;
        let peak_a = peak.map_or(rated_a, |peak| peak.value);
        // No motor is driven beyond its rating: for more current the class has windings of fewer turns, whose
        // resistance and inductance go with the square.
        let turns = (rated_a / peak_a).min(1.0);
        let constant = turns * class.holding_nm / rated_a;
        SetMotor {
            class,
            constant,
            phase_ohm: turns * turns * class.phase_ohm,
            phase_h: turns * turns * class.phase_h,
            told_peak: peak,
            peak_a,
            pull_out: constant * peak_a,
            poles: 2.0 * (turn.full_steps / 4.0).round().max(1.0),
            turn,
        }
    }

    /// Torque of the field for an angle, N m/rad.
    fn stiffness(&self) -> f64 {
        0.5 * self.poles * self.pull_out
    }

    /// Cycle in which the rotor has to be followed, us.
    fn servo_us(&self) -> f64 {
        let slow = SLOW_ROTOR_RAD_S * SLOW_ROTOR_RAD_S * self.class.inertia_kgm2;
        if self.stiffness() <= slow {
            SERVO_US
        } else {
            SHORT_SERVO_US
        }
    }

    /// Radians of the motor for a mm or deg.
    fn per_unit(&self) -> f64 {
        TAU / self.turn.units
    }
}

/// The load that is guessed: what is typical, or less where the machine could not run as it is set.
struct GuessedLoad {
    /// kg, or kg m2 of a table.
    inertia: f64,
    /// N, or N m of a table.
    friction: f64,
    /// N/um, or N m/rad of a table.
    stiffness: f64,
    is_belt: bool,
    /// Travel for a radian of the motor, m, or rad of a table.
    metres_per_rad: f64,
    /// Inertia of rotor and load at the motor, kg m2.
    at_motor: f64,
}

impl GuessedLoad {
    fn new(
        motor: &SetMotor<'_>,
        size: MachineSize,
        rotary: bool,
        [_, acceleration]: [f64; 2],
    ) -> GuessedLoad {
        let (class, turn) = (motor.class, &motor.turn);
        let typical = match size {
            MachineSize::Printer => &PRINTER,
            MachineSize::Router => &ROUTER,
        };
        let angle = if rotary { 360.0 } else { TAU };
        let metres_per_rad = turn.units / angle * if rotary { 1.0 } else { 1e-3 };
        let spare = (TORQUE_FOR_ACCELERATION * motor.pull_out / (acceleration * motor.per_unit())
            - class.inertia_kgm2)
            .max(0.1 * class.inertia_kgm2);
        let reflected = |load: f64| load * metres_per_rad * metres_per_rad;
        let (usual_load, usual_friction) = if rotary {
            (TABLE_KGM2, TABLE_FRICTION_NM)
        } else {
            (typical.mass_kg, typical.friction_n)
        };
        let most = spare.min(LOAD_RATIO * class.inertia_kgm2);
        let load = usual_load.min(most / reflected(1.0));
        let is_belt = !rotary && turn.units >= BELT_MM;
        let stiffness = match (rotary, is_belt) {
            (true, _) => TABLE_NM_PER_RAD,
            (false, true) => typical.belt_n_per_um,
            (false, false) => typical.screw_n_per_um,
        };
        let rigid = TAU * RIGID_HZ * TAU * RIGID_HZ
            / (1.0 / class.inertia_kgm2 + 1.0 / reflected(load))
            / reflected(if rotary { 1.0 } else { 1e6 });
        GuessedLoad {
            inertia: load,
            friction: usual_friction.min(TORQUE_FOR_FRICTION * motor.pull_out / metres_per_rad),
            stiffness: stiffness.min(rigid),
            is_belt,
            metres_per_rad,
            at_motor: class.inertia_kgm2 + reflected(load),
        }
    }
}

/// The rotor on the field of its phases: see the head of the file.
struct RotorSpring {
    /// Torque for an angle, N m/rad.
    stiffness: f64,
    /// Own frequency with the load, rad/s.
    own: f64,
    /// Torque for a speed, N m s/rad.
    damping: f64,
}

impl RotorSpring {
    fn new(motor: &SetMotor<'_>, load: &GuessedLoad) -> RotorSpring {
        let stiffness = motor.stiffness();
        let own = (stiffness / load.at_motor).sqrt();
        // A spring that answers late pushes along with the speed: so much damping less.
        let delay_s = 1.0 / (TAU * CURRENT_HZ) + DELAY_CYCLES * motor.servo_us() * 1e-6;
        let damping = (2.0 * DAMPING * own * load.at_motor)
            .min(MOST_DAMPING_PER_S * motor.class.inertia_kgm2)
            .max(DELAY_MARGIN * stiffness * delay_s);
        RotorSpring {
            stiffness,
            own,
            damping,
        }
    }
}

/// The axis' sections in the machine file, and the guesses of them in the report.
struct Sections<'a> {
    axis: &'a DraftAxis,
    letter: char,
    out: &'a mut String,
    rows: &'a mut Vec<Row>,
}

impl Sections<'_> {
    /// Lists a guess in the report.
    fn guess(&mut self, key: &str, value: String, note: &str) {
        self.rows.push(Row {
            key: format!("axis.{}.{key}", self.letter),
            value,
            fate: Fate::Guessed,
            note: note.to_owned(),
        });
    }

    /// Writes lines of the machine file.
    fn line(&mut self, text: &str) {
        let _ = writeln!(self.out, "{text}");
    }

    /// Lists what of the motor and its turn is not told.
    fn guess_motor(&mut self, motor: &SetMotor<'_>) {
        if let Some(what) = &motor.turn.guess {
            self.guess(
                "transmission",
                what.clone(),
                "read the driver's switches and the screw: together they give the steps",
            );
        }
        self.guess(
            "motor",
            motor.class.name.to_owned(),
            if motor.phase_ohm < motor.class.phase_ohm {
                "with a winding for the current that is told; the motor's plate tells torque and current"
            } else {
                "the motor's plate tells torque and current"
            },
        );
        if motor.told_peak.is_none() {
            self.guess(
                "drive.current_limit_a",
                float(motor.peak_a),
                "the motor's rated current: the driver's setting is not told",
            );
        }
    }

    /// The supply, V: what the class has, or what the told speed needs. Lists it.
    fn guess_supply(
        &mut self,
        motor: &SetMotor<'_>,
        load: &GuessedLoad,
        [velocity, acceleration]: [f64; 2],
    ) -> f64 {
        let class = motor.class;
        let speed = velocity * motor.per_unit();
        let torque =
            load.at_motor * acceleration * motor.per_unit() + load.friction * load.metres_per_rad;
        let current = torque / motor.constant;
        let needed = math::hypot(
            motor.constant * speed + motor.phase_ohm * current,
            0.5 * motor.poles * speed * motor.phase_h * current,
        );
        let supply = class.supply_v.max((SUPPLY_ROOM * needed).ceil());
        let note = if supply > class.supply_v {
            "the told speed needs it here: drivers get there with less by weakening the field, which is not modelled"
        } else {
            "as the driver's supply says"
        };
        self.guess("drive", format!("supply of {supply} V"), note);
        supply
    }

    /// Writes the transmission.
    fn transmission(&mut self, turn: &Turn) {
        let letter = self.letter;
        let text = if self.axis.rotary {
            format!(
                "\n[axis.{letter}.transmission.rotary]\ngear = {} # {}\nunit = \"deg\"",
                float(360.0 / turn.units),
                turn.told
            )
        } else {
            format!(
                "\n[axis.{letter}.transmission.linear]\nlead_mm = {} # {}",
                float(turn.units),
                turn.told
            )
        };
        self.line(&text);
    }

    /// Writes the motor, a phase's values brought to the frame of a drive.
    fn motor(&mut self, motor: &SetMotor<'_>) {
        let class = motor.class;
        self.line(&format!(
            "\n# stepper, open loop, {} full steps of a turn; guess: {}. A phase's values, times 4/3 for the frame of a drive\n[axis.{}.motor]\nresistance_ohm = {}\ninductance_h = {}\npoles = {}\ninertia_kgm2 = {:?}\ntorque_constant_nm_per_a = {}\nrated_torque_nm = {}\ncoulomb_nm = {}",
            motor.turn.full_steps,
            class.name,
            self.letter,
            float(motor.phase_ohm * 4.0 / 3.0),
            float(motor.phase_h * 4.0 / 3.0),
            motor.poles,
            class.inertia_kgm2,
            float(motor.constant),
            float(class.holding_nm),
            float(0.02 * class.holding_nm),
        ));
    }

    /// The gap, mm or deg, and where it is told.
    fn told_gap(&self) -> (f64, &str) {
        let gap = self.axis.gap.as_ref();
        gap.map_or((GAP_UNITS, "guess"), |gap| (gap.value, gap.from.as_str()))
    }

    /// Writes the load with its gap, and lists it.
    fn load(&mut self, load: &GuessedLoad) {
        let letter = self.letter;
        let (gap_units, gap_from) = self.told_gap();
        let (inertia, friction, stiffness) = (load.inertia, load.friction, load.stiffness);
        if self.axis.rotary {
            let own_damping = 2.0 * SLIDE_DAMPING * (stiffness * inertia).sqrt();
            let text = format!(
                "\n# guesses\n[axis.{letter}.load.table]\ninertia_kgm2 = {inertia:?}\ncoulomb_nm = {}\nstiffness_nm_per_rad = {}\ndamping_nm_s_per_rad = {}\ngap_mdeg = {} # {gap_from}",
                float(friction),
                float(stiffness),
                float(own_damping),
                float(gap_units * 1e3),
            );
            self.line(&text);
            self.guess(
                "load.table",
                format!("{inertia:.3} kg m2, {friction:.2} N m of friction"),
                "of small worm tables",
            );
        } else {
            // N s/m, written as N s/mm.
            let own_damping = 2.0 * SLIDE_DAMPING * (stiffness * 1e6 * inertia).sqrt() * 1e-3;
            let text = format!(
                "\n# guesses\n[axis.{letter}.load.slide]\nmass_kg = {}\ncoulomb_n = {}\nstiffness_n_per_um = {}\ndamping_n_s_per_mm = {}\ngap_um = {} # {gap_from}",
                float(inertia),
                float(friction),
                float(stiffness),
                float(own_damping),
                float(gap_units * 1e3),
            );
            self.line(&text);
            let by = if load.is_belt {
                "belt or rack"
            } else {
                "screw"
            };
            self.guess(
                "load.slide",
                format!("{inertia:.2} kg, {friction:.1} N of friction, {stiffness:.3} N/um"),
                &format!(
                    "a {by}, by the travel of a turn; weigh it, and pull it by a spring balance"
                ),
            );
        }
    }

    /// Lists the gap where none is told.
    fn gap(&mut self) {
        if self.axis.gap.is_some() {
            return;
        }
        let key = if self.axis.rotary {
            "load.table.gap_mdeg"
        } else {
            "load.slide.gap_um"
        };
        self.guess(key, float(GAP_UNITS * 1e3), "measure it with a dial gauge");
    }

    /// Writes the gains of the rotor on its spring, and the margins that it has by nature.
    fn gains(&mut self, motor: &SetMotor<'_>, spring: &RotorSpring, supply_v: f64) {
        let (letter, turn) = (self.letter, &motor.turn);
        self.line(&format!(
            "\n# a rotor on the field of its phases: {:.3} N m at the most (pull-out), {:.0} Hz\n[axis.{letter}.drive]\ncurrent_gain_v_per_a = {}\ncurrent_time_s = {}\nvelocity_gain_a_s_per_rad = {:?}\nvelocity_time_s = {NO_INTEGRAL_S:?}\nposition_gain_per_s = {}\nvelocity_feedforward = 1.0\nacceleration_feedforward = 0.0\ncurrent_limit_a = {}{}\nbus_voltage_v = {}\nencoder_counts_per_rev = {} # microsteps of a turn",
            motor.pull_out,
            spring.own / TAU,
            float(motor.phase_h * 2.0 / 3.0 * TAU * CURRENT_HZ),
            float(motor.phase_h / motor.phase_ohm),
            spring.damping / motor.constant,
            float(spring.stiffness / spring.damping),
            float(motor.peak_a),
            motor.told_peak.map_or_else(
                || " # guess: rated".to_owned(),
                |peak| format!(" # {}", peak.from)
            ),
            float(supply_v * 2.0 / 3.0_f64.sqrt()),
            (turn.full_steps * turn.microsteps).round().max(16.0),
        ));
        self.line(&format!(
            "\n# a rotor on its field swings by nature\n[axis.{letter}.drive.least_margins]\nphase_deg = {LEAST_PHASE_DEG:?}\ngain_db = {LEAST_GAIN_DB:?}"
        ));
    }

    /// Writes when the machine stops: beyond a full step the rotor falls into the next, which is lost. The
    /// command's way of one cycle of 1 ms is no error of the rotor.
    fn monitoring(&mut self, turn: &Turn, [velocity, _]: [f64; 2]) {
        let step = turn.units / turn.full_steps;
        let text = format!(
            "\n# beyond a full step, {} {}, the motor loses steps\n[axis.{}.monitoring]\nfollowing_error_units = {}\nstandstill_error_units = {}\ncontinuous_current_a = 0.0\nat_limit_s = 0.0",
            float(step),
            if self.axis.rotary { "deg" } else { "mm" },
            self.letter,
            float(step + 1e-3 * velocity),
            float(step),
        );
        self.line(&text);
    }
}
