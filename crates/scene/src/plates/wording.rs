//! What plates say: house number, unit, or both, in the words of the place.
//!
//! A plate says what is true of its door and nothing else. Which of it, and in which words, is
//! drawn for each building.

use openbench_core::Address;
use openbench_osm::draws::{chance, pick};
use rand_pcg::Pcg64Mcg;

/// Longest house number, characters; anything longer is part of a name.
const LONGEST_NUMBER: usize = 9;
/// Longest street name on a plate, characters.
const LONGEST_STREET: usize = 16;

/// The language of plates and signs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Language {
    /// English.
    English,
    /// German.
    German,
    /// French.
    French,
    /// Italian.
    Italian,
    /// Spanish.
    Spanish,
    /// Portuguese.
    Portuguese,
    /// Chinese.
    Chinese,
}

impl Language {
    /// The language that most of some names of streets are in, if any has a word for "street".
    ///
    /// ```
    /// use openbench_scene::plates::Language;
    ///
    /// let streets = ["Ringstraße", "Rechte Kremszeile", "Schillergasse"];
    /// assert_eq!(Language::of_streets(streets), Some(Language::German));
    /// assert_eq!(Language::of_streets(["building3"]), None);
    /// ```
    pub fn of_streets<'a>(names: impl IntoIterator<Item = &'a str>) -> Option<Self> {
        const WORDS: [(Language, &[&str]); 7] = [
            (
                Language::English,
                &["street", "road", "lane", "close", "avenue", "drive"],
            ),
            (
                Language::German,
                &["straße", "strasse", "gasse", "weg", "platz", "allee"],
            ),
            (
                Language::French,
                &[
                    "rue ",
                    "boulevard ",
                    "avenue ",
                    "place ",
                    "quai ",
                    "chemin ",
                ],
            ),
            (
                Language::Italian,
                &["via ", "viale ", "piazza ", "corso ", "largo ", "vicolo "],
            ),
            (
                Language::Spanish,
                &["calle ", "avenida ", "paseo ", "plaza "],
            ),
            (
                Language::Portuguese,
                &["rua ", "avenida ", "travessa ", "praça ", "largo ", "beco "],
            ),
            (Language::Chinese, &["路", "街", "巷", "道"]),
        ];
        let mut counts = [0_usize; WORDS.len()];
        for name in names {
            let name = name.to_lowercase();
            for (count, (language, words)) in counts.iter_mut().zip(WORDS) {
                let is_last = matches!(language, Self::English | Self::German | Self::Chinese);
                let says = |word: &&str| {
                    if is_last {
                        name.ends_with(*word)
                    } else {
                        name.starts_with(*word)
                    }
                };
                *count += usize::from(words.iter().any(says));
            }
        }
        let most = counts.iter().copied().max().filter(|most| *most > 0)?;
        let first = counts.iter().position(|count| *count == most)?;
        Some(WORDS[first].0)
    }

    /// Family names, for name plates and bells.
    pub(crate) fn family_names(self) -> &'static [&'static str] {
        match self {
            Self::English => &[
                "Baker", "Clarke", "Hughes", "Patel", "Osborne", "Reed", "Walsh",
            ],
            Self::German => &[
                "Huber", "Gruber", "Novak", "Steiner", "Yilmaz", "Brandt", "Lang",
            ],
            Self::French => &["Moreau", "Girard", "Lefort", "Benali", "Roux", "Fontaine"],
            Self::Italian => &["Rossi", "Conti", "Ferrari", "Bianchi", "Greco", "Marino"],
            Self::Spanish => &["Garcia", "Ortega", "Molina", "Vega", "Serrano", "Prieto"],
            Self::Portuguese => &["Silva", "Ferreira", "Almeida", "Rocha", "Pinto", "Costa"],
            Self::Chinese => &["Wang", "Li", "Zhang", "Liu", "Chen", "Yang"],
        }
    }
}

/// What is true of a door.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Facts {
    /// Street of the building, if its name begins with one.
    pub street: Option<String>,
    /// House number, or number of the building.
    pub number: Option<String>,
    /// The unit, without a word for it.
    pub unit: Option<String>,
    /// Whether the building has no other door.
    pub is_only: bool,
}

