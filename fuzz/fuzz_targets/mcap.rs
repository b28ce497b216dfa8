#![no_main]

use libfuzzer_sys::fuzz_target;
use openbench_logs::LogReader;
use openbench_logs::messages::{
    CompressedImage, CustomMsg, Imu, JointState, Odometry, Path, PointCloud2, PoseStamped,
};

fuzz_target!(|bytes: &[u8]| {
    let Ok(log) = LogReader::new(bytes) else {
        return;
    };
    for message in log.take(1000) {
        let Ok(message) = message else { return };
        let _ = message.decode::<Imu>();
        let _ = message.decode::<JointState>();
        let _ = message.decode::<Odometry>();
        let _ = message.decode::<Path>();
        let _ = message.decode::<PointCloud2>().map(|cloud| cloud.to_scan());
        let _ = message.decode::<CustomMsg>().map(|points| points.to_scan());
        let _ = message.decode::<PoseStamped>();
        let _ = message.decode::<CompressedImage>();
    }
});
