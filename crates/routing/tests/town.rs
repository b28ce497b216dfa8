//! Profiles, turns, ends and private ground, in a town small enough to know every answer.

use openbench_core::{Georeference, LonLat, MapPoint};
use openbench_osm::{OsmData, Projection};
use openbench_routing::{MapRouter, Profile, Route, RouteError, Router};

/// Main Street from west to east (nodes 1 to 4, 100 m apart), with three streets north to High
/// Street.
const TOWN: &str = r#"<osm version="0.6">
  <node id="1" lat="0" lon="0.000"/><node id="2" lat="0" lon="0.001"/>
  <node id="3" lat="0" lon="0.002"/><node id="4" lat="0" lon="0.003"/>
  <node id="12" lat="0.001" lon="0.001"/><node id="13" lat="0.001" lon="0.002"/>
  <node id="14" lat="0.001" lon="0.003"/>
  <way id="1"><nd ref="1"/><nd ref="2"/><tag k="highway" v="residential"/>
  <tag k="name" v="Main Street"/></way>
  <way id="2"><nd ref="2"/><nd ref="3"/><nd ref="4"/><tag k="highway" v="residential"/>
  <tag k="name" v="Main Street"/></way>
  <way id="3"><nd ref="2"/><nd ref="12"/><tag k="highway" v="residential"/>
  <tag k="name" v="First Street"/></way>
  <way id="4"><nd ref="4"/><nd ref="14"/><tag k="highway" v="residential"/>
  <tag k="name" v="Third Street"/></way>
  <way id="5"><nd ref="12"/><nd ref="13"/><nd ref="14"/><tag k="highway" v="residential"/>
  <tag k="name" v="High Street"/></way>
  MORE
</osm>"#;

struct Town {
    router: MapRouter,
    projection: Projection,
}

impl Town {
    fn new(profile: &str, more: &str) -> Self {
        let data = OsmData::from_xml(TOWN.replace("MORE", more).as_bytes()).unwrap();
        let projection = Projection::new(Georeference::tangent_plane(LonLat::new(0.0, 0.0)));
        let profile = Profile::named(profile).unwrap();
        Self {
            router: MapRouter::new(&data, projection.clone(), profile).unwrap(),
            projection,
        }
    }

    fn at(&self, lon: f64, lat: f64) -> MapPoint {
        self.projection.to_map(LonLat::new(lon, lat))
    }

    fn route(&self, from: (f64, f64), to: (f64, f64)) -> Result<Route, RouteError> {
        self.router
            .route(self.at(from.0, from.1), self.at(to.0, to.1))
    }

    /// The length of a route, in units of 100 m.
    fn length(&self, from: (f64, f64), to: (f64, f64)) -> f64 {
        (self.route(from, to).unwrap().distance / 11.13).round() / 10.0
    }
}

const WEST: (f64, f64) = (0.0002, 0.0);
const NORTH: (f64, f64) = (0.001, 0.0008);

#[test]
fn cars_drive_around_a_forbidden_turn() {
    let no_left = r#"<relation id="1"><member type="way" ref="1" role="from"/>
      <member type="node" ref="2" role="via"/>
      <member type="way" ref="3" role="to"/><tag k="type" v="restriction"/>
      <tag k="restriction" v="no_left_turn"/></relation>"#;
    let free = Town::new("car", "");
    assert_eq!(free.length(WEST, NORTH), 1.6);
    // Main Street, Third Street, High Street, and First Street from its other end.
    let round = Town::new("car", no_left).length(WEST, NORTH);
    assert_eq!(round, 6.0);
    assert_eq!(Town::new("delivery", no_left).length(WEST, NORTH), 1.6);
    let not_for_cars = no_left.replace(
        "\"no_left_turn\"/>",
        "\"no_left_turn\"/><tag k=\"except\" v=\"bicycle;motorcar\"/>",
    );
    assert_eq!(Town::new("car", &not_for_cars).length(WEST, NORTH), 1.6);
}

#[test]
fn a_restriction_may_name_several_roads_to_come_from() {
    let no_entry = r#"<relation id="1"><member type="way" ref="2" role="from"/>
      <member type="way" ref="1" role="from"/>
      <member type="node" ref="2" role="via"/><member type="way" ref="3" role="to"/>
      <tag k="type" v="restriction"/>
      <tag k="restriction" v="no_entry"/></relation>"#;
    assert_eq!(Town::new("car", no_entry).length(WEST, NORTH), 6.0);
    assert_eq!(Town::new("car", no_entry).length((0.0015, 0.0), NORTH), 4.7);
}

