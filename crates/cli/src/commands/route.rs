//! `openbench route`

use std::path::Path;

use openbench_osm::stream::Source;
use openbench_routing::geo::Place;
use openbench_routing::network::Network;
use openbench_routing::osrm::{
    Geometries, Limits, Overview, Request, RouteRequest, Service, ServiceMemory,
};
use openbench_routing::partition::CellSizes;
use openbench_routing::{Metric, Profile, Roads, store};

use crate::args::{RoadArgs, RouteArgs};
use crate::outcome::{Outcome, say};
use crate::progress::doing;

/// Prints a route.
pub fn run(args: &RouteArgs) -> anyhow::Result<Outcome> {
    let service = service(&args.roads, Limits::default())?;
    let places = args
        .places
        .iter()
        // All are kept: the arguments accept positions on the Earth only.
        .filter_map(|position| Place::new(*position))
        .collect();
    let mut through = RouteRequest::through(places);
    through.places.hints = false;
    through
        .places
        .snap
        .iter_mut()
        .for_each(|snap| snap.radius = args.radius);
    let request = Request::Route(RouteRequest {
        alternatives: args.alternatives,
        steps: args.steps,
        geometries: Geometries::GeoJson,
        overview: Overview::Full,
        ..through
    });
    let (body, outcome) = match service.body(&request, &mut ServiceMemory::default()) {
        Ok(body) => (body, Outcome::Done),
        Err(failure) => (failure.to_json(), Outcome::Problem),
    };
    say(&(String::from_utf8_lossy(&body) + "\n"))?;
    Ok(outcome)
}

/// A map and a profile that answer requests.
pub fn service(args: &RoadArgs, limits: Limits) -> anyhow::Result<Service> {
    let profile = Profile::open(&args.profile)?;
    let roads = roads(&args.map)?;
    let metric = doing("weighing them", || Metric::new(&roads, profile))?;
    Ok(Service {
        roads,
        metric,
        limits,
    })
}

/// The roads of a map or of a graph file.
pub fn roads(map: &Path) -> anyhow::Result<Roads> {
    if store::is_graph_file(map) {
        return Ok(store::read(map)?);
    }
    read_roads(map, &CellSizes::default())
}

/// The roads of a map in cells.
pub fn read_roads(map: &Path, sizes: &CellSizes) -> anyhow::Result<Roads> {
    let source = doing("opening the map", || Source::open(map))?;
    let network = doing("reading its roads", || Network::read(&source))
        .map_err(|error| error.in_file(map))?;
    // The network has what is needed: the map need not stay in memory while the cells are made.
    drop(source);
    Ok(doing("putting them into cells", || {
        Roads::new(network, sizes)
    }))
}
