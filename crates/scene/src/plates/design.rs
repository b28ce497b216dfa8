//! How the plates of a building look: material, colours, typeface, size.

use openbench_osm::draws::{between, chance, pick};
use rand_pcg::Pcg64Mcg;

use super::typefaces::{self, Style, TypefaceSet};

/// Widest plate, metres. Longer texts are set in lower letters.
const WIDEST_M: f64 = 0.85;
/// Lowest letters of a plate that says where one is, metres.
const LOWEST_CAPITAL_M: f64 = 0.06;

/// An sRGB colour.
pub(super) type Color = [u8; 3];

/// What a plate is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Make {
    /// Enamelled sheet, domed.
    Enamel,
    /// Engraved brass.
    Brass,
    /// Brushed steel or aluminium.
    Steel,
    /// Engraved stone.
    Stone,
    /// A sticker.
    Sticker,
    /// Single figures on the wall, without a board.
    Cast,
    /// A glazed tile with a painted border.
    Tile,
    /// A painted board.
    Wood,
    /// Plastic or painted aluminium, in large figures.
    Acrylic,
    /// A panel of bells with names, under the number.
    Bells,
}

impl Make {
    /// All of them.
    pub const ALL: [Self; 10] = [
        Self::Enamel,
        Self::Brass,
        Self::Steel,
        Self::Stone,
        Self::Sticker,
        Self::Cast,
        Self::Tile,
        Self::Wood,
        Self::Acrylic,
        Self::Bells,
    ];

    /// Name, as in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::Enamel => "enamel",
            Self::Brass => "brass",
            Self::Steel => "steel",
            Self::Stone => "stone",
            Self::Sticker => "sticker",
            Self::Cast => "cast figures",
            Self::Tile => "tile",
            Self::Wood => "wood",
            Self::Acrylic => "acrylic",
            Self::Bells => "bells",
        }
    }

    /// Thickness of the plate, metres.
    pub(crate) fn thickness_m(self) -> f64 {
        match self {
            Self::Sticker => 0.002,
            Self::Enamel | Self::Brass | Self::Steel => 0.006,
            Self::Tile | Self::Acrylic => 0.012,
            Self::Cast | Self::Bells => 0.02,
            Self::Stone | Self::Wood => 0.025,
        }
    }

    /// Least and largest height of its capitals, metres.
    fn capitals_m(self) -> [f64; 2] {
        match self {
            Self::Bells => [0.06, 0.08],
            Self::Brass | Self::Sticker => [0.06, 0.10],
            Self::Steel | Self::Stone | Self::Tile | Self::Wood => [0.07, 0.14],
            Self::Enamel => [0.08, 0.16],
            Self::Cast | Self::Acrylic => [0.12, 0.25],
        }
    }

    fn styles(self) -> &'static [Style] {
        use Style::*;
        match self {
            Self::Enamel => &[Plain, Condensed, Serif, Slab, Rounded],
            Self::Brass => &[Serif, Engraved, Slab, Plain],
            Self::Steel => &[Plain, Condensed, Rounded, Engraved],
            Self::Stone => &[Serif, Engraved, Slab, Deco],
            Self::Sticker => &[Plain, Rounded, Typewriter, Hand, Stencil],
            Self::Cast => &[Plain, Condensed, Serif, Slab, Stencil, Deco],
            Self::Tile => &[Hand, Serif, Deco],
            Self::Wood => &[Hand, Slab, Stencil],
            Self::Acrylic => &[Plain, Condensed, Rounded],
            Self::Bells => &[Plain, Condensed, Typewriter],
        }
    }

    /// Colours of board and letters.
    fn colors(self) -> &'static [[Color; 2]] {
        const WHITE: Color = [244, 243, 238];
        const BLACK: Color = [22, 22, 24];
        match self {
            Self::Enamel => &[
                [[22, 48, 122], WHITE],
                [[22, 48, 122], WHITE],
                [WHITE, BLACK],
                [WHITE, [24, 46, 120]],
                [[18, 74, 48], WHITE],
                [[142, 26, 30], WHITE],
                [BLACK, WHITE],
            ],
            Self::Brass => &[
                [[186, 150, 78], [38, 26, 12]],
                [[168, 132, 84], [28, 20, 12]],
            ],
            Self::Steel => &[
                [[178, 181, 184], [26, 28, 32]],
                [[158, 162, 166], [20, 22, 26]],
                [[186, 188, 190], [24, 44, 92]],
            ],
            Self::Stone => &[
                [[66, 66, 70], [226, 222, 208]],
                [[48, 48, 52], [212, 176, 92]],
                [[200, 192, 174], [44, 38, 34]],
                [[150, 148, 144], [26, 24, 24]],
            ],
            Self::Sticker => &[
                [WHITE, BLACK],
                [BLACK, WHITE],
                [[240, 200, 40], BLACK],
                [[230, 230, 226], [150, 24, 28]],
            ],
            // The second one is taken on bright walls, see `Design::on_wall`.
            Self::Cast => &[[BLACK, WHITE], [WHITE, BLACK]],
            Self::Tile => &[
                [[240, 238, 228], [30, 56, 130]],
                [[238, 232, 210], [40, 34, 30]],
                [[236, 236, 230], [20, 84, 60]],
            ],
            Self::Wood => &[
                [[120, 78, 46], [240, 232, 212]],
                [[226, 216, 196], [52, 36, 28]],
                [[70, 88, 74], [236, 230, 214]],
            ],
            Self::Acrylic => &[
                [[46, 50, 54], WHITE],
                [WHITE, [46, 50, 54]],
                [[28, 66, 60], WHITE],
                [[206, 208, 210], BLACK],
            ],
            Self::Bells => &[
                [[172, 175, 178], BLACK],
                [[190, 158, 92], BLACK],
                [BLACK, WHITE],
            ],
        }
    }
}

