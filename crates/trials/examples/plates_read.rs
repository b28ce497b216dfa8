//! The share of legible plates as in streets that PP-OCR reads, and those that it does not.
//!
//! ```text
//! cargo run --release -p openbench-trials --example plates_read -- [FIRST_SEED [SEEDS [EACH]]]
//! ```

#![allow(clippy::print_stdout)]

use openbench_models::ModelStore;
use openbench_trials::fairness::plates_that_are_read;
use openbench_vision::PpOcr;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let number = |at: usize, usual: u64| -> Result<u64, std::num::ParseIntError> {
        std::env::args()
            .nth(at)
            .map_or(Ok(usual), |text| text.parse())
    };
    let (first, seeds, each) = (number(1, 10_000)?, number(2, 8)?, number(3, 100)?);
    let mut reader = PpOcr::from_store(&ModelStore::from_environment()?)?;
    let fairness = plates_that_are_read(&mut reader, first..first + seeds, each as usize)?;
    for missed in &fairness.missed {
        println!(
            "`{}` read as `{}` ({})",
            missed.says, missed.read, missed.design
        );
    }
    println!(
        "seeds {first}..{}: {} of {} legible Latin plates read, {:.1} %",
        first + seeds,
        fairness.shown - fairness.missed.len(),
        fairness.shown,
        100.0 * fairness.share()
    );
    Ok(())
}
