//! The log of one axis.

use lostmotion_drive::AxisSample;

use crate::{
    body::{LoadOff, Motion, load_off::Pair},
    error::FitError,
    even::EvenGrid,
    rounding::{rounding_step, smallest_step},
};

/// Motor position, load position and current of one axis, sampled together at a fixed period.
#[derive(Clone, Debug, PartialEq)]
pub struct BacklashLog {
    period_s: f64,
    motor: Vec<f64>,
    load: Vec<f64>,
    current: Vec<f64>,
    /// Samples that stand for rows that were lost, in order of time; empty for a whole log.
    lost: Vec<bool>,
    /// Smallest step that the motor's and the load's position makes, rad.
    steps_rad: [f64; 2],
    /// The same where the column certainly is read in steps, else zero.
    rounded_rad: [f64; 2],
    /// How the load was off the motor, where that was taken off.
    load_off: Option<LoadOff>,
    /// What fits found the load to be read later than the motor, and took off beside that, s.
    late_s: f64,
    /// How large a scale of the load may be that was not taken off, in parts of the travel.
    unseen_scale: f64,
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
        let steps_rad = [smallest_step(&motor), smallest_step(&load)];
        let rounded_rad = [rounding_step(&motor), rounding_step(&load)];
        Ok(Self {
            period_s,
            motor,
            load,
            current,
            lost: Vec::new(),
            steps_rad,
            rounded_rad,
            load_off: None,
            late_s: 0.0,
            unseen_scale: 0.0,
        })
    }

    /// A log from rows with their times in s, in order; columns as in [`BacklashLog::new`].
    ///
    /// Rows at uneven times are carried over to even ones: positions by a cubic through the four
    /// nearest rows, the current by a straight line. Where rows are missing the fit leaves out what
    /// would touch them.
    ///
    /// # Errors
    /// As [`BacklashLog::new`]; times that are not finite or not in order; a log with more
    /// missing than present rows.
    pub fn from_rows(
        time_s: &[f64],
        motor: Vec<f64>,
        load: Vec<f64>,
        current: Vec<f64>,
    ) -> Result<Self, FitError> {
        let grid = EvenGrid::new(time_s)?;
        if time_s.len() != motor.len() {
            return Err(FitError::LengthMismatch {
                motor: motor.len(),
                load: load.len(),
                current: current.len(),
            });
        }
        // Checked before anything is interpolated, so that a message names the row as logged.
        let logged = Self::new(grid.period_s, motor, load, current)?;
        if grid.even {
            return Ok(logged);
        }
        Ok(Self {
            motor: grid.cubic(time_s, &logged.motor),
            load: grid.cubic(time_s, &logged.load),
            current: grid.straight(time_s, &logged.current),
            lost: grid.lost,
            ..logged
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

    /// Whether any sample of a range stands for a row that was lost.
    pub(crate) fn touches_lost(&self, samples: std::ops::RangeInclusive<usize>) -> bool {
        self.lost
            .get(samples)
            .is_some_and(|range| range.contains(&true))
    }

    /// The motor and the load beside it.
    fn pair(&self) -> Pair<'_> {
        Pair {
            period_s: self.period_s,
            motor: &self.motor,
            load: &self.load,
            drive: &self.current,
            lost: &self.lost,
        }
    }

    /// The same with the load put right where its lengths or its clock are certainly not the motor's.
    pub(crate) fn put_right(&self) -> Self {
        let mut log = self.clone();
        let looked = self
            .pair()
            .put_right(&Motion::in_positions(&self.motor, self.period_s));
        log.unseen_scale = looked.unseen_scale;
        if let Some(right) = looked.right {
            (log.load, log.lost, log.load_off) = (right.load, right.lost, Some(right.off));
        }
        log
    }

    /// The same with a load that was read so much later than it is in this one, s.
    pub(crate) fn with_late_taken_off(&self, late_s: f64) -> Self {
        let (load, lost) = self.pair().without(&LoadOff {
            late_s,
            ..LoadOff::default()
        });
        Self {
            load,
            lost,
            late_s: self.late_s + late_s,
            ..self.clone()
        }
    }

    /// What fits found the load to be read later than the motor, and took off beside [`Self::load_off`], s.
    pub(crate) fn late_s(&self) -> f64 {
        self.late_s
    }

    /// How much later than the motor the load was read before anything was taken off, s.
    pub(crate) fn all_late_s(&self) -> f64 {
        self.late_s + self.load_off.map_or(0.0, |off| off.late_s)
    }

    /// How large a scale of the load may be that was not taken off, in parts of the travel.
    pub(crate) fn unseen_scale(&self) -> f64 {
        self.unseen_scale
    }

    /// How the load was off the motor; `None` where nothing was taken off.
    pub(crate) fn load_off(&self) -> Option<&LoadOff> {
        self.load_off.as_ref()
    }

    /// Share of the samples that stand for rows that were lost.
    pub(crate) fn lost_share(&self) -> f64 {
        self.lost.iter().filter(|lost| **lost).count() as f64 / self.len() as f64
    }

    /// Standard deviation of the quantisation error of `motor - load`, rad: each position error
    /// taken as uniform over the smallest step that its column makes. Nearly zero where positions
    /// are not quantised.
    pub fn resolution_rad(&self) -> f64 {
        let square: f64 = self.steps_rad.iter().map(|step| step * step / 12.0).sum();
        square.sqrt()
    }

    /// Steps that motor and load are read in, rad; zero where they are in none.
    pub(crate) fn rounded_rad(&self) -> [f64; 2] {
        self.rounded_rad
    }

    /// Smallest step that the motor's position makes, rad; zero where it stands.
    pub(crate) fn motor_step_rad(&self) -> f64 {
        self.steps_rad[0]
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

    /// A log from rows with their times in s, as [`BacklashLog::from_rows`].
    ///
    /// # Errors
    /// As [`BacklashLog::from_rows`].
    pub fn from_rows(time_s: &[f64], motor: Vec<f64>, current: Vec<f64>) -> Result<Self, FitError> {
        let load = vec![0.0; motor.len()];
        Ok(Self {
            log: BacklashLog::from_rows(time_s, motor, load, current)?,
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
        log.steps_rad[1] = 0.0;
        Self { log }
    }
}
