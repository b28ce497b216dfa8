//! `openbench world`: worlds from an OSM map, from a Gazebo world, and what is done with their
//! folders.

mod common;

use common::Place;
use common::endpoint::{UNIT_1, babbler, reader_that_says};
use common::town::{NOBODY, deliver, town};

/// A street with houses: one named, one with street and number, one with nothing, and one that
/// crosses itself.
fn village() -> Place {
    let mut text = String::from("<osm version='0.6'>\n");
    let mut node = |id: usize, x: f64, y: f64, tags: &str| {
        text += &format!(
            "<node id='{id}' lat='{:.8}' lon='{:.8}'>{tags}</node>\n",
            y / 110_574.3 + 0.0,
            3.0 + x / 111_319.5
        );
    };
    for (first, x) in [(10, 0.0), (20, 18.0), (30, 36.0)] {
        for (k, (dx, dy)) in [(0.0, 6.0), (10.0, 6.0), (10.0, 14.0), (0.0, 14.0)]
            .into_iter()
            .enumerate()
        {
            node(first + k, x + dx, dy, "");
        }
    }
    for (k, (x, y)) in [(60.0, 6.0), (70.0, 14.0), (70.0, 6.0), (60.0, 14.1)]
        .into_iter()
        .enumerate()
    {
        node(40 + k, x, y, "");
    }
    node(
        50,
        4.0,
        6.0,
        "<tag k='entrance' v='yes'/><tag k='ref' v='7'/>",
    );
    node(1, -40.0, 0.0, "");
    node(2, 90.0, 0.0, "");
    let mut way = |id: usize, nodes: &[usize], tags: &[(&str, &str)]| {
        let nodes: String = nodes.iter().map(|n| format!("<nd ref='{n}'/>")).collect();
        let tags: String = tags
            .iter()
            .map(|(k, v)| format!("<tag k='{k}' v='{v}'/>"))
            .collect();
        text += &format!("<way id='{id}'>{nodes}{tags}</way>\n");
    };
    let house = ("building", "house");
    way(
        1,
        &[1, 2],
        &[("highway", "residential"), ("name", "Long Lane")],
    );
    way(
        10,
        &[10, 50, 11, 12, 13, 10],
        &[house, ("name", "Villa Rosa")],
    );
    way(
        20,
        &[20, 21, 22, 23, 20],
        &[
            house,
            ("addr:street", "Long Lane"),
            ("addr:housenumber", "3"),
        ],
    );
    way(30, &[30, 31, 32, 33, 30], &[house]);
    way(
        40,
        &[40, 41, 42, 43, 40],
        &[house, ("height", "1e999"), ("building:levels", "-3")],
    );
    let place = Place::new();
    place.file("village.osm", text + "</osm>\n");
    place
}

fn generated(more: &str) -> Place {
    let place = village();
    place
        .openbench(&format!("world generate --map village.osm --out w {more}"))
        .succeeded();
    place
}

#[test]
fn a_map_becomes_ground_as_the_map_server_reads_it() {
    let place = village();
    let said = place
        .openbench("costmap --map village.osm --out ground.yaml")
        .succeeded()
        .stdout
        .clone();
    assert!(
        said.contains("ground.yaml") && said.contains("cells of 0.10 m"),
        "{said}"
    );
    let yaml = place.read("ground.yaml");
    assert!(
        yaml.contains("image: ground.pgm") && yaml.contains("resolution: 0.1"),
        "{yaml}"
    );
    let pgm = std::fs::read(place.path("ground.pgm")).unwrap();
    assert!(pgm.starts_with(b"P5"));
    // Houses, the road and what nothing is known of.
    assert!([0, 254, 205].iter().all(|grey| pgm.contains(grey)));
    let part = "costmap --map village.osm --around 3.0002,0.0001 --radius 20 --out part.yaml";
    let said = place.openbench(part).succeeded().stdout.clone();
    assert!(said.contains("part.yaml: 40"), "{said}");
    place
        .openbench("costmap --map village.osm --out ground.pgm")
        .refused_with(&["ground.pgm", ".yaml"]);
    place
        .openbench("costmap --map nowhere.osm --out ground.yaml")
        .refused_with(&["nowhere.osm"]);
    place.file(
        "empty.osm",
        "<osm version='0.6'><node id='1' lat='0' lon='3'/></osm>",
    );
    place
        .openbench("costmap --map empty.osm --out ground.yaml")
        .refused_with(&["empty.osm", "no building"]);
}

