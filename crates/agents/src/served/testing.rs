//! Parts of tests.

use std::collections::VecDeque;
use std::sync::Arc;

use openbench_core::{Image, Pose2, RobotDescription, SimTime, Velocity};

use super::error::ServerError;
use super::question::{Answer, Episode, Question, Server};

/// A server with scripted answers.
pub struct Script {
    answers: VecDeque<Result<Answer, ServerError>>,
}

impl Script {
    pub fn new(answers: impl IntoIterator<Item = Result<Answer, ServerError>>) -> Self {
        Self {
            answers: answers.into_iter().collect(),
        }
    }
}

impl Server for Script {
    fn reach(&mut self) -> Result<(), ServerError> {
        Ok(())
    }

    fn begin(&mut self, _: &Episode) -> Result<(), ServerError> {
        Ok(())
    }

    fn ask(&mut self, _: &Question) -> Result<Answer, ServerError> {
        let closed = ServerError::Closed {
            detail: "the script is over".into(),
        };
        self.answers.pop_front().unwrap_or(Err(closed))
    }
}

/// An image of two pixels.
pub fn image() -> Arc<Image> {
    Arc::new(Image {
        stamp: SimTime::ZERO,
        width: 2,
        height: 1,
        rgb: vec![1, 2, 3, 4, 5, 6],
    })
}

pub fn episode() -> Episode {
    Episode {
        words: "box to unit 1".into(),
        has_point: false,
        robot: RobotDescription::sentry(),
        seed: 7,
    }
}

pub fn question(number: u64) -> Question {
    Question {
        image: image(),
        words: "box to unit 1".into(),
        goal: None,
        pose: Pose2::new(1.0, 2.0, 0.5),
        velocity: Velocity::new(0.1, 0.0),
        number,
        depth: None,
    }
}
