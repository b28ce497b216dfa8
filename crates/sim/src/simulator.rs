//! The robot in a world, in lock-step.

use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;

use openbench_core::{
    GnssFix, ImuSample, LidarScan, MapPoint, Observation, Pose2, Pose3, RobotDescription, SimTime,
    Velocity, WheelSample,
};
use openbench_osm::OsmMap;
use openbench_scene::{FreeSpace, Movers, SemanticClass, Snapshot, ground_height};

use crate::camera::SimCamera;
use crate::clock::{OBSERVATION_NS, STEP_NS};
use crate::collision::{Collision, ContactHistory};
use crate::crowd::Crowd;
use crate::defects::Defects;
use crate::encoders::Encoders;
use crate::error::SimError;
use crate::gnss::{FIX_NS, Gnss};
use crate::imu::{Imu, SAMPLE_NS};
use crate::left_world::{LeftWorld, left_world};
use crate::lidar::{Lidar, SCAN_NS, Scanning};
use crate::noise::Noise;
use crate::physics::Physics;
use crate::stage::Stage;
use crate::surroundings::Surroundings;
use crate::traffic::{
    Mover, MoverKind, PERSON_RADIUS_M, RobotState, RobotWatch, Traffic, TrafficPlan,
};

/// A robot whose wheels' rims are slower than this does not drive, m/s.
const STANDING_SPEED: f64 = 0.01;
/// Streams of random numbers of the sensors. The numbers are part of every recorded run; traffic
/// has others.
const IMU_STREAM: u64 = 1;
const LIDAR_STREAM: u64 = 2;
const GNSS_STREAM: u64 = 3;
/// Distinguishes the numbers of the LiDAR's errors from those of the camera.
const BEAM_STREAM: u64 = 0x5eed_beac;

/// The robot in a world. Time moves only in [`Simulator::step`].
pub struct Simulator {
    stage: Stage,
    /// As it is described.
    robot: RobotDescription,
    defects: Defects,
    /// How wet the ground is, 0 to 1.
    wetness: f64,
    /// Pose of the LiDAR in `base_link`, as it is.
    lidar_mount: Pose3,
    physics: Physics,
    /// Height of the ground at the start, metres.
    ground: f64,
    imu: Imu,
    encoders: Encoders,
    lidar: Lidar,
    scanning: Scanning,
    /// Poses of the LiDAR in `map` since the present scan began, one for each physics step.
    lidar_path: Vec<Pose3>,
    crowd: Option<Crowd>,
    watch: RobotWatch,
    movers: Arc<Movers>,
    time: SimTime,
    imu_samples: Vec<ImuSample>,
    wheel_samples: Vec<WheelSample>,
    scan: Option<LidarScan>,
    gnss: Option<Gnss>,
    fix: Option<GnssFix>,
    /// Added to the positions of fixes, metres.
    fix_shift: MapPoint,
    camera: SimCamera,
    collisions: Vec<Collision>,
    contacts: ContactHistory,
    /// Speed of the robot's fastest corner when the last step began, m/s.
    speed: f64,
    chain: [u8; 32],
    seed: u64,
}

impl Simulator {
    /// Puts the robot at `start` on the ground there. The same stage, robot, start, seed and
    /// velocities give the same bytes.
    pub fn new(stage: Stage, robot: RobotDescription, start: Pose2, seed: u64) -> Self {
        Self::with_defects(stage, robot, &Defects::default(), start, seed)
    }

