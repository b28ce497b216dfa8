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
        .with_agent("beeline", "drives straight", |_| {
            Ok(Box::new(beeline::Beeline::default()))
        })
        .with_reader("contrast", "PP-OCR on stretched contrast", || {
            contrast::Contrast::boxed()
        })
        .with_local_planner("dynamic-window", "DWA", |robot| {
            dynamic_window::boxed(robot)
        })
        .with_localizer("wheels", "wheels alone", |robot| {
            Box::new(wheels::Wheels::new(robot))
        });
    openbench::main_with(extensions)
}
