//! Slabs and towers of flats that stand free in greenery, and what is between them.

use openbench_core::{MapPoint, Pose2};
use openbench_geometry::{Segment, segments};
use openbench_osm::draws::{between, chance, pick, whole};
use rand_pcg::Pcg64Mcg;

use crate::ground::Ground;
use crate::kind::Kind;
use crate::outline::{Footprint, Shape};
use crate::plan::{Half, Home, HomeKind, Patch, Path, Side, Street};
use crate::purpose::{Purpose, Seed};

/// Places that are tried.
const TRIES: u64 = 160;
/// Depth of a parking place, metres.
const PARKING_DEPTH_M: f64 = 5.0;
/// Distance of a footpath from the house along which it runs, metres.
const BESIDE_M: [f64; 2] = [3.5, 5.5];

/// The slabs of an estate.
pub(crate) fn place(kind: Kind, seed: Seed, half: Half, ground: &mut Ground) -> Vec<Home> {
    let mut of_all = seed.stream(Purpose::Slab, 0);
    let turn = between(&mut of_all, -0.35, 0.35);
    let gap = match kind {
        Kind::Small => between(&mut of_all, 8.0, 11.0),
        Kind::Medium | Kind::Large => between(&mut of_all, 11.0, 16.0),
    };
    let most = match kind {
        Kind::Small => 4,
        Kind::Medium => 11,
        Kind::Large => 18,
    };
    let levels = whole(&mut of_all, 3, 8);
    let mut homes = Vec::new();
    for stream in 1..=TRIES {
        let mut draws = seed.stream(Purpose::Slab, stream);
        let home = slab(kind, half, turn, levels, stream, &mut draws);
        if homes.len() < most && ground.fits(&home.outer, gap, usize::MAX) {
            ground.add(&home.outer);
            homes.push(home);
        }
    }
    homes
}

fn slab(kind: Kind, half: Half, turn: f64, levels: u32, stream: u64, draws: &mut Pcg64Mcg) -> Home {
    let (x, y) = (
        between(draws, -half.x, half.x),
        between(draws, -half.y, half.y),
    );
    // Two directions, and either long side in front.
    let quarter = pick(draws, &[0.0, 0.0, 1.0, 2.0, 2.0, 3.0]);
    let pose = Pose2::new(x, y, turn + quarter * std::f64::consts::FRAC_PI_2);
    let is_tower = chance(draws, 0.2);
    let width = match kind {
        _ if is_tower => between(draws, 16.0, 21.0),
        Kind::Small => between(draws, 18.0, 30.0),
        Kind::Medium | Kind::Large => between(draws, 24.0, 52.0),
    };
    let depth = if is_tower {
        width
    } else {
        between(draws, 10.5, 13.0)
    };
    let shape = if !is_tower && chance(draws, 0.15) {
        Shape::Notched {
            from: between(draws, 0.3, 0.7),
            depth: between(draws, 1.5, 4.0),
            right: chance(draws, 0.5),
        }
    } else {
        Shape::Rectangle
    };
    let place = Footprint {
        width,
        depth,
        setback: 0.0,
        aside: 0.0,
    };
    // Galleries have a door for each flat on the ground floor, staircases one for each stack.
    let between_doors = if chance(draws, 0.12) {
        between(draws, 3.2, 4.5)
    } else {
        between(draws, 8.0, 14.0)
    };
    Home {
        kind: if is_tower {
            HomeKind::Tower
        } else {
            HomeKind::Slab
        },
        outer: place.outer(shape, pose),
        court: None,
        pose,
        street: 0,
        side: Side::Left,
        // Estates are numbered across.
        along: x + 0.15 * y,
        lot: None,
        levels: if is_tower { levels + 3 } else { levels },
        roof: Some("flat"),
        stream,
        number: String::new(),
        name: None,
        wanted_doors: (width / between_doors).round().clamp(1.0, 14.0) as usize,
        doors: Vec::new(),
    }
}