impl Facts {
    /// What an address says.
    ///
    /// ```
    /// use openbench_core::Address;
    /// use openbench_scene::plates::Facts;
    ///
    /// let facts = Facts::of(&Address::new("Ringstraße 12a", "unit2"), false);
    /// assert_eq!(facts.street.as_deref(), Some("Ringstraße"));
    /// assert_eq!(facts.number.as_deref(), Some("12a"));
    /// assert_eq!(facts.unit.as_deref(), Some("2"));
    /// let facts = Facts::of(&Address::new("Rue Grimaldi 5 bis", "unit1"), true);
    /// assert_eq!(facts.number.as_deref(), Some("5 bis"));
    /// ```
    pub fn of(address: &Address, is_only: bool) -> Self {
        // After a comma comes the area.
        let name = address
            .building
            .split(',')
            .next()
            .unwrap_or_default()
            .trim();
        let (street, number) = street_and_number(name);
        let unit = address.unit.as_deref().map(|unit| {
            let plain = unit.strip_prefix("unit").unwrap_or(unit);
            plain.to_uppercase()
        });
        Self {
            street,
            number,
            unit,
            is_only,
        }
    }
}

/// The parts of a building's name: `Ringstraße 12`, `building3`, `3号楼`.
fn street_and_number(name: &str) -> (Option<String>, Option<String>) {
    let words: Vec<&str> = name.split_whitespace().collect();
    let suffix = words.last().filter(|word| is_suffix(word));
    let at = words
        .len()
        .saturating_sub(1 + usize::from(suffix.is_some()));
    let Some(number) = words.get(at).and_then(|word| number_in(word)) else {
        return (None, None);
    };
    // `14 - 18` and `12 1/2` are numbers of several words, of which the last alone would be wrong.
    let before = at.checked_sub(1).map(|before| words[before]);
    if before.is_some_and(|word| !word.contains(char::is_alphabetic)) {
        return (None, None);
    }
    let number = match suffix {
        Some(suffix) => format!("{number} {suffix}"),
        None => number,
    };
    let street = words[..at].join(" ");
    (
        Some(street).filter(|street| !street.is_empty()),
        Some(number),
    )
}

/// What belongs to the number before it: `bis`, `a`, `a-b`.
fn is_suffix(word: &str) -> bool {
    let is_letters = word.len() <= 3
        && word.starts_with(|c: char| c.is_ascii_alphabetic())
        && word.split('-').all(|part| part.len() == 1);
    is_letters || ["bis", "ter", "quater"].contains(&word.to_lowercase().as_str())
}

/// The number in a word such as `12a`, `14-18`, `B7`, `building3` or `3号楼`; `None` if a part of it
/// would be lost.
fn number_in(word: &str) -> Option<String> {
    let from = word.find(|c: char| c.is_ascii_digit())?;
    // One letter belongs to the number, a word does not.
    let is_letter = |before: &str| before.len() == 1 && before.is_ascii();
    let from = if is_letter(&word[..from]) { 0 } else { from };
    let number: String = word[from..]
        .chars()
        .take_while(|c| c.is_ascii_alphanumeric() || matches!(c, '-' | '/'))
        .collect();
    // Behind a number in Chinese come its words.
    let rest = &word[from + number.len()..];
    let is_whole = rest.chars().all(|c| ('\u{4e00}'..='\u{9fff}').contains(&c));
    let fits = (1..=LONGEST_NUMBER).contains(&number.chars().count());
    (is_whole && fits).then_some(number)
}

/// One line of a plate.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// What it says.
    pub text: String,
    /// Height of its letters, a share of the largest.
    pub size: f64,
}

fn line(text: impl Into<String>) -> Line {
    Line {
        text: text.into(),
        size: 1.0,
    }
}

fn small(text: impl Into<String>) -> Line {
    Line {
        text: text.into(),
        size: 0.55,
    }
}

/// Which of its facts a plate says.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Content {
    /// House number.
    Number,
    /// Unit.
    Unit,
    /// House number and unit.
    Both,
}

