//! What a language file contains: words by class, numbers, words of deadlines.

use super::class::Class;
use super::feature::Feature;

/// The words of one language.
pub(crate) struct Language {
    /// Words by class.
    pub words: &'static [(Class, &'static [&'static str])],
    /// Words with a grammatical feature, folded.
    pub features: &'static [(Feature, &'static [&'static str])],
    /// Numbers that count: `three`. The lexer puts tens and units together.
    pub cardinals: &'static [(&'static str, u32)],
    /// Numbers that order: `third`.
    pub ordinals: &'static [(&'static str, u32)],
    /// Endings that make digits an ordinal: `rd` in `3rd`.
    pub ordinal_endings: &'static [&'static str],
    /// Articles that are the number one behind a word for a level: `bâtiment un`.
    pub ones: &'static [&'static str],
    /// How plurals of words for levels end, folded: `s`.
    pub plural_endings: &'static [&'static str],
    /// Words between tens and units: `y` in `treinta y uno`.
    pub joints: &'static [&'static str],
    /// Words between hundreds and the rest: `and` in `one hundred and five`.
    pub hundred_joints: &'static [&'static str],
    /// How tens and units make one word with the units first, where they do: `einundzwanzig`.
    pub units_first: Option<UnitsFirst>,
    /// Ideographs that are numbers: `三`.
    pub numerals: &'static [(&'static str, u32)],
    /// Marks that list numbers if they stand right behind digits: `・` in `1・2号室`.
    pub digit_separators: &'static [&'static str],
    /// Whether the number stands before the level: `3号楼`.
    pub number_first: bool,
    /// How the language is recognized.
    pub script: Script,
    /// Words of deadlines.
    pub times: Times,
}

impl Language {
    /// A language without words.
    pub(super) const EMPTY: Self = Self {
        words: &[],
        features: &[],
        cardinals: &[],
        ordinals: &[],
        ordinal_endings: &[],
        ones: &[],
        plural_endings: &[],
        joints: &[],
        hundred_joints: &[],
        units_first: None,
        numerals: &[],
        digit_separators: &[],
        number_first: false,
        script: Script::Latin,
        times: Times::EMPTY,
    };
}

/// How a language puts units before tens in one word.
pub(crate) struct UnitsFirst {
    /// Between them: `und`.
    pub joint: &'static str,
    /// The number one before it: `ein`.
    pub one: &'static str,
}

/// The words of deadlines of a language.
pub(crate) struct Times {
    /// Before a time of day: `by`.
    pub by: &'static [&'static str],
    /// Behind a time of day: `までに`.
    pub by_after: &'static [&'static str],
    /// Before a length of time: `within`.
    pub within: &'static [&'static str],
    /// Behind a length of time: `以内`.
    pub within_after: &'static [&'static str],
    /// Before an hour that needs no other word: `a las`.
    pub at: &'static [&'static str],
    /// Behind the hour: `o'clock`, `h`.
    pub clock: &'static [&'static str],
    /// Half past, behind the hour: `半`.
    pub half: &'static [&'static str],
    /// Before a deadline for all doors of its sentence: `both`.
    pub all: &'static [&'static str],
    /// The hours before noon, beside the hour: `a.m.`, `上午`.
    pub am: &'static [&'static str],
    /// The hours after noon, beside the hour: `p.m.`.
    pub pm: &'static [&'static str],
    /// Twelve o'clock in the day: `noon`.
    pub noon: &'static [&'static str],
    /// The unit of a length in minutes.
    pub minutes: &'static [&'static str],
    /// The unit of a length in hours.
    pub hours: &'static [&'static str],
    /// A length of thirty minutes.
    pub half_hour: &'static [&'static str],
    /// A length of sixty minutes, unless that is a number and `hour`.
    pub one_hour: &'static [&'static str],
    /// The last word of an entry of `by` after which a number is an hour: `las` in `antes de las
    /// 10`.
    pub hour_articles: &'static [&'static str],
    /// Entries of `by` after which a number is an hour at the end of a sentence: `by 4`.
    pub by_bare_hour: &'static [&'static str],
    /// Days other than today.
    pub other_days: &'static [&'static str],
    /// Before the beginning of a span: `from`.
    pub from: &'static [&'static str],
    /// Whether hours are counted to twelve twice, and the half of the day is often omitted.
    pub has_half_days: bool,
}

impl Times {
    /// No word of deadlines.
    pub(super) const EMPTY: Self = Self {
        by: &[],
        by_after: &[],
        within: &[],
        within_after: &[],
        at: &[],
        clock: &[],
        half: &[],
        all: &[],
        am: &[],
        pm: &[],
        noon: &[],
        minutes: &[],
        hours: &[],
        half_hour: &[],
        one_hour: &[],
        hour_articles: &[],
        by_bare_hour: &[],
        other_days: &[],
        from: &[],
        has_half_days: false,
    };
}

/// How a language is recognized.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Script {
    /// By its words, against the other languages in Latin letters.
    Latin,
    /// By ideographs without kana.
    Han,
    /// By kana.
    Kana,
}
