//! What benchmark and policy say to each other.
//!
//! A message is a MessagePack map with one key, the name of a variant below in snake case:
//! `{"act": {"time": 50000000, ...}}`; one without content is its name alone: `"want_scan"`. The
//! benchmark sends [`Request`]s, the policy [`Reply`]s, and says [`Reply::Hello`] before all else.
//!
//! | benchmark | policy answers |
//! |---|---|
//! | `begin` | `ready`, `refuse` or `failed` |
//! | `act` | `action` or `failed`; before, at most one `want_scan` and one `want_image` |
//! | `scan`, `image` | what it answers to `act` |
//! | `finish` | `finished` or `failed` |
//!
//! Scans and images are sent only when they are wanted, since an image has a megabyte.

use std::sync::Arc;

use openbench_core::{
    Action, Address, Briefing, GiveUp, GnssFix, Goal, Health, Image, ImuSample, LidarPoint,
    LidarScan, MapPoint, Observation, Pose2, RobotDescription, SimTime, Start, WheelSample,
};
use serde::{Deserialize, Serialize};
use serde_bytes::ByteBuf;

/// Version of the protocol, which both sides name.
pub const PROTOCOL: u32 = 1;

/// What the benchmark says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Request {
    /// An episode begins, with a policy that has forgotten the one before.
    Begin(Box<Begin>),
    /// The data since the last observation. What to do until the next one?
    Act(Act),
    /// The scan of this observation, if it has one.
    Scan(Option<Scan>),
    /// The image of this instant, if the camera has one.
    Image(Option<Picture>),
    /// The episode has ended.
    Finish,
}

/// What a policy says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Reply {
    /// First of all.
    Hello(Hello),
    /// Briefing read.
    Ready {
        /// What the policy reports for the log.
        #[serde(default)]
        reports: Vec<Report>,
    },
    /// The policy gives up the whole episode before its first step.
    Refuse(GiveUp),
    /// Sends the scan of this observation.
    WantScan,
    /// Sends the image of this instant.
    WantImage,
    /// What to do until the next observation.
    Action {
        /// The decision.
        action: Action,
        /// What the policy reports for the log.
        #[serde(default)]
        reports: Vec<Report>,
    },
    /// The episode is closed.
    Finished {
        /// The policy's copy of the map with its edits, OSM XML.
        #[serde(default)]
        map: Option<ByteBuf>,
    },
    /// The policy failed with an error of its own.
    Failed {
        /// The error, for people.
        detail: String,
    },
}

/// Who speaks.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// [`PROTOCOL`] of the policy's side.
    pub protocol: u32,
    /// Name and version of the program, for errors.
    pub program: String,
}

/// A [`Briefing`] and a seed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Begin {
    /// Seed of all random numbers of the policy in this episode.
    pub seed: u64,
    /// What to do.
    pub goal: Errand,
    /// The public map, OSM XML.
    pub map: ByteBuf,
    /// Projection and origin of the `map` frame.
    pub georeference: openbench_core::Georeference,
    /// Pose of the robot in `map`; none if it is not given.
    pub start: Option<Pose2>,
    /// Covariance of that pose's x, y and yaw: m², m rad, rad². Zero for an exact pose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_covariance: Option<[[f64; 3]; 3]>,
    /// The disc in which the robot starts, with any heading, instead of a pose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start_area: Option<Disc>,
    /// Sizes, sensors and limits of the robot.
    pub robot: RobotDescription,
    /// Simulated time that a delivery may take at most, seconds.
    pub time_limit_s: f64,
}

/// A disc on the ground, in `map`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Disc {
    /// Its middle: east, metres.
    pub x: f64,
    /// North, metres.
    pub y: f64,
    /// Its radius, metres.
    pub radius_m: f64,
}

/// A [`Goal`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Errand {
    /// Deliver as this instruction says.
    Instruction(String),
    /// Drive to the place at which this image was taken.
    Image(Picture),
    /// Drive to a point in `map`.
    Point(MapPoint),
}

/// The small part of an [`Observation`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Act {
    /// Simulated time now.
    pub time: SimTime,
    /// IMU samples since the last observation, oldest first.
    pub imu: Vec<ImuSample>,
    /// Wheel samples since the last observation, oldest first.
    pub wheels: Vec<WheelSample>,
    /// The satellite fix, if the robot got one.
    pub gnss: Option<GnssFix>,
    /// Whether there is a scan.
    pub has_scan: bool,
}

