//! A mission in a plain with one house, step by step, with parts that do as the tests say.

use std::sync::{Arc, Mutex};

use nalgebra::Vector2;
use openbench_core::{
    Camera, Discard, Georeference, Health, Image, LonLat, Plan, Pose2, Start, Step,
};
use openbench_localization::Localizer;
use openbench_localization::registration::BuildingOffset;
use openbench_models::{ChatError, Meter};
use openbench_motion::costmap::Preferences;
use openbench_motion::follower;
use openbench_vision::PlateReading;

use super::*;

/// One house of some 6 m x 6 m.
const MAP: &str = r#"<osm version="0.6">
  <node id="1" lat="50.0" lon="8.0"/><node id="2" lat="50.0" lon="8.00008"/>
  <node id="3" lat="50.00005" lon="8.00008"/><node id="4" lat="50.00005" lon="8.0"/>
  <way id="5"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/>
    <tag k="building" v="yes"/><tag k="name" v="building1"/></way></osm>"#;

fn house() -> OsmMap {
    let data = OsmData::from_bytes(MAP.as_bytes()).unwrap();
    let georeference = Georeference::tangent_plane(LonLat::new(8.0, 50.0));
    OsmMap::new(&data, georeference)
}

#[test]
fn a_mapped_door_hangs_on_the_nearest_wall_and_faces_away_from_it() {
    let address = Address::new("building1", "unit1");
    let south = MapPoint::new(3.0, -0.4);
    let door = mapped_door(&house(), 0, &address, south);
    assert!(door.position.distance(MapPoint::new(3.0, 0.0)) < 0.01);
    assert!((door.facing + std::f64::consts::FRAC_PI_2).abs() < 0.01);
    assert_eq!((door.unit.as_str(), door.confidence), ("unit1", 1.0));
}

#[test]
fn a_planner_that_does_not_answer_is_not_the_instructions_fault() {
    let unclear = PlanError::NotUnderstood {
        instruction: "Hello".into(),
        hint: "name a building".into(),
    };
    assert_eq!(cause_of(&unclear), FailureCause::NotUnderstood);
    let silent = PlanError::ModelUnavailable {
        model: "m".into(),
        source: ChatError::Timeout {
            endpoint: "e".into(),
            seconds: 1,
        },
    };
    assert_eq!(cause_of(&silent), FailureCause::PlannerUnavailable);
}

/// Plans these doors, whatever the instruction says.
struct Planned(Vec<Address>);

impl Planner for Planned {
    fn name(&self) -> &str {
        "planned"
    }

    fn plan(&self, _: &PlanRequest<'_>) -> Result<Plan, PlanError> {
        let delivery = |(instruction_index, address): (usize, &Address)| PlannedDelivery {
            instruction_index,
            item: "box".into(),
            building: address.building.clone(),
            unit: address.unit.clone(),
            levels: Vec::new(),
            steps: Vec::<Step>::new(),
            confidence: 1.0,
            problem: None,
            deadline: None,
        };
        Ok(Plan {
            planner: "planned".into(),
            deliveries: self.0.iter().enumerate().map(delivery).collect(),
            fallbacks: Vec::new(),
        })
    }
}

/// A reader without eyes.
struct Blind;

impl PlateReader for Blind {
    fn name(&self) -> &str {
        "blind"
    }

    fn read(&mut self, _: &Image) -> Result<Vec<PlateReading>, ReaderError> {
        Err(ReaderError::Chat(ChatError::Timeout {
            endpoint: "e".into(),
            seconds: 1,
        }))
    }
}

/// What a test says about the localizer.
#[derive(Debug, Clone, Copy)]
struct Said {
    health: Health,
    is_located: bool,
    is_presumed: bool,
    /// How far the robot turned out to be from its start, metres.
    away: f64,
    /// How far east of its place on the map the house turned out to be, metres.
    house_off: f64,
}

