//! Maps that are made to be slow or large are refused, or less is made of them.

use openbench_osm::OsmData;
use openbench_routing::partition::CellSizes;
use openbench_routing::{Metric, Profile, Roads};

fn roads(xml: &str, sizes: &CellSizes) -> Roads {
    let data = OsmData::from_xml(format!("<osm version=\"0.6\">{xml}</osm>").as_bytes()).unwrap();
    Roads::read(&data, sizes).unwrap()
}

fn node(id: usize, x: usize, y: usize) -> String {
    format!(
        "<node id=\"{id}\" lat=\"{}\" lon=\"{}\"/>",
        y as f64 / 1e4,
        x as f64 / 1e4
    )
}

fn way(id: usize, nodes: &[usize], tags: &str) -> String {
    let nodes: String = nodes
        .iter()
        .map(|node| format!("<nd ref=\"{node}\"/>"))
        .collect();
    format!("<way id=\"{id}\">{nodes}{tags}</way>")
}

const STREET: &str = "<tag k=\"highway\" v=\"residential\"/>";

/// Three thousand roads from one place have nine million turns.
#[test]
fn junctions_of_thousands_of_roads_are_refused_where_turns_matter() {
    let star: String = (2..3002)
        .map(|i| node(i, i % 60 + 1, i / 60) + &way(i, &[1, i], STREET))
        .collect();
    let roads = roads(&(node(1, 0, 0) + &star), &CellSizes::default());
    assert!(Metric::new(&roads, Profile::named("foot").unwrap()).is_ok());
    let problem = Metric::new(&roads, Profile::named("car").unwrap()).unwrap_err();
    assert_eq!((problem.node, problem.roads), (1, 3000));
    let said = problem.to_string();
    assert!(
        said.contains("node 1") && said.contains("3000 roads"),
        "{said}"
    );
}

/// Roads from each place to arbitrary places: most of each cell is on its border.
#[test]
fn layers_that_need_too_much_memory_are_left_out() {
    let places = 12_000;
    let mut xml: String = (1..=places)
        .map(|i| node(i, i * 7919 % 9973, i * 104_729 % 9967))
        .collect();
    for a in 1..=places {
        xml += &way(a, &[a, a * 31 % places + 1], STREET);
        xml += &way(places + a, &[a, a * 173 % places + 1], STREET);
    }
    let levels = CellSizes::new(&[32, 6000, 11_000]).unwrap();
    let roads = roads(&xml, &levels);
    assert_eq!((roads.levels.len(), roads.vertices.layers.len()), (3, 1));
    let metric = Metric::new(&roads, Profile::named("foot").unwrap()).unwrap();
    assert_eq!(metric.searched(&roads).cliques.len(), 1);
}

/// A hundred thousand restrictions on one way, half of them with ways in between.
#[test]
fn many_restrictions_are_looked_up_quickly() {
    let places = 3000;
    let mut xml: String = (1..=places).map(|i| node(i, i % 60, i / 60)).collect();
    // One way through all places, and a second one back, so that each is a junction.
    let all: Vec<usize> = (1..=places).collect();
    let back: Vec<usize> = all.iter().rev().copied().collect();
    xml += &(way(1, &all, STREET) + &way(2, &back, STREET));
    let kind = "<tag k=\"type\" v=\"restriction\"/><tag k=\"restriction\" v=\"no_u_turn\"/>";
    for id in 0..100_000 {
        let via = match id % 2 {
            0 => format!(
                "<member type=\"node\" ref=\"{}\" role=\"via\"/>",
                id % places + 1
            ),
            _ => "<member type=\"way\" ref=\"3\" role=\"via\"/>".to_owned(),
        };
        xml += &format!(
            "<relation id=\"{id}\"><member type=\"way\" ref=\"1\" role=\"from\"/>{via}\
             <member type=\"way\" ref=\"2\" role=\"to\"/>{kind}</relation>"
        );
    }
    xml += &format!(
        "<relation id=\"100000\"><member type=\"way\" ref=\"1\" role=\"from\"/>\
         <member type=\"way\" ref=\"2\" role=\"via\"/>\
         <member type=\"way\" ref=\"1\" role=\"to\"/>{kind}</relation>"
    );
    let roads = roads(&xml, &CellSizes::default());
    assert_eq!(roads.network.restrictions.len(), 100_001);
    let metric = Metric::new(&roads, Profile::named("car").unwrap()).unwrap();
    // Way 3 does not exist, and way 2 has too many edges to be in between.
    assert_eq!(metric.turns.unwrap().odd_restrictions, 50_001);
}
