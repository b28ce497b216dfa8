//! Graph files: what was written is read again, and nothing else is accepted.

use openbench_osm::OsmData;
use openbench_routing::partition::CellSizes;
use openbench_routing::store::{is_graph_file, read, write};
use openbench_routing::{Metric, Profile, Roads};

/// A grid of streets with names, one with a gate on it, and a forbidden turn.
fn roads() -> Roads {
    let mut xml = "<osm version=\"0.6\">".to_owned();
    for i in 0..100 {
        let gate = if i == 42 {
            "<tag k=\"barrier\" v=\"gate\"/>"
        } else {
            ""
        };
        xml += &format!(
            "<node id=\"{}\" lat=\"{}\" lon=\"{}\">{gate}</node>",
            i + 1,
            f64::from(i / 10) / 1e3,
            f64::from(i % 10) / 1e3
        );
    }
    for way in 0..20 {
        let node = |i: i32| {
            if way < 10 {
                10 * way + i
            } else {
                10 * i + way - 10
            }
        };
        let nodes: String = (0..10)
            .map(|i| format!("<nd ref=\"{}\"/>", node(i) + 1))
            .collect();
        xml += &format!(
            "<way id=\"{way}\">{nodes}<tag k=\"highway\" v=\"residential\"/>\
             <tag k=\"name\" v=\"Street {}\"/></way>",
            way % 3
        );
    }
    xml += r#"<relation id="1"><member type="way" ref="1" role="from"/>
        <member type="node" ref="15" role="via"/><member type="way" ref="14" role="to"/>
        <tag k="type" v="restriction"/><tag k="restriction" v="no_left_turn"/></relation></osm>"#;
    let data = OsmData::from_xml(xml.as_bytes()).unwrap();
    Roads::read(&data, &CellSizes::new(&[8, 32]).unwrap()).unwrap()
}

#[test]
fn a_written_file_is_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let (file, roads) = (folder.path().join("town.graph"), roads());
    write(&roads, &file).unwrap();
    assert!(is_graph_file(&file));
    let again = read(&file).unwrap();
    assert_eq!(again.network.edges, roads.network.edges);
    assert_eq!(again.network.names, roads.network.names);
    assert_eq!(
        (again.levels.clone(), again.network.restrictions.len()),
        (roads.levels.clone(), 1)
    );
    for name in Profile::NAMES {
        let metric = |roads: &Roads| Metric::new(roads, Profile::named(name).unwrap()).unwrap();
        let (one, two) = (metric(&roads), metric(&again));
        assert_eq!(one.searched(&roads).cliques, two.searched(&again).cliques);
    }
}

#[test]
fn truncated_and_changed_files_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("town.graph");
    write(&roads(), &file).unwrap();
    let whole = std::fs::read(&file).unwrap();
    let problem = |bytes: &[u8]| {
        std::fs::write(&file, bytes).unwrap();
        read(&file).unwrap_err().to_string()
    };
    for length in [0, 7, 63, 200, whole.len() / 2, whole.len() - 1] {
        let said = problem(&whole[..length]);
        assert!(said.contains("truncated"), "{length}: {said}");
        assert!(
            said.contains("town.graph") && said.contains("openbench prepare"),
            "{said}"
        );
    }
    for at in (0..whole.len()).step_by(97) {
        let mut changed = whole.clone();
        changed[at] ^= 0x10;
        problem(&changed);
    }
    assert!(problem(&[b'x'; 1000]).contains("not a graph file"));
    let mut newer = whole.clone();
    newer[8] += 1;
    assert!(problem(&newer).contains("another version"));
    assert!(problem(&[whole.as_slice(), b"more"].concat()).contains("follows its end"));
}

/// Anyone who makes a file can make its checksum too.
#[test]
fn inconsistent_files_are_refused_or_harmless() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("town.graph");
    write(&roads(), &file).unwrap();
    let whole = std::fs::read(&file).unwrap();
    let mut refused = 0;
    for at in (64..whole.len()).step_by(61) {
        for bits in [0x80, 0x01] {
            let mut changed = whole.clone();
            changed[at] ^= bits;
            let sum = blake3::hash(&changed[64..]);
            changed[32..64].copy_from_slice(sum.as_bytes());
            std::fs::write(&file, &changed).unwrap();
            match read(&file) {
                Ok(roads) if at % 2 == 0 => {
                    drop(Metric::new(&roads, Profile::named("car").unwrap()))
                }
                Ok(_) => {}
                Err(_) => refused += 1,
            }
        }
    }
    assert!(refused > 50, "{refused} were refused");
}
