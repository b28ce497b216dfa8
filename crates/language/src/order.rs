//! In which order to drive to several stops: the shortest open path from the start that keeps every
//! order the instruction asks for.
//!
//! Exact up to twelve places (dynamic programming over subsets after Held and Karp, 1962). Beyond,
//! nearest neighbour improved by moving and reversing pieces. Stops at one place count once and
//! stay together. Of equally short orders the one nearest to the instruction's wins: times are
//! whole milliseconds, so equal is equal.

/// The time between places that no route connects, in milliseconds: longer than any drive.
pub(crate) const UNKNOWN: u64 = 10_000_000_000;

/// The most places for which the order is exact: tables of 4096 sets by 13 places. Each more place
/// doubles time and memory; four bits a stop in [`Soonest::order`] allow sixteen at most.
const EXACT: usize = 12;
/// The longest piece that the heuristic moves, in stops, as in Or-opt (Or, 1976).
const LONGEST_PIECE: usize = 3;
/// How often the heuristic tries all moves at most. A pass for 200 stops tries some 10^5
/// moves.
const MOST_PASSES: usize = 50;

/// Which stops must come before which; never a circle.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Precedence {
    /// `earlier[i]`: all stops that must come before stop `i`.
    earlier: Vec<Vec<bool>>,
}

impl Precedence {
    /// No order among `count` stops.
    pub(crate) fn new(count: usize) -> Self {
        Self {
            earlier: vec![vec![false; count]; count],
        }
    }

    /// Puts `a` before `b`. Does nothing and returns false if `b` already comes before `a`.
    pub(crate) fn add(&mut self, a: usize, b: usize) -> bool {
        let count = self.earlier.len();
        if a >= count || b >= count || a == b || self.earlier[a][b] {
            return false;
        }
        // Already so, directly or by other stops.
        if self.earlier[b][a] {
            return true;
        }
        // The relation is kept transitive: all that come before `a`, and `a`, come before `b` and
        // all that follow it. So one look tells whether an order would close a circle.
        let ancestors: Vec<usize> = (0..count)
            .filter(|i| *i == a || self.earlier[a][*i])
            .collect();
        let descendants: Vec<usize> = (0..count)
            .filter(|i| *i == b || self.earlier[*i][b])
            .collect();
        for later in descendants {
            for ancestor in &ancestors {
                self.earlier[later][*ancestor] = true;
            }
        }
        true
    }

    /// Whether an order keeps to it.
    pub(crate) fn allows(&self, order: &[usize]) -> bool {
        order.iter().enumerate().all(|(i, stop)| {
            let rest = &order[i + 1..];
            !rest.iter().any(|later| self.earlier[*stop][*later])
        })
    }

    /// The order among groups of stops; `None` if it has a circle.
    fn of_groups(&self, groups: &[Vec<usize>]) -> Option<Self> {
        let mut coarse = Self::new(groups.len());
        for (b, later) in groups.iter().enumerate() {
            for (a, earlier) in groups.iter().enumerate().filter(|(a, _)| *a != b) {
                // Orders between stops have no circle, but those between groups may: A1 before B, B
                // before A2.
                if self.orders(earlier, later) && !coarse.add(a, b) {
                    return None;
                }
            }
        }
        Some(coarse)
    }

    /// Whether any stop of one group must come before any of another.
    fn orders(&self, earlier: &[usize], later: &[usize]) -> bool {
        later
            .iter()
            .any(|later| earlier.iter().any(|earlier| self.earlier[*later][*earlier]))
    }

    /// For each stop those that must come before it, as a bit mask.
    fn masks(&self) -> Vec<usize> {
        self.earlier.iter().map(|row| mask(row)).collect()
    }
}

/// Whether a stop may come next. Bit masks: `earlier` of the stops that must come before each stop,
/// `visited` of those that do.
fn may_follow(earlier: &[usize], visited: usize, next: usize) -> bool {
    visited & (1 << next) == 0 && earlier[next] & !visited == 0
}

/// The best order of the stops. `times` holds milliseconds from the start (index 0) and each stop
/// (index + 1) to each.
pub(crate) fn best_order(times: &[Vec<u64>], precedence: &Precedence) -> Vec<usize> {
    let count = times.len().saturating_sub(1);
    let groups = groups(times);
    match precedence.of_groups(&groups) {
        // Stops at one place are visited together and count as one, which keeps more instructions
        // within the exact limit. Where the sender's order parts them, all stops count by
        // themselves.
        Some(coarse) if groups.len() < count => {
            let order = places_in_order(&times_of_groups(times, &groups), &coarse);
            order
                .into_iter()
                .flat_map(|group| within(&groups[group], precedence))
                .collect()
        }
        _ => places_in_order(times, precedence),
    }
}

