//! What an instruction asks for, before it is looked up on the map.

use openbench_core::{AddressLevel, Deadline};

/// How an instruction names a building or a unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Named {
    /// By a number or letter, folded, and the words that it stands with.
    Label { label: String, said: String },
    /// By one of the map's names: the places that have it, and the percentage of its letters that
    /// are right.
    Places { places: Vec<usize>, percent: u8 },
    /// By words that the map does not have.
    Words(String),
    /// All units of the building but those with these labels, folded.
    All {
        but: Vec<String>,
        /// How many there are, if the instruction says so.
        count: Option<usize>,
        /// The labels' remainder divided by two, if only even or odd ones are meant.
        parity: Option<usize>,
    },
}

/// A door to deliver to.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Wish {
    /// In the instruction's words; may be empty.
    pub item: String,
    /// `None`: the instruction names a unit only.
    pub building: Option<Named>,
    pub unit: Option<Named>,
    /// Whether the unit is said as a flat or a room, which may be behind an entrance.
    pub is_room: bool,
    /// Whether these may not be the sender's words but, for instance, those of a label.
    pub doubtful: bool,
    /// Whether the sender says not to know whether this door is meant or another.
    pub unsure: bool,
    pub due: Option<Deadline>,
    /// The words around it, among which the levels above the building may be, folded as
    /// `lexicon::tokens::spelt` does.
    pub around: String,
    /// The levels below the unit.
    pub below: Vec<AddressLevel>,
}

/// All doors, in the order of the instruction, and which must come before which.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Wishes {
    pub doors: Vec<Wish>,
    /// Orders among `doors`.
    pub before: Vec<Precedes>,
    /// The words before all doors, which are said of all of them.
    pub around_all: String,
}

/// One door or stop must come before another: indices into a list of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Precedes {
    pub earlier: usize,
    pub later: usize,
}

impl Precedes {
    /// The other way round.
    pub(crate) fn turned(self) -> Self {
        Self {
            earlier: self.later,
            later: self.earlier,
        }
    }
}
