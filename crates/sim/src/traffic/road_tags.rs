//! What the tags of a way mean for people and cars: widths, speeds, directions, pavements.
//!
//! Tags as in the OSM wiki's *Key:highway*, *Key:maxspeed*, *Key:sidewalk* and *Key:driving side*.
//! Usual widths are those with which `openbench_scene::generate` builds streets. Conditional limits
//! are ignored.

use openbench_osm::Tags;

/// A carriageway.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Carriageway {
    /// Half its width, metres.
    pub half_width: f64,
    /// Speed limit, m/s.
    pub limit: f64,
    /// Whether cars drive in the direction of the way's nodes.
    pub forward: bool,
    /// Whether cars drive against the direction of the way's nodes.
    pub backward: bool,
    /// Whether traffic keeps to the left.
    pub left_hand: bool,
    /// People beside the carriageway.
    pub walkers: Walkers,
}

/// Distance of people from the middle of a carriageway, metres; `None` where nobody walks.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Walkers {
    pub left: Option<f64>,
    pub right: Option<f64>,
}

/// What is usual on a class of highway.
struct Usual {
    /// Width of the carriageway, metres.
    width: f64,
    /// Speed limit, km/h.
    limit: f64,
}

/// Width of a pavement that is not mapped as a way of its own, metres.
const PAVEMENT_M: f64 = 1.8;
/// Distance of people from the edge of a carriageway without a pavement, metres.
const VERGE_M: f64 = 0.5;
/// Width of a lane, metres.
const LANE_M: f64 = 3.0;
/// Speed limit of `maxspeed=walk`, km/h.
const WALKING_KMH: f64 = 7.0;
const KM_PER_MILE: f64 = 1.609_344;

/// The carriageway of a way; `None` if no car drives there.
pub(super) fn carriageway(tags: &Tags) -> Option<Carriageway> {
    let highway = tags.get("highway").filter(|_| is_on_the_ground(tags))?;
    let highway = highway.strip_suffix("_link").unwrap_or(highway);
    let usual = usual(highway, tags)?;
    // The most specific key that is present decides.
    let keys = ["motorcar", "motor_vehicle", "vehicle", "access"];
    if keys.iter().find_map(|key| tags.get(key)) == Some("no") {
        return None;
    }
    let lanes = number(tags, "lanes")
        .filter(|l| (1.0..=8.0).contains(l))
        .map(|l| LANE_M * l);
    // Numbers beyond these bounds are taken for mistakes.
    let tagged = number(tags, "width").filter(|w| (2.0..=40.0).contains(w));
    let half_width = tagged.or(lanes).unwrap_or(usual.width) / 2.0;
    let Directions { forward, backward } = directions(tags, highway);
    let fast = matches!(highway, "motorway" | "trunk");
    Some(Carriageway {
        half_width,
        limit: max_speed(tags).unwrap_or(usual.limit).clamp(5.0, 100.0) / 3.6,
        forward,
        backward,
        left_hand: tags.is("driving_side", "left"),
        walkers: if fast {
            Walkers::default()
        } else {
            walkers(tags, half_width)
        },
    })
}

fn usual(highway: &str, tags: &Tags) -> Option<Usual> {
    let (width, limit) = match highway {
        "motorway" | "trunk" => (10.0, 80.0),
        "primary" => (8.5, 50.0),
        "secondary" => (7.5, 50.0),
        "tertiary" => (6.5, 50.0),
        "residential" | "unclassified" | "road" => (5.5, 30.0),
        "living_street" => (5.0, WALKING_KMH),
        "service" if tags.is("service", "parking_aisle") => (5.0, 10.0),
        "service" => (3.2, 10.0),
        _ => return None,
    };
    Some(Usual { width, limit })
}

/// Half the width of a footway, metres; `None` if the way is none.
pub(super) fn footway_half_width(tags: &Tags) -> Option<f64> {
    let width = match tags.get("highway").filter(|_| is_on_the_ground(tags))? {
        "pedestrian" => 4.0,
        "footway" if tags.is("footway", "sidewalk") => 2.0,
        "footway" | "path" => 1.5,
        _ => return None,
    };
    let tagged = number(tags, "width").filter(|w| (0.5..=40.0).contains(w));
    let access = tags.get("foot").or(tags.get("access"));
    (access != Some("no")).then(|| tagged.unwrap_or(width) / 2.0)
}

fn is_on_the_ground(tags: &Tags) -> bool {
    let below = tags.says("tunnel") || tags.get("layer").is_some_and(|l| l.starts_with('-'));
    !below && !tags.is("area", "yes") && !tags.says("indoor")
}

