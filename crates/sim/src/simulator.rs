//! The robot in a world, in lock-step.

use std::sync::Arc;

use openbench_core::{
    GnssFix, ImuSample, LidarScan, Observation, Pose2, Pose3, RobotDescription, SimTime, Velocity,
    WheelSample,
};
use openbench_osm::OsmMap;
use openbench_scene::{FreeSpace, Movers, RayCaster, Scene, SemanticClass, Snapshot};

use crate::SimError;
use crate::camera::SimCamera;
use crate::clock::{OBSERVATION_NS, STEP_NS};
use crate::crowd::Crowd;
use crate::gnss::{self, Gnss};
use crate::inertial::{self, Encoders, Imu};
use crate::lidar::{Lidar, SCAN_NS};
use crate::noise::Noise;
use crate::physics::{Physics, Solids};
use crate::render::Renderer;
use crate::traffic::figures::Gallery;
use crate::traffic::yielding::Yielding;
use crate::traffic::{Mover, MoverKind, PERSON_RADIUS, RobotState, Traffic, TrafficPlan};

/// Rims slower than this do not drive a robot, m/s.
const STANDS: f64 = 0.01;
/// A touch after less than this time without one belongs to the same collision.
const SAME_COLLISION_NS: u64 = 500_000_000;

/// A collision: the robot touched something, after half a second or more of not touching anything of its class.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Collision {
    /// When it began.
    pub time: SimTime,
    /// What was touched.
    pub class: SemanticClass,
    /// Impulse of the first touch, N s.
    pub impulse: f64,
    /// Where the robot was.
    pub pose: Pose2,
    /// How fast its fastest corner was up to 50 ms before, m/s, turning as it was told to: a robot that stands is run into.
    pub speed: f64,
    /// Whether the robot had got into the way of who was touched when that was too near to stop.
    pub cut_off: bool,
}

/// Why the robot can no longer take part in an episode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum LeftWorld {
    /// No ground is under it, or it has fallen off the ground.
    #[error("the robot drove off the ground of the world")]
    OffTheGround,
    /// It is beyond all that there is, or nowhere.
    #[error("the robot drove out of the world")]
    OutOfBounds,
    /// It lies on its side or back.
    #[error("the robot has tipped over")]
    TippedOver,
}

/// So far beyond all that can be seen the robot is out of the world, metres.
const OUTSIDE_M: f64 = 50.0;
/// So far below the ground of its start the robot has fallen off, metres.
const FALLEN_M: f64 = 2.0;
/// Cosine of the tilt beyond which the robot's wheels carry it no more: 60 degrees.
const TIPPED_COSINE: f64 = 0.5;

/// A world prepared for simulation: shared by all episodes in it.
#[derive(Debug, Clone)]
pub struct Stage {
    caster: RayCaster,
    renderer: Arc<Renderer>,
    solids: Solids,
    gallery: Arc<Gallery>,
    bounds: Bounds,
}

/// A box on the ground, metres.
#[derive(Debug, Clone, Copy)]
struct Bounds {
    low: [f64; 2],
    high: [f64; 2],
}

impl Bounds {
    /// Round what stands in a scene; round everywhere where nothing does.
    fn of(scene: &Scene) -> Self {
        const EMPTY: Bounds = Bounds {
            low: [f64::INFINITY; 2],
            high: [f64::NEG_INFINITY; 2],
        };
        const EVERYWHERE: Bounds = Bounds {
            low: [f64::NEG_INFINITY; 2],
            high: [f64::INFINITY; 2],
        };
        let corners = scene
            .standing()
            .iter()
            .flat_map(|triangle| triangle.corners);
        let bounds = corners.fold(EMPTY, |mut bounds, corner| {
            for (axis, at) in scene.vertices[corner as usize].position[..2]
                .iter()
                .enumerate()
            {
                bounds.low[axis] = bounds.low[axis].min(f64::from(*at));
                bounds.high[axis] = bounds.high[axis].max(f64::from(*at));
            }
            bounds
        });
        if bounds.low[0] <= bounds.high[0] {
            bounds
        } else {
            EVERYWHERE
        }
    }

