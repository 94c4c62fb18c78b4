//! The log of one axis.

use lostmotion_drive::AxisSample;

use crate::error::FitError;

/// Motor position, load position and current of one axis, sampled together at a fixed period.
#[derive(Clone, Debug, PartialEq)]
pub struct BacklashLog {
    period_s: f64,
    motor: Vec<f64>,
    load: Vec<f64>,
    current: Vec<f64>,
}

impl BacklashLog {
    /// A log from its columns: motor position and load position in rad at the motor shaft (the
    /// load's position times the gear ratio, or times 2 pi over the lead), torque-forming current
    /// in A.
    ///
    /// # Errors
    /// A period that is not positive, columns that are empty or differ in length, or the first
    /// value that is not finite.
    pub fn new(
        period_s: f64,
        motor: Vec<f64>,
        load: Vec<f64>,
        current: Vec<f64>,
    ) -> Result<Self, FitError> {
        if !(period_s.is_finite() && period_s > 0.0) {
            return Err(FitError::Setting {
                name: "period_s",
                value: period_s,
                expected: "a positive finite number",
            });
        }
        if motor.len() != load.len() || motor.len() != current.len() {
            return Err(FitError::LengthMismatch {
                motor: motor.len(),
                load: load.len(),
                current: current.len(),
            });
        }
        if motor.is_empty() {
            return Err(FitError::Empty);
        }
        for (column, values) in [("motor", &motor), ("load", &load), ("current", &current)] {
            if let Some((index, &value)) = values
                .iter()
                .enumerate()
                .find(|(_, value)| !value.is_finite())
            {
                return Err(FitError::NotFinite {
                    column,
                    index,
                    value,
                });
            }
        }
        Ok(Self {
            period_s,
            motor,
            load,
            current,
        })
    }

    /// The log that a simulated axis leaves behind, positions without encoder error.
    ///
    /// # Errors
    /// As [`BacklashLog::new`].
    pub fn from_samples(period_s: f64, samples: &[AxisSample]) -> Result<Self, FitError> {
        Self::new(
            period_s,
            samples.iter().map(|sample| sample.motor_position).collect(),
            samples.iter().map(|sample| sample.load_position).collect(),
            samples.iter().map(|sample| sample.current).collect(),
        )
    }

    /// Time between samples, s.
    pub fn period_s(&self) -> f64 {
        self.period_s
    }

    /// Samples in the log, at least one.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.motor.len()
    }

    /// Motor positions, rad.
    pub fn motor(&self) -> &[f64] {
        &self.motor
    }

    /// Load positions, rad at the motor shaft.
    pub fn load(&self) -> &[f64] {
        &self.load
    }

    /// Currents, A.
    pub fn current(&self) -> &[f64] {
        &self.current
    }

    /// Standard deviation of the quantisation error of `motor - load`, rad: each position error
    /// taken as uniform over the smallest step that its column makes. Nearly zero where positions
    /// are not quantised.
    pub fn resolution_rad(&self) -> f64 {
        let square = |column: &[f64]| {
            // The smallest step that the column makes is taken for one count.
            let step = column
                .windows(2)
                .map(|pair| (pair[1] - pair[0]).abs())
                .filter(|step| *step > 0.0)
                .fold(f64::INFINITY, f64::min);
            if step.is_finite() {
                step * step / 12.0
            } else {
                0.0
            }
        };
        (square(&self.motor) + square(&self.load)).sqrt()
    }
}

/// Motor position and current of one axis, sampled together at a fixed period.
#[derive(Clone, Debug, PartialEq)]
pub struct MotorLog {
    /// The load's column is zero.
    log: BacklashLog,
}

impl MotorLog {
    /// A log from its columns: motor position in rad, torque-forming current in A.
    ///
    /// # Errors
    /// As [`BacklashLog::new`].
    pub fn new(period_s: f64, motor: Vec<f64>, current: Vec<f64>) -> Result<Self, FitError> {
        let load = vec![0.0; motor.len()];
        Ok(Self {
            log: BacklashLog::new(period_s, motor, load, current)?,
        })
    }

    /// Time between samples, s.
    pub fn period_s(&self) -> f64 {
        self.log.period_s
    }

    /// Samples in the log, at least one.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.log.len()
    }

    /// Standard deviation of the quantisation error of the motor's position, rad.
    pub fn resolution_rad(&self) -> f64 {
        self.log.resolution_rad()
    }

    /// The same with a load that stands at zero, so that the position difference is the motor's
    /// position.
    pub(crate) fn as_backlash_log(&self) -> &BacklashLog {
        &self.log
    }
}

impl From<BacklashLog> for MotorLog {
    /// The motor's part of a log.
    fn from(mut log: BacklashLog) -> Self {
        log.load.fill(0.0);
        Self { log }
    }
}
