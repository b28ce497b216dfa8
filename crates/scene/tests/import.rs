//! Import of small worlds that are written out here.

use std::path::PathBuf;

use openbench_core::with_causes;
use openbench_scene::{ImportError, ImportRequest, SemanticClass, World, import_world};
use tempfile::TempDir;

/// Two buildings, `east` around (10, 0) and `west` around (-10, 0), near the equator, and one door.
const MAP: &str = r#"<osm version="0.6">
  <node id="1" lat="-0.00005" lon="3.00005"/><node id="2" lat="-0.00005" lon="3.00015"/>
  <node id="3" lat="0.00005" lon="3.00015"/><node id="4" lat="0.00005" lon="3.00005"/>
  <node id="5" lat="-0.00005" lon="2.99985"/><node id="6" lat="-0.00005" lon="2.99995"/>
  <node id="7" lat="0.00005" lon="2.99995"/><node id="8" lat="0.00005" lon="2.99985"/>
  <node id="9" lat="0.0" lon="3.00005"><tag k="entrance" v="yes"/><tag k="addr:unit" v="1"/></node>
  <way id="1"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="9"/><nd ref="1"/>
    <tag k="building" v="yes"/><tag k="name" v="east"/></way>
  <way id="2"><nd ref="5"/><nd ref="6"/><nd ref="7"/><nd ref="8"/><nd ref="5"/>
    <tag k="building" v="yes"/><tag k="name" v="west"/></way>
</osm>"#;

const DOOR: &str = "<model name='text_model1'><pose>4 0 2 0 0 1.5707963267948966</pose></model>";

struct Place {
    folder: TempDir,
}

impl Place {
    fn new() -> Self {
        let place = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        place.file("map.osm", MAP);
        place
    }

    fn file(&self, name: &str, text: &str) -> PathBuf {
        let path = self.folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(&path, text).unwrap();
        path
    }

    /// Imports a world of these elements.
    fn import(&self, elements: &str) -> Result<World, ImportError> {
        self.import_text(&format!(
            "<sdf version='1.7'><world name='default'>{elements}</world></sdf>"
        ))
    }

    fn import_text(&self, text: &str) -> Result<World, ImportError> {
        self.import_at(text, "tangent:3,0")
    }

    fn import_at(&self, text: &str, georeference: &str) -> Result<World, ImportError> {
        import_world(&ImportRequest {
            world: self.file("test.world", text),
            map: self.folder.path().join("map.osm"),
            models: vec![self.folder.path().join("models")],
            georeference: Some(georeference.parse().unwrap()),
            start: None,
        })
    }

    /// Positions of the visible corners of a world that is one mesh, plate aside.
    fn mesh_corners(&self, file: &str, text: &str) -> Vec<[f32; 3]> {
        self.file(&format!("models/thing/meshes/{file}"), text);
        let elements = format!(
            "<model name='thing'><link name='l'><visual name='v'><geometry><mesh>\
             <uri>model://thing/meshes/{file}</uri></mesh></geometry></visual></link></model>{DOOR}"
        );
        let world = self.import(&elements).unwrap();
        corners(&world, SemanticClass::Other)
    }
}

/// Corners of the visible triangles of a class, in order.
fn corners(world: &World, class: SemanticClass) -> Vec<[f32; 3]> {
    let scene = &world.scene;
    let of_class = scene
        .triangles
        .iter()
        .filter(|t| scene.materials[t.material.0 as usize].class == class);
    of_class
        .flat_map(|t| t.corners)
        .map(|i| scene.vertices[i as usize].position)
        .collect()
}

fn close(found: &[[f32; 3]], expected: &[[f32; 3]]) -> bool {
    found.len() == expected.len()
        && found
            .iter()
            .flatten()
            .zip(expected.iter().flatten())
            .all(|(a, b)| (a - b).abs() < 1e-5)
}

