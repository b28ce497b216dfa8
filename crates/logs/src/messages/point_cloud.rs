//! `sensor_msgs/PointCloud2` and `sensor_msgs/PointField`. Their conversion to scans is in
//! `cloud_scan`.

use super::{Definition, Header, Message};
use crate::cdr::{CdrError, CdrReader, CdrWriter};

/// `PointField.UINT8`; the constants below follow the same definition.
pub(super) const UINT8: u8 = 2;
pub(super) const UINT32: u8 = 6;
pub(super) const FLOAT32: u8 = 7;
pub(super) const FLOAT64: u8 = 8;

/// `sensor_msgs/PointField`: the place of a number in the bytes of a point.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PointField {
    /// Name of the number, such as `x`.
    pub name: String,
    /// Offset from the beginning of the point, bytes.
    pub offset: u32,
    /// Type of the number, 1 to 8 as in the interface definition.
    pub datatype: u8,
    /// Number of elements.
    pub count: u32,
}

impl Message for PointField {
    const DEFINITION: &'static Definition = &Definition {
        name: "sensor_msgs/PointField",
        fields: "uint8 INT8=1\nuint8 UINT8=2\nuint8 INT16=3\nuint8 UINT16=4\nuint8 INT32=5\n\
                 uint8 UINT32=6\nuint8 FLOAT32=7\nuint8 FLOAT64=8\nstring name\nuint32 offset\n\
                 uint8 datatype\nuint32 count\n",
        parts: &[],
    };

    fn encode(&self, out: &mut CdrWriter) {
        out.string(&self.name);
        out.u32(self.offset);
        out.u8(self.datatype);
        out.u32(self.count);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            name: input.string()?,
            offset: input.u32()?,
            datatype: input.u8()?,
            count: input.u32()?,
        })
    }
}

/// `sensor_msgs/PointCloud2`.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct PointCloud2 {
    /// Time stamp and frame of the sensor.
    pub header: Header,
    /// Number of rows; 1 for an unordered cloud.
    pub height: u32,
    /// Number of points in each row.
    pub width: u32,
    /// The fields of a point.
    pub fields: Vec<PointField>,
    /// Whether numbers are big-endian.
    pub is_bigendian: bool,
    /// Length of a point, bytes.
    pub point_step: u32,
    /// Length of a row, bytes.
    pub row_step: u32,
    /// The bytes of all points.
    pub data: Vec<u8>,
    /// Whether no point contains NaN or infinity.
    pub is_dense: bool,
}

impl PointCloud2 {
    /// The offset of a field in a point, if the field has this type and lies inside the point.
    pub(super) fn offset(&self, name: &str, datatype: u8) -> Option<usize> {
        let field = self
            .fields
            .iter()
            .find(|f| f.name == name && f.datatype == datatype)?;
        let size = match datatype {
            UINT8 => 1,
            FLOAT64 => 8,
            _ => 4,
        };
        // Checked once for each field, so that reading from a point needs no check.
        let inside = field.offset.checked_add(size)? <= self.point_step;
        inside.then_some(field.offset as usize)
    }

    /// Iterates over the bytes of each point, row by row.
    pub(super) fn points(&self) -> impl Iterator<Item = &[u8]> {
        let rows = self
            .data
            // `chunks` panics at a size of zero, which a cloud without points may declare.
            .chunks(self.row_step.max(1) as usize)
            .take(self.height as usize);
        rows.flat_map(|row| {
            row.chunks_exact(self.point_step.max(1) as usize)
                .take(self.width as usize)
        })
    }
}

impl Message for PointCloud2 {
    const DEFINITION: &'static Definition = &Definition {
        name: "sensor_msgs/PointCloud2",
        fields: "std_msgs/Header header\nuint32 height\nuint32 width\n\
                 sensor_msgs/PointField[] fields\nbool is_bigendian\nuint32 point_step\n\
                 uint32 row_step\nuint8[] data\nbool is_dense\n",
        parts: &[Header::DEFINITION, PointField::DEFINITION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        out.u32(self.height);
        out.u32(self.width);
        out.count(self.fields.len());
        self.fields.iter().for_each(|f| f.encode(out));
        out.bool(self.is_bigendian);
        out.u32(self.point_step);
        out.u32(self.row_step);
        out.octets(&self.data);
        out.bool(self.is_dense);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        Ok(Self {
            header: Header::decode(input)?,
            height: input.u32()?,
            width: input.u32()?,
            // 13 bytes: three lengths or numbers of 4 bytes, and the type.
            fields: input.sequence(13, PointField::decode)?,
            is_bigendian: input.bool()?,
            point_step: input.u32()?,
            row_step: input.u32()?,
            data: input.octets()?.to_vec(),
            is_dense: input.bool()?,
        })
    }
}
