//! What a cell is known by: the hash of all that its figures depend on.
//!
//! SHA-256 of lines of text, so that a key can be worked out again by hand (`sha256sum`), on any
//! machine and in any release to come.

use serde::{Deserialize, Serialize};
use serde_json::Value;
use sha2::{Digest, Sha256};
use std::fmt;
use std::io::{self, Read};

/// Bytes of a key: of a million million cells, two alike have odds of 1 in 10^14.
const KEY_BYTES: usize = 16;

/// Bytes read at a time. A choice.
const BLOCK_BYTES: usize = 1 << 16;

/// The key of a cell: the first 128 bits of a SHA-256, as 32 hexadecimal digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Key([u8; KEY_BYTES]);

impl Key {
    /// Of a text.
    ///
    /// ```
    /// use lostmotion_sweep::key::Key;
    ///
    /// // echo -n abc | sha256sum
    /// assert_eq!(Key::of("abc").to_string(), "ba7816bf8f01cfea414140de5dae2223");
    /// ```
    pub fn of(text: &str) -> Key {
        let digest = Sha256::digest(text.as_bytes());
        let mut bytes = [0; KEY_BYTES];
        for (to, from) in bytes.iter_mut().zip(digest) {
            *to = from;
        }
        Key(bytes)
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl From<Key> for String {
    fn from(key: Key) -> String {
        key.to_string()
    }
}

impl TryFrom<String> for Key {
    type Error = String;

    fn try_from(text: String) -> Result<Key, String> {
        let mut bytes = [0; KEY_BYTES];
        // Digits alone: `from_str_radix` would take a sign.
        let good = text.len() == 2 * KEY_BYTES && text.bytes().all(|b| b.is_ascii_hexdigit());
        for (index, byte) in bytes.iter_mut().enumerate() {
            let digits = text.get(2 * index..2 * index + 2).filter(|_| good);
            let value = digits.and_then(|digits| u8::from_str_radix(digits, 16).ok());
            *byte = value.ok_or_else(|| format!("`{text}` is no key of 32 hexadecimal digits"))?;
        }
        Ok(Key(bytes))
    }
}

/// Keys, each once, 16 bytes each.
#[derive(Clone, Debug, Default)]
pub struct Keys(Vec<Key>);

impl Keys {
    /// Of keys in any order.
    pub fn of(mut keys: Vec<Key>) -> Keys {
        keys.sort_unstable();
        keys.dedup();
        keys.shrink_to_fit();
        Keys(keys)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Place of a key among them, in their order.
    pub fn place(&self, key: &Key) -> Option<usize> {
        self.0.binary_search(key).ok()
    }
}

/// SHA-256 of bytes, as 64 hexadecimal digits.
///
/// # Errors
/// Those of the reader.
pub fn sha256(mut from: impl Read) -> io::Result<String> {
    let mut hasher = Sha256::new();
    let mut block = vec![0; BLOCK_BYTES];
    loop {
        let read = match from.read(&mut block) {
            Ok(0) => break,
            Ok(read) => read,
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(error),
        };
        hasher.update(block.get(..read).unwrap_or_default());
    }
    let digest = hasher.finalize();
    Ok(digest.iter().map(|byte| format!("{byte:02x}")).collect())
}

/// JSON with the names of each object in their order, without blanks.
pub(crate) fn ordered(value: &Value) -> String {
    match value {
        Value::Object(map) => {
            let mut names: Vec<_> = map.iter().collect();
            names.sort_by_key(|(name, _)| *name);
            let inside = names
                .into_iter()
                .map(|(name, value)| format!("{}:{}", Value::from(name.as_str()), ordered(value)));
            format!("{{{}}}", inside.collect::<Vec<_>>().join(","))
        }
        Value::Array(list) => {
            let inside: Vec<String> = list.iter().map(ordered).collect();
            format!("[{}]", inside.join(","))
        }
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The examples of FIPS 180-4 (NIST, *SHA-256 example*), of 24 and 448 bits, and of nothing.
    #[test]
    fn digests_are_the_published_ones() {
        for (text, digest) in [
            (
                "abc",
                "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad",
            ),
            (
                "abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq",
                "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1",
            ),
            (
                "",
                "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855",
            ),
        ] {
            assert_eq!(sha256(text.as_bytes()).unwrap(), digest);
            assert_eq!(Key::of(text).to_string(), digest[..32]);
        }
    }

    #[test]
    fn keys_read_back_and_nothing_else_does() {
        let key = Key::of("x");
        assert_eq!(Key::try_from(key.to_string()), Ok(key));
        for wrong in [
            "",
            "12",
            &"g".repeat(32),
            &format!("+{}", "1".repeat(31)),
            &"é".repeat(16),
        ] {
            assert!(Key::try_from(wrong.to_owned()).is_err(), "{wrong}");
        }
    }

    #[test]
    fn order_of_names_does_not_count() {
        let [a, b] = [
            r#"{"b":[{"d":1,"c":2.5}],"a":"x"}"#,
            r#"{"a":"x","b":[{"c":2.5,"d":1}]}"#,
        ]
        .map(|text| ordered(&serde_json::from_str(text).unwrap()));
        assert_eq!((a.as_str(), &a), (r#"{"a":"x","b":[{"c":2.5,"d":1}]}"#, &b));
    }
}
