//! Limits and settings that make no sense, and the checks that find them.

/// A limit or setting that makes no sense.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{name} is {value}; {wanted}")]
pub struct SettingsError {
    /// Which.
    pub name: &'static str,
    /// What it is.
    pub value: f64,
    /// What it has to be.
    pub wanted: &'static str,
}

pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), SettingsError> {
    let wanted = "it must be more than nothing, and a number";
    if value > 0.0 && value.is_finite() { Ok(()) } else { Err(SettingsError { name, value, wanted }) }
}

pub(crate) fn finite(name: &'static str, value: f64) -> Result<(), SettingsError> {
    let wanted = "it must be a number";
    if value.is_finite() { Ok(()) } else { Err(SettingsError { name, value, wanted }) }
}

pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<(), SettingsError> {
    let wanted = "it must be nothing or more, and a number";
    if value >= 0.0 && value.is_finite() { Ok(()) } else { Err(SettingsError { name, value, wanted }) }
}

/// Whether a value is a number of at least `least`.
pub(crate) fn at_least(
    name: &'static str,
    value: f64,
    least: f64,
    wanted: &'static str,
) -> Result<(), SettingsError> {
    if value >= least && value.is_finite() { Ok(()) } else { Err(SettingsError { name, value, wanted }) }
}
