//! A suite prepared for runs: the world built, its free space computed, its doors looked up.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::time::Duration;

use openbench_core::{Address, Georeference, MapPoint, Pose2, RobotDescription};
use openbench_geometry::Bounds;
use openbench_osm::disturb::MapErrors;
use openbench_osm::{ElementId, Location, OsmData, OsmMap, Projection, locate};
use openbench_scene::{FreeSpace, World};
use openbench_sim::traffic::{PERSON_RADIUS_M, Traffic};
use openbench_sim::{Defects, Simulator, Stage, Surroundings};

use super::load_with;
use super::public_map::{OnMap, OtherMap, building_of};
use super::surroundings::surroundings;
use super::targets::{Target, find_doors, match_doors, read_truths};
use crate::BenchError;
use crate::suite::draw::Draw;
use crate::suite::{Condition, Episode, GoalKind, Suite, TargetSource};

/// Constant part of the time limit of a delivery.
const BASE_TIME_LIMIT_S: f64 = 120.0;
/// Time limit for each metre of the shortest path: eight times the time at 0.5 m/s.
const TIME_LIMIT_S_PER_M: f64 = 8.0 / 0.5;
/// Paths that the public limit allows for are longer than straight lines by this factor.
const PUBLIC_DETOUR: f64 = 2.0;

/// Largest straight-line distance from the start of doors that are drawn for a run, metres; as
/// `world generate` has it by default.
const MOST_FROM_START_M: f64 = 250.0;

/// An episode with its doors looked up.
#[derive(Debug, Clone, PartialEq)]
pub struct PreparedEpisode {
    /// The instruction for the agent.
    pub instruction: String,
    /// Pose of the robot at its beginning: the world's start, but in training.
    pub start: Pose2,
    /// The requested doors.
    pub targets: Vec<Target>,
    /// Pairs of indices into `targets`: the first has to be visited before the second.
    pub before: Vec<(usize, usize)>,
    /// Exact time limit for all deliveries. It depends on the doors, so agents do not get it.
    pub time_limit: Duration,
}

/// A suite with its world, ready to run.
pub struct Prepared {
    /// The suite.
    pub suite: Suite,
    /// Its episodes as they were given, before deliveries were drawn again for drawn doors.
    given: Vec<Episode>,
    /// The world.
    pub world: World,
    /// The world as the simulator needs it.
    pub stage: Stage,
    /// The free space of the robot's circumscribed circle.
    pub free_space: FreeSpace,
    /// The approach point of each door of the world: the free and reachable position in front of
    /// it; `None` if there is none.
    pub approach: Vec<Option<MapPoint>>,
    /// The episodes.
    pub episodes: Vec<PreparedEpisode>,
    /// The robot as agents know it.
    pub robot: RobotDescription,
    /// How the robot differs from that.
    pub defects: Defects,
    /// What its sensors meet.
    pub surroundings: Surroundings,
    /// The time limit of a delivery that agents are told: it follows from the public map alone.
    pub public_time_limit: Duration,
    /// The map of the world as it is, without doors, in metres.
    true_map: OsmMap,
    /// The building of each door of the world in that map.
    door_buildings: Vec<Option<ElementId>>,
    /// The public map, if it is not the true one.
    other_map: Option<OtherMap>,
    /// The free space of people; `None` in a world without traffic.
    people_space: Option<FreeSpace>,
    /// The file with the true positions of the doors, if one was given.
    pub truth: Option<PathBuf>,
}

impl Prepared {
    /// Builds the world of a suite and looks up its doors, by address or, if `truth` is given, by
    /// the true positions in that file. Where doors are drawn, so are deliveries that were drawn
    /// from doors of the world, see [`DoorPlaces`](crate::suite::DoorPlaces).
    ///
    /// # Errors
    /// A world that cannot be built, a truth file that does not fit, or an episode without
    /// deliveries or, unless a planner read them, with one to a door that the world lacks.
    pub fn new(suite: Suite, truth: Option<&Path>) -> Result<Self, BenchError> {
        Self::with_true_map(suite)?.with_episodes(truth)
    }