/// A COLLADA file with the triangle (0,0,0) (1,0,0) (0,2,0) in a node that holds `steps`.
fn dae(asset: &str, steps: &str) -> String {
    format!(
        r##"<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
  <asset>{asset}</asset>
  <library_effects><effect id="e"><profile_COMMON>
    <newparam sid="s1"><surface><init_from>img</init_from></surface></newparam>
    <newparam sid="s2"><sampler2D><source>s1</source></sampler2D></newparam>
    <technique sid="t"><lambert><diffuse><texture texture="s2" texcoord="C"/></diffuse></lambert>
    </technique>
  </profile_COMMON></effect></library_effects>
  <library_images><image id="img"><init_from>skin.png</init_from></image></library_images>
  <library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
  <library_geometries><geometry id="g"><mesh>
    <source id="p"><float_array id="pa" count="9">0 0 0 1 0 0 0 2 0</float_array>
      <technique_common><accessor source="#pa" count="3" stride="3"/></technique_common></source>
    <source id="u0"><float_array id="ua" count="2">0.25 0.25</float_array>
      <technique_common><accessor source="#ua" count="1" stride="2"/></technique_common></source>
    <source id="u1"><float_array id="ub" count="2">0.75 0.75</float_array>
      <technique_common><accessor source="#ub" count="1" stride="2"/></technique_common></source>
    <vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
    <polylist material="sym" count="1">
      <input semantic="VERTEX" source="#v" offset="0"/>
      <input semantic="TEXCOORD" source="#u0" offset="1" set="0"/>
      <input semantic="TEXCOORD" source="#u1" offset="1" set="1"/>
      <vcount>3</vcount><p>0 0 1 0 2 0</p></polylist>
  </mesh></geometry></library_geometries>
  <library_visual_scenes><visual_scene id="sc"><node id="n" name="Leaf">{steps}
    <instance_geometry url="#g"><bind_material><technique_common>
      <instance_material symbol="sym" target="#m">
      <bind_vertex_input semantic="C" input_semantic="TEXCOORD" input_set="1"/>
      </instance_material></technique_common></bind_material></instance_geometry></node>
      </visual_scene></library_visual_scenes>
  <scene><instance_visual_scene url="#sc"/></scene>
</COLLADA>"##
    )
}

const CENTIMETRES: &str = r#"<unit name="centimeter" meter="0.01"/><up_axis>Z_UP</up_axis>"#;

#[test]
fn collada_units_become_metres() {
    let found = Place::new().mesh_corners("a.dae", &dae(CENTIMETRES, ""));
    assert!(
        close(&found, &[[0.0; 3], [0.01, 0.0, 0.0], [0.0, 0.02, 0.0]]),
        "{found:?}"
    );
}

#[test]
fn collada_with_y_up_is_rotated() {
    let asset = r#"<unit meter="1"/><up_axis>Y_UP</up_axis>"#;
    let found = Place::new().mesh_corners("a.dae", &dae(asset, ""));
    assert!(
        close(&found, &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 2.0]]),
        "{found:?}"
    );
}

#[test]
fn collada_transforms_apply_in_turn() {
    let steps = "<translate>5 0 0</translate><rotate>0 0 1 90</rotate><scale>2 1 1</scale>";
    let found = Place::new().mesh_corners("a.dae", &dae("<up_axis>Z_UP</up_axis>", steps));
    assert!(
        close(&found, &[[5.0, 0.0, 0.0], [5.0, 2.0, 0.0], [3.0, 0.0, 0.0]]),
        "{found:?}"
    );
}

#[test]
fn a_collada_matrix_replaces_the_other_transforms_as_in_gazebo() {
    let matrix = "<matrix>1 0 0 0 0 1 0 0 0 0 1 7 0 0 0 1</matrix>";
    let steps = format!("{matrix}<translate>5 0 0</translate><scale>9 9 9</scale>");
    let found = Place::new().mesh_corners("a.dae", &dae("<up_axis>Z_UP</up_axis>", &steps));
    assert!(
        close(&found, &[[0.0, 0.0, 7.0], [1.0, 0.0, 7.0], [0.0, 2.0, 7.0]]),
        "{found:?}"
    );
}

#[test]
fn a_mirrored_mesh_keeps_its_outside() {
    let found = Place::new().mesh_corners(
        "a.dae",
        &dae("<up_axis>Z_UP</up_axis>", "<scale>-1 1 1</scale>"),
    );
    assert!(
        close(&found, &[[0.0; 3], [0.0, 2.0, 0.0], [-1.0, 0.0, 0.0]]),
        "{found:?}"
    );
}

