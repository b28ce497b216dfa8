//! A policy in a child process, which speaks the protocol on its standard input and output.

use std::io::{BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError, Sender};
use std::thread;
use std::time::{Duration, Instant};

use super::frame::{frame, read_frame};
use super::link::{Link, LinkError};
use super::message::{Hello, PROTOCOL, Reply, Request};

/// How long a process may take to end by itself when its input is closed.
const TIME_TO_END: Duration = Duration::from_secs(2);

/// A process that speaks the protocol. It is stopped when this is dropped.
pub struct ChildLink {
    process: Child,
    /// Frames to be written; `None` when the process is to end.
    frames: Option<Sender<Vec<u8>>>,
    replies: Receiver<Result<Option<Reply>, LinkError>>,
}

impl ChildLink {
    /// Starts a process and waits for its [`Hello`], no longer than `within`.
    ///
    /// # Errors
    /// [`LinkError`]: the program cannot be started, ended, said nothing, or speaks another
    /// version.
    pub fn start(command: &mut Command, within: Duration) -> Result<Self, LinkError> {
        // A group of its own, so that an interrupt from the terminal ends the run in order first.
        #[cfg(unix)]
        std::os::unix::process::CommandExt::process_group(command, 0);
        let program = command.get_program().to_string_lossy().into_owned();
        let mut process = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| LinkError::ended(&format!("before it began: {program}: {error}")))?;
        let (Some(input), Some(output)) = (process.stdin.take(), process.stdout.take()) else {
            return Err(LinkError::ended("before it began: it has no pipes"));
        };
        let mut link = Self {
            process,
            frames: Some(write_in_background(input)),
            replies: read_in_background(output),
        };
        match link.receive(within)? {
            Reply::Hello(hello) => accept(hello)?,
            Reply::Failed { detail } => return Err(LinkError::CannotBegin { detail }),
            reply => {
                return Err(LinkError::OutOfTurn {
                    said: reply.name(),
                    expected: "hello",
                });
            }
        }
        Ok(link)
    }

    /// How the process ended, for errors.
    fn ended(&mut self) -> LinkError {
        match wait(&mut self.process, TIME_TO_END) {
            Some(status) => LinkError::ended(&format!("({status})")),
            None => LinkError::ended("(it closed its output)"),
        }
    }
}

impl Link for ChildLink {
    fn send(&mut self, request: &Request) -> Result<(), LinkError> {
        let frame = frame(request)?;
        let sent = self.frames.as_ref().map(|frames| frames.send(frame));
        match sent {
            Some(Ok(())) => Ok(()),
            _ => Err(self.ended()),
        }
    }

    fn receive(&mut self, within: Duration) -> Result<Reply, LinkError> {
        match self.replies.recv_timeout(within) {
            Ok(Ok(Some(reply))) => Ok(reply),
            Ok(Ok(None)) | Err(RecvTimeoutError::Disconnected) => Err(self.ended()),
            Ok(Err(error)) => Err(error),
            Err(RecvTimeoutError::Timeout) => Err(LinkError::Silent { within }),
        }
    }
}

impl Drop for ChildLink {
    fn drop(&mut self) {
        // The end of its input tells a process to end.
        drop(self.frames.take());
        if wait(&mut self.process, TIME_TO_END).is_none() {
            // It may have ended by now.
            let _ = self.process.kill();
            let _ = self.process.wait();
        }
    }
}

fn accept(hello: Hello) -> Result<(), LinkError> {
    if hello.protocol == PROTOCOL {
        Ok(())
    } else {
        Err(LinkError::Version {
            program: hello.program,
            theirs: hello.protocol,
            ours: PROTOCOL,
        })
    }
}

/// Reads replies on a thread, since a pipe cannot be read with a time limit.
fn read_in_background(output: ChildStdout) -> Receiver<Result<Option<Reply>, LinkError>> {
    // One message: a process that writes without being asked waits.
    let (sender, replies) = mpsc::sync_channel(1);
    thread::spawn(move || {
        let mut reader = BufReader::new(output);
        loop {
            let reply = read_frame::<Reply>(&mut reader);
            let goes_on = matches!(reply, Ok(Some(_)));
            // The receiver is gone when the link was dropped.
            if sender.send(reply).is_err() || !goes_on {
                break;
            }
        }
    });
    replies
}

/// Writes on a thread: a process that does not read would stop the benchmark.
fn write_in_background(mut input: ChildStdin) -> Sender<Vec<u8>> {
    let (sender, frames) = mpsc::channel::<Vec<u8>>();
    thread::spawn(move || {
        for frame in frames {
            // The process has ended; the link learns it from its replies.
            if input
                .write_all(&frame)
                .and_then(|()| input.flush())
                .is_err()
            {
                break;
            }
        }
    });
    sender
}

/// Waits for the end of a process.
fn wait(process: &mut Child, within: Duration) -> Option<ExitStatus> {
    let began = Instant::now();
    loop {
        match process.try_wait() {
            Ok(Some(status)) => return Some(status),
            Ok(None) if began.elapsed() < within => thread::sleep(Duration::from_millis(2)),
            Ok(None) | Err(_) => return None,
        }
    }
}
