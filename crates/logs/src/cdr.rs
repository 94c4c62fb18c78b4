//! Messages of ROS 2: their definition (`ros2msg`), and its numbers in CDR, the encoding of OMG's
//! DDS.

/// Deepest definition within definitions.
const MAX_DEPTH: usize = 32;

/// Why a message ends early.
#[derive(Debug, PartialEq)]
pub(crate) enum Stop {
    /// Fewer bytes than the definition needs.
    Short,
    /// A form of CDR that is not read.
    Form(u16),
}

/// A type without parts.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Plain {
    Bool,
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
    Text,
    WideText,
}

impl Plain {
    fn named(name: &str) -> Option<Plain> {
        Some(match name {
            "bool" => Plain::Bool,
            "byte" | "char" | "uint8" => Plain::U8,
            "int8" => Plain::I8,
            "int16" => Plain::I16,
            "uint16" => Plain::U16,
            "int32" => Plain::I32,
            "uint32" => Plain::U32,
            "int64" => Plain::I64,
            "uint64" => Plain::U64,
            "float32" => Plain::F32,
            "float64" => Plain::F64,
            "string" => Plain::Text,
            "wstring" => Plain::WideText,
            _ => return None,
        })
    }
}

#[derive(Debug)]
enum FieldKind {
    Plain(Plain),
    /// Place of a definition among those of the file.
    Other(usize),
}

/// How many values a field has.
#[derive(Debug)]
enum Count {
    One,
    Fixed(usize),
    Any,
}

#[derive(Debug)]
struct Field {
    name: String,
    kind: FieldKind,
    count: Count,
}

/// A message with all that it is made of; the first part is the message.
#[derive(Debug)]
pub(crate) struct Definition(Vec<Vec<Field>>);

/// The fields of one part: their type, name and count, as written.
fn lines(part: &str) -> impl Iterator<Item = (&str, &str)> {
    part.lines().filter_map(|line| {
        let line = line.split('#').next().unwrap_or_default().trim();
        let (kind, rest) = line.split_once(char::is_whitespace)?;
        let name = rest.split_whitespace().next()?;
        // A constant, `uint8 MODE=1` or `uint8 MODE = 1`; what stands behind a name is its default.
        let is_constant = name.contains('=')
            || rest
                .trim_start()
                .strip_prefix(name)?
                .trim_start()
                .starts_with('=');
        (!is_constant).then_some((kind, name))
    })
}

impl Definition {
    /// Reads a definition: that of the message, then those of its parts behind lines of `=`, each
    /// with its name in a line `MSG: package/Name`.
    pub(crate) fn parse(text: &str) -> Result<Definition, String> {
        let mut parts: Vec<(String, String)> = vec![(String::new(), String::new())];
        for line in text.lines() {
            if line.starts_with("====") {
                parts.push((String::new(), String::new()));
            } else if let Some((name, body)) = parts.last_mut() {
                match line.strip_prefix("MSG:") {
                    Some(told) => told.trim().clone_into(name),
                    None => {
                        body.push_str(line);
                        body.push('\n');
                    }
                }
            }
        }
        let place = |wanted: &str| {
            let plain = wanted.replacen("/msg/", "/", 1);
            let last = plain.rsplit('/').next().unwrap_or_default();
            let is_short = !plain.contains('/');
            parts.iter().skip(1).position(|(name, _)| {
                let name = name.replacen("/msg/", "/", 1);
                name == plain || is_short && name.rsplit('/').next() == Some(last)
            })
        };
        let mut read = Vec::new();
        for (_, body) in &parts {
            let mut fields = Vec::new();
            for (kind, name) in lines(body) {
                let (base, count) = match kind.split_once('[') {
                    None => (kind, Count::One),
                    Some((base, "]")) => (base, Count::Any),
                    Some((base, bound)) => match bound.strip_suffix(']') {
                        Some(bound) if bound.starts_with("<=") => (base, Count::Any),
                        Some(bound) => {
                            let count = bound.parse();
                            let count = count.map_err(|_| format!("its type `{kind}` is none"))?;
                            (base, Count::Fixed(count))
                        }
                        None => return Err(format!("its type `{kind}` is none")),
                    },
                };
                // `string<=10`
                let base = base.split("<=").next().unwrap_or_default();
                let kind = match Plain::named(base) {
                    Some(plain) => FieldKind::Plain(plain),
                    None => FieldKind::Other(
                        1 + place(base)
                            .ok_or_else(|| format!("its type `{base}` is not defined"))?,
                    ),
                };
                let name = name.to_owned();
                fields.push(Field { name, kind, count });
            }
            read.push(fields);
        }
        Ok(Definition(read))
    }

    /// Gives every number of a message with its path.
    pub(crate) fn numbers(&self, data: &[u8], give: &mut dyn FnMut(&str, f64)) -> Result<(), Stop> {
        let (head, body) = data.split_at_checked(4).ok_or(Stop::Short)?;
        let form = u16::from_be_bytes([head[0], head[1]]);
        if form > 1 {
            return Err(Stop::Form(form));
        }
        let mut cursor = Cursor {
            bytes: body,
            at: 0,
            little: form == 1,
        };
        self.part(0, &mut cursor, &mut String::new(), 0, give)
    }

