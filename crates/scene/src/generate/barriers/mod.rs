//! Walls, fences, hedges and raised kerbs along `barrier=*` ways, open where a road or path goes
//! through. Where that is, `gates` says, for walls around water too.

pub(super) mod gates;

use openbench_geometry::{Segment, segments};
use openbench_osm::map::kerb_height;
use openbench_osm::{Barrier, OsmMap, Road, Tags};
use rand_pcg::Pcg64Mcg;

use crate::generate::greenery::hedges::{self, Size};
use crate::generate::inputs::Inputs;
use crate::generate::layout::lanes::Lanes;
use crate::generate::materials::palette::Palette;
use crate::generate::output::Output;
use crate::generate::seeds::{Purpose, between, chance, pick, stream};
use crate::generate::shapes::{Block, Surface, at, cuboid, facet, see_through};
use crate::generate::streets::profile::{KERB_WIDTH_M, metres};
use crate::material::SemanticClass;
use crate::scene::{Layer, SceneBuilder};
use gates::between_gates;

/// No kerb is built higher, metres.
const HIGHEST_KERB_M: f64 = 0.4;
/// Kerbs are drawn with short stretches just where paths cross them: what crosses one this far
/// beyond its ends opens it too, metres.
const KERB_NEIGHBOURS_M: f64 = 8.0;
/// Thickness of a wall, metres.
const WALL_THICKNESS_M: f64 = 0.25;
/// Distance between the posts of a fence, metres.
const POST_SPACING_M: f64 = 2.4;
/// Posts of one stretch at most.
const MAX_POSTS: usize = 4_000;

/// Construction of a barrier; heights in metres.
#[derive(Debug, Clone, Copy)]
enum Build {
    /// Masonry with a coping.
    Masonry { surface: Surface, height: f64 },
    /// Posts with panels that are seen through.
    Panels { surface: Surface, height: f64 },
    /// A clipped hedge.
    Hedge(Size),
    /// Kerb stones.
    Kerb { height: f64 },
    /// Bollards and other things that stop no robot or that are not lines.
    Nothing,
}

impl Build {
    fn class(self) -> SemanticClass {
        match self {
            Self::Hedge(_) => SemanticClass::Hedge,
            Self::Kerb { .. } => SemanticClass::Kerb,
            _ => SemanticClass::Wall,
        }
    }
}

/// Builds the map's barriers.
pub(super) fn build(inputs: &Inputs, out: &mut Output) {
    let map = inputs.map;
    for barrier in &map.barriers {
        // A stream for each way: a change to one barrier leaves the others as they are.
        let mut rng = stream(inputs.seed, Purpose::Barrier, barrier.way as u64);
        let build = build_of(&barrier.tags, &inputs.palette, &mut rng);
        out.scene
            .begin_object(kind(&barrier.tags).to_owned(), build.class());
        let on_ground = segments(&barrier.points).filter(|s| inputs.is_on_ground(s.start));
        for stretch in on_ground {
            for part in closed_parts(barrier, &map.roads, &inputs.lanes, stretch) {
                if !out.is_full() {
                    build_stretch(inputs, &mut out.scene, build, part);
                }
            }
        }
    }
}

/// The stretches of all barriers that stop a robot.
pub(super) fn standing(map: &OsmMap, lanes: &Lanes) -> Vec<Segment> {
    // The kinds for which `build_of` builds something solid.
    const SOLID: [&str; 8] = [
        "wall",
        "city_wall",
        "retaining_wall",
        "hedge",
        "fence",
        "handrail",
        "guard_rail",
        "kerb",
    ];
    let solid = map
        .barriers
        .iter()
        .filter(|b| SOLID.contains(&kind(&b.tags)));
    let mut found = Vec::new();
    for barrier in solid {
        for stretch in segments(&barrier.points) {
            found.extend(closed_parts(barrier, &map.roads, lanes, stretch));
        }
    }
    found
}

/// The parts of a stretch of a barrier that no road or gate opens.
fn closed_parts(
    barrier: &Barrier,
    roads: &[Road],
    lanes: &Lanes,
    stretch: Segment,
) -> Vec<Segment> {
    let beyond = if kind(&barrier.tags) == "kerb" {
        KERB_NEIGHBOURS_M
    } else {
        0.0
    };
    between_gates(roads, lanes, &barrier.gates, stretch, beyond)
}

