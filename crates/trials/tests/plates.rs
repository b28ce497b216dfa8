//! Plates as in streets are fair: a reader of texts can read them.

#[path = "../../skips.rs"]
mod skips;

use openbench_models::{ModelStore, catalogue};
use openbench_trials::fairness::plates_that_are_read;
use openbench_vision::PpOcr;
use skips::skipped;

#[test]
fn legible_plates_are_read() {
    let store = ModelStore::from_environment().ok();
    let store = store.filter(|store| {
        let files = catalogue::named("ppocr-v4");
        files.into_iter().all(|file| store.contains(file))
    });
    let Some(store) = store else {
        skipped("there are no files of PP-OCR; run `openbench models pull ppocr-v4`");
        return;
    };
    let mut reader = PpOcr::from_store(&store).unwrap();
    let fairness = plates_that_are_read(&mut reader, 10_000..10_001, 80).unwrap();
    assert!(fairness.shown > 40, "{}", fairness.shown);
    assert!(fairness.share() >= 0.9, "{:#?}", fairness.missed);
}