    /// Looks up the doors of the suite's episodes, see [`new`](Self::new).
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_episodes(mut self, truth: Option<&Path>) -> Result<Self, BenchError> {
        if truth.is_none() {
            self.draw_deliveries_again()?;
        }
        let truths = truth
            .map(|path| read_truths(path, &self.suite, &self.world.scene.doors))
            .transpose()?;
        self.episodes = self.look_up(truths.as_deref())?;
        let before = self.public_time_limit;
        self.draw_map()?;
        if self.public_time_limit != before {
            // No more than agents are told.
            let limit = |e: &PreparedEpisode| self.time_limit(e.start.point(), &e.targets);
            let limits: Vec<Duration> = self.episodes.iter().map(limit).collect();
            for (episode, limit) in self.episodes.iter_mut().zip(limits) {
                episode.time_limit = limit;
            }
        }
        // Absolute, since `run.json` has this path, and `verify` may be started in another folder.
        self.truth =
            truth.map(|path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned()));
        match self.missing_doors().into_iter().next() {
            // What a planner read may be wrong, and then the delivery fails.
            Some(missing) if self.target_source() != TargetSource::Planner => {
                Err(BenchError::world(format!("{missing}; correct its address")))
            }
            _ => Ok(self),
        }
    }

    /// Builds the world of a suite without its episodes.
    ///
    /// # Errors
    /// A world that cannot be built, or a public map that cannot be drawn.
    pub fn world_of(suite: Suite) -> Result<Self, BenchError> {
        let mut prepared = Self::with_true_map(suite)?;
        prepared.draw_map()?;
        Ok(prepared)
    }

    /// Builds the world of a suite. Which buildings the public map spares is not known before the
    /// episodes are.
    fn with_true_map(suite: Suite) -> Result<Self, BenchError> {
        let world = load_with(&suite.world, suite.alterations())?;
        let mut robot = suite.sensors.robot();
        robot.camera_intrinsics.distortion = suite.conditions.camera.distortion();
        let surroundings = surroundings(&world, &suite.conditions, suite.seed);
        let defects = suite.conditions.robot.draw(suite.seed);
        let stage =
            Stage::with_figures(world.scene.clone(), suite.traffic).map_err(BenchError::world)?;
        let space = |radius| FreeSpace::new(stage.caster(), world.start.point(), radius);
        // A circle fits at every heading or at none, so one grid is enough for all headings.
        let free_space = space(robot.circumscribed_radius());
        let people_space = (!suite.traffic.is_empty()).then(|| space(PERSON_RADIUS_M));
        let approach = world
            .scene
            .doors
            .iter()
            .map(|d| free_space.approach_point(d))
            .collect();
        let true_map = OsmMap::new(&world.map, world.georeference);
        let public_time_limit = public_time_limit(&true_map, Some(world.start.point()));
        let doors = world.scene.doors.iter();
        let door_buildings = doors.map(|door| building_of(&true_map, door)).collect();
        let (episodes, truth) = (Vec::new(), None);
        Ok(Self {
            given: suite.episodes.clone(),
            suite,
            world,
            stage,
            free_space,
            approach,
            episodes,
            robot,
            defects,
            surroundings,
            public_time_limit,
            true_map,
            door_buildings,
            other_map: None,
            people_space,
            truth,
        })
    }

    /// The same suite with a run's seed, if that makes a difference.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn of_seed(&self, seed: u64) -> Result<Option<Self>, BenchError> {
        let suite = self.suite.clone().with_seed(seed);
        if suite.seed == self.suite.seed {
            return Ok(None);
        }
        if suite.alterations() != self.suite.alterations() {
            // The world is another one, with more doors or fewer.
            let given = Suite {
                episodes: self.given.clone(),
                ..suite
            };
            return Self::new(given, self.truth.as_deref()).map(Some);
        }
        let other = self.redrawn(suite);
        Ok(Some(other.with_episodes(self.truth.as_deref())?))
    }

    /// The same world with another seed of what conditions draw, without its episodes.
    fn redrawn(&self, suite: Suite) -> Self {
        Self {
            defects: suite.conditions.robot.draw(suite.seed),
            surroundings: surroundings(&self.world, &suite.conditions, suite.seed),
            given: self.given.clone(),
            suite,
            world: self.world.clone(),
            stage: self.stage.clone(),
            free_space: self.free_space.clone(),
            approach: self.approach.clone(),
            episodes: Vec::new(),
            robot: self.robot.clone(),
            public_time_limit: public_time_limit(&self.true_map, Some(self.world.start.point())),
            true_map: self.true_map.clone(),
            door_buildings: self.door_buildings.clone(),
            other_map: None,
            people_space: self.people_space.clone(),
            truth: None,
        }
    }

    /// Draws the public map and what follows from it.
    fn draw_map(&mut self) -> Result<(), BenchError> {
        let conditions = self.suite.conditions;
        if !(conditions.map.is_off() && conditions.start.is_off()) {
            self.draw_other_map(&conditions.map)?;
        }
        let start = self.on_map().point(self.world.start.point());
        let told = Some(start).filter(|_| conditions.start.is_off());
        self.public_time_limit = public_time_limit(self.public_map(), told);
        Ok(())
    }

    fn draw_other_map(&mut self, errors: &MapErrors) -> Result<(), BenchError> {
        let targets = self.episodes.iter().flat_map(|episode| &episode.targets);
        let ordered: BTreeSet<ElementId> = targets
            .filter_map(|target| self.building(target.door?))
            .collect();
        let other = OtherMap::new(&self.world, errors, &ordered, self.suite.seed)?;
        self.other_map = Some(other);
        Ok(())
    }

    /// Draws the deliveries of a suite again if they were drawn from doors of the world, and some
    /// of its doors depend on the seed: as many, each to as many doors.
    fn draw_deliveries_again(&mut self) -> Result<(), BenchError> {
        let has_drawn = (self.world.doors).is_some_and(|drawn| drawn.doors + drawn.without > 0);
        if !has_drawn || self.suite.targets != TargetSource::World {
            return Ok(());
        }
        let doors = self.deliverable(MOST_FROM_START_M);
        if doors.is_empty() {
            return Err(BenchError::world(format!(
                "{}: a robot reaches no door within {MOST_FROM_START_M} m; use another seed",
                self.suite.name
            )));
        }
        let episodes = &self.suite.episodes;
        self.suite.episodes = Draw::new(doors, self.suite.seed).like(episodes);
        Ok(())
    }

    /// The addresses of the doors that a robot reaches, that an instruction can name, and that lie
    /// within so many metres of the start, in a straight line.
    pub fn deliverable(&self, max_distance_m: f64) -> Vec<Address> {
        let start = self.world.start.point();
        let doors = self.world.scene.doors.iter().zip(&self.approach);
        let reached = doors.filter(|(_, approach)| approach.is_some());
        reached
            .map(|(door, _)| door)
            .filter(|door| door.point().distance(start) <= max_distance_m)
            .filter(|door| is_unique(&self.true_map, &door.address))
            .map(|door| door.address.clone())
            .collect()
    }

    /// Where the doors of the episodes are known from.
    pub fn target_source(&self) -> TargetSource {
        if self.truth.is_some() {
            TargetSource::Positions
        } else {
            self.suite.targets
        }
    }

    /// The map of the world as it is, without doors, in metres in the `map` frame of the world.
    pub fn true_map(&self) -> &OsmMap {
        &self.true_map
    }

    /// The public map, in metres in its own `map` frame: what agents get.
    pub fn public_map(&self) -> &OsmMap {
        self.other_map
            .as_ref()
            .map_or(&self.true_map, OtherMap::map)
    }

    /// The data of the public map.
    pub fn public_data(&self) -> &OsmData {
        let other = self.other_map.as_ref().and_then(OtherMap::data);
        other.unwrap_or(&self.world.map)
    }

    /// How the `map` frame of the public map lies on the Earth.
    pub fn public_georeference(&self) -> Georeference {
        self.public_map().projection.georeference()
    }

    /// Where things of the world are on the public map.
    pub fn on_map(&self) -> OnMap<'_> {
        OnMap::of(self.other_map.as_ref())
    }

    /// The building of a door of the world, by its number in the true map.
    pub fn building(&self, door: usize) -> Option<ElementId> {
        self.door_buildings[door]
    }

    /// Whether a map has doors of this world exactly where they are. A robot measures doors to
    /// decimetres, so such a map is the one that the world is made from, and no memory of a robot.
    pub fn is_own_map(&self, map: &OsmData) -> bool {
        // OSM keeps degrees to 1e-7, which is about a centimetre.
        const EXACT_M: f64 = 0.02;
        // One or two may lie there by chance.
        const LEAST: usize = 3;
        let found = entrances(map, self.world.georeference);
        let doors: Vec<MapPoint> = self
            .world
            .scene
            .doors
            .iter()
            .map(|d| d.entrance().point())
            .collect();
        let is_exact = |at: &&MapPoint| doors.iter().any(|door| door.distance(**at) < EXACT_M);
        let exact = found.iter().filter(is_exact).count();
        exact >= LEAST && 2 * exact > found.len()
    }

    /// The people and cars of an episode; `None` in a world without traffic.
    pub fn traffic(&self, seed: u64) -> Option<Traffic> {
        let space = self.people_space.as_ref()?;
        let fits = |at: MapPoint| space.is_reachable(at);
        Some(Traffic::new(
            self.true_map(),
            fits,
            self.suite.traffic,
            self.world.start.point(),
            seed,
        ))
    }

    /// The simulator with the robot at the world's start, with people and cars.
    ///
    /// # Errors
    /// [`BenchError::World`] if people and cars cannot be placed.
    pub fn simulator(&self, seed: u64) -> Result<Simulator, BenchError> {
        self.simulator_at(self.world.start, seed)
    }

    /// The simulator with the robot at a pose, with people and cars.
    ///
    /// # Errors
    /// As [`simulator`](Self::simulator).
    pub fn simulator_at(&self, start: Pose2, seed: u64) -> Result<Simulator, BenchError> {
        let (stage, robot) = (self.stage.clone(), self.robot.clone());
        let simulator = Simulator::with_defects(stage, robot, &self.defects, start, seed)
            .with_fixes_shifted(self.on_map().shift())
            .in_surroundings(&self.surroundings);
        match self.traffic(seed) {
            Some(traffic) => simulator.with_traffic(traffic).map_err(BenchError::world),
            None => Ok(simulator),
        }
    }

    fn look_up(&self, truths: Option<&[Vec<usize>]>) -> Result<Vec<PreparedEpisode>, BenchError> {
        let episodes = self.suite.episodes.iter().enumerate();
        episodes
            .map(|(i, episode)| {
                let doors = &self.world.scene.doors;
                let targets = match truths {
                    Some(truths) => match_doors(episode, &truths[i], doors),
                    None => find_doors(episode, doors),
                };
                if targets.is_empty() {
                    return Err(BenchError::NothingToDeliver {
                        episode: i,
                        instruction: episode.instruction.clone(),
                    });
                }
                let start = self.world.start;
                let episode = PreparedEpisode {
                    instruction: episode.instruction.clone(),
                    start,
                    time_limit: self.time_limit(start.point(), &targets),
                    targets,
                    before: episode.before.clone(),
                };
                if self.suite.goal == GoalKind::Point && self.point_goal(&episode).is_none() {
                    return Err(no_point_goal(i, &episode));
                }
                Ok(episode)
            })
            .collect()
    }

    /// An episode from another start, with the time limit that follows from it.
    #[must_use]
    pub fn starting_at(&self, start: Pose2, episode: PreparedEpisode) -> PreparedEpisode {
        PreparedEpisode {
            start,
            time_limit: self.time_limit(start.point(), &episode.targets),
            ..episode
        }
    }

    /// The place in front of the door of an episode with one delivery.
    pub fn point_goal(&self, episode: &PreparedEpisode) -> Option<MapPoint> {
        match episode.targets[..] {
            [
                Target {
                    door: Some(door), ..
                },
            ] => self.approach[door],
            _ => None,
        }
    }

    /// The exact time limit: for each delivery no more than agents were told.
    fn time_limit(&self, mut from: MapPoint, targets: &[Target]) -> Duration {
        let public = self.public_time_limit.as_secs_f64();
        let mut seconds = 0.0;
        for target in targets {
            // An agent may search for a door that does not exist for this time only.
            let Some(door) = target.door else {
                seconds += BASE_TIME_LIMIT_S;
                continue;
            };
            let plate = self.world.scene.doors[door].point();
            // A door without an approach point can still be declared by the paper's criterion, so
            // it has a limit.
            let length = self
                .shortest(from, door)
                .unwrap_or_else(|| from.distance(plate));
            seconds += (BASE_TIME_LIMIT_S + TIME_LIMIT_S_PER_M * length).min(public);
            from = self.approach[door].unwrap_or(plate);
        }
        Duration::from_millis((seconds * 1000.0) as u64)
    }

    /// Warnings for the user before a run: requested doors that do not exist, and people and cars
    /// for which there is no space.
    pub fn warnings(&self) -> Vec<String> {
        let mut warnings = self.missing_doors();
        warnings.extend(self.missing_traffic());
        warnings
    }

    fn missing_traffic(&self) -> Option<String> {
        let (placed, wanted) = (self.traffic(0)?.placed(), self.suite.traffic);
        (placed != wanted).then(|| {
            format!(
                "there is space for {} of {} people and {} of {} cars on the roads and paths near \
                 the start",
                placed.pedestrians, wanted.pedestrians, placed.cars, wanted.cars
            )
        })
    }

    fn missing_doors(&self) -> Vec<String> {
        let targets = self
            .episodes
            .iter()
            .enumerate()
            .flat_map(|(i, e)| e.targets.iter().map(move |t| (i, t)));
        let missing = targets.filter(|(_, t)| t.door.is_none());
        missing
            .map(|(i, t)| {
                let (address, known) = (&t.address, self.doors_for(&t.address));
                format!("episode {i}: the world has no door {address}; there are {known}")
            })
            .collect()
    }

    /// The doors of a building, or of the whole world if it has none.
    fn doors_for(&self, address: &Address) -> String {
        let doors = || self.world.scene.doors.iter().map(|door| &door.address);
        let of_building = doors().filter(|door| door.same_building(address));
        let of_building: Vec<String> = of_building.map(Address::to_string).collect();
        if of_building.is_empty() {
            listed(&doors().map(Address::to_string).collect::<Vec<_>>())
        } else {
            listed(&of_building)
        }
    }

    /// Length of the shortest path of the footprint from a point to a door's approach point,
    /// metres; `None` if there is no path.
    pub fn shortest(&self, from: MapPoint, door: usize) -> Option<f64> {
        let from = self.nearest_reachable(from)?;
        self.free_space.distance(from, self.approach[door]?)
    }

    /// The free space nearest to a position of the robot; `None` if there is none within a metre.
    pub(crate) fn nearest_reachable(&self, robot: MapPoint) -> Option<MapPoint> {
        // The rectangular footprint fits where its circumscribed circle does not.
        const MAX_OFFSET_M: f64 = 1.0;
        self.free_space.nearest_reachable(robot, MAX_OFFSET_M)
    }
}

