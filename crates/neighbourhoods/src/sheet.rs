//! A plan written as OpenStreetMap data.

use std::collections::BTreeMap;

use openbench_core::{Georeference, LonLat, MapPoint, Pose2};
use openbench_geometry::{Segment, segments};
use openbench_osm::{ElementKind, Member, Node, OsmData, Projection, Relation, Tags, Way};

use crate::plan::{BarrierKind, Class, Fence, Home, HomeKind, Path, Plan, Street};

/// Points nearer than this are one node, 1/m: a centimetre, as OSM keeps positions.
const NODES_PER_M: f64 = 100.0;

/// A plan as a map, at a pose of the `map` frame.
pub(crate) fn write(
    plan: &Plan,
    names: &[String],
    pose: Pose2,
    georeference: Georeference,
) -> OsmData {
    let mut sheet = Sheet {
        data: OsmData::default(),
        nodes: BTreeMap::new(),
        pose,
        projection: Projection::new(georeference),
    };
    // Where paths and driveways open barriers they need a common node with the street alone.
    let mut names = names.iter();
    let named: Vec<Option<&str>> = plan
        .streets
        .iter()
        .map(|street| match street.class {
            Class::Service => None,
            Class::Residential | Class::Living => names.next().map(String::as_str),
        })
        .collect();
    for (street, name) in plan.streets.iter().zip(&named) {
        sheet.street(street, *name);
    }
    for path in &plan.paths {
        sheet.path(path);
    }
    for home in &plan.homes {
        sheet.home(home, named.get(home.street).copied().flatten());
    }
    for building in &plan.outbuildings {
        let tags = Tags::from([("building", building.kind)]);
        sheet.area(&building.outer, tags);
    }
    for fence in &plan.fences {
        sheet.fence(fence);
    }
    for patch in &plan.patches {
        sheet.area(&patch.outer, Tags::from([(patch.key, patch.value)]));
    }
    for thing in &plan.things {
        let node = sheet.node(thing.at);
        sheet.tag(node, Tags::from([(thing.key, thing.value)]));
    }
    sheet.data
}

struct Sheet {
    data: OsmData,
    /// By position, centimetres.
    nodes: BTreeMap<[i64; 2], i64>,
    pose: Pose2,
    projection: Projection,
}

impl Sheet {
    /// The node at a point of the plan.
    fn node(&mut self, point: MapPoint) -> i64 {
        let key = [point.x, point.y].map(|v| libm::round(v * NODES_PER_M) as i64);
        if let Some(id) = self.nodes.get(&key) {
            return *id;
        }
        let id = self.nodes.len() as i64 + 1;
        let at = self
            .projection
            .to_lonlat(self.pose.transform(point.x, point.y));
        let node = Node {
            id,
            position: LonLat::new(rounded(at.lon), rounded(at.lat)),
            tags: Tags::new(),
        };
        self.data.nodes.insert(id, node);
        self.nodes.insert(key, id);
        id
    }

    fn tag(&mut self, node: i64, tags: Tags) {
        if let Some(node) = self.data.nodes.get_mut(&node) {
            for (key, value) in tags.iter() {
                node.tags.insert(key, value);
            }
        }
    }

    fn way(&mut self, line: &[MapPoint], tags: Tags) -> i64 {
        let mut nodes: Vec<i64> = line.iter().map(|p| self.node(*p)).collect();
        nodes.dedup();
        self.way_of(nodes, tags)
    }

    fn way_of(&mut self, nodes: Vec<i64>, tags: Tags) -> i64 {
        let id = self.data.ways.len() as i64 + 1;
        self.data.ways.insert(id, Way { id, nodes, tags });
        id
    }

    fn area(&mut self, ring: &[MapPoint], tags: Tags) -> i64 {
        self.way(&closed(ring), tags)
    }

    fn street(&mut self, street: &Street, name: Option<&str>) {
        let mut tags = Tags::new();
        let kind = match street.class {
            Class::Residential => "residential",
            Class::Living => "living_street",
            Class::Service => "service",
        };
        tags.insert("highway", kind);
        tags.insert("width", format!("{:.1}", street.width));
        if street.class == Class::Residential {
            tags.insert("sidewalk", "both");
        }
        if let Some(name) = name {
            tags.insert("name", name);
        }
        let line = with_joints(street);
        self.way(&line, tags);
    }