#[test]
fn stl_and_obj_keep_their_own_units() {
    let place = Place::new();
    let obj = place.mesh_corners("a.obj", "v 0 0 0\nv 1 0 0\nv 0 2 0\nf 1 2 3\n");
    let stl = "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 2 0\n\
    endloop\nendfacet\nendsolid s\n";
    let stl = place.mesh_corners("a.stl", stl);
    assert!(
        close(&obj, &[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 2.0, 0.0]]),
        "{obj:?}"
    );
    assert_eq!(obj, stl);
}

#[test]
fn images_are_found_among_the_textures_of_the_model_with_the_bound_coordinates() {
    let place = Place::new();
    let skin = place
        .folder
        .path()
        .join("models/thing/materials/textures/skin.png");
    std::fs::create_dir_all(skin.parent().unwrap()).unwrap();
    image::RgbImage::from_pixel(2048, 16, image::Rgb([9, 8, 7]))
        .save(&skin)
        .unwrap();
    place.file("models/thing/meshes/a.dae", &dae(CENTIMETRES, ""));
    let world = place
        .import(&format!("{}{}{DOOR}", thing("", ""), thing("", "")))
        .unwrap();
    let painted: Vec<_> = world
        .scene
        .triangles
        .iter()
        .filter(|t| {
            let texture = world.scene.materials[t.material.0 as usize].texture;
            texture.is_some_and(|t| world.scene.textures[t.0 as usize].rgba[..3] == [9, 8, 7])
        })
        .collect();
    assert_eq!(painted.len(), 2, "{:?}", world.warnings);
    assert_eq!(painted[0].material, painted[1].material);
    assert_eq!(
        world.scene.vertices[painted[0].corners[0] as usize].uv,
        [0.75, 0.75]
    );
    let width = world.scene.textures[0].width;
    assert_eq!(
        (width, world.scene.textures.len()),
        (1024, 2),
        "brought down, loaded once"
    );
}

/// A model with the mesh `a.dae`, with further elements in its `<mesh>` and `<visual>`.
fn thing(in_mesh: &str, in_visual: &str) -> String {
    format!(
        "<model name='thing'><link name='l'><visual name='v'><geometry><mesh>\
         <uri>model://thing/meshes/a.dae</uri>{in_mesh}</mesh></geometry>{in_visual}</visual>\
         </link></model>"
    )
}

#[test]
fn a_script_takes_precedence_over_the_materials_of_the_mesh() {
    let place = Place::new();
    place.file("models/thing/meshes/a.dae", &dae(CENTIMETRES, ""));
    place.file(
        "models/thing/materials/scripts/t.material",
        "material T/Leaf { technique { pass {\n diffuse 0 1 0\n alpha_rejection greater 128\n } } \
        }",
    );
    let visual = "<material><script><uri>model://thing/materials/scripts</uri><name>T/Leaf</name>\
    </script></material>";
    let world = place
        .import(
            &(thing(
                "<scale>3 3 3</scale><submesh><name>Leaf</name></submesh>",
                visual,
            ) + DOOR),
        )
        .unwrap();
    let scene = &world.scene;
    let leaf = &scene.materials[scene.triangles[0].material.0 as usize];
    assert!(
        leaf.cutout && leaf.color == [0.0, 1.0, 0.0] && leaf.texture.is_none(),
        "{leaf:?}"
    );
    assert!((scene.vertices[1].position[0] - 0.03).abs() < 1e-6);
}

#[test]
fn an_unknown_submesh_is_a_warning() {
    let place = Place::new();
    place.file("models/thing/meshes/a.dae", &dae(CENTIMETRES, ""));
    let world = place
        .import(&(thing("<submesh><name>Root</name></submesh>", "") + DOOR))
        .unwrap();
    assert!(
        world.warnings.iter().any(|w| w.contains("Root")),
        "{:?}",
        world.warnings
    );
}