/// Stands at the start, and is what a test says.
struct Standing {
    start: Pose2,
    away: f64,
    offsets: Vec<BuildingOffset>,
    said: Arc<Mutex<Said>>,
}

impl Localizer for Standing {
    fn name(&self) -> &str {
        "standing"
    }

    fn reset(&mut self, start: Pose2) {
        self.start = start;
    }

    fn update(&mut self, _: &Observation<'_>) {
        let said = *self.said.lock().unwrap();
        self.away = said.away;
        self.offsets = vec![BuildingOffset {
            building: 0,
            offset: Vector2::new(said.house_off, 0.0),
        }];
    }

    fn building_offsets(&self) -> &[BuildingOffset] {
        &self.offsets
    }

    fn pose_at(&self, _: SimTime) -> Pose2 {
        self.start
    }

    fn pose(&self) -> Pose2 {
        Pose2::new(self.start.x - self.away, self.start.y, self.start.yaw)
    }

    fn ready(&self) -> bool {
        true
    }

    fn odom(&self) -> Pose2 {
        Pose2::new(-self.away, 0.0, 0.0)
    }

    fn is_located(&self) -> bool {
        self.said.lock().unwrap().is_located
    }

    fn is_presumed(&self) -> bool {
        self.said.lock().unwrap().is_presumed
    }

    fn health(&self) -> Health {
        self.said.lock().unwrap().health
    }
}

/// A camera that has an image, or none yet.
struct Shutter(bool);

impl Camera for Shutter {
    fn image(&self) -> Option<Arc<Image>> {
        let image = Image {
            stamp: SimTime::ZERO,
            width: 1,
            height: 1,
            rgb: vec![0; 3],
        };
        self.0.then(|| Arc::new(image))
    }
}

/// A mission to these doors, 8 m west of the house, and what its localizer says.
fn mission(doors: &[Address]) -> (Mission, Arc<Mutex<Said>>) {
    let start = Start::exact(Pose2::new(-8.0, 3.0, 0.0));
    let (mission, said) = begun(doors, start, true);
    (mission.unwrap(), said)
}

/// A mission that begins with this start, and a localizer that knows where it is or not.
fn begun(
    doors: &[Address],
    start: Start,
    is_located: bool,
) -> (Result<Mission, GiveUp>, Arc<Mutex<Said>>) {
    let said = Arc::new(Mutex::new(Said {
        health: Health::Good,
        is_located,
        is_presumed: false,
        away: 0.0,
        house_off: 0.0,
    }));
    let shared = said.clone();
    let parts = Parts {
        planner: Box::new(Planned(doors.to_vec())),
        reader: Box::new(Blind),
        localizer: Box::new(move |_| {
            Box::new(Standing {
                start: Pose2::default(),
                away: 0.0,
                offsets: Vec::new(),
                said: shared.clone(),
            })
        }),
        motion: follower::entry(),
        ground: Preferences::NONE,
        memory: None,
        meter: Meter::default(),
        thinks_in_simulated_time: false,
    };
    let briefing = Briefing {
        map_osm: MAP.as_bytes().to_vec(),
        georeference: Georeference::tangent_plane(LonLat::new(8.0, 50.0)),
        goal: Goal::Instruction("as planned".into()),
        start,
        robot: RobotDescription::sentry(),
        time_limit: Duration::from_secs(1200),
    };
    (Mission::begin(parts, &briefing, &mut Discard), said)
}

/// What a robot that stands without a scan observes.
fn observation(milliseconds: u64, camera: &Shutter) -> Observation<'_> {
    Observation {
        time: SimTime::from_millis(milliseconds),
        imu: &[],
        wheels: &[],
        scan: None,
        gnss: None,
        camera,
    }
}

fn act(mission: &mut Mission, milliseconds: u64, camera: &Shutter) -> Action {
    mission.act(&observation(milliseconds, camera), &mut Discard)
}

fn given_up(action: Action) -> GiveUp {
    match action {
        Action::GiveUp(give_up) => give_up,
        other => panic!("{other:?}"),
    }
}

