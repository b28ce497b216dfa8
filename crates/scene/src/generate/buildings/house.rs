//! The look of a building: what the map says of it, and what the seed draws of the rest.

use openbench_core::MapPoint;
use openbench_geometry::signed_area;
use openbench_osm::{Building, Tags};
use rand_pcg::Pcg64Mcg;

use super::walls::straightened;
use crate::generate::materials::openings::SHUTTERED_WIDTHS;
use crate::generate::materials::palette::Palette;
use crate::generate::seeds::{between, chance, pick};
use crate::generate::shapes::Surface;
use crate::generate::streets::profile::metres;
use crate::material::MaterialId;

/// Distance of plinths and window frames in front of the wall, metres.
pub(super) const RELIEF_M: f64 = 0.03;
/// Height of a parapet, metres.
pub(super) const PARAPET_M: f64 = 0.5;
/// A building that covers more is flat on top unless the map says otherwise, m².
const LARGE_M2: f64 = 2_500.0;
/// A building that covers more has three storeys or more unless the map says otherwise, m².
const TALL_M2: f64 = 220.0;
/// Widest rectangle under a gabled or hipped roof, metres.
const WIDEST_SPAN_M: f64 = 20.0;
/// Cosine of the angle of a corner that is still square enough for a gabled roof: houses are drawn
/// from aerial images, whose corners are off by some degrees.
const LARGEST_COSINE: f64 = 0.2;
/// Buildings from so many levels on are built like those of towns.
const TOWN_LEVELS: usize = 4;

/// How a building is topped.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Roof {
    /// Flat with a parapet.
    Flat,
    /// Two slopes and two gables; slope as rise over run.
    Gabled(f64),
    /// Four slopes.
    Hipped(f64),
    /// Steep slopes around a flat middle, over any outline.
    Mansard,
    /// Slopes up to one point, so many metres high, over any outline without holes.
    Tent(f64),
    /// Flat without a parapet: parts of the building stand on it.
    Terrace,
}

/// What the shops of a building have in common.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Shops {
    pub windows: [MaterialId; 2],
    pub sign: Surface,
    pub awning: Option<Surface>,
}

/// Number of floors, and the height at which the walls end.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Storeys {
    pub levels: usize,
    /// Metres.
    pub eaves: f64,
}

/// How one building looks.
#[derive(Debug, Clone)]
pub(crate) struct House {
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
    /// Without and with curtains.
    pub windows: [MaterialId; 2],
    /// Width of a window without its shutters, metres.
    pub window_width: f64,
    /// Metres.
    pub window_height: f64,
    /// Distance between windows, metres.
    pub spacing: f64,
    pub door: MaterialId,
    pub canopy: bool,
    pub balconies: bool,
    /// Number of storeys that are marked by a band, from the ground up.
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

impl House {
    /// The outline.
    pub fn outer(&self) -> &[MapPoint] {
        &self.rings[0]
    }

    pub fn holes(&self) -> &[Vec<MapPoint>] {
        &self.rings[1..]
    }

