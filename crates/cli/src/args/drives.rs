//! How drives are commanded.

use clap::Args;

/// From the command to the drives.
#[derive(Debug, Default, Args)]
pub(crate) struct Drives {
    /// How the drives go from setpoint to setpoint: linear, cubic-differences, catmull-rom,
    /// cubic-hermite, quintic-hermite, b-spline, compensated-b-spline or quintic-differences, for
    /// all axes or for one (x=linear); may be repeated
    #[arg(long, value_name = "[AXIS=]NAME")]
    pub(crate) interpolator: Vec<String>,
    #[command(flatten)]
    pub(crate) cycles: Cycles,
}

/// Cycles of command and servo.
#[derive(Clone, Copy, Debug, Default, Args)]
pub(crate) struct Cycles {
    /// Time from setpoint to setpoint, 0.25 to 8 ms; the machine's, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) command_ms: Option<f64>,
    /// Time from servo tick to servo tick, 31.25 to 1000 us, a whole fraction of the command's; the
    /// machine's, if left out
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub(crate) servo_us: Option<f64>,
}
