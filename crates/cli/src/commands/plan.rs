//! `openbench plan`

use anyhow::Context;
use openbench_agents::open::Catalogue;
use openbench_core::{MapPoint, ModelUse, Plan, with_causes};
use openbench_language::PlanRequest;
use openbench_osm::{OsmMap, default_georeference};
use openbench_routing::{MapRouter, Profile, RouterTimes};

use crate::args::PlanArgs;
use crate::commands::{read_data, unbounded_models};
use crate::outcome::{Outcome, say_json};

/// A plan, and what was asked of models for it.
#[derive(serde::Serialize)]
struct Planned {
    #[serde(flatten)]
    plan: Plan,
    #[serde(skip_serializing_if = "Option::is_none")]
    models: Option<ModelUse>,
}

/// Prints what an instruction asks for.
pub fn run(args: &PlanArgs, parts: &Catalogue) -> anyhow::Result<Outcome> {
    let mut models = unbounded_models(&args.planner, &[&args.map], args.exchanges.as_deref())?;
    let planner = parts.planner(&args.planner, &mut models)?;
    let data = read_data(&args.map)?;
    let georeference =
        default_georeference(&data).with_context(|| args.map.display().to_string())?;
    let map = OsmMap::new(&data, georeference);
    let router = MapRouter::new(&data, map.projection.clone(), Profile::delivery())?;
    let times = RouterTimes {
        router: &router,
        off_road_speed: 0.5,
    };
    let request = PlanRequest {
        instruction: &args.instruction,
        map: &map,
        start: MapPoint::default(),
        times: &times,
    };
    let planned = planner.plan(&request);
    if let Err(error) = &planned {
        crate::outcome::tell(&format!("openbench: {}", with_causes(error)));
    }
    // After a failure stdout gets a plan as well. The problem is on stderr and in the exit code.
    let nothing = || Plan {
        planner: planner.name().to_owned(),
        deliveries: Vec::new(),
        fallbacks: Vec::new(),
    };
    let problem = planned.as_ref().map_or(true, |plan| {
        plan.deliveries.iter().any(|d| d.problem.is_some())
    });
    let models = Some(models.meter().spent()).filter(|used| used.calls > 0);
    say_json(&Planned {
        plan: planned.unwrap_or_else(|_| nothing()),
        models,
    })?;
    Ok(if problem {
        Outcome::Problem
    } else {
        Outcome::Done
    })
}
