//! Parts by name: the one place in which an exchangeable part of a robot is registered.

use std::fmt;

/// Parts of one kind by name, in the order in which they were registered.
///
/// A part that takes an argument is registered with the form of it after a colon, such as
/// `replay:FILE`. It is then found by `replay:answers.jsonl`, and by `replay` with an empty
/// argument.
///
/// ```
/// use openbench_core::Registry;
///
/// let greetings = Registry::new("greeting")
///     .with("hello", "for friends", "Hello!")
///     .with("dear:NAME", "for letters", "Dear");
/// assert_eq!(greetings.get("hello"), Ok(&"Hello!"));
///
/// let found = greetings.find("dear:Ada")?;
/// assert_eq!((found.entry.part, found.argument), ("Dear", "Ada"));
///
/// let error = greetings.get("howdy").unwrap_err();
/// assert_eq!(error.to_string(), "there is no greeting `howdy`; known: hello, dear:NAME");
/// # Ok::<(), openbench_core::UnknownName>(())
/// ```
#[derive(Clone)]
pub struct Registry<P> {
    kind: &'static str,
    entries: Vec<Entry<P>>,
}

/// A registered part.
#[derive(Clone)]
pub struct Entry<P> {
    /// Its name, as settings and results have it, with the form of its argument: `replay:FILE`.
    pub name: String,
    /// What it is, in one line.
    pub about: String,
    /// The part, or what makes it.
    pub part: P,
    /// Whether it took the place of another part of this name.
    pub replaces: bool,
}

/// A part that was found by what a user wrote.
#[derive(Debug)]
pub struct Found<'r, 't, P> {
    /// The registered part.
    pub entry: &'r Entry<P>,
    /// What was written after the colon; empty without one.
    pub argument: &'t str,
}

/// A name that is not registered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct UnknownName {
    /// What kind of part was asked for.
    pub kind: &'static str,
    /// The name.
    pub name: String,
    /// The names that there are.
    pub known: Vec<String>,
}

impl fmt::Display for UnknownName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let known = self.known.join(", ");
        write!(
            f,
            "there is no {} `{}`; known: {known}",
            self.kind, self.name
        )
    }
}

impl std::error::Error for UnknownName {}

impl<P> Entry<P> {
    /// A part with a name, which may include the form of an argument, and a one-line description.
    pub fn new(name: impl Into<String>, about: impl Into<String>, part: P) -> Self {
        Self {
            name: name.into(),
            about: about.into(),
            part,
            replaces: false,
        }
    }

    /// Its name without the form of its argument.
    pub fn word(&self) -> &str {
        word_of(&self.name)
    }

    /// Whether it takes an argument.
    pub fn takes_argument(&self) -> bool {
        self.name.contains(':')
    }
}

impl<P> fmt::Debug for Entry<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { name, about, .. } = self;
        f.debug_struct("Entry")
            .field("name", name)
            .field("about", about)
            .finish_non_exhaustive()
    }
}

impl<P> fmt::Debug for Registry<P> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Registry")
            .field("kind", &self.kind)
            .field("entries", &self.entries)
            .finish()
    }
}

impl<P> Registry<P> {
    /// An empty registry of parts of that kind, named in errors: `local planner`.
    pub fn new(kind: &'static str) -> Self {
        Self {
            kind,
            entries: Vec::new(),
        }
    }

    /// What kind of part it contains.
    pub fn kind(&self) -> &'static str {
        self.kind
    }

    /// The same with one more part, after the others. A part of the same name is replaced and
    /// keeps its place.
    #[must_use]
    pub fn with(self, name: &str, about: &str, part: P) -> Self {
        self.with_entry(Entry::new(name, about, part))
    }

    /// As [`Registry::with`].
    #[must_use]
    pub fn with_entry(mut self, entry: Entry<P>) -> Self {
        let known = self
            .entries
            .iter_mut()
            // By word, since `replay:FILE` and `replay` are found by the same text.
            .find(|known| known.word() == entry.word());
        match known {
            Some(known) => {
                *known = Entry {
                    replaces: true,
                    ..entry
                };
            }
            None => self.entries.push(entry),
        }
        self
    }

    /// The same with several more parts, as by [`Registry::with`].
    #[must_use]
    pub fn with_entries(self, entries: impl IntoIterator<Item = Entry<P>>) -> Self {
        entries.into_iter().fold(self, Self::with_entry)
    }

    /// The same parts, of which none counts as taken from another one's place.
    #[must_use]
    pub fn as_original(mut self) -> Self {
        self.entries
            .iter_mut()
            .for_each(|entry| entry.replaces = false);
        self
    }

    /// The words of the parts that took the places of others.
    pub fn replaced(&self) -> impl Iterator<Item = &str> {
        let replaced = self.entries.iter().filter(|entry| entry.replaces);
        replaced.map(Entry::word)
    }

    /// The part that `NAME` or `NAME:ARGUMENT` names.
    ///
    /// # Errors
    /// [`UnknownName`] with the names that there are. A part that takes no argument is unknown
    /// with one.
    pub fn find<'t>(&self, text: &'t str) -> Result<Found<'_, 't, P>, UnknownName> {
        let argument = text.split_once(':').map(|(_, argument)| argument);
        let found = self
            .entry_of(word_of(text))
            .filter(|entry| argument.is_none() || entry.takes_argument());
        let entry = found.ok_or_else(|| UnknownName {
            kind: self.kind,
            name: text.to_owned(),
            known: self.names().map(str::to_owned).collect(),
        })?;
        Ok(Found {
            entry,
            argument: argument.unwrap_or_default(),
        })
    }

    /// The part of that name, for kinds whose parts take no arguments.
    ///
    /// # Errors
    /// As [`Registry::find`].
    pub fn get(&self, name: &str) -> Result<&P, UnknownName> {
        self.find(name).map(|found| &found.entry.part)
    }

    /// Splits a list of names at its commas.
    ///
    /// A comma is a separator only if a registered name follows it, since arguments, such as names
    /// of models and of files, may contain commas.
    pub fn split<'t>(&self, list: &'t str) -> Vec<&'t str> {
        let mut names = Vec::new();
        let mut start = 0;
        for (at, _) in list.match_indices(',') {
            // Otherwise the comma belongs to the argument before it.
            if self.begins(&list[at + 1..]) {
                names.push(list[start..at].trim());
                start = at + 1;
            }
        }
        names.push(list[start..].trim());
        names
    }

    /// All names with the forms of their arguments, in the order in which they were registered.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.entries.iter().map(|entry| entry.name.as_str())
    }

    /// All entries, in the order in which they were registered.
    pub fn entries(&self) -> impl Iterator<Item = &Entry<P>> {
        self.entries.iter()
    }

    /// Whether a list of names begins with a registered one.
    fn begins(&self, list: &str) -> bool {
        let first = list.split(',').next().unwrap_or_default();
        self.entry_of(word_of(first.trim())).is_some()
    }

    fn entry_of(&self, word: &str) -> Option<&Entry<P>> {
        self.entries.iter().find(|entry| entry.word() == word)
    }
}

