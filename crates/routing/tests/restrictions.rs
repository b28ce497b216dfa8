//! Turn restrictions, also those that depend on the roads before, compared with a search that
//! remembers its whole path.

use std::cmp::Reverse;
use std::collections::{BTreeMap, BinaryHeap};

use openbench_core::LonLat;
use openbench_osm::OsmData;
use openbench_routing::geo::Place;
use openbench_routing::leg::{Leg, Memory};
use openbench_routing::partition::CellSizes;
use openbench_routing::position::{Position, Snap, SnapOptions};
use openbench_routing::tree::Nearest;
use openbench_routing::{Metric, Profile, Roads};
use proptest::prelude::*;

const WIDTH: i64 = 4;

/// A restriction: ways one after another, and whether this sequence is mandatory or forbidden.
type Said = (Vec<i64>, bool);

/// The streets of a grid. Each is a way from the node of its number, to the east if even and to the
/// north if odd.
fn streets() -> BTreeMap<i64, [i64; 2]> {
    let nodes = (0..WIDTH * WIDTH).flat_map(|node| {
        let east = (node % WIDTH + 1 < WIDTH).then_some((2 * node + 1, [node, node + 1]));
        let north = (node / WIDTH + 1 < WIDTH).then_some((2 * node + 2, [node, node + WIDTH]));
        [east, north]
    });
    nodes.flatten().collect()
}

fn place(node: i64) -> (f64, f64) {
    // Slightly irregular, so that no two routes are equally long.
    let (x, y) = (node % WIDTH, node / WIDTH);
    (
        (x * 1000 + node * 13 % 7 * 20) as f64 / 1e6,
        (y * 1000 + node * 11 % 5 * 30) as f64 / 1e6,
    )
}

fn roads(restrictions: &[Said]) -> Roads {
    let mut xml = "<osm version=\"0.6\">".to_owned();
    for node in 0..WIDTH * WIDTH {
        let (lon, lat) = place(node);
        xml += &format!("<node id=\"{}\" lat=\"{lat}\" lon=\"{lon}\"/>", node + 1);
    }
    for (way, [a, b]) in streets() {
        let nodes = format!("<nd ref=\"{}\"/><nd ref=\"{}\"/>", a + 1, b + 1);
        xml += &format!("<way id=\"{way}\">{nodes}<tag k=\"highway\" v=\"residential\"/></way>");
    }
    for (id, (ways, only)) in restrictions.iter().enumerate() {
        let member = |kind: &str, id: i64, role: &str| {
            format!("<member type=\"{kind}\" ref=\"{id}\" role=\"{role}\"/>")
        };
        let [from, via @ .., to] = ways.as_slice() else {
            continue;
        };
        let mut members = member("way", *from, "from") + &member("way", *to, "to");
        if via.is_empty() {
            let [a, b] = [from, to].map(|way| streets()[way]);
            let node = a.iter().find(|node| b.contains(node)).unwrap();
            members += &member("node", node + 1, "via");
        }
        via.iter()
            .for_each(|way| members += &member("way", *way, "via"));
        let kind = if *only {
            "only_straight_on"
        } else {
            "no_straight_on"
        };
        xml += &format!(
            "<relation id=\"{id}\">{members}<tag k=\"type\" v=\"restriction\"/>\
             <tag k=\"restriction\" v=\"{kind}\"/></relation>"
        );
    }
    let data = OsmData::from_xml((xml + "</osm>").as_bytes()).unwrap();
    Roads::read(&data, &CellSizes::new(&[4, 8]).unwrap()).unwrap()
}

/// A car to which turns are free.
fn car() -> Profile {
    let text = Profile::text("car")
        .unwrap()
        .replace("sharpest = 7.5", "sharpest = 0.0")
        .replace("u_turn = 20", "u_turn = 0");
    Profile::from_toml("car", &text).unwrap()
}

/// Paths along the grid that meet no node twice.
fn walk(begin: i64, turns: &[usize]) -> Vec<i64> {
    let streets = streets();
    let (mut at, mut met, mut ways) = (begin, vec![begin], Vec::new());
    for turn in turns {
        let onwards = streets.iter().filter_map(|(way, ends)| {
            let end = ends.iter().position(|node| *node == at)?;
            Some((*way, ends[1 - end])).filter(|(_, end)| !met.contains(end))
        });
        let onwards: Vec<_> = onwards.collect();
        let Some((way, end)) = onwards.get(turn % onwards.len().max(1)) else {
            break;
        };
        ways.push(*way);
        met.push(*end);
        at = *end;
    }
    ways
}

