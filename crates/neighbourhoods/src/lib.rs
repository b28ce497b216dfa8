#![doc = include_str!("../README.md")]
//! ## Modules
//!
//! | module | contents |
//! |---|---|
//! | `kind`, `style` | [`Kind`]: sizes; [`Style`]: characters |
//! | `purpose` | streams of random numbers |
//! | `plan` | streets, homes, doors and barriers while they are planned |
//! | `network` | street networks |
//! | `ground` | what fits where |
//! | `outline` | shapes of buildings |
//! | `homes`, `estate` | homes along streets; slabs in greenery |
//! | `numbers`, `words` | house numbers; names and places |
//! | `reach` | the ground that a robot reaches |
//! | `doors` | doors in walls that are reached |
//! | `gardens`, `greenery` | garages, paths, barriers; trees, lamps, playgrounds |
//! | `start` | where the robot starts |
//! | `sheet` | the plan as OpenStreetMap data |

mod doors;
mod estate;
mod gardens;
mod greenery;
mod ground;
mod homes;
mod kind;
mod network;
mod numbers;
mod outline;
mod plan;
mod purpose;
mod reach;
mod sheet;
mod start;
mod style;
mod words;

use openbench_core::{Georeference, Pose2};
use openbench_geometry::sides;
use openbench_osm::OsmData;
use openbench_osm::draws::between;

use ground::Ground;
use plan::{Fence, Plan};
use purpose::{Purpose, Seed};
use reach::Reach;
use words::Language;

pub use kind::{Kind, UnknownKind};
pub use style::Style;

/// Largest distance of the start from the origin along each axis, metres.
const START_FROM_ORIGIN_M: f64 = 60.0;

/// A neighbourhood as a map.
///
/// ```
/// use openbench_neighbourhoods::{Kind, draw};
/// use openbench_osm::OsmData;
///
/// let here = draw(Kind::Small, 3);
/// // What is written as a file is read as the same map.
/// let read = OsmData::from_xml(&here.map.to_xml())?;
/// assert_eq!(read.ways, here.map.ways);
/// // The start is not the origin of the map.
/// assert!(here.start.point().distance(Default::default()) > 0.1);
/// # Ok::<(), openbench_osm::OsmError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Neighbourhood {
    /// The size.
    pub kind: Kind,
    /// The seed from which it was drawn.
    pub seed: u64,
    /// The character.
    pub style: Style,
    /// The map, doors included.
    pub map: OsmData,
    /// Where it pretends to be on the Earth.
    pub georeference: Georeference,
    /// The robot's start in the `map` frame of that georeference: free ground on a street.
    pub start: Pose2,
}

impl Neighbourhood {
    /// The name: kind and seed, as in `medium-7`.
    pub fn name(&self) -> String {
        format!("{}-{}", self.kind, self.seed)
    }

    /// What is said of the source of the map.
    pub fn attribution(&self) -> String {
        format!("Drawn map `{}`: a made-up place, CC0", self.name())
    }
}

/// Draws a neighbourhood. The same kind and seed give the same bytes on every machine.
///
/// ```
/// use openbench_neighbourhoods::{Kind, draw};
///
/// let here = draw(Kind::Medium, 7);
/// assert_eq!(here.name(), "medium-7");
/// assert_eq!(here.map.to_xml(), draw(Kind::Medium, 7).map.to_xml());
/// assert_ne!(here.map.to_xml(), draw(Kind::Medium, 8).map.to_xml());
/// ```
pub fn draw(kind: Kind, seed: u64) -> Neighbourhood {
    let of_all = Seed::new(kind, seed);
    let style = Style::draw(&mut of_all.stream(Purpose::Style, 0));
    let mut place = of_all.stream(Purpose::Place, 0);
    let language = Language::draw(&mut place);
    let georeference = language.georeference(&mut place);
    let (plan, start) = plan(kind, style, language, of_all);
    let names = language.streets(plan.streets.len(), &mut place);
    // Where the plan lies in the `map` frame.
    let mut frame = of_all.stream(Purpose::Place, 1);
    let turn = between(&mut frame, 0.0, std::f64::consts::TAU);
    let turned = Pose2::new(0.0, 0.0, turn).transform(start.x, start.y);
    let mut aside = || between(&mut frame, -START_FROM_ORIGIN_M, START_FROM_ORIGIN_M);
    let pose = Pose2::new(aside() - turned.x, aside() - turned.y, turn);
    let at = pose.transform(start.x, start.y);
    let yaw = openbench_core::frames::wrap_angle(start.yaw + turn);
    Neighbourhood {
        kind,
        seed,
        style,
        map: sheet::write(&plan, &names, pose, georeference),
        georeference,
        start: Pose2::new(at.x, at.y, yaw),
    }
}

/// Plans a neighbourhood, and draws the start in it.
fn plan(kind: Kind, style: Style, language: Language, seed: Seed) -> (Plan, Pose2) {
    let mut draws = seed.stream(Purpose::Network, 0);
    let half = style.ground(kind, &mut draws);
    let mut streets = network::draw(style, half, &mut draws);
    let mut ground = Ground::new(half, &streets);
    let (mut homes, mut patches, mut paths) = (Vec::new(), Vec::new(), Vec::new());
    if style == Style::Slabs {
        patches = estate::parking(seed, &streets, &mut ground);
        homes = estate::place(kind, seed, half, &mut ground);
        paths = estate::footpaths(seed, &homes, &mut streets, &ground);
    } else {
        homes.extend(homes::place(style, seed, &streets, &mut ground));
    }
    numbers::give(style, language, seed, streets.len(), &mut homes);
    let mut gardens = gardens::garages(seed, &homes, &mut streets, &mut ground);
    let middle = streets[0].pose_at(streets[0].length() / 2.0).point();
    let mut walls = doors::walls_of(&homes);
    walls.extend(gardens.outbuildings.iter().flat_map(|b| sides(&b.outer)));
    // Doors are drawn where a robot gets to between the buildings alone; barriers give way to them.
    let open = Reach::new(half, walls.iter().copied(), middle);
    for home in &mut homes {
        home.doors = doors::place(seed, home, &open, &walls);
    }
    gardens::enclose(seed, &homes, &mut streets, &ground, &mut gardens);
    let between_fences = |fences: &[Fence]| {
        let standing = fences.iter().flat_map(Fence::standing);
        Reach::new(half, walls.iter().copied().chain(standing), middle)
    };
    let reach = gardens::open_up(&homes, &mut gardens.fences, between_fences);
    paths.append(&mut gardens.paths);
    let mut plan = Plan {
        half,
        streets,
        paths,
        homes,
        outbuildings: gardens.outbuildings,
        fences: gardens.fences,
        patches,
        things: Vec::new(),
    };
    plan.patches
        .extend(greenery::playgrounds(style, seed, &plan, &ground));
    plan.things = greenery::things(seed, &plan, &ground);
    let start = start::draw(seed, &plan, &ground, &reach);
    (plan, start)
}