fn door(unit: &str, confidence: f32) -> Sighting {
    Sighting {
        unit: unit.into(),
        building: 0,
        position: MapPoint::new(0.0, 3.0),
        facing: std::f64::consts::PI,
        confidence,
    }
}

#[test]
fn a_building_that_the_map_lacks_ends_its_own_delivery_only() {
    let (missing, there) = (
        Address::new("building9", "unit1"),
        Address::new("building1", "unit1"),
    );
    let (mut mission, _) = mission(&[missing.clone(), there]);
    let first = given_up(act(&mut mission, 50, &Shutter(true)));
    assert_eq!(first.address, Some(missing));
    assert_eq!(first.cause, FailureCause::UnknownAddress);
    // The next delivery begins.
    assert!(matches!(
        act(&mut mission, 100, &Shutter(true)),
        Action::Drive(_)
    ));
    assert!(mission.task.is_some());
}

#[test]
fn a_mission_without_deliveries_left_gives_up_what_it_did_not_plan() {
    let (mut mission, _) = mission(&[]);
    let all = given_up(act(&mut mission, 50, &Shutter(true)));
    assert_eq!((all.address, all.cause), (None, FailureCause::NotDeclared));
}

#[test]
fn a_lost_robot_stands_and_then_gives_up_everything() {
    let (mut mission, said) = mission(&[Address::new("building1", "unit1")]);
    said.lock().unwrap().health = Health::Lost;
    for seconds in 0..15 {
        let action = act(&mut mission, 1000 * seconds, &Shutter(true));
        assert_eq!(action, Action::Drive(Velocity::ZERO), "{seconds} s");
    }
    let all = given_up(act(&mut mission, 15_000, &Shutter(true)));
    assert_eq!((all.address, all.cause), (None, FailureCause::Lost));
}

/// A start that is known to be somewhere.
const SOMEWHERE: Start = Start::Area {
    centre: MapPoint::new(0.0, 0.0),
    radius_m: 75.0,
};

#[test]
fn a_start_that_is_not_known_is_no_start_for_a_localizer_that_does_not_search() {
    let doors = [Address::new("building1", "unit1")];
    let give_up = begun(&doors, SOMEWHERE, true).0.err().unwrap();
    assert_eq!(give_up.cause, FailureCause::Lost);
}

#[test]
fn a_robot_that_does_not_know_where_it_is_searches_before_it_plans() {
    let doors = [Address::new("building1", "unit1")];
    let (mission, said) = begun(&doors, SOMEWHERE, false);
    let mut mission = mission.unwrap();
    let mut events = Vec::new();
    for milliseconds in [50, 100, 3000] {
        let action = mission.act(&observation(milliseconds, &Shutter(true)), &mut events);
        assert!(matches!(action, Action::Drive(_)), "{action:?}");
    }
    assert!(mission.locating.is_some() && mission.task.is_none());
    let locating = Event::Stage(openbench_core::Stage::Locating);
    assert!(
        matches!(&events[..], [Event::Note(_), stage] if *stage == locating),
        "{events:?}"
    );
    said.lock().unwrap().is_located = true;
    events.clear();
    mission.act(&observation(3050, &Shutter(true)), &mut events);
    assert!(mission.locating.is_none() && mission.task.is_some());
    // Without a road it looks for the door at once.
    let now = Event::Stage(openbench_core::Stage::Searching);
    assert!(
        events.contains(&now) && !events.contains(&locating),
        "{events:?}"
    );
}

