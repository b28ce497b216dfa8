//! Rules of the grammar as rows of tables: name, examples, function.

/// An instruction, and its plan where the map has `building1` to `building12` with `unit1` to
/// `unit4` each in a row, the nearest first: `building3/unit1 building5`, in driving order.
#[cfg_attr(not(test), allow(dead_code, reason = "tests plan the examples"))]
pub(crate) struct Example(pub &'static str, pub &'static str);

/// A rule of one stage.
#[derive(Clone, Copy)]
#[cfg_attr(
    not(test),
    allow(dead_code, reason = "tests run the examples of each rule by its name")
)]
pub(crate) struct Rule<Apply> {
    /// What it says, unique among all rules.
    pub name: &'static str,
    /// Instructions that it decides.
    pub examples: &'static [Example],
    pub apply: Apply,
}
