//! Houses: what the map says of them, and what the seed makes of the rest.

use openbench_core::MapPoint;
use openbench_osm::{Area, Building, Tags};
use rand_pcg::Pcg64Mcg;

use super::Site;
use super::clearance::ROAD;
use super::element_number;
use super::entrances::{Doorway, straightened, walls};
use super::facades::facing_out;
use super::seeds::{Purpose, between, chance, pick, stream};
use super::shapes::{Surface, along, panel, signed_area, wall};
use super::streets::metres;
use super::windows::{SHUTTERED, Shops};
use crate::material::{MaterialId, SemanticClass};
use crate::scene::Layer;

/// A building that covers more is flat on top unless the map says otherwise, m².
const LARGE: f64 = 2_500.0;

/// How a building is topped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Roof {
    /// Flat with a parapet.
    Flat,
    /// Two slopes and two gables; slope as rise over run.
    Gabled(f64),
    /// Four slopes.
    Hipped(f64),
    /// Steep slopes round a flat middle, over any outline.
    Mansard,
    /// Slopes up to one point, so many metres high, over any outline without holes.
    Tent(f64),
    /// Flat without a parapet: parts of the building stand on it.
    Terrace,
}

/// How one building looks.
#[derive(Debug, Clone)]
pub(super) struct House {
    /// Outer ring and holes, each without corners that do not bend; the building on the left.
    pub rings: Vec<Vec<MapPoint>>,
    /// Height at which the walls begin, metres: 0 unless it stands on another part of its building.
    pub foot: f64,
    /// Height at which the walls end, metres.
    pub eaves: f64,
    /// Floors between the two.
    pub levels: usize,
    pub roof: Roof,
    pub facade: Surface,
    pub plinth: Surface,
    pub trim: Surface,
    pub roofing: Surface,
    pub windows: [MaterialId; 2],
    /// Width and height of a window, metres.
    pub window_size: (f64, f64),
    /// Distance between windows, metres.
    pub spacing: f64,
    pub door: MaterialId,
    pub canopy: bool,
    pub balconies: bool,
    /// How many storeys are marked by a band, from the ground up.
    pub bands: usize,
    /// Whether corner stones are set off.
    pub quoins: bool,
    /// Whether the images of the windows have shutters at both sides.
    pub shuttered: bool,
    /// What is on the ground floor, if it is shops.
    pub shops: Option<Shops>,
    pub detailed: bool,
    /// Without windows: a garage or shed.
    pub plain: bool,
}

impl Site {
    pub(super) fn buildings(&mut self) {
        let mut parts = self.parts_of_buildings();
        let buildings = std::mem::take(&mut self.map.buildings);
        let mut next = 0;
        for (index, building) in buildings.iter().enumerate() {
            self.builder.object(
                building.name.clone().unwrap_or("building".into()),
                SemanticClass::Building,
            );
            let first = next;
            while self.doorways.get(next).is_some_and(|d| d.building == index) {
                next += 1;
            }
            let doors = self.doorways[first..next].to_vec();
            if self.builder.triangles() >= self.limits.bare {
                self.left_out += 1;
                continue;
            }
            self.building(building, parts.remove(&index).unwrap_or_default(), &doors);
        }
        self.map.buildings = buildings;
    }

    fn building(&mut self, building: &Building, parts: Vec<Area>, doors: &[Doorway]) {
        let mut rng = stream(
            self.seed,
            Purpose::Building,
            element_number(building.element),
        );
        let mut house = self.design(building, &mut rng);
        if is_open_below(&building.tags) {
            self.raised_walls(&house, building);
            self.shelter(&house);
            return;
        }
        let parts = self.parts(&mut house, building, &parts);
        for wall in walls(building) {
            self.facade(&house, wall, doors, &mut rng);
        }
        if house.plain {
            self.garage_door(building, &mut rng);
        }
        self.roof(&house, &mut rng);
        for part in parts {
            self.part(part, building, &mut rng);
        }
        for door in doors {
            self.doorway(&house, door, &mut rng);
        }
    }

    /// The walls of what stands on stilts, from its `min_height` up: seen only, a robot drives below.
    fn raised_walls(&mut self, house: &House, building: &Building) {
        let tags = &building.tags;
        let Some(floor) = foot_of(tags).filter(|floor| (0.5..house.eaves).contains(floor)) else {
            return;
        };
        for line in walls(building) {
            wall(
                &mut self.builder,
                Layer::Visible,
                house.facade,
                line,
                (floor, house.eaves),
            );
        }
    }

