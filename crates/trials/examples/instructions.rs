//! Generates instructions from the templates in `data/instructions`, one JSON object per line.
//!
//!     cargo run -p openbench-trials --example instructions -- development|test [SEED]
#![expect(clippy::print_stdout, reason = "an example prints its output")]

use std::error::Error;

use openbench_trials::instructions::{Split, generated::generated};

fn main() -> Result<(), Box<dyn Error>> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let split = match words.first().map(String::as_str) {
        Some("development") => Split::Development,
        Some("test") => Split::Test,
        _ => return Err("usage: instructions development|test [SEED]".into()),
    };
    let seed = words.get(1).map_or(Ok(1), |seed| seed.parse())?;
    for case in generated(split, seed) {
        println!("{}", serde_json::to_string(&case)?);
    }
    Ok(())
}
