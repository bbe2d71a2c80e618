//! Decompresses the chunks of recordings that other programs have written: MCAP names zstd and lz4.
//!
//! What a chunk takes in memory is bounded before its first byte is decompressed, by the size that its header declares,
//! and no decoder gets more room than that.

use std::io::Read as _;

/// Most bytes of a chunk after decompression. Writers close a chunk after 1 to 4 MB.
pub const CHUNK_BYTES_MAX: u64 = 256 << 20;

/// Most bytes of all compressed chunks of a recording after decompression: they are in memory together.
pub const DECOMPRESSED_BYTES_MAX: u64 = 1 << 30;

/// Most bytes that a zstd frame may refer back to, and that are held while it is decoded: the limit of zstd's own
/// decoder. A frame of one segment refers to all of itself.
const ZSTD_WINDOW_BYTES_MAX: u64 = 128 << 20;

/// The bytes of `stored`, of which the chunk's header declares that they are `size`, at most `budget`.
///
/// # Errors
/// What is wrong, as the end of "damaged: ".
pub(crate) fn decompressed(
    compression: &str,
    stored: &[u8],
    size: u64,
    budget: u64,
) -> Result<Vec<u8>, String> {
    let decompress: fn(&[u8], usize) -> Result<Vec<u8>, String> = match compression {
        "zstd" => zstd,
        "lz4" => lz4,
        other => return Err(format!("a chunk compressed by {other:?}, need zstd, lz4 or none")),
    };
    if size > CHUNK_BYTES_MAX {
        return Err(format!(
            "a chunk of {size} bytes once decompressed, need {CHUNK_BYTES_MAX} at most: write it in smaller chunks"
        ));
    }
    if size > budget {
        return Err(format!(
            "a chunk beyond the {DECOMPRESSED_BYTES_MAX} bytes that a recording may have once decompressed: write it \
             uncompressed"
        ));
    }
    let size = usize::try_from(size).map_err(|_| "a chunk larger than memory")?;
    let records =
        decompress(stored, size).map_err(|why| format!("a chunk that is not {compression}: {why}"))?;
    match records.len() == size {
        true => Ok(records),
        false => Err(format!("a chunk whose {compression} holds {} bytes, need {size}", records.len())),
    }
}

fn zstd(stored: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let mut decoder = ruzstd::decoding::FrameDecoder::new();
    decoder.set_max_window_size(ZSTD_WINDOW_BYTES_MAX.max(size as u64));
    let mut records = vec![0; size];
    let length = decoder.decode_all(stored, &mut records).map_err(|error| error.to_string())?;
    records.truncate(length);
    Ok(records)
}

fn lz4(mut stored: &[u8], size: usize) -> Result<Vec<u8>, String> {
    let mut records = Vec::new();
    while !stored.is_empty() {
        // A decoder for each frame: one cannot take a second frame with larger blocks.
        let decoder = lz4_flex::frame::FrameDecoder::new(&mut stored);
        // One byte more than there may be shows that there is too much.
        let room = (size - records.len()) as u64 + 1;
        decoder.take(room).read_to_end(&mut records).map_err(|error| error.to_string())?;
        if records.len() > size {
            return Err(format!("more than the {size} bytes of its header"));
        }
    }
    Ok(records)
}
