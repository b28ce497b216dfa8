//! Collisions by class, in words.

use crate::score::results::Metrics;

/// Number of collisions and seconds in contact with each class of object; empty without any.
pub(super) fn by_class(metrics: &Metrics) -> String {
    let classes = metrics.collisions_by_class.iter();
    let words =
        classes.map(|(class, sum)| format!("{} {class}, {:.1} s", sum.count, sum.contact_s));
    words.collect::<Vec<_>>().join("; ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::score::metrics::CollisionSum;
    use crate::score::results::tests::results;

    #[test]
    fn a_long_scrape_is_told_from_a_bump() {
        let mut metrics = results(vec![]).metrics;
        assert_eq!(by_class(&metrics), "");
        for (class, count, contact_s) in [("building", 1, 126.04), ("wall", 2, 0.1)] {
            let sum = CollisionSum {
                count,
                contact_s,
                ..CollisionSum::default()
            };
            metrics.collisions_by_class.insert(class.to_owned(), sum);
        }
        assert_eq!(by_class(&metrics), "1 building, 126.0 s; 2 wall, 0.1 s");
    }
}
