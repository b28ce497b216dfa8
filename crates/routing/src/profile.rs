//! Who may go where, and how fast.
//!
//! Tags are read as the OSM wiki's *Key:access* and *Key:highway* describe them: the most specific mode's word counts.
//! Conditional tags are not regarded.

use openbench_osm::Tags;

/// Speeds in both directions of a way, m/s; `None` where one may not go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Speeds {
    /// Along the way's nodes.
    pub forward: Option<f64>,
    /// Against them.
    pub backward: Option<f64>,
}

/// A means of transport.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Profile {
    /// A pavement robot: like a pedestrian, but never on steps, and a courier may enter private ground.
    Delivery,
    /// A pedestrian.
    Foot,
    /// A car.
    Car,
}

impl Profile {
    /// The names of all profiles.
    pub const NAMES: [&'static str; 3] = ["delivery", "foot", "car"];

    /// The profile of that name.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "delivery" => Some(Self::Delivery),
            "foot" => Some(Self::Foot),
            "car" => Some(Self::Car),
            _ => None,
        }
    }

    /// How fast this profile goes on a way with these tags.
    pub fn speeds(self, tags: &Tags) -> Speeds {
        const NOWHERE: Speeds = Speeds { forward: None, backward: None };
        let Some(speed) = tags.get("highway").and_then(|highway| self.speed_on(highway)) else {
            return NOWHERE;
        };
        if !self.may_enter(tags) {
            return NOWHERE;
        }
        let (forward, backward) = self.directions(tags);
        Speeds { forward: forward.then_some(speed), backward: backward.then_some(speed) }
    }

    fn speed_on(self, highway: &str) -> Option<f64> {
        match self {
            Self::Delivery => pavement_speed(highway).filter(|_| highway != "steps"),
            Self::Foot => pavement_speed(highway).map(|_| if highway == "steps" { 0.6 } else { 5.0 / 3.6 }),
            Self::Car => car_speed(highway),
        }
    }

    fn may_enter(self, tags: &Tags) -> bool {
        let keys: &[&str] = match self {
            Self::Delivery | Self::Foot => &["foot", "access"],
            Self::Car => &["motorcar", "motor_vehicle", "vehicle", "access"],
        };
        let Some(word) = keys.iter().find_map(|key| tags.get(key)) else { return true };
        match word {
            "no" | "use_sidepath" => false,
            "private" | "delivery" | "customers" => self == Self::Delivery,
            _ => true,
        }
    }

    fn directions(self, tags: &Tags) -> (bool, bool) {
        if self != Self::Car {
            return (!tags.is("oneway:foot", "-1"), !tags.is("oneway:foot", "yes"));
        }
        match tags.get("oneway") {
            Some("yes" | "true" | "1") => (true, false),
            Some("-1" | "reverse") => (false, true),
            Some("no") => (true, true),
            _ if tags.is("junction", "roundabout") || tags.is("highway", "motorway") => (true, false),
            _ => (true, true),
        }
    }
}

/// Speed of a robot of 0.5 m/s on ways for people; roads with fast cars are avoided by a low speed.
fn pavement_speed(highway: &str) -> Option<f64> {
    match highway {
        "footway" | "pedestrian" | "living_street" | "path" | "cycleway" | "corridor" => Some(0.5),
        "service" | "residential" | "unclassified" | "track" | "road" => Some(0.45),
        "tertiary" | "tertiary_link" => Some(0.35),
        "secondary" | "secondary_link" | "primary" | "primary_link" => Some(0.25),
        "steps" => Some(0.1),
        _ => None,
    }
}

fn car_speed(highway: &str) -> Option<f64> {
    let kilometres_per_hour = match highway {
        "motorway" => 90.0,
        "trunk" => 85.0,
        "primary" => 65.0,
        "secondary" => 55.0,
        "tertiary" => 40.0,
        "motorway_link" | "trunk_link" => 45.0,
        "primary_link" | "secondary_link" | "tertiary_link" => 30.0,
        "unclassified" | "residential" | "road" => 25.0,
        "service" => 15.0,
        "living_street" => 10.0,
        _ => return None,
    };
    Some(kilometres_per_hour / 3.6)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tags(words: &[(&str, &str)]) -> Tags {
        let mut tags = Tags::default();
        for (key, value) in words {
            tags.insert(*key, *value);
        }
        tags
    }

    #[test]
    fn robots_take_no_steps_but_enter_private_ground() {
        let steps = tags(&[("highway", "steps")]);
        assert_eq!(Profile::Delivery.speeds(&steps).forward, None);
        assert!(Profile::Foot.speeds(&steps).forward.is_some());
        let private = tags(&[("highway", "service"), ("access", "private")]);
        assert!(Profile::Delivery.speeds(&private).forward.is_some());
        assert_eq!(Profile::Foot.speeds(&private).forward, None);
    }

    #[test]
    fn the_most_specific_word_counts() {
        let allowed = tags(&[("highway", "residential"), ("access", "no"), ("foot", "yes")]);
        assert!(Profile::Foot.speeds(&allowed).forward.is_some());
        assert_eq!(Profile::Car.speeds(&allowed).forward, None);
    }

    #[test]
    fn one_way_streets_bind_cars_only() {
        let street = tags(&[("highway", "residential"), ("oneway", "yes")]);
        assert_eq!(Profile::Car.speeds(&street).backward, None);
        assert!(Profile::Delivery.speeds(&street).backward.is_some());
        let against = tags(&[("highway", "residential"), ("oneway", "-1")]);
        assert_eq!(Profile::Car.speeds(&against).forward, None);
    }
}
