#![no_main]
//! Descriptions and images of ROS's map server: whatever the bytes are, a grid or an error.

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use openbench_motion::costmap::map_server::{decode, describe};

const PLAIN: &str = "image: a.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n";

fuzz_target!(|bytes: &[u8]| {
    let path = Path::new(if bytes.starts_with(b"\x89PNG") {
        "a.png"
    } else {
        "a.pgm"
    });
    let _ = describe(&String::from_utf8_lossy(bytes), path);
    if let Ok(plain) = describe(PLAIN, path) {
        if let Ok(grid) = decode(&plain, bytes, path) {
            assert_eq!(grid.cells.len(), grid.grid.len());
        }
    }
});