/// How the plates of a building are worded.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wording {
    language: Language,
    /// Wish for plates with the house number, the unit or both; what a building lacks is not said.
    content: Content,
    /// Form of words, by numbers that each content counts out for itself.
    form: u32,
    /// Capitals alone.
    capitals: bool,
    /// The street above the number.
    street: bool,
}

impl Wording {
    /// The wording of a building.
    pub fn draw(draws: &mut Pcg64Mcg, language: Language, is_only: bool) -> Self {
        use Content::{Both, Number, Unit};
        // With several doors a number alone would not tell one from the other.
        let content = if is_only {
            pick(
                draws,
                &[
                    Number, Number, Number, Number, Number, Number, Unit, Both, Both, Both,
                ],
            )
        } else {
            pick(draws, &[Unit, Unit, Unit, Both, Both])
        };
        Self {
            language,
            content,
            form: pick(draws, &[0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11]),
            capitals: chance(draws, 0.35),
            street: chance(draws, 0.25),
        }
    }

    /// What a plate says; `None` if there is nothing to say.
    pub fn lines(&self, facts: &Facts) -> Option<(Content, Vec<Line>)> {
        let number = facts.number.as_deref();
        let unit = facts.unit.as_deref();
        let told = match (self.content, number, unit) {
            (Content::Both, Some(number), Some(unit)) => (Content::Both, self.both(number, unit)),
            // Where one is missing, the other is said.
            (Content::Number, Some(number), _) | (_, Some(number), None) => (
                Content::Number,
                self.number(number, facts.street.as_deref()),
            ),
            // A bare number at an only door would be taken for that of the house.
            (_, _, Some(unit)) => (Content::Unit, vec![line(self.unit(unit, !facts.is_only))]),
            (_, None, None) => return None,
        };
        let (content, lines) = told;
        let cased = |line: Line| Line {
            text: if self.capitals {
                line.text.to_uppercase()
            } else {
                line.text
            },
            ..line
        };
        Some((content, lines.into_iter().map(cased).collect()))
    }

    /// The same without the street, for typefaces that lack its letters.
    #[must_use]
    pub fn without_street(self) -> Self {
        Self {
            street: false,
            ..self
        }
    }

    fn number(&self, number: &str, street: Option<&str>) -> Vec<Line> {
        let short = |street: &&str| street.chars().count() <= LONGEST_STREET;
        if let Some(street) = street.filter(short).filter(|_| self.street) {
            return vec![small(street), line(number)];
        }
        let text = match (self.language, self.form % 6) {
            (Language::Chinese, 0 | 1) => format!("{number}号"),
            (Language::Chinese, 2 | 3) => format!("{number}号楼"),
            (Language::English, 0) => format!("No. {number}"),
            (Language::German, 0) => format!("Nr. {number}"),
            (Language::French | Language::Italian, 0) => format!("N° {number}"),
            (Language::Spanish | Language::Portuguese, 0) => format!("N.º {number}"),
            _ => number.to_owned(),
        };
        vec![line(text)]
    }

    /// A unit in words that no house number has, or, if `may_be_bare`, in some forms without any.
    fn unit(&self, unit: &str, may_be_bare: bool) -> String {
        let words: &[&str] = match self.language {
            Language::English => &["Unit", "Apt", "Unit", "Flat", "Door", "Apt."],
            Language::German => &["Top", "Tür", "Whg.", "Top"],
            Language::French => &["Appt", "Porte", "Apt.", "Entrée"],
            Language::Italian => &["Int.", "Interno", "Scala"],
            Language::Spanish => &["Puerta", "Pta.", "Portal"],
            Language::Portuguese => &["Porta", "Apt.", "Entrada"],
            Language::Chinese => {
                return match self.form % 4 {
                    0 if may_be_bare => unit.to_owned(),
                    _ => format!("{unit}单元"),
                };
            }
        };
        // A third have the number alone.
        let form = self.form as usize;
        if form.is_multiple_of(3) && may_be_bare {
            return unit.to_owned();
        }
        format!("{} {unit}", words[form % words.len()])
    }