#[test]
fn a_map_becomes_a_folder_with_recipe_maps_and_suite() {
    let place = generated("--seed 5");
    let recipe = place.read("w/world.toml");
    assert!(
        recipe.contains("kind = \"generated\"") && recipe.contains("seed = 5"),
        "{recipe}"
    );
    assert!(place.read("w/map.osm").contains("entrance"));
    let public = place.read("w/public.osm");
    assert!(
        !public.contains("entrance") && public.contains("Villa Rosa"),
        "{public}"
    );
    let left: Vec<_> = std::fs::read_dir(place.path(""))
        .unwrap()
        .map(|e| e.unwrap().file_name())
        .collect();
    assert_eq!(left.len(), 2, "nothing is left beside the folder: {left:?}");
}

#[test]
fn instructions_and_public_map_agree_on_addresses() {
    let place = generated("--draw 3 0 1");
    let suite = place.read("w/suite.toml");
    assert!(
        suite.contains("unit7") && suite.contains("Villa Rosa"),
        "{suite}"
    );
    assert!(suite.contains("Long Lane 3"), "{suite}");
    let public = place.read("w/public.osm");
    // The house without a name got a number of its own in its street.
    assert_eq!(
        public.matches("addr:housenumber").count(),
        public.matches("Long Lane").count() - 1,
        "{public}"
    );
    for instruction in suite
        .lines()
        .filter_map(|l| l.strip_prefix("instruction = "))
    {
        let words = instruction.trim_matches('"');
        let planned = place.openbench_with(&["plan", "--map", "w/public.osm", words]);
        let delivery = &planned.succeeded().json()["deliveries"][0];
        let name = delivery["building"].as_str().unwrap().to_owned();
        assert!(words.contains(&name), "{words}: {delivery}");
    }
}

#[test]
fn the_same_seed_gives_the_same_folder() {
    let (a, b) = (generated("--seed 4"), generated("--seed 4"));
    for file in ["world.toml", "map.osm", "public.osm", "suite.toml"] {
        assert_eq!(
            a.read(&format!("w/{file}")),
            b.read(&format!("w/{file}")),
            "{file}"
        );
    }
}

#[test]
fn a_run_in_a_world_verifies_and_moves_with_its_folder() {
    let place = generated("--draw 1 0 1");
    std::fs::rename(place.path("w"), place.path("moved")).unwrap();
    let reader = reader_that_says(UNIT_1);
    let words = format!("run moved --out run --record none --set reader={reader}");
    place.openbench(&words).succeeded();
    assert_eq!(place.json("run/results.json")["suite"], "w");
    assert!(
        place
            .openbench("verify run")
            .succeeded()
            .stdout
            .contains("1 episode: files and actions agree")
    );
}

#[test]
fn a_world_is_shown() {
    let place = generated("");
    place.openbench("world show w --out above.png").succeeded();
    place
        .openbench("world show w --from 0,0,90 --out street.png")
        .succeeded();
    for file in ["above.png", "street.png"] {
        assert!(
            std::fs::read(place.path(file))
                .unwrap()
                .starts_with(b"\x89PNG"),
            "{file}"
        );
    }
}

#[test]
fn depth_classes_and_instances_lie_beside_the_picture_with_their_legends() {
    let place = generated("");
    let words = "world show w --from 5,0,90 --out view.jpg --quality 70 --no-shadows --depth \
    d.png --classes c.png --instances i.png";
    place.openbench(words).succeeded();
    assert!(
        std::fs::read(place.path("view.jpg"))
            .unwrap()
            .starts_with(b"\xff\xd8\xff")
    );
    // Width, height and depth of the pixels stand at the beginning of a PNG.
    let depth = std::fs::read(place.path("d.png")).unwrap();
    assert_eq!(
        &depth[16..26],
        b"\0\0\x05\0\0\0\x03\xc0\x10\0",
        "1280 x 960, 16 bits, grey"
    );
    let names = |file: &str, list: &str| -> Vec<String> {
        let legend = place.json(file)[list].as_array().unwrap().clone();
        assert_eq!(
            legend
                .iter()
                .map(|e| e["pixels"].as_u64().unwrap())
                .sum::<u64>(),
            1280 * 960
        );
        legend
            .iter()
            .map(|e| e["name"].as_str().unwrap().to_owned())
            .collect()
    };
    let classes = names("c.json", "classes");
    assert!(
        ["sky", "grass", "road", "building", "door", "plate"]
            .iter()
            .all(|c| classes.iter().any(|n| n == c)),
        "{classes:?}"
    );
    let things = names("i.json", "instances");
    let legend = place.json("i.json");
    let numbers: Vec<_> = legend["instances"]
        .as_array()
        .unwrap()
        .iter()
        .map(|e| e["number"].as_u64())
        .collect();
    assert!(
        numbers.windows(2).all(|pair| pair[0] < pair[1]),
        "one entry a thing: {numbers:?}"
    );
    assert!(
        ["Villa Rosa", "Long Lane"]
            .iter()
            .all(|c| things.iter().any(|n| n == c)),
        "{things:?}"
    );
    place
        .openbench("world show w --quality 0")
        .refused_with(&["quality"]);
}

