//! From a run's tally to its results.

use super::advice::{note_side, recommend, refusal};
use super::monitor::Stop;
use super::recorder::Recorder;
use super::rows;
use super::run::{Tally, WITHOUT_GAP};
use super::stepper::Stepper;
use crate::machine::{Machine, MachineAxis};
use crate::method::Choice;
use crate::motion::Checked;
use crate::options::BowLimit;
use crate::program::BlockTexts;
use crate::results::{
    AxisResult, BlockResult, GantryResult, Harm, LimitsUsed, MethodResult, MisledResult, PlanInfo,
    Run, SCHEMA_VERSION, StopLimit, StopResult,
};
use crate::setup::Setup;
use lostmotion_analysis::{Fault, analyse};
use lostmotion_base::units::{UM_PER_MM, rad};
use lostmotion_base::{AxisId, Clock};
use lostmotion_drive::AxisOutput;
use lostmotion_methods::{AxisConfig, Misled};

/// The answer of a run.
pub(crate) fn answer(
    setup: &Setup<'_>,
    choices: &[Choice],
    checked: Checked,
    tally: &Tally,
) -> Run {
    let (machine, options) = (setup.machine, setup.options);
    let tolerance_um = options
        .tolerance_um
        .unwrap_or(machine.simulate().tolerance_um);
    let mut results: Vec<MethodResult> = choices
        .iter()
        .enumerate()
        .map(|(index, choice)| method_result(setup, choice, index + 1, tolerance_um, tally))
        .collect();
    // Texts of the few worst blocks are read again from the program: the tally holds places alone.
    let mut texts = BlockTexts::new(setup.program, checked.files);
    for row in results
        .iter_mut()
        .flat_map(|result| &mut result.worst_blocks)
    {
        row.text = texts.at(row.block.span);
    }
    // Needs all methods at once: harm is measured against `none` of the same run.
    add_misled(&mut results, tally);
    let refused = |choice: &Choice| refusal(setup, choice);
    let recommended = recommend(&mut results, choices, refused, tolerance_um);
    note_side(&mut results, recommended.as_deref());
    note_harm(&mut results);
    // Once: it holds for every method.
    if let Some(first) = results.first_mut() {
        let unseen = unseen_gaps(setup.machine, first);
        first.notes.extend(unseen);
    }
    let mut program = checked.program;
    let PlanInfo {
        bow,
        bow_limit_um,
        unstraight,
        late,
        shortfalls,
        ..
    } = tally.straightness;
    // Bow and end of the motion are known only after planning: these warnings follow those of the
    // reading pass.
    program.warnings.extend(
        tally
            .straightness
            .bow_warning(BowLimit::new(machine, options).um),
    );
    program.warnings.extend(tally.straightness.late_warning());
    program
        .warnings
        .extend(tally.straightness.shortfall_warning());
    Run {
        schema: SCHEMA_VERSION,
        program,
        machine: machine.name().to_owned(),
        tolerance_um,
        plan: PlanInfo {
            duration_s: tally.cycles.command().seconds(tally.stepper.count),
            command: rows::stats(&tally.command, UM_PER_MM),
            cutting_force_n: options
                .cutting_force_n
                .unwrap_or(machine.simulate().cutting_force_n),
            bow,
            bow_limit_um,
            unstraight,
            late,
            shortfalls,
            ..checked.plan
        },
        without_gap: rows::stats(&tally.recorders[WITHOUT_GAP].cutting, UM_PER_MM),
        recommended,
        trust: None,
        results,
    }
}

