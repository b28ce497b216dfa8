//! Registration of LiDAR scans to the public map: where the robot is, from the buildings around it.
//!
//! ```
//! use std::f64::consts::PI;
//!
//! use openbench_core::MapPoint;
//! use openbench_geometry::Bounds;
//! use openbench_localization::registration::field::Field;
//! use openbench_localization::registration::modes::modes;
//! use openbench_localization::registration::vote::{Evidence, Headings};
//! use openbench_localization::registration::{Chart, Facade, Submap};
//! use openbench_osm::{OsmData, OsmMap};
//!
//! // A house of 20 m by 10 m.
//! let xml = r#"<osm version="0.6">
//!   <node id="1" lat="0.0" lon="0.0"/><node id="2" lat="0.0" lon="0.00018"/>
//!   <node id="3" lat="0.00009" lon="0.00018"/><node id="4" lat="0.00009" lon="0.0"/>
//!   <way id="5"><nd ref="1"/><nd ref="2"/><nd ref="3"/><nd ref="4"/><nd ref="1"/>
//!     <tag k="building" v="house"/></way></osm>"#;
//! let map = OsmMap::new(&OsmData::from_xml(xml.as_bytes())?, "utm:31N,0,0".parse()?);
//! let corner = map.buildings[0].polygon.outer[0];
//! let chart = Chart::around(&map, corner, 100.0);
//!
//! // A robot sees a wall of 20 m ahead, and the wall of 10 m to the left of its left end.
//! let piece = |x, y, facing| Facade { at: MapPoint::new(x, y), facing, views: 1 };
//! let along = |i| 0.5 * f64::from(i);
//! let ahead = (0..40).map(|i| piece(6.0, along(i) - 9.75, PI));
//! let beside = (0..20).map(|i| piece(along(i) + 6.25, 10.0, PI / 2.0));
//! let seen = Submap { facades: ahead.chain(beside).collect(), panoramas: Vec::new() };
//!
//! let half = 40.0;
//! let area = Bounds { low: MapPoint::new(-half, -half), high: MapPoint::new(half, half) };
//! let field = Field::over(&chart, area);
//! let found = modes(&field, &Evidence::of(&seen), &Headings::ALL, &|_| 0.0, 5).modes;
//! // A rectangle looks the same from its opposite sides: two poses cost the least.
//! let gap = |i: usize| found[i].cost - found[0].cost;
//! assert!(gap(1) < 0.1 * gap(2), "{:?}", found);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! | module | job |
//! |---|---|
//! | [`chart`] | the map: walls that can be seen, outlines |
//! | `columns` | returns over each half metre of ground; which of them are facades |
//! | [`stretch`] | facades and free ground seen on a few metres of the way |
//! | [`submap`] | several stretches as one |
//! | [`field`] | what each place of the map costs a piece of evidence |
//! | [`mod@vote`] | the cost of every pose in an area |
//! | [`mod@modes`] | the best of these poses |
//! | `landscape` | a picture of the vote |
//! | [`prior`] | where the robot can be by its start and its way |
//! | [`nearness`] | facades on walls, beside them, and far from all |
//! | [`mod@explain`] | how well a pose explains the free ground that was seen |
//! | [`mod@candidates`] | the likely poses, refined and compared with what was seen |
//! | [`probability`] | how probable each of them is |
//! | [`hypothesis`] | such a pose along the way, and when it is accepted |
//! | [`locator`] | which of them is accepted, over the whole way |
//! | [`estimate`] | the pose by all that was seen, and offsets of buildings |
//! | `equations` | both as linear equations |
//! | `spread` | how large these offsets are |
//! | [`registrar`] | fixes from all that |
//! | [`matching`] | pieces of facades on walls, as equations |
//! | [`mod@refine`] | a pose made exact, with an offset of each building |

pub mod candidates;
pub mod chart;
mod columns;
mod equations;
pub mod estimate;
pub mod explain;
pub mod field;
pub mod hypothesis;
mod landscape;
pub mod locator;
pub mod matching;
pub mod modes;
pub mod nearness;
pub mod prior;
pub mod probability;
pub mod refine;
pub mod registrar;
mod spread;
pub mod stretch;
pub mod submap;
#[cfg(test)]
mod town;
pub mod vote;

pub use chart::Chart;
pub use columns::Facade;
pub use estimate::BuildingOffset;
pub use registrar::Registrar;
pub use stretch::{Gatherer, Stretch};
pub use submap::Submap;
