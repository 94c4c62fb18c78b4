//! The practical limit of a drawn cell, as the matrix has it ([`crate::matrix`]): what the best of
//! drives leaves that knows the gap to a hundredth and sees its encoder's counts.

use super::cell::DrawnCell;
use crate::error::StudyError;
use crate::matrix::{Physics, Watch, practical_um};
use lostmotion_base::units::UM_PER_MM;
use lostmotion_base::{AxisId, Clock};
use lostmotion_sim::{Program, Simulation};
use std::f64::consts::TAU;

/// The axes that drawn programs cut with.
const AXES: [AxisId; 2] = [AxisId::X, AxisId::Y];

/// Least errors of a cell over its whole motion, um: RMS and largest.
fn least_um(cell: &DrawnCell) -> Result<[f64; 2], StudyError> {
    let axes: Vec<(AxisId, Physics, f64)> = AXES
        .iter()
        .filter_map(|id| {
            let config = &cell.machine.axis(*id)?.config;
            let factor = config.transmission.motor_rad_per_unit();
            Some((*id, Physics::of(config), factor))
        })
        .collect();
    let mut watches = [Watch::default(); 2];
    let (mut squares, mut most) = (0.0, 0.0_f64);
    let program = Program::from_str(cell.name.clone(), cell.program.clone());
    let plan = Simulation::new(&program, &cell.machine).plan(&mut |samples, _| {
        for sample in samples {
            for ((id, physics, factor), watch) in axes.iter().zip(&mut watches) {
                let (velocity, acceleration) = (sample.velocity[*id], sample.acceleration[*id]);
                let event = watch.step(physics, velocity * factor, acceleration * factor);
                // Every unavoidable error at its largest for a whole traverse.
                if let Some(least) = event.flank_rad {
                    let um = UM_PER_MM * least / factor;
                    most = most.max(um);
                    squares += um * um * physics.traverse_s;
                }
            }
        }
        Ok(())
    })?;
    let time_s = plan.duration_s.max(Clock::CNC.period_s());
    Ok([(squares / time_s).sqrt(), most])
}

/// The practical limit of what backlash leaves in a cell in which `none` leaves these, um: RMS and
/// largest.
pub(super) fn practical_um_of(cell: &DrawnCell, none_um: [f64; 2]) -> Result<[f64; 2], StudyError> {
    let counts = (1_u64 << cell.traits.encoder_bits) as f64;
    let lead_mm = cell.machine.axis(AxisId::X).map_or(0.0, |axis| {
        TAU / axis.config.transmission.motor_rad_per_unit()
    });
    Ok(practical_um(
        least_um(cell)?,
        none_um,
        UM_PER_MM * lead_mm / counts,
    ))
}
