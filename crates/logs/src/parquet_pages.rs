//! The numbers in the pages of a Parquet column.
//!
//! The format's own crate finds the pages, and unpacks those of snappy and lz4. Its decoder of values
//! takes damaged pages for granted and panics on them, so values are decoded here, and everything is
//! held against what is there. Its zstd is C, and its gzip unpacks without a limit: both are unpacked
//! here, too.

use crate::packed::Packing;
use crate::thrift;
use bytes::Bytes;
use parquet::basic::{Compression, Encoding, Type as Physical};
use parquet::column::page::{Page, PageReader};
use parquet::errors::ParquetError;
use parquet::file::metadata::ColumnChunkMetaData;
use parquet::file::serialized_reader::SerializedPageReader;
use std::collections::VecDeque;
use std::sync::Arc;

/// Bytes that a value of a page takes while it waits.
const VALUE_BYTES: usize = 2 * std::mem::size_of::<Option<u64>>();

/// A number as it is stored: whole numbers with their sign extended, others by their bits.
type Stored = u64;

fn damaged(what: impl Into<String>) -> ParquetError {
    ParquetError::General(what.into())
}

fn short() -> ParquetError {
    damaged("a page is shorter than its values")
}

/// The bytes of a page; more than `most` are refused.
fn unpacked(packing: Packing, packed: &[u8], most: usize) -> Result<Vec<u8>, ParquetError> {
    let mut bytes = Vec::new();
    packing
        .unpack(packed, (most as u64 + 1, most), &mut bytes)
        .map_err(|error| damaged(format!("a page cannot be unpacked: {error}")))?;
    if bytes.len() > most {
        return Err(damaged(format!(
            "a page of more than {most} bytes; allow more with --max-memory-mb"
        )));
    }
    Ok(bytes)
}

/// Refuses headers of pages whose lists are longer than the file.
fn check_headers(file: &[u8], chunk: &ColumnChunkMetaData) -> Result<(), ParquetError> {
    let (first, size) = chunk.byte_range();
    let mut place = usize::try_from(first).unwrap_or(usize::MAX);
    let end = place.saturating_add(usize::try_from(size).unwrap_or(usize::MAX));
    while place < end.min(file.len()) {
        let passed = thrift::pass(&file[place..]).map_err(damaged)?;
        let page = passed.third.and_then(|size| usize::try_from(size).ok());
        let page = page.ok_or_else(|| damaged("a page without a size"))?;
        place = place.saturating_add(passed.bytes).saturating_add(page);
    }
    Ok(())
}

/// The values of one column of a row group, page by page.
pub(crate) struct Pages {
    reader: Box<dyn PageReader>,
    packing: Option<Packing>,
    physical: Physical,
    /// Levels of a value that is there; none are written where no value can be null.
    level: u32,
    most_bytes: usize,
    dictionary: Vec<Stored>,
    waiting: VecDeque<Option<Stored>>,
}

impl Pages {
    /// Of a column chunk of a file and so many rows, whose values have `level` levels where they are there.
    pub(crate) fn new(
        file: &Bytes,
        chunk: &ColumnChunkMetaData,
        rows: usize,
        level: i16,
        most_bytes: usize,
    ) -> Result<Pages, ParquetError> {
        let packing = match chunk.compression() {
            Compression::GZIP(_) => Some(Packing::Gzip),
            Compression::ZSTD(_) => Some(Packing::Zstd),
            _ => None,
        };
        // the crate gives pages that it takes for unpacked as they are
        let as_they_are = match packing {
            Some(_) => chunk
                .clone()
                .into_builder()
                .set_compression(Compression::UNCOMPRESSED)
                .build()?,
            None => chunk.clone(),
        };
        check_headers(file, chunk)?;
        let reader = SerializedPageReader::new(Arc::new(file.clone()), &as_they_are, rows, None)?;
        Ok(Pages {
            reader: Box::new(reader),
            packing,
            physical: chunk.column_type(),
            level: u32::try_from(level).unwrap_or_default(),
            most_bytes,
            dictionary: Vec::new(),
            waiting: VecDeque::new(),
        })
    }

    /// The bytes of a page or of its values.
    fn unpacked(&self, bytes: Bytes) -> Result<Bytes, ParquetError> {
        match self.packing {
            Some(packing) if !bytes.is_empty() => {
                Ok(unpacked(packing, &bytes, self.most_bytes)?.into())
            }
            _ => Ok(bytes),
        }
    }

