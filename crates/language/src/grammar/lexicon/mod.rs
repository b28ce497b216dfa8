//! The words of each language as data: one file a language, one table each. The engine knows classes of words, not words.
//!
//! Entries are written naturally (accents, several words, apostrophes); the index folds them as it folds instructions. A new
//! language is a new file and a line in [`LANGUAGES`].

mod de;
mod en;
mod es;
mod fr;
mod ja;
mod zh;

/// What a word does in an instruction.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Class {
    /// Names the building level: `building`, `号楼`.
    Building,
    /// Names the building level, but may mean a floor: `3楼`. Counts where no other building is named.
    WeakBuilding,
    /// Names the unit level: `unit`, `单元`.
    Unit,
    /// Names a level below the unit: `flat`, `室`. Counts as the unit where no unit is named.
    Room,
    /// Names a floor, which is behind a door.
    Floor,
    /// A letter that means building when a number is glued to it: `B8`.
    BuildingLetter,
    /// A letter that means unit when a number is glued to it: `U3`.
    UnitLetter,
    /// Stands between a level and its number: `no.`, `第`.
    Sign,
    /// Ties a unit to its building: `of`, `的`.
    Link,
    /// `the`, `der`.
    Article,
    /// Says where to: `to`, `送到`.
    Toward,
    /// Lists: `and`, `和`.
    And,
    /// Between the ends of a range: `through`, `bis`.
    Range,
    /// The next stop comes after those before: `then`, `然后`.
    Then,
    /// As `then`; where no stop is named before it, the next one comes after all others: `finally`, `最后`.
    Finally,
    /// The nearest stop comes before all others of the sentence: `first`, `先`.
    First,
    /// The nearest stop comes after all others: `last`.
    Last,
    /// The stop before the word precedes the one after it: `before`. After a `not` the other way round: `not … until`.
    Before,
    /// The stop before the word follows the one after it: `after`.
    After,
    /// The stop before the word follows the one after it, in whatever language: `has to wait until`, `要等`.
    Wait,
    /// Says where to, or, where another stop follows in the sentence, as `after`: `nach`.
    TowardOrAfter,
    /// The next place is not meant: `not`, `别`.
    Not,
    /// As [`Class::Not`], of some of all: `apart from`, `除了`.
    Except,
    /// As [`Class::Except`], behind the place: `以外`.
    ExceptBehind,
    /// As [`Class::Elsewhere`], for both of two places: `between`.
    Between,
    /// What follows may be so or not: `if`.
    If,
    /// The sender does not know which of the places is meant: `I'm not sure which`.
    Unsure,
    /// The next place replaces the one before: `I mean`, `不对`.
    Correct,
    /// The next place is only a landmark or the origin: `from`, `next to`.
    Elsewhere,
    /// The next place is the sender's, also behind a colon: `sender`, `寄件地址`.
    Sender,
    /// Behind a person's name: who lives at the place before it speaks: `の鈴木ですが`.
    Speaking,
    /// The place before the word is not meant, or only a landmark: `ではなく`, `旁边`.
    NotBefore,
    /// The place before the word, words without weight between them, is not meant any more: `was cancelled`.
    Dropped,
    /// The same, if another place is meant: `is closed`.
    Absent,
    /// The place before the word is where something comes from: `sends`, `寄来的`.
    Sends,
    /// What follows, or stands before, comes on top of the rest: `also`.
    Also,
    /// Deals units out to buildings one by one, or the same to each: `respectively`, `分别`.
    Respectively,
    /// Deals the same out to each: `each`, `各`.
    Each,
    /// The unit behind it is that of all buildings before that have none: `always`, `都是`.
    Shared,
    /// Where something is to be fetched, or somebody is for now: the next place, things before it, is an origin: `pick up`.
    Pickup,
    /// Before a word for a level without numbers, all of the building's: `all`, `所有`.
    All,
    /// The same in one word: `每个单元`, `全室`.
    AllUnits,
    /// The stops come in the order in which they are named: `in this order`.
    InOrder,
    /// The stops named before come the other way round: `swap the order`.
    Swap,
    /// The stop of its clause comes before the one named before: `before that`.
    Earlier,
    /// As [`Class::Correct`], but may stand behind the place: `instead`.
    Instead,
    /// Takes back all that was said before, which may not be the sender speaking: `ignore the above`.
    Override,
    /// The building named before: `same building`.
    Same,
    /// The unit named before, of another building: `same unit`.
    SameUnit,
    /// With a word for units, every second one: `even`.
    Even,
    /// The same of the others.
    Odd,
    /// Where something is put down: before a building as [`Class::Elsewhere`], before a unit as `at`.
    InFront,
    /// Begins a person's name: `Mrs`.
    Title,
    /// A thing to deliver.
    Item,
    /// Begins an item: `this`, `这个`.
    Determiner,
    /// A verb of delivering.
    Verb,
    /// A word without weight: `please`.
    Filler,
    /// A number before it is no address: `kg`, `pm`.
    Measure,
    /// A number after it is no address: `order`, `phone`.
    Reference,
}

