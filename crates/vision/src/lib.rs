//! Reading door plates in camera images.
//!
//! | module | what it holds |
//! |---|---|
//! | [`reader`] | [`PlateReader`]: an image in, the texts on it with their corners out |
//! | [`ppocr`] | [`PpOcr`]: PP-OCR text detection and recognition on the CPU, in pure Rust |
//! | [`vlm`] | [`VlmReader`]: the same question put to a vision-language model |
//! | [`in_turn`] | [`InTurn`]: readers that stand in for each other |
//! | [`address_text`] | [`parse_unit`]: from the text on a plate to a unit's name |

pub mod address_text;
pub mod in_turn;
pub mod ppocr;
pub mod reader;
pub mod vlm;

pub use address_text::{UnitText, parse_unit};
pub use in_turn::InTurn;
pub use ppocr::{PpOcr, PpOcrSettings};
pub use reader::{PlateReader, PlateReading, ReaderError};
pub use vlm::VlmReader;