    /// Whether a place lies no farther outside than so many metres. What is no number lies nowhere.
    fn hold(&self, place: [f64; 2], margin: f64) -> bool {
        let holds = |axis: usize| {
            place[axis] >= self.low[axis] - margin && place[axis] <= self.high[axis] + margin
        };
        holds(0) && holds(1)
    }
}

impl Stage {
    /// Prepares a scene.
    pub fn new(caster: RayCaster) -> Result<Self, SimError> {
        let solids = Solids::new(caster.scene())?;
        Ok(Self {
            renderer: Arc::new(Renderer::new(caster.clone())),
            bounds: Bounds::of(caster.scene()),
            solids,
            caster,
            gallery: Arc::default(),
        })
    }

    /// Prepares a scene in which up to as many people and cars as `plan` says will move.
    pub fn peopled(mut scene: Scene, plan: TrafficPlan) -> Result<Self, SimError> {
        let gallery = Arc::new(Gallery::add(&mut scene, plan));
        Ok(Self {
            gallery,
            ..Self::new(RayCaster::new(Arc::new(scene)))?
        })
    }

    /// The rays into the scene.
    pub fn caster(&self) -> &RayCaster {
        &self.caster
    }

    /// The scene with movers where they are now.
    pub fn snapshot<'a>(&'a self, movers: &'a Movers) -> Snapshot<'a> {
        Snapshot {
            caster: &self.caster,
            movers,
        }
    }

    /// What draws the scene.
    pub fn renderer(&self) -> &Renderer {
        &self.renderer
    }
}

/// The robot in a world. Time moves only in [`Simulator::step`].
pub struct Simulator {
    stage: Stage,
    robot: RobotDescription,
    physics: Physics,
    /// Height of the ground at the start, metres.
    ground: f64,
    imu: Imu,
    encoders: Encoders,
    lidar: Lidar,
    lidar_path: Vec<Pose3>,
    crowd: Option<Crowd>,
    yielding: Yielding,
    movers: Arc<Movers>,
    time: SimTime,
    imu_samples: Vec<ImuSample>,
    wheel_samples: Vec<WheelSample>,
    scan: Option<LidarScan>,
    gnss: Option<Gnss>,
    fix: Option<GnssFix>,
    camera: SimCamera,
    collisions: Vec<Collision>,
    last_touch: Vec<(SemanticClass, SimTime)>,
    /// The robot's speed when the last step began, m/s.
    speed: f64,
    chain: [u8; 32],
}

impl Simulator {
    /// Puts the robot at `start` on the ground there. Same stage, robot, start, seed and velocities: same bytes.
    pub fn new(stage: Stage, robot: RobotDescription, start: Pose2, seed: u64) -> Self {
        let ground = openbench_scene::free_space::ground_height(&stage.caster, start.point());
        let physics = Physics::new(&stage.solids, &robot, start, ground);
        let imu = Imu::new(Noise::new(seed, 1), &robot);
        let lidar = Lidar::new(Noise::new(seed, 2));
        let gnss = robot
            .gnss
            .map(|antenna| Gnss::new(Noise::new(seed, 3), antenna));
        let camera = SimCamera::new(stage.renderer.clone(), &robot);
        let yielding = Yielding::new(robot.max_acceleration);
        let mut simulator = Self {
            lidar_path: vec![physics.base_link() * robot.lidar],
            stage,
            robot,
            physics,
            ground,
            imu,
            encoders: Encoders::default(),
            lidar,
            crowd: None,
            yielding,
            movers: Arc::default(),
            time: SimTime::ZERO,
            imu_samples: Vec::new(),
            wheel_samples: Vec::new(),
            scan: None,
            gnss,
            fix: None,
            camera,
            collisions: Vec::new(),
            last_touch: Vec::new(),
            speed: 0.0,
            chain: [0; 32],
        };
        simulator.camera.move_to(
            SimTime::ZERO,
            simulator.base_link(),
            simulator.movers.clone(),
        );
        simulator
    }

