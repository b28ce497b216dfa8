//! Resolution of a band, and the automatic resizing that keeps it.

use super::timed_poses::{TimedPose, Trajectory};
use crate::checks::{SettingsError, positive};
use crate::kinematics::on_arc;

/// Share of the wanted step by which a stretch may be longer or shorter.
const HYSTERESIS: f64 = 0.4;
/// Stretches of new bands often have the wanted length; rounding must not decide how they are
/// divided. Seconds.
const ROUNDING_S: f64 = 1e-9;

/// How finely a band is divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// Duration of the first stretch, seconds.
    pub near: f64,
    /// Duration of stretches far ahead, seconds.
    pub far: f64,
    /// Seconds ahead from which on stretches have that duration.
    pub horizon: f64,
    /// Most poses of a band.
    pub most: usize,
}

impl Default for Resolution {
    fn default() -> Self {
        Self {
            near: 0.1,
            far: 0.3,
            horizon: 2.0,
            most: 150,
        }
    }
}

impl Resolution {
    /// Duration of a stretch that begins `time` seconds ahead, seconds.
    pub(crate) fn step_at(&self, time: f64) -> f64 {
        self.near + (self.far - self.near) * (time / self.horizon).clamp(0.0, 1.0)
    }

    /// Whether a band can be divided like that.
    pub fn check(&self) -> Result<(), SettingsError> {
        time_step("the first time step", self.near)?;
        time_step("the last time step", self.far)?;
        positive("the horizon of time steps", self.horizon)?;
        let value = self.most as f64;
        let enough = (4..=10_000).contains(&self.most);
        let wanted = "between 4 and 10000 are possible";
        if enough {
            Ok(())
        } else {
            Err(SettingsError {
                name: "the number of poses",
                value,
                wanted,
            })
        }
    }
}

impl Trajectory {
    /// Splits stretches that are too long and joins those that are too short.
    pub(crate) fn resize(&mut self, resolution: &Resolution) {
        self.split(resolution);
        self.join(resolution);
    }

    fn split(&mut self, resolution: &Resolution) {
        let mut poses = Vec::with_capacity(self.poses.len() + 8);
        for pair in self.poses.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            poses.push(a);
            while poses.len() < resolution.most {
                let at: TimedPose = poses[poses.len() - 1];
                let step = resolution.step_at(at.time);
                let left = b.time - at.time;
                if left <= (1.0 + HYSTERESIS) * step + ROUNDING_S {
                    break;
                }
                // Equal parts of what is left, at least two, as near as possible to the wanted
                // step.
                let time = at.time + left / (left / step + ROUNDING_S).round().max(2.0);
                let share = (time - a.time) / (b.time - a.time);
                poses.push(TimedPose {
                    pose: on_arc(a.pose, b.pose, share),
                    time,
                });
            }
        }
        poses.push(self.poses[self.poses.len() - 1]);
        self.poses = poses;
    }

    fn join(&mut self, resolution: &Resolution) {
        let mut kept = 1;
        let last = self.poses.len() - 1;
        for i in 1..last {
            let (before, after) = (self.poses[kept - 1].time, self.poses[i + 1].time);
            let step = resolution.step_at(before);
            let short = self.poses[i].time - before < (1.0 - HYSTERESIS) * step - ROUNDING_S;
            let room = after - before < (1.0 + HYSTERESIS) * step + ROUNDING_S;
            // At least three poses are left, for a velocity and its change.
            if !(short && room && kept + last - i >= 3) {
                self.poses[kept] = self.poses[i];
                kept += 1;
            }
        }
        self.poses[kept] = self.poses[last];
        self.poses.truncate(kept + 1);
    }
}

/// Whether a duration is usable: shorter ones vanish beside the times that they are added to.
fn time_step(name: &'static str, value: f64) -> Result<(), SettingsError> {
    let wanted = "1 ms to a minute are possible";
    if (1e-3..=60.0).contains(&value) {
        Ok(())
    } else {
        Err(SettingsError {
            name,
            value,
            wanted,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::trajectory::timed_poses::tests::band;

    #[test]
    fn resizing_keeps_ends_and_time_and_makes_steps_even() {
        let (mut band, resolution) = (band(), Resolution::default());
        let (end, duration) = (band.pose_at(99.0), band.duration());
        for _ in 0..3 {
            band.resize(&resolution);
        }
        assert_eq!((band.pose_at(99.0), band.duration()), (end, duration));
        for pair in band.poses().windows(2) {
            let (step, wanted) = (
                pair[1].time - pair[0].time,
                resolution.step_at(pair[0].time),
            );
            assert!(
                step < 1.41 * wanted && step > 0.3 * wanted,
                "{step} for {wanted}"
            );
        }
    }
}