    /// Height of a storey, metres.
    pub fn storey(&self) -> f64 {
        (self.eaves - self.foot) / self.levels as f64
    }
}

/// Designs a building. The order of the draws belongs to the world: it decides how each house of a
/// seed looks.
pub(super) fn design(
    building: &Building,
    palette: &Palette,
    detailed: bool,
    rng: &mut Pcg64Mcg,
) -> House {
    let tags = &building.tags;
    let rings: Vec<Vec<MapPoint>> = building.polygon.rings().map(straightened).collect();
    let area = signed_area(&rings[0]);
    let plain = is_outbuilding(tags);
    let Storeys { levels, eaves } = storeys(tags, area, plain, rng);
    let roof = roof_of(tags, &rings, levels, rng);
    // The windows of one house share an image; shutters make it wider.
    let shuttered = chance(rng, 0.3);
    let windows = pick(
        rng,
        if shuttered {
            &palette.shuttered
        } else {
            &palette.windows
        },
    );
    // Narrower between shutters, which take wall on both sides.
    let width = between(rng, 1.0, 1.5) * if shuttered { 0.85 } else { 1.0 };
    let is_cottage = detailed && levels < TOWN_LEVELS;
    // Shutters of neighbouring windows must not overlap.
    let least_spacing = if shuttered {
        width * SHUTTERED_WIDTHS + 0.5
    } else {
        0.0
    };
    House {
        // The fields are evaluated in the order in which they are written, which is that of the
        // draws.
        foot: 0.0,
        eaves,
        levels,
        roof,
        facade: pick(
            rng,
            if is_cottage {
                &palette.facades
            } else {
                &palette.town_facades
            },
        ),
        plinth: pick(rng, &palette.plinths),
        trim: pick(rng, &palette.trims),
        roofing: match roof {
            Roof::Flat => palette.flat_roof,
            _ => pick(rng, &palette.pitched_roofs),
        },
        windows,
        window_width: width,
        window_height: between(rng, 1.25, 1.65),
        spacing: between(rng, 2.3, 3.2).max(least_spacing),
        shuttered,
        shops: shops(tags, levels, palette, rng),
        door: pick(rng, &palette.doors),
        canopy: chance(rng, 0.6),
        balconies: levels >= 3 && chance(rng, 0.75),
        bands: pick(rng, &[0, 0, 0, 1, 1, usize::MAX]),
        quoins: chance(rng, 0.25),
        detailed,
        plain,
        rings,
    }
}

/// The shops of a building: where the map has them, and in some tall houses.
fn shops(tags: &Tags, levels: usize, palette: &Palette, rng: &mut Pcg64Mcg) -> Option<Shops> {
    // All draws come before the decision, so that a house without shops draws as many numbers.
    let (drawn, covered) = (chance(rng, 0.35), chance(rng, 0.5));
    let shops = Shops {
        windows: palette.shop_windows,
        sign: pick(rng, &palette.signs),
        awning: Some(pick(rng, &palette.awnings)).filter(|_| covered),
    };
    (has_shops(tags) || drawn && levels >= TOWN_LEVELS).then_some(shops)
}

/// Whether the map says that there are shops on the ground floor.
fn has_shops(tags: &Tags) -> bool {
    let kinds = ["retail", "commercial", "supermarket", "kiosk"];
    let amenities = ["restaurant", "cafe", "bar", "pharmacy", "bank"];
    tags.says("shop")
        || kinds.iter().any(|kind| tags.is("building", kind))
        || amenities.iter().any(|kind| tags.is("amenity", kind))
}

fn is_outbuilding(tags: &Tags) -> bool {
    const KINDS: [&str; 9] = [
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
        .is_some_and(|kind| KINDS.contains(&kind))
}

/// Whether a robot drives under it: a roof, or what begins above the ground.
pub(crate) fn is_open_below(tags: &Tags) -> bool {
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

/// Floors and height of a building that covers `area` m².
pub(super) fn storeys(tags: &Tags, area: f64, plain: bool, rng: &mut Pcg64Mcg) -> Storeys {
    // Drawn also where the map has a number: its tags must not shift later draws.
    let drawn = if plain {
        1
    } else if area > TALL_M2 {
        // An entry that is listed twice is drawn twice as often, here and in other lists.
        pick(rng, &[3, 3, 4, 5])
    } else {
        pick(rng, &[1, 2, 2, 2])
    };
    let tagged = tags
        .get("building:levels")
        .and_then(|l| l.parse::<f64>().ok())
        .filter(|l| (1.0..=120.0).contains(l))
        .map(|l| l as usize);
    let storey = between(rng, 2.75, 3.05);
    let roof = metres(tags, "roof:height").unwrap_or(0.0);
    match metres(tags, "height").filter(|h| (2.0..=600.0).contains(h)) {
        Some(height) => {
            let eaves = (height - roof).max(2.0);
            Storeys {
                levels: tagged.unwrap_or((eaves / 3.0) as usize).clamp(1, 200),
                eaves,
            }
        }
        None => {
            let levels = tagged.unwrap_or(drawn);
            Storeys {
                levels,
                eaves: levels as f64 * storey + if plain { 0.0 } else { 0.4 },
            }
        }
    }
}

/// The roof over an outline with holes.
pub(super) fn roof_of(
    tags: &Tags,
    rings: &[Vec<MapPoint>],
    levels: usize,
    rng: &mut Pcg64Mcg,
) -> Roof {
    let usual = between(rng, 0.5, 0.9);
    let slope = tagged_slope(tags, &rings[0]).unwrap_or(usual);
    let quad = rings.len() == 1 && is_rectangle(&rings[0]);
    match tags.get("roof:shape") {
        Some("flat") => return Roof::Flat,
        // Gables and hips need a rectangle. Over other outlines a mansard comes nearest, see below.
        Some("gabled" | "saltbox" | "gambrel") if quad => return Roof::Gabled(slope),
        Some("hipped" | "half-hipped") if quad => return Roof::Hipped(slope),
        Some("pyramidal" | "cone" | "dome" | "onion" | "round") if rings.len() == 1 => {
            // The slope over half the side of a square of the same area.
            let usual = slope * signed_area(&rings[0]).max(0.0).sqrt() / 2.0;
            let rise = metres(tags, "roof:height").unwrap_or(usual);
            return Roof::Tent(rise.clamp(0.3, 60.0));
        }
        Some("mansard" | "hipped" | "gabled") => return Roof::Mansard,
        _ => {}
    }
    if signed_area(&rings[0]) > LARGE_M2 {
        return Roof::Flat;
    }
    match (quad, levels) {
        (true, 0..=3) => {
            let gabled = Roof::Gabled(slope);
            pick(rng, &[gabled, gabled, Roof::Hipped(slope * 0.8)])
        }
        (false, 0..=4) => pick(rng, &[Roof::Mansard, Roof::Mansard, Roof::Flat]),
        _ => pick(rng, &[Roof::Flat, Roof::Flat, Roof::Mansard]),
    }
}

/// The slope that `roof:height` makes over a rectangle.
fn tagged_slope(tags: &Tags, ring: &[MapPoint]) -> Option<f64> {
    let height = metres(tags, "roof:height").filter(|_| ring.len() == 4)?;
    let half = shorter_side(ring) / 2.0;
    Some((height / half.max(0.5)).clamp(0.1, 2.5))
}

/// Four corners of about 90 degrees, and small enough for a roof over it.
fn is_rectangle(ring: &[MapPoint]) -> bool {
    let is_square = |i: usize| is_right_angle(ring[(i + 3) % 4], ring[i], ring[(i + 1) % 4]);
    ring.len() == 4 && (0..4).all(is_square) && shorter_side(ring) < WIDEST_SPAN_M
}

/// Whether the angle at `b` is a right one, to about 12 degrees.
fn is_right_angle(a: MapPoint, b: MapPoint, c: MapPoint) -> bool {
    let dot = (a.x - b.x) * (c.x - b.x) + (a.y - b.y) * (c.y - b.y);
    dot.abs() < LARGEST_COSINE * a.distance(b) * c.distance(b)
}

/// The shorter of the first two sides, metres.
fn shorter_side(ring: &[MapPoint]) -> f64 {
    ring[0].distance(ring[1]).min(ring[1].distance(ring[2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::seeds::{Purpose, stream};

    #[test]
    fn the_map_decides_on_height_and_levels() {
        let mut rng = stream(1, Purpose::Building, 1);
        let mut of = |tags: Tags| storeys(&tags, 100.0, false, &mut rng);
        let tall = of(Tags::from([("height", "12 m"), ("roof:height", "3")]));
        assert_eq!(
            tall,
            Storeys {
                levels: 3,
                eaves: 9.0
            }
        );
        let five = of(Tags::from([("building:levels", "5")]));
        assert!(five.levels == 5 && (14.0..16.0).contains(&five.eaves));
        assert!(of(Tags::from([("building:levels", "1e9")])).levels < 10);
    }
}