    /// Puts people and cars into the world. The stage must have figures for them, see [`Stage::peopled`].
    pub fn among(mut self, traffic: Traffic) -> Result<Self, SimError> {
        if !self.stage.gallery.suffices(traffic.placed()) {
            return Err(SimError::NoFigures);
        }
        let gallery = self.stage.gallery.clone();
        let crowd = Crowd::new(traffic, gallery, &self.stage.caster, &mut self.physics);
        crowd.show(&self.stage.caster, Arc::make_mut(&mut self.movers));
        self.crowd = Some(crowd);
        self.camera
            .move_to(self.time, self.base_link(), self.movers.clone());
        Ok(self)
    }

    /// Puts as many people and cars as `plan` says on the ways of a map, as far as there is room for them around the robot.
    pub fn among_traffic_of(
        self,
        map: &OsmMap,
        plan: TrafficPlan,
        seed: u64,
    ) -> Result<Self, SimError> {
        let start = self.robot_state().position;
        let space = FreeSpace::new(&self.stage.caster, start, PERSON_RADIUS);
        self.among(Traffic::new(
            map,
            |p| space.is_reachable(p),
            plan,
            start,
            seed,
        ))
    }

    /// Drives with `velocity` until the next observation.
    pub fn step(&mut self, velocity: Velocity) {
        self.imu_samples.clear();
        self.wheel_samples.clear();
        self.scan = None;
        self.fix = None;
        let robot = self.robot_state();
        let rim = velocity.angular.abs() * self.robot.circumscribed_radius();
        self.speed = libm::hypot(robot.velocity[0], robot.velocity[1]) + rim;
        if let Some(crowd) = &mut self.crowd {
            let figures = Arc::make_mut(&mut self.movers);
            let fastest = self
                .physics
                .wheel_speeds()
                .into_iter()
                .fold(0.0, |a: f64, w| a.max(w.abs()));
            let drives = self.robot.wheel_radius * fastest > STANDS;
            self.yielding
                .update(OBSERVATION_NS as f64 * 1e-9, &robot, drives, crowd.movers());
            crowd.step(robot, &self.stage.caster, &mut self.physics, figures);
        }
        for _ in 0..OBSERVATION_NS / STEP_NS {
            self.physics_step(velocity);
        }
        self.camera
            .move_to(self.time, self.base_link(), self.movers.clone());
        self.extend_chain();
    }

