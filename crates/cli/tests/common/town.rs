//! Two houses, a door each, and the map of them: small enough to deliver in within a simulated
//! minute.

use super::{Place, Ran};

/// The start is (0, 0), facing east; the doors are in the middle of the walls that face it.
pub const DOORS: [(f64, f64); 2] = [(8.2, 0.0), (0.0, 12.2)];
const HOUSES: [(f64, f64); 2] = [(10.0, 0.0), (0.0, 14.0)];
const HALF: f64 = 1.8;

/// A reader that cannot be reached.
pub const NOBODY: &str = "openai:m@http://127.0.0.1:9/v1";

fn block(name: &str, (x, y): (f64, f64), (width, depth, height): (f64, f64, f64)) -> String {
    let shape = format!("<geometry><box><size>{width} {depth} {height}</size></box></geometry>");
    let z = height / 2.0;
    format!(
        "<model name='{name}'><static>1</static><pose>{x} {y} {z} 0 0 0</pose><link name='l'>\
         <visual name='v'>{shape}</visual><collision name='c'>{shape}</collision></link></model>\n"
    )
}

/// A world of ground, houses and plates, and of `more` elements.
pub fn world(more: &str) -> String {
    let ground = "<geometry><plane><normal>0 0 1</normal><size>100 100</size></plane></geometry>";
    let mut text = format!(
        "<sdf version='1.7'>\n<world name='town'>\n\
         <model name='ground_plane'><static>1</static><link name='l'>\
         <visual name='v'>{ground}</visual>\
         <collision name='c'>{ground}</collision></link></model>\n"
    );
    for (i, (house, (x, y))) in HOUSES.into_iter().zip(DOORS).enumerate() {
        let (unit, yaw) = (i + 1, if i == 0 { 90_f64 } else { 180.0 }.to_radians());
        text += &block(
            &format!("house_{unit}"),
            house,
            (2.0 * HALF, 2.0 * HALF, 3.0),
        );
        text += &format!(
            "<model name='text_model{unit}'><pose>{x} {y} 1.2 0 0 {yaw}</pose>\
             <link name='l'><visual name='v'><geometry><mesh>\
             <uri>model://text_model{unit}/meshes/fire2.dae</uri>\
             </mesh></geometry></visual></link></model>\n"
        );
    }
    text + more + "</world>\n</sdf>\n"
}

/// Walls around the start, without a gate.
pub fn prison() -> String {
    let walls = [
        ((1.2, 0.0), (0.2, 2.6, 1.0)),
        ((-1.2, 0.0), (0.2, 2.6, 1.0)),
        ((0.0, 1.2), (2.6, 0.2, 1.0)),
        ((0.0, -1.2), (2.6, 0.2, 1.0)),
    ];
    walls
        .iter()
        .enumerate()
        .map(|(i, (at, size))| block(&format!("wall_{i}"), *at, *size))
        .collect()
}

/// Its map, with a street past both houses.
pub fn map() -> String {
    let mut text = String::from("<?xml version='1.0'?>\n<osm version='0.6'>\n");
    let node = |id: usize, x: f64, y: f64| {
        format!(
            "<node id='{id}' lat='{:.8}' lon='{:.8}'/>\n",
            y / 110_574.3,
            3.0 + x / 111_319.5
        )
    };
    for (i, (x, y)) in HOUSES.into_iter().enumerate() {
        let first = 10 * (i + 1);
        for (k, (dx, dy)) in [(-HALF, -HALF), (HALF, -HALF), (HALF, HALF), (-HALF, HALF)]
            .into_iter()
            .enumerate()
        {
            text += &node(first + k, x + dx, y + dy);
        }
        let refs: String = [0, 1, 2, 3, 0]
            .iter()
            .map(|k| format!("<nd ref='{}'/>", first + k))
            .collect();
        let name = format!("building{}", i + 1);
        text += &format!(
            "<way id='{first}'>{refs}<tag k='building' v='yes'/><tag k='name' v='{name}'/></way>\n"
        );
    }
    text += &(node(1, 0.0, -20.0)
        + &node(2, 0.0, 0.0)
        + &node(3, 30.0, 0.0)
        + &node(4, 500.0, 500.0)
        + &node(5, 520.0, 500.0));
    text += "<way id='1'><nd ref='1'/><nd ref='2'/><nd ref='3'/>\
             <tag k='highway' v='residential'/><tag k='name' v='Long Lane'/></way>\n";
    text += "<way id='2'><nd ref='4'/><nd ref='5'/>\
             <tag k='highway' v='residential'/><tag k='name' v='Far Away'/></way>\n";
    text + "</osm>\n"
}

/// The files of the town: `town.world`, `town.osm`, and `one.txt`, which asks for one door.
pub fn town() -> Place {
    let place = Place::new();
    place
        .file("town.world", world(""))
        .file("town.osm", map())
        .file("one.txt", "Bring this parcel to unit1, building1.\n");
    place
}

/// Where the town lies.
pub const HERE: &str = "run --world town.world --map town.osm --georef tangent:3,0";

/// Delivers what `more` says in the town.
pub fn deliver(place: &Place, more: &str) -> Ran {
    place.openbench(&format!("{HERE} {more}"))
}
