//! Commissioning: a minute of motion that teaches an axis its load and its gap before the part.
//!
//! Each drive is moved alone, within its travel and limits, with the method that learns; what it has
//! learned by the end is its memory. The machine's description is what it is held against.

mod gcode;
mod motion;

pub use gcode::program;
pub use motion::Bounds;

use crate::error::SimError;
use crate::machine::{Machine, Memory};
use lostmotion_base::AxisId;
use lostmotion_drive::{AxisError, AxisOutput, Learned, Setpoint};
use lostmotion_methods::{AxisConfig, AxisMemory, MethodId, build_runner};

/// Setpoints that go to a drive at once.
const SETPOINTS_PER_CHUNK: usize = 1000;

/// What commissioning a drive has shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Commissioned {
    /// Name of the drive: `x`, `y2`.
    pub drive: String,
    /// The axis.
    pub config: AxisConfig,
    /// What was learned; `None` if not even the load was.
    pub learned: Option<Learned>,
    /// Length of the motion, s.
    pub duration_s: f64,
}

impl Commissioned {
    /// What the description says, in the form of what is learned.
    pub fn truth(&self) -> Learned {
        let load = self.config.reflected_load();
        Learned {
            half_gap_rad: 0.5 * load.gap_rad,
            load_inertia_kgm2: load.inertia_kgm2,
            viscous_nm_s_per_rad: load.viscous_nm_s_per_rad,
            coulomb_nm: load.coulomb_nm,
            constant_nm: load.constant_nm,
            ..Learned::default()
        }
    }
}

/// The bounds of the motion of a drive of a machine; `None` for a name that is none of its drives.
pub fn bounds(machine: &Machine, drive: &str) -> Option<Bounds> {
    let config = machine.drive(drive)?;
    let letter = drive.chars().next().and_then(AxisId::from_letter)?;
    let axis = machine.axis(letter)?;
    let unit = axis.axis_units_per_joint_unit();
    let mut limits = axis.limits;
    for value in [
        &mut limits.min,
        &mut limits.max,
        &mut limits.velocity,
        &mut limits.acceleration,
        &mut limits.jerk,
    ] {
        *value *= unit;
    }
    Some(Bounds {
        limits,
        unit: config.unit(),
        motor_rad_per_unit: config.transmission.motor_rad_per_unit(),
        cycle_s: config.cycles.command().period_s(),
    })
}

/// Moves a drive alone and lets it learn.
///
/// # Errors
/// An axis that the method does not suit.
pub fn run(config: &AxisConfig, setpoints: &[Setpoint]) -> Result<Option<Learned>, AxisError> {
    let start = setpoints.first().map_or(0.0, |first| first.position);
    let mut runner = build_runner(config, MethodId::ADAPTIVE, start)?;
    let mut out = AxisOutput::new(false);
    for chunk in setpoints.chunks(SETPOINTS_PER_CHUNK) {
        out.clear();
        runner.push(chunk, &mut out)?;
    }
    Ok(runner.learned())
}

/// Commissions every drive of a machine, one after the other.
///
/// ```
/// use lostmotion_sim::{Machine, commission};
///
/// let machine = Machine::preset("vmc3-worn")?;
/// let found = commission::all(&machine)?;
/// let x = &found[0];
/// let gap_rad = x.learned.ok_or("nothing learned")?.half_gap_rad;
/// assert!((gap_rad / x.truth().half_gap_rad - 1.0).abs() < 0.03);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
/// An axis that the method does not suit.
pub fn all(machine: &Machine) -> Result<Vec<Commissioned>, SimError> {
    machine
        .drives()
        .iter()
        .filter_map(|drive| one(machine, drive))
        .collect()
}

/// Commissions a drive of a machine; `None` for a name that is none of its drives.
pub fn one(machine: &Machine, drive: &str) -> Option<Result<Commissioned, SimError>> {
    let mut config = machine.drive(drive)?.clone();
    let axis = drive.chars().next().and_then(AxisId::from_letter)?;
    // it starts from nothing
    config.compensation.learned = None;
    let bounds = bounds(machine, drive)?;
    let (setpoints, duration_s) = (bounds.setpoints(), bounds.duration_s());
    let learned = run(&config, &setpoints).map_err(|source| SimError::Axis { axis, source });
    Some(learned.map(|learned| Commissioned {
        drive: drive.to_owned(),
        config,
        learned,
        duration_s,
    }))
}

/// The memory of what was learned.
pub fn memory(found: &[Commissioned]) -> Memory {
    let mut memory = Memory::default();
    for drive in found {
        if let Some(learned) = drive.learned {
            let axis = AxisMemory::new(learned, &drive.config);
            memory.axis.insert(drive.drive.clone(), axis);
        }
    }
    memory
}
