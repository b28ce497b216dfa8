//! Parts by name: the one place in which an exchangeable part of a robot is registered.

/// Parts of one kind by name, in the order in which they were registered.
///
/// ```
/// use openbench_core::Registry;
///
/// let greetings = Registry::new("greeting")
///     .with("hello", "for friends", "Hello!")
///     .with("good-day", "for strangers", "Good day.");
/// assert_eq!(greetings.get("hello"), Ok(&"Hello!"));
/// let error = greetings.get("howdy").unwrap_err();
/// assert_eq!(error.to_string(), "there is no greeting `howdy`; there are hello, good-day");
/// ```
#[derive(Debug, Clone)]
pub struct Registry<P> {
    kind: &'static str,
    parts: Vec<Entry<P>>,
}

/// A registered part.
#[derive(Debug, Clone)]
pub struct Entry<P> {
    /// Its name, as settings and results have it.
    pub name: String,
    /// What it is, in one line.
    pub about: String,
    /// The part, or what makes it.
    pub part: P,
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

impl std::fmt::Display for UnknownName {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let known = self.known.join(", ");
        write!(
            f,
            "there is no {} `{}`; there are {known}",
            self.kind, self.name
        )
    }
}

impl std::error::Error for UnknownName {}

impl<P> Registry<P> {
    /// An empty registry of parts of that kind, named in errors: `local planner`.
    pub fn new(kind: &'static str) -> Self {
        Self {
            kind,
            parts: Vec::new(),
        }
    }

    /// The same with one more part. A part of the same name is replaced.
    #[must_use]
    pub fn with(mut self, name: &str, about: &str, part: P) -> Self {
        self.parts.retain(|entry| entry.name != name);
        self.parts.push(Entry {
            name: name.to_owned(),
            about: about.to_owned(),
            part,
        });
        self
    }

    /// The part of that name.
    ///
    /// # Errors
    /// [`UnknownName`] with the names that there are.
    pub fn get(&self, name: &str) -> Result<&P, UnknownName> {
        let found = self.parts.iter().find(|entry| entry.name == name);
        found.map(|entry| &entry.part).ok_or_else(|| UnknownName {
            kind: self.kind,
            name: name.to_owned(),
            known: self.names().map(str::to_owned).collect(),
        })
    }

    /// All names, in the order in which they were registered.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.parts.iter().map(|entry| entry.name.as_str())
    }

    /// All entries, in the order in which they were registered.
    pub fn entries(&self) -> impl Iterator<Item = &Entry<P>> {
        self.parts.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_of_the_same_name_is_replaced() {
        let parts = Registry::new("part")
            .with("a", "", 1)
            .with("b", "", 2)
            .with("a", "new", 3);
        assert_eq!(parts.get("a"), Ok(&3));
        assert_eq!(parts.names().collect::<Vec<_>>(), ["b", "a"]);
        let abouts: Vec<&str> = parts.entries().map(|entry| entry.about.as_str()).collect();
        assert_eq!(abouts, ["", "new"]);
    }
}
