//! Answers of a server that are recorded, or repeated from a recording.
//!
//! A recording has a line of JSON for each answer: the SHA-256 of the question, the answer or the
//! error, and the wall time that it took. Answers are repeated in their order, each to its own
//! question only.

use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::time::{Duration, Instant};

use openbench_core::{FailureCause, with_causes};
use openbench_models::Exchanges;
use serde::{Deserialize, Serialize};

use super::error::ServerError;
use super::question::{Answer, Episode, Question, Server, Timed};

/// Limit of the length of a recording, bytes.
const MAX_RECORDING_BYTES: u64 = 256 << 20;
/// What is recorded as the question where an episode begins.
const BEGIN: &str = "begin";

/// A line of a recording.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct Exchange {
    /// SHA-256 of the question, or [`BEGIN`].
    question: String,
    outcome: Outcome,
    took_us: u64,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
enum Outcome {
    Begun,
    Answer(Answer),
    Error { cause: FailureCause, detail: String },
}

/// Where answers come from.
enum Source {
    /// A server, whose answers may be recorded.
    Server(Box<dyn Server>, Option<File>),
    /// A recording.
    Recording(std::vec::IntoIter<Exchange>),
}

/// A server, or what one answered earlier.
pub struct Recorded {
    source: Source,
}

impl Recorded {
    /// The answers of a server, or those in the recording that `exchanges` name.
    ///
    /// # Errors
    /// [`ServerError::Recording`].
    pub fn new(exchanges: &Exchanges, server: Box<dyn Server>) -> Result<Self, ServerError> {
        let source = match exchanges {
            Exchanges::Unkept => Source::Server(server, None),
            Exchanges::Keep(path) => {
                let file = File::create(path).map_err(|error| unusable(path, &error))?;
                Source::Server(server, Some(file))
            }
            Exchanges::Repeat(path) => {
                let exchanges = read(path).map_err(|error| unusable(path, &error))?;
                Source::Recording(exchanges.into_iter())
            }
        };
        Ok(Self { source })
    }

    /// As [`Server::begin`].
    ///
    /// # Errors
    /// Those of the server.
    pub fn begin(&mut self, episode: &Episode) -> Result<(), ServerError> {
        let begin = |server: &mut dyn Server| match server.begin(episode) {
            Ok(()) => Ok(Outcome::Begun),
            Err(error) => Err(error),
        };
        self.exchange(BEGIN.to_owned(), begin).map(|_| ())
    }

    /// As [`Server::ask`], with the time that it takes.
    ///
    /// # Errors
    /// Those of the server; of a recording also that this is not the question that was recorded.
    pub fn ask(&mut self, question: &Question) -> Result<Timed, ServerError> {
        let digest = question.digest().map_err(|error| ServerError::Recording {
            detail: error.to_string(),
        })?;
        let ask = |server: &mut dyn Server| server.ask(question).map(Outcome::Answer);
        match self.exchange(digest, ask)? {
            (Outcome::Answer(answer), took) => Ok(Timed { answer, took }),
            _ => Err(differs()),
        }
    }

    /// As [`Server::wants_depth`]; a recording wants none.
    pub fn wants_depth(&self) -> bool {
        match &self.source {
            Source::Server(server, _) => server.wants_depth(),
            Source::Recording(_) => false,
        }
    }

    /// As [`Server::end`].
    pub fn end(&mut self) {
        if let Source::Server(server, _) = &mut self.source {
            server.end();
        }
    }

    fn exchange(
        &mut self,
        question: String,
        work: impl FnOnce(&mut dyn Server) -> Result<Outcome, ServerError>,
    ) -> Result<(Outcome, Duration), ServerError> {
        match &mut self.source {
            Source::Server(server, file) => {
                let began = Instant::now();
                let outcome = work(server.as_mut());
                let took_us = began.elapsed().as_micros() as u64;
                let recorded = match &outcome {
                    Ok(outcome) => outcome.clone(),
                    Err(error) => Outcome::Error {
                        cause: error.cause(),
                        detail: with_causes(error),
                    },
                };
                if let Some(file) = file {
                    write(
                        file,
                        &Exchange {
                            question,
                            outcome: recorded,
                            took_us,
                        },
                    )?;
                }
                // As recorded, so that a repetition gets the same.
                outcome.map(|outcome| (outcome, Duration::from_micros(took_us)))
            }
            Source::Recording(exchanges) => {
                let exchange = exchanges.next().filter(|next| next.question == question);
                let Exchange {
                    outcome, took_us, ..
                } = exchange.ok_or_else(differs)?;
                match outcome {
                    Outcome::Error { cause, detail } => {
                        Err(ServerError::Repeated { cause, detail })
                    }
                    outcome => Ok((outcome, Duration::from_micros(took_us))),
                }
            }
        }
    }
}

fn write(file: &mut File, exchange: &Exchange) -> Result<(), ServerError> {
    let line = serde_json::to_vec(exchange).map_err(std::io::Error::from);
    let written = line.and_then(|mut line| {
        line.push(b'\n');
        file.write_all(&line)
    });
    written.map_err(|error| ServerError::Recording {
        detail: format!("the answers of the policy server cannot be recorded: {error}"),
    })
}

