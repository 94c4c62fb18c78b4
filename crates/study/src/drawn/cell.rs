//! A cell: a machine and a part program, drawn.

use super::program;
use crate::error::StudyError;
use lostmotion_base::Random;
use lostmotion_drive::config::{ContactLaw, Linear, Load, Slide, Transmission, Tuning};
use lostmotion_methods::AxisConfig;
use lostmotion_sim::Machine;
use lostmotion_sim::machine::{AxisFile, LimitsTable, LinearLimits};
use std::f64::consts::TAU;

/// Leads of ball screws, mm a turn, as catalogues have them for machine tools.
const LEADS_MM: [f64; 5] = [5.0, 8.0, 10.0, 16.0, 20.0];
/// Total gaps of X, um: from a good screw to a worn one.
const GAPS_UM: (f64, f64) = (5.0, 120.0);
/// Gap of Y over that of X.
const GAP_RATIOS: (f64, f64) = (0.6, 1.5);
/// Gap of Z over that of X: a tool that plunges once and cuts on one flank ever after.
const Z_GAP_RATIOS: (f64, f64) = (0.4, 1.0);
/// Laws of the flanks' contact: with the damper that pulls for a moment, and without.
const CONTACTS: [ContactLaw; 2] = [ContactLaw::Linear, ContactLaw::Bounded];
/// Inertia of the load over that of rotor and screw.
const INERTIA_RATIOS: (f64, f64) = (0.3, 3.0);
/// Inertia of the load of Y over that of X: one axis carries the other.
const LOAD_RATIOS: (f64, f64) = (0.9, 1.6);
/// Part of the machines whose guides have no Coulomb friction (hydrostatic, air).
const FRICTIONLESS: f64 = 0.2;
/// Largest Coulomb friction, part of the rated torque at the motor.
const MOST_FRICTION: f64 = 0.15;
/// Friction of Y over that of X.
const FRICTION_RATIOS: (f64, f64) = (0.6, 1.5);
/// Largest viscous friction at 1 m/s, part of the rated torque.
const MOST_VISCOUS: f64 = 0.3;
/// Axial stiffness of screw, nut and bearings, N/um.
const STIFFNESSES_N_PER_UM: (f64, f64) = (30.0, 300.0);
/// Damping of the shaft in parts of the critical one.
const DAMPINGS: (f64, f64) = (0.02, 0.1);
/// Bits of a turn of the motor's encoder: the least and the most.
const ENCODER_BITS: (u32, u32) = (17, 24);
/// Natural frequency of the velocity loop, Hz, as [`Tuning`] has it.
const VELOCITIES_HZ: (f64, f64) = (15.0, 40.0);
/// Position gain over that frequency.
const POSITION_RATIOS: (f64, f64) = (0.15, 0.25);
/// Highest gain crossover of the velocity loop with the motor alone in the gap, 1/s: 45 degrees for
/// the delays of encoder difference, servo and current loop (0.5 ms in all).
const ALONE_PER_S: f64 = 1600.0;
/// Part of the peak torque that the planner's acceleration takes. A choice: the rest is for
/// friction, and for crossing the gap.
const PLANNED_TORQUE: f64 = 0.4;
/// Bounds of the planner's limits, mm/s and mm/s2, and the jerk by the acceleration, 1/s. A choice:
/// of machining centres.
const MOST_MM_S: f64 = 500.0;
const MOST_MM_S2: f64 = 8000.0;
const JERK_PER_S: f64 = 20.0;

/// A machine and a part program.
#[derive(Clone, Debug)]
pub struct DrawnCell {
    /// `SEED-INDEX`, with what the program is: `7-3-square20`.
    pub name: String,
    /// The machine.
    pub machine: Machine,
    /// The part program.
    pub program: String,
    /// What matters about it, for tables.
    pub traits: Traits,
}

