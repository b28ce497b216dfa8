//! CPU times of the local planner's parts among random discs, and of paths over a large costmap.
//!
//!     cargo run --release -p openbench-motion --example speed
#![expect(clippy::print_stdout, reason = "an example prints what it measured")]

use std::time::Duration;

use cpu_time::ThreadTime;
use openbench_core::{Georeference, LonLat, MapPoint, Pose2, RobotDescription, SimTime, Velocity};
use openbench_motion::Limits;
use openbench_motion::Motion;
use openbench_motion::teb::Problem;
use openbench_motion::teb::Settings;
use openbench_motion::teb::{Effort, Optimizer};
use openbench_motion::teb::{Explorer, Exploring};
use openbench_motion::trajectory::Trajectory;
use openbench_motion::{
    Costmap, Footprint, LocalPlanner, Obstacle, RangeRing, ScanPoint, Search, Situation, Teb,
    TebSettings, plan,
};
use openbench_osm::{OsmData, OsmMap};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Length of the path that is planned, metres.
const HORIZON: f64 = 4.0;
/// Draws of discs.
const DRAWS: u64 = 300;

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    println!(
        "{HORIZON} m ahead, CPU ms p50 / p99        classes     new band    warm band   five warm"
    );
    for discs in [20, 60] {
        bands(discs)?;
    }
    println!("\na second's drive, CPU ms p50 / p99      first cycle  later cycles");
    for discs in [20, 60] {
        cycles(discs)?;
    }
    println!();
    costmaps()
}

fn bands(discs: usize) -> Result<(), Failure> {
    let robot = RobotDescription::sentry();
    let (footprint, limits, settings) = (
        Footprint::of(&robot)?,
        Limits::of(&robot)?,
        Settings::default(),
    );
    let (mut explorer, mut optimizer) = (Explorer::default(), Optimizer::default());
    let (start, goal) = (MapPoint::default(), MapPoint::new(HORIZON, 0.0));
    let [mut classes, mut new, mut warm, mut five] = [const { Vec::new() }; 4];
    for draw in 0..DRAWS {
        let obstacles = scattered(discs, draw, start, goal)?;
        let problem = Problem {
            footprint: &footprint,
            obstacles: &obstacles,
            limits: &limits,
            settings: &settings,
            start: Velocity::ZERO,
            stops: true,
            end_yaw: true,
            side: 0.0,
        };
        let how = Exploring {
            keep: footprint.inscribed(),
            ..Exploring::default()
        };
        let (ways, took) = timed(|| explorer.explore(start, goal, &obstacles, &how));
        classes.push(took);
        let drafts = ways.iter().filter_map(|w| {
            Trajectory::along(Pose2::default(), &w.corners[1..], Some(0.0), &limits, 1.0)
        });
        let mut cycle = 0.0;
        let mut count = 0;
        for mut band in drafts {
            new.push(timed(|| optimizer.improve(&mut band, &problem, &[], &Effort::COLD)).1);
            let took = timed(|| optimizer.improve(&mut band, &problem, &[], &Effort::WARM)).1;
            warm.push(took);
            (cycle, count) = (cycle + took, count + 1);
        }
        if count == how.most {
            five.push(cycle + took);
        }
    }
    println!(
        "{discs} discs of 5 cm, {DRAWS} draws       {} {} {} {} ({} draws had five)",
        spread(&mut classes),
        spread(&mut new),
        spread(&mut warm),
        spread(&mut five),
        five.len()
    );
    Ok(())
}

/// Whole cycles of the planner, for the first second from rest.
fn cycles(discs: usize) -> Result<(), Failure> {
    let robot = RobotDescription::sentry();
    let limits = Limits::of(&robot)?;
    let path = [MapPoint::default(), MapPoint::new(HORIZON, 0.0)];
    let (mut first, mut later) = (Vec::new(), Vec::new());
    for draw in 0..DRAWS {
        let obstacles = scattered(discs, draw, path[0], path[1])?;
        let mut teb = Teb::new(&robot, TebSettings::default())?;
        let mut motion = Motion {
            pose: Pose2::default(),
            velocity: Velocity::ZERO,
            command: Velocity::ZERO,
        };
        for cycle in 0..20 {
            let time = SimTime::ZERO + Duration::from_millis(50) * cycle;
            let (pose, velocity) = (motion.pose, motion.velocity);
            let situation = Situation {
                time,
                pose,
                velocity,
                path: &path,
                final_yaw: Some(0.0),
                obstacles: &obstacles,
            };
            let (decided, took) = timed(|| teb.plan(&situation));
            if cycle == 0 { &mut first } else { &mut later }.push(took);
            motion.command = decided
                .ok()
                .and_then(|decided| decided.velocity())
                .unwrap_or(Velocity::ZERO);
            motion.step(&limits, 0.05);
        }
    }
    println!(
        "{discs} discs of 5 cm, {DRAWS} draws       {} {}",
        spread(&mut first),
        spread(&mut later)
    );
    Ok(())
}

