//! MCAP, the container of robotics tools: messages in JSON, and ROS 2 messages whose definition
//! stands in the file. Every topic is sampled by its own clock, and each number in its messages is a
//! channel: `topic.field`, `topic.list[0]`.

use crate::cdr::{Definition, Stop};
use crate::error::LogError;
pub(crate) use crate::mcap_records::MAGIC;
use crate::mcap_records::{Channels, Message, Records};
use crate::source::{Channel, Format, Header, MAX_CHANNELS, ReadOptions, Row, Source};
use crate::text::is_measured;
use crate::unit::Unit;
use serde_json::Value;
use std::collections::{BTreeMap, VecDeque};
use std::io::BufRead;

/// Bytes of messages that are looked at before the first row is given: a topic that begins later is
/// left out. A choice, as the first bytes of a text.
const HEAD_BYTES: usize = 1 << 20;
/// Seconds in a nanosecond.
const S_PER_NS: f64 = 1e-9;

/// How the messages of a topic are read.
enum Reading {
    Json,
    Ros(Definition),
}

impl Reading {
    /// Every number of a message with its path.
    fn numbers(&self, data: &[u8], give: &mut dyn FnMut(&str, f64)) -> Result<(), String> {
        match self {
            Reading::Json => {
                let value: Value = serde_json::from_slice(data)
                    .map_err(|error| format!("the message is no JSON: {error}"))?;
                flatten(&value, &mut String::new(), give);
                Ok(())
            }
            Reading::Ros(definition) => definition.numbers(data, give).map_err(|stop| match stop {
                Stop::Short => "the message is shorter than its definition".to_owned(),
                Stop::Form(form) => {
                    format!("the message has the encapsulation {form:#06x}; plain CDR is read")
                }
            }),
        }
    }
}

/// Gives every number in a JSON value with its path; booleans are 0 and 1, a number that was not
/// finite is `null` in JSON.
fn flatten(value: &Value, path: &mut String, give: &mut dyn FnMut(&str, f64)) {
    let length = path.len();
    match value {
        Value::Bool(value) => give(path, f64::from(u8::from(*value))),
        Value::Number(number) => give(path, number.as_f64().unwrap_or(f64::NAN)),
        Value::Array(values) => {
            for (index, value) in values.iter().enumerate() {
                path.push_str(&format!("[{index}]"));
                flatten(value, path, give);
                path.truncate(length);
            }
        }
        Value::Object(fields) => {
            for (name, value) in fields {
                path.push('.');
                path.push_str(name);
                flatten(value, path, give);
                path.truncate(length);
            }
        }
        Value::Null | Value::String(_) => {}
    }
}

/// What is read of one topic.
struct Topic {
    name: String,
    reading: Reading,
    group: usize,
    /// Place of each path among the values of the topic.
    places: BTreeMap<String, usize>,
    /// Names of its channels, and which are read.
    names: Vec<String>,
    wanted: Vec<bool>,
}

pub(crate) fn open<'a, R: BufRead + 'a>(
    input: R,
    name: &str,
    options: &ReadOptions,
) -> Result<(Header, Box<dyn Source + 'a>), LogError> {
    let mut records = Records::new(input, name, options.max_bytes)?;
    let mut head: VecDeque<Message> = VecDeque::new();
    let mut bytes = 0;
    while bytes < HEAD_BYTES.min(options.max_bytes) {
        let Some(message) = records.next_message()? else {
            break;
        };
        bytes += message.data.len() + std::mem::size_of::<Message>();
        head.push_back(message);
    }
    let mut said =
        vec!["every topic has its own times, which count from the first message".to_owned()];
    let mut topics = topics(name, records.channels(), &head, &mut said)?;
    let mut channels = Vec::new();
    topics.retain(|_, topic| !topic.places.is_empty());
    for (group, topic) in topics.values_mut().enumerate() {
        topic.group = group;
        for channel in &topic.names {
            channels.push(Channel {
                name: channel.clone(),
                unit: Unit::in_name(channel),
                group,
            });
        }
    }
    if channels.is_empty() || channels.len() > MAX_CHANNELS {
        let what = format!(
            "{} channels of numbers in messages that can be read",
            channels.len()
        );
        let hint = "messages in JSON are read, and ROS 2 messages with their definition";
        let all: Vec<String> = said.drain(1..).collect();
        let what = [&[what], &all[..]].concat().join("; ");
        return Err(LogError::file(name, what, hint));
    }
    let header = Header {
        columns: None,
        format: Format::Mcap,
        groups: topics.len(),
        channels,
        said,
        guessed_time: None,
    };
    let source = Mcap {
        name: name.to_owned(),
        first_ns: head.front().map_or(0, |message| message.time_ns),
        records,
        head,
        topics,
        messages: 0,
        late: BTreeMap::new(),
        remarks: Vec::new(),
    };
    Ok((header, Box::new(source)))
}

