//! Tables of motion: samples of a plan, signals of one axis; a row a tick.

use super::rows::{ColumnKind, POSITION_DECIMALS, RATE_DECIMALS, Rows, TableCells, TableColumn};
use lostmotion_base::{AxisId, AxisSet, Clock, Tick, units};
use lostmotion_drive::AxisSample;
use lostmotion_drive::config::AxisUnit;
use lostmotion_plan::Sample;
use std::io::{self, Write};

/// Writes the columns `t_s`, a position for each axis of the machine (`x_mm` ... `c_deg`), and
/// `line`, the source line.
#[derive(Debug)]
pub struct PlanWriter<T> {
    rows: T,
    axes: AxisSet,
    rotary: AxisSet,
    clock: Clock,
    /// 1 for positions alone, 3 with velocities and accelerations.
    derivatives: usize,
}

impl<W: Write> PlanWriter<Rows<W>> {
    /// Starts the table. `rotary` are the joints that turn; where these are not A, B and C (arms),
    /// columns are named `x_deg`, too. `clock` is the one that the samples' ticks count.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(
        out: W,
        axes: AxisSet,
        rotary: AxisSet,
        clock: Clock,
    ) -> io::Result<PlanWriter<Rows<W>>> {
        PlanWriter::start(out, axes, rotary, clock)
    }
}

impl<T: TableCells> PlanWriter<T> {
    /// The same in its form.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn start(
        out: T::Out,
        axes: AxisSet,
        rotary: AxisSet,
        clock: Clock,
    ) -> io::Result<PlanWriter<T>> {
        PlanWriter::begin(out, axes, rotary, clock, 1)
    }

    /// The same with the velocity (`x_velocity_mm_s`) and acceleration (`x_acceleration_mm_s2`) of
    /// each axis behind its position.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn start_with_rates(
        out: T::Out,
        axes: AxisSet,
        rotary: AxisSet,
        clock: Clock,
    ) -> io::Result<PlanWriter<T>> {
        PlanWriter::begin(out, axes, rotary, clock, 3)
    }

    fn begin(
        out: T::Out,
        axes: AxisSet,
        rotary: AxisSet,
        clock: Clock,
        derivatives: usize,
    ) -> io::Result<PlanWriter<T>> {
        let number = |name: String| TableColumn::new(name, ColumnKind::Number);
        let of_axis = |axis: AxisId| {
            // Arms have rotary joints named X or Y: the joint says its unit, not the letter.
            let unit = if rotary.contains(axis) { "deg" } else { "mm" };
            let letter = axis.letter().to_ascii_lowercase();
            let names = [
                format!("{letter}_{unit}"),
                format!("{letter}_velocity_{unit}_s"),
                format!("{letter}_acceleration_{unit}_s2"),
            ];
            names.into_iter().take(derivatives).map(number)
        };
        let mut columns = vec![number("t_s".to_owned())];
        columns.extend(axes.iter().flat_map(of_axis));
        columns.push(TableColumn::new("line", ColumnKind::Integer));
        Ok(PlanWriter {
            rows: T::start(out, &columns)?,
            axes,
            rotary,
            clock,
            derivatives,
        })
    }

    /// Appends rows.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn push(&mut self, samples: &[Sample]) -> io::Result<()> {
        for sample in samples {
            self.rows.seconds(sample.tick, self.clock.period_ns());
            for axis in self.axes.iter() {
                let cells = [
                    (sample.position[axis], POSITION_DECIMALS),
                    (sample.velocity[axis], RATE_DECIMALS),
                    (sample.acceleration[axis], RATE_DECIMALS),
                ];
                for (value, decimals) in cells.into_iter().take(self.derivatives) {
                    // The plan counts rotary joints in radians, the column is in deg.
                    let value = if self.rotary.contains(axis) {
                        units::deg(value)
                    } else {
                        value
                    };
                    self.rows.number(value, decimals);
                }
            }
            self.rows.integer(i64::from(sample.block.span.line));
            self.rows.end()?;
        }
        Ok(())
    }

    /// Writes what is left and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(self) -> io::Result<T::Out> {
        self.rows.finish()
    }
}