impl<P: Clone> Registry<P> {
    /// The parts of some names, in the order of this registry; all of them if no name is given.
    ///
    /// # Errors
    /// [`UnknownName`] of the first name that is not registered.
    pub fn select(&self, names: &[impl AsRef<str>]) -> Result<Self, UnknownName> {
        let mut wanted = Vec::new();
        for name in names {
            wanted.push(self.find(name.as_ref())?.entry.word());
        }
        let is_wanted = |entry: &&Entry<P>| wanted.is_empty() || wanted.contains(&entry.word());
        Ok(Self {
            kind: self.kind,
            entries: self.entries.iter().filter(is_wanted).cloned().collect(),
        })
    }
}

/// What stands before the colon of `NAME:ARGUMENT`; all of it without a colon.
fn word_of(text: &str) -> &str {
    text.split_once(':').map_or(text, |(word, _)| word)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn letters() -> Registry<i32> {
        Registry::new("letter")
            .with("a", "the first", 1)
            .with("b:FILE", "with an argument", 2)
            .with("c", "", 3)
    }

    fn names(letters: &Registry<i32>) -> Vec<&str> {
        letters.names().collect()
    }

    #[test]
    fn a_part_is_added_after_the_others_and_replaced_in_its_place() {
        let letters = letters().with("d", "", 4).with("a", "new", 5);
        assert_eq!(letters.get("a"), Ok(&5));
        assert_eq!(names(&letters), ["a", "b:FILE", "c", "d"]);
        let abouts: Vec<&str> = letters
            .entries()
            .map(|entry| entry.about.as_str())
            .collect();
        assert_eq!(abouts, ["new", "with an argument", "", ""]);
        assert!(letters.replaced().eq(["a"]));
        assert_eq!(letters.as_original().replaced().count(), 0);
    }

    #[test]
    fn a_part_is_replaced_by_one_with_another_argument() {
        let letters = letters().with("b:ADDRESS", "", 6);
        assert_eq!(names(&letters), ["a", "b:ADDRESS", "c"]);
    }

    #[test]
    fn what_follows_the_first_colon_is_the_argument() {
        let letters = letters();
        let argument = |text: &'static str| letters.find(text).map(|found| found.argument);
        assert_eq!(argument("b:x:y,z"), Ok("x:y,z"));
        assert_eq!(argument("b"), Ok(""));
        assert_eq!(argument("a"), Ok(""));
    }

    #[test]
    fn an_argument_that_a_part_does_not_take_is_refused() {
        let error = letters().find("a:x").unwrap_err().to_string();
        assert_eq!(error, "there is no letter `a:x`; known: a, b:FILE, c");
    }

    #[test]
    fn commas_inside_arguments_are_not_separators() {
        let letters = letters();
        assert_eq!(letters.split("a, b:x,y ,c"), ["a", "b:x,y", "c"]);
        assert_eq!(letters.split("b:x, y,b:z"), ["b:x, y", "b:z"]);
        assert_eq!(letters.split("a,cd"), ["a,cd"]);
        assert_eq!(letters.split(""), [""]);
    }

    #[test]
    fn parts_are_selected_in_the_order_of_the_registry() {
        let letters = letters();
        let selected = |wanted: &[&str]| {
            let some = letters.select(wanted)?;
            Ok::<_, UnknownName>(some.names().map(str::to_owned).collect::<Vec<_>>())
        };
        assert_eq!(selected(&["c", "a", "c"]).unwrap(), ["a", "c"]);
        assert_eq!(selected(&[]).unwrap(), ["a", "b:FILE", "c"]);
        assert_eq!(selected(&["a", "x"]).unwrap_err().name, "x");
    }
}