/// In which directions cars drive on a way.
struct Directions {
    /// In the order of the way's nodes.
    forward: bool,
    /// Against that order.
    backward: bool,
}

impl Directions {
    const FORWARD: Self = Self {
        forward: true,
        backward: false,
    };
    const BACKWARD: Self = Self {
        forward: false,
        backward: true,
    };
    const BOTH: Self = Self {
        forward: true,
        backward: true,
    };
}

/// In which directions cars drive. OSM implies `oneway=yes` for roundabouts and motorways.
fn directions(tags: &Tags, highway: &str) -> Directions {
    match tags.get("oneway") {
        Some("yes" | "true" | "1") => Directions::FORWARD,
        Some("-1" | "reverse") => Directions::BACKWARD,
        Some("no") => Directions::BOTH,
        _ if tags.is("junction", "roundabout") || highway == "motorway" => Directions::FORWARD,
        _ => Directions::BOTH,
    }
}

fn walkers(tags: &Tags, half_width: f64) -> Walkers {
    let paved = Some(half_width + PAVEMENT_M / 2.0);
    let verge = Some(half_width + VERGE_M);
    // Such streets usually have no pavement.
    let narrow = ["service", "living_street"]
        .iter()
        .any(|h| tags.is("highway", h));
    let usual = if narrow { verge } else { paved };
    match tags.get("sidewalk") {
        // Those pavements are ways of their own, and people walk on them.
        Some("separate") => Walkers::default(),
        Some("no" | "none") => Walkers {
            left: verge,
            right: verge,
        },
        Some("left") => Walkers {
            left: paved,
            right: verge,
        },
        Some("right") => Walkers {
            left: verge,
            right: paved,
        },
        _ => Walkers {
            left: on_side(tags, "sidewalk:left", verge, usual),
            right: on_side(tags, "sidewalk:right", verge, usual),
        },
    }
}

/// Where people walk on the side that `key` describes.
fn on_side(tags: &Tags, key: &str, verge: Option<f64>, usual: Option<f64>) -> Option<f64> {
    match tags.get(key).or(tags.get("sidewalk:both")) {
        Some("separate") => None,
        Some("no") => verge,
        _ => usual,
    }
}

/// `maxspeed` in km/h.
fn max_speed(tags: &Tags) -> Option<f64> {
    let text = tags.get("maxspeed")?.trim();
    if text == "walk" {
        return Some(WALKING_KMH);
    }
    let (digits, scale) = match text.strip_suffix("mph") {
        Some(miles) => (miles, KM_PER_MILE),
        None => (text, 1.0),
    };
    // Other values, such as `none` or `DE:urban`, leave the usual limit.
    let value: f64 = digits.trim().parse().ok()?;
    (value.is_finite() && value > 0.0).then_some(value * scale)
}

/// A number, with or without the unit `m` behind it.
fn number(tags: &Tags, key: &str) -> Option<f64> {
    let text = tags.get(key)?.trim().trim_end_matches('m').trim_end();
    text.replace(',', ".")
        .parse()
        .ok()
        .filter(|v: &f64| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(tags: &[(&str, &str)]) -> Option<Carriageway> {
        carriageway(&tags.iter().copied().collect::<Tags>())
    }

    #[test]
    fn limits_are_tagged_or_usual() {
        let limit = |tags: &[(&str, &str)]| of(tags).map(|c| libm::round(c.limit * 3.6));
        assert_eq!(limit(&[("highway", "residential")]), Some(30.0));
        assert_eq!(
            limit(&[("highway", "residential"), ("maxspeed", "20 mph")]),
            Some(32.0)
        );
        assert_eq!(
            limit(&[("highway", "residential"), ("maxspeed", "nan")]),
            Some(30.0)
        );
        assert_eq!(limit(&[("highway", "tertiary_link")]), Some(50.0));
        assert_eq!(
            limit(&[("highway", "residential"), ("motor_vehicle", "no")]),
            None
        );
        assert_eq!(limit(&[("highway", "footway")]), None);
    }

    #[test]
    fn people_walk_on_the_pavements_that_exist() {
        let walkers = |tags: &[(&str, &str)]| of(tags).unwrap().walkers;
        let street = walkers(&[
            ("highway", "residential"),
            ("width", "6"),
            ("sidewalk", "left"),
        ]);
        assert_eq!(
            street,
            Walkers {
                left: Some(3.9),
                right: Some(3.5)
            }
        );
        let separate = walkers(&[("highway", "residential"), ("sidewalk", "separate")]);
        assert_eq!(separate, Walkers::default());
        let footway = Tags::from([("highway", "footway"), ("width", "2.4 m")]);
        assert_eq!(footway_half_width(&footway), Some(1.2));
    }
}
