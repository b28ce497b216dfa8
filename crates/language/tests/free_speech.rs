//! Free speech: all units of a building, senders, reversed orders, places taken back, stories
//! around an address.

mod support;

use openbench_core::TravelTimes;
use openbench_language::GrammarPlanner;
use openbench_osm::OsmMap;
use support::{Flat, Straight, compare, doors, numbered_with_units, plan};

fn map() -> OsmMap {
    numbered_with_units(12)
}

/// All drives take the same time, so that doors come in the order in which they are named.
#[track_caller]
fn check(cases: &[(&str, &str)]) {
    check_in_time(cases, &Flat);
}

#[track_caller]
fn check_in_time(cases: &[(&str, &str)], times: &dyn TravelTimes) {
    let map = map();
    compare(cases, |text| {
        match plan(&GrammarPlanner::new(), &map, times, text) {
            Ok(plan) => doors(&plan),
            Err(error) => error.to_string(),
        }
    });
}

const ALL_OF_3: &str = "building3/unit1 building3/unit2 building3/unit3 building3/unit4";

#[test]
fn all_units_are_those_of_the_map() {
    check(&[
        ("A flyer to all units of building 3", ALL_OF_3),
        (
            "Flyers for each of the four entrances of building 3",
            ALL_OF_3,
        ),
        ("3号楼每个单元各送一份", ALL_OF_3),
        ("3号楼四个单元都要送", ALL_OF_3),
        ("Un aviso a todas las unidades del edificio 3", ALL_OF_3),
        ("Un journal à chacune des entrées du bâtiment 3", ALL_OF_3),
        ("Gebäude 3, alle vier Eingänge", ALL_OF_3),
        ("3号棟の全室にチラシを入れてください", ALL_OF_3),
        // Of which the map has other than said.
        ("The two units of building 3 get one each", "building3"),
    ]);
}

#[test]
fn some_of_all_units_can_be_excepted() {
    check(&[
        (
            "All units of building 3 except unit 2",
            "building3/unit1 building3/unit3 building3/unit4",
        ),
        (
            "Everyone in building 3 apart from units 1 and 4",
            "building3/unit2 building3/unit3",
        ),
        (
            "3号楼除了2单元，其他单元都要送",
            "building3/unit1 building3/unit3 building3/unit4",
        ),
        (
            "Todas las unidades del edificio 3 menos la 2",
            "building3/unit1 building3/unit3 building3/unit4",
        ),
        (
            "Toutes les entrées du bâtiment 3 sauf la 2 et la 3",
            "building3/unit1 building3/unit4",
        ),
        (
            "3号棟は2号室以外の全室に",
            "building3/unit1 building3/unit3 building3/unit4",
        ),
    ]);
}

#[test]
fn senders_are_no_destinations() {
    check(&[
        (
            "Sender: building 2 unit 4, recipient: building 9 unit 3",
            "building9/unit3",
        ),
        (
            "From: J. Novak, building 2, unit 4. To: M. Reyes, building 9, unit 3.",
            "building9/unit3",
        ),
        (
            "寄件人：陈先生，7号楼2单元；收件人：1号楼1单元。",
            "building1/unit1",
        ),
        (
            "Remitente: edificio 1, unidad 1. Destinatario: edificio 11, unidad 3.",
            "building11/unit3",
        ),
        (
            "De la part de Julien, du bâtiment 6, entrée 1, pour le bâtiment 2, entrée 3",
            "building2/unit3",
        ),
        (
            "Absender: Gebäude 2, Eingang 3. Empfänger: Gebäude 9, Eingang 4.",
            "building9/unit4",
        ),
        (
            "7号棟3号室の山本さんから預かった荷物を、12号棟2号室に",
            "building12/unit2",
        ),
        (
            "Pick up the keys in building 2 and take them to building 5",
            "building5",
        ),
        (
            "去2号楼4单元老张家拿一下电钻，送到5号楼1单元",
            "building5/unit1",
        ),
        (
            "Bring den Tisch von Gebäude 3, Einheit 1 zu Gebäude 8, Einheit 2.",
            "building8/unit2",
        ),
        (
            "Lleva la caja de la unidad 2 del edificio 4 a la unidad 3 del edificio 6",
            "building6/unit3",
        ),
        // Where nothing else is named it is the place after all.
        ("Sender: building 2 unit 4", "building2/unit4"),
    ]);
}

#[test]
fn orders_can_be_reversed() {
    let cases = [
        (
            "Building 2 unit 1 and then building 6 unit 3. Actually, swap the order.",
            "building6/unit3 building2/unit1",
        ),
        (
            "Building 9. Before that, building 12.",
            "building12 building9",
        ),
        (
            "Building 9 and building 12 and building 10, in this order",
            "building9 building12 building10",
        ),
        (
            "Building 2 comes last; building 7 and building 9 before.",
            "building9 building7 building2",
        ),
        (
            "Building 9 unit 4 needs it first. Building 2 unit 1 afterwards.",
            "building9/unit4 building2/unit1",
        ),
        (
            "第一站9栋1单元，第二站2栋3单元，最后一站5栋2单元",
            "building9/unit1 building2/unit3 building5/unit2",
        ),
        (
            "Am eiligsten ist Gebäude 9; Gebäude 2 danach.",
            "building9 building2",
        ),
        (
            "6号棟1号室に荷物を届ける前に、9号棟4号室に行って",
            "building9/unit4 building6/unit1",
        ),
        ("7号棟→1号棟→11号棟", "building7 building1 building11"),
        (
            "Gebäude 9 bis 10 Uhr, Gebäude 2 erst bis 14 Uhr.",
            "building9 building2",
        ),
        (
            "El edificio 9 antes de las 10 y el edificio 2 antes de las 12",
            "building9 building2",
        ),
    ];
    check_in_time(&cases, &Straight);
}

