//! Packed bytes within logs, unpacked within a limit: what a file says of its sizes is not believed.

use std::io::{self, Read};

/// How bytes are packed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Packing {
    #[cfg(feature = "parquet")]
    Gzip,
    #[cfg(feature = "mcap")]
    Lz4,
    Zstd,
}

impl Packing {
    /// Puts what the bytes unpack to into `bytes`, as far as `limit` bytes. `most`: bytes that may be
    /// held, which bounds what an unpacker looks back on.
    pub(crate) fn unpack(
        self,
        packed: impl Read,
        (limit, most): (u64, usize),
        bytes: &mut Vec<u8>,
    ) -> io::Result<usize> {
        match self {
            #[cfg(feature = "parquet")]
            Packing::Gzip => flate2::read::MultiGzDecoder::new(packed)
                .take(limit)
                .read_to_end(bytes),
            #[cfg(feature = "mcap")]
            Packing::Lz4 => lz4_flex::frame::FrameDecoder::new(packed)
                .take(limit)
                .read_to_end(bytes),
            Packing::Zstd => {
                let window = (most as u64).max(1 << 10);
                ruzstd::decoding::StreamingDecoder::new_with_max_window_size(packed, window)
                    .map_err(|error| io::Error::other(error.to_string()))?
                    .take(limit)
                    .read_to_end(bytes)
            }
        }
    }
}
