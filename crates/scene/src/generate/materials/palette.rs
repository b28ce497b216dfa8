//! The materials of a world. Reflectivities are roughly those of the surfaces at 905 nm: asphalt
//! dark, leaves and plaster bright, car paint by colour.

use super::images;
use super::openings::{self, Glazing};
use crate::generate::seeds::{Purpose, mix};
use crate::generate::shapes::Surface;
use crate::material::{Finish, Material, MaterialId, SemanticClass, Texture, TextureId};
use crate::scene::SceneBuilder;

/// The materials of a world.
#[derive(Debug)]
pub(crate) struct Palette {
    pub grass: Surface,
    pub asphalt: Surface,
    pub worn_asphalt: Surface,
    pub paving: Surface,
    pub kerb: Surface,
    pub path: Surface,
    pub gravel: Surface,
    pub earth: Surface,
    pub water: Surface,
    pub quay: Surface,
    /// Woods and meadows far away.
    pub hills: Surface,
    pub kerbstone: Surface,
    pub patch: Surface,
    pub marking: Surface,
    pub doorstep: Surface,
    /// Facades by kind: brick, plaster, siding, stone; each in several colours.
    pub facades: Vec<Surface>,
    /// Facades of tall houses and towns: no boards, more plaster.
    pub town_facades: Vec<Surface>,
    pub plinths: Vec<Surface>,
    pub trims: Vec<Surface>,
    pub pitched_roofs: Vec<Surface>,
    pub flat_roof: Surface,
    /// Two images of windows (with and without curtains) for each style.
    pub windows: Vec<[MaterialId; 2]>,
    /// The same with shutters at both sides.
    pub shuttered: Vec<[MaterialId; 2]>,
    pub shop_windows: [MaterialId; 2],
    pub signs: Vec<Surface>,
    pub awnings: Vec<Surface>,
    pub quoins: Surface,
    pub downpipe: Surface,
    pub doors: Vec<MaterialId>,
    pub garages: Vec<MaterialId>,
    pub free_walls: Vec<Surface>,
    pub coping: Surface,
    pub pickets: Vec<Surface>,
    pub railings: Surface,
    pub balcony_railings: Surface,
    pub hedge: Surface,
    pub flowers: Vec<Surface>,
    pub bark: Surface,
    pub pale_bark: Surface,
    pub crowns: Vec<Crown>,
    pub needles: Vec<Surface>,
    pub metal: Surface,
    pub dark_metal: Surface,
    pub lamp_glass: Surface,
    pub wood: Surface,
    pub red: Surface,
    pub yellow: Surface,
    pub green: Surface,
    pub car_paints: Vec<Surface>,
    pub car_glass: Surface,
    pub tyre: Surface,
    pub rim: Surface,
    pub car_lights: [Surface; 2],
}

/// The surfaces of a crown.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Crown {
    /// Dense foliage inside.
    pub core: Surface,
    /// Leaves with holes between them.
    pub shell: Surface,
}

/// An image, and the number of metres that it covers.
#[derive(Debug, Clone, Copy)]
struct Image {
    texture: TextureId,
    tile: f64,
}

fn tiled(texture: TextureId, tile: f64) -> Image {
    Image { texture, tile }
}

struct Mixer<'a> {
    builder: &'a mut SceneBuilder,
}