#[test]
fn a_mandatory_turn_forbids_the_others() {
    let only = r#"<relation id="1"><member type="way" ref="1" role="from"/>
      <member type="node" ref="2" role="via"/>
      <member type="way" ref="2" role="to"/><tag k="type" v="restriction"/>
      <tag k="restriction" v="only_straight_on"/></relation>"#;
    assert_eq!(Town::new("car", only).length(WEST, NORTH), 6.0);
}

#[test]
fn one_way_streets_bind_cars_and_not_robots() {
    let bypass = r#"<node id="20" lat="-0.001" lon="0.001"/><node id="21" lat="-0.001" lon="0.002"/>
      <way id="20"><nd ref="3"/><nd ref="21"/><nd ref="20"/><nd ref="2"/>
      <tag k="highway" v="primary"/><tag k="oneway" v="yes"/></way>"#;
    let (from, to) = ((0.001, -0.0005), (0.002, -0.0005));
    assert_eq!(Town::new("delivery", bypass).length(from, to), 2.0);
    assert_eq!(Town::new("car", bypass).length(from, to), 2.0);
    // In the other direction the bypass is the only route.
    assert_eq!(Town::new("car", bypass).length(to, from), 2.0);
    let (before, behind) = ((0.0012, -0.001), (0.0018, -0.001));
    assert_eq!(Town::new("car", bypass).length(behind, before), 0.6);
    assert_eq!(Town::new("car", bypass).length(before, behind), 3.4);
    assert_eq!(Town::new("delivery", bypass).length(before, behind), 0.6);
}

#[test]
fn private_ground_is_for_routes_that_begin_or_end_there() {
    let short_cut = r#"<way id="20"><nd ref="3"/><nd ref="13"/><tag k="highway" v="service"/>
      <tag k="access" v="private"/></way>"#;
    let town = Town::new("delivery", short_cut);
    assert_eq!(town.length((0.002, 0.0), (0.002, 0.001)), 3.0);
    assert_eq!(town.length((0.0018, 0.0), (0.002, 0.0006)), 0.8);
    assert_eq!(town.length((0.002, 0.0006), (0.0018, 0.0)), 0.8);
    let foot = Town::new("foot", short_cut);
    assert_eq!(foot.length((0.0018, 0.0), (0.002, 0.001)), 2.8);
    // Private ground is passed if there is no other route.
    let bridge = r#"<node id="30" lat="0.002" lon="0.002"/><way id="20"><nd ref="13"/>
      <nd ref="30"/><tag k="highway" v="service"/>
      <tag k="access" v="private"/></way><node id="31" lat="0.003" lon="0.002"/><way id="21">
      <nd ref="30"/><nd ref="31"/><tag k="highway" v="footway"/></way>"#;
    assert_eq!(
        Town::new("delivery", bridge).length((0.002, 0.001), (0.002, 0.003)),
        2.0
    );
}

#[test]
fn barriers_stop_and_gates_delay() {
    let gate = |barrier: &str| {
        format!(
            r#"<node id="5" lat="0.0005" lon="0.002"><tag k="barrier" v="{barrier}"/></node>
          <way id="20"><nd ref="3"/><nd ref="5"/><nd ref="13"/><tag k="highway" v="footway"/>
          </way>"#
        )
    };
    let (south, north) = ((0.002, 0.0), (0.002, 0.001));
    let through = Town::new("delivery", &gate("gate"))
        .route(south, north)
        .unwrap();
    assert!(
        (through.duration - (through.distance / 0.5 + 10.0)).abs() < 0.1,
        "{through:?}"
    );
    assert_eq!(
        Town::new("delivery", &gate("stile")).length(south, north),
        3.0
    );
    // The barrier can be approached from either side.
    assert_eq!(
        Town::new("delivery", &gate("stile")).length(south, (0.002, 0.0004)),
        0.4
    );
}