    /// The same with a robot that differs from its description.
    pub fn with_defects(
        stage: Stage,
        robot: RobotDescription,
        defects: &Defects,
        start: Pose2,
        seed: u64,
    ) -> Self {
        let ground = ground_height(stage.caster(), start.point());
        let physics = Physics::new(&stage.solids, &robot, defects, start, ground);
        let imu = Imu::new(Noise::new(seed, IMU_STREAM), defects.imu.of(robot.imu));
        let lidar = Lidar::new(Noise::new(seed, LIDAR_STREAM));
        let gnss = robot
            .gnss
            .map(|antenna| Gnss::new(Noise::new(seed, GNSS_STREAM), antenna));
        let optics = robot.camera_intrinsics;
        let mount = defects.camera.of(robot.camera);
        let camera = SimCamera::new(stage.renderer.clone(), optics, mount);
        let lidar_mount = defects.lidar.of(robot.lidar);
        let watch = RobotWatch::new(robot.max_acceleration);
        let mut simulator = Self {
            // First, since `physics` moves into the field below.
            lidar_path: vec![physics.base_link() * lidar_mount],
            lidar_mount,
            defects: *defects,
            wetness: 0.0,
            stage,
            robot,
            physics,
            ground,
            imu,
            encoders: Encoders::new(defects),
            lidar,
            scanning: Scanning::default(),
            crowd: None,
            watch,
            movers: Arc::default(),
            time: SimTime::ZERO,
            imu_samples: Vec::new(),
            wheel_samples: Vec::new(),
            scan: None,
            gnss,
            fix: None,
            fix_shift: MapPoint::default(),
            camera,
            collisions: Vec::new(),
            contacts: ContactHistory::default(),
            speed: 0.0,
            chain: [0; 32],
            seed,
        };
        simulator.move_camera();
        simulator
    }

    /// Changes what sensors and tyres meet: faults, another light, wet ground. Before traffic or
    /// after it, but before the first step.
    pub fn in_surroundings(mut self, surroundings: &Surroundings) -> Self {
        let optics = self.robot.camera_intrinsics;
        let camera = surroundings.camera(&optics, self.stage.caster(), self.seed);
        if let Some(camera) = camera {
            self.camera.replace(camera);
            self.move_camera();
        }
        self.wetness = surroundings.weather.wetness;
        let air = surroundings.weather.air();
        let seed = self.seed ^ BEAM_STREAM;
        self.lidar = self.lidar.with_errors(surroundings.lidar, air, seed);
        self
    }

    /// Puts people and cars into the world.
    ///
    /// # Errors
    /// [`SimError::NoFigures`] if the stage was made for fewer, see [`Stage::with_figures`].
    pub fn with_traffic(mut self, traffic: Traffic) -> Result<Self, SimError> {
        if !self.stage.gallery.suffices(traffic.placed()) {
            return Err(SimError::NoFigures);
        }
        let gallery = self.stage.gallery.clone();
        let crowd = Crowd::new(traffic, gallery, self.stage.caster(), &mut self.physics);
        crowd.show(self.stage.caster(), Arc::make_mut(&mut self.movers));
        self.crowd = Some(crowd);
        self.move_camera();
        Ok(self)
    }

    /// Puts as many people and cars as in `plan` on the footways and roads of a map, as far as
    /// there is room for them around the robot.
    ///
    /// # Errors
    /// As [`with_traffic`](Self::with_traffic).
    pub fn with_traffic_on(
        self,
        map: &OsmMap,
        plan: TrafficPlan,
        seed: u64,
    ) -> Result<Self, SimError> {
        let start = self.robot_state().position;
        // Only places connected with the robot's own: nobody walks in a closed yard or inside a
        // building.
        let space = FreeSpace::new(self.stage.caster(), start, PERSON_RADIUS_M);
        self.with_traffic(Traffic::new(
            map,
            |p| space.is_reachable(p),
            plan,
            start,
            seed,
        ))
    }

    /// Satellite fixes in a frame whose coordinates are those of the world plus `shift`: that of
    /// the map that the robot has.
    #[must_use]
    pub fn with_fixes_shifted(self, shift: MapPoint) -> Self {
        Self {
            fix_shift: shift,
            ..self
        }
    }

    /// Sets how much of the LiDAR's scans is cast from now on. The hash over all states and sensor
    /// data depends on it.
    pub fn set_scanning(&mut self, scanning: Scanning) {
        self.scanning = scanning;
    }

