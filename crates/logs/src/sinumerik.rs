//! Trace sessions of Sinumerik Operate, XML: each record lists the signals that changed.

use crate::error::LogError;
use crate::source::{Channel, Format, Header, MAX_CHANNELS, Row, Source};
use crate::unit::Unit;
use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use std::collections::{BTreeMap, VecDeque};
use std::io::{BufRead, Read};

/// Longest element that is read, bytes. A choice: a record of a thousand signals has some 20 kB.
const MAX_ELEMENT_BYTES: usize = 1 << 20;
/// How near a time lies to a multiple of an interval that it belongs to, in intervals: times are
/// written to the microsecond. A choice.
const ON_CLOCK_SHARE: f64 = 0.01;
/// Most rows that are filled in for times without a record. A choice: an hour at 1 kHz.
const MAX_HELD: f64 = 4e6;

/// Counts lines, and ends an element that does not end.
struct Counted<R> {
    input: R,
    lines: u64,
    left: usize,
}

impl<R: BufRead> Read for Counted<R> {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

impl<R: BufRead> BufRead for Counted<R> {
    fn fill_buf(&mut self) -> std::io::Result<&[u8]> {
        if self.left == 0 {
            let what = format!("an element has more than {MAX_ELEMENT_BYTES} bytes");
            return Err(std::io::Error::new(std::io::ErrorKind::InvalidData, what));
        }
        let left = self.left;
        let chunk = self.input.fill_buf()?;
        Ok(chunk.get(..left.min(chunk.len())).unwrap_or_default())
    }

    fn consume(&mut self, count: usize) {
        if count == 0 {
            return;
        }
        self.left -= count.min(self.left);
        if let Ok(chunk) = self.input.fill_buf() {
            let chunk = chunk.get(..count).unwrap_or_default();
            self.lines += memchr::memchr_iter(b'\n', chunk).count() as u64;
        }
        self.input.consume(count);
    }
}

/// A signal of a frame.
struct Signal {
    id: String,
    name: String,
    units_type: String,
    interval_s: f64,
    points: Option<u64>,
}

struct Trace<R> {
    name: String,
    reader: Reader<Counted<R>>,
    buffer: Vec<u8>,
    /// Place of each id among the signals.
    ids: BTreeMap<String, usize>,
    names: Vec<String>,
    /// Values as of the last record; NaN before a signal's first.
    values: Vec<f64>,
    /// Signals of each group, and the group's interval.
    groups: Vec<(f64, Vec<usize>)>,
    wanted: Vec<bool>,
    /// Records that were read before their rows were asked for.
    ready: VecDeque<Row>,
    /// Time of the last record of the frame, and how often the fastest clock has ticked.
    last_s: Option<f64>,
    lost: bool,
    part: u32,
    held: u64,
    unknown: u64,
    remarks: Vec<String>,
    ended: bool,
}

/// What the header of the file tells.
#[derive(Default)]
struct Setup {
    /// Kind of unit by key of the signal.
    units: BTreeMap<String, String>,
    signals: Vec<Signal>,
    drop_outs: bool,
    said: Vec<String>,
}

pub(crate) fn open<'a, R: BufRead + 'a>(
    input: R,
    name: &str,
) -> Result<(Header, Box<dyn Source + 'a>), LogError> {
    let counted = Counted {
        input,
        lines: 1,
        left: MAX_ELEMENT_BYTES,
    };
    let mut trace = Trace {
        name: name.to_owned(),
        reader: Reader::from_reader(counted),
        buffer: Vec::new(),
        ids: BTreeMap::new(),
        names: Vec::new(),
        values: Vec::new(),
        groups: Vec::new(),
        wanted: Vec::new(),
        ready: VecDeque::new(),
        last_s: None,
        lost: false,
        part: 0,
        held: 0,
        unknown: 0,
        remarks: Vec::new(),
        ended: false,
    };
    let mut setup = Setup::default();
    let first = loop {
        match trace.next_element()? {
            Some(Element::Signal(attributes)) => {
                if let (Some(key), Some(unit)) =
                    (attributes.get("key"), attributes.get("unitsType"))
                {
                    let before = setup.units.insert(key.clone(), unit.clone());
                    if setup.units.len() > MAX_CHANNELS {
                        return Err(trace.at("there are too many signals"));
                    }
                    // The setup stands in the file twice, once for older controls.
                    if before.is_some_and(|before| before != *unit) {
                        setup
                            .said
                            .push(format!("the setups disagree about the unit of `{key}`"));
                    }
                }
            }
            Some(Element::Frame(attributes)) => {
                setup.signals.clear();
                setup.drop_outs = attributes.get("dropOuts").is_some_and(|count| count != "0");
            }
            Some(Element::DataSignal(attributes)) => {
                let signal = trace.data_signal(&attributes, &mut setup)?;
                setup.signals.push(signal);
                if setup.signals.len() > MAX_CHANNELS {
                    return Err(trace.at("there are too many signals"));
                }
            }
            Some(Element::Record(record)) => break record,
            None => {
                let (what, hint) = (
                    "there are no records",
                    "the session holds a setup alone: save it with its data",
                );
                return Err(LogError::file(name, what, hint));
            }
        }
    };
    let header = trace.begin(setup)?;
    trace.record(&first)?;
    Ok((header, Box::new(trace)))
}

type Attributes = BTreeMap<String, String>;

/// The elements that matter.
enum Element {
    Signal(Attributes),
    Frame(Attributes),
    DataSignal(Attributes),
    Record(Vec<(String, String)>),
}

impl<R: BufRead> Trace<R> {
    fn line(&self) -> u64 {
        self.reader.get_ref().lines
    }

