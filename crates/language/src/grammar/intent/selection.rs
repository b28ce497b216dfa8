//! Mentions, and which of them are left out.

use crate::grammar::mentions::mention::Mention;

/// Why a mention is left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Why {
    /// The sender does not want it, or not any more.
    Denied,
    /// It is an origin or a landmark.
    Elsewhere,
}

/// Mentions in the order of the text, and which of them are left out.
pub(crate) struct Selection {
    pub mentions: Vec<Mention>,
    /// For each mention.
    pub left_out: Vec<Option<Why>>,
}

impl Selection {
    /// How many mentions there are.
    pub(super) fn count(&self) -> usize {
        self.mentions.len()
    }

    /// Whether a mention is not left out.
    pub(super) fn is_meant(&self, i: usize) -> bool {
        self.left_out[i].is_none()
    }

    /// Whether a mention is one of a building.
    pub(super) fn is_building(&self, i: usize) -> bool {
        self.mentions[i].is_building()
    }

    /// Whether any building is meant.
    pub(super) fn has_building(&self) -> bool {
        (0..self.count()).any(|i| self.is_building(i) && self.is_meant(i))
    }

    /// Adds a mention that is meant.
    pub(super) fn insert(&mut self, i: usize, mention: Mention) {
        self.mentions.insert(i, mention);
        self.left_out.insert(i, None);
    }

    /// The mentions that are meant.
    pub(super) fn into_meant(self) -> Vec<Mention> {
        let all = self.mentions.into_iter().zip(self.left_out);
        all.filter(|(_, why)| why.is_none())
            .map(|(mention, _)| mention)
            .collect()
    }
}
