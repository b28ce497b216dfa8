//! What of a band is worth how much.

use crate::checks::{SettingsError, not_negative, positive};
use crate::trajectory::Resolution;

/// What a second, a metre and a nearness are worth. Weights of what lasts are for a second of it, so that how finely a band is divided changes little.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Weights {
    /// Time.
    pub time: f64,
    /// Length of the way.
    pub length: f64,
    /// Driving sideways, per m² and stretch: not possible, so it must not pay.
    pub sideways: f64,
    /// Speeds above the limits.
    pub speed: f64,
    /// Turn rates above the limit.
    pub turn: f64,
    /// Accelerations above the limit.
    pub acceleration: f64,
    /// Changes of the turn rate, per m²/s⁴ of the rims: without it what is a little off is put right at once, and overshot.
    pub steady: f64,
    /// Driving backwards at all.
    pub backward: f64,
    /// Nearer to obstacles than [`Margins::least`].
    pub obstacle: f64,
    /// Nearer to obstacles than [`Margins::comfort`].
    pub comfort: f64,
    /// Away from a point to pass by.
    pub via: f64,
    /// Turning to the other side than is preferred.
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

/// Distances to keep, metres.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Margins {
    /// From the footprint to what stands: nearer is hardly ever worth it.
    pub least: f64,
    /// From the footprint to what moves.
    pub moving: f64,
    /// From here on nearness costs nothing.
    pub comfort: f64,
}

impl Default for Margins {
    fn default() -> Self {
        Self { least: 0.02, moving: 0.1, comfort: 0.2 }
    }
}

/// All that shapes a band.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Settings {
    /// How finely it is divided.
    pub resolution: Resolution,
    /// What is worth how much.
    pub weights: Weights,
    /// Distances to keep.
    pub margins: Margins,
}

impl Settings {
    /// Whether a band can be shaped by them.
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
        others.into_iter().try_for_each(|weight| not_negative("a weight", weight))?;
        let m = &self.margins;
        positive("the margin of comfort", m.comfort)?;
        [m.least, m.moving].into_iter().try_for_each(|margin| not_negative("a margin", margin))
    }
}
