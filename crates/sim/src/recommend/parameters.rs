//! The parameters of controls: names, units, signs, and what they ask for.
//!
//! Numbers are printed only for parameters whose unit and meaning a primary source of the maker
//! tells; what is known from elsewhere is named without one.

use super::results::ControlSetting;
use crate::control::Control;
use lostmotion_base::AxisId;
use lostmotion_drive::config::Gap;
use lostmotion_gcode::Units;
use lostmotion_methods::AxisConfig;

/// An axis with what the control is told of it.
#[derive(Clone, Debug)]
pub(super) struct ToldAxis {
    pub(super) id: AxisId,
    /// `X`, `Y2`.
    pub(super) name: String,
    /// Whether it turns.
    pub(super) is_rotary: bool,
    /// Total gap that is told, mm or deg.
    pub(super) gap: f64,
    /// Largest speed and acceleration, mm or deg per s and s2.
    pub(super) velocity: f64,
    pub(super) acceleration: f64,
    /// With the settings that were simulated.
    pub(super) config: AxisConfig,
}

/// What is set, and what has to be true for it.
#[derive(Clone, Debug, Default)]
pub(super) struct Parameters {
    pub(super) settings: Vec<ControlSetting>,
    pub(super) paste: Vec<String>,
    pub(super) preconditions: Vec<String>,
    pub(super) notes: Vec<String>,
    pub(super) source: &'static str,
}

/// How a control counts.
#[derive(Clone, Debug)]
pub(super) struct Counting {
    /// Detection unit of a Fanuc control, um.
    pub(super) detection_unit_um: f64,
    /// Unit of length of LinuxCNC's settings.
    pub(super) units: Units,
    /// The axes of LinuxCNC's joints by their number.
    pub(super) joints: Vec<Option<AxisId>>,
}

impl Counting {
    /// Unit of an axis in LinuxCNC's settings: its name, the mm or deg in it, and the digits behind
    /// the point that a gap has.
    fn of(&self, is_rotary: bool) -> (&'static str, f64, usize) {
        match self.units {
            _ if is_rotary => ("deg", 1.0, 4),
            Units::Mm => ("mm", 1.0, 4),
            Units::Inch => ("inch", Units::Inch.mm(), 5),
        }
    }
}

/// Step of the value that a control takes for a gap, mm or deg.
pub(super) fn step(control: Control, counting: &Counting, is_rotary: bool) -> f64 {
    match control {
        Control::Fanuc => counting.detection_unit_um * 1e-3,
        Control::LinuxCnc if !is_rotary && counting.units == Units::Inch => 1e-5 * Units::Inch.mm(),
        Control::Marlin | Control::RepRapFirmware | Control::Smoothieware | Control::GrblHal => {
            1e-3
        }
        _ => 1e-4,
    }
}

/// Largest value that it takes, mm or deg.
fn most(control: Control, detection_unit_um: f64) -> f64 {
    match control {
        Control::Fanuc => 9999.0 * detection_unit_um * 1e-3,
        Control::Heidenhain => 1.0,
        _ => f64::INFINITY,
    }
}

/// The told gap of an axis as its settings have it.
pub(super) fn gap_of(value: f64, is_rotary: bool) -> Gap {
    if is_rotary {
        Gap::Mdeg(value * 1e3)
    } else {
        Gap::Um(value * 1e3)
    }
}

impl Parameters {
    fn set(
        &mut self,
        name: impl Into<String>,
        axis: &str,
        value: String,
        unit: &str,
        meaning: &str,
    ) {
        self.settings.push(ControlSetting {
            name: name.into(),
            axis: axis.to_owned(),
            value,
            unit: unit.to_owned(),
            meaning: meaning.to_owned(),
        });
    }

    fn line(&mut self, line: String) {
        self.paste.push(line);
    }

    /// Said once, though both joints of a gantry need it.
    fn needs(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !self.preconditions.contains(&text) {
            self.preconditions.push(text);
        }
    }

    fn note(&mut self, text: impl Into<String>) {
        self.notes.push(text.into());
    }
}

