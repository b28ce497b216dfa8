//! What single words say beyond their class.

/// A grammatical feature of a word.
///
/// A class belongs to an entry in the languages of a text. A feature belongs to a folded word in
/// any text, since instructions mix languages and quote signs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Feature {
    /// Joins alternatives: `or`, `oder`.
    Disjunction,
    /// Is the sender: `I`.
    FirstPerson,
    /// An article of the plural, which makes the number behind it an amount: `las cuatro`.
    PluralArticle,
    /// A preposition of direction that also says where a thing is: `au`.
    Locative,
    /// A preposition of possession that also says where a thing comes from: `von`.
    Ablative,
    /// Begins a word for what a number counts: `个`.
    Counter,
    /// A word for a building that also counts buildings: `栋楼`.
    BuildingCounter,
    /// Before a number, says that there are so many: `有四个单元`.
    ExistenceBefore,
    /// Behind what is counted, says that there are so many: `12棟あります`.
    ExistenceBehind,
    /// A mark that lists as a comma does: `、`.
    EnumerationComma,
    /// Makes the numeral behind it an ordinal: `第`.
    OrdinalPrefix,
    /// A point of the compass that may stand inside a name: `北`.
    Compass,
}
