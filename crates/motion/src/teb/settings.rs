//! What a robot can do, and what of a band is worth how much.

use openbench_core::RobotDescription;

/// What a robot with two driven sides can do.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Largest forward speed, m/s.
    pub forward: f64,
    /// Largest backward speed, m/s; zero for a robot that never backs.
    pub backward: f64,
    /// Largest turn rate, rad/s.
    pub turn: f64,
    /// Largest acceleration of the wheels' rims, m/s².
    pub acceleration: f64,
    /// Half of the effective track: a turn rate times this is the rims' speed in turning, metres.
    pub half_track: f64,
}

/// A limit or setting that makes no sense.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{name} is {value}; {wanted}")]
pub struct SettingsError {
    /// Which.
    pub name: &'static str,
    /// What it is.
    pub value: f64,
    /// What it has to be.
    pub wanted: &'static str,
}

impl Limits {
    /// The limits of a robot.
    pub fn of(robot: &RobotDescription) -> Result<Self, SettingsError> {
        let limits = Self {
            forward: robot.max_forward,
            backward: robot.max_backward,
            turn: robot.max_turn,
            acceleration: robot.max_acceleration,
            half_track: robot.effective_track / 2.0,
        };
        limits.check().map(|()| limits)
    }

    /// Whether a robot could have these.
    pub fn check(&self) -> Result<(), SettingsError> {
        positive("the largest forward speed", self.forward)?;
        positive("the largest turn rate", self.turn)?;
        positive("the largest acceleration", self.acceleration)?;
        positive("half of the track", self.half_track)?;
        not_negative("the largest backward speed", self.backward)
    }
}

/// How finely a band is divided.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Resolution {
    /// Seconds of the first stretch.
    pub near: f64,
    /// Seconds of stretches far ahead.
    pub far: f64,
    /// Seconds ahead from which on it is far.
    pub horizon: f64,
    /// Most knots.
    pub most: usize,
}

impl Default for Resolution {
    fn default() -> Self {
        Self { near: 0.1, far: 0.3, horizon: 2.0, most: 150 }
    }
}

impl Resolution {
    /// Seconds of a stretch that begins `time` seconds ahead.
    pub fn step_at(&self, time: f64) -> f64 {
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
        if enough { Ok(()) } else { Err(SettingsError { name: "the number of knots", value, wanted }) }
    }
}

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

pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), SettingsError> {
    let wanted = "it must be more than nothing, and a number";
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(SettingsError { name, value, wanted }) }
}

/// Shorter ones vanish beside the times that they are added to.
fn time_step(name: &'static str, value: f64) -> Result<(), SettingsError> {
    let wanted = "1 ms to a minute are possible";
    if (1e-3..=60.0).contains(&value) { Ok(()) } else { Err(SettingsError { name, value, wanted }) }
}

pub(crate) fn finite(name: &'static str, value: f64) -> Result<(), SettingsError> {
    let wanted = "it must be a number";
    if value.is_finite() { Ok(()) } else { Err(SettingsError { name, value, wanted }) }
}

pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<(), SettingsError> {
    let wanted = "it must be nothing or more, and a number";
    if value >= 0.0 && value.is_finite() { Ok(()) } else { Err(SettingsError { name, value, wanted }) }
}

/// Whether a value is a number of at least `least`.
pub(crate) fn at_least(
    name: &'static str,
    value: f64,
    least: f64,
    wanted: &'static str,
) -> Result<(), SettingsError> {
    if value >= least && value.is_finite() { Ok(()) } else { Err(SettingsError { name, value, wanted }) }
}