    /// Drives with `velocity` until the next observation, 50 ms later.
    pub fn step(&mut self, velocity: Velocity) {
        self.imu_samples.clear();
        self.wheel_samples.clear();
        self.scan = None;
        self.fix = None;
        let robot = self.robot_state();
        let rim = velocity.angular.abs() * self.robot.circumscribed_radius();
        self.speed = libm::hypot(robot.velocity[0], robot.velocity[1]) + rim;
        // Movers decide by what the robot does now, and then move in step with it.
        self.step_crowd(robot);
        if self.defects.slips {
            self.physics
                .feel_surfaces(self.stage.caster(), self.wetness);
        }
        for _ in 0..OBSERVATION_NS / STEP_NS {
            self.step_physics(velocity);
        }
        self.move_camera();
        self.extend_chain();
    }

    /// Puts the robot on the ground elsewhere, at rest. Its sensors notice nothing of the way, as
    /// if they had been off, and the scan that is under way is taken at the new place.
    pub fn carry_to(&mut self, place: Pose2) {
        let ground = ground_height(self.stage.caster(), place.point());
        self.physics.put(place, ground);
        self.imu.rest();
        self.lidar_path
            .fill(self.physics.base_link() * self.lidar_mount);
        self.move_camera();
    }

    /// The sensor data since the last step.
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

    /// Sizes and sensors of the robot, as they are described.
    pub fn robot(&self) -> &RobotDescription {
        &self.robot
    }

    /// Simulated time now.
    pub fn time(&self) -> SimTime {
        self.time
    }

    /// Ground truth: pose of `base_link` in `map`.
    pub fn base_link(&self) -> Pose3 {
        self.physics.base_link()
    }

    /// Ground truth: speed of the robot in `map`, m/s.
    pub fn speed(&self) -> f64 {
        self.physics
            .velocity_at(nalgebra::Vector3::zeros())
            .xy()
            .norm()
    }

    /// Ground truth: the robot as people and cars see it.
    pub fn robot_state(&self) -> RobotState {
        let velocity = self.physics.velocity_at(nalgebra::Vector3::zeros());
        RobotState {
            position: Pose2::from_pose3(&self.base_link()).point(),
            velocity: [velocity.x, velocity.y],
            radius: self.robot.circumscribed_radius(),
        }
    }

    /// Ground truth: people and cars; empty in a world without traffic.
    pub fn movers(&self) -> &[Mover] {
        self.crowd.as_ref().map_or(&[], Crowd::movers)
    }

    /// Ground truth: people and cars at their places, as rays meet them.
    pub fn placed_movers(&self) -> Arc<Movers> {
        self.movers.clone()
    }

