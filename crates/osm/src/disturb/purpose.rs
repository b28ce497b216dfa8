//! What random numbers are drawn for.

/// Purposes of random numbers. They are part of every disturbed map: new ones go to the end.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
pub(super) enum Purpose {
    Whole = 1,
    BuildingShift,
    Missing,
    Number,
    Name,
    Simplified,
    Swelling,
    Roads,
    MissingRoads,
    Invented,
    InventedNumber,
}