/// The words of one language.
pub(crate) struct Lexicon {
    /// Words by what they do.
    pub words: &'static [(Class, &'static [&'static str])],
    /// Numbers that count: `three`. Tens and units are put together by the engine.
    pub cardinals: &'static [(&'static str, u32)],
    /// Numbers that order: `third`.
    pub ordinals: &'static [(&'static str, u32)],
    /// Endings that make digits ordinal: `3rd`.
    pub ordinal_endings: &'static [&'static str],
    /// Articles that are the number one after a word for a level: `bâtiment un`.
    pub ones: &'static [&'static str],
    /// How plurals of words for levels end, folded: `s`.
    pub plural_endings: &'static [&'static str],
    /// Words between tens and units: `y` in `treinta y uno`.
    pub joints: &'static [&'static str],
    /// Whether tens and units make one word with the units first: `einundzwanzig`.
    pub units_first: Option<&'static str>,
    /// Whether the number stands before the level: `3号楼`.
    pub number_first: bool,
    /// The script that the language is told by.
    pub script: Script,
    /// Words of deadlines.
    pub times: Times,
}

/// How a language says until when.
pub(crate) struct Times {
    /// Before a time of day: `by`.
    pub by: &'static [&'static str],
    /// After one: `までに`.
    pub by_after: &'static [&'static str],
    /// Before a length of time: `within`.
    pub within: &'static [&'static str],
    /// After one: `以内`.
    pub within_after: &'static [&'static str],
    /// Before an hour that needs no other word: `a las`.
    pub at: &'static [&'static str],
    /// After the hour: `o'clock`, `h`.
    pub clock: &'static [&'static str],
    /// Half past, after the hour: `半`.
    pub half: &'static [&'static str],
    /// Before a deadline that is of all doors of its sentence: `both`.
    pub all: &'static [&'static str],
    /// The hours before noon, before or after the hour: `a.m.`, `上午`.
    pub am: &'static [&'static str],
    /// Those after.
    pub pm: &'static [&'static str],
    /// Twelve o'clock in the day.
    pub noon: &'static [&'static str],
    /// Minutes.
    pub minutes: &'static [&'static str],
    /// Hours of length.
    pub hours: &'static [&'static str],
    /// Thirty minutes.
    pub half_hour: &'static [&'static str],
    /// Sixty, where that is no number and `hour`.
    pub one_hour: &'static [&'static str],
    /// Days that are not today.
    pub other_days: &'static [&'static str],
    /// Before the beginning of a span: `from`.
    pub from: &'static [&'static str],
    /// Whether hours are counted to twelve twice, and the half of the day is often left out.
    pub has_half_days: bool,
}

/// How a language is told from others.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Script {
    /// By its words, against the other languages in Latin letters.
    Latin,
    /// By ideographs without kana.
    Han,
    /// By kana.
    Kana,
}

/// All languages; the first is the one assumed in doubt.
pub(crate) const LANGUAGES: [&Lexicon; 6] =
    [&en::LEXICON, &zh::LEXICON, &es::LEXICON, &de::LEXICON, &fr::LEXICON, &ja::LEXICON];

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn no_language_says_a_word_twice() {
        for lexicon in LANGUAGES {
            let mut seen = BTreeSet::new();
            let words = lexicon.words.iter().flat_map(|(_, words)| words.iter());
            for word in words.chain(lexicon.cardinals.iter().map(|(w, _)| w)) {
                assert!(seen.insert(*word), "`{word}` stands twice");
            }
        }
    }

    #[test]
    fn every_language_can_say_an_address() {
        for lexicon in LANGUAGES {
            let denies = |class: Class| matches!(class, Class::Not | Class::NotBefore);
            assert!(lexicon.words.iter().any(|(class, words)| denies(*class) && !words.is_empty()));
            for class in [Class::Building, Class::Unit, Class::And, Class::Then, Class::All, Class::Item] {
                assert!(lexicon.words.iter().any(|(c, words)| *c == class && !words.is_empty()), "{class:?}");
            }
        }
    }
}
