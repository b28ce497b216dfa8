//! People and cars of the traffic model in the world of rays and bodies.

use std::sync::Arc;

use nalgebra::{Translation3, UnitQuaternion};
use openbench_core::{Pose2, Pose3};
use openbench_scene::free_space::ground_height;
use openbench_scene::{Movers, Placed, RayCaster};

use crate::bodies::Leg;
use crate::clock::OBSERVATION_NS;
use crate::physics::Physics;
use crate::traffic::figures::Gallery;
use crate::traffic::{Mover, RobotState, Traffic};

/// The height of the ground under one mover of so many is looked up in a step: it changes at kerbs only.
const TURNS: usize = 4;
/// Whoever walks or drives takes no step higher than this, metres: what is higher is something that stands in the way.
const HIGHEST_STEP: f64 = 0.3;

/// Everyone who moves.
pub(crate) struct Crowd {
    traffic: Traffic,
    gallery: Arc<Gallery>,
    before: Vec<Mover>,
    /// Height of the ground under each, metres.
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

    /// Who is where.
    pub(crate) fn movers(&self) -> &[Mover] {
        self.traffic.movers()
    }

    /// Goes on by one observation: the bodies set out, and the figures are placed where they will be at its end.
    pub(crate) fn step(
        &mut self,
        robot: RobotState,
        caster: &RayCaster,
        physics: &mut Physics,
        figures: &mut Movers,
    ) {
        self.before.copy_from_slice(self.traffic.movers());
        self.traffic.step(OBSERVATION_NS as f64 * 1e-9, robot);
        self.look_down(caster);
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
                (before.present && mover.present).then_some(leg)
            });
        physics.set_movers_out(robot.position, legs);
        self.show(caster, figures);
    }

    /// Places the figures where everyone is.
    pub(crate) fn show(&self, caster: &RayCaster, figures: &mut Movers) {
        let now = self.traffic.movers().iter().zip(&self.grounds);
        let placed = now.map(|(mover, ground)| Placed {
            // Who is not there keeps the number, but has no figure.
            figure: if mover.present {
                self.gallery.of(mover)
            } else {
                usize::MAX
            },
            pose: pose(&mover.pose, *ground),
            velocity: [mover.velocity[0] as f32, mover.velocity[1] as f32, 0.0],
        });
        figures.place(caster.figures(), placed);
    }

    fn look_down(&mut self, caster: &RayCaster) {
        self.steps += 1;
        let movers = self.traffic.movers().iter().enumerate();
        for (i, mover) in movers.filter(|(i, _)| (i + self.steps).is_multiple_of(TURNS)) {
            let height = ground_height(caster, mover.pose.point());
            if (height - self.grounds[i]).abs() < HIGHEST_STEP {
                self.grounds[i] = height;
            }
        }
    }
}

fn pose(at: &Pose2, ground: f64) -> Pose3 {
    let turn = UnitQuaternion::from_euler_angles(0.0, 0.0, at.yaw);
    Pose3::from_parts(Translation3::new(at.x, at.y, ground), turn)
}
