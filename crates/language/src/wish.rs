//! What an instruction asks for, before the map has been asked.

use openbench_core::{AddressLevel, Deadline};

/// How an instruction names a place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Named {
    /// By a number or letter, folded, and the words that it stands with.
    Label { label: String, said: String },
    /// By one of the map's names: the places that bear it, and how many of a hundred of its letters are right.
    Places { places: Vec<usize>, percent: u8 },
    /// By words that the map does not have.
    Words(String),
    /// All units of the building but those with these labels, folded; if there are `count` of them, where that is said; of numbers with this `parity`, if with any.
    All { but: Vec<String>, count: Option<usize>, parity: Option<usize> },
}

/// A door to deliver to.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Wish {
    /// In the instruction's words; may be empty.
    pub item: String,
    /// `None`: the instruction names a unit only.
    pub building: Option<Named>,
    pub unit: Option<Named>,
    /// Whether the unit is said as a flat or a room, which may lie behind another door.
    pub is_room: bool,
    /// Whether these may be the words of somebody else than the sender, a label's say.
    pub doubtful: bool,
    /// Whether the sender says not to know whether this door is meant or another.
    pub unsure: bool,
    /// Until when.
    pub due: Option<Deadline>,
    /// What is said around it, among which the levels above the building may be, as `text::spelt` has it.
    pub around: String,
    /// The levels below the unit.
    pub below: Vec<AddressLevel>,
}

/// All doors, in the order of the instruction, and which must come before which.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Wishes {
    pub doors: Vec<Wish>,
    /// Pairs (earlier, later) of indices into `doors`.
    pub before: Vec<(usize, usize)>,
    /// What is said before all doors and of all of them.
    pub around_all: String,
}
