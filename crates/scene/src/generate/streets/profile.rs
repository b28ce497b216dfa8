//! The cross section of a `highway=*` way, from its tags.

use openbench_osm::Tags;

/// Width of the kerb stones beside a carriageway, metres.
pub(crate) const KERB_WIDTH_M: f64 = 0.14;
/// Width of a pavement that the map does not draw as a way of its own, metres.
const PAVEMENT_WIDTH_M: f64 = 1.8;

/// How a `highway=*` way is built.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Profile {
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

/// What is usual for a kind of way.
struct Usual {
    /// Width, metres.
    width: f64,
    for_cars: bool,
    /// Whether it has pavements and markings.
    street: bool,
}

impl Usual {
    /// For cars alone.
    fn road(width: f64) -> Self {
        Self {
            width,
            for_cars: true,
            street: false,
        }
    }

    /// For cars, with pavements.
    fn street(width: f64) -> Self {
        Self {
            street: true,
            ..Self::road(width)
        }
    }

    /// For people alone.
    fn path(width: f64) -> Self {
        Self {
            for_cars: false,
            ..Self::road(width)
        }
    }
}

/// The profile of a way; `None` if nothing of it is on the ground.
pub(crate) fn profile(tags: &Tags) -> Option<Profile> {
    let underground = tags.says("tunnel") || tags.get("layer").is_some_and(|l| l.starts_with('-'));
    if underground || tags.is("area", "yes") || tags.says("indoor") {
        return None;
    }
    let usual = usual(tags)?;
    // A width is what was measured or estimated; the number of lanes comes second, the kind of road
    // last.
    let lanes = tags
        .get("lanes")
        .and_then(|l| l.parse::<f64>().ok())
        .filter(|l| (1.0..=8.0).contains(l));
    let width = metres(tags, "width")
        .filter(|w| (0.5..=40.0).contains(w))
        .or(lanes.map(|l| 3.0 * l))
        .unwrap_or(usual.width);
    let sides = if usual.street {
        pavement_sides(tags)
    } else {
        [false; 2]
    };
    let pavement = if sides[0] || sides[1] {
        PAVEMENT_WIDTH_M
    } else {
        0.0
    };
    // On a narrower street, two lanes have no line between them.
    let marked = usual.street && width >= 5.0;
    Some(Profile {
        width,
        pavement,
        sides,
        for_cars: usual.for_cars,
        marked,
    })
}

fn usual(tags: &Tags) -> Option<Usual> {
    let (road, street, path) = (Usual::road, Usual::street, Usual::path);
    Some(match tags.get("highway")? {
        "motorway" | "trunk" => road(10.0),
        "primary" => street(8.5),
        "secondary" => street(7.5),
        "tertiary" => street(6.5),
        "residential" | "unclassified" | "road" => street(5.5),
        "living_street" => road(5.0),
        "motorway_link" | "trunk_link" | "primary_link" | "secondary_link" | "tertiary_link" => {
            road(4.5)
        }
        "service" if tags.is("service", "parking_aisle") => road(5.0),
        "service" => road(3.2),
        "track" | "busway" => road(3.0),
        "pedestrian" => path(4.0),
        "cycleway" | "bridleway" => path(2.2),
        "footway" if tags.is("footway", "sidewalk") => path(2.0),
        "footway" | "path" | "steps" | "corridor" => path(1.5),
        _ => return None,
    })
}

fn pavement_sides(tags: &Tags) -> [bool; 2] {
    let side = |name: &str| {
        let value = tags
            .get(&format!("sidewalk:{name}"))
            .or(tags.get("sidewalk:both"));
        value.map(|v| v == "yes")
    };
    match tags.get("sidewalk") {
        Some("separate" | "no" | "none") => [false; 2],
        Some("left") => [true, false],
        Some("right") => [false, true],
        _ => [side("left").unwrap_or(true), side("right").unwrap_or(true)],
    }
}

/// A length tag in metres, above zero.
pub(crate) fn metres(tags: &Tags, key: &str) -> Option<f64> {
    tags.metres(key).filter(|v| *v > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_override_the_usual_profile() {
        let usual = profile(&Tags::from([("highway", "residential")])).unwrap();
        assert!(usual.for_cars && usual.sides == [true, true] && usual.pavement > 1.0);
        let tags = [
            ("highway", "residential"),
            ("width", "7,5 m"),
            ("sidewalk", "left"),
        ];
        let tagged = profile(&Tags::from(tags)).unwrap();
        assert_eq!((tagged.width, tagged.sides), (7.5, [true, false]));
        let separate = [("highway", "residential"), ("sidewalk", "separate")];
        assert_eq!(profile(&Tags::from(separate)).unwrap().pavement, 0.0);
        assert_eq!(
            profile(&Tags::from([("highway", "footway"), ("tunnel", "yes")])),
            None
        );
        assert_eq!(profile(&Tags::from([("highway", "proposed")])), None);
    }
}
