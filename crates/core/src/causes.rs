//! Errors in words.

use std::error::Error;

/// An error and its causes in one line, separated by colons.
///
/// Errors of this project do not repeat their source in their own text, so whoever shows one to
/// people shows the causes too.
///
/// ```
/// use openbench_core::with_causes;
///
/// let error = "12 m".parse::<f64>().unwrap_err();
/// assert_eq!(with_causes(&error), "invalid float literal");
/// ```
pub fn with_causes(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        text.push_str(": ");
        text.push_str(&error.to_string());
        cause = error.source();
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::registry::UnknownName;

    #[derive(Debug)]
    struct Outer(UnknownName);

    impl std::fmt::Display for Outer {
        fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            f.write_str("motion=zigzag")
        }
    }

    impl Error for Outer {
        fn source(&self) -> Option<&(dyn Error + 'static)> {
            Some(&self.0)
        }
    }

    #[test]
    fn causes_follow_the_error() {
        let known = vec!["teb".to_owned()];
        let cause = UnknownName {
            kind: "local planner",
            name: "zigzag".into(),
            known,
        };
        let text = with_causes(&Outer(cause));
        assert_eq!(
            text,
            "motion=zigzag: there is no local planner `zigzag`; there are teb"
        );
    }
}
