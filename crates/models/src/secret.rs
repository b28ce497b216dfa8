//! Keys that are never printed.

use std::fmt;

/// The key for an endpoint. It can be put into a request header and removed from a text; its
/// `Debug` output does not contain it.
#[derive(Clone)]
pub(crate) struct Secret(String);

impl Secret {
    /// `None` if the text contains characters that an HTTP header cannot contain.
    pub(crate) fn new(text: &str) -> Option<Self> {
        text.chars()
            .all(|c| c.is_ascii_graphic())
            .then(|| Self(text.to_owned()))
    }

    /// The key itself, for the header of a request.
    pub(crate) fn expose(&self) -> &str {
        &self.0
    }

    /// Replaces the key in a text, since servers quote it in error messages.
    pub(crate) fn redact(&self, text: &str) -> String {
        text.replace(&self.0, "[key]")
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("[key]")
    }
}
