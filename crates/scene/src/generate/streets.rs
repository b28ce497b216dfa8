//! Carriageways, pavements, paths and other ground covers. All lie within 2 cm above the ground, one on the other: what
//! is drawn higher hides what is drawn lower, so that roads cut through pavements and junctions need no geometry.

use openbench_core::MapPoint;
use openbench_osm::{Area, Tags};

use super::Site;
use super::shapes::{Surface, band, floor, parallel};
use super::water::is_water;
use crate::material::SemanticClass;

const Z_APRON: f64 = 0.0015;
const Z_AREA: f64 = 0.002;
const Z_PAVEMENT: f64 = 0.004;
const Z_PATH: f64 = 0.006;
const Z_SIDEWALK: f64 = 0.007;
const Z_KERB: f64 = 0.008;
const Z_SERVICE: f64 = 0.010;
const Z_ROAD: f64 = 0.012;
/// Width of the kerb stones beside a carriageway, metres.
pub(super) const KERB: f64 = 0.14;
/// Width of a pavement that the map does not draw as a way of its own, metres.
const PAVEMENT: f64 = 1.8;

/// Width of the paved ground around a building in a town, metres.
const APRON: f64 = 4.0;
/// A building is in a town if so much of the ground within so many metres is built over; of one building only so much counts, m².
const BUILT_SHARE: f64 = 0.4;
const NEIGHBOURHOOD: f64 = 30.0;
const MOST_BUILT: f64 = 1_500.0;
/// Fewer buildings than this make no town.
const CROWD: usize = 9;

/// How a `highway=*` way is built.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Profile {
    /// Width of the carriageway or path, metres.
    pub width: f64,
    /// Width of the pavements that belong to it, metres; 0 without any.
    pub pavement: f64,
    /// Whether there is a pavement on the left and on the right.
    pub sides: [bool; 2],
    /// Whether cars drive on it.
    pub for_cars: bool,
    /// Whether it is a through road with markings.
    pub marked: bool,
}

/// The profile of a way; `None` if nothing of it is on the ground.
pub(super) fn profile(tags: &Tags) -> Option<Profile> {
    let underground = tags.says("tunnel") || tags.get("layer").is_some_and(|l| l.starts_with('-'));
    if underground || tags.is("area", "yes") || tags.says("indoor") {
        return None;
    }
    // Usual width; whether for cars; whether it has pavements and markings.
    let (width, for_cars, street) = match tags.get("highway")? {
        "motorway" | "trunk" => (10.0, true, false),
        "primary" => (8.5, true, true),
        "secondary" => (7.5, true, true),
        "tertiary" => (6.5, true, true),
        "residential" | "unclassified" | "road" => (5.5, true, true),
        "living_street" => (5.0, true, false),
        "motorway_link" | "trunk_link" | "primary_link" | "secondary_link" | "tertiary_link" => {
            (4.5, true, false)
        }
        "service" => (
            if tags.is("service", "parking_aisle") {
                5.0
            } else {
                3.2
            },
            true,
            false,
        ),
        "track" | "busway" => (3.0, true, false),
        "pedestrian" => (4.0, false, false),
        "cycleway" | "bridleway" => (2.2, false, false),
        "footway" if tags.is("footway", "sidewalk") => (2.0, false, false),
        "footway" | "path" | "steps" | "corridor" => (1.5, false, false),
        _ => return None,
    };
    let lanes = tags
        .get("lanes")
        .and_then(|l| l.parse::<f64>().ok())
        .filter(|l| (1.0..=8.0).contains(l));
    let width = metres(tags, "width")
        .filter(|w| (0.5..=40.0).contains(w))
        .or(lanes.map(|l| 3.0 * l))
        .unwrap_or(width);
    let sides = if street {
        pavement_sides(tags)
    } else {
        [false; 2]
    };
    let pavement = if sides[0] || sides[1] { PAVEMENT } else { 0.0 };
    Some(Profile {
        width,
        pavement,
        sides,
        for_cars,
        marked: street && width >= 5.0,
    })
}

fn pavement_sides(tags: &Tags) -> [bool; 2] {
    let side = |name: &str| {
        tags.get(&format!("sidewalk:{name}"))
            .or(tags.get("sidewalk:both"))
            .map(|v| v == "yes")
    };
    match tags.get("sidewalk") {
        Some("separate" | "no" | "none") => [false; 2],
        Some("left") => [true, false],
        Some("right") => [false, true],
        _ => [side("left").unwrap_or(true), side("right").unwrap_or(true)],
    }
}

/// A length tag in metres, above zero.
pub(super) fn metres(tags: &Tags, key: &str) -> Option<f64> {
    tags.metres(key).filter(|v| *v > 0.0)
}

impl Site {
    /// Ground covers from the lowest to the highest.
    pub(super) fn streets(&mut self) {
        self.aprons();
        let areas = std::mem::take(&mut self.map.areas);
        for area in &areas {
            self.ground_cover(area);
        }
        self.map.areas = areas;
        let roads = std::mem::take(&mut self.map.roads);
        for road in &roads {
            let Some(profile) = profile(&road.tags).filter(|_| self.is_near(&road.points)) else {
                continue;
            };
            if self.builder.triangles() >= self.limits.bare {
                self.left_out += 1;
                continue;
            }
            let name = road
                .tags
                .get("name")
                .or(road.tags.get("highway"))
                .unwrap_or("road")
                .to_owned();
            if profile.for_cars {
                self.builder.object(name, SemanticClass::Road);
                self.carriageway(&road.points, &road.tags, profile);
            } else {
                self.builder.object(name, SemanticClass::Pavement);
                let surface = self.path_surface(&road.tags);
                let z = if surface == self.palette.paving {
                    Z_SIDEWALK
                } else {
                    Z_PATH
                };
                band(
                    &mut self.builder,
                    surface,
                    &road.points,
                    profile.width / 2.0,
                    z,
                );
            }
        }
        self.map.roads = roads;
        self.wear();
        self.markings();
    }

