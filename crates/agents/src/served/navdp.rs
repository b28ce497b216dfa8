//! Servers of NavDP: steps over HTTP, each with an image, a depth image and a goal.
//!
//! `navigator_reset` begins an episode; `pointgoal_step` answers the trajectory that its critic
//! prefers, in metres from the camera, x forward and y to the left. The server keeps the images of
//! an episode, so it serves one robot at a time.

use std::io::{Cursor, Read};
use std::time::Duration;

use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder};
use openbench_core::{Image, MapPoint, with_causes};
use serde::Deserialize;
use serde_json::json;
use ureq::Agent;

use super::address::Address;
use super::arrays::{Array, Rows};
use super::depth::DepthImage;
use super::error::ServerError;
use super::limits::{MAX_ANSWER_BYTES, shown};
use super::question::{Answer, Episode, Question, Server};
use super::settings::Settings;
use super::turns::{Turn, Turns};
use super::websocket;

/// What an address looks like.
pub(super) const EXAMPLE: &str = "navdp:http://127.0.0.1:8888";
/// Quality of images, as OpenCV has it by default.
const JPEG_QUALITY: u8 = 95;
/// Units of a depth in a metre.
const DEPTH_SCALE: f32 = 10_000.0;
/// A trajectory whose value is lower is replaced by a turn on the spot: the client's own default.
const STOP_THRESHOLD: f64 = -0.5;
/// A trajectory that ends nearer than this to where it begins means to stand, metres.
const STAYS_M: f64 = 0.05;
/// Boundary of the parts of a request. No image contains it but by a chance of 2^-200.
const BOUNDARY: &str = "openbench-3f6c1d0a9be84752a1d7c2e85b904f1e";

/// A policy of NavDP.
pub struct NavDp {
    address: Address,
    settings: Settings,
    turns: Turns,
    turn: Option<Turn>,
    /// Distance of the camera before `base_link`, metres.
    camera_ahead: f64,
}

impl NavDp {
    /// The server at `http://HOST:PORT`, which is not asked yet; `turns` are those of all its
    /// episodes.
    ///
    /// # Errors
    /// [`ServerError::Address`].
    pub fn new(address: &str, settings: Settings, turns: Turns) -> Result<Self, ServerError> {
        Ok(Self {
            address: Address::parse(address, "http", EXAMPLE)?,
            settings,
            turns,
            turn: None,
            camera_ahead: 0.0,
        })
    }

    /// Sends a request and returns its answer.
    fn post(
        &self,
        step: &str,
        kind: &str,
        body: Vec<u8>,
        within: Duration,
    ) -> Result<Vec<u8>, ServerError> {
        let config = Agent::config_builder()
            .timeout_global(Some(within))
            .max_redirects(0)
            // What the server says of an error is in the body.
            .http_status_as_error(false)
            // Policy servers stand in the own network.
            .proxy(None);
        let agent = config.build().new_agent();
        let base = self.address.url();
        let endpoint = format!("{}/{step}", base.trim_end_matches('/'));
        let failed = |error: ureq::Error| match error {
            ureq::Error::Timeout(_) => ServerError::Silent { within },
            ureq::Error::Io(error) if error.kind() == std::io::ErrorKind::TimedOut => {
                ServerError::Silent { within }
            }
            error => ServerError::Unreachable {
                address: self.address.host_and_port(),
                detail: shown(&with_causes(&error)),
            },
        };
        let request = agent.post(&endpoint).header("content-type", kind);
        let mut response = request.send(&body[..]).map_err(failed)?;
        let mut answer = Vec::new();
        let reader = response.body_mut().as_reader();
        // A byte more than allowed shows that there are more.
        let read = reader
            .take(MAX_ANSWER_BYTES as u64 + 1)
            .read_to_end(&mut answer);
        read.map_err(|error| failed(error.into()))?;
        if answer.len() > MAX_ANSWER_BYTES {
            return Err(ServerError::TooLong);
        }
        let status = response.status();
        if !status.is_success() {
            let text = shown(&String::from_utf8_lossy(&answer));
            return Err(ServerError::Reported {
                detail: format!("{status}: {text}"),
            });
        }
        Ok(answer)
    }
}

