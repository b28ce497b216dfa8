//! Extensions from outside the project's crates: each is one file, and one line below.
//!
//! ```console
//! $ cargo run --release -p extensions -- run --agent beeline
//! $ cargo run --release -p extensions -- run --set motion=dynamic-window
//! $ cargo run --release -p extensions -- run --set localizer=wheels
//! $ cargo run --release -p extensions -- run --set reader=contrast
//! ```

mod beeline;
mod contrast;
mod dynamic_window;
mod wheels;

use std::process::ExitCode;

use openbench::Extensions;

fn main() -> ExitCode {
    let extensions = Extensions::new()
        .with_agent("beeline", "drives straight", beeline::make)
        .with_reader_part("contrast", "PP-OCR, stretched contrast", contrast::part())
        .with_local_planner(
            "dynamic-window",
            "Dynamic Window Approach",
            dynamic_window::make,
        )
        .with_localizer("wheels", "wheels alone", wheels::make);
    openbench::main_with(extensions)
}
