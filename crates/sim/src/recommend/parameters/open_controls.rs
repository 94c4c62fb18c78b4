//! Settings of controls on a computer and of firmware: LinuxCNC, Mach3, grblHAL, Marlin, RepRapFirmware,
//! Smoothieware.

use super::{Counting, Parameters, ToldAxis, linear, short};
use lostmotion_base::AxisId;

pub(super) fn linuxcnc(p: &mut Parameters, axes: &[ToldAxis], counting: &Counting) {
    p.source = "LinuxCNC documentation, INI configuration: [JOINT_n] BACKLASH";
    for (joint, id) in counting.joints.iter().enumerate() {
        // The second joint of an axis is that of its second motor, where the machine has one.
        let before = counting.joints.iter().take(joint);
        let place = before.filter(|other| *other == id).count();
        let own: Vec<&ToldAxis> = axes.iter().filter(|axis| Some(axis.id) == *id).collect();
        let Some(axis) = own.get(place).or(own.last()) else {
            continue;
        };
        if place >= own.len() {
            p.note(format!(
                "{}: more than one joint moves it, and the machine description has one motor with one gap there: where their gaps differ, each joint gets its own",
                axis.name
            ));
        }
        let (unit, size, decimals) = counting.of(axis.is_rotary);
        let value = short(axis.gap / size, decimals);
        let meaning = "total backlash, taken up at half of the joint's limits";
        p.line(format!("[JOINT_{joint}]    # {}, {unit}", axis.name));
        p.line(format!("BACKLASH = {value}"));
        p.set(
            format!("[JOINT_{joint}]BACKLASH"),
            &axis.name,
            value,
            unit,
            meaning,
        );
        p.needs(format!(
            "{0}: with stepgen STEPGEN_MAXACCEL of {1} to {2} {3}/s2, 1.5 to 2 times MAX_ACCELERATION, and STEPGEN_MAXVEL of {4} {3}/s or more: the take-up is added to the motion",
            axis.name,
            short(1.5 * axis.acceleration / size, 1),
            short(2.0 * axis.acceleration / size, 1),
            unit,
            short(1.5 * axis.velocity / size, 1),
        ));
    }
    let linear = counting.of(false).0;
    p.needs(format!(
        "LINEAR_UNITS = {linear}, as `control_units` of the machine description says"
    ));
    p.needs("no COMP_FILE of the same joint: it replaces BACKLASH");
    let letters: String = counting
        .joints
        .iter()
        .map(|id| id.map_or('-', AxisId::letter))
        .collect();
    p.note(format!(
        "joints are numbered as {letters} (`joint_axes` of the machine description): compare with [KINS]; while running, `halcmd setp ini.N.backlash` changes the same value"
    ));
}

pub(super) fn mach3(p: &mut Parameters, axes: &[ToldAxis], counting: &Counting) {
    p.source = "secondary sources alone";
    for axis in linear(p, axes) {
        let (unit, size, decimals) = counting.of(false);
        let value = short(axis.gap / size, decimals);
        let percent = 100.0 * axis.config.compensation.fixed_mach3.speed_units_s / axis.velocity;
        p.line(format!(
            "Config > Backlash: {} distance {value} {unit}, speed {} %",
            axis.name,
            short(percent, 1)
        ));
        p.set(
            "backlash distance",
            &axis.name,
            value,
            unit,
            "total backlash",
        );
        p.set(
            "backlash speed",
            &axis.name,
            short(percent, 1),
            "% of the largest",
            "one for all axes; the acceleration is ignored",
        );
    }
    let unit = counting.of(false).0;
    p.needs(format!(
        "the native units (Config > Select Native Units) are {unit}, as `control_units` of the machine description says"
    ));
    p.note("what Mach3 does is known from secondary sources; it switches constant velocity off, so that the path stops at the end of every move");
}