impl Mixer<'_> {
    fn surface(
        &mut self,
        class: SemanticClass,
        color: [f32; 3],
        reflectivity: u8,
        image: Option<Image>,
    ) -> Surface {
        let mut material = Material::plain(class, color);
        material.reflectivity = reflectivity;
        material.texture = image.map(|image| image.texture);
        Surface {
            material: self.builder.material(material),
            tile: image.map_or(1.0, |image| image.tile),
        }
    }

    fn cutout(
        &mut self,
        class: SemanticClass,
        color: [f32; 3],
        reflectivity: u8,
        image: Image,
    ) -> Surface {
        let mut material = Material::plain(class, color).with_texture(image.texture);
        (material.reflectivity, material.cutout) = (reflectivity, true);
        Surface {
            material: self.builder.material(material),
            tile: image.tile,
        }
    }

    /// Panes, with or without an image of what is around and behind them.
    fn glass(
        &mut self,
        class: SemanticClass,
        color: [f32; 3],
        reflectivity: u8,
        image: Option<Image>,
    ) -> Surface {
        let mut material = Material::plain(class, color);
        material.reflectivity = reflectivity;
        material.texture = image.map(|image| image.texture);
        material.finish = Finish::Glass;
        Surface {
            material: self.builder.material(material),
            tile: image.map_or(1.0, |image| image.tile),
        }
    }

    fn lamp(&mut self, color: [f32; 3]) -> Surface {
        let mut material = Material::plain(SemanticClass::Furniture, color);
        material.finish = Finish::Lamp;
        Surface {
            material: self.builder.material(material),
            tile: 1.0,
        }
    }

    fn plain(&mut self, class: SemanticClass, color: [f32; 3]) -> Surface {
        let material = Material::plain(class, color);
        Surface {
            material: self.builder.material(material),
            tile: 1.0,
        }
    }

    fn image(&mut self, texture: Texture) -> TextureId {
        self.builder.texture(texture)
    }

    fn tinted(
        &mut self,
        class: SemanticClass,
        colors: &[[f32; 3]],
        reflectivity: u8,
        image: Image,
    ) -> Vec<Surface> {
        colors
            .iter()
            .map(|c| self.surface(class, *c, reflectivity, Some(image)))
            .collect()
    }
}

const BRICKS: [[f32; 3]; 4] = [
    [0.70, 0.36, 0.28],
    [0.76, 0.55, 0.40],
    [0.52, 0.33, 0.29],
    [0.80, 0.72, 0.60],
];
const PLASTERS: [[f32; 3]; 6] = [
    [0.93, 0.90, 0.83],
    [0.92, 0.83, 0.62],
    [0.88, 0.71, 0.60],
    [0.74, 0.80, 0.80],
    [0.80, 0.84, 0.70],
    [0.88, 0.88, 0.88],
];
const SIDINGS: [[f32; 3]; 4] = [
    [0.90, 0.91, 0.90],
    [0.56, 0.66, 0.74],
    [0.66, 0.30, 0.26],
    [0.62, 0.66, 0.54],
];
const STONES: [[f32; 3]; 2] = [[0.80, 0.76, 0.68], [0.66, 0.66, 0.66]];
const ROOFS: [[f32; 3]; 5] = [
    [0.72, 0.36, 0.26],
    [0.40, 0.40, 0.43],
    [0.55, 0.40, 0.32],
    [0.34, 0.38, 0.36],
    [0.62, 0.45, 0.36],
];
const DOORS: [[f32; 3]; 6] = [
    [0.55, 0.20, 0.17],
    [0.18, 0.34, 0.30],
    [0.20, 0.28, 0.45],
    [0.52, 0.36, 0.22],
    [0.90, 0.90, 0.88],
    [0.30, 0.30, 0.32],
];
/// Paints of cars.
pub(crate) const PAINTS: [[f32; 3]; 8] = [
    [0.88, 0.88, 0.88],
    [0.62, 0.64, 0.67],
    [0.14, 0.14, 0.16],
    [0.60, 0.11, 0.12],
    [0.14, 0.25, 0.48],
    [0.30, 0.36, 0.33],
    [0.78, 0.72, 0.60],
    [0.24, 0.42, 0.62],
];

