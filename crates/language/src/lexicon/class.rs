//! What a word does in an instruction: the classes that the grammar knows instead of words.

/// What a word does in an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Class {
    /// Names the building level: `building`, `号楼`.
    Building,
    /// Names the building level, but may mean a floor: `3楼`. Counts if no other building is named.
    WeakBuilding,
    /// Names the unit level: `unit`, `单元`.
    Unit,
    /// Names a level below the unit: `flat`, `室`. Counts as the unit if no unit is named.
    Room,
    /// Names a floor, which is behind a door: `storey`, `层`.
    Floor,
    /// A letter that means building when a number is glued to it: `B8`.
    BuildingLetter,
    /// A letter that means unit when a number is glued to it: `U3`.
    UnitLetter,
    /// Stands between a level and its number: `no.`, `第`.
    Sign,
    /// Links a unit to its building: `of`, `的`.
    Link,
    /// A definite article: `the`, `der`.
    Article,
    /// Introduces a destination: `to`, `送到`.
    Toward,
    /// Joins the items of a list: `and`, `和`.
    And,
    /// Stands between the ends of a range: `through`, `bis`.
    Range,
    /// The next stop comes after those before: `then`, `然后`.
    Then,
    /// As [`Class::Then`]. If no stop is named before it, the next one comes after all others:
    /// `finally`, `最后`.
    Finally,
    /// The nearest stop comes before all others of the sentence: `first`, `先`.
    First,
    /// The nearest stop comes after all others: `last`.
    Last,
    /// The stop before the word precedes the one behind it: `before`. After a `not` the other way
    /// round: `not … until`.
    Before,
    /// The stop before the word follows the one behind it: `after`.
    After,
    /// As [`Class::After`], also in languages that put such words behind the place: `has to wait
    /// until`, `要等`.
    Wait,
    /// As [`Class::Toward`], or as [`Class::After`] if another stop follows in the sentence:
    /// `nach`.
    TowardOrAfter,
    /// The next place is not meant: `not`, `别`.
    Not,
    /// As [`Class::Not`], for some of all units: `apart from`, `除了`.
    Except,
    /// As [`Class::Except`], behind the place: `以外`.
    ExceptBehind,
    /// As [`Class::Elsewhere`], for both of two places: `between`.
    Between,
    /// Begins a condition: `if`.
    If,
    /// The sender does not know which of the places is meant: `I'm not sure which`.
    Unsure,
    /// The next place replaces the one before: `I mean`, `不对`.
    Correct,
    /// The next place is a landmark or the origin: `from`, `next to`.
    Elsewhere,
    /// The next place is the sender's, also behind a colon: `sender`, `寄件地址`.
    Sender,
    /// Behind a person's name: the sender, who lives at the place before it: `の鈴木ですが`.
    Speaking,
    /// The place before the word is not meant, or is a landmark: `ではなく`, `旁边`.
    NotBefore,
    /// The place before the word is not meant any more, words without weight between them: `was
    /// cancelled`.
    Dropped,
    /// As [`Class::Dropped`], but only if another place is meant: `is closed`.
    Absent,
    /// The place before the word is an origin: `sends`, `寄来的`.
    Sends,
    /// The place beside the word is meant besides the others: `also`.
    Also,
    /// Assigns units to buildings one by one, or the same ones to each: `respectively`, `分别`.
    Respectively,
    /// Assigns the same to each: `each`, `各`.
    Each,
    /// The unit behind it is that of all buildings before it without a unit: `always`, `都是`.
    Shared,
    /// The next place is where things are fetched, the things named between: `pick up`.
    Pickup,
    /// Before a word for a level without numbers: all of the building's: `all`, `所有`.
    All,
    /// All units of the building, in one word: `每个单元`, `全室`.
    AllUnits,
    /// The stops come in the order in which they are named: `in this order`.
    InOrder,
    /// The stops named before it come the other way round: `swap the order`.
    Swap,
    /// The stop of its clause comes before the one named before it: `before that`.
    Earlier,
    /// As [`Class::Correct`], but may stand behind the place: `instead`.
    Instead,
    /// Takes back all that was said before; perhaps not the sender's words: `ignore the above`.
    Override,
    /// The building named before it: `same building`.
    Same,
    /// The unit named before it, of another building: `same unit`.
    SameUnit,
    /// With a word for units, every second one: `even`.
    Even,
    /// As [`Class::Even`], for the others: `odd`.
    Odd,
    /// As [`Class::Elsewhere`] before a building; before a unit it is the destination: `in front
    /// of`.
    InFront,
    /// Begins a person's name: `Mrs`.
    Title,
    /// A thing to deliver: `box`.
    Item,
    /// Begins an item: `this`, `这个`.
    Determiner,
    /// A verb of delivering: `take`.
    Verb,
    /// A word without weight: `please`.
    Filler,
    /// A number before it is no address: `kg`, `pm`.
    Measure,
    /// A number after it is no address: `order`, `phone`.
    Reference,
}
