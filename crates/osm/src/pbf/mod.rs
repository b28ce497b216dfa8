//! Reads OSM PBF, the compressed format of regional extracts.
//!
//! After *PBF Format*, wiki.openstreetmap.org. A file is a sequence of blobs, each with a header
//! that gives its kind and size. All headers are read before any blob is decompressed, so that a
//! truncated file is detected first. Unknown kinds of blobs are skipped and unknown features are
//! refused, as the format demands. Memory stays proportional to the file, whatever its blobs claim.
//!
//! | module | contents |
//! |---|---|
//! | `wire` | protocol buffers |
//! | `block` | nodes, ways and relations of a block |
//! | `bounded` | no more elements than a map of that size can have |

mod block;
mod bounded;
mod wire;

use std::io::Read;

use flate2::read::ZlibDecoder;

use crate::error::{OsmError, Place, Problem};
use crate::visitor::Visitor;
use bounded::Bounded;
use wire::{Field, Fields};

/// The format's limits for blobs, compressed or not, and for headers, bytes.
const LARGEST_BLOB_BYTES: u64 = 32 << 20;
const LARGEST_HEADER_BYTES: u32 = 64 << 10;
/// A blob that decompresses to more than this multiple of its size, and to more than
/// [`ALWAYS_ALLOWED_BYTES`], is no map. Real ones grow by a factor of two or three.
const LARGEST_RATIO: u64 = 20;
const ALWAYS_ALLOWED_BYTES: u64 = 64 << 10;

const KNOWN_FEATURES: [&str; 3] = ["OsmSchema-V0.6", "DenseNodes", "HistoricalInformation"];

/// Whether the bytes begin like PBF: the length of a blob header is below 2^16, so its first two
/// bytes are 0.
pub(crate) fn looks_like_pbf(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0, 0])
}

/// Shows all elements of a file to a visitor.
pub(crate) fn read(bytes: &[u8], visitor: &mut impl Visitor) -> Result<(), OsmError> {
    let mut unpacked = Vec::new();
    let mut bounded = Bounded::new(visitor, bytes.len());
    for blob in blobs(bytes)? {
        blob.read(&mut unpacked, &mut bounded)
            .and_then(|()| bounded.check())
            .map_err(|problem| at(blob.offset, problem))?;
    }
    Ok(())
}

fn at(offset: usize, problem: impl Into<Problem>) -> OsmError {
    OsmError::malformed(Place::Byte(offset), problem)
}

fn cut_off(offset: usize, part: &str) -> OsmError {
    at(
        offset,
        format!("the file ends within {part}; it is truncated, download it again"),
    )
}

/// A blob as it stands in the file.
struct Blob<'a> {
    /// Offset of its header.
    offset: usize,
    kind: &'a [u8],
    bytes: &'a [u8],
}

/// All blobs of a file. The last one must end where the bytes end.
fn blobs(bytes: &[u8]) -> Result<Vec<Blob<'_>>, OsmError> {
    let mut blobs = Vec::new();
    let mut rest = bytes;
    while !rest.is_empty() {
        let offset = bytes.len() - rest.len();
        let (length, after) = rest
            .split_first_chunk()
            .ok_or_else(|| cut_off(offset, "a blob header"))?;
        let length = u32::from_be_bytes(*length);
        // Both sizes are checked before anything is read by them.
        if length > LARGEST_HEADER_BYTES {
            return Err(at(
                offset,
                "a blob header of invalid size; this is not OSM PBF or it is damaged",
            ));
        }
        let (header, after) = after
            .split_at_checked(length as usize)
            .ok_or_else(|| cut_off(offset, "a blob header"))?;
        let Header { kind, size } = Header::read(header).map_err(|problem| at(offset, problem))?;
        if size > LARGEST_BLOB_BYTES {
            return Err(at(
                offset,
                "a blob of invalid size; this is not OSM PBF or it is damaged",
            ));
        }
        let (blob, after) = after
            .split_at_checked(size as usize)
            .ok_or_else(|| cut_off(offset, "this blob"))?;
        blobs.push(Blob {
            offset,
            kind,
            bytes: blob,
        });
        rest = after;
    }
    Ok(blobs)
}

/// What a header says about the blob behind it.
struct Header<'a> {
    kind: &'a [u8],
    /// Bytes.
    size: u64,
}

impl<'a> Header<'a> {
    fn read(bytes: &'a [u8]) -> Result<Self, wire::Problem> {
        let (mut kind, mut size) = (None, None);
        for field in Fields(bytes) {
            let Field { number, value } = field?;
            match number {
                1 => kind = Some(value.bytes()?),
                3 => size = Some(value.number()?),
                _ => {}
            }
        }
        let (Some(kind), Some(size)) = (kind, size) else {
            return Err("a blob header without kind or size; this is not OSM PBF or it is damaged");
        };
        Ok(Self { kind, size })
    }
}

