//! Heights of ground covers. All lie within 2 cm above the ground, one on the other: a higher one
//! hides the lower ones, so that roads cut through pavements and junctions need no geometry.
//!
//! Steps of a millimetre or two are far above the resolution of single precision (0.03 mm at
//! 500 m), and too small for wheels and LiDAR to notice. Mapped ways lie above what is derived
//! from tags, since a mapper knew better; paint lies above all.

/// Lots without a mapped surface, metres.
pub(crate) const Z_LOT_M: f64 = 0.000_75;
/// Paved ground around buildings, metres.
pub(super) const Z_APRON_M: f64 = 0.0015;
/// Mapped areas, metres.
pub(super) const Z_AREA_M: f64 = 0.002;
/// Pavements that belong to a road, metres.
pub(crate) const Z_PAVEMENT_M: f64 = 0.004;
/// Paths, metres.
pub(crate) const Z_PATH_M: f64 = 0.006;
/// Pavements that are mapped as ways of their own, metres.
pub(crate) const Z_SIDEWALK_M: f64 = 0.007;
/// Kerb stones beside carriageways, metres.
pub(crate) const Z_KERB_M: f64 = 0.008;
/// Service roads and tracks, metres.
pub(crate) const Z_SERVICE_M: f64 = 0.010;
/// Streets, metres.
pub(crate) const Z_ROAD_M: f64 = 0.012;
/// Mended places, metres.
pub(crate) const Z_PATCH_M: f64 = 0.013;
/// Manholes and drains, metres.
pub(crate) const Z_LID_M: f64 = 0.014;
/// Painted lines, metres.
pub(crate) const Z_MARKING_M: f64 = 0.015;