/// Writes an axis' trace in the axis' own unit `u` (`mm`, `deg`, `rad`), at the load.
///
/// Columns: `t_s`, `reference_<u>`, `reference_velocity_<u>_s`, `reference_acceleration_<u>_s2`,
/// `motor_<u>`, `motor_velocity_<u>_s`, `load_<u>`, `load_velocity_<u>_s`, `current_a`,
/// `torque_nm`, `engagement` (-1, 0, 1), `gap_estimate_<u>` (the compensator's theta_M - theta_L),
/// `inertia_estimate_kgm2` (motor side), `engagement_estimate`, `stiffness_estimate_nm_per_rad`,
/// `damping_estimate_nm_s_per_rad` (of the shaft, motor side; only where the axis estimates them),
/// `shaft_force_n` (`shaft_torque_nm` at a load that turns): what the shaft does to the load. Where
/// a method makes no estimate the cell is empty.
#[derive(Debug)]
pub struct AxisTraceWriter<T> {
    rows: T,
    clock: Clock,
    scales: AxisScales,
}

/// A sample of an axis as it is shown: positions and their rates in the axis' unit at the load,
/// current, torque and the estimates of inertia and shaft at the motor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AxisRow {
    /// Reference of the servo, its velocity per s and acceleration per s2.
    pub reference: f64,
    /// See [`Self::reference`].
    pub reference_velocity: f64,
    /// See [`Self::reference`].
    pub reference_acceleration: f64,
    /// Motor, and its velocity per s.
    pub motor: f64,
    /// See [`Self::motor`].
    pub motor_velocity: f64,
    /// Load, and its velocity per s.
    pub load: f64,
    /// See [`Self::load`].
    pub load_velocity: f64,
    /// Torque-forming current, A.
    pub current_a: f64,
    /// Torque of the motor, N m.
    pub torque_nm: f64,
    /// Flank in contact: -1, 0, 1.
    pub engagement: i8,
    /// The compensator's estimate of motor minus load; NaN without one, as those below.
    pub gap_estimate: f64,
    /// Its estimate of the inertia that the motor carries, kg m2.
    pub inertia_estimate_kgm2: f64,
    /// Its estimate of the flank in contact.
    pub engagement_estimate: i8,
    /// Its estimate of the shaft's stiffness, N m/rad.
    pub stiffness_estimate_nm_per_rad: f64,
    /// Its estimate of the shaft's damping, N m s/rad.
    pub damping_estimate_nm_s_per_rad: f64,
    /// What the shaft does to the load, N, or N m at a load that turns.
    pub shaft_force: f64,
}

/// How samples of an axis are shown in its unit.
#[derive(Clone, Copy, Debug)]
pub struct AxisScales {
    units_per_rad: f64,
    /// Force on the load, N or N m, for a torque of 1 N m at the motor.
    force_per_torque: f64,
}

impl AxisScales {
    /// `units_per_rad` is how far the load goes, in `unit`, for a radian of the motor.
    pub fn new(unit: AxisUnit, units_per_rad: f64) -> AxisScales {
        // Power is the same on both sides: a force is a torque over the way for a radian.
        let reach = match unit {
            AxisUnit::Mm => 1e-3 * units_per_rad,
            AxisUnit::Deg => units::rad(units_per_rad),
            AxisUnit::Rad => units_per_rad,
        };
        AxisScales {
            units_per_rad,
            force_per_torque: 1.0 / reach,
        }
    }

    /// A sample as it is shown.
    pub fn row(&self, sample: &AxisSample) -> AxisRow {
        let k = self.units_per_rad;
        AxisRow {
            reference: sample.reference.position * k,
            reference_velocity: sample.reference.velocity * k,
            reference_acceleration: sample.reference.acceleration * k,
            motor: sample.motor_position * k,
            motor_velocity: sample.motor_velocity * k,
            load: sample.load_position * k,
            load_velocity: sample.load_velocity * k,
            current_a: sample.current,
            torque_nm: sample.torque,
            engagement: sample.engagement.sign(),
            gap_estimate: sample.gap_angle_estimate * k,
            inertia_estimate_kgm2: sample.inertia_estimate,
            engagement_estimate: sample.engagement_estimate.sign(),
            stiffness_estimate_nm_per_rad: sample.stiffness_estimate,
            damping_estimate_nm_s_per_rad: sample.damping_estimate,
            shaft_force: sample.shaft_torque * self.force_per_torque,
        }
    }
}

