//! How many typing errors part two words.

/// The Damerau-Levenshtein distance (optimal string alignment) from `a` to `b`: insertions,
/// deletions, substitutions and swaps of neighbours. More than `limit` if it is more.
pub(crate) fn edit_distance(a: &str, b: &str, limit: usize) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    // Each letter more or less is an edit, so the table would show nothing else.
    if a.len().abs_diff(b.len()) > limit {
        return limit + 1;
    }
    let mut costs = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            // `costs[i][j]`: distance of the first `i` letters of `a` from the first `j` of `b`.
            // Against no letters it is a deletion or insertion of all.
            costs[i][j] = if i == 0 || j == 0 {
                i + j
            } else {
                let kept = costs[i - 1][j - 1] + usize::from(a[i - 1] != b[j - 1]);
                let swapped = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
                let swap = if swapped {
                    costs[i - 2][j - 2] + 1
                } else {
                    usize::MAX
                };
                kept.min(swap)
                    .min(costs[i - 1][j] + 1)
                    .min(costs[i][j - 1] + 1)
            };
        }
    }
    costs[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_are_counted_with_swaps() {
        for (a, b, edits) in [
            ("building", "buidling", 1),
            ("unit", "unti", 1),
            ("kitten", "sitting", 3),
            ("", "ab", 2),
        ] {
            assert_eq!(edit_distance(a, b, 9), edits, "{a} {b}");
        }
    }
}
