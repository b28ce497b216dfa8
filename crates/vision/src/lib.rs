#![doc = include_str!("../README.md")]
//!
//! # Modules
//!
//! | module | what it does |
//! |---|---|
//! | `reader` | [`PlateReader`]: the contract of a reader: image in, texts out |
//! | [`ppocr`] | [`PpOcr`]: PP-OCR text detection and recognition on the CPU |
//! | [`vlm`] | [`VlmReader`]: a vision-language model as reader |
//! | `in_turn` | [`InTurn`]: several readers, the next where one fails |
//! | `registry`, `entry` | [`ReaderRegistry`], [`ReaderEntry`]: readers by name |
//! | `error` | [`ReaderError`]: errors of reading an image |
//! | `address_text` | [`parse_unit`]: the unit that the text of a plate names |

mod address_text;
mod entry;
mod error;
mod in_turn;
pub mod ppocr;
mod reader;
mod registry;
pub mod vlm;

pub use address_text::{UnitText, parse_unit};
pub use entry::{OpenModel, ReaderContext, ReaderEntry, ReaderSettings};
pub use error::{AnswerError, Cause, ReaderError};
pub use in_turn::InTurn;
pub use ppocr::{PpOcr, PpOcrSettings};
pub use reader::{MAX_SIDE_PX, PlateReader, PlateReading};
pub use registry::{ReaderRegistry, RegistryError};
pub use vlm::VlmReader;