#[test]
fn visuals_are_visible_and_collisions_are_solid() {
    let cube = "<geometry><box><size>2 2 2</size></box></geometry>";
    let model = format!(
        "<model name='wall_1'><pose>0 5 1 0 0 0</pose><link name='l'>\
        <visual name='v'>{cube}</visual></link></model>"
    );
    let world = Place::new().import(&(model.clone() + DOOR)).unwrap();
    assert_eq!(corners(&world, SemanticClass::Wall).len(), 36);
    assert!(world.scene.solid.triangles.is_empty());
    let world = Place::new()
        .import(&(model.replace("visual", "collision") + DOOR))
        .unwrap();
    assert!(corners(&world, SemanticClass::Wall).is_empty());
    assert_eq!(world.scene.solid.triangles.len(), 12);
    assert!(
        world
            .scene
            .solid
            .positions
            .iter()
            .all(|p| (4.0..=6.0).contains(&p[1]) && p[2] >= 0.0)
    );
}

#[test]
fn the_saved_state_takes_precedence_over_models_and_links() {
    let cube = "<geometry><box><size>1 1 1</size></box></geometry>";
    let model = |name: &str| {
        format!(
            "<model name='{name}'><pose>1 0 0 0 0 0</pose><link name='a'>\
            <visual name='v'>{cube}</visual></link>\
             <link name='b'><pose>0 0 3 0 0 0</pose><visual name='v'>{cube}</visual></link></model>"
        )
    };
    let state = format!(
        "<state world_name='default'><insertions>{}</insertions><deletions><name>gone</name>\
        </deletions>\
         <model name='wall'><pose>0 20 0 0 0 0</pose><scale>2 1 1</scale><link name='b'>\
         <pose>0 30 0 0 0 0</pose></link></model></state>",
        model("fence")
    );
    let world = Place::new()
        .import(&format!("{}{}{state}{DOOR}", model("wall"), model("gone")))
        .unwrap();
    let found = corners(&world, SemanticClass::Wall);
    let near = |x: f32, y: f32, z: f32, half: f32| {
        found
            .iter()
            .filter(|p| {
                (p[0] - x).abs() <= half + 1e-5 && (p[1] - y).abs() < 0.6 && (p[2] - z).abs() < 0.6
            })
            .count()
    };
    assert_eq!(
        found.len(),
        4 * 36,
        "the deleted model is gone, the inserted one is there"
    );
    assert_eq!(
        (near(0.0, 20.0, 0.0, 1.0), near(0.0, 30.0, 0.0, 1.0)),
        (36, 36),
        "link poses are poses in the world"
    );
    assert_eq!(
        (near(0.0, 20.0, 0.0, 0.9), near(1.0, 0.0, 3.0, 0.5)),
        (0, 36)
    );
}

#[test]
fn included_models_are_found_by_their_config_named_and_placed() {
    let place = Place::new();
    place.file(
        "models/oak/model.config",
        "<model><sdf version='1.4'>old.sdf</sdf><sdf version='1.6'>new.sdf</sdf></model>",
    );
    let sdf = "<sdf version='1.6'><model name='inner'><pose>0 0 9 0 0 0</pose><link name='l'>\
    <visual name='v'><geometry>\
        <sphere><radius>1</radius></sphere></geometry></visual></link></model></sdf>";
    place.file("models/oak/new.sdf", sdf);
    let include =
        "<include><uri>model://oak</uri><name>tree_1</name><pose>7 0 0 0 0 0</pose></include>";
    let world = place.import(&format!("{include}{DOOR}")).unwrap();
    let found = corners(&world, SemanticClass::Vegetation);
    assert!(!found.is_empty() && found.iter().all(|p| p[0] > 5.9 && p[2] < 1.1));
    // Inside another model, relative to it.
    let nested = format!("<model name='park'><pose>0 50 0 0 0 0</pose>{include}</model>{DOOR}");
    let found = corners(&place.import(&nested).unwrap(), SemanticClass::Vegetation);
    assert!(!found.is_empty() && found.iter().all(|p| p[0] > 5.9 && p[1] > 48.9));
}

#[test]
fn a_model_that_includes_itself_is_an_error() {
    let place = Place::new();
    place.file(
        "models/loop/model.sdf",
        "<sdf version='1.6'><model name='a'><include><uri>model://loop</uri></include></model>\
        </sdf>",
    );
    let error = place
        .import(&format!("<include><uri>model://loop</uri></include>{DOOR}"))
        .unwrap_err()
        .to_string();
    assert!(error.contains("deep"), "{error}");
}

