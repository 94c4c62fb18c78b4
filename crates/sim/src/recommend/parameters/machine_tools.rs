//! Settings of the controls of machine tools.

use super::{Counting, Parameters, ToldAxis, linear, numbered, short};
use lostmotion_gcode::Units;

pub(super) fn fanuc(p: &mut Parameters, method: &str, axes: &[ToldAxis], detection_unit_um: f64) {
    p.source = "Fanuc B-63090EN/02 p. 97, B-64120EN/01 p. 116";
    if method != "fixed-fanuc" {
        p.note("backlash acceleration (2003#5, 2048, 2071, 2009) is sought by simulation only as a pulse; the units of these parameters have no primary source here, so no number is printed");
        return;
    }
    let mut line = "N1851".to_owned();
    for (number, axis) in axes.iter().enumerate() {
        let units = (axis.gap * 1e3 / detection_unit_um).round();
        let value = format!("{units:.0}");
        line.push_str(&format!(" A{}P{value}", number + 1));
        p.set(
            "1851",
            &axis.name,
            value,
            &format!(
                "detection units of {detection_unit_um} {}",
                if axis.is_rotary { "mdeg" } else { "um" }
            ),
            "total backlash, cutting feed and, with RBK = 0, rapid traverse",
        );
    }
    p.line(line);
    p.set(
        "1800#4 (RBK)",
        "",
        "0".to_owned(),
        "bit",
        "one amount for cutting and rapid traverse; with 1 set 1852 as 1851",
    );
    p.needs(format!(
        "the detection unit is {detection_unit_um} um (least input increment, CMR and DMR): the value is counted in it; --detection-unit-um changes it"
    ));
    p.needs("the reference position is established: before, the amount for rapid traverse is not used; jog counts as cutting");
    let all: Vec<&ToldAxis> = axes.iter().collect();
    let order = numbered(&all, |place| format!("A{}", place + 1));
    p.needs(format!("the axes are numbered as here: {order}"));
}

pub(super) fn siemens(p: &mut Parameters, method: &str, axes: &[ToldAxis], counting: &Counting) {
    p.source = "Siemens 840D, 828D, 808D: function manual K3, list of machine data";
    for (number, axis) in axes.iter().enumerate() {
        let ax = format!("AX{}", number + 1);
        if method == "actual-value" {
            let (unit, size, decimals) = counting.of(axis.is_rotary);
            let value = short(axis.gap / size, decimals);
            p.line(format!("N32450 $MA_BACKLASH[0,{ax}]={value}"));
            p.set(
                "MD32450 BACKLASH[0]",
                &axis.name,
                value,
                unit,
                "total backlash, added to the actual value; + where the encoder leads",
            );
            continue;
        }
        pulse(p, axis, &ax, counting);
    }
    if method != "actual-value" {
        p.note("blocks within one interpolation cycle are simulated with the whole pulse; where it overcompensates them, a smaller MD32580 has to be found on the machine");
    }
    p.needs("the axes are referenced: the compensation is active only behind it");
    p.needs("index 0 is the measuring system that closes the position loop; MD32452 BACKLASH_FACTOR is 1");
    let all: Vec<&ToldAxis> = axes.iter().collect();
    let order = numbered(&all, |place| format!("AX{}", place + 1));
    p.needs(format!(
        "the axes are numbered as here: {order}; a reset of the NCK makes the data active"
    ));
    let system = match counting.units {
        Units::Mm => "1: lengths of machine data are in mm",
        Units::Inch => "0: lengths of machine data are in inches",
    };
    p.needs(format!("MD10240 SCALING_SYSTEM_IS_METRIC is {system}"));
}

