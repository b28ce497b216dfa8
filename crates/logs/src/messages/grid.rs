//! `nav_msgs/OccupancyGrid`.

use super::{Definition, Header, Message, Pose, Time};
use crate::cdr::{CdrError, CdrReader, CdrWriter};

const MAP_META_DATA: &Definition = &Definition {
    name: "nav_msgs/MapMetaData",
    fields: "builtin_interfaces/Time map_load_time\nfloat32 resolution\nuint32 width\n\
             uint32 height\ngeometry_msgs/Pose origin\n",
    parts: &[Time::DEFINITION, Pose::DEFINITION],
};

/// `nav_msgs/OccupancyGrid`.
#[derive(Debug, Clone, PartialEq)]
pub struct OccupancyGrid {
    /// Time stamp and frame.
    pub header: Header,
    /// Side of a cell, metres.
    pub resolution: f32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Pose of the outer corner of the first cell.
    pub origin: Pose,
    /// The cells, row by row from the origin: -1 unknown, 0 free to 100 occupied.
    pub data: Vec<i8>,
}

impl Message for OccupancyGrid {
    const DEFINITION: &'static Definition = &Definition {
        name: "nav_msgs/OccupancyGrid",
        fields: "std_msgs/Header header\nnav_msgs/MapMetaData info\nint8[] data\n",
        parts: &[Header::DEFINITION, MAP_META_DATA],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        Time(self.header.stamp).encode(out);
        out.f32(self.resolution);
        out.u32(self.width);
        out.u32(self.height);
        self.origin.encode(out);
        out.count(self.data.len());
        // The bytes of an `int8` are those of its two's complement.
        self.data.iter().for_each(|cell| out.u8(*cell as u8));
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        let header = Header::decode(input)?;
        // The time of loading is that of the header, in our own logs.
        Time::decode(input)?;
        let (resolution, width, height) = (input.f32()?, input.u32()?, input.u32()?);
        let origin = Pose::decode(input)?;
        let data = input.octets()?.iter().map(|byte| *byte as i8).collect();
        Ok(Self {
            header,
            resolution,
            width,
            height,
            origin,
            data,
        })
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::{Pose2, SimTime};

    use super::*;

    #[test]
    fn grids_round_trip() {
        let grid = OccupancyGrid {
            header: Header::new(SimTime(5), "map"),
            resolution: 0.1,
            width: 3,
            height: 1,
            origin: Pose2::new(1.0, 2.0, 0.0).into(),
            data: vec![-1, 0, 100],
        };
        assert_eq!(OccupancyGrid::from_cdr(&grid.to_cdr()).unwrap(), grid);
    }
}