impl Server for NavDp {
    fn reach(&mut self) -> Result<(), ServerError> {
        // No request is without consequences, so that a connection has to do.
        websocket::connect(&self.address, self.settings.patience.begin).map(|_| ())
    }

    fn begin(&mut self, episode: &Episode) -> Result<(), ServerError> {
        if !episode.has_point {
            return Err(ServerError::Goal {
                server: "NavDP",
                takes: "points",
            });
        }
        // The turn before ends first: nobody waits for himself.
        self.turn = None;
        self.turn = Some(self.turns.wait());
        self.camera_ahead = episode.robot.camera.translation.x;
        let camera = episode.robot.camera_intrinsics;
        let focal = camera.focal_length();
        let (middle_x, middle_y) = (
            f64::from(camera.width) / 2.0,
            f64::from(camera.height) / 2.0,
        );
        let reset = json!({
            "intrinsic": [[focal, 0.0, middle_x], [0.0, focal, middle_y], [0.0, 0.0, 1.0]],
            "stop_threshold": STOP_THRESHOLD,
            "batch_size": 1,
        });
        let body = reset.to_string().into_bytes();
        let within = self.settings.patience.begin;
        self.post("navigator_reset", "application/json", body, within)?;
        Ok(())
    }

    fn wants_depth(&self) -> bool {
        true
    }

    fn ask(&mut self, question: &Question) -> Result<Answer, ServerError> {
        if self.turn.is_none() {
            return Err(ServerError::not_begun());
        }
        let goal = question.goal.unwrap_or_default();
        let goal = json!({"goal_x": [goal.x - self.camera_ahead], "goal_y": [goal.y]});
        let mut form = Form::default();
        form.file("image", "image.jpg", "image/jpeg", &jpeg(&question.image)?);
        let depth = question.depth.as_ref();
        let depth = depth.ok_or_else(|| ServerError::unreadable("there is no depth image"))?;
        form.file("depth", "depth.png", "image/png", &png(depth)?);
        form.field("goal_data", &goal.to_string());
        let within = self.settings.within(question);
        let answer = self.post("pointgoal_step", &Form::kind(), form.end(), within)?;
        let points = trajectory(&answer)?;
        let mut answer = self.settings.answer(&points)?;
        if let Answer::Path { points, .. } = &mut answer {
            let stays = |point: &MapPoint| point.distance(MapPoint::default()) < STAYS_M;
            if points.iter().all(stays) {
                // The camera stays where it is, and so does the robot.
                points.clear();
            }
            for point in points {
                point.x += self.camera_ahead;
            }
        }
        Ok(answer)
    }

    fn end(&mut self) {
        self.turn = None;
    }
}

/// The first trajectory of an answer.
fn trajectory(answer: &[u8]) -> Result<Rows, ServerError> {
    #[derive(Deserialize)]
    struct Trajectories {
        trajectory: Vec<Vec<Vec<f64>>>,
    }
    let read: Result<Trajectories, _> = serde_json::from_slice(answer);
    let read = read.map_err(|error| {
        // Python writes these words, which JSON has not.
        let has = |word: &str| {
            answer
                .windows(word.len())
                .any(|part| part == word.as_bytes())
        };
        let cause = if has("NaN") || has("Infinity") {
            "; it contains NaN or infinity"
        } else {
            ""
        };
        ServerError::unreadable(format!("{}{cause}", shown(&error.to_string())))
    })?;
    let points = read.trajectory.into_iter().next().unwrap_or_default();
    let columns = points.first().map_or(0, Vec::len);
    if points.iter().any(|point| point.len() != columns) {
        return Err(ServerError::unreadable(
            "the points of its trajectory differ in length",
        ));
    }
    Rows::of(Array::new(vec![points.len(), columns], points.concat()))
}

/// A form with files.
#[derive(Default)]
struct Form {
    bytes: Vec<u8>,
}

impl Form {
    fn kind() -> String {
        format!("multipart/form-data; boundary={BOUNDARY}")
    }

    fn part(&mut self, head: &str, content: &[u8]) {
        let head = format!("--{BOUNDARY}\r\ncontent-disposition: form-data; {head}\r\n\r\n");
        self.bytes.extend(head.as_bytes());
        self.bytes.extend(content);
        self.bytes.extend(b"\r\n");
    }