    fn path(&mut self, path: &Path) {
        let mut tags = Tags::new();
        if path.driveway {
            tags.insert("highway", "service");
            tags.insert("service", "driveway");
        } else {
            tags.insert("highway", "footway");
        }
        tags.insert("width", format!("{:.1}", path.width));
        self.way(&path.line, tags);
    }

    fn home(&mut self, home: &Home, street: Option<&str>) {
        let tags = tags_of(home, street);
        let outline = self.outline(home);
        match &home.court {
            None => {
                self.way_of(outline, tags);
            }
            Some(court) => {
                let outer = self.way_of(outline, Tags::new());
                let inner = self.area(court, Tags::new());
                let member = |id: i64, role: &str| Member {
                    kind: ElementKind::Way,
                    id,
                    role: role.to_owned(),
                };
                let id = self.data.relations.len() as i64 + 1;
                let mut tags = tags;
                tags.insert("type", "multipolygon");
                let members = vec![member(outer, "outer"), member(inner, "inner")];
                self.data
                    .relations
                    .insert(id, Relation { id, members, tags });
            }
        }
    }

    /// The nodes of a home's outline, doors among them, closed.
    fn outline(&mut self, home: &Home) -> Vec<i64> {
        let ring = closed(&home.outer);
        let mut nodes = Vec::new();
        for wall in segments(&ring) {
            nodes.push(self.node(wall.start));
            let mut doors: Vec<_> = home.doors.iter().filter(|d| d.wall == wall).collect();
            let along = |at: MapPoint| wall.start.distance(at);
            doors.sort_by(|a, b| along(a.at).total_cmp(&along(b.at)));
            for door in doors {
                let node = self.node(door.at);
                let kind = match home.kind {
                    _ if door.main && home.doors.len() > 1 => "main",
                    HomeKind::Slab | HomeKind::Tower | HomeKind::Perimeter => "staircase",
                    _ => "yes",
                };
                let unit = door.unit.as_str();
                self.tag(
                    node,
                    Tags::from([("entrance", kind), ("addr:unit", unit), ("ref", unit)]),
                );
                nodes.push(node);
            }
        }
        nodes.push(nodes[0]);
        nodes
    }

    fn fence(&mut self, fence: &Fence) {
        let kind = match fence.kind {
            BarrierKind::Hedge => "hedge",
            BarrierKind::Fence => "fence",
            BarrierKind::Wall => "wall",
        };
        self.way(&fence.line, Tags::from([("barrier", kind)]));
        if let Some(gate) = fence.gate {
            let node = self.node(gate);
            self.tag(node, Tags::from([("barrier", "gate")]));
        }
    }
}

fn rounded(degrees: f64) -> f64 {
    // As files keep them.
    libm::round(degrees * 1e7) / 1e7 + 0.0
}

fn closed(ring: &[MapPoint]) -> Vec<MapPoint> {
    ring.iter().chain(ring.first()).copied().collect()
}

/// The line of a street through the places where paths join it.
fn with_joints(street: &Street) -> Vec<MapPoint> {
    let mut line = Vec::new();
    let mut before = 0.0;
    for Segment { start, end } in segments(&street.line) {
        let length = start.distance(end);
        let mut here: Vec<_> = street
            .joints
            .iter()
            .filter(|joint| joint.along >= before && joint.along < before + length)
            .collect();
        here.sort_by(|a, b| a.along.total_cmp(&b.along));
        line.push(start);
        line.extend(here.iter().map(|joint| joint.point));
        before += length;
    }
    line.extend(street.line.last());
    line
}

fn tags_of(home: &Home, street: Option<&str>) -> Tags {
    let mut tags = Tags::new();
    let kind = match home.kind {
        HomeKind::Detached => "detached",
        HomeKind::Semi => "semidetached_house",
        HomeKind::Terraced => "house",
        HomeKind::Row => "terrace",
        HomeKind::Perimeter => "residential",
        HomeKind::Slab | HomeKind::Tower => "apartments",
        HomeKind::Farm => "farm",
    };
    tags.insert("building", kind);
    tags.insert("building:levels", home.levels.to_string());
    if let Some(roof) = home.roof {
        tags.insert("roof:shape", roof);
    }
    if let Some(name) = &home.name {
        tags.insert("name", name.as_str());
    }
    // The houses of an estate have its numbers alone.
    let of_estate = home.lot.is_none() && home.name.is_some();
    if let Some(street) = street.filter(|_| !of_estate) {
        tags.insert("addr:street", street);
        tags.insert("addr:housenumber", home.number.as_str());
    }
    tags
}
