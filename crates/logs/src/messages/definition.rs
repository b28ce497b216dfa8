//! Definitions of message types, in the `ros2msg` schema encoding of MCAP.

/// A message type: its fields and the message types in them.
#[derive(Debug, PartialEq, Eq)]
pub struct Definition {
    /// Package and name, such as `geometry_msgs/Pose`.
    pub name: &'static str,
    /// The fields, one on each line.
    pub fields: &'static str,
    /// The types of those fields that are messages themselves.
    pub parts: &'static [&'static Definition],
}

impl Definition {
    /// The full name of ROS 2, such as `geometry_msgs/msg/Pose`.
    pub fn full_name(&self) -> String {
        self.name.replacen('/', "/msg/", 1)
    }

    /// The schema: the fields of this type, then those of each type in it, each after a line of 80
    /// equals signs.
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
            // Each type once, however often it is used.
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
    fn a_schema_contains_each_type_once() {
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
        assert_eq!(
            PoseStamped::DEFINITION.full_name(),
            "geometry_msgs/msg/PoseStamped"
        );
    }
}
