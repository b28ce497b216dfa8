//! A key that does not show itself.

use std::fmt;

/// An endpoint's key. It can be put into a request header and blotted out of a text; nothing prints it.
#[derive(Clone)]
pub(crate) struct Secret(String);

impl Secret {
    /// `None` if the text holds what an HTTP header cannot carry.
    pub(crate) fn new(text: &str) -> Option<Self> {
        text.chars().all(|c| c.is_ascii_graphic()).then(|| Self(text.to_owned()))
    }

    /// The key itself, for a request's header.
    pub(crate) fn expose(&self) -> &str {
        &self.0
    }

    /// `text` without the key: servers like to quote it in their complaints.
    pub(crate) fn blot_out(&self, text: &str) -> String {
        text.replace(&self.0, "[key]")
    }
}

impl fmt::Debug for Secret {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("[key]")
    }
}
