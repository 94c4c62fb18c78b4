//! Traces as Apache Parquet: the columns of the CSV form, typed and column by column, for pandas,
//! Polars, DuckDB, Spark and the like.
//!
//! Numbers are `DOUBLE` and in full, not rounded to decimals; whole numbers are `INT64`, texts
//! `STRING`. A number that is not finite is null. Rows are grouped so that memory does not grow with
//! the run; nothing is compressed.

use crate::csv::{ColumnKind, ContourWriter, MotorWriter, TableCells, TableColumn};
use parquet::basic::{ConvertedType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::SerializedFileWriter;
use parquet::schema::types::Type;
use std::fmt;
use std::io::{self, Write};
use std::sync::Arc;

/// Rows of a group. A choice: some 10 MB of a wide table, and few groups in an hour.
const GROUP_ROWS: usize = 1 << 16;

/// Contour errors as Parquet.
///
/// ```
/// use lostmotion_report::csv::TraceRange;
/// use lostmotion_report::parquet::ContourTable;
///
/// let table = ContourTable::start(Vec::new(), TraceRange::default())?;
/// let bytes = table.finish()?;
/// assert!(bytes.starts_with(b"PAR1") && bytes.ends_with(b"PAR1"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub type ContourTable<W> = ContourWriter<Columns<W>>;

/// Signals of motors as Parquet.
pub type MotorTable<W> = MotorWriter<Columns<W>>;

/// What waits for its group to be full.
enum Waiting {
    Text(Vec<ByteArray>),
    /// Values, and for every row whether it has one.
    Number(Vec<f64>, Vec<i16>),
    Integer(Vec<i64>),
}

/// A table in columns.
pub struct Columns<W: Write + Send> {
    writer: SerializedFileWriter<W>,
    waiting: Vec<Waiting>,
    /// TableColumn of the next cell.
    next: usize,
    rows: usize,
}

impl<W: Write + Send> fmt::Debug for Columns<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Columns")
            .field("rows", &self.rows)
            .finish_non_exhaustive()
    }
}

/// An error of the format as one of the writer, which it mostly is.
fn unwritten(error: ParquetError) -> io::Error {
    match error {
        ParquetError::External(inner) => match inner.downcast::<io::Error>() {
            Ok(error) => *error,
            Err(inner) => io::Error::other(inner),
        },
        other => io::Error::other(other),
    }
}

fn field(column: &TableColumn) -> Result<Arc<Type>, ParquetError> {
    let (physical, converted, repetition) = match column.kind {
        ColumnKind::Text => (
            Physical::BYTE_ARRAY,
            ConvertedType::UTF8,
            Repetition::REQUIRED,
        ),
        ColumnKind::Number => (Physical::DOUBLE, ConvertedType::NONE, Repetition::OPTIONAL),
        ColumnKind::Integer => (Physical::INT64, ConvertedType::NONE, Repetition::REQUIRED),
    };
    let field = Type::primitive_type_builder(&column.name, physical)
        .with_converted_type(converted)
        .with_repetition(repetition)
        .build()?;
    Ok(Arc::new(field))
}

impl<W: Write + Send> Columns<W> {
    /// Writes the rows that wait as a group.
    fn flush(&mut self) -> io::Result<()> {
        if self.rows == 0 {
            return Ok(());
        }
        self.rows = 0;
        let mut group = self.writer.next_row_group().map_err(unwritten)?;
        for waiting in &mut self.waiting {
            let Some(mut column) = group.next_column().map_err(unwritten)? else {
                break;
            };
            let written = match waiting {
                Waiting::Text(values) => {
                    let written = column
                        .typed::<ByteArrayType>()
                        .write_batch(values, None, None);
                    values.clear();
                    written
                }
                Waiting::Number(values, there) => {
                    let typed = column.typed::<DoubleType>();
                    let written = typed.write_batch(values, Some(there), None);
                    values.clear();
                    there.clear();
                    written
                }
                Waiting::Integer(values) => {
                    let written = column.typed::<Int64Type>().write_batch(values, None, None);
                    values.clear();
                    written
                }
            };
            written.map_err(unwritten)?;
            column.close().map_err(unwritten)?;
        }
        group.close().map_err(unwritten)?;
        Ok(())
    }

    fn cell(&mut self) -> Option<&mut Waiting> {
        self.next += 1;
        self.waiting.get_mut(self.next - 1)
    }
}

impl<W: Write + Send> TableCells for Columns<W> {
    type Out = W;

    fn start(out: W, columns: &[TableColumn]) -> io::Result<Columns<W>> {
        let fields: Result<Vec<_>, _> = columns.iter().map(field).collect();
        let schema = fields.and_then(|fields| {
            Type::group_type_builder("trace")
                .with_fields(fields)
                .build()
        });
        let schema = Arc::new(schema.map_err(unwritten)?);
        let by = concat!("lostmotion ", env!("CARGO_PKG_VERSION"));
        let properties = WriterProperties::builder()
            .set_created_by(by.to_owned())
            .build();
        let writer = SerializedFileWriter::new(out, schema, Arc::new(properties));
        let waiting = columns.iter().map(|column| match column.kind {
            ColumnKind::Text => Waiting::Text(Vec::new()),
            ColumnKind::Number => Waiting::Number(Vec::new(), Vec::new()),
            ColumnKind::Integer => Waiting::Integer(Vec::new()),
        });
        Ok(Columns {
            writer: writer.map_err(unwritten)?,
            waiting: waiting.collect(),
            next: 0,
            rows: 0,
        })
    }

    fn text(&mut self, text: &str) {
        if let Some(Waiting::Text(values)) = self.cell() {
            values.push(ByteArray::from(text));
        }
    }

    fn number(&mut self, value: f64, _decimals: usize) {
        if let Some(Waiting::Number(values, there)) = self.cell() {
            let is_there = value.is_finite();
            there.push(i16::from(is_there));
            if is_there {
                values.push(value);
            }
        }
    }

    fn integer(&mut self, value: i64) {
        if let Some(Waiting::Integer(values)) = self.cell() {
            values.push(value);
        }
    }

    fn end(&mut self) -> io::Result<()> {
        self.next = 0;
        self.rows += 1;
        if self.rows >= GROUP_ROWS {
            self.flush()?;
        }
        Ok(())
    }

    fn finish(mut self) -> io::Result<W> {
        self.flush()?;
        // With the footer, without which no reader takes the file.
        let mut out = self.writer.into_inner().map_err(unwritten)?;
        out.flush()?;
        Ok(out)
    }
}
