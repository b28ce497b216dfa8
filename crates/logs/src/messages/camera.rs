//! `sensor_msgs/CameraInfo`.

use openbench_core::{CameraIntrinsics, Distortion, SimTime};

use super::{Definition, Header, Message};
use crate::cdr::{CdrError, CdrReader, CdrWriter};

const REGION_OF_INTEREST: &Definition = &Definition {
    name: "sensor_msgs/RegionOfInterest",
    fields: "uint32 x_offset\nuint32 y_offset\nuint32 height\nuint32 width\nbool do_rectify\n",
    parts: &[],
};

/// `sensor_msgs/CameraInfo` of a camera without binning and region of interest.
#[derive(Debug, Clone, PartialEq)]
pub struct CameraInfo {
    /// Time stamp, and the optical frame of the camera: z forward, x to the right.
    pub header: Header,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The camera matrix K, 3×3, row by row, pixels.
    pub k: [f64; 9],
    /// Coefficients of the model `plumb_bob`: k1, k2, p1, p2, k3.
    pub d: [f64; 5],
}

impl CameraInfo {
    /// What a camera with square pixels and its principal point in the middle reports.
    pub fn new(stamp: SimTime, frame: &str, intrinsics: CameraIntrinsics) -> Self {
        let Distortion { k1, k2, p1, p2 } = intrinsics.distortion;
        let f = intrinsics.focal_length();
        let cx = f64::from(intrinsics.width) / 2.0;
        let cy = f64::from(intrinsics.height) / 2.0;
        Self {
            header: Header::new(stamp, frame),
            width: intrinsics.width,
            height: intrinsics.height,
            k: [f, 0.0, cx, 0.0, f, cy, 0.0, 0.0, 1.0],
            d: [k1, k2, p1, p2, 0.0],
        }
    }
}

impl Message for CameraInfo {
    const DEFINITION: &'static Definition = &Definition {
        name: "sensor_msgs/CameraInfo",
        fields: "std_msgs/Header header\nuint32 height\nuint32 width\nstring distortion_model\n\
                 float64[] d\nfloat64[9] k\nfloat64[9] r\nfloat64[12] p\nuint32 binning_x\n\
                 uint32 binning_y\nsensor_msgs/RegionOfInterest roi\n",
        parts: &[Header::DEFINITION, REGION_OF_INTEREST],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        out.u32(self.height);
        out.u32(self.width);
        out.string("plumb_bob");
        out.f64_sequence(&self.d);
        out.f64_array(&self.k);
        out.f64_array(&[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
        let [a, b, c, d, e, f, g, h, i] = self.k;
        out.f64_array(&[a, b, c, 0.0, d, e, f, 0.0, g, h, i, 0.0]);
        // Zero binning means none, and a region of zeros the whole image.
        out.u32(0);
        out.u32(0);
        (0..4).for_each(|_| out.u32(0));
        out.bool(false);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        let header = Header::decode(input)?;
        let (height, width) = (input.u32()?, input.u32()?);
        input.string()?;
        let mut d = [0.0; 5];
        // A message may have fewer coefficients, or more of another model.
        let written = input.sequence(8, CdrReader::f64)?;
        d.iter_mut().zip(written).for_each(|(d, value)| *d = value);
        let k = input.f64_array()?;
        input.f64_array::<9>()?;
        input.f64_array::<12>()?;
        (0..6).try_for_each(|_| input.u32().map(drop))?;
        input.bool()?;
        Ok(Self {
            header,
            width,
            height,
            k,
            d,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn camera_infos_round_trip() {
        let intrinsics = CameraIntrinsics {
            width: 640,
            height: 480,
            horizontal_fov: 1.4,
            distortion: Distortion {
                k1: -0.1,
                ..Distortion::default()
            },
        };
        let info = CameraInfo::new(SimTime(3), "camera_optical", intrinsics);
        assert_eq!(CameraInfo::from_cdr(&info.to_cdr()).unwrap(), info);
        assert_eq!([info.k[2], info.k[5], info.k[8]], [320.0, 240.0, 1.0]);
        assert_eq!(info.d, [-0.1, 0.0, 0.0, 0.0, 0.0]);
    }
}
