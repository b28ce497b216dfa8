#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use openbench_fuzz::Folder;

static FOLDER: LazyLock<Folder> = LazyLock::new(Folder::new);

fuzz_target!(|bytes: &[u8]| {
    let _ = FOLDER.import(bytes);
});