/// The results of one method, which is a variant of the tally.
fn method_result(
    setup: &Setup<'_>,
    choice: &Choice,
    variant: usize,
    tolerance_um: f64,
    tally: &Tally,
) -> MethodResult {
    let (recorder, servo) = (&tally.recorders[variant], tally.cycles.servo());
    let cutting = rows::stats(&recorder.cutting, UM_PER_MM);
    let machine = setup.machine;
    let rotary = machine.axes().iter().any(MachineAxis::is_rotary);
    let mdeg = lostmotion_base::units::deg(1e3);
    let axes: Vec<AxisResult> = (0..machine.axes().len())
        .map(|axis| axis_result(variant, axis, tally))
        .collect();
    let mut result = MethodResult {
        method: choice.name(machine.configs()),
        cutting,
        rapid: rows::stats(&recorder.rapid, UM_PER_MM),
        backlash: rows::stats(&recorder.backlash, UM_PER_MM),
        orientation_mdeg: rotary.then(|| rows::stats(&recorder.orientation, mdeg)),
        worst_blocks: worst_blocks(recorder, servo),
        reversals: recorder
            .turns
            .worst()
            .map(|row| rows::reversal(row, servo))
            .collect(),
        reversal_count: recorder.turns.counts().iter().sum(),
        axes,
        gantry: gantry(variant, tally),
        stop: recorder
            .stop
            .as_ref()
            .map(|stop| stop_result(stop, choice, machine, tally)),
        limits_used: limits_used(&tally.stepper, variant, machine),
        within_tolerance: recorder.stop.is_none() && cutting.max <= tolerance_um,
        misled: Vec::new(),
        learned: tally.stepper.bank.learned(variant, machine),
        not_recommended: None,
        notes: Vec::new(),
    };
    // Last: the notes quote figures of the result itself.
    result.notes = notes(&result, servo, recorder.cutting.not_finite());
    result
}

/// Radius at which the gap of a rotary axis is told as a length, mm. A choice: of parts on a table.
const RADIUS_MM: f64 = 50.0;

/// Gaps of rotary axes that a program turns and whose kinematics do not say what they turn: none of
/// the errors has them.
pub(crate) fn unseen_gaps(machine: &Machine, result: &MethodResult) -> Vec<String> {
    let kind = machine.kinematics().kind();
    let turned = result.axes.iter().filter(|axis| {
        kind == "cartesian"
            && axis.axis.is_rotary()
            && axis.gap > 0.0
            && axis.range[1] > axis.range[0]
    });
    turned
        .map(|axis| {
            let um = rad(0.5e-3 * axis.gap) * RADIUS_MM * UM_PER_MM;
            format!(
                "{}: no contour error has its gap, since the kinematics ({kind}) do not say what it turns; half its {:.1} mdeg are {um:.1} um at {RADIUS_MM} mm from its centre",
                axis.axis, axis.gap
            )
        })
        .collect()
}

/// The worst blocks: of cutting moves; of rapids only where nothing is cut.
fn worst_blocks(recorder: &Recorder, servo: Clock) -> Vec<BlockResult> {
    let block = |row| rows::block(row, servo);
    // A program of rapids alone still has worst blocks to show.
    let cutting: Vec<BlockResult> = recorder.blocks.worst().map(block).collect();
    if cutting.is_empty() {
        recorder.blocks.worst_rapids().map(block).collect()
    } else {
        cutting
    }
}

fn notes(result: &MethodResult, servo: Clock, not_finite: u64) -> Vec<String> {
    let mut notes = Vec::new();
    if result.cutting.samples == 0 && result.stop.is_none() {
        notes.push(
            "the program has no cutting moves (G1, G2, G3); the verdict says nothing".to_owned(),
        );
    }
    // Of the axis that stops the machine the reason of the stop says it.
    let stops = |axis: &AxisResult| {
        let stop = result.stop.as_ref();
        stop.is_some_and(|stop| stop.axis == axis.axis)
    };
    for axis in result
        .axes
        .iter()
        .filter(|axis| axis.saturated_samples > 0 && !stops(axis))
    {
        let seconds = servo.seconds(axis.saturated_samples);
        // A period of the servo is less than a millisecond.
        let time = if seconds < 0.01 {
            format!("{:.3} ms", 1e3 * seconds)
        } else {
            format!("{seconds:.3} s")
        };
        notes.push(format!(
            "axis {}: the drive was at its current or voltage limit for {time}",
            axis.axis
        ));
    }
    if not_finite > 0 {
        notes.push(format!(
            "{not_finite} samples are not numbers: the simulation diverged"
        ));
    }
    notes
}

fn gantry(variant: usize, tally: &Tally) -> Option<GantryResult> {
    let (recorder, outputs) = (&tally.recorders[variant], &tally.stepper.chunk.outputs);
    let axis = outputs.axes().get(outputs.gantry_axis()?)?.id;
    let summary = recorder.skew.summary();
    Some(GantryResult {
        axis,
        skew_um: rows::stats(&recorder.skew, UM_PER_MM),
        peak_um: summary.max * UM_PER_MM,
        time_s: tally.cycles.servo().seconds(summary.max_at.tick),
        block: recorder.skew_peak.1,
    })
}