    /// The next value; `None` within where it is null, an error where there is no further one.
    pub(crate) fn value(&mut self) -> Result<Option<Stored>, ParquetError> {
        loop {
            if let Some(value) = self.waiting.pop_front() {
                return Ok(value);
            }
            let page = self.reader.get_next_page()?;
            self.take(page.ok_or_else(|| damaged("a column has fewer values than rows"))?)?;
        }
    }

    fn take(&mut self, page: Page) -> Result<(), ParquetError> {
        let count = page.num_values() as usize;
        if count.saturating_mul(VALUE_BYTES) > self.most_bytes {
            return Err(damaged(format!(
                "a page of {count} values; allow more with --max-memory-mb"
            )));
        }
        match page {
            Page::DictionaryPage { buf, .. } => {
                self.dictionary = plain(&self.unpacked(buf)?, self.physical, count)?;
                Ok(())
            }
            Page::DataPage {
                buf,
                encoding,
                def_level_encoding,
                ..
            } => {
                let buf = self.unpacked(buf)?;
                let mut bytes: &[u8] = &buf;
                let mut levels = None;
                if self.level > 0 {
                    if def_level_encoding != Encoding::RLE {
                        return Err(damaged(format!(
                            "levels in {def_level_encoding} are not read"
                        )));
                    }
                    let length = number(&mut bytes)? as usize;
                    let (first, rest) = bytes.split_at_checked(length).ok_or_else(short)?;
                    levels = Some(first);
                    bytes = rest;
                }
                self.data(levels, bytes, encoding, count)
            }
            Page::DataPageV2 {
                buf,
                encoding,
                def_levels_byte_len,
                rep_levels_byte_len,
                is_compressed,
                ..
            } => {
                let repeated = rep_levels_byte_len as usize;
                let behind = repeated.saturating_add(def_levels_byte_len as usize);
                let levels = buf.get(repeated..behind).ok_or_else(short)?;
                let levels = (self.level > 0).then_some(levels);
                // levels are never packed
                let mut values = buf.slice(behind..);
                if is_compressed {
                    values = self.unpacked(values)?;
                }
                self.data(levels, &values, encoding, count)
            }
        }
    }

    fn data(
        &mut self,
        levels: Option<&[u8]>,
        bytes: &[u8],
        encoding: Encoding,
        count: usize,
    ) -> Result<(), ParquetError> {
        let there: Option<Vec<bool>> = match levels {
            Some(levels) => {
                let width = u32::BITS - self.level.leading_zeros();
                let levels = hybrid(levels, width, count)?;
                Some(
                    levels
                        .into_iter()
                        .map(|level| level == self.level)
                        .collect(),
                )
            }
            None => None,
        };
        let present = there
            .as_ref()
            .map_or(count, |there| there.iter().filter(|there| **there).count());
        let values = self.decoded(bytes, encoding, present)?;
        match there {
            None => self.waiting.extend(values.into_iter().map(Some)),
            Some(there) => {
                let mut values = values.into_iter();
                for is_there in there {
                    let value = if is_there { values.next() } else { None };
                    self.waiting.push_back(value);
                }
            }
        }
        Ok(())
    }

    fn decoded(
        &self,
        bytes: &[u8],
        encoding: Encoding,
        count: usize,
    ) -> Result<Vec<Stored>, ParquetError> {
        match encoding {
            Encoding::PLAIN => plain(bytes, self.physical, count),
            Encoding::RLE if self.physical == Physical::BOOLEAN => {
                let bytes = bytes.get(4..).ok_or_else(short)?;
                Ok(hybrid(bytes, 1, count)?
                    .into_iter()
                    .map(u64::from)
                    .collect())
            }
            Encoding::PLAIN_DICTIONARY | Encoding::RLE_DICTIONARY => {
                if count == 0 {
                    return Ok(Vec::new());
                }
                let (&width, bytes) = bytes.split_first().ok_or_else(short)?;
                let places = hybrid(bytes, u32::from(width), count)?;
                let value = |place: u32| self.dictionary.get(place as usize).copied();
                let values: Option<Vec<Stored>> = places.into_iter().map(value).collect();
                values.ok_or_else(|| damaged("a value is not in the dictionary"))
            }
            Encoding::BYTE_STREAM_SPLIT => {
                let width = width(self.physical).ok_or_else(|| damaged("no numbers to split"))?;
                if bytes.len() < count.saturating_mul(width) {
                    return Err(short());
                }
                // The first bytes of all values, then the second ones.
                let stream = bytes.len() / width;
                let value = |row: usize| {
                    (0..width).fold(0, |value, byte| {
                        let byte_value = bytes.get(byte * stream + row).copied();
                        value | u64::from(byte_value.unwrap_or_default()) << (8 * byte)
                    })
                };
                Ok((0..count)
                    .map(|row| extended(value(row), self.physical))
                    .collect())
            }
            Encoding::DELTA_BINARY_PACKED => {
                let values = deltas(bytes, count)?;
                Ok(values
                    .into_iter()
                    .map(|value| extended(value, self.physical))
                    .collect())
            }
            other => Err(damaged(format!("values in {other} are not read"))),
        }
    }
}

