//! Materials that Gazebo itself has (`Gazebo/Grey`, `Gazebo/Wood`, `Gazebo/Residential`, …): plain
//! colours, and patterns of our own.

use super::patterns::Pattern;

/// The look of a built-in material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Builtin {
    /// sRGB colour.
    Color([f32; 3]),
    /// Pattern over it.
    Pattern(Pattern),
}

const COLORS: [(&str, [f32; 3]); 30] = [
    ("Grey", [0.70, 0.70, 0.70]),
    ("Gray", [0.70, 0.70, 0.70]),
    ("LightGrey", [0.80, 0.80, 0.80]),
    ("DarkGrey", [0.18, 0.18, 0.18]),
    ("DarkGray", [0.18, 0.18, 0.18]),
    ("FlatBlack", [0.10, 0.10, 0.10]),
    ("Black", [0.05, 0.05, 0.05]),
    ("White", [1.0, 1.0, 1.0]),
    ("Red", [1.0, 0.0, 0.0]),
    ("RedBright", [0.87, 0.26, 0.07]),
    ("DarkRed", [0.5, 0.05, 0.05]),
    ("Green", [0.0, 1.0, 0.0]),
    ("DarkGreen", [0.0, 0.5, 0.0]),
    ("Blue", [0.0, 0.0, 1.0]),
    ("DarkBlue", [0.0, 0.0, 0.5]),
    ("SkyBlue", [0.13, 0.44, 0.70]),
    ("Yellow", [1.0, 1.0, 0.0]),
    ("DarkYellow", [0.7, 0.7, 0.0]),
    ("Orange", [1.0, 0.51, 0.05]),
    ("DarkOrange", [0.7, 0.33, 0.0]),
    ("Purple", [1.0, 0.0, 1.0]),
    ("DarkMagenta", [0.5, 0.0, 0.5]),
    ("Turquoise", [0.0, 1.0, 1.0]),
    ("Indigo", [0.33, 0.0, 0.5]),
    ("Gold", [0.8, 0.65, 0.1]),
    ("ZincYellow", [0.97, 0.95, 0.21]),
    ("Grass", [0.35, 0.47, 0.22]),
    ("Bricks", [0.55, 0.33, 0.27]),
    ("PaintedWall", [0.85, 0.83, 0.78]),
    ("CloudySky", [0.60, 0.70, 0.80]),
];

const PATTERNS: [(&str, Pattern); 14] = [
    ("Wood", Pattern::Wood),
    ("WoodPallet", Pattern::Wood),
    ("WoodFloor", Pattern::Wood),
    ("Road", Pattern::MarkedRoad),
    ("Residential", Pattern::MarkedRoad),
    ("Tertiary", Pattern::MarkedRoad),
    ("Secondary", Pattern::MarkedRoad),
    ("Primary", Pattern::MarkedRoad),
    ("Trunk", Pattern::MarkedRoad),
    ("Motorway", Pattern::MarkedRoad),
    ("Lanes_2", Pattern::MarkedRoad),
    ("Lanes_4", Pattern::MarkedRoad),
    ("Footway", Pattern::Paving),
    ("Pedestrian", Pattern::Paving),
];

/// The built-in material of that name; `None` if Gazebo has none, or its look is unknown here.
pub(crate) fn builtin(name: &str) -> Option<Builtin> {
    let name = name.strip_prefix("Gazebo/")?;
    let color = COLORS
        .iter()
        .find(|(n, _)| *n == name)
        .map(|(_, c)| Builtin::Color(*c));
    color.or_else(|| {
        PATTERNS
            .iter()
            .find(|(n, _)| *n == name)
            .map(|(_, p)| Builtin::Pattern(*p))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_gazebos_own_names_are_known() {
        assert_eq!(
            builtin("Gazebo/Residential"),
            Some(Builtin::Pattern(Pattern::MarkedRoad))
        );
        assert_eq!(builtin("Gazebo/Grey"), Some(Builtin::Color([0.70; 3])));
        assert_eq!(builtin("Grey"), None);
        assert_eq!(builtin("Gazebo/Nonsense"), None);
    }
}
