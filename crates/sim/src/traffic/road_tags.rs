//! What the words on a way say to those who walk and drive: widths, speeds, directions, pavements.
//!
//! Tags as the OSM wiki's *Key:highway*, *Key:maxspeed*, *Key:sidewalk* and *Key:driving side* have them. Usual widths are those
//! by which `openbench_scene::generate` builds streets. Conditional limits are not regarded.

use openbench_osm::Tags;

/// A carriageway.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Carriageway {
    /// Half its width, metres.
    pub half_width: f64,
    /// Speed limit, m/s.
    pub limit: f64,
    /// Whether cars go along the way's nodes, and against them.
    pub directions: [bool; 2],
    /// Whether one drives on the left.
    pub left_hand: bool,
    /// Distance of walkers from the middle, on the left and on the right; `None` where they do not walk.
    pub walkers: [Option<f64>; 2],
}

/// Width of a pavement that is not drawn as a way of its own, metres.
const PAVEMENT: f64 = 1.8;
/// Walkers beside a carriageway without a pavement keep this far from its edge, metres.
const VERGE: f64 = 0.5;

/// The carriageway of a way; `None` if no car drives there.
pub(super) fn carriageway(tags: &Tags) -> Option<Carriageway> {
    let highway = tags.get("highway").filter(|_| on_the_ground(tags))?;
    let highway = highway.strip_suffix("_link").unwrap_or(highway);
    // Usual width, metres; usual limit, km/h.
    let (width, limit) = match highway {
        "motorway" | "trunk" => (10.0, 80.0),
        "primary" => (8.5, 50.0),
        "secondary" => (7.5, 50.0),
        "tertiary" => (6.5, 50.0),
        "residential" | "unclassified" | "road" => (5.5, 30.0),
        "living_street" => (5.0, 7.0),
        "service" => (
            if tags.is("service", "parking_aisle") {
                5.0
            } else {
                3.2
            },
            10.0,
        ),
        _ => return None,
    };
    let access = ["motorcar", "motor_vehicle", "vehicle", "access"]
        .iter()
        .find_map(|key| tags.get(key));
    if access == Some("no") {
        return None;
    }
    let lanes = number(tags, "lanes")
        .filter(|l| (1.0..=8.0).contains(l))
        .map(|l| 3.0 * l);
    let told = number(tags, "width").filter(|w| (2.0..=40.0).contains(w));
    let half_width = told.or(lanes).unwrap_or(width) / 2.0;
    let fast = matches!(highway, "motorway" | "trunk");
    Some(Carriageway {
        half_width,
        limit: max_speed(tags).unwrap_or(limit).clamp(5.0, 100.0) / 3.6,
        directions: directions(tags, highway),
        left_hand: tags.is("driving_side", "left"),
        walkers: if fast {
            [None; 2]
        } else {
            walkers(tags, half_width)
        },
    })
}

/// Half the width of a way for walkers, metres; `None` if it is none.
pub(super) fn walkway(tags: &Tags) -> Option<f64> {
    let width = match tags.get("highway").filter(|_| on_the_ground(tags))? {
        "pedestrian" => 4.0,
        "footway" if tags.is("footway", "sidewalk") => 2.0,
        "footway" | "path" => 1.5,
        _ => return None,
    };
    let told = number(tags, "width").filter(|w| (0.5..=40.0).contains(w));
    let access = tags.get("foot").or(tags.get("access"));
    (access != Some("no")).then(|| told.unwrap_or(width) / 2.0)
}

fn on_the_ground(tags: &Tags) -> bool {
    let below = tags.says("tunnel") || tags.get("layer").is_some_and(|l| l.starts_with('-'));
    !below && !tags.is("area", "yes") && !tags.says("indoor")
}

fn directions(tags: &Tags, highway: &str) -> [bool; 2] {
    match tags.get("oneway") {
        Some("yes" | "true" | "1") => [true, false],
        Some("-1" | "reverse") => [false, true],
        Some("no") => [true, true],
        _ if tags.is("junction", "roundabout") || highway == "motorway" => [true, false],
        _ => [true, true],
    }
}

fn walkers(tags: &Tags, half_width: f64) -> [Option<f64>; 2] {
    let (paved, verge) = (half_width + PAVEMENT / 2.0, half_width + VERGE);
    let street = !["service", "living_street"]
        .iter()
        .any(|h| tags.is("highway", h));
    let usual = if street { paved } else { verge };
    let side = |name: &str| {
        let word = tags
            .get(&format!("sidewalk:{name}"))
            .or(tags.get("sidewalk:both"));
        match word {
            Some("separate") => None,
            Some("no") => Some(verge),
            _ => Some(usual),
        }
    };
    match tags.get("sidewalk") {
        Some("separate") => [None; 2],
        Some("no" | "none") => [Some(verge); 2],
        Some("left") => [Some(paved), Some(verge)],
        Some("right") => [Some(verge), Some(paved)],
        _ => [side("left"), side("right")],
    }
}

/// `maxspeed` in km/h.
fn max_speed(tags: &Tags) -> Option<f64> {
    let text = tags.get("maxspeed")?.trim();
    if text == "walk" {
        return Some(7.0);
    }
    let (digits, scale) = text
        .strip_suffix("mph")
        .map_or((text, 1.0), |miles| (miles, 1.609_344));
    digits
        .trim()
        .parse::<f64>()
        .ok()
        .filter(|v| v.is_finite() && *v > 0.0)
        .map(|v| v * scale)
}

/// A number; `m` may stand behind it.
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

    #[test]
    fn limits_are_told_or_usual() {
        let limit = |words: &[(&str, &str)]| {
            carriageway(&words.iter().copied().collect::<Tags>())
                .map(|c| libm::round(c.limit * 3.6))
        };
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
    fn walkers_keep_to_the_pavement_that_there_is() {
        let of =
            |words: &[(&str, &str)]| carriageway(&words.iter().copied().collect::<Tags>()).unwrap();
        let street = of(&[
            ("highway", "residential"),
            ("width", "6"),
            ("sidewalk", "left"),
        ]);
        assert_eq!(street.walkers, [Some(3.9), Some(3.5)]);
        assert_eq!(
            of(&[("highway", "residential"), ("sidewalk", "separate")]).walkers,
            [None; 2]
        );
        assert_eq!(
            walkway(&Tags::from([("highway", "footway"), ("width", "2.4 m")])),
            Some(1.2)
        );
    }
}