/// A stop with its reason.
fn stop_result(stop: &Stop, choice: &Choice, machine: &Machine, tally: &Tally) -> StopResult {
    // Behind the axes comes the second motor of a gantry.
    let (axis, second) = match (machine.axes().get(stop.drive), machine.gantry()) {
        (None, Some(gantry)) => (machine.axis(gantry.axis), Some(&gantry.second)),
        (axis, _) => (axis, None),
    };
    let Some(axis) = axis else {
        return StopResult::default();
    };
    // Axis units to mm or deg, through the joint unit that both are defined by.
    let (large, small, per_joint_unit) = if axis.is_rotary() {
        ("deg", "mdeg", lostmotion_base::units::deg(1.0))
    } else {
        ("mm", "um", 1.0)
    };
    let per_unit = per_joint_unit / axis.axis_units_per_joint_unit();
    let (unit, factor) = match stop.limit {
        StopLimit::FollowingError => (small, per_unit * 1e3),
        StopLimit::Travel => (large, per_unit),
        StopLimit::Overload => ("%", 100.0),
        StopLimit::AtLimit => ("s", 1.0),
    };
    let servo = tally.cycles.servo();
    let seen = stop.drives.get(stop.drive).copied().unwrap_or_default();
    let at_limit_s = servo.seconds(seen.saturated_samples);
    // A loop that is unstable by itself comes first: everything else may follow from it.
    let mut reasons = Vec::new();
    reasons.extend(instability(choice, second.unwrap_or(&axis.config)));
    if seen.correction.abs() > 0.5 * excess(stop) {
        let correction = seen.correction * per_unit * 1e3;
        reasons.push(format!("the compensator asks for {correction:.0} {small}"));
    }
    // Of a stop by that time the limit itself says it.
    if at_limit_s > 0.0 && stop.limit != StopLimit::AtLimit {
        let text = "the drive was at its current or voltage limit for";
        reasons.push(format!("{text} {at_limit_s:.3} s"));
    }
    StopResult {
        axis: axis.id,
        second: second.is_some(),
        limit: stop.limit,
        time_s: servo.seconds(stop.tick),
        block: stop.block,
        at_mm: stop.at_mm,
        unit: unit.to_owned(),
        value: stop.value * factor,
        allowed: stop.allowed * factor,
        at_limit_s,
        reason: reasons.join("; "),
    }
}

/// How near each axis came to being stopped.
fn limits_used(stepper: &Stepper, variant: usize, machine: &Machine) -> Vec<LimitsUsed> {
    let axes = machine.axes().iter().enumerate();
    // The second motor of a gantry comes behind the axes.
    let second = |axis: AxisId| {
        machine.gantry().filter(|gantry| gantry.axis == axis)?;
        stepper.limits_used(variant, machine.axes().len())
    };
    axes.map(|(drive, axis)| {
        let first = stepper.limits_used(variant, drive).unwrap_or_default();
        // Of two motors the one that is nearer to its limits.
        let other = second(axis.id).unwrap_or_default();
        LimitsUsed {
            axis: axis.id,
            following_error: first.following_error.max(other.following_error),
            travel: first.travel.max(other.travel),
            overload: first.overload.max(other.overload),
            at_limit: first.at_limit.max(other.at_limit),
        }
    })
    .collect()
}

/// What is wrong with the loops of an axis with a method, if one of them is unstable.
fn instability(choice: &Choice, config: &AxisConfig) -> Option<String> {
    let mut config = config.clone();
    if let Some(method) = choice.method(&config) {
        // A method may close the position loop on the load.
        config.compensation.method = method;
    }
    match analyse(&config).fault(&config)? {
        fault @ Fault::Unstable(_) => Some(fault.to_string()),
        _ => None,
    }
}

