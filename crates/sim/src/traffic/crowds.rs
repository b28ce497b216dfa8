//! Crowds: a person alone, two streams, and the dependence of speed on density.

use super::tests::{DT, NOBODY, overlaps, street, tag};
use super::*;

/// A stretch of a walkway, x in metres. People who pass one end of it go on at its other end.
type Stretch = std::ops::Range<f64>;

/// People on a walkway between walls, from x = 0 to 100 m. Those with even numbers go east, the
/// others east too or west.
struct Walkway {
    traffic: Traffic,
    ends: [u32; 2],
    two_ways: bool,
}

/// People on a stretch: means of their speed forward and of their desired speed, m/s, and their
/// number.
struct Flow {
    speed: f64,
    desired: f64,
    count: f64,
}

impl Walkway {
    fn new(width: f64, people: usize, two_ways: bool, seed: u64) -> Self {
        let map = street(&(tag("highway", "footway") + &tag("width", &width.to_string())));
        let free =
            |p: MapPoint| p.y.abs() < width / 2.0 - PERSON_RADIUS_M && (-1.0..101.0).contains(&p.x);
        let plan = TrafficPlan {
            pedestrians: people,
            cars: 0,
        };
        let mut traffic = Traffic::new(&map, free, plan, MapPoint::new(0.0, 50.0), seed);
        assert!(
            traffic.placed().pedestrians * 10 >= people * 9,
            "{:?}",
            traffic.placed()
        );
        let ends = [100.0, 0.0].map(|x| traffic.pedestrians.end_at(MapPoint::new(x, 0.0)));
        for i in 0..traffic.pedestrians.people.len() {
            let from = traffic.pedestrians.people[i].position;
            traffic
                .pedestrians
                .send(i, from, ends[usize::from(two_ways && i % 2 == 1)]);
        }
        traffic.pedestrians.update_neighbours();
        Self {
            traffic,
            ends,
            two_ways,
        }
    }

    fn goes_west(&self, i: usize) -> bool {
        self.two_ways && i % 2 == 1
    }

    /// Lets people walk round and round; returns the deepest overlap, metres.
    fn walk(&mut self, seconds: f64, stretch: Stretch) -> f64 {
        let Stretch {
            start: low,
            end: high,
        } = stretch;
        let mut deepest = 0.0_f64;
        for _ in 0..(seconds / DT) as usize {
            self.traffic.step(DT, NOBODY);
            for i in 0..self.traffic.pedestrians.people.len() {
                let west = self.goes_west(i);
                let (x, back) = if west {
                    (low, low - high)
                } else {
                    (high, high - low)
                };
                self.traffic
                    .pedestrians
                    .wrap(i, x, back, self.ends[usize::from(west)]);
            }
            self.traffic.pedestrians.update_neighbours();
            deepest = deepest.max(overlaps(self.traffic.movers())[0]);
        }
        deepest
    }

    /// The flow of the people on a stretch.
    fn flow(&self, stretch: &Stretch) -> Flow {
        let (mut speed, mut desired, mut count) = (0.0, 0.0, 0.0);
        for (i, person) in self.traffic.pedestrians.people.iter().enumerate() {
            if stretch.contains(&person.position.x) {
                speed += person.velocity[0] * if self.goes_west(i) { -1.0 } else { 1.0 };
                (desired, count) = (desired + person.desired, count + 1.0);
            }
        }
        Flow {
            speed: speed / count,
            desired: desired / count,
            count,
        }
    }

    /// Order of the streams: 1 where everybody meets only people of his own direction within 6 m
    /// ahead and behind, about a third where directions are mixed at random (after Rex and Löwen,
    /// *Lane formation in oppositely charged colloids driven by an electric field*, 2007).
    fn order(&self) -> f64 {
        let people = &self.traffic.pedestrians.people;
        let order = |i: usize| {
            let near = |j: &usize| {
                let (p, q) = (people[i].position, people[*j].position);
                *j != i && (p.x - q.x).abs() < 6.0 && (p.y - q.y).abs() < 0.4
            };
            let met: Vec<bool> = (0..people.len())
                .filter(near)
                .map(|j| j % 2 == i % 2)
                .collect();
            let same = met.iter().filter(|same| **same).count() as f64;
            if met.is_empty() {
                1.0
            } else {
                (2.0 * same / met.len() as f64 - 1.0).powi(2)
            }
        };
        (0..people.len()).map(order).sum::<f64>() / people.len() as f64
    }
}

#[test]
fn a_person_alone_walks_at_the_desired_speed() {
    for seed in 1..8 {
        let mut walkway = Walkway::new(3.0, 1, false, seed);
        walkway.walk(3.0, 5.0..95.0);
        let (mut walked, mut desired) = (0.0, 0.0);
        for _ in 0..200 {
            walkway.walk(DT, 5.0..95.0);
            let flow = walkway.flow(&(0.0..100.0));
            (walked, desired) = (walked + flow.speed, desired + flow.desired);
        }
        assert!(
            (0.98..1.01).contains(&(walked / desired)),
            "seed {seed}: {walked} of {desired}"
        );
    }
}

#[test]
fn two_streams_form_lanes_and_keep_flowing() {
    let mut walkway = Walkway::new(4.0, 120, true, 7);
    let mixed = walkway.order();
    let deepest = walkway.walk(60.0, 8.0..92.0);
    let order = walkway.order();
    let Flow { speed, desired, .. } = walkway.flow(&(0.0..100.0));
    assert!(
        mixed < 0.6 && order > 0.85,
        "lanes: {mixed} before, {order} after a minute"
    );
    assert!(speed > 0.8 * desired, "{speed} m/s instead of {desired}");
    assert!(deepest < 0.05, "{deepest}");
}

/// Speed in m/s at a density in people a square metre, by U. Weidmann, *Transporttechnik der
/// Fussgänger*, ETH Zürich, 1993.
fn weidmann(density: f64) -> f64 {
    1.34 * (1.0 - libm::exp(-1.913 * (1.0 / density - 1.0 / 5.4)))
}

#[test]
fn dense_crowds_walk_more_slowly() {
    // In dense crowds people walk faster than Weidmann's: bodies with the same direction hardly
    // repel each other.
    let mut last = f64::INFINITY;
    for (people, length, off) in [
        (60, 84.0, 1.15),
        (170, 84.0, 1.15),
        (170, 50.0, 1.3),
        (170, 28.0, 2.0),
    ] {
        let mut walkway = Walkway::new(3.0, people, false, 5);
        let middle = 92.0 - 0.7 * length..92.0 - 0.3 * length;
        // Until the crowd has filled its stretch, people who come round may overlap others.
        walkway.walk(60.0, 92.0 - length..92.0);
        let (mut speeds, mut count, mut deepest) = (0.0, 0.0, 0.0_f64);
        for _ in 0..20 {
            deepest = deepest.max(walkway.walk(1.0, 92.0 - length..92.0));
            let flow = walkway.flow(&middle);
            (speeds, count) = (speeds + flow.speed * flow.count, count + flow.count);
        }
        let (speed, density) = (speeds / count, count / 20.0 / (0.4 * length * 3.0));
        let share = speed / weidmann(density);
        assert!(
            (1.0 / off..off).contains(&share),
            "{density} a square metre: {speed} m/s, {share} of Weidmann's"
        );
        assert!(
            speed < last && deepest < 0.05,
            "{density} a square metre: {speed} m/s, {deepest} m deep"
        );
        last = speed;
    }
}