#[test]
fn places_taken_back_are_no_destinations() {
    check(&[
        (
            "Units 2 and 4 of building 7, but unit 4 has just cancelled",
            "building7/unit2",
        ),
        (
            "Building 7, unit 2 and building 8, unit 1. Building 8, unit 1, has cancelled.",
            "building7/unit2",
        ),
        (
            "Gebäude 1, 6 und 11. Die 6 ist aber storniert.",
            "building1 building11",
        ),
        ("3号楼1单元和4单元，1单元刚刚退单了", "building3/unit4"),
        (
            "Building 6, no, wait, that was the old address, now building 8",
            "building8",
        ),
        ("Building 6 unit 1, sorry, 2", "building6/unit2"),
        (
            "Building 6 unit 1 was the plan, but go to building 8 unit 2 instead",
            "building8/unit2",
        ),
        (
            "el edificio 11 está bien, pero la unidad no es la 4, sino la 2",
            "building11/unit2",
        ),
        (
            "7号棟の2番入口、すみません、2番じゃなくて4番でした",
            "building7/unit4",
        ),
        // A condition is none.
        (
            "Building 6 unit 1 only after building 9 unit 2 has got theirs",
            "building9/unit2 building6/unit1",
        ),
    ]);
}

#[test]
fn addresses_are_shortened_and_misspelt() {
    check(&[
        ("pls drop @ bldg 12 u 4, call 555 0173", "building12/unit4"),
        ("Biulding sevn, untit 1 plese", "building7/unit1"),
        ("geb 4 eing 1 bite", "building4/unit1"),
        ("Edif. 12, ud. 4, 3 bultos", "building12/unit4"),
        ("Bât. 7, entr. 3, 2 sacs", "building7/unit3"),
        ("5号楼2单圆", "building5/unit2"),
        ("5ごうとう1ごうしつ", "building5/unit1"),
        (
            "Deliver to 4-1, 4-3 and 9-2",
            "building4/unit1 building4/unit3 building9/unit2",
        ),
        (
            "One for building 2, unit 3; another for 6, unit 1",
            "building2/unit3 building6/unit1",
        ),
        (
            "two bags, one to building 3, one to building 5, always unit 2",
            "building3/unit2 building5/unit2",
        ),
        (
            "Building 3 gets the box at unit 4, building 8 the big one at unit 1",
            "building3/unit4 building8/unit1",
        ),
        ("Building 3 unit 2, flat 1204", "building3/unit2"),
        ("Building 3, flat 1204", "building3"),
    ]);
}

#[test]
fn hints_and_landmarks_are_no_doors() {
    check(&[
        (
            "I am in building 8, unit 2 and I need my glasses.",
            "building8/unit2",
        ),
        (
            "The parcel goes to building 8, unit 2, first door on the left.",
            "building8/unit2",
        ),
        (
            "The gate at building 3 unit 2 is closed, ring the bell",
            "building3/unit2",
        ),
        (
            "The lift in building 6 is broken, but the parcel goes to building 5, unit 2.",
            "building5/unit2",
        ),
        (
            "Building 3 unit 1, sorry for the late notice, and building 4 unit 2",
            "building3/unit1 building4/unit2",
        ),
        (
            "Deliver all units of insulin to building 5 unit 2",
            "building5/unit2",
        ),
        (
            "Fahr zu Gebäude 8 und gib den Schlüssel bei Einheit 2 ab.",
            "building8/unit2",
        ),
        ("Haus 3 u. 4", "building3 building4"),
        (
            "Lleva el paquete al edificio 6, unidad 3, segunda puerta a la derecha.",
            "building6/unit3",
        ),
        (
            "Lleva esta carta al edificio 6, unidad 3, entre los edificios 5 y 7.",
            "building6/unit3",
        ),
        (
            "Apporte cette lettre au bâtiment 6, unité 3, entre 2 et 4 heures.",
            "building6/unit3",
        ),
        (
            "L'ascenseur du bâtiment 4 est en panne. Le colis va au bâtiment 6, unité 3.",
            "building6/unit3",
        ),
        ("请送到5号楼3单元,对面是6号楼。", "building5/unit3"),
        ("5号楼有4个单元,请送到3单元。", "building5/unit3"),
        (
            "5号楼3单元和4单元,8号楼1单元。",
            "building5/unit3 building5/unit4 building8/unit1",
        ),
        (
            "6号棟の向かいの5号棟3号室に届けてください。",
            "building5/unit3",
        ),
        ("地下鉄2号線の駅の近くの5号棟3号室に", "building5/unit3"),
    ]);
}

#[test]
fn an_unsure_sender_gets_one_delivery_with_a_problem() {
    let map = map();
    for text in [
        "It is for building 4 or building 5, I can't remember which",
        "是2号楼还是12号楼我记不清了",
        "Gebäude 4 oder Gebäude 5, so genau weiß ich das leider nicht",
    ] {
        let plan = plan(&GrammarPlanner::new(), &map, &Straight, text).unwrap();
        assert!(
            matches!(&plan.deliveries[..], [one] if one.problem.is_some()),
            "{text}: {plan:?}"
        );
    }
}

#[test]
fn the_number_of_stops_is_bounded() {
    let text = "all units of buildings 1 to 50; all units of buildings 51 to 60";
    let plan = plan(
        &GrammarPlanner::new(),
        &numbered_with_units(60),
        &Straight,
        text,
    )
    .unwrap();
    assert!(plan.deliveries.len() <= 210, "{}", plan.deliveries.len());
}