fn scattered(
    count: usize,
    seed: u64,
    start: MapPoint,
    goal: MapPoint,
) -> Result<Vec<Obstacle>, Failure> {
    let mut rng = Pcg64Mcg::seed_from_u64(seed);
    let places = (0..count).map(|_| {
        MapPoint::new(
            rng.random_range(0.5..HORIZON - 0.5),
            rng.random_range(-1.5..1.5),
        )
    });
    let places: Vec<MapPoint> = places
        .filter(|p| p.distance(start) > 0.5 && p.distance(goal) > 0.5)
        .collect();
    Ok(places
        .into_iter()
        .map(|place| Obstacle::disc(place, 0.05))
        .collect::<Result<_, _>>()?)
}

/// From corner to corner of 200 m by 200 m in cells of 10 cm: between posts, and between walls that
/// leave a gap at alternate ends, so that every cell has to be visited.
fn costmaps() -> Result<(), Failure> {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    let posts = (0..4000)
        .map(|_| MapPoint::new(rng.random_range(0.0..200.0), rng.random_range(0.0..200.0)));
    costmap("4000 posts", posts)?;
    let wall = |i: usize| {
        let from = if i.is_multiple_of(2) { 0.0 } else { 3.0 };
        (0..1970).map(move |k| MapPoint::new(from + 0.1 * k as f64, 10.0 * (i + 1) as f64))
    };
    costmap("19 walls", (0..19).flat_map(wall))
}

fn costmap(what: &str, posts: impl Iterator<Item = MapPoint>) -> Result<(), Failure> {
    let map = OsmMap::new(
        &OsmData::default(),
        Georeference::tangent_plane(LonLat::new(8.0, 50.0)),
    );
    let robot = RobotDescription::sentry();
    let corner = MapPoint::new(200.0, 200.0);
    let mut costmap = Costmap::new(&map, MapPoint::default(), corner, &robot)?;
    // Seen from so many places: an obstacle that was not seen for 600 scans would be forgotten.
    let mut seen = vec![Vec::new(); 20 * 20];
    for post in posts {
        let index = |at: f64| (at / 10.0) as usize;
        seen[20 * index(post.y) + index(post.x)].push(ScanPoint::new(post, 0.3));
    }
    for (i, posts) in seen.into_iter().enumerate() {
        let middle = MapPoint::new(10.0 * (i % 20) as f64 + 5.0, 10.0 * (i / 20) as f64 + 5.0);
        costmap.observe(&RangeRing::new(middle, 0.25, posts.into_iter()));
    }
    let ((), inflating) = timed(|| costmap.inflate());
    let mut search = Search::default();
    let goal = MapPoint::new(199.0, 199.0);
    let (mut times, mut length) = (Vec::new(), 0.0);
    for _ in 0..5 {
        let (way, took) = timed(|| plan(&mut search, &costmap, MapPoint::new(1.0, 1.0), goal));
        length = way?.windows(2).map(|w| w[0].distance(w[1])).sum();
        times.push(took);
    }
    let (columns, rows) = (costmap.grid().width, costmap.grid().height);
    println!(
        "costmap of {columns} x {rows}, {what}: inflated in {inflating:.0} ms, \
         corner to corner {length:.0} m in {:.0} ms (first {:.0})",
        times[1..].iter().copied().fold(0.0, f64::max),
        times[0]
    );
    Ok(())
}

fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let began = ThreadTime::now();
    let done = work();
    (done, began.elapsed().as_secs_f64() * 1e3)
}

fn spread(times: &mut [f64]) -> String {
    times.sort_by(f64::total_cmp);
    let at = |share: f64| {
        times
            .get((times.len() as f64 * share) as usize)
            .copied()
            .unwrap_or(f64::NAN)
    };
    format!("{:.2} / {:.2}", at(0.5), at(0.99))
}