/// Times between groups of stops: those between their first stops.
fn times_of_groups(times: &[Vec<u64>], groups: &[Vec<usize>]) -> Vec<Vec<u64>> {
    let firsts: Vec<usize> = std::iter::once(0)
        .chain(groups.iter().map(|group| group[0] + 1))
        .collect();
    firsts
        .iter()
        .map(|from| firsts.iter().map(|to| times[*from][*to]).collect())
        .collect()
}

/// When a set of stops is visited at the soonest, and in which order.
///
/// Of equal times the smaller order wins, so the fields stay in this order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Soonest {
    /// Milliseconds from the start.
    time: u64,
    /// Four bits a stop, the first one highest.
    order: u64,
}

impl Soonest {
    /// No order is in time.
    const NEVER: Self = Self {
        time: u64::MAX,
        order: 0,
    };

    /// The stops in their order.
    fn stops(self, count: usize) -> Vec<usize> {
        (0..count)
            .map(|i| (self.order >> (4 * (count - 1 - i)) & 15) as usize)
            .collect()
    }
}

/// The order that is done soonest among those that reach every stop in time; `due` is in
/// milliseconds from the start. `None` if there is no such order, or there are too many stops to
/// say.
pub(crate) fn order_in_time(
    times: &[Vec<u64>],
    precedence: &Precedence,
    due: &[Option<u64>],
) -> Option<Vec<usize>> {
    let count = times.len().saturating_sub(1);
    if count > EXACT {
        return None;
    }
    let all = (1_usize << count) - 1;
    let earlier = precedence.masks();
    // By the stops that are visited and the last of them.
    let mut soonest = vec![vec![Soonest::NEVER; count + 1]; all + 1];
    // `at` 0 is the start, and stop `i` is at `i + 1`.
    soonest[0][0] = Soonest { time: 0, order: 0 };
    // A larger set has a larger mask, so all that lead to a set come before it. With deadlines the
    // search runs from the start, since only from there the time of arrival is known.
    for visited in 0..all {
        for at in 0..=count {
            let now = soonest[visited][at];
            if now.time == u64::MAX {
                continue;
            }
            for next in (0..count).filter(|next| may_follow(&earlier, visited, *next)) {
                let time = now.time.saturating_add(times[at][next + 1]);
                // Only the soonest arrival at each pair of set and last stop is kept: from there it
                // meets every deadline that a later one meets.
                if due[next].is_none_or(|due| time <= due) {
                    let then = Soonest {
                        time,
                        // The next stop takes the lowest four bits and moves the earlier ones up.
                        // So of equal times the minimum is the order that is smallest as a
                        // sequence, nearest to the instruction's.
                        order: now.order << 4 | next as u64,
                    };
                    let known = &mut soonest[visited | 1 << next][next + 1];
                    *known = (*known).min(then);
                }
            }
        }
    }
    let best = soonest[all].iter().min()?;
    (best.time < u64::MAX).then(|| best.stops(count))
}

/// Stops with no time between them, each group in the instruction's order.
fn groups(times: &[Vec<u64>]) -> Vec<Vec<usize>> {
    let mut groups: Vec<Vec<usize>> = Vec::new();
    for stop in 0..times.len().saturating_sub(1) {
        let group = groups.iter_mut().find(|group| {
            group
                .iter()
                // With all of the group, since no time from A to B and from B to C need not mean
                // none from A to C.
                .all(|other| are_at_one_place(times, *other, stop))
        });
        match group {
            Some(group) => group.push(stop),
            None => groups.push(vec![stop]),
        }
    }
    groups
}

fn are_at_one_place(times: &[Vec<u64>], a: usize, b: usize) -> bool {
    times[a + 1][b + 1] == 0 && times[b + 1][a + 1] == 0
}