#[test]
fn poses_may_be_given_in_named_frames() {
    let model = "<model name='wall'><pose>0 5 0 0 0 0</pose><frame name='f::__model__'>\
    <pose relative_to='__model__'>1 0 0 0 0 0</pose></frame>\
        <link name='l'><pose relative_to='f::__model__'>0 0 2 0 0 0</pose><visual name='v'>\
        <geometry><box><size>1 1 1</size></box></geometry></visual></link></model>";
    let world = Place::new().import(&(model.to_owned() + DOOR)).unwrap();
    let found = corners(&world, SemanticClass::Wall);
    assert!(
        found.iter().all(|p| (p[0] - 1.0).abs() < 0.6
            && (p[1] - 5.0).abs() < 0.6
            && (p[2] - 2.0).abs() < 0.6),
        "{found:?}"
    );
}

#[test]
fn plates_become_doors_of_the_nearest_building() {
    let elements = "<model name='any'><pose>4 0 2 0 0 0</pose><link name='l'>\
    <pose>0 0 0 0 0 1.5707963267948966</pose><visual name='v'><geometry><mesh>\
        <uri>model://text_model2/meshes/fire2.dae</uri></mesh></geometry></visual></link></model>\
        <include><uri>model://text_model3</uri><pose>-10 1 2 0 0 0</pose></include>\
        <model name='text_model12_0'><pose>-4 0 1 0 0 -1.5707963267948966</pose></model>";
    let world = Place::new().import(elements).unwrap();
    let doors: Vec<String> = world
        .scene
        .doors
        .iter()
        .map(|d| format!("{} {} {:.2}", d.address, d.text, d.facing))
        .collect();
    assert_eq!(
        doors,
        [
            "unit2, east UNIT 2 3.14",
            "unit3, west UNIT 3 1.57",
            "unit12, west UNIT 12 0.00"
        ]
    );
    assert_eq!(corners(&world, SemanticClass::Plate).len(), 3 * 36);
    let public = openbench_osm::OsmMap::new(&world.map, world.georeference);
    assert!(
        public.entrances.is_empty() && public.buildings.len() == 2,
        "the public map has no doors"
    );
    let nodes = world.map.nodes.keys().copied();
    assert!(
        nodes.eq(1..=world.map.nodes.len() as i64),
        "its numbers do not say what was removed"
    );
}

/// An infinite ground, a box, a road and a door, all moved by some offset.
fn moved_world(x: f64, y: f64) -> String {
    let door = DOOR.replace("4 0 2", &format!("{} {} 2", 4.0 + x, y));
    format!(
        "<sdf version='1.7'><world name='default'>\
         <model name='ground'><link name='l'><collision name='c'><geometry><plane/></geometry>\
         </collision></link></model>\
         <model name='wall'><pose>{} {} 0.5 0 0 0.3</pose><link name='l'><visual name='v'>\
         <geometry><box><size>1 2 1</size></box>\
         </geometry></visual></link></model>\
         <road name='r'><width>6</width><point>{} {y} 0</point><point>{} {y} 0</point>\
         </road>{door}</world></sdf>",
        2.0 + x,
        7.0 + y,
        x - 20.0,
        x + 20.0
    )
}

/// A grey PNG of these pixels.
fn png(place: &Place, name: &str, width: u32, pixels: &[u8]) {
    let image =
        image::GrayImage::from_raw(width, pixels.len() as u32 / width, pixels.to_vec()).unwrap();
    let path = place.file(name, "");
    image.save(path).unwrap();
}