impl Palette {
    /// Draws the images and makes the materials.
    pub fn new(builder: &mut SceneBuilder, seed: u64) -> Self {
        use SemanticClass as C;
        let s = mix(seed ^ Purpose::Palette as u64);
        let m = &mut Mixer { builder };
        // Each image has a number of its own: a new one takes the next, and changes no other.
        let grass = m.image(images::grass(s));
        let grit = m.image(images::grit(s ^ 1));
        let slabs = m.image(images::slabs(s ^ 2));
        let setts = m.image(images::setts(s ^ 3));
        let earth = m.image(images::earth(s ^ 4));
        let plaster = m.image(images::plaster(s ^ 5));
        let bricks = m.image(images::bricks(s ^ 6));
        let stones = m.image(images::stones(s ^ 7));
        let tiles = m.image(images::tiles(s ^ 8));
        let foliage = m.image(images::foliage(s ^ 9));
        let blossoms = m.image(images::blossoms(s ^ 15));
        let leaves = m.image(images::leaves(s ^ 10));
        let bark = m.image(images::bark(s ^ 11));
        let railings = m.image(openings::railings());
        let siding = m.image(images::siding(s ^ 12));
        let pickets = m.image(openings::pickets());
        let ripples = m.image(images::ripples(s ^ 13));
        let kerbstones = m.image(images::kerbstones(s ^ 14));
        let stripes = m.image(openings::stripes());
        let walls = [
            // Eight bricks of 24 cm, and 24 courses of 8 cm, with their mortar.
            tiled(bricks, 1.92),
            tiled(plaster, 3.0),
            tiled(siding, 2.0),
            tiled(stones, 2.4),
        ];
        let facades = facades(m, walls);
        // Ranges in the order in which `facades` lists them. Plasters count twice, and sidings are
        // left out.
        let plasters = BRICKS.len()..BRICKS.len() + PLASTERS.len();
        let town = facades[..2]
            .iter()
            .chain(&facades[plasters.clone()])
            .chain(&facades[plasters]);
        Self {
            // First, since `facades` moves into the field below.
            town_facades: town
                .chain(&facades[facades.len() - STONES.len()..])
                .copied()
                .collect(),
            facades,
            grass: m.surface(C::Grass, [1.0; 3], 90, Some(tiled(grass, 2.4))),
            asphalt: m.surface(C::Road, [0.37, 0.37, 0.39], 22, Some(tiled(grit, 1.8))),
            worn_asphalt: m.surface(C::Road, [0.47, 0.46, 0.45], 26, Some(tiled(grit, 2.5))),
            paving: m.surface(C::Pavement, [0.76, 0.74, 0.70], 55, Some(tiled(slabs, 1.8))),
            kerb: m.surface(
                C::Pavement,
                [0.66, 0.66, 0.66],
                60,
                Some(tiled(kerbstones, 1.0)),
            ),
            path: m.surface(C::Pavement, [0.72, 0.62, 0.52], 50, Some(tiled(setts, 2.2))),
            gravel: m.surface(C::Pavement, [0.78, 0.73, 0.64], 60, Some(tiled(grit, 2.0))),
            earth: m.surface(C::Ground, [1.0; 3], 45, Some(tiled(earth, 1.5))),
            water: m.surface(C::Water, [0.25, 0.38, 0.45], 5, Some(tiled(ripples, 12.0))),
            quay: m.surface(C::Wall, [0.74, 0.71, 0.66], 70, Some(tiled(stones, 1.6))),
            hills: m.surface(
                C::Ground,
                [0.58, 0.58, 0.54],
                90,
                Some(tiled(foliage, 90.0)),
            ),
            kerbstone: m.surface(
                C::Kerb,
                [0.72, 0.72, 0.70],
                62,
                Some(tiled(kerbstones, 1.0)),
            ),
            patch: m.surface(C::Road, [0.30, 0.30, 0.31], 20, Some(tiled(grit, 1.8))),
            marking: m.surface(C::Road, [0.90, 0.90, 0.88], 160, Some(tiled(plaster, 1.0))),
            doorstep: m.surface(
                C::Pavement,
                [0.62, 0.60, 0.58],
                70,
                Some(tiled(plaster, 1.2)),
            ),
            plinths: m.tinted(
                C::Building,
                &[[0.50, 0.49, 0.48], [0.62, 0.58, 0.52]],
                60,
                tiled(plaster, 2.0),
            ),
            trims: m.tinted(
                C::Building,
                &[[0.94, 0.94, 0.92], [0.78, 0.74, 0.66], [0.38, 0.38, 0.40]],
                90,
                tiled(plaster, 2.0),
            ),
            pitched_roofs: m.tinted(C::Building, &ROOFS, 60, tiled(tiles, 3.2)),
            flat_roof: m.surface(C::Building, [0.62, 0.61, 0.60], 50, Some(tiled(grit, 3.0))),
            windows: windows(m, s),
            shuttered: shuttered(m, s),
            shop_windows: [0, 1].map(|look| {
                let image = m.image(openings::shop_window(look, s));
                m.glass(C::Building, [1.0; 3], 25, Some(tiled(image, 1.0)))
                    .material
            }),
            signs: [
                [0.16, 0.20, 0.28],
                [0.40, 0.14, 0.14],
                [0.20, 0.30, 0.22],
                [0.86, 0.83, 0.74],
            ]
            .map(|c| m.surface(C::Building, c, 80, Some(tiled(plaster, 1.0))))
            .to_vec(),
            awnings: [
                [0.70, 0.22, 0.20],
                [0.24, 0.42, 0.34],
                [0.26, 0.36, 0.56],
                [0.82, 0.62, 0.30],
            ]
            .map(|c| m.surface(C::Building, c, 90, Some(tiled(stripes, 1.2))))
            .to_vec(),
            quoins: m.surface(
                C::Building,
                [0.86, 0.83, 0.76],
                85,
                Some(tiled(stones, 1.4)),
            ),
            downpipe: m.surface(
                C::Building,
                [0.50, 0.51, 0.52],
                60,
                Some(tiled(plaster, 1.0)),
            ),
            doors: leaves_of(
                m,
                C::Door,
                &DOORS,
                &[openings::door(false), openings::door(true)],
            ),
            garages: leaves_of(
                m,
                C::Building,
                &[[0.92; 3], [0.60, 0.62, 0.64], [0.50, 0.38, 0.28]],
                &[openings::garage()],
            ),
            free_walls: free_walls(m, bricks, plaster, stones),
            coping: m.surface(C::Wall, [0.70, 0.69, 0.67], 70, Some(tiled(plaster, 1.0))),
            pickets: [[0.93, 0.93, 0.90], [0.58, 0.44, 0.32], [0.38, 0.45, 0.40]]
                .map(|c| m.cutout(C::Wall, c, 70, tiled(pickets, 1.0)))
                .to_vec(),
            railings: m.cutout(C::Wall, [0.20, 0.21, 0.22], 40, tiled(railings, 1.2)),
            balcony_railings: m.cutout(C::Building, [0.24, 0.25, 0.27], 40, tiled(railings, 1.0)),
            hedge: m.surface(C::Hedge, [0.52, 0.62, 0.46], 110, Some(tiled(foliage, 1.2))),
            flowers: [
                [0.95, 0.62, 0.72],
                [1.0, 0.92, 0.50],
                [0.98, 0.98, 0.95],
                [0.72, 0.60, 0.92],
            ]
            .map(|c| m.surface(C::Vegetation, c, 110, Some(tiled(blossoms, 1.0))))
            .to_vec(),
            bark: m.surface(C::Vegetation, [1.0; 3], 45, Some(tiled(bark, 0.5))),
            // Above 1, since the image is brown already and is multiplied by the colour.
            pale_bark: m.surface(C::Vegetation, [1.9, 2.2, 2.5], 80, Some(tiled(bark, 0.7))),
            crowns: crowns(m, foliage, leaves),
            needles: [[0.34, 0.46, 0.34], [0.28, 0.40, 0.30]]
                .map(|c| m.surface(C::Vegetation, c, 90, Some(tiled(foliage, 1.0))))
                .to_vec(),
            metal: m.plain(C::Furniture, [0.58, 0.60, 0.62]),
            dark_metal: m.plain(C::Furniture, [0.18, 0.20, 0.20]),
            lamp_glass: m.lamp([0.96, 0.95, 0.86]),
            wood: m.surface(C::Furniture, [1.30, 1.05, 0.80], 60, Some(tiled(bark, 0.8))),
            red: m.plain(C::Furniture, [0.74, 0.12, 0.10]),
            yellow: m.plain(C::Furniture, [0.90, 0.72, 0.15]),
            green: m.plain(C::Furniture, [0.20, 0.36, 0.26]),
            car_paints: PAINTS.map(|c| m.plain(C::Vehicle, c)).to_vec(),
            car_glass: m.glass(C::Vehicle, [0.10, 0.13, 0.16], 8, None),
            tyre: m.surface(C::Vehicle, [0.07, 0.07, 0.07], 8, None),
            rim: m.plain(C::Vehicle, [0.58, 0.60, 0.62]),
            car_lights: [[0.94, 0.94, 0.90], [0.60, 0.06, 0.06]]
                .map(|c| m.surface(C::Vehicle, c, 200, None)),
        }
    }
}

