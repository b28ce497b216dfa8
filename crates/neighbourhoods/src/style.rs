//! Characters of neighbourhoods, and how large each is.

use openbench_osm::draws::{between, pick};
use rand_pcg::Pcg64Mcg;

use crate::kind::Kind;
use crate::plan::Half;

/// The character of a neighbourhood.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Style {
    /// Detached and semi-detached houses along curved streets, loops and closes.
    Suburb,
    /// Houses of flats in closed rows around courts.
    Blocks,
    /// Rows of terraced houses along parallel streets.
    Terraces,
    /// Slabs and towers of flats in greenery, with access roads and parking.
    Slabs,
    /// A winding street with farms and houses at all distances from it.
    Village,
}

impl Style {
    /// All characters.
    pub const ALL: [Self; 5] = [
        Self::Suburb,
        Self::Blocks,
        Self::Terraces,
        Self::Slabs,
        Self::Village,
    ];

    /// The name.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Suburb => "suburb",
            Self::Blocks => "blocks",
            Self::Terraces => "terraces",
            Self::Slabs => "slabs",
            Self::Village => "village",
        }
    }

    pub(crate) fn draw(draws: &mut Pcg64Mcg) -> Self {
        pick(draws, &Self::ALL)
    }

    /// Half the sides of the ground, metres: few large buildings need more of it than many small
    /// ones.
    pub(crate) fn ground(self, kind: Kind, draws: &mut Pcg64Mcg) -> Half {
        let room = match self {
            Self::Suburb => 1.0,
            Self::Blocks => 1.05,
            Self::Terraces => 0.9,
            Self::Slabs => 1.25,
            Self::Village => 1.05,
        };
        let (x, y) = match kind {
            Kind::Small => (between(draws, 31.0, 38.0), between(draws, 26.0, 31.0)),
            Kind::Medium => (between(draws, 52.0, 66.0), between(draws, 48.0, 58.0)),
            Kind::Large => (between(draws, 82.0, 105.0), between(draws, 60.0, 76.0)),
        };
        Half {
            x: x * room,
            y: y * room,
        }
    }
}
