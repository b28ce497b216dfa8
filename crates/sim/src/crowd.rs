//! People and cars of the traffic model in the world of rays and bodies.

use std::sync::Arc;

use nalgebra::{Translation3, UnitQuaternion};
use openbench_core::{Pose2, Pose3};
use openbench_scene::{Movers, Placed, RayCaster, ground_height};

use crate::bodies::Leg;
use crate::clock::OBSERVATION_NS;
use crate::physics::Physics;
use crate::traffic::{Gallery, Mover, RobotState, Traffic};

/// The ground under a mover is looked up in one of this many steps: its height changes at kerbs
/// only.
const GROUND_INTERVAL: usize = 4;
/// Largest step of a person or car, metres. A greater difference in height is an obstacle, not
/// ground.
const MAX_STEP_M: f64 = 0.3;
/// The figure of a mover that is absent: it keeps its number and is not drawn.
const NO_FIGURE: usize = usize::MAX;

/// All people and cars.
pub(crate) struct Crowd {
    traffic: Traffic,
    gallery: Arc<Gallery>,
    /// The movers at the last observation.
    before: Vec<Mover>,
    /// Height of the ground under each mover, metres.
    grounds: Vec<f64>,
    steps: usize,
}

impl Crowd {
    pub(crate) fn new(
        traffic: Traffic,
        gallery: Arc<Gallery>,
        caster: &RayCaster,
        physics: &mut Physics,
    ) -> Self {
        let before = traffic.movers().to_vec();
        let grounds = before
            .iter()
            .map(|m| ground_height(caster, m.pose.point()))
            .collect();
        for mover in &before {
            physics.add_mover(mover, gallery.look(mover));
        }
        Self {
            traffic,
            gallery,
            before,
            grounds,
            steps: 0,
        }
    }

    /// The movers now.
    pub(crate) fn movers(&self) -> &[Mover] {
        self.traffic.movers()
    }

    /// Advances to the next observation. The figures are placed where the movers will be then, and
    /// the bodies set out for there.
    pub(crate) fn step(
        &mut self,
        robot: RobotState,
        caster: &RayCaster,
        physics: &mut Physics,
        figures: &mut Movers,
    ) {
        self.before.copy_from_slice(self.traffic.movers());
        self.traffic.step(OBSERVATION_NS as f64 * 1e-9, robot);
        self.update_grounds(caster);
        let now = self.traffic.movers().iter().zip(&self.grounds);
        let legs = self
            .before
            .iter()
            .zip(now)
            .map(|(before, (mover, ground))| {
                let leg = Leg {
                    from: before.pose,
                    to: mover.pose,
                    ground: *ground,
                };
                // A mover that has just come in or left has no leg: it would sweep across the map.
                (before.present && mover.present).then_some(leg)
            });
        physics.set_movers_out(robot.position, legs);
        // The figures stand where the legs end. Rays that are fired earlier see them earlier, by
        // their velocity (`lags` of packets).
        self.show(caster, figures);
    }

    /// Places the figures where the movers are.
    pub(crate) fn show(&self, caster: &RayCaster, figures: &mut Movers) {
        let now = self.traffic.movers().iter().zip(&self.grounds);
        let placed = now.map(|(mover, ground)| Placed {
            figure: if mover.present {
                self.gallery.figure(mover)
            } else {
                NO_FIGURE
            },
            pose: upright(mover.pose, *ground),
            velocity: [mover.velocity[0] as f32, mover.velocity[1] as f32, 0.0],
        });
        figures.place(caster.figures(), placed);
    }

    fn update_grounds(&mut self, caster: &RayCaster) {
        self.steps += 1;
        for (i, mover) in self.traffic.movers().iter().enumerate() {
            // Each time a quarter of the movers, so that no step has all the work.
            if !(i + self.steps).is_multiple_of(GROUND_INTERVAL) {
                continue;
            }
            let height = ground_height(caster, mover.pose.point());
            // The ray down may hit what the mover passes under or beside: then the last height
            // stays.
            if (height - self.grounds[i]).abs() < MAX_STEP_M {
                self.grounds[i] = height;
            }
        }
    }
}

fn upright(at: Pose2, ground: f64) -> Pose3 {
    let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, at.yaw);
    Pose3::from_parts(Translation3::new(at.x, at.y, ground), turn)
}
