//! The records of an MCAP file: its channels, and message after message, out of chunks where they
//! are packed (the format's specification, version 0).

use crate::error::LogError;
use crate::packed::Packing;
use std::collections::BTreeMap;
use std::io::{self, BufRead, Read};
use std::sync::Arc;

/// What a file begins with.
pub(crate) const MAGIC: &[u8] = b"\x89MCAP0\r\n";

const SCHEMA: u8 = 0x03;
const CHANNEL: u8 = 0x04;
const MESSAGE: u8 = 0x05;
const CHUNK: u8 = 0x06;
const DATA_END: u8 = 0x0F;

/// How the messages of channels are defined.
pub(crate) struct Schema {
    pub(crate) encoding: String,
    pub(crate) text: String,
}

/// A channel: a topic with its encoding.
pub(crate) struct McapChannel {
    pub(crate) topic: String,
    pub(crate) encoding: String,
    pub(crate) schema: Option<Arc<Schema>>,
    /// Whether it was told behind the messages that the channels are found from.
    pub(crate) is_late: bool,
}

pub(crate) type Channels = BTreeMap<u16, McapChannel>;

pub(crate) struct Message {
    pub(crate) channel: u16,
    pub(crate) time_ns: u64,
    pub(crate) data: Vec<u8>,
}

/// A record's bytes, read from the front.
struct Body<'a>(&'a [u8]);

impl<'a> Body<'a> {
    fn bytes(&mut self, length: usize) -> Option<&'a [u8]> {
        let (first, rest) = self.0.split_at_checked(length)?;
        self.0 = rest;
        Some(first)
    }

    fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        self.bytes(N)?.try_into().ok()
    }

    fn u16(&mut self) -> Option<u16> {
        self.array().map(u16::from_le_bytes)
    }

    fn u32(&mut self) -> Option<u32> {
        self.array().map(u32::from_le_bytes)
    }

    fn u64(&mut self) -> Option<u64> {
        self.array().map(u64::from_le_bytes)
    }

    fn text(&mut self) -> Option<String> {
        let length = self.u32()? as usize;
        Some(String::from_utf8_lossy(self.bytes(length)?).into_owned())
    }
}

pub(crate) struct Records<R> {
    input: R,
    name: String,
    most: usize,
    schemas: BTreeMap<u16, Arc<Schema>>,
    channels: Channels,
    /// The chunk being read, unpacked, and the place in it.
    chunk: Vec<u8>,
    at: usize,
    messages: u64,
    ended: bool,
    /// Whether the file ends within a record.
    cut: bool,
}

impl<R: BufRead> Records<R> {
    pub(crate) fn new(mut input: R, name: &str, most: usize) -> Result<Records<R>, LogError> {
        let mut magic = [0; 8];
        let begun = input.read_exact(&mut magic);
        if begun.is_err() || magic != *MAGIC {
            let what = "this is no MCAP file of version 0";
            return Err(LogError::file(
                name,
                what,
                "write it with an up-to-date tool",
            ));
        }
        Ok(Records {
            input,
            name: name.to_owned(),
            most,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            chunk: Vec::new(),
            at: 0,
            messages: 0,
            ended: false,
            cut: false,
        })
    }

    /// The channels that were told up to now.
    pub(crate) fn channels(&self) -> &Channels {
        &self.channels
    }

    /// What the end was like, for the user.
    pub(crate) fn remark(&mut self) -> Option<String> {
        std::mem::take(&mut self.cut).then(|| {
            format!(
                "the file ends within a record: the {} messages before it are read",
                self.messages
            )
        })
    }

    fn damaged(&self, what: &str) -> LogError {
        let after = self.messages;
        let what = format!("after message {after}: {what}");
        LogError::file(&self.name, what, "the file is damaged")
    }

    fn too_large(&self, what: &str, bytes: u64) -> LogError {
        let what = format!(
            "after message {}: {what} of {bytes} bytes; {} are allowed",
            self.messages, self.most
        );
        LogError::file(&self.name, what, "allow more with --max-memory-mb")
    }

    /// The next message; `None` at the end.
    pub(crate) fn next_message(&mut self) -> Result<Option<Message>, LogError> {
        loop {
            if self.at < self.chunk.len() {
                if let Some(message) = self.of_chunk()? {
                    self.messages += 1;
                    return Ok(Some(message));
                }
                continue;
            }
            if self.ended {
                return Ok(None);
            }
            let Some((kind, length)) = self.begin()? else {
                continue;
            };
            if !matches!(kind, SCHEMA | CHANNEL | MESSAGE | CHUNK) {
                self.skip(length)?;
                continue;
            }
            if length > self.most as u64 {
                return Err(self.too_large("a record", length));
            }
            let mut bytes = Vec::new();
            if !self.read(length, &mut bytes)? {
                continue;
            }
            if kind == CHUNK {
                self.unpack(&bytes)?;
            } else if let Some(message) = self.record(kind, &bytes)? {
                self.messages += 1;
                return Ok(Some(message));
            }
        }
    }

    /// The kind and the length of the next record of the file.
    fn begin(&mut self) -> Result<Option<(u8, u64)>, LogError> {
        let mut start = Vec::new();
        if !self.read(9, &mut start)? {
            // A file that ends between two records was cut there.
            return Ok(None);
        }
        let mut body = Body(&start);
        let kind = body.array::<1>().map(|[kind]| kind);
        let (Some(kind), Some(length)) = (kind, body.u64()) else {
            return Ok(None);
        };
        if kind == DATA_END {
            self.ended = true;
            return Ok(None);
        }
        Ok(Some((kind, length)))
    }

