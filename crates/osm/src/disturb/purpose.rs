//! What random numbers are drawn for.

/// Purposes of random numbers, apart from those of generated worlds, which draw by the same
/// elements. They are part of every disturbed map: new ones go to the end.
#[derive(Debug, Clone, Copy)]
#[repr(u64)]
pub(super) enum Purpose {
    Whole = 1001,
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
