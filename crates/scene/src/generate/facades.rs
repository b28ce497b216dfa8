//! Walls of buildings: plinth, bands between storeys, corner stones, downpipes. What is in them is for
//! [`windows`](super::windows) to say.

use openbench_core::{MapPoint, Pose2};
use openbench_osm::Polygon;
use rand_pcg::Pcg64Mcg;

use super::Site;
use super::buildings::{House, Roof};
use super::clearance::BUILDING;
use super::entrances::Doorway;
use super::shapes::{along, panel, wall};
use crate::scene::Layer;

/// Height of the plinth, metres.
const PLINTH: f64 = 0.5;
/// How far plinths and window frames stand out of the wall, metres.
pub(super) const RELIEF: f64 = 0.03;
/// Height of a parapet, metres.
pub(super) const PARAPET: f64 = 0.5;
/// Width of corner stones, and of a downpipe, metres.
const QUOIN: f64 = 0.38;
const PIPE: f64 = 0.09;
/// A wall that is shorter has neither windows nor ornaments, metres.
const SHORTEST: f64 = 1.6;

impl Site {
    /// The wall from `a` to `b`, the building on its left.
    pub(super) fn facade(
        &mut self,
        house: &House,
        (a, b): (MapPoint, MapPoint),
        doors: &[Doorway],
        rng: &mut Pcg64Mcg,
    ) {
        self.bare_wall(house, (a, b));
        let out = a.bearing_to(b) - std::f64::consts::FRAC_PI_2;
        let plinth = (0.0, PLINTH.min(house.eaves / 4.0));
        wall(
            &mut self.builder,
            Layer::Visible,
            house.plinth,
            raised((a, b), RELIEF),
            plinth,
        );
        let length = a.distance(b);
        if house.plain || self.is_full() || length < SHORTEST || self.is_party_wall(a, b, out) {
            return;
        }
        let spans: Vec<(f64, f64)> = doors.iter().filter_map(|d| d.span_on((a, b))).collect();
        self.ornaments(house, (a, b), &spans);
        self.windows(house, (a, b), (&spans, 0.0), rng);
    }

    /// A wall of a part that stands on another part, `hidden` by others up to so many metres.
    pub(super) fn facade_above(
        &mut self,
        house: &House,
        (a, b): (MapPoint, MapPoint),
        (outline, hidden): (&Polygon, f64),
        rng: &mut Pcg64Mcg,
    ) {
        self.bare_wall(house, (a, b));
        let out = a.bearing_to(b) - std::f64::consts::FRAC_PI_2;
        let is_inside = outline.contains(along(a, b, 0.5).offset(out, 0.4));
        let low = house.eaves - house.foot < 2.2;
        if house.plain || self.is_full() || low || a.distance(b) < SHORTEST {
            return;
        }
        if is_inside || !self.is_party_wall(a, b, out) {
            self.windows(house, (a, b), (&[], hidden), rng);
        }
    }

    fn bare_wall(&mut self, house: &House, line: (MapPoint, MapPoint)) {
        let top = house.eaves
            + if house.roof == Roof::Flat {
                PARAPET
            } else {
                0.0
            };
        // A robot meets what stands on the ground only.
        let layer = if house.foot == 0.0 {
            Layer::Both
        } else {
            Layer::Visible
        };
        wall(
            &mut self.builder,
            layer,
            house.facade,
            line,
            (house.foot, top),
        );
    }

    fn ornaments(&mut self, house: &House, (a, b): (MapPoint, MapPoint), doors: &[(f64, f64)]) {
        let storey = house.eaves / house.levels as f64;
        let bands = if house.levels > 1 {
            house.bands.min(house.levels - 1)
        } else {
            0
        };
        for level in 1..=bands {
            let z = storey * level as f64;
            wall(
                &mut self.builder,
                Layer::Visible,
                house.trim,
                raised((a, b), RELIEF),
                (z - 0.1, z + 0.08),
            );
        }
        if house.roof == Roof::Flat && house.bands > 0 {
            let z = (house.eaves - 0.1, house.eaves + 0.14);
            wall(
                &mut self.builder,
                Layer::Visible,
                house.trim,
                raised((a, b), 2.0 * RELIEF),
                z,
            );
        }
        let length = a.distance(b);
        let is_free = |from: f64, to: f64| doors.iter().all(|d| to < d.0 || from > d.1);
        if house.quoins && length > 3.0 {
            for (from, to) in [(0.0, QUOIN), (length - QUOIN, length)] {
                if is_free(from, to) {
                    let line = raised(
                        (along(a, b, from / length), along(a, b, to / length)),
                        RELIEF,
                    );
                    wall(
                        &mut self.builder,
                        Layer::Visible,
                        self.palette.quoins,
                        line,
                        (PLINTH, house.eaves),
                    );
                }
            }
        }
        let pipe = (QUOIN + 0.1, QUOIN + 0.1 + PIPE);
        if house.detailed && length > 4.0 && is_free(pipe.0, pipe.1) {
            let out = a.bearing_to(b) - std::f64::consts::FRAC_PI_2;
            let foot = |run: f64| along(a, b, run / length).offset(out, 2.0 * RELIEF);
            let line = (foot(pipe.0), foot(pipe.1));
            panel(
                &mut self.builder,
                Layer::Visible,
                self.palette.downpipe.material,
                line,
                (0.1, house.eaves),
            );
        }
    }

    fn is_party_wall(&self, a: MapPoint, b: MapPoint, out: f64) -> bool {
        let middle = along(a, b, 0.5);
        !self.clearance.is_free(
            middle.offset(out, 0.4),
            middle.offset(out, 0.8),
            0.2,
            BUILDING,
        )
    }
}

/// The line moved out of the wall by `relief` metres, and longer by as much, so that it closes round the corners.
fn raised((a, b): (MapPoint, MapPoint), relief: f64) -> (MapPoint, MapPoint) {
    let over = relief / a.distance(b).max(relief);
    let out = a.bearing_to(b) - std::f64::consts::FRAC_PI_2;
    (
        along(a, b, -over).offset(out, relief),
        along(a, b, 1.0 + over).offset(out, relief),
    )
}

/// At a share of the wall from `a` to `b`, facing away from the building on its left.
pub(super) fn facing_out(a: MapPoint, b: MapPoint, share: f64) -> Pose2 {
    let p = along(a, b, share);
    Pose2::new(p.x, p.y, a.bearing_to(b) - std::f64::consts::FRAC_PI_2)
}