pub(super) fn grblhal(p: &mut Parameters, axes: &[ToldAxis]) {
    p.source = "grblHAL core, issues 364 and 751: $160 and following";
    for axis in linear(p, axes) {
        let Some(number) = place(axis, "XYZABCUV") else {
            continue;
        };
        let value = short(axis.gap, 3);
        p.line(format!("${}={value}", 160 + number));
        p.set(
            format!("${}", 160 + number),
            &axis.name,
            value,
            "mm",
            "total backlash",
        );
    }
    p.needs("the firmware is built with backlash compensation, a compile-time option; uCNC and grbl forks number these settings otherwise");
    p.note("a rapid of the gap's length is put before the move, so the path stops at every reversal. Told too much it cuts with a rapid: small end mills break (issue 751)");
}

/// Number of an axis on a control that counts its axes by their letters; none of one that it has not.
fn place(axis: &ToldAxis, letters: &str) -> Option<usize> {
    letters.find(axis.id.letter())
}

/// ` X0.010 Y0.012`.
fn words(axes: &[&ToldAxis]) -> String {
    axes.iter()
        .map(|axis| format!(" {}{}", axis.name, short(axis.gap, 3)))
        .collect()
}

pub(super) fn marlin(p: &mut Parameters, axes: &[ToldAxis]) {
    p.source = "Marlin documentation, M425; pull request 11061";
    let all = linear(p, axes);
    let Some(first) = all.first() else { return };
    let settings = first.config.compensation.fixed_by_travel;
    p.line("G21".to_owned());
    p.line(format!(
        "M425 F{} S{}{}",
        short(settings.correction, 2),
        short(settings.smoothing_mm, 1),
        words(&all)
    ));
    for axis in &all {
        p.set(
            format!("M425 {}", axis.name),
            &axis.name,
            short(axis.gap, 3),
            "mm",
            "total backlash",
        );
    }
    p.set(
        "M425 F",
        "",
        short(settings.correction, 2),
        "-",
        "part that is corrected, 0 to 1",
    );
    p.set(
        "M425 S",
        "",
        short(settings.smoothing_mm, 1),
        "mm",
        "path over which it is spread",
    );
    p.needs("BACKLASH_COMPENSATION and BACKLASH_GCODE are compiled in; M500 keeps the values");
    p.note("arcs of Marlin are lines of about 1 mm; steps are added a line at a time");
}

pub(super) fn reprap(p: &mut Parameters, axes: &[ToldAxis]) {
    p.source = "RepRapFirmware documentation, M425 (3.5 and later)";
    let all = linear(p, axes);
    let Some(first) = all.first() else { return };
    let multiple = short(first.config.compensation.fixed_by_travel.multiple, 0);
    p.line("G21".to_owned());
    p.line(format!("M425{} S{multiple}", words(&all)));
    for axis in &all {
        p.set(
            format!("M425 {}", axis.name),
            &axis.name,
            short(axis.gap, 3),
            "mm",
            "total backlash, of the motor",
        );
    }
    p.set(
        "M425 S",
        "",
        multiple,
        "-",
        "way over which it is spread, in gaps",
    );
    p.needs("RepRapFirmware 3.5 or later; not on delta machines; motors that lose steps need a larger S");
}

pub(super) fn smoothie(p: &mut Parameters, axes: &[ToldAxis]) {
    p.source = "Smoothieware pull request 1543 and wiki";
    for axis in linear(p, axes) {
        let Some(place) = place(axis, "XYZ") else {
            continue;
        };
        let actuator = ["alpha", "beta", "gamma"][place];
        let value = short(axis.gap, 3);
        p.line(format!(
            "{actuator}_backlash_mm    {value}    # {}",
            axis.name
        ));
        p.set(
            format!("{actuator}_backlash_mm"),
            &axis.name,
            value,
            "mm",
            "total backlash",
        );
    }
    p.needs("version 2 writes alpha.backlash_mm and needs backlash_enable = true");
    p.note("how the steps are spread is taken as of Marlin without smoothing");
}