fn facades(m: &mut Mixer<'_>, [bricks, plaster, siding, stones]: [Image; 4]) -> Vec<Surface> {
    let class = SemanticClass::Building;
    let mut all = m.tinted(class, &BRICKS, 65, bricks);
    all.extend(m.tinted(class, &PLASTERS, 110, plaster));
    all.extend(m.tinted(class, &SIDINGS, 95, siding));
    all.extend(m.tinted(class, &STONES, 80, stones));
    all
}

fn free_walls(
    m: &mut Mixer<'_>,
    bricks: TextureId,
    plaster: TextureId,
    stones: TextureId,
) -> Vec<Surface> {
    let kinds = [
        ([0.70, 0.42, 0.34], tiled(bricks, 1.92)),
        ([0.86, 0.83, 0.76], tiled(plaster, 3.0)),
        ([0.72, 0.69, 0.63], tiled(stones, 1.6)),
    ];
    kinds
        .map(|(color, image)| m.surface(SemanticClass::Wall, color, 75, Some(image)))
        .to_vec()
}

fn windows(m: &mut Mixer<'_>, seed: u64) -> Vec<[MaterialId; 2]> {
    let styles = [
        ([0.96, 0.96, 0.95], Glazing::Casements),
        ([0.95, 0.95, 0.92], Glazing::Sash),
        ([0.24, 0.25, 0.27], Glazing::Single),
        ([0.48, 0.33, 0.22], Glazing::Casements),
    ];
    styles
        .map(|(frame, glazing)| {
            [false, true].map(|curtains| {
                let image = m.image(openings::window(frame, glazing, curtains, seed));
                // Glass reflects little of the LiDAR light; frame and curtains reflect some.
                m.glass(
                    SemanticClass::Building,
                    [1.0; 3],
                    25,
                    Some(tiled(image, 1.0)),
                )
                .material
            })
        })
        .to_vec()
}

