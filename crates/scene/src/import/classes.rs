//! Class of a model, from the words in its name.

use crate::SemanticClass;

/// The first row with a word of the name decides: a post office is a building before it is a post.
const WORDS: [(SemanticClass, &[&str]); 11] = [
    (
        SemanticClass::Building,
        &[
            "house",
            "building",
            "apartment",
            "apartments",
            "office",
            "shop",
            "store",
            "salon",
            "food",
            "station",
            "school",
            "church",
            "cafe",
            "hotel",
            "garage",
            "warehouse",
            "hospital",
            "tower",
            "facade",
            "bridge",
        ],
    ),
    (
        SemanticClass::Vegetation,
        &["tree", "bush", "hedge", "shrub", "plant", "pine", "oak"],
    ),
    (
        SemanticClass::Vehicle,
        &[
            "hatchback",
            "suv",
            "pickup",
            "ambulance",
            "car",
            "truck",
            "bus",
            "van",
            "prius",
            "taxi",
            "vehicle",
        ],
    ),
    (
        SemanticClass::Person,
        &["person", "pedestrian", "actor", "human"],
    ),
    (
        SemanticClass::Wall,
        &["wall", "walls", "fence", "barrier", "gate"],
    ),
    (SemanticClass::Road, &["road", "asphalt", "street", "lane"]),
    (
        SemanticClass::Pavement,
        &["sidewalk", "pavement", "footway"],
    ),
    (
        SemanticClass::Kerb,
        &["kerb", "curb", "kerbstone", "curbstone"],
    ),
    (
        SemanticClass::Ground,
        &["ground", "grass", "terrain", "heightmap"],
    ),
    (SemanticClass::Door, &["door"]),
    (
        SemanticClass::Furniture,
        &[
            "lamp",
            "post",
            "sign",
            "postbox",
            "mailbox",
            "hydrant",
            "dumpster",
            "light",
            "pole",
            "bench",
            "box",
            "cone",
            "bin",
            "table",
            "chair",
            "stop",
            "cardboard",
        ],
    ),
];

/// The class that a name tells, such as `pine_tree_88` of a model.
pub(crate) fn class_of(name: &str) -> SemanticClass {
    let lower = name.to_ascii_lowercase();
    // Digits end a word too: `house3` is a house. Whole words are compared, so that `carpet` is no
    // car.
    let words: Vec<&str> = lower.split(|c: char| !c.is_ascii_alphabetic()).collect();
    let speaks = |(_, known): &&(SemanticClass, &[&str])| words.iter().any(|w| known.contains(w));
    WORDS
        .iter()
        .find(speaks)
        .map_or(SemanticClass::Other, |(class, _)| *class)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_the_published_models() {
        let expected = [
            ("house_3_156", SemanticClass::Building),
            ("House 1", SemanticClass::Building),
            ("post_office_143", SemanticClass::Building),
            ("osrf_first_office_87", SemanticClass::Building),
            ("fast_food_93", SemanticClass::Building),
            ("pine_tree_88", SemanticClass::Vegetation),
            ("hatchback_blue_241", SemanticClass::Vehicle),
            ("lamp_post_189", SemanticClass::Furniture),
            ("postbox_92", SemanticClass::Furniture),
            ("telephone_pole_206_clone", SemanticClass::Furniture),
            ("wall_4", SemanticClass::Wall),
            ("ground_plane_0", SemanticClass::Ground),
            ("asphalt_plane", SemanticClass::Road),
            ("curb_12", SemanticClass::Kerb),
            ("carpet", SemanticClass::Other),
        ];
        for (name, class) in expected {
            assert_eq!(class_of(name), class, "{name}");
        }
    }
}
