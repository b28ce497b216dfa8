//! The plates of a door as in streets: beside it, on its leaf or above it, one or two or none, some
//! half hidden.

use nalgebra::Point3;
use openbench_core::Pose2;
use openbench_osm::draws;
use rand_pcg::Pcg64Mcg;

use super::doorway::Doorway;
use crate::generate::buildings::house::House;
use crate::generate::inputs::Inputs;
use crate::generate::output::Output;
use crate::generate::seeds::{between, chance, element_number, mix, pick};
use crate::generate::shapes::{Block, Surface, cuboid};
use crate::material::SemanticClass;
use crate::plates::{
    Content, Design, Extent, Facts, Language, Line, Make, TypefaceSet, Wear, Wording,
};
use crate::scene::{Door, Layer};

/// Streams of random numbers: those of a building and of a door.
const BUILDING_STREAM: u64 = 101;
const DOOR_STREAM: u64 = 102;
/// Distance from the middle of a door to the nearest edge of a plate beside it, metres.
const BESIDE_M: f64 = 0.75;
/// Lower edge of a plate above a door, metres: on the lintel over the frame.
const ABOVE_M: f64 = 2.27;
/// A house with lower eaves has no room above its doors, metres.
const LOWEST_EAVES_M: f64 = 2.9;
/// Space between two plates, metres.
const BETWEEN_M: f64 = 0.05;
/// How far what hides a plate stands out from it, metres.
const COVER_M: f64 = 0.18;
/// Size of a lump of leaves, metres.
const LEAF_M: f64 = 0.08;
/// Share of the doors whose plate is of another design than that of the building.
const OWN_DESIGN: f64 = 0.12;

/// Where the plates of a building hang.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Mount {
    Beside,
    Leaf,
    Above,
}

/// What the plates of a building have in common.
struct Custom {
    design: Design,
    wording: Wording,
    language: Language,
    mount: Mount,
    /// Height of the middle of plates beside the door and on its leaf, metres.
    height: f64,
    /// Height of the door above the ground, metres: plates above it are lifted with its frame.
    lift: f64,
}

impl Custom {
    fn draw(inputs: &Inputs, house: &House, door: &Doorway, brightness: f32) -> Self {
        let plates = &inputs.options.plates;
        let element = element_number(inputs.map.buildings[door.building].element);
        let draws = &mut draws::stream(plates.seed, BUILDING_STREAM, element);
        let language = pick(draws, inputs.neighbourhood.languages());
        let set = TypefaceSet::of_seed(plates.seed);
        let design = Design::draw(draws, set).on_wall(brightness);
        let wording = Wording::draw(draws, language, inputs.neighbourhood.is_only(door));
        let wish = pick(
            draws,
            &[Mount::Beside, Mount::Beside, Mount::Beside, Mount::Above],
        );
        let height = between(draws, 1.45, 1.85);
        let lift = inputs.relief.lift(door);
        let has_room_above = !house.canopy && house.eaves > LOWEST_EAVES_M + lift;
        let mount = match wish {
            Mount::Above if has_room_above => Mount::Above,
            // The wall has no room there, or the plate is on the leaf by draw.
            _ if door.plate_offset == 0.0 => Mount::Leaf,
            _ => Mount::Beside,
        };
        Self {
            design,
            wording,
            language,
            mount,
            height,
            lift,
        }
    }
}

/// What a plate of a design says of a door; `None` if its typefaces lack the letters.
fn told(wording: &Wording, design: &Design, facts: &Facts) -> Option<(Content, Vec<Line>)> {
    let is_drawable = |(_, lines): &(Content, Vec<Line>)| {
        let mut lines = lines.iter();
        lines.all(|line| design.has(&line.text))
    };
    // Streets may have letters that no typeface has.
    let told = wording.lines(facts).filter(is_drawable);
    told.or_else(|| wording.without_street().lines(facts).filter(is_drawable))
}

