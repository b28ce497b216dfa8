//! Writing typed topics to an MCAP file.
//!
//! The first message on a topic opens its channel. Chunks are compressed with zstd on the caller's
//! thread, so that the bytes depend only on the messages. Log and publish time are simulated time.

use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{BufWriter, Seek, Write};
use std::path::{Path, PathBuf};

use mcap::records::MessageHeader;
use openbench_core::SimTime;

use crate::cdr::CdrWriter;
use crate::error::LogError;
use crate::messages::{Definition, Message};

/// The library that the file names; without a version, so that bytes do not depend on one.
const LIBRARY: &str = "openbench";

/// Writes messages to topics of one MCAP file.
pub struct LogWriter<W: Write + Seek> {
    mcap: mcap::Writer<W>,
    topics: BTreeMap<String, Topic>,
    message: CdrWriter,
}

struct Topic {
    channel: u16,
    definition: &'static Definition,
    messages: u32,
}

impl<W: Write + Seek> LogWriter<W> {
    /// Begins a file in `out`.
    ///
    /// # Errors
    /// [`LogError::Write`].
    pub fn new(out: W) -> Result<Self, LogError> {
        let options = mcap::WriteOptions::new()
            .profile("ros2")
            .library(LIBRARY)
            .compression(Some(mcap::Compression::Zstd))
            .compression_level(1)
            .compression_threads(0);
        Ok(Self {
            mcap: options.create(out)?,
            topics: BTreeMap::new(),
            message: CdrWriter::new(),
        })
    }

    /// Writes a message. The first message on a topic determines its type.
    ///
    /// # Errors
    /// [`LogError::WrongType`], [`LogError::Write`].
    pub fn write<M: Message>(
        &mut self,
        topic: &str,
        time: SimTime,
        message: &M,
    ) -> Result<(), LogError> {
        self.write_on(topic, time, message, "")
    }

    /// Writes a message that holds until the next one on its topic. The topic is marked transient
    /// local, so that a later subscriber gets the last message, too.
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_lasting<M: Message>(
        &mut self,
        topic: &str,
        time: SimTime,
        message: &M,
    ) -> Result<(), LogError> {
        self.write_on(topic, time, message, LASTING)
    }

    fn write_on<M: Message>(
        &mut self,
        topic: &str,
        time: SimTime,
        message: &M,
        quality: &str,
    ) -> Result<(), LogError> {
        // Before encoding: a message of a wrong type leaves no trace.
        let header = self.next_header(topic, time, M::DEFINITION, quality)?;
        self.message.clear();
        message.encode(&mut self.message);
        Ok(self
            .mcap
            .write_to_known_channel(&header, self.message.as_bytes())?)
    }

    fn next_header(
        &mut self,
        topic: &str,
        time: SimTime,
        definition: &'static Definition,
        quality: &str,
    ) -> Result<MessageHeader, LogError> {
        // Not `entry`: that needs an owned name for each message.
        let open = match self.topics.get_mut(topic) {
            Some(open) => open,
            None => {
                let channel = open_channel(&mut self.mcap, topic, definition, quality)?;
                let open = Topic {
                    channel,
                    definition,
                    messages: 0,
                };
                self.topics.entry(topic.to_owned()).or_insert(open)
            }
        };
        if open.definition != definition {
            return Err(LogError::WrongType {
                topic: topic.to_owned(),
                found: open.definition.full_name(),
                wanted: definition.name,
            });
        }
        let sequence = open.messages;
        // MCAP stores sequence numbers in 32 bits.
        open.messages = sequence.wrapping_add(1);
        Ok(MessageHeader {
            channel_id: open.channel,
            sequence,
            log_time: time.0,
            publish_time: time.0,
        })
    }

    /// Writes the summary, which ends the file, and returns the sink.
    ///
    /// # Errors
    /// [`LogError::Write`].
    pub fn finish(mut self) -> Result<W, LogError> {
        self.mcap.finish()?;
        Ok(self.mcap.into_inner())
    }
}

fn open_channel<W: Write + Seek>(
    mcap: &mut mcap::Writer<W>,
    topic: &str,
    definition: &Definition,
    quality: &str,
) -> Result<u16, LogError> {
    let schema = mcap.add_schema(
        &definition.full_name(),
        "ros2msg",
        definition.schema().as_bytes(),
    )?;
    // The ros2 profile requires this key; empty stands for the defaults of the middleware.
    let metadata = BTreeMap::from([("offered_qos_profiles".to_owned(), quality.to_owned())]);
    Ok(mcap.add_channel(schema, topic, "cdr", &metadata)?)
}

/// How a topic is offered whose last message holds: reliable and transient local, as rosbag2 writes
/// it.
const LASTING: &str = "\
- history: 1
  depth: 1
  reliability: 1
  durability: 1
  deadline:
    sec: 9223372036
    nsec: 854775807
  lifespan:
    sec: 9223372036
    nsec: 854775807
  liveliness: 1
  liveliness_lease_duration:
    sec: 9223372036
    nsec: 854775807
  avoid_ros_namespace_conventions: false
";