/// A [`LidarScan`] as columns, little-endian, one entry a point.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Scan {
    /// When the first ray was cast.
    pub stamp: SimTime,
    /// Positions in `livox_frame`, metres: three `f32` a point.
    pub xyz: ByteBuf,
    /// Nanoseconds from the stamp to each point: `u32`.
    pub offset_ns: ByteBuf,
    /// Reflectivity of each point: `u8`.
    pub reflectivity: ByteBuf,
    /// Laser line of each point: `u8`.
    pub line: ByteBuf,
}

/// An [`Image`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Picture {
    /// When it was exposed.
    pub stamp: SimTime,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Rows from the top, three bytes a pixel.
    pub rgb: ByteBuf,
}

/// What a policy reports for the log, as an [`Event`](openbench_core::Event).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Report {
    /// The deliveries that it understood from its instruction, in driving order.
    Plan(Vec<Address>),
    /// Work on a delivery begins.
    Task(Address),
    /// A route over roads, in `map`.
    Route(Vec<MapPoint>),
    /// The path that is being followed, in `map`.
    Path(Vec<MapPoint>),
    /// Where it takes itself to be, in `map`.
    Pose {
        /// Pose of `base_link`.
        pose: Pose2,
        /// How far it can be trusted.
        #[serde(default)]
        health: Health,
    },
    /// A plate was read in the last image.
    Plate {
        /// The text as read.
        text: String,
        /// Confidence, 0 to 1.
        confidence: f32,
        /// Corners of the text in pixels, clockwise from its top left.
        corners: [[f32; 2]; 4],
        /// Estimated position of the plate in `map`.
        #[serde(default)]
        position: Option<MapPoint>,
    },
    /// A door was added to its map.
    Door {
        /// The door's address.
        address: Address,
        /// Position of the door in `map`.
        position: MapPoint,
    },
    /// Anything else.
    Note(String),
}

impl Begin {
    /// The message of a briefing.
    pub fn new(briefing: &Briefing, seed: u64) -> Self {
        Self {
            seed,
            goal: match &briefing.goal {
                Goal::Instruction(text) => Errand::Instruction(text.clone()),
                Goal::Image(image) => Errand::Image(Picture::from(image)),
                Goal::Point(point) => Errand::Point(*point),
            },
            map: ByteBuf::from(briefing.map_osm.clone()),
            georeference: briefing.georeference,
            start: briefing.start.pose(),
            start_covariance: match briefing.start {
                Start::Pose { covariance, .. } => Some(covariance),
                Start::Area { .. } | Start::Anywhere => None,
            },
            start_area: match briefing.start {
                Start::Area { centre, radius_m } => Some(Disc {
                    x: centre.x,
                    y: centre.y,
                    radius_m,
                }),
                Start::Pose { .. } | Start::Anywhere => None,
            },
            robot: briefing.robot.clone(),
            time_limit_s: briefing.time_limit.as_secs_f64(),
        }
    }
}

impl From<&Observation<'_>> for Act {
    fn from(observation: &Observation<'_>) -> Self {
        Self {
            time: observation.time,
            imu: observation.imu.to_vec(),
            wheels: observation.wheels.to_vec(),
            gnss: observation.gnss.copied(),
            has_scan: observation.scan.is_some(),
        }
    }
}

impl From<&LidarScan> for Scan {
    fn from(scan: &LidarScan) -> Self {
        let column = |bytes: fn(&LidarPoint) -> u8| {
            let bytes: Vec<u8> = scan.points.iter().map(bytes).collect();
            ByteBuf::from(bytes)
        };
        let xyz = scan.points.iter().flat_map(|point| point.xyz);
        let offsets = scan.points.iter().map(|point| point.offset_ns);
        Self {
            stamp: scan.stamp,
            xyz: ByteBuf::from(xyz.flat_map(f32::to_le_bytes).collect::<Vec<u8>>()),
            offset_ns: ByteBuf::from(offsets.flat_map(u32::to_le_bytes).collect::<Vec<u8>>()),
            reflectivity: column(|point| point.reflectivity),
            line: column(|point| point.line),
        }
    }
}

impl From<&Image> for Picture {
    fn from(image: &Image) -> Self {
        Self {
            stamp: image.stamp,
            width: image.width,
            height: image.height,
            rgb: ByteBuf::from(image.rgb.clone()),
        }
    }
}

impl From<Arc<Image>> for Picture {
    fn from(image: Arc<Image>) -> Self {
        Self::from(image.as_ref())
    }
}

impl Reply {
    /// Its name in the protocol.
    pub const fn name(&self) -> &'static str {
        match self {
            Self::Hello(_) => "hello",
            Self::Ready { .. } => "ready",
            Self::Refuse(_) => "refuse",
            Self::WantScan => "want_scan",
            Self::WantImage => "want_image",
            Self::Action { .. } => "action",
            Self::Finished { .. } => "finished",
            Self::Failed { .. } => "failed",
        }
    }
}
