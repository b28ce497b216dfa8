//! What a policy server is asked, and what it answers.

use std::io::Read;
use std::sync::Arc;
use std::time::Duration;

use openbench_core::{Image, MapPoint, Pose2, RobotDescription, Velocity};
use openbench_models::sha256_of;
use serde::{Deserialize, Serialize};

use super::depth::DepthImage;
use super::error::ServerError;
use super::limits::{MAX_PERIOD_S, MAX_ROWS, MIN_PERIOD_S};

/// An episode that begins.
#[derive(Debug, Clone, PartialEq)]
pub struct Episode {
    /// What to do, in words: the instruction, or a sentence that says where the point is.
    pub words: String,
    /// Whether the robot is to drive to a point.
    pub has_point: bool,
    /// The robot.
    pub robot: RobotDescription,
    /// Seed of the policy's random numbers.
    pub seed: u64,
}

/// What the robot senses at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// Image of the camera.
    pub image: Arc<Image>,
    /// As [`Episode::words`].
    pub words: String,
    /// Goal in `base_link`, x forward and y to the left, metres: if it is a point.
    pub goal: Option<MapPoint>,
    /// Pose in `odom`, whose origin is the start of the episode, by the robot's own odometry.
    pub pose: Pose2,
    /// Velocity that was commanded last.
    pub velocity: Velocity,
    /// How many questions of the episode came before.
    pub number: u64,
    /// Depths out of LiDAR scans, for servers that want them.
    pub depth: Option<DepthImage>,
}

impl Question {
    /// Pose and velocity as a row: x, y, yaw, linear, angular.
    pub fn state(&self) -> [f64; 5] {
        let Pose2 { x, y, yaw } = self.pose;
        let Velocity { linear, angular } = self.velocity;
        [x, y, yaw, linear, angular]
    }

    /// SHA-256 of all that is in it, in hexadecimal digits; without depths, which follow from the
    /// scans.
    ///
    /// # Errors
    /// None in fact: memory can be read.
    pub fn digest(&self) -> std::io::Result<String> {
        let goal = self.goal.map_or([f64::NAN; 2], |goal| [goal.x, goal.y]);
        let numbers = goal.into_iter().chain(self.state());
        let sizes = [self.image.width, self.image.height, self.words.len() as u32];
        let mut small = self.number.to_le_bytes().to_vec();
        small.extend(sizes.into_iter().flat_map(u32::to_le_bytes));
        small.extend(numbers.flat_map(f64::to_le_bytes));
        small.extend(self.words.as_bytes());
        sha256_of(small.as_slice().chain(&self.image.rgb[..]))
    }
}

/// What a policy wants the robot to do.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// One velocity after the other.
    Velocities {
        /// How long each lasts, seconds.
        period_s: f64,
        /// The velocities.
        steps: Vec<Step>,
    },
    /// Points to pass, in the order of driving, in `base_link` at the instant of the question.
    Path {
        /// The points, metres.
        points: Vec<MapPoint>,
        /// How long the drive along them takes, seconds; `None`: as the robot likes.
        lasts_s: Option<f64>,
    },
}

impl Answer {
    /// Whether its times and numbers can be driven, and it is no longer than an answer may be. What
    /// comes from a server does; a recording may have been changed.
    pub fn is_sound(&self) -> bool {
        match self {
            Self::Velocities { period_s, steps } => {
                (MIN_PERIOD_S..=MAX_PERIOD_S).contains(period_s)
                    && steps.len() <= MAX_ROWS
                    && steps.iter().all(|step| is_finite(step.velocity))
            }
            Self::Path { points, lasts_s } => {
                let lasts = lasts_s.unwrap_or(MIN_PERIOD_S);
                (MIN_PERIOD_S..=MAX_PERIOD_S * MAX_ROWS as f64).contains(&lasts)
                    && points.len() <= MAX_ROWS
                    && points.iter().all(|p| p.x.is_finite() && p.y.is_finite())
            }
        }
    }
}

fn is_finite(velocity: Velocity) -> bool {
    velocity.linear.is_finite() && velocity.angular.is_finite()
}

/// A velocity of an answer.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// The velocity.
    pub velocity: Velocity,
    /// Whether the parcel is delivered here, instead of driving.
    pub declares: bool,
}

/// An answer and the wall time that it took.
#[derive(Debug, Clone, PartialEq)]
pub struct Timed {
    /// The answer.
    pub answer: Answer,
    /// From the question to the answer.
    pub took: Duration,
}

/// A policy behind a server.
pub trait Server: Send {
    /// Checks that the server can be reached.
    ///
    /// # Errors
    /// [`ServerError`].
    fn reach(&mut self) -> Result<(), ServerError>;

    /// Begins an episode: the policy forgets the one before.
    ///
    /// # Errors
    /// [`ServerError`]; the server is of no use for this episode.
    fn begin(&mut self, episode: &Episode) -> Result<(), ServerError>;

    /// Whether questions should have a depth image.
    fn wants_depth(&self) -> bool {
        false
    }

    /// Asks what to do.
    ///
    /// # Errors
    /// As [`begin`](Self::begin).
    fn ask(&mut self, question: &Question) -> Result<Answer, ServerError>;

    /// Ends the episode. What fails here changes nothing any more.
    fn end(&mut self) {}
}

#[cfg(test)]
mod tests {
    use super::super::testing::question;
    use super::*;

    #[test]
    fn the_digest_depends_on_everything_that_is_asked() {
        let mut others = vec![question(3); 7];
        others[0].number = 4;
        others[1].words.push('!');
        others[2].goal = Some(MapPoint::new(1.0, 0.0));
        others[3].pose.yaw = 0.25;
        others[4].velocity.angular = 0.1;
        Arc::make_mut(&mut others[5].image).rgb[5] = 7;
        let image = Arc::make_mut(&mut others[6].image);
        (image.width, image.height) = (1, 2);
        let digest = question(3).digest().unwrap();
        assert_eq!(digest, question(3).digest().unwrap());
        for other in others {
            assert_ne!(other.digest().unwrap(), digest, "{other:?}");
        }
    }
}