    /// The shops of a building: where the map has them, and in some tall houses.
    fn shops(&self, tags: &Tags, levels: usize, rng: &mut Pcg64Mcg) -> Option<Shops> {
        let (drawn, covered) = (chance(rng, 0.35), chance(rng, 0.5));
        let palette = &self.palette;
        let shops = Shops {
            windows: palette.shop_windows,
            sign: pick(rng, &palette.signs),
            awning: Some(pick(rng, &palette.awnings)).filter(|_| covered),
        };
        (has_shops(tags) || drawn && levels >= 4).then_some(shops)
    }

    /// In the middle of the wall nearest to a road.
    fn garage_door(&mut self, building: &Building, rng: &mut Pcg64Mcg) {
        let to_road = |(a, b): &(MapPoint, MapPoint)| {
            let out = a.bearing_to(*b) - std::f64::consts::FRAC_PI_2;
            self.clearance
                .distance(along(*a, *b, 0.5).offset(out, 1.0), ROAD, 60.0)
        };
        let wide = walls(building)
            .into_iter()
            .filter(|(a, b)| a.distance(*b) > 3.0);
        let Some((a, b)) = wide.min_by(|s, t| to_road(s).total_cmp(&to_road(t))) else {
            return;
        };
        let pose = facing_out(a, b, 0.5);
        let line = (pose.transform(0.04, -1.25), pose.transform(0.04, 1.25));
        let leaf = pick(rng, &self.palette.garages);
        panel(&mut self.builder, Layer::Visible, leaf, line, (0.0, 2.1));
    }

    fn design(&self, building: &Building, rng: &mut Pcg64Mcg) -> House {
        let palette = &self.palette;
        let tags = &building.tags;
        let rings: Vec<Vec<MapPoint>> = building.polygon.rings().map(straightened).collect();
        let area = signed_area(&rings[0]);
        let plain = is_outbuilding(tags);
        let (levels, eaves) = storeys(tags, area, plain, rng);
        let roof = roof_of(tags, &rings, levels, rng);
        let shuttered = chance(rng, 0.3);
        let windows = pick(
            rng,
            if shuttered {
                &palette.shuttered
            } else {
                &palette.windows
            },
        );
        let width = between(rng, 1.0, 1.5) * if shuttered { 0.85 } else { 1.0 };
        House {
            foot: 0.0,
            eaves,
            levels,
            roof,
            facade: pick(
                rng,
                if self.detailed && levels < 4 {
                    &palette.facades
                } else {
                    &palette.town_facades
                },
            ),
            plinth: pick(rng, &palette.plinths),
            trim: pick(rng, &palette.trims),
            roofing: if roof == Roof::Flat {
                palette.flat_roof
            } else {
                pick(rng, &palette.pitched_roofs)
            },
            windows,
            window_size: (width, between(rng, 1.25, 1.65)),
            spacing: between(rng, 2.3, 3.2).max(if shuttered {
                width * SHUTTERED + 0.5
            } else {
                0.0
            }),
            shuttered,
            shops: self.shops(tags, levels, rng),
            door: pick(rng, &palette.doors),
            canopy: chance(rng, 0.6),
            balconies: levels >= 3 && chance(rng, 0.75),
            bands: pick(rng, &[0, 0, 0, 1, 1, usize::MAX]),
            quoins: chance(rng, 0.25),
            detailed: self.detailed,
            plain,
            rings,
        }
    }
}

/// What says that there are shops on the ground floor.
fn has_shops(tags: &Tags) -> bool {
    let kinds = ["retail", "commercial", "supermarket", "kiosk"];
    tags.says("shop")
        || kinds.iter().any(|kind| tags.is("building", kind))
        || ["restaurant", "cafe", "bar", "pharmacy", "bank"]
            .iter()
            .any(|kind| tags.is("amenity", kind))
}

fn is_outbuilding(tags: &Tags) -> bool {
    let kinds = [
        "garage",
        "garages",
        "shed",
        "hut",
        "carport",
        "greenhouse",
        "industrial",
        "warehouse",
        "service",
    ];
    tags.get("building")
        .is_some_and(|kind| kinds.contains(&kind))
}

/// Whether a robot drives under it: a roof, or what begins above the ground.
pub(super) fn is_open_below(tags: &Tags) -> bool {
    let raised = metres(tags, "min_height").is_some()
        || tags.get("building:min_level").is_some_and(|l| l != "0");
    raised
        || ["roof", "carport"]
            .iter()
            .any(|kind| tags.is("building", kind))
}

/// Height at which the map says that a building or a part of one begins, metres.
pub(super) fn foot_of(tags: &Tags) -> Option<f64> {
    let levels = tags
        .get("building:min_level")
        .and_then(|l| l.parse::<f64>().ok());
    metres(tags, "min_height")
        .or(levels.map(|l| 3.0 * l))
        .filter(|foot| (0.0..600.0).contains(foot))
}