/// The outline of a plate.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Outline {
    Square,
    Rounded,
    Oval,
}

/// A line around the board, near its edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Rim {
    None,
    Single,
    Double,
}

/// How the plates of a building look.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Design {
    /// What they are made of.
    pub make: Make,
    /// Height of the capitals of the largest line, metres.
    pub capital_m: f64,
    pub(super) typeface: usize,
    /// For texts that the first one has no characters for.
    pub(super) chinese: usize,
    pub(super) paper: Color,
    pub(super) ink: Color,
    pub(super) outline: Outline,
    pub(super) rim: Rim,
    pub(super) screws: bool,
    /// Longer texts are set in lower letters, metres.
    pub(super) widest_m: f64,
    /// But in no lower ones than these, metres.
    pub(super) lowest_m: f64,
    /// Seed of grain, scratches and dirt.
    pub(super) grain: u64,
}

impl Design {
    /// The design of a building.
    pub fn draw(draws: &mut Pcg64Mcg, set: TypefaceSet) -> Self {
        use Make::*;
        // Enamel and metal are most common, and one building in fourteen has painted wood.
        let make = pick(
            draws,
            &[
                Enamel, Enamel, Enamel, Brass, Steel, Steel, Stone, Sticker, Cast, Cast, Tile,
                Wood, Acrylic, Acrylic, Bells,
            ],
        );
        Self::of(make, draws, set)
    }

    /// A design of a make.
    pub fn of(make: Make, draws: &mut Pcg64Mcg, set: TypefaceSet) -> Self {
        let [least, largest] = make.capitals_m();
        let [paper, ink] = pick(draws, make.colors());
        let outline = match make {
            Make::Enamel => pick(
                draws,
                &[
                    Outline::Square,
                    Outline::Square,
                    Outline::Rounded,
                    Outline::Oval,
                ],
            ),
            Make::Brass | Make::Wood => pick(draws, &[Outline::Square, Outline::Rounded]),
            _ => Outline::Square,
        };
        let rims: &[Rim] = match make {
            Make::Enamel => &[Rim::Single, Rim::Single, Rim::None],
            Make::Tile => &[Rim::Double],
            Make::Brass | Make::Wood | Make::Stone => &[Rim::None, Rim::None, Rim::Single],
            _ => &[Rim::None],
        };
        Self {
            make,
            capital_m: between(draws, least, largest),
            typeface: pick(draws, &typefaces::of(set, make.styles())),
            chinese: pick(draws, &typefaces::of(set, &[Style::Chinese])),
            paper,
            ink,
            outline,
            rim: pick(draws, rims),
            screws: chance(draws, 0.6),
            widest_m: WIDEST_M,
            lowest_m: LOWEST_CAPITAL_M,
            grain: u64::from(pick(draws, &[0_u32, 1, 2, 3, 4, 5, 6, 7])),
        }
    }

    /// The same on a wall of some brightness, 0 to 1: single figures need a contrast to it.
    #[must_use]
    pub fn on_wall(self, brightness: f32) -> Self {
        if self.make != Make::Cast {
            return self;
        }
        let [dark_wall, bright_wall] = [0, 1].map(|i| Make::Cast.colors()[i]);
        let [paper, ink] = if brightness < 0.45 {
            dark_wall
        } else {
            bright_wall
        };
        Self { paper, ink, ..self }
    }

    /// The same in letters of another height, metres.
    #[must_use]
    pub fn with_capitals(self, capital_m: f64) -> Self {
        Self { capital_m, ..self }
    }

    /// Whether its typefaces have all characters of a text.
    pub fn has(&self, text: &str) -> bool {
        let own = &typefaces::typefaces()[self.typeface];
        let chinese = &typefaces::typefaces()[self.chinese];
        own.has(text) || chinese.has(text)
    }

    /// Name of its typeface.
    pub fn typeface(&self) -> &'static str {
        typefaces::typefaces()[self.typeface].name
    }
}

/// What time and light have done to a plate.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Wear {
    /// Dirt, 0 to 1.
    pub dirt: f64,
    /// Middle of a streak of glare, from the left edge (0) to the right one (1).
    pub glare: Option<f64>,
}

impl Wear {
    /// Whether the plate is not harder to read for it.
    pub fn is_slight(&self) -> bool {
        self.dirt < 0.3 && self.glare.is_none()
    }
}