impl<W: Write> AxisTraceWriter<Rows<W>> {
    /// Starts the table. `units_per_rad` is how far the load goes, in `unit`, for a radian of the
    /// motor.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(
        out: W,
        unit: AxisUnit,
        units_per_rad: f64,
        clock: Clock,
    ) -> io::Result<AxisTraceWriter<Rows<W>>> {
        AxisTraceWriter::start(out, unit, units_per_rad, clock)
    }
}

impl<T: TableCells> AxisTraceWriter<T> {
    /// The same in its form.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn start(
        out: T::Out,
        unit: AxisUnit,
        units_per_rad: f64,
        clock: Clock,
    ) -> io::Result<AxisTraceWriter<T>> {
        let u = unit.symbol();
        let force = match unit {
            AxisUnit::Mm => "shaft_force_n",
            AxisUnit::Deg | AxisUnit::Rad => "shaft_torque_nm",
        };
        // `push` fills the cells in this order.
        let header = [
            "t_s".to_owned(),
            format!("reference_{u}"),
            format!("reference_velocity_{u}_s"),
            format!("reference_acceleration_{u}_s2"),
            format!("motor_{u}"),
            format!("motor_velocity_{u}_s"),
            format!("load_{u}"),
            format!("load_velocity_{u}_s"),
            "current_a".to_owned(),
            "torque_nm".to_owned(),
            "engagement".to_owned(),
            format!("gap_estimate_{u}"),
            "inertia_estimate_kgm2".to_owned(),
            "engagement_estimate".to_owned(),
            "stiffness_estimate_nm_per_rad".to_owned(),
            "damping_estimate_nm_s_per_rad".to_owned(),
            force.to_owned(),
        ];
        // Which flank is in contact is -1, 0 or 1.
        let kind = |name: &str| {
            if name.starts_with("engagement") {
                ColumnKind::Integer
            } else {
                ColumnKind::Number
            }
        };
        let columns = header.map(|name| {
            let kind = kind(&name);
            TableColumn::new(name, kind)
        });
        Ok(AxisTraceWriter {
            rows: T::start(out, &columns)?,
            clock,
            scales: AxisScales::new(unit, units_per_rad),
        })
    }

    /// Appends the row of a tick.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn push(&mut self, tick: Tick, sample: &AxisSample) -> io::Result<()> {
        let row = self.scales.row(sample);
        let rows = &mut self.rows;
        rows.seconds(tick, self.clock.period_ns());
        for (value, decimals) in [
            (row.reference, POSITION_DECIMALS),
            (row.reference_velocity, RATE_DECIMALS),
            (row.reference_acceleration, RATE_DECIMALS),
            (row.motor, POSITION_DECIMALS),
            (row.motor_velocity, RATE_DECIMALS),
            (row.load, POSITION_DECIMALS),
            (row.load_velocity, RATE_DECIMALS),
            (row.current_a, RATE_DECIMALS),
            (row.torque_nm, RATE_DECIMALS),
        ] {
            rows.number(value, decimals);
        }
        rows.integer(row.engagement.into());
        rows.number(row.gap_estimate, POSITION_DECIMALS);
        // Inertias of 1e-3 kg m2 and less: decimals as for positions.
        rows.number(row.inertia_estimate_kgm2, POSITION_DECIMALS);
        rows.integer(row.engagement_estimate.into());
        rows.number(row.stiffness_estimate_nm_per_rad, RATE_DECIMALS);
        rows.number(row.damping_estimate_nm_s_per_rad, RATE_DECIMALS);
        rows.number(row.shaft_force, RATE_DECIMALS);
        rows.end()
    }

    /// Writes what is left and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(self) -> io::Result<T::Out> {
        self.rows.finish()
    }
}
