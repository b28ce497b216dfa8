//! What a delivery contributes to the metrics.

use std::collections::BTreeMap;

use super::path_ratio::path_ratio;
use crate::score::results::DeliveryResult;

/// Deliveries by episode, in the order of their tasks: the weights of LSR and LSPL fall with the
/// position in the sequence.
pub(crate) fn by_episode(deliveries: &[DeliveryResult]) -> BTreeMap<usize, Vec<&DeliveryResult>> {
    let mut episodes = BTreeMap::<usize, Vec<&DeliveryResult>>::new();
    for delivery in deliveries {
        episodes.entry(delivery.episode).or_default().push(delivery);
    }
    for episode in episodes.values_mut() {
        episode.sort_by_key(|delivery| delivery.task);
    }
    episodes
}

/// A value of a delivery, 0 to 1.
pub(crate) type Value = fn(&DeliveryResult) -> f64;

pub(crate) fn paper_success(delivery: &DeliveryResult) -> f64 {
    f64::from(delivery.success_10m)
}

pub(crate) fn strict_success(delivery: &DeliveryResult) -> f64 {
    f64::from(delivery.success_2m)
}

/// Strict success without a collision, nor a contact left from the delivery before.
pub(crate) fn clean_success(delivery: &DeliveryResult) -> f64 {
    let is_clean = delivery.collisions == 0 && delivery.contact_s == 0.0;
    f64::from(delivery.success_2m && is_clean)
}

pub(crate) fn correct_unit(delivery: &DeliveryResult) -> f64 {
    f64::from(delivery.correct_unit)
}

pub(crate) fn paper_ratio(delivery: &DeliveryResult) -> f64 {
    path_ratio(
        delivery.success_10m,
        delivery.straight_line_m,
        delivery.path_m,
    )
}

pub(crate) fn strict_ratio(delivery: &DeliveryResult) -> f64 {
    // Without a drivable path to the door the ratio is 0.
    let shortest = delivery.shortest_path_m.unwrap_or(f64::INFINITY);
    path_ratio(delivery.success_2m, shortest, delivery.path_m)
}
