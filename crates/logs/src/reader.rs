//! Messages out of an MCAP file, in the order they stand in it.
//!
//! A file that was cut off, or is damaged in its middle, yields every message before that place and then one error.
//! Chunks may be stored or compressed with zstd; LZ4 is refused by name. The index at the end of a file is not used.

use std::collections::{BTreeMap, VecDeque};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use std::sync::Arc;

use mcap::records::op;
use openbench_core::SimTime;

use crate::error::LogError;
use crate::framing::{self, Fields, Frame, Next};
use crate::messages::Message;

/// One message as it stands in the file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LoggedMessage {
    /// The topic it was written to.
    pub topic: Arc<str>,
    /// Full name of its type, `geometry_msgs/msg/PoseStamped`; empty if the file does not say.
    pub type_name: Arc<str>,
    /// When it was logged.
    pub time: SimTime,
    /// CDR.
    pub data: Vec<u8>,
}

impl LoggedMessage {
    /// The message as `M`.
    pub fn decode<M: Message>(&self) -> Result<M, LogError> {
        if *self.type_name != *M::DEFINITION.full_name() {
            return Err(LogError::WrongType {
                topic: self.topic.to_string(),
                found: self.type_name.to_string(),
                wanted: M::DEFINITION.name,
            });
        }
        M::from_cdr(&self.data).map_err(|source| LogError::Decode {
            topic: self.topic.to_string(),
            time: self.time,
            source,
        })
    }
}

/// Iterates over the messages of a log. After an error there is nothing more.
pub struct LogReader<R> {
    source: R,
    offset: u64,
    schemas: BTreeMap<u16, Arc<str>>,
    channels: BTreeMap<u16, Channel>,
    ready: VecDeque<LoggedMessage>,
    error: Option<LogError>,
    done: bool,
}

/// A topic and the full name of its type.
#[derive(Clone)]
struct Channel {
    topic: Arc<str>,
    type_name: Arc<str>,
}

impl LogReader<BufReader<File>> {
    /// Opens a file.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, LogError> {
        let path = path.as_ref();
        let file = File::open(path).map_err(|source| LogError::File { path: path.to_owned(), source })?;
        Self::new(BufReader::new(file))
    }
}

impl<R: Read> LogReader<R> {
    /// Reads from any source.
    pub fn new(mut source: R) -> Result<Self, LogError> {
        let mut offset = 0;
        let magic = framing::read_up_to(&mut source, mcap::MAGIC.len() as u64, &mut offset)?;
        if magic != mcap::MAGIC {
            return Err(LogError::NotMcap);
        }
        Ok(Self {
            source,
            offset,
            schemas: BTreeMap::new(),
            channels: BTreeMap::new(),
            ready: VecDeque::new(),
            error: None,
            done: false,
        })
    }

    /// The messages of one topic, decoded.
    pub fn messages<M: Message>(self, topic: &str) -> impl Iterator<Item = Result<(SimTime, M), LogError>> {
        let wanted = topic.to_owned();
        self.filter(move |m| m.as_ref().map_or(true, |m| *m.topic == *wanted))
            .map(|m| m.and_then(|m| Ok((m.time, m.decode()?))))
    }

    /// Reads one record and makes what is in it ready.
    fn advance(&mut self) -> Result<(), LogError> {
        let begin = self.offset;
        match framing::next_frame(&mut self.source, &mut self.offset)? {
            Next::Frame(Frame { op: op::DATA_END | op::FOOTER, .. }) => self.done = true,
            Next::Frame(Frame { op: op::CHUNK, body }) => self.take_chunk(&body, begin)?,
            Next::Frame(frame) => self.take(&frame, begin)?,
            Next::End => return Err(LogError::Truncated { offset: begin, what: "file" }),
            Next::CutOff(Frame { op: op::CHUNK, body }) => {
                self.take_chunk(&body, begin)?;
                return Err(LogError::Truncated { offset: begin, what: "chunk" });
            }
            Next::CutOff(_) => return Err(LogError::Truncated { offset: begin, what: "record" }),
        }
        Ok(())
    }

    fn take_chunk(&mut self, chunk: &[u8], offset: u64) -> Result<(), LogError> {
        let unpacked = framing::unpack_chunk(chunk, offset);
        for frame in &unpacked.frames {
            self.take(frame, offset)?;
        }
        unpacked.error.map_or(Ok(()), Err)
    }

    fn take(&mut self, frame: &Frame, offset: u64) -> Result<(), LogError> {
        let taken = match frame.op {
            op::SCHEMA => self.take_schema(Fields(&frame.body)),
            op::CHANNEL => self.take_channel(Fields(&frame.body)),
            op::MESSAGE => return self.take_message(Fields(&frame.body), offset),
            _ => Some(()),
        };
        taken.ok_or_else(|| damaged(offset, "a record ends before its fields"))
    }

    fn take_schema(&mut self, mut fields: Fields<'_>) -> Option<()> {
        let id = fields.u16()?;
        self.schemas.insert(id, text(fields.text()?));
        Some(())
    }

    fn take_channel(&mut self, mut fields: Fields<'_>) -> Option<()> {
        let (id, schema) = (fields.u16()?, fields.u16()?);
        let type_name = self.schemas.get(&schema).cloned().unwrap_or_default();
        self.channels.insert(id, Channel { topic: text(fields.text()?), type_name });
        Some(())
    }

