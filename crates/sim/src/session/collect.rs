//! From a run's tally to its results.

use super::check::Checked;
use super::recorder::Recorder;
use super::rows;
use super::run::{Tally, WITHOUT_GAP};
use crate::machine::{Machine, MachineAxis};
use crate::options::SimulateOptions;
use crate::results::{AxisResult, BlockResult, Comparison, MethodResult, PlanInfo, SCHEMA_VERSION, Simulation};
use crate::source::ProgramSource;
use lostmotion_axis::find_method;
use lostmotion_base::Clock;
use lostmotion_base::units::UM_PER_MM;

/// Backlash RMS by which a method has to be worse than `none` to be called harmful, um.
const HARM_UM: f64 = 0.1;

/// Everything there is to tell.
pub(crate) fn comparison(
    source: &ProgramSource,
    machine: &Machine,
    methods: &[String],
    options: &SimulateOptions,
    checked: Checked,
    tally: &Tally,
) -> Comparison {
    let tolerance_um = options.tolerance_um.unwrap_or(machine.simulate().tolerance_um);
    let mut results: Vec<MethodResult> =
        methods.iter().enumerate().map(|(index, method)| method_result(machine, method, index + 1, tolerance_um, tally)).collect();
    super::text::fill(source, &checked.files, results.iter_mut().flat_map(|result| &mut result.worst_blocks).collect());
    note_harm(&mut results);
    Comparison {
        schema: SCHEMA_VERSION,
        program: checked.program,
        machine: machine.name().to_owned(),
        tolerance_um,
        plan: PlanInfo { duration_s: Clock::CNC.seconds(tally.samples), command: rows::stats(&tally.command, UM_PER_MM), ..checked.plan },
        without_gap: rows::stats(&tally.recorders[WITHOUT_GAP].cutting, UM_PER_MM),
        recommended: recommended(&results),
        results,
    }
}

/// The answer for one method.
pub(crate) fn simulation(comparison: Comparison) -> Option<Simulation> {
    let result = comparison.results.into_iter().next()?;
    Some(Simulation {
        schema: comparison.schema,
        program: comparison.program,
        machine: comparison.machine,
        tolerance_um: comparison.tolerance_um,
        plan: comparison.plan,
        without_gap: comparison.without_gap,
        result,
    })
}

fn method_result(machine: &Machine, method: &str, variant: usize, tolerance_um: f64, tally: &Tally) -> MethodResult {
    let recorder = &tally.recorders[variant];
    let cutting = rows::stats(&recorder.cutting, UM_PER_MM);
    let rotary = machine.axes().iter().any(MachineAxis::is_rotary);
    let mdeg = lostmotion_base::units::deg(1e3);
    let axes: Vec<AxisResult> = (0..machine.axes().len()).map(|axis| axis_result(variant, axis, tally)).collect();
    let mut result = MethodResult {
        method: method.to_owned(),
        cutting,
        rapid: rows::stats(&recorder.rapid, UM_PER_MM),
        backlash: rows::stats(&recorder.backlash, UM_PER_MM),
        orientation_mdeg: rotary.then(|| rows::stats(&recorder.orientation, mdeg)),
        worst_blocks: worst_blocks(recorder),
        reversals: recorder.turns.worst().map(rows::reversal).collect(),
        reversal_count: recorder.turns.counts().iter().sum(),
        axes,
        within_tolerance: cutting.max <= tolerance_um,
        notes: Vec::new(),
    };
    result.notes = notes(&result, recorder.cutting.not_finite());
    result
}

/// Cutting moves; G0 moves only where nothing is cut.
fn worst_blocks(recorder: &Recorder) -> Vec<BlockResult> {
    let cutting: Vec<BlockResult> = recorder.blocks.worst().map(rows::block).collect();
    if cutting.is_empty() { recorder.blocks.worst_rapids().map(rows::block).collect() } else { cutting }
}

fn notes(result: &MethodResult, not_finite: u64) -> Vec<String> {
    let mut notes = Vec::new();
    if result.cutting.samples == 0 {
        notes.push("the program has no cutting moves (G1, G2, G3); the verdict says nothing".to_owned());
    }
    for axis in result.axes.iter().filter(|axis| axis.saturated_samples > 0) {
        let seconds = Clock::SERVO.seconds(axis.saturated_samples);
        notes.push(format!("axis {}: the drive was at its current or voltage limit for {seconds:.3} s", axis.axis));
    }
    if not_finite > 0 {
        notes.push(format!("{not_finite} samples are not numbers: the simulation diverged"));
    }
    notes
}

fn axis_result(variant: usize, axis: usize, tally: &Tally) -> AxisResult {
    let info = &tally.bank.outputs.axes()[axis];
    let output = tally.bank.outputs.of(variant, axis);
    let id = info.id;
    let unit = if info.rotary { "mdeg" } else { "um" };
    // Following errors are in the axis' own unit (mm or deg, or rad on axes described in rad): a joint unit is mm or rad.
    let per_joint_unit = if info.rotary { lostmotion_base::units::deg(1e3) } else { UM_PER_MM };
    let factor = per_joint_unit / info.units;
    let large = per_joint_unit / 1e3;
    AxisResult {
        axis: id,
        unit: unit.to_owned(),
        gap: info.gap * factor,
        following: rows::stats(&tally.recorders[variant].following[axis], factor),
        following_without_gap: rows::stats(&tally.recorders[WITHOUT_GAP].following[axis], factor),
        reversals: tally.recorders[variant].turns.counts()[id.index()],
        peak_current_ratio: output.peak_current_a / info.current_limit_a,
        saturated_samples: output.saturated_samples,
        peak_velocity: tally.peak_velocity[id] * large,
        range: [tally.range[0][id] * large, tally.range[1][id] * large],
    }
}

/// Says of every method that leaves more backlash than no compensation does.
fn note_harm(results: &mut [MethodResult]) {
    let Some(none) = results.iter().find(|result| result.method == "none").map(|result| result.backlash) else { return };
    for result in results.iter_mut().filter(|result| result.backlash.rms > none.rms + HARM_UM) {
        let (with, without) = (result.backlash.rms, none.rms);
        let digits = if with < 100.0 { 2 } else { 0 };
        result.notes.push(format!("does harm here: backlash RMS {with:.digits$} um against {without:.2} um without compensation"));
    }
}

/// The method with the least backlash RMS among those that need no scale on the load; ties go to the one named first.
fn recommended(results: &[MethodResult]) -> Option<String> {
    let usable = results.iter().filter(|result| find_method(&result.method).is_ok_and(|method| !method.info.knows.load_scale));
    let mut best: Option<&MethodResult> = None;
    for result in usable {
        if best.is_none_or(|best| result.backlash.rms < best.backlash.rms) {
            best = Some(result);
        }
    }
    best.filter(|_| results.len() > 1).map(|result| result.method.clone())
}