/// The parameters of a control with which a method is simulated.
///
/// # Errors
/// Why they cannot be given, for people.
pub(super) fn parameters(
    control: Control,
    method: &str,
    axes: &[ToldAxis],
    counting: &Counting,
) -> Result<Parameters, String> {
    let detection_unit_um = counting.detection_unit_um;
    let limit = most(control, detection_unit_um);
    if let Some(axis) = axes.iter().find(|axis| axis.gap > limit) {
        return Err(format!(
            "the gap of {} is {} {}, and a {control} control takes {limit} at most",
            axis.name,
            axis.gap,
            unit(axis)
        ));
    }
    let mut p = Parameters::default();
    match control {
        Control::LinuxCnc => linuxcnc(&mut p, axes, counting),
        Control::Fanuc => fanuc(&mut p, method, axes, detection_unit_um),
        Control::Siemens => siemens(&mut p, method, axes),
        Control::Heidenhain => heidenhain(&mut p, method, axes),
        Control::Mitsubishi => mitsubishi(&mut p, method, axes),
        Control::Fagor => fagor(&mut p, method, axes),
        Control::Beckhoff => isg(&mut p, axes),
        Control::Mach3 => mach3(&mut p, axes),
        Control::GrblHal => grblhal(&mut p, axes),
        Control::Marlin => marlin(&mut p, axes),
        Control::RepRapFirmware => reprap(&mut p, axes),
        Control::Smoothieware => smoothie(&mut p, axes),
        Control::Klipper | Control::Haas | Control::Own => return Err(unknown(control)),
    }
    Ok(p)
}

/// Why nothing can be said of a control's settings.
pub(super) fn unknown(control: Control) -> String {
    match control {
        Control::Haas => {
            "no primary source for the backlash settings of Haas controls is known here: no number is printed. Ask the manual of your control and the maker's service".to_owned()
        }
        Control::Klipper => {
            "Klipper as released has no backlash compensation; rewrite the program instead".to_owned()
        }
        control => format!(
            "a {control} control has no settings of its own: `simulate --methods` compares the methods themselves"
        ),
    }
}

fn unit(axis: &ToldAxis) -> &'static str {
    if axis.is_rotary { "deg" } else { "mm" }
}

/// A value without needless zeros, with a point.
fn short(value: f64, decimals: usize) -> String {
    let text = format!("{value:.decimals$}");
    let cut = text.trim_end_matches('0');
    if !text.contains('.') {
        text
    } else if cut.ends_with('.') {
        format!("{cut}0")
    } else {
        cut.to_owned()
    }
}

/// Axes that move along; the others are named as left out.
fn linear<'a>(p: &mut Parameters, axes: &'a [ToldAxis]) -> Vec<&'a ToldAxis> {
    let (turning, straight): (Vec<&ToldAxis>, Vec<&ToldAxis>) =
        axes.iter().partition(|axis| axis.is_rotary);
    for axis in turning {
        p.note(format!(
            "{}: in which unit rotary axes are set has no primary source here; no number is printed, and the simulation has it compensated",
            axis.name
        ));
    }
    straight
}

