//! No input may crash the readers: whatever the bytes, the result is a map or an error message.

use openbench_core::{Georeference, LonLat};
use openbench_osm::{
    ElementKind, Member, Node, OsmData, OsmMap, Relation, Tags, Way, without_doors,
};
use proptest::prelude::*;

const COURT: &[u8] = include_bytes!("fixtures/court.osm");

/// Reads, builds the map, edits and writes. None of it may panic.
fn read_without_panic(bytes: &[u8]) {
    if let Ok(data) = OsmData::from_bytes(bytes) {
        let map = OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(0.0, 0.0)));
        map.nearest_building(map.projection.to_map(LonLat::new(0.0, 0.0)));
        without_doors(&data).to_xml();
    }
}

#[test]
fn every_truncation_of_a_map_is_an_error() {
    let end = COURT.windows(6).rposition(|w| w == b"</osm>").unwrap() + 6;
    for length in 0..end {
        let error = OsmData::from_bytes(&COURT[..length])
            .expect_err("a cut map was read")
            .to_string();
        assert!(
            error.starts_with("line ") || error.starts_with("byte "),
            "{error}"
        );
    }
}

#[test]
fn a_missing_file_is_named() {
    let error = OsmData::read("no/such.osm".as_ref())
        .unwrap_err()
        .to_string();
    assert!(error.contains("no/such.osm"), "{error}");
}

#[test]
fn a_bad_file_is_named_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.osm.pbf");
    std::fs::write(&path, "<osm>\n<node").unwrap();
    let error = OsmData::read(&path).unwrap_err().to_string();
    assert!(error.contains("cut.osm.pbf: line 2: "), "{error}");
}

/// 2,000 relations that all reference one way of 20,000 nodes, and 20,000 stretches of a road with
/// a long name: 1 MB of text must not become gigabytes of map.
#[test]
fn a_small_file_does_not_make_a_huge_map() {
    let mut text = String::from("<osm>");
    for i in 0..20_000 {
        let turn = f64::from(i) / 20_000.0 * std::f64::consts::TAU;
        text += &format!(
            "<node id='{i}' lat='{}' lon='{}'/>",
            libm::sin(turn),
            libm::cos(turn)
        );
    }
    let references: String = (0..20_000)
        .chain([0])
        .map(|i| format!("<nd ref='{i}'/>"))
        .collect();
    text += &format!("<way id='1'>{references}</way>");
    let gaps: String = (0..20_000)
        .map(|i| format!("<nd ref='{i}'/>{}", ["", "<nd ref='-1'/>"][i % 2]))
        .collect();
    text += &format!(
        "<way id='2'>{gaps}<tag k='highway' v='path'/><tag k='name' v='{}'/></way>",
        "x".repeat(50_000)
    );
    for i in 0..2_000 {
        let tags = "<tag k='type' v='multipolygon'/><tag k='building' v='yes'/>";
        text += &format!(
            "<relation id='{i}'><member type='way' ref='1' role='outer'/>{tags}</relation>"
        );
    }
    let data = OsmData::from_xml((text + "</osm>").as_bytes()).unwrap();
    let map = OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(0.0, 0.0)));
    let points: usize = map.buildings.iter().map(|b| b.polygon.outer.len()).sum();
    let words: usize = map
        .roads
        .iter()
        .map(|r| r.tags.get("name").map_or(0, str::len))
        .sum();
    assert!(
        points < 3_000_000 && words < 60_000_000,
        "{points} points, {words} letters"
    );
    assert!(map.buildings.len() > 10 && map.report.broken_buildings > 1_000);
}

/// A field of a protobuf message: its tag, its length, its bytes.
fn field(tag: u8, bytes: &[u8]) -> Vec<u8> {
    let length = [bytes.len() as u8 | 0x80, (bytes.len() >> 7) as u8];
    [&[tag], length.as_slice(), bytes].concat()
}

/// A block with the strings "", "building" and "yes". Its elements are the nodes 1 (with a tag) and
/// 2, a way through both, and a relation with the way as member.
fn pbf_block() -> Vec<u8> {
    let strings = [
        field(0x0A, b""),
        field(0x0A, b"building"),
        field(0x0A, b"yes"),
    ]
    .concat();
    let (positions, tags) = (
        [field(0x42, &[20, 2]), field(0x4A, &[40, 2])].concat(),
        field(0x52, &[1, 2, 0, 0]),
    );
    let nodes = field(0x12, &[field(0x0A, &[2, 2]), positions, tags].concat());
    let tags = [field(0x12, &[1]), field(0x1A, &[2])].concat();
    let way = field(
        0x1A,
        &[&[0x08, 7], tags.as_slice(), &field(0x42, &[2, 2])].concat(),
    );
    let members = [field(0x42, &[2]), field(0x4A, &[14]), field(0x52, &[1])].concat();
    let relation = field(0x22, &[&[0x08, 9], tags.as_slice(), &members].concat());
    [
        field(0x0A, &strings),
        field(0x12, &nodes),
        field(0x12, &way),
        field(0x12, &relation),
    ]
    .concat()
}

