//! Reading door plates in camera images.
//!
//! | module | what it holds |
//! |---|---|
//! | [`reader`] | [`PlateReader`]: an image in, the texts on it with their corners out |
//! | [`ppocr`] | [`PpOcr`]: PP-OCR text detection and recognition on the CPU, in pure Rust |
//! | [`vlm`] | [`VlmReader`]: the same question put to a vision-language model |
//! | [`in_turn`] | [`InTurn`]: readers that stand in for each other |
//! | [`registry`], [`entry`] | [`ReaderRegistry`]: readers by name, those of this crate and any that are added |
//! | [`error`] | [`ReaderError`]: why an image was not read |
//! | [`address_text`] | [`parse_unit`]: from the text on a plate to a unit's name |

pub mod address_text;
pub mod entry;
pub mod error;
pub mod in_turn;
pub mod ppocr;
pub mod reader;
pub mod registry;
pub mod vlm;

pub use address_text::{UnitText, parse_unit};
pub use entry::{ReaderContext, ReaderEntry, ReaderSettings};
pub use error::{AnswerError, ReaderError};
pub use in_turn::InTurn;
pub use ppocr::{PpOcr, PpOcrSettings};
pub use reader::{PlateReader, PlateReading};
pub use registry::{ReaderRegistry, RegistryError};
pub use vlm::VlmReader;
