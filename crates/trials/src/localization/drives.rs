//! Drives that are recorded once, so that the robot can be localized on them in many maps.

use std::ops::ControlFlow;
use std::time::Duration;

use openbench_bench::run::threads;
use openbench_bench::{BenchError, Prepared};
use openbench_core::{LidarScan, Pose2};
use openbench_localization::registration::estimate::Measured;
use openbench_localization::registration::locator::Locator;
use openbench_localization::registration::stretch::{FIRST_SCANS, STRETCH_M};
use openbench_localization::registration::{Gatherer, Stretch};
use openbench_localization::{LidarInertial, Localizer, Track};
use serde::{Deserialize, Serialize};

use super::labels::{Labels, TrueLabels};
use super::mixed_seed;
use crate::tour::{STANDSTILL, Style, Tour, drive};

/// Usual length of a drive, metres.
pub const DRIVE_M: f64 = 60.0;
/// A tour has several drives, if they are no longer than this together, metres.
const TOUR_M: f64 = 600.0;
/// Half a metre in a second, with stops now and then: seconds for each metre.
const SECONDS_PER_M: f64 = 2.25;

/// What was seen on a stretch, and where that was in truth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    /// What the LiDAR saw, in the frame of odometry.
    pub stretch: Stretch,
    /// True pose of the robot at its end.
    pub truth: Pose2,
}

/// What is recorded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Recording {
    /// Length of each drive, metres.
    pub metres: f64,
    /// How many drives.
    pub count: usize,
    /// How facades are distinguished from other surfaces.
    pub labels: Labels,
    /// Seed of the way and of noise.
    pub seed: u64,
}

/// A drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Drive {
    /// The first half second, as if the robot had been switched on there.
    pub first: Seen,
    /// What comes after it, five metres each.
    pub legs: Vec<Seen>,
}

/// What a robot is shown at a moment of a drive.
#[derive(Debug, Clone, Copy)]
pub struct Shown<'a> {
    /// What it sees.
    pub seen: &'a Seen,
    /// Whether that is the first look, before it drives.
    pub is_first: bool,
    /// Metres driven.
    pub metres: f64,
}

impl Drive {
    /// Pose of the robot in the frame of odometry when it begins.
    pub fn start(&self) -> Pose2 {
        self.first.stretch.end
    }

    /// What the robot is shown: a first look, then each leg.
    pub fn shown(&self) -> Vec<Shown<'_>> {
        let first = Shown {
            seen: &self.first,
            is_first: true,
            metres: 0.0,
        };
        let mut metres = 0.0;
        let legs = self.legs.iter().map(|seen| {
            metres += seen.stretch.metres;
            Shown {
                seen,
                is_first: false,
                metres,
            }
        });
        [first].into_iter().chain(legs).collect()
    }
}

impl Shown<'_> {
    /// Shows it to a locator; gives what that says about the pose, if one is accepted.
    pub fn to(&self, locator: &mut Locator) -> Option<Measured> {
        if self.is_first {
            locator.look(&self.seen.stretch)
        } else {
            locator.take(self.seen.stretch.clone())
        }
    }
}

/// Records drives through a world, on tours along doors in random order. All tours begin at the
/// start of the world, and drives of one tour have no metre in common. Drives do not depend on the
/// number of threads, and the first ones not on their number. In heavy traffic they may be fewer.
///
/// # Errors
/// A world in which a robot cannot drive.
pub fn record(
    prepared: &Prepared,
    what: &Recording,
    threads: usize,
) -> Result<Vec<Drive>, BenchError> {
    let mut drives = Vec::new();
    let of_tour = ((TOUR_M / what.metres) as usize).max(1);
    let mut tours = 0;
    // Traffic makes some tours shorter than others.
    let most = 3 * what.count.div_ceil(of_tour);
    while drives.len() < what.count && tours < most {
        let missing = what.count - drives.len();
        let next = tours + missing.div_ceil(of_tour);
        let one = |number: usize| {
            let own = Recording {
                seed: mixed_seed(what.seed, number as u64),
                count: (missing - (number - tours) * of_tour).min(of_tour),
                ..*what
            };
            tour(prepared, &own, of_tour)
        };
        let recorded = threads::each(tours..next, threads, one, Ok::<_, BenchError>)?;
        drives.extend(recorded.into_iter().flatten());
        tours = next;
    }
    Ok(drives)
}