#[test]
fn images_become_hills_and_walls() {
    let place = Place::new();
    png(
        &place,
        "models/hill/hill.png",
        3,
        &[0, 0, 0, 0, 200, 0, 0, 0, 0],
    );
    png(
        &place,
        "models/plan/plan.png",
        4,
        &[0, 0, 255, 255, 255, 255, 255, 255],
    );
    let shape =
        |kind: &str, inner: &str| format!("<{kind} name='s'><geometry>{inner}</geometry></{kind}>");
    let hill = "<heightmap><uri>model://hill/hill.png</uri><size>20 20 5</size><pos>0 0 -1</pos>\
    </heightmap>";
    let plan =
        "<image><uri>model://plan/plan.png</uri><scale>0.5</scale><height>2</height></image>";
    let elements = format!(
        "<model name='terrain'><link name='l'>{}{}</link></model><model name='wall'>\
        <link name='l'>{}</link></model>{DOOR}",
        shape("visual", hill),
        shape("collision", hill),
        shape("visual", plan)
    );
    let world = place.import(&elements).unwrap();
    let ground = corners(&world, SemanticClass::Ground);
    assert_eq!(ground.len(), 3 * 8);
    let top = ground.iter().max_by(|a, b| a[2].total_cmp(&b[2])).unwrap();
    assert!(
        top[0].abs() < 1e-6 && top[1].abs() < 1e-6 && (top[2] - 4.0).abs() < 1e-6,
        "{top:?}"
    );
    assert_eq!(world.scene.solid.triangles.len(), 8);
    let wall = corners(&world, SemanticClass::Wall);
    assert_eq!(wall.len(), 3 * 12);
    assert!(
        wall.iter()
            .all(|p| (-1.0..=0.0).contains(&p[0]) && (0.0..=0.5).contains(&p[1])),
        "{wall:?}"
    );
    let gone = place
        .import(&elements.replace("hill.png", "gone.png"))
        .unwrap_err()
        .to_string();
    assert!(
        gone.contains("terrain") && gone.contains("gone.png"),
        "{gone}"
    );
}

#[test]
fn coordinates_of_millions_of_metres_give_the_same_world() {
    let place = Place::new();
    let near = place
        .import_at(&moved_world(0.0, 0.0), "utm:31N,-500000,0")
        .unwrap();
    let far = place
        .import_at(&moved_world(500_000.0, 4_712_000.0), "utm:31N,0,4712000")
        .unwrap();
    assert_eq!(far.georeference, near.georeference);
    assert_eq!(far.scene.vertices, near.scene.vertices);
    assert_eq!(far.scene.doors.len(), 1);
    let door = far.scene.doors[0].point();
    assert!(door.distance(near.scene.doors[0].point()) < 1e-6, "{door}");
    assert!(
        far.warnings.iter().any(|w| w.contains("utm:31N,-500000,0")),
        "{:?}",
        far.warnings
    );
    // Without a start, and with the origin of the file far away: in front of the door.
    assert!(
        (2.0..4.0).contains(&far.start.point().distance(door)),
        "{:?}",
        far.start
    );
    assert_eq!(near.start, openbench_core::Pose2::default());
    let touched = |x: f32, y: f32| {
        let solid = &far.scene.solid;
        let corner = |i: u32| solid.positions[i as usize];
        solid.triangles.iter().any(|t| {
            let [low, high] = [f32::min as fn(f32, f32) -> f32, f32::max].map(|pick| {
                let [a, b, c] = t.map(corner);
                [0, 1].map(|i| pick(pick(a[i], b[i]), c[i]))
            });
            low[0] <= x && x <= high[0] && low[1] <= y && y <= high[1]
        })
    };
    assert!(
        touched(0.0, 0.0) && touched(300.0, -2000.0),
        "ground is everywhere"
    );
}

#[test]
fn roads_are_visible_on_the_ground_and_not_solid() {
    let elements = "<model name='ground_plane'><pose>0 0 -0.1 0 0 0</pose><link name='l'>\
    <visual name='v'><geometry><plane><normal>0 0 1</normal>\
        <size>100 100</size></plane></geometry></visual></link></model><road name='r'>\
        <width>6</width><point>-20 0 0.01</point><point>20 0 0.01</point></road>";
    let world = Place::new().import(&(elements.to_owned() + DOOR)).unwrap();
    let road = corners(&world, SemanticClass::Road);
    assert!(
        road.len() == 6
            && road
                .iter()
                .all(|p| (p[2] + 0.09).abs() < 1e-6 && p[1].abs() <= 3.0),
        "{road:?}"
    );
    assert_eq!(corners(&world, SemanticClass::Ground).len(), 6);
    assert!(world.scene.solid.triangles.is_empty());
}

