//! Gardens: garages with driveways, garden paths, and barriers with gates.

use openbench_core::MapPoint;
use openbench_geometry::{Segment, segments};
use openbench_osm::draws::{between, chance, pick};
use rand_pcg::Pcg64Mcg;

use crate::ground::Ground;
use crate::outline::{Footprint, Shape};
use crate::plan::{BarrierKind, Fence, Home, HomeKind, Lot, Outbuilding, Path, Street};
use crate::purpose::{Purpose, Seed};
use crate::reach::Reach;

/// Distance of barriers from the edge of the pavement, metres.
const FROM_EDGE_M: f64 = 0.45;
/// Distance of barriers from buildings, metres: there is room to pass between.
const FROM_BUILDINGS_M: f64 = 1.35;
/// Distance of barriers from the line in front of a door, metres.
const FROM_DOORS_M: f64 = 1.3;
/// Length of that line, metres.
const BEFORE_DOOR_M: f64 = 1.8;
/// Shortest barrier, metres.
const SHORTEST_M: f64 = 1.2;
/// Distance between barriers that do not meet, metres.
const APART_M: f64 = 0.15;
/// Homes this near to each other are neighbours, metres.
const NEIGHBOURS_M: f64 = 30.0;
/// What the fences of each garden are made of.
const KINDS: [BarrierKind; 5] = [
    BarrierKind::Hedge,
    BarrierKind::Hedge,
    BarrierKind::Fence,
    BarrierKind::Fence,
    BarrierKind::Wall,
];

/// What gardens have.
#[derive(Debug, Default)]
pub(crate) struct Gardens {
    pub outbuildings: Vec<Outbuilding>,
    pub paths: Vec<Path>,
    pub fences: Vec<Fence>,
}

/// Draws garages and driveways, before doors are drawn: a garage stands before some walls.
pub(crate) fn garages(
    seed: Seed,
    homes: &[Home],
    streets: &mut [Street],
    ground: &mut Ground,
) -> Gardens {
    let mut gardens = Gardens::default();
    for home in homes {
        let mut draws = seed.stream(Purpose::Garden, (1 << 50) | home.stream);
        let share = match home.kind {
            HomeKind::Detached => 0.45,
            HomeKind::Semi | HomeKind::Farm => 0.3,
            _ => 0.0,
        };
        if home.lot.is_some() && chance(&mut draws, share) {
            garage(home, &mut draws, streets, ground, &mut gardens);
        }
        let shed = home.lot.filter(|_| chance(&mut draws, 0.12));
        if let Some(lot) = shed {
            let size = between(&mut draws, 2.0, 3.2);
            let place = Footprint {
                width: size,
                depth: size * 0.9,
                setback: lot.depth - size - 1.0,
                aside: between(&mut draws, -0.4, 0.4) * lot.width,
            };
            let outer = place.outer(Shape::Rectangle, home.pose);
            put(outer, "shed", ground, &mut gardens);
        }
    }
    gardens
}

fn garage(
    home: &Home,
    draws: &mut Pcg64Mcg,
    streets: &mut [Street],
    ground: &mut Ground,
    gardens: &mut Gardens,
) {
    let side = if chance(draws, 0.5) { 1.0 } else { -1.0 };
    let (width, depth) = (between(draws, 3.0, 3.6), between(draws, 5.2, 6.4));
    // Beside the house, or behind it in a corner of the garden.
    let deep = chance(draws, 0.4);
    let house_depth = depth_of(home);
    let setback = if deep {
        house_depth + between(draws, 1.8, 3.0)
    } else {
        between(draws, 5.0, 7.5)
    };
    let aside = side * (width_of(home) / 2.0 + width / 2.0 + between(draws, 1.7, 2.0));
    let place = Footprint {
        width,
        depth,
        setback,
        aside,
    };
    let outer = place.outer(Shape::Rectangle, home.pose);
    let from = streets[home.street].nearest(home.pose.transform(aside, 0.0));
    let line = vec![
        from.point,
        home.pose.transform(aside, 0.0),
        home.pose.transform(aside, setback - 0.3),
    ];
    let clear = segments(&line).all(|s| ground.is_clear_of_buildings(s, 1.2));
    if clear && put(outer, "garage", ground, gardens) {
        streets[home.street].joints.push(from);
        gardens.paths.push(Path {
            line,
            driveway: true,
            width: 2.6,
        });
    }
}

