//! Addresses of more levels than building and unit: towns and quarters, streets, floors, flats.

mod support;

use openbench_core::{Georeference, Level, LonLat, Plan, PlannedDelivery, StepMode};
use openbench_language::GrammarPlanner;
use openbench_osm::{OsmData, OsmMap};
use support::{Flat, map, numbered, plan};

fn understood(map: &OsmMap, text: &str) -> PlannedDelivery {
    let Plan { deliveries, .. } = plan(&GrammarPlanner::new(), map, &Flat, text).unwrap();
    let [delivery] = &deliveries[..] else {
        panic!("{text}: {deliveries:?}")
    };
    delivery.clone()
}

fn levels(delivery: &PlannedDelivery) -> String {
    delivery
        .levels
        .iter()
        .map(|level| level.name.as_str())
        .collect::<Vec<_>>()
        .join(" ")
}

fn steps(delivery: &PlannedDelivery) -> String {
    let word = |mode| {
        if mode == StepMode::Navigate {
            "navigate"
        } else {
            "explore"
        }
    };
    let steps = delivery
        .steps
        .iter()
        .map(|step| format!("{} {}", word(step.mode), step.target));
    steps.collect::<Vec<_>>().join(", ")
}

#[test]
fn floors_and_flats_are_behind_the_unit() {
    let map = numbered(9);
    for text in [
        "Parcel to entrance 2 of building 3, 4th floor, flat 12",
        "Parcel to building 3, entrance 2, floor 4, apartment 12, please",
        "把包裹送到3号楼2单元4层12室",
        "Paket zu Gebäude 3, Eingang 2, 4. Stock, Wohnung 12",
        "Lleva el paquete al edificio 3, entrada 2, planta 4, apartamento 12",
        "Colis pour le bâtiment 3, entrée 2, 4e étage, appartement 12",
        "3号棟の入口2、4階の12号室に荷物を届けてください",
        "Parcel to building 3, entrance 2 (floor 4, flat 12)",
        "Parcel to building 3, entrance 2: floor 4, flat 12",
        "Parcel to entrance 2 of building 3, 3rd floor, no, 4th floor, flat 12",
    ] {
        let delivery = understood(&map, text);
        assert_eq!(delivery.unit.as_deref(), Some("unit2"), "{text}");
        assert_eq!(levels(&delivery), "floor4 flat12", "{text}");
        assert_eq!(
            steps(&delivery),
            "navigate building3, explore unit2, explore floor4, explore flat12",
            "{text}"
        );
    }
}

#[test]
fn a_flat_without_an_entrance_is_the_unit() {
    let delivery = understood(
        &numbered(9),
        "Parcel to building 3, flat 12, on the third floor",
    );
    assert_eq!(
        (delivery.unit.as_deref(), levels(&delivery).as_str()),
        (Some("unit12"), "floor3")
    );
}

#[test]
fn floors_belong_to_the_nearest_door() {
    let text = "A box to unit 1 of building 3, 2nd floor, \
                and a letter to unit 2 of building 5, 7th floor.";
    let Plan { deliveries, .. } = plan(&GrammarPlanner::new(), &numbered(9), &Flat, text).unwrap();
    let of = |building: &str| levels(deliveries.iter().find(|d| d.building == building).unwrap());
    assert_eq!(
        (of("building3").as_str(), of("building5").as_str()),
        ("floor2", "floor7")
    );
}

/// Two estates with a building 3 each.
fn estates() -> OsmMap {
    let house = |name, estate| {
        [
            ("name", name),
            ("addr:suburb", estate),
            ("addr:city", "Rivertown"),
        ]
    };
    let houses = [
        house("building3", "Rose Estate"),
        house("building3", "百合园"),
        house("building4", "Rose Estate"),
        house("building4", "百合园"),
    ];
    let all: Vec<&[(&str, &str)]> = houses.iter().map(|tags| &tags[..]).collect();
    map(&all, &[])
}