/// Friction compensation of an axis: the pulse, and its curve over the acceleration. A block within one
/// interpolation cycle gets the whole pulse, as simulated.
fn pulse(p: &mut Parameters, axis: &ToldAxis, ax: &str, counting: &Counting) {
    let pulse = axis.config.compensation.decaying_pulse;
    // Of linear axes the acceleration is in metres where lengths are metric.
    let (per_minute, per_second, speed, rise) = match (axis.is_rotary, counting.units) {
        (true, _) => (60.0 / 360.0, 1.0 / 360.0, "rev/min", "rev/s2"),
        (false, Units::Mm) => (60.0, 1e-3, "mm/min", "m/s2"),
        (false, Units::Inch) => {
            let size = Units::Inch.mm();
            (60.0 / size, 1.0 / size, "inch/min", "inch/s2")
        }
    };
    let height = |units: f64| short(units * per_minute, 3);
    let curve = pulse.acceleration_units_s2;
    let mut all = vec![
        (
            32490,
            "FRICT_COMP_MODE",
            "1".to_owned(),
            "-",
            "constant or adaptive",
        ),
        (32500, "FRICT_COMP_ENABLE", "1".to_owned(), "-", "on"),
        (
            32510,
            "FRICT_COMP_ADAPT_ENABLE",
            if curve.is_some() { "1" } else { "0" }.to_owned(),
            "-",
            if curve.is_some() {
                "the height changes with the acceleration"
            } else {
                "the same height at all accelerations"
            },
        ),
        (
            32520,
            "FRICT_COMP_CONST_MAX",
            height(pulse.height_units_s.unwrap_or(0.0)),
            speed,
            "height of the pulse",
        ),
    ];
    if let Some(accelerations) = curve {
        let least = pulse.least_height_units_s.unwrap_or(0.0);
        let meaning = "height beyond acceleration 3";
        all.push((32530, "FRICT_COMP_CONST_MIN", height(least), speed, meaning));
        let names = [
            "FRICT_COMP_ACCEL1",
            "FRICT_COMP_ACCEL2",
            "FRICT_COMP_ACCEL3",
        ];
        let meanings = [
            "the height has risen",
            "the height begins to fall",
            "the height has fallen",
        ];
        for (index, value) in accelerations.into_iter().enumerate() {
            let number = 32550 + 10 * index;
            let value = short(value * per_second, 4);
            all.push((number, names[index], value, rise, meanings[index]));
        }
    }
    let time = short(pulse.time_ms * 1e-3, 4);
    let meaning = "time constant of the pulse";
    all.push((32540, "FRICT_COMP_TIME", time, "s", meaning));
    let meaning = "of the height, in blocks within one interpolation cycle";
    let whole = "100".to_owned();
    all.push((32580, "FRICT_COMP_INC_FACTOR", whole, "%", meaning));
    all.sort_by_key(|row| row.0);
    for (number, name, value, unit, meaning) in all {
        let index = if matches!(number, 32490 | 32500 | 32510) {
            ""
        } else {
            "0,"
        };
        p.line(format!("N{number} $MA_{name}[{index}{ax}]={value}"));
        p.set(
            format!("MD{number} {name}"),
            &axis.name,
            value,
            unit,
            meaning,
        );
    }
}

pub(super) fn heidenhain(p: &mut Parameters, method: &str, axes: &[ToldAxis]) {
    p.source = "Heidenhain iTNC 530 technical manual (MP710); MANUALplus 620 technical manual (CfgAxisComp)";
    if method != "actual-value" {
        p.note("reversal spikes (MP715, MP716): no primary source for how the amount is measured here; no number is printed");
        return;
    }
    let all = linear(p, axes);
    let order = numbered(&all, |place| format!("MP710.{place}"));
    for (number, axis) in all.into_iter().enumerate() {
        let value = short(axis.gap, 4);
        let time = axis.config.compensation.actual_value.spread_ms;
        if time > 0.0 {
            p.note(format!(
                "{}: MP710 of the iTNC 530 has no such time, and is not what was simulated",
                axis.name
            ));
        } else {
            p.line(format!(
                "MP710.{number} : {value}    ; iTNC 530, {}",
                axis.name
            ));
        }
        p.line(format!(
            "CfgAxisComp backLash {value} filterTime {}    ; newer controls, {}",
            short(time, 1),
            axis.name
        ));
        p.set(
            "MP710 / 401802 backLash",
            &axis.name,
            value,
            "mm",
            "total backlash; + where the encoder is ahead",
        );
        p.set(
            "401805 filterTime",
            &axis.name,
            short(time, 1),
            "ms",
            "time over which it is spread",
        );
    }
    p.needs("rotary encoders at the motors close the loop; with linear encoders MP750 and MP752 (posCtrlRevErr, posCtrlRevErrTime) are meant");
    p.needs("MP710 and MP750 are not both set for one axis");
    p.needs(format!("the axes are numbered as here: {order}"));
}