/// How wide a home is along the street, metres.
fn width_of(home: &Home) -> f64 {
    let local = home.outer.iter().map(|p| home.pose.inverse_transform(*p).0);
    2.0 * local.map(f64::abs).fold(0.0, f64::max)
}

/// How far a home reaches away from the street, metres.
fn depth_of(home: &Home) -> f64 {
    let local = home.outer.iter().map(|p| home.pose.inverse_transform(*p).1);
    local.fold(0.0, f64::max)
}

fn put(
    outer: Vec<MapPoint>,
    kind: &'static str,
    ground: &mut Ground,
    gardens: &mut Gardens,
) -> bool {
    let fits = ground.fits(&outer, 1.6, usize::MAX);
    if fits {
        ground.add(&outer);
        gardens.outbuildings.push(Outbuilding { outer, kind });
    }
    fits
}

/// Draws garden paths and barriers around the homes, whose doors are known.
pub(crate) fn enclose(
    seed: Seed,
    homes: &[Home],
    streets: &mut [Street],
    ground: &Ground,
    gardens: &mut Gardens,
) {
    let fronts: Vec<Segment> = homes.iter().flat_map(fronts_of).collect();
    for (index, home) in homes.iter().enumerate() {
        let Some(lot) = home.lot else { continue };
        let mut draws = seed.stream(Purpose::Garden, (1 << 51) | home.stream);
        let garden = Garden {
            home,
            index,
            lot,
            ground,
            fronts: &fronts,
        };
        let gate = garden.path(&mut draws, streets, gardens);
        garden.fences(gate, &mut draws, gardens);
    }
}

/// The ground in front of the doors of a home.
fn fronts_of(home: &Home) -> impl Iterator<Item = Segment> + '_ {
    home.doors.iter().map(|door| {
        let out = door.wall.outward();
        Segment::new(door.at, door.at.offset(out, BEFORE_DOOR_M))
    })
}

/// The garden of one home.
struct Garden<'a> {
    home: &'a Home,
    index: usize,
    lot: Lot,
    ground: &'a Ground,
    fronts: &'a [Segment],
}