#[test]
fn an_earlier_world_is_replaced_and_nothing_else() {
    let place = generated("--seed 1");
    place
        .openbench("world generate --map village.osm --seed 2 --out w")
        .succeeded();
    assert!(place.read("w/world.toml").contains("seed = 2"));
    place.file("w/notes.txt", "mine");
    place
        .openbench("world generate --map village.osm --out w")
        .refused_with(&["w", "do not belong to a world"]);
    assert!(place.read("w/world.toml").contains("seed = 2"));
    place
        .openbench("world generate --map village.osm --out village.osm")
        .refused_with(&["village.osm", "file"]);
    // Files that only have the names of ours.
    std::fs::create_dir(place.path("mine")).unwrap();
    for name in ["map.osm", "suite.toml"] {
        place.file(&format!("mine/{name}"), "mine");
        place
            .openbench("world generate --map village.osm --out mine")
            .refused_with(&["mine", "do not belong to a world"]);
        assert_eq!(place.read(&format!("mine/{name}")), "mine");
        std::fs::remove_file(place.path(&format!("mine/{name}"))).unwrap();
    }
    place
        .openbench("world generate --map village.osm --out mine")
        .succeeded();
}

#[test]
fn a_gazebo_world_becomes_such_a_folder() {
    let place = town();
    let words =
        "world import --world town.world --map town.osm --georef tangent:3,0 --draw 1 0 1 --out w";
    place.openbench(words).succeeded();
    let recipe = place.read("w/world.toml");
    let world = place.path("town.world");
    assert!(
        recipe.contains("kind = \"imported\"") && recipe.contains(&*world.to_string_lossy()),
        "{recipe}"
    );
    let ran = place.openbench(&format!(
        "run w --out run --record none --set reader={}",
        babbler()
    ));
    ran.succeeded();
}

#[test]
fn a_part_of_a_map_is_cut_out() {
    let place = generated("--around 3.00005,0.00009 --radius 12 --draw 1 0 1");
    assert!(place.read("w/map.osm").contains("Villa Rosa"));
    assert!(
        !place.read("w/map.osm").contains("way id=\"40\""),
        "the last house is outside"
    );
    let words = "world generate --map village.osm --bbox 50,50,51,51 --out none";
    place
        .openbench(words)
        .refused_with(&["village.osm", "50,50,51,51"]);
    let words = "world generate --map village.osm --bbox 3,1,2,0 --out none";
    place
        .openbench(words)
        .refused_with(&["3,1,2,0", "west of east"]);
}

#[test]
fn maps_that_make_no_world_are_refused() {
    let place = village();
    let refused = |map: &str, more: &str, parts: &[&str]| {
        place
            .openbench(&format!("world generate --map {map} --out none {more}"))
            .refused_with(parts);
        assert!(!place.path("none").exists());
    };
    place.file(
        "road.osm",
        "<osm><node id='1' lat='0' lon='3'/><node id='2' lat='0' lon='3.001'/></osm>",
    );
    refused("road.osm", "", &["road.osm", "no usable building"]);
    place.file("cut.osm", "<osm><node id='1'");
    refused("cut.osm", "", &["cut.osm"]);
    refused("missing.osm", "", &["missing.osm", "No such file"]);
    refused(
        "village.osm",
        "--georef utm:41S,0,0",
        &["village.osm", "utm:41S", "keeps lengths"],
    );
    refused("village.osm", "--parked-cars 2", &["0 to 1"]);
    refused("village.osm", "--radius 5", &["--around"]);
    refused(
        "village.osm",
        "--reach 1",
        &["no door can be delivered to", "--reach"],
    );
}