fn shuttered(m: &mut Mixer<'_>, seed: u64) -> Vec<[MaterialId; 2]> {
    let colors = [
        [0.30, 0.44, 0.36],
        [0.36, 0.46, 0.58],
        [0.52, 0.36, 0.26],
        [0.86, 0.86, 0.84],
        [0.52, 0.22, 0.20],
    ];
    colors
        .map(|color| {
            [false, true].map(|curtains| {
                let window =
                    openings::window([0.95, 0.95, 0.93], Glazing::Casements, curtains, seed);
                let image = m.image(openings::with_shutters(
                    &window,
                    color,
                    openings::SHUTTERED_WIDTHS,
                ));
                m.glass(
                    SemanticClass::Building,
                    [1.0; 3],
                    35,
                    Some(tiled(image, 1.0)),
                )
                .material
            })
        })
        .to_vec()
}

fn leaves_of(
    m: &mut Mixer<'_>,
    class: SemanticClass,
    colors: &[[f32; 3]],
    images: &[Texture],
) -> Vec<MaterialId> {
    let images: Vec<TextureId> = images.iter().map(|t| m.image(t.clone())).collect();
    let mut all = Vec::new();
    for color in colors {
        all.extend(
            images
                .iter()
                .map(|i| m.surface(class, *color, 70, Some(tiled(*i, 1.0))).material),
        );
    }
    all
}

/// A dense core and a shell with holes for each kind of crown.
fn crowns(m: &mut Mixer<'_>, foliage: TextureId, leaves: TextureId) -> Vec<Crown> {
    let colors = [
        [0.62, 0.72, 0.48],
        [0.50, 0.66, 0.42],
        [0.74, 0.76, 0.42],
        [0.44, 0.58, 0.40],
        [0.58, 0.62, 0.52],
        [0.94, 0.84, 0.50],
    ];
    colors
        .map(|c| {
            // The inside of a crown is darker than its leaves outside.
            let core = c.map(|v| v * 0.6);
            Crown {
                core: m.surface(
                    SemanticClass::Vegetation,
                    core,
                    100,
                    Some(tiled(foliage, 1.6)),
                ),
                shell: m.cutout(SemanticClass::Vegetation, c, 120, tiled(leaves, 2.0)),
            }
        })
        .to_vec()
}
