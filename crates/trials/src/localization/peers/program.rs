//! A program of one's own, which gets what the robot sees as lines of JSON.

use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{self, Receiver, Sender};
use std::thread;
use std::time::Duration;

use openbench_core::{Pose2, Start};
use openbench_localization::registration::Stretch;
use openbench_osm::OsmMap;
use serde::{Deserialize, Serialize};

use super::peer::{Peer, PeerError, bounds, guess, walls};

/// The longest time for an answer.
const PATIENCE: Duration = Duration::from_secs(60);
/// The longest answer, bytes.
const LONGEST: u64 = 4096;
/// A pose is at most so many standard deviations off.
const DEVIATIONS: f64 = 3.0;

/// What a program gets, one line each. It answers each with a line.
#[derive(Debug, Serialize)]
#[serde(rename_all = "snake_case")]
enum Request<'a> {
    /// Once, before all stretches; the answer may be any line.
    Begin {
        /// Walls of the map's buildings: x, y of both ends in `map`, metres.
        walls: &'a [[f64; 4]],
        /// The most likely start, x, y, yaw. Without a known heading yaw is 0.
        guess: [f64; 3],
        /// Whether the heading is known.
        knows_heading: bool,
        /// The start is not farther than this from the guess, metres.
        within_m: f64,
    },
    /// What was seen on the next five metres; the answer is a [`Reply`].
    Stretch {
        /// Pose of the robot at the end, in the frame of odometry.
        end: [f64; 3],
        /// Points of facades, in the frame of odometry.
        facades: Vec<[f64; 2]>,
    },
}

/// What it answers to a stretch.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Reply {
    /// Pose of the robot at the end, in `map`.
    pose: [f64; 3],
}

/// Asks a program. It is stopped when this is dropped.
pub(super) struct Program {
    path: PathBuf,
    process: Child,
    requests: Sender<String>,
    answers: Receiver<std::io::Result<String>>,
}

impl Program {
    /// Starts a program for one drive on a map, from a start.
    ///
    /// # Errors
    /// [`PeerError`]: it cannot be started, or does not answer.
    pub(super) fn new(path: &Path, map: &OsmMap, start: &Start) -> Result<Self, PeerError> {
        let broken = |source| PeerError::Program {
            path: path.to_owned(),
            source,
        };
        let mut process = Command::new(path)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(broken)?;
        // Both were asked for above.
        let pipes = process.stdin.take().zip(process.stdout.take());
        let (input, output) = pipes.ok_or_else(|| broken(std::io::ErrorKind::BrokenPipe.into()))?;
        let (requests, answers) = converse(input, output);
        let program = Self {
            path: path.to_owned(),
            process,
            requests,
            answers,
        };
        let walls = walls(map);
        let ends = walls.iter();
        let ends = ends.map(|wall| [wall.start.x, wall.start.y, wall.end.x, wall.end.y]);
        program.ask(&Request::Begin {
            walls: &ends.collect::<Vec<_>>(),
            guess: numbers(guess(map, start)),
            knows_heading: start.pose().is_some(),
            within_m: reach(map, start),
        })?;
        Ok(program)
    }

    fn ask(&self, request: &Request<'_>) -> Result<String, PeerError> {
        let broken = |source| PeerError::Program {
            path: self.path.clone(),
            source,
        };
        let line = serde_json::to_string(request).map_err(|error| broken(error.into()))?;
        let ended = || broken(std::io::ErrorKind::BrokenPipe.into());
        self.requests.send(line).map_err(|_| ended())?;
        match self.answers.recv_timeout(PATIENCE) {
            Ok(answer) => answer.map_err(broken),
            Err(mpsc::RecvTimeoutError::Timeout) => {
                Err(broken(std::io::ErrorKind::TimedOut.into()))
            }
            Err(mpsc::RecvTimeoutError::Disconnected) => Err(ended()),
        }
    }
}

impl Peer for Program {
    fn take(&mut self, stretch: &Stretch) -> Result<Pose2, PeerError> {
        let facades = stretch.facades.iter();
        let answer = self.ask(&Request::Stretch {
            end: numbers(stretch.end),
            facades: facades.map(|one| [one.at.x, one.at.y]).collect(),
        })?;
        let reply: Reply = serde_json::from_str(&answer).map_err(|source| PeerError::Answer {
            path: self.path.clone(),
            answer: answer.trim_end().chars().take(80).collect(),
            source,
        })?;
        let [x, y, yaw] = reply.pose;
        Ok(Pose2::new(x, y, yaw))
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        // It may have ended by itself.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Writes lines and reads answers in a thread of its own, so that a program that does not read or
/// answer can be given up.
fn converse(
    mut input: impl Write + Send + 'static,
    output: impl Read + Send + 'static,
) -> (Sender<String>, Receiver<std::io::Result<String>>) {
    let (requests, to_write) = mpsc::channel::<String>();
    let (to_answer, answers) = mpsc::channel();
    thread::spawn(move || {
        let mut output = BufReader::new(output);
        for request in to_write {
            let answer = writeln!(input, "{request}")
                .and_then(|()| input.flush())
                .and_then(|()| line_of(&mut output));
            if to_answer.send(answer).is_err() {
                break;
            }
        }
    });
    (requests, answers)
}

fn line_of(output: &mut impl BufRead) -> std::io::Result<String> {
    let mut line = String::new();
    output.take(LONGEST).read_line(&mut line)?;
    if line.ends_with('\n') {
        Ok(line)
    } else {
        // The program ended, or its answer is too long.
        Err(std::io::ErrorKind::UnexpectedEof.into())
    }
}

/// How far from the guess the start may be, metres.
fn reach(map: &OsmMap, start: &Start) -> f64 {
    match start {
        Start::Pose { covariance, .. } => {
            DEVIATIONS * (covariance[0][0] + covariance[1][1]).max(0.0).sqrt()
        }
        Start::Area { radius_m, .. } => *radius_m,
        Start::Anywhere => bounds(map).map_or(0.0, |all| {
            0.5 * libm::hypot(all.high.x - all.low.x, all.high.y - all.low.y)
        }),
    }
}

const fn numbers(pose: Pose2) -> [f64; 3] {
    [pose.x, pose.y, pose.yaw]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_answer_is_one_line_of_limited_length() {
        assert_eq!(line_of(&mut "{}\n[]\n".as_bytes()).unwrap(), "{}\n");
        assert!(line_of(&mut "no end".as_bytes()).is_err());
        let endless = "x".repeat(2 * LONGEST as usize) + "\n";
        assert!(line_of(&mut endless.as_bytes()).is_err());
    }
}
