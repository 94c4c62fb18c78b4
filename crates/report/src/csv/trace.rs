//! Traces: what is known of a run at servo ticks.

use super::rows::{ColumnKind, ERROR_DECIMALS, Rows, TableCells, TableColumn, columns};
use lostmotion_sim::{ContourPoint, MotorPoint};
use std::io::{self, Write};

/// Places of the tool, mm, and unit vectors: to a nanometre.
const PLACE_DECIMALS: usize = 6;
/// Positions of motors and loads, mm, deg or rad: below the step of any encoder.
const MOTOR_DECIMALS: usize = 9;
/// Currents, A, and torques, N m: below the noise of any drive.
const LOAD_DECIMALS: usize = 6;

/// Which servo ticks of a trace are written.
///
/// Of `every` ticks those with the peaks are, so that no peak of any signal is lost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TraceRange {
    /// From this time on, s.
    pub from_s: f64,
    /// Up to this time, s.
    pub to_s: f64,
    /// Ticks of a group; 1 writes each, 0 counts as 1.
    pub every: u64,
}

impl Default for TraceRange {
    fn default() -> TraceRange {
        TraceRange {
            from_s: 0.0,
            to_s: f64::INFINITY,
            every: 1,
        }
    }
}

impl TraceRange {
    fn contains(&self, time_s: f64) -> bool {
        (self.from_s..=self.to_s).contains(&time_s)
    }
}

/// The peaks of a group of ticks, by several sizes.
#[derive(Clone, Debug)]
struct Peaks<T> {
    seen: u64,
    /// For each size: its largest value, the place in the group, and the tick itself.
    largest: Vec<Option<(f64, u64, T)>>,
}

impl<T: Clone> Peaks<T> {
    const fn new() -> Peaks<T> {
        Peaks {
            seen: 0,
            largest: Vec::new(),
        }
    }

    fn push(&mut self, sizes: &[f64], tick: &T) {
        self.largest.resize(sizes.len(), None);
        for (largest, size) in self.largest.iter_mut().zip(sizes) {
            // Of equal ones the first; a size that is not a number gives way to any that is.
            if largest
                .as_ref()
                .is_none_or(|(most, ..)| *size > *most || most.is_nan())
            {
                *largest = Some((*size, self.seen, tick.clone()));
            }
        }
        self.seen += 1;
    }

    /// The peaks in the order of their times, once each; the next group begins.
    fn take(&mut self) -> impl Iterator<Item = T> + use<T> {
        let mut peaks: Vec<(u64, T)> = self
            .largest
            .iter_mut()
            .filter_map(Option::take)
            .map(|(_, place, tick)| (place, tick))
            .collect();
        self.seen = 0;
        peaks.sort_by_key(|(place, _)| *place);
        peaks.dedup_by_key(|(place, _)| *place);
        peaks.into_iter().map(|(_, tick)| tick)
    }
}

/// The ticks of several methods, each thinned out for itself.
#[derive(Clone, Debug)]
struct Thinned<T> {
    range: TraceRange,
    methods: Vec<(String, Peaks<T>)>,
}

impl<T: Clone> Thinned<T> {
    const fn new(range: TraceRange) -> Thinned<T> {
        Thinned {
            range,
            methods: Vec::new(),
        }
    }

    /// Adds a tick; the peaks of its group if it ends one.
    fn push(
        &mut self,
        method: &str,
        sizes: &[f64],
        tick: &T,
    ) -> Option<impl Iterator<Item = T> + use<T>> {
        let known = self.methods.iter().position(|(name, _)| name == method);
        let index = known.unwrap_or_else(|| {
            self.methods.push((method.to_owned(), Peaks::new()));
            self.methods.len() - 1
        });
        let (_, peaks) = self.methods.get_mut(index)?;
        peaks.push(sizes, tick);
        (peaks.seen >= self.range.every.max(1)).then(|| peaks.take())
    }

    /// The peaks of all groups that are not full.
    fn rest(&mut self) -> Vec<(String, T)> {
        let mut rest = Vec::new();
        for (name, peaks) in &mut self.methods {
            rest.extend(peaks.take().map(|tick| (name.clone(), tick)));
        }
        rest
    }
}