    /// Paved ground around the buildings of towns: no lawns between houses that stand wall to wall.
    fn aprons(&mut self) {
        self.builder.object("paving", SemanticClass::Pavement);
        let enough = BUILT_SHARE * std::f64::consts::PI * NEIGHBOURHOOD * NEIGHBOURHOOD;
        for index in 0..self.map.buildings.len() {
            let middle = self.map.buildings[index].polygon.centroid();
            let near = self.map.buildings_within(middle, NEIGHBOURHOOD);
            // A few hundred tell enough, should thousands be piled up in one place.
            let built: f64 = near
                .iter()
                .take(300)
                .map(|i| self.map.buildings[*i].polygon.area().min(MOST_BUILT))
                .sum();
            if near.len() < CROWD || built < enough || self.is_full() {
                continue;
            }
            let outer = &self.map.buildings[index].polygon.outer;
            let line: Vec<MapPoint> = outer.iter().chain(outer.first()).copied().collect();
            band(&mut self.builder, self.palette.path, &line, APRON, Z_APRON);
        }
    }

    fn is_near(&self, line: &[MapPoint]) -> bool {
        line.iter()
            .any(|p| self.extent.holds(*p, super::GROUND_MARGIN))
    }

    fn carriageway(&mut self, line: &[MapPoint], tags: &Tags, profile: Profile) {
        let half = profile.width / 2.0;
        let paving = self.palette.paving;
        let offset = half + profile.pavement / 2.0;
        for (sign, _) in [(1.0, 0), (-1.0, 1)]
            .into_iter()
            .filter(|(_, side)| profile.sides[*side])
        {
            let side = parallel(line, sign * offset);
            band(
                &mut self.builder,
                paving,
                &side,
                profile.pavement / 2.0 + 0.01,
                Z_PAVEMENT,
            );
        }
        let kerb = self.palette.kerb;
        let (surface, z) = match tags.get("highway") {
            Some("service") => (self.palette.worn_asphalt, Z_SERVICE),
            Some("track") => (self.palette.gravel, Z_SERVICE),
            _ => (self.palette.asphalt, Z_ROAD),
        };
        let surface = match tags.get("surface") {
            Some("gravel" | "fine_gravel" | "compacted" | "unpaved" | "dirt") => {
                self.palette.gravel
            }
            Some("sett" | "paving_stones" | "cobblestone") => self.palette.path,
            _ => surface,
        };
        if z == Z_ROAD {
            band(&mut self.builder, kerb, line, half + KERB, Z_KERB);
        }
        band(&mut self.builder, surface, line, half, z);
    }

    fn path_surface(&self, tags: &Tags) -> Surface {
        match tags.get("surface") {
            Some("asphalt") => self.palette.worn_asphalt,
            Some("gravel" | "fine_gravel" | "compacted" | "unpaved") => self.palette.gravel,
            Some("ground" | "dirt" | "earth") => self.palette.earth,
            Some("sett" | "cobblestone") => self.palette.path,
            _ if ["sidewalk", "crossing"]
                .iter()
                .any(|v| tags.is("footway", v)) =>
            {
                self.palette.paving
            }
            Some("paving_stones" | "concrete") => self.palette.paving,
            _ => self.palette.path,
        }
    }

    fn ground_cover(&mut self, area: &Area) {
        let tags = &area.tags;
        let palette = &self.palette;
        let surface = match () {
            () if tags.is("amenity", "parking") => palette.worn_asphalt,
            () if is_water(tags) => palette.water,
            () if tags.is("leisure", "playground") || tags.is("natural", "sand") => palette.gravel,
            () if tags.is("natural", "beach") => palette.gravel,
            () if tags.is("landuse", "flowerbed") || tags.is("natural", "bare_ground") => {
                palette.earth
            }
            () if tags.is("highway", "pedestrian")
                || tags.is("highway", "footway")
                || tags.is("place", "square")
                || ["pier", "breakwater", "groyne"]
                    .iter()
                    .any(|kind| tags.is("man_made", kind))
                || tags.is("landuse", "railway") =>
            {
                palette.paving
            }
            () => return,
        };
        if self.extent.meets(&area.polygon, super::GROUND_MARGIN) {
            let name = tags.get("name").unwrap_or("area").to_owned();
            self.builder.object(name, SemanticClass::Ground);
            floor(
                &mut self.builder,
                surface,
                (&area.polygon.outer, &area.polygon.holes),
                Z_AREA,
            );
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_overrule_the_usual_profile() {
        let usual = profile(&Tags::from([("highway", "residential")])).unwrap();
        assert!(usual.for_cars && usual.sides == [true, true] && usual.pavement > 1.0);
        let told = profile(&Tags::from([
            ("highway", "residential"),
            ("width", "7,5 m"),
            ("sidewalk", "left"),
        ]))
        .unwrap();
        assert_eq!((told.width, told.sides), (7.5, [true, false]));
        let mapped = profile(&Tags::from([
            ("highway", "residential"),
            ("sidewalk", "separate"),
        ]))
        .unwrap();
        assert_eq!(mapped.pavement, 0.0);
        assert_eq!(
            profile(&Tags::from([("highway", "footway"), ("tunnel", "yes")])),
            None
        );
        assert_eq!(profile(&Tags::from([("highway", "proposed")])), None);
    }
}