    fn at(&self, what: impl Into<String>) -> LogError {
        LogError::line(&self.name, self.line(), what, "")
    }

    /// Reads up to the next element that matters; `None` at the end of the file.
    fn next_element(&mut self) -> Result<Option<Element>, LogError> {
        loop {
            self.buffer.clear();
            self.reader.get_mut().left = MAX_ELEMENT_BYTES;
            let event = match self.reader.read_event_into(&mut self.buffer) {
                Ok(event) => event,
                Err(quick_xml::Error::Io(source))
                    if source.kind() != std::io::ErrorKind::InvalidData =>
                {
                    return Err(LogError::Io {
                        name: self.name.clone(),
                        source: std::io::Error::new(source.kind(), source.to_string()),
                    });
                }
                Err(error) => {
                    let what = format!("the XML is broken: {error}");
                    return Err(LogError::line(
                        &self.name,
                        self.reader.get_ref().lines,
                        what,
                        "the file may be cut",
                    ));
                }
            };
            let element = match &event {
                Event::Start(element) | Event::Empty(element) => element,
                Event::Eof => return Ok(None),
                _ => continue,
            };
            let wanted = match element.local_name().as_ref() {
                b"signal" => Element::Signal as fn(Attributes) -> Element,
                b"frameHeader" => Element::Frame,
                b"dataSignal" => Element::DataSignal,
                b"rec" => {
                    return match attributes(element) {
                        Some(list) => Ok(Some(Element::Record(list))),
                        None => Err(self.at("a record's attributes cannot be read")),
                    };
                }
                _ => continue,
            };
            return match attributes(element) {
                Some(list) => Ok(Some(wanted(list.into_iter().collect()))),
                None => Err(self.at("an element's attributes cannot be read")),
            };
        }
    }

    fn data_signal(&self, attributes: &Attributes, setup: &mut Setup) -> Result<Signal, LogError> {
        let get = |key: &str| attributes.get(key).map_or("", String::as_str);
        let (id, key) = (get("id"), get("key"));
        if id.is_empty() {
            return Err(self.at("a signal has no `id`"));
        }
        let interval_s: f64 = get("interval").parse().unwrap_or(f64::NAN);
        if !(interval_s.is_finite() && interval_s > 0.0) {
            let what = format!(
                "the interval `{}` of signal {id} is not a positive number",
                get("interval")
            );
            return Err(self.at(what));
        }
        let stated = get("unitsType").to_owned();
        // What the setup says of a signal is right where the frame says something else.
        let units_type = match setup.units.get(key) {
            Some(unit) if *unit != stated => {
                setup.said.push(format!(
                    "signal {id} has the unit `{stated}`, but `{unit}` in the setup, which is taken"
                ));
                unit.clone()
            }
            _ => stated,
        };
        Ok(Signal {
            id: id.to_owned(),
            name: get("name").to_owned(),
            units_type,
            interval_s,
            points: attributes
                .get("datapointCount")
                .and_then(|count| count.parse().ok()),
        })
    }

