//! Numbers of things in words.

/// `1 delivery`, `3 deliveries`.
pub fn count(n: usize, one: &str, many: &str) -> String {
    format!("{n} {}", if n == 1 { one } else { many })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_singular_and_none_is_not() {
        assert_eq!(count(1, "door", "doors"), "1 door");
        assert_eq!(count(0, "door", "doors"), "0 doors");
    }
}
