//! Traces as MCAP, the container of robotics tools (Foxglove, PlotJuggler): a message a row, as JSON
//! with its JSON Schema, on a topic of its own for every method (`contour/none`, `motors/lookup`).
//!
//! Times of messages are the `t_s` of their rows in nanoseconds from the start of the program.
//! Numbers are in full, not rounded to decimals; one that is not finite is null. Nothing is
//! compressed; chunks and their index let tools jump in the file without reading it.

use crate::csv::{ColumnKind, ContourWriter, MotorWriter, TableCells, TableColumn};
use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions, Writer};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, Write};

/// Bytes of a chunk. A choice: some thousand rows, so that a tool reads little around a time.
const CHUNK_BYTES: u64 = 1 << 20;
/// Nanoseconds of a second.
const NS_PER_S: f64 = 1e9;

/// Contour errors as MCAP.
///
/// ```
/// use lostmotion_report::csv::TraceRange;
/// use lostmotion_report::mcap::{ContourMessages, Topics};
///
/// let out = Topics::new(Vec::new(), "contour");
/// let bytes = ContourMessages::start(out, TraceRange::default())?.finish()?.out;
/// assert!(bytes.starts_with(b"\x89MCAP0\r\n") && bytes.ends_with(b"\x89MCAP0\r\n"));
/// # Ok::<(), std::io::Error>(())
/// ```
pub type ContourMessages<W> = ContourWriter<Messages<W>>;

/// Signals of motors as MCAP.
pub type MotorMessages<W> = MotorWriter<Messages<W>>;

/// What messages are written to.
#[derive(Clone, Debug)]
pub struct Topics<W> {
    /// The writer.
    pub out: W,
    /// First part of the topics' names, and name of the schema.
    pub name: &'static str,
}

impl<W> Topics<W> {
    /// Topics of this name in a writer.
    pub const fn new(out: W, name: &'static str) -> Topics<W> {
        Topics { out, name }
    }
}

/// A table whose rows are messages.
pub struct Messages<W: Write> {
    writer: Writer<NoSeek<W>>,
    name: &'static str,
    columns: Vec<TableColumn>,
    schema: u16,
    /// The channel of each method.
    channels: BTreeMap<String, u16>,
    /// The row as JSON, as far as it has come.
    row: Vec<u8>,
    method: String,
    time_ns: u64,
    /// Column of the next cell.
    next: usize,
    rows: u32,
}

impl<W: Write> fmt::Debug for Messages<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Messages")
            .field("name", &self.name)
            .field("rows", &self.rows)
            .finish_non_exhaustive()
    }
}

/// An error of the format as one of the writer, which it mostly is.
fn unwritten(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

/// Schema of the rows.
fn schema(name: &str, columns: &[TableColumn]) -> Value {
    let properties = columns.iter().map(|column| {
        let kind = match column.kind {
            ColumnKind::Text => "string",
            ColumnKind::Number => "number",
            ColumnKind::Integer => "integer",
        };
        (column.name.clone(), json!({ "type": kind }))
    });
    json!({
        "title": name,
        "type": "object",
        "properties": properties.collect::<serde_json::Map<_, _>>(),
    })
}

impl<W: Write> Messages<W> {
    /// Appends a cell with the name of its column.
    fn cell(&mut self, value: &Value) {
        let Some(column) = self.columns.get(self.next) else {
            return;
        };
        self.next += 1;
        let lead = if self.row.is_empty() { "{" } else { "," };
        // Into memory, where writing does not fail.
        let _ = write!(self.row, "{lead}{}:{value}", Value::from(&*column.name));
    }
}

impl<W: Write> TableCells for Messages<W> {
    type Out = Topics<W>;

    fn start(out: Topics<W>, columns: &[TableColumn]) -> io::Result<Messages<W>> {
        let Topics { out, name } = out;
        let mut writer = WriteOptions::new()
            .library(concat!("lostmotion ", env!("CARGO_PKG_VERSION")))
            .chunk_size(Some(CHUNK_BYTES))
            .disable_seeking(true)
            .create(NoSeek::new(out))
            .map_err(unwritten)?;
        let text = schema(name, columns).to_string();
        let schema = writer
            .add_schema(name, "jsonschema", text.as_bytes())
            .map_err(unwritten)?;
        Ok(Messages {
            writer,
            name,
            columns: columns.to_vec(),
            schema,
            channels: BTreeMap::new(),
            row: Vec::new(),
            method: String::new(),
            time_ns: 0,
            next: 0,
            rows: 0,
        })
    }

    fn text(&mut self, text: &str) {
        // The only text of a trace is its method.
        text.clone_into(&mut self.method);
        self.cell(&Value::from(text));
    }

    fn number(&mut self, value: f64, _decimals: usize) {
        if self
            .columns
            .get(self.next)
            .is_some_and(|column| column.name == "t_s")
        {
            // Saturates: no run begins before 0, nor lasts for centuries.
            self.time_ns = (value * NS_PER_S).round() as u64;
        }
        self.cell(&Value::from(value));
    }

    fn integer(&mut self, value: i64) {
        self.cell(&Value::from(value));
    }

    fn end(&mut self) -> io::Result<()> {
        self.row.push(b'}');
        let channel_id = match self.channels.get(&self.method) {
            Some(id) => *id,
            None => {
                let topic = format!("{}/{}", self.name, self.method);
                let id = self
                    .writer
                    .add_channel(self.schema, &topic, "json", &BTreeMap::new())
                    .map_err(unwritten)?;
                self.channels.insert(self.method.clone(), id);
                id
            }
        };
        let header = MessageHeader {
            channel_id,
            sequence: self.rows,
            log_time: self.time_ns,
            publish_time: self.time_ns,
        };
        let written = self.writer.write_to_known_channel(&header, &self.row);
        self.row.clear();
        self.next = 0;
        self.rows = self.rows.wrapping_add(1);
        written.map_err(unwritten)
    }

    fn finish(mut self) -> io::Result<Topics<W>> {
        // With the index, without which readers have to search the file.
        self.writer.finish().map_err(unwritten)?;
        let mut out = self.writer.into_inner().into_inner();
        out.flush()?;
        Ok(Topics::new(out, self.name))
    }
}