#[test]
fn the_quarter_disambiguates_buildings_of_one_name() {
    for (text, building, level) in [
        (
            "The box to unit 1, building 3 in Rose Estate",
            "building3, Rose Estate",
            "Rose Estate",
        ),
        (
            "Rose Estate, building 4, unit 1: a letter",
            "building4, Rose Estate",
            "Rose Estate",
        ),
        ("请送到百合园3号楼1单元", "building3, 百合园", "百合园"),
    ] {
        let delivery = understood(&estates(), text);
        assert_eq!(
            (delivery.building.as_str(), &delivery.problem),
            (building, &None),
            "{text}"
        );
        assert_eq!(
            (levels(&delivery).as_str(), delivery.confidence),
            (level, 1.0),
            "{text}"
        );
        assert_eq!(delivery.levels[0].level, Level::District);
        assert_eq!(
            steps(&delivery),
            format!("navigate {building}, explore unit1"),
            "{text}"
        );
    }
    let both = understood(
        &estates(),
        "The box to unit 1, building 3, Rose Estate, Rivertown",
    );
    assert_eq!(
        (both.building.as_str(), both.problem),
        ("building3, Rose Estate", None)
    );
    for unclear in [
        "The box to unit 1, building 3",
        "The box to unit 1, building 3, Rivertown",
        "The box to unit 1, building 3, not the one in Rose Estate",
        "The primrose estates' box to unit 1, building 3",
    ] {
        assert!(
            understood(&estates(), unclear).problem.is_some(),
            "{unclear}"
        );
    }
}

/// A town has several shops of a chain; an address belongs to one of them.
#[test]
fn an_address_disambiguates_buildings_of_one_name() {
    let shop = |street, number| {
        [
            ("name", "Speedy"),
            ("addr:street", street),
            ("addr:housenumber", number),
        ]
    };
    let shops = [shop("Rua Alta", "17"), shop("Rua Baixa", "4")];
    let map = map(&[&shops[0], &shops[1], &[("name", "Speedy")]], &[]);
    let delivery = understood(&map, "The box to unit 1 of Rua Alta 17");
    assert_eq!(
        (delivery.building.as_str(), &delivery.problem),
        ("Rua Alta 17", &None)
    );
    assert_eq!(steps(&delivery), "navigate Rua Alta 17, explore unit1");
    let problem = understood(&map, "The box to unit 1 of Speedy")
        .problem
        .unwrap();
    assert!(
        problem.contains("Rua Alta 17, Rua Baixa 4, Speedy"),
        "{problem}"
    );
}

/// `Ost` is in `Post`, and 12 in a telephone number.
#[test]
fn quarters_match_whole_words_but_no_numbers() {
    let houses = [
        [("name", "building3"), ("addr:suburb", "Ost")],
        [("name", "building3"), ("addr:block", "12")],
    ];
    let map = map(&[&houses[0], &houses[1]], &[]);
    for unclear in ["Die Post zu Gebäude 3", "12 letters to building 3, call 12"] {
        assert!(understood(&map, unclear).problem.is_some(), "{unclear}");
    }
    assert_eq!(
        understood(&map, "Die Post zu Gebäude 3 in Ost").building,
        "building3, Ost"
    );
}

#[test]
fn a_quarter_applies_to_its_door_or_to_all_doors() {
    let doors = |text: &str| {
        let Plan { deliveries, .. } =
            plan(&GrammarPlanner::new(), &estates(), &Flat, text).unwrap();
        let mut names: Vec<String> = deliveries.iter().map(|d| d.building.clone()).collect();
        names.sort();
        names.join("; ")
    };
    let both = doors("A box to building 3 in Rose Estate and a letter to building 4 in 百合园.");
    assert_eq!(both, "building3, Rose Estate; building4, 百合园");
    let unknown =
        doors("A box to building 3 in Rose Estate and a letter to building 4 in Lily Esate.");
    assert_eq!(
        unknown, "building3, Rose Estate; building4",
        "nobody says that it is the same quarter"
    );
    let one = doors("In Rose Estate: a box to building 3 and a letter to building 4.");
    assert_eq!(one, "building3, Rose Estate; building4, Rose Estate");
}

#[test]
fn a_building_missing_on_the_map_is_explored_for_in_its_street() {
    let xml = r#"<osm version="0.6">
        <node id="1" lat="0" lon="0"/><node id="2" lat="0" lon="1e-3"/>
        <way id="1"><nd ref="1"/><nd ref="2"/>
            <tag k="highway" v="residential"/><tag k="name" v="Oak Street"/></way>
        </osm>"#;
    let data = OsmData::from_xml(xml.as_bytes()).unwrap();
    let map = OsmMap::new(&data, Georeference::tangent_plane(LonLat::new(0.0, 0.0)));
    let delivery = understood(&map, "The box to unit 1, building 7, Oak Street");
    assert!(delivery.problem.is_some());
    assert_eq!(
        (levels(&delivery).as_str(), delivery.levels[0].level),
        ("Oak Street", Level::Street)
    );
    assert_eq!(
        steps(&delivery),
        "navigate Oak Street, explore building7, explore unit1"
    );
    let nowhere = understood(&map, "The box to unit 1, building 7");
    assert_eq!(steps(&nowhere), "explore building7, explore unit1");
}