impl Garden<'_> {
    /// Draws the gate's place along the front of the garden, metres from its middle, and a path
    /// through it. The path ends somewhere in the garden: it says nothing about the door.
    fn path(&self, draws: &mut Pcg64Mcg, streets: &mut [Street], gardens: &mut Gardens) -> f64 {
        let reach = (self.lot.width / 2.0 - 1.6).max(0.0);
        let gate = between(draws, -reach, reach);
        let share = match self.home.kind {
            HomeKind::Terraced | HomeKind::Row => 0.45,
            _ => 0.75,
        };
        let wanted = chance(draws, share);
        let pose = self.home.pose;
        let front = self.home.outer.iter().map(|p| pose.inverse_transform(*p).1);
        let room = front.fold(f64::INFINITY, f64::min) - 1.0;
        let end_x = (gate + between(draws, -2.5, 2.5)).clamp(-reach, reach);
        let end_y = between(draws, 0.9, room.max(1.0));
        if wanted && room > 1.0 {
            let from = streets[self.home.street].nearest(pose.transform(gate, 0.0));
            streets[self.home.street].joints.push(from);
            gardens.paths.push(Path {
                line: vec![
                    from.point,
                    pose.transform(gate, FROM_EDGE_M),
                    pose.transform(end_x, end_y),
                ],
                driveway: false,
                width: 1.2,
            });
        }
        gate
    }

    fn fences(&self, gate: f64, draws: &mut Pcg64Mcg, gardens: &mut Gardens) {
        let kind = pick(draws, &KINDS);
        let Lot { width, depth } = self.lot;
        let half = width / 2.0;
        // All draws come first, so that no fence depends on whether another fits.
        let [front, left, right, back] = [0.7, 0.55, 0.25, 0.5].map(|share| chance(draws, share));
        let at = |x: f64, y: f64| self.home.pose.transform(x, y);
        if front {
            let gate = at(gate, FROM_EDGE_M);
            let line = vec![
                at(-half + 0.1, FROM_EDGE_M),
                gate,
                at(half - 0.1, FROM_EDGE_M),
            ];
            self.add(kind, line, Some(gate), gardens);
        }
        for (wanted, x) in [(left, -half), (right, half)] {
            if wanted {
                let line = vec![at(x, FROM_EDGE_M + 0.3), at(x, depth)];
                self.add(kind, line, None, gardens);
            }
        }
        if back {
            let line = vec![at(-half + 0.1, depth), at(half - 0.1, depth)];
            self.add(kind, line, None, gardens);
        }
    }

    /// Adds the parts of a barrier that keep their distance from all else.
    fn add(
        &self,
        kind: BarrierKind,
        line: Vec<MapPoint>,
        gate: Option<MapPoint>,
        gardens: &mut Gardens,
    ) {
        let whole = Fence {
            kind,
            line,
            gate,
            home: self.index,
        };
        let fits = whole
            .standing()
            .iter()
            .all(|part| self.is_free(*part, gardens));
        let long = openbench_geometry::line::length(&whole.line) > SHORTEST_M;
        if fits && long {
            gardens.fences.push(whole);
        }
    }

    fn is_free(&self, part: Segment, gardens: &Gardens) -> bool {
        let others = gardens.fences.iter().flat_map(Fence::standing);
        let mut driveways = gardens.paths.iter().filter(|path| path.driveway);
        let own = |path: &Path| segments(&path.line).any(|s| s.crosses(part));
        // A driveway opens whatever crosses it; nothing runs along it.
        let off_driveways = driveways.all(|path| {
            let mut stretches = segments(&path.line);
            own(path) || stretches.all(|s| s.distance_to(part) > path.width / 2.0 + 0.3)
        });
        self.ground.is_clear_of_buildings(part, FROM_BUILDINGS_M)
            && self.ground.is_off_streets(part, 0.05)
            && off_driveways
            && self
                .fronts
                .iter()
                .all(|f| f.distance_to(part) > FROM_DOORS_M)
            && others
                .into_iter()
                .all(|other| other.distance_to(part) > APART_M)
    }
}

/// Takes away barriers until every door is reached, and returns the ground that is reached then.
pub(crate) fn open_up(
    homes: &[Home],
    fences: &mut Vec<Fence>,
    reach: impl Fn(&[Fence]) -> Reach,
) -> Reach {
    // Each round takes away the fences of a home at least, so this ends.
    loop {
        let reached = reach(fences);
        let is_shut = |home: &Home| {
            let mut doors = home.doors.iter();
            doors.any(|door| !reached.holds(door.at.offset(door.wall.outward(), 1.2)))
        };
        let shut: Vec<usize> = (0..homes.len()).filter(|i| is_shut(&homes[*i])).collect();
        if shut.is_empty() || fences.is_empty() {
            return reached;
        }
        let before = fences.len();
        fences.retain(|fence| !shut.contains(&fence.home));
        if fences.len() == before {
            // Shut in by the fences of neighbours.
            fences.retain(|fence| {
                let own = homes[fence.home].pose.point();
                let is_far = |i: &usize| homes[*i].pose.point().distance(own) > NEIGHBOURS_M;
                shut.iter().all(is_far)
            });
        }
        if fences.len() == before {
            fences.clear();
        }
    }
}
