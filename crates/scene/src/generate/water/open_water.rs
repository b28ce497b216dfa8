//! Which of the map's areas are open water.

use openbench_osm::Tags;

/// Whether an area is open water: none that lies under the ground.
pub(crate) fn is_water(tags: &Tags) -> bool {
    let below = tags.says("tunnel")
        || tags.says("covered")
        || tags.is("location", "underground")
        || tags.get("layer").is_some_and(|l| l.starts_with('-'));
    let open = tags.is("natural", "water")
        || tags.says("water")
        || tags.is("waterway", "riverbank")
        || tags.is("leisure", "swimming_pool")
        || tags.is("amenity", "fountain");
    open && !below
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn water_under_the_ground_is_not_open() {
        assert!(is_water(&Tags::from([("natural", "water")])));
        assert!(!is_water(&Tags::from([
            ("natural", "water"),
            ("tunnel", "yes")
        ])));
        assert!(!is_water(&Tags::from([("natural", "wood")])));
    }
}
