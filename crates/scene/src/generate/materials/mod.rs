//! The materials of a world, and their procedural textures.
//!
//! | file | contents |
//! |---|---|
//! | `palette` | all materials of a world |
//! | `images` | textures of walls, roofs and grounds |
//! | `openings` | images of windows, doors and fence panels |

pub(super) mod images;
pub(super) mod openings;
pub(super) mod palette;