    /// Ground truth: the scene now.
    pub fn snapshot(&self) -> Snapshot<'_> {
        self.stage.snapshot(&self.movers)
    }

    /// Ground truth: how the robot left the world, if it did.
    pub fn left_world(&self) -> Option<LeftWorld> {
        left_world(&self.base_link(), &self.stage.bounds, self.ground)
    }

    /// Every collision so far.
    pub fn collisions(&self) -> &[Collision] {
        &self.collisions
    }

    /// The time that the robot has been in contact with each class of objects so far.
    pub fn contact_durations(&self) -> BTreeMap<SemanticClass, Duration> {
        self.contacts.durations()
    }

    /// Hash over all states and sensor data so far.
    pub fn hash_chain(&self) -> [u8; 32] {
        self.chain
    }

    fn move_camera(&mut self) {
        self.camera
            .move_to(self.time, self.base_link(), self.movers.clone());
    }

    fn step_crowd(&mut self, robot: RobotState) {
        let Some(crowd) = &mut self.crowd else { return };
        let rim = self.robot.wheel_radius * self.physics.wheel_speeds().fastest();
        let seconds = OBSERVATION_NS as f64 * 1e-9;
        self.watch
            .update(seconds, &robot, rim > STANDING_SPEED, crowd.movers());
        // The camera still shares the figures of the last step, and keeps those: this copies them.
        let figures = Arc::make_mut(&mut self.movers);
        crowd.step(robot, self.stage.caster(), &mut self.physics, figures);
    }

    fn step_physics(&mut self, velocity: Velocity) {
        self.physics.step(self.stage.caster(), velocity);
        self.time.0 += STEP_NS;
        self.encoders
            .turn(self.physics.wheel_speeds(), STEP_NS as f64 * 1e-9);
        if self.time.0.is_multiple_of(SAMPLE_NS) {
            self.imu_samples
                .push(self.imu.sample(self.time, &self.physics));
            self.wheel_samples.push(self.encoders.sample(self.time));
        }
        self.camera.pass(self.time, self.physics.base_link());
        self.lidar_path.push(self.base_link() * self.lidar_mount);
        if self.time.0.is_multiple_of(SCAN_NS) {
            self.take_scan();
        }
        if self.time.0.is_multiple_of(FIX_NS) {
            let base = self.base_link();
            let caster = self.stage.caster();
            let fix = self
                .gnss
                .as_mut()
                .and_then(|gnss| gnss.fix(caster, self.time, &base));
            self.fix = fix.map(|fix| shifted(fix, self.fix_shift));
        }
        // Last, so that the collision has the pose and the time of this step.
        self.note_contact();
    }

    fn take_scan(&mut self) {
        if let Scanning::OneFiringIn(stride) = self.scanning {
            let began = SimTime(self.time.0 - SCAN_NS);
            // Scans end where steps end, and the movers already have the places of that instant.
            let seen = self.stage.snapshot(&self.movers);
            let scan = self.lidar.scan(seen, began, &self.lidar_path, stride);
            self.scan = Some(LidarScan {
                stamp: self.defects.lidar_stamp(scan.stamp),
                ..scan
            });
        } else {
            self.lidar.skip();
        }
        // The next scan begins at the last pose of this one.
        self.lidar_path.drain(..self.lidar_path.len() - 1);
    }

    fn note_contact(&mut self) {
        let Some(contact) = self.physics.contact() else {
            return;
        };
        if self.contacts.begins_collision(contact.class, self.time) {
            self.collisions.push(Collision {
                time: self.time,
                class: contact.class,
                impulse: contact.impulse,
                pose: Pose2::from_pose3(&self.base_link()),
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
        self.watch.cut_off(kind, self.movers())
    }

    fn extend_chain(&mut self) {
        // Images are left out: whether one is rendered depends on what the agent asks for.
        let mut hasher = blake3::Hasher::new();
        hasher.update(&self.chain);
        hasher.update(&self.time.0.to_le_bytes());
        hasher.update(&self.physics.state_bytes());
        for sample in &self.imu_samples {
            update(&mut hasher, &sample.gyro);
            update(&mut hasher, &sample.accel);
        }
        for sample in &self.wheel_samples {
            update(&mut hasher, &[sample.left, sample.right]);
        }
        if let Some(scan) = &self.scan {
            let coordinates = scan.points.iter().flat_map(|p| p.xyz);
            hasher.update(&coordinates.flat_map(f32::to_le_bytes).collect::<Vec<u8>>());
        }
        for mover in self.movers() {
            hasher.update(&[u8::from(mover.present)]);
            update(&mut hasher, &[mover.pose.x, mover.pose.y, mover.pose.yaw]);
        }
        if let Some(fix) = &self.fix {
            update(&mut hasher, &fix.position);
        }
        self.chain = *hasher.finalize().as_bytes();
    }
}

fn shifted(fix: GnssFix, shift: MapPoint) -> GnssFix {
    let [x, y, z] = fix.position;
    GnssFix {
        position: [x + shift.x, y + shift.y, z],
        ..fix
    }
}

fn update(hasher: &mut blake3::Hasher, values: &[f64]) {
    for value in values {
        hasher.update(&value.to_le_bytes());
    }
}