#[test]
fn errors_have_the_place_of_what_cannot_be_imported() {
    let place = Place::new();
    let model = |geometry: &str| {
        format!(
            "<model name='m'><link name='l'><visual name='v'><geometry>{geometry}</geometry>\
            </visual></link></model>{DOOR}"
        )
    };
    let cases = [
        (place.import(""), "test.world: the world has no doors"),
        (
            place.import_text("<sdf version='1.7'>\n<world name='a'>\n <model"),
            "test.world:3:",
        ),
        (place.import_text("<sdf/>"), "there is no <world>"),
        (
            place.import(&model("<mesh><uri>model://cow/cow.dae</uri></mesh>")),
            "model `m` needs `model://cow/cow.dae`",
        ),
        (
            place.import(&model("<box><size>1 1</size></box>")),
            "test.world:1:",
        ),
        (
            place.import(&model("<box><size>1 1 -1</size></box>")),
            "must be positive",
        ),
        (
            place.import(&format!("<include><uri>model://cow</uri></include>{DOOR}")),
            "model `cow` needs `model://cow`",
        ),
    ];
    for (result, expected) in cases {
        let error = with_causes(&result.unwrap_err());
        assert!(error.contains(expected), "{error} lacks {expected}");
    }
}

#[test]
fn a_map_without_buildings_is_an_error() {
    let place = Place::new();
    place.file(
        "map.osm",
        r#"<osm version="0.6"><node id="1" lat="0" lon="3"/></osm>"#,
    );
    let error = place.import(DOOR).unwrap_err().to_string();
    assert!(
        error.contains("map.osm") && error.contains("no buildings"),
        "{error}"
    );
}

#[test]
fn broken_meshes_are_errors_with_their_file() {
    let good = dae(CENTIMETRES, "");
    let cases = [
        (good[..good.len() / 2].to_owned(), "a.dae:"),
        (
            good.replace("<p>0 0 1 0 2 0</p>", "<p>0 0 1 0 9 0</p>"),
            "position 9",
        ),
        (
            good.replace("<p>0 0 1 0 2 0</p>", "<p>0 0 1 0 2</p>"),
            "multiple of 2",
        ),
        (good.replace("<vcount>3", "<vcount>4"), "more corners"),
        (
            good.replace("offset=\"0\"", &format!("offset=\"{}\"", usize::MAX)),
            "sane input offsets",
        ),
        (
            good.replace("0 2 0</float_array>", "0 x 0</float_array>"),
            "`x` is not a number",
        ),
        (good.replace("url=\"#g\"", "url=\"#h\""), "geometry"),
        (
            good.replace(
                "<node id",
                "<node><instance_node url=\"#n\"/></node><node id",
            )
            .replace(
                "name=\"Leaf\">",
                "name=\"Leaf\"><instance_node url=\"#n\"/>",
            ),
            "inside themselves",
        ),
    ];
    for (text, expected) in cases {
        let place = Place::new();
        place.file("models/thing/meshes/a.dae", &text);
        let error = place
            .import(&(thing("", "") + DOOR))
            .unwrap_err()
            .to_string();
        assert!(
            error.contains("a.dae") && error.contains(expected),
            "{error} lacks {expected}"
        );
    }
}

#[test]
fn harmless_elements_are_counted() {
    let shape = "<visual name='v'><geometry><capsule/></geometry></visual>";
    let elements = format!(
        "<actor name='a'/><light name='l' type='point'/><model name='m'>\
        <link name='l'>{shape}{shape}</link></model>{DOOR}"
    );
    let warnings = Place::new().import(&elements).unwrap().warnings;
    assert!(
        warnings
            .iter()
            .any(|w| w.contains("capsule") && w.contains("2 times")),
        "{warnings:?}"
    );
    assert_eq!(warnings.len(), 3, "{warnings:?}");
}

#[test]
fn deep_nesting_does_not_overflow() {
    let nest = |tag: &str, count: usize| {
        format!(
            "{}{}",
            format!("<{tag}>").repeat(count),
            format!("</{tag}>").repeat(count)
        )
    };
    assert!(
        Place::new()
            .import(&(nest("plugin", 100_000) + DOOR))
            .is_ok()
    );
    let error = Place::new()
        .import(&(nest("model", 100_000) + DOOR))
        .unwrap_err()
        .to_string();
    assert!(error.contains("deep"), "{error}");
}

