//! Lanes: the drives of every variant at the start, and which of them are stepped together.

use super::outputs::{AxisInfo, Beam, LaneLayout};
use super::variant::Variant;
use crate::error::SimError;
use crate::machine::{Machine, Memory};
use lostmotion_base::Coords;
use lostmotion_drive::{AxisBatch, AxisError, AxisOutput, AxisRunner, Setpoint, Tie, TiedAxes};
use lostmotion_methods::{AxisConfig, MethodId, build_runner};

/// How long the machine stands still before the program, s: gravity pulls loads to their flank,
/// drives settle. A choice: many times the slowest loop's time constant of the embedded machines.
pub const SETTLE_S: f64 = 0.5;

/// Lanes that are stepped as one crew. A choice: those of a rehearsal on most machines, whose vectors are
/// as long as that.
const ONE_CREW: usize = AxisBatch::GROUP / 2;

/// An axis of a variant that is being set up.
pub(super) struct Lane {
    pub(super) runner: Box<dyn AxisRunner>,
    config: AxisConfig,
    pub(super) drive: usize,
    datum: f64,
}

/// One lane for each drive of each variant, at rest at `start` (joint positions) and settled under
/// gravity: the drives of the axes, then the second motor of a gantry, which has the same axis and its
/// own description.
pub(super) fn lanes(
    machine: &Machine,
    variants: &[Variant<'_>],
    start: &Coords,
    memory: Option<&Memory>,
    gantry: Option<&Beam>,
) -> Result<Vec<Lane>, SimError> {
    let (drives, axes) = (machine.drives(), machine.axes());
    let mut lanes = Vec::with_capacity(variants.len() * drives.len());
    for variant in variants {
        let firsts = axes
            .iter()
            .enumerate()
            .map(|(drive, axis)| (drive, axis, &axis.config));
        let second =
            gantry.and_then(|beam| Some((axes.len(), axes.get(beam.axis)?, &beam.gantry.second)));
        for (drive, axis, config) in firsts.chain(second) {
            let error = |source| SimError::Axis {
                axis: axis.id,
                source,
            };
            let remembered = memory.zip(drives.get(drive));
            let remembered = remembered.and_then(|(memory, name)| memory.axis.get(name).copied());
            let config = variant.config(config, remembered);
            // Joints count in mm and rad, axes in the unit of their file (mm, deg, rad).
            let at = start[axis.id] * axis.axis_units_per_joint_unit();
            let mut runner = variant.runner(&config, at).map_err(error)?;
            // A program starts from rest: gravity has chosen the flank, integrators hold the
            // load.
            settle(runner.as_mut(), &config, at).map_err(error)?;
            let datum = datum(&config, at).map_err(error)?;
            lanes.push(Lane {
                runner,
                config,
                drive,
                datum,
            });
        }
    }
    Ok(lanes)
}

/// Lets an axis stand still at a place until it has come to rest; gives where its load then is.
fn settle(runner: &mut dyn AxisRunner, config: &AxisConfig, at: f64) -> Result<f64, AxisError> {
    let rest = Setpoint::moving(at, 0.0, 0.0);
    let mut output = AxisOutput::new(false);
    // Command cycles in the time for settling.
    let ticks = (SETTLE_S / config.cycles.command().period_s()).round() as usize;
    runner.push(&vec![rest; ticks], &mut output)?;
    Ok(output.load.last().copied().unwrap_or(at))
}

/// The machine's zero of an axis: where people set it. A load that gravity holds on one flank is
/// set up there, gap and wind-up included; one that may lie on either flank is set up in the middle
/// of its gap.
fn datum(config: &AxisConfig, at: f64) -> Result<f64, AxisError> {
    if config.reflected_load().constant_nm == 0.0 {
        return Ok(0.0);
    }
    // The zero is set with the bare drive: a compensator would already shift the load.
    let mut runner = build_runner(config, MethodId::NONE, at)?;
    Ok(settle(runner.as_mut(), config, at)? - at)
}

/// A beam whose ends push on each other each current period: they are stepped in pairs, behind the
/// lanes that are free of each other.
pub(super) struct StiffBeam {
    /// The axis of both ends.
    axis: usize,
    /// Lane of the second end within a variant: behind those of the axes.
    second: usize,
    tie: Tie,
}

impl StiffBeam {
    /// The beam of a gantry, if it does not yield.
    pub(super) fn of(gantry: Option<&Beam>, axes: &[AxisInfo]) -> Option<StiffBeam> {
        let beam = gantry?;
        Some(StiffBeam {
            axis: beam.axis,
            second: axes.len(),
            tie: beam.gantry.beam?,
        })
    }

    fn carries(&self, lane: &Lane) -> bool {
        lane.drive == self.axis || lane.drive == self.second
    }

    /// Ties the ends, two and two, as they stand.
    fn tie(&self, ends: Vec<Lane>, machine: &Machine) -> Result<Vec<TiedAxes>, SimError> {
        let axis = machine.axes()[self.axis].id;
        let (mut beams, mut ends) = (Vec::new(), ends.into_iter());
        // The two ends of a variant come one behind the other.
        while let (Some(first), Some(second)) = (ends.next(), ends.next()) {
            let beam = TiedAxes::new(
                [first.runner, second.runner],
                [&first.config, &second.config],
                self.tie,
            );
            beams.push(beam.map_err(|source| SimError::Axis {
                axis,
                source: source.into(),
            })?);
        }
        Ok(beams)
    }
}

/// Which lanes are stepped together, and in which order. Variants whose compensators heed each other
/// are a crew each, the others one together; lanes so few that one vector holds them stay together, too.
pub(super) struct Grouping {
    /// By variant, whether its compensators heed each other.
    pub(super) heeds: Vec<bool>,
    /// The crew of each variant.
    pub(super) crew_of: Vec<usize>,
    /// Number of crews.
    pub(super) crews: usize,
    /// The lanes crew by crew, those of a beam behind the free ones.
    order: Vec<usize>,
    drives: usize,
    stiff: Option<StiffBeam>,
}

impl Grouping {
    /// Groups the lanes of machines with so many drives.
    pub(super) fn of(lanes: &[Lane], drives: usize, stiff: Option<StiffBeam>) -> Grouping {
        let drives = drives.max(1);
        let in_beam = |lane: &Lane| stiff.as_ref().is_some_and(|beam| beam.carries(lane));
        let heeds: Vec<bool> = lanes
            .chunks(drives)
            .map(|lanes| {
                let mut free = lanes.iter().filter(|lane| !in_beam(lane));
                free.any(|lane| lane.runner.heeds_others())
            })
            .collect();
        let mut crews = 1;
        let crew_of: Vec<usize> = heeds
            .iter()
            .map(|heeds| {
                if lanes.len() <= ONE_CREW || !heeds {
                    return 0;
                }
                crews += 1;
                crews - 1
            })
            .collect();
        let mut order: Vec<usize> = (0..lanes.len()).collect();
        // A stable sort: free lanes of a crew keep their order and come first, so that one split
        // separates batch and beams. Every variant has as many lanes, one behind the other.
        order.sort_by_key(|lane| (crew_of[lane / drives], in_beam(&lanes[*lane])));
        Grouping {
            heeds,
            crew_of,
            crews,
            order,
            drives,
            stiff,
        }
    }

    /// Which lane is which.
    pub(super) fn layout(
        &self,
        lanes: &[Lane],
        axes: Vec<AxisInfo>,
        gantry: Option<Beam>,
    ) -> LaneLayout {
        // The inverse permutation, for readers who ask by variant and axis.
        let mut lane_of = vec![0; lanes.len()];
        self.order
            .iter()
            .enumerate()
            .for_each(|(place, lane)| lane_of[*lane] = place);
        let order = self.order.iter();
        LaneLayout {
            lane_of,
            variant_of: order.clone().map(|lane| lane / self.drives).collect(),
            datums: order.map(|lane| lanes[*lane].datum).collect(),
            axes,
            gantry,
        }
    }

    /// The lanes of each crew: the free ones, and the beams.
    pub(super) fn divide(
        &self,
        lanes: Vec<Lane>,
        machine: &Machine,
    ) -> Result<Vec<Members>, SimError> {
        let mut lanes: Vec<Option<Lane>> = lanes.into_iter().map(Some).collect();
        let members = |crew: usize| {
            let mine = self
                .order
                .iter()
                .filter(|lane| self.crew_of[**lane / self.drives] == crew);
            let variant_of: Vec<usize> = mine.clone().map(|lane| lane / self.drives).collect();
            let mine: Vec<Lane> = mine.filter_map(|lane| lanes[*lane].take()).collect();
            let drive_of = mine.iter().map(|lane| lane.drive).collect();
            let mut free = mine;
            let mut beams = Vec::new();
            if let Some(beam) = &self.stiff {
                let tied;
                (tied, free) = free.into_iter().partition(|lane| beam.carries(lane));
                beams = beam.tie(tied, machine)?;
            }
            Ok::<_, SimError>(Members {
                free: free.into_iter().map(|lane| lane.runner).collect(),
                beams,
                drive_of,
                variant_of,
            })
        };
        (0..self.crews).map(members).collect()
    }
}

/// The lanes of a crew.
pub(super) struct Members {
    /// Axes that are free of each other.
    pub(super) free: Vec<Box<dyn AxisRunner>>,
    /// Behind them pairs that a beam ties.
    pub(super) beams: Vec<TiedAxes>,
    /// The drive of each lane.
    pub(super) drive_of: Vec<usize>,
    /// The variant of each lane.
    pub(super) variant_of: Vec<usize>,
}