/// How far the motor is off its command or its travel, in the axis' unit: a correction of that size
/// is what took it there. No correction explains a drive at its limits.
fn excess(stop: &Stop) -> f64 {
    match stop.limit {
        StopLimit::FollowingError => stop.value.abs(),
        StopLimit::Travel => (stop.value - stop.allowed).abs(),
        StopLimit::Overload | StopLimit::AtLimit => f64::INFINITY,
    }
}

fn axis_result(variant: usize, axis: usize, tally: &Tally) -> AxisResult {
    let outputs = &tally.stepper.chunk.outputs;
    let info = &outputs.axes()[axis];
    // Where the machine has stopped, what its drives had done by then.
    let stop = tally.recorders[variant].stop.as_ref();
    let drive = |drive: usize, output: &AxisOutput| {
        stop.and_then(|stop| stop.drives.get(drive))
            .map_or((output.peak_current_a, output.saturated_samples), |seen| {
                (seen.peak_current_a, seen.saturated_samples)
            })
    };
    let (peak_current_a, saturated_samples) = drive(axis, outputs.of(variant, axis));
    let second = outputs
        .second_of(variant, axis)
        .map(|(output, limit_a)| (drive(outputs.axes().len(), output), limit_a));
    let id = info.id;
    let unit = if info.rotary { "mdeg" } else { "um" };
    // Following errors are in the axis' own unit (mm or deg, or rad on axes described in rad): a
    // joint unit is mm or rad.
    let per_joint_unit = if info.rotary {
        lostmotion_base::units::deg(1e3)
    } else {
        UM_PER_MM
    };
    // Axis units to um or mdeg, through the joint unit that both are defined by.
    let factor = per_joint_unit / info.units;
    let large = per_joint_unit / 1e3;
    AxisResult {
        axis: id,
        unit: unit.to_owned(),
        gap: info.gap * factor,
        following: rows::stats(&tally.recorders[variant].following[axis], factor),
        following_without_gap: rows::stats(&tally.recorders[WITHOUT_GAP].following[axis], factor),
        reversals: tally.recorders[variant].turns.counts()[id.index()],
        // The harder loaded motor of a gantry decides, each by its own drive's limit.
        peak_current_ratio: second
            .map_or(0.0, |((peak_a, _), limit_a)| peak_a / limit_a)
            .max(peak_current_a / info.current_limit_a),
        saturated_samples: second
            .map_or(0, |((_, samples), _)| samples)
            .max(saturated_samples),
        peak_velocity: tally.stepper.peak_velocity[id] * large,
        range: [
            tally.stepper.range[0][id] * large,
            tally.stepper.range[1][id] * large,
        ],
    }
}

/// Says of every method that leaves more backlash than no compensation does.
fn note_harm(results: &mut [MethodResult]) {
    let Some(baseline) = results.iter().find(|result| result.is_baseline()).cloned() else {
        return;
    };
    let none = baseline.backlash;
    for result in results
        .iter_mut()
        // One message a cause.
        .filter(|result| result.not_recommended.is_none())
        .filter(|result| matches!(result.harm(&baseline), Some(Harm::Rms(_))))
    {
        // Diverged runs leave metres of error: decimals would say nothing.
        let (with, without) = (result.backlash.rms, none.rms);
        let digits = if with < 100.0 { 2 } else { 0 };
        result.notes.push(format!("does harm here: backlash RMS {with:.digits$} um against {without:.2} um without compensation"));
    }
}

/// Adds to each method how it does where its drives are told something wrong.
fn add_misled(results: &mut [MethodResult], tally: &Tally) {
    for ((method, _), misled) in tally.misled.iter().zip(misled(tally, results.len())) {
        if let Some(result) = results.get_mut(*method) {
            result.misled.push(misled);
        }
    }
}

/// How the methods did that were told something wrong, in the order of the tally, behind so many
/// that were told everything right.
pub(super) fn misled(tally: &Tally, methods: usize) -> Vec<MisledResult> {
    let recorders = tally.recorders.iter().skip(WITHOUT_GAP + 1 + methods);
    let row = |(method, recorder): (&(usize, Misled), &Recorder)| MisledResult {
        misled: method.1,
        cutting: rows::stats(&recorder.cutting, UM_PER_MM),
        backlash: rows::stats(&recorder.backlash, UM_PER_MM),
        stops: recorder.stop.is_some(),
    };
    tally.misled.iter().zip(recorders).map(row).collect()
}