/// The stops of one place: the instruction's order as far as the precedence allows.
fn within(group: &[usize], precedence: &Precedence) -> Vec<usize> {
    let mut left = group.to_vec();
    let mut order = Vec::new();
    while !left.is_empty() {
        let free = left.iter().position(|stop| {
            let earlier = &precedence.earlier[*stop];
            !left.iter().any(|other| earlier[*other])
        });
        // A precedence has no circle, so one is always free.
        let next = free.unwrap_or_default();
        order.push(left.remove(next));
    }
    order
}

fn places_in_order(times: &[Vec<u64>], precedence: &Precedence) -> Vec<usize> {
    // Row and column 0 are the start.
    if times.len() <= EXACT + 1 {
        exact(times, precedence)
    } else {
        improved(times, precedence)
    }
}

/// Held-Karp from the end: `rest[visited][at]` is the shortest time through all that is not yet
/// visited.
fn exact(times: &[Vec<u64>], precedence: &Precedence) -> Vec<usize> {
    let count = times.len().saturating_sub(1);
    let all = (1_usize << count) - 1;
    let earlier = precedence.masks();
    let mut rest = vec![vec![u64::MAX; count + 1]; all + 1];
    rest[all].fill(0);
    // From the full set down: `rest` of a larger set is known when a smaller one needs it. From the
    // end, so that the order can then be read off from the start, the instruction's first choice at
    // each step.
    for visited in (0..all).rev() {
        for at in 0..=count {
            rest[visited][at] = (0..count)
                .filter(|next| may_follow(&earlier, visited, *next))
                .map(|next| time_by(times, &rest, visited, at, next))
                .min()
                .unwrap_or(u64::MAX);
        }
    }
    let mut visited = 0;
    let mut at = 0;
    let mut order = Vec::with_capacity(count);
    while visited != all {
        // The first of equals, which is the instruction's own.
        let best = (0..count).find(|next| {
            may_follow(&earlier, visited, *next)
                && time_by(times, &rest, visited, at, *next) == rest[visited][at]
        });
        let Some(next) = best else { break };
        order.push(next);
        visited |= 1 << next;
        at = next + 1;
    }
    order
}

/// The shortest time through all that is not yet visited if stop `next` comes next.
fn time_by(times: &[Vec<u64>], rest: &[Vec<u64>], visited: usize, at: usize, next: usize) -> u64 {
    // Saturating below: `u64::MAX` stands for no allowed order, and the sum must not wrap to a
    // short one.
    let behind = rest[visited | 1 << next][next + 1];
    times[at][next + 1].saturating_add(behind)
}

fn mask(row: &[bool]) -> usize {
    row.iter()
        .enumerate()
        .filter(|(_, set)| **set)
        .fold(0, |mask, (i, _)| mask | 1 << i)
}

/// Milliseconds from the start through all stops.
fn length(times: &[Vec<u64>], order: &[usize]) -> u64 {
    let from = std::iter::once(0).chain(order.iter().map(|stop| stop + 1));
    from.zip(order)
        .map(|(from, to)| times[from][to + 1])
        .fold(0, u64::saturating_add)
}

fn nearest_first(times: &[Vec<u64>], precedence: &Precedence) -> Vec<usize> {
    let count = times.len() - 1;
    let mut order = Vec::with_capacity(count);
    let mut done = vec![false; count];
    while order.len() < count {
        let at = order.last().map_or(0, |stop: &usize| stop + 1);
        let next = (0..count)
            // Without a circle some stop is always free, so the order becomes complete and allowed.
            .filter(|stop| !done[*stop] && !waits(&precedence.earlier[*stop], &done))
            .min_by_key(|stop| times[at][stop + 1]);
        let Some(next) = next else { break };
        done[next] = true;
        order.push(next);
    }
    order
}

/// Whether a stop that must come earlier is not done yet.
fn waits(earlier: &[bool], done: &[bool]) -> bool {
    earlier
        .iter()
        .zip(done)
        .any(|(earlier, done)| *earlier && !done)
}

/// Nearest neighbour, then the first shortening move again and again.
fn improved(times: &[Vec<u64>], precedence: &Precedence) -> Vec<usize> {
    let mut order = nearest_first(times, precedence);
    let mut best = length(times, &order);
    for _ in 0..MOST_PASSES {
        let before = best;
        for from in 0..order.len() {
            for piece in 1..=LONGEST_PIECE.min(order.len() - from) {
                for to in 0..=order.len() - piece {
                    let changed = moved(&order, from, piece, to);
                    keep_if_shorter(times, precedence, &mut order, &mut best, changed);
                }
            }
            // 2-opt: a piece of at least two stops the other way round. Times may differ by
            // direction, so its whole length is computed anew.
            for to in from + 2..=order.len() {
                let mut changed = order.clone();
                changed[from..to].reverse();
                keep_if_shorter(times, precedence, &mut order, &mut best, changed);
            }
        }
        if best == before {
            break;
        }
    }
    order
}

