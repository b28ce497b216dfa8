//! The three sizes of neighbourhoods.

use std::fmt;
use std::str::FromStr;

/// The size of a neighbourhood, after the built-in world of the same name.
///
/// ```
/// use openbench_neighbourhoods::Kind;
///
/// assert_eq!("large".parse(), Ok(Kind::Large));
/// assert_eq!(Kind::Small.to_string(), "small");
/// assert!("huge".parse::<Kind>().is_err());
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// One street, some 70 m long, with a handful of buildings.
    Small,
    /// Some 120 m by 120 m with about fourteen buildings.
    Medium,
    /// Some 200 m by 140 m with about 25 buildings.
    Large,
}

impl Kind {
    /// All kinds, by size.
    pub const ALL: [Self; 3] = [Self::Small, Self::Medium, Self::Large];

    /// The name: that of the built-in world.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Small => "small",
            Self::Medium => "medium",
            Self::Large => "large",
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is no kind.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownKind(String);

impl fmt::Display for UnknownKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}` is no kind of neighbourhood; ", self.0)?;
        f.write_str("there are small, medium and large")
    }
}

impl std::error::Error for UnknownKind {}

impl FromStr for Kind {
    type Err = UnknownKind;

    fn from_str(name: &str) -> Result<Self, UnknownKind> {
        let found = Self::ALL.into_iter().find(|kind| kind.name() == name);
        found.ok_or_else(|| UnknownKind(name.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kinds_are_read_by_their_names() {
        for kind in Kind::ALL {
            assert_eq!(kind.name().parse(), Ok(kind));
        }
        let error = "huge".parse::<Kind>().unwrap_err().to_string();
        assert!(
            error.contains("huge") && error.contains("medium"),
            "{error}"
        );
    }
}