/// What tells one cell from another.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traits {
    /// Total gaps of X and Y, um.
    pub gap_um: [f64; 2],
    /// Coulomb friction of the loads, parts of the rated torque.
    pub friction: [f64; 2],
    /// Inertia of the load over that of the motor.
    pub inertia_ratio: [f64; 2],
    /// Bits of a turn of the encoder.
    pub encoder_bits: u32,
    /// Whether speed and acceleration are fed forward.
    pub feed_forward: bool,
}

/// The cell of a seed and a number.
///
/// Each number has a sequence of its own, so that a cell is the same however many are drawn.
///
/// # Errors
/// A drawn machine that makes no sense: a fault of the ranges here.
pub fn draw(seed: u64, index: u32) -> Result<DrawnCell, StudyError> {
    let mut random = Random::new(seed);
    // The seed's own sequence gives the cell's seed: neighbours have nothing in common.
    let mut own = 0;
    for _ in 0..=index {
        own = random.next_u64();
    }
    let mut random = Random::new(own);
    // What was added later has a sequence of its own, so that the rest of a cell stays what it was.
    let (machine, traits) = machine(&mut random, &mut Random::new(!own), seed, index)?;
    let program = program::draw(&mut random);
    Ok(DrawnCell {
        name: format!("{seed}-{index}-{}", program.name),
        machine,
        program: program.text,
        traits,
    })
}

/// What both axes of a machine have in common.
struct Common {
    base: AxisConfig,
    lead_mm: f64,
    stiffness_n_per_um: f64,
    damping: f64,
    encoder_bits: u32,
    feed_forward: bool,
    velocity_hz: f64,
    position_ratio: f64,
}

/// What is an axis' own.
#[derive(Clone, Copy)]
struct Own {
    inertia_ratio: f64,
    friction: f64,
    viscous: f64,
    gap_um: f64,
}

fn machine(
    random: &mut Random,
    later: &mut Random,
    seed: u64,
    index: u32,
) -> Result<(Machine, Traits), StudyError> {
    // Motors of two sizes, with their drives' limits: those of the presets.
    let preset = ["bench3", "vmc3"][random.below(2)];
    let mut base = Machine::preset(preset)?
        .axes()
        .first()
        .map_or_else(AxisConfig::paper, |axis| axis.config.clone());
    base.contact = CONTACTS[later.below(CONTACTS.len())];
    let bits = ENCODER_BITS.1 - ENCODER_BITS.0 + 1;
    let common = Common {
        base,
        lead_mm: LEADS_MM[random.below(LEADS_MM.len())],
        stiffness_n_per_um: random.log_between(STIFFNESSES_N_PER_UM.0, STIFFNESSES_N_PER_UM.1),
        damping: random.log_between(DAMPINGS.0, DAMPINGS.1),
        encoder_bits: ENCODER_BITS.0 + random.below(bits as usize) as u32,
        feed_forward: random.unit() < 0.7,
        velocity_hz: random.log_between(VELOCITIES_HZ.0, VELOCITIES_HZ.1),
        position_ratio: random.between(POSITION_RATIOS.0, POSITION_RATIOS.1),
    };
    let has_friction = random.unit() >= FRICTIONLESS;
    let x = Own {
        inertia_ratio: random.log_between(INERTIA_RATIOS.0, INERTIA_RATIOS.1),
        friction: if has_friction {
            random.between(0.01, MOST_FRICTION)
        } else {
            0.0
        },
        viscous: random.between(0.0, MOST_VISCOUS),
        gap_um: random.log_between(GAPS_UM.0, GAPS_UM.1),
    };
    let y = Own {
        inertia_ratio: x.inertia_ratio * random.between(LOAD_RATIOS.0, LOAD_RATIOS.1),
        friction: x.friction * random.between(FRICTION_RATIOS.0, FRICTION_RATIOS.1),
        viscous: x.viscous * random.between(FRICTION_RATIOS.0, FRICTION_RATIOS.1),
        gap_um: x.gap_um * random.between(GAP_RATIOS.0, GAP_RATIOS.1),
    };
    let z = Own {
        gap_um: x.gap_um * later.between(Z_GAP_RATIOS.0, Z_GAP_RATIOS.1),
        ..x
    };
    let mut machine = Machine::preset(preset)?.file();
    machine.general.name = format!("drawn-{seed}-{index}");
    machine.general.work_offset = Default::default();
    machine.general.home = Default::default();
    machine.axis.clear();
    for (letter, own) in [("x", x), ("y", y), ("z", z)] {
        machine.axis.insert(letter.to_owned(), axis(&common, own));
    }
    let traits = Traits {
        gap_um: [x.gap_um, y.gap_um],
        friction: [x.friction, y.friction],
        inertia_ratio: [x.inertia_ratio, y.inertia_ratio],
        encoder_bits: common.encoder_bits,
        feed_forward: common.feed_forward,
    };
    Ok((machine.check()?, traits))
}

