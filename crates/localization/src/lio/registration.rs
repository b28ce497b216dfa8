//! A scan laid on the map: points are matched to planes and the state is updated, in turn.
//!
//! Where the pose is uncertain beforehand, as after a gap, many points would match planes that they
//! do not lie on. The gate is then closed step by step, about what agrees so far.

use nalgebra::Vector3;

use super::belief::Belief;
use super::iterated_update::{Posterior, Prior};
use super::matching::Matching;
use super::noise::LidarNoise;
use super::planes::PlaneMap;
use super::scan_match::ScanMatch;
use super::state::{Covariance, Error, State, at};

/// At most this many searches for planes.
const MAX_SEARCHES: usize = 8;
/// Points are matched again where the pose has moved farther than this since the last search,
/// metres,
const REMATCH_DISTANCE_M: f64 = 0.03;
/// or turned by more than this, radians.
const REMATCH_ANGLE_RAD: f64 = 0.003;
/// A prior whose pose displaces surfaces by more than this is uncertain, metres.
const UNCERTAIN_M: f64 = 0.05;
/// How far those surfaces are from the robot, metres.
const SURFACE_DISTANCE_M: f64 = 10.0;
/// Of an uncertain prior the gates of the searches: points match planes up to this distance,
/// metres.
const GATES_M: [f64; 5] = [0.6, 0.3, 0.15, 0.1, f64::INFINITY];
/// The gates of a prior that is certain.
const OPEN_GATE_M: [f64; 1] = [f64::INFINITY];
/// One point in this many is matched in all of the gated searches but the last,
const THINNING: usize = 4;
/// if the scan has at least this many.
const MIN_POINTS_TO_THIN: usize = 2000;

/// A scan and the map it is laid on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Scene<'a> {
    /// In the LiDAR's frame at the belief's instant.
    pub(super) points: &'a [Vector3<f64>],
    pub(super) map: &'a PlaneMap,
    pub(super) noise: &'a LidarNoise,
    /// Whether the LiDAR's pose on the IMU is estimated, too.
    pub(super) estimate_lidar: bool,
}

/// Corrects a belief by a scan. `None` leaves it as it was: the equations have no solution, or no
/// end.
pub(super) fn register(
    belief: &mut Belief,
    scene: &Scene<'_>,
    matching: &mut Matching,
) -> Option<ScanMatch> {
    let registration = Registration::new(belief, scene)?;
    if registration.is_uncertain && scene.points.len() >= MIN_POINTS_TO_THIN {
        // Some of the points suffice until the pose is roughly known. If they do not, all may.
        let thinned: Vec<_> = scene.points.iter().copied().step_by(THINNING).collect();
        let mut attempt = belief.clone();
        let found = registration.search(&mut attempt, &thinned, matching);
        if let Some(matched) = found.filter(ScanMatch::is_good) {
            *belief = attempt;
            return Some(matched);
        }
    }
    registration.search(belief, scene.points, matching)
}

/// A registration in progress.
struct Registration<'a> {
    prior: Prior,
    is_uncertain: bool,
    gates: &'static [f64],
    scene: &'a Scene<'a>,
}

impl<'a> Registration<'a> {
    fn new(belief: &Belief, scene: &'a Scene<'a>) -> Option<Self> {
        let prior = Prior::new(belief)?;
        let is_uncertain = surface_deviation(&belief.in_map().covariance) > UNCERTAIN_M;
        let gates: &[f64] = if is_uncertain { &GATES_M } else { &OPEN_GATE_M };
        Some(Self {
            prior,
            is_uncertain,
            gates,
            scene,
        })
    }

    /// Matches points and updates the state, in turn, until the state stays where it is. `rough`
    /// are the points to match in all gated searches but the last.
    fn search(
        &self,
        belief: &mut Belief,
        rough: &[Vector3<f64>],
        matching: &mut Matching,
    ) -> Option<ScanMatch> {
        let mut here = belief.clone();
        for search in 0..MAX_SEARCHES {
            let gate = self.gates.get(search).copied().unwrap_or(f64::INFINITY);
            let is_last_gate = search + 1 >= self.gates.len();
            let points = if is_last_gate {
                self.scene.points
            } else {
                rough
            };
            let matched_at = here.in_map();
            let Scene { map, noise, .. } = *self.scene;
            matching.find(
                &matched_at.state,
                &matched_at.covariance,
                points,
                map,
                noise,
                gate,
            );
            let posterior = self.update(here.state, matching)?;
            // Against the map, since a tilt of the map moves points off planes as a turn of the
            // robot does.
            let moved = posterior.state.in_map().minus(&matched_at.state);
            if is_last_gate && !has_moved(&moved) {
                return self.finish(belief, posterior, matching);
            }
            // Where to linearize and to search next. Each update begins at the prior again, so that
            // the scan counts once; the covariance serves the gates alone.
            here.state = posterior.state;
            if self.is_uncertain {
                here.covariance = posterior.covariance;
            }
        }
        None
    }

    fn update(&self, state: State, matching: &Matching) -> Option<Posterior> {
        if self.scene.estimate_lidar {
            self.prior.update::<12>(state, &matching.clusters)
        } else {
            self.prior.update::<6>(state, &matching.clusters)
        }
    }

    /// Adopts a posterior, if it is finite.
    fn finish(
        &self,
        belief: &mut Belief,
        posterior: Posterior,
        matching: &Matching,
    ) -> Option<ScanMatch> {
        let Posterior {
            state,
            covariance,
            summary,
        } = posterior;
        if !state.is_finite() {
            return None;
        }
        let innovation = self.prior.innovation(&state, &covariance);
        belief.state = state;
        // Rounding makes it slightly asymmetric, and the errors would add up from scan to scan.
        belief.covariance = (covariance + covariance.transpose()) * 0.5;
        Some(ScanMatch {
            points: summary.points,
            agreeing: matching.agreeing(),
            fit: summary.fit,
            degenerate: summary.degenerate,
            innovation,
        })
    }
}

/// Whether an error of the state is so large that points may match other planes now.
fn has_moved(error: &Error) -> bool {
    error.fixed_rows::<3>(at::POSITION).norm() > REMATCH_DISTANCE_M
        || error.fixed_rows::<3>(at::ROTATION).norm() > REMATCH_ANGLE_RAD
}

/// How far a surface may seem displaced by the pose's uncertainty alone, metres (one standard
/// deviation).
fn surface_deviation(covariance: &Covariance) -> f64 {
    let distance = SURFACE_DISTANCE_M;
    let position = trace(covariance, at::POSITION);
    let rotation = trace(covariance, at::ROTATION);
    (position + distance * distance * rotation).sqrt()
}

/// Sum of three variances; `first` is where they begin.
fn trace(covariance: &Covariance, first: usize) -> f64 {
    (first..first + 3).map(|i| covariance[(i, i)]).sum::<f64>()
}
