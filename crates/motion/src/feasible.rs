//! Whether a motion keeps the whole footprint off everything, all the time.

use openbench_core::{Pose2, Velocity};

use crate::kinematics::Motion;
use crate::limits::Limits;
use crate::shape::{Footprint, Obstacle};
use crate::trajectory::Band;

/// Seconds between two looks along a motion: at half a metre and one radian a second no corner moves further than 4 cm.
const LOOK: f64 = 0.05;
/// Of a start that is nearer to something than it should be, this share is kept: much is gained by getting off it, and not much can be lost.
const KEPT: f64 = 0.5;
/// What is lost to rounding where a start is inside something, metres.
const ROUNDING: f64 = 1e-6;
/// Looks along one motion, at most.
const MOST_LOOKS: usize = 10_000;

/// The clearance that a motion from a place with `clearance` may not fall below.
fn floor(clearance: f64, margin: f64) -> f64 {
    if clearance > 0.0 { margin.min(KEPT * clearance) } else { clearance - ROUNDING }
}

/// How near to each obstacle a motion may come: `margin`, but for those that it begins nearer to.
pub(crate) struct Floors {
    margin: f64,
    /// Number and floor of each obstacle that the motion begins near to. None may be made up for by another.
    near: Vec<(usize, f64)>,
}

impl Floors {
    /// For a motion that begins at `pose`.
    pub(crate) fn new<'a>(
        footprint: &Footprint,
        obstacles: impl Iterator<Item = &'a Obstacle>,
        pose: Pose2,
        margin: f64,
    ) -> Self {
        let (placed, circle, reach) = (footprint.at(pose), footprint.circumscribed(), margin / KEPT);
        let distance = |o: &Obstacle| o.contact(&placed, circle, 0.0, reach).map(|c| c.distance);
        let near = obstacles.enumerate().filter_map(|(i, o)| Some((i, distance(o).filter(|d| *d < reach)?)));
        Self { margin, near: near.map(|(i, d)| (i, floor(d, margin))).collect() }
    }

    /// Whether a pose keeps off everything; what it has got off by now counts from here on.
    pub(crate) fn keep<'a>(
        &mut self,
        footprint: &Footprint,
        obstacles: impl Iterator<Item = &'a Obstacle>,
        pose: Pose2,
        seconds: f64,
    ) -> bool {
        let (placed, circle, reach) = (footprint.at(pose), footprint.circumscribed(), self.margin / KEPT);
        for (i, obstacle) in obstacles.enumerate() {
            let contact = obstacle.contact(&placed, circle, seconds, reach);
            let distance = contact.map_or(reach, |c| c.distance);
            let near = self.near.iter_mut().find(|(number, _)| *number == i);
            let least = near.as_ref().map_or(self.margin, |(_, floor)| *floor);
            if distance < least {
                return false;
            }
            if let Some((_, least)) = near {
                *least = least.max(floor(distance, self.margin));
            }
        }
        true
    }
}

/// Distance from the footprint to the nearest obstacle as it will be after `seconds`, if less than `reach`, else `reach`; metres, negative inside.
pub fn clearance<'a>(
    footprint: &Footprint,
    obstacles: impl Iterator<Item = &'a Obstacle>,
    pose: Pose2,
    seconds: f64,
    reach: f64,
) -> f64 {
    let (placed, circle) = (footprint.at(pose), footprint.circumscribed());
    let near = obstacles.filter_map(|o| o.contact(&placed, circle, seconds, reach));
    near.map(|contact| contact.distance).fold(reach, f64::min)
}

/// Seconds until the robot comes nearer than `margin` to something on the band, driven no faster than it can; `None` if it never does. Who begins nearer than that may move away.
pub fn first_conflict(
    footprint: &Footprint,
    limits: &Limits,
    obstacles: &[Obstacle],
    band: &Band,
    margin: f64,
) -> Option<f64> {
    let band = band.slowed(limits);
    let mut floors = Floors::new(footprint, obstacles.iter(), band.pose_at(0.0), margin);
    let looks = (band.duration() / LOOK).ceil() as usize;
    let mut times = (1..=looks.min(MOST_LOOKS)).map(|i| band.duration().min(i as f64 * LOOK));
    let met = times.find(|&time| !floors.keep(footprint, obstacles.iter(), band.pose_at(time), time));
    // What is not looked at is not known to be free.
    met.or_else(|| (looks > MOST_LOOKS).then_some(MOST_LOOKS as f64 * LOOK))
}

/// Seconds in which any robot stops.
const LONGEST_STOP: f64 = 20.0;

/// Seconds until the robot comes nearer than `margin` to something that stands if it does as it is told for `hold` seconds and then brakes. Who moves is not looked at: to stop in somebody's way is worse than to be gone.
pub fn conflict_before_stop(
    footprint: &Footprint,
    obstacles: &[Obstacle],
    motion: Motion,
    limits: &Limits,
    hold: f64,
    margin: f64,
) -> Option<f64> {
    const STEP: f64 = 0.025;
    let standing = || obstacles.iter().filter(|o| !o.is_moving());
    let mut motion = motion;
    let mut floors = Floors::new(footprint, standing(), motion.pose, margin);
    let mut time = 0.0;
    // Who does not come to stand, with a speed that no robot has, is taken for one who runs into something.
    let longest = hold + LONGEST_STOP;
    while time < hold || !motion.stands() {
        if time > longest {
            return Some(time);
        }
        if time >= hold {
            motion.command = Velocity::ZERO;
        }
        motion.step(limits, STEP);
        time += STEP;
        if !floors.keep(footprint, standing(), motion.pose, 0.0) {
            return Some(time);
        }
    }
    None
}