    fn part(
        &self,
        part: usize,
        cursor: &mut Cursor<'_>,
        path: &mut String,
        depth: usize,
        give: &mut dyn FnMut(&str, f64),
    ) -> Result<(), Stop> {
        if depth > MAX_DEPTH {
            return Err(Stop::Short);
        }
        let length = path.len();
        let fields = self.0.get(part).map_or(&[][..], Vec::as_slice);
        // ROS gives a message without fields one byte, since IDL knows no empty ones.
        if fields.is_empty() {
            cursor.take::<1>()?;
        }
        for field in fields {
            path.push('.');
            path.push_str(&field.name);
            let named = path.len();
            let count = match field.count {
                Count::One => 1,
                Count::Fixed(count) => count,
                Count::Any => cursor.u32()? as usize,
            };
            // Every value has a byte at least.
            if count > cursor.left() {
                return Err(Stop::Short);
            }
            for index in 0..count {
                if !matches!(field.count, Count::One) {
                    path.push_str(&format!("[{index}]"));
                }
                match field.kind {
                    FieldKind::Other(other) => self.part(other, cursor, path, depth + 1, give)?,
                    FieldKind::Plain(plain) => {
                        if let Some(value) = cursor.value(plain)? {
                            give(path, value);
                        }
                    }
                }
                path.truncate(named);
            }
            path.truncate(length);
        }
        Ok(())
    }
}

/// A place in a message.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    little: bool,
}

impl Cursor<'_> {
    fn left(&self) -> usize {
        self.bytes.len().saturating_sub(self.at)
    }

    /// The bytes of a number, at a multiple of its size, lowest first.
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Stop> {
        let from = self.at.next_multiple_of(N);
        let bytes = self.bytes.get(from..from + N).ok_or(Stop::Short)?;
        let mut bytes: [u8; N] = bytes.try_into().map_err(|_| Stop::Short)?;
        if !self.little {
            bytes.reverse();
        }
        self.at = from + N;
        Ok(bytes)
    }

    fn u32(&mut self) -> Result<u32, Stop> {
        self.take().map(u32::from_le_bytes)
    }

    /// The next value; none for a text.
    fn value(&mut self, plain: Plain) -> Result<Option<f64>, Stop> {
        Ok(Some(match plain {
            Plain::Bool | Plain::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Plain::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Plain::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Plain::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Plain::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Plain::U32 => f64::from(self.u32()?),
            Plain::I64 => i64::from_le_bytes(self.take()?) as f64,
            Plain::U64 => u64::from_le_bytes(self.take()?) as f64,
            Plain::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Plain::F64 => f64::from_le_bytes(self.take()?),
            Plain::Text | Plain::WideText => {
                let characters = self.u32()? as usize;
                let size = if plain == Plain::Text { 1 } else { 2 };
                let bytes = characters.checked_mul(size).ok_or(Stop::Short)?;
                if bytes > self.left() {
                    return Err(Stop::Short);
                }
                self.at += bytes;
                return Ok(None);
            }
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(definition: &Definition, data: &[u8]) -> Result<Vec<(String, f64)>, Stop> {
        let mut found = Vec::new();
        definition.numbers(data, &mut |path, value| {
            found.push((path.to_owned(), value));
        })?;
        Ok(found)
    }

    /// A message put together by hand by the rules of CDR: numbers stand at multiples of their
    /// size, counted behind the four bytes of the encapsulation.
    #[test]
    fn numbers_stand_at_multiples_of_their_size() {
        let text = "# a comment\nuint8 MODE=3\nstd_msgs/Header header\nfloat64[] position\nint16[2] pair\nbool on true\nstring<=8 name\n================\nMSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id\n================\nMSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec\n";
        let definition = Definition::parse(text).unwrap();
        let mut body: Vec<u8> = Vec::new();
        body.extend((-5_i32).to_le_bytes());
        body.extend(7_u32.to_le_bytes());
        body.extend(3_u32.to_le_bytes());
        body.extend(b"ab\0");
        body.resize(16, 0);
        body.extend(2_u32.to_le_bytes());
        body.resize(24, 0);
        body.extend(1.5_f64.to_le_bytes());
        body.extend((-2.5_f64).to_le_bytes());
        body.extend((-1_i16).to_le_bytes());
        body.extend(2_i16.to_le_bytes());
        body.push(1);
        body.resize(48, 0);
        body.extend(1_u32.to_le_bytes());
        body.push(0);
        let data = [&[0, 1, 0, 0], &body[..]].concat();
        let expected = [
            (".header.stamp.sec", -5.0),
            (".header.stamp.nanosec", 7.0),
            (".position[0]", 1.5),
            (".position[1]", -2.5),
            (".pair[0]", -1.0),
            (".pair[1]", 2.0),
            (".on", 1.0),
        ]
        .map(|(path, value)| (path.to_owned(), value));
        assert_eq!(numbers(&definition, &data).unwrap(), expected);
        // cut anywhere it is short, never another value
        for length in 0..data.len() {
            assert_eq!(numbers(&definition, &data[..length]), Err(Stop::Short));
        }
        let other = [&[0, 7, 0, 0], &body[..]].concat();
        assert_eq!(numbers(&definition, &other), Err(Stop::Form(7)));
    }

    #[test]
    fn both_byte_orders_are_read() {
        let definition = Definition::parse("float32 data").unwrap();
        let big = [&[0, 0, 0, 0], &0.25_f32.to_be_bytes()[..]].concat();
        let found = vec![(".data".to_owned(), 0.25)];
        assert_eq!(numbers(&definition, &big), Ok(found));
    }

    #[test]
    fn what_is_not_defined_is_said() {
        assert!(
            Definition::parse("Other x")
                .unwrap_err()
                .contains("`Other` is not defined")
        );
        assert!(Definition::parse("int8[x] x").is_err());
        // a part that holds itself ends
        let own = Definition::parse("A a\n====\nMSG: p/A\nA a\n").unwrap();
        assert_eq!(numbers(&own, &[0, 1, 0, 0, 1, 2]), Err(Stop::Short));
    }
}