/// The drives of one tour, for which a robot has the time of `of_tour` drives.
fn tour(prepared: &Prepared, what: &Recording, of_tour: usize) -> Result<Vec<Drive>, BenchError> {
    let seconds = SECONDS_PER_M * what.metres * of_tour as f64;
    let tour = Tour {
        time: STANDSTILL + Duration::from_secs_f64(seconds),
        via: Vec::new(),
        style: Style::Smooth,
        seed: what.seed,
        standstill: STANDSTILL,
    };
    let truth = TrueLabels::new(prepared.stage.caster(), prepared.robot.lidar);
    let mut labeller = Labeller {
        labels: what.labels,
        truth,
    };
    let mut odometry = LidarInertial::new(prepared.robot.clone());
    odometry.reset(Pose2::default());
    let mut recorder = DriveRecorder::new(prepared, what.metres);
    drive(prepared, &tour, &mut |simulator, _| {
        let observation = simulator.observation();
        odometry.update(&observation);
        labeller
            .truth
            .observe(observation.time, simulator.base_link());
        if let (Some(scan), true) = (observation.scan, odometry.ready()) {
            let gathered = labeller.gather(&mut recorder.gatherer, scan, &odometry);
            recorder.add(gathered, Pose2::from_pose3(&simulator.base_link()));
        }
        Ok(if recorder.drives.len() < what.count {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        })
    })?;
    Ok(recorder.drives)
}

/// Gathers scans with the labels that are asked for.
struct Labeller<'a> {
    labels: Labels,
    truth: TrueLabels<'a>,
}

impl Labeller<'_> {
    fn gather(
        &self,
        gatherer: &mut Gatherer,
        scan: &LidarScan,
        track: &dyn Track,
    ) -> Option<Stretch> {
        match self.labels {
            Labels::Geometry => gatherer.take(scan, track),
            Labels::Truth => {
                gatherer.take_labelled(scan, &|index| self.truth.facade(scan, index), track)
            }
        }
    }
}

/// Gathers drives of the same length, one after another.
struct DriveRecorder {
    gatherer: Gatherer,
    /// Legs of a drive.
    legs: usize,
    /// Scans of the drive.
    scans: u16,
    /// The drive that has begun, once the robot has looked around.
    begun: Option<Drive>,
    drives: Vec<Drive>,
}

impl DriveRecorder {
    fn new(prepared: &Prepared, metres: f64) -> Self {
        Self {
            gatherer: Gatherer::new(prepared.robot.lidar),
            legs: ((metres / STRETCH_M) as usize).max(1),
            scans: 0,
            begun: None,
            drives: Vec::new(),
        }
    }

    /// After a scan, which may have ended a stretch; `truth` is where the robot is.
    fn add(&mut self, ended: Option<Stretch>, truth: Pose2) {
        self.scans = self.scans.saturating_add(1);
        match (&mut self.begun, ended) {
            (None, _) if self.scans == FIRST_SCANS => {
                let first = self.gatherer.end().map(|stretch| Seen { stretch, truth });
                self.begun = first.map(|first| Drive {
                    first,
                    legs: Vec::new(),
                });
            }
            (Some(drive), Some(stretch)) => {
                drive.legs.push(Seen { stretch, truth });
                if drive.legs.len() == self.legs {
                    self.drives.extend(self.begun.take());
                    self.scans = 0;
                }
            }
            _ => {}
        }
    }
}