    /// Takes the signals of the first frame.
    fn begin(&mut self, setup: Setup) -> Result<Header, LogError> {
        let mut said = setup.said;
        let mut intervals: Vec<f64> = Vec::new();
        let (mut channels, mut positions) = (Vec::new(), false);
        let mut signals: Vec<Signal> = Vec::new();
        for signal in setup.signals {
            if signal.points == Some(0) {
                said.push(format!(
                    "signal {} has no points and is left out",
                    signal.id
                ));
            } else {
                signals.push(signal);
            }
        }
        if signals.is_empty() {
            return Err(self.at("a record stands before its signals"));
        }
        signals.sort_by(|a, b| a.interval_s.total_cmp(&b.interval_s));
        for signal in signals {
            if intervals.last() != Some(&signal.interval_s) {
                intervals.push(signal.interval_s);
                self.groups.push((signal.interval_s, Vec::new()));
            }
            let place = channels.len();
            if let Some((_, members)) = self.groups.last_mut() {
                members.push(place);
            }
            positions |= signal.units_type == "posn";
            channels.push(Channel {
                name: signal.name.clone(),
                unit: unit_of(&signal.units_type),
                group: intervals.len() - 1,
            });
            self.names.push(signal.name);
            if self.ids.insert(signal.id.clone(), place).is_some() {
                return Err(self.at(format!("two signals have the id {}", signal.id)));
            }
        }
        if positions {
            said.push("units are not in the file: positions are taken for mm, speeds for mm/min, currents for A, torques for Nm".to_owned());
        }
        if setup.drop_outs {
            said.push("the trace lost records: times without one are not filled in".to_owned());
        }
        self.lost = setup.drop_outs;
        self.values = vec![f64::NAN; channels.len()];
        self.wanted = vec![true; channels.len()];
        Ok(Header {
            columns: None,
            format: Format::SinumerikTrace,
            groups: self.groups.len(),
            channels,
            said,
            guessed_time: None,
        })
    }

    /// Takes a record over into rows.
    fn record(&mut self, record: &[(String, String)]) -> Result<(), LogError> {
        let line = self.line();
        let time = record.iter().find(|(id, _)| id == "time");
        let text = time.map_or("", |(_, value)| value.as_str());
        let time_s = crate::text::number(text, '.')
            .ok_or_else(|| LogError::cell(&self.name, line, "time", text, "is not a time", ""))?;
        if let Some(last_s) = self.last_s {
            if time_s <= last_s {
                let what = format!(
                    "the time {time_s} s is not after {last_s} s, that of the record before"
                );
                return Err(self.at(what));
            }
            // Nothing changed between: what is known is given at every tick of the clocks.
            if !self.lost {
                self.fill(last_s, time_s, line)?;
            }
        }
        for (id, text) in record.iter().filter(|(id, _)| id != "time") {
            let Some(&place) = self.ids.get(id) else {
                self.unknown += 1;
                continue;
            };
            let value = crate::text::number(text, '.');
            let value = match value {
                Some(value) => value,
                None if self.wanted.get(place) == Some(&false) => f64::NAN,
                None => {
                    let name = self.names.get(place).map_or("", String::as_str);
                    let (what, hint) = crate::text::no_number(text, '.');
                    return Err(LogError::cell(&self.name, line, name, text, what, hint));
                }
            };
            if let Some(known) = self.values.get_mut(place) {
                *known = value;
            }
        }
        self.last_s = Some(time_s);
        self.tick(time_s, line);
        Ok(())
    }

