//! Settings: what shapes a band, and how the planner works.

use crate::checks::{SettingsError, finite, not_negative, positive};
use crate::teb::classes::Exploring;
use crate::trajectory::Resolution;

/// Weights of the objectives. Those of lasting quantities are for a second of them, so that the
/// resolution of a band changes little.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Of time.
    pub time: f64,
    /// Of the length of the path.
    pub length: f64,
    /// Of driving sideways, per m² and stretch: it is impossible, so it must not pay.
    pub sideways: f64,
    /// Of speeds above the limits.
    pub speed: f64,
    /// Of turn rates above the limit.
    pub turn: f64,
    /// Of accelerations above the limit.
    pub acceleration: f64,
    /// Of changes of the turn rate, per m²/s⁴ of the rims: without it small errors are corrected at
    /// once, and overshot.
    pub steady: f64,
    /// Of driving backward at all.
    pub backward: f64,
    /// Of being nearer to obstacles than [`Margins::least`].
    pub obstacle: f64,
    /// Of being nearer to obstacles than [`Margins::comfort`].
    pub comfort: f64,
    /// Of distance from a via point.
    pub via: f64,
    /// Of turning to the other side than the preferred one.
    pub side: f64,
}

impl Default for Weights {
    fn default() -> Self {
        Self {
            time: 1.0,
            length: 3.0,
            sideways: 5000.0,
            speed: 400.0,
            turn: 40.0,
            acceleration: 10.0,
            steady: 0.2,
            backward: 0.5,
            obstacle: 2000.0,
            comfort: 1.0,
            via: 0.0,
            side: 0.0,
        }
    }
}

/// Distances to keep from obstacles, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margins {
    /// From the footprint to standing obstacles: being nearer is hardly ever worth it.
    pub least: f64,
    /// From the footprint to moving obstacles.
    pub moving: f64,
    /// From this distance on nearness costs nothing.
    pub comfort: f64,
}

impl Default for Margins {
    fn default() -> Self {
        Self {
            least: 0.02,
            moving: 0.1,
            comfort: 0.2,
        }
    }
}

/// Settings of a band.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Settings {
    /// How finely it is divided.
    pub resolution: Resolution,
    /// Weights of the objectives.
    pub weights: Weights,
    /// Distances to keep from obstacles.
    pub margins: Margins,
}

impl Settings {
    /// Whether a band can be optimized with them.
    pub fn check(&self) -> Result<(), SettingsError> {
        self.resolution.check()?;
        let w = &self.weights;
        positive("the weight of time", w.time)?;
        positive("the weight of driving sideways", w.sideways)?;
        let others = [
            w.length,
            w.speed,
            w.turn,
            w.acceleration,
            w.steady,
            w.backward,
            w.obstacle,
            w.comfort,
            w.via,
            w.side,
        ];
        others
            .into_iter()
            .try_for_each(|weight| not_negative("a weight", weight))?;
        let m = &self.margins;
        positive("the margin of comfort", m.comfort)?;
        [m.least, m.moving]
            .into_iter()
            .try_for_each(|margin| not_negative("a margin", margin))
    }
}

/// Settings of the planner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TebSettings {
    /// Settings of its bands.
    pub band: Settings,
    /// How classes are searched; `keep` and `comfort` are set from the footprint and the margins of
    /// bands.
    pub exploring: Exploring,
    /// Length of the path that is planned ahead, metres.
    pub horizon: f64,
    /// Another band is driven only if it costs less than this share of the present one.
    pub hysteresis: f64,
    /// Distance from the end with which the robot has arrived, metres.
    pub tolerance: f64,
    /// Heading error at the end with which the robot has arrived, radians.
    pub yaw_tolerance: f64,
    /// Distance between via points of the path, metres, which bands pass as firmly as
    /// [`Weights::via`] says: not at all by default, since paths are only hints where to go.
    pub via: Option<f64>,
    /// Preferred side where the robot turns by more than two radians: left if positive, right if
    /// negative. [`Weights::side`] says how much turning to the other side at the beginning of a
    /// band costs besides.
    pub side: f64,
    /// How much faster than predicted people may approach, m/s.
    ///
    /// Near them the robot is slow enough to stand when they reach it, and it does not run from
    /// them, since people walk around what stands. When it stands near somebody it waits for half a
    /// second before it sets out. [`Margins::moving`] should be 0.3 m then, so that bands pass
    /// people as far as that allows.
    ///
    /// `None` by default: where all motion is predicted exactly the robot may pass closely, and
    /// evades.
    pub approach_margin_mps: Option<f64>,
    /// Seconds that a walking person needs to stop: the robot does not drive onto ground where
    /// somebody will be by then. `None` by default: where all motion is predicted exactly it may
    /// pass closely before somebody.
    pub stopping_time_s: Option<f64>,
}

impl Default for TebSettings {
    fn default() -> Self {
        Self {
            band: Settings::default(),
            exploring: Exploring::default(),
            horizon: 4.0,
            hysteresis: 0.9,
            tolerance: 0.1,
            yaw_tolerance: 0.08,
            via: None,
            side: 0.0,
            approach_margin_mps: None,
            stopping_time_s: None,
        }
    }
}

impl TebSettings {
    /// Whether a planner can work with them.
    pub fn check(&self) -> Result<(), SettingsError> {
        self.band.check()?;
        positive("the horizon", self.horizon)?;
        positive("the tolerance", self.tolerance)?;
        positive("the tolerance of heading", self.yaw_tolerance)?;
        if !(self.hysteresis > 0.0 && self.hysteresis <= 1.0) {
            let wanted = "give a number above 0, and 1 at most";
            return Err(SettingsError {
                name: "the hysteresis",
                value: self.hysteresis,
                wanted,
            });
        }
        positive("the distance between via points", self.via.unwrap_or(1.0))?;
        finite("the preferred side", self.side)?;
        positive(
            "the unpredicted approach speed of people",
            self.approach_margin_mps.unwrap_or(1.0),
        )?;
        positive(
            "the time that somebody needs to stop",
            self.stopping_time_s.unwrap_or(1.0),
        )?;
        self.exploring.check()
    }
}