    /// What the sensors delivered since the last step.
    pub fn observation(&self) -> Observation<'_> {
        Observation {
            time: self.time,
            imu: &self.imu_samples,
            wheels: &self.wheel_samples,
            scan: self.scan.as_ref(),
            gnss: self.fix.as_ref(),
            camera: &self.camera,
        }
    }

    /// Now.
    pub fn time(&self) -> SimTime {
        self.time
    }

    /// The truth: where `base_link` is in `map`.
    pub fn base_link(&self) -> Pose3 {
        self.physics.base_link()
    }

    /// The truth: how fast the robot moves in `map`, m/s.
    pub fn speed(&self) -> f64 {
        self.physics
            .velocity_at(nalgebra::Vector3::zeros())
            .xy()
            .norm()
    }

    /// The truth: the robot as people and cars see it.
    pub fn robot_state(&self) -> RobotState {
        let velocity = self.physics.velocity_at(nalgebra::Vector3::zeros());
        RobotState {
            position: Pose2::from_pose3(&self.base_link()).point(),
            velocity: [velocity.x, velocity.y],
            radius: self.robot.circumscribed_radius(),
        }
    }

    /// The truth: people and cars that move by themselves; none if nothing does.
    pub fn movers(&self) -> &[Mover] {
        self.crowd.as_ref().map_or(&[], Crowd::movers)
    }

    /// The truth: the scene as it is now.
    pub fn snapshot(&self) -> Snapshot<'_> {
        self.stage.snapshot(&self.movers)
    }

    /// The truth: whether the robot left the world, and how.
    pub fn left_world(&self) -> Option<LeftWorld> {
        let base = self.base_link();
        let [x, y, z] = base.translation.vector.into();
        if !(z.is_finite() && self.stage.bounds.hold([x, y], OUTSIDE_M)) {
            return Some(LeftWorld::OutOfBounds);
        }
        if (base.rotation * nalgebra::Vector3::z()).z < TIPPED_COSINE {
            return Some(LeftWorld::TippedOver);
        }
        (z < self.ground - FALLEN_M).then_some(LeftWorld::OffTheGround)
    }

    /// Every collision so far.
    pub fn collisions(&self) -> &[Collision] {
        &self.collisions
    }

    /// Hash over all states and scans so far.
    pub fn chain(&self) -> [u8; 32] {
        self.chain
    }

    fn physics_step(&mut self, velocity: Velocity) {
        self.physics.step(&self.stage.caster, velocity);
        self.time.0 += STEP_NS;
        self.encoders
            .turn(self.physics.wheel_speeds(), STEP_NS as f64 * 1e-9);
        if self.time.0.is_multiple_of(inertial::SAMPLE_NS) {
            self.imu_samples
                .push(self.imu.sample(self.time, &self.physics));
            self.wheel_samples.push(self.encoders.sample(self.time));
        }
        self.lidar_path.push(self.base_link() * self.robot.lidar);
        if self.time.0.is_multiple_of(SCAN_NS) {
            let began = SimTime(self.time.0 - SCAN_NS);
            self.scan = Some(self.lidar.scan(
                self.stage.snapshot(&self.movers),
                began,
                &self.lidar_path,
            ));
            self.lidar_path.drain(..self.lidar_path.len() - 1);
        }
        if self.time.0.is_multiple_of(gnss::FIX_NS) {
            let base = self.base_link();
            self.fix = self
                .gnss
                .as_mut()
                .and_then(|gnss| gnss.fix(&self.stage.caster, self.time, &base));
        }
        self.note_contact();
    }

    fn note_contact(&mut self) {
        let Some(contact) = self.physics.contact() else {
            return;
        };
        let known = self
            .last_touch
            .iter_mut()
            .find(|(class, _)| *class == contact.class);
        let fresh = match known {
            Some((_, last)) => {
                self.time.0 - std::mem::replace(last, self.time).0 > SAME_COLLISION_NS
            }
            None => {
                self.last_touch.push((contact.class, self.time));
                true
            }
        };
        if fresh {
            let pose = Pose2::from_pose3(&self.base_link());
            self.collisions.push(Collision {
                time: self.time,
                class: contact.class,
                impulse: contact.impulse,
                pose,
                speed: self.speed,
                cut_off: self.has_cut_off(contact.class),
            });
        }
    }

    fn has_cut_off(&self, class: SemanticClass) -> bool {
        let kind = match class {
            SemanticClass::Person => MoverKind::Pedestrian,
            SemanticClass::Vehicle => MoverKind::Car,
            _ => return false,
        };
        self.yielding.cut_off(kind, self.movers())
    }

    fn extend_chain(&mut self) {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.chain);
        hasher.update(&self.time.0.to_le_bytes());
        hasher.update(&self.physics.state_bytes());
        let inertial = self
            .imu_samples
            .iter()
            .flat_map(|s| s.gyro.into_iter().chain(s.accel));
        let wheels = self.wheel_samples.iter().flat_map(|s| [s.left, s.right]);
        inertial.chain(wheels).for_each(|value| {
            hasher.update(&value.to_le_bytes());
        });
        if let Some(scan) = &self.scan {
            let bytes: Vec<u8> = scan
                .points
                .iter()
                .flat_map(|p| p.xyz)
                .flat_map(f32::to_le_bytes)
                .collect();
            hasher.update(&bytes);
        }
        for mover in self.movers() {
            hasher.update(&[u8::from(mover.present)]);
            for value in [mover.pose.x, mover.pose.y, mover.pose.yaw] {
                hasher.update(&value.to_le_bytes());
            }
        }
        if let Some(fix) = &self.fix {
            fix.position.iter().for_each(|value| {
                hasher.update(&value.to_le_bytes());
            });
        }
        self.chain = *hasher.finalize().as_bytes();
    }
}