#[test]
fn a_search_that_finds_nothing_ends_with_the_start_as_given_or_with_the_episode() {
    let doors = [Address::new("building1", "unit1")];
    let near = Start::exact(Pose2::new(-8.0, 3.0, 0.0));
    let (mission, _) = begun(&doors, near, false);
    let mut mission = mission.unwrap();
    act(&mut mission, 0, &Shutter(true));
    assert!(mission.task.is_none());
    act(&mut mission, 1_000_000, &Shutter(true));
    act(&mut mission, 1_000_050, &Shutter(true));
    assert!(mission.locating.is_none() && mission.task.is_some());

    let (mission, _) = begun(&doors, SOMEWHERE, false);
    let mut mission = mission.unwrap();
    act(&mut mission, 0, &Shutter(true));
    let all = given_up(act(&mut mission, 1_000_000, &Shutter(true)));
    assert_eq!((all.address, all.cause), (None, FailureCause::Lost));
}

#[test]
fn a_robot_goes_on_where_it_probably_is_and_sets_out_again_where_it_is_not() {
    let doors = [Address::new("building1", "unit1")];
    let near = Start::exact(Pose2::new(-8.0, 3.0, 0.0));
    let (mission, said) = begun(&doors, near, false);
    let mut mission = mission.unwrap();
    act(&mut mission, 0, &Shutter(false));
    assert!(mission.locating.is_some() && mission.task.is_none());
    said.lock().unwrap().is_presumed = true;
    act(&mut mission, 50, &Shutter(false));
    assert!(mission.locating.is_none() && mission.task.is_some());
    // It is certain now, and was right: what was seen counts.
    mission.seen.push(door("unit1", 0.9));
    said.lock().unwrap().away = 0.05;
    act(&mut mission, 100, &Shutter(false));
    assert_eq!(mission.seen.len(), 1);
    // It was wrong.
    let mut events = Vec::new();
    said.lock().unwrap().is_located = true;
    said.lock().unwrap().away = 3.15;
    mission.act(&observation(150, &Shutter(false)), &mut events);
    assert!(mission.task.is_some());
    // The plate is where it was seen from the robot.
    let seen = mission.seen[0].position;
    assert!(seen.distance(MapPoint::new(-3.15, 3.0)) < 1e-9, "{seen}");
    assert!(
        matches!(&events[0], Event::Note(note) if note.contains("is 3.1 m from")),
        "{events:?}"
    );
}

#[test]
fn a_robot_that_was_carried_away_searches_and_sets_out_again() {
    let (mut mission, said) = mission(&[Address::new("building1", "unit1")]);
    act(&mut mission, 50, &Shutter(false));
    assert!(mission.task.is_some());
    mission.seen.push(door("unit1", 0.9));
    said.lock().unwrap().is_located = false;
    act(&mut mission, 100, &Shutter(false));
    assert!(mission.locating.is_some() && mission.seen.is_empty());
    said.lock().unwrap().is_located = true;
    act(&mut mission, 150, &Shutter(false));
    assert!(mission.locating.is_none() && mission.task.is_some());
    // Only once.
    mission.seen.push(door("unit1", 0.9));
    act(&mut mission, 200, &Shutter(false));
    assert_eq!(mission.seen.len(), 1);
}

#[test]
fn a_door_that_was_seen_moves_when_the_pose_is_corrected() {
    let address = Address::new("building1", "unit1");
    let (mut mission, said) = mission(std::slice::from_ref(&address));
    act(&mut mission, 50, &Shutter(false));
    mission.seen.push(door("unit1", 0.9));
    let task = mission.task.take().unwrap();
    let Next::GoOn(task, _) = mission.approach(task, door("unit1", 0.9)) else {
        panic!("on its way")
    };
    mission.task = Some(*task);
    let aim = |mission: &Mission| match &mission.task.as_ref().unwrap().stage {
        Stage::Approach(aim) => aim.clone(),
        other => panic!("{other:?}"),
    };
    // A few centimetres change where the door is, and not where the robot drives.
    said.lock().unwrap().away = 0.05;
    act(&mut mission, 100, &Shutter(false));
    let moved = aim(&mission);
    assert_eq!((moved.door.position.x, moved.then.x), (-0.05, 0.0));
    assert_eq!(mission.seen[0], moved.door);
    // Slowly, since a jump is a finding of its own.
    for step in 1..=10 {
        said.lock().unwrap().away = 0.05 + 0.05 * f64::from(step);
        act(&mut mission, 100 + 50 * step as u64, &Shutter(false));
    }
    let moved = aim(&mission);
    assert!((moved.door.position.x + 0.55).abs() < 1e-9);
    assert!(moved.then.x < -0.2, "{}", moved.then);
}