    fn file(&mut self, name: &str, file: &str, kind: &str, content: &[u8]) {
        let head = format!("name=\"{name}\"; filename=\"{file}\"\r\ncontent-type: {kind}");
        self.part(&head, content);
    }

    fn field(&mut self, name: &str, text: &str) {
        self.part(&format!("name=\"{name}\""), text.as_bytes());
    }

    fn end(mut self) -> Vec<u8> {
        self.bytes.extend(format!("--{BOUNDARY}--\r\n").as_bytes());
        self.bytes
    }
}

/// An image as JPEG with red and blue exchanged: the protocol's clients write RGB as if it were
/// BGR, and its servers change it back.
fn jpeg(image: &Image) -> Result<Vec<u8>, ServerError> {
    let pixels = image.rgb.chunks_exact(3);
    let exchanged: Vec<u8> = pixels.flat_map(|rgb| [rgb[2], rgb[1], rgb[0]]).collect();
    let mut bytes = Vec::new();
    let encoder = image::codecs::jpeg::JpegEncoder::new_with_quality(&mut bytes, JPEG_QUALITY);
    encoder
        .write_image(
            &exchanged,
            image.width,
            image.height,
            ExtendedColorType::Rgb8,
        )
        .map_err(|error| ServerError::unreadable(error.to_string()))?;
    Ok(bytes)
}

/// Depths as PNG with 16 bits, in tenths of a millimetre.
fn png(depth: &DepthImage) -> Result<Vec<u8>, ServerError> {
    let units = depth
        .metres
        .iter()
        .map(|metres| (metres * DEPTH_SCALE) as u16);
    // The encoder takes numbers as this machine has them.
    let bytes: Vec<u8> = units.flat_map(u16::to_ne_bytes).collect();
    let mut png = Cursor::new(Vec::new());
    PngEncoder::new_with_quality(&mut png, CompressionType::Fast, FilterType::Up)
        .write_image(
            &bytes,
            depth.width as u32,
            depth.height as u32,
            ExtendedColorType::L16,
        )
        .map_err(|error| ServerError::unreadable(error.to_string()))?;
    Ok(png.into_inner())
}

#[cfg(test)]
mod tests {
    use super::super::testing::image;
    use super::*;

    #[test]
    fn of_a_batch_the_first_trajectory_counts() {
        let answer =
            br#"{"all_values": [[1.5]], "trajectory": [[[0.25, 0.0, 0.1], [0.5, 0.1, 0]]]}"#;
        let rows = trajectory(answer).unwrap();
        let points = rows.with_columns(3, "x, y, z").unwrap();
        assert_eq!(
            points.collect::<Vec<_>>(),
            [[0.25, 0.0, 0.1], [0.5, 0.1, 0.0]]
        );
    }

    #[test]
    fn what_is_no_trajectory_is_refused() {
        for (answer, expected) in [
            ("{}", "trajectory"),
            ("<html>", "expected value"),
            (r#"{"trajectory": [[[NaN, 1]]]}"#, "contains NaN"),
            (r#"{"trajectory": []}"#, "no actions"),
            (r#"{"trajectory": [[[1, 2], [1]]]}"#, "differ in length"),
            (r#"{"trajectory": [[[1e999, 1]]]}"#, "out of range"),
        ] {
            let error = trajectory(answer.as_bytes()).unwrap_err().to_string();
            assert!(error.contains(expected), "{answer}: {error}");
        }
    }

    #[test]
    fn depths_are_tenths_of_millimetres_and_far_ones_the_largest() {
        let depth = DepthImage {
            width: 3,
            height: 1,
            metres: vec![0.0, 1.5, 50.0],
        };
        let image = image::load_from_memory(&png(&depth).unwrap()).unwrap();
        assert_eq!(image.into_luma16().into_raw(), [0, 15_000, 65_535]);
    }

    #[test]
    fn red_and_blue_are_exchanged() {
        let mut red = (*image()).clone();
        (red.width, red.height, red.rgb) = (16, 16, [250, 0, 10].repeat(256));
        let decoded = image::load_from_memory(&jpeg(&red).unwrap())
            .unwrap()
            .into_rgb8();
        let [r, _, b] = decoded.get_pixel(8, 8).0;
        assert!(r < 30 && b > 230, "{r} {b}");
    }
}