    /// Reads so many bytes; false, and the end, where the file is cut.
    fn read(&mut self, length: u64, bytes: &mut Vec<u8>) -> Result<bool, LogError> {
        let read = self.input.by_ref().take(length).read_to_end(bytes);
        let read = read.map_err(|source| LogError::Io {
            name: self.name.clone(),
            source,
        })?;
        if (read as u64) < length {
            (self.ended, self.cut) = (true, true);
            return Ok(false);
        }
        Ok(true)
    }

    /// Passes over what is not read: attachments, indexes, metadata.
    fn skip(&mut self, length: u64) -> Result<(), LogError> {
        let passed = io::copy(&mut self.input.by_ref().take(length), &mut io::sink());
        let passed = passed.map_err(|source| LogError::Io {
            name: self.name.clone(),
            source,
        })?;
        if passed < length {
            (self.ended, self.cut) = (true, true);
        }
        Ok(())
    }

    /// Unpacks a chunk.
    fn unpack(&mut self, bytes: &[u8]) -> Result<(), LogError> {
        let mut body = Body(bytes);
        let mut parts = || {
            let (_start, _end) = (body.u64()?, body.u64()?);
            let (size, _check) = (body.u64()?, body.u32()?);
            let packing = body.text()?;
            let length = usize::try_from(body.u64()?).ok()?;
            Some((size, packing, body.bytes(length)?))
        };
        let Some((size, packing, packed)) = parts() else {
            return Err(self.damaged("a chunk has no records"));
        };
        if size > self.most as u64 {
            return Err(self.too_large("a chunk", size));
        }
        self.chunk.clear();
        self.at = 0;
        // One byte more tells a chunk that is larger than it says.
        let most = size + 1;
        let packing = match packing.as_str() {
            "" => None,
            "lz4" => Some(Packing::Lz4),
            "zstd" => Some(Packing::Zstd),
            other => {
                let what = format!("a chunk is compressed with `{other}`");
                let hint = "lz4 and zstd are read: write it with one of them, or without";
                return Err(LogError::file(&self.name, what, hint));
            }
        };
        let unpacked = match packing {
            None => packed.take(most).read_to_end(&mut self.chunk),
            Some(packing) => packing.unpack(packed, (most, self.most), &mut self.chunk),
        };
        if let Err(error) = unpacked {
            return Err(self.damaged(&format!("a chunk cannot be unpacked: {error}")));
        }
        if self.chunk.len() as u64 != size {
            return Err(self.damaged(&format!(
                "a chunk says that it has {size} bytes and has others"
            )));
        }
        Ok(())
    }

    /// The next record of the chunk, if it is a message.
    fn of_chunk(&mut self) -> Result<Option<Message>, LogError> {
        let chunk = std::mem::take(&mut self.chunk);
        let mut body = Body(chunk.get(self.at..).unwrap_or_default());
        let mut record = || {
            let [kind] = body.array::<1>()?;
            let length = usize::try_from(body.u64()?).ok()?;
            Some((kind, body.bytes(length)?))
        };
        let found = match record() {
            Some((kind, bytes)) => {
                self.at = chunk.len() - body.0.len();
                self.record(kind, bytes)
            }
            None => Err(self.damaged("a record of a chunk is longer than the chunk")),
        };
        self.chunk = chunk;
        found
    }

    /// Takes a record up; returns it if it is a message.
    fn record(&mut self, kind: u8, bytes: &[u8]) -> Result<Option<Message>, LogError> {
        let mut body = Body(bytes);
        let whole = match kind {
            SCHEMA => self.schema(&mut body),
            CHANNEL => self.channel(&mut body),
            MESSAGE => {
                let mut parts = || {
                    let (channel, _sequence) = (body.u16()?, body.u32()?);
                    let (time_ns, _published) = (body.u64()?, body.u64()?);
                    Some((channel, time_ns))
                };
                let Some((channel, time_ns)) = parts() else {
                    return Err(self.damaged("a message is too short"));
                };
                if !self.channels.contains_key(&channel) {
                    let what = format!("a message is of channel {channel}, which is not told");
                    return Err(self.damaged(&what));
                }
                return Ok(Some(Message {
                    channel,
                    time_ns,
                    data: body.0.to_vec(),
                }));
            }
            _ => Some(()),
        };
        match whole {
            Some(()) => Ok(None),
            None => Err(self.damaged("the record of a channel or a schema is too short")),
        }
    }

    fn schema(&mut self, body: &mut Body<'_>) -> Option<()> {
        let (id, _name, encoding) = (body.u16()?, body.text()?, body.text()?);
        let text = body.text()?;
        // A definition does not change; chunks repeat it.
        let schema = || Arc::new(Schema { encoding, text });
        self.schemas.entry(id).or_insert_with(schema);
        Some(())
    }

    fn channel(&mut self, body: &mut Body<'_>) -> Option<()> {
        let (id, schema) = (body.u16()?, body.u16()?);
        let (topic, encoding) = (body.text()?, body.text()?);
        let schema = self.schemas.get(&schema).cloned();
        let is_late = self.messages > 0;
        self.channels.entry(id).or_insert_with(|| McapChannel {
            topic,
            encoding,
            schema,
            is_late,
        });
        Some(())
    }
}