fn read(path: &Path) -> std::io::Result<Vec<Exchange>> {
    let file = openbench_core::input::open(path)?;
    let lines = BufReader::new(file.take(MAX_RECORDING_BYTES)).lines();
    lines.map(|line| exchange_of(&line?)).collect()
}

fn exchange_of(line: &str) -> std::io::Result<Exchange> {
    let exchange: Exchange = serde_json::from_str(line).map_err(invalid)?;
    match &exchange.outcome {
        Outcome::Answer(answer) if !answer.is_sound() => {
            Err(invalid("an answer has numbers that no server sends"))
        }
        _ => Ok(exchange),
    }
}

fn invalid(error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> std::io::Error {
    std::io::Error::new(std::io::ErrorKind::InvalidData, error)
}

fn unusable(path: &Path, error: &std::io::Error) -> ServerError {
    ServerError::Recording {
        detail: format!("{}: {error}", path.display()),
    }
}

fn differs() -> ServerError {
    ServerError::Recording {
        detail: "the recorded answers belong to other questions".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::super::testing::{Script, episode, question};
    use super::*;

    fn path() -> Answer {
        Answer::Path {
            points: vec![openbench_core::MapPoint::new(0.1 + 0.2, -1e-9)],
            lasts_s: None,
        }
    }

    fn repeated(path: &Path) -> Recorded {
        // A script that is over: a repetition asks no server.
        let over = Box::new(Script::new([]));
        Recorded::new(&Exchanges::Repeat(path.to_owned()), over).unwrap()
    }

    #[test]
    fn answers_errors_and_times_are_repeated() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("answers.jsonl");
        let silent = ServerError::Silent {
            within: Duration::from_secs(60),
        };
        let script = Script::new([Ok(path()), Err(silent.clone())]);
        let keep = Exchanges::Keep(file.clone());
        let mut recorded = Recorded::new(&keep, Box::new(script)).unwrap();
        recorded.begin(&episode()).unwrap();
        let first = recorded.ask(&question(0)).unwrap();
        assert_eq!(recorded.ask(&question(1)), Err(silent.clone()));

        let mut again = repeated(&file);
        again.begin(&episode()).unwrap();
        assert_eq!(again.ask(&question(0)), Ok(first));
        let error = again.ask(&question(1)).unwrap_err();
        assert_eq!(error.to_string(), silent.to_string());
    }

    #[test]
    fn another_question_gets_no_recorded_answer() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("answers.jsonl");
        let script = Script::new([Ok(path())]);
        let keep = Exchanges::Keep(file.clone());
        let mut recorded = Recorded::new(&keep, Box::new(script)).unwrap();
        recorded.begin(&episode()).unwrap();
        recorded.ask(&question(0)).unwrap();

        let mut again = repeated(&file);
        again.begin(&episode()).unwrap();
        assert_eq!(again.ask(&question(7)), Err(differs()));
    }

    #[test]
    fn a_recording_that_is_none_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("answers.jsonl");
        let path = |lasts: &str| {
            format!(
                r#"{{"question":"q","outcome":{{"answer":{{"path":{{"points":[],"lasts_s":{lasts}}}}}}},"took_us":1}}"#
            )
        };
        let steps = |period: &str| {
            format!(
                r#"{{"question":"q","outcome":{{"answer":{{"velocities":{{"period_s":{period},"steps":[]}}}}}},"took_us":1}}"#
            )
        };
        let opens = |text: &str| {
            std::fs::write(&file, text).unwrap();
            let over = Box::new(Script::new([]));
            Recorded::new(&Exchanges::Repeat(file.clone()), over).map(|_| ())
        };
        for text in [
            "{\"question\":".to_owned(),
            path("-1.0"),
            steps("-1.0"),
            steps("1e300"),
            steps("0.0"),
        ] {
            let error = opens(&text).unwrap_err().to_string();
            assert!(error.contains("answers.jsonl"), "{text}: {error}");
        }
        for text in [path("null"), path("2.4"), steps("0.1")] {
            assert_eq!(opens(&text), Ok(()), "{text}");
        }
    }

    #[test]
    fn what_an_error_meant_is_repeated() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("answers.jsonl");
        let goal = ServerError::Goal {
            server: "NavDP",
            takes: "points",
        };
        let script = Script::new([Err(goal)]);
        let mut recorded = Recorded::new(&Exchanges::Keep(file.clone()), Box::new(script)).unwrap();
        recorded.begin(&episode()).unwrap();
        let first = recorded.ask(&question(0)).unwrap_err();
        let mut again = repeated(&file);
        again.begin(&episode()).unwrap();
        let second = again.ask(&question(0)).unwrap_err();
        assert_eq!(first.cause(), FailureCause::Briefing);
        assert_eq!(
            (second.cause(), second.to_string()),
            (first.cause(), first.to_string())
        );
    }
}
