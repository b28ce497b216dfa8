//! Checks of limits and settings.

/// A limit or setting is out of its range.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[error("{name} is {value}; {wanted}")]
pub struct SettingsError {
    /// Its name.
    pub name: &'static str,
    /// Its value.
    pub value: f64,
    /// What it has to be, for the user.
    pub wanted: &'static str,
}

/// Whether a value is positive and finite.
pub(crate) fn positive(name: &'static str, value: f64) -> Result<(), SettingsError> {
    let wanted = "it must be positive and finite";
    if value > 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(SettingsError {
            name,
            value,
            wanted,
        })
    }
}

/// Whether a value is finite.
pub(crate) fn finite(name: &'static str, value: f64) -> Result<(), SettingsError> {
    let wanted = "it must be finite";
    if value.is_finite() {
        Ok(())
    } else {
        Err(SettingsError {
            name,
            value,
            wanted,
        })
    }
}

/// Whether a value is zero or positive, and finite.
pub(crate) fn not_negative(name: &'static str, value: f64) -> Result<(), SettingsError> {
    let wanted = "it must be zero or positive, and finite";
    if value >= 0.0 && value.is_finite() {
        Ok(())
    } else {
        Err(SettingsError {
            name,
            value,
            wanted,
        })
    }
}

/// Whether a value is finite and at least `least`.
pub(crate) fn at_least(
    name: &'static str,
    value: f64,
    least: f64,
    wanted: &'static str,
) -> Result<(), SettingsError> {
    if value >= least && value.is_finite() {
        Ok(())
    } else {
        Err(SettingsError {
            name,
            value,
            wanted,
        })
    }
}