/// Hangs the plates of a door, and records the door.
pub(super) fn hang(inputs: &Inputs, out: &mut Output, house: &House, door: &Doorway) {
    let plates = &inputs.options.plates;
    let brightness = out.scene.brightness(house.facade.material);
    let custom = Custom::draw(inputs, house, door, brightness);
    let unit = door.address.unit.as_deref().unwrap_or_default();
    let element = element_number(inputs.map.buildings[door.building].element);
    let number = unit
        .bytes()
        .fold(element, |n, byte| mix(n ^ u64::from(byte)));
    let draws = &mut draws::stream(plates.seed, DOOR_STREAM, number);
    let state = plates.shares.state(draws);
    let other = Design::draw(draws, TypefaceSet::of_seed(plates.seed)).on_wall(brightness);
    let design = if chance(draws, OWN_DESIGN) {
        other
    } else {
        custom.design
    };
    let facts = Facts::of(&door.address, inputs.neighbourhood.is_only(door));
    let told = told(&custom.wording, &design, &facts).filter(|_| !state.is_missing);
    let names = [0; 4].map(|_| pick(draws, custom.language.family_names()));
    let drawn = &mut out.drawn_plates;
    drawn.doors += 1;
    drawn.test_typefaces = TypefaceSet::of_seed(plates.seed) == TypefaceSet::Test;
    let Some((content, lines)) = told else {
        drawn.missing += 1;
        let place = Place::of(
            &custom,
            door,
            Extent {
                width_m: 0.2,
                height_m: 0.2,
            },
        );
        out.scene
            .door(place.door(door, String::new(), 0.0, NO_TEXT));
        return;
    };
    count(out, content, design.make, &state.wear);
    out.drawn_plates.tilted += usize::from(state.is_tilted());
    let face = out.street_face(SemanticClass::Plate, &design, &lines, &names, state.wear);
    let place = Place::of(&custom, door, face.size);
    let tilt = state.tilt_deg.to_radians();
    face.hang(&mut out.scene, place.door, place.back, tilt);
    let text = lines
        .iter()
        .map(|line| line.text.as_str())
        .collect::<Vec<_>>();
    out.scene
        .door(place.door(door, text.join(" "), face.text_above_m, face.text));
    if state.has_second {
        let more = second(draws, inputs, &custom, &lines, &names, design);
        let wear = Wear {
            dirt: 0.25,
            glare: None,
        };
        let lower = out.street_face(
            SemanticClass::Plate,
            &more.design,
            &more.lines,
            &names,
            wear,
        );
        if let Some(below) = place.below(face.size, lower.size) {
            lower.hang(&mut out.scene, below.door, below.back, 0.0);
            out.drawn_plates.second += 1;
        }
    }
    if state.is_hidden {
        cover(inputs, out, house, &place, face.size, draws);
        out.drawn_plates.hidden += 1;
    }
}

const NO_TEXT: Extent = Extent {
    width_m: 0.0,
    height_m: 0.0,
};

fn count(out: &mut Output, content: Content, make: Make, wear: &Wear) {
    let drawn = &mut out.drawn_plates;
    *drawn.makes.entry(make.name().to_owned()).or_default() += 1;
    drawn.dirty += usize::from(wear.dirt >= 0.5);
    drawn.glare += usize::from(wear.glare.is_some());
    let kind = match content {
        Content::Number => &mut drawn.number_only,
        Content::Unit => &mut drawn.unit_only,
        Content::Both => &mut drawn.both,
    };
    *kind += 1;
}

/// A second plate.
struct Second {
    design: Design,
    lines: Vec<Line>,
}

/// A name, bells, or the number once more in an older design.
fn second(
    draws: &mut Pcg64Mcg,
    inputs: &Inputs,
    custom: &Custom,
    lines: &[Line],
    names: &[&str],
    first: Design,
) -> Second {
    let set = TypefaceSet::of_seed(inputs.options.plates.seed);
    let kind = pick(draws, &[0, 1, 2]);
    let name_make = pick(
        draws,
        &[Make::Brass, Make::Sticker, Make::Tile, Make::Steel],
    );
    let older_make = pick(draws, &[Make::Enamel, Make::Tile, Make::Wood, Make::Steel]);
    let make = match kind {
        0 => name_make,
        1 if first.make != Make::Bells => Make::Bells,
        _ => older_make,
    };
    let design = Design::of(make, draws, set);
    let name = Line {
        text: names
            .first()
            .map_or_else(String::new, |name| (*name).to_owned()),
        size: 1.0,
    };
    // A name alone says which door it is to those who know the people.
    let is_name = kind == 0 && custom.language != Language::Chinese;
    Second {
        design: design.with_capitals(0.06),
        lines: if is_name { vec![name] } else { lines.to_vec() },
    }
}

/// The place of a plate in its wall, in the frame of the door: forward, left, up, metres.
#[derive(Debug, Clone, Copy)]
struct Place {
    /// Middle of the back of the plate.
    back: Point3<f64>,
    /// The door.
    door: Pose2,
    mount: Mount,
}

