//! How an axis begins that is run alone.

use crate::output::Failure;
use clap::Args;
use lostmotion::base::names::did_you_mean;
use lostmotion::drive::AxisStart;
use lostmotion::drive::config::{AxisUnit, StartInGap};
use lostmotion::methods::AxisConfig;

/// How the axis begins.
#[derive(Debug, Default, Args)]
#[command(next_help_heading = "Start")]
pub(crate) struct Start {
    /// What the axis begins with besides the first position, which is the motor's:
    /// motor_velocity_U_s, load_velocity_U_s (U: the axis' unit, mm, deg or rad), wind_up_um
    /// (wind_up_mdeg, wind_up_rad; motor less load past the flank on the side of its sign), or
    /// in_gap, the motor's lead over the load in half gaps, -1 to 1; several with commas, may be
    /// repeated
    #[arg(long, value_name = "KEY=VALUE,..", allow_hyphen_values = true)]
    pub(crate) start: Vec<String>,
    /// The drive is off: no current flows, and the setpoints give time and force alone
    #[arg(long, conflicts_with = "method")]
    pub(crate) drive_off: bool,
}

/// What a key sets.
#[derive(Clone, Copy, PartialEq)]
enum Sets {
    MotorVelocity,
    LoadVelocity,
    WindUp,
    InGap,
}

/// The keys of an axis, each with what it sets and the axis' units in one of its own.
fn keys(unit: AxisUnit) -> [(&'static str, Sets, f64); 4] {
    // Wind-ups are told in the unit in which gaps are.
    let (motor, load, wind_up, share) = match unit {
        AxisUnit::Mm => (
            "motor_velocity_mm_s",
            "load_velocity_mm_s",
            "wind_up_um",
            1e-3,
        ),
        AxisUnit::Deg => (
            "motor_velocity_deg_s",
            "load_velocity_deg_s",
            "wind_up_mdeg",
            1e-3,
        ),
        AxisUnit::Rad => (
            "motor_velocity_rad_s",
            "load_velocity_rad_s",
            "wind_up_rad",
            1.0,
        ),
    };
    [
        (motor, Sets::MotorVelocity, 1.0),
        (load, Sets::LoadVelocity, 1.0),
        (wind_up, Sets::WindUp, share),
        ("in_gap", Sets::InGap, 1.0),
    ]
}

impl Start {
    /// The axis with its place in the gap, and its start with the motor at a position.
    ///
    /// # Errors
    /// A word that is not understood, a value that the axis cannot begin with.
    pub(crate) fn of(
        &self,
        config: AxisConfig,
        position: f64,
    ) -> Result<(AxisConfig, AxisStart), Failure> {
        let mut config = config;
        let keys = keys(config.unit());
        let example = format!("for example: --start {}=10,{}=20", keys[0].0, keys[2].0);
        let mut start = AxisStart {
            drive_off: self.drive_off,
            ..AxisStart::at(position)
        };
        let mut told: Vec<Sets> = Vec::new();
        for word in self.start.iter().flat_map(|option| option.split(',')) {
            let refused =
                |why: &str, hint: &str| Failure::with_hint(format!("--start {word}: {why}"), hint);
            let (key, text) = word
                .split_once('=')
                .ok_or_else(|| refused("it is not of the form KEY=VALUE", &example))?;
            let key = key.trim();
            let (_, sets, share) = keys
                .into_iter()
                .find(|(name, ..)| *name == key)
                .ok_or_else(|| {
                    let names = keys.map(|(name, ..)| name);
                    let why = format!("an axis in {} has no key `{key}`", config.unit().symbol());
                    refused(&why, &did_you_mean(key, &names))
                })?;
            let value = text
                .trim()
                .parse::<f64>()
                .ok()
                .filter(|value| value.is_finite())
                .ok_or_else(|| refused(&format!("`{text}` is not a finite number"), &example))?;
            if told.contains(&sets) {
                return Err(refused("it is told twice", "keep one of the two"));
            }
            told.push(sets);
            match sets {
                Sets::MotorVelocity => start.motor_velocity = value * share,
                Sets::LoadVelocity => start.load_velocity = value * share,
                Sets::WindUp => start.wind_up = Some(value * share),
                Sets::InGap if (-1.0..=1.0).contains(&value) => {
                    config.start_in_gap = StartInGap(value);
                }
                Sets::InGap => {
                    return Err(refused(
                        "it has to be from -1 to 1",
                        "in half gaps: -1 is the negative flank, 0 the middle, 1 the positive flank",
                    ));
                }
            }
        }
        // A shaft that is wound up is on a flank.
        if told.contains(&Sets::WindUp) && told.contains(&Sets::InGap) {
            return Err(Failure::with_hint(
                format!(
                    "--start: {} and in_gap say where the load is in its gap",
                    keys[2].0
                ),
                "keep one of the two: a wind-up puts the load on the flank of its sign",
            ));
        }
        start
            .check(&config)
            .map_err(|error| Failure::with_hint(format!("--start: {error}"), example))?;
        Ok((config, start))
    }
}