/// Floors, and height of the walls in metres.
pub(super) fn storeys(tags: &Tags, area: f64, plain: bool, rng: &mut Pcg64Mcg) -> (usize, f64) {
    let guess = if plain {
        1
    } else if area > 220.0 {
        pick(rng, &[3, 3, 4, 5])
    } else {
        pick(rng, &[1, 2, 2, 2])
    };
    let told = tags
        .get("building:levels")
        .and_then(|l| l.parse::<f64>().ok())
        .filter(|l| (1.0..=120.0).contains(l));
    let levels = told.map_or(guess, |l| l as usize);
    let storey = between(rng, 2.75, 3.05);
    let roof = metres(tags, "roof:height").unwrap_or(0.0);
    match metres(tags, "height").filter(|h| (2.0..=600.0).contains(h)) {
        Some(height) => {
            let eaves = (height - roof).max(2.0);
            (
                told.map_or((eaves / 3.0) as usize, |l| l as usize)
                    .clamp(1, 200),
                eaves,
            )
        }
        None => (
            levels,
            levels as f64 * storey + if plain { 0.0 } else { 0.4 },
        ),
    }
}

pub(super) fn roof_of(
    tags: &Tags,
    rings: &[Vec<MapPoint>],
    levels: usize,
    rng: &mut Pcg64Mcg,
) -> Roof {
    let usual = between(rng, 0.5, 0.9);
    let slope = told_slope(tags, &rings[0]).unwrap_or(usual);
    let quad = rings.len() == 1 && is_rectangle(&rings[0]);
    match tags.get("roof:shape") {
        Some("flat") => return Roof::Flat,
        Some("gabled" | "saltbox" | "gambrel") if quad => return Roof::Gabled(slope),
        Some("hipped" | "half-hipped") if quad => return Roof::Hipped(slope),
        Some("pyramidal" | "cone" | "dome" | "onion" | "round") if rings.len() == 1 => {
            let usual = slope * signed_area(&rings[0]).max(0.0).sqrt() / 2.0;
            return Roof::Tent(
                metres(tags, "roof:height")
                    .unwrap_or(usual)
                    .clamp(0.3, 60.0),
            );
        }
        Some("mansard" | "hipped" | "gabled") => return Roof::Mansard,
        _ => {}
    }
    if signed_area(&rings[0]) > LARGE {
        return Roof::Flat;
    }
    match (quad, levels) {
        (true, 0..=3) => pick(
            rng,
            &[
                Roof::Gabled(slope),
                Roof::Gabled(slope),
                Roof::Hipped(slope * 0.8),
            ],
        ),
        (false, 0..=4) => pick(rng, &[Roof::Mansard, Roof::Mansard, Roof::Flat]),
        _ => pick(rng, &[Roof::Flat, Roof::Flat, Roof::Mansard]),
    }
}

/// The slope that `roof:height` makes over a rectangle.
fn told_slope(tags: &Tags, ring: &[MapPoint]) -> Option<f64> {
    let height = metres(tags, "roof:height").filter(|_| ring.len() == 4)?;
    let half = ring[0].distance(ring[1]).min(ring[1].distance(ring[2])) / 2.0;
    Some((height / half.max(0.5)).clamp(0.1, 2.5))
}

/// Four corners of about 90 degrees, and small enough for a roof over it.
fn is_rectangle(ring: &[MapPoint]) -> bool {
    let square = |i: usize| {
        let (a, b, c) = (ring[(i + 3) % 4], ring[i], ring[(i + 1) % 4]);
        let dot = (a.x - b.x) * (c.x - b.x) + (a.y - b.y) * (c.y - b.y);
        dot.abs() < 0.2 * a.distance(b) * c.distance(b)
    };
    ring.len() == 4
        && (0..4).all(square)
        && ring[0].distance(ring[1]).min(ring[1].distance(ring[2])) < 20.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_decides_on_height_and_levels() {
        let mut rng = stream(1, Purpose::Building, 1);
        let (levels, eaves) = storeys(
            &Tags::from([("height", "12 m"), ("roof:height", "3")]),
            100.0,
            false,
            &mut rng,
        );
        assert_eq!((levels, eaves), (3, 9.0));
        let (levels, eaves) = storeys(
            &Tags::from([("building:levels", "5")]),
            100.0,
            false,
            &mut rng,
        );
        assert!(levels == 5 && (14.0..16.0).contains(&eaves));
        let (levels, _) = storeys(
            &Tags::from([("building:levels", "1e9")]),
            100.0,
            false,
            &mut rng,
        );
        assert!(levels < 10);
    }
}