    /// Rows for times between two records, at which nothing changed.
    fn fill(&mut self, last_s: f64, time_s: f64, line: u64) -> Result<(), LogError> {
        let Some(&(interval_s, _)) = self.groups.first() else {
            return Ok(());
        };
        let missing = ((time_s - last_s) / interval_s).round() - 1.0;
        if missing > MAX_HELD {
            let what = format!("{missing} intervals lie between this record and the one before");
            return Err(self.at(what));
        }
        for step in 1..=missing.max(0.0) as u64 {
            self.held += 1;
            self.tick(last_s + step as f64 * interval_s, line);
        }
        Ok(())
    }

    /// A row of each group whose clock ticks at this time.
    fn tick(&mut self, time_s: f64, line: u64) {
        for (group, (interval_s, members)) in self.groups.iter().enumerate() {
            let ticks = time_s / interval_s;
            if group > 0 && (ticks - ticks.round()).abs() > ON_CLOCK_SHARE {
                continue;
            }
            let values: Vec<f64> = members
                .iter()
                .map(|&place| self.values.get(place).copied().unwrap_or(f64::NAN))
                .collect();
            // Before its first record a signal has no value.
            let known = members
                .iter()
                .zip(&values)
                .all(|(&place, value)| !value.is_nan() || self.wanted.get(place) == Some(&false));
            if known {
                self.ready.push_back(Row {
                    line,
                    time_s,
                    group,
                    part: self.part,
                    values,
                });
            }
        }
    }
}

impl<R: BufRead> Source for Trace<R> {
    fn next_row(&mut self, row: &mut Row) -> Result<bool, LogError> {
        let mut more = Vec::new();
        loop {
            if let Some(ready) = self.ready.pop_front() {
                *row = ready;
                return Ok(true);
            }
            if self.ended {
                return Ok(false);
            }
            match self.next_element()? {
                Some(Element::Record(record)) => {
                    // A further frame of the same signals is another recording.
                    if !more.is_empty() {
                        let same = more.iter().all(|id| self.ids.contains_key(id));
                        if !same {
                            self.remarks.push(format!(
                                "line {}: a frame with other signals begins; it was left out",
                                self.line()
                            ));
                            self.ended = true;
                            continue;
                        }
                        more.clear();
                        self.part += 1;
                        self.last_s = None;
                        self.values.fill(f64::NAN);
                    }
                    self.record(&record)?;
                }
                Some(Element::DataSignal(attributes)) => {
                    if attributes
                        .get("datapointCount")
                        .is_none_or(|count| count != "0")
                    {
                        more.push(attributes.get("id").cloned().unwrap_or_default());
                    }
                }
                Some(_) => {}
                None => {
                    self.ended = true;
                    if self.held > 0 {
                        self.remarks.push(format!(
                            "{} times have no record, since nothing changed; they were filled in",
                            self.held
                        ));
                    }
                    if self.unknown > 0 {
                        self.remarks
                            .push(format!("{} values belong to no signal", self.unknown));
                    }
                }
            }
        }
    }

    fn select(&mut self, wanted: &[bool]) {
        self.wanted = wanted.to_vec();
    }

    fn remarks(&mut self) -> Vec<String> {
        std::mem::take(&mut self.remarks)
    }
}

/// The kind of unit as Sinumerik calls it.
fn unit_of(units_type: &str) -> Option<Unit> {
    let symbol = match units_type {
        "posn" => "mm",
        "velo" => "mm/min",
        "current" => "A",
        "torque" => "Nm",
        "percent" => "%",
        _ => return None,
    };
    symbol.parse().ok()
}

/// All attributes; names of signals may have bytes of another encoding.
fn attributes(element: &BytesStart<'_>) -> Option<Vec<(String, String)>> {
    element
        .attributes()
        .map(|attribute| {
            let attribute = attribute.ok()?;
            let key = String::from_utf8_lossy(attribute.key.local_name().as_ref()).into_owned();
            let raw = String::from_utf8_lossy(&attribute.value);
            let value = quick_xml::escape::unescape(&raw).ok()?.into_owned();
            Some((key, value))
        })
        .collect()
}