impl Blob<'_> {
    /// Decompresses into `buffer`, whose memory is used again.
    fn read(&self, buffer: &mut Vec<u8>, visitor: &mut impl Visitor) -> Result<(), Problem> {
        match self.kind {
            b"OSMHeader" => check_features(self.unpack(buffer)?),
            b"OSMData" => Ok(block::read(self.unpack(buffer)?, visitor)?),
            // Unknown kinds of blobs are skipped, as the format demands.
            _ => Ok(()),
        }
    }

    fn unpack<'b>(&self, buffer: &'b mut Vec<u8>) -> Result<&'b [u8], Problem>
    where
        Self: 'b,
    {
        for field in Fields(self.bytes) {
            let Field { number, value } = field?;
            match number {
                1 => return Ok(value.bytes()?),
                // Field 2 states the size of the content. It is not needed, and a hostile file may
                // lie.
                3 => return inflate(value.bytes()?, buffer),
                // lzma, bzip2, lz4 and zstd.
                4..=7 => {
                    return Err(
                        "this blob is not compressed with zlib; no other compression is supported"
                            .into(),
                    );
                }
                _ => {}
            }
        }
        Err("a blob without content".into())
    }
}

fn inflate<'b>(packed: &[u8], unpacked: &'b mut Vec<u8>) -> Result<&'b [u8], Problem> {
    // Decompression stops one byte above the limit, which is enough to see that it is exceeded.
    let largest =
        (LARGEST_RATIO * packed.len() as u64).clamp(ALWAYS_ALLOWED_BYTES, LARGEST_BLOB_BYTES);
    unpacked.clear();
    let read = ZlibDecoder::new(packed)
        .take(largest + 1)
        .read_to_end(unpacked);
    read.map_err(|error| Problem::caused("this blob cannot be decompressed", error))?;
    if unpacked.len() as u64 > largest {
        let packed = packed.len();
        return Err(format!(
            "this blob of {packed} bytes decompresses to more than {largest}; this is not a map"
        )
        .into());
    }
    Ok(unpacked)
}

fn check_features(header: &[u8]) -> Result<(), Problem> {
    for field in Fields(header) {
        // Field 4 lists the features that a reader must know. Optional ones are in another field.
        let Field { number: 4, value } = field? else {
            continue;
        };
        let feature = String::from_utf8_lossy(value.bytes()?);
        if !KNOWN_FEATURES.contains(&feature.as_ref()) {
            return Err(
                format!("the file needs the feature {feature}, which is not supported").into(),
            );
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::data::OsmData;

    /// One blob with a header block that requires `feature`, uncompressed, built by hand from the
    /// definition of the format.
    fn header_blob(feature: &str) -> Vec<u8> {
        let field = |tag: u8, bytes: &[u8]| [&[tag, bytes.len() as u8], bytes].concat();
        let blob = field(0x0A, &field(0x22, feature.as_bytes()));
        let header = [field(0x0A, b"OSMHeader"), vec![0x18, blob.len() as u8]].concat();
        [
            &(header.len() as u32).to_be_bytes(),
            header.as_slice(),
            &blob,
        ]
        .concat()
    }

    #[test]
    fn a_file_with_only_a_header_is_an_empty_map() {
        let data = OsmData::from_bytes(&header_blob("DenseNodes")).unwrap();
        assert!(data.nodes.is_empty());
    }

    #[test]
    fn an_unknown_feature_is_refused_by_name() {
        let error = OsmData::from_bytes(&header_blob("LocationsOnMars"))
            .unwrap_err()
            .to_string();
        assert_eq!(
            error,
            "byte 0: the file needs the feature LocationsOnMars, which is not supported"
        );
    }

    #[test]
    fn every_truncation_of_a_file_is_an_error() {
        let whole = header_blob("DenseNodes");
        for length in 1..whole.len() {
            assert!(
                OsmData::from_pbf(&whole[..length]).is_err(),
                "cut to {length} bytes"
            );
        }
    }

    #[test]
    fn a_negative_blob_size_does_not_loop() {
        // Size -1 as a ten-byte varint.
        let header = [
            &[0x0A, 9],
            b"OSMHeader".as_slice(),
            &[0x18],
            &[0xFF; 9],
            &[1],
        ]
        .concat();
        let bytes = [&(header.len() as u32).to_be_bytes(), header.as_slice()].concat();
        assert!(
            OsmData::from_pbf(&bytes)
                .unwrap_err()
                .to_string()
                .contains("invalid size")
        );
    }

    /// A file of one compressed blob of zeros.
    fn packed(zeros: usize) -> Vec<u8> {
        let mut packer = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::best());
        std::io::Write::write_all(&mut packer, &vec![0; zeros]).unwrap();
        let number = |n: usize| [n as u8 | 128, (n >> 7) as u8 | 128, (n >> 14) as u8];
        let packed = packer.finish().unwrap();
        let blob = [&[0x1A], number(packed.len()).as_slice(), &packed].concat();
        let header = [
            [0x0A, 7].as_slice(),
            b"OSMData",
            &[0x18],
            &number(blob.len()),
        ]
        .concat();
        [
            &(header.len() as u32).to_be_bytes(),
            header.as_slice(),
            &blob,
        ]
        .concat()
    }

    #[test]
    fn a_small_blob_that_decompresses_to_megabytes_is_refused() {
        let error = OsmData::from_pbf(&packed(20 << 20))
            .unwrap_err()
            .to_string();
        assert!(error.contains("this is not a map"), "{error}");
        // Few enough to be parsed; zeros are no fields.
        let error = OsmData::from_pbf(&packed(1000)).unwrap_err().to_string();
        assert!(!error.contains("this is not a map"), "{error}");
    }
}
