//! The contents of the built-in suites.

use super::tracks::TRACKS;

/// The contents of a built-in suite.
pub struct BuiltIn {
    /// Name of the suite and of its world.
    pub name: &'static str,
    /// Number of single deliveries.
    pub singles: usize,
    /// Number of sequences.
    pub sequences: usize,
    /// Number of doors in each sequence.
    pub length: usize,
}

/// All built-in suites.
pub const BUILT_IN: [BuiltIn; 8] = [
    BuiltIn {
        name: "small",
        singles: 8,
        sequences: 1,
        length: 3,
    },
    BuiltIn {
        name: "medium",
        singles: 10,
        sequences: 2,
        length: 5,
    },
    BuiltIn {
        name: "large",
        singles: 10,
        sequences: 2,
        length: 5,
    },
    place("krems"),
    place("heidelberg"),
    place("campus"),
    place("bayreuth"),
    place("monaco"),
];

/// The suite of a real place.
const fn place(name: &'static str) -> BuiltIn {
    BuiltIn {
        name,
        singles: 10,
        sequences: 2,
        length: 5,
    }
}

/// The names that need no file: of the built-in suites, and of the tracks.
pub fn known_suites() -> Vec<String> {
    let tracks = TRACKS.iter().map(|track| track.name.to_owned());
    builtin_suites().into_iter().chain(tracks).collect()
}

/// The names of the built-in suites.
pub fn builtin_suites() -> Vec<String> {
    BUILT_IN.iter().map(|suite| suite.name.to_owned()).collect()
}
