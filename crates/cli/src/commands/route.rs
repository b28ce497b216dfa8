//! `openbench route`

use openbench_routing::{Dijkstra, Profile, RoadGraph, osrm};

use crate::args::RouteArgs;
use crate::commands::read_map;
use crate::outcome::{Outcome, say_json};

/// Prints a route.
pub fn run(args: &RouteArgs) -> anyhow::Result<Outcome> {
    let profile = Profile::named(&args.profile).ok_or_else(|| {
        anyhow::anyhow!("there is no profile `{}`; there are {}", args.profile, Profile::NAMES.join(", "))
    })?;
    let map = read_map(&args.map)?;
    let router = Dijkstra::new(RoadGraph::new(&map, profile));
    let response = osrm::route(&router, &map.projection, &args.places);
    say_json(&response)?;
    Ok(if response.code == "Ok" { Outcome::Done } else { Outcome::Problem })
}