fn linuxcnc(p: &mut Parameters, axes: &[ToldAxis], counting: &Counting) {
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

fn fanuc(p: &mut Parameters, method: &str, axes: &[ToldAxis], detection_unit_um: f64) {
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
    p.needs("the axes are numbered A1, A2, ... in the order of the machine description");
}

fn siemens(p: &mut Parameters, method: &str, axes: &[ToldAxis]) {
    p.source = "Siemens 840D, 828D, 808D: function manual K3, list of machine data";
    for (number, axis) in axes.iter().enumerate() {
        let ax = format!("AX{}", number + 1);
        if method == "actual-value" {
            let value = short(axis.gap, 4);
            p.line(format!("N32450 $MA_BACKLASH[0,{ax}]={value}"));
            p.set(
                "MD32450 BACKLASH[0]",
                &axis.name,
                value,
                unit(axis),
                "total backlash, added to the actual value; + where the encoder leads",
            );
            continue;
        }
        pulse(p, axis, &ax);
    }
    if method != "actual-value" {
        p.note("blocks within one interpolation cycle are simulated with the whole pulse; where it overcompensates them, a smaller MD32580 has to be found on the machine");
    }
    p.needs("the axes are referenced: the compensation is active only behind it");
    p.needs("index 0 is the measuring system that closes the position loop; MD32452 BACKLASH_FACTOR is 1");
    p.needs("axes are AX1, AX2, ... in the order of the machine description; a reset of the NCK makes the data active");
}

/// Friction compensation of an axis: the pulse, and its curve over the acceleration. A block within one
/// interpolation cycle gets the whole pulse, as simulated.
fn pulse(p: &mut Parameters, axis: &ToldAxis, ax: &str) {
    let pulse = axis.config.compensation.decaying_pulse;
    // mm/min and m/s2 for linear axes, rev/min and rev/s2 for rotary ones.
    let (per_minute, per_second) = if axis.is_rotary {
        (60.0 / 360.0, 1.0 / 360.0)
    } else {
        (60.0, 1e-3)
    };
    let [speed, rise] = if axis.is_rotary {
        ["rev/min", "rev/s2"]
    } else {
        ["mm/min", "m/s2"]
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

fn heidenhain(p: &mut Parameters, method: &str, axes: &[ToldAxis]) {
    p.source = "Heidenhain iTNC 530 technical manual (MP710); MANUALplus 620 technical manual (CfgAxisComp)";
    if method != "actual-value" {
        p.note("reversal spikes (MP715, MP716): no primary source for how the amount is measured here; no number is printed");
        return;
    }
    for (number, axis) in linear(p, axes).into_iter().enumerate() {
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
}

fn mitsubishi(p: &mut Parameters, method: &str, axes: &[ToldAxis]) {
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

fn fagor(p: &mut Parameters, method: &str, axes: &[ToldAxis]) {
    p.source = "Fagor CNC 8060, 8065: installation manual (BACKLASH, BAKANOUT, BAKTIME)";
    let mut is_pulse = false;
    for axis in linear(p, axes) {
        if method == "fixed" {
            let value = short(axis.gap, 4);
            p.line(format!("BACKLASH {value}    ({})", axis.name));
            p.set("BACKLASH", &axis.name, value, "mm", "total backlash");
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
    p.note("how fast the control applies BACKLASH is not published; 15 ms are taken");
}

fn isg(p: &mut Parameters, axes: &[ToldAxis]) {
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

fn mach3(p: &mut Parameters, axes: &[ToldAxis]) {
    p.source = "secondary sources alone";
    for axis in linear(p, axes) {
        let value = short(axis.gap, 4);
        let percent = 100.0 * axis.config.compensation.fixed_mach3.speed_units_s / axis.velocity;
        p.line(format!(
            "Config > Backlash: {} distance {value}, speed {} %",
            axis.name,
            short(percent, 1)
        ));
        p.set(
            "backlash distance",
            &axis.name,
            value,
            "mm",
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
    p.note("what Mach3 does is known from secondary sources; it switches constant velocity off, so that the path stops at the end of every move");
}

fn grblhal(p: &mut Parameters, axes: &[ToldAxis]) {
    p.source = "grblHAL core, issues 364 and 751: $160 and following";
    for (number, axis) in linear(p, axes).into_iter().enumerate() {
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

/// ` X0.010 Y0.012`.
fn words(axes: &[&ToldAxis]) -> String {
    axes.iter()
        .map(|axis| format!(" {}{}", axis.name, short(axis.gap, 3)))
        .collect()
}

fn marlin(p: &mut Parameters, axes: &[ToldAxis]) {
    p.source = "Marlin documentation, M425; pull request 11061";
    let all = linear(p, axes);
    let Some(first) = all.first() else { return };
    let settings = first.config.compensation.fixed_by_travel;
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

fn reprap(p: &mut Parameters, axes: &[ToldAxis]) {
    p.source = "RepRapFirmware documentation, M425 (3.5 and later)";
    let all = linear(p, axes);
    let Some(first) = all.first() else { return };
    let multiple = short(first.config.compensation.fixed_by_travel.multiple, 0);
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

fn smoothie(p: &mut Parameters, axes: &[ToldAxis]) {
    p.source = "Smoothieware pull request 1543 and wiki";
    for (axis, actuator) in linear(p, axes).into_iter().zip(["alpha", "beta", "gamma"]) {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_zeros_behind_the_point_are_cut() {
        let texts = [
            (10.0, 0),
            (20.0, 0),
            (1.0, 0),
            (0.05, 4),
            (100.0, 1),
            (0.0, 3),
        ]
        .map(|(value, decimals)| short(value, decimals));
        assert_eq!(texts, ["10", "20", "1", "0.05", "100.0", "0.0"]);
    }
}
