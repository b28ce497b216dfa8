//! Reading messages from an MCAP file, in file order.
//!
//! A truncated or damaged file yields each message before that place, and then one error. Chunks
//! may be uncompressed or compressed with zstd; LZ4 is refused. The index at the end of the file is
//! not used.

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

/// One message of a log, not yet decoded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LoggedMessage {
    /// Its topic.
    pub topic: Arc<str>,
    /// Full name of its type, such as `geometry_msgs/msg/PoseStamped`; empty if the file lacks it.
    pub type_name: Arc<str>,
    /// Its log time.
    pub time: SimTime,
    /// Its bytes, CDR.
    pub data: Vec<u8>,
}

impl LoggedMessage {
    /// Decodes the message.
    ///
    /// # Errors
    /// [`LogError::WrongType`], [`LogError::Decode`].
    pub fn decode<M: Message>(&self) -> Result<M, LogError> {
        // The name alone: definitions of one type may differ, if only in their comments.
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

/// Iterates over the messages of a log, and ends after the first error.
pub struct LogReader<R> {
    source: R,
    offset: u64,
    schemas: BTreeMap<u16, Arc<str>>,
    channels: BTreeMap<u16, Channel>,
    ready: VecDeque<LoggedMessage>,
    error: Option<LogError>,
    done: bool,
}

/// A topic and its message type.
#[derive(Clone)]
struct Channel {
    topic: Arc<str>,
    /// In full.
    type_name: Arc<str>,
}

impl LogReader<BufReader<File>> {
    /// Opens a file.
    ///
    /// # Errors
    /// [`LogError::File`], [`LogError::Read`], [`LogError::NotMcap`].
    pub fn open(path: impl AsRef<Path>) -> Result<Self, LogError> {
        let path = path.as_ref();
        let file = openbench_core::input::open(path).map_err(|source| LogError::File {
            path: path.to_owned(),
            source,
        })?;
        Self::new(BufReader::new(file))
    }
}

impl<R: Read> LogReader<R> {
    /// Reads from any source.
    ///
    /// # Errors
    /// [`LogError::Read`], [`LogError::NotMcap`].
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

    /// Iterates over the decoded messages of one topic, with their log times.
    pub fn messages<M: Message>(
        self,
        topic: &str,
    ) -> impl Iterator<Item = Result<(SimTime, M), LogError>> {
        let wanted = topic.to_owned();
        // Errors have no topic and pass.
        self.filter(move |m| m.as_ref().map_or(true, |m| *m.topic == *wanted))
            .map(|m| m.and_then(|m| Ok((m.time, m.decode()?))))
    }

    /// Reads one record and queues the messages in it.
    fn advance(&mut self) -> Result<(), LogError> {
        // Errors name where the record begins, not where reading stopped.
        let begin = self.offset;
        match framing::next_frame(&mut self.source, &mut self.offset)? {
            Next::Frame(Frame {
                op: op::DATA_END | op::FOOTER,
                ..
            // Behind the data come the summary and the index, which repeat what was read.
            }) => self.done = true,
            Next::Frame(Frame {
                op: op::CHUNK,
                body,
            }) => self.take_chunk(&body, begin)?,
            Next::Frame(frame) => self.take(&frame, begin)?,
            // A complete file ends with one of the records above.
            Next::End => {
                return Err(LogError::Truncated {
                    offset: begin,
                    what: "file",
                });
            }
            Next::Truncated(Frame {
                op: op::CHUNK,
                body,
            }) => {
                // Its complete records first; `next` returns these messages before the error.
                self.take_chunk(&body, begin)?;
                return Err(LogError::Truncated {
                    offset: begin,
                    what: "chunk",
                });
            }
            Next::Truncated(_) => {
                return Err(LogError::Truncated {
                    offset: begin,
                    what: "record",
                });
            }
        }
        Ok(())
    }

    fn take_chunk(&mut self, chunk: &[u8], offset: u64) -> Result<(), LogError> {
        let unpacked = framing::unpack_chunk(chunk, offset);
        // Records before the damage are good, so they are taken before the error is returned.
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
            // The header, indices, statistics, and records of later versions. MCAP lets readers
            // skip records that they do not know.
            _ => Some(()),
        };
        taken.ok_or_else(|| damaged(offset, "a record is shorter than its fields"))
    }

    fn take_schema(&mut self, mut fields: Fields<'_>) -> Option<()> {
        let id = fields.u16()?;
        self.schemas.insert(id, text(fields.text()?));
        Some(())
    }

    fn take_channel(&mut self, mut fields: Fields<'_>) -> Option<()> {
        let (id, schema) = (fields.u16()?, fields.u16()?);
        // Schema 0 means none. Such messages are read, but only `decode` needs the type.
        let type_name = self.schemas.get(&schema).cloned().unwrap_or_default();
        self.channels.insert(
            id,
            Channel {
                topic: text(fields.text()?),
                type_name,
            },
        );
        Some(())
    }

    fn take_message(&mut self, mut fields: Fields<'_>, offset: u64) -> Result<(), LogError> {
        let head = MessageHead::read(&mut fields)
            .ok_or_else(|| damaged(offset, "a message is shorter than its fields"))?;
        let Some(Channel { topic, type_name }) = self.channels.get(&head.channel).cloned() else {
            return Err(damaged(offset, "a message refers to an undefined channel"));
        };
        let data = fields.rest().to_vec();
        self.ready.push_back(LoggedMessage {
            topic,
            type_name,
            time: head.time,
            data,
        });
        Ok(())
    }
}

/// The fields in front of the bytes of a message.
struct MessageHead {
    channel: u16,
    /// Log time.
    time: SimTime,
}

impl MessageHead {
    fn read(fields: &mut Fields<'_>) -> Option<Self> {
        let channel = fields.u16()?;
        // Sequence number.
        fields.take(4)?;
        let time = SimTime(fields.u64()?);
        // Publish time.
        fields.take(8)?;
        Some(Self { channel, time })
    }
}

fn text(bytes: &[u8]) -> Arc<str> {
    String::from_utf8_lossy(bytes).into()
}

fn damaged(offset: u64, problem: &str) -> LogError {
    LogError::Damaged {
        offset,
        source: problem.into(),
    }
}

impl<R: Read> Iterator for LogReader<R> {
    type Item = Result<LoggedMessage, LogError>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            // Messages before the error, and the error before the end.
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
            // Text that compresses poorly, so that the log has several chunks.
            let noise: String = (0..2000u64)
                .map(|j| char::from(33 + ((i as u64 * 7919 + j * j * 31) % 90) as u8))
                .collect();
            log.write("/note", SimTime(i as u64), &StringMessage(noise))
                .unwrap();
            log.write(
                "/head",
                SimTime(i as u64),
                &Header::new(SimTime(i as u64), "map"),
            )
            .unwrap();
        }
        log.finish().unwrap().into_inner()
    }

    fn read(bytes: &[u8]) -> (usize, Option<LogError>) {
        let Ok(reader) = LogReader::new(bytes) else {
            return (0, Some(LogError::NotMcap));
        };
        let mut error = None;
        let good = reader
            .filter_map(|m| m.map_err(|e| error = Some(e)).ok())
            .count();
        (good, error)
    }

    #[test]
    fn messages_of_a_topic_are_read_back() {
        let bytes = log(3);
        let headers: Result<Vec<_>, _> = LogReader::new(bytes.as_slice())
            .unwrap()
            .messages::<Header>("/head")
            .collect();
        let expected: Vec<_> = (0..3)
            .map(|i| (SimTime(i), Header::new(SimTime(i), "map")))
            .collect();
        assert_eq!(headers.unwrap(), expected);
        let wrong = LogReader::new(bytes.as_slice())
            .unwrap()
            .messages::<StringMessage>("/head")
            .next();
        assert!(matches!(wrong, Some(Err(LogError::WrongType { .. }))));
    }

    #[test]
    fn a_truncated_log_yields_the_messages_before_its_end() {
        let bytes = log(1200);
        let (all, error) = read(&bytes);
        assert!(all == 2400 && error.is_none());
        let (some, error) = read(&bytes[..bytes.len() * 2 / 3]);
        assert!(some > 1200 && some < 2400, "{some}");
        assert!(
            matches!(error, Some(LogError::Truncated { .. })),
            "{error:?}"
        );
    }

    #[test]
    fn other_files_are_refused() {
        assert!(matches!(
            LogReader::new(&b"SQLite format 3\0"[..]),
            Err(LogError::NotMcap)
        ));
        assert!(matches!(LogReader::new(&b""[..]), Err(LogError::NotMcap)));
    }

    #[test]
    fn a_record_of_excessive_length_is_refused() {
        let mut bytes = mcap::MAGIC.to_vec();
        bytes.push(op::SCHEMA);
        bytes.extend(u64::MAX.to_le_bytes());
        assert!(matches!(read(&bytes), (0, Some(LogError::TooLarge { .. }))));
    }

    #[test]
    fn an_uncompressed_chunk_shorter_than_its_record_is_an_error() {
        let mut chunk = vec![0; 16];
        // Unpacked length; CRC and empty compression; packed length.
        chunk.extend(9u64.to_le_bytes());
        chunk.extend([0; 8]);
        chunk.extend(9u64.to_le_bytes());
        chunk.push(op::MESSAGE);
        chunk.extend(1000u64.to_le_bytes());
        let mut bytes = mcap::MAGIC.to_vec();
        bytes.push(op::CHUNK);
        bytes.extend((chunk.len() as u64).to_le_bytes());
        bytes.extend(chunk);
        assert!(matches!(
            read(&bytes),
            (0, Some(LogError::Truncated { .. }))
        ));
    }

    #[test]
    fn a_changed_byte_of_a_chunk_is_noticed_whether_it_is_compressed_or_not() {
        for compression in [None, Some(mcap::Compression::Zstd)] {
            let mut bytes = Cursor::new(Vec::new());
            let options = mcap::WriteOptions::new().compression(compression);
            let mut writer = options.create(&mut bytes).unwrap();
            let channel = writer
                .add_channel(0, "/note", "cdr", &Default::default())
                .unwrap();
            // Bytes that hardly compress, or few would be left of them.
            let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 13) as u8;
            let body: Vec<u8> = (0..300).map(noise).collect();
            for sequence in 0..20 {
                let header = mcap::records::MessageHeader {
                    channel_id: channel,
                    sequence,
                    log_time: u64::from(sequence),
                    publish_time: u64::from(sequence),
                };
                writer.write_to_known_channel(&header, &body).unwrap();
            }
            writer.finish().unwrap();
            drop(writer);
            let mut bytes = bytes.into_inner();
            assert!(matches!(read(&bytes), (20, None)), "{compression:?}");
            bytes[300] ^= 1;
            let (_, error) = read(&bytes);
            assert!(matches!(error, Some(LogError::Damaged { .. })), "{error:?}");
        }
    }

    proptest! {
        #[test]
        fn damaged_logs_do_not_panic(at in 0usize..3000, value: u8, cut in 0usize..6000) {
            let mut bytes = log(2);
            let len = bytes.len();
            bytes[at % len] = value;
            bytes.truncate(cut.max(8).min(len));
            let (good, _) = read(&bytes);
            prop_assert!(good <= 4);
        }
    }
}
