//! How well an agent knows where it starts.

use openbench_core::frames::wrap_angle;
use openbench_core::{MapPoint, Pose2, Start};
use openbench_sim::noise::Noise;
use serde::{Deserialize, Serialize};

use super::level::{Condition, check_ranges};

/// Stream of random numbers, distinct from those of sensors, traffic and fixes.
const RANDOM_STREAM: u64 = 33;
/// Largest error of a start that is given as a pose, and largest radius, metres.
const MOST_M: f64 = 10_000.0;

/// How well an agent knows where it starts.
///
/// ```
/// use openbench_bench::suite::StartErrors;
/// use openbench_core::{Pose2, Start};
///
/// let errors = StartErrors { position_m: 5.0, yaw_deg: 20.0, ..StartErrors::default() };
/// let Start::Pose { covariance, .. } = errors.draw(Pose2::default(), 7) else { unreachable!() };
/// assert_eq!(covariance[0][0], 25.0);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StartErrors {
    /// Error of the given position, standard deviation along each axis, metres.
    pub position_m: f64,
    /// Error of the given heading, standard deviation, degrees.
    pub yaw_deg: f64,
    /// Radius of the disc that is given instead of a pose, metres; 0 for a pose.
    pub area_m: f64,
    /// Whether nothing is given.
    pub anywhere: bool,
}

impl StartErrors {
    const EXACT: Self = Self {
        position_m: 0.0,
        yaw_deg: 0.0,
        area_m: 0.0,
        anywhere: false,
    };

    const fn within(position_m: f64) -> Self {
        Self {
            position_m,
            yaw_deg: 20.0,
            ..Self::EXACT
        }
    }

    /// What the briefing says about the true pose at the start.
    pub fn draw(&self, pose: Pose2, seed: u64) -> Start {
        let mut noise = Noise::new(seed, RANDOM_STREAM);
        if self.is_off() {
            // Without the rounding of errors that are zero.
            Start::exact(pose)
        } else if self.anywhere {
            Start::Anywhere
        } else if self.area_m > 0.0 {
            Start::Area {
                centre: self.centre(pose.point(), &mut noise),
                radius_m: self.area_m,
            }
        } else {
            self.pose(pose, &mut noise)
        }
    }

    /// The middle of a disc in which the start is as likely at one place as at another.
    fn centre(&self, at: MapPoint, noise: &mut Noise) -> MapPoint {
        let direction = noise.uniform() * std::f64::consts::TAU;
        at.offset(direction, self.area_m * noise.uniform().sqrt())
    }

    fn pose(&self, pose: Pose2, noise: &mut Noise) -> Start {
        let yaw_rad = self.yaw_deg.to_radians();
        let east = self.position_m * noise.normal();
        let north = self.position_m * noise.normal();
        let turn = yaw_rad * noise.normal();
        let variances = [
            self.position_m * self.position_m,
            self.position_m * self.position_m,
            yaw_rad * yaw_rad,
        ];
        let mut covariance = [[0.0; 3]; 3];
        for (axis, variance) in variances.into_iter().enumerate() {
            covariance[axis][axis] = variance;
        }
        Start::Pose {
            pose: Pose2::new(pose.x + east, pose.y + north, wrap_angle(pose.yaw + turn)),
            covariance,
        }
    }
}

impl Condition for StartErrors {
    const KEY: &'static str = "start";
    const LEVELS: &'static [(&'static str, Self)] = &[
        ("exact", Self::EXACT),
        ("5m", Self::within(5.0)),
        ("10m", Self::within(10.0)),
        (
            "block",
            Self {
                area_m: 75.0,
                ..Self::EXACT
            },
        ),
        (
            "map",
            Self {
                anywhere: true,
                ..Self::EXACT
            },
        ),
    ];

    fn check(&self) -> Result<(), String> {
        let numbers = [
            ("position_m", self.position_m, MOST_M),
            ("yaw_deg", self.yaw_deg, 180.0),
            ("area_m", self.area_m, MOST_M),
        ];
        check_ranges(&numbers)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const AT: Pose2 = Pose2::new(10.0, -20.0, 3.0);

    #[test]
    fn an_exact_start_is_the_true_pose() {
        assert_eq!(StartErrors::EXACT.draw(AT, 3), Start::exact(AT));
    }

    #[test]
    fn errors_have_the_covariance_that_agents_are_told() {
        let errors = StartErrors::within(5.0);
        let (mut squares, mut turns) = (0.0, 0.0);
        for seed in 0..2000 {
            let start = errors.draw(AT, seed).pose().unwrap();
            squares += (start.x - AT.x) * (start.x - AT.x);
            let turn = wrap_angle(start.yaw - AT.yaw);
            turns += turn * turn;
        }
        let deviation = (squares / 2000.0_f64).sqrt();
        assert!((deviation - 5.0).abs() < 0.3, "{deviation}");
        let degrees = (turns / 2000.0_f64).sqrt().to_degrees();
        assert!((degrees - 20.0).abs() < 1.5, "{degrees}");
    }

    #[test]
    fn a_disc_holds_the_start_anywhere_in_it() {
        let errors = StartErrors {
            area_m: 75.0,
            ..StartErrors::EXACT
        };
        let distances: Vec<f64> = (0..2000)
            .map(|seed| match errors.draw(AT, seed) {
                Start::Area { centre, radius_m } => centre.distance(AT.point()) / radius_m,
                other => panic!("{other:?}"),
            })
            .collect();
        assert!(distances.iter().all(|d| *d <= 1.0));
        // Half of the area is within 71 % of the radius.
        let inner = distances.iter().filter(|d| **d < 0.5_f64.sqrt()).count();
        assert!((900..1100).contains(&inner), "{inner}");
    }
}