impl Place {
    fn of(custom: &Custom, door: &Doorway, size: Extent) -> Self {
        let [depth, left, up] = match custom.mount {
            Mount::Leaf => [0.06, 0.0, custom.height.min(1.75)],
            Mount::Above => [0.02, 0.0, ABOVE_M + custom.lift + size.height_m / 2.0],
            Mount::Beside => {
                let side = door.plate_offset.signum();
                [0.035, side * (BESIDE_M + size.width_m / 2.0), custom.height]
            }
        };
        Self {
            back: Point3::new(depth, left, up),
            door: door.pose(),
            mount: custom.mount,
        }
    }

    /// Below a plate of `own` size; `None` where a plate would be on the door or too low.
    fn below(&self, own: Extent, size: Extent) -> Option<Self> {
        let up = self.back.z - (own.height_m + size.height_m) / 2.0 - BETWEEN_M;
        let fits = self.mount != Mount::Above && up - size.height_m / 2.0 > 0.8;
        fits.then_some(Self {
            back: Point3::new(self.back.x, self.back.y, up),
            ..*self
        })
    }

    /// A point of the door's frame in `map`.
    fn point(&self, forward: f64, left: f64, up: f64) -> Point3<f64> {
        let at = self.door.transform(forward, left);
        Point3::new(at.x, at.y, up)
    }

    /// The door with its plate, whose text has its middle so many metres above the plate's.
    fn door(&self, door: &Doorway, text: String, above: f64, size: Extent) -> Door {
        let middle = self.point(self.back.x + 0.01, self.back.y, self.back.z + above);
        Door {
            address: door.address.clone(),
            text,
            plate: middle.into(),
            facing: door.facing,
            lettering: size,
            doorway: Some(self.door),
        }
    }
}

/// Hides half of a plate: a climber, a lamp or a letter box, a relief of the wall. All hang on the
/// wall above the robot, so nothing solid is added.
fn cover(
    inputs: &Inputs,
    out: &mut Output,
    house: &House,
    place: &Place,
    size: Extent,
    draws: &mut Pcg64Mcg,
) {
    let (w, h) = (size.width_m / 2.0, size.height_m / 2.0);
    let share = between(draws, 0.4, 0.6);
    let from_left = chance(draws, 0.5);
    let [back, left, up] = [place.back.x, place.back.y, place.back.z];
    // The covered strip, from one side of the plate to a share of it.
    let strip = if from_left {
        [left + w - 2.0 * w * share, left + w + 0.08]
    } else {
        [left - w - 0.08, left - w + 2.0 * w * share]
    };
    let whole = [left - w - 0.06, left + w + 0.06];
    let kind = pick(draws, &[0, 0, 1, 2]);
    let front = back + COVER_M;
    let mut add = |surface: Surface, forward: [f64; 2], across: [f64; 2], z: [f64; 2]| {
        let block = Block {
            min: [forward[0], across[0], z[0]],
            max: [forward[1], across[1], z[1]],
        };
        cuboid(&mut out.scene, Layer::Visible, surface, place.door, block);
    };
    match kind {
        // Leaves, a lump at a time, so close that none of the strip is seen.
        0 => {
            let crown = pick(draws, &inputs.palette.crowns);
            let high = up - h - 0.3..up + h + 0.15;
            let wide = (strip[1] - strip[0]).max(0.05);
            let rows = ((high.end - high.start) / LEAF_M) as usize + 1;
            let columns = (wide / LEAF_M) as usize + 1;
            for row in 0..rows {
                for column in 0..columns {
                    let half = between(draws, 0.8, 1.2) * LEAF_M;
                    let share = (column as f64 + between(draws, 0.3, 0.7)) / columns as f64;
                    let middle = strip[0] + share * wide;
                    let z = high.start + (row as f64 + between(draws, 0.2, 0.8)) * LEAF_M;
                    let depth = between(draws, 0.6, 1.0) * COVER_M;
                    // Towards the plate's open half a ragged edge.
                    let across = [middle - half, middle + half];
                    let surface = if chance(draws, 0.7) {
                        crown.core
                    } else {
                        crown.shell
                    };
                    add(surface, [back, back + depth], across, [z - half, z + half]);
                }
            }
        }
        // A lamp or a box in front of the lower half.
        1 => {
            let top = up - h + 2.0 * h * share;
            add(
                inputs.palette.dark_metal,
                [back, front],
                whole,
                [top - 0.3, top],
            );
        }
        _ => add(
            house.trim,
            [0.0, front],
            strip,
            [up - h - 0.4, up + h + 0.3],
        ),
    }
}
