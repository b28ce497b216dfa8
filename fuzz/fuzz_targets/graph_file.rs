#![no_main]

use libfuzzer_sys::fuzz_target;
use openbench_fuzz::use_roads;
use openbench_routing::store;

// The header is made good, or nothing would be looked at but the checksum.
fuzz_target!(|bytes: &[u8]| {
    let mut file = bytes.to_vec();
    if file.len() < 64 {
        return;
    }
    let length = file.len() as u64;
    file[..16].copy_from_slice(b"OBROADS\0\x02\0\0\0\x14\0\0\0");
    file[16..24].copy_from_slice(&length.to_le_bytes());
    let sum = blake3::hash(&file[64..]);
    file[32..64].copy_from_slice(sum.as_bytes());
    let folder = tempfile::tempdir().expect("a folder for temporary files");
    let path = folder.path().join("map.graph");
    std::fs::write(&path, file).expect("room for a file");
    if let Ok(roads) = store::read(&path) {
        use_roads(roads);
    }
});
