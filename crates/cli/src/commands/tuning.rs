//! Margins and limit cycles as text.

use lostmotion::analysis::{LimitCycle, LoopAnalysis};
use lostmotion::base::AxisId;
use lostmotion::report::text::{Align, Cell, Table};
use lostmotion::sim::Machine;
use lostmotion::sim::machine::AxisTuning;

/// A row for each loop of each axis, then a line for each axis' delays and limit cycles.
pub(crate) fn table(machine: &Machine, tuning: &[AxisTuning]) -> String {
    let right = Align::Right;
    let mut table = Table::new(&[
        ("axis", Align::Left),
        ("loop", Align::Left),
        ("", Align::Left),
        ("gain margin dB", right),
        ("phase margin deg", right),
        ("crossover Hz", right),
        ("bandwidth Hz", right),
    ]);
    for axis in tuning {
        for at in &axis.loops.loops {
            table.row(row(axis.axis, at));
        }
    }
    let lines: String = tuning
        .iter()
        .map(|axis| format!("axis {}: {}\n", axis.axis, delays_and_cycles(machine, axis)))
        .collect();
    format!("{}{lines}", table.render())
}

fn row(axis: AxisId, at: &LoopAnalysis) -> [Cell; 7] {
    let number = |value: Option<f64>| {
        value
            .map_or("-".to_owned(), |value| format!("{value:.1}"))
            .into()
    };
    let margins = &at.margins;
    [
        axis.letter().to_string().into(),
        at.kind.to_string().into(),
        at.regime.to_string().into(),
        number(margins.gain_margin_db),
        number(margins.phase_margin_deg),
        number(margins.crossover_hz),
        number(margins.bandwidth_hz),
    ]
}

fn delays_and_cycles(machine: &Machine, tuning: &AxisTuning) -> String {
    let delays = &tuning.loops.delays;
    let mut line = format!(
        "dead times {} us (current), {} us (velocity), {} us (position)",
        delays.current_us, delays.velocity_us, delays.position_us
    );
    let Some(axis) = machine.axis(tuning.axis) else {
        return line;
    };
    if axis.config.gap_in_unit() <= 0.0 {
        return line;
    }
    let unit = axis.config.unit().symbol();
    let swing = |frequency_hz: f64, amplitude: f64| {
        format!("{frequency_hz:.1} Hz, load +-{amplitude:.3e} {unit}")
    };
    let predicted = match &tuning.predicted {
        LimitCycle::None => "none predicted".to_owned(),
        LimitCycle::Swing {
            frequency_hz,
            load_rad,
            ..
        } => {
            format!(
                "{} predicted",
                swing(
                    *frequency_hz,
                    load_rad / axis.config.transmission.motor_rad_per_unit()
                )
            )
        }
        LimitCycle::Unstable => "the loop itself is unstable".to_owned(),
    };
    let simulated = tuning
        .simulated
        .map_or("none simulated".to_owned(), |cycle| {
            format!("{} simulated", swing(cycle.frequency_hz, cycle.amplitude))
        });
    line.push_str(&format!("; limit cycle: {predicted}, {simulated}"));
    line
}
