//! Buildings whose parts are mapped (`building:part=*`), after OSM's [Simple 3D Buildings](https://wiki.openstreetmap.org/wiki/Simple_3D_Buildings).
//!
//! Where parts cover most of an outline, the outline itself is only built as high as the lowest of them: a base without gaps,
//! in which the doors are, and which the robot meets. The parts rise from it, each with its own height and roof; what hangs in the
//! air (`min_height`) begins there. Where parts cover less, say the tower of a church, they rise from the whole building.

use std::collections::BTreeMap;

use openbench_core::MapPoint;
use openbench_osm::{Area, Building, Polygon};
use rand_pcg::Pcg64Mcg;

use super::Site;
use super::buildings::{House, Roof, foot_of, roof_of, storeys};
use super::element_number;
use super::entrances::straightened;
use super::seeds::{Purpose, stream};
use super::shapes::{along, floor};

/// Share of an outline from which on its parts stand for it.
const COVERED: f64 = 0.5;
/// Lowest base, metres: a door must fit.
const LOWEST_BASE: f64 = 2.8;
/// Parts of one building at most.
const MAX_PARTS: usize = 500;

/// A part as it is built, with the outlines and tops of its neighbours.
pub(super) struct Part {
    house: House,
    siblings: std::rc::Rc<Vec<(Polygon, f64)>>,
}

impl Site {
    /// The mapped parts by building; parts in no building are counted.
    pub(super) fn parts_of_buildings(&mut self) -> BTreeMap<usize, Vec<Area>> {
        let mut found: BTreeMap<usize, Vec<Area>> = BTreeMap::new();
        let mut stray = 0;
        for area in self
            .map
            .areas
            .iter()
            .filter(|a| a.tags.says("building:part"))
        {
            let around = self
                .map
                .buildings_within(area.polygon.interior_point(), 0.0);
            let Some(index) = around.first() else {
                stray += 1;
                continue;
            };
            let list = found.entry(*index).or_default();
            if list.len() < MAX_PARTS {
                list.push(area.clone());
            } else {
                stray += 1;
            }
        }
        if stray > 0 {
            self.warnings.push(format!("{stray} parts of buildings lie in no building, or in one of more than {MAX_PARTS} parts, and were left out"));
        }
        found
    }

    /// What is built of the parts of a building; `house` is lowered where they stand for it.
    pub(super) fn parts(
        &self,
        house: &mut House,
        building: &Building,
        areas: &[Area],
    ) -> Vec<Part> {
        if areas.is_empty() {
            return Vec::new();
        }
        let mut houses: Vec<House> = areas
            .iter()
            .map(|area| self.design_part(house, area))
            .collect();
        let covered: f64 = areas.iter().map(|a| a.polygon.area()).sum();
        if covered >= COVERED * building.polygon.area() {
            let lowest = houses
                .iter()
                .map(|p| if p.foot < 1.0 { p.eaves } else { p.foot });
            let top = lowest.fold(house.eaves, f64::min).max(LOWEST_BASE);
            (house.eaves, house.levels, house.roof) =
                (top, ((top / 3.0) as usize).max(1), Roof::Terrace);
        }
        let base = house.eaves;
        for part in &mut houses {
            let foot = part.foot.max(base);
            part.levels = (((part.eaves - foot) / 3.0).round() as usize).clamp(1, 200);
            part.foot = foot;
        }
        let tops = areas
            .iter()
            .zip(&houses)
            .map(|(a, p)| (a.polygon.clone(), p.eaves))
            .collect();
        let siblings = std::rc::Rc::new(tops);
        let parts = houses.into_iter().map(|house| Part {
            house,
            siblings: std::rc::Rc::clone(&siblings),
        });
        parts.collect()
    }

    /// A part in the style of its building.
    fn design_part(&self, house: &House, area: &Area) -> House {
        let mut rng = stream(self.seed, Purpose::Building, element_number(area.element));
        let rings: Vec<Vec<MapPoint>> = area.polygon.rings().map(straightened).collect();
        let told = ["height", "building:levels"]
            .iter()
            .any(|key| area.tags.has(key));
        let own = if told {
            storeys(&area.tags, 0.0, false, &mut rng).1
        } else {
            house.eaves
        };
        let roof = if area.tags.has("roof:shape") {
            roof_of(&area.tags, &rings, house.levels, &mut rng)
        } else {
            Roof::Flat
        };
        let roofing = if roof == Roof::Flat {
            self.palette.flat_roof
        } else {
            house.roofing
        };
        let foot = foot_of(&area.tags).unwrap_or(0.0);
        House {
            rings,
            foot,
            eaves: own,
            roof,
            roofing,
            balconies: false,
            ..house.clone()
        }
    }

    pub(super) fn part(&mut self, part: Part, building: &Building, rng: &mut Pcg64Mcg) {
        let house = part.house;
        if house.eaves < house.foot + 0.3 {
            // No higher than the base: its top is the part's.
            return;
        }
        floor(
            &mut self.builder,
            house.facade,
            (&house.rings[0], &house.rings[1..]),
            house.foot + 0.01,
        );
        for ring in &house.rings {
            for i in 0..ring.len() {
                let wall = (ring[i], ring[(i + 1) % ring.len()]);
                let hidden = hidden_to(&part.siblings, wall);
                self.facade_above(&house, wall, (&building.polygon, hidden), rng);
            }
        }
        self.roof(&house, rng);
    }
}

/// Up to which height other parts stand before the middle of a wall, metres.
fn hidden_to(siblings: &[(Polygon, f64)], (a, b): (MapPoint, MapPoint)) -> f64 {
    let out = a.bearing_to(b) - std::f64::consts::FRAC_PI_2;
    let before = along(a, b, 0.5).offset(out, 0.3);
    siblings
        .iter()
        .filter(|(polygon, _)| polygon.contains(before))
        .map(|(_, top)| *top)
        .fold(0.0, f64::max)
}
