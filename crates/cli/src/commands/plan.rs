//! `openbench plan`

use openbench_core::MapPoint;
use openbench_language::PlanRequest;
use openbench_osm::{OsmMap, default_georeference};
use openbench_routing::{MapRouter, Profile, RouterTimes};

use crate::args::PlanArgs;
use crate::commands::read_data;
use crate::open_parts::planner;
use crate::outcome::{Outcome, say_json};

/// Prints what an instruction asks for.
pub fn run(args: &PlanArgs) -> anyhow::Result<Outcome> {
    let planner = planner(&args.planner).map_err(anyhow::Error::msg)?;
    let data = read_data(&args.map)?;
    let georeference =
        default_georeference(&data).map_err(|e| anyhow::anyhow!("{}: {e}", args.map.display()))?;
    let map = OsmMap::new(&data, georeference);
    let router = MapRouter::new(&data, map.projection.clone(), Profile::delivery())?;
    let times = RouterTimes { router: &router, speed: 0.5 };
    let request =
        PlanRequest { instruction: &args.instruction, map: &map, start: MapPoint::default(), times: &times };
    let plan = match planner.plan(&request) {
        Ok(plan) => plan,
        Err(error) => {
            crate::outcome::tell(&format!("openbench: {error}"));
            say_json(&openbench_core::Plan {
                planner: planner.name().to_owned(),
                deliveries: Vec::new(),
                fallbacks: Vec::new(),
            })?;
            return Ok(Outcome::Problem);
        }
    };
    say_json(&plan)?;
    let problem = plan.deliveries.iter().any(|d| d.problem.is_some());
    Ok(if problem { Outcome::Problem } else { Outcome::Done })
}
