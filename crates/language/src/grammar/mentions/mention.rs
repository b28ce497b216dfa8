//! A place that an instruction names: its level, and the labels or names.

use std::ops::Range;

use crate::lexicon::class::Class;

/// A level of the address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Level {
    Building,
    Unit,
    /// Below the unit; stands for it where no unit is named.
    Room,
}

impl Level {
    /// The level that words of a class name.
    pub(crate) fn of(class: Class) -> Option<Self> {
        match class {
            Class::Building | Class::WeakBuilding => Some(Self::Building),
            Class::Unit => Some(Self::Unit),
            Class::Room => Some(Self::Room),
            _ => None,
        }
    }
}

/// What is named at a level.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Target {
    /// A number or letter, folded, and the words that it stands with: `3` and `Tower 3`.
    Label { label: String, said: String },
    /// A name on the map: index into the names found in the text.
    Name(usize),
    /// Words that the map does not have.
    Words(String),
    /// All units of the building but those with these labels.
    All {
        but: Vec<String>,
        /// How many there are, where only their number says that all are meant: `the four units`.
        count: Option<usize>,
        /// The labels' remainder divided by two, where only those are meant: `even units`.
        parity: Option<usize>,
    },
}

impl Target {
    /// A number that stands alone.
    pub(crate) fn bare(label: &str) -> Self {
        Self::Label {
            label: label.to_owned(),
            said: label.to_owned(),
        }
    }

    /// Whether two targets have the same label or name.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Label { label: a, .. }, Self::Label { label: b, .. }) => a == b,
            (Self::Name(a), Self::Name(b)) => a == b,
            _ => false,
        }
    }
}

/// A place that is named.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Mention {
    pub level: Level,
    /// One or more: `units 1 and 2`.
    pub targets: Vec<Target>,
    /// The lexemes that it takes.
    pub at: Range<usize>,
    /// Whether it counts only where no other building is named.
    pub weak: bool,
}

impl Mention {
    /// A mention of one target that counts in any case.
    pub(crate) fn one(level: Level, target: Target, at: Range<usize>) -> Self {
        Self {
            level,
            targets: vec![target],
            at,
            weak: false,
        }
    }

    /// All doors of a level of the building.
    pub(crate) fn all(level: Level, at: Range<usize>, count: Option<usize>) -> Self {
        Self::one(
            level,
            Target::All {
                but: Vec::new(),
                count,
                parity: None,
            },
            at,
        )
    }

    /// Whether it is one of a building.
    pub(crate) fn is_building(&self) -> bool {
        self.level == Level::Building
    }

    /// Whether a target is among its own.
    pub(crate) fn names(&self, target: &Target) -> bool {
        self.targets.iter().any(|own| own.is_same(target))
    }

    /// Whether all targets of another mention are among its own.
    pub(crate) fn names_all_of(&self, other: &Self) -> bool {
        other.targets.iter().all(|target| self.names(target))
    }
}
