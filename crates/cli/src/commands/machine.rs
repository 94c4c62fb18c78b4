//! `lostmotion machine`.

use super::{DONE, import, tuning};
use crate::args::machine::Machine as Arguments;
use crate::failure::Failure;
use crate::{machines, output};
use lostmotion::report::number::{error, percent, plain};
use lostmotion::report::text::{Align, Table};
use lostmotion::sim::Machine;
use lostmotion::sim::machine::{DEFAULT_MACHINE, axis_preset_toml, axis_presets, presets};

/// Lists, shows or checks machines.
pub(crate) fn run(arguments: &Arguments) -> Result<u8, Failure> {
    let text = match arguments {
        Arguments::List => list(),
        Arguments::Show { name } => show(name)?,
        Arguments::Import {
            file,
            from,
            preset,
            out,
        } => return import::run(file, from.as_deref(), preset, out.as_deref()),
        Arguments::Check { file } => {
            let (machine, tuning) = machines::check(file)?;
            let (figures, loops) = (review(&machine), tuning::table(&machine, &tuning));
            format!(
                "{}: machine \"{}\" is sound\n\n{figures}\n{loops}",
                file.display(),
                machine.name()
            )
        }
    };
    output::print(&text)?;
    Ok(DONE)
}

fn list() -> String {
    let mut table = Table::new(&[("machine", Align::Left), ("", Align::Left)]);
    for preset in presets() {
        let note = if preset.name == DEFAULT_MACHINE {
            " (the one taken if none is named)"
        } else {
            ""
        };
        table.row([
            preset.name.into(),
            format!("{}{note}", preset.summary).into(),
        ]);
    }
    format!(
        "{}\naxes for `axis` and `fit`: {}\n",
        table.render(),
        axis_presets().join(", ")
    )
}

/// The file of a preset as it came, with its comments; then, as comments too, how its loops are
/// tuned. Axes as files for `axis --axis`.
fn show(name: &str) -> Result<String, Failure> {
    match presets().iter().find(|preset| preset.name == name) {
        Some(preset) => Ok(format!("{}{}", preset.toml, tuned(name))),
        None => axis_preset_toml(name).ok_or_else(|| {
            let known: Vec<&str> = presets().iter().map(|preset| preset.name).collect();
            let hint = format!(
                "known machines: {}; axes: {}",
                known.join(", "),
                axis_presets().join(", ")
            );
            Failure::with_hint(format!("there is no machine \"{name}\""), hint)
        }),
    }
}

/// Comments at the end of a preset's file.
fn tuned(name: &str) -> String {
    let Ok(machine) = Machine::preset(name) else {
        return String::new();
    };
    let table = tuning::table(&machine, &machine.tuning());
    let lines: Vec<String> = table
        .lines()
        .map(|line| format!("# {line}").trim_end().to_owned())
        .collect();
    format!(
        "\n# The loops as they are tuned here; `lostmotion machine check FILE` says it for a file.\n{}\n",
        lines.join("\n")
    )
}

/// What the machine's figures mean.
fn review(machine: &Machine) -> String {
    let right = Align::Right;
    let mut table = Table::new(&[
        ("axis", Align::Left),
        ("gap", right),
        ("peak torque", right),
        ("friction", right),
        ("motor 1/min", right),
        ("J load/motor", right),
        ("resonance Hz", right),
        ("velocity loop Hz", right),
        ("Kv 1/s", right),
    ]);
    let mut remarks = String::new();
    for (axis, figures) in machine.axes().iter().zip(machine.review()) {
        let unit = if axis.is_rotary() { "mdeg" } else { "um" };
        table.row([
            axis.id.letter().to_string().into(),
            format!("{} {unit}", error(axis.config.gap_in_unit() * 1e3)).into(),
            percent(figures.peak_torque_ratio).into(),
            percent(figures.friction_ratio).into(),
            format!("{:.0}", figures.motor_rpm).into(),
            format!("{:.2}", figures.inertia_ratio).into(),
            format!("{:.0}", figures.resonance_hz).into(),
            format!("{:.0}", figures.velocity_loop_hz).into(),
            plain(figures.position_gain_per_s).into(),
        ]);
        for remark in figures.remarks() {
            remarks.push_str(&format!("remark: {remark}\n"));
        }
    }
    format!("{}{remarks}", table.render())
}