/// An order with a piece of it moved.
fn moved(order: &[usize], from: usize, piece: usize, to: usize) -> Vec<usize> {
    let mut moved = order.to_vec();
    let taken: Vec<usize> = moved.drain(from..from + piece).collect();
    moved.splice(to..to, taken);
    moved
}

fn keep_if_shorter(
    times: &[Vec<u64>],
    precedence: &Precedence,
    order: &mut Vec<usize>,
    best: &mut u64,
    changed: Vec<usize>,
) {
    let shorter = length(times, &changed);
    // The cheap test first: most moves are not shorter.
    if shorter < *best && precedence.allows(&changed) {
        *order = changed;
        *best = shorter;
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn equal(count: usize) -> Vec<Vec<u64>> {
        (0..=count)
            .map(|i| (0..=count).map(|j| if i == j { 0 } else { 5 }).collect())
            .collect()
    }

    /// Times between places on a line, the start at 0.
    fn line(places: &[i64]) -> Vec<Vec<u64>> {
        let all: Vec<i64> = std::iter::once(0).chain(places.iter().copied()).collect();
        all.iter()
            .map(|a| all.iter().map(|b| a.abs_diff(*b)).collect())
            .collect()
    }

    /// The shortest allowed order, by trying all; the first of equals.
    fn brute_force(times: &[Vec<u64>], precedence: &Precedence) -> (u64, Vec<usize>) {
        fn go(left: &[usize], order: &mut Vec<usize>, visit: &mut impl FnMut(&[usize])) {
            if left.is_empty() {
                visit(order);
            }
            for (i, next) in left.iter().enumerate() {
                order.push(*next);
                go(&[&left[..i], &left[i + 1..]].concat(), order, visit);
                order.pop();
            }
        }
        let mut best = (u64::MAX, Vec::new());
        go(
            &(0..times.len() - 1).collect::<Vec<_>>(),
            &mut Vec::new(),
            &mut |order| {
                if precedence.allows(order) && length(times, order) < best.0 {
                    best = (length(times, order), order.to_vec());
                }
            },
        );
        best
    }

    #[test]
    fn equal_or_unknown_times_keep_the_instructions_order() {
        for count in [0, 1, 5, 12, 20] {
            let order: Vec<usize> = (0..count).collect();
            assert_eq!(best_order(&equal(count), &Precedence::new(count)), order);
            let unknown = vec![vec![UNKNOWN; count + 1]; count + 1];
            assert_eq!(best_order(&unknown, &Precedence::new(count)), order);
        }
    }

    #[test]
    fn nearer_stops_come_first_unless_the_instruction_says_otherwise() {
        let times = line(&[30, 10, 20]);
        assert_eq!(best_order(&times, &Precedence::new(3)), [1, 2, 0]);
        let mut precedence = Precedence::new(3);
        assert!(precedence.add(0, 1));
        assert_eq!(best_order(&times, &precedence), [0, 2, 1]);
    }

    #[test]
    fn stops_at_one_place_stay_together() {
        assert_eq!(
            best_order(&line(&[30, 10, 30, 10]), &Precedence::new(4)),
            [1, 3, 0, 2]
        );
    }

    #[test]
    fn a_stop_required_in_between_splits_a_place() {
        let mut precedence = Precedence::new(3);
        assert!(precedence.add(0, 1) && precedence.add(1, 2));
        assert!(!precedence.add(2, 0), "a circle is refused");
        assert_eq!(best_order(&line(&[10, 90, 10]), &precedence), [0, 1, 2]);
    }

    #[test]
    fn deadlines_are_met_by_the_shortest_order() {
        let times = line(&[30, 10, -20]);
        let order = |due: [Option<u64>; 3]| order_in_time(&times, &Precedence::new(3), &due);
        assert_eq!(
            order([None, None, Some(200)]),
            Some(vec![2, 1, 0]),
            "the shortest is in time"
        );
        assert_eq!(
            order([Some(30), None, None]),
            Some(vec![0, 1, 2]),
            "as short, and as said"
        );
        assert_eq!(order([None, Some(10), Some(40)]), Some(vec![1, 2, 0]));
        assert_eq!(order([Some(30), None, Some(20)]), None);
        let all_alike = order_in_time(
            &equal(4),
            &Precedence::new(4),
            &[None, None, Some(99), None],
        );
        assert_eq!(
            all_alike,
            Some(vec![0, 1, 2, 3]),
            "of equals the instruction's"
        );
        let mut precedence = Precedence::new(3);
        assert!(precedence.add(2, 0));
        assert_eq!(
            order_in_time(&times, &precedence, &[Some(60), None, None]),
            None
        );
    }

    /// An order with each of the other stops behind it.
    fn longer(order: &[usize], count: usize) -> Vec<Vec<usize>> {
        let others = (0..count).filter(|next| !order.contains(next));
        others.map(|next| [order, &[next]].concat()).collect()
    }

    proptest! {
        #[test]
        fn orders_in_time_are_the_shortest_of_their_kind(
            cells in proptest::collection::vec(1_u64..40, 36),
            due in proptest::collection::vec(proptest::option::of(1_u64..120), 5),
            pair in (0_usize..5, 0_usize..5),
        ) {
            let times: Vec<Vec<u64>> = (0..=5).map(|i| cells[i * 6..i * 6 + 6].to_vec()).collect();
            let mut precedence = Precedence::new(5);
            precedence.add(pair.0, pair.1);
            let in_time = |order: &[usize]| {
                let mut now = 0;
                std::iter::once(0).chain(order.iter().map(|s| s + 1)).zip(order).all(|(from, to)| {
                    now += times[from][to + 1];
                    due[*to].is_none_or(|due| now <= due)
                })
            };
            let mut orders: Vec<Vec<usize>> = vec![vec![]];
            for _ in 0..5 {
                orders = orders.iter().flat_map(|order| longer(order, 5)).collect();
            }
            let allowed = orders.iter().filter(|order| precedence.allows(order) && in_time(order));
            let best = allowed.map(|order| length(&times, order)).min();
            let found = order_in_time(&times, &precedence, &due);
            prop_assert_eq!(found.as_ref().map(|o| length(&times, o)), best);
            if let Some(order) = found {
                prop_assert!(precedence.allows(&order) && in_time(&order));
            }
        }

        #[test]
        fn exact_orders_equal_brute_force(
            cells in proptest::collection::vec(1_u64..40, 49),
            pairs in proptest::collection::vec((0_usize..6, 0_usize..6), 0..6),
            count in 1_usize..=6,
        ) {
            let row = |i: usize| cells[i * 7..=i * 7 + count].to_vec();
            let times: Vec<Vec<u64>> = (0..=count).map(row).collect();
            let mut precedence = Precedence::new(count);
            pairs.iter().for_each(|(a, b)| { precedence.add(*a, *b); });
            let (shortest, first) = brute_force(&times, &precedence);
            prop_assert_eq!(length(&times, &exact(&times, &precedence)), shortest);
            prop_assert_eq!(best_order(&times, &precedence), first);
            let good = improved(&times, &precedence);
            prop_assert!(precedence.allows(&good) && good.len() == count);
        }

        #[test]
        fn long_orders_are_good_and_keep_the_precedence(
            places in proptest::collection::vec(-500_i64..500, 13..25),
            pairs in proptest::collection::vec((0_usize..13, 0_usize..13), 0..4),
        ) {
            let times = line(&places);
            let mut precedence = Precedence::new(places.len());
            pairs.iter().for_each(|(a, b)| { precedence.add(*a, *b); });
            let order = best_order(&times, &precedence);
            prop_assert!(precedence.allows(&order));
            let mut sorted = order.clone();
            sorted.sort_unstable();
            prop_assert_eq!(sorted, (0..places.len()).collect::<Vec<_>>());
            if pairs.is_empty() {
                let low = places.iter().copied().min().unwrap_or(0);
                let high = places.iter().copied().max().unwrap_or(0);
                let shortest = match (low >= 0, high <= 0) {
                    (true, _) => high,
                    (_, true) => -low,
                    _ => high - low + high.min(-low),
                };
                let length = length(&times, &order);
                prop_assert!(length * 2 <= 3 * shortest.unsigned_abs(), "{length} {shortest}");
            }
        }
    }
}
