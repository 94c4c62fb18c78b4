//! A log's units in those of the fits and of people, and what was found in words.

use lostmotion::drive::config::AxisUnit;
use lostmotion::identify::body::{
    BodyLog, Figure, LoadOff, LostMotion, Motion, RigidBody, ServoGains,
};
use lostmotion::identify::{BacklashFit, FitError, Presumed};
use lostmotion::logs::{AxisLog, DriveSignal};
use lostmotion::methods::AxisConfig;

/// Three digits, as people read them.
pub(super) fn figures(value: f64) -> String {
    if value == 0.0 || !value.is_finite() {
        return value.to_string();
    }
    let decimals =
        (2.0 - lostmotion::base::math::log10(value.abs()).floor()).clamp(0.0, 9.0) as usize;
    format!("{value:.decimals$}")
}

/// A figure and the ends of its interval with as many decimals as the interval has two digits of, and
/// the value three.
pub(super) fn with_interval(figure: Figure) -> [String; 3] {
    let [low, high] = figure.interval;
    let all = [figure.value, low, high];
    let largest = all.iter().fold(0.0, |top: f64, value| top.max(value.abs()));
    if !(largest > 0.0 && largest.is_finite()) {
        return all.map(|value| value.to_string());
    }
    let digit = |value: f64| lostmotion::base::math::log10(value).floor();
    let of_value = 2.0 - digit(largest);
    // Not more than six digits in all: of a clean log the interval is narrower than anything counts.
    let of_interval = (1.0 - digit(high - low)).min(of_value + 3.0);
    let decimals = of_value.max(of_interval).clamp(0.0, 9.0) as usize;
    all.map(|value| format!("{value:.decimals$}"))
}

pub(super) fn line(what: &str, figure: Figure, unit: &str) -> String {
    let [value, low, high] = with_interval(figure);
    format!("{what}: {value} {unit} (95 %: {low} to {high})\n")
}

/// Units of a log in those of the fits and of people.
pub(super) struct Scales {
    pub(super) unit: AxisUnit,
    /// m or rad in one unit of the log.
    pub(super) base: f64,
    /// m or rad in one small unit.
    pub(super) small: f64,
    pub(super) small_unit: &'static str,
    /// What drives the axis is multiplied with this.
    pub(super) drive: f64,
    pub(super) drive_unit: &'static str,
    /// The role of its column.
    pub(super) drive_name: &'static str,
    /// m or rad at the load for a radian of the motor; 1 where the axis is not given.
    pub(super) per_rad: f64,
}

impl Scales {
    pub(super) fn of(log: &AxisLog, unit: AxisUnit, described: Option<&AxisConfig>) -> Scales {
        let (base, small, small_unit) = match unit {
            AxisUnit::Mm => (1e-3, 1e-6, "um"),
            AxisUnit::Deg => (1.0_f64.to_radians(), 1e-3_f64.to_radians(), "mdeg"),
            AxisUnit::Rad => (1.0, 1e-6, "urad"),
        };
        let per_rad = described.map_or(1.0, |axis| axis.transmission.load_per_motor_rad());
        let force = if unit == AxisUnit::Mm { "N" } else { "N m" };
        let (drive, drive_unit) = match (&log.drive, described) {
            (Some(DriveSignal::Current(_)), Some(axis)) => {
                (axis.motor.torque_constant_nm_per_a / per_rad, force)
            }
            (Some(DriveSignal::Torque(_)), Some(_)) => (1.0 / per_rad, force),
            (Some(DriveSignal::Force(_)), _) => (1.0, force),
            (Some(DriveSignal::Torque(_)), None) => (1.0, "N m of the motor"),
            _ => (1.0, "A"),
        };
        let drive_name = match &log.drive {
            Some(DriveSignal::Torque(_)) => "torque",
            Some(DriveSignal::Force(_)) => "force",
            Some(DriveSignal::Current(_)) | None => "current",
        };
        Scales {
            unit,
            base,
            small,
            small_unit,
            drive,
            drive_unit,
            drive_name,
            per_rad,
        }
    }

    pub(super) fn body_log(&self, log: &AxisLog) -> Result<BodyLog, FitError> {
        let scaled =
            |values: &[f64], factor: f64| values.iter().map(|value| value * factor).collect();
        let drive = log.drive.as_ref().map_or(&[][..], DriveSignal::values);
        BodyLog::from_rows(
            &log.time_s,
            scaled(&log.motor, self.base),
            scaled(&log.load, self.base),
            scaled(&log.command, self.base),
            scaled(drive, self.drive),
        )
    }