#[test]
fn both_ends_on_one_street() {
    let town = Town::new("car", "");
    let there = town.route((0.0002, 0.0), (0.0008, 0.0)).unwrap();
    assert_eq!(
        (there.names.as_slice(), there.points.len()),
        (&["Main Street".to_owned()][..], 2)
    );
    assert_eq!(town.length((0.0008, 0.0), (0.0002, 0.0)), 0.6);
    assert_eq!(town.length((0.0005, 0.0), (0.0005, 0.0)), 0.0);
}

#[test]
fn unconnected_places_have_no_route() {
    let town = Town::new("delivery", "");
    assert!(matches!(
        town.route(WEST, (0.5, 0.5)),
        Err(RouteError::NoSegment { .. })
    ));
    let island = r#"<node id="30" lat="0.004" lon="0.004"/><node id="31" lat="0.004" lon="0.005"/>
      <way id="30"><nd ref="30"/><nd ref="31"/><tag k="highway" v="footway"/></way>"#;
    let town = Town::new("delivery", island);
    // Routes within an island stay there. For a route to the town, the start is moved to the town's
    // streets.
    assert_eq!(town.length((0.004, 0.004), (0.005, 0.004)), 1.0);
    assert!(
        town.route((0.004, 0.004), WEST).unwrap().points[0].distance(town.at(0.003, 0.001)) < 1.0
    );
}

/// A square of 100 m with a path at its south-west and another at its north-east corner. `outline`
/// holds the tags of its outline.
fn square(outline: &str) -> String {
    format!(
        r#"<node id="50" lat="0.01" lon="0.01"/><node id="51" lat="0.01" lon="0.011"/>
      <node id="52" lat="0.011" lon="0.011"/>
        <node id="53" lat="0.011" lon="0.01"/><node id="54" lat="0.009" lon="0.01"/>
        <node id="55" lat="0.012" lon="0.011"/>
        <way id="50"><nd ref="54"/><nd ref="50"/><tag k="highway" v="footway"/></way>
        <way id="51"><nd ref="52"/><nd ref="55"/><tag k="highway" v="footway"/></way>
        <way id="52"><nd ref="50"/><nd ref="51"/><nd ref="52"/><nd ref="53"/>
        <nd ref="50"/>{outline}</way>"#
    )
}

const OUTLINE: &str = r#"<tag k="highway" v="pedestrian"/><tag k="area" v="yes"/>"#;

#[test]
fn squares_are_crossed_and_osrms_pedestrian_walks_around() {
    let (from, to) = ((0.01, 0.009), (0.011, 0.012));
    let across = Town::new("delivery", &square(OUTLINE))
        .route(from, to)
        .unwrap();
    assert!(
        (across.distance - (110.57 * 2.0 + 156.9)).abs() < 1.0,
        "{}",
        across.distance
    );
    let round = Town::new("foot", &square(OUTLINE)).route(from, to).unwrap();
    assert!(
        (round.distance - (110.57 * 3.0 + 111.3)).abs() < 1.0,
        "{}",
        round.distance
    );
}

#[test]
fn holes_in_squares_are_walked_around() {
    // A fountain in the middle, 40 m wide.
    let holed = square("")
        + r#"<node id="60" lat="0.0103" lon="0.0103"/><node id="61" lat="0.0103" lon="0.0107"/>
      <node id="62" lat="0.0107" lon="0.0107"/><node id="63" lat="0.0107" lon="0.0103"/>
      <way id="53"><nd ref="60"/><nd ref="61"/><nd ref="62"/><nd ref="63"/><nd ref="60"/></way>
      <relation id="9"><member type="way" ref="52" role="outer"/>
      <member type="way" ref="53" role="inner"/>
      <tag k="type" v="multipolygon"/><tag k="highway" v="pedestrian"/></relation>"#;
    let route = Town::new("delivery", &holed)
        .route((0.01, 0.009), (0.011, 0.012))
        .unwrap();
    // By a corner of the fountain: 76.1 m twice.
    assert!(
        (route.distance - (110.57 * 2.0 + 2.0 * 84.5)).abs() < 2.0,
        "{}",
        route.distance
    );
    assert_eq!(route.points.len(), 5);
}