/// A mission on its way to look at the door of the map, from a place in front of it, and what its
/// localizer says.
fn checking() -> (Mission, Arc<Mutex<Said>>) {
    let address = Address::new("building1", "unit1");
    let (mut mission, said) = mission(std::slice::from_ref(&address));
    let task = Task::new(address, 0, Some(door("unit1", 1.0)));
    let Next::GoOn(task, _) = mission.check_door(task, &door("unit1", 1.0)) else {
        panic!("on its way")
    };
    mission.task = Some(*task);
    (mission, said)
}

#[test]
fn the_robot_drives_where_a_building_is_and_not_where_the_map_shows_it() {
    let (mut mission, said) = checking();
    let in_wall_on_map = MapPoint::new(0.5, 3.0);
    let is_blocked = |mission: &Mission| {
        let near = mission.driver.terrain().near();
        near.is_obstacle(near.grid().cell_at(in_wall_on_map).unwrap())
    };
    assert!(is_blocked(&mission));
    said.lock().unwrap().house_off = 4.0;
    act(&mut mission, 50, &Shutter(false));
    assert!(!is_blocked(&mission));
    // Places to look from are before its walls.
    let mut task = mission.task.take().unwrap();
    (task.expected, task.stage) = (None, Stage::Travel);
    let Next::GoOn(task, _) = mission.next_waypoint(task, &mut Discard) else {
        panic!("on its way")
    };
    let west = task.place.unwrap().wall;
    assert!((west.x - 4.0).abs() < 0.1, "{west}");
}

#[test]
fn what_only_the_map_says_of_a_delivery_moves_with_its_building() {
    let (mut mission, said) = checking();
    assert_eq!(mission.driver.target().unwrap().point.x, -CHECK_DISTANCE_M);
    said.lock().unwrap().house_off = 4.0;
    act(&mut mission, 50, &Shutter(false));
    let expected = mission.task.as_ref().unwrap().expected.clone();
    assert_eq!(expected.unwrap().position, MapPoint::new(4.0, 3.0));
    let target = mission.driver.target().unwrap().point;
    assert_eq!(target.x, 4.0 - CHECK_DISTANCE_M);
    // The robot is at the door, and it is a metre beside.
    let task = mission.task.take().unwrap();
    let on_map = task.expected.clone().unwrap();
    let Next::GoOn(task, _) = mission.approach(task, on_map) else {
        panic!("on its way")
    };
    mission.task = Some(*task);
    let step = mission.driver.target().unwrap().point;
    said.lock().unwrap().house_off = 5.0;
    act(&mut mission, 100, &Shutter(false));
    let target = mission.driver.target().unwrap().point;
    assert!(target.x > step.x + 0.3, "{target} {step}");
    // It is where the map shows it again, once that is forgotten.
    let mut task = mission.task.take().unwrap();
    task.expected = Some(Sighting {
        position: MapPoint::new(5.0, 3.0),
        ..door("unit1", 1.0)
    });
    mission.task = Some(task);
    mission.begin_anew();
    let expected = mission.task.unwrap().expected.unwrap();
    assert_eq!(expected.position, MapPoint::new(0.0, 3.0));
}

#[test]
fn a_door_that_was_seen_stays_when_its_building_moves_on_the_map() {
    let (mut mission, said) = checking();
    mission.seen.push(door("unit1", 1.0));
    said.lock().unwrap().house_off = 1.0;
    act(&mut mission, 50, &Shutter(false));
    let task = mission.task.as_ref().unwrap();
    assert_eq!(task.expected, Some(door("unit1", 1.0)));
    let target = mission.driver.target().unwrap().point;
    assert_eq!(target.x, -CHECK_DISTANCE_M);
}