/// Bytes of a number.
fn width(physical: Physical) -> Option<usize> {
    match physical {
        Physical::INT32 | Physical::FLOAT => Some(4),
        Physical::INT64 | Physical::DOUBLE => Some(8),
        _ => None,
    }
}

/// A stored value with its sign extended.
fn extended(value: u64, physical: Physical) -> Stored {
    match physical {
        Physical::INT32 => i64::from(value as u32 as i32).cast_unsigned(),
        Physical::FLOAT => u64::from(value as u32),
        _ => value,
    }
}

/// Values one behind the other; those of one bit eight to a byte.
fn plain(bytes: &[u8], physical: Physical, count: usize) -> Result<Vec<Stored>, ParquetError> {
    let Some(width) = width(physical) else {
        return (0..count)
            .map(|row| {
                let byte = bytes.get(row / 8).ok_or_else(short)?;
                Ok(u64::from(byte >> (row % 8) & 1))
            })
            .collect();
    };
    if bytes.len() < count.saturating_mul(width) {
        return Err(short());
    }
    let values = bytes.chunks_exact(width).take(count).map(|bytes| {
        let value = bytes
            .iter()
            .rev()
            .fold(0, |value, byte| value << 8 | u64::from(*byte));
        extended(value, physical)
    });
    Ok(values.collect())
}

/// Four bytes as a number, lowest first.
fn number(bytes: &mut &[u8]) -> Result<u32, ParquetError> {
    let (first, rest) = bytes.split_first_chunk::<4>().ok_or_else(short)?;
    *bytes = rest;
    Ok(u32::from_le_bytes(*first))
}

/// A number of seven bits a byte, lowest first.
fn leb128(bytes: &mut &[u8]) -> Result<u64, ParquetError> {
    let mut value = 0;
    for place in 0..10 {
        let (&byte, rest) = bytes.split_first().ok_or_else(short)?;
        *bytes = rest;
        value |= u64::from(byte & 0x7F) << (7 * place);
        if byte & 0x80 == 0 {
            return Ok(value);
        }
    }
    Err(damaged("a number is too long"))
}

/// The same with its sign in the lowest bit.
fn zigzag(bytes: &mut &[u8]) -> Result<i64, ParquetError> {
    let value = leb128(bytes)?;
    Ok((value >> 1).cast_signed() ^ -(value & 1).cast_signed())
}

/// A value of so many bits at a bit of the bytes; bits behind the end are zero.
fn bits(bytes: &[u8], at: usize, width: u32) -> u64 {
    let mut value = 0_u128;
    // 64 bits lie in nine bytes at most.
    for byte in 0..9 {
        let found = bytes.get(at / 8 + byte).copied().unwrap_or_default();
        value |= u128::from(found) << (8 * byte);
    }
    let mask = (1_u128 << width) - 1;
    (value >> (at % 8) & mask) as u64
}

/// Runs of one value, and groups of eight packed by their bits.
fn hybrid(mut bytes: &[u8], width: u32, count: usize) -> Result<Vec<u32>, ParquetError> {
    if width > u32::BITS {
        return Err(damaged(format!("values of {width} bits")));
    }
    let mut values = Vec::new();
    while values.len() < count {
        let header = leb128(&mut bytes)?;
        let left = count - values.len();
        let told = usize::try_from(header >> 1).unwrap_or(usize::MAX);
        if header & 1 == 0 {
            let size = width.div_ceil(8) as usize;
            let (first, rest) = bytes.split_at_checked(size).ok_or_else(short)?;
            bytes = rest;
            let value = bits(first, 0, width) as u32;
            values.extend(std::iter::repeat_n(value, told.min(left)));
            if told == 0 {
                return Err(damaged("a run of no values"));
            }
        } else {
            let groups = told.min(left.div_ceil(8));
            let size = groups * width as usize;
            // The last group may lack bytes that no value needs.
            let needed = (groups * 8).min(left) * width as usize;
            let packed = bytes.get(..size.min(bytes.len())).unwrap_or_default();
            if packed.len() * 8 < needed || groups == 0 {
                return Err(short());
            }
            bytes = bytes.get(packed.len()..).unwrap_or_default();
            let places = (0..(groups * 8).min(left)).map(|place| place * width as usize);
            values.extend(places.map(|at| bits(packed, at, width) as u32));
        }
    }
    Ok(values)
}