    /// Whether forces at the load are known.
    pub(super) fn has_force(&self) -> bool {
        matches!(self.drive_unit, "N" | "N m")
    }

    pub(super) fn motion(&self, motion: &Motion, log: &BodyLog) -> String {
        let missing = match log.missing_rows() {
            0 => String::new(),
            count => format!(", {count} of them in the place of missing rows"),
        };
        let text = format!(
            "{} samples every {} ms{missing}: {} strokes, {} reversals, {} rests; up to {} {u}/s and {} {u}/s^2\n",
            log.len(),
            figures(1e3 * log.period_s),
            motion.strokes.len(),
            motion.reversals,
            motion.rests,
            figures(motion.top_speed / self.base),
            figures(motion.top_acceleration / self.base),
            u = self.unit.symbol(),
        );
        text + &log
            .load_off()
            .map_or(String::new(), |off| self.load_off(off))
    }

    /// How the load's scale was off the motor's.
    fn load_off(&self, off: &LoadOff) -> String {
        let mut text = String::new();
        let taken_off = |value: f64, interval: [f64; 2], unit: &str, more: [&str; 2]| {
            let way = if value < 0.0 { more[1] } else { more[0] };
            let mut ends = interval.map(|end| end * value.signum());
            ends.sort_by(f64::total_cmp);
            let [low, high] = ends.map(figures);
            let size = figures(value.abs());
            format!(
                "{size} {unit} {way} than the motor's (95 %: {low} to {high}); it is taken off\n"
            )
        };
        if off.scale != 0.0 {
            let unit = if self.unit == AxisUnit::Mm {
                "um/m"
            } else {
                "ppm"
            };
            let interval = off.scale_interval.map(|end| 1e6 * end);
            let more = ["more", "less"];
            text += "the load's position reads ";
            text += &taken_off(1e6 * off.scale, interval, unit, more);
        }
        if off.late_s != 0.0 {
            let interval = off.late_interval_s.map(|end| 1e3 * end);
            let more = ["later", "earlier"];
            text += "the load's position is read ";
            text += &taken_off(1e3 * off.late_s, interval, "ms", more);
        }
        text
    }

    /// How position is lost after a reversal.
    pub(super) fn lost(&self, lost: &LostMotion) -> String {
        let um = 1.0 / self.small;
        let u = self.small_unit;
        let total = lost.total.times(um);
        let mut text = if total.value > 0.0 {
            line("lost motion", total, u)
        } else {
            format!(
                "lost motion: at most {} {u} (95 %)\n",
                figures(total.interval[1])
            )
        };
        if lost.is_step {
            text += "  a step, as of a gap and wind-up, explains it\n";
            return text;
        }
        let [low, high] = lost.saturates_between.map(|end| figures(end * um));
        text += &format!(
            "  not a step: 95 % of it comes within {} {u} of travel ({low} to {high} {u}); a gap alone is no model of it\n",
            figures(lost.saturates_after * um),
        );
        text += &line("  of it at once", lost.step.times(um), u);
        text += &line("  of it along the travel", lost.along.times(um), u);
        text
    }

    pub(super) fn body(&self, body: &RigidBody) -> String {
        let way = if self.unit == AxisUnit::Mm {
            "m"
        } else {
            "rad"
        };
        let drive = self.drive_unit;
        let inertia = match drive {
            "N" => "kg".to_owned(),
            "N m" => "kg m2".to_owned(),
            other => format!("{other} s2/{way}"),
        };
        let mut text = if body.inertia.value > 0.0 {
            line("inertia, motor and load", body.inertia, &inertia)
        } else {
            // No motion tells a negative one.
            let most = figures(body.inertia.interval[1].max(0.0));
            format!("inertia, motor and load: at most {most} {inertia} (95 %)\n")
        };
        text += &line(
            "viscous friction",
            body.viscous,
            &format!("{drive} s/{way}"),
        );
        if let Some(sided) = &body.sided {
            for (which, figure) in ["  forwards", "  backwards"].into_iter().zip(sided.viscous) {
                text += &line(which, figure, &format!("{drive} s/{way}"));
            }
        }
        text += &line("Coulomb friction", body.coulomb, drive);
        if let Some(stribeck) = &body.stribeck {
            text += &line("breakaway above it (Stribeck)", stribeck.above, drive);
            if let Some(sided) = stribeck.sided {
                for (which, figure) in ["  forwards", "  backwards"].into_iter().zip(sided) {
                    text += &line(which, figure, drive);
                }
            }
            let speed = stribeck.speed.times(1.0 / self.base);
            text += &line(
                "  falls to 37 % at",
                speed,
                &format!("{}/s", self.unit.symbol()),
            );
        }
        if let Some(bound) = &body.stribeck_bound {
            text += &format!(
                "friction does not fall with speed (Stribeck): by at most {} {drive} from {} {}/s on (95 %)\n",
                figures(bound.above),
                figures(bound.from_speed / self.base),
                self.unit.symbol()
            );
        }
        text += &line("constant force", body.constant, drive);
        text += &format!(
            "  {} % of the force is left unexplained\n",
            figures(100.0 * body.residual_share)
        );
        text
    }

