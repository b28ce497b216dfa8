//! The text that explains a message type to a reader that does not know it: the `ros2msg` schema encoding of MCAP.

/// A message type: its fields, and the types that these have.
#[derive(Debug, PartialEq, Eq)]
pub struct Definition {
    /// Package and name, `geometry_msgs/Pose`.
    pub name: &'static str,
    /// The fields, one a line.
    pub fields: &'static str,
    /// The types of the fields, as far as they are messages.
    pub parts: &'static [&'static Definition],
}

impl Definition {
    /// The name as ROS 2 writes it in full, `geometry_msgs/msg/Pose`.
    pub fn full_name(&self) -> String {
        self.name.replacen('/', "/msg/", 1)
    }

    /// The fields of this type, then of each type that it is made of, divided by a line of equals signs.
    pub fn schema(&self) -> String {
        let mut parts = Vec::new();
        self.collect_parts(&mut parts);
        let line = "=".repeat(80);
        let mut text = self.fields.to_owned();
        for part in parts {
            text += &format!("{line}\nMSG: {}\n{}", part.name, part.fields);
        }
        text
    }

    fn collect_parts(&self, parts: &mut Vec<&'static Self>) {
        for part in self.parts {
            if !parts.contains(part) {
                parts.push(part);
                part.collect_parts(parts);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::messages::{Message, PoseStamped};

    #[test]
    fn a_schema_lists_each_part_once() {
        let text = PoseStamped::DEFINITION.schema();
        let heads: Vec<&str> = text.lines().filter(|l| l.starts_with("MSG: ")).collect();
        assert_eq!(
            heads,
            [
                "MSG: std_msgs/Header",
                "MSG: builtin_interfaces/Time",
                "MSG: geometry_msgs/Pose",
                "MSG: geometry_msgs/Point",
                "MSG: geometry_msgs/Quaternion"
            ]
        );
        assert!(text.starts_with("std_msgs/Header header\ngeometry_msgs/Pose pose\n===="));
        assert_eq!(PoseStamped::DEFINITION.full_name(), "geometry_msgs/msg/PoseStamped");
    }
}
