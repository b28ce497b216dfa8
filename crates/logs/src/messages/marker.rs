//! `visualization_msgs/MarkerArray`.

use openbench_core::Pose3;

use super::geometry::{POINT, VECTOR3};
use super::{CompressedImage, Definition, Header, Message, Pose};
use crate::cdr::{CdrError, CdrReader, CdrWriter};

const COLOR: &Definition = &Definition {
    name: "std_msgs/ColorRGBA",
    fields: "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n",
    parts: &[],
};
const DURATION: &Definition = &Definition {
    name: "builtin_interfaces/Duration",
    fields: "int32 sec\nuint32 nanosec\n",
    parts: &[],
};
const UV_COORDINATE: &Definition = &Definition {
    name: "visualization_msgs/UVCoordinate",
    fields: "float32 u\nfloat32 v\n",
    parts: &[],
};
const MESH_FILE: &Definition = &Definition {
    name: "visualization_msgs/MeshFile",
    fields: "string filename\nuint8[] data\n",
    parts: &[],
};

/// The form of a marker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Shape {
    /// A box of the marker's size.
    Cube,
    /// An ellipsoid of the marker's size.
    Sphere,
    /// A line between each two points; the size's x is its width.
    LineList,
    /// Text that faces the viewer; the size's z is its height.
    Text,
}

impl Shape {
    /// Its number in the message.
    fn number(self) -> i32 {
        match self {
            Self::Cube => 1,
            Self::Sphere => 2,
            Self::LineList => 5,
            Self::Text => 9,
        }
    }

    fn of_number(number: i32) -> Result<Self, CdrError> {
        let all = [Self::Cube, Self::Sphere, Self::LineList, Self::Text];
        let found = all.into_iter().find(|shape| shape.number() == number);
        found.ok_or_else(|| CdrError::Value(format!("the marker type {number} is not supported")))
    }
}

/// `visualization_msgs/Marker` that stays until another one of its name and number replaces it.
#[derive(Debug, Clone, PartialEq)]
pub struct Marker {
    /// Time stamp and frame.
    pub header: Header,
    /// The kind of thing that is marked.
    pub namespace: String,
    /// Its number among those of its kind.
    pub id: i32,
    /// Its form.
    pub shape: Shape,
    /// Its middle, or the origin of its points.
    pub pose: Pose,
    /// Its size along x, y and z, metres.
    pub scale: [f64; 3],
    /// Red, green, blue and opacity, 0 to 1.
    pub color: [f32; 4],
    /// The points of lines, metres.
    pub points: Vec<[f64; 3]>,
    /// The text.
    pub text: String,
}

impl Marker {
    /// A marker at the origin of its frame, without points and text.
    pub fn new(header: Header, namespace: &str, id: i32, shape: Shape) -> Self {
        Self {
            header,
            namespace: namespace.to_owned(),
            id,
            shape,
            pose: Pose3::identity().into(),
            scale: [1.0; 3],
            color: [1.0; 4],
            points: Vec::new(),
            text: String::new(),
        }
    }
}

