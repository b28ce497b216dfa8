//! Towns that are unlike others: without roads, on islands, behind walls, with a thousand doors.

mod common;

use std::fmt::Write as _;

use common::{Place, Ran};

/// A map, way by way, in metres around 50° north, 8° east.
struct Map {
    text: String,
    ways: String,
    nodes: usize,
}

impl Map {
    fn new() -> Self {
        Self {
            text: "<osm version='0.6'>\n".to_owned(),
            ways: String::new(),
            nodes: 0,
        }
    }

    fn way(mut self, points: &[(f64, f64)], closed: bool, tags: &[(&str, &str)]) -> Self {
        let first = self.nodes + 1;
        let mut way = String::new();
        for (x, y) in points {
            self.nodes += 1;
            let (lat, lon) = (50.0 + y / 111_229.0, 8.0 + x / 71_696.0);
            let _ = writeln!(
                self.text,
                "<node id='{}' lat='{lat:.8}' lon='{lon:.8}'/>",
                self.nodes
            );
            let _ = write!(way, "<nd ref='{}'/>", self.nodes);
        }
        if closed {
            let _ = write!(way, "<nd ref='{first}'/>");
        }
        for (key, value) in tags {
            let _ = write!(way, "<tag k='{key}' v='{value}'/>");
        }
        let _ = writeln!(self.ways, "<way id='{first}'>{way}</way>");
        self
    }

    fn area(self, low: (f64, f64), high: (f64, f64), tags: &[(&str, &str)]) -> Self {
        self.way(&[low, (high.0, low.1), high, (low.0, high.1)], true, tags)
    }

    fn house(self, x: f64, y: f64, number: usize) -> Self {
        let number = number.to_string();
        let tags = [
            ("building", "house"),
            ("addr:street", "Weg"),
            ("addr:housenumber", number.as_str()),
        ];
        self.area((x, y), (x + 10.0, y + 8.0), &tags)
    }

    fn street(self) -> Self {
        self.way(
            &[(-50.0, 0.0), (120.0, 0.0)],
            false,
            &[("highway", "residential"), ("name", "Weg")],
        )
    }

    /// Two houses at a street.
    fn hamlet() -> Self {
        Self::new().street().house(0.0, 6.0, 1).house(20.0, 6.0, 3)
    }

    /// What generating a world of it says.
    fn generate(self, more: &str) -> (Place, Ran) {
        let place = Place::new();
        place.file("map.osm", format!("{}{}</osm>", self.text, self.ways));
        let ran = place.openbench(&format!(
            "world generate --map map.osm --out w --georef tangent:8,50 {more}"
        ));
        (place, ran)
    }
}

/// Doors, those within reach, and those to deliver to, as a world's making says.
fn doors(ran: &Ran) -> [usize; 3] {
    let said = &ran.succeeded().stdout;
    let before = |words: &str| {
        let number = said
            .split(words)
            .next()
            .and_then(|s| s.rsplit([' ', ',']).next());
        number
            .and_then(|n| n.parse().ok())
            .unwrap_or_else(|| panic!("{said}"))
    };
    [
        before(" doors"),
        before(" reachable"),
        before(" to deliver to"),
    ]
}

#[test]
fn a_town_without_roads_is_delivered_in() {
    let (place, ran) = Map::new()
        .house(0.0, 6.0, 1)
        .house(20.0, 6.0, 3)
        .generate("--draw 1 0 3");
    assert_eq!(doors(&ran), [2, 2, 2]);
    let said = place.openbench("run w --json --out out").succeeded().json();
    assert_eq!(said["metrics"]["sr_2m"], 1.0, "{said}");
}

#[test]
fn one_road_and_one_house_are_a_town() {
    let (_place, ran) = Map::new().street().house(0.0, 6.0, 1).generate("");
    assert_eq!(doors(&ran), [1, 1, 1]);
}

#[test]
fn who_starts_on_an_island_delivers_there() {
    let water = ("natural", "water");
    let island = || {
        Map::hamlet()
            .area((-80.0, -60.0), (150.0, -8.0), &[water])
            .house(10.0, -40.0, 9)
    };
    let (_place, ran) = island().generate("");
    assert_eq!(doors(&ran), [3, 2, 2], "the mainland");
    let (_place, ran) = island().generate("--start=15,-45,0");
    assert_eq!(doors(&ran), [3, 1, 1], "the island");
}

#[test]
fn who_starts_behind_walls_or_in_a_house_is_told() {
    let walled = || Map::hamlet().area((-30.0, -40.0), (60.0, -10.0), &[("barrier", "wall")]);
    let (_place, ran) = walled().generate("--start=0,-25,0");
    ran.refused_with(&["no door can be delivered to", "--start"]);
    let (_place, ran) = walled().generate("");
    assert_eq!(doors(&ran), [2, 2, 2], "by itself the start is outside");
    let (_place, ran) = Map::hamlet().generate("--start=5,10,0");
    ran.refused_with(&["no door can be delivered to", "--start"]);
}

#[test]
fn a_thousand_doors_are_a_town() {
    let houses = (0..1000).fold(Map::new().street(), |map, i| {
        map.house(14.0 * (i % 40) as f64, 6.0 + 16.0 * (i / 40) as f64, i + 1)
    });
    let (_place, ran) = houses.generate("");
    let [all, reachable, near] = doors(&ran);
    assert_eq!((all, reachable), (1000, 1000));
    assert!(near > 100, "{near}");
}

#[test]
fn coordinates_beyond_the_earths_are_refused() {
    let place = Place::new();
    let Map { text, ways, .. } = Map::hamlet();
    let text = text
        .replace("lat='50.", "lat='150.")
        .replace("lon='8.", "lon='888.");
    place.file("map.osm", format!("{text}{ways}</osm>"));
    place
        .openbench("world generate --map map.osm --out w")
        .refused_with(&["map.osm"]);
}