/// A file of that one block, uncompressed.
fn pbf_file(block: &[u8]) -> Vec<u8> {
    let blob = field(0x0A, block);
    let size = [0x18, blob.len() as u8 | 0x80, (blob.len() >> 7) as u8];
    let header = [field(0x0A, b"OSMData"), size.to_vec()].concat();
    [
        &(header.len() as u32).to_be_bytes(),
        header.as_slice(),
        &blob,
    ]
    .concat()
}

#[test]
fn a_pbf_block_is_read() {
    let data = OsmData::from_bytes(&pbf_file(&pbf_block())).unwrap();
    assert_eq!(data.nodes[&1].position, LonLat::new(20.0 / 1e7, 10.0 / 1e7));
    assert_eq!(data.nodes[&1].tags, Tags::from([("building", "yes")]));
    assert_eq!((data.nodes.len(), &data.ways[&7].nodes), (2, &vec![1, 2]));
    let member = Member {
        kind: ElementKind::Way,
        id: 7,
        role: "yes".into(),
    };
    assert_eq!(data.relations[&9].members, [member]);
}

#[test]
fn a_member_of_unknown_type_is_an_error() {
    let mut block = pbf_block();
    *block.last_mut().unwrap() = 5;
    let error = OsmData::from_bytes(&pbf_file(&block))
        .unwrap_err()
        .to_string();
    assert_eq!(error, "byte 0: a member of unknown type");
}

fn text() -> impl Strategy<Value = String> {
    "[ -~\t\n\r<&\"'äß号é💡]{0,8}"
}

fn tags() -> impl Strategy<Value = Tags> {
    let key = prop_oneof![
        Just("building".to_owned()),
        Just("entrance".to_owned()),
        text()
    ];
    prop::collection::vec((key, text()), 0..4).prop_map(|pairs| pairs.into_iter().collect())
}

fn node() -> impl Strategy<Value = Node> {
    let position = (
        -1_800_000_000i64..=1_800_000_000,
        -900_000_000i64..=900_000_000,
    );
    (-9i64..9, position, tags()).prop_map(|(id, (lon, lat), tags)| Node {
        id,
        position: LonLat::new(lon as f64 / 1e7, lat as f64 / 1e7),
        tags,
    })
}

fn way() -> impl Strategy<Value = Way> {
    (-9i64..9, prop::collection::vec(-9i64..9, 0..8), tags()).prop_map(|(id, nodes, tags)| Way {
        id,
        nodes,
        tags,
    })
}

fn relation() -> impl Strategy<Value = Relation> {
    let kind = prop::sample::select(vec![
        ElementKind::Node,
        ElementKind::Way,
        ElementKind::Relation,
    ]);
    let member = (kind, -9i64..9, text()).prop_map(|(kind, id, role)| Member { kind, id, role });
    (-9i64..9, prop::collection::vec(member, 0..6), tags()).prop_map(|(id, members, mut tags)| {
        tags.insert("type", "multipolygon");
        Relation { id, members, tags }
    })
}

fn data() -> impl Strategy<Value = OsmData> {
    let all = (
        prop::collection::vec(node(), 0..12),
        prop::collection::vec(way(), 0..6),
        prop::collection::vec(relation(), 0..4),
    );
    all.prop_map(|(nodes, ways, relations)| OsmData {
        nodes: nodes.into_iter().map(|n| (n.id, n)).collect(),
        ways: ways.into_iter().map(|w| (w.id, w)).collect(),
        relations: relations.into_iter().map(|r| (r.id, r)).collect(),
        ..OsmData::default()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn what_is_written_is_read_back(data in data()) {
        let back = OsmData::from_xml(&data.to_xml()).unwrap();
        prop_assert_eq!(&back.nodes, &data.nodes);
        prop_assert_eq!(&back.ways, &data.ways);
        prop_assert_eq!(&back.relations, &data.relations);
        read_without_panic(&data.to_xml());
    }

    #[test]
    fn random_bytes_do_not_panic(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        read_without_panic(&bytes);
    }

    /// The frame stays valid, so that the damage reaches the decoder.
    #[test]
    fn a_damaged_pbf_block_does_not_panic(
        changes in prop::collection::vec((0usize..1000, any::<u8>()), 1..4),
    ) {
        let mut block = pbf_block();
        for (place, byte) in changes {
            let place = place % block.len();
            block[place] = byte;
        }
        read_without_panic(&pbf_file(&block));
    }

    #[test]
    fn a_map_with_some_bytes_changed_does_not_panic(
        changes in prop::collection::vec((0..COURT.len(), any::<u8>()), 1..20),
    ) {
        let mut bytes = COURT.to_vec();
        for (place, byte) in changes {
            bytes[place] = byte;
        }
        read_without_panic(&bytes);
    }
}