/// The topics whose messages are read, by the number of their channel in the file.
fn topics(
    name: &str,
    channels: &Channels,
    head: &VecDeque<Message>,
    said: &mut Vec<String>,
) -> Result<BTreeMap<u16, Topic>, LogError> {
    let mut topics = BTreeMap::new();
    for (&id, channel) in channels {
        let reading = match (channel.encoding.as_str(), channel.schema.as_ref()) {
            ("json", _) => Ok(Reading::Json),
            ("cdr", Some(schema)) if schema.encoding == "ros2msg" => {
                Definition::parse(&schema.text).map(Reading::Ros)
            }
            (encoding, schema) => {
                let by = schema.map_or("no schema", |schema| schema.encoding.as_str());
                Err(format!(
                    "its messages are in `{encoding}` by `{by}`, which is not read"
                ))
            }
        };
        match reading {
            Ok(reading) => {
                topics.insert(
                    id,
                    Topic {
                        name: channel.topic.clone(),
                        reading,
                        group: 0,
                        places: BTreeMap::new(),
                        names: Vec::new(),
                        wanted: Vec::new(),
                    },
                );
            }
            Err(reason) => said.push(format!("topic `{}` is left out: {reason}", channel.topic)),
        }
    }
    // Every path that a number was seen at.
    for (index, message) in head.iter().enumerate() {
        let Some(topic) = topics.get_mut(&message.channel) else {
            continue;
        };
        let Topic {
            name: called,
            reading,
            places,
            names,
            wanted,
            ..
        } = topic;
        let mut found = |path: &str, _: f64| {
            if !places.contains_key(path) && places.len() <= MAX_CHANNELS {
                places.insert(path.to_owned(), names.len());
                names.push(format!("{called}{path}"));
                wanted.push(true);
            }
        };
        reading
            .numbers(&message.data, &mut found)
            .map_err(|what| refused(name, index as u64 + 1, called, &what))?;
    }
    Ok(topics)
}

fn refused(name: &str, message: u64, topic: &str, what: &str) -> LogError {
    let what = format!("topic `{topic}`: {what}");
    LogError::line(name, message, what, "").counting(Format::Mcap.counted())
}

struct Mcap<R> {
    name: String,
    records: Records<R>,
    /// Messages that were looked at and not yet given.
    head: VecDeque<Message>,
    topics: BTreeMap<u16, Topic>,
    first_ns: u64,
    messages: u64,
    /// Messages of topics that begin late, and numbers that no message had before.
    late: BTreeMap<String, u64>,
    remarks: Vec<String>,
}

impl<R: BufRead> Mcap<R> {
    /// Says what was left out.
    fn end(&mut self) {
        for (what, count) in std::mem::take(&mut self.late) {
            self.remarks.push(format!(
                "`{what}` begins late and was left out, {count} values"
            ));
        }
        self.remarks.extend(self.records.remark());
    }

    fn counted_late(&mut self, what: String) {
        if self.late.contains_key(&what) || self.late.len() < 20 {
            *self.late.entry(what).or_default() += 1;
        }
    }
}

impl<R: BufRead> Source for Mcap<R> {
    fn next_row(&mut self, row: &mut Row) -> Result<bool, LogError> {
        loop {
            let message = match self.head.pop_front() {
                Some(message) => Some(message),
                None => self.records.next_message()?,
            };
            let Some(message) = message else {
                self.end();
                return Ok(false);
            };
            self.messages += 1;
            let Some(topic) = self.topics.get(&message.channel) else {
                let begun = self.records.channels().get(&message.channel);
                let begun = begun.filter(|channel| channel.is_late);
                if let Some(topic) = begun.map(|channel| channel.topic.clone()) {
                    self.counted_late(topic);
                }
                continue;
            };
            row.values.clear();
            row.values.resize(topic.names.len(), f64::NAN);
            let mut unknown = Vec::new();
            let mut put = |path: &str, value: f64| match topic.places.get(path) {
                Some(&place) => {
                    if let Some(entry) = row.values.get_mut(place) {
                        *entry = value;
                    }
                }
                None => unknown.push(format!("{}{path}", topic.name)),
            };
            topic
                .reading
                .numbers(&message.data, &mut put)
                .map_err(|what| refused(&self.name, self.messages, &topic.name, &what))?;
            for (place, value) in row.values.iter().enumerate() {
                if !is_measured(*value) && topic.wanted.get(place) == Some(&true) {
                    let channel = topic.names.get(place).map_or("", String::as_str);
                    let what = if value.is_finite() {
                        "is larger than anything measured (1e30) in this message"
                    } else {
                        "is no finite number in this message"
                    };
                    let hint = "remove the message, or the field";
                    let shown = match value {
                        value if value.is_nan() => String::new(),
                        value => format!("{value:e}"),
                    };
                    let error =
                        LogError::cell(&self.name, self.messages, channel, &shown, what, hint);
                    return Err(error.counting(Format::Mcap.counted()));
                }
            }
            row.group = topic.group;
            row.line = self.messages;
            row.part = 0;
            // Apart from the first one, so that no nanosecond is lost in a large number.
            let since = i128::from(message.time_ns) - i128::from(self.first_ns);
            row.time_s = since as f64 * S_PER_NS;
            unknown.into_iter().for_each(|what| self.counted_late(what));
            return Ok(true);
        }
    }

    fn select(&mut self, wanted: &[bool]) {
        let mut wanted = wanted.iter().copied();
        for topic in self.topics.values_mut() {
            for entry in &mut topic.wanted {
                *entry = wanted.next().unwrap_or_default();
            }
        }
    }

    fn remarks(&mut self) -> Vec<String> {
        std::mem::take(&mut self.remarks)
    }
}
