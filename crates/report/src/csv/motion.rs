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
    units_per_rad: f64,
    /// Force on the load, N or N m, for a torque of 1 N m at the motor.
    force_per_torque: f64,
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
        // Power is the same on both sides: a force is a torque over the way for a radian.
        let (force, reach) = match unit {
            AxisUnit::Mm => ("shaft_force_n", 1e-3 * units_per_rad),
            AxisUnit::Deg => ("shaft_torque_nm", units::rad(units_per_rad)),
            AxisUnit::Rad => ("shaft_torque_nm", units_per_rad),
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
            units_per_rad,
            force_per_torque: 1.0 / reach,
        })
    }

    /// Appends the row of a tick.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn push(&mut self, tick: Tick, sample: &AxisSample) -> io::Result<()> {
        // Positions and their rates come in radians of the motor and are shown in the axis' unit at
        // the load; current, torque and the estimates of inertia and shaft stay at the motor.
        let (rows, k) = (&mut self.rows, self.units_per_rad);
        rows.seconds(tick, self.clock.period_ns());
        rows.number(sample.reference.position * k, POSITION_DECIMALS);
        rows.number(sample.reference.velocity * k, RATE_DECIMALS);
        rows.number(sample.reference.acceleration * k, RATE_DECIMALS);
        rows.number(sample.motor_position * k, POSITION_DECIMALS);
        rows.number(sample.motor_velocity * k, RATE_DECIMALS);
        rows.number(sample.load_position * k, POSITION_DECIMALS);
        rows.number(sample.load_velocity * k, RATE_DECIMALS);
        rows.number(sample.current, RATE_DECIMALS);
        rows.number(sample.torque, RATE_DECIMALS);
        rows.integer(sample.engagement.sign().into());
        rows.number(sample.gap_angle_estimate * k, POSITION_DECIMALS);
        // Inertias of 1e-3 kg m2 and less: decimals as for positions.
        rows.number(sample.inertia_estimate, POSITION_DECIMALS);
        rows.integer(sample.engagement_estimate.sign().into());
        rows.number(sample.stiffness_estimate, RATE_DECIMALS);
        rows.number(sample.damping_estimate, RATE_DECIMALS);
        rows.number(sample.shaft_torque * self.force_per_torque, RATE_DECIMALS);
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
