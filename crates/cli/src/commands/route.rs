//! `openbench route`

use openbench_osm::{Projection, default_georeference};
use openbench_routing::{MapRouter, Profile, osrm};

use crate::args::RouteArgs;
use crate::commands::read_data;
use crate::outcome::{Outcome, say_json};

/// Prints a route.
pub fn run(args: &RouteArgs) -> anyhow::Result<Outcome> {
    let profile = Profile::open(&args.profile)?;
    let data = read_data(&args.map)?;
    let georeference =
        default_georeference(&data).map_err(|e| anyhow::anyhow!("{}: {e}", args.map.display()))?;
    let projection = Projection::new(georeference);
    let router = MapRouter::new(&data, projection.clone(), profile)?;
    let response = osrm::route(&router, &projection, &args.places);
    say_json(&response)?;
    Ok(if response.code == "Ok" { Outcome::Done } else { Outcome::Problem })
}
