//! Odometry made worse: a drive as a robot would see it whose odometry drifts.

use openbench_core::Pose2;
use openbench_sim::noise::Noise;

use super::drives::{Drive, Seen};

/// Stream of random numbers, distinct from those of sensors.
const RANDOM_STREAM: u64 = 37;
/// A walk of the heading by this many radians on each leg, for each unit of drift, leads as far
/// aside on 100 m as the drift leads astray along them: twenty legs of five metres, whose lever
/// arms have a root of the sum of squares of 268 m.
const TURN_PER_DRIFT: f64 = 100.0 / 268.0;

/// The same drive with an odometry that errs by a share of the way: each leg is longer by it, and
/// the heading walks at random. Odometry knows how much, not in which direction. What is seen on a
/// leg, seen from its end, stays the same.
#[must_use]
pub fn drifting(drive: &Drive, share: f64, seed: u64) -> Drive {
    let mut noise = Noise::new(seed, RANDOM_STREAM);
    let mut before = drive.start();
    let mut drifted = before;
    let legs = drive.legs.iter().map(|leg| {
        let end = leg.stretch.end;
        let motion = end.seen_from(before);
        let turn = TURN_PER_DRIFT * share * noise.normal();
        drifted = drifted.compose(Pose2::new(
            motion.x * (1.0 + share),
            motion.y * (1.0 + share),
            motion.yaw + turn,
        ));
        before = end;
        // From the frame of the odometry to that of the worse one.
        let by = drifted.compose(Pose2::default().seen_from(end));
        let mut leg = moved(leg, by);
        let along = share * libm::hypot(motion.x, motion.y);
        let turned = TURN_PER_DRIFT * share;
        for (i, error) in [along, along, turned].into_iter().enumerate() {
            leg.stretch.drift[i][i] += error * error;
        }
        leg
    });
    Drive {
        first: drive.first.clone(),
        legs: legs.collect(),
    }
}

fn moved(seen: &Seen, by: Pose2) -> Seen {
    Seen {
        stretch: seen.stretch.moved(by),
        truth: seen.truth,
    }
}

#[cfg(test)]
mod tests {
    use openbench_localization::registration::Stretch;

    use super::*;

    /// Straight ahead, five metres a leg.
    fn straight(legs: usize) -> Drive {
        let seen = |x: f64| Seen {
            stretch: Stretch {
                end: Pose2::new(x, 0.0, 0.0),
                metres: 5.0,
                drift: [[0.0; 3]; 3],
                facades: Vec::new(),
                panoramas: Vec::new(),
            },
            truth: Pose2::new(x, 0.0, 0.0),
        };
        Drive {
            first: seen(0.0),
            legs: (1..=legs).map(|i| seen(5.0 * i as f64)).collect(),
        }
    }

    #[test]
    fn odometry_errs_along_and_across_by_the_share_of_a_hundred_metres() {
        let drive = straight(20);
        assert_eq!(drifting(&drive, 0.0, 1), drive);
        let ends = (0..400).map(|seed| {
            let drifted = drifting(&drive, 0.01, seed);
            let last = drifted.legs.last().expect("it has legs");
            assert_eq!((last.truth.x, drifted.start().x), (100.0, 0.0));
            last.stretch.end
        });
        let ends: Vec<Pose2> = ends.collect();
        let count = ends.len() as f64;
        let along = ends.iter().map(|end| end.x - 100.0).sum::<f64>() / count;
        let across = (ends.iter().map(|end| end.y * end.y).sum::<f64>() / count).sqrt();
        assert!((along - 1.0).abs() < 0.1, "{along}");
        assert!((across - 1.0).abs() < 0.15, "{across}");
    }
}