impl Message for Marker {
    const DEFINITION: &'static Definition = &Definition {
        name: "visualization_msgs/Marker",
        fields: "int32 ARROW=0\nint32 CUBE=1\nint32 SPHERE=2\nint32 CYLINDER=3\n\
                 int32 LINE_STRIP=4\nint32 LINE_LIST=5\nint32 CUBE_LIST=6\n\
                 int32 SPHERE_LIST=7\nint32 POINTS=8\nint32 TEXT_VIEW_FACING=9\n\
                 int32 MESH_RESOURCE=10\nint32 TRIANGLE_LIST=11\n\
                 int32 ADD=0\nint32 MODIFY=0\nint32 DELETE=2\nint32 DELETEALL=3\n\
                 std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n\
                 geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n\
                 builtin_interfaces/Duration lifetime\nbool frame_locked\n\
                 geometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\n\
                 string texture_resource\nsensor_msgs/CompressedImage texture\n\
                 visualization_msgs/UVCoordinate[] uv_coordinates\nstring text\n\
                 string mesh_resource\nvisualization_msgs/MeshFile mesh_file\n\
                 bool mesh_use_embedded_materials\n",
        parts: &[
            Header::DEFINITION,
            Pose::DEFINITION,
            VECTOR3,
            COLOR,
            DURATION,
            POINT,
            CompressedImage::DEFINITION,
            UV_COORDINATE,
            MESH_FILE,
        ],
    };

    fn encode(&self, out: &mut CdrWriter) {
        self.header.encode(out);
        out.string(&self.namespace);
        out.i32(self.id);
        out.i32(self.shape.number());
        // The action: add or replace.
        out.i32(0);
        self.pose.encode(out);
        out.f64_array(&self.scale);
        self.color.iter().for_each(|part| out.f32(*part));
        // A lifetime of zero is endless.
        out.i32(0);
        out.u32(0);
        // Whether it moves with its frame.
        out.bool(false);
        out.count(self.points.len());
        self.points.iter().for_each(|point| out.f64_array(point));
        // No colours of single points.
        out.count(0);
        out.string("");
        CompressedImage::default().encode(out);
        out.count(0);
        out.string(&self.text);
        out.string("");
        out.string("");
        out.octets(&[]);
        out.bool(false);
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        let (header, namespace) = (Header::decode(input)?, input.string()?);
        let (id, shape) = (input.i32()?, Shape::of_number(input.i32()?)?);
        input.i32()?;
        let (pose, scale) = (Pose::decode(input)?, input.f64_array()?);
        let color = color(input)?;
        input.i32()?;
        input.u32()?;
        input.bool()?;
        let points = input.sequence(3 * 8, CdrReader::f64_array)?;
        input.sequence(4 * 4, self::color)?;
        input.string()?;
        CompressedImage::decode(input)?;
        input.sequence(2 * 4, |input| Ok([input.f32()?, input.f32()?]))?;
        let text = input.string()?;
        input.string()?;
        input.string()?;
        input.octets()?;
        input.bool()?;
        Ok(Self {
            header,
            namespace,
            id,
            shape,
            pose,
            scale,
            color,
            points,
            text,
        })
    }
}

fn color(input: &mut CdrReader<'_>) -> Result<[f32; 4], CdrError> {
    Ok([input.f32()?, input.f32()?, input.f32()?, input.f32()?])
}

/// `visualization_msgs/MarkerArray`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MarkerArray(pub Vec<Marker>);

impl Message for MarkerArray {
    const DEFINITION: &'static Definition = &Definition {
        name: "visualization_msgs/MarkerArray",
        fields: "visualization_msgs/Marker[] markers\n",
        parts: &[Marker::DEFINITION],
    };

    fn encode(&self, out: &mut CdrWriter) {
        out.count(self.0.len());
        self.0.iter().for_each(|marker| marker.encode(out));
    }

    fn decode(input: &mut CdrReader<'_>) -> Result<Self, CdrError> {
        // Time stamp, three numbers, pose, size and colour, and the lengths of what varies.
        const SMALLEST: usize = 8 + 3 * 4 + 7 * 8 + 3 * 8 + 4 * 4;
        Ok(Self(input.sequence(SMALLEST, Marker::decode)?))
    }
}

#[cfg(test)]
mod tests {
    use openbench_core::SimTime;

    use super::*;

    #[test]
    fn markers_round_trip() {
        let header = Header::new(SimTime(9), "map");
        let mut lines = Marker::new(header.clone(), "walls", 3, Shape::LineList);
        lines.points = vec![[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]];
        let mut text = Marker::new(header, "names", -1, Shape::Text);
        text.text = "building1".into();
        let markers = MarkerArray(vec![lines, text]);
        assert_eq!(MarkerArray::from_cdr(&markers.to_cdr()).unwrap(), markers);
    }
}
