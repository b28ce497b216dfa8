//! Errors in words.

use std::error::Error;

/// An error and its causes in one line, separated by colons.
///
/// A cause whose text the line already contains is not repeated: some errors include their source
/// in their own text, others do not.
///
/// ```
/// use openbench_core::with_causes;
///
/// #[derive(Debug, thiserror::Error)]
/// #[error("the width is unreadable")]
/// struct WidthError(#[source] std::num::ParseFloatError);
///
/// let error = WidthError("12 m".parse::<f64>().unwrap_err());
/// assert_eq!(with_causes(&error), "the width is unreadable: invalid float literal");
/// ```
pub fn with_causes(error: &dyn Error) -> String {
    let mut text = error.to_string();
    let mut cause = error.source();
    while let Some(error) = cause {
        let next = error.to_string();
        if !text.contains(&next) {
            text.push_str(": ");
            text.push_str(&next);
        }
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

    /// An error that includes its source in its own text.
    #[derive(Debug)]
    struct Repeating(UnknownName);

    impl std::fmt::Display for Repeating {
        fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
            write!(f, "no suite: {}", self.0)
        }
    }

    impl Error for Repeating {
        fn source(&self) -> Option<&(dyn Error + 'static)> {
            Some(&self.0)
        }
    }

    impl Error for Outer {
        fn source(&self) -> Option<&(dyn Error + 'static)> {
            Some(&self.0)
        }
    }

    #[test]
    fn a_cause_that_was_said_is_not_repeated() {
        let cause = UnknownName {
            kind: "suite",
            name: "motion=zigzag".into(),
            known: Vec::new(),
        };
        let said = with_causes(&Outer(cause.clone()));
        assert_eq!(said, format!("motion=zigzag: {cause}"));
        let repeated = with_causes(&Repeating(cause.clone()));
        assert_eq!(repeated, format!("no suite: {cause}"));
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
            "motion=zigzag: there is no local planner `zigzag`; known: teb"
        );
    }
}