#[test]
fn no_truncation_of_a_world_panics() {
    let place = Place::new();
    let text = format!(
        "<sdf version='1.7'><world name='default'><road name='r'><width>6</width>\
        <point>-20 0 0.01</point><point>20 0 0.01</point></road>{DOOR}</world></sdf>"
    );
    for end in 0..text.len() {
        assert!(place.import_text(&text[..end]).is_err());
    }
    assert!(place.import_text(&text).is_ok());
}

#[test]
fn each_model_is_an_object() {
    let cube = "<link name='l'><visual name='v'><geometry><box><size>1 1 1</size></box></geometry>\
    </visual></link>";
    let elements = format!(
        "<model name='oak_tree_1'>{cube}</model>\
        <model name='shed'>{cube}<model name='inner'>{cube}</model></model>{DOOR}"
    );
    let scene = Place::new().import(&elements).unwrap().scene;
    let names: Vec<&str> = scene.objects.iter().map(|o| &*o.name).collect();
    assert_eq!(
        names,
        ["oak_tree_1", "shed", "inner", "plate of unit1, east"]
    );
    assert_eq!(scene.objects[0].class, SemanticClass::Vegetation);
    let of_inner = scene.object_numbers.iter().filter(|n| **n == 3).count();
    assert_eq!(of_inner, 12, "the triangles of a box");
}

#[test]
fn triangles_with_non_finite_corners_are_left_out_and_counted() {
    // ASCII STL cannot express it, but binary files can.
    let place = Place::new();
    let vertex = |x: f32| {
        [
            x.to_le_bytes(),
            0.0_f32.to_le_bytes(),
            1.0_f32.to_le_bytes(),
        ]
        .concat()
    };
    let mut binary = vec![0_u8; 80];
    binary.extend(4_u32.to_le_bytes());
    for x in [1.0, f32::NAN, f32::INFINITY, -3e38] {
        binary.extend([0; 12]);
        binary.extend(
            [
                vertex(x),
                vertex(2.0),
                [[0_u8; 4], 1.0_f32.to_le_bytes(), [0; 4]].concat(),
            ]
            .concat(),
        );
        binary.extend([0; 2]);
    }
    place.file("models/thing/meshes/a.stl", "");
    std::fs::write(
        place.folder.path().join("models/thing/meshes/a.stl"),
        binary,
    )
    .unwrap();
    place.file(
        "models/thing/meshes/b.obj",
        "v 0 0 0\nv 1 0 0\nv nan 1 0\nv 1 inf 0\nv 0 1 1e30\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 2 5\n\
        f 1 2 6\n",
    );
    for (mesh, center) in [
        ("a.stl", ""),
        ("b.obj", ""),
        (
            "b.obj",
            "<submesh><name>default</name><center>true</center></submesh>",
        ),
    ] {
        let shape = |tag: &str| {
            format!(
                "<{tag} name='v'><geometry><mesh>\
                <uri>model://thing/meshes/{mesh}</uri>{center}</mesh></geometry></{tag}>"
            )
        };
        let link = format!(
            "<link name='l'>{}{}</link>",
            shape("visual"),
            shape("collision")
        );
        let world = place
            .import(&format!("<model name='thing'>{link}</model>{DOOR}"))
            .unwrap();
        let finite = |p: &[f32; 3]| p.iter().all(|c| c.is_finite());
        let scene = &world.scene;
        let seen = scene.triangles.iter().flat_map(|t| t.corners);
        assert!(
            seen.clone()
                .all(|i| finite(&scene.vertices[i as usize].position)),
            "{mesh}"
        );
        let touched = scene.solid.triangles.iter().flatten();
        assert!(
            touched
                .clone()
                .all(|i| finite(&scene.solid.positions[*i as usize])),
            "{mesh}"
        );
        if center.is_empty() {
            assert_eq!(scene.solid.triangles.len(), 1, "{mesh}");
            assert!(
                world
                    .warnings
                    .iter()
                    .any(|w| w.contains("no number") && w.contains("6 times")),
                "{:?}",
                world.warnings
            );
        }
    }
}