/// The weight of the lightest route from the middle of a way to the middle of another, by a search
/// that remembers the last ways. `weight` is the weight of a way.
fn oracle(restrictions: &[Said], from: i64, to: i64, weight: &impl Fn(i64) -> u32) -> Option<u32> {
    let streets = streets();
    // A directed way: its number, and whether it is travelled against its direction.
    type Directed = (i64, bool);
    let end = |(way, back): Directed| streets[&way][usize::from(!back)];
    let begin = |(way, back): Directed| streets[&way][usize::from(back)];
    let allowed = |travelled: &[Directed], next: Directed| {
        let last = travelled[travelled.len() - 1];
        let matches = |ways: &[i64]| {
            let tail = travelled
                .len()
                .checked_sub(ways.len())
                .map(|first| &travelled[first..]);
            tail.is_some_and(|tail| tail.iter().map(|d| d.0).eq(ways.iter().copied()))
        };
        let behind = |said: &&Said| {
            // The ways of a restriction meet no node twice, so their numbers determine the
            // directions in which they are travelled, except for the last one.
            let [row @ .., to] = said.0.as_slice() else {
                return false;
            };
            let onwards = streets[to].contains(&end(last));
            matches(row) && onwards
        };
        let here: Vec<&Said> = restrictions.iter().filter(behind).collect();
        let no = here
            .iter()
            .any(|said| !said.1 && said.0.last() == Some(&next.0));
        // Of all mandatory turns after the same ways one must be taken; of those after different
        // ways all.
        let row = |said: &Said| said.0[..said.0.len() - 1].to_vec();
        let kept = |said: &Said| {
            here.iter()
                .any(|other| other.1 && row(other) == row(said) && other.0.last() == Some(&next.0))
        };
        let back = next == (last.0, !last.1);
        !no && (back || here.iter().all(|said| !said.1 || kept(said)))
    };
    let mut heap: BinaryHeap<Reverse<(u32, Vec<Directed>)>> = BinaryHeap::new();
    for back in [false, true] {
        heap.push(Reverse((
            weight(from) - half(weight(from), back),
            vec![(from, back)],
        )));
    }
    let (mut done, mut best) = (std::collections::BTreeSet::new(), None::<u32>);
    while let Some(Reverse((reached, travelled))) = heap.pop() {
        if !done.insert(travelled.clone()) {
            continue;
        }
        let last = travelled[travelled.len() - 1];
        let exits = streets
            .keys()
            .flat_map(|way| [(*way, false), (*way, true)])
            .filter(|d| begin(*d) == end(last));
        let exits: Vec<Directed> = exits.filter(|d| allowed(&travelled, *d)).collect();
        let dead_end = exits.iter().all(|d| *d == (last.0, !last.1));
        for next in exits
            .into_iter()
            .filter(|d| dead_end || *d != (last.0, !last.1))
        {
            if next.0 == to {
                let weight = reached + half(weight(to), next.1);
                best = Some(best.map_or(weight, |best| best.min(weight)));
            }
            let mut way = travelled.clone();
            way.push(next);
            let first = way.len().saturating_sub(5);
            heap.push(Reverse((reached + weight(next.0), way[first..].to_vec())));
        }
    }
    best
}

/// The weight of half a way, in the direction in which it is travelled.
fn half(whole: u32, back: bool) -> u32 {
    let forward = (f64::from(whole) * 0.5).round() as u32;
    if back { whole - forward } else { forward }
}

/// The directed edges of a way, exactly in the middle of which a route begins or ends.
fn middle_of(roads: &Roads, metric: &Metric, way: i64) -> Vec<Position> {
    let [a, b] = streets()[&way].map(place);
    let middle = Place::new(LonLat::new((a.0 + b.0) / 2.0, (a.1 + b.1) / 2.0)).unwrap();
    let options = SnapOptions::default();
    let mut positions = Snap::new(roads, metric, middle, &options, &mut Nearest::default()).nearest;
    positions.retain(|position| position.edge == edge_of(roads, way));
    // Without the rounding errors of snapping.
    positions
        .iter_mut()
        .for_each(|position| position.share = 0.5);
    positions
}

/// The edge of a way.
fn edge_of(roads: &Roads, way: i64) -> u32 {
    roads
        .network
        .ways
        .iter()
        .position(|other| *other == way)
        .unwrap() as u32
}

fn walks() -> impl Strategy<Value = Vec<Said>> {
    let turns = proptest::collection::vec(0_usize..12, 2..6);
    let said = (0..WIDTH * WIDTH, turns, any::<bool>())
        .prop_map(|(begin, turns, only)| (walk(begin, &turns), only));
    proptest::collection::vec(said, 1..14)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn routes_obey_all_restrictions(
        walks in walks(),
        trips in proptest::collection::vec((0_usize..24, 0_usize..24), 6),
    ) {
        let said: Vec<Said> = walks.into_iter().filter(|said| said.0.len() > 1).collect();
        let roads = roads(&said);
        let metric = Metric::new(&roads, car()).unwrap();
        let weight = |way: i64| metric.edges[2 * edge_of(&roads, way) as usize].weight();
        let ways: Vec<i64> = streets().into_keys().collect();
        let mut memory = Memory::default();
        for (a, b) in trips.into_iter().filter(|(a, b)| a != b) {
            let (from, to) = (ways[a], ways[b]);
            let ends = [from, to].map(|way| middle_of(&roads, &metric, way));
            let leg = Leg::find(&roads, &metric, &ends[0], &ends[1], &mut memory);
            let found = leg.as_ref().map(|leg| leg.weight);
            let expected = oracle(&said, from, to, &weight);
            prop_assert_eq!(found, expected, "{} to {}, {:?}", from, to, said);
            if let Some(leg) = leg {
                let edges = 0..leg.edges.len();
                let sum: u32 = edges.map(|i| leg.measures(&roads, &metric, i).weight).sum();
                prop_assert_eq!(sum, leg.weight);
            }
        }
    }
}

/// The turn from one carriageway along the link to the other is forbidden. Whoever reaches the link
/// from elsewhere may turn there.
#[test]
fn a_turn_may_depend_on_the_roads_before() {
    // East along the south side, north along a link, west along the next row.
    let round = vec![1, 4, 9];
    assert!(round.iter().all(|way| streets().contains_key(way)));
    let free = roads(&[]);
    let kept = roads(&[(round, false)]);
    assert_eq!(
        (
            free.network.restrictions.len(),
            kept.network.restrictions.len()
        ),
        (0, 1)
    );
    assert_eq!(kept.network.report.odd_restrictions, 0);
    let turns = |roads: &Roads| Metric::new(roads, car()).unwrap().turns.unwrap();
    assert_eq!(turns(&kept).edge_of.len(), turns(&free).edge_of.len() + 1);
    assert_eq!(turns(&kept).odd_restrictions, 0);
}
