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
//! | [`readers`] | readers by name, and those of a list |
//! | `part` | [`ReaderPart`], [`ReaderContext`]: what readers are made from |
//! | `error` | [`ReaderError`]: errors of reading an image |
//! | `address_text` | [`parse_unit`]: the unit that the text of a plate names |

mod address_text;
mod error;
mod in_turn;
mod part;
pub mod ppocr;
mod reader;
pub mod readers;
pub mod vlm;

pub use address_text::{UnitText, parse_unit};
pub use error::{AnswerError, Cause, ReaderError};
pub use in_turn::InTurn;
pub use part::{OpenModel, ReaderContext, ReaderPart, ReaderSettings};
pub use ppocr::{PpOcr, PpOcrSettings};
pub use reader::{MAX_SIDE_PX, PlateReader, PlateReading};
pub use vlm::VlmReader;
