//! Door plates of real streets: what they say, how they look, and how many are missing, hidden,
//! dirty.
//!
//! | module | contents |
//! |---|---|
//! | `settings` | [`StreetPlates`]: the shares that are drawn; [`DrawnPlates`]: what was drawn |
//! | `wording` | [`Facts`] of an address, and what a plate says of them |
//! | `design` | [`Design`]: material, colours, typeface, size; [`Wear`] |
//! | `typefaces` | the fonts, those for training and those for tests |
//! | `lettering` | lines of text as coverage |
//! | `face` | [`draw_face`]: the image of a plate |
//! | `signs` | other text of streets |
//! | `sample` | plates without a world: a contact sheet, and tests of readers |
//!
//! The plates of published worlds, 1.0 x 0.45 m, are in [`plate`](crate::plate).

mod design;
mod face;
mod lettering;
mod sample;
mod settings;
mod signs;
mod typefaces;
mod wording;

pub use design::{Design, Make, Wear};
pub use face::{Extent, Face, draw_face};
pub use sample::{SampledPlate, contact_sheet, sampled_plates};
pub use settings::{DrawnPlates, StreetPlates};
pub(crate) use signs::{SignKind, draw_sign};
pub use typefaces::{
    FIRST_TEST_SEED, LAST_TEST_SEED, Style, Typeface, TypefaceError, TypefaceSet, read_font,
    typefaces,
};
pub use wording::{Content, Facts, Language, Line, Wording};