/// The error of an episode that has no single place to drive to.
fn no_point_goal(number: usize, episode: &PreparedEpisode) -> BenchError {
    let problem = match episode.targets.len() {
        1 => "its door cannot be reached",
        _ => "it has several deliveries",
    };
    BenchError::world(format!(
        "episode {number} has no point as its goal: {problem}"
    ))
}

/// Whether an address has one place on the map, so that an instruction can name it.
fn is_unique(map: &OsmMap, address: &Address) -> bool {
    matches!(
        locate(map, address),
        Location::Building(_) | Location::Unit { .. }
    )
}

/// The first of many words, and how many follow.
fn listed(words: &[String]) -> String {
    const SHOWN: usize = 8;
    let shown = words[..words.len().min(SHOWN)].join("; ");
    match words.len().saturating_sub(SHOWN) {
        0 => shown,
        more => format!("{shown}; and {more} more"),
    }
}

/// The positions of a map's entrances, in the `map` frame.
fn entrances(map: &OsmData, georeference: Georeference) -> Vec<MapPoint> {
    let projection = Projection::new(georeference);
    let nodes = map.nodes.values().filter(|node| node.tags.says("entrance"));
    nodes.map(|node| projection.to_map(node.position)).collect()
}

/// The time limit of a delivery as far as the public map tells: enough for a path from any building
/// to any other one. Nothing about doors enters it. An agent that is not told where it starts could
/// infer that from a limit that depends on the start, so that for it only the extent of the map
/// counts.
fn public_time_limit(map: &OsmMap, start: Option<MapPoint>) -> Duration {
    let corners = || map.buildings.iter().flat_map(|b| &b.polygon.outer);
    let across = match start {
        Some(start) => 2.0 * corners().map(|c| c.distance(start)).fold(0.0, f64::max),
        None => {
            let bounds = corners().map(|corner| Bounds::of_point(*corner));
            let bounds = bounds.reduce(|a, b| a.union(b));
            bounds.map_or(0.0, |bounds| bounds.low.distance(bounds.high))
        }
    };
    let longest = PUBLIC_DETOUR * across;
    Duration::from_secs((BASE_TIME_LIMIT_S + TIME_LIMIT_S_PER_M * longest).ceil() as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::suite::Sensors;
    use crate::worlds::builtin_suite;
    use openbench_core::Velocity;
    use openbench_osm::add_entrance;

    #[test]
    fn agents_are_told_a_limit_that_depends_on_no_door() {
        let suite = builtin_suite("small").unwrap();
        let prepared = Prepared::new(suite, None).unwrap();
        let told = prepared.public_time_limit;
        for (number, episode) in prepared.episodes.iter().enumerate() {
            let briefing = crate::run::Rollout::new(&prepared, number, 1).unwrap();
            assert_eq!(briefing.briefing().time_limit, told);
            assert!(episode.time_limit <= told * episode.targets.len() as u32);
        }
    }

    #[test]
    fn the_suite_in_the_document_on_formats_can_be_run() {
        let document = include_str!("../../../../docs/formats.md");
        let block = document.split("```toml\n").nth(1).unwrap();
        let block = block.split("```").next().unwrap();
        let prepared = Prepared::new(toml::from_str(block).unwrap(), None).unwrap();
        assert_eq!(prepared.episodes[0].targets.len(), 2);
    }

    #[test]
    fn a_door_that_the_world_lacks_is_an_error_unless_a_planner_read_it() {
        let with = |targets: TargetSource| {
            let mut suite = builtin_suite("small").unwrap();
            suite.episodes[0].deliveries[0] = Address::new("building1", "unit99");
            Prepared::new(Suite { targets, ..suite }, None)
        };
        let error = with(TargetSource::Annotation).err().unwrap().to_string();
        assert!(
            error.contains("unit99") && error.contains("unit1, building1"),
            "{error}"
        );
        let warnings = with(TargetSource::Planner).unwrap().warnings();
        assert!(warnings[0].contains("unit99"), "{warnings:?}");
    }

    #[test]
    fn a_limit_does_not_tell_a_start_that_the_briefing_keeps() {
        let limit = |level: &str, start: MapPoint| {
            let mut suite = builtin_suite("small").unwrap();
            suite.conditions.set("start", level).unwrap();
            let mut prepared = Prepared::world_of(suite).unwrap();
            prepared.world.start.x = start.x;
            prepared.draw_map().unwrap();
            prepared.public_time_limit
        };
        let (here, there) = (MapPoint::new(0.0, 0.0), MapPoint::new(30.0, 0.0));
        assert_ne!(limit("exact", here), limit("exact", there));
        assert_eq!(limit("block", here), limit("block", there));
    }

    #[test]
    fn doors_in_the_map_do_not_change_the_limit_that_agents_are_told() {
        let prepared = Prepared::world_of(builtin_suite("small").unwrap()).unwrap();
        let (public, start) = (prepared.public_map(), prepared.world.start.point());
        let mut data = prepared.world.map.clone();
        for building in &public.buildings {
            let at = building.polygon.outer[0];
            let unit = Address::new("", "7");
            add_entrance(&mut data, &public.projection, building.element, at, &unit).unwrap();
        }
        let map = OsmMap::new(&data, prepared.world.georeference);
        assert_eq!(map.entrances.len(), public.buildings.len());
        assert_eq!(
            public_time_limit(&map, Some(start)),
            prepared.public_time_limit
        );
    }

    #[test]
    fn the_numbers_in_the_public_map_have_no_gaps_that_count_doors() {
        for name in ["small", "medium", "large"] {
            let prepared = Prepared::world_of(builtin_suite(name).unwrap()).unwrap();
            let map = &prepared.world.map;
            let is_counted = |ids: Vec<i64>| ids.iter().copied().eq(1..=ids.len() as i64);
            assert!(is_counted(map.nodes.keys().copied().collect()), "{name}");
            assert!(is_counted(map.ways.keys().copied().collect()), "{name}");
            assert!(
                is_counted(map.relations.keys().copied().collect()),
                "{name}"
            );
        }
    }

    #[test]
    fn there_are_gnss_fixes_if_the_suite_requests_a_receiver() {
        let has_fixes = |gnss: bool| {
            let suite = Suite {
                sensors: Sensors { gnss },
                ..builtin_suite("small").unwrap()
            };
            let mut simulator = Prepared::world_of(suite).unwrap().simulator(1).unwrap();
            (0..40).any(|_| {
                simulator.step(Velocity::ZERO);
                simulator.observation().gnss.is_some()
            })
        };
        assert!(has_fixes(true) && !has_fixes(false));
    }
}
