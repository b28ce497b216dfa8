//! Drives that are recorded once, so that the robot can be localized on them in many maps.

use std::time::Duration;

use openbench_bench::run::threads;
use openbench_bench::{BenchError, Prepared};
use openbench_core::{LidarScan, Pose2};
use openbench_localization::registration::estimate::Measured;
use openbench_localization::registration::locator::Locator;
use openbench_localization::registration::{Gatherer, Stretch, stretch::STRETCH_M};
use openbench_localization::{LidarInertial, Localizer, Track};
use serde::{Deserialize, Serialize};

use super::labels::{Labels, TrueLabels};
use crate::tour::{STANDSTILL, Style, Tour, drive};

/// Usual length of a drive, metres.
pub const DRIVE_M: f64 = 60.0;
/// A tour has several drives, if they are no longer than this together, metres.
const TOUR_M: f64 = 600.0;
/// Half a metre in a second, with stops now and then: seconds for each metre.
const SECONDS_PER_M: f64 = 2.25;
/// A first look consists of so many scans.
const FIRST_SCANS: usize = 5;

/// What was seen on a stretch, and where that was in truth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Seen {
    /// What the LiDAR saw, in the frame of odometry.
    pub stretch: Stretch,
    /// True pose of the robot at its end.
    pub truth: Pose2,
}

/// Five metres of a drive.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Leg {
    /// Its first half second, as if the robot had been switched on there.
    pub first: Seen,
    /// All of it.
    pub whole: Seen,
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
    /// Its legs, in their order.
    pub legs: Vec<Leg>,
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
        self.legs
            .first()
            .map_or(Pose2::default(), |leg| leg.first.stretch.end)
    }

    /// What the robot is shown: a first look, then each leg.
    pub fn shown(&self) -> Vec<Shown<'_>> {
        let first = self.legs.first().map(|leg| Shown {
            seen: &leg.first,
            is_first: true,
            metres: 0.0,
        });
        let mut metres = 0.0;
        let wholes = self.legs.iter().map(|leg| {
            metres += leg.whole.stretch.metres;
            Shown {
                seen: &leg.whole,
                is_first: false,
                metres,
            }
        });
        first.into_iter().chain(wholes).collect()
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

/// Records drives through a world, on tours along doors in random order. Drives have no metre in
/// common. They do not depend on the number of threads, and the first ones not on their number. In
/// heavy traffic they may be fewer.
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
    // Traffic makes some tours shorter than others.
    for round in 0..3 {
        let missing = what.count - drives.len();
        let tours = missing.div_ceil(of_tour);
        let one = |i: usize| {
            let number = round * 1000 + i as u64;
            let own = Recording {
                seed: what.seed.wrapping_mul(1_000_000).wrapping_add(number),
                count: (missing - i * of_tour).min(of_tour),
                ..*what
            };
            tour(prepared, &own)
        };
        let recorded = threads::each(0..tours, threads, one, Ok::<_, BenchError>)?;
        drives.extend(recorded.into_iter().flatten().take(missing));
    }
    Ok(drives)
}

/// The drives of one tour.
fn tour(prepared: &Prepared, what: &Recording) -> Result<Vec<Drive>, BenchError> {
    let seconds = SECONDS_PER_M * what.metres * what.count as f64;
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
    let mut legs = Vec::new();
    let mut recorder = LegRecorder::new(prepared);
    drive(prepared, &tour, &mut |simulator, _| {
        let observation = simulator.observation();
        odometry.update(&observation);
        labeller
            .truth
            .observe(observation.time, simulator.base_link());
        if let (Some(scan), true) = (observation.scan, odometry.ready()) {
            let truth = Pose2::from_pose3(&simulator.base_link());
            let gathered = labeller.gather(&mut recorder.whole, scan, &odometry);
            if recorder.scans < FIRST_SCANS {
                recorder.scans += 1;
                labeller.gather(&mut recorder.first, scan, &odometry);
                if recorder.scans == FIRST_SCANS {
                    let stretch = recorder.first.unfinished();
                    recorder.seen = stretch.map(|stretch| Seen { stretch, truth });
                }
            }
            if let Some(stretch) = gathered {
                let whole = Seen { stretch, truth };
                legs.extend(recorder.seen.take().map(|first| Leg { first, whole }));
                recorder = LegRecorder::new(prepared);
            }
        }
        Ok(())
    })?;
    let drives = legs.chunks_exact(((what.metres / STRETCH_M) as usize).max(1));
    Ok(drives
        .map(|legs| Drive {
            legs: legs.to_vec(),
        })
        .collect())
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

/// Gathers one leg.
struct LegRecorder {
    whole: Gatherer,
    first: Gatherer,
    scans: usize,
    seen: Option<Seen>,
}

impl LegRecorder {
    fn new(prepared: &Prepared) -> Self {
        let gatherer = Gatherer::new(prepared.robot.lidar);
        Self {
            whole: gatherer.clone(),
            first: gatherer,
            scans: 0,
            seen: None,
        }
    }
}