    pub(super) fn servo(&self, servo: &ServoGains) -> String {
        let mut text = line("lag behind the command", servo.lag_s.times(1e3), "ms");
        let Some(law) = &servo.law else {
            return text;
        };
        let way = if self.unit == AxisUnit::Mm {
            "m"
        } else {
            "rad"
        };
        text += &line("position gain", law.position_gain_per_s, "1/s");
        text += &line(
            "velocity gain",
            law.velocity_gain,
            &format!("{} s/{way}", self.drive_unit),
        );
        match law.integral_time_s {
            Some(time) if time.interval[1].is_infinite() => {
                text += &format!(
                    "integral time of the velocity loop: {} ms or more\n",
                    figures(1e3 * time.interval[0])
                );
            }
            Some(time) => {
                text += &line("integral time of the velocity loop", time.times(1e3), "ms");
            }
            None => text += "the velocity loop has no integral part\n",
        }
        if let Some([gain, time]) = law.alike {
            text += &format!(
                "  {} 1/s with {} ms explain the log alike, as the whole speed is fed forward: taken is the slower position loop\n",
                figures(gain),
                figures(1e3 * time)
            );
        }
        text += &format!(
            "velocity feed-forward {}, measured speed or current {} ms late; {} % of the current is left unexplained\n",
            figures(law.feedforward),
            figures(1e3 * law.delay_s),
            figures(100.0 * law.residual_share),
        );
        text
    }
}

/// Part of the gap's interval from which on what lateness makes of it is said. A choice: the larger half.
const LATENESS_SHARE: f64 = 0.5;

/// The gap's total and interval, m or rad at the load.
pub(super) fn gap_figure(fit: &BacklashFit, per_rad: f64) -> Figure {
    Figure {
        value: 2.0 * fit.half_gap_rad * per_rad,
        error: 0.0,
        interval: fit.half_gap_interval_rad.map(|half| 2.0 * half * per_rad),
    }
}

pub(super) fn gap_text(fit: &BacklashFit, scales: &Scales) -> String {
    let gap = gap_figure(fit, scales.per_rad).times(1.0 / scales.small);
    let mut text = line("gap", gap, scales.small_unit);
    if let Some(reason) = fit.reason.as_ref().filter(|_| !fit.excited) {
        text += &format!("  the log does not tell it from zero: {reason}\n");
    }
    let [low, high] = gap.interval;
    let late = 2.0 * fit.half_gap_lateness_rad * scales.per_rad / scales.small;
    if late > LATENESS_SHARE * 0.5 * (high - low) {
        text += &format!(
            "  {} {} of that either way are for a load that may be read later or earlier than its motor (--lateness), which this log does not tell: log strokes of several speeds\n",
            figures(late),
            scales.small_unit
        );
    }
    for other in &fit.otherwise {
        let half_um = other.half_gap_rad * scales.per_rad / scales.small;
        let with = match other.presumed {
            Presumed::DescribedStiffness => "the stiffness that is described",
            _ => "the motor that the log itself shows",
        };
        text += &format!(
            "  with {with} it would be {} {}, which the interval holds: log strokes of several speeds and accelerations\n",
            figures(2.0 * half_um),
            scales.small_unit
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_shows_its_width() {
        let shown = |value: f64, low: f64, high: f64| {
            with_interval(Figure {
                value,
                error: 0.0,
                interval: [low, high],
            })
            .join(" ")
        };
        assert_eq!(shown(898.3196, 897.946, 898.698), "898.32 897.95 898.70");
        assert_eq!(shown(10.5, 4.09, 15.6), "10.5 4.1 15.6");
        assert_eq!(shown(1073.0, -193.2, 2339.4), "1073 -193 2339");
        assert_eq!(shown(-16.8, -26.0, -7.61), "-16.8 -26.0 -7.6");
        // no more than six digits, however narrow
        assert_eq!(
            shown(9.99996, 9.999_95, 9.999_96),
            "9.99996 9.99995 9.99996"
        );
        assert_eq!(shown(0.0, 0.0, 0.0), "0 0 0");
        assert_eq!(shown(5.0, 5.0, 5.0), "5.00000 5.00000 5.00000");
    }
}