/// A log on disk.
///
/// It is written to `NAME.partial` and renamed when it is complete, so that a file named `NAME` is
/// always complete.
///
/// ```
/// use openbench_core::SimTime;
/// use openbench_logs::messages::StringMessage;
/// use openbench_logs::{LogFile, LogReader};
///
/// let folder = tempfile::tempdir()?;
/// let mut log = LogFile::create(folder.path().join("run.mcap"))?;
/// log.write("/note", SimTime::from_millis(50), &StringMessage("unit2 delivered".into()))?;
/// let path = log.finish()?;
///
/// let mut notes = LogReader::open(path)?.messages::<StringMessage>("/note");
/// let (time, note) = notes.next().unwrap()?;
/// assert_eq!((time.0, note.0.as_str()), (50_000_000, "unit2 delivered"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct LogFile {
    log: LogWriter<BufWriter<File>>,
    partial: PathBuf,
    path: PathBuf,
}

impl LogFile {
    /// Begins a log that [`LogFile::finish`] puts at `path`.
    ///
    /// # Errors
    /// [`LogError::File`], [`LogError::Write`].
    pub fn create(path: impl Into<PathBuf>) -> Result<Self, LogError> {
        let path = path.into();
        let mut name = path.clone().into_os_string();
        name.push(".partial");
        let partial = PathBuf::from(name);
        let file = File::create(&partial).map_err(at(&partial))?;
        Ok(Self {
            log: LogWriter::new(BufWriter::new(file))?,
            partial,
            path,
        })
    }

    /// Writes a message. The first message on a topic determines its type.
    ///
    /// # Errors
    /// [`LogError::WrongType`], [`LogError::Write`].
    pub fn write<M: Message>(
        &mut self,
        topic: &str,
        time: SimTime,
        message: &M,
    ) -> Result<(), LogError> {
        self.log.write(topic, time, message)
    }

    /// Writes a message that holds until the next one on its topic, see
    /// [`LogWriter::write_lasting`].
    ///
    /// # Errors
    /// As [`write`](Self::write).
    pub fn write_lasting<M: Message>(
        &mut self,
        topic: &str,
        time: SimTime,
        message: &M,
    ) -> Result<(), LogError> {
        self.log.write_lasting(topic, time, message)
    }

    /// Completes the log, renames it and returns its path.
    ///
    /// # Errors
    /// [`LogError::File`], [`LogError::Write`].
    pub fn finish(self) -> Result<PathBuf, LogError> {
        let buffer = self.log.finish()?;
        buffer
            .into_inner()
            // `into_inner` writes what is left in the buffer. Dropping it would hide an error.
            .map_err(|e| at(&self.partial)(e.into_error()))?;
        // In one folder, where a rename replaces the file in one step.
        fs::rename(&self.partial, &self.path).map_err(at(&self.path))?;
        Ok(self.path)
    }
}

fn at(path: &Path) -> impl FnOnce(std::io::Error) -> LogError {
    let path = path.to_owned();
    move |source| LogError::File { path, source }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::messages::{Header, PoseStamped, StringMessage};
    use openbench_core::Pose2;
    use std::io::Cursor;

    fn sample() -> Vec<u8> {
        let mut log = LogWriter::new(Cursor::new(Vec::new())).unwrap();
        for i in 0..5 {
            let time = SimTime::from_millis(50 * i);
            let pose = Pose2::new(i as f64, 0.0, 0.0).into();
            log.write(
                "/pose",
                time,
                &PoseStamped {
                    header: Header::new(time, "map"),
                    pose,
                },
            )
            .unwrap();
            log.write("/note", time, &StringMessage(format!("step {i}")))
                .unwrap();
        }
        log.finish().unwrap().into_inner()
    }

    #[test]
    fn equal_messages_give_equal_bytes() {
        let bytes = sample();
        assert_eq!(bytes, sample());
        let text = String::from_utf8_lossy(&bytes);
        assert!(
            !text.contains("mcap-rust"),
            "the version of a library must not be in the file"
        );
    }

    #[test]
    fn a_topic_has_one_type() {
        let mut log = LogWriter::new(Cursor::new(Vec::new())).unwrap();
        log.write("/a", SimTime::ZERO, &StringMessage("x".into()))
            .unwrap();
        let error = log
            .write("/a", SimTime::ZERO, &Header::default())
            .unwrap_err()
            .to_string();
        assert_eq!(
            error,
            "topic `/a` has type std_msgs/msg/String, not std_msgs/Header"
        );
    }

    #[test]
    fn the_file_exists_once_it_is_complete() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("run.mcap");
        let mut log = LogFile::create(&path).unwrap();
        log.write("/a", SimTime::ZERO, &StringMessage("x".into()))
            .unwrap();
        assert!(!path.exists());
        assert_eq!(log.finish().unwrap(), path);
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn the_error_for_a_missing_folder_names_the_path() {
        let error = LogFile::create("/nonexistent/run.mcap")
            .err()
            .unwrap()
            .to_string();
        assert!(error.contains("/nonexistent/run.mcap"), "{error}");
    }
}