    fn take_message(&mut self, mut fields: Fields<'_>, offset: u64) -> Result<(), LogError> {
        let head = MessageHead::read(&mut fields)
            .ok_or_else(|| damaged(offset, "a message ends before its fields"))?;
        let Some(Channel { topic, type_name }) = self.channels.get(&head.channel).cloned() else {
            return Err(damaged(offset, "a message belongs to no channel"));
        };
        let data = fields.rest().to_vec();
        self.ready.push_back(LoggedMessage { topic, type_name, time: head.time, data });
        Ok(())
    }
}

/// What stands before the bytes of a message.
struct MessageHead {
    channel: u16,
    /// When it was logged.
    time: SimTime,
}

impl MessageHead {
    fn read(fields: &mut Fields<'_>) -> Option<Self> {
        let channel = fields.u16()?;
        fields.take(4)?; // sequence number
        let time = SimTime(fields.u64()?);
        fields.take(8)?; // publish time
        Some(Self { channel, time })
    }
}

fn text(bytes: &[u8]) -> Arc<str> {
    String::from_utf8_lossy(bytes).into()
}

fn damaged(offset: u64, problem: &str) -> LogError {
    LogError::Damaged { offset, source: problem.into() }
}

impl<R: Read> Iterator for LogReader<R> {
    type Item = Result<LoggedMessage, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(message) = self.ready.pop_front() {
                return Some(Ok(message));
            }
            if let Some(error) = self.error.take() {
                return Some(Err(error));
            }
            if self.done {
                return None;
            }
            if let Err(error) = self.advance() {
                (self.error, self.done) = (Some(error), true);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::{Header, StringMessage};
    use crate::writer::LogWriter;
    use proptest::prelude::*;
    use std::io::Cursor;

    fn log(messages: usize) -> Vec<u8> {
        let mut log = LogWriter::new(Cursor::new(Vec::new())).unwrap();
        for i in 0..messages {
            // Text that compresses badly, so that the log has several chunks.
            let noise: String =
                (0..2000u64).map(|j| char::from(33 + ((i as u64 * 7919 + j * j * 31) % 90) as u8)).collect();
            log.write("/note", SimTime(i as u64), &StringMessage(noise)).unwrap();
            log.write("/head", SimTime(i as u64), &Header::new(SimTime(i as u64), "map")).unwrap();
        }
        log.finish().unwrap().into_inner()
    }

    fn read(bytes: &[u8]) -> (usize, Option<LogError>) {
        let Ok(reader) = LogReader::new(bytes) else { return (0, Some(LogError::NotMcap)) };
        let mut error = None;
        let good = reader.filter_map(|m| m.map_err(|e| error = Some(e)).ok()).count();
        (good, error)
    }

    #[test]
    fn a_topic_is_read_back() {
        let bytes = log(3);
        let headers: Result<Vec<_>, _> =
            LogReader::new(bytes.as_slice()).unwrap().messages::<Header>("/head").collect();
        let expected: Vec<_> = (0..3).map(|i| (SimTime(i), Header::new(SimTime(i), "map"))).collect();
        assert_eq!(headers.unwrap(), expected);
        let wrong = LogReader::new(bytes.as_slice()).unwrap().messages::<StringMessage>("/head").next();
        assert!(matches!(wrong, Some(Err(LogError::WrongType { .. }))));
    }

    #[test]
    fn a_log_that_is_cut_off_gives_what_it_has() {
        let bytes = log(1200);
        let (all, error) = read(&bytes);
        assert!(all == 2400 && error.is_none());
        let (some, error) = read(&bytes[..bytes.len() * 2 / 3]);
        assert!(some > 1200 && some < 2400, "{some}");
        assert!(matches!(error, Some(LogError::Truncated { .. })), "{error:?}");
    }

    #[test]
    fn other_files_are_refused() {
        assert!(matches!(LogReader::new(&b"SQLite format 3\0"[..]), Err(LogError::NotMcap)));
        assert!(matches!(LogReader::new(&b""[..]), Err(LogError::NotMcap)));
    }

    #[test]
    fn a_record_that_claims_the_world_is_refused() {
        let mut bytes = mcap::MAGIC.to_vec();
        bytes.push(op::SCHEMA);
        bytes.extend(u64::MAX.to_le_bytes());
        assert!(matches!(read(&bytes), (0, Some(LogError::TooLarge { .. }))));
    }

    #[test]
    fn a_stored_chunk_whose_record_is_longer_than_it_is_survived() {
        let mut chunk = vec![0; 16];
        chunk.extend(9u64.to_le_bytes()); // unpacked
        chunk.extend([0; 8]); // CRC, compression ""
        chunk.extend(9u64.to_le_bytes()); // packed
        chunk.push(op::MESSAGE);
        chunk.extend(1000u64.to_le_bytes());
        let mut bytes = mcap::MAGIC.to_vec();
        bytes.push(op::CHUNK);
        bytes.extend((chunk.len() as u64).to_le_bytes());
        bytes.extend(chunk);
        assert!(matches!(read(&bytes), (0, Some(LogError::Truncated { .. }))));
    }

    proptest! {
        #[test]
        fn damage_is_never_a_panic(at in 0usize..3000, value: u8, cut in 0usize..6000) {
            let mut bytes = log(2);
            let len = bytes.len();
            bytes[at % len] = value;
            bytes.truncate(cut.max(8).min(len));
            let (good, _) = read(&bytes);
            prop_assert!(good <= 4);
        }
    }
}