/// Columns of [`ContourWriter`].
fn contour_columns() -> Vec<TableColumn> {
    use ColumnKind::{Integer, Number, Text};
    columns([
        ("method", Text),
        ("t_s", Number),
        ("foot_x_mm", Number),
        ("foot_y_mm", Number),
        ("foot_z_mm", Number),
        ("normal_x", Number),
        ("normal_y", Number),
        ("normal_z", Number),
        ("error_um", Number),
        ("backlash_um", Number),
        ("rapid", Integer),
        ("file", Integer),
        ("line", Integer),
        ("commanded_x_mm", Number),
        ("commanded_y_mm", Number),
        ("commanded_z_mm", Number),
        ("tool_x_mm", Number),
        ("tool_y_mm", Number),
        ("tool_z_mm", Number),
        ("moving", Integer),
    ])
}

/// Writes the fields of [`ContourPoint`] with the method's name before them. Peaks of a group are
/// those of the error and of what backlash adds to it.
#[derive(Debug)]
pub struct ContourWriter<T> {
    rows: T,
    thinned: Thinned<ContourPoint>,
}

impl<W: Write> ContourWriter<Rows<W>> {
    /// Starts the table.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn new(out: W, range: TraceRange) -> io::Result<ContourWriter<Rows<W>>> {
        ContourWriter::start(out, range)
    }
}

impl<T: TableCells> ContourWriter<T> {
    /// Starts the table in its form.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn start(out: T::Out, range: TraceRange) -> io::Result<ContourWriter<T>> {
        Ok(ContourWriter {
            rows: T::start(out, &contour_columns())?,
            thinned: Thinned::new(range),
        })
    }

    /// Appends rows.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn push(&mut self, method: &str, points: &[ContourPoint]) -> io::Result<()> {
        let range = self.thinned.range;
        for point in points.iter().filter(|point| range.contains(point.time_s)) {
            let sizes = [point.error_um.abs(), point.backlash_um.abs()];
            for point in self
                .thinned
                .push(method, &sizes, point)
                .into_iter()
                .flatten()
            {
                contour_row(&mut self.rows, method, &point)?;
            }
        }
        Ok(())
    }

    /// Writes what is left and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(mut self) -> io::Result<T::Out> {
        for (method, point) in self.thinned.rest() {
            contour_row(&mut self.rows, &method, &point)?;
        }
        self.rows.finish()
    }
}

fn contour_row(rows: &mut impl TableCells, method: &str, point: &ContourPoint) -> io::Result<()> {
    rows.text(method);
    rows.number(point.time_s, 6);
    for coordinate in point.foot_mm {
        rows.number(coordinate, PLACE_DECIMALS);
    }
    // The error counts positive along this normal.
    for component in point.normal {
        rows.number(component, PLACE_DECIMALS);
    }
    rows.number(point.error_um, ERROR_DECIMALS);
    rows.number(point.backlash_um, ERROR_DECIMALS);
    // Rapids are in the table, too: sums over cutting moves leave them out by this column.
    rows.integer(i64::from(point.rapid));
    rows.integer(i64::from(point.block.span.file));
    rows.integer(i64::from(point.block.span.line));
    // Where the tool should be and where it is: the foot point and the error along the normal do
    // not tell in space, nor at a corner.
    for coordinate in point.commanded_mm.into_iter().chain(point.actual_mm) {
        rows.number(coordinate, PLACE_DECIMALS);
    }
    rows.integer(i64::from(point.moving));
    rows.end()
}

/// Writes the signals of all motors: `method`, `t_s`, and for each motor, named by its axis in lower
/// case (`y2` is the second motor of a gantry's Y), `x_reference_<u>`, `x_motor_<u>`, `x_load_<u>`,
/// `x_current_a`, `x_torque_nm`, `x_engagement` (-1, 0, 1). Peaks of a group are, for
/// each motor, those of the following error of motor and of load, and of the current (and so torque).
pub struct MotorWriter<T: TableCells> {
    /// Until the first tick tells which motors there are.
    out: Option<T::Out>,
    rows: Option<T>,
    thinned: Thinned<Vec<MotorPoint>>,
    /// Of each motor of a tick: following errors of motor and load, current.
    sizes: Vec<f64>,
}