/// Whole numbers by their differences, packed in blocks.
fn deltas(mut bytes: &[u8], count: usize) -> Result<Vec<u64>, ParquetError> {
    let (block, parts) = (leb128(&mut bytes)?, leb128(&mut bytes)?);
    let told = leb128(&mut bytes)?;
    let per_part = block.checked_div(parts).unwrap_or_default();
    if told < count as u64 || per_part == 0 || parts > 1 << 16 || per_part > 1 << 24 {
        return Err(damaged("blocks of differences without values"));
    }
    let (parts, per_part) = (parts as usize, per_part as usize);
    let mut value = zigzag(&mut bytes)?;
    let mut values = Vec::new();
    if count > 0 {
        values.push(value.cast_unsigned());
    }
    while values.len() < count {
        let least = zigzag(&mut bytes)?;
        let (widths, rest) = bytes.split_at_checked(parts).ok_or_else(short)?;
        bytes = rest;
        for &width in widths {
            if values.len() >= count {
                break;
            }
            if u32::from(width) > u64::BITS {
                return Err(damaged(format!("differences of {width} bits")));
            }
            let size = (per_part * usize::from(width)).div_ceil(8);
            let (packed, rest) = bytes.split_at_checked(size).ok_or_else(short)?;
            bytes = rest;
            for place in 0..per_part.min(count - values.len()) {
                let more = bits(packed, place * usize::from(width), u32::from(width));
                value = value.wrapping_add(least).wrapping_add(more.cast_signed());
                values.push(value.cast_unsigned());
            }
        }
    }
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_unpacks_to_more_than_may_be_held_is_refused() {
        let zeros = vec![0; 1 << 20];
        let mut gzip = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        std::io::Write::write_all(&mut gzip, &zeros).unwrap();
        let gzip = gzip.finish().unwrap();
        let zstd = ruzstd::encoding::compress_to_vec(
            zeros.as_slice(),
            ruzstd::encoding::CompressionLevel::Fastest,
        );
        for (packing, packed) in [(Packing::Gzip, gzip), (Packing::Zstd, zstd)] {
            assert!(packed.len() < 1 << 12, "{}", packed.len());
            assert_eq!(unpacked(packing, &packed, 1 << 20).unwrap(), zeros);
            let said = unpacked(packing, &packed, (1 << 20) - 1).unwrap_err();
            assert!(said.to_string().contains("--max-memory-mb"), "{said}");
            assert!(unpacked(packing, &packed[..packed.len() / 2], 1 << 20).is_err());
        }
    }

    /// The example in the format's description of its encodings: 0 to 7 in three bits each.
    #[test]
    fn packed_bits_are_those_of_the_description() {
        let bytes = [0x03, 0b1000_1000, 0b1100_0110, 0b1111_1010];
        assert_eq!(hybrid(&bytes, 3, 8).unwrap(), [0, 1, 2, 3, 4, 5, 6, 7]);
        // a run of five
        assert_eq!(hybrid(&[0x0A, 0x07], 3, 5).unwrap(), [7; 5]);
        assert!(hybrid(&[0x0A], 3, 5).is_err() && hybrid(&[0, 7], 3, 5).is_err());
        assert!(hybrid(&bytes[..2], 3, 8).is_err() && hybrid(&bytes, 40, 8).is_err());
    }

    /// Both examples in the format's description of differences: 1 to 5, and 7, 5, 3, 1, 2, 3, 4, 5.
    #[test]
    fn differences_are_those_of_the_description() {
        let even = [0x80, 0x01, 4, 5, 2, 2, 0, 0, 0, 0];
        assert_eq!(deltas(&even, 5).unwrap(), [1, 2, 3, 4, 5]);
        let mut other = vec![0x80, 0x01, 4, 8, 14, 3, 2, 0, 0, 0, 0xC0, 0x3F];
        other.resize(18, 0);
        assert_eq!(deltas(&other, 8).unwrap(), [7, 5, 3, 1, 2, 3, 4, 5]);
        assert!(deltas(&other[..17], 8).is_err() && deltas(&[1, 0, 1, 0], 1).is_err());
    }
}