    fn both(&self, number: &str, unit: &str) -> Vec<Line> {
        if self.language == Language::Chinese {
            let text = match self.form % 4 {
                0 => format!("{number}-{unit}"),
                1 => format!("{number}幢{unit}单元"),
                _ => format!("{number}号楼{unit}单元"),
            };
            return vec![line(text)];
        }
        // A letter behind a number would be that of another house: `12-A` and `12a`.
        let is_letter = unit.chars().all(char::is_alphabetic);
        match self.form % 4 {
            0 if !is_letter => vec![line(format!("{number}-{unit}"))],
            1 if !is_letter => vec![line(format!("{number}/{unit}"))],
            _ => vec![
                line(number),
                Line {
                    size: 0.7,
                    ..line(self.unit(unit, !is_letter))
                },
            ],
        }
    }
}

#[cfg(test)]
mod tests {
    use openbench_osm::draws::stream;

    use super::*;

    fn said(language: Language, building: &str, unit: &str, is_only: bool) -> Vec<String> {
        let facts = Facts::of(&Address::new(building, unit), is_only);
        let mut texts: Vec<String> = (0..300)
            .filter_map(|seed| {
                let wording = Wording::draw(&mut stream(seed, 1, 1), language, is_only);
                let (_, lines) = wording.lines(&facts)?;
                let texts: Vec<String> = lines.into_iter().map(|line| line.text).collect();
                Some(texts.join(" "))
            })
            .collect();
        texts.sort();
        texts.dedup();
        texts
    }

    #[test]
    fn many_forms_are_said_and_all_are_true() {
        let texts = said(Language::English, "Mill Lane 7", "unit2", true);
        for expected in [
            "7",
            "No. 7",
            "7-2",
            "7/2",
            "MILL LANE 7",
            "Apt 2",
            "7 Unit 2",
        ] {
            assert!(texts.iter().any(|t| t == expected), "{expected}: {texts:?}");
        }
        let digits = |text: &String| {
            text.chars()
                .filter(char::is_ascii_digit)
                .collect::<String>()
        };
        assert!(
            texts
                .iter()
                .map(digits)
                .all(|d| ["7", "2", "72"].contains(&&*d))
        );
        let texts = said(Language::Chinese, "building3", "unit2", false);
        assert!(texts.iter().any(|t| t == "3号楼2单元"), "{texts:?}");
    }

    #[test]
    fn one_of_several_doors_is_never_told_by_the_number_alone() {
        for text in said(Language::German, "Gasse 12", "unit3", false) {
            assert!(text.contains('3'), "{text}");
        }
    }

    #[test]
    fn no_unit_reads_as_the_number_of_a_house() {
        // An only door says neither `2` nor `No. 2` for its unit.
        for language in [Language::English, Language::German, Language::Chinese] {
            let texts = said(language, "Rose Cottage", "unit2", true);
            let is_worded = |text: &String| text.chars().any(char::is_alphabetic);
            assert!(
                !texts.is_empty() && texts.iter().all(is_worded),
                "{texts:?}"
            );
            let is_number = |text: &&String| text.starts_with("No") || text.starts_with("Haus");
            assert_eq!(texts.iter().find(is_number), None);
        }
        let texts = said(Language::English, "Mill Lane 12", "unitA", false);
        assert!(
            !texts.iter().any(|t| t == "12-A" || t == "12/A"),
            "{texts:?}"
        );
    }

    #[test]
    fn numbers_of_the_map_stay_as_they_are() {
        for (name, number) in [
            ("Ringstraße 14-18", Some("14-18")),
            ("Elm Street 12A", Some("12A")),
            ("building21, Rose Estate", Some("21")),
            ("3号楼", Some("3")),
            ("Hoher Markt 12 a", Some("12 a")),
            ("Hoher Markt 36 a-b", Some("36 a-b")),
            ("Row B7", Some("B7")),
            // Part of it would be another number.
            ("Hoher Markt 14 - 18", None),
            ("Hoher Markt 12 1/2", None),
            ("Hoher Markt 12½", None),
            ("Лесная 12А", None),
            ("Town Hall", None),
            ("", None),
        ] {
            let facts = Facts::of(&Address::new(name, "unit1"), true);
            assert_eq!(facts.number.as_deref(), number, "{name}");
        }
    }
}