/// Car parks along the access roads.
pub(crate) fn parking(seed: Seed, streets: &[Street], ground: &mut Ground) -> Vec<Patch> {
    let mut found = Vec::new();
    for (index, street) in streets.iter().enumerate().skip(1) {
        let mut draws = seed.stream(Purpose::Streets, 1_000 + index as u64);
        let length = street.length();
        for left in [true, false] {
            let wanted = chance(&mut draws, 0.8);
            let long = between(&mut draws, 11.0, 24.0).min(0.4 * length);
            let at = street.pose_at(length - long / 2.0 - 1.5);
            let (turn, edge) = if left {
                (0.0, street.edge() + 0.5)
            } else {
                (std::f64::consts::PI, -street.edge() - 0.5)
            };
            let corner = at.transform(0.0, edge);
            let pose = Pose2::new(corner.x, corner.y, at.yaw + turn);
            let place = Footprint {
                width: long,
                depth: PARKING_DEPTH_M,
                setback: 0.0,
                aside: 0.0,
            };
            let outer = place.outer(Shape::Rectangle, pose);
            if wanted && ground.fits(&outer, 2.0, usize::MAX) {
                ground.add(&outer);
                found.push(Patch {
                    outer,
                    key: "amenity",
                    value: "parking",
                });
            }
        }
    }
    found
}

/// Footpaths along slabs, each joined to the nearest street.
pub(crate) fn footpaths(
    seed: Seed,
    homes: &[Home],
    streets: &mut [Street],
    ground: &Ground,
) -> Vec<Path> {
    let mut paths = Vec::new();
    for home in homes {
        let mut draws = seed.stream(Purpose::Garden, home.stream);
        let wanted = chance(&mut draws, 0.85);
        let in_front = chance(&mut draws, 0.5);
        let beside = between(&mut draws, BESIDE_M[0], BESIDE_M[1]);
        let beyond = between(&mut draws, 2.5, 5.0);
        let sides = [in_front, !in_front].map(|front| beside_home(home, front, beside, beyond));
        let tries = sides.into_iter().flat_map(|[a, b]| [[a, b], [b, a]]);
        let found = tries
            .filter_map(|along| join(along, streets, ground))
            .find(|joined| joined.is_clear(ground));
        if let Some(joined) = found.filter(|_| wanted) {
            streets[joined.street].joints.push(joined.joint);
            paths.push(Path {
                line: joined.line,
                driveway: false,
                width: 1.8,
            });
        }
    }
    paths
}

/// The ends of a line along the front or back of a home.
fn beside_home(home: &Home, front: bool, beside: f64, beyond: f64) -> [MapPoint; 2] {
    let local = home.outer.iter().map(|p| home.pose.inverse_transform(*p));
    let (mut low, mut high) = ([f64::MAX; 2], [f64::MIN; 2]);
    for (x, y) in local {
        low = [low[0].min(x), low[1].min(y)];
        high = [high[0].max(x), high[1].max(y)];
    }
    let y = if front {
        low[1] - beside
    } else {
        high[1] + beside
    };
    [
        home.pose.transform(low[0] - beyond, y),
        home.pose.transform(high[0] + beyond, y),
    ]
}

/// A path and where it joins a street.
struct Joined {
    line: Vec<MapPoint>,
    street: usize,
    joint: crate::plan::Joint,
}

impl Joined {
    fn is_clear(&self, ground: &Ground) -> bool {
        segments(&self.line).all(|s| ground.is_clear_of_buildings(s, 1.2))
    }
}

fn join([near, far]: [MapPoint; 2], streets: &[Street], ground: &Ground) -> Option<Joined> {
    let joints = streets.iter().map(|street| street.nearest(near));
    let (street, joint) = joints.enumerate().min_by(|(_, a), (_, b)| {
        let distance = |j: &crate::plan::Joint| j.point.distance(near);
        distance(a).total_cmp(&distance(b))
    })?;
    let crosses = !ground.is_off_streets(Segment::new(near, far), 0.3);
    (!crosses).then(|| Joined {
        line: vec![joint.point, near, far],
        street,
        joint,
    })
}
