//! Alternatives are as light, as different and as sensible as promised.

#[path = "../../skips.rs"]
mod skips;

use openbench_core::LonLat;
use openbench_osm::OsmData;
use openbench_routing::geo::Place;
use openbench_routing::leg::{Leg, Memory};
use openbench_routing::partition::CellSizes;
use openbench_routing::position::{Position, Snap, SnapOptions};
use openbench_routing::{Metric, Profile, Roads};
use skips::shared_data;

/// A straight road of 400 m from west to east along the equator. Two detours in its middle lead to
/// the north and to the south, by so many thousandths of a degree. A side street comes back to
/// where it began.
fn roads(north: f64, south: f64) -> Roads {
    let xml = format!(
        r#"<osm version="0.6"><node id="1" lat="0" lon="0"/><node id="2" lat="0" lon="0.0005"/>
      <node id="3" lat="0" lon="0.0035"/>
        <node id="4" lat="0" lon="0.004"/><node id="5" lat="{n}" lon="0.0005"/>
        <node id="6" lat="{n}" lon="0.0035"/>
        <node id="7" lat="{s}" lon="0.0005"/><node id="8" lat="{s}" lon="0.0035"/>
        <node id="9" lat="0.0002" lon="0.0020"/>
        <node id="12" lat="{n}" lon="0.0001"/><node id="13" lat="{s}" lon="0.0001"/>
        <node id="10" lat="0" lon="0.0018"/><node id="11" lat="0" lon="0.0022"/>
        <way id="1"><nd ref="1"/><nd ref="2"/><nd ref="10"/><nd ref="11"/><nd ref="3"/>
        <nd ref="4"/><tag k="highway" v="footway"/></way>
        <way id="2"><nd ref="2"/><nd ref="5"/><nd ref="6"/><nd ref="3"/>
        <tag k="highway" v="footway"/></way>
        <way id="3"><nd ref="2"/><nd ref="7"/><nd ref="8"/><nd ref="3"/>
        <tag k="highway" v="footway"/></way>
        <way id="5"><nd ref="5"/><nd ref="12"/><tag k="highway" v="footway"/></way>
        <way id="6"><nd ref="7"/><nd ref="13"/><tag k="highway" v="footway"/></way>
        <way id="4"><nd ref="10"/><nd ref="9"/><nd ref="11"/><tag k="highway" v="footway"/></way>
        </osm>"#,
        n = north / 1e3,
        s = -south / 1e3
    );
    Roads::read(
        &OsmData::from_xml(xml.as_bytes()).unwrap(),
        &CellSizes::new(&[100]).unwrap(),
    )
    .unwrap()
}

/// The lengths of all routes that are offered, metres.
fn ways(north: f64, south: f64, others: usize) -> Vec<f64> {
    let roads = roads(north, south);
    let metric = Metric::new(&roads, Profile::named("foot").unwrap()).unwrap();
    let snap = |lon: f64| -> Vec<Position> {
        let place = Place::new(LonLat::new(lon, 0.0)).unwrap();
        Snap::new(
            &roads,
            &metric,
            place,
            &SnapOptions::default(),
            &mut Default::default(),
        )
        .nearest
    };
    let legs = Leg::alternatives(
        &roads,
        &metric,
        &snap(0.0001),
        &snap(0.0039),
        others,
        &mut Memory::default(),
    );
    legs.iter()
        .map(|leg| leg.length_and_duration(&roads, &metric).length.round())
        .collect()
}

#[test]
fn detours_are_offered_in_order_if_they_are_short_enough() {
    let straight = 423.0;
    assert_eq!(ways(0.2, 0.3, 3), [straight, 467.0, 489.0]);
    assert_eq!(ways(0.2, 0.3, 1), [straight, 467.0]);
    // A quarter longer is too long.
    assert_eq!(ways(0.2, 0.6, 3), [straight, 467.0]);
    assert_eq!(ways(0.9, 0.9, 3), [straight]);
    assert_eq!(ways(0.2, 0.3, 0), [straight]);
}

#[test]
fn a_detour_along_a_side_street_is_no_alternative() {
    // It is short, but shares nearly all of the straight route.
    assert_eq!(ways(0.9, 0.9, 3).len(), 1);
}

/// Alternatives are found on real maps too, where cells hide what is inside them, and obey the
/// rules.
#[test]
fn alternatives_through_a_city_obey_the_rules() {
    let Some(map) = shared_data("osm/porto_portugal.osm.pbf") else {
        return;
    };
    let source = openbench_osm::stream::Source::open(&map).unwrap();
    let roads = Roads::read(&source, &Default::default()).unwrap();
    let metric = Metric::new(&roads, Profile::named("foot").unwrap()).unwrap();
    let (mut memory, mut with_others) = (Memory::default(), 0);
    for i in 0..40_i32 {
        let snap = |k: i32| {
            let place = Place::new(LonLat::new(
                -8.64 + f64::from(k * 7 % 40) * 0.002,
                41.14 + f64::from(k * 11 % 40) * 0.001,
            ));
            Snap::new(
                &roads,
                &metric,
                place.unwrap(),
                &SnapOptions::default(),
                &mut Default::default(),
            )
        };
        let (a, b) = (snap(i), snap(i + 17));
        let legs = Leg::alternatives(
            &roads,
            &metric,
            a.positions(false),
            b.positions(false),
            3,
            &mut memory,
        );
        with_others += usize::from(legs.len() > 1);
        for (number, leg) in legs.iter().enumerate() {
            assert!(
                f64::from(leg.weight) <= 1.25 * f64::from(legs[0].weight),
                "{i}"
            );
            let duration = leg.length_and_duration(&roads, &metric).duration;
            assert_eq!(
                duration, leg.weight,
                "{i} {number}: the way is what it claims to be"
            );
            for other in &legs[..number] {
                let shared = leg.edges.iter().filter(|edge| other.edges.contains(edge));
                let shared: f64 = shared
                    .map(|edge| f64::from(metric.edges[*edge as usize].weight()))
                    .sum();
                assert!(shared <= 0.75 * f64::from(legs[0].weight), "{i} {number}");
            }
        }
    }
    assert!(
        with_others >= 15,
        "only {with_others} of 40 had another way"
    );
}