#[test]
fn a_square_with_a_degenerate_outline_is_harmless() {
    for rings in [
        "<nd ref=\"50\"/><nd ref=\"50\"/><nd ref=\"50\"/><nd ref=\"50\"/>",
        "<nd ref=\"50\"/><nd ref=\"52\"/><nd ref=\"51\"/><nd ref=\"53\"/><nd ref=\"50\"/>",
    ] {
        let odd = square(OUTLINE) + &format!("<way id=\"60\">{rings}{OUTLINE}</way>");
        assert!(
            Town::new("delivery", &odd)
                .route((0.01, 0.009), (0.011, 0.012))
                .is_ok()
        );
    }
}

/// Found by fuzzing: a way of which one node is known makes a vertex without edges, and a cell of
/// such vertices has no states.
#[test]
fn vertices_without_edges_are_harmless() {
    let lone: String = (100..200)
        .map(|i| {
            let lon = 1.0 + f64::from(i) / 1e4;
            format!(
                r#"<node id="{i}" lat="0" lon="{lon}"/><way id="{i}"><nd ref="{i}"/>
      <nd ref="{i}"/><tag k="highway" v="path"/></way>"#
            )
        })
        .collect();
    for profile in Profile::NAMES {
        assert_eq!(Town::new(profile, &lone).length(WEST, NORTH), 1.6);
    }
}

/// The car makes a U-turn at the bollard, and does not pass it.
#[test]
fn a_u_turn_at_a_barrier_takes_no_longer_than_its_weight() {
    let blocked = r#"<relation id="1"><member type="way" ref="1" role="from"/>
      <member type="node" ref="2" role="via"/>
      <member type="way" ref="3" role="to"/><tag k="type" v="restriction"/>
      <tag k="restriction" v="no_left_turn"/></relation>
      <node id="90" lat="0" lon="0.0015"><tag k="barrier" v="bollard"/></node>"#;
    let town = TOWN.replace(
        r#"<nd ref="2"/><nd ref="3"/><nd ref="4"/>"#,
        r#"<nd ref="2"/><nd ref="90"/><nd ref="3"/><nd ref="4"/>"#,
    );
    let data = OsmData::from_xml(town.replace("MORE", blocked).as_bytes()).unwrap();
    let projection = Projection::new(Georeference::tangent_plane(LonLat::new(0.0, 0.0)));
    let router = MapRouter::new(&data, projection.clone(), Profile::named("car").unwrap()).unwrap();
    let at = |(lon, lat): (f64, f64)| projection.to_map(LonLat::new(lon, lat));
    let route = router.route(at(WEST), at(NORTH)).unwrap();
    assert!(
        (route.distance / 111.3 - 2.6).abs() < 0.05 && route.duration < 120.0,
        "{route:?}"
    );
}

#[test]
fn routes_cross_the_date_line() {
    let xml = r#"<osm version="0.6"><node id="1" lat="10" lon="179.999"/>
      <node id="2" lat="10" lon="-179.999"/>
      <way id="1"><nd ref="1"/><nd ref="2"/><tag k="highway" v="path"/></way></osm>"#;
    let data = OsmData::from_xml(xml.as_bytes()).unwrap();
    let roads = openbench_routing::Roads::read(&data, &Default::default()).unwrap();
    let metric = openbench_routing::Metric::new(&roads, Profile::delivery()).unwrap();
    use openbench_routing::geo::Place;
    use openbench_routing::position::{Snap, SnapOptions};
    for lon in [179.9995, -179.9995] {
        let place = Place::new(LonLat::new(lon, 10.0001)).unwrap();
        let snap = Snap::new(
            &roads,
            &metric,
            place,
            &SnapOptions::default(),
            &mut Default::default(),
        );
        assert!((snap.nearest[0].away - 11.06).abs() < 0.1, "{snap:?}");
        assert!(
            (snap.nearest[0].place.position().lon - lon).abs() < 1e-6,
            "{snap:?}"
        );
    }
}

#[test]
fn a_blocked_road_is_closed_and_avoided() {
    let mut town = Town::new("delivery", "");
    let (first_street, high_street) = ((0.001, 0.0004), (0.0012, 0.001));
    let before = town.length(WEST, high_street);
    let nowhere = town.at(0.5, 0.5);
    assert!(!town.router.close(nowhere, 10.0), "no road is near");
    assert_eq!(town.length(WEST, high_street), before);
    let blocked = town.at(first_street.0, first_street.1);
    assert!(town.router.close(blocked, 10.0));
    assert!(town.length(WEST, high_street) > before);
}
