//! The records of an MCAP file: an operation code, a length and a body. Chunks contain further
//! records.
//!
//! The file is read from its beginning to its end without its index, so that a truncated file
//! yields the records it has. Memory for a body grows with the bytes that are read, not with the
//! length that a record declares.

use std::io::Read;

use mcap::records::op;
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};

use crate::error::LogError;

/// Limit for the length of a record and of an unpacked chunk, bytes. Recorders write chunks of some
/// megabytes; the largest single messages are uncompressed images and clouds of tens of megabytes.
pub(crate) const LIMIT_BYTES: u64 = 256 << 20;
/// Length of the operation code and the length field of a record, bytes.
const HEAD_BYTES: usize = 9;

/// One record.
pub(crate) struct Frame {
    pub op: u8,
    pub body: Vec<u8>,
}

/// The next item of a file or a chunk.
pub(crate) enum Next {
    Frame(Frame),
    End,
    /// The source ended inside a record, which has the part of its body that was there.
    Truncated(Frame),
}

/// Reads the next record and advances `offset` by the bytes read.
pub(crate) fn next_frame(source: &mut impl Read, offset: &mut u64) -> Result<Next, LogError> {
    let begin = *offset;
    let head = read_up_to(source, HEAD_BYTES as u64, offset)?;
    // No byte at all: the source ends between two records.
    let [op, length @ ..] = head.as_slice() else {
        return Ok(Next::End);
    };
    // The source ends inside the length.
    let Ok(length) = <[u8; 8]>::try_from(length) else {
        return Ok(Next::Truncated(Frame {
            op: *op,
            body: Vec::new(),
        }));
    };
    let bytes = u64::from_le_bytes(length);
    // Before anything is read: a damaged length would make the rest of the file one record.
    if bytes > LIMIT_BYTES {
        return Err(LogError::TooLarge {
            offset: begin,
            what: "record",
            bytes,
            limit: LIMIT_BYTES,
        });
    }
    let body = read_up_to(source, bytes, offset)?;
    let complete = body.len() as u64 == bytes;
    let frame = Frame { op: *op, body };
    Ok(if complete {
        Next::Frame(frame)
    } else {
        Next::Truncated(frame)
    })
}

/// Reads `wanted` bytes, or fewer where the source ends.
pub(crate) fn read_up_to(
    source: &mut impl Read,
    wanted: u64,
    offset: &mut u64,
) -> Result<Vec<u8>, LogError> {
    // Not allocated in advance: a damaged length field would take all memory.
    let mut bytes = Vec::new();
    let read = source.take(wanted).read_to_end(&mut bytes);
    *offset += bytes.len() as u64;
    read.map_err(|source| LogError::Read {
        offset: *offset,
        source,
    })?;
    Ok(bytes)
}

/// The records of a chunk, or of the beginning of a truncated chunk.
pub(crate) struct Unpacked {
    pub frames: Vec<Frame>,
    /// Why there are not more of them, if the chunk is truncated or damaged.
    pub error: Option<LogError>,
}

/// Unpacks a chunk that begins at byte `offset` of the file.
pub(crate) fn unpack_chunk(chunk: &[u8], offset: u64) -> Unpacked {
    let mut frames = Vec::new();
    // By reference, so that the records before an error are kept.
    let error = unpack(chunk, offset, &mut frames).err();
    Unpacked { frames, error }
}

fn unpack(chunk: &[u8], offset: u64, frames: &mut Vec<Frame>) -> Result<(), LogError> {
    let header = ChunkHeader::parse(chunk).ok_or(LogError::Truncated {
        offset,
        what: "chunk",
    })?;
    let (bytes, limit) = (header.unpacked, LIMIT_BYTES);
    if bytes > limit {
        return Err(LogError::TooLarge {
            offset,
            what: "chunk",
            bytes,
            limit,
        });
    }
    match header.compression {
        b"" | b"zstd" => unpack_known(chunk, offset, frames),
        other => {
            let compression = String::from_utf8_lossy(other);
            let problem = format!(
                "chunk compression `{compression}` is not supported; convert the log to zstd"
            );
            Err(LogError::Damaged {
                offset,
                source: problem.into(),
            })
        }
    }
}

/// Passes the chunk, as a file of one record, to the `mcap` crate, which decompresses it and checks
/// its CRC.
fn unpack_known(chunk: &[u8], offset: u64, frames: &mut Vec<Frame>) -> Result<(), LogError> {
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true)
        .with_validate_chunk_crcs(true)
        .with_record_length_limit(LIMIT_BYTES as usize);
    let mut reader = LinearReader::new_with_options(options);
    let head = [&[op::CHUNK][..], &(chunk.len() as u64).to_le_bytes()].concat();
    let mut source = head.as_slice().chain(chunk);
    while let Some(event) = reader.next_event() {
        match event.map_err(|error| chunk_error(error, offset))? {
            LinearReadEvent::ReadRequest(wanted) => {
                let bytes = read_up_to(
                    &mut source,
                    // Never more than there is: the chunk may declare any length.
                    wanted.min(chunk.len() + HEAD_BYTES) as u64,
                    &mut 0,
                )?;
                reader.insert(bytes.len()).copy_from_slice(&bytes);
                // Zero bytes tell the reader that the source has ended.
                reader.notify_read(bytes.len());
            }
            LinearReadEvent::Record { data, opcode } => frames.push(Frame {
                op: opcode,
                body: data.to_vec(),
            }),
        }
    }
    Ok(())
}

fn chunk_error(error: mcap::McapError, offset: u64) -> LogError {
    match error {
        mcap::McapError::UnexpectedEof | mcap::McapError::UnexpectedEoc => LogError::Truncated {
            offset,
            what: "chunk",
        },
        other => LogError::Damaged {
            offset,
            source: other.into(),
        },
    }
}

struct ChunkHeader<'a> {
    unpacked: u64,
    compression: &'a [u8],
}

impl<'a> ChunkHeader<'a> {
    fn parse(chunk: &'a [u8]) -> Option<Self> {
        let mut fields = Fields(chunk);
        // First and last log time.
        fields.take(16)?;
        let unpacked = fields.u64()?;
        // CRC.
        fields.take(4)?;
        let compression = fields.text()?;
        // Packed length: a truncated chunk declares more bytes than it has.
        fields.u64()?;
        Some(Self {
            unpacked,
            compression,
        })
    }
}

/// Reads the fields of a record's body in order; `None` where the body ends before a field.
pub(crate) struct Fields<'a>(pub &'a [u8]);

impl<'a> Fields<'a> {
    pub(crate) fn take(&mut self, bytes: usize) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(bytes)?;
        self.0 = rest;
        Some(taken)
    }

    pub(crate) fn u16(&mut self) -> Option<u16> {
        Some(u16::from_le_bytes(self.take(2)?.try_into().ok()?))
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        Some(u64::from_le_bytes(self.take(8)?.try_into().ok()?))
    }

    /// Bytes with their length in front, u32.
    pub(crate) fn text(&mut self) -> Option<&'a [u8]> {
        let length = u32::from_le_bytes(self.take(4)?.try_into().ok()?);
        self.take(length as usize)
    }

    pub(crate) fn rest(&mut self) -> &'a [u8] {
        std::mem::take(&mut self.0)
    }
}