pub(super) fn mitsubishi(p: &mut Parameters, method: &str, axes: &[ToldAxis]) {
    p.source = "Mitsubishi M80: IB-1501269 (backlash compensation II); drive manuals (SV016, SV027, SV041)";
    if method == "fixed-mitsubishi" {
        for axis in linear(p, axes) {
            p.set(
                "backlash compensation amount, G0 and G1",
                &axis.name,
                short(axis.gap, 4),
                "mm",
                "total backlash",
            );
        }
        p.note("the numbers of these parameters (2011 G0back and 2012 G1back by secondary sources) have no primary source here, nor has their unit: enter the mm above in the unit that your manual names");
        return;
    }
    for axis in axes {
        let amount = axis
            .config
            .compensation
            .friction_torque
            .amount_nm
            .unwrap_or(0.0);
        let percent = 100.0 * amount / axis.config.motor.rated_torque_nm;
        let value = format!("{:.0}", percent.clamp(0.0, 200.0));
        p.line(format!(
            "{}: SV027 bit 9 = 1, SV016 = {value}, SV041 = 0",
            axis.name
        ));
        p.set(
            "SV016 LMC1",
            &axis.name,
            value,
            "% of the stall current",
            "lost motion compensation; twice the friction torque is the standard",
        );
        p.set(
            "SV041 LMC2",
            &axis.name,
            "0".to_owned(),
            "% of the stall current",
            "the other direction; 0 is the same as LMC1",
        );
    }
    p.needs("SV027 bit 9 switches the compensation on; the rated torque of the description is taken for the stall torque");
}

pub(super) fn fagor(p: &mut Parameters, method: &str, axes: &[ToldAxis], counting: &Counting) {
    p.source = "Fagor CNC 8060, 8065: installation manual (BACKLASH, BAKANOUT, BAKTIME)";
    let mut is_pulse = false;
    for axis in linear(p, axes) {
        if method == "fixed" {
            let (unit, size, decimals) = counting.of(false);
            let value = short(axis.gap / size, decimals);
            p.line(format!("BACKLASH {value}    ({}, {unit})", axis.name));
            p.set("BACKLASH", &axis.name, value, unit, "total backlash");
            continue;
        }
        let pulse = axis.config.compensation.decaying_pulse;
        let per_mm = axis.config.transmission.motor_rad_per_unit();
        let rpm = pulse.height_units_s.unwrap_or(0.0) * per_mm * 60.0 / std::f64::consts::TAU;
        p.line(format!(
            "BAKANOUT {}, BAKTIME {}    ({})",
            short(rpm, 2),
            short(pulse.time_ms, 1),
            axis.name
        ));
        p.set(
            "BAKANOUT",
            &axis.name,
            short(rpm, 2),
            "1/min of the motor",
            "additional command at the reversal",
        );
        p.set(
            "BAKTIME",
            &axis.name,
            short(pulse.time_ms, 1),
            "ms",
            "time of the exponential pulse, 0 to 100",
        );
        is_pulse = true;
    }
    if is_pulse {
        p.needs("ACTBAKAN: the pulse on all moves, not on G2 and G3 alone, as simulated");
    }
    let unit = counting.of(false).0;
    p.needs(format!("lengths of machine parameters are in {unit}, as `control_units` of the machine description says"));
    p.note("how fast the control applies BACKLASH is not published; 15 ms are taken");
}

pub(super) fn isg(p: &mut Parameters, axes: &[ToldAxis]) {
    p.source = "ISG kernel, axis parameters: P-AXIS-00021, P-AXIS-00103, P-AXIS-00243";
    for axis in linear(p, axes) {
        let units = format!("{:.0}", axis.gap * 1e4);
        let cycles = axis.config.compensation.fixed_isg.cycles.to_string();
        p.line(format!(
            "{}: P-AXIS-00103 {units}, P-AXIS-00021 1, P-AXIS-00243 {cycles}",
            axis.name
        ));
        p.set(
            "P-AXIS-00103",
            &axis.name,
            units,
            "0.1 um",
            "total backlash; positive between the motor and the slide",
        );
        p.set(
            "P-AXIS-00021",
            &axis.name,
            "1".to_owned(),
            "-",
            "on, the last motion before it was positive; 2: it was negative; 0 is off",
        );
        p.set(
            "P-AXIS-00243",
            &axis.name,
            cycles,
            "cycles",
            "over which it is spread along sin2; 0 and 1 are abrupt",
        );
    }
    p.needs("the cycle of the control is the command cycle of the machine description");
    p.needs("P-AXIS-00021 as homing ends: 1 where its last motion is in positive direction, 2 in negative");
    p.note("plain TwinCAT NC (PTP, NC I) has none of these: there it is MC_BacklashCompensation of Tc2_MC2, Backlash in mm with Position Correction enabled; how it gets there is not published, so no value is printed");
}