#[test]
fn what_is_left_out_of_a_world_is_said_when_it_is_made_and_when_it_is_run() {
    let place = village();
    let flat = "<way id='60'><nd ref='10'/><nd ref='11'/><nd ref='10'/><tag k='building' \
    v='yes'/></way>\
        <way id='61'><nd ref='1'/><nd ref='2'/><nd ref='1'/><nd ref='2'/><nd ref='1'/><tag \
        k='building:part' v='yes'/></way>\
        <node id='99' lat='95' lon='3'/></osm>";
    place.file(
        "village.osm",
        place.read("village.osm").replace("</osm>", flat),
    );
    let made = place.openbench("world generate --map village.osm --out w --draw 1 0 1");
    let said = &made.succeeded().stderr;
    assert!(
        said.contains("1 buildings without a closed outline"),
        "{said}"
    );
    assert!(said.contains("village.osm: 1 element"), "{said}");
    let ran = place.openbench(&format!("run w --set reader={}", babbler()));
    let said = &ran.succeeded().stderr;
    assert!(
        said.contains("1 buildings without a closed outline"),
        "{said}"
    );
}

#[test]
fn folders_that_are_no_worlds_are_refused() {
    let place = generated("");
    std::fs::create_dir(place.path("empty")).unwrap();
    place
        .openbench("run empty")
        .refused_with(&["empty", "world.toml"]);
    let recipe = place.read("w/world.toml");
    place.file("w/world.toml", recipe.replace("kind", "sort"));
    place
        .openbench("run w")
        .refused_with(&["world.toml", "kind"]);
    place.file(
        "w/world.toml",
        recipe.replace("version = \"", "version = \"9"),
    );
    let ran = place.openbench("world show w");
    assert!(
        ran.succeeded().stderr.contains("written by version 9"),
        "{}",
        ran.stderr
    );
}

/// The village with three doors in its map.
fn village_with_doors() -> Place {
    let place = village();
    let mut text = place.read("village.osm");
    for (id, first, x) in [(51, 20, 22.0), (52, 30, 40.0)] {
        let (lat, lon) = (6.0 / 110_574.3, 3.0 + x / 111_319.5);
        let door = format!(
            "<node id='{id}' lat='{lat:.8}' lon='{lon:.8}'><tag k='entrance' v='yes'/>\
             <tag k='ref' v='{id}'/></node>\n"
        );
        text = text.replacen("<node", &(door + "<node"), 1);
        let wall = format!("<nd ref='{first}'/>");
        text = text.replacen(&wall, &format!("{wall}<nd ref='{id}'/>"), 1);
    }
    place.file("village.osm", text);
    place
}

#[test]
fn the_public_map_does_not_tell_whether_there_were_doors() {
    let public = |place: &Place| {
        place
            .openbench("world generate --map village.osm --out w")
            .succeeded();
        place.read("w/public.osm")
    };
    assert_eq!(public(&village()), public(&village_with_doors()));
}

#[test]
fn the_map_of_a_world_is_no_memory_of_a_run() {
    let place = village_with_doors();
    place
        .openbench("world generate --map village.osm --out w")
        .succeeded();
    place.file("copy.osm", place.read("w/map.osm"));
    for own in ["village.osm", "copy.osm"] {
        let words = format!("run w --set reader={NOBODY} --memory {own}");
        place
            .openbench(&words)
            .refused_with(&[own, "the map that the world is made from"]);
    }
    assert!(!place.path("runs").exists());
    // The public map has no doors, so it tells nothing.
    place.file("public.osm", place.read("w/public.osm"));
    let words = "run w --agent random --record none --memory public.osm --out run";
    place.openbench(words).succeeded();
    assert_eq!(place.json("run/results.json")["memory"]["doors"], 0);
}

#[test]
fn a_map_that_no_run_has_written_is_not_replaced_by_a_memory() {
    let place = generated("");
    let public = place.read("w/public.osm");
    let mine = public.replacen("<way", "<node id='77' lat='0' lon='0'/><way", 1);
    place.file("mine.osm", &mine);
    place
        .openbench("run w --agent random --record none --out out --memory mine.osm")
        .refused_with(&[
            "mine.osm",
            "no memory of this world: 1 of its elements",
            "name a new one",
        ]);
    assert_eq!(place.read("mine.osm"), mine);
}

#[test]
fn a_memory_replaces_nothing_that_the_run_reads_or_writes() {
    let place = generated("");
    std::fs::create_dir(place.path("out")).unwrap();
    let run = "run w --agent random --record none --out out --memory";
    for input in ["w/map.osm", "w/public.osm", "w/new.osm", "out/results.json"] {
        place
            .openbench(&format!("{run} {input}"))
            .refused_with(&[input, "would be replaced"]);
    }
    let town = town();
    let before = town.read("town.osm");
    let words =
        format!("--deliveries one.txt --targets planner --memory town.osm --set reader={NOBODY}");
    deliver(&town, &words).refused_with(&["town.osm", "would be replaced"]);
    assert_eq!(town.read("town.osm"), before);
}