fn kind(tags: &Tags) -> &str {
    if tags.is("natural", "hedge") || tags.is("landuse", "hedge") {
        return "hedge";
    }
    tags.get("barrier")
        .filter(|k| *k != "yes")
        .unwrap_or("wall")
}

fn build_of(tags: &Tags, palette: &Palette, rng: &mut Pcg64Mcg) -> Build {
    let tagged_height = metres(tags, "height").filter(|h| (0.1..=12.0).contains(h));
    match kind(tags) {
        "wall" | "city_wall" | "retaining_wall" => {
            let surface = pick(rng, &palette.free_walls);
            // Drawn also where the map has a height, so that the tag does not shift later draws.
            let drawn = between(rng, 1.5, 2.0);
            Build::Masonry {
                surface,
                height: tagged_height.unwrap_or(drawn),
            }
        }
        "hedge" => {
            let drawn = between(rng, 1.0, 1.5);
            let thickness = between(rng, 0.6, 0.8);
            Build::Hedge(Size {
                height: tagged_height.unwrap_or(drawn),
                thickness,
            })
        }
        "fence" | "handrail" | "guard_rail" => {
            let drawn_metal = chance(rng, 0.4);
            let is_metal = tags
                .get("fence_type")
                .map_or(drawn_metal, |kind| kind != "wood");
            let surface = if is_metal {
                palette.railings
            } else {
                pick(rng, &palette.pickets)
            };
            let drawn = between(rng, 1.0, 1.3);
            Build::Panels {
                surface,
                height: tagged_height.unwrap_or(drawn),
            }
        }
        "kerb" => Build::Kerb {
            height: kerb_height(tags).min(HIGHEST_KERB_M),
        },
        _ => Build::Nothing,
    }
}

fn build_stretch(inputs: &Inputs, scene: &mut SceneBuilder, build: Build, line: Segment) {
    let palette = &inputs.palette;
    match build {
        Build::Masonry { surface, height } => {
            masonry(scene, surface, palette.coping, line, height);
        }
        Build::Hedge(size) => hedges::build(inputs, scene, line, size),
        Build::Panels { surface, height } => panels(scene, surface, palette.coping, line, height),
        Build::Kerb { height } => {
            let half = KERB_WIDTH_M / 2.0;
            let stones = Block {
                min: [0.0, -half, 0.0],
                max: [line.length(), half, height],
            };
            cuboid(scene, Layer::Both, palette.kerbstone, line.pose(), stones);
        }
        Build::Nothing => {}
    }
}

fn masonry(
    scene: &mut SceneBuilder,
    surface: Surface,
    coping: Surface,
    line: Segment,
    height: f64,
) {
    let (pose, length) = (line.pose(), line.length());
    let half = WALL_THICKNESS_M / 2.0;
    let wall = Block {
        // Longer by half the thickness at both ends, so that stretches close around their corners.
        min: [-half, -half, 0.0],
        max: [length + half, half, height],
    };
    cuboid(scene, Layer::Both, surface, pose, wall);
    let (out, top) = (half + 0.05, height + 0.08);
    let stones = Block {
        min: [-out, -out, height],
        max: [length + out, out, top],
    };
    cuboid(scene, Layer::Visible, coping, pose, stones);
}

fn panels(scene: &mut SceneBuilder, surface: Surface, post: Surface, line: Segment, height: f64) {
    see_through(scene, surface, line, 0.0..height);
    let Segment { start: a, end: b } = line;
    // Rays pass between the bars; a robot does not.
    let corners = [at(a, 0.0), at(b, 0.0), at(b, height), at(a, height)];
    facet(scene, Layer::Solid, surface, &corners);
    let length = line.length();
    // Spans between posts; there is one post more, at the end.
    let posts = ((length / POST_SPACING_M) as usize).min(MAX_POSTS) + 1;
    for i in 0..=posts {
        let x = length * i as f64 / posts as f64;
        let block = Block {
            min: [x - 0.05, -0.05, 0.0],
            max: [x + 0.05, 0.05, height + 0.06],
        };
        cuboid(scene, Layer::Visible, post, line.pose(), block);
    }
}