/// An axis, commissioned by the rule of [`Tuning`] with its true inertia.
fn axis(common: &Common, own: Own) -> AxisFile {
    let base = &common.base;
    let motor = &base.motor;
    let m_per_rad = 1e-3 * common.lead_mm / TAU;
    // A screw turns with the rotor: a third of its inertia is usual.
    let screw = 0.3 * motor.inertia_kgm2;
    let turning = motor.inertia_kgm2 + screw;
    let mass_kg = own.inertia_ratio * turning / (m_per_rad * m_per_rad);
    let turning_kg = turning / (m_per_rad * m_per_rad);
    let reduced_kg = mass_kg * turning_kg / (mass_kg + turning_kg);
    let stiffness = 1e6 * common.stiffness_n_per_um;
    let rated_n = motor.rated_torque_nm / m_per_rad;
    let slide = Slide {
        mass_kg,
        screw_inertia_kgm2: screw,
        viscous_n_s_per_m: own.viscous * rated_n,
        coulomb_n: own.friction * rated_n,
        constant_n: 0.0,
        stiffness_n_per_um: common.stiffness_n_per_um,
        damping_n_s_per_mm: 1e-3 * 2.0 * common.damping * (stiffness * reduced_kg).sqrt(),
        gap_um: own.gap_um,
        scale_um: 0.1,
    };
    let all = turning * (1.0 + own.inertia_ratio);
    // With the motor alone in the gap the crossover is higher by the ratio of the inertias, and
    // has to stay below the limit.
    let alone_hz = ALONE_PER_S * turning / (2.0 * all) / TAU;
    let share = if common.feed_forward { 1.0 } else { 0.0 };
    let tuning = Tuning {
        velocity_frequency_hz: common.velocity_hz.min(alone_hz),
        position_ratio: common.position_ratio,
        velocity_feedforward: share,
        acceleration_feedforward: share,
        ..Tuning::default()
    };
    let mut config = AxisConfig {
        transmission: Transmission::Linear(Linear {
            lead_mm: common.lead_mm,
            gear: 1.0,
        }),
        load: Load::Slide(slide),
        ..base.clone()
    }
    .tuned(&tuning);
    config.drive.told_inertia_kgm2 = Some(all);
    config.drive.encoder_counts_per_rev = Some(1 << common.encoder_bits);
    config.drive.friction_feedforward = None;
    let peak_nm = motor.torque_constant_nm_per_a * config.drive.current_limit_a;
    let acceleration = (1e3 * PLANNED_TORQUE * peak_nm * m_per_rad / all).min(MOST_MM_S2);
    AxisFile {
        limits: LimitsTable::Linear(LinearLimits {
            min_mm: -500.0,
            max_mm: 500.0,
            velocity_mm_s: MOST_MM_S,
            acceleration_mm_s2: acceleration,
            jerk_mm_s3: JERK_PER_S * acceleration,
        }),
        config,
    }
}