#[test]
fn a_plate_that_turns_out_to_be_at_another_building_is_not_the_door() {
    let mut mission = looking();
    let mut task = mission.task.take().unwrap();
    task.stage = Stage::Approach(Aim::new(Sighting {
        building: 1,
        ..door("unit1", 0.9)
    }));
    let events = &mut Discard;
    let glimpse = mission.glance(&mut task, &observation(50, &Shutter(false)), events);
    assert!(matches!(glimpse, Glimpse::Refuted));
}

#[test]
fn a_plate_at_the_building_beside_is_the_last_resort() {
    let mut mission = looking();
    let address = Address::new("building1", "unit1");
    let at = |x: f64, unit: &str| Sighting {
        building: 1,
        position: MapPoint::new(x, 3.0),
        ..door(unit, 0.9)
    };
    mission.seen = vec![at(-9.0, "unit1"), at(-0.2, "unit7")];
    assert_eq!(mission.beside(0, &address), None);
    mission.seen.extend([at(-3.0, "unit1"), at(-1.5, "unit1")]);
    assert_eq!(mission.beside(0, &address).unwrap().position.x, -1.5);
    // Once: it may be out of reach.
    let (task, here) = (mission.task.take().unwrap(), MapPoint::new(-8.0, 3.0));
    let Next::GoOn(mut task, _) = mission.not_found(task, here) else {
        panic!("on its way")
    };
    assert!(matches!(task.stage, Stage::Approach(_)));
    task.looked = true;
    assert!(matches!(mission.not_found(*task, here), Next::End(_)));
}

/// A mission that stands at a waypoint since the time zero.
fn looking() -> Mission {
    let address = Address::new("building1", "unit1");
    let (mut mission, _) = mission(std::slice::from_ref(&address));
    let mut task = Task::new(address, 0, None);
    task.stage = Stage::Look(SimTime::ZERO);
    mission.task = Some(task);
    mission
}

#[test]
fn an_image_is_taken_when_the_robot_stands_still_and_the_camera_has_one() {
    let mut mission = looking();
    let stands = Action::Drive(Velocity::ZERO);
    // Too early, and then without an image: neither asks the reader, which would fail.
    assert_eq!(act(&mut mission, 200, &Shutter(true)), stands);
    assert_eq!(act(&mut mission, 900, &Shutter(false)), stands);
    let failed = given_up(act(&mut mission, 950, &Shutter(true)));
    assert_eq!(failed.cause, FailureCause::ReaderUnavailable);
    assert_eq!(failed.address, Some(Address::new("building1", "unit1")));
}

#[test]
fn an_unreadable_plate_of_the_building_is_looked_at_again_once() {
    let mut mission = looking();
    let mut task = mission.task.take().unwrap();
    let plate = |x: f64| crate::open::sighting::Location {
        position: MapPoint::new(x, 3.0),
        facing: std::f64::consts::PI,
    };
    // One on the wall, and one on something far from it.
    mission.look_closer(&mut task, &[plate(0.0), plate(-30.0)]);
    let views = task.waypoints.len();
    assert!(views > 0);
    mission.look_closer(&mut task, &[plate(0.1)]);
    assert_eq!(task.waypoints.len(), views);
}

#[test]
fn only_a_door_that_is_sure_enough_is_remembered() {
    let mut mission = looking();
    let address = Address::new("building1", "unit1");
    mission.seen.push(door("unit1", 0.3));
    assert_eq!(mission.remembered(0, &address), None);
    mission.seen.push(door("unit1", 0.9));
    assert_eq!(mission.remembered(0, &address), Some(door("unit1", 0.9)));
    // As much evidence for another number takes the trust away.
    mission
        .seen
        .extend([door("unit7", 0.9), door("unit7", 0.9)]);
    assert_eq!(mission.remembered(0, &address), None);
    assert_eq!(mission.remembered(1, &address), None, "another building");
}