impl<W: Write> MotorWriter<Rows<W>> {
    /// A table whose columns are made with its first row.
    pub const fn new(out: W, range: TraceRange) -> MotorWriter<Rows<W>> {
        MotorWriter::start(out, range)
    }
}

impl<T: TableCells> MotorWriter<T> {
    /// The same in its form.
    pub const fn start(out: T::Out, range: TraceRange) -> MotorWriter<T> {
        MotorWriter {
            out: Some(out),
            rows: None,
            thinned: Thinned::new(range),
            sizes: Vec::new(),
        }
    }

    /// Appends rows: `points` has all motors of a tick, then all of the next.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn push(&mut self, method: &str, points: &[MotorPoint]) -> io::Result<()> {
        // Points of a tick share their time.
        for tick in points.chunk_by(|a, b| a.time_s.to_bits() == b.time_s.to_bits()) {
            self.head(tick)?;
            if !tick
                .iter()
                .any(|point| self.thinned.range.contains(point.time_s))
            {
                continue;
            }
            self.sizes.clear();
            self.sizes.extend(tick.iter().flat_map(|point| {
                [
                    (point.reference - point.motor).abs(),
                    (point.reference - point.load).abs(),
                    point.current_a.abs(),
                ]
            }));
            let peaks = self.thinned.push(method, &self.sizes, &tick.to_vec());
            for tick in peaks.into_iter().flatten() {
                motor_row(self.rows.as_mut(), method, &tick)?;
            }
        }
        Ok(())
    }

    /// Writes the header, by the motors of the first tick.
    fn head(&mut self, tick: &[MotorPoint]) -> io::Result<()> {
        let Some(out) = self.out.take() else {
            return Ok(());
        };
        let mut columns = first_columns();
        for point in tick {
            let motor = format!(
                "{}{}",
                point.axis.to_string().to_lowercase(),
                if point.second { "2" } else { "" }
            );
            let unit = point.unit.symbol();
            let number = |name| TableColumn::new(name, ColumnKind::Number);
            let positions = ["reference", "motor", "load"];
            columns.extend(positions.map(|what| number(format!("{motor}_{what}_{unit}"))));
            columns
                .extend(["current_a", "torque_nm"].map(|what| number(format!("{motor}_{what}"))));
            columns.push(TableColumn::new(
                format!("{motor}_engagement"),
                ColumnKind::Integer,
            ));
        }
        self.rows = Some(T::start(out, &columns)?);
        Ok(())
    }

    /// Writes what is left and gives the writer back.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(mut self) -> io::Result<T::Out> {
        for (method, tick) in self.thinned.rest() {
            motor_row(self.rows.as_mut(), &method, &tick)?;
        }
        match (self.rows, self.out) {
            (Some(rows), _) => rows.finish(),
            // No tick: a table without motors.
            (None, Some(out)) => T::start(out, &first_columns())?.finish(),
            (None, None) => Err(io::Error::other("the table was not started")),
        }
    }
}

/// Columns before those of motors.
fn first_columns() -> Vec<TableColumn> {
    vec![
        TableColumn::new("method", ColumnKind::Text),
        TableColumn::new("t_s", ColumnKind::Number),
    ]
}

fn motor_row(
    rows: Option<&mut impl TableCells>,
    method: &str,
    tick: &[MotorPoint],
) -> io::Result<()> {
    let (Some(rows), Some(first)) = (rows, tick.first()) else {
        return Ok(());
    };
    rows.text(method);
    rows.number(first.time_s, 6);
    for point in tick {
        for position in [point.reference, point.motor, point.load] {
            rows.number(position, MOTOR_DECIMALS);
        }
        rows.number(point.current_a, LOAD_DECIMALS);
        rows.number(point.torque_nm, LOAD_DECIMALS);
        rows.integer(point.engagement.sign().into());
    }
    rows.end()
}
